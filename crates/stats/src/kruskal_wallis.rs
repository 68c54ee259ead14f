//! The Kruskal-Wallis test that several groups of observations come from one distribution.
//!
//! With `N` observations ranked together, `R_i` the rank sum of group `i` of size `n_i`, and `t`
//! the sizes of groups of ties,
//!
//! ```text
//! H  = 12/(N(N+1)) sum R_i^2/n_i - 3(N+1)
//! H' = H / (1 - sum (t^3 - t) / (N^3 - N))          ~ chi-squared, k - 1 degrees of freedom
//! ```
//!
//! The exact p-value is the share of all assignments of the observations to groups of these
//! sizes whose H is at least the one observed. It is computed by a dynamic programme over the
//! distinct values: a state is how many observations and what rank sum each group has so far.
//!
//! Source: W. H. Kruskal and W. A. Wallis, "Use of ranks in one-criterion variance analysis"
//! (1952). Deviation: rank sums are doubled whole numbers and compared exactly, so that rounding
//! never decides whether an assignment counts. Cost: states grow with the product of group sizes;
//! beyond [`MAX_STATES`] the exact test is refused. Guarantee: exact up to rounding of the sum.
//!
//! # Assumes
//! Under the hypothesis observations are independent and of one distribution, whichever it is. The chi-squared p-value
//! takes groups as large.

use crate::counts::StatsError;
use crate::ranks::Ranking;
use crate::special::{chi_squared_sf, hypergeometric_pmf};
use std::collections::BTreeMap;

/// The number of states beyond which the exact distribution is refused.
pub const MAX_STATES: usize = 250_000;

/// The Kruskal-Wallis statistic with its approximate p-values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KruskalWallis {
    /// H with the correction for ties.
    pub statistic: f64,
    /// `P(chi-squared > statistic)`.
    pub p_value: f64,
    /// H without the correction for ties.
    pub uncorrected_statistic: f64,
    /// `P(chi-squared > uncorrected_statistic)`.
    pub uncorrected_p_value: f64,
    /// Number of groups less one.
    pub degrees: usize,
}

/// The test with its chi-squared approximation, for groups given as lists of observations.
/// Empty groups are skipped.
///
/// # Errors
/// [`StatsError::TooFew`] below two groups, [`StatsError::Constant`] when all observations are
/// equal, [`StatsError::OutOfRange`] when one is not a number.
pub fn kruskal_wallis(groups: &[Vec<f64>]) -> Result<KruskalWallis, StatsError> {
    let table = RankedGroups::new(groups)?;
    let n = table.total() as f64;
    let squares: f64 = table
        .rank_sums
        .iter()
        .zip(&table.sizes)
        .map(|(&doubled, &size)| (0.5 * doubled as f64).powi(2) / size as f64)
        .sum();
    let uncorrected = 12.0 / (n * (n + 1.0)) * squares - 3.0 * (n + 1.0);
    let correction = 1.0 - table.ranking.tie_sum() / (n.powi(3) - n);
    let degrees = table.sizes.len() - 1;
    let statistic = uncorrected / correction;
    Ok(KruskalWallis {
        statistic,
        p_value: chi_squared_sf(statistic, degrees as f64),
        uncorrected_statistic: uncorrected,
        uncorrected_p_value: chi_squared_sf(uncorrected, degrees as f64),
        degrees,
    })
}

/// The exact permutation p-value of the test.
///
/// # Errors
/// Those of [`kruskal_wallis`], and [`StatsError::TooManyArrangements`].
pub fn kruskal_wallis_exact(groups: &[Vec<f64>]) -> Result<f64, StatsError> {
    let table = RankedGroups::new(groups)?;
    let observed = table.spread(&table.rank_sums);
    let groups = table.sizes.len();
    let start = State {
        left: table.sizes.clone(),
        rank_sums: vec![0; groups],
    };
    let mut states = BTreeMap::from([(start, 1.0)]);
    for &(rank, size) in &table.ranking.classes {
        let mut next = BTreeMap::new();
        for (state, probability) in &states {
            let draft = Draft {
                state: state.clone(),
                group: 0,
                to_place: size,
            };
            place(draft, rank, *probability, &mut next);
            if next.len() > MAX_STATES {
                return Err(StatsError::TooManyArrangements { limit: MAX_STATES });
            }
        }
        states = next;
    }
    let at_least = states
        .iter()
        .filter(|(state, _)| table.spread(&state.rank_sums) >= observed);
    Ok(at_least
        .map(|(_, probability)| probability)
        .sum::<f64>()
        .min(1.0))
}

