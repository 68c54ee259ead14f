//! `corroborate check`: properties of one model, like the peers' command
//! lines.

use super::{Done, Setting, json};
use crate::args::{Check, Format};
use crate::outcome::Outcome;
use crate::problem::{Problem, Source};
use crate::study::Method;
use crate::technique::model_checking::{sharp_complement, warning_line};
use checker::explore::ExploreOptions;
use checker::state_space::StateSpace;
use checker::{Answer, AnswerValue, Guarantee, Options};
use prism_lang::{Constants, NamedProperty, Rational, resolved};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use std::time::Instant;

/// What `check --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CheckReport {
    /// Version of this form.
    pub format: String,
    /// The model's file.
    pub model: String,
    /// Reachable states.
    pub states: u64,
    /// Transitions between pairs of states.
    pub transitions: u64,
    /// Initial states.
    pub initial_states: u64,
    /// States without a command, which were given a self-loop.
    pub deadlocks: u64,
    /// Seconds for building the state space.
    pub build_secs: f64,
    /// One for each property, in the order asked.
    pub properties: Vec<PropertyReport>,
}

/// The answer to one property.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PropertyReport {
    /// Its place among the properties, from 1.
    pub prop_idx: usize,
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Its text.
    pub property: String,
    /// The value as text: a number, a fraction, `true` or `false`, or
    /// `[low,high]` over several initial states.
    pub result: Option<String>,
    /// The value as a number, if it is one.
    pub value: Option<f64>,
    /// One minus the value, computed directly.
    pub complement: Option<f64>,
    /// `exact`, `bounded`, `statistical` or `estimated`.
    pub guarantee: Option<String>,
    /// Lower bound, where there are bounds.
    pub low: Option<f64>,
    /// Upper bound, where there are bounds.
    pub high: Option<f64>,
    /// Largest distance of the value from the truth, where it is known.
    pub abs_err: Option<f64>,
    /// Whether the value is exact.
    pub exact: bool,
    /// How it was computed.
    pub method: String,
    /// Rounds of iteration.
    pub iterations: u64,
    /// What to know besides, for example why a value is only an estimate.
    pub notes: Vec<String>,
    /// Why there is no answer.
    pub error: Option<String>,
    /// Whether that is because it is not supported.
    pub unsupported: bool,
    /// Seconds for the answer.
    pub check_secs: f64,
}

/// Checks properties of a model.
pub fn check(arguments: &Check, setting: &Setting) -> Result<Done, Problem> {
    let given = constants(&arguments.constants)?;
    let source = Source::read(&arguments.model)?;
    let parsed = prism_lang::parse_model(&source.text);
    if let Some(problem) = Problem::from_diagnostics(&source, &parsed.diagnostics) {
        return Err(problem);
    }
    let own = constants_of_model(arguments, &parsed.tree, &given)?;
    let model = prism_lang::resolve(&parsed.tree, &own).map_err(|found| {
        Problem::from_diagnostics(&source, &found)
            .unwrap_or_else(|| Problem::new("cannot-resolve", "the model cannot be resolved"))
    })?;
    for warning in parsed.diagnostics.iter().chain(&model.warnings) {
        setting.talk.say(&warning_line(&source, warning));
    }
    let asked = properties(arguments, &model, &given)?;
    if asked.is_empty() && (arguments.properties.is_some() || !arguments.property_texts.is_empty())
    {
        setting
            .talk
            .say("warning: no property was given, so nothing is checked");
    }
    let limits = ExploreOptions {
        max_states: usize::try_from(arguments.max_states).unwrap_or(usize::MAX),
        ..ExploreOptions::for_properties(asked.iter().map(|p| &p.property))
    };
    let report = match arguments.method {
        Method::Exact => {
            let began = Instant::now();
            let space = explore::<Rational>(&source, &model, &limits, setting)?;
            let build_secs = began.elapsed().as_secs_f64();
            let answer =
                |p: &NamedProperty, o: &Options| checker::check_exact(&space, &p.property, o);
            report(arguments, &space, build_secs, &asked, setting, answer)?
        }
        _ => {
            let began = Instant::now();
            let space = explore::<f64>(&source, &model, &limits, setting)?;
            let build_secs = began.elapsed().as_secs_f64();
            let answer =
                |p: &NamedProperty, o: &Options| checker::check_space(&space, &p.property, o);
            report(arguments, &space, build_secs, &asked, setting, answer)?
        }
    };
    let outcome = outcome(&report);
    let output = match arguments.format {
        Format::Json => json(&report)?,
        Format::Text => text(&report),
    };
    Ok(Done { output, outcome })
}

