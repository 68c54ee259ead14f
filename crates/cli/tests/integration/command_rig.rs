//! A simulator that is a command where benches of ours are asked for, too: rare events, engines, a calibration. Needs
//! `python3`, which it is written in; nothing else.

use crate::support;

use serde_json::Value;
use std::path::Path;
use support::program::{Said, corroborate};
use support::{command_study, read, root, schema};

/// The study with another simulator, in a folder of its own, with one more file.
fn study(file: &str, text: &str) -> tempfile::TempDir {
    let folder = command_study(&[]);
    std::fs::write(folder.path().join(file), text).expect("written");
    folder
}

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

fn holds_to(name: &str, report: &Value) {
    let path = root().join("schemas").join(name);
    let schema: Value = serde_json::from_str(&read(&path)).expect("a schema");
    let violations = schema::violations(&schema, report);
    assert!(violations.is_empty(), "{violations:?}");
}

/// How often the cart is fast: it begins with the speed that is set times a factor from 0.8 to 1.2. A score is in the unit
/// of its recording, here cm/s.
const EVENTS: &str = r#"
evidence = "sim"
test = "straight on"

[[event]]
name = "fast"
meaning = "The cart is faster than 2.15 m/s."
greatest = "/cart.speed"
limit = 215
until_secs = 1.0
particles = 20
killed = 4
replications = 3

[[event.parameter]]
name = "speed"
sets = ["cart.speed_cm_per_s"]
uniform = [100.0, 200.0]
"#;

#[test]
fn rare_events_of_a_command_are_sought_among_inputs() {
    let folder = study("rare.toml", EVENTS);
    let arguments = ["rare", ".", "rare.toml", "--format", "json"];
    let said = corroborate(folder.path(), &arguments);
    assert_eq!(said.code, 0, "{said:?}");
    let report = json(&said);
    holds_to("rare.schema.json", &report);
    let event = &report["events"][0];
    // The product of two uniform numbers, 100 to 200 and 0.8 to 1.2, is above 215 with probability
    // 1 - E[clamp((215 / f - 100) / 100, 0, 1)], f from 0.8 to 1.2: by the midpoint rule.
    let exact: f64 = (0..4000)
        .map(|i| 0.8 + 0.4 * (f64::from(i) + 0.5) / 4000.0)
        .map(|factor| 1.0 - ((215.0 / factor - 100.0) / 100.0).clamp(0.0, 1.0))
        .sum::<f64>()
        / 4000.0;
    let number = |key: &str| event[key].as_f64().expect("a number");
    // Of seeded runs: the interval at 95 % widened by half, lest a right answer fail.
    assert!(
        number("low") / 1.5 < exact && exact < number("high") * 1.5,
        "{exact}: {event}"
    );
    assert!(number("probability") > 0.0 && number("episode_equivalents") > 60.0);
    // What is kept is taken, byte for byte.
    assert_eq!(corroborate(folder.path(), &arguments).out, said.out);
}

#[test]
fn a_command_is_not_split_and_its_test_has_to_be_its_own() {
    let parameters = &EVENTS[EVENTS.find("[[event.parameter]]").expect("parameters")..];
    for (old, new, message) in [
        (parameters, "", "cannot be saved and continued"),
        ("straight on", "straight", "no abstract test `straight`"),
        ("evidence = \"sim\"", "", "neither a scene alone"),
        ("\"sim\"", "\"sin\"", "sin"),
    ] {
        let folder = study("rare.toml", &EVENTS.replace(old, new));
        let said = corroborate(folder.path(), &["rare", ".", "rare.toml"]);
        assert_eq!(said.code, 2, "{new}: {said:?}");
        assert!(said.talk.contains(message), "{message}: {said:?}");
    }
}

#[test]
fn a_command_is_run_again_and_compared_with_itself() {
    let folder = study("unused", "");
    let arguments = [
        "engines",
        ".",
        "sim",
        "-n",
        "2",
        "--determinism",
        "--format",
        "json",
    ];
    let said = corroborate(folder.path(), &arguments);
    assert_eq!(said.code, 0, "{said:?}");
    let report = json(&said);
    holds_to("engines.schema.json", &report);
    let repeated = report["repeated"].as_array().expect("repeated");
    assert_eq!(repeated.len(), 2);
    for episode in repeated {
        assert_eq!(episode["hash"], episode["again"], "{report}");
        assert_eq!(episode["continued"], Value::Null, "{report}");
        assert_eq!(episode["same"], true, "{report}");
    }
    assert_ne!(repeated[0]["hash"], repeated[1]["hash"]);
    let compared = corroborate(folder.path(), &["engines", ".", "sim", "-n", "1"]);
    assert_eq!(compared.code, 2, "{compared:?}");
    assert!(compared.talk.contains("not simulated by this test bench"));
}

/// Its own simulator, fitted to counts on a real floor.
const CALIBRATION: &str = r#"
name = "fitted"
simulator = "sim"
test = "straight on"
evidence = "floor"
fit = ["stops"]
rounds = 2
episodes_per_round = 12
check_episodes = 8

[known]
"cart.speed_cm_per_s" = 120

[[parameter]]
name = "braking"
sets = ["cart.braking_cm_per_s2"]
uniform = [20.0, 120.0]
"#;

