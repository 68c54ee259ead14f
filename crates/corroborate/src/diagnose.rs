//! Which asset is to blame for what disagrees in a study that has been run, and one sampled path of a formal model to look
//! at.

use crate::kept::DIAGNOSIS;
use crate::results::{REPORT, RESULT, json, read_current_result, results_folder};
use crate::technique::matrix::{self, ModelPaths, as_text, path_seeds};
use crate::technique::model_checking::worst_cases_in_lines;
use diagnostic::Problem;
use evidence::{Diagnosis, Effort, StudyResult};
use host::Host;
use host::store::Store;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use study::Study;

/// A diagnosis. [`DiagnoseRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct DiagnoseRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Where its results are; by default in the folder `results` of the study.
    pub out: Option<PathBuf>,
    /// How much is looked at.
    pub effort: Effort,
}

impl DiagnoseRequest {
    /// Of the study in this folder: 1000 paths of each formal model, 1000 recordings of each simulation, nothing run again.
    pub fn new(study: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            out: None,
            effort: Effort {
                paths: 1000,
                half_step: None,
                engines: None,
                runs: Some(1000),
            },
        }
    }

    /// With results in another folder.
    #[must_use]
    pub fn out(mut self, folder: impl Into<PathBuf>) -> Self {
        self.out = Some(folder.into());
        self
    }

    /// With another effort.
    #[must_use]
    pub fn effort(mut self, effort: Effort) -> Self {
        self.effort = effort;
        self
    }
}

/// Diagnoses a study that has been run, and adds the diagnosis to its results: `diagnosis.json` and `study.json`.
///
/// # Errors
/// `not-run` without a run, `stale-result` if the study's files have changed since, `results-in-use` if another process
/// writes to the same folder, `interrupted` if the host was asked to stop.
pub fn diagnose(request: &DiagnoseRequest, host: &Host) -> Result<Diagnosis, Problem> {
    carried_out(request, host, None)
}

/// The same, with the page that `draw` makes of the result written beside it.
///
/// # Errors
/// Those of [`diagnose()`].
pub fn diagnose_with_page(
    request: &DiagnoseRequest,
    host: &Host,
    draw: &dyn Fn(&StudyResult) -> String,
) -> Result<Diagnosis, Problem> {
    carried_out(request, host, Some(draw))
}

fn carried_out(
    request: &DiagnoseRequest,
    host: &Host,
    draw: Option<&dyn Fn(&StudyResult) -> String>,
) -> Result<Diagnosis, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    let folder = results_folder(&request.study, request.out.as_deref());
    let mut result = read_current_result(&request.study, &folder)?;
    for piece in &result.evidence {
        for line in worst_cases_in_lines(&piece.id, &piece.findings) {
            host.events.say(&line);
        }
    }
    let store = Store::open(&folder)?;
    let diagnosis = matrix::diagnose(&study, &result, &folder, &request.effort, host)?;
    store.keep(DIAGNOSIS, &diagnosis.inputs, &diagnosis)?;
    result.diagnosis = Some(diagnosis.clone());
    store.write(RESULT, json(&result)?.as_bytes())?;
    if let Some(draw) = draw {
        store.write(REPORT, draw(&result).as_bytes())?;
    }
    Ok(diagnosis)
}

/// A diagnosis for people; `study` is how the user named it.
pub fn in_words(diagnosis: &Diagnosis, study: &Path) -> String {
    as_text(diagnosis, &study.display().to_string())
}

/// A sampled path of a formal model, of those that a diagnosis judges.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SampledPath {
    /// The evidence of whose model it is.
    pub evidence: String,
    /// Its number, from 1.
    pub number: u64,
    /// The steps that change what holds.
    pub steps: Vec<PathStep>,
}

/// A step that changes what holds.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct PathStep {
    /// Its number, from 0.
    pub step: usize,
    /// The model's state.
    pub state: String,
    /// What holds.
    pub holds: Vec<String>,
}

/// The path that is named `EVIDENCE:NUMBER`, as witnesses in a diagnosis are.
///
/// # Errors
/// `bad-path` if no path has the name; `open-choices` if the model leaves choices open; what the study's files say wrong.
pub fn sampled_path(study: &Path, name: &str, host: &Host) -> Result<SampledPath, Problem> {
    let study = Study::load_for(study, &host.trust)?;
    let wrong = || {
        Problem::new(
            "bad-path",
            format!("`{name}` names no path of a formal model"),
        )
        .remedy("name the evidence and the path's number, from 1: E1:17")
    };
    let (id, number) = name.rsplit_once(':').ok_or_else(wrong)?;
    let number: u64 = number.parse().ok().filter(|n| *n > 0).ok_or_else(wrong)?;
    if study.entry(id)?.work.model().is_none() {
        return Err(wrong());
    }
    let paths = ModelPaths::of_entry(&study, id, &host.cancel)?;
    let steps = paths.shown(path_seeds(study.about.seed, id).of(number));
    let steps = steps.into_iter().map(|it| PathStep {
        step: it.step,
        state: it.state,
        holds: it.holds,
    });
    Ok(SampledPath {
        evidence: id.to_owned(),
        number,
        steps: steps.collect(),
    })
}
