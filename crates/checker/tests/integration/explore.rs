//! Exploring against a naive interpreter of the same language, and on models counted by hand.

use std::collections::{BTreeMap, BTreeSet};

use checker::explore::{ExploreError, ExploreOptions, explore, explore_with};
use checker::state_space::StateSpace;
use prism_lang::resolved::{Command, Model};
use prism_lang::{Constants, Rational, parse_model, resolve};
use proptest::prelude::*;

fn model(text: &str) -> Model {
    let parsed = parse_model(text);
    assert!(
        parsed.diagnostics.is_empty(),
        "{text}\n{:?}",
        parsed.diagnostics
    );
    resolve(&parsed.tree, &Constants::new()).unwrap_or_else(|d| panic!("{text}\n{d:?}"))
}

fn rational(above: i64, below: i64) -> Rational {
    Rational::new(above.into(), below.into())
}

type Row = BTreeMap<Vec<i64>, Rational>;

/// All rows of a model, from its definition: every choice is a list of commands, built module by module.
fn naive(model: &Model, initial: Vec<i64>) -> BTreeMap<Vec<i64>, Row> {
    let mut rows = BTreeMap::new();
    let mut open = vec![initial];
    while let Some(state) = open.pop() {
        if rows.contains_key(&state) {
            continue;
        }
        let mut row = Row::new();
        let choices = naive_choices(model, &state);
        let weight = rational(1, choices.len().max(1) as i64);
        for commands in &choices {
            for (target, probability) in naive_outcomes(commands, &state) {
                *row.entry(target).or_insert_with(|| rational(0, 1)) += probability * &weight;
            }
        }
        if choices.is_empty() {
            row.insert(state.clone(), rational(1, 1));
        }
        open.extend(row.keys().cloned());
        rows.insert(state, row);
    }
    rows
}

fn naive_choices<'m>(model: &'m Model, state: &[i64]) -> Vec<Vec<&'m Command>> {
    let enabled = |c: &&Command| c.guard.eval_bool(state).unwrap();
    let all = || model.modules.iter().flat_map(|m| &m.commands);
    let mut choices: Vec<Vec<&Command>> = all()
        .filter(|c| c.action.is_none())
        .filter(enabled)
        .map(|c| vec![c])
        .collect();
    for action in 0..model.actions.len() {
        let mut tuples: Vec<Vec<&Command>> = vec![Vec::new()];
        for module in &model.modules {
            let of_action: Vec<&Command> = module
                .commands
                .iter()
                .filter(|c| c.action == Some(action))
                .collect();
            if of_action.is_empty() {
                continue;
            }
            let ready: Vec<&Command> = of_action.into_iter().filter(enabled).collect();
            let extend = |t: &Vec<&'m Command>| {
                let t = t.clone();
                ready
                    .clone()
                    .into_iter()
                    .map(move |c| [t.clone(), vec![c]].concat())
            };
            tuples = tuples.iter().flat_map(extend).collect();
        }
        choices.extend(tuples);
    }
    choices
}

fn naive_outcomes(commands: &[&Command], state: &[i64]) -> Vec<(Vec<i64>, Rational)> {
    let mut outcomes = vec![(state.to_vec(), rational(1, 1))];
    for command in commands {
        let mut next = Vec::new();
        for (target, probability) in &outcomes {
            for update in &command.updates {
                let factor: Rational = update.probability.eval_number(state).unwrap();
                let mut target = target.clone();
                for (variable, value) in &update.assignments {
                    target[*variable] = value.eval_int(state).unwrap();
                }
                next.push((target, probability * factor));
            }
        }
        outcomes = next;
    }
    outcomes.retain(|(_, p)| *p != rational(0, 1));
    outcomes
}

/// A guard over the variables `x0`, `x1`, `x2`, each with range 0..3.
fn guard() -> impl Strategy<Value = String> {
    let atom = (
        0..3,
        prop::sample::select(vec!["=", "!=", "<", "<=", ">", ">="]),
        0..4,
    )
        .prop_map(|(v, op, c)| format!("x{v}{op}{c}"));
    let other = prop::sample::select(vec![
        "true",
        "mod(x0+x1,2)=0",
        "x0*0.5<x1",
        "2>x2",
        "x0=x1",
        "min(x1,x2)<2",
    ])
    .prop_map(str::to_owned);
    prop_oneof![3 => atom, 1 => other].prop_recursive(2, 6, 2, |inner| {
        prop_oneof![
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a} & {b})")),
            (inner.clone(), inner.clone()).prop_map(|(a, b)| format!("({a} | {b})")),
            inner.prop_map(|a| format!("!({a})")),
        ]
    })
}

