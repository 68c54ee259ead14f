//! A test of "the rate is at least the threshold" that repeats trials until it knows, with a zone in which either answer is
//! allowed.
//!
//! # Definition
//! With a threshold `t` and a margin `m`, the *indifference zone* lies between `l = t - m` and `u = t + m`. Of `n` trials `s`
//! succeed and `f = n - s` fail. The evidence (e-value) for "the rate is above `l`" is
//!
//! ```text
//! E_above = 1/2 (u/l)^s ((1-u)/(1-l))^f  +  1/2 integral over q >= u of q^s (1-q)^f dJ(q | q >= u) / (l^s (1-l)^f)
//! ```
//!
//! with Jeffreys' prior `J` = Beta(1/2, 1/2): half of it is Wald's likelihood ratio at the edges of the zone, which decides
//! soonest where a decision is hardest, and half looks for rates far beyond the zone. The evidence for "the rate is below `u`" is
//! the same with the sides exchanged. The rate is *at least the threshold* at the first `n` with `E_above >= 1/alpha`, and *below
//! it* at the first with `E_below >= 1/alpha`. Without a margin the ratio is 1 and has no share: the test is
//! [`crate::SequentialTest`].
//!
//! Trials whose outcome is unknown count against either answer: as failures in `E_above`, as successes in `E_below`.
//!
//! # Source
//! A. Wald, "Sequential tests of statistical hypotheses", Annals of Mathematical Statistics 16 (1945), for the ratio and the zone;
//! H. Robbins, "Statistical methods related to the law of the iterated logarithm", ibid. 41 (1970), for mixtures; J. Ville (1939).
//! H. L. S. Younes and R. G. Simmons, "Probabilistic verification of discrete event systems using acceptance sampling" (CAV
//! 2002), use the zone for models. Deviation: the mixture of both is this project's; Wald's limits `ln((1-beta)/alpha)` are
//! replaced by `ln(1/alpha)`, since these hold for every rule of stopping.
//!
//! # Assumes
//! Each trial succeeds with the same rate given what was seen before, and every trial is counted, in an order that does not depend on
//! outcomes. When to stop, and for which reason, may depend on all that was seen. Nothing is assumed of unknown outcomes.
//!
//! # Cost and guarantee
//! Constant for a look. For every rate of at most `l` the probability of ever being told "at least" is at most `alpha`; for every
//! rate of at least `u` that of ever being told "below" is at most `alpha`. Both hold at any number of trials, however one stops.
//! Inside the zone either answer may come. The limits of [`time_uniform_limits`] hold at all numbers of trials together with
//! the confidence, by half of the error on each side.
//!
//! Of 4000 seeded tests for each true rate, "at least 0.95" at 95 % with a margin of 0.02 and 400 trials at most (`cargo run -p
//! corroborate-stats --example deciding`; standard error at most 0.8 points). *Fixed* is the least fixed number of trials with
//! the same two error rates, 309 of which 295 have to succeed; *until pass* repeats a test that fails up to five times.
//!
//! | rate | pass, % | fail, % | undecided, % | trials | fixed: pass, % | trials | until pass: pass, % | trials |
//! |---|---|---|---|---|---|---|---|---|
//! | 0.4 | 0.0 | 100.0 | 0.0 | 4 | 0.0 | 309 | 92.1 | 2.35 |
//! | 0.7 | 0.0 | 100.0 | 0.0 | 11 | 0.0 | 309 | 99.8 | 1.42 |
//! | 0.8 | 0.0 | 100.0 | 0.0 | 22 | 0.0 | 309 | 100.0 | 1.26 |
//! | 0.9 | 0.5 | 99.4 | 0.0 | 75 | 0.1 | 309 | 100.0 | 1.11 |
//! | 0.93 | 4.5 | 88.3 | 7.2 | 166 | 5.7 | 309 | 100.0 | 1.07 |
//! | 0.95 | 29.6 | 40.2 | 30.2 | 247 | 41.7 | 309 | 100.0 | 1.05 |
//! | 0.97 | 88.4 | 2.1 | 9.5 | 184 | 95.0 | 309 | 100.0 | 1.03 |
//! | 0.98 | 99.1 | 0.4 | 0.5 | 116 | 99.9 | 309 | 100.0 | 1.02 |
//! | 0.99 | 100.0 | 0.0 | 0.0 | 78 | 100.0 | 309 | 100.0 | 1.01 |
//! | 1 | 100.0 | 0.0 | 0.0 | 54 | 100.0 | 309 | 100.0 | 1.00 |
//!
//! Without a limit of trials, 4.7 % pass at 0.93 (174 trials on the average) and 2.3 % fail at 0.97 (194 trials).

