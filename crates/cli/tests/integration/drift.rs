//! The study whose hand-written forms drifted from its sentences: each drift and each difference is found, nothing
//! else is, and fixing one form makes exactly what was said of that form go.

use crate::support;

use serde_json::Value;
use std::collections::BTreeSet;
use support::program::corroborate;
use support::{files_below, read, root};
use tempfile::TempDir;

/// What was planted, as (requirement, form, kind, a part of what is found, a part of what is declared).
const DRIFT: [(&str, &str, &str, &str, &str); 8] = [
    ("4", "simulation", "limit", "5 s", "release_time = 2 s"),
    (
        "4",
        "simulation",
        "clock",
        "/clock.wall",
        "recording's time",
    ),
    ("6", "simulation", "shape", "abs(", "distance("),
    ("8", "experiment", "limit", "20 cm", "near_distance = 0.1 m"),
    ("8", "experiment", "shape", "abs(", "distance("),
    ("8", "simulation", "limit", "5 cm", "near_distance = 0.1 m"),
    ("8", "simulation", "shape", "abs(", "distance("),
    (
        "8",
        "simulation",
        "instant",
        "previous hand_slow",
        "instant",
    ),
];

/// The recordings on which a form answers otherwise than the sentence, as (requirement, form, recording, the
/// sentence's verdict, the form's). Only `agrees.csv` is not among them.
const DIFFERENCES: [(&str, &str, &str, &str, &str); 6] = [
    ("6", "simulation", "closing_beside", "satisfied", "violated"),
    (
        "8",
        "experiment",
        "fast_below_in_the_tall_box",
        "not-covered",
        "violated",
    ),
    (
        "8",
        "simulation",
        "fast_beside_the_small_box",
        "violated",
        "not-covered",
    ),
    (
        "8",
        "simulation",
        "fast_in_the_small_box",
        "violated",
        "satisfied",
    ),
    ("4", "simulation", "late_release", "violated", "satisfied"),
    ("4", "simulation", "slow_computer", "satisfied", "violated"),
];

/// A text of a file that is replaced: the file, the old text, the new one.
type Change = (&'static str, &'static str, &'static str);

/// Forms fixed: what is replaced by what in which file, and the form that is then without drift and differences.
const MENDED: [(&[Change], &str, &str); 4] = [
    (
        &[
            ("requirements.toml", "within_secs = 5", "within_secs = 2"),
            ("requirements.toml", "clock = \"/clock.wall\"\n", ""),
        ],
        "4",
        "simulation",
    ),
    (
        &[("requirements.toml", "person_clear_by_axis", "person_clear")],
        "6",
        "simulation",
    ),
    (
        &[(
            "requirements.toml",
            "rise(in_small_box) => previous hand_slow",
            "near => hand_slow",
        )],
        "8",
        "simulation",
    ),
    (
        &[(
            "requirements.toml",
            "in_tall_box => hand_slow",
            "near => hand_slow",
        )],
        "8",
        "experiment",
    ),
];

type Key = (String, String, String);

/// The study in a folder of its own, with texts replaced.
fn study(changes: &[(&str, &str, &str)]) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let from = root().join("conformance/drift");
    for file in files_below(&from) {
        let name = file.strip_prefix(&from).expect("below it");
        let to = folder.path().join(name);
        std::fs::create_dir_all(to.parent().expect("a folder")).expect("made");
        std::fs::copy(&file, to).expect("copied");
    }
    for (file, old, new) in changes {
        let path = folder.path().join(file);
        let text = read(&path);
        assert!(text.contains(old), "`{old}` is no longer in {file}");
        std::fs::write(&path, text.replacen(old, new, 1)).expect("written");
    }
    folder
}

/// What `requirements` reports of the study, and its exit code.
fn reported(changes: &[(&str, &str, &str)]) -> (Value, i32) {
    let folder = study(changes);
    let arguments = ["requirements", ".", "recordings", "--format", "json"];
    let said = corroborate(folder.path(), &arguments);
    let report = serde_json::from_str(&said.out);
    (
        report.unwrap_or_else(|error| panic!("{error}: {said:?}")),
        said.code,
    )
}

fn list<'a>(report: &'a Value, name: &str) -> &'a [Value] {
    let list = report[name].as_array();
    list.unwrap_or_else(|| panic!("no list {name} in {report}"))
}

fn keys(report: &Value, name: &str, third: &str) -> BTreeSet<Key> {
    let text = |value: &Value| value.as_str().expect("a text").to_owned();
    let keys = list(report, name);
    keys.iter()
        .map(|v| (text(&v["requirement"]), text(&v["form"]), text(&v[third])))
        .collect()
}

