//! A scale that is lacking, so that no recording ever comes near: nothing is violated, and no rate could be compared. That the
//! requirement is never triggered is what shows it.

use crate::support;

use serde_json::Value;
use support::planted::Planted;

const STUDY: &str = r#"
title = "A robot that warns"
summary = "A model, and a week of recordings."
seed = 1
confidence = 0.95
agreement = 0.95
sample_sizes = "fixed"
[conditions]
usual = "As usual."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "warned"
text = "Somebody who comes near is warned in at least 80 % of all cases."
shall = "When near, the robot shall with probability at least 0.8 eventually satisfy warning."
margin = 0.1
"#;

const VOCABULARY: &str = r#"
[near]
meaning = "somebody is near"
model = "s=1"
trace = "/person.gap < 1 m"
[warning]
meaning = "the robot warns"
model = "s=2"
trace = "/robot.warns > 0.5"
"#;

const TOPICS: &str = r#"
["/person.gap"]
from = "/csv.gap_cm"
scale = 0.01
unit = "m"
["/robot.warns"]
from = "/csv.warns"
"#;

const LEDGER: &str = r#"
[[evidence]]
id = "M"
title = "A model"
technique = "model-checking"
conditions = "usual"
model = "model.prism"
changed = "The first."
[[evidence]]
id = "O"
title = "A week of work"
technique = "operation"
conditions = "usual"
recordings = "recordings"
changed = "Recorded."
"#;

/// In 0.3 of all runs somebody comes near, in 0.9 of these with a warning.
const MODEL: &str = "dtmc\nmodule m\n  s : [0..3] init 0;\n  [] s=0 -> 0.3 : (s'=1) + 0.7 : (s'=3);\n\
                     \n  [] s=1 -> 0.9 : (s'=2) + 0.1 : (s'=3);\n  [] s>1 -> true;\nendmodule\n";

/// The suspects, without the scale or with it.
fn suspects(topics: &str) -> Vec<Value> {
    let folder = Planted::new();
    for (name, text) in [
        ("study.toml", STUDY),
        ("requirements.toml", REQUIREMENTS),
        ("vocabulary.toml", VOCABULARY),
        ("topics.toml", topics),
        ("ledger.toml", LEDGER),
        ("model.prism", MODEL),
    ] {
        folder.write(name, text);
    }
    for run in 0..100_u32 {
        // Three of ten come as near as 60 cm, and one of ten of these is not warned.
        let (gap, warns) = match (run % 10, run % 100 / 10) {
            (0..3, tens) => (60, u32::from((tens + run) % 10 != 0)),
            _ => (240, 0),
        };
        folder.write(
            &format!("recordings/{run}.csv"),
            &format!("time_secs,gap_cm,warns\n0,400,0\n1,{gap},0\n2,{gap},{warns}\n3,500,0\n"),
        );
    }
    folder.run();
    let found = folder.json("diagnose");
    found["suspects"].as_array().expect("a list").clone()
}

#[test]
fn a_scale_with_which_nothing_is_ever_triggered_is_named() {
    assert_eq!(suspects(TOPICS), Vec::<Value>::new());
    let found = suspects(&TOPICS.replace("scale = 0.01\n", ""));
    let first = &found[0];
    assert_eq!(first["asset"]["file"], "topics.toml", "{found:?}");
    let instead = first["symptoms"][0]["instead"].as_str().unwrap_or_default();
    // The unit that the field is called after says the same.
    assert!(
        instead == "cm" || instead.contains("scale = 0.01"),
        "{found:?}"
    );
    // The runs themselves, or what they are read through, stay behind it.
    let runs = found
        .iter()
        .any(|it| it["title"] == "O never triggers requirement warned");
    assert!(runs, "{found:?}");
}
