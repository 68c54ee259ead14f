//! What is kept of an episode once it is judged, and the journal of a campaign.
//!
//! The journal is a line of JSON for each episode, in the order of their numbers, behind a line
//! that says what they were judged with. A line is written in one piece with its hash, so a
//! campaign that is ended anywhere, even by the system, has whole lines up to there; what is cut is
//! made again. Only the place of each line is held in memory.

use super::tally::Monitored;
use diagnostic::Problem;
use evidence::FailureKind;
use host::store::hash_of;
use judging::verdicts::RunVerdicts;
use judging::{Judgement, Robustness};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::ops::{ControlFlow, Range};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use temporal::monitor::Verdict;
use testbench::{Creep, OutOfReach};

/// An episode that is judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EpisodeRecord {
    /// Its number.
    pub number: u64,
    /// Its seed.
    pub seed: u64,
    /// How it ended: `complete`, `decided` (ended early, since all was),
    /// `incomplete` (cut short by the longest time that is allowed, or, of
    /// another simulator, whose recording is cut short), or the name of a
    /// failure, which cut it short.
    pub end: String,
    /// Simulated time; unknown of other simulators.
    pub simulated_secs: Option<f64>,
    /// The hash of its recording, if that is kept.
    pub recording: Option<String>,
    /// What each of the study's monitors says, in their order.
    pub judged: Vec<Judged>,
    /// The verdict of each form that is held against another.
    pub forms: Vec<Verdict>,
    /// What moved in the fingers that held it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub crept: Vec<Creep>,
    /// Trajectories that were out of reach.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub out_of_reach: Vec<OutOfReach>,
}

/// What one monitor says of an episode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// The verdict.
    pub verdict: Verdict,
    /// How often the precondition was met.
    pub triggered: u64,
    /// By how much it holds.
    pub robustness: Option<Bounds>,
    /// When the verdict was determined, if before the end.
    pub decided_at_secs: Option<f64>,
    /// Whether it leaves out what was pending at the end.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub left_out: bool,
}

/// The least and the greatest that the robustness can be. Numbers are texts, since JSON has no
/// infinity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    #[serde(with = "as_text")]
    pub low: f64,
    #[serde(with = "as_text")]
    pub high: f64,
}

mod as_text {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        // The shortest text that gives back the same number.
        serializer.collect_str(value)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(D::Error::custom)
    }
}

impl Judged {
    /// What is kept of a judgement.
    pub fn of(judgement: &Judgement<'_>) -> Self {
        let findings = &judgement.findings;
        let bounds = |r: &Robustness| Bounds {
            low: r.low,
            high: r.high,
        };
        Self {
            verdict: findings.verdict,
            triggered: findings.triggered,
            robustness: findings.robustness.as_ref().map(bounds),
            decided_at_secs: findings.decided_at_secs,
            left_out: findings.left_out.is_some(),
        }
    }
}

impl EpisodeRecord {
    /// What ended it, if it did not end by itself.
    pub fn failure(&self) -> Option<FailureKind> {
        FailureKind::named(&self.end)
    }

    /// Whether a requirement is violated or a failure mode occurs, by its main monitor.
    pub fn shows_violation(judged: &[Judged], monitors: &[Monitored]) -> bool {
        let mut main = judged.iter().zip(monitors);
        main.any(|(judged, monitor)| {
            monitor.reading.is_none() && judged.verdict == Verdict::Violated
        })
    }
}

/// A campaign's journal.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: Mutex<File>,
    /// Where each line begins, and the end of the last.
    places: Vec<u64>,
    first: u64,
}

/// A line: the record as text, and the hash of that text.
#[derive(Serialize)]
struct Line<'a> {
    hash: &'a str,
    episode: &'a serde_json::value::RawValue,
}

/// The verdicts of an episode alone: most of a line's time goes into the rest.
#[derive(Debug, Deserialize)]
struct VerdictsOnly {
    judged: Vec<VerdictOnly>,
    forms: Vec<Verdict>,
}

#[derive(Debug, Deserialize)]
struct VerdictOnly {
    verdict: Verdict,
}

/// The number of an episode alone.
#[derive(Debug, Deserialize)]
struct NumberOnly {
    number: u64,
}

