//! Exploring as a user meets it, on a study small enough to know what has to be found: a person who walks, and who is
//! distracted once in ten thousand episodes, which the formal model has never heard of.
//!
//! Needs the physics library. Without it the tests are skipped with a line that says so, except in continuous
//! integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;
use support::program::{Said, command, contents};
use support::simulation::{library, simulating};

const ABOUT: &str = r#"
title = "A person walks"
summary = "A person walks five metres and may be distracted."
seed = 7
confidence = 0.95
agreement = 0.95
[conditions]
typical = "One person, alone."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "attention"
text = "The person is attentive."
shall = "The person shall always satisfy attentive."
margin = 0.05

[[requirement]]
id = "arrival"
text = "Who walks arrives."
shall = "When walking, the person shall eventually satisfy arrived."
margin = 0.05
"#;

const VOCABULARY: &str = r#"
[attentive]
meaning = "The person is not distracted."
model = "!distracted"
trace = "!/truth/anna.distracted"

[walking]
meaning = "The person walks."
model = "place>0"
trace = "/truth/anna.speed > 0.1 m/s"

[arrived]
meaning = "The person is there."
model = "place=2"
trace = "/truth/anna.arrived"
"#;

const LEDGER: &str = r#"
[[evidence]]
id = "model"
title = "Formal model"
technique = "model-checking"
conditions = "typical"
model = "walk.prism"
changed = "First."

[[evidence]]
id = "bench"
title = "Simulation"
technique = "simulation"
conditions = "typical"
scene = "scene.toml"
episodes = 10
changed = "First."
"#;

