//! A scene in both physics engines, as a user meets it: the corridor, whose robot is driven by a program in Python.
//!
//! Needs the physics library and `python3`. Without the library the tests are skipped with a line that says so, except in
//! continuous integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use support::copy_study;
use support::program::{Said, command, said};
use support::simulation::{driven, handover, keep_only, library, simulating};

/// The corridor's study in a folder of its own, with physics in longer steps and episodes of at most so many seconds,
/// for what tests wait.
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

/// An entry says its engine, so that what it shows needs no library; its evidence and its replay are of that engine.
#[test]
fn an_entry_of_the_ledger_is_run_in_the_engine_that_it_names() {
    let folder = tempfile::TempDir::new().expect("a folder");
    for (name, text) in [
        ("study.toml", FALLING_STUDY),
        ("requirements.toml", FALLING_REQUIREMENTS),
        ("vocabulary.toml", FALLING_VOCABULARY),
        ("ledger.toml", FALLING_LEDGER),
        ("scene.toml", FALLING_SCENE),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let without_library =
        |arguments: &[&str]| said(command(folder.path(), arguments).env("CORROBORATE_MUJOCO", ""));
    let ran = without_library(&["run", ".", "--quiet"]);
    assert!([0, 3].contains(&ran.code), "{ran:?}");
    let evidence = support::read(&folder.path().join("results/evidence/S1.json"));
    let evidence: Value = serde_json::from_str(&evidence).expect("JSON");
    assert!(evidence.to_string().contains("Rapier"), "{evidence}");
    // The same inputs give the same episode, in the same engine.
    let again = without_library(&["verify", "results", ".", "--deep"]);
    assert!([0, 3].contains(&again.code), "{again:?}");
    let replayed = without_library(&["replay", ".", "S1:1"]);
    assert!([0, 1].contains(&replayed.code), "{replayed:?}");
    // Another engine than the two is no engine, and what has none takes no such key.
    let ledger = folder.path().join("ledger.toml");
    std::fs::write(&ledger, FALLING_LEDGER.replace("rapier", "bullet")).expect("written");
    let refused = without_library(&["plan", "."]);
    assert_eq!(refused.code, 2, "{refused:?}");
    assert!(
        refused.talk.contains("ledger.toml:8") && refused.talk.contains("mujoco"),
        "{refused:?}"
    );
}

const FALLING_STUDY: &str = "title = \"A stone\"\nsummary = \"It falls.\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
    [conditions]\nusual = \"u\"\n";

const FALLING_REQUIREMENTS: &str = "[[requirement]]\nid = \"down\"\ntext = \"The stone comes to the ground.\"\n\
    formula = \"eventually[0,1.4 s] low\"\nmargin = 0.1\n";

const FALLING_VOCABULARY: &str =
    "low = { meaning = \"it is near the ground\", trace = \"/truth/stone.z < 0.2 m\" }\n";

const FALLING_LEDGER: &str = "[[evidence]]\nid = \"S1\"\ntitle = \"s\"\ntechnique = \"simulation\"\nconditions = \"usual\"\n\
    scene = \"scene.toml\"\nepisodes = 2\nengine = \"rapier\"\nchanged = \"c\"\n";

const FALLING_SCENE: &str = r#"
name = "a stone falls"
simulation = { duration_secs = 1.5, time_step_secs = 0.005 }
[[object]]
name = "stone"
radius_m = 0.1
mass_kg = 1.0
z_m = 1.0
[[abstract_test]]
name = "nothing"
actions = []
"#;

#[test]
fn the_handover_is_run_in_both_engines_and_compared() {
    let Some(library) = library() else { return };
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&handover(), folder.path());
    let arguments = ["engines", ".", "E4", "-n", "1", "--format", "json"];
    let said = simulating(&library, folder.path(), &arguments);
    assert!([0, 1].contains(&said.code), "{said:?}");
    let found = json(&said);
    let engines = found["engines"].to_string();
    assert!(
        engines.contains("MuJoCo") && engines.contains("Rapier"),
        "{found}"
    );
    let signals = found["signals"].as_array().expect("signals");
    let typical = |name: &str| {
        let of = signals.iter().find(|signal| signal["signal"] == name);
        let typical = of.and_then(|signal| signal["typical"].as_f64());
        typical.unwrap_or_else(|| panic!("no {name}: {found}"))
    };
    // What the seed draws and physics has no part in is the same; the arm is where its drives take it, to millimetres.
    assert_eq!(typical("/truth.human_head.x"), 0.0, "{found}");
    let arm_m_s = typical("/robot.hand_speed");
    assert!(arm_m_s > 0.0 && arm_m_s < 0.01, "{arm_m_s}");
}

