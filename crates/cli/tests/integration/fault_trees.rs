//! A lift's brake as a fault tree, beside trials of the lift: what it computes, what it is compared with, who is suspected,
//! when it is stale, and what is refused.

use crate::support;

use serde_json::Value;
use stats::{BetaPosterior, Sample};
use support::program::{Said, corroborate};
use tempfile::TempDir;

const STUDY: &str = "title = \"A lift's brake\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
                     [conditions]\nladen = \"any\"\n";

const REQUIREMENTS: &str = "[[requirement]]\nid = \"1\"\ntext = \"The lift shall stop.\"\nmargin = 0.05\n\
                            threshold = \"at least 0.9\"\n\
                            [[failure_mode]]\nid = \"slip\"\nname = \"Slip\"\nmeaning = \"A lining slips.\"\nmargin = 0.05\n";

/// It does not stop if its valve sticks (1 %) or both linings slip (20 % each): 1 - 0.99 * 0.96 = 0.0496.
const TREE: &str = "toplevel \"no stop\";\n\"no stop\" or \"valve\" \"linings\";\n\"linings\" and \"left\" \"right\";\n\
                    \"valve\" prob=0.01;\n\"left\" prob=0.2;\n\"right\" prob=0.2;\n";

const TABLES: &str = "[[evidence]]\nid = \"X\"\ntitle = \"trials\"\ntechnique = \"experiment\"\nconditions = \"laden\"\n\
                      tables.requirements = \"r.csv\"\ntables.failure_modes = \"f.csv\"\nchanged = \"c\"\n";

const ENTRY: &str = "[[evidence]]\nid = \"T\"\ntitle = \"brake\"\ntechnique = \"fault-tree\"\nconditions = \"laden\"\n\
                     tree = \"brake.dft\"\nevents = { \"1\" = \"no stop\", slip = \"left\" }\nchanged = \"c\"\n";

struct Lift(TempDir);

impl Lift {
    /// The lift stopped in so many of 400 trials.
    fn new(stopped: u64) -> Self {
        let lift = Self(TempDir::new().expect("a folder"));
        let table = format!(
            "requirement,covered,passed,failed\n1,400,{stopped},{}\n",
            400 - stopped
        );
        lift.write("study.toml", STUDY)
            .write("requirements.toml", REQUIREMENTS)
            .write("vocabulary.toml", "")
            .write("ledger.toml", &format!("{TABLES}{ENTRY}"))
            .write("brake.dft", TREE)
            .write("r.csv", &table)
            .write("f.csv", "mode,occurrences,opportunities\nslip,20,100\n")
    }

    fn write(self, name: &str, text: &str) -> Self {
        std::fs::write(self.0.path().join(name), text).expect("written");
        self
    }

    fn call(&self, arguments: &[&str]) -> Said {
        corroborate(self.0.path(), arguments)
    }

    fn result(&self) -> Value {
        let said = self.call(&["run", ".", "--format", "json"]);
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
    }

    fn is_refused_with(&self, parts: &[&str]) {
        let said = self.call(&["run", "."]);
        assert_eq!(said.code, 2, "{said:?}");
        for part in parts {
            assert!(said.talk.contains(part), "{part}: {}", said.talk);
        }
    }
}

fn tree_of(result: &Value) -> &Value {
    let all = result["evidence"].as_array().expect("evidence");
    all.iter().find(|it| it["id"] == "T").expect("the tree")
}

/// The pair of the tree and the trials on a subject.
fn pair<'r>(result: &'r Value, id: &str) -> &'r Value {
    let all = result["comparisons"].as_array().expect("comparisons");
    let found = all.iter().find(|it| it["subject"]["id"] == id);
    found.expect("a pair")
}

#[test]
fn a_tree_is_evidence_for_the_model_and_agrees_with_the_trials() {
    let lift = Lift::new(380);
    let result = lift.result();
    let tree = tree_of(&result);
    let rate = &tree["findings"][0]["measure"]["answer"];
    assert_eq!(rate["guarantee"]["kind"], "exact", "{rate}");
    assert_eq!(rate["guarantee"]["rational"], "594/625", "{rate}");
    assert!((rate["value"].as_f64().expect("a value") - 0.9504).abs() < 1e-15);
    let slip = &tree["findings"][1]["measure"]["answer"];
    assert_eq!(slip["guarantee"]["rational"], "1/5", "{slip}");
    let settings = tree["tool"]["settings"].as_str().expect("settings");
    assert!(
        settings.contains("2 minimal cut sets, the smallest valve, left and right"),
        "{settings}"
    );
    let stops = pair(&result, "1");
    assert_eq!(stops["outcome"], "corroborates", "{stops}");
    // A lining was looked at in 100 of the trials, and the tree speaks of all.
    let slips = pair(&result, "slip");
    assert_eq!(slips["outcome"], "not-comparable", "{slips}");
    let conclusion = &result["conclusions"][0];
    assert_eq!(conclusion["verdict"], "satisfied");
    assert_eq!(conclusion["step"], "system");
    let text = lift.call(&["report", "."]).out.replace('\u{a0}', " ");
    let text: Vec<&str> = text.split_whitespace().collect();
    let text = text.join(" ");
    assert!(text.contains("Fault trees"), "{text}");
    assert!(text.contains("For the model: T: computed 95 %"), "{text}");

    // By itself it decides nothing of the system.
    let alone = Lift::new(380).write("ledger.toml", ENTRY);
    let said = alone.call(&["run", "."]);
    assert_eq!(said.code, 3, "{said:?}");
    assert_eq!(alone.result()["conclusions"][0]["step"], "model");
}

