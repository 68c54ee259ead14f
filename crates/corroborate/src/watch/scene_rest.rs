//! A scene as the simulated rest of a robot: sensors that come from outside,
//! and the episode at the pace of the clock.
//!
//! A sensor is outside if one of the topics that its signals come from is said
//! to be. It then measures, at its own rate, what the monitors see of these
//! signals (unit, frame, staleness and all), without the errors and faults that
//! the scene gives it; while that is not known, it measures nothing.

use super::connection::topics_for;
use diagnostic::Problem;
use recording::TopicMap;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use testbench::scene::{SceneData, Sensor};
use trace::{SignalIndex, SignalValues, Trace};

/// The numbers of a sensor, a list for each field; `None` while not known.
type Measured = Option<Vec<Vec<f64>>>;

/// A sensor that is outside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SensorInput {
    /// Its name in the scene.
    pub name: String,
    /// Of each field the signals of its numbers.
    fields: Vec<Vec<String>>,
}

impl SensorInput {
    /// The sensors that topics named in `outside` give.
    pub fn from_outside(outside: &[String], map: &TopicMap, scene: &SceneData) -> Vec<Self> {
        let all = scene.sensors.iter().map(Self::new);
        all.filter(|input| {
            let topics = topics_for(map, &input.signals());
            outside.iter().any(|topic| topics.contains(topic))
        })
        .collect()
    }

    fn new(sensor: &Sensor) -> Self {
        let signals = |field: testbench::controller::PortField| -> Vec<String> {
            let name = format!("/sensor/{}.{}", sensor.name, field.name);
            match field.length {
                1 => vec![name],
                length => (0..length).map(|place| format!("{name}.{place}")).collect(),
            }
        };
        Self {
            name: sensor.name.clone(),
            fields: sensor.fields().into_iter().map(signals).collect(),
        }
    }

    /// The signals that it is read from.
    pub fn signals(&self) -> Vec<String> {
        self.fields.concat()
    }
}

/// What sensors outside measure, as the judge writes and the episode reads it.
#[derive(Clone, Debug, Default)]
pub struct SharedMeasurements(Arc<Mutex<BTreeMap<String, Measured>>>);

impl SharedMeasurements {
    /// Measurements that are not known yet.
    pub fn new(inputs: &[SensorInput]) -> Self {
        let unknown = inputs.iter().map(|input| (input.name.clone(), None));
        Self(Arc::new(Mutex::new(unknown.collect())))
    }

    /// The measurements now.
    pub fn now(&self) -> BTreeMap<String, Measured> {
        self.locked().clone()
    }

    // A panic elsewhere leaves plain numbers, not broken memory.
    fn locked(&self) -> MutexGuard<'_, BTreeMap<String, Measured>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Passes the values of signals on to the sensors of an episode.
#[derive(Debug)]
pub struct SensorLink {
    inputs: Vec<(String, Vec<Vec<SignalIndex>>)>,
    measurements: SharedMeasurements,
}

impl SensorLink {
    /// Finds the signals of `inputs` among those of `layout`.
    pub fn new(
        inputs: &[SensorInput],
        layout: &Trace,
        measurements: SharedMeasurements,
    ) -> Result<Self, Problem> {
        let find = |name: &String| {
            layout.signal(name).ok_or_else(|| {
                Problem::new(
                    "unfit-input",
                    format!("the simulated robot cannot read {name}: it is not among the signals"),
                )
                .remedy("say in the topic map (topics.toml, or --map) where it is, in its unit")
            })
        };
        let mut found = Vec::new();
        for input in inputs {
            let fields = input.fields.iter();
            let fields = fields.map(|numbers| numbers.iter().map(find).collect());
            found.push((input.name.clone(), fields.collect::<Result<_, _>>()?));
        }
        Ok(Self {
            inputs: found,
            measurements,
        })
    }

    /// Passes on what the signals are at this instant. A sensor of which any
    /// number is not known is not known.
    pub fn pass(&self, values: &impl SignalValues) {
        let mut measurements = self.measurements.locked();
        for (name, fields) in &self.inputs {
            let list = |numbers: &Vec<SignalIndex>| {
                let known = numbers.iter().map(|index| values.value(*index));
                known.collect::<Option<Vec<f64>>>()
            };
            let known: Measured = fields.iter().map(list).collect();
            measurements.insert(name.clone(), known);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trace::{Field, Snapshot};

    #[test]
    fn a_sensor_is_known_once_all_of_it_is() {
        let input = SensorInput {
            name: "wheels".into(),
            fields: vec![
                vec!["/sensor/wheels.x".into()],
                vec!["/sensor/wheels.v.0".into(), "/sensor/wheels.v.1".into()],
            ],
        };
        let mut layout = Trace::new();
        let fields = ["x", "v.0", "v.1"].map(|name| Field::number(name, "m"));
        layout
            .add_channel("/sensor/wheels", fields.into())
            .expect("a channel");
        let inputs = [input];
        let shared = SharedMeasurements::new(&inputs);
        assert_eq!(shared.now()["wheels"], None);
        let link = SensorLink::new(&inputs, &layout, shared.clone()).expect("linked");
        let mut snapshot = Snapshot::new(&layout);
        snapshot
            .update(0, 1.0, &[1.0, 2.0, f64::NAN])
            .expect("taken");
        link.pass(&snapshot);
        assert_eq!(shared.now()["wheels"], None);
        snapshot.update(0, 2.0, &[1.0, 2.0, 3.0]).expect("taken");
        link.pass(&snapshot);
        assert_eq!(
            shared.now()["wheels"],
            Some(vec![vec![1.0], vec![2.0, 3.0]])
        );
        let other = Trace::new();
        let error = SensorLink::new(&inputs, &other, shared).expect_err("not there");
        assert!(error.to_string().contains("/sensor/wheels.x"));
    }
}
