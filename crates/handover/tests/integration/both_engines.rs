//! The handover's robot and object as a scene, in both engines.
//!
//! A scene does not carry MuJoCo's contact masks and solver settings over, so the grip itself is not
//! compared here; the engine's own tests compare grips that are laid out by hand. What is compared is
//! how the machine, without power, falls.

use crate::common;

use std::sync::Arc;

use handover::{World, mjcf};
use stimulus::Stimulus;
use testbench::controller::ControllerError;
use testbench::scene::{BuildPhysics, SceneBench, mujoco, rapier};
use testbench::{Bench, Cancel, Unwatched, differences};
use trace::Trace;

/// Nothing drives it, and what it touches is the same in both.
const SCENE: &str = r#"
    name = "the handover's machine falls"
    simulation = { duration_secs = 0.12, time_step_secs = 0.002 }
    [[robot]]
    name = "machine"
    file = "handover.xml"
    fixed = true
    recorded_joints = ["hip_rotor", "left_shoulder_flex", "left_shoulder_abduction", "left_humeral_rot", "left_elbow_flex", "left_wrist_pronation", "left_thumb_flex"]
    [[abstract_test]]
    name = "nothing"
    actions = []
"#;

fn fall(model: &str, step_secs: f64, physics: BuildPhysics) -> Trace {
    let read = |_: &str| Ok(model.as_bytes().to_vec());
    let none = Arc::new(|_: &_| {
        Err(ControllerError::Failed {
            message: "there is none".to_owned(),
        })
    });
    let scene = SCENE.replace("0.002", &step_secs.to_string());
    let (bench, gaps) = SceneBench::new(&scene, &read, physics, none).expect("sound");
    assert!(!gaps.is_empty(), "what is not carried over is said");
    let nothing = Stimulus::of(bench.tests()[0].clone());
    let run = bench.run(&nothing, 1, &mut Unwatched, &Cancel::default());
    run.expect("it runs").trace
}

#[test]
fn the_handover_s_machine_falls_the_same_in_both_engines() {
    let Some(engine) = common::engine() else {
        return;
    };
    let (scenario, tuned) = (common::scenario(), common::parameters("tuned"));
    let world = World::new(&engine, &scenario, &tuned).expect("sound");
    let model = mjcf(&scenario, &tuned, &world.physical_draws(1));
    let apart = [0.002, 0.001].map(|step_secs| {
        let first = fall(&model, step_secs, mujoco(&engine));
        let second = fall(&model, step_secs, rapier());
        let of_joints = differences(&first, &second);
        let of_joints = of_joints
            .iter()
            .filter(|it| it.signal.ends_with(".position"));
        of_joints.map(|it| it.largest).fold(0.0, f64::max)
    });
    // Measured over 0.24 s, in which the elbow falls by 0.81 rad: 3.8 and 1.9 mrad. What is between
    // the engines shrinks with the step.
    assert!(
        apart[0] < 0.02 && apart[1] < 0.7 * apart[0],
        "{apart:?} rad"
    );
}
