//! From numbered transitions to the rows of the matrix.
//!
//! Definition: a chain's row merges the outcomes of all choices with the same target, each weighted with one
//! over the number of choices in a `dtmc`; otherwise each choice's outcomes are merged into a row of its own.
//! Columns ascend. Cost: sorting of each row. Guarantee: every rounding is counted.

use prism_lang::Arithmetic;
use prism_lang::resolved::{Model, ModelType};

use super::batch::{Batch, UNKNOWN};
use super::code::Compiler;
use super::{ExploreOptions, rewards};
use crate::state_space::{Csr, NO_ACTION};

/// A transition before those with the same target are merged.
#[derive(Clone, Debug)]
struct Outcome<N> {
    target: u32,
    action: u32,
    roundings: u32,
    probability: N,
}

/// The rows so far.
pub(super) struct Assembly<'m, N> {
    kind: ModelType,
    /// Whether rows are divided by their sums.
    weights: bool,
    pub(super) matrix: Csr<N>,
    pub(super) choice_start: Vec<usize>,
    pub(super) choice_action: Vec<u32>,
    pub(super) rewards: rewards::Builder<'m, N>,
    pub(super) deadlocks: Vec<usize>,
    pub(super) labelled_transitions: u64,
    /// The greatest number of roundings behind an entry.
    roundings: u32,
    states: usize,
    outcomes: Vec<Outcome<N>>,
    merged: Vec<(u32, N)>,
}

impl<'m, N: Arithmetic> Assembly<'m, N> {
    pub(super) fn new(model: &'m Model, compiler: Compiler<'m>, options: &ExploreOptions) -> Self {
        Self {
            kind: model.model_type,
            weights: options.weights(model.model_type),
            matrix: Csr::with_capacity(0),
            choice_start: Vec::new(),
            choice_action: Vec::new(),
            rewards: rewards::Builder::new(model, compiler, options.rewards.as_deref()),
            deadlocks: Vec::new(),
            labelled_transitions: 0,
            roundings: 0,
            states: 0,
            outcomes: Vec::new(),
            merged: Vec::new(),
        }
    }

    /// The number of states whose rows are there.
    pub(super) fn states(&self) -> usize {
        self.states
    }

    /// The greatest number of roundings behind an entry of the matrix; `None` if an error is unknown.
    pub(super) fn roundings(&self) -> Option<u32> {
        (self.roundings < UNKNOWN).then_some(self.roundings)
    }

    /// The bytes that it takes.
    pub(super) fn bytes(&self) -> usize {
        let entry = size_of::<u32>() + size_of::<N>();
        self.matrix.num_entries() * entry
            + (self.matrix.row_start.len() + self.choice_start.len()) * size_of::<usize>()
            + self.choice_action.len() * size_of::<u32>()
            + self.rewards.bytes()
    }

    /// Appends the rows of the batch's states, whose targets are numbered.
    pub(super) fn append(&mut self, batch: &Batch<N>, words: usize) {
        let (mut choice, mut outcome) = (0, 0);
        for (end, state) in batch.ends.iter().zip(batch.states.chunks_exact(words)) {
            let choices = &batch.choices[choice..*end as usize];
            let first = outcome;
            outcome = choices.last().map_or(first, |(stop, _)| *stop as usize);
            self.rewards.state(state);
            if self.kind.has_choices() {
                self.choice_start.push(self.matrix.num_rows());
            }
            if outcome == first {
                // Nothing is enabled, or all rates are 0.
                self.deadlock();
            } else if self.kind.has_choices() {
                self.choices(choices, first, state, batch);
            } else {
                self.collect(choices, first, batch);
                self.finish_row(choices.len(), state);
            }
            choice = *end as usize;
            self.states += 1;
        }
    }