/// Bytes of a journal that are held at a time.
const BLOCK: u64 = 1 << 24;

impl Journal {
    /// Opens the journal of episodes from `first` on in `folder`. What was judged by other monitors,
    /// of which `judged_by` is the hash, and what is cut or damaged, is left out.
    pub fn open(folder: &Path, first: u64, judged_by: &str) -> Result<Self, Problem> {
        let path = folder.join(match first {
            1 => "journal".to_owned(),
            _ => format!("journal-{first}"),
        });
        let header = header(judged_by);
        let fail = |error: std::io::Error| Problem::cannot_write(&path, &error);
        let mut file = File::options()
            .create(true)
            .truncate(false)
            .read(true)
            .write(true)
            .open(&path)
            .map_err(fail)?;
        let places = match whole_lines(&mut file, &header, first).map_err(fail)? {
            Some(places) => places,
            None => {
                file.set_len(0).map_err(fail)?;
                file.rewind().map_err(fail)?;
                file.write_all(header.as_bytes()).map_err(fail)?;
                vec![header.len() as u64]
            }
        };
        let mut journal = Self {
            path,
            file: Mutex::new(file),
            places,
            first,
        };
        journal.keep(journal.count())?;
        Ok(journal)
    }

    /// The journal of a folder that another process made, to be read alone: `None` if it was judged by other monitors.
    pub fn made_elsewhere(
        path: &Path,
        first: u64,
        judged_by: &str,
    ) -> Result<Option<Self>, Problem> {
        let mut file = host::files::open_file(path)?;
        let places = whole_lines(&mut file, &header(judged_by), first);
        let places = places.map_err(|error| Problem::cannot_read(path, &error))?;
        Ok(places.map(|places| Self {
            path: path.to_owned(),
            file: Mutex::new(file),
            places,
            first,
        }))
    }

    /// The journals in a folder, with the number of the first episode of each.
    pub fn files(folder: &Path) -> Result<Vec<(u64, PathBuf)>, Problem> {
        let fail = |error: std::io::Error| Problem::cannot_read(folder, &error);
        let mut found = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(fail)? {
            let path = entry.map_err(fail)?.path();
            let name = path.file_name().and_then(|name| name.to_str());
            let first = match name {
                Some("journal") => Some(1),
                Some(name) => name.strip_prefix("journal-").and_then(|it| it.parse().ok()),
                None => None,
            };
            found.extend(first.map(|first| (first, path)));
        }
        found.sort();
        Ok(found)
    }

    /// The numbers of its episodes.
    pub fn numbers(&self) -> Range<u64> {
        self.first..self.first + self.count()
    }

