//! Variants as a user meets them: a model's constants, simulators' settings, and files that are wrong.

use crate::support;

use serde_json::Value;
use support::program::{Said, Study, corroborate};
use support::simulation::{handover, library, simulating};
use support::{copy_study, read, root, schema};

const MODEL: &str = "\
dtmc
const double pLoses = 0.1;
const int tries = 1;
module robot
  s : [0..2] init 0;
  [] s=0 -> 1-pow(pLoses, tries) : (s'=1) + pow(pLoses, tries) : (s'=2);
  [] s>0 -> true;
endmodule
";

const REQUIREMENTS: &str = "\
[[requirement]]
id = \"R1\"
text = \"The object is handed over.\"
property = 'P=? [ F \"handed_over\" ]'
experiment = \"handed_over\"
";

const VOCABULARY: &str = "\
[handed_over]
meaning = \"The object is with the person.\"
model = \"s=1\"
column = \"successes\"
";

const LEDGER: &str = "\
[[evidence]]
id = \"E1\"
title = \"Experiments\"
technique = \"experiment\"
conditions = \"typical\"
tables.requirements = \"counts.csv\"
changed = \"Twenty trials.\"

[[evidence]]
id = \"E2\"
title = \"Model\"
technique = \"model-checking\"
conditions = \"typical\"
model = \"model.prism\"
changed = \"Set to the experiments.\"
calibrated = [{ constant = \"pLoses\", from = \"E1\", requirement = \"R1\" }]
";

const VARIANT: &str = "\
name = \"second try\"
meaning = \"It tries twice.\"
subjects = [\"R1\"]

[[change]]
evidence = \"E2\"
constants = { pLoses = \"pLoses^2\" }
assumes = \"Tries are independent.\"

[[change]]
evidence = \"E1\"
cannot = \"Nobody has tried.\"
";

/// A study of one constant. The counts are of losses, so that the constant is
/// their share.
fn study(variant: &str) -> Study {
    let study = Study::new();
    let about = read(&study.path("study.toml"));
    assert!(about.contains("[conditions]"), "{about}");
    std::fs::create_dir_all(study.path("variants")).expect("made");
    study
        .write("model.prism", MODEL)
        .write("requirements.toml", REQUIREMENTS)
        .write("vocabulary.toml", VOCABULARY)
        .write("ledger.toml", LEDGER)
        .write(
            "counts.csv",
            "requirement,covered,passed,failed\nR1,20,2,18\n",
        )
        .write("variants/second.toml", variant);
    let start = about.find("[conditions]").expect("found");
    study.write(
        "study.toml",
        format!("{}[conditions]\ntypical = \"As it is.\"\n", &about[..start]),
    );
    study
}

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

#[test]
fn a_models_gain_has_the_interval_of_its_constants_posterior() {
    let squared = "{ pLoses = \"pLoses^2\" }";
    assert!(VARIANT.contains(squared));
    for constants in [squared, "{ tries = \"tries + 1\" }"] {
        let study = study(&VARIANT.replace(squared, constants));
        let said = study.run(&["what-if", "study", "--points", "2000", "--format", "json"]);
        assert_eq!(said.code, 0, "{said:?}");
        let report = json(&said);
        let schema: Value =
            serde_json::from_str(&read(&root().join("schemas/what-if.schema.json")))
                .expect("a schema");
        let violations = schema::violations(&schema, &report);
        assert!(violations.is_empty(), "{violations:?}");
        let rows = report["variants"][0]["rows"].as_array().expect("rows");
        assert_eq!(rows.len(), 2);
        let gain = &rows[0]["gain"];
        let number = |value: &Value| value.as_f64().expect("a number");
        assert!((number(&gain["before"]) - 0.9).abs() < 1e-9, "{gain}");
        assert!((number(&gain["after"]) - 0.99).abs() < 1e-9, "{gain}");
        // p - p^2 grows with p below one half, so its quantiles are those of p.
        // scipy.stats.beta(2.5, 18.5).ppf([0.025, 0.975]) = 0.0213725, 0.2838533.
        let (low, high) = (&gain["interval"]["low"], &gain["interval"]["high"]);
        assert!((number(low) - 0.0209157).abs() < 0.001, "{gain}");
        assert!((number(high) - 0.2032806).abs() < 0.002, "{gain}");
        assert_eq!(rows[1]["gain"]["kind"], "not-expressible");
    }
}

#[test]
fn wrong_variants_are_said_with_their_place() {
    for (old, new, wanted) in [
        ("evidence = \"E2\"", "evidence = \"E9\"", "E9"),
        ("{ pLoses =", "{ pWins =", "pWins"),
        (
            "{ pLoses = \"pLoses^2\" }",
            "{ tries = \"tries / 2\" }",
            "whole number",
        ),
        ("\"pLoses^2\"", "\"pLoses +\"", "second.toml"),
        ("subjects = [\"R1\"]", "subjects = [\"R7\"]", "R7"),
        ("cannot = \"Nobody has tried.\"", "", "cannot"),
        ("meaning =", "meening =", "meening"),
    ] {
        assert!(VARIANT.contains(old));
        let study = study(&VARIANT.replacen(old, new, 1));
        let said = study.run(&["what-if", "study"]);
        assert_eq!(said.code, 2, "{new}: {said:?}");
        assert!(said.talk.contains(wanted), "{new}: {}", said.talk);
    }
    let said = study(VARIANT).run(&["what-if", "study", "--variant", "third try"]);
    assert_eq!(said.code, 2);
    assert!(said.talk.contains("second try"), "{}", said.talk);
}

const SLOWER: &str = "\
name = \"slower\"
meaning = \"It drives at two thirds of the speed.\"
subjects = [\"stops\", \"clear\"]

[[change]]
evidence = \"sim\"
settings = { \"cart.speed_cm_per_s\" = 100 }
";

/// The study of a simulator that is a command, with a variant.
fn carts(variant: &str) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&root().join("conformance/command"), folder.path());
    let file = folder.path().join("variants/slower.toml");
    std::fs::create_dir_all(folder.path().join("variants")).expect("made");
    std::fs::write(file, variant).expect("written");
    folder
}

/// A variant in a simulator that is a command is what its stimulus would make of the same seeds.
#[test]
fn another_simulators_gain_is_that_of_its_stimulus() {
    let folder = carts(SLOWER);
    let said = corroborate(
        folder.path(),
        &["what-if", ".", "--episodes", "12", "--format", "json"],
    );
    assert_eq!(said.code, 0, "{said:?}");
    let kept = "as it is: 12 of 12 are there";
    assert!(said.talk.contains(kept), "{}", said.talk);
    let report = json(&said);
    let rows = report["variants"][0]["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 2, "{report}");

    let stimulus = folder.path().join("stimulus.toml");
    let counted = || {
        let runs = tempfile::TempDir::new().expect("a folder");
        let out = runs.path().join("runs");
        let out = out.to_str().expect("a path");
        let arguments = [
            "simulate", ".", "sim", "-n", "12", "--out", out, "--format", "json",
        ];
        let shown = json(&corroborate(folder.path(), &arguments));
        ["stops", "clear"].map(|id| {
            let estimates = shown["estimates"].as_array().expect("estimates");
            let one = estimates.iter().find(|it| it["subject"]["id"] == id);
            let count = |key: &str| one.expect("an estimate")[key].as_f64().expect("a number");
            count("count") / count("trials")
        })
    };
    let before = counted();
    let changed = read(&stimulus).replace("= 150", "= 100");
    std::fs::write(&stimulus, changed).expect("written");
    let after = counted();
    assert!(before[0] < after[0], "{before:?} {after:?}");
    for (row, (before, after)) in rows.iter().zip(before.into_iter().zip(after)) {
        let gain = &row["gain"];
        let close =
            |value: &Value, wanted: f64| (value.as_f64().expect("a number") - wanted).abs() < 1e-12;
        assert!(
            close(&gain["before"], before) && close(&gain["after"], after),
            "{row} {before} {after}"
        );
    }
}

/// A key that the simulator may not know would look like no gain, and a rig is not moved for a prediction.
#[test]
fn what_no_simulator_can_be_asked_is_refused() {
    for (old, new, study, wanted) in [
        ("speed_cm", "sped_cm", "", "did you mean `speed_cm_per_s`"),
        (
            "name = \"slower\"",
            "name = \"slower\"",
            "experiment",
            "cannot",
        ),
    ] {
        let folder = carts(&SLOWER.replacen(old, new, 1));
        let ledger = folder.path().join("ledger.toml");
        if !study.is_empty() {
            let text = read(&ledger).replace("\"simulation\"", &format!("\"{study}\""));
            std::fs::write(&ledger, text).expect("written");
        }
        let said = corroborate(folder.path(), &["what-if", ".", "--episodes", "2"]);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(
            said.talk.contains(wanted) && said.talk.contains("slower.toml"),
            "{}",
            said.talk
        );
    }
}

/// Each of the handover's variants keys something that exists, and paired runs
/// are the same runs: with the planner's fault made certain, a second call
/// fixes each of them.
#[test]
fn a_second_call_of_the_planner_mends_what_one_call_spoils() {
    let Some(library) = library() else { return };
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&handover(), folder.path());
    let ledger = folder.path().join("ledger.toml");
    let text = read(&ledger);
    let mut parts = text.split("[[evidence]]");
    let head = parts.next().unwrap_or_default();
    let only: Vec<&str> = parts
        .filter(|part| {
            ["\"E3\"", "\"E4\"", "\"E5\""]
                .iter()
                .any(|id| part.contains(&format!("id = {id}")))
        })
        .collect();
    let kept = format!("{head}[[evidence]]{}", only.join("[[evidence]]"));
    let kept = kept.replace("episodes = 500", "episodes = 2");
    let lines: Vec<&str> = kept
        .lines()
        .filter(|line| !line.contains("E4-published"))
        .collect();
    std::fs::write(ledger, lines.join("\n")).expect("written");
    let model = folder.path().join("models/handover_v5.prism");
    let short = read(&model).replace("timeMax = 1000", "timeMax = 320");
    std::fs::write(model, short).expect("written");
    let tuned = folder.path().join("simulation/tuned.toml");
    let text = read(&tuned).replace("failure_rate_per_run = 0.002", "failure_rate_per_run = 1.0");
    std::fs::write(tuned, text).expect("written");
    let arguments = [
        "what-if",
        ".",
        "--variant",
        "planner retry",
        "--episodes",
        "3",
        "--points",
        "20",
        "--format",
        "json",
    ];
    let said = simulating(&library, folder.path(), &arguments);
    assert_eq!(said.code, 0, "{said:?}");
    // The two episodes that the evidence has are not run again.
    let kept = "as it is: 2 of 3 are there";
    assert!(said.talk.contains(kept), "{}", said.talk);
    let report = json(&said);
    let rows = report["variants"][0]["rows"].as_array().expect("rows");
    let of = |evidence: &str, id: &str| {
        let row = rows
            .iter()
            .find(|row| row["evidence"] == evidence && row["subject"]["id"] == id);
        row.expect("a row")["gain"].clone()
    };
    let errors = of("E4", "runtime_error");
    assert_eq!(
        (&errors["before"], &errors["after"]),
        (&1.0.into(), &0.0.into()),
        "{errors}"
    );
    let formal = of("E5", "runtime_error");
    let after = formal["after"].as_f64().expect("a value");
    assert!((after - 0.000004).abs() < 1e-12, "{formal}");
}
