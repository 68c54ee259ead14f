//! Robots as they are found run, and what cannot run is refused with its place in the robot's own file.

use std::sync::Arc;

use crate::common;
use testbench::controller::ControllerError;
use testbench::scene::{SceneBench, SceneGap, mujoco};
use testbench::{Bench, Cancel, SimError, Unwatched};

const SCENE: &str = r#"
name = "robots"
simulation = { duration_secs = 0.1 }
abstract_test = [{ name = "wait", actions = [] }]
[[robot]]
name = "robot"
file = "robots/arm/urdf/arm.urdf"
fixed = true
"#;

/// A frame of mass 0 as base, a point fixed to the arm, a mesh of a package beside the folder of the file.
const ARM: &str = r#"<robot name="arm">
  <link name="base"><inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0"/></inertial></link>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
    <collision><geometry><mesh filename="package://arm/arm.obj"/></geometry></collision></link>
  <link name="tool"><inertial><mass value="0.1"/><inertia ixx="0" iyy="0" izz="0"/></inertial></link>
  <joint name="turns" type="continuous"><parent link="base"/><child link="arm"/></joint>
  <joint name="holds" type="fixed"><parent link="arm"/><child link="tool"/></joint></robot>"#;

fn made(arm: &str) -> Option<Result<(SceneBench, Vec<SceneGap>), SimError>> {
    let engine = common::engine()?;
    let read = |path: &str| match path {
        "robots/arm/urdf/arm.urdf" => Ok(arm.as_bytes().to_vec()),
        "robots/arm/arm.obj" => Ok(
            b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n".to_vec(),
        ),
        other => Err(format!("{other} is not here")),
    };
    let none = Arc::new(|_: &_| {
        Err(ControllerError::Failed {
            message: "none".into(),
        })
    });
    Some(SceneBench::new(SCENE, &read, mujoco(&engine), none))
}

#[test]
fn a_massless_base_a_point_and_a_mesh_of_a_package_run() {
    let Some(made) = made(ARM) else { return };
    let (bench, gaps) = made.expect("it runs");
    assert!(gaps.is_empty(), "{gaps:?}");
    assert_eq!(bench.layout_of(1).expect("laid out").shapes.len(), 1);
    let wait = stimulus::Stimulus::of(bench.tests()[0].clone());
    let recorded = bench.run(&wait, 1, &mut Unwatched, &Cancel::default());
    assert!(recorded.expect("an episode").steps > 0);
}

#[test]
fn a_moving_link_without_mass_is_refused_with_its_place() {
    let massless = ARM.replace("<mass value=\"1\"/>", "<mass value=\"0\"/>");
    let Some(made) = made(&massless) else { return };
    let Err(refused) = made else {
        panic!("nothing can move it");
    };
    let refused = refused.to_string();
    assert!(
        refused.contains("arm.urdf:3:3: link arm moves and has no mass"),
        "{refused}"
    );
}

/// Two robots of one xacro file with arguments of their own, and a name that the file does not have.
#[test]
fn a_xacro_file_has_the_arguments_of_each_robot() {
    let Some(engine) = common::engine() else {
        return;
    };
    let text = r#"<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="mass" default="1"/><xacro:arg name="long" default="false"/>
  <link name="base"/>
  <link name="arm"><inertial><mass value="$(arg mass)"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>
  <joint name="turns" type="continuous"><parent link="base"/><child link="arm"/></joint>
  <xacro:if value="$(arg long)">
    <link name="more"><inertial><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>
    <joint name="more" type="continuous"><parent link="arm"/><child link="more"/></joint>
  </xacro:if></robot>"#;
    let made = |scene: &str| {
        let read = |_: &str| Ok(text.as_bytes().to_vec());
        let none = Arc::new(|_: &_| {
            Err(ControllerError::Failed {
                message: "none".into(),
            })
        });
        SceneBench::new(scene, &read, mujoco(&engine), none)
    };
    let scene = |arguments: &str| {
        let other =
            "[[robot]]\nname = \"other\"\nfile = \"robots/arm/urdf/arm.urdf\"\nfixed = true\n";
        format!("{SCENE}{arguments}{other}")
    };
    let (bench, _) = made(&scene("arguments = { mass = 2.5, long = true }\n")).expect("it runs");
    let layout = bench.layout_of(1).expect("laid out");
    // Two joints of the one with `long`, one of the other.
    assert_eq!(layout.joints.len(), 3);
    let mut masses: Vec<f64> = (layout.bodies.iter())
        .filter_map(|it| Some(it.inertia.as_ref()?.mass_kg))
        .collect();
    masses.sort_by(f64::total_cmp);
    assert_eq!(masses, [1.0, 2.0, 2.5]);
    let Err(refused) = made(&scene("arguments = { lenght = true }\n")) else {
        panic!("it has no such argument");
    };
    let refused = refused.to_string();
    assert!(
        refused.contains("no argument `lenght`; it has mass, long"),
        "{refused}"
    );
}
