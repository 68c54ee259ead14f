//! On random Markov chains: sound bounds contain the exact values, PRISM's iteration tends to them, and the
//! values of nested formulas agree with sampled paths judged by the definition of the logic.

use checker::state_space::{Csr, StateSpace};
use checker::{
    Answer, AnswerValue, Guarantee, Method, Options, check_exact, check_space, sample_path,
};
use num_traits::ToPrimitive;
use prism_lang::{
    Comparison, Number, Path, Property, Rational, StateFormula, TimeBound, rational_to_f64,
};
use proptest::prelude::*;
use temporal::ltl::{Ltl, StepBound};

const LABELS: [&str; 2] = ["a", "b"];

/// A chain by integer weights: row `i` has the entries `weights[i]` divided by their sum.
#[derive(Debug, Clone)]
struct Chain {
    weights: Vec<Vec<u32>>,
    labels: Vec<u8>,
}

impl Chain {
    fn exact(&self) -> StateSpace<Rational> {
        let row = |(state, weights): (usize, &Vec<u32>)| {
            let total: u32 = weights.iter().sum();
            if total == 0 {
                return vec![(state as u32, Rational::from_integer(1.into()))];
            }
            let entry = |(target, weight): (usize, &u32)| {
                (target as u32, Rational::new((*weight).into(), total.into()))
            };
            let positive = |(_, weight): &(usize, &u32)| **weight > 0;
            weights
                .iter()
                .enumerate()
                .filter(positive)
                .map(entry)
                .collect()
        };
        let rows = self.weights.iter().enumerate().map(row).collect();
        StateSpace::from_matrix(Csr::from_rows(rows), vec![0], self.label_sets())
    }

    fn rounded(&self) -> StateSpace<f64> {
        let exact = self.exact().matrix;
        let matrix = Csr {
            row_start: exact.row_start,
            column: exact.column,
            value: exact.value.iter().map(rational_to_f64).collect(),
        };
        StateSpace::from_matrix(matrix, vec![0], self.label_sets())
    }

    fn label_sets(&self) -> Vec<(String, Vec<bool>)> {
        let set = |bit: usize| self.labels.iter().map(|l| l >> bit & 1 == 1).collect();
        LABELS
            .iter()
            .enumerate()
            .map(|(bit, name)| ((*name).to_owned(), set(bit)))
            .collect()
    }
}

/// Up to `states` states; most weights are 0, some very different from each other if `uneven`.
fn arbitrary_chain(states: usize, uneven: bool) -> impl Strategy<Value = Chain> {
    let heavy = if uneven { 1_000_000 } else { 5 };
    let weight = prop_oneof![4 => Just(0u32), 3 => 1u32..4, 1 => Just(heavy)];
    (2..=states).prop_flat_map(move |states| {
        let row = prop::collection::vec(weight.clone(), states);
        let weights = prop::collection::vec(row, states);
        let labels = prop::collection::vec(0u8..4, states);
        (weights, labels).prop_map(|(weights, labels)| Chain { weights, labels })
    })
}

fn label(index: usize) -> Box<Path> {
    Box::new(Path::State(Box::new(StateFormula::Label(
        LABELS[index].to_owned(),
    ))))
}

fn arbitrary_window() -> impl Strategy<Value = TimeBound> + Clone {
    let lower = prop::option::of((0i64..4, any::<bool>()));
    let upper = prop::option::of((5i64..9, any::<bool>()));
    (lower, upper).prop_map(|(lower, upper)| TimeBound { lower, upper })
}

/// Path formulas, nested up to `depth`.
fn arbitrary_path(depth: u32) -> impl Strategy<Value = Path> {
    let leaf = (0usize..2).prop_map(|index| *label(index));
    leaf.prop_recursive(depth, 8, 2, |inner| {
        let one = inner.clone().prop_map(Box::new);
        let two = (
            inner.clone().prop_map(Box::new),
            inner.prop_map(Box::new),
            arbitrary_window(),
        );
        prop_oneof![
            one.clone().prop_map(Path::Not),
            one.clone().prop_map(Path::Next),
            (one.clone(), arbitrary_window())
                .prop_map(|(operand, bound)| Path::Finally { operand, bound }),
            (one, arbitrary_window())
                .prop_map(|(operand, bound)| Path::Globally { operand, bound }),
            two.clone()
                .prop_map(|(left, right, _)| Path::And(left, right)),
            two.clone()
                .prop_map(|(left, right, _)| Path::Or(left, right)),
            two.clone()
                .prop_map(|(left, right, _)| Path::Implies(left, right)),
            two.clone()
                .prop_map(|(left, right, _)| Path::Iff(left, right)),
            two.clone()
                .prop_map(|(left, right, bound)| Path::Until { left, right, bound }),
            two.clone()
                .prop_map(|(left, right, bound)| Path::WeakUntil { left, right, bound }),
            two.prop_map(|(left, right, bound)| Path::Release { left, right, bound }),
        ]
    })
}

