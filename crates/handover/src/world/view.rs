//! What can be seen of the handover: links, object, pedestal, and what of the human is modelled.
//!
//! Links are placed by forward kinematics from the joints' angles, so that they are the same
//! whichever part of the model is being integrated:
//!
//! ```text
//! T(link) = T(parent) * translate(position) * rotate(rpy) * rotate(fixed) * rotate(axis, angle)
//! ```
//!
//! A link is drawn as what touches the object, if it has that, or as the solid that gives it its
//! inertia.

use std::collections::BTreeMap;

use testbench::geometry::{IDENTITY, Pose, Vector, about, compose, from_roll_pitch_yaw};
use testbench::physics::Form;
use testbench::{Geometry, Role, VisibleShape};

use super::human::HAND_ATTITUDE;
use super::plant::Plant;
use super::setup::Setup;
use crate::scenario::{Body, Scenario, Shape};

/// Radius of the human's head, as in the physical model.
const HEAD_RADIUS_M: f64 = 0.1;
/// The pointer that shows where the human looks.
const GAZE_RADIUS_M: f64 = 0.012;
const GAZE_LENGTH_M: f64 = 0.2;

const WORLD: Pose = Pose {
    position_m: [0.0; 3],
    orientation: IDENTITY,
};

/// What can be seen. The bodies are the scenario's links, then object, head and hand.
pub(super) fn geometry(setup: &Setup) -> Geometry {
    let scenario = &setup.scenario;
    let mut bodies: Vec<String> = scenario.bodies.iter().map(|it| it.name.clone()).collect();
    let mut shapes: Vec<VisibleShape> = scenario
        .bodies
        .iter()
        .enumerate()
        .map(|(index, body)| link_shape(index, body))
        .collect();
    let (object, head, hand) = (bodies.len(), bodies.len() + 1, bodies.len() + 2);
    bodies.extend(["object", "human_head", "human_hand"].map(str::to_owned));
    let mut add = |name: &str, body, role, pose, form| {
        shapes.push(VisibleShape {
            name: name.to_owned(),
            body,
            role,
            pose,
            form,
        });
    };
    let leg = cylinder(scenario.object.length_m, scenario.object.radius_m);
    add("object", Some(object), Role::Object, WORLD, leg);
    let sphere = Form::Sphere {
        radius_m: HEAD_RADIUS_M,
    };
    add("human_head", Some(head), Role::Person, WORLD, sphere);
    let gaze = Pose {
        position_m: [HEAD_RADIUS_M + GAZE_LENGTH_M / 2.0, 0.0, 0.0],
        orientation: about([0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2),
    };
    let pointer = cylinder(GAZE_LENGTH_M, GAZE_RADIUS_M);
    add("human_gaze", Some(head), Role::Person, gaze, pointer);
    let edges_m = scenario.human.hand_box_m;
    let form = Form::Box { edges_m };
    add("human_hand", Some(hand), Role::Person, WORLD, form);
    let pedestal = &scenario.pedestal;
    let place = Pose {
        position_m: pedestal.centre_m,
        ..WORLD
    };
    let form = cylinder(pedestal.length_m, pedestal.radius_m);
    add("pedestal", None, Role::Surroundings, place, form);
    add("floor", None, Role::Surroundings, WORLD, Form::Ground);
    Geometry { bodies, shapes }
}

fn cylinder(length_m: f64, radius_m: f64) -> Form {
    Form::Cylinder { radius_m, length_m }
}

fn link_shape(index: usize, body: &Body) -> VisibleShape {
    let shape = body.contact_shape.as_ref().unwrap_or(&body.shape);
    let mut orientation = IDENTITY;
    let form = match *shape {
        Shape::Box { box_m } => Form::Box { edges_m: box_m },
        Shape::Sphere { sphere_radius_m } => Form::Sphere {
            radius_m: sphere_radius_m,
        },
        Shape::Cylinder {
            cylinder_length_m,
            cylinder_radius_m,
        } => cylinder(cylinder_length_m, cylinder_radius_m),
        Shape::Capsule {
            capsule_length_m,
            capsule_radius_m,
        } => {
            // Capsules of a scenario lie along y, with their caps within the length.
            orientation = about([1.0, 0.0, 0.0], std::f64::consts::FRAC_PI_2);
            Form::Capsule {
                radius_m: capsule_radius_m,
                length_m: capsule_length_m - 2.0 * capsule_radius_m,
            }
        }
    };
    VisibleShape {
        name: body.name.clone(),
        body: Some(index),
        role: Role::Robot,
        pose: Pose {
            position_m: body.shape_position_m,
            orientation,
        },
        form,
    }
}

/// Where the bodies are, in the order of [`geometry`].
pub(super) fn poses(setup: &Setup, plant: &Plant, human: (&Pose, Vector)) -> Vec<Pose> {
    let angles: BTreeMap<&str, f64> = plant.joints_rad().collect();
    let mut poses = link_poses(&setup.scenario, &angles);
    poses.push(plant.object().pose);
    poses.push(*human.0);
    poses.push(Pose {
        position_m: human.1,
        orientation: HAND_ATTITUDE,
    });
    poses
}

/// The links' frames, in the order of the scenario.
fn link_poses(scenario: &Scenario, angles: &BTreeMap<&str, f64>) -> Vec<Pose> {
    let mut poses = vec![WORLD; scenario.bodies.len()];
    let mut to_place = vec![("world", WORLD)];
    while let Some((parent, frame)) = to_place.pop() {
        for (index, body) in scenario.bodies.iter().enumerate() {
            if body.parent == parent {
                let angle_rad = angles.get(body.name.as_str()).copied().unwrap_or(0.0);
                poses[index] = frame.then(&in_parent(body, angle_rad));
                to_place.push((&body.name, poses[index]));
            }
        }
    }
    poses
}

fn in_parent(body: &Body, angle_rad: f64) -> Pose {
    let fixed = compose(
        from_roll_pitch_yaw(body.rotation_rpy_rad),
        about(body.fixed_axis, body.fixed_angle_rad),
    );
    let turned = body
        .joint
        .as_ref()
        .map_or(IDENTITY, |joint| about(joint.axis, angle_rad));
    Pose {
        position_m: body.position_m,
        orientation: compose(fixed, turned),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{PhysicalDraws, joint_order, mjcf, standing_pose};
    use crate::scenario::Parameters;
    use testbench::Engine;
    use testbench::geometry::{norm, rotation_between, subtract};

    fn file(name: &str) -> String {
        let folder = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../case-studies/handover/simulation/"
        );
        std::fs::read_to_string(format!("{folder}{name}")).expect("the case study is there")
    }

    #[test]
    fn links_are_where_the_physics_engine_has_them() {
        let library = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../.tools/mujoco-3.17.0/libmujoco.so.3.17.0"
        );
        let library = std::path::Path::new(library);
        if !library.exists() && std::env::var_os("CI").is_none() {
            println!("skipped: libmujoco not found (run tools/mujoco)");
            return;
        }
        let engine = Engine::load(library).expect("the pinned library loads");
        let scenario = Scenario::parse(&file("scenario.toml")).expect("sound");
        let parameters = Parameters::parse(&file("tuned.toml")).expect("sound");
        let draws = PhysicalDraws {
            object_mass_kg: 0.1,
            friction: 0.6,
            object_pose: standing_pose(&scenario, 0.27, -0.4, 0.0),
        };
        let model = mjcf(&scenario, &parameters, &draws);
        let mut simulation = engine.compile(&model).expect("it compiles");
        let names = joint_order(&scenario);
        let mut angles = BTreeMap::new();
        for (index, name) in names.iter().enumerate() {
            // Different angles, none of them round.
            let angle_rad = 0.9 * (1.7 * index as f64 + 0.3).sin();
            simulation.positions_mut()[index] = angle_rad;
            angles.insert(name.as_str(), angle_rad);
        }
        simulation.forward();
        let poses = link_poses(&scenario, &angles);
        for (body, pose) in scenario.bodies.iter().zip(&poses) {
            let id = simulation.body(&body.name).expect("it is in the model");
            let apart_m = norm(subtract(pose.position_m, simulation.body_position(id)));
            let turned = rotation_between(pose.orientation, simulation.body_quaternion(id));
            assert!(apart_m < 1e-9, "{}: {apart_m} m", body.name);
            assert!(norm(turned) < 1e-9, "{}: {turned:?}", body.name);
        }
    }
}
