//! A study's episodes on several machines: each runs a shard of them, and what they leave is merged.
//!
//! # Definition
//! [`shard()`] runs the episodes of one of `n` shards of every simulation of a study ([`crate::technique::campaign::numbers_of`]) into a
//! folder of its own, and compares nothing. [`merge()`] takes the episodes of such folders over into the study's results,
//! after which [`crate::run()`] produces the evidence without simulating them again. Any batch system that starts the one with a
//! number and copies folders to the other will do: there is no server, and nothing but files passes.
//!
//! # Assumes
//! That machines with the same build of this program and the same physics library compute the same bits; episodes that
//! several shards have are held against each other.
//!
//! # Guarantee
//! Evidence, counts and journal are those of one machine, byte for byte, whatever the number of shards, also where a stopping rule ends
//! the campaign. A shard of other files, another seed, other settings or another build is refused.

use crate::outcome::{Ended, Outcome};
use crate::results::results_folder;
use crate::rigs;
use crate::technique::campaign::{self, Campaigning, Until, numbers_of};
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use host::Host;
use host::store::{Store, is_stage_of};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use study::{Entry, Study};

/// The file of a shard's folder that says what was run there.
pub const SHARD: &str = "shard.json";

/// Shards of one campaign, at most.
pub const MOST_SHARDS: u64 = 1_000_000;

/// A shard of a study's episodes to be run. [`ShardRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct ShardRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Which shard, from 1.
    pub shard: u64,
    /// Of how many.
    pub of: u64,
    /// Where its episodes go. A folder that holds some of the same shard is gone on with.
    pub out: PathBuf,
    /// The simulations that are run; all if there are none.
    pub only: Vec<String>,
}

impl ShardRequest {
    /// The shard `shard` of `of` of all simulations of this study.
    pub fn new(
        study: impl Into<PathBuf>,
        (shard, of): (u64, u64),
        out: impl Into<PathBuf>,
    ) -> Self {
        Self {
            study: study.into(),
            shard,
            of,
            out: out.into(),
            only: Vec::new(),
        }
    }
}

/// What a shard ran, and on what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShardReport {
    /// Version of this form.
    pub format: String,
    /// The study's title.
    pub study: String,
    /// Which shard it is, from 1.
    pub shard: u64,
    /// Of how many.
    pub of: u64,
    /// The build of the program.
    pub build: String,
    /// The kind of processor and the system for which the program was built, as Rust calls them.
    pub system: String,
    /// What was run, in the order of the ledger.
    pub campaigns: Vec<ShardOfCampaign>,
}

/// The part of one simulation's episodes that a shard ran.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShardOfCampaign {
    /// The ledger's entry.
    pub evidence: String,
    /// The simulator with its version.
    pub simulator: String,
    /// The number of its first episode.
    pub first: u64,
    /// How many episodes.
    pub episodes: u64,
    /// Elapsed time in seconds.
    pub wall_secs: f64,
    /// Processor seconds, where they are known.
    pub cpu_secs: Option<f64>,
}

/// Folders of shards whose episodes are taken over. [`MergeRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct MergeRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// The folders of shards, in any order; more than one may have the same episodes.
    pub shards: Vec<PathBuf>,
    /// Where the study's results are; by default its folder `results`.
    pub out: Option<PathBuf>,
}

impl MergeRequest {
    /// These shards, into the results of this study.
    pub fn new(study: impl Into<PathBuf>, shards: Vec<PathBuf>) -> Self {
        Self {
            study: study.into(),
            shards,
            out: None,
        }
    }
}

/// What was merged.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct MergeReport {
    /// Version of this form.
    pub format: String,
    /// By simulation, in the order of the ledger.
    pub campaigns: Vec<MergedCampaign>,
    /// What the shards say of themselves, in the order in which they were named.
    pub shards: Vec<ShardReport>,
}

/// What one simulation took over.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct MergedCampaign {
    /// The ledger's entry.
    pub evidence: String,
    /// How many episodes it asks for.
    pub asked: u64,
    /// Episodes that it had before.
    pub known: u64,
    /// Episodes that were taken from shards.
    pub taken: u64,
    /// Of these, how many several shards have, the same.
    pub repeated: u64,
    /// The first that is in no shard, and the last before the next that is.
    pub missing: Option<[u64; 2]>,
    /// Whether its stopping rule has ended it, so that no more are needed.
    pub is_decided: bool,
}

/// Whether all episodes are there that are needed.
impl Ended for MergeReport {
    fn outcome(&self) -> Outcome {
        match self.campaigns.iter().any(|it| it.missing.is_some()) {
            true => Outcome::DataLost,
            false => Outcome::Holds,
        }
    }
}

