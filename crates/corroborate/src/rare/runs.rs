//! Runs of the bench as splitting and subset simulation want them.

use super::file::EventText;
use super::report::RunFailures;
use super::score::{Follower, Following, Score};
use crate::technique::campaign::{ended, failure_of};
use crate::test_bench::{simulation_problem, stimulus_at};
use campaign::splitting::{Branch, Candidate, Crossing, Job};
use diagnostic::Problem;
use evidence::FailureKind;
use host::Host;
use rayon::prelude::*;
use rig::{Rig, Running, Saved};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use stimulus::Space;
use testbench::{SimError, Status};

/// A run is looked at this often, and saved if it has come nearer.
const LOOK_SECS: f64 = 0.02;

/// One event on one bench.
pub struct Runs<'a> {
    /// Its own stimulus is the test that episodes enact, without settings.
    pub rig: &'a dyn Rig,
    pub score: &'a Score<'a>,
    pub event: &'a EventText,
    pub host: &'a Host,
    /// What ended runs, since it was last taken.
    pub ended: Mutex<RunsEnded>,
}

/// Runs, continuations among them, and those of them that a failure ended. Such a run counts up to there: an event that
/// it had not come to has not happened in it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunsEnded {
    pub runs: u64,
    pub failed: BTreeMap<FailureKind, u64>,
    /// Whole episodes, in the order in which they were asked for; not runs that are split.
    pub episodes: Vec<EpisodeOfInputs>,
}

/// A whole episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeOfInputs {
    pub seed: u64,
    /// Its inputs, in the unit cube.
    pub unit: Vec<f64>,
    /// `None` of an episode without a score: minus infinity is no number of JSON.
    pub score: Option<f64>,
    pub failed: Option<FailureKind>,
}

impl RunsEnded {
    /// Adds others.
    pub fn add(&mut self, other: &Self) {
        self.runs += other.runs;
        for (kind, count) in &other.failed {
            *self.failed.entry(*kind).or_default() += count;
        }
    }

    /// How many runs each kind of failure ended.
    pub fn reports(&self) -> Vec<RunFailures> {
        let failed = self.failed.iter();
        let reports = failed.map(|(kind, count)| RunFailures {
            kind: *kind,
            count: *count,
            runs: self.runs,
        });
        reports.collect()
    }
}

/// A run at a moment at which it had come nearer to the event.
#[derive(Clone)]
pub struct Moment<'s> {
    saved: Saved<'s>,
    follower: Follower<'s>,
}

impl<'a> Runs<'a> {
    /// The highest rung.
    pub fn top(&self) -> usize {
        self.score.rungs.len()
    }

