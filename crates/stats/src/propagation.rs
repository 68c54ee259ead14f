//! What uncertain inputs do to a result: its distribution, and the share of each input alone and
//! with the others.
//!
//! For independent inputs, `y = g(x)`; `A` and `B` are two independent designs of `N` rows, and
//! `A_j` is `A` with column `j` taken from `B`. All functions are evaluated on the same rows
//! (common random numbers), so that differences between variants are not blurred by sampling.
//!
//! ```text
//! first order  S_j = Var(E[y | x_j]) / V     ~ 1/(N V) sum g(B) (g(A_j) - g(A))
//! total        T_j = E[Var(y | x_-j)] / V    ~ 1/(2 N V) sum (g(A) - g(A_j))^2
//! ```
//!
//! `V` is the variance of `g` over `A` and `B` together, about whose mean `g` is taken. For few inputs the means are
//! taken by quadrature instead (module `gauss_grid`): the shares of smooth functions are then known to a
//! fraction of a point from some hundreds of evaluations, where rows drawn at random need ten thousands.
//!
//! Source: I. M. Sobol, "Sensitivity estimates for nonlinear mathematical models" (1993);
//! A. Saltelli and others, "Variance based sensitivity analysis of model output" (2010), table 2,
//! rows b and f (the latter M. J. W. Jansen's of 1999). Deviation: rows are randomised Halton points of
//! twice the dimension (see [`mod@crate::design`]). Cost: the evaluations that it is given; `N (k + 2)` make rows `A`,
//! `B` and `A_j` for `k` inputs. Guarantee: consistent. Each share comes with its error: from exchanged rows the
//! standard error over rows, which overstates that of the low-discrepancy rows used; by quadrature the difference
//! between two orders, or what the variance of independent draws contradicts beyond three standard errors.
//!
//! # Assumes
//! Inputs are independent with the posteriors that are given, and the function is the same each time.
//! [`extremes_at_corners`] takes it as monotone or linear in each input.

use crate::counts::{Confidence, Interval, StatsError};
use crate::design::posterior_design;
use crate::draws::Draws;
use crate::gauss_grid::GaussGrid;
use crate::posterior::BetaPosterior;

/// The rows at which a function of uncertain inputs is to be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct SharesDesign {
    inputs: usize,
    /// How many of the rows, the first ones, are independent draws of the inputs.
    draws: usize,
    /// What follows the draws.
    means: Means,
    rows: Vec<Vec<f64>>,
}

/// How the means that shares are made of are taken.
#[derive(Clone, Debug, PartialEq)]
enum Means {
    Quadrature(GaussGrid),
    /// The draws are `A` and `B`.
    Exchanged,
}

/// The distribution of a result, with the inputs' shares in its variance.
#[derive(Clone, Debug, PartialEq)]
pub struct Propagated {
    /// Draws of the result.
    pub draws: Draws,
    /// One entry for each input, in their order; empty when the result does not vary.
    pub shares: Vec<Shares>,
}

/// One input's shares in the variance of a result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// What knowing this input alone would take away from the variance, 0 to 1.
    pub first_order: f64,
    /// What would be left of the variance if all other inputs were known, 0 to 1.
    pub total: f64,
    /// Error of `first_order`: a standard error, or what quadrature leaves open.
    pub first_order_error: f64,
    /// The same of `total`.
    pub total_error: f64,
}

/// A standard deviation below this share of the largest value is that of the evaluations' rounding.
const ROUNDING: f64 = 1e-10;

/// The part of the evaluations that quadrature may take: the draws' quantiles need the others.
const MOST_FOR_QUADRATURE: f64 = 0.5;

impl SharesDesign {
    /// At most so many rows for independent `inputs`: draws of them, and those that tell the shares.
    ///
    /// ```
    /// use stats::{BetaPosterior, Confidence, Sample, SharesDesign};
    /// // Two failure rates from counts; a run succeeds when neither failure occurs.
    /// let inputs = [(7, 98), (2, 100)].map(|(k, n)| {
    ///     BetaPosterior::jeffreys(Sample { successes: k, trials: n })
    /// });
    /// let design = SharesDesign::new(&inputs, 2000, 1);
    /// let success: Vec<f64> = design.rows().iter().map(|x| (1.0 - x[0]) * (1.0 - x[1])).collect();
    /// let result = design.analyse(&success)?;
    /// assert_eq!(result.draws.interval(Confidence::P95).to_string(), "[0.8363, 0.9511]");
    /// assert!((result.shares[0].total - 0.7672).abs() < 1e-4);
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    #[must_use]
    pub fn new(inputs: &[BetaPosterior], evaluations: usize, seed: u64) -> Self {
        let most = (evaluations as f64 * MOST_FOR_QUADRATURE) as usize;
        match GaussGrid::within(inputs, most) {
            Some(grid) => Self::by_quadrature(inputs, grid, evaluations, seed),
            None => Self::exchanged(inputs, evaluations / (inputs.len() + 2), seed),
        }
    }

