//! Requirements kept the same in a study and in the files of other tools, by id.
//!
//! # Definition
//! Of each field of each requirement there are three values: the study's, the file's, and the one on which both agreed last
//! (of which [`RECORD`] keeps a hash). Where only one side differs from the last, that side was edited, and an import or export
//! carries it over to the other; where both do and are not equal, they are in conflict, and nothing is written of it. A requirement
//! that one side never had is added; one that it had and has no longer was removed there, which is said and never repeated here.
//!
//! # Guarantee
//! From reading to writing one call alone works on a study: a second one, of this process or another, is refused and has changed
//! nothing. The same call twice changes nothing the second time. What is not carried over stays as it is, in the file byte for byte.

mod drift;
mod files;
mod merge;
mod record;
mod text;

pub use drift::{ComparisonShown, SentenceShown, Verdict};
pub use merge::{Edited, Take};
pub use record::RECORD;
pub use requirement_files::{Columns, Field};

use diagnostic::Problem;
use host::Host;
use host::files::{Lock, write_whole};
use merge::{Direction, Merged};
use requirement_files::{Change, Document, Format, Item};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use study::{Study, SubjectForm};

/// What is carried over, and between what.
#[derive(Clone, Debug)]
pub struct ExchangeRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// The file of the other tool, or a folder of Doorstop.
    pub file: PathBuf,
    /// Under which names the file has the fields, where they are not the usual ones; remembered in the study.
    pub columns: Columns,
    /// Whose value counts where both sides were edited.
    pub take: Option<Take>,
    /// Only these requirements; all if there are none.
    pub only: Vec<String>,
    /// Whether translated sentences become the sentences of requirements that are added, where the vocabulary has their names.
    pub sentences: bool,
    /// Whether nothing is written.
    pub dry_run: bool,
}

/// Holds the study while an import or export works on it.
const LOCK: &str = ".requirements-sync.lock";

impl ExchangeRequest {
    /// Between this study and this file.
    pub fn new(study: impl Into<PathBuf>, file: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            file: file.into(),
            columns: Columns::default(),
            take: None,
            only: Vec::new(),
            sentences: false,
            dry_run: false,
        }
    }
}

/// What `requirements import` and `requirements export` print with `--format json`.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ExchangeReport {
    /// Version of this form.
    pub format: String,
    /// `import` or `export`.
    pub direction: String,
    /// The file of the other tool.
    pub file: String,
    /// Its format.
    pub file_format: String,
    /// Whether nothing was written.
    pub dry_run: bool,
    /// The fields that the file has a place for.
    pub fields: Vec<String>,
    /// Requirements that the target did not have.
    pub added: Vec<String>,
    /// Fields that were carried over.
    pub changed: Vec<Edited>,
    /// Fields that were edited on the target's side alone: the other direction carries them over.
    pub waiting: Vec<Edited>,
    /// Fields that were edited on both sides.
    pub conflicts: Vec<Edited>,
    /// Requirements that both had and the file has no longer.
    pub removed_from_file: Vec<String>,
    /// Requirements that both had and the study has no longer.
    pub removed_from_study: Vec<String>,
    /// Requirements that only the target has: the other direction adds them.
    pub only_in_target: Vec<String>,
    /// Requirements of the study that are kept the same in another file, and so are not added to this one.
    pub kept_elsewhere: Vec<String>,
    /// How many requirements are the same on both sides.
    pub same: usize,
    /// FRET's sentences as sentences of ours, and how their meanings compare.
    pub sentences: Vec<SentenceShown>,
    /// What stands in the file and is not taken over, and what else is to be known.
    pub notes: Vec<String>,
    /// The files that were written, or would be.
    pub written: Vec<String>,
}

/// Carries requirements over from a file to a study.
///
/// # Errors
/// What the study's files or the other tool's say wrong, each with its place (`bad-requirement-file`); `unknown-requirement` of
/// `only`; `requirements-in-use` if another import or export of the study is at work; `cannot-write`.
pub fn import_requirements(
    request: &ExchangeRequest,
    host: &Host,
) -> Result<ExchangeReport, Problem> {
    let work = Work::new(request, Direction::Import, host)?;
    host.go_on()?;
    let merged = work.merged();
    let sentences = drift::of_document(&work.study, &work.document);
    let text = text::edited(
        &work.study,
        &work.document,
        &merged,
        &sentences,
        request.sentences,
    )?;
    let mut report = work.report(&merged, sentences);
    if let Some(text) = text {
        report.written.push("requirements.toml".to_owned());
        if !request.dry_run {
            text::write(&work.study, &text)?;
        }
    }
    work.keep(&merged, &mut report)?;
    Ok(report)
}