/// How many places each group still has, and the doubled rank sum it holds.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct State {
    left: Vec<u64>,
    rank_sums: Vec<u64>,
}

/// A state in which `to_place` observations of one value are still to be given to the groups
/// from `group` on.
struct Draft {
    state: State,
    group: usize,
    to_place: u64,
}

/// Adds to `next` every way of sharing out the rest of a draft, with its probability: group by
/// group, the number taken is hypergeometric.
fn place(draft: Draft, rank: u64, probability: f64, next: &mut BTreeMap<State, f64>) {
    let Draft {
        state,
        group,
        to_place,
    } = draft;
    let places: u64 = state.left[group..].iter().sum();
    let last = group + 1 == state.left.len();
    for taken in 0..=to_place.min(state.left[group]) {
        if to_place - taken > places - state.left[group] {
            continue;
        }
        let share = hypergeometric_pmf(taken, state.left[group], to_place, places);
        let mut state = state.clone();
        state.left[group] -= taken;
        state.rank_sums[group] += taken * rank;
        if last || taken == to_place {
            *next.entry(state).or_insert(0.0) += probability * share;
        } else {
            let draft = Draft {
                state,
                group: group + 1,
                to_place: to_place - taken,
            };
            place(draft, rank, probability * share, next);
        }
    }
}

/// Groups of observations after ranking them together.
struct RankedGroups {
    ranking: Ranking,
    sizes: Vec<u64>,
    /// Doubled rank sums.
    rank_sums: Vec<u64>,
    /// The least common multiple of group sizes over each size, so that `sum R^2 / n` can be
    /// compared in whole numbers.
    weights: Vec<u128>,
}

impl RankedGroups {
    fn new(groups: &[Vec<f64>]) -> Result<Self, StatsError> {
        let groups: Vec<&Vec<f64>> = groups.iter().filter(|group| !group.is_empty()).collect();
        if groups.len() < 2 {
            return Err(StatsError::TooFew {
                what: "groups",
                found: groups.len(),
                needed: 2,
            });
        }
        let all: Vec<f64> = groups
            .iter()
            .flat_map(|group| group.iter().copied())
            .collect();
        let ranking = Ranking::of(&all)?;
        if ranking.classes.len() < 2 {
            return Err(StatsError::Constant {
                what: "observations",
            });
        }
        let mut rest = ranking.doubled.as_slice();
        let mut rank_sums = Vec::new();
        for group in &groups {
            let (own, others) = rest.split_at(group.len());
            rank_sums.push(own.iter().sum());
            rest = others;
        }
        let sizes: Vec<u64> = groups.iter().map(|group| group.len() as u64).collect();
        Ok(Self {
            weights: weights(&sizes),
            ranking,
            sizes,
            rank_sums,
        })
    }

    fn total(&self) -> u64 {
        self.sizes.iter().sum()
    }

    /// A whole number that grows with H: `sum R_i^2 / n_i` over the common denominator.
    fn spread(&self, rank_sums: &[u64]) -> u128 {
        rank_sums
            .iter()
            .zip(&self.weights)
            .map(|(&sum, &weight)| u128::from(sum).pow(2).saturating_mul(weight))
            .fold(0, u128::saturating_add)
    }
}

