//! `corroborate compare`: the comparisons of a study that has been run.

use super::{Done, json};
use crate::args::{Compare, Format};
use corroborate::outcome::Outcome;
use corroborate::results::{read_current_result, results_folder};
use diagnostic::Problem;
use evidence::{Comparison, StudyResult};
use schemars::JsonSchema;
use serde::Serialize;

/// What `compare --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CompareReport {
    /// Version of this form.
    pub format: String,
    /// The pairs that were asked for.
    pub comparisons: Vec<Comparison>,
}

/// Prints comparisons.
pub fn compare(arguments: &Compare) -> Result<Done, Problem> {
    let folder = results_folder(&arguments.study, arguments.out.as_deref());
    let result = read_current_result(&arguments.study, &folder)?;
    let known = |id: &String| result.evidence.iter().any(|e| &e.id == id);
    if let Some(unknown) = arguments.evidence.iter().find(|id| !known(id)) {
        let ids: Vec<&str> = result.evidence.iter().map(|e| e.id.as_str()).collect();
        return Err(Problem::new(
            "unknown-evidence",
            format!("the ledger has no evidence `{unknown}`"),
        )
        .remedy(format!("it has {}", ids.join(", "))));
    }
    let chosen: Vec<&Comparison> = result
        .comparisons
        .iter()
        .filter(|c| is_chosen(c, &arguments.evidence))
        .collect();
    let outcome = if chosen
        .iter()
        .any(|c| c.outcome == evidence::Outcome::Conflicts)
    {
        Outcome::Violated
    } else if chosen
        .iter()
        .any(|c| c.outcome == evidence::Outcome::Inconclusive)
    {
        Outcome::Inconclusive
    } else {
        Outcome::Holds
    };
    let output = match arguments.format {
        Format::Json => json(&CompareReport {
            format: "1.0".into(),
            comparisons: chosen.into_iter().cloned().collect(),
        })?,
        Format::Text => text(&result, &chosen),
    };
    Ok(Done { output, outcome })
}

/// With one identifier: its pairs. With more: the pairs among them.
fn is_chosen(comparison: &Comparison, ids: &[String]) -> bool {
    let named = |id: &String| ids.contains(id);
    match ids.len() {
        0 => true,
        1 => named(&comparison.left) || named(&comparison.right),
        _ => named(&comparison.left) && named(&comparison.right),
    }
}

fn text(result: &StudyResult, chosen: &[&Comparison]) -> String {
    let mut output = String::new();
    let mut subject = "";
    for comparison in chosen {
        if comparison.subject.id() != subject {
            subject = comparison.subject.id();
            output.push_str(&format!("\n{}\n", heading(result, subject)));
        }
        output.push_str(&format!(
            "  {:<28} {:<15} {}\n",
            format!("{} and {}", comparison.left, comparison.right),
            outcome_name(comparison),
            comparison.reason
        ));
    }
    if output.is_empty() {
        output.push_str("There is nothing to compare.\n");
    }
    output.trim_start().to_owned()
}

fn heading(result: &StudyResult, id: &str) -> String {
    if let Some(requirement) = result.requirements.iter().find(|r| r.id == id) {
        return format!("{id}  {}", requirement.text);
    }
    let mode = result.failure_modes.iter().find(|m| m.id == id);
    mode.map_or_else(|| id.to_owned(), |m| m.name.clone())
}

fn outcome_name(comparison: &Comparison) -> &'static str {
    match comparison.outcome {
        evidence::Outcome::Corroborates if comparison.independent => "corroborates",
        evidence::Outcome::Corroborates => "fits",
        evidence::Outcome::Conflicts => "conflicts",
        evidence::Outcome::Inconclusive => "inconclusive",
        evidence::Outcome::NotComparable => "not comparable",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(CompareReport).into();
        crate::command::tests::assert_schema_is_committed("compare.schema.json", &schema);
    }
}
