//! The handover as a bench: stimuli, watching, and runs that are saved and continued.

use crate::common;

use handover::robot::Decision;
use handover::{HandoverBench, run_episode};
use stimulus::{AbstractTest, Action, Distribution, Setting, Stimulus};
use testbench::{Bench, Cancel, Control, End, Savable, SimError, Status, Unwatched, Watch};
use trace::Trace;

fn bench() -> Option<HandoverBench> {
    let engine = common::engine()?;
    let (scenario, parameters) = (
        common::scenario_text(false),
        common::handover_file("tuned.toml"),
    );
    Some(HandoverBench::new(&engine, &scenario, &parameters).expect("the case study is sound"))
}

fn typical(bench: &HandoverBench) -> Stimulus {
    bench
        .own_test("typical use")
        .expect("it is in the scenario")
}

fn set(mut stimulus: Stimulus, key: &str, value: f64) -> Stimulus {
    stimulus
        .settings
        .insert(key.to_owned(), Setting::from(value));
    stimulus
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
fn the_scenario_s_own_test_as_a_stimulus_gives_the_world_s_own_bits() {
    let Some(bench) = bench() else { return };
    let stimulus = typical(&bench);
    let cancel = Cancel::default();
    let recorded = bench
        .run(&stimulus, 5, &mut Unwatched, &cancel)
        .expect("it runs");
    let engine = common::engine().expect("it was there");
    let world = handover::World::new(&engine, &common::scenario(), &common::parameters("tuned"))
        .expect("sound");
    let episode = run_episode(&world, 5, &cancel).expect("it runs");
    assert_eq!(bits(&recorded.trace), bits(&episode.trace));
    assert_eq!(recorded.trace.metadata, episode.trace.metadata);
    assert_eq!(recorded.end, End::Over);
    let layout = bench.layout().expect("sound");
    for (empty, full) in layout.channels.iter().zip(&recorded.trace.channels) {
        assert_eq!((&empty.topic, &empty.fields), (&full.topic, &full.fields));
        assert!(empty.times_secs.is_empty());
    }
}

#[test]
fn settings_reach_scenario_and_parameters_and_wrong_ones_are_named() {
    let Some(bench) = bench() else { return };
    let outcome = |stimulus: &Stimulus| {
        let episode = bench.episode(stimulus, 1, &mut Unwatched, &Cancel::default());
        episode.map(|episode| episode.outcome)
    };
    let slippery = set(typical(&bench), "parameters.hand.friction", 0.02);
    assert!(outcome(&slippery).expect("it runs").grip_failure);
    let blind = set(
        typical(&bench),
        "scenario.sensors.gaze_half_angle_rad",
        0.001,
    );
    let blind = set(blind, "scenario.sensors.gaze_head_radius_m", 0.001);
    let blind = set(blind, "parameters.hand.friction", 0.8);
    let blind = set(blind, "parameters.planner.failure_rate_per_run", 0.0);
    let seen = outcome(&blind).expect("it runs");
    assert_eq!((seen.gaze_ok, seen.decision), (Some(false), Decision::Keep));
    for (key, value, expected) in [
        ("parameters.hand.fiction", 0.5, "friction"),
        ("friction", 0.5, "friction"),
        ("parameters.hand.friction", -1.0, "hand.friction"),
        ("scenario.rates.tracking_hz", 120.0, "tracking_hz"),
    ] {
        let error = outcome(&set(typical(&bench), key, value)).expect_err("it is refused");
        assert!(matches!(error, SimError::Stimulus { .. }), "{error:?}");
        assert!(error.to_string().contains(expected), "{error}");
    }
}

#[test]
fn a_test_made_from_data_is_enacted_and_a_word_it_does_not_know_is_named() {
    let Some(bench) = bench() else { return };
    let cancel = Cancel::default();
    let delay = Distribution::Triangular {
        low: 0.1,
        mode: 0.2,
        high: 0.9,
    };
    let test = |actions| Stimulus::of(AbstractTest::new("made", actions));
    let made = test(vec![
        Action::send("activate").after(delay),
        Action::receive("announcement"),
    ]);
    let run = |stimulus: &Stimulus, seed| bench.run(stimulus, seed, &mut Unwatched, &cancel);
    let (first, again) = (run(&made, 3), run(&made, 3));
    let (first, again) = (first.expect("it runs"), again.expect("it runs"));
    assert_eq!(first.trace.metadata["abstract_test"], "made");
    assert_eq!(bits(&first.trace), bits(&again.trace));
    for (action, expected) in [
        (Action::send("sing"), "activate or ready"),
        (Action::receive("song"), "announcement"),
        (Action::set("mood", true), "gaze, pressure or location"),
        (Action::set("gaze", 3.0), "true or false"),
    ] {
        let error = run(&test(vec![action]), 3).expect_err("it is refused");
        assert!(error.to_string().contains(expected), "{error}");
    }
}

/// Keeps every row it sees, and has seen enough at a time.
struct Witness {
    rows: Vec<(usize, u64, Vec<u64>)>,
    until_secs: f64,
}

impl Watch for Witness {
    fn row(&mut self, topic: usize, time_secs: f64, values: &[f64]) -> Control {
        let values = values.iter().map(|value| value.to_bits()).collect();
        self.rows.push((topic, time_secs.to_bits(), values));
        if time_secs >= self.until_secs {
            Control::Finish
        } else {
            Control::Continue
        }
    }
}

#[test]
fn a_watch_sees_each_row_as_recorded_and_ends_the_run() {
    let Some(bench) = bench() else { return };
    let mut witness = Witness {
        rows: Vec::new(),
        until_secs: 6.5,
    };
    let recorded = bench
        .run(&typical(&bench), 2, &mut witness, &Cancel::default())
        .expect("it runs");
    assert_eq!(recorded.end, End::Watched);
    assert!(!recorded.trace.complete, "its end is not the run's");
    assert!(
        (recorded.sim_secs - 6.502).abs() < 1e-9,
        "{}",
        recorded.sim_secs
    );
    for (index, channel) in recorded.trace.channels.iter().enumerate() {
        let seen = witness.rows.iter().filter(|(topic, ..)| *topic == index);
        let (times, values): (Vec<_>, Vec<_>) = seen
            .map(|(_, time, values)| (*time, values.clone()))
            .unzip();
        let recorded_times: Vec<u64> = channel.times_secs.iter().map(|t| t.to_bits()).collect();
        let recorded_values: Vec<u64> = channel.values.iter().map(|v| v.to_bits()).collect();
        assert_eq!(times, recorded_times, "{}", channel.topic);
        assert_eq!(values.concat(), recorded_values, "{}", channel.topic);
    }
}

/// A run with seed 2 up to a time.
fn started(bench: &HandoverBench, until_secs: f64) -> handover::RunningHandover {
    let mut running = bench.start(&typical(bench), 2).expect("it starts");
    let status = bench
        .advance(&mut running, until_secs, &mut Unwatched, &Cancel::default())
        .expect("it runs");
    assert_eq!(status, Status::Running);
    running
}

fn finished(bench: &HandoverBench, mut running: handover::RunningHandover) -> Trace {
    let cancel = Cancel::default();
    let status = bench.advance(&mut running, f64::INFINITY, &mut Unwatched, &cancel);
    assert_eq!(status.expect("it runs"), Status::Ended(End::Over));
    bench.finish(running).expect("it ends").trace
}

#[test]
fn a_saved_run_continues_bit_for_bit_wherever_it_is_saved() {
    let Some(bench) = bench() else { return };
    let whole = bench
        .run(&typical(&bench), 2, &mut Unwatched, &Cancel::default())
        .expect("it runs")
        .trace;
    // Reset, on the way, closing the hand, carrying, held and waiting, under the pull.
    for until_secs in [0.0, 3.013, 14.3, 15.9, 19.002, 24.0, 28.71] {
        let running = started(&bench, until_secs);
        let saved = bench.save(&running).expect("memory suffices");
        let resumed = bench.resume(&saved, None).expect("memory suffices");
        drop(saved);
        for (which, run) in [("saved", running), ("resumed", resumed)] {
            let trace = finished(&bench, run);
            assert_eq!(trace.metadata, whole.metadata);
            assert!(bits(&trace) == bits(&whole), "{which} at {until_secs} s");
        }
    }
}

#[test]
fn a_run_resumed_with_another_seed_keeps_the_past_and_draws_the_rest_anew() {
    let Some(bench) = bench() else { return };
    let running = started(&bench, 15.0);
    let saved = bench.save(&running).expect("memory suffices");
    let resumed = |seed| {
        let run = bench.resume(&saved, Some(seed)).expect("memory suffices");
        finished(&bench, run)
    };
    let (old, a, again, b) = (
        finished(&bench, running),
        resumed(7),
        resumed(7),
        resumed(8),
    );
    assert_eq!(bits(&a), bits(&again));
    for key in ["object_mass_kg", "friction", "object_x_m"] {
        assert_eq!(a.metadata[key], old.metadata[key], "{key} stays");
    }
    assert_eq!(a.metadata["resumed_with_seed"], "7");
    let signal = |trace: &Trace, topic: &str, field: &str| {
        let channel = trace.channel(topic).expect("a topic").clone();
        let field = channel.field_index(field).expect("a field");
        let rows = channel.values.chunks(channel.fields.len());
        let values: Vec<f64> = rows.map(|row| row[field]).collect();
        (channel.times_secs, values)
    };
    let (times, reported) = signal(&old, "/tracking", "object.x");
    let past = times.iter().filter(|time| **time < 15.0).count();
    let mut pulls = Vec::new();
    for trace in [&old, &a, &b] {
        assert_eq!(
            signal(trace, "/tracking", "object.x").1[..past],
            reported[..past]
        );
        pulls.push(
            signal(trace, "/truth", "pull")
                .1
                .into_iter()
                .fold(0.0, f64::max),
        );
    }
    for (one, other) in [(&old, &a), (&a, &b)] {
        let now = |trace| signal(trace, "/tracking", "object.x").1[past + 1];
        assert_ne!(now(one), now(other), "the noise is drawn anew");
    }
    assert!(pulls[0] != pulls[1] && pulls[1] != pulls[2], "{pulls:?}");
    let (times, pull) = signal(&old, "/truth", "pull");
    let began = pull.iter().position(|newtons| *newtons > 0.0);
    let later = started(&bench, times[began.expect("it pulls")] + 0.5);
    let saved = bench.save(&later).expect("memory suffices");
    let late = bench.resume(&saved, Some(7)).expect("memory suffices");
    let pull = signal(&finished(&bench, late), "/truth", "pull").1;
    let pull = pull.into_iter().fold(0.0, f64::max);
    assert_eq!(pull, pulls[0], "a pull that has begun stays");
}

#[test]
fn with_its_draws_as_settings_a_run_is_the_same_whatever_the_seed_would_draw() {
    let Some(engine) = common::engine() else {
        return;
    };
    for (parameters, expected) in [("untuned.toml", 9), ("tuned.toml", 1)] {
        let (scenario, parameters) = (
            common::scenario_text(false),
            common::handover_file(parameters),
        );
        let bench = HandoverBench::new(&engine, &scenario, &parameters).expect("sound");
        let stimulus = typical(&bench);
        let drawn = bench.drawn(&stimulus, 5).expect("it fits");
        assert!(drawn.len() >= expected, "{drawn:?}");
        let mut pinned = stimulus.clone();
        for number in &drawn {
            pinned = set(pinned, &number.key, number.value);
        }
        assert!(bench.drawn(&pinned, 5).expect("it fits").is_empty());
        let cancel = Cancel::default();
        let run = |stimulus: &Stimulus| bench.run(stimulus, 5, &mut Unwatched, &cancel);
        let (before, after) = (
            run(&stimulus).expect("it runs"),
            run(&pinned).expect("it runs"),
        );
        assert_eq!(bits(&before.trace), bits(&after.trace));
        // Under another seed the same numbers are there still.
        let other = bench.drawn(&stimulus, 6).expect("it fits");
        assert!(other.iter().zip(&drawn).all(|(a, b)| a.key == b.key));
        assert!(other.iter().zip(&drawn).any(|(a, b)| a.value != b.value));
    }
}
