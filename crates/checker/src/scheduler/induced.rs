//! The chain that a scheduler with memory induces.
//!
//! *Definition.* Its states are the nodes of the scheduler: a state of the model and a memory, which is one more
//! variable (`_mem`), the last. From a node the step by the chosen row leads where the model does, with the next memory;
//! where a mixture is drawn, its shares weigh the rows. Labels and rewards are those of the model's states and rows; rewards of
//! rows that are merged are their mean. Cost: linear. Guarantee: the probabilities are those of the model, bit
//! by bit, but where a mixture is drawn.

use prism_lang::resolved::{ModelType, Variable, VariableKind};
use prism_lang::{Arithmetic, Number, Span};

use super::{FiniteMemory, Node, Scheduler};
use crate::explore::ExploreError;
use crate::state_space::{
    Csr, LabelStates, Layout, Rewards, RewardsOf, StateSpace, TransitionRewards,
};

/// One entry of a node's row: the node it leads to, the place in the model's matrix, the share of its row.
type Entry<N> = (u32, usize, Option<N>);

impl Scheduler {
    /// The chain that the scheduler induces on the state space for which it was found.
    ///
    /// # Panics
    /// If it is a scheduler of another state space.
    #[must_use]
    pub fn induced<N: Arithmetic>(&self, space: &StateSpace<N>) -> StateSpace<N> {
        match self {
            Self::ByState(rows) => space.induced(rows),
            Self::WithMemory(memory) => memory.induced(space),
        }
    }
}

impl FiniteMemory {
    fn induced<N: Arithmetic>(&self, space: &StateSpace<N>) -> StateSpace<N> {
        let entries: Vec<Vec<Entry<N>>> = (self.nodes.iter())
            .map(|node| entries(space, node))
            .collect();
        let mut matrix = Csr::with_capacity(self.nodes.len());
        for entries in &entries {
            let mut row: Vec<(u32, N)> = Vec::with_capacity(entries.len());
            for (target, at, share) in entries {
                let p = weighed(&space.matrix.value[*at], share.as_ref());
                match row.last_mut() {
                    Some((last, sum)) if last == target => *sum = sum.add(&p),
                    _ => row.push((*target, p)),
                }
            }
            matrix.push_row(row);
        }
        let is_mixed = self.nodes.iter().any(|node| node.moves.len() > 1);
        let variables = self.variables(space);
        let layout = Layout::new(&variables);
        let mut packed = vec![0; self.nodes.len() * layout.words()];
        for (node, packed) in self
            .nodes
            .iter()
            .zip(packed.chunks_exact_mut(layout.words()))
        {
            let mut values = space.state(node.state);
            values.push(i64::from(node.memory));
            layout.pack(&values, packed);
        }
        let deadlocks = space.deadlocks();
        let is_deadlock = |node: &usize| {
            let state = &self.nodes[*node].state;
            deadlocks.binary_search(state).is_ok()
        };
        StateSpace {
            kind: ModelType::Dtmc,
            labelled_transitions: matrix.num_entries() as u64,
            choice_start: Vec::new(),
            choice_action: Vec::new(),
            actions: space.actions.clone(),
            variables,
            layout,
            packed,
            initial: (0..space.initial.len()).collect(),
            deadlocks: (0..self.nodes.len()).filter(is_deadlock).collect(),
            labels: (space.labels.iter())
                .map(|(name, of)| (name.clone(), self.label(of)))
                .collect(),
            rewards: (space.rewards.iter())
                .map(|of| self.rewards(of, &entries, &matrix, space))
                .collect(),
            represented: None,
            // A share, its product and the sum round; nothing else is computed.
            roundings: match is_mixed {
                true => (space.roundings).map(|known| known.saturating_add(self.longest() + 3)),
                false => space.roundings,
            },
            matrix,
        }
    }

    fn longest(&self) -> u32 {
        let lengths = (self.nodes.iter()).map(|node| node.moves.iter().map(|m| m.next.len()).sum());
        let longest: usize = lengths.max().unwrap_or(0);
        u32::try_from(longest).unwrap_or(u32::MAX)
    }

