//! A stimulus of which some settings vary between episodes: each is a distribution from which an episode draws.
//!
//! The draw itself is that of whoever has the random numbers; so nothing here is random.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;

use crate::abstract_test::AbstractTest;
use crate::distribution::Distribution;
use crate::error::StimulusError;
use crate::setting::{Setting, Settings};
use crate::stimulus::{Stimulus, is_json};

/// What every episode is given, and what differs between them.
///
/// ```
/// use std::path::Path;
/// use stimulus::VariedStimulus;
///
/// let text = r#"
/// [test]
/// name = "push"
/// actions = []
///
/// [settings]
/// "crate.mass_kg" = 1.5
/// "ground.friction" = { uniform = [0.2, 0.4] }
/// "#;
/// let varied = VariedStimulus::read(Path::new("stimulus.toml"), text)?;
/// let episode = varied.at(&|_, distribution| distribution.quantile(0.5));
/// assert_eq!(episode.settings["ground.friction"].to_string(), "0.30000000000000004");
/// assert_eq!(episode.settings["crate.mass_kg"], 1.5.into());
/// # Ok::<(), stimulus::StimulusError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct VariedStimulus {
    /// What is done, and what is set to the same value in every episode.
    pub fixed: Stimulus,
    /// What each episode draws, by the dotted key that it sets.
    pub varied: BTreeMap<String, Distribution>,
}

/// The form of files: as that of a stimulus, but a setting may be a distribution.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    test: AbstractTest,
    #[serde(default)]
    settings: BTreeMap<String, toml::Value>,
}

impl VariedStimulus {
    /// Reads the form that a file's name tells: JSON of one that ends with `.json`, else TOML.
    ///
    /// # Errors
    /// [`StimulusError::Text`], of a wrong setting with its key.
    pub fn read(path: &Path, text: &str) -> Result<Self, StimulusError> {
        let plain = Stimulus::read(path, text);
        let file: Result<File, String> = match is_json(path) {
            true => serde_json::from_str(text).map_err(|error| error.to_string()),
            false => toml::from_str(text).map_err(|error| error.to_string()),
        };
        match (plain, file) {
            (Ok(fixed), _) => Ok(Self {
                fixed,
                varied: BTreeMap::new(),
            }),
            // Its error has a line and a column.
            (Err(error), Ok(file)) if !file.settings.values().any(toml::Value::is_table) => {
                Err(error)
            }
            (Err(_), Ok(file)) => Self::of_file(file),
            (Err(_), Err(error)) => Err(StimulusError::Text(error)),
        }
    }

    fn of_file(file: File) -> Result<Self, StimulusError> {
        let mut read = Self {
            fixed: Stimulus::of(file.test),
            varied: BTreeMap::new(),
        };
        for (key, value) in file.settings {
            let wrong = |error: String| StimulusError::Text(format!("`{key}`: {error}"));
            if value.is_table() {
                let found: Distribution = value.try_into().map_err(|e| wrong(text_of(&e)))?;
                found.check().map_err(|error| wrong(error.to_string()))?;
                if !is_of_numbers(&found) {
                    return Err(wrong("only numbers are drawn in an episode".into()));
                }
                read.varied.insert(key, found);
            } else {
                let found: Setting = value.try_into().map_err(|e| wrong(text_of(&e)))?;
                read.fixed.settings.insert(key, found);
            }
        }
        Ok(read)
    }

    /// A stimulus that is the same in every episode.
    #[must_use]
    pub fn of(fixed: Stimulus) -> Self {
        Self {
            fixed,
            varied: BTreeMap::new(),
        }
    }

    /// The stimulus of an episode for which `draw` draws, from the distribution of each key.
    #[must_use]
    pub fn at(&self, draw: &dyn Fn(&str, &Distribution) -> f64) -> Stimulus {
        let mut one = self.fixed.clone();
        let drawn = self.varied.iter();
        let drawn = drawn.map(|(key, from)| (key.clone(), Setting::from(draw(key, from))));
        one.settings.extend(drawn);
        one
    }

    /// Sets keys to the same value in every episode.
    pub fn fix(&mut self, settings: &Settings) {
        self.varied.retain(|key, _| !settings.contains_key(key));
        self.fixed.settings.extend(settings.clone());
    }

    /// The form that [`VariedStimulus::read`] reads from a file of this name.
    #[must_use]
    pub fn write(&self, path: &Path) -> String {
        if is_json(path) {
            return self.to_json();
        }
        let mut text = self.fixed.to_toml();
        for (key, distribution) in &self.varied {
            // A distribution is a table of finite numbers, which TOML can hold.
            if let Ok(value) = toml::Value::try_from(distribution) {
                let key = serde_json::Value::from(key.as_str());
                text.push_str(&format!("{key} = {value}\n"));
            }
        }
        text
    }

    /// The JSON form on one line; the same always gives the same text.
    #[must_use]
    pub fn to_json(&self) -> String {
        if self.varied.is_empty() {
            return self.fixed.to_json();
        }
        let mut value = serde_json::to_value(&self.fixed).unwrap_or_default();
        for (key, distribution) in &self.varied {
            value["settings"][key] = serde_json::to_value(distribution).unwrap_or_default();
        }
        value.to_string()
    }
}

/// An error of TOML without the lines of a text that is not the user's.
fn text_of(error: &toml::de::Error) -> String {
    error.message().to_owned()
}

/// Whether all that comes of it are numbers, not labels or truth values.
fn is_of_numbers(distribution: &Distribution) -> bool {
    !matches!(
        distribution,
        Distribution::Choice {
            options: crate::Options::Labels(_),
            ..
        } | Distribution::Boolean { .. }
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "test = { name = \"t\", actions = [] }\n[settings]\n";

    fn read(settings: &str) -> Result<VariedStimulus, StimulusError> {
        VariedStimulus::read(Path::new("s.toml"), &format!("{FILE}{settings}"))
    }

    #[test]
    fn what_is_written_is_read_again_in_both_forms() {
        let varied = read("\"a.b\" = { normal = [1.0, 0.1], low = 0.5 }\nwet = true\n").unwrap();
        assert_eq!(varied.varied.len(), 1);
        for name in ["s.toml", "s.json"] {
            let path = Path::new(name);
            let text = varied.write(path);
            assert_eq!(VariedStimulus::read(path, &text).unwrap(), varied, "{text}");
        }
    }

    #[test]
    fn what_does_not_vary_is_written_as_before() {
        let same = read("wet = true\nb = 2").unwrap();
        for name in ["s.toml", "s.json"] {
            let path = Path::new(name);
            assert_eq!(same.write(path), same.fixed.write(path));
        }
    }

    #[test]
    fn what_is_fixed_is_drawn_no_longer() {
        let mut varied =
            read("a = { uniform = [1.0, 2.0] }\nb = { uniform = [1.0, 2.0] }").unwrap();
        varied.fix(&Settings::from([("a".to_owned(), 7.0.into())]));
        let one = varied.at(&|_, from| from.quantile(1.0));
        assert_eq!(one.settings["a"], 7.0.into());
        assert_eq!(one.settings["b"], 2.0.into());
    }

    #[test]
    fn mistakes_name_their_key() {
        for (settings, said) in [
            ("a = { uniform = [2.0, 1.0] }", "`a`"),
            ("a = { unifrom = [1.0, 2.0] }", "`a`"),
            ("a = { choice = [\"x\", \"y\"] }", "only numbers"),
            ("a = [1.0]", "line 3"),
        ] {
            let error = read(settings).unwrap_err().to_string();
            assert!(error.contains(said), "{settings}: {error}");
        }
    }
}
