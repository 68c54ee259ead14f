//! The one place that prepares a program which a study names, or which the user has typed.

use crate::consent::Consent;
use std::path::Path;
use std::process::Command;

/// A program with its arguments, to be started in a folder. Whoever has no [`Consent`] cannot start it.
///
/// # Errors
/// In words: no program is named.
pub(crate) fn program(
    words: &[String],
    folder: &Path,
    consent: &Consent,
) -> Result<Command, &'static str> {
    let (program, arguments) = words.split_first().ok_or("no program is named")?;
    let mut command = Command::new(program);
    command
        .args(arguments)
        .current_dir(folder)
        .envs(consent.environment().iter().copied());
    Ok(command)
}
