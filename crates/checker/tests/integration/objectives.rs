//! Several objectives and conditional probabilities: by hand, and on random decision processes against all their
//! memoryless schedulers and against each other. All in rational arithmetic.

use checker::explore::explore;
use checker::state_space::{Csr, StateSpace};
use checker::{AnswerValue, Guarantee, Method, Options, check, check_exact};
use prism_lang::ast::Optimum;
use prism_lang::property::{Objective, Quantity};
use prism_lang::resolved::ModelType;
use prism_lang::{
    Comparison, Constants, Number, Path, Property, Rational, StateFormula, TimeBound, parse_model,
    parse_properties, resolve, resolve_properties,
};
use proptest::prelude::*;

fn rational(n: i64, d: i64) -> Rational {
    Rational::new(n.into(), d.into())
}

fn finally(label: &str) -> Path {
    let label = StateFormula::Label(label.to_owned());
    Path::Finally {
        operand: Box::new(Path::State(Box::new(label))),
        bound: TimeBound::default(),
    }
}

fn optimise(optimum: Optimum, path: Path) -> Objective {
    let path = Box::new(path);
    let optimum_asked = Some(optimum);
    Objective::Optimise(
        optimum,
        Quantity::Probability {
            optimum: optimum_asked,
            path,
        },
    )
}

fn at_least(bound: Rational, path: Path) -> Objective {
    Objective::Require(StateFormula::Probability {
        bound: (Comparison::GreaterEqual, Number::from_rational(bound)),
        path: Box::new(path),
    })
}

fn answer(space: &StateSpace<Rational>, property: &Property) -> AnswerValue {
    check_exact(space, property, &Options::default())
        .unwrap()
        .value
}

fn corners(space: &StateSpace<Rational>, objectives: Vec<Objective>) -> Vec<Vec<Rational>> {
    match answer(space, &Property::Objectives(objectives)) {
        AnswerValue::Corners(corners) => corners,
        other => panic!("no corners: {other:?}"),
    }
}

fn of_text(text: &str, property: &str) -> (AnswerValue, Guarantee) {
    let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    let asked = parse_properties(property);
    assert!(asked.diagnostics.is_empty(), "{:?}", asked.diagnostics);
    let asked = resolve_properties(&asked.tree, &model, &Constants::new()).unwrap();
    let space = explore::<f64>(&model).unwrap();
    let found = check(&space, &model, &asked[0].property, &Options::default()).unwrap();
    if matches!(found.value, AnswerValue::Number(_)) {
        let exactly = Options::with_method(Method::Exact);
        let exact = check(&space, &model, &asked[0].property, &exactly).unwrap();
        let (exact, found) = match (exact.value, &found.value) {
            (AnswerValue::Exact(exact), AnswerValue::Number(found)) => (exact, found),
            (AnswerValue::Number(exact), AnswerValue::Number(found))
                if exact.is_nan() && found.is_nan() =>
            {
                return (AnswerValue::Number(f64::NAN), Guarantee::Exact);
            }
            other => panic!("{other:?}"),
        };
        assert!(
            (prism_lang::rational_to_f64(&exact) - found).abs() < 1e-9,
            "{exact} {found}"
        );
    }
    (found.value, found.guarantee)
}

