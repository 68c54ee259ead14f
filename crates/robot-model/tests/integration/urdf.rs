//! URDF: the tree, its kinematics in closed form, gaps and problems with their places.

use crate::common;

use common::{ARM, close, elements, load, loaded};
use robot_model::{ActuatorKind, Effect, Format, Geometry, JointKind, Role, SensorKind};

#[test]
fn two_links_in_a_plane_stand_where_trigonometry_says() {
    let model = loaded("arm.urdf", ARM).model;
    assert_eq!(model.format, Format::Urdf);
    let start = |name: &str| model.position_start(model.joint(name).expect("a joint"));
    let mut positions = model.reference_positions();
    let (shoulder, elbow) = (0.4_f64, -1.1_f64);
    positions[start("shoulder").expect("one freedom")] = shoulder;
    positions[start("elbow").expect("one freedom")] = elbow;
    positions[start("left").expect("one freedom")] = 0.03;
    let poses = model.poses(&positions).expect("the right number");
    let both = shoulder + elbow;
    let lower = poses[model.link("lower").expect("a link")];
    assert!(close(
        &lower.position_m,
        &[0.5 * shoulder.cos(), 0.5 * shoulder.sin(), 0.3]
    ));
    let left = poses[model.link("left_finger").expect("a link")];
    let expected = [
        0.5 * shoulder.cos() + 0.4 * both.cos() - 0.03 * both.sin(),
        0.5 * shoulder.sin() + 0.4 * both.sin() + 0.03 * both.cos(),
        0.3,
    ];
    assert!(close(&left.position_m, &expected), "{:?}", left.position_m);
    // The tool's z axis points along the lower link.
    let tool = poses[model.link("tool").expect("a link")];
    let tip = tool.apply([0.0, 0.0, 1.0]);
    let along = [tip[0] - tool.position_m[0], tip[1] - tool.position_m[1]];
    assert!(close(&along, &[both.cos(), both.sin()]));
}

#[test]
fn limits_dynamics_couplings_drives_and_sensors_are_those_of_the_text() {
    let loaded = loaded("arm.urdf", ARM);
    assert_eq!(elements(&loaded.gaps), Vec::<&str>::new());
    assert_eq!(loaded.warnings, vec![]);
    let model = loaded.model;
    assert!((model.total_mass_kg() - 3.2).abs() < 1e-12);
    let shoulder = &model.joints[model.joint("shoulder").expect("a joint")];
    assert_eq!(shoulder.axis, [0.0, 0.0, 1.0], "axes have length 1");
    assert_eq!(shoulder.limits, Some([-2.0, 2.5]));
    assert_eq!(
        (shoulder.effort_limit, shoulder.velocity_limit),
        (Some(50.0), Some(3.0))
    );
    assert_eq!((shoulder.damping, shoulder.friction), (0.7, 0.2));
    let elbow = &model.joints[model.joint("elbow").expect("a joint")];
    assert_eq!((elbow.kind, elbow.limits), (JointKind::Revolute, None));
    assert_eq!(model.couplings.len(), 1);
    assert_eq!(model.couplings[0].leader, model.joint("left"));
    assert_eq!(model.couplings[0].coefficients, [0.001, 1.0, 0.0, 0.0, 0.0]);
    let drives: Vec<_> = model
        .actuators
        .iter()
        .map(|a| (a.name.as_str(), a.kind))
        .collect();
    let position = ActuatorKind::Position { kp: None, kv: None };
    assert_eq!(
        drives,
        [
            ("shoulder/position", position),
            ("elbow/effort", ActuatorKind::Effort)
        ]
    );
    assert_eq!(model.actuators[0].command_range, Some([-2.0, 2.5]));
    assert_eq!(model.actuators[0].force_range, Some([-50.0, 50.0]));
    let imu = model
        .sensors
        .iter()
        .find(|sensor| sensor.name == "wrist_imu")
        .expect("a sensor");
    assert_eq!((&imu.kind, imu.rate_hz), (&SensorKind::Imu, Some(200.0)));
    assert_eq!(imu.link, model.link("tool"));
    assert_eq!(imu.noise[0].0, "angular_velocity/x");
    assert_eq!(imu.noise[0].1.standard_deviation, 0.02);
    let finger = &model.links[model.link("left_finger").expect("a link")];
    assert_eq!(
        finger.shapes[0].friction.map(|friction| friction.sliding),
        Some(0.8)
    );
    let base = &model.links[0];
    assert_eq!(base.shapes[0].colour, Some([0.5, 0.5, 0.5, 1.0]));
    assert_eq!(base.shapes[1].role, Role::Collision);
    assert_eq!(
        base.shapes[1].geometry,
        Geometry::Box {
            half_extents_m: [0.1, 0.1, 0.05]
        }
    );
}

#[test]
fn inertia_is_turned_into_the_axes_of_the_link() {
    let model = loaded("arm.urdf", ARM).model;
    let inertial = model.links[model.link("upper").expect("a link")]
        .inertial
        .expect("mass");
    // R(0.5) [[a, c], [c, b]] R(0.5)ᵀ by hand.
    let (a, b, c) = (0.002, 0.04, 0.001);
    let (sin, cos) = 0.5_f64.sin_cos();
    let xx = cos * cos * a - 2.0 * sin * cos * c + sin * sin * b;
    let yy = sin * sin * a + 2.0 * sin * cos * c + cos * cos * b;
    let xy = sin * cos * (a - b) + (cos * cos - sin * sin) * c;
    assert!(close(
        &inertial.tensor_kg_m2,
        &[xx, yy, 0.041, xy, 0.0, 0.0]
    ));
    assert_eq!(inertial.centre_m, [0.25, 0.0, 0.0]);
}

