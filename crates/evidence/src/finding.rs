//! Findings: one number about one subject, never without its uncertainty.

use crate::{Guarantee, Interval, RunVerdict};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stats::{Confidence, Sample};

/// What a finding speaks about.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind", content = "id")]
pub enum Subject {
    /// The share of runs that satisfy the requirement with this identifier.
    Requirement(String),
    /// The share of opportunities at which the failure mode with this
    /// identifier occurs.
    FailureMode(String),
}

impl Subject {
    /// The identifier of the requirement or failure mode.
    pub fn id(&self) -> &str {
        match self {
            Subject::Requirement(id) | Subject::FailureMode(id) => id,
        }
    }

    /// What it is called within a sentence: `requirement 3`, `sensor blind`.
    #[must_use]
    pub fn in_words(&self) -> String {
        match self {
            Subject::Requirement(id) => format!("requirement {id}"),
            Subject::FailureMode(id) => id.replace('_', " "),
        }
    }
}

/// The denominator of a finding: over which runs its number is taken. Numbers over different runs are not compared.
///
/// Of a failure mode, a run triggers it that gives it an opportunity.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Denominator {
    /// All runs, in each of which the subject is triggered (or which has no trigger): it is the same number over all
    /// runs and over those that trigger it.
    #[default]
    EveryRun,
    /// All runs: the study does not say that the subject is triggered in some of them alone. It is the same number over
    /// the runs that trigger it only if each does, which other evidence may show not to be so.
    NoTrigger,
    /// The runs that trigger it, where others are known not to.
    Triggered,
    /// The runs that trigger it; nothing says whether there were others.
    Covered,
    /// The runs of a model that satisfy the study's trigger, which are not those in which the subject's monitor is triggered.
    OtherTrigger {
        /// The study's trigger, in the words of the study.
        trigger: String,
        /// What triggers the monitor.
        monitor: String,
    },
    /// All runs, also those that do not trigger it, as far as known.
    AllRuns {
        /// Why the number is not given that it is triggered.
        reason: String,
    },
}

/// What the scheduler of the worst case does along the most probable path on which the subject fails.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct WorstCase {
    /// The probability of the path under that scheduler.
    pub probability: Option<f64>,
    /// Its steps in words: the action that is taken, and what changes.
    pub steps: Vec<String>,
    /// The file of the results in which it is a test for the bench, relative to the study, if it is one.
    pub file: Option<String>,
    /// The test, as it is in that file.
    pub test: Option<String>,
    /// How the test is run, or why there is none.
    pub note: String,
}

/// The answer of one method of model checking.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MethodAnswer {
    /// `sound`, `exact`, `prism-default` or another method by name.
    pub method: String,
    /// The probability.
    pub value: f64,
    /// One minus the probability, computed directly and hence accurate even
    /// when it is far below the precision of `value`.
    pub complement: Option<f64>,
    /// What is known of the error.
    pub guarantee: Guarantee,
    /// Iterations of the numerical method, where it iterates.
    pub iterations: Option<u64>,
}

/// One constant's share in the variance of a computed probability.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Spread {
    /// The model's constant.
    pub constant: String,
    /// What knowing this constant alone would take away from the variance, 0 to 1 (Sobol's index of first order).
    pub share: f64,
    /// What would be left of the variance if all other constants were known, 0 to 1.
    #[serde(default)]
    pub total: Option<f64>,
    /// The larger error of `share` and `total`: a standard error, or what quadrature leaves open.
    #[serde(default)]
    pub error: Option<f64>,
}

/// A constant and the interval in which its counts leave it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ConstantInterval {
    /// The model's constant.
    pub constant: String,
    /// Where it lies, all constants at once at the study's level.
    pub interval: Interval,
}

/// Bounds of a probability over every value of the constants within their intervals, by an interval
/// model. They hold, and are conservative: the model's rows may be chosen free of each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RobustBounds {
    /// The constants with their intervals, which hold at once at the study's level.
    pub constants: Vec<ConstantInterval>,
    /// The bounds; `None` where there are none.
    pub interval: Option<Interval>,
    /// Why there are no bounds.
    pub reason: Option<String>,
}