    /// How many episodes it holds.
    pub fn count(&self) -> u64 {
        self.places.len() as u64 - 1
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Forgets all but the first `count` episodes.
    pub fn keep(&mut self, count: u64) -> Result<(), Problem> {
        self.places.truncate(count as usize + 1);
        let end = self.places.last().copied().unwrap_or_default();
        let fail = |error: std::io::Error| Problem::cannot_write(&self.path, &error);
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.set_len(end).map_err(fail)?;
        file.seek(SeekFrom::Start(end)).map_err(fail)?;
        Ok(())
    }

    /// The record of the episode with this number, if it is there.
    pub fn read(&self, number: u64) -> Result<Option<EpisodeRecord>, Problem> {
        let place = number.checked_sub(self.first).map(|place| place as usize);
        let bounds =
            place.and_then(|place| Some((*self.places.get(place)?, *self.places.get(place + 1)?)));
        let Some((begin, end)) = bounds else {
            return Ok(None);
        };
        let mut bytes = vec![0; (end - begin) as usize];
        let fail = |error: std::io::Error| Problem::cannot_read(&self.path, &error);
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.seek(SeekFrom::Start(begin)).map_err(fail)?;
        file.read_exact(&mut bytes).map_err(fail)?;
        Ok(record_of(&bytes))
    }

    /// Adds the record of the next episode.
    pub fn add(&mut self, record: &EpisodeRecord) -> Result<(), Problem> {
        let unwritten = |error: serde_json::Error| {
            Problem::data_lost("cannot-write", format!("{}: {error}", self.path.display()))
        };
        let text = serde_json::value::to_raw_value(record).map_err(unwritten)?;
        let line = Line {
            hash: &hash_of(text.get().as_bytes())[..16],
            episode: &text,
        };
        let mut bytes = serde_json::to_vec(&line).map_err(unwritten)?;
        bytes.push(b'\n');
        let end = self.places.last().copied().unwrap_or_default();
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let written = file
            .seek(SeekFrom::Start(end))
            .and_then(|_| file.write_all(&bytes));
        written.map_err(|error| {
            Problem::data_lost("cannot-record", format!("{}: {error}", self.path.display()))
                .remedy("make room on the disk or choose another folder, and run the command again")
        })?;
        self.places.push(end + bytes.len() as u64);
        Ok(())
    }
}

/// The first line of a journal.
fn header(judged_by: &str) -> String {
    format!("corroborate journal 1 of {judged_by}\n")
}

/// Whether a journal was judged by the monitors of which `judged_by` is the hash.
pub fn is_judged_by(path: &Path, judged_by: &str) -> bool {
    let mut line = String::new();
    let read = File::open(path).and_then(|file| BufReader::new(file).read_line(&mut line));
    read.is_ok() && line == header(judged_by)
}

/// The records of a journal, in order, without changing it; the number of lines that are damaged.
pub fn records(path: &Path) -> Result<(Vec<EpisodeRecord>, u64), Problem> {
    let (mut records, mut damaged) = (Vec::new(), 0);
    each_line(path, record_of, |record| {
        match record {
            Some(record) => records.push(record),
            None => damaged += 1,
        }
        ControlFlow::Continue(())
    })?;
    Ok((records, damaged))
}

/// What the monitors and the forms say of each of the first `episodes` of a journal, up to a line that is damaged.
pub fn verdicts(path: &Path, episodes: u64) -> Result<RunVerdicts, Problem> {
    let mut verdicts = RunVerdicts::default();
    let most = usize::try_from(episodes).unwrap_or(usize::MAX);
    each_line(path, record_of::<VerdictsOnly>, |record| match record {
        Some(record) if verdicts.main.len() < most => {
            let main = record.judged.iter().map(|judged| judged.verdict);
            verdicts.add(main.collect(), record.forms);
            ControlFlow::Continue(())
        }
        _ => ControlFlow::Break(()),
    })?;
    Ok(verdicts)
}

/// Reads the lines behind the header on all cores, block by block, and hands over what is read of each in their order.
fn each_line<T: Send>(
    path: &Path,
    read: impl Fn(&[u8]) -> Option<T> + Sync,
    mut take: impl FnMut(Option<T>) -> ControlFlow<()>,
) -> Result<(), Problem> {
    let fail = |error: std::io::Error| Problem::cannot_read(path, &error);
    let mut reader = BufReader::new(File::open(path).map_err(fail)?);
    let mut block = Vec::new();
    reader.read_until(b'\n', &mut block).map_err(fail)?;
    loop {
        block.clear();
        let limited = reader.by_ref().take(BLOCK).read_to_end(&mut block);
        if limited.map_err(fail)? == 0 {
            return Ok(());
        }
        reader.read_until(b'\n', &mut block).map_err(fail)?;
        let lines: Vec<&[u8]> = block.split_inclusive(|byte| *byte == b'\n').collect();
        let found: Vec<Option<T>> = lines.into_par_iter().map(&read).collect();
        for one in found {
            if take(one).is_break() {
                return Ok(());
            }
        }
    }
}

/// The places of the whole lines behind the header; `None` if there is another header.
fn whole_lines(file: &mut File, header: &str, first: u64) -> std::io::Result<Option<Vec<u64>>> {
    let mut reader = BufReader::new(file);
    let mut line = Vec::new();
    reader.read_until(b'\n', &mut line)?;
    if line != header.as_bytes() {
        return Ok(None);
    }
    let mut places = vec![line.len() as u64];
    loop {
        line.clear();
        let bytes = reader.read_until(b'\n', &mut line)? as u64;
        let begin = places.last().copied().unwrap_or_default();
        let expected = first + places.len() as u64 - 1;
        match record_of::<NumberOnly>(&line) {
            Some(record) if record.number == expected => places.push(begin + bytes),
            _ => return Ok(Some(places)),
        }
    }
}

/// The record of a line that is whole, or what is asked of it.
fn record_of<T: for<'de> Deserialize<'de>>(line: &[u8]) -> Option<T> {
    // A line has one form, so its two parts are found without reading it as JSON.
    let line = line.strip_suffix(b"}\n")?.strip_prefix(b"{\"hash\":\"")?;
    let (hash, rest) = line.split_at_checked(16)?;
    let text = rest.strip_prefix(b"\",\"episode\":")?;
    let is_ours = hash_of(text).as_bytes().starts_with(hash);
    is_ours.then(|| serde_json::from_slice(text).ok())?
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(number: u64) -> EpisodeRecord {
        EpisodeRecord {
            number,
            seed: u64::MAX - number,
            end: "complete".into(),
            simulated_secs: Some(0.1 + number as f64),
            recording: None,
            judged: vec![Judged {
                verdict: Verdict::Violated,
                triggered: 2,
                robustness: Some(Bounds {
                    low: f64::NEG_INFINITY,
                    high: 1.0 / 3.0,
                }),
                decided_at_secs: Some(1e-17),
                left_out: true,
            }],
            forms: vec![Verdict::NotCovered],
            crept: Vec::new(),
            out_of_reach: Vec::new(),
        }
    }

    fn filled(folder: &Path, count: u64) -> Journal {
        let mut journal = Journal::open(folder, 1, "a").expect("opened");
        for number in 1..=count {
            journal.add(&record(number)).expect("added");
        }
        journal
    }

    #[test]
    fn what_is_added_is_read_again_to_the_last_bit() {
        let folder = tempfile::tempdir().expect("a folder");
        filled(folder.path(), 3);
        let journal = Journal::open(folder.path(), 1, "a").expect("opened");
        assert_eq!(journal.count(), 3);
        assert_eq!(journal.read(2).expect("read"), Some(record(2)));
        assert_eq!(journal.read(4).expect("read"), None);
        assert_eq!(journal.read(0).expect("read"), None);
    }

    #[test]
    fn a_journal_cut_at_any_byte_keeps_its_whole_lines_and_goes_on() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = filled(folder.path(), 3).path().to_owned();
        let whole = std::fs::read(&path).expect("bytes");
        let ends: Vec<usize> = (0..whole.len()).filter(|at| whole[*at] == b'\n').collect();
        for cut in (0..=whole.len())
            .step_by(3)
            .chain(ends.iter().flat_map(|end| [*end, end + 1]))
        {
            std::fs::write(&path, &whole[..cut]).expect("cut");
            let mut journal = Journal::open(folder.path(), 1, "a").expect("opened");
            let complete = ends.iter().skip(1).filter(|end| **end < cut).count() as u64;
            assert_eq!(journal.count(), complete, "cut at {cut}");
            for number in complete + 1..=3 {
                journal.add(&record(number)).expect("added");
            }
            drop(journal);
            assert!(
                std::fs::read(&path).expect("bytes") == whole,
                "cut at {cut}"
            );
        }
    }

    #[test]
    fn an_edited_line_ends_what_is_taken() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = filled(folder.path(), 3).path().to_owned();
        let text = std::fs::read_to_string(&path).expect("text");
        let place = text.rfind("\"triggered\":2").expect("the last line");
        let mut edited = text.into_bytes();
        edited[place + 12] = b'3';
        std::fs::write(&path, edited).expect("edited");
        assert_eq!(
            Journal::open(folder.path(), 1, "a")
                .expect("opened")
                .count(),
            2
        );
    }

    #[test]
    fn other_monitors_begin_anew_and_other_numbers_have_their_own() {
        let folder = tempfile::tempdir().expect("a folder");
        filled(folder.path(), 3);
        assert_eq!(
            Journal::open(folder.path(), 101, "a")
                .expect("opened")
                .count(),
            0
        );
        assert_eq!(
            Journal::open(folder.path(), 1, "a")
                .expect("opened")
                .count(),
            3
        );
        assert_eq!(
            Journal::open(folder.path(), 1, "b")
                .expect("opened")
                .count(),
            0
        );
    }
}
