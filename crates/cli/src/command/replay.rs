//! `corroborate replay`: one episode run again, bit for bit, as recording,
//! verdicts and a 3D page; or all regressions, as tests.

mod junit;
mod regressions;

use super::{Done, Host, json, use_threads};
use crate::args::{Format, Replay};
use corroborate::Ended;
use corroborate::replay::{ReplayReport, ReplayRequest, replay_with_page};
use diagnostic::Problem;
use evidence::RunVerdict;

/// Replays.
pub fn replay(arguments: &Replay, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    if arguments.check {
        return regressions::check(arguments, setting);
    }
    let report = replay_with_page(&request(arguments)?, setting, &report::replay::html)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => as_text(&report),
        },
        outcome: report.outcome(),
    })
}

/// What the arguments ask.
fn request(arguments: &Replay) -> Result<ReplayRequest, Problem> {
    let [episode] = arguments.what.as_slice() else {
        return Err(
            Problem::new("one-at-a-time", "one episode is replayed at a time")
                .remedy("name one, or run all regressions with --check"),
        );
    };
    Ok(ReplayRequest {
        study: arguments.study.clone(),
        episode: episode.clone(),
        only: arguments.only.clone(),
        out: arguments.out.clone(),
    })
}

fn as_text(report: &ReplayReport) -> String {
    let mut text = format!("{}, seed {}\n", report.episode, report.seed);
    if let (Some(shows), Some(shown)) = (&report.shows, report.shown) {
        let again = if shown {
            "shown again"
        } else {
            "NOT SHOWN AGAIN"
        };
        text.push_str(&format!("{again}: {shows}\n"));
    }
    text.push_str(match report.same_bytes {
        Some(true) => "the recording is the same, bit for bit\n",
        Some(false) => "THE RECORDING IS NOT THE SAME as before\n",
        None => "no earlier recording is known to compare with\n",
    });
    if let Some(kind) = report.failed {
        text.push_str(&format!("ended by: {kind}\n"));
        for line in report.said.iter().flat_map(|said| said.lines()) {
            text.push_str(&format!("    {line}\n"));
        }
    }
    verdicts(report, &mut text);
    for file in &report.files {
        text.push_str(&format!("{file}\n"));
    }
    text
}

fn verdicts(report: &ReplayReport, text: &mut String) {
    let covered = report
        .verdicts
        .iter()
        .filter(|it| it.verdict != RunVerdict::NotCovered);
    for verdict in covered {
        text.push_str(&format!("{:<28} {}\n", verdict.subject, verdict.verdict));
        if verdict.verdict == RunVerdict::Violated {
            for reason in &verdict.reasons {
                text.push_str(&format!("    {reason}\n"));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(ReplayReport).into();
        crate::command::tests::assert_schema_is_committed("replay.schema.json", &schema);
    }
}
