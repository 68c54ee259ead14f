//! The form of the answers.

use crate::certify::CertificateReport;
use crate::parametric::ParametricReport;
use crate::properties::Wrong;
use crate::request::CheckRequest;
use checker::state_space::{Represented, StateSpace};
use checker::{Answer, AnswerValue, Guarantee};
use prism_lang::{Arithmetic, NamedProperty};
use schemars::JsonSchema;
use serde::Serialize;
use study::Method;

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
    /// If the command was interrupted: how far it had come.
    pub interrupted: Option<String>,
    /// With `--steady-state` and `--transient`: the probabilities of all states, for each valuation.
    pub distributions: Vec<DistributionReport>,
    /// One for each property, in the order asked, for each valuation.
    pub properties: Vec<PropertyReport>,
    /// Whether any state space was built.
    #[serde(skip)]
    pub(crate) is_built: bool,
}

impl CheckReport {
    /// Answers without a state space yet.
    pub(crate) fn new(request: &CheckRequest, properties: Vec<PropertyReport>) -> Self {
        Self {
            format: "1.0".into(),
            model: request.model.name(),
            built: Built::default(),
            is_built: false,
            further: Vec::new(),
            interrupted: None,
            distributions: Vec::new(),
            properties,
        }
    }

    /// Whether any state space was built.
    pub fn is_built(&self) -> bool {
        self.is_built
    }

    /// Whether no property was left because the command had to end.
    pub fn is_finished(&self) -> bool {
        let is_finished = |property: &PropertyReport| {
            let certificate = property.certificate.as_ref();
            property.unfinished.is_none() && !certificate.is_some_and(|c| c.is_unfinished())
        };
        self.interrupted.is_none() && self.properties.iter().all(is_finished)
    }

    /// Adds a state space.
    pub(crate) fn push(&mut self, mut built: Built) {
        for mut found in std::mem::take(&mut built.distributions) {
            found.constants.clone_from(&built.constants);
            self.distributions.push(found);
        }
        match std::mem::replace(&mut self.is_built, true) {
            false => self.built = built,
            true => self.further.push(built),
        }
    }
}

/// A state space that was built.
#[derive(Debug, Default, Serialize, JsonSchema)]
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
    /// States that were explored, if these stand for all others by symmetries of the model.
    pub states_up_to_symmetry: Option<u64>,
    /// Seconds for building it.
    pub build_secs: f64,
    /// Which valuation of constants it belongs to.
    #[serde(skip)]
    pub(crate) valuation: usize,
    /// The probabilities of its states, which the report lists beside it.
    #[serde(skip)]
    pub(crate) distributions: Vec<DistributionReport>,
}

impl PropertyReport {
    /// Whether it means nothing over the model, so that the input has to be fixed.
    pub fn is_wrong(&self) -> bool {
        self.is_wrong
    }

    /// Which valuation of constants it belongs to, from 0.
    pub fn valuation(&self) -> usize {
        self.valuation
    }
}

impl Built {
    /// Which valuation of constants it belongs to, from 0.
    pub fn valuation(&self) -> usize {
        self.valuation
    }

