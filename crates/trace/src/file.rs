//! Files: whole ones are read, and written so that they appear complete or not at all.

use std::fmt;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// A file could not be read or written.
#[derive(Debug)]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// Whether it was to be written.
    pub writing: bool,
    /// What the operating system says.
    pub source: io::Error,
}

impl fmt::Display for FileError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let action = if self.writing { "write" } else { "read" };
        let remedy = match self.source.kind() {
            io::ErrorKind::NotFound if self.writing => "create the folder first",
            io::ErrorKind::NotFound => "check the path",
            io::ErrorKind::PermissionDenied => "check its permissions and those of its folder",
            io::ErrorKind::StorageFull => "free some space and try again",
            io::ErrorKind::ReadOnlyFilesystem => "choose a place that can be written to",
            io::ErrorKind::IsADirectory => "give the path of a file, not of a folder",
            io::ErrorKind::InvalidData => "save it as UTF-8 text",
            _ => "check that the place can be used and try again",
        };
        let path = self.path.display();
        write!(out, "cannot {action} {path}: {}; {remedy}", self.source)
    }
}

impl std::error::Error for FileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&self.source)
    }
}

/// What `read` gives of a file. A pipe, a socket or a device is refused: opening it may wait for a writer for ever, and reading it
/// need not end.
fn of_file<T>(path: &Path, read: fn(&Path) -> io::Result<T>) -> io::Result<T> {
    let metadata = fs::metadata(path)?;
    match metadata.is_file() || metadata.is_dir() {
        true => read(path),
        false => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "it is a pipe, a socket or a device, not a file",
        )),
    }
}

/// Reads the whole file at `path`.
///
/// # Errors
/// [`FileError`] if the operating system refuses.
pub fn read_file(path: &Path) -> Result<Vec<u8>, FileError> {
    of_file(path, |path| fs::read(path)).map_err(|source| FileError {
        path: path.to_owned(),
        writing: false,
        source,
    })
}

/// Reads the whole file at `path` as UTF-8 text.
///
/// # Errors
/// [`FileError`] if the operating system refuses or the file is no UTF-8 text.
pub fn read_text(path: &Path) -> Result<String, FileError> {
    of_file(path, |path| fs::read_to_string(path)).map_err(|source| FileError {
        path: path.to_owned(),
        writing: false,
        source,
    })
}

/// Writes `content` to the file at `path`, replacing what was there. It is written to a temporary
/// file in the same folder first, which then takes the name `path`: at any moment there is the
/// whole old content or the whole new one, and after an error the old one.
///
/// # Errors
/// [`FileError`] if the operating system refuses, for example because the disk is full.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), FileError> {
    let error = |source| FileError {
        path: path.to_owned(),
        writing: true,
        source,
    };
    if path.is_dir() {
        return Err(error(io::Error::from(io::ErrorKind::IsADirectory)));
    }
    let (temporary, file) = create_beside(path).map_err(error)?;
    let written = fill(file, content).and_then(|()| fs::rename(&temporary, path));
    if written.is_err() {
        // Nothing more can be done if this fails too; the error above is the one to report.
        let _ = fs::remove_file(&temporary);
    }
    written.map_err(error)
}

/// Creates the folder at `path` with those above it; one that exists stays as it is.
///
/// # Errors
/// [`FileError`] if the operating system refuses, for example because a file has that name.
pub fn create_folder(path: &Path) -> Result<(), FileError> {
    fs::create_dir_all(path).map_err(|source| FileError {
        path: path.to_owned(),
        writing: true,
        source,
    })
}

fn fill(mut file: File, content: &[u8]) -> io::Result<()> {
    file.write_all(content)?;
    // Some file systems report a full disk only here.
    file.sync_data()
}

/// Creates a new file in the folder of `path`, with a name that no other writer uses.
fn create_beside(path: &Path) -> io::Result<(PathBuf, File)> {
    let Some(name) = path.file_name() else {
        return Err(io::Error::from(io::ErrorKind::InvalidInput));
    };
    let mut attempt = 0_u32;
    loop {
        let mut temporary = std::ffi::OsString::from(".");
        temporary.push(name);
        temporary.push(format!(".{attempt}.tmp"));
        let temporary = path.with_file_name(temporary);
        match OpenOptions::new()
            .write(true)
            .create_new(true)
            .open(&temporary)
        {
            Ok(file) => return Ok((temporary, file)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && attempt < 10_000 => {
                attempt += 1;
            }
            Err(error) => return Err(error),
        }
    }
}
