//! Campaigns of many episodes as a user meets them: with another simulator, interrupted, ended by
//! a rule, and as a table. Needs `python3`, which the other simulator is written in; nothing else.

use crate::support;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;
use support::command_study;
use support::program::{Said, code_of_verdicts, command, corroborate};

/// A simulation that is slow enough to be interrupted.
const SLOWLY: &str = "    stimulus, seed, recording = sys.argv[1:]\n";

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

/// Every file of a folder but those that say what a call was, with its content.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    entries
        .filter(|entry| entry.path().is_file())
        .map(|entry| {
            let name = entry.file_name().to_string_lossy().into_owned();
            (name, std::fs::read(entry.path()).expect("a file"))
        })
        .collect()
}

fn simulate(folder: &Path, more: &[&str]) -> Said {
    let mut arguments = vec!["simulate", ".", "sim", "--format", "json"];
    arguments.extend(more);
    corroborate(folder, &arguments)
}

#[test]
fn another_simulator_counts_like_ours_at_any_number_of_threads() {
    let folder = command_study(&[]);
    for threads in ["1", "3"] {
        let said = corroborate(
            folder.path(),
            &["run", ".", "-j", threads, "--out", threads],
        );
        assert!([0, 1, 3].contains(&said.code), "{said:?}");
    }
    let of = |threads: &str| files(&folder.path().join(threads).join("episodes/sim"));
    assert!(of("1") == of("3"));
    let all = of("1");
    let tables: Vec<&[u8]> = all
        .iter()
        .filter(|(name, _)| name.ends_with(".csv"))
        .map(|(_, content)| content.as_slice())
        .collect();
    assert_eq!(tables.len(), 40);
    assert!(all.contains_key("episodes.parquet"));

    // What the program counts is what the simulator's own tables show.
    let (mut stops, mut clear) = (0, 0);
    for table in tables {
        let text = std::str::from_utf8(table).expect("text");
        let last: Vec<f64> = text
            .lines()
            .last()
            .expect("rows")
            .split(',')
            .map(|cell| cell.parse().expect("a number"))
            .collect();
        stops += u64::from(last[2] == 0.0 && last[0] - 1000.0 <= 3500.0);
        clear += u64::from(last[1] > 0.0);
    }
    let study = std::fs::read_to_string(folder.path().join("1/study.json")).expect("a result");
    let study: Value = serde_json::from_str(&study).expect("JSON");
    let evidence = &study["evidence"][0];
    let count = |place: usize| evidence["findings"][place]["measure"]["count"].as_u64();
    assert_eq!(
        (count(0), count(1)),
        (Some(stops), Some(clear)),
        "{evidence}"
    );
    assert!(stops > 0 && stops < 40 && clear < 40, "{stops} {clear}");
    let assets = evidence["assets"].to_string();
    assert!(
        assets.contains("simulate.py") && assets.contains("stimulus.toml"),
        "{assets}"
    );

    // A change of the simulator makes its episodes stale, another call does not.
    let again = corroborate(folder.path(), &["run", ".", "--out", "1"]);
    assert!(again.talk.contains("nothing has changed"), "{again:?}");
    let script = folder.path().join("simulate.py");
    let text = std::fs::read_to_string(&script).expect("a script");
    std::fs::write(&script, text.replace("gap = 400.0", "gap = 300.0")).expect("changed");
    corroborate(folder.path(), &["run", ".", "--out", "1"]);
    assert!(of("1") != all);
}

/// A campaign of 40 episodes, killed each time so many have begun, and then run to its end; how often it was killed.
fn killed_and_finished(folder: &Path, keep: &str) -> usize {
    let arguments = [
        "simulate", ".", "sim", "--out", "out", "-n", "40", "-j", "2", "--keep", keep,
    ];
    let mut killed = 0;
    for enough in [3, 9, 17, 30] {
        let mut child = command(folder, &arguments)
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("it starts");
        while begun(folder) < enough && child.try_wait().expect("a state").is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        killed += usize::from(child.try_wait().expect("a state").is_none());
        child.kill().expect("killed");
        child.wait().expect("ended");
    }
    let said = simulate(folder, &["--out", "out", "-n", "40", "--keep", keep]);
    assert_eq!(said.code, code_of_verdicts(&json(&said)), "{said:?}");
    killed
}

/// How many episodes have begun.
fn begun(folder: &Path) -> usize {
    std::fs::read_to_string(folder.join("begun")).map_or(0, |text| text.lines().count())
}

#[test]
fn a_campaign_that_is_killed_goes_on_without_losing_or_repeating_an_episode() {
    let slowly = format!(
        "{SLOWLY}    open(\"begun\", \"a\").write(seed + \"\\n\")\n    __import__(\"time\").sleep(0.02)\n"
    );
    for keep in ["all", "none"] {
        let undisturbed = command_study(&[]);
        let arguments = ["--out", "out", "-n", "40", "--keep", keep];
        // Six in ten stop where nine are asked for; that they are all clear is asked for with certainty.
        let said = simulate(undisturbed.path(), &arguments);
        let judged = json(&said)["verdicts"].clone();
        assert_eq!(
            (said.code, judged.as_array().map(Vec::len)),
            (1, Some(1)),
            "{judged}"
        );
        assert_eq!(judged[0]["verdict"], "violated", "{judged}");
        let folder = command_study(&[("simulate.py", SLOWLY, &slowly)]);
        let killed = killed_and_finished(folder.path(), keep);
        assert!(killed > 0, "every call ended before it could be killed");
        let [found, wanted] = [&folder, &undisturbed].map(|folder| {
            let mut files = files(&folder.path().join("out"));
            // It says of which simulator the recordings are, and this one is slower.
            files.remove("campaign");
            files
        });
        assert!(
            found == wanted,
            "{:?}, not {:?}",
            found.keys(),
            wanted.keys()
        );
        assert!(wanted.contains_key("journal") && wanted.contains_key("episodes.parquet"));
        assert_eq!(
            wanted.keys().any(|name| name.ends_with(".csv")),
            keep == "all"
        );
        // Only what was under way, on two threads, when a call was killed was begun again.
        let most = 40 + 2 * killed;
        assert!(keep == "none" || (40..=most).contains(&begun(folder.path())));
    }
}

