//! The values of a column, and which of them are of which row.

use super::Damage;
use super::schema::Leaf;

/// Values of one type, one after the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ColumnValues {
    Bool(Vec<bool>),
    Int32(Vec<i64>),
    Int64(Vec<i64>),
    Float(Vec<f64>),
    Double(Vec<f64>),
    Bytes(Vec<Vec<u8>>),
}

impl ColumnValues {
    /// None yet, of a physical type by its number.
    pub(super) fn of_kind(kind: i64) -> Result<Self, Damage> {
        Ok(match kind {
            0 => Self::Bool(Vec::new()),
            1 => Self::Int32(Vec::new()),
            2 => Self::Int64(Vec::new()),
            4 => Self::Float(Vec::new()),
            5 => Self::Double(Vec::new()),
            6 => Self::Bytes(Vec::new()),
            3 => {
                return Err(Damage::unread(
                    "it holds numbers of 96 bits, which are not read",
                ));
            }
            7 => {
                return Err(Damage::unread(
                    "it holds bytes of a fixed length, which are not read",
                ));
            }
            other => return Err(Damage::new(format!("no type has the number {other}"))),
        })
    }

    pub(super) fn len(&self) -> usize {
        match self {
            Self::Bool(all) => all.len(),
            Self::Int32(all) | Self::Int64(all) => all.len(),
            Self::Float(all) | Self::Double(all) => all.len(),
            Self::Bytes(all) => all.len(),
        }
    }

    /// Adds values of a dictionary by their places.
    pub(super) fn extend_from(&mut self, dictionary: &Self, places: &[u32]) -> Result<(), Damage> {
        match (self, dictionary) {
            (Self::Bool(own), Self::Bool(all)) => picked(own, all, places),
            (Self::Int32(own), Self::Int32(all)) | (Self::Int64(own), Self::Int64(all)) => {
                picked(own, all, places)
            }
            (Self::Float(own), Self::Float(all)) | (Self::Double(own), Self::Double(all)) => {
                picked(own, all, places)
            }
            (Self::Bytes(own), Self::Bytes(all)) => picked(own, all, places),
            _ => Err(Damage::new(
                "the dictionary is of another type than its column",
            )),
        }
    }
}

fn picked<T: Clone>(own: &mut Vec<T>, all: &[T], places: &[u32]) -> Result<(), Damage> {
    for place in places {
        let value = all.get(*place as usize).ok_or_else(|| {
            Damage::new(format!(
                "place {place} of a dictionary of {} values is asked for",
                all.len()
            ))
        })?;
        own.push(value.clone());
    }
    Ok(())
}

/// A column in all rows: a value each, none where it is missing, or a list.
#[derive(Debug, Clone, PartialEq)]
pub struct ParquetRows {
    pub(super) values: ColumnValues,
    /// Where the values of each row end.
    ends: Vec<usize>,
    is_list: bool,
}

impl ParquetRows {
    pub(super) fn of(values: ColumnValues) -> Self {
        Self {
            values,
            ends: Vec::new(),
            is_list: false,
        }
    }

    /// The number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Adds the rows of a page, whose values have been added from `at` on.
    pub(super) fn add_rows(
        &mut self,
        mut at: usize,
        repeated: &[u32],
        defined: &[u32],
        leaf: &Leaf,
    ) -> Result<(), Damage> {
        self.is_list |= leaf.repeated > 0;
        for (repeated, defined) in repeated.iter().zip(defined) {
            if *repeated == 0 {
                self.ends.push(at);
            } else if self.ends.is_empty() {
                return Err(Damage::new("a list goes on before it begins"));
            }
            at += usize::from(*defined == u32::from(leaf.defined));
            if let Some(end) = self.ends.last_mut() {
                *end = at;
            }
        }
        match at == self.values.len() {
            true => Ok(()),
            false => Err(Damage::new("a page has other values than its levels say")),
        }
    }

    /// Where the values of each row stand.
    fn spans(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, end)| start..*end)
    }

    fn single<T: Clone>(&self, all: &[T]) -> Option<Vec<Option<T>>> {
        let one = |span: std::ops::Range<usize>| all[span].first().cloned();
        (!self.is_list).then(|| self.spans().map(one).collect())
    }

    /// A truth value in each row, if that is what the column holds.
    #[must_use]
    pub fn bools(&self) -> Option<Vec<Option<bool>>> {
        match &self.values {
            ColumnValues::Bool(all) => self.single(all),
            _ => None,
        }
    }

    /// A whole number in each row, if that is what the column holds. Those of 64 bits without a sign wrap from 2^63 on.
    #[must_use]
    pub fn ints(&self) -> Option<Vec<Option<i64>>> {
        match &self.values {
            ColumnValues::Int32(all) | ColumnValues::Int64(all) => self.single(all),
            _ => None,
        }
    }

    /// A number in each row, if that is what the column holds, of single or double precision.
    #[must_use]
    pub fn doubles(&self) -> Option<Vec<Option<f64>>> {
        match &self.values {
            ColumnValues::Float(all) | ColumnValues::Double(all) => self.single(all),
            _ => None,
        }
    }

    /// The texts of each row, be it one or a list, if the column holds texts in UTF-8.
    #[must_use]
    pub fn texts(&self) -> Option<Vec<Vec<&str>>> {
        let ColumnValues::Bytes(all) = &self.values else {
            return None;
        };
        let texts: Vec<&str> = all
            .iter()
            .map(|it| std::str::from_utf8(it).ok())
            .collect::<Option<_>>()?;
        Some(self.spans().map(|span| texts[span].to_vec()).collect())
    }

    /// The numbers of each row, be it one or a list: whole ones, others, and truth values as 0 and 1. `None` of texts.
    #[must_use]
    pub fn numbers(&self) -> Option<Vec<Vec<f64>>> {
        let all: Vec<f64> = match &self.values {
            ColumnValues::Bool(all) => all.iter().map(|it| f64::from(u8::from(*it))).collect(),
            ColumnValues::Int32(all) | ColumnValues::Int64(all) => {
                all.iter().map(|it| *it as f64).collect()
            }
            ColumnValues::Float(all) | ColumnValues::Double(all) => all.clone(),
            ColumnValues::Bytes(_) => return None,
        };
        Some(self.spans().map(|span| all[span].to_vec()).collect())
    }
}
