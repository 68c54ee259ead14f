//! The techniques: each turns an entry of the ledger into findings.
//!
//! This is where the engines of the lower floors meet evidence; nothing else
//! knows both.

pub mod campaign;
pub mod copies;
mod counted;
pub mod experiment;
pub mod exploration;
mod files;
pub(crate) mod kinds;
pub mod matrix;
pub mod model_checking;
pub mod operation;
pub mod rows;
mod same_messages;
mod sessions;
pub mod simulation;

pub use counted::CountedConstant;
pub use files::Files;
pub(crate) use kinds::technique_of;
pub use kinds::{Asked, Kept, Prepared, Propositions, Technique, Techniques, Working};
pub use same_messages::RepeatedRecording;
pub(crate) use same_messages::question as repeated_question;

use diagnostic::Problem;
use evidence::{
    AlikeTrials, Asset, AssetRole, ClusterTests, Cost, DescriptionGap, EpisodeFailures, Finding,
    FormDifference, Measure, Tool,
};
pub use rig::asset;
use serde::{Deserialize, Serialize};
use std::path::Path;
use study::{Entry, Study, TableFiles};

/// What a technique found for one entry of the ledger.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Produced {
    /// With which tool.
    pub tool: Tool,
    /// What was found, one for each subject that the technique was asked for.
    pub findings: Vec<Finding>,
    /// Forms of one requirement that do not agree on the same runs.
    #[serde(default)]
    pub form_differences: Vec<FormDifference>,
    /// Episodes that were ended by what is tested, or by its simulator.
    #[serde(default)]
    pub failures: Vec<EpisodeFailures>,
    /// What of robots' descriptions was not simulated.
    #[serde(default)]
    pub description_gaps: Vec<DescriptionGap>,
    /// Clustering, for trials by subject.
    pub clusters: Option<ClusterTests>,
    /// How alike the trials are in groups that nothing declares, where each trial is seen.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alike_trials: Option<AlikeTrials>,
    /// Recordings with the same messages as others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repeated_recordings: Vec<RepeatedRecording>,
    /// What was found without them, unless the ledger says that they are trials of their own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub findings_once: Vec<Finding>,
    /// What a formal model tells of failure modes and requirements.
    pub influences: Vec<Influence>,
    /// What it took.
    pub cost: Cost,
}

/// Whether a failure mode makes runs fail a requirement.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Influence {
    /// The requirement.
    pub requirement: String,
    /// The failure mode.
    pub failure_mode: String,
    /// Whether it does.
    pub bears: bool,
}

/// The files that an entry names, with their hashes.
pub fn assets(study: &Study, entry: &Entry) -> Result<Vec<Asset>, Problem> {
    use AssetRole::{Data, RequirementModel, SystemModel};
    let parts = entry.work.parts();
    let simulated = parts.simulated.map(|it| [it.file(), it.parameters()]);
    let models = simulated.into_iter().flatten().chain([parts.model]);
    let mut files: Vec<(AssetRole, &Path)> =
        models.flatten().map(|path| (SystemModel, path)).collect();
    let tables = parts.tables.into_iter().flat_map(TableFiles::paths);
    files.extend(tables.map(|path| (Data, path)));
    let topics = Path::new("topics.toml");
    if parts.uses_topics && study.folder.join(topics).exists() {
        files.push((RequirementModel, topics));
    }
    files.push((RequirementModel, Path::new("requirements.toml")));
    files.push((RequirementModel, Path::new("vocabulary.toml")));
    files
        .into_iter()
        .map(|(role, path)| asset(&study.folder, role, path))
        .collect()
}

/// The level as `stats` has it. The study's levels were checked when it was
/// loaded.
pub fn confidence(level: f64) -> Result<stats::Confidence, Problem> {
    stats::Confidence::new(level).map_err(|error| Problem::new("bad-level", error.to_string()))
}

/// Findings with their runs that reached no verdict counted both ways, unless the ledger declares that these are missing at
/// random.
pub fn counting_undecided(
    study: &Study,
    entry: &Entry,
    findings: Vec<Finding>,
) -> Result<Vec<Finding>, Problem> {
    if entry.undecided_at_random.is_some() {
        return Ok(findings);
    }
    let level = confidence(study.about.confidence)?;
    let is_anytime = entry.sampling.until.is_some();
    let counted = |sample: stats::Sample| match is_anytime {
        true => Ok(campaign::anytime(sample, level)),
        false => Measure::of_counts(sample, None, level),
    };
    let bad = |error: stats::StatsError| Problem::new("bad-counts", error.to_string());
    let all = findings.into_iter();
    all.map(|finding| match finding.completions {
        // A technique knows better how its trials were counted.
        Some(_) => Ok(finding),
        None => finding.counting_undecided(level, &counted).map_err(bad),
    })
    .collect()
}

/// Counts as a measure, with Wilson's interval at the effective number of
/// trials.
pub fn counts(
    count: u64,
    trials: u64,
    effective_trials: Option<f64>,
    level: stats::Confidence,
) -> Result<Measure, Problem> {
    let bad = |error: stats::StatsError| Problem::new("bad-counts", error.to_string());
    let sample = stats::Sample::new(count, trials).map_err(bad)?;
    Measure::of_counts(sample, effective_trials, level).map_err(bad)
}
