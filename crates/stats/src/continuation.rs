//! Tests that stay valid when trials are added and the same question is asked again.
//!
//! # Definition
//! The trials between two looks are a *stage*. A test at level `a` starts with the conditional error `b = a`: the
//! probability, under the null hypothesis and given all that was seen, of ever rejecting it from here on. A stage gives
//! a p-value `u` of its own, uniform (or larger) given the past if the hypothesis is true, and turns `b` into
//!
//! ```text
//! b' = 1                     if u <= r b              rejected at this look
//! b' = min(1, k u^-s)        else,    k such that  integral over (r b, 1] of min(1, k u^-s) du = (1 - r) b
//! ```
//!
//! so that `b'` has mean `b`: it is a martingale between 0 and 1 that starts at `a`, and reaches 1 with probability at
//! most `a` whatever the number of looks and however the size of the next stage is chosen from all that was seen. The
//! hypothesis is rejected at the first look with `b' = 1`. The *p-value under continuation* is the least `a` at which it
//! would be rejected by now; `b'` grows with `a` at every `u`, so that the tests of all levels are nested.
//!
//! `r = 1 - (1 - R)^g` and `s = S sqrt(g)`, where `g` is the stage's information relative to all before it, at most 1;
//! `R = 0.8` and `S = 1.8`. Of the first stage `g` is 1, so that a first look at which a study ends costs a fifth of its level: its
//! p-value is `u / R`. Where no outcome of it could come out at 5 % (two trials), `g` is the less, and later stages are held
//! against what a first look would need: a glance at few trials leaves the level to those that follow.
//! `k u^-s` is near to the conditional error of a test at the end of a stage as large as all so far.
//!
//! No p-value is below the one that all trials would have if this was the only look: what an early look showed and all trials
//! together do not is not claimed. That takes claims away and adds none.
//!
//! # Stages
//! * *Counts against a threshold* ([`continued_above`], [`continued_below`]): the stage's own trials are binomial at the
//!   threshold. An outcome `x` stands for the `u` between `P(X > x)` and `P(X >= x)`, and `b'` is the mean over these.
//!   That is exact: nothing is lost to whole numbers but within the look that rejects. Monotone in `x`, so that it holds
//!   for every rate beyond the threshold, too.
//! * *Anything with a p-value at each look* ([`continued_p`]): of the p-value `P` of all trials at a look and their
//!   information `I`, the score is `z sqrt(I)`, `z` the normal quantile of `1 - P`; the difference of two scores over the
//!   root of the information between them is the stage's normal deviate. Two samples, equivalence and clustered counts
//!   are tested so; of clustered counts stages of few people by their exact distribution ([`continued_clusters_above`]).
//!
//! # Source
//! The conditional error principle: H.-H. Mueller and H. Schaefer, "A general statistical principle for changing a
//! design any time during the course of a trial", Statistics in Medicine 23 (2004); M. Proschan and S. Hunsberger,
//! "Designed extension of studies based on conditional power", Biometrics 51 (1995). Nested levels to p-values:
//! W. Brannath, M. Posch and P. Bauer, "Recursive combination tests", JASA 97 (2002). Martingales: J. Ville (1939);
//! G. Shafer, "Testing by betting", JRSS A 184 (2021). Deviation: the form of `b'` above is this project's, chosen so
//! that it has a closed integral, for whatever stages come.
//!
//! # Assumes
//! All looks are given, none left out for what it showed, and later counts contain the trials of earlier ones. Given what
//! was seen, the trials of a stage are independent with the same rate; how many there are may depend on all that was seen.
//! By scores: increments are independent and normal.
//!
//! # Guarantee
//! Counts against a threshold: the probability of ever rejecting a true hypothesis at level `a` is at most `a`, exactly,
//! for every rule of going on that looks only at what was seen (tested by the sum over all paths). By scores: as far as
//! scores have independent normal increments, which counts have asymptotically; measured rates are in
//! `evidence/ERROR_RATES.md`.
//!
//! Shares in percent of 4000 seeded studies that show the rate to be above 0.9 at a level of 5 %; 60 trials, doubled up to
//! four times (`cargo run -p corroborate-stats --release --example looking_again`; standard error at most 0.7). *Single*: each look is
//! tested as if it was the only one.
//!
//! | rate | first look, single | any look, single | first look, continued | any look, continued |
//! |---|---|---|---|---|
//! | 0.9 (false) | 1.4 | 12.5 | 1.4 | 3.5 |
//! | 0.95 (true) | 19.7 | 100.0 | 19.7 | 90.2 |

