//! What contradicts itself before any rate is compared: a model in which something cannot come of which people counted trials, and a
//! table with more trials than attempts.

use crate::support;

use serde_json::Value;
use support::planted::Planted;
use support::program::corroborate;

const STUDY: &str = r#"
title = "A gate that lets carts through"
summary = "A model, and carts that were counted."
seed = 1
confidence = 0.95
agreement = 0.95
sample_sizes = "fixed"
[conditions]
yard = "A yard."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "through"
text = "At least 70 % of carts come through."
property = 'P=? [ F "through" ]'
margin = 0.1
threshold = "at least 0.7"
experiment = "through"
[[failure_mode]]
id = "stuck"
name = "Cart stuck"
meaning = "A cart that was weighed gets stuck."
margin = 0.08
occurs = 'P=? [ F "stuck" ]'
opportunity = 'P=? [ F "weighed" ]'
experiment = "stuck"
"#;

const LEDGER: &str = r#"
[[evidence]]
id = "M"
title = "A model"
technique = "model-checking"
conditions = "yard"
model = "model.prism"
changed = "The first."
[[evidence]]
id = "T"
title = "Carts"
technique = "experiment"
conditions = "yard"
tables.cohort = "carts.csv"
tables.failure_modes = "modes.csv"
changed = "Counted by hand."
"#;

const MODEL: &str = "dtmc
module cart
  s : [0..4] init 0;
  [] s=0 -> 0.9 : (s'=1) + 0.1 : (s'=2);
  [] s=1 -> 0.85 : (s'=2) + 0.15 : (s'=3);
  [] s>1 -> true;
endmodule
";

/// The study with a word for what is weighed and so many that got stuck of so many that were, run.
fn study(weighed: &str, stuck: usize, of: usize) -> Planted {
    study_of(MODEL, weighed, stuck, of)
}

fn study_of(model: &str, weighed: &str, stuck: usize, of: usize) -> Planted {
    let folder = Planted::new();
    let words = format!(
        "[through]\nmeaning = \"it is through\"\nmodel = \"s=2\"\ncolumn = \"through\"\n[weighed]\nmeaning = \"it is weighed\"\n\
         model = \"{weighed}\"\n[stuck]\nmeaning = \"it is stuck\"\nmodel = \"s=3\"\ncolumn = \"modes: S\"\n"
    );
    // Those who got stuck are spread evenly over the days.
    let of_day = |day: usize| "S ".repeat(stuck * (day + 1) / 20 - stuck * day / 20);
    let carts: String = (0..20)
        .map(|day| format!("D{day},17,20,{}\n", of_day(day).trim_end()))
        .collect();
    for (name, text) in [
        ("study.toml", STUDY),
        ("requirements.toml", REQUIREMENTS),
        ("vocabulary.toml", &words),
        ("ledger.toml", LEDGER),
        ("model.prism", model),
        ("carts.csv", &format!("day,through,attempts,modes\n{carts}")),
        (
            "modes.csv",
            &format!("mode,occurrences,opportunities\nstuck,{stuck},{of}\n"),
        ),
    ] {
        folder.write(name, text);
    }
    folder.run();
    folder
}

/// The comparison of the model and the carts on the failure.
fn on_stuck(folder: &Planted) -> Value {
    let compared = folder.json("compare");
    let pairs = compared["comparisons"].as_array().expect("a list");
    let mut own = pairs.iter().filter(|it| it["subject"]["id"] == "stuck");
    own.next().cloned().unwrap_or_else(|| panic!("{compared}"))
}

fn exit_code(folder: &Planted) -> i32 {
    corroborate(folder.path(), &["run", ".", "--quiet"]).code
}

