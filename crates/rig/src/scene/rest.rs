//! A scene as the simulated rest of a robot: sensors that come from outside,
//! and the episode at the pace of the clock.
//!
//! A sensor is outside if one of the topics that its signals come from is said
//! to be. It then measures, at its own rate, what the monitors see of these
//! signals (unit, frame, staleness and all), without the errors and faults that
//! the scene gives it; while that is not known, it measures nothing.

use crate::rest::{Link, Pace, Rest};
use diagnostic::Problem;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use stimulus::Stimulus;
use testbench::scene::{SceneBench, SceneData, Sensor};
use testbench::{Cancel, Savable, SimError, Status, Unwatched};
use trace::{SignalIndex, SignalValues, Trace};

/// A scene without what comes from outside.
pub struct SceneRest {
    bench: Arc<SceneBench>,
    stimulus: Stimulus,
    inputs: Vec<SensorInput>,
    measurements: SharedMeasurements,
}

impl SceneRest {
    /// The scene in which sensors are outside of which a signal is.
    pub fn new(
        bench: Arc<SceneBench>,
        stimulus: Stimulus,
        is_outside: &dyn Fn(&[String]) -> bool,
    ) -> Self {
        let inputs = SensorInput::from_outside(bench.data(), is_outside);
        Self {
            bench,
            stimulus,
            measurements: SharedMeasurements::new(&inputs),
            inputs,
        }
    }
}

impl Rest for SceneRest {
    fn signals(&self) -> Vec<String> {
        self.inputs.iter().flat_map(SensorInput::signals).collect()
    }

    fn link(&self, layout: &Trace) -> Result<Box<dyn Link>, Problem> {
        let link = SensorLink::new(&self.inputs, layout, self.measurements.clone())?;
        Ok(Box::new(link))
    }

    fn period_secs(&self) -> f64 {
        let data = self.bench.data();
        let periods = data.controllers.iter().map(|it| it.period_secs);
        let shortest = periods.fold(f64::INFINITY, f64::min);
        match shortest.is_finite() {
            true => shortest,
            false => 1.0 / data.simulation.record_hz,
        }
    }

    fn run(&self, seed: u64, pace: &mut dyn Pace) -> Result<(Trace, f64), SimError> {
        let (bench, period_secs) = (&self.bench, self.period_secs());
        let mut running = bench.start(&self.stimulus, seed)?;
        pace.start();
        let mut steps: u64 = 0;
        loop {
            for (sensor, values) in self.measurements.now() {
                running.measure_outside(&sensor, values)?;
            }
            let now_secs = bench.now_secs(&running);
            if pace.step(now_secs, bench.so_far(&running)).is_break() {
                return Err(SimError::Cancelled);
            }
            steps += 1;
            let until_secs = steps as f64 * period_secs;
            let status =
                bench.advance(&mut running, until_secs, &mut Unwatched, &Cancel::default())?;
            if status != Status::Running {
                let recorded = bench.finish(running)?;
                return Ok((recorded.trace, recorded.sim_secs));
            }
        }
    }
}

/// The numbers of a sensor, a list for each field; `None` while not known.
type Measured = Option<Vec<Vec<f64>>>;

/// A sensor that is outside.
#[derive(Clone, Debug, PartialEq, Eq)]
struct SensorInput {
    /// Its name in the scene.
    name: String,
    /// Of each field the signals of its numbers.
    fields: Vec<Vec<String>>,
}

impl SensorInput {
    /// The sensors of which a signal comes from outside.
    fn from_outside(scene: &SceneData, is_outside: &dyn Fn(&[String]) -> bool) -> Vec<Self> {
        let all = scene.sensors.iter().map(Self::new);
        all.filter(|input| is_outside(&input.signals())).collect()
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
    fn signals(&self) -> Vec<String> {
        self.fields.concat()
    }
}

/// What sensors outside measure, as the judge writes and the episode reads it.
#[derive(Clone, Debug, Default)]
struct SharedMeasurements(Arc<Mutex<BTreeMap<String, Measured>>>);

impl SharedMeasurements {
    /// Measurements that are not known yet.
    fn new(inputs: &[SensorInput]) -> Self {
        let unknown = inputs.iter().map(|input| (input.name.clone(), None));
        Self(Arc::new(Mutex::new(unknown.collect())))
    }

    /// The measurements now.
    fn now(&self) -> BTreeMap<String, Measured> {
        self.locked().clone()
    }

    // A panic elsewhere leaves plain numbers, not broken memory.
    fn locked(&self) -> MutexGuard<'_, BTreeMap<String, Measured>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Passes the values of signals on to the sensors of an episode.
#[derive(Debug)]
struct SensorLink {
    inputs: Vec<(String, Vec<Vec<SignalIndex>>)>,
    measurements: SharedMeasurements,
}

impl SensorLink {
    /// Finds the signals of `inputs` among those of `layout`.
    fn new(
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
}

impl Link for SensorLink {
    /// A sensor of which any number is not known is not known.
    fn pass(&self, values: &dyn SignalValues) {
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
