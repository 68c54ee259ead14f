//! SDF: frames relative to frames, trees from joints in any order, includes, worlds.

use crate::common;

use common::{BASE, close, elements, load, loaded};
use robot_model::{Effect, JointKind, SensorKind, parse};
use std::f64::consts::PI;

#[test]
fn poses_relative_to_other_frames_are_resolved() {
    let loaded = loaded("base.sdf", BASE);
    assert_eq!(elements(&loaded.gaps), ["model/plugin"]);
    assert_eq!(loaded.gaps[0].effect, Effect::Control);
    let model = loaded.model;
    let poses = model
        .poses(&model.reference_positions())
        .expect("its own positions");
    let at = |name: &str| poses[model.link(name).unwrap_or_else(|| panic!("no {name}"))];
    assert!(close(&at("left_wheel").position_m, &[0.1, 0.17, 0.08]));
    // The foot, 0.2 m below the pole's frame, stands at the placed pose: on top of the chassis.
    assert!(close(
        &at("mast::pole").position_m,
        &[-0.1, 0.0, 0.1 + 0.05 + 0.2]
    ));
    // Turned with the model's pose: the pole's x axis points along y.
    let tip = at("mast::pole").apply([1.0, 0.0, 0.0]);
    assert!(close(&tip, &[-0.1, 1.0, 0.35]));
}

#[test]
fn axes_are_turned_into_the_moved_link_and_free_models_get_a_free_joint() {
    let model = loaded("base.sdf", BASE).model;
    for name in ["left_drive", "right_drive"] {
        let joint = &model.joints[model.joint(name).expect("a joint")];
        assert!(
            close(&joint.axis, &[0.0, 0.0, 1.0]),
            "{name}: {:?}",
            joint.axis
        );
    }
    let free = &model.joints[model.joint("chassis_free").expect("a joint")];
    assert_eq!(
        (free.kind, free.link),
        (JointKind::Free, model.link("chassis").expect("a link"))
    );
    assert_eq!(model.freedoms(), 8);
    let axle = model
        .marks
        .iter()
        .find(|mark| mark.name == "axle")
        .expect("a frame");
    assert_eq!(
        axle.link,
        model.link("chassis"),
        "the model's frame moves with its first link"
    );
    assert!(close(&axle.pose_in_link.position_m, &[0.1, 0.0, -0.02]));
}

#[test]
fn automatic_inertia_is_that_of_the_capsule() {
    let model = loaded("base.sdf", BASE).model;
    let pole = model.links[model.link("mast::pole").expect("a link")]
        .inertial
        .expect("mass");
    let volume = PI * 0.02 * 0.02 * (0.36 + 4.0 / 3.0 * 0.02);
    assert!((pole.mass_kg - 500.0 * volume).abs() < 1e-12);
}

#[test]
fn a_lidar_keeps_its_fan_range_rate_noise_and_place() {
    let model = loaded("base.sdf", BASE).model;
    let scan = &model.sensors[0];
    let SensorKind::Lidar(lidar) = scan.kind else {
        panic!("{scan:?}");
    };
    assert_eq!((lidar.horizontal.count, lidar.vertical.count), (360, 1));
    assert_eq!(
        (lidar.nearest_m, lidar.farthest_m, lidar.resolution_m),
        (0.1, 12.0, 0.01)
    );
    assert_eq!(scan.rate_hz, Some(10.0));
    assert_eq!(scan.noise[0].1.standard_deviation, 0.01);
    assert!(
        close(&scan.pose_in_link.position_m, &[0.0, 0.0, 0.2]),
        "relative to the foot"
    );
}

/// A model of links a, b, c and the given joints.
fn with_joints(joints: &str) -> String {
    let links: String = ["a", "b", "c"]
        .iter()
        .zip(1..)
        .map(|(name, x)| {
            format!("<link name='{name}'><pose>{x} 0 0 0 0 0</pose><inertial><mass>1</mass></inertial></link>")
        })
        .collect();
    format!("<sdf version='1.9'><model name='m'>{links}{joints}</model></sdf>")
}

#[test]
fn a_joint_is_turned_round_where_only_that_makes_a_tree() {
    let text = with_joints(
        "<joint name='j' type='fixed'><parent>a</parent><child>b</child></joint>\
         <joint name='k' type='revolute'><parent>c</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>",
    );
    let model = loaded("m.sdf", &text).model;
    let c = model.link("c").expect("a link");
    assert_eq!(model.links[c].parent, model.link("b"));
    // b turned by 0.5 against c about the origin of b is c turned by -0.5 against b about it.
    let k = model.joint("k").expect("a joint");
    let mut positions = model.reference_positions();
    positions[model.position_start(k).expect("one freedom")] = 0.5;
    let poses = model.poses(&positions).expect("its positions");
    let (b, c) = (poses[model.link("b").expect("a link")], poses[c]);
    let b_in_c = c.inverse().then(&b);
    let x_of_b = b_in_c.apply([1.0, 0.0, 0.0]);
    let along = [
        x_of_b[0] - b_in_c.position_m[0],
        x_of_b[1] - b_in_c.position_m[1],
    ];
    assert!(close(&along, &[0.5_f64.cos(), 0.5_f64.sin()]), "{along:?}");
    assert!(close(&b_in_c.position_m, &[-1.0, 0.0, 0.0]));
}

