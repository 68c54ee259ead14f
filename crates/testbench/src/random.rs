//! Seeded randomness: one independent stream for each purpose.
//!
//! A purpose is a ChaCha8 stream of its own under the episode's seed (Bernstein, "ChaCha, a variant
//! of Salsa20", 2008; key from the seed, nonce from the purpose). So a further draw for one
//! purpose changes nothing for the others, and two parameter sets with the same seed share their
//! draws. Normal variates come by the method of Box and Muller (1958).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::bench::ScenarioError;

/// The random numbers for one purpose in one episode.
#[derive(Debug, Clone)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of `purpose` under `seed`, for purposes that a bench numbers. The numbers are part of the seed's meaning: a
    /// new purpose takes a new number.
    #[must_use]
    pub fn new(seed: u64, purpose: impl Into<u32>) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(u64::from(purpose.into()));
        Self(generator)
    }

    /// The stream of `name` under `seed`, for purposes that data names (a sensor, a person).
    ///
    /// The stream's number is the name's FNV-1a hash (Fowler, Noll, Vo, 1991) with the highest bit
    /// set, so it never is that of a numbered purpose.
    #[must_use]
    pub fn named(seed: u64, name: &str) -> Self {
        const OFFSET_BASIS: u64 = 0xcbf2_9ce4_8422_2325;
        const PRIME: u64 = 0x0000_0100_0000_01b3;
        let hash = name.bytes().fold(OFFSET_BASIS, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(PRIME)
        });
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(hash | 1 << 63);
        Self(generator)
    }

    /// A number uniform in [0, 1), from the upper 53 bits of a draw.
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// A number uniform in [low, high).
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// True with probability `probability`.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// An index below `count`; 0 when `count` is 0.
    pub fn index(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// A standard normal variate; takes two draws.
    pub fn standard_normal(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }
}

/// How a quantity of the scenario varies between episodes; written in TOML as a plain number,
/// `{ uniform = [low, high] }` or `{ normal = [mean, standard deviation] }`.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Deserialize)]
#[serde(untagged)]
pub enum Distribution {
    /// Always this value.
    Constant(f64),
    /// Uniform between two values.
    Uniform {
        /// Lowest and highest value.
        uniform: [f64; 2],
    },
    /// Normal, not truncated.
    Normal {
        /// Mean and standard deviation.
        normal: [f64; 2],
    },
}

impl Distribution {
    /// Draws a value. A constant takes no draw from the stream.
    pub fn draw(&self, stream: &mut Stream) -> f64 {
        match *self {
            Self::Constant(value) => value,
            Self::Uniform {
                uniform: [low, high],
            } => stream.uniform(low, high),
            Self::Normal {
                normal: [mean, deviation],
            } => mean + deviation * stream.standard_normal(),
        }
    }

    /// The smallest and the largest value that can come, infinite for a normal distribution.
    #[must_use]
    pub fn support(&self) -> [f64; 2] {
        match *self {
            Self::Constant(value) => [value, value],
            Self::Uniform { uniform } => uniform,
            Self::Normal {
                normal: [mean, 0.0],
            } => [mean, mean],
            Self::Normal { .. } => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// The value below which half of all draws are.
    #[must_use]
    pub fn middle(&self) -> f64 {
        match *self {
            Self::Constant(value) => value,
            Self::Uniform {
                uniform: [low, high],
            } => low + 0.5 * (high - low),
            Self::Normal { normal: [mean, _] } => mean,
        }
    }

    /// Checks that the numbers are finite, in order, and that every value lies in
    /// `[low, high]`.
    ///
    /// # Errors
    /// [`ScenarioError::Value`] naming `key`.
    pub fn check(&self, key: &str, low: f64, high: f64) -> Result<(), ScenarioError> {
        let numbers = match *self {
            Self::Constant(value) => [value, value],
            Self::Uniform { uniform: pair } | Self::Normal { normal: pair } => pair,
        };
        if numbers.iter().any(|number| !number.is_finite()) {
            return Err(ScenarioError::value(key, "must be finite"));
        }
        if matches!(self, Self::Uniform { uniform: [a, b] } if a > b) {
            return Err(ScenarioError::value(
                key,
                "has its lowest value above its highest",
            ));
        }
        if matches!(self, Self::Normal { normal: [_, deviation] } if *deviation < 0.0) {
            return Err(ScenarioError::value(
                key,
                "has a negative standard deviation",
            ));
        }
        let [smallest, largest] = self.support();
        if smallest < low || largest > high {
            return Err(ScenarioError::value(
                key,
                &format!("must lie between {low} and {high}"),
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_of_one_seed_differ_and_repeat() {
        let draw = |seed, purpose: u32| Stream::new(seed, purpose).unit().to_bits();
        assert_eq!(draw(7, 3), draw(7, 3));
        assert_ne!(draw(7, 3), draw(7, 1));
        assert_ne!(draw(7, 3), draw(8, 3));
    }

    #[test]
    fn named_streams_differ_from_each_other_and_from_purposes() {
        let first = |name| Stream::named(7, name).unit().to_bits();
        assert_eq!(first("lidar"), first("lidar"));
        assert_ne!(first("lidar"), first("lidar2"));
        for purpose in [1_u32, 3, 6] {
            assert_ne!(first("lidar"), Stream::new(7, purpose).unit().to_bits());
        }
    }

    #[test]
    fn moments_are_those_of_the_distributions() {
        let mut stream = Stream::new(1, 1_u32);
        let count = 200_000;
        let mut moments = |distribution: Distribution| {
            let values: Vec<f64> = (0..count).map(|_| distribution.draw(&mut stream)).collect();
            let mean = values.iter().sum::<f64>() / count as f64;
            let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count as f64;
            (mean, variance.sqrt())
        };
        // Five standard errors of the mean are 5 * 2 / sqrt(200000) = 0.022.
        let (mean, deviation) = moments(Distribution::Normal { normal: [3.0, 2.0] });
        assert!((mean - 3.0).abs() < 0.022 && (deviation - 2.0).abs() < 0.02);
        let (mean, deviation) = moments(Distribution::Uniform {
            uniform: [1.0, 15.0],
        });
        assert!((mean - 8.0).abs() < 0.05 && (deviation - 14.0 / 12.0_f64.sqrt()).abs() < 0.05);
    }

    #[test]
    fn bounds_are_checked_with_the_key_named() {
        let wrong = Distribution::Uniform {
            uniform: [2.0, 1.0],
        };
        assert!(
            wrong
                .check("pull", 0.0, 9.0)
                .unwrap_err()
                .to_string()
                .contains("pull")
        );
        assert!(
            Distribution::Constant(-1.0)
                .check("mass", 0.0, 9.0)
                .is_err()
        );
        assert!(Distribution::Constant(1.0).check("mass", 0.0, 9.0).is_ok());
    }
}