const MODEL: &str = r#"
dtmc
const double pDistracted = 0;
module person
  chosen : bool init false;
  distracted : bool init false;
  place : [0..2] init 0;
  [] !chosen -> pDistracted : (chosen'=true) & (distracted'=true) + 1-pDistracted : (chosen'=true);
  [walk] chosen & place=0 -> (place'=1);
  [] chosen & place=1 -> (place'=2);
  [] place=2 -> true;
endmodule
"#;

const SCENE: &str = r#"
name = "a person walks"
simulation = { duration_secs = 6.0, record_hz = 20 }
ground = { friction = 0.8 }

[[person]]
name = "anna"
x_m = 0.0
y_m = 0.0
activity = "stand"
speed_m_s = 1.2
distracted_probability = 0.0001
waypoint = [{ x_m = 2.0, y_m = 0.0 }]

[[abstract_test]]
name = "walk"
actions = [{ set_param = { "anna.activity" = "walk" }, after_secs = 0.5 }]
"#;

const EXPLORATION: &str = r#"
evidence = "bench"
model = "model"

[budget]
episodes = 60
batch = 10

[abstraction]
steps = 2
[[abstraction.proposition]]
name = "arrived"
[[abstraction.proposition]]
name = "distracted"
model = "distracted"
trace = "!attentive"

[[goal]]
name = "the person is there"
model = "place=2"

[[step]]
action = "walk"
set_param = { "anna.activity" = "walk" }
after_secs = { uniform = [0.0, 1.0] }

[grammar]
name = "random"
length = [1, 3]
[[grammar.action]]
set_param = { "anna.activity" = ["walk", "stand"] }
after_secs = { uniform = [0.0, 3.0] }

[[parameter]]
name = "speed"
sets = ["person.anna.speed_m_s"]
unit = "m/s"
uniform = [0.4, 1.8]
nominal = 1.2

[[situation]]
name = "speed"
parameter = "speed"
edges = [0.4, 0.9, 1.3, 1.8]
[[situation]]
name = "there"
proposition = "arrived"
[[situation]]
name = "stands"
action = "set anna.activity=stand"
[[cross]]
name = "walks"
of = ["speed", "there", "stands"]

[[search]]
requirement = "arrival"
test = "walk"
method = "cma-es"

[disagreement]
requirement = "attention"
test = "walk"
episodes = 400
[[disagreement.constant]]
name = "pDistracted"
parameter = "distraction"
factor = 1.0
[[disagreement.parameter]]
name = "distraction"
sets = ["person.anna.distracted_probability"]
choice = [0.0, 0.25, 0.5]
nominal = 0.0
"#;

/// The study, with changes in how it is explored.
fn study(changes: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    let mut exploration = EXPLORATION.to_owned();
    for (old, new) in changes {
        assert!(exploration.contains(old), "{old}");
        exploration = exploration.replace(old, new);
    }
    let files = [
        ("study.toml", ABOUT),
        ("requirements.toml", REQUIREMENTS),
        ("vocabulary.toml", VOCABULARY),
        ("ledger.toml", LEDGER),
        ("walk.prism", MODEL),
        ("scene.toml", SCENE),
        ("exploration.toml", &exploration),
    ];
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

fn explore(library: &Path, folder: &Path, more: &[&str]) -> Said {
    let mut arguments = vec!["explore", ".", "exploration.toml"];
    if !more.contains(&"--out") {
        arguments.extend(["--out", "out"]);
    }
    arguments.extend(more);
    simulating(library, folder, &arguments)
}

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

fn report(library: &Path, folder: &Path, more: &[&str]) -> Value {
    let said = explore(library, folder, &[&["--format", "json"], more].concat());
    assert_eq!(said.code, 1, "{said:?}");
    json(&said)
}

/// The finding whose words are these.
fn finding<'r>(report: &'r Value, words: &str) -> Option<&'r Value> {
    let mut findings = report["findings"].as_array().expect("findings").iter();
    findings.find(|finding| finding["in_words"] == words)
}

#[test]
fn what_is_declared_to_fail_once_in_ten_thousand_is_met_within_a_few_episodes_and_is_unknown_to_the_model()
 {
    let Some(library) = library() else { return };
    let folder = study(&[]);
    let explored = report(&library, folder.path(), &[]);
    let violated = finding(&explored, "requirement attention is violated").expect("found");
    let first = violated["first_episode"].as_u64().expect("a number");
    assert!(first <= 3, "{violated}");
    assert_eq!(violated["replayed"], true, "{violated}");
    let by = "fault injection: person.anna.distracted_probability = 1";
    assert_eq!(violated["found_by"], by);
    assert!(
        finding(
            &explored,
            "unknown behaviour: {distracted} to {arrived distracted}"
        )
        .is_some()
    );
    let file = folder
        .path()
        .join("out")
        .join(violated["file"].as_str().expect("a file"));
    let file = std::fs::read_to_string(file).expect("the finding");
    assert!(
        file.contains("\"person.anna.distracted_probability\" = 1\n"),
        "{file}"
    );
    // The same number of the bench's own episodes does not show it.
    let plain = explore(
        &library,
        folder.path(),
        &["--plain", "--out", "plain", "--format", "json"],
    );
    assert_eq!(plain.code, 0, "{plain:?}");
}

#[test]
fn goals_and_triggers_of_the_model_become_tests_and_the_rest_has_its_reason() {
    let Some(library) = library() else { return };
    let folder = study(&[]);
    let explored = report(&library, folder.path(), &[]);
    let tests = explored["model_tests"]["tests"].as_array().expect("tests");
    let goals: Vec<&str> = tests
        .iter()
        .flat_map(|test| test["goals"].as_array().expect("goals"))
        .map(|goal| goal.as_str().expect("a text"))
        .collect();
    assert!(goals.contains(&"the person is there"), "{goals:?}");
    assert!(goals.contains(&"trigger of arrival: walking"), "{goals:?}");
    let without = explored["model_tests"]["without"].to_string();
    assert!(without.contains("the model begins there"), "{without}");
    // Every source that the file has data for was used.
    let sources: BTreeMap<&str, u64> = explored["sources"]
        .as_array()
        .expect("sources")
        .iter()
        .map(|s| {
            (
                s["source"].as_str().expect("a name"),
                s["episodes"].as_u64().expect("a count"),
            )
        })
        .collect();
    for name in [
        "own tests",
        "model: goals",
        "fault injection",
        "random tests",
        "mutation",
        "search",
    ] {
        assert!(
            sources.get(name).is_some_and(|episodes| *episodes > 0),
            "{name}: {sources:?}"
        );
    }
    assert_eq!(sources.values().sum::<u64>(), 60);
}

#[test]
fn a_search_is_guided_by_time_and_says_when_it_cannot_see() {
    let Some(library) = library() else { return };
    // Without a deadline all walks that arrive are as good; who stands never comes to it.
    let blind = study(&[("test = \"walk\"\nmethod", "test = \"stay\"\nmethod")]);
    let scene = blind.path().join("scene.toml");
    let stays = "[[abstract_test]]\nname = \"stay\"\nactions = []\n";
    std::fs::write(&scene, format!("{SCENE}{stays}")).expect("written");
    let search = ["--source", "search", "-n", "20"];
    let said = explore(&library, blind.path(), &search);
    // Standing still is behaviour that the model does not have.
    assert_eq!(said.code, 1, "{said:?}");
    let warned = "the search against requirement arrival cannot see: in its first 10 episodes the requirement never came up";
    assert!(said.talk.contains(warned), "{said:?}");
    assert!(said.out.contains(warned), "{said:?}");

    // With one the time that is left leads to the slowest walk, which does not keep it.
    let seeing = study(&[("cma-es", "bayesian")]);
    let requirements =
        REQUIREMENTS.replace("eventually satisfy arrived", "within 4 s satisfy arrived");
    std::fs::write(seeing.path().join("requirements.toml"), requirements).expect("written");
    let found = report(&library, seeing.path(), &search);
    let search = &found["searches"][0];
    assert_eq!(search["blind"], Value::Null, "{search}");
    assert_eq!(search["with_robustness"], 20, "{search}");
    assert!(number(&search["least_robustness"]) < 0.0, "{search}");
    assert!(finding(&found, "requirement arrival is violated").is_some());
}

#[test]
fn what_is_covered_is_counted_and_holes_are_named() {
    let Some(library) = library() else { return };
    let folder = study(&[]);
    let coverage = &report(&library, folder.path(), &[])["coverage"];
    assert_eq!(coverage["triggers"]["total"], 2);
    assert_eq!(coverage["triggers"]["covered"], 2);
    let cross = &coverage["crosses"][0];
    assert_eq!(cross["total"], 12);
    let two = [
        "-n", "2", "--source", "own", "--out", "few", "--format", "json",
    ];
    let few = json(&explore(&library, folder.path(), &two));
    let few = &few["coverage"]["crosses"][0];
    assert!(
        few["covered"].as_u64() < cross["covered"].as_u64(),
        "{few} {cross}"
    );
    assert!(few["holes"].to_string().contains("stands=yes"), "{few}");
}

#[test]
fn the_result_does_not_depend_on_the_number_of_threads() {
    let Some(library) = library() else { return };
    let folder = study(&[]);
    for threads in ["1", "2"] {
        report(&library, folder.path(), &["-j", threads, "--out", threads]);
    }
    let of = |threads: &str| results(&folder.path().join(threads));
    assert!(of("1").len() > 3);
    assert!(of("1") == of("2"));
}

/// All results with their names: everything but the journal, whose lines come in the order in which episodes end.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = contents(folder).into_iter();
    let named = files.map(|(path, bytes)| {
        let name = path
            .strip_prefix(folder)
            .expect("inside")
            .display()
            .to_string();
        (name, bytes)
    });
    named.filter(|(name, _)| name != "journal").collect()
}

fn journal_lines(folder: &Path) -> usize {
    let text = std::fs::read(folder.join("journal")).unwrap_or_default();
    text.iter().filter(|byte| **byte == b'\n').count()
}

#[test]
fn an_exploration_that_is_killed_goes_on_without_repeating_an_episode() {
    let Some(library) = library() else { return };
    let folder = study(&[]);
    report(&library, folder.path(), &["--out", "whole"]);
    let mut killed = 0;
    for enough in [2, 15, 40] {
        let arguments = [
            "explore",
            ".",
            "exploration.toml",
            "--out",
            "out",
            "-j",
            "2",
        ];
        let mut child = command(folder.path(), &arguments)
            .env("CORROBORATE_MUJOCO", &library)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("it starts");
        let out = folder.path().join("out");
        while journal_lines(&out) < enough && child.try_wait().expect("a state").is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        killed += usize::from(child.try_wait().expect("a state").is_none());
        child.kill().expect("killed");
        child.wait().expect("ended");
    }
    assert!(killed > 0, "every call ended before it could be killed");
    report(&library, folder.path(), &[]);
    let out = folder.path().join("out");
    assert!(results(&out) == results(&folder.path().join("whole")));
    // A line for what looked at them, and one for each episode.
    assert_eq!(journal_lines(&out), 61);
    // Its lines may be put in order, and none is added.
    let lines = || {
        let text = std::fs::read_to_string(out.join("journal")).expect("the journal");
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines
    };
    let before = lines();
    report(&library, folder.path(), &[]);
    assert!(lines() == before);
}

#[test]
fn a_planted_disagreement_is_found_and_none_where_there_is_none() {
    let Some(library) = library() else { return };
    let agreeing = study(&[]);
    let search = ["--disagreement", "--format", "json"];
    let said = explore(&library, agreeing.path(), &search);
    assert!(said.code == 0 || said.code == 3, "{said:?}");
    let found = json(&said);
    let regions = found["regions"].as_array().expect("regions");
    let differs = |region: &&Value| region["decided"] == "differs";
    assert_eq!(regions.iter().find(differs), None, "{found}");
    // The model follows the context, whose mean is 0.25: that is why it agrees.
    if let [whole] = &regions[..] {
        assert!((number(&whole["predicted"]) - 0.75).abs() < 0.02, "{found}");
    }
    // What was run is in the journal, so that the same comes again at once.
    let kept = std::fs::read_to_string(agreeing.path().join("out/disagreement.json"));
    let again = explore(&library, agreeing.path(), &search);
    assert_eq!((again.code, &again.out), (said.code, &said.out));
    assert_eq!(kept.expect("written").trim_end(), again.out.trim_end());

    let planted = study(&[("factor = 1.0", "factor = 0.0")]);
    let said = explore(&library, planted.path(), &search);
    assert_eq!(said.code, 1, "{said:?}");
    let found = json(&said);
    let worst = &found["regions"][0];
    assert_eq!(worst["decided"], "differs", "{found}");
    assert_eq!(worst["predicted"], 1.0, "{found}");
    assert!(number(&worst["high"]) < 0.95, "{found}");
    assert!(number(&worst["ranges"][0]["high"]) > 0.0, "{found}");
    let shares = &found["shares"];
    let all: f64 = ["differs", "undecided", "agrees"]
        .iter()
        .map(|kind| number(&shares[kind]))
        .sum();
    assert!((all - 1.0).abs() < 1e-9, "{found}");
}

/// What `verify` says of the results: its exit code, faults, what holds and what was not derived again.
fn verified(library: &Path, folder: &Path, more: &[&str]) -> (i32, Value) {
    let arguments = [&["verify", "results", "--format", "json"], more].concat();
    let said = simulating(library, folder, &arguments);
    (said.code, json(&said))
}

fn says(report: &Value, list: &str, words: &str) -> bool {
    let list = report[list].as_array().expect("a list").iter();
    list.clone().any(|it| it.to_string().contains(words))
}

#[test]
fn a_map_of_disagreement_follows_from_its_journal_and_from_running_its_episodes_again() {
    let Some(library) = library() else { return };
    let folder = study(&[("episodes = 400", "episodes = 60")]);
    let search = [
        "--disagreement",
        "--out",
        "results/exploration",
        "--seed",
        "11",
    ];
    let said = explore(&library, folder.path(), &search);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let run = || simulating(&library, folder.path(), &["run", "."]);
    let said = run();
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    for (more, from) in [
        (&[][..], "the journal of its episodes"),
        (&["--deep"], "running its episodes again"),
    ] {
        let (code, report) = verified(&library, folder.path(), more);
        assert_eq!(code, 0, "{report}");
        assert!(says(&report, "checked", from), "{report}");
    }
    // A count of the map is changed, and all that is drawn from it with it.
    let path = folder.path().join("results/exploration/disagreement.json");
    let text = std::fs::read_to_string(&path).expect("the map");
    let mut map: Value = serde_json::from_str(&text).expect("JSON");
    let successes = map["regions"][0]["successes"].as_u64().expect("a count");
    map["regions"][0]["successes"] = (successes - 1).into();
    std::fs::write(&path, serde_json::to_string_pretty(&map).expect("JSON")).expect("written");
    run();
    let (code, report) = verified(&library, folder.path(), &[]);
    assert_eq!(code, 1, "{report}");
    assert!(says(&report, "faults", "/regions/0/successes"), "{report}");
    std::fs::write(&path, &text).expect("written");
    run();
    // Without the journal's last line the search ends sooner than the map says; without it nothing is derived.
    let journal = folder
        .path()
        .join("results/exploration/disagreement/journal");
    let lines = std::fs::read_to_string(&journal).expect("the journal");
    let cut = lines.trim_end().rfind('\n').expect("lines") + 1;
    std::fs::write(&journal, &lines[..cut]).expect("written");
    let (code, report) = verified(&library, folder.path(), &[]);
    assert_eq!(code, 1, "{report}");
    assert!(says(&report, "faults", "/ended"), "{report}");
    std::fs::remove_file(&journal).expect("removed");
    let (code, report) = verified(&library, folder.path(), &[]);
    assert_eq!(code, 0, "{report}");
    assert!(says(&report, "not_checked", "no journal"), "{report}");
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("no number: {value}"))
}

