//! `corroborate diagnose`: which asset is to blame for what disagrees.

use super::run::{terminal_width, use_colour};
use super::{Done, Host, json, use_threads};
use crate::args::{Diagnose, Format};
use corroborate::kept::DIAGNOSIS;
use corroborate::outcome::Outcome;
use corroborate::results::{REPORT, RESULT, read_current_result, results_folder};
use corroborate::technique::matrix::{ModelPaths, as_text, diagnose as diagnosed, path_seeds};
use corroborate::technique::model_checking::worst_cases_in_lines;
use diagnostic::Problem;
use evidence::{Diagnosis, Effort};
use host::store::Store;
use std::fmt::Write as _;
use study::Study;

/// Runs the command.
pub fn diagnose(arguments: &Diagnose, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let study = Study::load(&arguments.study)?;
    if let Some(path) = &arguments.show {
        return show(&study, path, setting);
    }
    let folder = results_folder(&arguments.study, arguments.out.as_deref());
    let mut result = read_current_result(&arguments.study, &folder)?;
    let effort = Effort {
        paths: arguments.paths,
        half_step: arguments.half_step,
        engines: arguments.engines,
        runs: Some(arguments.runs),
    };
    for piece in &result.evidence {
        for line in worst_cases_in_lines(&piece.id, &piece.findings) {
            setting.events.say(&line);
        }
    }
    let store = Store::open(&folder)?;
    let diagnosis = diagnosed(&study, &result, &folder, &effort, setting)?;
    let output = match arguments.format {
        Format::Json => json(&diagnosis)?,
        Format::Text => as_text(&diagnosis, &arguments.study.display().to_string()),
    };
    let outcome = outcome(&diagnosis);
    store.keep(DIAGNOSIS, &diagnosis.inputs, &diagnosis)?;
    result.diagnosis = Some(diagnosis);
    store.write(RESULT, json(&result)?.as_bytes())?;
    store.write(REPORT, report::html(&result).as_bytes())?;
    // Formed so that what cannot be written as text is found here, not when it is read.
    let _ = report::text(&result, terminal_width(), use_colour());
    Ok(Done { output, outcome })
}

fn outcome(diagnosis: &Diagnosis) -> Outcome {
    let mut suspects = diagnosis.suspects.iter();
    match suspects.any(|suspect| suspect.score >= 1.0 && suspect.resolved_by.is_none()) {
        true => Outcome::Violated,
        false => Outcome::Holds,
    }
}

/// One sampled path, step by step.
fn show(study: &Study, named: &str, setting: &Host) -> Result<Done, Problem> {
    let wrong = || {
        Problem::new(
            "bad-path",
            format!("`{named}` names no path of a formal model"),
        )
        .remedy("name the evidence and the path's number, from 1: E1:17")
    };
    let (id, number) = named.rsplit_once(':').ok_or_else(wrong)?;
    let number: u64 = number.parse().ok().filter(|n| *n > 0).ok_or_else(wrong)?;
    if study.entry(id)?.work.model().is_none() {
        return Err(wrong());
    }
    let paths = ModelPaths::of_entry(study, id, &setting.cancel)?;
    let mut output = format!("Path {number} of {id}: the steps that change what holds\n");
    for step in paths.shown(path_seeds(study.about.seed, id).of(number)) {
        let _ = writeln!(output, "{:>7}  {}", step.step, step.holds.join(" "));
        let _ = writeln!(output, "         {}", step.state);
    }
    Ok(Done {
        output,
        outcome: Outcome::Holds,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(Diagnosis).into();
        crate::command::tests::assert_schema_is_committed("diagnose.schema.json", &schema);
    }
}
