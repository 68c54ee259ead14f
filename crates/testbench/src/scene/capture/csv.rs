//! Tables of positions: a column of times in seconds, and three columns for each point, `NAME.x`, `NAME.y`, `NAME.z` (or `NAME_x`).
//!
//! Columns are parted by commas, semicolons or tabs. An empty cell, or one that says `nan`, is a point that was not seen.

use super::{BadFile, Raw};

/// Reads a file whose times stand in the column of this name.
pub(super) fn read(text: &str, time_column: &str) -> Result<Raw, BadFile> {
    let mut lines = text
        .lines()
        .enumerate()
        .filter(|(_, it)| !it.trim().is_empty());
    let (at, head) = lines.next().ok_or_else(|| {
        bad(
            0,
            0,
            "the file is empty; its first line names the columns".to_owned(),
        )
    })?;
    let by = [';', '\t', ',']
        .into_iter()
        .find(|it| head.contains(*it))
        .unwrap_or(',');
    let head = cells(head, by);
    let time = head.iter().position(|it| it == time_column).ok_or_else(|| {
        let what = format!(
            "no column `{time_column}` with times in seconds; `time_column` names it, and there are {}",
            head.join(", ")
        );
        bad(at, 0, what)
    })?;
    let table = Table {
        by,
        points: points_of(&head),
        head,
        time,
    };
    let mut raw = Raw {
        names: table.points.iter().map(|(name, _)| name.clone()).collect(),
        places: vec![Vec::new(); table.points.len()],
        ..Raw::default()
    };
    for (line, text) in lines {
        table.add(line, text, &mut raw)?;
    }
    Ok(raw)
}

fn bad(line: usize, column: usize, what: String) -> BadFile {
    BadFile {
        place: format!("{}:{}", line + 1, column + 1),
        what,
    }
}

fn cells(line: &str, by: char) -> Vec<String> {
    let cells = line.split(by);
    cells
        .map(|cell| cell.trim().trim_matches('"').to_owned())
        .collect()
}

/// The columns of a table.
struct Table {
    by: char,
    head: Vec<String>,
    time: usize,
    points: Vec<(String, [usize; 3])>,
}

impl Table {
    /// Adds a line.
    fn add(&self, line: usize, text: &str, raw: &mut Raw) -> Result<(), BadFile> {
        let row = cells(text, self.by);
        if row.len() != self.head.len() {
            let what = format!(
                "{} cells where the first line has {}",
                row.len(),
                self.head.len()
            );
            return Err(bad(line, 0, what));
        }
        let at = |column: usize| column_of(text, self.by, column);
        let number = |column: usize| -> Result<Option<f64>, BadFile> {
            let cell = &row[column];
            if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
                return Ok(None);
            }
            let number = cell.parse().ok().filter(|it: &f64| it.is_finite());
            let name = &self.head[column];
            let what = || format!("`{cell}` in the column `{name}` is not a number");
            number
                .map(Some)
                .ok_or_else(|| bad(line, at(column), what()))
        };
        let secs = number(self.time)?;
        let secs = secs.ok_or_else(|| bad(line, at(self.time), "no time".to_owned()))?;
        if raw.times_secs.last().is_some_and(|before| secs <= *before) {
            let what = format!("the time {secs} is not after the one before");
            return Err(bad(line, at(self.time), what));
        }
        raw.times_secs.push(secs);
        for (kept, (_, columns)) in raw.places.iter_mut().zip(&self.points) {
            let numbers = [
                number(columns[0])?,
                number(columns[1])?,
                number(columns[2])?,
            ];
            kept.push(match numbers {
                [Some(x), Some(y), Some(z)] => Some([x, y, z]),
                _ => None,
            });
        }
        Ok(())
    }
}

/// The points that have all three columns, in the order of their first.
fn points_of(head: &[String]) -> Vec<(String, [usize; 3])> {
    let place_of = |name: &str, axis: &str| {
        head.iter().position(|it| {
            let rest = it.strip_prefix(name).map(str::to_ascii_lowercase);
            rest.is_some_and(|rest| {
                rest.len() == 2 && ".:_ ".contains(&rest[..1]) && rest.ends_with(axis)
            })
        })
    };
    let names = head.iter().filter_map(|it| {
        let (name, axis) = it.split_at_checked(it.len().checked_sub(2)?)?;
        let axis = axis.to_ascii_lowercase();
        [".x", ":x", "_x", " x"]
            .contains(&axis.as_str())
            .then_some(name)
    });
    names
        .filter_map(|name| {
            let columns = ["x", "y", "z"].map(|axis| place_of(name, axis));
            let [Some(x), Some(y), Some(z)] = columns else {
                return None;
            };
            Some((name.to_owned(), [x, y, z]))
        })
        .collect()
}

/// Where a cell begins in its line.
fn column_of(line: &str, by: char, cell: usize) -> usize {
    let before = line.split(by).take(cell).map(|it| it.len() + 1);
    before.sum()
}