/// Runs the episodes of a shard. What it has is continued where an earlier call was interrupted.
///
/// # Errors
/// What the study's files say wrong; `bad-shard`; `nothing-to-shard` if the study simulates nothing; `interrupted`, after which the
/// same request goes on.
pub fn shard(request: &ShardRequest, host: &Host) -> Result<ShardReport, Problem> {
    if request.shard == 0 || request.shard > request.of || request.of > MOST_SHARDS {
        let message = format!("there is no shard {} of {}", request.shard, request.of);
        return Err(Problem::new("bad-shard", message).remedy(format!(
            "name one of 1/N to N/N, where N is at most {MOST_SHARDS}"
        )));
    }
    let study = Study::load_for(&request.study, &host.trust)?;
    let entries = simulations(&study, &request.only)?;
    let store = Store::open(&request.out)?;
    let mut campaigns = Vec::new();
    for entry in entries {
        campaigns.push(run_of(&study, entry, request, (&store, host))?);
    }
    let report = ShardReport {
        format: "1.0".into(),
        study: study.about.title.clone(),
        shard: request.shard,
        of: request.of,
        build: host.build.as_str().to_owned(),
        system: env!("CORROBORATE_TARGET").to_owned(),
        campaigns,
    };
    let text = serde_json::to_vec_pretty(&report);
    let text = text.map_err(|error| Problem::data_lost("cannot-write", error.to_string()))?;
    store.write(SHARD, &text)?;
    Ok(report)
}

/// The entries whose episodes can be run apart.
fn simulations<'s>(study: &'s Study, only: &[String]) -> Result<Vec<&'s Entry>, Problem> {
    for id in only {
        let entry = study.entry(id)?;
        if entry.work.simulated().is_none() {
            return Err(Problem::new(
                "not-a-simulation",
                format!("`{id}` has no episodes to be run"),
            )
            .remedy("name simulations alone; `corroborate run` produces the rest in a moment"));
        }
    }
    let is_asked = |entry: &&Entry| only.is_empty() || only.contains(&entry.id);
    let all = study.ledger.iter().filter(is_asked);
    let found: Vec<&Entry> = all.filter(|it| it.work.simulated().is_some()).collect();
    match found.is_empty() {
        true => Err(
            Problem::new("nothing-to-shard", "the study simulates no episodes")
                .at(&study.ledger_source, 0..0)
                .remedy("run it as a whole: `corroborate run`"),
        ),
        false => Ok(found),
    }
}

fn run_of(
    study: &Study,
    entry: &Entry,
    request: &ShardRequest,
    (store, host): (&Store, &Host),
) -> Result<ShardOfCampaign, Problem> {
    let rig = rigs::of_entry(study, entry, host)?;
    let rig = rig.as_ref();
    let numbers = numbers_of(request.shard, request.of, entry.work.episodes());
    let inputs = campaign::episode_inputs(study, entry, rig, host.build.as_str());
    let folder = store.stage(&stage_of(&entry.id), &inputs.hash())?;
    let episodes = numbers.end - numbers.start;
    let title = format!(
        "{}: episodes {} to {}",
        entry.id,
        numbers.start,
        numbers.end - 1
    );
    let tool = rig.tool();
    let mut run = ShardOfCampaign {
        evidence: entry.id.clone(),
        simulator: format!("{} {}", tool.name, tool.version)
            .trim_end()
            .to_owned(),
        first: numbers.start,
        episodes,
        wall_secs: 0.0,
        cpu_secs: None,
    };
    if episodes == 0 {
        return Ok(run);
    }
    let stage = host.events.begin(&title, episodes);
    let plan = Campaigning {
        study,
        id: &entry.id,
        rig,
        seeds: Seeds::new(study.about.seed, entry.seeded_as()),
        numbers,
        keep: entry.sampling.keep,
        early_end: entry.sampling.early_end,
        on_failure: entry.sampling.on_failure,
        // Where a rule ends it follows from the episodes of all shards.
        until: None,
        folder: &folder,
        judged_by: campaign::judged_by(study, rig, host.build.as_str()),
        interrupt: &host.cancel,
        stage: &stage,
    };
    let cost = plan.run()?.cost;
    // A shard that was there already took no time now, and keeps what it took.
    let before = known(&request.out).and_then(|it| it.of(&entry.id).cloned());
    (run.wall_secs, run.cpu_secs) = match before {
        Some(before) if before.episodes == episodes && cost.cpu_secs == Some(0.0) => {
            (before.wall_secs, before.cpu_secs)
        }
        _ => (cost.wall_secs, cost.cpu_secs),
    };
    Ok(run)
}

/// Where the episodes of an entry lie below results.
fn stage_of(id: &str) -> String {
    format!("episodes/{id}")
}

