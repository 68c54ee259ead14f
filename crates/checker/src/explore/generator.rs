//! The transitions of a state: its enabled events, and for each choice the products of the commands' updates.
//!
//! Definition: as in [`super`]. An event with one slot gives a choice for each enabled command; one with several
//! slots a choice for each way to pick an enabled command from every slot. The outcomes of a choice are built
//! in place: each command multiplies what the commands before it gave. Right-hand sides read the state itself,
//! so that assignments are simultaneous.
//!
//! Cost: the guards' tables ([`super::guards`]), plus a few word operations for each assignment of each outcome.
//! Guarantee: outcomes come in the order of events, commands and updates, whatever the domain.

use prism_lang::resolved::{Command, Model, ModelType};
use prism_lang::{Arithmetic, Span};

use super::batch::{Batch, UNKNOWN};
use super::code::Compiler;
use super::command::{CompiledCommand, CompiledUpdate, Rounded, probability};
use super::fault::{bad_probability, check_sum, no_value, out_of_range};
use super::guards::Guards;
use super::intern::append;
use super::orbits::Orbits;
use super::plan::{Group, Plan, SlotBits};
use super::{ExploreError, ExploreOptions};

/// Finds the transitions of states, one after the other. Tables that it fills on the way are its own.
#[derive(Clone)]
pub(super) struct Generator<'m, N> {
    pub(super) compiler: Compiler<'m>,
    commands: Vec<CompiledCommand<'m, N>>,
    /// The action of each command that happens alone.
    actions: Vec<u32>,
    groups: Vec<Group>,
    guards: Guards,
    enabled: Vec<u64>,
    /// For each slot of an event its enabled commands, and which of them is picked.
    ready: Vec<Vec<usize>>,
    picks: Vec<usize>,
    kept: Kept<N>,
    /// The symmetries up to which targets are the same.
    pub(super) orbits: Option<Orbits>,
    has_choices: bool,
}

impl<'m, N: Arithmetic> Generator<'m, N> {
    pub(super) fn new(model: &'m Model, compiler: Compiler<'m>, options: &ExploreOptions) -> Self {
        let plan = Plan::new(model);
        let kind = model.model_type;
        // Rates and weights need not sum to anything.
        let sums = kind != ModelType::Ctmc && !options.weights(kind);
        let guards = plan.commands.iter().map(|c| compiler.code(&c.guard));
        let guards = Guards::new(guards.collect(), compiler.layout);
        let compiled = |c: &&'m Command| CompiledCommand::new(c, sums, compiler);
        Self {
            compiler,
            commands: plan.commands.iter().map(compiled).collect(),
            actions: plan.actions,
            groups: plan.groups,
            enabled: vec![0; guards.words()],
            guards,
            ready: Vec::new(),
            picks: Vec::new(),
            kept: Kept {
                targets: Vec::new(),
                probabilities: Vec::new(),
                roundings: Vec::new(),
            },
            orbits: Orbits::new(&options.symmetry, compiler.layout),
            has_choices: kind.has_choices(),
        }
    }

    /// Expands a batch's states until one has an error or the batch is full.
    pub(super) fn fill(&mut self, batch: &mut Batch<N>) {
        let words = self.compiler.layout.words();
        let states = std::mem::take(&mut batch.states);
        for state in states.chunks_exact(words) {
            if let Err(error) = self.expand(state, batch) {
                batch.error = Some(error);
                break;
            }
            batch.ends.push(batch.choices.len() as u32);
            if batch.is_full() {
                break;
            }
        }
        batch.states = states;
        if let Some(orbits) = &mut self.orbits {
            orbits.fold(batch, self.has_choices);
        }
    }

    fn expand(&mut self, state: &[u64], batch: &mut Batch<N>) -> Result<(), ExploreError> {
        let mut enabled = std::mem::take(&mut self.enabled);
        let result = self.expand_into(state, &mut enabled, batch);
        self.enabled = enabled;
        result
    }

