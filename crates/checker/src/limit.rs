//! Formulas that speak only of what happens for ever: combinations of `G F` and `F G`, which need no automaton.
//!
//! *Definition.* Of formulas without temporal operators `p`, `phi ::= G F p | F G p | !phi | phi & phi | phi '|' phi`; also `X phi`,
//! `F phi`, `G phi`, which say the same as `phi`. Whether a path satisfies one depends only on the states that it visits infinitely often.
//! These are almost surely an end component (the states of one, in a chain a bottom component), so that with
//! `phi` in disjunctive normal form
//!
//! ```text
//! P(phi) = P(F accepting)    accepting = the maximal end components within all p of `F G p`
//!                                        that have a state of each p of `G F p`, of some disjunct
//! ```
//!
//! since a scheduler can visit all states of an end component again and again.
//!
//! Source: Emerson and Lei 1987, "Modalities for Model Checking: Branching Time Logic Strikes Back"; de Alfaro 1997, "Formal
//! Verification of Probabilistic Systems", chapter 4; Baier and Katoen 2008, section 10.6.4.
//!
//! Deviation: normal forms of more than [`MOST`] disjuncts are left to the product with an automaton ([`crate::product`]), and so are
//! fair schedulers. Cost: a search for end components for each disjunct, on the model itself. Guarantee: exact.

use temporal::ltl::Ltl;

use crate::choices::Choices;
use crate::graph::maximal_end_components;
use crate::shape::{holds, negation};

/// Disjuncts beyond which an automaton is smaller.
const MOST: usize = 32;

/// What must hold of the states that are visited infinitely often.
#[derive(Debug, Clone)]
struct Disjunct {
    /// All of them are in this set.
    within: Vec<bool>,
    /// Each of these has one of them.
    visits: Vec<Vec<bool>>,
}

/// The states of the end components in which a scheduler satisfies the formula; `None` if it is of another form.
pub(crate) fn accepting<N>(
    choices: Choices<'_, N>,
    formula: &Ltl,
    sets: &[Vec<bool>],
) -> Option<Vec<bool>> {
    let mut accepting = vec![false; choices.num_states()];
    for disjunct in normal_form(formula, false, sets, accepting.len())? {
        for component in maximal_end_components(choices, &disjunct.within, |_| true) {
            let has_one = |set: &Vec<bool>| component.states.iter().any(|s| set[*s as usize]);
            if disjunct.visits.iter().all(has_one) {
                for state in &component.states {
                    accepting[*state as usize] = true;
                }
            }
        }
    }
    Some(accepting)
}

/// The disjuncts of a formula, or of its negation.
fn normal_form(
    formula: &Ltl,
    negated: bool,
    sets: &[Vec<bool>],
    states: usize,
) -> Option<Vec<Disjunct>> {
    let of = |formula: &Ltl| normal_form(formula, negated, sets, states);
    let operand = |formula: &Ltl| {
        let set = formula
            .is_propositional()
            .then(|| holds(formula, sets, states))?;
        Some(if negated { negation(set) } else { set })
    };
    match formula {
        Ltl::Not(inner) => normal_form(inner, !negated, sets, states),
        Ltl::And(left, right) | Ltl::Or(left, right) => {
            let is_and = matches!(formula, Ltl::And(..)) != negated;
            let (left, right) = (of(left)?, of(right)?);
            if is_and {
                both(&left, &right)
            } else {
                Some(left.into_iter().chain(right).collect())
            }
        }
        Ltl::Next(inner) => of(inner),
        Ltl::Globally(inner, bound) | Ltl::Finally(inner, bound) if bound.is_unbounded() => {
            let is_globally = matches!(formula, Ltl::Globally(..));
            let (Ltl::Finally(set, last) | Ltl::Globally(set, last)) = &**inner else {
                return of(inner);
            };
            let is_alternating = is_globally == matches!(**inner, Ltl::Finally(..));
            match operand(set) {
                Some(set) if last.is_unbounded() && is_alternating => {
                    Some(vec![single(set, is_globally != negated)])
                }
                _ => of(inner),
            }
        }
        _ => None,
    }
}

