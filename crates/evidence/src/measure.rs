//! From counts, solves and answers to measures: each number with its uncertainty.
//!
//! * Counts: Wilson's interval; where trials come in clusters, that of `stats::clustered`.
//! * Solves of a model at points of its constants' posteriors: the distribution of its answer.
//! * Two answers of one method: their quotient, with the bounds that theirs imply.
//!
//! Source: E. B. Wilson (1927) for the interval; `stats` for clusters and draws. Guarantee: bounds of a
//! quotient hold, since each division is rounded outwards.
//!
//! # Assumes
//! Trials are independent, or of clusters as `stats::clustered` has it, and fixed in number. Points of constants'
//! posteriors are of independent constants.

use crate::{
    CredibleInterval, EndDistribution, Guarantee, Interval, Measure, MethodAnswer, SchedulerEnds,
    Spread,
};
use stats::{
    ClusterMethod, ClusteredRate, CommonCorrelation, Confidence, EffectiveSample, Sample,
    SharesDesign, StatsError,
};

impl Measure {
    /// Counts with Wilson's interval at the effective number of trials.
    ///
    /// # Errors
    /// [`StatsError`] for an effective number that is no positive number.
    pub fn of_counts(
        sample: Sample,
        effective_trials: Option<f64>,
        level: Confidence,
    ) -> Result<Self, StatsError> {
        let interval = match effective_trials {
            Some(size) => stats::wilson(EffectiveSample::at_size(sample, size)?, level),
            None => stats::wilson(sample, level),
        };
        Ok(Self::Counts {
            count: sample.successes,
            trials: sample.trials,
            effective_trials,
            by_subject: None,
            subjects: None,
            interval: Interval {
                low: interval.low,
                high: interval.high,
            },
        })
    }

    /// Whether counts by subject or session are all of one of these.
    #[must_use]
    pub fn is_of_one_subject(&self) -> bool {
        match self {
            Self::Counts {
                by_subject,
                subjects,
                trials,
                ..
            } => {
                let is_alone = by_subject.as_ref().is_some_and(|all| all.len() == 1);
                *trials > 1 && (is_alone || *subjects == Some(1))
            }
            _ => false,
        }
    }

    /// Counts, and what they are worth in independent trials; none of what is no count, contradicts itself or has no trials.
    #[must_use]
    pub fn at_its_worth(&self) -> Option<(Sample, EffectiveSample)> {
        let Self::Counts {
            count,
            trials,
            effective_trials,
            ..
        } = *self
        else {
            return None;
        };
        let sample = Sample::new(count, trials).ok()?;
        let size = effective_trials.unwrap_or(trials as f64);
        Some((sample, EffectiveSample::at_size(sample, size).ok()?))
    }

    /// Counts by subject or session, whose trials may be alike.
    ///
    /// # Errors
    /// [`StatsError`] for more successes than trials, or no trials at all.
    ///
    /// ```
    /// use evidence::Measure;
    /// use stats::{Confidence, Sample};
    /// let subjects = [9, 10, 8, 7, 9, 10, 10, 6, 9, 10].map(|successes| Sample { successes, trials: 10 });
    /// let Measure::Counts { count, trials, effective_trials, .. } =
    ///     Measure::of_clusters(&subjects, Confidence::P95)? else { unreachable!() };
    /// assert_eq!((count, trials), (88, 100));
    /// assert!(effective_trials < Some(100.0));
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    pub fn of_clusters(by_subject: &[Sample], level: Confidence) -> Result<Self, StatsError> {
        let rate = stats::clustered_rate(by_subject, level)?;
        Ok(Self::of_rate(&rate, by_subject))
    }

    /// The same where more was counted of these subjects: a count that cannot tell how alike their trials are is
    /// given the correlation that all have in common.
    ///
    /// # Errors
    /// Those of [`Measure::of_clusters`].
    pub fn of_clusters_among(
        common: &CommonCorrelation,
        by_subject: &[Sample],
        level: Confidence,
    ) -> Result<Self, StatsError> {
        let rate = stats::clustered_rate_among(common, by_subject, level)?;
        Ok(Self::of_rate(&rate, by_subject))
    }