/// The distribution of one end of the range over all schedulers, of a model whose constants are estimated from counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EndDistribution {
    /// Mean of the distribution.
    pub mean: f64,
    /// Its central interval at the study's confidence level, extended to the mean and to the end with the constants as
    /// they are written.
    pub interval: Interval,
    /// Which constant contributes how much to its variance, largest first.
    pub spread: Vec<Spread>,
    /// Evenly spaced quantiles (0.5 % to 99.5 %), equal weight each, ascending.
    pub quantiles: Vec<f64>,
}

/// The least and the greatest probability over all schedulers, each with its distribution.
///
/// Each lies beyond its outer limit with at most half of what the study's level leaves, so that with the level's
/// probability the whole range lies between the outer limits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SchedulerEnds {
    /// The probability under the scheduler that makes it least.
    pub least: EndDistribution,
    /// The probability under the scheduler that makes it greatest.
    pub greatest: EndDistribution,
}

/// A probability whose model has constants estimated from counts: the
/// constants' Jeffreys posteriors pushed through the model.
///
/// Of a model with choices it is the probability under the scheduler that is worst for the subject at each point of the
/// constants, and the interval is that of `ends`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CredibleInterval {
    /// Mean of the distribution.
    pub mean: f64,
    /// Its central interval at the study's confidence level, extended to the mean and to the answer with the constants as
    /// they are written where these lie outside (in a skewed distribution). Of a range over all schedulers it reaches from
    /// the lower limit of the least to the upper limit of the greatest probability.
    pub interval: Interval,
    /// At how many points of the constants it was answered.
    pub solves: u64,
    /// Whether by a rational function of the constants, found once; else the model was solved at each point.
    #[serde(default)]
    pub by_function: bool,
    /// Which constant contributes how much, largest first.
    pub spread: Vec<Spread>,
    /// Evenly spaced quantiles (0.5 % to 99.5 %) for drawing and comparing;
    /// equal weight each, ascending.
    pub quantiles: Vec<f64>,
    /// Robust bounds beside the distribution.
    #[serde(default)]
    pub robust: Option<Box<RobustBounds>>,
    /// Both ends of the range, where the model leaves choices open.
    #[serde(default)]
    pub ends: Option<Box<SchedulerEnds>>,
    /// At which share of the points the model has a counted rate with no value of a constant that was solved for: there it has the
    /// nearest that it can.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub out_of_reach: f64,
}

/// Whether there is nothing to write.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde gives a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

/// What was found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Measure {
    /// Counts over runs or attempts.
    Counts {
        /// Requirement: runs that passed. Failure mode: occurrences.
        count: u64,
        /// Requirement: runs that were covered. Failure mode: opportunities.
        trials: u64,
        /// Independent trials that say as much, once clustering is allowed for and for how few
        /// clusters it is known from; `None` if runs are independent.
        effective_trials: Option<f64>,
        /// What was counted of each subject or session, and of how many trials; `None` where that is not known, or each
        /// has a single trial.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        by_subject: Option<Vec<[u64; 2]>>,
        /// How many subjects or sessions have trials, where those of one may be alike; `None` if runs are independent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        subjects: Option<u64>,
        /// Interval of the rate at the study's level: Wilson's or, of clustered trials, from the
        /// variance between clusters.
        interval: Interval,
    },
    /// A computed probability.
    Probability {
        /// The answer that counts: of the sound method.
        answer: MethodAnswer,
        /// Answers of other methods to the same question.
        others: Vec<MethodAnswer>,
        /// The distribution, if constants were estimated from counts.
        credible: Option<CredibleInterval>,
    },
    /// The asset cannot express the subject.
    NotExpressible {
        /// What is missing.
        reason: String,
    },
    /// The subject could have been observed but never was.
    NotCovered {
        /// Why, as far as known.
        reason: String,
        /// The one truth value that what is asked of a model has on all of its runs, whatever its commands do.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        constant: Option<bool>,
    },
}

/// The same traces judged by another reading of the requirement's text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Reading {
    /// Short name of the reading, for example `human`.
    pub name: String,
    /// How it differs from the main reading, in one sentence.
    pub meaning: String,
    /// Runs that passed under this reading.
    pub count: u64,
    /// Runs that were covered under this reading.
    pub trials: u64,
    /// Runs with another verdict than under the main reading.
    pub differing: u64,
    /// Some of the differing runs, for replay.
    pub witnesses: Vec<String>,
}

