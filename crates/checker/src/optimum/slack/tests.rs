//! Bounds by slack against elimination and many rounds of iteration.

use super::*;
use crate::elimination::System;

/// Walks on `side` times `side` places that are left at the first with a reward of 1, at the last with one of 3: choice 0
/// drifts to higher, choice 1 to lower places, the third stays about.
fn walks(side: usize, choices: usize) -> Local {
    let states = side * side;
    let mut local = Local {
        choice_start: vec![0],
        row_start: vec![0],
        ..Local::default()
    };
    for state in 0..states {
        let (x, y) = (state / side, state % side);
        for up in &[0.65, 0.4, 0.5][..choices] {
            let (mut exit, mut earned) = (0.0, 0.0);
            let steps = [(x + 1, y, *up), (x, y + 1, *up)];
            for (x, y, p) in steps {
                let p = p / 2.0;
                if x < side && y < side {
                    local.column.push((x * side + y) as u32);
                    local.probability.push(p);
                } else if state == states - 1 {
                    exit += p;
                    earned += 3.0 * p;
                }
            }
            for (is_inside, target) in [
                (x > 0, state.wrapping_sub(side)),
                (y > 0, state.wrapping_sub(1)),
            ] {
                let p = (1.0 - up) / 2.0;
                if is_inside {
                    local.column.push(target as u32);
                    local.probability.push(p);
                } else if state == 0 {
                    exit += p;
                    earned += p;
                }
            }
            let start = local.row_start[local.row_start.len() - 1];
            let inside: f64 = local.probability[start..].iter().sum();
            local.finish_row(exit, [earned, earned * (1.0 + 1e-12)], inside);
        }
        local.choice_start.push(local.exit.len());
    }
    local.error = 2.0 * 16.0 * f64::EPSILON;
    local
}

fn found(local: &Local, maximise: bool) -> Confirmed {
    let options = Options::default();
    let slack = Slack {
        local,
        maximise,
        tolerance: 1e-8,
        options: &options,
    };
    slack.search(vec![0.0; local.len()]).unwrap()
}

#[test]
fn bounds_of_a_chain_are_around_what_elimination_finds() {
    let local = walks(20, 1);
    let policy: Vec<usize> = (0..local.len()).collect();
    let system: System<f64, 3> = local.system(&policy);
    let values = system.solve(u64::MAX, &|| false).unwrap().values;
    let found = found(&local, true);
    assert!(found.is_close);
    let (lower, upper) = (found.lower.unwrap(), found.upper.unwrap());
    for (state, [_, low, high]) in values.iter().enumerate() {
        let around = lower[state] <= low * (1.0 + 1e-11) && high * (1.0 - 1e-11) <= upper[state];
        assert!(
            around,
            "{state}: {} {low} {high} {}",
            lower[state], upper[state]
        );
        assert!(upper[state] - lower[state] <= 2e-8 * low);
    }
}

#[test]
fn bounds_of_optima_are_around_what_many_rounds_reach() {
    for maximise in [true, false] {
        let local = walks(12, 3);
        // From below; what is left after so many rounds is far below the bounds' distance.
        let mut x = vec![0.0; local.len()];
        for _ in 0..40_000 {
            for place in 0..x.len() {
                x[place] = local.best(place, &x, Side::Low, maximise).1;
            }
        }
        let found = found(&local, maximise);
        assert!(found.is_close, "{maximise}");
        let (lower, upper) = (found.lower.unwrap(), found.upper.unwrap());
        for (state, x) in x.iter().enumerate() {
            let around = lower[state] <= x * (1.0 + 1e-10) && x * (1.0 - 1e-10) <= upper[state];
            assert!(
                around,
                "{maximise} {state}: {} {x} {}",
                lower[state], upper[state]
            );
            assert!(upper[state] - lower[state] <= 2e-8 * x);
        }
    }
}

#[test]
fn what_is_not_inductive_is_not_confirmed() {
    let local = walks(12, 3);
    let candidate = found(&local, true).candidate;
    let options = Options::default();
    let slack = Slack {
        local: &local,
        maximise: true,
        tolerance: 1e-8,
        options: &options,
    };
    // Without slack, every distance leaves a state in which rounding decides against the claim.
    let nothing = vec![0.0; local.len()];
    let wrong: Vec<f64> = candidate.iter().map(|x| x * 0.5).collect();
    let weights = candidate.clone();
    assert!(
        slack
            .confirm(&wrong, &nothing, &weights, Side::High)
            .is_none()
    );
    let wrong: Vec<f64> = candidate.iter().map(|x| x * 2.0).collect();
    assert!(
        slack
            .confirm(&wrong, &nothing, &weights, Side::Low)
            .is_none()
    );
}