/// The same formula over propositions 0 and 1, written without the checker's translation.
fn as_ltl(path: &Path) -> Ltl {
    let window = |bound: &TimeBound| {
        let (low, strict) = bound.lower.unwrap_or((0, false));
        let upper = bound
            .upper
            .map(|(high, strict)| (high - i64::from(strict)) as u64);
        let lower = (low + i64::from(strict)) as u64;
        StepBound { lower, upper }
    };
    match path {
        Path::State(formula) => match formula.as_ref() {
            StateFormula::Label(name) => Ltl::Ap(usize::from(name == LABELS[1])),
            other => panic!("only labels are generated, not {other:?}"),
        },
        Path::Not(inner) => Ltl::Not(Box::new(as_ltl(inner))),
        Path::And(left, right) => Ltl::and(as_ltl(left), as_ltl(right)),
        Path::Or(left, right) => Ltl::or(as_ltl(left), as_ltl(right)),
        Path::Implies(left, right) => Ltl::implies(as_ltl(left), as_ltl(right)),
        Path::Iff(left, right) => Ltl::iff(as_ltl(left), as_ltl(right)),
        Path::Next(inner) => Ltl::next(as_ltl(inner)),
        Path::Until { left, right, bound } => {
            Ltl::until(as_ltl(left), as_ltl(right)).within(window(bound))
        }
        Path::Finally { operand, bound } => Ltl::finally(as_ltl(operand)).within(window(bound)),
        Path::Globally { operand, bound } => Ltl::globally(as_ltl(operand)).within(window(bound)),
        Path::WeakUntil { left, right, bound } => {
            Ltl::weak_until(as_ltl(left), as_ltl(right)).within(window(bound))
        }
        Path::Release { left, right, bound } => {
            Ltl::release(as_ltl(left), as_ltl(right)).within(window(bound))
        }
        Path::Timed { .. } => panic!("no bounds in time are generated"),
    }
}

fn probability(path: Path) -> Property {
    Property::Probability { bound: None, path }
}

fn exact_value(chain: &Chain, path: &Path) -> Rational {
    let options = Options::default();
    let answer = check_exact(&chain.exact(), &probability(path.clone()), &options).unwrap();
    match answer.value {
        AnswerValue::Exact(value) => value,
        other => panic!("an exact value, not {other:?}"),
    }
}

fn bounds(answer: &Answer) -> (f64, f64) {
    match (&answer.guarantee, &answer.value) {
        (Guarantee::Bounded { low, high }, _) => (*low, *high),
        (Guarantee::Exact, AnswerValue::Number(value)) => (*value, *value),
        other => panic!("a sound answer, not {other:?}"),
    }
}

fn contains((low, high): (f64, f64), exact: &Rational) -> bool {
    let rational = |value| Rational::from_float(value).unwrap();
    rational(low) <= *exact && *exact <= rational(high)
}

fn number(answer: &Answer) -> f64 {
    match answer.value {
        AnswerValue::Number(value) => value,
        ref other => panic!("a number, not {other:?}"),
    }
}

