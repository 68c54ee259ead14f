//! Exploration: episodes that are meant to show what nobody has thought of.
//!
//! Tests come from the formal model, from chance within rules, from agents
//! and from mutation; parameters are drawn, pushed to their limits or searched;
//! each episode is judged by the study's monitors and held against the formal
//! model; what is new feeds back into what is tried next. What is found is a
//! witness. How often it is found says nothing of how often it happens in use:
//! the episodes are chosen, not drawn.

mod abstraction;
mod again;
mod bench;
mod campaign;
mod code;
mod concretise;
mod disagreement;
mod distinction;
mod episode;
mod faults;
mod form;
mod formal;
mod journal;
mod moments;
mod plan;
mod searches;
mod seen;
mod shows;
mod situations;
mod sources;
mod tests_of_model;
mod text;
mod triggers;

pub use abstraction::{AbstractTrace, Abstraction, Class};
pub use again::{assets_of, findings_again, inputs_of_all, shown_again};
pub use bench::{OpenBench, command_of, failed};
pub use campaign::{Explored, Exploring};
pub use disagreement::{MapSearch, as_text as disagreement_text, map_again};
pub use episode::Watching;
pub use form::{ExplorationReport, FindingReport};
pub use formal::{Formal, Meaning};
pub use journal::Journal;
pub use moments::Signals;
pub use plan::{Plan, SourceKind};
pub use seen::Met;
pub use shows::{Said, ShowsJudge};
pub use situations::Situations;
pub use tests_of_model::{ModelTests, path_step, tests_of_model};
pub use text::as_text;
