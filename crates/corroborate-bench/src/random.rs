//! Random numbers that are the same for the same seed, in every thread and on every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng};
use stats::special::{beta_quantile, normal_quantile};

/// A stream of random numbers.
#[derive(Debug)]
pub struct Random(ChaCha8Rng);

impl Random {
    /// The stream of this number under this seed; streams of other numbers are independent.
    #[must_use]
    pub fn new(seed: u64, number: u64) -> Self {
        let mut stream = ChaCha8Rng::seed_from_u64(seed);
        stream.set_stream(number);
        Self(stream)
    }

    /// Uniform in (0, 1), the ends excluded.
    pub fn unit(&mut self) -> f64 {
        ((self.0.next_u64() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Between two positive numbers, uniform on the logarithmic scale.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        (self.between(low.ln(), high.ln())).exp()
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// A whole number from 0 to below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// One of several.
    pub fn one_of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// Failures before the first success, when each trial fails with probability `again`.
    pub fn geometric(&mut self, again: f64) -> u32 {
        if again <= 0.0 {
            return 0;
        }
        (self.unit().ln() / again.ln()).min(1e9) as u32
    }

    /// Normal with mean 0 and variance 1.
    pub fn normal(&mut self) -> f64 {
        normal_quantile(self.unit())
    }

    /// A cluster's rate: beta distributed with this mean and intraclass correlation.
    pub fn rate_of_cluster(&mut self, mean: f64, correlation: f64) -> f64 {
        if correlation <= 0.0 || mean <= 0.0 || mean >= 1.0 {
            return mean;
        }
        let size = 1.0 / correlation - 1.0;
        beta_quantile(mean * size, (1.0 - mean) * size, self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_have_their_means() {
        let mut random = Random::new(1, 2);
        let n = 20_000;
        let mean =
            |draw: &mut dyn FnMut() -> f64| (0..n).map(|_| draw()).sum::<f64>() / f64::from(n);
        assert!((mean(&mut || random.unit()) - 0.5).abs() < 0.01);
        assert!((mean(&mut || f64::from(random.geometric(0.75))) - 3.0).abs() < 0.15);
        assert!((mean(&mut || random.rate_of_cluster(0.9, 0.3)) - 0.9).abs() < 0.01);
        let mut other = Random::new(1, 3);
        assert_ne!(Random::new(1, 2).unit(), other.unit());
        assert_eq!(Random::new(1, 3).below(1), 0);
    }
}
