//! What the handover's robot reads from outside, where it is the simulated rest of one: the way from the
//! judged signals to the episode under way.
//!
//! A reading is linked if one of the topics that its signals come from is said
//! to be outside. It then has the value that the monitors see, unit, frame,
//! staleness and all; while that is not known, the robot has no reading.

use crate::rest::Link;
use diagnostic::Problem;
use handover::{OutsideReadings, Reading};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use trace::{FieldKind, SignalIndex, SignalValues, Trace};

/// What an episode can take from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    Activated,
    Ready,
    Gaze,
    Pressure,
    Location,
    Object,
    HumanHand,
    HumanHead,
}

impl Input {
    /// All inputs with the signals by which they are known in a topic map;
    /// of points, each coordinate.
    const ALL: [(Self, &'static str); 8] = [
        (Self::Activated, "/human.activated"),
        (Self::Ready, "/human.ready"),
        (Self::Gaze, "/sensors.gaze_ok"),
        (Self::Pressure, "/sensors.pressure_ok"),
        (Self::Location, "/sensors.location_ok"),
        (Self::Object, "/tracking.object"),
        (Self::HumanHand, "/tracking.human_hand"),
        (Self::HumanHead, "/tracking.human_head"),
    ];

    /// The inputs of which a signal comes from outside.
    pub fn from_outside(is_outside: &dyn Fn(&[String]) -> bool) -> Vec<Self> {
        let all = Self::ALL.iter().map(|(input, _)| *input);
        all.filter(|input| is_outside(&input.signals())).collect()
    }

    fn name(self) -> &'static str {
        let mut all = Self::ALL.iter();
        all.find(|(input, _)| *input == self)
            .map_or("", |(_, name)| name)
    }

    fn is_point(self) -> bool {
        matches!(self, Self::Object | Self::HumanHand | Self::HumanHead)
    }

    /// The signals that it is read from.
    pub fn signals(self) -> Vec<String> {
        match self.is_point() {
            true => ["x", "y", "z"]
                .map(|axis| format!("{}.{axis}", self.name()))
                .into(),
            false => vec![self.name().to_owned()],
        }
    }

    /// Puts in the value that its signals have; `None` if it is not known.
    fn put(self, values: &[Option<f64>], readings: &mut OutsideReadings) {
        let truth = Reading::Outside(values.first().copied().flatten().map(|it| it != 0.0));
        let point = || match values {
            [Some(x), Some(y), Some(z)] => Reading::Outside(Some([*x, *y, *z])),
            _ => Reading::Outside(None),
        };
        match self {
            Self::Activated => readings.activated = truth,
            Self::Ready => readings.human_ready = truth,
            Self::Gaze => readings.sensors.gaze = truth,
            Self::Pressure => readings.sensors.pressure = truth,
            Self::Location => readings.sensors.location = truth,
            Self::Object => readings.object_m = point(),
            Self::HumanHand => readings.human_hand_m = point(),
            Self::HumanHead => readings.human_head_m = point(),
        }
    }
}

/// The readings as the judge writes and the episode reads them.
#[derive(Clone, Debug, Default)]
pub struct SharedReadings(Arc<Mutex<OutsideReadings>>);

impl SharedReadings {
    /// Readings of which `inputs` come from outside and are not known yet.
    pub fn new(inputs: &[Input]) -> Self {
        let shared = Self::default();
        for input in inputs {
            input.put(&[], &mut shared.locked());
        }
        shared
    }

    /// The readings now.
    pub fn now(&self) -> OutsideReadings {
        *self.locked()
    }

