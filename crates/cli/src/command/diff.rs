//! `corroborate diff`: what differs between two results of a study.

mod text;

use super::{Done, json};
use crate::args::{Diff, DiffFormat};
use corroborate::{DiffRequest, Ended};
use diagnostic::Problem;

/// Compares two results.
pub fn diff(arguments: &Diff) -> Result<Done, Problem> {
    let request = DiffRequest {
        old: arguments.old.clone(),
        new: arguments.new.clone(),
    };
    let report = corroborate::diff(&request)?;
    Ok(Done {
        outcome: report.outcome(),
        output: match arguments.format {
            DiffFormat::Json => json(&report)?,
            DiffFormat::Text => text::plain(&report),
            DiffFormat::Markdown => text::markdown(&report),
        },
    })
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(corroborate::DiffReport).into();
        crate::command::tests::assert_schema_is_committed("diff.schema.json", &schema);
    }
}
