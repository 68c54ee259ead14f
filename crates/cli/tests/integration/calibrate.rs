//! Calibration as a user meets it: a small one of the handover, and priors that are wrong. Files that are wrong are in the tests
//! of the library.
//!
//! Needs the physics library; without it the tests that simulate are skipped with a line that says
//! so, except in continuous integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use std::path::Path;
use support::program::Said;
use support::simulation::{handover, library, simulating};
use support::{copy_study, read, root, schema};

/// The handover's study with a calibration of few episodes, changed.
fn study(changes: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&handover(), folder.path());
    let file = folder.path().join("calibration.toml");
    let mut text = read(&file);
    let small = [
        ("rounds = 3", "rounds = 2"),
        ("episodes_per_round = 400", "episodes_per_round = 8"),
        ("check_episodes = 300", "check_episodes = 6"),
    ];
    for (old, new) in small.iter().chain(changes) {
        assert!(text.contains(old), "no `{old}`");
        text = text.replacen(old, new, 1);
    }
    std::fs::write(file, text).expect("written");
    folder
}

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

#[test]
fn a_small_calibration_reports_everything_and_the_same_again() {
    let Some(library) = library() else { return };
    let folder = study(&[]);
    let arguments = [
        "calibrate",
        ".",
        "calibration.toml",
        "--format",
        "json",
        "--to",
        "fitted.toml",
    ];
    let said = simulating(&library, folder.path(), &arguments);
    let report = json(&said);
    let expected = match report["conclusion"].as_str() {
        Some("equivalent") => 0,
        Some("different") => 1,
        Some("undecided") => 3,
        other => panic!("{other:?}"),
    };
    assert_eq!(said.code, expected, "{said:?}");
    let schema: Value = serde_json::from_str(&read(&root().join("schemas/calibrate.schema.json")))
        .expect("a schema");
    let violations = schema::violations(&schema, &report);
    assert!(violations.is_empty(), "{violations:?}");
    assert_eq!(report["episodes"], 16);
    assert_eq!(report["parameters"].as_array().map(Vec::len), Some(4));
    let mode = |id: &str| {
        let modes = report["modes"].as_array().expect("modes");
        modes
            .iter()
            .find(|mode| mode["id"] == id)
            .expect("a mode")
            .clone()
    };
    // By subject, after the two lost objects: 98 opportunities; the gaze's, too.
    let pressure = mode("false_negative_pressure");
    assert_eq!(
        (&pressure["occurrences"], &pressure["opportunities"]),
        (&7.into(), &98.into())
    );
    assert_eq!(
        (&pressure["by_subject"], &pressure["held_out"]),
        (&true.into(), &false.into())
    );
    assert_eq!(mode("runtime_error")["by_subject"], false);
    assert_eq!(mode("1a")["occurrences"], 12);
    assert_eq!(mode("1a")["held_out"], true);
    // What is fitted is no evidence; with 6 episodes nothing is shown of what was held out.
    assert_eq!(mode("false_negative_pressure")["margin"], 0.05);
    let runtime_error = mode("runtime_error");
    assert_eq!(runtime_error["likeness"], "undecided");
    assert!(
        runtime_error["equivalence_p"].as_f64() > Some(0.05),
        "{runtime_error}"
    );
    assert_ne!(report["conclusion"], "equivalent");
    for parameter in report["parameters"].as_array().expect("parameters") {
        let contraction = parameter["contraction"].as_f64().expect("a number");
        let words = match contraction {
            it if it >= 0.8 => "identified",
            it if it >= 0.5 => "weakly-identified",
            _ => "not-identified",
        };
        assert_eq!(parameter["identifiability"], words, "{parameter}");
    }
    // Each person is predicted once, and all their runs together are the experiments'.
    let groups = report["held_out_runs"].as_array().expect("groups");
    let subjects: usize = groups
        .iter()
        .map(|it| it["subjects"].as_array().map_or(0, Vec::len))
        .sum();
    assert_eq!((groups.len(), subjects), (5, 10));
    let of = |group: &Value, key: &str| -> u64 {
        let predictions = group["predictions"].as_array().expect("predictions");
        let one = predictions
            .iter()
            .find(|it| it["id"] == "false_negative_pressure");
        one.expect("predicted")[key].as_u64().expect("a count")
    };
    let sum = |key: &str| groups.iter().map(|group| of(group, key)).sum::<u64>();
    assert_eq!((sum("occurrences"), sum("opportunities")), (7, 98));

    // What is printed is kept for the report.
    let result = folder.path().join("results/calibration/calibration.json");
    let text = read(&result);
    let mut kept_result: Value = serde_json::from_str(&text).expect("JSON");
    let digest = kept_result
        .as_object_mut()
        .and_then(|it| it.remove("digest"));
    assert!(digest.is_some_and(|it| it.is_string()), "{text}");
    assert_eq!(kept_result, json(&said));
    // The written set is the printed one, and a simulation takes it.
    let written = read(&folder.path().join("fitted.toml"));
    assert_eq!(Some(written.as_str()), report["parameter_set"].as_str());
    assert!(
        written.contains("is a fit") && written.contains("grip_failure 2/100"),
        "{written}"
    );
    let ledger = folder.path().join("ledger.toml");
    let text = read(&ledger).replace("simulation/untuned.toml", "fitted.toml");
    std::fs::write(&ledger, text).expect("written");
    let simulate = ["simulate", ".", "E2", "--episodes", "1", "--out", "one"];
    let simulated = simulating(&library, folder.path(), &simulate);
    assert!([1, 3].contains(&simulated.code), "{simulated:?}");

    // Called again, episodes are taken as they were kept.
    let before = kept(folder.path());
    let again = simulating(&library, folder.path(), &arguments);
    assert_eq!(again.out, said.out);
    assert_eq!(kept(folder.path()), before);
    // Other counts held out: the episodes of the first round are kept still.
    let file = folder.path().join("calibration.toml");
    let text = read(&file).replace(
        "hold_out_runs.folds = 5",
        "hold_out_runs.subjects = [\"8\"]",
    );
    std::fs::write(&file, text).expect("written");
    let other = json(&simulating(&library, folder.path(), &arguments));
    assert_eq!(other["held_out_runs"][0]["fitted_set_without_them"], true);
    assert_eq!(kept(folder.path())[0], before[0]);
    let written = read(&folder.path().join("fitted.toml"));
    assert!(
        written.contains("false_negative_pressure 5/88")
            && written.contains("runs of 8")
            && written.contains("(posterior mode)"),
        "{written}"
    );
}

