//! `corroborate what-if`: variants of the assets, side by side.

use super::{Done, Host, json, use_threads};
use crate::args::{Format, WhatIf};
use corroborate::Outcome;
use corroborate::WhatIfRequest;
use diagnostic::Problem;

/// Tries the variants.
pub fn what_if(arguments: &WhatIf, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let request = WhatIfRequest {
        study: arguments.study.clone(),
        out: arguments.out.clone(),
        variants: arguments.variant.clone(),
        points: usize::from(arguments.points),
        episodes: arguments.episodes,
    };
    let report = corroborate::what_if(&request, setting, &report::html)?;
    Ok(Done {
        outcome: Outcome::Holds,
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => report.text(),
        },
    })
}

#[cfg(test)]
mod tests {
    use corroborate::what_if::report::WhatIfReport;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(WhatIfReport).into();
        crate::command::tests::assert_schema_is_committed("what-if.schema.json", &schema);
    }
}
