//! What errors and faults of drives do, against closed forms: a cart of 4 kg on a rail, which is level, or
//! upright where it has a weight. Strength is the engine's, so it is tested on both; what only changes commands
//! is the same for any engine, and is tested on one.
//!
//! Statistical bounds are five standard errors, and seeds are fixed.

use crate::engines;

use std::sync::Arc;

use engines::common;
use stimulus::{Setting, Settings, Stimulus};
use testbench::controller::{Controller, ControllerError, Description, Inputs, Outputs, Setup};
use testbench::scene::{BuildPhysics, ControllerData, SceneBench, mujoco, rapier};
use testbench::{Bench, Cancel, Unwatched};
use trace::Trace;

const MASS_KG: f64 = 4.0;

/// Commands one number from the beginning, and another from one second on.
struct Stepped {
    description: Description,
    field: String,
    values: [f64; 2],
}

impl Controller for Stepped {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn set_up(&mut self, setup: &Setup) -> Result<(), ControllerError> {
        self.field.clone_from(&setup.actuators[0].fields[0].name);
        let number = |key: &str| setup.settings.get(key).and_then(serde_json::Value::as_f64);
        self.values = ["first", "then"].map(|key| number(key).unwrap_or(f64::NAN));
        Ok(())
    }

    fn tick(&mut self, inputs: &Inputs) -> Result<Outputs, ControllerError> {
        let value = self.values[usize::from(inputs.time_secs > 0.999)];
        Ok(Outputs::default().command("drive", &self.field, value))
    }
}

/// What is driven, how, and what is told to do so.
struct Case<'a> {
    upright: bool,
    drive: &'a str,
    commands: [f64; 2],
    secs: f64,
    /// The actions of the test.
    actions: &'a str,
    settings: &'a [(&'a str, f64)],
}

impl Default for Case<'_> {
    fn default() -> Self {
        Self {
            upright: false,
            drive: "",
            commands: [0.0; 2],
            secs: 2.0,
            actions: "",
            settings: &[],
        }
    }
}

impl Case<'_> {
    fn scene(&self) -> String {
        let Self {
            drive,
            commands: [first, then],
            secs,
            actions,
            ..
        } = self;
        let gravity = if self.upright { 9.81 } else { 0.0 };
        format!(
            r#"
            name = "rail"
            simulation = {{ duration_secs = {secs:?}, record_hz = 500, gravity_m_s2 = {gravity:?} }}
            abstract_test = [{{ name = "it", actions = [{actions}] }}]
            [[robot]]
            name = "it"
            file = "rail.urdf"
            fixed = true
            recorded_joints = ["rail"]
            [[controller]]
            name = "stepped"
            robot = "it"
            period_secs = 0.01
            settings = {{ first = {first:?}, then = {then:?} }}
            [[actuator]]
            name = "drive"
            robot = "it"
            joint = "rail"
            {drive}
            "#
        )
    }

    fn run(&self, physics: BuildPhysics) -> Result<Trace, String> {
        let axis = if self.upright { "0 0 1" } else { "1 0 0" };
        let rail = format!(
            r#"<robot name="rail"><link name="post"/>
              <link name="cart"><inertial><mass value="{MASS_KG}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
              <joint name="rail" type="prismatic"><parent link="post"/><child link="cart"/><axis xyz="{axis}"/>
                <limit lower="-90" upper="90" effort="999" velocity="99"/></joint></robot>"#
        );
        let read = move |_: &str| Ok(rail.clone().into_bytes());
        let start = Arc::new(|_: &ControllerData| {
            Ok(Box::new(Stepped {
                description: Description::new("stepped", "1"),
                field: String::new(),
                values: [f64::NAN; 2],
            }) as Box<dyn Controller>)
        });
        let made = SceneBench::new(&self.scene(), &read, physics, start);
        let (bench, _) = made.map_err(|error| error.to_string())?;
        let mut stimulus = Stimulus::of(bench.tests()[0].clone());
        let settings = self.settings.iter();
        let settings = settings.map(|(key, value)| ((*key).to_owned(), Setting::Number(*value)));
        stimulus.settings = settings.collect::<Settings>();
        let run = bench.run(&stimulus, 5, &mut Unwatched, &Cancel::default());
        let trace = run.map_err(|error| error.to_string())?.trace;
        assert_sliding(&trace);
        Ok(trace)
    }

    /// Runs it in MuJoCo, or in Rapier where that is missing.
    fn in_one(&self, test: impl Fn(&str, &Trace)) {
        let (name, physics) = match common::engine() {
            Some(engine) => ("MuJoCo", mujoco(&engine)),
            None => ("Rapier", rapier()),
        };
        let trace = self.run(physics);
        test(
            name,
            &trace.unwrap_or_else(|error| panic!("{name}: {error}")),
        );
    }

    fn in_each(&self, test: impl Fn(&str, &Trace)) {
        let mut engines: Vec<(&str, BuildPhysics)> = vec![("Rapier", rapier())];
        if let Some(engine) = common::engine() {
            engines.push(("MuJoCo", mujoco(&engine)));
        }
        for (name, physics) in engines {
            let trace = self.run(physics);
            test(
                name,
                &trace.unwrap_or_else(|error| panic!("{name}: {error}")),
            );
        }
    }
}

