//! Which studies this machine's user has allowed, and whether one is.

use super::content::{Content, whole};
use super::programs::{NamedProgram, programs};
use super::{Basis, records_of, store};
use diagnostic::Problem;
use host::Host;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The file that makes a folder a study.
const ABOUT: &str = "study.toml";

/// That a study is allowed.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// The study's folder, without links.
    pub study: PathBuf,
    /// Whether it is allowed whatever it contains.
    pub always: bool,
    /// Its files as they were allowed, with their hashes.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
}

/// What was allowed.
#[derive(Clone, Debug)]
pub struct Allowed {
    /// The study's folder.
    pub study: PathBuf,
    /// Every program that it names.
    pub programs: Vec<NamedProgram>,
    /// Of how many files the content is; `None` if it is allowed whatever it contains.
    pub files: Option<usize>,
}

/// The programs that a study names, and of how many files its content is.
///
/// # Errors
/// `no-study`, `cannot-read`, `link-leads-out`, `too-many-files`.
pub fn look(study: &Path) -> Result<Allowed, Problem> {
    let folder = folder_of(study)?;
    let content = Content::of(&folder)?;
    Ok(Allowed {
        programs: programs(&folder, &content)?,
        study: folder,
        files: Some(content.files.len()),
    })
}

/// Allows the programs of a study: with the content that it has, or whatever it contains.
///
/// # Errors
/// `no-study`, `no-records-of-trust`, `records-in-study`, `cannot-read`, `cannot-write`, `link-leads-out`, `too-many-files`.
pub fn allow(study: &Path, always: bool, host: &Host) -> Result<Allowed, Problem> {
    let records = records_of(host)?;
    let folder = folder_of(study)?;
    is_apart(records, &folder)?;
    let content = match (always, Content::of(&folder)) {
        (false, content) => content?,
        // What it contains is not asked; its programs are shown as far as they are found.
        (true, content) => content.unwrap_or_default(),
    };
    let allowed = Allowed {
        programs: programs(&folder, &content)?,
        study: folder.clone(),
        files: (!always).then_some(content.files.len()),
    };
    let record = Record {
        study: folder.clone(),
        always,
        files: match always {
            true => BTreeMap::new(),
            false => content.files,
        },
    };
    store::write(&store::file_of(records, &folder), &record)?;
    Ok(allowed)
}

/// Allows a study that its user has just had made, whatever it will contain, unless all studies there are allowed.
///
/// # Errors
/// As [`allow`].
pub fn own(study: &Path, host: &Host) -> Result<(), Problem> {
    match is_given(&whole(study)?, host) {
        true => Ok(()),
        false => allow(study, true, host).map(drop),
    }
}

/// Whether the user has said for this call, or for a folder around the study, that programs may run.
fn is_given(folder: &Path, host: &Host) -> bool {
    let around = |it: &PathBuf| it.canonicalize().is_ok_and(|it| folder.starts_with(it));
    host.trust.is_given || host.trust.folders.iter().any(around)
}

/// A study's folder, without links.
fn folder_of(study: &Path) -> Result<PathBuf, Problem> {
    let about = study.join(ABOUT);
    if about.is_file() {
        return whole(study);
    }
    let message = format!("not a study: {} does not exist", about.display());
    Err(Problem::new("no-study", message).remedy("make a study with `corroborate init FOLDER`"))
}

/// Takes back that a study is allowed; whether it was. Its folder need not be there any more.
///
/// # Errors
/// `no-records-of-trust`, `cannot-write`.
pub fn revoke(study: &Path, host: &Host) -> Result<bool, Problem> {
    let folder = whole(study).unwrap_or_else(|_| study.to_owned());
    store::remove(&store::file_of(records_of(host)?, &folder))
}

/// All studies that are allowed.
///
/// # Errors
/// `no-records-of-trust`.
pub fn allowed(host: &Host) -> Result<Vec<Record>, Problem> {
    Ok(store::all(records_of(host)?))
}

/// A record in a study could be brought by the study.
fn is_apart(records: &Path, study: &Path) -> Result<(), Problem> {
    let mut records = records.to_owned();
    // It may not be there yet, but what it is to be made in is.
    while !records.exists() && records.pop() {}
    let records = records.canonicalize().unwrap_or(records);
    match records.starts_with(study) {
        false => Ok(()),
        true => Err(Problem::new(
            "records-in-study",
            format!(
                "which studies are allowed is kept in {}, which lies in the study {}",
                records.display(),
                study.display()
            ),
        )
        .remedy("set XDG_STATE_HOME to a folder that is part of no study")),
    }
}

/// On which basis programs of a study may run that `file` of it names.
///
/// # Errors
/// Why they may not, in words.
pub(super) fn basis(study: &Path, file: &Path, host: &Host) -> Result<Basis, String> {
    let folder = whole(study).map_err(|problem| problem.line())?;
    if is_given(&folder, host) {
        return Ok(Basis::Whole);
    }
    let record = match &host.trust.records {
        Some(records) => {
            is_apart(records, &folder).map_err(|problem| problem.line())?;
            store::read(&store::file_of(records, &folder))?
        }
        None => None,
    };
    let Some(record) = record.filter(|it| it.study == folder) else {
        return Err("this study was not allowed to run programs on this machine".into());
    };
    match record.always {
        true => Ok(Basis::Whole),
        false => as_allowed(record, &folder, file),
    }
}

fn as_allowed(record: Record, folder: &Path, file: &Path) -> Result<Basis, String> {
    let then = Content {
        files: record.files,
    };
    let now = Content::of(folder).map_err(|problem| problem.line())?;
    if then != now {
        return Err(format!(
            "this study has changed since it was allowed ({})",
            then.changes_to(&now)
        ));
    }
    match now.has(folder, file) {
        true => Ok(Basis::Content),
        false => Err(format!(
            "it is named in {}, which is not part of what was allowed",
            file.display()
        )),
    }
}
