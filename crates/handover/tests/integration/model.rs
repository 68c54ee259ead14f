//! The model of robot and object in the physics engine: what is saved of it, and the arm against its published kinematics.

use crate::common;

use handover::{World, joint_order, mjcf};
use testbench::Simulation;

#[test]
fn a_saved_state_continues_bit_for_bit() {
    let Some(engine) = common::engine() else {
        return;
    };
    let scenario = common::scenario();
    let world = World::new(&engine, &scenario, &common::parameters("tuned")).expect("sound");
    let text = mjcf(
        &scenario,
        &common::parameters("tuned"),
        &world.physical_draws(5),
    );
    let mut simulation = engine.compile(&text).expect("sound");
    let run = |simulation: &mut Simulation| {
        for step in 0..300 {
            let target = f64::from(step) * 1e-3;
            simulation.controls_mut().fill(target);
            simulation.step();
        }
        simulation
            .positions()
            .iter()
            .map(|position| position.to_bits())
            .collect::<Vec<_>>()
    };
    run(&mut simulation);
    let saved = simulation.save();
    let first = run(&mut simulation);
    assert!(simulation.restore(&saved));
    assert_eq!(run(&mut simulation), first);
    let other =
        r#"<mujoco><worldbody><body><freejoint/><geom size="1"/></body></worldbody></mujoco>"#;
    let mut other = engine.compile(other).expect("sound");
    assert!(
        !other.restore(&saved),
        "a state of another model is refused"
    );
}

#[test]
fn the_arm_s_kinematics_are_the_published_ones() {
    let Some(engine) = common::engine() else {
        return;
    };
    let scenario = common::scenario();
    let parameters = common::parameters("tuned");
    let world = World::new(&engine, &scenario, &parameters).expect("sound");
    let text = mjcf(&scenario, &parameters, &world.physical_draws(1));
    let mut simulation = engine.compile(&text).expect("sound");
    let hand = simulation
        .body(&scenario.robot.hand)
        .expect("the scenario was checked");
    let finger = simulation
        .body("left_mid_finger_flex")
        .expect("a body of the scenario");
    // By numpy from the same chain, rotation matrices multiplied out joint by joint; to 1 mm.
    let poses = &scenario.robot.poses;
    for (pose, hand_m, finger_m) in [
        (&poses.prepare, [0.414, 0.089, 1.124], [0.491, 0.065, 1.166]),
        (
            &poses.pickup,
            [0.297, -0.296, 1.109],
            [0.319, -0.375, 1.148],
        ),
        (&poses.serve, [0.321, 0.276, 1.124], [0.399, 0.293, 1.166]),
    ] {
        for (index, joint) in joint_order(&scenario).iter().enumerate() {
            simulation.positions_mut()[index] = pose.get(joint).copied().unwrap_or(0.0);
        }
        simulation.forward();
        for (found, expected) in [
            (simulation.body_position(hand), hand_m),
            (simulation.body_position(finger), finger_m),
        ] {
            for axis in 0..3 {
                assert!(
                    (found[axis] - expected[axis]).abs() < 1e-3,
                    "{found:?} {expected:?}"
                );
            }
        }
    }
}
