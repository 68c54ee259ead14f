//! Findings made small, kept as regressions and replayed, as a user does it.
//!
//! Needs the physics library. Without it the tests are skipped with a line that says so, except in continuous
//! integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use std::path::Path;
use support::program::{Said, command};
use support::simulation::{library, simulating};
use support::{copy_study, root};

/// A failed planner, among much that has nothing to do with it.
const FINDING: &str = r#"format = "1.0"
found_by = "a test"
program = "0.1.0"
seed = "17430106638011324533"

[bench]
evidence = "E2"
scenario = "simulation/scenario.toml"
parameters = "simulation/untuned.toml"

[shows]
violated = "4"

[test]
name = "typical use"
actions = [
  { after_secs = { uniform = [0.5, 6.0] }, send_signal = "activate" },
  { receive_signal = "announcement" },
  { after_secs = { uniform = [0.3, 1.0] }, set_param = { gaze = true, location = true } },
  { after_secs = { uniform = [1.5, 2.5] }, send_signal = "ready" },
]

[settings]
"parameters.planner.failure_rate_per_run" = 1
"parameters.object.mass_kg" = 0.1234567
"#;

fn handover() -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&root().join("case-studies/handover"), folder.path());
    std::fs::write(folder.path().join("found.toml"), FINDING).expect("written");
    folder
}

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

fn regression(folder: &Path) -> toml::Table {
    let text = std::fs::read_to_string(folder.join("regressions/found.toml")).expect("it is kept");
    assert!(
        text.starts_with("# Shows: requirement 4 is violated"),
        "{text}"
    );
    text.parse().expect("it is TOML")
}