/// A robot that may carry on (and may fail) or stop.
const ROBOT: &str = "mdp
module robot
  s : [0..3] init 0; // 1: delivered, 2: broken, 3: given up
  [carry] s=0 -> 1/2:(s'=1) + 1/4:(s'=2) + 1/4:(s'=0);
  [stop] s=0 -> (s'=3);
  [] s>0 -> true;
endmodule
rewards \"energy\" [carry] true : 3; endrewards";

#[test]
fn bounds_that_are_met_exactly_are_decided() {
    // Carrying on for ever delivers with 2/3; a mixture with stopping gives up with the rest.
    let truth = |property: &str| of_text(ROBOT, property).0;
    let exactly = "multi(P>=1/3 [ F s=1 ], P>=1/2 [ F s=3 ])";
    assert_eq!(truth(exactly), AnswerValue::Truth(true));
    let more = "multi(P>1/3 [ F s=1 ], P>=1/2 [ F s=3 ])";
    assert_eq!(truth(more), AnswerValue::Truth(false));
    let fewer = "multi(P>=1/3 [ F s=1 ], P<=1/6 [ F s=2 ], R{\"energy\"}<=2 [ C ])";
    assert_eq!(truth(fewer), AnswerValue::Truth(true));
    let too_few = "multi(P>=1/3 [ F s=1 ], R{\"energy\"}<2 [ C ])";
    assert_eq!(truth(too_few), AnswerValue::Truth(false));
}

#[test]
fn the_best_value_under_bounds_and_the_curve_are_those_by_hand() {
    let (value, guarantee) = of_text(ROBOT, "multi(Pmax=? [ F s=1 ], P<=1/7 [ F s=2 ])");
    let AnswerValue::Number(value) = value else {
        panic!("{value:?}")
    };
    assert!((value - 2.0 / 7.0).abs() < 1e-15);
    assert!(matches!(guarantee, Guarantee::Bounded { low, high } if low <= value && value <= high));
    let (value, _) = of_text(ROBOT, "multi(R{\"energy\"}min=? [ C ], P>=1/2 [ F s=1 ])");
    assert_eq!(value, AnswerValue::Number(3.0));
    // Two attempts: the first delivers with 1/2, the second with 1/8.
    let (value, _) = of_text(ROBOT, "multi(R{\"energy\"}max=? [ C<=2 ], P>=0 [ F s=1 ])");
    assert_eq!(value, AnswerValue::Number(3.75));
    let (value, _) = of_text(ROBOT, "multi(Pmax=? [ F s=1 ], Pmin=? [ F s=2 ])");
    let expected = vec![
        vec![rational(0, 1), rational(0, 1)],
        vec![rational(2, 3), rational(1, 3)],
    ];
    assert_eq!(value, AnswerValue::Corners(expected));
    let (value, _) = of_text(
        ROBOT,
        "multi(Pmax=? [ F s=1 ], P>=0.9 [ F s=3 ], P>=0.2 [ F s=1 ])",
    );
    assert!(
        matches!(value, AnswerValue::Number(value) if value.is_nan()),
        "{value:?}"
    );
}

#[test]
fn conditional_probabilities_are_those_by_hand() {
    let chain = ROBOT
        .replace("mdp", "dtmc")
        .replace("[stop] s=0 -> (s'=3);", "");
    let close = |property: &str, of_chain: f64, greatest: f64| {
        for text in [&chain, ROBOT] {
            let property = match text == ROBOT {
                true => property.replacen("P=?", "Pmax=?", 1),
                false => property.to_owned(),
            };
            let expected = if text == ROBOT { greatest } else { of_chain };
            let (value, _) = of_text(text, &property);
            let AnswerValue::Number(value) = value else {
                panic!("{value:?}")
            };
            assert!(
                (value - expected).abs() < 1e-9,
                "{property}: {value} {expected}"
            );
        }
    };
    // At the first attempt, given that it is ever delivered: 1/2 of 2/3; for certain if there is one attempt only.
    close("P=? [ X s=1 || F s=1 ]", 0.75, 1.0);
    // Given that nothing breaks at the first step.
    let later = (0.5 + 0.25 * 2.0 / 3.0) / 0.75;
    close("P=? [ F s=1 || X s!=2 ]", later, later);
    let (value, _) = of_text(ROBOT, "Pmin=? [ X s=1 || F s=1 ]");
    assert!(
        matches!(value, AnswerValue::Number(value) if (value - 0.75).abs() < 1e-6),
        "{value:?}"
    );
    let (value, _) = of_text(&chain, "P>=0.75 [ X s=1 || F s=1 ]");
    assert_eq!(value, AnswerValue::Truth(true));
    let (value, _) = of_text(&chain, "P=? [ F s=1 || F s=3 ]");
    assert!(
        matches!(value, AnswerValue::Number(value) if value.is_nan()),
        "{value:?}"
    );
}

/// A random process with up to four states; labels `a`, `b` in the last two.
fn process() -> impl Strategy<Value = StateSpace<Rational>> {
    let weight = prop_oneof![3 => Just(0u32), 2 => 1u32..4];
    let row = prop::collection::vec(weight, 4);
    let choices = prop::collection::vec(row, 1..=3);
    prop::collection::vec(choices, 4).prop_map(|weights| {
        let (mut rows, mut start) = (Vec::new(), vec![0]);
        for (state, choices) in weights.iter().enumerate() {
            for weights in choices {
                let total: u32 = weights.iter().sum();
                let entry =
                    |(to, w): (usize, &u32)| (to as u32, Rational::new((*w).into(), total.into()));
                rows.push(match total {
                    0 => vec![(state as u32, rational(1, 1))],
                    _ => weights
                        .iter()
                        .enumerate()
                        .filter(|(_, w)| **w > 0)
                        .map(entry)
                        .collect(),
                });
            }
            start.push(rows.len());
        }
        let only = |state: usize| (0..4).map(|s| s == state).collect::<Vec<bool>>();
        let labels = vec![("a".to_owned(), only(2)), ("b".to_owned(), only(3))];
        StateSpace::from_parts(ModelType::Mdp, Csr::from_rows(rows), start, vec![0], labels)
    })
}

/// All chains that memoryless schedulers induce.
fn chains(space: &StateSpace<Rational>) -> Vec<StateSpace<Rational>> {
    let mut all = vec![Vec::new()];
    for state in 0..space.num_states() {
        let longer = |rows: &Vec<Option<usize>>| {
            let rows = rows.clone();
            space
                .choices(state)
                .map(move |row| [&rows[..], &[Some(row)]].concat())
        };
        all = all.iter().flat_map(longer).collect();
    }
    all.iter()
        .map(|scheduler| space.induced(scheduler))
        .collect()
}

fn probability(space: &StateSpace<Rational>, path: Path) -> Rational {
    match answer(space, &Property::Probability { bound: None, path }) {
        AnswerValue::Exact(value) => value,
        other => panic!("no number: {other:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_scheduler_does_better_than_the_curve(space in process()) {
        let both = vec![optimise(Optimum::Max, finally("a")), optimise(Optimum::Max, finally("b"))];
        let curve = corners(&space, both);
        // The ends of the curve are the greatest values.
        let most = |label: &str| {
            let path = Box::new(finally(label));
            let optimum = Some(Optimum::Max);
            match answer(&space, &Property::Number(Quantity::Probability { optimum, path })) {
                AnswerValue::Exact(value) => value,
                other => panic!("no number: {other:?}"),
            }
        };
        prop_assert_eq!(&curve.last().unwrap()[0], &most("a"));
        prop_assert_eq!(&curve[0][1], &most("b"));
        for corner in &curve {
            let required = vec![at_least(corner[0].clone(), finally("a")), at_least(corner[1].clone(), finally("b"))];
            prop_assert_eq!(answer(&space, &Property::Objectives(required)), AnswerValue::Truth(true));
        }
        for chain in chains(&space).iter().take(12) {
            let (a, b) = (probability(chain, finally("a")), probability(chain, finally("b")));
            let asked = vec![optimise(Optimum::Max, finally("a")), at_least(b, finally("b"))];
            let AnswerValue::Exact(best) = answer(&space, &Property::Objectives(asked)) else {
                panic!("the bound is met by the scheduler")
            };
            prop_assert!(best >= a, "{} {}", best, a);
        }
    }

    #[test]
    fn conditional_probabilities_are_the_steepest_corner(space in process()) {
        let path = Path::Next(Box::new(finally("a")));
        let given = finally("b");
        let both = Path::And(Box::new(path.clone()), Box::new(given.clone()));
        let contrary = Path::Not(Box::new(given.clone()));
        let curve = corners(&space, vec![optimise(Optimum::Max, both), optimise(Optimum::Max, contrary)]);
        let one = rational(1, 1);
        let ratio = |corner: &Vec<Rational>| (corner[1] < one).then(|| &corner[0] / (&one - &corner[1]));
        let expected = curve.iter().filter_map(ratio).max();
        let optimum = Some(Optimum::Max);
        let asked = Quantity::Conditional { optimum, path: Box::new(path.clone()), condition: Box::new(given.clone()) };
        match (answer(&space, &Property::Number(asked)), expected) {
            (AnswerValue::Exact(found), Some(expected)) => prop_assert_eq!(found, expected),
            // No scheduler meets the condition (or the curve ends in giving it up).
            (AnswerValue::Exact(found), None) => prop_assert_eq!(found, rational(0, 1)),
            (AnswerValue::Number(found), expected) => {
                prop_assert!(found.is_nan() && expected.is_none(), "{} {:?}", found, expected);
            }
            (other, _) => prop_assert!(false, "{:?}", other),
        }
        for chain in chains(&space).iter().take(12) {
            let possible = probability(chain, given.clone());
            if possible > rational(0, 1) {
                let both = Path::And(Box::new(path.clone()), Box::new(given.clone()));
                let value = probability(chain, both) / possible;
                for (optimum, order) in [(Optimum::Max, false), (Optimum::Min, true)] {
                    let asked = Quantity::Conditional {
                        optimum: Some(optimum), path: Box::new(path.clone()), condition: Box::new(given.clone()),
                    };
                    let AnswerValue::Exact(best) = answer(&space, &Property::Number(asked)) else {
                        panic!("the condition is possible")
                    };
                    prop_assert!(if order { best <= value } else { best >= value }, "{} {}", best, value);
                }
            }
        }
    }
}

#[test]
fn what_is_not_defined_is_not_a_number() {
    let (value, _) = of_text(ROBOT, "(1.0/0.0)/(1.0/0.0)");
    assert!(
        matches!(value, AnswerValue::Number(value) if value.is_nan()),
        "{value:?}"
    );
}
