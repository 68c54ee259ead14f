//! The collaborative cell: what its README concludes, without the two scenes, so that no physics library is needed. Needs
//! `python3`, in which the rig and the stand-in for reality are written; nothing else.

use crate::support;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::program::corroborate;
use support::simulation::keep_only;
use support::{copy_study, read, root};

fn cell() -> PathBuf {
    root().join("case-studies/cell")
}

/// All of the ledger but the scenes.
const KEPT: [&str; 11] = [
    "F1",
    "K1",
    "T1",
    "F2",
    "K2",
    "O1",
    "K2-recorded",
    "F3",
    "K3",
    "A1",
    "T2",
];

/// A copy of the study as it lies in the project, for the rig looks for its module beside `case-studies`.
fn study() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::TempDir::new().expect("a folder");
    let study = folder.path().join("case-studies/cell");
    copy_study(&cell(), &study);
    copy_study(
        &root().join("integrations/common"),
        &folder.path().join("integrations/common"),
    );
    keep_only(&study, &KEPT);
    (folder, study)
}

fn by_id<'a>(list: &'a Value, key: &str, id: &str) -> &'a Value {
    let all = list.as_array().expect("a list");
    let found = all.iter().find(|one| one[key] == id);
    found.unwrap_or_else(|| panic!("{id} is not among {key}"))
}

fn measure<'a>(result: &'a Value, evidence: &str, subject: &str) -> &'a Value {
    let findings = &by_id(&result["evidence"], "id", evidence)["findings"];
    let all = findings.as_array().expect("findings");
    let found = all.iter().find(|one| one["subject"]["id"] == subject);
    &found.unwrap_or_else(|| panic!("{evidence} says nothing of {subject}"))["measure"]
}

/// Counts as `[count, trials]`.
fn counts(result: &Value, evidence: &str, subject: &str) -> [u64; 2] {
    let measure = measure(result, evidence, subject);
    ["count", "trials"].map(|key| measure[key].as_u64().expect("a number"))
}

fn value(result: &Value, evidence: &str, subject: &str) -> f64 {
    let answer = &measure(result, evidence, subject)["answer"];
    answer["value"].as_f64().expect("a value")
}

fn comparison<'a>(result: &'a Value, left: &str, right: &str, subject: &str) -> &'a Value {
    let all = result["comparisons"].as_array().expect("comparisons");
    let found = all.iter().find(|one| {
        one["left"] == left && one["right"] == right && one["subject"]["id"] == subject
    });
    found.unwrap_or_else(|| panic!("{left} and {right} are not compared on {subject}"))
}

#[track_caller]
fn assert_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 5e-4, "{found}, not {expected}");
}

#[test]
#[ignore = "runs 1,500 episodes of a simulator; `.ci/run studies` runs it"]
fn the_conclusions_of_the_cell_are_those_of_its_readme() {
    let (folder, study) = study();
    let arguments = ["run", ".", "--out", "out"];
    let said = corroborate(&study, &arguments);
    assert_eq!(said.code, 1, "{said:?}");
    let result: Value = serde_json::from_str(&read(&study.join("out/study.json"))).expect("JSON");

    for (requirement, verdict, step) in [
        ("separation", "violated", Some("system")),
        ("transient", "violated", Some("system")),
        ("quasi_static", "undecided", None),
        ("work", "satisfied", Some("model")),
    ] {
        let conclusion = by_id(&result["conclusions"], "requirement", requirement);
        assert_eq!(conclusion["verdict"], verdict, "{requirement}");
        assert_eq!(conclusion["step"].as_str(), step, "{requirement}");
    }

    // Trials, recordings and the rig at each of its steps.
    for (evidence, subject, expected) in [
        ("T1", "separation", [216, 222]),
        ("T2", "separation", [215, 224]),
        ("T1", "work", [217, 240]),
        ("T2", "work", [212, 240]),
        ("T1", "lost", [2, 240]),
        ("T2", "lost", [8, 240]),
        ("O1", "separation", [6, 6]),
        ("O1", "struck", [7, 13]),
        ("K1", "separation", [293, 293]),
        ("K1", "work", [273, 300]),
        ("K2", "separation", [270, 289]),
        ("K2", "work", [293, 300]),
        ("K3", "separation", [543, 582]),
        ("K3", "work", [523, 600]),
    ] {
        assert_eq!(
            counts(&result, evidence, subject),
            expected,
            "{evidence}, {subject}"
        );
    }

    // The formal model at each of its steps, and for anybody.
    assert_near(value(&result, "F1", "separation"), 0.9988);
    assert_near(value(&result, "F2", "separation"), 0.9286);
    assert_near(value(&result, "F3", "separation"), 0.9425);
    assert_near(value(&result, "F2", "work"), 0.9999);
    assert_near(value(&result, "F3", "work"), 0.8705);
    assert_near(value(&result, "A1", "separation"), 1.0);

    // The first models agree with each other and not with the trials; the calibrated one misses what was held out, and the
    // refined one does not.
    for (left, right, subject, outcome, is_independent) in [
        ("F1", "K1", "separation", "corroborates", true),
        ("F1", "T2", "unnoticed", "conflicts", true),
        ("F1", "T2", "work", "conflicts", true),
        ("F2", "T2", "work", "conflicts", true),
        ("F3", "T2", "work", "corroborates", true),
        ("K3", "T2", "work", "corroborates", true),
        ("T1", "F3", "work", "corroborates", false),
        ("F3", "K3", "separation", "corroborates", false),
    ] {
        let compared = comparison(&result, left, right, subject);
        let name = format!("{left} and {right} on {subject}");
        assert_eq!(compared["outcome"], outcome, "{name}");
        assert_eq!(compared["independent"], is_independent, "{name}");
    }
    drop(folder);
}

/// What the stand-in for reality leaves, made again into a folder.
fn made(what: &str, folder: &Path) {
    let done = Command::new("python3")
        .arg(cell().join("reality/stand_in.py"))
        .args([what, &folder.to_string_lossy()])
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .status()
        .expect("python3 runs");
    assert!(done.success(), "{what}");
}

#[test]
fn trials_and_recordings_of_the_cell_are_made_again_byte_by_byte() {
    for (what, kept) in [("trials", "experiments"), ("recordings", "recordings")] {
        let folder = tempfile::TempDir::new().expect("a folder");
        made(what, folder.path());
        let mut files = 0;
        for entry in std::fs::read_dir(folder.path())
            .expect("a folder")
            .flatten()
        {
            let kept = cell().join(kept).join(entry.file_name());
            let again = std::fs::read(entry.path()).expect("a file");
            assert!(
                again == std::fs::read(&kept).expect("a kept file"),
                "{} is made otherwise",
                kept.display()
            );
            files += 1;
        }
        assert_eq!(files, if what == "trials" { 6 } else { 16 });
    }
}