    /// Appends a row for each choice, whose outcomes start at `first`.
    fn choices(&mut self, choices: &[(u32, u32)], first: usize, state: &[u64], batch: &Batch<N>) {
        let before = self.matrix.num_entries();
        let mut first = first;
        for choice in choices {
            self.collect(std::slice::from_ref(choice), first, batch);
            first = choice.0 as usize;
            self.choice_action.push(choice.1);
            self.rewards.row(choice.1, state);
            self.finish_row(1, state);
        }
        self.labelled_transitions += (self.matrix.num_entries() - before) as u64;
    }

    /// A self-loop where nothing is enabled.
    fn deadlock(&mut self) {
        self.deadlocks.push(self.states);
        self.labelled_transitions += 1;
        self.matrix.push_row([(self.states as u32, N::one())]);
        self.rewards.deadlock();
        if self.kind.has_choices() {
            self.choice_action.push(NO_ACTION);
        }
    }

    /// Gathers the outcomes of choices, which start at `first`.
    fn collect(&mut self, choices: &[(u32, u32)], first: usize, batch: &Batch<N>) {
        let mut at = first;
        for (stop, action) in choices {
            while at < *stop as usize {
                self.outcomes.push(Outcome {
                    target: batch.numbers[at],
                    action: *action,
                    roundings: batch.roundings[at],
                    probability: batch.probabilities[at].clone(),
                });
                at += 1;
            }
        }
    }

    /// What the probabilities of a row are divided by, and how many roundings that takes.
    fn weight(&self, choices: usize) -> (Option<N>, u32) {
        if self.weights {
            let each = self.outcomes.iter().map(|o| &o.probability);
            let sum = each.fold(N::zero(), |sum, p| sum.add(p));
            let roundings = self.outcomes.iter().map(|o| o.roundings).max().unwrap_or(0);
            let own = u32::from(!N::EXACT) * (self.outcomes.len() as u32 + 1);
            return (Some(sum), roundings + own);
        }
        if self.kind != ModelType::Dtmc || choices < 2 {
            return (None, 0);
        }
        let division = u32::from(!N::EXACT && !choices.is_power_of_two());
        (Some(N::from_i64(choices as i64)), division)
    }

    /// Merges outcomes with the same target, in a `dtmc` weighs the choices equally, and appends the row.
    fn finish_row(&mut self, choices: usize, state: &[u64]) {
        let (weight, division) = self.weight(choices);
        let of_entries = !self.kind.has_choices() && self.rewards.of_transitions();
        sort(&mut self.outcomes);
        for group in self.outcomes.chunk_by(|a, b| a.target == b.target) {
            let mut sum = group[0].probability.clone();
            let mut roundings = group[0].roundings;
            for more in &group[1..] {
                sum = sum.add(&more.probability);
                roundings = roundings.max(more.roundings) + u32::from(!N::EXACT);
            }
            if let Some(weight) = &weight {
                // The weight is positive.
                sum = sum.div(weight).unwrap_or(sum);
            }
            self.matrix.column.push(group[0].target);
            self.matrix.value.push(sum);
            self.roundings = self.roundings.max(roundings + division);
            if !self.kind.has_choices() {
                self.labelled_transitions += distinct_actions(group);
            }
            if of_entries {
                self.merged.clear();
                let actions = group.iter().map(|o| (o.action, o.probability.clone()));
                self.merged.extend(actions);
                self.rewards.entry(&self.merged, state);
            }
        }
        self.outcomes.clear();
        self.matrix.row_start.push(self.matrix.column.len());
    }
}

/// Sorts by target, keeping the order of the same ones.
fn sort<N>(outcomes: &mut [Outcome<N>]) {
    const FEW: usize = 20;
    if outcomes.len() > FEW {
        outcomes.sort_by_key(|o| o.target);
        return;
    }
    for end in 1..outcomes.len() {
        let mut at = end;
        while at > 0 && outcomes[at - 1].target > outcomes[at].target {
            outcomes.swap(at - 1, at);
            at -= 1;
        }
    }
}

/// The number of different actions.
fn distinct_actions<N>(group: &[Outcome<N>]) -> u64 {
    let is_new = |at: usize| group[..at].iter().all(|o| o.action != group[at].action);
    (0..group.len()).filter(|at| is_new(*at)).count() as u64
}
