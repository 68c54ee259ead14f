//! Every model of `conformance/models` under every method, held against the exact values beside its properties.
//!
//! In a `.props` file each property is preceded by lines `// RESULT: value`, or `// RESULT (N=3,p=0.5): value` with values
//! of the model's constants. A value is an arithmetic expression over decimal numbers (`+ - * / ^` and parentheses,
//! computed exactly), `true`, `false`, or `[low, high]` over several initial states. Models may state their size in lines
//! `// STATES: n` and `// TRANSITIONS: n`.
//!
//! The exact method must give the value itself, the sound method bounds that contain it and are narrow. The method of
//! PRISM's default settings may be far off, but then a line `// PRISM-DEFAULT: off, reason` (with constants as above) must
//! say so, and it must really be off. There are no exceptions for the other methods, and no way to state one, but that the
//! classical iterations, run until hardly anything changes, may be off, too, where PRISM's stopping rule is; and where a line
//! `// ESTIMATES: off, reason` says that plain floating point cannot tell (value iteration must be off there).
//! Policy iteration and linear equations must enclose the value as the sound method does.

use crate::support;

use checker::explore::explore;
use checker::state_space::StateSpace;
use checker::{Bounds, CheckError, Method, Options, Stop, Termination, check_exact, check_space};
use prism_lang::Rational;
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};
use support::corpus::{Case, for_all, models, noted, resolved};
use support::judge::{
    PRECISION, estimate_is_close, exactly, is_above, is_below, near, near_absolutely, sound,
};
use support::value::Expected;

/// Relative error up to which the method of PRISM's default settings counts as right.
const CLOSE: f64 = 1e-4;

#[test]
fn the_exact_method_gives_the_value_itself() {
    for_all::<Rational>(|space, case| {
        let options = Options::with_method(Method::Exact);
        let answer =
            check_exact(space, &case.property.property, &options).map_err(|e| e.to_string())?;
        exactly(&answer, &case.expected)
    });
}

#[test]
fn the_sound_method_encloses_the_value_narrowly() {
    for_all::<f64>(|space, case| {
        let options = Options {
            precision: PRECISION,
            ..Options::with_method(Method::Sound)
        };
        match check_space(space, &case.property.property, &options) {
            Ok(answer) => sound(&answer, &case.property.property, &case.expected),
            // A bound that lies within the bounds of the computation is not guessed at.
            Err(CheckError::Undecided { bounds, .. }) if bounds.low <= bounds.high => {
                decided_exactly(case)
            }
            Err(error) => Err(error.to_string()),
        }
    });
}

/// What `CheckError::Undecided` tells its reader to do.
fn decided_exactly(case: &Case) -> Result<(), String> {
    let has_bound = ["P<", "P>"].iter().any(|p| case.property.text.contains(p));
    if !has_bound {
        return Err("undecided, but there is no bound to decide".to_owned());
    }
    let space = explore::<Rational>(&resolved(&case.model, &case.constants));
    let space = space.map_err(|e| e.to_string())?;
    let options = Options::with_method(Method::Exact);
    let answer = check_exact(&space, &case.property.property, &options);
    exactly(&answer.map_err(|e| e.to_string())?, &case.expected)
}

#[test]
fn the_method_of_prisms_default_is_close_or_stated_to_be_off() {
    for_all::<f64>(|space, case| {
        let options = Options::with_method(Method::PrismDefault);
        let outcome = match check_space(space, &case.property.property, &options) {
            Ok(answer) => estimate_is_close(&answer, &case.expected, &|value, exact| {
                near(value, exact, CLOSE)
            }),
            Err(error @ (CheckError::NotConverged { .. } | CheckError::NotFinite { .. })) => {
                Err(error.to_string())
            }
            Err(error) => return Err(error.to_string()),
        };
        match (outcome, case.off) {
            (Err(reason), false) => Err(reason),
            (Ok(()), true) => Err("is stated to be off but is close".to_owned()),
            _ => Ok(()),
        }
    });
}

/// Change at which the classical iterations are stopped, and the relative error within which they must then be.
const HARDLY: f64 = 1e-13;
const NEAR: f64 = 1e-8;

#[test]
fn classical_iterations_come_near_and_call_themselves_estimates() {
    let classical = |method: &Method| method.is_estimate() && *method != Method::PrismDefault;
    for_all::<f64>(|space, case| {
        for method in Method::ALL.into_iter().filter(classical) {
            let outcome = by_iteration(space, case, method, Termination::Relative);
            match outcome {
                Ok(()) if case.estimates_off && method == Method::ValueIteration => {
                    return Err("is stated to be off but is close".to_owned());
                }
                Err(_) if case.off || case.estimates_off => {}
                outcome => outcome?,
            }
        }
        match by_iteration(space, case, Method::GaussSeidel, Termination::Absolute) {
            Err(_) if case.off || case.estimates_off => Ok(()),
            outcome => outcome,
        }
    });
}

