//! A small scene that confirms, on the loaded library, every byte offset of [`super::layout`].
//!
//! A ball rests on a plane beside a mocap body. Each field read through an offset is compared with
//! what MuJoCo's own functions report, or with physics: the contact must name the ball and the
//! plane and carry the ball's weight.

use super::layout::state;
use super::{Engine, EngineError, Simulation};

/// The scene: a 2 kg ball of 0.1 m radius on a plane, a servo on a pendulum, a mocap body.
const SCENE: &str = r#"<mujoco>
  <option timestep="0.002" gravity="0 0 -9.81"/>
  <worldbody>
    <geom name="ground" type="plane" size="1 1 0.1"/>
    <body name="ball" pos="0.3 -0.2 0.0999"><freejoint/><geom name="shell" type="sphere" size="0.1" mass="2"/></body>
    <body name="bob" pos="0 0 2"><joint name="swing" axis="0 1 0"/><site name="held"/><geom type="sphere" pos="0 0 -0.3" size="0.05" mass="1" contype="0" conaffinity="0"/></body>
    <body name="target" mocap="true" pos="1 2 3"/>
  </worldbody>
  <actuator><position joint="swing" kp="1" forcerange="-7 9"/></actuator>
  <sensor><force site="held"/></sensor>
</mujoco>"#;

/// Runs the check.
///
/// # Errors
/// [`EngineError::SelfCheck`] naming the first field that disagrees.
pub(super) fn run(engine: &Engine) -> Result<(), EngineError> {
    let mut simulation = engine.compile(SCENE)?;
    check_inputs(&mut simulation)?;
    for _ in 0..400 {
        simulation.step();
    }
    check_state(&simulation)?;
    check_frames(&simulation)?;
    check_queries(&mut simulation)?;
    check_contact(&simulation)?;
    check_sensors(&simulation)?;
    check_drives(&mut simulation)
}

/// Turns a comparison into the check's error.
fn require(holds: bool, what: &'static str) -> Result<(), EngineError> {
    if holds {
        Ok(())
    } else {
        Err(EngineError::SelfCheck { what })
    }
}

/// Writes through offsets, reads back through MuJoCo.
fn check_inputs(simulation: &mut Simulation) -> Result<(), EngineError> {
    require(
        simulation.controls_mut().len() == 1,
        "the number of actuators",
    )?;
    simulation.controls_mut()[0] = 0.125;
    require(simulation.state(state::CTRL) == [0.125], "ctrl")?;
    // The ball's six velocities come first, then the pendulum's.
    simulation.joint_forces_mut()[6] = 0.25;
    simulation.warm_start_mut()[6] = 0.5;
    let seventh = |bits| simulation.state(bits).get(6).copied();
    require(seventh(state::QFRC_APPLIED) == Some(0.25), "qfrc_applied")?;
    require(seventh(state::WARMSTART) == Some(0.5), "qacc_warmstart")?;
    simulation.joint_forces_mut()[6] = 0.0;
    simulation.set_mocap(0, [1.5, 2.5, 3.5], [0.0, 1.0, 0.0, 0.0]);
    require(
        simulation.state(state::MOCAP_POS) == [1.5, 2.5, 3.5],
        "mocap_pos",
    )?;
    require(
        simulation.state(state::MOCAP_QUAT) == [0.0, 1.0, 0.0, 0.0],
        "mocap_quat",
    )?;
    let bob = simulation
        .body("bob")
        .ok_or(EngineError::SelfCheck { what: "mj_name2id" })?;
    simulation.set_applied_force(bob, [1.0, 2.0, 3.0], [4.0, 5.0, 6.0]);
    let applied = simulation.state(state::XFRC_APPLIED);
    require(
        applied
            .windows(6)
            .any(|window| window == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]),
        "xfrc_applied",
    )?;
    simulation.set_applied_force(bob, [0.0; 3], [0.0; 3]);
    Ok(())
}

/// Reads time, positions and velocities both ways.
fn check_state(simulation: &Simulation) -> Result<(), EngineError> {
    require((simulation.time_secs() - 0.8).abs() < 1e-9, "time")?;
    require(
        simulation.state(state::TIME) == [simulation.time_secs()],
        "time",
    )?;
    require(
        simulation.state(state::QPOS) == simulation.positions(),
        "qpos",
    )?;
    require(
        simulation.state(state::QVEL) == simulation.velocities(),
        "qvel",
    )?;
    require(simulation.warning_count() == 0, "warning")
}

