//! Places in JSON messages.
//!
//! Without conditions in the paths, a message is gone through once and nothing is built of what is
//! not asked for. With conditions, whose keys may stand behind what they choose, the message is
//! first read as a whole. Of a name that stands twice in an object the last one counts, as in most
//! readers. Texts `NaN`, `Infinity` and `-Infinity`, by which protocol buffers and others write
//! numbers that JSON has not, are those numbers.

use std::borrow::Cow;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::Value as Json;

use super::DecodeError;
use super::cell::{Cell, Cells};
use super::path::{Condition, FieldPath, Key, PathError, Step};

/// What to read of JSON messages.
#[derive(Debug, Clone)]
pub(crate) struct JsonPlan {
    paths: Vec<FieldPath>,
    tree: Tree,
    has_conditions: bool,
    pub(crate) slots: usize,
}

/// Paths by their first steps.
#[derive(Debug, Clone, Default)]
struct Tree {
    slots: Vec<usize>,
    lengths: Vec<usize>,
    fields: Vec<(String, Tree)>,
    elements: Vec<(u64, Tree)>,
}

impl JsonPlan {
    pub(crate) fn new(paths: &[FieldPath]) -> Result<Self, PathError> {
        let mut tree = Tree::default();
        let mut has_conditions = false;
        for (slot, path) in paths.iter().enumerate() {
            let is_condition = |step: &Step| matches!(step, Step::Where(_));
            if path.steps.iter().any(is_condition) {
                has_conditions = true;
            } else {
                tree.add(&path.steps, slot, path.is_length);
            }
        }
        Ok(JsonPlan {
            slots: paths.len(),
            paths: paths.to_vec(),
            tree,
            has_conditions,
        })
    }

    pub(crate) fn read(&self, data: &[u8], cells: &mut Cells) -> Result<(), DecodeError> {
        let error = |error: serde_json::Error| DecodeError {
            offset_in_message: offset(data, &error),
            message: format!("it is not JSON ({error})").into(),
        };
        if self.has_conditions {
            let whole: Json = serde_json::from_slice(data).map_err(error)?;
            for (slot, path) in self.paths.iter().enumerate() {
                if let Some(found) = follow(&whole, &path.steps) {
                    take(found, slot, path.is_length, cells);
                }
            }
            return Ok(());
        }
        let mut deserializer = serde_json::Deserializer::from_slice(data);
        let part = Part {
            tree: &self.tree,
            cells,
        };
        part.deserialize(&mut deserializer).map_err(error)?;
        deserializer.end().map_err(error)
    }
}

/// The place of an error that names line and column.
fn offset(data: &[u8], error: &serde_json::Error) -> usize {
    let lines = data.split_inclusive(|byte| *byte == b'\n');
    let before: usize = lines
        .take(error.line().saturating_sub(1))
        .map(<[u8]>::len)
        .sum();
    (before + error.column().saturating_sub(1)).min(data.len())
}

impl Tree {
    fn add(&mut self, steps: &[Step], slot: usize, is_length: bool) {
        match steps.split_first() {
            None if is_length => self.lengths.push(slot),
            None => self.slots.push(slot),
            Some((Step::Field(name), rest)) => {
                child(&mut self.fields, name.clone()).add(rest, slot, is_length);
            }
            Some((Step::Index(index), rest)) => {
                child(&mut self.elements, *index).add(rest, slot, is_length);
            }
            Some((Step::Where(_), _)) => {}
        }
    }

    /// Forgets what an earlier entry of the same name gave.
    fn clear(&self, cells: &mut Cells) {
        cells.set(&self.slots, Cell::Missing);
        cells.set(&self.lengths, Cell::Missing);
        self.fields.iter().for_each(|(_, tree)| tree.clear(cells));
        self.elements.iter().for_each(|(_, tree)| tree.clear(cells));
    }
}

fn child<K: PartialEq>(children: &mut Vec<(K, Tree)>, key: K) -> &mut Tree {
    let position = children.iter().position(|(known, _)| *known == key);
    let position = position.unwrap_or_else(|| {
        children.push((key, Tree::default()));
        children.len() - 1
    });
    &mut children[position].1
}

struct Part<'a> {
    tree: &'a Tree,
    cells: &'a mut Cells,
}

