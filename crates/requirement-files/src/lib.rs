#![doc = include_str!("../README.md")]
//!
//! # What is read, and what is written
//! A [`Document`] is what one file (or one folder of Doorstop) holds: requirements as [`Item`]s, each with the place where it
//! stands. [`Document::with`] changes items *in the text that was read*: everything that is not asked for stays as it is, byte
//! for byte, whatever it means. The new text is read again before it is given out, and is refused unless it holds exactly what
//! was asked for, so no change is lost on the way.
//!
//! | format | id | text | rationale | status | parents |
//! |---|---|---|---|---|---|
//! | FRET (JSON) | `reqid` | `fulltext` | `rationale` | `status` | `parent_reqid` |
//! | ReqIF 1.x (XML, or a `.reqifz` archive) | `ReqIF.ForeignID`, else `IDENTIFIER` | `ReqIF.Text` | an attribute of that name | an attribute of that name | `SPEC-RELATION`s from it |
//! | StrictDoc | `UID` | `STATEMENT` | `RATIONALE` | `STATUS` | `RELATIONS` of type `Parent` |
//! | Doorstop | the file's name | `text` | an attribute of that name | an attribute of that name | `links` |
//! | CSV | a column | a column | a column | a column | a column, separated by commas |
//!
//! [`Columns`] name the attributes or columns where they have other names.
//!
//! # FRET's formulas
//! [`fret`] reads FRET's sentences as sentences of [`requirement_lang`], and compares the meaning of those with the formulas
//! that FRET wrote beside them.

mod csv;
mod doorstop;
mod edit;
pub mod fret;
mod json;
mod mistakes;
mod reqif;
mod strictdoc;

use diagnostic::{Problem, Source};
use std::fmt;
use std::ops::Range;

pub use doorstop::is_item_file as is_doorstop_item;

/// The most bytes that a file, or the files of a folder together, may have.
pub const MOST_BYTES: usize = 64 << 20;
/// The most requirements of one document.
pub const MOST_ITEMS: usize = 100_000;

/// A format of another tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Format {
    /// NASA's FRET: JSON.
    Fret,
    /// The OMG's Requirements Interchange Format: XML.
    ReqIf,
    /// The same in a ZIP archive.
    ReqIfArchive,
    /// StrictDoc's own text.
    StrictDoc,
    /// A folder of Doorstop.
    Doorstop,
    /// A table in CSV, or with tabs.
    Csv,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Fret,
        Self::ReqIf,
        Self::ReqIfArchive,
        Self::StrictDoc,
        Self::Doorstop,
        Self::Csv,
    ];

    /// What people call it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fret => "FRET",
            Self::ReqIf => "ReqIF",
            Self::ReqIfArchive => "ReqIF archive",
            Self::StrictDoc => "StrictDoc",
            Self::Doorstop => "Doorstop",
            Self::Csv => "CSV",
        }
    }

    /// The format of a file by the ending of its name; `None` if no reader has that ending. Doorstop's is that of folders.
    #[must_use]
    pub fn of_ending(name: &str) -> Option<Self> {
        let ending = name.rsplit_once('.')?.1.to_ascii_lowercase();
        Some(match ending.as_str() {
            "json" => Self::Fret,
            "reqif" | "xml" => Self::ReqIf,
            "reqifz" => Self::ReqIfArchive,
            "sdoc" => Self::StrictDoc,
            "csv" | "tsv" => Self::Csv,
            _ => return None,
        })
    }
}

/// What of a requirement is kept the same in both places.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Field {
    /// The requirement itself.
    Text,
    /// Why it is asked for.
    Rationale,
    /// How far it is, in the other tool's words.
    Status,
    /// The ids of the requirements that it was derived from.
    Parents,
}

impl Field {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Text, Self::Rationale, Self::Status, Self::Parents];

    /// Its name in files of ours.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Rationale => "rationale",
            Self::Status => "status",
            Self::Parents => "parents",
        }
    }
}

impl fmt::Display for Field {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name())
    }
}

/// A requirement. What a document does not say is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Item {
    /// Its identifier, unique in its document.
    pub id: String,
    /// The requirement itself, lines ended by `\n`.
    pub text: String,
    /// Why it is asked for.
    pub rationale: String,
    /// How far it is, in the other tool's words.
    pub status: String,
    /// The ids of the requirements that it was derived from.
    pub parents: Vec<String>,
}

impl Item {
    /// A field as text; of the parents, joined by `, `.
    #[must_use]
    pub fn value(&self, field: Field) -> String {
        match field {
            Field::Text => self.text.clone(),
            Field::Rationale => self.rationale.clone(),
            Field::Status => self.status.clone(),
            Field::Parents => self.parents.join(", "),
        }
    }

    /// Sets a field to its value in another item.
    pub fn take(&mut self, field: Field, other: &Self) {
        match field {
            Field::Text => self.text.clone_from(&other.text),
            Field::Rationale => self.rationale.clone_from(&other.rationale),
            Field::Status => self.status.clone_from(&other.status),
            Field::Parents => self.parents.clone_from(&other.parents),
        }
    }
}

