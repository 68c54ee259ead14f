//! How strongly two pieces of evidence speak against having the same rate.
//!
//! # Definition
//! `strength = log10 P(data | two rates) / P(data | one rate)`, the decimal logarithm of the Bayes
//! factor for a difference. A rate of which nothing is known has Jeffreys' prior Beta(1/2, 1/2), so
//! that `k` of `n` has the marginal likelihood `m(k, n) = B(k + 1/2, n - k + 1/2) / B(1/2, 1/2)`
//! (binomial coefficients are the same under both and left out).
//!
//! * counts and counts: `m(k1, n1) m(k2, n2) / m(k1 + k2, n1 + n2)`;
//! * a computed value `v` and counts: one rate means that it is somewhere in `v - w .. v + w`, uniformly,
//!   since models that agree within the declared margin agree. With `w` the margin;
//! * two computed values: 0 if they are within the margin, else [`CERTAIN`];
//! * a failure that a model excludes ([`Rate::Never`]): a value of 0 with a tenth of the margin. That something cannot
//!   happen is a claim of its own, which no margin for rates softens; what is left is for runs that were taken for
//!   another kind of failure by mistake.
//!
//! Any other difference within the margin is weighed again with a tenth of the margin and counts at most 1, so
//! that it is named, but behind all that matters; one that is larger than the margin, but may be within it by chance, at
//! most [`AROUND_MARGIN`]: a comparison calls it a conflict. Effective sizes take the place of sizes where trials
//! are clustered.
//!
//! Of runs without a verdict each may have counted or not ([`mod@crate::completions`]): two rates are weighed where these
//! runs bring them nearest to each other, so that nobody is accused of what they alone could explain.
//!
//! # Source
//! H. Jeffreys, "Theory of Probability" (3rd ed., 1961), section 5.01 and appendix B; R. E. Kass and A. E.
//! Raftery, "Bayes factors", Journal of the American Statistical Association 90 (1995), sections 3.2 and
//! 4. Their scale: above 0.5 substantial, above 1 strong, above 2 decisive. Deviation: the uniform window
//! for computed values, and that strengths are cut at [`CERTAIN`].
//!
//! # Assumes
//! Trials are independent, or count at their effective size, and both sides are independent of each other. A rate of which
//! nothing is known has Jeffreys' prior; a computed value is off by anything within the margin with equal probability,
//! whatever its own bounds or draws say.
//!
//! # Cost and guarantee
//! 2048 evaluations of a likelihood for a computed value, else a constant. The window is integrated by
//! the midpoint rule, over the part of it that has likelihood: relative error below 1e-3 of the Bayes
//! factor (tested against exact integrals).

use crate::{Evidence, Finding, Measure, Subject};
use stats::special::ln_gamma;

/// What is strong evidence, in decades: a Bayes factor of 10, by Jeffreys' scale.
pub const STRONG: f64 = 1.0;

/// The strength of what cannot be otherwise: a greater one is cut to this.
pub const CERTAIN: f64 = 100.0;

/// The most that a difference within the margin counts.
const WITHIN_MARGIN: f64 = 1.0;

/// The most that a difference counts which is larger than the margin, but may be within it by chance.
const AROUND_MARGIN: f64 = 1.5;

/// The part of the margin with which a difference within it is weighed again.
const SMALL: f64 = 0.1;

/// Points at which a likelihood is evaluated.
const POINTS: u32 = 2048;

/// What is known of a rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// Counts, worth `count` of `trials` independent ones, or up to `open` more of as many.
    Counted {
        /// How often at the least.
        count: f64,
        /// How many of the others may count or not.
        open: f64,
        /// Of how many.
        trials: f64,
    },
    /// A value that was computed from a model.
    Computed(f64),
    /// A failure that a model excludes: it computes exactly 0, or has nothing that could be it.
    Never,
}

