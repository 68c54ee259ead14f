//! From a model to its reachable states and transitions.
//!
//! Definition: in a state, the choices are the enabled commands without action and, for each action, one
//! enabled command of every module that has commands with that action (in general: the events of `events`).
//! A choice's outcomes are the products of its commands' updates. In an `mdp` or `lts`, choices are what a
//! scheduler chooses from; in a `dtmc` with `k` choices each is taken with probability `1/k`; in a `ctmc` they
//! race: rates of synchronised commands are multiplied, rates of choices add up. Outcomes of probability 0 are
//! dropped, outcomes with the same target are merged (in a chain over all choices, else within a choice), a
//! state without choices gets a self-loop.
//!
//! Source: the semantics of the PRISM language (Kwiatkowska, Norman, Parker, "PRISM 4.0: Verification of
//! Probabilistic Real-time Systems", CAV 2011, and the tool's description of its language); uniform choice in
//! a `dtmc` and `fixdl` are the tool's.
//!
//! Deviation: the probabilities of a command must sum to 1 to within 1e-12 (exactly in an exact domain); the
//! tool allows 1e-5 and rescales. Cost: linear in states times commands, plus transitions; breadth first, so
//! that the numbering of states does not depend on the domain.
//!
//! Guarantee: in `f64`, each entry of the matrix is within the relative error
//! [`StateSpace::relative_error`] of the exact probability; none is lost to underflow.

mod code;
mod command;
mod error;
mod events;
mod fault;
mod intern;
mod rewards;

use std::ops::Range;

use prism_lang::resolved::{Init, Model, ModelType};
use prism_lang::{Arithmetic, Expr, Span};

use crate::state_space::{Csr, LabelStates, Layout, NO_ACTION, StateSpace, describe};
use code::Code;
use command::{CompiledCommand, CompiledEvent, compile, probability};
pub use error::ExploreError;
use fault::{bad_probability, check_sum, in_range, no_value};
use intern::Interner;

/// How many states `init ... endinit` may be tried on.
const MAX_CANDIDATES: u64 = 100_000_000;
/// How many states are explored between two calls of the progress function.
const PROGRESS_INTERVAL: usize = 1024;

/// How far to explore.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExploreOptions {
    /// More reachable states than this are an error.
    pub max_states: usize,
}

impl Default for ExploreOptions {
    /// At most 100 million states.
    fn default() -> Self {
        Self {
            max_states: 100_000_000,
        }
    }
}

/// Builds the reachable state space of a model.
///
/// # Errors
/// If the model leaves a variable's range, has probabilities that do not sum to 1, or too many states.
///
/// ```
/// use checker::explore::explore;
/// use prism_lang::{Constants, parse_model, resolve};
/// let text = "dtmc module die x : [0..6]; [] x=0 -> 1/2:(x'=1) + 1/2:(x'=2); endmodule";
/// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
/// let space = explore::<f64>(&model)?;
/// assert_eq!((space.num_states(), space.num_transitions()), (3, 4));
/// assert_eq!(space.deadlocks(), [1, 2]);
/// # Ok::<(), checker::explore::ExploreError>(())
/// ```
pub fn explore<N: Arithmetic>(model: &Model) -> Result<StateSpace<N>, ExploreError> {
    explore_with(model, ExploreOptions::default(), &|_| true)
}

/// Like [`explore`], with a limit, and a function that is told the number of states found so far and stops
/// the search by returning `false`.
///
/// # Errors
/// As for [`explore`]; also if the search was stopped.
pub fn explore_with<N: Arithmetic>(
    model: &Model,
    options: ExploreOptions,
    progress: &dyn Fn(usize) -> bool,
) -> Result<StateSpace<N>, ExploreError> {
    if !model.parameters.is_empty() {
        return Err(ExploreError::UnsupportedConstruct(
            "a model with open constants cannot be explored yet: give each constant a value",
        ));
    }
    let mut explorer = Explorer::new(model, options);
    explorer.initial_states(progress)?;
    let num_initial = explorer.interner.len();
    let mut state = 0;
    while state < explorer.interner.len() {
        if state % PROGRESS_INTERVAL == 0 && !progress(explorer.interner.len()) {
            return Err(ExploreError::Cancelled);
        }
        explorer.expand(state)?;
        state += 1;
    }
    Ok(explorer.finish(num_initial))
}

