//! Episodes of a learned policy as a cohort: LeRobot's evaluations and datasets, and tables that teams make by hand.
//!
//! # Definition
//! An *episode* succeeded or not, and has a task, a checkpoint (the policy as it was saved) and a seed, as far as the file says.
//! Episodes of one *cluster* are alike: the ledger declares what makes them so (`tables.cluster`), and each cluster is a row of
//! a cohort, as a person is elsewhere.
//!
//! | file | episodes | task | seed | checkpoint |
//! |---|---|---|---|---|
//! | `eval_info.json` with `per_episode` (older) | `success` of each | the file's | `seed` | the file |
//! | `eval_info.json` with `per_task` (newer) | `metrics.successes` | `task_group/task_id` | not told | the file |
//! | a dataset with `meta/info.json` ([`dataset`]) | `success` of the episode, or `next.success` of its frames | `tasks` | not told | the folder |
//! | a table in CSV | a row each, `success`, and every column of truth values | `task` | `seed` | `checkpoint` |
//!
//! A file that holds several evaluations under names of their own has a checkpoint for each. In a folder all files `eval_info.json` are read, each a checkpoint by its folder's name;
//! if there are none, all datasets below it.
//!
//! # Source
//! LeRobot's `lerobot_eval.py` (both layouts).
//!
//! # Assumes
//! Episodes of different clusters are independent. Nothing is assumed of episodes of one cluster.
//!
//! # Guarantee
//! What a file says of its own sums (`pc_success`, `n_episodes`) is held against its episodes. The same seed of the same task and
//! checkpoint counts once: a second one is refused, as are the same episode's number or task twice in one file, and two files of
//! the same bytes, which are one evaluation under two names. An episode that does not say whether it succeeded is refused, not left out.

mod dataset;

use super::placed::{in_row, table_problem};
use crate::technique::files::Files;
use diagnostic::{Problem, Source, counted};
use evidence::AssetRole;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use study::Study;
use study::placed::quoted;
use trace::Table;

/// LeRobot's file of an evaluation.
const EVAL_INFO: &str = "eval_info.json";

/// What to do about an evaluation that is there twice.
const COPIED: &str =
    "leave one of them out, or put the other checkpoint's own evaluation in its place";

/// The episodes as a cohort, and of what they speak.
pub(super) struct Episodes {
    pub(super) cohort: Table,
    pub(super) speaks_of: String,
}

/// One episode.
struct Episode {
    task: Option<String>,
    seed: Option<String>,
    checkpoint: Option<String>,
    /// What is counted, by column.
    counted: Vec<(String, bool)>,
    /// The value of the column that is the cluster, where it is another one.
    other: Option<String>,
    /// Whether it is of a dataset, which has the episodes that were saved.
    is_saved: bool,
}

/// Reads the episodes of a file or folder, a path relative to the study's.
pub(super) fn read(
    study: &Study,
    path: &Path,
    cluster: &str,
    reader: &Files<'_>,
) -> Result<Episodes, Problem> {
    let whole = study.folder.join(path);
    let mut episodes = Vec::new();
    if !whole.is_dir() {
        let source = reader.text(AssetRole::Data, path)?;
        match path.extension().is_some_and(|it| it == "json") {
            true => episodes.extend(evaluation(&source, &named(path))?),
            false => episodes.extend(of_table(&source, cluster)?),
        }
    } else if whole.join(dataset::INFO).exists() {
        episodes.extend(dataset::read(path, &study.folder, reader)?.episodes);
    } else {
        let found = below(&study.folder, path, &|folder| {
            folder.join(EVAL_INFO).is_file()
        })?;
        match found.is_empty() {
            false => episodes.extend(evaluations(path, &found, reader)?),
            true => episodes.extend(dataset::all_below(&study.folder, path, reader)?),
        }
    }
    cohort(&path.display().to_string(), cluster, &episodes)
}

fn named(path: &Path) -> String {
    match path.to_string_lossy().replace('\\', "/") {
        name if name.is_empty() => ".".to_owned(),
        name => name,
    }
}