impl Rate {
    /// The counted share of the trials, or the computed value; none of what never comes.
    #[must_use]
    pub fn share(self) -> Option<f64> {
        match self {
            Self::Counted { count, trials, .. } => (trials > 0.0).then(|| count / trials),
            Self::Computed(value) => Some(value),
            Self::Never => None,
        }
    }

    /// Whether it is a count of trials that all came out alike.
    #[must_use]
    pub fn has_one_outcome(self) -> bool {
        match self {
            Self::Counted {
                count,
                open,
                trials,
            } => count + open <= 0.0 || count >= trials,
            Self::Computed(_) | Self::Never => false,
        }
    }

    /// The rate of a finding, if it has one.
    pub fn of(finding: &Finding) -> Option<Self> {
        let whole = Self::decided(&finding.measure);
        let Some(completions) = &finding.completions else {
            return whole;
        };
        let ends: Vec<[f64; 2]> = completions
            .ends
            .iter()
            .filter_map(|end| match Self::decided(end)? {
                Self::Counted { count, trials, .. } => Some([count / trials, trials]),
                Self::Computed(_) | Self::Never => None,
            })
            .collect();
        let least = ends.iter().map(|it| it[0]).fold(f64::INFINITY, f64::min);
        let most = ends.iter().map(|it| it[0]).fold(0.0, f64::max);
        let trials = ends.iter().map(|it| it[1]).fold(f64::INFINITY, f64::min);
        match ends.is_empty() {
            true => whole,
            false => Some(Self::Counted {
                count: least * trials,
                open: (most - least) * trials,
                trials,
            }),
        }
    }

    /// That of what is known of all runs.
    fn decided(measure: &Measure) -> Option<Self> {
        match measure {
            Measure::Counts {
                count,
                trials,
                effective_trials,
                ..
            } if *trials > 0 => {
                let size = effective_trials.unwrap_or(*trials as f64);
                let share = *count as f64 / *trials as f64;
                Some(Self::Counted {
                    count: share * size,
                    open: 0.0,
                    trials: size,
                })
            }
            Measure::Probability { answer, .. } => Some(Self::Computed(answer.value)),
            _ => None,
        }
    }

    /// The rate of a piece on a subject, if it has one. A failure mode of which a model computes exactly 0, by a method
    /// whose bounds hold, is excluded by it.
    pub fn on(piece: &Evidence, subject: &Subject) -> Option<Self> {
        let finding = piece.finding(subject)?;
        match &finding.measure {
            Measure::Probability { answer, .. } if answer.guarantee.is_certain() => {
                Some(Self::claimed(answer.value, subject))
            }
            _ => Self::of(finding),
        }
    }

    /// The same, and of a model whose property has one truth value whatever its commands do, that value: no evidence of how the
    /// system behaves, but what the model would say if that were meant.
    pub fn asked(piece: &Evidence, subject: &Subject) -> Option<Self> {
        let constant = match &piece.finding(subject)?.measure {
            Measure::NotCovered { constant, .. } => *constant,
            _ => None,
        };
        let value = constant.map(|truth| Self::Computed(if truth { 1.0 } else { 0.0 }));
        value.or_else(|| Self::on(piece, subject))
    }

    /// What a model says that computes this value; a failure mode with the value 0 is excluded by it.
    #[must_use]
    pub fn claimed(value: f64, subject: &Subject) -> Self {
        match subject {
            Subject::FailureMode(_) if value == 0.0 => Self::Never,
            _ => Self::Computed(value),
        }
    }

    /// The rate of the contrary; that something is certain excludes the contrary.
    pub(super) fn of_contrary(self) -> Self {
        match self {
            Self::Counted {
                count,
                open,
                trials,
            } => Self::Counted {
                count: (trials - count - open).max(0.0),
                open,
                trials,
            },
            Self::Computed(1.0) => Self::Never,
            Self::Computed(value) => Self::Computed(1.0 - value),
            Self::Never => Self::Computed(1.0),
        }
    }

