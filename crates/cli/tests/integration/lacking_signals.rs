//! Recordings of which some lack a signal: what reads it reaches no verdict there, all else is judged.

use crate::support::program::{Said, corroborate};
use std::path::Path;
use tempfile::TempDir;

const STUDY: &str = r#"
title = "Recordings of two kinds"
summary = "Some were made before the sensor of the gap was there."
seed = 1
confidence = 0.95
agreement = 0.95
[conditions]
typical = "As usual."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "slow"
text = "The robot is slow."
shall = "The robot shall always satisfy slow."
[[requirement]]
id = "far"
text = "The robot keeps its distance."
shall = "The robot shall always satisfy far."
[[requirement]]
id = "either"
text = "The robot is slow or keeps its distance."
shall = "The robot shall always satisfy slow_or_far."
"#;

const VOCABULARY: &str = r#"
[slow]
meaning = "slower than 1 m/s"
trace = "/robot.speed < 1 m/s"
[far]
meaning = "farther than 10 cm"
trace = "/gap.distance > 10 cm"
[slow_or_far]
meaning = "one of both"
trace = "/robot.speed < 1 m/s | /gap.distance > 10 cm"
"#;

const LEDGER: &str = r#"
[[evidence]]
id = "O"
title = "A week of work"
technique = "operation"
conditions = "typical"
recordings = "recordings"
changed = "The first."
"#;

const TOPICS: &str = "[\"/robot.speed\"]\nfrom = \"/robot.speed\"\nunit = \"m/s\"\n";

/// Recordings in our own form.
const WHOLE: &str = "time_secs,/robot.speed [m/s],/gap.distance [m]\n0,0.1,1\n1,0.2,1\n2,0.1,1\n";
const WITHOUT: &str = "time_secs,/robot.speed [m/s]\n0,0.1\n1,0.2\n2,0.1\n";

fn run(recordings: &[(&str, &str)]) -> (TempDir, Said) {
    run_with(TOPICS, recordings)
}

fn run_with(topics: &str, recordings: &[(&str, &str)]) -> (TempDir, Said) {
    let folder = TempDir::new().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        std::fs::write(path, text).expect("written");
    };
    write("study.toml", STUDY);
    write("requirements.toml", REQUIREMENTS);
    write("vocabulary.toml", VOCABULARY);
    write("ledger.toml", LEDGER);
    write("topics.toml", topics);
    for (name, text) in recordings {
        write(&format!("recordings/{name}"), text);
    }
    let said = corroborate(folder.path(), &["run", "."]);
    (folder, said)
}

/// What a study's first piece of evidence found of a subject.
pub fn finding(folder: &Path, subject: &str) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("results/study.json")).expect("a result");
    let result: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let findings = result["evidence"][0]["findings"]
        .as_array()
        .expect("findings");
    let is_wanted = |it: &&serde_json::Value| it["subject"]["id"] == subject;
    findings.iter().find(is_wanted).expect("a finding").clone()
}

#[test]
fn what_one_recording_lacks_leaves_its_requirements_without_a_verdict_there() {
    let (folder, said) = run(&[("a.csv", WHOLE), ("b.csv", WITHOUT), ("c.csv", WHOLE)]);
    assert_eq!(said.code, 3, "{said:?}");
    let told = "O: b.csv has no /gap.distance; what reads that reaches no verdict there";
    assert!(said.talk.contains(told), "{said:?}");
    let slow = finding(folder.path(), "slow");
    assert_eq!(slow["measure"]["trials"], 3, "{slow}");
    assert_eq!(slow["undecided"], 0);
    let far = finding(folder.path(), "far");
    assert_eq!(far["measure"]["trials"], 2, "{far}");
    assert_eq!(far["undecided"], 1);
    assert!(
        said.out
            .contains("1 run of O reached no verdict: it is counted against and for"),
        "{said:?}"
    );
}

/// A trace in JSON lines is read through its topics, a table of ours whole.
#[test]
fn recordings_of_any_format_may_lack_a_signal() {
    let lines = r#"{"topic": "/robot", "time_secs": 0, "speed": 0.1}
{"topic": "/robot", "time_secs": 1, "speed": 2.0}
"#;
    let (folder, said) = run(&[("a.csv", WHOLE), ("b.jsonl", lines)]);
    let told = "b.jsonl has no /gap.distance";
    assert!(said.talk.contains(told), "{said:?}");
    let slow = finding(folder.path(), "slow");
    assert_eq!(slow["measure"]["trials"], 2, "{slow}");
    assert_eq!(slow["measure"]["count"], 1, "{slow}");
}

