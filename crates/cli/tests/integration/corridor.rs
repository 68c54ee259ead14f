//! Scenes as a user meets them: the corridor, whose robot is driven by a program in Python.
//!
//! Needs the physics library and `python3`. Without the library the tests are skipped with a line
//! that says so, except in continuous integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use std::path::{Path, PathBuf};
use support::simulation::{driven, library};
use support::{copy_study, root};

/// The corridor's study with fewer episodes, and a change in one of its files.
fn study(file: &str, old: &str, new: &str) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&root().join("case-studies/corridor"), folder.path());
    change(
        &folder.path().join("ledger.toml"),
        "episodes = 100",
        "episodes = 2",
    );
    change(&folder.path().join(file), old, new);
    folder
}

fn change(file: &Path, old: &str, new: &str) {
    let text = std::fs::read_to_string(file).expect("a text");
    assert!(text.contains(old), "{} has no `{old}`", file.display());
    std::fs::write(file, text.replace(old, new)).expect("written");
}

fn episodes(folder: &Path, out: &str, evidence: &str) -> Vec<Vec<u8>> {
    let episodes: PathBuf = folder.join(out).join("episodes").join(evidence);
    (1..=2)
        .map(|n| std::fs::read(episodes.join(format!("episode-{n:05}.mcap"))).expect("an episode"))
        .collect()
}

#[test]
fn a_robot_driven_by_python_is_judged_like_any_other_and_the_same_each_time() {
    let Some(library) = library() else { return };
    // A mesh that is not there is not simulated, which is part of what was found.
    let mast = "<collision name=\"mast\">";
    let bumper = "<collision name=\"bumper\"><geometry><mesh filename=\"bumper.stl\"/></geometry></collision>";
    let folder = study("simulation/carrier.urdf", mast, &format!("{bumper}{mast}"));
    for threads in ["1", "2"] {
        let arguments = ["run", ".", "-j", threads, "--out", threads];
        let said = driven(&library, folder.path(), &arguments);
        assert!([0, 1, 3].contains(&said.code), "{said:?}");
    }
    for evidence in ["S1", "S2"] {
        let of = |threads: &str| episodes(folder.path(), threads, evidence);
        assert!(
            of("1") == of("2"),
            "{evidence} depends on the number of threads"
        );
    }
    let text = std::fs::read_to_string(folder.path().join("1/study.json")).expect("a result");
    let result: Value = serde_json::from_str(&text).expect("JSON");
    let simulated = &result["evidence"][1];
    let assets = simulated["assets"].as_array().expect("assets");
    for path in [
        "simulation/scene.toml",
        "simulation/carrier.urdf",
        "controller/corridor.py",
    ] {
        let is_it = |asset: &&Value| asset["path"] == path;
        assert!(
            assets.iter().any(|asset| is_it(&asset)),
            "{path} is not among {assets:?}"
        );
    }
    let gaps = simulated["description_gaps"].as_array().expect("gaps");
    let [gap] = &gaps[..] else { panic!("{gaps:?}") };
    let (file, line) = (
        "simulation/carrier.urdf",
        gap["line"].as_u64().expect("a line"),
    );
    let urdf = std::fs::read_to_string(folder.path().join(file)).expect("a description");
    assert!(
        urdf.lines()
            .nth(line as usize - 1)
            .expect("that line")
            .contains("bumper.stl")
    );
    assert_eq!(
        (&gap["file"], &gap["effect"]),
        (&file.into(), &"contact".into())
    );
    let again = std::fs::read_to_string(folder.path().join("2/study.json")).expect("a result");
    let again: Value = serde_json::from_str(&again).expect("JSON");
    assert_eq!(
        again["evidence"][1]["description_gaps"],
        simulated["description_gaps"]
    );
    let page = std::fs::read_to_string(folder.path().join("1/report.html")).expect("a page");
    assert!(page.contains("Not simulated as it is described") && page.contains("bumper.stl"));
    let arrival = simulated["findings"].as_array().expect("findings");
    let arrival = arrival.iter().find(|f| f["subject"]["id"] == "arrival");
    assert_eq!(arrival.expect("arrival")["measure"]["trials"], 2);
}

#[test]
fn a_changed_controller_makes_its_evidence_stale() {
    let Some(library) = library() else { return };
    let folder = study("ledger.toml", "S1", "S1");
    let arguments = ["run", ".", "--only", "S1"];
    assert_eq!(driven(&library, folder.path(), &arguments).code, 0);
    let before = episodes(folder.path(), "results", "S1");
    let controller = folder.path().join("controller/corridor.py");
    change(&controller, "-1.0, min(1.0, 1.5 *", "-1.0, min(1.0, 1.4 *");
    assert_eq!(driven(&library, folder.path(), &arguments).code, 0);
    assert!(episodes(folder.path(), "results", "S1") != before);
}

#[test]
fn what_goes_wrong_with_a_scene_or_its_controller_is_said() {
    let Some(library) = library() else { return };
    let hang = "        import time\n        time.sleep(600)\n        odometry = ";
    for (file, old, new, expected) in [
        (
            "simulation/scene.toml",
            "corridor.py",
            "corridr.py",
            "corridr.py",
        ),
        (
            "simulation/scene.toml",
            "carrier.urdf",
            "carier.urdf",
            "carier.urdf",
        ),
        ("simulation/scene.toml", "rays = 61", "rayz = 61", "rayz"),
        (
            "ledger.toml",
            "ben_crosses",
            "ben_croses",
            "did you mean `ben_crosses`",
        ),
        (
            "controller/corridor.py",
            "self.longest = lidar",
            "self.longst = lidar",
            "no attribute 'longest'",
        ),
        (
            "controller/corridor.py",
            "        odometry = ",
            hang,
            "the robot's program hangs in 2 of 2 episodes",
        ),
        (
            "vocabulary.toml",
            "carrier.person_distance",
            "carrier.persn_distance",
            "did you mean",
        ),
    ] {
        let folder = study(file, old, new);
        let scene = folder.path().join("simulation/scene.toml");
        change(
            &scene,
            "latency_secs = 0.02\n",
            "latency_secs = 0.02\nanswer_within_secs = 4\n",
        );
        let said = driven(&library, folder.path(), &["run", "."]);
        // A program that hangs is what was found out, not a mistake in the study; nothing is covered then.
        let code = if new == hang { 3 } else { 2 };
        assert_eq!(said.code, code, "{new}: {said:?}");
        assert!(said.talk.contains(expected), "{new}: {said:?}");
    }
}
