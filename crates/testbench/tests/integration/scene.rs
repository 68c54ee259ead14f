//! Scenes against closed forms: what sensors measure, how drives brake, what faults do; and that an
//! episode is the same bits whenever and wherever it runs.

use crate::common;

use std::sync::Arc;

use stimulus::{Action, Setting, Stimulus};
use testbench::controller::{
    Controller, ControllerError, Description, Field, Inputs, Outputs, Setup,
};
use testbench::physics::{MujocoPhysics, Physics};
use testbench::scene::{ControllerData, SceneBench, mujoco};
use testbench::{Bench, Cancel, End, Recorded, Savable, SimError, Status, Unwatched};
use trace::Trace;

/// Drives at a speed for a while, then brakes; says when it begins to brake.
struct Driver {
    description: Description,
    speed_m_s: f64,
    brake_secs: f64,
}

impl Driver {
    fn new() -> Self {
        let mut description = Description::new("driver", "1");
        description.sends = vec!["braking".to_owned()];
        description.receives = vec!["halt".to_owned()];
        description.reports = vec![Field::bool("halted")];
        Self {
            description,
            speed_m_s: 0.0,
            brake_secs: 0.0,
        }
    }
}

impl Controller for Driver {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn set_up(&mut self, setup: &Setup) -> Result<(), ControllerError> {
        let setting = |name: &str| setup.settings.get(name).and_then(serde_json::Value::as_f64);
        self.speed_m_s = setting("speed_m_s").unwrap_or(0.0);
        self.brake_secs = setting("brake_secs").unwrap_or(f64::INFINITY);
        Ok(())
    }

    fn tick(&mut self, inputs: &Inputs) -> Result<Outputs, ControllerError> {
        if inputs.messages.iter().any(|message| message.name == "halt") {
            self.brake_secs = inputs.time_secs;
        }
        let brakes = inputs.time_secs >= self.brake_secs;
        let speed_m_s = if brakes { 0.0 } else { self.speed_m_s };
        let mut outputs = Outputs::default()
            .command("drive", "speed", speed_m_s)
            .command("drive", "turn_rate", 0.0);
        if brakes {
            outputs.messages.push("braking".to_owned());
        }
        outputs
            .reports
            .insert("halted".to_owned(), f64::from(u8::from(brakes)));
        Ok(outputs)
    }
}

/// A carrier in a square room of 6 m, without anything random.
const ROOM: &str = r#"
    name = "room"
    simulation = { duration_secs = 6.0 }
    ground = { friction = 0.8 }
    [[abstract_test]]
    name = "nothing"
    actions = []
    [[robot]]
    name = "carrier"
    file = "carrier.urdf"
    friction = 0.8
    [[object]]
    name = "east"
    box_m = [0.2, 6.4, 2.0]
    x_m = 3.1
    z_m = 1.0
    [[object]]
    name = "west"
    box_m = [0.2, 6.4, 2.0]
    x_m = -3.1
    z_m = 1.0
    [[object]]
    name = "north"
    box_m = [6.0, 0.2, 2.0]
    y_m = 3.1
    z_m = 1.0
    [[object]]
    name = "south"
    box_m = [6.0, 0.2, 2.0]
    y_m = -3.1
    z_m = 1.0
    [[actuator]]
    name = "drive"
    robot = "carrier"
    kind = "differential_drive"
    left_joints = ["left_wheel_joint"]
    right_joints = ["right_wheel_joint"]
    wheel_radius_m = 0.1
    wheel_separation_m = 0.44
    longest_speed_m_s = 2.0
    longest_turn_rate_rad_s = 1.5
    acceleration_m_s2 = 0.5
    deceleration_m_s2 = 1.25
    turn_acceleration_rad_s2 = 3.0
    gain_nms_rad = 5.0
    torque_limit_nm = 20.0
    [[controller]]
    name = "driver"
    robot = "carrier"
    period_secs = 0.05
    settings = { speed_m_s = 0.0, brake_secs = 1000.0 }
"#;

fn bench(more: &str) -> Option<SceneBench> {
    let engine = common::engine()?;
    let folder = common::root().join("case-studies/corridor/simulation");
    let read = move |file: &str| std::fs::read(folder.join(file)).map_err(|e| e.to_string());
    let start = Arc::new(|_: &ControllerData| Ok(Box::new(Driver::new()) as Box<dyn Controller>));
    let made = SceneBench::new(&format!("{ROOM}{more}"), &read, mujoco(&engine), start);
    Some(made.unwrap().0)
}