#[test]
fn a_rule_ends_a_campaign_at_the_same_episode_at_any_number_of_threads() {
    let folder = command_study(&[]);
    // Some forty episodes: six in ten stop.
    let rule = "requirement stops is decided against 0.3 at 90 %";
    let mut ended = Vec::new();
    for threads in ["1", "4"] {
        let out = format!("out{threads}");
        let said = simulate(
            folder.path(),
            &["--until", rule, "-n", "400", "-j", threads, "--out", &out],
        );
        let report = json(&said);
        let episodes = report["episodes"].as_u64().expect("a number");
        assert!((2..400).contains(&episodes), "{report}");
        assert!(
            report["until"]
                .as_str()
                .expect("words")
                .contains("decided at 90 %")
        );
        // What the rule asks is met; the requirement itself asks for more.
        assert_eq!(said.code, code_of_verdicts(&report), "{report}");
        ended.push((episodes, said.code, report["estimates"].to_string()));
        let kept = files(&folder.path().join(&out));
        ended.dedup();
        assert!(kept.contains_key("episodes.parquet"));
    }
    assert_eq!(ended.len(), 1, "{ended:?}");

    let said = simulate(folder.path(), &["--until", rule, "-n", "2", "--out", "few"]);
    assert!([1, 3].contains(&said.code), "{said:?}");
    assert_ne!(code_of_verdicts(&json(&said)), 0, "{said:?}");
    assert!(said.out.contains("was not decided"), "{said:?}");
}

#[test]
fn rules_that_cannot_be_are_refused_before_anything_runs() {
    let folder = command_study(&[]);
    for (rule, reason) in [
        ("soon", "is not a valid rule"),
        ("requirement x is decided at 99 %", "no requirement `x`"),
        ("requirement clear is decided at 99 %", "no threshold"),
        ("requirement stops is decided at 100 %", "confidence"),
        ("requirement stops is decided against 1.5 at 99 %", "1.5"),
    ] {
        let said = simulate(folder.path(), &["--until", rule, "--out", "out"]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{rule}: {said:?}");
        assert!(said.talk.contains(reason), "{rule}: {}", said.talk);
    }
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_simulator_that_never_works_is_told_with_what_it_said() {
    let fails = "    sys.exit(\"no licence for \" + seed)\n";
    let hangs = "    __import__(\"time\").sleep(600)\n";
    let leaves_nothing = "    return\n";
    // A busy machine takes its time to start a program.
    for (change, limit, reason) in [
        (fails, "60", "no licence for"),
        (hangs, "0.5", "did not end within 0.5 s"),
        (leaves_nothing, "60", "left no recording"),
    ] {
        let changed = format!("{SLOWLY}{change}");
        let limit = format!("limit_secs = {limit}");
        let folder = command_study(&[
            ("simulate.py", SLOWLY, &changed),
            ("ledger.toml", "limit_secs = 60", &limit),
        ]);
        let said = simulate(folder.path(), &["--out", "out"]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{said:?}");
        assert!(said.talk.contains(reason), "{}", said.talk);
        assert!(said.talk.contains("seed"), "{}", said.talk);
    }
    let folder = command_study(&[("ledger.toml", "\"python3\"", "\"no-such-program\"")]);
    let said = simulate(folder.path(), &["--out", "out"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("cannot be started"), "{}", said.talk);
}

#[test]
fn a_ledger_that_names_a_command_wrongly_is_refused_with_its_line() {
    for (old, new, reason) in [
        (
            "\"{recording}\"",
            "\"out.csv\"",
            "where to leave its recording",
        ),
        ("\"{seed}\"", "\"1\"", "its seed"),
        ("limit_secs = 60", "limit_secs = 0", "`limit_secs` must be"),
        ("leaves = \"csv\"", "leaves = \"a/b\"", "`leaves` must be"),
        (
            "stimulus = \"stimulus.toml\"",
            "stimulus = \"none.toml\"",
            "none.toml",
        ),
        (
            "episodes = 40",
            "episodes = 40\nearly_end = true",
            "does not end early",
        ),
        (
            "episodes = 40",
            "episodes = 40\nscene = \"stimulus.toml\"",
            "another source",
        ),
        ("episodes = 40", "episodes = 40\nkeep = \"some\"", "some"),
        (
            "episodes = 40",
            "episodes = 40\nuntil = { requirement = \"x\", confidence = 0.9 }",
            "no requirement `x`",
        ),
    ] {
        let folder = command_study(&[("ledger.toml", old, new)]);
        let said = corroborate(folder.path(), &["run", "."]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{new}: {said:?}");
        assert!(said.talk.contains(reason), "{new}: {}", said.talk);
    }
}
