//! Automata accept exactly the words on which the definition of the logic holds: exhaustively on
//! small worlds, and on thousands of random formulas and words.

use proptest::prelude::*;
use temporal::automaton::Automaton;
use temporal::ltl::{Ltl, StepBound};

/// Every word `prefix cycle*` with the two parts up to these lengths over `letters` letters.
fn lassos(letters: u64, prefix: usize, cycle: usize) -> Vec<(Vec<u64>, Vec<u64>)> {
    let of_length = |length: usize| -> Vec<Vec<u64>> {
        (0..letters.pow(length as u32))
            .map(|code| {
                (0..length)
                    .map(|i| code / letters.pow(i as u32) % letters)
                    .collect()
            })
            .collect()
    };
    let prefixes: Vec<Vec<u64>> = (0..=prefix).flat_map(of_length).collect();
    let cycles: Vec<Vec<u64>> = (1..=cycle).flat_map(of_length).collect();
    (prefixes.iter())
        .flat_map(|prefix| cycles.iter().map(|cycle| (prefix.clone(), cycle.clone())))
        .collect()
}

fn disagreement(formula: &Ltl, words: &[(Vec<u64>, Vec<u64>)]) -> Option<String> {
    let mut automaton = Automaton::new(formula).expect("small formulas have automata");
    let simple = formula.simplify();
    for (prefix, cycle) in words {
        let expected = formula.holds_on_lasso(prefix, cycle);
        let accepted = automaton
            .accepts_lasso(prefix, cycle)
            .expect("small automaton");
        let simplified = simple.holds_on_lasso(prefix, cycle);
        if accepted != expected || simplified != expected {
            return Some(format!(
                "{formula} on {prefix:?} {cycle:?}*: definition {expected}, automaton {accepted}, \
                 simplified ({simple}) {simplified}"
            ));
        }
    }
    None
}

/// All formulas with up to `depth` nested operators over two propositions, without windows.
fn formulas(depth: usize) -> Vec<Ltl> {
    let mut known = vec![Ltl::Ap(0), Ltl::Ap(1), Ltl::True];
    for _ in 0..depth {
        let smaller = known.clone();
        for a in &smaller {
            known.push(Ltl::negate(a.clone()));
            known.push(Ltl::next(a.clone()));
            known.push(Ltl::finally(a.clone()));
            known.push(Ltl::globally(a.clone()));
            for b in &smaller {
                known.push(Ltl::and(a.clone(), b.clone()));
                known.push(Ltl::or(a.clone(), b.clone()));
                known.push(Ltl::until(a.clone(), b.clone()));
                known.push(Ltl::release(a.clone(), b.clone()));
                known.push(Ltl::weak_until(a.clone(), b.clone()));
            }
        }
        known.sort();
        known.dedup();
    }
    known
}

#[test]
fn all_formulas_of_depth_two_on_all_short_words() {
    let words = lassos(4, 1, 2);
    let formulas = formulas(2);
    assert!(formulas.len() > 10_000, "{} formulas", formulas.len());
    for formula in &formulas {
        assert_eq!(disagreement(formula, &words), None);
    }
}

#[test]
fn formulas_with_known_difficulties() {
    let (a, b, c) = (|| Ltl::Ap(0), || Ltl::Ap(1), || Ltl::Ap(2));
    let gf = |x| Ltl::globally(Ltl::finally(x));
    let fg = |x| Ltl::finally(Ltl::globally(x));
    let formulas = [
        // Strong fairness, a Rabin and Streett pair.
        Ltl::implies(gf(a()), gf(b())),
        Ltl::globally(Ltl::implies(a(), Ltl::until(b(), c()))),
        Ltl::finally(Ltl::and(a(), Ltl::globally(Ltl::or(b(), Ltl::next(c()))))),
        fg(Ltl::or(a(), Ltl::next(Ltl::until(b(), c())))),
        gf(Ltl::and(a(), Ltl::next(Ltl::and(b(), Ltl::next(c()))))),
        Ltl::globally(Ltl::or(
            Ltl::finally(a()),
            Ltl::finally(Ltl::until(b(), c())),
        )),
        Ltl::until(Ltl::globally(Ltl::finally(a())), Ltl::until(b(), fg(c()))),
        // Nondeterministic Büchi automata of these need Safra's trees of depth two.
        Ltl::globally(Ltl::finally(Ltl::and(a(), fg(b())))),
        Ltl::finally(Ltl::and(
            fg(a()),
            Ltl::globally(Ltl::finally(Ltl::next(b()))),
        )),
        fg(Ltl::implies(
            a(),
            Ltl::finally(Ltl::and(b(), Ltl::next(Ltl::finally(c())))),
        )),
        Ltl::globally(Ltl::implies(
            a(),
            Ltl::finally(b()).within(StepBound::at_most(3)),
        )),
        gf(Ltl::until(a(), b()).within(StepBound::between(1, 3))),
        fg(Ltl::weak_until(a(), b()).within(StepBound::between(1, 2))),
        Ltl::globally(Ltl::release(a(), Ltl::finally(c())).within(StepBound {
            lower: 2,
            upper: None,
        })),
    ];
    let words = lassos(8, 1, 3);
    for formula in &formulas {
        assert_eq!(disagreement(formula, &words), None);
        assert_eq!(disagreement(&Ltl::negate(formula.clone()), &words), None);
    }
}