/// The least common multiple of the sizes over each size.
fn weights(sizes: &[u64]) -> Vec<u128> {
    let sizes = || sizes.iter().map(|&size| u128::from(size));
    let common = sizes().fold(1_u128, |lcm, size| {
        (lcm / gcd(lcm, size)).saturating_mul(size)
    });
    sizes().map(|size| common / size).collect()
}

fn gcd(a: u128, b: u128) -> u128 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: f64, expected: f64) {
        assert!(
            (found / expected - 1.0).abs() < 1e-10,
            "found {found:e}, expected {expected:e}"
        );
    }

    #[test]
    fn reference_values() {
        // scipy 1.16: kruskal(*groups) and brute force over all assignments.
        let groups = [
            vec![9.0],
            vec![10.0, 10.0, 6.0, 9.0],
            vec![8.0, 10.0, 10.0],
            vec![7.0, 9.0],
        ];
        let found = kruskal_wallis(&groups).unwrap();
        close(found.statistic, 1.5000000000000022);
        close(found.p_value, 0.6822703303362121);
        close(found.uncorrected_statistic, 1.3727272727272748);
        close(kruskal_wallis_exact(&groups).unwrap(), 10106.0 / 12600.0);
        let groups = [
            vec![9.0],
            vec![10.0],
            vec![8.0, 7.0, 9.0, 6.0, 10.0],
            vec![10.0, 10.0, 9.0],
        ];
        let found = kruskal_wallis(&groups).unwrap();
        close(found.statistic, 3.8304635761589347);
        close(found.p_value, 0.2803625350960407);
        close(found.uncorrected_statistic, 3.5054545454545405);
        close(kruskal_wallis_exact(&groups).unwrap(), 1426.0 / 5040.0);
        let groups = [
            vec![2.1, 3.0, 3.0, 5.0],
            vec![4.0, 6.0, 7.5],
            vec![1.0, 2.1, 8.0],
        ];
        let found = kruskal_wallis(&groups).unwrap();
        close(found.statistic, 2.2246932515337474);
        close(found.p_value, 0.3287865161994158);
        close(found.uncorrected_statistic, 2.1977272727272776);
        close(kruskal_wallis_exact(&groups).unwrap(), 1528.0 / 4200.0);
    }

    #[test]
    fn two_distinct_groups_of_three_by_hand() {
        // 20 assignments, of which the two extreme ones have this H.
        let groups = [vec![1.0, 2.0, 3.0], vec![4.0, 5.0, 6.0]];
        close(kruskal_wallis_exact(&groups).unwrap(), 0.1);
    }

    #[test]
    fn the_order_and_scale_of_groups_do_not_matter() {
        let groups = [
            vec![9.0, 9.0, 4.0],
            vec![3.0, 9.0],
            vec![1.0, 5.0, 5.0, 2.0],
        ];
        let moved: Vec<Vec<f64>> = groups
            .iter()
            .rev()
            .map(|g| g.iter().rev().map(|x| 7.0 * x - 3.0).collect())
            .collect();
        let (first, second) = (
            kruskal_wallis(&groups).unwrap(),
            kruskal_wallis(&moved).unwrap(),
        );
        close(first.statistic, second.statistic);
        close(
            kruskal_wallis_exact(&groups).unwrap(),
            kruskal_wallis_exact(&moved).unwrap(),
        );
    }

    #[test]
    fn refusals() {
        assert!(kruskal_wallis(&[vec![1.0, 2.0]]).is_err());
        assert!(kruskal_wallis(&[vec![1.0, 2.0], vec![]]).is_err());
        assert!(kruskal_wallis(&[vec![1.0], vec![1.0]]).is_err());
        assert!(kruskal_wallis(&[vec![1.0], vec![f64::NAN]]).is_err());
        let many: Vec<Vec<f64>> = (0..6)
            .map(|g| (0..12).map(|i| f64::from(g * 100 + i)).collect())
            .collect();
        let refused = kruskal_wallis_exact(&many);
        assert_eq!(
            refused,
            Err(StatsError::TooManyArrangements { limit: MAX_STATES })
        );
    }
}
