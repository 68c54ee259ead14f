//! The fitted set as TOML, with what each value was fitted to.

use super::counts::Reality;
use super::file::CalibrationText;
use super::report::ParameterReport;
use super::written;
use crate::problem::{Problem, Source};
use std::fmt::Write;
use stimulus::Settings;
use toml::Table;

/// The parameters with the fitted values.
pub fn body(base: &Source, settings: &Settings) -> Result<String, Problem> {
    let table: Table =
        toml::from_str(&base.text).map_err(|error| Problem::from_toml(base, &error))?;
    let mut data = Table::new();
    data.insert("parameters".to_owned(), table.into());
    stimulus::apply(&mut data, settings)
        .map_err(|error| Problem::new("bad-settings", error.to_string()))?;
    match data.remove("parameters") {
        Some(toml::Value::Table(table)) => written(&table),
        _ => Ok(String::new()),
    }
}

/// Comments that say where the values are from.
pub fn heading(about: &CalibrationText, reality: &Reality, fitted: &[ParameterReport]) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_heading(&mut text, about, reality, fitted);
    text
}

fn write_heading(
    text: &mut String,
    about: &CalibrationText,
    reality: &Reality,
    fitted: &[ParameterReport],
) -> std::fmt::Result {
    writeln!(
        text,
        "# Written by `corroborate calibrate` from {}: agreement with what it was fitted to is a fit\n# and no independent confirmation.\n#\n# Fitted to the counts of {}:",
        about.parameters.display(),
        about.evidence
    )?;
    let counts = reality.fitted();
    for it in counts.iter().filter(|mode| !mode.held_out) {
        writeln!(
            text,
            "#   {} {}/{}",
            it.mode, it.occurrences, it.opportunities
        )?;
    }
    if let (true, Some(group)) = (reality.kept_out, reality.held_out.first()) {
        let names = reality.names(group).join(", ");
        writeln!(text, "# without the runs of {names}.")?;
    }
    if !about.hold_out.is_empty() {
        writeln!(
            text,
            "# Not fitted, only predicted: {}.",
            about.hold_out.join(", ")
        )?;
    }
    writeln!(
        text,
        "# Fitted values (posterior mean), with their credible intervals:"
    )?;
    for it in fitted {
        let unit = it
            .unit
            .as_ref()
            .map_or(String::new(), |unit| format!(" {unit}"));
        writeln!(
            text,
            "#   {}: {:.5}{unit} [{:.5}, {:.5}], sets {}",
            it.name,
            it.fitted,
            it.low,
            it.high,
            it.sets.join(", ")
        )?;
    }
    let known: Vec<&str> = about.known.keys().map(String::as_str).collect();
    if !known.is_empty() {
        writeln!(
            text,
            "# Taken as known, not fitted: values of {}.",
            known.join(", ")
        )?;
    }
    writeln!(text)
}
