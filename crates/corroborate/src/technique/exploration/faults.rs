//! Fault injection: what the bench's own data declares to fail now and then is
//! made to fail.
//!
//! # Definition
//! A fault is a number, or a distribution of one, in the bench's data whose
//! key says that it is a probability: it is `probability`, ends in
//! `_probability`, or has `_rate_per_` in it. So it needs no list of faults:
//! names in a bench's data carry their units. First each fault by itself is
//! made certain in the bench's first test, all else as declared. Later one or
//! two are drawn with a probability from 0.01 to 1, in any test that is there.
//! Values of other keys are injected where the plan names them.
//!
//! # Source
//! Fault injection as in M.-C. Hsueh, T. K. Tsai and R. K. Iyer, "Fault
//! injection techniques and tools" (1997); that rare draws of the environment
//! are the tester's to choose: R. Lee et al., "Adaptive stress testing" (2015).
//! Deviation: faults are chosen by rule and by chance, not by learning.
//!
//! # Assumes
//! A key that reads as a probability is one.
//!
//! # Guarantee
//! After as many episodes as there are faults, each was met alone. How often
//! it happens in use is not said: that is what its declared rate was for.

use super::plan::Plan;
use campaign::Random;
use diagnostic::Problem;
use schemars::JsonSchema;
use serde::Deserialize;
use stimulus::{Setting, Settings};
use toml::{Table, Value};

/// Values that a plan names for a key of the bench's data.
#[derive(Clone, Debug, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultData {
    /// The key, for example `parameters.planner.answer_secs`.
    pub key: String,
    /// What it is set to, one after the other.
    pub values: Vec<Setting>,
}

/// Something that can be made to fail.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Its key in the bench's data.
    pub key: String,
    /// Its values; a probability if there are none.
    pub values: Vec<Setting>,
}

/// The least probability that is drawn.
const LEAST: f64 = 0.01;

/// The faults that a bench's data declares, and those that a plan names.
pub fn faults(plan: &Plan, data: &Table) -> Result<Vec<Fault>, Problem> {
    let mut found = Vec::new();
    walk(data, "", &mut found);
    for named in &plan.data.fault {
        if named.values.is_empty() {
            return Err(plan.mistake(&named.key, "a fault has at least one value"));
        }
        let settings = Settings::from([(named.key.clone(), named.values[0].clone())]);
        stimulus::apply(&mut data.clone(), &settings)
            .map_err(|error| plan.mistake(&named.key, error.to_string()))?;
        found.retain(|fault| fault.key != named.key);
        found.push(Fault {
            key: named.key.clone(),
            values: named.values.clone(),
        });
    }
    Ok(found)
}

impl Fault {
    /// Its first values: certain, or those that are named.
    pub fn first(&self) -> Vec<Setting> {
        match self.values.is_empty() {
            true => vec![1.0.into()],
            false => self.values.clone(),
        }
    }

    fn draw(&self, random: &mut Random) -> Setting {
        if let Some(value) = self.values.get(random.index(self.values.len().max(1))) {
            return value.clone();
        }
        // Certain in half of the cases; else anything from the least, evenly in orders of magnitude.
        match random.chance(0.5) {
            true => 1.0.into(),
            false => LEAST.powf(random.open_unit()).into(),
        }
    }
}

/// One fault or two, with values.
pub fn draw(faults: &[Fault], random: &mut Random) -> Settings {
    let count = 1 + usize::from(faults.len() > 1 && random.chance(0.5));
    let places = random.permutation(faults.len()).into_iter().take(count);
    let drawn = places.filter_map(|place| {
        let fault = faults.get(place)?;
        Some((fault.key.clone(), fault.draw(random)))
    });
    drawn.collect::<Vec<_>>().into_iter().collect()
}

/// Settings in words.
pub fn in_words(settings: &Settings) -> String {
    let words: Vec<String> = settings.iter().map(|(k, v)| format!("{k} = {v}")).collect();
    words.join(", ")
}

fn is_probability(key: &str) -> bool {
    key == "probability" || key.ends_with("_probability") || key.contains("_rate_per_")
}

/// Appends the keys of all probabilities, in the order of the data.
fn walk(table: &Table, above: &str, found: &mut Vec<Fault>) {
    for (name, value) in table {
        let key = joined(above, name);
        match value {
            Value::Float(_) | Value::Integer(_) if is_probability(name) => found.push(of_key(key)),
            // A distribution of a probability.
            Value::Table(_) if is_probability(name) => found.push(of_key(key)),
            Value::Table(inner) => walk(inner, &key, found),
            Value::Array(entries) => {
                for (place, entry) in entries.iter().enumerate() {
                    let Some(inner) = entry.as_table() else {
                        continue;
                    };
                    let name = inner.get("name").and_then(Value::as_str);
                    let part = name.map_or_else(|| place.to_string(), str::to_owned);
                    walk(inner, &joined(&key, &part), found);
                }
            }
            _ => {}
        }
    }
}

fn of_key(key: String) -> Fault {
    Fault {
        key,
        values: Vec::new(),
    }
}

/// A dotted key; a part that is no plain word is in quotes.
fn joined(above: &str, part: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    let part = match part.chars().all(is_plain) && !part.is_empty() {
        true => part.to_owned(),
        false => format!("\"{part}\""),
    };
    match above.is_empty() {
        true => part,
        false => format!("{above}.{part}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DATA: &str = r#"
        [planner]
        failure_rate_per_run = 0.002
        answer_secs = 0.3
        [[sensor]]
        name = "front lidar"
        dropout_probability = { uniform = [0.0, 0.1] }
        [[sensor]]
        rate_hz = 10
        glitch_rate_per_reading = 0
    "#;

    fn declared() -> Vec<Fault> {
        let mut found = Vec::new();
        walk(&toml::from_str(DATA).unwrap(), "", &mut found);
        found
    }

    #[test]
    fn probabilities_are_found_by_their_names_and_can_be_set() {
        let keys: Vec<String> = declared().into_iter().map(|fault| fault.key).collect();
        let expected = [
            "planner.failure_rate_per_run",
            "sensor.\"front lidar\".dropout_probability",
            "sensor.1.glitch_rate_per_reading",
        ];
        assert_eq!(keys, expected);
        let settings: Settings = keys.into_iter().map(|key| (key, 1.0.into())).collect();
        let mut data: Table = toml::from_str(DATA).unwrap();
        stimulus::apply(&mut data, &settings).unwrap();
        assert_eq!(
            data["sensor"][1]["glitch_rate_per_reading"].as_integer(),
            Some(1)
        );
    }

    #[test]
    fn one_or_two_faults_are_drawn_with_probabilities() {
        let (faults, mut random) = (declared(), Random::new(1, "faults"));
        let (mut counts, mut certain) = ([0; 2], 0);
        for _ in 0..400 {
            let drawn = draw(&faults, &mut random);
            counts[drawn.len() - 1] += 1;
            for value in drawn.values() {
                let Setting::Number(value) = value else {
                    panic!("{value:?}")
                };
                assert!((LEAST..=1.0).contains(value), "{value}");
                certain += usize::from(*value == 1.0);
            }
        }
        // 200 each in the mean with a standard deviation of 10; half of 600 values.
        assert!(
            counts.iter().all(|count| (140..=260).contains(count)),
            "{counts:?}"
        );
        assert!((210..=390).contains(&certain), "{certain}");
    }
}
