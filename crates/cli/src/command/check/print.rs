//! Answers as text.

use super::form::{Built, CheckReport, PropertyReport, WitnessReport};
use crate::problem::Problem;
use checker::AnswerValue;

/// A value, as PRISM writes it.
pub(super) fn value(value: &AnswerValue) -> String {
    match value {
        AnswerValue::Number(value) => number(*value),
        AnswerValue::Exact(value) => value.to_string(),
        AnswerValue::Range { low, high } => format!("[{},{}]", number(*low), number(*high)),
        AnswerValue::ExactRange { low, high } => format!("[{low},{high}]"),
        AnswerValue::Ends { low, high } => format!("[{},{}]", self::value(low), self::value(high)),
        AnswerValue::Truth(truth) => truth.to_string(),
        AnswerValue::Corners(corners) => {
            let number = |value: &prism_lang::Rational| number(prism_lang::rational_to_f64(value));
            let corner = |corner: &Vec<prism_lang::Rational>| {
                let numbers: Vec<String> = corner.iter().map(number).collect();
                format!("({})", numbers.join(","))
            };
            let corners: Vec<String> = corners.iter().map(corner).collect();
            format!("[{}]", corners.join(","))
        }
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
    if let Some(explored) = built.states_up_to_symmetry {
        line.push_str(&format!(
            "{explored} states were explored, which stand for the others by symmetry\n"
        ));
    }
    if built.deadlocks > 0 {
        line.push_str(&format!(
            "{} deadlock states were given a self-loop\n",
            built.deadlocks
        ));
    }
    line
}

/// Whether a property is the first of a further state space.
fn begins(built: &Built, property: &PropertyReport) -> bool {
    built.valuation == property.valuation
}

/// One line for each answer.
pub(super) fn lines(report: &CheckReport) -> Result<String, Problem> {
    let mut output = String::new();
    for property in &report.properties {
        let line = serde_json::to_string(property)
            .map_err(|error| Problem::new("cannot-write", error.to_string()))?;
        output.push_str(&line);
        output.push('\n');
    }
    Ok(output)
}

/// The report for reading.
pub(super) fn text(report: &CheckReport) -> String {
    let mut output = match &report.interrupted {
        Some(how) if !report.is_built => format!("{}: {how}\n", report.model),
        _ => built(&report.model, &report.built),
    };
    let mut further = report.further.iter().peekable();
    for property in &report.properties {
        // The properties of one valuation follow each other.
        if let Some(next) = further.next_if(|next| begins(next, property)) {
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
            // One line for each part of the region.
            (Some(result), _) if property.parametric.is_some() => {
                output.push_str(&format!("Result: {result}\n"));
            }
            (Some(result), _) => {
                output.push_str(&format!("Result: {result}{}\n", in_brackets(property)));
            }
            (None, Some(why)) if property.unfinished.is_some() => {
                let bounds = match (property.low, property.high) {
                    (Some(low), Some(high)) => {
                        format!("between {} and {}, ", number(low), number(high))
                    }
                    _ => String::new(),
                };
                let capital = if bounds.is_empty() { "" } else { "Stopped: " };
                output.push_str(&format!("{capital}{bounds}{why}\n"));
            }
            (None, error) => {
                output.push_str(&format!(
                    "Error: {}\n",
                    error.as_deref().unwrap_or("no answer")
                ));
            }
        }
        if let Some(certificate) = &property.certificate {
            output.push_str(&super::certify::text(certificate));
        }
        if let Some(path) = &property.witness {
            output.push_str(&witness(path));
        }
        for note in &property.notes {
            output.push_str(&format!("Note: {note}\n"));
        }
    }
    output
}

/// A path, one line for each state.
fn witness(path: &WitnessReport) -> String {
    let does = if path.violates {
        "violates"
    } else {
        "satisfies"
    };
    let mut text = format!(
        "Most probable path that {does} it ({}):\n",
        path.probability
    );
    for (place, state) in path.states.iter().enumerate() {
        let action = path.actions.get(place).and_then(Option::as_ref);
        let action = action.map_or(String::new(), |action| format!("  [{action}]"));
        text.push_str(&format!("  {state}{action}\n"));
    }
    text
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
