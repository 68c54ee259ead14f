//! `corroborate plan`: what a run of a study would do.

use super::{Done, Host, json};
use crate::args::{Format, Plan};
use crate::written;
use corroborate::Outcome;
use corroborate::{Freshness, PlannedEvidence, RunPlan, RunRequest};
use diagnostic::{Problem, counted};

/// Plans a run.
pub fn plan(arguments: &Plan, setting: &Host) -> Result<Done, Problem> {
    let request = RunRequest {
        techniques: corroborate::Techniques::default(),
        study: arguments.study.clone(),
        out: arguments.out.clone(),
        only: arguments.only.clone(),
    };
    let plan = corroborate::plan(&request, setting);
    let mistakes = plan.as_ref().err().map(written::of_problem);
    written::keep_sarif(arguments.sarif.as_deref(), &mistakes.unwrap_or_default())?;
    let plan = plan?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&plan)?,
            Format::Text => text(&plan),
        },
        outcome: Outcome::Holds,
    })
}

fn text(plan: &RunPlan) -> String {
    let widths = plan.evidence.iter().map(|it| it.id.chars().count());
    let width = widths.max().unwrap_or(0).max("comparison".len());
    let line = |name: &str, what: &str| format!("{name:<width$}  {what}\n");
    let mut output: String = plan
        .evidence
        .iter()
        .map(|it| line(&it.id, &evidence(it)))
        .collect();
    if let Some(comparison) = &plan.comparison {
        output.push_str(&line("comparison", &freshness(comparison)));
    }
    output.push_str(&sum(plan));
    output
}

/// What a run would produce, in one sentence.
fn sum(plan: &RunPlan) -> String {
    let count = |is: fn(&Freshness) -> bool| {
        let all = plan.evidence.iter();
        all.filter(|planned| is(&planned.freshness)).count()
    };
    let fresh = count(|it| matches!(it, Freshness::Fresh));
    let waiting = count(|it| matches!(it, Freshness::Awaits { .. }));
    let impossible = count(|it| matches!(it, Freshness::CannotProduce { .. }));
    let all = plan.evidence.len();
    if plan.is_fresh() {
        return "A run would produce nothing.\n".to_owned();
    }
    if fresh == all {
        return "A run would produce no evidence, and compare again.\n".to_owned();
    }
    let mut sum = format!(
        "A run would produce {} of {all} pieces of evidence",
        all - fresh - waiting - impossible
    );
    if waiting > 0 {
        sum.push_str(&format!("; {waiting} may be stale"));
    }
    if impossible > 0 {
        sum.push_str(&format!("; {impossible} cannot be produced here"));
    }
    match plan.last_took_secs() {
        (secs, 0) => sum.push_str(&format!(", which took {} last time", time(secs))),
        (secs, _) if secs > 0.0 => sum.push_str(&format!(
            ", of which those that were produced before took {} last time",
            time(secs)
        )),
        _ => {}
    }
    sum.push_str(".\n");
    sum
}

/// A time to two digits, which is more than is known of it.
fn time(secs: f64) -> String {
    match secs {
        secs if secs < 0.1 => "less than 0.1 s".to_owned(),
        secs if secs < 9.95 => format!("{secs:.1} s"),
        secs if secs < 120.0 => format!("{secs:.0} s"),
        secs if secs < 7200.0 => format!("{:.0} min", secs / 60.0),
        secs => format!("{:.0} h", secs / 3600.0),
    }
}

/// What is to be done for one piece of evidence.
fn evidence(planned: &PlannedEvidence) -> String {
    let kept = match planned.kept_episodes {
        None | Some(0) => String::new(),
        Some(kept) => format!("; {} of an interrupted run kept", counted(kept, "episode")),
    };
    let took = planned.last_took_secs.map_or(String::new(), |secs| {
        format!("; took {} last time", time(secs))
    });
    format!("{}{kept}{took}", freshness(&planned.freshness))
}

fn freshness(of: &Freshness) -> String {
    match of {
        Freshness::Fresh => "fresh".to_owned(),
        Freshness::NotProduced => "not produced yet".to_owned(),
        Freshness::Damaged => "stale: what was kept is damaged".to_owned(),
        Freshness::FilesChanged { files } => format!("stale: {} changed", files.join(", ")),
        Freshness::OtherInputs => {
            "stale: settings, counts that it depends on, or the program changed".to_owned()
        }
        Freshness::Awaits { evidence } => format!("waits for {}", evidence.join(", ")),
        Freshness::CannotProduce { reason } => format!("cannot be produced here: {reason}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(RunPlan).into();
        crate::command::tests::assert_schema_is_committed("plan.schema.json", &schema);
    }
}
