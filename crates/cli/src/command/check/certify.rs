//! `check --certify`: each answer checked again by code that shares nothing with the solver (crate `certifier`).

use super::ending::Ending;
use super::properties::Asked;
use super::{CheckReport, PropertyReport};
use crate::args::Check;
use crate::problem::{Problem, Source};
use certifier::{Certificate, Certified, Failure, certify_while};
use checker::explore::ExploreOptions;
use checker::state_space::StateSpace;
use checker::{CheckError, Options};
use prism_lang::{NamedProperty, Property, StateFormula, resolved};
use schemars::JsonSchema;
use serde::Serialize;

/// What became of checking an answer again.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CertificateReport {
    /// `certified`: the bounds below are shown, and the answer agrees with them; `refuted`: they are shown, and it
    /// does not; `not certified`: nothing was shown; `not finished`: the command had to end before.
    pub status: String,
    /// What the value is at least.
    pub low: Option<f64>,
    /// What the value is at most.
    pub high: Option<f64>,
    /// How many states of the model were read anew.
    pub states: u64,
    /// How many inequalities were checked.
    pub inequalities: u64,
    /// Why nothing was shown, or what does not agree.
    pub why: Option<String>,
}

impl CertificateReport {
    /// Whether the answer was certified.
    pub fn is_good(&self) -> bool {
        self.status == "certified"
    }

    /// Whether the command had to end before.
    pub fn is_unfinished(&self) -> bool {
        self.status == NOT_FINISHED
    }
}

/// The status of what the command had to end before.
const NOT_FINISHED: &str = "not finished";

/// How many times more than the residual bounds are widened by, one after the other.
const SLACKS: [f64; 4] = [2.0, 32.0, 1024.0, 1_048_576.0];

/// Certifies all answers of a report.
pub(super) fn all(
    report: &mut CheckReport,
    arguments: &Check,
    source: &Source,
    model: &resolved::Model,
    asked: &[Asked],
    ending: &Ending,
) -> Result<(), Problem> {
    let limits = ExploreOptions {
        max_states: usize::try_from(arguments.max_states).unwrap_or(usize::MAX),
        ..ExploreOptions::default()
    };
    let space = match super::explore::<f64>(source, model, &limits, ending) {
        Err(_) if ending.is_due() => None,
        space => Some(space?),
    };
    let cancel = || ending.is_due();
    let options = Options {
        precision: arguments.precision,
        fair: arguments.fair,
        cancel: Some(&cancel),
        ..Options::default()
    };
    for property in &mut report.properties {
        let Some(Asked::Property(named)) = asked.get(property.prop_idx - 1) else {
            continue;
        };
        if property.error.is_none() {
            let found = match &space {
                Some(space) if !ending.is_due() => one(property, named, space, model, &options),
                _ => None,
            };
            // The answer stays.
            let ended = || CertificateReport {
                status: NOT_FINISHED.into(),
                ..nothing(format!("the command was {}", ending.reason()))
            };
            property.certificate = Some(found.unwrap_or_else(ended));
        }
    }
    Ok(())
}

/// What became of an answer; nothing if the work had to end.
fn one(
    report: &PropertyReport,
    named: &NamedProperty,
    space: &StateSpace<f64>,
    model: &resolved::Model,
    options: &Options<'_>,
) -> Option<CertificateReport> {
    let go_on = || !options.cancel.is_some_and(|cancel| cancel());
    let states: Vec<Vec<i64>> = (0..space.num_states()).map(|s| space.state(s)).collect();
    let mut why = String::new();
    for slack in SLACKS {
        let bounds = match checker::bounds_of_states(space, &named.property, options, slack) {
            Ok(bounds) => bounds,
            Err(CheckError::Cancelled) => return None,
            Err(error) => return Some(nothing(error.to_string())),
        };
        let certificate = Certificate {
            states: states.clone(),
            lower: bounds.lower,
            upper: bounds.upper,
            scheduler: bounds.scheduler,
        };
        match certify_while(model, &named.property, &certificate, &go_on) {
            Ok(certified) => return Some(judged(report, named, &certified)),
            Err(Failure::Cancelled) => return None,
            // Wider bounds may pass.
            Err(failure @ Failure::Broken { .. }) => why = failure.to_string(),
            Err(failure) => return Some(nothing(failure.to_string())),
        }
    }
    Some(nothing(why))
}

fn nothing(why: String) -> CertificateReport {
    CertificateReport {
        status: "not certified".into(),
        low: None,
        high: None,
        states: 0,
        inequalities: 0,
        why: Some(why),
    }
}

/// Whether an answer agrees with what was shown.
fn judged(
    report: &PropertyReport,
    named: &NamedProperty,
    certified: &Certified,
) -> CertificateReport {
    let (low, high) = (certified.low, certified.high);
    let why = match report.result.as_deref() {
        Some("true") => agrees(named, certified, true),
        Some("false") => agrees(named, certified, false),
        Some("Infinity") => Some(low == f64::INFINITY),
        _ => {
            let ends = (report.low.or(report.value), report.high.or(report.value));
            match ends {
                (Some(from), Some(to)) => Some(from <= high && low <= to),
                _ => None,
            }
        }
    };
    let (status, why) = match why {
        Some(true) => ("certified", None),
        Some(false) => {
            let why = format!("the value is shown to lie between {low} and {high}");
            ("refuted", Some(why))
        }
        None => {
            let why = format!("the value is shown to lie between {low} and {high} only");
            ("not certified", Some(why))
        }
    };
    let finite = |x: f64| x.is_finite().then_some(x);
    CertificateReport {
        status: status.into(),
        low: finite(low),
        high: finite(high),
        states: certified.states as u64,
        inequalities: certified.inequalities,
        why,
    }
}

/// Whether bounds agree that a property has this truth value; `None` if they leave it open.
fn agrees(named: &NamedProperty, certified: &Certified, truth: bool) -> Option<bool> {
    let (comparison, bound) = match &named.property {
        Property::Probability {
            bound: Some((comparison, bound)),
            ..
        } => (comparison, bound),
        Property::State(StateFormula::Reward { bound, .. }) => (&bound.0, &bound.1),
        _ => return None,
    };
    let bound = prism_lang::Rational::from_float(bound.to_f64())
        .filter(|exact| Some(exact) == bound.exact())
        .map(|_| bound.to_f64())
        .map_or_else(
            || (bound.to_f64().next_down(), bound.to_f64().next_up()),
            |exact| (exact, exact),
        );
    let holds_at = |value: f64| {
        let (a, b) = (
            comparison.holds(&value, &bound.0),
            comparison.holds(&value, &bound.1),
        );
        (a == b).then_some(a)
    };
    match (holds_at(certified.low)?, holds_at(certified.high)?) {
        (low, high) if low == high => Some(low == truth),
        _ => None,
    }
}

/// The lines of a certificate, for reading.
pub(super) fn text(certificate: &CertificateReport) -> String {
    let mut line = format!("Certificate: {}", certificate.status);
    if let (Some(low), Some(high)) = (certificate.low, certificate.high) {
        line.push_str(&format!(
            ", between {low} and {high} ({} inequalities in {} states)",
            certificate.inequalities, certificate.states
        ));
    }
    if let Some(why) = &certificate.why {
        line.push_str(&format!(": {why}"));
    }
    line.push('\n');
    line
}