fn constants(texts: &[String]) -> Result<Constants, Problem> {
    Constants::parse(&texts.join(",")).map_err(|error| {
        Problem::new("bad-constants", format!("--const: {error}"))
            .remedy("write for example --const N=5,p=0.1")
    })
}

/// Constants may be meant for the model or for the properties' file; the model
/// is given those that it declares.
fn constants_of_model(
    arguments: &Check,
    tree: &prism_lang::ast::Model,
    given: &Constants,
) -> Result<Constants, Problem> {
    let declared: Vec<&str> = tree
        .constants
        .iter()
        .map(|c| c.name.text.as_str())
        .collect();
    let mut own = Constants::new();
    for (name, value) in &given.0 {
        if declared.contains(&name.as_str()) {
            own.set(name.clone(), value.clone());
        } else if arguments.properties.is_none() {
            return Err(Problem::new(
                "unknown-constant",
                format!("the model declares no constant `{name}`"),
            )
            .remedy(format!("it declares {}", declared.join(", "))));
        }
    }
    Ok(own)
}

fn properties(
    arguments: &Check,
    model: &resolved::Model,
    given: &Constants,
) -> Result<Vec<NamedProperty>, Problem> {
    let mut sources = Vec::new();
    if let Some(argument) = &arguments.properties {
        let looks_like_file = Path::new(argument).exists()
            || [".props", ".pctl", ".csl", ".prop", ".ltl"]
                .iter()
                .any(|e| argument.ends_with(e));
        sources.push(if looks_like_file {
            Source::read(Path::new(argument))?
        } else {
            given_property(argument)
        });
    }
    sources.extend(
        arguments
            .property_texts
            .iter()
            .map(|text| given_property(text)),
    );
    let mut all = Vec::new();
    for source in &sources {
        let parsed = prism_lang::parse_properties(&source.text);
        if let Some(problem) = Problem::from_diagnostics(source, &parsed.diagnostics) {
            return Err(problem);
        }
        let resolved = prism_lang::resolve_properties(&parsed.tree, model, given);
        all.extend(resolved.map_err(|found| {
            Problem::from_diagnostics(source, &found)
                .unwrap_or_else(|| Problem::new("cannot-resolve", "a property cannot be resolved"))
        })?);
    }
    Ok(all)
}

fn given_property(text: &str) -> Source {
    Source {
        name: "<property>".into(),
        text: text.to_owned(),
    }
}

fn explore<N: prism_lang::Arithmetic>(
    source: &Source,
    model: &resolved::Model,
    limits: &ExploreOptions,
    setting: &Setting,
) -> Result<StateSpace<N>, Problem> {
    crate::technique::model_checking::explore_within(source, model, limits.clone(), &|| {
        setting.interrupt.is_set()
    })
}

fn report<N>(
    arguments: &Check,
    space: &StateSpace<N>,
    build_secs: f64,
    asked: &[NamedProperty],
    setting: &Setting,
    answer: impl Fn(&NamedProperty, &Options) -> Result<Answer, checker::CheckError>,
) -> Result<CheckReport, Problem> {
    let cancel = || setting.interrupt.is_set();
    let mut options = Options::with_method(arguments.method.of_checker());
    options.precision = arguments.precision;
    options.epsilon = arguments.epsilon;
    options.max_iters = arguments.max_iterations.unwrap_or(options.max_iters);
    options.cancel = Some(&cancel);
    let mut properties = Vec::new();
    for (place, property) in selected(arguments, asked)? {
        let began = Instant::now();
        let answered = answer(property, &options);
        if matches!(answered, Err(checker::CheckError::Cancelled)) {
            return Err(Problem::interrupted());
        }
        let check_secs = began.elapsed().as_secs_f64();
        properties.push(property_report(
            place,
            property,
            answered,
            arguments.method,
            check_secs,
        ));
    }
    Ok(CheckReport {
        format: "1.0".into(),
        model: arguments.model.display().to_string(),
        states: space.num_states() as u64,
        transitions: space.num_transitions() as u64,
        initial_states: space.initial_states().len() as u64,
        deadlocks: space.deadlocks().len() as u64,
        build_secs,
        properties,
    })
}

