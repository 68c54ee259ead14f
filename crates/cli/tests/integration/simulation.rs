//! The simulation as a user meets it: recorded, judged again, at any number of threads.
//!
//! Needs the physics library. Without it the tests are skipped with a line that says so, except
//! in continuous integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use support::program::command;
use support::simulation::{handover, library, simulating};

/// Two simulations of the handover, few episodes each.
const LEDGER: &str = r#"
[[evidence]]
id = "E2"
title = "Simulation, untuned"
technique = "simulation"
conditions = "typical"
scenario = "simulation/scenario.toml"
parameters = "simulation/untuned.toml"
episodes = 3
changed = "The first simulation."

[[evidence]]
id = "E4"
title = "Simulation, tuned"
technique = "simulation"
conditions = "typical"
scenario = "simulation/scenario.toml"
parameters = "simulation/tuned.toml"
episodes = 4
changed = "Tuned."
"#;

/// The handover's study with a ledger of two short simulations.
fn study() -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    let from = handover();
    for name in [
        "study.toml",
        "parameters.toml",
        "requirements.toml",
        "vocabulary.toml",
    ] {
        std::fs::copy(from.join(name), folder.path().join(name)).expect("copied");
    }
    let simulation = folder.path().join("simulation");
    std::fs::create_dir(&simulation).expect("made");
    for name in ["scenario.toml", "untuned.toml", "tuned.toml"] {
        let source = from.join("simulation").join(name);
        std::fs::copy(source, simulation.join(name)).expect("copied");
    }
    std::fs::write(folder.path().join("ledger.toml"), LEDGER).expect("written");
    folder
}

/// The recordings below a folder, with their content.
fn recordings(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(".mcap") {
            found.insert(name, std::fs::read(entry.path()).expect("a recording"));
        }
    }
    found
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// The result without what it took, which differs from run to run.
fn result(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("study.json")).expect("a result");
    let mut result = json(&text);
    result.as_object_mut().expect("an object").remove("costs");
    result
}

#[test]
fn episodes_have_the_same_bytes_at_any_number_of_threads_and_are_judged_alike_again() {
    let Some(library) = library() else {
        return;
    };
    let folder = study();
    for threads in ["1", "2"] {
        let said = simulating(
            &library,
            folder.path(),
            &["run", ".", "-j", threads, "--out", threads],
        );
        assert!([0, 1, 3].contains(&said.code), "{said:?}");
    }
    for evidence in ["E2", "E4"] {
        let of = |threads: &str| {
            let episodes = folder.path().join(threads).join("episodes").join(evidence);
            recordings(&episodes)
        };
        assert!(of("1").len() >= 3, "{evidence} has no recordings");
        assert!(
            of("1") == of("2"),
            "{evidence} depends on the number of threads"
        );
    }
    let first = result(&folder.path().join("1"));
    assert!(first == result(&folder.path().join("2")));
    assert_forms_differ_alike(&library, folder.path(), &first);

    let said = simulating(
        &library,
        folder.path(),
        &["monitor", ".", "1/episodes/E4", "--format", "json"],
    );
    let totals = json(&said.out)["totals"]
        .as_array()
        .expect("totals")
        .clone();
    let mut compared = 0;
    for finding in first["evidence"][1]["findings"]
        .as_array()
        .expect("findings")
    {
        let id = &finding["subject"]["id"];
        let total = totals
            .iter()
            .find(|t| &t["subject"] == id && t["reading"].is_null())
            .unwrap_or_else(|| panic!("{id} was not judged again"));
        if finding["measure"]["kind"] == "counts" {
            let is_mode = finding["subject"]["kind"] == "failure-mode";
            let count = if is_mode {
                &total["failed"]
            } else {
                &total["passed"]
            };
            assert_eq!(&finding["measure"]["count"], count, "{id}");
            assert_eq!(finding["measure"]["trials"], total["covered"], "{id}");
            compared += 1;
        } else {
            assert_eq!(total["covered"], 0, "{id}");
        }
    }
    assert!(compared >= 8, "only {compared} subjects were covered");
}

/// The forms that differ on a run's episodes are those that differ on its recordings when these are asked for.
fn assert_forms_differ_alike(library: &Path, folder: &Path, result: &Value) {
    let mut all = 0;
    for (place, evidence) in ["E2", "E4"].into_iter().enumerate() {
        let episodes = format!("1/episodes/{evidence}");
        let arguments = ["requirements", ".", &episodes, "--format", "json"];
        let again = json(&simulating(library, folder, &arguments).out);
        let mut expected: BTreeMap<[&str; 3], u64> = BTreeMap::new();
        for found in again["differences"].as_array().expect("differences") {
            let key = ["requirement", "form", "verdict"]
                .map(|name| found[name].as_str().expect("a text"));
            *expected.entry(key).or_default() += 1;
        }
        let mut told: BTreeMap<[&str; 3], u64> = BTreeMap::new();
        let found = &result["evidence"][place]["form_differences"];
        for found in found.as_array().expect("differences") {
            let text = |value: &'_ Value| value.as_str().map(str::to_owned).expect("a text");
            assert!(!text(&found["witnesses"][0]).is_empty());
            let key = [&found["subject"]["id"], &found["form"], &found["verdict"]];
            let key = key.map(|value| value.as_str().expect("a text"));
            *told.entry(key).or_default() += found["count"].as_u64().expect("a count");
        }
        assert_eq!(told, expected, "{evidence}");
        all += told.len();
    }
    assert!(
        all > 0,
        "one of the episodes is a grip failure, on which forms differ"
    );
}

