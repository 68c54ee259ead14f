//! The smallest scenario that still shows what an episode showed, kept as a regression.
//!
//! First every number that the episode drew from its seed becomes a setting, so
//! that what is left afterwards names the cause and the seed does not hide it.
//! Then `campaign::shrink` makes the stimulus smaller: settings go back to their
//! nominal values, or as near to these as still shows it clearly (`clarity`). Where the bench has a fast physics, that proposes a smaller
//! scenario first, and the full physics goes on from there (`trials`). At last the episode is
//! cut to the fewest whole seconds that still show it. A cut recording counts as
//! cut: what is violated only because nothing more comes is not decided by it,
//! so an end cannot become the reason.

mod clarity;
mod pins;
mod report;
mod subject;
mod trials;

pub use report::{ExtentReport, ShrinkReport};

pub(crate) use clarity::Clarity;
pub(crate) use trials::Trials;

use crate::replay::Episode;
use crate::technique::exploration::{Plan, ShowsJudge};
use crate::technique::simulation::SearchPhysics;
use campaign::ShrinkOptions;
use diagnostic::Problem;
use host::Host;
use std::path::{Path, PathBuf};
use study::{Expected, Finding, Shows, Study};
use subject::Subject;
use trials::Shrunken;

/// An episode to be made small. [`ShrinkRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct ShrinkRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Which one: the file of a finding, as it is or relative to the study; or an episode of an evidence by its number, such as
    /// `E4:17`.
    pub episode: String,
    /// What is to be shown still, where the episode shows several things: a requirement, a failure mode, or a failure such as
    /// `controller-failed`.
    pub only: Option<String>,
    /// How many episodes may be run; where several seeds are tried, each scenario takes one for each.
    pub budget: u64,
    /// In how many seeds it must show, the finding's own among them, and of how many.
    pub seeds: (u32, u32),
    /// By how much what is kept has to violate its requirement, as a share of what is allowed; by default by a tenth, or by half of
    /// what the finding does if that is less.
    pub margin: Option<f64>,
    /// In which physics scenarios are tried first; by default in the fast one, where the bench has one.
    pub physics: Option<SearchPhysics>,
    /// The exploration whose parameters say what is possible, and what needs no explanation; by default that of the finding, or
    /// `exploration.toml` if it is of the same evidence.
    pub exploration: Option<PathBuf>,
    /// The name of the regression; by default the finding's.
    pub name: Option<String>,
}

impl ShrinkRequest {
    /// This episode of the study in this folder, in its own seed, in at most 300 episodes.
    pub fn new(study: impl Into<PathBuf>, episode: impl Into<String>) -> Self {
        Self {
            study: study.into(),
            episode: episode.into(),
            only: None,
            budget: 300,
            seeds: (1, 1),
            margin: None,
            physics: None,
            exploration: None,
            name: None,
        }
    }
}

/// Makes an episode smaller while it still shows the same, and writes `regressions/NAME.toml`. If the host is asked to stop,
/// the smallest so far is kept.
///
/// # Errors
/// What the study's files say wrong; `no-finding`, `bad-episode`, `unknown-subject` and `several-shown` if the request does
/// not say which episode and what of it; `already-there` if there is a regression of that name; `not-shown` if the episode
/// does not show it; `no-margin` if it is not violated by the margin that is asked for; `no-physics-library` if it cannot be simulated here.
pub fn shrink(request: &ShrinkRequest, host: &Host) -> Result<ShrinkReport, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    let subject = Subject::of(&study, request, host)?;
    let target = target(&study, request, &subject)?;
    let Subject { finding, bench, .. } = &subject;
    let fast =
        SearchPhysics::choose(request.physics, || bench.in_fast_physics()).map_err(|message| {
            let problem = Problem::new("bad-settings", message);
            problem.remedy("leave out the choice of a physics (--physics on the command line)")
        })?;
    let mut options = options(&study, request, finding, host)?;
    let judge = ShowsJudge::new(&study, &finding.shows, &host.cancel)?;
    let clarity = Clarity::new(&study, &finding.shows, request.margin)?;
    let stage = host.events.begin("shrinking: episodes", request.budget);
    let trials = Trials::new(
        (bench, fast.as_ref()),
        (&judge, &clarity),
        Episode::of_named(finding.clone(), &subject.name),
        (request.budget, request.seeds),
        (&host.cancel, &stage),
    );
    let shrunk = trials.shrink(finding, &mut options)?;
    drop(stage);
    keep(&shrunk, &subject, &target, &options)
}

