//! Datasets of LeRobot: which episodes they have, and whether each succeeded.
//!
//! # Definition
//! | version | episodes | frames |
//! |---|---|---|
//! | 2.0, 2.1 | a line each in `meta/episodes.jsonl` | `data/*/*.parquet`, a file for each episode |
//! | 3 | a row each in `meta/episodes/*/*.parquet` | `data/*/*.parquet`, many episodes in a file |
//!
//! An episode succeeded if its `success` among the episodes says so; where that is not there, if `next.success` is true in any of
//! its frames, which is how `lerobot-eval` counts.
//!
//! # Source
//! LeRobot's documentation of datasets, versions 2.1 and 3.0, and what `lerobot_dataset.py` and `lerobot_eval.py` write.
//!
//! # Guarantee
//! Nothing is left out: the episodes are as many as `total_episodes` says, each has as many frames as its `length` says, and no
//! frame is of an episode that is not there. A file that Git LFS has not fetched is told from a damaged one.
//!
//! # Assumes
//! The dataset has every episode that was run. `lerobot-eval` with `--eval.recording=true` saves an episode only once its
//! environment ends it; environments that never end a failed one by themselves (LIBERO's and VLABench's do not) leave recordings of
//! successes alone. So recordings beside the `eval_info.json` of the same evaluation are refused in its favour, and what the rate
//! speaks of says that it is of saved episodes.

use super::{COPIED, EVAL_INFO, Episode, bad, below, json, named, outcome, success};
use crate::technique::files::Files;
use diagnostic::{Problem, Source, counted};
use evidence::AssetRole;
use host::store::hash_of;
use recording::{ParquetRows, ParquetTable};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// What says that a folder is a dataset.
pub(super) const INFO: &str = "meta/info.json";
const LINES: &str = "meta/episodes.jsonl";
/// Whether the environment said that the task succeeded, frame by frame.
const SUCCESS: &str = "next.success";
/// The folder in which `lerobot-eval` puts its recordings.
const RECORDINGS: &str = "recordings";

const INCOMPLETE: &str =
    "complete the dataset: all files below `meta` and `data`, as they were published or recorded";

/// A dataset that was read.
pub(super) struct Dataset {
    pub(super) episodes: Vec<Episode>,
    /// The hash of what its episodes are read from.
    digest: String,
}

/// An episode as it is listed.
struct Listed {
    number: i64,
    task: Option<String>,
    frames: Option<i64>,
    success: Option<bool>,
}

/// The datasets at and below a path.
pub(super) fn all_below(
    study: &Path,
    path: &Path,
    reader: &Files<'_>,
) -> Result<Vec<Episode>, Problem> {
    let folders = below(study, path, &|folder| folder.join(INFO).is_file())?;
    if folders.is_empty() {
        let message = format!("{} has neither {EVAL_INFO} nor {INFO}", path.display());
        return Err(Problem::new("bad-evaluation", message).remedy(
            "name the folder of LeRobot's evaluations or of a dataset, or a table in CSV",
        ));
    }
    let mut known: BTreeMap<String, PathBuf> = BTreeMap::new();
    let mut episodes = Vec::new();
    for folder in folders {
        let dataset = read(&folder, study, reader)?;
        if let Some(first) = known.insert(dataset.digest, folder.clone()) {
            let (again, first) = (folder.display(), first.display());
            let message = format!(
                "{again} has the same episodes as {first}: it is one dataset under two names"
            );
            return Err(Problem::new("bad-evaluation", message).remedy(COPIED));
        }
        episodes.extend(dataset.episodes);
    }
    Ok(episodes)
}

