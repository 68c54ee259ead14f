//! What if: variants of the assets, each tried in every technique that can
//! express it, side by side.
//!
//! A variant names, for pieces of evidence of the ledger, what would be
//! different in their assets: constants of a formal model as expressions over
//! their values, keys of a simulation's scenario and parameters. The gain of a
//! variant is a difference on the same draws: the same posterior points of a
//! model's counted constants, the same seeds of a simulation.

pub mod file;
pub mod formal;
pub mod report;
mod request;
pub mod simulated;

pub use request::{WhatIfRequest, what_if};
