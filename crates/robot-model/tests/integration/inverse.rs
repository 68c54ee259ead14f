//! Inverse kinematics against forward kinematics: on arms of public packages where these are installed, on a planar arm whose
//! answers are known everywhere.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use crate::common::loaded;
use robot_model::inverse::{Chain, Goal, rotation_vector};
use robot_model::{JointKind, Model, Pose, parse};

/// Two links of 0.5 m and 0.3 m that turn about z, then a hand of 0.2 m.
const PLANAR: &str = r#"<robot name="planar">
  <link name="base"/><link name="upper"/><link name="fore"/><link name="hand"/>
  <joint name="a" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="b" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/><limit lower="0" upper="2.5" effort="1" velocity="1"/></joint>
  <joint name="c" type="revolute"><parent link="fore"/><child link="hand"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
</robot>"#;

fn planar() -> (Model, Chain) {
    let model = loaded("planar.urdf", PLANAR).model;
    let chain = Chain {
        joints: ["a", "b", "c"]
            .map(|name| model.joint(name).unwrap())
            .to_vec(),
        link: model.link("hand").unwrap(),
        tool: Pose::at([0.2, 0.0, 0.0]),
    };
    (model, chain)
}

/// Where the installed packages of robots are.
fn packages() -> Option<PathBuf> {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.tools/robots/lib/python3.11");
    let robots = python.join("site-packages/cmeel.prefix/share/example-robot-data/robots");
    if !robots.is_dir() {
        println!("skipped: no packages of robots (.ci/run robots_of_others installs them)");
        return None;
    }
    Some(robots)
}

/// A robot of a package, and its chain from the root to a link.
fn arm(path: &Path, link: &str) -> (Model, Chain) {
    let text = std::fs::read_to_string(path).expect("the description");
    let robots = path.ancestors().nth(3).expect("above the package");
    let mut resolve = |address: &str| {
        let local = address.split("/robots/").last().unwrap_or(address);
        std::fs::read(robots.join(local)).map_err(|error| error.to_string())
    };
    let model = parse("arm.urdf", &text, &mut resolve)
        .unwrap_or_else(|p| panic!("{p}"))
        .model;
    let link = model.link(link).unwrap_or_else(|| panic!("no {link}"));
    let mut links = vec![link];
    while let Some(parent) = model.links[links[links.len() - 1]].parent {
        links.push(parent);
    }
    let moves = |index: &usize| {
        let joint = &model.joints[*index];
        links.contains(&joint.link)
            && matches!(joint.kind, JointKind::Revolute | JointKind::Prismatic)
    };
    let joints = (0..model.joints.len()).filter(moves).collect();
    let tool = Pose::at([0.0, 0.02, 0.1]);
    (model, Chain { joints, link, tool })
}

/// All positions, with those of the chain.
fn with(model: &Model, chain: &Chain, positions: &[f64]) -> Vec<f64> {
    let mut all = model.reference_positions();
    for (joint, position) in chain.joints.iter().zip(positions) {
        all[model.position_start(*joint).unwrap()] = *position;
    }
    all
}

/// Positions within the limits, by whole numbers alone.
fn within_limits(model: &Model, chain: &Chain, number: usize) -> Vec<f64> {
    let joints = chain.joints.iter().enumerate();
    joints
        .map(|(index, joint)| {
            let [low, high] = model.joints[*joint].limits.unwrap_or([-PI, PI]);
            let share = ((number * 37 + index * 23 + number * index * 11) % 97) as f64 / 96.0;
            low + (high - low) * (0.05 + 0.9 * share)
        })
        .collect()
}

/// Of a number of poses that the arm can have, all are found again from one start.
fn finds_all(model: &Model, chain: &Chain, poses: usize) {
    for number in 0..poses {
        let wanted = within_limits(model, chain, number);
        let goal = model
            .tool_pose(chain, &with(model, chain, &wanted))
            .unwrap();
        let start = with(model, chain, &within_limits(model, chain, number + 1000));
        let goal = Goal {
            position_m: goal.position_m,
            rotation: Some(goal.rotation),
        };
        let found = model.inverse(chain, &goal, &start).unwrap();
        assert!(found.is_there(), "pose {number}: {found:?} for {wanted:?}");
        // Forwards again, by the same poses that physics has.
        let tool = model
            .tool_pose(chain, &with(model, chain, &found.positions))
            .unwrap();
        let turn = rotation_vector(tool.rotation, goal.rotation.unwrap());
        for (now, wanted) in tool.position_m.iter().zip(goal.position_m) {
            assert!((now - wanted).abs() < 2e-6, "pose {number}");
        }
        assert!(turn.iter().all(|angle| angle.abs() < 2e-6), "pose {number}");
        for (joint, position) in chain.joints.iter().zip(&found.positions) {
            let [low, high] = model.joints[*joint].limits.unwrap_or([-1e9, 1e9]);
            assert!(
                (low..=high).contains(position),
                "pose {number}: joint {joint} at {position}"
            );
        }
    }
}

