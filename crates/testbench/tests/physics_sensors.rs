//! Models of sensors against closed forms, on both engines: rates, latencies, noise, bias, dropout,
//! quantised encoders, the cone in which a person is seen.
//!
//! Statistical bounds are five standard errors, and seeds are fixed.

mod engines;

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

/// Runs the scene with `more` for a time in each engine that is there.
fn in_each(secs: f64, more: &str, test: impl Fn(&str, &Trace)) {
    let scene = SCENE.replace("20.0", &secs.to_string());
    let mut engines: Vec<(&str, BuildPhysics)> = vec![("Rapier", rapier())];
    if let Some(engine) = common::engine() {
        engines.push(("MuJoCo", mujoco(&engine)));
    }
    for (name, physics) in engines {
        let read = |_: &str| Ok(SWING.as_bytes().to_vec());
        let none = Arc::new(|_: &_| {
            Err(ControllerError::Failed {
                message: "there is none".to_owned(),
            })
        });
        let made = SceneBench::new(&format!("{scene}{more}"), &read, physics, none);
        let (bench, _) = made.unwrap_or_else(|error| panic!("{name}: {error}"));
        let nothing = Stimulus::of(bench.tests()[0].clone());
        let run = bench.run(&nothing, 11, &mut Unwatched, &Cancel::default());
        test(
            name,
            &run.unwrap_or_else(|error| panic!("{name}: {error}")).trace,
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