/// Carries requirements over from a study to a file, which is made if there is none.
///
/// # Errors
/// As [`import_requirements`]; `cannot-write-requirement` if a change has no place in the file's format.
pub fn export_requirements(
    request: &ExchangeRequest,
    host: &Host,
) -> Result<ExchangeReport, Problem> {
    let work = Work::new(request, Direction::Export, host)?;
    host.go_on()?;
    let merged = work.merged();
    let mut changes: Vec<Change> = Vec::new();
    for item in &merged.added {
        changes.push(Change::Add(item.clone()));
    }
    for (id, fields) in merged.fields_by_id() {
        let item = work.own.iter().find(|item| item.id == id);
        changes.extend(item.map(|item| Change::Set(item.clone(), fields)));
    }
    let files = work.document.with(&changes)?;
    let sentences = drift::of_document(&work.study, &work.document);
    let drifted = drift::of_texts(&work.study, &work.document, &sentences, |id| {
        work.written_text(&merged, id)
    });
    let mut report = work.report(&merged, sentences);
    report.notes.extend(drifted);
    report.notes.extend(work.left_out(&merged));
    report
        .notes
        .extend(files::lost_with_texts(&work.document, &merged));
    for file in files {
        let path = work.place.of(&file.name);
        report.written.push(path.display().to_string());
        if !request.dry_run {
            write_whole(&path, &file.bytes)?;
        }
    }
    work.keep(&merged, &mut report)?;
    Ok(report)
}

fn in_use(study: &std::path::Path) -> Problem {
    let message = format!(
        "another import or export of requirements is working on {}",
        study.display()
    );
    Problem::new("requirements-in-use", message)
        .remedy("wait until it is done, and run this one again: nothing was changed")
}

/// A study's requirements as a document in ReqIF.
pub(crate) fn reqif(study: &Study) -> Result<Vec<u8>, Problem> {
    let name = "requirements.reqif";
    let document = Document::empty(Format::ReqIf, name, &study.about.title, "")?;
    let items = study.forms.subjects.iter();
    let items = items.filter_map(|it| item(study, it)).map(Change::Add);
    let files = document.with(&items.collect::<Vec<_>>())?;
    let written = files.into_iter().find(|file| file.name == name);
    written.map(|file| file.bytes).ok_or_else(|| {
        Problem::new("cannot-write-requirement", "the study has no requirement")
            .remedy("write one in requirements.toml")
    })
}

/// Both sides, read.
struct Work<'r> {
    request: &'r ExchangeRequest,
    direction: Direction,
    study: Study,
    own: Vec<Item>,
    document: Document,
    place: files::Place,
    record: record::Record,
    /// Keeps others out until all is written; none where nothing is.
    _lock: Option<Lock>,
}

impl<'r> Work<'r> {
    fn new(
        request: &'r ExchangeRequest,
        direction: Direction,
        host: &Host,
    ) -> Result<Self, Problem> {
        let lock = match request.dry_run {
            true => None,
            false => Lock::take(&request.study.join(LOCK), || in_use(&request.study))?,
        };
        let study = Study::load_for(&request.study, &host.trust)?;
        let own: Vec<Item> = study
            .forms
            .subjects
            .iter()
            .filter_map(|it| item(&study, it))
            .collect();
        let record = record::Record::load(&study.folder)?;
        let place = files::Place::new(&study.folder, &request.file)?;
        let known = record.of(&place.name);
        let columns = match request.columns == Columns::default() {
            true => known.map(record::File::columns).unwrap_or_default(),
            false => request.columns.clone(),
        };
        let first = own.first().map_or("", |item| item.id.as_str());
        let document = files::read(&place, &columns, direction, &study.about.title, first)?;
        let work = Self {
            request,
            direction,
            study,
            own,
            document,
            place,
            record,
            _lock: lock,
        };
        work.check_only()?;
        Ok(work)
    }

