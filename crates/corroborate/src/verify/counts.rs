//! Whether the intervals of evidence are those of its counts.

use super::audit::Audit;
use crate::technique::campaign::anytime;
use crate::technique::{Produced, confidence, counts};
use diagnostic::Problem;
use evidence::Measure;
use std::path::Path;
use study::Study;

/// Every interval is Wilson's or a confidence sequence's of its counts.
pub fn check_intervals(
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
