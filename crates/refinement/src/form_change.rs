//! Changes of `requirements.toml`: a monitor's clauses by another reading, a limit by the declared parameter, a form
//! by that of the sentence.
//!
//! The file is changed at the place of the values; all else stays as it is written.
//!
//! A form that was written by hand and says something else than the requirement's sentence is taken out
//! ([`FormChange::Derived`]): the form that follows from the sentence takes its place. Guarantee: what is left of the
//! file has the same values as before, else the change is refused.
//!
//! # Assumes
//! The sentence is what is meant.

use crate::toml_text::{Table, get, number, span_of, table_of, with_id, without};
use prism_lang::edit::{self, Edit};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A change of `requirements.toml`.
#[derive(Clone, Debug, PartialEq)]
pub enum FormChange {
    /// The monitor takes the clauses of a reading.
    Reading {
        /// The requirement.
        requirement: String,
        /// The reading.
        reading: String,
    },
    /// A time limit takes the declared value.
    Limit {
        /// The requirement.
        requirement: String,
        /// `monitor`, or the name of a reading.
        form: String,
        /// What it is now, in seconds.
        found_secs: f64,
        /// What is declared, in seconds.
        declared_secs: f64,
    },
    /// A form that was written by hand goes, and that of the sentence takes its place.
    Derived {
        /// The requirement.
        requirement: String,
        /// `property` or `monitor`.
        form: String,
    },
}

/// The keys of a requirement that make its property, and those that make its monitor.
const PROPERTY: [&str; 1] = ["property"];
const MONITOR: [&str; 5] = ["monitor", "formula", "time", "ending", "clock"];

impl FormChange {
    /// The requirement and the form that it changes.
    #[must_use]
    pub fn touches(&self) -> (&str, &str) {
        match self {
            Self::Reading { requirement, .. } => (requirement, "monitor"),
            Self::Limit {
                requirement, form, ..
            }
            | Self::Derived { requirement, form } => (requirement, form),
        }
    }

    /// The text of `requirements.toml` after the change.
    ///
    /// # Errors
    /// Why it cannot be made, in one sentence.
    pub fn make(&self, text: &str) -> Result<String, String> {
        let document = DeTable::parse(text).map_err(|error| error.to_string())?;
        let edits = match self {
            Self::Derived { requirement, form } => return derived(text, requirement, form),
            Self::Reading {
                requirement,
                reading,
            } => reading_edits(text, document.get_ref(), requirement, reading)?,
            Self::Limit {
                requirement,
                form,
                found_secs,
                declared_secs,
            } => {
                let table = subject(document.get_ref(), requirement)?;
                let monitor = match form.as_str() {
                    "monitor" => table_of(table, "monitor"),
                    name => reading_of(table, name),
                };
                let monitor = monitor.ok_or("it has no monitor of its own")?;
                limit_edits(monitor, *found_secs, *declared_secs)
            }
        };
        if edits.is_empty() {
            return Err("the value does not stand in requirements.toml".into());
        }
        edit::apply(text, &edits).map_err(|error| error.to_string())
    }
}

/// The table of a requirement or failure mode.
fn subject<'t, 'a>(document: &'t Table<'a>, id: &str) -> Result<&'t Table<'a>, String> {
    with_id(document, &["requirement", "failure_mode"], id)
        .ok_or_else(|| format!("requirements.toml has no `{id}`"))
}

fn reading_of<'t, 'a>(table: &'t Table<'a>, name: &str) -> Option<&'t Table<'a>> {
    table_of(table_of(table_of(table, "reading")?, name)?, "monitor")
}

fn reading_edits(
    text: &str,
    document: &Table,
    requirement: &str,
    reading: &str,
) -> Result<Vec<Edit>, String> {
    let table = subject(document, requirement)?;
    let main = table_of(table, "monitor").ok_or("its monitor is not written by hand")?;
    let other = reading_of(table, reading).ok_or("the reading is not a monitor")?;
    let keys = |table: &Table| -> Vec<String> {
        let all = table.keys().map(|key| key.get_ref().to_string());
        all.collect()
    };
    let (mut of_main, mut of_other) = (keys(main), keys(other));
    of_main.sort();
    of_other.sort();
    if of_main != of_other {
        return Err("the two monitors do not have the same keys".into());
    }
    let mut edits = Vec::new();
    for key in of_main {
        if let (Some(old), Some(new)) = (get(main, &key), get(other, &key)) {
            let (old, new) = (span_of(old), span_of(new));
            if old.of(text) != new.of(text) {
                edits.push(Edit::replace(old, new.of(text)));
            }
        }
    }
    Ok(edits)
}

