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
    /// Whether the task has this failure at all: a model may have left it out.
    pub can_fail: bool,
}

/// A task.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// How it goes on.
    pub course: Course,
    /// The stages in order.
    pub stages: Vec<Stage>,
    /// The stage at which the robot senses whether the person is ready: it fails where a sensor misses
    /// that the person is.
    pub sensing: usize,
    /// Median of the hand's speed near the person, in m/s.
    pub median_speed: f64,
}

/// How a task goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Course {
    /// Through its stages in order, until one fails.
    Stages,
    /// As the corridor's journey, which arrives whatever happens ([`crate::journey`]).
    Journey,
}

/// A stage that was left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passed {
    /// Its place.
    pub place: usize,
    /// The steps by then.
    pub at: u32,
    /// Whether it failed.
    pub failed: bool,
}

/// What happened in one run.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Run {
    /// The stages that were left, in their order.
    pub passed: Vec<Passed>,
    /// The steps by which it was done, if it was.
    pub done_at: Option<u32>,
    /// The hand's speed near the person, in m/s.
    pub speed: f64,
}

impl Task {
    /// The probability that a run is done.
    #[must_use]
    pub fn success(&self) -> f64 {
        match self.course {
            Course::Stages => self.stages.iter().map(|stage| 1.0 - stage.fails).product(),
            Course::Journey => 1.0,
        }
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
        let mut run = match self.course {
            Course::Stages => self.run_stages(random),
            Course::Journey => crate::journey::run(self, random),
        };
        run.speed = self.median_speed * (SPEED_SPREAD * random.normal()).exp();
        run
    }

    fn run_stages(&self, random: &mut Random) -> Run {
        let mut run = Run::default();
        let mut steps = 0;
        for (place, stage) in self.stages.iter().enumerate() {
            steps += 1 + 2 * random.geometric(stage.again);
            let failed = random.chance(stage.fails);
            run.passed.push(Passed {
                place,
                at: steps,
                failed,
            });
            if failed {
                return run;
            }
        }
        run.done_at = Some(steps);
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

    /// Whether the model has a constant for how often this stage is passed, as authors of models often write it; else
    /// it has one for how often it fails.
    #[must_use]
    pub fn says_what_passes(place: usize) -> bool {
        place % 2 == 1
    }

    /// The name of that constant.
    #[must_use]
    pub fn constant(place: usize, mode: &str) -> String {
        let sign = if Self::says_what_passes(place) {
            'q'
        } else {
            'p'
        };
        format!("{sign}_{mode}")
    }

    /// The task as a chain in the PRISM language. Its states have names: `at_` each stage, `retry_` of it, `done`, and
    /// `failed_` at it. A stage that cannot fail has no failure in the text.
    #[must_use]
    pub fn model(&self) -> String {
        let mut text = String::from("dtmc\n");
        for (place, stage) in self.stages.iter().enumerate() {
            let (mode, again) = (&stage.mode, stage.again);
            let _ = writeln!(text, "const double again_{mode} = {again};");
            if stage.can_fail {
                let value = match Self::says_what_passes(place) {
                    true => 1.0 - stage.fails,
                    false => stage.fails,
                };
                let name = Self::constant(place, mode);
                let _ = writeln!(text, "const double {name} = {value};");
            }
        }
        let last = self.name_states(&mut text);
        let _ = write!(text, "module task\n  s : [0..{last}] init 0;\n");
        for (i, stage) in self.stages.iter().enumerate() {
            let mode = &stage.mode;
            let next = match self.stages.get(i + 1) {
                Some(next) => format!("at_{}", next.mode),
                None => "done".into(),
            };
            let name = Self::constant(i, mode);
            let (passes, fails) = match Self::says_what_passes(i) {
                true => (name.clone(), format!("(1-{name})")),
                false => (format!("(1-{name})"), name.clone()),
            };
            let passes = if stage.can_fail {
                format!(
                    "(1-again_{mode})*{passes}:(s'={next}) + (1-again_{mode})*{fails}:(s'=failed_{mode})"
                )
            } else {
                format!("1-again_{mode}:(s'={next})")
            };
            let _ = write!(
                text,
                "  [] s=at_{mode} -> again_{mode}:(s'=retry_{mode}) + {passes};\n  [] s=retry_{mode} -> (s'=at_{mode});\n"
            );
        }
        text.push_str("  [] s>=done -> true;\nendmodule\n");
        text
    }

    /// Writes the names of the states; the last of them.
    fn name_states(&self, text: &mut String) -> usize {
        let k = self.stages.len();
        let mut last = 2 * k;
        let _ = writeln!(text, "const int done = {last};");
        for (i, stage) in self.stages.iter().enumerate() {
            let mode = &stage.mode;
            let _ = write!(
                text,
                "const int at_{mode} = {i};\nconst int retry_{mode} = {};\n",
                k + i
            );
            if stage.can_fail {
                last += 1;
                let _ = writeln!(text, "const int failed_{mode} = {last};");
            }
        }
        last
    }
}

impl Run {
    /// Whether it was done.
    #[must_use]
    pub fn is_done(&self) -> bool {
        self.done_at.is_some()
    }

    /// Whether stage `place` was reached.
    #[must_use]
    pub fn reached(&self, place: usize) -> bool {
        self.passed.iter().any(|passed| passed.place == place)
    }

    /// Whether it failed there.
    #[must_use]
    pub fn failed_at(&self, place: usize) -> bool {
        let mut all = self.passed.iter();
        all.any(|passed| passed.place == place && passed.failed)
    }

    /// Whether it was done within so many steps.
    #[must_use]
    pub fn is_done_by(&self, steps: u32) -> bool {
        self.done_at.is_some_and(|at| at <= steps)
    }
}
