//! A sentence whose timing, duration or condition is not what the requirement's text says: the phrase is named, and put right before any
//! number of a model. (What the text does not say, such as a scope, is told from other mistakes by several pieces alone.)

use crate::support;

use support::planted::Planted;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "clear"
text = "In at least 80 % of the crossings the tug is not passed nearer than two metres."
shall = "The tug shall with probability at least 0.8 never satisfy near."
margin = 0.03
[[requirement]]
id = "over"
text = "In at least 50 % of the crossings the tug is over the road within 5 s."
shall = "The tug shall with probability at least 0.5 within 5 s satisfy across."
margin = 0.03
[[requirement]]
id = "coupled"
text = "In at least 60 % of the crossings the dollies stay coupled on the road."
shall = "Whenever on_road, the tug shall with probability at least 0.6 immediately satisfy held."
margin = 0.03
"#;

const VOCABULARY: &str = r#"
[near]
meaning = "Somebody passes nearer than two metres."
model = "near"
[across]
meaning = "The tug has crossed."
model = "s=2"
[on_road]
meaning = "The tug is on the road."
model = "s=1"
[held]
meaning = "The dollies are coupled."
model = "held"
[ready]
meaning = "The tug stands at the kerb."
model = "s=0"
"#;

const MODEL: &str = "dtmc
module tug
  s : [0..2] init 0;
  near : bool init false;
  held : bool init true;
  [] s=0 -> 0.3 : (s'=0) + 0.56 : (s'=1) + 0.14 : (s'=1) & (held'=false);
  [] s=1 -> 0.9 : (s'=2) + 0.1 : (s'=2) & (near'=true);
  [] s=2 -> true;
endmodule
";

// 0.1 are passed near; 1 - 0.3^4 have entered after four steps and crossed after five; a fifth has lost the dollies by then.
const COUNTS: &str = "requirement,covered,passed,failed\nclear,2000,1800,200\nover,2000,1984,16\ncoupled,2000,1600,400\n";

fn study(old: &str, new: &str) -> Planted {
    assert!(REQUIREMENTS.contains(old), "no `{old}`");
    let requirements = REQUIREMENTS.replace(old, new);
    let folder = Planted::with_step(1.0);
    folder.complete([&requirements, VOCABULARY, MODEL, COUNTS]);
    folder
}

/// The first suspect's file and line, and the first offered diff.
fn first(old: &str, new: &str) -> (String, u64, String) {
    let folder = study(old, new);
    let diagnosis = folder.json("diagnose");
    let asset = &diagnosis["suspects"][0]["asset"];
    let offered = folder.json("refine");
    let diff = offered["proposals"][0]["diff"].as_str().unwrap_or_default();
    (
        asset["file"].as_str().unwrap_or_default().to_owned(),
        asset["line"].as_u64().unwrap_or_default(),
        diff.to_owned(),
    )
}

#[test]
fn a_sound_study_accuses_nothing_and_offers_nothing() {
    let folder = study("never", "never");
    assert_eq!(folder.json("diagnose")["suspects"], serde_json::json!([]));
    assert_eq!(folder.json("refine")["proposals"], serde_json::json!([]));
}

#[test]
fn a_timing_that_the_text_denies_is_put_right() {
    let (file, line, diff) = first("never satisfy near", "eventually satisfy near");
    assert_eq!((file.as_str(), line), ("requirements.toml", 5), "{diff}");
    assert!(
        diff.contains(
            "+shall = \"The tug shall with probability at least 0.8 never satisfy near.\""
        )
    );
}

#[test]
fn a_duration_that_the_text_says_otherwise_is_put_right() {
    let (file, line, diff) = first("0.5 within 5 s", "0.5 within 2 s");
    assert_eq!((file.as_str(), line), ("requirements.toml", 10), "{diff}");
    assert!(diff.contains(
        "+shall = \"The tug shall with probability at least 0.5 within 5 s satisfy across.\""
    ));
}

#[test]
fn a_condition_that_the_text_names_takes_the_place_of_another() {
    let (file, line, diff) = first("Whenever on_road", "Whenever ready");
    assert_eq!((file.as_str(), line), ("requirements.toml", 15), "{diff}");
    assert!(
        diff.contains("+shall = \"Whenever on_road, the tug"),
        "{diff}"
    );
}
