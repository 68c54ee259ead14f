//! What can happen in a state of composed modules, by the rules of process algebra.
//!
//! *Definition.* A module can take each of its enabled commands, under the command's action or without one. Two processes
//! composed over a set of actions take an action of the set together, each way of the one with each way of the other, and all
//! others alone; hiding takes an action's name away, renaming gives it another one. Without `system` every two modules are
//! composed over the actions that both have. Source: Hoare 1985; PRISM's manual, section "Process algebra operators".
//! Cost: commands for each state. Guarantee: exact. The rules are applied state by state to what is enabled; nothing is
//! worked out for the model as a whole but the sets of actions.

use std::collections::BTreeSet;

use prism_lang::resolved::{ActionId, Command, Composition, Model};

use crate::failure::Failure;

/// What happens at once: the commands taken, with the action if there is one.
#[derive(Clone)]
pub(crate) struct Event<'m> {
    pub action: Option<ActionId>,
    pub commands: Vec<&'m Command>,
}

/// Modules, composed.
pub(crate) enum Process<'m> {
    Module(&'m [Command]),
    /// Together over these actions, else apart.
    Both(Box<Process<'m>>, BTreeSet<ActionId>, Box<Process<'m>>),
    /// The action of each pair becomes what is beside it; nothing is no name.
    Named(Box<Process<'m>>, Vec<(ActionId, Option<ActionId>)>),
    /// Without modules.
    Nothing,
}

impl<'m> Process<'m> {
    /// That of a model.
    pub fn new(model: &'m Model) -> Self {
        match &model.composition {
            Some(composition) => Self::of(composition, model),
            None => Self::shared((0..model.modules.len()).map(Composition::Module), model),
        }
    }

    fn of(composition: &Composition, model: &'m Model) -> Self {
        match composition {
            Composition::Module(index) => match model.modules.get(*index) {
                Some(module) => Self::Module(&module.commands),
                None => Self::Nothing,
            },
            Composition::Full(operands) => Self::shared(operands.iter().cloned(), model),
            Composition::Interleaved(operands) => (operands.iter())
                .map(|operand| Self::of(operand, model))
                .reduce(|a, b| Self::Both(Box::new(a), BTreeSet::new(), Box::new(b)))
                .unwrap_or(Self::Nothing),
            Composition::On(left, actions, right) => Self::Both(
                Box::new(Self::of(left, model)),
                actions.iter().copied().collect(),
                Box::new(Self::of(right, model)),
            ),
            Composition::Hide(operand, hidden) => {
                let names = hidden.iter().map(|action| (*action, None));
                Self::Named(Box::new(Self::of(operand, model)), names.collect())
            }
            Composition::Rename(operand, renames) => {
                let names = renames.iter().map(|(old, new)| (*old, Some(*new)));
                Self::Named(Box::new(Self::of(operand, model)), names.collect())
            }
        }
    }

    /// Together over the actions that those before share with the next.
    fn shared(operands: impl Iterator<Item = Composition>, model: &'m Model) -> Self {
        let mut known = BTreeSet::new();
        let mut all: Option<Self> = None;
        for operand in operands {
            let own = operand.alphabet(&model.modules);
            let next = Self::of(&operand, model);
            all = Some(match all {
                None => next,
                Some(all) => Self::Both(Box::new(all), &known & &own, Box::new(next)),
            });
            known.extend(own);
        }
        all.unwrap_or(Self::Nothing)
    }

    /// What can happen in a state.
    pub fn events(&self, state: &[i64]) -> Result<Vec<Event<'m>>, Failure> {
        match self {
            Self::Nothing => Ok(Vec::new()),
            Self::Module(commands) => {
                let mut events = Vec::new();
                for command in *commands {
                    if command.guard.eval_bool(state)? {
                        events.push(Event {
                            action: command.action,
                            commands: vec![command],
                        });
                    }
                }
                Ok(events)
            }
            Self::Both(left, over, right) => {
                let (left, right) = (left.events(state)?, right.events(state)?);
                let is_joint = |event: &&Event<'_>| event.action.is_some_and(|a| over.contains(&a));
                let alone = left.iter().chain(&right).filter(|event| !is_joint(event));
                let mut events: Vec<Event<'m>> = alone.cloned().collect();
                for one in left.iter().filter(is_joint) {
                    for other in right.iter().filter(|other| other.action == one.action) {
                        events.push(Event {
                            action: one.action,
                            commands: [&one.commands[..], &other.commands].concat(),
                        });
                    }
                }
                Ok(events)
            }
            Self::Named(operand, names) => {
                let mut events = operand.events(state)?;
                for event in &mut events {
                    let new = names.iter().find(|(old, _)| Some(*old) == event.action);
                    if let Some((_, new)) = new {
                        event.action = *new;
                    }
                }
                Ok(events)
            }
        }
    }
}
