//! The engine: from a study's entries to evidence, comparison, conclusion, diagnosis and refinement, as functions of values
//! and of a [`host::Host`]. Faces (a command line, a notebook, a server) translate and render, and nothing else.

pub mod corroboration;
mod memory;
pub mod outcome;
mod published;
pub mod refine;
pub mod schemas;
pub mod technique;
pub mod what_if;

/// Which build of the engine this is: the same for the same sources of what computes results, however they were built.
pub fn build() -> host::BuildId {
    host::BuildId::new(env!("CORROBORATE_BUILD"))
}
