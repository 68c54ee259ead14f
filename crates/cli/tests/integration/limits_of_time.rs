//! What a limit of time says in a form that was written by hand: by then, until then, not before. A form that says another thing
//! with the same number has drifted, and one that says the same otherwise has not.

use serde_json::Value;
use support::program::corroborate;

use crate::support;

const STUDY: &str = r#"
title = "Limits of time"
summary = "One requirement, in several forms."
seed = 1
confidence = 0.95
agreement = 0.95
[conditions]
typical = "As usual."
[model]
step = "0.1 s"
units = { timer = "0.1 s" }
"#;

const WITHIN: &str = "Upon start the robot shall within 3 s satisfy done.";
const FOR: &str = "Upon start the robot shall for 3 s satisfy done.";
const AFTER: &str = "Upon start the robot shall after 3 s satisfy done.";

/// The kinds of drift of a requirement with this sentence, property and monitor; each may be empty. `timed` is this to the model.
fn drift(sentence: &str, property: &str, monitor: &str, timed: &str) -> Vec<(String, String)> {
    let folder = tempfile::TempDir::new().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
    };
    write("study.toml", STUDY);
    write("ledger.toml", "");
    let word = |name: &str, model: &str, trace: &str| {
        format!("[{name}]\nmeaning = \"{name}\"\nmodel = \"{model}\"\ntrace = \"{trace}\"\n")
    };
    let words = [
        word("start", "s=1", "/a.start"),
        word("done", "s=2", "/a.done"),
        word("mid", "s=3", "/a.mid"),
        word("timed", timed, "/a.done"),
    ];
    write("vocabulary.toml", &words.concat());
    let key = |name: &str, text: &str| match text {
        "" => String::new(),
        text => format!("{name} = '{text}'\n"),
    };
    let forms = [
        "[[requirement]]\nid = \"1\"\ntext = \"In time.\"\n".to_owned(),
        key("shall", sentence),
        key("property", property),
        monitor.to_owned(),
    ];
    write("requirements.toml", &forms.concat());
    let arguments = ["requirements", ".", "--format", "json"];
    let said = corroborate(folder.path(), &arguments);
    let report: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
    let all = report["drift"].as_array().expect("a list").iter();
    let text = |it: &Value| it.as_str().expect("a text").to_owned();
    all.map(|it| (text(&it["kind"]), text(&it["found"])))
        .collect()
}

fn of_property(sentence: &str, property: &str) -> Vec<(String, String)> {
    drift(sentence, property, "", "s=2 & timer<=30")
}

#[test]
fn a_bound_that_says_another_thing_with_the_same_number_has_drifted() {
    for (sentence, property, found) in [
        (
            WITHIN,
            r#"P=? [ G ("start" => (F>=30 "done")) ]"#,
            "not before 30 steps",
        ),
        (
            WITHIN,
            r#"P=? [ G ("start" => (F=30 "done")) ]"#,
            "not before 30 steps",
        ),
        (
            WITHIN,
            r#"P=? [ G<=30 ("start" => (F "done")) ]"#,
            "for 30 steps",
        ),
        (
            WITHIN,
            r#"P=? [ G ("start" => (G<=30 "done")) ]"#,
            "for 30 steps",
        ),
        (
            WITHIN,
            r#"P=? [ G ("start" => (F<=30 (F<=30 "done"))) ]"#,
            "behind another 30 steps",
        ),
        (
            WITHIN,
            r#"P=? [ G ("start" => (F<=30 ("mid" & (F<=30 "done")))) ]"#,
            "behind another",
        ),
        (
            WITHIN,
            r#"P=? [ G ("start" => !(F<=30 "done")) ]"#,
            "for 30 steps",
        ),
        (
            FOR,
            r#"P=? [ G ("start" => (F<=30 "done")) ]"#,
            "within 30 steps",
        ),
        (
            AFTER,
            r#"P=? [ G ("start" => (F<=30 "done")) ]"#,
            "within 30 steps",
        ),
    ] {
        let all = of_property(sentence, property);
        let is_found = all
            .iter()
            .any(|(kind, what)| kind == "limit" && what.contains(found));
        assert!(is_found, "{sentence} {property}: {all:?}");
    }
}

#[test]
fn a_bound_that_says_the_same_has_not() {
    for (sentence, property) in [
        (WITHIN, r#"P=? [ G ("start" => (F<=30 "done")) ]"#),
        (WITHIN, r#"P=? [ G ("start" => (true U<=30 "done")) ]"#),
        (WITHIN, r#"P=? [ G ("start" => !(G<=30 !"done")) ]"#),
        (WITHIN, r#"P=? [ !(F ("start" & (G<=30 !"done"))) ]"#),
        (FOR, r#"P=? [ G ("start" => (G<=30 "done")) ]"#),
        (
            AFTER,
            r#"P=? [ G ("start" => ((G<30 (!"done")) & (F=30 "done"))) ]"#,
        ),
    ] {
        assert_eq!(of_property(sentence, property), [], "{sentence} {property}");
    }
    // Two stages, each with its own limit.
    let stages = "Upon start the robot shall within 3 s satisfy mid, then within 3 s satisfy done.";
    let property = r#"P=? [ G ("start" => (F<=30 ("mid" & (F<=30 "done")))) ]"#;
    assert_eq!(of_property(stages, property), []);
}

/// A formula for traces is read likewise.
#[test]
fn windows_of_a_formula_are_told_apart() {
    let of = |window: &str| {
        let formula = format!("formula = \"always (start => eventually[{window}] done)\"\n");
        drift(WITHIN, "", &formula, "s=2")
    };
    assert_eq!(of("0 s, 3 s"), []);
    for window in ["3 s, inf", "3 s, 3 s"] {
        let all = of(window);
        assert!(
            all.iter()
                .any(|(_, found)| found.starts_with("not before 3 s")),
            "{window}: {all:?}"
        );
    }
}

/// A timer of the model counts whole steps.
#[test]
fn a_timer_with_a_unit_is_a_limit_however_it_is_written() {
    let property = r#"P=? [ G ("start" => (F "timed")) ]"#;
    let of = |timed: &str| drift(WITHIN, property, "", timed);
    for timed in [
        "s=2 & timer<=30",
        "s=2 & timer<31",
        "s=2 & !(timer>30)",
        "s=2 & !(timer>=31)",
        "s=2 & timer>0 & timer<=30",
    ] {
        assert_eq!(of(timed), [], "{timed}");
    }
    for timed in ["s=2 & timer<=20", "s=2 & timer<=31", "s=2 & timer<30"] {
        assert!(!of(timed).is_empty(), "{timed}");
    }
}

/// Without a sentence, property and monitor are held against each other.
#[test]
fn a_monitor_with_another_bound_than_the_property_is_told() {
    let property = r#"P=? [ G ("start" => (F<=30 "done")) ]"#;
    let monitor = |secs: u32| {
        format!(
            "monitor.when = \"start\"\nmonitor.then = [{{ wait_for = \"done\", within_secs = {secs} }}]\n"
        )
    };
    assert_eq!(drift("", property, &monitor(3), "s=2"), []);
    let other = drift("", property, &monitor(5), "s=2");
    assert!(
        other
            .iter()
            .any(|(kind, found)| kind == "limit" && found.contains("3 s")),
        "{other:?}"
    );
    let least = drift(
        "",
        r#"P=? [ G ("start" => (F>=30 "done")) ]"#,
        &monitor(3),
        "s=2",
    );
    assert!(
        least.iter().any(|(_, found)| found.contains("not before")),
        "{least:?}"
    );
}