    fn by_quadrature(
        inputs: &[BetaPosterior],
        grid: GaussGrid,
        evaluations: usize,
        seed: u64,
    ) -> Self {
        let nodes = grid.rows();
        let draws = evaluations - nodes.len();
        let mut rows = posterior_design(inputs, draws, seed);
        rows.extend(nodes);
        Self {
            inputs: inputs.len(),
            draws,
            means: Means::Quadrature(grid),
            rows,
        }
    }

    /// `base` rows twice, and `base` for each input.
    fn exchanged(inputs: &[BetaPosterior], base: usize, seed: u64) -> Self {
        let twice: Vec<BetaPosterior> = inputs.iter().chain(inputs).copied().collect();
        let points = posterior_design(&twice, base, seed);
        let k = inputs.len();
        let mut rows: Vec<Vec<f64>> = points.iter().map(|point| point[..k].to_vec()).collect();
        rows.extend(points.iter().map(|point| point[k..].to_vec()));
        for input in 0..k {
            rows.extend(points.iter().map(|point| {
                let mut row = point[..k].to_vec();
                row[input] = point[k + input];
                row
            }));
        }
        Self {
            inputs: k,
            draws: 2 * base,
            means: Means::Exchanged,
            rows,
        }
    }

    /// The rows, one value for each input.
    #[must_use]
    pub fn rows(&self) -> &[Vec<f64>] {
        &self.rows
    }

    /// How many of the rows, the first ones, are independent draws of the inputs.
    #[must_use]
    pub fn draws(&self) -> usize {
        self.draws
    }

    /// Distribution and shares, given the function's value at each of the rows.
    ///
    /// # Errors
    /// [`StatsError::LengthMismatch`] unless there is one output a row, [`StatsError::TooFew`]
    /// below 40 draws, [`StatsError::OutOfRange`] for an output that is not finite.
    pub fn analyse(&self, outputs: &[f64]) -> Result<Propagated, StatsError> {
        if outputs.len() != self.rows.len() {
            return Err(StatsError::LengthMismatch {
                left: self.rows.len(),
                right: outputs.len(),
            });
        }
        if self.draws < 40 {
            return Err(StatsError::TooFew {
                what: "draws",
                found: self.draws,
                needed: 40,
            });
        }
        Draws::new(outputs)?;
        let (drawn, others) = outputs.split_at(self.draws);
        let draws = Draws::new(drawn)?;
        let largest = outputs.iter().fold(0.0_f64, |most, y| most.max(y.abs()));
        let varies = draws.variance().sqrt() > ROUNDING * largest;
        let shares = match &self.means {
            _ if !varies => Vec::new(),
            Means::Quadrature(grid) => by_quadrature(grid, others, &draws),
            Means::Exchanged => (0..self.inputs)
                .map(|input| self.shares(outputs, input, draws.mean(), draws.variance()))
                .collect(),
        };
        // Each exchanged row is a draw, too; a node of a rule is none.
        let draws = match &self.means {
            Means::Quadrature(_) => draws,
            Means::Exchanged => Draws::new(outputs)?,
        };
        Ok(Propagated { draws, shares })
    }

    fn shares(&self, outputs: &[f64], input: usize, centre: f64, variance: f64) -> Shares {
        let n = self.draws / 2;
        let (a, b) = (&outputs[..n], &outputs[n..2 * n]);
        let exchanged = &outputs[(2 + input) * n..(3 + input) * n];
        let first: Vec<f64> = (0..n)
            .map(|i| (b[i] - centre) * (exchanged[i] - a[i]) / variance)
            .collect();
        let total: Vec<f64> = (0..n)
            .map(|i| 0.5 * (a[i] - exchanged[i]).powi(2) / variance)
            .collect();
        let (first_order, first_order_error) = mean_and_error(&first);
        let (total, total_error) = mean_and_error(&total);
        Shares {
            first_order: first_order.clamp(0.0, 1.0),
            total: total.clamp(0.0, 1.0),
            first_order_error,
            total_error,
        }
    }
}

