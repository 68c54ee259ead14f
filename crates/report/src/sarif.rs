//! Findings with places in files, in the Static Analysis Results Interchange Format (SARIF 2.1.0, OASIS).
//!
//! Viewers of code show them at their lines. A finding has a rule (the kind of mistake), a level, a message and, where it is known, a
//! place; paths are relative to the folder in which the program was called, and percent-encoded.

use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fmt::Write;

/// How grave a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gravity {
    /// It has to be looked at.
    Error,
    /// It should be.
    Warning,
    /// It may be.
    Note,
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spot {
    /// The file's path.
    pub file: String,
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1, if it is known.
    pub column: Option<usize>,
}

/// A finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Alert {
    /// The kind of finding.
    pub rule: String,
    /// How grave it is.
    pub gravity: Gravity,
    /// What is said of it.
    pub message: String,
    /// Where it is.
    pub spot: Option<Spot>,
}

/// The findings of one call of a program of this version as a log in SARIF, with a final newline.
#[must_use]
pub fn sarif(version: &str, alerts: &[Alert]) -> String {
    let rules: BTreeSet<&str> = alerts.iter().map(|it| it.rule.as_str()).collect();
    let rules: Vec<Value> = rules.iter().map(|rule| json!({ "id": rule })).collect();
    let results: Vec<Value> = alerts.iter().map(result).collect();
    let log = json!({
        "$schema": "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": { "name": "corroborate", "version": version, "rules": rules } },
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    });
    format!("{log:#}\n")
}

fn result(alert: &Alert) -> Value {
    let level = match alert.gravity {
        Gravity::Error => "error",
        Gravity::Warning => "warning",
        Gravity::Note => "note",
    };
    let mut result = json!({
        "ruleId": alert.rule,
        "level": level,
        "message": { "text": alert.message },
    });
    if let Some(spot) = &alert.spot {
        let mut region = json!({ "startLine": spot.line.max(1) });
        if let Some(column) = spot.column {
            region["startColumn"] = column.max(1).into();
        }
        result["locations"] = json!([{
            "physicalLocation": {
                "artifactLocation": { "uri": uri(&spot.file) },
                "region": region,
            },
        }]);
    }
    result
}

/// A path as a reference in the form of RFC 3986.
fn uri(path: &str) -> String {
    let path = path.strip_prefix("./").unwrap_or(path);
    let mut uri = match path.starts_with('/') {
        true => String::from("file://"),
        false => String::new(),
    };
    for byte in path.bytes() {
        match byte {
            b'\\' => uri.push('/'),
            b'/' | b'-' | b'.' | b'_' | b'~' | b'0'..=b'9' | b'A'..=b'Z' | b'a'..=b'z' => {
                uri.push(char::from(byte));
            }
            // Writing to a string cannot fail.
            other => drop(write!(uri, "%{other:02X}")),
        }
    }
    uri
}
