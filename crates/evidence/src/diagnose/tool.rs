//! Tools to blame: one model, one property, two methods whose answers cannot both be right.
//!
//! An answer without a bound that lies outside the bounds of another method is wrong by at least
//! that distance. Cost: linear in the answers. Guarantee: no claim rests on an estimate, only on
//! bounds that hold.

use super::name_of;
use crate::{Discrepancy, Evidence, Guarantee, Inaccuracy, Measure, MethodAnswer, Subject};
use std::collections::BTreeMap;

/// Answers of two methods may differ by rounding; below this distance from
/// the bounds nothing is reported.
const ROUNDING: f64 = 1e-12;

pub(super) fn tool_inaccuracies(evidence: &[Evidence]) -> Vec<Discrepancy> {
    let mut found = Vec::new();
    for piece in evidence {
        let mut by_method: BTreeMap<&str, Vec<Stopped>> = BTreeMap::new();
        for finding in &piece.findings {
            let Measure::Probability { answer, others, .. } = &finding.measure else {
                continue;
            };
            for other in others {
                if let Some(distance) = distance_from_bounds(answer, other) {
                    by_method.entry(&other.method).or_default().push(Stopped {
                        subject: &finding.subject,
                        sound: answer,
                        other,
                        distance,
                    });
                }
            }
        }
        found.extend(
            by_method
                .values()
                .filter_map(|all| tool_inaccuracy(piece, all)),
        );
    }
    found
}

/// An answer that lies outside the bounds of a sound one.
struct Stopped<'a> {
    subject: &'a Subject,
    sound: &'a MethodAnswer,
    other: &'a MethodAnswer,
    distance: f64,
}

/// How far an answer lies outside the bounds of a sound one, if it does.
pub(super) fn distance_from_bounds(sound: &MethodAnswer, other: &MethodAnswer) -> Option<f64> {
    let (low, high) = match &sound.guarantee {
        Guarantee::Exact { .. } => (sound.value, sound.value),
        Guarantee::Bounded { low, high } => (*low, *high),
        Guarantee::Estimated { .. } => return None,
    };
    let distance = (low - other.value).max(other.value - high);
    let estimated = matches!(other.guarantee, Guarantee::Estimated { .. });
    (estimated && distance > ROUNDING).then_some(distance)
}

fn tool_inaccuracy(piece: &Evidence, all: &[Stopped]) -> Option<Discrepancy> {
    let first = all.first()?;
    let (sound, other) = (first.sound, first.other);
    let stopped = match &other.guarantee {
        Guarantee::Estimated { reason } => format!(" ({reason})"),
        _ => String::new(),
    };
    let truth = match sound.complement {
        Some(rest) if rest > 0.0 && rest < 1e-6 => format!("1 - {rest:.3e}"),
        _ => format!("{}", sound.value),
    };
    let subjects: Vec<Subject> = all.iter().map(|s| s.subject.clone()).collect();
    let rest = match subjects.len() {
        1 => String::new(),
        n => format!(" So it is with {n} subjects of {}.", piece.id),
    };
    Some(Discrepancy {
        inaccuracy: Inaccuracy::Tool,
        title: format!(
            "{}'s {} is where the solver stopped, not a probability",
            piece.id, other.value
        ),
        explanation: format!(
            "For {}, the method `{}` answers {}{stopped}. The method `{}` answers {truth} on the same model \
             and property, with bounds that hold. The difference of at least {:.2e} says nothing about the \
             robot: it is the error of the iteration when it stopped.{rest}",
            name_of(first.subject),
            other.method,
            other.value,
            sound.method,
            first.distance
        ),
        subjects,
        evidence: vec![piece.id.clone()],
        witnesses: Vec::new(),
        // The answer that counts in this evidence is that of the sound method.
        resolved_by: Some(piece.id.clone()),
        proposal: Some(format!(
            "Report the answer of the method `{}`.",
            sound.method
        )),
    })
}