struct Explorer<'m, N> {
    model: &'m Model,
    limit: usize,
    layout: Layout,
    events: Vec<CompiledEvent<'m, N>>,
    interner: Interner,
    matrix: Csr<N>,
    choice_start: Vec<usize>,
    choice_action: Vec<u32>,
    rewards: rewards::Builder<'m, N>,
    deadlocks: Vec<usize>,
    labelled_transitions: u64,
    /// The greatest number of roundings behind an entry; `None` if an error is unknown.
    roundings: Option<u32>,
    scratch: Scratch<N>,
}

/// A transition before those with the same target are merged.
#[derive(Clone, Debug)]
struct Outcome<N> {
    target: u32,
    probability: N,
    roundings: Option<u32>,
    action: u32,
}

/// What is known of the state that is being expanded.
struct Scratch<N> {
    values: Vec<i64>,
    key: Vec<i64>,
    /// Updates of the enabled commands: probability, roundings, and a range of `writes`.
    updates: Vec<(N, Option<u32>, Range<usize>)>,
    writes: Vec<(usize, i64)>,
    /// The state itself, packed.
    packed: Vec<u64>,
    /// The enabled commands of an action, for each module, by index.
    ready: Vec<Vec<usize>>,
    /// The same as ranges of `updates`.
    options: Vec<Vec<Range<usize>>>,
    /// The command that is chosen for each module.
    picked: Vec<Range<usize>>,
    /// The products of the updates chosen so far: packed targets, probability, roundings.
    partial: Vec<(N, Option<u32>)>,
    next_partial: Vec<(N, Option<u32>)>,
    partial_targets: Vec<u64>,
    next_targets: Vec<u64>,
    /// Outcomes of the choice, in a chain of all choices.
    outcomes: Vec<Outcome<N>>,
    /// Target (high half) and action (low half) of all outcomes.
    labelled: Vec<u64>,
    /// Actions and probabilities of the outcomes with one target.
    merged: Vec<(u32, N)>,
}

impl<'m, N: Arithmetic> Explorer<'m, N> {
    fn new(model: &'m Model, options: ExploreOptions) -> Self {
        let layout = Layout::new(&model.variables);
        Self {
            limit: options.max_states.min(u32::MAX as usize - 1),
            events: compile(model),
            interner: Interner::new(layout.words()),
            matrix: Csr::with_capacity(0),
            choice_start: Vec::new(),
            choice_action: Vec::new(),
            rewards: rewards::Builder::new(model),
            deadlocks: Vec::new(),
            labelled_transitions: 0,
            roundings: Some(0),
            scratch: Scratch {
                values: vec![0; model.variables.len()],
                key: Vec::new(),
                updates: Vec::new(),
                writes: Vec::new(),
                packed: vec![0; layout.words()],
                ready: Vec::new(),
                options: Vec::new(),
                picked: Vec::new(),
                partial: Vec::new(),
                next_partial: Vec::new(),
                partial_targets: Vec::new(),
                next_targets: Vec::new(),
                outcomes: Vec::new(),
                labelled: Vec::new(),
                merged: Vec::new(),
            },
            layout,
            model,
        }
    }

    /// Numbers the initial states, in the order of their values.
    fn initial_states(&mut self, progress: &dyn Fn(usize) -> bool) -> Result<(), ExploreError> {
        match &self.model.init {
            Init::Single(values) => {
                let mut packed = vec![0; self.layout.words()];
                self.layout.pack(values, &mut packed);
                self.intern(&packed).map(|_| ())
            }
            Init::Predicate(predicate) => self.satisfying_states(predicate, progress),
        }
    }

