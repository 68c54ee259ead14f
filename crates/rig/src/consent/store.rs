//! Records as files that only their user may read and write.

use super::records::Record;
use diagnostic::Problem;
use host::store::hash_of;
use std::path::{Path, PathBuf};

/// More than a record has: a hundred bytes for each file.
const MOST_BYTES: u64 = 64 << 20;

/// The file of a study's record.
pub(super) fn file_of(records: &Path, study: &Path) -> PathBuf {
    let name = hash_of(study.as_os_str().as_encoded_bytes());
    records.join(format!("{}.json", &name[..32]))
}

/// A record, if there is one.
///
/// # Errors
/// Why it does not count, in words.
pub(super) fn read(file: &Path) -> Result<Option<Record>, String> {
    if !file.exists() {
        return Ok(None);
    }
    super::owner::is_only_mine(file)?;
    let bytes = host::files::read_file(file, MOST_BYTES).map_err(|problem| problem.line())?;
    let record = serde_json::from_slice(&bytes);
    let cannot = |error: serde_json::Error| format!("{} is damaged: {error}", file.display());
    record.map(Some).map_err(cannot)
}

/// Writes a record whole, for its user alone.
pub(super) fn write(file: &Path, record: &Record) -> Result<(), Problem> {
    let bytes = serde_json::to_vec_pretty(record).unwrap_or_default();
    host::files::write_private(file, &bytes)
}

/// All records that can be read, by their studies.
pub(super) fn all(records: &Path) -> Vec<Record> {
    let entries = std::fs::read_dir(records).into_iter().flatten().flatten();
    let found = entries.filter_map(|entry| read(&entry.path()).ok().flatten());
    let mut found: Vec<Record> = found.collect();
    found.sort_by(|a, b| a.study.cmp(&b.study));
    found
}

/// Removes a record; whether there was one.
pub(super) fn remove(file: &Path) -> Result<bool, Problem> {
    match std::fs::remove_file(file) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(Problem::cannot_write(file, &error)),
    }
}
