//! The physical model: MJCF text for MuJoCo, written from a scenario and the draws of an episode.
//!
//! What touches what is set by bit masks: the hand touches the object, the object stands on the
//! pedestal and may fall on the floor; nothing else collides. All shapes are pairs that MuJoCo
//! treats in closed form (capsule, sphere, box, plane, upright cylinder): the object is a capsule
//! to the fingers, and to the pedestal a ring of four small feet with a ball at either end, for
//! when it lies. Masses and inertias are given explicitly, so shapes weigh nothing.

mod layout;
mod part;
#[cfg(test)]
mod tests;

use std::fmt::Write;

use testbench::geometry::{
    IDENTITY, Pose, Quaternion, Vector, about, compose, from_roll_pitch_yaw,
};

use crate::scenario::{Body, Drive, InertiaSource, Joint, Object, Parameters, Scenario, Shape};

pub(crate) use layout::{carried, layout};
pub(crate) use part::{Contacts, Part, hand_is_separable};

/// Masks of who touches whom, as MJCF's `contype` and `conaffinity`.
const HAND_MASK: &str = r#"contype="1" conaffinity="2""#;
const OBJECT_GRIP_MASK: &str = r#"contype="2" conaffinity="1""#;
const OBJECT_REST_MASK: &str = r#"contype="4" conaffinity="8""#;
const SUPPORT_MASK: &str = r#"contype="8" conaffinity="4""#;
const NO_CONTACT: &str = r#"contype="0" conaffinity="0""#;

/// Radius of the feet on which the object stands, and how far its ends hang above them.
const FOOT_RADIUS_M: f64 = 0.003;
const END_CLEARANCE_M: f64 = 0.002;

/// Names in the model that the world looks up.
pub(crate) const OBJECT_BODY: &str = "object";
/// The object's shape that fingers touch.
pub(crate) const OBJECT_GEOM: &str = "object_grip";
/// Prefix of the shapes of the hand.
pub(crate) const CONTACT_GEOM_PREFIX: &str = "skin_";

/// What an episode draws for the physical model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PhysicalDraws {
    /// Mass of the object.
    pub object_mass_kg: f64,
    /// Coulomb friction between hand and object.
    pub friction: f64,
    /// Where the object first stands, its centre.
    pub object_pose: Pose,
}

/// What the model is written from.
struct Source<'a> {
    scenario: &'a Scenario,
    parameters: &'a Parameters,
    draws: &'a PhysicalDraws,
    part: &'a Part,
}

