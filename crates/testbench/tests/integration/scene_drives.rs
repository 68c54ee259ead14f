//! Drives, contact and people's arms of scenes against closed forms; robots from each language; numbers
//! that are drawn or set.

use crate::common;

use std::sync::Arc;

use stimulus::{Action, Setting, Settings, Stimulus};
use testbench::controller::{Controller, ControllerError, Description, Inputs, Outputs, Setup};
use testbench::scene::{ControllerData, SceneBench, SceneGap, mujoco};
use testbench::{Bench, Cancel, Savable, Unwatched};
use trace::Trace;

/// Commands what its settings say, `"actuator.field" = number`, from the first tick on.
struct Steady {
    description: Description,
    commands: Vec<(String, String, f64)>,
}

impl Controller for Steady {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn set_up(&mut self, setup: &Setup) -> Result<(), ControllerError> {
        let command = |(key, value): (&String, &serde_json::Value)| {
            let (actuator, field) = key.split_once('.')?;
            Some((actuator.to_owned(), field.to_owned(), value.as_f64()?))
        };
        self.commands = setup.settings.iter().filter_map(command).collect();
        Ok(())
    }

    fn tick(&mut self, _: &Inputs) -> Result<Outputs, ControllerError> {
        let commands = self.commands.iter();
        Ok(
            commands.fold(Outputs::default(), |outputs, (actuator, field, value)| {
                outputs.command(actuator, field, *value)
            }),
        )
    }
}

/// A rotor about the vertical and a slider along x on a fixed post: 0.5 kg m², 4 kg.
const ROTOR: &str = r#"<robot name="rotor">
  <link name="post"/>
  <link name="wheel"><inertial><mass value="1"/><inertia ixx="0.3" iyy="0.3" izz="0.5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="cart"><inertial><mass value="4"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="turn" type="continuous"><parent link="post"/><child link="wheel"/><axis xyz="0 0 1"/></joint>
  <joint name="rail" type="prismatic"><origin xyz="0 0 1"/><parent link="post"/><child link="cart"/><axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="99" velocity="9"/></joint>
</robot>"#;

/// A plate of 1 m on which things can lie.
const PLATE: &str = r#"<robot name="plate"><link name="plate">
  <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="1 1 0.1"/></geometry></collision></link></robot>"#;

/// A block of 10 kg and 0.5 kg m² about the vertical.
const BLOCK: &str = r#"<robot name="block"><link name="block">
  <inertial><mass value="10"/><inertia ixx="0.5" iyy="0.5" izz="0.5" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="0.4 0.4 0.2"/></geometry></collision></link></robot>"#;

/// The same slider in MJCF, with what scenes do not have.
const SLIDER: &str = r#"<mujoco model="slider"><worldbody>
  <body name="cart" pos="0 0 1">
    <joint name="rail" type="slide" axis="1 0 0"/>
    <geom name="cart" type="box" size="0.1 0.1 0.1" mass="4"/>
    <site name="hook"/>
    <body name="bob"><joint name="swing" axis="0 1 0" damping="1"/><geom type="sphere" size="0.05" pos="0 0 -0.3" mass="0.1"/></body>
  </body></worldbody>
  <tendon><fixed name="string"><joint joint="rail" coef="1"/><joint joint="swing" coef="-1"/></fixed></tendon>
  <equality><weld body1="cart" body2="bob"/><connect body1="bob" anchor="0 0 0"/></equality>
</mujoco>"#;

fn file(name: &str) -> Result<Vec<u8>, String> {
    let text = match name {
        "rotor.urdf" => ROTOR,
        "plate.urdf" => PLATE,
        "block.urdf" => BLOCK,
        "slider.xml" => SLIDER,
        "base.sdf" => include_str!("../../../robot-model/tests/data/base.sdf"),
        _ => return Err(format!("there is no {name}")),
    };
    Ok(text.into())
}

fn bench(scene: &str) -> Option<(SceneBench, Vec<SceneGap>)> {
    let engine = common::engine()?;
    let start = Arc::new(|_: &ControllerData| {
        let controller = Steady {
            description: Description::new("steady", "1"),
            commands: Vec::new(),
        };
        Ok(Box::new(controller) as Box<dyn Controller>)
    });
    let made = SceneBench::new(scene, &file, mujoco(&engine), start);
    Some(made.unwrap_or_else(|error| panic!("{error}")))
}