/// The tuned handover is what the command wrote from the files that are there: who changes one of them
/// has to calibrate again.
#[test]
fn the_handovers_tuned_set_names_the_files_that_it_was_made_from() {
    let folder = handover();
    let text = read(&folder.join("simulation/tuned.toml"));
    let comments = text.lines().filter_map(|line| line.strip_prefix("#   "));
    let files: Vec<(&str, &str)> = comments
        .filter_map(|line| line.strip_suffix(')')?.rsplit_once(" ("))
        .filter(|(_, hash)| hash.len() == 64)
        .collect();
    assert_eq!(files.len(), 6, "{text}");
    for (file, hash) in files {
        let content = read(&folder.join(file));
        assert_eq!(
            blake3::hash(content.as_bytes()).to_hex().as_str(),
            hash,
            "{file}"
        );
    }
}

/// The kept episodes in order, with when they were written.
fn kept(folder: &Path) -> Vec<(String, std::time::SystemTime)> {
    let entries = std::fs::read_dir(folder.join("results/calibration")).expect("kept");
    let mut files: Vec<_> = entries
        .flatten()
        .filter(|entry| {
            let name = entry.file_name();
            let name = name.to_string_lossy();
            name.starts_with("episodes-") && name.ends_with(".json")
        })
        .map(|entry| {
            let time = entry
                .metadata()
                .and_then(|it| it.modified())
                .expect("a time");
            (entry.file_name().to_string_lossy().into_owned(), time)
        })
        .collect();
    files.sort();
    files
}

#[test]
fn priors_that_the_simulator_does_not_take_are_said_before_anything_runs() {
    let Some(library) = library() else { return };
    for (old, new, message) in [
        (
            "parameters.hand.friction.uniform.0",
            "parameters.hand.frictoin.uniform.0",
            "friction",
        ),
        (
            "uniform = [0.28, 0.6]",
            "uniform = [-2.0, 0.6]",
            "lowest friction",
        ),
        (
            "uniform = [0.28, 0.6]",
            "uniform = [0.28, 0.95]",
            "lowest friction",
        ),
    ] {
        let folder = study(&[(old, new)]);
        let said = simulating(
            &library,
            folder.path(),
            &["calibrate", ".", "calibration.toml"],
        );
        assert_eq!(said.code, 2, "{new}: {said:?}");
        let place = said.talk.contains("calibration.toml:");
        assert!(place && said.talk.contains(message), "{new}: {said:?}");
        assert!(!folder.path().join("results/calibration").exists(), "{new}");
    }
}

