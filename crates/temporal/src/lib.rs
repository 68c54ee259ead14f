#![doc = include_str!("../README.md")]
//!
//! * [`ltl`]: formulas of linear temporal logic over infinite words, and what they mean;
//! * [`automaton`]: deterministic automata that accept the words on which a formula holds;
//! * [`formula`]: metric and signal temporal logic over traces;
//! * [`monitor`]: staged assertions that judge one finite trace while time passes.

pub mod automaton;
mod clock;
pub mod formula;
pub mod ltl;
pub mod monitor;