    /// The value of one that was not counted.
    #[must_use]
    pub fn computed(self) -> Option<f64> {
        match self {
            Self::Computed(value) => Some(value),
            Self::Never => Some(0.0),
            Self::Counted { .. } => None,
        }
    }

    /// How far the rate of the system may be from what is said of it, of a declared margin.
    fn window(self, margin: f64) -> f64 {
        match self {
            Self::Never => margin * SMALL,
            Self::Computed(_) | Self::Counted { .. } => margin,
        }
    }

    /// Counts of independent trials.
    pub fn counted(count: u64, trials: u64) -> Self {
        Self::Counted {
            count: count as f64,
            open: 0.0,
            trials: trials as f64,
        }
    }

    /// All that were counted as one count.
    pub(super) fn pooled(rates: &[Self]) -> Self {
        let (mut count, mut open, mut trials) = (0.0, 0.0, 0.0);
        for rate in rates {
            if let Self::Counted {
                count: k,
                open: u,
                trials: n,
            } = rate
            {
                (count, open, trials) = (count + k, open + u, trials + n);
            }
        }
        Self::Counted {
            count,
            open,
            trials,
        }
    }

    /// The least and the greatest share that it may be.
    #[must_use]
    pub fn shares(self) -> [f64; 2] {
        match self {
            Self::Counted { trials, .. } if trials <= 0.0 => [0.0, 1.0],
            Self::Counted {
                count,
                open,
                trials,
            } => [count / trials, (count + open) / trials],
            Self::Computed(value) => [value; 2],
            Self::Never => [0.0; 2],
        }
    }

    /// What is counted, of how many, if the open ones bring it as near to a share as they can.
    fn toward(self, share: f64) -> Option<[f64; 2]> {
        match self {
            Self::Counted {
                count,
                open,
                trials,
            } => Some([(share * trials).clamp(count, count + open), trials]),
            Self::Computed(_) | Self::Never => None,
        }
    }
}

/// How far two rates are apart where they are nearest to each other.
fn gap(one: Rate, other: Rate) -> f64 {
    let ([low, high], [other_low, other_high]) = (one.shares(), other.shares());
    (low - other_high).max(other_low - high).max(0.0)
}

/// The share at which two rates are nearest to each other.
fn meeting(one: Rate, other: Rate) -> f64 {
    let ([low, high], [other_low, other_high]) = (one.shares(), other.shares());
    // Between the inner ends, whether these leave a gap or overlap.
    (low.max(other_low) + high.min(other_high)) / 2.0
}

/// How strongly two rates differ, from 0 (not at all) to [`CERTAIN`].
pub fn strength(one: Rate, other: Rate, margin: f64) -> f64 {
    let whole = against_one_rate(one, other, margin);
    let most = match gap(one, other) > margin {
        true => AROUND_MARGIN,
        false => WITHIN_MARGIN,
    };
    let strength = if whole >= most {
        whole
    } else {
        against_one_rate(one, other, margin * SMALL).clamp(whole, most)
    };
    strength.clamp(0.0, CERTAIN)
}

/// A strength in words: a Bayes factor, or what stands for one where a difference may lie within the margin.
pub(crate) fn weighed(strength: f64) -> String {
    let most = match strength {
        it if it == AROUND_MARGIN => "a difference that may lie within the margin by chance",
        it if it == WITHIN_MARGIN => "a difference within the margin",
        _ => return format!("with a Bayes factor of 10^{strength:.1}"),
    };
    format!("weighed at 10^{strength:.1}, the most for {most}")
}

/// The same, below 0 by how strongly the data speak for one rate, in decades.
pub fn signed_strength(one: Rate, other: Rate, margin: f64) -> f64 {
    let strength = strength(one, other, margin);
    match strength > 0.0 {
        true => strength,
        false => against_one_rate(one, other, margin).min(0.0),
    }
}

