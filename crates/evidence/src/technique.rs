//! The techniques, and what each says of itself as evidence.
//!
//! What compares, diagnoses, reports and refines asks for a technique's [`Traits`] and never for its name, so that a new
//! technique is one more variant and one more row of [`Technique::traits`], in which no field can be left out.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A way of finding out whether a requirement holds.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Technique {
    /// Exhaustive analysis of a formal model.
    ModelChecking,
    /// Exact analysis of a fault tree: how probable its events are, given its basic events.
    FaultTree,
    /// Seeded episodes of a physics simulation, judged by monitors.
    Simulation,
    /// Trials with the real robot.
    Experiment,
    /// Recordings of the robot at work, judged by monitors, live or later.
    Operation,
}

/// Of what a technique is a witness.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WitnessOf {
    /// Of a formal model: its values are computed.
    Model,
    /// Of a simulator: its values are counts of simulated runs.
    Simulator,
    /// Of the system itself: later trials do not take the place of earlier ones.
    System,
}

/// In which form a requirement is asked of a technique.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AskedBy {
    /// The property, evaluated on a model.
    Property,
    /// The event that the ledger names, of a tree.
    Event,
    /// The monitor, over runs.
    Monitor,
}

/// How one of its runs is looked at again.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Rerun {
    /// A path of its model is shown.
    Path,
    /// It has none: its model has events instead of runs.
    None,
    /// The episode is run again, from its seed; what others published cannot be.
    Episode,
    /// The recording is judged again.
    Recording,
    /// The same, where there is one: what was counted by hand has none, so that its runs are no witnesses.
    RecordingIfKept,
}

/// Its mark in plots.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Mark {
    /// A square on its corner.
    Diamond,
    /// A triangle on its point.
    Wedge,
    /// A disc.
    Circle,
    /// A square on its side.
    Square,
    /// A triangle, upright.
    Triangle,
}

/// What a technique says of itself as evidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Traits {
    /// Its word in files, as it is serialized.
    pub key: &'static str,
    /// Its name in running text.
    pub name: &'static str,
    /// Its name as a heading.
    pub heading: &'static str,
    /// Its mark in plots.
    pub mark: Mark,
    /// Of what it is a witness.
    pub witness_of: WitnessOf,
    /// In which form it is asked whether a requirement holds.
    pub asked_by: AskedBy,
    /// How one of its runs is looked at again.
    pub rerun: Rerun,
    /// Whether people set up its trials and count what happens, so that the form by which they counted is not known and
    /// names in their tables may be exchanged.
    pub is_counted_by_people: bool,
    /// Whether a report has a place for it that stays empty where a study has no such evidence.
    pub is_expected: bool,
}

impl Technique {
    /// All techniques, from the most abstract to the most real.
    pub const ALL: [Technique; 5] = [
        Technique::ModelChecking,
        Technique::FaultTree,
        Technique::Simulation,
        Technique::Experiment,
        Technique::Operation,
    ];

    /// What it says of itself.
    #[must_use]
    pub const fn traits(self) -> Traits {
        match self {
            Technique::ModelChecking => Traits {
                key: "model-checking",
                name: "model checking",
                heading: "Model checking",
                mark: Mark::Diamond,
                witness_of: WitnessOf::Model,
                asked_by: AskedBy::Property,
                rerun: Rerun::Path,
                is_counted_by_people: false,
                is_expected: true,
            },
            Technique::FaultTree => Traits {
                key: "fault-tree",
                name: "fault trees",
                heading: "Fault trees",
                mark: Mark::Wedge,
                witness_of: WitnessOf::Model,
                asked_by: AskedBy::Event,
                rerun: Rerun::None,
                is_counted_by_people: false,
                is_expected: false,
            },
            Technique::Simulation => Traits {
                key: "simulation",
                name: "simulation",
                heading: "Simulation",
                mark: Mark::Circle,
                witness_of: WitnessOf::Simulator,
                asked_by: AskedBy::Monitor,
                rerun: Rerun::Episode,
                is_counted_by_people: false,
                is_expected: true,
            },
            Technique::Experiment => Traits {
                key: "experiment",
                name: "experiments",
                heading: "Experiments",
                mark: Mark::Square,
                witness_of: WitnessOf::System,
                asked_by: AskedBy::Monitor,
                rerun: Rerun::RecordingIfKept,
                is_counted_by_people: true,
                is_expected: true,
            },
            Technique::Operation => Traits {
                key: "operation",
                name: "operation",
                heading: "Operation",
                mark: Mark::Triangle,
                witness_of: WitnessOf::System,
                asked_by: AskedBy::Monitor,
                rerun: Rerun::Recording,
                is_counted_by_people: false,
                is_expected: false,
            },
        }
    }

    /// The technique's name in running text.
    #[must_use]
    pub const fn name(self) -> &'static str {
        self.traits().name
    }

    /// Of what it is a witness.
    #[must_use]
    pub const fn witness_of(self) -> WitnessOf {
        self.traits().witness_of
    }

    /// Whether it is a witness of a formal model.
    #[must_use]
    pub fn is_of_model(self) -> bool {
        self.witness_of() == WitnessOf::Model
    }

    /// Whether it is a witness of a simulator.
    #[must_use]
    pub fn is_of_simulator(self) -> bool {
        self.witness_of() == WitnessOf::Simulator
    }

    /// Whether it is a witness of the system itself.
    #[must_use]
    pub fn is_of_system(self) -> bool {
        self.witness_of() == WitnessOf::System
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn keys_are_those_of_files_and_words_and_marks_tell_techniques_apart() {
        assert!(Technique::ALL.is_sorted());
        for technique in Technique::ALL {
            let json = serde_json::to_string(&technique).expect("a name");
            assert_eq!(json, format!("\"{}\"", technique.traits().key));
        }
        let count = Technique::ALL.len();
        let distinct = |of: fn(Traits) -> &'static str| {
            let words = Technique::ALL.map(|it| of(it.traits()));
            BTreeSet::from(words).len()
        };
        assert_eq!(distinct(|it| it.name), count);
        assert_eq!(distinct(|it| it.heading), count);
        assert_eq!(
            BTreeSet::from(Technique::ALL.map(|it| it.traits().mark)).len(),
            count
        );
    }
}
