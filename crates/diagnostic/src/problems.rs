//! What is wrong with an input that is read on behind its mistakes.
//!
//! Who reads on puts something neutral in the place of what is wrong. What is found later and speaks of that place, or of a
//! name that could not be read, follows from the first mistake and is not told: it may be gone once that one is corrected.

use crate::{Kind, Problem, Source, line_and_column};
use std::collections::BTreeSet;
use std::ops::Range;

/// Line and column, counted from one.
type Position = (usize, usize);

/// The problems of one input, in the order in which they are found.
#[derive(Debug, Default)]
pub struct Problems {
    found: Vec<Problem>,
    not_shown: usize,
    /// The files that were read, in the order in which their problems are told.
    files: Vec<String>,
    /// Places whose content is not the user's, or is known to be wrong.
    settled: Vec<(String, Position, Position)>,
    /// Names whose definition is wrong.
    broken: BTreeSet<String>,
    /// Whether there may be definitions whose names could not be read.
    names_are_missing: bool,
}

impl Problems {
    /// None so far.
    pub fn new() -> Self {
        Self::default()
    }

    /// Whether nothing was found.
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// Problems of this file are told behind those of the files before.
    pub fn reads(&mut self, source: &Source) {
        self.rank(&source.name);
    }

    /// Adds a problem, with the others that it has, unless it follows from one that is known.
    pub fn add(&mut self, mut problem: Problem) {
        self.not_shown += std::mem::take(&mut problem.not_shown);
        let others = std::mem::take(&mut problem.others);
        if !self.follows(&problem) && !self.found.contains(&problem) {
            if let Some(place) = problem.place() {
                self.rank(&place.name.clone());
            }
            self.found.push(problem);
        }
        for other in others {
            self.add(other);
        }
    }

    /// Adds what was found in a part, with what is known of it.
    pub fn join(&mut self, part: Problems) {
        let Problems {
            found,
            not_shown,
            files,
            settled,
            broken,
            names_are_missing,
        } = part;
        files.iter().for_each(|name| self.rank(name));
        found.into_iter().for_each(|problem| self.add(problem));
        self.not_shown += not_shown;
        self.settled.extend(settled);
        self.broken.extend(broken);
        self.names_are_missing |= names_are_missing;
    }

    /// The value of a result; its problem is added.
    pub fn keep<T>(&mut self, result: Result<T, Problem>) -> Option<T> {
        result.map_err(|problem| self.add(problem)).ok()
    }

    /// What stands there is not the user's or was told already: further problems at that place follow from it.
    pub fn settle(&mut self, source: &Source, span: Range<usize>) {
        let start = line_and_column(&source.text, span.start);
        let end = line_and_column(&source.text, span.end.max(span.start));
        self.settled.push((source.name.clone(), start, end));
    }

    /// What this name stands for is wrong: further problems that speak of it follow from that.
    pub fn break_name(&mut self, name: &str) {
        self.broken.insert(name.to_owned());
    }

    /// Some definitions could not be read: names that are not known may be theirs.
    pub fn lose_names(&mut self) {
        self.names_are_missing = true;
    }

    /// Whether there may be definitions whose names could not be read.
    pub fn has_lost_names(&self) -> bool {
        self.names_are_missing
    }

    /// Whether reading on makes no sense: it was interrupted, or something is wrong that is not in the input.
    pub fn is_ended(&self) -> bool {
        self.found.iter().any(|it| it.kind() != Kind::Input)
    }

    /// All of them as one, in the order of files and lines; `None` if there are none. An interruption, or what is not a
    /// mistake in the input, comes alone.
    pub fn into_problem(self) -> Option<Problem> {
        let other = self.found.iter().find(|it| it.kind() != Kind::Input);
        if let Some(other) = other {
            return Some(other.clone());
        }
        let mut found = self.found;
        let rank = |problem: &Problem| match problem.place() {
            Some(place) => {
                let file = self.files.iter().position(|name| *name == place.name);
                (file.unwrap_or(usize::MAX), place.line, place.column)
            }
            None => (usize::MAX, 0, 0),
        };
        found.sort_by_key(rank);
        Some(Problem::all(found)?.and_more(self.not_shown))
    }

    /// The value, if nothing is wrong.
    ///
    /// # Errors
    /// All problems as one.
    pub fn or<T>(self, value: T) -> Result<T, Problem> {
        self.into_problem().map_or(Ok(value), Err)
    }

    fn rank(&mut self, name: &str) {
        if !self.files.iter().any(|known| known == name) {
            self.files.push(name.to_owned());
        }
    }

    fn follows(&self, problem: &Problem) -> bool {
        if self.names_are_missing && problem.code.starts_with("unknown-") {
            return true;
        }
        let at_settled = problem.place().is_some_and(|place| {
            let at = (place.line, place.column);
            let mut settled = self.settled.iter();
            settled.any(|(name, start, end)| *name == place.name && *start <= at && at <= *end)
        });
        at_settled || self.broken.iter().any(|name| names(problem, name))
    }
}

/// Whether a problem's message, or what it points at, has this name.
fn names(problem: &Problem, name: &str) -> bool {
    let pointed_at = problem.place().and_then(|place| {
        let excerpt = place.excerpt.as_ref()?;
        excerpt.text.get(excerpt.span.clone())
    });
    has_word(problem.message(), name) || pointed_at.is_some_and(|text| has_word(text, name))
}

fn has_word(text: &str, word: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + word.len()..].chars().next();
        !before.is_some_and(is_part) && !after.is_some_and(is_part)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn source(name: &str) -> Source {
        Source::new(name, "first = 1\nsecond = 2\nthird = 3\n")
    }

    fn messages(problems: Problems) -> Vec<String> {
        let all = problems.into_problem().expect("problems");
        let others = all.others().to_vec();
        let mut each = vec![all];
        each.extend(others);
        each.iter().map(|it| it.message().to_owned()).collect()
    }

    #[test]
    fn problems_are_told_in_the_order_of_files_and_lines_each_once() {
        let (a, b) = (source("a"), source("b"));
        let mut problems = Problems::new();
        problems.reads(&a);
        problems.add(Problem::new("x", "b1").at(&b, 0..5));
        let of_a = [(20, "a3"), (0, "a1"), (10, "a2"), (0, "a1")];
        let of_a = of_a.map(|(at, message)| Problem::new("x", message).at(&a, at..at + 5));
        problems.add(Problem::all(of_a).expect("some"));
        assert_eq!(messages(problems), ["a1", "a2", "a3", "b1"]);
    }

    #[test]
    fn what_follows_from_a_mistake_is_not_told() {
        let a = source("a");
        let mut problems = Problems::new();
        problems.add(Problem::new("x", "wrong").at(&a, 8..9));
        problems.settle(&a, 8..9);
        problems.add(Problem::new("y", "out of range").at(&a, 8..9));
        problems.break_name("speed");
        problems.add(Problem::new("y", "`speed` has a bad unit").at(&a, 10..12));
        problems.add(Problem::new("y", "`speed_limit` is too large").at(&a, 20..21));
        problems.lose_names();
        problems.add(Problem::new("unknown-name", "`x` is not known").at(&a, 20..21));
        assert_eq!(messages(problems), ["wrong", "`speed_limit` is too large"]);
    }

    #[test]
    fn an_interruption_comes_alone() {
        let mut problems = Problems::new();
        problems.add(Problem::new("x", "wrong"));
        problems.add(Problem::interrupted());
        let one = problems.into_problem().expect("one");
        assert!(one.is_interruption() && one.others().is_empty());
    }
}
