//! What is kept of trials beside the report: failing seeds with the command of each, and tables.

use super::journal::Trial;
use super::report::DecideReport;
use super::rule::OnError;
use diagnostic::Problem;
use host::files::write_whole;
use std::fmt::Write;
use std::path::Path;

/// The file of failing seeds, each with the command that runs it again; a shell can read it.
pub const FAILING: &str = "failing-seeds.sh";
/// The table with a row for each trial.
pub const TRIALS: &str = "trials.csv";
/// The table of counts that a study's ledger takes: `tables.requirements` of an experiment.
pub const TABLE: &str = "requirements.csv";

/// Writes all of them.
pub(super) fn write(folder: &Path, report: &DecideReport, trials: &[Trial]) -> Result<(), Problem> {
    write_whole(&folder.join(FAILING), failing(report).as_bytes())?;
    write_whole(&folder.join(TRIALS), rows(trials).as_bytes())?;
    write_whole(&folder.join(TABLE), table(report).as_bytes())
}

/// A command as a shell takes it, with the seed and the number of a trial.
#[must_use]
pub fn written_command(command: &[String], seed: u64, trial: u64) -> String {
    let words = command.iter().map(|word| {
        let word = word
            .replace("{seed}", &seed.to_string())
            .replace("{trial}", &trial.to_string());
        quoted(&word)
    });
    words.collect::<Vec<_>>().join(" ")
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,@%+".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', r"'\''")),
    }
}

fn failing(report: &DecideReport) -> String {
    let mut text = format!(
        "# Trials of {} that failed or broke: {} of {}. Each command runs one of them again.\n",
        one_line(&report.requirement),
        report.failing.len(),
        report.counts.trials()
    );
    for it in &report.failing {
        let (outcome, why) = (it.outcome.name(), one_line(&it.why));
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "# trial {}, seed {}: {outcome}, {why}",
            it.trial, it.seed
        );
        if let Some(command) = &it.command {
            let _ = writeln!(text, "{command}");
        }
    }
    text
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn rows(trials: &[Trial]) -> String {
    let mut text = String::from("trial,seed,outcome\n");
    for it in trials {
        let _ = writeln!(text, "{},{},{}", it.trial, it.seed, it.outcome.name());
    }
    text
}

/// Trials whose harness broke are undecided where they do not count as failures.
fn table(report: &DecideReport) -> String {
    let counts = report.counts;
    let (failed, undecided) = match report.on_error {
        OnError::Unknown => (counts.failed, counts.errors),
        OnError::Failure => (counts.failed + counts.errors, 0),
    };
    format!(
        "# Stopped by a sequential test: at least {} at {}, margin {}.\n\
         requirement,covered,passed,failed,undecided,stopped\n{},{},{},{failed},{undecided},yes\n",
        report.at_least,
        report.confidence,
        report.margin,
        field(&report.requirement),
        counts.passed + failed,
        counts.passed
    )
}

/// A field of a table in CSV.
fn field(text: &str) -> String {
    match text.contains([',', '"', '\n', '\r']) {
        true => format!("\"{}\"", text.replace('"', "\"\"")),
        false => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_written_as_a_shell_reads_them() {
        let words = ["sh", "-c", "echo \"$1\" it's {seed}", "a b", "", "{trial}"];
        let words = words.map(String::from);
        let said = std::process::Command::new("sh")
            .args([
                "-c",
                &format!("printf '%s|' {}", written_command(&words, 7, 2)),
            ])
            .output()
            .expect("a shell");
        let said = String::from_utf8(said.stdout).expect("text");
        assert_eq!(said, "sh|-c|echo \"$1\" it's 7|a b||2|");
    }
}