    fn satisfying_states(
        &mut self,
        predicate: &Expr,
        progress: &dyn Fn(usize) -> bool,
    ) -> Result<(), ExploreError> {
        let bounds: Vec<(i64, i64)> = self
            .model
            .variables
            .iter()
            .map(|v| v.kind.bounds())
            .collect();
        let candidates = bounds.iter().try_fold(1u64, |product, (low, high)| {
            let size = high.checked_sub(*low)?.checked_add(1)?;
            product
                .checked_mul(size as u64)
                .filter(|p| *p <= MAX_CANDIDATES)
        });
        if candidates.is_none() {
            return Err(ExploreError::TooManyCandidates {
                limit: MAX_CANDIDATES,
            });
        }
        let code = Code::new(predicate);
        let mut values: Vec<i64> = bounds.iter().map(|(low, _)| *low).collect();
        let mut packed = vec![0; self.layout.words()];
        for candidate in 0..candidates.unwrap_or(0) {
            if candidate.is_multiple_of(1 << 20) && !progress(self.interner.len()) {
                return Err(ExploreError::Cancelled);
            }
            match code.value(&values) {
                Some(0) => {}
                Some(_) => {
                    self.layout.pack(&values, &mut packed);
                    self.intern(&packed)?;
                }
                None => return Err(no_value(predicate, &values, self.model)),
            }
            count_up(&mut values, &bounds);
        }
        if self.interner.len() == 0 {
            return Err(ExploreError::NoInitialState {
                span: predicate.span,
            });
        }
        Ok(())
    }

    fn intern(&mut self, packed: &[u64]) -> Result<u32, ExploreError> {
        let index = self.interner.intern(packed);
        if self.interner.len() > self.limit {
            return Err(ExploreError::TooManyStates { limit: self.limit });
        }
        Ok(index)
    }

    /// Finds all transitions of a state and appends its rows.
    fn expand(&mut self, state: usize) -> Result<(), ExploreError> {
        self.scratch
            .packed
            .copy_from_slice(self.interner.state(state));
        self.layout
            .unpack(&self.scratch.packed, &mut self.scratch.values);
        self.scratch.outcomes.clear();
        self.scratch.labelled.clear();
        self.rewards.state(&self.scratch.values);
        if self.has_choices() {
            self.choice_start.push(self.matrix.num_rows());
        }
        let mut choices = 0i64;
        for event in 0..self.events.len() {
            choices += self.synchronise(event)?;
        }
        if choices == 0 {
            self.deadlocks.push(state);
            self.labelled_transitions += 1;
            self.matrix.push_row([(state as u32, N::one())]);
            self.rewards.deadlock();
            if self.has_choices() {
                self.choice_action.push(NO_ACTION);
            }
        } else if !self.has_choices() {
            let labelled = &mut self.scratch.labelled;
            labelled.sort_unstable();
            labelled.dedup();
            self.labelled_transitions += labelled.len() as u64;
            self.finish_row(choices);
        }
        Ok(())
    }

    fn has_choices(&self) -> bool {
        self.model.model_type.has_choices()
    }

    /// Makes the choices of an event; returns how many there are.
    fn synchronise(&mut self, event: usize) -> Result<i64, ExploreError> {
        if !self.find_ready(event)? {
            return Ok(0);
        }
        self.find_options(event)?;
        let CompiledEvent { action, ref slots } = self.events[event];
        let span = slots[0][0].source.span;
        let options = std::mem::take(&mut self.scratch.options);
        let modules = slots.len();
        let mut picks = vec![0; modules];
        let mut choices = 0;
        loop {
            self.scratch.picked.clear();
            for (ranges, pick) in options.iter().zip(&picks) {
                self.scratch.picked.push(ranges[*pick].clone());
            }
            choices += 1;
            self.choose(action, span)?;
            let Some(module) = (0..modules).find(|m| picks[*m] + 1 < options[*m].len()) else {
                break;
            };
            picks[module] += 1;
            picks[..module].fill(0);
        }
        self.scratch.options = options;
        Ok(choices)
    }

    /// Finds the enabled commands of each slot of an event; false if some slot has none.
    fn find_ready(&mut self, event: usize) -> Result<bool, ExploreError> {
        let modules = &self.events[event].slots;
        let ready = &mut self.scratch.ready;
        ready.resize(modules.len().max(ready.len()), Vec::new());
        for (commands, ready) in modules.iter().zip(ready) {
            ready.clear();
            for (index, command) in commands.iter().enumerate() {
                if holds(command, &self.scratch.values, self.model)? {
                    ready.push(index);
                }
            }
            if ready.is_empty() {
                return Ok(false);
            }
        }
        Ok(!modules.is_empty())
    }

