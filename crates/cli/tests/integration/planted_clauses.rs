//! One slip in how words are put together: a clause, a comparison, a case, a signal, a scale, a number that the text says, a word
//! of a sentence. Trials that people counted, and a model, say what is right, so that `diagnose` names the line and what it
//! should be.

use crate::support;

use serde_json::Value;
use support::planted::Planted;
use support::program::corroborate;

const STUDY: &str = r#"
title = "Bread"
summary = "Recordings of an oven, trials counted by bakers, and a model."
seed = 1
confidence = 0.95
agreement = 0.95
[conditions]
typical = "As usual."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "pale"
text = "In at least 70 % of loaves the crust never gets above 180 degrees behind a shut door."
shall = "The oven shall with probability at least 0.7 never satisfy scorched."
margin = 0.05
experiment = "pale"
[[requirement]]
id = "high"
text = "At least 60 % of loaves are risen, to 120 mm and more."
shall = "The oven shall with probability at least 0.6 eventually satisfy risen."
margin = 0.05
experiment = "high"
[[requirement]]
id = "whole"
text = "In at least 60 % of loaves the blade cuts nothing."
shall = "The oven shall with probability at least 0.6 never satisfy cut."
margin = 0.05
experiment = "whole"
"#;

const VOCABULARY: &str = r#"
[scorched]
meaning = "The crust is too hot behind a shut door."
model = "s=1 | s=3"
trace = "/crust.heat > 180 & /door.shut"
[risen]
meaning = "The loaf is high enough."
model = "h=1"
trace = "/dough.height >= 120"
[cut]
meaning = "The blade has cut."
model = "c=1"
trace = "/blade.cuts > 0"
[pale]
meaning = "The crust stayed pale."
column = "pale"
[high]
meaning = "The loaf came out high."
column = "high"
[whole]
meaning = "The loaf came out whole."
column = "whole"
"#;

const TOPICS: &str = r#"
["/crust.heat"]
from = "/csv.crust_dc"
scale = 0.1
["/core.heat"]
from = "/csv.core_dc"
scale = 0.1
["/dough.height"]
from = "/csv.height_mm"
["/blade.cuts"]
from = "/csv.cuts"
["/door.shut"]
from = "/csv.shut"
kind = "bool"
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

const MODEL: &str = "dtmc\nmodule m\n  s : [0..3] init 0;\n  h : [0..2] init 0;\n  c : [0..2] init 0;\n\
                     \n  [] s=0 -> 0.05 : (s'=1) + 0.15 : (s'=3) + 0.8 : (s'=2);\
                     \n  [] s>0 & h=0 -> 0.7 : (h'=1) + 0.3 : (h'=2);\
                     \n  [] h>0 & c=0 -> 0.25 : (c'=1) + 0.75 : (c'=2);\n  [] c>0 -> true;\nendmodule\n";

/// The crust, in tenths of a degree, and the door, the height and the cuts of a run: of a hundred, 20 are scorched, 40 as hot
/// with an open door, 70 are risen and 25 cut.
fn run(number: u32) -> (u32, bool, u32, u32) {
    let (crust, shut) = match number / 40 {
        0 => (1900 + number, true),
        1 | 2 => (1900 + number, false),
        _ => (1500 + number, true),
    };
    let height = match number % 10 {
        0..=2 => 80 + number % 30,
        _ => 121 + number % 50,
    };
    (crust, shut, height, u32::from(number % 4 == 1))
}

/// What `diagnose` prints of the study, and its suspects, with one text replaced in a file, or in the files of a folder.
fn suspects(change: Option<(&str, &str, &str)>) -> (String, Vec<Value>) {
    let folder = Planted::new();
    let write = |name: &str, text: &str| {
        let mut text = text.to_owned();
        if let Some((file, old, new)) = change.filter(|(file, ..)| name.starts_with(file)) {
            assert!(
                file.ends_with('/') || text.contains(old),
                "{name} has no `{old}`"
            );
            text = text.replacen(old, new, 1);
        }
        folder.write(name, &text);
    };
    write("study.toml", STUDY);
    write("requirements.toml", REQUIREMENTS);
    write("vocabulary.toml", VOCABULARY);
    write("topics.toml", TOPICS);
    write("ledger.toml", LEDGER);
    write("model.prism", MODEL);
    let rows: String = (0..40)
        .map(|day| format!("d{day},20,16,14,{}\n", 15 + day % 2 - (day / 2) % 2))
        .collect();
    write(
        "trials.csv",
        &format!("day,attempts,pale,high,whole\n{rows}"),
    );
    for number in 0..200_u32 {
        let (crust, shut, height, cuts) = run(number);
        let core = 920 + number % 60;
        write(
            &format!("recordings/{number:03}.csv"),
            &format!(
                "time_secs,crust_dc,core_dc,height_mm,cuts,shut\n0,200,200,60,0,true\n1,{crust},{core},{height},{cuts},{shut}\n\
                 2,900,900,{height},{cuts},true\n"
            ),
        );
    }
    folder.run();
    let text = corroborate(folder.path(), &["diagnose", ".", "--quiet"]);
    let diagnosis = folder.json("diagnose");
    // The commands that are printed run.
    for line in text
        .out
        .lines()
        .filter(|line| line.contains("witness: corroborate monitor"))
    {
        let command = line.split("corroborate ").nth(1).expect("a command");
        let command = command.split("  (").next().expect("a command");
        let arguments: Vec<&str> = command.split_whitespace().collect();
        let said = corroborate(folder.path(), &arguments);
        assert!([0, 1].contains(&said.code), "{line}: {said:?}");
    }
    let all = diagnosis["suspects"].as_array().expect("suspects").clone();
    (text.out, all)
}