#[test]
fn a_long_window_needs_one_state_per_step() {
    let response = Ltl::globally(Ltl::implies(
        Ltl::Ap(0),
        Ltl::finally(Ltl::Ap(1)).within(StepBound::at_most(200)),
    ));
    let mut automaton = Automaton::new(&response).unwrap();
    let word = |gap: usize| [vec![1], vec![1; gap], vec![2]].concat();
    assert!(automaton.accepts_lasso(&word(199), &[0]).unwrap());
    assert!(!automaton.accepts_lasso(&word(200), &[0]).unwrap());
    assert!(
        automaton.state_count() <= 203,
        "{}",
        automaton.state_count()
    );
}

#[test]
fn the_state_limit_is_an_error_not_a_hang() {
    let far = Ltl::next(Ltl::finally(Ltl::Ap(0)).within(StepBound::between(5, 1_000_000)));
    let mut automaton = Automaton::with_state_limit(&far, 50).unwrap();
    let error = automaton.accepts_lasso(&[], &[0]).unwrap_err();
    assert!(error.to_string().contains("50 states"), "{error}");
    let wide = Automaton::new(&Ltl::Ap(64)).unwrap_err();
    assert!(wide.to_string().contains("at most 64"), "{wide}");
}

fn arbitrary_bound() -> impl Strategy<Value = StepBound> {
    prop_oneof![
        6 => Just(StepBound::UNBOUNDED),
        1 => (0u64..4).prop_map(StepBound::at_most),
        1 => (0u64..3, 0u64..4).prop_map(|(low, more)| StepBound::between(low, low + more)),
        1 => (0u64..3).prop_map(|lower| StepBound { lower, upper: None }),
        1 => Just(StepBound::between(2, 1)),
    ]
}

fn arbitrary_formula() -> impl Strategy<Value = Ltl> {
    let atom = prop_oneof![8 => (0usize..3).prop_map(Ltl::Ap), 1 => Just(Ltl::True), 1 => Just(Ltl::False)];
    atom.prop_recursive(6, 18, 2, |inner| {
        let pair = (inner.clone(), inner.clone());
        prop_oneof![
            inner.clone().prop_map(Ltl::negate),
            inner.clone().prop_map(Ltl::next),
            (inner.clone(), arbitrary_bound()).prop_map(|(a, b)| Ltl::finally(a).within(b)),
            (inner.clone(), arbitrary_bound()).prop_map(|(a, b)| Ltl::globally(a).within(b)),
            pair.clone().prop_map(|(a, b)| Ltl::and(a, b)),
            pair.clone().prop_map(|(a, b)| Ltl::or(a, b)),
            pair.clone().prop_map(|(a, b)| Ltl::iff(a, b)),
            (pair.clone(), arbitrary_bound()).prop_map(|((a, b), w)| Ltl::until(a, b).within(w)),
            (pair.clone(), arbitrary_bound()).prop_map(|((a, b), w)| Ltl::release(a, b).within(w)),
            (pair, arbitrary_bound()).prop_map(|((a, b), w)| Ltl::weak_until(a, b).within(w)),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_formulas_on_random_words(
        formula in arbitrary_formula(),
        words in prop::collection::vec(
            (prop::collection::vec(0u64..8, 0..5), prop::collection::vec(0u64..8, 1..5)), 30),
    ) {
        prop_assert_eq!(disagreement(&formula, &words), None);
    }
}