    /// Evaluates the updates of the enabled commands.
    fn find_options(&mut self, event: usize) -> Result<(), ExploreError> {
        let ready = std::mem::take(&mut self.scratch.ready);
        let mut options = std::mem::take(&mut self.scratch.options);
        self.scratch.updates.clear();
        self.scratch.writes.clear();
        let modules = &mut self.events[event].slots;
        options.resize(modules.len().max(options.len()), Vec::new());
        for ((commands, ready), ranges) in modules.iter_mut().zip(&ready).zip(&mut options) {
            ranges.clear();
            for index in ready {
                let updates = evaluate(&mut commands[*index], &mut self.scratch, self.model)?;
                ranges.push(updates);
            }
        }
        self.scratch.ready = ready;
        self.scratch.options = options;
        Ok(())
    }

    /// Adds the outcomes of one choice: the products of the picked commands' updates.
    fn choose(&mut self, action: u32, span: Span) -> Result<(), ExploreError> {
        let words = self.layout.words();
        let scratch = &mut self.scratch;
        scratch.partial.clear();
        scratch.partial.push((N::one(), Some(0)));
        scratch.partial_targets.clear();
        scratch.partial_targets.extend_from_slice(&scratch.packed);
        for updates in &scratch.picked {
            scratch.next_partial.clear();
            scratch.next_targets.clear();
            for (at, (probability, roundings)) in scratch.partial.iter().enumerate() {
                for (factor, factor_roundings, writes) in &scratch.updates[updates.clone()] {
                    let from = scratch.next_targets.len();
                    let target = &scratch.partial_targets[at * words..(at + 1) * words];
                    scratch.next_targets.extend_from_slice(target);
                    for (variable, value) in &scratch.writes[writes.clone()] {
                        self.layout
                            .store(*variable, *value, &mut scratch.next_targets[from..]);
                    }
                    let joint = product((probability, *roundings), (factor, *factor_roundings));
                    scratch.next_partial.push(joint);
                }
            }
            std::mem::swap(&mut scratch.partial, &mut scratch.next_partial);
            std::mem::swap(&mut scratch.partial_targets, &mut scratch.next_targets);
        }
        self.collect_outcomes(words, action, span)
    }

    fn collect_outcomes(
        &mut self,
        words: usize,
        action: u32,
        span: Span,
    ) -> Result<(), ExploreError> {
        let partial = std::mem::take(&mut self.scratch.partial);
        let targets = std::mem::take(&mut self.scratch.partial_targets);
        for ((probability, roundings), target) in partial.iter().zip(targets.chunks_exact(words)) {
            if !N::EXACT && probability.to_f64() < f64::MIN_POSITIVE {
                let state = describe(&self.model.variables, &self.scratch.values);
                return Err(ExploreError::Underflow { state, span });
            }
            if !probability.is_non_negative() {
                let value = probability.to_f64();
                let state = describe(&self.model.variables, &self.scratch.values);
                return Err(ExploreError::NotAProbability { value, state, span });
            }
            let target = self.intern(target)?;
            self.scratch
                .labelled
                .push(u64::from(target) << 32 | u64::from(action));
            self.scratch.outcomes.push(Outcome {
                target,
                probability: probability.clone(),
                roundings: *roundings,
                action,
            });
        }
        self.scratch.partial = partial;
        self.scratch.partial_targets = targets;
        if self.has_choices() {
            self.choice_action.push(action);
            self.rewards.row(action, &self.scratch.values);
            self.labelled_transitions += self.finish_row(1) as u64;
        }
        Ok(())
    }

    /// Merges outcomes with the same target, in a `dtmc` weighs the choices equally, and appends the row; returns
    /// the number of its entries.
    fn finish_row(&mut self, choices: i64) -> usize {
        let Scratch {
            outcomes,
            merged,
            values,
            ..
        } = &mut self.scratch;
        // Only a uniform choice weighs; rates add up.
        let choices = if self.model.model_type == ModelType::Ctmc {
            1
        } else {
            choices
        };
        let weight = N::from_i64(choices);
        let division = u32::from(!N::EXACT && choices.count_ones() != 1);
        let of_entries = !self.model.model_type.has_choices() && self.rewards.of_transitions();
        outcomes.sort_by_key(|o| o.target);
        let before = self.matrix.column.len();
        for group in outcomes.chunk_by(|a, b| a.target == b.target) {
            let mut sum = group[0].probability.clone();
            let mut roundings = group[0].roundings;
            for more in &group[1..] {
                sum = sum.add(&more.probability);
                let worst = roundings.zip(more.roundings).map(|(a, b)| a.max(b));
                roundings = worst.map(|w| w + u32::from(!N::EXACT));
            }
            if choices > 1 {
                // The weight is at least 2.
                sum = sum.div(&weight).unwrap_or(sum);
            }
            self.matrix.column.push(group[0].target);
            self.matrix.value.push(sum);
            let total = roundings.map(|r| r + division);
            self.roundings = self.roundings.zip(total).map(|(a, b)| a.max(b));
            if of_entries {
                merged.clear();
                merged.extend(group.iter().map(|o| (o.action, o.probability.clone())));
                self.rewards.entry(merged, values);
            }
        }
        outcomes.clear();
        self.matrix.row_start.push(self.matrix.column.len());
        self.matrix.column.len() - before
    }

