//! The physics engine, set as the scenarios set it, against textbook physics.

use crate::common;

use testbench::{Engine, Simulation};

/// Solver settings with which a grip creeps little: elliptic cones, and friction that counts far more than the normal forces' softness.
const OPTIONS: &str = r#"<option timestep="0.002" gravity="0 0 -9.81" integrator="implicitfast" cone="elliptic" impratio="1000" iterations="20" tolerance="1e-8"/>"#;

fn compile(engine: &Engine, body: &str) -> Simulation {
    let text = format!("<mujoco>{OPTIONS}{body}</mujoco>");
    engine.compile(&text).expect("the test's model is sound")
}

#[test]
fn a_free_body_falls_as_the_integrator_says() {
    let Some(engine) = common::engine() else {
        return;
    };
    let mut simulation = compile(
        &engine,
        r#"<worldbody><body name="stone" pos="0 0 9"><freejoint/><geom type="sphere" size="0.1" mass="3"/></body></worldbody>"#,
    );
    let stone = simulation.body("stone").expect("it was named");
    for _ in 0..500 {
        simulation.step();
    }
    // Semi-implicit Euler: v_n = -g n h, z_n = z_0 - g h² n (n + 1) / 2; at 1 s that is 9.81 mm
    // below the parabola.
    simulation.forward();
    let expected_m = 9.0 - 9.81 * 0.002_f64.powi(2) * 500.0 * 501.0 / 2.0;
    assert!((simulation.body_position(stone)[2] - expected_m).abs() < 1e-9);
    assert!((simulation.body_velocity(stone).1[2] + 9.81).abs() < 1e-9);
}

/// The pull (N) at which a block held between two pads with `squeeze` newtons starts to slide.
fn pull_at_slip(engine: &Engine, friction: f64, squeeze: f64) -> f64 {
    let pad = |name: &str, y: f64| {
        format!(
            r#"<body pos="0 {y} 1"><joint name="{name}" type="slide" axis="0 1 0"/><geom type="capsule" fromto="-0.02 0 0 0.02 0 0" size="0.01" mass="0.1" priority="1" condim="4" friction="{friction} 0.003 0.0001" solref="0.01 1" contype="1" conaffinity="2"/></body>"#
        )
    };
    let model = format!(
        r#"<worldbody>{}{}<body name="block" pos="0 0 1"><joint type="slide" axis="0 0 1"/><geom type="box" size="0.03 0.03 0.15" mass="0.2" contype="2" conaffinity="1"/></body></worldbody>
        <actuator><motor joint="left"/><motor joint="right"/></actuator>"#,
        pad("left", 0.0399),
        pad("right", -0.0399)
    );
    let mut simulation = compile(engine, &model);
    let block = simulation.body("block").expect("it was named");
    simulation
        .controls_mut()
        .copy_from_slice(&[-squeeze, squeeze]);
    let weight = 0.2 * 9.81;
    let mut pull = 0.0;
    for step in 0..20_000 {
        // Downwards, growing by 1 N/s after half a second of settling.
        pull = (f64::from(step) * 0.002 - 0.5).max(0.0);
        simulation.set_applied_force(block, [0.0, 0.0, -pull], [0.0; 3]);
        simulation.step();
        if simulation.body_velocity(block).1[2].abs() > 0.02 {
            break;
        }
    }
    pull + weight
}

#[test]
fn the_pull_at_which_a_grip_slips_is_linear_in_friction_and_in_squeeze() {
    let Some(engine) = common::engine() else {
        return;
    };
    for (friction, squeeze) in [(0.2, 20.0), (0.4, 20.0), (0.8, 20.0), (0.4, 10.0)] {
        // Coulomb: two pads, each holding friction times squeeze.
        let expected = 2.0 * friction * squeeze;
        let found = pull_at_slip(&engine, friction, squeeze);
        assert!(
            (found / expected - 1.0).abs() < 0.03,
            "{found} N instead of {expected} N"
        );
    }
}

/// A stone that slides and tips on the ground, under a changing force: contacts, friction, warm starts.
const STONE: &str = r#"<worldbody><geom type="plane" size="9 9 1"/><body name="stone" pos="0 0 0.12"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="3"/></body></worldbody>"#;

#[test]
fn a_saved_state_continues_bit_for_bit() {
    let Some(engine) = common::engine() else {
        return;
    };
    let mut simulation = compile(&engine, STONE);
    let stone = simulation.body("stone").expect("it was named");
    let run = |simulation: &mut Simulation| {
        for step in 0..300 {
            let push = f64::from(step) * 0.2;
            simulation.set_applied_force(stone, [push, 0.0, 0.0], [0.0; 3]);
            simulation.step();
        }
        let positions = simulation.positions().iter();
        positions.map(|it| it.to_bits()).collect::<Vec<_>>()
    };
    run(&mut simulation);
    let saved = simulation.save();
    let first = run(&mut simulation);
    assert!(simulation.restore(&saved));
    assert_eq!(run(&mut simulation), first);
    assert_ne!(run(&mut simulation), first, "it moves on");
    let mut other = compile(
        &engine,
        r#"<worldbody><body><freejoint/><geom size="1"/></body><body><joint/><geom size="1"/></body></worldbody>"#,
    );
    assert!(
        !other.restore(&saved),
        "a state of another model is refused"
    );
}