#[test]
fn what_a_model_excludes_and_people_counted_is_a_conflict() {
    let sound = study("s=1", 54, 360);
    assert_eq!(on_stuck(&sound)["outcome"], "corroborates");
    assert_eq!(exit_code(&sound), 0);

    let folder = study("s=4", 54, 360);
    let pair = on_stuck(&folder);
    assert_eq!(pair["outcome"], "conflicts", "{pair}");
    assert!(pair["difference"].is_null(), "{pair}");
    let reason = pair["reason"].as_str().unwrap_or_default();
    let said = "In M no run gives it an opportunity, for certain, and T counts 360 opportunities";
    assert!(reason.starts_with(said), "{reason}");
    assert_eq!(exit_code(&folder), 1);

    let suspects = &folder.json("diagnose")["suspects"];
    let first = &suspects[0];
    assert_eq!(first["asset"]["file"], "model.prism", "{suspects}");
    let together = first["asset"]["together"].to_string();
    assert!(together.contains("vocabulary.toml"), "{suspects}");
    let title = first["title"].as_str().unwrap_or_default();
    assert_eq!(title, "M never gives stuck an opportunity");
    // Page and terminal say it as it is: there is no difference to tell.
    let page = support::read(&folder.path().join("results/report.html"));
    assert!(page.contains("what happened is not impossible"));
    assert!(!page.contains("they differ by 0 points"));
}

