//! Writes an episode down as a trace: which topics, which fields, which units.

use testbench::{Control, Watch};
use trace::{Field, Trace, TraceError};

use super::human::Human;
use super::judge::Truth;
use super::tracking::Reading;
use crate::robot::{Controller, Decision, HandCommand, State};

/// Topics in the order of the trace.
const ROBOT: usize = 0;
const SENSORS: usize = 1;
const TRACKING: usize = 2;
const TRUTH: usize = 3;
const HUMAN: usize = 4;

/// Names of hand commands, in the order of the enumeration.
const HAND_COMMANDS: [(HandCommand, &str); 3] = [
    (HandCommand::Open, "open"),
    (HandCommand::Pregrasp, "pregrasp"),
    (HandCommand::Grasp, "grasp"),
];

/// A trace being written.
#[derive(Debug, Clone)]
pub(crate) struct Recorder {
    trace: Trace,
    finished: bool,
}

impl Recorder {
    /// An empty recording with all topics.
    pub(crate) fn new() -> Result<Self, TraceError> {
        let mut trace = Trace::new();
        trace.complete = false;
        trace.add_channel("/robot", robot_fields())?;
        trace.add_channel("/sensors", sensor_fields())?;
        trace.add_channel("/tracking", tracking_fields())?;
        trace.add_channel("/truth", truth_fields())?;
        trace.add_channel("/human", human_fields())?;
        Ok(Self {
            trace,
            finished: false,
        })
    }

    /// A fact about the recording.
    pub(crate) fn note(&mut self, key: &str, value: impl ToString) {
        self.trace
            .metadata
            .insert(key.to_owned(), value.to_string());
    }

    /// What was recorded so far.
    pub(crate) fn so_far(&self) -> &Trace {
        &self.trace
    }

    /// The recording; `complete` is false when the episode was cut short.
    pub(crate) fn finish(mut self, complete: bool) -> Trace {
        self.trace.complete = complete;
        self.trace
    }

    /// The robot's code and hand.
    pub(crate) fn robot(
        &mut self,
        now_secs: f64,
        controller: &Controller,
        truth: &Truth,
        watch: &mut dyn Watch,
    ) -> Result<(), TraceError> {
        let commands = controller.commands();
        let row = [
            index_of(&State::NAMES, controller.state()),
            index_of(&Decision::NAMES, controller.decision()),
            flag(controller.state() == State::Crashed),
            flag(controller.state().is_final()),
            flag(controller.is_planning()),
            index_of(&HAND_COMMANDS, commands.hand),
            flag(commands.restricted),
            flag(commands.announcing),
            truth.hand_m[0],
            truth.hand_m[1],
            truth.hand_m[2],
            truth.hand_speed_m_s,
        ];
        self.row(ROBOT, now_secs, &row, watch)
    }

    /// The robot's sensors, and the tracking reading they last judged by.
    pub(crate) fn sensors(
        &mut self,
        now_secs: f64,
        controller: &Controller,
        reading: Option<&Reading>,
        watch: &mut dyn Watch,
    ) -> Result<(), TraceError> {
        let report = controller.sensor_report().unwrap_or_default();
        let satisfied = |sensor: Option<bool>| flag(sensor == Some(true));
        let object_m = reading.map_or([f64::NAN; 3], |reading| reading.reported.object_m);
        let row = [
            flag(controller.state() == State::Sense),
            flag(controller.sensing_done()),
            satisfied(report.gaze),
            satisfied(report.pressure),
            satisfied(report.location),
            flag(report.all_satisfied()),
            controller.finger_displacement_counts() as f64,
            object_m[0],
            object_m[1],
            object_m[2],
        ];
        self.row(SENSORS, now_secs, &row, watch)
    }

    /// What tracking reports.
    pub(crate) fn tracking(
        &mut self,
        now_secs: f64,
        reading: &Reading,
        watch: &mut dyn Watch,
    ) -> Result<(), TraceError> {
        let reported = &reading.reported;
        let mut row = [0.0; 9];
        row[..3].copy_from_slice(&reported.object_m);
        row[3..6].copy_from_slice(&reported.human_hand_m);
        row[6..].copy_from_slice(&reported.human_head.position_m);
        self.row(TRACKING, now_secs, &row, watch)
    }

