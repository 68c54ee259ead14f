//! `corroborate monitor` and `corroborate inspect` on recordings that another library wrote.
//!
//! `crates/recording/tests/files/make_rosbags.py` says what is in them: on /joint_states, each 100 ms, position[0] = i / 7
//! and velocity[0] = -2 i / 7 for i from 0 to 11.

use crate::support;

use recording::{Extractor, FieldPath, OpenOptions};
use std::path::{Path, PathBuf};
use support::program::{Said, corroborate};
use support::schema::violations;
use support::{read, root};
use tempfile::TempDir;

const MAP: &str = r#"
["/arm.shoulder"]
from = "/joint_states.position[0]"
unit = "rad"
["/arm.speed"]
from = "/joint_states.velocity[0]"
unit = "rad/s"
["/robot.ready"]
from = "/ready.data"
kind = "bool"
"#;

/// Violated by i = 7, where 7 / 7 > 0.9; the worst is i = 11.
const BELOW: &str = "always (/arm.shoulder < 900 mrad)";

fn rosbag(name: &str) -> PathBuf {
    root()
        .join("crates/recording/tests/files/rosbags")
        .join(name)
}

/// A folder with the topic map `map.toml`.
fn folder() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("map.toml"), MAP).expect("written");
    folder
}

fn monitor(folder: &Path, formula: &str, more: &[&str]) -> Said {
    let mut arguments = vec!["monitor", "--map", "map.toml", "--formula", formula];
    arguments.extend(more);
    corroborate(folder, &arguments)
}

fn json(said: &Said) -> serde_json::Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

#[track_caller]
fn assert_conforms(name: &str, said: &Said) {
    let schema = read(&root().join("schemas").join(name));
    let schema = serde_json::from_str(&schema).expect("a schema is JSON");
    let found = violations(&schema, &json(said));
    assert!(found.is_empty(), "not as {name} says: {found:?}");
}

fn shown(path: &Path) -> String {
    path.display().to_string()
}

fn near(value: &serde_json::Value, expected: f64) -> bool {
    value
        .as_f64()
        .is_some_and(|it| (it - expected).abs() < 1e-9)
}

#[test]
fn every_format_has_the_same_verdict_robustness_and_reason() {
    let folder = folder();
    for name in [
        "mcap",
        "mcap_file",
        "sqlite",
        "split",
        "none.bag",
        "bz2.bag",
        "lz4.bag",
    ] {
        let file = shown(&rosbag(name));
        let said = monitor(folder.path(), BELOW, &[&file, "--format", "json"]);
        assert_eq!(said.code, 1, "{said:?}");
        assert_conforms("monitor.schema.json", &said);
        let verdict = json(&said)["recordings"][0]["verdicts"][0].clone();
        assert_eq!(verdict["verdict"], "violated", "{verdict}");
        for side in ["least", "greatest"] {
            let robustness = &verdict["robustness"][side];
            assert!(near(robustness, 0.9 - 11.0 / 7.0), "{name}: {verdict}");
        }
        assert!(near(&verdict["decided_at_secs"], 0.7), "{name}: {verdict}");
        assert!(near(&verdict["violation"]["from_secs"], 0.7), "{verdict}");
        let part = &verdict["violation"]["responsible"][0];
        assert_eq!(part["proposition"], "/arm.shoulder < 900 mrad");
        assert_eq!(part["signals"][0]["name"], "/arm.shoulder");
        assert_eq!(part["signals"][0]["unit"], "rad");
    }
}

#[test]
fn the_time_and_the_ending_are_those_of_the_call() {
    let folder = folder();
    let file = shown(&rosbag("mcap"));
    // Nothing falls below -2.5 rad/s before i = 9, and then the deadline has passed.
    let late = "eventually[0, 800 ms] (/arm.speed < -2.5 rad/s)";
    let in_time = "eventually[0, 900 ms] (/arm.speed < -2.5 rad/s)";
    for time in ["log", "publish", "header"] {
        let code = |formula: &str| monitor(folder.path(), formula, &[&file, "--time", time]).code;
        assert_eq!((code(late), code(in_time)), (1, 0), "{time}");
    }
    let said = monitor(folder.path(), late, &[&file, "--time", "clock"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("/clock"), "{said:?}");
    let more = "always (/arm.shoulder < 3 rad)";
    let endings = [
        ("finite", 0),
        ("weak", 0),
        ("inconclusive", 3),
        ("strong", 1),
    ];
    for (ending, code) in endings {
        let said = monitor(folder.path(), more, &[&file, "--ending", ending]);
        assert_eq!(said.code, code, "{ending}: {said:?}");
    }
    assert_eq!(monitor(folder.path(), in_time, &[&file, "--dense"]).code, 0);
}

#[test]
fn a_folder_is_a_set_of_trials() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("trials")).expect("a folder");
    let names = ["none.bag", "bz2.bag", "lz4.bag"];
    for (number, name) in names.iter().enumerate() {
        let copy = folder.path().join(format!("trials/run{}.bag", number * 5));
        std::fs::copy(rosbag(name), copy).expect("copied");
    }
    let said = monitor(folder.path(), BELOW, &["trials", "--format", "json"]);
    let report = json(&said);
    assert_eq!((said.code, &report["totals"][0]["failed"]), (1, &3.into()));
    let files: Vec<&str> = (0..3)
        .map(|place| report["recordings"][place]["file"].as_str().unwrap_or(""))
        .collect();
    assert_eq!(
        files,
        ["trials/run0.bag", "trials/run5.bag", "trials/run10.bag"]
    );
}

