//! Random chains and decision processes against each other: elimination, iteration, exact arithmetic.

use super::*;
use crate::amount::Extended;
use crate::answer::Options;
use crate::engine::{Exact, Sound};
use crate::state_space::Csr;
use crate::test_models::{Process, arbitrary_process, rounded};
use prism_lang::{Number, Rational};
use proptest::prelude::*;

fn part<A: Amount>(process: &Process, numbers: &[u32]) -> Part<A> {
    let amount = |n: u32| A::literal(&Number::from_rational(Rational::from_integer(n.into())));
    Part {
        state: Vec::new(),
        row: (0..process.matrix.num_rows())
            .map(|r| amount(numbers[r % numbers.len()]))
            .collect(),
    }
}

/// The long-run averages in the chain of a scheduler, exactly.
fn of_scheduler(process: &Process, rows: &[usize], numbers: &[u32]) -> Vec<Extended> {
    let chain = process.chain(rows);
    let rewards: Part<Extended> = part(process, numbers);
    let rewards = Part {
        state: Vec::new(),
        row: rows.iter().map(|row| rewards.row[*row].clone()).collect(),
    };
    let options = Options::default();
    let context = Context::new(&options, 0.0);
    let choices = Choices::new(&chain, &[]);
    average::<Exact>(|| choices, choices, || None, &rewards, true, &context)
        .unwrap()
        .values
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn averages_are_those_of_the_best_memoryless_scheduler(
        process in arbitrary_process(4),
        numbers in prop::collection::vec(prop_oneof![1 => Just(0u32), 1 => 1u32..5], 7),
        maximise in any::<bool>(),
    ) {
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let matrix = rounded(&process.matrix);
        let choices = Choices::new(&matrix, &process.choice_start);
        let found = average::<Sound>(|| choices, choices, || None, &part(&process, &numbers), maximise, &context).unwrap();
        let all: Vec<_> = process.schedulers().map(|rows| of_scheduler(&process, &rows, &numbers)).collect();
        for (state, bounds) in found.values.iter().enumerate() {
            let values = all.iter().map(|values| values[state].clone());
            let Some(Extended::Finite(best)) = values.reduce(|a, b| a.best(&b, maximise)) else {
                panic!("averages are finite");
            };
            prop_assert!(Rational::from_float(bounds.low).unwrap() <= best, "{:?} {}", bounds, best);
            prop_assert!(Rational::from_float(bounds.high).unwrap() >= best, "{:?} {}", bounds, best);
            prop_assert!(bounds.high - bounds.low <= 2e-6 * bounds.low, "{:?} {}", bounds, best);
        }
    }
}

#[test]
fn a_cycle_is_averaged_over_its_time() {
    // Rates 1 and 3: three quarters of the time in the first state.
    let rates = Csr::from_rows(vec![vec![(1, 1.0)], vec![(0, 3.0)]]);
    let jumps = Csr::from_rows(vec![vec![(1, 1.0)], vec![(0, 1.0)]]);
    let options = Options::default();
    let context = Context::new(&options, 0.0);
    let rewards = Part {
        state: Vec::new(),
        row: vec![Bounds::ONE, Bounds::ZERO],
    };
    let (rates, jumps) = (Choices::new(&rates, &[]), Choices::new(&jumps, &[]));
    let found = average::<Sound>(|| jumps, rates, || None, &rewards, true, &context).unwrap();
    assert!(found.values[0].contains(0.75) && found.values[1].relative_width() < 1e-12);
    let component = EndComponent {
        states: vec![0, 1],
        rows: vec![0, 1],
    };
    let work = Iteration::new(
        rates.matrix,
        |s| rates.rows(s as usize),
        &rewards.row,
        &component,
        &[0, 1],
    );
    let (bounds, _) = work.run(true, &context).unwrap();
    assert!(
        bounds.contains(0.75) && bounds.relative_width() < 1e-6,
        "{bounds:?}"
    );
}

#[test]
fn equations_and_elimination_agree() {
    // Two queues of 30 places, served in turn when they are longer than the other: 900 states.
    let at = |x: usize, y: usize| (x * 30 + y) as u32;
    let rates = |state: usize| {
        let (x, y) = (state / 30, state % 30);
        let mut row = Vec::new();
        if x < 29 {
            row.push((at(x + 1, y), 1.0));
        }
        if y < 29 {
            row.push((at(x, y + 1), 1.5));
        }
        if x > 0 && x >= y {
            row.push((at(x - 1, y), 3.0));
        }
        if y > 0 && y >= x {
            row.push((at(x, y - 1), 2.0));
        }
        row
    };
    let rates = Csr::from_rows((0..900).map(rates).collect());
    let rewards: Vec<Bounds> = (0..900)
        .map(|state| Bounds::exactly(f64::from(state / 30 + state % 30)))
        .collect();
    let part = Part {
        state: Vec::new(),
        row: rewards.clone(),
    };
    let component = EndComponent {
        states: (0..900).collect(),
        rows: (0..900).collect(),
    };
    let options = Options::default();
    let context = Context::new(&options, 0.0);
    let local: Vec<u32> = (0..900).collect();
    let choices = Choices::new(&rates, &[]);
    let directly = round_trip::<Sound>(choices, &part, &component, &local, BUDGET, &context)
        .unwrap()
        .unwrap();
    let rows = |state: u32| choices.rows(state as usize);
    let work = Iteration::new(&rates, rows, &rewards, &component, &local);
    let (bounds, _) = work.quickly(&context).unwrap().unwrap();
    assert!(
        bounds.low <= directly.high && directly.low <= bounds.high,
        "{bounds:?} {directly:?}"
    );
    assert!(bounds.relative_width() <= 1e-6, "{bounds:?}");
}
