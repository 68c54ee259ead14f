//! The files of other tools, found and read.

use super::merge::{Direction, Merged};
use diagnostic::Problem;
use host::files::read_file;
use requirement_files::{Columns, Document, File, Format, MOST_BYTES, is_doorstop_item};
use std::path::{Component, Path, PathBuf};

/// Where the other tool's file is.
pub(super) struct Place {
    path: PathBuf,
    /// As the user named it.
    pub(super) shown: String,
    /// From the study's folder, the same wherever both are checked out.
    pub(super) name: String,
    format: Format,
    pub(super) exists: bool,
}

impl Place {
    pub(super) fn new(study: &Path, path: &Path) -> Result<Self, Problem> {
        let shown = path.display().to_string();
        let is_folder = path.is_dir();
        let format = match is_folder {
            true => Some(Format::Doorstop),
            false => Format::of_ending(&shown),
        };
        let format = format.ok_or_else(|| {
            let message = format!("{shown} is not known as a file of requirements");
            Problem::new("bad-requirement-file", message).remedy(
                "name a file that ends with .json (FRET), .reqif, .reqifz, .sdoc or .csv, or a folder of Doorstop",
            )
        })?;
        let exists = match is_folder {
            true => path.join(".doorstop.yml").exists(),
            false => path.exists(),
        };
        Ok(Self {
            name: from_folder(study, path).unwrap_or_else(|| shown.replace('\\', "/")),
            path: path.to_owned(),
            shown,
            format,
            exists,
        })
    }

    /// Where a file of the document is written.
    pub(super) fn of(&self, name: &str) -> PathBuf {
        match self.format {
            Format::Doorstop => self.path.join(name),
            _ => self.path.clone(),
        }
    }
}

/// A path as it is seen from a folder.
fn from_folder(folder: &Path, path: &Path) -> Option<String> {
    let folder = folder.canonicalize().ok()?;
    let path = match path.canonicalize() {
        Ok(path) => path,
        // It will be made.
        Err(_) => {
            let parent = path.parent().filter(|it| !it.as_os_str().is_empty());
            parent
                .unwrap_or(Path::new("."))
                .canonicalize()
                .ok()?
                .join(path.file_name()?)
        }
    };
    let (mut own, mut other) = (folder.components().peekable(), path.components().peekable());
    while own.peek().is_some() && own.peek() == other.peek() {
        own.next();
        other.next();
    }
    let mut parts: Vec<String> = own.map(|_| "..".to_owned()).collect();
    for part in other {
        match part {
            Component::Normal(name) => parts.push(name.to_string_lossy().into_owned()),
            _ => return None,
        }
    }
    Some(parts.join("/"))
}

/// Reads the document; for an export, an empty one where there is none yet.
pub(super) fn read(
    place: &Place,
    columns: &Columns,
    direction: Direction,
    title: &str,
    first_id: &str,
) -> Result<Document, Problem> {
    if !place.exists && direction == Direction::Export {
        return Document::empty(place.format, &place.shown, title, first_id);
    }
    let files = match place.format {
        Format::Doorstop => folder(&place.path)?,
        _ => vec![File {
            name: place.shown.clone(),
            bytes: read_file(&place.path, MOST_BYTES as u64)?,
        }],
    };
    Document::read(place.format, &files, columns)
}

/// The files of a folder of Doorstop, in the order of their names.
fn folder(path: &Path) -> Result<Vec<File>, Problem> {
    let cannot = |error: std::io::Error| Problem::cannot_read(path, &error);
    let mut names = Vec::new();
    for entry in std::fs::read_dir(path).map_err(cannot)? {
        let entry = entry.map_err(cannot)?;
        if let Some(name) = entry
            .file_name()
            .to_str()
            .filter(|name| is_doorstop_item(name))
            && entry.path().is_file()
        {
            names.push(name.to_owned());
        }
    }
    names.sort();
    let mut left = MOST_BYTES as u64;
    let mut files = Vec::new();
    for name in names {
        let bytes = read_file(&path.join(&name), left)?;
        left -= bytes.len() as u64;
        files.push(File { name, bytes });
    }
    Ok(files)
}

/// What a text that was replaced loses in the file, since it belonged to the old one.
pub(super) fn lost_with_texts(document: &Document, merged: &Merged) -> Vec<String> {
    let texts = merged.changed.iter().filter(|it| it.field == "text");
    match document.format {
        Format::Fret => {
            let has_formulas = |id: &str| document.item(id).is_some_and(|it| it.formulas.is_some());
            let note = |id: &str| {
                format!(
                    "{id}: FRET's formulas were those of the old sentence, and are taken out: open it in FRET, and save it."
                )
            };
            texts
                .filter(|it| has_formulas(&it.id))
                .map(|it| note(&it.id))
                .collect()
        }
        Format::ReqIf | Format::ReqIfArchive => {
            let note = |id: &str| {
                format!(
                    "{id}: the new text is plain; formatting that the old one had in the file is gone."
                )
            };
            texts.map(|it| note(&it.id)).collect()
        }
        _ => Vec::new(),
    }
}
