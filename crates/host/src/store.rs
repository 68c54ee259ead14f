//! Where results are kept, and how it is known that they are still fresh.
//!
//! A result carries the hash of everything that it depends on: the content of
//! the assets, the settings, and this program itself. If the hash is the same,
//! the work is not done again; if it differs, the result is stale.

use crate::files::{not_through_a_link, write_whole};
use diagnostic::Problem;
use serde::{Deserialize, Serialize};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

/// The folder of a study's results, held by this process alone.
#[derive(Debug)]
pub struct Store {
    folder: PathBuf,
    /// Keeps others out until it is dropped.
    _lock: File,
}

/// A stored result with the hash of its inputs.
#[derive(Debug, Serialize, Deserialize)]
pub struct Stored<T> {
    /// Hash of everything the content depends on, in hexadecimal.
    pub inputs: String,
    /// Hash of the content, so that an edited result is not taken for ours.
    pub digest: String,
    /// The result.
    pub content: T,
}

impl<T: Serialize> Stored<T> {
    /// Whether the content is as it was kept.
    pub fn is_as_kept(&self) -> bool {
        digest(&self.content).is_some_and(|digest| digest == self.digest)
    }
}

impl Store {
    /// Opens or makes the folder.
    pub fn open(folder: &Path) -> Result<Self, Problem> {
        let fail = |error: std::io::Error| Problem::cannot_write(folder, &error);
        std::fs::create_dir_all(folder).map_err(fail)?;
        not_through_a_link(&folder.join(".lock"))?;
        let lock = File::options()
            .create(true)
            .truncate(false)
            .write(true)
            .open(folder.join(".lock"))
            .map_err(fail)?;
        match lock.try_lock() {
            Ok(()) => Ok(Self {
                folder: folder.to_owned(),
                _lock: lock,
            }),
            Err(TryLockError::WouldBlock) => Err(Problem::new(
                "results-in-use",
                format!("another process is writing to {}", folder.display()),
            )
            .remedy("wait until it is done, or choose another folder for results (--out on the command line)")),
            Err(TryLockError::Error(error)) => Err(fail(error)),
        }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The stored result, if it is there, readable and fresh.
    pub fn fresh<T: for<'de> Deserialize<'de> + Serialize>(
        &self,
        name: &str,
        inputs: &str,
    ) -> Option<T> {
        fresh_in(&self.folder, name, inputs)
    }

    /// Keeps a result.
    pub fn keep<T: Serialize>(&self, name: &str, inputs: &str, content: T) -> Result<(), Problem> {
        let stored = Stored {
            inputs: inputs.to_owned(),
            digest: digest(&content).unwrap_or_default(),
            content,
        };
        let mut bytes = serde_json::to_vec_pretty(&stored)
            .map_err(|error| Problem::new("cannot-write", format!("{name}: {error}")))?;
        bytes.push(b'\n');
        self.write(name, &bytes)
    }

    /// Writes a file of the folder whole, unless it already has this content.
    pub fn write(&self, name: &str, content: &[u8]) -> Result<(), Problem> {
        let path = self.folder.join(name);
        if std::fs::read(&path).is_ok_and(|old| old == content) {
            return Ok(());
        }
        write_whole(&path, content)
    }

    /// A folder for many files of one stage of work. If what is in it was made
    /// from other inputs, it is emptied first.
    pub fn stage(&self, name: &str, inputs: &str) -> Result<PathBuf, Problem> {
        let folder = self.folder.join(name);
        let mark = folder.join(MARK);
        let fail = |error: std::io::Error| Problem::cannot_write(&folder, &error);
        if !is_stage_of(&folder, inputs) {
            if folder.exists() {
                std::fs::remove_dir_all(&folder).map_err(fail)?;
            }
            write_whole(&mark, format!("{inputs}\n").as_bytes())?;
        }
        Ok(folder)
    }
}

/// The file of a stage that says from what it was made.
const MARK: &str = "inputs";

/// Whether the files of a stage were made from these inputs.
pub fn is_stage_of(folder: &Path, inputs: &str) -> bool {
    let marked = std::fs::read_to_string(folder.join(MARK)).unwrap_or_default();
    marked.trim() == inputs
}

/// The result that is stored in a folder of results, if it is there, readable and fresh.
pub fn fresh_in<T: for<'de> Deserialize<'de> + Serialize>(
    folder: &Path,
    name: &str,
    inputs: &str,
) -> Option<T> {
    let bytes = std::fs::read(folder.join(name)).ok()?;
    // A file that cannot be read back is as good as none: it is made again.
    let stored: Stored<T> = serde_json::from_slice(&bytes).ok()?;
    let is_fresh = stored.inputs == inputs && stored.digest == digest(&stored.content)?;
    is_fresh.then_some(stored.content)
}

fn digest(content: &impl Serialize) -> Option<String> {
    Some(hash_of(&serde_json::to_vec(content).ok()?))
}

/// Collects what a result depends on.
#[derive(Clone, Debug, Default)]
pub struct Inputs(blake3::Hasher);

impl Inputs {
    /// Adds a named part. Names and contents cannot run into each other.
    pub fn add(&mut self, name: &str, content: &[u8]) -> &mut Self {
        for part in [name.as_bytes(), content] {
            self.0.update(&(part.len() as u64).to_le_bytes());
            self.0.update(part);
        }
        self
    }