    /// A total of subjects with so many trials each, of whom it is not known who did what.
    ///
    /// # Errors
    /// Those of [`Measure::of_clusters`].
    pub fn of_total_among(
        common: &CommonCorrelation,
        total: Sample,
        trials_by_subject: &[u64],
        level: Confidence,
    ) -> Result<Self, StatsError> {
        let rate = common.rate(total, trials_by_subject, level)?;
        Ok(Self::of_rate(&rate, &[]))
    }

    fn of_rate(rate: &ClusteredRate, by_subject: &[Sample]) -> Self {
        let with_trials = by_subject.iter().filter(|one| one.trials > 0);
        let counts = with_trials.map(|one| [one.successes, one.trials]);
        let counts: Vec<[u64; 2]> = counts.collect();
        let has_several = counts.iter().any(|one| one[1] > 1);
        Self::Counts {
            by_subject: has_several.then_some(counts),
            // Trials that few attempts gave are of no more subjects than trials.
            subjects: (rate.method != ClusterMethod::Independent)
                .then_some((rate.clusters as u64).min(rate.total.trials)),
            count: rate.total.successes,
            trials: rate.total.trials,
            effective_trials: match rate.method {
                ClusterMethod::Independent => None,
                ClusterMethod::Profile | ClusterMethod::Common | ClusterMethod::OneEach => {
                    Some(rate.worth.trials)
                }
            },
            interval: Interval {
                low: rate.interval.low,
                high: rate.interval.high,
            },
        }
    }
}

/// Whether counts by subject or session are those of a total: they add up to its successes and its trials, none with more
/// successes than trials.
///
/// ```
/// use evidence::adds_up;
/// assert!(adds_up(&[[4, 5], [3, 5]], [7, 10]));
/// assert!(!adds_up(&[[6, 5], [1, 5]], [7, 10]));
/// assert!(!adds_up(&[[4, 5]], [7, 10]));
/// ```
#[must_use]
pub fn adds_up(by_subject: &[[u64; 2]], [successes, trials]: [u64; 2]) -> bool {
    let sum = |place: usize| -> u128 { by_subject.iter().map(|it| u128::from(it[place])).sum() };
    let possible = by_subject.iter().all(|it| it[0] <= it[1]);
    possible && [sum(0), sum(1)] == [u128::from(successes), u128::from(trials)]
}

impl CredibleInterval {
    /// What a model's answers (`values`) at points of its constants' posteriors say: one row of
    /// `points` for each value, one column for each of the `constants`.
    ///
    /// # Errors
    /// [`StatsError`] unless all values are finite and there is at least one.
    pub fn of_solves(
        constants: &[&str],
        points: &[Vec<f64>],
        values: &[f64],
        level: Confidence,
    ) -> Result<Self, StatsError> {
        let draws = stats::Draws::new(values)?;
        // A result that no constant moves has no variance to share.
        let shares = stats::variance_shares(points, values).unwrap_or_default();
        let spread: Vec<Spread> = constants
            .iter()
            .zip(shares)
            .map(|(constant, share)| Spread {
                constant: (*constant).to_owned(),
                // The squared correlation is the linear part of the first-order index
                // and thus never above it; the estimate of the whole may be.
                share: share.first_order.max(share.squared_correlation),
                total: None,
                error: None,
            })
            .collect();
        Ok(Self::of_draws(&draws, values.len(), spread, level))
    }

    /// What a model's answers at the rows of a design say: their distribution, and each constant's
    /// share in its variance, alone and with the others (`stats::propagation`).
    ///
    /// # Errors
    /// Those of [`SharesDesign::analyse`].
    ///
    /// ```
    /// use evidence::CredibleInterval;
    /// use stats::{BetaPosterior, Confidence, Sample, SharesDesign};
    /// let constants = [(7, 98), (2, 100)].map(|(successes, trials)| {
    ///     BetaPosterior::jeffreys(Sample { successes, trials })
    /// });
    /// let design = SharesDesign::new(&constants, 2000, 1);
    /// let values: Vec<f64> = design.rows().iter().map(|x| (1.0 - x[0]) * (1.0 - x[1])).collect();
    /// let found = CredibleInterval::of_design(&["p", "q"], &design, &values, Confidence::P95)?;
    /// assert_eq!(found.spread[0].constant, "p");
    /// assert!(found.spread[0].total > Some(0.7));
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    pub fn of_design(
        constants: &[&str],
        design: &SharesDesign,
        values: &[f64],
        level: Confidence,
    ) -> Result<Self, StatsError> {
        let found = design.analyse(values)?;
        let spread = constants
            .iter()
            .zip(&found.shares)
            .map(|(constant, share)| Spread {
                constant: (*constant).to_owned(),
                share: share.first_order,
                total: Some(share.total),
                error: Some(share.total_error.max(share.first_order_error)),
            })
            .collect();
        Ok(Self::of_draws(&found.draws, values.len(), spread, level))
    }