fn by_iteration(
    space: &StateSpace<f64>,
    case: &Case,
    method: Method,
    termination: Termination,
) -> Result<(), String> {
    let options = Options {
        epsilon: HARDLY,
        termination,
        ..Options::with_method(method)
    };
    let is_near = |value, exact: &Rational| match termination {
        Termination::Relative => near(value, exact, NEAR),
        Termination::Absolute => near_absolutely(value, exact, NEAR),
    };
    let outcome = match check_space(space, &case.property.property, &options) {
        Ok(answer) if answer.method != method => Err(format!("answered by {:?}", answer.method)),
        Ok(answer) => estimate_is_close(&answer, &case.expected, &is_near),
        Err(error) if has_no_answer(&error, method) => Ok(()),
        Err(error) => Err(error.to_string()),
    };
    outcome.map_err(|reason| format!("{method:?}: {reason}"))
}

/// What a method by name is not for, and says so.
fn has_no_answer(error: &CheckError, method: Method) -> bool {
    let CheckError::Unsupported(why) = error else {
        return false;
    };
    match method {
        Method::LinearEquations => why.contains("are those of a chain"),
        Method::ValueIteration => false,
        _ => why.contains("long-run averages over schedulers"),
    }
}

#[test]
fn policy_iteration_and_linear_equations_enclose_the_value_narrowly() {
    for_all::<f64>(|space, case| {
        for method in [Method::PolicyIteration, Method::LinearEquations] {
            let options = Options {
                precision: PRECISION,
                ..Options::with_method(method)
            };
            let outcome = match check_space(space, &case.property.property, &options) {
                Ok(answer) if answer.method != method => {
                    Err(format!("answered by {:?}", answer.method))
                }
                Ok(answer) => sound(&answer, &case.property.property, &case.expected),
                Err(CheckError::Undecided { bounds, .. }) if bounds.low <= bounds.high => {
                    decided_exactly(case)
                }
                Err(error) if has_no_answer(&error, method) => Ok(()),
                Err(error) => Err(error.to_string()),
            };
            outcome.map_err(|reason| format!("{method:?}: {reason}"))?;
        }
        Ok(())
    });
}

/// Whatever moment a check is stopped at, the bounds that it has reached contain the value.
#[test]
fn bounds_reached_when_stopped_contain_the_value() {
    let reached = Cell::new(0);
    for_all::<f64>(|space, case| {
        for asked in [0, 2] {
            let count = AtomicU64::new(0);
            let is_asked = || count.fetch_add(1, Ordering::Relaxed) >= asked;
            let stop = Stop::new(&is_asked);
            let options = Options {
                stop: Some(&stop),
                ..Options::default()
            };
            match check_space(space, &case.property.property, &options) {
                Ok(answer) => sound(&answer, &case.property.property, &case.expected)?,
                Err(CheckError::Stopped {
                    reached: Some(bounds),
                }) => {
                    reached.set(reached.get() + 1);
                    holds_when_stopped(bounds, &case.expected)?;
                }
                Err(
                    CheckError::Stopped { reached: None }
                    | CheckError::Cancelled
                    | CheckError::Undecided { .. },
                ) => {}
                Err(error) => return Err(error.to_string()),
            }
        }
        Ok(())
    });
    let reached = reached.get();
    assert!(
        reached > 20,
        "only {reached} checks were stopped with bounds"
    );
}

fn holds_when_stopped(Bounds { low, high }: Bounds, expected: &Expected) -> Result<(), String> {
    let holds = match expected {
        Expected::Number(exact) => is_below(low, exact) && is_above(high, exact),
        Expected::Range(least, greatest) => is_below(low, least) && is_above(high, greatest),
        // Of what is compared, the truth alone is known here.
        Expected::Truth(_) => low <= high,
    };
    match holds {
        true => Ok(()),
        false => Err(format!("stopped between {low:e} and {high:e}")),
    }
}

#[test]
fn models_have_the_stated_sizes() {
    let mut stated = 0;
    for model in models() {
        let text = std::fs::read_to_string(&model).expect("the model can be read");
        let number = |key| {
            let noted = noted(&text, key);
            noted.first().map(|(_, n)| {
                n.parse::<usize>()
                    .expect("a number of states or transitions")
            })
        };
        let (states, transitions) = (number("STATES"), number("TRANSITIONS"));
        if states.is_none() && transitions.is_none() {
            continue;
        }
        let space = explore::<f64>(&resolved(&model, "")).expect("a state space");
        assert!(
            states.is_none_or(|n| n == space.num_states()),
            "{}: {} states",
            model.display(),
            space.num_states()
        );
        assert!(
            transitions.is_none_or(|n| n == space.num_transitions()),
            "{}: {} transitions",
            model.display(),
            space.num_transitions()
        );
        stated += 1;
    }
    assert!(stated >= 10, "only {stated} models state their size");
}
