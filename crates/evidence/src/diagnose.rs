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
//! The conflicts on one subject are edges between pieces of evidence. They
//! are covered by as few pieces as a greedy search finds: the piece with most
//! conflicts is the odd one out, its conflicts are one discrepancy, and the
//! rest is searched again. Published evidence that other evidence reproduces
//! is spoken for by that evidence and takes part only against it.
//!
//! A conflict on a requirement that none of these explains is reported as
//! undetermined.
//!
//! # Guarantee
//! Every comparison with the outcome *conflicts* between evidence that takes
//! part is named in at least one discrepancy.

use crate::compare::words::p_value;
use crate::{
    Comparison, Discrepancy, Evidence, Finding, Guarantee, Inaccuracy, Measure, MethodAnswer,
    Outcome, Reading, Subject,
};
use std::collections::{BTreeMap, BTreeSet};

/// Answers of two methods may differ by rounding; below this distance from
/// the bounds nothing is reported.
const ROUNDING: f64 = 1e-12;

/// Explains the disagreements of a study, tools first, then requirement
/// models, then system models.
///
/// `evidence` is in the ledger's order; `comparisons` are its pairs; `alpha`
/// is the level of the tests (0.05 for a confidence of 0.95).
pub fn diagnose(evidence: &[Evidence], comparisons: &[Comparison], alpha: f64) -> Vec<Discrepancy> {
    let ledger = Ledger {
        evidence,
        conflicts: conflicts(evidence, comparisons),
        alpha,
    };
    let mut found = tool_inaccuracies(evidence);
    found.extend(ledger.requirement_inaccuracies());
    found.extend(ledger.missing_behaviour());
    found.extend(ledger.differing_rates());
    let conflicting = ledger.conflicting_requirements(&found);
    found.extend(conflicting);
    found
}

fn tool_inaccuracies(evidence: &[Evidence]) -> Vec<Discrepancy> {
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

/// The conflicts between pieces that take part, by subject in their order.
fn conflicts<'a>(evidence: &'a [Evidence], comparisons: &'a [Comparison]) -> Vec<&'a Comparison> {
    let spoken_for = |id: &str, other: &str| {
        let piece = evidence.iter().find(|e| e.id == id);
        piece.is_some_and(|e| e.reproduced_by.as_deref().is_some_and(|ours| ours != other))
    };
    comparisons
        .iter()
        .filter(|c| c.outcome == Outcome::Conflicts)
        .filter(|c| !spoken_for(&c.left, &c.right) && !spoken_for(&c.right, &c.left))
        .collect()
}

/// One piece of evidence with all that it conflicts with on a subject.
struct OddOneOut<'a> {
    subject: &'a Subject,
    id: &'a str,
    others: Vec<&'a str>,
    conflicts: Vec<&'a Comparison>,
}

struct Ledger<'a> {
    evidence: &'a [Evidence],
    conflicts: Vec<&'a Comparison>,
    alpha: f64,
}

