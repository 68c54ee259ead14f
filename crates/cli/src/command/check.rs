//! `corroborate check`: properties of one model, like the peers' command
//! lines.

mod print;
mod properties;

use super::{Done, Setting, json};
use crate::args::{Check, Format};
use crate::outcome::Outcome;
use crate::problem::{Problem, Source};
use crate::study::Method;
use crate::technique::model_checking::{sharp_complement, warning_line};
use checker::explore::ExploreOptions;
use checker::state_space::StateSpace;
use checker::{Answer, AnswerValue, Guarantee, Options};
use prism_lang::{Constants, Experiment, NamedProperty, Rational, resolved};
use properties::{Asked, Wrong};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;

/// What `check --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CheckReport {
    /// Version of this form.
    pub format: String,
    /// The model's file.
    pub model: String,
    /// The state space; of several valuations of constants the first one's.
    #[serde(flatten)]
    pub built: Built,
    /// The state spaces of further valuations, in their order.
    pub further: Vec<Built>,
    /// One for each property, in the order asked, for each valuation.
    pub properties: Vec<PropertyReport>,
}

/// A state space that was built.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Built {
    /// The values of the constants that run over ranges, as `name=value,...`.
    pub constants: Option<String>,
    /// Reachable states.
    pub states: u64,
    /// Transitions between pairs of states.
    pub transitions: u64,
    /// Initial states.
    pub initial_states: u64,
    /// States without a command, which were given a self-loop.
    pub deadlocks: u64,
    /// Seconds for building it.
    pub build_secs: f64,
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
    /// The values of the constants that run over ranges, as `name=value,...`.
    pub constants: Option<String>,
    /// The value as text: a number, a fraction, `true`, `false`, `Infinity` or `NaN`, or
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
    /// The states that the property's filters list.
    pub printed: Vec<PrintedState>,
    /// Why there is no answer.
    pub error: Option<String>,
    /// Whether that is because it is not supported.
    pub unsupported: bool,
    /// Seconds for the answer.
    pub check_secs: f64,
}

/// A state that a filter lists.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PrintedState {
    /// Its number.
    pub state: u64,
    /// Its variables' values, as `(name=value,...)`.
    pub values: String,
    /// The property's value there.
    pub result: String,
}

/// How many valuations of constants one command checks.
const MOST_VALUATIONS: u64 = 1_000_000;

/// Checks properties of a model, for each valuation of its constants.
pub fn check(arguments: &Check, setting: &Setting) -> Result<Done, Problem> {
    let experiment = constants(&arguments.constants)?;
    let source = Source::read(&arguments.model)?;
    let parsed = prism_lang::parse_model(&source.text);
    if let Some(problem) = Problem::from_diagnostics(&source, &parsed.diagnostics) {
        return Err(problem);
    }
    let ranges = experiment.ranges();
    let mut all: Option<CheckReport> = None;
    for given in experiment.valuations() {
        let mut report = check_one(arguments, &source, &parsed, &given, setting)?;
        report.built.constants = valuation(&given, &ranges);
        for property in &mut report.properties {
            property.constants = valuation(&given, &ranges);
        }
        match &mut all {
            None => all = Some(report),
            Some(all) => {
                all.further.push(report.built);
                all.properties.append(&mut report.properties);
            }
        }
    }
    // An experiment has at least one valuation.
    let report = all.ok_or_else(|| Problem::new("bad-constants", "there is no valuation"))?;
    let outcome = outcome(&report);
    let output = match arguments.format {
        Format::Json => json(&report)?,
        Format::Text => print::text(&report),
    };
    Ok(Done { output, outcome })
}

/// The values of the constants that run over ranges, if any does.
fn valuation(given: &Constants, ranges: &[&str]) -> Option<String> {
    let value = |name: &&str| given.get(name).map(|value| format!("{name}={value}"));
    let values: Vec<String> = ranges.iter().filter_map(value).collect();
    (!values.is_empty()).then(|| values.join(","))
}

