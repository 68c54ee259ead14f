//! Models of sensors against closed forms, on both engines: rates, latencies, noise, bias, dropout,
//! quantised encoders, the cone in which a person is seen, what cameras see, what flanges and joints bear.
//!
//! Statistical bounds are five standard errors, and seeds are fixed.

use crate::engines;

use std::sync::Arc;

use engines::common;
use stimulus::Stimulus;
use testbench::controller::ControllerError;
use testbench::scene::{BuildPhysics, SceneBench, mujoco, rapier};
use testbench::{Bench, Cancel, Unwatched};
use trace::Trace;

/// A fixed post with a rod that swings about y.
const SWING: &str = r#"<robot name="swing">
  <link name="post"/>
  <link name="rod">
    <inertial><origin xyz="0 0 -0.4"/><mass value="1"/>
      <inertia ixx="0.05" iyy="0.05" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="hinge" type="continuous"><parent link="post"/><child link="rod"/><axis xyz="0 1 0"/></joint>
</robot>"#;

/// A tray of 1 kg on a vertical slide, whose drive holds it.
const TRAY: &str = r#"<robot name="tray">
  <link name="column"/>
  <link name="tray">
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.4 0.4 0.02"/></geometry></collision>
  </link>
  <joint name="lift" type="prismatic"><parent link="column"/><child link="tray"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1000" velocity="10"/></joint>
</robot>"#;

const SCENE: &str = r#"
    name = "swing"
    simulation = { duration_secs = 20.0, record_hz = 100 }
    [[abstract_test]]
    name = "nothing"
    actions = []
    [[robot]]
    name = "swing"
    file = "swing.urdf"
    fixed = true
    joints = { hinge = 1.0 }
    recorded_joints = ["hinge"]
"#;

/// Runs the scene with `more` for a time in an engine.
fn run_in(physics: BuildPhysics, secs: f64, more: &str) -> Result<Trace, String> {
    let scene = SCENE.replace("20.0", &secs.to_string());
    let read = |file: &str| {
        let text = if file == "tray.urdf" { TRAY } else { SWING };
        Ok(text.as_bytes().to_vec())
    };
    let none = Arc::new(|_: &_| {
        Err(ControllerError::Failed {
            message: "there is none".to_owned(),
        })
    });
    let made = SceneBench::new(&format!("{scene}{more}"), &read, physics, none);
    let (bench, _) = made.map_err(|error| error.to_string())?;
    let nothing = Stimulus::of(bench.tests()[0].clone());
    let run = bench.run(&nothing, 11, &mut Unwatched, &Cancel::default());
    run.map(|recorded| recorded.trace)
        .map_err(|error| error.to_string())
}

/// Runs it in each engine that is there.
fn in_each(secs: f64, more: &str, test: impl Fn(&str, &Trace)) {
    let mut engines: Vec<(&str, BuildPhysics)> = vec![("Rapier", rapier())];
    if let Some(engine) = common::engine() {
        engines.push(("MuJoCo", mujoco(&engine)));
    }
    for (name, physics) in engines {
        let trace = run_in(physics, secs, more);
        test(
            name,
            &trace.unwrap_or_else(|error| panic!("{name}: {error}")),
        );
    }
}

/// The times and values of a signal.
fn signal(trace: &Trace, name: &str) -> Vec<(f64, f64)> {
    let index = trace.signal(name).unwrap_or_else(|| {
        let known: Vec<String> = trace.signal_names().collect();
        panic!("no {name} among {known:?}")
    });
    let channel = &trace.channels[index.channel];
    let times = channel.times_secs.iter().enumerate();
    times
        .map(|(row, time)| (*time, channel.row(row)[index.field]))
        .collect()
}

