//! Slips with which a property has one truth value whatever the model does, with which nothing triggers it, or which no value of
//! another kind shows: another word, another trigger, another bound, another beginning, two branches written as one. Two tables of
//! totals say what is right, so that `diagnose` names the line and `refine` offers what it should be.

use crate::support;

use serde_json::Value;
use support::planted::Planted;

const STUDY: &str = r#"
title = "A kiosk that hands out medicine"
summary = "A model, a simulation's totals and trials that were counted."
seed = 1
confidence = 0.95
agreement = 0.95
sample_sizes = "fixed"
[conditions]
hall = "In the hall."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "served"
text = "At least 50 % of those who ask are served."
threshold = "at least 0.5"
margin = 0.05
property = 'P=? [ F "served" ]'
[[requirement]]
id = "prompt"
text = "At least 30 % of those who ask are served promptly."
threshold = "at least 0.3"
margin = 0.05
property = 'P=? [ F<=2 "served" ]'
[[requirement]]
id = "mended"
text = "Who meets a jam is served all the same in at least 40 % of all cases."
threshold = "at least 0.4"
margin = 0.08
property = 'P=? [ F "served" ]'
trigger = 'P=? [ F "jammed" ]'
[[failure_mode]]
id = "jam"
name = "Jam"
meaning = "The drawer is jammed; counted for each who asks."
margin = 0.05
occurs = 'P=? [ F "jammed" ]'
[[failure_mode]]
id = "balk"
name = "Balk"
meaning = "Somebody balks at the queue; counted for each who asks."
margin = 0.05
occurs = 'P=? [ F "balked" ]'
[[failure_mode]]
id = "left"
name = "Left"
meaning = "Somebody leaves without medicine; counted for each who asks."
margin = 0.05
occurs = 'P=? [ F "left" ]'
"#;

const VOCABULARY: &str = r#"
[served]
meaning = "the medicine is handed out"
model = "s=2"
[jammed]
meaning = "the drawer is jammed"
model = "s=3"
[balked]
meaning = "somebody left at once"
model = "s=5"
[left]
meaning = "somebody left without medicine"
model = "gone"
"#;

const LEDGER: &str = r#"
[[evidence]]
id = "M"
title = "A model"
technique = "model-checking"
conditions = "hall"
model = "model.prism"
changed = "The first."
[[evidence]]
id = "S"
title = "A simulation"
technique = "simulation"
conditions = "hall"
tables.requirements = "simulated.csv"
tables.failure_modes = "simulated_failures.csv"
changed = "The first."
[[evidence]]
id = "T"
title = "Trials"
technique = "experiment"
conditions = "hall"
tables.requirements = "counted.csv"
tables.failure_modes = "counted_failures.csv"
changed = "Counted by hand."
"#;

