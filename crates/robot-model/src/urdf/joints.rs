//! `<joint>` and `<mimic>`.

use super::origin;
use crate::actuator::Coupling;
use crate::diagnostics::{Effect, Place};
use crate::model::{Joint, JointKind, Model};
use crate::pose::{Pose, rotate, z_axis_to};
use crate::reader::Reader;
use crate::xml::Element;

/// A joint, before its place in the tree is known: the freedoms it stands for, from the parent outwards.
pub(super) struct RawJoint {
    pub name: String,
    pub parent: String,
    pub child: String,
    pub origin: Pose,
    pub joints: Vec<Joint>,
    pub mimic: Option<Element>,
    pub place: Place,
}

const CHILDREN: [&str; 8] = [
    "origin",
    "parent",
    "child",
    "axis",
    "limit",
    "dynamics",
    "mimic",
    "calibration",
];

pub(super) fn joint(reader: &mut Reader<'_, '_>, element: &Element) -> Option<RawJoint> {
    reader.known_attributes(element, &["name", "type"]);
    let name = reader.required(element, "name").to_owned();
    let kind = reader.required(element, "type").to_owned();
    let mut link_of = |end: &str| match element.child(end) {
        Some(child) => reader.required(child, "link").to_owned(),
        None => {
            let message = format!("joint {name} has no {end}");
            reader.problem(
                &element.place,
                message,
                format!("add <{end} link=\"...\"/>"),
            );
            String::new()
        }
    };
    let (parent, child) = (link_of("parent"), link_of("child"));
    for below in &element.children {
        match below.name.as_str() {
            "safety_controller" => reader.passed_over("joint", below, Effect::Control),
            "calibration" => reader.passed_over("joint", below, Effect::Nothing),
            known if CHILDREN.contains(&known) => {}
            _ => reader.passed_over("joint", below, Effect::Motion),
        }
    }
    let joints = freedoms(reader, element, &name, &kind)?;
    Some(RawJoint {
        parent,
        child,
        origin: origin(reader, element),
        joints,
        mimic: element.child("mimic").cloned(),
        place: element.place.clone(),
        name,
    })
}

/// The freedoms that a joint's type stands for.
fn freedoms(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    name: &str,
    kind: &str,
) -> Option<Vec<Joint>> {
    let axis = match element.child("axis") {
        Some(axis) if !matches!(kind, "fixed" | "floating") => {
            reader.known_attributes(axis, &["xyz"]);
            reader.required(axis, "xyz");
            let given = reader
                .attribute::<3>(axis, "xyz")
                .unwrap_or([1.0, 0.0, 0.0]);
            reader.axis(&axis.place, "axis@xyz", given)
        }
        _ => [1.0, 0.0, 0.0],
    };
    let with = |name: String, kind: JointKind| Joint {
        axis,
        ..Joint::new(name, 0, kind)
    };
    Some(match kind {
        "fixed" => vec![with(name.to_owned(), JointKind::Fixed)],
        "floating" => vec![with(name.to_owned(), JointKind::Free)],
        "revolute" | "continuous" => {
            let joint = with(name.to_owned(), JointKind::Revolute);
            vec![limited(reader, element, joint, kind == "revolute")]
        }
        "prismatic" => {
            let joint = with(name.to_owned(), JointKind::Prismatic);
            vec![limited(reader, element, joint, true)]
        }
        "planar" => planar(reader, element, name, axis),
        "spherical" => {
            let what = "the type spherical is not one of URDF's own";
            let consequence = "the joint is a ball joint without limits";
            reader.gap(
                &element.place,
                "joint@type",
                what,
                Effect::Nothing,
                consequence,
            );
            vec![with(name.to_owned(), JointKind::Ball)]
        }
        other => {
            let message = format!("joint {name} is of type {other}");
            let remedy = "use fixed, revolute, continuous, prismatic, planar or floating";
            reader.problem(&element.place, message, remedy);
            return None;
        }
    })
}

/// Two slides in the plane across the axis, and a turn about it.
fn planar(
    reader: &mut Reader<'_, '_>,
    element: &Element,
    name: &str,
    axis: [f64; 3],
) -> Vec<Joint> {
    let plane = z_axis_to(axis);
    let slide = |suffix: &str, along: [f64; 3]| Joint {
        axis: rotate(plane, along),
        ..Joint::new(format!("{name}_{suffix}"), 0, JointKind::Prismatic)
    };
    let turn = Joint {
        axis,
        ..Joint::new(format!("{name}_yaw"), 0, JointKind::Revolute)
    };
    let what = format!("the planar joint became {name}_x, {name}_y and {name}_yaw");
    let consequence = "its position is named by three joints; the motion is the same";
    reader.gap(&element.place, "joint", what, Effect::Nothing, consequence);
    vec![
        slide("x", [1.0, 0.0, 0.0]),
        slide("y", [0.0, 1.0, 0.0]),
        turn,
    ]
}

