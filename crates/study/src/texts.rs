//! Where the texts of a study's own files come from: the folder, or an editor that has not saved them yet.

use diagnostic::{Problem, Source};
use std::path::Path;

/// Gives the texts of a study's own files.
pub trait Texts {
    /// Whether there is such a file.
    fn exists(&self, path: &Path) -> bool;

    /// Its text.
    ///
    /// # Errors
    /// `cannot-read`, `file-too-large`, `not-text`.
    fn text(&self, path: &Path) -> Result<Source, Problem>;
}

/// The texts as they are kept.
#[derive(Clone, Copy, Debug, Default)]
pub struct Saved;

impl Texts for Saved {
    fn exists(&self, path: &Path) -> bool {
        path.exists()
    }

    fn text(&self, path: &Path) -> Result<Source, Problem> {
        host::files::read_source(path)
    }
}
