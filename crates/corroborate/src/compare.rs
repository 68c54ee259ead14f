//! The comparisons of a study that has been run.

use crate::results::{read_current_result, results_folder};
use diagnostic::Problem;
use evidence::{Comparison, StudyResult};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Which comparisons are asked for. [`CompareRequest::new`] asks for all.
#[derive(Clone, Debug)]
pub struct CompareRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Where its results are; by default in the folder `results` of the study.
    pub out: Option<PathBuf>,
    /// With one identifier the pairs of this evidence; with more the pairs among them; all pairs without any.
    pub evidence: Vec<String>,
}

impl CompareRequest {
    /// All pairs of the study in this folder, with results in its folder `results`.
    pub fn new(study: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            out: None,
            evidence: Vec::new(),
        }
    }

    /// With a piece of evidence among those whose pairs are asked for.
    #[must_use]
    pub fn evidence(mut self, id: impl Into<String>) -> Self {
        self.evidence.push(id.into());
        self
    }

    /// With one identifier: its pairs. With more: the pairs among them.
    fn asks_for(&self, comparison: &Comparison) -> bool {
        let named = |id: &String| self.evidence.contains(id);
        match self.evidence.len() {
            0 => true,
            1 => named(&comparison.left) || named(&comparison.right),
            _ => named(&comparison.left) && named(&comparison.right),
        }
    }
}

/// What `compare --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CompareReport {
    /// Version of this form.
    pub format: String,
    /// The pairs that were asked for.
    pub comparisons: Vec<Comparison>,
    /// What the subjects of the study are called, by their identifiers.
    #[serde(skip)]
    names: BTreeMap<String, String>,
}

impl CompareReport {
    /// A requirement's identifier and text, or a failure mode's name.
    pub fn heading<'r>(&'r self, subject: &'r str) -> &'r str {
        self.names.get(subject).map_or(subject, String::as_str)
    }
}

/// The comparisons of a study's last run.
///
/// # Errors
/// `not-run` without a run, `stale-result` if the study's files have changed since, `unknown-evidence` if the ledger has
/// no such evidence.
pub fn compare(request: &CompareRequest) -> Result<CompareReport, Problem> {
    let folder = results_folder(&request.study, request.out.as_deref());
    let result = read_current_result(&request.study, &folder)?;
    let known = |id: &String| result.evidence.iter().any(|e| &e.id == id);
    if let Some(unknown) = request.evidence.iter().find(|id| !known(id)) {
        let ids: Vec<&str> = result.evidence.iter().map(|e| e.id.as_str()).collect();
        return Err(Problem::new(
            "unknown-evidence",
            format!("the ledger has no evidence `{unknown}`"),
        )
        .remedy(format!("it has {}", ids.join(", "))));
    }
    let names = names(&result);
    let mut comparisons = result.comparisons;
    comparisons.retain(|comparison| request.asks_for(comparison));
    Ok(CompareReport {
        format: "1.0".into(),
        comparisons,
        names,
    })
}

fn names(result: &StudyResult) -> BTreeMap<String, String> {
    let modes = result.failure_modes.iter();
    let modes = modes.map(|mode| (mode.id.clone(), mode.name.clone()));
    let requirements = result.requirements.iter();
    // A requirement goes before a failure mode of the same identifier.
    let requirements = requirements.map(|it| (it.id.clone(), format!("{}  {}", it.id, it.text)));
    modes.chain(requirements).collect()
}
