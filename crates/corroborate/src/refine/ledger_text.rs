//! New entries of a ledger, as text that is put behind the old ones.

use evidence::{Calibration, Subject};
use std::fmt::Write;
use std::path::Path;
use study::{Entry, Study};

/// Names for what is new.
pub struct Names;

impl Names {
    /// The entry's identifier without the number of an earlier refinement.
    fn stem(id: &str) -> &str {
        match id.rsplit_once("-r") {
            Some((stem, number))
                if !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit()) =>
            {
                stem
            }
            _ => id,
        }
    }

    fn number(id: &str) -> u64 {
        let stem = Self::stem(id);
        id.get(stem.len() + 2..)
            .and_then(|number| number.parse().ok())
            .unwrap_or(0)
    }

    /// The first free identifier of a refinement of an entry.
    pub fn next_id(study: &Study, id: &str, taken: &[String]) -> String {
        let stem = Self::stem(id);
        let is_taken = |id: &String| study.ledger.iter().any(|e| &e.id == id) || taken.contains(id);
        let mut number = Self::number(id) + 1;
        loop {
            let next = format!("{stem}-r{number}");
            if !is_taken(&next) {
                return next;
            }
            number += 1;
        }
    }

    /// The file of the next refinement of a model, as far as its name tells.
    pub fn next_model(path: &Path) -> String {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        Self::beside(path, &stem, Self::number(&stem) + 1)
    }

    /// The first file beside a model that is not there yet.
    pub fn free_model(folder: &Path, path: &Path, taken: &[String]) -> String {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let mut number = Self::number(&stem) + 1;
        loop {
            let next = Self::beside(path, &stem, number);
            if !folder.join(&next).exists() && !taken.contains(&next) {
                return next;
            }
            number += 1;
        }
    }

    fn beside(path: &Path, stem: &str, number: u64) -> String {
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let name = format!("{}-r{number}.{extension}", Self::stem(stem));
        let path = path.with_file_name(name);
        path.to_string_lossy().replace('\\', "/")
    }
}

/// A number that an entry's asset was set to.
#[derive(Clone, Debug, PartialEq)]
pub struct SetTo {
    /// `constant` of a model or `parameter` of a simulation.
    pub key: &'static str,
    /// Its name.
    pub name: String,
    /// Whose counts.
    pub from: String,
    /// Of what.
    pub subject: Subject,
    /// Whether the constant keeps its value.
    pub held: bool,
    /// Whether the constant is 1 minus the counted rate.
    pub is_complement: bool,
}

impl SetTo {
    /// What an entry was set to already.
    pub fn of(entry: &Entry) -> Vec<Self> {
        let all = entry.calibrated.iter().map(|it| Self {
            key: match it.constant {
                Some(_) => "constant",
                None => "parameter",
            },
            name: it.calibration.parameter.clone(),
            from: it.calibration.from.clone(),
            subject: it.calibration.subject.clone(),
            held: it.held,
            is_complement: it.is_complement,
        });
        all.collect()
    }
}

/// A new entry.
#[derive(Clone, Debug)]
pub struct NewEntry {
    /// Its identifier.
    pub id: String,
    /// Its title.
    pub title: String,
    /// Its technique, as the ledger writes it.
    pub technique: &'static str,
    /// A key of the study's conditions.
    pub conditions: String,
    /// Files and numbers, as TOML lines.
    pub assets: Vec<(&'static str, toml::Value)>,
    /// A step on the way.
    pub intermediate: bool,
    /// What was changed.
    pub changed: String,
    /// What was set to whose counts.
    pub set_to: Vec<SetTo>,
    /// For what evidence its texts were chosen.
    pub chosen: Vec<Calibration>,
}

impl NewEntry {
    /// As TOML, with an empty line before it.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "\n[[evidence]]")?;
        writeln!(text, "id = {}", quoted(&self.id))?;
        writeln!(text, "title = {}", quoted(&self.title))?;
        writeln!(text, "technique = {}", quoted(self.technique))?;
        writeln!(text, "conditions = {}", quoted(&self.conditions))?;
        for (key, value) in &self.assets {
            writeln!(text, "{key} = {value}")?;
        }
        if self.intermediate {
            writeln!(text, "intermediate = true")?;
        }
        writeln!(text, "changed = {}", quoted(&self.changed))?;
        if !self.set_to.is_empty() {
            writeln!(text, "{}", calibrated(&self.set_to))?;
        }
        if !self.chosen.is_empty() {
            writeln!(text, "{}", chosen(&self.chosen))?;
        }
        Ok(())
    }
}

/// The lineage of an entry, as TOML without a line break at its end.
pub fn calibrated(set_to: &[SetTo]) -> String {
    let lines = set_to.iter().map(|it| {
        let kind = kind(&it.subject);
        let held = if it.held { ", held = true" } else { "" };
        let complement = if it.is_complement {
            ", complement = true"
        } else {
            ""
        };
        format!(
            "    {{ {} = {}{held}{complement}, from = {}, {kind} = {} }},\n",
            it.key,
            quoted(&it.name),
            quoted(&it.from),
            quoted(it.subject.id())
        )
    });
    format!("calibrated = [\n{}]", lines.collect::<String>())
}

/// For what evidence an entry's texts were chosen, as TOML without a line break at its end.
pub fn chosen(all: &[Calibration]) -> String {
    let lines = all.iter().map(|it| {
        format!(
            "    {{ what = {}, from = {}, {} = {} }},\n",
            quoted(&it.parameter),
            quoted(&it.from),
            kind(&it.subject),
            quoted(it.subject.id())
        )
    });
    format!("chosen = [\n{}]", lines.collect::<String>())
}

fn kind(subject: &Subject) -> &'static str {
    match subject {
        Subject::Requirement(_) => "requirement",
        Subject::FailureMode(_) => "failure_mode",
    }
}

/// A string as TOML writes it.
pub fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
