//! `corroborate monitor` on signals that come at their own times, twice at one time, late, or not at all.

use crate::support;

use std::path::Path;
use support::program::corroborate;
use tempfile::TempDir;

/// Times 0, 0.5, 1.5 and 2 s of one topic; what came at 1 s cannot be read.
const GAP: &str = r#"{"topic":"/x","time":0.0,"a":1}
{"topic":"/x","time":0.5,"a":1}
{"topic":"/x","time":1.0,"a":-
{"topic":"/x","time":1.5,"a":1}
{"topic":"/x","time":2.0,"a":1}
"#;

const DROPS_OUT: &str = r#"{"topic":"/s","time":0.0,"v":1}
{"topic":"/s","time":0.1,"v":1}
{"topic":"/s","time":5.0,"v":1}
{"topic":"/o","time":5.1,"w":1}
"#;

const JOINTS: &str = r#"{"topic":"/joints","time":0.0,"name":["arm"],"velocity":[1]}
{"topic":"/joints","time":0.1,"name":["grip"],"velocity":[2]}
{"topic":"/joints","time":0.2,"name":["arm"],"velocity":[1]}
{"topic":"/joints","time":0.3,"name":["grip"],"velocity":[2]}
"#;

const MAP: &str = r#"
["/s.v"]
from = "/s.v"
staleness = "0.5 s"
["/r.arm"]
from = "/joints.velocity[name='arm']"
["/r.grip"]
from = "/joints.velocity[name='grip']"
"#;

fn folder() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
    };
    write("map.toml", MAP);
    write("gap.jsonl", GAP);
    write("drop.jsonl", DROPS_OUT);
    write("joints.jsonl", JOINTS);
    write("twice.csv", "time_secs,/x.a\n0,1\n1,-3\n1,2\n2,1\n");
    write(
        "one.csv",
        "time_secs,/x.a,/y.b\n0,1,\n0.1,,5\n0.2,1,\n0.3,,5\n0.4,-1,\n",
    );
    write("late.csv", "time_secs,/a.v,/b.v\n0,1,\n0.001,,1\n1,2,1\n");
    write("nothing.csv", "time_secs,/x.a\n");
    write("lone.csv", "time_secs,/x.a\n1000000000,1\n");
    write("nan.csv", "time_secs,/x.a\n0,nan\n1,nan\n");
    folder
}

/// The verdicts and the exit code.
fn judged(folder: &Path, file: &str, formulas: &[&str], more: &[&str]) -> (Vec<String>, i32) {
    let mut arguments = vec!["monitor", "--format", "json"];
    if file.ends_with("jsonl") {
        arguments.extend(["--time-unit", "s", "--map", "map.toml"]);
    }
    for formula in formulas {
        arguments.extend(["--formula", formula]);
    }
    arguments.extend(more);
    arguments.push(file);
    let said = corroborate(folder, &arguments);
    let report: serde_json::Value =
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
    let verdicts = report["recordings"][0]["verdicts"]
        .as_array()
        .expect("verdicts");
    let name = |it: &serde_json::Value| it["verdict"].as_str().expect("a verdict").to_owned();
    (verdicts.iter().map(name).collect(), said.code)
}

#[track_caller]
fn is(file: &str, formula: &str, more: &[&str], verdict: &str) {
    let folder = folder();
    let (found, _) = judged(folder.path(), file, &[formula], more);
    assert_eq!(found, [verdict], "{formula} on {file}");
}

#[test]
fn another_formula_changes_nothing() {
    let folder = folder();
    let formula = "next next (/x.a < 0)";
    let alone = judged(folder.path(), "one.csv", &[formula], &[]);
    assert_eq!(alone, (vec!["satisfied".to_owned()], 0));
    let both = judged(
        folder.path(),
        "one.csv",
        &[formula, "always (/y.b > 0)"],
        &[],
    );
    assert_eq!(both, (vec!["satisfied".to_owned(); 2], 0));
}

#[test]
fn messages_of_one_time_all_count() {
    is("twice.csv", "always (/x.a > 0)", &[], "violated");
    is("twice.csv", "always (/x.a > 0)", &["--dense"], "violated");
    is("twice.csv", "always[0, 1 s] (/x.a > 0)", &[], "violated");
    is("twice.csv", "eventually (/x.a > 1.5)", &[], "satisfied");
    is("twice.csv", "next next (/x.a > 1.5)", &[], "satisfied");
}

#[test]
fn signals_may_begin_one_after_the_other() {
    is("late.csv", "always (/a.v - /b.v < 5)", &[], "satisfied");
    let strict = ["--start-within", "0"];
    is(
        "late.csv",
        "always (/a.v - /b.v < 5)",
        &strict,
        "inconclusive",
    );
}

#[test]
fn what_is_lost_may_have_been_anything() {
    // Between 0.5 and 1.5 s, these included: a lost message can have the time of its neighbour.
    let partial = ["--partial"];
    is(
        "gap.jsonl",
        "always[0, 1.9 s] (/x.a > 0)",
        &partial,
        "inconclusive",
    );
    is(
        "gap.jsonl",
        "always[0, 1.9 s] (/x.a > 0)",
        &["--partial", "--dense"],
        "inconclusive",
    );
    is(
        "gap.jsonl",
        "always[0, 0.4 s] (/x.a > 0)",
        &partial,
        "satisfied",
    );
    is("gap.jsonl", "eventually (/x.a > 0)", &partial, "satisfied");
    is("gap.jsonl", "always (/x.a < 0)", &partial, "violated");
    is(
        "gap.jsonl",
        "next next (/x.a > 0)",
        &partial,
        "inconclusive",
    );
}

#[test]
fn a_sensor_that_drops_out_is_unknown_meanwhile() {
    is(
        "drop.jsonl",
        "always[0, 2 s] (/s.v > 0)",
        &[],
        "inconclusive",
    );
    is(
        "drop.jsonl",
        "eventually[1 s, 2 s] (/s.v < 0)",
        &[],
        "inconclusive",
    );
    is(
        "drop.jsonl",
        "always[0, 0.4 s] (/s.v > 0)",
        &[],
        "satisfied",
    );
}

#[test]
fn joints_of_two_publishers_keep_their_values() {
    is(
        "joints.jsonl",
        "always (/r.arm < 3 and /r.grip < 3)",
        &[],
        "satisfied",
    );
}

#[test]
fn odd_recordings_are_judged_as_far_as_they_say_anything() {
    is("nan.csv", "always (/x.a > 0)", &[], "inconclusive");
    is("nothing.csv", "always (/x.a > 0)", &[], "inconclusive");
    is("lone.csv", "always (/x.a > 0)", &[], "satisfied");
}
