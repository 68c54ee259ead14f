//! Verdicts and robustness over time, as a recording that viewers open beside the original.
//!
//! # Format
//! An MCAP file of ROS 2 messages (see [`Ros2Recording`]), since these are
//! what both Foxglove and Rerun read. Give the log times of the original
//! ([`Moment::log_nanos`](crate::Moment)), so that both lie over each other. Foxglove plots the
//! numbers and lists the log; Rerun (0.41) shows the log by level and the verdicts as text, and has
//! the numbers as a component to be chosen for a plot. For each requirement:
//!
//! | topic | type | holds |
//! |---|---|---|
//! | `/corroborate/<id>/robustness` | `std_msgs/msg/Float64` | how far from being violated (positive) or satisfied (negative), NaN where unknown |
//! | `/corroborate/<id>/verdict` | `std_msgs/msg/String` | `undecided`, `satisfied`, `violated`, `inconclusive` or `not covered`, at each change |
//! | `/corroborate/log` | `rcl_interfaces/msg/Log` | each change of a verdict with its explanation; violations have level error |
//!
//! Letters of an identifier that topics cannot have become `_`. The requirements' texts stand in
//! the metadata record `corroborate.requirements`.
//!
//! # Example
//! ```
//! use recording::{ShownVerdict, VerdictFile};
//! let mut file = VerdictFile::new()?;
//! let slow = file.add_requirement("R1", "The hand moves slower than 250 mm/s.")?;
//! file.robustness(slow, 1_000_000_000, 0.05)?;
//! file.robustness(slow, 1_001_000_000, -0.01)?;
//! file.verdict(slow, 1_001_000_000, ShownVerdict::Violated, "/robot.hand_speed is 0.26 m/s")?;
//! let bytes = file.finish()?;
//! # assert!(!bytes.is_empty());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;
use std::fmt;

use crate::ros2_writer::{Ros2Recording, Ros2TopicId, Ros2Value, Ros2WriteError};

/// Levels of `rcl_interfaces/msg/Log`.
const LEVEL_INFO: f64 = 20.0;
const LEVEL_WARN: f64 = 30.0;
const LEVEL_ERROR: f64 = 40.0;

/// What is known of a requirement at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShownVerdict {
    /// Nothing yet.
    Undecided,
    /// It holds, whatever comes.
    Satisfied,
    /// It does not hold, whatever comes.
    Violated,
    /// The recording ended before it was decided.
    Inconclusive,
    /// What the requirement is about never happened.
    NotCovered,
}

impl ShownVerdict {
    fn level(self) -> f64 {
        match self {
            ShownVerdict::Undecided | ShownVerdict::Satisfied => LEVEL_INFO,
            ShownVerdict::Inconclusive | ShownVerdict::NotCovered => LEVEL_WARN,
            ShownVerdict::Violated => LEVEL_ERROR,
        }
    }
}

impl fmt::Display for ShownVerdict {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            ShownVerdict::Undecided => "undecided",
            ShownVerdict::Satisfied => "satisfied",
            ShownVerdict::Violated => "violated",
            ShownVerdict::Inconclusive => "inconclusive",
            ShownVerdict::NotCovered => "not covered",
        })
    }
}

/// A requirement of one [`VerdictFile`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShownRequirement(usize);

#[derive(Debug)]
struct Requirement {
    id: String,
    name: String,
    robustness: Ros2TopicId,
    verdict: Ros2TopicId,
}

/// A recording of verdicts that is being written.
#[derive(Debug)]
pub struct VerdictFile {
    recording: Ros2Recording,
    log: Ros2TopicId,
    requirements: Vec<Requirement>,
    texts: BTreeMap<String, String>,
}

impl VerdictFile {
    /// A file without requirements.
    ///
    /// # Errors
    /// [`Ros2WriteError::Format`] if the container cannot be begun.
    pub fn new() -> Result<Self, Ros2WriteError> {
        let mut recording = Ros2Recording::new()?;
        let log = recording.add_topic("/corroborate/log", "rcl_interfaces/msg/Log")?;
        Ok(VerdictFile {
            recording,
            log,
            requirements: Vec::new(),
            texts: BTreeMap::new(),
        })
    }

