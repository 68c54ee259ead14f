//! The files of a new study, written all or not at all.

use diagnostic::Problem;
use host::files::write_whole;
use std::path::{Path, PathBuf};

/// What to do about a file that cannot be written.
const REMEDY: &str = "name a folder that can be written, on a disk with space";

/// What a new file holds.
#[derive(Clone, Debug)]
pub enum Content {
    /// These bytes.
    Bytes(Vec<u8>),
    /// What this file or folder holds: copied.
    CopyOf(PathBuf),
    /// A symbolic link to this file or folder.
    LinkTo(PathBuf),
}

/// A file of a new study.
#[derive(Clone, Debug)]
pub struct NewFile {
    /// Its place in the study's folder.
    pub path: PathBuf,
    /// What it holds.
    pub content: Content,
}

impl NewFile {
    /// A file with a text.
    pub fn text(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            content: Content::Bytes(text.into().into_bytes()),
        }
    }
}

/// Whether there is room for a study: nothing, or an empty folder.
pub(super) fn refuse_occupied(folder: &Path) -> Result<(), Problem> {
    let holds_something = std::fs::read_dir(folder).is_ok_and(|mut found| found.next().is_some());
    let is_something_else = folder.symlink_metadata().is_ok() && !folder.is_dir();
    if holds_something || is_something_else {
        let message = format!("{} already has content", folder.display());
        return Err(Problem::new("folder-not-empty", message)
            .remedy("name a folder that does not exist yet"));
    }
    Ok(())
}

/// Writes the files; if one cannot be written, removes those that were.
pub(super) fn write(folder: &Path, files: &[NewFile]) -> Result<(), Problem> {
    let was_there = folder.is_dir();
    let written = files
        .iter()
        .try_for_each(|file| write_one(&folder.join(&file.path), &file.content));
    if written.is_err() {
        remove(folder, was_there);
    }
    written
}

fn write_one(path: &Path, content: &Content) -> Result<(), Problem> {
    match content {
        Content::Bytes(bytes) => write_whole(path, bytes).map_err(|problem| problem.remedy(REMEDY)),
        Content::CopyOf(source) => copied(source, path).map_err(|error| cannot(path, &error)),
        Content::LinkTo(source) => linked(source, path).map_err(|error| cannot(path, &error)),
    }
}

fn cannot(path: &Path, error: &std::io::Error) -> Problem {
    let message = format!("{} cannot be written: {error}", path.display());
    Problem::new("cannot-write", message).remedy(REMEDY)
}

/// Copies a file, or a folder with all that is in it.
fn copied(source: &Path, path: &Path) -> std::io::Result<()> {
    if !source.is_dir() {
        make_parent(path)?;
        return std::fs::copy(source, path).map(|_| ());
    }
    std::fs::create_dir_all(path)?;
    for entry in std::fs::read_dir(source)? {
        let entry = entry?;
        copied(&entry.path(), &path.join(entry.file_name()))?;
    }
    Ok(())
}

fn linked(source: &Path, path: &Path) -> std::io::Result<()> {
    make_parent(path)?;
    host::system::link(source, path)
}

fn make_parent(path: &Path) -> std::io::Result<()> {
    path.parent().map_or(Ok(()), std::fs::create_dir_all)
}

/// As it was before: the folder gone, or empty. What cannot be removed stays, since the reason is told already.
fn remove(folder: &Path, was_there: bool) {
    if !was_there {
        let _ = std::fs::remove_dir_all(folder);
        return;
    }
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        let _ = match is_folder {
            true => std::fs::remove_dir_all(path),
            false => std::fs::remove_file(path),
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_written_whole_leaves_nothing() {
        let place = tempfile::tempdir().expect("a folder");
        let files = [
            NewFile::text("study.toml", "title"),
            NewFile {
                path: "recordings/run.csv".into(),
                content: Content::CopyOf(place.path().join("nowhere.csv")),
            },
        ];
        let new = place.path().join("new");
        let problem = write(&new, &files).expect_err("no such file");
        assert_eq!(problem.code, "cannot-write");
        assert!(!new.exists());
        std::fs::create_dir(&new).expect("made");
        write(&new, &files).expect_err("no such file");
        assert_eq!(std::fs::read_dir(&new).expect("there").count(), 0);
    }
}
