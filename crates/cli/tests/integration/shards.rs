//! A study's episodes on several machines, as a user meets them: shards in any order, some of them twice, one that was ended, and
//! what is refused. Needs `python3`, which the simulator is written in; nothing else.

use crate::support;

use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use support::program::{Said, command, corroborate};
use support::{command_study, read, root, schema};

/// The command study, whose stopping rule ends it before its last episode.
const UNTIL: (&str, &str, &str) = (
    "ledger.toml",
    "episodes = 40",
    "episodes = 40\nuntil = { requirement = \"stops\", threshold = 0.2, confidence = 0.9 }",
);

/// The episodes of results, with their content. Recordings of episodes that ran ahead of the one at which a stopping rule ended it, as many
/// as there were threads, are not of them.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    fn add(folder: &Path, under: &str, found: &mut BTreeMap<String, Vec<u8>>) {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            let name = format!("{under}{}", entry.file_name().to_string_lossy());
            match entry.path().is_dir() {
                true => add(&entry.path(), &format!("{name}/"), found),
                false => _ = found.insert(name, std::fs::read(entry.path()).expect("a file")),
            }
        }
    }
    let mut found = BTreeMap::new();
    add(&folder.join("episodes"), "episodes/", &mut found);
    let journal = String::from_utf8(found["episodes/sim/journal"].clone()).expect("text");
    let last = journal.lines().count() - 1;
    let number = |name: &str| {
        let stem = name.strip_prefix("episodes/sim/episode-")?;
        stem.strip_suffix(".csv")?.parse::<usize>().ok()
    };
    found.retain(|name, _| number(name).is_none_or(|it| it <= last));
    found
}

/// The evidence of the simulator in a result, without what it cost.
fn evidence(out: &Path) -> Value {
    let study: Value = serde_json::from_str(&read(&out.join("study.json"))).expect("JSON");
    study["evidence"].clone()
}

fn shard(folder: &Path, of: &str, out: &str) -> Said {
    corroborate(folder, &["run", "--shard", of, "--out", out])
}

fn merge(folder: &Path, shards: &[&str], out: &str) -> Said {
    let mut arguments = vec!["merge", ".", "--out", out, "--format", "json"];
    arguments.extend(shards);
    corroborate(folder, &arguments)
}

fn holds_to(name: &str, report: &Value) {
    let schema = read(&root().join("schemas").join(name));
    let schema: Value = serde_json::from_str(&schema).expect("a schema");
    let violations = schema::violations(&schema, report);
    assert!(violations.is_empty(), "{violations:?}");
}

#[test]
fn shards_merge_to_what_one_machine_gives_byte_for_byte() {
    for changes in [&[][..], &[UNTIL][..]] {
        let folder = command_study(changes);
        let path = folder.path();
        let whole = corroborate(path, &["run", ".", "--out", "whole"]);
        assert!([0, 1, 3].contains(&whole.code), "{whole:?}");
        for k in 1..=3 {
            let said = shard(path, &format!("{k}/3"), &format!("part-{k}"));
            assert_eq!(said.code, 0, "{said:?}");
            let report = read(&path.join(format!("part-{k}/shard.json")));
            holds_to(
                "shard.schema.json",
                &serde_json::from_str(&report).expect("JSON"),
            );
        }
        // Another division of the same episodes, of which some are there already.
        assert_eq!(shard(path, "2/4", "more").code, 0);
        let said = merge(path, &["part-3", "more", "part-1", "part-2"], "merged");
        assert_eq!(said.code, 0, "{said:?}");
        let report: Value = serde_json::from_str(&said.out).expect("JSON");
        holds_to("merge.schema.json", &report);
        let campaign = &report["campaigns"][0];
        assert_eq!(campaign["is_decided"], !changes.is_empty(), "{report}");
        assert!(
            changes.len() == 1 || campaign["repeated"].as_u64() > Some(5),
            "{report}"
        );
        let said = corroborate(path, &["run", ".", "--out", "merged"]);
        assert_eq!(said.code, whole.code, "{said:?}");
        assert!(evidence(&path.join("whole")) == evidence(&path.join("merged")));
        let (one, several) = (results(&path.join("whole")), results(&path.join("merged")));
        let names = |of: &BTreeMap<String, Vec<u8>>| of.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&one), names(&several));
        assert!(one == several);
        // What was merged is sound, and merging once more changes nothing.
        let verified = corroborate(path, &["verify", "merged", "."]);
        assert_eq!(verified.code, 0, "{verified:?}");
        let again = merge(path, &["part-1", "part-2", "part-3"], "merged");
        let again: Value = serde_json::from_str(&again.out).expect("JSON");
        assert_eq!(again["campaigns"][0]["taken"], 0, "{again}");
    }
}

