//! What a monitor is to check, as it is written in a file.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A monitor as it is written down: propositions are names (or any text that the caller can give
/// a value to).
///
/// In TOML:
/// ```
/// let spec: temporal::monitor::MonitorSpec = toml::from_str(r#"
///     when = "robot_grasps_object"
///     then = [
///         { hold = "object_in_hand", until = "sensing_done" },
///         { assert = "sensors_ok" },
///         { wait_for = "robot_decided", within_secs = 5 },
///         { assert = "released" },
///     ]
///     repeat = "once"
/// "#)?;
/// assert_eq!(spec.then.len(), 4);
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MonitorSpec {
    /// The precondition.
    pub when: String,
    /// Whether the precondition triggers on becoming true (the default) or at each sample.
    #[serde(default)]
    pub trigger: Trigger,
    /// The postconditions, in the order in which they must be met.
    pub then: Vec<Stage>,
    /// Whether later triggers begin new instances (the default) or only the first one counts.
    #[serde(default)]
    pub repeat: Repeat,
    /// What becomes of an instance that is under way when a complete trace ends.
    #[serde(default)]
    pub at_end: AtEnd,
}

/// When a true precondition begins a new instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Trigger {
    /// Where the precondition becomes true.
    #[default]
    BecomesTrue,
    /// At every sample where the precondition is true.
    EachSample,
}

/// How many instances a trace may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Repeat {
    /// Each trigger begins an instance, unless one is under way.
    #[default]
    EveryTrigger,
    /// Only the first trigger of the trace begins an instance.
    Once,
}

/// What becomes of an instance that is under way at the end of a complete trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AtEnd {
    /// It stays open: neither passed nor failed.
    #[default]
    InconclusivePending,
    /// It fails: what has not happened by the end of the run will not happen.
    FailPending,
}

/// One postcondition.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(try_from = "StageText", into = "StageText")]
pub enum Stage {
    /// The proposition must be true at the sample where this stage is entered.
    Assert {
        /// What is asserted.
        proposition: String,
    },
    /// Waits until the proposition is true.
    WaitFor {
        /// What is waited for.
        proposition: String,
        /// The longest allowed wait in seconds; `None` for any.
        within_secs: Option<f64>,
    },
    /// The proposition must be true at every sample until `until` is true.
    Hold {
        /// What must hold.
        proposition: String,
        /// What ends this stage.
        until: String,
        /// The longest allowed duration of this stage in seconds; `None` for any.
        within_secs: Option<f64>,
    },
}

/// The form of a stage in a file, where the key says which kind it is.
#[derive(Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct StageText {
    /// What is true at the sample where this stage begins, or
    #[serde(default, skip_serializing_if = "Option::is_none")]
    assert: Option<String>,
    /// what is waited for, or
    #[serde(default, skip_serializing_if = "Option::is_none")]
    wait_for: Option<String>,
    /// what is true at every sample until `until` is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    hold: Option<String>,
    /// What ends a `hold`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    until: Option<String>,
    /// The longest that a `wait_for` or `hold` may take, in seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    within_secs: Option<f64>,
}

impl TryFrom<StageText> for Stage {
    type Error = SpecError;

    fn try_from(text: StageText) -> Result<Self, SpecError> {
        let StageText {
            assert,
            wait_for,
            hold,
            until,
            within_secs,
        } = text;
        match (assert, wait_for, hold, until) {
            (Some(proposition), None, None, None) if within_secs.is_none() => {
                Ok(Stage::Assert { proposition })
            }
            (Some(_), None, None, None) => Err(SpecError::AssertWithin),
            (None, Some(proposition), None, None) => Ok(Stage::WaitFor {
                proposition,
                within_secs,
            }),
            (None, None, Some(proposition), Some(until)) => Ok(Stage::Hold {
                proposition,
                until,
                within_secs,
            }),
            (None, None, Some(_), None) => Err(SpecError::HoldWithoutUntil),
            _ => Err(SpecError::StageKind),
        }
    }
}

impl From<Stage> for StageText {
    fn from(stage: Stage) -> Self {
        let mut text = StageText {
            assert: None,
            wait_for: None,
            hold: None,
            until: None,
            within_secs: None,
        };
        match stage {
            Stage::Assert { proposition } => text.assert = Some(proposition),
            Stage::WaitFor {
                proposition,
                within_secs,
            } => {
                text.wait_for = Some(proposition);
                text.within_secs = within_secs;
            }
            Stage::Hold {
                proposition,
                until,
                within_secs,
            } => {
                text.hold = Some(proposition);
                text.until = Some(until);
                text.within_secs = within_secs;
            }
        }
        text
    }
}

impl MonitorSpec {
    /// A monitor that triggers each time `when` becomes true, with the stages `then`.
    pub fn new(when: impl Into<String>, then: Vec<Stage>) -> Self {
        MonitorSpec {
            when: when.into(),
            trigger: Trigger::default(),
            then,
            repeat: Repeat::default(),
            at_end: AtEnd::default(),
        }
    }

    /// An invariant: at each sample where `when` is true, `then` must be true.
    pub fn invariant(when: impl Into<String>, then: impl Into<String>) -> Self {
        let stages = vec![Stage::Assert {
            proposition: then.into(),
        }];
        MonitorSpec {
            trigger: Trigger::EachSample,
            ..MonitorSpec::new(when, stages)
        }
    }

    /// The propositions in order of appearance, each once.
    #[must_use]
    pub fn propositions(&self) -> Vec<&str> {
        let mut names = vec![self.when.as_str()];
        for stage in &self.then {
            match stage {
                Stage::Assert { proposition } | Stage::WaitFor { proposition, .. } => {
                    names.push(proposition);
                }
                Stage::Hold {
                    proposition, until, ..
                } => names.extend([&**proposition, until]),
            }
        }
        let mut distinct = Vec::new();
        for name in names {
            if !distinct.contains(&name) {
                distinct.push(name);
            }
        }
        distinct
    }
}

/// Why a monitor as written makes no sense.
#[derive(Debug, Clone, PartialEq)]
pub enum SpecError {
    /// A stage has none, or more than one, of the keys that say what kind it is.
    StageKind,
    /// A `hold` does not say until when.
    HoldWithoutUntil,
    /// An `assert` has a deadline, which it cannot use.
    AssertWithin,
    /// There are no postconditions.
    NoStages,
    /// A proposition is an empty text.
    EmptyProposition,
    /// A deadline is negative or not a number.
    BadWithin {
        /// The deadline in seconds.
        within_secs: f64,
    },
}

impl fmt::Display for SpecError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SpecError::StageKind => out.write_str(
                "a stage of a monitor must be exactly one of { assert = p }, { wait_for = p } \
                 and { hold = p, until = q }",
            ),
            SpecError::HoldWithoutUntil => {
                out.write_str("a stage with \"hold\" must say until when: { hold = p, until = q }")
            }
            SpecError::AssertWithin => out.write_str(
                "a stage with \"assert\" is judged at once and takes no \"within_secs\"; use \
                 \"wait_for\" to allow time",
            ),
            SpecError::NoStages => out
                .write_str("a monitor needs at least one postcondition: then = [ { assert = p } ]"),
            SpecError::EmptyProposition => {
                out.write_str("a proposition of the monitor is empty; give it a name")
            }
            SpecError::BadWithin { within_secs } => write!(
                out,
                "within_secs = {within_secs} is not a duration; give a number of seconds that is \
                 not negative"
            ),
        }
    }
}

impl std::error::Error for SpecError {}