#[test]
fn counts_of_none_and_of_all_are_fitted() {
    let Some(library) = library() else { return };
    // As if no person and then every person had lost the object: the tables are replaced whole.
    for occurrences in [0_u64, 100] {
        let fit = (
            "fit = [\"grip_failure\", \"false_negative_pressure\", \"false_negative_location\"]",
            "fit = [\"grip_failure\"]",
        );
        let hold = (
            "hold_out = [\"runtime_error\", \"false_negative_gaze\", \"1a\"]",
            "hold_out = []",
        );
        let by = ("hold_out_runs.folds = 5", "by_subject = false");
        let parts = ["pressure", "location", "gaze"]
            .map(|mode| format!("no_opportunity_after.false_negative_{mode} = [\"grip_failure\"]"));
        let mut changes = vec![
            fit,
            hold,
            by,
            ("rounds = 2", "rounds = 1"),
            ("check_episodes = 6", "check_episodes = 2"),
        ];
        changes.extend(parts.iter().map(|part| (part.as_str(), "")));
        let folder = study(&changes);
        let table = folder.path().join("experiments/failure_modes.csv");
        std::fs::write(
            &table,
            format!("mode,occurrences,opportunities\ngrip_failure,{occurrences},100\n"),
        )
        .expect("written");
        let ledger = folder.path().join("ledger.toml");
        let text = read(&ledger).replace("tables.cohort = \"experiments/cohort.csv\"\n", "");
        std::fs::write(&ledger, text).expect("written");
        let said = simulating(
            &library,
            folder.path(),
            &["calibrate", ".", "calibration.toml", "--format", "json"],
        );
        // Nothing was held out, so nothing is shown.
        assert!([1, 3].contains(&said.code), "{said:?}");
        let report = json(&said);
        assert_eq!(report["modes"][0]["occurrences"], occurrences);
        assert!(report["effective_size"].as_f64() > Some(1.0), "{report}");
    }
}

/// A robot that stands still where a setting puts it.
const SCENE: &str = r#"
name = "standing"
simulation = { duration_secs = 0.2, time_step_secs = 0.01 }

[[robot]]
name = "carrier"
file = "carrier.urdf"
y_m = 0.5
yaw_rad = { uniform = [-0.1, 0.1] }

[[abstract_test]]
name = "nothing"
actions = []
"#;

/// What the corridor's study has beside its own, for that scene: the requirement, the word, and the ledger's entries.
const MORE: [(&str, &str); 3] = [
    (
        "requirements.toml",
        r#"
[[requirement]]
id = "place"
text = "The robot is not far to the left."
shall = "The robot shall always satisfy placed."
margin = 0.05
"#,
    ),
    (
        "vocabulary.toml",
        r#"
[placed]
meaning = "The robot is where it ought to be."
trace = "/truth/carrier.y < 1 m"
"#,
    ),
    (
        "ledger.toml",
        r#"
[[evidence]]
id = "stand"
title = "A robot that stands"
technique = "simulation"
conditions = "typical"
scene = "simulation/standing.toml"
test = "nothing"
episodes = 5
changed = "A robot that stands still."

[[evidence]]
id = "looked"
title = "Where it stood"
technique = "experiment"
conditions = "typical"
tables.requirements = "looked.csv"
changed = "Forty looks."
"#,
    ),
];

const OF_SCENE: &str = r#"
name = "placed"
simulator = "stand"
test = "nothing"
evidence = "looked"
fit = ["place"]
rounds = 2
episodes_per_round = 12
check_episodes = 8

[known]
simulation.duration_secs = 0.1

[[parameter]]
name = "place"
unit = "m"
sets = ["robot.carrier.y_m"]
uniform = [0.0, 2.0]
"#;

#[test]
fn a_scene_is_fitted_and_the_fitted_one_is_a_scene_again() {
    let Some(library) = library() else { return };
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&root().join("case-studies/corridor"), folder.path());
    for (file, more) in MORE {
        let file = folder.path().join(file);
        std::fs::write(&file, read(&file) + more).expect("written");
    }
    let counts = "requirement,covered,passed,failed\nplace,40,30,10\n";
    for (file, text) in [
        ("simulation/standing.toml", SCENE),
        ("looked.csv", counts),
        ("calibration.toml", OF_SCENE),
    ] {
        std::fs::write(folder.path().join(file), text).expect("written");
    }
    let to = "simulation/standing.toml";
    let arguments = [
        "calibrate",
        ".",
        "calibration.toml",
        "--format",
        "json",
        "--to",
        to,
    ];
    let said = simulating(&library, folder.path(), &arguments);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let report = json(&said);
    assert_eq!(report["episodes"], 24);
    let files = report["lineage"]["files"].to_string();
    for file in ["standing.toml", "carrier.urdf", "looked.csv"] {
        assert!(files.contains(file), "{files}");
    }
    let fitted: toml::Table = toml::from_str(&read(&folder.path().join(to))).expect("a scene");
    let [robot] = &fitted["robot"].as_array().expect("robots")[..] else {
        panic!("{fitted}")
    };
    assert_eq!(
        robot["y_m"].as_float(),
        report["parameters"][0]["fitted"].as_f64()
    );
    assert_eq!(fitted["name"].as_str(), Some("placed"));
    assert_eq!(fitted["simulation"]["duration_secs"].as_float(), Some(0.1));
    // It is a scene: fitting it again begins with it.
    let again = simulating(&library, folder.path(), &arguments);
    assert!([0, 1, 3].contains(&again.code), "{again:?}");
}
