//! A folder of recordings as a set of trials.

use std::cmp::Ordering;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::open::{Format, detect};
use crate::reader::ReadError;

/// Folders in folders are looked into this deep.
const MAX_FOLDER_DEPTH: usize = 8;

/// One trial: a file, or a folder that rosbag2 recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TrialPath {
    /// Where it is.
    pub path: PathBuf,
    /// Its path within the folder, with `/` on every system; unique among the trials.
    pub name: String,
    /// The format that it is in, by its first bytes or its name.
    pub format: Format,
}

/// A file that is no recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SkippedPath {
    /// Where it is.
    pub path: PathBuf,
    /// Why it is no trial.
    pub reason: String,
}

/// The trials in a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Trials {
    /// In natural order: `run2` comes before `run10`.
    pub trials: Vec<TrialPath>,
    /// Files that are no recordings, in the same order. Hidden files and the files that SQLite keeps
    /// beside a database are not mentioned.
    pub skipped: Vec<SkippedPath>,
}

/// Lists the recordings at `path`: those in a folder and in the folders below it, or the one that
/// `path` itself is. A folder that rosbag2 recorded is one trial. Nothing is read but the first bytes.
///
/// ```
/// let folder = tempfile::tempdir()?;
/// for name in ["run10.csv", "run2.csv", "notes.txt"] {
///     std::fs::write(folder.path().join(name), "time_secs,speed\n")?;
/// }
/// let found = recording::trials(folder.path())?;
/// assert_eq!(found.trials[0].name, "run2.csv");
/// assert_eq!(found.trials[1].name, "run10.csv");
/// assert!(found.skipped[0].path.ends_with("notes.txt"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ReadError`] if a folder cannot be read, or `path` is a file that is no recording.
pub fn trials(path: &Path) -> Result<Trials, ReadError> {
    let of_path = |error: io::Error| ReadError::from(error).in_file(path);
    let is_folder = fs::metadata(path).map_err(of_path)?.is_dir();
    let mut found = Trials::default();
    if is_folder && !crate::rosbag2::is_recording(path).map_err(of_path)? {
        add_folder(path, "", 0, &mut found)?;
    } else {
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        let format = detect(path)?;
        found.trials.push(TrialPath {
            path: path.to_owned(),
            name,
            format,
        });
    }
    Ok(found)
}

fn add_folder(
    folder: &Path,
    prefix: &str,
    depth: usize,
    found: &mut Trials,
) -> Result<(), ReadError> {
    let of_folder = |error: io::Error| ReadError::from(error).in_file(folder);
    let mut entries = Vec::new();
    for entry in fs::read_dir(folder).map_err(of_folder)? {
        let entry = entry.map_err(of_folder)?;
        entries.push((
            entry.file_name().to_string_lossy().into_owned(),
            entry.path(),
        ));
    }
    entries.sort_by(|(a, _), (b, _)| natural_order(a, b));
    for (name, path) in entries {
        if name.starts_with('.') || is_companion(&name) {
            continue;
        }
        let name = format!("{prefix}{name}");
        let is_folder = path.is_dir();
        let is_bag = is_folder && crate::rosbag2::is_recording(&path).map_err(of_folder)?;
        if is_folder && !is_bag {
            let below = format!("{name}/");
            match depth < MAX_FOLDER_DEPTH {
                true => add_folder(&path, &below, depth + 1, found)?,
                false => found.skipped.push(SkippedPath {
                    path,
                    reason: format!("it is more than {MAX_FOLDER_DEPTH} folders deep"),
                }),
            }
            continue;
        }
        match detect(&path) {
            Ok(format) => found.trials.push(TrialPath { path, name, format }),
            Err(error) => {
                let reason = error.problem.to_string();
                found.skipped.push(SkippedPath { path, reason });
            }
        }
    }
    Ok(())
}

/// Whether SQLite keeps the file beside a database.
fn is_companion(name: &str) -> bool {
    ["-wal", "-shm", "-journal"]
        .iter()
        .any(|suffix| name.ends_with(suffix))
}

/// Compares names so that numbers in them count as numbers.
pub(crate) fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut left, mut right) = (a, b);
    while let (Some(x), Some(y)) = (left.chars().next(), right.chars().next()) {
        let order = if x.is_ascii_digit() && y.is_ascii_digit() {
            let (x, y) = (take_digits(&mut left), take_digits(&mut right));
            x.len().cmp(&y.len()).then_with(|| x.cmp(y))
        } else {
            left = &left[x.len_utf8()..];
            right = &right[y.len_utf8()..];
            x.cmp(&y)
        };
        if order != Ordering::Equal {
            return order;
        }
    }
    // Names that differ in leading zeros alone are still different.
    left.len().cmp(&right.len()).then_with(|| a.cmp(b))
}

/// Takes a number from the front of `text`, without leading zeros.
fn take_digits<'a>(text: &mut &'a str) -> &'a str {
    let end = text
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(text.len());
    let (digits, rest) = text.split_at(end);
    *text = rest;
    digits.trim_start_matches('0')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count_as_numbers() {
        let mut names = [
            "run10", "run2", "run", "run02", "a10b2", "a10b10", "run2a", "10", "9",
        ];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(
            names,
            [
                "9", "10", "a10b2", "a10b10", "run", "run02", "run2", "run2a", "run10"
            ]
        );
    }

    #[test]
    fn bag_folders_are_one_trial_and_other_folders_are_looked_into() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, content: &str| {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, content).unwrap();
        };
        write("trial10/metadata.yaml", "rosbag2_bagfile_information:\n");
        write("trial10/trial10_0.db3", "SQLite format 3\0");
        write("trial9/run.jsonl", "{}");
        write("trial9/killed/killed_0.mcap", "\u{89}");
        write("trial9/.hidden", "x");
        write("x.db3-wal", "x");
        write("photo.png", "x");
        let found = trials(folder.path()).unwrap();
        let names: Vec<_> = found
            .trials
            .iter()
            .map(|trial| (trial.name.as_str(), trial.format))
            .collect();
        assert_eq!(
            names,
            [
                ("trial9/killed", Format::Rosbag2Folder),
                ("trial9/run.jsonl", Format::JsonLines),
                ("trial10", Format::Rosbag2Folder),
            ]
        );
        assert_eq!(found.skipped.len(), 1);
        assert!(found.skipped[0].path.ends_with("photo.png"));
        let single = trials(&folder.path().join("trial9/run.jsonl")).unwrap();
        assert_eq!(
            (single.trials.len(), single.trials[0].name.as_str()),
            (1, "run.jsonl")
        );
        assert!(trials(&folder.path().join("photo.png")).is_err());
        assert!(trials(&folder.path().join("absent")).is_err());
    }
}
