//! What a finding says of its rate, in the three forms that comparison knows.

use super::by_cluster::ByCluster;
use super::ends::{End, Ends};
use super::quantiles::Quantiles;
use super::statistical::of_interval;
use super::uncertain::Uncertain;
use crate::{
    Completions, CredibleInterval, EndDistribution, Evidence, Finding, Guarantee, Measure,
    MethodAnswer, Subject,
};
use stats::{BetaPosterior, Confidence, EffectiveSample, Interval, Sample};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Counts at one look, of one sequence of trials.
#[derive(Clone, Debug)]
pub(crate) struct CountsAtLook {
    /// The counts as they were.
    pub sample: Sample,
    /// At their effective size.
    pub effective: EffectiveSample,
    /// By subject or session, where they tell how alike trials of one are.
    pub clusters: Option<Rc<ByCluster>>,
}

impl CountsAtLook {
    /// Whether each trial counts as one.
    pub fn is_independent(&self) -> bool {
        self.effective.trials >= self.sample.trials as f64
    }

    /// p-values of "the rate is below the threshold" and "the rate is at least as high", by the counts by subject
    /// alone; 0, which claims nothing by itself, where there are none.
    pub fn doubts_by_cluster(&self, threshold: f64) -> (f64, f64) {
        let clusters = self.clusters.as_ref();
        clusters.map_or((0.0, 0.0), |it| it.doubts(threshold))
    }
}

/// What is known of a rate.
#[derive(Clone, Debug)]
pub(crate) enum Belief {
    /// Counts, and what they are worth in independent trials.
    Counts {
        /// The counts as they are.
        sample: Sample,
        /// The same rate at the effective size.
        effective: EffectiveSample,
        /// The counts by subject or session, where they tell how alike trials of one are.
        clusters: Option<Rc<ByCluster>>,
        /// The counts at looks before this one, where trials may be added; `None` if this is the only look.
        before: Option<Rc<[CountsAtLook]>>,
        /// The same counts with the runs that reached no verdict, as if none of them counted and as if all did; and without runs
        /// that may be others told twice. `None` where each run counts for itself. They have none themselves.
        completions: Option<Rc<[Belief]>>,
    },
    /// A computed probability, between these bounds.
    Known {
        /// The answer.
        value: f64,
        /// Bounds that hold.
        bounds: Interval,
        /// Whether every value between the bounds is one that the model allows (a decision process), so that a rate
        /// agrees with it that agrees with any of them.
        is_range: bool,
    },
    /// A computed probability of a model whose constants are uncertain.
    Distribution {
        /// The answer with the constants at their estimates.
        value: f64,
        /// The distribution, as a beta distribution of the same mean and variance, for comparisons.
        posterior: BetaPosterior,
        /// Its quantiles, against thresholds; `None` where only the beta distribution is known.
        quantiles: Option<Quantiles>,
    },
    /// The range over all schedulers of a model whose constants are uncertain.
    Range {
        /// The answer of the worst scheduler with the constants at their estimates.
        value: f64,
        /// Both ends with their distributions.
        ends: Ends,
    },
}

/// What computed probabilities say, for comparisons that are made again and again with the same ones: what is worked out of
/// a distribution stays with its belief.
#[derive(Debug, Default)]
pub(crate) struct Computed(RefCell<BTreeMap<(String, Subject), Result<Belief, String>>>);

impl Computed {
    /// What a finding of a piece says of its rate; computed probabilities of one piece and subject are the same each time.
    pub fn belief(&self, piece: &Evidence, finding: &Finding) -> Result<Belief, String> {
        let Measure::Probability { .. } = finding.measure else {
            return Belief::of_piece(piece, finding);
        };
        let key = (piece.id.clone(), finding.subject.clone());
        let mut known = self.0.borrow_mut();
        let belief = known.entry(key);
        belief
            .or_insert_with(|| Belief::of_finding(finding))
            .clone()
    }
}

impl Belief {
    /// What a finding says of its rate, with the runs that reached no verdict; or in words why it says nothing.
    pub fn of_finding(finding: &Finding) -> Result<Self, String> {
        let belief = Self::of(&finding.measure)?;
        match finding.completions.as_deref() {
            Some(Completions { ends }) => {
                let ends: Result<Vec<Self>, String> = ends.iter().map(Self::of).collect();
                Ok(belief.completed_by(ends?))
            }
            None => Ok(belief),
        }
    }

    /// The same counts, which may be any of these.
    pub fn completed_by(self, ends: Vec<Self>) -> Self {
        match self {
            Self::Counts {
                sample,
                effective,
                clusters,
                before,
                completions: _,
            } => Self::Counts {
                sample,
                effective,
                clusters,
                before,
                completions: Some(ends.into()),
            },
            other => other,
        }
    }

