//! Simulation: the episodes of the rig that an entry of the ledger names.
//!
//! An episode is known by its number; its seed follows from the study's seed,
//! the evidence's identifier and that number. Campaigns of many episodes are
//! run by `technique::campaign`.

use super::campaign::{Intervals, Tally, monitors};
use diagnostic::Problem;
use evidence::Finding;
use host::store::Inputs;
use host::{Cancel, Host, Stage};
use judging::{Judgement, Judges};
use rayon::prelude::*;
use rig::{Resumable, Rig, episode_name};
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use stimulus::Stimulus;
use study::Study;
use testbench::{Engine, Recorded, SimError, Unwatched};
use trace::Trace;

/// Runs an episode of a rig's own stimulus. One whose controller fails is cut short; one whose controller cannot be set up
/// is an error.
fn run(rig: &dyn Rig, seed: u64, interrupt: &Cancel) -> Result<Recorded, Problem> {
    let recorded = rig
        .run(rig.stimulus(), seed, &mut Unwatched, interrupt)
        .map_err(|error| problem_at(seed, &error))?;
    match &recorded.failure {
        Some(failure) if failure.in_setup => {
            let message = format!("seed {seed}: {}", failure.words);
            Err(Problem::new("controller-failed", message))
        }
        _ => Ok(recorded),
    }
}

/// What kept an episode from being simulated.
pub fn problem_at(seed: u64, error: &SimError) -> Problem {
    match error {
        SimError::Cancelled => Problem::interrupted(),
        other => Problem::new("simulation-failed", format!("seed {seed}: {other}")),
    }
}

/// An episode that is saved in the middle of its recording and continued from there in a new run.
pub fn in_two_parts(
    bench: &dyn Resumable,
    stimulus: &Stimulus,
    seed: u64,
    interrupt: &Cancel,
) -> Result<Recorded, SimError> {
    let mut whole = bench.start(stimulus, seed)?;
    whole.advance(f64::INFINITY, &mut Unwatched, interrupt)?;
    let middle_secs = whole.now_secs() / 2.0;
    drop(whole);
    let mut first = bench.start(stimulus, seed)?;
    first.advance(middle_secs, &mut Unwatched, interrupt)?;
    let saved = first.save()?;
    drop(first);
    let mut second = saved.resume(None)?;
    second.advance(f64::INFINITY, &mut Unwatched, interrupt)?;
    second.finish()
}

/// Loads the physics library.
pub fn load_engine(host: &Host) -> Result<Engine, Problem> {
    let Some(library) = &host.physics_library else {
        return Err(Problem::new(
                "no-physics-library",
                "simulations need the MuJoCo library, whose place is not known",
            )
            .remedy("start the program as `./corroborate`, which fetches it, or set CORROBORATE_MUJOCO to its path"));
    };
    let engine = Engine::load(library).map_err(|error| {
        Problem::new("no-physics-library", error.to_string())
            .remedy("run `tools/mujoco`, which fetches the version that is needed")
    })?;
    host.memory.physics_begins();
    Ok(engine)
}

/// The seeds of a piece of evidence's episodes.
#[derive(Clone, Debug)]
pub struct Seeds {
    study: u64,
    evidence: String,
}

impl Seeds {
    /// Seeds that differ between pieces of evidence of one study.
    pub fn new(study: u64, evidence: &str) -> Self {
        Self {
            study,
            evidence: evidence.to_owned(),
        }
    }

    /// The seed of one episode.
    pub fn of(&self, number: u64) -> u64 {
        let mut inputs = Inputs::default();
        inputs
            .add("study", &self.study.to_le_bytes())
            .add("evidence", self.evidence.as_bytes())
            .add("episode", &number.to_le_bytes());
        u64::from_str_radix(&inputs.hash()[..16], 16).unwrap_or(number)
    }
}

/// Simulates episodes and hands each trace, with its file's path, to `write`,
/// which may run on any thread; the results come in the order of the numbers.
pub fn record_with<T: Send>(
    rig: &dyn Rig,
    seeds: &Seeds,
    numbers: std::ops::Range<u64>,
    folder: &Path,
    interrupt: &Cancel,
    stage: &Stage,
    write: impl Fn(&Trace, &Path) -> Result<T, Problem> + Sync,
) -> Result<Vec<(PathBuf, T)>, Problem> {
    let numbers: Vec<u64> = numbers.collect();
    numbers
        .into_par_iter()
        .map(|number| {
            let trace = run(rig, seeds.of(number), interrupt)?.trace;
            let path = folder.join(episode_name(number));
            let result = write(&trace, &path)?;
            stage.advance();
            Ok((path, result))
        })
        .collect()
}

/// Sums up judgements of many traces, one finding for each subject.
pub fn findings(
    study: &Study,
    judges: &Judges<'_>,
    judgements: &[Vec<Judgement>],
    names: &[String],
) -> Result<Vec<Finding>, Problem> {
    let mut tally = Tally::new(&monitors(judges));
    for (judgements, name) in judgements.iter().zip(names) {
        let verdicts: Vec<_> = judgements.iter().map(|j| j.findings.verdict).collect();
        tally.add(name, &verdicts);
        let left_out = judgements.iter().map(|it| it.findings.left_out.is_some());
        tally.left_out(left_out);
    }
    tally.findings(study, Intervals::Fixed)
}

/// Which physics a search runs in. What it finds is shown by the full one before it counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SearchPhysics {
    /// The fast one, which is approximate; of benches that have one.
    Fast,
    /// The full one.
    Full,
}

impl study::Choice for SearchPhysics {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Fast,
            "fast",
            "The fast one, which is approximate; of benches that have one",
        ),
        (Self::Full, "full", "The full one"),
    ];
}

impl SearchPhysics {
    /// What a search runs in beside the full physics: `fast` makes the bench of the fast one, if there is one. Without
    /// a choice the fast one is taken where it exists; `Err` if it is asked for where it does not exist.
    pub fn choose<T>(
        asked: Option<Self>,
        fast: impl FnOnce() -> Option<T>,
    ) -> Result<Option<T>, String> {
        match asked {
            Some(Self::Full) => Ok(None),
            None => Ok(fast()),
            Some(Self::Fast) => match fast() {
                Some(bench) => Ok(Some(bench)),
                None => {
                    Err("this bench has no fast physics: it always runs in the full one".to_owned())
                }
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn a_search_takes_the_fast_physics_where_it_exists() {
        let choose = |asked, there: bool| SearchPhysics::choose(asked, || there.then_some(()));
        assert_eq!(choose(None, true), Ok(Some(())));
        assert_eq!(choose(None, false), Ok(None));
        assert_eq!(choose(Some(SearchPhysics::Full), true), Ok(None));
        assert_eq!(choose(Some(SearchPhysics::Fast), true), Ok(Some(())));
        assert!(choose(Some(SearchPhysics::Fast), false).is_err());
    }

    #[test]
    fn seeds_differ_between_episodes_and_evidence_and_never_change() {
        let seeds = Seeds::new(2020, "E4");
        let first: BTreeSet<u64> = (1..=1000).map(|n| seeds.of(n)).collect();
        assert_eq!(first.len(), 1000);
        assert!(!first.contains(&Seeds::new(2020, "E2").of(1)));
        assert_eq!(seeds.of(7), Seeds::new(2020, "E4").of(7));
    }
}