    /// Adds a named value in its JSON form.
    pub fn add_json(&mut self, name: &str, value: &impl Serialize) -> &mut Self {
        // The values are plain data of this program; a failure to serialise
        // them must still not make two different inputs look the same.
        let json = serde_json::to_vec(value).unwrap_or_else(|e| e.to_string().into_bytes());
        self.add(name, &json)
    }

    /// The hash of all parts, in hexadecimal.
    pub fn hash(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}

/// The hash of a content, in hexadecimal.
pub fn hash_of(content: &[u8]) -> String {
    blake3::hash(content).to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn store() -> (tempfile::TempDir, Store) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let store = Store::open(folder.path()).expect("a store");
        (folder, store)
    }

    #[test]
    fn a_result_is_fresh_only_for_its_inputs() {
        let (_folder, store) = store();
        store.keep("a.json", "one", 42_u64).expect("kept");
        assert_eq!(store.fresh::<u64>("a.json", "one"), Some(42));
        assert_eq!(store.fresh::<u64>("a.json", "two"), None);
        assert_eq!(store.fresh::<u64>("b.json", "one"), None);
    }

    #[test]
    fn an_edited_result_is_made_again() {
        let (folder, store) = store();
        store.keep("a.json", "one", 42_u64).expect("kept");
        let path = folder.path().join("a.json");
        let text = std::fs::read_to_string(&path).expect("text");
        std::fs::write(&path, text.replace("42", "43")).expect("written");
        assert_eq!(store.fresh::<u64>("a.json", "one"), None);
    }

    #[test]
    fn a_damaged_result_is_made_again() {
        let (folder, store) = store();
        std::fs::write(folder.path().join("a.json"), "{\"inputs\": \"one\", \"con")
            .expect("written");
        assert_eq!(store.fresh::<u64>("a.json", "one"), None);
    }

    #[test]
    fn a_second_process_is_kept_out() {
        let (folder, _store) = store();
        let second = Store::open(folder.path()).expect_err("locked");
        assert_eq!(second.code, "results-in-use");
    }

    #[test]
    fn other_inputs_empty_a_stage() {
        let (_folder, store) = store();
        let stage = store.stage("traces/E1", "one").expect("made");
        std::fs::write(stage.join("episode"), "x").expect("written");
        assert!(
            store
                .stage("traces/E1", "one")
                .expect("kept")
                .join("episode")
                .exists()
        );
        assert!(
            !store
                .stage("traces/E1", "two")
                .expect("emptied")
                .join("episode")
                .exists()
        );
    }

    #[test]
    fn parts_of_inputs_do_not_run_into_each_other() {
        let hash = |parts: &[(&str, &str)]| {
            let mut inputs = Inputs::default();
            for (name, content) in parts {
                inputs.add(name, content.as_bytes());
            }
            inputs.hash()
        };
        assert_ne!(hash(&[("ab", "c")]), hash(&[("a", "bc")]));
        assert_ne!(
            hash(&[("a", "b"), ("c", "d")]),
            hash(&[("a", "bc"), ("", "d")])
        );
    }
}