/// What an earlier call has said of a shard.
fn known(folder: &Path) -> Option<ShardReport> {
    let bytes = host::files::read_file(&folder.join(SHARD), 1 << 24).ok()?;
    serde_json::from_slice(&bytes).ok()
}

impl ShardReport {
    fn of(&self, id: &str) -> Option<&ShardOfCampaign> {
        self.campaigns.iter().find(|it| it.evidence == id)
    }
}

/// Takes the episodes of shards over into a study's results. The shards stay as they are, so a merge that was interrupted, or that
/// found some missing, is done again.
///
/// # Errors
/// What the study's files say wrong; `no-shard` for a folder that is none; `other-shard` for one of another study, seed or build;
/// `shards-differ`, `other-seed` and `other-recording` for episodes that are not what they say; `interrupted`.
pub fn merge(request: &MergeRequest, host: &Host) -> Result<MergeReport, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    let shards = request.shards.iter().map(|folder| {
        known(folder).ok_or_else(|| {
            let message = format!("{} is not the folder of a shard that is complete", folder.display());
            Problem::new("no-shard", message).remedy(
                "name folders that `corroborate run STUDY --shard K/N --out FOLDER` wrote; what was interrupted is continued by the same command",
            )
        })
    });
    let shards: Vec<ShardReport> = shards.collect::<Result<_, _>>()?;
    let store = Store::open(&results_folder(&request.study, request.out.as_deref()))?;
    let mut campaigns = Vec::new();
    for entry in simulations(&study, &[])? {
        if shards.iter().any(|it| it.of(&entry.id).is_some()) {
            campaigns.push(merged(&study, entry, (request, &shards), (&store, host))?);
        }
    }
    Ok(MergeReport {
        format: "1.0".into(),
        campaigns,
        shards,
    })
}

fn merged(
    study: &Study,
    entry: &Entry,
    (request, shards): (&MergeRequest, &[ShardReport]),
    (store, host): (&Store, &Host),
) -> Result<MergedCampaign, Problem> {
    let rig = rigs::of_entry(study, entry, host)?;
    let rig = rig.as_ref();
    let inputs = campaign::episode_inputs(study, entry, rig, host.build.as_str()).hash();
    let own = request.shards.iter().zip(shards);
    let own = own.filter_map(|(folder, shard)| Some((folder, shard, shard.of(&entry.id)?)));
    let (mut folders, mut wall_secs) = (Vec::new(), 0.0);
    for (folder, shard, run) in own {
        let place = folder.join(stage_of(&entry.id));
        if run.episodes > 0 && !is_stage_of(&place, &inputs) {
            return Err(other_shard(&place, shard, host));
        }
        if place.is_dir() {
            folders.push(place);
        }
        wall_secs += run.wall_secs;
    }
    let folder = store.stage(&stage_of(&entry.id), &inputs)?;
    let asked = entry.work.episodes();
    let rule = entry.sampling.until.as_ref();
    let until = rule
        .map(|rule| Until::new(study, entry, rule))
        .transpose()?;
    let stage = host
        .events
        .begin(&format!("{}: merged episodes", entry.id), asked);
    let plan = Campaigning {
        study,
        id: &entry.id,
        rig,
        seeds: Seeds::new(study.about.seed, entry.seeded_as()),
        numbers: 1..asked + 1,
        keep: entry.sampling.keep,
        early_end: entry.sampling.early_end,
        on_failure: entry.sampling.on_failure,
        until: until.as_ref(),
        folder: &folder,
        judged_by: campaign::judged_by(study, rig, host.build.as_str()),
        interrupt: &host.cancel,
        stage: &stage,
    };
    let found = plan.take_over(&folders, wall_secs)?;
    Ok(MergedCampaign {
        evidence: entry.id.clone(),
        asked,
        known: found.known,
        taken: found.taken,
        repeated: found.repeated,
        missing: found.missing.map(|it| [it.start, it.end - 1]),
        is_decided: found.is_decided,
    })
}

/// Why the episodes of a shard are not those of the study.
fn other_shard(place: &Path, shard: &ShardReport, host: &Host) -> Problem {
    let build = host.build.as_str();
    let (message, remedy) = match shard.build == build {
        true => (
            format!(
                "{} holds episodes of something else: its files, seed or settings are not the study's",
                place.display()
            ),
            "run the shard again with the study as it is now, or merge with the study as it was",
        ),
        false => (
            format!(
                "{} was made by another build of the program ({}, here {build})",
                place.display(),
                shard.build
            ),
            "use one build on all machines, and run the shard again",
        ),
    };
    Problem::new("other-shard", message).remedy(remedy)
}