    /// What a finding of a piece says of its rate.
    pub fn of_piece(piece: &Evidence, finding: &Finding) -> Result<Self, String> {
        let belief = Self::of_finding(finding);
        match piece.is_simulated_of_one() {
            true => belief.and_then(Self::of_one),
            false => belief,
        }
    }

    /// What simulated runs of one cluster say of others: how others differ is not known, so that all are worth one run.
    fn of_one(self) -> Result<Self, String> {
        match self {
            Self::Counts {
                sample,
                completions,
                ..
            } => {
                let one = EffectiveSample::at_size(sample, 1.0);
                let ends: Option<Result<Vec<Self>, String>> =
                    completions.map(|all| all.iter().cloned().map(Self::of_one).collect());
                Ok(Self::Counts {
                    sample,
                    effective: one.map_err(|error| error.to_string())?,
                    clusters: None,
                    before: None,
                    completions: ends.transpose()?.map(Into::into),
                })
            }
            other => Ok(other),
        }
    }

    /// What is known if each run without a verdict counts one way, and runs that may be told twice count or do not; this belief
    /// where there are none. What holds of all of them holds whatever these runs are.
    pub fn ends(&self) -> &[Self] {
        match self {
            Self::Counts {
                completions: Some(ends),
                ..
            } => ends,
            other => std::slice::from_ref(other),
        }
    }

    /// Whether runs without a verdict, or such as may be told twice, count both ways.
    pub fn has_undecided(&self) -> bool {
        self.ends().len() > 1
    }

    /// How many runs without a verdict count both ways.
    pub fn undecided(&self) -> u64 {
        match (self, self.ends()) {
            (Self::Counts { sample, .. }, [Self::Counts { sample: all, .. }, ..]) => {
                all.trials.saturating_sub(sample.trials)
            }
            _ => 0,
        }
    }

    /// Whether some of its runs may be others told twice, which count and do not count.
    pub fn may_be_told_twice(&self) -> bool {
        let of_undecided = if self.undecided() > 0 { 2 } else { 1 };
        self.ends().len() > of_undecided
    }

    /// What a measure says of its rate, or in words why it says nothing.
    pub fn of(measure: &Measure) -> Result<Self, String> {
        match measure {
            Measure::Counts {
                count,
                trials,
                effective_trials,
                by_subject,
                subjects,
                ..
            } => {
                let belief = Self::of_counts(*count, *trials, *effective_trials)?;
                Ok(match by_subject {
                    Some(by_subject) => belief.by_cluster(ByCluster::new(by_subject)),
                    None => match subjects {
                        Some(subjects) => belief.by_cluster(ByCluster::of_total(*subjects)),
                        None => belief,
                    },
                })
            }
            Measure::Probability {
                answer, credible, ..
            } => computed(answer, credible.as_ref()),
            Measure::NotExpressible { reason } => Err(format!("cannot express it. {reason}")),
            Measure::NotCovered { reason, .. } => Err(format!("never covered it. {reason}")),
        }
    }

    /// What counts say, at their effective size.
    pub fn of_counts(count: u64, trials: u64, effective: Option<f64>) -> Result<Self, String> {
        counts(count, trials, effective)
    }

    /// The same counts by subject or session; nothing else has any.
    pub fn by_cluster(self, clusters: ByCluster) -> Self {
        match self {
            Self::Counts {
                sample,
                effective,
                before,
                completions,
                ..
            } => Self::Counts {
                sample,
                effective,
                clusters: Some(Rc::new(clusters)),
                before,
                completions,
            },
            other => other,
        }
    }

    /// The same counts, with the looks of others before them.
    pub fn after_looks_of(self, others: &Self) -> Self {
        match (self, others) {
            (
                Self::Counts {
                    sample,
                    effective,
                    clusters,
                    completions,
                    ..
                },
                Self::Counts { before, .. },
            ) => Self::Counts {
                sample,
                effective,
                clusters,
                before: before.clone(),
                completions,
            },
            (belief, _) => belief,
        }
    }

    /// The rate or probability.
    pub fn estimate(&self) -> f64 {
        match self {
            Self::Counts { effective, .. } => effective.successes / effective.trials,
            Self::Known { value, .. }
            | Self::Distribution { value, .. }
            | Self::Range { value, .. } => *value,
        }
    }

    /// How wide a range over all schedulers is; none if it is no such range.
    pub fn width_of_range(&self) -> Option<f64> {
        let is_range = match self {
            Self::Known { is_range, .. } => *is_range,
            Self::Range { ends, .. } => ends.is_range,
            Self::Counts { .. } | Self::Distribution { .. } => false,
        };
        let values = self.values();
        is_range.then_some(values.high - values.low)
    }

