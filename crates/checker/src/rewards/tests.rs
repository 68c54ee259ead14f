//! Random decision processes with rewards against all memoryless schedulers.

use super::*;
use crate::amount::Extended;
use crate::answer::Options;
use crate::engine::{Exact, Sound};
use crate::graph::qualitative;
use crate::state_space::{Csr, Rewards, TransitionRewards};
use crate::test_models::{Process, arbitrary_process, rounded};
use prism_lang::Rational;
use proptest::prelude::*;

/// The reward before `target` in the chain of a scheduler: by Gaussian elimination.
fn of_scheduler(
    process: &Process,
    rows: &[usize],
    reward: &[Rational],
    target: &[bool],
) -> Vec<Extended> {
    let chain = process.chain(rows);
    let n = target.len();
    let sure = qualitative(&chain, &vec![true; n], target).surely;
    let zero = || Rational::from_integer(0.into());
    let open: Vec<usize> = (0..n).filter(|s| sure[*s] && !target[*s]).collect();
    let mut a: Vec<Vec<Rational>> = vec![vec![zero(); open.len() + 1]; open.len()];
    for (i, state) in open.iter().enumerate() {
        a[i][i] += Rational::from_integer(1.into());
        a[i][open.len()] = reward[rows[*state]].clone();
        for (to, p) in chain.row(*state) {
            if let Some(j) = open.iter().position(|s| *s == to) {
                a[i][j] -= p;
            }
        }
    }
    let solved = gauss(a);
    (0..n)
        .map(|s| match open.iter().position(|o| *o == s) {
            Some(i) => Extended::Finite(solved[i].clone()),
            None if target[s] => Extended::Finite(zero()),
            None => Extended::Infinite,
        })
        .collect()
}

fn gauss(mut a: Vec<Vec<Rational>>) -> Vec<Rational> {
    let n = a.len();
    for pivot in 0..n {
        let row = (pivot..n)
            .find(|r| a[*r][pivot] != Rational::from_integer(0.into()))
            .unwrap();
        a.swap(pivot, row);
        let scale = a[pivot][pivot].clone();
        a[pivot].iter_mut().for_each(|x| *x /= &scale);
        for other in (0..n).filter(|r| *r != pivot) {
            let factor = a[other][pivot].clone();
            let line = a[pivot].clone();
            a[other]
                .iter_mut()
                .zip(&line)
                .for_each(|(x, y)| *x -= &factor * y);
        }
    }
    a.into_iter().map(|mut row| row.pop().unwrap()).collect()
}

fn structure(process: &Process, numbers: &[u32]) -> Rewards<Rational> {
    let rational = |n: u32| Rational::new(n.into(), 3.into());
    let states = process.num_states();
    Rewards {
        state: (0..states).map(|s| rational(numbers[s])).collect(),
        transition: TransitionRewards::Row(
            (0..process.matrix.num_rows())
                .map(|r| rational(numbers[5 + r % 7]))
                .collect(),
        ),
        relative_error: 0.0,
    }
}

fn floats(rewards: &Rewards<Rational>) -> Rewards<f64> {
    let all = |values: &[Rational]| values.iter().map(prism_lang::rational_to_f64).collect();
    Rewards {
        state: all(&rewards.state),
        transition: match &rewards.transition {
            TransitionRewards::Row(values) => TransitionRewards::Row(all(values)),
            _ => TransitionRewards::None,
        },
        relative_error: f64::EPSILON,
    }
}