/// As above, where the topic map says in which field the signal is.
#[test]
fn a_recording_may_lack_a_field_that_the_map_names() {
    let map = "[\"/robot.speed\"]\nfrom = \"/robot.speed\"\nunit = \"m/s\"\n\
               [\"/gap.distance\"]\nfrom = \"/robot.gap\"\nunit = \"m\"\n";
    let whole = r#"{"topic": "/robot", "time_secs": 0, "speed": 0.1, "gap": 1.0}
{"topic": "/robot", "time_secs": 1, "speed": 0.1, "gap": 1.0}
"#;
    let without = r#"{"topic": "/robot", "time_secs": 0, "speed": 0.1}
{"topic": "/robot", "time_secs": 1, "speed": 0.1}
"#;
    let (folder, said) = run_with(map, &[("a.jsonl", whole), ("b.jsonl", without)]);
    assert!(
        said.talk.contains("b.jsonl has no /gap.distance"),
        "{said:?}"
    );
    assert_eq!(finding(folder.path(), "slow")["measure"]["trials"], 2);
    let far = finding(folder.path(), "far");
    assert_eq!(
        (&far["measure"]["trials"], &far["undecided"]),
        (&1.into(), &1.into())
    );
}

/// By its speed alone the second would pass, and could not fail: counted, it would make the rate of passes too high.
#[test]
fn a_recording_that_lacks_a_signal_does_not_pass_by_what_else_is_read() {
    let whole = r#"{"topic": "/robot", "time_secs": 0, "speed": 0.1, "gap": 1.0}
{"topic": "/robot", "time_secs": 1, "speed": 0.1, "gap": 1.0}
"#;
    let slow = whole.replace(", \"gap\": 1.0", "");
    let map = format!("{TOPICS}[\"/gap.distance\"]\nfrom = \"/robot.gap\"\nunit = \"m\"\n");
    let (folder, _) = run_with(&map, &[("a.jsonl", whole), ("b.jsonl", &slow)]);
    let either = finding(folder.path(), "either");
    assert_eq!(either["measure"]["trials"], 1, "{either}");
    assert_eq!(either["undecided"], 1, "{either}");
}

#[test]
fn a_signal_that_no_recording_has_is_a_mistake_at_its_place() {
    let (_folder, said) = run(&[("a.csv", WITHOUT), ("b.csv", WITHOUT)]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("vocabulary.toml:7"), "{said:?}");
    assert!(said.talk.contains("/gap.distance"), "{said:?}");
}

/// Sixty recordings in which the robot keeps its distance, and twenty that cannot tell: whether it kept it in 75 % or all of
/// them is not known, unless the study says why these are as the others.
#[test]
fn what_has_no_verdict_counts_both_ways_unless_it_is_declared() {
    let recordings: Vec<(String, String)> = (0..80)
        .map(|i| {
            let text = if i < 60 { WHOLE } else { WITHOUT };
            // Each has its own values.
            (
                format!("{i}.csv"),
                text.replace("1,0.2", &format!("1,0.{}", 100 + i)),
            )
        })
        .collect();
    let recordings: Vec<(&str, &str)> = recordings
        .iter()
        .map(|(name, text)| (name.as_str(), text.as_str()))
        .collect();
    let (folder, _) = run(&recordings);
    let study = |declared: &str| {
        let write = |name: &str, text: String| {
            std::fs::write(folder.path().join(name), text).expect("written");
        };
        write("ledger.toml", format!("{LEDGER}{declared}\n"));
        let far = "shall = \"The robot shall always satisfy far.\"";
        write(
            "requirements.toml",
            REQUIREMENTS.replace(far, &format!("{far}\nthreshold = \"at least 0.9\"")),
        );
        let said = corroborate(folder.path(), &["run", "."]);
        let text = std::fs::read_to_string(folder.path().join("results/study.json"));
        let result: serde_json::Value =
            serde_json::from_str(&text.expect("a result")).expect("JSON");
        let all = result["conclusions"].as_array().expect("conclusions");
        let far = all.iter().find(|it| it["requirement"] == "far");
        (said, far.expect("a conclusion").clone())
    };
    let (said, far) = study("");
    assert_eq!(far["verdict"], "undecided", "{far}");
    assert!(
        said.out
            .contains("60/60 and 20 undecided, counted against and for"),
        "{said:?}"
    );
    let widened = finding(folder.path(), "far");
    let low = widened["measure"]["interval"]["low"].as_f64();
    let lowest = widened["completions"]["ends"][0]["interval"]["low"].as_f64();
    assert!(low == lowest && low < Some(0.7), "{widened}");
    let (said, far) = study("undecided_at_random = \"the sensor came in May\"");
    assert_eq!(far["verdict"], "satisfied", "{far}");
    assert!(said.out.contains("the sensor came in May"), "{said:?}");
    let verified = corroborate(folder.path(), &["verify", "results", "--deep"]);
    assert_eq!(verified.code, 0, "{verified:?}");
    let (said, _) = study("undecided_at_random = \"\"");
    assert_eq!(said.code, 2, "{said:?}");
}

