//! The handover in either engine: physics that can be computed by hand, and that Rapier repeats itself bit for bit.

use crate::common;

use handover::{EngineAlone, HandoverBench, Parameters, Physics, Scenario, World, run_episode};
use testbench::{Bench, Cancel, Distribution, End, Savable, SimError, Unwatched};
use trace::Trace;

/// Gravity of the scenario, m/s².
const GRAVITY: f64 = 9.81;

/// Each engine that is there.
fn engines() -> Vec<Physics> {
    let mujoco = common::engine().map(Physics::from);
    mujoco.into_iter().chain([Physics::Rapier]).collect()
}

/// Parameters under which nothing is drawn that matters here.
fn plain() -> Parameters {
    let mut parameters = common::parameters("tuned");
    let constant = Distribution::Constant;
    parameters.tracking.glitch_rate_per_reading = 0.0;
    parameters.planner.failure_rate_per_run = 0.0;
    parameters.object.mass_kg = constant(0.35);
    parameters.object.x_error_m = constant(0.0);
    parameters.object.y_error_m = constant(0.0);
    parameters.human.pull_forward_newtons = constant(12.0);
    parameters.human.pull_up_newtons = constant(5.0);
    parameters.hand.friction = constant(0.8);
    parameters
}

fn run(physics: &Physics, scenario: &Scenario, parameters: &Parameters, seed: u64) -> Trace {
    let world = World::new(physics, scenario, parameters).expect("sound");
    let episode = run_episode(&world, seed, &Cancel::default());
    episode.expect("it runs").trace
}

/// The samples of a signal, with their times.
fn samples(trace: &Trace, signal: &str) -> Vec<(f64, f64)> {
    let index = trace.signal(signal).expect("it is recorded");
    let channel = &trace.channels[index.channel];
    let rows = channel.values.chunks(channel.fields.len());
    let values = rows.map(|row| row[index.field]);
    channel.times_secs.iter().copied().zip(values).collect()
}

/// Every bit of a trace's numbers.
fn bits(trace: &Trace) -> Vec<u64> {
    let channels = trace.channels.iter();
    let numbers = channels.flat_map(|channel| channel.times_secs.iter().chain(&channel.values));
    numbers.map(|number| number.to_bits()).collect()
}

#[test]
fn an_object_beside_its_pedestal_falls_freely() {
    let mut scenario = common::scenario();
    scenario.object.position_m = [-1.5, 1.5];
    scenario.simulation.longest_secs = 0.4;
    let step_secs = scenario.simulation.time_step_secs;
    for physics in engines() {
        let trace = run(&physics, &scenario, &plain(), 1);
        let heights = samples(&trace, "/truth.object.z");
        let (_, from_m) = heights[0];
        for (at_secs, height_m) in heights {
            // What is asked belongs to the time before the last step; velocities are stepped first: g t (t + h) / 2.
            let secs = (at_secs - step_secs).max(0.0);
            let fallen_m = GRAVITY * secs * (secs + step_secs) / 2.0;
            assert!(
                (from_m - height_m - fallen_m).abs() < 1e-6 + 0.002 * fallen_m,
                "{}: {at_secs} s, {} m, {fallen_m} m",
                physics.name(),
                from_m - height_m
            );
        }
    }
}

/// By hand: once the robot has let go, the human's hand carries the object as a spring does: it hangs lower by m g / k.
#[test]
fn what_the_human_holds_hangs_by_its_weight_on_the_hand_s_spring() {
    let mut scenario = common::scenario();
    scenario.simulation.end_after_secs = 4.0;
    for physics in engines() {
        let trace = run(&physics, &scenario, &plain(), 1);
        let held = samples(&trace, "/truth.human_holds");
        let heights = samples(&trace, "/truth.object.z");
        let taken = held.iter().position(|(_, held)| *held > 0.5);
        let taken = taken.expect("the human takes it");
        let hangs_m = heights[taken].1 - heights[heights.len() - 1].1;
        let by_hand_m = 0.35 * GRAVITY / scenario.human.hold_stiffness_n_m;
        // Where it is taken over from the fingers is known to the rate of tracking.
        assert!(
            (hangs_m / by_hand_m - 1.0).abs() < 0.02,
            "{}: {hangs_m} m, {by_hand_m} m",
            physics.name()
        );
    }
}

