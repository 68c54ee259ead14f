//! `corroborate shrink` on the handover: the cause is named and not left to the seed, episodes of an evidence are taken by
//! their numbers, and the budget is kept.
//!
//! Needs the physics library. Without it the tests are skipped with a line that says so, except in continuous integration,
//! where nothing is skipped.

use crate::support;

use serde_json::Value;
use std::path::Path;
use support::program::{Said, contents};
use support::simulation::{handover, library, simulating};

/// The handover in a folder of its own.
fn study() -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    let from = handover();
    for (path, bytes) in contents(&from) {
        let name = path.strip_prefix(&from).expect("inside");
        if !name.starts_with("results") && !name.starts_with("recordings") {
            let to = folder.path().join(name);
            std::fs::create_dir_all(to.parent().expect("a folder")).expect("made");
            std::fs::write(to, bytes).expect("written");
        }
    }
    folder
}

fn json(said: &Said) -> Value {
    assert_eq!(said.code, 0, "{said:?}");
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

/// A finding of a grip that fails, of which nothing is set: its seed draws a friction of 0.3167.
const GRIP: &str = r#"
format = "1.0"
found_by = "own tests"
program = "0.1.0"
seed = "9309717024207723383"

[bench]
evidence = "E2"
scenario = "simulation/scenario.toml"
parameters = "simulation/untuned.toml"

[shows]
failure_mode = "grip_failure"

[test]
name = "human looks away"
actions = [
  { send_signal = "activate" },
]

[settings]
"#;

fn shrink(library: &Path, folder: &Path, more: &[&str]) -> Said {
    let mut arguments = vec!["shrink", "."];
    arguments.extend(more);
    simulating(library, folder, &arguments)
}

#[test]
fn what_the_seed_drew_is_set_and_the_cause_is_named() {
    let Some(library) = library() else { return };
    let folder = study();
    std::fs::write(folder.path().join("grip.toml"), GRIP).expect("written");
    let arguments = ["grip.toml", "--format", "json"];
    let report = json(&shrink(&library, folder.path(), &arguments));
    assert_eq!(report["not_pinned"], Value::Null, "{report}");
    assert!(report["pinned"].as_u64() >= Some(8), "{report}");
    let causes = report["causes"].as_array().expect("causes");
    let keys: Vec<&str> = causes.iter().filter_map(|it| it["key"].as_str()).collect();
    assert_eq!(keys, ["parameters.hand.friction"], "{report}");
    let friction = causes[0]["value"].as_str().expect("text");
    let friction: f64 = friction.parse().expect("a number");
    assert!((0.28..0.6).contains(&friction), "{friction}");
    assert_eq!(causes[0]["nominal"], "0.6");
    assert_eq!(report["is_minimal"], true);

    // What is left shows it, and it is the friction that does: nominal, it shows no more.
    let file = folder.path().join("regressions/grip.toml");
    let text = std::fs::read_to_string(&file).expect("a regression");
    assert!(
        text.contains("all other parameters are at their nominal values"),
        "{text}"
    );
    let replay = |name: &str| {
        let said = simulating(
            &library,
            folder.path(),
            &["replay", ".", name, "--format", "json"],
        );
        let report: Value = serde_json::from_str(&said.out).expect("JSON");
        (said.code, report["shown"].as_bool())
    };
    assert_eq!(replay("regressions/grip.toml"), (0, Some(true)));
    let mut nominal: toml::Table = toml::from_str(&text).expect("TOML");
    nominal["settings"]["parameters.hand.friction"] = toml::Value::Float(0.6);
    std::fs::write(folder.path().join("nominal.toml"), nominal.to_string()).expect("written");
    assert_eq!(replay("nominal.toml"), (1, Some(false)));
}

#[test]
fn no_more_episodes_are_run_than_the_budget_allows() {
    let Some(library) = library() else { return };
    let folder = study();
    std::fs::write(folder.path().join("grip.toml"), GRIP).expect("written");
    for budget in [1, 2, 5] {
        let (budget, name) = (budget.to_string(), format!("grip-{budget}"));
        let arguments = [
            "grip.toml",
            "--budget",
            &budget,
            "--name",
            &name,
            "--format",
            "json",
        ];
        let report = json(&shrink(&library, folder.path(), &arguments));
        let episodes = report["episodes"].as_u64().expect("a number");
        assert!(
            episodes <= budget.parse().expect("a number"),
            "{budget}: {report}"
        );
        assert_eq!(report["is_minimal"], false, "{report}");
        let regression = format!("regressions/{name}.toml");
        let replayed = simulating(&library, folder.path(), &["replay", ".", &regression]);
        assert_eq!(replayed.code, 0, "{budget}: {replayed:?}");
        assert!(
            replayed.out.contains("same, bit for bit"),
            "{budget}: {replayed:?}"
        );
    }
    let text = shrink(
        &library,
        folder.path(),
        &["grip.toml", "--budget", "1", "--name", "one"],
    )
    .out;
    assert!(text.contains("the budget does not allow it"), "{text}");
    assert!(!text.contains("-0.00 s"), "{text}");
}

#[test]
fn an_episode_of_an_evidence_is_shrunk_by_its_number() {
    let Some(library) = library() else { return };
    let folder = study();
    let simulated = simulating(
        &library,
        folder.path(),
        &[
            "simulate",
            ".",
            "E2",
            "-n",
            "8",
            "--keep",
            "violations",
            "--out",
            "out",
            "--format",
            "json",
        ],
    );
    // What eight episodes show of one in twenty is no matter here.
    assert!([1, 3].contains(&simulated.code), "{simulated:?}");
    let found: Value = serde_json::from_str(&simulated.out).expect("JSON");
    let first = found["recordings"][0]["file"]
        .as_str()
        .expect("one is kept")
        .to_owned();
    let number: u64 = first
        .trim_start_matches("out/episode-")
        .trim_end_matches(".mcap")
        .parse()
        .expect("a number");
    let episode = format!("E2:{number}");
    // Which of several things is meant has to be said.
    let said = shrink(&library, folder.path(), &[&episode, "--budget", "1"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("several-shown"), "{}", said.talk);
    let choice = said.talk.split("--only ").nth(1).expect("a remedy");
    let id = choice.split_whitespace().next().expect("an identifier");
    let arguments = [&episode, "--only", id, "--budget", "12", "--format", "json"];
    let report = json(&shrink(&library, folder.path(), &arguments));
    assert!(report["after"]["actions"].as_u64() <= report["before"]["actions"].as_u64());
    assert!(
        report["file"]
            .as_str()
            .expect("a file")
            .contains(&format!("E2-{number}-{id}"))
    );
    assert!(report["episodes"].as_u64() <= Some(12), "{report}");

    for (arguments, reason) in [
        (&["E2:0"][..], "the number of an episode must be"),
        (&["E99:1"], "E99"),
        (&[&episode, "--only", "no-such"], "does not declare"),
        (&["nothing"], "no finding"),
    ] {
        let said = shrink(&library, folder.path(), arguments);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{said:?}");
        assert!(said.talk.contains(reason), "{}", said.talk);
    }
}