impl Source<'_> {
    /// The mask by which hand and object find each other; listed pairs need none.
    fn grip_mask(&self, mask: &'static str) -> &'static str {
        match self.part.contacts {
            Contacts::Listed => NO_CONTACT,
            Contacts::Found => mask,
        }
    }

    /// The mask by which the object finds what it stands on.
    fn rest_mask(&self, mask: &'static str) -> &'static str {
        match self.part.is_lean {
            true => NO_CONTACT,
            false => mask,
        }
    }
}

/// Writes the model.
#[must_use]
pub fn mjcf(scenario: &Scenario, parameters: &Parameters, draws: &PhysicalDraws) -> String {
    mjcf_of_part(scenario, parameters, draws, &Part::default())
}

/// Writes a part of the model. Names, masses, drives and solver are those of the whole.
pub(crate) fn mjcf_of_part(
    scenario: &Scenario,
    parameters: &Parameters,
    draws: &PhysicalDraws,
    part: &Part,
) -> String {
    let source = Source {
        scenario,
        parameters,
        draws,
        part,
    };
    let mut text = String::with_capacity(16 * 1024);
    header(&mut text, &source);
    text.push_str("<worldbody>\n");
    supports(&mut text, &source);
    let is_root = |body: &&Body| body.parent == "world";
    for body in scenario.bodies.iter().filter(is_root) {
        body_tree(&mut text, &source, body);
    }
    object(&mut text, &source);
    if !part.is_without_human {
        human(&mut text, scenario);
    }
    text.push_str("</worldbody>\n");
    actuators(&mut text, &source);
    if part.contacts == Contacts::Listed {
        pairs(&mut text, &source);
    }
    text.push_str("</mujoco>\n");
    text
}

/// Appends formatted text. Writing to a `String` cannot fail.
macro_rules! put {
    ($text:expr, $($argument:tt)*) => {{ let _ = writeln!($text, $($argument)*); }};
}

/// `1 2 3`.
fn list<const N: usize>(numbers: [f64; N]) -> String {
    numbers.map(|number| number.to_string()).join(" ")
}

fn header(text: &mut String, source: &Source<'_>) {
    let settings = &source.scenario.simulation;
    let gravity = if source.part.is_weightless(source.scenario) {
        0.0
    } else {
        -settings.gravity_m_s2
    };
    // A held object and the hand are one island: there is nothing to take apart.
    let islands = if source.part.is_lean {
        r#" island="disable""#
    } else {
        ""
    };
    put!(text, r#"<mujoco model="testbench">"#);
    put!(
        text,
        r#"<compiler angle="radian" autolimits="true" boundmass="0" balanceinertia="false"/>"#
    );
    put!(
        text,
        r#"<option timestep="{}" gravity="0 0 {}" integrator="implicitfast" cone="elliptic" impratio="{}" iterations="{}" tolerance="{}" noslip_iterations="{}"><flag sensor="disable" energy="disable"{islands}/></option>"#,
        settings.time_step_secs,
        gravity,
        settings.impedance_ratio,
        settings.solver_iterations,
        settings.solver_tolerance,
        settings.noslip_iterations
    );
}

/// Floor and pedestal.
fn supports(text: &mut String, source: &Source<'_>) {
    let scenario = source.scenario;
    let mask = source.rest_mask(SUPPORT_MASK);
    let friction = scenario.object.pedestal_friction;
    let pedestal = &scenario.pedestal;
    put!(
        text,
        r#"<geom name="floor" type="plane" size="5 5 0.1" friction="{friction} 0.005 0.0001" {mask}/>"#
    );
    put!(
        text,
        r#"<geom name="pedestal" type="cylinder" pos="{}" size="{} {}" friction="{friction} 0.005 0.0001" {mask}/>"#,
        list(pedestal.centre_m),
        pedestal.radius_m,
        pedestal.length_m / 2.0
    );
}

/// A link with everything that hangs on it.
fn body_tree(text: &mut String, source: &Source<'_>, body: &Body) {
    let Source {
        scenario,
        parameters,
        part,
        ..
    } = *source;
    let turned = compose(
        from_roll_pitch_yaw(body.rotation_rpy_rad),
        about(body.fixed_axis, body.fixed_angle_rad),
    );
    put!(
        text,
        r#"<body name="{}" pos="{}" quat="{}" gravcomp="{}">"#,
        body.name,
        list(body.position_m),
        list(turned),
        if part.is_weightless(scenario) {
            0.0
        } else {
            scenario.robot.gravity_compensation
        }
    );
    inertial(text, parameters, body);
    hinge(text, scenario, parameters, body);
    if let Some(shape) = &body.contact_shape {
        contact_geom(text, source, body, shape);
    }
    for child in scenario
        .bodies
        .iter()
        .filter(|child| child.parent == body.name)
    {
        body_tree(text, source, child);
    }
    put!(text, "</body>");
}

fn inertial(text: &mut String, parameters: &Parameters, body: &Body) {
    put!(
        text,
        r#"<inertial pos="{}" mass="{}" diaginertia="{}"/>"#,
        list(body.shape_position_m),
        body.mass_kg,
        list(link_inertia_kg_m2(parameters, body))
    );
}

/// A link's principal moments of inertia about its centre.
pub(crate) fn link_inertia_kg_m2(parameters: &Parameters, body: &Body) -> Vector {
    match parameters.inertia {
        InertiaSource::Geometry => body.shape.inertia_kg_m2(body.mass_kg),
        InertiaSource::Placeholder => body.placeholder_inertia_kg_m2,
    }
}

/// The object's principal moments of inertia about its centre.
pub(crate) fn object_inertia_kg_m2(
    scenario: &Scenario,
    parameters: &Parameters,
    mass_kg: f64,
) -> Vector {
    let object = &scenario.object;
    match parameters.inertia {
        InertiaSource::Geometry => {
            testbench::geometry::cylinder_inertia(mass_kg, object.length_m, object.radius_m)
        }
        InertiaSource::Placeholder => object.placeholder_inertia_kg_m2,
    }
}

fn hinge(text: &mut String, scenario: &Scenario, parameters: &Parameters, body: &Body) {
    let Some(joint) = &body.joint else { return };
    let (armature, friction_loss) = joint_loads(scenario, parameters, joint.drive);
    put!(
        text,
        r#"<joint name="{}" type="hinge" axis="{}" range="{}" armature="{armature}" frictionloss="{friction_loss}" solreflimit="{} 1"/>"#,
        body.name,
        list(joint.axis),
        list(joint.range_rad),
        parameters.hand.stop_time_constant_secs
    );
}

/// The inertia of a joint's drive as seen from the joint (kg m²), and its dry friction (N m).
fn joint_loads(scenario: &Scenario, parameters: &Parameters, drive: Drive) -> (f64, f64) {
    match drive {
        Drive::Arm => (scenario.robot.joint_armature_kg_m2, 0.0),
        Drive::Hand => (
            scenario.robot.finger_armature_kg_m2,
            parameters.hand.friction_loss_nm,
        ),
    }
}

/// Stiffness (N m/rad), damping (N m s/rad) and largest torque (N m) of a joint's servo.
fn drive_gains(parameters: &Parameters, joint: &Joint) -> [f64; 3] {
    let hand = &parameters.hand;
    match joint.drive {
        Drive::Arm => [
            joint.stiffness_nm_rad,
            joint.damping_nms_rad,
            joint.effort_limit_nm,
        ],
        Drive::Hand => [
            hand.stiffness_nm_rad,
            hand.damping_nms_rad,
            hand.torque_limit_nm,
        ],
    }
}

fn contact_geom(text: &mut String, source: &Source<'_>, body: &Body, shape: &Shape) {
    let hand = &source.parameters.hand;
    put!(
        text,
        r#"<geom name="{CONTACT_GEOM_PREFIX}{}" {} priority="1" condim="3" friction="{} 0.005 0.0001" solref="{} 1" mass="0" {}/>"#,
        body.name,
        geom_shape(shape, body.shape_position_m),
        source.draws.friction,
        hand.contact_time_constant_secs,
        source.grip_mask(HAND_MASK)
    );
}

/// The attributes that give a shape's form, size and place.
fn geom_shape(shape: &Shape, centre_m: Vector) -> String {
    let [x, y, z] = centre_m;
    match *shape {
        Shape::Box { box_m } => format!(
            r#"type="box" pos="{x} {y} {z}" size="{}""#,
            list(box_m.map(|edge| edge / 2.0))
        ),
        Shape::Cylinder {
            cylinder_length_m,
            cylinder_radius_m,
        } => format!(
            r#"type="cylinder" pos="{x} {y} {z}" size="{cylinder_radius_m} {}""#,
            cylinder_length_m / 2.0
        ),
        Shape::Sphere { sphere_radius_m } => {
            format!(r#"type="sphere" pos="{x} {y} {z}" size="{sphere_radius_m}""#)
        }
        Shape::Capsule {
            capsule_length_m,
            capsule_radius_m,
        } => {
            let half = capsule_length_m / 2.0 - capsule_radius_m;
            format!(
                r#"type="capsule" fromto="{x} {} {z} {x} {} {z}" size="{capsule_radius_m}""#,
                y - half,
                y + half
            )
        }
    }
}

fn object(text: &mut String, source: &Source<'_>) {
    let Source {
        scenario,
        parameters,
        draws,
        ..
    } = *source;
    let mass = draws.object_mass_kg;
    let moments = object_inertia_kg_m2(scenario, parameters, mass);
    put!(
        text,
        r#"<body name="{OBJECT_BODY}" pos="{}" quat="{}"><freejoint/>"#,
        list(draws.object_pose.position_m),
        list(draws.object_pose.orientation)
    );
    put!(
        text,
        r#"<inertial pos="0 0 0" mass="{mass}" diaginertia="{}"/>"#,
        list(moments)
    );
    object_shapes(text, source);
    put!(text, "</body>");
}

fn object_shapes(text: &mut String, source: &Source<'_>) {
    let object = &source.scenario.object;
    let (grip, rest) = (
        source.grip_mask(OBJECT_GRIP_MASK),
        source.rest_mask(OBJECT_REST_MASK),
    );
    let friction = object.pedestal_friction;
    let (end, rests) = object_rest_shapes(object);
    put!(
        text,
        r#"<geom name="{OBJECT_GEOM}" type="capsule" fromto="0 0 {} 0 0 {end}" size="{}" condim="3" mass="0" {grip}/>"#,
        -end,
        object.radius_m
    );
    for (name, [x, y, z], radius_m) in rests {
        put!(
            text,
            r#"<geom name="object_{name}" type="sphere" pos="{x} {y} {z}" size="{radius_m}" friction="{friction} 0.005 0.0001" mass="0" {rest}/>"#
        );
    }
}

/// How far along its axis, to either side, the object is a cylinder to the fingers; and the balls on which it rests: their names,
/// centres in its frame and radii. Two are its ends, for when it lies, four the feet on which it stands.
fn object_rest_shapes(object: &Object) -> (f64, [(&'static str, Vector, f64); 6]) {
    let half = object.length_m / 2.0;
    let end = half - object.radius_m - END_CLEARANCE_M;
    let ring = object.radius_m - FOOT_RADIUS_M;
    let foot = |name, x, y| (name, [x, y, FOOT_RADIUS_M - half], FOOT_RADIUS_M);
    let rests = [
        ("bottom", [0.0, 0.0, -end], object.radius_m),
        ("top", [0.0, 0.0, end], object.radius_m),
        foot("foot0", ring, 0.0),
        foot("foot1", 0.0, ring),
        foot("foot2", -ring, 0.0),
        foot("foot3", 0.0, -ring),
    ];
    (end, rests)
}

/// The human's head and hand: moved by the world, seen by viewers, touching nothing. The hand acts
/// on the object by its force.
fn human(text: &mut String, scenario: &Scenario) {
    let human = &scenario.human;
    put!(
        text,
        r#"<body name="human_head" mocap="true" pos="{}"><geom type="sphere" size="0.1" {NO_CONTACT}/></body>"#,
        list(human.head_position_m)
    );
    put!(
        text,
        r#"<body name="human_hand" mocap="true" pos="{}"><geom type="box" size="{}" {NO_CONTACT}/></body>"#,
        list(human.hand_rest_m),
        list(human.hand_box_m.map(|edge| edge / 2.0))
    );
}

/// The pairs of shapes that can touch, with the values that the engine would mix from theirs: hand and object, and in a lean
/// model the object and what it stands on.
fn pairs(text: &mut String, source: &Source<'_>) {
    let Source {
        scenario,
        parameters,
        draws,
        ..
    } = *source;
    put!(text, "<contact>");
    let skin = scenario
        .bodies
        .iter()
        .filter(|it| it.contact_shape.is_some());
    for body in skin {
        put!(
            text,
            r#"<pair geom1="{OBJECT_GEOM}" geom2="{CONTACT_GEOM_PREFIX}{}" condim="3" friction="{mu} {mu} 0.005 0.0001 0.0001" solref="{} 1"/>"#,
            body.name,
            parameters.hand.contact_time_constant_secs,
            mu = draws.friction
        );
    }
    let ends = ["bottom", "top", "foot0", "foot1", "foot2", "foot3"];
    let rest = source.part.is_lean;
    for (end, support) in ends
        .iter()
        .flat_map(|end| [(end, "floor"), (end, "pedestal")])
        .filter(|_| rest)
    {
        put!(
            text,
            r#"<pair geom1="object_{end}" geom2="{support}" condim="3" friction="{mu} {mu} 0.005 0.0001 0.0001"/>"#,
            mu = scenario.object.pedestal_friction
        );
    }
    put!(text, "</contact>");
}

/// One position servo for each joint, in the order of [`joint_order`].
fn actuators(text: &mut String, source: &Source<'_>) {
    put!(text, "<actuator>");
    for name in joint_order(source.scenario) {
        let body = source.scenario.bodies.iter().find(|body| body.name == name);
        let Some(joint) = body.and_then(|body| body.joint.as_ref()) else {
            continue;
        };
        let [stiffness, damping, limit] = drive_gains(source.parameters, joint);
        put!(
            text,
            r#"<position joint="{name}" kp="{stiffness}" kv="{damping}" forcerange="{} {limit}"/>"#,
            -limit
        );
    }
    put!(text, "</actuator>");
}

/// The joints in the order in which MuJoCo numbers them: depth first through the bodies. Joint `i`
/// has generalised position `i`; the object's free joint follows.
#[must_use]
pub fn joint_order(scenario: &Scenario) -> Vec<String> {
    fn visit(scenario: &Scenario, parent: &str, order: &mut Vec<String>) {
        for body in scenario.bodies.iter().filter(|body| body.parent == parent) {
            if body.joint.is_some() {
                order.push(body.name.clone());
            }
            visit(scenario, &body.name, order);
        }
    }
    let mut order = Vec::new();
    visit(scenario, "world", &mut order);
    order
}

/// The object's pose when it stands on the pedestal at `x`, `y`, turned by `yaw_rad`.
#[must_use]
pub fn standing_pose(scenario: &Scenario, x_m: f64, y_m: f64, yaw_rad: f64) -> Pose {
    let orientation: Quaternion = if yaw_rad == 0.0 {
        IDENTITY
    } else {
        about([0.0, 0.0, 1.0], yaw_rad)
    };
    let z_m = scenario.pedestal.top_m() + scenario.object.length_m / 2.0;
    Pose {
        position_m: [x_m, y_m, z_m],
        orientation,
    }
}