/// The decimal logarithm of the Bayes factor.
fn against_one_rate(one: Rate, other: Rate, margin: f64) -> f64 {
    let share = meeting(one, other);
    match (one.toward(share), other.toward(share)) {
        (Some([count, trials]), Some([other_count, other_trials])) => {
            let apart = marginal(count, trials) + marginal(other_count, other_trials);
            in_decades(apart - marginal(count + other_count, trials + other_trials))
        }
        (Some([count, trials]), None) | (None, Some([count, trials])) => {
            let claim = match one {
                Rate::Counted { .. } => other,
                Rate::Computed(_) | Rate::Never => one,
            };
            let value = claim.computed().unwrap_or_default();
            let one_rate = near(value, claim.window(margin), count, trials);
            in_decades(marginal(count, trials) - one_rate)
        }
        (None, None) => {
            let [a, b] = [one, other].map(|it| it.computed().unwrap_or_default());
            match (a - b).abs() <= margin {
                true => 0.0,
                false => CERTAIN,
            }
        }
    }
}

fn in_decades(natural: f64) -> f64 {
    natural / std::f64::consts::LN_10
}

/// `ln m(k, n)`.
fn marginal(count: f64, trials: f64) -> f64 {
    ln_beta(count + 0.5, trials - count + 0.5) - ln_beta(0.5, 0.5)
}

fn ln_beta(a: f64, b: f64) -> f64 {
    ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b)
}

/// How often the open runs of several counts are brought nearer to the rate of all.
const ROUNDS: u32 = 8;

/// `ln P(data | all have one rate)`; of equal computed values nothing is left to explain. Open runs count as they fit best.
pub fn ln_together(rates: &[Rate], margin: f64) -> f64 {
    let mut computed: Option<f64> = None;
    let mut window = margin;
    let mut is_contradiction = false;
    for rate in rates {
        if let Some(value) = rate.computed() {
            is_contradiction |= computed.is_some_and(|first| (first - value).abs() > margin);
            // That it cannot happen says more than that it is rare.
            computed = match *rate {
                Rate::Never => Some(0.0),
                _ => computed.or(Some(value)),
            };
            window = window.min(rate.window(margin));
        }
    }
    let [count, trials] = pooled(rates, computed);
    // Relative to what the counts would weigh by themselves: that alone can be much less than a certainty.
    let least = marginal(count, trials) - CERTAIN * std::f64::consts::LN_10;
    match computed {
        Some(_) if is_contradiction => least,
        Some(value) => near(value, window, count, trials).max(least),
        None => marginal(count, trials),
    }
}

/// All counts in one, their open runs as near to the computed value, or else to the share of all, as they can be.
fn pooled(rates: &[Rate], computed: Option<f64>) -> [f64; 2] {
    let summed = |share: &dyn Fn(Rate) -> f64| {
        let counted = rates.iter().filter_map(|rate| rate.toward(share(*rate)));
        counted.fold([0.0, 0.0], |sum, [count, trials]| {
            [sum[0] + count, sum[1] + trials]
        })
    };
    if let Some(value) = computed {
        return summed(&|_| value);
    }
    let mut sum = summed(&|rate| rate.shares().iter().sum::<f64>() / 2.0);
    for _ in 0..ROUNDS {
        let share = sum[0] / sum[1].max(1.0);
        sum = summed(&|_| share);
    }
    sum
}

