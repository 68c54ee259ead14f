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
use super::schedulers::none;
use crate::amount::Amount;
use crate::answer::{CheckError, Options};
use crate::choices::Choices;
use crate::engine::{Context, Numbers};
use crate::fairness::not_yet;
use crate::graph::{EndComponent, NO_ROW, maximal_end_components};
use crate::joint::Joint;
use crate::reachability::{self, Found};
use crate::scheduler::tour::{Recurring, Stay};
use crate::scheduler::{Meaning, Numbered, Policy, Scheduler};
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
        let (formulas, letters) = self.conditional_formulas((path, condition), maximise)?;
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

    /// What is read by the automata: path and condition (its contrary and condition, for a least probability), the
    /// condition's contrary, the condition; and the letters of all states.
    fn conditional_formulas(
        &mut self,
        (path, condition): (&Path, &Path),
        maximise: bool,
    ) -> Result<([Ltl; 3], Vec<u64>), CheckError> {
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
        Ok((formulas, letters(&sets, self.space.num_states())))
    }

    /// The greatest probability of the first formula given the third, of which the second is the negation.
    fn restarting(
        &mut self,
        formulas: &[Ltl; 3],
        letters: &[u64],
        from: usize,
    ) -> Result<E::Amount, CheckError> {
        let options = self.context.options;
        let joint = Joint::new(self.choices(), formulas, letters, 0, from, options)?;
        self.product_states = self.product_states.max(Some(joint.num_states()));
        let Some(restarts) = Restarts::new(joint, options)? else {
            return Ok(E::Amount::undefined());
        };
        let (values, _, rounds) = restarts.solve::<E>(&self.context)?;
        self.iterations += rounds;
        Ok(E::amount(&values[0]))
    }

    /// The scheduler that attains the greatest or least conditional probability.
    pub(super) fn conditional_scheduler(
        &mut self,
        both: (&Path, &Path),
        maximise: bool,
    ) -> Result<Scheduler, CheckError> {
        let [initial] = *self.space.initial_states() else {
            return none("a conditional probability over several initial states has several");
        };
        let (formulas, letters) = self.conditional_formulas(both, maximise)?;
        let options = self.context.options;
        let joint = Joint::new(self.choices(), &formulas, &letters, 0, initial, options)?;
        let Some(restarts) = Restarts::new(joint, options)? else {
            return none("the condition is impossible");
        };
        let (values, rows, _) = restarts.solve::<E>(&self.context)?;
        if E::amount(&values[0]).bounds().high <= 0.0 {
            return none(
                "every scheduler under which the condition is possible attains this value",
            );
        }
        let mut policy = restarts.policy(self.choices(), &rows.unwrap_or_default());
        self.unfold(&mut policy, Meaning::Automaton)
    }
}

/// The product in which what does not count starts again.
struct Restarts<'a, N> {
    joint: Joint<'a, N>,
    goal: Vec<bool>,
    again: Vec<bool>,
    /// Where to stay in each component of the goal, and in each that may start again; and the components.
    stays: [Vec<(EndComponent, Recurring)>; 2],
}

impl<'a, N: Arithmetic> Restarts<'a, N> {
    /// Nothing if the condition is impossible.
    fn new(mut joint: Joint<'a, N>, options: &Options<'_>) -> Result<Option<Self>, CheckError> {
        let everywhere = vec![true; joint.num_states()];
        let (mut goal, mut again) = (vec![false; everywhere.len()], vec![false; everywhere.len()]);
        let mut stays = [Vec::new(), Vec::new()];
        let mut possible = false;
        for component in maximal_end_components(joint.choices(), &everywhere, |_| true) {
            options.check_cancelled()?;
            let reached = joint.recurring(&component, &[0])?;
            let restarts = match reached {
                Some(_) => None,
                None => joint.recurring(&component, &[1])?,
            };
            let (is_goal, may_restart) = (reached.is_some(), restarts.is_some());
            possible |= is_goal || !may_restart || joint.satisfies(&component, &[2])?;
            for state in component.states.iter().map(|s| *s as usize) {
                (goal[state], again[state]) = (is_goal, may_restart);
            }
            for (stays, found) in stays.iter_mut().zip([reached, restarts]) {
                stays.extend(found.map(|found| (component.clone(), found)));
            }
        }
        Ok(possible.then_some(Self {
            joint,
            goal,
            again,
            stays,
        }))
    }

