//! Which files beside a result belong to it, and which are left out: what nothing has verified is not signed.
//!
//! # Definition
//! Of the evidence: the file of each entry of the ledger, and its episodes. Of what is kept beside it (a diagnosis, an exploration,
//! a map of disagreement, a calibration): what the verified result has. `run` takes one into the result only if it is of the
//! present evidence and files, and [`verify`](crate::verify()) holds it against the one in the result; a result without one says that
//! what lies there is older, newer or changed.
//!
//! Guarantee: each file that is found and left out is named, with the command that renews it where there is one. That a file is packed
//! does not say that it was derived again; the list of what is not shown does.

use super::parts::{Gathering, below, files_of, study_paths};
use crate::kept::{CALIBRATION, DIAGNOSIS, DISAGREEMENT, EXPLORATION};
use crate::run::evidence_file;
use ::pack::{NotShown, Recording, encoded};
use diagnostic::Problem;

/// How many files are named.
const MOST_NAMED: usize = 20;

/// Whether a file of this name in the folder of results belongs to the result.
pub(super) fn is_of(from: &Gathering<'_>, name: &str) -> bool {
    let result = from.result;
    let mut entries = from.study.ledger.iter();
    match Kind::of(name) {
        Kind::Diagnosis => result.diagnosis.is_some(),
        Kind::Map => result.disagreement.is_some(),
        Kind::Exploration => result.exploration.is_some(),
        Kind::Calibration => result.calibration.is_some(),
        Kind::Evidence => entries.any(|it| evidence_file(&it.id) == name),
        Kind::Episodes(id) => entries.any(|it| it.id == id),
        Kind::Other => true,
    }
}

/// Of what a file is a part.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind<'n> {
    Diagnosis,
    Map,
    Exploration,
    Calibration,
    Evidence,
    Episodes(&'n str),
    Other,
}

impl<'n> Kind<'n> {
    fn of(name: &'n str) -> Self {
        let parts: Vec<&str> = name.split('/').collect();
        match parts.as_slice() {
            [DIAGNOSIS] => Self::Diagnosis,
            // The map, and the folder of its journal.
            ["exploration", DISAGREEMENT | "disagreement", ..] => Self::Map,
            ["exploration", ..] => Self::Exploration,
            ["calibration", ..] => Self::Calibration,
            ["evidence", ..] => Self::Evidence,
            ["episodes", id, ..] => Self::Episodes(id),
            _ => Self::Other,
        }
    }

    /// Why it is left out, and what renews it.
    fn remedy(self) -> String {
        let renewed = |file: &str, command: &str| {
            format!(
                "{file} is not of the present evidence, was changed, or came after the result; `{command}`, then `corroborate run STUDY`, \
                 renews it"
            )
        };
        match self {
            Self::Diagnosis => renewed(DIAGNOSIS, "corroborate diagnose STUDY"),
            Self::Map => renewed(
                DISAGREEMENT,
                "corroborate explore STUDY FILE --disagreement",
            ),
            Self::Exploration => renewed(EXPLORATION, "corroborate explore STUDY FILE"),
            Self::Calibration => renewed(CALIBRATION, "corroborate calibrate STUDY FILE"),
            Self::Evidence | Self::Episodes(_) | Self::Other => {
                "no entry of ledger.toml has produced it".to_owned()
            }
        }
    }
}

/// What is said of files that are left out, in the order of their names.
pub(super) fn in_words(names: &[String]) -> Vec<NotShown> {
    let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
    for name in names {
        let remedy = Kind::of(name).remedy();
        match groups.iter_mut().find(|(known, _)| *known == remedy) {
            Some((_, group)) => group.push(name),
            None => groups.push((remedy, vec![name.as_str()])),
        }
    }
    let said = groups.into_iter().map(|(remedy, group)| NotShown {
        of: "the pack".into(),
        words: format!("Left out of study/results: {} ({remedy}).", listed(&group)),
    });
    said.collect()
}

/// Files of which the part has another name than the file, so that nothing that is unpacked is found by it.
pub(super) fn other_names(
    from: &Gathering<'_>,
    recordings: &[Recording],
) -> Result<Option<NotShown>, Problem> {
    let kept = files_of(from)?.into_iter();
    let kept = kept.map(|path| format!("results/{}", below(from.results, &path)));
    let packed = recordings.iter().filter(|it| it.part.is_some());
    let packed = packed.map(|it| it.path.clone());
    let mut names: Vec<String> = study_paths(from)?
        .into_iter()
        .chain(kept.filter(|name| !super::recordings::has_format(name)))
        .chain(packed)
        .filter(|name| encoded(name) != *name)
        .collect();
    names.sort_unstable();
    names.dedup();
    let shown: Vec<&str> = names.iter().map(String::as_str).collect();
    Ok((!names.is_empty()).then(|| NotShown {
        of: "the pack".into(),
        words: format!(
            "That its figures follow again where it is unpacked: names that lie outside the study's folder, or that not every system has, are \
             changed in the pack (`%XX`), and `corroborate verify` does not find these there: {}.",
            listed(&shown)
        ),
    }))
}

/// Names, of many the first.
pub(super) fn listed(names: &[&str]) -> String {
    let named: Vec<&str> = names.iter().take(MOST_NAMED).copied().collect();
    let named = named.join(", ");
    match names.len().checked_sub(MOST_NAMED).filter(|it| *it > 0) {
        Some(further) => format!("{named} and {further} more"),
        None => named,
    }
}
