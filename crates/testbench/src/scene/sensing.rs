//! Sensors at work: what they measure, with noise, bias, latency, dropout and faults.
//!
//! A measurement is true numbers, then the episode's bias, then normal noise, then what a fault
//! makes of it; it arrives after a latency, unless it is lost. None overtakes another. Numbers that
//! cannot be measured are NaN, and stay so.

use std::collections::{BTreeMap, VecDeque};

use stimulus::Distribution;

use super::build::{Built, BuiltRobot};
use super::data::{FaultKind, Sensor};
use super::draws::Draws;
use super::measure::{Instrument, Scenery};
use crate::controller::{Measurement, Port, PortField};
use crate::random::Stream;

/// Truth values have no noise.
const TRUTH_VALUES: [&str; 2] = ["seen", "touching"];

/// A fault in an episode.
#[derive(Debug, Clone, PartialEq)]
struct DrawnFault {
    kind: FaultKind,
    from_secs: f64,
    until_secs: f64,
    offset: Vec<f64>,
}

/// A sensor in an episode.
#[derive(Debug, Clone)]
pub(super) struct Sensing {
    pub(super) name: String,
    pub(super) robot: usize,
    pub(super) period_steps: u64,
    pub(super) fields: Vec<PortField>,
    instrument: Instrument,
    bias: Vec<f64>,
    noise: Vec<f64>,
    latency: Distribution,
    dropout_probability: f64,
    faults: Vec<DrawnFault>,
    /// What the test has made of it.
    pub(super) forced: Option<FaultKind>,
    /// What is measured outside instead, if it is: a list for each field, none while not known.
    pub(super) outside: Option<Option<Vec<Vec<f64>>>>,
    stream: Stream,
    last: Option<Vec<Vec<f64>>>,
    on_the_way: VecDeque<(f64, Arrived)>,
}

/// A measurement as it arrives: a list of numbers for each field.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Arrived {
    pub(super) measured_secs: f64,
    pub(super) values: Vec<Vec<f64>>,
}

impl Arrived {
    /// As a controller gets it.
    pub(super) fn measurement(&self, fields: &[PortField]) -> Measurement {
        let named = fields.iter().zip(&self.values);
        Measurement {
            time_secs: self.measured_secs,
            values: named
                .map(|(field, values)| (field.name.clone(), values.clone()))
                .collect(),
        }
    }
}

impl Sensing {
    /// The sensor at the beginning of an episode. `period_steps` is its period.
    pub(super) fn new(
        sensor: &Sensor,
        robot: usize,
        built: &Built,
        period_steps: u64,
        draws: Draws,
    ) -> Self {
        let drawn = |field: &str, d: &Distribution| draws.of("sensor", &sensor.name, field, d);
        let fields = sensor.fields();
        let errors = |list: &str, errors: &BTreeMap<String, Distribution>| -> Vec<f64> {
            let error = |field: &PortField| {
                let key = super::data::key_with_unit(field);
                let given = errors.get(&key);
                given.map_or(0.0, |d| drawn(&format!("{list}.{key}"), d))
            };
            fields.iter().map(error).collect()
        };
        let fault = |(index, fault): (usize, &super::data::Fault)| {
            let field = |name: &str| format!("fault.{index}.{name}");
            let probability = drawn(&field("probability"), &fault.probability);
            let name = format!("sensor.{}.{}", sensor.name, field("occurs"));
            let until_secs = fault.until_secs.as_ref();
            draws.stream(&name).chance(probability).then(|| DrawnFault {
                kind: fault.kind,
                from_secs: drawn(&field("from_secs"), &fault.from_secs),
                until_secs: until_secs.map_or(f64::INFINITY, |d| drawn(&field("until_secs"), d)),
                offset: errors(&field("offset"), &fault.offset),
            })
        };
        Self {
            name: sensor.name.clone(),
            robot,
            period_steps,
            instrument: Instrument::new(sensor, &built.robots[robot], &built.layout, draws),
            bias: errors("bias", &sensor.bias),
            noise: errors("noise", &sensor.noise),
            latency: sensor.latency_secs.clone(),
            dropout_probability: drawn("dropout_probability", &sensor.dropout_probability),
            faults: sensor.faults.iter().enumerate().filter_map(fault).collect(),
            forced: None,
            outside: None,
            stream: draws.stream(&errors_of(&sensor.name)),
            last: None,
            on_the_way: VecDeque::new(),
            fields,
        }
    }

