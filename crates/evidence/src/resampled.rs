//! Further people as those so far tell of them: for plans that are held against the tests by which something is concluded.
//!
//! # Definition
//! People have rates of one beta distribution, as in the likelihood by which they are judged (`stats::BetaBinomial`). Its mean and
//! correlation have the posterior of the counts so far, on a grid, with Jeffreys' prior of the mean and a flat one of the correlation. Each
//! draw takes one pair of them; a further person's rate is drawn from that beta distribution, and their trials from that rate.
//!
//! # Source
//! A. O'Hagan, J. W. Stevens and M. J. Campbell, "Assurance in clinical trial design" (2005): what is known now, not a guess at it. (A
//! posterior of each person's own trials in place of the population's would draw rates towards one half, the more the fewer trials each has.)
//!
//! # Assumes
//! Further people are of the population of those so far, whose rates have a beta distribution.
//!
//! # Guarantee
//! The same numbers each time.

use crate::FurtherSubjects;
use stats::{BetaBinomial, BetaPosterior, Sample};
use std::f64::consts::FRAC_PI_2;

/// Draws of each number of people.
pub(crate) const DRAWS: u64 = 40;
/// A simulated chance below this share of the wanted one is clearly less.
pub(crate) const CLEARLY: f64 = 0.8;
/// More trials of one person than this are not drawn one by one.
pub(crate) const MOST_EACH: u64 = 2_000;
/// More people than this are not drawn.
pub(crate) const MOST_PEOPLE: u64 = 400;

/// By how much a number of people grows that is clearly too small: twofold, up to [`MOST_PEOPLE`]; `None` where it is that.
pub(crate) fn growth(people: u64) -> Option<f64> {
    (people < MOST_PEOPLE).then(|| (MOST_PEOPLE as f64 / people.max(1) as f64).min(2.0))
}

/// The chances of two things of which draws show at most one, after so many that show each: so many draws do not tell a chance of 99 % from
/// certainty.
pub(crate) fn shares(shown: [u64; 2]) -> (f64, f64) {
    let both = shown[0] + shown[1];
    let chance = (both as f64 / DRAWS as f64).min(1.0 - 0.5 / DRAWS as f64);
    let share = |count: u64| chance * count as f64 / both.max(1) as f64;
    (share(shown[0]), share(shown[1]))
}

/// Means and correlations of the grid.
const MEANS: u32 = 160;
const CORRELATIONS: u32 = 16;

/// People so far, with what is known of all of their kind.
pub(crate) struct Population<'a> {
    rows: &'a [Sample],
    /// Means and correlations, and the probability of all up to each.
    upto: Vec<(f64, f64, f64)>,
}

impl<'a> Population<'a> {
    /// Of the counts of each; `None` of fewer than two.
    pub fn new(rows: &'a [Sample]) -> Option<Self> {
        let fit = BetaBinomial::fit(rows).ok()?;
        let best = fit.ln_likelihood(fit.mean, fit.intraclass_correlation);
        let mut upto = Vec::with_capacity((MEANS * CORRELATIONS) as usize);
        let mut sum = 0.0;
        for i in 0..MEANS {
            // Equally spaced in the angle: Jeffreys' prior.
            let mean = (FRAC_PI_2 * (f64::from(i) + 0.5) / f64::from(MEANS))
                .sin()
                .powi(2);
            for j in 0..CORRELATIONS {
                // Closer together near independence, each with the width that it stands for.
                let root = (f64::from(j) + 0.5) / f64::from(CORRELATIONS);
                let correlation = root * root;
                sum += root * (fit.ln_likelihood(mean, correlation) - best).exp();
                upto.push((mean, correlation, sum));
            }
        }
        (sum.is_finite() && sum > 0.0).then_some(Self { rows, upto })
    }

    fn at(&self, place: f64) -> (f64, f64) {
        let sum = self.upto.last().map_or(0.0, |it| it.2);
        let found = self.upto.partition_point(|it| it.2 < place * sum);
        let (mean, correlation, _) = self.upto[found.min(self.upto.len() - 1)];
        (mean, correlation)
    }
}

