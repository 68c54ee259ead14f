//! The physical model in plain numbers, for an engine that is built from these.
//!
//! It is the model that [`mjcf`](super::mjcf) writes for MuJoCo, link by link and shape by shape; a test holds the two against each
//! other in MuJoCo. What the text has as MuJoCo's own settings is carried over so:
//!
//! * Who touches whom: the same bit masks.
//! * Friction of a pair: MuJoCo takes that of the hand, which has priority; here both sides have it, and the smaller holds.
//! * `contact_time_constant_secs` and `stop_time_constant_secs`: springs and dampers that give way as far, and as fast
//!   ([`Softness::spring`]). Of contacts of hand and object, and of object and pedestal, which is fixed, Rapier can have two kinds.
//! * The arm's weight, which its feed-forward carries: constant forces, which whoever runs the layout applies ([`carried`]).
//! * Human: its head and hand touch nothing and are left out.
//!
//! Not carried over, since it says how MuJoCo solves and nothing about the world: iterations, tolerance, impedance ratio, no-slip
//! iterations.

use std::collections::BTreeMap;

use testbench::geometry::{IDENTITY, Pose, Vector, about, compose, from_roll_pitch_yaw};
use testbench::physics::{
    BodyPlan, DriveKind, DrivePlan, Form, Inertia, JointKind, JointPlan, Layout, Motion,
    RapierSolver, ShapePlan, Softness, Solver, Surface, Touches,
};

use super::{
    CONTACT_GEOM_PREFIX, OBJECT_BODY, OBJECT_GEOM, PhysicalDraws, drive_gains, joint_loads,
    link_inertia_kg_m2, object_inertia_kg_m2, object_rest_shapes,
};
use crate::scenario::{Body, Parameters, Scenario, Shape};

const HAND: Touches = Touches::Kinds { is: 1, touches: 2 };
const OBJECT_GRIP: Touches = Touches::Kinds { is: 2, touches: 1 };
const OBJECT_REST: Touches = Touches::Kinds { is: 4, touches: 8 };
const SUPPORT: Touches = Touches::Kinds { is: 8, touches: 4 };

/// `solref` as MuJoCo has it where nothing is said: of the object on the pedestal and the floor.
const AS_IT_COMES_SECS: f64 = 0.02;

/// The model as a layout. Joints are those of [`joint_order`](super::joint_order), with one drive each; the object is the last body.
pub(crate) fn layout(
    scenario: &Scenario,
    parameters: &Parameters,
    draws: &PhysicalDraws,
) -> Layout {
    let settings = &scenario.simulation;
    let softness = |secs| softness(secs).spring();
    let grip = softness(parameters.hand.contact_time_constant_secs);
    let mut layout = Layout {
        time_step_secs: settings.time_step_secs,
        gravity_m_s2: settings.gravity_m_s2,
        solver: Solver {
            rapier: RapierSolver {
                contact_frequency_hz: Some(grip.frequency_hz),
                contact_damping_ratio: Some(grip.damping_ratio),
                fixed_contact: Some(softness(AS_IT_COMES_SECS)),
                substeps: SUBSTEPS,
                iterations: Some(ITERATIONS),
            },
            ..Solver::default()
        },
        ..Layout::default()
    };
    supports(&mut layout, scenario);
    let mut places = BTreeMap::new();
    links(
        &mut layout,
        (scenario, parameters, draws),
        "world",
        &mut places,
    );
    object(&mut layout, scenario, parameters, draws);
    layout
}

/// Substeps of Rapier in a time step, and its passes in each. Of a held leg (tuned, seed 1) the grip's forces add up to 42.6 N, and in
/// MuJoCo to 43.5 N; with 4 passes they were 4 % less, with 2 substeps of 8 the same. A substep costs as much as the step, passes
/// next to nothing.
const SUBSTEPS: usize = 1;
const ITERATIONS: usize = 16;

/// The force that carries a share of a link's weight, for each link of the robot: its place among the layout's bodies, and the
/// force at its centre of mass.
pub(crate) fn carried(scenario: &Scenario, layout: &Layout) -> Vec<(usize, Vector)> {
    let share = scenario.robot.gravity_compensation * layout.gravity_m_s2;
    let bodies = layout.bodies.iter().enumerate();
    let links = bodies.filter(|(_, body)| body.motion != Motion::Free);
    links
        .filter_map(|(index, body)| Some((index, [0.0, 0.0, share * body.inertia?.mass_kg])))
        .collect()
}

fn softness(time_constant_secs: f64) -> Softness {
    Softness {
        time_constant_secs,
        damping_ratio: 1.0,
        impedance: None,
    }
}

fn at(position_m: Vector) -> Pose {
    Pose {
        position_m,
        orientation: IDENTITY,
    }
}

/// Floor and pedestal.
fn supports(layout: &mut Layout, scenario: &Scenario) {
    let pedestal = &scenario.pedestal;
    let form = Form::Cylinder {
        radius_m: pedestal.radius_m,
        length_m: pedestal.length_m,
    };
    for (name, pose, form) in [
        ("floor", at([0.0; 3]), Form::Ground),
        ("pedestal", at(pedestal.centre_m), form),
    ] {
        layout.shapes.push(ShapePlan {
            name: name.to_owned(),
            body: None,
            pose,
            form,
            friction: scenario.object.pedestal_friction,
            touches: SUPPORT,
            surface: Surface::default(),
        });
    }
}

