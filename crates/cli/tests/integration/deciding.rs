//! Flaky tests as a user meets them: repeated until their rate is decided, by several at a time, interrupted, told by lines, as
//! evidence of a study, and asked for wrongly.

use crate::support;

use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::Stdio;
use support::program::{Said, Study, command, corroborate};
use support::schema::violations;
use support::{read, root};
use tempfile::TempDir;

/// A test that fails for some seeds in a hundred, is not applicable to one, and is ended by a signal for one.
const SCRIPT: &str = "#!/bin/sh\n\
    case $(($1 % 100)) in\n\
    0|1) echo \"seed $1 dropped the part\"; exit 1;;\n\
    7) exit 77;;\n\
    8) kill -9 $$;;\n\
    esac\n";

fn folder() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("t.sh"), SCRIPT).expect("written");
    folder
}

fn decide(folder: &Path, options: &[&str]) -> Said {
    let mut words = vec!["-q", "decide", "--format", "json"];
    words.extend(options);
    words.extend(["--", "sh", "t.sh", "{seed}"]);
    corroborate(folder, &words)
}

fn report(said: &Said) -> Value {
    let schema = read(&root().join("schemas/decide.schema.json"));
    let schema: Value = serde_json::from_str(&schema).expect("a schema is JSON");
    let report =
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
    assert_eq!(violations(&schema, &report), Vec::<String>::new());
    report
}

#[test]
fn a_rate_is_decided_at_the_same_trial_whoever_runs_how_many_at_a_time() {
    let folder = folder();
    let asked = |jobs, out| {
        let options = ["--margin", "0.02", "-r", "REQ-7", "-j", jobs, "--out", out];
        let said = decide(folder.path(), &options);
        assert_eq!(said.code, 0, "{said:?}");
        let report = report(&said);
        for name in [
            "decision.json",
            "trials.csv",
            "requirements.csv",
            "junit.xml",
        ] {
            assert!(folder.path().join(out).join(name).exists(), "{name}");
        }
        report
    };
    let (one, four) = (asked("1", "one"), asked("4", "four"));
    assert_eq!(one, four);
    assert_eq!(
        (&one["verdict"], &one["ended"]),
        (&"passed".into(), &"decided".into())
    );
    // What the script says of the seeds is what was counted.
    let trials = read(&folder.path().join("one/trials.csv"));
    let mut counted = [0_u64; 4];
    for row in trials.lines().skip(1) {
        let fields: Vec<&str> = row.split(',').collect();
        let seed: u64 = fields[1].parse().expect("a seed");
        let (place, outcome) = match seed % 100 {
            0 | 1 => (1, "fail"),
            8 => (2, "error"),
            7 => (3, "not-applicable"),
            _ => (0, "pass"),
        };
        assert_eq!(fields[2], outcome, "{row}");
        counted[place] += 1;
    }
    let names = ["passed", "failed", "errors", "not_applicable"];
    let counts = names.map(|name| one["counts"][name].as_u64().expect("a count"));
    assert_eq!(counts, counted);
    let table = format!(
        "REQ-7,{},{},{},{},yes\n",
        counts[0] + counts[1],
        counts[0],
        counts[1],
        counts[2]
    );
    assert!(read(&folder.path().join("one/requirements.csv")).ends_with(&table));
}

#[test]
fn failing_seeds_are_kept_with_the_command_that_fails_again() {
    let folder = folder();
    let said = decide(
        folder.path(),
        &["--at-least", "0.999", "--on-error", "failure"],
    );
    let report = report(&said);
    let failing = report["failing"].as_array().expect("a list");
    assert!(!failing.is_empty());
    for it in failing {
        let shell = std::process::Command::new("sh")
            .args(["-c", it["command"].as_str().expect("a command")])
            .current_dir(folder.path())
            .output()
            .expect("a shell");
        assert!(!shell.status.success(), "{it}");
        let log = folder
            .path()
            .join("decision")
            .join(it["log"].as_str().expect("a log"));
        let says = if it["outcome"] == "fail" {
            "dropped the part"
        } else {
            ""
        };
        assert!(read(&log).contains(says), "{it}");
    }
    let kept = read(&folder.path().join("decision/failing-seeds.sh"));
    assert_eq!(
        kept.lines().filter(|it| it.starts_with("sh t.sh ")).count(),
        failing.len()
    );
}

