//! Datasets of LeRobot as evidence, in both kinds of layout.

use crate::episodes::{counted, run, study, write};
use crate::support::Copy;
use recording::{Cell, ParquetColumn, ParquetType, ParquetWriter};

/// A table with these columns, whose cells stand row by row.
fn table(columns: &[(&str, ParquetType)], rows: &[Vec<Cell<'_>>]) -> Vec<u8> {
    let columns = columns
        .iter()
        .map(|(name, kind)| ParquetColumn::new(*name, *kind).optional());
    let mut table = ParquetWriter::new(Vec::new(), columns.collect(), &[]).expect("columns");
    for row in rows {
        table.push(row).expect("a row");
    }
    table.finish().expect("written")
}

fn put(study: &Copy, name: &str, bytes: &[u8]) {
    let path = study.path(name);
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
    std::fs::write(path, bytes).expect("written");
}

/// The list of episodes, of these tasks and with so many frames each.
fn listed(tasks: &[&str], frames: u64) -> Vec<u8> {
    let rows: Vec<Vec<Cell<'_>>> = tasks
        .iter()
        .zip(0..)
        .map(|(task, number)| vec![Cell::U64(number), Cell::Text(task), Cell::U64(frames)])
        .collect();
    let columns = [
        ("episode_index", ParquetType::U64),
        ("tasks", ParquetType::Text),
        ("length", ParquetType::U64),
    ];
    table(&columns, &rows)
}

/// Frames of these episodes: the last but one says whether the episode succeeded.
fn frames(episodes: &[(u64, bool)], count: u64) -> Vec<u8> {
    let frame = |(number, won): &(u64, bool), at: u64| {
        vec![Cell::U64(*number), Cell::Bool(*won && at + 2 == count)]
    };
    let rows: Vec<Vec<Cell<'_>>> = episodes
        .iter()
        .flat_map(|it| (0..count).map(move |at| frame(it, at)))
        .collect();
    table(
        &[
            ("episode_index", ParquetType::U64),
            ("next.success", ParquetType::Bool),
        ],
        &rows,
    )
}

fn info(version: &str, episodes: usize) -> String {
    format!(
        "{{\"codebase_version\": \"{version}\", \"total_episodes\": {episodes}, \"fps\": 10, \
         \"features\": {{\"next.success\": {{\"dtype\": \"bool\", \"shape\": [1]}}}}}}"
    )
}

const LIST: &str = "set/meta/episodes/chunk-000/file-000.parquet";
const DATA: &str = "set/data/chunk-000/file-000.parquet";
const MORE: &str = "set/data/chunk-000/file-001.parquet";

/// Four episodes of two tasks, of which three succeeded, in two files.
fn third() -> Copy {
    let study = study("set", "task");
    write(&study, "set/meta/info.json", &info("v3.0", 4));
    put(
        &study,
        LIST,
        &listed(&["pick", "pick", "place", "place"], 5),
    );
    put(
        &study,
        DATA,
        &frames(&[(0, true), (1, false), (2, true)], 5),
    );
    put(&study, MORE, &frames(&[(3, true)], 5));
    study
}

#[test]
fn frames_of_a_dataset_say_which_episodes_succeeded() {
    let study = third();
    let evidence = run(&study).expect("read");
    let (count, trials, _) = counted(&evidence);
    assert_eq!((count, trials), (3, 4));
    let settings = &evidence.tool.settings;
    assert!(
        settings.contains("4 episodes of one checkpoint")
            && settings.contains("(2 clusters); of those that were saved"),
        "{settings}"
    );
    // Which files it rests on is part of the evidence.
    let paths: Vec<&str> = evidence.assets.iter().map(|it| it.path.as_str()).collect();
    assert!(
        [LIST, DATA, MORE, "set/meta/info.json"]
            .iter()
            .all(|it| paths.contains(it)),
        "{paths:?}"
    );
}

#[test]
fn what_episodes_say_of_themselves_counts_before_their_frames() {
    let study = third();
    let columns = [
        ("episode_index", ParquetType::U64),
        ("success", ParquetType::Bool),
    ];
    let rows: Vec<Vec<Cell<'_>>> = (0..4)
        .map(|it| vec![Cell::U64(it), Cell::Bool(it == 0)])
        .collect();
    put(&study, LIST, &table(&columns, &rows));
    study.edit("ledger.toml", "cluster = \"task\"", "cluster = \"episode\"");
    let (count, trials, _) = counted(&run(&study).expect("read"));
    assert_eq!((count, trials), (1, 4));
    let rows: Vec<Vec<Cell<'_>>> = (0..4)
        .map(|it| {
            vec![
                Cell::U64(it),
                if it == 2 {
                    Cell::Missing
                } else {
                    Cell::Bool(true)
                },
            ]
        })
        .collect();
    put(&study, LIST, &table(&columns, &rows));
    let problem = run(&study).expect_err("one is missing").to_string();
    assert!(problem.contains("episode 2 does not say"), "{problem}");
}

/// The layout before: lines of JSON, and a file for each episode.
#[test]
fn the_second_version_has_frames_too() {
    let study = study("set", "task");
    write(&study, "set/meta/info.json", &info("v2.1", 2));
    write(
        &study,
        "set/meta/episodes.jsonl",
        "{\"episode_index\": 0, \"tasks\": [\"pick\"], \"length\": 3}\n{\"episode_index\": 1, \"tasks\": [\"place\"], \"length\": 3}\n",
    );
    put(
        &study,
        "set/data/chunk-000/episode_000000.parquet",
        &frames(&[(0, true)], 3),
    );
    put(
        &study,
        "set/data/chunk-000/episode_000001.parquet",
        &frames(&[(1, false)], 3),
    );
    let (count, trials, _) = counted(&run(&study).expect("read"));
    assert_eq!((count, trials), (1, 2));
}

/// What `lerobot-eval` leaves: a dataset for each task and environment.
#[test]
fn datasets_of_a_folder_are_one_policy_where_its_evaluation_recorded_them() {
    let study = study("out/recordings", "checkpoint");
    for (task, won) in [("pusht_0/env_0", true), ("pusht_0/env_1", false)] {
        let folder = format!("out/recordings/{task}");
        write(
            &study,
            &format!("{folder}/meta/info.json"),
            &info("v3.0", 1),
        );
        put(
            &study,
            &format!("{folder}/meta/episodes/chunk-000/file-000.parquet"),
            &listed(&["push"], 5),
        );
        put(
            &study,
            &format!("{folder}/data/chunk-000/file-000.parquet"),
            &frames(&[(0, won)], 5),
        );
    }
    study.edit(
        "ledger.toml",
        "tables.cluster",
        "tables.one_for_all = \"Only this policy.\"\ntables.cluster",
    );
    let evidence = run(&study).expect("read");
    assert_eq!(counted(&evidence).1, 2);
    assert!(
        evidence.tool.settings.contains("of one checkpoint"),
        "{}",
        evidence.tool.settings
    );
    // Its own file has the episodes that it ended itself, too.
    write(&study, "out/eval_info.json", "{}");
    let problem = run(&study)
        .expect_err("the evaluation's own file")
        .to_string();
    assert!(
        problem.contains("out/eval_info.json") && problem.contains("recordings lack episodes"),
        "{problem}"
    );
    // The same recording twice.
    std::fs::remove_file(study.path("out/eval_info.json")).expect("removed");
    for file in [
        "meta/episodes/chunk-000/file-000.parquet",
        "data/chunk-000/file-000.parquet",
    ] {
        let of = |which: &str| study.path(&format!("out/recordings/pusht_0/{which}/{file}"));
        std::fs::copy(of("env_0"), of("env_1")).expect("copied");
    }
    let problem = run(&study).expect_err("a copy").to_string();
    assert!(
        problem.contains("env_1 has the same episodes as") && problem.contains("env_0"),
        "{problem}"
    );
}

#[test]
fn what_a_dataset_lacks_is_named() {
    let fails = |change: &dyn Fn(&Copy), said: &[&str]| {
        let study = third();
        change(&study);
        let problem = run(&study).expect_err(said[0]);
        let shown = problem.to_string();
        assert!(
            said.iter().all(|it| shown.contains(it)),
            "no {said:?}: {shown}"
        );
        assert!(problem.what_to_do().is_some(), "{shown}");
    };
    let remove =
        |study: &Copy, name: &str| std::fs::remove_file(study.path(name)).expect("removed");
    fails(
        &|it| remove(it, MORE),
        &["episode 3 should have 5 frames, and 0 are there"],
    );
    fails(
        &|it| put(it, MORE, &frames(&[(3, true)], 4)),
        &["episode 3 should have 5 frames, and 4 are there"],
    );
    fails(
        &|it| put(it, MORE, &frames(&[(3, true), (7, true)], 5)),
        &["frames of 1 episode", "is 7"],
    );
    fails(
        &|it| write(it, "set/meta/info.json", &info("v3.0", 5)),
        &["`total_episodes` is 5, and 4 are there"],
    );
    fails(
        &|it| write(it, "set/meta/info.json", &info("v1.6", 4)),
        &["version is `v1.6`"],
    );
    fails(
        &|it| write(it, "set/meta/info.json", &info("v4.0", 4)),
        &["version is `v4.0`"],
    );
    fails(
        &|it| {
            write(
                it,
                "set/meta/info.json",
                "{\"codebase_version\": \"v3.0\", \"features\": {\"action\": {}}}",
            )
        },
        &["does not say whether its episodes succeeded"],
    );
    fails(&|it| remove(it, LIST), &["set/meta/episodes has no tables"]);
    fails(
        &|it| std::fs::remove_dir_all(it.path("set/data")).expect("removed"),
        &["data"],
    );
    fails(
        &|it| {
            write(
                it,
                DATA,
                "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
            )
        },
        &[DATA, "Git LFS"],
    );
    fails(
        &|it| {
            let whole = std::fs::read(it.path(DATA)).expect("read");
            put(it, DATA, &whole[..whole.len() - 9]);
        },
        &[DATA, "not written to its end"],
    );
    let twice = [(LIST, ParquetType::U64)].map(|_| vec![Cell::U64(0)]);
    let twice = [twice[0].clone(), twice[0].clone()];
    fails(
        &|it| {
            put(
                it,
                LIST,
                &table(&[("episode_index", ParquetType::U64)], &twice),
            )
        },
        &["the episode 0 stands in", "too"],
    );
    let odd = [vec![Cell::U64(0), Cell::Double(0.5)]];
    fails(
        &|it| {
            put(
                it,
                MORE,
                &table(
                    &[
                        ("episode_index", ParquetType::U64),
                        ("next.success", ParquetType::Double),
                    ],
                    &odd,
                ),
            )
        },
        &["row 0: [0.5] is neither true nor false"],
    );
}

/// No changed byte of a dataset makes it panic: it is an error with the file's name, or another count.
#[test]
fn changed_bytes_of_a_dataset_are_errors_or_other_episodes() {
    let study = third();
    let (mut errors, mut read) = (0, 0);
    for name in ["set/meta/info.json", LIST, DATA] {
        let whole = std::fs::read(study.path(name)).expect("read");
        for at in (0..whole.len()).step_by(7) {
            let mut bytes = whole.clone();
            bytes[at] ^= [0xFF, 0x80, 0x01][at % 3];
            put(&study, name, &bytes);
            match run(&study) {
                Ok(_) => read += 1,
                Err(problem) => {
                    assert!(!problem.to_string().is_empty());
                    errors += 1;
                }
            }
        }
        put(&study, name, &whole);
    }
    assert!(errors > 50 && read > 5, "{errors} errors, {read} read");
}

/// What `lerobot` 0.4.4 has written (`tests/files/make_lerobot.py`), with every column that it writes.
#[test]
fn datasets_of_lerobot_itself_are_read() {
    let files = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files/lerobot");
    let study = study("set", "task");
    copy(&files.join("set"), &study.path("set"));
    let evidence = run(&study).expect("read");
    let (count, trials, _) = counted(&evidence);
    assert_eq!((count, trials), (3, 5));
    assert!(
        evidence.tool.settings.contains("(2 clusters)"),
        "{}",
        evidence.tool.settings
    );
    assert!(
        evidence
            .assets
            .iter()
            .any(|it| it.path.ends_with("data/chunk-000/file-001.parquet"))
    );
    let other = self::study("demonstrations", "task");
    copy(&files.join("demonstrations"), &other.path("demonstrations"));
    let problem = run(&other).expect_err("it does not say what succeeded");
    assert!(
        problem
            .to_string()
            .contains("neither `success` of its episodes nor the feature `next.success`"),
        "{problem}"
    );
    assert!(problem.place().is_some(), "{problem}");
}

fn copy(from: &std::path::Path, to: &std::path::Path) {
    std::fs::create_dir_all(to).expect("made");
    for entry in std::fs::read_dir(from).expect("a folder") {
        let entry = entry.expect("an entry");
        let (own, new) = (entry.path(), to.join(entry.file_name()));
        match own.is_dir() {
            true => copy(&own, &new),
            false => {
                std::fs::copy(&own, &new).expect("copied");
            }
        }
    }
}
