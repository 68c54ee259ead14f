//! `<joint>`: its freedoms, with axes in any frame.

use super::frames::Frames;
use super::include::below;
use super::scope::{FoundJoint, within};
use crate::diagnostics::Effect;
use crate::model::{Joint, JointKind};
use crate::pose::{Pose, conjugate, rotate};
use crate::reader::Reader;
use crate::xml::Element;

/// Freedoms from the parent outwards, and the slide for each radian of turn if a screw couples them (m/rad).
pub(super) struct Freedoms {
    pub joints: Vec<Joint>,
    pub screw_m_per_rad: Option<f64>,
}

/// The freedoms of a joint whose moved link stands at `link_in_world`. Names are as in the text.
pub(super) fn freedoms(
    reader: &mut Reader<'_, '_>,
    found: &FoundJoint<'_>,
    frames: &mut Frames,
    link_in_world: &Pose,
) -> Option<Freedoms> {
    let element = found.element;
    let kind = reader.required(element, "type");
    leftovers(reader, element);
    let joint_in_world = frames.in_world(reader, &found.name, &element.place);
    let anchor_m = link_in_world.inverse().apply(joint_in_world.position_m);
    let mut axis = |suffix: &str, child: &str, kind: JointKind| {
        let name = format!("{}{suffix}", found.name);
        let joint = Joint {
            anchor_m,
            ..Joint::new(name, 0, kind)
        };
        about_axis(reader, found, frames, link_in_world, child, joint)
    };
    let joints = match kind {
        "fixed" => vec![Joint::new(found.name.clone(), 0, JointKind::Fixed)],
        "ball" => vec![Joint {
            anchor_m,
            ..Joint::new(found.name.clone(), 0, JointKind::Ball)
        }],
        "revolute" | "continuous" => {
            let mut joint = axis("", "axis", JointKind::Revolute);
            if kind == "continuous" {
                joint.limits = None;
            }
            vec![joint]
        }
        "prismatic" => vec![axis("", "axis", JointKind::Prismatic)],
        "universal" | "revolute2" => {
            let first = axis("_1", "axis", JointKind::Revolute);
            let second = axis("_2", "axis2", JointKind::Revolute);
            split(reader, element, &found.name, "_1 and _2");
            vec![first, second]
        }
        "screw" => {
            let turn = axis("", "axis", JointKind::Revolute);
            let mut slide = axis("_slide", "axis", JointKind::Prismatic);
            slide.limits = None;
            split(reader, element, &found.name, "_slide, coupled to it");
            vec![turn, slide]
        }
        other => {
            let what = format!("joints of type {other} are not read");
            let consequence = "the links are not connected by it";
            reader.gap(&element.place, "joint", what, Effect::Motion, consequence);
            return None;
        }
    };
    let screw_m_per_rad = (kind == "screw").then(|| screw(reader, element));
    Some(Freedoms {
        joints,
        screw_m_per_rad,
    })
}

fn split(reader: &mut Reader<'_, '_>, element: &Element, name: &str, suffixes: &str) {
    let what = format!("the joint has two freedoms, called {name}{suffixes}");
    let consequence = "only names differ";
    reader.gap(&element.place, "joint", what, Effect::Nothing, consequence);
}

/// Metres for each radian: `screw_thread_pitch` is metres for each turn, the older `thread_pitch` is -2 pi by it.
fn screw(reader: &mut Reader<'_, '_>, element: &Element) -> f64 {
    let turn = 2.0 * std::f64::consts::PI;
    if let Some(pitch) = reader.child_number(element, "screw_thread_pitch") {
        return pitch / turn;
    }
    match reader.child_number(element, "thread_pitch") {
        Some(pitch) if pitch != 0.0 => -1.0 / pitch,
        Some(_) => 0.0,
        None => -1.0,
    }
}

fn leftovers(reader: &mut Reader<'_, '_>, element: &Element) {
    for child in &element.children {
        match child.name.as_str() {
            "parent" | "child" | "pose" | "axis" | "axis2" | "sensor" | "thread_pitch"
            | "screw_thread_pitch" => {}
            "plugin" => reader.passed_over("joint", child, Effect::Control),
            _ => reader.passed_over("joint", child, Effect::Motion),
        }
    }
}

