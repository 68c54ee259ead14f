//! What was decided of a test's rate, and on which grounds.

use super::journal::Outcome as TrialOutcome;
use super::log_of;
use super::rule::{Counts, Course, OnError};
use super::tables::written_command;
use crate::Outcome;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;

/// The form of a report.
const FORMAT: &str = "1.0";

/// What was decided of a rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The rate is above the lower edge of the zone.
    Passed,
    /// The rate is below the upper edge of the zone.
    Failed,
    /// Neither is shown.
    Undecided,
}

impl Verdict {
    /// Its word.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Passed => "passed",
            Verdict::Failed => "failed",
            Verdict::Undecided => "undecided",
        }
    }
}

/// Why no further trials were taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StoppedBy {
    /// The rate is decided.
    Decided,
    /// As many trials as were allowed did not decide it.
    MaxTrials,
    /// The harness broke more often than was allowed.
    Errors,
    /// Not all trials are there yet.
    Unfinished,
}

/// Rates between a lower and an upper end.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Zone {
    /// The lower end.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// A trial that failed, or whose harness broke.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Failing {
    /// Its number, from 1.
    pub trial: u64,
    /// Its seed.
    pub seed: u64,
    /// How it ended.
    pub outcome: TrialOutcome,
    /// Why.
    pub why: String,
    /// The command that runs it again, as a shell takes it; `None` if it was not run by a command.
    pub command: Option<String>,
    /// The file in the folder of results with what it printed, if that was kept.
    pub log: Option<String>,
}

/// A rate, what was decided of it, and on which grounds.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct DecideReport {
    /// The form of this report; what begins with the same number can be read alike.
    pub format: String,
    /// The requirement that the test verifies.
    pub requirement: String,
    /// What was decided.
    pub verdict: Verdict,
    /// Why no further trials were taken.
    pub ended: StoppedBy,
    /// The rate of success that is required.
    pub at_least: f64,
    /// How far from it a rate may get either answer.
    pub margin: f64,
    /// One minus the probability of a wrong answer outside the zone.
    pub confidence: f64,
    /// The rates that may get either answer: a rate below is passed, and one above is failed, with probability of at most one minus
    /// the confidence.
    pub zone: Zone,
    /// How many trials ended how.
    pub counts: Counts,
    /// Trials that count: all but those that were not applicable.
    pub trials: u64,
    /// The share of trials that passed, of those whose outcome is known; `None` without any.
    pub rate: Option<f64>,
    /// The rates that the trials do not exclude, at the confidence and at all numbers of trials together, whatever unknown outcomes would
    /// have been.
    pub interval: Zone,
    /// Whether the interval shows the required rate itself, without the margin.
    pub shows_at_least: bool,
    /// What the answer is worth, in words.
    pub guarantee: String,
    /// Of an undecided rate: how many further trials would decide it if they succeed as often as those so far. A forecast, not a
    /// bound; `None` where no number is enough to tell, and where it is decided.
    pub further_trials: Option<u64>,
    /// What broken trials count for.
    pub on_error: OnError,
    /// How many trials are run at most.
    pub max_trials: u64,
    /// The stream that seeds are drawn from.
    pub seed: u64,
    /// The program and its arguments, before seeds are filled in.
    pub command: Vec<String>,
    /// Trials that failed or broke, in their order.
    pub failing: Vec<Failing>,
}

/// What was asked for.
pub(super) struct Asked<'a> {
    pub(super) requirement: &'a str,
    pub(super) command: &'a [String],
    pub(super) seed: u64,
    pub(super) folder: &'a Path,
}

impl DecideReport {
    pub(super) fn of(course: &Course, asked: Asked<'_>) -> Self {
        let (rule, test, counts) = (course.rule(), course.test(), course.counts());
        let ends = course.ends();
        // Those that are no success at either end, and no unknown one.
        let known = counts.passed + ends[1].trials - ends[1].successes;
        let limits = stats::time_uniform_limits(ends, test.confidence());
        let is_open = course.verdict() == Verdict::Undecided;
        let zone = test.zone();
        Self {
            format: FORMAT.into(),
            requirement: asked.requirement.to_owned(),
            verdict: course.verdict(),
            ended: course.ended().unwrap_or(StoppedBy::Unfinished),
            at_least: rule.at_least,
            margin: rule.margin,
            confidence: rule.confidence,
            zone: Zone {
                low: tidy(zone.low),
                high: tidy(zone.high),
            },
            counts,
            trials: ends[0].trials,
            rate: (known > 0).then(|| counts.passed as f64 / known as f64),
            interval: Zone {
                low: limits.low,
                high: limits.high,
            },
            shows_at_least: limits.low >= rule.at_least,
            guarantee: guarantee(course),
            further_trials: (is_open && known > 0)
                .then(|| test.further_trials(ends))
                .flatten(),
            on_error: rule.on_error,
            max_trials: rule.max_trials,
            seed: asked.seed,
            command: asked.command.to_vec(),
            failing: failing(course, &asked),
        }
    }