    /// What a model with choices says at the rows of a design: the least and the greatest probability over all schedulers
    /// at each, of which `worst` names that which is the subject's value.
    ///
    /// The interval reaches from the lower limit of the central interval of the least to the upper limit of that of the
    /// greatest probability: the posterior probability that the whole range lies within is at least the level
    /// (Bonferroni's inequality).
    ///
    /// # Errors
    /// Those of [`SharesDesign::analyse`].
    ///
    /// ```
    /// use evidence::{CredibleInterval, Worst};
    /// use stats::{BetaPosterior, Confidence, Sample, SharesDesign};
    /// let p = BetaPosterior::jeffreys(Sample { successes: 90, trials: 100 });
    /// let design = SharesDesign::new(&[p], 1000, 1);
    /// let ends = |of: fn(f64) -> f64| -> Vec<f64> { design.rows().iter().map(|x| of(x[0])).collect() };
    /// let (least, greatest) = (ends(|p| p * p), ends(|p| p));
    /// let found = CredibleInterval::of_ends(&["p"], &design, (&least, &greatest), Worst::Least, Confidence::P95)?;
    /// assert!((found.interval.low - p.quantile(0.025).powi(2)).abs() < 1e-3);
    /// assert!((found.interval.high - p.quantile(0.975)).abs() < 1e-3);
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    pub fn of_ends(
        constants: &[&str],
        design: &SharesDesign,
        (least, greatest): (&[f64], &[f64]),
        worst: Worst,
        level: Confidence,
    ) -> Result<Self, StatsError> {
        let least = Self::of_design(constants, design, least, level)?;
        let greatest = Self::of_design(constants, design, greatest, level)?;
        let interval = Interval {
            low: least.interval.low,
            high: greatest.interval.high,
        };
        let ends = SchedulerEnds {
            least: least.end(),
            greatest: greatest.end(),
        };
        let worst = match worst {
            Worst::Least => least,
            Worst::Greatest => greatest,
        };
        Ok(Self {
            interval,
            ends: Some(Box::new(ends)),
            ..worst
        })
    }

    fn end(&self) -> EndDistribution {
        EndDistribution {
            mean: self.mean,
            interval: self.interval,
            spread: self.spread.clone(),
            quantiles: self.quantiles.clone(),
        }
    }

    /// The same beside the ends of the range with the constants as they are written, as [`CredibleInterval::beside`].
    pub fn beside_ends(mut self, as_written: Interval) -> Self {
        if let Some(ends) = &mut self.ends {
            let (least, greatest) = (&mut ends.least, &mut ends.greatest);
            least.interval = least.interval.with(as_written.low).with(least.mean);
            greatest.interval = greatest.interval.with(as_written.high).with(greatest.mean);
            self.interval.low = self.interval.low.min(least.interval.low);
            self.interval.high = self.interval.high.max(greatest.interval.high);
        }
        self
    }

    /// The same beside the answer with the constants as they are written: no number lies outside the interval that is
    /// shown with it. The interval only becomes wider, so it holds at least at its level.
    pub fn beside(self, value: f64) -> Self {
        Self {
            interval: self.interval.with(value).with(self.mean),
            ..self
        }
    }

    fn of_draws(
        draws: &stats::Draws,
        solves: usize,
        mut spread: Vec<Spread>,
        level: Confidence,
    ) -> Self {
        spread.sort_by(|a, b| b.share.total_cmp(&a.share));
        let interval = draws.interval(level);
        Self {
            // A sum of many ones may round to more than one.
            mean: draws.mean().clamp(draws.quantile(0.0), draws.quantile(1.0)),
            interval: Interval {
                low: interval.low,
                high: interval.high,
            },
            solves: solves as u64,
            by_function: false,
            spread,
            quantiles: (0..100)
                .map(|i| draws.quantile((f64::from(i) + 0.5) / 100.0))
                .collect(),
            robust: None,
            ends: None,
            out_of_reach: 0.0,
        }
    }
}

