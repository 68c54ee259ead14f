//! Actions by what they do: "send ready", "receive announcement", "set gaze", "set gaze=false".

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stimulus::{AbstractTest, Action, Setting, Verb};

/// Which actions are meant, written as a text.
///
/// ```
/// use campaign::ActionPattern;
/// use stimulus::Action;
/// let pattern: ActionPattern = "set gaze=false".to_owned().try_into()?;
/// assert!(pattern.matches(&Action::set("gaze", false)));
/// assert!(!pattern.matches(&Action::set("gaze", true)));
/// # Ok::<(), String>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum ActionPattern {
    /// Sends this signal.
    Send(String),
    /// Waits for this signal.
    Receive(String),
    /// Sets this parameter, to this value if one is given.
    Set(String, Option<Setting>),
}

impl ActionPattern {
    /// Whether an action is one of those that are meant.
    #[must_use]
    pub fn matches(&self, action: &Action) -> bool {
        match (self, &action.verb) {
            (Self::Send(name), Verb::Send(signal))
            | (Self::Receive(name), Verb::Receive(signal)) => name == signal,
            (Self::Set(name, value), Verb::Set(values)) => {
                let found = values.get(name);
                found.is_some_and(|found| value.as_ref().is_none_or(|value| value == found))
            }
            _ => false,
        }
    }

    /// Whether some action of a test is meant.
    #[must_use]
    pub fn is_in(&self, test: &AbstractTest) -> bool {
        test.actions.iter().any(|action| self.matches(action))
    }
}

impl TryFrom<String> for ActionPattern {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let (verb, name) = text.split_once(' ').unwrap_or((&text, ""));
        let name = name.trim();
        match (verb, name) {
            (_, "") => {}
            ("send", name) => return Ok(Self::Send(name.to_owned())),
            ("receive", name) => return Ok(Self::Receive(name.to_owned())),
            ("set", name) => {
                return Ok(match name.split_once('=') {
                    Some((name, value)) => Self::Set(name.to_owned(), Some(value_of(value))),
                    None => Self::Set(name.to_owned(), None),
                });
            }
            _ => {}
        }
        Err(format!(
            "unknown action `{text}`; write \"send signal\", \"receive signal\", \"set parameter\" \
             or \"set parameter=value\""
        ))
    }
}

fn value_of(text: &str) -> Setting {
    match (text, text.parse::<f64>()) {
        ("true", _) => Setting::Bool(true),
        ("false", _) => Setting::Bool(false),
        (_, Ok(number)) if number.is_finite() => Setting::Number(number),
        _ => Setting::Text(text.trim_matches('"').to_owned()),
    }
}

impl From<ActionPattern> for String {
    fn from(pattern: ActionPattern) -> Self {
        pattern.to_string()
    }
}

impl fmt::Display for ActionPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Send(name) => write!(f, "send {name}"),
            Self::Receive(name) => write!(f, "receive {name}"),
            Self::Set(name, None) => write!(f, "set {name}"),
            Self::Set(name, Some(value)) => write!(f, "set {name}={value}"),
        }
    }
}
