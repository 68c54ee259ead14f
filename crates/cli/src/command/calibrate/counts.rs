//! What was counted in reality, and what episodes show of it.

use super::file::CalibrationText;
use crate::command::Setting;
use crate::command::rare::bench::{TestBench, simulation_problem};
use crate::problem::Problem;
use crate::study::{Study, Work};
use crate::technique::experiment::Tables;
use crate::technique::judging::Judges;
use campaign::calibration::Observed;
use evidence::{Measure, Subject};
use stimulus::Stimulus;
use temporal::monitor::Verdict;
use testbench::{Bench, Unwatched};

/// The counts of the evidence, of requirements as violations.
pub fn observed(study: &Study, text: &CalibrationText) -> Result<Vec<Observed>, Problem> {
    let entry = study.entry(&text.evidence)?;
    let Work::Read {
        technique,
        cohort,
        requirements,
        failure_modes,
    } = &entry.work
    else {
        let message = format!("`{}` has no tables of counts", entry.id);
        return Err(Problem::new("bad-calibration-file", message)
            .remedy("name an entry of the ledger whose counts are read from tables"));
    };
    let tables = Tables::read(
        study,
        cohort.as_deref(),
        requirements.as_deref(),
        failure_modes.as_deref(),
    )?;
    let produced = tables.produce(study, &entry.id, *technique)?;
    let ids = text.fit.iter().map(|id| (id, false));
    let ids = ids.chain(text.hold_out.iter().map(|id| (id, true)));
    ids.map(|(id, held_out)| {
        let finding = produced.findings.iter().find(|f| f.subject.id() == id);
        let unusable = |reason: &str, remedy: &str| {
            let message = format!("`{id}` {reason}");
            Problem::new("bad-calibration-file", message).remedy(remedy)
        };
        let Some(finding) = finding else {
            let reason = "is no requirement and no failure mode of this study";
            return Err(unusable(reason, "correct `fit` or `hold_out`"));
        };
        let Measure::Counts { count, trials, .. } = finding.measure else {
            let reason = format!("was not counted by {}", entry.id);
            return Err(unusable(&reason, "leave it out of `fit` and `hold_out`"));
        };
        Ok(Observed {
            mode: id.clone(),
            occurrences: match finding.subject {
                Subject::Requirement(_) => trials - count,
                Subject::FailureMode(_) => count,
            },
            opportunities: trials,
            held_out,
        })
    })
    .collect()
}

/// Runs one episode and says of each subject: violated or occurred (`true`),
/// not (`false`), or no opportunity.
pub fn episode(
    bench: &TestBench,
    judges: &Judges<'_>,
    subjects: &[Observed],
    stimulus: &Stimulus,
    seed: u64,
    setting: &Setting,
) -> Result<Vec<Option<bool>>, Problem> {
    setting.go_on()?;
    let cancel = setting.interrupt.cancel();
    let recorded = bench
        .bench
        .run(stimulus, seed, &mut Unwatched, cancel)
        .map_err(|error| simulation_problem(error, seed))?;
    let judgements = judges.judge(&recorded.trace)?;
    let of = |observed: &Observed| {
        let judgement = judgements
            .iter()
            .find(|j| j.subject.id() == observed.mode && j.reading.is_none());
        match judgement?.findings.verdict {
            Verdict::Violated => Some(true),
            Verdict::Satisfied => Some(false),
            Verdict::NotCovered | Verdict::Inconclusive => None,
        }
    };
    Ok(subjects.iter().map(of).collect())
}
