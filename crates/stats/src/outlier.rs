//! Whether one subject of a cohort differs from all others.
//!
//! # Definition
//! Of subjects `i` with `k_i` of `n_i` trials, the hypothesis is that all are alike: their rates are draws of one beta
//! distribution with mean `p` and intraclass correlation `rho`, of which nothing is known (`p` by Jeffreys' prior, `rho`
//! from 0 to `MOST_ALIKE` with a weight of `(MOST_ALIKE - rho)^2`, whose mean is 0.075: people who do the same task are seldom
//! more alike). The alternative for subject `i` is that its rate has nothing to do with the others',
//! and has Jeffreys' prior itself. The e-value of the subject is
//!
//! `e_i = P(k_i | a rate of its own) / P(k_i | what the others did)`,
//!
//! the prediction being the beta-binomial distribution averaged over the posterior of `(p, rho)` given all others. Since
//! any of `m` subjects can be the one, what counts is `e_i / m`.
//!
//! # Source
//! H. Jeffreys, "Theory of Probability" (1961), section 5 (a Bayes factor); V. Vovk, R. Wang, "E-values: calibration,
//! combination and applications", Annals of Statistics 49 (2021), proposition 3.1 (the mean of e-values is one); J. G.
//! Skellam, JRSS B 10 (1948), for the beta-binomial distribution.
//!
//! # Assumes
//! Under the hypothesis subjects are independent, with rates of one beta distribution, and trials of one are independent
//! given its rate. Numbers of trials tell nothing of rates.
//!
//! # Guarantee
//! Each `e_i` is non-negative and has expectation 1 under the hypothesis (exactly, on average over the prior: tested by
//! enumerating all outcomes), and so has their mean, which is at least the largest divided by `m`. By Markov's inequality
//! `max e_i / m` is at least `x` with probability at most `1/x` on average over the prior of `p` and `rho`, not for each
//! single value of them: the guarantee is of the grid of `MEANS` times `CORRELATIONS` values. The weight of `rho` was chosen
//! for power among four, on six cohorts; it is an assumption and not derived. For fixed `p` and `rho` the rate of errors
//! is measured on few draws (tests).
//!
//! # Cost
//! One beta-binomial likelihood for each subject and value of the grid.

use crate::special::ln_gamma;
use crate::{Sample, StatsError};

/// The largest intraclass correlation that subjects who are alike are taken to have.
const MOST_ALIKE: f64 = 0.3;

/// Values of the mean in the grid.
const MEANS: u32 = 200;

/// Values of the correlation in the grid.
const CORRELATIONS: u32 = 16;

/// The subject that differs most from all others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outlier {
    /// Its place.
    pub place: usize,
    /// Its e-value divided by the number of subjects.
    pub e_value: f64,
}

/// The subject that differs most from all others; `None` with fewer than three subjects who have trials.
///
/// ```
/// use stats::{Sample, outlier};
/// let cohort = [9, 10, 9, 8, 1, 10, 9, 10].map(|successes| Sample { successes, trials: 10 });
/// let found = outlier(&cohort)?.expect("enough subjects");
/// assert_eq!(found.place, 4);
/// assert!(found.e_value > 20.0);
/// # Ok::<(), stats::StatsError>(())
/// ```
///
/// # Errors
/// [`StatsError`] for more successes than trials.
pub fn outlier(subjects: &[Sample]) -> Result<Option<Outlier>, StatsError> {
    for it in subjects {
        Sample::new(it.successes, it.trials)?;
    }
    let with_trials = subjects.iter().filter(|it| it.trials > 0).count();
    if with_trials < 3 {
        return Ok(None);
    }
    let all = e_values(subjects);
    let best = all.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
    Ok(best.map(|(place, e_value)| Outlier {
        place,
        e_value: e_value / with_trials as f64,
    }))
}

/// The e-value of each subject; 0 of one without trials.
fn e_values(subjects: &[Sample]) -> Vec<f64> {
    let grid = grid();
    // The likelihood of each subject at each place of the grid, binomial coefficients left out on both sides.
    let likelihoods: Vec<Vec<f64>> = grid
        .iter()
        .map(|(_, shape)| subjects.iter().map(|it| shape.ln_likelihood(*it)).collect())
        .collect();
    let sums: Vec<f64> = likelihoods.iter().map(|all| all.iter().sum()).collect();
    let of = |place: usize| {
        if subjects[place].trials == 0 {
            return 0.0;
        }
        let weights = grid.iter().zip(likelihoods.iter().zip(&sums));
        let others = weights.map(|((prior, _), (all, sum))| prior + sum - all[place]);
        let others: Vec<f64> = others.collect();
        let with = others.iter().zip(&likelihoods);
        let with: Vec<f64> = with.map(|(others, all)| others + all[place]).collect();
        let predicted = ln_sum(&with) - ln_sum(&others);
        let own = Shape::Beta { a: 0.5, b: 0.5 }.ln_likelihood(subjects[place]);
        (own - predicted).exp()
    };
    (0..subjects.len()).map(of).collect()
}

/// How the rates of subjects are distributed.
#[derive(Clone, Copy)]
enum Shape {
    /// All have this rate.
    Same(f64),
    /// Draws of a beta distribution.
    Beta { a: f64, b: f64 },
}

