//! Episodes of the handover: determinism, faults, and the human's other ways.

use crate::common;

use handover::robot::Decision;
use handover::{
    Episode, Outside, OutsideReadings, Parameters, Reading, World, run_episode, run_episode_with,
};
use std::ops::ControlFlow;
use testbench::{Cancel, Distribution, Engine, SimError};
use trace::Trace;

fn world(engine: &Engine, parameters: &Parameters) -> World {
    World::new(engine, &common::scenario(), parameters).expect("the scenario is sound")
}

fn run(world: &World, seed: u64) -> Episode {
    run_episode(world, seed, &Cancel::default()).expect("the episode runs")
}

/// Parameters under which nothing but physics can go wrong: no glitch, no planner fault, a firm pull.
fn faultless() -> Parameters {
    let mut parameters = common::parameters("tuned");
    parameters.tracking.glitch_rate_per_reading = 0.0;
    parameters.planner.failure_rate_per_run = 0.0;
    parameters.human.pull_forward_newtons = Distribution::Constant(12.0);
    parameters.hand.friction = Distribution::Constant(0.8);
    parameters
}

/// Every bit of a trace's numbers.
fn bits(trace: &Trace) -> Vec<u64> {
    let numbers = trace
        .channels
        .iter()
        .flat_map(|channel| channel.times_secs.iter().chain(&channel.values));
    numbers.map(|number| number.to_bits()).collect()
}

#[test]
fn one_seed_gives_the_same_bits_in_a_used_world_a_fresh_one_and_on_two_threads() {
    let Some(engine) = common::engine() else {
        return;
    };
    let parameters = common::parameters("tuned");
    let used = world(&engine, &parameters);
    run(&used, 1);
    let expected = run(&used, 2);
    let fresh = run(&world(&engine, &parameters), 2);
    assert_eq!(bits(&fresh.trace), bits(&expected.trace));
    assert_eq!(fresh.trace.metadata, expected.trace.metadata);
    assert_eq!(fresh.outcome, expected.outcome);
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..2)
            .map(|_| scope.spawn(|| bits(&run(&world(&engine, &parameters), 2).trace)))
            .collect();
        for thread in threads {
            assert_eq!(thread.join().expect("no panic"), bits(&expected.trace));
        }
    });
    assert_ne!(
        bits(&run(&used, 3).trace),
        bits(&expected.trace),
        "seeds matter"
    );
}

#[test]
fn without_faults_the_object_is_handed_over_and_the_trace_is_sound() {
    let Some(engine) = common::engine() else {
        return;
    };
    let episode = run(&world(&engine, &faultless()), 1);
    assert!(episode.outcome.success, "{:?}", episode.outcome);
    assert!(episode.outcome.object_with_human);
    assert!(episode.trace.complete);
    episode
        .trace
        .validate()
        .expect("the trace keeps its own rules");
    assert!((episode.sim_secs - episode.steps as f64 * 0.002).abs() < 1e-9);
    for signal in [
        "/robot.state",
        "/robot.decision",
        "/robot.crashed",
        "/robot.hand_speed",
        "/sensors.all_ok",
        "/sensors.sensing_done",
        "/tracking.object.x",
        "/truth.in_hand",
        "/truth.human_ready",
        "/truth.human_distance",
        "/truth.object_contacts_hand",
        "/human.ready",
    ] {
        assert!(
            episode.trace.signal(signal).is_some(),
            "{signal} is missing"
        );
    }
    assert_eq!(episode.trace.metadata["engine_version"], engine.version());
    assert_eq!(episode.trace.metadata["seed"], "1");
}

#[test]
fn an_unanswered_plan_crashes_the_robot_and_the_run_still_ends() {
    let Some(engine) = common::engine() else {
        return;
    };
    let mut parameters = faultless();
    parameters.planner.failure_rate_per_run = 1.0;
    let episode = run(&world(&engine, &parameters), 4);
    assert!(episode.outcome.crashed);
    assert_eq!(episode.outcome.decision, Decision::None);
    assert!(!episode.outcome.success && episode.trace.complete);
}

