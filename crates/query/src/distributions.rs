//! Probabilities of all states of a chain: in the long run, and at times (PRISM's `-steadystate` and `-transient`).
//!
//! States are in the order of the exported files, with the numbers that they have there.

use crate::export::Output;
use crate::report::{DistributionReport, StateProbability};
use crate::request::CheckRequest;
use checker::distribution::{after_steps, at_times, in_the_long_run};
use checker::formats::{Explicit, Written};
use checker::state_space::StateSpace;
use checker::{Bounds, CheckError, Options};
use diagnostic::Problem;
use prism_lang::resolved::ModelType;
use prism_lang::{Arithmetic, Experiment, Number};
use std::path::{Path, PathBuf};

/// How far the sum of given probabilities may be from 1: they are written with some digits only.
const MOST_OFF: f64 = 1e-9;

/// Whether any distribution is asked for.
pub(crate) fn are_asked(request: &CheckRequest) -> bool {
    request.transient.is_some() || is_long_run_asked(request)
}

fn is_long_run_asked(request: &CheckRequest) -> bool {
    // Who asks for the file wants what is to be in it.
    request.steady_state || request.exports.steady_state.is_some()
}

/// The distributions that the request asks for.
pub(crate) fn all<N: Arithmetic + Written + 'static>(
    request: &CheckRequest,
    space: &StateSpace<N>,
    options: &Options<'_>,
    output: Output<'_>,
) -> Result<Vec<DistributionReport>, Problem> {
    if !are_asked(request) {
        return match &request.exports.transient {
            Some(_) => Err(Problem::new(
                "bad-distribution",
                "the probabilities at a time are to be written, but no time is given",
            )
            .remedy("say when, for example `--transient 2.5`")),
            None => Ok(Vec::new()),
        };
    }
    let Some(space) = (space as &dyn std::any::Any).downcast_ref::<StateSpace<f64>>() else {
        return Err(Problem::new(
            "bad-distribution",
            "the probabilities of all states are computed with bounds, not exactly",
        )
        .remedy("choose another method than `exact`"));
    };
    let order = Explicit::new(space);
    let start = match &request.initial_distribution {
        Some(path) => Some(given(path, &order)?),
        None => None,
    };
    let start = start.as_deref();
    let mut reports = Vec::new();
    if is_long_run_asked(request) {
        let found = in_the_long_run(space, start, options);
        let file = request.exports.steady_state.as_deref();
        let found = found.map(|shares| vec![shares]);
        reports.extend(reports_of(
            &order,
            "steady-state",
            &[None],
            found,
            file,
            output,
        )?);
    }
    if let Some(times) = &request.transient {
        let times = instants(times)?;
        let found = match space.kind {
            ModelType::Dtmc => {
                let steps = times.iter().map(steps).collect::<Result<Vec<_>, _>>()?;
                after_steps(space, start, &steps, options)
            }
            _ => at_times(space, start, &times, options),
        };
        let named: Vec<Option<String>> = times.iter().map(|t| Some(t.to_string())).collect();
        let file = request.exports.transient.as_deref();
        reports.extend(reports_of(
            &order,
            "transient",
            &named,
            found,
            file,
            output,
        )?);
    }
    Ok(reports)
}

/// A time, or several: `2`, `0:5`, `0:0.5:5`; ascending.
fn instants(text: &str) -> Result<Vec<Number>, Problem> {
    let bad = || {
        Problem::new("bad-distribution", format!("`{text}` is not a time"))
            .remedy("write a time that is not negative, or a range: 2.5, 0:10 or 0:0.5:10")
    };
    let experiment = Experiment::parse(&format!("T={text}")).map_err(|_| bad())?;
    let time = |values: prism_lang::Constants| {
        let value = values.get("T")?.clone();
        match value {
            prism_lang::Value::Int(steps) => Some(Number::from_i64(steps)),
            prism_lang::Value::Double(time) => Some(time),
            prism_lang::Value::Bool(_) => None,
        }
    };
    let times: Option<Vec<Number>> = experiment.valuations().map(time).collect();
    let times = times.ok_or_else(bad)?;
    match times.iter().all(|time| *time >= Number::from_i64(0)) {
        true => Ok(times),
        false => Err(bad()),
    }
}

fn steps(time: &Number) -> Result<u64, Problem> {
    let whole = time.exact().filter(|time| time.is_integer());
    whole
        .and_then(|whole| u64::try_from(whole.to_integer()).ok())
        .ok_or_else(|| {
            let message = format!("{time} is not a number of steps");
            Problem::new("bad-distribution", message)
                .remedy("a `dtmc` is asked after a whole number of steps")
        })
}