mod clusters;

pub use clusters::{ClusteredLook, continued_clusters_above, continued_clusters_below};

use crate::binomial::binomial_test_above;
use crate::counts::{Confidence, Interval, Sample};
use crate::special::{normal_cdf, normal_quantile};

/// Share of the conditional error that a look spends when it doubles the information, or is the first.
pub const SHARE_OF_A_LOOK: f64 = 0.8;

/// A first look at which no p-value can be as low cannot come out at a level of 5 %.
pub const LEAST_OF_A_FIRST: f64 = SHARE_OF_A_LOOK * 0.05;

/// The exponent `s` of such a look.
const STEEPNESS: f64 = 1.8;

/// Deviates beyond this are no better evidence: their p-value is about 1e-300.
const MOST_DEVIATE: f64 = 37.0;

/// Deviates to the contrary beyond this are taken for it. A p-value of 1 says that no outcome could be further from showing the
/// claim, of two trials as of two hundred; and what is added later would get the credit for all by which it is better.
const LEAST_DEVIATE: f64 = -2.0;

/// The trials between two looks, as far as a test sees them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stage {
    /// Its information relative to all before it, at most 1; 1 for the first.
    growth: f64,
    /// The p-values for which its outcome stands: from, to.
    outcome: (f64, f64),
}

/// One look at all trials so far: the p-value that they would have if it was the only look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScoredLook {
    /// The one-sided p-value of all trials so far.
    pub p: f64,
    /// Their information, in any unit, such as the effective number of trials.
    pub information: f64,
}

/// What is spent at a look, and how the rest is kept.
#[derive(Clone, Copy, Debug)]
struct Spending {
    /// Rejected up to here.
    rejected: f64,
    /// `b' = 1` up to here, too.
    certain: f64,
    /// `k` and `s` of the rest.
    scale: f64,
    steepness: f64,
}

impl Spending {
    fn new(budget: f64, growth: f64) -> Self {
        let uncapped = Self::uncapped(budget, growth);
        if !uncapped.is_too_much() {
            return uncapped;
        }
        // Capped at 1 up to a point at which the integral is as wanted.
        let kept = budget - uncapped.rejected;
        let (mut low, mut high) = (uncapped.rejected, 1.0);
        for _ in 0..60 {
            let middle = f64::midpoint(low, high);
            if uncapped.capped_integral(middle) <= kept {
                low = middle;
            } else {
                high = middle;
            }
        }
        Self {
            certain: low,
            scale: low.powf(uncapped.steepness),
            ..uncapped
        }
    }

    /// With `k u^-s` as it is, though it may be above 1.
    fn uncapped(budget: f64, growth: f64) -> Self {
        let share = 1.0 - (1.0 - SHARE_OF_A_LOOK).powf(growth);
        let steepness = STEEPNESS * growth.sqrt();
        let rejected = share * budget;
        Self {
            rejected,
            certain: rejected,
            scale: (budget - rejected) / power_integral(rejected, 1.0, steepness),
            steepness,
        }
    }

    /// Whether `k u^-s` is above 1 somewhere.
    fn is_too_much(&self) -> bool {
        self.scale > self.rejected.powf(self.steepness)
    }

    /// The integral of `min(1, k u^-s)` behind what is rejected, if it is 1 up to `end`.
    fn capped_integral(&self, end: f64) -> f64 {
        let rest = end.powf(self.steepness) * power_integral(end, 1.0, self.steepness);
        end - self.rejected + rest
    }

