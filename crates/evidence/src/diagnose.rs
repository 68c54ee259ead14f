//! Diagnosis: for each disagreement, which asset is to blame.
//!
//! # Definition
//! Webster et al. (2020, section 2.3) name three sources of disagreement:
//! the system model, the requirement model and the tool. They are separated
//! by what differs while all else is the same:
//!
//! * *tool*: one model, one property, two methods. If an answer without a
//!   bound lies outside the bounds of another method, it is wrong by at least
//!   that distance.
//! * *requirement model*: one set of traces, two readings of the requirement.
//!   Every trace with two verdicts is a witness. If two pieces of evidence
//!   conflict under the main reading and not under the other, the reading
//!   explains the conflict.
//! * *system model*: a failure mode whose rates conflict, or that one asset
//!   cannot express although others show it.
//!
//! A conflict on a requirement that none of these explains is reported as
//! undetermined, so that no conflict goes unmentioned.
//!
//! # Guarantee
//! Every comparison with the outcome *conflicts* between evidence that is not
//! intermediate is named in at least one discrepancy.

use crate::{
    Comparison, Discrepancy, Evidence, Finding, Guarantee, Inaccuracy, Measure, MethodAnswer,
    Outcome, Reading, Subject,
};
use std::collections::BTreeSet;

/// Answers of two methods may differ by rounding; below this distance from
/// the bounds nothing is reported.
const ROUNDING: f64 = 1e-12;

/// Explains the disagreements of a study, tools first, then requirement
/// models, then system models.
///
/// `evidence` is in the ledger's order; `comparisons` are its pairs; `alpha`
/// is the level of the tests (0.05 for a confidence of 0.95).
pub fn diagnose(evidence: &[Evidence], comparisons: &[Comparison], alpha: f64) -> Vec<Discrepancy> {
    let mut found = tool_inaccuracies(evidence);
    found.extend(requirement_inaccuracies(evidence, comparisons, alpha));
    found.extend(system_inaccuracies(evidence, comparisons));
    found.extend(missing_behaviour(evidence));
    let unexplained = unexplained(comparisons, &found);
    found.extend(unexplained);
    found
}

fn tool_inaccuracies(evidence: &[Evidence]) -> Vec<Discrepancy> {
    let mut found: Vec<Discrepancy> = Vec::new();
    for piece in evidence {
        for finding in &piece.findings {
            let Measure::Probability { answer, others, .. } = &finding.measure else {
                continue;
            };
            for other in others {
                let Some(distance) = distance_from_bounds(answer, other) else {
                    continue;
                };
                let title = format!(
                    "{}'s {} is where the solver stopped, not a probability",
                    piece.id, other.value
                );
                match found.iter_mut().find(|d| d.title == title) {
                    Some(same) => same.subjects.push(finding.subject.clone()),
                    None => found.push(tool_inaccuracy(
                        piece, finding, answer, other, distance, title,
                    )),
                }
            }
        }
    }
    found
}

/// How far an answer lies outside the bounds of a sound one, if it does.
fn distance_from_bounds(sound: &MethodAnswer, other: &MethodAnswer) -> Option<f64> {
    let (low, high) = match &sound.guarantee {
        Guarantee::Exact { .. } => (sound.value, sound.value),
        Guarantee::Bounded { low, high } => (*low, *high),
        Guarantee::Estimated { .. } => return None,
    };
    let distance = (low - other.value).max(other.value - high);
    let estimated = matches!(other.guarantee, Guarantee::Estimated { .. });
    (estimated && distance > ROUNDING).then_some(distance)
}

