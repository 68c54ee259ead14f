//! Tasks whose truth is known: stages in series, each of which can fail in a way of its own.
//!
//! A run passes the stages in order. A stage takes one step of 0.1 s; with probability `again` it is
//! tried again, which costs two steps; then it fails with probability `fails`, or the run goes on. With `p_i` the
//! probabilities of failure, the run is done with probability `(1-p_1) ... (1-p_k)`, whatever the
//! retries. Near its end, the hand passes the person at a speed that is log-normal.
//!
//! The same task is a chain in the PRISM language ([`Task::model`]) and a simulator ([`Task::run`]).

use crate::random::Random;
use std::fmt::Write as _;

/// The steps of a task in each second.
pub const STEPS_PER_SEC: u32 = 10;

/// The declared limit of the hand's speed near a person, in m/s.
pub const SPEED_LIMIT: f64 = 0.25;

/// The spread of the logarithm of the speed.
const SPEED_SPREAD: f64 = 0.2;

/// One stage, and the way in which it fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// The failure mode.
    pub mode: String,
    /// Probability that it fails, once it is reached.
    pub fails: f64,
    /// Probability that an attempt has to be repeated.
    pub again: f64,
}

/// A task.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// The stages in order.
    pub stages: Vec<Stage>,
    /// The stage at which the robot senses whether the person is ready: it fails where a sensor misses
    /// that the person is.
    pub sensing: usize,
    /// Median of the hand's speed near the person, in m/s.
    pub median_speed: f64,
}

/// What happened in one run.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Run {
    /// For each stage that was left, the steps by then.
    pub left_at: Vec<u32>,
    /// Whether the last of these failed.
    pub failed: bool,
    /// The hand's speed near the person, in m/s.
    pub speed: f64,
}

impl Task {
    /// The probability that a run is done.
    #[must_use]
    pub fn success(&self) -> f64 {
        self.stages.iter().map(|stage| 1.0 - stage.fails).product()
    }

    /// The probability that the hand is slower than `limit`, in m/s.
    #[must_use]
    pub fn slower_than(&self, limit: f64) -> f64 {
        stats::special::normal_cdf((limit / self.median_speed).ln() / SPEED_SPREAD)
    }

    /// The median speed at which the hand is slower than the limit with this probability.
    #[must_use]
    pub fn median_for(slow: f64) -> f64 {
        SPEED_LIMIT * (-SPEED_SPREAD * stats::special::normal_quantile(slow)).exp()
    }

    /// The place of a failure mode.
    #[must_use]
    pub fn stage_of(&self, mode: &str) -> Option<usize> {
        self.stages.iter().position(|stage| stage.mode == mode)
    }

    /// The mean number of steps of a run that is done.
    #[must_use]
    pub fn mean_steps(&self) -> f64 {
        let steps = |stage: &Stage| 1.0 + 2.0 * stage.again / (1.0 - stage.again);
        self.stages.iter().map(steps).sum()
    }

    /// One run.
    pub fn run(&self, random: &mut Random) -> Run {
        let mut run = Run::default();
        let mut steps = 0;
        for stage in &self.stages {
            steps += 1 + 2 * random.geometric(stage.again);
            run.left_at.push(steps);
            run.failed = random.chance(stage.fails);
            if run.failed {
                break;
            }
        }
        run.speed = self.median_speed * (SPEED_SPREAD * random.normal()).exp();
        run
    }

    /// The task as one person finds it: each rate is that person's own.
    pub fn of_person(&self, correlation: f64, random: &mut Random) -> Self {
        let mut own = self.clone();
        for stage in &mut own.stages {
            stage.fails = random.rate_of_cluster(stage.fails, correlation);
        }
        let slow = self.slower_than(SPEED_LIMIT);
        let slow = random.rate_of_cluster(slow, correlation);
        own.median_speed = Self::median_for(slow.clamp(1e-9, 1.0 - 1e-9));
        own
    }

    /// The task as a chain in the PRISM language. State `i` is stage `i`, then come "done", the
    /// failures, and the detours of retries. A stage with `fails = 0` has no failure in the text.
    #[must_use]
    pub fn model(&self) -> String {
        let k = self.stages.len();
        let mut text = String::from("dtmc\n");
        for stage in &self.stages {
            let (mode, fails, again) = (&stage.mode, stage.fails, stage.again);
            let _ = write!(
                text,
                "const double p_{mode} = {fails};\nconst double again_{mode} = {again};\n"
            );
        }
        let _ = write!(text, "module task\n  s : [0..{}] init 0;\n", 3 * k);
        for (i, stage) in self.stages.iter().enumerate() {
            let (mode, fail, retry) = (&stage.mode, k + 1 + i, 2 * k + 1 + i);
            let _ = write!(
                text,
                "  [] s={i} -> again_{mode}:(s'={retry}) + (1-again_{mode})*(1-p_{mode}):(s'={}) \
                 + (1-again_{mode})*p_{mode}:(s'={fail});\n  [] s={retry} -> (s'={i});\n",
                i + 1
            );
        }
        let _ = write!(text, "  [] s>={k} & s<={} -> true;\nendmodule\n", 2 * k);
        let _ = write!(
            text,
            "label \"ready\" = true;\nlabel \"done\" = s={k};\nlabel \"finished\" = s>={k} & s<={};\n",
            2 * k
        );
        for (i, stage) in self.stages.iter().enumerate() {
            let (mode, fail) = (&stage.mode, k + 1 + i);
            let _ = write!(
                text,
                "label \"reached_{mode}\" = s={i};\nlabel \"failed_{mode}\" = s={fail};\n"
            );
        }
        text
    }
}

impl Run {
    /// Whether all of `stages` were passed.
    #[must_use]
    pub fn is_done(&self, stages: usize) -> bool {
        self.left_at.len() == stages && !self.failed
    }

    /// Whether stage `place` was reached.
    #[must_use]
    pub fn reached(&self, place: usize) -> bool {
        self.left_at.len() > place
    }

    /// Whether it was there that the run failed.
    #[must_use]
    pub fn failed_at(&self, place: usize) -> bool {
        self.failed && self.left_at.len() == place + 1
    }

    /// Steps until the run ended.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.left_at.last().copied().unwrap_or(0)
    }
}
