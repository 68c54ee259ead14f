#![doc = include_str!("../README.md")]
//!
//! A fault tree says which combinations of basic events lead to a top event (W. E. Vesely et al., *Fault Tree Handbook*,
//! NUREG-0492, 1981; E. Ruijters, M. Stoelinga, *Fault tree analysis: a survey*, Computer Science Review 15-16, 2015). Here it
//! is static (the order of events does not matter), and basic events are independent.
//!
//! | question | answered by |
//! |---|---|
//! | What does a text in Galileo's or the Open-PSA format say, and what is wrong with it? | [`read_galileo`], [`read_open_psa`] |
//! | How probable is an event? | [`Analysis::probability`]: exact, or enclosed by rounding, by ranges or with a confidence ([`Guarantee`]) |
//! | Which smallest combinations lead to it? | [`Analysis::cut_sets`] |
//! | Which basic event matters how much? | [`Analysis::importance`] |
//! | Can one event prevent another? | [`Analysis::is_monotone`] |
//! | Which trees does one change of a gate make of a text? | [`rewrites()`] |
//!
//! A basic event has a probability, a rate with a mission time, an interval, or counts ([`EventData`]); the last two come by
//! a table of the caller ([`FaultTree::with_data`]) or by attributes of the Open-PSA format.
//!
//! The engine opens no file, prints nothing and reads no clock. Decision diagrams have a limit of nodes
//! ([`Options::nodes`]): beyond it there is an error and no number. Whatever may take long ends when a
//! [`Cancel`](diagnostic::Cancel) asks for it. No walk recurses, so depth costs no stack. The same text gives the same
//! answers, bit for bit.

mod analysis;
mod bdd;
mod compile;
mod cut_sets;
mod data;
mod decimal;
mod draft;
mod enclosure;
mod families;
mod function;
mod galileo;
mod importance;
mod mistakes;
mod open_psa;
mod order;
mod probability;
mod reading;
mod results;
mod rewrites;
mod tree;

pub use analysis::{Analysis, Options};
pub use cut_sets::{CutSetKind, CutSets};
pub use data::EventData;
pub use decimal::decimal;
pub use enclosure::Enclosure;
pub use galileo::read_galileo;
pub use importance::Importance;
pub use num_rational::BigRational;
pub use open_psa::read_open_psa;
pub use order::Order;
pub use probability::{Guarantee, Probability};
pub use reading::{Reading, Settings};
pub use rewrites::{Format, Rewrite, RewriteKind, rewrites};
pub use tree::{Connective, FaultTree, Node, NodeId, NodeKind};
