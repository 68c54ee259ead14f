//! The level at which each requirement is judged, so that the error rate holds for the study.
//!
//! # Definition
//! There are two claims: that a threshold is met, and that it is missed. The tests of one claim over all requirements
//! are a family, and Holm's step-down procedure is applied to it: while any test of the remaining units has a p-value
//! of at most `alpha` divided by the number of units that still have a test open, the tests that do are taken as shown.
//! A *unit* is a quantity with the side of its thresholds. Thresholds of one unit are nested (who shows 95 % shows
//! 60 %), so several of them count once. Tests that cannot err (of a value that is known, and of certainty, which one
//! failure denies and no count shows) are in no family.
//!
//! # Source
//! S. Holm, "A simple sequentially rejective multiple test procedure" (1979); for nested hypotheses, R. Marcus,
//! E. Peritz and K. R. Gabriel, "On closed testing procedures" (1976).
//!
//! # Assumes
//! Each p-value is at most `a` with a probability of at most `a` where its hypothesis is true. Nothing of how tests depend
//! on each other. All thresholds of a unit are of one quantity, and no requirement was left out for its outcome.
//!
//! # Guarantee
//! The probability that any test of a claim is wrong is at most `alpha`, whatever the dependence of the tests. Before
//! the first wrong one, each unit with a true hypothesis still has a test open, so the divisor is at least their
//! number; and in one unit the first wrong one is that of the true hypothesis nearest to the rate. The two claims are
//! two families: no more than one of them can be wrong of one requirement, but both may be wrong of two.

use crate::ErrorFamily;

/// One test of a claim: of which unit, and its p-value; `None` for one that cannot err.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Test {
    pub unit: usize,
    pub p: Option<f64>,
}

/// By what `alpha` is divided for each test.
pub(super) fn divisors(tests: &[Test], alpha: f64, family: ErrorFamily) -> Vec<usize> {
    let mut divisors = vec![1; tests.len()];
    if family == ErrorFamily::Requirement {
        return divisors;
    }
    let mut open: Vec<usize> = (0..tests.len()).filter(|&i| tests[i].p.is_some()).collect();
    loop {
        let count = units(tests, &open);
        for &index in &open {
            divisors[index] = count;
        }
        let level = alpha / count.max(1) as f64;
        let before = open.len();
        open.retain(|&index| tests[index].p.is_some_and(|p| p > level));
        if open.len() == before {
            return divisors;
        }
    }
}

/// How many units have one of these tests.
fn units(tests: &[Test], open: &[usize]) -> usize {
    let mut units: Vec<usize> = open.iter().map(|&index| tests[index].unit).collect();
    units.sort_unstable();
    units.dedup();
    units.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(tests: &[(usize, Option<f64>)]) -> Vec<usize> {
        let tests: Vec<Test> = tests.iter().map(|&(unit, p)| Test { unit, p }).collect();
        divisors(&tests, 0.05, ErrorFamily::Study)
    }

    #[test]
    fn the_divisor_falls_as_claims_are_shown() {
        let three = [(0, Some(0.01)), (1, Some(0.02)), (2, Some(0.04))];
        assert_eq!(of(&three), [3, 2, 1]);
        let none = [(0, Some(0.02)), (1, Some(0.02)), (2, Some(0.04))];
        assert_eq!(of(&none), [3, 3, 3]);
    }

    #[test]
    fn thresholds_of_one_quantity_count_once_and_what_cannot_err_not_at_all() {
        assert_eq!(of(&[(0, Some(0.5)), (0, Some(0.04)), (1, None)]), [1, 1, 1]);
        assert_eq!(
            of(&[(0, Some(0.5)), (0, Some(0.02)), (1, Some(0.9))]),
            [2, 2, 2]
        );
        let each = [
            Test {
                unit: 0,
                p: Some(0.5),
            },
            Test {
                unit: 1,
                p: Some(0.5),
            },
        ];
        assert_eq!(divisors(&each, 0.05, ErrorFamily::Requirement), [1, 1]);
    }
}
