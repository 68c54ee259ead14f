#![doc = include_str!("../README.md")]
//!
//! The HTML needs no network and no script: plots are inline SVG, the style is
//! inline, and a policy in its head forbids everything else. All text of the
//! study is escaped.

mod answers;
pub mod assurance;
pub mod junit;
mod markdown;
mod number;
mod page;
mod plan;
mod plot;
pub mod replay;
pub mod sarif;
mod section;
mod text;
mod traceability;
mod view;
mod words;

pub use answers::{Answer, Part};
pub use markdown::markdown;
pub use traceability::traceability;

use evidence::StudyResult;

/// The five questions that people ask of a study, with their answers: what the page begins with.
#[must_use]
pub fn answers(study: &StudyResult) -> [Answer; 5] {
    answers::answers(view::View { study })
}

/// The study as one HTML file that opens offline.
pub fn html(study: &StudyResult) -> String {
    page::render(study)
}

/// The study's summary for a terminal of `width` columns (at least 40 are
/// used): the verdict, the matrix, the main conflicts. `colour` adds ANSI
/// escapes; without it the text is plain.
pub fn text(study: &StudyResult, width: usize, colour: bool) -> String {
    text::render(study, width, colour)
}

/// The study as indented JSON, fields in the order of their declaration, so
/// that equal results are equal bytes.
///
/// # Errors
/// None is known for a [`StudyResult`]; the serialiser's own are passed on.
pub fn json(study: &StudyResult) -> Result<String, serde_json::Error> {
    serde_json::to_string_pretty(study).map(|text| text + "\n")
}