#[test]
fn a_finding_shrinks_to_what_matters_and_is_a_regression_from_then_on() {
    let Some(library) = library() else { return };
    let folder = handover();
    let study = folder.path();
    let run = |arguments: &[&str]| simulating(&library, study, arguments);
    let said = run(&["shrink", ".", "found.toml", "--format", "json"]);
    assert_eq!(said.code, 0, "{said:?}");
    let report = json(&said);
    assert_eq!(report["is_minimal"], true);
    assert_eq!(report["before"]["actions"], 4);
    assert_eq!(report["after"]["actions"], 1, "{report}");
    assert_eq!(report["after"]["settings"], 1, "{report}");
    let kept = regression(study);
    let actions = kept["test"]["actions"].as_array().expect("actions");
    assert_eq!(actions[0]["send_signal"].as_str(), Some("activate"));
    assert!(
        kept["settings"]
            .get("parameters.planner.failure_rate_per_run")
            .is_some()
    );
    // A second time nothing is replaced.
    let said = run(&["shrink", ".", "found.toml"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("is there already"), "{said:?}");

    let said = run(&["replay", ".", "--check", "--format", "json"]);
    assert_eq!(said.code, 0, "{said:?}");
    let checked = &json(&said)["regressions"][0];
    assert_eq!(
        (&checked["shown"], &checked["same_bytes"]),
        (&true.into(), &true.into())
    );

    // Once the fault is fixed, the regression no longer shows it.
    let text = std::fs::read_to_string(study.join("regressions/found.toml")).expect("kept");
    let key = "\"parameters.planner.failure_rate_per_run\"";
    let line = text
        .lines()
        .find(|line| line.starts_with(key))
        .expect("a setting");
    let mended = text.replace(line, &format!("{key} = 0"));
    std::fs::write(study.join("regressions/mended.toml"), mended).expect("written");
    std::fs::write(study.join("regressions/torn.toml"), &text[..text.len() / 2]).expect("written");
    let said = run(&["replay", ".", "--check", "-j", "2"]);
    assert_eq!(said.code, 1, "{said:?}");
    let lines: Vec<&str> = said.out.lines().collect();
    assert!(lines[0].starts_with("fails still "), "{said:?}");
    assert!(lines[1].starts_with("PASSES NOW"), "{said:?}");
    assert!(
        lines.iter().any(|line| line.starts_with("CANNOT BE RUN")),
        "{said:?}"
    );
    assert_eq!(
        lines.last(),
        Some(&"1 of 3 regressions do what is expected of them")
    );
}

/// An object that slips, which is decided long before the episode ends.
const SLIPS: &str = r#"format = "1.0"
found_by = "a test"
program = "0.1.0"
seed = "9309717024207723383"

[bench]
evidence = "E2"
scenario = "simulation/scenario.toml"
parameters = "simulation/untuned.toml"

[shows]
failure_mode = "grip_failure"

[test]
name = "nobody helps"
actions = [{ after_secs = 0.5882303120603325, send_signal = "activate" }]

[settings]
"parameters.hand.friction" = 0.2904082625044228
"parameters.object.mass_kg" = 0.39787699369345536
"parameters.object.x_error_m" = 0.005
"parameters.object.y_error_m" = -0.002554113770559195
"#;

#[test]
fn an_episode_ends_once_it_has_shown_it_and_a_small_budget_is_said() {
    let Some(library) = library() else { return };
    let folder = handover();
    let study = folder.path();
    std::fs::write(study.join("slips.toml"), SLIPS).expect("written");
    let run = |arguments: &[&str]| simulating(&library, study, arguments);
    let shrunk = |arguments: &[&str]| {
        let said = run(&[&["shrink", ".", "--format", "json"], arguments].concat());
        assert_eq!(said.code, 0, "{said:?}");
        json(&said)
    };
    let report = shrunk(&["slips.toml"]);
    assert_eq!(report["is_minimal"], true);
    let [before, after] = ["before", "after"].map(|of| report[of]["simulated_secs"].as_f64());
    assert!(after < before, "{report}");
    let text = std::fs::read_to_string(study.join("regressions/slips.toml")).expect("kept");
    let kept: toml::Table = text.parse().expect("TOML");
    let until = kept["bench"]["until_secs"].as_integer().expect("it is cut") as f64;
    assert!((after.expect("a number") - until).abs() < 0.1, "{report}");

    // A planner that always fails does so in every seed.
    let report = shrunk(&["found.toml", "--seeds", "2/2", "--budget", "2"]);
    assert_eq!(report["seeds"], serde_json::json!([2, 2]));
    assert_eq!(report["is_minimal"], false);
    assert_eq!(report["episodes"], 2, "{report}");
    let few = [
        "shrink",
        ".",
        "found.toml",
        "--seeds",
        "2/2",
        "--budget",
        "1",
        "--name",
        "few",
    ];
    let said = run(&few);
    assert_eq!((said.code, said.out.as_str()), (2, ""), "{said:?}");
    assert!(said.talk.contains("small-budget"), "{}", said.talk);
    let said = run(&["replay", ".", "--check"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(
        said.out.contains("2 of 2") && !said.out.contains("other bytes"),
        "{said:?}"
    );
}

#[test]
fn a_replay_gives_the_same_bytes_a_page_and_a_scene() {
    let Some(library) = library() else { return };
    let folder = handover();
    let study = folder.path();
    let run = |arguments: &[&str]| simulating(&library, study, arguments);
    let said = run(&[
        "replay",
        ".",
        "found.toml",
        "--out",
        "one",
        "--format",
        "json",
    ]);
    assert_eq!(said.code, 0, "{said:?}");
    let report = json(&said);
    assert_eq!(report["shown"], true);
    assert_eq!(report["same_bytes"], Value::Null);
    let verdicts = report["verdicts"].as_array().expect("verdicts");
    let fourth = verdicts
        .iter()
        .find(|it| it["subject"] == "4")
        .expect("it is judged");
    assert_eq!(fourth["verdict"], "violated");
    assert!(
        fourth["reasons"]
            .as_array()
            .is_some_and(|reasons| reasons.len() > 1)
    );
    let page = std::fs::read_to_string(study.join("one/replay.html")).expect("a page");
    assert!(page.len() < 2_000_000 && page.contains("Requirement 4 is violated"));
    assert!(page.contains("human_head") && !page.contains("https://"));

    // What simulate and monitor make of it is the same.
    let said = run(&[
        "monitor",
        ".",
        "one/recording.mcap",
        "--only",
        "4",
        "--partial",
    ]);
    assert_eq!(said.code, 1, "{said:?}");
    for (file, topic) in [
        ("scene", "/transforms"),
        ("verdicts", "/corroborate/r4/verdict"),
    ] {
        let said = run(&["inspect", &format!("one/{file}.mcap")]);
        assert_eq!(said.code, 0, "{said:?}");
        assert!(said.out.contains(topic), "{said:?}");
    }

    // With its hash known, a replay is held against it.
    let hash = report["recording"].as_str().expect("a hash");
    let with = |hash: &str| {
        let text = FINDING.replace("[bench]", &format!("recording = \"{hash}\"\n\n[bench]"));
        std::fs::write(study.join("known.toml"), text).expect("written");
        run(&["replay", ".", "known.toml", "--out", "two"])
    };
    let said = with(hash);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("bit for bit"), "{said:?}");
    let bytes =
        |folder: &str, file: &str| std::fs::read(study.join(folder).join(file)).expect("there");
    for file in ["recording.mcap", "scene.mcap", "verdicts.mcap"] {
        assert!(bytes("one", file) == bytes("two", file), "{file} differs");
    }
    let said = with(&hash.replace(&hash[..1], if hash.starts_with('0') { "1" } else { "0" }));
    assert_eq!(said.code, 3, "{said:?}");
    assert!(said.out.contains("NOT THE SAME"), "{said:?}");
}

#[test]
fn an_episode_of_an_evidence_is_the_one_that_was_recorded() {
    let Some(library) = library() else { return };
    let folder = handover();
    let study = folder.path();
    let run = |arguments: &[&str]| simulating(&library, study, arguments);
    let said = run(&[
        "simulate",
        ".",
        "E4",
        "-n",
        "1",
        "--first",
        "3",
        "--out",
        "results/episodes/E4",
    ]);
    // One episode decides nothing of 95 in 100, unless it is a failure.
    assert!([1, 3].contains(&said.code), "{said:?}");
    let said = run(&["replay", ".", "E4:3"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("bit for bit"), "{said:?}");
    let replayed = std::fs::read(study.join("results/replays/E4-3/recording.mcap")).expect("there");
    let recorded =
        std::fs::read(study.join("results/episodes/E4/episode-00003.mcap")).expect("there");
    assert!(replayed == recorded);
}

#[test]
fn what_is_wrong_with_a_call_is_said() {
    let Some(library) = library() else { return };
    let folder = handover();
    let study = folder.path();
    let broken = FINDING.replace("violated = \"4\"", "violated = \"44\"");
    std::fs::write(study.join("broken.toml"), broken).expect("written");
    let other = FINDING.replace("failure_rate_per_run\" = 1", "failure_rate_per_run\" = 0");
    std::fs::write(study.join("not.toml"), other).expect("written");
    let calls: [(&[&str], i32, &str); 13] = [
        (&["replay", "."], 2, "required"),
        (&["replay", ".", "nothing.toml"], 2, "no finding"),
        (
            &["replay", ".", "E4:0"],
            2,
            "the number of an episode must be",
        ),
        (
            &["replay", ".", "E4:501"],
            2,
            "name one from E4:1 to E4:500",
        ),
        (
            &["replay", ".", "E4:x"],
            2,
            "the number of an episode must be",
        ),
        (&["replay", ".", "E99:1"], 2, "no evidence `E99`"),
        (&["replay", ".", "E1:1"], 2, "not a simulation"),
        (&["replay", ".", "broken.toml"], 2, "no monitor for `44`"),
        (
            &["replay", ".", "found.toml", "--only", "44"],
            2,
            "does not declare `44`",
        ),
        (&["replay", ".", "found.toml", "not.toml"], 2, "one episode"),
        (&["replay", ".", "--check"], 2, "holds no regressions"),
        (
            &["shrink", ".", "found.toml", "--name", "../x"],
            2,
            "not a valid name of a regression",
        ),
        (&["shrink", ".", "not.toml"], 3, "did not show it"),
    ];
    for (arguments, code, message) in calls {
        let said = simulating(&library, study, arguments);
        assert_eq!(said.code, code, "{arguments:?}: {said:?}");
        assert!(said.talk.contains(message), "{arguments:?}: {said:?}");
    }
    let said = simulating(&library, study, &["replay", ".", "not.toml"]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.out.contains("NOT SHOWN AGAIN"), "{said:?}");
    assert!(!study.join("regressions").exists());
    let without = command(study, &["replay", ".", "found.toml"])
        .output()
        .expect("it starts");
    assert_eq!(without.status.code(), Some(2));
    let without = command(study, &["replay", ".", "--check", "found.toml"]).output();
    assert_eq!(without.expect("it starts").status.code(), Some(2));
}

#[test]
fn a_scene_is_replayed_with_its_robot_and_people() {
    let Some(library) = library() else { return };
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&root().join("case-studies/corridor"), folder.path());
    let output = command(
        folder.path(),
        &["replay", ".", "S1:1", "--out", "one", "--format", "json"],
    )
    .env("CORROBORATE_MUJOCO", &library)
    .env("CORROBORATE_CLIENTS", root().join("clients"))
    .output()
    .expect("the program starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let page = std::fs::read_to_string(folder.path().join("one/replay.html")).expect("a page");
    assert!(page.len() < 2_000_000, "{}", page.len());
    for role in ["robot", "person", "surroundings"] {
        assert!(page.contains(&format!("\"role\":\"{role}\"")), "no {role}");
    }
    assert!(page.contains("\"kind\":\"capsule\"") && page.contains("Follow"));
}
