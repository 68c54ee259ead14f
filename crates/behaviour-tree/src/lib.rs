#![doc = include_str!("../README.md")]

mod expand;
mod files;
mod flow;
mod log;
mod mistakes;
mod names;
mod notes;
mod prism;
mod read;
mod tree;
mod types;

pub use files::Includer;
pub use log::{Attributed, Counts, Event, Executions, Group, Shared, Status};
pub use prism::{Conditions, Constant, Options, PrismModel, to_prism};
pub use read::{Reading, read};
pub use tree::{BehaviourTree, Draw, Kind, Leaf, Node, NodeId, Outcome, Precondition, Script};
