//! When trials are enough: what is asked of the rate, and the counts so far.

use super::journal::{Outcome, Trial};
use super::report::{StoppedBy, Verdict};
use diagnostic::Problem;
use schemars::JsonSchema;
use serde::Serialize;
use stats::{Confidence, Decision, IndifferenceTest, Sample};
use study::Choice;

/// What a trial counts for whose harness broke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OnError {
    /// Its outcome is unknown: it counts against either answer.
    Unknown,
    /// It is a failure of what is tested.
    Failure,
}

impl Choice for OnError {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            OnError::Unknown,
            "unknown",
            "Its outcome is unknown: it counts against either answer",
        ),
        (
            OnError::Failure,
            "failure",
            "It is a failure of what is tested",
        ),
    ];
}

/// What is asked of a rate, and when to stop asking. [`DecideRule::new`] has the defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DecideRule {
    /// The rate of success that is required.
    pub at_least: f64,
    /// One minus the probability of a wrong answer outside the zone.
    pub confidence: f64,
    /// Rates nearer to what is required than this may get either answer.
    pub margin: f64,
    /// How many trials are run at most, those that were not applicable included.
    pub max_trials: u64,
    /// After how many broken trials it is given up.
    pub max_errors: u64,
    /// What broken trials count for.
    pub on_error: OnError,
}

/// The part of a rule that trials counted together have in common.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Fixed {
    at_least: f64,
    confidence: f64,
    margin: f64,
    on_error: OnError,
}

impl DecideRule {
    /// At least this rate at 95 %, without a margin, in 400 trials at most, of which ten may break.
    #[must_use]
    pub fn new(at_least: f64) -> Self {
        Self {
            at_least,
            confidence: 0.95,
            margin: 0.0,
            max_trials: 400,
            max_errors: 10,
            on_error: OnError::Unknown,
        }
    }

    pub(super) fn fixed(&self) -> Fixed {
        Fixed {
            at_least: self.at_least,
            confidence: self.confidence,
            margin: self.margin,
            on_error: self.on_error,
        }
    }

    /// The test that decides.
    ///
    /// # Errors
    /// `bad-rule`.
    pub fn test(&self) -> Result<IndifferenceTest, Problem> {
        let test = Confidence::new(self.confidence)
            .and_then(|level| IndifferenceTest::new(self.at_least, self.margin, level));
        test.map_err(|error| {
            Problem::new("bad-rule", error.to_string()).remedy(
                "the required rate less the margin must be above 0, and with the margin below 1: for example at least 0.95 with \
                 a margin of 0.02; confidence is a number between 0 and 1, such as 0.95",
            )
        })
    }
}

/// How many trials ended how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Counts {
    /// Passed.
    pub passed: u64,
    /// Failed.
    pub failed: u64,
    /// The harness broke.
    pub errors: u64,
    /// The test said that it was not applicable.
    pub not_applicable: u64,
}

impl Counts {
    /// All trials.
    #[must_use]
    pub fn trials(&self) -> u64 {
        self.passed + self.failed + self.errors + self.not_applicable
    }

    /// The counts with all unknown outcomes as failures, and as successes.
    #[must_use]
    pub fn ends(&self, on_error: OnError) -> [Sample; 2] {
        let trials = self.passed + self.failed + self.errors;
        let unknown = match on_error {
            OnError::Unknown => self.errors,
            OnError::Failure => 0,
        };
        [self.passed, self.passed + unknown].map(|successes| Sample { successes, trials })
    }

    fn add(&mut self, outcome: Outcome) {
        *match outcome {
            Outcome::Pass => &mut self.passed,
            Outcome::Fail => &mut self.failed,
            Outcome::Error => &mut self.errors,
            Outcome::NotApplicable => &mut self.not_applicable,
        } += 1;
    }
}

/// Trials in the order of their numbers, and how they stand.
#[derive(Debug)]
pub(super) struct Course {
    rule: DecideRule,
    test: IndifferenceTest,
    counts: Counts,
    trials: Vec<Trial>,
    ended: Option<StoppedBy>,
    verdict: Verdict,
}

impl Course {
    pub(super) fn new(rule: DecideRule, test: IndifferenceTest) -> Self {
        Self {
            rule,
            test,
            counts: Counts::default(),
            trials: Vec::new(),
            ended: None,
            verdict: Verdict::Undecided,
        }
    }

    /// Takes the next trial, and says whether that was the last. Behind the last no trial is taken.
    pub(super) fn take(&mut self, trial: Trial) -> bool {
        if self.ended.is_some() {
            return true;
        }
        self.counts.add(trial.outcome);
        self.trials.push(trial);
        self.verdict = match self.test.decide(self.ends()) {
            Decision::AtLeast => Verdict::Passed,
            Decision::Below => Verdict::Failed,
            Decision::Open => Verdict::Undecided,
        };
        self.ended = if self.verdict != Verdict::Undecided {
            Some(StoppedBy::Decided)
        } else if self.counts.errors > self.rule.max_errors {
            Some(StoppedBy::Errors)
        } else if self.counts.trials() >= self.rule.max_trials {
            Some(StoppedBy::MaxTrials)
        } else {
            None
        };
        self.ended.is_some()
    }

    pub(super) fn rule(&self) -> &DecideRule {
        &self.rule
    }

    pub(super) fn test(&self) -> &IndifferenceTest {
        &self.test
    }

    pub(super) fn counts(&self) -> Counts {
        self.counts
    }

    pub(super) fn ends(&self) -> [Sample; 2] {
        self.counts.ends(self.rule.on_error)
    }

    pub(super) fn trials(&self) -> &[Trial] {
        &self.trials
    }

    pub(super) fn verdict(&self) -> Verdict {
        self.verdict
    }

    /// Why no more trials are taken; not all that were asked for are there yet if there is no reason.
    pub(super) fn ended(&self) -> Option<StoppedBy> {
        self.ended
    }

    /// How it stands, for people who wait.
    pub(super) fn in_words(&self) -> String {
        let [lowest, _] = self.ends();
        format!("{lowest} succeeded")
    }
}
