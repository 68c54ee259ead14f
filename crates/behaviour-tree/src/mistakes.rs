//! Mistakes and notes of several files: collected as they are met, placed at the end.
//!
//! To find line and column of a place takes a walk over the text. Only what is shown is placed, so a text of a
//! hundred thousand mistakes costs fifty walks.

use std::ops::Range;

use diagnostic::{MOST_SHOWN, Problem, Source};

/// A place in one of the files.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Spot {
    /// The number of the file.
    pub file: usize,
    /// Its bytes.
    pub start: usize,
    pub end: usize,
}

impl Spot {
    pub fn new(file: usize, span: Range<usize>) -> Self {
        Self {
            file,
            start: span.start,
            end: span.end,
        }
    }
}

#[derive(Debug)]
struct Mistake {
    code: &'static str,
    spot: Spot,
    message: String,
    remedy: String,
}

/// Mistakes, or notes, in the order in which they were met.
#[derive(Debug, Default)]
pub(crate) struct Mistakes {
    found: Vec<Mistake>,
}

impl Mistakes {
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// What cannot be read.
    pub fn add(&mut self, spot: Spot, message: impl Into<String>, remedy: impl Into<String>) {
        self.push("bad-behaviour-tree", spot, message.into(), remedy.into());
    }

    /// What is well-formed, and beyond what is read here.
    pub fn refuse(&mut self, spot: Spot, message: impl Into<String>, remedy: impl Into<String>) {
        let code = "unsupported-behaviour-tree";
        self.push(code, spot, message.into(), remedy.into());
    }

    /// What the model leaves out or assumes.
    pub fn note(&mut self, spot: Spot, message: impl Into<String>, remedy: impl Into<String>) {
        let code = "abstracted-behaviour-tree";
        self.push(code, spot, message.into(), remedy.into());
    }

    fn push(&mut self, code: &'static str, spot: Spot, message: String, remedy: String) {
        let known = self.found.iter().rev().take(MOST_SHOWN);
        if known
            .into_iter()
            .any(|it| it.spot == spot && it.message == message)
        {
            return;
        }
        self.found.push(Mistake {
            code,
            spot,
            message,
            remedy,
        });
    }

    /// The mistakes in the order of their places, as one problem; `None` if there are none.
    pub fn into_problem(self, files: &[Source]) -> Option<Problem> {
        let count = self.found.len();
        let shown = self.into_problems(files, MOST_SHOWN);
        let not_shown = count - shown.len();
        Problem::all(shown).map(|problem| problem.and_more(not_shown))
    }

    /// Each as a problem with its place, in the order of the places; no more than `most`.
    pub fn into_problems(mut self, files: &[Source], most: usize) -> Vec<Problem> {
        self.found.sort_by(|a, b| a.spot.cmp(&b.spot));
        self.found.truncate(most);
        let placed = |it: Mistake| {
            Problem::new(it.code, it.message)
                .at(&files[it.spot.file], it.spot.start..it.spot.end)
                .remedy(it.remedy)
        };
        self.found.into_iter().map(placed).collect()
    }
}
