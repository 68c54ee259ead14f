//! The assurance case of a study: why its conclusions should be believed, and
//! why not.
//!
//! # Definition
//! Two arguments in the Goal Structuring Notation (GSN Community Standard,
//! version 3, 2021), both read off a [`StudyResult`] without computing
//! anything:
//!
//! * the *safety argument* claims each requirement and supports it by the
//!   evidence on which its conclusion rests, cited by identifier and by the
//!   hash of all its inputs;
//! * the *confidence argument* (Hawkins, Kelly, Knight, Graydon, "A new
//!   approach to creating clear safety arguments", 2011) stands beside it. It
//!   claims, for each assurance claim point `ACP-…` of the safety argument,
//!   that the evidence there can be relied on: it was shown to agree
//!   independently, it covers what it speaks of, its numbers have known errors.
//!
//! What is not so is said in the notation's own terms. Evidence against a goal
//! and conflicts between evidence are *counter goals* that challenge it (the
//! standard's dialectic extension); a violated requirement's goal is *defeated*,
//! and so is a counter goal whose cause was fixed by later evidence. What is
//! missing (never covered, not expressible, not comparable, inconclusive,
//! agreement that is only a fit) is an *undeveloped goal*.
//!
//! # Guarantee
//! Every goal or strategy without support is marked undeveloped, every
//! identifier is unique, every reference exists, and the support of a goal is a
//! tree. Cost: linear in the study's comparisons times its requirements.
//!
//! Both are written for other tools: in the YAML of gsn2x ([`yaml()`]) and, together, in SACM ([`sacm()`]).
//!
//! Where every piece came from is exported by [`provenance()`] in the terms of
//! W3C PROV.

mod confidence;
pub(crate) mod drawing;
mod gsn2x;
mod node;
mod provenance;
mod sacm;
mod safety;
pub(crate) mod words;

pub use gsn2x::yaml;
pub use node::{Argument, Citation, ClaimPoint, Kind, Node};
pub use provenance::provenance;
pub use sacm::sacm;

use crate::view::View;
use evidence::StudyResult;

/// The safety argument and, beside it, the argument for its confidence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AssuranceCase {
    /// Claims every requirement.
    pub safety: Argument,
    /// Claims that the evidence can be relied on at each claim point.
    pub confidence: Argument,
}

/// Reads the assurance case off a study.
///
/// ```
/// # let study = evidence::StudyResult {
/// #     format: "1.0".into(), title: "A robot hands over".into(), summary: String::new(),
/// #     confidence: 0.95, requirements: vec![], failure_modes: vec![], evidence: vec![],
/// #     comparisons: vec![], conclusions: vec![], synthesis: Default::default(), suspects: vec![],
/// #     diagnosis: None,
/// #     disagreement: None, exploration: None, calibration: None, gaps: vec![],
/// #     published: vec![], costs: vec![], produced_by: "example".into(),
/// # };
/// let case = report::assurance::case(&study);
/// let yaml = report::assurance::yaml(&case.safety);
/// assert!(yaml.contains("A robot hands over"));
/// assert!(yaml.contains("undeveloped: true"), "nothing supports an empty study");
/// ```
pub fn case(study: &StudyResult) -> AssuranceCase {
    let view = View { study };
    AssuranceCase {
        safety: safety::argument(view),
        confidence: confidence::argument(view),
    }
}

/// Where the statement about a piece of evidence is, relative to the argument.
pub fn statement_file(evidence: &str) -> String {
    format!("evidence/{evidence}.intoto.json")
}
