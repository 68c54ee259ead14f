//! From a model to its reachable states and transitions.
//!
//! Definition: in a state, the choices are the enabled commands without action and, for each action, one
//! enabled command of every module that has commands with that action. A choice's outcomes are the products
//! of its commands' updates. With `k` choices each is taken with probability `1/k`. Outcomes of probability 0
//! are dropped, outcomes with the same target are merged, a state without choices gets a self-loop.
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
mod fault;
mod intern;

use std::ops::Range;

use prism_lang::resolved::{Init, Model, ModelType};
use prism_lang::{Arithmetic, Expr, Span};

use crate::state_space::{Csr, LabelStates, Layout, StateSpace, describe};
use code::Code;
use command::{Commands, CompiledCommand};
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
/// If the model is no `dtmc`, leaves a variable's range, has probabilities that do not sum to 1, or too many states.
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
    if model.model_type != ModelType::Dtmc {
        return Err(ExploreError::Unsupported(model.model_type));
    }
    if model.composition.is_some() {
        return Err(ExploreError::UnsupportedConstruct(
            "`system ... endsystem` cannot be explored yet: let the modules synchronise on all actions that they share",
        ));
    }
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
    commands: Commands<'m, N>,
    interner: Interner,
    matrix: Csr<N>,
    deadlocks: Vec<usize>,
    labelled_transitions: u64,
    /// The greatest number of roundings behind an entry; `None` if an error is unknown.
    roundings: Option<u32>,
    scratch: Scratch<N>,
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
    /// Outcomes of all choices: target, probability, roundings.
    outcomes: Vec<(u32, N, Option<u32>)>,
    /// Target (high half) and action (low half, 0 for none) of all outcomes.
    labelled: Vec<u64>,
}

impl<'m, N: Arithmetic> Explorer<'m, N> {
    fn new(model: &'m Model, options: ExploreOptions) -> Self {
        let layout = Layout::new(&model.variables);
        Self {
            limit: options.max_states.min(u32::MAX as usize - 1),
            commands: Commands::new(model),
            interner: Interner::new(layout.words()),
            matrix: Csr::with_capacity(0),
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

    /// Finds all transitions of a state and appends its row.
    fn expand(&mut self, state: usize) -> Result<(), ExploreError> {
        self.scratch
            .packed
            .copy_from_slice(self.interner.state(state));
        self.layout
            .unpack(&self.scratch.packed, &mut self.scratch.values);
        self.scratch.outcomes.clear();
        self.scratch.labelled.clear();
        let mut choices = 0i64;
        for index in 0..self.commands.alone.len() {
            self.scratch.updates.clear();
            self.scratch.writes.clear();
            let command = &mut self.commands.alone[index];
            if let Some(updates) = enabled(command, &mut self.scratch, self.model)? {
                let span = command.source.span;
                choices += 1;
                self.scratch.picked.clear();
                self.scratch.picked.push(updates);
                self.choose(0, span)?;
            }
        }
        for action in 0..self.commands.together.len() {
            choices += self.synchronise(action)?;
        }
        if choices == 0 {
            self.deadlocks.push(state);
            self.labelled_transitions += 1;
            self.matrix.push_row([(state as u32, N::one())]);
            return Ok(());
        }
        self.finish_row(choices)
    }

    /// Makes the choices of an action; returns how many there are.
    fn synchronise(&mut self, action: usize) -> Result<i64, ExploreError> {
        if !self.find_ready(action)? {
            return Ok(0);
        }
        self.find_options(action)?;
        let span = self.commands.together[action][0][0].source.span;
        let options = std::mem::take(&mut self.scratch.options);
        let modules = self.commands.together[action].len();
        let mut picks = vec![0; modules];
        let mut choices = 0;
        loop {
            self.scratch.picked.clear();
            for (ranges, pick) in options.iter().zip(&picks) {
                self.scratch.picked.push(ranges[*pick].clone());
            }
            choices += 1;
            self.choose(action as u32 + 1, span)?;
            let Some(module) = (0..modules).find(|m| picks[*m] + 1 < options[*m].len()) else {
                break;
            };
            picks[module] += 1;
            picks[..module].fill(0);
        }
        self.scratch.options = options;
        Ok(choices)
    }

    /// Finds the enabled commands of each module for an action; false if some module has none.
    fn find_ready(&mut self, action: usize) -> Result<bool, ExploreError> {
        let modules = &self.commands.together[action];
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
    fn find_options(&mut self, action: usize) -> Result<(), ExploreError> {
        let ready = std::mem::take(&mut self.scratch.ready);
        let mut options = std::mem::take(&mut self.scratch.options);
        self.scratch.updates.clear();
        self.scratch.writes.clear();
        let modules = &mut self.commands.together[action];
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
            let target = self.intern(target)?;
            self.scratch
                .labelled
                .push(u64::from(target) << 32 | u64::from(action));
            let outcome = (target, probability.clone(), *roundings);
            self.scratch.outcomes.push(outcome);
        }
        self.scratch.partial = partial;
        self.scratch.partial_targets = targets;
        Ok(())
    }

    /// Merges outcomes with the same target, weighs the choices equally and appends the row.
    fn finish_row(&mut self, choices: i64) -> Result<(), ExploreError> {
        let labelled = &mut self.scratch.labelled;
        labelled.sort_unstable();
        labelled.dedup();
        self.labelled_transitions += labelled.len() as u64;
        let outcomes = &mut self.scratch.outcomes;
        outcomes.sort_by_key(|(target, ..)| *target);
        let weight = N::from_i64(choices);
        let division = u32::from(!N::EXACT && choices.count_ones() != 1);
        let mut merged = outcomes.drain(..).peekable();
        while let Some((target, mut sum, mut roundings)) = merged.next() {
            while let Some((_, more, more_roundings)) = merged.next_if(|(t, ..)| *t == target) {
                sum = sum.add(&more);
                let worst = roundings.zip(more_roundings).map(|(a, b)| a.max(b));
                roundings = worst.map(|w| w + u32::from(!N::EXACT));
            }
            if choices > 1 {
                // The weight is at least 2.
                sum = sum.div(&weight).unwrap_or(sum);
            }
            self.matrix.column.push(target);
            self.matrix.value.push(sum);
            let total = roundings.map(|r| r + division);
            self.roundings = self.roundings.zip(total).map(|(a, b)| a.max(b));
        }
        self.matrix.row_start.push(self.matrix.column.len());
        Ok(())
    }

    fn finish(self, num_initial: usize) -> StateSpace<N> {
        let labels = self.model.labels.iter();
        StateSpace {
            matrix: self.matrix,
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

/// The updates of a command if it is enabled.
fn enabled<N: Arithmetic>(
    command: &mut CompiledCommand<'_, N>,
    scratch: &mut Scratch<N>,
    model: &Model,
) -> Result<Option<Range<usize>>, ExploreError> {
    if !holds(command, &scratch.values, model)? {
        return Ok(None);
    }
    evaluate(command, scratch, model).map(Some)
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
        let probability = update.probability.value(&scratch.values, &mut scratch.key);
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
