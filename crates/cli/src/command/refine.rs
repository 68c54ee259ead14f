//! `corroborate refine`: patches of the assets from what disagrees, and what
//! they change.

use super::{Done, Host, json, use_threads};
use crate::args::{Format, Refine};
use crate::shown_calibration::as_text;
use corroborate::RefineRequest;
use corroborate::refine::Accept;
use diagnostic::Problem;

/// Shows what is offered, and makes what is accepted.
pub fn refine(arguments: &Refine, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let request = RefineRequest {
        study: arguments.study.clone(),
        suspect: arguments.suspect,
        accept: match arguments.all {
            true => Accept::All,
            false => Accept::Numbers(arguments.accept.clone()),
        },
        rounds: usize::from(arguments.rounds),
        fit: arguments.fit,
        episodes: arguments.episodes,
        to: arguments.to.clone(),
        out: arguments.out.clone(),
    };
    let refined = corroborate::refine(&request, setting, &report::html)?;
    for calibration in &refined.calibrations {
        setting.events.say(as_text(calibration).trim_end());
    }
    Ok(Done {
        outcome: refined.outcome,
        output: match arguments.format {
            Format::Json => json(&refined.report)?,
            Format::Text => refined.report.text(),
        },
    })
}

#[cfg(test)]
mod tests {
    use corroborate::refine::report::RefineReport;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(RefineReport).into();
        crate::command::tests::assert_schema_is_committed("refine.schema.json", &schema);
    }
}
