//! The transitions of some consecutive states, before targets are numbered.

use super::ExploreError;
use crate::state_space::Represented;

/// Transitions of consecutive states: for each state its choices, for each choice its outcomes.
#[derive(Debug)]
pub(super) struct Batch<N> {
    /// The states, packed.
    pub(super) states: Vec<u64>,
    /// The outcomes' targets, packed, and their probabilities or rates.
    pub(super) targets: Vec<u64>,
    pub(super) probabilities: Vec<N>,
    /// The roundings behind each probability; [`UNKNOWN`] where that is not known.
    pub(super) roundings: Vec<u32>,
    /// Where the outcomes of each choice end, and its action.
    pub(super) choices: Vec<(u32, u32)>,
    /// Where the choices of each state end.
    pub(super) ends: Vec<u32>,
    /// Why the state behind the last complete one could not be expanded.
    pub(super) error: Option<ExploreError>,
    /// The targets' numbers.
    pub(super) numbers: Vec<u32>,
    /// What the expanded states stand for, if there are symmetries.
    pub(super) represented: Represented,
}

/// A number of roundings that is not known.
pub(super) const UNKNOWN: u32 = 1 << 30;

impl<N> Batch<N> {
    pub(super) fn new() -> Self {
        Self {
            states: Vec::new(),
            targets: Vec::new(),
            probabilities: Vec::new(),
            roundings: Vec::new(),
            choices: Vec::new(),
            ends: Vec::new(),
            error: None,
            numbers: Vec::new(),
            represented: Represented::default(),
        }
    }

    /// Whether there is no room for the transitions of more states: the memory of a batch stays bounded also where
    /// each state has very many.
    pub(super) fn is_full(&self) -> bool {
        const MOST_OUTCOMES: usize = 1 << 18;
        self.probabilities.len() >= MOST_OUTCOMES
    }

    /// Leaves the states that were not expanded, if any, and nothing else; says whether there are some.
    pub(super) fn keep_rest(&mut self, words: usize) -> bool {
        let states = self.states.split_off(self.ends.len() * words);
        self.clear();
        self.states = states;
        !self.states.is_empty()
    }

    pub(super) fn clear(&mut self) {
        self.states.clear();
        self.targets.clear();
        self.probabilities.clear();
        self.roundings.clear();
        self.choices.clear();
        self.ends.clear();
        self.error = None;
        self.represented = Represented::default();
    }
}
