//! The chain that a scheduler induces.
//!
//! *Definition.* The states that are reachable when each state takes the choice that the scheduler names; where it
//! names none (its choice does not matter, or the state is not reached) the first one. States keep their values,
//! labels and rewards. Cost: linear. Guarantee: the probabilities are those of the model, bit by bit.

use prism_lang::Arithmetic;
use prism_lang::resolved::ModelType;

use super::{LabelStates, RewardsOf, StateSpace};
use crate::explore::ExploreError;
use crate::state_space::{Csr, Rewards, TransitionRewards};

/// The state has no number yet.
const NEW: u32 = u32::MAX;

impl<N: Arithmetic> StateSpace<N> {
    /// The `dtmc` that a scheduler induces: a row of the matrix for each state, as in
    /// [`Answer::scheduler`](crate::Answer::scheduler). A chain induces what is reachable of itself.
    ///
    /// # Panics
    /// If a row is not one of the state's choices, or if entries are missing.
    ///
    /// ```
    /// use checker::explore::explore;
    /// use checker::{AnswerValue, Options, check, check_space};
    /// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
    /// let text = "mdp module m x : [0..2]; [a] x=0 -> 0.4:(x'=1) + 0.6:(x'=2); [b] x=0 -> (x'=2); endmodule";
    /// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    /// let asked = parse_properties("Pmax=? [ F x=1 ]").tree;
    /// let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
    /// let space = explore::<f64>(&model)?;
    /// let best = check(&space, &model, &asked[0].property, &Options::default())?;
    /// let chain = space.induced(best.scheduler.as_ref().unwrap());
    /// let of_chain = check_space(&chain, &asked[0].property, &Options::default())?;
    /// assert_eq!((of_chain.value, chain.num_transitions()), (best.value, 4));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn induced(&self, scheduler: &[Option<usize>]) -> Self {
        let rows = |state: usize| self.row_of(scheduler, state);
        let order = self.reached(rows);
        let mut number = vec![NEW; self.num_states()];
        for (place, state) in order.iter().enumerate() {
            number[*state] = place as u32;
        }
        let chosen: Vec<usize> = order.iter().map(|state| rows(*state)).collect();
        let entries: Vec<Vec<usize>> = chosen
            .iter()
            .map(|row| self.sorted(*row, &number))
            .collect();
        let mut matrix = Csr::with_capacity(order.len());
        for places in &entries {
            let entry = |at: &usize| {
                let target = number[self.matrix.column[*at] as usize];
                (target, self.matrix.value[*at].clone())
            };
            matrix.push_row(places.iter().map(entry));
        }
        let kept = Kept {
            order: &order,
            chosen: &chosen,
            entries: &entries,
        };
        let renumbered = |states: &[usize]| {
            let mut found: Vec<usize> = (states.iter().map(|state| number[*state]))
                .filter(|state| *state != NEW)
                .map(|state| state as usize)
                .collect();
            found.sort_unstable();
            found
        };
        let words = self.layout.words();
        let packed = |state: &usize| &self.packed[state * words..(state + 1) * words];
        Self {
            kind: if self.kind == ModelType::Ctmc {
                self.kind
            } else {
                ModelType::Dtmc
            },
            labelled_transitions: matrix.num_entries() as u64,
            matrix,
            choice_start: Vec::new(),
            choice_action: Vec::new(),
            actions: self.actions.clone(),
            variables: self.variables.clone(),
            layout: self.layout.clone(),
            packed: order.iter().flat_map(packed).copied().collect(),
            initial: renumbered(&self.initial),
            deadlocks: renumbered(&self.deadlocks),
            labels: self.labels.iter().map(|label| kept.label(label)).collect(),
            rewards: self.rewards.iter().map(|of| kept.rewards(of)).collect(),
            represented: None,
            roundings: self.roundings,
        }
    }

    /// The `dtmc` of a `ctmc`'s jumps, without its rewards (which depend on time).
    #[must_use]
    pub fn embedded(&self) -> Self {
        Self {
            kind: ModelType::Dtmc,
            matrix: crate::evaluate::embedded(&self.matrix),
            rewards: Vec::new(),
            // The sum of a row and the division.
            represented: None,
            roundings: (self.roundings).map(|known| known.saturating_add(self.longest_row() + 1)),
            ..self.clone()
        }
    }

    fn longest_row(&self) -> u32 {
        let lengths = self
            .matrix
            .row_start
            .windows(2)
            .map(|pair| pair[1] - pair[0]);
        u32::try_from(lengths.max().unwrap_or(0)).unwrap_or(u32::MAX)
    }

    /// The row that a scheduler takes in a state.
    pub(crate) fn row_of(&self, scheduler: &[Option<usize>], state: usize) -> usize {
        match scheduler.get(state) {
            Some(Some(row)) => {
                assert!(
                    self.choices(state).contains(row),
                    "a choice of another state"
                );
                *row
            }
            _ => self.choices(state).start,
        }
    }

    /// The states that are reached under a scheduler: those of the chain that it induces, in its order.
    pub(crate) fn reached_by(&self, scheduler: &[Option<usize>]) -> Vec<usize> {
        self.reached(|state| self.row_of(scheduler, state))
    }

    /// The states that are reached, the initial ones first.
    fn reached(&self, row: impl Fn(usize) -> usize) -> Vec<usize> {
        let mut seen = vec![false; self.num_states()];
        let mut order = Vec::new();
        let mut enter = |state: usize, order: &mut Vec<usize>| {
            if !std::mem::replace(&mut seen[state], true) {
                order.push(state);
            }
        };
        self.initial
            .iter()
            .for_each(|state| enter(*state, &mut order));
        let mut next = 0;
        while next < order.len() {
            for (target, _) in self.matrix.row(row(order[next])) {
                enter(target, &mut order);
            }
            next += 1;
        }
        order
    }

    /// The places of a row's entries, by the new numbers of their targets.
    fn sorted(&self, row: usize, number: &[u32]) -> Vec<usize> {
        let range = self.matrix.row_start[row]..self.matrix.row_start[row + 1];
        let mut places: Vec<usize> = range.collect();
        places.sort_by_key(|at| number[self.matrix.column[*at] as usize]);
        places
    }
}