    /// Every value that it may have as far as it says itself: of a range over all schedulers all of it, of counts what the runs
    /// without a verdict leave open, else the estimate.
    pub fn values(&self) -> Interval {
        match self {
            Self::Known {
                bounds,
                is_range: true,
                ..
            } => *bounds,
            Self::Range { ends, .. } if ends.is_range => ends.as_written,
            open if open.has_undecided() => {
                let rates = open.ends().iter().map(Self::estimate);
                Interval {
                    low: rates.clone().fold(1.0, f64::min),
                    high: rates.fold(0.0, f64::max),
                }
            }
            other => Interval {
                low: other.estimate(),
                high: other.estimate(),
            },
        }
    }

    /// An interval of the rate: Wilson's, the bounds, or a credible interval.
    pub fn interval(&self, confidence: Confidence) -> Interval {
        match self {
            open if open.has_undecided() => {
                let all = open.ends().iter().map(|end| end.interval(confidence));
                all.reduce(|one, other| Interval {
                    low: one.low.min(other.low),
                    high: one.high.max(other.high),
                })
                .unwrap_or(Interval {
                    low: 0.0,
                    high: 1.0,
                })
            }
            Self::Counts { effective, .. } => stats::wilson(*effective, confidence),
            Self::Known { bounds, .. } => *bounds,
            Self::Distribution {
                value, posterior, ..
            } => {
                let central = posterior.credible_interval(confidence);
                Interval {
                    low: central.low.min(*value),
                    high: central.high.max(*value),
                }
            }
            Self::Range { ends, .. } => ends.interval(confidence),
        }
    }

    /// The present counts, without the looks before; `None` of what is not counted.
    pub fn counts(&self) -> Option<CountsAtLook> {
        match self {
            Self::Counts {
                sample,
                effective,
                clusters,
                ..
            } => Some(CountsAtLook {
                sample: *sample,
                effective: *effective,
                clusters: clusters.clone(),
            }),
            _ => None,
        }
    }

    /// The posterior of the rate; `None` for a computed probability without uncertain constants, and for a range.
    pub fn posterior(&self) -> Option<BetaPosterior> {
        match self {
            Self::Counts { effective, .. } => Some(BetaPosterior::jeffreys(*effective)),
            Self::Known { .. } | Self::Range { .. } => None,
            Self::Distribution { posterior, .. } => Some(*posterior),
        }
    }

    /// Counts that say as much: at the effective size, or those whose Jeffreys posterior is the
    /// distribution. `None` for a probability that is known, or known less well than by one trial, and for a range.
    pub fn worth_in_counts(&self) -> Option<EffectiveSample> {
        match self {
            Self::Counts { effective, .. } => Some(*effective),
            Self::Known { .. } | Self::Range { .. } => None,
            Self::Distribution { posterior, .. } => {
                let (alpha, beta) = posterior.parameters();
                let worth = EffectiveSample {
                    successes: (alpha - 0.5).max(0.0),
                    trials: (alpha - 0.5).max(0.0) + (beta - 0.5).max(0.0),
                };
                (worth.trials >= 1.0).then_some(worth)
            }
        }
    }

    /// Trials for each independent trial's worth; `None` where nothing is counted, so that trials
    /// cannot be added.
    pub fn design_effect(&self) -> Option<f64> {
        match self {
            Self::Counts {
                sample, effective, ..
            } => Some(sample.trials as f64 / effective.trials),
            _ => None,
        }
    }
}

fn counts(count: u64, trials: u64, effective: Option<f64>) -> Result<Belief, String> {
    let sample = Sample::new(count, trials)
        .map_err(|error| format!("has counts that contradict each other: {error}"))?;
    if trials == 0 {
        return Err("never covered it".to_owned());
    }
    let all = trials as f64;
    let size = effective
        .filter(|size| *size > 0.0 && *size < all)
        .unwrap_or(all);
    let effective = EffectiveSample::at_size(sample, size).map_err(|error| error.to_string())?;
    Ok(Belief::Counts {
        sample,
        effective,
        clusters: None,
        before: None,
        completions: None,
    })
}

