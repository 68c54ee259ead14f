//! What a scene writes down: its topics, and rows in them.

use trace::{Field, Trace, TraceError};

use super::data::{
    Activity, ActuatorKind, GripperKind, JointGroup, Person, Robot, SceneData, Sensor, SensorKind,
};
use super::gripping::names_of;
use super::truth::Block;
use crate::bench::{Control, Watch};
use crate::controller::Description;

/// The places of topics in the trace.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topics {
    pub(super) robots: Vec<usize>,
    pub(super) people: Vec<usize>,
    pub(super) sensors: Vec<usize>,
    pub(super) actuators: Vec<usize>,
    pub(super) controllers: Vec<usize>,
    pub(super) test: usize,
    /// Of what actuators are at that are groups or grippers.
    pub(super) arms: Vec<Option<usize>>,
    /// Of declared truth, by block: its own topic; `None` where its fields are in one that is always there.
    pub(super) declared: Vec<Option<usize>>,
}

/// A trace that is being written.
#[derive(Debug, Clone)]
pub(super) struct Recorder {
    pub(super) trace: Trace,
    pub(super) topics: Topics,
    /// Whether who watches has seen enough.
    pub(super) is_enough: bool,
}

impl Recorder {
    /// An empty recording of a scene with these controllers, and with the truth that is declared. What always is recorded
    /// keeps its place, whatever is declared.
    pub(super) fn new(
        data: &SceneData,
        controllers: &[Description],
        declared: &[Block],
    ) -> Result<Self, TraceError> {
        let mut trace = Trace::new();
        trace.complete = false;
        let mut topics = Topics {
            robots: Vec::new(),
            people: Vec::new(),
            sensors: Vec::new(),
            actuators: Vec::new(),
            controllers: Vec::new(),
            test: 0,
            arms: Vec::new(),
            declared: Vec::new(),
        };
        for robot in &data.robots {
            let topic = format!("/truth/{}", robot.name);
            let mut fields = robot_fields(robot);
            fields.extend(more(declared, &topic));
            let topic = trace.add_channel(topic, fields)?;
            topics.robots.push(topic);
        }
        for person in &data.people {
            let topic = format!("/truth/{}", person.name);
            let mut fields = person_fields(person);
            fields.extend(more(declared, &topic));
            let topic = trace.add_channel(topic, fields)?;
            topics.people.push(topic);
        }
        for sensor in &data.sensors {
            let fields = sensor_fields(sensor);
            let topic = trace.add_channel(format!("/sensor/{}", sensor.name), fields)?;
            topics.sensors.push(topic);
        }
        for actuator in &data.actuators {
            let fields = super::actuating::fields_of(&actuator.kind);
            let fields = fields.into_iter().map(|f| Field::number(f.name, f.unit));
            let fields = fields.chain([Field::bool("faulty")]).collect();
            let topic = trace.add_channel(format!("/command/{}", actuator.name), fields)?;
            topics.actuators.push(topic);
        }
        for (controller, description) in data.controllers.iter().zip(controllers) {
            let fields = controller_fields(description);
            let topic = trace.add_channel(format!("/controller/{}", controller.name), fields)?;
            topics.controllers.push(topic);
        }
        for actuator in &data.actuators {
            topics.arms.push(match &actuator.kind {
                ActuatorKind::JointGroup(group) => {
                    let topic = format!("/group/{}", actuator.name);
                    Some(trace.add_channel(topic, group_fields(group))?)
                }
                ActuatorKind::Gripper(gripper) => {
                    let topic = format!("/gripper/{}", actuator.name);
                    let names = names_of(gripper, data);
                    Some(trace.add_channel(topic, gripper_fields(&gripper.kind, names))?)
                }
                _ => None,
            });
        }
        let test = vec![Field::number("actions_done", "1"), Field::bool("done")];
        topics.test = trace.add_channel("/test", test)?;
        for block in declared {
            let is_there = trace.channel(&block.topic).is_some();
            topics.declared.push(match is_there {
                true => None,
                false => Some(trace.add_channel(&*block.topic, block.fields.clone())?),
            });
        }
        Ok(Self {
            trace,
            topics,
            is_enough: false,
        })
    }

    /// A fact about the recording.
    pub(super) fn note(&mut self, key: &str, value: impl ToString) {
        self.trace
            .metadata
            .insert(key.to_owned(), value.to_string());
    }

    /// Writes a row.
    pub(super) fn row(
        &mut self,
        topic: usize,
        now_secs: f64,
        row: &[f64],
        watch: &mut dyn Watch,
    ) -> Result<(), TraceError> {
        self.trace.channels[topic].push(now_secs, row)?;
        if watch.row(topic, now_secs, row) == Control::Finish {
            self.is_enough = true;
        }
        Ok(())
    }
}

/// What is declared of a topic that is always there.
fn more(declared: &[Block], topic: &str) -> Vec<Field> {
    let blocks = declared.iter().filter(|block| block.topic == topic);
    blocks.flat_map(|block| block.fields.clone()).collect()
}

fn world(name: &str, unit: &str) -> Field {
    Field::number(name, unit).in_frame("world")
}