const FLOOR: &str = r#"
[[evidence]]
id = "floor"
title = "A cart on a floor"
technique = "experiment"
conditions = "floor"
tables.requirements = "floor.csv"
changed = "Forty trials with a cart."
"#;

fn calibrating(calibration: &str) -> tempfile::TempDir {
    let folder = study("calibration.toml", calibration);
    let counts = "requirement,covered,passed,failed\nstops,40,30,10\n";
    std::fs::write(folder.path().join("floor.csv"), counts).expect("written");
    let ledger = folder.path().join("ledger.toml");
    std::fs::write(&ledger, read(&ledger) + FLOOR).expect("written");
    folder
}

fn calibrate(folder: &Path) -> Said {
    let arguments = [
        "calibrate",
        ".",
        "calibration.toml",
        "--format",
        "json",
        "--to",
        "fitted.toml",
    ];
    corroborate(folder, &arguments)
}

#[test]
fn a_stimulus_of_a_command_is_fitted_and_can_be_run() {
    let folder = calibrating(CALIBRATION);
    let said = calibrate(folder.path());
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let report = json(&said);
    holds_to("calibrate.schema.json", &report);
    assert_eq!(report["episodes"], 24);
    let fitted = read(&folder.path().join("fitted.toml"));
    let stimulus = stimulus::Stimulus::from_toml(&fitted).expect("a stimulus");
    let braking = &report["parameters"][0]["fitted"];
    assert_eq!(
        serde_json::to_value(&stimulus.settings["cart.braking_cm_per_s2"]).expect("a value"),
        *braking
    );
    assert!(fitted.contains("\"cart.speed_cm_per_s\" = 120"), "{fitted}");
    assert!(fitted.contains("from stimulus.toml"), "{fitted}");
    // It is a stimulus that the ledger can name.
    std::fs::write(folder.path().join("stimulus.toml"), fitted).expect("written");
    let arguments = ["simulate", ".", "sim", "-n", "1", "--out", "out"];
    let run = corroborate(folder.path(), &arguments);
    assert!([0, 1, 3].contains(&run.code), "{run:?}");
}

#[test]
fn a_key_that_the_stimulus_does_not_set_is_not_fitted() {
    for (old, new, message) in [
        ("cart.braking_cm_per_s2", "cart.breaking", "cart.breaking"),
        (
            "\"cart.speed_cm_per_s\"",
            "\"cart.sped\"",
            "that could be known",
        ),
        (
            "simulator = \"sim\"",
            "simulator = \"sim\"\nscenario = \"s.toml\"",
            "neither a scenario",
        ),
    ] {
        let folder = calibrating(&CALIBRATION.replace(old, new));
        let said = calibrate(folder.path());
        assert_eq!(said.code, 2, "{new}: {said:?}");
        assert!(said.talk.contains(message), "{message}: {said:?}");
    }
}

/// A brake that is set too weak: which number it is, and its value, is found by running the simulator before anything is
/// accepted; what the counts do not tell apart is said.
#[test]
fn a_wrong_setting_is_offered_with_its_value_once_the_simulator_was_run() {
    let folder = calibrating(CALIBRATION);
    std::fs::remove_file(folder.path().join("calibration.toml")).expect("removed");
    for (file, old, new) in [
        (
            "stimulus.toml",
            "braking_cm_per_s2\" = 60",
            "braking_cm_per_s2\" = 20",
        ),
        ("ledger.toml", "episodes = 40", "episodes = 12"),
        ("floor.csv", "stops,40,30,10", "clear,400,399,1"),
    ] {
        let path = folder.path().join(file);
        let text = read(&path);
        assert!(text.contains(old), "{file} has no `{old}`");
        std::fs::write(&path, text.replace(old, new)).expect("written");
    }
    let arguments = ["refine", ".", "--fit", "--accept", "1", "--format", "json"];
    let said = corroborate(folder.path(), &arguments);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let report = json(&said);
    holds_to("refine.schema.json", &report);
    let offered = &report["proposals"][0];
    let text = |key: &str| offered[key].as_str().expect("a text").to_owned();
    assert!(text("title").starts_with("sim: cart."), "{offered}");
    let diff = text("diff");
    assert!(diff.contains("+++ stimulus-r1.toml"), "{diff}");
    // Both a weak brake and a fast cart come too far, and nothing was counted of either.
    let notes = offered["notes"].to_string();
    let names = ["cart.braking_cm_per_s2", "cart.speed_cm_per_s"];
    let changed = names.map(|name| diff.contains(&format!("+\"{name}\"")));
    assert_eq!(changed.iter().filter(|it| **it).count(), 1, "{diff}");
    let other = if changed[0] { names[1] } else { names[0] };
    assert!(
        notes.contains("does not tell it from") && notes.contains(other),
        "{notes}"
    );
    let repaired = offered["tried"]["repairs"].as_array().expect("repairs");
    assert!(
        repaired.iter().any(|it| it["evidence"] == "floor"),
        "{offered}"
    );
    // What was shown is what is written.
    let kept = read(&folder.path().join("stimulus-r1.toml"));
    let line = diff.lines().find(|it| it.starts_with("+\"cart."));
    assert!(
        line.is_some_and(|line| kept.contains(&line[1..])),
        "{kept}\n{diff}"
    );
    assert!(report["applied"].to_string().contains("sim-r1"), "{report}");
}