/// Numbers that look drawn (SplitMix64), and people by them.
pub(crate) struct Resampled(u64);

impl Default for Resampled {
    fn default() -> Self {
        Self(0x5eed)
    }
}

impl Resampled {
    /// Other numbers.
    #[cfg(test)]
    pub fn seeded(seed: u64) -> Self {
        Self(seed)
    }

    /// These people and so many further ones of their population.
    pub fn with_further(
        &mut self,
        population: &Population<'_>,
        people: FurtherSubjects,
    ) -> Vec<Sample> {
        let (mean, correlation) = population.at(self.uniform());
        let precision = 1.0 / correlation - 1.0;
        let rates = BetaPosterior::new(mean * precision, (1.0 - mean) * precision);
        let mut all = population.rows.to_vec();
        for _ in 0..people.subjects {
            let place = self.uniform();
            let rate = rates.as_ref().map_or(mean, |it| it.quantile(place));
            let trials = people.each;
            let successes = (0..trials).filter(|_| self.uniform() < rate).count() as u64;
            all.push(Sample { successes, trials });
        }
        all
    }

    /// One of these values, each as likely as its weight.
    pub fn weighted(&mut self, values: &[(u64, f64)]) -> u64 {
        let mut left = self.uniform() * values.iter().map(|(_, weight)| weight).sum::<f64>();
        for (value, weight) in values {
            left -= weight;
            if left <= 0.0 {
                return *value;
            }
        }
        values.last().map_or(0, |(value, _)| *value)
    }

    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        ((bits >> 11) as f64 + 0.5) / 2_f64.powi(53)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The means of many further people over the draws: their centre, and how far they scatter.
    fn drawn(rows: &[[u64; 2]]) -> (f64, f64) {
        let rows: Vec<Sample> = rows
            .iter()
            .map(|&[successes, trials]| Sample { successes, trials })
            .collect();
        let population = Population::new(&rows).expect("several people");
        let mut drawn = Resampled::default();
        let people = FurtherSubjects {
            subjects: 150,
            each: 10,
        };
        let mut mean = || {
            let all = drawn.with_further(&population, people);
            assert_eq!(all.len(), rows.len() + 150);
            let further = all[rows.len()..].iter();
            further.map(|it| it.successes).sum::<u64>() as f64 / 1_500.0
        };
        let means: Vec<f64> = (0..400).map(|_| mean()).collect();
        let centre = means.iter().sum::<f64>() / 400.0;
        let squares = means.iter().map(|it| (it - centre).powi(2)).sum::<f64>();
        (centre, (squares / 399.0).sqrt())
    }

    /// Rates are not drawn towards one half where each person has few trials, and are as uncertain as the people are few.
    #[test]
    fn further_people_are_like_those_so_far() {
        // What a posterior of each person's own two trials made 0.83 of.
        let (centre, _) = drawn(&[[2, 2]; 20]);
        assert!(centre > 0.95, "{centre}");
        let (centre, spread) = drawn(&[
            [3, 6],
            [6, 6],
            [6, 6],
            [5, 6],
            [6, 6],
            [4, 6],
            [6, 6],
            [6, 6],
        ]);
        assert!((centre - 42.0 / 48.0).abs() < 0.05, "{centre}");
        assert!((0.04..0.12).contains(&spread), "{spread}");
        // Many who are alike: nearly the binomial spread of what is known, and of what is drawn.
        let (centre, spread) = drawn(&[[9, 10]; 40]);
        let binomial = (0.09_f64 * (1.0 / 400.0 + 1.0 / 1_500.0)).sqrt();
        assert!((centre - 0.9).abs() < 0.01, "{centre}");
        assert!(
            (0.8..1.6).contains(&(spread / binomial)),
            "{spread} {binomial}"
        );
    }

    #[test]
    fn forty_draws_show_no_certainty() {
        assert!(shares([DRAWS, 0]).0 < 0.99);
        assert!((shares([20, 0]).0 - 0.5).abs() < 1e-12);
    }
}