#[test]
fn without_friction_the_object_is_dropped() {
    let Some(engine) = common::engine() else {
        return;
    };
    let mut parameters = faultless();
    parameters.hand.friction = Distribution::Constant(0.02);
    let outcome = run(&world(&engine, &parameters), 1).outcome;
    assert!(
        outcome.grip_failure && !outcome.success && !outcome.object_with_human,
        "{outcome:?}"
    );
}

#[test]
fn every_reading_glitched_fails_the_location_but_not_the_physics() {
    let Some(engine) = common::engine() else {
        return;
    };
    let mut parameters = faultless();
    parameters.tracking.glitch_rate_per_reading = 1.0;
    let outcome = run(&world(&engine, &parameters), 1).outcome;
    assert_eq!(
        (outcome.location_ok, outcome.decision),
        (Some(false), Decision::Keep)
    );
    assert!(!outcome.grip_failure && outcome.human_was_ready);
}

#[test]
fn a_human_who_is_not_ready_does_not_get_the_object() {
    let Some(engine) = common::engine() else {
        return;
    };
    let parameters = faultless();
    for (test, decision, failing) in [
        ("human looks away", Decision::Keep, 0),
        ("human does not pull", Decision::Keep, 1),
        ("human keeps the hand away", Decision::Keep, 2),
        ("human never ready", Decision::TimeOut, 3),
    ] {
        let world = world(&engine, &parameters)
            .with_test(test)
            .expect("it is in the scenario");
        let outcome = run(&world, 1).outcome;
        assert_eq!(outcome.decision, decision, "{test}");
        assert!(!outcome.human_was_ready, "{test}");
        let sensors = [outcome.gaze_ok, outcome.pressure_ok, outcome.location_ok];
        match sensors.get(failing) {
            Some(sensor) => assert_eq!(*sensor, Some(false), "{test}"),
            None => assert_eq!(sensors, [None; 3], "{test}"),
        }
    }
}

#[test]
fn halving_the_time_step_moves_the_held_object_by_less_than_a_few_millimetres() {
    let Some(engine) = common::engine() else {
        return;
    };
    let mut placed = Vec::new();
    for time_step_secs in [0.001, 0.002, 0.0025] {
        let mut scenario = common::scenario();
        scenario.simulation.time_step_secs = time_step_secs;
        let world = World::new(&engine, &scenario, &faultless())
            .and_then(|world| world.with_test("human never ready"))
            .expect("the scenario is sound");
        let episode = run(&world, 2);
        assert!(!episode.outcome.grip_failure, "{time_step_secs}");
        let truth = episode
            .trace
            .channel("/truth")
            .expect("a topic of the trace");
        let last = &truth.values[truth.values.len() - truth.fields.len()..];
        placed.push([last[0], last[1], last[2]]);
    }
    for other in &placed[1..] {
        let distance = (0..3)
            .map(|axis| (other[axis] - placed[0][axis]).powi(2))
            .sum::<f64>()
            .sqrt();
        assert!(distance < 0.005, "{distance} m: {placed:?}");
    }
}

#[test]
fn a_cancelled_episode_and_an_unknown_test_say_so() {
    let Some(engine) = common::engine() else {
        return;
    };
    let world = world(&engine, &faultless());
    let cancel = Cancel::default();
    cancel.cancel();
    assert!(matches!(
        run_episode(&world, 1, &cancel),
        Err(SimError::Cancelled)
    ));
    let error = world.with_test("human sings").unwrap_err();
    assert!(error.to_string().contains("human sings"));
}

#[test]
fn an_episode_cut_short_by_its_longest_time_says_so_in_its_trace() {
    let Some(engine) = common::engine() else {
        return;
    };
    let mut scenario = common::scenario();
    scenario.simulation.longest_secs = 1.0;
    let world = World::new(&engine, &scenario, &faultless()).expect("the scenario is sound");
    let episode = run(&world, 1);
    assert!(!episode.trace.complete);
    assert!((episode.sim_secs - 1.0).abs() < 1e-9);
}