/// An item with the place where it stands.
#[derive(Clone, Debug)]
pub struct Placed {
    /// The requirement.
    pub item: Item,
    /// Which of the document's texts it stands in.
    pub source: usize,
    /// Where it stands there.
    pub span: Range<usize>,
    /// The formulas that FRET wrote beside it.
    pub formulas: Option<fret::Formulas>,
}

/// Under which names a document has the fields, where they are not the usual ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Columns {
    /// The attribute or column of the id.
    pub id: Option<String>,
    /// Of each field, if it is named.
    pub fields: Vec<(Field, String)>,
}

impl Columns {
    /// The name under which a field stands, if it is declared.
    #[must_use]
    pub fn of(&self, field: Field) -> Option<&str> {
        let mut fields = self.fields.iter();
        fields
            .find(|(known, _)| *known == field)
            .map(|(_, name)| name.as_str())
    }

    fn is_empty(&self) -> bool {
        self.id.is_none() && self.fields.is_empty()
    }
}

/// The bytes of a file, under the name that the user knows.
#[derive(Clone, Debug)]
pub struct File {
    /// Its name: of Doorstop's, below the folder.
    pub name: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

/// What a file, or a folder of Doorstop, holds.
#[derive(Clone, Debug)]
pub struct Document {
    /// Its format.
    pub format: Format,
    /// The texts that were read.
    pub sources: Vec<Source>,
    /// The requirements, in the order of the document.
    pub items: Vec<Placed>,
    /// Which fields this document has a place for.
    pub fields: Vec<Field>,
    /// What stands in the document and is not taken over, each in one sentence: it is kept there.
    pub notes: Vec<String>,
    columns: Columns,
    /// Of an archive, the bytes that it was read of.
    archive: Vec<u8>,
    /// Of an archive, the names of the texts in it.
    members: Vec<String>,
    /// Of an archive, its own name.
    archive_name: String,
}

/// What is asked of a document.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// The item of this id takes these fields of the item given.
    Set(Item, Vec<Field>),
    /// The item is added.
    Add(Item),
}

impl Document {
    /// Reads a document: one file, or of Doorstop all files of the folder.
    ///
    /// # Errors
    /// `bad-requirement-file` with all mistakes, each with its place and a remedy; `file-too-large`.
    pub fn read(format: Format, files: &[File], columns: &Columns) -> Result<Self, Problem> {
        let bytes: usize = files.iter().map(|file| file.bytes.len()).sum();
        if bytes > MOST_BYTES {
            let name = files.first().map_or("", |file| file.name.as_str());
            return Err(too_large(name));
        }
        let document = match format {
            Format::ReqIfArchive => reqif::archive::read(files, columns)?,
            Format::Doorstop => doorstop::read(texts(files)?, columns)?,
            _ => {
                let mut sources = texts(files)?;
                let source = match sources.len() {
                    1 => sources.remove(0),
                    _ => return Err(mistakes::bad("one file was expected")),
                };
                match format {
                    Format::Fret => fret::read(source, columns)?,
                    Format::ReqIf => reqif::read(source, columns)?,
                    Format::StrictDoc => strictdoc::read(source, columns)?,
                    _ => csv::read(source, columns)?,
                }
            }
        };
        document.checked()
    }

    /// A document of this format without requirements, to which they can be added. Of Doorstop, the prefix of its ids is made of
    /// the first id that it will hold.
    ///
    /// # Errors
    /// `bad-requirement-file` if an id does not fit the format.
    pub fn empty(format: Format, name: &str, title: &str, first_id: &str) -> Result<Self, Problem> {
        let file = |name: &str, text: String| File {
            name: name.to_owned(),
            bytes: text.into_bytes(),
        };
        let files = match format {
            Format::Fret => vec![file(name, fret::EMPTY.to_owned())],
            Format::ReqIf => vec![file(name, reqif::empty(title))],
            Format::ReqIfArchive => vec![File {
                name: name.to_owned(),
                bytes: reqif::archive::empty(title)?,
            }],
            Format::StrictDoc => vec![file(name, strictdoc::empty(title))],
            Format::Doorstop => vec![file(".doorstop.yml", doorstop::empty(first_id)?)],
            Format::Csv => vec![file(name, csv::empty(name))],
        };
        Self::read(format, &files, &Columns::default())
    }

    /// The item of this id.
    #[must_use]
    pub fn item(&self, id: &str) -> Option<&Placed> {
        self.items.iter().find(|placed| placed.item.id == id)
    }

    /// Under which names the fields were declared to stand.
    #[must_use]
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// A problem at the place of an item.
    #[must_use]
    pub fn at(&self, id: &str, problem: Problem) -> Problem {
        match self.item(id) {
            Some(placed) => problem.at(&self.sources[placed.source], placed.span.clone()),
            None => problem,
        }
    }

