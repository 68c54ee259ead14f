//! Recordings that end too early, through the whole command: in every format, cut at many places.
//!
//! `crates/recording/tests/files/make_rosbags.py` says what is in them: on /joint_states, each 100 ms, position[0] = i / 7
//! for i from 0 to 11. So 1.5 is exceeded by the last message only, and never before.

use crate::support;

use std::path::Path;
use support::program::{Said, corroborate};
use support::root;
use tempfile::TempDir;

/// The last message decides: satisfied by the whole recording, and by no part of it.
const AT_THE_END: &str = "eventually (/arm.shoulder > 1.5)";
/// Every message is needed: satisfied by the whole recording, and open until its end.
const ALWAYS: &str = "always (/arm.shoulder < 3)";

const IN_BAGS: &str = "[\"/arm.shoulder\"]\nfrom = \"/joint_states.position[0]\"\n";
const IN_ROWS: &str = "[\"/arm.shoulder\"]\nfrom = \"/csv.shoulder\"\n";
const IN_LINES: &str = "[\"/arm.shoulder\"]\nfrom = \"/joint_states.position[0]\"\n";

/// A recording as a file: its name, its bytes, and where the signal is in it.
type Recording = (String, Vec<u8>, &'static str);

fn bags() -> Vec<Recording> {
    let folder = root().join("crates/recording/tests/files/rosbags");
    let names = [
        "none.bag",
        "lz4.bag",
        "bz2.bag",
        "humble.db3",
        "sqlite/sqlite.db3",
        "mcap/mcap.mcap",
        "mcap_file/mcap_file.mcap.zstd",
    ];
    let read = |name: &str| {
        let bytes = std::fs::read(folder.join(name)).expect("a recording");
        let name = name.rsplit('/').next().unwrap_or(name).to_owned();
        (name, bytes, IN_BAGS)
    };
    names.map(read).into()
}

/// The same values as texts.
fn texts() -> Vec<Recording> {
    let rows = |line: &dyn Fn(usize, f64) -> String| -> String {
        (0..12).map(|i| line(i, i as f64 / 7.0)).collect()
    };
    let plain = rows(&|i, value| format!("{}.{},{value}\n", i / 10, i % 10));
    let lines = rows(&|i, value| {
        format!(
            "{{\"topic\": \"/joint_states\", \"time_ms\": {}, \"position\": [{value}]}}\n",
            i * 100
        )
    });
    [
        ("rows.csv", format!("time_secs,shoulder\n{plain}"), IN_ROWS),
        (
            "signals.csv",
            format!("time_secs,/arm.shoulder\n{plain}"),
            "",
        ),
        ("lines.jsonl", lines, IN_LINES),
    ]
    .map(|(name, text, map)| (name.to_owned(), text.into_bytes(), map))
    .into()
}

fn monitor(folder: &Path, formula: &str, file: &str, more: &[&str]) -> Said {
    let mut arguments = vec!["monitor", "--map", "map.toml", "--formula", formula, file];
    arguments.extend(["--format", "json"]);
    arguments.extend(more);
    corroborate(folder, &arguments)
}

fn verdict(said: &Said) -> (String, Option<String>) {
    let report: serde_json::Value =
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
    let recording = &report["recordings"][0];
    let verdict = recording["verdicts"][0]["verdict"].as_str();
    let lost = recording["lost"].as_str().map(str::to_owned);
    (verdict.expect("a verdict").to_owned(), lost)
}

fn check(recordings: Vec<Recording>, cuts: &dyn Fn(&[u8]) -> Vec<usize>) {
    let folder = TempDir::new().expect("a folder");
    for (name, bytes, map) in recordings {
        std::fs::write(folder.path().join("map.toml"), map).expect("written");
        let write = |length: usize| {
            std::fs::write(folder.path().join(&name), &bytes[..length]).expect("written");
        };
        write(bytes.len());
        for formula in [AT_THE_END, ALWAYS] {
            let said = monitor(folder.path(), formula, &name, &[]);
            assert_eq!(
                (said.code, verdict(&said).0.as_str()),
                (0, "satisfied"),
                "{name}"
            );
        }
        let mut judged = 0;
        for length in cuts(&bytes) {
            write(length);
            judged += u64::from(check_cut(folder.path(), &name, length));
        }
        // Otherwise refusing everything would do.
        let can_be_judged = !name.ends_with(".zstd");
        assert_eq!(judged > 0, can_be_judged, "{name}: {judged}");
    }
}

/// Checks a cut file; whether anything of it could be judged.
fn check_cut(folder: &Path, name: &str, length: usize) -> bool {
    let mut judged = false;
    for formula in [AT_THE_END, ALWAYS] {
        let refused = monitor(folder, formula, name, &[]);
        assert_eq!(
            (refused.code, refused.out.as_str()),
            (2, ""),
            "{name}, {length}: {refused:?}"
        );
        assert!(refused.talk.contains(name), "{name}, {length}: {refused:?}");
        let said = monitor(folder, formula, name, &["--partial"]);
        if said.code == 2 {
            // Nothing can be read of it, and why is said.
            assert!(
                said.talk.contains("error[bad-recording]"),
                "{name}, {length}: {said:?}"
            );
            assert!(said.talk.contains(name), "{name}, {length}: {said:?}");
            continue;
        }
        assert!(
            refused.talk.contains("recording-cut-short"),
            "{name}, {length}: {refused:?}"
        );
        assert_eq!(said.code, 3, "{name}, {length}: {said:?}");
        let (verdict, lost) = verdict(&said);
        assert!(
            lost.is_some_and(|lost| lost.len() > 20),
            "{name}, {length}: {said:?}"
        );
        // The last message may have been in front of the cut; then it has decided.
        let may_be_decided = formula == AT_THE_END && verdict == "satisfied";
        assert!(
            verdict == "inconclusive" || may_be_decided,
            "{name}, {length}: {said:?}"
        );
        judged = true;
    }
    judged
}

#[test]
fn bags_that_are_cut_short_are_inconclusive() {
    check(bags(), &|bytes| {
        let tenths = (1..10).map(|tenth| bytes.len() * tenth / 10);
        tenths.chain([bytes.len() - 1]).collect()
    });
}

/// A text that ends behind a whole line, or a whole JSON object, cannot be told from one that was finished, so it is cut
/// within them: also within numbers, where what is left would be another number.
#[test]
fn texts_that_are_cut_short_are_inconclusive() {
    check(texts(), &|bytes| {
        let is_inside = |length: &usize| !matches!(bytes[length - 1], b'\n' | b'}');
        let first = bytes.iter().position(|byte| *byte == b'\n').unwrap_or(0);
        let steps = (first + 2..bytes.len()).step_by(23);
        steps.chain([bytes.len() - 1]).filter(is_inside).collect()
    });
}

/// A column in which nothing was ever written is missing throughout, also where a truth value is needed.
#[test]
fn columns_without_values_are_missing_and_said_to_be() {
    let folder = TempDir::new().expect("a folder");
    for (name, text, formula) in [
        (
            "own.csv",
            "time_secs,/robot.speed,/robot.ready,/robot.on\n0,0.5,,\n1,0.5,,\n2,0.25,,\n",
            "always (/robot.ready & /robot.on)",
        ),
        (
            "rows.csv",
            "t [s],speed,ready,on\n0,0.5,,\n1,0.5,,\n2,0.25,,\n",
            "always (/csv.ready & /csv.on)",
        ),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
        let arguments = ["monitor", "--formula", formula, name, "--format", "json"];
        let said = corroborate(folder.path(), &arguments);
        assert_eq!(
            (said.code, verdict(&said).0.as_str()),
            (3, "inconclusive"),
            "{said:?}"
        );
        assert!(said.out.contains("ready has no value anywhere"), "{said:?}");
        // What has values is what it is, and the file is named.
        let wrong = formula.replace("ready", "speed");
        let said = corroborate(folder.path(), &["monitor", "--formula", &wrong, name]);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(
            said.talk.contains(&format!("{name}: formula: `"))
                && said.talk.contains("speed`: this is a number"),
            "{said:?}"
        );
    }
}