#[test]
fn a_shard_that_was_ended_goes_on_and_one_that_is_missing_is_named() {
    let slow = (
        "simulate.py",
        "    stimulus, seed, recording = sys.argv[1:]\n",
        "    stimulus, seed, recording = sys.argv[1:]\n    __import__(\"time\").sleep(0.05)\n",
    );
    let folder = command_study(&[slow]);
    let path = folder.path();
    let arguments = ["run", "--shard", "1/2", "--out", "one", "-j", "1"];
    let mut child = command(path, &arguments)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("it starts");
    let begun = || std::fs::read_dir(path.join("one/episodes/sim")).map_or(0, Iterator::count);
    while begun() < 6 && child.try_wait().expect("a state").is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    // It is not complete, so it is none yet.
    let said = merge(path, &["one"], "results");
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("error[no-shard]"), "{said:?}");
    assert_eq!(corroborate(path, &arguments).code, 0);
    assert_eq!(shard(path, "3/4", "third").code, 0);
    assert_eq!(shard(path, "4/4", "fourth").code, 0);

    let said = merge(path, &["fourth", "one"], "results");
    assert_eq!(said.code, 3, "{said:?}");
    let report: Value = serde_json::from_str(&said.out).expect("JSON");
    let campaign = &report["campaigns"][0];
    assert_eq!(campaign["taken"], 20, "{report}");
    assert_eq!(campaign["missing"], serde_json::json!([21, 30]), "{report}");
    // The others come later; what was taken is not taken again.
    let said = merge(path, &["one", "fourth", "third"], "results");
    let report: Value = serde_json::from_str(&said.out).expect("JSON");
    assert_eq!(
        (said.code, &report["campaigns"][0]["taken"]),
        (0, &20.into()),
        "{report}"
    );
    let whole = corroborate(path, &["run", ".", "--out", "whole"]);
    assert_eq!(corroborate(path, &["run", "."]).code, whole.code);
    assert!(evidence(&path.join("whole")) == evidence(&path.join("results")));
}

#[test]
fn what_is_not_a_shard_of_this_study_is_refused() {
    let folder = command_study(&[]);
    let path = folder.path();
    for (of, out) in [("1/2", "one"), ("2/2", "two")] {
        assert_eq!(shard(path, of, out).code, 0);
    }
    let refused = |code: &str, exit: i32| {
        let said = merge(path, &["one", "two"], "results");
        assert_eq!(said.code, exit, "{code}: {said:?}");
        assert!(said.talk.contains(&format!("error[{code}]")), "{said:?}");
        assert!(said.talk.contains("help: "), "{said:?}");
    };
    // A recording that is not the one that was judged.
    let recording = path.join("two/episodes/sim/episode-00030.csv");
    let bytes = std::fs::read(&recording).expect("a recording");
    std::fs::write(&recording, b"time\n0\n").expect("written");
    refused("other-recording", 3);
    assert!(!path.join("results/episodes/sim/episode-00030.csv").exists());
    // Nor is a link, wherever it leads.
    std::fs::remove_file(&recording).expect("removed");
    host::system::link(std::path::Path::new("/etc/hostname"), &recording).expect("linked");
    refused("other-recording", 3);
    std::fs::remove_file(&recording).expect("removed");
    std::fs::write(&recording, &bytes).expect("written");
    assert_eq!(merge(path, &["one", "two"], "results").code, 0);

    // The same episode with another result: its line in the journal is whole, as if another machine had computed it.
    std::fs::remove_dir_all(path.join("results")).expect("removed");
    assert_eq!(shard(path, "1/1", "all").code, 0);
    let journal = path.join("all/episodes/sim/journal");
    let text = read(&journal);
    let line = text.lines().nth(3).expect("an episode");
    let (head, record) = line.split_once(",\"episode\":").expect("a record");
    let record = record.strip_suffix('}').expect("an object");
    let record = record.replacen("\"end\":\"complete\"", "\"end\":\"incomplete\"", 1);
    let hash = &blake3::hash(record.as_bytes()).to_hex()[..16];
    assert!(head.starts_with("{\"hash\":\""), "{head}");
    let forged = format!("{{\"hash\":\"{hash}\",\"episode\":{record}}}");
    std::fs::write(&journal, text.replace(line, &forged)).expect("written");
    let said = merge(path, &["one", "all", "two"], "results");
    assert_eq!(said.code, 3, "{said:?}");
    assert!(said.talk.contains("error[shards-differ]"), "{said:?}");
    assert!(said.talk.contains("episode 3 is another in"), "{said:?}");

    // Another seed, and another simulator.
    let about = read(&path.join("study.toml"));
    let seed = about
        .lines()
        .find(|line| line.starts_with("seed"))
        .expect("a seed");
    std::fs::write(path.join("study.toml"), about.replace(seed, "seed = 4711")).expect("written");
    refused("other-shard", 2);
    std::fs::write(path.join("study.toml"), &about).expect("written");
    let script = read(&path.join("simulate.py"));
    std::fs::write(path.join("simulate.py"), script + "\n").expect("written");
    refused("other-shard", 2);
}

#[test]
fn a_shard_that_cannot_be_is_refused() {
    let folder = command_study(&[]);
    for (of, code) in [("0/2", 2), ("3/2", 2), ("a/b", 2)] {
        let said = shard(folder.path(), of, "out");
        assert_eq!(said.code, code, "{said:?}");
        assert!(said.talk.contains("must be one of 1/N to N/N"), "{said:?}");
    }
    let said = corroborate(folder.path(), &["run", "--shard", "1/2"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("--out"), "{said:?}");
    let study = support::planted::Planted::of_model_and_counts([
        "[[requirement]]\nid = \"r\"\ntext = \"It holds.\"\nproperty = 'P=? [ F \"a\" ]'\nmargin = 0.1\nthreshold = \"at least 0.5\"\n",
        "a = { meaning = \"a\", model = \"s=1\" }\n",
        "dtmc\nmodule m\n s : [0..1] init 0;\n [] s=0 -> (s'=1);\n [] s=1 -> true;\nendmodule\n",
        "requirement,covered,passed,failed\nr,10,10,0\n",
    ]);
    let said = shard(study.path(), "1/2", "out");
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("error[nothing-to-shard]"), "{said:?}");
}
