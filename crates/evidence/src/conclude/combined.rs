//! The interval that the independent evidence on a requirement supports together.
//!
//! # Definition
//! Of the current evidence (see `conclude`) those pieces are combined that are independent, can be
//! counted, and do not conflict with one another: counts at their effective size, and
//! distributions of computed probabilities at the counts that would leave them. Each enters with a
//! declared weight from 0 to 1. A probability that is known exactly is not a count: it is held
//! against the interval, not combined.
//!
//! * The rates may be one (Cochran's Q has a p-value of at least [`SCATTER`]): a power prior, that
//!   is the beta posterior of all weighted counts, and its credible interval.
//! * They scatter: random effects, and the credible interval of the mean rate.
//! * They are further apart than the prior of the random effects allows for ([`stats::MOST_BETWEEN`]): nothing is
//!   combined, because that prior would hold them together against their counts.
//! * There is one piece: its own interval.
//! * Two pieces conflict: nothing is combined.
//! * Some are trials of the system, others stand for it, and not every pair of them is shown to agree: nothing is combined.
//!
//! Beside it stands the sound common statement, which combines nothing: what every current piece
//! supports, at the study's level (see `conclude`).
//!
//! It is an estimate under the assumption that all pieces measure one rate. It is not held against the threshold: the
//! verdict on a requirement is that of `conclude` alone, which divides models from the system.
//!
//! # Source
//! See `stats::combination`; the level of 0.1 for Q is customary, its power being low.
//!
//! # Assumes
//! Pieces that are pooled are independent of each other, and measure one rate or rates that scatter as the random effects
//! have it. Weights were declared without looking at the counts. Not allowed for are looks before, that Q chooses between
//! the two on the same counts, and that pieces which conflict are not pooled.
//!
//! # Guarantee
//! Where the true rates are one, the power prior's interval covers it at the study's level on average over its prior, as far
//! as what is not allowed for plays no part; with weights below 1 it covers oftener. It says nothing of dependence that is not
//! declared.

use super::common::{common_bound, common_statement, over_the_same_runs};
use super::{
    Piece, among_current, current, independent_among, is_trial, quantity, superseded, threshold_of,
};
use crate::compare::words::{list, p_value, percent};
use crate::compare::{Belief, Lineage, Study};
use crate::{Comparison, Direction, Evidence, Interval, Measure, Outcome, Requirement, Subject};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stats::{Confidence, EffectiveSample, StatsError};
use std::collections::BTreeMap;

/// The p-value of Cochran's Q below which rates count as scattered.
pub const SCATTER: f64 = 0.1;

/// How much each piece of evidence counts, from 0 (left out) to 1 (in full); 1 where not declared.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Weights {
    declared: BTreeMap<String, f64>,
}

impl Weights {
    /// The same with one piece's weight declared.
    ///
    /// # Errors
    /// [`StatsError::OutOfRange`] for a weight outside `[0, 1]`.
    pub fn declare(mut self, evidence: &str, weight: f64) -> Result<Self, StatsError> {
        if !(0.0..=1.0).contains(&weight) {
            return Err(StatsError::OutOfRange {
                what: "weight",
                value: weight,
                expected: "a number from 0 to 1",
            });
        }
        self.declared.insert(evidence.to_owned(), weight);
        Ok(self)
    }

    fn of(&self, evidence: &str) -> f64 {
        self.declared.get(evidence).copied().unwrap_or(1.0)
    }
}

/// How rates were combined.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// One common rate, counts weighted.
    PowerPrior,
    /// Rates that scatter about a mean.
    RandomEffects,
}

/// What all current pieces of evidence support at once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CommonBound {
    /// Whether the rate is at least or at most the bound, as the requirement asks.
    pub direction: Direction,
    /// The bound.
    pub value: f64,
    /// The confidence with which all pieces support it at once.
    pub confidence: f64,
    /// The pieces, in the ledger's order.
    pub pieces: Vec<String>,
    /// All of it in a sentence.
    pub statement: String,
}