/// The file of the regression, which must not be there yet.
fn target(study: &Study, request: &ShrinkRequest, subject: &Subject) -> Result<PathBuf, Problem> {
    let name = request.name.as_deref().unwrap_or(&subject.name);
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
        return Err(Problem::new(
            "bad-name",
            format!("`{name}` is not a valid name of a regression"),
        )
        .remedy("use letters, digits, `-` and `_`"));
    }
    let target = study
        .folder
        .join("regressions")
        .join(format!("{name}.toml"));
    if target.exists() {
        let message = format!(
            "{} is there already and would be replaced",
            target.display()
        );
        return Err(Problem::new("already-there", message)
            .remedy("choose another name (--name on the command line), or remove the file"));
    }
    Ok(target)
}

/// What is possible and what needs no explanation: the parameters of an
/// exploration, if there is one of the same bench.
fn options(
    study: &Study,
    request: &ShrinkRequest,
    finding: &Finding,
    host: &Host,
) -> Result<ShrinkOptions, Problem> {
    let budget = usize::try_from(request.budget).unwrap_or(usize::MAX);
    let is_asked = request.exploration.is_some();
    let plan = match exploration(study, request, finding) {
        Some(file) if is_asked => Some((Plan::load(&study.folder, &file)?, file)),
        Some(file) => Some((Plan::of_study(study, &file)?, file)),
        None => None,
    };
    // Another bench has other keys.
    let fits = |plan: &Plan| is_asked || plan.data.evidence == finding.bench.evidence;
    let Some((plan, file)) = plan.filter(|(plan, _)| fits(plan)) else {
        host.events
            .say("no exploration says what is possible: any value may be tried");
        return Ok(ShrinkOptions {
            budget,
            ..ShrinkOptions::default()
        });
    };
    host.events.say(&format!(
        "ranges and nominal values are those of {}",
        file.display()
    ));
    ShrinkOptions::within(plan.space, budget)
        .map_err(|error| Problem::new("bad-exploration", error.to_string()))
}

/// The exploration that is asked for, or that of the finding, or the usual one if it is there.
fn exploration(study: &Study, request: &ShrinkRequest, finding: &Finding) -> Option<PathBuf> {
    let of_finding = || match &finding.shows {
        Shows::Unknown(step) => Some(PathBuf::from(&step.exploration)),
        _ => None,
    };
    let usual = || {
        let usual = PathBuf::from("exploration.toml");
        study.folder.join(&usual).is_file().then_some(usual)
    };
    let asked = request.exploration.clone();
    asked.or_else(of_finding).or_else(usual)
}

/// Writes the regression and says what became of it.
fn keep(
    shrunk: &Shrunken,
    subject: &Subject,
    target: &Path,
    options: &ShrinkOptions,
) -> Result<ShrinkReport, Problem> {
    let mut kept = shrunk.regression.clone();
    kept.expected = Expected::Fails;
    kept.program = env!("CARGO_PKG_VERSION").into();
    let report = ShrinkReport::new(shrunk, &subject.finding, target, options);
    kept.write(target, &report.comment(&subject.from))?;
    if Finding::read(target)? != kept {
        let message = format!("{} does not hold what was written", target.display());
        return Err(Problem::data_lost("cannot-write", message));
    }
    Ok(report)
}
