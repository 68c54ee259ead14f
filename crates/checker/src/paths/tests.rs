//! Paths against enumeration: all paths without a circle, of small random chains.

use super::*;
use crate::explore::explore;
use crate::state_space::Csr;
use prism_lang::resolved::Model;
use prism_lang::{Constants, Rational, parse_model, resolve};
use proptest::prelude::*;

fn model(text: &str) -> Model {
    resolve(&parse_model(text).tree, &Constants::new()).expect("a correct model")
}

/// Rows of a chain whose probabilities are sixteenths; row s leads to the targets named for it.
fn chain(rows: &[Vec<usize>]) -> StateSpace<f64> {
    let row = |targets: &Vec<usize>| {
        let mut row: Vec<(u32, f64)> = Vec::new();
        let share = 1.0 / targets.len() as f64;
        for target in targets {
            match row.iter_mut().find(|(known, _)| *known == *target as u32) {
                Some((_, p)) => *p += share,
                None => row.push((*target as u32, share)),
            }
        }
        row
    };
    let matrix = Csr::from_rows(rows.iter().map(row).collect());
    StateSpace::from_matrix(matrix, vec![0], Vec::new())
}

/// The greatest probability and the least length of all circle-free paths to a goal.
fn by_enumeration(space: &StateSpace<f64>, goal: &[bool]) -> Option<(f64, usize)> {
    fn go(
        space: &StateSpace<f64>,
        goal: &[bool],
        path: &mut Vec<usize>,
        p: f64,
        best: &mut Option<(f64, usize)>,
    ) {
        let here = path[path.len() - 1];
        if goal[here] {
            let (most, least) = best.unwrap_or((0.0, usize::MAX));
            *best = Some((most.max(p), least.min(path.len() - 1)));
            return;
        }
        for (target, factor) in space.matrix.row(here) {
            if !path.contains(&target) {
                path.push(target);
                go(space, goal, path, p * factor, best);
                path.pop();
            }
        }
    }
    let mut best = None;
    go(space, goal, &mut vec![0], 1.0, &mut best);
    best
}

fn transitions(states: &[usize]) -> impl Iterator<Item = (usize, usize)> + '_ {
    states.windows(2).map(|pair| (pair[0], pair[1]))
}

fn reachable(space: &StateSpace<f64>) -> Vec<bool> {
    let mut seen = vec![false; space.num_states()];
    let mut stack = vec![0];
    while let Some(state) = stack.pop() {
        if !std::mem::replace(&mut seen[state], true) {
            stack.extend(space.matrix.row(state).map(|(target, _)| target));
        }
    }
    seen
}

proptest! {
    #[test]
    fn paths_agree_with_enumeration(
        rows in prop::collection::vec(prop::collection::vec(0usize..7, 1..6), 7),
        goal in prop::collection::vec(prop::bool::weighted(0.3), 7),
    ) {
        let space = chain(&rows);
        let expected = by_enumeration(&space, &goal);
        let likely = most_probable_path(&space, &goal);
        let short = shortest_path(&space, &goal);
        prop_assert_eq!(likely.is_some(), expected.is_some());
        prop_assert_eq!(short.is_some(), expected.is_some());
        if let (Some(likely), Some(short), Some((most, least))) = (likely, short, expected) {
            prop_assert!((likely.probability - most).abs() <= 1e-14 * most, "{} {most}", likely.probability);
            prop_assert_eq!(short.states.len() - 1, least);
            for path in [&likely, &short] {
                let product = transitions(&path.states).map(|(from, to)| {
                    *probability(&space, from, to).expect("a transition")
                }).product::<f64>();
                prop_assert_eq!(path.probability, product);
                prop_assert_eq!(path.states[0], 0);
                prop_assert!(goal[path.states[path.states.len() - 1]]);
            }
        }
    }

    #[test]
    fn a_cover_takes_every_reachable_transition_and_nothing_else(
        rows in prop::collection::vec(prop::collection::vec(0usize..8, 1..5), 8),
        longest in 1usize..30,
    ) {
        let space = chain(&rows);
        let seen = reachable(&space);
        let class = |from: usize, to: usize| seen[from].then_some((from, to));
        let cover = transition_cover(&space, class, longest, &|| false);
        let taken: std::collections::BTreeSet<_> =
            cover.paths.iter().flat_map(|path| transitions(&path.states)).collect();
        let all: std::collections::BTreeSet<_> = (0..8)
            .filter(|from| seen[*from])
            .flat_map(|from| space.matrix.row(from).map(move |(to, _)| (from, to)))
            .collect();
        prop_assert_eq!(&taken, &all);
        prop_assert_eq!(cover.classes, all.len());
        prop_assert_eq!(cover.length, cover.paths.iter().map(|p| p.states.len() - 1).sum::<usize>());
        // Every path takes something that no path before it took.
        let mut before = std::collections::BTreeSet::new();
        for path in &cover.paths {
            let news = transitions(&path.states).filter(|t| before.insert(*t)).count();
            prop_assert!(news > 0 && path.probability > 0.0);
        }
    }
}

