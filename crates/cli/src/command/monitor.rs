//! `corroborate monitor`: a study's monitors, or a formula, over recordings
//! of any format.

mod text;

use super::{Done, Host, json};
use crate::args::{EndingChoice, Format, Monitor, TimeChoice};
use corroborate::Ended;
use diagnostic::Problem;
use judging::{MonitorRequest, Monitored};
use std::path::{Path, PathBuf};
use temporal::formula::{Ending, TimeModel};

/// Judges recordings.
pub fn monitor(arguments: &Monitor, setting: &Host) -> Result<Done, Problem> {
    let report = corroborate::monitor(&request(arguments)?, setting)?;
    let output = match arguments.format {
        Format::Json => json(&report)?,
        Format::Text => text::text(&report),
    };
    Ok(Done {
        output,
        outcome: report.outcome(),
    })
}

/// What the arguments ask.
fn request(arguments: &Monitor) -> Result<MonitorRequest, Problem> {
    let (monitored, recordings) = match arguments.formula.is_empty() {
        true => {
            let (folder, recordings) = study_first(&arguments.paths)?;
            let (folder, only) = (folder.to_owned(), arguments.only.clone());
            (Monitored::Study { folder, only }, recordings)
        }
        false => (formulas(arguments), &arguments.paths[..]),
    };
    Ok(MonitorRequest {
        recordings: recordings.to_vec(),
        map: arguments.map.clone(),
        time: arguments.time.map(TimeChoice::source),
        opening: arguments.opening.options(),
        partial: arguments.partial,
        verdicts: arguments.verdicts.clone(),
        ..MonitorRequest::new(monitored)
    })
}

/// The study that is named first, and the recordings.
fn study_first(paths: &[PathBuf]) -> Result<(&Path, &[PathBuf]), Problem> {
    let remedy = "name a study's folder first, or give a formula: \
                  --formula 'always (/robot.speed < 250 mm/s)'";
    match paths {
        [study, ..] if study.is_file() => {
            let message = format!("{} is a file, not a study's folder", study.display());
            Err(Problem::new("no-study", message).remedy(remedy))
        }
        [study, rest @ ..] if !rest.is_empty() => Ok((study, rest)),
        _ => Err(
            Problem::new("no-recordings", "no recording is named behind the study")
                .remedy("name recordings, or folders of them, behind the study"),
        ),
    }
}

fn formulas(arguments: &Monitor) -> Monitored {
    Monitored::Formulas {
        texts: arguments.formula.clone(),
        ending: match arguments.ending {
            EndingChoice::LongEnough => Ending::LongEnough,
            EndingChoice::Finite => Ending::Finite,
            EndingChoice::Weak => Ending::Weak,
            EndingChoice::Strong => Ending::Strong,
            EndingChoice::Inconclusive => Ending::Inconclusive,
        },
        time: match arguments.dense {
            true => TimeModel::Dense,
            false => TimeModel::Discrete,
        },
        start_within_secs: arguments.start_within,
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(judging::MonitorReport).into();
        crate::command::tests::assert_schema_is_committed("monitor.schema.json", &schema);
    }
}