/// Which end of the range over all schedulers is a subject's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Worst {
    /// The least probability, of a requirement.
    Least,
    /// The greatest, of a failure mode.
    Greatest,
}

impl MethodAnswer {
    /// A value of a model that was solved with a change, of whose error nothing is said.
    #[must_use]
    pub fn plain(value: f64) -> Self {
        Self {
            method: "plain".into(),
            value,
            complement: None,
            guarantee: Guarantee::Estimated {
                reason: "solved plainly, with a change".into(),
            },
            iterations: None,
        }
    }

    /// Bounds of the probability that hold for certain; `None` where there are none.
    pub fn bounds(&self) -> Option<Interval> {
        match &self.guarantee {
            Guarantee::Exact { .. } => Some(Interval {
                low: self.value,
                high: self.value,
            }),
            Guarantee::Bounded { low, high } | Guarantee::Schedulers { low, high, .. } => {
                Some(Interval {
                    low: *low,
                    high: *high,
                })
            }
            Guarantee::Statistical { .. } | Guarantee::Estimated { .. } => None,
        }
    }

    /// Where the probability lies, and with which probability it does not lie there; `None` where its error is unknown.
    pub(crate) fn within(&self) -> Option<(Interval, f64)> {
        let certain = self.bounds().map(|bounds| (bounds, 0.0));
        certain.or_else(|| self.guarantee.within())
    }

    /// The probability of the contrary, with the bounds that this one's imply.
    pub fn contrary(&self) -> MethodAnswer {
        let turned = |low: f64, high: f64| {
            // One step outwards: the subtraction rounds, except from 0.
            let low_of = |x: f64| {
                if x == 0.0 {
                    1.0
                } else {
                    (1.0 - x).next_down().max(0.0)
                }
            };
            let high_of = |x: f64| {
                if x == 0.0 {
                    1.0
                } else {
                    (1.0 - x).next_up().min(1.0)
                }
            };
            (low_of(high), high_of(low))
        };
        let guarantee = match &self.guarantee {
            Guarantee::Exact { .. } => {
                let (low, high) = turned(self.value, self.value);
                Guarantee::Bounded { low, high }
            }
            Guarantee::Bounded { low, high } => {
                let (low, high) = turned(*low, *high);
                Guarantee::Bounded { low, high }
            }
            Guarantee::Schedulers { low, high, worst } => {
                let (low, high) = turned(*low, *high);
                Guarantee::Schedulers {
                    low,
                    high,
                    worst: worst.clone(),
                }
            }
            Guarantee::Statistical {
                confidence,
                low,
                high,
            } => {
                let (low, high) = turned(*low, *high);
                Guarantee::Statistical {
                    confidence: *confidence,
                    low,
                    high,
                }
            }
            Guarantee::Estimated { reason } => Guarantee::Estimated {
                reason: reason.clone(),
            },
        };
        MethodAnswer {
            method: self.method.clone(),
            value: 1.0 - self.value,
            complement: Some(self.value),
            guarantee,
            iterations: self.iterations,
        }
    }

    /// This probability given that of its opportunity, with the bounds that theirs imply. Where one is statistical, both lie
    /// where they are said to lie with at least one minus the sum of their doubts (Bonferroni), however they depend.
    pub fn quotient(&self, opportunity: &MethodAnswer) -> MethodAnswer {
        let guarantee = match (self.within(), opportunity.within()) {
            (Some((this, doubt)), Some((other, others_doubt)))
                if other.low > 0.0 && doubt + others_doubt < 1.0 =>
            {
                // One step outwards each: the divisions round.
                let low = match this.low > 0.0 {
                    true => (this.low / other.high).next_down().clamp(0.0, 1.0),
                    false => 0.0,
                };
                let high = match this.high > 0.0 {
                    true => (this.high / other.low).next_up().min(1.0),
                    false => 0.0,
                };
                match doubt + others_doubt {
                    0.0 => Guarantee::Bounded { low, high },
                    doubt => Guarantee::Statistical {
                        confidence: 1.0 - doubt,
                        low,
                        high,
                    },
                }
            }
            _ => Guarantee::Estimated {
                reason: "the quotient of two estimates".into(),
            },
        };
        MethodAnswer {
            method: self.method.clone(),
            value: (self.value / opportunity.value).min(1.0),
            complement: None,
            guarantee,
            iterations: self.iterations.max(opportunity.iterations),
        }
    }
}