/// All that is said against the hand-written forms.
fn findings(report: &Value) -> BTreeSet<Key> {
    let mut all = keys(report, "drift", "kind");
    all.extend(keys(report, "differences", "recording"));
    all
}

fn says(value: &Value, part: &str) -> bool {
    value.as_str().is_some_and(|text| text.contains(part))
}

#[test]
fn each_planted_drift_is_found_and_nothing_else() {
    let (report, code) = reported(&[]);
    assert_eq!(code, 1);
    let found = list(&report, "drift");
    for (requirement, form, kind, seen, declared) in DRIFT {
        let hits = found.iter().filter(|drift| {
            drift["requirement"] == requirement
                && drift["form"] == form
                && drift["kind"] == kind
                && says(&drift["found"], seen)
                && says(&drift["declared"], declared)
        });
        assert_eq!(hits.count(), 1, "{requirement} {form} {kind}: {found:#?}");
    }
    assert_eq!(found.len(), DRIFT.len(), "{found:#?}");
}

#[test]
fn each_recording_shows_its_difference_and_one_shows_none() {
    let (report, _) = reported(&[]);
    let recordings = list(&report, "recordings");
    assert_eq!(recordings.len(), DIFFERENCES.len() + 1);
    assert!(recordings.iter().any(|name| says(name, "agrees.csv")));
    let found = list(&report, "differences");
    for (requirement, form, recording, sentence, verdict) in DIFFERENCES {
        let hits = found.iter().filter(|difference| {
            difference["requirement"] == requirement
                && difference["form"] == form
                && says(&difference["recording"], &format!("{recording}.csv"))
                && difference["reference"] == "sentence"
                && difference["reference_verdict"] == sentence
                && difference["verdict"] == verdict
        });
        assert_eq!(hits.count(), 1, "{recording}: {found:#?}");
    }
    assert_eq!(found.len(), DIFFERENCES.len(), "{found:#?}");
}

#[test]
fn mending_a_form_makes_exactly_what_was_said_of_it_go() {
    let before = findings(&reported(&[]).0);
    for (changes, requirement, form) in MENDED {
        let (report, code) = reported(changes);
        assert_eq!(code, 1, "the others still drift");
        let mut left = before.clone();
        left.retain(|(r, f, _)| r != requirement || f != form);
        assert!(left.len() < before.len());
        assert_eq!(findings(&report), left, "{requirement}, {form}");
    }
}

#[test]
fn mending_one_thing_of_a_form_leaves_its_other_drift() {
    let before = keys(&reported(&[]).0, "drift", "kind");
    let changes = [("requirements.toml", "within_secs = 5", "within_secs = 2")];
    let mut left = before;
    assert!(left.remove(&("4".into(), "simulation".into(), "limit".into())));
    assert_eq!(keys(&reported(&changes).0, "drift", "kind"), left);
}

#[test]
fn mended_throughout_the_study_has_no_drift() {
    let changes: Vec<_> = MENDED.iter().flat_map(|mended| mended.0).copied().collect();
    let (report, code) = reported(&changes);
    assert_eq!(findings(&report), BTreeSet::new());
    assert_eq!(code, 0, "{report}");
}

/// The fixed study with another form of requirement 8 for the simulation, or with requirements more.
fn mended_but(formula: &str, more: &str) -> (Value, i32) {
    let mended = MENDED.iter().flat_map(|mended| mended.0);
    let mut changes: Vec<(&str, &str, &str)> = mended.copied().collect();
    changes.push(("requirements.toml", "always (near => hand_slow)", formula));
    let beginning = "[[requirement]]\nid = \"4\"";
    let with_more = format!("{more}\n{beginning}");
    changes.push(("requirements.toml", beginning, &with_more));
    reported(&changes)
}

/// The kinds of what the fixed study is told if requirement 8 is written as `formula` for the simulation.
fn told_of(formula: &str) -> (Vec<String>, Vec<String>) {
    let (report, _) = mended_but(formula, "");
    let kinds = |name| {
        let all = list(&report, name).iter();
        all.map(|found| {
            assert_eq!(
                (&found["requirement"], &found["form"]),
                (&"8".into(), &"simulation".into())
            );
            found["kind"].as_str().expect("a kind").to_owned()
        })
        .collect()
    };
    (kinds("drift"), kinds("hints"))
}

