//! Two failure modes, or two requirements, that were written down as each other, a table's columns, or the files of two entries:
//! one proposal for all texts that name them.
//!
//! # Definition
//! A table of failure modes, or of requirements, has a row for each of the two; a cohort counts each in a column, or by a code, that the
//! vocabulary binds. Tables of one piece of evidence must not contradict each other, so that all that count the two change
//! together. Whether the cohort's columns were exchanged or the vocabulary's bindings of them, no count can tell: each
//! gives the same numbers. The vocabulary is changed where the columns are called after the other mode each and nothing
//! else is counted by these bindings; else the cohort.
//!
//! # Guarantee
//! Each text is changed in a copy before the proposal is offered. That the exchange is right is not shown: it needs a
//! decision.

use super::proposal::{Change, Offered, Proposal};
use super::suspects::of;
use diagnostic::Problem;
use evidence::{Subject, Suspect};
use refinement::{Exchange, unified};
use std::path::Path;
use study::Study;

const VOCABULARY: &str = "vocabulary.toml";

const LEDGER: &str = "ledger.toml";

/// What was mixed up.
pub(super) struct Mixed<'a> {
    /// The evidence that rests on the tables.
    pub evidence: &'a str,
    /// The two failure modes and requirements.
    pub modes: &'a [Subject; 2],
    /// Whether their opportunities were exchanged, too.
    pub is_whole: bool,
}

/// The proposal with which the two change places.
pub(super) fn of_exchange(
    study: &Study,
    suspect: &Suspect,
    mixed: &Mixed<'_>,
    offered: &mut Offered,
) -> Result<(), Problem> {
    let [one, other] = mixed.modes.each_ref().map(Subject::id);
    let title = format!("{}: `{one}` and `{other}` exchanged", mixed.evidence);
    offer(suspect, title, texts(study, mixed)?, study, offered)
}

/// The proposal with which the columns of a piece's table of requirements change places, in these rows or in all.
pub(super) fn of_columns(
    study: &Study,
    suspect: &Suspect,
    (evidence, rows): (&str, &[String]),
    offered: &mut Offered,
) -> Result<(), Problem> {
    let tables = study.entry(evidence)?.work.tables();
    let headers = ["passed", "failed"].map(str::to_owned);
    let of_rows = rows.to_vec();
    let exchange = match of_rows.is_empty() {
        true => Exchange::Headers { headers },
        false => Exchange::InRows {
            headers,
            rows: of_rows,
        },
    };
    let file = tables.and_then(|tables| tables.requirements);
    let texts = file.map(|file| (shown(file), exchange));
    let place = match rows {
        [] => String::new(),
        [row] => format!(" in the row `{row}`"),
        rows => format!(" in the rows `{}`", rows.join("`, `")),
    };
    let title = format!("{evidence}: `passed` and `failed` exchanged{place}");
    offer(suspect, title, texts.into_iter().collect(), study, offered)
}

/// The proposal with which two entries of the ledger get each other's files.
pub(super) fn of_entries(
    study: &Study,
    suspect: &Suspect,
    ids: &[String; 2],
    offered: &mut Offered,
) -> Result<(), Problem> {
    let [one, other] = ids;
    let title = format!("{one} and {other}: the files of the two exchanged");
    let exchange = Exchange::Entries { ids: ids.clone() };
    offer(
        suspect,
        title,
        vec![(LEDGER.into(), exchange)],
        study,
        offered,
    )
}

fn offer(
    suspect: &Suspect,
    title: String,
    texts: Vec<(String, Exchange)>,
    study: &Study,
    offered: &mut Offered,
) -> Result<(), Problem> {
    let Some((first, _)) = texts.first() else {
        return Ok(());
    };
    let mut diff = String::new();
    for (file, exchange) in &texts {
        let text = host::files::read_source(&study.folder.join(file))?.text;
        match exchange.make(&text) {
            Ok(changed) => diff.push_str(&unified(file, file, &text, &changed)),
            Err(reason) => {
                offered.refused.push(format!("{title}: {file}: {reason}."));
                return Ok(());
            }
        }
    }
    let mut notes = vec!["Only who kept it can tell: look at the original first.".to_owned()];
    let also: Vec<String> = texts[1..].iter().map(|(file, _)| file.clone()).collect();
    if !also.is_empty() {
        notes.push(format!(
            "The same is counted in {}, which changes with it. Whether a table or the vocabulary's columns are the wrong \
             way round, the counts cannot tell.",
            also.join(" and ")
        ));
    }
    offered.add(Proposal {
        title,
        file: first.clone(),
        also,
        diff,
        notes,
        needs_decision: true,
        ..of(suspect, Change::Exchange { texts })
    });
    Ok(())
}

