//! Episodes that are meant to show what nobody has thought of, what they found, and what brought it about; or the contexts in
//! which formal model and bench differ.

mod causes;
mod disagreement;
mod keeping;
mod names;
mod search;

pub use disagreement::{DisagreementRequest, map_disagreement};

use crate::kept::{EXPLORATION, sealed};
use crate::technique::exploration::{ExplorationReport, Explored, OpenBench, Plan, SourceKind};
use crate::technique::rows;
use causes::Causes;
use diagnostic::Problem;
use evidence::Stopped;
use host::Host;
use host::files::write_whole;
use keeping::Keeping;
use search::Search;
use std::path::{Path, PathBuf};
use study::Study;

/// An exploration. [`ExploreRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct ExploreRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// The file that says how to explore, relative to the study.
    pub file: PathBuf,
    /// Episodes, at most; by default the file's budget.
    pub episodes: Option<u64>,
    /// The sources of tests; those of the file if there are none.
    pub sources: Vec<SourceKind>,
    /// Runs the bench's own tests as they are, in turn, with nothing varied but their random draws: what an exploration is to be
    /// compared with. Then `sources` does not count.
    pub plain: bool,
    /// The seed; by default the study's.
    pub seed: Option<u64>,
    /// Shrinks the episodes of each finding, in at most so many episodes, and groups them by cause.
    pub causes: Option<u64>,
    /// Where results go; by default to the folder `results/exploration` of the study.
    pub out: Option<PathBuf>,
    /// The folder in which controllers leave which of their lines ran, if they do.
    pub coverage: Option<PathBuf>,
}

impl ExploreRequest {
    /// As the file of the study in this folder says.
    pub fn new(study: impl Into<PathBuf>, file: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            file: file.into(),
            episodes: None,
            sources: Vec::new(),
            plain: false,
            seed: None,
            causes: None,
            out: None,
            coverage: None,
        }
    }

    /// In at most so many episodes.
    #[must_use]
    pub fn episodes(mut self, episodes: u64) -> Self {
        self.episodes = Some(episodes);
        self
    }

    /// With a source of tests among those that are used; those of the file are not, then.
    #[must_use]
    pub fn source(mut self, source: SourceKind) -> Self {
        self.sources.push(source);
        self
    }
}

/// Explores, and writes `exploration.json`, `findings/NAME.toml` for each thing that was found, and the table of all episodes.
///
/// The search runs in the fast physics where the file and the bench say so; what the full physics does not show is told apart.
/// What an earlier call has run of the same exploration is in its journal and is not run again. If the host is asked to stop,
/// the episodes so far are counted.
///
/// # Errors
/// What the study's files say wrong, each with its place, before anything runs; `not-a-simulation` if the evidence has no
/// bench; `no-physics-library` if episodes cannot be simulated here.
pub fn explore(request: &ExploreRequest, host: &Host) -> Result<ExplorationReport, Problem> {
    let study = study_of(&request.study, request.seed, host)?;
    let plan = plan_of(&study, &request.file, request.episodes)?;
    let bench = bench_of(&study, &plan, false, host)?;
    let folder = folder_of(&study, request.out.as_deref());
    let fast = plan.searching(&bench)?;
    let search = Search {
        study: &study,
        plan: &plan,
        bench: fast.as_ref().unwrap_or(&bench),
        request,
        folder: &folder,
        host,
    };
    let mut explored = search.run()?;
    let keeping = Keeping {
        study: &study,
        bench: &bench,
        is_fast: fast.is_some(),
        folder: &folder,
    };
    keeping.keep(&mut explored)?;
    if let Some(budget) = request.causes {
        find_causes(&search, (&bench, fast.as_ref()), budget, &mut explored)?;
    }
    let about = [
        ("study", study.about.title.as_str()),
        ("evidence", &bench.files.evidence),
    ];
    explored.rows.write(&folder.join(rows::FILE), &about)?;
    write(&folder.join(EXPLORATION), &sealed(&explored.report)?, host)?;
    Ok(explored.report)
}

/// The study, with the seed that is asked for.
fn study_of(folder: &Path, seed: Option<u64>, host: &Host) -> Result<Study, Problem> {
    let mut study = Study::load_for(folder, &host.trust)?;
    study.about.seed = seed.unwrap_or(study.about.seed);
    Ok(study)
}

/// How to explore, with the number of episodes that is asked for.
fn plan_of(study: &Study, file: &Path, episodes: Option<u64>) -> Result<Plan, Problem> {
    let mut plan = Plan::load(&study.folder, file)?;
    plan.check_triggers(study)?;
    if let Some(episodes) = episodes {
        plan.data.budget.episodes = episodes;
        if let Some(disagreement) = &mut plan.data.disagreement {
            disagreement.episodes = episodes;
        }
    }
    Ok(plan)
}

/// The bench of the full physics, if the plan fits it.
fn bench_of(
    study: &Study,
    plan: &Plan,
    disagreement: bool,
    host: &Host,
) -> Result<OpenBench, Problem> {
    let entry = study.entry(plan.evidence(disagreement))?;
    let bench = OpenBench::of_entry(study, entry, host)?;
    plan.fits(&bench, disagreement)?;
    Ok(bench)
}

/// Where results go.
fn folder_of(study: &Study, out: Option<&Path>) -> PathBuf {
    out.map_or_else(|| study.folder.join("results/exploration"), Path::to_owned)
}

/// Looks into each finding, in at most `budget` episodes.
fn find_causes(
    search: &Search<'_>,
    benches: (&OpenBench, Option<&OpenBench>),
    budget: u64,
    explored: &mut Explored,
) -> Result<(), Problem> {
    let host = search.host;
    let findings = explored.findings.len() as u64;
    let title = "shrinking findings: episodes";
    let stage = host.events.begin(title, budget * findings);
    let causes = Causes {
        study: search.study,
        plan: search.plan,
        benches,
        budget,
        folder: search.folder,
        host,
        stage: &stage,
    };
    let reports = &mut explored.report.found.findings;
    causes.find(&explored.findings, &explored.met, reports)?;
    if host.cancel.is_cancelled() {
        // Causes that were not looked into are missing.
        explored.report.found.stopped = Stopped::Interrupted;
    }
    Ok(())
}

/// Writes a result, and says where.
fn write(path: &Path, text: &str, host: &Host) -> Result<(), Problem> {
    write_whole(path, text.as_bytes())?;
    host.events.say(&format!("{} is written", path.display()));
    Ok(())
}
