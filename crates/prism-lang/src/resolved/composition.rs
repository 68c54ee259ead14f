//! How modules are composed: the meaning of `system ... endsystem`.
//!
//! Definition: a composition has an alphabet of actions. That of a module are the actions of its commands.
//!
//! * `Full`: an action of several operands' alphabets happens in all of these together, every other action in
//!   one operand alone. (Full parallel composition of all modules is what a model without `system` means.)
//! * `Interleaved`: every action happens in one operand alone, also one that several have.
//! * `On`: the actions of the list happen in both operands together or not at all, all others in one alone.
//! * `Hide`: the actions of the list become unnamed: they still happen, but nothing synchronises with them.
//! * `Rename`: actions get new names, all at the same time.
//!
//! Commands without an action always happen alone. Source: PRISM's manual, section "Process algebra operators";
//! C.A.R. Hoare, Communicating Sequential Processes, 1985, for the operators.

use std::collections::BTreeSet;

use super::{ActionId, Module};

/// A composition of modules. Each module of the model occurs in it once.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Composition {
    /// The module of this index in [`Model::modules`](super::Model::modules).
    Module(usize),
    /// Synchronised on every action that operands share.
    Full(Vec<Composition>),
    /// Not synchronised.
    Interleaved(Vec<Composition>),
    /// Synchronised on these actions.
    On(Box<Composition>, Vec<ActionId>, Box<Composition>),
    /// These actions become unnamed.
    Hide(Box<Composition>, Vec<ActionId>),
    /// The first action of each pair becomes the second.
    Rename(Box<Composition>, Vec<(ActionId, ActionId)>),
}

impl Composition {
    /// The actions that it can take part in, under the names that they have outside.
    pub fn alphabet(&self, modules: &[Module]) -> BTreeSet<ActionId> {
        match self {
            Self::Module(index) => modules.get(*index).map_or_else(BTreeSet::new, |module| {
                module.commands.iter().filter_map(|c| c.action).collect()
            }),
            Self::Full(operands) | Self::Interleaved(operands) => {
                operands.iter().flat_map(|o| o.alphabet(modules)).collect()
            }
            Self::On(left, _, right) => &left.alphabet(modules) | &right.alphabet(modules),
            Self::Hide(operand, hidden) => {
                let inside = operand.alphabet(modules);
                inside.into_iter().filter(|a| !hidden.contains(a)).collect()
            }
            Self::Rename(operand, renames) => {
                let new = |a| {
                    renames
                        .iter()
                        .find(|(old, _)| *old == a)
                        .map_or(a, |(_, new)| *new)
                };
                operand.alphabet(modules).into_iter().map(new).collect()
            }
        }
    }

    /// The modules, in the order of their occurrence.
    pub fn modules(&self) -> Vec<usize> {
        match self {
            Self::Module(index) => vec![*index],
            Self::Full(operands) | Self::Interleaved(operands) => {
                operands.iter().flat_map(Self::modules).collect()
            }
            Self::On(left, _, right) => [left.modules(), right.modules()].concat(),
            Self::Hide(operand, _) | Self::Rename(operand, _) => operand.modules(),
        }
    }

    /// Whether it only joins modules by full parallel composition.
    pub fn is_standard(&self) -> bool {
        match self {
            Self::Module(_) => true,
            // Nested full composition of modules synchronises as the flat one does.
            Self::Full(operands) => operands.iter().all(Self::is_standard),
            _ => false,
        }
    }
}
