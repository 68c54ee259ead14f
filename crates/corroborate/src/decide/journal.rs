//! The journal of a test's trials: a line for each as it ends, so that an interrupted call goes on and nothing is run twice.
//!
//! The first line holds the settings with which its trials were run. Lines are written in one piece; the last one may be cut off
//! by the end of the process or of the machine, and is then run again.

use diagnostic::{Problem, Source};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The journal's file in the folder of results.
pub const JOURNAL: &str = "journal.jsonl";

/// How a trial ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// It passed.
    Pass,
    /// It failed.
    Fail,
    /// The harness broke: its outcome is unknown.
    Error,
    /// It says that it was not applicable.
    NotApplicable,
}

impl Outcome {
    /// Whether it is one to look at.
    pub fn is_failing(self) -> bool {
        match self {
            Outcome::Fail | Outcome::Error => true,
            Outcome::Pass | Outcome::NotApplicable => false,
        }
    }

    /// Its name in journals, tables and the protocol.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Pass => "pass",
            Outcome::Fail => "fail",
            Outcome::Error => "error",
            Outcome::NotApplicable => "not-applicable",
        }
    }

    /// The outcome of this name.
    pub fn named(name: &str) -> Option<Self> {
        let all = [
            Outcome::Pass,
            Outcome::Fail,
            Outcome::Error,
            Outcome::NotApplicable,
        ];
        all.into_iter().find(|it| it.name() == name)
    }
}

/// A trial that has ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trial {
    /// Its number, from 1.
    pub trial: u64,
    /// Its seed.
    pub seed: u64,
    /// How it ended.
    pub outcome: Outcome,
    /// Why, if it did not pass.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub why: String,
}

/// An open journal.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    file: File,
    trials: BTreeMap<u64, Trial>,
}

impl Journal {
    /// Opens the journal in `folder`, or begins it.
    ///
    /// # Errors
    /// `other-trials` if it was begun with other settings, `bad-journal` for a line that is none, `cannot-read`, `cannot-write`.
    pub fn open(folder: &Path, settings: &impl Serialize) -> Result<Self, Problem> {
        let path = folder.join(JOURNAL);
        let fail = |error: std::io::Error| Problem::cannot_write(&path, &error);
        let settings = serde_json::to_value(settings)
            .map_err(|error| Problem::new("cannot-write", error.to_string()))?;
        let mut file = File::options()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(&path)
            .map_err(fail)?;
        let text = host::files::read_any_size(&path)?;
        let (whole, trials) = read(&text, &settings)?;
        // What was cut off is written anew.
        file.set_len(whole).map_err(fail)?;
        file.seek(SeekFrom::Start(whole)).map_err(fail)?;
        if whole == 0 {
            file.write_all(format!("{settings}\n").as_bytes())
                .map_err(fail)?;
        }
        Ok(Self {
            state: Mutex::new(State { file, trials }),
            path,
        })
    }

    /// The trial of this number, if it has ended.
    pub fn known(&self, number: u64) -> Option<Trial> {
        self.lock().trials.get(&number).cloned()
    }

    /// How many trials it holds.
    pub fn count(&self) -> usize {
        self.lock().trials.len()
    }