/// The links that hang on `parent`, each followed by those that hang on it.
fn links<'a>(
    layout: &mut Layout,
    of: (&'a Scenario, &Parameters, &PhysicalDraws),
    parent: &str,
    places: &mut BTreeMap<&'a str, usize>,
) {
    let scenario = of.0;
    for body in scenario.bodies.iter().filter(|body| body.parent == parent) {
        places.insert(&body.name, layout.bodies.len());
        link(layout, of, body, places);
        links(layout, of, &body.name, places);
    }
}

fn link(
    layout: &mut Layout,
    (scenario, parameters, draws): (&Scenario, &Parameters, &PhysicalDraws),
    body: &Body,
    places: &BTreeMap<&str, usize>,
) {
    let place = layout.bodies.len();
    let [xx, yy, zz] = link_inertia_kg_m2(parameters, body);
    layout.bodies.push(BodyPlan {
        name: body.name.clone(),
        parent: places.get(body.parent.as_str()).copied(),
        pose: Pose {
            position_m: body.position_m,
            orientation: compose(
                from_roll_pitch_yaw(body.rotation_rpy_rad),
                about(body.fixed_axis, body.fixed_angle_rad),
            ),
        },
        motion: match body.joint {
            Some(_) => Motion::Jointed,
            None => Motion::Fixed,
        },
        inertia: Some(Inertia {
            mass_kg: body.mass_kg,
            centre_m: body.shape_position_m,
            moments_kg_m2: [xx, yy, zz, 0.0, 0.0, 0.0],
        }),
    });
    if body.joint.is_some() {
        drive(layout, scenario, parameters, body, place);
    }
    if let Some(shape) = &body.contact_shape {
        let (form, pose) = form_of(shape, body.shape_position_m);
        layout.shapes.push(ShapePlan {
            name: format!("{CONTACT_GEOM_PREFIX}{}", body.name),
            body: Some(place),
            pose,
            form,
            friction: draws.friction,
            touches: HAND,
            surface: Surface::default(),
        });
    }
}

/// A link's joint with its position servo.
fn drive(
    layout: &mut Layout,
    scenario: &Scenario,
    parameters: &Parameters,
    body: &Body,
    place: usize,
) {
    let Some(joint) = &body.joint else { return };
    let (armature, friction_loss) = joint_loads(scenario, parameters, joint.drive);
    let [stiffness, damping, limit] = drive_gains(parameters, joint);
    layout.drives.push(DrivePlan {
        joint: layout.joints.len(),
        kind: DriveKind::Position { stiffness, damping },
        limit,
    });
    layout.joints.push(JointPlan {
        name: body.name.clone(),
        body: place,
        kind: JointKind::Hinge,
        anchor_m: [0.0; 3],
        axis: joint.axis,
        reference: 0.0,
        range: Some(joint.range_rad),
        damping: 0.0,
        friction_loss,
        armature,
        stiffness: 0.0,
        spring_reference: 0.0,
        stop: Some(softness(parameters.hand.stop_time_constant_secs)),
    });
}

/// A shape's form and its frame in the link's; capsules of a scenario lie along y, with their caps within the length.
fn form_of(shape: &Shape, centre_m: Vector) -> (Form, Pose) {
    match *shape {
        Shape::Box { box_m } => (Form::Box { edges_m: box_m }, at(centre_m)),
        Shape::Sphere { sphere_radius_m } => {
            let radius_m = sphere_radius_m;
            (Form::Sphere { radius_m }, at(centre_m))
        }
        Shape::Cylinder {
            cylinder_length_m,
            cylinder_radius_m,
        } => {
            let form = Form::Cylinder {
                radius_m: cylinder_radius_m,
                length_m: cylinder_length_m,
            };
            (form, at(centre_m))
        }
        Shape::Capsule {
            capsule_length_m,
            capsule_radius_m,
        } => {
            let form = Form::Capsule {
                radius_m: capsule_radius_m,
                length_m: capsule_length_m - 2.0 * capsule_radius_m,
            };
            let pose = Pose {
                position_m: centre_m,
                orientation: about([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_2),
            };
            (form, pose)
        }
    }
}

fn object(
    layout: &mut Layout,
    scenario: &Scenario,
    parameters: &Parameters,
    draws: &PhysicalDraws,
) {
    let place = layout.bodies.len();
    let mass_kg = draws.object_mass_kg;
    let [xx, yy, zz] = object_inertia_kg_m2(scenario, parameters, mass_kg);
    layout.bodies.push(BodyPlan {
        name: OBJECT_BODY.to_owned(),
        parent: None,
        pose: draws.object_pose,
        motion: Motion::Free,
        inertia: Some(Inertia {
            mass_kg,
            centre_m: [0.0; 3],
            moments_kg_m2: [xx, yy, zz, 0.0, 0.0, 0.0],
        }),
    });
    let (end, rests) = object_rest_shapes(&scenario.object);
    let grip = Form::Capsule {
        radius_m: scenario.object.radius_m,
        length_m: 2.0 * end,
    };
    let mut add = |name: String, centre_m, form, friction, touches| {
        layout.shapes.push(ShapePlan {
            name,
            body: Some(place),
            pose: at(centre_m),
            form,
            friction,
            touches,
            surface: Surface::default(),
        });
    };
    let name = OBJECT_GEOM.to_owned();
    add(name, [0.0; 3], grip, draws.friction, OBJECT_GRIP);
    for (name, centre_m, radius_m) in rests {
        let form = Form::Sphere { radius_m };
        let friction = scenario.object.pedestal_friction;
        add(
            format!("object_{name}"),
            centre_m,
            form,
            friction,
            OBJECT_REST,
        );
    }
}