fn selected<'a>(
    arguments: &Check,
    asked: &'a [NamedProperty],
) -> Result<Vec<(usize, &'a NamedProperty)>, Problem> {
    let numbered = || asked.iter().enumerate().map(|(i, p)| (i + 1, p));
    if arguments.selected.is_empty() {
        return Ok(numbered().collect());
    }
    arguments
        .selected
        .iter()
        .map(|wanted| {
            numbered()
                .find(|(place, p)| p.name.as_ref() == Some(wanted) || place.to_string() == *wanted)
                .ok_or_else(|| {
                    let names: Vec<&str> = asked.iter().filter_map(|p| p.name.as_deref()).collect();
                    Problem::new(
                        "unknown-property",
                        format!("there is no property `{wanted}`"),
                    )
                    .remedy(format!(
                        "there are {} properties{}{}",
                        asked.len(),
                        if names.is_empty() { "" } else { ", named " },
                        names.join(", ")
                    ))
                })
        })
        .collect()
}

fn property_report(
    prop_idx: usize,
    property: &NamedProperty,
    answered: Result<Answer, checker::CheckError>,
    method: Method,
    check_secs: f64,
) -> PropertyReport {
    let mut report = PropertyReport {
        prop_idx,
        name: property.name.clone(),
        property: property.text.clone(),
        result: None,
        value: None,
        complement: None,
        guarantee: None,
        low: None,
        high: None,
        abs_err: None,
        exact: false,
        method: method.name().into(),
        iterations: 0,
        notes: Vec::new(),
        error: None,
        unsupported: false,
        check_secs,
    };
    match answered {
        Ok(answer) => fill(&mut report, answer),
        Err(error) => {
            report.unsupported = matches!(error, checker::CheckError::Unsupported(_));
            report.error = Some(error.to_string());
        }
    }
    report
}

fn fill(report: &mut PropertyReport, answer: Answer) {
    let (result, value) = match &answer.value {
        AnswerValue::Number(value) => (value.to_string(), Some(*value)),
        AnswerValue::Exact(value) => (value.to_string(), Some(prism_lang::rational_to_f64(value))),
        AnswerValue::Range { low, high } => (format!("[{low},{high}]"), None),
        AnswerValue::ExactRange { low, high } => (format!("[{low},{high}]"), None),
        AnswerValue::Truth(truth) => (truth.to_string(), None),
    };
    report.result = Some(result);
    report.value = value;
    report.complement = sharp_complement(&answer);
    report.iterations = answer.iterations;
    report.notes = answer.notes;
    let guarantee = match answer.guarantee {
        Guarantee::Exact => {
            report.exact = true;
            report.abs_err = Some(0.0);
            "exact"
        }
        Guarantee::Bounded { low, high } => {
            (report.low, report.high) = (Some(low), Some(high));
            report.abs_err = value.map(|v| (high - v).max(v - low).next_up());
            "bounded"
        }
        Guarantee::Statistical { low, high, .. } => {
            (report.low, report.high) = (Some(low), Some(high));
            "statistical"
        }
        Guarantee::Estimated { reason } => {
            report.notes.insert(0, reason);
            "estimated"
        }
    };
    report.guarantee = Some(guarantee.into());
}

fn outcome(report: &CheckReport) -> Outcome {
    let any = |test: &dyn Fn(&PropertyReport) -> bool| report.properties.iter().any(test);
    if any(&|p| p.result.as_deref() == Some("false")) {
        Outcome::Violated
    } else if any(&|p| p.error.is_some()) {
        Outcome::Inconclusive
    } else {
        Outcome::Holds
    }
}

fn text(report: &CheckReport) -> String {
    let mut output = format!(
        "{}: {} states, {} transitions, {} initial, built in {:.3} s\n",
        report.model, report.states, report.transitions, report.initial_states, report.build_secs
    );
    if report.deadlocks > 0 {
        output.push_str(&format!(
            "{} deadlock states were given a self-loop\n",
            report.deadlocks
        ));
    }
    for property in &report.properties {
        let name = property
            .name
            .as_ref()
            .map_or(String::new(), |n| format!("\"{n}\": "));
        output.push_str(&format!("\nModel checking: {name}{}\n", property.property));
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(CheckReport).into();
        crate::command::tests::assert_schema_is_committed("check.schema.json", &schema);
    }
}
