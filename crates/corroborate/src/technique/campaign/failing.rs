//! Episodes that are ended by what is tested, or by its simulator.
//!
//! Leaving such an episode out would bias what the others show, and stopping at it would keep the
//! campaign from ever getting past its seed: it is a trial that failed. So it is judged up to there
//! as a recording that was cut short, its `end` in the journal is the kind of the failure, and what
//! the program said is kept beside the recordings. Those words are no part of what is reproducible
//! (a dying process may say more or less), so neither journal nor recording holds them.
//!
//! What fails before it has ever worked is a mistake of the set-up and ends the campaign.

use diagnostic::Problem;
use evidence::FailureKind;
use host::files::write_whole;
use std::path::{Path, PathBuf};
use testbench::{Failure, SimError};

/// What ended an episode.
#[derive(Clone, Debug)]
pub struct EpisodeFailure {
    /// Its kind.
    pub kind: FailureKind,
    /// All that is known of it, what the program said last behind it.
    pub words: String,
}

impl EpisodeFailure {
    /// A robot's program, or a simulator that is a command, that failed.
    pub fn of(failure: &Failure) -> Self {
        Self {
            kind: kind_of(failure),
            words: failure.words.clone(),
        }
    }

    /// Physics that gave no numbers; `None` for what says nothing of the episode.
    pub fn of_simulator(error: &SimError) -> Option<Self> {
        is_of_physics(error).then(|| Self {
            kind: FailureKind::SimulatorFailed,
            words: error.to_string(),
        })
    }

    /// The failure as an error that ends the campaign.
    pub fn problem(&self, number: u64, seed: u64) -> Problem {
        let code = match self.kind {
            FailureKind::ControllerFailed | FailureKind::ControllerHung => "controller-failed",
            FailureKind::SimulatorFailed | FailureKind::SimulatorHung => "episode-failed",
        };
        let message = format!("episode {number} (seed {seed}): {}", self.words);
        Problem::new(code, message)
    }

    /// Keeps what was said beside the recordings.
    pub fn keep(&self, folder: &Path, number: u64, seed: u64) -> Result<(), Problem> {
        let text = format!(
            "episode {number}, seed {seed}: {}\n{}\n",
            self.kind.name(),
            self.words
        );
        write_whole(&words_of(folder, number), text.as_bytes())
    }
}

/// Whether physics gave no numbers, so that nothing can be said of what is simulated.
pub fn is_of_physics(error: &SimError) -> bool {
    matches!(error, SimError::Unstable { .. } | SimError::Trace(_))
}

/// The kind of a program's failure.
pub fn kind_of(failure: &Failure) -> FailureKind {
    FailureKind::named(failure.kind()).unwrap_or(FailureKind::ControllerFailed)
}

/// Where what was said in an episode that failed is kept. It is named unlike a recording.
pub fn words_of(folder: &Path, number: u64) -> PathBuf {
    folder.join(format!("failure-{number:05}.txt"))
}

/// Said of a failure that an earlier call has counted, where it is to end the campaign.
pub fn stopped_by(folder: &Path, number: u64, kind: FailureKind) -> Problem {
    let words = std::fs::read_to_string(words_of(folder, number));
    let words = words.unwrap_or_else(|_| format!("episode {number}: {}", kind.name()));
    Problem::new("episode-failed", words.trim_end().to_owned()).remedy(
        "mend the program, or count such episodes (`--on-failure count` on the command line)",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use testbench::controller::ControllerError;

    #[test]
    fn every_failure_of_a_controller_has_a_kind_of_ours() {
        let silent = ControllerError::Silent { reason: "r".into() };
        let gone = ControllerError::Transport { reason: "r".into() };
        for (error, kind) in [
            (silent, FailureKind::ControllerHung),
            (gone, FailureKind::ControllerFailed),
        ] {
            let failure = Failure::of_controller(&error, false);
            assert_eq!(FailureKind::named(failure.kind()), Some(kind));
            assert_eq!(kind_of(&failure), kind);
        }
    }
}
