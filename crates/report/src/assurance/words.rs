//! What the elements of an argument say of the study's parts.

use super::node::{Citation, identifier};
use crate::number;
use crate::view::View;
use crate::words::{asked, has_no_bound};
use evidence::{
    Comparison, Evidence, Finding, Measure, Requirement, StudyResult, Subject, effective_size,
};

/// The finding in one line: counts, rate and interval, or probability and
/// guarantee.
pub fn figures(measure: &Measure) -> String {
    match measure {
        Measure::Counts {
            count,
            trials,
            effective_trials,
            interval,
            ..
        } if *trials > 0 => {
            let worth = effective_trials.filter(|worth| *worth < *trials as f64);
            let worth = worth.map_or(String::new(), |worth| {
                format!(" (effective sample size {})", effective_size(worth))
            });
            format!(
                "{} of {}{worth}: {}, interval {}",
                number::count(*count),
                number::count(*trials),
                number::percent(*count as f64 / *trials as f64),
                number::interval(*interval)
            )
        }
        Measure::Probability {
            answer, credible, ..
        } => {
            let spread = credible.as_ref().map(|c| c.interval);
            let spread = spread.filter(|interval| interval.low < interval.high);
            let spread = spread.map_or(String::new(), |interval| {
                format!(", credible {}", number::interval(interval))
            });
            format!(
                "{}{spread} ({})",
                number::answer(answer),
                number::guarantee(&answer.guarantee)
            )
        }
        Measure::NotExpressible { reason } => format!("not expressible: {reason}"),
        Measure::NotCovered { reason, .. } => format!("never covered: {reason}"),
        Measure::Counts { .. } => "never covered".to_owned(),
    }
}

/// Whether the measure is a number whose error is known.
pub fn has_known_error(measure: &Measure) -> bool {
    measure.estimate().is_some() && !has_no_bound(measure)
}

/// A comparison's outcome with its figures, as its reason states it.
pub fn compared(comparison: &Comparison) -> String {
    format!(
        "{} and {}: {}",
        comparison.left, comparison.right, comparison.reason
    )
}

/// The requirement as a claim.
pub fn claim(requirement: &Requirement) -> String {
    format!(
        "Requirement {} holds ({}): {}",
        requirement.id,
        asked(requirement),
        requirement.text
    )
}

/// The claim point of a requirement.
pub fn claim_point(requirement: &Requirement) -> String {
    format!("ACP-{}", identifier(&requirement.id))
}

/// How a solution names a piece of evidence, with the runs over which its figure is taken where these are not all.
pub fn cited(view: View, piece: &Evidence, finding: &Finding) -> String {
    let condition = view.condition(finding).filter(|_| finding.is_conditional());
    let condition = condition.map_or(String::new(), |words| format!("; {words}"));
    format!(
        "{} ({}): {}{condition}",
        piece.id,
        piece.technique.name(),
        figures(&finding.measure)
    )
}

/// The reference to a piece of evidence.
pub fn citation(piece: &Evidence) -> Citation {
    Citation {
        evidence: piece.id.clone(),
        inputs: piece.inputs.clone(),
    }
}

/// The subject under which a requirement's quantity was compared.
pub fn quantity(study: &StudyResult, requirement: &Requirement) -> Subject {
    let of = |id: &str| study.requirements.iter().find(|r| r.id == id);
    let mut id = &requirement.id;
    let mut next = requirement.same_quantity_as.as_ref();
    // As many steps as there are requirements, so that a circle ends.
    for _ in &study.requirements {
        let Some(other) = next else { break };
        id = other;
        next = of(other).and_then(|r| r.same_quantity_as.as_ref());
    }
    Subject::Requirement(id.clone())
}

/// The evidence on which a requirement's conclusion rests, with what it found.
pub fn rests_on<'a>(view: View<'a>, requirement: &Requirement) -> Vec<(&'a Evidence, &'a Finding)> {
    let study = view.study;
    let own = Subject::Requirement(requirement.id.clone());
    let quantity = quantity(study, requirement);
    let conclusion = study
        .conclusions
        .iter()
        .find(|c| c.requirement == requirement.id);
    let ids = conclusion.map_or(&[][..], |c| &c.rests_on);
    study
        .evidence
        .iter()
        .filter(|piece| ids.contains(&piece.id))
        .filter_map(|piece| {
            let finding = piece.finding(&own).or_else(|| piece.finding(&quantity))?;
            Some((piece, finding))
        })
        .collect()
}

/// Comparisons on a subject between two of the named pieces of evidence.
pub fn among<'a>(study: &'a StudyResult, subject: &Subject, ids: &[&str]) -> Vec<&'a Comparison> {
    let named = |id: &str| ids.contains(&id);
    study
        .comparisons
        .iter()
        .filter(|c| &c.subject == subject && named(&c.left) && named(&c.right))
        .collect()
}