/// The episodes of a dataset; paths are relative to the study's folder.
pub(super) fn read(path: &Path, study: &Path, reader: &Files<'_>) -> Result<Dataset, Problem> {
    refuse_recordings(path, study)?;
    let about = reader.text(AssetRole::Data, &path.join(INFO))?;
    let info = json(&about, 0, &about.text)?;
    let version = info
        .get("codebase_version")
        .and_then(Value::as_str)
        .unwrap_or_default();
    let mut digest = String::new();
    let mut listed = match version {
        _ if version.starts_with("v2.") => in_lines(path, reader, &mut digest)?,
        _ if version.starts_with("v3.") => in_tables(path, study, reader, &mut digest)?,
        _ => {
            let message = format!(
                "the dataset's version is `{version}`, and those that are read are 2.0, 2.1 and 3"
            );
            return Err(bad(&about, "codebase_version", message).remedy(
                "convert it with LeRobot, or write a table in CSV with a row for each episode (columns success, task, seed, checkpoint)",
            ));
        }
    };
    has_all(&about, &info, &listed)?;
    if listed.iter().all(|it| it.success.is_none()) {
        let has = info
            .get("features")
            .and_then(|it| it.get(SUCCESS))
            .is_some();
        if !has {
            let message = format!(
                "the dataset does not say whether its episodes succeeded: neither `success` of its episodes nor the feature `{SUCCESS}` is there"
            );
            return Err(bad(&about, "features", message).remedy(
                "do not take demonstrations for trials; where these episodes are, write a table in CSV with a row for each (columns success, task, seed, checkpoint)",
            ));
        }
        by_frames(path, study, reader, &mut listed, &mut digest)?;
    }
    let checkpoint = checkpoint(path);
    let episode = |it: Listed| {
        let won = it.success.ok_or_else(|| {
            let message = format!(
                "{}: episode {} does not say whether it succeeded",
                path.display(),
                it.number
            );
            Problem::new("bad-evaluation", message)
                .remedy("write `success` for every episode, or for none")
        })?;
        Ok(Episode {
            task: it.task,
            seed: None,
            checkpoint: Some(checkpoint.clone()),
            counted: outcome(won),
            other: None,
            is_saved: true,
        })
    };
    Ok(Dataset {
        episodes: listed
            .into_iter()
            .map(episode)
            .collect::<Result<_, Problem>>()?,
        digest,
    })
}

/// Recordings that `lerobot-eval` left beside its own file, which has all episodes.
fn refuse_recordings(path: &Path, study: &Path) -> Result<(), Problem> {
    for folder in path.ancestors().filter(|it| it.ends_with(RECORDINGS)) {
        let file = folder.with_file_name(EVAL_INFO);
        if study.join(&file).is_file() {
            let (dataset, file) = (path.display(), file.display());
            let message = format!(
                "{dataset} was recorded by the evaluation that {file} reports; recordings lack episodes that the evaluation alone ended"
            );
            return Err(Problem::new("bad-evaluation", message)
                .remedy(format!("name {file}, which counts all")));
        }
    }
    Ok(())
}

/// The policy of which a dataset is: its folder; in recordings of `lerobot-eval`, which has one for each task and environment, what
/// they are in.
fn checkpoint(path: &Path) -> String {
    let recordings = path.ancestors().find(|it| it.ends_with(RECORDINGS));
    let whole = recordings.and_then(Path::parent).unwrap_or(path);
    named(whole)
}

/// Holds the number of episodes against what the dataset says.
fn has_all(about: &Source, info: &Value, listed: &[Listed]) -> Result<(), Problem> {
    match info.get("total_episodes").and_then(Value::as_u64) {
        Some(stated) if stated != listed.len() as u64 => {
            let message = format!(
                "`total_episodes` is {stated}, and {} are there",
                listed.len()
            );
            Err(bad(about, "total_episodes", message).remedy(INCOMPLETE))
        }
        _ => Ok(()),
    }
}

/// Episodes as JSON, one on each line.
fn in_lines(path: &Path, reader: &Files<'_>, digest: &mut String) -> Result<Vec<Listed>, Problem> {
    let source = reader.text(AssetRole::Data, &path.join(LINES))?;
    digest.push_str(&hash_of(source.text.as_bytes()));
    let mut listed = Vec::new();
    let mut numbers = BTreeSet::new();
    let mut start = 0;
    for (at, line) in source.text.split_inclusive('\n').enumerate() {
        let from = start;
        start += line.len();
        if line.trim().is_empty() {
            continue;
        }
        let one = json(&source, from, line)?;
        // Without numbers they are counted, as the format does it.
        let number = one.get("episode_index").and_then(Value::as_i64);
        let number = number.unwrap_or(listed.len() as i64);
        if !numbers.insert(number) {
            let message = format!("line {}: the episode {number} stands twice", at + 1);
            return Err(Problem::new("bad-evaluation", message)
                .at(&source, from..from + line.trim_end().len())
                .remedy("leave one of them out; if they are others, number them so"));
        }
        let own = one.get("success").filter(|it| !it.is_null());
        let tasks = one.get("tasks").and_then(Value::as_array);
        listed.push(Listed {
            number,
            task: tasks.map(|all| joined(all.iter().filter_map(Value::as_str))),
            frames: one.get("length").and_then(Value::as_i64),
            success: match own {
                Some(own) => Some(success(&source, Some(own), &format!("line {}", at + 1))?),
                None => None,
            },
        });
    }
    Ok(listed)
}