#[test]
fn the_trace_shows_the_end_of_sensing_no_later_than_the_decision() {
    let Some(engine) = common::engine() else {
        return;
    };
    let trace = run(&world(&engine, &faultless()), 1).trace;
    let first_time = |topic: &str, field: &str| {
        let channel = trace.channel(topic).expect("a topic of the trace");
        let index = channel
            .fields
            .iter()
            .position(|f| f.name == field)
            .expect("a field");
        let mut rows = channel
            .times_secs
            .iter()
            .zip(channel.values.chunks(channel.fields.len()));
        *rows
            .find(|(_, row)| row[index] > 0.0)
            .expect("it comes about")
            .0
    };
    let decided_secs = first_time("/robot", "decision");
    assert_eq!(first_time("/sensors", "sensing_done"), decided_secs);
    assert!(first_time("/sensors", "all_ok") <= decided_secs);
    assert!(first_time("/truth", "human_ready") < decided_secs);
}

/// An outside that says the same all the time, and breaks off at a time.
struct Constant {
    readings: OutsideReadings,
    until_secs: f64,
    steps: u64,
    rows: usize,
}

impl Constant {
    fn new(readings: OutsideReadings) -> Self {
        Self {
            readings,
            until_secs: f64::INFINITY,
            steps: 0,
            rows: 0,
        }
    }
}

impl Outside for Constant {
    fn step(&mut self, now_secs: f64, recorded: &Trace) -> ControlFlow<()> {
        self.steps += 1;
        let rows = recorded.channels.iter().map(|channel| channel.len()).sum();
        assert!(rows >= self.rows, "rows are only added");
        self.rows = rows;
        match now_secs < self.until_secs {
            true => ControlFlow::Continue(()),
            false => ControlFlow::Break(()),
        }
    }

    fn readings(&self) -> OutsideReadings {
        self.readings
    }
}

#[test]
fn an_outside_that_says_nothing_changes_no_bit_and_sees_every_step() {
    let Some(engine) = common::engine() else {
        return;
    };
    let world = world(&engine, &faultless());
    let expected = run(&world, 1);
    let mut outside = Constant::new(OutsideReadings::default());
    let joined = run_episode_with(&world, 1, &Cancel::default(), &mut outside);
    let joined = joined.expect("the episode runs");
    assert_eq!(bits(&joined.trace), bits(&expected.trace));
    assert_eq!(outside.steps, expected.steps);
    assert!(outside.rows > 0);
}

#[test]
fn the_robot_decides_by_what_a_sensor_outside_says() {
    let Some(engine) = common::engine() else {
        return;
    };
    let world = world(&engine, &faultless());
    assert_eq!(run(&world, 1).outcome.decision, Decision::Release);
    for (says, expected) in [
        (Some(true), Decision::Release),
        (Some(false), Decision::Keep),
        // A sensor that never speaks: the robot gives up.
        (None, Decision::TimeOut),
    ] {
        let mut readings = OutsideReadings::default();
        readings.sensors.pressure = Reading::Outside(says);
        let mut outside = Constant::new(readings);
        let joined = run_episode_with(&world, 1, &Cancel::default(), &mut outside);
        let decision = joined.expect("the episode runs").outcome.decision;
        assert_eq!(decision, expected, "{says:?}");
    }
}

#[test]
fn an_outside_may_break_off() {
    let Some(engine) = common::engine() else {
        return;
    };
    let world = world(&engine, &faultless());
    let mut outside = Constant::new(OutsideReadings::default());
    outside.until_secs = 0.5;
    let joined = run_episode_with(&world, 1, &Cancel::default(), &mut outside);
    assert!(matches!(joined, Err(SimError::Cancelled)));
}