/// A model whose number was counted in 30 of 30 recordings, with 10 more that cannot tell: it computes anything that 30 to 40
/// of 40 may mean, and what 30 of 30 mean only where the study says why the others are as these.
#[test]
fn a_model_carries_what_the_runs_without_a_verdict_leave_open() {
    let recordings: Vec<(String, String)> = (0..40)
        .map(|i| {
            let text = if i < 30 { WHOLE } else { WITHOUT };
            let own = text.replace("1,0.2", &format!("1,0.{}", 100 + i));
            (format!("{i}.csv"), own)
        })
        .collect();
    let recordings: Vec<(&str, &str)> = recordings
        .iter()
        .map(|(name, text)| (name.as_str(), text.as_str()))
        .collect();
    let (folder, _) = run(&recordings);
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
    };
    write(
        "m.prism",
        "dtmc\nconst double pFar = 1;\nmodule m\n  s : [0..2] init 0;\n  \
         [] s=0 -> pFar:(s'=1) + 1-pFar:(s'=2);\n  [] s>0 -> true;\nendmodule\n",
    );
    let of_model = |name: &str| format!("trace = \"{name}\"\nmodel = \"s<2\"\n");
    let far = "trace = \"/gap.distance > 10 cm\"\n";
    write(
        "vocabulary.toml",
        &VOCABULARY.replace(far, &of_model("/gap.distance > 10 cm")),
    );
    let interval = |declared: &str| {
        let model = "[[evidence]]\nid = \"M\"\ntitle = \"m\"\ntechnique = \"model-checking\"\nconditions = \"typical\"\n\
                     model = \"m.prism\"\nchanged = \"c\"\n\
                     calibrated = [{ constant = \"pFar\", from = \"O\", requirement = \"far\" }]\n";
        write("ledger.toml", &format!("{LEDGER}{declared}\n{model}"));
        let said = corroborate(folder.path(), &["run", "."]);
        let text = std::fs::read_to_string(folder.path().join("results/study.json"));
        let text = text.unwrap_or_else(|error| panic!("{error}: {said:?}"));
        let result: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let findings = result["evidence"][1]["findings"]
            .as_array()
            .expect("findings");
        let own = findings.iter().find(|it| it["subject"]["id"] == "far");
        let own = own.unwrap_or_else(|| panic!("{said:?}"));
        let interval = &own["measure"]["credible"]["interval"];
        let end = |name: &str| interval[name].as_f64().unwrap_or_else(|| panic!("{own}"));
        (end("low"), end("high"))
    };
    let limits = |successes: u64, trials: u64| {
        let sample = stats::Sample { successes, trials };
        stats::BetaPosterior::jeffreys(sample).credible_interval(stats::Confidence::P95)
    };
    let near = |found: f64, expected: f64| (found - expected).abs() < 2e-3;
    let (low, high) = interval("");
    assert!(near(low, limits(30, 40).low), "{low}");
    assert!(near(high, 1.0), "{high}");
    let (low, _) = interval("undecided_at_random = \"the sensor came in May\"");
    assert!(near(low, limits(30, 30).low), "{low}");
}
