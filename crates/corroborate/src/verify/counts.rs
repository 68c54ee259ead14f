//! Whether the counts of evidence are those of its tables and journals, and its intervals those of
//! its counts.

use super::audit::Audit;
use super::{compare, sound};
use crate::technique::campaign::{Intervals, anytime, recount};
use crate::technique::experiment::Tables;
use crate::technique::{Produced, confidence, counts};
use diagnostic::Problem;
use evidence::Measure;
use std::path::Path;
use study::{Entry, Study, Work};

/// Holds an entry's findings against what they come from.
pub fn check(
    study: &Study,
    entry: &Entry,
    results: &Path,
    path: &Path,
    produced: &Produced,
    audit: &mut Audit,
) -> Result<(), Problem> {
    sound::check(study.about.confidence, path, produced, audit);
    match &entry.work {
        Work::Read {
            technique,
            cohort,
            requirements,
            failure_modes,
        } => {
            let tables = Tables::read(
                study,
                cohort.as_deref(),
                requirements.as_deref(),
                failure_modes.as_deref(),
            )?;
            let mut again = tables.produce(study, &entry.id, *technique)?;
            again.cost = produced.cost.clone();
            let values = compare::values_at(path, "/content", &again, produced, audit)?;
            audit.checked(values, "values of evidence follow from tables");
        }
        Work::Simulate { episodes, .. }
        | Work::SimulateScene { episodes, .. }
        | Work::Command { episodes, .. } => {
            episodes_again(study, entry, results, (path, produced, *episodes), audit)?;
        }
        Work::Judge { .. } => {
            intervals(study, path, produced, audit)?;
            audit.not_checked(&format!(
                "{}: recordings were not judged again (--deep does)",
                entry.id
            ));
        }
        Work::Check { .. } => {
            audit.not_checked(&format!(
                "{}: the model was not solved again (--deep does)",
                entry.id
            ));
        }
    }
    Ok(())
}

/// Counts the journal of a campaign again.
fn episodes_again(
    study: &Study,
    entry: &Entry,
    results: &Path,
    (path, produced, episodes): (&Path, &Produced, u64),
    audit: &mut Audit,
) -> Result<(), Problem> {
    intervals(study, path, produced, audit)?;
    let folder = results.join("episodes").join(&entry.id);
    let how = match entry.sampling.until {
        Some(_) => Intervals::Anytime,
        None => Intervals::Fixed,
    };
    let Some(again) = recount(study, &folder, episodes, how, &produced.findings)? else {
        audit.not_checked(&format!(
            "{}: there is no journal of its episodes, so its counts were not counted again",
            entry.id
        ));
        return Ok(());
    };
    let place = "/content/findings";
    let mut values = compare::values_at(path, place, &again.findings, &produced.findings, audit)?;
    let place = "/content/failures";
    values += compare::values_at(path, place, &again.failures, &produced.failures, audit)?;
    audit.checked(
        values,
        "values of evidence follow from journals of episodes",
    );
    audit.checked(
        again.recordings,
        "recordings have the hash of what was judged",
    );
    for (file, fault) in again.faults {
        audit.fault(Path::new(&file), "", fault);
    }
    audit.not_checked(&format!("{}: episodes were not simulated again", entry.id));
    Ok(())
}

/// Every interval is Wilson's or a confidence sequence's of its counts.
fn intervals(
    study: &Study,
    path: &Path,
    produced: &Produced,
    audit: &mut Audit,
) -> Result<(), Problem> {
    let level = confidence(study.about.confidence)?;
    let mut right = 0;
    for (place, finding) in produced.findings.iter().enumerate() {
        let Measure::Counts {
            count,
            trials,
            effective_trials,
            ..
        } = &finding.measure
        else {
            continue;
        };
        let fixed = counts(*count, *trials, *effective_trials, level);
        let sample = stats::Sample::new(*count, *trials);
        let follows = fixed.is_ok_and(|fixed| fixed == finding.measure)
            || sample.is_ok_and(|sample| anytime(sample, level) == finding.measure);
        if follows {
            right += 1;
        } else {
            let place = format!("/content/findings/{place}/measure/interval");
            audit.fault(path, &place, "it is not the interval of these counts");
        }
    }
    audit.checked(right, "intervals follow from their counts");
    Ok(())
}