/// Estimates the probability from paths closed to loops at a late return to the same state.
fn sampled(space: &StateSpace<f64>, labels: &[u8], formula: &Ltl, paths: u64) -> f64 {
    let holds = |seed: u64| {
        let path = sample_path(space, seed, 240).expect("a chain").into_iter();
        let path: Vec<usize> = path.map(|visit| visit.state).collect();
        let letters: Vec<u64> = path.iter().map(|state| u64::from(labels[*state])).collect();
        let end = path.len() - 1;
        // A path that was not cut short ended in a state that it cannot leave.
        let returns = (path.len() > 240).then(|| {
            (80..end)
                .find(|position| path[*position] == path[end])
                .unwrap_or(end)
        });
        let from = returns.unwrap_or(end);
        formula.holds_on_lasso(&letters[..from], &letters[from..end.max(from + 1)])
    };
    (0..paths).filter(|seed| holds(*seed)).count() as f64 / paths as f64
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn sound_bounds_contain_the_exact_value(chain in arbitrary_chain(9, true), path in arbitrary_path(2)) {
        let exact = exact_value(&chain, &path);
        let answer = check_space(&chain.rounded(), &probability(path), &Options::default()).unwrap();
        prop_assert!(contains(bounds(&answer), &exact), "{answer:?} {exact}");
        let (low, high) = bounds(&answer);
        prop_assert!(high - low <= 1e-6 * low || high == low, "{answer:?}");
        let one = Rational::from_integer(1.into());
        let complement = answer.complement_bounds
            .unwrap_or((answer.complement.unwrap(), answer.complement.unwrap()));
        prop_assert!(contains(complement, &(one - exact)), "{answer:?}");
    }

    #[test]
    fn iteration_with_a_tiny_threshold_comes_near_the_exact_value(
        chain in arbitrary_chain(6, false), path in arbitrary_path(2),
    ) {
        let exact = exact_value(&chain, &path).to_f64().unwrap();
        let options = Options {
            epsilon: 1e-15,
            max_iters: 1_000_000,
            ..Options::with_method(Method::PrismDefault)
        };
        let answer = check_space(&chain.rounded(), &probability(path), &options).unwrap();
        prop_assert!((number(&answer) - exact).abs() < 1e-8, "{answer:?} {exact}");
        let estimated = matches!(answer.guarantee, Guarantee::Estimated { .. });
        prop_assert!(estimated);
    }

    #[test]
    fn comparisons_are_decided_as_the_exact_value_demands(
        chain in arbitrary_chain(5, true), path in arbitrary_path(1), bound in 0i64..=8,
    ) {
        let exact = exact_value(&chain, &path);
        let bound = Rational::new(bound.into(), 8.into());
        for comparison in
            [Comparison::Less, Comparison::LessEqual, Comparison::Greater, Comparison::GreaterEqual]
        {
            let formula = StateFormula::Probability {
                bound: (comparison, Number::from_rational(bound.clone())),
                path: Box::new(path.clone()),
            };
            let property = Property::State(formula);
            let expected = AnswerValue::Truth(comparison.holds(&exact, &bound));
            let options = Options::default();
            let answer = check_exact(&chain.exact(), &property, &options).unwrap();
            prop_assert_eq!(&answer.value, &expected);
            // Floating point may leave it open, but must not be wrong.
            if let Ok(answer) = check_space(&chain.rounded(), &property, &options) {
                prop_assert_eq!(answer.value, expected);
            }
        }
        let quantified = |formula: fn(Box<Path>) -> StateFormula| {
            let property = Property::State(formula(Box::new(path.clone())));
            let answer = check_space(&chain.rounded(), &property, &Options::default()).unwrap();
            answer.value == AnswerValue::Truth(true)
        };
        let (some, all) = (quantified(StateFormula::Exists), quantified(StateFormula::ForAll));
        let (possible, sure) = (exact > Rational::from_integer(0.into()), exact == Rational::from_integer(1.into()));
        prop_assert!(some || !possible);
        prop_assert!(sure || !all);
        // What the first steps decide is possible where some path shows it, and sure where all do.
        if is_finite(&path) {
            prop_assert_eq!((some, all), (possible, sure));
        }
    }
}

/// Whether finitely many steps decide a formula.
fn is_finite(path: &Path) -> bool {
    match path {
        Path::State(_) => true,
        Path::Not(a) | Path::Next(a) => is_finite(a),
        Path::And(a, b) | Path::Or(a, b) | Path::Implies(a, b) | Path::Iff(a, b) => {
            is_finite(a) && is_finite(b)
        }
        Path::Finally { operand, bound } | Path::Globally { operand, bound } => {
            bound.upper.is_some() && is_finite(operand)
        }
        Path::Until { left, right, bound }
        | Path::WeakUntil { left, right, bound }
        | Path::Release { left, right, bound } => {
            bound.upper.is_some() && is_finite(left) && is_finite(right)
        }
        Path::Timed { .. } => false,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nested_formulas_agree_with_sampled_paths(chain in arbitrary_chain(4, false), path in arbitrary_path(4)) {
        let exact = exact_value(&chain, &path).to_f64().unwrap();
        let paths = 300;
        let estimate = sampled(&chain.rounded(), &chain.labels, &as_ltl(&path), paths);
        let deviation = (exact * (1.0 - exact) / paths as f64).sqrt();
        prop_assert!((estimate - exact).abs() <= 5.0 * deviation + 1e-9, "{exact} {estimate}");
    }
}
