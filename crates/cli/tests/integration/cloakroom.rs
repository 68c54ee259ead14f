//! The conclusions of the swarm in a cloakroom, as its README draws them: the first models agree with each other and not
//! with the trials, and the last ones agree with trials to which nothing was fitted.
//!
//! Needs `python3`. The physics simulation needs the library, too; without it that test is skipped with a line that says
//! so, except in continuous integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use support::program::corroborate;
use support::simulation::{driven, keep_only, library};
use support::{copy_study, read, root};

/// The evidence that needs no physics.
const WITHOUT_PHYSICS: [&str; 12] = [
    "L1", "T1", "M1", "R1", "C1", "M2", "M3", "L2", "T2", "M4", "R2", "C2",
];

/// A copy of the study, beside a copy of the module that joins its simulation.
fn study() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::TempDir::new().expect("a folder");
    let study = folder.path().join("case-studies/cloakroom");
    copy_study(&root().join("case-studies/cloakroom"), &study);
    copy_study(
        &root().join("integrations/common"),
        &folder.path().join("integrations/common"),
    );
    (folder, study)
}

fn result(study: &Path) -> Value {
    serde_json::from_str(&read(&study.join("results/study.json"))).expect("JSON")
}

/// What a piece of evidence measured of a requirement or a way to fail.
fn measure<'a>(result: &'a Value, evidence: &str, subject: &str) -> &'a Value {
    let pieces = result["evidence"].as_array().expect("evidence");
    let piece = pieces.iter().find(|piece| piece["id"] == evidence);
    let findings = piece.expect("that evidence")["findings"].as_array();
    let findings = findings.expect("findings");
    let finding = findings.iter().find(|it| it["subject"]["id"] == subject);
    &finding.expect("that finding")["measure"]
}

fn counts(result: &Value, evidence: &str, subject: &str) -> (u64, u64) {
    let measure = measure(result, evidence, subject);
    let number = |key: &str| measure[key].as_u64().expect("a count");
    (number("count"), number("trials"))
}

/// What a pair shows; agreement that calibration made is a fit.
fn outcome<'a>(result: &'a Value, pair: (&str, &str), subject: &str) -> &'a str {
    let all = result["comparisons"].as_array().expect("comparisons");
    let of_pair = |it: &&Value| {
        let sides = (it["left"].as_str(), it["right"].as_str());
        sides == (Some(pair.0), Some(pair.1)) || sides == (Some(pair.1), Some(pair.0))
    };
    let mut found = all.iter().filter(of_pair);
    let found = found.find(|it| it["subject"]["id"] == subject);
    let found = found.expect("that comparison");
    let outcome = found["outcome"].as_str().expect("a word");
    let is_fit = outcome == "corroborates" && found["independent"] == false;
    if is_fit { "fits" } else { outcome }
}

