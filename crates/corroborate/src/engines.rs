//! The same episodes in two physics engines, and how far they differ; or whether each engine repeats itself, by hashes.

mod compared;
mod determinism;
mod report;

pub use determinism::Repeated;
pub use report::{
    EngineFailures, EnginesReport, SignalKind, SignalReport, VerdictPair, VerdictReport,
};

use crate::rigs;
use crate::technique::simulation::Seeds;
use compared::Called;
use diagnostic::Problem;
use host::Host;
use rig::Rig;
use std::collections::BTreeMap;
use std::path::PathBuf;
use study::{Entry, Study};

/// Episodes to be run in two engines. [`EnginesRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct EnginesRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// The ledger's entry whose scene or scenario is simulated.
    pub evidence: String,
    /// How many episodes.
    pub episodes: u64,
    /// The seed; by default the study's.
    pub seed: Option<u64>,
    /// Compares the hashes of repeated and of continued episodes instead. A command can be asked for this, and be
    /// run against another.
    pub determinism: bool,
    /// Another entry of the ledger, of any simulator, in place of the second engine.
    pub against: Option<String>,
    /// By how much numbers may differ, by signal (`/topic.field`), in its unit: they are ordered by it.
    pub tolerances: BTreeMap<String, f64>,
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
            against: None,
            tolerances: BTreeMap::new(),
        }
    }
}

/// Runs the same episodes (test, seeds, controllers) in the engine that the entry says and in the other one, MuJoCo and Rapier, or as two entries of the ledger have them, and
/// compares recordings and verdicts; or runs each episode again, and saves it in its middle and continues it, and compares the
/// hashes. Of two entries both have the seeds of the first.
///
/// # Errors
/// What the study's files say wrong; `one-engine` and `not-a-simulation` if the entry cannot be run so; `interrupted` if the
/// host was asked to stop; `no-physics-library` if episodes cannot be simulated here.
pub fn engines(request: &EnginesRequest, host: &Host) -> Result<EnginesReport, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    let entry = study.entry(&request.evidence)?;
    let (rigs, names) = match &request.against {
        Some(other) => two_entries(&study, [entry, study.entry(other)?], host)?,
        None => in_engines(&study, entry, request.determinism, host)?,
    };
    let called = Called {
        study: &study,
        entry,
        rigs: &rigs,
        names: &names,
        numbers: (1..=request.episodes).collect(),
        tolerances: &request.tolerances,
        seeds: Seeds::new(request.seed.unwrap_or(study.about.seed), entry.seeded_as()),
        host,
    };
    let mut report = EnginesReport {
        format: "1.2".into(),
        evidence: entry.id.clone(),
        engines: names.clone(),
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

/// The entry in each engine that can run it; both, unless repetition is all that is asked.
fn in_engines(
    study: &Study,
    entry: &Entry,
    determinism: bool,
    host: &Host,
) -> Result<Named, Problem> {
    let is_simulation = match determinism {
        true => entry.work.simulated().is_some(),
        false => entry.work.is_simulated_here(),
    };
    if !is_simulation {
        let message = format!("`{}` is not simulated by this test bench", entry.id);
        return Err(Problem::new("not-a-simulation", message).remedy(
            "name an entry of the ledger with a scene or a scenario, or a second entry to run it against (`--against`)",
        ));
    }
    let second = match rigs::in_other_engine(study, entry, host) {
        Err(problem) if determinism && problem.code == "one-engine" => None,
        second => Some(second?),
    };
    let first = rigs::of_entry(study, entry, host)?;
    say_gaps(first.as_ref(), host);
    let rigs: Vec<Box<dyn Rig>> = std::iter::once(first).chain(second).collect();
    let names = rigs.iter().map(|rig| name_of(rig.as_ref())).collect();
    Ok((rigs, names))
}

/// Rigs, and what each is called.
type Named = (Vec<Box<dyn Rig>>, Vec<String>);

/// Two entries of the ledger, called by their identifiers.
fn two_entries(study: &Study, entries: [&Entry; 2], host: &Host) -> Result<Named, Problem> {
    let mut named = Named::default();
    for entry in entries {
        if entry.work.simulated().is_none() {
            let message = format!("`{}` is not a simulation", entry.id);
            return Err(Problem::new("not-a-simulation", message)
                .remedy("name entries of the ledger with a scene, a scenario or a command"));
        }
        let rig = rigs::of_entry(study, entry, host)?;
        say_gaps(rig.as_ref(), host);
        named.0.push(rig);
        named.1.push(entry.id.clone());
    }
    Ok(named)
}

fn say_gaps(rig: &dyn Rig, host: &Host) {
    for gap in rig.gaps() {
        host.events.say(&gap.to_string());
    }
}

fn name_of(rig: &dyn Rig) -> String {
    let tool = rig.tool();
    format!("{} {}", tool.name, tool.version)
        .trim_end()
        .to_owned()
}
