//! Tables of positions: a column of times in seconds, and three columns for each point, `NAME.x`, `NAME.y`, `NAME.z` (or `NAME_x`).
//!
//! Columns are parted by commas, semicolons or tabs. An empty cell, or one that says `nan`, is a point that was not seen.

use super::{BadFile, Raw};
use crate::geometry::Vector;

/// Reads a file whose times stand in the column of this name.
pub(super) fn read(text: &str, time_column: &str) -> Result<Raw, BadFile> {
    let bad = |line: usize, column: usize, what: String| BadFile {
        place: format!("{}:{}", line + 1, column + 1),
        what,
    };
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
    let cells = |line: &str| -> Vec<String> {
        let cells = line.split(by);
        cells
            .map(|cell| cell.trim().trim_matches('"').to_owned())
            .collect()
    };
    let head = cells(head);
    let time = head.iter().position(|it| it == time_column).ok_or_else(|| {
        let what = format!(
            "no column `{time_column}` with times in seconds; `time_column` names it, and there are {}",
            head.join(", ")
        );
        bad(at, 0, what)
    })?;
    let points = points_of(&head);
    let mut raw = Raw {
        names: points.iter().map(|(name, _)| name.clone()).collect(),
        places: vec![Vec::new(); points.len()],
        ..Raw::default()
    };
    for (line, text) in lines {
        let row = cells(text);
        if row.len() != head.len() {
            let what = format!(
                "{} cells where the first line has {}",
                row.len(),
                head.len()
            );
            return Err(bad(line, 0, what));
        }
        let number = |column: usize| -> Result<Option<f64>, BadFile> {
            let cell = &row[column];
            if cell.is_empty() || cell.eq_ignore_ascii_case("nan") {
                return Ok(None);
            }
            let number = cell.parse().ok().filter(|it: &f64| it.is_finite());
            let what = || format!("`{cell}` in the column `{}` is not a number", head[column]);
            number
                .map(Some)
                .ok_or_else(|| bad(line, column_of(text, by, column), what()))
        };
        let secs = number(time)?
            .ok_or_else(|| bad(line, column_of(text, by, time), "no time".to_owned()))?;
        if raw.times_secs.last().is_some_and(|before| secs <= *before) {
            let what = format!("the time {secs} is not after the one before");
            return Err(bad(line, column_of(text, by, time), what));
        }
        raw.times_secs.push(secs);
        for (kept, (_, columns)) in raw.places.iter_mut().zip(&points) {
            let mut place: Option<Vector> = Some([0.0; 3]);
            for (axis, column) in columns.iter().enumerate() {
                place = match (place, number(*column)?) {
                    (Some(mut place), Some(number)) => {
                        place[axis] = number;
                        Some(place)
                    }
                    _ => None,
                };
            }
            kept.push(place);
        }
    }
    Ok(raw)
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
