//! Proposals that reach beyond one text: what stands in several files, and the files of a simulator that is a command.

use crate::support;

use serde_json::Value;
use std::path::Path;
use support::program::corroborate;
use support::{copy_study, read, root};

/// The study of two ways to fail with some files changed, run and diagnosed.
fn diagnosed(changes: &[(&str, &str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(
        &root().join("crates/cli/tests/data/two_failures"),
        folder.path(),
    );
    for (file, old, new) in changes {
        let file = folder.path().join(file);
        let text = read(&file);
        assert!(text.contains(old), "no `{old}`");
        std::fs::write(file, text.replacen(old, new, 1)).expect("written");
    }
    suspects(folder.path());
    folder
}

/// The suspects with a score of 1 or more: kind, part, score.
fn suspects(folder: &Path) -> Vec<(String, String, f64)> {
    let run = corroborate(folder, &["run", ".", "--quiet"]);
    assert!([0, 1, 3].contains(&run.code), "{run:?}");
    let words = [
        "diagnose", ".", "--format", "json", "--paths", "100", "--quiet",
    ];
    let said = corroborate(folder, &words);
    let diagnosis: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {said:?}"));
    let all = diagnosis["suspects"].as_array().expect("a list").iter();
    let open = all.filter(|it| it["resolved_by"].is_null());
    let read = open.map(|it| {
        let text = |key: &str| it["asset"][key].as_str().unwrap_or_default().to_owned();
        (
            text("kind"),
            text("part"),
            it["score"].as_f64().expect("a score"),
        )
    });
    read.filter(|(.., score)| *score >= 1.0).collect()
}

fn refined(folder: &Path, words: &[&str]) -> Value {
    let said = corroborate(
        folder,
        &[&["refine", ".", "--format", "json", "--quiet"], words].concat(),
    );
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

#[test]
fn nobody_is_suspected_where_nothing_is_wrong() {
    let folder = diagnosed(&[]);
    assert_eq!(suspects(folder.path()), []);
}

#[test]
fn what_was_exchanged_in_two_tables_is_put_right_in_both() {
    let folder = diagnosed(&[
        (
            "experiments/failures.csv",
            "slip,2,100\ndrop,25,100",
            "slip,25,100\ndrop,2,100",
        ),
        ("experiments/trials.csv", "n_slip,n_drop", "n_drop,n_slip"),
    ]);
    let offered = refined(folder.path(), &[]);
    let first = &offered["proposals"][0];
    assert_eq!(first["file"], "experiments/failures.csv", "{first}");
    assert_eq!(first["also"], serde_json::json!(["experiments/trials.csv"]));
    assert_eq!(first["needs_decision"], true);
    let made = refined(folder.path(), &["--accept", "1"]);
    assert_eq!(made["applied"].as_array().map(Vec::len), Some(2), "{made}");
    let cohort = read(&folder.path().join("experiments/trials.csv"));
    assert!(
        cohort.starts_with("person,ok,attempts,n_slip,n_drop\n"),
        "{cohort}"
    );
    assert_eq!(suspects(folder.path()), []);
}

#[test]
fn a_simulators_number_is_found_by_running_it() {
    let folder = diagnosed(&[("simulation/parameters.txt", "slip 0.02", "slip 0.4")]);
    let offered = refined(folder.path(), &[]);
    let first = &offered["proposals"][0];
    assert_eq!(first["file"], "simulation/parameters.txt", "{first}");
    assert_eq!(first["needs_decision"], true);
    let made = refined(folder.path(), &["--accept", "1"]);
    assert_eq!(made["applied"][0]["entry"], "simulation-r1", "{made}");
    let changed = read(&folder.path().join("simulation/parameters-r1.txt"));
    let slip = changed.lines().find_map(|line| line.strip_prefix("slip "));
    let slip: f64 = slip.expect("the number").parse().expect("a number");
    assert!(slip > 0.001 && slip < 0.1, "{changed}");
    assert!(changed.contains("duration 4\ndrop 0.25\n"), "{changed}");
    let ledger = read(&folder.path().join("ledger.toml"));
    let lineage = "{ parameter = \"slip\", from = \"trials\", failure_mode = \"slip\" }";
    assert!(ledger.contains(lineage), "{ledger}");
    assert_eq!(suspects(folder.path()), []);
}

#[test]
fn who_differs_from_all_others_is_named_and_nothing_is_left_out() {
    let rows = "1,15,20,0,5\n2,14,20,1,5\n3,15,20,0,5\n4,14,20,1,5\n5,15,20,0,5\n";
    let others = "1,18,20,0,2\n2,17,20,1,2\n3,18,20,0,2\n4,17,20,1,2\n5,18,20,0,2\n6,18,20,0,2\n7,2,20,0,18\n8,18,20,0,2\n";
    let folder = diagnosed(&[
        ("experiments/trials.csv", rows, others),
        (
            "experiments/failures.csv",
            "slip,2,100\ndrop,25,100",
            "slip,2,160\ndrop,32,160",
        ),
    ]);
    let found = suspects(folder.path());
    let named = found
        .iter()
        .filter(|(kind, part, _)| kind == "data" && part == "row `7`");
    assert_eq!(named.count(), 1, "{found:?}");
    assert!(read(&folder.path().join("experiments/trials.csv")).contains("7,2,20,0,18"));
}
