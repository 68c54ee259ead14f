//! `corroborate run --shard`: some of a study's episodes on one of several machines.

use crate::args::{Format, Run};
use crate::command::{Done, Host, json, use_threads};
use corroborate::shard::ShardOfCampaign;
use corroborate::{Outcome, ShardReport, ShardRequest};
use diagnostic::Problem;
use std::path::Path;

/// Runs a shard.
pub(super) fn shard(
    arguments: &Run,
    of: (u64, u64),
    out: &Path,
    setting: &Host,
) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let request = ShardRequest {
        only: arguments.only.clone(),
        ..ShardRequest::new(&arguments.study, of, out)
    };
    let report = corroborate::shard(&request, setting)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => of_shard(&report, &arguments.study, out),
        },
        outcome: Outcome::Holds,
    })
}

fn of_shard(report: &ShardReport, study: &Path, out: &Path) -> String {
    let lines = report.campaigns.iter().map(|it| format!("{}\n", ran(it)));
    let lines: String = lines.collect();
    format!(
        "{lines}Shard {} of {} is in {out}\nNext, with all shards: corroborate merge {study} {out} ...\n",
        report.shard,
        report.of,
        out = out.display(),
        study = study.display()
    )
}

/// What a shard ran of a campaign.
fn ran(run: &ShardOfCampaign) -> String {
    let id = &run.evidence;
    if run.episodes == 0 {
        return format!("{id}: no episodes fall to this shard");
    }
    let last = run.first + run.episodes - 1;
    format!(
        "{id}: episodes {} to {last} ({:.1} s)",
        run.first, run.wall_secs
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let shard: serde_json::Value = schemars::schema_for!(ShardReport).into();
        crate::command::tests::assert_schema_is_committed("shard.schema.json", &shard);
    }
}