#[test]
fn a_rate_that_is_too_low_fails_and_one_in_between_says_how_many_more() {
    let folder = folder();
    std::fs::write(folder.path().join("t.sh"), "test $(($1 % 10)) -gt 3\n").expect("written");
    let said = decide(folder.path(), &["--out", "low"]);
    assert_eq!(
        (said.code, &report(&said)["verdict"]),
        (1, &"failed".into())
    );
    // It passes in three of five trials.
    let close = ["--at-least", "0.6", "--max-trials", "60", "--out", "close"];
    let said = decide(folder.path(), &close);
    let undecided = report(&said);
    assert_eq!((said.code, &undecided["verdict"]), (3, &"undecided".into()));
    assert_eq!(undecided["ended"], "max-trials");
    assert!(
        undecided["further_trials"].as_u64() > Some(60),
        "{undecided}"
    );
    assert!(
        read(&folder.path().join("close/junit.xml")).contains("<skipped message=\"undecided: ")
    );
    // More trials go on behind those that are there.
    let more = ["--at-least", "0.6", "--max-trials", "80", "--out", "close"];
    let before = read(&folder.path().join("close/journal.jsonl"));
    assert_eq!(report(&decide(folder.path(), &more))["trials"], 80);
    let after = read(&folder.path().join("close/journal.jsonl"));
    assert!(after.starts_with(&before) && after.lines().count() == 81);
}

