//! The handover as recordings of a ROS 2 robot: what a simulated episode says in its own signals and in ROS 2 messages
//! is the same, and the bags that come with the case study have the verdicts that its README states.
//!
//! What simulates needs the physics library. Without it those tests are skipped with a line that says so, except in
//! continuous integration, where nothing is skipped.

use crate::support;

use recording::{OpenOptions, SignalStream, TopicMap};
use serde_json::Value;
use std::path::Path;
use support::program::{Said, corroborate};
use support::root;
use support::simulation::{handover, library, simulating};
use trace::{SignalValues, Trace};

/// The bags that come with the case study, with what is violated in each; all else is satisfied or did not come up.
const BAGS: [(&str, &[&str]); 3] = [
    ("episode-00002.mcap", &["1a", "1b", "grip_failure"]),
    (
        "episode-00019.mcap",
        &["1a", "1b", "3, human", "false_negative_pressure"],
    ),
    ("episode-00021.mcap", &[]),
];

/// What comes up in every episode in which the robot decides: it is satisfied where it is not violated.
const ALWAYS_COVERED: [&str; 9] = [
    "1a",
    "1b",
    "4",
    "5",
    "5b",
    "6",
    "7",
    "runtime_error",
    "grip_failure",
];

/// Half of what a nanosecond is, to which the times of messages are rounded.
const ROUNDING_SECS: f64 = 0.5e-9 + 1e-12;

/// Simulates `episodes` of `evidence` in `form` into `out`.
fn simulate(library: &Path, evidence: &str, episodes: &str, form: &str, out: &Path) -> Said {
    let study = handover();
    let (study, out) = (study.to_string_lossy(), out.to_string_lossy());
    let arguments = [
        "simulate",
        &study,
        evidence,
        "--episodes",
        episodes,
        "--as",
        form,
        "--out",
        &out,
    ];
    let said = simulating(library, &root(), &arguments);
    // Bags are not judged; a few episodes decide nothing of 95 in 100, or deny it.
    let codes: &[i32] = match form {
        "ros2" => &[0],
        _ => &[1, 3],
    };
    assert!(codes.contains(&said.code), "{said:?}");
    said
}

/// The report on the recordings in a folder, one for each recording.
fn monitored(folder: &Path) -> Vec<Value> {
    let (study, folder) = (handover(), folder.to_string_lossy());
    let study = study.to_string_lossy();
    let said = corroborate(&root(), &["monitor", &study, &folder, "--format", "json"]);
    let report: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
    report["recordings"].as_array().expect("a list").clone()
}

fn verdicts(recording: &Value) -> &[Value] {
    recording["verdicts"].as_array().expect("a list")
}

fn name(verdict: &Value) -> String {
    let subject = verdict["subject"].as_str().expect("a name");
    match verdict["reading"].as_str() {
        Some(reading) => format!("{subject}, {reading}"),
        None => subject.to_owned(),
    }
}

#[test]
fn the_bags_of_the_case_study_have_their_verdicts() {
    let judged = monitored(&handover().join("recordings"));
    assert_eq!(judged.len(), BAGS.len());
    for (recording, (file, violated)) in judged.iter().zip(BAGS) {
        assert!(
            recording["file"]
                .as_str()
                .is_some_and(|f| f.ends_with(file))
        );
        assert_eq!(recording["complete"], true, "{file}");
        assert_eq!(recording["notes"], serde_json::json!([]), "{file}");
        let with = |wanted: &str| -> Vec<String> {
            let all = verdicts(recording).iter();
            all.filter(|v| v["verdict"] == wanted).map(name).collect()
        };
        assert_eq!(with("violated"), violated, "{file}");
        let satisfied = with("satisfied");
        for covered in ALWAYS_COVERED {
            let is_satisfied = satisfied.iter().any(|name| name == covered);
            assert_ne!(
                is_satisfied,
                violated.contains(&covered),
                "{file}: {covered}"
            );
        }
        let open = verdicts(recording).len() - satisfied.len() - violated.len();
        assert_eq!(with("not-covered").len(), open, "{file}");
    }
}

#[test]
fn an_episode_in_ros2_messages_is_judged_as_in_its_own_signals() {
    let Some(library) = library() else {
        return;
    };
    let folder = tempfile::TempDir::new().expect("a folder");
    for (evidence, episodes) in [("E2", "3"), ("E4", "2")] {
        let [own, ros2] = ["corroborate", "ros2"].map(|form| {
            let out = folder.path().join(format!("{evidence}-{form}"));
            simulate(&library, evidence, episodes, form, &out);
            monitored(&out)
        });
        assert_eq!(own.len().to_string(), episodes);
        assert_eq!(own.len(), ros2.len());
        for (own, ros2) in own.iter().zip(&ros2) {
            assert_eq!(verdicts(own).len(), verdicts(ros2).len());
            for (own, ros2) in verdicts(own).iter().zip(verdicts(ros2)) {
                assert_same_verdict(own, ros2);
            }
        }
    }
}

#[track_caller]
fn assert_same_verdict(own: &Value, ros2: &Value) {
    let same = [
        "subject",
        "reading",
        "verdict",
        "covered",
        "passed",
        "failed",
        "failed_proposition",
    ];
    for key in same {
        assert_eq!(own[key], ros2[key], "{key} of {own}");
    }
    match (
        own["failed_at_secs"].as_f64(),
        ros2["failed_at_secs"].as_f64(),
    ) {
        (Some(own), Some(ros2)) => assert!((own - ros2).abs() <= ROUNDING_SECS),
        (own, ros2) => assert_eq!(own, ros2),
    }
}

/// Every signal of the topic map at every instant: numbers exactly, truth values, and the names of states.
#[test]
fn every_signal_survives_in_ros2_messages() {
    let Some(library) = library() else {
        return;
    };
    let folder = tempfile::TempDir::new().expect("a folder");
    let [own, ros2] = ["corroborate", "ros2"].map(|form| {
        let out = folder.path().join(form);
        simulate(&library, "E2", "1", form, &out);
        out.join("episode-00001.mcap")
    });
    let own = recording::read_mcap(&own).expect("our own recording").trace;
    let map = TopicMap::read(&handover().join("topics.toml")).expect("a topic map");
    let wanted: Vec<String> = map.signal_names().collect();
    let reader = recording::open(&ros2, &OpenOptions::default()).expect("a bag");
    let mut stream = SignalStream::new(reader, &map, &wanted).expect("all signals are there");
    let mut compared = 0_u64;
    while let Some(instant) = stream.next_instant().expect("a bag that is whole") {
        for signal in &wanted {
            let expected = value_at(&own, signal, instant.time_secs);
            let index = stream
                .layout()
                .signal(signal)
                .expect("a signal of the stream");
            let found = stream.snapshot().raw(index);
            let same = expected == found || expected.is_nan() && found.is_nan();
            assert!(
                same,
                "{signal} at {}: {expected}, not {found}",
                instant.time_secs
            );
            compared += 1;
        }
    }
    assert!(compared > 10_000, "only {compared} values");
}

/// The value of a signal at a time, held since its last row.
fn value_at(trace: &Trace, name: &str, time_secs: f64) -> f64 {
    let signal = trace.signal(name).unwrap_or_else(|| panic!("no {name}"));
    let channel = &trace.channels[signal.channel];
    let seen = channel
        .times_secs
        .partition_point(|&t| t <= time_secs + ROUNDING_SECS);
    let row = seen
        .checked_sub(1)
        .map(|row| channel.row(row)[signal.field]);
    row.unwrap_or(f64::NAN)
}
