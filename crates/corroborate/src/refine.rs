//! Refinement: from what a study's evidence disagrees on to patches of its
//! assets.
//!
//! A proposal changes one asset: a formal model, a requirement's monitor, a
//! simulation's parameters. It is shown with what it is predicted to change,
//! which is found by solving the changed model, not by guessing. What is
//! accepted is written beside the old asset and joins the ledger as a new
//! entry, which names the counts that it was set to: agreement on them is a
//! fit from then on. So it is where a text was changed because then the
//! evidence agrees, which its entry says under `chosen`.

pub mod apply;
pub mod command;
mod exchange;
mod forms;
pub mod ledger_text;
mod lineage;
mod one_value;
pub mod proposal;
pub mod report;
mod request;
mod rivals;
pub mod simulator;
pub mod solver;
pub mod suspects;
mod texts;
pub(crate) mod trees;

pub use request::{Accept, RefineRequest, Refined, refine};

#[cfg(test)]
mod tests;
