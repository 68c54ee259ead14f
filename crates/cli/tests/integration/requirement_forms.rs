//! What the text of a requirement's forms alone shows, and when a sentence is judged in dense time.

use crate::support;

use serde_json::Value;
use support::program::corroborate;
use tempfile::TempDir;

const PARAMETERS: &str = r#"
near = { value = "10 cm", meaning = "near" }
slow = { value = "250 mm/s", meaning = "slow" }
many = { value = "3", meaning = "many" }
late = { value = "2 s", meaning = "late" }
"#;

const VOCABULARY: &str = r#"
active = { meaning = "active", trace = "/r.active" }
done = { meaning = "done", trace = "/r.done" }
hand_slow = { meaning = "slow", trace = "/r.speed < slow" }
hand_slow_in_si = { meaning = "slow", trace = "/r.speed < 0.25" }
hand_slow_as_written = { meaning = "slow", trace = "/r.speed < 250" }
hand_less_slow = { meaning = "slow", trace = "/r.speed < 0.3" }
hand_not_fast = { meaning = "slow", trace = "!(/r.speed >= 0.5)" }
few = { meaning = "few", trace = "/r.count < many" }
few_more = { meaning = "few", trace = "/r.count < 5" }
turns_slowly = { meaning = "turns", trace = "/r.turn < 0.25 rad/s" }
near_in_plane = { meaning = "near", trace = "norm(/a.x - /b.x, /a.y - /b.y) < near" }
near_upright = { meaning = "near", trace = "norm(/a.x - /b.x, /a.z - /b.z) < near" }
"#;

const STUDY: &str = "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
                     [model]\nstep = \"0.1 s\"\n";