impl<'de> DeserializeSeed<'de> for Part<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Part<'_> {
    type Value = ();

    fn expecting(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("a value")
    }

    fn visit_unit<E>(self) -> Result<(), E> {
        Ok(())
    }

    fn visit_bool<E>(self, value: bool) -> Result<(), E> {
        self.cells.set(&self.tree.slots, Cell::Bool(value));
        Ok(())
    }

    fn visit_f64<E>(self, value: f64) -> Result<(), E> {
        self.cells.set(&self.tree.slots, Cell::Number(value));
        Ok(())
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<(), E> {
        self.visit_f64(value as f64)
    }

    fn visit_str<E>(self, value: &str) -> Result<(), E> {
        set_text(&self.tree.slots, value, self.cells);
        Ok(())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut sequence: A) -> Result<(), A::Error> {
        let mut count = 0_u64;
        loop {
            let wanted = self.tree.elements.iter().find(|(index, _)| *index == count);
            let more = match wanted {
                Some((_, tree)) => {
                    let cells = &mut *self.cells;
                    sequence.next_element_seed(Part { tree, cells })?.is_some()
                }
                None => sequence.next_element::<IgnoredAny>()?.is_some(),
            };
            if !more {
                break;
            }
            count += 1;
        }
        self.cells
            .set(&self.tree.lengths, Cell::Number(count as f64));
        Ok(())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(name) = map.next_key::<Cow<'de, str>>()? {
            match self.tree.fields.iter().find(|(known, _)| *known == name) {
                Some((_, tree)) => {
                    tree.clear(self.cells);
                    let cells = &mut *self.cells;
                    map.next_value_seed(Part { tree, cells })?;
                }
                None => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        Ok(())
    }
}

fn set_text(slots: &[usize], text: &str, cells: &mut Cells) {
    let number = match text {
        "NaN" => f64::NAN,
        "Infinity" => f64::INFINITY,
        "-Infinity" => f64::NEG_INFINITY,
        _ => return cells.set_text(slots, text.as_bytes()),
    };
    cells.set(slots, Cell::Number(number));
}

fn take(found: &Json, slot: usize, is_length: bool, cells: &mut Cells) {
    match found {
        Json::Array(elements) if is_length => {
            cells.set(&[slot], Cell::Number(elements.len() as f64));
        }
        _ if is_length => {}
        Json::Bool(truth) => cells.set(&[slot], Cell::Bool(*truth)),
        Json::Number(number) => {
            let cell = number.as_f64().map_or(Cell::Missing, Cell::Number);
            cells.set(&[slot], cell);
        }
        Json::String(text) => set_text(&[slot], text, cells),
        Json::Null | Json::Array(_) | Json::Object(_) => {}
    }
}

/// The value at the end of the steps.
fn follow<'j>(mut value: &'j Json, steps: &[Step]) -> Option<&'j Json> {
    let mut around = value;
    for step in steps {
        let next = match step {
            Step::Field(name) => value.get(name)?,
            Step::Index(index) => value.get(usize::try_from(*index).ok()?)?,
            Step::Where(conditions) => choose(value.as_array()?, around, conditions)?,
        };
        (around, value) = (value, next);
    }
    Some(value)
}

/// The first element for which all conditions hold; elements that are not objects are chosen by
/// the array of that name in the object around them.
fn choose<'j>(elements: &'j [Json], around: &Json, conditions: &[Condition]) -> Option<&'j Json> {
    if elements.iter().any(Json::is_object) {
        let fits = |element: &&Json| conditions.iter().all(|c| equals(at(element, c), &c.key));
        return elements.iter().find(fits);
    }
    let [condition] = conditions else { return None };
    let keys = at(around, condition)?.as_array()?;
    let place = keys
        .iter()
        .position(|key| equals(Some(key), &condition.key));
    elements.get(place?)
}

fn at<'j>(value: &'j Json, condition: &Condition) -> Option<&'j Json> {
    let mut names = condition.names.iter();
    names.try_fold(value, |value, name| value.get(name))
}

fn equals(found: Option<&Json>, key: &Key) -> bool {
    match (found, key) {
        (Some(Json::String(text)), Key::Text(wanted)) => text == wanted,
        (Some(Json::Number(number)), Key::Number(wanted)) => number.as_f64() == Some(*wanted),
        (Some(Json::Bool(truth)), Key::Text(wanted)) => {
            (if *truth { "true" } else { "false" }) == wanted
        }
        _ => false,
    }
}
