//! What a finding says of its rate, in the three forms that comparison knows.

use crate::{CredibleInterval, Guarantee, Measure, MethodAnswer};
use stats::{BetaPosterior, Confidence, EffectiveSample, Interval, IntervalMethod, Sample};

/// What is known of a rate.
#[derive(Clone, Debug)]
pub(crate) enum Belief {
    /// Counts, and what they are worth in independent trials.
    Counts {
        /// The counts as they are.
        sample: Sample,
        /// The same rate at the effective size.
        effective: EffectiveSample,
    },
    /// A computed probability, between these bounds.
    Known {
        /// The answer.
        value: f64,
        /// Bounds that hold.
        bounds: Interval,
    },
    /// A computed probability of a model whose constants are uncertain.
    Distribution {
        /// The answer with the constants at their estimates.
        value: f64,
        /// The distribution, as a beta distribution of the same mean and variance.
        posterior: BetaPosterior,
    },
}

impl Belief {
    /// What a measure says of its rate, or in words why it says nothing.
    pub fn of(measure: &Measure) -> Result<Self, String> {
        match measure {
            Measure::Counts {
                count,
                trials,
                effective_trials,
                ..
            } => counts(*count, *trials, *effective_trials),
            Measure::Probability {
                answer, credible, ..
            } => computed(answer, credible.as_ref()),
            Measure::NotExpressible { reason } => Err(format!("cannot express it. {reason}")),
            Measure::NotCovered { reason } => Err(format!("never covered it. {reason}")),
        }
    }

    /// The rate or probability.
    pub fn estimate(&self) -> f64 {
        match self {
            Self::Counts { effective, .. } => effective.successes / effective.trials,
            Self::Known { value, .. } | Self::Distribution { value, .. } => *value,
        }
    }

    /// An interval of the rate: Wilson's, the bounds, or a credible interval.
    pub fn interval(&self, confidence: Confidence) -> Interval {
        match self {
            Self::Counts { effective, .. } => stats::wilson(*effective, confidence),
            Self::Known { bounds, .. } => *bounds,
            Self::Distribution { posterior, .. } => posterior.credible_interval(confidence),
        }
    }

    /// The value that the rate reaches with `confidence`, one-sided: Clopper and Pearson's limit,
    /// the lower bound, or a quantile.
    pub fn lower_limit(&self, confidence: Confidence) -> f64 {
        match self {
            Self::Counts { effective, .. } => {
                IntervalMethod::ClopperPearson.lower_limit(*effective, confidence)
            }
            Self::Known { bounds, .. } => bounds.low,
            Self::Distribution { posterior, .. } => posterior.quantile(confidence.alpha()),
        }
    }

    /// The value that the rate does not exceed with `confidence`, one-sided, found as the lower limit.
    pub fn upper_limit(&self, confidence: Confidence) -> f64 {
        match self {
            Self::Counts { effective, .. } => {
                IntervalMethod::ClopperPearson.upper_limit(*effective, confidence)
            }
            Self::Known { bounds, .. } => bounds.high,
            Self::Distribution { posterior, .. } => posterior.quantile_upper(confidence.alpha()),
        }
    }

    /// The posterior of the rate; `None` for a computed probability without uncertain constants.
    pub fn posterior(&self) -> Option<BetaPosterior> {
        match self {
            Self::Counts { effective, .. } => Some(BetaPosterior::jeffreys(*effective)),
            Self::Known { .. } => None,
            Self::Distribution { posterior, .. } => Some(*posterior),
        }
    }

    /// Counts that say as much: at the effective size, or those whose Jeffreys posterior is the
    /// distribution. `None` for a probability that is known, or known less well than by one trial.
    pub fn worth_in_counts(&self) -> Option<EffectiveSample> {
        match self {
            Self::Counts { effective, .. } => Some(*effective),
            Self::Known { .. } => None,
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
            Self::Counts { sample, effective } => Some(sample.trials as f64 / effective.trials),
            _ => None,
        }
    }

    /// Whole counts near the effective ones, for exact tests: both neighbours of the successes at
    /// the effective size rounded down. The counts themselves where trials are independent.
    pub fn whole_counts(sample: Sample, effective: EffectiveSample) -> Vec<Sample> {
        if effective.trials >= sample.trials as f64 {
            return vec![sample];
        }
        let trials = effective.trials.floor().max(1.0);
        let successes = trials * effective.successes / effective.trials;
        let whole = |successes: f64| Sample {
            successes: successes as u64,
            trials: trials as u64,
        };
        let (below, above) = (whole(successes.floor()), whole(successes.ceil()));
        if below == above {
            vec![below]
        } else {
            vec![below, above]
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
    Ok(Belief::Counts { sample, effective })
}

fn computed(answer: &MethodAnswer, credible: Option<&CredibleInterval>) -> Result<Belief, String> {
    let value = answer.value;
    if let Some(posterior) = credible.and_then(moments_as_beta) {
        return Ok(Belief::Distribution { value, posterior });
    }
    match &answer.guarantee {
        Guarantee::Exact { .. } => Ok(Belief::Known {
            value,
            bounds: Interval {
                low: value,
                high: value,
            },
        }),
        Guarantee::Bounded { low, high } => Ok(Belief::Known {
            value,
            bounds: Interval {
                low: *low,
                high: *high,
            },
        }),
        Guarantee::Estimated { reason } => Err(format!(
            "has an answer whose error is unknown: {reason}; use a method with bounds"
        )),
    }
}

/// The beta distribution with the mean and variance of the draws; `None` when they do not vary.
fn moments_as_beta(credible: &CredibleInterval) -> Option<BetaPosterior> {
    let draws = stats::Draws::new(&credible.quantiles).ok()?;
    let (mean, variance) = (credible.mean, draws.variance());
    // Draws that differ by rounding only are one number.
    if variance.sqrt() <= 1e-12 {
        return None;
    }
    let size = mean * (1.0 - mean) / variance - 1.0;
    BetaPosterior::new(mean * size, (1.0 - mean) * size).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_counts_are_neighbours() {
        let sample = Sample {
            successes: 88,
            trials: 100,
        };
        let effective = EffectiveSample::at_size(sample, 55.3).unwrap();
        let whole = Belief::whole_counts(sample, effective);
        assert_eq!(
            whole,
            [
                Sample {
                    successes: 48,
                    trials: 55
                },
                Sample {
                    successes: 49,
                    trials: 55
                }
            ]
        );
        assert_eq!(Belief::whole_counts(sample, sample.into()), [sample]);
        let none = Sample {
            successes: 0,
            trials: 7,
        };
        let effective = EffectiveSample::at_size(none, 0.4).unwrap();
        assert_eq!(
            Belief::whole_counts(none, effective),
            [Sample {
                successes: 0,
                trials: 1
            }]
        );
    }

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
}
