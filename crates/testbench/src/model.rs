//! The physical model: MJCF text for MuJoCo, written from a scenario and the draws of an episode.
//!
//! What touches what is set by bit masks: the hand touches the object, the object stands on the
//! pedestal and may fall on the floor; nothing else collides. All shapes are pairs that MuJoCo
//! treats in closed form (capsule, sphere, box, plane, upright cylinder): the object is a capsule
//! to the fingers, and to the pedestal a ring of four small feet with a ball at either end, for
//! when it lies. Masses and inertias are given explicitly, so shapes weigh nothing.

use std::fmt::Write;

use crate::geometry::{IDENTITY, Pose, Quaternion, Vector, about, compose, from_roll_pitch_yaw};
use crate::scenario::{Body, Drive, InertiaSource, Parameters, Scenario, Shape};

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
/// Mocap bodies, in this order.
pub(crate) const HUMAN_HEAD: usize = 0;
/// See [`HUMAN_HEAD`].
pub(crate) const HUMAN_HAND: usize = 1;

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

/// Writes the model.
#[must_use]
pub fn mjcf(scenario: &Scenario, parameters: &Parameters, draws: &PhysicalDraws) -> String {
    let mut text = String::with_capacity(16 * 1024);
    header(&mut text, scenario);
    text.push_str("<worldbody>\n");
    supports(&mut text, scenario);
    let roots = scenario.bodies.iter().filter(|body| body.parent == "world");
    for body in roots {
        body_tree(&mut text, scenario, parameters, draws, body);
    }
    object(&mut text, scenario, parameters, draws);
    human(&mut text, scenario);
    text.push_str("</worldbody>\n");
    actuators(&mut text, scenario, parameters);
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

fn header(text: &mut String, scenario: &Scenario) {
    let settings = &scenario.simulation;
    put!(text, r#"<mujoco model="testbench">"#);
    put!(
        text,
        r#"<compiler angle="radian" autolimits="true" boundmass="0" balanceinertia="false"/>"#
    );
    put!(
        text,
        r#"<option timestep="{}" gravity="0 0 {}" integrator="implicitfast" cone="elliptic" impratio="{}" iterations="{}" tolerance="{}" noslip_iterations="{}"><flag sensor="disable" energy="disable"/></option>"#,
        settings.time_step_secs,
        -settings.gravity_m_s2,
        settings.impedance_ratio,
        settings.solver_iterations,
        settings.solver_tolerance,
        settings.noslip_iterations
    );
}

/// Floor and pedestal.
fn supports(text: &mut String, scenario: &Scenario) {
    let friction = scenario.object.pedestal_friction;
    let pedestal = &scenario.pedestal;
    put!(
        text,
        r#"<geom name="floor" type="plane" size="5 5 0.1" friction="{friction} 0.005 0.0001" {SUPPORT_MASK}/>"#
    );
    put!(
        text,
        r#"<geom name="pedestal" type="cylinder" pos="{}" size="{} {}" friction="{friction} 0.005 0.0001" {SUPPORT_MASK}/>"#,
        list(pedestal.centre_m),
        pedestal.radius_m,
        pedestal.length_m / 2.0
    );
}

/// A link with everything that hangs on it.
fn body_tree(
    text: &mut String,
    scenario: &Scenario,
    parameters: &Parameters,
    draws: &PhysicalDraws,
    body: &Body,
) {
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
        scenario.robot.gravity_compensation
    );
    inertial(text, parameters, body);
    joint(text, scenario, parameters, body);
    if let Some(shape) = &body.contact_shape {
        contact_geom(text, parameters, draws, body, shape);
    }
    for child in scenario
        .bodies
        .iter()
        .filter(|child| child.parent == body.name)
    {
        body_tree(text, scenario, parameters, draws, child);
    }
    put!(text, "</body>");
}

fn inertial(text: &mut String, parameters: &Parameters, body: &Body) {
    let moments = match parameters.inertia {
        InertiaSource::Geometry => body.shape.inertia_kg_m2(body.mass_kg),
        InertiaSource::Placeholder => body.placeholder_inertia_kg_m2,
    };
    put!(
        text,
        r#"<inertial pos="{}" mass="{}" diaginertia="{}"/>"#,
        list(body.shape_position_m),
        body.mass_kg,
        list(moments)
    );
}

fn joint(text: &mut String, scenario: &Scenario, parameters: &Parameters, body: &Body) {
    let Some(joint) = &body.joint else { return };
    let (armature, friction_loss) = match joint.drive {
        Drive::Arm => (scenario.robot.joint_armature_kg_m2, 0.0),
        Drive::Hand => (
            scenario.robot.finger_armature_kg_m2,
            parameters.hand.friction_loss_nm,
        ),
    };
    put!(
        text,
        r#"<joint name="{}" type="hinge" axis="{}" range="{}" armature="{armature}" frictionloss="{friction_loss}" solreflimit="{} 1"/>"#,
        body.name,
        list(joint.axis),
        list(joint.range_rad),
        parameters.hand.stop_time_constant_secs
    );
}

fn contact_geom(
    text: &mut String,
    parameters: &Parameters,
    draws: &PhysicalDraws,
    body: &Body,
    shape: &Shape,
) {
    let hand = &parameters.hand;
    put!(
        text,
        r#"<geom name="{CONTACT_GEOM_PREFIX}{}" {} priority="1" condim="3" friction="{} 0.005 0.0001" solref="{} 1" mass="0" {HAND_MASK}/>"#,
        body.name,
        geom_shape(shape, body.shape_position_m),
        draws.friction,
        hand.contact_time_constant_secs
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

fn object(text: &mut String, scenario: &Scenario, parameters: &Parameters, draws: &PhysicalDraws) {
    let object = &scenario.object;
    let mass = draws.object_mass_kg;
    let moments = match parameters.inertia {
        InertiaSource::Geometry => {
            crate::geometry::cylinder_inertia(mass, object.length_m, object.radius_m)
        }
        InertiaSource::Placeholder => object.placeholder_inertia_kg_m2,
    };
    let friction = object.pedestal_friction;
    let half = object.length_m / 2.0;
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
    let end = half - object.radius_m - END_CLEARANCE_M;
    put!(
        text,
        r#"<geom name="{OBJECT_GEOM}" type="capsule" fromto="0 0 {} 0 0 {end}" size="{}" condim="3" mass="0" {OBJECT_GRIP_MASK}/>"#,
        -end,
        object.radius_m
    );
    for (name, z) in [("bottom", -end), ("top", end)] {
        put!(
            text,
            r#"<geom name="object_{name}" type="sphere" pos="0 0 {z}" size="{}" friction="{friction} 0.005 0.0001" mass="0" {OBJECT_REST_MASK}/>"#,
            object.radius_m
        );
    }
    let ring = object.radius_m - FOOT_RADIUS_M;
    for (index, (x, y)) in [(ring, 0.0), (0.0, ring), (-ring, 0.0), (0.0, -ring)]
        .iter()
        .enumerate()
    {
        put!(
            text,
            r#"<geom name="object_foot{index}" type="sphere" pos="{x} {y} {}" size="{FOOT_RADIUS_M}" friction="{friction} 0.005 0.0001" mass="0" {OBJECT_REST_MASK}/>"#,
            FOOT_RADIUS_M - half
        );
    }
    put!(text, "</body>");
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

/// One position servo for each joint, in the order of [`joint_order`].
fn actuators(text: &mut String, scenario: &Scenario, parameters: &Parameters) {
    put!(text, "<actuator>");
    for name in joint_order(scenario) {
        let body = scenario.bodies.iter().find(|body| body.name == name);
        let Some(joint) = body.and_then(|body| body.joint.as_ref()) else {
            continue;
        };
        let hand = &parameters.hand;
        let (stiffness, damping, limit) = match joint.drive {
            Drive::Arm => (
                joint.stiffness_nm_rad,
                joint.damping_nms_rad,
                joint.effort_limit_nm,
            ),
            Drive::Hand => (
                hand.stiffness_nm_rad,
                hand.damping_nms_rad,
                hand.torque_limit_nm,
            ),
        };
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