fn run(bench: &SceneBench, seed: u64, settings: &[(&str, f64)]) -> Trace {
    let mut stimulus = Stimulus::of(bench.tests()[0].clone());
    let settings = settings.iter();
    let settings = settings.map(|(key, value)| ((*key).to_owned(), Setting::Number(*value)));
    stimulus.settings = settings.collect::<Settings>();
    let recorded = bench.run(&stimulus, seed, &mut Unwatched, &Cancel::default());
    recorded.unwrap_or_else(|error| panic!("{error}")).trace
}

/// The value of a signal in the last row at or before a time.
fn at(trace: &Trace, name: &str, secs: f64) -> f64 {
    let index = trace.signal(name).unwrap_or_else(|| panic!("no {name}"));
    let channel = &trace.channels[index.channel];
    let rows = channel
        .times_secs
        .partition_point(|time| *time <= secs + 1e-9);
    channel.row(rows - 1)[index.field]
}

/// A scene of one robot, one drive and what it is told to do.
fn driven(file: &str, fixed: bool, joint: &str, drive: &str, command: &str) -> String {
    let recorded = if joint.is_empty() {
        String::new()
    } else {
        format!("recorded_joints = [\"{joint}\"]\n")
    };
    format!(
        r#"
        name = "driven"
        simulation = {{ duration_secs = 2.0, record_hz = 500, gravity_m_s2 = 0.0 }}
        abstract_test = [{{ name = "wait", actions = [] }}]
        [[robot]]
        name = "it"
        file = "{file}"
        fixed = {fixed}
        {recorded}
        [[actuator]]
        name = "drive"
        robot = "it"
        {drive}
        [[controller]]
        name = "steady"
        robot = "it"
        period_secs = 0.01
        settings = {{ {command} }}
        "#
    )
}

#[test]
fn an_effort_drive_accelerates_as_newton_says_and_no_more_than_its_limit() {
    let drive = "kind = \"effort\"\njoint = \"turn\"\nlimit = 1.0";
    for (effort_nm, felt_nm) in [(0.1, 0.1), (-0.3, -0.3), (5.0, 1.0)] {
        let command = format!("\"drive.effort\" = {effort_nm:?}");
        let Some((bench, _)) = bench(&driven("rotor.urdf", true, "turn", drive, &command)) else {
            return;
        };
        let trace = run(&bench, 1, &[]);
        // ω = τ t / I with I = 0.5 kg m²; the first step has begun before the command.
        let expected = felt_nm * 1.5 / 0.5;
        let omega = at(&trace, "/truth/it.turn.velocity", 1.5);
        assert!(
            (omega - expected).abs() < 0.005 * expected.abs(),
            "{omega} for {expected}"
        );
    }
}

#[test]
fn a_velocity_drive_approaches_its_speed_with_the_time_constant_of_mass_over_gain() {
    let drive = "kind = \"velocity\"\njoint = \"rail\"\ngain = 8.0\nlimit = 100.0";
    let scene = driven(
        "rotor.urdf",
        true,
        "rail",
        drive,
        "\"drive.velocity\" = 0.6",
    );
    let Some((bench, _)) = bench(&scene) else {
        return;
    };
    let trace = run(&bench, 1, &[]);
    for secs in [0.25, 0.5, 1.0, 2.0_f64] {
        // 4 kg over 8 N s/m: half a second.
        let expected = 0.6 * (1.0 - (-secs / 0.5).exp());
        let speed = at(&trace, "/truth/it.rail.velocity", secs);
        assert!((speed - expected).abs() < 0.006, "{speed} for {expected}");
    }
}