fn tool_inaccuracy(
    piece: &Evidence,
    finding: &Finding,
    sound: &MethodAnswer,
    other: &MethodAnswer,
    distance: f64,
    title: String,
) -> Discrepancy {
    let stopped = match &other.guarantee {
        Guarantee::Estimated { reason } => format!(" ({reason})"),
        _ => String::new(),
    };
    let truth = match sound.complement {
        Some(rest) if rest > 0.0 && rest < 1e-6 => format!("1 - {rest:.3e}"),
        _ => format!("{}", sound.value),
    };
    Discrepancy {
        inaccuracy: Inaccuracy::Tool,
        title,
        explanation: format!(
            "The method `{}` answers {}{stopped}. The method `{}` answers {truth} on the same model and property, \
             with bounds that hold. The difference of at least {distance:.2e} says nothing about the robot: \
             it is the error of the iteration when it stopped.",
            other.method, other.value, sound.method
        ),
        subjects: vec![finding.subject.clone()],
        evidence: vec![piece.id.clone()],
        witnesses: Vec::new(),
        resolved_by: None,
        proposal: Some(format!(
            "Report the answer of the method `{}`.",
            sound.method
        )),
    }
}

fn requirement_inaccuracies(
    evidence: &[Evidence],
    comparisons: &[Comparison],
    alpha: f64,
) -> Vec<Discrepancy> {
    let mut found = Vec::new();
    for piece in evidence.iter().filter(|e| !e.intermediate) {
        for finding in &piece.findings {
            for reading in finding.readings.iter().filter(|r| r.differing > 0) {
                let conflicts = conflicts_of(comparisons, &finding.subject, &piece.id);
                found.push(requirement_inaccuracy(
                    evidence, piece, finding, reading, &conflicts, alpha,
                ));
            }
        }
    }
    found
}

fn requirement_inaccuracy(
    evidence: &[Evidence],
    piece: &Evidence,
    finding: &Finding,
    reading: &Reading,
    conflicts: &[&str],
    alpha: f64,
) -> Discrepancy {
    let requirement = finding.subject.id();
    let mut explanation = format!(
        "On the same traces of {}, {}. The verdicts differ on {} runs.",
        piece.id,
        readings_in_words(finding, reading),
        reading.differing
    );
    let mut touched = vec![piece.id.clone()];
    for other in conflicts {
        if let Some(sentence) = explains(evidence, finding, reading, other, alpha) {
            explanation.push(' ');
            explanation.push_str(&sentence);
            touched.push((*other).to_owned());
        }
    }
    let conflicting = touched.len() > 1;
    Discrepancy {
        inaccuracy: Inaccuracy::RequirementModel,
        title: if conflicting {
            format!("Requirement {requirement} conflicts because of how its monitor reads the text")
        } else {
            format!("Requirement {requirement} has two readings with different verdicts")
        },
        explanation,
        subjects: vec![finding.subject.clone()],
        evidence: touched,
        witnesses: reading.witnesses.clone(),
        resolved_by: None,
        proposal: Some(format!(
            "Decide which reading is meant; `{}`: {}",
            reading.name, reading.meaning
        )),
    }
}

fn readings_in_words(finding: &Finding, reading: &Reading) -> String {
    let main = match &finding.measure {
        Measure::Counts { count, trials, .. } => format!("{count} of {trials} runs pass"),
        _ => "no run is covered".to_owned(),
    };
    format!(
        "{main} as the monitor reads the requirement, and {} of {} under the reading `{}` ({})",
        reading.count,
        reading.trials,
        reading.name,
        reading.meaning.trim_end_matches('.')
    )
}

/// Says whether the other reading removes the conflict with `other`.
fn explains(
    evidence: &[Evidence],
    finding: &Finding,
    reading: &Reading,
    other: &str,
    alpha: f64,
) -> Option<String> {
    let other_finding = evidence
        .iter()
        .find(|e| e.id == other)?
        .finding(&finding.subject)?;
    let Measure::Counts { count, trials, .. } = other_finding.measure else {
        return None;
    };
    let ours = stats::Sample::new(reading.count, reading.trials).ok()?;
    let theirs = stats::Sample::new(count, trials).ok()?;
    let p = stats::fisher_exact(ours, theirs);
    let verdict = if p >= alpha {
        "the conflict is gone"
    } else {
        "they still differ"
    };
    Some(format!(
        "Under that reading and {other}'s {count} of {trials}, {verdict} (Fisher's exact test, p = {p:.2})."
    ))
}

