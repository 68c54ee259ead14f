//! `corroborate calibrate`: simulator parameters from an evidence's counts.

use super::{Done, Host, json, use_threads};
use crate::args::{Calibrate, Format};
use crate::shown_calibration::as_text;
use corroborate::{CalibrateRequest, Ended};
use diagnostic::Problem;
use host::files::write_whole;

/// Fits, checks, and writes the fitted set.
pub fn calibrate(arguments: &Calibrate, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let request = CalibrateRequest {
        study: arguments.study.clone(),
        file: arguments.file.clone(),
        out: arguments.out.clone(),
    };
    let report = corroborate::calibrate(&request, setting)?;
    if let Some(path) = &arguments.to {
        write_whole(path, report.parameter_set.as_bytes())?;
    }
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => as_text(&report),
        },
    })
}

#[cfg(test)]
mod tests {
    use evidence::CalibrationReport;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(CalibrationReport).into();
        crate::command::tests::assert_schema_is_committed("calibrate.schema.json", &schema);
    }
}
