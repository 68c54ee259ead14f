//! The publication's path from E1 to E5 on both sides, formal and simulated, by the tool's own proposals: from the first
//! formal model, the untuned simulation and the experiments. The published simulations are not in the ledger.

use crate::support;

use serde_json::Value;
use std::path::Path;
use support::simulation::{handover, keep_only, library, simulating};
use support::{copy_study, read};

/// As things stood after the experiments, and what may be fitted; with fewer episodes where `changes` say so.
fn at_the_start(changes: &[(&str, &str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&handover(), folder.path());
    keep_only(folder.path(), &["E1", "E2", "rig", "E3"]);
    let ledger = folder.path().join("ledger.toml");
    let text = read(&ledger);
    let lines = text.lines().filter(|line| !line.contains("E2-published"));
    let text: String = lines.map(|line| format!("{line}\n")).collect();
    std::fs::write(ledger, text).expect("written");
    std::fs::remove_file(folder.path().join("simulation/tuned.toml")).expect("removed");
    for (file, old, new) in changes {
        let file = folder.path().join(file);
        let text = read(&file);
        assert!(text.contains(old), "no `{old}`");
        std::fs::write(file, text.replacen(old, new, 1)).expect("written");
    }
    folder
}

fn refined(library: &Path, folder: &Path, episodes: &str) -> Value {
    let arguments = [
        "refine",
        ".",
        "--all",
        "--rounds",
        "5",
        "--episodes",
        episodes,
    ];
    let arguments = [&arguments[..], &["--format", "json", "--quiet"]].concat();
    let said = simulating(library, folder, &arguments);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

fn made(report: &Value) -> Vec<&str> {
    let applied = report["applied"].as_array().expect("a list").iter();
    let entries = applied.filter_map(|it| it["entry"].as_str());
    entries.collect()
}

fn finding<'v>(study: &'v Value, id: &str, subject: &str) -> &'v Value {
    let all = study["evidence"].as_array().expect("evidence").iter();
    let piece = all.clone().find(|piece| piece["id"] == id);
    let findings = piece.unwrap_or_else(|| panic!("no {id}"))["findings"].as_array();
    let mut findings = findings.expect("findings").iter();
    let found = findings.find(|finding| finding["subject"]["id"] == subject);
    &found.expect("the subject")["measure"]
}

fn count(measure: &Value) -> (u64, u64) {
    let number = |name: &str| measure[name].as_u64().expect("a count");
    (number("count"), number("trials"))
}

/// The last of the models that the first one became, in however many steps.
fn last_model(report: &Value) -> &str {
    let of_model = |id: &&str| id.starts_with("E1-");
    made(report)
        .into_iter()
        .rfind(of_model)
        .unwrap_or_else(|| panic!("no step of the model: {report}"))
}

/// A model fails as often as the experiments counted, each way once in a run, and by the planner as often as given.
fn assert_counted_once(study: &Value, model: &str, planner: f64) {
    let counted = [
        ("grip_failure", 2.0 / 100.0),
        ("false_negative_gaze", 0.0),
        ("false_negative_pressure", 7.0 / 98.0),
        ("false_negative_location", 3.0 / 98.0),
    ];
    let passed: f64 = counted.iter().map(|(_, rate)| 1.0 - rate).product();
    let wanted = [("1a", passed * (1.0 - planner))];
    for (subject, rate) in wanted.into_iter().chain(counted) {
        let value = finding(study, model, subject)["answer"]["value"].as_f64();
        assert!(
            value.is_some_and(|it| (it - rate).abs() < 2e-9),
            "{subject} of {model}: {value:?} {rate}"
        );
    }
}

/// The study that a folder's last run left.
fn study_of(folder: &Path) -> Value {
    serde_json::from_str(&read(&folder.join("results/study.json"))).expect("JSON")
}

/// The simulation lost the object far too often, and does so less often now.
fn assert_grip_is_mended(study: &Value) {
    let of = |id| count(finding(study, id, "grip_failure"));
    let (before, now) = (of("E2"), of("E2-r1"));
    assert!(
        before.0 * now.1 > 2 * now.0 * before.1,
        "{before:?} {now:?}"
    );
}

#[test]
#[ignore = "simulates 200 episodes; `.ci/run refinement` runs it"]
fn proposals_mend_the_first_model_and_the_untuned_simulation() {
    let Some(library) = library() else { return };
    let folder = at_the_start(&[
        ("ledger.toml", "episodes = 100", "episodes = 60"),
        ("calibration.toml", "rounds = 3", "rounds = 1"),
        (
            "calibration.toml",
            "episodes_per_round = 400",
            "episodes_per_round = 80",
        ),
        (
            "calibration.toml",
            "check_episodes = 300",
            "check_episodes = 20",
        ),
    ]);
    let first = refined(&library, folder.path(), "40");
    let study = study_of(folder.path());
    assert_counted_once(&study, last_model(&first), 0.0);
    assert_grip_is_mended(&study);
}

#[test]
#[ignore = "simulates 2100 episodes; run by hand"]
fn proposals_lead_from_the_first_model_and_the_untuned_simulation_to_the_last_of_both() {
    let Some(library) = library() else { return };
    let folder = at_the_start(&[]);
    // The model gets grip failure and the counted sensors, each read once; the simulation is fitted to the experiments.
    let first = refined(&library, folder.path(), "500");
    assert_counted_once(&study_of(folder.path()), last_model(&first), 0.0);
    // The fitted simulation has shown the planner's failures, which the model gets then.
    let second = refined(&library, folder.path(), "500");
    let last = *made(&second).last().expect("a step");
    let study = study_of(folder.path());
    let (failed, runs) = count(finding(&study, "E2-r1", "runtime_error"));
    assert!(failed > 0, "{failed} of {runs}");
    assert_counted_once(&study, last, failed as f64 / runs as f64);
    assert_grip_is_mended(&study);
    // Both agree with the experiments on what they were set to, and it is called a fit.
    let all = study["comparisons"].as_array().expect("comparisons").iter();
    let of_grip = all.filter(|it| it["subject"]["id"] == "grip_failure" && it["left"] == "E3");
    let fitted: Vec<&Value> = of_grip
        .filter(|it| it["right"] == "E2-r1" || it["right"] == last)
        .collect();
    assert_eq!(fitted.len(), 2);
    for pair in fitted {
        assert_ne!(pair["outcome"], "conflicts", "{pair}");
        assert_eq!(pair["independent"], false, "{pair}");
    }
}