#[test]
fn what_is_lost_is_said_with_its_place_and_never_a_success() {
    let folder = folder();
    let whole = std::fs::read(rosbag("mcap/mcap.mcap")).expect("a recording");
    let cut = folder.path().join("cut.mcap");
    std::fs::write(&cut, &whole[..whole.len() / 2]).expect("written");
    let holds = "always (/arm.shoulder < 3 rad)";
    for file in [shown(&cut), shown(&rosbag("unfinished.bag"))] {
        let refused = monitor(folder.path(), holds, &[&file]);
        assert_eq!((refused.code, refused.out.as_str()), (2, ""), "{refused:?}");
        assert!(refused.talk.contains("recording-cut-short"), "{refused:?}");
        assert!(refused.talk.contains("at byte"), "{refused:?}");
        for formula in [holds, BELOW] {
            let said = monitor(folder.path(), formula, &[&file, "--partial"]);
            assert_eq!(said.code, 3, "{said:?}");
            assert!(said.out.contains("lost: at byte"), "{said:?}");
            let inspected = corroborate(folder.path(), &["inspect", &file]);
            assert_eq!(inspected.code, 3, "{inspected:?}");
            assert!(inspected.out.contains("lost at byte"), "{inspected:?}");
        }
    }
}

/// A flipped byte anywhere gives the verdict and robustness of the whole recording, or is told as a loss, or is refused.
/// The recording is violated by its last message: 3 is not below 2.5.
#[test]
fn damaged_recordings_end_in_a_known_way() {
    let folder = folder();
    let whole = std::fs::read(root().join("crates/recording/tests/files/mcap/ros2_small.mcap"))
        .expect("a recording");
    let file = folder.path().join("damaged.mcap");
    let call = || {
        let formula = "always (/arm.shoulder < 2.5)";
        let said = monitor(
            folder.path(),
            formula,
            &["damaged.mcap", "--format", "json"],
        );
        let verdict = (said.code == 1).then(|| json(&said)["recordings"][0].clone());
        (said, verdict)
    };
    std::fs::write(&file, &whole).expect("written");
    let (said, expected) = call();
    assert!(
        near(
            &expected.as_ref().expect("violated")["verdicts"][0]["robustness"]["least"],
            -0.5
        ),
        "{said:?}"
    );
    let mut refused = 0;
    for place in (0..whole.len()).step_by(whole.len() / 40) {
        let mut bytes = whole.clone();
        bytes[place] ^= 0x5a;
        std::fs::write(&file, &bytes).expect("written");
        let inspected = corroborate(folder.path(), &["inspect", "damaged.mcap"]);
        let (said, verdict) = call();
        if said.code == 1 {
            assert_eq!(verdict, expected, "byte {place}");
            continue;
        }
        assert_eq!(said.code, 2, "byte {place}: {said:?}");
        assert!(said.talk.contains("damaged.mcap"), "byte {place}: {said:?}");
        assert!(
            [2, 3].contains(&inspected.code),
            "byte {place}: {inspected:?}"
        );
        refused += 1;
    }
    assert!(refused > 20, "{refused}");
}

#[test]
fn verdicts_over_time_lie_beside_the_recording() {
    let folder = folder();
    let file = shown(&rosbag("mcap"));
    let arguments = [&file, "--verdicts", "shown", "--format", "json"];
    let said = monitor(folder.path(), BELOW, &arguments);
    assert_eq!(said.code, 1, "{said:?}");
    let path = folder.path().join("shown/mcap.verdicts.mcap");
    let name = json(&said)["recordings"][0]["shown_in"].clone();
    assert_eq!(name, "shown/mcap.verdicts.mcap");

    let mut reader = recording::open(&path, &OpenOptions::default()).expect("it opens");
    let topic = reader
        .topics()
        .iter()
        .find(|topic| topic.name == "/corroborate/formula/robustness")
        .expect("the robustness is there")
        .clone();
    let paths = [FieldPath::parse("data").expect("a path")];
    let mut extractor = Extractor::new(&topic, &paths).expect("a number");
    reader.select(&|info| info.id == topic.id);
    let (mut values, mut instant) = ([0.0], 0_u32);
    while let Some(message) = reader.next().expect("it is whole") {
        extractor
            .extract(message.data, &mut values)
            .expect("a number");
        // The worst so far, as position[0] only grows.
        let expected = 0.9 - f64::from(instant) / 7.0;
        assert!(
            (values[0] - expected).abs() < 1e-12,
            "{values:?} at {instant}"
        );
        let nanos = 1_700_000_000_000_000_000 + i64::from(instant) * 100_000_000;
        assert_eq!(message.log_nanos, nanos);
        instant += 1;
    }
    assert_eq!(instant, 12);

    let before = std::fs::read(&path).expect("a file");
    let again = monitor(folder.path(), BELOW, &arguments);
    assert_eq!(again.code, 2, "{again:?}");
    assert!(again.talk.contains("already-there"), "{again:?}");
    assert!(std::fs::read(&path).expect("a file") == before);
}

