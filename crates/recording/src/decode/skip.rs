//! How far it is from one field to a later one.
//!
//! In CDR a value of n bytes begins at a multiple of min(n, 8) from the beginning of the message, so
//! what a type occupies depends on where it begins, but only on that place modulo 8. A type of
//! fixed layout is therefore a table of eight lengths; tables of neighbours are added up when the
//! plan is made, and passing over any number of fixed fields costs one look-up. Texts and sequences
//! are walked.
//!
//! Source: OMG DDS-XTypes 1.3, section 7.4 (plain CDR and CDR2); ROS 1 wiki, "msg" (packed).

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::schema::{MessageType, Primitive, Type};

/// A layout of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Layout {
    /// ROS 1 and columns: packed.
    Packed,
    /// CDR, first version: aligned to at most 8.
    Cdr1,
    /// CDR, second version: aligned to at most 4; arrays of anything but numbers have a length.
    Cdr2,
}

impl Layout {
    pub(crate) fn alignment(self, primitive: Primitive) -> usize {
        let most = match self {
            Layout::Packed => 1,
            Layout::Cdr1 => 8,
            Layout::Cdr2 => 4,
        };
        primitive.bytes().min(most)
    }

    /// Whether an array of such elements has its length in bytes before it.
    pub(crate) fn is_delimited(self, element: &Type) -> bool {
        self == Layout::Cdr2 && !matches!(innermost(element), Type::Primitive(_))
    }

    /// Whether values of this type can be read: not those of wide text, whose bytes differ between
    /// implementations, nor tables of anything but numbers in the second version of CDR.
    pub(crate) fn reads(self, kind: &Type) -> bool {
        match kind {
            Type::WideText => false,
            Type::Array(element, _) if matches!(**element, Type::Array(..)) => {
                !self.is_delimited(element)
            }
            _ => true,
        }
    }
}

/// The elements of a table of tables.
fn innermost(kind: &Type) -> &Type {
    match kind {
        Type::Array(element, _) => innermost(element),
        _ => kind,
    }
}

/// Lengths in bytes, padding included, by the beginning modulo 8.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Table([u64; 8]);

impl Table {
    pub(crate) const EMPTY: Table = Table([0; 8]);

    pub(crate) fn primitive(primitive: Primitive, layout: Layout) -> Table {
        let alignment = layout.alignment(primitive);
        let mut lengths = [0; 8];
        for (begin, length) in lengths.iter_mut().enumerate() {
            *length = (begin.next_multiple_of(alignment) - begin + primitive.bytes()) as u64;
        }
        Table(lengths)
    }

    /// The length of something that begins at `at`.
    #[inline]
    pub(crate) fn length(&self, at: usize) -> u64 {
        self.0[at & 7]
    }

    /// This, then `next`. Lengths beyond all messages stay beyond them.
    pub(crate) fn then(&self, next: &Table) -> Table {
        let mut lengths = self.0;
        for (begin, length) in lengths.iter_mut().enumerate() {
            let end = (begin as u64).saturating_add(*length) as usize;
            *length = length.saturating_add(next.length(end));
        }
        Table(lengths)
    }

    /// This, `count` times.
    pub(crate) fn times(&self, mut count: u64) -> Table {
        let (mut result, mut power) = (Table::EMPTY, *self);
        while count > 0 {
            if count & 1 == 1 {
                result = result.then(&power);
            }
            power = power.then(&power);
            count >>= 1;
        }
        result
    }

    /// The alignment and size of elements that stand one after another without gaps, if the table
    /// is that of such elements.
    fn stride(&self) -> Option<Stride> {
        [1_usize, 2, 4, 8].into_iter().find_map(|alignment| {
            let size = self.0[0];
            let fits = |begin: usize| {
                let padding = (begin.next_multiple_of(alignment) - begin) as u64;
                self.0[begin] == size.saturating_add(padding)
            };
            let fits = size.is_multiple_of(alignment as u64) && (0..8).all(fits);
            fits.then_some(Stride { alignment, size })
        })
    }
}

/// Elements of `size` bytes, the first of which begins at a multiple of `alignment`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stride {
    pub(crate) alignment: usize,
    pub(crate) size: u64,
}