    /// Whether a look with this budget rejects at p-values up to `high`: as `new(budget, growth).mean(low, high) >= 1`,
    /// without the search for the point up to which it does.
    fn is_certain(budget: f64, growth: f64, high: f64) -> bool {
        let uncapped = Self::uncapped(budget, growth);
        high <= uncapped.rejected
            || uncapped.is_too_much()
                && uncapped.capped_integral(high) <= budget - uncapped.rejected
    }

    /// The mean of `b'` over p-values from `low` to `high`.
    fn mean(&self, low: f64, high: f64) -> f64 {
        let end = self.certain.max(self.rejected);
        if high <= end {
            return 1.0;
        }
        if high <= low {
            return (self.scale * high.powf(-self.steepness)).min(1.0);
        }
        let from = low.max(end);
        let sure = (end - low).max(0.0);
        let rest = self.scale * power_integral(from, high, self.steepness);
        ((sure + rest) / (high - low)).min(LESS_THAN_CERTAIN)
    }
}

/// A conditional error below this is none.
const LEAST_BUDGET: f64 = 1e-100;

/// What rounding must not make 1.
const LESS_THAN_CERTAIN: f64 = 1.0 - f64::EPSILON;

/// The integral of `u^-s` from `low` to `high`.
fn power_integral(low: f64, high: f64, s: f64) -> f64 {
    if (s - 1.0).abs() < 1e-9 {
        return (high / low).ln();
    }
    (high.powf(1.0 - s) - low.powf(1.0 - s)) / (1.0 - s)
}

/// Whether a test at this level has rejected by the last stage.
fn rejects(stages: &[Stage], level: f64) -> bool {
    let Some((last, before)) = stages.split_last() else {
        return level >= 1.0;
    };
    let mut budget = level;
    let is_open = |budget: f64| (LEAST_BUDGET..1.0).contains(&budget);
    for stage in before {
        if !is_open(budget) {
            return budget >= 1.0;
        }
        let (low, high) = stage.outcome;
        budget = Spending::new(budget, stage.growth).mean(low, high);
    }
    match is_open(budget) {
        true => Spending::is_certain(budget, last.growth, last.outcome.1),
        false => budget >= 1.0,
    }
}

/// The p-value under continuation of these stages alone: 1 without any. It never rises from look to look.
#[must_use]
pub fn p_of_stages(stages: &[Stage]) -> f64 {
    if stages.is_empty() || !rejects(stages, LESS_THAN_CERTAIN) {
        return 1.0;
    }
    // Geometric, since levels of interest are small.
    let (mut low, mut high) = (LEAST_BUDGET.ln(), 0.0_f64);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if rejects(stages, middle.exp().min(LESS_THAN_CERTAIN)) {
            high = middle;
        } else {
            low = middle;
        }
    }
    high.exp().min(1.0)
}

/// The p-value under continuation of "the rate is at most the threshold", from the counts at each look, all trials so
/// far, oldest look first. Looks that hold no new trials count as none; looks before one that does not contain them are
/// not of the same sequence of trials, and left out.
///
/// ```
/// use stats::{Sample, binomial_test_above, continued_above};
/// let looks = [Sample::new(90, 100)?, Sample::new(188, 200)?];
/// let once = continued_above(&looks[1..], 0.9);
/// assert!((once - binomial_test_above(looks[1], 0.9) / 0.8).abs() < 1e-9);
/// // Looking at the first hundred alone before cost something.
/// assert!(continued_above(&looks, 0.9) > once);
/// # Ok::<(), stats::StatsError>(())
/// ```
#[must_use]
pub fn continued_above(looks: &[Sample], threshold: f64) -> f64 {
    if threshold >= 1.0 {
        return 1.0;
    }
    p_of_stages(&stages_of_counts(looks, threshold)).max(once_above(looks, threshold))
}

