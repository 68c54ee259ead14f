//! Boschloo's test that two proportions are equal: exact like Fisher's, and never less powerful.
//!
//! Fisher's p-value is taken for a statistic, and its distribution without fixed margins, for the
//! common rate `pi` that is least favourable. With `t` the p-value observed and `n + m = N`,
//!
//! ```text
//! p = max over pi of  sum over M of Binomial(M; N, pi) h(M),
//! h(M) = P(Fisher's p-value <= t | M successes in all)  <=  t
//! ```
//!
//! Source: R. D. Boschloo, "Raised conditional level of significance for the 2 x 2 table when
//! testing the equality of two probabilities" (1970), with Fisher's two-sided p-value. Deviations:
//! `h` is summed from both tails of the hypergeometric distribution inwards, within nine standard
//! deviations; the maximum is searched on the scale `pi = sin^2 a` in steps of an eighth of the
//! binomial's width and then by a golden section. Beyond [`MOST_TRIALS`] trials in all, and for p-values below
//! [`SMALLEST`], Fisher's is given: it is then hardly larger. Cost: `O(N^1.5)`. Guarantee: a true
//! hypothesis is rejected at level `alpha` with probability at most `alpha`, for every common
//! rate; the p-value is never above Fisher's.
//!
//! # Assumes
//! Trials of each sample are independent with one rate, the samples are independent of each other, and both sizes were
//! fixed in advance. The maximum over the common rate is the largest value that the search found, not a bound.

use crate::counts::Sample;
use crate::fisher::{Table, fisher_exact};
use crate::special::binomial_pmf;

/// Trials of both samples together beyond which Fisher's p-value is given.
pub const MOST_TRIALS: u64 = 4000;

/// Fisher's p-values below this are given as they are.
pub const SMALLEST: f64 = 1e-12;

/// Standard deviations beyond which nothing counts.
const WIDTH: f64 = 9.0;

/// The two-sided p-value of two samples having the same true proportion; 1 when either carries no
/// information.
///
/// ```
/// use stats::{Sample, boschloo_exact, fisher_exact};
/// let (first, second) = (Sample::new(80, 100)?, Sample::new(88, 100)?);
/// assert!((fisher_exact(first, second) - 0.176).abs() < 1e-3);
/// assert!((boschloo_exact(first, second) - 0.138).abs() < 1e-3);
/// # Ok::<(), stats::StatsError>(())
/// ```
#[must_use]
pub fn boschloo_exact(first: Sample, second: Sample) -> f64 {
    let conditional = fisher_exact(first, second);
    let total = first.trials.saturating_add(second.trials);
    if !(SMALLEST..1.0).contains(&conditional) || total > MOST_TRIALS {
        return conditional;
    }
    let levels: Vec<f64> = (0..=total)
        .map(|marked| attained(first.trials, total, marked, conditional))
        .collect();
    least_favourable(&levels).min(conditional)
}

/// The largest probability, given `marked` successes in all, of tables whose p-value is at most
/// `level`.
fn attained(drawn: u64, total: u64, marked: u64, level: f64) -> f64 {
    let table = Table::with_margins(marked, drawn, total);
    let (n, m) = (total as f64, marked as f64);
    let mean = drawn as f64 * m / n;
    let deviation = (mean * (1.0 - m / n) * (n - drawn as f64) / (n - 1.0).max(1.0)).sqrt();
    let reach = WIDTH * deviation + 2.0;
    let mut low = table.low.max((mean - reach).max(0.0) as u64);
    let mut high = table.high.min((mean + reach) as u64);
    let (mut at_low, mut at_high) = (table.pmf(low), table.pmf(high));
    // As in Fisher's test, outcomes of nearly the same density count together.
    let (limit, equal) = (
        level * (1.0 + 1e-9),
        1.0 + crate::binomial::EQUAL_LIKELIHOOD,
    );
    let mut sum = 0.0;
    while low < high {
        let (take_low, take_high) = (at_low <= at_high * equal, at_high <= at_low * equal);
        let more = if take_low { at_low } else { 0.0 } + if take_high { at_high } else { 0.0 };
        if sum + more > limit {
            return sum;
        }
        sum += more;
        if take_low {
            at_low *= table.ratio(low);
            low += 1;
        }
        if take_high {
            high -= 1;
            at_high /= table.ratio(high);
        }
        if low > high {
            break;
        }
    }
    // The last outcome is the mode, with which the p-value would be 1.
    sum
}

/// The maximum over the common rate of the mean level.
fn least_favourable(levels: &[f64]) -> f64 {
    let total = (levels.len() - 1) as f64;
    let mean = |angle: f64| mean_level(levels, angle.sin().powi(2));
    let step = 0.125 / total.sqrt();
    let most = std::f64::consts::FRAC_PI_2;
    let points = (most / step).ceil() as usize;
    let best = (0..=points)
        .map(|point| most * point as f64 / points as f64)
        .map(|angle| (angle, mean(angle)))
        .fold(
            (0.0, 0.0),
            |best, new| if new.1 > best.1 { new } else { best },
        );
    let (mut low, mut high) = ((best.0 - step).max(0.0), (best.0 + step).min(most));
    let mut largest = best.1;
    for _ in 0..30 {
        let (left, right) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        let (at_left, at_right) = (mean(left), mean(right));
        largest = largest.max(at_left).max(at_right);
        if at_left >= at_right {
            high = right
        } else {
            low = left
        }
    }
    largest
}