#[test]
fn an_exact_path_has_an_exact_probability() {
    let model = model(
        "dtmc module m x : [0..3]; [] x=0 -> 1/3:(x'=1) + 2/3:(x'=2); [] x=1 -> 1:(x'=3); \
         [] x=2 -> 1/7:(x'=3) + 6/7:(x'=2); endmodule",
    );
    let space = explore::<Rational>(&model).expect("a state space");
    let goal: Vec<bool> = (0..space.num_states())
        .map(|s| space.value(s, 0) == 3)
        .collect();
    let path = most_probable_path(&space, &goal).expect("a path");
    let third = Rational::from_i64(1).div(&Rational::from_i64(3));
    assert_eq!(Some(path.probability), third);
}

#[test]
fn a_goal_that_cannot_be_reached_has_no_path() {
    let space = chain(&[vec![0], vec![1]]);
    assert_eq!(most_probable_path(&space, &[false, true]), None);
    assert_eq!(shortest_path(&space, &[false, true]), None);
    assert_eq!(most_probable_path(&space, &[]), None);
    let start = most_probable_path(&space, &[true, false]).expect("the start");
    assert_eq!((start.states, start.probability), (vec![0], 1.0));
}

#[test]
fn of_equal_paths_the_first_in_order_is_taken() {
    let space = chain(&[vec![1, 2], vec![3], vec![3], vec![3]]);
    let goal = [false, false, false, true];
    for _ in 0..3 {
        assert_eq!(
            most_probable_path(&space, &goal).map(|p| p.states),
            Some(vec![0, 1, 3])
        );
    }
}

#[test]
fn a_class_is_taken_once_and_paths_are_cut_at_their_length() {
    // A ring of 6 states.
    let space = chain(&[vec![1], vec![2], vec![3], vec![4], vec![5], vec![0]]);
    let one = transition_cover(&space, |_, _| Some(()), 100, &|| false);
    assert_eq!((one.paths.len(), one.classes, one.length), (1, 1, 1));
    let all = transition_cover(&space, |from, _| Some(from), 100, &|| false);
    assert_eq!((all.paths.len(), all.classes, all.length), (1, 6, 6));
    let cut = transition_cover(&space, |from, _| Some(from), 2, &|| false);
    assert!(cut.paths.len() > 1 && cut.classes == 6);
    let stopped = transition_cover(&space, |from, _| Some(from), 2, &|| true);
    assert!(stopped.paths.is_empty());
}

#[test]
fn causes_of_each_step_sum_to_its_probability() {
    let model = model(
        "dtmc
         module a x : [0..2]; [go] x<2 -> 0.25:(x'=x+1) + 0.75:true; [] x=0 -> (x'=1); endmodule
         module b y : bool; [go] !y -> 0.5:(y'=true) + 0.5:true; [go] !y -> (y'=true); [] y -> (y'=false); endmodule",
    );
    let space = explore::<f64>(&model).expect("a state space");
    for from in 0..space.num_states() {
        for (to, p) in space.matrix.row(from) {
            let path = Path {
                states: vec![from, to],
                probability: *p,
            };
            let steps = PathSteps::new(&model, &space, &path).expect("causes").steps;
            let causes = &steps[0].causes;
            let sum: f64 = causes.iter().map(|cause| cause.probability).sum();
            let deadlock = space.deadlocks().contains(&from);
            assert!(deadlock && causes.is_empty() || (sum - p).abs() < 1e-15);
            assert_eq!(steps[0].changes.is_empty(), from == to);
        }
    }
    let goal: Vec<bool> = (0..space.num_states())
        .map(|s| space.state(s) == [1, 1])
        .collect();
    let path = shortest_path(&space, &goal).expect("a path");
    let steps = PathSteps::new(&model, &space, &path).expect("causes").steps;
    // The second command of b sets y for certain: it is the likelier cause.
    let modules = &steps[0].causes[0].modules;
    assert_eq!(modules, &["a".to_owned(), "b".to_owned()]);
    assert_eq!(steps[0].causes[0].action.as_deref(), Some("go"));
    assert!(steps[0].causes[0].probability > steps[0].causes[1].probability);
}
