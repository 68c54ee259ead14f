//! Probabilities over fair schedulers: small models worked out by hand, and random ones against schedulers that take
//! every choice of a state with at least a small probability, which are all fair and come as near as one likes.

use checker::explore::explore;
use checker::{AnswerValue, CheckError, Guarantee, Method, Options, check_exact, check_space};
use prism_lang::{
    Constants, Rational, parse_model, parse_properties, rational_to_f64, resolve,
    resolve_properties,
};
use proptest::prelude::*;

/// The exact value of a property.
fn exactly(model: &str, property: &str, fair: bool) -> Result<Rational, CheckError> {
    let model = resolve(&parse_model(model).tree, &Constants::new()).unwrap();
    let properties = parse_properties(property).tree;
    let properties = resolve_properties(&properties, &model, &Constants::new()).unwrap();
    let options = Options {
        fair,
        ..Options::with_method(Method::Exact)
    };
    let space = explore::<Rational>(&model).unwrap();
    match check_exact(&space, &properties[0].property, &options)?.value {
        AnswerValue::Exact(value) => Ok(value),
        other => panic!("{other:?}"),
    }
}

/// The exact value over fair schedulers, which the bounds of the sound method have to contain.
fn fairly(model: &str, property: &str) -> Result<Rational, CheckError> {
    let exact = exactly(model, property, true)?;
    let model = resolve(&parse_model(model).tree, &Constants::new()).unwrap();
    let properties = parse_properties(property).tree;
    let properties = resolve_properties(&properties, &model, &Constants::new()).unwrap();
    let options = Options {
        fair: true,
        ..Options::default()
    };
    let space = explore::<f64>(&model).unwrap();
    let answer = check_space(&space, &properties[0].property, &options)?;
    let value = rational_to_f64(&exact);
    match (answer.value, answer.guarantee) {
        (AnswerValue::Number(near), Guarantee::Exact) => assert_eq!(near, value),
        (_, Guarantee::Bounded { low, high }) => assert!(low <= value && value <= high),
        other => panic!("{other:?}"),
    }
    Ok(exact)
}

fn q(above: i64, below: i64) -> Rational {
    Rational::new(above.into(), below.into())
}