/// Two forms of one requirement (its sentence, monitor, property, a reading)
/// that do not agree on runs that both judged: one is violated, the other not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FormDifference {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// The form that the other is held against, for example `sentence`.
    pub reference: String,
    /// Its verdict.
    pub reference_verdict: RunVerdict,
    /// The other form, for example `property`.
    pub form: String,
    /// Its verdict.
    pub verdict: RunVerdict,
    /// On how many runs they differ so.
    pub count: u64,
    /// How many runs were judged.
    pub runs: u64,
    /// Some of the runs on which they differ so.
    pub witnesses: Vec<String>,
}

/// A count as it would be with each run of which it is not known what it counts for counted one way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Completions {
    /// The ends of what it may be. First as if none of the runs without a verdict had passed (or shown the failure mode), then
    /// as if all had; the same again without runs that may be others told twice.
    pub ends: Vec<Measure>,
}

/// One piece of evidence about one subject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Finding {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// The number with its uncertainty.
    pub measure: Measure,
    /// Over which runs it is taken.
    #[serde(default)]
    pub denominator: Denominator,
    /// In what share of all runs the subject is triggered, where that is known and not certain: a quantity of its own.
    #[serde(default)]
    pub trigger: Option<Box<Measure>>,
    /// Runs that reached no verdict (inconclusive): they ended before it, or lack a signal.
    pub undecided: u64,
    /// Runs with a verdict that leaves out what was pending at their end: windows that nothing had violated and that the end cut,
    /// beside others that were seen whole.
    #[serde(default, skip_serializing_if = "is_none_left_out")]
    pub left_out: u64,
    /// Its rate with these runs counted: the ends of what they may have been; and without runs that may be others told twice.
    /// `None` where there are none, where they are declared to be missing at random
    /// ([`crate::Evidence::undecided_at_random`]), and where nothing is counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub completions: Option<Box<Completions>>,
    /// Runs that show it, for replay: episode seeds or file names, few.
    pub witnesses: Vec<String>,
    /// The verdicts under other readings of the requirement, if it has any.
    pub readings: Vec<Reading>,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde passes a reference
fn is_none_left_out(count: &u64) -> bool {
    *count == 0
}

impl Measure {
    /// The point estimate: rate or probability; `None` where nothing was
    /// observed.
    pub fn estimate(&self) -> Option<f64> {
        match self {
            Measure::Counts { count, trials, .. } if *trials > 0 => {
                Some(*count as f64 / *trials as f64)
            }
            Measure::Probability { answer, .. } => Some(answer.value),
            _ => None,
        }
    }

    /// Whether its interval is that of a confidence sequence at a level, which holds however the number of trials was chosen.
    pub fn holds_at_every_look(&self, level: f64) -> bool {
        let Measure::Counts {
            count,
            trials,
            interval,
            ..
        } = self
        else {
            return false;
        };
        let sample = Sample::new(*count, *trials).ok().filter(|_| *trials > 0);
        let sequence = sample
            .zip(Confidence::new(level).ok())
            .map(|(sample, level)| stats::confidence_sequence(sample, level));
        sequence.is_some_and(|it| (it.low, it.high) == (interval.low, interval.high))
    }

    /// The interval to draw: of the counts, or the credible interval, or the
    /// bounds of the computation.
    ///
    /// The estimate lies in it: an interval that is central in a skewed distribution, or a little off by rounding, is
    /// extended to it.
    pub fn interval(&self) -> Option<Interval> {
        self.own_interval()
            .zip(self.estimate())
            .map(|(interval, estimate)| interval.with(estimate))
    }

    fn own_interval(&self) -> Option<Interval> {
        match self {
            Measure::Counts {
                interval, trials, ..
            } if *trials > 0 => Some(*interval),
            Measure::Probability {
                answer, credible, ..
            } => Some(match (credible, &answer.guarantee) {
                (Some(credible), _) => credible.interval,
                (
                    None,
                    Guarantee::Bounded { low, high }
                    | Guarantee::Schedulers { low, high, .. }
                    | Guarantee::Statistical { low, high, .. },
                ) => Interval {
                    low: *low,
                    high: *high,
                },
                (None, Guarantee::Exact { .. } | Guarantee::Estimated { .. }) => Interval {
                    low: answer.value,
                    high: answer.value,
                },
            }),
            _ => None,
        }
    }
}