    /// Keeps a trial.
    ///
    /// # Errors
    /// `cannot-write`.
    pub fn write(&self, trial: &Trial) -> Result<(), Problem> {
        let line = serde_json::to_string(trial)
            .map_err(|error| Problem::new("cannot-write", error.to_string()))?;
        let mut state = self.lock();
        let written = state.file.write_all(format!("{line}\n").as_bytes());
        written.map_err(|error| Problem::cannot_write(&self.path, &error))?;
        state.trials.insert(trial.trial, trial.clone());
        Ok(())
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The bytes of whole lines, and the trials of a journal.
fn read(source: &Source, settings: &Value) -> Result<(u64, BTreeMap<u64, Trial>), Problem> {
    let mut trials = BTreeMap::new();
    let mut place = 0;
    for line in source.text.split_inclusive('\n') {
        if !line.ends_with('\n') {
            break;
        }
        let span = place..place + line.trim_end().len();
        let bad = |message: String| {
            Problem::new("bad-journal", message)
                .at(source, span.clone())
                .remedy("remove the folder, and all trials are run again; or name another one")
        };
        if place == 0 {
            let begun: Value = serde_json::from_str(line)
                .map_err(|error| bad(format!("the settings cannot be read: {error}")))?;
            same_settings(source, &begun, settings)?;
        } else {
            let trial: Trial = serde_json::from_str(line)
                .map_err(|error| bad(format!("this is not a trial: {error}")))?;
            let number = trial.trial;
            if trials.insert(number, trial).is_some() {
                return Err(bad(format!("trial {number} stands here twice")));
            }
        }
        place += line.len();
    }
    Ok((place as u64, trials))
}

/// Trials of other settings would be of another rate.
fn same_settings(source: &Source, begun: &Value, now: &Value) -> Result<(), Problem> {
    if begun == now {
        return Ok(());
    }
    let keys = now.as_object().into_iter().flatten();
    let other = keys.filter(|(key, value)| begun.get(key.as_str()) != Some(value));
    let other: Vec<String> = other
        .map(|(key, value)| {
            let before = begun.get(key.as_str()).unwrap_or(&Value::Null);
            format!("{key} {before}, now {value}")
        })
        .collect();
    let message = format!(
        "{} has trials with other settings: {}",
        source.name,
        other.join("; ")
    );
    Err(Problem::new("other-trials", message).remedy(
        "write the results to another folder (--out), or remove this one to begin anew; trials of different settings are \
         not counted together",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: [&str; 2] = ["sh", "{seed}"];

    fn trial(number: u64, outcome: Outcome) -> Trial {
        Trial {
            trial: number,
            seed: 7 * number,
            outcome,
            why: String::new(),
        }
    }

    #[test]
    fn wherever_a_journal_is_cut_off_its_whole_lines_are_kept_and_it_goes_on() {
        let folder = tempfile::tempdir().expect("a folder");
        let journal = Journal::open(folder.path(), &SETTINGS).expect("begun");
        let trials = [
            trial(2, Outcome::Fail),
            trial(1, Outcome::Pass),
            trial(3, Outcome::Error),
        ];
        for one in &trials {
            journal.write(one).expect("kept");
        }
        drop(journal);
        let path = folder.path().join(JOURNAL);
        let whole = std::fs::read_to_string(&path).expect("text");
        for end in 0..=whole.len() {
            std::fs::write(&path, &whole[..end]).expect("cut");
            let journal = Journal::open(folder.path(), &SETTINGS).expect("whole lines");
            let lines = whole[..end].matches('\n').count();
            assert_eq!(journal.count(), lines.saturating_sub(1), "{end}");
            for one in &trials[journal.count()..] {
                journal.write(one).expect("kept");
            }
            assert_eq!(
                std::fs::read_to_string(&path).expect("text"),
                whole,
                "{end}"
            );
        }
    }

    #[test]
    fn other_settings_and_lines_that_are_none_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let journal = Journal::open(folder.path(), &SETTINGS).expect("begun");
        journal.write(&trial(1, Outcome::Pass)).expect("kept");
        journal.write(&trial(2, Outcome::Pass)).expect("kept");
        drop(journal);
        let other = Journal::open(folder.path(), &["bash"]).expect_err("other settings");
        assert_eq!(other.code, "other-trials");
        let path = folder.path().join(JOURNAL);
        let whole = std::fs::read_to_string(&path).expect("text");
        for wrong in [
            whole.replace("\"trial\":2", "\"trial\":1"),
            whole.replace("\"trial\":1", "\"trial\":-1"),
            whole.replace("\"outcome\":\"pass\"", "\"outcome\":\"passed\""),
            whole.replace("\n{", "\n\n{"),
        ] {
            std::fs::write(&path, &wrong).expect("written");
            let problem = Journal::open(folder.path(), &SETTINGS).expect_err("damaged");
            assert_eq!(problem.code, "bad-journal", "{wrong}");
            assert!(problem.has_place());
        }
    }
}