#[test]
fn a_study_that_is_put_together_right_accuses_nothing() {
    let (_, found) = suspects(None);
    let strong = found.iter().filter(|it| it["score"].as_f64() > Some(1.0));
    assert_eq!(strong.count(), 0, "{found:#?}");
}

/// The rank of the suspect of this file that offers this text instead.
fn rank(found: &[Value], file: &str, instead: &str) -> Option<usize> {
    let offer = format!("With `{instead}` in place of");
    let is_it = |it: &Value| {
        it["asset"]["file"] == file
            && it["asset"]["line"].is_u64()
            && it["explanation"]
                .as_str()
                .is_some_and(|words| words.contains(&offer))
    };
    found.iter().position(is_it).map(|place| place + 1)
}

/// The planted change, what is to stand there instead, and the rank that it has at the most.
fn is_named((file, old, new): (&str, &str, &str), instead: &str, most: usize) {
    let (_, found) = suspects(Some((file, old, new)));
    let rank = rank(&found, file, instead);
    assert!(
        rank.is_some_and(|rank| rank <= most),
        "`{instead}`, {rank:?}: {found:#?}"
    );
}

const VOCABULARY_FILE: &str = "vocabulary.toml";

#[test]
fn a_clause_that_is_joined_otherwise_is_named() {
    let right = "/crust.heat > 180 & /door.shut";
    is_named(
        (VOCABULARY_FILE, right, "/crust.heat > 180 | /door.shut"),
        right,
        2,
    );
}

#[test]
fn a_clause_that_is_negated_is_named() {
    let right = "/crust.heat > 180 & /door.shut";
    is_named(
        (VOCABULARY_FILE, right, "/crust.heat > 180 & !/door.shut"),
        right,
        2,
    );
}

#[test]
fn a_comparison_that_is_not_strict_is_named() {
    is_named(
        (VOCABULARY_FILE, "/blade.cuts > 0", "/blade.cuts >= 0"),
        "/blade.cuts > 0",
        2,
    );
}

#[test]
fn a_case_that_is_lacking_is_named() {
    is_named((VOCABULARY_FILE, "s=1 | s=3", "s=1"), "s=1 | s=3", 2);
}

#[test]
fn another_signal_is_named() {
    let right = "/crust.heat > 180 & /door.shut";
    is_named(
        (VOCABULARY_FILE, right, "/core.heat > 180 & /door.shut"),
        right,
        2,
    );
}

#[test]
fn a_scale_that_is_lacking_is_named() {
    let instead = "\"/csv.crust_dc\", scale = 0.1";
    is_named(("topics.toml", "\nscale = 0.1", ""), instead, 1);
}

#[test]
fn a_number_that_the_text_says_otherwise_is_named() {
    is_named((VOCABULARY_FILE, ">= 120", ">= 150"), "120", 1);
}

#[test]
fn a_word_that_the_text_says_otherwise_is_named() {
    let wrong = ("requirements.toml", "satisfy risen", "satisfy scorched");
    is_named(wrong, "risen", 1);
}

#[test]
fn recordings_are_named_by_their_folder_with_the_words_that_they_are_read_through() {
    // Crusts of 162 to 170 degrees that a sensor shows as 192 to 200, which no slip explains.
    let (text, found) = suspects(Some(("recordings/", "\n1,16", "\n1,19")));
    let of_recordings = found.iter().find(|it| it["asset"]["file"] == "recordings/");
    let suspect = of_recordings.unwrap_or_else(|| panic!("{found:#?}"));
    assert_eq!(suspect["asset"]["part"], "200 files");
    assert_eq!(
        suspect["asset"]["together"],
        serde_json::json!(["vocabulary.toml", "topics.toml"])
    );
    assert!(
        text.contains("witness: corroborate monitor . ./recordings/"),
        "{text}"
    );
}