fn joined<'a>(tasks: impl Iterator<Item = &'a str>) -> String {
    tasks.collect::<Vec<_>>().join("; ")
}

/// The tables `*/*.parquet` of a folder, in the order of their names.
fn tables(study: &Path, folder: &Path) -> Result<Vec<PathBuf>, Problem> {
    let listed = |folder: &Path| -> Result<Vec<PathBuf>, Problem> {
        let whole = study.join(folder);
        let cannot =
            |error: std::io::Error| Problem::cannot_read(&whole, &error).remedy(INCOMPLETE);
        let entries = std::fs::read_dir(&whole).map_err(cannot)?;
        let paths = entries.map(|it| it.map(|entry| folder.join(entry.file_name())));
        paths.collect::<Result<_, _>>().map_err(cannot)
    };
    let mut found = Vec::new();
    for chunk in listed(folder)? {
        if study.join(&chunk).is_dir() {
            let is_table = |it: &PathBuf| it.extension().is_some_and(|it| it == "parquet");
            found.extend(listed(&chunk)?.into_iter().filter(is_table));
        }
    }
    found.sort();
    match found.is_empty() {
        false => Ok(found),
        true => {
            let message = format!("{} has no tables `*/*.parquet`", folder.display());
            Err(Problem::new("bad-evaluation", message).remedy(INCOMPLETE))
        }
    }
}

/// A table's bytes.
fn bytes(path: &Path, reader: &Files<'_>, digest: &mut String) -> Result<Vec<u8>, Problem> {
    let bytes = reader.bytes(AssetRole::Data, path)?;
    if bytes.starts_with(b"version https://git-lfs") {
        let message = format!(
            "{} is what Git LFS has in place of the file",
            path.display()
        );
        return Err(Problem::new("bad-evaluation", message)
            .remedy("fetch the files: `git lfs pull` in the dataset's folder"));
    }
    digest.push_str(&hash_of(&bytes));
    Ok(bytes)
}

/// What is wrong with a table, and which.
fn damaged(path: &Path, message: impl std::fmt::Display) -> Problem {
    Problem::new("bad-evaluation", format!("{}: {message}", path.display()))
}

/// A column of a table.
fn column(path: &Path, table: &ParquetTable<'_>, name: &str) -> Result<ParquetRows, Problem> {
    table.column(name).map_err(|error| {
        damaged(path, &error).remedy(match error.is_unread_form {
            true => "write it again with pyarrow's own settings: `pq.write_table(pq.read_table(OLD), NEW)`",
            false => "fetch or record the dataset again",
        })
    })
}

fn opened<'a>(path: &Path, bytes: &'a [u8]) -> Result<ParquetTable<'a>, Problem> {
    ParquetTable::open(bytes)
        .map_err(|error| damaged(path, error).remedy("fetch or record the dataset again"))
}

/// The numbers of a column, of which none may be missing.
fn numbers(path: &Path, table: &ParquetTable<'_>, name: &str) -> Result<Vec<i64>, Problem> {
    let rows = column(path, table, name)?;
    let all: Option<Vec<i64>> = rows.ints().and_then(|all| all.into_iter().collect());
    all.ok_or_else(|| {
        damaged(
            path,
            format!("column `{name}` should have a whole number in each row"),
        )
        .remedy(INCOMPLETE)
    })
}