fn study(requirement: &str) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let requirements = format!("[[requirement]]\nid = \"1\"\ntext = \"t\"\n{requirement}\n");
    for (name, text) in [
        ("study.toml", STUDY),
        ("parameters.toml", PARAMETERS),
        ("vocabulary.toml", VOCABULARY),
        ("requirements.toml", &requirements),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

fn reported(folder: &TempDir, arguments: &[&str]) -> Value {
    let said = corroborate(folder.path(), arguments);
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

/// The kinds of drift between a sentence and a formula.
fn drift(sentence: &str, formula: &str) -> Vec<String> {
    let folder = study(&format!("shall = \"{sentence}\"\nformula = \"{formula}\""));
    kinds(&folder)
}

fn kinds(folder: &TempDir) -> Vec<String> {
    let report = reported(folder, &["requirements", ".", "--format", "json"]);
    let found = report["drift"].as_array().expect("a list");
    let kind = |drift: &Value| drift["kind"].as_str().expect("a text").to_owned();
    found.iter().map(kind).collect()
}

const SLOW: &str = "Whenever active the robot shall immediately satisfy hand_slow.";

#[test]
fn a_number_without_a_unit_is_held_against_the_limit_of_the_same_signal() {
    for same in ["hand_slow_in_si", "hand_slow_as_written"] {
        let formula = format!("always (active => {same})");
        assert_eq!(drift(SLOW, &formula), Vec::<String>::new(), "{same}");
    }
    for other in ["hand_less_slow", "hand_not_fast", "/r.speed < 0.26"] {
        let formula = format!("always (active => {other})");
        assert_eq!(drift(SLOW, &formula), ["limit"], "{other}");
    }
}

#[test]
fn limits_without_a_dimension_are_compared() {
    let sentence = "Whenever active the robot shall immediately satisfy few.";
    assert_eq!(
        drift(sentence, "always (active => /r.count < 3)"),
        Vec::<String>::new()
    );
    assert_eq!(drift(sentence, "always (active => few_more)"), ["limit"]);
}

#[test]
fn a_limit_of_a_kind_that_the_sentence_has_not_is_drift() {
    let other = drift(SLOW, "always (active => turns_slowly)");
    assert_eq!(other, ["limit", "left-out"]);
    let eventually = "When active the robot shall eventually satisfy done.";
    let deadline = "always (rise(active) => eventually[0, 5 s] done)";
    assert_eq!(drift(eventually, deadline), ["limit"]);
}

#[test]
fn steps_are_held_against_seconds() {
    let within =
        |steps: u32| format!("When active the robot shall within {steps} steps satisfy done.");
    let deadline = "always (rise(active) => eventually[0, 2 s] done)";
    assert_eq!(drift(&within(20), deadline), Vec::<String>::new());
    assert_eq!(drift(&within(30), deadline), ["limit"]);
}

#[test]
fn a_distance_in_another_plane_is_another_quantity() {
    let sentence = "Whenever active the robot shall immediately satisfy near_in_plane.";
    assert_eq!(
        drift(sentence, "always (active => near_upright)"),
        ["signal"]
    );
}

#[test]
fn the_past_is_another_instant_only_where_the_requirement_does_not_speak_of_it() {
    let after = "After active the robot shall always satisfy hand_slow.";
    let same = "always (once(not active and once active) => hand_slow)";
    assert_eq!(drift(after, same), Vec::<String>::new());
    let earlier = "always (once(not active and once active) => previous hand_slow)";
    assert_eq!(drift(after, earlier), ["instant"]);
}

#[test]
fn without_a_sentence_the_clock_and_the_past_of_the_main_monitor_are_the_declared_ones() {
    let main = "parameters = [\"late\"]\nclock = \"/r.time\"\n\
                formula = \"always (done => once[0, 2 s] active)\"\n";
    assert_eq!(kinds(&study(main)), Vec::<String>::new());
    let reading = "[requirement.reading.other]\nmeaning = \"m\"\n\
                   formula = \"always (done => once[0, 2 s] active)\"";
    assert_eq!(kinds(&study(&format!("{main}{reading}"))), ["clock"]);
}

/// Samples at 0.0, 0.31, 0.62, ... s: none is exactly 2 s behind another.
#[test]
fn a_stage_that_begins_between_two_samples_is_judged() {
    let sentence =
        "When active, the robot shall for 2 s satisfy active, then within 1 s satisfy done.";
    for (done_from, verdict) in [(10, "satisfied"), (13, "violated")] {
        let folder = study(&format!("shall = \"{sentence}\""));
        let mut table = String::from("time_secs,/r.active,/r.done\n");
        for sample in 0..20 {
            let time_secs = f64::from(sample) * 0.31;
            table += &format!("{time_secs:.2},{},{}\n", sample >= 1, sample >= done_from);
        }
        std::fs::write(folder.path().join("uneven.csv"), table).expect("written");
        let report = reported(&folder, &["monitor", ".", "uneven.csv", "--format", "json"]);
        let judged = &report["recordings"][0]["verdicts"][0];
        assert_eq!(judged["verdict"], verdict, "{report:#}");
    }
}

/// A clock that shows the time of the calendar, and stands still for three samples at a time.
#[test]
fn a_late_clock_that_stands_still_can_be_judged_by() {
    let sentence = "When active, the robot shall within 2 s satisfy done.";
    for (done_from, verdict) in [(20, "satisfied"), (40, "violated")] {
        let folder = study(&format!("shall = \"{sentence}\"\nclock = \"/clock.wall\""));
        let mut table = String::from("time_secs,/r.active,/r.done,/clock.wall [s]\n");
        for sample in 0..50_u32 {
            let (time_secs, wall_secs) = (f64::from(sample) * 0.1, 0.3 * f64::from(sample / 3));
            let (active, done) = (sample >= 6, sample >= done_from);
            table += &format!("{time_secs:.1},{active},{done},{:.1}\n", 1.7e9 + wall_secs);
        }
        std::fs::write(folder.path().join("calendar.csv"), table).expect("written");
        let arguments = ["monitor", ".", "calendar.csv", "--format", "json"];
        let judged = reported(&folder, &arguments);
        assert_eq!(
            judged["recordings"][0]["verdicts"][0]["verdict"], verdict,
            "{judged:#}"
        );
    }
}

/// The warnings of `requirements`, which are said, too.
fn warnings(requirement: &str) -> Vec<String> {
    let folder = study(requirement);
    let said = corroborate(folder.path(), &["requirements", ".", "--format", "json"]);
    let report: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
    let found = report["warnings"].as_array().expect("a list");
    let found: Vec<String> = found
        .iter()
        .filter_map(Value::as_str)
        .map(str::to_owned)
        .collect();
    assert!(
        found.iter().all(|line| said.talk.contains(line)),
        "{said:?}"
    );
    found
}

#[test]
fn what_is_perhaps_not_meant_is_warned_of_once_at_its_place() {
    let after = "shall = \"When active the robot shall after 2 s satisfy done.\"";
    let within = "shall = \"When active the robot shall within 2 s satisfy done.\"";
    let formula = "formula = \"always (active => eventually[2 s, 2 s] done)\"";
    let found = warnings(after);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].starts_with("warning: ./requirements.toml:4:"),
        "{found:?}"
    );
    assert!(found[0].contains("exact instant"), "{found:?}");
    assert_eq!(warnings(within), Vec::<String>::new());
    let by_hand = warnings(&format!("{within}\n{formula}"));
    assert_eq!(by_hand.len(), 1, "{by_hand:?}");
    assert!(
        by_hand[0].starts_with("warning: ./requirements.toml:5:12: [2 s, 2 s]"),
        "{by_hand:?}"
    );
    assert_eq!(
        warnings(&format!("{formula}\ntime = \"dense\"")),
        Vec::<String>::new()
    );
    let twice = format!(
        "{after}\n[[requirement]]\nid = \"2\"\ntext = \"t\"\nthreshold = \"at least 0.5\"\nsame_as = \"1\""
    );
    assert_eq!(warnings(&twice).len(), 1);
}

/// Nine stages that wait for ever are judged, but have no robustness, and that is said.
#[test]
fn why_stages_have_no_robustness_is_said() {
    let decided = "what decided it is true or false, and no number";
    let stage = "{ wait_for = \"done\" }";
    let shown = |count: usize| {
        let stages = vec![stage; count].join(", ");
        let folder = study(&format!(
            "monitor.when = \"active\"\nmonitor.then = [{stages}]"
        ));
        let table = "time_secs,/r.active,/r.done\n0,false,false\n1,true,false\n2,true,true\n";
        std::fs::write(folder.path().join("r.csv"), table).expect("written");
        let report = reported(&folder, &["monitor", ".", "r.csv", "--format", "json"]);
        let text = corroborate(folder.path(), &["monitor", ".", "r.csv"]).out;
        (report["recordings"][0]["verdicts"][0].clone(), text)
    };
    let (verdict, text) = shown(8);
    assert_eq!(verdict["verdict"], "satisfied", "{verdict}");
    assert!(
        verdict["robustness"].is_null() && verdict["no_robustness"] == decided,
        "{verdict}"
    );
    assert!(!text.contains("no robustness"), "{text}");
    let (verdict, text) = shown(9);
    assert_eq!(verdict["verdict"], "satisfied", "{verdict}");
    assert!(verdict["robustness"].is_null(), "{verdict}");
    let reason = verdict["no_robustness"].as_str().expect("a reason");
    assert!(reason.contains("up to 8 stages"), "{reason}");
    assert!(
        text.contains(&format!("satisfied, no robustness: {reason}")),
        "{text}"
    );
}
