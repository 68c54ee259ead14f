//! Changes of the texts that are neither a formal model nor the requirements: the ledger's methods, a scene's time step.
//!
//! # Definition
//! * *Methods*: the method whose bounds hold comes first in `methods`, so that its answer counts.
//! * *Step*: a time step is divided by a power of two ([`steps`]).
//!
//! # Source of [`steps`]
//! L. F. Richardson, "The approximate arithmetical solution by finite differences" (1911): of an error that is
//! proportional to the step, half is left at half the step, so that the rates at both tell the error.
//!
//! # Assumes
//! The error is proportional to the time step.
//!
//! # Guarantee
//! All else of the text stays as it is written.

use crate::toml_text::{get, number, span_of, table_of, with_id};
use prism_lang::edit::{self, Edit};
use toml::de::{DeTable, DeValue};

/// A change of one of these texts.
#[derive(Clone, Debug, PartialEq)]
pub enum TextChange {
    /// The ledger's entry takes this method first.
    Methods {
        /// The entry.
        evidence: String,
        /// The method.
        first: String,
    },
    /// A number in a scene or scenario, such as the time step, is divided.
    Step {
        /// Its place: `simulation.time_step_secs`.
        key: String,
        /// By what.
        divisor: u32,
    },
}

impl TextChange {
    /// The text after the change.
    ///
    /// # Errors
    /// Why it cannot be made, in one sentence.
    pub fn make(&self, text: &str) -> Result<String, String> {
        match self {
            Self::Methods { evidence, first } => methods(text, evidence, first),
            Self::Step { key, divisor } => step(text, key, *divisor),
        }
    }
}

fn methods(text: &str, evidence: &str, first: &str) -> Result<String, String> {
    let document = DeTable::parse(text).map_err(|error| error.to_string())?;
    let table = with_id(document.get_ref(), &["evidence"], evidence)
        .ok_or_else(|| format!("the ledger has no `{evidence}`"))?;
    let value = get(table, "methods").ok_or("its entry names no methods")?;
    let DeValue::Array(array) = value.get_ref() else {
        return Err("its `methods` must be a list".into());
    };
    let mut all = vec![format!("\"{first}\"")];
    for method in array.iter() {
        if let DeValue::String(name) = method.get_ref()
            && name.as_ref() != first
        {
            all.push(format!("\"{name}\""));
        }
    }
    let edit = Edit::replace(span_of(value), format!("[{}]", all.join(", ")));
    edit::apply(text, &[edit]).map_err(|error| error.to_string())
}

fn step(text: &str, key: &str, divisor: u32) -> Result<String, String> {
    let document = DeTable::parse(text).map_err(|error| error.to_string())?;
    let missing = || format!("the file has no number `{key}`");
    let (tables, name) = key.rsplit_once('.').unwrap_or(("", key));
    let mut table = document.get_ref();
    for part in tables.split('.').filter(|part| !part.is_empty()) {
        table = table_of(table, part).ok_or_else(missing)?;
    }
    let value = get(table, name).ok_or_else(missing)?;
    let old = number(value.get_ref()).ok_or_else(missing)?;
    let edit = Edit::replace(span_of(value), (old / f64::from(divisor)).to_string());
    edit::apply(text, &[edit]).map_err(|error| error.to_string())
}

/// By which power of two a time step is divided so that what is left of its error is at most `allowed`. Episodes that
/// violate something at the whole step and at half of it (`violated`), and those with two verdicts (`differing`), of all:
/// twice the difference of the rates is the error of the whole step, and is taken at the 95 % upper limit of it
/// (`1.645 sqrt(differing) / episodes`, McNemar's variance), since some ten episodes tell it within a factor only.
#[must_use]
pub fn steps(violated: [u64; 2], differing: u64, episodes: u64, allowed: f64) -> u32 {
    let chance = UPPER * (differing as f64).sqrt();
    let most = violated[0].abs_diff(violated[1]) as f64 + chance;
    let error = 2.0 * (most / episodes.max(1) as f64).min(1.0);
    let mut divisor = 2;
    while error / f64::from(divisor) > allowed && divisor < LEAST_STEP {
        divisor *= 2;
    }
    divisor
}

/// The standard normal quantile of 95 %.
const UPPER: f64 = 1.644_853_626_951_472_2;

/// The most by which a step is divided.
const LEAST_STEP: u32 = 64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sound_method_comes_first_and_the_others_stay() {
        let text = "[[evidence]]\nid = \"A\"\nmethods = [\"sound\"]\n\n[[evidence]]\nid = \"B\"\n\
                    methods = [\"prism-default\", \"sound\"] # both\n";
        let change = TextChange::Methods {
            evidence: "B".into(),
            first: "sound".into(),
        };
        let swapped = text.replace(
            "\"prism-default\", \"sound\"",
            "\"sound\", \"prism-default\"",
        );
        assert_eq!(change.make(text), Ok(swapped));
        let other = TextChange::Methods {
            evidence: "C".into(),
            first: "sound".into(),
        };
        assert!(other.make(text).is_err());
    }

    #[test]
    fn a_step_is_divided_where_it_stands() {
        let text = "[simulation]\nname = \"x\"\ntime_step_secs = 0.002 # s\n";
        let change = |key: &str| TextChange::Step {
            key: key.into(),
            divisor: 4,
        };
        let made = change("simulation.time_step_secs").make(text);
        assert_eq!(made, Ok(text.replace("0.002", "0.0005")));
        assert!(change("simulation.name").make(text).is_err());
        assert!(change("time_step_secs").make(text).is_err());
    }

    #[test]
    fn the_error_that_is_left_is_within_what_is_allowed() {
        // An error of 0.2 at the whole step, of first order: 0.05 at a quarter of it, and of many episodes no more.
        let many = 1_000_000_000;
        assert_eq!(steps([300_000_000, 200_000_000], 0, many, 0.05), 4);
        assert_eq!(
            steps([300_000_000, 200_000_000], 100_000_000, many, 0.06),
            4
        );
        assert_eq!(steps([100, 100], 0, 1000, 0.01), 2);
        assert_eq!(steps([100, 0], 100, 100, 1e-9), LEAST_STEP);
        // Ten of a hundred go one way: up to 15.2 may in truth.
        assert_eq!(steps([30, 20], 10, 100, 0.08), 4);
        assert_eq!(steps([30, 20], 10, 100, 0.077), 4);
        assert_eq!(steps([30, 20], 10, 100, 0.075), 8);
    }
}