    /// What is true.
    pub(crate) fn truth(
        &mut self,
        now_secs: f64,
        truth: &Truth,
        glitch: bool,
        watch: &mut dyn Watch,
    ) -> Result<(), TraceError> {
        let object = &truth.object;
        let mut row = Vec::with_capacity(26);
        row.extend(object.pose.position_m);
        row.extend(object.pose.orientation);
        row.extend([
            testbench::geometry::norm(object.velocity_m_s),
            flag(truth.in_hand),
            flag(truth.grip.contacts > 0),
            truth.grip.contacts as f64,
            truth.grip.normal_newtons,
        ]);
        row.extend(truth.human_hand_m);
        row.extend(truth.human_head.position_m);
        row.extend([
            truth.human_distance_m,
            truth.pull_newtons,
            flag(truth.gaze),
            flag(truth.pressure),
            flag(truth.location),
            flag(truth.human_ready()),
            flag(truth.human_holds),
            flag(glitch),
        ]);
        self.row(TRUTH, now_secs, &row, watch)
    }

    /// What the human does and applies.
    pub(crate) fn human(
        &mut self,
        now_secs: f64,
        human: &Human,
        watch: &mut dyn Watch,
    ) -> Result<(), TraceError> {
        let [gaze, pressure, location] = human.applied();
        let row = [
            human.activated(),
            human.ready(),
            gaze,
            pressure,
            location,
            human.has_given_up(),
        ]
        .map(flag);
        self.row(HUMAN, now_secs, &row, watch)
    }

    /// Whether a watch has seen enough.
    pub(crate) fn is_finished(&self) -> bool {
        self.finished
    }

    /// Writes a row down and shows it.
    fn row(
        &mut self,
        topic: usize,
        now_secs: f64,
        row: &[f64],
        watch: &mut dyn Watch,
    ) -> Result<(), TraceError> {
        self.trace.channels[topic].push(now_secs, row)?;
        self.finished |= watch.row(topic, now_secs, row) == Control::Finish;
        Ok(())
    }
}

/// 1 for true.
fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}

/// The index of a value in its list of names.
fn index_of<T: PartialEq, const N: usize>(names: &[(T, &str); N], value: T) -> f64 {
    names
        .iter()
        .position(|(candidate, _)| *candidate == value)
        .unwrap_or(0) as f64
}

/// The field of an enumeration.
fn enumeration<T, const N: usize>(name: &str, names: &[(T, &'static str); N]) -> Field {
    Field::enumeration(name, names.iter().map(|(_, name)| *name))
}

/// Three coordinates in metres in the world frame: `name.x`, `name.y`, `name.z`.
fn point(name: &str) -> impl Iterator<Item = Field> {
    ["x", "y", "z"]
        .map(|axis| Field::number(format!("{name}.{axis}"), "m").in_frame("world"))
        .into_iter()
}

fn robot_fields() -> Vec<Field> {
    let mut fields = vec![
        enumeration("state", &State::NAMES),
        enumeration("decision", &Decision::NAMES),
        Field::bool("crashed"),
        Field::bool("ended"),
        Field::bool("planning"),
        enumeration("hand_command", &HAND_COMMANDS),
        Field::bool("restricted"),
        Field::bool("announcing"),
    ];
    fields.extend(point("hand"));
    fields.push(Field::number("hand_speed", "m/s").in_frame("world"));
    fields
}

fn sensor_fields() -> Vec<Field> {
    let mut fields = vec![
        Field::bool("sensing"),
        Field::bool("sensing_done"),
        Field::bool("gaze_ok"),
        Field::bool("pressure_ok"),
        Field::bool("location_ok"),
        Field::bool("all_ok"),
        Field::number("finger_displacement", "counts"),
    ];
    fields.extend(point("object"));
    fields
}

fn tracking_fields() -> Vec<Field> {
    point("object")
        .chain(point("human_hand"))
        .chain(point("human_head"))
        .collect()
}

fn truth_fields() -> Vec<Field> {
    let mut fields: Vec<Field> = point("object").collect();
    for part in ["w", "x", "y", "z"] {
        fields.push(Field::number(format!("object_attitude.{part}"), "1").in_frame("world"));
    }
    fields.extend([
        Field::number("object_speed", "m/s").in_frame("world"),
        Field::bool("in_hand"),
        Field::bool("object_contacts_hand"),
        Field::number("hand_contacts", "1"),
        Field::number("grip_force", "N"),
    ]);
    fields.extend(point("human_hand"));
    fields.extend(point("human_head"));
    fields.extend([
        Field::number("human_distance", "m"),
        Field::number("pull", "N").in_frame("world"),
        Field::bool("gaze"),
        Field::bool("pressure"),
        Field::bool("location"),
        Field::bool("human_ready"),
        Field::bool("human_holds"),
        Field::bool("tracking_glitch"),
    ]);
    fields
}

fn human_fields() -> Vec<Field> {
    [
        "activated",
        "ready",
        "gaze",
        "pressure",
        "location",
        "gave_up",
    ]
    .map(Field::bool)
    .into()
}