const MODEL: &str = "dtmc
const double pJam = 0.2;
const double pBalk = 0.3;
formula gone = s=4 | s=5;
module kiosk
  s : [0..5] init 0; // asked, opens, served, jammed, gives up, balks
  [] s=0 -> 1-pJam-pBalk : (s'=1) + pJam : (s'=3) + pBalk : (s'=5);
  [] s=1 -> 0.75 : (s'=2) + 0.25 : (s'=1);
  [] s=3 -> 0.6 : (s'=1) + 0.4 : (s'=4);
  [] s=2 | s=4 | s=5 -> true;
endmodule
";

/// What `diagnose` and `refine` say with one text replaced in a file.
fn said(change: Option<(&str, &str, &str)>) -> (Value, Value) {
    let folder = Planted::new();
    for (name, text) in [
        ("study.toml", STUDY),
        ("requirements.toml", REQUIREMENTS),
        ("vocabulary.toml", VOCABULARY),
        ("ledger.toml", LEDGER),
        ("model.prism", MODEL),
        (
            "simulated.csv",
            "requirement,covered,passed,failed\nserved,1000,623,377\nprompt,1000,381,619\nmended,196,115,81\n",
        ),
        (
            "simulated_failures.csv",
            "mode,occurrences,opportunities\njam,196,1000\nbalk,304,1000\nleft,377,1000\n",
        ),
        (
            "counted.csv",
            "requirement,covered,passed,failed\nserved,600,369,231\nprompt,600,228,372\nmended,123,76,47\n",
        ),
        (
            "counted_failures.csv",
            "mode,occurrences,opportunities\njam,123,600\nbalk,177,600\nleft,231,600\n",
        ),
    ] {
        let mut text = text.to_owned();
        if let Some((file, old, new)) = change.filter(|(file, ..)| *file == name) {
            assert!(text.contains(old), "{file} has no `{old}`");
            text = text.replacen(old, new, 1);
        }
        folder.write(name, &text);
    }
    folder.run();
    (folder.json("diagnose"), folder.json("refine"))
}

/// The line of a text in a file of the study.
fn line_of(file: &str, text: &str) -> u64 {
    let whole = match file {
        "requirements.toml" => REQUIREMENTS,
        "vocabulary.toml" => VOCABULARY,
        _ => MODEL,
    };
    let at = whole.find(text).expect("it is there");
    whole[..at].matches('\n').count() as u64 + 1
}

/// The first suspect is the line that was changed, and the first proposal puts back what was there.
fn is_found((file, old, new): (&str, &str, &str)) {
    let (diagnosis, offered) = said(Some((file, old, new)));
    let first = &diagnosis["suspects"][0]["asset"];
    assert_eq!(first["file"], file, "{new}: {diagnosis:#}");
    assert_eq!(first["line"], line_of(file, old), "{new}: {diagnosis:#}");
    let diff = offered["proposals"][0]["diff"].as_str().unwrap_or_default();
    let added: String = diff.lines().filter(|it| it.starts_with('+')).collect();
    let plain = |text: &str| text.split_whitespace().collect::<String>();
    assert!(plain(&added).contains(&plain(old)), "{new}: {offered:#}");
}

#[test]
fn a_study_that_is_right_accuses_nobody() {
    let (diagnosis, _) = said(None);
    let all = diagnosis["suspects"].as_array().expect("a list");
    let strong = all.iter().filter(|it| it["score"].as_f64() > Some(1.0));
    assert_eq!(strong.count(), 0, "{diagnosis:#}");
}

#[test]
fn an_inverted_word_that_makes_a_property_constant_is_named() {
    is_found(("vocabulary.toml", "model = \"s=3\"", "model = \"s!=3\""));
    is_found(("vocabulary.toml", "model = \"s=2\"", "model = \"s!=2\""));
}

#[test]
fn a_word_of_the_state_in_which_the_model_begins_is_named() {
    is_found(("vocabulary.toml", "model = \"s=5\"", "model = \"s=0\""));
}

#[test]
fn a_beginning_that_makes_a_property_constant_is_named() {
    is_found(("model.prism", "[0..5] init 0", "[0..5] init 3"));
}

#[test]
fn an_operator_that_makes_a_property_constant_is_named() {
    is_found((
        "model.prism",
        "formula gone = s=4 | s=5",
        "formula gone = s=4 & s=5",
    ));
}

#[test]
fn a_trigger_of_another_word_is_named() {
    is_found((
        "requirements.toml",
        "trigger = 'P=? [ F \"jammed\" ]'",
        "trigger = 'P=? [ F \"balked\" ]'",
    ));
}

#[test]
fn a_bound_that_no_text_says_is_named() {
    is_found(("requirements.toml", "F<=2 \"served\"", "F<=7 \"served\""));
}

#[test]
fn two_branches_that_were_written_as_one_are_divided() {
    is_found((
        "model.prism",
        "pJam : (s'=3) + pBalk : (s'=5)",
        "pJam+pBalk : (s'=3)",
    ));
}

#[test]
fn what_no_update_leads_to_and_triggers_a_requirement_is_led_to() {
    is_found(("model.prism", "pJam : (s'=3)", "pJam : (s'=1)"));
}
