//! The estimate of one event, part by part; finished parts are kept.

use super::file::CODE;
use super::report::{EventReport, PlainReport};
use super::runs::{EpisodeOfInputs, Runs, RunsEnded};
use crate::technique::campaign::{FailureCounts, never_worked};
use crate::technique::rows::{Rows, Value};
use crate::technique::simulation::Seeds;
use crate::test_bench::{begins, stimulus_at};
use campaign::splitting::{
    Descent, RareEstimate, SplittingOptions, SubsetOptions, combine, split, subset,
};
use diagnostic::{Problem, Source};
use host::store::{Inputs, Store};
use rayon::prelude::*;
use rig::{check_units, tried};
use stats::special::normal_sf;
use stats::{Confidence, Sample, clopper_pearson};
use stimulus::Space;
use study::placed::quoted;
use testbench::SimError;

/// Plain episodes that are kept together.
const CHUNK: u64 = 64;

/// The estimate of one event, part by part.
pub struct Work<'a> {
    pub runs: Runs<'a>,
    pub store: &'a Store,
    pub inputs: Inputs,
    pub seeds: Seeds,
    pub space: Space,
}

impl Work<'_> {
    /// Fails unless the middle of the inputs can be simulated, and both ends of each.
    pub fn accepts(&self, source: &Source) -> Result<(), Problem> {
        check_units(&self.space, source, CODE)?;
        let rig = self.runs.rig;
        let middle = vec![0.5; self.space.dimensions()];
        let stimulus = stimulus_at(rig.stimulus(), &self.space, &middle)?;
        if let Err(SimError::Controller(error)) = begins(rig, &stimulus) {
            return Err(never_worked(&error.to_string(), 0));
        }
        for (place, parameter) in self.space.parameters.iter().enumerate() {
            for end in tried(&parameter.distribution) {
                let mut unit = middle.clone();
                unit[place] = end;
                let stimulus = stimulus_at(rig.stimulus(), &self.space, &unit)?;
                let Err(SimError::Stimulus { reason }) = begins(rig, &stimulus) else {
                    continue;
                };
                let value = parameter.distribution.quantile(end);
                let message = format!("`{}` cannot be {value}: {reason}", parameter.name);
                return Err(Problem::new("bad-settings", message)
                    .at(source, quoted(source, &parameter.name))
                    .remedy("correct the keys that it sets, or its range"));
            }
        }
        Ok(())
    }

    /// The report, and the rows of whole episodes.
    pub fn report(&self, level: Confidence, rows: &mut Rows) -> Result<EventReport, Problem> {
        let event = self.runs.event;
        let (descents, ended) = self.replications(rows)?;
        let estimate = combine(&descents, level).map_err(problem)?;
        let plain = match event.plain {
            0 => None,
            episodes => Some(self.plain(episodes, &estimate, level, rows)?),
        };
        Ok(EventReport {
            name: event.name.clone(),
            meaning: event.meaning.clone(),
            guarantee: self.guarantee(level),
            limit: event.limit(),
            probability: estimate.probability,
            low: estimate.interval.low,
            high: estimate.interval.high,
            relative_error: estimate.relative_error,
            replications: estimate.replications,
            episode_equivalents: estimate.episode_equivalents,
            plain_episodes_for_the_same_error: estimate.plain_equivalent,
            failures: ended.reports(),
            plain,
        })
    }

    /// All replications, and what ended their runs.
    fn replications(&self, rows: &mut Rows) -> Result<(Vec<Descent>, RunsEnded), Problem> {
        let event = self.runs.event;
        let stage = (self.runs.host.events).begin(&event.name, event.replications);
        let (mut descents, mut ended) = (Vec::new(), RunsEnded::default());
        for replication in 0..event.replications {
            let (descent, of_runs): (Descent, RunsEnded) =
                self.kept("replication", replication, |seed| {
                    let descent = self.descent(seed)?;
                    Ok((descent, self.runs.take_ended()))
                })?;
            descents.push(descent);
            for episode in &of_runs.episodes {
                self.row(rows, &format!("replication {}", replication + 1), episode);
            }
            ended.add(&of_runs);
            stage.advance();
        }
        Ok((descents, ended))
    }

    fn guarantee(&self, level: Confidence) -> String {
        let event = self.runs.event;
        let method = match self.space.parameters.is_empty() {
            true => "by splitting on saved states (unbiased)",
            false => "by subset simulation over inputs (bias of the order of 1/particles)",
        };
        format!(
            "statistical, {method}, {} replications of {} particles, {} % interval from their spread",
            event.replications,
            event.particles,
            100.0 * level.level()
        )
    }

    /// A part of the work: as it was kept, or done now with its own seed.
    fn kept<T: serde::Serialize + for<'de> serde::Deserialize<'de>>(
        &self,
        kind: &str,
        number: u64,
        make: impl FnOnce(u64) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        let mut inputs = self.inputs.clone();
        inputs.add(kind, &number.to_le_bytes());
        let inputs = inputs.hash();
        let name = format!("{kind}-{}.json", &inputs[..24]);
        if let Some(kept) = self.store.fresh(&name, &inputs) {
            return Ok(kept);
        }
        self.store
            .keep(&name, &inputs, make(self.seeds.of(number))?)?;
        let again = || Problem::data_lost("cannot-write", format!("{name} cannot be read back"));
        self.store.fresh(&name, &inputs).ok_or_else(again)
    }

    fn descent(&self, seed: u64) -> Result<Descent, Problem> {
        let event = self.runs.event;
        if self.space.parameters.is_empty() {
            let options = SplittingOptions {
                particles: event.particles,
                killed: event.killed(),
                top: self.runs.top(),
                seed,
            };
            return split(&options, |jobs| self.runs.branches(jobs).map_err(Failure))
                .map_err(|failure| failure.0);
        }
        let options = SubsetOptions {
            particles: event.particles,
            chains: event.killed(),
            dimensions: self.space.dimensions(),
            limit: event.limit(),
            seed,
        };
        let score = |inputs| self.runs.scores(&self.space, inputs).map_err(Failure);
        let (descent, _) = subset(&options, score).map_err(|failure| failure.0)?;
        Ok(descent)
    }

    /// Counts plain episodes, whose seeds are none of the replications'.
    fn plain(
        &self,
        episodes: u64,
        estimate: &RareEstimate,
        level: Confidence,
        rows: &mut Rows,
    ) -> Result<PlainReport, Problem> {
        let chunks = episodes.div_ceil(CHUNK);
        let title = format!("{}: plain episodes", self.runs.event.name);
        let stage = self.runs.host.events.begin(&title, chunks);
        let (mut count, mut failed) = (0, Vec::new());
        for chunk in 0..chunks {
            let numbers = chunk * CHUNK..((chunk + 1) * CHUNK).min(episodes);
            let (low, high) = (numbers.start, numbers.end);
            let part = (low << 32) | high;
            let (hits, of_chunk): (u64, Vec<EpisodeOfInputs>) = self.kept("plain", part, |_| {
                let hit = |number: u64| self.is_hit(1_000_000 + number);
                let hits: Vec<(bool, EpisodeOfInputs)> = (low..high)
                    .into_par_iter()
                    .map(hit)
                    .collect::<Result<_, _>>()?;
                let count = hits.iter().filter(|(hit, _)| *hit).count() as u64;
                Ok((
                    count,
                    hits.into_iter().map(|(_, episode)| episode).collect(),
                ))
            })?;
            count += hits;
            for episode in &of_chunk {
                self.row(rows, "plain", episode);
            }
            let kinds = of_chunk.into_iter().map(|it| it.failed);
            failed.extend((low + 1..).zip(kinds));
            stage.advance();
        }
        let counted = Sample::new(count, episodes).map_err(problem)?;
        let interval = clopper_pearson(counted, level);
        Ok(PlainReport {
            count,
            episodes,
            low: interval.low,
            high: interval.high,
            p_value: difference_p_value(estimate, counted),
            failures: FailureCounts::of(failed).shares(level)?,
        })
    }

    /// A whole episode's row of the table.
    fn row(&self, rows: &mut Rows, part: &str, episode: &EpisodeOfInputs) {
        let event = self.runs.event;
        rows.begin();
        rows.plain("event", "its name", Value::Text(event.name.clone()));
        rows.plain(
            "part",
            "of which part of the estimate it is",
            Value::Text(part.into()),
        );
        rows.plain(
            "seed",
            "from which everything random is drawn",
            Value::U64(episode.seed),
        );
        let score = episode.score.unwrap_or(f64::NEG_INFINITY);
        rows.plain("score", "how near it came", Value::Double(score));
        let happened = self.runs.score.rung(score) >= self.runs.top();
        rows.plain(
            "happened",
            "whether the event happened",
            Value::Bool(happened),
        );
        if let Some(kind) = episode.failed {
            rows.plain(
                "failed",
                "what ended it by failing",
                Value::Text(kind.name().into()),
            );
        }
        for (parameter, value) in self
            .space
            .parameters
            .iter()
            .zip(&self.space.at(&episode.unit).0)
        {
            rows.parameter(parameter, *value);
        }
    }

    /// Whether the event happened, and the episode.
    fn is_hit(&self, number: u64) -> Result<(bool, EpisodeOfInputs), Problem> {
        let seed = self.seeds.of(number);
        let mut random = campaign::Random::new(seed, "inputs");
        let unit: Vec<f64> = (0..self.space.dimensions())
            .map(|_| random.open_unit())
            .collect();
        let (score, failed) = self.runs.episode(&self.space, &unit, seed)?;
        let episode = EpisodeOfInputs {
            seed,
            unit,
            score: Some(score).filter(|score| score.is_finite()),
            failed,
        };
        Ok((self.runs.score.rung(score) >= self.runs.top(), episode))
    }
}

