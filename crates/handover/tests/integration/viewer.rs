//! What a viewer is shown is where things are, and looking changes nothing.

use crate::common;

use handover::HandoverBench;
use testbench::{Bench, Cancel, Unwatched, ViewKeeper};
use trace::Trace;

/// The value of a signal at each of its rows.
fn signal(trace: &Trace, name: &str) -> Vec<(f64, f64)> {
    let index = trace.signal(name).unwrap_or_else(|| panic!("no {name}"));
    let channel = &trace.channels[index.channel];
    let times = channel.times_secs.iter().enumerate();
    times
        .map(|(row, time)| (*time, channel.row(row)[index.field]))
        .collect()
}

/// The largest distance between what is seen of a body and what is recorded of it, along each axis.
fn largest_difference(keeper: &ViewKeeper, trace: &Trace, body: &str, topic: &str) -> f64 {
    let body = keeper.geometry.bodies.iter().position(|it| it == body);
    let body = body.expect("it is to be seen");
    let mut largest: f64 = 0.0;
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let Some(_) = trace.signal(&format!("{topic}{name}")) else {
            continue;
        };
        let recorded = signal(trace, &format!("{topic}{name}"));
        assert_eq!(recorded.len(), keeper.times_secs.len(), "{topic}{name}");
        for ((time_secs, value), (seen_secs, poses)) in recorded
            .iter()
            .zip(keeper.times_secs.iter().zip(&keeper.poses))
        {
            assert_eq!(time_secs, seen_secs);
            largest = largest.max((poses[body].position_m[axis] - value).abs());
        }
    }
    largest
}

#[test]
fn the_handover_is_seen_as_it_is_recorded_and_recorded_as_if_unseen() {
    let Some(engine) = common::engine() else {
        return;
    };
    let (scenario, parameters) = (
        common::scenario_text(false),
        common::handover_file("tuned.toml"),
    );
    let bench = HandoverBench::new(&engine, &scenario, &parameters).expect("sound");
    let stimulus = bench.own_test("typical use").expect("it is there");
    let cancel = Cancel::default();
    let mut keeper = ViewKeeper::default();
    let seen = bench
        .run(&stimulus, 5, &mut keeper, &cancel)
        .expect("it runs");
    let unseen = bench.run(&stimulus, 5, &mut Unwatched, &cancel);
    assert!(seen == unseen.expect("it runs"), "looking changed it");
    assert_eq!(keeper.times_secs.len(), keeper.poses.len());
    assert!(keeper.times_secs.windows(2).all(|pair| pair[0] < pair[1]));
    let hand_m = largest_difference(&keeper, &seen.trace, "left_wrist_flex", "/robot.hand.");
    let object_m = largest_difference(&keeper, &seen.trace, "object", "/truth.object.");
    let head_m = largest_difference(&keeper, &seen.trace, "human_head", "/truth.human_head.");
    let human_m = largest_difference(&keeper, &seen.trace, "human_hand", "/truth.human_hand.");
    // The engine's poses are those of the step before; the hand moves at most 1 mm in a step.
    assert!(hand_m < 1e-3, "the hand is {hand_m} m off");
    assert!(object_m == 0.0 && head_m == 0.0 && human_m == 0.0);
    for body in keeper.poses.iter().flatten() {
        let squares: f64 = body.orientation.iter().map(|it| it * it).sum();
        assert!((squares - 1.0).abs() < 1e-6, "{body:?}");
    }
}
