//! The order in which a model's events are tried, and the numbers of their commands.
//!
//! Every command of an event has a number: its bit in the words of enabled commands. A slot that takes part in
//! several events has its commands once.

use std::ops::Range;

use prism_lang::resolved::{Command, Model};

use super::events::{Slot, events};
use crate::state_space::NO_ACTION;

/// Commands of an event's slot, as bits of some words.
pub(super) type SlotBits = Vec<(usize, u64)>;

/// Something that can happen.
#[derive(Clone, Debug)]
pub(super) enum Group {
    /// Each enabled command of these bits happens alone, with its action.
    Alone(SlotBits),
    /// One command of each slot, with this action.
    Together(u32, Vec<SlotBits>),
}

/// Commands, numbered, and groups of them.
#[derive(Debug, Default)]
pub(super) struct Plan<'m> {
    pub(super) commands: Vec<&'m Command>,
    /// The action of each command that happens alone.
    pub(super) actions: Vec<u32>,
    pub(super) groups: Vec<Group>,
    /// The first command of each slot placed for synchronisation, and the slot's numbers.
    placed: Vec<(*const Command, Range<usize>)>,
}

impl<'m> Plan<'m> {
    pub(super) fn new(model: &'m Model) -> Self {
        let mut plan = Self::default();
        for event in events(model) {
            let action = event.action.map_or(NO_ACTION, |a| a as u32);
            let mut slots = event.slots;
            if let [_] = slots[..] {
                let bits = bits(plan.place(slots.remove(0), action));
                match plan.groups.last_mut() {
                    Some(Group::Alone(before)) => join(before, &bits),
                    _ => plan.groups.push(Group::Alone(bits)),
                }
            } else {
                let slots = slots.into_iter().map(|slot| bits(plan.shared(slot)));
                let slots = slots.collect();
                plan.groups.push(Group::Together(action, slots));
            }
        }
        plan
    }

    fn place(&mut self, slot: Slot<'m>, action: u32) -> Range<usize> {
        let start = self.commands.len();
        self.commands.extend(slot);
        self.actions.resize(self.commands.len(), action);
        start..self.commands.len()
    }

    fn shared(&mut self, slot: Slot<'m>) -> Range<usize> {
        let first = slot
            .first()
            .map_or(std::ptr::null(), |c| std::ptr::from_ref(*c));
        if let Some((_, range)) = self.placed.iter().find(|(p, _)| *p == first) {
            return range.clone();
        }
        let range = self.place(slot, NO_ACTION);
        self.placed.push((first, range.clone()));
        range
    }
}

/// A range of commands as bits of words.
fn bits(range: std::ops::Range<usize>) -> SlotBits {
    let mut bits: SlotBits = Vec::new();
    for command in range {
        join(&mut bits, &[(command / 64, 1 << (command % 64))]);
    }
    bits
}

/// Adds bits of commands that come later.
fn join(bits: &mut SlotBits, more: &[(usize, u64)]) {
    for (word, mask) in more {
        match bits.last_mut() {
            Some((last, bits)) if last == word => *bits |= mask,
            _ => bits.push((*word, *mask)),
        }
    }
}
