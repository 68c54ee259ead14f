//! Traceability: which requirement is shown by what, and which by no evidence.
//!
//! # Definition
//! A row for each requirement and each piece of evidence that has a finding about the requirement's quantity, in the order of
//! the requirements and of the ledger; a requirement without such a piece has one row, whose gap says so. What the row says of the
//! requirement (forms, verdict) is the same in all of its rows, so that a row can be read by itself.
//!
//! Guarantee: every requirement has a row; nothing is computed, a row is a view of fields of the result.
//!
//! # Assumes
//! The tests are those that the caller found; the result does not name them.

use crate::{
    Asset, Conclusion, Evidence, Finding, Requirement, Step, StudyResult, Subject, Technique,
    Verdict,
};
use std::collections::BTreeMap;

/// A requirement, and a piece of evidence about it.
#[derive(Clone, Debug)]
pub struct TraceRow<'r> {
    /// The requirement in all its forms.
    pub requirement: &'r Requirement,
    /// What the study concludes about it.
    pub verdict: Verdict,
    /// On which step.
    pub step: Option<Step>,
    /// The piece with what it found; `None` if no piece speaks of the requirement.
    pub shown_by: Option<(&'r Evidence, &'r Finding)>,
    /// How the piece takes part in the conclusion, in words.
    pub part: String,
    /// Tests of the requirement by name.
    pub tests: Vec<String>,
    /// What is missing; empty if nothing is.
    pub gap: String,
}

impl TraceRow<'_> {
    /// The technique of the piece.
    #[must_use]
    pub fn technique(&self) -> Option<Technique> {
        self.shown_by.map(|(piece, _)| piece.technique)
    }

    /// The files on which the piece rests.
    pub fn assets(&self) -> impl Iterator<Item = &Asset> {
        self.shown_by
            .into_iter()
            .flat_map(|(piece, _)| &piece.assets)
    }
}

/// The rows of a result, with the tests of each requirement by its identifier.
#[must_use]
pub fn trace<'r>(
    result: &'r StudyResult,
    tests: &BTreeMap<String, Vec<String>>,
) -> Vec<TraceRow<'r>> {
    let rows = result.requirements.iter().flat_map(|requirement| {
        let conclusions = &mut result.conclusions.iter();
        let conclusion = conclusions.find(|it| it.requirement == requirement.id);
        let tests = tests.get(&requirement.id).cloned().unwrap_or_default();
        let row = |shown_by, part, gap| TraceRow {
            requirement,
            verdict: conclusion.map_or(Verdict::NotCovered, |it| it.verdict),
            step: conclusion.and_then(|it| it.step),
            shown_by,
            part,
            tests: tests.clone(),
            gap,
        };
        let pieces = pieces(result, requirement).into_iter();
        let mut rows: Vec<TraceRow> = pieces
            .map(|(piece, finding)| {
                let gap = gap(finding);
                row(Some((piece, finding)), part(conclusion, piece), gap)
            })
            .collect();
        if rows.is_empty() {
            let gap = "no evidence has a finding about it".to_owned();
            rows.push(row(None, String::new(), gap));
        }
        rows
    });
    rows.collect()
}

/// The pieces that speak of a requirement: by its own identifier, or that of the requirement with the same quantity.
fn pieces<'r>(
    result: &'r StudyResult,
    requirement: &Requirement,
) -> Vec<(&'r Evidence, &'r Finding)> {
    let own = Subject::Requirement(requirement.id.clone());
    let first = requirement
        .same_quantity_as
        .clone()
        .map(Subject::Requirement);
    let found = result.evidence.iter().filter_map(|piece| {
        let of_first = || first.as_ref().and_then(|it| piece.finding(it));
        let finding = piece.finding(&own).or_else(of_first)?;
        Some((piece, finding))
    });
    found.collect()
}

fn part(conclusion: Option<&Conclusion>, piece: &Evidence) -> String {
    let Some(conclusion) = conclusion else {
        return "not concluded from".into();
    };
    let excluded = conclusion
        .excluded
        .iter()
        .find(|it| it.evidence == piece.id);
    match excluded {
        Some(excluded) => format!("left out: {}", excluded.words),
        None if conclusion.rests_on.contains(&piece.id) => "the verdict rests on it".into(),
        None if piece.intermediate => "a step on the way".into(),
        None => "shown, not decisive".into(),
    }
}

fn gap(finding: &Finding) -> String {
    use crate::Measure;
    let missing = match &finding.measure {
        Measure::NotExpressible { reason } => format!("not expressible: {reason}"),
        Measure::NotCovered { reason, .. } => format!("never observed: {reason}"),
        Measure::Counts { trials: 0, .. } => "never observed".into(),
        Measure::Counts { .. } | Measure::Probability { .. } => String::new(),
    };
    match (missing.is_empty(), finding.undecided) {
        (true, 0) => String::new(),
        (true, runs) => format!("runs without a verdict: {runs}"),
        (false, _) => missing,
    }
}
