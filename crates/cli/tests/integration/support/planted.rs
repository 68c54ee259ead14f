//! A study that a test writes file by file, runs, and has diagnosed and refined.

use super::program::corroborate;
use serde_json::Value;
use std::path::Path;
use tempfile::TempDir;

/// Its folder, which goes away with it.
pub struct Planted(TempDir);

impl Planted {
    /// A study without files.
    pub fn new() -> Self {
        Self(TempDir::new().expect("a folder"))
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Writes a file, in a folder of the study if its name says one.
    pub fn write(&self, name: &str, text: &str) {
        let path = self.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        std::fs::write(path, text).expect("written");
    }

    /// Runs it: whatever it shows, it is a study.
    pub fn run(&self) {
        let said = corroborate(self.path(), &["run", ".", "--quiet"]);
        assert!([0, 1, 3].contains(&said.code), "{said:?}");
    }

    /// What a command says of it as JSON.
    pub fn json(&self, command: &str) -> Value {
        let said = corroborate(self.path(), &[command, ".", "--format", "json", "--quiet"]);
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
    }
}
