//! Where the texts of a study's own files come from: the folder, or an editor that has not saved them yet.

use diagnostic::{Problem, Source};
use host::Reach;
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

    /// Its text, where every study has such a file.
    ///
    /// # Errors
    /// `cannot-read` where it is not there, and those of [`Self::text`].
    fn needed(&self, path: &Path) -> Result<Source, Problem> {
        if self.exists(path) {
            return self.text(path);
        }
        let message = format!("{} is not there, and every study has one", path.display());
        Err(Problem::new("cannot-read", message)
            .remedy("`corroborate init` writes a small study with all its files"))
    }
}

/// The texts as they are kept, of those files that are in reach: the link that a file is may lead elsewhere.
#[derive(Clone, Debug, Default)]
pub struct Saved(pub Reach);

impl Texts for Saved {
    fn exists(&self, path: &Path) -> bool {
        path.exists()
    }

    fn text(&self, path: &Path) -> Result<Source, Problem> {
        self.0.check(path)?;
        host::files::read_source(path)
    }
}
