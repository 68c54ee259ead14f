//! The fast physics against the full one: the same trajectories within stated bounds, and runs that
//! are saved and continued bit for bit. Counts over many episodes are compared by
//! `examples/fast_against_full.rs`.

use crate::common;

use handover::{HandoverBench, Outcome, Scenario, World, run_episode};
use testbench::{Bench, Cancel, Engine, Savable, Unwatched};
use trace::Trace;

fn world(engine: &Engine, set: &str, fast: bool) -> World {
    let mut scenario = common::scenario();
    scenario.simulation.fast = fast;
    World::new(engine, &scenario, &common::parameters(set)).expect("the case study is sound")
}

fn episode(world: &World, seed: u64) -> (Trace, Outcome) {
    let episode = run_episode(world, seed, &Cancel::default()).expect("it runs");
    (episode.trace, episode.outcome)
}

/// Times and one field of a topic.
fn signal(trace: &Trace, topic: &str, field: &str) -> (Vec<f64>, Vec<f64>) {
    let channel = trace.channel(topic).expect("a topic of the trace");
    let index = channel.field_index(field).expect("a field of the topic");
    let rows = channel.values.chunks(channel.fields.len());
    (
        channel.times_secs.clone(),
        rows.map(|row| row[index]).collect(),
    )
}

/// The largest difference of a signal between two traces within a stretch of time.
fn apart(traces: [&Trace; 2], topic: &str, field: &str, [from_secs, to_secs]: [f64; 2]) -> f64 {
    let [(times, a), (_, b)] = traces.map(|trace| signal(trace, topic, field));
    let rows = times.iter().zip(a.iter().zip(&b));
    rows.filter(|(time, _)| (from_secs..to_secs).contains(*time))
        .map(|(_, (a, b))| (a - b).abs())
        .fold(0.0, f64::max)
}

/// When the robot's state becomes `state`.
fn enters(trace: &Trace, state: handover::robot::State) -> f64 {
    let names = handover::robot::State::NAMES;
    let wanted = names.iter().position(|(name, _)| *name == state);
    let wanted = wanted.expect("a state of the robot") as f64;
    let (times, states) = signal(trace, "/robot", "state");
    let index = states.iter().position(|state| *state == wanted);
    times[index.expect("the robot comes to it")]
}

#[test]
fn the_hand_goes_its_way_and_outcomes_are_those_of_the_full_physics() {
    let Some(engine) = common::engine() else {
        return;
    };
    use handover::robot::State::{Grasp, Lift, Sense};
    // Episodes in which the object settles alike in the hand, chosen for that among the first ones: of tuned episodes 2 to
    // 40 half differ by less than 1 mm. In the others it has two ways to settle, some millimetres apart, as in episodes 1,
    // 6 and 9, where the full physics itself takes the other one once its object is displaced by 1 to 10 micrometres
    // (`FULL_NUDGED=1e-5` of `examples/fast_against_full.rs`). In episode 7 both drop it.
    for (set, seed) in [("tuned", 2), ("tuned", 5), ("untuned", 1), ("untuned", 4)] {
        let (full, full_outcome) = episode(&world(&engine, set, false), seed);
        let (fast, fast_outcome) = episode(&world(&engine, set, true), seed);
        assert_ne!(full, fast, "the fast physics is on");
        for state in [Grasp, Lift, Sense] {
            let times = [&full, &fast].map(|trace| enters(trace, state));
            assert_eq!(times[0], times[1], "states change at the same ticks");
        }
        // The object begins at a distance of 0 from what it stands on, so that rounding says whether
        // it falls for one step; it has settled by half a second.
        let (empty, held) = (
            [0.5, enters(&full, Grasp)],
            [enters(&full, Lift), enters(&full, Sense)],
        );
        let within = |topic: &str, field: &str, when: [f64; 2], limit: f64| {
            let difference = apart([&full, &fast], topic, field, when);
            assert!(difference < limit, "{set} {seed}: {field} by {difference}");
        };
        for axis in ["x", "y", "z"] {
            // Light fingers of the empty hand do not push the arm while it speeds up; heavy ones do.
            let closely = if set == "untuned" { 1e-5 } else { 1e-4 };
            within("/robot", &format!("hand.{axis}"), empty, closely);
            within("/truth", &format!("object.{axis}"), empty, 1e-5);
            // How the object comes to lie in the hand depends on how the fingers first met it.
            within("/robot", &format!("hand.{axis}"), held, 1e-4);
            let loosely = if set == "untuned" { 3e-4 } else { 1e-3 };
            within("/truth", &format!("object.{axis}"), held, loosely);
        }
        within("/robot", "hand_speed", empty, 5e-3);
        assert_eq!(full_outcome.grip_failure, fast_outcome.grip_failure);
        assert_eq!(full_outcome.decision, fast_outcome.decision, "{set} {seed}");
        let peaks = [&full_outcome, &fast_outcome].map(|outcome| outcome.reset_peak_speed_m_s);
        assert!(
            (peaks[0] - peaks[1]).abs() < 1e-3,
            "{set} {seed}: {peaks:?}"
        );
    }
}

#[test]
fn without_the_key_the_physics_is_the_full_one() {
    let text = common::handover_file("scenario.toml");
    let lines = text.lines().filter(|line| !line.starts_with("fast ="));
    let text = lines.collect::<Vec<_>>().join("\n");
    let scenario = Scenario::parse(&text).expect("the scenario is sound");
    assert!(!scenario.simulation.fast);
}

#[test]
fn a_fast_run_is_repeated_on_any_thread_and_continued_bit_for_bit() {
    let Some(engine) = common::engine() else {
        return;
    };
    // Coasting empty, closing the hand, carrying, held, under the pull; and with fingers that swing while the empty arm
    // speeds up, while it carries, and after they were bent.
    let moments: [(&str, &[f64]); 2] = [
        ("tuned", &[3.0, 15.013, 19.0, 26.0, 30.5]),
        ("untuned", &[0.55, 18.01, 31.5]),
    ];
    for (set, moments) in moments {
        continued(&engine, set, moments);
    }
}

/// Runs episode 2 of a set, on two threads and from each of these moments on, and compares all bits.
fn continued(engine: &Engine, set: &str, moments: &[f64]) {
    let scenario = common::scenario_text(true);
    let parameters = common::handover_file(&format!("{set}.toml"));
    let bench = HandoverBench::new(engine, &scenario, &parameters).expect("sound");
    let stimulus = bench.own_test("typical use").expect("it is there");
    let cancel = Cancel::default();
    let run = || {
        let recorded = bench.run(&stimulus, 2, &mut Unwatched, &cancel);
        recorded.expect("it runs").trace
    };
    let [whole, other] = std::thread::scope(|scope| {
        let threads = [scope.spawn(run), scope.spawn(run)];
        threads.map(|thread| thread.join().expect("no panic"))
    });
    assert!(other == whole, "{set}: repeated on another thread");
    for until_secs in moments {
        let mut running = bench.start(&stimulus, 2).expect("it starts");
        bench
            .advance(&mut running, *until_secs, &mut Unwatched, &cancel)
            .expect("it runs");
        let saved = bench.save(&running).expect("memory suffices");
        let mut resumed = bench.resume(&saved, None).expect("memory suffices");
        bench
            .advance(&mut resumed, f64::INFINITY, &mut Unwatched, &cancel)
            .expect("it runs");
        let trace = bench.finish(resumed).expect("it ends").trace;
        assert!(trace == whole, "{set}: continued from {until_secs} s");
    }
}
