//! MJCF: classes, frames, orientations, inertia from geoms; and written MJCF read again.

use crate::common;

use common::{ARM, BASE, SWING, close, load, loaded};
use robot_model::{ActuatorKind, JointKind, MjcfOptions, Model, Role, parse, to_mjcf};
use std::f64::consts::PI;

#[test]
fn classes_angles_and_numbers_are_those_of_the_text() {
    let model = loaded("swing.xml", SWING).model;
    assert_eq!(
        (model.time_step_secs, model.gravity_m_s2),
        (Some(0.001), Some([0.0, 0.0, -9.8]))
    );
    let joint = |name: &str| &model.joints[model.joint(name).expect("a joint")];
    assert_eq!((joint("rail").damping, joint("rail").armature), (0.1, 0.0));
    assert_eq!(
        (joint("swing").damping, joint("swing").armature),
        (0.1, 0.01)
    );
    assert_eq!(
        joint("rail").limits,
        Some([-1.0, 1.0]),
        "metres are no degrees"
    );
    assert_eq!(joint("swing").limits, Some([-PI / 2.0, PI / 4.0]));
    assert_eq!(joint("neck").limits.map(|[_, most]| most), Some(PI / 3.0));
    assert_eq!(joint("roll").spring_reference, 10.0_f64.to_radians());
    assert_eq!(joint("rail").reference, 0.2);
    assert_eq!(joint("stone").kind, JointKind::Free);
    let kinds: Vec<ActuatorKind> = model
        .actuators
        .iter()
        .map(|actuator| actuator.kind)
        .collect();
    let servo = ActuatorKind::Position {
        kp: Some(200.0),
        kv: Some(20.0),
    };
    assert_eq!(kinds, [servo, ActuatorKind::Effort]);
    assert_eq!(model.actuators[1].gear, 3.0);
    assert_eq!(model.couplings[0].coefficients, [0.1, 0.5, 0.0, 0.0, 0.0]);
    assert_eq!(model.sensors[0].noise[0].1.standard_deviation, 0.001);
    let stone = &model.links[model.link("stone").expect("a link")];
    let roles: Vec<Role> = stone.shapes.iter().map(|shape| shape.role).collect();
    assert_eq!(roles, [Role::Collision, Role::Visual]);
}

#[test]
fn masses_and_places_follow_from_geoms_and_frames() {
    let model = loaded("swing.xml", SWING).model;
    let inertial = |name: &str| {
        let link = model.link(name).expect("a link");
        model.links[link].inertial.expect("mass")
    };
    let length = 0.26_f64.sqrt();
    let bar = 2000.0 * PI * 0.02 * 0.02 * (length + 4.0 / 3.0 * 0.02);
    assert!((inertial("rod").mass_kg - bar).abs() < 1e-12);
    assert!(close(&inertial("rod").centre_m, &[0.0, 0.05, -0.25]));
    assert!((inertial("cart").mass_kg - 3.0).abs() < 1e-12);
    // A box of 0.2 x 0.1 x 0.1 m.
    let [xx, yy, ..] = inertial("cart").tensor_kg_m2;
    assert!(close(&[xx, yy], &[3.0 / 12.0 * 0.02, 3.0 / 12.0 * 0.05]));
    assert!(
        (inertial("bob").mass_kg - 0.7).abs() < 1e-12,
        "an inertial counts before geoms"
    );
    // The cart's frame: 30 degrees about z, 0.1 m along the turned x axis, 1 m up.
    let poses = model
        .poses(&model.reference_positions())
        .expect("its positions");
    let cart = poses[model.link("cart").expect("a link")].position_m;
    let angle = 30.0_f64.to_radians();
    assert!(close(&cart, &[0.1 * angle.cos(), 0.1 * angle.sin(), 1.0]));
    let stone = poses[model.link("stone").expect("a link")];
    let up = stone.apply([0.0, 0.0, 1.0]);
    let half = 0.5_f64.sqrt();
    assert!(close(&up, &[1.0 + half, 0.0, 0.5 + half]));
}

/// Positions in which every joint has moved.
fn somewhere(model: &Model) -> Vec<f64> {
    let mut positions = model.reference_positions();
    for (index, joint) in model.joints.iter().enumerate() {
        let Some(start) = model.position_start(index) else {
            continue;
        };
        let turned = [0.8, 0.0, 0.6, 0.0];
        match joint.kind {
            JointKind::Fixed => {}
            JointKind::Revolute | JointKind::Prismatic => {
                positions[start] += 0.1 + 0.07 * index as f64
            }
            JointKind::Ball => positions[start..start + 4].copy_from_slice(&turned),
            JointKind::Free => positions[start + 3..start + 7].copy_from_slice(&turned),
        }
    }
    positions
}

