//! A scene in both physics engines, as a user meets it: the corridor, whose robot is driven by a program in Python.
//!
//! Needs the physics library and `python3`. Without the library the tests are skipped with a line that says so, except in
//! continuous integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use support::copy_study;
use support::program::Said;
use support::simulation::{driven, handover, library, simulating};

/// The corridor's study in a folder of its own, with physics in longer steps and episodes of at most so many seconds:
/// the second engine is built without optimisation for tests.
fn corridor(longest_secs: f64) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(
        &support::root().join("case-studies/corridor"),
        folder.path(),
    );
    let scene = folder.path().join("simulation/scene.toml");
    let mut text = std::fs::read_to_string(&scene).expect("a scene");
    for (old, new) in [
        ("time_step_secs = 0.002", "time_step_secs = 0.005".into()),
        (
            "duration_secs = 40",
            format!("duration_secs = {longest_secs}"),
        ),
    ] {
        assert!(text.contains(old), "{text}");
        text = text.replace(old, &new);
    }
    std::fs::write(&scene, text).expect("written");
    folder
}

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

#[test]
fn the_same_episode_in_both_engines_lies_near_and_is_judged_alike() {
    let Some(library) = library() else { return };
    let folder = corridor(40.0);
    let arguments = ["engines", ".", "S1", "-n", "1", "--format", "json"];
    let said = driven(&library, folder.path(), &arguments);
    assert_eq!(said.code, 0, "{said:?}");
    let found = json(&said);
    let signals = found["signals"].as_array().expect("signals");
    let typical = |name: &str| {
        let of = signals.iter().find(|signal| signal["signal"] == name);
        let typical = of.and_then(|signal| signal["typical"].as_f64());
        typical.unwrap_or_else(|| panic!("no {name}: {found}"))
    };
    // What physics has no part in is the same; where the robot is differs, but by less than its own length.
    assert_eq!(typical("/truth/ben.x"), 0.0, "{found}");
    let lies_apart = typical("/truth/carrier.x");
    assert!(lies_apart > 0.0 && lies_apart < 0.3, "{lies_apart}");
    let verdicts = found["verdicts"].as_array().expect("verdicts");
    assert!(verdicts.len() >= 4, "{found}");
    let alike = |verdict: &Value| verdict["differ"].as_array().is_some_and(Vec::is_empty);
    assert!(verdicts.iter().all(alike), "{found}");
}

#[test]
fn both_engines_repeat_and_continue_an_episode_to_the_same_hash() {
    let Some(library) = library() else { return };
    let folder = corridor(4.0);
    let arguments = [
        "engines",
        ".",
        "S1",
        "-n",
        "1",
        "--determinism",
        "--format",
        "json",
    ];
    let said = driven(&library, folder.path(), &arguments);
    assert_eq!(said.code, 0, "{said:?}");
    let found = json(&said);
    let repeated = found["repeated"].as_array().expect("repeated");
    assert_eq!(repeated.len(), 2, "{found}");
    for engine in repeated {
        assert_eq!(engine["hash"], engine["again"], "{found}");
        assert_eq!(engine["hash"], engine["continued"], "{found}");
    }
    assert_ne!(repeated[0]["hash"], repeated[1]["hash"], "{found}");
}

#[test]
fn a_scene_is_simulated_in_the_second_engine_alone() {
    let Some(library) = library() else { return };
    let folder = corridor(40.0);
    let arguments = [
        "simulate", ".", "S1", "--engine", "rapier", "-n", "1", "--out", "out",
    ];
    let said = driven(&library, folder.path(), &arguments);
    // One journey decides nothing of nine in ten.
    assert_eq!(said.code, 3, "{said:?}");
    assert!(
        said.out.contains("arrival") || said.talk.contains("arrival"),
        "{said:?}"
    );
    let judged = driven(&library, folder.path(), &["monitor", ".", "out"]);
    assert_eq!(judged.code, 0, "{judged:?}");
}

#[test]
fn the_handover_is_refused_with_what_it_would_need() {
    let Some(library) = library() else { return };
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&handover(), folder.path());
    for arguments in [
        &["engines", ".", "E4", "-n", "1"][..],
        &[
            "simulate", ".", "E4", "--engine", "rapier", "-n", "1", "--out", "out",
        ],
    ] {
        let said = simulating(&library, folder.path(), arguments);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(said.talk.contains("written for MuJoCo"), "{said:?}");
        assert_eq!(said.out, "", "{said:?}");
    }
}