    /// The files that differ from what was read once these changes are made.
    ///
    /// # Errors
    /// `cannot-write-requirement` if a change has no place in this format, with the reason.
    pub fn with(&self, changes: &[Change]) -> Result<Vec<File>, Problem> {
        if changes.is_empty() {
            return Ok(Vec::new());
        }
        let files = match self.format {
            Format::Fret => fret::with(self, changes)?,
            Format::ReqIf => reqif::with(self, changes)?,
            Format::ReqIfArchive => reqif::archive::with(self, changes)?,
            Format::StrictDoc => strictdoc::with(self, changes)?,
            Format::Doorstop => doorstop::with(self, changes)?,
            Format::Csv => csv::with(self, changes)?,
        };
        self.hold_against(changes, &files)?;
        Ok(files)
    }

    /// Reads what would be written, and fails unless it holds what was there with what was asked for.
    fn hold_against(&self, changes: &[Change], files: &[File]) -> Result<(), Problem> {
        let mut expected: Vec<Item> = self.items.iter().map(|it| it.item.clone()).collect();
        for change in changes {
            match change {
                Change::Set(new, fields) => {
                    if let Some(known) = expected.iter_mut().find(|it| it.id == new.id) {
                        fields.iter().for_each(|field| known.take(*field, new));
                    }
                }
                Change::Add(item) => expected.push(item.clone()),
            }
        }
        let again = Self::read(self.format, &self.all_files(files), &self.columns)
            .map_err(|problem| problem.about("what would be written cannot be read again"))?;
        for item in &expected {
            let Some(found) = again.item(&item.id) else {
                return Err(mistakes::cannot_write(
                    &item.id,
                    "it would not be found again",
                ));
            };
            let differs = |field: &&Field| {
                again.fields.contains(field) && found.item.value(**field) != item.value(**field)
            };
            if let Some(field) = Field::ALL.iter().find(differs) {
                let reason = format!(
                    "its {field} would be read as `{}`",
                    diagnostic::shortened(&found.item.value(*field))
                );
                return Err(mistakes::cannot_write(&item.id, &reason));
            }
        }
        match again.items.len() == expected.len() {
            true => Ok(()),
            false => Err(mistakes::cannot_write(
                &self.sources[0].name,
                "it would have another number of requirements",
            )),
        }
    }

    /// The files of the document with those that are written in the place of the old ones.
    fn all_files(&self, written: &[File]) -> Vec<File> {
        if self.format != Format::Doorstop {
            return written.to_vec();
        }
        let is_written = |name: &str| written.iter().any(|file| file.name == name);
        let kept = self
            .sources
            .iter()
            .filter(|source| !is_written(&source.name));
        let kept = kept.map(|source| File {
            name: source.name.clone(),
            bytes: source.text.clone().into_bytes(),
        });
        kept.chain(written.iter().cloned()).collect()
    }

    /// The document, if its ids are unique and it is not too large.
    fn checked(self) -> Result<Self, Problem> {
        let mut seen = std::collections::BTreeMap::new();
        let mut found = Vec::new();
        for placed in &self.items {
            let source = &self.sources[placed.source];
            if placed.item.id.contains(char::is_control) {
                let message = "an id cannot have line breaks or other control characters";
                let problem = mistakes::bad(message).at(source, placed.span.clone());
                found.push(problem.remedy("write it in one line"));
            }
            let before = seen.insert(placed.item.id.as_str(), placed);
            if let Some(before) = before {
                let message = format!("the id `{}` is given twice", placed.item.id);
                let first = (before.span.clone(), "first here".to_owned());
                let related = match before.source == placed.source {
                    true => vec![first],
                    false => Vec::new(),
                };
                let problem = mistakes::bad(message)
                    .at_places(source, placed.span.clone(), related)
                    .remedy("give each requirement an id of its own; requirements are kept the same by it");
                found.push(problem);
                if found.len() > diagnostic::MOST_SHOWN {
                    break;
                }
            }
        }
        if self.items.len() > MOST_ITEMS {
            found.push(mistakes::bad(format!(
                "{} has more than {MOST_ITEMS} requirements",
                self.sources[0].name
            )));
        }
        match Problem::all(found) {
            Some(problem) => Err(problem),
            None => Ok(self),
        }
    }
}

fn too_large(name: &str) -> Problem {
    let message = format!("{name} has more than {} MiB", MOST_BYTES >> 20);
    Problem::new("file-too-large", message)
        .remedy("check that it is the file you mean: requirements are smaller")
}

/// The files as texts; a mark of the byte order at the beginning is no part of a text.
fn texts(files: &[File]) -> Result<Vec<Source>, Problem> {
    let text = |file: &File| {
        let text = String::from_utf8(file.bytes.clone()).map_err(|error| {
            let first = error.utf8_error().valid_up_to();
            let message = format!(
                "{} is not UTF-8 text (first bad byte at offset {first})",
                file.name
            );
            Problem::new("not-text", message)
                .remedy("save the file as UTF-8, or check that it is the file you mean")
        })?;
        Ok(Source::new(file.name.clone(), text))
    };
    files.iter().map(text).collect()
}

/// Ids that a text lists, separated by commas.
fn listed(text: &str) -> Vec<String> {
    let parts = text.split(',').map(str::trim);
    parts
        .filter(|part| !part.is_empty())
        .map(str::to_owned)
        .collect()
}