fn system_inaccuracies(evidence: &[Evidence], comparisons: &[Comparison]) -> Vec<Discrepancy> {
    comparisons
        .iter()
        .filter(|c| c.outcome == Outcome::Conflicts)
        .filter(|c| matches!(c.subject, Subject::FailureMode(_)))
        .map(|c| Discrepancy {
            inaccuracy: Inaccuracy::SystemModel,
            title: format!(
                "{} and {} differ in {}",
                c.left,
                c.right,
                c.subject.id().replace('_', " ")
            ),
            explanation: format!("{} {}", rates_in_words(evidence, c), c.reason),
            subjects: vec![c.subject.clone()],
            evidence: vec![c.left.clone(), c.right.clone()],
            witnesses: witnesses(evidence, c),
            resolved_by: mended_by(evidence, comparisons, c),
            proposal: Some(format!(
                "Look at what decides {} in the asset that is further from the experiments.",
                c.subject.id().replace('_', " ")
            )),
        })
        .collect()
}

fn rates_in_words(evidence: &[Evidence], comparison: &Comparison) -> String {
    let rate = |id: &str| {
        let measure = evidence
            .iter()
            .find(|e| e.id == id)
            .and_then(|e| e.finding(&comparison.subject))
            .map(|f| &f.measure);
        match measure {
            Some(Measure::Counts { count, trials, .. }) => format!("{count} of {trials} in {id}"),
            Some(Measure::Probability { answer, .. }) => format!("{:.4} in {id}", answer.value),
            _ => format!("nothing in {id}"),
        }
    };
    format!("{}, {}.", rate(&comparison.left), rate(&comparison.right))
}

fn witnesses(evidence: &[Evidence], comparison: &Comparison) -> Vec<String> {
    [&comparison.left, &comparison.right]
        .into_iter()
        .filter_map(|id| evidence.iter().find(|e| &e.id == id))
        .filter_map(|e| e.finding(&comparison.subject))
        .flat_map(|f| f.witnesses.iter().take(3).cloned())
        .collect()
}

/// Later evidence of the same technique as one side that no longer conflicts
/// with the other side on the subject.
fn mended_by(
    evidence: &[Evidence],
    comparisons: &[Comparison],
    conflict: &Comparison,
) -> Option<String> {
    let place = |id: &str| evidence.iter().position(|e| e.id == id);
    [
        (&conflict.left, &conflict.right),
        (&conflict.right, &conflict.left),
    ]
    .into_iter()
    .filter_map(|(mended, kept)| {
        let from = place(mended)?;
        evidence[from + 1..]
            .iter()
            .filter(|e| e.technique == evidence[from].technique)
            .filter(|e| !e.intermediate && !e.published && &e.id != kept)
            .find(|e| {
                comparisons.iter().any(|c| {
                    c.subject == conflict.subject
                        && is_pair(c, &e.id, kept)
                        && matches!(c.outcome, Outcome::Corroborates | Outcome::Inconclusive)
                })
            })
    })
    .map(|e| e.id.clone())
    .next()
}

fn is_pair(comparison: &Comparison, one: &str, other: &str) -> bool {
    (comparison.left == one && comparison.right == other)
        || (comparison.left == other && comparison.right == one)
}

