//! Whether an engine repeats itself: hashes of an episode's recordings.

use super::compared::Called;
use super::name_of;
use crate::technique::simulation::{in_two_parts, problem_at};
use diagnostic::Problem;
use evidence::FailureKind;
use host::store::Inputs;
use rayon::prelude::*;
use rig::Rig;
use schemars::JsonSchema;
use serde::Serialize;
use trace::Trace;

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
    /// ended, and of a command: they are not continued.
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
        for rig in self.rigs.iter().map(AsRef::as_ref) {
            let engine = name_of(rig);
            let title = format!("{engine}: episodes, thrice");
            let stage = self.host.events.begin(&title, self.numbers.len() as u64);
            let numbers = self.numbers.par_iter();
            let beside: Vec<(String, Option<FailureKind>)> = numbers
                .map(|number| self.hashed(rig, *number))
                .collect::<Result<_, Problem>>()?;
            // In the other order, so that what a world keeps of an episode would show.
            for (number, (hash, failed)) in self.numbers.iter().zip(beside).rev() {
                let (again, failed_again) = self.hashed(rig, *number)?;
                let continued = match failed.or(failed_again) {
                    Some(_) => None,
                    None => self.continued(rig, *number)?,
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
    fn hashed(&self, rig: &dyn Rig, number: u64) -> Result<(String, Option<FailureKind>), Problem> {
        let run = self.run(rig, number)?;
        let hash = run.trace().map_or_else(String::new, recording_hash);
        Ok((hash, run.failed))
    }

    /// The hash of an episode's recording that was saved in its middle; none of a rig whose runs cannot be saved.
    fn continued(&self, rig: &dyn Rig, number: u64) -> Result<Option<String>, Problem> {
        let Some(bench) = rig.resumable() else {
            return Ok(None);
        };
        let seed = self.seeds.of(number);
        let run = in_two_parts(bench, rig.stimulus(), seed, &self.host.cancel);
        let run = run.map_err(|error| problem_at(seed, &error))?;
        Ok(Some(recording_hash(&run.trace)))
    }
}

/// The hash of a recording: names, times and values, without its metadata,
/// which names engine and version.
fn recording_hash(trace: &Trace) -> String {
    let mut inputs = Inputs::default();
    for channel in &trace.channels {
        inputs.add("topic", channel.topic.as_bytes());
        for field in &channel.fields {
            inputs.add("field", field.name.as_bytes());
        }
        for (name, numbers) in [("times", &channel.times_secs), ("values", &channel.values)] {
            let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
            inputs.add(name, &bytes);
        }
    }
    inputs.hash()
}