/// What the independent evidence on a requirement supports together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Combined {
    /// The requirement's identifier.
    pub requirement: String,
    /// The pieces that were combined, with their weights.
    pub pieces: BTreeMap<String, f64>,
    /// Pieces that were not, each with the reason.
    pub left_out: BTreeMap<String, String>,
    /// Those of them that a later piece of the same technique has taken the place of, with that piece.
    #[serde(default)]
    pub superseded: BTreeMap<String, String>,
    /// `true` if every pair of the combined pieces corroborates.
    pub corroborated: bool,
    /// How they were combined; `None` if nothing was.
    pub model: Option<Model>,
    /// The combined rate.
    pub rate: Option<f64>,
    /// Its interval at the study's level.
    pub interval: Option<Interval>,
    /// p-value of "one common rate", with two pieces or more.
    pub p_heterogeneity: Option<f64>,
    /// The sound common statement; `None` without evidence.
    pub common: Option<CommonBound>,
    /// What was combined, and to what, in a few sentences.
    pub statement: String,
}

/// Combines the independent evidence on every requirement, in their order.
///
/// `comparisons` are those of [`crate::compare()`] on the same study.
pub fn combine(study: &Study<'_>, comparisons: &[Comparison], weights: &Weights) -> Vec<Combined> {
    let lineage = study.lineage();
    study
        .requirements
        .iter()
        .map(|requirement| combined(study, &lineage, requirement, comparisons, weights))
        .collect()
}

fn combined(
    study: &Study<'_>,
    lineage: &Lineage<'_>,
    requirement: &Requirement,
    comparisons: &[Comparison],
    weights: &Weights,
) -> Combined {
    let quantity = quantity(study.requirements, requirement);
    let pieces = current(study.evidence, requirement, &quantity);
    let pieces = super::looked_at(study, pieces, (requirement, &quantity));
    let among = among_current(comparisons, &quantity, &pieces);
    let mut result = blank(requirement);
    result.common = common(study, &pieces, requirement);
    let chosen = chosen(&pieces, lineage, &quantity, weights, &mut result);
    say_what_is_older(study.evidence, requirement, &quantity, &pieces, &mut result);
    let both = |c: &&&Comparison| {
        result.pieces.contains_key(&c.left) && result.pieces.contains_key(&c.right)
    };
    let inside: Vec<&Comparison> = among.iter().filter(both).copied().collect();
    let conflict = inside.iter().any(|c| c.outcome == Outcome::Conflicts);
    if !conflict {
        let all = |c: &&Comparison| c.outcome == Outcome::Corroborates;
        result.corroborated = !inside.is_empty() && inside.iter().all(all);
        let confidence = study.levels.confidence;
        match chosen.as_slice() {
            [only] => alone(only, confidence, &mut result),
            _ if !result.corroborated && is_of_several_steps(&chosen) => {}
            _ => estimate(&chosen, confidence, &mut result),
        }
    }
    result.statement = statement(&result, conflict, study.levels.confidence);
    result
}