#[test]
fn a_loop_is_opened_and_said() {
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name='{name}' type='fixed'><parent>{parent}</parent><child>{child}</child></joint>"
        )
    };
    let text = with_joints(&(joint("j", "a", "b") + &joint("k", "b", "c") + &joint("l", "c", "a")));
    let loaded = loaded("m.sdf", &text);
    assert_eq!(elements(&loaded.gaps), ["joint"]);
    assert!(loaded.gaps[0].what.contains("closes a loop"));
}

#[test]
fn a_world_includes_models_and_says_which_it_could_not_have() {
    let world = "<sdf version='1.9'><world name='w'><gravity>0 0 -3.7</gravity>\
        <physics type='ode'><max_step_size>0.002</max_step_size></physics>\
        <include><uri>model://box</uri><name>left</name><pose>0 1 0 0 0 0</pose></include>\
        <include><uri>model://box</uri><name>right</name><static>true</static></include>\
        <include><uri>model://absent</uri></include>\
        <light name='sun'/></world></sdf>";
    let body = with_joints("").replace("version='1.9'", "version='1.4'");
    let mut asked = vec![];
    let mut resolve = |address: &str| {
        asked.push(address.to_owned());
        match address {
            "model://box/model.sdf" => Ok(body.clone().into_bytes()),
            other => Err(format!("{other} is not here")),
        }
    };
    let loaded = parse("w.sdf", world, &mut resolve).expect("a world");
    assert_eq!(
        asked,
        [
            "model://box/model.sdf",
            "model://box/model.sdf",
            "model://absent/model.sdf"
        ]
    );
    let model = loaded.model;
    assert_eq!(
        (model.gravity_m_s2, model.time_step_secs),
        (Some([0.0, 0.0, -3.7]), Some(0.002))
    );
    assert_eq!(elements(&loaded.gaps), ["include", "world/light"]);
    let left = model.link("left::b").expect("a link");
    assert!(close(
        &model.links[left].pose_in_parent.position_m,
        &[2.0, 1.0, 0.0]
    ));
    assert!(model.is_static(model.link("right::b").expect("a link")) && !model.is_static(left));
    assert_eq!(
        model.freedoms(),
        18,
        "three free links on the left, none on the right"
    );
}

/// Texts that are refused, with a part of the first problem.
const WRONG: [(&str, &str); 8] = [
    (
        "<link name='x'><pose relative_to='y'/></link>",
        "there is no frame m::y",
    ),
    (
        "<frame name='f'><pose relative_to='g'/></frame><frame name='g'><pose relative_to='f'/></frame>",
        "depends on itself",
    ),
    (
        "<link name='a'/>",
        "two things in one model are called m::a",
    ),
    (
        "<link name='x'><pose>1 2 3</pose></link>",
        "pose has 3 numbers",
    ),
    (
        "<joint name='j' type='fixed'><parent>a</parent></joint>",
        "joint m::j has no child",
    ),
    (
        "<joint name='j' type='fixed'><parent>a</parent><child>world</child></joint>",
        "the child of joint m::j is the world",
    ),
    (
        "<joint name='j' type='revolute'><parent>a</parent><child>b</child><axis><xyz>0 0 0</xyz></axis></joint>",
        "axis/xyz has no direction",
    ),
    (
        "<joint name='j' type='fixed'><parent>a</parent><child>nowhere</child></joint>",
        "joint m::j names m::nowhere, which does not exist",
    ),
];

#[test]
fn wrong_texts_are_refused_with_a_reason() {
    for (part, expected) in WRONG {
        let Err(problems) = load("m.sdf", &with_joints(part)) else {
            panic!("accepted: {part}");
        };
        assert!(
            problems.to_string().contains(expected),
            "{problems}\nlacks: {expected}"
        );
    }
}

#[test]
fn a_file_that_includes_itself_ends() {
    let text =
        "<sdf version='1.9'><world name='w'><include><uri>w.sdf</uri></include></world></sdf>";
    let model = "<sdf version='1.9'><model name='m'><include><uri>m.sdf</uri></include><include><uri>m.sdf</uri></include></model></sdf>";
    let mut resolve = |_: &str| Ok(model.as_bytes().to_vec());
    let problems = parse("w.sdf", text, &mut resolve).expect_err("endless");
    assert!(
        problems.to_string().contains("nested more than"),
        "{problems}"
    );
}

#[test]
fn a_joint_of_old_files_may_have_the_name_of_a_link() {
    let text = |version: &str| {
        format!(
            "<sdf version='{version}'><model name='m'>\
             <joint name='wheel' type='revolute'><parent>base</parent><child>wheel</child><axis><xyz>0 0 1</xyz></axis></joint>\
             <link name='base'/><link name='wheel'><inertial><mass>1</mass></inertial></link></model></sdf>"
        )
    };
    let read = |version: &str| parse("m.sdf", &text(version), &mut |_: &str| Err(String::new()));
    let loaded = read("1.4").unwrap_or_else(|problems| panic!("{problems}"));
    assert!(
        loaded
            .model
            .joints
            .iter()
            .any(|joint| joint.name == "wheel_joint")
    );
    let told = loaded.gaps.iter().map(ToString::to_string);
    assert!(told.into_iter().any(|gap| gap.contains("wheel_joint")));
    // Since 1.7 names have to differ.
    let refused = read("1.7").map(|_| ()).expect_err("two of one name");
    assert!(refused.to_string().contains("two things in one model"));
}
