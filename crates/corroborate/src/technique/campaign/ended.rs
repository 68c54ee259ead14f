//! Failures of episodes that stand in no campaign's journal: those of `rare`, `what-if`, `engines`, `diagnose` and the
//! search for disagreement.
//!
//! They count as in a campaign (`failing.rs`): such an episode stays a trial, is judged up to where it was ended, and
//! its kind is counted, unless the entry of the ledger declares that one ends it all. Only what fails in the first episode before anything has begun is a mistake of the study.

use super::failing::EpisodeFailure;
use super::tally::{WITNESSES, witness};
use crate::technique::simulation::{Seeds, problem_at};
use diagnostic::Problem;
use evidence::{EpisodeFailures, FailureKind, Measure};
use std::collections::BTreeMap;
use study::{Entry, OnFailure};
use testbench::{Recorded, SimError};

/// An episode, as far as it went.
#[derive(Debug)]
pub struct Ended {
    /// What was recorded; none where physics gave no numbers.
    pub recorded: Option<Recorded>,
    /// What ended it, if it did not end by itself.
    pub failed: Option<FailureKind>,
    /// What was said then.
    pub words: String,
}

impl Ended {
    /// What was recorded.
    pub fn trace(&self) -> Option<&trace::Trace> {
        self.recorded.as_ref().map(|recorded| &recorded.trace)
    }
}

/// What became of an episode; an error is what says nothing of it.
pub fn ended(run: Result<Recorded, SimError>, seed: u64, is_first: bool) -> Result<Ended, Problem> {
    let recorded = match run {
        Ok(recorded) => recorded,
        Err(error) => {
            let failure = failure_of(&error).ok_or_else(|| problem_at(seed, &error))?;
            return Ok(Ended {
                recorded: None,
                failed: Some(failure.kind),
                words: failure.words,
            });
        }
    };
    let failed = match &recorded.failure {
        Some(failure) if failure.in_setup && is_first => {
            return Err(never_worked(&failure.words, seed));
        }
        failure => failure.as_ref().map(EpisodeFailure::of),
    };
    let (failed, words) = failed.map(|it| (it.kind, it.words)).unzip();
    Ok(Ended {
        recorded: Some(recorded),
        failed,
        words: words.unwrap_or_default(),
    })
}

/// The first failure as an error, where the entry declares that one ends the campaign; of episodes by number, in their
/// order.
pub fn stops<'a>(
    entry: &Entry,
    seeds: &Seeds,
    episodes: impl IntoIterator<Item = (u64, Option<FailureKind>, &'a str)>,
) -> Result<(), Problem> {
    if entry.sampling.on_failure == OnFailure::Count {
        return Ok(());
    }
    let mut episodes = episodes.into_iter();
    let failed = episodes.find_map(|(number, kind, words)| {
        let words = words.to_owned();
        let failure = EpisodeFailure { kind: kind?, words };
        Some(failure.problem(number, seeds.of(number)))
    });
    match failed {
        Some(problem) => Err(problem.remedy(format!(
            "mend the program, or count such episodes: {} declares `on_failure = \"stop\"`",
            entry.id
        ))),
        None => Ok(()),
    }
}

/// A failure that comes as an error: of a robot's program in a run that is taken step by step, or of the physics.
pub fn failure_of(error: &SimError) -> Option<EpisodeFailure> {
    match error {
        SimError::Controller(error) => {
            let failure = testbench::Failure::of_controller(error, false);
            Some(EpisodeFailure::of(&failure))
        }
        other => EpisodeFailure::of_simulator(other),
    }
}

/// Said of a program that could not be set up in the first episode.
pub fn never_worked(words: &str, seed: u64) -> Problem {
    let message = format!("seed {seed}: {words}");
    Problem::new("controller-failed", message)
        .remedy("it has not worked once: check what the study says of it")
}

/// How often failures ended episodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FailureCounts {
    episodes: u64,
    failed: BTreeMap<FailureKind, (u64, Vec<String>)>,
}

impl FailureCounts {
    /// Counts of episodes, by number, in their order.
    pub fn of(episodes: impl IntoIterator<Item = (u64, Option<FailureKind>)>) -> Self {
        let mut counts = Self::default();
        for (number, failed) in episodes {
            counts.episodes += 1;
            if let Some(kind) = failed {
                let (count, witnesses) = counts.failed.entry(kind).or_default();
                *count += 1;
                witness(witnesses, &format!("episode {number}"));
            }
        }
        counts
    }

    /// Whether all episodes ended by themselves.
    pub fn is_empty(&self) -> bool {
        self.failed.is_empty()
    }

    /// Of each kind, its share of all episodes with Wilson's interval.
    pub fn shares(&self, level: stats::Confidence) -> Result<Vec<EpisodeFailures>, Problem> {
        let failed = self.failed.iter();
        let shares = failed.map(|(kind, (count, witnesses))| {
            Ok(EpisodeFailures {
                kind: *kind,
                measure: crate::technique::counts(*count, self.episodes, None, level)?,
                witnesses: witnesses[..witnesses.len().min(WITNESSES)].to_vec(),
            })
        });
        shares.collect()
    }
}

/// In words: `the robot's program fails in 3 of 20 episodes (15.0 %, 5.2 to 36.0 %), first in episode 4`.
pub fn in_words(failures: &EpisodeFailures) -> String {
    let Measure::Counts {
        count,
        trials,
        interval,
        ..
    } = &failures.measure
    else {
        return failures.kind.to_string();
    };
    let percent = |share: f64| 100.0 * share;
    let first = failures.witnesses.first();
    format!(
        "{} in {count} of {trials} episodes ({:.1} %, {:.1} to {:.1} %){}",
        failures.kind,
        percent(*count as f64 / *trials as f64),
        percent(interval.low),
        percent(interval.high),
        first.map_or(String::new(), |first| format!(", first in {first}"))
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use testbench::controller::ControllerError;

    #[test]
    fn failures_are_counted_and_mistakes_are_not() {
        let unstable = SimError::Unstable {
            seed: 7,
            time_secs: 1.0,
        };
        let found = ended(Err(unstable), 7, true).expect("an outcome");
        assert_eq!(found.failed, Some(FailureKind::SimulatorFailed));
        assert!(found.recorded.is_none());
        let mistake = SimError::Stimulus { reason: "r".into() };
        assert!(ended(Err(mistake), 7, false).is_err());
        let silent = SimError::Controller(ControllerError::Silent { reason: "r".into() });
        let kind = failure_of(&silent).map(|it| it.kind);
        assert_eq!(kind, Some(FailureKind::ControllerHung));

        let level = stats::Confidence::new(0.95).expect("a level");
        let kinds = [None, kind, None, kind];
        let counts = FailureCounts::of((1..).zip(kinds));
        let shares = counts.shares(level).expect("counts");
        assert_eq!(shares.len(), 1);
        let words = in_words(&shares[0]);
        assert!(
            words.starts_with(
                "the robot's program hangs in 2 of 4 episodes (50.0 %, 15.0 to 85.0 %)"
            ),
            "{words}"
        );
        assert!(words.ends_with("first in episode 2"), "{words}");
        assert!(FailureCounts::of([(1, None)]).is_empty());
    }
}