fn command(module: usize) -> impl Strategy<Value = String> {
    let value = prop::sample::select(vec![
        "0",
        "1",
        "3",
        "mod(x0+1,4)",
        "3-x1",
        "x2>1 ? 0 : x2+1",
    ]);
    let action = prop::sample::select(vec!["", "a", "b"]);
    let weights = prop::sample::select(vec![
        vec!["1"],
        vec!["0.5", "0.5"],
        vec!["1/3", "1-1/3"],
        vec!["x0/3", "1-x0/3"],
        vec!["0.1", "0", "0.9"],
    ]);
    (action, guard(), weights, prop::collection::vec(value, 3)).prop_map(
        move |(action, guard, weights, values)| {
            let updates: Vec<String> = weights
                .iter()
                .zip(&values)
                .map(|(w, v)| format!("{w}:(x{module}'={v})"))
                .collect();
            format!("[{action}] {guard} -> {};", updates.join(" + "))
        },
    )
}

fn random_model() -> impl Strategy<Value = String> {
    let module = |i: usize| {
        prop::collection::vec(command(i), 0..5).prop_map(move |commands| {
            format!(
                "module m{i} x{i} : [0..3]; {} endmodule",
                commands.join(" ")
            )
        })
    };
    (module(0), module(1), module(2)).prop_map(|(a, b, c)| format!("dtmc {a} {b} {c}"))
}

fn rows_of(space: &StateSpace<Rational>) -> BTreeMap<Vec<i64>, Row> {
    let row = |state| {
        space
            .matrix
            .row(state)
            .map(|(t, p)| (space.state(t), p.clone()))
            .collect()
    };
    (0..space.num_states())
        .map(|s| (space.state(s), row(s)))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn exploring_agrees_with_the_naive_interpreter(text in random_model()) {
        let model = model(&text);
        let exact = explore::<Rational>(&model).unwrap();
        let expected = naive(&model, vec![0, 0, 0]);
        prop_assert_eq!(rows_of(&exact), expected, "{}", text);
        for state in 0..exact.num_states() {
            let sum: Rational = exact.matrix.row(state).map(|(_, p)| p.clone()).sum();
            prop_assert_eq!(sum, rational(1, 1));
        }
        let rounded = explore::<f64>(&model).unwrap();
        prop_assert_eq!(&rounded.matrix.column, &exact.matrix.column);
        prop_assert_eq!(&rounded.matrix.row_start, &exact.matrix.row_start);
        prop_assert_eq!(rounded.deadlocks(), exact.deadlocks());
        let error = Rational::from_float(rounded.relative_error()).unwrap();
        for (found, exact) in rounded.matrix.value.iter().zip(&exact.matrix.value) {
            let found = Rational::from_float(*found).unwrap();
            let difference = if found > *exact { &found - exact } else { exact - &found };
            prop_assert!(difference <= &error * exact, "{} against {}", found, exact);
        }
    }
}

#[test]
fn states_are_numbered_breadth_first_and_deadlocks_get_a_loop() {
    let space = explore::<f64>(&model(
        "dtmc module m x : [0..9]; [] x=0 -> 0.25:(x'=5) + 0.75:(x'=3); [] x=5 -> (x'=7); endmodule label \"odd\" = mod(x,2)=1;",
    ))
    .unwrap();
    let values: Vec<i64> = (0..space.num_states()).map(|s| space.value(s, 0)).collect();
    assert_eq!(values, [0, 5, 3, 7]);
    assert_eq!(space.deadlocks(), [2, 3]);
    assert_eq!(space.matrix.row(2).collect::<Vec<_>>(), [(2, &1.0)]);
    assert_eq!(space.label("odd"), Ok(vec![false, true, true, true]));
    assert_eq!(space.label("init"), Ok(vec![true, false, false, false]));
    assert_eq!(space.label("deadlock"), Ok(vec![false, false, true, true]));
    assert_eq!(space.describe(1), "(x=5)");
    assert_eq!(space.relative_error(), 0.0);
}

#[test]
fn choices_are_uniform_and_parallel_transitions_merge() {
    let text = "dtmc module m x : [0..1]; [] x=0 -> (x'=1); [] x=0 -> true; [a] x=0 -> (x'=1); [] x=1 -> true; endmodule";
    let space = explore::<Rational>(&model(text)).unwrap();
    let row: Vec<_> = space.matrix.row(0).collect();
    assert_eq!(row, [(0, &rational(1, 3)), (1, &rational(2, 3))]);
    assert_eq!(
        (space.num_transitions(), space.num_labelled_transitions()),
        (3, 4)
    );
}

