//! Whether an engine repeats itself: hashes of an episode's recordings.

use super::{Called, name_of, recording_hash};
use crate::problem::Problem;
use crate::technique::simulation::Campaign;
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
    /// The hash when it was saved in its middle and continued.
    pub continued: String,
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
            let stage = self.setting.talk.begin(&title, self.numbers.len() as u64);
            let numbers = self.numbers.par_iter();
            let beside: Vec<String> = numbers
                .map(|number| Ok(recording_hash(&self.run(campaign, *number)?)))
                .collect::<Result<_, Problem>>()?;
            // In the other order, so that what a world keeps of an episode would show.
            for (number, hash) in self.numbers.iter().zip(beside).rev() {
                let again = recording_hash(&self.run(campaign, *number)?);
                let continued = self.in_two_parts(campaign, *number)?;
                let same = hash == again && hash == continued;
                all.push(Repeated {
                    engine: engine.clone(),
                    episode: *number,
                    seed: self.seeds.of(*number),
                    hash,
                    again,
                    continued,
                    same,
                });
                stage.advance();
            }
        }
        Ok(all)
    }

    fn in_two_parts(&self, campaign: &Campaign, number: u64) -> Result<String, Problem> {
        let seed = self.seeds.of(number);
        let run = campaign.run_in_two_parts(seed, &self.setting.interrupt)?;
        Ok(recording_hash(&run.trace))
    }
}

/// Appends the hashes.
pub(super) fn text(repeated: &[Repeated], out: &mut String) {
    for it in repeated {
        let said = match it.same {
            true => "the same again and continued".to_owned(),
            false => format!(
                "NOT the same: again {}, continued {}",
                it.again, it.continued
            ),
        };
        let _ = writeln!(
            out,
            "{} episode {} (seed {}): {} {said}",
            it.engine, it.episode, it.seed, it.hash
        );
    }
}
