//! One requirement in several forms: do they say the same?
//!
//! A requirement has a sentence, and beside it perhaps a property, a monitor
//! and other readings that were written by hand. Two checks hold the forms
//! against each other. [`drift`] looks at the texts: limits, quantities,
//! clocks and instants that are not those of the requirement. [`differences`]
//! looks at recordings: each on which two forms do not agree.

mod counterpart;
pub mod differences;
pub mod drift;
mod left_out;
mod limits;
mod path;
mod roles;

pub use path::{judged_on_paths, judged_on_traces};