#[test]
fn a_position_drive_swings_and_settles_as_a_damped_spring() {
    let drive =
        "kind = \"position\"\njoint = \"rail\"\nstiffness = 400.0\ndamping = 80.0\nlimit = 1000.0";
    let scene = driven(
        "rotor.urdf",
        true,
        "rail",
        drive,
        "\"drive.position\" = 0.5",
    );
    let Some((bench, _)) = bench(&scene) else {
        return;
    };
    let trace = run(&bench, 1, &[]);
    // Critically damped at 10 rad/s: x = 0.5 (1 - (1 + 10 t) e^(-10 t)).
    for secs in [0.1, 0.2, 0.4, 1.9_f64] {
        let expected = 0.5 * (1.0 - (1.0 + 10.0 * secs) * (-10.0 * secs).exp());
        let x = at(&trace, "/truth/it.rail.position", secs);
        assert!((x - expected).abs() < 0.008, "{x} for {expected} at {secs}");
    }
}

#[test]
fn a_planar_drive_goes_where_the_base_faces_within_its_forces() {
    let drive = "kind = \"planar_velocity\"\nlongest_speed_m_s = 1.0\nlongest_turn_rate_rad_s = 1.0\ngain_ns_m = 20.0\nturn_gain_nms_rad = 1.0\nforce_limit_newtons = 5.0\ntorque_limit_nm = 5.0";
    let command = "\"drive.forward\" = 0.2, \"drive.left\" = 0.1";
    let scene = driven("block.urdf", false, "", drive, command).replace(
        "fixed = false",
        "fixed = false\nyaw_rad = 1.5707963267948966",
    );
    let Some((bench, _)) = bench(&scene) else {
        return;
    };
    let trace = run(&bench, 1, &[]);
    // Facing along y, so left is -x. 10 kg over 20 N s/m: half a second; below the limit of 5 N.
    let (x, y) = (
        at(&trace, "/truth/it.x", 2.0),
        at(&trace, "/truth/it.y", 2.0),
    );
    let way = 2.0 - 0.5 * (1.0 - (-4.0_f64).exp());
    assert!((y - 0.2 * way).abs() < 0.004, "{y} for {}", 0.2 * way);
    assert!((x + 0.1 * way).abs() < 0.004, "{x} for {}", -0.1 * way);
    // At full speed the force is at its limit at first: 0.5 m/s².
    let fast = scene.replace(
        "\"drive.forward\" = 0.2, \"drive.left\" = 0.1",
        "\"drive.forward\" = 9.0",
    );
    let Some((bench, _)) = self::bench(&fast) else {
        return;
    };
    let trace = run(&bench, 1, &[]);
    let speed = at(&trace, "/truth/it.speed", 1.0);
    assert!((speed - 0.5).abs() < 0.01, "{speed}");
}

/// A ball of 2 kg on a fixed plate that feels it; gravity is drawn.
const SCALES: &str = r#"
    name = "scales"
    simulation = { duration_secs = 2.0, gravity_m_s2 = { uniform = [9.0, 10.0] } }
    abstract_test = [{ name = "wait", actions = [] }]
    [[robot]]
    name = "plate"
    file = "plate.urdf"
    fixed = true
    [[object]]
    name = "ball"
    radius_m = 0.1
    mass_kg = 2
    z_m = 0.16
    [[sensor]]
    name = "scales"
    robot = "plate"
    kind = "contact"
    rate_hz = 50
"#;

#[test]
fn a_contact_sensor_weighs_what_lies_on_its_link_and_gravity_is_drawn_or_set() {
    let Some((bench, _)) = bench(SCALES) else {
        return;
    };
    let weight = |seed: u64, settings: &[(&str, f64)]| {
        let trace = run(&bench, seed, settings);
        assert_eq!(at(&trace, "/sensor/scales.touching", 0.0), 0.0);
        assert_eq!(at(&trace, "/sensor/scales.touching", 2.0), 1.0);
        at(&trace, "/sensor/scales.force", 2.0)
    };
    let (one, other) = (weight(1, &[]), weight(2, &[]));
    assert!((18.0..20.0).contains(&one) && (18.0..20.0).contains(&other));
    assert!(
        (one - other).abs() > 1e-3,
        "gravity is drawn for each episode"
    );
    assert_eq!(one.to_bits(), weight(1, &[]).to_bits());
    let set = weight(1, &[("simulation.gravity_m_s2", 4.0)]);
    assert!((set - 8.0).abs() < 0.01, "{set}");
    // Two thirds of the mass; and no ball on the plate is no touch.
    let light = weight(
        1,
        &[
            ("simulation.gravity_m_s2", 4.0),
            ("object.ball.mass_kg", 1.0),
        ],
    );
    assert!((light - 4.0).abs() < 0.01, "{light}");
}

