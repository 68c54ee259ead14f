//! `corroborate trust`: which programs a study would run, and that they may.

use super::{Done, Host};
use crate::args::Trust;
use corroborate::Outcome;
use corroborate::consent::{self, Allowed, NamedProgram};
use diagnostic::Problem;
use std::fmt::Write as _;
use std::path::Path;

/// Shows, allows or takes back.
pub fn trust(arguments: &Trust, setting: &Host) -> Result<Done, Problem> {
    let output = match &arguments.study {
        None => listed(setting)?,
        Some(study) if arguments.revoke => revoked(study, setting)?,
        Some(study) if arguments.show => shown(&consent::look(study)?),
        Some(study) => {
            let allowed = consent::allow(study, arguments.always, setting)?;
            shown(&allowed) + &said(&allowed)
        }
    };
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}

fn shown(allowed: &Allowed) -> String {
    let study = allowed.study.display();
    if allowed.programs.is_empty() {
        return format!("{study} names no programs.\n");
    }
    let mut output = format!("{study} would run:\n");
    for it in &allowed.programs {
        // Writing to a string cannot fail.
        let _ = writeln!(output, "  {}", line(it));
    }
    output
}

/// Where it is named, whose it is, and its words.
fn line(program: &NamedProgram) -> String {
    let place = format!("{}:{}", program.file, program.line);
    let words: Vec<String> = program.words.iter().map(|it| quoted(it)).collect();
    match program.of.as_str() {
        "" => format!("{place}: {}", words.join(" ")),
        of => format!("{place}: {of}: {}", words.join(" ")),
    }
}

/// A word as it is told apart from its neighbours.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,{}+@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("{word:?}"),
    }
}

fn said(allowed: &Allowed) -> String {
    match allowed.files {
        None => "It is allowed, whatever its folder will contain.\n".into(),
        Some(files) => format!(
            "It is allowed with what its folder contains now ({}); what changes is asked anew.\n",
            diagnostic::counted(files as u64, "file")
        ),
    }
}

fn revoked(study: &Path, setting: &Host) -> Result<String, Problem> {
    let study_is = study.display();
    Ok(match consent::revoke(study, setting)? {
        true => format!("{study_is} is no longer allowed to run programs.\n"),
        false => format!("{study_is} was not allowed to run programs.\n"),
    })
}

fn listed(setting: &Host) -> Result<String, Problem> {
    let mut output = String::new();
    for record in consent::allowed(setting)? {
        let how = match record.always {
            true => "whatever it contains",
            false => "with the content that it had",
        };
        let _ = writeln!(output, "{}: {how}", record.study.display());
    }
    for folder in &setting.trust.folders {
        let _ = writeln!(
            output,
            "{}: and all studies below (CORROBORATE_TRUST)",
            folder.display()
        );
    }
    match output.is_empty() {
        true => Ok("No study is allowed to run programs.\n".into()),
        false => Ok(output),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_told_apart() {
        assert_eq!(quoted("{seed}"), "{seed}");
        assert_eq!(quoted("rm -r ~"), "\"rm -r ~\"");
        assert_eq!(quoted(""), "\"\"");
        // What would hide what follows on a terminal is shown as what it is.
        assert_eq!(quoted("a\u{1b}[8m"), "\"a\\u{1b}[8m\"");
    }
}
