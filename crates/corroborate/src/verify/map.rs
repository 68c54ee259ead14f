//! The map of disagreement: that it is of these assets, and that the same search gives it again, from the
//! journal of its episodes or, with `--deep`, by running them.

use super::audit::Audit;
use super::compare;
use crate::kept;
use crate::results::RESULT;
use crate::technique::exploration::map_again;
use diagnostic::Problem;
use evidence::{DisagreementMap, StudyResult};
use host::Host;
use std::path::Path;
use study::Study;

/// The map that the result has to have.
pub fn again(
    study: &Study,
    claimed: &StudyResult,
    results: &Path,
    (host, is_deep): (&Host, bool),
    audit: &mut Audit,
) -> Result<Option<DisagreementMap>, Problem> {
    if claimed.disagreement.is_none() {
        return Ok(None);
    }
    let kept = match kept::map(study, results) {
        Ok(Some(kept)) => kept,
        Ok(None) => return Ok(None),
        Err(problem) => {
            let file = results.join(RESULT);
            audit.fault(&file, "/disagreement", problem.to_string());
            return Ok(None);
        }
    };
    let what = match is_deep {
        true => "values of the map of disagreement follow from running its episodes again",
        false => "values of the map of disagreement follow from the journal of its episodes",
    };
    match map_again(study, &kept, results, is_deep, host) {
        Ok(Some(again)) => {
            let values = compare::values(&kept::map_file(results), &again, &kept, audit)?;
            audit.checked(values, what);
        }
        Ok(None) => audit.not_checked(
            "the map of disagreement: there is no journal of its episodes by this program (`--deep` runs them)",
        ),
        Err(problem) if host.cancel.is_cancelled() => return Err(problem),
        Err(problem) => {
            audit.not_checked(&format!(
                "the map of disagreement cannot be made again here: {problem}"
            ));
        }
    }
    Ok(Some(kept))
}
