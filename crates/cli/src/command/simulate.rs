//! `corroborate simulate`: episodes of a study's simulation, recorded, judged and counted.

use super::{Done, Host, json, use_threads};
use crate::args::{self, Format, Simulate};
use corroborate::simulate::{RecordingForm, SimulateReport, SimulateRequest};
use diagnostic::{Problem, counted};
use evidence::{Cost, Verdict};

/// Simulates and records.
pub fn simulate(arguments: &Simulate, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let found = corroborate::simulate::simulate(&request(arguments), setting)?;
    let output = match (arguments.format, &found.cost) {
        (Format::Json, _) => json(&found.report)?,
        (Format::Text, None) => next(arguments, &found.report),
        (Format::Text, Some(cost)) => {
            let next = match found.report.recordings.is_empty() {
                true => String::new(),
                false => next(arguments, &found.report),
            };
            text(&found.report, cost) + &next
        }
    };
    Ok(Done {
        output,
        outcome: found.outcome,
    })
}

fn request(arguments: &Simulate) -> SimulateRequest {
    SimulateRequest {
        episodes: arguments.episodes,
        until: arguments.until.clone(),
        keep: arguments.keep,
        on_failure: arguments.on_failure,
        first: arguments.first,
        seed: arguments.seed,
        engine: arguments.engine,
        form: match arguments.form {
            args::RecordingForm::Corroborate => RecordingForm::Signals,
            args::RecordingForm::Ros2 => RecordingForm::Ros2,
        },
        ..SimulateRequest::new(&arguments.study, &arguments.evidence, &arguments.out)
    }
}

fn next(arguments: &Simulate, report: &SimulateReport) -> String {
    let (study, out) = (arguments.study.display(), arguments.out.display());
    format!(
        "{} of {} in {out}\nNext: corroborate monitor {study} {out}\n",
        counted(report.episodes, "episode"),
        report.evidence
    )
}

/// For people.
fn text(report: &SimulateReport, cost: &Cost) -> String {
    let mut text = String::new();
    for estimate in &report.estimates {
        let share = 100.0 * estimate.count as f64 / estimate.trials as f64;
        let undecided = match estimate.undecided {
            0 => String::new(),
            many => format!("; {many} undecided, counted against and for"),
        };
        text.push_str(&format!(
            "{:<28} {:>6} of {:<6} {share:5.1} % ({:.1} to {:.1}){undecided}\n",
            estimate.subject.id(),
            estimate.count,
            estimate.trials,
            100.0 * estimate.low,
            100.0 * estimate.high
        ));
    }
    for judged in &report.verdicts {
        let verdict = match judged.verdict {
            Verdict::Satisfied => "satisfied",
            Verdict::Violated | Verdict::Conflicting => "VIOLATED",
            Verdict::Undecided => "undecided",
            Verdict::NotCovered => "not covered",
        };
        let (id, statement) = (&judged.requirement, &judged.statement);
        text.push_str(&format!("{id:<28} {verdict}: {statement}\n"));
    }
    for failure in &report.failures {
        let share = 100.0 * failure.count as f64 / failure.trials as f64;
        text.push_str(&format!(
                "{:<28} {:>6} of {:<6} {share:5.1} % ({:.1} to {:.1}): {}, first in episode {}; what it said: {}\n",
                failure.kind.name(),
                failure.count,
                failure.trials,
                100.0 * failure.low,
                100.0 * failure.high,
                failure.kind,
                failure.first_episode,
                failure.said
            ));
    }
    if !report.description_gaps.is_empty() {
        text.push_str("Not simulated as it is described:\n");
    }
    for gap in &report.description_gaps {
        text.push_str(&format!("  {gap}\n"));
    }
    if let Some(until) = &report.until {
        text.push_str(&format!("{until}\n"));
    }
    let speed = cost
        .real_time_factor
        .map(|factor| format!(", {factor:.0} times real time on a core"));
    text.push_str(&format!(
        "Table: {} ({:.1} s{})\n",
        report.table.as_deref().unwrap_or_default(),
        cost.wall_secs,
        speed.unwrap_or_default()
    ));
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(SimulateReport).into();
        crate::command::tests::assert_schema_is_committed("simulate.schema.json", &schema);
    }
}