/// What is left of the model: states, their rows, the places of these rows' entries.
struct Kept<'a> {
    order: &'a [usize],
    chosen: &'a [usize],
    entries: &'a [Vec<usize>],
}

impl Kept<'_> {
    fn label(&self, (name, states): &(String, LabelStates)) -> (String, LabelStates) {
        let states = match states {
            LabelStates::Defined(expr) => LabelStates::Defined(expr.clone()),
            LabelStates::Listed(flags) => {
                LabelStates::Listed(self.order.iter().map(|state| flags[*state]).collect())
            }
        };
        (name.clone(), states)
    }

    fn rewards<N: Clone>(&self, (name, rewards): &RewardsOf<N>) -> RewardsOf<N> {
        let kept = |rewards: &Rewards<N>| {
            let transition = match &rewards.transition {
                TransitionRewards::None => TransitionRewards::None,
                TransitionRewards::Row(values) => TransitionRewards::Row(
                    self.chosen.iter().map(|row| values[*row].clone()).collect(),
                ),
                TransitionRewards::Entry(values) => TransitionRewards::Entry(
                    self.entries
                        .iter()
                        .flatten()
                        .map(|at| values[*at].clone())
                        .collect(),
                ),
            };
            Rewards {
                state: self
                    .order
                    .iter()
                    .map(|state| rewards.state[*state].clone())
                    .collect(),
                transition,
                ..rewards.clone()
            }
        };
        let rewards = rewards.as_ref().map(kept).map_err(ExploreError::clone);
        (name.clone(), rewards)
    }
}