/// Adds axis, limits and dynamics of `<axis>` or `<axis2>` to a joint.
fn about_axis(
    reader: &mut Reader<'_, '_>,
    found: &FoundJoint<'_>,
    frames: &mut Frames,
    link_in_world: &Pose,
    child: &str,
    mut joint: Joint,
) -> Joint {
    let given = found.element.child(child);
    let xyz = given.and_then(|axis| axis.child("xyz"));
    let (mut vector, mut frame) = ([0.0, 0.0, 1.0], found.name.clone());
    if let Some(xyz) = xyz {
        let numbers = reader.exactly::<3>(&xyz.place, "axis/xyz", &xyz.text);
        vector = reader.axis(&xyz.place, "axis/xyz", numbers.unwrap_or([0.0, 0.0, 1.0]));
        if let Some(named) = xyz.get("expressed_in").filter(|name| !name.is_empty()) {
            frame = within(&found.scope, named);
        }
    }
    let in_model = given
        .and_then(|axis| axis.child("use_parent_model_frame"))
        .map_or(below(&found.version, 5), |flag| {
            reader.truth(&flag.place, "use_parent_model_frame", &flag.text) == Some(true)
        });
    if in_model {
        frame.clone_from(&found.scope);
    }
    let place = xyz.map_or(&found.element.place, |xyz| &xyz.place);
    let turn = frames.in_world(reader, &frame, place).rotation;
    joint.axis = rotate(conjugate(link_in_world.rotation), rotate(turn, vector));
    if let Some(axis) = given {
        axis_details(reader, axis, &mut joint);
    }
    joint
}

fn axis_details(reader: &mut Reader<'_, '_>, axis: &Element, joint: &mut Joint) {
    for child in &axis.children {
        match child.name.as_str() {
            "xyz" | "use_parent_model_frame" | "mimic" => {}
            "limit" => limits(reader, child, joint),
            "dynamics" => dynamics(reader, child, joint),
            "initial_position" => reader.passed_over("axis", child, Effect::Motion),
            _ => reader.passed_over("axis", child, Effect::Motion),
        }
    }
}

fn limits(reader: &mut Reader<'_, '_>, element: &Element, joint: &mut Joint) {
    const FAR: f64 = 1e9;
    let mut ends = [None, None];
    for child in &element.children {
        let mut number = || reader.limit(&child.place, &child.name, &child.text);
        match child.name.as_str() {
            "lower" => ends[0] = number(),
            "upper" => ends[1] = number(),
            // A negative limit means none.
            "effort" => joint.effort_limit = number().filter(|most| *most >= 0.0),
            "velocity" => joint.velocity_limit = number().filter(|most| *most >= 0.0),
            _ => reader.passed_over("limit", child, Effect::Contact),
        }
    }
    joint.limits = match ends {
        [None, None] => None,
        [lower, upper] => Some([lower.unwrap_or(-FAR), upper.unwrap_or(FAR)]),
    };
    if joint.limits.is_some_and(|[lower, upper]| lower > upper) {
        let message = format!(
            "joint {} has its lower limit above its upper limit",
            joint.name
        );
        reader.problem(&element.place, message, "exchange the limits");
    }
}

fn dynamics(reader: &mut Reader<'_, '_>, element: &Element, joint: &mut Joint) {
    for child in &element.children {
        let mut number = || reader.child_number(element, &child.name).unwrap_or(0.0);
        match child.name.as_str() {
            "damping" => joint.damping = number(),
            "friction" => joint.friction = number(),
            "spring_stiffness" => joint.stiffness = number(),
            "spring_reference" => joint.spring_reference = number(),
            _ => reader.passed_over("dynamics", child, Effect::Motion),
        }
    }
    for (what, number) in [
        ("damping", joint.damping),
        ("friction", joint.friction),
        ("spring_stiffness", joint.stiffness),
    ] {
        if number < 0.0 {
            let message = format!("the {what} of joint {} is negative ({number})", joint.name);
            reader.problem(&element.place, message, "give 0 or more");
        }
    }
}
