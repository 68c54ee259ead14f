//! What systems do each in their own way with files.
//!
//! | | Unix | Windows |
//! |---|---|---|
//! | a link | to a file or a folder alike | of either kind, with the right to make links ("developer mode") |
//! | a file for its owner alone | mode 600 | as the folder has it |
//! | a folder for its owner alone | mode 700 | as the folder around it has it |
//! | what may be executed | by its mode | by its name, which no table or recording has |
//! | whether a name still is that of an open file | by device and number | always, as an open file keeps its name |

use std::fs::{File, OpenOptions};
use std::io::Result;
use std::path::Path;

/// Makes `path` a symbolic link to a file or a folder.
///
/// # Errors
/// As the system says.
#[cfg(unix)]
pub fn link(source: &Path, path: &Path) -> Result<()> {
    std::os::unix::fs::symlink(source, path)
}

/// Makes `path` a symbolic link to a file or a folder.
///
/// # Errors
/// As the system says.
#[cfg(windows)]
pub fn link(source: &Path, path: &Path) -> Result<()> {
    match source.is_dir() {
        true => std::os::windows::fs::symlink_dir(source, path),
        false => std::os::windows::fs::symlink_file(source, path),
    }
}

/// A file that is made new is for its owner alone or, if it `is_secret` not, to be read by all; elsewhere than on Unix as its folder
/// has it.
pub fn set_owner(options: &mut OpenOptions, is_secret: bool) {
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(options, if is_secret { 0o600 } else { 0o644 });
    #[cfg(not(unix))]
    let _ = (options, is_secret);
}

/// Makes an open file one that only its owner may read and write; elsewhere than on Unix it stays as its folder has it.
pub(crate) fn keep_private(file: &File) -> Result<()> {
    #[cfg(unix)]
    return file.set_permissions(std::os::unix::fs::PermissionsExt::from_mode(0o600));
    #[cfg(not(unix))]
    {
        let _ = file;
        Ok(())
    }
}

/// Makes a folder that only its owner may enter, with those above it; one that is there stays as it is.
pub(crate) fn make_private_folder(path: &Path) -> Result<()> {
    let mut made = std::fs::DirBuilder::new();
    made.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut made, 0o700);
    made.create(path)
}

/// Whether a file may be executed as a program, whatever it is called.
#[must_use]
pub fn may_be_executed(path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::metadata(path).is_ok_and(|it| it.permissions().mode() & 0o111 != 0)
    }
    #[cfg(not(unix))]
    {
        let _ = path;
        false
    }
}

/// Whether the path still names this file.
#[cfg(unix)]
pub(crate) fn is_named(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(own), Ok(named)) => (own.dev(), own.ino()) == (named.dev(), named.ino()),
        _ => false,
    }
}

/// Nothing removes it here.
#[cfg(not(unix))]
pub(crate) fn is_named(_: &File, _: &Path) -> bool {
    true
}
