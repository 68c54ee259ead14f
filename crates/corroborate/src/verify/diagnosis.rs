//! The diagnosis: that it is of this evidence, that it is as it was kept, and, with `--deep`, that it comes out again.

use super::audit::Audit;
use super::{compare, kept};
use crate::kept::DIAGNOSIS;
use crate::technique::confidence;
use crate::technique::matrix::{diagnose, inputs_of};
use diagnostic::Problem;
use evidence::{Diagnosis, Interval, StudyResult};
use host::Host;
use host::store::Stored;
use std::path::Path;
use study::Study;

/// The diagnosis that the result has to have.
pub fn again(
    (study, expected): (&Study, &StudyResult),
    claimed: &StudyResult,
    results: &Path,
    deep: Option<&Host>,
    audit: &mut Audit,
) -> Result<Option<Diagnosis>, Problem> {
    if claimed.diagnosis.is_none() {
        return Ok(None);
    }
    let path = results.join(DIAGNOSIS);
    let Some(kept) = kept::read::<Stored<Diagnosis>>(&path, audit) else {
        return Ok(None);
    };
    if !kept.is_as_kept() {
        audit.fault(&path, "/digest", "the hash of the content does not hold");
    }
    if kept.inputs != inputs_of(claimed) {
        audit.fault(&path, "/inputs", "it is a diagnosis of other evidence");
    }
    intervals(study, &path, &kept.content, audit)?;
    let Some(host) = deep else {
        audit.not_checked("the diagnosis: nothing was sampled or judged again (`--deep` does)");
        return Ok(Some(kept.content));
    };
    let effort = kept.content.effort.clone();
    match diagnose(study, expected, results, &effort, host) {
        Ok(again) => {
            let values = compare::values_at(&path, "/content", &again, &kept.content, audit)?;
            audit.checked(
                values,
                "values of the diagnosis follow from making it again",
            );
            Ok(Some(again))
        }
        Err(problem) if host.cancel.is_cancelled() => Err(problem),
        Err(problem) => {
            let why = format!("the diagnosis cannot be made again here: {problem}");
            audit.not_checked(&why);
            Ok(Some(kept.content))
        }
    }
}

/// The intervals of the matrix are those of its counts.
fn intervals(
    study: &Study,
    path: &Path,
    diagnosis: &Diagnosis,
    audit: &mut Audit,
) -> Result<(), Problem> {
    let level = confidence(study.about.confidence)?;
    let mut right = 0;
    for (place, cell) in diagnosis.cells.iter().enumerate() {
        let sample = stats::Sample::new(cell.count, cell.trials).ok();
        let sample = sample.filter(|sample| sample.trials > 0);
        let follows = sample.map(|sample| {
            let wilson = stats::wilson(sample, level);
            Interval {
                low: wilson.low,
                high: wilson.high,
            }
        });
        if follows == cell.interval {
            right += 1;
        } else {
            let place = format!("/content/cells/{place}/interval");
            audit.fault(path, &place, "it is not the interval of these counts");
        }
    }
    audit.checked(
        right,
        "cells of the diagnosis have the interval of their counts",
    );
    Ok(())
}