#[test]
fn a_limit_that_itself_counts_to_the_other_side_is_drift_however_it_is_negated() {
    let nothing: (Vec<String>, Vec<String>) = Default::default();
    let other = (vec!["boundary".to_owned()], vec![]);
    for (form, expected) in [
        (
            "always (near => /robot.hand_speed <= reduced_speed)",
            &other,
        ),
        ("always (near => !(/robot.hand_speed > 0.25 m/s))", &other),
        (
            "always (near => !(reduced_speed < /robot.hand_speed))",
            &other,
        ),
        ("always (near => /robot.hand_speed < 25 cm/s)", &nothing),
        (
            "always (near => !(/robot.hand_speed >= reduced_speed))",
            &nothing,
        ),
        (
            "always (near => reduced_speed > /robot.hand_speed)",
            &nothing,
        ),
    ] {
        assert_eq!(&told_of(form), expected, "{form}");
    }
}

#[test]
fn a_limit_that_is_left_out_is_drift_unless_a_flag_may_hold_it() {
    for (form, expected) in [
        ("always near", vec!["left-out"]),
        (
            "always (near => distance(/robot.hand, /human.hand) > 0 m)",
            vec!["limit", "left-out"],
        ),
        ("always (near => /robot.closing)", vec![]),
    ] {
        assert_eq!(
            told_of(form),
            (expected.iter().map(|k| (*k).to_owned()).collect(), vec![]),
            "{form}"
        );
    }
}

#[test]
fn a_number_without_a_unit_is_a_hint_if_it_is_the_limit_and_drift_if_it_is_not() {
    let told = |drift: &[&str], hints: &[&str]| {
        let owned = |kinds: &[&str]| kinds.iter().map(|k| (*k).to_owned()).collect::<Vec<_>>();
        (owned(drift), owned(hints))
    };
    let hand = "abs(/robot.hand.x - /human.hand.x)";
    for (form, expected) in [
        (
            "always (near => /robot.hand_speed < 0.25)".to_owned(),
            told(&[], &["unit"]),
        ),
        (
            "always (near => /robot.hand_speed < 0.3)".into(),
            told(&["limit"], &[]),
        ),
        (
            format!("always ({hand} < 0.1 => hand_slow)"),
            told(&["shape"], &["unit"]),
        ),
    ] {
        let mut found = told_of(&form);
        let mut expected = expected;
        found.0.sort();
        expected.0.sort();
        assert_eq!(found, expected, "{form}");
    }
}

/// A requirement of a box of two sizes, and of two waits; a form of each in which the two are exchanged.
const EXCHANGED: &str = r#"
[[requirement]]
id = "box"
text = "In the tall box the hand is slow."
shall = "Whenever in_tall_box the robot shall immediately satisfy hand_slow."
[requirement.reading.lying]
meaning = "The box lies on its side."
formula = """always (abs(/robot.hand.x - /human.hand.x) < 20 cm & abs(/robot.hand.y - /human.hand.y) < 10 cm \
& abs(/robot.hand.z - /human.hand.z) < 10 cm => hand_slow)"""
[requirement.reading.standing]
meaning = "As required."
formula = """always (abs(/robot.hand.x - /human.hand.x) < 0.1 m & abs(/robot.hand.y - /human.hand.y) < 10 cm \
& abs(/robot.hand.z - /human.hand.z) < 200 mm => hand_slow)"""
[requirement.reading.flat]
meaning = "Without its height."
formula = """always (abs(/robot.hand.x - /human.hand.x) < 0.1 m & abs(/robot.hand.y - /human.hand.y) < 10 cm \
=> hand_slow)"""

[[requirement]]
id = "waits"
text = "Released in time, then closed."
shall = "Upon sensors_satisfied the robot shall within release_time satisfy released, then within 5 s satisfy hand_closing."
[requirement.reading.exchanged]
meaning = "The times are exchanged."
monitor.when = "sensors_satisfied"
monitor.then = [{ wait_for = "released", within_secs = 5 }, { wait_for = "hand_closing", within_secs = 2 }]
[requirement.reading.same]
meaning = "As required."
monitor.when = "sensors_satisfied"
monitor.then = [{ wait_for = "released", within_secs = 2 }, { wait_for = "hand_closing", within_secs = 5 }]
[requirement.reading.endless]
meaning = "Without the second time."
monitor.when = "sensors_satisfied"
monitor.then = [{ wait_for = "released", within_secs = 2 }, { wait_for = "hand_closing" }]
"#;

