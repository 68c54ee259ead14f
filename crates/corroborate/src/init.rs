//! New studies: from a template that runs as it is, or drafted from a robot's description, a recording or a behaviour tree.

mod draft;
mod files;
mod recording;
mod robot;
mod template;
mod tree;

use diagnostic::Problem;
use std::path::{Path, PathBuf};

pub use files::{Content, NewFile};
pub use template::Template;

/// What a new study is made of, and where.
#[derive(Clone, Debug)]
pub struct InitRequest {
    /// The folder to make; one with content is not touched.
    pub folder: PathBuf,
    /// What it is made of.
    pub source: InitSource,
    /// Recordings of a behaviour tree at work, to whose counts the constants of its model are set: a recording, a folder of
    /// them, or a table with the columns `node` and `status`. For a [`InitSource::File`] that is a behaviour tree.
    pub recordings: Option<PathBuf>,
    /// Files that whoever makes the study adds, by their places in the folder.
    pub extra: Vec<NewFile>,
}

/// What a study is made of.
#[derive(Clone, Debug)]
pub enum InitSource {
    /// A template.
    Template(Template),
    /// A behaviour tree (the XML of BehaviorTree.CPP), a description of a robot (URDF, SDF, MJCF), or a recording in any
    /// format that [`inspect`](crate::inspect()) reads.
    File(PathBuf),
}

/// What was made.
#[derive(Clone, Debug)]
pub struct InitReport {
    /// What it is, in a few words: the template's meaning, or what it was drafted from.
    pub is: String,
    /// The files by their places in the folder, but for those that were added by `extra`.
    pub files: Vec<PathBuf>,
    /// What whoever edits a draft has to know: what was referred to and what was copied.
    pub notes: Vec<String>,
}

impl InitRequest {
    /// The template with which one begins.
    pub fn new(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: folder.into(),
            source: InitSource::Template(Template::default()),
            recordings: None,
            extra: Vec::new(),
        }
    }
}

/// A study before it is written.
struct Draft {
    is: String,
    files: Vec<NewFile>,
    notes: Vec<String>,
}

/// Makes a study. Everything is read and drafted first; what cannot be written whole is removed again.
///
/// # Errors
/// `folder-not-empty`, `cannot-write`; of a behaviour tree `bad-behaviour-tree`, `unsupported-behaviour-tree`, and
/// `no-executions` if the recordings show none of it; `recordings-without-tree`; of another file what [`inspect`](crate::inspect()) says of it, `description-refused` if no
/// simulation would take the robot, and `nothing-to-draft` if a recording holds no number.
pub fn init(request: &InitRequest) -> Result<InitReport, Problem> {
    files::refuse_occupied(&request.folder)?;
    refuse_recordings(request)?;
    let mut draft = match &request.source {
        InitSource::Template(template) => Draft {
            is: template.meaning().to_owned(),
            files: template.files(),
            notes: Vec::new(),
        },
        InitSource::File(file) if tree::is_tree(file) => {
            tree::draft(file, request.recordings.as_deref())?
        }
        InitSource::File(file) if crate::inspect::is_description(file) => robot::draft(file)?,
        InitSource::File(file) => recording::draft(file)?,
    };
    let files = draft.files.iter().map(|file| file.path.clone()).collect();
    draft.files.extend(request.extra.iter().cloned());
    files::write(&request.folder, &draft.files)?;
    Ok(InitReport {
        is: draft.is,
        files,
        notes: draft.notes,
    })
}

/// Recordings are counted for a behaviour tree alone.
fn refuse_recordings(request: &InitRequest) -> Result<(), Problem> {
    let is_tree = matches!(&request.source, InitSource::File(file) if tree::is_tree(file));
    if request.recordings.is_none() || is_tree {
        return Ok(());
    }
    let message =
        "recordings are given, and what the study is drafted from is not a behaviour tree";
    Err(Problem::new("recordings-without-tree", message)
        .remedy("name a file of BehaviorTree.CPP with --from; a recording alone is drafted from with --from itself"))
}

/// Makes the study with which one begins: [`init()`] with [`InitRequest::new`].
///
/// # Errors
/// As [`init()`].
pub fn new_study(folder: &Path) -> Result<(), Problem> {
    init(&InitRequest::new(folder)).map(|_| ())
}