#[test]
fn trials_that_contradict_the_tree_make_its_file_a_suspect() {
    let lift = Lift::new(320);
    let result = lift.result();
    assert_eq!(
        pair(&result, "1")["outcome"],
        "conflicts",
        "{}",
        pair(&result, "1")
    );
    let said = lift.call(&["diagnose", ".", "--format", "json"]);
    let found: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|it| panic!("{it}: {said:?}"));
    let suspects = found["suspects"].as_array().expect("suspects");
    let files: Vec<&str> = suspects
        .iter()
        .filter_map(|it| it["asset"]["file"].as_str())
        .collect();
    assert!(files.contains(&"brake.dft"), "{suspects:?}");
    let forms = suspects
        .iter()
        .filter(|it| it["inaccuracy"] == "requirement-model");
    assert_eq!(forms.count(), 0, "a tree asks no property: {suspects:?}");
}

#[test]
fn a_tree_over_all_runs_is_not_compared_with_trials_of_which_some_do_not_trigger_it() {
    let cohort: String = (1..=50).map(|it| format!("{it},10\n")).collect();
    let ledger = |triggered: &str| {
        let tables = TABLES.replace(
            "tables.requirements",
            "tables.cohort = \"a.csv\"\ntables.requirements",
        );
        format!("{tables}{ENTRY}{triggered}\n")
    };
    let compared = |triggered: &str| {
        let lift = Lift::new(380).write("ledger.toml", &ledger(triggered));
        let lift = lift.write("a.csv", &format!("session,attempts\n{cohort}"));
        let result = lift.result();
        let pair = pair(&result, "1");
        let reason = pair["reason"].as_str().expect("a reason").to_owned();
        (pair["outcome"].clone(), reason)
    };
    let (outcome, reason) = compared("");
    assert_eq!(outcome, "not-comparable", "{reason}");
    assert!(reason.contains("`triggered = true`"), "{reason}");
    let (outcome, reason) = compared("triggered = true");
    assert_ne!(outcome, "not-comparable", "{reason}");
}

/// Of an event that is a basic one the distribution is known: the posterior of its counts.
#[test]
fn counts_behind_a_basic_event_are_carried_on_and_make_the_agreement_a_fit() {
    let calibrated =
        "[[evidence.calibrated]]\nconstant = \"left\"\nfrom = \"X\"\nfailure_mode = \"slip\"\n";
    let lift = Lift::new(380).write("ledger.toml", &format!("{TABLES}{ENTRY}{calibrated}"));
    let result = lift.result();
    let tree = tree_of(&result);
    let credible = &tree["findings"][1]["measure"]["credible"];
    let counts = Sample {
        successes: 20,
        trials: 100,
    };
    let posterior = BetaPosterior::jeffreys(counts);
    for (end, place) in [("low", 0.025), ("high", 0.975)] {
        let found = credible["interval"][end].as_f64().expect("an end");
        let expected = posterior.quantile(place);
        assert!((found - expected).abs() < 2e-3, "{end}: {found} {expected}");
    }
    // The valve is certain, so all that is uncertain of the top comes from this lining: 0.99 (1 - 0.2 p).
    let top = &tree["findings"][0]["measure"]["credible"];
    let low = top["interval"]["low"].as_f64().expect("an end");
    let expected = 0.99 * (1.0 - 0.2 * posterior.quantile(0.975));
    assert!((low - expected).abs() < 5e-4, "{low} {expected}");
    assert_eq!(
        pair(&result, "slip")["independent"],
        false,
        "{}",
        pair(&result, "slip")
    );

    // Both linings of one kind have one unknown rate: 0.99 (1 - p^2).
    let second = calibrated.replace("left", "right");
    let twins = Lift::new(380).write(
        "ledger.toml",
        &format!("{TABLES}{ENTRY}{calibrated}{second}"),
    );
    let result = twins.result();
    let low = tree_of(&result)["findings"][0]["measure"]["credible"]["interval"]["low"].clone();
    let expected = 0.99 * (1.0 - posterior.quantile(0.975).powi(2));
    let low = low.as_f64().expect("an end");
    assert!((low - expected).abs() < 1e-3, "{low} {expected}");

    let other = Lift::new(380)
        .write("ledger.toml", &format!("{TABLES}{ENTRY}{calibrated}"))
        .write(
            "brake.dft",
            &TREE.replace("\"left\" prob=0.2", "\"left\" prob=0.3"),
        );
    other.is_refused_with(&[
        "error[bad-calibration]",
        "20/100",
        "probability 0.2 in brake.dft",
    ]);
    let unknown = calibrated.replace("left", "lift");
    let unknown = Lift::new(380).write("ledger.toml", &format!("{TABLES}{ENTRY}{unknown}"));
    unknown.is_refused_with(&["error[unknown-constant]", "did you mean `left`?"]);
}

