//! `corroborate format`: models and property files, laid out anew.

use super::Done;
use crate::args::FormatFiles;
use crate::terminal::read_standard_input;
use crate::terminal::to_stderr;
use corroborate::Outcome;
use diagnostic::{Problem, Source};
use host::files::write_whole;
use std::path::{Path, PathBuf};

/// How names of property files end.
const PROPERTY_FILES: [&str; 5] = ["props", "prop", "pctl", "csl", "ltl"];

/// A file, and how it should look.
struct Formatted<'a> {
    path: &'a Path,
    text: String,
    is_changed: bool,
}

/// Formats files, or names those that should be. Nothing is written if one of them has mistakes.
pub fn format(arguments: &FormatFiles) -> Result<Done, Problem> {
    let (mut formatted, mut problems) = (Vec::new(), Vec::new());
    for path in &arguments.files {
        match one(path, arguments.properties) {
            Ok(file) => formatted.push(file),
            Err(problem) => problems.push(problem),
        }
    }
    if let Some(problem) = Problem::all(problems) {
        return Err(problem);
    }
    let mut output = String::new();
    let mut outcome = Outcome::Holds;
    for file in &formatted {
        if arguments.check {
            if file.is_changed {
                outcome = Outcome::Violated;
                output += &format!("{}: would be laid out otherwise\n", file.path.display());
            }
        } else if is_standard_input(file.path) {
            output += &file.text;
        } else if file.is_changed {
            write(file.path, &file.text)?;
            output += &format!("{}: formatted\n", file.path.display());
        }
    }
    Ok(Done { output, outcome })
}

fn is_standard_input(path: &Path) -> bool {
    path == Path::new("-")
}

fn one(path: &Path, properties: bool) -> Result<Formatted<'_>, Problem> {
    let (source, is_utf8) = read(path)?;
    let ending = path.extension().and_then(|ending| ending.to_str());
    let is_of_properties = properties || ending.is_some_and(|e| PROPERTY_FILES.contains(&e));
    let formatted = if is_of_properties {
        prism_lang::format_properties(&source.text)
    } else {
        prism_lang::format_model(&source.text)
    };
    let text = formatted.map_err(|mistakes| {
        study::placed::from_diagnostics(&source, &mistakes)
            .unwrap_or_else(|| Problem::new("syntax", format!("{} has mistakes", source.name)))
    })?;
    Ok(Formatted {
        path,
        is_changed: text != source.text || !is_utf8,
        text,
    })
}

/// The text, and whether it is in UTF-8, as what is written always is.
fn read(path: &Path) -> Result<(Source, bool), Problem> {
    if is_standard_input(path) {
        return Ok((read_standard_input()?, true));
    }
    let (source, warning) = host::files::read_prism(path)?;
    if let Some(warning) = &warning {
        to_stderr(&diagnostic::printable(&warning.warning_line()));
    }
    Ok((source, warning.is_none()))
}

/// Writes the file behind a link, with its permissions.
fn write(path: &Path, text: &str) -> Result<(), Problem> {
    let fail = |error: std::io::Error| Problem::cannot_write(path, &error);
    let target: PathBuf = path.canonicalize().map_err(fail)?;
    let permissions = std::fs::metadata(&target).map_err(fail)?.permissions();
    if permissions.readonly() {
        return Err(fail(std::io::ErrorKind::PermissionDenied.into()));
    }
    write_whole(&target, text.as_bytes())?;
    std::fs::set_permissions(&target, permissions).map_err(fail)
}