    pub(crate) fn new<N: Arithmetic>(space: &StateSpace<N>, build_secs: f64) -> Self {
        let explored = Represented {
            states: space.num_states() as u64,
            transitions: space.num_transitions() as u64,
            initial: space.initial_states().len() as u64,
            deadlocks: space.deadlocks().len() as u64,
        };
        let all = space.represented().unwrap_or(explored);
        Self {
            constants: None,
            states: all.states,
            transitions: all.transitions,
            initial_states: all.initial,
            deadlocks: all.deadlocks,
            states_up_to_symmetry: (all.states != explored.states).then_some(explored.states),
            build_secs,
            valuation: 0,
            distributions: Vec::new(),
        }
    }
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
    /// The values of the constants that run over ranges and that the property depends on, as `name=value,...`.
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
    /// With constants left open: the value as functions of these.
    pub parametric: Option<ParametricReport>,
    /// With `--certify`: what became of checking the answer again.
    pub certificate: Option<CertificateReport>,
    /// What to know besides, for example why a value is only an estimate.
    pub notes: Vec<String>,
    /// The states that the property's filters list.
    pub printed: Vec<PrintedState>,
    /// The most probable path that shows why, if it was asked for and there is one.
    pub witness: Option<WitnessReport>,
    /// Why there is no answer.
    pub error: Option<String>,
    /// Whether that is because it is not supported.
    pub unsupported: bool,
    /// If the command had to end before there was an answer (interrupted, or by its limit of memory or time): `stopped` while the
    /// property was checked, with the bounds reached so far if there are some, or `not begun`.
    pub unfinished: Option<String>,
    /// Seconds for the answer.
    pub check_secs: f64,
    /// Whether the property means nothing over the model, so that the input has to be fixed.
    #[serde(skip)]
    pub(crate) is_wrong: bool,
    /// Which valuation of constants it belongs to.
    #[serde(skip)]
    pub(crate) valuation: usize,
}

/// The probabilities of all states of a chain.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DistributionReport {
    /// `steady-state` (shares of the time in the long run) or `transient`.
    pub kind: String,
    /// The number of steps (`dtmc`) or the time (`ctmc`), if it is transient.
    pub time: Option<String>,
    /// The values of the constants that run over ranges, as `name=value,...`.
    pub constants: Option<String>,
    /// The largest distance of the bounds of one state.
    pub widest: f64,
    /// The states that may have a probability, unless they were written to a file.
    pub states: Vec<StateProbability>,
    /// The file to which the probabilities of all states were written.
    pub file: Option<String>,
    /// Why there is none.
    pub error: Option<String>,
    /// Whether that is because it is not supported.
    pub unsupported: bool,
}

/// The probability of a state.
#[derive(Debug, Serialize, JsonSchema)]
pub struct StateProbability {
    /// Its number, as in exported files.
    pub state: u64,
    /// Its variables' values, as `(value,...)`.
    pub values: String,
    /// The middle of the bounds.
    pub value: f64,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
    pub high: f64,
}

/// A path that shows why.
#[derive(Debug, Serialize, JsonSchema)]
pub struct WitnessReport {
    /// Whether it violates the path formula; else it satisfies it.
    pub violates: bool,
    /// Its probability.
    pub probability: f64,
    /// Its states, each as `(name=value,...)`.
    pub states: Vec<String>,
    /// The action taken in each state but the last, where the model has choices and the action a name.
    pub actions: Vec<Option<String>>,
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

/// The answer to a property, or why there is none.
pub(crate) fn property_report(
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
pub(crate) fn wrong_report(prop_idx: usize, wrong: &Wrong, method: Method) -> PropertyReport {
    let mut report = empty(prop_idx, wrong.name.clone(), wrong.text.clone(), method);
    report.unsupported = wrong.unsupported;
    report.is_wrong = !wrong.unsupported;
    report.error = Some(wrong.message.clone());
    report
}

/// A report without an answer.
pub(crate) fn empty(
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
        parametric: None,
        certificate: None,
        notes: Vec::new(),
        printed: Vec::new(),
        witness: None,
        error: None,
        unsupported: false,
        unfinished: None,
        check_secs: 0.0,
        is_wrong: false,
        valuation: 0,
    }
}

fn fill(report: &mut PropertyReport, answer: Answer) {
    let value = match &answer.value {
        AnswerValue::Number(value) => Some(*value),
        AnswerValue::Exact(value) => Some(prism_lang::rational_to_f64(value)),
        _ => None,
    };
    report.result = Some(crate::written::value(&answer.value));
    report.value = value.filter(|value| value.is_finite());
    let listed = |(state, value): &(usize, AnswerValue)| PrintedState {
        state: *state as u64,
        values: String::new(),
        result: crate::written::value(value),
    };
    report.printed = answer.printed.iter().map(listed).collect();
    report.complement = answer.sharp_complement();
    report.iterations = answer.iterations;
    report.notes = answer.notes;
    report.method = Method::name_of_checker(answer.method).into();
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
