//! All pieces of evidence on a subject at once: do they agree, and which pairs tell otherwise?
//!
//! # Definition
//! The pieces on one subject that are neither intermediate nor reproduced by another, under the
//! conditions that most of them share, are looked at together. The outcome of the whole is
//!
//! * *conflicts* when a pair among them conflicts;
//! * *corroborates* when every pair among them does (then every difference lies within the margin,
//!   without further correction: the intersection of the claims is claimed only if each is shown);
//! * *not comparable* with fewer than two pieces, *inconclusive* else.
//!
//! Beside it stands the test of homogeneity of the rates that are uncertain: Cochran's Q against one common rate,
//! corrected by Holm over the study's subjects. It says that some rates differ, not by how much nor which, so it decides
//! no outcome: several rates that differ beyond chance within the margin are no conflict, and a rate that is known
//! exactly has no part in it.
//!
//! # Source
//! W. G. Cochran (1954); R. L. Berger, "Multiparameter hypothesis testing and acceptance sampling"
//! (1982), for the intersection. Distributions of computed probabilities enter at the counts of
//! their beta distribution; probabilities that are known exactly only in pairs.
//!
//! # Assumes
//! As for pairs. Q takes the pieces as independent of each other and their log-odds as normal.
//!
//! # Guarantee
//! As for pairs: a conflict of equal rates anywhere in the study has probability at most `1 - c`, and agreement is
//! claimed falsely with probability at most `1 - g`. The level of Q is asymptotic.

use super::{Belief, Study};
use crate::{Comparison, Evidence, Interval, Outcome, Subject};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stats::{Confidence, EffectiveSample};
use std::collections::BTreeMap;

/// All pieces of evidence on one subject, compared at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Together {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// The pieces, in the ledger's order.
    pub evidence: Vec<String>,
    /// What they show together.
    pub outcome: Outcome,
    /// `true` if no pair among them rests on common counts.
    pub independent: bool,
    /// The test of homogeneity of the rates that are uncertain, which decides no outcome; `None` with fewer than two.
    pub heterogeneity: Option<Spreading>,
    /// How many pairs have each outcome: corroborate, conflict, inconclusive.
    pub pairs: [usize; 3],
}

/// How far the rates of several pieces differ beyond chance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spreading {
    /// Cochran's Q.
    pub statistic: f64,
    /// Its degrees of freedom.
    pub degrees: u64,
    /// p-value of "one common rate".
    pub p_value: f64,
    /// The same after Holm's correction over the subjects.
    pub p_corrected: f64,
    /// The share of the variation that is beyond chance, 0 to 1.
    pub i_squared: f64,
    /// The common rate, if there is one, with its interval at the study's level.
    pub common_rate: f64,
    /// Interval of the common rate.
    pub common_interval: Interval,
}

/// Compares all pieces of evidence on each subject at once, in the order of subjects.
///
/// `comparisons` are those of [`crate::compare()`] on the same study.
pub fn compare_together(study: &Study<'_>, comparisons: &[Comparison]) -> Vec<Together> {
    let mut found: Vec<Together> = study
        .subjects()
        .into_iter()
        .map(|(subject, _)| together(study, comparisons, subject))
        .collect();
    let raw: Vec<f64> = found
        .iter()
        .filter_map(|one| Some(one.heterogeneity.as_ref()?.p_value))
        .collect();
    let mut corrected = stats::holm(&raw).into_iter();
    for one in &mut found {
        if let Some(spreading) = &mut one.heterogeneity {
            spreading.p_corrected = corrected.next().unwrap_or(spreading.p_value);
        }
        one.outcome = outcome(one.pairs);
    }
    found
}

fn outcome(pairs: [usize; 3]) -> Outcome {
    let [agree, conflict, _] = pairs;
    let all: usize = pairs.iter().sum();
    if all == 0 {
        Outcome::NotComparable
    } else if agree == all {
        Outcome::Corroborates
    } else if conflict > 0 {
        Outcome::Conflicts
    } else {
        Outcome::Inconclusive
    }
}

fn together(study: &Study<'_>, comparisons: &[Comparison], subject: Subject) -> Together {
    let pieces = pieces(study.evidence, &subject);
    let is_among = |id: &str| pieces.iter().any(|(piece, _)| piece.id == id);
    let among: Vec<&Comparison> = comparisons
        .iter()
        .filter(|c| c.subject == subject && is_among(&c.left) && is_among(&c.right))
        .collect();
    let count = |wanted| among.iter().filter(|c| c.outcome == wanted).count();
    Together {
        evidence: pieces.iter().map(|(piece, _)| piece.id.clone()).collect(),
        outcome: Outcome::NotComparable,
        independent: among.iter().all(|c| c.independent),
        heterogeneity: spreading(&pieces, study.levels.confidence),
        pairs: [
            Outcome::Corroborates,
            Outcome::Conflicts,
            Outcome::Inconclusive,
        ]
        .map(count),
        subject,
    }
}

/// The pieces that have a number on the subject, under the conditions that most of them share.
fn pieces<'a>(evidence: &'a [Evidence], subject: &Subject) -> Vec<(&'a Evidence, Belief)> {
    let mut by_conditions: BTreeMap<&str, Vec<(&Evidence, Belief)>> = BTreeMap::new();
    for piece in evidence {
        let belief = piece
            .finding(subject)
            .and_then(|f| Belief::of_piece(piece, f).ok());
        if let (Some(belief), false, None) = (belief, piece.intermediate, &piece.reproduced_by) {
            by_conditions
                .entry(&piece.conditions)
                .or_default()
                .push((piece, belief));
        }
    }
    let most = by_conditions.into_values().max_by_key(Vec::len);
    most.unwrap_or_default()
}

fn spreading(pieces: &[(&Evidence, Belief)], confidence: Confidence) -> Option<Spreading> {
    let samples: Vec<EffectiveSample> = pieces
        .iter()
        // Rates that are known up to runs without a verdict may be one where those that are counted are not.
        .filter(|(_, b)| !b.has_undecided())
        .filter_map(|(_, b)| b.worth_in_counts())
        .collect();
    let found = stats::heterogeneity(&samples).ok()?;
    let interval = found.fixed.interval(confidence);
    Some(Spreading {
        statistic: found.statistic,
        degrees: found.degrees as u64,
        p_value: found.p_value,
        p_corrected: found.p_value,
        i_squared: found.i_squared,
        common_rate: found.fixed.rate(),
        common_interval: Interval {
            low: interval.low,
            high: interval.high,
        },
    })
}