#[test]
fn rates_are_exact_and_a_latency_is_its_number_of_steps() {
    let sensors = r#"
        [[sensor]]
        name = "late"
        robot = "swing"
        kind = "pose"
        rate_hz = 50
        latency_secs = 0.034
    "#;
    in_each(20.0, sensors, |name, trace| {
        let late = signal(trace, "/sensor/late.measured_at");
        assert_eq!(late.len(), 999, "{name}");
        for (index, (arrived, measured)) in late.iter().enumerate() {
            let tick = |secs: f64| (secs / 0.002).round();
            assert!(
                (measured - index as f64 * 0.02).abs() < 1e-9,
                "{name}: {measured}"
            );
            assert_eq!(tick(*arrived) - tick(*measured), 17.0, "{name}: {arrived}");
        }
    });
}

#[test]
fn noise_and_bias_have_their_moments_and_dropout_its_rate() {
    let sensors = r#"
        [[sensor]]
        name = "noisy"
        robot = "swing"
        kind = "pose"
        rate_hz = 100
        noise = { x_m = 0.1 }
        bias = { x_m = 0.3 }
        [[sensor]]
        name = "lossy"
        robot = "swing"
        kind = "pose"
        rate_hz = 100
        dropout_probability = 0.2
    "#;
    in_each(20.0, sensors, |name, trace| {
        let noisy: Vec<f64> = signal(trace, "/sensor/noisy.x")
            .iter()
            .map(|row| row.1)
            .collect();
        let n = noisy.len() as f64;
        assert!(n >= 2000.0, "{name}: {n}");
        let mean = noisy.iter().sum::<f64>() / n;
        let moment = |power: i32| noisy.iter().map(|x| (x - mean).powi(power)).sum::<f64>() / n;
        let deviation = moment(2).sqrt();
        assert!(
            (mean - 0.3).abs() < 5.0 * 0.1 / n.sqrt(),
            "{name}: mean {mean}"
        );
        assert!(
            (deviation - 0.1).abs() < 5.0 * 0.1 / (2.0 * n).sqrt(),
            "{name}: {deviation}"
        );
        let skewness = moment(3) / deviation.powi(3);
        let kurtosis = moment(4) / deviation.powi(4);
        assert!(
            skewness.abs() < 5.0 * (6.0 / n).sqrt(),
            "{name}: skewness {skewness}"
        );
        assert!(
            (kurtosis - 3.0).abs() < 5.0 * (24.0 / n).sqrt(),
            "{name}: kurtosis {kurtosis}"
        );
        // Errors do not depend on those before.
        let pairs = noisy
            .windows(2)
            .map(|pair| (pair[0] - mean) * (pair[1] - mean));
        let correlation = pairs.sum::<f64>() / n / moment(2);
        assert!(correlation.abs() < 5.0 / n.sqrt(), "{name}: {correlation}");
        let lossy = signal(trace, "/sensor/lossy.x").len() as f64;
        let spread = (n * 0.2 * 0.8).sqrt();
        assert!(
            (lossy - 0.8 * n).abs() < 5.0 * spread,
            "{name}: {lossy} of {n} arrived"
        );
        assert!(lossy < n, "{name}");
    });
}

#[test]
fn an_encoder_gives_the_nearest_multiple_of_its_resolution() {
    let sensors = r#"
        [[sensor]]
        name = "encoder"
        robot = "swing"
        kind = "joint_encoder"
        joints = ["hinge"]
        resolution = 0.05
        rate_hz = 100
        record_all = true
    "#;
    in_each(20.0, sensors, |name, trace| {
        let truth = signal(trace, "/truth/swing.hinge.position");
        let names: Vec<String> = trace.signal_names().collect();
        let position = names
            .iter()
            .find(|name| name.starts_with("/sensor/encoder.position"))
            .unwrap_or_else(|| panic!("{names:?}"));
        let read = signal(trace, position);
        let mut values = std::collections::BTreeSet::new();
        for ((read_secs, read), (true_secs, truth)) in read.iter().zip(&truth) {
            assert_eq!(read_secs, true_secs, "{name}");
            let steps = (read / 0.05).round();
            assert!((read - 0.05 * steps).abs() < 1e-12, "{name}: {read}");
            assert!(
                (read - truth).abs() < 0.025 + 1e-9,
                "{name}: {read} for {truth}"
            );
            values.insert(steps as i64);
        }
        // It swings from 1 to -1 rad: all 41 multiples but perhaps the outermost.
        assert!(values.len() >= 39, "{name}: {values:?}");
    });
}