/// The ball's frame follows from its joint, the mocap body's from its input.
fn check_frames(simulation: &Simulation) -> Result<(), EngineError> {
    let missing = EngineError::SelfCheck { what: "mj_name2id" };
    let target = simulation.body("target").ok_or_else(|| missing.clone())?;
    require(simulation.body_position(target) == [1.5, 2.5, 3.5], "xpos")?;
    require(
        simulation.body_quaternion(target) == [0.0, 1.0, 0.0, 0.0],
        "xquat",
    )?;
    let ball = simulation.body("ball").ok_or(missing)?;
    let height = simulation.body_position(ball)[2];
    require((height - simulation.positions()[2]).abs() < 1e-4, "xpos")?;
    let (_, velocity) = simulation.body_velocity(ball);
    require(
        (velocity[2] - simulation.velocities()[2]).abs() < 1e-3,
        "mj_objectVelocity",
    )
}

/// The pendulum's joint comes after the ball's free joint; rays and distances meet the ball.
fn check_queries(simulation: &mut Simulation) -> Result<(), EngineError> {
    let missing = EngineError::SelfCheck { what: "mj_name2id" };
    let swing = simulation.joint("swing").ok_or_else(|| missing.clone())?;
    require(swing.position_index() == 7, "jnt_qposadr")?;
    require(swing.velocity_index() == 6, "jnt_dofadr")?;
    let (ball, shell) = (simulation.body("ball"), simulation.geom("shell"));
    let (Some(ball), Some(shell), Some(ground)) = (ball, shell, simulation.geom("ground")) else {
        return Err(missing);
    };
    // The ball of 2 kg is free: half a unit of acceleration for each of force.
    let weights = simulation.body_inverse_weights(ball);
    require((weights[0] - 0.5).abs() < 1e-9, "body_invweight0")?;
    let weights = simulation.joint_inverse_weights();
    require(
        weights.len() == 7 && (weights[0] - 0.5).abs() < 1e-9,
        "dof_invweight0",
    )?;
    let [x, y, z] = simulation.body_position(ball);
    let down = [0.0, 0.0, -1.0];
    let hit = simulation.ray([x, y, z + 1.0], down, None);
    require(
        hit.is_some_and(|hit| hit.geom == shell && (hit.distance_m - 0.9).abs() < 1e-9),
        "mj_ray",
    )?;
    let beyond = simulation.ray([x, y, z + 1.0], down, Some(ball));
    require(beyond.is_some_and(|hit| hit.geom == ground), "mj_ray")?;
    let depth = simulation.geom_distance(ground, shell, 1.0);
    require((depth - (z - 0.1)).abs() < 1e-6, "mj_geomDistance")
}

/// The contact carries the ball's weight.
fn check_contact(simulation: &Simulation) -> Result<(), EngineError> {
    let ball = simulation.body("ball");
    let ball = ball.ok_or(EngineError::SelfCheck { what: "mj_name2id" })?;
    let contacts: Vec<_> = simulation.contacts().collect();
    require(contacts.len() == 1, "ncon")?;
    let geoms = [simulation.geom("ground"), simulation.geom("shell")];
    require(contacts[0].geoms.map(Some) == geoms, "contact.geom")?;
    require(
        contacts[0].distance_m < 0.0 && contacts[0].distance_m > -0.01,
        "contact.dist",
    )?;
    let [x, y, _] = simulation.body_position(ball);
    let [at_x, at_y, at_z] = contacts[0].point_m;
    require(
        (at_x - x).abs() < 1e-6 && (at_y - y).abs() < 1e-6 && at_z.abs() < 0.01,
        "contact.pos",
    )?;
    require(contacts[0].normal == [0.0, 0.0, 1.0], "contact.frame")?;
    require(
        (contacts[0].normal_newtons - 2.0 * 9.81).abs() < 0.05,
        "mj_contactForce",
    )
}

/// The pendulum hardly swings: what holds it bears its weight of 1 kg, upwards.
fn check_sensors(simulation: &Simulation) -> Result<(), EngineError> {
    let readings = simulation.sensor_readings();
    require(readings.len() == 3, "nsensordata")?;
    require((readings[2] - 9.81).abs() < 0.1, "sensordata")
}

/// The servo has its gains and its limits, a share of them when it is made weak, and all of them again.
fn check_drives(simulation: &mut Simulation) -> Result<(), EngineError> {
    let whole = simulation.drives();
    require(whole.len() == 1, "the number of actuators")?;
    let is = |numbers: [f64; 10], first: [f64; 3]| {
        numbers[..3] == first && numbers[3..].iter().all(|number| *number == 0.0)
    };
    require(is(whole[0].gains, [1.0, 0.0, 0.0]), "actuator_gainprm")?;
    require(is(whole[0].biases, [0.0, -1.0, 0.0]), "actuator_biasprm")?;
    require(whole[0].force_range == [-7.0, 9.0], "actuator_forcerange")?;
    let is_set = simulation.set_drive(0, &whole[0].of_strength(0.5));
    let weak = simulation.drives();
    let has_half = weak[0].gains[0] == 0.5 && weak[0].force_range == [-3.5, 4.5];
    require(is_set && has_half, "actuator_gainprm")?;
    simulation.set_drive(0, &whole[0]);
    require(simulation.drives() == whole, "actuator_gainprm")
}
