//! A small version of the tables of `ERROR_RATES.md`, at fixed seeds: no rate exceeds what is promised of it by more than
//! four standard deviations, no sum exceeds it at all, and what is worked out beside `compare` is what `compare` says.

#[path = "../../examples/error_rates/main.rs"]
mod error_rates;

use error_rates::carried;
use error_rates::cells::{self, RELATIONS, largest};
use error_rates::looks::{self, Going, Trials};
use error_rates::pairs::{self, History, Sides, Sought, ledger};
use error_rates::people;
use error_rates::several::{self, concluded};
use error_rates::support::{Uniform, at_least, piece, requirement};
use error_rates::table::{Rate, Row};
use evidence::*;
use stats::Sample;

fn keep_their_promises(rows: &[Row]) {
    assert!(rows.iter().any(|row| row.most.is_some()));
    for row in rows {
        assert!(!row.breaks_its_promise(), "{row:?}");
    }
}

#[test]
fn several_requirements_err_no_more_often_than_one() {
    keep_their_promises(&several::rows(60));
}

#[test]
fn models_that_carry_over_err_as_rarely_as_promised() {
    for (runs, off, requirements) in [
        (None, [0.1, 0.19], 1),
        (None, [0.0, 0.0999], 1),
        (Some(100), [-0.1, -0.19], 1),
        // By agreement on six quantities, of which chance makes one agree in a quarter of all studies.
        (None, [0.1, 0.19], 6),
    ] {
        let case = carried::Case {
            runs,
            trials: 50,
            experiments: 1,
            requirements,
            own_anchors: requirements > 1,
            off,
            looks: 1,
        };
        let verdict = match off[1] > 0.0 {
            true => Verdict::Satisfied,
            false => Verdict::Violated,
        };
        let found = carried::share(&case, verdict, 100);
        let row = Row::counted("", "", found, Some(0.05));
        assert!(!row.breaks_its_promise(), "{case:?} {found:?}");
    }
    // What the declaration does not cover is seen, so that the test can fail.
    let undeclared = carried::Case {
        runs: None,
        trials: 200,
        experiments: 1,
        requirements: 1,
        own_anchors: false,
        off: [0.0, 0.19],
        looks: 1,
    };
    let (said, of) = carried::share(&undeclared, Verdict::Satisfied, 40);
    assert!(2 * said > of, "{said} of {of}");
}

#[test]
fn attempts_of_people_err_as_rarely_as_promised() {
    let case = people::Case {
        people: 10,
        each: 10,
        correlation: 0.3,
        rate: 0.9,
        requirements: 1,
    };
    let studies = 200;
    let found = people::wrong(&case, studies);
    let most = 0.05 + 4.0 * (0.05_f64 * 0.95 / studies as f64).sqrt();
    let people::Wrong {
        conflicts,
        violated,
        satisfied,
        agreements,
        misses,
    } = found;
    for wrong in [conflicts, violated, satisfied, agreements, misses] {
        assert!(wrong as f64 / studies as f64 <= most, "{found:?}");
    }
}

/// Adding trials until a verdict comes out, with the looks recorded; and what it would be without them.
#[test]
fn verdicts_over_looks_err_as_rarely_as_promised() {
    for (going, trials) in [
        (Going::Double, Trials::Independent),
        (Going::BySeen, Trials::Independent),
        (Going::Double, Trials::People(0.3)),
    ] {
        let case = looks::Case {
            going,
            trials,
            requirements: 1,
            rate: 0.9,
            threshold: 0.9,
            first: 60,
        };
        for verdict in [Verdict::Satisfied, Verdict::Violated] {
            let found = looks::share(&case, verdict, 100);
            let row = Row::counted("", "", found, Some(0.05));
            assert!(!row.breaks_its_promise(), "{case:?} {verdict:?} {found:?}");
        }
    }
}

#[test]
fn pairs_over_looks_err_as_rarely_as_promised() {
    for (going, is_model) in [(Going::Double, false), (Going::Often, true)] {
        let equal = pairs::Case {
            going,
            rates: [0.88, 0.88],
            is_model,
            one_side: false,
            margin: 0.1,
            first: 60,
        };
        let apart = pairs::Case {
            rates: [0.85, 0.95],
            ..equal
        };
        for (case, sought) in [(equal, Sought::Difference), (apart, Sought::Agreement)] {
            let found = pairs::share(&case, sought, 200);
            let row = Row::counted("", "", found, Some(0.05));
            assert!(!row.breaks_its_promise(), "{case:?} {found:?}");
            // Without the wrong statement's hypothesis it is made, so that the test can fail.
            let turned = match sought {
                Sought::Difference => Sought::Agreement,
                Sought::Agreement => Sought::Difference,
            };
            assert!(pairs::share(&case, turned, 100).0 > 30, "{case:?}");
        }
    }
}

