//! The engine: from a study's entries to evidence, comparison, conclusion, diagnosis and refinement, as functions of values
//! and of a [`host::Host`]. Faces (a command line, a notebook, a server) translate and render, and nothing else.

mod compare;
pub mod corroboration;
pub mod kept;
mod memory;
pub mod outcome;
mod plan;
mod published;
pub mod refine;
pub mod results;
mod run;
pub mod schemas;
pub mod technique;
mod verify;
pub mod what_if;

pub use compare::{CompareReport, CompareRequest, compare};
pub use plan::{Freshness, PlannedEvidence, RunPlan, plan};
pub use run::{EvidenceReport, RunReport, RunRequest, run, run_with_page};
pub use verify::{Checked, Drawing, Fault, NamedTexts, VerifyReport, VerifyRequest, verify};

/// Which build of the engine this is: the same for the same sources of what computes results, however they were built.
pub fn build() -> host::BuildId {
    host::BuildId::new(env!("CORROBORATE_BUILD"))
}
