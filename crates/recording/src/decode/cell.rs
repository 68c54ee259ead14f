//! What is found at the places that were asked for, before it becomes numbers.

/// What stands at one place of a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// A number. Whole numbers of 64 bits beyond 2^53 are the nearest double.
    Number(f64),
    /// A text; bytes that are not UTF-8 are replaced.
    Text(String),
    /// A truth value.
    Bool(bool),
    /// Nothing: a field that is absent, an index beyond the end, no element with that key.
    Missing,
}

/// A value without its text, which stands in [`Cells::texts`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Cell {
    Missing,
    Number(f64),
    Bool(bool),
    Text { start: usize, end: usize },
}

/// The values of one message: first those that were asked for, then those needed for comparisons.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cells {
    pub(crate) cells: Vec<Cell>,
    pub(crate) texts: Vec<u8>,
    /// Places found in arrays that stand beside others.
    pub(crate) places: Vec<Option<u64>>,
    /// Where fields begin that are read later.
    pub(crate) marks: Vec<usize>,
}

impl Cells {
    pub(crate) fn reset(&mut self) {
        self.cells.fill(Cell::Missing);
        self.texts.clear();
        self.places.fill(None);
    }

    pub(crate) fn set(&mut self, slots: &[usize], cell: Cell) {
        for &slot in slots {
            self.cells[slot] = cell;
        }
    }

    pub(crate) fn set_text(&mut self, slots: &[usize], text: &[u8]) {
        let start = self.texts.len();
        self.texts.extend_from_slice(text);
        let end = self.texts.len();
        self.set(slots, Cell::Text { start, end });
    }

    pub(crate) fn text(&self, slot: usize) -> Option<&[u8]> {
        match self.cells[slot] {
            Cell::Text { start, end } => self.texts.get(start..end),
            _ => None,
        }
    }

    pub(crate) fn value(&self, slot: usize) -> Value {
        match self.cells[slot] {
            Cell::Missing => Value::Missing,
            Cell::Number(number) => Value::Number(number),
            Cell::Bool(truth) => Value::Bool(truth),
            Cell::Text { start, end } => {
                Value::Text(String::from_utf8_lossy(&self.texts[start..end]).into_owned())
            }
        }
    }
}
