//! The files of a study as a technique reads them: what was read is what its evidence rests on.
//!
//! A technique is given [`Files`] and reads through them. Each file that it read, or looked for in vain, becomes part of the
//! evidence's fingerprint, and each that it read one of its assets, so that evidence cannot be fresh although a file on
//! which it depends was changed.

use diagnostic::{Problem, Source};
use evidence::{Asset, AssetRole};
use host::files::MOST_BYTES;
use host::store::{Inputs, hash_of};
use host::{Reach, Trust};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use study::Study;

/// The files of a study, and which of them were read.
#[derive(Debug)]
pub struct Files<'s> {
    folder: &'s Path,
    /// What of it, and beside it, may be read.
    reach: Reach,
    /// In the order in which they were first read.
    read: RefCell<Vec<Asset>>,
    /// Paths at which there was no file.
    missing: RefCell<Vec<String>>,
}

impl<'s> Files<'s> {
    /// Those of a study's folder and no others, none of which was read yet.
    pub fn of(folder: &'s Path) -> Self {
        Self::within(folder, Reach::of(folder, &Trust::default()))
    }

    /// Those of a study, wherever it may read.
    pub fn of_study(study: &'s Study) -> Self {
        Self::within(&study.folder, study.reach.clone())
    }

    fn within(folder: &'s Path, reach: Reach) -> Self {
        Self {
            folder,
            reach,
            read: RefCell::default(),
            missing: RefCell::default(),
        }
    }

    /// The bytes of a file, whose path is relative to the study's folder.
    ///
    /// # Errors
    /// `outside-study`, `cannot-read`, `file-too-large`.
    pub fn bytes(&self, role: AssetRole, path: &Path) -> Result<Vec<u8>, Problem> {
        let bytes = host::files::read_file(&self.in_reach(path)?, u64::MAX - 1)?;
        self.add(role, path, &bytes);
        Ok(bytes)
    }

    /// A text, of at most [`MOST_BYTES`] in UTF-8.
    ///
    /// # Errors
    /// `outside-study`, `cannot-read`, `file-too-large`, `not-text`.
    pub fn text(&self, role: AssetRole, path: &Path) -> Result<Source, Problem> {
        let source = host::files::read_source(&self.in_reach(path)?)?;
        self.add(role, path, source.text.as_bytes());
        Ok(source)
    }

    /// A text in the PRISM language, with the warning that its letters had to be guessed, if so.
    ///
    /// # Errors
    /// `outside-study`, `cannot-read`, `file-too-large`, `not-text`.
    pub fn prism(
        &self,
        role: AssetRole,
        path: &Path,
    ) -> Result<(Source, Option<Problem>), Problem> {
        let full = self.in_reach(path)?;
        let bytes = host::files::read_file(&full, MOST_BYTES)?;
        self.add(role, path, &bytes);
        host::files::prism_of_bytes(&full, bytes)
    }

    /// A text if there is such a file. That there is none is remembered, too: evidence is stale once there is one.
    ///
    /// # Errors
    /// `outside-study`, `cannot-read`, `file-too-large`, `not-text`.
    pub fn text_if_any(&self, role: AssetRole, path: &Path) -> Result<Option<Source>, Problem> {
        if self.folder.join(path).exists() {
            return self.text(role, path).map(Some);
        }
        let mut missing = self.missing.borrow_mut();
        let path = shown(path);
        if !missing.contains(&path) {
            missing.push(path);
        }
        Ok(None)
    }

    /// The whole path of a file that may be read.
    fn in_reach(&self, path: &Path) -> Result<PathBuf, Problem> {
        let full = self.folder.join(path);
        self.reach.check(&full).map(|()| full)
    }

    /// A file that was read and hashed elsewhere.
    pub(crate) fn was_read(&self, asset: &Asset) {
        let mut read = self.read.borrow_mut();
        if !read.contains(asset) {
            read.push(asset.clone());
        }
    }

    fn add(&self, role: AssetRole, path: &Path, bytes: &[u8]) {
        self.was_read(&Asset {
            role,
            path: shown(path),
            hash: hash_of(bytes),
        });
    }

    /// What was read, in the order in which it was read first.
    pub(crate) fn read(&self) -> Vec<Asset> {
        self.read.borrow().clone()
    }

    /// Adds what was read, and what was looked for in vain, to what a result depends on.
    pub(crate) fn inputs(&self, inputs: &mut Inputs) {
        for asset in self.read.borrow().iter() {
            inputs
                .add("file", asset.path.as_bytes())
                .add("content", asset.hash.as_bytes());
        }
        for path in self.missing.borrow().iter() {
            inputs.add("no file", path.as_bytes());
        }
    }
}

fn shown(path: &Path) -> String {
    path.to_string_lossy().replace('\\', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_read_or_looked_for_in_vain_is_part_of_the_fingerprint() {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).expect("written");
        };
        let fingerprint = || {
            let files = Files::of(folder.path());
            let (one, other) = (Path::new("one"), Path::new("other"));
            files.text(AssetRole::Data, one).expect("read");
            files.text_if_any(AssetRole::Data, other).expect("read");
            let mut inputs = Inputs::default();
            files.inputs(&mut inputs);
            (inputs.hash(), files.read().len())
        };
        write("one", "1");
        write("unread", "1");
        let (before, count) = fingerprint();
        assert_eq!(count, 1);
        write("unread", "2");
        assert_eq!(fingerprint().0, before);
        write("other", "");
        let (with_other, count) = fingerprint();
        assert_ne!(with_other, before);
        assert_eq!(count, 2);
        write("one", "2");
        assert_ne!(fingerprint().0, with_other);
    }
}
