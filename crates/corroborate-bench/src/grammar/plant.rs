//! The catalogue of faults of generated studies, and how each is planted.
//!
//! Magnitudes go from hardly visible to gross. The *power in theory* of a planted fault is that of the best single test
//! on the data of the study: for a rate that differs, the difference test of [`crate::theory`] at the 5 % level between
//! the faulty asset and the other source that tells most, on the subject that tells most; for two forms that judge
//! runs differently, the probability that one of the runs shows it. Rates of bounded times are counted on 4000 runs of
//! the truth.

mod data;
mod model;
mod requirement;

use super::draft::{Draft, Stream};
use super::machine::Run;
use crate::random::Random;
use data::{clock, columns, drifted, outlier, scaled, shared};
use model::{constant, impossible, missing};
use requirement::{binding, bound, clause, unit};

/// A fault of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Plant {
    /// Nothing.
    Nothing,
    /// A constant of the model is wrong, and acts once in a run.
    WrongConstant,
    /// A constant of the model is wrong, and acts several times in a run.
    RepeatedConstant,
    /// The model lacks a way to fail.
    MissingBranch,
    /// The model fails in a way that never happens.
    ImpossibleBranch,
    /// The property has another limit of time.
    PropertyBound,
    /// The monitor has another limit of time.
    MonitorBound,
    /// The property waits for the end instead of success.
    PropertyClause,
    /// The monitor waits for the end instead of success.
    MonitorClause,
    /// A word means another state of the model.
    ModelBinding,
    /// A word means another state of traces.
    TraceBinding,
    /// Words count each other's columns.
    WrongColumn,
    /// Two kinds of failure were written down as each other.
    SwappedRows,
    /// The limit of speed has another unit.
    SpeedUnit,
    /// The map of topics declares another unit of length.
    TopicUnit,
    /// A parameter of the simulator is scaled.
    ScaledParameter,
    /// The speed sensor of the recorded system drifted.
    DriftedSensor,
    /// The simulator's clock is wrong.
    WrongClock,
    /// One person fails much more often than all others.
    OutlierPerson,
    /// Model and simulator share a wrong number.
    SharedAssumption,
}

/// Whom it is right to suspect first.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Culprit {
    /// The kind of the suspect, as in the program's output.
    pub kind: &'static str,
    /// A part of its file's or part's name that has to be there; empty for any.
    pub names: String,
}

/// What was planted.
#[derive(Clone, Debug)]
pub struct Planted {
    /// The fault.
    pub plant: Plant,
    /// Whom it is right to suspect first; any of them.
    pub culprits: Vec<Culprit>,
    /// The subjects that it touches.
    pub subjects: Vec<String>,
    /// The files in which a change can fix it; empty where no text can.
    pub mended_in: Vec<&'static str>,
    /// What a line that fixes it contains; empty for any.
    pub mended_by: String,
    /// The power of the best single test.
    pub power: f64,
    /// What was done, in words.
    pub words: String,
}

impl Plant {
    /// All faults, after nothing.
    pub const ALL: [Plant; 20] = [
        Plant::Nothing,
        Plant::WrongConstant,
        Plant::RepeatedConstant,
        Plant::MissingBranch,
        Plant::ImpossibleBranch,
        Plant::PropertyBound,
        Plant::MonitorBound,
        Plant::PropertyClause,
        Plant::MonitorClause,
        Plant::ModelBinding,
        Plant::TraceBinding,
        Plant::WrongColumn,
        Plant::SwappedRows,
        Plant::SpeedUnit,
        Plant::TopicUnit,
        Plant::ScaledParameter,
        Plant::DriftedSensor,
        Plant::WrongClock,
        Plant::OutlierPerson,
        Plant::SharedAssumption,
    ];

    /// Its name in tables and folders.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Plant::Nothing => "nothing",
            Plant::WrongConstant => "wrong-constant",
            Plant::RepeatedConstant => "repeated-constant",
            Plant::MissingBranch => "missing-branch",
            Plant::ImpossibleBranch => "impossible-branch",
            Plant::PropertyBound => "property-bound",
            Plant::MonitorBound => "monitor-bound",
            Plant::PropertyClause => "property-clause",
            Plant::MonitorClause => "monitor-clause",
            Plant::ModelBinding => "model-binding",
            Plant::TraceBinding => "trace-binding",
            Plant::WrongColumn => "wrong-column",
            Plant::SwappedRows => "swapped-rows",
            Plant::SpeedUnit => "speed-unit",
            Plant::TopicUnit => "topic-unit",
            Plant::ScaledParameter => "scaled-parameter",
            Plant::DriftedSensor => "drifted-sensor",
            Plant::WrongClock => "wrong-clock",
            Plant::OutlierPerson => "outlier-person",
            Plant::SharedAssumption => "shared-assumption",
        }
    }
}

fn culprit(kind: &'static str, names: &str) -> Culprit {
    Culprit {
        kind,
        names: names.to_owned(),
    }
}

/// Plants a fault; `None` where the system has nothing that it could be planted in.
#[must_use]
pub fn plant(plant: Plant, draft: &mut Draft) -> Option<Planted> {
    let mut random = Random::new(draft.seed.0 ^ 0x666c_6177, draft.seed.1);
    let mut planted = Planted {
        plant,
        culprits: Vec::new(),
        subjects: Vec::new(),
        mended_in: Vec::new(),
        mended_by: String::new(),
        power: 0.0,
        words: "nothing".into(),
    };
    let done = match plant {
        Plant::Nothing => Some(()),
        Plant::WrongConstant => constant(draft, &mut planted, false, &mut random),
        Plant::RepeatedConstant => constant(draft, &mut planted, true, &mut random),
        Plant::MissingBranch => missing(draft, &mut planted, &mut random),
        Plant::ImpossibleBranch => impossible(draft, &mut planted, &mut random),
        Plant::PropertyBound | Plant::MonitorBound => bound(draft, &mut planted, &mut random),
        Plant::PropertyClause | Plant::MonitorClause => clause(draft, &mut planted),
        Plant::ModelBinding | Plant::TraceBinding => binding(draft, &mut planted),
        Plant::WrongColumn | Plant::SwappedRows => columns(draft, &mut planted),
        Plant::SpeedUnit | Plant::TopicUnit => unit(draft, &mut planted),
        Plant::ScaledParameter => scaled(draft, &mut planted, &mut random),
        Plant::DriftedSensor => drifted(draft, &mut planted, &mut random),
        Plant::WrongClock => clock(draft, &mut planted, &mut random),
        Plant::OutlierPerson => outlier(draft, &mut planted, &mut random),
        Plant::SharedAssumption => shared(draft, &mut planted, &mut random),
    };
    done.map(|()| planted)
}

/// Trials of the experiment.
fn trials_of(draft: &Draft) -> f64 {
    (draft.cohort.rows * draft.cohort.attempts) as f64
}

/// Independent trials of the experiment with this many opportunities.
fn worth(draft: &Draft, trials: f64) -> f64 {
    let rows = draft.cohort.rows as f64;
    trials / (1.0 + (trials / rows - 1.0).max(0.0) * draft.cohort.correlation)
}

/// The share of runs of the truth for which something holds, of 4000.
fn share(draft: &Draft, holds: &dyn Fn(&Run, f64) -> bool) -> f64 {
    let mut random = draft.stream(Stream::Truth);
    let runs = draft.runs(&draft.truth, 4000, &mut random);
    runs.iter()
        .filter(|(run, speed)| holds(run, *speed))
        .count() as f64
        / 4000.0
}
