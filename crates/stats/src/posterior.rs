//! Beta posteriors of a proportion, and the probability that two differ by less than a margin.
//!
//! With Jeffreys' prior, `s` of `n` successes give `Beta(s + 1/2, n - s + 1/2)`. For independent
//! posteriors with densities `f1`, `f2` and distribution function `F2`,
//!
//! ```text
//! P(|p1 - p2| < m) = integral_0^1 f1(x) (F2(x + m) - F2(x - m)) dx
//! ```
//!
//! Source: H. Jeffreys, "An invariant form for the prior probability in estimation problems"
//! (1946); the Gauss-Kronrod pair G7K15 is that of QUADPACK (Piessens and others, 1983).
//! Deviations: the integral is taken over `t` with `x = sin^2 t`, which removes the singular
//! ends of the density; it is cut at the tails of 1e-17 and at the places where the integrand
//! bends, then bisected adaptively. No random numbers: the same counts give the same bits.
//! Cost: some hundreds to thousands of beta tails, whose cost does not grow with the counts. Guarantee: absolute error
//! below 1e-9; within 1e-11 of 30 digits from 0 of 5 to counts of 10^8, the ends included. Of parameters beyond 10^10 the
//! places of a density are rounded to a part of its width, and the error grows with them; the cost does not.
//!
//! # Assumes
//! Trials are independent with one rate of the prior that is named; two proportions are independent of each other. Counts
//! at an effective size are taken as that many independent trials.

use crate::counts::{Confidence, EffectiveSample, Interval, StatsError};
use crate::quadrature::{integrate_over_pieces, kronrod_places};
use crate::special::{
    beta_cdf, beta_quantile, beta_quantile_upper, beta_sf, beta_tails, power_over_beta,
};

/// A beta distribution of a proportion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BetaPosterior {
    alpha: f64,
    beta: f64,
}

impl BetaPosterior {
    /// The distribution Beta(alpha, beta).
    ///
    /// # Errors
    /// [`StatsError::OutOfRange`] unless both parameters are positive and finite.
    pub fn new(alpha: f64, beta: f64) -> Result<Self, StatsError> {
        for value in [alpha, beta] {
            if !(value > 0.0 && value.is_finite()) {
                let expected = "a positive number";
                return Err(StatsError::OutOfRange {
                    what: "beta parameter",
                    value,
                    expected,
                });
            }
        }
        Ok(Self { alpha, beta })
    }

    /// The posterior under Jeffreys' prior Beta(1/2, 1/2); the prior itself when the sample
    /// carries no information.
    #[must_use]
    pub fn jeffreys(sample: impl Into<EffectiveSample>) -> Self {
        Self::with_prior(sample.into(), 0.5)
    }

    /// The posterior under the uniform prior Beta(1, 1); the prior itself when the sample carries
    /// no information.
    #[must_use]
    pub fn uniform(sample: impl Into<EffectiveSample>) -> Self {
        Self::with_prior(sample.into(), 1.0)
    }

    fn with_prior(sample: EffectiveSample, prior: f64) -> Self {
        if !sample.is_informative() {
            return Self {
                alpha: prior,
                beta: prior,
            };
        }
        Self {
            alpha: sample.successes + prior,
            beta: sample.failures() + prior,
        }
    }

    /// One distribution for a proportion that any of `ends` may describe: its central interval at a level reaches from the
    /// least to the greatest limit that one of them has.
    ///
    /// ```
    /// use stats::{BetaPosterior, Confidence, Sample};
    /// // 90 of 100, and 10 more that nothing is known of: from 90 to 100 of 110.
    /// let ends = [90, 100].map(|k| BetaPosterior::jeffreys(Sample { successes: k, trials: 110 }));
    /// let either = BetaPosterior::spanning(&ends, Confidence::P95).credible_interval(Confidence::P95);
    /// assert!((either.low - ends[0].quantile(0.025)).abs() < 1e-9);
    /// assert!((either.high - ends[1].quantile(0.975)).abs() < 1e-9);
    /// ```
    ///
    /// The two parameters are found by bisection; that of no ends is Jeffreys' prior.
    #[must_use]
    pub fn spanning(ends: &[Self], confidence: Confidence) -> Self {
        let Some(first) = ends.first() else {
            return Self {
                alpha: 0.5,
                beta: 0.5,
            };
        };
        if ends.iter().all(|end| end == first) {
            return *first;
        }
        let tail = 0.5 * confidence.alpha();
        let limits = ends.iter().map(|end| end.credible_interval(confidence));
        let (low, high) = limits.fold((1.0_f64, 0.0_f64), |(low, high), it| {
            (low.min(it.low), high.max(it.high))
        });
        // Of so many trials, with this lower limit.
        let with_total = |total: f64| {
            let at = |logit: f64| {
                let mean = 1.0 / (1.0 + (-logit).exp());
                Self {
                    alpha: (mean * total).max(f64::MIN_POSITIVE),
                    beta: ((1.0 - mean) * total).max(f64::MIN_POSITIVE),
                }
            };
            at(halved(-40.0, 40.0, |logit| at(logit).cdf(low) > tail))
        };
        // The more trials, the less lies above the upper limit; the ends have at most as many as the most of them.
        let most = ends
            .iter()
            .map(|end| end.alpha + end.beta)
            .fold(1.0, f64::max);
        let is_wider = |ln_total: f64| with_total(ln_total.exp()).sf(high) > tail;
        with_total(halved((1e-3_f64).ln(), most.ln() + 1e-6, is_wider).exp())
    }

