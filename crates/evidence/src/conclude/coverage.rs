//! What evidence does not cover.

use super::{current_evidence, latest_of_each_technique};
use crate::compare::Study;
use crate::compare::words::sentence;
use crate::{CoverageGap, Evidence, Finding, Measure, Subject};

/// Requirements and failure modes about which no current evidence has a number (`evidence` is
/// then empty), and those that the current evidence of some technique cannot express, never
/// covered, or was not asked about.
///
/// Current is the latest evidence of each technique under the conditions that most techniques
/// share, without intermediate evidence and evidence that another reproduces. A subject that a technique's
/// evidence lacks altogether is only a gap if that evidence speaks about subjects of this kind.
pub fn coverage_gaps(study: &Study<'_>) -> Vec<CoverageGap> {
    let current: Vec<&Evidence> = latest_of_each_technique(study.evidence, |_| true)
        .into_iter()
        .map(|index| &study.evidence[index])
        .collect();
    study
        .subjects()
        .into_iter()
        .flat_map(|(subject, _)| gaps(study.evidence, &current, &subject))
        .collect()
}

fn gaps(evidence: &[Evidence], current: &[&Evidence], subject: &Subject) -> Vec<CoverageGap> {
    let silent: Vec<(&str, String)> = current
        .iter()
        .filter_map(|piece| Some((piece.id.as_str(), why_silent(piece, subject)?)))
        .collect();
    // Conclusions rest on the latest piece of each technique that has a number on the subject, which an earlier one may be.
    let speaks = |piece: &Evidence| {
        piece
            .finding(subject)
            .is_some_and(|finding| why_no_number(finding).is_none())
    };
    if !current_evidence(evidence, speaks).is_empty() {
        return silent
            .into_iter()
            .map(|(id, why)| CoverageGap {
                subject: subject.clone(),
                evidence: vec![id.to_owned()],
                reason: sentence(&format!("{id} {why}")),
            })
            .collect();
    }
    let reasons = silent
        .iter()
        .map(|(id, why)| sentence(&format!("{id} {why}")));
    // A number that takes part in nothing is named, so that nobody reads that there is none.
    let apart = evidence.iter().filter(|piece| speaks(piece));
    let apart = apart.map(|piece| {
        let why = match &piece.reproduced_by {
            Some(by) => format!("is reproduced by {by}"),
            None => "is marked as intermediate".to_owned(),
        };
        format!("{} has a number on it and {why}.", piece.id)
    });
    let apart: Vec<String> = apart.collect();
    let what = match apart.is_empty() {
        true => "Not covered by any evidence.",
        false => "Not covered by any evidence that takes part.",
    };
    let reasons: Vec<String> = reasons.chain(apart).collect();
    let reason = match reasons.as_slice() {
        [] => "No evidence was asked about it.".to_owned(),
        _ => format!("{what} {}", reasons.join(" ")),
    };
    vec![CoverageGap {
        subject: subject.clone(),
        evidence: Vec::new(),
        reason,
    }]
}

/// Why a piece of evidence says nothing about a subject; `None` if it does, or if it is about
/// other kinds of subjects.
fn why_silent(piece: &Evidence, subject: &Subject) -> Option<String> {
    match piece.finding(subject) {
        Some(finding) => why_no_number(finding),
        None => piece
            .findings
            .iter()
            .any(|finding| same_kind(&finding.subject, subject))
            .then(|| "was not asked about it".to_owned()),
    }
}

fn same_kind(one: &Subject, other: &Subject) -> bool {
    matches!(one, Subject::Requirement(_)) == matches!(other, Subject::Requirement(_))
}

fn why_no_number(finding: &Finding) -> Option<String> {
    match &finding.measure {
        Measure::NotExpressible { reason } => Some(format!("cannot express it. {reason}")),
        Measure::NotCovered { reason, .. } => Some(format!("never covered it. {reason}")),
        Measure::Counts { trials: 0, .. } => Some("never covered it".to_owned()),
        Measure::Counts { .. } | Measure::Probability { .. } => None,
    }
}
