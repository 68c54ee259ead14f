//! A command that stays for many episodes, seeds that entries share, and numbers of a stimulus that vary: what they give is
//! what a process for each episode and a written number give. Needs `python3`; nothing else.

use crate::support;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use support::program::{Said, corroborate};
use support::{command_study, root};

/// The beginning of the simulator's `main`, and how it becomes one that is asked line by line.
const ONCE: &str = "    stimulus, seed, recording = sys.argv[1:]\n";
const MAIN: &str = "def main() -> None:\n";
const ASKED: &str = "def main() -> None:\n    for line in sys.stdin:\n        asked = json.loads(line)\n        \
    try:\n            once(asked['stimulus'], asked['seed'], asked['recording'])\n            print('{\"type\": \"recorded\"}', flush=True)\n        \
    except ValueError as error:\n            print(json.dumps({'type': 'error', 'message': str(error)}), flush=True)\n\n\ndef once(stimulus, seed, recording) -> None:\n";
const WORDS: &str = ", \"{stimulus}\", \"{seed}\", \"{recording}\"]";

/// The same study with a simulator that stays; `fault` is what it does at the beginning of an episode.
fn staying(fault: &str) -> tempfile::TempDir {
    command_study(&[
        ("simulate.py", MAIN, ASKED),
        ("simulate.py", ONCE, fault),
        ("ledger.toml", WORDS, "]\npersistent = true"),
    ])
}

fn simulate(folder: &Path, entry: &str, more: &[&str]) -> Said {
    let mut arguments = vec!["simulate", ".", entry, "--format", "json", "--out", "out"];
    arguments.extend(more);
    corroborate(folder, &arguments)
}

/// The recordings by name, with what is in them.
fn recordings(folder: &Path) -> BTreeMap<String, String> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    let name = |entry: &std::fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
    entries
        .filter(|entry| name(entry).ends_with(".csv"))
        .map(|entry| {
            let text = std::fs::read_to_string(entry.path()).expect("a recording");
            (name(&entry), text)
        })
        .collect()
}

#[test]
fn a_command_that_stays_gives_the_same_recordings() {
    let once = command_study(&[]);
    let said = simulate(once.path(), "sim", &[]);
    let expected = recordings(&once.path().join("out"));
    assert_eq!(expected.len(), 40, "{said:?}");
    for threads in ["1", "3"] {
        let stays = staying("");
        let again = simulate(stays.path(), "sim", &["--threads", threads]);
        assert_eq!(again.code, said.code, "{again:?}");
        assert_eq!(recordings(&stays.path().join("out")), expected);
    }
}

#[test]
fn its_failures_count_as_those_of_a_process_for_each_episode() {
    let fault = "    if int(seed) % 4 == 0: raise ValueError('it tipped over')\n";
    let mut shown = Vec::new();
    for folder in [
        command_study(&[("simulate.py", ONCE, &format!("{ONCE}{fault}"))]),
        staying(fault),
        // It takes the process with it.
        staying("    if int(seed) % 4 == 0: sys.exit('it tipped over')\n"),
    ] {
        let said = simulate(folder.path(), "sim", &[]);
        let report: Value = serde_json::from_str(&said.out).expect("a report");
        let out = folder.path().join("out");
        let words = std::fs::read_dir(&out).expect("a folder").flatten();
        let words: Vec<String> = words
            .filter(|it| it.file_name().to_string_lossy().starts_with("failure-"))
            .map(|it| std::fs::read_to_string(it.path()).expect("words"))
            .collect();
        assert!(words.len() > 2, "{said:?}");
        assert!(
            words.iter().all(|it| it.contains("it tipped over")),
            "{words:?}"
        );
        shown.push((words.len(), report["failures"].clone(), recordings(&out)));
    }
    assert_eq!(shown[0], shown[1]);
    assert_eq!(shown[0], shown[2]);
}

#[test]
fn one_that_remembers_episodes_is_found_out() {
    let remembers =
        "    once.count = getattr(once, 'count', 0) + 1\n    seed = int(seed) + once.count\n";
    for (fault, code, said) in [("", 0, "the same again\n"), (remembers, 1, "NOT the same")] {
        let folder = staying(fault);
        let arguments = [
            "engines",
            ".",
            "sim",
            "-n",
            "3",
            "--determinism",
            "--threads",
            "1",
        ];
        let told = corroborate(folder.path(), &arguments);
        assert_eq!(told.code, code, "{told:?}");
        assert!(told.out.contains(said), "{told:?}");
    }
}