fn robot_fields(robot: &Robot) -> Vec<Field> {
    let mut fields = vec![
        world("x", "m"),
        world("y", "m"),
        world("z", "m"),
        world("yaw", "rad"),
        world("speed", "m/s"),
        world("turn_rate", "rad/s"),
        Field::number("person_distance", "m"),
        Field::number("person_force", "N"),
        Field::number("other_force", "N"),
    ];
    for joint in &robot.recorded_joints {
        let (position, velocity) = match robot.sliding_joints.contains(joint) {
            true => ("m", "m/s"),
            false => ("rad", "rad/s"),
        };
        fields.push(Field::number(format!("{joint}.position"), position));
        fields.push(Field::number(format!("{joint}.velocity"), velocity));
    }
    fields
}

fn person_fields(person: &Person) -> Vec<Field> {
    let mut fields = vec![
        world("x", "m"),
        world("y", "m"),
        world("heading", "rad"),
        world("speed", "m/s"),
        Field::number("robot_distance", "m"),
        Field::enumeration("activity", Activity::NAMES.map(|(_, name)| name)),
        Field::bool("reacting"),
        Field::bool("distracted"),
        Field::bool("arrived"),
    ];
    if person.body.has_arms() {
        for side in ["left_hand", "right_hand"] {
            fields.extend(["x", "y", "z"].map(|axis| world(&format!("{side}.{axis}"), "m")));
        }
    }
    if person.takes.is_some() {
        fields.push(Field::bool("holding"));
    }
    fields
}

/// A list of more than three numbers is recorded as its smallest number, where that stands, and how
/// many there are, unless all are wanted.
pub(super) fn is_summed_up(sensor: &Sensor, length: usize) -> bool {
    let is_image = matches!(
        sensor.kind,
        SensorKind::Lidar { .. } | SensorKind::DepthCamera { .. }
    );
    is_image && length > 1 && !sensor.record_all
}

/// Fields of sensors that are truth values.
const BOOLS: [&str; 5] = ["seen", "touching", "moving", "holding", "attached"];

fn sensor_fields(sensor: &Sensor) -> Vec<Field> {
    let mut fields = vec![Field::number("measured_at", "s"), Field::bool("faulty")];
    for field in sensor.fields() {
        let (name, unit) = (&field.name, &field.unit);
        if is_summed_up(sensor, field.length) {
            fields.push(Field::number(format!("{name}.nearest"), unit));
            fields.push(Field::number(format!("{name}.nearest_index"), "1"));
            fields.push(Field::number(format!("{name}.count"), "1"));
        } else if field.length == 1 && BOOLS.contains(&name.as_str()) {
            fields.push(Field::bool(name));
        } else if field.length == 1 {
            fields.push(Field::number(name, unit));
        } else {
            let each = (0..field.length).map(|i| Field::number(format!("{name}.{i}"), unit));
            fields.extend(each);
        }
    }
    fields
}

/// A measurement as a row of its topic.
pub(super) fn sensor_row(
    sensor: &Sensor,
    measured_secs: f64,
    is_faulty: bool,
    values: &[Vec<f64>],
) -> Vec<f64> {
    let mut row = vec![measured_secs, f64::from(u8::from(is_faulty))];
    for numbers in values {
        if is_summed_up(sensor, numbers.len()) {
            let met = numbers.iter().enumerate().filter(|(_, n)| !n.is_nan());
            let nearest = met.clone().min_by(|a, b| a.1.total_cmp(b.1));
            row.push(nearest.map_or(f64::NAN, |(_, number)| *number));
            row.push(nearest.map_or(f64::NAN, |(index, _)| index as f64));
            row.push(met.count() as f64);
        } else {
            row.extend(numbers);
        }
    }
    row
}

/// What a group is at: each joint, whether it is on its way, and by how much its last goal was out of reach.
fn group_fields(group: &JointGroup) -> Vec<Field> {
    let mut fields = Vec::new();
    for (joint, is_slide) in group.group.joints.iter().zip(&group.is_slide) {
        let [position, velocity] = if *is_slide {
            ["m", "m/s"]
        } else {
            ["rad", "rad/s"]
        };
        fields.push(Field::number(format!("{joint}.position"), position));
        fields.push(Field::number(format!("{joint}.velocity"), velocity));
        fields.push(Field::number(format!("{joint}.reference"), position));
    }
    fields.push(Field::bool("moving"));
    fields.push(Field::number("distance_left", "m"));
    fields.push(Field::number("angle_left", "rad"));
    fields.push(Field::bool("failed"));
    fields
}

/// What a gripper is at: what it holds, whether that is attached, and with which force.
fn gripper_fields(kind: &GripperKind, names: Vec<String>) -> Vec<Field> {
    let mut fields = vec![
        Field::enumeration("holding", names),
        Field::bool("attached"),
        Field::number("force", "N"),
    ];
    if matches!(kind, GripperKind::Parallel { .. }) {
        fields.push(Field::number("width", "m"));
    }
    fields
}

fn controller_fields(description: &Description) -> Vec<Field> {
    let mut fields = vec![Field::bool("finished")];
    let said = description.sends.iter();
    fields.extend(said.map(|message| Field::bool(format!("said.{message}"))));
    fields.extend(description.reports.iter().cloned());
    fields
}