    /// Adds a requirement by its identifier and its text.
    ///
    /// # Errors
    /// [`Ros2WriteError::Format`] if there is one with this identifier, or one that differs from
    /// it only in letters that topics cannot have.
    pub fn add_requirement(
        &mut self,
        id: &str,
        text: &str,
    ) -> Result<ShownRequirement, Ros2WriteError> {
        let name = topic_name(id);
        if self.requirements.iter().any(|other| other.name == name) {
            return Err(Ros2WriteError::Format(format!(
                "the requirement {id} has the same topics as another one; rename it"
            )));
        }
        let topic = |what: &str| format!("/corroborate/{name}/{what}");
        let robustness = self
            .recording
            .add_topic(&topic("robustness"), "std_msgs/msg/Float64")?;
        let verdict = self
            .recording
            .add_topic(&topic("verdict"), "std_msgs/msg/String")?;
        self.texts.insert(id.to_owned(), text.to_owned());
        self.requirements.push(Requirement {
            id: id.to_owned(),
            name,
            robustness,
            verdict,
        });
        Ok(ShownRequirement(self.requirements.len() - 1))
    }

    /// Writes the robustness of a requirement at a time of the original; NaN where it is unknown.
    ///
    /// # Errors
    /// [`Ros2WriteError::Format`] if the time lies before 0.
    pub fn robustness(
        &mut self,
        requirement: ShownRequirement,
        log_nanos: i64,
        robustness: f64,
    ) -> Result<(), Ros2WriteError> {
        let topic = self.requirement(requirement)?.robustness;
        let value = [("data", Ros2Value::Number(robustness))];
        self.recording.write(topic, log_nanos, &value)
    }

    /// Writes that the verdict of a requirement changed at a time of the original, and why.
    ///
    /// # Errors
    /// [`Ros2WriteError`] if the time lies before 0, or the explanation has a zero byte.
    pub fn verdict(
        &mut self,
        requirement: ShownRequirement,
        log_nanos: i64,
        verdict: ShownVerdict,
        explanation: &str,
    ) -> Result<(), Ros2WriteError> {
        let found = self.requirement(requirement)?;
        let (id, topic, word) = (found.id.clone(), found.verdict, verdict.to_string());
        self.recording
            .write(topic, log_nanos, &[("data", Ros2Value::Text(&word))])?;
        let message = if explanation.is_empty() {
            format!("{id}: {word}")
        } else {
            format!("{id}: {word}: {explanation}")
        };
        let fields = [
            ("stamp", Ros2Value::Nanos(log_nanos)),
            ("level", Ros2Value::Number(verdict.level())),
            ("name", Ros2Value::Text(&id)),
            ("msg", Ros2Value::Text(&message)),
        ];
        self.recording.write(self.log, log_nanos, &fields)
    }

    fn requirement(&self, requirement: ShownRequirement) -> Result<&Requirement, Ros2WriteError> {
        let found = self.requirements.get(requirement.0);
        found.ok_or_else(|| Ros2WriteError::Format("the requirement is of another file".to_owned()))
    }

    /// The bytes of the file; the same calls give the same bytes.
    ///
    /// # Errors
    /// [`Ros2WriteError::Format`] if the container refuses.
    pub fn finish(mut self) -> Result<Vec<u8>, Ros2WriteError> {
        self.recording
            .add_metadata("corroborate.requirements", &self.texts)?;
        self.recording.finish()
    }
}

/// `id` with every letter that a topic cannot have replaced.
fn topic_name(id: &str) -> String {
    let fits = |letter: char| letter.is_ascii_alphanumeric() || letter == '_';
    let replaced = id
        .chars()
        .map(|letter| if fits(letter) { letter } else { '_' });
    let name: String = replaced.collect();
    // A part of a topic must not begin with a digit, nor be empty.
    match name.chars().next() {
        Some(first) if !first.is_ascii_digit() => name,
        _ => format!("r{name}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_become_parts_of_topics() {
        assert_eq!(topic_name("R3.1 (new)"), "R3_1__new_");
        assert_eq!(topic_name("3"), "r3");
        assert_eq!(topic_name(""), "r");
        let mut file = VerdictFile::new().unwrap();
        file.add_requirement("R.1", "a").unwrap();
        let message = file.add_requirement("R-1", "b").unwrap_err().to_string();
        assert!(message.contains("R-1 has the same topics"), "{message}");
    }

    #[test]
    fn the_same_calls_give_the_same_bytes() {
        let write = |robustness: f64| {
            let mut file = VerdictFile::new().unwrap();
            let one = file.add_requirement("R1", "text").unwrap();
            file.robustness(one, 5, robustness).unwrap();
            file.verdict(one, 6, ShownVerdict::NotCovered, "").unwrap();
            assert!(file.robustness(one, -1, 0.0).is_err());
            assert!(
                file.verdict(one, 7, ShownVerdict::Violated, "a\0b")
                    .is_err()
            );
            file.finish().unwrap()
        };
        assert_eq!(write(f64::NAN), write(f64::NAN));
        assert_ne!(write(0.0), write(1.0));
    }
}
