//! TOML texts of a study into their types, with all mistakes of their form at once.
//!
//! The deserializer stops at its first mistake. That mistake is mended in a copy of the parsed text, and the copy is read for
//! the next one: an unknown field is left out, or takes the known name that it is like; a missing one gets a value of its
//! type; a value of a wrong type is replaced; what cannot be mended so is left out as a whole. What then is read is only
//! good for looking further ([`read_on`]): places whose content is made up are settled there, so that nothing is told of
//! them that the user did not write.

mod mend;
mod words;

use diagnostic::{MOST_SHOWN, Problem, Problems, Source};
use mend::Mended;
use serde::de::DeserializeOwned;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

/// Longer texts are not read again and again.
const LONGEST: usize = 1 << 17;
/// The code of a mistake in one of the study's own files.
const OWN: &str = "bad-study-file";

/// Reads a text, whose mistakes have this code.
///
/// # Errors
/// All mistakes of its form, in the order of its lines.
pub fn read<T: DeserializeOwned>(code: &'static str, source: &Source) -> Result<T, Problem> {
    let mut found = Problems::new();
    let value = read_as(code, source, &[], &mut found);
    match found.into_problem() {
        Some(problem) => Err(problem),
        // Without a value there is a problem.
        None => value.ok_or_else(|| Problem::new(code, "the file cannot be read").at(source, 0..0)),
    }
}

/// Reads a text, adds the mistakes of its form to those that were found, and gives what is left of it to look further in.
pub fn read_on<T: DeserializeOwned>(source: &Source, found: &mut Problems) -> Option<T> {
    read_as(OWN, source, &[], found)
}

/// The same, whose mistakes have a code of one's own. What stands at `taken` is taken for a number: it becomes one before it is
/// read.
pub fn read_as<T: DeserializeOwned>(
    code: &'static str,
    source: &Source,
    taken: &[Range<usize>],
    found: &mut Problems,
) -> Option<T> {
    found.reads(source);
    let (root, errors) = DeTable::parse_recoverable(&source.text);
    if !errors.is_empty() {
        for problem in syntax(code, source, &errors) {
            found.add(problem);
        }
        found.lose_names();
        return None;
    }
    let root = Spanned::new(root.span(), DeValue::Table(root.into_inner()));
    let mut tree = Mended::new(root, taken);
    let value = read_to_the_end(code, source, &mut tree, found);
    // Only now: until here, what is told is of the form, and of what the user wrote.
    for span in tree.made_up().chain(taken.iter().cloned()) {
        found.settle(source, span);
    }
    if tree.is_a_name_lost() || value.is_none() {
        found.lose_names();
    }
    value
}

fn read_to_the_end<T: DeserializeOwned>(
    code: &'static str,
    source: &Source,
    tree: &mut Mended<'_>,
    found: &mut Problems,
) -> Option<T> {
    for _ in 0..MOST_SHOWN {
        let error = match tree.read::<T>() {
            Ok(value) => return Some(value),
            Err(error) => error,
        };
        found.add(words::problem(code, source, tree, &error));
        if source.text.len() > LONGEST || !tree.mend::<T>(&error) {
            return None;
        }
    }
    None
}

/// Mistakes of the syntax, one for each line: what follows in a line follows from the first.
fn syntax(code: &'static str, source: &Source, errors: &[Error]) -> Vec<Problem> {
    let mut lines = Vec::new();
    let mut problems = Vec::new();
    for error in errors.iter().take(MOST_SHOWN) {
        let span = error.span().unwrap_or(0..0);
        let (line, _) = diagnostic::line_and_column(&source.text, span.start);
        if !lines.contains(&line) {
            lines.push(line);
            let message = error.message().trim_end().to_owned();
            problems.push(
                Problem::new(code, message)
                    .at(source, span)
                    .remedy("correct the line; it has to be valid TOML"),
            );
        }
    }
    problems
}

/// Where a field stands that is not known, if the error only shows its table.
pub fn place_of_unknown(text: &str, error: &Error) -> Option<Range<usize>> {
    let field = words::quoted_in(error.message(), "unknown field `")?;
    let span = error.span()?;
    if text
        .get(span.clone())
        .is_some_and(|shown| shown.trim_matches(['"', '\'']) == field)
    {
        return None;
    }
    let root = DeTable::parse(text).ok()?;
    let root = Spanned::new(root.span(), DeValue::Table(root.into_inner()));
    mend::key_in_table_at(&root, span.start, field)
}

#[cfg(test)]
mod tests;