    fn finish(mut self, num_initial: usize) -> StateSpace<N> {
        let labels = self.model.labels.iter();
        if self.has_choices() {
            self.choice_start.push(self.matrix.num_rows());
        }
        StateSpace {
            kind: self.model.model_type,
            matrix: self.matrix,
            choice_start: self.choice_start,
            choice_action: self.choice_action,
            actions: self.model.actions.clone(),
            rewards: self.rewards.finish(),
            variables: self.model.variables.clone(),
            layout: self.layout,
            packed: self.interner.packed,
            initial: (0..num_initial).collect(),
            deadlocks: self.deadlocks,
            labelled_transitions: self.labelled_transitions,
            labels: labels
                .map(|(name, body)| (name.clone(), LabelStates::Defined(body.clone())))
                .collect(),
            roundings: self.roundings,
        }
    }
}

/// The product of two probabilities; multiplying by 1 needs no rounding.
fn product<N: Arithmetic>(
    (a, a_roundings): (&N, Option<u32>),
    (b, b_roundings): (&N, Option<u32>),
) -> (N, Option<u32>) {
    if *a == N::one() {
        return (b.clone(), b_roundings);
    }
    if *b == N::one() {
        return (a.clone(), a_roundings);
    }
    let before = a_roundings.zip(b_roundings).map(|(a, b)| a + b);
    (a.mul(b), before.map(|r| r + u32::from(!N::EXACT)))
}

/// Goes to the next valuation; the last variable moves fastest.
fn count_up(values: &mut [i64], bounds: &[(i64, i64)]) {
    for (value, (low, high)) in values.iter_mut().zip(bounds).rev() {
        if *value < *high {
            *value += 1;
            return;
        }
        *value = *low;
    }
}

fn holds<N>(
    command: &CompiledCommand<'_, N>,
    values: &[i64],
    model: &Model,
) -> Result<bool, ExploreError> {
    match command.guard.value(values) {
        Some(value) => Ok(value != 0),
        None => Err(no_value(&command.source.guard, values, model)),
    }
}

/// The updates of an enabled command, those of probability 0 left out: a range of `scratch.updates`.
fn evaluate<N: Arithmetic>(
    command: &mut CompiledCommand<'_, N>,
    scratch: &mut Scratch<N>,
    model: &Model,
) -> Result<Range<usize>, ExploreError> {
    let first = scratch.updates.len();
    let mut sum = N::zero();
    for (index, update) in command.updates.iter_mut().enumerate() {
        let probability =
            (update.probability).value(&scratch.values, &mut scratch.key, probability);
        let probability = probability.map_err(|bad| {
            let span = command.source.updates[index].probability.span;
            bad_probability(bad, span, &scratch.values, model)
        })?;
        if !command.sum_known {
            sum = sum.add(&probability.value);
        }
        if probability.value.is_zero() {
            continue;
        }
        let start = scratch.writes.len();
        for (variable, code, expr) in &update.assignments {
            let value = code
                .value(&scratch.values)
                .ok_or_else(|| no_value(expr, &scratch.values, model))?;
            in_range(*variable, value, expr.span, &scratch.values, model)?;
            scratch.writes.push((*variable, value));
        }
        let writes = start..scratch.writes.len();
        scratch
            .updates
            .push((probability.value, probability.roundings, writes));
    }
    if !command.sum_known {
        check_sum(&sum, command.source.span, &scratch.values, model)?;
        command.sum_known = command.is_constant();
    }
    Ok(first..scratch.updates.len())
}
