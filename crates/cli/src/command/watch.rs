//! `corroborate watch`: a study's monitors on a running system.

mod teller;

use super::{Done, Host};
use crate::args::{Format, TimeChoice, Watch};
use corroborate::watch::{LiveSystem, SimulatedRest, WatchReport, WatchRequest};
use diagnostic::{Problem, counted};
use teller::Teller;

/// Judges a running system until it is told to end.
pub fn watch(arguments: &Watch, setting: &Host) -> Result<Done, Problem> {
    let audience = Box::new(Teller::new(arguments.format));
    let report = corroborate::watch::watch(&request(arguments), setting, audience)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => String::new(),
            Format::Text => summary(&report),
        },
        outcome: report.outcome,
    })
}

fn request(arguments: &Watch) -> WatchRequest {
    let from = match &arguments.foxglove {
        Some(url) => LiveSystem::Foxglove { url: url.clone() },
        None => LiveSystem::Dds {
            domain: arguments.dds.unwrap_or(0),
            networks: arguments.network.clone(),
        },
    };
    let rest = arguments.simulate.as_ref().map(|entry| SimulatedRest {
        entry: entry.clone(),
        outside: arguments.outside.clone(),
        episode: arguments.episode,
        seed: arguments.seed,
    });
    WatchRequest {
        only: arguments.only.clone(),
        topics: arguments.topics.clone(),
        map: arguments.map.clone(),
        time: arguments.time.map(TimeChoice::source),
        message_path: arguments.message_path.clone(),
        wait: arguments.wait,
        limit: arguments.limit,
        out: arguments.out.clone(),
        rest,
        ..WatchRequest::new(&arguments.study, from)
    }
}

fn summary(report: &WatchReport) -> String {
    let mut text = format!(
        "\n{:<34} {:<12} {:>8} {:>8} {:>8} {:>22}\n",
        "requirement or failure mode", "verdict", "covered", "passed", "failed", "robustness"
    );
    for verdict in &report.verdicts {
        text.push_str(&teller::row(verdict));
    }
    for verdict in report.verdicts.iter().filter(|v| v.violation.is_some()) {
        text.push_str(&format!("{}: {}\n", verdict.label(), verdict.why()));
    }
    let (received, lost, instants) = (report.received, report.lost, report.instants);
    text.push_str(&format!(
        "{}, {lost} known to be lost, {} judged\n",
        counted(received, "message"),
        counted(instants, "instant")
    ));
    for what in &report.missing {
        text.push_str(&format!("missing: {what}\n"));
    }
    if let Some(path) = &report.recording {
        text.push_str(&format!("recorded in {}\n", path.display()));
    }
    text
}

#[cfg(test)]
mod tests {
    use corroborate::watch::WatchLine;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(WatchLine).into();
        crate::command::tests::assert_schema_is_committed("watch.schema.json", &schema);
    }
}
