//! `check --param`: answers as rational functions of constants that stay open.

use crate::check::{explore, most_states, selected};
use crate::ending::Ending;
use crate::properties::{self, Asked, Text};
use crate::report::{Built, CheckReport, PropertyReport, empty, wrong_report};
use crate::request::CheckRequest;
use checker::explore::ExploreOptions;
use checker::parametric::{
    ParametricAnswer, ParametricValue, RationalFunction, Region, RegionError, solve,
};
use checker::state_space::StateSpace;
use checker::{CheckError, Options};
use diagnostic::{Problem, Source};
use prism_lang::{Constants, NamedProperty, rational_to_f64, resolved};
use schemars::JsonSchema;
use serde::Serialize;
use std::time::Instant;
use study::Method;

/// A property's value as functions of open constants.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ParametricReport {
    /// The open constants, in the order of the ranges of a region.
    pub parameters: Vec<String>,
    /// The parts of the region with an answer; each holds at all points strictly inside.
    pub parts: Vec<PartReport>,
    /// Parts without one: which choice is best, or whether a bound is met, differs inside.
    pub undecided: Vec<Vec<RangeReport>>,
    /// Parts at no point of which the model is one, since a probability is negative.
    pub ill_defined: Vec<Vec<RangeReport>>,
    /// What must hold at a point for the answer to hold there.
    pub conditions: Vec<ConditionReport>,
    /// Whether all conditions are known to hold on the whole region.
    pub conditions_hold: bool,
}

/// A part of the region.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PartReport {
    /// A range for each open constant.
    pub region: Vec<RangeReport>,
    /// The value in each initial state.
    pub values: Vec<ValueReport>,
}

/// The range of an open constant.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RangeReport {
    /// Its lower end, exactly.
    pub low: String,
    /// Its upper end, exactly.
    pub high: String,
}

/// A value as a function.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ValueReport {
    /// The function in PRISM's syntax, or `true`, `false`, `Infinity`, `-Infinity` or `NaN`.
    pub function: String,
    /// Its value in the middle of the part.
    pub at_centre: Option<f64>,
    /// Its derivative by each open constant, in the middle of the part.
    pub gradient_at_centre: Vec<f64>,
    /// Its derivative by each open constant.
    pub derivatives: Vec<String>,
}

/// A condition for the answer.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ConditionReport {
    /// A probability, a rate or a reward.
    pub function: String,
    /// `> 0` or `>= 0`.
    pub relation: String,
    /// Whether it holds on the whole region; `null` if that is not known.
    pub holds: Option<bool>,
}

/// Larger functions are not differentiated for the report.
const MOST_TERMS: usize = 2_000;

/// Checks properties of a model some of whose constants stay open.
pub(crate) fn check(
    request: &CheckRequest,
    source: &Source,
    tree: &prism_lang::ast::Model,
    own: &Constants,
    given: &Constants,
    texts: &[Text],
    ending: &Ending,
) -> Result<CheckReport, Problem> {
    let text = request.open.as_deref().unwrap_or_default();
    let names = Region::names(text);
    let none = Constants::new();
    let model = prism_lang::resolve_open(tree, own, &none, &names).map_err(|found| {
        study::placed::from_diagnostics(source, &found)
            .unwrap_or_else(|| Problem::new("cannot-resolve", "the model cannot be resolved"))
    })?;
    let region = Region::parse(text, &model.parameters).map_err(bad_region)?;
    let asked = properties::resolved(texts, &model, given)?;
    let meaningful = asked.iter().filter_map(|asked| match asked {
        Asked::Property(property) => Some(&property.property),
        Asked::Wrong(_) => None,
    });
    let limits = ExploreOptions {
        max_states: most_states(request),
        ..ExploreOptions::for_properties(meaningful)
    };
    let began = Instant::now();
    let space = explore::<RationalFunction>(source, &model, &limits, ending)?;
    let built = Built::new(&space, began.elapsed().as_secs_f64());
    let cancel = || ending.is_due();
    let mut options = Options::with_method(Method::Exact.of_checker());
    options.cancel = Some(&cancel);
    options.fair = request.fair;
    let mut properties = Vec::new();
    for (place, property) in selected(request, &asked)? {
        properties.push(match property {
            Asked::Property(property) => {
                if ending.is_due() {
                    let named = (place, property.name.clone(), property.text.clone());
                    ending.not_begun(named, Method::Exact)
                } else {
                    answer(place, property, &space, &model, &region, &options, ending)
                }
            }
            Asked::Wrong(wrong) => wrong_report(place, wrong, Method::Exact),
        });
    }
    let mut report = CheckReport::new(request, properties);
    report.push(built);
    Ok(report)
}

