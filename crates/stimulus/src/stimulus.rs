//! A concrete stimulus: a test and the values that a bench is set to, as stable text with a hash.

use std::fmt::Write;
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::abstract_test::{AbstractTest, Action};
use crate::error::StimulusError;
use crate::setting::Settings;

/// What one episode is given, beside its seed.
///
/// ```
/// use stimulus::{AbstractTest, Action, Setting, Stimulus};
///
/// let stimulus = Stimulus {
///     test: AbstractTest::new("push", vec![Action::send("start"), Action::set("push", true)]),
///     settings: [("human.force_newtons".to_owned(), Setting::from(12.5))].into(),
/// };
/// let text = stimulus.to_toml();
/// assert_eq!(text, r#"[test]
/// name = "push"
/// actions = [
///   { send_signal = "start" },
///   { set_param = { push = true } },
/// ]
///
/// [settings]
/// "human.force_newtons" = 12.5
/// "#);
/// assert_eq!(Stimulus::from_toml(&text)?, stimulus);
/// assert_eq!(Stimulus::from_json(&stimulus.to_json())?.hash(), stimulus.hash());
/// # Ok::<(), stimulus::StimulusError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stimulus {
    /// What is done.
    pub test: AbstractTest,
    /// What the bench's data is set to, by dotted key.
    #[serde(default)]
    pub settings: Settings,
}

impl Stimulus {
    /// A test on a bench whose data stays as it is.
    #[must_use]
    pub fn of(test: AbstractTest) -> Self {
        Self {
            test,
            settings: Settings::new(),
        }
    }

    /// Reads the TOML form.
    ///
    /// # Errors
    /// [`StimulusError::Text`] with line and column.
    pub fn from_toml(text: &str) -> Result<Self, StimulusError> {
        toml::from_str(text).map_err(|error| StimulusError::Text(error.to_string()))
    }

    /// Reads the JSON form.
    ///
    /// # Errors
    /// [`StimulusError::Text`] with line and column.
    pub fn from_json(text: &str) -> Result<Self, StimulusError> {
        serde_json::from_str(text).map_err(|error| StimulusError::Text(error.to_string()))
    }

    /// Reads the form that a file's name tells: JSON of one that ends with `.json`, else TOML.
    ///
    /// # Errors
    /// [`StimulusError::Text`] with line and column.
    pub fn read(path: &Path, text: &str) -> Result<Self, StimulusError> {
        match is_json(path) {
            true => Self::from_json(text),
            false => Self::from_toml(text),
        }
    }

    /// The form that [`Stimulus::read`] reads from a file of this name.
    #[must_use]
    pub fn write(&self, path: &Path) -> String {
        match is_json(path) {
            true => self.to_json(),
            false => self.to_toml(),
        }
    }

    /// The TOML form, one action a line; the same stimulus always gives the same text.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
        let mut text = format!("[test]\nname = {}\nactions = [\n", quoted(&self.test.name));
        for action in &self.test.actions {
            let _ = writeln!(text, "  {},", action_in_line(action));
        }
        text.push_str("]\n\n[settings]\n");
        for (key, value) in &self.settings {
            let key = serde_json::Value::from(key.as_str());
            let _ = writeln!(text, "{key} = {}", value.to_toml());
        }
        text
    }

    /// The JSON form on one line; the same stimulus always gives the same text.
    #[must_use]
    pub fn to_json(&self) -> String {
        // Maps have texts as keys and numbers are finite, so that writing cannot fail.
        serde_json::to_string(self).unwrap_or_default()
    }

    /// BLAKE3 of the JSON form, as 64 hexadecimal digits; the test's name counts as well.
    #[must_use]
    pub fn hash(&self) -> String {
        blake3::hash(self.to_json().as_bytes()).to_hex().to_string()
    }

    /// The hash of what is done and set, whatever the test is called: two stimuli with the same
    /// content have the same effect.
    #[must_use]
    pub fn content_hash(&self) -> String {
        let mut nameless = self.clone();
        nameless.test.name.clear();
        nameless.hash()
    }
}

pub(crate) fn is_json(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension == "json")
}

/// One action as an inline table.
fn action_in_line(action: &Action) -> String {
    match toml::Value::try_from(action) {
        Ok(value) => value.to_string(),
        // An action is a table of texts and finite numbers, which TOML can hold.
        Err(_) => String::new(),
    }
}
