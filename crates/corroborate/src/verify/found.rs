//! What was explored and fitted: that it is what was kept, of these very files; with `--deep`, that each scenario of a
//! finding shows it again.

use super::audit::Audit;
use crate::kept;
use crate::results::RESULT;
use crate::technique::exploration::findings_again;
use diagnostic::Problem;
use evidence::{CalibrationReport, Exploration, StudyResult};
use host::Host;
use std::path::Path;
use study::Study;

/// The exploration that the result has to have.
pub fn again(
    study: &Study,
    claimed: &StudyResult,
    results: &Path,
    deep: Option<&Host>,
    audit: &mut Audit,
) -> Result<Option<Exploration>, Problem> {
    if claimed.exploration.is_none() {
        return Ok(None);
    }
    let kept = kept::exploration(study, results);
    let Some(kept) = of_these_files(kept, "/exploration", results, audit) else {
        return Ok(None);
    };
    let Some(host) = deep else {
        audit.not_checked("findings of the exploration (`--deep` runs their scenarios again)");
        return Ok(Some(kept));
    };
    match findings_again(study, &kept, results, host) {
        Ok((run, lost)) => {
            let file = results.join(RESULT);
            for lost in &lost {
                let fault = format!("{lost} does not show again what was found");
                audit.fault(&file, "/exploration/findings", fault);
            }
            let shown = run - lost.len() as u64;
            audit.checked(shown, "scenarios of findings show again what was found");
        }
        Err(problem) if host.cancel.is_cancelled() => return Err(problem),
        Err(problem) => audit.not_checked(&format!(
            "the exploration's scenarios cannot be run again here: {problem}"
        )),
    }
    Ok(Some(kept))
}

/// The calibration that the result has to have.
pub fn calibration(
    study: &Study,
    claimed: &StudyResult,
    results: &Path,
    audit: &mut Audit,
) -> Option<CalibrationReport> {
    claimed.calibration.as_ref()?;
    let kept = kept::calibration(study, results);
    let kept = of_these_files(kept, "/calibration", results, audit)?;
    audit.not_checked("the posterior of the calibration (`calibrate` fits it again from the episodes that it kept)");
    Some(kept)
}

fn of_these_files<T>(
    kept: Result<Option<T>, Problem>,
    place: &str,
    results: &Path,
    audit: &mut Audit,
) -> Option<T> {
    kept.unwrap_or_else(|problem| {
        audit.fault(&results.join(RESULT), place, problem.to_string());
        None
    })
}
