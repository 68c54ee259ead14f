//! All integration tests of the crate in one program, since each program costs a link.

mod answers;
mod bad_inputs;
mod conformance;
mod explore;
mod fairness;
mod formats;
mod handover;
mod kinds;
mod large_components;
mod objectives;
mod parametric;
mod random_chains;
mod random_models;
mod schedulers;
mod support;
mod threads;
mod witness;