impl Shape {
    fn ln_likelihood(self, sample: Sample) -> f64 {
        let (hits, misses) = (sample.successes as f64, sample.failures() as f64);
        match self {
            Self::Same(p) => hits * p.ln() + misses * (1.0 - p).ln(),
            Self::Beta { a, b } => ln_beta(a + hits, b + misses) - ln_beta(a, b),
        }
    }
}

/// The places of the grid with the logarithms of their prior weights: the mean in equal parts of Jeffreys' prior, the
/// correlation in equal steps from 0, small ones with more weight.
fn grid() -> Vec<(f64, Shape)> {
    let weight = |step: u32| f64::from(CORRELATIONS - step).powi(2);
    let all: f64 = (0..CORRELATIONS).map(weight).sum::<f64>() * f64::from(MEANS);
    let mut grid = Vec::new();
    for step in 0..CORRELATIONS {
        let rho = MOST_ALIKE * f64::from(step) / f64::from(CORRELATIONS);
        let weight = (weight(step) / all).ln();
        for mean in 0..MEANS {
            // The quantiles of the arcsine law.
            let part = (f64::from(mean) + 0.5) / f64::from(MEANS);
            let p = (std::f64::consts::FRAC_PI_2 * part).sin().powi(2);
            let shape = match step {
                0 => Shape::Same(p),
                _ => Shape::Beta {
                    a: p * (1.0 - rho) / rho,
                    b: (1.0 - p) * (1.0 - rho) / rho,
                },
            };
            grid.push((weight, shape));
        }
    }
    grid
}

fn ln_beta(a: f64, b: f64) -> f64 {
    ln_gamma(a) + ln_gamma(b) - ln_gamma(a + b)
}

/// The logarithm of a sum of which the logarithms are known.
fn ln_sum(all: &[f64]) -> f64 {
    let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    most + all.iter().map(|it| (it - most).exp()).sum::<f64>().ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(successes: u64, trials: u64) -> Sample {
        Sample { successes, trials }
    }

    fn choose(n: u64, k: u64) -> f64 {
        (0..k).map(|i| (n - i) as f64 / (i + 1) as f64).product()
    }

    #[test]
    fn the_expectation_is_one_over_all_outcomes() {
        let trials = 2;
        let mut expected = [0.0; 3];
        for code in 0..27 {
            let counts = [code % 3, code / 3 % 3, code / 9];
            let cohort = counts.map(|k| sample(k, trials));
            let ln =
                |shape: &Shape| -> f64 { cohort.iter().map(|it| shape.ln_likelihood(*it)).sum() };
            let all: Vec<f64> = grid()
                .iter()
                .map(|(prior, shape)| prior + ln(shape))
                .collect();
            let ways: f64 = counts.iter().map(|k| choose(trials, *k)).product();
            let probability = ways * ln_sum(&all).exp();
            for (sum, e) in expected.iter_mut().zip(e_values(&cohort)) {
                *sum += probability * e;
            }
        }
        for sum in expected {
            assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        }
    }

    /// SplitMix64, to draw cohorts.
    struct Draws(u64);

    impl Draws {
        fn chance(&mut self, p: f64) -> bool {
            self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.0;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 <= p
        }

        /// Pólya's urn: each trial is like the earlier ones of its subject, with this correlation.
        fn subject(&mut self, p: f64, rho: f64, trials: u64) -> Sample {
            let mut hits = 0;
            for done in 0..trials {
                let (kept, done) = (rho * hits as f64, rho * done as f64);
                hits += u64::from(self.chance((p * (1.0 - rho) + kept) / (1.0 - rho + done)));
            }
            sample(hits, trials)
        }
    }

    #[test]
    fn who_are_alike_are_rarely_called_outliers_and_who_differs_is_found() {
        let mut draws = Draws(7);
        for (p, rho, subjects) in [
            (0.85, 0.0, 10),
            (0.85, 0.08, 24),
            (0.6, 0.2, 15),
            (0.95, 0.08, 6),
        ] {
            let (mut wrong, mut found) = (0, 0);
            for _ in 0..100 {
                let mut cohort: Vec<Sample> =
                    (0..subjects).map(|_| draws.subject(p, rho, 10)).collect();
                let e = |cohort: &[Sample]| outlier(cohort).expect("counts").expect("subjects");
                wrong += u32::from(e(&cohort).e_value >= 20.0);
                cohort[2] = draws.subject(0.02, 0.0, 10);
                let it = e(&cohort);
                found += u32::from(it.place == 2 && it.e_value >= 10.0);
            }
            assert!(wrong <= 8, "{p} {rho}: {wrong} of 100");
            assert!(
                found >= 50 || rho > 0.1 || subjects < 10,
                "{p} {rho}: {found} of 100"
            );
        }
    }

    #[test]
    fn few_subjects_tell_nothing_and_wrong_counts_are_errors() {
        assert_eq!(
            outlier(&[sample(1, 5), sample(5, 5), sample(0, 0)]),
            Ok(None)
        );
        assert!(outlier(&[sample(6, 5), sample(5, 5), sample(0, 1)]).is_err());
    }
}
