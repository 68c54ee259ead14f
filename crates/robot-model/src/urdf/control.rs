//! `<transmission>` and `<ros2_control>`: through which quantity controllers command each joint.
//!
//! Both interfaces are at the joint, whatever the gear behind it, so a gear of 1 is right for commands; the reduction
//! only concerns the motor's side and is reported as a gap.

use crate::actuator::{Actuator, ActuatorKind};
use crate::diagnostics::{Effect, Place};
use crate::model::Model;
use crate::pose::Pose;
use crate::reader::Reader;
use crate::sensor::{Sensor, SensorKind};
use crate::xml::Element;

pub(super) fn read(reader: &mut Reader<'_, '_>, root: &Element, model: &mut Model) {
    for element in root.all("transmission") {
        transmission(reader, element, model);
    }
    for element in root.all("ros2_control") {
        ros2_control(reader, element, model);
    }
}

/// The kind for the last word of an interface's name.
fn kind_of(interface: &str) -> Option<ActuatorKind> {
    let word = interface.rsplit('/').next().unwrap_or(interface).trim();
    Some(match word {
        "effort" | "EffortJointInterface" => ActuatorKind::Effort,
        "position" | "PositionJointInterface" => ActuatorKind::Position { kp: None, kv: None },
        "velocity" | "VelocityJointInterface" => ActuatorKind::Velocity { kv: None },
        _ => return None,
    })
}

/// An actuator at a joint; its force is limited as the joint's.
fn actuator(model: &Model, joint: usize, interface: &str, kind: ActuatorKind) -> Actuator {
    let effort = model.joints[joint].effort_limit;
    let word = interface.rsplit('/').next().unwrap_or(interface).trim();
    let word = word.trim_end_matches("JointInterface").to_ascii_lowercase();
    Actuator {
        name: format!("{}/{word}", model.joints[joint].name),
        joint,
        kind,
        gear: 1.0,
        command_range: None,
        force_range: effort.filter(|most| *most > 0.0).map(|most| [-most, most]),
    }
}

/// Adds an actuator, unless one of that name came before (a description often says it in two ways).
fn push(model: &mut Model, new: Actuator) {
    if !model.actuators.iter().any(|known| known.name == new.name) {
        model.actuators.push(new);
    }
}

fn joint_called(
    reader: &mut Reader<'_, '_>,
    place: &Place,
    model: &Model,
    name: &str,
) -> Option<usize> {
    let one_freedom = |joint: &usize| model.joints[*joint].kind.position_size() == 1;
    let found = model.joint(name).filter(one_freedom);
    if found.is_none() {
        let what = format!("no joint {name} with one freedom exists to be driven");
        let consequence = "there is no such drive";
        reader.gap(place, "joint", what, Effect::Control, consequence);
    }
    found
}

fn transmission(reader: &mut Reader<'_, '_>, element: &Element, model: &mut Model) {
    for child in &element.children {
        match child.name.as_str() {
            "joint" => {
                let name = reader.required(child, "name").to_owned();
                let Some(joint) = joint_called(reader, &child.place, model, &name) else {
                    continue;
                };
                for interface in child.all("hardwareInterface") {
                    match kind_of(&interface.text) {
                        Some(kind) => push(model, actuator(model, joint, &interface.text, kind)),
                        None => reader.passed_over("joint", interface, Effect::Control),
                    }
                }
            }
            "actuator" => reduction(reader, child, "mechanicalReduction"),
            "type" | "plugin" => {}
            _ => reader.passed_over("transmission", child, Effect::Control),
        }
    }
}

fn reduction(reader: &mut Reader<'_, '_>, element: &Element, name: &str) {
    // Whatever stands there, it changes nothing at the joint; templates leave words.
    if let Some(child) = element.child(name)
        && child.text.trim().parse() != Ok(1.0)
    {
        let what = format!("the reduction {} is not modelled", child.text);
        let consequence = "commands and forces are those at the joint; the motor has no inertia";
        let path = format!("{}/{name}", element.name);
        reader.gap(&child.place, path, what, Effect::Control, consequence);
    }
}

fn ros2_control(reader: &mut Reader<'_, '_>, element: &Element, model: &mut Model) {
    for child in &element.children {
        match child.name.as_str() {
            "joint" => {
                let name = reader.required(child, "name").to_owned();
                if let Some(joint) = joint_called(reader, &child.place, model, &name) {
                    interfaces(reader, child, model, joint);
                }
            }
            "transmission" => {
                for joint in child.all("joint") {
                    reduction(reader, joint, "mechanical_reduction");
                }
            }
            _ => reader.passed_over("ros2_control", child, Effect::Control),
        }
    }
}

fn interfaces(reader: &mut Reader<'_, '_>, element: &Element, model: &mut Model, joint: usize) {
    for child in &element.children {
        let name = child.get("name").unwrap_or("").to_owned();
        match (child.name.as_str(), kind_of(&name)) {
            ("command_interface", Some(kind)) => {
                let command_range = parameters(reader, child);
                let made = actuator(model, joint, &name, kind);
                push(
                    model,
                    Actuator {
                        command_range,
                        ..made
                    },
                );
            }
            ("state_interface", Some(kind)) => {
                let measured = match kind {
                    ActuatorKind::Velocity { .. } => SensorKind::JointVelocity { joint },
                    ActuatorKind::Effort => SensorKind::JointEffort { joint },
                    _ => SensorKind::JointPosition { joint },
                };
                model.sensors.push(Sensor {
                    name: format!("{}/{name}_state", model.joints[joint].name),
                    kind: measured,
                    link: Some(model.joints[joint].link),
                    pose_in_link: Pose::IDENTITY,
                    rate_hz: None,
                    noise: vec![],
                });
            }
            _ => reader.passed_over("joint", child, Effect::Control),
        }
    }
}

/// `<param name="min">` and `<param name="max">` of a command.
fn parameters(reader: &mut Reader<'_, '_>, element: &Element) -> Option<[f64; 2]> {
    let mut ends = [None, None];
    for child in &element.children {
        match child.get("name") {
            Some("min") => ends[0] = reader.limit(&child.place, "param min", &child.text),
            Some("max") => ends[1] = reader.limit(&child.place, "param max", &child.text),
            _ => reader.passed_over("command_interface", child, Effect::Control),
        }
    }
    match ends {
        [Some(low), Some(high)] if low <= high => Some([low, high]),
        [None, None] => None,
        _ => {
            let remedy = "give both ends, the smaller as min";
            reader.warn(
                &element.place,
                "the range of a command is not complete",
                remedy,
            );
            None
        }
    }
}