fn bad(source: &Source, word: &str, message: impl Into<String>) -> Problem {
    Problem::new("bad-evaluation", message).at(source, quoted(source, word))
}

/// The folders at and below a path for which `is_wanted` holds, in the order of their names. Below one of them none is looked for
/// unless it is the path itself.
fn below(
    study: &Path,
    path: &Path,
    is_wanted: &dyn Fn(&Path) -> bool,
) -> Result<Vec<PathBuf>, Problem> {
    const DEEPEST: usize = 12;
    let mut found = Vec::new();
    let mut folders = vec![(path.to_owned(), 0)];
    while let Some((folder, depth)) = folders.pop() {
        let whole = study.join(&folder);
        if is_wanted(&whole) {
            found.push(folder.clone());
        }
        let cannot = |error: std::io::Error| Problem::cannot_read(&whole, &error);
        for entry in std::fs::read_dir(&whole).map_err(cannot)? {
            let entry = entry.map_err(cannot)?;
            // A link to a folder may lead back.
            if entry.file_type().map_err(cannot)?.is_dir() && depth < DEEPEST {
                folders.push((folder.join(entry.file_name()), depth + 1));
            }
        }
    }
    found.sort();
    Ok(found)
}

/// The episodes of all evaluations in these folders.
fn evaluations(
    path: &Path,
    folders: &[PathBuf],
    reader: &Files<'_>,
) -> Result<Vec<Episode>, Problem> {
    let mut known: BTreeMap<String, PathBuf> = BTreeMap::new();
    let mut episodes = Vec::new();
    for folder in folders {
        let file = folder.join(EVAL_INFO);
        let source = reader.text(AssetRole::Data, &file)?;
        if let Some(first) = known.insert(source.text.clone(), file.clone()) {
            let message = format!(
                "{} has the same bytes as {}: it is one evaluation under two names",
                file.display(),
                first.display()
            );
            return Err(bad(&source, "", message).remedy(COPIED));
        }
        let own = folder.strip_prefix(path).unwrap_or(folder);
        episodes.extend(evaluation(&source, &named(own))?);
    }
    Ok(episodes)
}

/// Reads a part of a text as JSON as Python writes it, in which a number may be `NaN` or `Infinity`.
fn json(source: &Source, start: usize, text: &str) -> Result<Value, Problem> {
    let mut plain = String::with_capacity(text.len());
    let mut is_text = false;
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        let word = ["NaN", "-Infinity", "Infinity"]
            .into_iter()
            .find(|it| rest.starts_with(it));
        if let (false, Some(word)) = (is_text, word) {
            // As long as it was, so that places stay.
            let _ = write!(plain, "{:<1$}", "null", word.len());
            rest = &rest[word.len()..];
            continue;
        }
        let mut length = letter.len_utf8();
        if is_text && letter == '\\' {
            length += rest[1..].chars().next().map_or(0, char::len_utf8);
        }
        is_text ^= letter == '"';
        plain.push_str(&rest[..length]);
        rest = &rest[length..];
    }
    serde_json::from_str(&plain).map_err(|error| {
        let before: usize = text
            .split_inclusive('\n')
            .take(error.line().saturating_sub(1))
            .map(str::len)
            .sum();
        let at = (start + before + error.column().saturating_sub(1)).min(source.text.len());
        Problem::new(
            "bad-evaluation",
            format!("the JSON cannot be read: {error}"),
        )
        .at(source, at..at)
        .remedy("check that the evaluation was written to its end")
    })
}

/// Whether an episode succeeded.
fn success(source: &Source, value: Option<&Value>, which: &str) -> Result<bool, Problem> {
    let read = match value {
        Some(Value::Bool(success)) => Some(*success),
        Some(Value::Number(number)) => match number.as_f64() {
            Some(0.0) => Some(false),
            Some(1.0) => Some(true),
            _ => None,
        },
        _ => None,
    };
    read.ok_or_else(|| {
        bad(
            source,
            "success",
            format!("{which} does not say whether it succeeded"),
        )
        .remedy("write true or false, or leave the episode out and say so in the entry's `changed`")
    })
}

