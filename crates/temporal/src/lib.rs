//! Temporal logic: LTL to automata, and monitors that judge signals.

pub mod monitor;
