//! Tables of episodes that were not run as a campaign (`explore`, `rare`, `calibrate`), in Parquet: one row each.
//!
//! Columns come as they are met: an exploration sets other keys in each test. A value that an episode does not have is
//! missing in its row. The same rows give the same bytes.

use diagnostic::Problem;
use host::files::write_whole;
use recording::{Cell, ParquetColumn, ParquetError, ParquetType, ParquetWriter};
use rig::unit_of;
use std::collections::BTreeMap;
use std::path::Path;
use stimulus::{Parameter, Setting};

/// The table's name, in the folder of what was run.
pub const FILE: &str = "episodes.parquet";

/// A value that a row owns.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A truth value.
    Bool(bool),
    /// A whole number.
    U64(u64),
    /// A number.
    Double(f64),
    /// A text.
    Text(String),
}

impl Value {
    fn kind(&self) -> ParquetType {
        match self {
            Self::Bool(_) => ParquetType::Bool,
            Self::U64(_) => ParquetType::U64,
            Self::Double(_) => ParquetType::Double,
            Self::Text(_) => ParquetType::Text,
        }
    }

    fn cell(&self) -> Cell<'_> {
        match self {
            Self::Bool(value) => Cell::Bool(*value),
            Self::U64(value) => Cell::U64(*value),
            Self::Double(value) => Cell::Double(*value),
            Self::Text(value) => Cell::Text(value),
        }
    }
}

impl From<&Setting> for Value {
    fn from(setting: &Setting) -> Self {
        match setting {
            Setting::Bool(value) => Self::Bool(*value),
            Setting::Number(value) => Self::Double(*value),
            Setting::Text(value) => Self::Text(value.clone()),
        }
    }
}

/// A table that is put together row by row.
#[derive(Debug, Default)]
pub struct Rows {
    columns: Vec<ParquetColumn>,
    places: BTreeMap<String, usize>,
    rows: Vec<BTreeMap<usize, Value>>,
}

impl Rows {
    /// Begins a row.
    pub fn begin(&mut self) {
        self.rows.push(BTreeMap::new());
    }

    /// Sets a value of the last row. A column is what its first value is; of another kind it is another column.
    pub fn set(&mut self, column: ParquetColumn, value: Value) {
        let kind = value.kind();
        let column = ParquetColumn { kind, ..column }.optional();
        let known = self.places.get(&column.name).copied();
        let place = match known.filter(|place| self.columns[*place].kind == kind) {
            Some(place) => place,
            None => {
                let name = match known {
                    Some(_) => format!("{} ({kind:?})", column.name).to_lowercase(),
                    None => column.name.clone(),
                };
                let next = self.columns.len();
                let place = *self.places.entry(name.clone()).or_insert(next);
                if place == next {
                    self.columns.push(ParquetColumn { name, ..column });
                }
                place
            }
        };
        if let Some(row) = self.rows.last_mut() {
            row.insert(place, value);
        }
    }

    /// The same for a column without unit.
    pub fn plain(&mut self, name: &str, meaning: &str, value: Value) {
        self.set(
            ParquetColumn::new(name, value.kind()).meaning(meaning),
            value,
        );
    }

    /// A key of the bench that was set (`set`) or drawn from the seed (`drawn`).
    pub fn key(&mut self, how: &str, key: &str, value: Value) {
        self.set(column_of_key(how, key), value);
    }

    /// A declared parameter, with its unit in the name: readers of tables see no more.
    pub fn parameter(&mut self, parameter: &Parameter, value: f64) {
        let unit = parameter.unit.as_deref();
        let of_unit = unit.map_or(String::new(), |unit| format!(" [{unit}]"));
        let name = format!("parameter.{}{of_unit}", parameter.name);
        let column = ParquetColumn::new(name, ParquetType::Double)
            .meaning(format!("sets {}", parameter.sets.join(", ")));
        let column = match unit {
            Some(unit) => column.in_unit(unit),
            None => column,
        };
        self.set(column, Value::Double(value));
    }

    /// Writes the table, whole or not at all; a table without rows is not written.
    pub fn write(&self, path: &Path, about: &[(&str, &str)]) -> Result<(), Problem> {
        if self.rows.is_empty() {
            return Ok(());
        }
        let unwritten = |error: ParquetError| {
            Problem::data_lost("cannot-write", format!("{}: {error}", path.display()))
        };
        let mut table =
            ParquetWriter::new(Vec::new(), self.columns.clone(), about).map_err(unwritten)?;
        for row in &self.rows {
            let cell = |place| row.get(&place).map_or(Cell::Missing, Value::cell);
            let cells: Vec<Cell<'_>> = (0..self.columns.len()).map(cell).collect();
            table.push(&cells).map_err(unwritten)?;
        }
        write_whole(path, &table.finish().map_err(unwritten)?)
    }
}

/// The column of a number of the bench's data, in the unit that its name ends in.
pub fn column_of_key(how: &str, key: &str) -> ParquetColumn {
    let column = ParquetColumn::new(format!("{how}.{key}"), ParquetType::Double);
    match unit_of(key) {
        Some(unit) => column.in_unit(unit),
        None => column,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_come_as_they_are_met_and_have_their_units() {
        let mut rows = Rows::default();
        rows.begin();
        rows.plain("episode", "its number", Value::U64(1));
        rows.key("set", "object.mass_kg", Value::Double(0.1));
        rows.begin();
        rows.plain("episode", "its number", Value::U64(2));
        rows.key("drawn", "hand.friction", Value::Double(0.4));
        rows.key("set", "object.mass_kg", Value::Text("light".into()));
        let names: Vec<&str> = rows.columns.iter().map(|it| it.name.as_str()).collect();
        let expected = [
            "episode",
            "set.object.mass_kg",
            "drawn.hand.friction",
            "set.object.mass_kg (text)",
        ];
        assert_eq!(names, expected);
        assert_eq!(rows.columns[1].unit.as_deref(), Some("kg"));
        assert_eq!(rows.columns[2].unit, None);
        let mut space = Rows::default();
        space.begin();
        let speed: Parameter = toml::from_str(
            "name = \"speed\"\nunit = \"rad/s\"\nsets = [\"arm.speed_rad_s\"]\nuniform = [0.2, 0.4]",
        )
        .expect("a parameter");
        space.parameter(&speed, 0.3);
        assert_eq!(space.columns[0].name, "parameter.speed [rad/s]");
        assert_eq!(space.columns[0].unit.as_deref(), Some("rad/s"));
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(FILE);
        rows.write(&path, &[("study", "s")]).expect("written");
        let bytes = std::fs::read(&path).expect("bytes");
        assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
        let none = folder.path().join("none.parquet");
        Rows::default().write(&none, &[]).expect("nothing to write");
        assert!(!none.exists());
    }
}
