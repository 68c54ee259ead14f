//! The chain that a scheduler with memory induces.
//!
//! *Definition.* Its states are the nodes of the scheduler: a state of the model and a memory, which is one more
//! variable (`_mem`), the last. From a node the step by the chosen row leads where the model does, with the next memory.
//! Labels and rewards are those of the model's states and rows. Cost: linear. Guarantee: the probabilities are those of
//! the model, bit by bit.

use prism_lang::resolved::{ModelType, Variable, VariableKind};
use prism_lang::{Arithmetic, Span};

use super::{FiniteMemory, Node, Scheduler};
use crate::explore::ExploreError;
use crate::state_space::{
    Csr, LabelStates, Layout, Rewards, RewardsOf, StateSpace, TransitionRewards,
};

/// One entry of a node's row: the node it leads to, and the place in the model's matrix.
type Entry = (u32, usize);

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
        let entries: Vec<Vec<Entry>> = self.nodes.iter().map(|n| entries(space, n)).collect();
        let mut matrix = Csr::with_capacity(self.nodes.len());
        for entries in &entries {
            let entry = |(target, at): &Entry| (*target, space.matrix.value[*at].clone());
            matrix.push_row(entries.iter().map(entry));
        }
        let variables = self.variables(space);
        let layout = Layout::new(&variables);
        let mut packed = vec![0; self.nodes.len() * layout.words()];
        for (node, packed) in (self.nodes.iter()).zip(packed.chunks_exact_mut(layout.words())) {
            let mut values = space.state(node.state);
            values.push(i64::from(node.memory));
            layout.pack(&values, packed);
        }
        let deadlocks = space.deadlocks();
        let is_deadlock = |node: &usize| deadlocks.binary_search(&self.nodes[*node].state).is_ok();
        StateSpace {
            kind: ModelType::Dtmc,
            labelled_transitions: matrix.num_entries() as u64,
            matrix,
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
                .map(|of| self.rewards(of, &entries))
                .collect(),
            represented: None,
            roundings: space.roundings,
        }
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
        entries: &[Vec<Entry>],
    ) -> RewardsOf<N> {
        let nodes = || self.nodes.iter();
        let of = |rewards: &Rewards<N>| Rewards {
            state: nodes().map(|n| rewards.state[n.state].clone()).collect(),
            transition: match &rewards.transition {
                TransitionRewards::None => TransitionRewards::None,
                TransitionRewards::Row(values) => {
                    TransitionRewards::Row(nodes().map(|n| values[n.row].clone()).collect())
                }
                TransitionRewards::Entry(values) => {
                    let places = entries.iter().flatten();
                    TransitionRewards::Entry(places.map(|(_, at)| values[*at].clone()).collect())
                }
            },
            relative_error: rewards.relative_error,
        };
        let rewards = rewards.as_ref().map(of).map_err(ExploreError::clone);
        (name.clone(), rewards)
    }
}

/// The entries of a node, by the node they lead to.
fn entries<N>(space: &StateSpace<N>, node: &Node) -> Vec<Entry> {
    let places = space.matrix.row_start[node.row]..space.matrix.row_start[node.row + 1];
    assert_eq!(places.len(), node.next.len(), "a row of another model");
    let mut entries: Vec<Entry> = node.next.iter().copied().zip(places).collect();
    entries.sort_unstable();
    entries
}