/// How to pass over the elements of an array.
#[derive(Debug, Clone)]
pub(crate) struct Items {
    /// How many, if the type says it.
    pub(crate) count: Option<u64>,
    pub(crate) element: Skip,
    /// Set if elements have a fixed layout without gaps.
    pub(crate) stride: Option<Stride>,
    /// Whether the length in bytes stands before them.
    pub(crate) is_delimited: bool,
}

/// How to pass over a value.
#[derive(Debug, Clone)]
pub(crate) enum Skip {
    Fixed(Table),
    Text,
    /// It cannot be passed over ([`Layout::reads`]).
    Unreadable,
    Items(Arc<Items>),
    /// One after another.
    Parts(Arc<[Skip]>),
}

/// Makes [`Skip`]s, each type once.
pub(crate) struct Skips {
    layout: Layout,
    known: BTreeMap<*const MessageType, Skip>,
}

impl Skips {
    pub(crate) fn new(layout: Layout) -> Self {
        Skips {
            layout,
            known: BTreeMap::new(),
        }
    }

    pub(crate) fn of(&mut self, kind: &Type) -> Skip {
        if !self.layout.reads(kind) {
            return Skip::Unreadable;
        }
        match kind {
            Type::WideText => Skip::Unreadable,
            Type::Primitive(primitive) => Skip::Fixed(Table::primitive(*primitive, self.layout)),
            Type::Text => Skip::Text,
            Type::Struct(message) => {
                let key = Arc::as_ptr(message);
                if let Some(known) = self.known.get(&key) {
                    return known.clone();
                }
                let parts: Vec<Skip> = message.fields.iter().map(|f| self.of(&f.kind)).collect();
                let made = joined(parts);
                self.known.insert(key, made.clone());
                made
            }
            Type::Array(element, count) => {
                let items = self.items(element, Some(*count));
                match &items.element {
                    Skip::Fixed(table) => Skip::Fixed(self.fixed(table.times(*count), &items)),
                    _ => Skip::Items(Arc::new(items)),
                }
            }
            Type::Sequence(element) => Skip::Items(Arc::new(self.items(element, None))),
        }
    }

    fn fixed(&self, elements: Table, items: &Items) -> Table {
        if items.is_delimited {
            Table::primitive(Primitive::Uint32, self.layout).then(&elements)
        } else {
            elements
        }
    }

    pub(crate) fn items(&mut self, element: &Type, count: Option<u64>) -> Items {
        let skip = self.of(element);
        let stride = match &skip {
            Skip::Fixed(table) => table.stride(),
            _ => None,
        };
        Items {
            count,
            element: skip,
            stride,
            is_delimited: self.layout.is_delimited(element),
        }
    }
}

/// Parts as one, with neighbours of fixed layout added up.
pub(crate) fn joined(parts: Vec<Skip>) -> Skip {
    let mut merged: Vec<Skip> = Vec::new();
    for part in parts {
        match (merged.last_mut(), part) {
            (Some(Skip::Fixed(before)), Skip::Fixed(table)) => *before = before.then(&table),
            (_, part) => merged.push(part),
        }
    }
    match merged.as_slice() {
        [] => Skip::Fixed(Table::EMPTY),
        [only] => only.clone(),
        _ => Skip::Parts(merged.into()),
    }
}

impl Skip {
    /// Whether a message can be read behind it.
    pub(crate) fn is_readable(&self) -> bool {
        match self {
            Skip::Fixed(_) | Skip::Text => true,
            Skip::Unreadable => false,
            Skip::Items(items) => items.element.is_readable(),
            Skip::Parts(parts) => parts.iter().all(Skip::is_readable),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_add_up_as_fields_one_by_one_do() {
        let kinds = [
            Primitive::Uint8,
            Primitive::Float64,
            Primitive::Int16,
            Primitive::Uint32,
            Primitive::Bool,
        ];
        for layout in [Layout::Packed, Layout::Cdr1, Layout::Cdr2] {
            let tables = kinds.map(|kind| Table::primitive(kind, layout));
            let all = tables.iter().fold(Table::EMPTY, |sum, t| sum.then(t));
            for begin in 0..8_usize {
                let mut at = begin;
                for _ in 0..37 {
                    for kind in kinds {
                        at = at.next_multiple_of(layout.alignment(kind)) + kind.bytes();
                    }
                }
                assert_eq!(begin as u64 + all.times(37).length(begin), at as u64);
            }
        }
    }
}
