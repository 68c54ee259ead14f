//! `A` and `E`: of all paths, of some path, whatever their probability.
//!
//! Some path satisfies a formula iff it has probability 1 in the system in which a scheduler chooses every
//! transition on its own. There: some path satisfies `left U right` iff it leads there; some path violates it
//! iff the scheduler can avoid it; other formulas by the product with an automaton ([`crate::product`]), where a
//! path to an accepting component is what is asked for. No fairness is assumed; deadlocks have a self-loop.
//!
//! Source: Emerson and Clarke 1982 (CTL), Emerson and Halpern 1986 (CTL*); Baier and Katoen 2008, chapter 6.
//! Cost: linear in transitions (of the product). Guarantee: exact.

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
                contrary,
                ..
            }) => match contrary {
                false => {
                    Backward::new(choices)
                        .reaching(&right, |s| left[s], |_| true)
                        .0
                }
                true => qualitative_optimum(choices, &left, &right, false).never,
            },
        };
        Ok(from.iter().map(|state| holds[*state]).collect())
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