#[test]
fn mistakes_are_told_with_their_place_before_anything_runs() {
    let Some(library) = library() else { return };
    let mistakes = [
        (
            ("name = \"speed\"\nsets", "name = \"sped\"\nsets"),
            "there is no [[parameter]] `speed`",
        ),
        (("method = \"cma-es\"", "method = \"cmaes\""), "cmaes"),
        (
            ("evidence = \"bench\"", "evidence = \"model\""),
            "not a simulation that takes tests",
        ),
        (
            ("model = \"model\"", "model = \"bench\""),
            "not a formal model",
        ),
        (("episodes = 60", "episodes = 0"), "at least one episode"),
        (("model = \"place=2\"", "model = \"place=\""), "expected"),
        (
            (
                "[grammar]",
                "[[fault]]\nkey = \"person.ana.speed_m_s\"\nvalues = [9.0]\n[grammar]",
            ),
            "did you mean `anna`",
        ),
        (
            (
                "person.anna.speed_m_s\"]\nunit",
                "person.anna.sped_m_s\"]\nunit",
            ),
            "exploration.toml:36:",
        ),
        (
            ("unit = \"m/s\"", "unit = \"km/h\""),
            "give its numbers in m/s",
        ),
        (("unit = \"m/s\"", "unit = \"kg\""), "correct `unit`"),
        (
            ("requirement = \"arrival\"", "requirement = \"arival\""),
            "did you mean `arrival`",
        ),
    ];
    for ((old, new), expected) in mistakes {
        let folder = study(&[(old, new)]);
        let said = explore(&library, folder.path(), &[]);
        assert_eq!(said.code, 2, "{old} -> {new}: {said:?}");
        assert!(said.talk.contains(expected), "{new}: {said:?}");
        assert_eq!(said.out, "", "{said:?}");
    }
}