    fn expand_into(
        &mut self,
        state: &[u64],
        enabled: &mut [u64],
        batch: &mut Batch<N>,
    ) -> Result<(), ExploreError> {
        self.guards.tabulated(state, enabled);
        self.evaluate_rest(state, enabled)?;
        let groups = std::mem::take(&mut self.groups);
        let mut result = Ok(());
        for group in &groups {
            result = match group {
                Group::Alone(bits) => self.alone(bits, state, enabled, batch),
                Group::Together(action, slots) => {
                    self.together(*action, slots, state, enabled, batch)
                }
            };
            if result.is_err() {
                break;
            }
        }
        self.groups = groups;
        result
    }

    /// Evaluates what the tables leave open, and disables what does not hold.
    fn evaluate_rest(&self, state: &[u64], enabled: &mut [u64]) -> Result<(), ExploreError> {
        for (word, has_rest) in self.guards.has_rest.iter().enumerate() {
            let mut open = enabled[word] & has_rest;
            while open != 0 {
                let bit = open.trailing_zeros();
                open &= open - 1;
                let command = word * 64 + bit as usize;
                let mut holds = true;
                for part in &self.guards.rest[command] {
                    match part.value(state) {
                        Some(0) => holds = false,
                        Some(_) => continue,
                        None => {
                            let guard = &self.commands[command].source.guard;
                            let value = self.compiler.slowly(guard, state);
                            holds = value.map_err(|e| no_value(e, state, self.compiler))? != 0;
                        }
                    }
                    break;
                }
                if !holds {
                    enabled[word] &= !(1 << bit);
                }
            }
        }
        Ok(())
    }

    /// A choice for each enabled command.
    fn alone(
        &mut self,
        bits: &SlotBits,
        state: &[u64],
        enabled: &[u64],
        batch: &mut Batch<N>,
    ) -> Result<(), ExploreError> {
        for (word, mask) in bits {
            let mut open = enabled[*word] & mask;
            while open != 0 {
                let command = word * 64 + open.trailing_zeros() as usize;
                open &= open - 1;
                match &self.commands[command].simple {
                    Some(factor) => self.apply_simple(command, factor, state, batch)?,
                    None => {
                        let first = batch.probabilities.len();
                        self.start(state, batch);
                        self.apply(command, state, first, batch)?;
                    }
                }
                self.finish(self.actions[command], batch);
            }
        }
        Ok(())
    }

    /// A choice for each way to pick an enabled command of every slot.
    fn together(
        &mut self,
        action: u32,
        slots: &[SlotBits],
        state: &[u64],
        enabled: &[u64],
        batch: &mut Batch<N>,
    ) -> Result<(), ExploreError> {
        let is_ready = |(word, mask): &(usize, u64)| enabled[*word] & mask != 0;
        if !slots.iter().all(|slot| slot.iter().any(is_ready)) {
            return Ok(());
        }
        self.find_ready(slots, enabled);
        self.picks.clear();
        self.picks.resize(slots.len(), 0);
        loop {
            self.picked(slots.len(), state, batch)?;
            self.finish(action, batch);
            let next = (0..slots.len()).find(|s| self.picks[*s] + 1 < self.ready[*s].len());
            let Some(slot) = next else {
                return Ok(());
            };
            self.picks[slot] += 1;
            self.picks[..slot].fill(0);
        }
    }

    /// The outcomes of the commands that are picked, one of each slot.
    fn picked(
        &mut self,
        slots: usize,
        state: &[u64],
        batch: &mut Batch<N>,
    ) -> Result<(), ExploreError> {
        let first = batch.probabilities.len();
        self.start(state, batch);
        for slot in 0..slots {
            let number = self.ready[slot][self.picks[slot]];
            let command = &self.commands[number];
            match &command.simple {
                Some(factor) => {
                    let outcomes = first..batch.probabilities.len();
                    self.outcomes(&command.updates[0], factor, state, outcomes, batch)?;
                }
                None => self.apply(number, state, first, batch)?,
            }
        }
        self.check_products(state, first, batch)
    }