fn stimulus(bench: &SceneBench, settings: &[(&str, Setting)]) -> Stimulus {
    let mut stimulus = Stimulus::of(bench.tests()[0].clone());
    for (key, value) in settings {
        stimulus.settings.insert((*key).to_owned(), value.clone());
    }
    stimulus
}

fn run(bench: &SceneBench, seed: u64, settings: &[(&str, Setting)]) -> Recorded {
    let stimulus = stimulus(bench, settings);
    bench
        .run(&stimulus, seed, &mut Unwatched, &Cancel::default())
        .unwrap()
}

/// All numbers of a recording.
fn bits(trace: &Trace) -> Vec<u64> {
    let rows = trace.channels.iter();
    rows.flat_map(|channel| (0..channel.len()).flat_map(|row| channel.row(row).to_vec()))
        .map(f64::to_bits)
        .collect()
}

/// The times and values of a signal.
fn signal(trace: &Trace, name: &str) -> Vec<(f64, f64)> {
    let index = trace.signal(name).unwrap_or_else(|| panic!("no {name}"));
    let channel = &trace.channels[index.channel];
    let times = channel.times_secs.iter().enumerate();
    times
        .map(|(row, time)| (*time, channel.row(row)[index.field]))
        .collect()
}

const LIDAR: &str = r#"
    [[sensor]]
    name = "lidar"
    robot = "carrier"
    kind = "lidar"
    rate_hz = 10
    x_m = 0.2
    z_m = 0.3
    rays = 37
    first_angle_rad = -1.5707963267948966
    last_angle_rad = 1.5707963267948966
    longest_m = 10.0
    record_all = true
"#;

#[test]
fn a_lidar_in_a_square_room_measures_the_walls() {
    let Some(bench) = bench(LIDAR) else { return };
    let trace = run(&bench, 1, &[]).trace;
    let x = signal(&trace, "/truth/carrier.x");
    for ray in 0..37 {
        let angle = -std::f64::consts::FRAC_PI_2 + std::f64::consts::PI / 36.0 * f64::from(ray);
        // From (0.2, 0) to the wall at x = 3 or at y = ±3, whichever the ray meets first.
        let expected = (2.8 / angle.cos().max(1e-12)).min(3.0 / angle.sin().abs().max(1e-12));
        let ranges = signal(&trace, &format!("/sensor/lidar.ranges.{ray}"));
        let (_, range) = ranges[ranges.len() - 1];
        // The robot settles on its wheels by less than a millimetre.
        assert!(
            (range - expected).abs() < 2e-3,
            "ray {ray}: {range} for {expected}, x {:?}",
            x[0]
        );
    }
}

#[test]
fn braking_takes_the_distance_that_the_deceleration_gives() {
    let Some(bench) = bench("") else { return };
    let settings = [
        ("controller.driver.settings.speed_m_s", Setting::Number(1.0)),
        (
            "controller.driver.settings.brake_secs",
            Setting::Number(3.0),
        ),
        ("robot.carrier.xm", Setting::Number(-2.5)),
    ];
    // A setting needs a key that the scene knows.
    let error = bench.run(
        &stimulus(&bench, &settings),
        1,
        &mut Unwatched,
        &Cancel::default(),
    );
    assert!(matches!(error, Err(SimError::Stimulus { .. })));
    let trace = run(&bench, 1, &settings[..2]).trace;
    let x = signal(&trace, "/truth/carrier.x");
    let speed = signal(&trace, "/truth/carrier.speed");
    let at = |secs: f64| x.iter().find(|(time, _)| *time >= secs - 1e-9).unwrap().1;
    let cruising = speed.iter().find(|(time, _)| *time >= 2.9).unwrap().1;
    // Damping of the wheels and creep of their contacts cost some of it.
    assert!((0.97..1.0).contains(&cruising), "{cruising}");
    // At 0.5 m/s²: 2 s and 1 m, then 1 s at that speed.
    let expected = 1.0 + cruising;
    assert!((at(3.0) - expected).abs() < 0.04, "{}", at(3.0));
    // Braking at 1.25 m/s².
    let braking = cruising.powi(2) / (2.0 * 1.25);
    assert!(
        (at(5.0) - at(3.0) - braking).abs() < 0.02,
        "{}",
        at(5.0) - at(3.0)
    );
}