#[test]
fn a_recording_is_inspected_and_its_draft_is_a_topic_map() {
    let folder = folder();
    let file = shown(&rosbag("sqlite"));
    let said = corroborate(
        folder.path(),
        &["inspect", &file, "--draft-map", "draft.toml"],
    );
    assert_eq!(said.code, 0, "{said:?}");
    for word in [
        "/joint_states",
        "sensor_msgs/msg/JointState",
        "10.00",
        "draft.toml",
    ] {
        assert!(said.out.contains(word), "{word}: {}", said.out);
    }
    let draft = std::fs::read_to_string(folder.path().join("draft.toml")).expect("a draft");
    let printed = corroborate(folder.path(), &["inspect", &file, "--draft-map", "-"]);
    assert!(printed.out == draft && printed.code == 0);
    // The draft's signal of position[0] is judged as that of a map written by hand.
    let formula = "always (/joint_states.position_shoulder < 0.9)";
    let arguments = [
        "monitor",
        "--formula",
        formula,
        "--map",
        "draft.toml",
        &file,
    ];
    let judged = corroborate(folder.path(), &arguments);
    assert_eq!(judged.code, 1, "{judged:?}");
    assert!(judged.out.contains("violated at 0.700 s"), "{judged:?}");

    let again = corroborate(
        folder.path(),
        &["inspect", &file, "--draft-map", "draft.toml"],
    );
    assert_eq!(again.code, 2, "{again:?}");
    assert!(again.talk.contains("already-there"), "{again:?}");
    let said = corroborate(folder.path(), &["inspect", &file, "--format", "json"]);
    assert_conforms("inspect.schema.json", &said);
    assert_eq!(json(&said)["recording"]["messages"], 29);
}

#[test]
fn tables_need_a_time_that_is_known() {
    let folder = folder();
    let table = "moment,speed\n0,0.1\n500,0.3\n";
    std::fs::write(folder.path().join("run.csv"), table).expect("written");
    let formula = "always (/csv.speed < 0.25)";
    let call = |more: &[&str]| {
        let mut arguments = vec!["monitor", "--formula", formula, "run.csv"];
        arguments.extend(more);
        corroborate(folder.path(), &arguments)
    };
    let refused = call(&[]);
    assert_eq!(refused.code, 2, "{refused:?}");
    let said = call(&["--time-field", "moment", "--time-unit", "ms"]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.out.contains("violated at 0.500 s"), "{said:?}");
    let refused = call(&["--time-field", "moment", "--time-unit", "weeks"]);
    assert_eq!(refused.code, 2, "{refused:?}");
}

#[test]
fn a_call_without_study_or_formula_is_refused() {
    let folder = folder();
    let file = shown(&rosbag("none.bag"));
    for (arguments, code) in [
        (vec!["monitor", &file, &file], "no-study"),
        (vec!["monitor", "."], "no-recordings"),
        (
            vec!["monitor", "--formula", "always near", &file],
            "bad-formula",
        ),
        (
            vec!["monitor", "--formula", "always (", &file],
            "bad-formula",
        ),
        (
            vec!["monitor", "--formula", "always (/no.x < 1)", &file],
            "bad-recording",
        ),
    ] {
        let said = corroborate(folder.path(), &arguments);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(said.talk.contains(code), "{code}: {said:?}");
    }
}

#[test]
fn a_window_of_one_instant_is_warned_of_in_discrete_time() {
    let folder = folder();
    let file = shown(&rosbag("mcap"));
    let at_once = "eventually[500 ms, 500 ms] (/arm.shoulder > 0 rad)";
    let said = monitor(folder.path(), at_once, &[&file, "--format", "json"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert_conforms("monitor.schema.json", &said);
    let report = json(&said);
    let warnings = report["warnings"].as_array().expect("a list");
    assert_eq!(warnings.len(), 1, "{report}");
    let warning = warnings[0].as_str().expect("a text");
    assert!(
        warning.starts_with("warning: <formula>:1:1: [0.5 s, 0.5 s]"),
        "{warning}"
    );
    assert!(said.talk.contains(warning), "{said:?}");
    for more in [&["--dense"][..], &["--ending", "weak"]] {
        let mut arguments = vec![file.as_str(), "--format", "json"];
        arguments.extend(more);
        let said = monitor(folder.path(), at_once, &arguments);
        let count = json(&said)["warnings"].as_array().map(Vec::len);
        assert_eq!(count, Some(usize::from(more[0] != "--dense")), "{said:?}");
    }
}
