//! Answers as text.

use super::{Built, CheckReport, PropertyReport};
use checker::AnswerValue;

/// A value, as PRISM writes it.
pub(super) fn value(value: &AnswerValue) -> String {
    match value {
        AnswerValue::Number(value) => number(*value),
        AnswerValue::Exact(value) => value.to_string(),
        AnswerValue::Range { low, high } => format!("[{},{}]", number(*low), number(*high)),
        AnswerValue::ExactRange { low, high } => format!("[{low},{high}]"),
        AnswerValue::Truth(truth) => truth.to_string(),
    }
}

fn number(value: f64) -> String {
    if value == f64::INFINITY {
        "Infinity".to_owned()
    } else if value == f64::NEG_INFINITY {
        "-Infinity".to_owned()
    } else {
        value.to_string()
    }
}

/// The size of a state space.
fn built(model: &str, built: &Built) -> String {
    let constants = built.constants.as_ref();
    let constants = constants.map_or(String::new(), |values| format!(" with {values}"));
    let mut line = format!(
        "{model}{constants}: {} states, {} transitions, {} initial, built in {:.3} s\n",
        built.states, built.transitions, built.initial_states, built.build_secs
    );
    if built.deadlocks > 0 {
        line.push_str(&format!(
            "{} deadlock states were given a self-loop\n",
            built.deadlocks
        ));
    }
    line
}

/// The report for reading.
pub(super) fn text(report: &CheckReport) -> String {
    let mut output = built(&report.model, &report.built);
    let mut further = report.further.iter().peekable();
    for property in &report.properties {
        // The properties of one valuation follow each other.
        if let Some(next) = further.next_if(|next| next.constants == property.constants) {
            output.push('\n');
            output.push_str(&built(&report.model, next));
        }
        let name = property
            .name
            .as_ref()
            .map_or(String::new(), |n| format!("\"{n}\": "));
        output.push_str(&format!("\nModel checking: {name}{}\n", property.property));
        if let Some(constants) = &property.constants {
            output.push_str(&format!("Constants: {constants}\n"));
        }
        for listed in &property.printed {
            output.push_str(&format!(
                "{}:{}={}\n",
                listed.state, listed.values, listed.result
            ));
        }
        match (&property.result, &property.error) {
            (Some(result), _) => {
                output.push_str(&format!("Result: {result}{}\n", in_brackets(property)));
            }
            (None, error) => {
                output.push_str(&format!(
                    "Error: {}\n",
                    error.as_deref().unwrap_or("no answer")
                ));
            }
        }
        for note in &property.notes {
            output.push_str(&format!("Note: {note}\n"));
        }
    }
    output
}

fn in_brackets(property: &PropertyReport) -> String {
    let mut parts = Vec::new();
    match (property.guarantee.as_deref(), property.low, property.high) {
        (Some("exact"), ..) => parts.push("exact".to_owned()),
        (Some(_), Some(low), Some(high)) => parts.push(format!("between {low} and {high}")),
        (Some("estimated"), ..) => parts.push("estimated".to_owned()),
        _ => {}
    }
    if let Some(complement) = property.complement
        && complement > 0.0
        && complement < 1e-6
    {
        parts.push(format!("1 - {complement:.6e}"));
    }
    parts.push(format!("{:.3} s", property.check_secs));
    format!(" ({})", parts.join("; "))
}