    // A panic elsewhere leaves plain numbers, not broken memory.
    fn locked(&self) -> MutexGuard<'_, OutsideReadings> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Passes the values of signals on to the episode.
#[derive(Debug)]
pub struct ReadingsLink {
    inputs: Vec<(Input, Vec<SignalIndex>)>,
    readings: SharedReadings,
}

impl ReadingsLink {
    /// Finds the signals of `inputs` among those of `layout`.
    pub fn new(
        inputs: &[Input],
        layout: &Trace,
        readings: SharedReadings,
    ) -> Result<Self, Problem> {
        let mut found = Vec::new();
        for input in inputs {
            let signals = input.signals();
            let indices = signals.iter().map(|name| usable(*input, name, layout));
            found.push((*input, indices.collect::<Result<_, _>>()?));
        }
        Ok(Self {
            inputs: found,
            readings,
        })
    }
}

impl Link for ReadingsLink {
    fn pass(&self, values: &dyn SignalValues) {
        let mut readings = self.readings.locked();
        for (input, signals) in &self.inputs {
            let known: Vec<_> = signals.iter().map(|it| values.value(*it)).collect();
            input.put(&known, &mut readings);
        }
    }
}

/// The signal `name`, if the robot can read it as it is mapped.
fn usable(input: Input, name: &str, layout: &Trace) -> Result<SignalIndex, Problem> {
    let unfit = |why: String| {
        Problem::new(
            "unfit-input",
            format!("the simulated robot cannot read {name}: {why}"),
        )
        .remedy("say in the topic map (topics.toml, or --map) where it is, in its unit and frame")
    };
    let index = layout
        .signal(name)
        .ok_or_else(|| unfit("it is not among the signals".into()))?;
    let field = &layout.channels[index.channel].fields[index.field];
    if !input.is_point() {
        return match field.kind {
            FieldKind::Bool => Ok(index),
            _ => Err(unfit("it has to be a truth value (kind = \"bool\")".into())),
        };
    }
    let frame = field.frame.as_deref().unwrap_or("world");
    match (field.unit.as_str(), frame) {
        ("m", "world") => Ok(index),
        (unit, frame) => Err(unfit(format!(
            "it is in `{unit}` and the frame `{frame}`, and has to be in m and world"
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trace::{Field, Snapshot};

    #[test]
    fn an_input_is_outside_if_one_of_its_signals_is() {
        let from = |topic: &str| {
            Input::from_outside(&|signals: &[String]| {
                signals.iter().any(|it| it.starts_with(topic))
            })
        };
        assert_eq!(from("/sensors.pressure_ok"), [Input::Pressure]);
        let all = [Input::Object, Input::HumanHand, Input::HumanHead];
        assert_eq!(from("/tracking"), all);
        assert_eq!(from("/tracking.object.y"), [Input::Object]);
        assert_eq!(from("/elsewhere"), []);
    }

    #[test]
    fn readings_are_unknown_until_they_are_passed_on_and_again_when_they_are_missing() {
        let mut layout = Trace::new();
        let point = ["x", "y", "z"].map(|axis| Field::number(format!("object.{axis}"), "m"));
        layout
            .add_channel("/tracking", point.into())
            .expect("a channel");
        let bools = vec![Field::bool("pressure_ok")];
        layout.add_channel("/sensors", bools).expect("a channel");
        let inputs = [Input::Pressure, Input::Object];
        let shared = SharedReadings::new(&inputs);
        let unknown = shared.now();
        assert_eq!(unknown.sensors.pressure, Reading::Outside(None));
        assert_eq!(unknown.object_m, Reading::Outside(None));
        assert_eq!(unknown.sensors.gaze, Reading::Simulated);
        let link = ReadingsLink::new(&inputs, &layout, shared.clone()).expect("linked");
        let mut snapshot = Snapshot::new(&layout);
        snapshot.update(0, 1.0, &[1.0, 2.0, 3.0]).expect("taken");
        snapshot.update(1, 1.0, &[1.0]).expect("taken");
        link.pass(&snapshot);
        let known = shared.now();
        assert_eq!(known.sensors.pressure, Reading::Outside(Some(true)));
        assert_eq!(known.object_m, Reading::Outside(Some([1.0, 2.0, 3.0])));
        snapshot
            .update(0, 2.0, &[1.0, f64::NAN, 3.0])
            .expect("taken");
        link.pass(&snapshot);
        assert_eq!(shared.now().object_m, Reading::Outside(None));
    }

    #[test]
    fn a_signal_in_another_unit_frame_or_kind_is_refused() {
        let refused = |fields: Vec<Field>, input: Input| {
            let mut layout = Trace::new();
            let topic = if input.is_point() {
                "/tracking"
            } else {
                "/sensors"
            };
            layout.add_channel(topic, fields).expect("a channel");
            let linked = ReadingsLink::new(&[input], &layout, SharedReadings::default());
            linked.expect_err("refused").to_string()
        };
        let points = |unit: &str, frame: &str| -> Vec<Field> {
            let field = |axis| Field::number(format!("object.{axis}"), unit).in_frame(frame);
            ["x", "y", "z"].map(field).into()
        };
        assert!(refused(points("mm", "world"), Input::Object).contains("`mm`"));
        assert!(refused(points("m", "base"), Input::Object).contains("`base`"));
        let number = vec![Field::number("gaze_ok", "1")];
        assert!(refused(number, Input::Gaze).contains("truth value"));
        let other = vec![Field::bool("sensing")];
        assert!(refused(other, Input::Gaze).contains("not among"));
    }
}
