//! `requirements-sync.toml`: on what the study and the files of other tools agreed last.
//!
//! Of each file and each requirement in both it keeps a hash of each field, and under which names the file has the fields. It is
//! written by `requirements import` and `export`, and belongs under version control with the study.

use super::merge::{Direction, Merged};
use diagnostic::Problem;
use host::files::{read_source, write_text};
use requirement_files::{Columns, Document, Field};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

/// The file's name.
pub const RECORD: &str = "requirements-sync.toml";

/// Its content.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Record {
    #[serde(default)]
    file: Vec<File>,
}

/// What was agreed on with one file.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    /// Its path, from the study's folder.
    path: String,
    /// Its format.
    format: String,
    /// Under which names it has id and fields.
    #[serde(default)]
    columns: BTreeMap<String, String>,
    /// The requirements that the study has from it.
    #[serde(default)]
    imported: BTreeSet<String>,
    /// Of each requirement, the hashes of its fields.
    #[serde(default)]
    pub(super) requirements: BTreeMap<String, BTreeMap<String, String>>,
}

/// What stands for a value.
pub(super) fn hash(value: &str) -> String {
    blake3::hash(value.as_bytes()).to_hex()[..16].to_owned()
}

impl Record {
    /// The record of a study; empty if there is none.
    pub(super) fn load(folder: &Path) -> Result<Self, Problem> {
        let path = folder.join(RECORD);
        match path.exists() {
            false => Ok(Self::default()),
            true => study::read_toml("bad-study-file", &read_source(&path)?),
        }
    }

    pub(super) fn of(&self, path: &str) -> Option<&File> {
        self.file.iter().find(|file| file.path == path)
    }

    /// The requirements that came from other files than this one, so that they have their place there.
    pub(super) fn kept_elsewhere(&self, path: &str) -> BTreeSet<String> {
        let others = self.file.iter().filter(|file| file.path != path);
        others
            .flat_map(|file| file.imported.iter().cloned())
            .collect()
    }

    /// Sets what was agreed on with a file.
    pub(super) fn set(
        &mut self,
        path: &str,
        document: &Document,
        merged: &Merged,
        direction: Direction,
    ) {
        let mut imported = self
            .of(path)
            .map_or(BTreeSet::new(), |known| known.imported.clone());
        if direction == Direction::Import {
            imported.extend(merged.added.iter().map(|item| item.id.clone()));
        }
        let file = File {
            imported,
            path: path.to_owned(),
            format: document.format.name().to_owned(),
            columns: columns_of(document),
            requirements: merged.agreed.clone(),
        };
        match self.file.iter_mut().find(|known| known.path == path) {
            Some(known) => *known = file,
            None => self.file.push(file),
        }
    }

    pub(super) fn write(&self, folder: &Path) -> Result<(), Problem> {
        let path = folder.join(RECORD);
        write_text(&path, &self.text(), &path)
    }

    fn text(&self) -> String {
        let mut text = String::from(
            "# On what this study and files of other tools agreed last, written by `corroborate requirements import` and\n\
             # `export`. Keep it with the study: by it they know which side was edited (`corroborate explain requirements-sync`).\n",
        );
        let quoted = |text: &str| toml::Value::from(text).to_string();
        // Writing to a String cannot fail.
        for file in &self.file {
            let _ = write!(
                text,
                "\n[[file]]\npath = {}\nformat = {}\n",
                quoted(&file.path),
                quoted(&file.format)
            );
            let table = |entries: &BTreeMap<String, String>| {
                let entries = entries
                    .iter()
                    .map(|(key, value)| format!("{} = {}", quoted(key), quoted(value)));
                entries.collect::<Vec<_>>().join(", ")
            };
            if !file.columns.is_empty() {
                let _ = writeln!(text, "columns = {{ {} }}", table(&file.columns));
            }
            if !file.imported.is_empty() {
                let ids: Vec<String> = file.imported.iter().map(|id| quoted(id)).collect();
                let _ = writeln!(text, "imported = [{}]", ids.join(", "));
            }
            let _ = writeln!(text, "[file.requirements]");
            for (id, fields) in &file.requirements {
                let _ = writeln!(text, "{} = {{ {} }}", quoted(id), table(fields));
            }
        }
        text
    }
}

impl File {
    /// Under which names the file has the fields.
    pub(super) fn columns(&self) -> Columns {
        let fields = Field::ALL.into_iter();
        Columns {
            id: self.columns.get("id").cloned(),
            fields: fields
                .filter_map(|field| Some((field, self.columns.get(field.name())?.clone())))
                .collect(),
        }
    }
}

fn columns_of(document: &Document) -> BTreeMap<String, String> {
    let columns = document.columns();
    let fields = columns
        .fields
        .iter()
        .map(|(field, name)| (field.name().to_owned(), name.clone()));
    let id = columns
        .id
        .iter()
        .map(|name| ("id".to_owned(), name.clone()));
    fields.chain(id).collect()
}