/// The episodes of one evaluation, or of several that somebody put into one file under names of their own.
fn evaluation(source: &Source, checkpoint: &str) -> Result<Vec<Episode>, Problem> {
    let root = json(source, 0, &source.text)?;
    let is_one = |it: &Value| it.get("per_episode").is_some() || it.get("per_task").is_some();
    if is_one(&root) {
        return one_evaluation(source, &root, checkpoint);
    }
    let mut episodes = Vec::new();
    let mut known: Vec<(&String, &Value)> = Vec::new();
    for (name, inner) in root
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(_, it)| is_one(it))
    {
        if let Some((first, _)) = known.iter().find(|(_, it)| *it == inner) {
            let message =
                format!("`{name}` is the same as `{first}`: it is one evaluation under two names");
            return Err(bad(source, name, message).remedy(COPIED));
        }
        known.push((name, inner));
        episodes.extend(one_evaluation(
            source,
            inner,
            &format!("{checkpoint}/{name}"),
        )?);
    }
    match episodes.is_empty() {
        false => Ok(episodes),
        true => Err(bad(
            source,
            "",
            "this is not an evaluation of LeRobot: it has neither `per_episode` nor `per_task`",
        )
        .remedy("name the `eval_info.json` that `lerobot-eval` wrote, or a table in CSV")),
    }
}

fn one_evaluation(
    source: &Source,
    root: &Value,
    checkpoint: &str,
) -> Result<Vec<Episode>, Problem> {
    let mut episodes = Vec::new();
    let mut add = |task: Option<String>, seed: Option<String>, success: bool| {
        episodes.push(Episode {
            task,
            seed,
            checkpoint: Some(checkpoint.to_owned()),
            counted: outcome(success),
            other: None,
            is_saved: false,
        });
    };
    if let Some(Value::Array(all)) = root.get("per_episode") {
        let mut numbers = Vec::new();
        for (at, one) in all.iter().enumerate() {
            if let Some(number) = one.get("episode_ix").filter(|it| !it.is_null()) {
                once(
                    source,
                    &mut numbers,
                    &format!("the episode {number}"),
                    "\"episode_ix\"",
                )?;
            }
            let won = success(source, one.get("success"), &format!("episode {at}"))?;
            let seed = one.get("seed").filter(|it| !it.is_null());
            add(None, seed.map(Value::to_string), won);
        }
        held_against(source, root.get("aggregated"), &episodes)?;
        return Ok(episodes);
    }
    let mut tasks = Vec::new();
    for task in root
        .get("per_task")
        .and_then(Value::as_array)
        .into_iter()
        .flatten()
    {
        let part = |key: &str| match task.get(key) {
            Some(Value::String(text)) => text.clone(),
            Some(other) => other.to_string(),
            None => String::new(),
        };
        let name = format!("{}/{}", part("task_group"), part("task_id"));
        once(
            source,
            &mut tasks,
            &format!("the task {name}"),
            "\"task_id\"",
        )?;
        let successes = task.get("metrics").and_then(|it| it.get("successes"));
        let Some(Value::Array(successes)) = successes else {
            let message = format!("the task {name} has no `metrics.successes`");
            return Err(
                bad(source, "per_task", message).remedy("write the evaluation anew with LeRobot")
            );
        };
        for (at, one) in successes.iter().enumerate() {
            let won = success(source, Some(one), &format!("episode {at} of {name}"))?;
            add(Some(name.clone()), None, won);
        }
    }
    held_against(source, root.get("overall"), &episodes)?;
    Ok(episodes)
}

/// Refuses what stands twice in a file; its place is that of the same key as often as there were others before.
fn once(source: &Source, known: &mut Vec<String>, what: &str, key: &str) -> Result<(), Problem> {
    if known.iter().any(|it| it == what) {
        let mut places = source.text.match_indices(key);
        let at = places.nth(known.len()).map_or(0, |(at, _)| at);
        let message = format!("{what} stands twice: its episodes would count twice");
        return Err(Problem::new("bad-evaluation", message)
            .at(source, at..at + key.len())
            .remedy("leave one of them out; if they are others, number them so"));
    }
    known.push(what.to_owned());
    Ok(())
}

