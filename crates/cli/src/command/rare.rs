//! `corroborate rare`: how rare an event is, by splitting.

use super::{Done, Host, json, use_threads};
use crate::args::{Format, Rare};
use corroborate::Ended;
use corroborate::rare::{EventReport, RareReport, RareRequest};
use corroborate::technique::campaign::failures_in_words;
use diagnostic::Problem;
use std::fmt::Write;

/// Estimates all events of the file.
pub fn rare(arguments: &Rare, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let request = RareRequest {
        study: arguments.study.clone(),
        file: arguments.file.clone(),
        only: arguments.only.clone(),
        out: arguments.out.clone(),
    };
    let report = corroborate::rare(&request, setting)?;
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => text_of(&report),
        },
    })
}

/// For people.
fn text_of(report: &RareReport) -> String {
    let mut text = String::new();
    for event in &report.events {
        // Writing to a string cannot fail.
        let _ = write_event(&mut text, event);
    }
    text
}

fn write_event(text: &mut String, event: &EventReport) -> std::fmt::Result {
    writeln!(text, "{}\n  {}", event.name, event.meaning)?;
    writeln!(
        text,
        "  probability  {:.3e}  [{:.3e}, {:.3e}]",
        event.probability, event.low, event.high
    )?;
    writeln!(text, "  guarantee    {}", event.guarantee)?;
    write!(
        text,
        "  cost         {:.0} episodes",
        event.episode_equivalents
    )?;
    match event.plain_episodes_for_the_same_error {
        Some(plain) => writeln!(text, "; as exact a count would take {plain:.2e}")?,
        None if event.probability <= 0.0 => writeln!(text, "; the event was never reached")?,
        None => writeln!(text)?,
    }
    for failures in &event.failures {
        let (kind, count, runs) = (failures.kind, failures.count, failures.runs);
        writeln!(
            text,
            "  failures     {kind} in {count} of {runs} runs, which count up to there"
        )?;
    }
    if let Some(plain) = &event.plain {
        writeln!(
            text,
            "  counted      {} of {} plain episodes  [{:.3e}, {:.3e}], {} (p = {:.3})",
            plain.count,
            plain.episodes,
            plain.low,
            plain.high,
            match plain.contradicts() {
                true => "which contradicts it",
                false => "which agrees",
            },
            plain.p_value
        )?;
        for failures in &plain.failures {
            writeln!(text, "               {}", failures_in_words(failures))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(RareReport).into();
        crate::command::tests::assert_schema_is_committed("rare.schema.json", &schema);
    }
}