/// Whether trials of the system would be pooled with what stands for it.
fn is_of_several_steps(chosen: &[Chosen<'_>]) -> bool {
    let trials = chosen.iter().filter(|it| is_trial(it.piece.evidence));
    (1..chosen.len()).contains(&trials.count())
}

/// What every current piece supports.
fn common(
    study: &Study<'_>,
    pieces: &[Piece<'_>],
    requirement: &Requirement,
) -> Option<CommonBound> {
    let direction = threshold_of(requirement).direction;
    let confidence = study.levels.confidence;
    let pieces = over_the_same_runs(pieces);
    let value = common_bound(&pieces, direction, confidence)?;
    let pieces: Vec<String> = pieces.iter().map(|p| p.evidence.id.clone()).collect();
    Some(CommonBound {
        direction,
        value,
        confidence: confidence.level(),
        statement: common_statement(&pieces, direction, value, confidence),
        pieces,
    })
}

fn statement(result: &Combined, conflict: bool, confidence: Confidence) -> String {
    let mut sentences = vec![together_in_words(result, conflict, confidence)];
    let left_out = result.left_out.iter();
    sentences.extend(left_out.map(|(id, why)| format!("{id} {why}.")));
    sentences.join(" ")
}

/// What was combined, and to what.
fn together_in_words(result: &Combined, conflict: bool, confidence: Confidence) -> String {
    let ids: Vec<String> = result.pieces.keys().cloned().collect();
    let who = list(&ids);
    let Some(Interval { low, high }) = result.interval else {
        return match result.common {
            None => "Nothing to pool: no evidence takes part.".to_owned(),
            _ if conflict => format!("Not pooled: {who} are independent and conflict."),
            _ if ids.is_empty() => "Not pooled: no independent evidence is counted.".to_owned(),
            _ if result.p_heterogeneity.is_none() => format!(
                "Not pooled: {who} are counted independently, of the system and of what stands for it, and their agreement \
                 within the margin is not shown."
            ),
            _ => {
                let p = p_value(result.p_heterogeneity.unwrap_or(1.0));
                format!("{who} are too heterogeneous to pool (homogeneity test, p {p}).")
            }
        };
    };
    let level = percent(confidence.level());
    // One piece stands with its own interval, several with that of a posterior; neither allows for looks.
    let kind = match ids.len() {
        1 => "interval",
        _ => "credible interval",
    };
    let range = format!(
        "{} to {} (two-sided {level} {kind} of one look)",
        percent(low),
        percent(high)
    );
    if ids.len() == 1 {
        return format!("Only {who} is counted independently: {range}.");
    }
    let p = p_value(result.p_heterogeneity.unwrap_or(1.0));
    let mut words = match result.model {
        Some(Model::RandomEffects) => format!(
            "Pooled mean rate of {who}: {range}, by random effects (homogeneity test, p {p})."
        ),
        _ => format!("Pooled rate of {who}: {range} (homogeneity test, p {p})."),
    };
    let weighted = result.pieces.iter().filter(|(_, weight)| **weight < 1.0);
    let weights: Vec<String> = weighted
        .map(|(id, weight)| format!("{id} has weight {weight}"))
        .collect();
    if !weights.is_empty() {
        words.push_str(&format!(" As declared, {}.", list(&weights)));
    }
    if !result.corroborated {
        words.push_str(" Agreement within the margin is not shown for every pair.");
    }
    words
}

/// Nothing combined yet.
fn blank(requirement: &Requirement) -> Combined {
    Combined {
        requirement: requirement.id.clone(),
        pieces: BTreeMap::new(),
        left_out: BTreeMap::new(),
        superseded: BTreeMap::new(),
        corroborated: false,
        model: None,
        rate: None,
        interval: None,
        p_heterogeneity: None,
        common: None,
        statement: String::new(),
    }
}

/// A piece that is combined.
struct Chosen<'a> {
    piece: &'a Piece<'a>,
    sample: EffectiveSample,
    weight: f64,
}

/// The pieces that are combined; the others are noted with the reason.
fn chosen<'a>(
    pieces: &'a [Piece<'a>],
    lineage: &Lineage<'_>,
    quantity: &Subject,
    weights: &Weights,
    result: &mut Combined,
) -> Vec<Chosen<'a>> {
    // What is computed takes no part, so that no count is left out for it.
    let is_counted = |at: &usize| pieces[*at].belief.worth_in_counts().is_some();
    let places = (0..pieces.len()).filter(is_counted);
    let same_runs: Vec<&str> = over_the_same_runs(pieces)
        .into_iter()
        .map(|piece| piece.evidence.id.as_str())
        .collect();
    let places: Vec<usize> = places.collect();
    let are_several = places.len() > 1;
    let free = independent_among(pieces, places, lineage, quantity);
    let mut chosen = Vec::new();
    for (index, piece) in pieces.iter().enumerate() {
        let id = piece.evidence.id.clone();
        let weight = weights.of(&id);
        let reason = match piece.belief.worth_in_counts() {
            _ if weight <= 0.0 => "has a declared weight of 0",
            Some(_) if piece.is_of_one_subject() => match is_trial(piece.evidence) {
                true => "is of one person or session alone",
                false => "is of one cluster alone",
            },
            Some(_) if are_several && piece.belief.has_undecided() => {
                "has runs that count both ways (without a verdict, or reported twice)"
            }
            Some(_) if !same_runs.contains(&id.as_str()) => "is over other runs",
            Some(_) if !free.contains(&index) => "rests on the counts of a piece that is combined",
            None if matches!(piece.belief, Belief::Known { .. } | Belief::Range { .. }) => {
                "is computed, not counted"
            }
            None => "says less than one trial would",
            Some(sample) => {
                chosen.push(Chosen {
                    piece,
                    sample,
                    weight,
                });
                result.pieces.insert(id, weight);
                continue;
            }
        };
        result.left_out.insert(id, reason.to_owned());
    }
    chosen
}