    fn find_ready(&mut self, slots: &[SlotBits], enabled: &[u64]) {
        self.ready
            .resize(slots.len().max(self.ready.len()), Vec::new());
        for (slot, ready) in slots.iter().zip(&mut self.ready) {
            ready.clear();
            for (word, mask) in slot {
                let mut open = enabled[*word] & mask;
                while open != 0 {
                    ready.push(word * 64 + open.trailing_zeros() as usize);
                    open &= open - 1;
                }
            }
        }
    }

    /// Begins a choice: the state itself, for sure.
    fn start(&self, state: &[u64], batch: &mut Batch<N>) {
        append(&mut batch.targets, state);
        batch.probabilities.push(N::one());
        batch.roundings.push(0);
    }

    fn finish(&self, action: u32, batch: &mut Batch<N>) {
        batch
            .choices
            .push((batch.probabilities.len() as u32, action));
    }

    /// The one outcome of a command with one update of a constant probability.
    fn apply_simple(
        &self,
        command: usize,
        factor: &Rounded<N>,
        state: &[u64],
        batch: &mut Batch<N>,
    ) -> Result<(), ExploreError> {
        let update = &self.commands[command].updates[0];
        self.check_increments(update, state)?;
        let at = batch.probabilities.len();
        let from = batch.targets.len();
        append(&mut batch.targets, state);
        update.apply_masks(&mut batch.targets[from..]);
        batch.probabilities.push(factor.value.clone());
        batch.roundings.push(factor.roundings.unwrap_or(UNKNOWN));
        self.compute(update, state, at..at + 1, batch)
    }

    /// Multiplies the outcomes from `first` on with the updates of a command.
    fn apply(
        &mut self,
        command: usize,
        state: &[u64],
        first: usize,
        batch: &mut Batch<N>,
    ) -> Result<(), ExploreError> {
        let mut updates = std::mem::take(&mut self.commands[command].updates);
        let result = self.multiply(command, &mut updates, state, first, batch);
        self.commands[command].updates = updates;
        let sum = result?;
        let known = &mut self.commands[command];
        if !known.sum_known {
            known.sum_known = known.is_constant;
            check_sum(&sum, known.source.span, state, self.compiler)?;
        }
        Ok(())
    }

