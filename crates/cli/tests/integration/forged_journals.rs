//! Journals of episodes that somebody changed, line hashes and all that is formed from them included, as one would who wants another
//! result: `verify --deep` finds it. Needs `python3`, which the simulator is written in; nothing else.

use crate::support;

use serde_json::Value;
use std::path::Path;
use support::program::{Said, corroborate};
use support::{command_study, read};

/// Turns so many violations of `clear` into successes, and has the program form everything anew from that.
fn forge(study: &Path, many: usize) -> Vec<u64> {
    let journal = study.join("results/episodes/sim/journal");
    let text = read(&journal);
    let (mut lines, mut forged) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let record = line.split_once(",\"episode\":");
        let record = record.and_then(|(_, it)| it.strip_suffix('}'));
        let whole = record.and_then(|it| {
            let value: Value = serde_json::from_str(it).ok()?;
            Some((it, value))
        });
        match whole {
            Some((record, value))
                if forged.len() < many && value["judged"][1]["verdict"] == "violated" =>
            {
                // The last of the record's verdicts of monitors that is a violation: that of `clear`.
                let place = record.find("\"forms\"").expect("forms");
                let at = record[..place].rfind("\"violated\"").expect("a violation");
                let mut changed = record.to_owned();
                changed.replace_range(at..at + "\"violated\"".len(), "\"satisfied\"");
                let hash = &blake3::hash(changed.as_bytes()).to_hex()[..16];
                lines.push(format!("{{\"hash\":\"{hash}\",\"episode\":{changed}}}"));
                forged.push(value["number"].as_u64().expect("a number"));
            }
            _ => lines.push(line.to_owned()),
        }
    }
    std::fs::write(&journal, lines.join("\n") + "\n").expect("written");
    for made in ["evidence", "study.json", "comparison.json", "report.html"] {
        let path = study.join("results").join(made);
        _ = std::fs::remove_file(&path);
        _ = std::fs::remove_dir_all(&path);
    }
    let said = corroborate(study, &["run", "."]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    forged
}

fn clear(study: &Path) -> u64 {
    let result: Value =
        serde_json::from_str(&read(&study.join("results/study.json"))).expect("JSON");
    result["evidence"][0]["findings"][1]["measure"]["count"]
        .as_u64()
        .expect("a count")
}

fn verify(study: &Path, more: &[&str]) -> Said {
    let mut arguments = vec!["verify", "results", "--format", "json"];
    arguments.extend(more);
    corroborate(study, &arguments)
}

fn faults(said: &Said) -> Vec<String> {
    let report: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
    let all = report["faults"].as_array().expect("a list").iter();
    all.map(|it| format!("{} {}", it["place"], it["fault"]))
        .collect()
}

#[test]
fn recordings_that_are_kept_give_every_changed_verdict_away() {
    let folder = command_study(&[]);
    let path = folder.path();
    corroborate(path, &["run", "."]);
    let sound = verify(path, &["--deep", "--draw", "1"]);
    assert_eq!((sound.code, faults(&sound)), (0, vec![]), "{sound:?}");
    assert!(
        sound
            .out
            .contains("recordings of episodes have the same verdicts"),
        "{sound:?}"
    );
    let before = clear(path);
    let forged = forge(path, 5);
    assert_eq!((forged.len(), clear(path)), (5, before + 5));
    // What is formed from a changed journal follows from it.
    assert_eq!(verify(path, &[]).code, 0);
    let said = verify(path, &["--deep", "--episodes", "0"]);
    let found = faults(&said);
    assert_eq!(said.code, 1, "{said:?}");
    for number in &forged {
        let named = found
            .iter()
            .filter(|it| it.starts_with(&format!("\"episode {number}\"")));
        assert_eq!(named.count(), 1, "{number}: {found:?}");
    }
    assert_eq!(found.len(), 5, "{found:?}");
}

#[test]
fn without_recordings_the_episodes_that_are_drawn_do() {
    let folder = command_study(&[(
        "ledger.toml",
        "episodes = 40",
        "episodes = 40\nkeep = \"none\"",
    )]);
    let path = folder.path();
    corroborate(path, &["run", "."]);
    let sound = verify(path, &["--deep", "--episodes", "40"]);
    assert_eq!((sound.code, faults(&sound)), (0, vec![]), "{sound:?}");
    let forged = forge(path, 8);
    assert_eq!(forged.len(), 8);
    assert_eq!(
        faults(&verify(path, &["--deep", "--episodes", "40"])).len(),
        8
    );
    // Of draws of 6 of 40 episodes, of which 8 are changed, 24 % at most meet none.
    let mut met = 0;
    for draw in 1..=20 {
        let said = verify(
            path,
            &["--deep", "--episodes", "6", "--draw", &draw.to_string()],
        );
        assert_eq!(said.code == 1, !faults(&said).is_empty(), "{said:?}");
        met += u32::from(said.code == 1);
        let left = format!("34 of 40 episodes were not simulated again (drawn from {draw};");
        assert!(said.out.contains(&left), "{said:?}");
    }
    assert!(met >= 10, "{met} of 20");
    // Another draw each time, unless one is named.
    let drawn = |said: &Said| said.out.split("(drawn from ").nth(1).map(str::to_owned);
    let (one, other) = (verify(path, &["--deep"]), verify(path, &["--deep"]));
    assert_ne!(drawn(&one), drawn(&other));
}
