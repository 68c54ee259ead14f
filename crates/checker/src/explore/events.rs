//! What can happen in a composition of modules: events, each with the modules that take part.
//!
//! Definition: an event has an action (or none) and slots; a slot has commands of one module. The event is
//! enabled if every slot has an enabled command; each way to pick one from every slot is a choice. A
//! composition gives a list of events:
//!
//! * a module: for each of its actions an event with the commands of that action as one slot, and one for its
//!   commands without action;
//! * `A || B`: for an action of both alphabets, every pair of an event of `A` and one of `B` with that action is
//!   one event with the slots of both; other events stay. `A ||| B`: all stay. `A |[a]| B`: pairs for the listed;
//! * `A / {a}`: events of the listed actions have no action; `A {a <- b}`: they have the new one. Two
//!   events with the same action are alternatives, just as two commands of a slot are.
//!
//! Source: PRISM manual, section "Process algebra operators". Cost: the product of the numbers of events of an
//! action in the operands, which is 1 without interleaving of modules that share actions.

use prism_lang::resolved::{ActionId, Command, Composition, Model};
use std::collections::{BTreeMap, BTreeSet};

/// Commands that can take part in an event for one module.
pub(super) type Slot<'m> = Vec<&'m Command>;

/// Something that can happen, under the name that it has outside.
#[derive(Clone, Debug)]
pub(super) struct Event<'m> {
    pub(super) action: Option<ActionId>,
    pub(super) slots: Vec<Slot<'m>>,
}

/// The events of a model: those without action first, then action by action.
pub(super) fn events(model: &Model) -> Vec<Event<'_>> {
    let mut events = match &model.composition {
        Some(composition) => of_composition(composition, model),
        None => full((0..model.modules.len()).map(|m| operand(&Composition::Module(m), model))),
    };
    events.sort_by_key(|e| e.action.map_or(0, |a| a + 1));
    events
}

fn of_module(index: usize, model: &Model) -> Vec<Event<'_>> {
    let mut by_action: BTreeMap<Option<ActionId>, Slot<'_>> = BTreeMap::new();
    for command in model.modules.get(index).iter().flat_map(|m| &m.commands) {
        by_action.entry(command.action).or_default().push(command);
    }
    let event = |(action, slot)| Event {
        action,
        slots: vec![slot],
    };
    by_action.into_iter().map(event).collect()
}

fn operand<'m>(composition: &Composition, model: &'m Model) -> Operand<'m> {
    let alphabet = composition.alphabet(&model.modules);
    (of_composition(composition, model), alphabet)
}

fn of_composition<'m>(composition: &Composition, model: &'m Model) -> Vec<Event<'m>> {
    match composition {
        Composition::Module(index) => of_module(*index, model),
        Composition::Full(operands) => full(operands.iter().map(|o| operand(o, model))),
        Composition::Interleaved(operands) => operands
            .iter()
            .flat_map(|o| of_composition(o, model))
            .collect(),
        Composition::On(left, actions, right) => {
            let (left, right) = (of_composition(left, model), of_composition(right, model));
            together(left, right, |a| actions.contains(&a))
        }
        Composition::Hide(operand, hidden) => {
            let mut events = of_composition(operand, model);
            for event in &mut events {
                event.action = event.action.filter(|a| !hidden.contains(a));
            }
            events
        }
        Composition::Rename(operand, renames) => {
            let mut events = of_composition(operand, model);
            for event in &mut events {
                let new = renames.iter().find(|(old, _)| Some(*old) == event.action);
                event.action = new.map_or(event.action, |(_, new)| Some(*new));
            }
            events
        }
    }
}

/// Events and the actions that they may have; an action can be known although nothing makes it happen.
type Operand<'m> = (Vec<Event<'m>>, BTreeSet<ActionId>);

/// Synchronised on every action that operands share.
fn full<'m>(operands: impl Iterator<Item = Operand<'m>>) -> Vec<Event<'m>> {
    let joined = operands.reduce(|(left, left_knows), (right, right_knows)| {
        let shared = &left_knows & &right_knows;
        let events = together(left, right, |a| shared.contains(&a));
        (events, &left_knows | &right_knows)
    });
    joined.map_or_else(Vec::new, |(events, _)| events)
}

/// Events of an action for which `synchronised` holds happen in pairs, the others alone.
fn together<'m>(
    left: Vec<Event<'m>>,
    right: Vec<Event<'m>>,
    synchronised: impl Fn(ActionId) -> bool,
) -> Vec<Event<'m>> {
    let is_joint = |event: &Event<'_>| event.action.is_some_and(&synchronised);
    let (joint_left, mut events): (Vec<_>, Vec<_>) = left.into_iter().partition(is_joint);
    let (joint_right, alone): (Vec<_>, Vec<_>) = right.into_iter().partition(is_joint);
    events.extend(alone);
    for a in &joint_left {
        for b in joint_right.iter().filter(|b| b.action == a.action) {
            events.push(Event {
                action: a.action,
                slots: [&a.slots[..], &b.slots[..]].concat(),
            });
        }
    }
    events
}