fn outcome(success: bool) -> Vec<(String, bool)> {
    vec![
        ("success".to_owned(), success),
        ("failure".to_owned(), !success),
    ]
}

/// The file's own sums have to be those of its episodes.
fn held_against(
    source: &Source,
    sums: Option<&Value>,
    episodes: &[Episode],
) -> Result<(), Problem> {
    let number = |key: &str| sums.and_then(|it| it.get(key)).and_then(Value::as_f64);
    let won = episodes.iter().filter(|it| it.counted[0].1).count();
    let percent = 100.0 * won as f64 / episodes.len().max(1) as f64;
    if let Some(stated) = number("pc_success")
        && !episodes.is_empty()
        && (stated - percent).abs() > 1e-6
    {
        let message = format!(
            "`pc_success` is {stated}, and {won} of {} episodes are {percent}",
            episodes.len()
        );
        return Err(bad(source, "pc_success", message)
            .remedy("correct the file that was changed by hand, or evaluate anew"));
    }
    if let Some(stated) = number("n_episodes")
        && stated != episodes.len() as f64
    {
        let message = format!(
            "`n_episodes` is {stated}, and the file has {}",
            episodes.len()
        );
        return Err(bad(source, "n_episodes", message)
            .remedy("correct the file that was changed by hand, or evaluate anew"));
    }
    Ok(())
}

/// The episodes of a table, one in each row.
fn of_table(source: &Source, cluster: &str) -> Result<Vec<Episode>, Problem> {
    let table = Table::parse(&source.name, &source.text).map_err(table_problem)?;
    let has = |name: &str| table.headers().iter().any(|it| it == name);
    if !has("success") {
        return Err(bad(source, "", "the table has no column `success`")
            .remedy("give each episode a row, with `success` true or false"));
    }
    let texts = |name: &str| -> Result<Option<Vec<&str>>, Problem> {
        match has(name) {
            false => Ok(None),
            true => table
                .column(name)
                .map(|it| Some(it.as_texts()))
                .map_err(table_problem),
        }
    };
    let (tasks, seeds, checkpoints) = (texts("task")?, texts("seed")?, texts("checkpoint")?);
    let numbers = texts("episode")?;
    let is_known = ["task", "seed", "checkpoint", "episode"].contains(&cluster);
    let others = match is_known {
        true => None,
        false => texts(cluster)?,
    };
    let mut known = BTreeSet::new();
    for row in 0..table.len() {
        let names = [&numbers, &tasks, &seeds, &checkpoints, &others];
        let key = names.map(|it| it.as_ref().map(|all| all[row]));
        if let (Some(number), false) = (key[0], known.insert(key)) {
            let message =
                format!("the episode `{number}` stands twice for the same task and checkpoint");
            return Err(in_row(&table, row, "bad-evaluation", message)
                .remedy("leave one of them out; if they are others, number them so"));
        }
    }
    // Every column of truth values counts something.
    let mut outcomes: Vec<(String, Vec<bool>)> = Vec::new();
    for column in table.columns() {
        let is_name = ["task", "seed", "checkpoint", "episode", cluster].contains(&column.header());
        let mut values = Vec::new();
        for (row, cell) in column.cells().enumerate() {
            match truth(cell) {
                Some(value) => values.push(value),
                None if column.header() == "success" => {
                    let message = format!("column \"success\": `{cell}` is neither true nor false");
                    return Err(in_row(&table, row, "bad-evaluation", message)
                        .remedy("write true or false, or leave the episode out and say so in the entry's `changed`"));
                }
                None => break,
            }
        }
        if values.len() == table.len() && !is_name {
            outcomes.push((column.header().to_owned(), values));
        }
    }
    let of = |all: &Option<Vec<&str>>, row: usize| all.as_ref().map(|it| it[row].to_owned());
    let episode = |row: usize| {
        let mut counted: Vec<(String, bool)> = outcomes
            .iter()
            .map(|(name, all)| (name.clone(), all[row]))
            .collect();
        if !has("failure") {
            let won = counted.iter().any(|(name, won)| name == "success" && *won);
            counted.push(("failure".to_owned(), !won));
        }
        Episode {
            task: of(&tasks, row),
            seed: of(&seeds, row),
            checkpoint: of(&checkpoints, row),
            counted,
            other: of(&others, row),
            is_saved: false,
        }
    };
    Ok((0..table.len()).map(episode).collect())
}