/// Each `within_secs` of the stages that has the value.
fn limit_edits(monitor: &Table, found_secs: f64, declared_secs: f64) -> Vec<Edit> {
    let Some(DeValue::Array(stages)) = get(monitor, "then").map(Spanned::get_ref) else {
        return Vec::new();
    };
    let mut edits = Vec::new();
    for stage in stages.iter() {
        if let DeValue::Table(stage) = stage.get_ref()
            && let Some(limit) = get(stage, "within_secs")
            && number(limit.get_ref()) == Some(found_secs)
        {
            edits.push(Edit::replace(span_of(limit), declared_secs.to_string()));
        }
    }
    edits
}

/// The text without a form that was written by hand.
fn derived(text: &str, requirement: &str, form: &str) -> Result<String, String> {
    let document = DeTable::parse(text).map_err(|error| error.to_string())?;
    let table = subject(document.get_ref(), requirement)?;
    if get(table, "shall").is_none() && get(table, "template").is_none() {
        return Err("it has no sentence from which a form could follow".into());
    }
    let keys: &[&str] = match form {
        "property" => &PROPERTY,
        "monitor" => &MONITOR,
        _ => return Err(format!("`{form}` is neither its property nor its monitor")),
    };
    let edits = keys.iter().flat_map(|key| without(text, table, key));
    let edits: Vec<Edit> = edits.collect();
    if edits.is_empty() {
        return Err(format!("its {form} is not written by hand"));
    }
    let changed = edit::apply(text, &edits).map_err(|error| error.to_string())?;
    let (before, after) = (values(text)?, values(&changed)?);
    match same_but_for(&before, &after, requirement, keys) {
        true => Ok(changed),
        false => Err(format!(
            "its {form} stands in a table of its own; take it out by hand"
        )),
    }
}

fn values(text: &str) -> Result<toml::Table, String> {
    text.parse()
        .map_err(|error: toml::de::Error| error.to_string())
}

/// Whether `after` is `before` without these keys of one requirement.
fn same_but_for(before: &toml::Table, after: &toml::Table, id: &str, keys: &[&str]) -> bool {
    let mut wanted = before.clone();
    let requirements = wanted
        .get_mut("requirement")
        .and_then(toml::Value::as_array_mut);
    for table in requirements
        .into_iter()
        .flatten()
        .filter_map(toml::Value::as_table_mut)
    {
        if table.get("id").and_then(toml::Value::as_str) == Some(id) {
            table.retain(|key, _| !keys.contains(&key));
        }
    }
    &wanted == after
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "# What is required.\n[[requirement]]\nid = \"1\"\nshall = \"The robot shall stop.\" # meant\n\
        property = 'P=? [ F \"stopped\" ]'\nmonitor.when = \"go\"\nmonitor.then = [\n    { wait_for = \"stopped\" },\n]\n\
        margin = 0.1\n\n[[requirement]]\nid = \"2\"\nmonitor = { when = \"go\", then = [] }\nproperty = 'true'\n";

    fn derive(requirement: &str, form: &str) -> Result<String, String> {
        let (requirement, form) = (requirement.to_owned(), form.to_owned());
        FormChange::Derived { requirement, form }.make(TEXT)
    }

    #[test]
    fn a_form_is_taken_out_and_nothing_else() {
        let without = derive("1", "monitor").expect("a change");
        let gone = "monitor.when = \"go\"\nmonitor.then = [\n    { wait_for = \"stopped\" },\n]\n";
        assert_eq!(without, TEXT.replace(gone, ""));
        let without = derive("1", "property").expect("a change");
        assert_eq!(
            without,
            TEXT.replace("property = 'P=? [ F \"stopped\" ]'\n", "")
        );
    }

    #[test]
    fn what_has_no_sentence_keeps_its_form() {
        let refusal = derive("2", "monitor").expect_err("no sentence");
        assert!(refusal.contains("no sentence"), "{refusal}");
        let refusal = derive("3", "monitor").expect_err("no requirement");
        assert!(refusal.contains("`3`"), "{refusal}");
        let table = TEXT
            .replace("monitor.when", "[requirement.monitor]\nwhen")
            .replace("monitor.then", "then");
        let change = FormChange::Derived {
            requirement: "1".into(),
            form: "monitor".into(),
        };
        let refusal = change.make(&table).expect_err("a header stays");
        assert!(refusal.contains("by hand"), "{refusal}");
    }
}
