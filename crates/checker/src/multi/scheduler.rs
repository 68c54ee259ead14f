//! The scheduler of a corner of several objectives on the model, and mixtures of such schedulers.
//!
//! *Definition.* A corner's scheduler is one of the skeleton ([`super::weighted`]): where a state of it is a component, the
//! row that it leaves by is headed for by rows of the component, taken, and again if it leads back; where it stops, what it
//! stops with is gone round for ever ([`crate::scheduler::tour`]). A mixture draws one of the schedulers in the beginning, with its
//! share, and remembers which: the first state takes the first rows of all of them in these shares, so that a drawing takes no
//! step of its own.
//!
//! Source: Etessami, Kwiatkowska, Vardi and Yannakakis 2008, section 3; Forejt, Kwiatkowska and Parker 2012. Cost: linear in
//! the states of the product that are reached, for each corner. Guarantee: exact.

use prism_lang::Rational;

use super::weighted::{Skeleton, Step};
use crate::answer::{CheckError, Options};
use crate::choices::Choices;
use crate::graph::{Backward, NO_ROW};
use crate::joint::Joint;
use crate::scheduler::tour::Stay;
use crate::scheduler::{FiniteMemory, Meaning, Move, Node, Numbered, Policy, unfold};

/// A corner's scheduler, as far as it is reached; `chosen` are its rows in the skeleton.
pub(crate) fn unfolded(
    model: Choices<'_, Rational>,
    initial: usize,
    joint: &Joint<'_, Rational>,
    skeleton: &Skeleton,
    chosen: &[usize],
    options: &Options<'_>,
) -> Result<FiniteMemory, CheckError> {
    let mut policy = OfCorner::new(model, joint, skeleton, chosen);
    unfold(model, &[initial], &mut policy, Meaning::Automaton, options)
}

/// The memory is the state of the product, and the place of the round where the scheduler stays.
struct OfCorner<'a> {
    model: Choices<'a, Rational>,
    joint: &'a Joint<'a, Rational>,
    /// The row of the product in each state; none where it does not matter, or where the scheduler stays.
    rows: Vec<usize>,
    stays: Vec<bool>,
    stay: Stay,
    numbers: Numbered<(u32, u32)>,
}

impl<'a> OfCorner<'a> {
    fn new(
        model: Choices<'a, Rational>,
        joint: &'a Joint<'a, Rational>,
        skeleton: &Skeleton,
        chosen: &[usize],
    ) -> Self {
        let states = joint.num_states();
        let step = |state: usize| match chosen[skeleton.class[state] as usize] {
            NO_ROW => None,
            row => Some(&skeleton.steps[row]),
        };
        let (mut goal, mut stays) = (vec![false; states], vec![false; states]);
        let mut stopping = Vec::new();
        for (state, stays) in stays.iter_mut().enumerate() {
            match step(state) {
                Some(Step::Row(row)) => goal[joint.owner(*row)] = true,
                Some(Step::Stay(component, recurring)) => {
                    *stays = true;
                    let component = &skeleton.components[*component];
                    if component.states.first() == Some(&(state as u32)) {
                        stopping.push((component.clone(), recurring.clone()));
                    }
                }
                None => {}
            }
        }
        let (mut inside, mut within) = (vec![false; states], vec![false; joint.matrix.num_rows()]);
        for component in &skeleton.components {
            let states = component.states.iter();
            states.for_each(|state| inside[*state as usize] = true);
            component.rows.iter().for_each(|row| within[*row] = true);
        }
        let backward = Backward::new(joint.choices());
        let (_, towards) = backward.reaching(&goal, |s| inside[s], |row| within[row]);
        let row = |state: usize| match step(state) {
            Some(Step::Row(row)) if joint.owner(*row) == state => *row,
            Some(Step::Row(_)) => towards[state],
            _ => NO_ROW,
        };
        Self {
            model,
            joint,
            rows: (0..states).map(row).collect(),
            stays,
            stay: Stay::new(joint.choices(), &stopping),
            numbers: Numbered::new(),
        }
    }

    /// The product's row.
    fn taken(&self, (state, place): (u32, u32)) -> usize {
        let state = state as usize;
        match self.stays[state] {
            true => self.stay.row(state, place),
            false => self.rows[state],
        }
    }
}

impl Policy for OfCorner<'_> {
    type Key = (u32, u32);

    fn first(&mut self, _: usize, _: usize) -> Self::Key {
        (0, 0)
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
        let to = *to.expect("the product has all targets of the model");
        let place = match self.stays[from] {
            true => self.stay.next(from, key.1, row),
            false => 0,
        };
        (to, place)
    }

    fn number(&mut self, (state, place): Self::Key) -> u32 {
        (self.numbers).of((self.joint.memory(state as usize), place))
    }
}

/// A mixture of schedulers from one state, with shares that sum to 1; one alone is itself.
pub(crate) fn mixed(mut parts: Vec<(Rational, FiniteMemory)>) -> FiniteMemory {
    if parts.len() == 1 {
        return parts.swap_remove(0).1;
    }
    let state = parts.first().map_or(0, |(_, part)| part.nodes[0].state);
    let mut nodes = vec![Node {
        state,
        memory: 0,
        matters: true,
        moves: Vec::new(),
    }];
    let mut memory = 1;
    for (share, part) in parts {
        let (first, base) = (nodes.len() as u32, memory);
        for node in part.nodes {
            let moves = node.moves.into_iter().map(|taken| Move {
                next: taken.next.iter().map(|next| next + first).collect(),
                ..taken
            });
            memory = memory.max(base + node.memory + 1);
            nodes.push(Node {
                memory: base + node.memory,
                moves: moves.collect(),
                ..node
            });
        }
        let start = nodes[first as usize].moves[0].clone();
        nodes[0].moves.push(Move { share, ..start });
    }
    FiniteMemory {
        nodes,
        meaning: Meaning::Mixture,
    }
}