/// A truth value as tables have it, in any case.
fn truth(cell: &str) -> Option<bool> {
    match cell.to_ascii_lowercase().as_str() {
        "true" | "yes" | "1" | "1.0" => Some(true),
        "false" | "no" | "0" | "0.0" => Some(false),
        _ => None,
    }
}

/// The episodes by cluster.
fn cohort(name: &str, cluster: &str, episodes: &[Episode]) -> Result<Episodes, Problem> {
    let fail = |message: String, remedy: &str| {
        Err(Problem::new("bad-evaluation", format!("{name}: {message}")).remedy(remedy))
    };
    if episodes.is_empty() {
        return fail(
            "there are no episodes".to_owned(),
            "name the file that has them",
        );
    }
    let mut seen = BTreeSet::new();
    let mut rows: BTreeMap<String, (u64, BTreeMap<&str, u64>)> = BTreeMap::new();
    for (at, episode) in episodes.iter().enumerate() {
        if let Some(seed) = &episode.seed
            && !seen.insert((&episode.checkpoint, &episode.task, seed))
        {
            return fail(
                format!("the seed {seed} stands twice for the same task and checkpoint"),
                "leave one of them out: the same seed again is not another trial; or say which checkpoint each is of",
            );
        }
        let key = match cluster {
            "task" => episode.task.clone(),
            "seed" => episode.seed.clone(),
            "checkpoint" => episode.checkpoint.clone(),
            "episode" => Some(format!("{}", at + 1)),
            _ => episode.other.clone(),
        };
        let Some(key) = key else {
            return fail(
                format!("its episodes do not say their {cluster}, which `tables.cluster` names"),
                "name what the file has: `task`, `seed`, `checkpoint`, a column of the table, or `episode` for each by itself",
            );
        };
        let row = rows.entry(key).or_default();
        row.0 += 1;
        for (name, happened) in &episode.counted {
            *row.1.entry(name).or_default() += u64::from(*happened);
        }
    }
    let columns: Vec<&str> = episodes[0]
        .counted
        .iter()
        .map(|(name, _)| name.as_str())
        .collect();
    let cell = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let heads: Vec<String> = columns.iter().map(|it| cell(it)).collect();
    // The first column names the row, whatever it is called.
    let mut text = format!(
        "\"cluster: {}\",attempts,{}\n",
        cluster.replace('"', "\"\""),
        heads.join(",")
    );
    for (key, (attempts, counts)) in &rows {
        let counts: Vec<String> = columns
            .iter()
            .map(|it| counts.get(it).copied().unwrap_or(0).to_string())
            .collect();
        let _ = writeln!(text, "{},{attempts},{}", cell(key), counts.join(","));
    }
    let table = Table::parse(&format!("{name} by {cluster}"), &text).map_err(table_problem)?;
    Ok(Episodes {
        cohort: table,
        speaks_of: speaks_of(cluster, episodes, rows.len()),
    })
}

/// Of what the rate is.
fn speaks_of(cluster: &str, episodes: &[Episode], clusters: usize) -> String {
    let checkpoints: BTreeSet<_> = episodes.iter().map(|it| &it.checkpoint).collect();
    let of = match (episodes[0].checkpoint.is_some(), checkpoints.len()) {
        (false, _) => "of checkpoints that the table does not name".to_owned(),
        (true, 1) => {
            "of one checkpoint, so of this policy as it was saved and not of training it again"
                .to_owned()
        }
        (true, many) => format!("of {many} checkpoints"),
    };
    let saved = match episodes.iter().any(|it| it.is_saved) {
        true => "; of those that were saved in datasets, not of those that were run and not saved",
        false => "",
    };
    format!(
        "{} {of}; alike by {cluster} ({}){saved}",
        counted(episodes.len(), "episode"),
        counted(clusters, "cluster")
    )
}
