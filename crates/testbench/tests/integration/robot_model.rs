//! Descriptions in the physics library: what `robot-model` writes moves as what the library reads itself.
//!
//! Needs the physics library; without it the tests say so and pass.

use crate::common;

use robot_model::{Assembly, Base, JointKind, MjcfOptions, Model, Pose, parse, to_mjcf};
use testbench::{Engine, Simulation};

const ARM: &str = include_str!("../../../robot-model/tests/data/arm.urdf");
const BASE: &str = include_str!("../../../robot-model/tests/data/base.sdf");
const SWING: &str = include_str!("../../../robot-model/tests/data/swing.xml");

fn model(file: &str, text: &str) -> Model {
    let loaded = parse(file, text, &mut |address: &str| Err(address.to_owned()));
    loaded.unwrap_or_else(|problems| panic!("{problems}")).model
}

fn written(model: &Model, extra: &str) -> String {
    let options = MjcfOptions {
        extra: extra.to_owned(),
        ..MjcfOptions::default()
    };
    to_mjcf(model, &options).expect("names are unique").text
}

fn compiled(engine: &Engine, text: &str) -> Simulation {
    engine
        .compile(text)
        .unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Positions in which every joint has moved a little.
fn somewhere(model: &Model) -> Vec<f64> {
    let mut positions = model.reference_positions();
    for (index, joint) in model.joints.iter().enumerate() {
        let Some(start) = model.position_start(index) else {
            continue;
        };
        match joint.kind {
            JointKind::Fixed => {}
            JointKind::Revolute | JointKind::Prismatic => {
                positions[start] += 0.01 * (index + 1) as f64;
            }
            JointKind::Ball => positions[start..start + 4].copy_from_slice(&[0.8, 0.0, 0.6, 0.0]),
            JointKind::Free => {
                positions[start + 3..start + 7].copy_from_slice(&[0.8, 0.0, 0.6, 0.0]);
            }
        }
    }
    positions
}

/// Whether all bodies of the model stand in the simulation where `poses` says.
fn assert_stands(simulation: &Simulation, model: &Model, poses: &[Pose]) {
    for (link, pose) in model.links.iter().zip(poses) {
        // The world's own body has no other name.
        let Some(body) = simulation.body(&link.name) else {
            panic!("the library has no body {}", link.name);
        };
        let position = simulation.body_position(body);
        let quaternion = simulation.body_quaternion(body);
        let same: f64 = quaternion
            .iter()
            .zip(pose.rotation)
            .map(|(a, b)| a * b)
            .sum();
        let near = position
            .iter()
            .zip(pose.position_m)
            .all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(
            near && (same.abs() - 1.0).abs() < 1e-12,
            "{}: {position:?} {pose:?}",
            link.name
        );
    }
}

#[test]
fn the_library_and_the_tree_agree_where_every_link_stands() {
    let Some(engine) = common::engine() else {
        return;
    };
    for (file, text) in [("arm.urdf", ARM), ("base.sdf", BASE), ("swing.xml", SWING)] {
        let model = model(file, text);
        let mut simulation = compiled(&engine, &written(&model, ""));
        assert_eq!(
            simulation.positions(),
            model.reference_positions(),
            "{file}"
        );
        let positions = somewhere(&model);
        simulation.positions_mut().copy_from_slice(&positions);
        simulation.forward();
        let poses = model.poses(&positions).expect("its positions");
        assert_stands(&simulation, &model, &poses);
    }
}

/// The largest difference of positions while two simulations move from the same start.
fn largest_difference(ours: &mut Simulation, theirs: &mut Simulation, start: &[f64]) -> f64 {
    let mut largest = 0.0_f64;
    for simulation in [&mut *ours, &mut *theirs] {
        simulation.positions_mut().copy_from_slice(start);
        for (index, velocity) in simulation.velocities_mut().iter_mut().enumerate() {
            *velocity = 0.3 - 0.1 * (index % 4) as f64;
        }
    }
    for _ in 0..200 {
        ours.step();
        theirs.step();
        let pairs = ours.positions().iter().zip(theirs.positions());
        largest = pairs.fold(largest, |largest, (a, b)| largest.max((a - b).abs()));
    }
    largest
}

#[test]
fn an_mjcf_moves_as_in_the_library_itself() {
    let Some(engine) = common::engine() else {
        return;
    };
    let model = model("swing.xml", SWING);
    let text = written(&model, "<option integrator=\"RK4\"/>");
    let (mut ours, mut theirs) = (compiled(&engine, &text), compiled(&engine, SWING));
    let start = somewhere(&model);
    let difference = largest_difference(&mut ours, &mut theirs, &start);
    let moved = ours
        .positions()
        .iter()
        .zip(&start)
        .any(|(a, b)| (a - b).abs() > 0.01);
    assert!(moved, "nothing moved");
    assert!(difference < 1e-9, "{difference}");
}

#[test]
fn a_urdf_moves_as_in_the_library_itself() {
    let Some(engine) = common::engine() else {
        return;
    };
    let model = model("arm.urdf", ARM);
    let option = "<option><flag contact=\"disable\"/></option>";
    let compiler =
        "<compiler fusestatic=\"false\" discardvisual=\"true\" inertiafromgeom=\"false\"/>";
    let theirs = ARM.replacen(
        "<robot name=\"arm\">",
        &format!("<robot name=\"arm\"><mujoco>{compiler}{option}</mujoco>"),
        1,
    );
    let mut ours = compiled(&engine, &written(&model, option));
    let mut theirs = compiled(&engine, &theirs);
    let difference = largest_difference(&mut ours, &mut theirs, &somewhere(&model));
    assert!(difference < 1e-9, "{difference}");
}

#[test]
fn models_of_three_languages_share_a_world() {
    let Some(engine) = common::engine() else {
        return;
    };
    let mut scene = Assembly::new("scene");
    let table = Pose::at([1.0, 0.0, 0.7]);
    scene
        .add(&model("arm.urdf", ARM), "arm/", table, Base::Fixed)
        .expect("new names");
    scene
        .add(
            &model("base.sdf", BASE),
            "robot/",
            Pose::IDENTITY,
            Base::AsDescribed,
        )
        .expect("new names");
    scene
        .add(
            &model("base.sdf", BASE),
            "other/",
            Pose::at([0.0, 2.0, 0.0]),
            Base::AsDescribed,
        )
        .expect("new names");
    scene
        .add(
            &model("swing.xml", SWING),
            "swing/",
            Pose::at([-2.0, 0.0, 0.0]),
            Base::AsDescribed,
        )
        .expect("new names");
    let again = scene.add(&model("arm.urdf", ARM), "arm/", table, Base::Fixed);
    assert_eq!(again.expect_err("taken").name, "arm/base");
    let text = scene.to_mjcf(&MjcfOptions::default()).expect("a text").text;
    let mut simulation = compiled(&engine, &text);
    let all = scene.model();
    simulation.forward();
    let poses = all
        .poses(&all.reference_positions())
        .expect("its positions");
    assert_stands(&simulation, all, &poses);
    // The robots stand on the floor that came with the swing: their wheels touch it, and nothing else of theirs does.
    for _ in 0..300 {
        simulation.step();
    }
    assert_eq!(simulation.warning_count(), 0);
    let wheel = simulation.body("robot/left_wheel").expect("a body");
    let height = simulation.body_position(wheel)[2];
    assert!((height - 0.08).abs() < 0.005, "{height}");
}