/// Adds limits and dynamics.
fn limited(reader: &mut Reader<'_, '_>, element: &Element, mut joint: Joint, ends: bool) -> Joint {
    if let Some(limit) = element.child("limit") {
        let known = [
            "lower",
            "upper",
            "effort",
            "velocity",
            "acceleration",
            "deceleration",
            "jerk",
        ];
        reader.known_attributes(limit, &known);
        joint.effort_limit = reader.limit_attribute(limit, "effort");
        joint.velocity_limit = reader.limit_attribute(limit, "velocity");
        if ends {
            let mut end = |name: &str| match limit.get(name) {
                Some(_) => reader.limit_attribute(limit, name),
                None => Some(0.0),
            };
            let (lower, upper) = (end("lower"), end("upper"));
            joint.limits = range(reader, &limit.place, &joint.name, lower, upper);
        }
    } else if ends {
        let message = format!("joint {} has no limit, which its type requires", joint.name);
        let remedy = "add <limit lower upper effort velocity>; it is taken as unlimited";
        reader.warn(&element.place, message, remedy);
    }
    if let Some(dynamics) = element.child("dynamics") {
        reader.known_attributes(dynamics, &["damping", "friction"]);
        joint.damping = not_negative(reader, dynamics, "damping");
        joint.friction = not_negative(reader, dynamics, "friction");
    }
    joint
}

/// A range of positions, if both ends are limited. A range open at one side is closed far away.
fn range(
    reader: &mut Reader<'_, '_>,
    place: &Place,
    name: &str,
    lower: Option<f64>,
    upper: Option<f64>,
) -> Option<[f64; 2]> {
    const FAR: f64 = 1e9;
    let (lower, upper) = match (lower, upper) {
        (None, None) => return None,
        (lower, upper) => (lower.unwrap_or(-FAR), upper.unwrap_or(FAR)),
    };
    if lower > upper {
        // Some programs write it so for a joint without limits; Bullet reads it so.
        let message =
            format!("joint {name} has a lower limit {lower} above its upper limit {upper}");
        reader.warn(
            place,
            message,
            "exchange the limits; it is taken as unlimited",
        );
        return None;
    }
    Some([lower, upper])
}

fn not_negative(reader: &mut Reader<'_, '_>, element: &Element, name: &str) -> f64 {
    let number = reader.number(element, name).unwrap_or(0.0);
    if number < 0.0 {
        let message = format!(
            "{}@{name} is negative ({number}) and would add energy",
            element.name
        );
        reader.problem(&element.place, message, "give 0 or more");
    }
    number
}

/// `<mimic joint multiplier offset>`: position = multiplier * leader + offset.
pub(super) fn couplings(reader: &mut Reader<'_, '_>, raw: &[RawJoint], model: &mut Model) {
    for joint in raw {
        let Some(mimic) = &joint.mimic else { continue };
        reader.known_attributes(mimic, &["joint", "multiplier", "offset"]);
        let leader = reader.required(mimic, "joint").to_owned();
        let multiplier = reader.number(mimic, "multiplier").unwrap_or(1.0);
        let offset = reader.number(mimic, "offset").unwrap_or(0.0);
        let follower = joint.joints.first().and_then(|own| model.joint(&own.name));
        let simple = |index: usize| model.joints[index].kind.position_size() == 1;
        let (Some(follower), [_]) = (follower.filter(|f| simple(*f)), &joint.joints[..]) else {
            reader.passed_over("joint", mimic, Effect::Nothing);
            continue;
        };
        let found = model.joint(&leader).filter(|found| *found != follower);
        let fixed = |index: &usize| model.joints[*index].kind == JointKind::Fixed;
        let leader = match found {
            // What does not move holds its follower at the offset.
            Some(found) if fixed(&found) => None,
            Some(found) if simple(found) => Some(found),
            _ => {
                let what = format!("no joint {leader} with one freedom exists to be followed");
                let consequence = format!("joint {} moves on its own", joint.name);
                let element = "joint/mimic";
                reader.gap(&mimic.place, element, what, Effect::Motion, consequence);
                continue;
            }
        };
        model.couplings.push(Coupling {
            joint: follower,
            leader,
            coefficients: [offset, multiplier, 0.0, 0.0, 0.0],
        });
    }
}
