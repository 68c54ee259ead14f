//! Whose a record is: whoever may write one may run programs as this user.
//!
//! On Unix by its owner and its mode. Elsewhere files have no owner that could be asked for in the same way; there the folder of the user's own
//! state keeps others out.

use std::path::Path;

/// That a record is a file which nobody but this user could have written.
///
/// # Errors
/// In words: others could have, or it is no file.
#[cfg(unix)]
pub(super) fn is_only_mine(file: &Path) -> Result<(), String> {
    use std::os::unix::fs::MetadataExt;
    let known = std::fs::symlink_metadata(file);
    let known = known.map_err(|error| format!("{}: {error}", file.display()))?;
    let is_mine = known.uid() == rustix::process::geteuid().as_raw();
    match known.is_file() && is_mine && known.mode() & 0o022 == 0 {
        true => Ok(()),
        false => Err(format!(
            "the record {} could have been written by others, so it does not count",
            file.display()
        )),
    }
}

/// That a record is a file.
///
/// # Errors
/// In words: it is no file.
#[cfg(not(unix))]
pub(super) fn is_only_mine(file: &Path) -> Result<(), String> {
    let known = std::fs::symlink_metadata(file);
    match known.is_ok_and(|it| it.is_file()) {
        true => Ok(()),
        false => Err(format!("the record {} is not a file", file.display())),
    }
}
