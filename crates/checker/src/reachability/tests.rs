//! Random decision processes against all memoryless schedulers, each chain solved on its own.

use super::*;
use crate::answer::Options;
use crate::engine::{Exact, Plain, Sound};
use crate::graph::qualitative;
use crate::state_space::Csr;
use crate::test_models::{Process, arbitrary_process, rounded};
use prism_lang::Rational;
use proptest::prelude::*;

/// The probability of `left U right` in the chain of a scheduler.
fn of_scheduler(process: &Process, rows: &[usize], left: &[bool], right: &[bool]) -> Vec<Rational> {
    let chain = process.chain(rows);
    let sets = qualitative(&chain, left, right);
    crate::exact::reachability(&chain, &sets, &Options::default()).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn optimum_is_that_of_all_memoryless_schedulers(
        process in arbitrary_process(5),
        left in prop::collection::vec(prop::bool::weighted(0.8), 5),
        right in prop::collection::vec(prop::bool::weighted(0.3), 5),
        maximise in any::<bool>(),
    ) {
        let n = process.num_states();
        let (left, right) = (&left[..n], &right[..n]);
        let (exact, scheduler, _) = run::<Exact>(process.choices(), left, right, maximise);
        let all: Vec<_> = process.schedulers().map(|s| of_scheduler(&process, &s, left, right)).collect();
        for state in 0..n {
            let values = all.iter().map(|values| values[state].clone());
            let best = if maximise { values.max() } else { values.min() }.unwrap();
            prop_assert_eq!(&exact[state], &best, "state {}", state);
        }
        let rows = process.completed(&scheduler.unwrap());
        prop_assert_eq!(&of_scheduler(&process, &rows, left, right), &exact);

        let floats = rounded(&process.matrix);
        let choices = Choices::new(&floats, &process.choice_start);
        let (sound, _, _) = run::<Sound>(choices, left, right, maximise);
        for (bounds, exact) in sound.iter().zip(&exact) {
            let (low, high) = (bounds.value.low, bounds.value.high);
            prop_assert!(Rational::from_float(low).unwrap() <= *exact, "{} {}", low, exact);
            prop_assert!(Rational::from_float(high).unwrap() >= *exact, "{} {}", high, exact);
            prop_assert!(high - low <= 1e-6 * low || high == low, "{} {}", low, high);
        }
        // Iteration from below stays below, however early it stops.
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let estimates = until::<Plain>(choices, left, right, (0, None), None, maximise, &context);
        if let Ok((estimates, _, _)) = estimates {
            for (estimate, exact) in estimates.iter().zip(&exact) {
                prop_assert!(*estimate <= prism_lang::rational_to_f64(exact) + 1e-12);
            }
        }
    }

    #[test]
    fn steps_are_those_of_the_recursion(
        process in arbitrary_process(4), maximise in any::<bool>(), first in 0u64..3, more in 0u64..4,
        left in prop::collection::vec(prop::bool::weighted(0.8), 4),
        right in prop::collection::vec(prop::bool::weighted(0.3), 4),
    ) {
        let n = process.num_states();
        let (left, right) = (&left[..n], &right[..n]);
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let bound = (first, Some(first + more));
        let (values, _, _) =
            until::<Exact>(process.choices(), left, right, bound, None, maximise, &context).unwrap();
        for (state, value) in values.iter().enumerate() {
            let expected = recursion(&process, left, right, (first, first + more), maximise, state);
            prop_assert_eq!(value, &expected);
        }
    }
}

/// The definition, step by step forwards.
fn recursion(
    process: &Process,
    left: &[bool],
    right: &[bool],
    (first, last): (u64, u64),
    maximise: bool,
    state: usize,
) -> Rational {
    if first == 0 && right[state] {
        return Rational::from_integer(1.into());
    }
    if !left[state] || last == 0 {
        return Rational::from_integer(0.into());
    }
    let bound = (first.saturating_sub(1), last - 1);
    let value = |row: usize| -> Rational {
        let entries = process.matrix.row(row);
        entries
            .map(|(to, p)| p * recursion(process, left, right, bound, maximise, to))
            .sum()
    };
    let values = process.choices().rows(state).map(value);
    if maximise { values.max() } else { values.min() }.unwrap()
}

fn run<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    left: &[bool],
    right: &[bool],
    maximise: bool,
) -> Found<E::Value> {
    let options = Options::default();
    let context = Context::new(&options, 0.0);
    until::<E>(choices, left, right, (0, None), None, maximise, &context).unwrap()
}

#[test]
fn end_components_do_not_stop_the_bounds_from_meeting() {
    // 0 and 1 can go round for ever; from 0 a coin decides. Plain iteration from above stays at 1.
    let rows = vec![
        vec![(1, 1.0)],
        vec![(2, 0.25), (3, 0.75)],
        vec![(0, 1.0)],
        vec![(2, 1.0)],
        vec![(3, 1.0)],
    ];
    let matrix = Csr::from_rows(rows);
    let start = [0, 2, 3, 4, 5];
    let choices = Choices::new(&matrix, &start);
    let (values, scheduler, _) =
        run::<Sound>(choices, &[true; 4], &[false, false, true, false], true);
    assert!(values[0].value.contains(0.25) && values[0].value.relative_width() < 1e-12);
    assert!(values[1].value.contains(0.25) && values[1].complement.contains(0.75));
    assert_eq!(scheduler.unwrap()[..2], [1, 2]);
    let (least, _, _) = run::<Sound>(choices, &[true; 4], &[false, false, true, false], false);
    assert_eq!(least[0].value, crate::rounding::Bounds::ZERO);
}
