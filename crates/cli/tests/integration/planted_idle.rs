//! A model that declares or asks for what it never comes to: the line that was written otherwise is named, and what it leads to is
//! offered before any number that would make up for it.

use crate::support;

use support::planted::{LEDGER, Planted};

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "read"
text = "In at least 85 % of tries the label is read."
property = 'P=? [ F "readable" ]'
threshold = "at least 0.85"
margin = 0.04
[[requirement]]
id = "soon"
text = "In at least 50 % of tries the label is read at the first look."
property = 'P=? [ F<=1 "readable" ]'
threshold = "at least 0.5"
margin = 0.04
[[requirement]]
id = "sorted"
text = "In at least 70 % of tries the parcel comes to its belt."
property = 'P=? [ F "sorted" ]'
threshold = "at least 0.7"
margin = 0.04
"#;

const VOCABULARY: &str = r#"
[readable]
meaning = "The label has been read."
model = "s=read"
[sorted]
meaning = "The parcel is on its belt."
model = "s=belt"
"#;

const MODEL: &str = "dtmc
const int look = 0;
const int read = 1;
const int belt = 2;
const int floor = 3;
const double sees = 0.6;
module scanner
  s : [look..floor] init look;
  looks : [0..2] init 0;
  [] s=look & looks<2 -> sees : (s'=read) + 1-sees : (looks'=looks+1);
  [] s=look & looks=2 -> sees : (s'=read) + 1-sees : (s'=floor);
  [] s=read -> 0.9 : (s'=belt) + 0.1 : (s'=floor);
  [] s>=belt -> true;
endmodule
";

// 1 - 0.4^3 are read, 0.6 at the first look, nine in ten of them come to the belt.
const COUNTS: &str =
    "requirement,covered,passed,failed\nread,1000,936,64\nsoon,1000,600,400\nsorted,1000,842,158\n";

fn study(old: &str, new: &str) -> Planted {
    assert!(MODEL.contains(old), "the model has no `{old}`");
    let model = MODEL.replace(old, new);
    Planted::of_model_and_counts([REQUIREMENTS, VOCABULARY, &model, COUNTS])
}

fn first(old: &str, new: &str) -> (u64, String) {
    study(old, new).first_of_model()
}

#[test]
fn the_sound_model_accuses_nothing() {
    let folder = study("sees = 0.6", "sees = 0.6");
    assert_eq!(folder.json("diagnose")["suspects"], serde_json::json!([]));
    assert_eq!(folder.json("refine")["proposals"], serde_json::json!([]));
}

#[test]
fn a_counter_that_stops_before_the_end_of_its_range_goes_on() {
    let folder = |text: &str| {
        text.replace("looks<2", "looks<1")
            .replace("looks=2", "looks=1")
    };
    let (line, diff) = first(MODEL, &folder(MODEL));
    assert_eq!(line, 10, "{diff}");
    assert!(
        diff.contains("+  [] s=look & looks<2 ->") && diff.contains("+  [] s=look & looks=2 ->"),
        "{diff}"
    );
}

#[test]
fn a_counter_that_begins_within_its_range_begins_at_its_end() {
    let (line, diff) = first("looks : [0..2] init 0", "looks : [0..2] init 1");
    assert_eq!(line, 9, "{diff}");
    assert!(diff.contains("+  looks : [0..2] init 0;"), "{diff}");
}

#[test]
fn a_lost_repetition_is_put_back_where_a_guard_asks_for_it() {
    let (line, diff) = first("1-sees : (looks'=looks+1)", "1-sees : (s'=floor)");
    assert_eq!(line, 10, "{diff}");
    assert!(
        diff.contains("+  [] s=look & looks<2 -> sees : (s'=read) + 1-sees : (looks'=looks+1);"),
        "{diff}"
    );
}

#[test]
fn an_update_that_leads_elsewhere_is_named() {
    let (line, diff) = first(
        "0.9 : (s'=belt) + 0.1 : (s'=floor)",
        "0.9 : (s'=floor) + 0.1 : (s'=belt)",
    );
    assert_eq!(line, 12, "{diff}");
    assert!(diff.contains("+  [] s=read ->"), "{diff}");
}

/// What decides a failure that is told by a comparison is not read off the text, and is solved for all the same.
#[test]
fn a_number_of_a_failure_that_a_comparison_tells_is_solved_for() {
    let folder = study("sees = 0.6", "sees = 0.45");
    let modes = "\n[[failure_mode]]\nid = \"missed\"\nname = \"First look missed\"\nmeaning = \"The first look reads nothing.\"\n\
                 margin = 0.03\noccurs = 'P=? [ F \"again\" ]'\n";
    let word = "\n[again]\nmeaning = \"It looks again.\"\nmodel = \"looks>0\"\n";
    folder.write("requirements.toml", &format!("{REQUIREMENTS}{modes}"));
    folder.write("vocabulary.toml", &format!("{VOCABULARY}{word}"));
    let ledger = format!("{LEDGER}tables.failure_modes = \"modes.csv\"\n");
    folder.write("ledger.toml", &ledger);
    folder.write(
        "modes.csv",
        "mode,occurrences,opportunities\nmissed,400,1000\n",
    );
    folder.run();
    let titles = folder.titles();
    assert!(
        titles
            .first()
            .is_some_and(|it| it.contains("sees set to 0.6")),
        "{titles:?}"
    );
}
