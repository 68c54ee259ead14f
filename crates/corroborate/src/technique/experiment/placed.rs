//! Mistakes in a table, each shown at its line.

use diagnostic::{Problem, Source};
use std::ops::Range;
use trace::{Table, TableError};

/// Where a row of a table stands, for what is said once the table is closed.
#[derive(Clone, Debug)]
pub struct RowPlace {
    file: String,
    /// None of the headers.
    line: Option<u64>,
}

impl RowPlace {
    pub fn new(table: &Table, row: usize) -> Self {
        Self {
            file: table.name().to_owned(),
            line: table.line(row),
        }
    }

    /// The headers of a table.
    pub fn head(table: &Table) -> Self {
        Self {
            file: table.name().to_owned(),
            line: None,
        }
    }

    /// The line, where there is one.
    pub fn line(&self) -> Option<u64> {
        self.line
    }

    /// The file, and the line where there is one.
    pub fn in_words(&self) -> String {
        match self.line {
            Some(line) => format!("{}:{line}", self.file),
            None => self.file.clone(),
        }
    }

    /// A mistake, at this place.
    pub fn of(&self, problem: Problem) -> Problem {
        at_line(problem, &self.file, self.line)
    }
}

/// What is wrong in a row of a table.
pub(super) fn in_row(
    table: &Table,
    row: usize,
    code: &'static str,
    message: impl Into<String>,
) -> Problem {
    at_line(Problem::new(code, message), table.name(), table.line(row))
}

/// Why a table is none, or lacks what is read of it.
pub(super) fn table_problem(error: TableError) -> Problem {
    let problem = Problem::new("bad-table", error.what());
    let placed = match error.table() {
        Some(table) => at_line(problem, table, error.line()),
        None => problem,
    };
    match error.remedy() {
        Some(remedy) => placed.remedy(remedy),
        None => placed,
    }
}

/// At a line of the table's file, its headers if none is given. The file is read again, since tables keep no text: if it has
/// gone meanwhile, the table is named alone.
fn at_line(problem: Problem, table: &str, line: Option<u64>) -> Problem {
    let Ok(text) = std::fs::read_to_string(table) else {
        return problem.about(table);
    };
    // Headers are the first line that is neither empty nor a comment.
    let said = |text: &str| !text.trim().is_empty() && !text.starts_with('#');
    let span = first_line(&text, |number, text| match line {
        Some(line) => number == line,
        None => said(text),
    });
    problem.at(&Source::new(table, text), span)
}

/// The first line of which this holds, given its number from 1; the end of the text if there is none.
fn first_line(text: &str, holds: impl Fn(u64, &str) -> bool) -> Range<usize> {
    let mut start = 0;
    for (line, number) in text.split_inclusive('\n').zip(1..) {
        if holds(number, line) {
            return start..start + line.trim_end().len();
        }
        start += line.len();
    }
    text.len()..text.len()
}
