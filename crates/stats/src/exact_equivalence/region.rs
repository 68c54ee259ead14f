//! The outcomes that speak at least as much against "the first rate exceeds the second by the margin or more".
//!
//! # Assumes
//! The order grows with the first count and falls with the second, as the module above proves.

use super::Counts;
use crate::score::restricted_rate;
use crate::special::deviance;
use std::cmp::Ordering;

/// Of each number of successes of the second sample the most of the first that belong.
pub(super) struct Region {
    /// The first `y` for which there is an entry.
    pub from: u64,
    /// `c(y)`: all `x <= c(y)` belong; -1 for none. Never falls.
    pub most: Vec<i64>,
}

impl Region {
    /// The region of outcomes whose order is at most that of the counts, for `y` in a range.
    pub fn new(counts: &Counts, (from, to): (u64, u64)) -> Self {
        let limit = order(counts, counts.x, counts.y);
        // Outcomes that are equal but for rounding belong together.
        let limit = limit + 1e-9 * limit.abs() + 1e-11;
        let belongs = |x: i64, y: u64| order(counts, x as u64, y) <= limit;
        let end = counts.n as i64 + 1;
        let mut most = Vec::with_capacity((to - from + 1) as usize);
        let (mut x, mut step) = (-1_i64, end);
        for y in from..=to {
            let before = x;
            x = last_that_belongs(x, end, step, |x| belongs(x, y));
            step = (x - before).max(1);
            most.push(x);
        }
        Self { from, most }
    }
}

/// The last number before `end` that belongs, when `low` does or is -1; by galloping in steps and halving.
fn last_that_belongs(mut low: i64, end: i64, step: i64, belongs: impl Fn(i64) -> bool) -> i64 {
    let mut step = step;
    let mut high = end;
    while low + step < high {
        if belongs(low + step) {
            low += step;
            step *= 2;
        } else {
            high = low + step;
            break;
        }
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        match belongs(middle) {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

/// The signed likelihood ratio of the first rate exceeding the second by exactly the margin.
fn order(counts: &Counts, x: u64, y: u64) -> f64 {
    let (x, y) = (x as f64, y as f64);
    let (n, m) = (counts.n as f64, counts.m as f64);
    let q1 = most_likely(counts, x, y);
    let q2 = (q1 - counts.margin).max(0.0);
    let ratio = 2.0
        * (deviance(x, n * q1)
            + deviance(n - x, n * (1.0 - q1))
            + deviance(y, m * q2)
            + deviance(m - y, m * (1.0 - q2)));
    let excess = x / n - y / m - counts.margin;
    match excess.partial_cmp(&0.0) {
        Some(Ordering::Less) => -ratio,
        Some(Ordering::Greater) => ratio,
        _ => 0.0,
    }
}

/// The most likely first rate where it exceeds the second by the margin: the cubic's root and a step of Newton's.
fn most_likely(counts: &Counts, x: f64, y: f64) -> f64 {
    let (n, m) = (counts.n as f64, counts.m as f64);
    let q1 = restricted_rate((x, n), (y, m), counts.margin);
    let q2 = q1 - counts.margin;
    if q1 <= 0.0 || q1 >= 1.0 || q2 <= 0.0 {
        return q1;
    }
    let slope = x / q1 - (n - x) / (1.0 - q1) + y / q2 - (m - y) / (1.0 - q2);
    let curvature = x / (q1 * q1)
        + (n - x) / ((1.0 - q1) * (1.0 - q1))
        + y / (q2 * q2)
        + (m - y) / ((1.0 - q2) * (1.0 - q2));
    let better = q1 + slope / curvature;
    match better > counts.margin && better < 1.0 {
        true => better,
        false => q1,
    }
}
