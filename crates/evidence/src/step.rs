//! The ladder of verdicts: of what a verdict speaks.
//!
//! # Definition
//! A requirement speaks of the system. Each verdict names the step on which it stands:
//!
//! | step | what decides it |
//! |---|---|
//! | for the model | the computed probability of a formal model |
//! | in simulation | the episodes of a simulator |
//! | corroborated | a model or simulator whose agreement with the system is shown, independently, where the study declares that this agreement carries over to the requirement |
//! | of the system | trials of the system: experiment or operation |
//!
//! See `conclude` for the rule of each step and its error rate.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! A verdict never stands on a higher step than what decides it.

use crate::{Subject, Technique, WitnessOf};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Of what a verdict speaks, the weakest first.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    /// Of a formal model.
    Model,
    /// Of a simulator.
    Simulation,
    /// Of the system, by a model whose agreement with the system is shown and declared to carry over.
    ///
    /// The default of what a requirement needs: it is the lowest step at which a verdict speaks of the system.
    #[default]
    Corroborated,
    /// Of the system, by trials of it.
    System,
}

impl Step {
    /// All steps, the weakest first.
    pub const ALL: [Step; 4] = [
        Step::Model,
        Step::Simulation,
        Step::Corroborated,
        Step::System,
    ];

    /// The step on which evidence of a technique stands by itself.
    #[must_use]
    pub fn of(technique: Technique) -> Self {
        match technique.witness_of() {
            WitnessOf::Model => Step::Model,
            WitnessOf::Simulator => Step::Simulation,
            WitnessOf::System => Step::System,
        }
    }

    /// Its name in files: `model`, `simulation`, `corroborated`, `system`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Step::Model => "model",
            Step::Simulation => "simulation",
            Step::Corroborated => "corroborated",
            Step::System => "system",
        }
    }

    /// The step with this name in files.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|step| step.name() == name)
    }

    /// What stands beside a verdict: `for the model`, `in simulation`, `corroborated`, `of the system`.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Step::Model => "for the model",
            Step::Simulation => "in simulation",
            Step::Corroborated => "corroborated",
            Step::System => "of the system",
        }
    }
}

/// A declaration that the agreement of a model with the system carries over to a requirement.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct CarryOver {
    /// The model or simulation that speaks of the requirement.
    pub evidence: String,
    /// The evidence of the same model whose agreement with the system is shown: itself, or another piece under other
    /// conditions.
    pub shown_by: String,
    /// The requirement or failure mode on which that agreement is shown.
    pub on: Subject,
    /// What the carrying over rests on, in words.
    pub because: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_ordered_and_known_by_name() {
        assert!(Step::ALL.is_sorted());
        for step in Step::ALL {
            assert_eq!(Step::from_name(step.name()), Some(step));
            let json = serde_json::to_string(&step).expect("a name");
            assert_eq!(json, format!("\"{}\"", step.name()));
        }
        assert_eq!(Step::from_name("sim"), None);
    }
}
