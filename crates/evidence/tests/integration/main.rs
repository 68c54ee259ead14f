//! All integration tests of the crate in one program, since each program costs a link.

#![allow(
    clippy::duplicate_mod,
    clippy::module_inception,
    reason = "examples are run as tests, each with its own copy of what they share"
)]

mod calibration;
mod clustering;
mod coherence;
mod error_rates;
mod false_conflicts;
mod figures;
mod handover;
mod intervals;
mod one_subject;
mod support;
mod suspects;
mod techniques;
mod triggers;
mod undecided;
mod verdicts;
