//! Where formal model and bench differ, as a map of contexts.

use super::{bench_of, folder_of, plan_of, study_of, write};
use crate::kept::DISAGREEMENT;
use crate::results::json;
use crate::technique::exploration::MapSearch;
use diagnostic::Problem;
use evidence::DisagreementMap;
use host::Host;
use std::path::PathBuf;

/// A search for contexts in which model and bench differ. [`DisagreementRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct DisagreementRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// The file that says how to explore, relative to the study.
    pub file: PathBuf,
    /// Episodes, at most; by default those of the file.
    pub episodes: Option<u64>,
    /// The seed; by default the study's.
    pub seed: Option<u64>,
    /// Where results go; by default to the folder `results/exploration` of the study.
    pub out: Option<PathBuf>,
}

impl DisagreementRequest {
    /// As the file of the study in this folder says.
    pub fn new(study: impl Into<PathBuf>, file: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            file: file.into(),
            episodes: None,
            seed: None,
            out: None,
        }
    }
}

/// Divides all declared contexts into regions in which model and bench differ, agree within the margin, or are undecided, each
/// decided by fresh episodes of the full physics, and writes `disagreement.json`. What an earlier call has run is in its journal
/// and is not run again.
///
/// # Errors
/// Those of [`explore()`](super::explore()).
pub fn map_disagreement(
    request: &DisagreementRequest,
    host: &Host,
) -> Result<DisagreementMap, Problem> {
    let study = study_of(&request.study, request.seed, host)?;
    let plan = plan_of(&study, &request.file, request.episodes)?;
    let bench = bench_of(&study, &plan, true, host)?;
    let folder = folder_of(&study, request.out.as_deref());
    let search = MapSearch {
        study: &study,
        plan: &plan,
        bench: &bench,
        folder: &folder,
    };
    let report = search.go_on(host)?;
    write(&folder.join(DISAGREEMENT), &json(&report)?, host)?;
    Ok(report)
}