impl<'a> Ledger<'a> {
    fn piece(&self, id: &str) -> Option<&'a Evidence> {
        self.evidence.iter().find(|e| e.id == id)
    }

    fn place(&self, id: &str) -> usize {
        self.evidence
            .iter()
            .position(|e| e.id == id)
            .unwrap_or(usize::MAX)
    }

    /// Covers the wanted conflicts on each subject by odd ones out.
    fn odd_ones_out(&self, wanted: impl Fn(&Comparison) -> bool) -> Vec<OddOneOut<'a>> {
        let mut subjects: Vec<&Subject> = Vec::new();
        for conflict in self.conflicts.iter().filter(|c| wanted(c)) {
            if !subjects.contains(&&conflict.subject) {
                subjects.push(&conflict.subject);
            }
        }
        let mut found = Vec::new();
        for subject in subjects {
            let mut left: Vec<&'a Comparison> = self
                .conflicts
                .iter()
                .copied()
                .filter(|c| &c.subject == subject && wanted(c))
                .collect();
            while let Some(odd) = self.oddest(subject, &left) {
                left.retain(|c| c.left != odd.id && c.right != odd.id);
                found.push(odd);
            }
        }
        found
    }

    /// The piece with most conflicts; of equals the earlier in the ledger.
    fn oddest(&self, subject: &'a Subject, conflicts: &[&'a Comparison]) -> Option<OddOneOut<'a>> {
        let mut count: BTreeMap<&'a str, usize> = BTreeMap::new();
        for conflict in conflicts {
            *count.entry(&conflict.left).or_default() += 1;
            *count.entry(&conflict.right).or_default() += 1;
        }
        let (id, _) = count
            .into_iter()
            .min_by_key(|(id, count)| (usize::MAX - count, self.place(id)))?;
        let conflicts: Vec<&'a Comparison> = conflicts
            .iter()
            .copied()
            .filter(|c| c.left == id || c.right == id)
            .collect();
        let others = conflicts
            .iter()
            .map(|c| {
                if c.left == id {
                    c.right.as_str()
                } else {
                    c.left.as_str()
                }
            })
            .collect();
        Some(OddOneOut {
            subject,
            id,
            others,
            conflicts,
        })
    }

    /// Later evidence of the same technique that none of the others conflicts
    /// with.
    fn mended_by(&self, odd: &OddOneOut) -> Option<String> {
        let piece = self.piece(odd.id)?;
        let conflicting = |id: &str| {
            self.conflicts.iter().any(|c| {
                &c.subject == odd.subject
                    && odd.others.iter().any(|other| {
                        *other != id
                            && ((c.left == id && c.right == *other)
                                || (c.right == id && c.left == *other))
                    })
            })
        };
        self.evidence
            .iter()
            .skip(self.place(odd.id) + 1)
            .filter(|e| e.technique == piece.technique && !e.intermediate && !e.published)
            .filter(|e| {
                e.finding(odd.subject)
                    .is_some_and(|f| f.measure.estimate().is_some())
            })
            .find(|e| !conflicting(&e.id))
            .map(|e| e.id.clone())
    }

    fn rates(&self, odd: &OddOneOut) -> String {
        let rate = |id: &str| {
            let finding = self.piece(id).and_then(|e| e.finding(odd.subject));
            match finding.map(|f| &f.measure) {
                Some(Measure::Counts { count, trials, .. }) => {
                    format!("{count} of {trials} in {id}")
                }
                Some(Measure::Probability { answer, .. }) => format!("{:.4} in {id}", answer.value),
                _ => format!("nothing in {id}"),
            }
        };
        let others: Vec<String> = odd.others.iter().map(|id| rate(id)).collect();
        format!("{} against {}.", rate(odd.id), others.join(", "))
    }

    fn witnesses(&self, odd: &OddOneOut) -> Vec<String> {
        let finding = self.piece(odd.id).and_then(|e| e.finding(odd.subject));
        finding.map_or_else(Vec::new, |f| f.witnesses.clone())
    }

    fn requirement_inaccuracies(&self) -> Vec<Discrepancy> {
        let mut merged: Vec<Discrepancy> = Vec::new();
        for piece in self.evidence.iter().filter(|e| !e.intermediate) {
            for finding in &piece.findings {
                for reading in finding.readings.iter().filter(|r| r.differing > 0) {
                    let one = self.requirement_inaccuracy(piece, finding, reading);
                    match merged
                        .iter_mut()
                        .find(|d| d.subjects == one.subjects && d.proposal == one.proposal)
                    {
                        Some(same) => merge(same, one),
                        None => merged.push(one),
                    }
                }
            }
        }
        merged.sort_by_key(|d| d.evidence.len() < 2);
        merged
    }

    fn requirement_inaccuracy(
        &self,
        piece: &Evidence,
        finding: &Finding,
        reading: &Reading,
    ) -> Discrepancy {
        let requirement = finding.subject.id();
        let mut explanation = format!(
            "On the same traces of {}, {}; the verdicts differ on {} runs.",
            piece.id,
            readings_in_words(finding, reading),
            reading.differing
        );
        let mut touched = BTreeSet::from([piece.id.clone()]);
        for other in self.in_conflict_with(&finding.subject, &piece.id) {
            if let Some((sentence, is_gone)) = self.explains(finding, reading, other) {
                explanation.push(' ');
                explanation.push_str(&sentence);
                if is_gone {
                    touched.insert(other.to_owned());
                }
            }
        }
        let meaning = reading.meaning.trim_end_matches('.');
        Discrepancy {
            inaccuracy: Inaccuracy::RequirementModel,
            title: if touched.len() > 1 {
                format!(
                    "Requirement {requirement} conflicts because of what its monitor reads; {}, it does not",
                    in_lower_case(meaning)
                )
            } else {
                format!("Requirement {requirement} has two readings with different verdicts")
            },
            explanation,
            subjects: vec![finding.subject.clone()],
            evidence: touched.into_iter().collect(),
            witnesses: reading
                .witnesses
                .iter()
                .map(|w| format!("{} {w}", piece.id))
                .collect(),
            resolved_by: None,
            proposal: Some(format!(
                "Decide which reading is meant. The reading `{}`: {meaning}.",
                reading.name
            )),
        }
    }

    /// Whether the other reading removes the conflict with `other`, in words
    /// and as a fact.
    fn explains(
        &self,
        finding: &Finding,
        reading: &Reading,
        other: &str,
    ) -> Option<(String, bool)> {
        let other_finding = self.piece(other)?.finding(&finding.subject)?;
        let ours = stats::Sample::new(reading.count, reading.trials).ok()?;
        let (theirs, p, test) = match &other_finding.measure {
            Measure::Counts { count, trials, .. } => {
                let sample = stats::Sample::new(*count, *trials).ok()?;
                let words = format!("{count} of {trials}");
                (
                    words,
                    stats::fisher_exact(ours, sample),
                    "Fisher's exact test",
                )
            }
            Measure::Probability { answer, .. } => {
                let p = stats::binomial_test_two_sided(ours, answer.value);
                (format!("{:.4}", answer.value), p, "exact binomial test")
            }
            _ => return None,
        };
        let is_gone = p >= self.alpha;
        let verdict = if is_gone {
            "the conflict is gone"
        } else {
            "they still differ"
        };
        let p = p_value(p);
        let sentence =
            format!("Against {other}'s {theirs}, {verdict} under that reading ({test}, p {p}).");
        Some((sentence, is_gone))
    }

    fn in_conflict_with(&self, subject: &Subject, id: &str) -> Vec<&'a str> {
        self.conflicts
            .iter()
            .filter(|c| &c.subject == subject)
            .filter_map(|c| match (c.left == id, c.right == id) {
                (true, _) => Some(c.right.as_str()),
                (_, true) => Some(c.left.as_str()),
                _ => None,
            })
            .collect()
    }

    fn differing_rates(&self) -> Vec<Discrepancy> {
        self.odd_ones_out(|c| matches!(c.subject, Subject::FailureMode(_)))
            .iter()
            .map(|odd| Discrepancy {
                inaccuracy: Inaccuracy::SystemModel,
                title: format!("{} differs in {}", odd.id, name_of(odd.subject)),
                explanation: format!("{} {}", self.rates(odd), reasons(odd)),
                subjects: vec![odd.subject.clone()],
                evidence: pieces(odd),
                witnesses: self.witnesses(odd),
                resolved_by: self.mended_by(odd),
                proposal: Some(format!(
                    "Look at what decides {} in the system model of {}.",
                    name_of(odd.subject),
                    odd.id
                )),
            })
            .collect()
    }

    /// Failure modes that occur in some evidence and that a model of the
    /// ledger cannot express.
    fn missing_behaviour(&self) -> Vec<Discrepancy> {
        let mut found = Vec::new();
        for piece in self.evidence.iter().filter(|e| !e.intermediate) {
            for finding in &piece.findings {
                let (Subject::FailureMode(_), Measure::NotExpressible { reason }) =
                    (&finding.subject, &finding.measure)
                else {
                    continue;
                };
                let shown = self.shown_by(&finding.subject);
                if !shown.is_empty() {
                    found.push(self.missing(piece, &finding.subject, &shown, reason));
                }
            }
        }
        found
    }

    fn missing(
        &self,
        piece: &Evidence,
        subject: &Subject,
        shown: &[String],
        reason: &str,
    ) -> Discrepancy {
        let resolved = self
            .evidence
            .iter()
            .skip(self.place(&piece.id) + 1)
            .filter(|e| e.technique == piece.technique && !e.intermediate)
            .find(|e| {
                e.finding(subject)
                    .is_some_and(|f| f.measure.estimate().is_some())
            });
        Discrepancy {
            inaccuracy: Inaccuracy::SystemModel,
            title: format!("{} does not know {}", piece.id, name_of(subject)),
            explanation: format!("It occurs: {}. {reason}", shown.join(", ")),
            subjects: vec![subject.clone()],
            evidence: vec![piece.id.clone()],
            witnesses: Vec::new(),
            resolved_by: resolved.map(|e| e.id.clone()),
            proposal: Some(format!("Add {} to the system model.", name_of(subject))),
        }
    }

    fn shown_by(&self, subject: &Subject) -> Vec<String> {
        self.evidence
            .iter()
            .filter_map(|e| match e.finding(subject)?.measure {
                Measure::Counts { count, trials, .. } if count > 0 => {
                    Some(format!("{count} of {trials} in {}", e.id))
                }
                _ => None,
            })
            .collect()
    }

    /// Conflicts on requirements, but for those that a reading explains.
    fn conflicting_requirements(&self, found: &[Discrepancy]) -> Vec<Discrepancy> {
        self.odd_ones_out(|c| {
            matches!(c.subject, Subject::Requirement(_)) && !self.is_explained_by_reading(c)
        })
        .iter()
        .map(|odd| self.conflicting_requirement(odd, found))
        .collect()
    }

    /// Whether another reading of the requirement, on the traces of one side,
    /// removes the conflict with the other side.
    fn is_explained_by_reading(&self, conflict: &Comparison) -> bool {
        let (left, right) = (&conflict.left, &conflict.right);
        [(left, right), (right, left)]
            .into_iter()
            .any(|(id, other)| {
                let finding = self.piece(id).and_then(|e| e.finding(&conflict.subject));
                finding.is_some_and(|finding| {
                    finding.readings.iter().any(|reading| {
                        self.explains(finding, reading, other)
                            .is_some_and(|(_, is_gone)| is_gone)
                    })
                })
            })
    }

    fn conflicting_requirement(&self, odd: &OddOneOut, found: &[Discrepancy]) -> Discrepancy {
        // A conflict on a rate of success is the sum of what the failure modes do.
        let causes: Vec<&str> = found
            .iter()
            .filter(|d| d.inaccuracy == Inaccuracy::SystemModel)
            .filter(|d| d.evidence.first().is_some_and(|id| id == odd.id))
            .map(|d| d.title.as_str())
            .collect();
        let (inaccuracy, cause) = if causes.is_empty() {
            let unknown = "No other method, reading or failure mode at hand separates the cause.";
            (Inaccuracy::Undetermined, unknown.to_owned())
        } else {
            (
                Inaccuracy::SystemModel,
                format!("One level down: {}.", causes.join("; ")),
            )
        };
        Discrepancy {
            inaccuracy,
            title: format!(
                "{} conflicts with {} on {}",
                odd.id,
                odd.others.join(", "),
                name_of(odd.subject)
            ),
            explanation: format!("{} {} {cause}", self.rates(odd), reasons(odd)),
            subjects: vec![odd.subject.clone()],
            evidence: pieces(odd),
            witnesses: self.witnesses(odd),
            resolved_by: self.mended_by(odd),
            proposal: None,
        }
    }
}