    /// What a controller is told of it.
    pub(super) fn port(&self, sensor: &Sensor) -> Port {
        Port {
            name: self.name.clone(),
            kind: sensor.kind_name().to_owned(),
            fields: self.fields.clone(),
            facts: self.instrument.facts(sensor),
        }
    }

    /// Whether a fault is on, given by the scene or by the test.
    pub(super) fn fault(&self, now_secs: f64) -> Option<FaultKind> {
        if self.outside.is_some() {
            return None;
        }
        let given = self.faults.iter().find(|fault| is_on(fault, now_secs));
        self.forced.or(given.map(|fault| fault.kind))
    }

    /// Measures; the measurement sets out on its way.
    pub(super) fn measure(&mut self, scenery: &mut Scenery<'_>) {
        let now_secs = scenery.now_secs;
        if let Some(outside) = &self.outside {
            if let Some(values) = outside.clone() {
                let measured_secs = now_secs;
                let arrived = Arrived {
                    measured_secs,
                    values,
                };
                self.on_the_way.push_back((now_secs, arrived));
            }
            return;
        }
        let mut values = self.instrument.measure(scenery, &mut self.stream);
        for (index, numbers) in values.iter_mut().enumerate() {
            if TRUTH_VALUES.contains(&self.fields[index].name.as_str()) {
                continue;
            }
            let (bias, noise) = (self.bias[index], self.noise[index]);
            for number in numbers.iter_mut() {
                *number += bias;
                if noise > 0.0 {
                    *number += noise * self.stream.standard_normal();
                }
            }
        }
        self.spoil(now_secs, &mut values);
        let is_lost = self.stream.chance(self.dropout_probability)
            || self.fault(now_secs) == Some(FaultKind::Silent);
        let latency_secs = match &self.latency {
            Distribution::Constant(latency_secs) => *latency_secs,
            latency => latency.quantile(self.stream.unit()),
        };
        self.last = Some(values.clone());
        if is_lost {
            return;
        }
        let earliest_secs = self
            .on_the_way
            .back()
            .map_or(0.0, |(due_secs, _)| *due_secs);
        let arrived = Arrived {
            measured_secs: now_secs,
            values,
        };
        let due_secs = (now_secs + latency_secs).max(earliest_secs);
        self.on_the_way.push_back((due_secs, arrived));
    }

    /// Puts offsets on, or the last numbers in place of the new ones.
    fn spoil(&self, now_secs: f64, values: &mut Vec<Vec<f64>>) {
        for fault in self.faults.iter().filter(|fault| is_on(fault, now_secs)) {
            if fault.kind == FaultKind::Offset {
                for (numbers, offset) in values.iter_mut().zip(&fault.offset) {
                    numbers.iter_mut().for_each(|number| *number += offset);
                }
            }
        }
        let is_stuck =
            |fault: &DrawnFault| fault.kind == FaultKind::Stuck && is_on(fault, now_secs);
        let stuck = self.forced == Some(FaultKind::Stuck) || self.faults.iter().any(is_stuck);
        if let (true, Some(last)) = (stuck, &self.last) {
            values.clone_from(last);
        }
    }

    /// Draws errors from here on anew.
    pub(super) fn draw_anew(&mut self, draws: Draws) {
        self.stream = draws.stream(&errors_of(&self.name));
    }

    /// The next measurement that has arrived by now.
    pub(super) fn arrived(&mut self, now_secs: f64) -> Option<Arrived> {
        let (due_secs, _) = self.on_the_way.front()?;
        if *due_secs > now_secs + 1e-9 {
            return None;
        }
        self.on_the_way.pop_front().map(|(_, arrived)| arrived)
    }
}

/// The name of the stream of a sensor's errors.
fn errors_of(name: &str) -> String {
    format!("sensor.{name}.errors")
}

fn is_on(fault: &DrawnFault, now_secs: f64) -> bool {
    (fault.from_secs..fault.until_secs).contains(&now_secs)
}

/// The joints of a robot by name, in the given order.
pub(super) fn joints_of(robot: &BuiltRobot, names: &[String]) -> Vec<usize> {
    names
        .iter()
        .filter_map(|name| robot.added.joints.get(name).copied())
        .collect()
}
