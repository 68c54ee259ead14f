//! Intervals and tests of a rate that stay valid however often one looks.
//!
//! Definition. Of `n` trials with unknown rate `p`, `s` succeed and `f = n - s` fail. With the
//! mixture of all rates `q` by Jeffreys' prior, Beta(1/2, 1/2), the likelihood ratio
//! `M_n(p) = integral q^s (1-q)^f dBeta(q) / (p^s (1-p)^f) = B(s+1/2, f+1/2) / (B(1/2, 1/2) p^s (1-p)^f)`
//! is a martingale of mean 1 if `p` is the true rate. By Ville's inequality
//! `P(M_n(p) >= 1/alpha for any n) <= alpha`, so the rates with `M_n(p) < 1/alpha` hold the true
//! one at all `n` at once with confidence `1 - alpha`: a confidence sequence. Against a whole side,
//! "`p <= t`", the mixture is taken over `q > t` alone; it is then a supermartingale for every such
//! `p`, and its value is evidence (an e-value) for "`p > t`".
//!
//! Source: J. Ville (1939); H. Robbins, "Statistical methods related to the law of the iterated
//! logarithm", Annals of Mathematical Statistics 41 (1970); S. R. Howard, A. Ramdas, J. McAuliffe
//! and J. Sekhon, "Time-uniform, nonparametric, nonasymptotic confidence sequences", Annals of
//! Statistics 49 (2021), section 3.1 (mixtures); I. Waudby-Smith and A. Ramdas, "Estimating means
//! of bounded random variables by betting", JRSS B 86 (2024), of which this is the case of trials
//! with two outcomes.
//!
//! Deviation: none. Cost: constant for a test, 100 evaluations at most for an interval. Guarantee:
//! coverage at all times together is at least `1 - alpha`, for every `n` and rate; the ends found
//! lie outside the exact ones. The price against an interval for an `n` fixed beforehand
//! (Clopper-Pearson, 95 %, rate 0.88) is a width 1.56 times as large at 100 trials, 2.00 at 10^4
//! and 2.29 at 10^6.
//!
//! # Assumes
//! Given what was seen, each trial succeeds with the same rate, and every trial is counted. When to stop may depend on all
//! that was seen. Trials that are alike within people break this.

use crate::counts::{Confidence, Interval, Sample, StatsError};
use crate::special::{beta_cdf, beta_sf, deviance, ln_gamma};

/// The weight of either outcome in Jeffreys' prior.
const HALF: f64 = 0.5;

/// What a test that may go on for ever has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// The rate is at least the threshold.
    AtLeast,
    /// The rate is below the threshold.
    Below,
    /// Not decided yet.
    Open,
}

/// `ln M_n(p)`: the evidence against `rate` being the true rate, whenever one looks. Contradictory
/// counts and counts of nothing are no evidence, 0.
///
/// ```
/// use stats::{Sample, ln_evidence_against};
/// // 60 of 100 speaks against a rate of 1/4, beyond one chance in 10^6.
/// assert!(ln_evidence_against(Sample::new(60, 100)?, 0.25) > 1e6_f64.ln());
/// # Ok::<(), stats::StatsError>(())
/// ```
#[must_use]
pub fn ln_evidence_against(sample: Sample, rate: f64) -> f64 {
    if !sample.is_informative() {
        return 0.0;
    }
    ln_mixture(sample) + divergence(sample, rate)
}

/// The logarithm of the mixture's likelihood over that of the observed rate; at most 0.
fn ln_mixture(sample: Sample) -> f64 {
    let (s, f) = (sample.successes as f64, sample.failures() as f64);
    let n = s + f;
    let entropy = |k: f64| if k > 0.0 { k * (k / n).ln() } else { 0.0 };
    // B(1/2, 1/2) = pi.
    ln_gamma(s + HALF) + ln_gamma(f + HALF)
        - ln_gamma(n + 1.0)
        - std::f64::consts::PI.ln()
        - entropy(s)
        - entropy(f)
}

/// `n` times the Kullback-Leibler divergence of `rate` from the observed rate.
fn divergence(sample: Sample, rate: f64) -> f64 {
    let (s, f) = (sample.successes as f64, sample.failures() as f64);
    let n = s + f;
    let part = |count: f64, mean: f64| match (count > 0.0, mean > 0.0) {
        (false, _) => mean,
        (true, false) => f64::INFINITY,
        (true, true) => deviance(count, mean),
    };
    part(s, n * rate) + part(f, n * (1.0 - rate))
}

/// The rates that the counts do not exclude, valid at every number of trials at once.
///
/// The interval of a fixed count alone; [`RunningInterval`] also keeps what earlier looks excluded.
///
/// ```
/// use stats::{Confidence, Sample, confidence_sequence};
/// let interval = confidence_sequence(Sample::new(88, 100)?, Confidence::P95);
/// assert!(interval.low > 0.74 && interval.high < 0.97);
/// // Nothing seen, nothing said.
/// assert_eq!(confidence_sequence(Sample::new(0, 0)?, Confidence::P95).to_string(), "[0.0000, 1.0000]");
/// # Ok::<(), stats::StatsError>(())
/// ```
#[must_use]
pub fn confidence_sequence(sample: Sample, confidence: Confidence) -> Interval {
    let (true, Some(observed)) = (sample.is_informative(), sample.rate()) else {
        return Interval::VACUOUS;
    };
    let allowed = -confidence.alpha().ln() - ln_mixture(sample);
    let excluded = |rate: f64| divergence(sample, rate) >= allowed;
    let low = match sample.successes {
        0 => 0.0,
        _ => boundary(0.0, observed, excluded),
    };
    let high = match sample.failures() {
        0 => 1.0,
        _ => boundary(1.0, observed, excluded),
    };
    Interval { low, high }
}

