//! Random chains and decision processes that are one large component with some ways out: what the sound method finds by linear
//! equations, and proves by slack, has to lie around the exact optimum.

use checker::explore::explore;
use checker::{AnswerValue, Guarantee, Method, Options, check};
use num_traits::ToPrimitive;
use prism_lang::{Constants, Rational, parse_model, parse_properties, resolve, resolve_properties};
use proptest::prelude::*;
use std::fmt::Write;

/// A branch: how far to go on the ring of states (or out, to one end or the other), with a weight.
#[derive(Clone, Copy, Debug)]
enum Branch {
    Along(i32, u32),
    Out(usize, u32),
}

/// The choices of one state, each a distribution, and what the state earns.
type State = (Vec<Vec<Branch>>, u32);

fn arbitrary_choice() -> impl Strategy<Value = Vec<Branch>> {
    let step = prop_oneof![Just(-2), Just(-1), Just(1), Just(1), Just(2), -30i32..30];
    let along = (
        step,
        1u32..10,
        prop_oneof![Just(1u32), Just(10), Just(1000)],
    )
        .prop_map(|(step, weight, scale)| Branch::Along(step, weight * scale));
    let out =
        (0usize..2, prop_oneof![Just(1u32), Just(5)]).prop_map(|(end, w)| Branch::Out(end, w));
    // One choice in five leads out, too.
    (
        prop::collection::vec(along, 1..4),
        prop::option::weighted(0.2, out),
    )
        .prop_map(|(mut branches, out)| {
            branches.extend(out);
            branches
        })
}

fn arbitrary_states(choices: usize) -> impl Strategy<Value = Vec<State>> {
    let choices = prop::collection::vec(arbitrary_choice(), 1..=choices);
    let reward = prop_oneof![Just(0u32), Just(1), Just(7)];
    prop::collection::vec((choices, reward), 60..100)
}

/// The model in the PRISM language: the ring, then two ends.
fn text(kind: &str, states: &[State]) -> String {
    let count = states.len();
    let mut text = format!("{kind}\nmodule walk\n  s : [0..{}];\n", count + 1);
    for (state, (choices, _)) in states.iter().enumerate() {
        for branches in choices {
            let targets: Vec<(usize, u32)> = branches
                .iter()
                .map(|branch| match *branch {
                    Branch::Along(step, weight) => {
                        let to = (state as i32 + step).rem_euclid(count as i32);
                        (to as usize, weight)
                    }
                    Branch::Out(end, weight) => (count + end, weight),
                })
                .collect();
            let sum: u32 = targets.iter().map(|(_, weight)| weight).sum();
            let updates: Vec<String> = targets
                .iter()
                .map(|(to, weight)| format!("{weight}/{sum} : (s'={to})"))
                .collect();
            let _ = writeln!(text, "  [] s={state} -> {};", updates.join(" + "));
        }
    }
    let _ = writeln!(text, "  [] s>={count} -> true;\nendmodule\nrewards");
    for (state, (_, reward)) in states.iter().enumerate() {
        let _ = writeln!(text, "  s={state} : {reward};");
    }
    text + "endrewards\n"
}

/// Holds the bounds of each question against its exact value.
fn assert_around(text: &str, questions: &[String]) {
    let model = resolve(&parse_model(text).tree, &Constants::new()).expect("a sound model");
    let space = explore::<f64>(&model).expect("states");
    for question in questions {
        let parsed = parse_properties(question);
        let properties = resolve_properties(&parsed.tree, &model, &Constants::new());
        let property = &properties.expect("a sound question")[0].property;
        let answer = |method| {
            let answer = check(&space, &model, property, &Options::with_method(method));
            answer.unwrap_or_else(|error| panic!("{question}: {error:?}"))
        };
        let (exact, sound) = (answer(Method::Exact), answer(Method::Sound));
        let Guarantee::Bounded { low, high } = sound.guarantee else {
            assert!(sound.guarantee == Guarantee::Exact, "{question}: {sound:?}");
            continue;
        };
        let AnswerValue::Exact(exact) = exact.value else {
            // Infinite for both.
            assert!(low.is_infinite(), "{question}: {exact:?}, {sound:?}");
            continue;
        };
        let of = |bound: f64| Rational::from_float(bound).expect("a finite bound");
        assert!(
            of(low) <= exact && exact <= of(high),
            "{question}: {exact} and {low} to {high}"
        );
        let wide = high - low;
        let value = exact.to_f64().unwrap_or(f64::NAN);
        assert!(wide <= 1e-6 * value, "{question}: {value}, {wide} wide");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, max_shrink_iters: 40, ..ProptestConfig::default() })]

    #[test]
    fn bounds_of_a_chain_are_around_its_exact_values(states in arbitrary_states(1)) {
        let end = states.len();
        let questions = [
            format!("P=? [ F s={end} ]"),
            format!("P=? [ s!={} U s={} ]", end / 2, end + 1),
            format!("R=? [ F s>={end} ]"),
        ];
        assert_around(&text("dtmc", &states), &questions);
    }

    #[test]
    fn bounds_of_a_decision_process_are_around_its_exact_optima(states in arbitrary_states(3)) {
        let end = states.len();
        let questions = ["min", "max"].map(|optimum| {
            [
                format!("P{optimum}=? [ F s={end} ]"),
                format!("P{optimum}=? [ s!={} U s={} ]", end / 2, end + 1),
                format!("R{optimum}=? [ F s>={end} ]"),
            ]
        });
        assert_around(&text("mdp", &states), &questions.concat());
    }
}