/// The files, and what changes places in each.
fn texts(study: &Study, mixed: &Mixed<'_>) -> Result<Vec<(String, Exchange)>, Problem> {
    let mut texts = Vec::new();
    let Some(tables) = study.entry(mixed.evidence)?.work.tables() else {
        return Ok(texts);
    };
    let modes = mixed.modes.each_ref().map(|mode| mode.id().to_owned());
    let are_modes = mixed
        .modes
        .each_ref()
        .map(|it| matches!(it, Subject::FailureMode(_)));
    // Totals of one of them stand in another table than those of the other, so that they cannot have been exchanged.
    let has_totals = tables.requirements.is_some() || tables.failure_modes.is_some();
    if are_modes[0] != are_modes[1] && has_totals {
        return Ok(texts);
    }
    let is_of_modes = are_modes[0];
    if let (Some(file), false) = (tables.requirements, is_of_modes) {
        let exchange = Exchange::Names {
            modes: modes.clone(),
        };
        // A requirement may be counted in the cohort alone.
        let text = host::files::read_source(&study.folder.join(file))?.text;
        if tables.cohort.is_none() || exchange.make(&text).is_ok() {
            texts.push((shown(file), exchange));
        }
    }
    if let (Some(file), true) = (tables.failure_modes, is_of_modes) {
        let exchange = match mixed.is_whole {
            true => Exchange::Names { modes },
            false => Exchange::Occurrences { modes },
        };
        texts.push((shown(file), exchange));
    }
    let counted = mixed.modes.each_ref().map(|mode| counted_by(study, mode));
    if let (Some(cohort), [Some(one), Some(other)]) = (tables.cohort, counted) {
        texts.push(of_cohort(study, mixed, cohort, [one, other]));
    }
    Ok(texts)
}

fn shown(file: &Path) -> String {
    file.to_string_lossy().replace('\\', "/")
}

/// The proposition that experiments count for a failure mode, and its column.
fn counted_by<'s>(study: &'s Study, mode: &Subject) -> Option<(&'s String, &'s str)> {
    let form = study.forms.of(mode)?;
    let name = form.experiment.as_ref()?;
    let column = study.vocabulary.propositions.get(name)?.column.as_ref()?;
    Some((name, column.text.as_str()))
}

/// What changes places so that the cohort counts the one where it counted the other.
fn of_cohort(
    study: &Study,
    mixed: &Mixed<'_>,
    cohort: &Path,
    counted: [(&String, &str); 2],
) -> (String, Exchange) {
    let columns = counted.map(|(_, column)| column.trim().to_owned());
    let cohorts = study.ledger.iter().filter_map(|entry| entry.work.cohort());
    let others = cohorts.filter(|file| *file != cohort);
    let is_alone = others.count() == 0;
    let [one, other] = mixed.modes.each_ref().map(Subject::id);
    let is_crossed = called_after(&columns[0], other) && called_after(&columns[1], one);
    let is_right = called_after(&columns[0], one) || called_after(&columns[1], other);
    let codes = columns.each_ref().map(|column| column.split_once(':'));
    let propositions = || counted.map(|(name, _)| name.clone());
    match codes {
        _ if is_alone && is_crossed && !is_right => (
            VOCABULARY.into(),
            Exchange::Columns {
                propositions: propositions(),
            },
        ),
        [None, None] => (shown(cohort), Exchange::Headers { headers: columns }),
        [Some((header, one)), Some((same, other))] if header.trim() == same.trim() => (
            shown(cohort),
            Exchange::Codes {
                header: header.trim().to_owned(),
                codes: [one, other].map(|code| code.trim().to_owned()),
            },
        ),
        _ => (
            VOCABULARY.into(),
            Exchange::Columns {
                propositions: propositions(),
            },
        ),
    }
}

/// Whether a column has a failure mode's name, or its code begins as the mode does: `n_slip`, and `codes: S0`, that of `slip`.
fn called_after(column: &str, mode: &str) -> bool {
    let mode = mode.to_lowercase();
    match column.split_once(':') {
        Some((_, code)) => {
            let letters: String = code
                .trim()
                .chars()
                .take_while(|c| c.is_alphabetic())
                .flat_map(char::to_lowercase)
                .collect();
            !letters.is_empty() && mode.starts_with(&letters)
        }
        None => {
            let column = column.to_lowercase();
            let mut words = column.match_indices(&mode);
            words.any(|(at, _)| {
                let ends = [
                    column[..at].chars().next_back(),
                    column[at + mode.len()..].chars().next(),
                ];
                ends.iter().all(|c| c.is_none_or(|c| !c.is_alphanumeric()))
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::called_after;

    #[test]
    fn columns_are_called_after_failures_by_their_name_or_their_code() {
        assert!(called_after("n_slip", "slip") && !called_after("n_slippage", "slip"));
        assert!(called_after("codes: S0", "slip") && !called_after("codes: G1", "slip"));
        assert!(!called_after("codes: 7", "slip"));
    }
}