fn merge(into: &mut Discrepancy, other: Discrepancy) {
    into.explanation.push(' ');
    into.explanation.push_str(&other.explanation);
    let conflicting = other.evidence.len() > 1;
    for id in other.evidence {
        if !into.evidence.contains(&id) {
            into.evidence.push(id);
        }
    }
    into.witnesses.extend(other.witnesses);
    if conflicting {
        into.title = other.title;
    }
}

fn readings_in_words(finding: &Finding, reading: &Reading) -> String {
    let main = match &finding.measure {
        Measure::Counts { count, trials, .. } => format!("{count} of {trials} runs pass"),
        _ => "no run is covered".to_owned(),
    };
    format!(
        "{main} as the monitor reads the requirement, and {} of {} under the reading `{}`",
        reading.count, reading.trials, reading.name
    )
}

/// A sentence as part of another.
fn in_lower_case(sentence: &str) -> String {
    let mut letters = sentence.chars();
    match letters.next() {
        Some(first) => first.to_lowercase().chain(letters).collect(),
        None => String::new(),
    }
}

fn name_of(subject: &Subject) -> String {
    match subject {
        Subject::Requirement(id) => format!("requirement {id}"),
        Subject::FailureMode(id) => id.replace('_', " "),
    }
}

fn pieces(odd: &OddOneOut) -> Vec<String> {
    std::iter::once(odd.id)
        .chain(odd.others.iter().copied())
        .map(str::to_owned)
        .collect()
}

/// The reasons of the conflicts, each once.
fn reasons(odd: &OddOneOut) -> String {
    let mut reasons: Vec<&str> = Vec::new();
    for conflict in &odd.conflicts {
        let reason = conflict.reason.as_str();
        if !reasons.contains(&reason) {
            reasons.push(reason);
        }
    }
    match reasons.as_slice() {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [first, _] => format!("{first} Likewise the other."),
        [first, rest @ ..] => format!("{first} Likewise the {} others.", rest.len()),
    }
}
