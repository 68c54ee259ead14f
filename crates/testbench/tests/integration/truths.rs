//! What tests of truth share: a scene, the signals that are read of it, both engines.
#![allow(dead_code, reason = "each test file uses a part")]

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::engines::common;
use stimulus::Stimulus;
use testbench::controller::{Controller, ControllerError, Description, Inputs, Outputs, Setup};
use testbench::scene::{BuildPhysics, ControllerData, SceneBench, mujoco, rapier};
use testbench::{Bench, Cancel, Recorded, Unwatched};
use trace::Trace;

/// Starts a scene's controllers.
pub type Start = fn(&ControllerData) -> Result<Box<dyn Controller>, ControllerError>;

/// No controller is asked for.
pub fn no_controller(_: &ControllerData) -> Result<Box<dyn Controller>, ControllerError> {
    Err(ControllerError::Failed {
        message: "there is none".to_owned(),
    })
}

/// The engines that are there, by name.
pub fn engines() -> Vec<(&'static str, BuildPhysics)> {
    let mut engines: Vec<(&str, BuildPhysics)> = vec![("Rapier", rapier())];
    if let Some(engine) = common::engine() {
        engines.push(("MuJoCo", mujoco(&engine)));
    }
    engines
}

/// A scene with its descriptions.
pub struct Scene<'a> {
    pub text: &'a str,
    pub files: &'a [(&'a str, &'a str)],
    pub start: Start,
}

impl<'a> Scene<'a> {
    /// A scene without controllers.
    pub fn new(text: &'a str, files: &'a [(&'a str, &'a str)]) -> Self {
        Self {
            text,
            files,
            start: no_controller,
        }
    }

    /// The bench in an engine, or what is wrong.
    pub fn bench(&self, physics: BuildPhysics, read: &[&str]) -> Result<SceneBench, String> {
        let files: BTreeMap<String, Vec<u8>> = self
            .files
            .iter()
            .map(|(name, text)| ((*name).to_owned(), text.as_bytes().to_vec()))
            .collect();
        let file = |name: &str| files.get(name).cloned().ok_or(format!("no {name}"));
        let made = SceneBench::new(self.text, &file, physics, Arc::new(self.start));
        let (bench, _) = made.map_err(|error| error.to_string())?;
        let names = read.iter().map(|name| (*name).to_owned());
        let declared = bench
            .record_truth(names)
            .map_err(|error| error.to_string())?;
        declared.map_err(|unknown| unknown.to_string())
    }

    /// An episode of the first test.
    pub fn run(&self, physics: BuildPhysics, read: &[&str]) -> Recorded {
        let bench = self
            .bench(physics, read)
            .unwrap_or_else(|error| panic!("{error}"));
        let first = Stimulus::of(bench.tests()[0].clone());
        let run = bench.run(&first, 3, &mut Unwatched, &Cancel::default());
        run.unwrap_or_else(|error| panic!("{error}"))
    }

    /// An episode in each engine.
    pub fn in_each(&self, read: &[&str], test: impl Fn(&str, &Trace)) {
        for (name, physics) in engines() {
            test(name, &self.run(physics, read).trace);
        }
    }
}

/// The times and values of a signal.
pub fn signal(trace: &Trace, name: &str) -> Vec<(f64, f64)> {
    let index = trace.signal(name).unwrap_or_else(|| {
        let known: Vec<String> = trace.signal_names().collect();
        panic!("no {name} among {known:?}")
    });
    let channel = &trace.channels[index.channel];
    let times = channel.times_secs.iter().enumerate();
    times
        .map(|(row, time)| (*time, channel.row(row)[index.field]))
        .collect()
}

/// The value of a signal at the last row that is not after a time.
pub fn at(trace: &Trace, name: &str, secs: f64) -> f64 {
    let rows = signal(trace, name);
    let before = rows.iter().rev().find(|(time, _)| *time <= secs + 1e-9);
    before
        .unwrap_or_else(|| panic!("{name} has no row by {secs} s"))
        .1
}

/// The largest value of a signal.
pub fn most(trace: &Trace, name: &str) -> f64 {
    let values = signal(trace, name).into_iter().map(|(_, value)| value);
    values.fold(f64::NEG_INFINITY, f64::max)
}

/// Whether a truth value was ever true.
pub fn ever(trace: &Trace, name: &str) -> bool {
    signal(trace, name).iter().any(|(_, value)| *value == 1.0)
}

/// The name that an enumeration has at a time.
pub fn name_at(trace: &Trace, name: &str, secs: f64) -> String {
    let index = trace.signal(name).expect("the signal");
    let value = at(trace, name, secs);
    match &trace.field(index).expect("the field").kind {
        trace::FieldKind::Enumeration(names) => names[value as usize].clone(),
        other => panic!("{name} is {other:?}"),
    }
}

/// Commands at times: the setting `plan` is a list of `[secs, actuator, field, value]`.
struct Planned {
    description: Description,
    plan: Vec<(f64, String, String, f64)>,
}

/// Starts a controller that carries out the plan in its settings.
pub fn planned(_: &ControllerData) -> Result<Box<dyn Controller>, ControllerError> {
    Ok(Box::new(Planned {
        description: Description::new("planned", "1"),
        plan: Vec::new(),
    }))
}

impl Controller for Planned {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn set_up(&mut self, setup: &Setup) -> Result<(), ControllerError> {
        let plan = setup.settings.get("plan").cloned().unwrap_or_default();
        self.plan = serde_json::from_value(plan).map_err(|error| ControllerError::Failed {
            message: error.to_string(),
        })?;
        Ok(())
    }

    fn tick(&mut self, inputs: &Inputs) -> Result<Outputs, ControllerError> {
        let due = self
            .plan
            .iter()
            .filter(|(secs, ..)| *secs <= inputs.time_secs + 1e-9);
        Ok(due.fold(
            Outputs::default(),
            |outputs, (_, actuator, field, value)| outputs.command(actuator, field, *value),
        ))
    }
}
