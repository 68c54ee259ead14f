//! Runs of the bench as splitting and subset simulation want them.

use super::bench::{simulation_problem, stimulus_at};
use super::file::EventText;
use super::score::{Follower, Following, Score};
use crate::command::Setting;
use crate::problem::Problem;
use campaign::splitting::{Branch, Candidate, Crossing, Job};
use rayon::prelude::*;
use stimulus::{Space, Stimulus};
use testbench::{Savable, SimError, Status};

/// A run is looked at this often, and saved if it has come nearer.
const LOOK_SECS: f64 = 0.02;

/// One event on one bench.
pub struct Runs<'a, B> {
    pub bench: &'a B,
    /// The test that episodes enact, without settings.
    pub test: &'a Stimulus,
    pub score: &'a Score<'a>,
    pub event: &'a EventText,
    pub setting: &'a Setting,
}

/// A run at a moment at which it had come nearer to the event.
#[derive(Clone)]
pub struct Moment<'s, S> {
    saved: S,
    follower: Follower<'s>,
}

impl<'a, B: Savable> Runs<'a, B> {
    /// The highest rung.
    pub fn top(&self) -> usize {
        self.score.rungs.len()
    }

    /// Runs, in parallel; the outcomes come in the order of the jobs.
    pub fn branches(
        &self,
        jobs: Vec<Job<Moment<'a, B::Saved>>>,
    ) -> Result<Vec<Branch<Moment<'a, B::Saved>>>, Problem> {
        jobs.into_par_iter().map(|job| self.branch(&job)).collect()
    }

    fn branch(
        &self,
        job: &Job<Moment<'a, B::Saved>>,
    ) -> Result<Branch<Moment<'a, B::Saved>>, Problem> {
        let fail = |error| self.problem(error, job.seed);
        let bench = self.bench;
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
                let run = bench.start(self.test, job.seed).map_err(fail)?;
                (run, self.score.start()?)
            }
            Some(from) => {
                let run = bench.resume(&from.state.saved, Some(job.seed));
                (run.map_err(fail)?, from.state.follower.clone())
            }
        };
        let begun_secs = bench.now_secs(&run);
        loop {
            self.setting.go_on()?;
            let next_secs = (bench.now_secs(&run) + LOOK_SECS).min(self.event.until_secs);
            let mut watch = self.following(&mut follower);
            let status = bench
                .advance(
                    &mut run,
                    next_secs,
                    &mut watch,
                    self.setting.interrupt.cancel(),
                )
                .map_err(fail)?;
            if let Some(problem) = watch.problem {
                return Err(problem);
            }
            let reached = self.score.rung(follower.highest);
            if reached > rung {
                rung = reached;
                let state = Moment {
                    saved: bench.save(&run).map_err(fail)?,
                    follower: follower.clone(),
                };
                branch.crossings.push(Crossing { rung, state });
            }
            let over = bench.now_secs(&run) + 1e-9 >= self.event.until_secs;
            if over || rung >= self.top() || status != Status::Running {
                break;
            }
        }
        branch.cost = (bench.now_secs(&run) - begun_secs) / self.event.until_secs;
        Ok(branch)
    }

    fn problem(&self, error: SimError, seed: u64) -> Problem {
        match error {
            // A controller that ended with us did not fail.
            SimError::Controller(_) if self.setting.interrupt.is_set() => Problem::interrupted(),
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
        let one = |input: Candidate| self.episode(space, &input.unit, input.seed);
        inputs.into_par_iter().map(one).collect()
    }

    /// The score of one plain episode, exact up to the limit.
    pub fn episode(&self, space: &Space, unit: &[f64], seed: u64) -> Result<f64, Problem> {
        self.setting.go_on()?;
        let stimulus = stimulus_at(self.test, space, unit)?;
        let mut follower = self.score.start()?;
        let mut watch = self.following(&mut follower);
        let cancel = self.setting.interrupt.cancel();
        self.bench
            .run(&stimulus, seed, &mut watch, cancel)
            .map_err(|error| self.problem(error, seed))?;
        match watch.problem {
            Some(problem) => Err(problem),
            None => Ok(follower.highest),
        }
    }
}