#[test]
fn measurements_from_outside_stand_in_the_place_of_simulated_ones() {
    let Some((bench, _)) = bench(SCALES) else {
        return;
    };
    let stimulus = Stimulus::of(bench.tests()[0].clone());
    let cancel = Cancel::default();
    let mut running = bench.start(&stimulus, 1).expect("it starts");
    assert!(running.measure_outside("scale", None).is_err());
    assert!(
        running
            .measure_outside("scales", Some(vec![vec![1.0]]))
            .is_err()
    );
    running
        .measure_outside("scales", None)
        .expect("it is there");
    bench
        .advance(&mut running, 0.5, &mut Unwatched, &cancel)
        .expect("it goes on");
    running
        .measure_outside("scales", Some(vec![vec![1.0], vec![77.0]]))
        .expect("it fits");
    bench
        .advance(&mut running, 9.0, &mut Unwatched, &cancel)
        .expect("it goes on");
    let trace = bench.finish(running).expect("it ends").trace;
    let channel = trace
        .channels
        .iter()
        .find(|it| it.topic == "/sensor/scales");
    let channel = channel.expect("the sensor's topic");
    assert!(channel.times_secs[0] >= 0.5, "nothing was known before");
    assert!((channel.len() as i64 - 75).abs() <= 1, "{}", channel.len());
    assert!((0..channel.len()).all(|row| channel.row(row)[2..] == [1.0, 77.0]));
}

#[test]
fn keys_that_the_scene_knows_can_be_set_although_it_leaves_them_out() {
    let Some((bench, _)) = bench(SCALES) else {
        return;
    };
    // The ball begins above the plate's edge and falls past it.
    let trace = run(&bench, 1, &[("object.ball.x_m", 5.0)]);
    assert_eq!(at(&trace, "/sensor/scales.touching", 2.0), 0.0);
    let refused = |key: &str, value: f64| {
        let mut stimulus = Stimulus::of(bench.tests()[0].clone());
        stimulus
            .settings
            .insert(key.to_owned(), Setting::Number(value));
        let run = bench.run(&stimulus, 1, &mut Unwatched, &Cancel::default());
        run.expect_err(key).to_string()
    };
    assert!(refused("object.ball.x", 5.0).contains("object.ball.x"));
    assert!(refused("object.bal.x_m", 5.0).contains("ball"));
    assert!(refused("object.ball.friction", -1.0).contains("between 0 and 10"));
    let wrong = SCALES.replace("[9.0, 10.0]", "[9.0, 1000.0]");
    let start = Arc::new(|_: &ControllerData| {
        Err(ControllerError::Failed {
            message: "none".into(),
        })
    });
    let Some(engine) = common::engine() else {
        return;
    };
    let made = SceneBench::new(&wrong, &file, mujoco(&engine), start);
    let error = made
        .err()
        .map(|error| error.to_string())
        .unwrap_or_default();
    assert!(error.contains("gravity_m_s2"), "{error}");
}

#[test]
fn a_robot_of_sdf_drives_on_its_wheels_and_its_plugin_is_a_gap() {
    let scene = r#"
        name = "base"
        simulation = { duration_secs = 3.0 }
        ground = { friction = 1.0 }
        abstract_test = [{ name = "wait", actions = [] }]
        [[robot]]
        name = "it"
        file = "base.sdf"
        [[actuator]]
        name = "drive"
        robot = "it"
        kind = "differential_drive"
        left_joints = ["left_drive"]
        right_joints = ["right_drive"]
        wheel_radius_m = 0.08
        wheel_separation_m = 0.34
        longest_speed_m_s = 1.0
        longest_turn_rate_rad_s = 1.0
        acceleration_m_s2 = 0.5
        deceleration_m_s2 = 0.5
        turn_acceleration_rad_s2 = 1.0
        gain_nms_rad = 5.0
        torque_limit_nm = 10.0
        [[controller]]
        name = "steady"
        robot = "it"
        period_secs = 0.05
        settings = { "drive.speed" = 0.2, "drive.turn_rate" = 0.0 }
    "#;
    let Some((bench, gaps)) = bench(scene) else {
        return;
    };
    assert!(gaps.iter().any(|gap| gap.element.contains("plugin")));
    let trace = run(&bench, 1, &[]);
    let gone = at(&trace, "/truth/it.x", 3.0) - at(&trace, "/truth/it.x", 1.0);
    // The chassis drags on the floor behind the axle, so the wheels creep.
    assert!((0.36..0.41).contains(&gone), "{gone}");
}

