//! Carries a [`Plan`](super::plan::Plan) out on the bytes of a message.
//!
//! Costs: passing over fields of fixed layout is one look-up however many they are; texts and
//! sequences cost one step each, sequences of fixed elements one in all. Every position is checked
//! against the message, so no length in it is believed.

use super::DecodeError;
use super::cell::{Cell, Cells};
use super::path::Key;
use super::plan::{ItemsPlan, Node, Pick, PlanStep, StructPlan, Where};
use super::skip::{Items, Layout, Skip};
use crate::schema::Primitive;

const CUT: &str = "the message ends too early";

/// The bytes of a message, without the header that tells how they are encoded.
pub(crate) struct Walker<'d, const BIG_ENDIAN: bool> {
    pub(crate) data: &'d [u8],
    /// What stands before `data` in the message, in bytes.
    pub(crate) header_bytes: usize,
    pub(crate) layout: Layout,
}

type Walked<T> = Result<T, DecodeError>;

impl<const BIG_ENDIAN: bool> Walker<'_, BIG_ENDIAN> {
    fn error<T>(&self, at: usize, message: &'static str) -> Walked<T> {
        Err(DecodeError {
            offset_in_message: self.header_bytes + at.min(self.data.len()),
            message: message.into(),
        })
    }

    fn bytes<const N: usize>(&self, at: usize) -> Walked<[u8; N]> {
        match self.data.get(at..).and_then(|rest| rest.first_chunk::<N>()) {
            Some(bytes) => Ok(*bytes),
            None => self.error(at, CUT),
        }
    }

    /// The position `by` bytes further on.
    fn forward(&self, at: usize, by: u64) -> Walked<usize> {
        let left = (self.data.len() as u64).saturating_sub(at as u64);
        if by > left {
            return self.error(at, CUT);
        }
        Ok(at + by as usize)
    }

    fn aligned(&self, at: usize, primitive: Primitive) -> usize {
        at.next_multiple_of(self.layout.alignment(primitive))
    }

    /// Reads a length, and gives the position behind it.
    fn length(&self, at: usize) -> Walked<(u64, usize)> {
        let at = self.aligned(at, Primitive::Uint32);
        let bytes = self.bytes::<4>(at)?;
        let length = if BIG_ENDIAN {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        };
        Ok((u64::from(length), at + 4))
    }

    fn number(&self, at: usize, primitive: Primitive) -> Walked<(Cell, usize)> {
        macro_rules! number {
            ($kind:ty, $at:expr) => {{
                let bytes = self.bytes::<{ size_of::<$kind>() }>($at)?;
                Cell::Number(if BIG_ENDIAN {
                    <$kind>::from_be_bytes(bytes) as f64
                } else {
                    <$kind>::from_le_bytes(bytes) as f64
                })
            }};
        }
        let at = self.aligned(at, primitive);
        let cell = match primitive {
            Primitive::Bool => match self.bytes::<1>(at)? {
                [0] => Cell::Bool(false),
                [1] => Cell::Bool(true),
                _ => return self.error(at, "a truth value is neither 0 nor 1"),
            },
            Primitive::Int8 => number!(i8, at),
            Primitive::Uint8 => number!(u8, at),
            Primitive::Int16 => number!(i16, at),
            Primitive::Uint16 => number!(u16, at),
            Primitive::Int32 => number!(i32, at),
            Primitive::Uint32 => number!(u32, at),
            Primitive::Int64 => number!(i64, at),
            Primitive::Uint64 => number!(u64, at),
            Primitive::Float32 => number!(f32, at),
            Primitive::Float64 => number!(f64, at),
        };
        Ok((cell, at + primitive.bytes()))
    }

    fn text(&self, at: usize) -> Walked<(&[u8], usize)> {
        let (length, at) = self.length(at)?;
        let end = self.forward(at, length)?;
        let text = &self.data[at..end];
        let text = match (self.layout, text.split_last()) {
            // CDR counts and writes the zero at the end.
            (Layout::Cdr1 | Layout::Cdr2, Some((0, text))) => text,
            _ => text,
        };
        Ok((text, end))
    }

    pub(crate) fn skip(&self, skip: &Skip, at: usize) -> Walked<usize> {
        match skip {
            Skip::Fixed(table) => self.forward(at, table.length(at)),
            Skip::Text => {
                let (length, at) = self.length(at)?;
                self.forward(at, length)
            }
            Skip::Unreadable => self.error(at, "wide text is not supported"),
            Skip::Items(items) => {
                let (count, at) = self.begin(items, at)?;
                self.advance(items, at, count)
            }
            Skip::Parts(parts) => parts.iter().try_fold(at, |at, part| self.skip(part, at)),
        }
    }

    /// The number of elements, and where they begin.
    fn begin(&self, items: &Items, mut at: usize) -> Walked<(u64, usize)> {
        if items.is_delimited {
            (_, at) = self.length(at)?;
        }
        match items.count {
            Some(count) => Ok((count, at)),
            None => self.length(at),
        }
    }

    /// The position behind `count` elements that begin at `at`.
    fn advance(&self, items: &Items, at: usize, count: u64) -> Walked<usize> {
        if let Some(stride) = items.stride {
            if count == 0 {
                return Ok(at);
            }
            let begin = at.next_multiple_of(stride.alignment);
            let by = stride.size.saturating_mul(count);
            return self.forward(begin, by);
        }
        // Elements without a stride have at least one byte each, so this ends with the message.
        (0..count).try_fold(at, |at, _| self.skip(&items.element, at))
    }

    pub(crate) fn structure(
        &self,
        plan: &StructPlan,
        mut at: usize,
        cells: &mut Cells,
        needs_end: bool,
    ) -> Walked<usize> {
        let last = plan.steps.len().saturating_sub(1);
        for (index, step) in plan.steps.iter().enumerate() {
            match step {
                PlanStep::Skip(skip) => {
                    if needs_end || index < last {
                        at = self.skip(skip, at)?;
                    }
                }
                PlanStep::Mark(mark) => cells.marks[*mark] = at,
                PlanStep::Visit(node) => {
                    at = self.node(node, at, cells, needs_end || index < last)?;
                }
            }
        }
        if needs_end {
            at = self.skip(&plan.rest, at)?;
        }
        for (mark, node) in &plan.deferred {
            self.node(node, cells.marks[*mark], cells, false)?;
        }
        Ok(at)
    }

    /// Reads what is wanted of a value, and gives the position behind it if that is needed.
    fn node(&self, node: &Node, at: usize, cells: &mut Cells, needs_end: bool) -> Walked<usize> {
        match node {
            Node::Number(primitive, slots) => {
                let (cell, at) = self.number(at, *primitive)?;
                cells.set(slots, cell);
                Ok(at)
            }
            Node::Text(slots) => {
                let (text, at) = self.text(at)?;
                cells.set_text(slots, text);
                Ok(at)
            }
            Node::Struct(plan) => self.structure(plan, at, cells, needs_end),
            Node::Items(plan) => self.items(plan, at, cells, needs_end),
        }
    }

    fn items(
        &self,
        plan: &ItemsPlan,
        at: usize,
        cells: &mut Cells,
        needs_end: bool,
    ) -> Walked<usize> {
        let (count, begin) = self.begin(&plan.items, at)?;
        cells.set(&plan.lengths, Cell::Number(count as f64));
        for (pick, node) in &plan.picks {
            let index = match pick {
                Pick::Index(index) => Some(*index),
                Pick::Place(place) => cells.places[*place],
            };
            if let Some(index) = index.filter(|index| *index < count) {
                let at = self.advance(&plan.items, begin, index)?;
                self.node(node, at, cells, false)?;
            }
        }
        if !plan.finds.is_empty() || !plan.wheres.is_empty() {
            self.search(plan, begin, count, cells)?;
        }
        if needs_end {
            self.advance(&plan.items, begin, count)
        } else {
            Ok(begin)
        }
    }

    /// Goes through the elements until all that is looked for is found.
    fn search(&self, plan: &ItemsPlan, begin: usize, count: u64, cells: &mut Cells) -> Walked<()> {
        let mut is_found = vec![false; plan.wheres.len()];
        let mut at = begin;
        for index in 0..count {
            let mut is_open = false;
            for find in &plan.finds {
                if cells.places[find.place].is_none() {
                    let kept = cells.texts.len();
                    self.node(&find.node, at, cells, false)?;
                    let found = cells.matches(find.slot, &find.key);
                    cells.texts.truncate(kept);
                    if found {
                        cells.places[find.place] = Some(index);
                    }
                    is_open |= !found;
                }
            }
            for (wanted, is_found) in plan.wheres.iter().zip(&mut is_found) {
                if !*is_found {
                    *is_found = self.element_matches(wanted, at, cells)?;
                    if *is_found {
                        self.node(&wanted.then, at, cells, false)?;
                    }
                    is_open |= !*is_found;
                }
            }
            if !is_open {
                break;
            }
            at = self.advance(&plan.items, at, 1)?;
            // Elements of no size would otherwise be counted as often as the message claims.
            if at == begin && index > 0 {
                break;
            }
        }
        Ok(())
    }

    fn element_matches(&self, wanted: &Where, at: usize, cells: &mut Cells) -> Walked<bool> {
        let kept = cells.texts.len();
        for (slot, _) in &wanted.tests {
            cells.cells[*slot] = Cell::Missing;
        }
        self.node(&wanted.keys, at, cells, false)?;
        let mut tests = wanted.tests.iter();
        let found = tests.all(|(slot, key)| cells.matches(*slot, key));
        cells.texts.truncate(kept);
        Ok(found)
    }
}

impl Cells {
    /// Whether a slot holds what a key says.
    pub(crate) fn matches(&self, slot: usize, key: &Key) -> bool {
        match (self.cells[slot], key) {
            (Cell::Text { start, end }, Key::Text(text)) => {
                &self.texts[start..end] == text.as_bytes()
            }
            (Cell::Number(number), Key::Number(wanted)) => number == *wanted,
            (Cell::Bool(truth), Key::Text(text)) => (if truth { "true" } else { "false" }) == text,
            (Cell::Bool(truth), Key::Number(wanted)) => f64::from(u8::from(truth)) == *wanted,
            _ => false,
        }
    }
}