#[test]
fn odometry_agrees_with_the_truth_while_wheels_do_not_slip_and_an_imu_feels_gravity() {
    let sensors = r#"
        [[sensor]]
        name = "odometry"
        robot = "carrier"
        kind = "odometry"
        rate_hz = 50
        left_joints = ["left_wheel_joint"]
        right_joints = ["right_wheel_joint"]
        wheel_radius_m = 0.1
        wheel_separation_m = 0.44
        [[sensor]]
        name = "imu"
        robot = "carrier"
        kind = "imu"
        rate_hz = 100
    "#;
    let Some(bench) = bench(sensors) else { return };
    let settings = [
        ("controller.driver.settings.speed_m_s", Setting::Number(0.5)),
        (
            "controller.driver.settings.brake_secs",
            Setting::Number(4.0),
        ),
    ];
    let trace = run(&bench, 1, &settings).trace;
    let (_, reckoned) = *signal(&trace, "/sensor/odometry.x").last().unwrap();
    let (_, truth) = *signal(&trace, "/truth/carrier.x").last().unwrap();
    assert!(
        (reckoned - truth).abs() < 0.01 * truth,
        "{reckoned} {truth}"
    );
    let mean = |axis: u8, from: f64, to: f64| {
        let values = signal(&trace, &format!("/sensor/imu.acceleration.{axis}"));
        let within: Vec<f64> = values
            .iter()
            .filter(|(time, _)| (from..to).contains(time))
            .map(|(_, value)| *value)
            .collect();
        within.iter().sum::<f64>() / within.len() as f64
    };
    assert!((mean(2, 1.5, 3.5) - 9.81).abs() < 0.01);
    // Speeding up at 0.5 m/s² for a second.
    assert!(
        (mean(0, 0.2, 0.9) - 0.5).abs() < 0.03,
        "{}",
        mean(0, 0.2, 0.9)
    );
}

#[test]
fn faults_latency_and_dropout_do_what_they_say() {
    let more = r#"
        [[sensor]]
        name = "late"
        robot = "carrier"
        kind = "pose"
        rate_hz = 50
        latency_secs = 0.1
        dropout_probability = 0.25
        [[sensor]]
        name = "noisy"
        robot = "carrier"
        kind = "pose"
        rate_hz = 50
        noise = { x_m = 0.1 }
        bias = { y_m = 0.5 }
        [[sensor.fault]]
        kind = "stuck"
        from_secs = 2.0
        until_secs = 3.0
        [[sensor.fault]]
        kind = "silent"
        from_secs = 4.0
    "#;
    let Some(bench) = bench(more) else { return };
    let trace = run(&bench, 3, &[]).trace;
    let late = signal(&trace, "/sensor/late.measured_at");
    for (arrived, measured) in &late {
        assert!((arrived - measured - 0.1).abs() < 1e-9);
    }
    // 295 measurements could arrive; 5 standard deviations of a binomial are 37.
    assert!(
        (late.len() as f64 - 0.75 * 295.0).abs() < 37.0,
        "{}",
        late.len()
    );
    let noisy = signal(&trace, "/sensor/noisy.x");
    assert!(noisy.iter().all(|(time, _)| *time < 4.0));
    let stuck: Vec<f64> = noisy
        .iter()
        .filter(|(time, _)| (2.0..3.0).contains(time))
        .map(|(_, x)| *x)
        .collect();
    assert!(stuck.len() == 50 && stuck.iter().all(|x| x.to_bits() == stuck[0].to_bits()));
    let free: Vec<f64> = noisy.iter().take(100).map(|(_, x)| *x).collect();
    let mean = free.iter().sum::<f64>() / 100.0;
    let deviation = (free.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 99.0).sqrt();
    // Five standard errors of a standard deviation from 100 numbers: 0.1 * 5 / sqrt(198).
    assert!((deviation - 0.1).abs() < 0.036, "{deviation}");
    let biased = signal(&trace, "/sensor/noisy.y");
    assert!((biased[10].1 - 0.5).abs() < 1e-3);
}

