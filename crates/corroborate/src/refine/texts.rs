//! The texts of assets as they are read to be changed, and written back in the encoding and with the line ends that they had.

use diagnostic::{Problem, Source};
use host::files::{read_prism, read_source, write_prism, write_text};
use std::path::Path;
use study::Study;

/// Reads a file of a study: a model as models are read, which may be in Latin-1.
pub(super) fn read(study: &Study, file: &Path) -> Result<Source, Problem> {
    let path = study.folder.join(file);
    match is_model(study, file) {
        true => Ok(read_prism(&path)?.0),
        false => read_source(&path),
    }
}

/// Writes a file of a study in its place.
pub(super) fn write(study: &Study, file: &Path, text: &str) -> Result<(), Problem> {
    let path = study.folder.join(file);
    match is_model(study, file) {
        true => write_prism(&path, text, &path),
        false => write_text(&path, text, &path),
    }
}

fn is_model(study: &Study, file: &Path) -> bool {
    let mut models = study.ledger.iter().filter_map(|entry| entry.work.model());
    models.any(|model| model == file)
}
