//! Probabilities under a condition: of a path formula, given that another one holds.
//!
//! *Definition.* `P(path and condition) / P(condition)`; over schedulers, the optimum over those under which the
//! condition is possible. Where it is not, the number is not defined (NaN).
//!
//! *Without choices* both probabilities are computed, each with its relative accuracy, and divided.
//!
//! *With choices* on the product with automata of `path and condition` and of `not condition`: where a scheduler can
//! stay and satisfy the first, the goal is reached; where it can only satisfy the second, it may start again, for
//! what is not given does not count. The greatest probability of the goal in the process with these restarts is the
//! greatest conditional one; the least is that of the contrary, less from 1.
//!
//! Source: Baier, Klein, Klüppelholz and Märcker 2014, "Computing Conditional Probabilities in Markovian Models
//! Efficiently" (restarts). Deviation: end components of a product with automata in place of goal states. Cost: that
//! of one reachability problem on the product, for each state asked for. Guarantee: that of the engine.

use prism_lang::Arithmetic;
use prism_lang::property::Path;
use temporal::ltl::Ltl;

use super::Evaluator;
use crate::amount::Amount;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::Numbers;
use crate::fairness::not_yet;
use crate::graph::maximal_end_components;
use crate::joint::Joint;
use crate::reachability;
use crate::shape::{letters, read_path};
use crate::state_space::Csr;

impl<E: Numbers> Evaluator<'_, E> {
    /// The probability of the first path formula given the second, in the states `from`.
    pub(super) fn conditional(
        &mut self,
        (path, condition): (&Path, &Path),
        maximise: bool,
        from: &[usize],
    ) -> Result<Vec<E::Amount>, CheckError> {
        if self.choices().is_chain() {
            let both = Path::And(Box::new(path.clone()), Box::new(condition.clone()));
            let both = self.probability(&both, true, from)?;
            let given = self.probability(condition, true, from)?;
            let one = E::Amount::one();
            let pairs = both.iter().zip(&given);
            return Ok(pairs
                .map(|(both, given)| E::amount(both).div(&E::amount(given)).least(&one))
                .collect());
        }
        if self.context.options.fair {
            return Err(not_yet("conditional probabilities"));
        }
        let mut sets = Vec::new();
        let path = read_path(path, &mut sets, &mut |f| self.set(f))?;
        let condition = read_path(condition, &mut sets, &mut |f| self.set(f))?;
        let path = match maximise {
            true => path,
            false => Ltl::negate(path),
        };
        let both = Ltl::and(path, condition.clone()).simplify();
        let formulas = [
            both,
            Ltl::negate(condition.clone()).simplify(),
            condition.simplify(),
        ];
        let letters = letters(&sets, self.space.num_states());
        self.scheduler = None;
        let value = |state: &usize| {
            let value = self.restarting(&formulas, &letters, *state)?;
            Ok(match maximise {
                true => value,
                false => E::Amount::one().sub(&value),
            })
        };
        from.iter().map(value).collect()
    }

    /// The greatest probability of the first formula given the third, of which the second is the negation.
    fn restarting(
        &mut self,
        formulas: &[Ltl; 3],
        letters: &[u64],
        from: usize,
    ) -> Result<E::Amount, CheckError> {
        let options = self.context.options;
        let mut joint = Joint::new(self.choices(), formulas, letters, 0, from, options)?;
        self.product_states = self.product_states.max(Some(joint.num_states()));
        let everywhere = vec![true; joint.num_states()];
        let (mut goal, mut again) = (vec![false; everywhere.len()], vec![false; everywhere.len()]);
        let mut possible = false;
        for component in maximal_end_components(joint.choices(), &everywhere, |_| true) {
            options.check_cancelled()?;
            let is_goal = joint.satisfies(&component, &[0])?;
            let may_restart = !is_goal && joint.satisfies(&component, &[1])?;
            possible |= is_goal || !may_restart || joint.satisfies(&component, &[2])?;
            for state in component.states.iter().map(|s| *s as usize) {
                (goal[state], again[state]) = (is_goal, may_restart);
            }
        }
        if !possible {
            return Ok(E::Amount::undefined());
        }
        let (matrix, choice_start) = with_restarts(joint.choices(), &again);
        let choices = Choices::new(&matrix, &choice_start);
        let (values, _, rounds) = reachability::until::<E>(
            choices,
            &everywhere,
            &goal,
            (0, None),
            None,
            true,
            &self.context,
        )?;
        self.iterations += rounds;
        Ok(E::amount(&values[0]))
    }
}

/// The process in which some states may go back to state 0.
fn with_restarts<N: Arithmetic>(choices: Choices<'_, N>, again: &[bool]) -> (Csr<N>, Vec<usize>) {
    let mut matrix = Csr::with_capacity(choices.matrix.num_entries());
    let mut choice_start = vec![0];
    for (state, again) in again.iter().enumerate() {
        for row in choices.rows(state) {
            let entries = choices.matrix.row(row);
            matrix.push_row(entries.map(|(target, p)| (target as u32, p.clone())));
        }
        if *again {
            matrix.push_row([(0, N::one())]);
        }
        choice_start.push(matrix.num_rows());
    }
    (matrix, choice_start)
}