/// From 0 to a state with a loop, and by its other choice on to 2 or 3.
const WAITING: &str = "mdp module m s : [0..3];
    [] s=0 -> (s'=1);
    [] s=1 -> (s'=0);
    [] s=1 -> 1/3:(s'=2) + 2/3:(s'=3);
    [] s>1 -> true;
endmodule";

#[test]
fn a_fair_scheduler_does_not_wait_for_ever() {
    for (property, all, fair) in [
        ("Pmin=? [ F s=2 ]", q(0, 1), q(1, 3)),
        ("Pmin=? [ F s>1 ]", q(0, 1), q(1, 1)),
        ("Pmin=? [ s!=3 U s=2 ]", q(0, 1), q(1, 3)),
        ("Pmax=? [ G s<2 ]", q(1, 1), q(0, 1)),
        ("Pmax=? [ s<2 W s=3 ]", q(1, 1), q(2, 3)),
        ("Pmax=? [ F s=2 ]", q(1, 3), q(1, 3)),
        // Both by automata.
        ("Pmax=? [ G F s=0 ]", q(1, 1), q(0, 1)),
        ("Pmin=? [ F (s=1 & (X s=2)) ]", q(0, 1), q(1, 3)),
        // Within steps it may wait.
        ("Pmin=? [ F<=50 s=2 ]", q(0, 1), q(0, 1)),
        ("Pmax=? [ G<=50 s<2 ]", q(1, 1), q(1, 1)),
        ("Pmin=? [ F>=2 s=2 ]", q(0, 1), q(1, 3)),
    ] {
        assert_eq!(
            exactly(WAITING, property, false).unwrap(),
            all,
            "{property}"
        );
        assert_eq!(fairly(WAITING, property).unwrap(), fair, "{property}");
    }
}

/// From 0 to 1 or 2 and back.
const ALTERNATING: &str = "mdp module m s : [0..2];
    [] s=0 -> (s'=1);
    [] s=0 -> (s'=2);
    [] s>0 -> (s'=0);
endmodule";

#[test]
fn a_fair_scheduler_may_remember() {
    for (property, value) in [
        // Taking turns is fair, though in each state of the automaton one choice is never taken.
        (
            "Pmax=? [ (G (s=1 => (X X s=2))) & (G (s=2 => (X X s=1))) ]",
            q(1, 1),
        ),
        // Always the same one is not.
        ("Pmax=? [ F G s!=2 ]", q(0, 1)),
        ("Pmin=? [ (G F s=1) & (G F s=2) ]", q(1, 1)),
    ] {
        assert_eq!(fairly(ALTERNATING, property).unwrap(), value, "{property}");
    }
}

#[test]
fn what_fairness_would_change_is_computed_or_refused() {
    let rewards = "rewards true : 1; endrewards";
    let model = format!("{WAITING} {rewards}");
    // The quickest way is fair once it has arrived.
    assert_eq!(fairly(&model, "Rmin=? [ F s>1 ]").unwrap(), q(2, 1));
    assert_eq!(fairly(&model, "Rmax=? [ C<=5 ]").unwrap(), q(5, 1));
    for property in [
        "Rmax=? [ F s>1 ]",
        "Rmin=? [ C ]",
        "Rmax=? [ S ]",
        "Pmax=? [ F s=2 ] + (E [ G s<2 ] ? 1 : 0)",
        "multi(Pmax=? [ F s=2 ], P>=0.1 [ F s=3 ])",
    ] {
        let found = exactly(&model, property, true);
        let refused = matches!(&found, Err(CheckError::Unsupported(why)) if why.contains("fair"));
        assert!(refused, "{property}: {found:?}");
    }
}

/// A state's choices, each with weights of targets.
type Weights = Vec<Vec<Vec<u32>>>;

/// The model; every choice of a state is mixed with all of that state's choices, in the share `mixed`.
fn text(choices: &Weights, mixed: &Rational) -> String {
    let states = choices.len();
    let mut text = format!("mdp module m s : [0..{}];\n", states - 1);
    for (state, rows) in choices.iter().enumerate() {
        let rows: Vec<Vec<Rational>> = rows.iter().map(|row| probabilities(row, state)).collect();
        let count = q(rows.len() as i64, 1);
        for row in &rows {
            let entry = |target: usize| {
                let all: Rational = rows.iter().map(|row| &row[target]).sum();
                &row[target] * (q(1, 1) - mixed) + all * mixed / &count
            };
            let parts: Vec<String> = (0..states)
                .map(|target| (target, entry(target)))
                .filter(|(_, p)| *p > q(0, 1))
                .map(|(target, p)| format!("{p}:(s'={target})"))
                .collect();
            text += &format!("[] s={state} -> {};\n", parts.join(" + "));
        }
    }
    text + "endmodule"
}

/// Weights as probabilities; without any, the state is kept.
fn probabilities(weights: &[u32], state: usize) -> Vec<Rational> {
    let total: u32 = weights.iter().sum();
    let weight = |(target, weight): (usize, &u32)| match total {
        0 => q(i64::from(target == state), 1),
        _ => q(i64::from(*weight), i64::from(total)),
    };
    weights.iter().enumerate().map(weight).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]
    #[test]
    fn fair_schedulers_are_approached_by_those_that_take_every_choice(
        choices in prop::collection::vec(
            prop::collection::vec(
                prop::collection::vec(prop_oneof![3 => Just(0u32), 1 => 1u32..3], 5),
                1..4,
            ),
            5,
        ),
    ) {
        let own = text(&choices, &q(0, 1));
        let mixed = text(&choices, &q(1, 1_000_000_000));
        for property in [
            "Pmin=? [ F s=4 ]",
            "Pmin=? [ s!=3 U s=4 ]",
            "Pmax=? [ s!=3 U s=4 ]",
            "Pmax=? [ G s<4 ]",
            "Pmax=? [ s<3 W s=4 ]",
            "Pmax=? [ F G s>2 ]",
            "Pmin=? [ F G s>2 ]",
            "Pmax=? [ G F s=4 ]",
            "Pmin=? [ G F s=4 ]",
            "Pmax=? [ (F s=3) & (F G s<4) ]",
        ] {
            let fair = fairly(&own, property).unwrap();
            let near = exactly(&mixed, property, false).unwrap();
            let distance = rational_to_f64(&(fair.clone() - near.clone())).abs();
            prop_assert!(distance < 1e-5, "{property}: {fair} but {near}\n{own}");
        }
    }
}