#[test]
fn initial_states_may_be_many() {
    let text = "dtmc module m x : [0..4]; b : bool; [] x<4 -> (x'=x+1); endmodule init x=1 & b | x=3 endinit";
    let space = explore::<f64>(&model(text)).unwrap();
    let initial: Vec<Vec<i64>> = space
        .initial_states()
        .iter()
        .map(|s| space.state(*s))
        .collect();
    assert_eq!(initial, [vec![1, 1], vec![3, 0], vec![3, 1]]);
    assert_eq!(space.num_states(), 6);
    let none = model("dtmc module m x : [0..4]; endmodule init x>4 endinit");
    assert!(matches!(
        explore::<f64>(&none),
        Err(ExploreError::NoInitialState { .. })
    ));
    let many = model("dtmc module m x : [0..99999]; y : [0..99999]; endmodule init x=y endinit");
    assert!(matches!(
        explore::<f64>(&many),
        Err(ExploreError::TooManyCandidates { .. })
    ));
}

#[test]
fn what_goes_wrong_is_told_with_state_and_place() {
    let check = |text: &str, place: &str, message: &str| {
        let error = explore::<f64>(&model(text)).unwrap_err();
        assert_eq!(error.span().map(|s| s.of(text)), Some(place), "{error}");
        assert!(error.to_string().starts_with(message), "{error}");
    };
    check(
        "dtmc module m x : [0..3]; [] true -> (x'=x+1); endmodule",
        "x+1",
        "in state (x=3), this update would set `x` to 4, out of its range 0..3",
    );
    check(
        "dtmc module m x : [0..3]; [] true -> x/2:(x'=1) + 0.5:(x'=2); endmodule",
        "[] true -> x/2:(x'=1) + 0.5:(x'=2);",
        "in state (x=0), the probabilities of this command sum to 0.5, not to 1",
    );
    check(
        "dtmc module m x : [0..3]; [] true -> x-1:(x'=1) + 2-x:(x'=2); endmodule",
        "x-1",
        "in state (x=0), this probability is -1",
    );
    check(
        "dtmc module m x : [0..3]; [] 1/x>0 -> (x'=1); endmodule",
        "1/x",
        "in state (x=0), this divides by zero",
    );
    check(
        "dtmc const double p = 1e-400; module m x : [0..3]; [] true -> p:(x'=1) + 1-p:true; endmodule",
        "p",
        "in state (x=0), this probability is positive but too small for a double",
    );
}

#[test]
fn exact_exploring_refuses_what_is_not_exact() {
    let nearly = "dtmc const double p = 0.3333333333333333; module m x : [0..3]; [] true -> p:(x'=1) + p:(x'=2) + p:(x'=3); endmodule";
    assert!(explore::<f64>(&model(nearly)).is_ok());
    assert!(matches!(
        explore::<Rational>(&model(nearly)),
        Err(ExploreError::ProbabilitySum { .. })
    ));
    let root = model(
        "dtmc const double p = pow(0.5, 0.5); module m x : [0..3]; [] true -> p:(x'=1) + 1-p:true; endmodule",
    );
    assert!(matches!(
        explore::<Rational>(&root),
        Err(ExploreError::NoValue { .. })
    ));
    assert_eq!(
        explore::<f64>(&root).unwrap().relative_error(),
        f64::INFINITY
    );
}

#[test]
fn exploring_can_be_limited_and_cancelled() {
    let counter = model("dtmc module m x : [0..999999]; [] x<999999 -> (x'=x+1); endmodule");
    let limited = explore_with::<f64>(
        &counter,
        ExploreOptions {
            max_states: 1000,
            ..ExploreOptions::default()
        },
        &|_| true,
    );
    assert_eq!(
        limited.unwrap_err(),
        ExploreError::TooManyStates { limit: 1000 }
    );
    let cancelled =
        explore_with::<f64>(&counter, ExploreOptions::default(), &|states| states < 5000);
    assert_eq!(cancelled.unwrap_err(), ExploreError::Cancelled);
}

#[test]
fn wide_states_take_several_words() {
    let variables: String = (0..20).map(|i| format!("v{i} : [-1000..1000];")).collect();
    let text = format!(
        "dtmc module m {variables} [] v19<3 -> 0.5:(v19'=v19+1)&(v0'=-v19) + 0.5:(v10'=1000); endmodule"
    );
    let space = explore::<f64>(&model(&text)).unwrap();
    let distinct: BTreeSet<Vec<i64>> = (0..space.num_states()).map(|s| space.state(s)).collect();
    assert_eq!(distinct.len(), space.num_states());
    assert_eq!(space.num_states(), 2 * 1004);
}
