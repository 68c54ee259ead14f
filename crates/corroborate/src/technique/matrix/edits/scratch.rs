//! A study with one edit, read from a folder of its own.

use super::TextEdit;
use diagnostic::Problem;
use std::path::{Path, PathBuf};
use study::Study;

/// The texts of a study in a folder of their own, where they can be edited and read.
pub(crate) struct Scratch {
    pub(super) folder: PathBuf,
    study: PathBuf,
    /// What the study reads.
    reach: host::Reach,
}

/// The texts that are read to judge, to ask and to count.
const TEXTS: [&str; 5] = [
    "study.toml",
    "parameters.toml",
    "requirements.toml",
    "vocabulary.toml",
    "topics.toml",
];

impl Scratch {
    pub(crate) fn new(study: &Study, results: &Path) -> Result<Self, Problem> {
        let folder = results.join("edits");
        std::fs::create_dir_all(&folder).map_err(|error| Problem::cannot_write(&folder, &error))?;
        Ok(Self {
            folder,
            study: study.folder.clone(),
            reach: study.reach.clone(),
        })
    }

    /// The study with an edit; its other files stay where they are, and it has no ledger.
    pub(super) fn with(&self, edit: &TextEdit) -> Result<Study, Problem> {
        self.with_changed(edit.file, &|text| {
            text.replace_range(edit.span.clone(), &edit.new);
        })
    }

    /// The study with one of its texts changed.
    pub(crate) fn with_changed(
        &self,
        file: &str,
        change: &dyn Fn(&mut String),
    ) -> Result<Study, Problem> {
        for name in TEXTS {
            let path = self.study.join(name);
            if !path.exists() {
                continue;
            }
            let mut text = host::files::read_source(&path)?.text;
            if name == file {
                change(&mut text);
            }
            if name == "study.toml" {
                text = without_entries(&text);
            }
            let target = self.folder.join(name);
            std::fs::write(&target, text)
                .map_err(|error| Problem::cannot_write(&target, &error))?;
        }
        let mut study = Study::load(&self.folder)?;
        study.folder.clone_from(&self.study);
        study.reach.clone_from(&self.reach);
        Ok(study)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed is in nobody's way.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// study.toml without what it says of the ledger's entries.
fn without_entries(text: &str) -> String {
    let Ok(mut table) = text.parse::<toml::Table>() else {
        return text.to_owned();
    };
    table.remove("weights");
    table.remove("costs");
    table.to_string()
}