/// Notes the pieces that are not current for the only reason that a later one of the same technique is.
fn say_what_is_older(
    evidence: &[Evidence],
    requirement: &Requirement,
    quantity: &Subject,
    pieces: &[Piece<'_>],
    result: &mut Combined,
) {
    for older in superseded(evidence, requirement, quantity, pieces) {
        let latest = pieces
            .iter()
            .find(|it| it.evidence.technique == older.technique);
        let Some(latest) = latest else { continue };
        let (id, by) = (older.id.clone(), latest.evidence.id.clone());
        let why = format!("is older than {by}");
        result.left_out.insert(id.clone(), why);
        result.superseded.insert(id, by);
    }
}

/// What one piece says by itself: its own interval.
fn alone(only: &Chosen<'_>, confidence: Confidence, result: &mut Combined) {
    let Chosen {
        piece,
        sample,
        weight,
    } = only;
    if *weight < 1.0 {
        // Discounted, it says less than it does by itself.
        return estimate(std::slice::from_ref(only), confidence, result);
    }
    result.model = Some(Model::PowerPrior);
    result.rate = Some(sample.successes / sample.trials);
    // The one that is shown with it, so that no two of one piece differ.
    let shown = match &piece.finding.measure {
        Measure::Probability { credible, .. } => credible.as_ref().map(|it| it.interval),
        _ => piece.counted,
    };
    result.interval = Some(shown.unwrap_or_else(|| {
        let own = piece.belief.interval(confidence);
        Interval {
            low: own.low,
            high: own.high,
        }
    }));
}

/// Rate and interval of the combined counts.
fn estimate(chosen: &[Chosen<'_>], confidence: Confidence, result: &mut Combined) {
    let counts: Vec<(EffectiveSample, f64)> =
        chosen.iter().map(|it| (it.sample, it.weight)).collect();
    let samples: Vec<EffectiveSample> = chosen.iter().map(|it| it.sample).collect();
    let found = stats::heterogeneity(&samples).ok();
    result.p_heterogeneity = found.map(|found| found.p_value);
    let is_scattered = found.is_some_and(|found| found.p_value < SCATTER);
    // Without a failure nothing speaks against 1, and without a success nothing against 0.
    let counted = |part: fn(&EffectiveSample) -> f64| samples.iter().any(|it| part(it) > 0.0);
    let (passed, failed) = (
        counted(|sample| sample.successes),
        counted(EffectiveSample::failures),
    );
    let at = |confidence: Confidence| -> Option<(f64, stats::Interval)> {
        let (rate, interval) = if is_scattered {
            let mean = stats::scattered_rate(&counts, confidence).ok()?;
            if mean.is_beyond_the_prior() {
                return None;
            }
            (mean.rate, mean.interval)
        } else {
            let posterior = stats::power_prior(&counts).ok()?;
            (posterior.mean(), posterior.credible_interval(confidence))
        };
        let open = stats::Interval {
            low: if passed { interval.low } else { 0.0 },
            high: if failed { interval.high } else { 1.0 },
        };
        Some((rate, open))
    };
    let Some((rate, interval)) = at(confidence) else {
        return;
    };
    result.model = Some(match is_scattered {
        true => Model::RandomEffects,
        false => Model::PowerPrior,
    });
    result.rate = Some(rate);
    result.interval = Some(Interval {
        low: interval.low,
        high: interval.high,
    });
}