#[test]
fn one_that_never_works_is_told_with_what_it_said() {
    for (fault, limit, reason) in [
        (
            "    print('ready')\n",
            "60",
            "`ready`, which is not an answer",
        ),
        (
            "    __import__('time').sleep(600)\n",
            "0.5",
            "no answer within 0.5 s",
        ),
        ("    return\n", "60", "left no recording"),
    ] {
        let folder = staying(fault);
        let ledger = folder.path().join("ledger.toml");
        let text = std::fs::read_to_string(&ledger).expect("a ledger");
        let text = text.replace("limit_secs = 60", &format!("limit_secs = {limit}"));
        std::fs::write(&ledger, text).expect("written");
        let said = simulate(folder.path(), "sim", &[]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{said:?}");
        assert!(said.talk.contains(reason), "{}", said.talk);
    }
}

#[test]
fn entries_that_share_seeds_have_the_same_episodes() {
    let ledger = root().join("conformance/command/ledger.toml");
    let entry = std::fs::read_to_string(ledger).expect("a ledger");
    let entry = &entry[entry.find("[[evidence]]").expect("an entry")..];
    let shared = entry.replace("id = \"sim\"", "id = \"again\"\nseeds = \"sim\"");
    let own = entry.replace("id = \"sim\"", "id = \"other\"");
    let folder = command_study(&[("ledger.toml", entry, &format!("{entry}\n{shared}\n{own}"))]);
    let of = |id: &str| {
        let _ = std::fs::remove_dir_all(folder.path().join("out"));
        simulate(folder.path(), id, &["--episodes", "3"]);
        recordings(&folder.path().join("out"))
    };
    let first = of("sim");
    assert_eq!(first.len(), 3);
    assert_eq!(of("again"), first);
    assert_ne!(of("other"), first);
}

#[test]
fn two_entries_are_held_against_each_other_with_the_same_seeds() {
    let ledger = root().join("conformance/command/ledger.toml");
    let entry = std::fs::read_to_string(ledger).expect("a ledger");
    let entry = &entry[entry.find("[[evidence]]").expect("an entry")..];
    let again = entry.replace("id = \"sim\"", "id = \"again\"");
    let other = entry.replace("id = \"sim\"", "id = \"other\"");
    let other = other.replace("stimulus.toml", "other.toml");
    let folder = command_study(&[("ledger.toml", entry, &format!("{entry}\n{again}\n{other}"))]);
    let stimulus = std::fs::read_to_string(folder.path().join("stimulus.toml")).expect("a text");
    let stronger = stimulus.replace("= 60", "= 600");
    std::fs::write(folder.path().join("other.toml"), stronger).expect("written");
    let against = |other: &str| {
        let arguments = [
            "engines",
            ".",
            "sim",
            "--against",
            other,
            "--format",
            "json",
            "-n",
            "4",
        ];
        let said = corroborate(folder.path(), &arguments);
        let report: Value = serde_json::from_str(&said.out).unwrap_or_default();
        (said, report)
    };
    let (said, report) = against("again");
    assert_eq!(said.code, 0, "{said:?}");
    assert_eq!(report["engines"], serde_json::json!(["sim", "again"]));
    let signals = report["signals"].as_array().expect("signals");
    assert!(
        !signals.is_empty() && signals.iter().all(|it| it["largest"] == 0.0),
        "{report}"
    );
    let (said, report) = against("other");
    let signals = report["signals"].as_array().expect("signals");
    let speed = signals
        .iter()
        .find(|it| it["signal"] == "/cart.speed")
        .expect("speed");
    assert!(speed["largest"].as_f64() > Some(1.0), "{said:?}");
    let (said, _) = against("none");
    assert_eq!(said.code, 2, "{said:?}");
}

#[test]
fn numbers_of_a_stimulus_vary_as_the_seed_draws_them() {
    let folder = command_study(&[
        ("stimulus.toml", "= 150", "= { uniform = [100.0, 200.0] }"),
        ("simulate.py", "draws.uniform(0.8, 1.2)", "1.0"),
    ]);
    let speeds = |more: &[&str]| -> Vec<f64> {
        let _ = std::fs::remove_dir_all(folder.path().join("out"));
        simulate(folder.path(), "sim", more);
        let all = recordings(&folder.path().join("out"));
        all.values()
            .map(|text| text.lines().nth(1).expect("a row"))
            .map(|row| {
                row.split(',')
                    .nth(2)
                    .expect("a speed")
                    .parse()
                    .expect("a number")
            })
            .collect()
    };
    let all = speeds(&[]);
    assert!(all.iter().all(|it| (100.0..200.0).contains(it)), "{all:?}");
    // Of 40 uniform numbers a quarter above and below, but for a probability of 1e-4.
    let slow = all.iter().filter(|it| **it < 125.0).count();
    assert!((1..25).contains(&slow), "{all:?}");
    assert_eq!(speeds(&["--threads", "1"]), all);
    assert_ne!(speeds(&["--seed", "5"]), all);
    let wrong = command_study(&[("stimulus.toml", "= 150", "= { uniform = [200.0, 100.0] }")]);
    let said = simulate(wrong.path(), "sim", &[]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("cart.speed_cm_per_s"), "{}", said.talk);
}

#[test]
fn keys_that_do_not_fit_are_refused() {
    for (old, new, reason) in [
        (
            "limit_secs = 60",
            "persistent = true",
            "is not told `{stimulus}`",
        ),
        (
            "limit_secs = 60",
            "seeds = \"none\"",
            "must name another entry",
        ),
        (
            "limit_secs = 60",
            "seeds = \"sim\"",
            "must name another entry",
        ),
    ] {
        let folder = command_study(&[("ledger.toml", old, new)]);
        let said = corroborate(folder.path(), &["run", "."]);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{new}: {said:?}");
        assert!(said.talk.contains(reason), "{new}: {}", said.talk);
    }
}
