//! Why what a text describes cannot be simulated.

use std::fmt;

/// Why a scenario or a parameter set cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ScenarioError {
    /// The text is not TOML, or a key is missing, unknown or of the wrong type.
    Syntax {
        /// What the TOML reader says, with line and column.
        reason: String,
    },
    /// A value is out of its range.
    Value {
        /// The key.
        key: String,
        /// What is wrong.
        problem: String,
    },
    /// A name refers to nothing.
    UnknownName {
        /// Where the name stands.
        key: String,
        /// The name.
        name: String,
    },
    /// A robot's or object's description cannot be read.
    Description {
        /// Its file.
        file: String,
        /// What is wrong, with places and remedies.
        reason: String,
    },
    /// More than one of them.
    Several(Vec<ScenarioError>),
}

impl ScenarioError {
    /// All that was found, if anything was.
    ///
    /// # Errors
    /// The one error, or [`ScenarioError::Several`].
    pub fn all(found: Vec<ScenarioError>) -> Result<(), ScenarioError> {
        let mut found: Vec<ScenarioError> = found.into_iter().flat_map(Self::each).collect();
        match found.len() {
            0 => Ok(()),
            1 => Err(found.remove(0)),
            _ => Err(Self::Several(found)),
        }
    }

    /// It, or all of several.
    fn each(self) -> Vec<ScenarioError> {
        match self {
            Self::Several(all) => all,
            one => vec![one],
        }
    }

    /// A value out of range: its key, and what is wrong with it, so that the message reads "`key` must ...".
    #[must_use]
    pub fn value(key: &str, problem: &str) -> Self {
        Self::Value {
            key: key.to_owned(),
            problem: problem.to_owned(),
        }
    }
}

impl fmt::Display for ScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Several(all) => {
                let texts: Vec<String> = all.iter().map(ToString::to_string).collect();
                f.write_str(&texts.join("\n"))
            }
            Self::Syntax { reason } => write!(f, "the scenario cannot be read: {reason}"),
            Self::Value { key, problem } => {
                write!(f, "`{key}` {problem}")
            }
            Self::Description { file, reason } => write!(f, "{file}: {reason}"),
            Self::UnknownName { key, name } => write!(
                f,
                "`{key}` names `{name}`, which the scenario does not define"
            ),
        }
    }
}

impl std::error::Error for ScenarioError {}