/// The mean of the levels when the number of successes is binomial, from its mode outwards.
fn mean_level(levels: &[f64], rate: f64) -> f64 {
    let total = (levels.len() - 1) as u64;
    if rate <= 0.0 || rate >= 1.0 {
        return levels[if rate <= 0.0 { 0 } else { total as usize }];
    }
    let odds = rate / (1.0 - rate);
    let mode = (((total + 1) as f64 * rate) as u64).min(total);
    let start = binomial_pmf(mode, total, rate);
    let mut sum = start * levels[mode as usize];
    let mut density = start;
    for k in mode..total {
        density *= (total - k) as f64 / (k + 1) as f64 * odds;
        sum += density * levels[k as usize + 1];
        if density < 1e-18 {
            break;
        }
    }
    density = start;
    for k in (0..mode).rev() {
        density *= (k + 1) as f64 / ((total - k) as f64 * odds);
        sum += density * levels[k as usize];
        if density < 1e-18 {
            break;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn p(s: u64, n: u64, r: u64, m: u64) -> f64 {
        boschloo_exact(
            Sample {
                successes: s,
                trials: n,
            },
            Sample {
                successes: r,
                trials: m,
            },
        )
    }

    /// By numpy and scipy 1.16: Fisher's p-values of all tables, their cumulated probabilities,
    /// and the maximum over the common rate by minimize_scalar from the best of 2000 rates.
    #[test]
    fn reference_values() {
        let cases = [
            ((80, 100, 88, 100), 0.137_610_661_392_983_1),
            ((20, 100, 3, 100), 0.000_164_193_628_907_997_6),
            ((3, 10, 9, 12), 0.057_768_915_762_299_89),
            ((0, 5, 4, 8), 0.087_402_343_75),
            ((88, 98, 102, 102), 0.000_494_672_029_902_990_4),
            ((7, 7, 30, 41), 0.133_691_229_868_558_8),
        ];
        for ((s, n, r, m), expected) in cases {
            let (found, back) = (p(s, n, r, m), p(r, m, s, n));
            assert!(
                (found / expected - 1.0).abs() < 1e-9,
                "{s}/{n} {r}/{m}: {found} {expected}"
            );
            assert!((found / back - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn never_above_fishers_and_equal_where_nothing_is_gained() {
        for (s, n, r, m) in [
            (1, 3, 2, 40),
            (5, 5, 5, 5),
            (0, 20, 0, 3),
            (300, 1000, 350, 1000),
        ] {
            let (first, second) = (
                Sample {
                    successes: s,
                    trials: n,
                },
                Sample {
                    successes: r,
                    trials: m,
                },
            );
            assert!(boschloo_exact(first, second) <= fisher_exact(first, second));
        }
        let large = (
            Sample {
                successes: 3000,
                trials: 10_000,
            },
            Sample {
                successes: 2900,
                trials: 10_000,
            },
        );
        assert_eq!(
            boschloo_exact(large.0, large.1),
            fisher_exact(large.0, large.1)
        );
        assert_eq!(p(0, 0, 3, 4), 1.0);
        assert_eq!(p(3, 2, 3, 4), 1.0);
    }

    /// At every common rate, a true hypothesis is rejected at most at the level.
    #[test]
    fn the_level_is_kept_for_every_rate_and_used_better_than_fishers() {
        let (n, m) = (12_u64, 17_u64);
        let mut largest: (f64, f64) = (0.0, 0.0);
        let table: Vec<(f64, f64, u64, u64)> = (0..=n)
            .flat_map(|a| (0..=m).map(move |b| (a, b)))
            .map(|(a, b)| {
                let pair = (
                    Sample {
                        successes: a,
                        trials: n,
                    },
                    Sample {
                        successes: b,
                        trials: m,
                    },
                );
                (
                    boschloo_exact(pair.0, pair.1),
                    fisher_exact(pair.0, pair.1),
                    a,
                    b,
                )
            })
            .collect();
        for step in 1..100 {
            let rate = f64::from(step) / 100.0;
            let (mut ours, mut fishers) = (0.0, 0.0);
            for (p, fisher, a, b) in &table {
                let weight = binomial_pmf(*a, n, rate) * binomial_pmf(*b, m, rate);
                ours += weight * f64::from(u8::from(*p <= 0.05));
                fishers += weight * f64::from(u8::from(*fisher <= 0.05));
            }
            assert!(
                ours <= 0.05 + 1e-9 && ours >= fishers,
                "{rate}: {ours} {fishers}"
            );
            largest = (largest.0.max(ours), largest.1.max(fishers));
        }
        assert!(largest.0 > largest.1 + 0.005, "{largest:?}");
    }
}
