//! One episode run again, bit for bit, as recordings and verdicts, and as a page that a face draws; or all regressions, as
//! tests.

mod episode;
mod page;
mod regressions;
mod scene;
mod shown;

pub use regressions::{
    RegressionReport, RegressionState, RegressionsReport, RegressionsRequest, check_regressions,
};

pub(crate) use episode::{Episode, finding_file, hash_of_trace, no_finding};

use crate::technique::campaign::kind_of;
use crate::technique::exploration::{OpenBench, ShowsJudge, failed};
use diagnostic::Problem;
use evidence::replay::Replay as Page;
use evidence::{FailureKind, RunVerdict};
use host::Host;
use host::files::write_whole;
use judging::run_verdict;
use schemars::JsonSchema;
use serde::Serialize;
use shown::Judged;
use std::path::{Path, PathBuf};
use study::Study;
use testbench::{Recorded, ViewKeeper};

/// An episode to be run again. [`ReplayRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct ReplayRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Which one: the file of a finding or regression, as it is or relative to the study; or an episode of an evidence by its
    /// number, such as `E4:17`.
    pub episode: String,
    /// The requirements and failure modes that the page shows; what the finding is of, or all that is violated, if there are none.
    pub only: Vec<String>,
    /// Where the files go; by default to the folder `results/replays/NAME` of the study.
    pub out: Option<PathBuf>,
}

impl ReplayRequest {
    /// This episode of the study in this folder.
    pub fn new(study: impl Into<PathBuf>, episode: impl Into<String>) -> Self {
        Self {
            study: study.into(),
            episode: episode.into(),
            only: Vec::new(),
            out: None,
        }
    }

    /// With files in another folder.
    #[must_use]
    pub fn out(mut self, folder: impl Into<PathBuf>) -> Self {
        self.out = Some(folder.into());
        self
    }
}

/// An episode that was run again.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ReplayReport {
    /// Version of this form.
    pub format: String,
    /// The episode.
    pub episode: String,
    /// Its seed, as a text: readers round numbers beyond 2^53.
    pub seed: String,
    /// What of the robot's program or the simulator ended it, if it did not end by itself.
    pub failed: Option<FailureKind>,
    /// What the program said then.
    pub said: Option<String>,
    /// What it showed, in words, if that is why it was replayed.
    pub shows: Option<String>,
    /// Whether it shows it again.
    pub shown: Option<bool>,
    /// BLAKE3 of the recording.
    pub recording: String,
    /// Whether that is the same as before; absent where that is not known.
    pub same_bytes: Option<bool>,
    /// What each requirement's monitor says.
    pub verdicts: Vec<VerdictReport>,
    /// What was written.
    pub files: Vec<String>,
}

/// What a requirement's monitor says.
#[derive(Debug, Serialize, JsonSchema)]
pub struct VerdictReport {
    /// The requirement or failure mode.
    pub subject: String,
    /// The verdict.
    pub verdict: RunVerdict,
    /// Why, in sentences.
    pub reasons: Vec<String>,
}

/// Draws a page.
type Draw<'d> = &'d dyn Fn(&Page) -> String;

/// Runs an episode again and writes `recording.mcap` (all that was recorded), `verdicts.mcap` (the verdicts over time) and
/// `scene.mcap` (what there is to see, for Foxglove's 3D panel).
///
/// # Errors
/// What the study's files say wrong; `no-finding`, `bad-episode` and `unknown-subject` if the request names what is not
/// there; `interrupted` if the host was asked to stop; `no-physics-library` if it cannot be simulated here.
pub fn replay(request: &ReplayRequest, host: &Host) -> Result<ReplayReport, Problem> {
    carried_out(request, host, None)
}

/// The same, with `replay.html` written beside it, the page that `draw` makes.
///
/// # Errors
/// Those of [`replay()`].
pub fn replay_with_page(
    request: &ReplayRequest,
    host: &Host,
    draw: &dyn Fn(&Page) -> String,
) -> Result<ReplayReport, Problem> {
    carried_out(request, host, Some(draw))
}