/// Long enough for the hand to close on the object, and no longer.
fn until_the_grip() -> Scenario {
    let mut scenario = common::scenario();
    scenario.simulation.longest_secs = 18.0;
    scenario
}

#[test]
fn in_rapier_one_seed_gives_the_same_bits_in_a_used_world_a_fresh_one_and_on_two_threads() {
    let (scenario, parameters) = (until_the_grip(), common::parameters("tuned"));
    let world = || World::new(Physics::Rapier, &scenario, &parameters).expect("sound");
    let run = |world: &World, seed| run_episode(world, seed, &Cancel::default()).expect("it runs");
    let used = world();
    let expected = run(&used, 2);
    assert_eq!(expected.end, End::Longest);
    assert_eq!(expected.trace.metadata["engine"], "Rapier");
    let gripped = samples(&expected.trace, "/truth.hand_contacts");
    assert!(
        gripped.iter().any(|(_, count)| *count > 2.0),
        "the hand closes on it"
    );
    let others = std::thread::scope(|scope| {
        let of_used = scope.spawn(|| bits(&run(&used, 2).trace));
        let of_fresh = scope.spawn(|| bits(&run(&world(), 2).trace));
        [of_used, of_fresh].map(|thread| thread.join().expect("no panic"))
    });
    for other in others {
        assert!(other == bits(&expected.trace));
    }
}

#[test]
fn in_rapier_an_episode_goes_on_from_where_it_was_saved_bit_for_bit() {
    let (scenario, parameters) = (
        common::scenario_text(false),
        common::handover_file("tuned.toml"),
    );
    let scenario = scenario.replace("longest_secs = 240.0", "longest_secs = 18.0");
    let bench = HandoverBench::new(Physics::Rapier, &scenario, &parameters).expect("sound");
    let stimulus = bench.own_test("typical use").expect("the scenario has it");
    let cancel = Cancel::default();
    let whole = bench
        .run(&stimulus, 2, &mut Unwatched, &cancel)
        .expect("it runs")
        .trace;
    let mut begun = bench.start(&stimulus, 2).expect("it starts");
    bench
        .advance(&mut begun, 16.0, &mut Unwatched, &cancel)
        .expect("it runs");
    let saved = bench.save(&begun).expect("it is saved");
    drop(begun);
    let mut resumed = bench.resume(&saved, None).expect("it goes on");
    bench
        .advance(&mut resumed, 100.0, &mut Unwatched, &cancel)
        .expect("it runs");
    let resumed = bench.finish(resumed).expect("it ends").trace;
    assert!(bits(&resumed) == bits(&whole));
}

#[test]
fn in_rapier_the_engine_alone_takes_the_steps_of_the_episode() {
    let mut scenario = common::scenario();
    scenario.simulation.longest_secs = 4.0;
    let world = World::new(Physics::Rapier, &scenario, &common::parameters("tuned"));
    let alone = EngineAlone::record(&world.expect("sound"), 1).expect("it runs");
    let alone = alone.expect("it is the full physics");
    let mut steps = alone.start().expect("it starts");
    assert_eq!(steps.take(), 2000);
    assert!(steps.ended_the_same());
}

#[test]
fn rapier_has_no_fast_physics_and_says_so() {
    let parameters = common::handover_file("tuned.toml");
    let scenario = common::scenario_text(false);
    let bench = HandoverBench::new(Physics::Rapier, &scenario, &parameters).expect("sound");
    assert!(bench.in_fast_physics().is_none());
    let refused = HandoverBench::new(Physics::Rapier, &common::scenario_text(true), &parameters);
    match refused {
        Err(SimError::Engine(error)) => {
            let said = error.to_string();
            assert!(said.contains("Rapier has none"), "{said}");
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("it was taken"),
    }
}
