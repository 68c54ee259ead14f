//! What can be wrong with a stimulus, a space, or a setting.

use std::fmt;

/// Why a text, a space or a setting was refused. Every message names the key or the line.
#[derive(Debug, Clone, PartialEq)]
pub enum StimulusError {
    /// The text is no TOML or JSON of the expected form; the message has line and column.
    Text(String),
    /// The numbers of a distribution make no sense.
    Distribution(String),
    /// A parameter of a space is wrong.
    Parameter {
        /// The parameter's name.
        name: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A point does not belong to the space.
    Point(String),
    /// An action of a test is wrong.
    Action {
        /// The test's name.
        test: String,
        /// The action's place, from 0.
        index: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// A key that the bench's data does not have.
    UnknownKey {
        /// The dotted key as it was given.
        key: String,
        /// The longest part of it that exists; empty when nothing of it does.
        known: String,
        /// The nearest name at the place where it goes wrong.
        similar: Option<String>,
    },
    /// A key that exists, but cannot be set to this value.
    Unsettable {
        /// The dotted key.
        key: String,
        /// Why not.
        problem: String,
    },
}

impl StimulusError {
    pub(crate) fn parameter(name: &str, problem: impl Into<String>) -> Self {
        Self::Parameter {
            name: name.to_owned(),
            problem: problem.into(),
        }
    }

    pub(crate) fn unsettable(key: &str, problem: impl Into<String>) -> Self {
        Self::Unsettable {
            key: key.to_owned(),
            problem: problem.into(),
        }
    }
}

impl fmt::Display for StimulusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(problem) => write!(f, "{}", problem.trim_end()),
            Self::Distribution(problem) => write!(f, "the distribution is wrong: {problem}"),
            Self::Parameter { name, problem } => write!(f, "parameter `{name}`: {problem}"),
            Self::Point(problem) => write!(f, "the point does not fit the space: {problem}"),
            Self::Action {
                test,
                index,
                problem,
            } => write!(f, "test `{test}`, action {index} (from 0): {problem}"),
            Self::UnknownKey {
                key,
                known,
                similar,
            } => {
                write!(f, "there is no `{key}` to set")?;
                if !known.is_empty() {
                    write!(f, " (there is `{known}`)")?;
                }
                match similar {
                    Some(similar) => write!(f, "; did you mean `{similar}`?"),
                    None => Ok(()),
                }
            }
            Self::Unsettable { key, problem } => write!(f, "`{key}` cannot be set: {problem}"),
        }
    }
}

impl std::error::Error for StimulusError {}