    /// The counted rate, its interval and for how many trials it holds, in one line.
    #[must_use]
    pub fn rate_in_words(&self) -> String {
        let Some(rate) = self.rate else {
            return "no trial has a known outcome".to_owned();
        };
        let known = self.trials - self.unknown();
        format!(
            "{}/{known} = {}, {} CI {} to {} (at any number of trials)",
            self.counts.passed,
            percent(rate),
            percent(self.confidence),
            percent(self.interval.low),
            percent(self.interval.high)
        )
    }

    /// How many trials have an outcome that is unknown.
    #[must_use]
    pub fn unknown(&self) -> u64 {
        match self.on_error {
            OnError::Unknown => self.counts.errors,
            OnError::Failure => 0,
        }
    }

    /// Why it is undecided, and what would decide it; `None` if it is decided.
    #[must_use]
    pub fn undecided_in_words(&self) -> Option<String> {
        let why = match self.ended {
            StoppedBy::Decided => return None,
            StoppedBy::MaxTrials => format!("{} trials do not decide it", self.counts.trials()),
            StoppedBy::Errors => format!("the harness broke in {} trials", self.counts.errors),
            StoppedBy::Unfinished => "not all trials have ended".to_owned(),
        };
        let more = match (self.ended, self.further_trials) {
            (StoppedBy::Errors, _) => {
                "repair it first: what those trials printed is kept".to_owned()
            }
            _ if self.rate.is_none() => {
                "no trial has a known outcome, from which further ones could be forecast".to_owned()
            }
            (_, Some(more)) => format!("about {more} more would, at the rate seen so far"),
            (_, None) => {
                "no number of trials would, at the rate seen so far: widen the margin".to_owned()
            }
        };
        Some(format!("{why}; {more}"))
    }
}

impl crate::Ended for DecideReport {
    /// Whether the rate is shown.
    fn outcome(&self) -> Outcome {
        match self.verdict {
            Verdict::Passed => Outcome::Holds,
            Verdict::Failed => Outcome::Violated,
            Verdict::Undecided => Outcome::Inconclusive,
        }
    }
}

/// Without the last digits of a difference of decimal numbers.
fn tidy(rate: f64) -> f64 {
    (rate * 1e12).round() / 1e12
}

/// A share in percent, with two digits behind the point and no trailing zeros. What is neither nothing nor all is not shown as such.
#[must_use]
pub fn percent(share: f64) -> String {
    let hundredths = (1e4 * share).round();
    let shown = match share > 0.0 && share < 1.0 {
        true => hundredths.clamp(1.0, 9999.0),
        false => hundredths,
    };
    let text = format!("{:.2}", shown / 100.0);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    format!("{text} %")
}

fn guarantee(course: &Course) -> String {
    let (zone, alpha) = (course.test().zone(), course.test().confidence().alpha());
    let (low, high, wrong) = (percent(zone.low), percent(zone.high), percent(alpha));
    match course.verdict() {
        Verdict::Passed => format!(
            "a test whose rate is {low} or less passes with probability at most {wrong}, however trials are stopped"
        ),
        Verdict::Failed => format!(
            "a test whose rate is {high} or more fails with probability at most {wrong}, however trials are stopped"
        ),
        Verdict::Undecided => format!(
            "neither a rate above {low} nor one below {high} is shown at {}",
            percent(course.rule().confidence)
        ),
    }
}

fn failing(course: &Course, asked: &Asked<'_>) -> Vec<Failing> {
    let failing = course.trials().iter().filter(|it| it.outcome.is_failing());
    let failing = failing.map(|it| Failing {
        trial: it.trial,
        seed: it.seed,
        outcome: it.outcome,
        why: it.why.clone(),
        command: (!asked.command.is_empty())
            .then(|| written_command(asked.command, it.seed, it.trial)),
        log: log_of(asked.folder, it.trial),
    });
    failing.collect()
}