const PEOPLE: &str = r#"
    [[person]]
    name = "anna"
    body = "articulated"
    x_m = 2.0
    y_m = { uniform = [-0.5, 0.5] }
    speed_m_s = { uniform = [0.5, 1.0] }
    waypoint = [{ x_m = 2.0, y_m = 2.0 }]
    [[person]]
    name = "ben"
    x_m = -2.0
    y_m = 0.0
    activity = "stand"
    [[sensor]]
    name = "watch"
    robot = "carrier"
    kind = "person_detector"
    rate_hz = 10
    x_m = 0.3
    z_m = 0.9
    field_of_view_rad = 2.0
    longest_m = 5.0
"#;

#[test]
fn a_person_detector_sees_who_is_ahead_and_not_who_is_behind() {
    let Some(bench) = bench(PEOPLE) else { return };
    let stand = [("person.anna.speed_m_s", Setting::Number(0.0))];
    let trace = run(&bench, 5, &stand).trace;
    let (_, seen) = *signal(&trace, "/sensor/watch.seen").last().unwrap();
    let (_, distance) = *signal(&trace, "/sensor/watch.distance").last().unwrap();
    let (_, y) = *signal(&trace, "/truth/anna.y").last().unwrap();
    assert_eq!(seen, 1.0);
    assert!((distance - 1.7_f64.hypot(y)).abs() < 0.01, "{distance}");
    // A board between them hides her.
    let board = format!(
        "{PEOPLE}\n[[object]]\nname = \"board\"\nbox_m = [0.05, 3.0, 2.0]\nx_m = 1.0\nz_m = 1.0\n"
    );
    let hidden = run(&self::bench(&board).unwrap(), 5, &stand).trace;
    let (_, seen) = *signal(&hidden, "/sensor/watch.seen").last().unwrap();
    assert_eq!(seen, 0.0);
}

