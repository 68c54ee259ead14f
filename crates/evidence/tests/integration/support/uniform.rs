//! Seeded numbers for tests and simulations.
#![allow(dead_code, reason = "each test and example uses its part")]

use stats::{BetaPosterior, Sample};

/// Uniform numbers: SplitMix64 (G. L. Steele, D. Lea and C. H. Flood, 2014).
pub struct Uniform(pub u64);

impl Uniform {
    /// A number from 0 to 1, without 1.
    pub fn draw(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Successes of so many trials.
    pub fn count(&mut self, trials: u64, rate: f64) -> u64 {
        (0..trials).filter(|_| self.draw() < rate).count() as u64
    }

    /// Whether something of this probability occurs.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.draw() < probability
    }

    /// One of these.
    pub fn of<T: Copy>(&mut self, items: &[T]) -> T {
        items[(self.draw() * items.len() as f64) as usize % items.len()]
    }

    /// So many trials with their successes.
    pub fn sample(&mut self, trials: u64, rate: f64) -> Sample {
        Sample {
            successes: self.count(trials, rate),
            trials,
        }
    }

    /// A person's rate, of the beta distribution with this mean and intraclass correlation; the mean at a correlation of 0.
    pub fn rate(&mut self, mean: f64, correlation: f64) -> f64 {
        let theta = correlation / (1.0 - correlation);
        let place = self.draw().clamp(1e-12, 1.0 - 1e-12);
        let rates = BetaPosterior::new(mean / theta, (1.0 - mean) / theta);
        rates.map_or(mean, |rates| rates.quantile(place))
    }

    /// People with so many trials each, at rates of their own.
    pub fn people(
        &mut self,
        people: usize,
        trials: u64,
        mean: f64,
        correlation: f64,
    ) -> Vec<Sample> {
        let of = |_| {
            let rate = self.rate(mean, correlation);
            self.sample(trials, rate)
        };
        (0..people).map(of).collect()
    }
}