    /// The probabilities of the goal, and a scheduler of the process with restarts.
    fn solve<E: Numbers<Entry = N>>(
        &self,
        context: &Context<'_>,
    ) -> Result<Found<E::Value>, CheckError> {
        let (matrix, choice_start) = with_restarts(self.joint.choices(), &self.again);
        let choices = Choices::new(&matrix, &choice_start);
        let everywhere = vec![true; self.goal.len()];
        reachability::until::<E>(
            choices,
            &everywhere,
            &self.goal,
            (0, None),
            None,
            true,
            context,
        )
    }

    /// The scheduler without restarts: where one would be, it sees to it that the condition does not hold.
    fn policy<'b>(&'b self, model: Choices<'b, N>, rows: &[usize]) -> WithoutRestarts<'b, N> {
        let choices = self.joint.choices();
        let mut start = 0;
        let mut seek = Vec::with_capacity(self.again.len());
        for (state, again) in self.again.iter().enumerate() {
            let own = choices.rows(state);
            seek.push(match rows.get(state) {
                Some(row) if *row != NO_ROW && row - start < own.len() => own.start + row - start,
                Some(row) if *row != NO_ROW => RESTART,
                _ => NO_ROW,
            });
            start += own.len() + usize::from(*again);
        }
        WithoutRestarts {
            model,
            joint: &self.joint,
            goal: &self.goal,
            seek,
            stays: (self.stays.each_ref()).map(|stays| Stay::new(choices, stays)),
            numbers: Numbered::new(),
        }
    }
}

/// In place of a row: start again.
const RESTART: usize = NO_ROW - 1;

/// The policy: the state of the product, whether it seeks (0) or stays in the goal (1) or outside the condition (2),
/// and the place of the round.
struct WithoutRestarts<'a, N> {
    model: Choices<'a, N>,
    joint: &'a Joint<'a, N>,
    goal: &'a [bool],
    seek: Vec<usize>,
    stays: [Stay; 2],
    numbers: Numbered<(u32, u8, u32)>,
}

impl<N: Arithmetic> WithoutRestarts<'_, N> {
    fn key(&self, state: usize, mode: u8, place: u32) -> (u32, u8, u32) {
        let mode = match mode {
            0 if self.goal[state] => 1,
            0 if self.seek[state] == RESTART => 2,
            mode => mode,
        };
        (state as u32, mode, place)
    }

    /// The product's row.
    fn taken(&self, (state, mode, place): (u32, u8, u32)) -> usize {
        let state = state as usize;
        match mode {
            0 => self.seek[state],
            mode => self.stays[usize::from(mode) - 1].row(state, place),
        }
    }
}

impl<N: Arithmetic> Policy for WithoutRestarts<'_, N> {
    type Key = (u32, u8, u32);

    fn first(&mut self, _: usize, _: usize) -> Self::Key {
        self.key(0, 0, 0)
    }

    fn row(&mut self, _: usize, key: Self::Key) -> Option<usize> {
        match self.taken(key) {
            NO_ROW => None,
            row => Some(self.joint.origin[row]),
        }
    }

    fn next(&mut self, state: usize, key: Self::Key, row: usize, target: usize) -> Self::Key {
        let from = key.0 as usize;
        let choices = self.joint.choices();
        let row = choices.rows(from).start + row - self.model.rows(state).start;
        let is_target = |to: &&u32| self.joint.state(**to as usize) == target;
        let to = choices.targets(row).iter().find(is_target);
        let to = *to.expect("the product has all targets of the model") as usize;
        let place = match key.1 {
            0 => 0,
            mode => self.stays[usize::from(mode) - 1].next(from, key.2, row),
        };
        self.key(to, key.1, place)
    }

    fn number(&mut self, (state, mode, place): Self::Key) -> u32 {
        (self.numbers).of((self.joint.memory(state as usize), mode, place))
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
