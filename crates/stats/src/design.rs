//! Evenly spread points of the unit cube, for pushing distributions through a model.
//!
//! Coordinate `j` of point `i` is the radical inverse of `i` in the `j`-th prime base, with every
//! digit sent through a random permutation of its own:
//!
//! ```text
//! i = sum_k d_k b^k   ->   u = sum_k pi_k(d_k) b^(-k-1)
//! ```
//!
//! Source: J. H. Halton (1960); A. B. Owen, "A randomized Halton algorithm in R" (2017).
//! Deviations: permutations come from a SplitMix64 generator (G. L. Steele, D. Lea and
//! C. H. Flood, 2014) seeded per base and digit, so that a point depends on nothing but the seed
//! and its index; half a unit of the last digit is added, which keeps 0 and 1 out. Cost: about
//! 53/log2(b) steps a coordinate. Guarantee: each point is uniform over seeds, so that means are
//! unbiased; in a few dimensions their error falls nearly as 1/n instead of 1/sqrt(n).
//!
//! # Assumes
//! Inputs of [`posterior_design`] are independent of each other. The faster error takes a function of bounded variation.

use crate::posterior::BetaPosterior;

/// `points` points in `dimensions` coordinates, strictly between 0 and 1, as rows; the first
/// points of a longer design are those of a shorter one.
#[must_use]
pub fn design(points: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    design_from(0, points, dimensions, seed)
}

/// The same sequence from the point at `first` on, for designs that are continued.
#[must_use]
pub fn design_from(first: u64, points: usize, dimensions: usize, seed: u64) -> Vec<Vec<f64>> {
    let axes: Vec<Axis> = primes(dimensions)
        .into_iter()
        .map(|base| Axis::new(base, seed))
        .collect();
    (first..first + points as u64)
        .map(|index| axes.iter().map(|axis| axis.coordinate(index)).collect())
        .collect()
}

/// `points` joint draws of independent posteriors, one column for each: the quantiles at the
/// coordinates of [`design`].
#[must_use]
pub fn posterior_design(posteriors: &[BetaPosterior], points: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut rows = design(points, posteriors.len(), seed);
    for row in &mut rows {
        for (value, posterior) in row.iter_mut().zip(posteriors) {
            *value = posterior.quantile(*value);
        }
    }
    rows
}

/// One coordinate: a prime base and a permutation for each digit.
struct Axis {
    base: u64,
    permutations: Vec<Vec<u64>>,
}

impl Axis {
    fn new(base: u64, seed: u64) -> Self {
        let digits = (53.0 / (base as f64).log2()).ceil() as u64;
        let permutation = |digit: u64| {
            let mut generator = SplitMix64(seed ^ SplitMix64(base << 32 | digit).next());
            shuffled(base, &mut generator)
        };
        Self {
            base,
            permutations: (0..digits).map(permutation).collect(),
        }
    }

    fn coordinate(&self, mut index: u64) -> f64 {
        let inverse = 1.0 / self.base as f64;
        let mut scale = inverse;
        let mut value = 0.0;
        for permutation in &self.permutations {
            value += scale * permutation[(index % self.base) as usize] as f64;
            index /= self.base;
            scale *= inverse;
        }
        (value + 0.5 * scale).clamp(f64::EPSILON / 4.0, 1.0 - f64::EPSILON / 2.0)
    }
}

/// `0..count` in random order (Fisher and Yates).
fn shuffled(count: u64, generator: &mut SplitMix64) -> Vec<u64> {
    let mut values: Vec<u64> = (0..count).collect();
    for last in (1..values.len()).rev() {
        // The high half of a 128-bit product: the bias is below count / 2^64.
        let chosen = (u128::from(generator.next()) * (last as u128 + 1)) >> 64;
        values.swap(last, chosen as usize);
    }
    values
}

/// The first primes, by trial division.
fn primes(count: usize) -> Vec<u64> {
    let mut found: Vec<u64> = Vec::with_capacity(count);
    let mut candidate = 2;
    while found.len() < count {
        if found
            .iter()
            .take_while(|p| *p * *p <= candidate)
            .all(|p| candidate % p != 0)
        {
            found.push(candidate);
        }
        candidate += 1;
    }
    found
}

/// A 64-bit generator whose state is a counter.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::counts::Sample;

    #[test]
    fn split_mix_gives_its_published_numbers() {
        // The first outputs for seed 1234567, from the authors' reference code.
        let mut generator = SplitMix64(1_234_567);
        assert_eq!(generator.next(), 6_457_827_717_110_365_317);
        assert_eq!(generator.next(), 3_203_168_211_198_807_973);
    }

    #[test]
    fn points_are_inside_distinct_and_a_prefix_of_longer_designs() {
        let short = design(100, 12, 5);
        let long = design(1000, 12, 5);
        assert_eq!(short[..], long[..100]);
        assert!(long.iter().flatten().all(|u| 0.0 < *u && *u < 1.0));
        assert_ne!(design(10, 2, 5), design(10, 2, 6));
        for axis in 0..12 {
            let mut column: Vec<f64> = long.iter().map(|row| row[axis]).collect();
            column.sort_by(f64::total_cmp);
            assert!(column.windows(2).all(|pair| pair[0] < pair[1]));
        }
    }

    #[test]
    fn every_elementary_interval_holds_one_point() {
        for (axis, base, power) in [(0, 2, 10), (1, 3, 6), (2, 5, 4)] {
            let count = u64::pow(base, power) as usize;
            let mut seen = vec![0; count];
            for row in design(count, 3, 99) {
                seen[(row[axis] * count as f64) as usize] += 1;
            }
            assert!(seen.iter().all(|&times| times == 1), "base {base}");
        }
    }

    #[test]
    fn a_product_of_means_comes_out_far_better_than_by_chance() {
        let posteriors: Vec<BetaPosterior> = [(7, 98), (3, 98), (2, 100), (1, 500)]
            .map(|(successes, trials)| BetaPosterior::jeffreys(Sample { successes, trials }))
            .to_vec();
        let exact: f64 = posteriors.iter().map(|p| 1.0 - p.mean()).product();
        let rows = posterior_design(&posteriors, 4096, 1);
        let product = |row: &Vec<f64>| row.iter().map(|p| 1.0 - p).product::<f64>();
        let mean = rows.iter().map(product).sum::<f64>() / rows.len() as f64;
        // Random draws would be off by about 0.033 / 64 = 5e-4.
        assert!((mean - exact).abs() < 2e-5, "{}", mean - exact);
    }
}