    /// Multiplies the outcomes from `first` on with updates; returns the sum of their probabilities.
    fn multiply(
        &mut self,
        command: usize,
        updates: &mut [CompiledUpdate<'m, N>],
        state: &[u64],
        first: usize,
        batch: &mut Batch<N>,
    ) -> Result<N, ExploreError> {
        let words = self.compiler.layout.words();
        let before = batch.probabilities.len() - first;
        let several = updates.len() > 1;
        if several {
            self.kept.keep(first, words, batch);
        }
        let mut sum = N::zero();
        let mut place = first;
        for (index, update) in updates.iter_mut().enumerate() {
            let factor =
                (update.probability.value(state, self.compiler, probability)).map_err(|bad| {
                    bad_probability(bad, self.place(command, index), state, self.compiler)
                })?;
            sum = sum.add(&factor.value);
            if factor.value.is_zero() {
                continue;
            }
            if several {
                self.kept.restore(place, words, batch);
            }
            self.outcomes(update, &factor, state, place..place + before, batch)?;
            place += before;
        }
        batch.targets.truncate(place * words);
        batch.probabilities.truncate(place);
        batch.roundings.truncate(place);
        Ok(sum)
    }

    fn place(&self, command: usize, update: usize) -> Span {
        let command = self.commands[command].source;
        let update = command.updates.get(update);
        update.map_or(command.span, |u| u.probability.span)
    }

    /// Multiplies outcomes with one update.
    fn outcomes(
        &self,
        update: &CompiledUpdate<'m, N>,
        factor: &Rounded<N>,
        state: &[u64],
        outcomes: std::ops::Range<usize>,
        batch: &mut Batch<N>,
    ) -> Result<(), ExploreError> {
        let words = self.compiler.layout.words();
        self.check_increments(update, state)?;
        let is_one = factor.value == N::one();
        for outcome in outcomes.clone() {
            let target = &mut batch.targets[outcome * words..(outcome + 1) * words];
            update.apply_masks(target);
            if !is_one {
                let probability = &mut batch.probabilities[outcome];
                let roundings = &mut batch.roundings[outcome];
                let behind = factor.roundings.unwrap_or(UNKNOWN);
                if *probability == N::one() {
                    *probability = factor.value.clone();
                    *roundings = behind;
                } else {
                    *probability = probability.mul(&factor.value);
                    *roundings += behind + u32::from(!N::EXACT);
                }
            }
        }
        self.compute(update, state, outcomes, batch)
    }

    /// Whether all increments stay in range.
    #[inline]
    fn check_increments(
        &self,
        update: &CompiledUpdate<'m, N>,
        state: &[u64],
    ) -> Result<(), ExploreError> {
        for increment in &update.increments {
            let value = increment.field.value(state);
            if value < increment.low || value > increment.high {
                let (variable, source) = (increment.variable, increment.source);
                return Err(out_of_range(variable, source, state, self.compiler));
            }
        }
        Ok(())
    }

    /// Assigns what must be computed to some outcomes.
    fn compute(
        &self,
        update: &CompiledUpdate<'m, N>,
        state: &[u64],
        outcomes: std::ops::Range<usize>,
        batch: &mut Batch<N>,
    ) -> Result<(), ExploreError> {
        let words = self.compiler.layout.words();
        for computed in &update.computed {
            let value = match computed.code.value(state) {
                Some(value) => value,
                None => (self.compiler.slowly(computed.source, state))
                    .map_err(|error| no_value(error, state, self.compiler))?,
            };
            let (low, high) = computed.field.bounds();
            if !computed.fits && (value < low || value > high) {
                return Err(out_of_range(
                    computed.variable,
                    computed.source,
                    state,
                    self.compiler,
                ));
            }
            let bits = computed.field.bits(value);
            for outcome in outcomes.clone() {
                batch.targets[outcome * words + computed.field.word] |= bits;
            }
        }
        Ok(())
    }

    /// Products of positive numbers must not become 0 or infinite.
    fn check_products(
        &self,
        state: &[u64],
        first: usize,
        batch: &Batch<N>,
    ) -> Result<(), ExploreError> {
        if N::EXACT {
            return Ok(());
        }
        for probability in &batch.probabilities[first..] {
            let value = probability.to_f64();
            if !(f64::MIN_POSITIVE..=f64::MAX).contains(&value) {
                let command = self.ready[0][self.picks[0]];
                let span = self.commands[command].source.span;
                let bad = if value < f64::MIN_POSITIVE {
                    super::command::BadNumber::Underflow
                } else {
                    super::command::BadNumber::OutOfBounds(value)
                };
                return Err(bad_probability(bad, span, state, self.compiler));
            }
        }
        Ok(())
    }
}

/// The outcomes of the commands before, which every update of a command multiplies.
#[derive(Clone)]
struct Kept<N> {
    targets: Vec<u64>,
    probabilities: Vec<N>,
    roundings: Vec<u32>,
}

impl<N: Clone> Kept<N> {
    fn keep(&mut self, first: usize, words: usize, batch: &Batch<N>) {
        self.targets.clear();
        self.targets
            .extend_from_slice(&batch.targets[first * words..]);
        self.probabilities.clear();
        self.probabilities
            .extend_from_slice(&batch.probabilities[first..]);
        self.roundings.clear();
        self.roundings.extend_from_slice(&batch.roundings[first..]);
    }

    /// Puts them at a place, which is where the outcomes so far end, or begin.
    fn restore(&self, place: usize, words: usize, batch: &mut Batch<N>) {
        batch.targets.truncate(place * words);
        batch.probabilities.truncate(place);
        batch.roundings.truncate(place);
        batch.targets.extend_from_slice(&self.targets);
        batch.probabilities.extend_from_slice(&self.probabilities);
        batch.roundings.extend_from_slice(&self.roundings);
    }
}
