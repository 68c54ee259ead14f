//! Abstract tests: what is done to the system, in three verbs.
//!
//! A test sends signals, waits for signals, and sets parameters, in order. Names are the bench's.
//! Source: D. Araiza-Illan, D. Western, A. Pipe and K. Eder, "Coverage-driven verification: an
//! approach to verify code for robots that directly interact with humans" (2015), for the two
//! tiers: a test without numbers, made concrete by parameters.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::distribution::Distribution;
use crate::error::StimulusError;
use crate::setting::Setting;

/// A named list of actions.
///
/// ```
/// let test: stimulus::AbstractTest = toml::from_str(r#"
///     name = "typical use"
///     actions = [
///       { send_signal = "activate", after_secs = { uniform = [0.5, 6.0] } },
///       { receive_signal = "announcement" },
///       { set_param = { gaze = true, location = true }, after_secs = 0.5 },
///     ]"#)?;
/// assert_eq!(test.actions.len(), 3);
/// assert_eq!(test.to_string(),
///     "send activate; receive announcement; set gaze=true location=true");
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AbstractTest {
    /// What the test is called.
    pub name: String,
    /// What is done, in order.
    pub actions: Vec<Action>,
}

/// One action: a verb, and how long after the action before it is done.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(try_from = "ActionText", into = "ActionText")]
pub struct Action {
    /// What is done.
    pub verb: Verb,
    /// Delay since the action before was done, in seconds.
    pub after_secs: Distribution,
}

/// What an action does.
#[derive(Debug, Clone, PartialEq)]
pub enum Verb {
    /// Sends this signal to the system.
    Send(String),
    /// Waits until the system sends this signal.
    Receive(String),
    /// Sets these parameters; what is not named stays as it is.
    Set(BTreeMap<String, Setting>),
}

/// An action as it is written: exactly one of the three verbs.
#[derive(Clone, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct ActionText {
    /// Sends this signal to the system, or
    #[serde(skip_serializing_if = "Option::is_none")]
    send_signal: Option<String>,
    /// waits until the system sends this signal, or
    #[serde(skip_serializing_if = "Option::is_none")]
    receive_signal: Option<String>,
    /// sets these parameters; what is not named stays as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    set_param: Option<BTreeMap<String, Setting>>,
    /// How long after the action before it is done, in seconds.
    #[serde(default = "at_once", skip_serializing_if = "is_at_once")]
    after_secs: Distribution,
}

fn at_once() -> Distribution {
    Distribution::Constant(0.0)
}

fn is_at_once(delay: &Distribution) -> bool {
    *delay == at_once()
}

impl Action {
    /// An action without delay.
    #[must_use]
    pub fn new(verb: Verb) -> Self {
        Self {
            verb,
            after_secs: at_once(),
        }
    }

    /// The same action so many seconds (or a random time) later.
    #[must_use]
    pub fn after(mut self, delay_secs: Distribution) -> Self {
        self.after_secs = delay_secs;
        self
    }

    /// Sends a signal at once.
    #[must_use]
    pub fn send(signal: &str) -> Self {
        Self::new(Verb::Send(signal.to_owned()))
    }

    /// Waits for a signal.
    #[must_use]
    pub fn receive(signal: &str) -> Self {
        Self::new(Verb::Receive(signal.to_owned()))
    }

    /// Sets one parameter at once.
    #[must_use]
    pub fn set(parameter: &str, value: impl Into<Setting>) -> Self {
        let values = BTreeMap::from([(parameter.to_owned(), value.into())]);
        Self::new(Verb::Set(values))
    }

    /// What is wrong with the action by itself, if anything is.
    fn problem(&self) -> Option<String> {
        let empty_name = match &self.verb {
            Verb::Send(name) | Verb::Receive(name) => name.is_empty(),
            Verb::Set(values) => values.is_empty() || values.contains_key(""),
        };
        if empty_name {
            return Some("a signal or parameter without a name".to_owned());
        }
        if let Err(error) = self.after_secs.check() {
            return Some(format!("after_secs: {error}"));
        }
        let negative = self.after_secs.support()[0] < 0.0;
        negative.then(|| "after_secs can be negative; a delay starts at 0".to_owned())
    }
}

impl AbstractTest {
    /// A test of these actions.
    #[must_use]
    pub fn new(name: impl Into<String>, actions: Vec<Action>) -> Self {
        Self {
            name: name.into(),
            actions,
        }
    }

    /// Checks every action: names, and delays that cannot be negative.
    ///
    /// # Errors
    /// [`StimulusError::Action`] with the first wrong action's place.
    pub fn check(&self) -> Result<(), StimulusError> {
        for (index, action) in self.actions.iter().enumerate() {
            if let Some(problem) = action.problem() {
                return Err(StimulusError::Action {
                    test: self.name.clone(),
                    index,
                    problem,
                });
            }
        }
        Ok(())
    }
}

impl TryFrom<ActionText> for Action {
    type Error = String;

    fn try_from(text: ActionText) -> Result<Self, String> {
        let verbs = [
            text.send_signal.map(Verb::Send),
            text.receive_signal.map(Verb::Receive),
            text.set_param.map(Verb::Set),
        ];
        let mut verbs = verbs.into_iter().flatten();
        let (Some(verb), None) = (verbs.next(), verbs.next()) else {
            return Err(
                "an action needs exactly one of send_signal, receive_signal and set_param"
                    .to_owned(),
            );
        };
        let action = Self {
            verb,
            after_secs: text.after_secs,
        };
        match action.problem() {
            Some(problem) => Err(problem),
            None => Ok(action),
        }
    }
}

impl From<Action> for ActionText {
    fn from(action: Action) -> Self {
        let mut text = Self {
            send_signal: None,
            receive_signal: None,
            set_param: None,
            after_secs: action.after_secs,
        };
        match action.verb {
            Verb::Send(signal) => text.send_signal = Some(signal),
            Verb::Receive(signal) => text.receive_signal = Some(signal),
            Verb::Set(values) => text.set_param = Some(values),
        }
        text
    }
}

impl std::fmt::Display for Verb {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Send(signal) => write!(f, "send {signal}"),
            Self::Receive(signal) => write!(f, "receive {signal}"),
            Self::Set(values) => {
                write!(f, "set")?;
                values
                    .iter()
                    .try_for_each(|(name, value)| write!(f, " {name}={value}"))
            }
        }
    }
}

impl std::fmt::Display for AbstractTest {
    /// The verbs in order, without delays.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, action) in self.actions.iter().enumerate() {
            let separator = if index == 0 { "" } else { "; " };
            write!(f, "{separator}{}", action.verb)?;
        }
        Ok(())
    }
}
