//! A study's assurance case, its provenance, and its evidence as statements that others can sign and check.
//!
//! The argument is read off the result by the face ([`Argued`]), as its page is; the evidence, the statements and the hashes
//! in them are made here.

mod statement;

pub use statement::{EvidencePredicate, File, Statement, StudyPredicate};

use crate::results::{ASSURANCE, REPORT, RESULT, json, read_current_result, results_folder};
use diagnostic::Problem;
use evidence::StudyResult;
use host::files::write_whole;
use schemars::JsonSchema;
use serde::Serialize;
use statement::{about_evidence, about_study};
use std::path::PathBuf;

/// Names of files, with what they hold.
pub type NamedTexts = Vec<(String, String)>;

/// How a face draws what it writes of a result: the engine only holds it against the files, and hashes it.
pub struct Drawing<'d> {
    /// The page.
    pub page: &'d dyn Fn(&StudyResult) -> String,
    /// The argument.
    pub argument: &'d dyn Fn(&StudyResult) -> Argued,
    /// In which file of the case the argument cites the statement about the evidence of this identifier.
    pub statement_file: &'d dyn Fn(&str) -> String,
}

/// The argument of an assurance case, as a face draws it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Argued {
    /// Its files.
    pub files: NamedTexts,
    /// Its elements.
    pub elements: usize,
    /// Those that are undeveloped.
    pub undeveloped: usize,
    /// Those that are defeated.
    pub defeated: usize,
}

/// An assurance case to be written. [`AssureRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct AssureRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Where its results are; by default in the folder `results` of the study.
    pub out: Option<PathBuf>,
    /// Where the case goes; by default to the folder `assurance` of the results.
    pub to: Option<PathBuf>,
}

impl AssureRequest {
    /// Of the study in this folder, written beside its results.
    pub fn new(study: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            out: None,
            to: None,
        }
    }

    /// Written to another folder.
    #[must_use]
    pub fn to(mut self, folder: impl Into<PathBuf>) -> Self {
        self.to = Some(folder.into());
        self
    }
}

/// An assurance case that was written.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct AssureReport {
    /// Where it is.
    pub folder: PathBuf,
    /// The names of its files.
    pub files: Vec<String>,
    /// Elements of its arguments.
    pub elements: usize,
    /// Those that are undeveloped.
    pub undeveloped: usize,
    /// Those that are defeated.
    pub defeated: usize,
}

/// Writes the assurance case of a study that has been run.
///
/// # Errors
/// `not-run` without a run, `stale-result` if the study's files have changed since, `cannot-write`.
pub fn assure(request: &AssureRequest, drawing: &Drawing<'_>) -> Result<AssureReport, Problem> {
    let folder = results_folder(&request.study, request.out.as_deref());
    let result = read_current_result(&request.study, &folder)?;
    let to = request.to.clone();
    let to = to.unwrap_or_else(|| folder.join(ASSURANCE));
    let argued = (drawing.argument)(&result);
    let files = files_with(&result, drawing, argued.files)?;
    for (name, content) in &files {
        write_whole(&to.join(name), content.as_bytes())?;
    }
    Ok(AssureReport {
        folder: to,
        files: files.into_iter().map(|(name, _)| name).collect(),
        elements: argued.elements,
        undeveloped: argued.undeveloped,
        defeated: argued.defeated,
    })
}

/// Names and contents of all files of a result's assurance case.
///
/// # Errors
/// `cannot-write` if something cannot be written as JSON.
pub fn files(result: &StudyResult, drawing: &Drawing<'_>) -> Result<NamedTexts, Problem> {
    files_with(result, drawing, (drawing.argument)(result).files)
}

fn files_with(
    result: &StudyResult,
    drawing: &Drawing<'_>,
    argument: NamedTexts,
) -> Result<NamedTexts, Problem> {
    let mut files = vec![
        (RESULT.to_owned(), json(result)?),
        (REPORT.to_owned(), (drawing.page)(result)),
    ];
    files.extend(argument);
    let whole = about_study(result, &files);
    files.push(("study.intoto.json".to_owned(), json(&whole)?));
    for piece in &result.evidence {
        let name = format!("evidence/{}.json", piece.id);
        let content = json(piece)?;
        let statement = about_evidence(result, piece, (&name, &content));
        let cited = (drawing.statement_file)(&piece.id);
        files.push((cited, json(&statement)?));
        files.push((name, content));
    }
    Ok(files)
}