/// An entry of the handover that names Rapier needs no library, is evidence of that engine, and is stale once it names another.
#[test]
fn an_entry_of_the_handover_is_evidence_of_the_engine_that_it_names() {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&handover(), folder.path());
    keep_only(folder.path(), &["E3", "E4-published", "E4"]);
    let ledger = folder.path().join("ledger.toml");
    let text = support::read(&ledger);
    let (of_mujoco, episodes) = ("episodes = 1", "episodes = 500");
    assert!(text.contains(episodes), "{text}");
    let of_mujoco = text.replace(episodes, of_mujoco);
    let of_rapier = text.replace(episodes, "episodes = 1\nengine = \"rapier\"");
    std::fs::write(&ledger, &of_rapier).expect("written");
    let without_library =
        |arguments: &[&str]| said(command(folder.path(), arguments).env("CORROBORATE_MUJOCO", ""));
    let ran = without_library(&["run", ".", "--quiet"]);
    assert!([0, 1, 3].contains(&ran.code), "{ran:?}");
    let evidence = support::read(&folder.path().join("results/evidence/E4.json"));
    assert!(
        evidence.contains("Rapier") && !evidence.contains("MuJoCo"),
        "{evidence}"
    );
    let plan = without_library(&["plan", "."]);
    assert!(plan.out.contains("would produce nothing"), "{plan:?}");
    std::fs::write(&ledger, &of_mujoco).expect("written");
    // What was found in Rapier is no evidence of MuJoCo, which is missing without the library; Rapier can still be asked for.
    let plan = without_library(&["plan", "."]);
    assert!(plan.out.contains("need the MuJoCo library"), "{plan:?}");
    let missing = without_library(&["simulate", ".", "E4", "-n", "1", "--out", "out"]);
    assert!(missing.talk.contains("no-physics-library"), "{missing:?}");
    let arguments = "simulate . E4 --engine rapier -n 1 --out out --format json";
    let arguments: Vec<&str> = arguments.split(' ').collect();
    let simulated = without_library(&arguments);
    assert!(simulated.out.contains("Rapier"), "{simulated:?}");
}

/// A command has an engine of its own.
#[test]
fn a_command_is_refused_in_another_engine_with_what_can_be_named() {
    let folder = tempfile::TempDir::new().expect("a folder");
    for (name, text) in [
        ("study.toml", FALLING_STUDY),
        ("requirements.toml", FALLING_REQUIREMENTS),
        ("vocabulary.toml", FALLING_VOCABULARY),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let ledger = "[[evidence]]\nid = \"S1\"\ntitle = \"s\"\ntechnique = \"simulation\"\nconditions = \"usual\"\n\
        command = [\"true\", \"{seed}\", \"{recording}\"]\nepisodes = 1\nchanged = \"c\"\n";
    std::fs::write(folder.path().join("ledger.toml"), ledger).expect("written");
    let arguments = ["simulate", ".", "S1", "--engine", "rapier", "--out", "out"];
    let refused = said(command(folder.path(), &arguments).env("CORROBORATE_MUJOCO", ""));
    assert_eq!(refused.code, 2, "{refused:?}");
    assert!(refused.talk.contains("one-engine"), "{refused:?}");
}