/// All values of a signal, with their times.
fn signal(trace: &Trace, name: &str) -> Vec<(f64, f64)> {
    let index = trace.signal(name).unwrap_or_else(|| panic!("no {name}"));
    let channel = &trace.channels[index.channel];
    let times = channel.times_secs.iter().enumerate();
    times
        .map(|(row, time)| (*time, channel.row(row)[index.field]))
        .collect()
}

/// The value in the last row at or before a time.
fn at(trace: &Trace, name: &str, secs: f64) -> f64 {
    let rows = signal(trace, name);
    rows[rows.partition_point(|row| row.0 <= secs + 1e-9) - 1].1
}

const SPEED: &str = "/truth/it.rail.velocity";

#[test]
fn a_weak_effort_drive_has_its_share_of_force_and_of_its_limit() {
    // 10 N, and 40 N that the limit makes 20.
    for (strength, effort, felt) in [(0.4, 10.0, 4.0), (0.4, 40.0, 8.0), (0.0, 10.0, 0.0)] {
        let drive = format!(
            "kind = \"effort\"\nlimit = 20.0\nfault = [{{ kind = \"weak\", strength = {strength:?}, from_secs = 0.0 }}]"
        );
        let case = Case {
            drive: &drive,
            commands: [effort; 2],
            ..Case::default()
        };
        case.in_each(|engine, trace| {
            let gained = at(trace, SPEED, 1.5) - at(trace, SPEED, 0.5);
            let expected = felt / MASS_KG;
            assert!(
                (gained - expected).abs() < 1e-6,
                "{engine}: {gained} for {expected}"
            );
        });
    }
}

#[test]
fn a_weak_servo_gives_way_under_a_weight_by_one_over_its_strength() {
    // A velocity servo falls short by m g / (s g), a position servo by m g / (s k).
    let weight = MASS_KG * 9.81;
    for (drive, signal, short) in [
        (
            "kind = \"velocity\"\ngain = 200.0\nlimit = 500.0",
            SPEED,
            weight / 200.0,
        ),
        (
            "kind = \"position\"\nstiffness = 2000.0\ndamping = 300.0\nlimit = 500.0",
            "/truth/it.rail.position",
            weight / 2000.0,
        ),
    ] {
        let drive =
            format!("{drive}\nfault = [{{ kind = \"weak\", strength = 0.25, from_secs = 1.5 }}]");
        let case = Case {
            upright: true,
            drive: &drive,
            commands: [0.5; 2],
            secs: 3.0,
            ..Case::default()
        };
        case.in_each(|engine, trace| {
            for (secs, strength) in [(1.49, 1.0), (3.0, 0.25)] {
                let (found, expected) = (at(trace, signal, secs), 0.5 - short / strength);
                assert!(
                    (found - expected).abs() < 0.01 * short / strength,
                    "{engine}: {signal} {found} for {expected}"
                );
            }
        });
    }
}

