//! `corroborate merge`: a study's episodes from several machines, taken over.

use super::{Done, Host, json};
use crate::args::{Format, Merge};
use corroborate::shard::MergedCampaign;
use corroborate::{Ended, MergeReport, MergeRequest, Outcome};
use diagnostic::{Problem, counted};
use std::path::Path;

/// Takes over what shards have.
pub fn merge(arguments: &Merge, setting: &Host) -> Result<Done, Problem> {
    let request = MergeRequest {
        out: arguments.out.clone(),
        ..MergeRequest::new(&arguments.study, arguments.shards.clone())
    };
    let report = corroborate::merge(&request, setting)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => of_merge(&report, &arguments.study),
        },
        outcome: report.outcome(),
    })
}

fn of_merge(report: &MergeReport, study: &Path) -> String {
    let mut text = String::new();
    for campaign in &report.campaigns {
        text.push_str(&format!("{}\n", took(campaign)));
    }
    let mut systems: Vec<&str> = report.shards.iter().map(|it| it.system.as_str()).collect();
    systems.sort_unstable();
    systems.dedup();
    if systems.len() > 1 {
        text.push_str(&format!(
            "The shards come from different systems ({}): only episodes that several of them have show whether these compute alike.\n",
            systems.join(", ")
        ));
    }
    let costs = report.shards.iter().flat_map(|it| &it.campaigns);
    let secs: f64 = costs.map(|it| it.wall_secs).sum();
    text.push_str(&format!(
        "{} took {secs:.1} s in all\n",
        counted(report.shards.len() as u64, "shard")
    ));
    match report.outcome() {
        Outcome::Holds => text + &format!("Next: corroborate run {}\n", study.display()),
        _ => {
            text + "Nothing is lost: merge again when the other shards are there, or let `corroborate run` simulate the rest\n"
        }
    }
}

/// What a campaign took over.
fn took(campaign: &MergedCampaign) -> String {
    let MergedCampaign {
        evidence,
        asked,
        known,
        taken,
        repeated,
        missing,
        is_decided,
    } = campaign;
    let mut text = format!("{evidence}: {} taken over", counted(*taken, "episode"));
    if *known > 0 {
        text.push_str(&format!(", {known} were there before"));
    }
    if *repeated > 0 {
        text.push_str(&format!("; {repeated} are in several shards, the same"));
    }
    match (missing, is_decided) {
        (Some([first, last]), _) => text.push_str(&format!(
            "; of {asked} MISSING from {first} on, up to {last} in no shard"
        )),
        (None, true) => text.push_str(&format!(
            "; its stopping rule ends it there, of {asked} at most"
        )),
        (None, false) => text.push_str(&format!("; all {asked} are there")),
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let merge: serde_json::Value = schemars::schema_for!(MergeReport).into();
        crate::command::tests::assert_schema_is_committed("merge.schema.json", &merge);
    }
}