/// The p-values over looks that `pairs` works out are those of `compare`, along seeded paths.
#[test]
fn p_values_over_looks_are_those_of_the_comparison() {
    let mut uniform = Uniform(5);
    for is_model in [false, true] {
        let mut sides = [Sample {
            successes: 0,
            trials: 0,
        }; 2];
        let mut histories = [History::default(), History::default()];
        let mut looks = Looks::default();
        for further in [40_u64, 10, 60, 35] {
            for (side, rate) in sides.iter_mut().zip([0.9, 0.8]) {
                side.successes += uniform.count(further, rate);
                side.trials += further;
            }
            let now = Sides {
                first: sides[0],
                second: if is_model { Err(0.8) } else { Ok(sides[1]) },
            };
            let ledger = ledger(now);
            looks = looks.with(Look::of(&ledger));
            let (comparisons, _) =
                concluded(&ledger, &[requirement(0, at_least(0.5))], Some(&looks));
            let [difference, agreement] = &mut histories;
            let expected = [
                difference.and(now, Sought::Difference, 0.1),
                agreement.and(now, Sought::Agreement, 0.1),
            ];
            let found = [comparisons[0].p_difference, comparisons[0].p_equivalence];
            for (found, expected) in found.into_iter().zip(expected) {
                let found = found.expect("a p-value");
                assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            }
        }
    }
}

/// The same of verdicts: what `looks` works out is what `conclude` says.
#[test]
fn verdicts_over_looks_are_those_of_the_conclusion() {
    let mut uniform = Uniform(6);
    for trials in [Trials::Independent, Trials::People(0.3)] {
        let (mut seen, mut measures, mut looks) = (Vec::new(), Vec::new(), Looks::default());
        for further in [40_u64, 10, 60] {
            trials.add(&mut uniform, &mut seen, further, 0.9);
            measures.push(trials.measure(&seen));
            let now = vec![(0, measures[measures.len() - 1].clone())];
            let ledger = [piece("E", Technique::Experiment, now)];
            looks = looks.with(Look::of(&ledger));
            let asked = [requirement(0, at_least(0.85))];
            let (_, found) = concluded(&ledger, &asked, Some(&looks));
            let standing = &found[0].standings[0];
            for (verdict, found) in [
                (Verdict::Satisfied, standing.p_not_met),
                (Verdict::Violated, standing.p_met),
            ] {
                let expected = looks::doubt(&measures, verdict, 0.85);
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{verdict:?}: {found} {expected}"
                );
            }
        }
    }
}

/// What each relation of a pair states is wrong with at most its probability, at every rate of a grid, as sums over all
/// outcomes; and every relation comes up.
#[test]
fn every_relation_keeps_its_promise_at_all_rates() {
    let mut seen = [0.0_f64; RELATIONS.len()];
    for (first, second, margin) in [
        (12, Ok(12), 0.3),
        (10, Ok(40), 0.3),
        (60, Err(0.9), 0.1),
        (400, Err(0.5), 0.1),
    ] {
        let (cells::Largest(cells), together) = largest(&cells::Case {
            first,
            second,
            margin,
        });
        for (seen, cell) in seen.iter_mut().zip(cells) {
            *seen = seen.max(cell.into_iter().fold(0.0, f64::max));
        }
        let sums = [together.different, together.agree];
        for sum in sums {
            assert!(sum <= 0.05 + 1e-9, "{first} {second:?} {margin}: {sum}");
        }
        for (place, kinds) in [(0, vec![2]), (1, vec![0, 2]), (2, vec![0]), (3, vec![0])] {
            for kind in kinds {
                assert!(cells[place][kind] <= 0.05 + 1e-9, "{place} {kind}");
            }
        }
    }
    assert!(seen.iter().all(|most| *most > 0.01), "{seen:?}");
}

#[test]
fn a_rate_that_breaks_its_promise_is_seen() {
    let counted = |found| Row::counted("", "", (found, 1000), Some(0.05));
    assert!(!counted(60).breaks_its_promise() && counted(90).breaks_its_promise());
    let exact = Row {
        rate: Rate::Exact(0.051),
        ..counted(0)
    };
    assert!(exact.breaks_its_promise());
}