/// A counter that begins at its end excludes all; that it begins at its beginning explains all, which other changes do in part, one of
/// them with more weight.
#[test]
fn what_explains_all_that_is_excluded_is_offered() {
    let tries = |first: u8| {
        format!(
            "dtmc
module cart
  s : [0..4] init 0;
  tries : [0..3] init {first};
  [] s=0 & tries<3 -> 0.7 : (s'=1) + 0.3 : (tries'=tries+1);
  [] s=0 & tries=3 -> (s'=4);
  [] s=1 -> 0.85 : (s'=2) + 0.15 : (s'=3);
  [] s>1 -> true;
endmodule
"
        )
    };
    let sound = study_of(&tries(0), "s=1", 54, 360);
    assert_eq!(exit_code(&sound), 0);
    let folder = study_of(&tries(3), "s=1", 54, 360);
    let titles = folder.titles();
    assert!(
        titles
            .iter()
            .any(|it| it.starts_with("M: `tries` begins with 0")),
        "{titles:?}"
    );
}

/// The same of a requirement, on which no conclusion rests on the model: the study does not hold all the same.
#[test]
fn a_requirement_that_the_model_never_triggers_is_no_agreement() {
    let folder = study("s=4", 54, 360);
    let requirements = REQUIREMENTS.replace(
        "property = 'P=? [ F \"through\" ]'",
        "property = 'P=? [ F \"through\" ]'\ntrigger = 'P=? [ F \"weighed\" ]'",
    );
    let mode = requirements.find("[[failure_mode]]").expect("a mode");
    folder.write("requirements.toml", &requirements[..mode]);
    let ledger = LEDGER.replace("tables.failure_modes = \"modes.csv\"\n", "");
    folder.write("ledger.toml", &ledger);
    folder.run();
    // Nothing says that any of the carts was weighed.
    let pair = folder.json("compare")["comparisons"][0].clone();
    assert_eq!(pair["outcome"], "not-comparable", "{pair}");
    assert_eq!(exit_code(&folder), 3);
    let words = support::read(&folder.path().join("vocabulary.toml"));
    let words = words.replace("[stuck]", "column = \"weighed\"\n[stuck]");
    folder.write("vocabulary.toml", &words);
    let carts = support::read(&folder.path().join("carts.csv"));
    let carts = carts
        .replace("attempts,", "attempts,weighed,")
        .replace(",20,", ",20,18,");
    folder.write("carts.csv", &carts);
    folder.run();
    let pair = folder.json("compare")["comparisons"][0].clone();
    assert_eq!(pair["outcome"], "conflicts", "{pair}");
    assert_eq!(exit_code(&folder), 1);
    let page = support::read(&folder.path().join("results/report.html"));
    assert!(!page.contains("nothing conflicts"));
}

/// A trigger whose bound is too short for the model: the conflict says so.
#[test]
fn what_only_the_bound_of_its_trigger_excludes_is_said_with_its_share() {
    let folder = study("s=1", 54, 360);
    let requirements = REQUIREMENTS.replace("P=? [ F \"weighed\" ]", "P=? [ F<=0 \"weighed\" ]");
    folder.write("requirements.toml", &requirements);
    folder.run();
    assert_eq!(on_stuck(&folder)["outcome"], "conflicts");
    let found = folder.findings("M");
    let reason = "In the model, the opportunity has probability 0 within the bound of `F<=0 \"weighed\"`; without the bound it is 90 %.";
    assert_eq!(found[1]["measure"]["reason"], reason, "{found:?}");
}

/// None of 30 is counted, and held: that it never comes is not computed of the model, but written into it.
#[test]
fn a_constant_that_is_held_at_none_of_thirty_excludes_nothing() {
    let model = "dtmc
const double heavy = 0;
module cart
  s : [0..4] init 0;
  [] s=0 -> heavy : (s'=1) + (1-heavy) : (s'=2);
  [] s=1 -> 0.85 : (s'=2) + 0.15 : (s'=3);
  [] s>1 -> true;
endmodule
";
    let folder = study_of(model, "s=1", 54, 360);
    assert_eq!(on_stuck(&folder)["outcome"], "conflicts");
    folder.write("heavy.csv", "mode,occurrences,opportunities\nheavy,0,30\n");
    let mode =
        "[[failure_mode]]\nid = \"heavy\"\nname = \"Heavy\"\nmeaning = \"It is to be weighed.\"\n";
    folder.write("requirements.toml", &format!("{REQUIREMENTS}{mode}"));
    let counted = "[[evidence]]\nid = \"W\"\ntitle = \"Weighing\"\ntechnique = \"experiment\"\nconditions = \"yard\"\n\
                   tables.failure_modes = \"heavy.csv\"\nchanged = \"Counted.\"\n";
    let set = "model = \"model.prism\"\ncalibrated = [{ constant = \"heavy\", from = \"W\", failure_mode = \"heavy\", held = true }]";
    let ledger = LEDGER.replace("model = \"model.prism\"", set);
    folder.write("ledger.toml", &format!("{counted}{ledger}"));
    folder.run();
    let pair = on_stuck(&folder);
    assert_eq!(pair["outcome"], "not-comparable", "{pair}");
    let found = folder.findings("M");
    let reason = found[1]["measure"]["reason"].as_str().unwrap_or_default();
    assert!(
        reason.contains("because `heavy` is held at what was counted"),
        "{found:?}"
    );
}

/// A model that is never asked, or of which it is not known that the probability is 0, is not refuted.
#[test]
fn what_nobody_counted_is_no_conflict() {
    let folder = study("s=4", 0, 0);
    let pair = on_stuck(&folder);
    assert_eq!(pair["outcome"], "not-comparable", "{pair}");
    assert_eq!(exit_code(&folder), 0);
}

#[test]
fn a_table_with_more_trials_than_attempts_is_suspected_before_the_model() {
    let folder = study("s=1", 54, 3600);
    assert_eq!(on_stuck(&folder)["outcome"], "conflicts");
    let suspects = &folder.json("diagnose")["suspects"];
    let first = &suspects[0]["asset"];
    assert_eq!(
        (&first["file"], &first["line"]),
        (&"modes.csv".into(), &2.into()),
        "{suspects}"
    );
    // What the model could be changed to waits for that.
    let offered = folder.json("refine");
    for proposal in offered["proposals"].as_array().expect("a list") {
        assert_eq!(proposal["needs_decision"], true, "{proposal}");
    }
    // One that conflicts with nothing is not accused.
    let sound = study("s=1", 66, 440);
    assert_eq!(on_stuck(&sound)["outcome"], "corroborates");
    assert_eq!(sound.json("diagnose")["suspects"], serde_json::json!([]));
}
