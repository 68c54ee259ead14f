//! `corroborate simulate`: episodes of a study's simulation, recorded.

pub mod ros2_table;

use super::{Done, Setting, json, use_threads};
use crate::args::{Format, RecordingForm, Simulate};
use crate::outcome::Outcome;
use crate::problem::{Problem, write_whole};
use crate::store::{Inputs, program_hash};
use crate::study::{Study, Work};
use crate::technique::simulation::{Campaign, Seeds, record, record_with};
use ros2_table::Ros2Table;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};

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
    let library = setting.physics_library.as_deref();
    let (campaign, scenario, episodes) = match &entry.work {
        Work::Simulate {
            scenario,
            parameters,
            episodes,
        } => {
            let campaign = Campaign::new(&study, scenario, parameters, library)?;
            (campaign, scenario, episodes)
        }
        Work::SimulateScene {
            scene,
            test,
            episodes,
        } => {
            let campaign = Campaign::of_scene(&study, scene, test.as_deref(), library)?;
            (campaign, scene, episodes)
        }
        _ => {
            return Err(Problem::new(
                "not-a-simulation",
                format!("`{}` is no simulation of this study", entry.id),
            )
            .remedy("name an entry of the ledger with a scenario or a scene"));
        }
    };
    campaign.gaps().iter().for_each(|gap| setting.talk.say(gap));
    let seeds = Seeds::new(arguments.seed.unwrap_or(study.about.seed), &entry.id);
    let count = arguments.episodes.unwrap_or(*episodes);
    let numbers = arguments.first..arguments.first + count;
    let ros2 = match arguments.form {
        RecordingForm::Corroborate => None,
        RecordingForm::Ros2 => Some(Ros2Table::beside(&study.folder.join(scenario))?),
    };
    let mut inputs = Inputs::default();
    campaign.inputs(&mut inputs);
    if let Some(table) = &ros2 {
        inputs.add("ros2", table.text.as_bytes());
    }
    inputs
        .add("program", program_hash()?.as_bytes())
        .add_json("seed", &seeds.of(0));
    claim(&arguments.out, &inputs.hash())?;
    let files = record_all(
        &campaign,
        &seeds,
        numbers.clone(),
        arguments,
        ros2.as_ref(),
        setting,
    )?;
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

/// Records the episodes in the form that is wanted.
fn record_all(
    campaign: &Campaign,
    seeds: &Seeds,
    numbers: std::ops::Range<u64>,
    arguments: &Simulate,
    ros2: Option<&Ros2Table>,
    setting: &Setting,
) -> Result<Vec<PathBuf>, Problem> {
    let title = format!("{}: episodes", arguments.evidence);
    let stage = setting.talk.begin(&title, numbers.end - numbers.start);
    let (folder, interrupt) = (&arguments.out, &setting.interrupt);
    let Some(table) = ros2 else {
        return record(campaign, seeds, numbers, folder, interrupt, &stage);
    };
    let written = record_with(
        campaign,
        seeds,
        numbers,
        folder,
        interrupt,
        &stage,
        |trace, path| table.write(trace, path),
    )?;
    drop(stage);
    let left_out: u64 = written.iter().map(|(_, left_out)| left_out).sum();
    if left_out > 0 {
        setting.talk.say(&format!(
            "{left_out} messages are not written: a truth value, a name or a whole number is missing there"
        ));
    }
    Ok(written.into_iter().map(|(path, _)| path).collect())
}

/// The file that says which campaign a folder's recordings are of.
const MARK: &str = "campaign";

/// Recordings that are already there are gone on with if they are of the same
/// campaign; others are neither taken for ours nor overwritten.
fn claim(folder: &Path, campaign: &str) -> Result<(), Problem> {
    std::fs::create_dir_all(folder).map_err(|error| Problem::cannot_write(folder, &error))?;
    let mark = folder.join(MARK);
    let entries =
        std::fs::read_dir(folder).map_err(|error| Problem::cannot_read(folder, &error))?;
    let occupied = entries
        .flatten()
        .any(|e| e.path().extension().is_some_and(|x| x == "mcap"));
    let same = std::fs::read_to_string(&mark).is_ok_and(|text| text.trim() == campaign);
    if occupied && !same {
        return Err(Problem::new(
            "folder-not-empty",
            format!(
                "{} already holds recordings of something else",
                folder.display()
            ),
        )
        .remedy("name a new folder with --out"));
    }
    write_whole(&mark, format!("{campaign}\n").as_bytes())
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
