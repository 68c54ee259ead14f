//! What can keep a campaign from going on.

use std::fmt;

/// Why a campaign cannot go on with what it was given.
#[derive(Debug, Clone, PartialEq)]
pub enum CampaignError {
    /// A setting of an algorithm is out of its range.
    Setting {
        /// Which one.
        name: String,
        /// What is wrong, and what would be right.
        problem: String,
    },
    /// No (or hardly any) point of the space meets its constraints.
    TooTight {
        /// How many points were tried in a row without one being allowed.
        tried: usize,
    },
    /// A text could not be read; the message has the line.
    Text(String),
    /// Data names something that is not there.
    Unknown {
        /// What kind of thing: a variable, a label, a bin.
        kind: &'static str,
        /// Its name.
        name: String,
    },
}

impl CampaignError {
    /// An error of a setting.
    #[must_use]
    pub fn setting(name: &str, problem: impl Into<String>) -> Self {
        Self::Setting {
            name: name.to_owned(),
            problem: problem.into(),
        }
    }
}

impl fmt::Display for CampaignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Setting { name, problem } => write!(f, "`{name}`: {problem}"),
            Self::TooTight { tried } => write!(
                f,
                "none of {tried} points in a row met the constraints; widen them, or narrow the \
                 parameters to where they can hold"
            ),
            Self::Text(problem) => write!(f, "{}", problem.trim_end()),
            Self::Unknown { kind, name } => write!(f, "there is no {kind} `{name}`"),
        }
    }
}

impl std::error::Error for CampaignError {}
