//! One wrong value in what monitors read: a parameter, a unit, a scale, a number or a comparison of the vocabulary. Trials that
//! people counted and a model are right, so that `diagnose` names its line among the suspects, with the right value.

use crate::support;

use serde_json::Value;
use support::planted::Planted;

const STUDY: &str = r#"
title = "A gap that is kept"
summary = "Recordings, trials counted by people, and a model."
seed = 1
confidence = 0.95
agreement = 0.95
[conditions]
typical = "As usual."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "far"
text = "The robot keeps its distance in at least 80 % of runs."
shall = "The robot shall with probability at least 0.8 always satisfy far."
margin = 0.1
experiment = "kept"
[[requirement]]
id = "slow"
text = "The robot is slow in at least 80 % of runs."
shall = "The robot shall with probability at least 0.8 always satisfy slow."
margin = 0.1
experiment = "slow_kept"
"#;

const VOCABULARY: &str = r#"
[far]
meaning = "farther than allowed"
model = "s!=1"
trace = "/gap.distance > least_gap"
[slow]
meaning = "slower than allowed"
model = "s!=2"
trace = "/robot.speed < 0.5 m/s"
[kept]
meaning = "the distance was kept"
column = "kept"
[slow_kept]
meaning = "the speed was kept"
column = "slow"
"#;

const PARAMETERS: &str = "[least_gap]\nvalue = \"40 mm\"\nmeaning = \"The least gap.\"\n";

const TOPICS: &str = r#"
["/gap.distance"]
from = "/csv.gap"
scale = 0.001
unit = "m"
["/robot.speed"]
from = "/csv.speed"
unit = "m/s"
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
tables.cohort = "trials.csv"
changed = "Counted by hand."
[[evidence]]
id = "O"
title = "A week of work"
technique = "operation"
conditions = "typical"
recordings = "recordings"
changed = "Recorded."
"#;

const MODEL: &str = "dtmc\nmodule m\n  s : [0..3] init 0;\n  [] s=0 -> 0.06 : (s'=1) + 0.05 : (s'=2) + 0.89 : (s'=3);\n\
                     \n  [] s>0 -> true;\nendmodule\n";

/// The suspects of the study with texts replaced: the file, the old text, the new one.
fn suspects(changes: &[(&str, &str, &str)]) -> Vec<Value> {
    let folder = Planted::new();
    let write = |name: &str, text: &str| {
        let mut text = text.to_owned();
        for (_, old, new) in changes.iter().filter(|(file, ..)| *file == name) {
            assert!(text.contains(old), "{name} has no `{old}`");
            text = text.replacen(old, new, 1);
        }
        folder.write(name, &text);
    };
    write("study.toml", STUDY);
    write("requirements.toml", REQUIREMENTS);
    write("vocabulary.toml", VOCABULARY);
    write("parameters.toml", PARAMETERS);
    write("topics.toml", TOPICS);
    write("ledger.toml", LEDGER);
    write("model.prism", MODEL);
    let rows: String = (0..40)
        .map(|day| {
            format!(
                "d{day},4,{},{}\n",
                4 - u32::from(day % 4 == 0),
                4 - u32::from(day % 5 == 0)
            )
        })
        .collect();
    write("trials.csv", &format!("day,attempts,kept,slow\n{rows}"));
    for run in 0..100_u32 {
        // In six the gap is between 10 and 35 mm, in all others between 60 and 380 mm; in five the speed is 0.8 m/s.
        let gap = match run % 17 {
            0 => 10 + run / 4,
            _ => 60 + 320 * (run * 37 % 100) / 100,
        };
        let speed = if run % 20 == 7 {
            0.8
        } else {
            0.1 + f64::from(run) / 500.0
        };
        write(
            &format!("recordings/{run}.csv"),
            &format!("time_secs,gap,speed\n0,500,0.01\n1,{gap},{speed}\n2,400,0.02\n"),
        );
    }
    folder.run();
    let diagnosis = folder.json("diagnose");
    diagnosis["suspects"].as_array().expect("suspects").clone()
}

/// What is said of a part of a file: the values that it may be instead.
fn instead(suspects: &[Value], file: &str, part: &str) -> Vec<String> {
    let of_part = |it: &&Value| it["asset"]["file"] == file && it["asset"]["part"] == part;
    let found = suspects.iter().filter(of_part);
    found
        .map(|it| it["explanation"].as_str().expect("words").to_owned())
        .collect()
}

#[test]
fn a_study_whose_values_are_right_accuses_none_of_them() {
    let found = suspects(&[]);
    let strong = found.iter().filter(|it| it["score"].as_f64() > Some(1.0));
    assert_eq!(strong.count(), 0, "{found:#?}");
}

#[test]
fn a_wrong_value_is_named_by_its_line_with_the_right_one() {
    type Edit<'t> = (&'t str, &'t str, &'t str);
    let cases: [(&[Edit<'_>], &str, &str, &str); 5] = [
        // Millimetres written as centimetres.
        (
            &[("parameters.toml", "40 mm", "40 cm")],
            "parameters.toml",
            "least_gap, value",
            "`40 mm`",
        ),
        // Ten times the value.
        (
            &[("parameters.toml", "40 mm", "400 mm")],
            "parameters.toml",
            "least_gap, value",
            "`40 mm`",
        ),
        (
            &[("vocabulary.toml", "0.5 m/s", "0.05 m/s")],
            "vocabulary.toml",
            "slow, trace",
            "`0.5 m/s`",
        ),
        (
            &[("vocabulary.toml", "speed < 0.5", "speed > 0.5")],
            "vocabulary.toml",
            "slow, trace",
            "`<`",
        ),
        (
            &[("topics.toml", "scale = 0.001", "scale = 0.0001")],
            "topics.toml",
            "/gap.distance, scale",
            "`0.001`",
        ),
    ];
    for (planted, file, part, right) in cases {
        let found = suspects(planted);
        let named = instead(&found, file, part);
        assert!(
            named.iter().any(|it| it.contains(right)),
            "{planted:?}: {named:?}\n{found:#?}"
        );
    }
}

/// What the text says is the likelier value, and is tried though it is no slip.
#[test]
fn what_the_text_of_the_requirement_says_is_tried() {
    let text = "keeps its distance in";
    let found = suspects(&[
        ("requirements.toml", text, "keeps 40 mm of distance in"),
        ("parameters.toml", "40 mm", "290 mm"),
    ]);
    let named = instead(&found, "parameters.toml", "least_gap, value");
    assert!(
        named
            .iter()
            .any(|it| it.contains("the text of requirement far says it")),
        "{named:?}"
    );
    assert_eq!(found[0]["asset"]["file"], "parameters.toml", "{found:#?}");
}