/// Whether "the rate is at most the threshold" is rejected at this level by the last look: as `continued_above(looks,
/// threshold) <= level`, quicker.
fn is_shown_above(looks: &[Sample], threshold: f64, level: f64) -> bool {
    threshold < 1.0
        && once_above(looks, threshold) <= level
        && rejects(&stages_of_counts(looks, threshold), level)
}

/// The p-value of all trials, as if the last look was the only one.
fn once_above(looks: &[Sample], threshold: f64) -> f64 {
    let now = looks.iter().rev().find(|look| look.is_informative());
    now.map_or(1.0, |now| outcome(*now, threshold).1)
}

/// The same of "the rate is at least the threshold".
#[must_use]
pub fn continued_below(looks: &[Sample], threshold: f64) -> f64 {
    continued_above(&failures(looks), 1.0 - threshold)
}

/// The looks with failures for successes.
fn failures(looks: &[Sample]) -> Vec<Sample> {
    let failures = looks.iter().map(|look| Sample {
        successes: look.failures(),
        trials: look.trials,
    });
    failures.collect()
}

/// The stages between looks, against "the rate is at most the threshold".
fn stages_of_counts(looks: &[Sample], threshold: f64) -> Vec<Stage> {
    let mut before = Sample {
        successes: 0,
        trials: 0,
    };
    let mut stages = Vec::new();
    let mut growing: Option<Growing> = None;
    for look in sequence(looks) {
        let own = Sample {
            successes: look.successes - before.successes,
            trials: look.trials - before.trials,
        };
        let own_trials = own.trials as f64;
        let growing = growing
            .get_or_insert_with(|| Growing::from_first(own_trials, own_trials * threshold.ln()));
        stages.push(Stage {
            growth: growing.by(own_trials),
            outcome: outcome(own, threshold),
        });
        before = look;
    }
    stages
}

/// By how much the information grows from stage to stage.
struct Growing {
    /// What there is, or what a first look would need.
    information: f64,
    before: f64,
}

impl Growing {
    /// From a first stage with this information and the logarithm of the least p-value that it can have.
    fn from_first(information: f64, ln_least: f64) -> Self {
        let share = (ln_least / LEAST_OF_A_FIRST.ln()).min(1.0);
        Self {
            information: information / share.max(f64::MIN_POSITIVE),
            before: 0.0,
        }
    }

    /// A stage with so much information of its own: relative to all before it, at most 1.
    fn by(&mut self, own: f64) -> f64 {
        let relative = (own / self.information.max(self.before)).min(1.0);
        self.before += own;
        relative
    }
}

/// `P(X > x)` and `P(X >= x)` at the threshold.
fn outcome(own: Sample, threshold: f64) -> (f64, f64) {
    if threshold <= 0.0 {
        // A success is impossible: it rejects.
        return if own.successes > 0 {
            (0.0, 0.0)
        } else {
            (0.0, 1.0)
        };
    }
    let above = Sample {
        successes: own.successes + 1,
        trials: own.trials,
    };
    let low = if own.successes == own.trials {
        0.0
    } else {
        binomial_test_above(above, threshold)
    };
    (low, binomial_test_above(own, threshold))
}

/// The looks that are of one sequence of trials with the last, each with more trials than the one before.
#[must_use]
fn sequence(looks: &[Sample]) -> Vec<Sample> {
    let mut kept: Vec<Sample> = Vec::new();
    for look in looks.iter().rev().filter(|look| look.is_informative()) {
        let Some(next) = kept.last() else {
            kept.push(*look);
            continue;
        };
        if look == next {
            continue;
        }
        if look.successes > next.successes || look.failures() > next.failures() {
            break;
        }
        kept.push(*look);
    }
    kept.reverse();
    kept
}