#[test]
fn a_drive_without_strength_lets_the_cart_fall_freely() {
    let case = Case {
        upright: true,
        drive: "kind = \"velocity\"\ngain = 4000.0\nlimit = 900.0",
        actions: "{ set_param = { \"drive.fault\" = \"limp\" }, after_secs = 0.5 }",
        ..Case::default()
    };
    case.in_each(|engine, trace| {
        let held = at(trace, SPEED, 0.5);
        assert!(
            (held + MASS_KG * 9.81 / 4000.0).abs() < 1e-3,
            "{engine}: {held}"
        );
        let gained = at(trace, SPEED, 1.5) - at(trace, SPEED, 1.0);
        assert!((gained + 0.5 * 9.81).abs() < 1e-6, "{engine}: {gained}");
        let faulty = signal(trace, "/command/drive.faulty");
        let first = faulty
            .iter()
            .find(|row| row.1 == 1.0)
            .expect("it is written down");
        assert!((first.0 - 0.5).abs() < 1e-9, "{engine}: {}", first.0);
    });
}

#[test]
fn a_delayed_drive_does_the_same_later_and_a_stuck_one_goes_on() {
    let servo = "kind = \"velocity\"\ngain = 400.0\nlimit = 900.0";
    let faults = |fault: &str| format!("{servo}\nfault = [{{ {fault} }}]");
    let run = |drive: &str, actions: &str| -> Vec<(String, Trace)> {
        let case = Case {
            drive,
            commands: [0.2, 0.6],
            actions,
            ..Case::default()
        };
        let traces = std::cell::RefCell::new(Vec::new());
        case.in_one(|engine, trace| {
            traces.borrow_mut().push((engine.to_owned(), trace.clone()));
        });
        traces.into_inner()
    };
    let sound = run(servo, "");
    let late = run(
        &faults("kind = \"delayed\", delay_secs = 0.25, from_secs = 0.0"),
        "",
    );
    for ((engine, sound), (_, late)) in sound.iter().zip(&late) {
        for secs in [0.3, 1.0, 1.2, 1.3, 1.7] {
            let [before, after] = [at(sound, SPEED, secs - 0.25), at(late, SPEED, secs)];
            assert!(
                (before - after).abs() < 1e-9,
                "{engine}: {before}, {after} at {secs} s"
            );
        }
    }
    let stuck = run(
        &faults("kind = \"stuck\", from_secs = 0.5, until_secs = 1.5"),
        "",
    );
    let forced = run(
        servo,
        "{ set_param = { \"drive.fault\" = \"stuck\" }, after_secs = 0.5 }, { set_param = { \"drive.fault\" = \"none\" }, after_secs = 1.0 }",
    );
    for (engine, trace) in stuck.iter().chain(&forced) {
        for (secs, expected) in [(1.4, 0.2), (1.9, 0.6)] {
            let speed = at(trace, SPEED, secs);
            assert!(
                (speed - expected).abs() < 1e-3,
                "{engine}: {speed} at {secs} s"
            );
        }
    }
}

#[test]
fn a_dead_band_swallows_what_is_small_and_shortens_the_rest() {
    let servo = "kind = \"velocity\"\ngain = 400.0\nlimit = 900.0\nfault = [{ kind = \"dead_band\", dead_band = { velocity_rad_s = 0.3 }, from_secs = 0.0 }]";
    let case = Case {
        drive: servo,
        commands: [-0.29, -0.8],
        ..Case::default()
    };
    case.in_one(|engine, trace| {
        assert_eq!(at(trace, SPEED, 0.9), 0.0, "{engine}");
        let speed = at(trace, SPEED, 2.0);
        assert!((speed + 0.5).abs() < 1e-3, "{engine}: {speed}");
    });
    // A position stays until the command is further away than the band.
    let held = "kind = \"position\"\nstiffness = 4000.0\ndamping = 300.0\nlimit = 900.0\nfault = [{ kind = \"dead_band\", dead_band = { position_rad = 0.1 }, from_secs = 0.0 }]";
    for (then, expected) in [(0.59, 0.5), (0.61, 0.61)] {
        let case = Case {
            drive: held,
            commands: [0.5, then],
            ..Case::default()
        };
        case.in_one(|engine, trace| {
            let position = at(trace, "/truth/it.rail.position", 2.0);
            assert!(
                (position - expected).abs() < 1e-3,
                "{engine}: {position} for {then}"
            );
        });
    }
}

