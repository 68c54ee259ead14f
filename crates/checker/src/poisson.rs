//! Probabilities of the Poisson distribution, with small relative error over a very wide range.
//!
//! *Definition.* `w_k = e^-m m^k / k!` for the mean `m`. *Method.* Unnormalised from the mode `floor(m)` outwards
//! by `w_(k-1) = w_k k / m` and `w_(k+1) = w_k m / (k + 1)` as far as numbers of floating point reach, then
//! divided by their sum: no exponential, no subtraction.
//!
//! Source: Fox and Glynn 1988, "Computing Poisson probabilities". Deviation: the range is not cut to where the
//! sum is nearly 1, but to where weights fall below 1e-280 of the greatest, so that tiny probabilities keep
//! their digits. Guarantee: the relative error of each weight is at most [`Weights::error`]; the mass left out
//! is below 1e-270. Cost: about 36 times the square root of the mean on each side.

use crate::rounding::UNIT;

/// Weights below this share of the greatest are left out.
const SMALLEST: f64 = 1e-280;

/// The weights of `first..`.
#[derive(Debug, Clone)]
pub(crate) struct Weights {
    /// The number to which the first weight belongs.
    pub first: u64,
    pub weight: Vec<f64>,
    /// A bound of the relative error of each.
    pub error: f64,
}

impl Weights {
    /// The weights for a mean that is positive.
    pub fn new(mean: f64) -> Self {
        let mode = mean.floor();
        let (mut below, mut above) = (Vec::new(), vec![1.0]);
        let (mut k, mut weight) = (mode, 1.0);
        while k >= 1.0 && weight > SMALLEST {
            weight *= k / mean;
            k -= 1.0;
            below.push(weight);
        }
        let (mut k, mut weight) = (mode, 1.0);
        while weight > SMALLEST {
            k += 1.0;
            weight *= mean / k;
            above.push(weight);
        }
        below.reverse();
        let first = mode as u64 - below.len() as u64;
        below.append(&mut above);
        let sum: f64 = sum_from_ends(&below);
        let terms = below.len() as f64;
        below.iter_mut().for_each(|weight| *weight /= sum);
        Self {
            first,
            weight: below,
            error: (4.0 * terms + 4.0) * UNIT,
        }
    }

    /// The weight of `k`.
    pub fn of(&self, k: u64) -> f64 {
        let place = k.checked_sub(self.first).map(|place| place as usize);
        place
            .and_then(|place| self.weight.get(place))
            .copied()
            .unwrap_or(0.0)
    }

    /// The last number that has a weight.
    pub fn last(&self) -> u64 {
        self.first + self.weight.len() as u64 - 1
    }

    /// The sums of all weights of numbers greater than `k`, for `k` in `0..=last`.
    pub fn tails(&self) -> Vec<f64> {
        let mut tails = vec![0.0; self.last() as usize + 1];
        let mut sum = 0.0;
        for k in (0..tails.len()).rev() {
            tails[k] = sum;
            sum += self.of(k as u64);
        }
        tails
    }
}

/// The small terms first.
fn sum_from_ends(values: &[f64]) -> f64 {
    let middle = values.iter().position(|value| *value == 1.0).unwrap_or(0);
    let (left, right) = values.split_at(middle);
    left.iter().sum::<f64>() + right.iter().rev().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `ln k!` by adding logarithms.
    fn ln_factorial(k: u64) -> f64 {
        (2..=k).map(|i| (i as f64).ln()).sum()
    }

    #[test]
    fn weights_are_those_of_the_definition() {
        for mean in [1e-9, 0.3, 1.0, 7.5, 400.0, 12_345.6] {
            let weights = Weights::new(mean);
            let sum: f64 = weights.weight.iter().sum();
            assert!((sum - 1.0).abs() < 1e-12, "{mean} {sum}");
            for k in [0, 1, 5, mean as u64, (1.1 * mean) as u64] {
                let expected = (k as f64 * mean.ln() - mean - ln_factorial(k)).exp();
                if expected > 1e-250 {
                    let off = (weights.of(k) / expected - 1.0).abs();
                    assert!(off < 1e-8, "{mean} {k} {off}");
                }
            }
        }
        assert!(Weights::new(100.0).error < 1e-12);
    }

    #[test]
    fn tails_are_sums_of_weights() {
        let weights = Weights::new(20.0);
        let tails = weights.tails();
        assert!((tails[0] - (1.0 - weights.of(0))).abs() < 1e-14);
        assert!((tails[20] - 0.4409).abs() < 1e-4);
        assert!(tails[200] > 0.0 && tails[200] < 1e-100);
    }
}