/// The p-value under continuation from the p-values that each look would have by itself, oldest first. Looks without
/// more information than the one before change nothing.
///
/// ```
/// use stats::{ScoredLook, continued_p};
/// let once = continued_p(&[ScoredLook { p: 0.03, information: 50.0 }]);
/// assert!((once - 0.03 / 0.8).abs() < 1e-9);
/// let again = [(0.2, 50.0), (0.01, 100.0)].map(|(p, information)| ScoredLook { p, information });
/// assert!(continued_p(&again) > 0.01 / 0.8);
/// ```
#[must_use]
pub fn continued_p(looks: &[ScoredLook]) -> f64 {
    let once = looks.last().map_or(1.0, |now| now.p);
    p_of_stages(&stages_of_scores(looks)).max(once)
}

/// Whether a test at this level has rejected by the last of these looks: as `continued_p(looks) <= level`, quicker.
#[must_use]
pub fn continued_rejects(looks: &[ScoredLook], level: f64) -> bool {
    let once = looks.last().is_some_and(|now| now.p <= level);
    once && rejects(&stages_of_scores(looks), level)
}

fn stages_of_scores(looks: &[ScoredLook]) -> Vec<Stage> {
    let mut before: Option<ScoredLook> = None;
    let mut stages: Vec<Stage> = Vec::new();
    for look in looks {
        if let Some(stage) = scored_stage(before, *look) {
            stages.push(stage);
            before = Some(*look);
        }
    }
    stages
}

/// The stage between two looks by the difference of their scores; `None` without new information.
fn scored_stage(before: Option<ScoredLook>, look: ScoredLook) -> Option<Stage> {
    let information = before.map_or(0.0, |it| it.information);
    let own = look.information - information;
    // No new information: nothing is asked again.
    if own.is_nan() || own <= 1e-9 * look.information {
        return None;
    }
    let u = match before {
        // Exact at the first look, whatever the quantile's rounding.
        None => look.p,
        Some(before) => normal_cdf(-(look.score() - before.score()) / own.sqrt()),
    };
    let growth = if information > 0.0 {
        (own / information).min(1.0)
    } else {
        1.0
    };
    Some(Stage {
        growth,
        outcome: (u, u),
    })
}

impl ScoredLook {
    fn score(&self) -> f64 {
        deviate(self.p) * self.information.sqrt()
    }
}

fn deviate(p: f64) -> f64 {
    if p <= 0.0 {
        MOST_DEVIATE
    } else if p >= 1.0 {
        LEAST_DEVIATE
    } else {
        (-normal_quantile(p)).clamp(LEAST_DEVIATE, MOST_DEVIATE)
    }
}

/// The rates that the looks do not exclude, at any look together: those of which neither "at most" nor "at least" is
/// rejected at half the level's error each.
///
/// ```
/// use stats::{Confidence, Sample, clopper_pearson, continued_interval};
/// let now = Sample::new(88, 100)?;
/// let (once, again) = (clopper_pearson(now, Confidence::P95), continued_interval(&[now], Confidence::P95));
/// assert!(again.low < once.low && again.high > once.high && again.width() < 1.12 * once.width());
/// # Ok::<(), stats::StatsError>(())
/// ```
#[must_use]
pub fn continued_interval(looks: &[Sample], confidence: Confidence) -> Interval {
    let error = 0.5 * confidence.alpha();
    Interval {
        low: continued_lower_limit(looks, error),
        high: continued_upper_limit(looks, error),
    }
}

/// The largest rate up to which all are excluded as too low, at this one-sided error.
#[must_use]
pub fn continued_lower_limit(looks: &[Sample], error: f64) -> f64 {
    if looks.last().is_none_or(|look| look.successes == 0) {
        return 0.0;
    }
    boundary(|rate| is_shown_above(looks, rate, error))
}

/// The least rate from which on all are excluded as too high, at this one-sided error.
#[must_use]
pub fn continued_upper_limit(looks: &[Sample], error: f64) -> f64 {
    if looks.last().is_none_or(|look| look.failures() == 0) {
        return 1.0;
    }
    let failures = failures(looks);
    1.0 - boundary(|rate| is_shown_above(&failures, rate, error))
}

/// By halving: the end of the rates from 0 on for which it holds, from below.
fn boundary(excluded: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = f64::midpoint(low, high);
        if excluded(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[cfg(test)]
mod tests;