#[test]
fn a_person_is_seen_within_the_cone_and_the_range_and_not_outside() {
    // The cone reaches 0.5 rad to either side and 4 m far.
    for (distance_m, bearing_rad, seen) in [
        (2.0, 0.0, true),
        (2.0, 0.45, true),
        (2.0, -0.45, true),
        (2.0, 0.55, false),
        (2.0, -0.55, false),
        (3.9, 0.1, true),
        (4.1, 0.1, false),
        (2.0, 3.1, false),
    ] {
        let (sine, cosine) = f64::sin_cos(bearing_rad);
        let more = format!(
            r#"
            [[person]]
            name = "anna"
            x_m = {}
            y_m = {}
            activity = "stand"
            [[sensor]]
            name = "eye"
            robot = "swing"
            kind = "person_detector"
            rate_hz = 10
            z_m = 1.0
            field_of_view_rad = 1.0
            longest_m = 4.0
            "#,
            distance_m * cosine,
            distance_m * sine
        );
        in_each(0.4, &more, |name, trace| {
            let rows = signal(trace, "/sensor/eye.seen");
            let expected = f64::from(u8::from(seen));
            let all_so = rows.iter().all(|row| row.1 == expected);
            assert!(
                all_so && !rows.is_empty(),
                "{name}: {distance_m} m, {bearing_rad} rad"
            );
            if seen {
                let bearing = signal(trace, "/sensor/eye.bearing")[0].1;
                let distance = signal(trace, "/sensor/eye.distance")[0].1;
                assert!(
                    (bearing - bearing_rad).abs() < 1e-9,
                    "{name}: {bearing} rad"
                );
                assert!((distance - distance_m).abs() < 1e-9, "{name}: {distance} m");
            }
        });
    }
}