#[test]
fn a_recording_that_is_missing_or_damaged_is_made_again_with_the_same_bytes() {
    let Some(library) = library() else {
        return;
    };
    let folder = study();
    let arguments = ["run", ".", "--only", "E2"];
    assert_eq!(simulating(&library, folder.path(), &arguments).code, 0);
    let episodes = folder.path().join("results/episodes/E2");
    let before = recordings(&episodes);
    let names: Vec<&String> = before.keys().collect();
    std::fs::remove_file(episodes.join(names[0])).expect("removed");
    let half = &before[names[1]][..before[names[1]].len() / 2];
    std::fs::write(episodes.join(names[1]), half).expect("cut short");
    std::fs::remove_file(folder.path().join("results/evidence/E2.json")).expect("removed");
    assert_eq!(simulating(&library, folder.path(), &arguments).code, 0);
    assert!(recordings(&episodes) == before);
}

#[test]
fn a_recording_cut_short_is_refused_unless_a_part_is_asked_for() {
    let Some(library) = library() else {
        return;
    };
    let folder = study();
    let arguments = ["simulate", ".", "E4", "-n", "1", "--out", "one"];
    let said = simulating(&library, folder.path(), &arguments);
    assert!([1, 3].contains(&said.code), "{said:?}");
    let file = folder.path().join("one/episode-00001.mcap");
    let whole = std::fs::read(&file).expect("a recording");
    std::fs::write(&file, &whole[..whole.len() * 2 / 3]).expect("cut short");
    let refused = simulating(&library, folder.path(), &["monitor", ".", "one"]);
    assert_eq!((refused.code, refused.out.as_str()), (2, ""), "{refused:?}");
    assert!(
        refused.talk.contains("episode-00001.mcap was cut short"),
        "{refused:?}"
    );
    assert!(refused.talk.contains("--partial"), "{refused:?}");

    let arguments = ["monitor", ".", "one", "--partial", "--format", "json"];
    let said = simulating(&library, folder.path(), &arguments);
    let report = json(&said.out);
    assert_eq!(report["recordings"][0]["complete"], false, "{}", said.out);
    assert!(report["recordings"][0]["lost"].is_string(), "{}", said.out);
    assert!([1, 3].contains(&said.code), "{said:?}");
}

/// Both are determined as soon as the robot has decided, or not at all.
const SOON_DETERMINED: &str = r#"
[[requirement]]
id = "decides"
text = "The robot decides."
formula = "eventually decided"

[[requirement]]
id = "decides-late"
text = "The robot does not decide within its first ten seconds."
formula = "always[0, 10 s] not decided"
"#;

#[test]
fn an_episode_that_ends_once_all_is_determined_is_shorter_and_has_the_same_verdicts() {
    let Some(library) = library() else {
        return;
    };
    let folder = study();
    std::fs::write(folder.path().join("requirements.toml"), SOON_DETERMINED).expect("written");
    let run = |out: &str| {
        let arguments = ["run", ".", "--only", "E4", "--out", out, "--format", "json"];
        let said = simulating(&library, folder.path(), &arguments);
        assert_eq!(said.code, 0, "{said:?}");
        let findings = json(&said.out)[0]["findings"].clone();
        assert!(findings.as_array().is_some_and(|it| it.len() == 2));
        let episodes = folder.path().join(out).join("episodes/E4");
        (findings, recordings(&episodes))
    };
    let (findings, whole) = run("whole");
    let early = LEDGER.replace("episodes = 4", "episodes = 4\nearly_end = true");
    std::fs::write(folder.path().join("ledger.toml"), early).expect("written");
    let (same_findings, ended) = run("early");
    assert_eq!(findings, same_findings);
    assert_eq!(whole.len(), ended.len());
    let shorter = whole
        .iter()
        .filter(|(name, bytes)| ended[*name].len() < bytes.len());
    assert_eq!(
        shorter.count(),
        whole.len(),
        "each of these robots decides before its end"
    );
}

#[test]
fn the_built_program_finds_the_library_that_was_fetched() {
    let is_in_project = Path::new(env!("CARGO_BIN_EXE_corroborate")).starts_with(support::root());
    if library().is_none() || !is_in_project {
        eprintln!("skipped: the program was built elsewhere, or there is nothing to find");
        return;
    }
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let study = handover().display().to_string();
    let arguments = ["simulate", &study, "E2", "-n", "1", "--out", "out"];
    let mut program = command(folder.path(), &arguments);
    let output = program.env_remove("CORROBORATE_MUJOCO").output();
    let output = output.expect("the program starts");
    let talk = String::from_utf8_lossy(&output.stderr);
    assert!(!talk.contains("no-physics-library"), "{talk}");
    assert!(folder.path().join("out").is_dir(), "{talk}");
}