/// Truth values of a column, as such, as 0 and 1, or as lists of one.
fn truths(path: &Path, table: &ParquetTable<'_>, name: &str) -> Result<Vec<Option<bool>>, Problem> {
    let rows = column(path, table, name)?;
    let truth = |(at, row): (usize, Vec<f64>)| match row[..] {
        [] => Ok(None),
        [0.0] => Ok(Some(false)),
        [1.0] => Ok(Some(true)),
        _ => Err(damaged(
            path,
            format!("column `{name}`, row {at}: {row:?} is neither true nor false"),
        )
        .remedy("write true or false")),
    };
    match rows.numbers() {
        Some(all) => all.into_iter().enumerate().map(truth).collect(),
        None => Err(damaged(
            path,
            format!("column `{name}` holds texts, and should hold true and false"),
        )
        .remedy("write true or false")),
    }
}

/// Episodes as rows of tables.
fn in_tables(
    path: &Path,
    study: &Path,
    reader: &Files<'_>,
    digest: &mut String,
) -> Result<Vec<Listed>, Problem> {
    let mut listed = Vec::new();
    let mut known = BTreeMap::new();
    for file in tables(study, &path.join("meta/episodes"))? {
        let bytes = bytes(&file, reader, digest)?;
        let table = opened(&file, &bytes)?;
        let has = |name: &str| table.names().contains(&name);
        let frames = match has("length") {
            true => Some(numbers(&file, &table, "length")?),
            false => None,
        };
        let won = match has("success") {
            true => truths(&file, &table, "success")?,
            false => vec![None; table.rows()],
        };
        let rows = match has("tasks") {
            true => Some(column(&file, &table, "tasks")?),
            false => None,
        };
        let tasks = rows.as_ref().and_then(ParquetRows::texts);
        for (at, number) in numbers(&file, &table, "episode_index")?
            .into_iter()
            .enumerate()
        {
            if let Some(first) = known.insert(number, file.clone()) {
                let message = format!("the episode {number} stands in {}, too", first.display());
                return Err(damaged(&file, message)
                    .remedy("leave one of them out; if they are others, number them so"));
            }
            listed.push(Listed {
                number,
                task: tasks.as_ref().map(|all| joined(all[at].iter().copied())),
                frames: frames.as_ref().map(|all| all[at]),
                success: won[at],
            });
        }
    }
    Ok(listed)
}

/// Whether episodes succeeded, by their frames.
fn by_frames(
    path: &Path,
    study: &Path,
    reader: &Files<'_>,
    listed: &mut [Listed],
    digest: &mut String,
) -> Result<(), Problem> {
    // Of each episode how many frames there are, and whether it succeeded in one.
    let mut seen: BTreeMap<i64, (i64, bool)> = BTreeMap::new();
    let data = path.join("data");
    for file in tables(study, &data)? {
        let bytes = bytes(&file, reader, digest)?;
        let table = opened(&file, &bytes)?;
        let won = truths(&file, &table, SUCCESS)?;
        for (at, number) in numbers(&file, &table, "episode_index")?
            .into_iter()
            .enumerate()
        {
            let Some(won) = won[at] else {
                let message = format!(
                    "column `{SUCCESS}`, row {at}: a frame of episode {number} does not say whether it succeeded"
                );
                return Err(damaged(&file, message).remedy("write true or false"));
            };
            let episode = seen.entry(number).or_default();
            episode.0 += 1;
            episode.1 |= won;
        }
    }
    for it in listed.iter_mut() {
        let (frames, won) = seen.remove(&it.number).unwrap_or_default();
        if frames == 0 || it.frames.is_some_and(|stated| stated != frames) {
            let stated = it
                .frames
                .map_or("some".to_owned(), |stated| stated.to_string());
            let message = format!(
                "episode {} should have {stated} frames, and {frames} are there",
                it.number
            );
            return Err(damaged(&data, message).remedy(INCOMPLETE));
        }
        it.success = Some(won);
    }
    match seen.keys().next() {
        None => Ok(()),
        Some(number) => {
            let others = counted(seen.len(), "episode");
            let message = format!(
                "frames of {others} are there that `meta` does not list, the first of which is {number}"
            );
            Err(damaged(&data, message).remedy(INCOMPLETE))
        }
    }
}