    /// Every requirement that was named has to be on one of both sides.
    fn check_only(&self) -> Result<(), Problem> {
        let is_known =
            |id: &str| self.own.iter().any(|it| it.id == id) || self.document.item(id).is_some();
        let unknown = self.request.only.iter().filter(|id| !is_known(id));
        let problem = |id: &String| {
            let message = format!(
                "neither the study nor {} has a requirement `{id}`",
                self.place.shown
            );
            let known = self.own.iter().map(|it| it.id.as_str());
            let similar = diagnostic::did_you_mean(id, known);
            Problem::new("unknown-requirement", message).remedy(match similar {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => "name a requirement of one of both".to_owned(),
            })
        };
        Problem::all(unknown.map(problem)).map_or(Ok(()), Err)
    }

    fn merged(&self) -> Merged {
        merge::merged(
            self.direction,
            &self.own,
            &self.document,
            self.record.of(&self.place.name),
            &match self.place.exists {
                true => self.record.kept_elsewhere(&self.place.name),
                // A new file takes all.
                false => std::collections::BTreeSet::new(),
            },
            self.request.take,
            &self.request.only,
        )
    }

    fn report(&self, merged: &Merged, sentences: Vec<SentenceShown>) -> ExchangeReport {
        ExchangeReport {
            format: "1.0".into(),
            direction: self.direction.name().to_owned(),
            file: self.place.shown.clone(),
            file_format: self.document.format.name().to_owned(),
            dry_run: self.request.dry_run,
            fields: self
                .document
                .fields
                .iter()
                .map(|it| it.name().to_owned())
                .collect(),
            added: merged.added.iter().map(|it| it.id.clone()).collect(),
            changed: merged.changed.clone(),
            waiting: merged.waiting.clone(),
            conflicts: merged.conflicts.clone(),
            removed_from_file: merged.removed_from_file.clone(),
            removed_from_study: merged.removed_from_study.clone(),
            only_in_target: merged.only_in_target.clone(),
            kept_elsewhere: merged.kept_elsewhere.clone(),
            same: merged.same,
            sentences,
            notes: self.document.notes.clone(),
            written: Vec::new(),
        }
    }

    /// The text of a requirement that is written: of one that is added, or whose text changes.
    fn written_text(&self, merged: &Merged, id: &str) -> Option<String> {
        let is_added = merged.added.iter().any(|it| it.id == id);
        let mut changed = merged.changed.iter();
        let is_written = is_added || changed.any(|it| it.id == id && it.field == "text");
        let own = self.own.iter().find(|it| it.id == id)?;
        is_written.then(|| own.text.clone())
    }

    /// Fields of requirements that are added and have no place in the file.
    fn left_out(&self, merged: &Merged) -> Vec<String> {
        let absent = Field::ALL
            .iter()
            .filter(|field| !self.document.fields.contains(field));
        let note = |field: &Field| {
            let with = merged
                .added
                .iter()
                .filter(|item| !item.value(*field).is_empty());
            let count = with.count();
            (count > 0).then(|| {
                format!(
                    "Kept in the study: the {field} of {}, for which {} has no place.",
                    diagnostic::counted(count, "requirement"),
                    self.place.shown
                )
            })
        };
        absent.filter_map(note).collect()
    }

    /// Writes down on what both sides agree now.
    fn keep(&self, merged: &Merged, report: &mut ExchangeReport) -> Result<(), Problem> {
        let mut record = self.record.clone();
        record.set(&self.place.name, &self.document, merged, self.direction);
        let is_new = self.record.of(&self.place.name).is_none();
        if record == self.record || (is_new && merged.agreed.is_empty()) {
            return Ok(());
        }
        report.written.push(RECORD.to_owned());
        match self.request.dry_run {
            true => Ok(()),
            false => record.write(&self.study.folder),
        }
    }
}

/// A requirement of the study as an item of other tools.
fn item(study: &Study, form: &SubjectForm) -> Option<Item> {
    let requirement = study
        .requirements
        .iter()
        .find(|it| it.id == form.subject.id())?;
    // A text of several lines has the line ends of its file; items have one kind.
    let lines = |text: &str| text.replace("\r\n", "\n");
    matches!(form.subject, evidence::Subject::Requirement(_)).then(|| Item {
        id: requirement.id.clone(),
        text: lines(&requirement.text),
        rationale: lines(&form.background.rationale),
        status: lines(&form.background.status),
        parents: form.background.parents.clone(),
    })
}
