//! What a verification found.

use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;

/// Something that does not hold.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Fault {
    /// The file.
    pub file: String,
    /// Where in it: a JSON pointer, or a line and column; empty for the whole file.
    pub place: String,
    /// What is wrong.
    pub fault: String,
}

/// Something that holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Checked {
    /// How many.
    pub count: u64,
    /// Of what.
    pub what: String,
}

/// What `verify --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct VerifyReport {
    /// Version of this form.
    pub format: String,
    /// The folder of results.
    pub results: String,
    /// The study's folder.
    pub study: String,
    /// What does not hold.
    pub faults: Vec<Fault>,
    /// What holds.
    pub checked: Vec<Checked>,
    /// What was not derived again, and why.
    pub not_checked: Vec<String>,
}

/// Collects what is found.
#[derive(Debug, Default)]
pub struct Audit {
    faults: Vec<Fault>,
    checked: Vec<Checked>,
    not_checked: Vec<String>,
}

impl Audit {
    /// Something does not hold.
    pub fn fault(&mut self, file: &Path, place: &str, fault: impl Into<String>) {
        let fault = Fault {
            file: file.display().to_string(),
            place: place.to_owned(),
            fault: fault.into(),
        };
        if !self.faults.contains(&fault) {
            self.faults.push(fault);
        }
    }

    /// So many hold.
    pub fn checked(&mut self, count: u64, what: &str) {
        let known = self.checked.iter_mut().find(|checked| checked.what == what);
        match known {
            Some(known) => known.count += count,
            None => self.checked.push(Checked {
                count,
                what: what.to_owned(),
            }),
        }
    }

    /// Something was not derived again.
    pub fn not_checked(&mut self, what: &str) {
        self.not_checked.push(what.to_owned());
    }
}

impl VerifyReport {
    /// The report of an audit.
    pub(crate) fn new(results: &Path, study: &Path, audit: Audit) -> Self {
        Self {
            format: "1.0".into(),
            results: results.display().to_string(),
            study: study.display().to_string(),
            faults: audit.faults,
            checked: audit.checked,
            not_checked: audit.not_checked,
        }
    }
}