/// An error of the campaign or of a run.
struct Failure(Problem);

impl From<campaign::CampaignError> for Failure {
    fn from(error: campaign::CampaignError) -> Self {
        Self(problem(error))
    }
}

fn problem(error: impl std::fmt::Display) -> Problem {
    Problem::new("bad-rare-event", error.to_string()).remedy("correct the event's numbers")
}

/// Two-sided, by the normal approximation of both errors; the count's is taken at the mean of
/// both rates, so that a count of 0 has one.
fn difference_p_value(estimate: &RareEstimate, counted: Sample) -> f64 {
    let rate = counted.rate().unwrap_or(0.0);
    let shared = f64::midpoint(rate, estimate.probability);
    let counting = shared * (1.0 - shared) / counted.trials as f64;
    let splitting = estimate.relative_error.unwrap_or(0.0) * estimate.probability;
    let deviation = (counting + splitting * splitting).sqrt();
    if deviation <= 0.0 {
        return 1.0;
    }
    2.0 * normal_sf((rate - estimate.probability).abs() / deviation)
}

#[cfg(test)]
mod tests {
    use super::super::report::CONTRADICTION;
    use super::*;

    #[test]
    fn a_count_far_from_the_estimate_contradicts_it() {
        let estimate = RareEstimate {
            probability: 0.01,
            interval: stats::Interval {
                low: 0.008,
                high: 0.012,
            },
            relative_error: Some(0.1),
            replications: vec![0.01; 10],
            episode_equivalents: 1000.0,
            plain_equivalent: None,
        };
        let p_value = |count| difference_p_value(&estimate, Sample::new(count, 2000).unwrap());
        assert!(p_value(20) > 0.9 && p_value(26) > 0.05);
        assert!(p_value(60) < 1e-4 && p_value(0) < CONTRADICTION);
    }
}
