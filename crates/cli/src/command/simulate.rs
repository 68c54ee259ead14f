//! `corroborate simulate`: episodes of a study's simulation, recorded.

use super::{Done, Setting, json, use_threads};
use crate::args::{Format, Simulate};
use crate::outcome::Outcome;
use crate::problem::Problem;
use crate::study::{Study, Work};
use crate::technique::simulation::{Campaign, Seeds, record};
use schemars::JsonSchema;
use serde::Serialize;

/// What `simulate --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SimulateReport {
    /// Version of this form.
    pub format: String,
    /// The ledger's entry that was simulated.
    pub evidence: String,
    /// The physics engine with its version.
    pub engine: String,
    /// The recordings with the seed of each.
    pub recordings: Vec<RecordingReport>,
}

/// One recorded episode.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RecordingReport {
    /// The file.
    pub file: String,
    /// The episode's seed.
    pub seed: u64,
}

/// Simulates and records.
pub fn simulate(arguments: &Simulate, setting: &Setting) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let study = Study::load(&arguments.study)?;
    let entry = study.entry(&arguments.evidence)?;
    let Work::Simulate {
        scenario,
        parameters,
        episodes,
    } = &entry.work
    else {
        return Err(Problem::new(
            "not-a-simulation",
            format!("`{}` is no simulation of this study", entry.id),
        )
        .remedy("name an entry of the ledger with a scenario"));
    };
    let library = setting.physics_library.as_deref();
    let campaign = Campaign::new(&study, scenario, parameters, library)?;
    let seeds = Seeds::new(arguments.seed.unwrap_or(study.about.seed), &entry.id);
    let count = arguments.episodes.unwrap_or(*episodes);
    let numbers = arguments.first..arguments.first.saturating_add(count);
    std::fs::create_dir_all(&arguments.out)
        .map_err(|error| Problem::cannot_write(&arguments.out, &error))?;
    refuse_other_recordings(arguments)?;
    let stage = setting.talk.begin(&format!("{}: episodes", entry.id), count);
    let files = record(
        &campaign,
        &seeds,
        numbers.clone(),
        &arguments.out,
        &setting.interrupt,
        &stage,
    )?;
    drop(stage);
    let tool = campaign.tool();
    let report = SimulateReport {
        format: "1.0".into(),
        evidence: entry.id.clone(),
        engine: format!("{} {}", tool.name, tool.version),
        recordings: files
            .iter()
            .zip(numbers)
            .map(|(file, number)| RecordingReport {
                file: file.display().to_string(),
                seed: seeds.of(number),
            })
            .collect(),
    };
    let output = match arguments.format {
        Format::Json => json(&report)?,
        Format::Text => format!(
            "{count} episodes of {} in {}\nNext: corroborate monitor {} {}\n",
            entry.id,
            arguments.out.display(),
            arguments.study.display(),
            arguments.out.display()
        ),
    };
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}

/// Recordings that are already there may be of another seed or study: they
/// are neither taken for ours nor overwritten.
fn refuse_other_recordings(arguments: &Simulate) -> Result<(), Problem> {
    let entries = std::fs::read_dir(&arguments.out)
        .map_err(|error| Problem::cannot_read(&arguments.out, &error))?;
    let occupied = entries
        .flatten()
        .any(|e| e.path().extension().is_some_and(|x| x == "mcap"));
    if occupied {
        return Err(Problem::new(
            "folder-not-empty",
            format!("{} already holds recordings", arguments.out.display()),
        )
        .remedy("name a new folder with --out"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(SimulateReport).into();
        crate::command::tests::assert_schema_is_committed("simulate.schema.json", &schema);
    }
}
