//! `corroborate explore`: episodes that are meant to show what nobody has
//! thought of; or where formal model and bench differ.

use super::{Done, Host, json, use_threads};
use crate::args::{Explore, Format};
use corroborate::Ended;
use corroborate::explore::{DisagreementRequest, ExploreRequest, map_disagreement};
use corroborate::technique::exploration::{as_text, disagreement_text};
use diagnostic::Problem;
use std::path::PathBuf;
use std::time::Instant;

/// The environment's name for the folder in which controllers leave which of
/// their lines ran.
const COVERAGE: &str = "CORROBORATE_COVERAGE";

/// Explores and writes what was found.
pub fn explore(arguments: &Explore, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    if arguments.disagreement {
        return disagreement(arguments, setting);
    }
    let request = ExploreRequest {
        study: arguments.study.clone(),
        file: arguments.file.clone(),
        episodes: arguments.episodes,
        sources: arguments.source.clone(),
        plain: arguments.plain,
        seed: arguments.seed,
        causes: arguments.causes,
        out: arguments.out.clone(),
        coverage: std::env::var_os(COVERAGE).map(PathBuf::from),
    };
    let began = Instant::now();
    let report = corroborate::explore(&request, setting)?;
    let wall_secs = began.elapsed().as_secs_f64();
    setting
        .events
        .say(&format!("{wall_secs:.1} s of wall time"));
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => as_text(&report),
        },
        outcome: report.outcome(),
    })
}

/// Searches for disagreement, and writes what was found.
fn disagreement(arguments: &Explore, setting: &Host) -> Result<Done, Problem> {
    let request = DisagreementRequest {
        study: arguments.study.clone(),
        file: arguments.file.clone(),
        episodes: arguments.episodes,
        seed: arguments.seed,
        out: arguments.out.clone(),
    };
    let report = map_disagreement(&request, setting)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => disagreement_text(&report),
        },
        outcome: report.outcome(),
    })
}

#[cfg(test)]
mod tests {
    use crate::command::tests::assert_schema_is_committed;
    use corroborate::technique::exploration::ExplorationReport;
    use evidence::DisagreementMap;

    #[test]
    fn the_committed_schemas_are_the_forms_that_are_written() {
        let schema: serde_json::Value = schemars::schema_for!(ExplorationReport).into();
        assert_schema_is_committed("exploration.schema.json", &schema);
        let schema: serde_json::Value = schemars::schema_for!(DisagreementMap).into();
        assert_schema_is_committed("disagreement.schema.json", &schema);
    }
}
