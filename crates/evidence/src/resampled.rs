//! Further people as those so far may have them: for plans that are held against the tests by which something is concluded.
//!
//! # Definition
//! Each draw gives the people so far weights that are uniform over all that sum to one, since it is not known how common their kinds are.
//! A further person is like one of them, drawn by these weights: their rate is drawn from Jeffreys' posterior of that one's trials, and
//! their trials from that rate.
//!
//! # Source
//! D. B. Rubin, "The Bayesian bootstrap", The Annals of Statistics 9 (1981), of people, with a posterior in place of each one's share.
//!
//! # Assumes
//! Further people are of the kinds of those so far.
//!
//! # Guarantee
//! The same numbers each time.

use crate::FurtherSubjects;
use stats::{BetaPosterior, EffectiveSample, Sample};

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

    /// These people and so many further ones.
    pub fn with_further(&mut self, rows: &[Sample], people: FurtherSubjects) -> Vec<Sample> {
        let mut upto = Vec::with_capacity(rows.len());
        let mut sum = 0.0;
        for _ in rows {
            // Exponential weights over their sum are uniform over all weights.
            sum -= self.uniform().ln();
            upto.push(sum);
        }
        let mut all = rows.to_vec();
        for _ in 0..people.subjects {
            let place = sum * self.uniform();
            let like = upto.partition_point(|&end| end < place).min(rows.len() - 1);
            let rate = self.rate(EffectiveSample::from(rows[like]));
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

    /// A rate of Jeffreys' posterior of what is known.
    fn rate(&mut self, known: EffectiveSample) -> f64 {
        BetaPosterior::jeffreys(known).quantile(self.uniform())
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
    use stats::Interval;

    /// The mean of many further people scatters as much as the mean of those so far is uncertain.
    #[test]
    fn further_people_are_as_uncertain_as_those_so_far() {
        let rows = [[2, 10], [9, 10], [10, 10], [8, 10], [9, 10], [10, 10]];
        let rows = rows.map(|[successes, trials]| Sample { successes, trials });
        let mut drawn = Resampled::default();
        let people = FurtherSubjects {
            subjects: 200,
            each: 10,
        };
        let mean = |drawn: &mut Resampled| {
            let all = drawn.with_further(&rows, people);
            assert_eq!(all.len(), 206);
            let further = all[rows.len()..].iter();
            further.map(|it| it.successes).sum::<u64>() as f64 / 2_000.0
        };
        let means: Vec<f64> = (0..300).map(|_| mean(&mut drawn)).collect();
        let centre = means.iter().sum::<f64>() / 300.0;
        let spread = means.iter().map(|it| (it - centre).powi(2)).sum::<f64>() / 299.0;
        // Of the posteriors' means 2.5/11, 9.5/11, ..., whose weights vary by 1/(n (n + 1)) times the sum of squares.
        let places = rows.map(|it| (it.successes as f64 + 0.5) / 11.0);
        let exact = places.iter().sum::<f64>() / 6.0;
        let squares = places.iter().map(|it| (it - exact).powi(2)).sum::<f64>();
        let expected = squares / 42.0;
        assert!((centre - exact).abs() < 0.02, "{centre} {exact}");
        let near = Interval {
            low: 0.75 * expected,
            high: 1.35 * expected,
        };
        assert!(
            (near.low..near.high).contains(&spread),
            "{spread} {expected}"
        );
    }
}
