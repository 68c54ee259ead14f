//! The same episodes in two physics engines, and how far they differ; or whether each engine repeats itself, by hashes.

mod compared;
mod determinism;
mod report;

pub use determinism::Repeated;
pub use report::{EngineFailures, EnginesReport, SignalReport, VerdictPair, VerdictReport};

use crate::technique::simulation::{Campaign, Seeds};
use compared::Called;
use diagnostic::Problem;
use host::Host;
use std::path::PathBuf;
use study::{Entry, Simulated, Study};

/// Episodes to be run in two engines. [`EnginesRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct EnginesRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// The ledger's entry whose scene is simulated.
    pub evidence: String,
    /// How many episodes.
    pub episodes: u64,
    /// The seed; by default the study's.
    pub seed: Option<u64>,
    /// Compares the hashes of repeated and of continued episodes instead. An entry that is no scene can be asked for this alone.
    pub determinism: bool,
}

impl EnginesRequest {
    /// Five episodes of this entry of the study in this folder, in both engines.
    pub fn new(study: impl Into<PathBuf>, evidence: impl Into<String>) -> Self {
        Self {
            study: study.into(),
            evidence: evidence.into(),
            episodes: 5,
            seed: None,
            determinism: false,
        }
    }
}

/// Runs the same episodes (test, seeds, controllers) in MuJoCo and in Rapier and compares recordings and verdicts; or runs each
/// episode again, and saves it in its middle and continues it, and compares the hashes.
///
/// # Errors
/// What the study's files say wrong; `one-engine` and `not-a-simulation` if the entry cannot be run so; `interrupted` if the
/// host was asked to stop; `no-physics-library` if episodes cannot be simulated here.
pub fn engines(request: &EnginesRequest, host: &Host) -> Result<EnginesReport, Problem> {
    let study = Study::load(&request.study)?;
    let entry = study.entry(&request.evidence)?;
    let campaigns = campaigns(&study, entry, request.determinism, host)?;
    let called = Called {
        study: &study,
        entry,
        campaigns: &campaigns,
        numbers: (1..=request.episodes).collect(),
        seeds: Seeds::new(request.seed.unwrap_or(study.about.seed), &entry.id),
        host,
    };
    let mut report = EnginesReport {
        format: "1.1".into(),
        evidence: entry.id.clone(),
        engines: campaigns.iter().map(name_of).collect(),
        episodes: request.episodes,
        signals: Vec::new(),
        verdicts: Vec::new(),
        failures: Vec::new(),
        repeated: Vec::new(),
        fail_alike: true,
    };
    match request.determinism {
        true => report.repeated = called.repeat()?,
        false => called.compare(&mut report)?,
    }
    Ok(report)
}

/// An entry that only one engine can run.
pub fn one_engine(entry: &Entry) -> Problem {
    Problem::new(
        "one-engine",
        format!(
            "`{}` is no scene, and the second engine runs scenes only; the handover's contacts, servos and short cuts are written for MuJoCo",
            entry.id
        ),
    )
    .remedy("name an entry of the ledger with a `scene`")
}

/// The entry in each engine; MuJoCo alone if repetition is all that is asked.
fn campaigns(
    study: &Study,
    entry: &Entry,
    determinism: bool,
    host: &Host,
) -> Result<Vec<Campaign>, Problem> {
    let library = host.physics_library.as_deref();
    match entry.work.simulated() {
        Some(Simulated::Scene { scene, test }) => {
            let first = Campaign::of_scene(study, scene, test, library)?;
            for gap in first.gaps() {
                host.events.say(&gap.to_string());
            }
            let second = Campaign::of_scene_in_rapier(study, scene, test)?;
            Ok(vec![first, second])
        }
        Some(Simulated::Handover {
            scenario,
            parameters,
        }) if determinism => Ok(vec![Campaign::new(study, scenario, parameters, library)?]),
        Some(Simulated::Handover { .. }) => Err(one_engine(entry)),
        Some(Simulated::Command(_)) | None => Err(Problem::new(
            "not-a-simulation",
            format!("`{}` is no simulation of this test bench", entry.id),
        )
        .remedy("name an entry of the ledger with a scene")),
    }
}

fn name_of(campaign: &Campaign) -> String {
    let tool = campaign.tool();
    format!("{} {}", tool.name, tool.version)
}