/// A flat world for cameras: the swing's post looks along x, and nothing moves.
#[test]
fn a_marker_is_seen_in_view_in_range_with_a_free_line_and_from_its_face() {
    let camera = |name: &str, target: &str, more: &str| {
        format!(
            r#"
            [[sensor]]
            name = "{name}"
            robot = "swing"
            kind = "marker_camera"
            link = "post"
            rate_hz = 10
            z_m = 1.0
            target = "{target}"
            horizontal_view_rad = 1.0
            vertical_view_rad = 0.6
            longest_m = 4.0
            {more}
            "#
        )
    };
    let ball = |name: &str, [x, y, z]: [f64; 3]| {
        format!("[[object]]\nname = \"{name}\"\nradius_m = 0.05\nx_m = {x}\ny_m = {y}\nz_m = {z}\n")
    };
    let at = |bearing: f64, elevation: f64| [2.0, 2.0 * bearing.tan(), 1.0 + 2.0 * elevation.tan()];
    // The wall stands from y = 0.2 to 0.4 at x = 1, so it covers bearings from 0.1974 to 0.3805 rad there.
    let wall =
        "[[object]]\nname = \"wall\"\nbox_m = [0.02, 0.2, 0.4]\nx_m = 1.0\ny_m = 0.3\nz_m = 1.0\n";
    for (name, place, more, seen) in [
        ("inside", at(-0.49, 0.29), "", true),
        ("left_of_view", at(-0.51, 0.0), "", false),
        ("above_view", at(0.0, 0.31), "", false),
        (
            "below_a_camera_that_looks_down",
            at(0.0, -0.5),
            "pitch_rad = 0.4",
            true,
        ),
        (
            "to_a_camera_that_is_turned",
            at(-0.7, 0.0),
            "yaw_rad = -0.4",
            true,
        ),
        ("behind_the_wall", at(0.3, 0.0), "", false),
        ("beside_the_wall", at(0.17, 0.0), "", true),
        ("far", [4.01, 0.0, 1.0], "", false),
        ("near_enough", [3.99, 0.0, 1.0], "", true),
        ("too_near", [0.5, 0.0, 1.0], "shortest_m = 0.6", false),
        ("facing", at(0.0, 0.1), "facing = [-1.0, 0.0, 0.0]", true),
        (
            "turned_away",
            at(0.0, 0.1),
            "facing = [1.0, 0.0, 0.0]",
            false,
        ),
        (
            "at_60_degrees",
            [2.0, 0.0, 1.0],
            "facing = [-0.5, 0.866, 0.0]\nwidest_angle_rad = 1.05",
            true,
        ),
        (
            "at_steeper",
            [2.0, 0.0, 1.0],
            "facing = [-0.5, 0.866, 0.0]\nwidest_angle_rad = 1.04",
            false,
        ),
        (
            "not_detected",
            [2.0, 0.0, 1.0],
            "detection_probability = 0.0",
            false,
        ),
        (
            "silenced",
            [2.0, 0.0, 1.0],
            "bias = { x_m = 0.25 }\nfault = [{ kind = \"silent\", from_secs = 0.35 }]",
            true,
        ),
    ] {
        let scene = [wall, &ball("ball", place), &camera(name, "ball", more)].concat();
        in_each(0.6, &scene, |engine, trace| {
            let said = |field: &str| signal(trace, &format!("/sensor/{name}.{field}"));
            let rows = said("seen");
            assert_eq!(
                rows.len(),
                if name == "silenced" { 4 } else { 6 },
                "{engine}: {name}"
            );
            let expected = f64::from(u8::from(seen));
            assert!(rows.iter().all(|row| row.1 == expected), "{engine}: {name}");
            let [x, y, z] = ["x", "y", "z"].map(|axis| said(axis)[0].1);
            assert_eq!([x, y, z].map(f64::is_nan), [!seen; 3], "{engine}: {name}");
            if name == "inside" {
                let off = [x - 2.0, y - place[1], z - (place[2] - 1.0)];
                assert!(off.iter().all(|off| off.abs() < 1e-9), "{engine}: {off:?}");
            }
            if name == "silenced" {
                assert!((x - 2.25).abs() < 1e-9, "{engine}: {x}");
            }
            if name == "below_a_camera_that_looks_down" {
                // Along its axis, down by 0.4 rad, the marker is 0.1 rad lower: distance times cosine.
                let distance_m = 2.0 / 0.5_f64.cos();
                assert!(
                    (x - distance_m * 0.1_f64.cos()).abs() < 1e-9,
                    "{engine}: {x}"
                );
                let pitch = said("pitch")[0].1;
                assert!((pitch + 0.4).abs() < 1e-9, "{engine}: {pitch}");
            }
        });
    }
}

#[test]
fn an_image_of_depth_is_even_on_a_wall_across_and_has_holes_beyond_its_range() {
    // A wall across at 2 m, but for its upper half, and a ball of 0.2 m in the middle at 1.5 m.
    let scene = r#"
        [[object]]
        name = "wall"
        box_m = [0.2, 9.0, 3.0]
        x_m = 2.1
        z_m = -0.5
        [[object]]
        name = "ball"
        radius_m = 0.2
        x_m = 1.5
        z_m = 1.0
        [[sensor]]
        name = "depth"
        robot = "swing"
        kind = "depth_camera"
        link = "post"
        rate_hz = 10
        z_m = 1.0
        columns = 9
        rows = 7
        horizontal_view_rad = 1.2
        vertical_view_rad = 0.9
        longest_m = 3.0
        record_all = true
    "#;
    in_each(0.1, scene, |engine, trace| {
        let depth = |pixel: usize| signal(trace, &format!("/sensor/depth.depths.{pixel}"))[0].1;
        let nearest = depth(3 * 9 + 4);
        assert!((nearest - 1.3).abs() < 1e-6, "{engine}: {nearest}");
        for pixel in 0..63 {
            let (row, column) = (pixel / 9, pixel % 9);
            let is_on_ball = (2..=4).contains(&row) && (3..=5).contains(&column);
            if is_on_ball {
                continue;
            }
            let depth_m = depth(pixel);
            // The wall ends at the camera's height: the rows above look past it.
            assert_eq!(
                depth_m.is_nan(),
                row < 3,
                "{engine}: {row} {column}: {depth_m}"
            );
            if row > 3 {
                assert!(
                    (depth_m - 2.0).abs() < 1e-9,
                    "{engine}: {row} {column}: {depth_m}"
                );
            }
        }
    });
}