#[test]
fn limits_of_one_dimension_that_are_exchanged_are_drift() {
    let (report, _) = mended_but("always (near => hand_slow)", EXCHANGED);
    let mut found: Vec<Key> = keys(&report, "drift", "kind").into_iter().collect();
    found.sort();
    let key =
        |requirement: &str, form: &str, kind: &str| (requirement.into(), form.into(), kind.into());
    let expected: [Key; 4] = [
        key("box", "flat", "left-out"),
        key("box", "lying", "limit"),
        key("waits", "endless", "left-out"),
        key("waits", "exchanged", "limit"),
    ];
    assert_eq!(found, expected, "{report:#}");
    let of_box = list(&report, "drift")
        .iter()
        .filter(|d| d["form"] == "lying");
    assert_eq!(of_box.count(), 2, "x and z: {report:#}");
}

/// The property by which requirement 4 is asked of the model, and the declared duration of a step.
const PROPERTY: &str = "(F \"released_within_limit\")";
const STEP: &str = "step = \"0.1 s\"\n";

/// The drift of the property of requirement 4: kind, what is found, what is declared, place and remedy.
fn of_property(changes: &[(&str, &str, &str)]) -> Vec<[String; 5]> {
    let (report, _) = reported(changes);
    let own = list(&report, "drift").iter();
    let own = own.filter(|it| it["requirement"] == "4" && it["form"] == "property");
    let text = |it: &Value, key: &str| it[key].as_str().expect("a text").to_owned();
    let keys = ["kind", "found", "declared", "place", "remedy"];
    own.map(|it| keys.map(|key| text(it, key))).collect()
}

/// A property that asks for no time is weaker than "within release_time", whether or not a step of the model has a duration.
#[test]
fn a_property_without_the_sentence_s_time_limit_is_drift() {
    let unbounded = ("requirements.toml", PROPERTY, "(F \"released\")");
    for changes in [&[unbounded][..], &[unbounded, ("study.toml", STEP, "")]] {
        let found = of_property(changes);
        assert_eq!(found.len(), 1, "{found:?}");
        let [kind, seen, declared, place, remedy] = &found[0];
        assert_eq!(kind, "left-out");
        assert_eq!(seen, "no limit of the time to `released`");
        assert!(declared.contains("release_time"), "{declared}");
        assert!(place.ends_with("requirements.toml:9"), "{place}");
        assert!(remedy.contains("F<=k"), "{remedy}");
    }
    // What has a bound in steps, or a label that may hold one, is not said to have none.
    let bounded = ("requirements.toml", PROPERTY, "(F<=20 \"released\")");
    let untimed = ("study.toml", STEP, "");
    for changes in [&[bounded][..], &[bounded, untimed], &[untimed]] {
        let found = of_property(changes);
        assert!(found.is_empty(), "{changes:?}: {found:?}");
    }
}

#[test]
fn a_sentence_without_a_time_limit_asks_the_property_for_none() {
    let untimed = (
        "requirements.toml",
        "within release_time satisfy",
        "eventually satisfy",
    );
    let unbounded = ("requirements.toml", PROPERTY, "(F \"released\")");
    let step = ("study.toml", STEP, "");
    for changes in [&[untimed, unbounded][..], &[untimed, unbounded, step]] {
        let found = of_property(changes);
        assert!(found.is_empty(), "{changes:?}: {found:?}");
    }
}

/// Without a sentence the property and the formula are held against each other, and the one without a limit is named.
#[test]
fn of_a_property_and_a_formula_the_one_without_a_time_limit_is_named() {
    let sentence = "shall = \"Upon sensors_satisfied the robot shall within release_time satisfy released.\"\n";
    let formula = |time: &str| {
        format!("formula = \"always (rise(sensors_satisfied) => eventually{time} released)\"\n")
    };
    for (time, property, named) in [
        (
            "[0 s, 2 s]",
            "(F \"released\")",
            Some(("property", "2 s in its monitor")),
        ),
        (
            "",
            "(F<=20 \"released\")",
            Some(("monitor", "as its property")),
        ),
        ("[0 s, 2 s]", "(F<=20 \"released\")", None),
        ("", "(F \"released\")", None),
    ] {
        let written = formula(time);
        let (report, _) = reported(&[
            ("requirements.toml", sentence, &written),
            ("requirements.toml", PROPERTY, property),
        ]);
        let drift = list(&report, "drift").iter();
        let left_out: Vec<&Value> = drift
            .filter(|it| it["requirement"] == "4" && it["kind"] == "left-out")
            .collect();
        match named {
            None => assert!(left_out.is_empty(), "{time} {property}: {left_out:?}"),
            Some((form, declared)) => {
                assert_eq!(left_out.len(), 1, "{left_out:?}");
                assert_eq!(left_out[0]["form"], form);
                assert!(says(&left_out[0]["declared"], declared), "{left_out:?}");
            }
        }
    }
}