/// The shares that a grid gives, whose errors are no less than what the draws contradict.
fn by_quadrature(grid: &GaussGrid, outputs: &[f64], draws: &Draws) -> Vec<Shares> {
    let mut found = grid.analyse(outputs);
    let contradicted = contradicted(found.variance, draws);
    for share in &mut found.shares {
        share.first_order_error = share.first_order_error.max(contradicted);
        share.total_error = share.total_error.max(contradicted);
    }
    found.shares
}

/// By how much of itself a variance is off that of the draws, beyond three of its standard errors, at most 1.
fn contradicted(variance: f64, draws: &Draws) -> f64 {
    let (mean, drawn) = (draws.mean(), draws.variance());
    let fourth = draws.average(|y| (y - mean).powi(4));
    let error = ((fourth / drawn - drawn).max(0.0) / drawn / draws.count() as f64).sqrt();
    let off = (variance - drawn).abs() / drawn.max(variance) - 3.0 * error;
    // A grid on which the function does not vary has no shares to speak of.
    if variance > 0.0 {
        off.clamp(0.0, 1.0)
    } else {
        1.0
    }
}

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (n * (n - 1.0))).sqrt())
}

/// The distribution of second minus first, when both were evaluated on the same rows.
///
/// # Errors
/// [`StatsError::LengthMismatch`], and those of [`Draws::new`].
pub fn paired_difference(first: &[f64], second: &[f64]) -> Result<Draws, StatsError> {
    if first.len() != second.len() {
        return Err(StatsError::LengthMismatch {
            left: first.len(),
            right: second.len(),
        });
    }
    let differences: Vec<f64> = first.iter().zip(second).map(|(a, b)| b - a).collect();
    Draws::new(&differences)
}

/// Intervals that hold all inputs at once with `confidence`: the box over which a robust answer
/// is sought. Each interval is at the level `confidence^(1/k)` (Z. Sidak, 1967), which is exact
/// for independent inputs. Tails are equal, but an interval begins at 0 (ends at 1) where the density
/// is unbounded, so for 0 (or all) of n under Jeffreys' prior; it then holds more than its level
/// (Brown, Cai and DasGupta, 2001).
///
/// ```
/// use stats::{BetaPosterior, Confidence, Sample, credible_box, extremes_at_corners};
/// let inputs = [(7, 98), (2, 100)].map(|(k, n)| BetaPosterior::jeffreys(Sample { successes: k, trials: n }));
/// let all = credible_box(&inputs, Confidence::P95);
/// let success = |x: &[f64]| (1.0 - x[0]) * (1.0 - x[1]);
/// // Whatever the rates in the box, the success lies between these bounds.
/// assert_eq!(extremes_at_corners(&all, success)?.to_string(), "[0.7941, 0.9685]");
/// # Ok::<(), stats::StatsError>(())
/// ```
#[must_use]
pub fn credible_box(inputs: &[BetaPosterior], confidence: Confidence) -> Vec<Interval> {
    let count = inputs.len().max(1) as f64;
    // 1 - level^(1/k) without losing digits.
    let tail = -0.5 * ((-confidence.alpha()).ln_1p() / count).exp_m1();
    inputs
        .iter()
        .map(|input| {
            let (alpha, beta) = input.parameters();
            Interval {
                low: if alpha < 1.0 {
                    0.0
                } else {
                    input.quantile(tail)
                },
                high: if beta < 1.0 {
                    1.0
                } else {
                    input.quantile_upper(tail)
                },
            }
        })
        .collect()
}

/// Inputs beyond which corners are too many to visit.
pub const MOST_CORNERS_OF: usize = 20;