#[test]
fn a_wrist_bears_what_it_holds_and_a_joint_what_its_drive_makes() {
    let sensor = |name: &str, robot: &str, rest: &str| {
        format!("[[sensor]]\nname = \"{name}\"\nrobot = \"{robot}\"\nrate_hz = 50\n{rest}\n")
    };
    let drive = |name: &str, robot: &str, joint: &str| {
        format!(
            "[[actuator]]\nname = \"{name}\"\nrobot = \"{robot}\"\nkind = \"position\"\njoint = \"{joint}\"\nstiffness = 3000.0\ndamping = 200.0\nlimit = 500.0\n"
        )
    };
    let more = [
        "[[robot]]\nname = \"server\"\nfile = \"tray.urdf\"\nfixed = true\nx_m = 3.0\n",
        "[[object]]\nname = \"cup\"\nbox_m = [0.1, 0.1, 0.1]\nmass_kg = 0.7\nx_m = 3.1\nz_m = 0.06\nfriction = 0.9\n",
        &drive("holder", "swing", "hinge"),
        &drive("lifter", "server", "lift"),
        &sensor("wrist", "server", "kind = \"force_torque\"\nlink = \"tray\""),
        &sensor("under_cup", "server", "kind = \"force_torque\"\nlink = \"tray\"\nx_m = 0.1\nyaw_rad = 1.5707963267948966\nbias = { force_newtons = 3.0 }"),
        &sensor("motors", "server", "kind = \"joint_torque\"\njoints = [\"lift\"]"),
        &sensor("elbow", "swing", "kind = \"joint_torque\"\njoints = [\"hinge\"]"),
    ]
    .concat();
    in_each(3.0, &more, |engine, trace| {
        let last = |name: &str| signal(trace, name).last().expect("rows").1;
        let near = |name: &str, expected: f64, within: f64| {
            let found = last(name);
            assert!(
                (found - expected).abs() < within,
                "{engine}: {name}: {found} and not {expected}"
            );
        };
        // The tray and the cup, which stands 0.1 m off its middle.
        let (all, cup) = (1.7 * 9.81, 0.7 * 9.81);
        near("/sensor/wrist.force.2", all, 1e-3 * all);
        near("/sensor/wrist.force.0", 0.0, 0.02);
        near("/sensor/wrist.torque.1", -0.1 * cup, 0.01 * cup);
        // Below the cup the tray's own weight turns the other way, seen in a frame that is turned by 90 degrees.
        near("/sensor/under_cup.force.2", all + 3.0, 1e-3 * all);
        near("/sensor/under_cup.torque.0", 0.1 * (all - cup), 0.01 * cup);
        near("/sensor/motors.effort", all, 1e-3 * all);
        // The rod's centre is 0.4 m from the hinge.
        let angle = last("/truth/swing.hinge.position");
        near("/sensor/elbow.effort", 0.4 * 9.81 * angle.sin(), 2e-3);
    });
}

#[test]
fn what_is_fixed_to_the_world_bears_nothing_that_rapier_could_tell() {
    let more = "[[sensor]]\nname = \"foot\"\nrobot = \"swing\"\nrate_hz = 50\nkind = \"force_torque\"\nlink = \"post\"\n";
    let refused = run_in(rapier(), 0.1, more).expect_err("it has no joint");
    assert!(
        refused.contains("sensor.foot.kind") && refused.contains("fixed to the world"),
        "{refused}"
    );
}