    /// The parameters `(alpha, beta)`.
    #[must_use]
    pub fn parameters(&self) -> (f64, f64) {
        (self.alpha, self.beta)
    }

    /// The mean.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.alpha / (self.alpha + self.beta)
    }

    /// The variance.
    #[must_use]
    pub fn variance(&self) -> f64 {
        let total = self.alpha + self.beta;
        self.alpha / total * (self.beta / total) / (total + 1.0)
    }

    /// `P(p <= x)`.
    #[must_use]
    pub fn cdf(&self, x: f64) -> f64 {
        beta_cdf(self.alpha, self.beta, x.clamp(0.0, 1.0))
    }

    /// `P(p > x)`.
    #[must_use]
    pub fn sf(&self, x: f64) -> f64 {
        beta_sf(self.alpha, self.beta, x.clamp(0.0, 1.0))
    }

    /// `P(low < p <= high)`, from whichever tail keeps more digits.
    #[must_use]
    pub fn probability_between(&self, low: f64, high: f64) -> f64 {
        if high <= low {
            return 0.0;
        }
        if low > self.mean() {
            self.sf(low) - self.sf(high)
        } else {
            self.cdf(high) - self.cdf(low)
        }
    }

    /// The proportion with `P(p <= quantile) = probability`; `NaN` outside `[0, 1]`.
    #[must_use]
    pub fn quantile(&self, probability: f64) -> f64 {
        beta_quantile(self.alpha, self.beta, probability)
    }

    /// The proportion with `P(p > quantile) = probability`, accurate for tiny probabilities.
    #[must_use]
    pub fn quantile_upper(&self, probability: f64) -> f64 {
        beta_quantile_upper(self.alpha, self.beta, probability)
    }

    /// The equal-tailed credible interval.
    #[must_use]
    pub fn credible_interval(&self, confidence: Confidence) -> Interval {
        let tail = 0.5 * confidence.alpha();
        Interval {
            low: self.quantile(tail),
            high: self.quantile_upper(tail),
        }
    }
}

