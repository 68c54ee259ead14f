//! Evidence as pages and text: a [`StudyResult`] as one self-contained HTML
//! file, as a summary for the terminal, and as JSON.
//!
//! The report computes nothing. Every number in it is a field of the study's
//! result; this crate chooses digits, words and places. What a page shows can
//! therefore be checked against the JSON alone.
//!
//! The HTML needs no network and no script: plots are inline SVG, the style is
//! inline, and a policy in its head forbids everything else. All text of the
//! study is escaped.
//!
//! ```
//! # let study = evidence::StudyResult {
//! #     format: "1.0".into(), title: "A robot hands over".into(), summary: String::new(),
//! #     confidence: 0.95, requirements: vec![], failure_modes: vec![], evidence: vec![],
//! #     comparisons: vec![], conclusions: vec![], synthesis: Default::default(), suspects: vec![],
//! #     diagnosis: None,
//! #     disagreement: None, exploration: None, calibration: None, gaps: vec![],
//! #     published: vec![], costs: vec![], produced_by: "example".into(),
//! # };
//! let page: String = report::html(&study);
//! assert!(page.starts_with("<!DOCTYPE html>"));
//! let summary: String = report::text(&study, 80, false);
//! assert!(summary.contains("A robot hands over"));
//! let data: String = report::json(&study)?;
//! # Ok::<(), serde_json::Error>(())
//! ```

pub mod assurance;
mod number;
mod page;
mod plan;
mod plot;
pub mod replay;
mod section;
mod text;
mod view;
mod words;

use evidence::StudyResult;

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