#[test]
fn what_is_not_carried_over_is_a_gap_with_its_place() {
    let text = r#"<robot name="r">
  <link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>
    <collision><geometry><mesh filename="package://p/a.stl"/></geometry></collision>
    <collision><geometry><mesh filename="package://p/a.dae"/></geometry></collision>
  </link>
  <link name="b"/>
  <joint name="j" type="fixed"><parent link="a"/><child link="b"/><calibration rising="0"/></joint>
  <gazebo><plugin filename="x"/></gazebo>
  <sensor name="s"/>
</robot>"#;
    let mut resolve = |address: &str| match address {
        "package://p/a.dae" => Ok(vec![]),
        _ => Err("no such file".to_owned()),
    };
    let loaded = robot_model::parse("r.urdf", text, &mut resolve).expect("a robot");
    let found: Vec<_> = loaded
        .gaps
        .iter()
        .map(|gap| (gap.place.line, gap.element.as_str(), gap.effect))
        .collect();
    assert_eq!(
        found,
        [
            (3, "mesh", Effect::Contact),
            (4, "mesh", Effect::Contact),
            (7, "joint/calibration", Effect::Nothing),
            (9, "robot/sensor", Effect::Nothing),
            (8, "gazebo/plugin", Effect::Control),
        ]
    );
    assert!(loaded.gaps[0].what.contains("no such file"));
}

#[test]
fn impossible_inertias_are_warned_about_and_massless_moving_links_refused() {
    let text = r#"<robot name="r"><link name="a"/>
  <link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="5"/></inertial></link>
  <link name="c"/>
  <joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
  <joint name="k" type="continuous"><parent link="b"/><child link="c"/></joint>
</robot>"#;
    let loaded = loaded("r.urdf", text);
    let found: Vec<String> = loaded.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].starts_with("r.urdf:2:") && found[0].contains("no rigid body has"),
        "{found:?}"
    );
    assert!(found[0].contains("2.3333e0 kg m²"), "{found:?}");
    let refused = |fixed: bool| -> Vec<String> {
        let refusals = loaded.refusals(fixed);
        refusals.iter().map(ToString::to_string).collect()
    };
    let fixed = refused(true);
    assert_eq!(fixed.len(), 1, "{fixed:?}");
    assert!(
        fixed[0].starts_with("r.urdf:3:3: link c moves and has no mass"),
        "{fixed:?}"
    );
    let free = refused(false);
    assert_eq!(free.len(), 2, "{free:?}");
    assert!(free[0].contains("link a") && free[0].contains("fix the robot's base"));
}

/// Texts that are refused, with a part of the place and message of the first problem.
const WRONG: [(&str, &str); 14] = [
    (
        "<robot><link name='a'></robot>",
        "r.urdf:1:23: this is not well-formed XML",
    ),
    (
        "<robot><link/></robot>",
        "r.urdf:1:8: link has no attribute name",
    ),
    ("<robot/>", "the robot has no link"),
    ("<car/>", "<car> starts no robot description"),
    (
        "<robot><link name='a'/><link name='a'/></robot>",
        "two links are called a",
    ),
    (
        "<robot><link name='a'/>\n<link name='b'/></robot>",
        "r.urdf:2:1: links a and b are both roots",
    ),
    (
        "<robot><link name='a'/><joint name='j' type='fixed'><parent link='a'/><child link='x'/></joint></robot>",
        "joint j names link x, which does not exist",
    ),
    (
        "<robot><link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint><joint name='k' type='fixed'><parent link='b'/><child link='a'/></joint></robot>",
        "lies on a cycle",
    ),
    (
        "<robot><link name='a'/><link name='b'/><joint name='j' type='bendy'><parent link='a'/><child link='b'/></joint></robot>",
        "joint j is of type bendy",
    ),
    (
        "<robot><link name='a'><inertial><mass value='NaN'/></inertial></link></robot>",
        "mass@value holds NaN",
    ),
    (
        "<robot><link name='a'><inertial><mass value='1e400'/></inertial></link></robot>",
        "which is too large or not finite",
    ),
    (
        "<robot><link name='a'><collision><geometry><sphere radius='-1'/></geometry></collision></link></robot>",
        "sphere@radius is -1",
    ),
    (
        "<robot xmlns:xacro='http://ros.org/wiki/xacro'><xacro:wheel side='left'/><link name='a'/></robot>",
        "there is no macro `wheel`",
    ),
    (
        "<!DOCTYPE r [<!ENTITY a 'b'>]><robot name='&a;'><link name='a'/></robot>",
        "DTD",
    ),
];

#[test]
fn wrong_texts_are_refused_with_a_place_and_a_remedy() {
    for (text, expected) in WRONG {
        let Err(problems) = load("r.urdf", text) else {
            panic!("accepted: {text}");
        };
        let first = problems.0[0].to_string();
        assert!(first.contains(expected), "{first}\nlacks: {expected}");
        assert!(!problems.0[0].remedy.is_empty());
    }
}

#[test]
fn a_planar_joint_becomes_two_slides_and_a_turn() {
    let text = r#"<robot name="r"><link name="a"/>
  <link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <joint name="p" type="planar"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>"#;
    let loaded = loaded("r.urdf", text);
    let names: Vec<&str> = loaded
        .model
        .joints
        .iter()
        .map(|joint| joint.name.as_str())
        .collect();
    assert_eq!(names, ["p_x", "p_y", "p_yaw"]);
    assert_eq!(elements(&loaded.gaps), ["joint"]);
    let poses = loaded.model.poses(&[1.0, 2.0, 0.7]).expect("three numbers");
    assert!(close(&poses[1].position_m, &[1.0, 2.0, 0.0]));
}