/// Failure modes that occur in some evidence and that a formal model of the
/// ledger cannot express.
fn missing_behaviour(evidence: &[Evidence]) -> Vec<Discrepancy> {
    let mut found = Vec::new();
    for piece in evidence.iter().filter(|e| !e.intermediate) {
        for finding in &piece.findings {
            let (Subject::FailureMode(mode), Measure::NotExpressible { reason }) =
                (&finding.subject, &finding.measure)
            else {
                continue;
            };
            let shown = shown_by(evidence, &finding.subject);
            if shown.is_empty() {
                continue;
            }
            let later = evidence.iter().skip_while(|e| e.id != piece.id).skip(1);
            let resolved = later
                .filter(|e| e.technique == piece.technique && !e.intermediate)
                .find(|e| {
                    e.finding(&finding.subject)
                        .is_some_and(|f| f.measure.estimate().is_some())
                });
            found.push(Discrepancy {
                inaccuracy: Inaccuracy::SystemModel,
                title: format!("{} does not know {}", piece.id, mode.replace('_', " ")),
                explanation: format!("It occurs: {}. {reason}", shown.join(", ")),
                subjects: vec![finding.subject.clone()],
                evidence: vec![piece.id.clone()],
                witnesses: Vec::new(),
                resolved_by: resolved.map(|e| e.id.clone()),
                proposal: Some("Add the event to the system model.".into()),
            });
        }
    }
    found
}

fn shown_by(evidence: &[Evidence], subject: &Subject) -> Vec<String> {
    evidence
        .iter()
        .filter_map(|e| match e.finding(subject)?.measure {
            Measure::Counts { count, trials, .. } if count > 0 => {
                Some(format!("{count} of {trials} in {}", e.id))
            }
            _ => None,
        })
        .collect()
}

/// The evidence that conflicts with `id` on a subject.
fn conflicts_of<'a>(comparisons: &'a [Comparison], subject: &Subject, id: &str) -> Vec<&'a str> {
    comparisons
        .iter()
        .filter(|c| c.outcome == Outcome::Conflicts && &c.subject == subject)
        .filter_map(|c| match (c.left == id, c.right == id) {
            (true, _) => Some(c.right.as_str()),
            (_, true) => Some(c.left.as_str()),
            _ => None,
        })
        .collect()
}

/// Conflicts on requirements that no discrepancy found so far speaks of.
fn unexplained(comparisons: &[Comparison], found: &[Discrepancy]) -> Vec<Discrepancy> {
    let explained: BTreeSet<(&Subject, &str, &str)> = comparisons
        .iter()
        .filter(|c| {
            found.iter().any(|d| {
                d.subjects.contains(&c.subject)
                    && d.evidence.contains(&c.left)
                    && d.evidence.contains(&c.right)
            })
        })
        .map(|c| (&c.subject, c.left.as_str(), c.right.as_str()))
        .collect();
    comparisons
        .iter()
        .filter(|c| c.outcome == Outcome::Conflicts)
        .filter(|c| !explained.contains(&(&c.subject, c.left.as_str(), c.right.as_str())))
        .map(|c| unexplained_conflict(c, found))
        .collect()
}

fn unexplained_conflict(conflict: &Comparison, found: &[Discrepancy]) -> Discrepancy {
    // A conflict on a rate of success is the sum of what the failure modes do.
    let causes: Vec<String> = found
        .iter()
        .filter(|d| d.inaccuracy == Inaccuracy::SystemModel)
        .filter(|d| d.evidence.contains(&conflict.left) || d.evidence.contains(&conflict.right))
        .filter(|d| {
            d.evidence
                .iter()
                .all(|id| id == &conflict.left || id == &conflict.right)
        })
        .map(|d| d.title.clone())
        .collect();
    let (inaccuracy, cause) = if causes.is_empty() {
        (
            Inaccuracy::Undetermined,
            "No other method, reading or failure mode at hand separates the cause.".to_owned(),
        )
    } else {
        (
            Inaccuracy::SystemModel,
            format!("One level down: {}.", causes.join("; ")),
        )
    };
    Discrepancy {
        inaccuracy,
        title: format!(
            "{} and {} conflict on requirement {}",
            conflict.left,
            conflict.right,
            conflict.subject.id()
        ),
        explanation: format!("{} {cause}", conflict.reason),
        subjects: vec![conflict.subject.clone()],
        evidence: vec![conflict.left.clone(), conflict.right.clone()],
        witnesses: Vec::new(),
        resolved_by: None,
        proposal: None,
    }
}
