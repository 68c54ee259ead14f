//! A layout as MJCF text for MuJoCo.
//!
//! Masses and inertias are given explicitly and shapes weigh nothing, so that what a form weighs
//! does not depend on the engine. Bodies that are fixed to the world become parts of it.

use std::fmt::Write;

use super::layout::{
    BodyPlan, Cone, DriveKind, Form, Inertia, JointKind, Layout, Motion, MujocoSolver, ShapePlan,
    Softness, Surface, Touches,
};
use crate::geometry::Pose;

/// Appends a formatted line. Writing to a `String` cannot fail.
macro_rules! put {
    ($text:expr, $($argument:tt)*) => {{ let _ = writeln!($text, $($argument)*); }};
}

/// Torsional and rolling friction in metres: MuJoCo's own, which count only where a surface gives one.
const OTHER_FRICTION_M: [f64; 2] = [0.005, 0.0001];

/// The layout as MJCF. Names are those of the layout, drives are in its order.
#[must_use]
pub fn mjcf_of(layout: &Layout) -> String {
    let mut text = String::with_capacity(16 * 1024);
    put!(text, r#"<mujoco model="scene">"#);
    put!(
        text,
        r#"<compiler angle="radian" autolimits="true" balanceinertia="false" fusestatic="false"/>"#
    );
    put!(
        text,
        r#"<option timestep="{}" gravity="0 0 {}" integrator="implicitfast" {}><flag energy="disable"/></option>"#,
        layout.time_step_secs,
        -layout.gravity_m_s2,
        solver(&layout.solver.mujoco)
    );
    hulls(&mut text, layout);
    put!(text, "<worldbody>");
    shapes_of(&mut text, layout, None);
    children_of(&mut text, layout, None);
    put!(text, "</worldbody>");
    drives(&mut text, layout);
    couplings(&mut text, layout);
    no_contact(&mut text, layout);
    wrenches(&mut text, layout);
    put!(text, "</mujoco>");
    text
}

/// The solver's settings as attributes; those that are not given are MuJoCo's own.
fn solver(solver: &MujocoSolver) -> String {
    let cone = match solver.cone {
        Cone::Elliptic => "elliptic",
        Cone::Pyramidal => "pyramidal",
    };
    let mut text = format!(r#"cone="{cone}" impratio="{}""#, solver.impratio);
    if let Some(iterations) = solver.iterations {
        text.push_str(&format!(r#" iterations="{iterations}""#));
    }
    if let Some(tolerance) = solver.tolerance {
        text.push_str(&format!(r#" tolerance="{tolerance}""#));
    }
    if solver.no_slip_iterations > 0 {
        let iterations = solver.no_slip_iterations;
        text.push_str(&format!(r#" noslip_iterations="{iterations}""#));
    }
    text
}

fn numbers(numbers: &[f64]) -> String {
    let texts: Vec<String> = numbers.iter().map(f64::to_string).collect();
    texts.join(" ")
}

/// A name as an attribute's value.
fn escaped(name: &str) -> String {
    name.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}

fn place(pose: &Pose) -> String {
    format!(
        r#"pos="{}" quat="{}""#,
        numbers(&pose.position_m),
        numbers(&pose.orientation)
    )
}

fn hulls(text: &mut String, layout: &Layout) {
    let hulls = layout.shapes.iter().filter_map(|shape| match &shape.form {
        Form::Hull { points_m } => Some((&shape.name, points_m)),
        _ => None,
    });
    put!(text, "<asset>");
    for (name, points_m) in hulls {
        put!(
            text,
            r#"<mesh name="{}" vertex="{}" inertia="convex"/>"#,
            escaped(name),
            numbers(points_m.as_flattened())
        );
    }
    put!(text, "</asset>");
}

fn children_of(text: &mut String, layout: &Layout, parent: Option<usize>) {
    let children = layout.bodies.iter().enumerate();
    for (index, body) in children.filter(|(_, body)| body.parent == parent) {
        let mocap = if body.motion == Motion::Led {
            r#" mocap="true""#
        } else {
            ""
        };
        put!(
            text,
            r#"<body name="{}" {}{mocap}>"#,
            escaped(&body.name),
            place(&body.pose)
        );
        inertial(text, body);
        match body.motion {
            Motion::Free => put!(text, r#"<freejoint name="{}"/>"#, escaped(&body.name)),
            Motion::Jointed => joint_of(text, layout, index),
            Motion::Fixed | Motion::Led => {}
        }
        if layout.wrenches.contains(&index) {
            put!(text, r#"<site name="wrench {index}"/>"#);
        }
        shapes_of(text, layout, Some(index));
        children_of(text, layout, Some(index));
        put!(text, "</body>");
    }
}

fn inertial(text: &mut String, body: &BodyPlan) {
    if let Some(inertia) = &body.inertia {
        let (centre_m, mass_kg) = (numbers(&inertia.centre_m), inertia.mass_kg);
        let moments = moments_of(inertia);
        put!(
            text,
            r#"<inertial pos="{centre_m}" mass="{mass_kg}" {moments}/>"#
        );
    }
}

/// MuJoCo takes no matrix of which a principal moment is below 1e-14, but the moments themselves, which may be 0 where
/// nothing moves.
fn moments_of(inertia: &Inertia) -> String {
    let inertial = robot_model::Inertial {
        mass_kg: inertia.mass_kg,
        centre_m: inertia.centre_m,
        tensor_kg_m2: inertia.moments_kg_m2,
    };
    if inertial.principal_moments_kg_m2()[0] > 1e-13 {
        return format!(r#"fullinertia="{}""#, numbers(&inertia.moments_kg_m2));
    }
    let (moments, axes) = inertial.principal_axes();
    let moments = moments.map(|moment| moment.max(0.0));
    format!(
        r#"quat="{}" diaginertia="{}""#,
        numbers(&axes),
        numbers(&moments)
    )
}

fn joint_of(text: &mut String, layout: &Layout, body: usize) {
    for joint in layout.joints.iter().filter(|joint| joint.body == body) {
        let kind = match joint.kind {
            JointKind::Hinge => "hinge",
            JointKind::Slide => "slide",
            JointKind::Ball => "ball",
        };
        let range = joint.range.map_or(String::new(), |range| {
            format!(r#" range="{}""#, numbers(&range))
        });
        let stop = joint.stop.map_or(String::new(), |stop| {
            let mut text = format!(r#" solreflimit="{}""#, reference_of(&stop));
            if let Some(impedance) = &stop.impedance {
                text.push_str(&format!(r#" solimplimit="{}""#, numbers(impedance)));
            }
            text
        });
        put!(
            text,
            r#"<joint name="{}" type="{kind}" pos="{}" axis="{}" ref="{}" stiffness="{}" springref="{}" damping="{}" frictionloss="{}" armature="{}"{range}{stop}/>"#,
            escaped(&joint.name),
            numbers(&joint.anchor_m),
            numbers(&joint.axis),
            joint.reference,
            joint.stiffness,
            joint.spring_reference,
            joint.damping,
            joint.friction_loss,
            joint.armature
        );
    }
}

fn shapes_of(text: &mut String, layout: &Layout, body: Option<usize>) {
    for shape in layout.shapes.iter().filter(|shape| shape.body == body) {
        put!(
            text,
            r#"<geom name="{}" {} {} friction="{} {}" priority="{}" {} mass="0" {}/>"#,
            escaped(&shape.name),
            place(&shape.pose),
            form_of(shape),
            shape.friction,
            other_friction(&shape.surface),
            priority_of(shape.friction),
            surface_of(&shape.surface),
            masks_of(shape.touches)
        );
    }
}

fn other_friction(surface: &Surface) -> String {
    let [torsional_m, rolling_m] = OTHER_FRICTION_M;
    numbers(&[
        surface.torsional_m.unwrap_or(torsional_m),
        surface.rolling_m.unwrap_or(rolling_m),
    ])
}

/// How many dimensions its contacts have, and how soft they are.
fn surface_of(surface: &Surface) -> String {
    let dimensions = match (surface.torsional_m, surface.rolling_m) {
        (_, Some(_)) => 6,
        (Some(_), None) => 4,
        (None, None) => 3,
    };
    let mut text = format!(r#"condim="{dimensions}""#);
    if let Some(softness) = &surface.softness {
        text.push_str(&format!(r#" solref="{}""#, reference_of(softness)));
        if let Some(impedance) = &softness.impedance {
            text.push_str(&format!(r#" solimp="{}""#, numbers(impedance)));
        }
    }
    text
}

/// The numbers of a `solref`.
fn reference_of(softness: &Softness) -> String {
    numbers(&[softness.time_constant_secs, softness.damping_ratio])
}

/// MuJoCo takes the friction of the shape with the higher priority: the smaller friction's.
fn priority_of(friction: f64) -> i32 {
    ((10.0 - friction) * 1e6).clamp(0.0, 1e8) as i32
}

/// Two shapes touch if a bit of one's `contype` is in the other's `conaffinity`.
fn masks_of(touches: Touches) -> String {
    const ALL: u32 = i32::MAX as u32;
    let (kind, touched) = match touches {
        Touches::All => (ALL, ALL),
        Touches::AllButGroup(group) => {
            let bit = 1 << group.min(30);
            (bit, ALL & !bit)
        }
        Touches::Kinds { is, touches } => (ALL & is, ALL & touches),
        Touches::Nothing => (0, 0),
    };
    format!(r#"contype="{kind}" conaffinity="{touched}""#)
}

fn form_of(shape: &ShapePlan) -> String {
    match &shape.form {
        Form::Ground => r#"type="plane" size="0 0 1""#.to_owned(),
        Form::Box { edges_m } => {
            format!(
                r#"type="box" size="{}""#,
                numbers(&edges_m.map(|edge| edge / 2.0))
            )
        }
        Form::Sphere { radius_m } => format!(r#"type="sphere" size="{radius_m}""#),
        Form::Capsule { radius_m, length_m } => {
            format!(r#"type="capsule" size="{radius_m} {}""#, length_m / 2.0)
        }
        Form::Cylinder { radius_m, length_m } => {
            format!(r#"type="cylinder" size="{radius_m} {}""#, length_m / 2.0)
        }
        Form::Ellipsoid { radii_m } => {
            format!(r#"type="ellipsoid" size="{}""#, numbers(radii_m))
        }
        Form::Hull { .. } => format!(r#"type="mesh" mesh="{}""#, escaped(&shape.name)),
    }
}

fn drives(text: &mut String, layout: &Layout) {
    put!(text, "<actuator>");
    for drive in &layout.drives {
        let Some(joint) = layout.joints.get(drive.joint) else {
            continue;
        };
        let name = escaped(&joint.name);
        let range = format!(r#"forcerange="{} {}""#, -drive.limit, drive.limit);
        match drive.kind {
            DriveKind::Position { stiffness, damping } => put!(
                text,
                r#"<position joint="{name}" kp="{stiffness}" kv="{damping}" {range}/>"#
            ),
            DriveKind::Velocity { gain } => {
                put!(text, r#"<velocity joint="{name}" kv="{gain}" {range}/>"#);
            }
            DriveKind::Effort => put!(text, r#"<motor joint="{name}" {range}/>"#),
        }
    }
    put!(text, "</actuator>");
}

fn couplings(text: &mut String, layout: &Layout) {
    put!(text, "<equality>");
    for coupling in &layout.couplings {
        let name = |joint: usize| layout.joints.get(joint).map(|joint| escaped(&joint.name));
        let Some(follower) = name(coupling.joint) else {
            continue;
        };
        let leader = coupling.leader.and_then(name);
        let leader = leader.map_or(String::new(), |name| format!(r#" joint2="{name}""#));
        // The shortest time constant that MuJoCo takes, and the highest impedance: its own would be a spring of 0.4 N/mm between
        // fingers of 15 g.
        let stiff = match coupling.carries {
            true => format!(
                r#" solref="{} 1" solimp="0.9999 0.9999 0.001 0.5 2""#,
                2.0 * layout.time_step_secs
            ),
            false => String::new(),
        };
        put!(
            text,
            r#"<joint joint1="{follower}"{leader} polycoef="{}"{stiff}/>"#,
            numbers(&coupling.coefficients)
        );
    }
    put!(text, "</equality>");
}

fn no_contact(text: &mut String, layout: &Layout) {
    put!(text, "<contact>");
    for pair in &layout.no_contact {
        let [Some(a), Some(b)] = pair.map(|body| layout.bodies.get(body)) else {
            continue;
        };
        put!(
            text,
            r#"<exclude body1="{}" body2="{}"/>"#,
            escaped(&a.name),
            escaped(&b.name)
        );
    }
    put!(text, "</contact>");
}

/// A force and a torque for each body of which the layout asks for them, at the origin of its frame.
fn wrenches(text: &mut String, layout: &Layout) {
    put!(text, "<sensor>");
    for body in &layout.wrenches {
        put!(text, r#"<force site="wrench {body}"/>"#);
        put!(text, r#"<torque site="wrench {body}"/>"#);
    }
    put!(text, "</sensor>");
}
