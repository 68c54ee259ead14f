//! Seeded random numbers whose state can be kept: seed, stream, and how many were drawn.
//!
//! Source: ChaCha8 (D. J. Bernstein, "ChaCha, a variant of Salsa20", 2008), key from the seed,
//! nonce from the stream; normal variates by G. E. P. Box and M. E. Muller (1958). Guarantee: a
//! generator that was written down and read back goes on with the very same numbers.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// A stream of random numbers, resumable from its written form.
///
/// ```
/// use campaign::Random;
/// let mut random = Random::new(7, "mutation");
/// random.unit();
/// let kept = serde_json::to_string(&random)?;
/// let mut resumed: Random = serde_json::from_str(&kept)?;
/// assert_eq!(resumed.unit(), random.unit());
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(from = "Written", into = "Written")]
pub struct Random {
    generator: ChaCha8Rng,
    written: Written,
}

/// What has to be kept of a generator. The stream is a text because JSON readers in other
/// languages round whole numbers beyond 2^53.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    seed: u64,
    stream: String,
    drawn: u64,
}

impl From<Written> for Random {
    fn from(written: Written) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(written.seed);
        generator.set_stream(stream_number(&written.stream));
        generator.set_word_pos(2 * u128::from(written.drawn));
        Self { generator, written }
    }
}

impl From<Random> for Written {
    fn from(random: Random) -> Self {
        random.written
    }
}

/// The stream's name as a number: FNV-1a (G. Fowler, L. C. Noll and K.-P. Vo, 1991).
fn stream_number(name: &str) -> u64 {
    name.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

impl Random {
    /// The beginning of the stream with this name under `seed`; streams of other names are
    /// independent.
    #[must_use]
    pub fn new(seed: u64, stream: &str) -> Self {
        Self::from(Written {
            seed,
            stream: stream.to_owned(),
            drawn: 0,
        })
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.written.drawn += 1;
        self.generator.next_u64()
    }

    /// A number uniform in [0, 1), from the upper 53 bits of a draw.
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// A number uniform strictly between 0 and 1.
    pub fn open_unit(&mut self) -> f64 {
        self.unit() + 0.5 / (1_u64 << 53) as f64
    }

    /// True with this probability.
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

    /// An index with probability in proportion to its weight; `None` if no weight is positive.
    pub fn weighted(&mut self, weights: &[f64]) -> Option<usize> {
        let total: f64 = weights.iter().filter(|weight| **weight > 0.0).sum();
        let mut left = self.unit() * total;
        let mut last = None;
        for (index, weight) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
            last = Some(index);
            if left < *weight {
                break;
            }
            left -= weight;
        }
        last
    }

    /// A random order of `0..count` (R. A. Fisher and F. Yates; R. Durstenfeld, 1964).
    pub fn permutation(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, self.index(last + 1));
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_generator_is_resumed_anywhere() {
        let mut random = Random::new(3, "a");
        for drawn in 0..100 {
            let text = serde_json::to_string(&random).unwrap();
            let mut resumed: Random = serde_json::from_str(&text).unwrap();
            assert_eq!(resumed.bits(), random.clone().bits(), "after {drawn}");
            random.bits();
        }
        assert_ne!(Random::new(3, "a").bits(), Random::new(3, "b").bits());
        assert_ne!(Random::new(3, "a").bits(), Random::new(4, "a").bits());
    }

    #[test]
    fn weights_are_shares() {
        let mut random = Random::new(1, "weights");
        let mut counts = [0; 3];
        for _ in 0..40_000 {
            counts[random.weighted(&[1.0, 0.0, 3.0]).unwrap()] += 1;
        }
        // Five standard deviations of a count with share 1/4 of 40000: 433.
        assert!(
            counts[1] == 0 && (counts[0] - 10_000_i32).abs() < 433,
            "{counts:?}"
        );
        assert_eq!(random.weighted(&[0.0, 0.0]), None);
    }

    #[test]
    fn permutations_hold_each_index_once() {
        let mut order = Random::new(1, "order").permutation(50);
        assert_ne!(order, (0..50).collect::<Vec<_>>());
        order.sort_unstable();
        assert_eq!(order, (0..50).collect::<Vec<_>>());
    }
}
