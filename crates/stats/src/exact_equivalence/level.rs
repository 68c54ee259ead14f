//! The probability of a region at given rates, with its derivatives along the boundary.
//!
//! # Assumes
//! Both counts are binomial and independent of each other.

use super::region::Region;
use crate::special::binomial_pmf;

/// Densities that are left out, beside the largest.
const NEGLIGIBLE: f64 = 1e-18;

/// A probability and its first two derivatives when both rates grow alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expansion {
    pub value: f64,
    pub slope: f64,
    pub curvature: f64,
}

/// Binomial densities of all counts that are not negligible.
pub(super) struct Band {
    pub from: u64,
    pub densities: Vec<f64>,
}

impl Band {
    pub fn new(trials: u64, rate: f64) -> Self {
        if rate <= 0.0 || rate >= 1.0 {
            let from = if rate <= 0.0 { 0 } else { trials };
            let densities = vec![1.0];
            return Self { from, densities };
        }
        let odds = rate / (1.0 - rate);
        let mode = (((trials + 1) as f64 * rate) as u64).min(trials);
        let start = binomial_pmf(mode, trials, rate);
        let mut below = Vec::new();
        let (mut k, mut density) = (mode, start);
        while k > 0 && density > NEGLIGIBLE * start {
            density *= k as f64 / ((trials - k + 1) as f64 * odds);
            k -= 1;
            below.push(density);
        }
        below.reverse();
        below.push(start);
        let from = k;
        let (mut k, mut density) = (mode, start);
        while k < trials && density > NEGLIGIBLE * start {
            density *= (trials - k) as f64 / (k + 1) as f64 * odds;
            k += 1;
            below.push(density);
        }
        Self {
            from,
            densities: below,
        }
    }
}

/// The probability of the region.
pub(super) fn probability(region: &Region, (n, first): (u64, f64), (m, second): (u64, f64)) -> f64 {
    let (xs, ys) = (Band::new(n, first), Band::new(m, second));
    let cumulated = cumulated(&xs.densities);
    let mut sum = 0.0;
    for (density, most) in rows(region, &ys) {
        sum += density * at_most(most, xs.from, &cumulated);
    }
    sum.min(1.0)
}

/// The same with derivatives, at rates strictly between 0 and 1.
pub(super) fn expansion(
    region: &Region,
    (n, first): (u64, f64),
    (m, second): (u64, f64),
) -> Expansion {
    let (xs, ys) = (Band::new(n, first), Band::new(m, second));
    let cumulated = cumulated(&xs.densities);
    let (p, q) = (first, 1.0 - first);
    let of_second = second * (1.0 - second);
    let mut found = Expansion {
        value: 0.0,
        slope: 0.0,
        curvature: 0.0,
    };
    let mut y = ys.from as f64;
    for (density, most) in rows(region, &ys) {
        let below = at_most(most, xs.from, &cumulated);
        // d/dp P(X <= c) = -(n - c) P(X = c) / q, and its derivative.
        let place = most - xs.from as i64;
        let at = match usize::try_from(place) {
            Ok(place) => xs.densities.get(place).copied().unwrap_or(0.0),
            Err(_) => 0.0,
        };
        let c = most as f64;
        let below_1 = -(n as f64 - c) * at / q;
        let below_2 = below_1 / q * ((c - n as f64 * p) / p + 1.0);
        // The density's derivatives over the density.
        let off = y - m as f64 * second;
        let score = off / of_second;
        let score_2 = (off * off - (1.0 - 2.0 * second) * off - m as f64 * of_second)
            / (of_second * of_second);
        found.value += density * below;
        found.slope += density * (score * below + below_1);
        found.curvature += density * (score_2 * below + 2.0 * score * below_1 + below_2);
        y += 1.0;
    }
    found.value = found.value.min(1.0);
    found
}

/// The densities of the second sample, each with the region's most successes of the first.
fn rows<'a>(region: &'a Region, ys: &'a Band) -> impl Iterator<Item = (f64, i64)> + 'a {
    let last = region.most.len() as i64 - 1;
    let start = ys.from as i64 - region.from as i64;
    let places = (start..).map(move |place| place.clamp(0, last) as usize);
    let most = places.map(|place| region.most[place]);
    ys.densities.iter().copied().zip(most)
}

fn cumulated(densities: &[f64]) -> Vec<f64> {
    let sums = densities.iter().scan(0.0, |sum, density| {
        *sum += density;
        Some(*sum)
    });
    sums.collect()
}

fn at_most(most: i64, from: u64, cumulated: &[f64]) -> f64 {
    let place = most - from as i64;
    match usize::try_from(place) {
        Ok(place) => cumulated.get(place).copied().unwrap_or(1.0),
        Err(_) => 0.0,
    }
}
