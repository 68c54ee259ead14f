//! The commands by what they are for, as `--help` lists them.

use super::Arguments;
use clap::{Command, CommandFactory, FromArgMatches};
use std::ffi::OsString;
use std::fmt::Write;

/// What commands are for, and which: each once, those that are needed first at the top.
const GROUPS: [(&str, &[&str]); 7] = [
    (
        "A study",
        &[
            "init",
            "run",
            "plan",
            "report",
            "compare",
            "diff",
            "requirements",
            "merge",
        ],
    ),
    (
        "Why evidence disagrees, and what mends it",
        &["diagnose", "refine", "what-if"],
    ),
    (
        "Simulation",
        &[
            "simulate",
            "explore",
            "shrink",
            "replay",
            "engines",
            "rare",
            "calibrate",
        ],
    ),
    (
        "Recordings, running systems and flaky tests",
        &["inspect", "monitor", "watch", "decide"],
    ),
    ("Models in the PRISM language", &["check", "format"]),
    ("For assessors", &["assure", "pack", "verify"]),
    (
        "Help and set-up",
        &[
            "explain",
            "schema",
            "trust",
            "doctor",
            "completions",
            "man",
            "language-server",
            "help",
        ],
    ),
];

/// Columns of the listing.
const WIDTH: usize = 100;

/// Columns before what a command does.
const INDENT: usize = 19;

/// The arguments, or why they are none; or the help that they ask for.
pub fn parsed(arguments: impl IntoIterator<Item = OsString>) -> Result<Arguments, clap::Error> {
    let matches = command().try_get_matches_from(arguments)?;
    Arguments::from_arg_matches(&matches)
}

/// The command line, whose help has its commands in groups.
fn command() -> Command {
    let command = Arguments::command();
    let mut listing = String::new();
    for (purpose, names) in GROUPS {
        _ = writeln!(listing, "\n{purpose}:");
        for name in names {
            let does = match command.find_subcommand(name).and_then(Command::get_about) {
                Some(about) => about.to_string(),
                None => "Print this message, or the help of a command".to_owned(),
            };
            _ = write!(listing, "  {name:<width$}", width = INDENT - 2);
            listing.push_str(&wrapped(&does));
        }
    }
    // Braces would be read as what the template fills in.
    debug_assert!(!listing.contains(['{', '}']));
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n{listing}\nOptions:\n{{options}}{{after-help}}"
    ))
}

/// A text in lines behind the indentation.
fn wrapped(text: &str) -> String {
    let mut lines = String::new();
    let mut column = INDENT;
    for word in text.split_whitespace() {
        let length = word.chars().count() + 1;
        if column > INDENT && column + length > WIDTH {
            _ = write!(lines, "\n{:INDENT$}", "");
            column = INDENT;
        } else if column > INDENT {
            lines.push(' ');
        }
        lines.push_str(word);
        column += length;
    }
    lines.push('\n');
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_command_is_in_one_group_and_in_the_help() {
        let mut listed: Vec<&str> = GROUPS
            .iter()
            .flat_map(|(_, names)| *names)
            .copied()
            .collect();
        listed.sort_unstable();
        let known = Arguments::command();
        let mut known: Vec<&str> = known.get_subcommands().map(Command::get_name).collect();
        known.push("help");
        known.sort_unstable();
        assert_eq!(listed, known);
        let help = command().render_help().to_string();
        for line in help.lines() {
            assert!(line.chars().count() <= WIDTH, "{line}");
        }
        for name in listed {
            assert!(help.contains(&format!("\n  {name} ")), "{name} in {help}");
        }
    }
}