/// Where a property that holds below and not above ends.
fn halved(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        match holds(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    f64::midpoint(low, high)
}

/// A posterior as places with weights that sum to 1, for means over it that are taken thousands of times.
///
/// The Kronrod rule over the posterior's probability in seven pieces, so that the tails have places of their own. The
/// probabilities that it gives are within 4e-3 of [`probability_within`] and [`probability_exceeds`] (tested); they serve
/// plans, never conclusions.
#[derive(Clone, Debug, PartialEq)]
pub struct PosteriorPlaces(Vec<(f64, f64)>);

/// Where the pieces of probability end.
const PIECES: [f64; 8] = [0.0, 0.01, 0.1, 0.35, 0.65, 0.9, 0.99, 1.0];

impl PosteriorPlaces {
    /// The places of a posterior.
    #[must_use]
    pub fn new(posterior: &BetaPosterior) -> Self {
        Self::of_quantiles(|level| posterior.quantile(level))
    }

    /// The places of any distribution, by its quantile function.
    #[must_use]
    pub fn of_quantiles(quantile: impl Fn(f64) -> f64) -> Self {
        let pieces = PIECES.windows(2);
        let levels = pieces.flat_map(|piece| kronrod_places(piece[0], piece[1]));
        Self(
            levels
                .map(|(level, weight)| (quantile(level), weight))
                .collect(),
        )
    }

    /// About `P(|p1 - p2| < margin)`, `p1` of these places.
    #[must_use]
    pub fn within(&self, other: &BetaPosterior, margin: f64) -> f64 {
        let near = |x: f64| other.probability_between(x - margin, x + margin);
        self.0.iter().map(|(x, weight)| weight * near(*x)).sum()
    }

    /// About `P(p1 >= p2 + by)`, `p1` of these places.
    #[must_use]
    pub fn exceed(&self, other: &BetaPosterior, by: f64) -> f64 {
        self.0
            .iter()
            .map(|(x, weight)| weight * other.cdf(x - by))
            .sum()
    }

    /// About `P(p2 >= p1 + by)`, `p1` of these places.
    #[must_use]
    pub fn are_exceeded(&self, other: &BetaPosterior, by: f64) -> f64 {
        self.0
            .iter()
            .map(|(x, weight)| weight * other.sf(x + by))
            .sum()
    }
}

/// `P(|p1 - p2| < margin)` for independent posteriors.
#[must_use]
pub fn probability_within(first: &BetaPosterior, second: &BetaPosterior, margin: f64) -> f64 {
    if margin.is_nan() || margin <= 0.0 {
        return 0.0;
    }
    if margin >= 1.0 {
        return 1.0;
    }
    // Against the wider density the other's distribution function is the rougher factor, and
    // its bends are given to the integrator; either order gives the same probability.
    let value = average(first, second, margin, |x, y| {
        second.between((x - margin, y + margin), (x + margin, y - margin))
    });
    value.clamp(0.0, 1.0)
}

/// `P(p1 > p2)` for independent posteriors.
#[must_use]
pub fn probability_greater(first: &BetaPosterior, second: &BetaPosterior) -> f64 {
    average(first, second, 0.0, |x, y| second.tails(x, y).0).clamp(0.0, 1.0)
}

/// `P(p1 >= p2 + by)` for independent posteriors.
///
/// ```
/// use stats::{BetaPosterior, Sample, probability_exceeds, probability_greater};
/// let [a, b] = [(17, 20), (12, 20)].map(|(successes, trials)| {
///     BetaPosterior::jeffreys(Sample { successes, trials })
/// });
/// assert!((probability_exceeds(&a, &b, 0.0) - probability_greater(&a, &b)).abs() < 1e-9);
/// assert!(probability_exceeds(&a, &b, 0.2) < probability_greater(&a, &b));
/// ```
#[must_use]
pub fn probability_exceeds(first: &BetaPosterior, second: &BetaPosterior, by: f64) -> f64 {
    if by == 0.0 {
        return probability_greater(first, second);
    }
    average(first, second, by.abs(), |x, _| second.cdf(x - by)).clamp(0.0, 1.0)
}

/// The mean of `function` under `first`, where `function` bends where `second` has its mass,
/// shifted by `margin` to either side. It is given `x` and `1 - x`, the smaller of which keeps its digits: near 1
/// at counts of 10^8 `x` alone would have lost half of them.
fn average(
    first: &BetaPosterior,
    second: &BetaPosterior,
    margin: f64,
    function: impl Fn(f64, f64) -> f64,
) -> f64 {
    let ends = (first.quantile(TAIL), first.quantile_upper(TAIL));
    let mut cuts: Vec<f64> = [ends.0, ends.1].to_vec();
    for probability in [1e-9, 1e-3, 0.1, 0.5, 0.9] {
        cuts.push(first.quantile(probability));
        for level in [
            second.quantile(probability),
            second.quantile_upper(probability),
        ] {
            cuts.extend([level - margin, level + margin]);
        }
    }
    cuts.extend([
        first.quantile_upper(1e-3),
        first.quantile_upper(1e-9),
        margin,
        1.0 - margin,
    ]);
    cuts.retain(|cut| ends.0 <= *cut && *cut <= ends.1);
    let mut angles: Vec<f64> = cuts.iter().map(|x| x.sqrt().asin()).collect();
    angles.sort_by(f64::total_cmp);
    let integrand = |angle: f64| {
        let (sine, cosine) = angle.sin_cos();
        first.density_over_angle(sine, cosine) * function(sine * sine, cosine * cosine)
    };
    integrate_over_pieces(&integrand, &angles, 1e-13)
}

/// Tails that are cut off an integral: far below its tolerance.
const TAIL: f64 = 1e-17;

impl BetaPosterior {
    /// Both tails at `x`, given `y = 1 - x`.
    fn tails(&self, x: f64, y: f64) -> (f64, f64) {
        beta_tails(self.alpha, self.beta, x, y)
    }

    /// The probability between two places, each with what it lacks of 1, from whichever tail keeps more digits.
    fn between(&self, low: (f64, f64), high: (f64, f64)) -> f64 {
        let (low_tails, high_tails) = (self.tails(low.0, low.1), self.tails(high.0, high.1));
        if low.0 > self.mean() {
            low_tails.1 - high_tails.1
        } else {
            high_tails.0 - low_tails.0
        }
    }

    /// The density of the angle `t` with `x = sin^2 t`.
    fn density_over_angle(&self, sine: f64, cosine: f64) -> f64 {
        let product = sine * cosine;
        if product <= 0.0 {
            return 0.0;
        }
        let (x, y) = (sine * sine, cosine * cosine);
        2.0 * power_over_beta(self.alpha, self.beta, x, y) / product
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Also at the smaller levels that several constants have together, and inside the ends.
    #[test]
    fn what_spans_several_holds_the_limits_of_each() {
        for (k, n, more) in [
            (0, 5, 1),
            (0, 100, 7),
            (9, 10, 1),
            (90, 100, 10),
            (7, 7, 40),
            (174, 200, 3),
            (1, 900, 90),
        ] {
            let end = |with: u64| {
                BetaPosterior::jeffreys(crate::Sample::new(k + with, n + more).unwrap())
            };
            let plain = BetaPosterior::jeffreys(crate::Sample::new(k, n).unwrap());
            let ends = [end(0), end(more / 2), end(more), plain];
            let one = BetaPosterior::spanning(&ends, Confidence::P95);
            for alpha in [0.05, 0.025, 0.01, 0.005, 0.001] {
                let level = Confidence::new(1.0 - alpha).unwrap();
                let found = one.credible_interval(level);
                let rounding = if alpha == 0.05 { 1e-9 } else { 0.0 };
                for end in &ends {
                    let within = end.credible_interval(level);
                    assert!(
                        found.low <= within.low + rounding,
                        "{k}/{n}+{more} {alpha}: {found} {within}"
                    );
                    assert!(
                        found.high >= within.high - rounding,
                        "{k}/{n}+{more} {alpha}: {found} {within}"
                    );
                }
            }
            assert_eq!(
                BetaPosterior::spanning(&[plain, plain], Confidence::P95),
                plain
            );
        }
    }

    #[test]
    fn places_give_nearly_the_same_probabilities() {
        let mut worst = 0.0_f64;
        for (s, n) in [(0, 5), (1, 20), (17, 20), (50, 50), (174, 200), (2, 1000)] {
            for (a, b) in [
                (0.7, 3.0),
                (9.5, 1.5),
                (40.0, 3.0),
                (200.0, 30.0),
                (3.0, 997.0),
            ] {
                let counted = BetaPosterior::jeffreys(crate::Sample::new(s, n).unwrap());
                let computed = BetaPosterior::new(a, b).unwrap();
                let places = PosteriorPlaces::new(&computed);
                for margin in [0.02, 0.05, 0.1] {
                    let exact = probability_within(&computed, &counted, margin);
                    worst = worst.max((places.within(&counted, margin) - exact).abs());
                }
                for by in [0.0, 0.02, 0.1] {
                    let exact = probability_exceeds(&computed, &counted, by);
                    worst = worst.max((places.exceed(&counted, by) - exact).abs());
                    let exact = probability_exceeds(&counted, &computed, by);
                    worst = worst.max((places.are_exceeded(&counted, by) - exact).abs());
                }
            }
        }
        assert!(worst < 4e-3, "{worst:e}");
    }

    use crate::counts::Sample;

    fn posterior(successes: u64, trials: u64) -> BetaPosterior {
        BetaPosterior::jeffreys(Sample { successes, trials })
    }

    /// `(successes, trials, successes, trials, margin, P(|p1 - p2| < margin))`, by mpmath's quad
    /// of the definition in 30 digits.
    const WITHIN: [(u64, u64, u64, u64, f64, f64); 7] = [
        (88, 100, 439, 500, 0.05, 0.8423304064439447),
        (88, 100, 439, 500, 0.1, 0.9931127057845642),
        (0, 5, 0, 5, 0.1, 0.6327454907349793),
        (0, 10, 3, 8, 0.3, 0.41252325256656397),
        (5, 5, 9, 9, 0.05, 0.4937841609324131),
        (80, 100, 88, 100, 0.02, 0.09697022053582721),
        (1, 2, 700, 1000, 0.25, 0.5444187303540222),
    ];

    #[test]
    fn reference_values_either_way_round() {
        for (a, n, b, m, margin, expected) in WITHIN {
            let (first, second) = (posterior(a, n), posterior(b, m));
            let forth = probability_within(&first, &second, margin);
            let back = probability_within(&second, &first, margin);
            assert!(
                (forth - expected).abs() < 1e-11,
                "{a}/{n} {b}/{m}: {}",
                forth - expected
            );
            assert!(
                (back - expected).abs() < 1e-11,
                "{b}/{m} {a}/{n}: {}",
                back - expected
            );
        }
        let greater = probability_greater(&posterior(88, 100), &posterior(80, 100));
        assert!((greater - 0.9390582585967248).abs() < 1e-11);
        let greater = probability_greater(&posterior(0, 5), &posterior(3, 9));
        assert!((greater - 0.06435742975173486).abs() < 1e-11);
    }

    /// `(successes, trials, successes, trials, margin, P(|p1 - p2| < margin), P(p1 > p2))` at counts of 10^8, by
    /// Gauss-Legendre and tanh-sinh quadrature of the definition (mpmath in 25 digits, the last with scipy 1.17).
    const AT_LARGE_COUNTS: [(u64, u64, u64, u64, f64, f64, f64); 7] = [
        (
            88_000_000,
            T,
            87_995_000,
            T,
            1e-4,
            0.861_127_703_677_906_5,
            0.861_677_610_095_550_1,
        ),
        (
            50_000_000,
            T,
            50_000_000,
            T,
            1e-4,
            0.842_700_796_581_905_4,
            0.5,
        ),
        (0, T, 0, T, 1e-8, 0.791_006_339_581_359_1, 0.5),
        (
            T,
            T,
            T - 3,
            T,
            3e-8,
            0.555_377_531_827_093_5,
            0.966_854_500_691_156,
        ),
        (
            0,
            T,
            7,
            T,
            5e-8,
            0.250_101_274_016_216_3,
            0.001_501_773_330_943_735_2,
        ),
        (
            12_345_678,
            T,
            4400,
            36_000,
            2e-3,
            0.640_626_941_975_563_8,
            0.761_440_806_824_228_8,
        ),
        (
            30_000,
            100_000,
            301_000,
            1_000_000,
            1e-3,
            0.405_741_237_120_114_5,
            0.255_538_751_422_862_4,
        ),
    ];
    const T: u64 = 100_000_000;

    #[test]
    fn reference_values_at_large_counts_either_way_round_and_mirrored() {
        for (a, n, b, m, margin, within, greater) in AT_LARGE_COUNTS {
            let (first, second) = (posterior(a, n), posterior(b, m));
            let (failures, others) = (posterior(n - a, n), posterior(m - b, m));
            for (found, expected) in [
                (probability_within(&first, &second, margin), within),
                (probability_within(&second, &first, margin), within),
                (probability_within(&failures, &others, margin), within),
                (probability_greater(&first, &second), greater),
                (probability_greater(&second, &first), 1.0 - greater),
                (probability_greater(&others, &failures), greater),
            ] {
                let off = found - expected;
                assert!(off.abs() < 1e-10, "{a}/{n} {b}/{m}: {off:e}");
            }
        }
    }

    #[test]
    fn large_counts_approach_the_normal_limit() {
        let first = posterior(88_000_000, 100_000_000);
        let second = posterior(87_995_000, 100_000_000);
        let deviation = (2.0 * 0.88 * 0.12 / 1e8_f64).sqrt();
        let normal = crate::special::normal_cdf((1e-4 - 5e-5) / deviation)
            - crate::special::normal_cdf((-1e-4 - 5e-5) / deviation);
        let found = probability_within(&first, &second, 1e-4);
        assert!((found - normal).abs() < 1e-3, "{found} against {normal}");
    }

    #[test]
    fn a_large_sample_against_a_small_one() {
        // Against a practically known rate, only the small sample's posterior is left.
        let (small, large) = (posterior(3, 7), posterior(40_000_000, 100_000_000));
        let limit = small.probability_between(0.3, 0.5);
        for found in [
            probability_within(&small, &large, 0.1),
            probability_within(&large, &small, 0.1),
        ] {
            assert!((found - limit).abs() < 1e-6, "{found} against {limit}");
        }
    }

    #[test]
    fn the_margins_zero_and_one() {
        let (first, second) = (posterior(0, 5), posterior(5, 5));
        assert_eq!(probability_within(&first, &second, 0.0), 0.0);
        assert_eq!(probability_within(&first, &second, 1.0), 1.0);
        let nothing = posterior(0, 0);
        assert_eq!(nothing.parameters(), (0.5, 0.5));
        assert!((probability_greater(&nothing, &nothing) - 0.5).abs() < 1e-12);
    }
}
