//! What all current evidence on a requirement supports at once.
//!
//! # Definition
//! The common bound is the smallest one-sided lower limit of all current pieces whose numbers are over the same runs (for a
//! requirement of "at most": the largest upper limit), each at the level `1 - alpha`. The limits are those of the tests by which
//! verdicts are made (`limits`), so that one piece has one limit at one level. The bound is above the rate of some
//! piece only if it is above the smallest of the rates, and then the limit of the piece with that rate
//! is wrong: so *all rates are at least the bound* holds with confidence `1 - alpha` whatever the number
//! of pieces and their dependence, without a correction for being several (an intersection-union test;
//! R. L. Berger, "Multiparameter hypothesis testing and acceptance sampling", 1982).
//!
//! How often it holds, in percent of 1000 seeded studies (`tests/integration/calibration.rs`, `table_of_common_bounds`; standard
//! error at most 0.7), beside limits that hold all at once (Sidak's), which is more than the statement says; in brackets
//! the mean of the bound. 150 trials of their own or ten people with ten each.
//!
//! | rates | of them alike by person (10 x 10, correlation 0.3) | the bound | all at once |
//! |---|---|---|---|
//! | 0.9, 0.9 | none | 99.8 (0.834) | 100.0 (0.824) |
//! | 0.85, 0.95 | none | 94.4 (0.793) | 98.1 (0.783) |
//! | 0.9, 0.9, 0.9 | none | 100.0 (0.825) | 100.0 (0.809) |
//! | 0.85, 0.95, 0.95 | none | 96.3 (0.792) | 99.0 (0.776) |
//! | 0.9, 0.9, 0.9, 0.9 | none | 100.0 (0.822) | 100.0 (0.802) |
//! | 0.85, 0.95, 0.95, 0.95 | none | 94.8 (0.795) | 99.5 (0.775) |
//! | 0.9, 0.9 | the first | 100.0 (0.728) | 100.0 (0.698) |
//! | 0.85, 0.95 | the first | 96.2 (0.673) | 97.4 (0.641) |
//! | 0.9, 0.9, 0.9 | the first | 100.0 (0.728) | 100.0 (0.682) |
//! | 0.85, 0.95, 0.95 | the first | 97.1 (0.673) | 98.4 (0.624) |
//! | 0.9, 0.9, 0.9, 0.9 | the first | 100.0 (0.724) | 100.0 (0.668) |
//! | 0.85, 0.95, 0.95, 0.95 | the first | 95.7 (0.675) | 97.9 (0.614) |
//! | 0.9, 0.9 | all | 99.7 (0.681) | 99.9 (0.647) |
//! | 0.85, 0.95 | all | 99.4 (0.661) | 100.0 (0.627) |
//! | 0.9, 0.9, 0.9 | all | 100.0 (0.651) | 100.0 (0.596) |
//! | 0.85, 0.95, 0.95 | all | 100.0 (0.648) | 100.0 (0.593) |
//! | 0.9, 0.9, 0.9, 0.9 | all | 100.0 (0.636) | 100.0 (0.566) |
//! | 0.85, 0.95, 0.95, 0.95 | all | 100.0 (0.649) | 100.0 (0.579) |
//!
//! # Assumes
//! The limit of each piece holds by itself. Nothing of how many pieces there are or how they depend on each other.
//!
//! # Guarantee
//! The bound holds with confidence `1 - alpha` where the limit of each piece does, by the argument above; the table shows what is
//! left of it with clustered counts.

use super::limits::limits;
use super::stand::ClaimLevels;
use super::words::{percent_down, percent_up};
use super::{Piece, is_trial};
use crate::compare::words::{list, percent};
use crate::{Direction, Threshold};
use stats::Confidence;

/// The pieces whose numbers are over the same runs as those of the system, or, without such, as those of the first that counts:
/// numbers over other runs are of another rate, and support nothing together with these.
pub(super) fn over_the_same_runs<'p, 'a>(pieces: &'p [Piece<'a>]) -> Vec<&'p Piece<'a>> {
    let mut trials = pieces.iter().filter(|piece| is_trial(piece.evidence));
    let mut counted = pieces.iter().filter(|piece| piece.counted.is_some());
    let reference = trials.next().or_else(|| counted.next());
    let Some(reference) = reference.or(pieces.first()) else {
        return Vec::new();
    };
    let is_same = |piece: &&Piece<'_>| piece.finding.is_over_the_same_runs(reference.finding);
    pieces.iter().filter(is_same).collect()
}

/// What all pieces support at once: "at least" or "at most" this, as the requirement asks.
pub(super) fn common_bound(
    pieces: &[&Piece<'_>],
    direction: Direction,
    level: Confidence,
) -> Option<f64> {
    // The limits of a rate do not depend on the value that is asked.
    let asked = Threshold {
        direction,
        value: 0.5,
    };
    let of = |piece: &&Piece<'_>| limits(&piece.belief, asked, ClaimLevels::both(level));
    let all = pieces.iter().map(of);
    match direction {
        Direction::AtLeast => all.map(|limits| limits.low).reduce(f64::min),
        Direction::AtMost => all.map(|limits| limits.high).reduce(f64::max),
    }
}

/// The common bound in a sentence that stays true when its number is rounded.
pub(super) fn common_statement(
    ids: &[String],
    direction: Direction,
    bound: f64,
    confidence: Confidence,
) -> String {
    let (who, why) = match ids {
        [only] => (
            format!("{only} supports"),
            "at the whole level, which the verdict divides among all that is judged",
        ),
        [_, _] => (
            format!("{} both support", list(ids)),
            "uncorrected for several pieces: it is the weakest of their limits at the whole level",
        ),
        _ => (
            format!("{} all support", list(ids)),
            "uncorrected for several pieces: it is the weakest of their limits at the whole level",
        ),
    };
    let level = percent(confidence.level());
    let what = match direction {
        Direction::AtLeast => format!("rate >= {}", percent_down(bound)),
        Direction::AtMost => format!("rate <= {}", percent_up(bound)),
    };
    format!("{who} {what} with {level} confidence ({why}).")
}
