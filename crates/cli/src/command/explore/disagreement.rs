//! `corroborate explore --disagreement`: where formal model and bench part.

use crate::args::Format;
use crate::command::{Done, Host, json};
use corroborate::kept::DISAGREEMENT;
use corroborate::outcome::Outcome;
use corroborate::technique::exploration::{MapSearch, disagreement_text};
use diagnostic::Problem;
use evidence::{DisagreementMap, SearchEnd};
use host::files::write_whole;

/// Searches, and writes what was found.
pub fn search(search: &MapSearch<'_>, format: Format, setting: &Host) -> Result<Done, Problem> {
    let report = search.go_on(setting)?;
    let path = search.folder.join(DISAGREEMENT);
    write_whole(&path, json(&report)?.as_bytes())?;
    setting
        .events
        .say(&format!("{} is written", path.display()));
    Ok(Done {
        output: match format {
            Format::Json => json(&report)?,
            Format::Text => disagreement_text(&report),
        },
        outcome: outcome(&report),
    })
}

fn outcome(report: &DisagreementMap) -> Outcome {
    match report.ended {
        SearchEnd::Interrupted => Outcome::Interrupted,
        _ if report.shares.differs > 0.0 => Outcome::Violated,
        SearchEnd::Decided => Outcome::Holds,
        SearchEnd::Budget => Outcome::Inconclusive,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_written() {
        let schema: serde_json::Value = schemars::schema_for!(DisagreementMap).into();
        crate::command::tests::assert_schema_is_committed("disagreement.schema.json", &schema);
    }
}