    /// The model's variables and the memory.
    fn variables<N>(&self, space: &StateSpace<N>) -> Vec<Variable> {
        let mut name = "_mem".to_owned();
        while space.variables().iter().any(|v| v.name == name) {
            name.insert(0, '_');
        }
        let high = self.nodes.iter().map(|node| node.memory).max().unwrap_or(0);
        let mut variables = space.variables().to_vec();
        variables.push(Variable {
            name,
            module: None,
            kind: VariableKind::Int {
                low: 0,
                high: i64::from(high),
            },
            init: 0,
            span: Span::default(),
        });
        variables
    }

    fn label(&self, states: &LabelStates) -> LabelStates {
        match states {
            LabelStates::Defined(expr) => LabelStates::Defined(expr.clone()),
            LabelStates::Listed(flags) => {
                LabelStates::Listed(self.nodes.iter().map(|node| flags[node.state]).collect())
            }
        }
    }

    fn rewards<N: Arithmetic>(
        &self,
        (name, rewards): &RewardsOf<N>,
        entries: &[Vec<Entry<N>>],
        matrix: &Csr<N>,
        space: &StateSpace<N>,
    ) -> RewardsOf<N> {
        let of = |rewards: &Rewards<N>| {
            let state = self
                .nodes
                .iter()
                .map(|node| rewards.state[node.state].clone());
            let transition = match &rewards.transition {
                TransitionRewards::None => TransitionRewards::None,
                some => TransitionRewards::Entry(self.of_entries(some, entries, matrix, space)),
            };
            let mixed = self.nodes.iter().any(|node| node.moves.len() > 1);
            let error = match mixed && !N::EXACT {
                true => f64::from(3 * self.longest() + 3) * 2.0 * crate::rounding::UNIT,
                false => 0.0,
            };
            Rewards {
                state: state.collect(),
                transition,
                relative_error: rewards.relative_error + error,
            }
        };
        let rewards = rewards.as_ref().map(of).map_err(ExploreError::clone);
        (name.clone(), rewards)
    }

    fn of_entries<N: Arithmetic>(
        &self,
        rewards: &TransitionRewards<N>,
        entries: &[Vec<Entry<N>>],
        matrix: &Csr<N>,
        space: &StateSpace<N>,
    ) -> Vec<N> {
        let mut all: Vec<N> = Vec::with_capacity(matrix.num_entries());
        for (node, entries) in self.nodes.iter().zip(entries) {
            let mut last = None;
            let mut sum = N::zero();
            for (target, at, share) in entries {
                let row = (node.moves.iter()).map(|taken| taken.row).find(|row| {
                    (space.matrix.row_start[*row]..space.matrix.row_start[row + 1]).contains(at)
                });
                let reward = row.and_then(|row| rewards.of(row, *at)).cloned();
                let reward = reward.unwrap_or_else(N::zero);
                match share {
                    // One row: nothing is merged.
                    None => all.push(reward),
                    Some(share) => {
                        if last != Some(*target) {
                            all.push(N::zero());
                            sum = N::zero();
                            last = Some(*target);
                        }
                        sum = sum.add(&weighed(&space.matrix.value[*at], Some(share)).mul(&reward));
                        let p = &matrix.value[all.len() - 1];
                        if let (Some(mean), Some(place)) = (sum.div(p), all.last_mut()) {
                            *place = mean;
                        }
                    }
                }
            }
        }
        all
    }
}

/// The entries of a node, by the node they lead to.
fn entries<N: Arithmetic>(space: &StateSpace<N>, node: &Node) -> Vec<Entry<N>> {
    let mut entries = Vec::new();
    for taken in &node.moves {
        let share = (node.moves.len() > 1)
            .then(|| N::from_literal(&Number::from_rational(taken.share.clone())))
            .flatten();
        let places = space.matrix.row_start[taken.row]..space.matrix.row_start[taken.row + 1];
        assert_eq!(places.len(), taken.next.len(), "a row of another model");
        let each = places.zip(&taken.next);
        entries.extend(each.map(|(at, next)| (*next, at, share.clone())));
    }
    entries.sort_by_key(|(target, at, _)| (*target, *at));
    entries
}

fn weighed<N: Arithmetic>(p: &N, share: Option<&N>) -> N {
    match share {
        None => p.clone(),
        Some(share) => p.mul(share),
    }
}