use crate::counts::{Confidence, Interval, Sample, StatsError};
use crate::sequential::{Decision, SequentialTest, boundary, ln_evidence_against};
use crate::special::{beta_cdf, beta_sf};

/// The weight of either outcome in Jeffreys' prior.
const HALF: f64 = 0.5;

/// More further trials than this are not counted.
const MOST_FURTHER: u64 = 1 << 30;

/// A drift of the evidence by less than this for a trial is rounding.
const NO_DRIFT: f64 = 1e-12;

/// A sequential test of a rate against a threshold with an indifference zone.
///
/// ```
/// use stats::{Confidence, Decision, IndifferenceTest, Sample};
/// let test = IndifferenceTest::new(0.95, 0.02, Confidence::P95)?;
/// let decide = |successes, trials| Ok::<_, stats::StatsError>(test.decide([Sample::new(successes, trials)?; 2]));
/// assert_eq!(decide(60, 60)?, Decision::AtLeast);
/// assert_eq!(decide(24, 30)?, Decision::Below);
/// assert_eq!(decide(95, 100)?, Decision::Open);
/// # Ok::<(), stats::StatsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndifferenceTest {
    threshold: f64,
    zone: Interval,
    confidence: Confidence,
}

impl IndifferenceTest {
    /// A test against `threshold` with a zone of `margin` on either side.
    ///
    /// # Errors
    /// [`StatsError::OutOfRange`] unless `0 < threshold <= 1`, and the zone lies between 0 and 1, both excluded. A threshold of 1
    /// has a zone below it alone, which must not be empty: all successes never show that the rate is 1.
    pub fn new(threshold: f64, margin: f64, confidence: Confidence) -> Result<Self, StatsError> {
        let is_one = threshold >= 1.0;
        let error = |what, value, expected| {
            Err(StatsError::OutOfRange {
                what,
                value,
                expected,
            })
        };
        if !(threshold > 0.0 && threshold <= 1.0) {
            return error("threshold of a rate", threshold, "above 0, at most 1");
        }
        if is_one && margin <= 0.0 {
            let expected = "above 0 with a threshold of 1, which no number of trials can show";
            return error("margin", margin, expected);
        }
        let fits = margin >= 0.0 && threshold - margin > 0.0;
        if !(fits && (is_one || threshold + margin < 1.0)) {
            let expected = "at least 0, and less than the threshold's distance from 0 and from 1";
            return error("margin", margin, expected);
        }
        let (low, high) = (threshold - margin, (threshold + margin).min(1.0));
        Ok(Self {
            threshold,
            zone: Interval { low, high },
            confidence,
        })
    }

    /// The rate that is tested against.
    #[must_use]
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// The rates for which either answer is allowed.
    #[must_use]
    pub fn zone(&self) -> Interval {
        self.zone
    }

    /// One minus the probability of a wrong answer outside the zone.
    #[must_use]
    pub fn confidence(&self) -> Confidence {
        self.confidence
    }

    /// The logarithm of the e-value for "the rate is above the lower edge of the zone".
    #[must_use]
    pub fn ln_evidence_above(&self, sample: Sample) -> f64 {
        let Interval { low, high } = self.zone;
        mixed(sample, low, high, high, beta_sf)
    }

    /// The logarithm of the e-value for "the rate is below the upper edge of the zone".
    #[must_use]
    pub fn ln_evidence_below(&self, sample: Sample) -> f64 {
        let Interval { low, high } = self.zone;
        if high >= 1.0 {
            // One failure excludes a rate of 1.
            return if sample.failures() > 0 {
                f64::INFINITY
            } else {
                0.0
            };
        }
        mixed(sample, high, low, low, beta_cdf)
    }

    /// What these counts decide, given with all unknown outcomes as failures and with all of them as successes. The first decision
    /// in a sequence of trials may be taken.
    #[must_use]
    pub fn decide(&self, ends: [Sample; 2]) -> Decision {
        let enough = -self.confidence.alpha().ln();
        let [lowest, highest] = ends;
        if self.ln_evidence_above(lowest) >= enough {
            Decision::AtLeast
        } else if self.ln_evidence_below(highest) >= enough {
            Decision::Below
        } else {
            Decision::Open
        }
    }