/// The least and largest value of `function` at the corners of a box. These are its bounds over
/// the whole box when the function is, in each input with the others fixed, monotone or linear,
/// as probabilities of parametric models without loops are. For other functions use bounds of
/// their own, such as those of interval models.
///
/// # Errors
/// [`StatsError::OutOfRange`] beyond `MOST_CORNERS_OF` inputs, or for a value that is not finite.
pub fn extremes_at_corners(
    within: &[Interval],
    function: impl Fn(&[f64]) -> f64,
) -> Result<Interval, StatsError> {
    if within.len() > MOST_CORNERS_OF {
        return Err(StatsError::OutOfRange {
            what: "number of inputs",
            value: within.len() as f64,
            expected: "at most 20 inputs",
        });
    }
    let mut bounds = Interval {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };
    for corner in 0_u32..1 << within.len() {
        let end = |(input, range): (usize, &Interval)| {
            if corner >> input & 1 == 0 {
                range.low
            } else {
                range.high
            }
        };
        let point: Vec<f64> = within.iter().enumerate().map(end).collect();
        let value = function(&point);
        if !value.is_finite() {
            return Err(StatsError::OutOfRange {
                what: "value at a corner",
                value,
                expected: "a finite number",
            });
        }
        bounds = Interval {
            low: bounds.low.min(value),
            high: bounds.high.max(value),
        };
    }
    Ok(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uniform(count: usize) -> Vec<BetaPosterior> {
        vec![BetaPosterior::new(1.0, 1.0).unwrap(); count]
    }

    fn outputs(design: &SharesDesign, function: impl Fn(&[f64]) -> f64) -> Vec<f64> {
        design.rows().iter().map(|row| function(row)).collect()
    }

    /// T. Ishigami and T. Homma (1990), a = 7, b = 0.1, and its shares in closed form.
    fn ishigami(x: &[f64]) -> f64 {
        let angle = |u: f64| std::f64::consts::PI * (2.0 * u - 1.0);
        angle(x[0]).sin() * (1.0 + 0.1 * angle(x[2]).powi(4)) + 7.0 * angle(x[1]).sin().powi(2)
    }

    fn shares_of_ishigami() -> [(f64, f64); 3] {
        let pi4 = std::f64::consts::PI.powi(4);
        let (first, second) = (0.5 * (1.0 + 0.1 * pi4 / 5.0).powi(2), 49.0 / 8.0);
        let third = 0.01 * pi4 * pi4 * (1.0 / 18.0 - 1.0 / 50.0);
        let variance = first + second + third;
        [
            (first / variance, (first + third) / variance),
            (second / variance, second / variance),
            (0.0, third / variance),
        ]
    }

    /// Both ways to take the means give shares whose errors say how far they are off; quadrature of a smooth function
    /// is far nearer from a third of the evaluations.
    #[test]
    fn shares_of_the_ishigami_function() {
        let exchanged = SharesDesign::exchanged(&uniform(3), 4096, 3);
        let grid = SharesDesign::new(&uniform(3), 7000, 3);
        assert!(matches!(grid.means, Means::Quadrature(_)));
        for (design, most) in [(exchanged, 0.05), (grid, 1e-3)] {
            let found = design.analyse(&outputs(&design, ishigami)).unwrap();
            for (found, (first_order, total)) in found.shares.iter().zip(shares_of_ishigami()) {
                let allowed = 3.0 * found.first_order_error + 1e-3;
                assert!(
                    (found.first_order - first_order).abs() < allowed,
                    "{found:?} {first_order}"
                );
                let allowed = 3.0 * found.total_error + 1e-3;
                assert!((found.total - total).abs() < allowed, "{found:?} {total}");
                assert!(
                    found.total_error < most && found.first_order_error < most,
                    "{found:?}"
                );
            }
            assert!((found.draws.variance() / 13.844_587_940_719_254 - 1.0).abs() < 0.02);
        }
    }

    /// For a product of independent factors, the share alone is below the total by the
    /// interaction, both in closed form from means and variances: quadrature gives them exactly.
    #[test]
    fn shares_of_a_product_of_posteriors() {
        let counts = [(7_u64, 98_u64), (3, 98), (2, 100), (0, 100_000_000), (0, 5)];
        let inputs = counts.map(|(successes, trials)| {
            BetaPosterior::jeffreys(crate::counts::Sample { successes, trials })
        });
        let relative = inputs.map(|i| i.variance() / (1.0 - i.mean()).powi(2));
        let all: f64 = relative.iter().map(|r| 1.0 + r).product::<f64>() - 1.0;
        let success = |x: &[f64]| x.iter().map(|rate| 1.0 - rate).product();
        let (quick, slow) = (
            SharesDesign::new(&inputs, 1750, 7),
            SharesDesign::exchanged(&inputs, 2000, 7),
        );
        for (design, allowed) in [(quick, 1e-12), (slow, 0.03)] {
            let found = design.analyse(&outputs(&design, success)).unwrap();
            for (share, r) in found.shares.iter().zip(relative) {
                let total = (all - ((1.0 + all) / (1.0 + r) - 1.0)) / all;
                assert!(
                    (share.first_order - r / all).abs() < allowed,
                    "{share:?} {}",
                    r / all
                );
                assert!((share.total - total).abs() < allowed, "{share:?} {total}");
            }
            let mean: f64 = inputs.iter().map(|i| 1.0 - i.mean()).product();
            assert!((found.draws.mean() - mean).abs() < 2e-3);
        }
    }

    /// A jump is not what quadrature is made for, and a peak between the nodes is not seen by it: the errors say so.
    #[test]
    fn errors_cover_what_is_not_smooth() {
        let inputs = uniform(4);
        let design = SharesDesign::new(&inputs, 1500, 2);
        assert_eq!(design.rows().len() - design.draws, 256 + 81);
        let jump = |x: &[f64]| f64::from(u8::from(x.iter().sum::<f64>() > 2.0));
        let found = design.analyse(&outputs(&design, jump)).unwrap();
        // E[q (1-q)] / (1/4) with q = P(x > 2 - s) for the sum s of the three others, whose density is known.
        let total = 7.0 / 15.0;
        for share in &found.shares {
            let off = (share.total - total).abs();
            assert!(
                off < share.total_error && share.total_error > 0.02,
                "{share:?}"
            );
        }
        let peak = |x: &[f64]| (-400.0 * (x[0] - 0.2).powi(2)).exp();
        let found = design.analyse(&outputs(&design, peak)).unwrap();
        assert!(found.shares[0].total_error > 0.1, "{found:?}");
        // More inputs than a grid can hold: rows are exchanged.
        assert!(matches!(
            SharesDesign::new(&uniform(7), 2250, 1).means,
            Means::Exchanged
        ));
    }

    #[test]
    fn a_result_that_nothing_moves_has_no_shares() {
        let design = SharesDesign::new(&uniform(2), 200, 1);
        let found = design.analyse(&outputs(&design, |_| 0.998)).unwrap();
        assert!(found.shares.is_empty());
        assert_eq!(found.draws.quantile(0.5), 0.998);
        let rounded = outputs(&design, |x| 0.998 + 1e-11 * (1e6 * x[0]).fract());
        assert!(design.analyse(&rounded).unwrap().shares.is_empty());
        assert!(design.analyse(&[1.0]).is_err());
        assert!(design.analyse(&outputs(&design, |_| f64::NAN)).is_err());
        assert!(
            SharesDesign::new(&uniform(2), 20, 1)
                .analyse(&[0.0; 20])
                .is_err()
        );
    }

    /// The difference of two variants on common rows is known far better than from two samples.
    #[test]
    fn common_rows_sharpen_differences() {
        let design = SharesDesign::new(&uniform(2), 800, 5);
        let first = outputs(&design, |x| x[0] * x[1]);
        let second = outputs(&design, |x| x[0] * x[1] + 0.001 * x[0]);
        let gain = paired_difference(&first, &second).unwrap();
        assert!(gain.quantile(0.0) > 0.0 && gain.quantile(1.0) < 0.001);
        assert!(gain.variance().sqrt() < 0.01 * Draws::new(&first).unwrap().variance().sqrt());
        assert!(paired_difference(&first, &second[1..]).is_err());
    }

    #[test]
    fn the_box_holds_all_inputs_at_its_level() {
        let inputs = uniform(3);
        let all = credible_box(&inputs, Confidence::P95);
        let held: f64 = all.iter().map(Interval::width).product();
        assert!((held - 0.95).abs() < 1e-12, "{held}");
        assert!(credible_box(&[], Confidence::P95).is_empty());
        let none_and_all = [(0, 50), (20, 20)].map(|(successes, trials)| {
            BetaPosterior::jeffreys(crate::Sample { successes, trials })
        });
        let ends = credible_box(&none_and_all, Confidence::P95);
        assert_eq!((ends[0].low, ends[1].high), (0.0, 1.0));
        let tail = |interval: &Interval, input: &BetaPosterior| {
            input.probability_between(interval.low, interval.high)
        };
        let held = tail(&ends[0], &none_and_all[0]) * tail(&ends[1], &none_and_all[1]);
        // Two one-sided tails of (1 - sqrt(0.95)) / 2 each.
        assert!((held - (1.0 - 0.5 * (1.0 - 0.95_f64.sqrt())).powi(2)).abs() < 1e-12);
        let bounds = extremes_at_corners(&all, |x| x[0] * (1.0 - x[1]) + x[2]).unwrap();
        let (low, high) = (all[0].low, all[0].high);
        assert!((bounds.low - (low * (1.0 - high) + low)).abs() < 1e-15);
        assert!((bounds.high - (high * (1.0 - low) + high)).abs() < 1e-15);
        assert!(extremes_at_corners(&vec![Interval::VACUOUS; 21], |_| 0.0).is_err());
        assert!(extremes_at_corners(&all, |_| f64::NAN).is_err());
    }
}
