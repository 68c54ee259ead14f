//! `A` and `E`: of all paths, of some path, whatever their probability.
//!
//! Some path satisfies a formula iff it has probability 1 in the system in which a scheduler chooses every
//! transition on its own. There: some path satisfies `left U right` iff it leads there; some path violates it
//! iff the scheduler can avoid it; other formulas by the product with an automaton ([`crate::product`]), where a
//! path to an accepting component is what is asked for. No fairness is assumed; deadlocks have a self-loop.
//!
//! *Within the steps `first..=last`*, from the end, with `pre` the states with some successor in a set:
//!
//! ```text
//! some path satisfies     S_0 = right         S_(k+1) = right | left & pre(S_k)       then  S = left & pre(S)
//! some path violates      V_0 = !right        V_(k+1) = !right & (!left | pre(V_k))   then  V = !left | pre(V)
//! ```
//!
//! `last - first` times the one (for ever without `last`, which is what is computed above), then `first` times the other.
//!
//! Source: Emerson and Clarke 1982 (CTL), Emerson and Halpern 1986 (CTL*); Emerson, Mok, Sistla and Srinivasan 1992 (steps);
//! Baier and Katoen 2008, chapter 6. Cost: linear in transitions (of the product), for each step until the set is the same
//! again. Guarantee: exact.

use prism_lang::Arithmetic;
use prism_lang::property::Path;
use temporal::automaton::{Automaton, DEFAULT_STATE_LIMIT};
use temporal::ltl::Ltl;

use super::Evaluator;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::Numbers;
use crate::fairness::not_yet;
use crate::graph::{Backward, qualitative_optimum};
use crate::product::product;
use crate::shape::{Shape, letters, read_path, shape};
use crate::state_space::Csr;

impl<E: Numbers> Evaluator<'_, E> {
    /// Whether some path from each of the states `from` satisfies a formula, or its negation.
    pub(super) fn some_path(
        &mut self,
        path: &Path,
        negated: bool,
        from: &[usize],
    ) -> Result<Vec<bool>, CheckError> {
        if self.context.options.fair && !self.choices().is_chain() {
            return Err(not_yet("`A` and `E`"));
        }
        let mut sets = Vec::new();
        let formula = read_path(path, &mut sets, &mut |f| self.set(f))?;
        let formula = match negated {
            true => Ltl::negate(formula).simplify(),
            false => formula.simplify(),
        };
        let states = self.space.num_states();
        let (matrix, choice_start) = every_transition::<E::Entry>(self.choices());
        let choices = Choices::new(&matrix, &choice_start);
        let holds = match shape(&formula, &sets, states) {
            None => return self.some_path_of_product(choices, &formula, &sets, from),
            Some(Shape::Set(holds)) => holds,
            Some(Shape::Next { operand, contrary }) => {
                let leads = |row: usize| {
                    choices
                        .targets(row)
                        .iter()
                        .any(|t| operand[*t as usize] != contrary)
                };
                (0..states)
                    .map(|state| choices.rows(state).any(leads))
                    .collect()
            }
            Some(Shape::Until {
                left,
                right,
                steps: (first, last),
                contrary,
            }) => {
                let window = match (last, contrary) {
                    (Some(last), _) => {
                        let start = right.iter().map(|right| *right != contrary).collect();
                        let steps = last.saturating_sub(first);
                        self.steps_earlier(start, steps, |state, leads| match contrary {
                            false => right[state] || left[state] && leads,
                            true => !right[state] && (!left[state] || leads),
                        })?
                    }
                    (None, false) => {
                        let backward = Backward::new(choices);
                        backward.reaching(&right, |s| left[s], |_| true).0
                    }
                    (None, true) => qualitative_optimum(choices, &left, &right, false).never,
                };
                self.steps_earlier(window, first, |state, leads| match contrary {
                    false => left[state] && leads,
                    true => !left[state] || leads,
                })?
            }
        };
        Ok(from.iter().map(|state| holds[*state]).collect())
    }

    /// A set of states some steps earlier: `holds` is told whether a state leads to the set one step later.
    fn steps_earlier(
        &self,
        mut set: Vec<bool>,
        steps: u64,
        holds: impl Fn(usize, bool) -> bool,
    ) -> Result<Vec<bool>, CheckError> {
        let choices = self.choices();
        for step in 0..steps {
            if step % 16 == 0 {
                self.context.options.check_cancelled()?;
            }
            let leads = |state: usize| {
                let targets = &choices.matrix.column[choices.all_entries(state)];
                targets.iter().any(|target| set[*target as usize])
            };
            let earlier = (0..set.len()).map(|state| holds(state, leads(state)));
            let earlier: Vec<bool> = earlier.collect();
            if earlier == set {
                break;
            }
            set = earlier;
        }
        Ok(set)
    }

    fn some_path_of_product(
        &mut self,
        choices: Choices<'_, E::Entry>,
        formula: &Ltl,
        sets: &[Vec<bool>],
        from: &[usize],
    ) -> Result<Vec<bool>, CheckError> {
        let limit = self.context.options.product_limit.min(DEFAULT_STATE_LIMIT);
        let mut automaton = Automaton::with_state_limit(formula, limit)?;
        let letters = letters(sets, self.space.num_states());
        let product = product(
            choices,
            &mut automaton,
            &letters,
            from,
            self.context.options,
        )?;
        self.product_states = self.product_states.max(Some(product.accepting.len()));
        let backward = Backward::new(product.choices());
        let (reaches, _) = backward.reaching(&product.accepting, |_| true, |_| true);
        Ok(product.start.iter().map(|state| reaches[*state]).collect())
    }
}

/// Each transition as a choice of its own.
fn every_transition<N: Arithmetic>(choices: Choices<'_, N>) -> (Csr<N>, Vec<usize>) {
    let mut matrix = Csr::with_capacity(choices.matrix.num_entries());
    let mut choice_start = vec![0];
    let mut targets = Vec::new();
    for state in 0..choices.num_states() {
        targets.clear();
        targets.extend_from_slice(&choices.matrix.column[choices.all_entries(state)]);
        targets.sort_unstable();
        targets.dedup();
        for target in &targets {
            matrix.push_row([(*target, N::one())]);
        }
        choice_start.push(matrix.num_rows());
    }
    (matrix, choice_start)
}
