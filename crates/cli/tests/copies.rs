//! What looks copied from other evidence is asked about, and a line of the ledger settles it.

mod support;

use serde_json::Value;
use support::program::Study;

/// The study of the tests with further experiments of these tables, and its result.
fn ran(tables: &[(&str, &str, String)], settled: &str, model: Option<&str>) -> (Study, Value) {
    let study = Study::new();
    let mut ledger = support::read(&study.path("ledger.toml"));
    for (id, key, table) in tables {
        study.write(&format!("{id}.csv"), table.clone());
        let reason = if *id == "B" { settled } else { "" };
        ledger += &format!(
            "\n[[evidence]]\nid = \"{id}\"\ntitle = \"{id}\"\ntechnique = \"experiment\"\n\
             conditions = \"typical\"\n{key} = \"{id}.csv\"\nchanged = \"Sessions.\"\n{reason}\n"
        );
    }
    study.write("ledger.toml", ledger);
    if let Some(line) = model {
        let text = support::read(&study.path("model.prism"));
        study.write("model.prism", format!("{text}\n{line}\n"));
    }
    let said = study.run(&["run", "study", "--quiet"]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let result = support::read(&study.path("results/study.json"));
    (study, serde_json::from_str(&result).expect("JSON"))
}

fn questions(result: &Value, id: &str) -> Vec<Value> {
    let pieces = result["evidence"].as_array().expect("evidence");
    let piece = pieces.iter().find(|it| it["id"] == id).expect("the piece");
    let all = piece["lineage_questions"].as_array().expect("questions");
    all.clone()
}

/// Pairs of the two that have figures.
fn pairs(result: &Value) -> Vec<Value> {
    let comparisons = result["comparisons"].as_array().expect("comparisons");
    let ours = |c: &&Value| c["left"] == "A" && c["right"] == "B" && !c["p_difference"].is_null();
    comparisons.iter().filter(ours).cloned().collect()
}

fn cohort(names: &str, counts: &[u64]) -> String {
    let row = |(i, count): (usize, &u64)| {
        let missed = "M ".repeat(30 - *count as usize);
        format!("{names}{i},{count},30,{missed}\n")
    };
    let rows: String = counts.iter().enumerate().map(row).collect();
    format!("session,successes,attempts,failure_modes\n{rows}")
}

const COUNTS: [u64; 12] = [27, 24, 30, 21, 25, 28, 19, 26, 23, 29, 22, 25];

#[test]
fn rows_under_other_names_are_asked_about_until_settled() {
    let other = [25, 27, 24, 22, 28, 29, 26, 24, 20, 27, 23, 30];
    for (counts, settled, is_open) in [
        (COUNTS, "", true),
        (
            COUNTS,
            "independent = { A = \"another robot, the same list\" }",
            false,
        ),
        (other, "", false),
    ] {
        let tables = [
            ("A", "tables.cohort", cohort("p", &COUNTS)),
            ("B", "tables.cohort", cohort("x", &counts)),
        ];
        let (study, result) = ran(&tables, settled, None);
        let asked = questions(&result, "B");
        assert_eq!(!asked.is_empty(), counts == COUNTS, "{asked:?}");
        if let Some(asked) = asked.first() {
            assert_eq!(asked["kind"], "rows");
            assert_eq!(asked["places"][0], "B.csv:2");
            assert_eq!(asked["settled"].is_null(), is_open);
        }
        let pairs = pairs(&result);
        assert!(!pairs.is_empty());
        for pair in pairs {
            assert_eq!(pair["possibly_copied"], is_open, "{pair}");
            assert_eq!(pair["independent"], !is_open, "{pair}");
            let reason = pair["reason"].as_str().expect("a reason");
            assert_eq!(reason.contains("copied"), is_open, "{reason}");
        }
        let verified = study.run(&["verify", "study/results"]);
        assert_eq!(verified.code, 0, "{verified:?}");
    }
}

#[test]
fn small_tables_that_always_succeed_are_no_copies() {
    let always = |names: &str| cohort(names, &[30, 30, 30, 30, 30]);
    let tables = [
        ("A", "tables.cohort", always("p")),
        ("B", "tables.cohort", always("x")),
    ];
    let (_, result) = ran(&tables, "", None);
    assert!(questions(&result, "B").is_empty());
    assert!(
        pairs(&result)
            .iter()
            .all(|pair| pair["independent"] == true)
    );
}

#[test]
fn a_number_of_the_model_that_is_a_rate_is_asked_about_with_its_line() {
    let tables = [("A", "tables.cohort", cohort("p", &COUNTS))];
    // 299 of 360.
    let study = Study::new();
    let lines = support::read(&study.path("model.prism")).lines().count();
    for (line, blocks) in [
        ("const double copied = 299/360;", Some(true)),
        ("const double copied = 0.8306;", Some(true)),
        ("const double copied = 0.83;", Some(false)),
        ("const double other = 0.8312;", None),
    ] {
        let (study, result) = ran(&tables, "", Some(line));
        let ledger = support::read(&study.path("ledger.toml"));
        let model = ledger.find("model.prism").expect("a model");
        let begin = ledger[..model].rfind("id = \"").expect("an entry") + 6;
        let id = &ledger[begin..begin + ledger[begin..].find('"').expect("an end")];
        let asked = questions(&result, id);
        let about = |it: &&Value| it["with"] == "A" && it["kind"] == "constant";
        let found = asked.iter().find(about);
        assert_eq!(
            found.map(|it| it["blocks"] == true),
            blocks,
            "{line} {asked:?}"
        );
        if let Some(found) = found {
            let place = found["places"][0].as_str().expect("a place");
            assert_eq!(place, format!("model.prism:{}", lines + 2));
            let remedy = found["remedy"].as_str().expect("a remedy");
            assert!(
                remedy.contains("constant = \"copied\", from = \"A\""),
                "{remedy}"
            );
        }
    }
}

#[test]
fn a_reason_is_asked_for_and_only_evidence_of_the_ledger_is_named() {
    let tables = |_: ()| [("A", "tables.cohort", cohort("p", &COUNTS))];
    for (line, code) in [
        ("independent = { nothing = \"x\" }", "unknown-evidence"),
        ("independent = \" \"", "no-reason"),
    ] {
        let (study, _) = ran(&tables(()), "", None);
        let ledger = support::read(&study.path("ledger.toml"));
        study.write("ledger.toml", format!("{ledger}\n{line}\n"));
        let said = study.run(&["run", "study", "--quiet"]);
        assert!(said.code == 2 && said.talk.contains(code), "{said:?}");
    }
}