fn contains(bounds: &crate::rounding::Bounds, exact: &Extended) -> bool {
    match exact {
        Extended::Finite(value) => {
            Rational::from_float(bounds.low).unwrap() <= *value
                && Rational::from_float(bounds.high).is_some_and(|high| high >= *value)
                && bounds.high - bounds.low <= 2e-6 * bounds.low
        }
        _ => bounds.low == f64::INFINITY,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn reward_before_a_target_is_that_of_the_best_scheduler(
        process in arbitrary_process(5),
        target in prop::collection::vec(prop::bool::weighted(0.3), 5),
        numbers in prop::collection::vec(prop_oneof![2 => Just(0u32), 1 => 1u32..5], 12),
        maximise in any::<bool>(),
    ) {
        let target = &target[..process.num_states()];
        let rewards = structure(&process, &numbers);
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let model = RewardModel::new(process.choices(), &rewards, 0.0);
        let exact = reach::<Exact>(process.choices(), &model, target, maximise, &context).unwrap();
        let earned: Vec<Rational> = (model.rows().iter())
            .map(|r| match r { Extended::Finite(r) => r.clone(), _ => unreachable!() })
            .collect();
        let all: Vec<_> = process.schedulers().map(|s| of_scheduler(&process, &s, &earned, target)).collect();
        for state in 0..target.len() {
            let best = all.iter().map(|v| v[state].clone()).reduce(|a, b| a.best(&b, maximise)).unwrap();
            prop_assert_eq!(&exact.values[state], &best, "state {}", state);
        }
        if !maximise {
            let rows = process.completed(&exact.scheduler);
            prop_assert_eq!(&of_scheduler(&process, &rows, &earned, target), &exact.values);
        }
        let matrix = rounded(&process.matrix);
        let choices = Choices::new(&matrix, &process.choice_start);
        let model = RewardModel::new(choices, &floats(&rewards), context.entry_error);
        let sound = reach::<Sound>(choices, &model, target, maximise, &context).unwrap();
        for (bounds, exact) in sound.values.iter().zip(&exact.values) {
            prop_assert!(contains(bounds, exact), "{:?} {:?}", bounds, exact);
        }
    }

    #[test]
    fn total_reward_is_that_of_the_best_scheduler(
        process in arbitrary_process(4),
        numbers in prop::collection::vec(prop_oneof![3 => Just(0u32), 1 => 1u32..5], 12),
        maximise in any::<bool>(),
    ) {
        let rewards = structure(&process, &numbers);
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        let matrix = rounded(&process.matrix);
        let choices = Choices::new(&matrix, &process.choice_start);
        let model = RewardModel::new(choices, &floats(&rewards), context.entry_error);
        let sound = total::<Sound>(choices, &model, maximise, &context).unwrap();
        let exact_model = RewardModel::new(process.choices(), &rewards, 0.0);
        let exact = total::<Exact>(process.choices(), &exact_model, maximise, &context).unwrap();
        let earned: Vec<Rational> = (exact_model.rows().iter())
            .map(|r| match r { Extended::Finite(r) => r.clone(), _ => unreachable!() })
            .collect();
        let of_all: Vec<_> = (process.schedulers())
            .map(|rows| of_scheduler(&process, &rows, &earned, &resting(&process, &rows, &earned)))
            .collect();
        for (state, (total, exact)) in sound.values.iter().zip(&exact.values).enumerate() {
            prop_assert!(contains(total, exact), "{:?} {:?}", total, exact);
            let values = of_all.iter().map(|values| values[state].clone());
            prop_assert_eq!(exact, &values.reduce(|a, b| a.best(&b, maximise)).unwrap());
        }
    }
}

/// The states of bottom components of a scheduler's chain in which nothing is earned.
fn resting(process: &Process, rows: &[usize], reward: &[Rational]) -> Vec<bool> {
    let mut resting = vec![false; rows.len()];
    let nothing = Rational::from_integer(0.into());
    for component in crate::graph::bottom_components(&process.chain(rows)) {
        let free = component
            .iter()
            .all(|s| reward[rows[*s as usize]] == nothing);
        component.iter().for_each(|s| resting[*s as usize] = free);
    }
    resting
}

#[test]
fn rewards_of_both_signs_cancel_in_a_chain() {
    let matrix = Csr::from_rows(vec![
        vec![(0, 0.5), (1, 0.5)],
        vec![(2, 1.0)],
        vec![(2, 1.0)],
    ]);
    let choices = Choices::new(&matrix, &[]);
    let rewards = Rewards::of_states(vec![3.0, -6.0, 7.0]);
    let model = RewardModel::new(choices, &rewards, 0.0);
    let options = Options::default();
    let context = Context::new(&options, 0.0);
    let target = [false, false, true];
    let found = reach::<Sound>(choices, &model, &target, true, &context).unwrap();
    assert!(found.values[0].contains(0.0), "{:?}", found.values);
    assert!(found.values[0].high - found.values[0].low < 1e-12);
    assert!(found.values[1].contains(-6.0));
}
