//! The fitted set as TOML, with what each value was fitted to.

use super::counts::Reality;
use super::file::CalibrationText;
use evidence::{LineageReport, ParameterReport};
use std::fmt::Write;
use std::path::Path;

/// What the comments of a fitted set say.
pub struct Written<'a> {
    pub about: &'a CalibrationText,
    /// The file that it was made from.
    pub file: &'a Path,
    pub reality: &'a Reality,
    pub fitted: &'a [ParameterReport],
    pub lineage: &'a LineageReport,
    pub engine: &'a str,
    /// Whether these episodes are of the fast physics.
    pub is_fast: bool,
    /// Episodes that the posterior rests on.
    pub episodes: usize,
}

/// Comments that say where the values are from.
pub fn heading(written: &Written<'_>) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = written.counts(&mut text);
    let _ = written.values(&mut text);
    let _ = written.origin(&mut text);
    text
}

impl Written<'_> {
    fn counts(&self, text: &mut String) -> std::fmt::Result {
        let about = self.about;
        writeln!(
            text,
            "# Written by `corroborate calibrate` from {}: agreement with what it was fitted to is a fit\n# and no independent confirmation.\n#\n# Fitted to the counts of {}:",
            self.file.display(),
            about.evidence
        )?;
        let counts = self.reality.fitted();
        for it in counts.iter().filter(|mode| !mode.held_out) {
            writeln!(
                text,
                "#   {} {}/{}",
                it.mode, it.occurrences, it.opportunities
            )?;
        }
        if let (true, Some(group)) = (self.reality.kept_out, self.reality.held_out.first()) {
            let names = self.reality.names(group).join(", ");
            writeln!(text, "# without the runs of {names}.")?;
        }
        if about.hold_out.is_empty() {
            return Ok(());
        }
        let held_out = about.hold_out.join(", ");
        writeln!(text, "# Not fitted, only predicted: {held_out}.")
    }

    fn values(&self, text: &mut String) -> std::fmt::Result {
        writeln!(
            text,
            "# Fitted values ({}), with their credible intervals and priors:",
            self.about.point.name()
        )?;
        for it in self.fitted {
            let unit = it
                .unit
                .as_ref()
                .map_or(String::new(), |unit| format!(" {unit}"));
            writeln!(
                text,
                "#   {}: {:.5}{unit} [{:.5}, {:.5}], prior {:.5} to {:.5}, sets {}",
                it.name,
                it.fitted,
                it.low,
                it.high,
                it.prior[0],
                it.prior[1],
                it.sets.join(", ")
            )?;
        }
        let known: Vec<&str> = self.about.known.keys().map(String::as_str).collect();
        match known.is_empty() {
            true => Ok(()),
            false => writeln!(
                text,
                "# Taken as known, not fitted: values of {}.",
                known.join(", ")
            ),
        }
    }

    fn origin(&self, text: &mut String) -> std::fmt::Result {
        let lineage = self.lineage;
        let physics = match self.is_fast {
            true => " in the fast physics (the check of this set is of the full one)",
            false => " in the full physics",
        };
        writeln!(
            text,
            "# Made with {}{physics}, {} episodes and the study's seed {}, from (BLAKE3):",
            self.engine, self.episodes, lineage.seed
        )?;
        for it in std::iter::once(&lineage.calibration).chain(&lineage.files) {
            writeln!(text, "#   {} ({})", it.file, it.hash)?;
        }
        writeln!(text)
    }
}