#[test]
fn noise_and_bias_have_their_moments_whatever_the_time_step() {
    // A free cart: over each period of the noise its speed gains (-2.9 + 3 + s n) h / m.
    let drive = "kind = \"effort\"\nlimit = 900.0\nnoise = { effort_nm = 4.0 }\nnoise_hz = 250\nbias = { effort_nm = 3.0 }\nfault = [{ kind = \"noisy\", noise = { effort_nm = 3.0 }, from_secs = 0.0, probability = 0.0 }]";
    for (probability, deviation) in [(0.0, 4.0), (1.0, 5.0)] {
        let case = Case {
            drive,
            commands: [-2.9; 2],
            secs: 4.0,
            settings: &[("actuator.drive.fault.0.probability", probability)],
            ..Case::default()
        };
        case.in_one(|engine, trace| {
            let speed = signal(trace, SPEED);
            let ends: Vec<f64> = speed.iter().skip(2).step_by(2).map(|row| row.1).collect();
            let forces: Vec<f64> = ends
                .windows(2)
                .map(|pair| (pair[1] - pair[0]) * MASS_KG / 0.004)
                .collect();
            let n = forces.len() as f64;
            assert!(n > 990.0, "{engine}: {n}");
            let mean = forces.iter().sum::<f64>() / n;
            let variance = forces.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / n;
            let error = deviation / n.sqrt();
            assert!((mean - 0.1).abs() < 5.0 * error, "{engine}: mean {mean}");
            let found = variance.sqrt();
            let spread = 5.0 * error / 2.0_f64.sqrt();
            assert!(
                (found - deviation).abs() < spread,
                "{engine}: {found} for {deviation}"
            );
        });
    }
}

#[test]
fn faults_are_drawn_from_the_seed_and_wrong_ones_are_refused() {
    let fault =
        "fault = [{ kind = \"weak\", strength = { uniform = [0.2, 0.9] }, from_secs = 0.0 }]";
    let drive = format!("kind = \"effort\"\nlimit = 20.0\n{fault}");
    let case = Case {
        drive: &drive,
        commands: [8.0; 2],
        secs: 1.0,
        ..Case::default()
    };
    let gained =
        |trace: Trace| (at(&trace, SPEED, 0.9) - at(&trace, SPEED, 0.4)) * MASS_KG / 0.5 / 8.0;
    let drawn = [rapier(), rapier()].map(|engine| gained(case.run(engine).expect("it runs")));
    assert!((0.2..0.9).contains(&drawn[0]), "{drawn:?}");
    assert_eq!(drawn[0], drawn[1]);
    for (wrong, said) in [
        (
            "fault = [{ kind = \"weak\", from_secs = 0.0 }]",
            "needs `strength`",
        ),
        (
            "fault = [{ kind = \"stuck\", delay_secs = 1.0, from_secs = 0.0 }]",
            "has no `delay_secs`",
        ),
        (
            "fault = [{ kind = \"weak\", strength = 1.5, from_secs = 0.0 }]",
            "between 0 and 1",
        ),
        ("noise = { effort = 1.0 }", "may be one of effort_nm"),
        ("noise_hz = 300.0", "must be a whole number of time steps"),
    ] {
        let case = Case {
            drive: &format!("kind = \"effort\"\nlimit = 20.0\n{wrong}"),
            ..Case::default()
        };
        let refused = case.run(rapier()).expect_err("it is refused");
        assert!(
            refused.contains(said) && refused.contains("actuator.drive"),
            "{refused}"
        );
    }
}

/// What slides is recorded as a length.
fn assert_sliding(trace: &Trace) {
    let unit = |name: &str| {
        let field = trace.field(trace.signal(name).expect(name)).expect(name);
        field.unit.clone()
    };
    assert_eq!(unit("/truth/it.rail.position"), "m");
    assert_eq!(unit("/truth/it.rail.velocity"), "m/s");
}
