//! One piece of evidence by itself against the thresholds of requirements.
//!
//! # Definition
//! As in `conclude` with this piece alone (`k = 1`): a requirement is *satisfied* if the piece supports its threshold at the
//! level, *violated* if it denies it, *undecided* if it does neither, and *not covered* if it came up in no trial. Left
//! out are requirements without a threshold, of which trials alone never show the certainty that they ask for, and those
//! that the technique cannot express.
//!
//! # Assumes
//! As in [`super`], for one piece. Its size was fixed in advance: looks before are not allowed for.
//!
//! # Guarantee
//! Each verdict *satisfied* or *violated* is wrong with probability at most `1 - level`; they are not corrected for being
//! several.

use super::quantity;
use super::stand::{ClaimLevels, Named, doubts, stand, standing};
use super::words::hypothesis;
use crate::compare::Belief;
use crate::{Finding, Measure, Requirement, Standing, Step, Subject, Threshold, Verdict};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stats::Confidence;

/// What one piece of evidence shows of one requirement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Alone {
    /// The requirement's identifier.
    pub requirement: String,
    /// What it asks for.
    pub threshold: Threshold,
    /// What the piece shows of that.
    pub verdict: Verdict,
    /// Of what it shows it.
    #[serde(default)]
    pub step: Step,
    /// The same in a sentence, with figures.
    pub statement: String,
}

/// What the findings of a piece show of each requirement that has a threshold.
pub fn alone(
    (id, step): (&str, Step),
    requirements: &[Requirement],
    findings: &[Finding],
    level: Confidence,
) -> Vec<Alone> {
    let of = |subject: &Subject| findings.iter().find(|finding| finding.subject == *subject);
    let judged = requirements.iter().filter_map(|requirement| {
        let threshold = requirement.threshold?;
        let own = of(&Subject::Requirement(requirement.id.clone()));
        let finding = own.or_else(|| of(&quantity(requirements, requirement)))?;
        let (verdict, words) = match (&finding.measure, Belief::of_finding(finding)) {
            (Measure::NotExpressible { .. }, _) => return None,
            (_, Ok(belief)) => {
                let trigger = requirement.trigger.as_deref();
                let named = Named {
                    id,
                    step,
                    finding,
                    trigger,
                };
                let stand = stand(named, &belief, threshold, ClaimLevels::both(level));
                let verdict = match stand.standing {
                    Standing::Supports => Verdict::Satisfied,
                    Standing::Denies => Verdict::Violated,
                    Standing::Neither => Verdict::Undecided,
                };
                (verdict, stand.words)
            }
            (_, Err(reason)) => (Verdict::NotCovered, format!("{id} {reason}")),
        };
        Some(Alone {
            requirement: requirement.id.clone(),
            threshold,
            verdict,
            step,
            statement: format!("asked: {}; {words}", hypothesis(threshold, true)),
        })
    });
    judged.collect()
}

/// Whether a number shows by itself that a threshold is met (`true`) or missed (`false`), with a p-value of at most
/// `1 - level`, as conclusions take it at their only look; `None` if it shows neither.
pub fn shown(measure: &Measure, threshold: Threshold, level: Confidence) -> Option<bool> {
    let belief = Belief::of(measure).ok()?;
    let (p_not_met, p_met) = doubts(&belief, threshold);
    match standing(p_not_met, p_met, ClaimLevels::both(level)) {
        Standing::Supports => Some(true),
        Standing::Denies => Some(false),
        Standing::Neither => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Direction;
    use stats::Sample;

    fn requirement(id: &str, least: Option<f64>, same: Option<&str>) -> Requirement {
        Requirement {
            id: id.into(),
            text: String::new(),
            threshold: least.map(|value| Threshold {
                direction: Direction::AtLeast,
                value,
            }),
            sentence: None,
            property: None,
            monitor: None,
            margin: 0.05,
            asks_for: None,
            same_quantity_as: same.map(str::to_owned),
            ..Requirement::default()
        }
    }

    fn finding(id: &str, measure: Measure) -> Finding {
        Finding {
            subject: Subject::Requirement(id.into()),
            measure,
            denominator: crate::Denominator::default(),
            trigger: None,
            undecided: 0,
            left_out: 0,
            completions: None,
            witnesses: Vec::new(),
            readings: Vec::new(),
        }
    }

    #[test]
    fn each_threshold_is_judged_once_and_certainty_is_not_asked_of_trials() {
        let requirements = [
            requirement("1a", Some(0.95), None),
            requirement("1b", Some(0.6), Some("1a")),
            requirement("2", None, None),
            requirement("3", Some(0.9), None),
            requirement("4", Some(0.9), None),
            requirement("5", Some(0.86), Some("1a")),
        ];
        let sample = Sample::new(88, 100).expect("counts");
        let counted = Measure::of_counts(sample, None, Confidence::P95).expect("a measure");
        let reason = || "r".to_owned();
        let findings = [
            finding("1a", counted.clone()),
            finding("2", counted),
            finding(
                "3",
                Measure::NotCovered {
                    reason: reason(),
                    constant: None,
                },
            ),
            finding("4", Measure::NotExpressible { reason: reason() }),
        ];
        let judged = alone(
            ("E", Step::System),
            &requirements,
            &findings,
            Confidence::P95,
        );
        let verdicts: Vec<_> = judged
            .iter()
            .map(|it| (it.requirement.as_str(), it.verdict))
            .collect();
        let expected = [
            ("1a", Verdict::Violated),
            ("1b", Verdict::Satisfied),
            ("3", Verdict::NotCovered),
            ("5", Verdict::Undecided),
        ];
        assert_eq!(verdicts, expected);
        let words = "asked: rate >= 95 %; E: 88/100, rate <= 93 % (one-sided 95 % limit, p =";
        assert!(judged[0].statement.starts_with(words), "{judged:?}");
    }
}