/// By halving, the end between `outside`, which is excluded, and `inside`, which is not; on the
/// excluded side, so that rounding never narrows an interval.
pub(crate) fn boundary(mut outside: f64, mut inside: f64, excluded: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..100 {
        let middle = f64::midpoint(outside, inside);
        if middle == outside || middle == inside {
            break;
        }
        if excluded(middle) {
            outside = middle;
        } else {
            inside = middle;
        }
    }
    outside
}

/// A confidence sequence that is followed trial by trial: a rate once excluded stays excluded.
///
/// ```
/// use stats::{Confidence, RunningInterval};
/// let mut running = RunningInterval::new(Confidence::P99);
/// for trial in 0..1000 {
///     running.observe(trial % 10 != 0);
/// }
/// assert!(running.interval().contains(0.9) && running.interval().width() < 0.1);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunningInterval {
    confidence: Confidence,
    sample: Sample,
    interval: Interval,
}

impl RunningInterval {
    /// Before the first trial: nothing is excluded.
    #[must_use]
    pub fn new(confidence: Confidence) -> Self {
        let sample = Sample {
            successes: 0,
            trials: 0,
        };
        Self {
            confidence,
            sample,
            interval: Interval::VACUOUS,
        }
    }

    /// Takes one more trial into account.
    pub fn observe(&mut self, success: bool) {
        self.sample.trials += 1;
        self.sample.successes += u64::from(success);
        let now = confidence_sequence(self.sample, self.confidence);
        let (low, high) = (
            now.low.max(self.interval.low),
            now.high.min(self.interval.high),
        );
        // Once in 1/alpha sequences all rates get excluded; the last interval is then kept, since
        // an empty one would be mistaken for certainty.
        if low <= high {
            self.interval = Interval { low, high };
        }
    }

    /// The counts so far.
    #[must_use]
    pub fn sample(&self) -> Sample {
        self.sample
    }

    /// The rates not excluded so far.
    #[must_use]
    pub fn interval(&self) -> Interval {
        self.interval
    }
}

/// A test of "the rate is at least the threshold" that may be looked at after every trial.
///
/// With probability at most `alpha` it ever takes a wrong decision, whatever the rate.
///
/// ```
/// use stats::{Confidence, Sample, Decision, SequentialTest};
/// let test = SequentialTest::new(0.95, Confidence::P99)?;
/// assert_eq!(test.decide(Sample::new(40, 50)?), Decision::Below);
/// assert_eq!(test.decide(Sample::new(96, 100)?), Decision::Open);
/// assert_eq!(test.decide(Sample::new(300, 300)?), Decision::AtLeast);
/// # Ok::<(), stats::StatsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequentialTest {
    threshold: f64,
    confidence: Confidence,
}

impl SequentialTest {
    /// A test against `threshold`.
    ///
    /// # Errors
    /// [`StatsError::OutOfRange`] unless `0 <= threshold <= 1`.
    pub fn new(threshold: f64, confidence: Confidence) -> Result<Self, StatsError> {
        if (0.0..=1.0).contains(&threshold) {
            return Ok(Self {
                threshold,
                confidence,
            });
        }
        Err(StatsError::OutOfRange {
            what: "threshold of a rate",
            value: threshold,
            expected: "a probability, 0 to 1",
        })
    }

    /// The rate that is tested against.
    #[must_use]
    pub fn threshold(&self) -> f64 {
        self.threshold
    }

    /// The confidence in a decision.
    #[must_use]
    pub fn confidence(&self) -> Confidence {
        self.confidence
    }

    /// The logarithm of the e-value for "at least the threshold".
    #[must_use]
    pub fn ln_evidence_at_least(&self, sample: Sample) -> f64 {
        self.ln_evidence(sample, beta_sf)
    }

    /// The logarithm of the e-value for "below the threshold".
    #[must_use]
    pub fn ln_evidence_below(&self, sample: Sample) -> f64 {
        self.ln_evidence(sample, beta_cdf)
    }

    /// The mixture over one side of the threshold, whose share of a beta distribution is `side`.
    fn ln_evidence(&self, sample: Sample, side: impl Fn(f64, f64, f64) -> f64) -> f64 {
        if !sample.is_informative() {
            return 0.0;
        }
        let (s, f) = (sample.successes as f64, sample.failures() as f64);
        let after = side(s + HALF, f + HALF, self.threshold);
        let before = side(HALF, HALF, self.threshold);
        ln_evidence_against(sample, self.threshold) + after.ln() - before.ln()
    }

    /// What these counts decide. Decisions at different counts of one sequence of trials hold
    /// together: the first that is not open may be taken.
    #[must_use]
    pub fn decide(&self, sample: Sample) -> Decision {
        let enough = -self.confidence.alpha().ln();
        if self.threshold <= 0.0 {
            return Decision::AtLeast;
        }
        if self.threshold >= 1.0 {
            return match sample.is_informative() && sample.failures() > 0 {
                true => Decision::Below,
                false => Decision::Open,
            };
        }
        if self.ln_evidence_at_least(sample) >= enough {
            Decision::AtLeast
        } else if self.ln_evidence_below(sample) >= enough {
            Decision::Below
        } else {
            Decision::Open
        }
    }
}
