//! `corroborate completions`: a shell's completion script, made of the definitions by which arguments are parsed.

use super::Done;
use crate::args::{Arguments, Completions};
use clap::CommandFactory;
use corroborate::Outcome;
use diagnostic::Problem;

/// The script for a shell.
pub fn completions(arguments: &Completions) -> Result<Done, Problem> {
    let mut bytes = Vec::new();
    let mut command = Arguments::command();
    clap_complete::generate(arguments.shell, &mut command, "corroborate", &mut bytes);
    let output = String::from_utf8(bytes)
        .map_err(|error| Problem::new("not-text", format!("the script: {error}")))?;
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}
