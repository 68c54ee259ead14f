//! Whether an engine repeats itself: hashes of an episode's recordings.

use super::{Called, name_of, recording_hash};
use corroborate::technique::simulation::Campaign;
use diagnostic::Problem;
use evidence::FailureKind;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;

/// The recordings of one episode in one engine.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Repeated {
    /// The engine with its version.
    pub engine: String,
    /// The episode's number.
    pub episode: u64,
    /// Its seed.
    pub seed: u64,
    /// The hash of its recording, when the episodes ran beside each other.
    pub hash: String,
    /// The hash when it was run again, alone, after the others.
    pub again: String,
    /// The hash when it was saved in its middle and continued. Absent of an episode that a failure
    /// ended: it is not continued.
    pub continued: Option<String>,
    /// What ended it, if it did not end by itself.
    pub failed: Option<FailureKind>,
    /// Whether all are the same.
    pub same: bool,
}

impl Called<'_> {
    /// Runs each episode beside others, again, and in two parts.
    pub(super) fn repeat(&self) -> Result<Vec<Repeated>, Problem> {
        let mut all = Vec::new();
        for campaign in self.campaigns {
            let engine = name_of(campaign);
            let title = format!("{engine}: episodes, thrice");
            let stage = self.setting.events.begin(&title, self.numbers.len() as u64);
            let numbers = self.numbers.par_iter();
            let beside: Vec<(String, Option<FailureKind>)> = numbers
                .map(|number| self.hashed(campaign, *number))
                .collect::<Result<_, Problem>>()?;
            // In the other order, so that what a world keeps of an episode would show.
            for (number, (hash, failed)) in self.numbers.iter().zip(beside).rev() {
                let (again, failed_again) = self.hashed(campaign, *number)?;
                let continued = match failed.or(failed_again) {
                    Some(_) => None,
                    None => Some(self.in_two_parts(campaign, *number)?),
                };
                let same = hash == again
                    && failed == failed_again
                    && continued
                        .as_ref()
                        .is_none_or(|continued| *continued == hash);
                all.push(Repeated {
                    engine: engine.clone(),
                    episode: *number,
                    seed: self.seeds.of(*number),
                    hash,
                    again,
                    continued,
                    failed,
                    same,
                });
                stage.advance();
            }
        }
        Ok(all)
    }

    /// The hash of an episode's recording, and what ended it.
    fn hashed(
        &self,
        campaign: &Campaign,
        number: u64,
    ) -> Result<(String, Option<FailureKind>), Problem> {
        let run = self.run(campaign, number)?;
        let hash = run.trace().map_or_else(String::new, recording_hash);
        Ok((hash, run.failed))
    }

    fn in_two_parts(&self, campaign: &Campaign, number: u64) -> Result<String, Problem> {
        let seed = self.seeds.of(number);
        let run = campaign.run_in_two_parts(seed, &self.setting.cancel)?;
        Ok(recording_hash(&run.trace))
    }
}

/// Appends the hashes.
pub(super) fn text(repeated: &[Repeated], out: &mut String) {
    for it in repeated {
        let said = match it.same {
            true if it.failed.is_none() => "the same again and continued".to_owned(),
            true => "the same again".to_owned(),
            false => format!(
                "NOT the same: again {}, continued {}",
                it.again,
                it.continued.as_deref().unwrap_or("not")
            ),
        };
        let _ = writeln!(
            out,
            "{} episode {} (seed {}): {} {said}{}",
            it.engine,
            it.episode,
            it.seed,
            it.hash,
            it.failed.map_or(String::new(), |kind| format!("; {kind}"))
        );
    }
}