#[test]
fn a_robot_of_mjcf_moves_by_its_joints_and_what_scenes_do_not_have_is_a_gap() {
    let drive = "kind = \"velocity\"\njoint = \"rail\"\ngain = 100.0\nlimit = 100.0";
    let scene = driven(
        "slider.xml",
        false,
        "rail",
        drive,
        "\"drive.velocity\" = 0.3",
    );
    let Some((bench, gaps)) = bench(&scene) else {
        return;
    };
    for missing in ["tendon", "weld", "connect"] {
        assert!(
            gaps.iter().any(|gap| gap.to_string().contains(missing)),
            "{missing}"
        );
    }
    let trace = run(&bench, 1, &[]);
    let speed = at(&trace, "/truth/it.rail.velocity", 2.0);
    assert!((speed - 0.3).abs() < 0.003, "{speed}");
}

#[test]
fn people_reach_and_withdraw_when_a_test_or_a_robot_makes_them() {
    let scene = r#"
        name = "arms"
        simulation = { duration_secs = 4.0, record_hz = 100, gravity_m_s2 = 0.0 }
        abstract_test = [{ name = "reach", actions = [{ set_param = { "anna.arms" = "reach" }, after_secs = 1.0 }] }]
        [[robot]]
        name = "plate"
        file = "plate.urdf"
        x_m = 0.9
        z_m = 1.35
        [[person]]
        name = "anna"
        body = "articulated"
        x_m = 0.0
        y_m = 0.0
        activity = "stand"
        arm_rate_rad_s = 1.0
        reach = { shoulder_rad = { uniform = [1.5, 1.6] }, elbow_rad = 0.0 }
        reaction = { kind = "goes_on", within_m = 0.5, delay_secs = 0.1, arms = "withdraw" }
    "#;
    let Some((bench, _)) = bench(scene) else {
        return;
    };
    assert_eq!(bench.tests()[0].actions.len(), 1);
    assert_ne!(
        bench.tests()[0].actions[0],
        Action::set("anna.arms", "carry")
    );
    let trace = run(&bench, 1, &[]);
    let hand = |axis: &str, secs: f64| at(&trace, &format!("/truth/anna.left_hand.{axis}"), secs);
    let (arm_m, shoulder_m) = ((0.186 + 0.254) * 1.75, 0.8 * 1.75);
    assert!(hand("x", 1.0) < 0.15 && hand("z", 1.0) < 0.75 * shoulder_m);
    // After a second and a half at 1 rad/s not there yet, after two it is; the arm is straight.
    assert!(hand("x", 1.7) < 0.75 * arm_m);
    assert!((hand("x", 3.5) - arm_m).abs() < 0.01, "{}", hand("x", 3.5));
    assert!((hand("z", 3.5) - shoulder_m).abs() < 0.1);
    // The plate is in the way of the hands, and feels them.
    let force =
        (100..400).map(|row| at(&trace, "/truth/plate.person_force", f64::from(row) / 100.0));
    assert!(force.fold(0.0, f64::max) > 0.0);
    // A robot that is near makes her withdraw, whatever the test says.
    let near = run(
        &bench,
        1,
        &[("robot.plate.x_m", 0.2), ("robot.plate.z_m", 2.5)],
    );
    assert_eq!(at(&near, "/truth/anna.reacting", 3.5), 1.0);
    let back = at(&near, "/truth/anna.left_hand.x", 3.5);
    assert!(back < 0.4 * arm_m, "{back}");
}