#[test]
#[ignore = "solves chains with fast rates for some ten minutes in this profile; run by hand"]
fn the_first_models_agree_with_each_other_and_the_last_with_fresh_trials() {
    let (_folder, study) = study();
    keep_only(&study, &WITHOUT_PHYSICS);
    let said = corroborate(&study, &["run", "."]);
    assert_eq!(said.code, 1, "{said:?}");
    let result = result(&study);
    for (evidence, subject, expected) in [
        ("L1", "brought", (190, 200)),
        ("L1", "share", (196, 200)),
        ("L1", "apart", (200, 200)),
        ("L1", "slow_first", (18, 200)),
        ("L1", "slow_second", (26, 200)),
        ("L2", "brought", (133, 200)),
        ("L2", "share", (169, 200)),
        ("R1", "brought", (76, 120)),
        ("R2", "brought", (81, 120)),
        ("R2", "share", (112, 120)),
        ("T1", "grab", (1597, 37946)),
        ("C1", "grab", (499, 32548)),
    ] {
        assert_eq!(
            counts(&result, evidence, subject),
            expected,
            "{evidence}, {subject}"
        );
    }
    for (model, brought, share) in [
        ("M1", 0.89556, 0.85473),
        ("M2", 0.88178, 0.96011),
        ("M3", 0.90624, 0.97539),
        ("M4", 0.66461, 0.89120),
    ] {
        for (subject, expected) in [("brought", brought), ("share", share)] {
            let answer = &measure(&result, model, subject)["answer"];
            let value = answer["value"].as_f64().expect("a probability");
            assert!(
                (value - expected).abs() < 1e-5,
                "{model}, {subject}: {value}"
            );
            assert_eq!(answer["guarantee"]["kind"], "bounded");
        }
    }
    for (pair, subject, expected) in [
        (("L1", "R1"), "brought", "conflicts"),
        (("M1", "R1"), "brought", "conflicts"),
        (("R1", "M3"), "brought", "conflicts"),
        // Trained on the program of the other.
        (("L1", "M1"), "brought", "fits"),
        (("L1", "M3"), "share", "fits"),
        (("L2", "M4"), "brought", "fits"),
        // Fitted to these very trials, by way of the simulation.
        (("R1", "M4"), "share", "fits"),
        // Nothing was fitted to these.
        (("M4", "R2"), "brought", "corroborates"),
        (("M4", "R2"), "share", "corroborates"),
    ] {
        assert_eq!(
            outcome(&result, pair, subject),
            expected,
            "{pair:?}, {subject}"
        );
    }
    let conclusions = result["conclusions"].as_array().expect("conclusions");
    for (requirement, verdict) in [
        ("brought", "violated"),
        ("share", "satisfied"),
        ("waiting", "satisfied"),
    ] {
        let found = conclusions
            .iter()
            .find(|it| it["requirement"] == requirement);
        let found = found.expect("a conclusion");
        assert_eq!(
            (&found["verdict"], &found["step"]),
            (&verdict.into(), &"system".into()),
            "{requirement}"
        );
    }
    let first = &result["suspects"][0];
    assert_eq!(first["title"], "T1 differs in grab");
}

#[test]
fn the_tables_recordings_and_the_scene_are_what_their_programs_make() {
    let (_folder, study) = study();
    let python = |arguments: &[&str]| {
        let output = Command::new("python3")
            .args(arguments)
            .current_dir(&study)
            .output()
            .expect("python3 runs");
        assert!(output.status.success(), "{output:?}");
        output.stdout
    };
    let made = study.join("made.csv");
    let file = made.to_string_lossy().into_owned();
    for (session, trial) in [("6", "3"), ("15", "2"), ("29", "1")] {
        python(&["reality/trials.py", "trial", session, trial, &file]);
        let kept = format!("recordings/session-{session:0>2}-trial-{trial}.csv");
        assert!(read(&made) == read(&study.join(&kept)), "{kept}");
    }
    let scene = String::from_utf8(python(&["simulation/make_scene.py"])).expect("text");
    assert!(scene == read(&study.join("simulation/scene.toml")));
    // The first lines of the tables are their commands. Those of the changes take a few seconds each.
    for table in ["tables/changes_first.csv", "tables/changes_fitted.csv"] {
        let before = read(&study.join(table));
        let command = before.lines().next().expect("a line");
        let command = command.split('`').nth(1).expect("a command");
        let words: Vec<&str> = command.split(' ').skip(1).collect();
        python(&words);
        assert!(read(&study.join(table)) == before, "{table}");
    }
}

#[test]
fn four_robots_with_a_program_each_are_the_same_each_time() {
    let Some(library) = library() else { return };
    let (_folder, study) = study();
    keep_only(&study, &["H1"]);
    let ledger = study.join("ledger.toml");
    let text = read(&ledger);
    assert!(text.contains("episodes = 40"));
    std::fs::write(&ledger, text.replace("episodes = 40", "episodes = 2")).expect("written");
    for threads in ["1", "2"] {
        let said = driven(
            &library,
            &study,
            &["run", ".", "-j", threads, "--out", threads],
        );
        assert!([0, 1, 3].contains(&said.code), "{said:?}");
    }
    let episodes = |out: &str| -> Vec<Vec<u8>> {
        let folder = study.join(out).join("episodes/H1");
        (1..=2)
            .map(|n| std::fs::read(folder.join(format!("episode-{n:05}.mcap"))))
            .map(|read| read.expect("an episode"))
            .collect()
    };
    assert!(episodes("1") == episodes("2"));
    let result: Value = serde_json::from_str(&read(&study.join("1/study.json"))).expect("JSON");
    assert_eq!(counts(&result, "H1", "brought").1, 2);
    assert_eq!(counts(&result, "H1", "apart").1, 2);
}