    /// Runs, in parallel; the outcomes come in the order of the jobs.
    pub fn branches(&self, jobs: Vec<Job<Moment<'a>>>) -> Result<Vec<Branch<Moment<'a>>>, Problem> {
        jobs.into_par_iter().map(|job| self.branch(&job)).collect()
    }

    fn branch(&self, job: &Job<Moment<'a>>) -> Result<Branch<Moment<'a>>, Problem> {
        let fail = |error| self.problem(error, job.seed);
        let mut rung = job.from.as_ref().map_or(0, |from| from.rung);
        let mut branch = Branch {
            crossings: Vec::new(),
            cost: 0.0,
        };
        if rung >= self.top() {
            return Ok(branch);
        }
        let (mut run, mut follower) = match &job.from {
            None => {
                let run = match self.start(job.seed) {
                    Err(error) if !self.host.cancel.is_cancelled() => {
                        let failure = failure_of(&error).ok_or_else(|| fail(error))?;
                        self.count(Some(failure.kind));
                        return Ok(branch);
                    }
                    run => run.map_err(fail)?,
                };
                (run, self.score.start()?)
            }
            Some(from) => {
                let run = from.state.saved.resume(Some(job.seed));
                (run.map_err(fail)?, from.state.follower.clone())
            }
        };
        let begun_secs = run.now_secs();
        let mut failed = None;
        loop {
            self.host.go_on()?;
            let next_secs = (run.now_secs() + LOOK_SECS).min(self.event.until_secs);
            let mut watch = self.following(&mut follower);
            let cancel = &self.host.cancel;
            let status = run.advance(next_secs, &mut watch, cancel);
            if let Err(error) = &status {
                failed = failure_of(error).map(|failure| failure.kind);
            }
            if let Some(problem) = watch.problem {
                return Err(problem);
            }
            let status = match status {
                Err(_) if failed.is_some() && !self.host.cancel.is_cancelled() => break,
                status => status.map_err(fail)?,
            };
            let reached = self.score.rung(follower.highest);
            if reached > rung {
                rung = reached;
                let state = Moment {
                    saved: run.save().map_err(fail)?,
                    follower: follower.clone(),
                };
                branch.crossings.push(Crossing { rung, state });
            }
            let over = run.now_secs() + 1e-9 >= self.event.until_secs;
            if over || rung >= self.top() || status != Status::Running {
                break;
            }
        }
        self.count(failed);
        branch.cost = (run.now_secs() - begun_secs) / self.event.until_secs;
        Ok(branch)
    }

    /// A run that can be saved. That the rig has such runs was tried before any.
    fn start(&self, seed: u64) -> Result<Box<dyn Running<'a> + 'a>, SimError> {
        match self.rig.resumable() {
            Some(bench) => bench.start(self.rig.stimulus(), seed),
            None => Err(SimError::Outside {
                reason: format!("runs of {} cannot be saved", self.rig.engine()),
            }),
        }
    }

    fn count(&self, failed: Option<FailureKind>) {
        let mut ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        ended.runs += 1;
        if let Some(kind) = failed {
            *ended.failed.entry(kind).or_default() += 1;
        }
    }

    /// What ended runs since this was last asked.
    pub fn take_ended(&self) -> RunsEnded {
        std::mem::take(&mut self.ended.lock().unwrap_or_else(PoisonError::into_inner))
    }

    fn problem(&self, error: SimError, seed: u64) -> Problem {
        match error {
            // A controller that ended with us did not fail.
            SimError::Controller(_) if self.host.cancel.is_cancelled() => Problem::interrupted(),
            other => simulation_problem(other, seed),
        }
    }

    fn following<'f>(&'f self, follower: &'f mut Follower<'a>) -> Following<'f, 'a> {
        Following {
            score: self.score,
            follower,
            until_secs: self.event.until_secs,
            problem: None,
        }
    }

    /// The scores of inputs, in parallel and in order.
    pub fn scores(&self, space: &Space, inputs: Vec<Candidate>) -> Result<Vec<f64>, Problem> {
        let one = |input: Candidate| {
            let (score, failed) = self.episode(space, &input.unit, input.seed)?;
            self.count(failed);
            let episode = EpisodeOfInputs {
                seed: input.seed,
                unit: input.unit,
                score: Some(score).filter(|score| score.is_finite()),
                failed,
            };
            Ok((score, episode))
        };
        let scored: Vec<(f64, EpisodeOfInputs)> = inputs
            .into_par_iter()
            .map(one)
            .collect::<Result<_, Problem>>()?;
        let (scores, episodes): (Vec<f64>, Vec<EpisodeOfInputs>) = scored.into_iter().unzip();
        let mut ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        ended.episodes.extend(episodes);
        Ok(scores)
    }

    /// The score of one plain episode, exact up to the limit, and what ended it if it did not end by itself.
    pub fn episode(
        &self,
        space: &Space,
        unit: &[f64],
        seed: u64,
    ) -> Result<(f64, Option<FailureKind>), Problem> {
        self.host.go_on()?;
        let stimulus = stimulus_at(self.rig.stimulus(), space, unit)?;
        let mut follower = self.score.start()?;
        let mut watch = self.following(&mut follower);
        let cancel = &self.host.cancel;
        let run = self.rig.run(&stimulus, seed, &mut watch, cancel);
        if let Some(problem) = watch.problem {
            return Err(problem);
        }
        let failed = match run {
            Err(error @ (SimError::Cancelled | SimError::Stimulus { .. })) => {
                return Err(self.problem(error, seed));
            }
            run => ended(run, seed, false)?.failed,
        };
        Ok((follower.highest, failed))
    }
}
