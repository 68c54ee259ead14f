//! A study in Markdown, for the summary of a step in continuous integration and for comments on a change.

use crate::view::View;
use crate::{number, words};
use evidence::{Outcome, StudyResult, Subject};
use std::fmt::Write;

/// The verdicts in a table, then what conflicts and who is suspected.
#[must_use]
pub fn markdown(study: &StudyResult) -> String {
    let view = View { study };
    let mut text = format!("## {}\n\n", cell(&study.title));
    verdicts(&view, &mut text);
    conflicts(&view, &mut text);
    suspects(study, &mut text);
    text
}

fn verdicts(view: &View<'_>, text: &mut String) {
    text.push_str("| | requirement | verdict | evidence |\n|---|---|---|---|\n");
    for requirement in &view.study.requirements {
        let conclusion = view.conclusion(&requirement.id);
        let mark = conclusion.map(words::concluded);
        let (symbol, word) =
            mark.map_or(("○", "not covered".to_owned()), |it| (it.symbol, it.word));
        let subject = view.quantity(requirement);
        let pieces = conclusion.map_or(&[][..], |it| it.rests_on.as_slice());
        let pieces = pieces
            .iter()
            .filter_map(|id| figures(view.study, id, &subject));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {symbol} | {}: {} | {} | {} |",
            cell(&requirement.id),
            cell(&requirement.text),
            cell(&word),
            cell(&pieces.collect::<Vec<_>>().join("; "))
        );
    }
    let _ = writeln!(text, "\nIntervals are {}.", words::intervals(view.study));
}

/// A piece of evidence with its number on a subject.
fn figures(study: &StudyResult, id: &str, subject: &Subject) -> Option<String> {
    let piece = study.evidence.iter().find(|it| it.id == id)?;
    let measure = &piece.finding(subject)?.measure;
    let rate = number::percent(measure.estimate()?);
    let counted = match measure {
        evidence::Measure::Counts { count, trials, .. } => format!("{count}/{trials} = "),
        evidence::Measure::Probability { .. }
        | evidence::Measure::NotExpressible { .. }
        | evidence::Measure::NotCovered { .. } => String::new(),
    };
    let interval = measure.interval().map(number::interval).unwrap_or_default();
    Some(format!("{id}: {counted}{rate} ({interval})"))
}

fn conflicts(view: &View<'_>, text: &mut String) {
    let comparisons = view.study.comparisons.iter();
    let conflicts: Vec<_> = comparisons
        .filter(|it| it.outcome == Outcome::Conflicts)
        .collect();
    if conflicts.is_empty() {
        return;
    }
    text.push_str("\n### Conflicts\n\n");
    for it in conflicts {
        let subject = it.subject.in_words();
        let _ = writeln!(
            text,
            "* {} and {}, {}: {}",
            cell(&it.left),
            cell(&it.right),
            cell(&subject),
            cell(&it.reason)
        );
    }
}

fn suspects(study: &StudyResult, text: &mut String) {
    let open = study.suspected().iter().filter(|it| it.is_open());
    let open: Vec<_> = open.collect();
    if open.is_empty() {
        return;
    }
    text.push_str("\n### Suspected\n\n");
    for suspect in open {
        let _ = writeln!(
            text,
            "* {}: {}",
            cell(&suspect.title),
            cell(&suspect.explanation)
        );
    }
}

/// A text within a line or a cell of a table: nothing in it is taken for markup.
fn cell(text: &str) -> String {
    let mut cell = String::with_capacity(text.len());
    for word in text.split_whitespace() {
        if !cell.is_empty() {
            cell.push(' ');
        }
        for character in word.chars() {
            match character {
                '<' => cell.push_str("&lt;"),
                '>' => cell.push_str("&gt;"),
                '&' => cell.push_str("&amp;"),
                '|' | '*' | '_' | '`' | '[' | ']' | '\\' | '#' => {
                    cell.push('\\');
                    cell.push(character);
                }
                other => cell.push(other),
            }
        }
    }
    cell
}