#[test]
fn what_is_written_is_read_again_as_the_same_tree() {
    for (file, text) in [("arm.urdf", ARM), ("base.sdf", BASE), ("swing.xml", SWING)] {
        let first = loaded(file, text).model;
        let written = to_mjcf(&first, &MjcfOptions::default()).expect("a text");
        let second = loaded("again.xml", &written.text).model;
        assert_eq!(second.links.len(), first.links.len(), "{file}");
        assert!(
            (second.total_mass_kg() - first.total_mass_kg()).abs() < 1e-12,
            "{file}"
        );
        assert_eq!(second.couplings.len(), first.couplings.len());
        let moving = |model: &Model| -> Vec<String> {
            let joints = model
                .joints
                .iter()
                .filter(|joint| joint.kind != JointKind::Fixed);
            joints.map(|joint| joint.name.clone()).collect()
        };
        assert_eq!(moving(&second), moving(&first));
        let positions = somewhere(&first);
        let poses = first.poses(&positions).expect("its positions");
        let again = second.poses(&positions).expect("the same positions");
        for (before, after) in poses.iter().zip(&again) {
            assert!(
                close(&before.position_m, &after.position_m),
                "{file}: {before:?} {after:?}"
            );
        }
        for (before, after) in first.links.iter().zip(&second.links) {
            let [before, after] =
                [before, after].map(|link| link.inertial.map_or([0.0; 6], |i| i.tensor_kg_m2));
            assert!(close(&before, &after), "{file}: {before:?} {after:?}");
        }
    }
}

#[test]
fn the_same_text_gives_the_same_bytes() {
    let write = || {
        to_mjcf(&loaded("base.sdf", BASE).model, &MjcfOptions::default())
            .expect("a text")
            .text
    };
    assert_eq!(write(), write());
}

#[test]
fn includes_are_spliced_and_names_are_found_across_files() {
    let main = "<mujoco><include file='parts/a.xml'/><worldbody><body name='b'><geom class='heavy'/></body></worldbody></mujoco>";
    let part = "<mujocoinclude><default><default class='heavy'><geom size='0.1' mass='5'/></default></default></mujocoinclude>";
    let mut resolve = |address: &str| match address {
        "models/parts/a.xml" => Ok(part.as_bytes().to_vec()),
        other => Err(format!("{other} is not here")),
    };
    let loaded = parse("models/main.xml", main, &mut resolve).expect("a model");
    assert_eq!(loaded.model.total_mass_kg(), 5.0);
}

#[test]
fn a_tetrahedron_has_the_inertia_of_the_closed_form() {
    // Corners 0, e1, e2, e3: V = 1/6, centre 1/4, second moments V/10 and V/20 about the corner.
    let text = "<mujoco><asset><mesh name='t' vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 2 1 0 1 3 0 3 2 1 2 3'/></asset>\
        <worldbody><body name='b'><geom type='mesh' mesh='t' density='60'/></body></worldbody></mujoco>";
    let model = loaded("t.xml", text).model;
    let inertial = model.links[0].inertial.expect("mass");
    assert!((inertial.mass_kg - 10.0).abs() < 1e-12);
    assert!(close(&inertial.centre_m, &[0.25; 3]));
    let (square, product) = (10.0 / 10.0 - 10.0 / 16.0, 10.0 / 20.0 - 10.0 / 16.0);
    let expected = [
        2.0 * square,
        2.0 * square,
        2.0 * square,
        -product,
        -product,
        -product,
    ];
    assert!(
        close(&inertial.tensor_kg_m2, &expected),
        "{:?}",
        inertial.tensor_kg_m2
    );
}

/// Texts that are refused, with a part of the first problem.
const WRONG: [(&str, &str); 6] = [
    (
        "<mujoco><worldbody><body><geom class='x' size='1'/></body></worldbody></mujoco>",
        "there is no class x",
    ),
    (
        "<mujoco><worldbody><body><geom type='box' size='1'/></body></worldbody></mujoco>",
        "a box has only 1 sizes",
    ),
    (
        "<mujoco><worldbody><geom type='mesh' mesh='m'/></worldbody></mujoco>",
        "there is no mesh m",
    ),
    (
        "<mujoco><worldbody><body name='a'/><body name='a'/></worldbody></mujoco>",
        "two bodies are called a",
    ),
    (
        "<mujoco><actuator><motor joint='j'/></actuator></mujoco>",
        "motor@joint names j, which does not exist",
    ),
    (
        "<mujoco><include file='x.xml'/></mujoco>",
        "x.xml cannot be included",
    ),
];

#[test]
fn wrong_texts_are_refused_with_a_reason() {
    for (text, expected) in WRONG {
        let Err(problems) = load("m.xml", text) else {
            panic!("accepted: {text}");
        };
        assert!(
            problems.0[0].to_string().contains(expected),
            "{problems}\nlacks: {expected}"
        );
    }
}