fn carried_out(
    request: &ReplayRequest,
    host: &Host,
    draw: Option<Draw<'_>>,
) -> Result<ReplayReport, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    refuse_unknown(&study, &request.only)?;
    let (episode, bench) = Episode::named(&study, &request.episode, host)?;
    let judge = match &episode.shows {
        Some(shows) => Some(ShowsJudge::new(&study, shows, &host.cancel)?),
        None => None,
    };
    let (recorded, seen) = run(&episode, &bench, host)?;
    let shown = match &judge {
        Some(judge) => Some(judge.shows(&recorded)?),
        None => None,
    };
    let folder = match &request.out {
        Some(folder) => folder.clone(),
        None => study.folder.join("results/replays").join(&episode.name),
    };
    let replayed = Replayed {
        judged: shown::judge(&study, &recorded.trace)?,
        study: &study,
        engine: &bench.engine,
        episode,
        recorded,
        seen,
        shown,
    };
    replayed.kept(&request.only, &folder, draw)
}

/// Fails if one of them is no requirement and no failure mode of the study.
fn refuse_unknown(study: &Study, ids: &[String]) -> Result<(), Problem> {
    match ids.iter().find(|id| study.forms.by_id(id).is_none()) {
        None => Ok(()),
        Some(id) => {
            let message = format!("requirements.toml does not declare `{id}`");
            Err(Problem::new("unknown-subject", message).remedy("check the identifier"))
        }
    }
}

/// Runs it, and sees where bodies are.
fn run(
    episode: &Episode,
    bench: &OpenBench,
    host: &Host,
) -> Result<(Recorded, ViewKeeper), Problem> {
    if bench.is_outside() {
        host.events
            .say("another simulator shows no bodies: the page has signals and verdicts only");
    }
    let mut seen = ViewKeeper::default();
    let stage = host.events.begin("replaying", 1);
    let recorded = episode
        .run(bench, Some(&mut seen), &host.cancel)
        .map_err(|error| failed(&error))?;
    stage.advance();
    Ok((recorded, seen))
}

/// An episode that was run again, with all that was found.
struct Replayed<'a> {
    study: &'a Study,
    engine: &'a str,
    episode: Episode,
    recorded: Recorded,
    seen: ViewKeeper,
    judged: Judged<'a>,
    shown: Option<bool>,
}

impl Replayed<'_> {
    /// Writes the files, and says what was found.
    fn kept(
        &self,
        only: &[String],
        folder: &Path,
        draw: Option<Draw<'_>>,
    ) -> Result<ReplayReport, Problem> {
        let (hash, bytes) = hash_of_trace(&self.recorded.trace)?;
        let mut files = Vec::new();
        if let Some(draw) = draw {
            let page = self.page(only, &hash)?;
            files.push(("replay.html", draw(&page).into_bytes()));
        }
        files.extend([
            ("recording.mcap", bytes),
            ("verdicts.mcap", self.judged.over_time.clone()),
            ("scene.mcap", scene::of_foxglove(&self.seen)?),
        ]);
        let mut written = Vec::new();
        for (name, content) in &files {
            let path = folder.join(name);
            write_whole(&path, content)?;
            written.push(path.display().to_string());
        }
        Ok(self.report(hash, written))
    }

    fn report(&self, recording: String, files: Vec<String>) -> ReplayReport {
        let judgements = self.judged.judgements.iter();
        let verdicts = judgements.map(|judgement| VerdictReport {
            subject: judgement.subject.id().to_owned(),
            verdict: run_verdict(judgement.findings.verdict),
            reasons: shown::reasons(judgement),
        });
        let failure = self.recorded.failure.as_ref();
        let known = self.episode.recording.as_ref();
        ReplayReport {
            format: "1.1".into(),
            episode: self.episode.name.clone(),
            seed: self.episode.seed.to_string(),
            failed: failure.map(kind_of),
            said: failure.map(|it| it.words.clone()),
            shows: self.episode.shows.as_ref().map(ToString::to_string),
            shown: self.shown,
            same_bytes: known.map(|known| *known == recording),
            recording,
            verdicts: verdicts.collect(),
            files,
        }
    }
}
