//! What was counted under two conditions, entered each under the other's: the ledger is fixed, and nothing else.

use crate::support;

use support::planted::Planted;
use support::program::corroborate;

const STUDY: &str = r#"
title = "A ferry's ramp"
summary = "The ramp of a ferry, in calm weather and in wind."
seed = 1
confidence = 0.95
agreement = 0.95
sample_sizes = "fixed"
[conditions]
calm = "Calm weather."
windy = "Wind."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "down"
text = "At least 80 % of landings have the ramp down at the first try."
property = 'P=? [ F "down" ]'
margin = 0.03
threshold = "at least 0.8"
experiment = "down"
"#;

const VOCABULARY: &str =
    "[down]\nmeaning = \"the ramp is down\"\nmodel = \"s=1\"\ncolumn = \"down\"\n";

const COUNTS: [&str; 2] = [
    "requirement,covered,passed,failed\ndown,400,361,39\n",
    "requirement,covered,passed,failed\ndown,400,279,121\n",
];

fn entry(id: &str, technique: &str, conditions: &str, source: &str) -> String {
    format!(
        "[[evidence]]\nid = \"{id}\"\ntitle = \"{id}\"\ntechnique = \"{technique}\"\nconditions = \"{conditions}\"\n{source}\n\
         changed = \"First.\"\n\n"
    )
}

/// The study, with the tables as they belong or each in the other's place.
fn study(tables: [&str; 2]) -> Planted {
    let folder = Planted::new();
    let model = |p: f64| {
        format!(
            "dtmc\nmodule m\n  s : [0..2] init 0;\n  [] s=0 -> {p} : (s'=1) + 1-{p} : (s'=2);\n  [] s>0 -> true;\nendmodule\n"
        )
    };
    let table = |file: &str| format!("tables.requirements = \"{file}\"");
    let ledger = [
        entry("M1", "model-checking", "calm", "model = \"calm.prism\""),
        entry("M2", "model-checking", "windy", "model = \"windy.prism\""),
        entry("T1", "experiment", "calm", &table(tables[0])),
        entry("T2", "experiment", "windy", &table(tables[1])),
    ];
    for (name, text) in [
        ("study.toml", STUDY),
        ("requirements.toml", REQUIREMENTS),
        ("vocabulary.toml", VOCABULARY),
        ("ledger.toml", &ledger.concat()),
        ("calm.prism", &model(0.9)),
        ("windy.prism", &model(0.7)),
        ("calm.csv", COUNTS[0]),
        ("windy.csv", COUNTS[1]),
    ] {
        folder.write(name, text);
    }
    folder.run();
    folder
}

#[test]
fn tables_that_changed_places_are_told_and_put_back_in_the_ledger() {
    let sound = study(["calm.csv", "windy.csv"]);
    assert_eq!(sound.json("diagnose")["suspects"], serde_json::json!([]));
    assert_eq!(sound.json("refine")["proposals"], serde_json::json!([]));

    let folder = study(["windy.csv", "calm.csv"]);
    let suspects = &folder.json("diagnose")["suspects"];
    let first = &suspects[0];
    let title = first["title"].as_str().unwrap_or_default();
    assert!(title.contains("changed places"), "{suspects}");
    assert_eq!(first["asset"]["file"], "ledger.toml", "{suspects}");

    let offered = folder.json("refine");
    let proposals = offered["proposals"].as_array().expect("a list");
    let put_back = proposals
        .iter()
        .find(|it| it["title"] == "T1 and T2: the files of the two exchanged");
    let put_back = put_back.unwrap_or_else(|| panic!("{offered}"));
    assert_eq!(put_back["file"], "ledger.toml");
    assert_eq!(put_back["needs_decision"], true);
    let diff = put_back["diff"].as_str().unwrap_or_default();
    assert!(
        diff.contains("-tables.requirements = \"windy.csv\"\n+tables.requirements = \"calm.csv\""),
        "{diff}"
    );

    let number = proposals
        .iter()
        .position(|it| it["title"] == put_back["title"])
        .map_or(0, |at| at + 1);
    let number = number.to_string();
    let said = corroborate(
        folder.path(),
        &["refine", ".", "--accept", &number, "--quiet"],
    );
    assert!([0, 1].contains(&said.code), "{said:?}");
    folder.run();
    assert_eq!(folder.json("diagnose")["suspects"], serde_json::json!([]));

    // What was put back because then the models agree does not agree with them by itself.
    let ledger = support::read(&folder.path().join("ledger.toml"));
    let lines = |from: &str| {
        format!(
            "chosen = [\n    {{ what = \"T1 and T2: the files of the two exchanged\", from = \"{from}\", requirement = \"down\" }},\n]"
        )
    };
    assert!(ledger.contains(&lines("M1")), "{ledger}");
    assert!(ledger.contains(&lines("M2")), "{ledger}");
    let compared = folder.json("compare");
    let pairs = compared["comparisons"].as_array().expect("comparisons");
    for (model, table) in [("M1", "T1"), ("M2", "T2")] {
        let mut own = pairs
            .iter()
            .filter(|it| it["left"] == model && it["right"] == table);
        let pair = own.next().unwrap_or_else(|| panic!("{pairs:#?}"));
        assert_eq!(pair["independent"], false, "{pair}");
        let reason = pair["reason"].as_str().unwrap_or_default();
        let said = format!(
            "\"T1 and T2: the files of the two exchanged\" was chosen in {table} because then {model} agrees."
        );
        assert!(reason.contains(&said), "{reason}");
    }
}

/// A choice names evidence of the ledger, before or behind it, and says what was changed.
#[test]
fn a_choice_of_nothing_is_refused_with_its_place() {
    let folder = study(["calm.csv", "windy.csv"]);
    let ledger = support::read(&folder.path().join("ledger.toml"));
    for (written, part) in [
        (
            "what = \"word\", from = \"T3\", requirement = \"down\"",
            "the ledger has no evidence `T3`",
        ),
        (
            "what = \" \", from = \"T1\", requirement = \"down\"",
            "does not say what was changed",
        ),
        (
            "what = \"word\", from = \"T1\"",
            "needs either a `failure_mode` or a `requirement`",
        ),
        (
            "what = \"word\", from = \"T1\", requirement = \"dwn\"",
            "did you mean `down`?",
        ),
    ] {
        let line = format!("model = \"calm.prism\"\nchosen = [{{ {written} }}]");
        folder.write(
            "ledger.toml",
            &ledger.replacen("model = \"calm.prism\"", &line, 1),
        );
        let said = corroborate(folder.path(), &["run", ".", "--quiet"]);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(
            said.talk.contains(part) && said.talk.contains("ledger.toml:7:"),
            "{said:?}"
        );
    }
}
