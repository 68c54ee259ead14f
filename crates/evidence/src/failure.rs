//! Episodes that were ended by what is tested, or by its simulator, and not by themselves.
//!
//! Every robot can fail in this way, so it is declared by no study: a robot's program that stops is
//! found whether or not somebody has thought of it. Such an episode stays a trial. What its
//! recording shows up to there is judged as a recording that was cut short, so what was not decided
//! by then is undecided.

use crate::Measure;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// What ended an episode that did not end by itself.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum FailureKind {
    /// The robot's program ended, reported an error, or answered what cannot be.
    ControllerFailed,
    /// The robot's program ran on and did not answer in time.
    ControllerHung,
    /// Another simulator ended with an error, or left no recording.
    SimulatorFailed,
    /// Another simulator did not end in time.
    SimulatorHung,
}

impl FailureKind {
    /// All of them.
    pub const ALL: [Self; 4] = [
        Self::ControllerFailed,
        Self::ControllerHung,
        Self::SimulatorFailed,
        Self::SimulatorHung,
    ];

    /// Its name, as in the JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::ControllerFailed => "controller-failed",
            Self::ControllerHung => "controller-hung",
            Self::SimulatorFailed => "simulator-failed",
            Self::SimulatorHung => "simulator-hung",
        }
    }

    /// That of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

impl fmt::Display for FailureKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::ControllerFailed => "the robot's program fails",
            Self::ControllerHung => "the robot's program hangs",
            Self::SimulatorFailed => "the simulator fails",
            Self::SimulatorHung => "the simulator hangs",
        })
    }
}

/// How many episodes were ended by one kind of failure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EpisodeFailures {
    /// What ended them.
    pub kind: FailureKind,
    /// Their share of all episodes.
    pub measure: Measure,
    /// The first of them.
    pub witnesses: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_json_and_tell_kinds_apart() {
        for kind in FailureKind::ALL {
            let json = serde_json::to_value(kind).unwrap();
            assert_eq!(json, kind.name());
            assert_eq!(FailureKind::named(kind.name()), Some(kind));
        }
        assert_eq!(FailureKind::named("complete"), None);
    }
}