#[test]
fn the_same_seed_gives_the_same_bits_on_any_thread_and_others_differ() {
    let Some(bench) = bench(&format!("{PEOPLE}{LIDAR}")) else {
        return;
    };
    let first = run(&bench, 11, &[]).trace;
    let others: Vec<Trace> = std::thread::scope(|scope| {
        let runs: Vec<_> = (0..3)
            .map(|_| scope.spawn(|| run(&bench, 11, &[]).trace))
            .collect();
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    assert!(others.iter().all(|other| bits(other) == bits(&first)));
    assert_ne!(bits(&run(&bench, 12, &[]).trace), bits(&first));
    // What is set to what would have been drawn leaves everything else as it is.
    let y = signal(&first, "/truth/anna.y")[0].1;
    let set = run(&bench, 11, &[("person.anna.y_m", Setting::Number(y))]).trace;
    assert_eq!(bits(&set), bits(&first));
}

#[test]
fn a_test_sends_waits_and_sets_and_what_it_cannot_do_is_refused() {
    let Some(bench) = bench(PEOPLE) else { return };
    let mut stimulus = stimulus(
        &bench,
        &[("controller.driver.settings.speed_m_s", Setting::Number(0.3))],
    );
    stimulus.test.actions = vec![
        Action::receive("anna.arrived"),
        Action::send("halt"),
        Action::receive("braking"),
        Action::set("ben.activity", "approach"),
    ];
    let cancel = Cancel::default();
    let recorded = bench.run(&stimulus, 2, &mut Unwatched, &cancel).unwrap();
    assert_eq!(recorded.end, End::Over);
    let trace = &recorded.trace;
    let when = |name: &str| {
        let values = signal(trace, name);
        values
            .iter()
            .find(|(_, value)| *value == 1.0)
            .map(|(time, _)| *time)
    };
    let (arrived, halted) = (
        when("/truth/anna.arrived").unwrap(),
        when("/controller/driver.halted"),
    );
    assert!((0.0..=0.1).contains(&(halted.unwrap() - arrived)));
    assert_eq!(
        when("/test.done").map(|time| time >= halted.unwrap()),
        Some(true)
    );
    let walked = signal(trace, "/truth/ben.speed");
    assert!(walked.iter().any(|(_, speed)| *speed > 0.5));
    assert_eq!(walked[0].1, 0.0);
    stimulus.test.actions = vec![Action::send("jump")];
    let refused = bench
        .run(&stimulus, 2, &mut Unwatched, &cancel)
        .unwrap_err();
    assert!(
        refused.to_string().contains("they receive halt"),
        "{refused}"
    );
}

#[test]
fn a_saved_state_of_physics_answers_and_goes_on_bit_for_bit() {
    let (Some(bench), Some(engine)) = (bench(""), common::engine()) else {
        return;
    };
    let layout = bench.layout_of(1).unwrap();
    let mut physics = MujocoPhysics::new(&engine, &layout).unwrap();
    let drive = |physics: &mut MujocoPhysics| {
        physics.set_drive(0, 5.0);
        physics.set_drive(1, 4.0);
        (0..300).for_each(|_| physics.step());
    };
    let look = |physics: &MujocoPhysics| {
        let mut touches = Vec::new();
        physics.touches(&mut touches);
        let ray = physics.ray([0.0, 0.0, 1.5], [1.0, 0.0, 0.0], 10.0, &|_| true);
        (physics.body_pose(0), physics.body_twist(0), touches, ray)
    };
    drive(&mut physics);
    let saved = physics.save();
    let there = look(&physics);
    drive(&mut physics);
    let later = look(&physics);
    assert_ne!(there, later);
    assert!(!later.2.is_empty() && later.3.is_some());
    assert!(physics.restore(&saved));
    assert_eq!(look(&physics), there);
    drive(&mut physics);
    assert_eq!(look(&physics), later);
}

#[test]
fn a_saved_episode_goes_on_bit_for_bit_and_with_a_new_seed_otherwise() {
    let noise = LIDAR.replace("record_all = true", "noise = { ranges_m = 0.02 }");
    let Some(bench) = bench(&format!("{PEOPLE}{noise}")) else {
        return;
    };
    let stimulus = stimulus(
        &bench,
        &[("controller.driver.settings.speed_m_s", Setting::Number(0.3))],
    );
    let cancel = Cancel::default();
    let go_on = |mut running| {
        let status = bench.advance(&mut running, f64::INFINITY, &mut Unwatched, &cancel);
        assert_eq!(status.unwrap(), Status::Ended(End::Over));
        bench.finish(running).unwrap().trace
    };
    let mut running = bench.start(&stimulus, 4).unwrap();
    let status = bench.advance(&mut running, 2.5, &mut Unwatched, &cancel);
    assert_eq!(status.unwrap(), Status::Running);
    assert!((bench.now_secs(&running) - 2.5).abs() < 1e-9);
    let saved = bench.save(&running).unwrap();
    let until_now = bits(bench.so_far(&running));
    let uninterrupted = bench
        .run(&stimulus, 4, &mut Unwatched, &cancel)
        .unwrap()
        .trace;
    assert_eq!(bits(&go_on(running)), bits(&uninterrupted));
    let resumed = bench.resume(&saved, None).unwrap();
    assert_eq!(bits(bench.so_far(&resumed)), until_now);
    assert_eq!(bits(&go_on(resumed)), bits(&uninterrupted));
    let anew = go_on(bench.resume(&saved, Some(9)).unwrap());
    let nearest = |trace: &Trace| signal(trace, "/sensor/lidar.ranges.nearest");
    let (one, other) = (nearest(&uninterrupted), nearest(&anew));
    let differs = |row: &usize| one[*row] != other[*row];
    assert_eq!(
        (0..one.len()).find(differs),
        Some(25),
        "from 2.5 s on at 10 Hz"
    );
}

/// Answers with how often it was ever asked, over all episodes of the process.
struct Forgetful(Driver, Arc<std::sync::atomic::AtomicU64>);

impl Controller for Forgetful {
    fn describe(&self) -> &Description {
        self.0.describe()
    }

    fn set_up(&mut self, setup: &Setup) -> Result<(), ControllerError> {
        self.0.set_up(setup)
    }

    fn tick(&mut self, _: &Inputs) -> Result<Outputs, ControllerError> {
        let count = self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        Ok(Outputs::default().command("drive", "speed", count as f64 * 1e-6))
    }
}

#[test]
fn a_controller_that_answers_otherwise_each_time_cannot_be_continued() {
    let Some(engine) = common::engine() else {
        return;
    };
    let folder = common::root().join("case-studies/corridor/simulation");
    let read = move |file: &str| std::fs::read(folder.join(file)).map_err(|e| e.to_string());
    let count = Arc::new(std::sync::atomic::AtomicU64::new(0));
    let start = Arc::new(move |_: &ControllerData| {
        let controller = Forgetful(Driver::new(), Arc::clone(&count));
        Ok(Box::new(controller) as Box<dyn Controller>)
    });
    let (bench, _) = SceneBench::new(ROOM, &read, mujoco(&engine), start).unwrap();
    let mut running = bench.start(&stimulus(&bench, &[]), 1).unwrap();
    let cancel = Cancel::default();
    bench
        .advance(&mut running, 1.0, &mut Unwatched, &cancel)
        .unwrap();
    let saved = bench.save(&running).unwrap();
    let error = bench.resume(&saved, None).err().unwrap().to_string();
    assert!(error.contains("answers otherwise"), "{error}");
}

#[test]
fn what_is_wrong_in_a_scene_is_said_with_its_key() {
    let Some(engine) = common::engine() else {
        return;
    };
    let error = |more: &str, change: [&str; 2]| {
        let folder = common::root().join("case-studies/corridor/simulation");
        let read = move |file: &str| std::fs::read(folder.join(file)).map_err(|e| e.to_string());
        let start =
            Arc::new(|_: &ControllerData| Ok(Box::new(Driver::new()) as Box<dyn Controller>));
        let text = format!("{ROOM}{more}").replace(change[0], change[1]);
        let made = SceneBench::new(&text, &read, mujoco(&engine), start);
        made.err()
            .map(|error| error.to_string())
            .unwrap_or_default()
    };
    for (more, change, expected) in [
        ("", ["carrier.urdf", "carier.urdf"], "carier.urdf"),
        ("", ["duration_secs = 6.0", "duration = 6.0"], "duration"),
        (
            "",
            ["\"left_wheel_joint\"", "\"left_wheel\""],
            "actuator.drive.joint",
        ),
        (
            "",
            [
                "robot = \"carrier\"\n    kind",
                "robot = \"carier\"\n    kind",
            ],
            "actuator.drive.robot",
        ),
        (
            "",
            ["period_secs = 0.05", "period_secs = 0.0501"],
            "must be a whole number of time steps",
        ),
        ("", ["friction = 0.8", "friction = -0.8"], "ground.friction"),
        ("", ["name = \"east\"", "name = \"west\""], "is used twice"),
        (LIDAR, ["rays = 37", "rays = 0"], "sensor.lidar.rays"),
        (
            LIDAR,
            ["rate_hz = 10", "rate_hz = 10\nnoise = { ranges = 0.1 }"],
            "may be one of ranges_m",
        ),
        (LIDAR, ["rate_hz = 10", "rate_hz = 10\nrange = 1"], "range"),
        (
            LIDAR,
            ["z_m = 0.3", "link = \"mast\"\nz_m = 0.3"],
            "sensor.lidar.link",
        ),
        (
            PEOPLE,
            [
                "speed_m_s = { uniform = [0.5, 1.0] }",
                "speed_m_s = { normal = [0.5, 1.0] }",
            ],
            "person.anna.speed_m_s",
        ),
    ] {
        let said = error(more, change);
        assert!(said.contains(expected), "{change:?}: {said}");
    }
}

#[test]
fn with_its_draws_as_settings_an_episode_is_the_same() {
    let more = r#"
        [[person]]
        name = "ann"
        x_m = { uniform = [1.5, 2.5] }
        y_m = { normal = [0.0, 0.2], low = -1.0, high = 1.0 }
        speed_m_s = { uniform = [0.5, 1.0] }
        waypoint = [{ x_m = -2.0, y_m = { uniform = [-0.5, 0.5] } }]
        [[sensor]]
        name = "lidar"
        robot = "carrier"
        kind = "lidar"
        rate_hz = 10
        rays = 5
        first_angle_rad = -0.5
        last_angle_rad = 0.5
        longest_m = { uniform = [5.0, 6.0] }
        noise = { ranges_m = 0.01 }
        bias = { ranges_m = { uniform = [-0.1, 0.1] } }
        latency_secs = { uniform = [0.02, 0.06] }
    "#;
    let Some(bench) = bench(more) else { return };
    let plain = stimulus(
        &bench,
        &[("controller.driver.settings.speed_m_s", 0.5.into())],
    );
    let drawn = bench.drawn(&plain, 3).unwrap();
    let keys: Vec<&str> = drawn.iter().map(|number| number.key.as_str()).collect();
    for key in [
        "person.ann.x_m",
        "person.ann.waypoint.0.y_m",
        "sensor.lidar.longest_m",
        "sensor.lidar.bias.ranges_m",
    ] {
        assert!(keys.contains(&key), "{keys:?}");
    }
    // Drawn for each reading, it is no number of the episode.
    assert!(!keys.contains(&"sensor.lidar.latency_secs"), "{keys:?}");
    let mut pinned = plain.clone();
    for number in &drawn {
        pinned
            .settings
            .insert(number.key.clone(), number.value.into());
    }
    assert!(bench.drawn(&pinned, 3).unwrap().is_empty());
    let run = |stimulus: &Stimulus, seed| {
        let recorded = bench.run(stimulus, seed, &mut Unwatched, &Cancel::default());
        let trace = recorded.unwrap().trace;
        let numbers = trace.channels.into_iter();
        let numbers = numbers.flat_map(|it| it.times_secs.into_iter().chain(it.values));
        numbers.map(f64::to_bits).collect::<Vec<u64>>()
    };
    assert!(run(&plain, 3) == run(&pinned, 3));
    assert!(run(&plain, 3) != run(&plain, 4));
}

/// Drives until it fails: by an error, or when it is set up.
struct Failing(Driver, Option<f64>);

impl Controller for Failing {
    fn describe(&self) -> &Description {
        self.0.describe()
    }

    fn set_up(&mut self, setup: &Setup) -> Result<(), ControllerError> {
        match self.1 {
            Some(_) => self.0.set_up(setup),
            None => Err(ControllerError::Silent {
                reason: "it says nothing".into(),
            }),
        }
    }

    fn tick(&mut self, inputs: &Inputs) -> Result<Outputs, ControllerError> {
        if self.1.is_some_and(|secs| inputs.time_secs + 1e-9 >= secs) {
            return Err(ControllerError::Failed {
                message: "out of its depth".into(),
            });
        }
        self.0.tick(inputs)
    }
}

#[test]
fn what_a_controller_did_before_it_failed_is_recorded_and_it_is_said_how() {
    let Some(engine) = common::engine() else {
        return;
    };
    let folder = common::root().join("case-studies/corridor/simulation");
    let read = move |file: &str| std::fs::read(folder.join(file)).map_err(|e| e.to_string());
    let failing = |fails_secs: Option<f64>| {
        let start = Arc::new(move |_: &ControllerData| {
            Ok(Box::new(Failing(Driver::new(), fails_secs)) as Box<dyn Controller>)
        });
        let (bench, _) = SceneBench::new(ROOM, &read, mujoco(&engine), start).unwrap();
        run(&bench, 1, &[])
    };
    let recorded = failing(Some(2.0));
    assert_eq!(recorded.end, End::Failed);
    let failure = recorded.failure.clone().unwrap();
    assert!(!failure.in_setup && failure.words.contains("out of its depth"));
    assert!(
        (recorded.sim_secs - 2.0).abs() < 1e-9,
        "{}",
        recorded.sim_secs
    );
    assert!(!recorded.trace.complete);
    assert_eq!(recorded.trace.metadata["failed"], "controller-failed");
    assert_eq!(recorded.trace.end_secs(), Some(2.0));
    // Another time it is the same; what nobody measures is NaN, which equals nothing.
    let bits = |recorded: &Recorded| {
        let channels = recorded.trace.channels.iter();
        let numbers = channels.flat_map(|it| it.times_secs.iter().chain(&it.values));
        numbers.map(|number| number.to_bits()).collect::<Vec<u64>>()
    };
    let again = failing(Some(2.0));
    assert!(bits(&again) == bits(&recorded));
    assert_eq!(again.trace.metadata, recorded.trace.metadata);

    let recorded = failing(None);
    let failure = recorded.failure.unwrap();
    assert!(failure.in_setup);
    assert_eq!(failure.kind(), "controller-hung");
    assert_eq!(recorded.trace.metadata["seed"], "1");
    assert!(
        recorded
            .trace
            .channels
            .iter()
            .all(|it| it.times_secs.is_empty())
    );
}