#[test]
fn an_interrupted_call_goes_on_and_comes_to_the_same_end() {
    let folder = folder();
    let slow = "sleep 0.02\nexit $(($1 % 20 == 0))\n";
    std::fs::write(folder.path().join("t.sh"), slow).expect("written");
    let words = [
        "-q",
        "decide",
        "--format",
        "json",
        "--margin",
        "0.04",
        "--max-trials",
        "150",
        "-j",
        "2",
    ];
    let words = |out| [&words[..], &["--out", out, "--", "sh", "t.sh", "{seed}"]].concat();
    let mut child = command(folder.path(), &words("cut"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts");
    let journal = folder.path().join("cut/journal.jsonl");
    let lines = || std::fs::read_to_string(&journal).map_or(0, |text| text.lines().count());
    while lines() < 8 {
        assert!(
            child.try_wait().expect("a state").is_none(),
            "it ended too early"
        );
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let signalled = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(signalled.expect("kill runs").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    // A line that was cut off is run again.
    let kept = read(&journal);
    std::fs::write(&journal, &kept[..kept.len() - 5]).expect("written");
    let whole = report(&corroborate(folder.path(), &words("whole")));
    let on = report(&corroborate(folder.path(), &words("cut")));
    assert_eq!(on, whole);
    let numbers: Vec<u64> = read(&journal)
        .lines()
        .skip(1)
        .map(|line| {
            let trial: Value = serde_json::from_str(line).expect("a line of JSON");
            trial["trial"].as_u64().expect("a number")
        })
        .collect();
    let mut different = numbers.clone();
    different.sort_unstable();
    different.dedup();
    assert_eq!(different.len(), numbers.len(), "a trial was run twice");
}

#[test]
fn other_trials_are_not_counted_together_and_wrong_calls_say_what_to_do() {
    let folder = folder();
    assert_eq!(decide(folder.path(), &["--max-trials", "5"]).code, 3);
    let refused = |options: &[&str], code: &str, part: &str| {
        let said = decide(folder.path(), options);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(
            said.talk.contains(&format!("error[{code}]")),
            "{}",
            said.talk
        );
        assert!(said.talk.contains(part), "{}", said.talk);
    };
    refused(&["--seed", "2"], "other-trials", "seed 1, now 2");
    refused(&["--at-least", "0.9"], "other-trials", "--out");
    refused(
        &["--at-least", "0.99", "--margin", "0.02", "--out", "x"],
        "bad-rule",
        "margin",
    );
    refused(
        &["--at-least", "1", "--out", "x"],
        "bad-rule",
        "no number of trials",
    );
    refused(
        &["--confidence", "95", "--out", "x"],
        "bad-rule",
        "confidence",
    );
    let journal = folder.path().join("decision/journal.jsonl");
    std::fs::write(&journal, read(&journal).replace("\"pass\"", "\"well\"")).expect("written");
    refused(&[], "bad-journal", "journal.jsonl:2:1");
    let call = |words: &[&str]| {
        corroborate(
            folder.path(),
            &[&["-q", "decide", "--out", "y", "--"], words].concat(),
        )
    };
    let said = call(&["sh", "t.sh"]);
    assert!(
        said.code == 2 && said.talk.contains("error[no-seed]"),
        "{said:?}"
    );
    let said = call(&["./not-there", "{seed}"]);
    assert!(
        said.code == 2 && said.talk.contains("error[test-cannot-start]"),
        "{said:?}"
    );
}

#[test]
fn a_harness_that_breaks_is_never_success() {
    let folder = folder();
    std::fs::write(folder.path().join("t.sh"), "sleep 30\n").expect("written");
    let said = decide(
        folder.path(),
        &["--timeout", "50ms", "--max-errors", "2", "-j", "2"],
    );
    let broken = report(&said);
    assert_eq!((said.code, &broken["ended"]), (3, &"errors".into()));
    assert_eq!(
        (&broken["counts"]["passed"], &broken["counts"]["errors"]),
        (&0.into(), &3.into())
    );
    assert_eq!(broken["rate"], Value::Null);
    // All that is not applicable decides nothing.
    std::fs::write(folder.path().join("t.sh"), "exit 5\n").expect("written");
    let said = decide(
        folder.path(),
        &[
            "--not-applicable",
            "5",
            "--max-trials",
            "9",
            "--out",
            "none",
        ],
    );
    let none = report(&said);
    assert_eq!(
        (said.code, &none["counts"]["not_applicable"]),
        (3, &9.into())
    );
}

/// Two runners that each are told all outcomes, in another order, come to the answer of the command.
#[test]
fn lines_come_to_the_same_answer_in_any_order() {
    let folder = folder();
    let whole = report(&decide(folder.path(), &["--margin", "0.02"]));
    let trials = read(&folder.path().join("decision/trials.csv"));
    let lines: Vec<String> = trials
        .lines()
        .skip(1)
        .map(|row| {
            let fields: Vec<&str> = row.split(',').collect();
            format!("{} {}", fields[0], fields[2])
        })
        .collect();
    let schema = read(&root().join("schemas/decide-answer.schema.json"));
    let schema: Value = serde_json::from_str(&schema).expect("a schema is JSON");
    for order in [lines.clone(), lines.iter().rev().cloned().collect()] {
        let words = [
            "-q",
            "decide",
            "--protocol",
            "--margin",
            "0.02",
            "--out",
            "told",
            "--",
            "sh",
            "t.sh",
            "{seed}",
        ];
        let mut child = command(folder.path(), &words)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let (mut input, output) = (
            child.stdin.take().expect("open"),
            child.stdout.take().expect("open"),
        );
        let mut answers = BufReader::new(output).lines();
        let mut ask = |line: &str| -> Value {
            writeln!(input, "{line}").expect("told");
            let answer = answers.next().expect("an answer").expect("text");
            let answer = serde_json::from_str(&answer).expect("JSON");
            assert_eq!(violations(&schema, &answer), Vec::<String>::new());
            answer
        };
        let seed = trials
            .lines()
            .nth(1)
            .and_then(|row| row.split(',').nth(1))
            .expect("a seed");
        assert_eq!(ask("seed 1")["seed"].to_string(), seed);
        let standing: Vec<Value> = order.iter().map(|line| ask(line)).collect();
        assert!(standing.iter().rev().skip(1).all(|it| it["ended"] == false));
        assert_eq!(standing.last().expect("some")["verdict"], "passed");
        let told = ask("report");
        for key in [
            "verdict", "counts", "rate", "interval", "zone", "seed", "command",
        ] {
            assert_eq!(told[key], whole[key], "{key}");
        }
        drop(input);
        assert_eq!(child.wait().expect("it ends").code(), Some(0));
    }
    for name in ["requirements.csv", "trials.csv", "junit.xml"] {
        let [told, run] = ["told", "decision"].map(|it| read(&folder.path().join(it).join(name)));
        assert_eq!(told, run, "{name}");
    }
    let mut child = command(folder.path(), &["decide", "--protocol"])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("the program starts");
    child
        .stdin
        .take()
        .expect("open")
        .write_all(b"1 pass\n1 fail\n")
        .expect("told");
    let said = child.wait_with_output().expect("it ends");
    assert_eq!(said.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&said.stderr).contains("error[bad-line]"));
}

#[test]
fn its_table_is_an_experiment_of_a_study() {
    let study = Study::new();
    let script = "exit $(($1 % 50 == 0))\n";
    std::fs::write(study.beside().join("t.sh"), script).expect("written");
    let said = decide(
        study.beside(),
        &["-r", "2", "--margin", "0.02", "--out", "study/docking"],
    );
    let decided = report(&said);
    let ledger = read(&study.path("ledger.toml"));
    let entry = "\n[[evidence]]\nid = \"E3\"\ntitle = \"Repeated test\"\ntechnique = \"experiment\"\n\
                 conditions = \"typical\"\ntables.requirements = \"docking/requirements.csv\"\nchanged = \"Repeated.\"\n";
    study.write("ledger.toml", ledger + entry);
    let said = study.run(&["run", "study", "--format", "json"]);
    let result: Value = serde_json::from_str(&said.out).expect("JSON");
    let pieces = result["evidence"].as_array().expect("evidence");
    let piece = pieces.iter().find(|it| it["id"] == "E3").expect("E3");
    let findings = piece["findings"].as_array().expect("findings");
    let finding = findings
        .iter()
        .find(|it| it["subject"]["id"] == "2")
        .expect("of 2");
    let measure = &finding["measure"];
    let [count, trials] = ["count", "trials"].map(|key| measure[key].clone());
    assert_eq!(count, decided["counts"]["passed"], "{measure}");
    assert_eq!(trials, decided["trials"]);
    // Stopped by what was seen: at least as wide as an interval of trials whose number was fixed.
    let sample = stats::Sample::new(
        count.as_u64().expect("a count"),
        trials.as_u64().expect("trials"),
    );
    let sample = sample.expect("counts");
    let fixed = stats::wilson(sample, stats::Confidence::P95);
    let low = measure["interval"]["low"].as_f64().expect("a limit");
    assert!(low < fixed.low - 0.01, "{measure} beside {fixed:?}");
}

#[test]
fn a_table_says_what_is_undecided_and_that_it_was_stopped() {
    let study = Study::new();
    let of = |more: &str| {
        study.write(
            "docking/requirements.csv",
            format!("requirement,covered,passed,failed{more}"),
        );
        study.run(&["run", "study", "--format", "json"])
    };
    let ledger = read(&study.path("ledger.toml"));
    let entry = "\n[[evidence]]\nid = \"E3\"\ntitle = \"Trials\"\ntechnique = \"experiment\"\n\
                 conditions = \"typical\"\ntables.requirements = \"docking/requirements.csv\"\nchanged = \"Counted.\"\n";
    study.write("ledger.toml", ledger + entry);
    std::fs::create_dir_all(study.path("docking")).expect("a folder");
    let finding = |said: &Said| {
        let result: Value = serde_json::from_str(&said.out).expect("JSON");
        let pieces = result["evidence"].as_array().expect("evidence");
        let piece = pieces.iter().find(|it| it["id"] == "E3").expect("E3");
        let mut findings = piece["findings"].as_array().expect("findings").iter();
        findings
            .find(|it| it["subject"]["id"] == "2")
            .expect("of 2")
            .clone()
    };
    let limits = |it: &Value| {
        ["low", "high"].map(|end| it["measure"]["interval"][end].as_f64().expect("a limit"))
    };
    let plain = finding(&of("\n2,60,57,3\n"));
    let undecided = finding(&of(",undecided\n2,60,57,3,15\n"));
    assert_eq!(
        (&undecided["undecided"], &plain["undecided"]),
        (&15.into(), &0.into())
    );
    // 57 of 75 at the least, 72 of 75 at the most.
    let end = |successes| {
        let sample = stats::Sample::new(successes, 75).expect("counts");
        stats::wilson(sample, stats::Confidence::P95)
    };
    let [low, high] = limits(&undecided);
    assert!(
        (low - end(57).low).abs() < 1e-12 && (high - end(72).high).abs() < 1e-12,
        "{undecided}"
    );
    let stopped = finding(&of(",stopped\n2,60,57,3,yes\n"));
    let ([low, high], [plain_low, plain_high]) = (limits(&stopped), limits(&plain));
    assert!(
        low < plain_low && high > plain_high,
        "{stopped} beside {plain}"
    );
    let wrong = of(",stopped\n2,60,57,3,perhaps\n");
    assert_eq!(wrong.code, 2, "{wrong:?}");
    assert!(
        wrong.talk.contains("requirements.csv:2") && wrong.talk.contains("`yes`"),
        "{wrong:?}"
    );
}