/// The logarithm of the mean likelihood of counts over `value - window .. value + window`.
fn near(value: f64, window: f64, count: f64, trials: f64) -> f64 {
    let (low, high) = ((value - window).max(0.0), (value + window).min(1.0));
    if trials <= 0.0 {
        return 0.0;
    }
    if high <= low {
        return ln_likelihood(value.clamp(0.0, 1.0), count, trials);
    }
    // Farther than 40 deviations from the likelihood's peak there is nothing, unless the window is there.
    let peak = (count / trials).clamp(low, high);
    let deviation = (peak * (1.0 - peak) / trials).sqrt().max(1.0 / trials);
    let from = low.max(peak - 40.0 * deviation);
    let to = high.min(peak + 40.0 * deviation);
    let step = (to - from) / f64::from(POINTS);
    let at = |i: u32| ln_likelihood(from + (f64::from(i) + 0.5) * step, count, trials);
    let greatest = (0..POINTS).map(at).fold(f64::NEG_INFINITY, f64::max);
    if greatest == f64::NEG_INFINITY {
        return greatest;
    }
    let sum: f64 = (0..POINTS).map(|i| (at(i) - greatest).exp()).sum();
    greatest + (sum * step / (high - low)).ln()
}

fn ln_likelihood(rate: f64, count: f64, trials: f64) -> f64 {
    let part = |number: f64, share: f64| {
        if number > 0.0 {
            number * share.ln()
        } else {
            0.0
        }
    };
    part(count, rate) + part(trials - count, 1.0 - rate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bayes_factor_of_two_counts_is_that_of_the_closed_form() {
        // One head and one tail: m(1,1) = 1/2, m(0,1) = 1/2, m(1,2) = B(1.5, 1.5)/B(.5, .5) = 1/8.
        let found = against_one_rate(Rate::counted(1, 1), Rate::counted(0, 1), 0.0);
        assert!((found - 2.0_f64.log10()).abs() < 1e-12, "{found}");
    }

    #[test]
    fn the_window_is_integrated() {
        // All rates are within reach: the mean likelihood of k of n is B(k+1, n-k+1).
        for (count, trials) in [(0.0, 5.0), (3.0, 10.0), (990.0, 1000.0), (5e5, 1e6)] {
            let exact = ln_beta(count + 1.0, trials - count + 1.0);
            let found = near(0.5, 0.5, count, trials);
            assert!(
                (found - exact).abs() < 1e-3,
                "{count} of {trials}: {found} {exact}"
            );
        }
    }

    /// However much counts weigh by themselves, that two models contradict each other is against what they say together.
    #[test]
    fn models_that_contradict_each_other_have_no_rate_with_many_counts() {
        let (one, other) = (Rate::Computed(0.65), Rate::Computed(0.87));
        for trials in [10, 1_000, 100_000] {
            let counted = Rate::counted(trials * 87 / 100, trials);
            let [with_both, with_one, alone] =
                [&[one, other, counted][..], &[other, counted], &[counted]]
                    .map(|rates| ln_together(rates, 0.05));
            assert!(with_both < with_one, "{trials}: {with_both} {with_one}");
            let against = (alone - with_both) / std::f64::consts::LN_10;
            assert!((against - CERTAIN).abs() < 1e-9, "{trials}: {against}");
        }
    }

    #[test]
    fn what_a_model_excludes_is_certain_and_what_is_near_counts_little() {
        let all = Rate::Computed(1.0);
        assert_eq!(strength(all, Rate::counted(5_000, 10_000), 0.05), CERTAIN);
        assert!(strength(all, Rate::counted(80, 100), 0.05) > 2.0);
        let near = strength(all, Rate::counted(98, 100), 0.05);
        assert!((0.0..=WITHIN_MARGIN).contains(&near), "{near}");
        assert_eq!(strength(all, Rate::counted(100, 100), 0.05), 0.0);
        assert_eq!(strength(all, Rate::Computed(0.5), 0.05), CERTAIN);
        assert_eq!(strength(all, Rate::Computed(0.97), 0.05), WITHIN_MARGIN);
        assert_eq!(strength(all, Rate::Computed(1.0), 0.05), 0.0);
    }

    #[test]
    fn what_cannot_happen_is_held_to_a_tenth_of_the_margin() {
        let seen = Rate::counted(30, 1000);
        assert!(strength(Rate::Computed(0.0), seen, 0.05) <= WITHIN_MARGIN);
        assert!(strength(Rate::Never, seen, 0.05) > 5.0);
        assert_eq!(strength(Rate::Never, Rate::counted(0, 1000), 0.05), 0.0);
        // One of a thousand may have been written down as another kind.
        assert_eq!(strength(Rate::Never, Rate::counted(1, 1000), 0.05), 0.0);
        // Another model that takes it for rare agrees within the margin, as ever.
        assert!(strength(Rate::Never, Rate::Computed(0.03), 0.05) <= WITHIN_MARGIN);
        let apart = ln_together(&[Rate::Never, seen], 0.05);
        assert!(apart < ln_together(&[Rate::Computed(0.0), seen], 0.05));
    }

    #[test]
    fn more_of_the_same_difference_is_stronger_and_order_does_not_matter() {
        let at = |n: u64| {
            strength(
                Rate::counted(20 * n, 100 * n),
                Rate::counted(3 * n, 100 * n),
                0.05,
            )
        };
        assert!(at(1) > 1.0 && at(2) > at(1) && at(10) > at(2));
        let turned = strength(Rate::counted(3, 100), Rate::counted(20, 100), 0.05);
        assert!((at(1) - turned).abs() < 1e-12);
    }

    #[test]
    fn clustered_trials_are_worth_less() {
        let of = |effective_trials| {
            Rate::decided(&Measure::Counts {
                by_subject: None,
                subjects: None,
                count: 20,
                trials: 100,
                effective_trials,
                interval: crate::Interval {
                    low: 0.1,
                    high: 0.3,
                },
            })
            .expect("a rate")
        };
        let other = Rate::counted(3, 100);
        assert!(strength(of(Some(50.0)), other, 0.05) < strength(of(None), other, 0.05));
    }

    /// Against every way in which the open runs may have ended, one after the other.
    #[test]
    fn open_runs_count_as_they_bring_two_rates_nearest() {
        let open = |count: u64, open: u64, trials: u64| Rate::Counted {
            count: count as f64,
            open: open as f64,
            trials: trials as f64,
        };
        let least = |one: (u64, u64, u64), other: &dyn Fn(u64) -> Rate, many: u64| {
            let ways = (0..=one.1).flat_map(|k| (0..=many).map(move |l| (k, l)));
            ways.map(|(k, l)| strength(Rate::counted(one.0 + k, one.2), other(l), 0.05))
                .fold(f64::INFINITY, f64::min)
        };
        for one in [(80, 15, 100), (10, 5, 40), (0, 30, 60), (58, 2, 60)] {
            let own = open(one.0, one.1, one.2);
            for (count, many, trials) in [(40, 0, 50), (5, 20, 50), (1, 3, 30), (70, 5, 200)] {
                let found = strength(own, open(count, many, trials), 0.05);
                let least = least(one, &|more| Rate::counted(count + more, trials), many);
                assert!(
                    found <= least + 0.02 && found > least - 0.2,
                    "{found} {least}"
                );
            }
            for value in [0.0, 0.3, 0.97] {
                let found = strength(own, Rate::Computed(value), 0.05);
                let least = least(one, &|_| Rate::Computed(value), 0);
                assert!((found - least).abs() < 0.2, "{found} {least}");
            }
        }
        // Twelve of twenty open runs explain the whole difference.
        assert!(strength(open(70, 20, 100), Rate::counted(82, 100), 0.05) < STRONG);
        assert!(strength(Rate::counted(70, 80), Rate::counted(30, 100), 0.05) > 2.0);
    }

    #[test]
    fn what_nobody_saw_speaks_for_nothing() {
        for other in [Rate::counted(3, 40), Rate::Computed(0.5), Rate::Never] {
            assert_eq!(strength(Rate::counted(0, 0), other, 0.05), 0.0);
            assert!(ln_together(&[Rate::counted(0, 0), other], 0.05).is_finite());
        }
    }
}