/// Checks properties of a model whose constants have one value each.
fn check_one(
    arguments: &Check,
    source: &Source,
    parsed: &prism_lang::Parsed<prism_lang::ast::Model>,
    given: &Constants,
    setting: &Setting,
) -> Result<CheckReport, Problem> {
    let own = constants_of_model(arguments, &parsed.tree, given)?;
    let model = prism_lang::resolve(&parsed.tree, &own).map_err(|found| {
        Problem::from_diagnostics(source, &found)
            .unwrap_or_else(|| Problem::new("cannot-resolve", "the model cannot be resolved"))
    })?;
    for warning in parsed.diagnostics.iter().chain(&model.warnings) {
        setting.talk.say(&warning_line(source, warning));
    }
    let asked = properties::properties(arguments, &model, given)?;
    if asked.is_empty() && (arguments.properties.is_some() || !arguments.property_texts.is_empty())
    {
        setting
            .talk
            .say("warning: no property was given, so nothing is checked");
    }
    let meaningful = asked.iter().filter_map(|asked| match asked {
        Asked::Property(property) => Some(&property.property),
        Asked::Wrong(_) => None,
    });
    let limits = ExploreOptions {
        max_states: usize::try_from(arguments.max_states).unwrap_or(usize::MAX),
        ..ExploreOptions::for_properties(meaningful)
    };
    let began = Instant::now();
    match arguments.method {
        Method::Exact => {
            let space = explore::<Rational>(source, &model, &limits, setting)?;
            let build_secs = began.elapsed().as_secs_f64();
            let answer =
                |p: &NamedProperty, o: &Options| checker::check_exact(&space, &p.property, o);
            report(arguments, &space, build_secs, &asked, setting, answer)
        }
        _ => {
            let space = explore::<f64>(source, &model, &limits, setting)?;
            let build_secs = began.elapsed().as_secs_f64();
            let answer =
                |p: &NamedProperty, o: &Options| checker::check(&space, &model, &p.property, o);
            report(arguments, &space, build_secs, &asked, setting, answer)
        }
    }
}

fn constants(texts: &[String]) -> Result<Experiment, Problem> {
    let experiment = Experiment::parse(&texts.join(",")).map_err(|error| {
        Problem::new("bad-constants", format!("--const: {error}"))
            .remedy("write for example --const N=5,p=0.1 or, for a range, --const N=1:2:9")
    })?;
    if experiment.len() > MOST_VALUATIONS {
        let count = experiment.len();
        let message = format!("--const: the ranges have {count} valuations");
        let remedy = format!("give at most {MOST_VALUATIONS} in one command");
        return Err(Problem::new("bad-constants", message).remedy(remedy));
    }
    Ok(experiment)
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
    asked: &[Asked],
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
        let property = match property {
            Asked::Property(property) => property.as_ref(),
            Asked::Wrong(wrong) => {
                properties.push(wrong_report(place, wrong, arguments.method));
                continue;
            }
        };
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
        let described = properties
            .last_mut()
            .into_iter()
            .flat_map(|p| &mut p.printed);
        described.for_each(|listed| listed.values = space.describe(listed.state as usize));
    }
    Ok(CheckReport {
        format: "1.0".into(),
        model: arguments.model.display().to_string(),
        built: Built {
            constants: None,
            states: space.num_states() as u64,
            transitions: space.num_transitions() as u64,
            initial_states: space.initial_states().len() as u64,
            deadlocks: space.deadlocks().len() as u64,
            build_secs,
        },
        further: Vec::new(),
        properties,
    })
}

fn selected<'a>(arguments: &Check, asked: &'a [Asked]) -> Result<Vec<(usize, &'a Asked)>, Problem> {
    let numbered = || asked.iter().enumerate().map(|(i, p)| (i + 1, p));
    if arguments.selected.is_empty() {
        return Ok(numbered().collect());
    }
    arguments
        .selected
        .iter()
        .map(|wanted| {
            numbered()
                .find(|(place, p)| {
                    p.name() == Some(wanted.as_str()) || place.to_string() == *wanted
                })
                .ok_or_else(|| {
                    let names: Vec<&str> = asked.iter().filter_map(Asked::name).collect();
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
    let mut report = empty(
        prop_idx,
        property.name.clone(),
        property.text.clone(),
        method,
    );
    report.check_secs = check_secs;
    match answered {
        Ok(answer) => fill(&mut report, answer),
        Err(error) => {
            report.unsupported = matches!(error, checker::CheckError::Unsupported(_));
            report.error = Some(error.to_string());
        }
    }
    report
}

/// A property that means nothing over this model.
fn wrong_report(prop_idx: usize, wrong: &Wrong, method: Method) -> PropertyReport {
    let mut report = empty(prop_idx, wrong.name.clone(), wrong.text.clone(), method);
    report.unsupported = wrong.unsupported;
    report.error = Some(wrong.message.clone());
    report
}

fn empty(
    prop_idx: usize,
    name: Option<String>,
    property: String,
    method: Method,
) -> PropertyReport {
    PropertyReport {
        prop_idx,
        name,
        property,
        constants: None,
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
        printed: Vec::new(),
        error: None,
        unsupported: false,
        check_secs: 0.0,
    }
}

fn fill(report: &mut PropertyReport, answer: Answer) {
    let value = match &answer.value {
        AnswerValue::Number(value) => Some(*value),
        AnswerValue::Exact(value) => Some(prism_lang::rational_to_f64(value)),
        _ => None,
    };
    report.result = Some(print::value(&answer.value));
    report.value = value.filter(|value| value.is_finite());
    let listed = |(state, value): &(usize, AnswerValue)| PrintedState {
        state: *state as u64,
        values: String::new(),
        result: print::value(value),
    };
    report.printed = answer.printed.iter().map(listed).collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(CheckReport).into();
        crate::command::tests::assert_schema_is_committed("check.schema.json", &schema);
    }
}
