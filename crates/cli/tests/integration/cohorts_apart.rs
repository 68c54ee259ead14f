//! Two tables of people that count different things in one study: each speaks of what it counts, and a header that no table has is
//! still a mistake.

use crate::support;

use support::program::corroborate;
use tempfile::TempDir;

const STUDY: &str = "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
                     [conditions]\ntypical = \"any\"\n";

const VOCABULARY: &str = "kept = { meaning = \"kept\", column = \"kept\" }\n\
                          greeted = { meaning = \"greeted\", column = \"greeted\" }\n";

const REQUIREMENTS: &str = "[[requirement]]\nid = \"1\"\ntext = \"It is kept.\"\nthreshold = \"at least 0.8\"\n\
                            margin = 0.1\nexperiment = \"kept\"\n\
                            [[requirement]]\nid = \"2\"\ntext = \"It greets.\"\nthreshold = \"at least 0.8\"\n\
                            margin = 0.1\nexperiment = \"greeted\"\n";

/// A study of two cohorts with these headers of the second.
fn study(second: &str) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let entry = |id: &str, file: &str| {
        format!(
            "[[evidence]]\nid = \"{id}\"\ntitle = \"experiment\"\ntechnique = \"experiment\"\nconditions = \"typical\"\n\
             tables.cohort = \"{file}\"\nchanged = \"c\"\n"
        )
    };
    let ledger = entry("A", "a.csv") + &entry("B", "b.csv");
    let rows = |people: std::ops::Range<u32>| -> String {
        people
            .map(|person| format!("P{person},{},20\n", 18 + person % 3))
            .collect()
    };
    let (first, second) = (
        format!("person,kept,attempts\n{}", rows(0..12)),
        format!("person,{second},attempts\n{}", rows(20..33)),
    );
    for (name, text) in [
        ("study.toml", STUDY),
        ("vocabulary.toml", VOCABULARY),
        ("requirements.toml", REQUIREMENTS),
        ("ledger.toml", ledger.as_str()),
        ("a.csv", first.as_str()),
        ("b.csv", second.as_str()),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

#[test]
fn each_cohort_speaks_of_what_it_counts() {
    let folder = study("greeted");
    let said = corroborate(folder.path(), &["run", "."]);
    assert_eq!(said.code, 0, "{}{}", said.out, said.talk);
    let result = corroborate(folder.path(), &["run", ".", "--format", "json"]);
    let result: serde_json::Value = serde_json::from_str(&result.out).expect("JSON");
    let counted = |evidence: usize| -> Vec<bool> {
        let findings = result["evidence"][evidence]["findings"].as_array();
        let findings = findings.expect("findings").iter();
        findings
            .map(|it| it["measure"]["kind"] == "counts")
            .collect()
    };
    assert_eq!(counted(0), [true, false], "{result:#}");
    assert_eq!(counted(1), [false, true], "{result:#}");
}

#[test]
fn a_header_that_no_cohort_has_is_a_mistake() {
    let folder = study("greted");
    let said = corroborate(folder.path(), &["run", "."]);
    assert_eq!(said.code, 2, "{}", said.out);
    assert!(said.talk.contains("greeted"), "{}", said.talk);
}