/// The answer to one property.
fn answer(
    place: usize,
    property: &NamedProperty,
    space: &StateSpace<RationalFunction>,
    model: &resolved::Model,
    region: &Region,
    options: &Options<'_>,
    ending: &Ending,
) -> PropertyReport {
    let began = Instant::now();
    let answered = solve(space, &property.property, region, options);
    let (name, text) = (property.name.clone(), property.text.clone());
    let mut report = empty(place, name, text, Method::Exact);
    report.method = "parametric".into();
    report.check_secs = began.elapsed().as_secs_f64();
    match answered {
        Err(CheckError::Cancelled) => {
            let named = (place, report.name, report.property);
            return ending.stopped(named, Method::Exact, None, report.check_secs);
        }
        Err(error) => {
            report.unsupported = matches!(error, CheckError::Unsupported(_));
            report.error = Some(error.to_string());
        }
        Ok(answer) => fill(&mut report, &answer, model),
    }
    report
}

fn bad_region(error: RegionError) -> Problem {
    Problem::new("bad-parameters", format!("open constants: {error}"))
        .remedy("write for example p=0:1,q=0.2:0.4")
}

fn fill(report: &mut PropertyReport, answer: &ParametricAnswer, model: &resolved::Model) {
    let names: Vec<&str> = model.parameters.iter().map(|p| p.name.as_str()).collect();
    let lines = answer.parts.iter().map(|part| {
        let values: Vec<String> = part.values.iter().map(|v| text(v, &names)).collect();
        format!("{}: {}", part.region, values.join(", "))
    });
    let lines: Vec<String> = lines.collect();
    report.result = Some(lines.join("\n"));
    if lines.is_empty() {
        report.result = None;
        report.error = Some("no part of the region could be decided".into());
    }
    report.exact = true;
    report.guarantee = Some("exact".into());
    report.abs_err = Some(0.0);
    report.notes.extend(notes(answer, &names));
    report.parametric = Some(ParametricReport {
        parts: (answer.parts.iter())
            .map(|part| PartReport {
                region: ranges(&part.region),
                values: (part.values.iter())
                    .map(|value| value_report(value, &part.region, &names))
                    .collect(),
            })
            .collect(),
        undecided: answer.undecided.iter().map(ranges).collect(),
        ill_defined: answer.ill_defined.iter().map(ranges).collect(),
        conditions: (answer.conditions.each.iter())
            .map(|condition| ConditionReport {
                function: condition.function.text(&names),
                relation: if condition.or_zero { ">= 0" } else { "> 0" }.into(),
                holds: condition.holds,
            })
            .collect(),
        conditions_hold: answer.conditions.hold(),
        parameters: names.into_iter().map(str::to_owned).collect(),
    });
}

/// What the reader has to know besides the functions.
fn notes(answer: &ParametricAnswer, names: &[&str]) -> Vec<String> {
    let mut notes = Vec::new();
    let open: Vec<String> = (answer.conditions.each.iter())
        .filter(|condition| condition.holds != Some(true))
        .map(|condition| {
            let relation = if condition.or_zero { ">=" } else { ">" };
            format!("{} {relation} 0", condition.function.text(names))
        })
        .collect();
    if !open.is_empty() {
        notes.push(format!(
            "the answer holds at the points of the region at which {}, which is not everywhere",
            open.join(" and ")
        ));
    }
    for (parts, what) in [
        (
            &answer.undecided,
            "undecided, since the answer differs inside",
        ),
        (
            &answer.ill_defined,
            "without a model, since a probability is negative",
        ),
    ] {
        if !parts.is_empty() {
            let parts: Vec<String> = parts.iter().map(ToString::to_string).collect();
            notes.push(format!("{what}: {}", parts.join(", ")));
        }
    }
    notes
}

fn text(value: &ParametricValue, names: &[&str]) -> String {
    match value {
        ParametricValue::Function(function) => function.text(names),
        ParametricValue::Infinite => "Infinity".to_owned(),
        ParametricValue::MinusInfinite => "-Infinity".to_owned(),
        ParametricValue::Undefined => "NaN".to_owned(),
        ParametricValue::Truth(truth) => truth.to_string(),
    }
}

fn value_report(value: &ParametricValue, region: &Region, names: &[&str]) -> ValueReport {
    let mut report = ValueReport {
        function: text(value, names),
        at_centre: None,
        gradient_at_centre: Vec::new(),
        derivatives: Vec::new(),
    };
    if let ParametricValue::Function(function) = value
        && function.size() <= MOST_TERMS
    {
        let centre = region.centre();
        report.at_centre = function.at(&centre).as_ref().map(rational_to_f64);
        for parameter in 0..names.len() {
            let slope = function.derivative(parameter);
            let here = slope.at(&centre).as_ref().map(rational_to_f64);
            report.gradient_at_centre.extend(here);
            report.derivatives.push(slope.text(names));
        }
    }
    report
}

fn ranges(region: &Region) -> Vec<RangeReport> {
    let range = |(low, high): &(prism_lang::Rational, prism_lang::Rational)| RangeReport {
        low: low.to_string(),
        high: high.to_string(),
    };
    region.ranges.iter().map(range).collect()
}