/// A distribution as PRISM writes it: the probability of each state on a line of its own.
fn given(path: &Path, order: &Explicit<'_, f64>) -> Result<Vec<f64>, Problem> {
    let text = host::files::read_any_size(path)?.text;
    let bad = |message: String| {
        Problem::new("bad-distribution", format!("{}: {message}", path.display())).remedy(
            "write one probability in each line, in the order of the states in an exported FILE.sta",
        )
    };
    let mut numbers = Vec::new();
    for (line, text) in text.lines().enumerate() {
        let number = text.trim().parse::<f64>().ok();
        match number.filter(|number| (0.0..=1.0).contains(number)) {
            Some(number) => numbers.push(number),
            None if text.trim().is_empty() => {}
            None => {
                return Err(bad(format!(
                    "line {}: expected a probability, found `{text}`",
                    line + 1
                )));
            }
        }
    }
    let states = order.states().len();
    if numbers.len() != states {
        let lines = numbers.len();
        return Err(bad(format!(
            "there are {lines} probabilities for {states} states"
        )));
    }
    let sum: f64 = numbers.iter().sum();
    if (sum - 1.0).abs() > MOST_OFF {
        return Err(bad(format!("the probabilities sum to {sum}, not to 1")));
    }
    Ok((0..numbers.len())
        .map(|state| numbers[order.number(state)])
        .collect())
}

/// One report for each time, or one that says why there is none; files are written.
fn reports_of(
    order: &Explicit<'_, f64>,
    kind: &str,
    times: &[Option<String>],
    found: Result<Vec<Vec<Bounds>>, CheckError>,
    file: Option<&Path>,
    output: Output<'_>,
) -> Result<Vec<DistributionReport>, Problem> {
    let empty = |time: Option<&String>| DistributionReport {
        kind: kind.to_owned(),
        time: time.cloned(),
        constants: None,
        widest: 0.0,
        states: Vec::new(),
        file: None,
        error: None,
        unsupported: false,
    };
    let found = match found {
        Ok(found) => found,
        Err(error) => {
            let mut report = empty(None);
            report.unsupported = matches!(error, CheckError::Unsupported(_));
            report.error = Some(match error {
                CheckError::Cancelled => "ended before there were bounds".to_owned(),
                error => error.to_string(),
            });
            return Ok(vec![report]);
        }
    };
    let file = file.filter(|file| *file != Path::new("stdout"));
    let mut reports = Vec::new();
    for (time, bounds) in times.iter().zip(found) {
        let mut report = empty(time.as_ref());
        let width = |b: &Bounds| b.high - b.low;
        report.widest = bounds.iter().map(width).fold(0.0, f64::max);
        match file {
            None => report.states = listed(order, &bounds),
            Some(file) => {
                let file = match time {
                    Some(time) if times.len() > 1 => with_suffix(file, time),
                    _ => file.to_owned(),
                };
                write(order, &bounds, &file, output)?;
                report.file = Some(file.display().to_string());
            }
        }
        reports.push(report);
    }
    Ok(reports)
}

/// The states that may be in it.
fn listed(order: &Explicit<'_, f64>, bounds: &[Bounds]) -> Vec<StateProbability> {
    let listed = |state: &usize| StateProbability {
        state: order.number(*state) as u64,
        values: order.values(*state),
        value: bounds[*state].middle(),
        low: bounds[*state].low,
        high: bounds[*state].high,
    };
    let states = order.states().iter();
    states
        .filter(|s| bounds[**s].high > 0.0)
        .map(listed)
        .collect()
}

fn write(
    order: &Explicit<'_, f64>,
    bounds: &[Bounds],
    file: &Path,
    output: Output<'_>,
) -> Result<(), Problem> {
    let mut text = String::new();
    for state in order.states() {
        text.push_str(&bounds[*state].middle().written());
        text.push('\n');
    }
    output.write(file, text.as_bytes())
}

/// The file for one of several times, as PRISM names it.
fn with_suffix(file: &Path, suffix: &str) -> PathBuf {
    let name = file.display().to_string();
    PathBuf::from(match name.rsplit_once('.') {
        Some((stem, ending)) => format!("{stem}{suffix}.{ending}"),
        None => format!("{name}{suffix}"),
    })
}
