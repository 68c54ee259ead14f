//! The journal of an exploration: what each episode showed, so that one that
//! was interrupted goes on without running an episode twice.
//!
//! A line of JSON for each episode, in the order in which they ended, behind a
//! line that says what they were looked at with. A line holds the hash of its
//! own text: what is cut or damaged is left out and run again. What is run
//! next follows from what was shown, so an exploration that goes on asks for
//! the same episodes; an episode that was another one is not taken.

use diagnostic::Problem;
use host::store::hash_of;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use stimulus::Stimulus;

/// An exploration's journal, of episodes of which `T` is kept.
#[derive(Debug)]
pub struct Journal<T> {
    path: PathBuf,
    file: Mutex<File>,
    known: Known<T>,
}

/// What a journal has of episodes that were run before.
#[derive(Debug)]
pub struct Known<T>(BTreeMap<u64, Entry<T>>);

/// What an episode was and what it showed.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Entry<T> {
    episode: u64,
    seed: u64,
    stimulus: String,
    shown: T,
}

/// A line: the entry as text, and the hash of that text.
#[derive(Serialize, Deserialize)]
struct Line {
    hash: String,
    entry: Box<serde_json::value::RawValue>,
}

impl<T: Clone + Serialize + DeserializeOwned> Journal<T> {
    /// Opens the journal in a folder. Episodes that were looked at with
    /// something else, of which `looked_at_by` is the hash, are forgotten.
    pub fn open(folder: &Path, looked_at_by: &str) -> Result<Self, Problem> {
        let path = folder.join(JOURNAL);
        let header = header(looked_at_by);
        let fail = |error: std::io::Error| Problem::cannot_write(&path, &error);
        std::fs::create_dir_all(folder).map_err(fail)?;
        let text = std::fs::read(&path).unwrap_or_default();
        let known = Known(entries(&text, &header));
        let mut whole = header.into_bytes();
        for entry in known.0.values() {
            whole.extend(line_of(entry).map_err(|error| unwritten(&path, &error))?);
        }
        host::files::write_whole(&path, &whole)?;
        let file = File::options().append(true).open(&path).map_err(fail)?;
        Ok(Self {
            path,
            file: Mutex::new(file),
            known,
        })
    }

    /// What it has of episodes that were run before.
    pub fn known(&self) -> &Known<T> {
        &self.known
    }

    /// Adds what an episode showed; any thread may.
    pub fn add(
        &self,
        episode: u64,
        seed: u64,
        stimulus: &Stimulus,
        shown: &T,
    ) -> Result<(), Problem> {
        let entry = Entry {
            episode,
            seed,
            stimulus: short_hash(stimulus),
            shown: shown.clone(),
        };
        let line = line_of(&entry).map_err(|error| unwritten(&self.path, &error))?;
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(&line).map_err(|error| {
            Problem::data_lost("cannot-record", format!("{}: {error}", self.path.display()))
                .remedy("make room on the disk or choose another folder, and run the command again")
        })
    }
}

impl<T: Clone + DeserializeOwned> Known<T> {
    /// What the journal in a folder has, which is left as it is; `None` if there is none of episodes that
    /// were looked at with what `looked_at_by` is the hash of.
    pub fn of(folder: &Path, looked_at_by: &str) -> Option<Self> {
        let text = std::fs::read(folder.join(JOURNAL)).ok()?;
        let header = header(looked_at_by);
        let is_of_these = text.starts_with(header.as_bytes());
        is_of_these.then(|| Self(entries(&text, &header)))
    }

    /// What an episode showed, if it was run with this seed and stimulus.
    pub fn read(&self, episode: u64, seed: u64, stimulus: &Stimulus) -> Option<T> {
        let entry = self.0.get(&episode)?;
        let is_same = entry.seed == seed && entry.stimulus == short_hash(stimulus);
        is_same.then(|| entry.shown.clone())
    }
}

/// The journal's name in its folder.
const JOURNAL: &str = "journal";

fn header(looked_at_by: &str) -> String {
    format!("corroborate exploration 1 of {looked_at_by}\n")
}

fn unwritten(path: &Path, error: &serde_json::Error) -> Problem {
    Problem::data_lost("cannot-write", format!("{}: {error}", path.display()))
}