/// `G F` of a set, or `F G`.
fn single(set: Vec<bool>, again_and_again: bool) -> Disjunct {
    if again_and_again {
        Disjunct {
            within: vec![true; set.len()],
            visits: vec![set],
        }
    } else {
        Disjunct {
            within: set,
            visits: Vec::new(),
        }
    }
}

/// The conjunction of two normal forms.
fn both(left: &[Disjunct], right: &[Disjunct]) -> Option<Vec<Disjunct>> {
    if left.len() * right.len() > MOST {
        return None;
    }
    let pairs = left.iter().flat_map(|a| right.iter().map(move |b| (a, b)));
    let join = |(a, b): (&Disjunct, &Disjunct)| Disjunct {
        within: (a.within.iter().zip(&b.within))
            .map(|(a, b)| *a && *b)
            .collect(),
        visits: a.visits.iter().chain(&b.visits).cloned().collect(),
    };
    Some(pairs.map(join).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Options;
    use crate::product::product;
    use crate::state_space::Csr;
    use proptest::prelude::*;
    use temporal::automaton::{Automaton, DEFAULT_STATE_LIMIT};

    fn formulas() -> impl Strategy<Value = Ltl> {
        let leaf = (0usize..3, any::<bool>(), any::<bool>()).prop_map(|(ap, negative, again)| {
            let ap = if negative {
                Ltl::negate(Ltl::Ap(ap))
            } else {
                Ltl::Ap(ap)
            };
            match again {
                true => Ltl::globally(Ltl::finally(ap)),
                false => Ltl::finally(Ltl::globally(ap)),
            }
        });
        leaf.prop_recursive(3, 6, 2, |inner| {
            prop_oneof![
                inner.clone().prop_map(Ltl::negate),
                inner.clone().prop_map(Ltl::next),
                inner.clone().prop_map(Ltl::finally),
                (inner.clone(), inner.clone()).prop_map(|(a, b)| Ltl::and(a, b)),
                (inner.clone(), inner).prop_map(|(a, b)| Ltl::or(a, b)),
            ]
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn accepting_states_reach_those_of_the_product_and_back(
            formula in formulas(),
            rows in prop::collection::vec(prop::collection::vec(0u32..6, 1..3), 12),
            sets in prop::collection::vec(prop::collection::vec(any::<bool>(), 6), 3),
            is_chain in any::<bool>(),
        ) {
            // Two choices for each of six states, or one; probabilities do not matter.
            let row = |targets: &Vec<u32>| {
                let mut targets = targets.clone();
                targets.sort_unstable();
                targets.dedup();
                let p = 1.0 / targets.len() as f64;
                targets.into_iter().map(|t| (t, p)).collect::<Vec<_>>()
            };
            let rows: Vec<_> = rows.iter().take(if is_chain { 6 } else { 12 }).map(row).collect();
            let matrix = Csr::from_rows(rows);
            let start: Vec<usize> = if is_chain { Vec::new() } else { (0..=6).map(|s| 2 * s).collect() };
            let choices = Choices::new(&matrix, &start);
            let formula = formula.simplify();
            prop_assume!(!formula.is_propositional());
            let found = accepting(choices, &formula, &sets);
            prop_assume!(found.is_some());
            let found = found.unwrap();
            let mut automaton = Automaton::with_state_limit(&formula, DEFAULT_STATE_LIMIT).unwrap();
            let letters = crate::shape::letters(&sets, 6);
            let from: Vec<usize> = (0..6).collect();
            let product = product(choices, &mut automaton, &letters, &from, &Options::default()).unwrap();
            let reach = |choices: Choices<'_, f64>, target: &[bool]| {
                crate::graph::qualitative_optimum(choices, &vec![true; target.len()], target, true)
            };
            let (here, there) = (reach(choices, &found), reach(product.choices(), &product.accepting));
            for state in 0..6 {
                let at = product.start[state];
                prop_assert_eq!(here.never[state], there.never[at], "{} from {}", formula, state);
                prop_assert_eq!(here.surely[state], there.surely[at], "{} from {}", formula, state);
            }
        }
    }
}
