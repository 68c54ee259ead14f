//! One slip in a property that was written by hand, or one row of a table the wrong way round: each is named by its line, and
//! offered the other way; the sound study accuses nothing.

use crate::support;

use support::planted::Planted;

const STUDY: &str = r#"
title = "Parcels"
summary = "A model of a sorter, and counts by hand."
seed = 1
confidence = 0.95
agreement = 0.95
[conditions]
typical = "As usual."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "read"
text = "In at least 90 % of tries the label is read within two looks."
property = 'P=? [ F<=2 "readable" ]'
threshold = "at least 0.9"
margin = 0.06
[[requirement]]
id = "whole"
text = "At least 80 % of the parcels that are sorted are whole."
property = 'P=? [ G !"torn" || F "sorted" ]'
threshold = "at least 0.8"
margin = 0.06
"#;

const VOCABULARY: &str = r#"
[readable]
meaning = "The label has been read."
model = "s=1"
[sorted]
meaning = "The parcel is on its belt."
model = "s=2"
[torn]
meaning = "The parcel is torn."
model = "torn"
"#;

const LEDGER: &str = r#"
[[evidence]]
id = "M"
title = "A model"
technique = "model-checking"
conditions = "typical"
model = "model.prism"
changed = "The first."
[[evidence]]
id = "T"
title = "Trials"
technique = "experiment"
conditions = "typical"
tables.requirements = "counts.csv"
changed = "Counted by hand."
"#;

const MODEL: &str = "dtmc\nmodule m\n  s : [0..3] init 0;\n  looks : [0..2] init 0;\n  torn : bool init false;\n\
                     \n  [] s=0 & looks<2 -> 0.8 : (s'=1) + 0.2 : (looks'=looks+1);\n  [] s=0 & looks=2 -> (s'=3);\n\
                     \n  [] s=1 -> 0.135 : (s'=2) & (torn'=true) + 0.765 : (s'=2) + 0.1 : (s'=3);\n  [] s>=2 -> true;\nendmodule\n";

const COUNTS: &str = "requirement,covered,passed,failed\nread,400,385,15\nwhole,340,291,49\n";

/// The study with a text replaced.
fn study(change: Option<(&str, &str, &str)>) -> Planted {
    let folder = Planted::new();
    for (name, text) in [
        ("study.toml", STUDY),
        ("requirements.toml", REQUIREMENTS),
        ("vocabulary.toml", VOCABULARY),
        ("ledger.toml", LEDGER),
        ("model.prism", MODEL),
        ("counts.csv", COUNTS),
    ] {
        let text = match change {
            Some((file, old, new)) if file == name => {
                assert!(text.contains(old), "{name} has no `{old}`");
                text.replacen(old, new, 1)
            }
            _ => text.to_owned(),
        };
        folder.write(name, &text);
    }
    folder.run();
    folder
}

/// The first suspect's place, and the first offered diff.
fn first(change: (&str, &str, &str)) -> (String, u64, String) {
    let folder = study(Some(change));
    let diagnosis = folder.json("diagnose");
    let suspect = &diagnosis["suspects"][0];
    let file = suspect["asset"]["file"].as_str().unwrap_or_default();
    let line = suspect["asset"]["line"].as_u64().unwrap_or_default();
    let offered = folder.json("refine");
    let diff = offered["proposals"][0]["diff"].as_str().unwrap_or_default();
    (file.to_owned(), line, diff.to_owned())
}

#[test]
fn the_sound_study_accuses_nothing_and_offers_nothing() {
    let folder = study(None);
    let suspects = folder.json("diagnose");
    assert_eq!(suspects["suspects"], serde_json::json!([]));
    let offered = folder.json("refine");
    assert_eq!(offered["proposals"], serde_json::json!([]));
}

/// The text counts in words, and nothing says how long a step takes.
#[test]
fn a_bound_in_steps_that_the_text_says_otherwise_is_named() {
    let (file, line, diff) = first(("requirements.toml", "F<=2", "F<=1"));
    assert_eq!((file.as_str(), line), ("requirements.toml", 5));
    assert!(
        diff.contains("+property = 'P=? [ F<=2 \"readable\" ]'"),
        "{diff}"
    );
}

#[test]
fn a_property_that_asks_for_the_contrary_is_named() {
    let wrong = ("requirements.toml", "G !\"torn\"", "F \"torn\"");
    let (file, line, diff) = first(wrong);
    assert_eq!((file.as_str(), line), ("requirements.toml", 11));
    assert!(
        diff.contains("+property = 'P=? [ G !\"torn\" || F \"sorted\" ]'"),
        "{diff}"
    );
}

#[test]
fn a_row_with_passed_and_failed_the_wrong_way_round_is_named() {
    let (file, line, diff) = first(("counts.csv", "read,400,385,15", "read,400,15,385"));
    assert_eq!((file.as_str(), line), ("counts.csv", 2));
    assert!(diff.contains("+read,400,385,15"), "{diff}");
}