#[test]
fn a_tree_is_fresh_until_its_file_or_its_mission_time_changes_and_a_forged_value_is_found() {
    let tree = TREE.replace("\"valve\" prob=0.01", "\"valve\" lambda=0.0001");
    let entry = |hours: u64| format!("{TABLES}{ENTRY}mission_time = {hours}\n");
    let lift = Lift::new(380)
        .write("brake.dft", &tree)
        .write("ledger.toml", &entry(100));
    let result = lift.result();
    let answer = &tree_of(&result)["findings"][0]["measure"]["answer"];
    assert_eq!(answer["guarantee"]["kind"], "bounded", "{answer}");
    let expected = (-0.01_f64).exp() * 0.96;
    assert!((answer["value"].as_f64().expect("a value") - expected).abs() < 1e-12);
    let is_fresh = |lift: &Lift| {
        let said = lift.call(&["plan", "."]).out;
        let line = said
            .lines()
            .find(|line| line.starts_with("T "))
            .expect("a line");
        line.contains("fresh")
    };
    assert!(is_fresh(&lift));
    let lift = lift.write("ledger.toml", &entry(200));
    assert!(!is_fresh(&lift));
    let lift = lift.write("ledger.toml", &entry(100));
    assert!(is_fresh(&lift));
    let lift = lift.write("brake.dft", &format!("{tree}\n"));
    assert!(!is_fresh(&lift));
    lift.result();
    assert_eq!(lift.call(&["verify", "results"]).code, 0);
    let kept = lift.0.path().join("results/study.json");
    let text = std::fs::read_to_string(&kept).expect("a result");
    let value = tree_of(&lift.result())["findings"][1]["measure"]["answer"]["value"].to_string();
    std::fs::write(&kept, text.replace(&value, "0.21")).expect("written");
    assert_eq!(lift.call(&["verify", "results"]).code, 1);
}

#[test]
fn what_is_wrong_with_a_tree_is_said_at_its_place_before_anything_runs() {
    let with = |old: &str, new: &str| {
        let entry = ENTRY.replace(old, new);
        Lift::new(380).write("ledger.toml", &format!("{TABLES}{entry}"))
    };
    let place = "ledger.toml:1";
    with("\"no stop\"", "\"no stopp\"").is_refused_with(&[
        "error[unknown-fault-tree-event]",
        place,
        "did you mean `no stop`?",
    ]);
    with("slip = ", "slipp = ").is_refused_with(&[
        "error[unknown-subject]",
        place,
        "did you mean `slip`?",
    ]);
    with("events = { \"1\" = \"no stop\", slip = \"left\" }\n", "").is_refused_with(&[
        "error[missing-entry]",
        place,
        "events = ",
    ]);
    with("tree = ", "model = \"m.prism\"\ntree = ").is_refused_with(&[
        "error[bad-ledger]",
        "which does not use `model`",
        place,
    ]);
    with("changed", "mission_time = -1\nchanged").is_refused_with(&["error[bad-ledger]", place]);
    with("brake.dft", "brake.txt").is_refused_with(&["error[missing-file]", place]);
    let tree = |text: &str| Lift::new(380).write("brake.dft", text);
    tree(&TREE.replace("prob=0.01", "lambda=0.001")).is_refused_with(&["brake.dft:4", "mission"]);
    tree(&TREE.replace("\"linings\" and", "\"linings\" pand"))
        .is_refused_with(&["brake.dft:3", "pand"]);
    tree(&TREE.replace("prob=0.01", "prob=1.5")).is_refused_with(&["brake.dft:4"]);
}

/// Its valve sticks 0.01 times an hour, and a shift of 8 h was written in minutes.
#[test]
fn a_mission_in_another_unit_is_named_by_its_line_of_the_ledger_and_offered() {
    let tree = TREE.replace("prob=0.01", "lambda=0.01");
    let entry = ENTRY.replace("changed", "mission_time = 480.0\nchanged");
    let lift = Lift::new(354)
        .write("brake.dft", &tree)
        .write("ledger.toml", &format!("{TABLES}{entry}"));
    assert_eq!(lift.call(&["run", ".", "--quiet"]).code, 1);
    let said = lift.call(&["diagnose", ".", "--format", "json"]);
    let diagnosis: Value = serde_json::from_str(&said.out).expect("JSON");
    let first = &diagnosis["suspects"][0];
    assert_eq!(first["asset"]["file"], "ledger.toml", "{first}");
    assert_eq!(first["asset"]["part"], "T, mission_time");
    assert_eq!(first["symptoms"][0]["instead"], "8.0");
    let offered = lift.call(&["refine", "."]);
    assert!(
        offered.out.contains("+mission_time = 8.0"),
        "{}",
        offered.out
    );
}
