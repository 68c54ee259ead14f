//! `corroborate diagnose`: which asset is to blame for what disagrees.

use super::{Done, Host, json, use_threads};
use crate::args::{Diagnose, Format};
use corroborate::diagnose::{SampledPath, diagnose_with_page, in_words, sampled_path};
use corroborate::{DiagnoseRequest, Ended, Outcome};
use diagnostic::Problem;
use evidence::Effort;
use std::fmt::Write as _;

/// Runs the command.
pub fn diagnose(arguments: &Diagnose, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    if let Some(name) = &arguments.show {
        let path = sampled_path(&arguments.study, name, setting)?;
        return Ok(Done {
            output: match arguments.format {
                Format::Json => json(&path)?,
                Format::Text => path_text(&path),
            },
            outcome: Outcome::Holds,
        });
    }
    let request = DiagnoseRequest {
        study: arguments.study.clone(),
        out: arguments.out.clone(),
        effort: Effort {
            paths: arguments.paths,
            half_step: arguments.half_step,
            engines: arguments.engines,
            runs: Some(arguments.runs),
        },
    };
    let diagnosis = diagnose_with_page(&request, setting, &report::html)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&diagnosis)?,
            Format::Text => in_words(&diagnosis, &arguments.study),
        },
        outcome: diagnosis.outcome(),
    })
}

/// One sampled path, step by step.
fn path_text(path: &SampledPath) -> String {
    let (number, id) = (path.number, &path.evidence);
    let mut output = format!("Path {number} of {id}: the steps that change what holds\n");
    for step in &path.steps {
        // Writing to a String cannot fail.
        let _ = writeln!(output, "{:>7}  {}", step.step, step.holds.join(" "));
        let _ = writeln!(output, "         {}", step.state);
    }
    output
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(evidence::Diagnosis).into();
        crate::command::tests::assert_schema_is_committed("diagnose.schema.json", &schema);
        let schema: serde_json::Value =
            schemars::schema_for!(corroborate::diagnose::SampledPath).into();
        crate::command::tests::assert_schema_is_committed("sampled-path.schema.json", &schema);
    }
}