#[test]
fn an_arm_of_six_joints_of_a_public_package_finds_its_poses_again() {
    let Some(robots) = packages() else { return };
    let (model, chain) = arm(
        &robots.join("ur_description/urdf/ur5_robot.urdf"),
        "wrist_3_link",
    );
    assert_eq!(chain.joints.len(), 6);
    finds_all(&model, &chain, 40);
}

#[test]
fn an_arm_of_seven_joints_of_a_public_package_finds_its_poses_again() {
    let Some(robots) = packages() else { return };
    let (model, chain) = arm(
        &robots.join("panda_description/urdf/panda.urdf"),
        "panda_link8",
    );
    assert_eq!(chain.joints.len(), 7);
    finds_all(&model, &chain, 40);
}

#[test]
fn a_planar_arm_has_the_angles_of_the_law_of_cosines() {
    let (model, chain) = planar();
    // With the hand along x the wrist is at (0.4, 0.3), 0.5 m away: the elbow's angle follows from the sides 0.5, 0.3 and 0.5.
    let goal = Goal {
        position_m: [0.6, 0.3, 0.0],
        rotation: Some([1.0, 0.0, 0.0, 0.0]),
    };
    let found = model
        .inverse(&chain, &goal, &model.reference_positions())
        .unwrap();
    assert!(found.is_there(), "{found:?}");
    let inside = ((0.25 + 0.09 - 0.25) / (2.0 * 0.5 * 0.3_f64)).acos();
    assert!(
        (found.positions[1] - (PI - inside)).abs() < 1e-5,
        "{found:?}"
    );
    assert!(
        found.positions.iter().sum::<f64>().abs() < 1e-5,
        "{found:?}"
    );
}

#[test]
fn what_is_out_of_reach_is_told_with_the_distance_that_is_left() {
    let (model, chain) = planar();
    let start = model.reference_positions();
    let at = |position_m| Goal {
        position_m,
        rotation: None,
    };
    // Stretched it reaches 1 m.
    for far in [1.5, 4.0] {
        let found = model.inverse(&chain, &at([0.0, far, 0.0]), &start).unwrap();
        assert!(!found.is_there());
        assert!((found.distance_m - (far - 1.0)).abs() < 1e-4, "{found:?}");
    }
    // Nothing of it leaves the plane.
    let found = model
        .inverse(&chain, &at([0.4, 0.4, 0.25]), &start)
        .unwrap();
    assert!((found.distance_m - 0.25).abs() < 1e-4, "{found:?}");
    // With the hand turned out of the plane a right angle is left, and the place can still be reached.
    let upright = Goal {
        position_m: [0.6, 0.3, 0.0],
        rotation: Some([0.5_f64.sqrt(), 0.0, 0.5_f64.sqrt(), 0.0]),
    };
    let found = model.inverse(&chain, &upright, &start).unwrap();
    assert!(found.distance_m < 1e-3, "{found:?}");
    assert!((found.angle_rad - PI / 2.0).abs() < 1e-3, "{found:?}");
}

#[test]
fn limits_hold_where_they_keep_the_goal_out_of_reach() {
    let (model, chain) = planar();
    // Folded all the way the elbow would have to go beyond 2.5 rad for a wrist this near.
    let goal = Goal {
        position_m: [0.0, 0.0, 0.0],
        rotation: None,
    };
    let found = model
        .inverse(&chain, &goal, &model.reference_positions())
        .unwrap();
    for (joint, position) in chain.joints.iter().zip(&found.positions) {
        let [low, high] = model.joints[*joint].limits.unwrap();
        assert!((low..=high).contains(position), "{found:?}");
    }
    let again = model
        .inverse(&chain, &goal, &model.reference_positions())
        .unwrap();
    assert_eq!(found, again, "the same every time");
    assert_eq!(
        model.inverse(&chain, &goal, &[0.0]),
        None,
        "too few positions"
    );
}
