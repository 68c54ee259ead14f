use super::*;
use crate::answer::Options;
use crate::graph::qualitative;
use proptest::prelude::*;

const NEVER_ELIMINATE: Effort = Effort {
    first_budget: 0,
    equations: false,
    first_rounds: 100_000,
    second_budget: 0,
    last_rounds: 1_000_000,
};

/// Haddad and Monmege's chain: from the middle, up with probability `p` and back to the middle at each
/// step with 1/2, down likewise; the probability of the upper end is `p`.
fn haddad_monmege(n: usize, p: f64) -> Csr<f64> {
    let (upper, lower, states) = (|k: usize| k, |k: usize| n + k, 2 * n + 1);
    let mut rows = vec![Vec::new(); states];
    rows[0] = vec![(upper(1) as u32, p), (lower(1) as u32, 1.0 - p)];
    for k in 1..n {
        rows[upper(k)] = vec![(0, 0.5), (upper(k + 1) as u32, 0.5)];
        rows[lower(k)] = vec![(0, 0.5), (lower(k + 1) as u32, 0.5)];
    }
    rows[upper(n)] = vec![(upper(n) as u32, 1.0)];
    rows[lower(n)] = vec![(lower(n) as u32, 1.0)];
    Csr::from_rows(rows)
}

#[test]
fn a_chain_that_defeats_iteration_is_solved_at_once() {
    let options = Options::default();
    let context = Context::new(&options, 0.0);
    for n in [20, 300] {
        let matrix = haddad_monmege(n, 0.7);
        let target: Vec<bool> = (0..2 * n + 1).map(|state| state == n).collect();
        let sets = qualitative(&matrix, &vec![true; 2 * n + 1], &target);
        let (values, rounds) = reachability(&matrix, &sets, &context).unwrap();
        assert!(values[0].value.contains(0.7), "{:?}", values[0]);
        assert!(values[0].complement.contains(0.3), "{:?}", values[0]);
        assert!(values[0].value.relative_width() < 1e-6, "{:?}", values[0]);
        assert_eq!(rounds, 0);
    }
}

#[test]
fn tiny_probabilities_keep_their_digits() {
    let options = Options::default();
    let context = Context::new(&options, 0.0);
    // Forty times one in a thousand, each state waiting almost surely.
    let mut rows: Vec<Vec<(u32, f64)>> = (0..40)
        .map(|k| vec![(k, 0.5), (k + 1, 0.0005), (41, 0.4995)])
        .collect();
    rows.extend([vec![(40, 1.0)], vec![(41, 1.0)]]);
    let matrix = Csr::from_rows(rows);
    let target: Vec<bool> = (0..42).map(|state| state == 40).collect();
    let sets = qualitative(&matrix, &[true; 42], &target);
    let (values, _) = reachability(&matrix, &sets, &context).unwrap();
    assert!(
        (values[0].value.middle() / 1e-120 - 1.0).abs() < 1e-11,
        "{:?}",
        values[0]
    );
    assert!(values[0].value.relative_width() < 1e-11);
    assert!(values[0].complement.contains(1.0));
}

proptest! {
    #[test]
    fn iteration_and_elimination_have_bounds_in_common(
        weights in prop::collection::vec(prop::collection::vec(0u32..5, 8), 8),
        right in prop::collection::vec(prop::bool::weighted(0.2), 8),
    ) {
        let row = |(state, weights): (usize, &Vec<u32>)| {
            let total: u32 = weights.iter().sum();
            let entry = |(target, weight): (usize, &u32)| {
                (target as u32, f64::from(*weight) / f64::from(total))
            };
            match total {
                0 => vec![(state as u32, 1.0)],
                _ => weights.iter().enumerate().filter(|(_, w)| **w > 0).map(entry).collect(),
            }
        };
        let matrix = Csr::from_rows(weights.iter().enumerate().map(row).collect());
        let sets = qualitative(&matrix, &[true; 8], &right);
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let (direct, _) = reachability(&matrix, &sets, &context).unwrap();
        let (iterated, _) = reachability_with(&matrix, &sets, &context, NEVER_ELIMINATE).unwrap();
        for (a, b) in direct.iter().zip(&iterated) {
            for (a, b) in [(a.value, b.value), (a.complement, b.complement)] {
                prop_assert!(b.low <= a.middle() && a.middle() <= b.high, "{:?} {:?}", a, b);
                prop_assert!(b.relative_width() <= 1e-6, "{:?}", b);
            }
        }
    }
}