fn short_hash(stimulus: &Stimulus) -> String {
    hash_of(stimulus.to_json().as_bytes())[..16].to_owned()
}

fn line_of<T: Serialize>(entry: &Entry<T>) -> Result<Vec<u8>, serde_json::Error> {
    let text = serde_json::value::to_raw_value(entry)?;
    let line = Line {
        hash: hash_of(text.get().as_bytes())[..16].to_owned(),
        entry: text,
    };
    let mut bytes = serde_json::to_vec(&line)?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// The entries of whole lines behind the header; the last of each episode.
fn entries<T: DeserializeOwned>(text: &[u8], header: &str) -> BTreeMap<u64, Entry<T>> {
    let mut known = BTreeMap::new();
    let Some(lines) = text.strip_prefix(header.as_bytes()) else {
        return known;
    };
    for line in lines.split_inclusive(|byte| *byte == b'\n') {
        if let Some(entry) = entry_of(line) {
            known.insert(entry.episode, entry);
        }
    }
    known
}

fn entry_of<T: DeserializeOwned>(line: &[u8]) -> Option<Entry<T>> {
    let line: Line = serde_json::from_slice(line.strip_suffix(b"\n")?).ok()?;
    let text = line.entry.get();
    let is_ours = line.hash.len() == 16 && hash_of(text.as_bytes()).starts_with(&line.hash);
    is_ours.then(|| serde_json::from_str(text).ok())?
}

#[cfg(test)]
mod tests {
    use super::super::episode::Shown;
    use super::*;
    use stimulus::{AbstractTest, Action};

    fn stimulus(signal: &str) -> Stimulus {
        Stimulus::of(AbstractTest::new("t", vec![Action::send(signal)]))
    }

    fn shown(secs: f64) -> Shown {
        Shown {
            violated: vec!["8".into()],
            robustness: Some(1.0 / 3.0),
            unknown: vec![(5, None), (u64::MAX, Some(2))],
            simulated_secs: secs,
            ..Shown::default()
        }
    }

    #[test]
    fn what_was_shown_is_there_again_to_the_last_bit_and_for_the_same_episode_only() {
        let folder = tempfile::tempdir().unwrap();
        let journal = Journal::<Shown>::open(folder.path(), "a").unwrap();
        journal
            .add(2, u64::MAX, &stimulus("go"), &shown(0.1))
            .unwrap();
        let journal = Journal::<Shown>::open(folder.path(), "a").unwrap();
        assert_eq!(
            journal.known().read(2, u64::MAX, &stimulus("go")),
            Some(shown(0.1))
        );
        assert_eq!(journal.known().read(2, 7, &stimulus("go")), None);
        assert_eq!(journal.known().read(2, u64::MAX, &stimulus("stop")), None);
        assert_eq!(journal.known().read(1, u64::MAX, &stimulus("go")), None);
        let journal = Journal::<Shown>::open(folder.path(), "b").unwrap();
        assert_eq!(journal.known().read(2, u64::MAX, &stimulus("go")), None);
    }

    #[test]
    fn a_journal_cut_at_any_byte_keeps_its_whole_lines() {
        let folder = tempfile::tempdir().unwrap();
        let journal = Journal::<Shown>::open(folder.path(), "a").unwrap();
        for episode in 1..=3 {
            journal
                .add(episode, 1, &stimulus("go"), &shown(0.5))
                .unwrap();
        }
        let whole = std::fs::read(&journal.path).unwrap();
        for cut in 0..=whole.len() {
            std::fs::write(&journal.path, &whole[..cut]).unwrap();
            let lines = whole[..cut].iter().filter(|byte| **byte == b'\n').count();
            let again = Journal::<Shown>::open(folder.path(), "a").unwrap();
            let there = (1..=3).filter(|n| again.known().read(*n, 1, &stimulus("go")).is_some());
            assert_eq!(there.count(), lines.saturating_sub(1), "cut at {cut}");
        }
        let mut damaged = whole.clone();
        let place = whole.len() - 40;
        damaged[place] = damaged[place].wrapping_add(1);
        std::fs::write(&journal.path, &damaged).unwrap();
        let again = Journal::<Shown>::open(folder.path(), "a").unwrap();
        assert!(again.known().read(3, 1, &stimulus("go")).is_none());
        assert!(again.known().read(2, 1, &stimulus("go")).is_some());
    }
}