fn computed(answer: &MethodAnswer, credible: Option<&CredibleInterval>) -> Result<Belief, String> {
    let value = answer.value;
    if let Some(ends) = credible.and_then(|credible| range(answer, credible)) {
        return Ok(Belief::Range { value, ends });
    }
    if let Some(posterior) = credible.and_then(moments_as_beta) {
        let of_draws = |credible: &CredibleInterval| Quantiles::new(&credible.quantiles, posterior);
        return Ok(Belief::Distribution {
            value,
            posterior,
            quantiles: credible.and_then(of_draws),
        });
    }
    match &answer.guarantee {
        Guarantee::Exact { .. } => Ok(Belief::Known {
            is_range: false,
            value,
            bounds: Interval {
                low: value,
                high: value,
            },
        }),
        Guarantee::Bounded { low, high } | Guarantee::Schedulers { low, high, .. } => {
            Ok(Belief::Known {
                is_range: matches!(answer.guarantee, Guarantee::Schedulers { .. }),
                value,
                bounds: Interval {
                    low: *low,
                    high: *high,
                },
            })
        }
        Guarantee::Statistical {
            confidence,
            low,
            high,
        } => Ok(Belief::Distribution {
            value,
            posterior: of_interval((*low, *high), *confidence)?,
            quantiles: None,
        }),
        Guarantee::Estimated { reason } => Err(format!(
            "has an answer whose error is unknown: {reason}; use a method with bounds"
        )),
    }
}

/// Both ends of a range with their distributions; `None` where there is no range, or neither end varies.
fn range(answer: &MethodAnswer, credible: &CredibleInterval) -> Option<Ends> {
    let (distributions, (bounds, _)) = (credible.ends.as_ref()?, answer.within()?);
    let end = |of: &EndDistribution, as_written: f64| {
        let shape = beta_of(of.mean, &of.quantiles);
        let drawn = |shape| End::Uncertain(Uncertain::of_draws(&of.quantiles, shape));
        shape.map_or(End::Known(as_written), drawn)
    };
    let (least, greatest) = (
        end(&distributions.least, bounds.low),
        end(&distributions.greatest, bounds.high),
    );
    let vary = [&least, &greatest]
        .iter()
        .any(|it| matches!(it, End::Uncertain(_)));
    vary.then_some(Ends {
        as_written: Interval {
            low: bounds.low,
            high: bounds.high,
        },
        least,
        greatest,
        is_range: matches!(answer.guarantee, Guarantee::Schedulers { .. }),
    })
}

/// The beta distribution with the mean and variance of the draws; `None` when they do not vary.
fn moments_as_beta(credible: &CredibleInterval) -> Option<BetaPosterior> {
    if credible.ends.is_some() {
        return None;
    }
    beta_of(credible.mean, &credible.quantiles)
}

fn beta_of(mean: f64, quantiles: &[f64]) -> Option<BetaPosterior> {
    let draws = stats::Draws::new(quantiles).ok()?;
    let variance = draws.variance();
    // Draws that differ by rounding only are one number.
    if variance.sqrt() <= 1e-12 {
        return None;
    }
    let size = mean * (1.0 - mean) / variance - 1.0;
    BetaPosterior::new(mean * size, (1.0 - mean) * size).ok()
}

/// Beliefs that tests of comparisons share.
#[cfg(test)]
pub(super) mod samples {
    use super::{Belief, Interval};

    /// Independent trials.
    pub fn counts(successes: u64, trials: u64) -> Belief {
        Belief::of_counts(successes, trials, None).expect("counts")
    }

    /// A computed probability.
    pub fn known(value: f64) -> Belief {
        Belief::Known {
            value,
            bounds: Interval {
                low: value,
                high: value,
            },
            is_range: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_effective_size_never_exceeds_the_trials() {
        for size in [Some(-1.0), Some(0.0), Some(500.0), Some(f64::NAN), None] {
            let Ok(Belief::Counts { effective, .. }) = counts(3, 10, size) else {
                panic!()
            };
            assert_eq!(effective.trials, 10.0);
        }
        assert!(counts(3, 2, None).is_err());
        assert!(counts(0, 0, None).is_err());
    }

    fn answered(guarantee: Guarantee) -> Result<Belief, String> {
        let answer = MethodAnswer {
            method: "sampled".into(),
            value: 0.5,
            complement: None,
            guarantee,
            iterations: None,
        };
        computed(&answer, None)
    }

    #[test]
    fn bounds_are_known_a_level_is_uncertain_and_an_estimate_says_nothing() {
        let (low, high) = (0.4, 0.6);
        let bounded = answered(Guarantee::Bounded { low, high });
        assert!(matches!(bounded, Ok(Belief::Known { .. })), "{bounded:?}");
        let statistical = answered(Guarantee::Statistical {
            confidence: 0.95,
            low,
            high,
        });
        let Ok(Belief::Distribution { posterior, .. }) = statistical else {
            panic!("{statistical:?}");
        };
        assert!(posterior.cdf(low) >= 0.0249 && posterior.sf(high) >= 0.0249);
        let reason = "it stopped".to_owned();
        let estimated = answered(Guarantee::Estimated { reason });
        assert!(estimated.expect_err("unknown").contains("it stopped"));
    }
}