    /// How many further trials decide it if they succeed at the rate seen so far (with one success and one failure of Jeffreys'
    /// half each added), all with an outcome that is known: a forecast, not a bound. `None` if more than 2^30 do not, as of a
    /// rate in the middle of the zone, or if the rate itself, without Jeffreys' halves, is exactly where no number does: what
    /// the halves alone add is no forecast.
    #[must_use]
    pub fn further_trials(&self, ends: [Sample; 2]) -> Option<u64> {
        let [lowest, highest] = ends;
        let unknown = highest.successes - lowest.successes.min(highest.successes);
        let known = lowest.trials.saturating_sub(unknown) as f64;
        if self.is_never_decided(lowest.successes as f64 / known) {
            return None;
        }
        let rate = (lowest.successes as f64 + HALF) / (known + 1.0);
        let after = |further: u64| {
            let gained = (rate * further as f64).round() as u64;
            ends.map(|end| Sample {
                successes: end.successes.saturating_add(gained),
                trials: end.trials.saturating_add(further),
            })
        };
        let decides = |further: u64| self.decide(after(further)) != Decision::Open;
        let mut enough = 1;
        while !decides(enough) {
            enough *= 2;
            if enough > MOST_FURTHER {
                return None;
            }
        }
        let mut too_few = enough / 2;
        while enough - too_few > 1 {
            let middle = u64::midpoint(too_few, enough);
            match decides(middle) {
                true => enough = middle,
                false => too_few = middle,
            }
        }
        Some(enough)
    }

    /// Whether trials that go on at exactly this rate decide nothing, however many: it is the threshold of a test without a
    /// margin, or the rate in the zone at which Wald's ratio neither grows nor falls.
    fn is_never_decided(&self, rate: f64) -> bool {
        let Interval { low, high } = self.zone;
        let drift = match low < high {
            true => rate * (high / low).ln() + (1.0 - rate) * ((1.0 - high) / (1.0 - low)).ln(),
            false => rate - low,
        };
        drift.abs() < NO_DRIFT
    }
}

/// The mixture's evidence against `null`: half on the ratio at `edge`, half over the rates on that `side` of `from`.
fn mixed(
    sample: Sample,
    null: f64,
    edge: f64,
    from: f64,
    side: impl Fn(f64, f64, f64) -> f64,
) -> f64 {
    if !sample.is_informative() {
        return 0.0;
    }
    let (s, f) = (sample.successes as f64, sample.failures() as f64);
    let before = side(HALF, HALF, from);
    let over = side(s + HALF, f + HALF, from).ln() - before.ln();
    let over = ln_evidence_against(sample, null) + over;
    let power = |count: f64, ratio: f64| match count > 0.0 {
        true => count * ratio.ln(),
        false => 0.0,
    };
    let ratio = power(s, edge / null) + power(f, (1.0 - edge) / (1.0 - null));
    match (edge == null, before > 0.0) {
        (true, _) => over,
        (false, false) => ratio,
        (false, true) => ln_sum(ratio, over) - std::f64::consts::LN_2,
    }
}

/// `ln(e^a + e^b)`.
fn ln_sum(a: f64, b: f64) -> f64 {
    let most = a.max(b);
    match most.is_finite() {
        true => most + ((a - most).exp() + (b - most).exp()).ln(),
        false => most,
    }
}

/// The rates that the counts do not exclude, at all numbers of trials together, whatever outcomes that are unknown would have
/// been: `ends` has them all as failures and all as successes.
///
/// ```
/// use stats::{Confidence, Sample, time_uniform_limits};
/// let known = [Sample::new(95, 100)?; 2];
/// let unknown = [Sample::new(95, 102)?, Sample::new(97, 102)?];
/// let [narrow, wide] = [known, unknown].map(|ends| time_uniform_limits(ends, Confidence::P95));
/// assert!(narrow.low > 0.84 && narrow.high < 0.995);
/// assert!(wide.low < narrow.low && wide.high > narrow.high);
/// # Ok::<(), stats::StatsError>(())
/// ```
#[must_use]
pub fn time_uniform_limits(ends: [Sample; 2], confidence: Confidence) -> Interval {
    let each = confidence.simultaneous(2);
    let enough = -each.alpha().ln();
    let test = |rate: f64| SequentialTest::new(rate, each).ok();
    let below = |rate: f64| test(rate).is_some_and(|it| it.ln_evidence_at_least(ends[0]) >= enough);
    let above = |rate: f64| test(rate).is_some_and(|it| it.ln_evidence_below(ends[1]) >= enough);
    let low = match ends[0].rate() {
        Some(rate) if rate > 0.0 => boundary(0.0, rate, |rate| rate <= 0.0 || below(rate)),
        _ => 0.0,
    };
    let high = match ends[1].rate() {
        Some(rate) if rate < 1.0 => boundary(1.0, rate, |rate| rate >= 1.0 || above(rate)),
        _ => 1.0,
    };
    Interval { low, high }
}
