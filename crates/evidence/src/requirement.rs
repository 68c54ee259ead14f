//! Requirements and failure modes: the subjects of evidence.

use crate::{CarryOver, Step};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Which side of a threshold is required.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Direction {
    /// The probability shall be at least the threshold.
    AtLeast,
    /// The probability shall be at most the threshold.
    AtMost,
}

/// A probability that decides a requirement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Threshold {
    /// Which side is required.
    pub direction: Direction,
    /// The probability, 0 to 1.
    pub value: f64,
}

/// A requirement as the study states it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Requirement {
    /// Identifier, for example `1a`.
    pub id: String,
    /// The text, verbatim.
    pub text: String,
    /// The probability it asks for; `None` if it asks for certainty, which
    /// counts as "at least 1".
    pub threshold: Option<Threshold>,
    /// The requirement in structured English, verbatim, if it is written so;
    /// the forms that are not written by hand are made from it.
    #[serde(default)]
    pub sentence: Option<String>,
    /// The logical property, in the PRISM property language.
    pub property: Option<String>,
    /// The assertion monitor, in words.
    pub monitor: Option<String>,
    /// What triggers it, in the words of the study: the proposition that has to become true, or the formula that a run has
    /// to satisfy; `None` if every run does, or counts as one that does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trigger: Option<String>,
    /// How long a run has to be for all that it asks for to be seen (`10 s`): a shorter one may reach no verdict. `None` where
    /// every run is long enough.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asks_for: Option<String>,
    /// Largest difference of two rates that counts as agreement.
    pub margin: f64,
    /// Requirements with the same quantity (such as 1a and 1b, which differ
    /// only in their threshold) name the first of them here.
    pub same_quantity_as: Option<String>,
    /// The lowest step on which "satisfied" is enough.
    #[serde(default)]
    pub needs: Step,
    /// Models whose agreement with the system carries over to it, as the study declares.
    #[serde(default)]
    pub carries_over: Vec<CarryOver>,
}

/// A way in which a run can fail, counted against its opportunities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FailureMode {
    /// Identifier, for example `grip_failure`.
    pub id: String,
    /// A short name for people.
    pub name: String,
    /// What it means and what counts as an opportunity.
    pub meaning: String,
    /// Largest difference of two rates that counts as agreement.
    pub margin: f64,
}
