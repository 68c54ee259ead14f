//! Keeping a run: messages as they came, events, and verdicts.
//!
//! | file | holds |
//! |---|---|
//! | `recordings/NAME.mcap` | the messages, with the definitions of their types |
//! | `events/NAME.jsonl` | what happened, as `--format json` tells it |
//! | `verdicts/NAME.mcap` | the verdicts, to be opened beside the recording |
//!
//! Messages and events are handed to the operating system at least twice a
//! second, so they survive the end of this process.

use super::connection::schema_of;
use super::event::LiveVerdict;
use diagnostic::Problem;
use evidence::RunVerdict;
use live::Message;
use recording::{RawRecording, RawTopicId, ShownVerdict, TypeDefinitions, VerdictFile};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// How long messages are kept back at most.
const FLUSH_EVERY_NANOS: i64 = 500_000_000;

/// The name of what a recording says of its run.
const ABOUT: &str = "corroborate.watch";

/// Keeps one run.
pub struct Keeper {
    /// The recording.
    pub path: PathBuf,
    /// Recordings of earlier runs that were not ended.
    pub unfinished: Vec<PathBuf>,
    verdicts: PathBuf,
    recording: Option<RawRecording<BufWriter<File>>>,
    events: BufWriter<File>,
    types: TypeDefinitions,
    topics: BTreeMap<u32, RawTopicId>,
    flushed_nanos: i64,
    /// What could not be kept.
    failed: Option<String>,
}

impl Keeper {
    /// Begins a run in `folder` at `now_nanos`.
    pub fn new(folder: &Path, now_nanos: i64, types: TypeDefinitions) -> Result<Self, Problem> {
        let folders = ["recordings", "events", "verdicts"].map(|name| folder.join(name));
        for folder in &folders {
            std::fs::create_dir_all(folder)
                .map_err(|error| Problem::cannot_write(folder, &error))?;
        }
        let unfinished = unfinished(&folders[0]);
        let name = stamp(now_nanos);
        let (file, path, name) = new_file(&folders[0], &name)?;
        let events = folders[1].join(format!("{name}.jsonl"));
        let recording = RawRecording::new(BufWriter::new(file))
            .map_err(|error| Problem::new("cannot-write", error.to_string()))?;
        Ok(Self {
            path,
            unfinished,
            verdicts: folders[2].join(format!("{name}.mcap")),
            recording: Some(recording),
            events: File::create(&events)
                .map(BufWriter::new)
                .map_err(|error| Problem::cannot_write(&events, &error))?,
            types,
            topics: BTreeMap::new(),
            flushed_nanos: now_nanos,
            failed: None,
        })
    }

    /// Keeps a message that was received at `log_nanos`.
    pub fn message(&mut self, message: &Message, log_nanos: i64) {
        let Some(recording) = &mut self.recording else {
            return;
        };
        let topic = &message.topic;
        let written = match self.topics.get(&topic.id) {
            Some(id) => Ok(*id),
            None => {
                let schema = schema_of(topic, &self.types);
                let schema = schema.as_ref().map(|s| (s.encoding.as_str(), &s.data[..]));
                recording.add_topic(&topic.name, &topic.type_name, &topic.encoding, schema)
            }
        };
        let written = written.and_then(|id| {
            self.topics.insert(topic.id, id);
            // A publisher's clock may be anything; a time before 1970 is none.
            let publish_nanos = message.publish_nanos.filter(|nanos| *nanos >= 0);
            let publish_nanos = publish_nanos.unwrap_or(log_nanos);
            recording.write(id, log_nanos, publish_nanos, &message.data)
        });
        if let Err(error) = written {
            self.fail(error.to_string());
        }
    }

    /// Keeps an event's line.
    pub fn event(&mut self, line: &str) {
        if let Err(error) = writeln!(self.events, "{line}") {
            self.fail(format!("the events cannot be written: {error}"));
        }
    }

    /// Hands over what was kept back, if it is time.
    pub fn flush_when_due(&mut self, now_nanos: i64) {
        if now_nanos - self.flushed_nanos < FLUSH_EVERY_NANOS {
            return;
        }
        self.flushed_nanos = now_nanos;
        if let Some(recording) = &mut self.recording
            && let Err(error) = recording.flush()
        {
            self.fail(error.to_string());
        }
        if let Err(error) = self.events.flush() {
            self.fail(format!("the events cannot be written: {error}"));
        }
    }

    /// What could not be kept so far.
    pub fn failure(&self) -> Option<&str> {
        self.failed.as_deref()
    }

    fn fail(&mut self, what: String) {
        self.failed.get_or_insert(what);
    }

    /// Ends the recording, with what is to be known about the run.
    pub fn finish_recording(&mut self, about: &BTreeMap<String, String>) {
        let Some(recording) = self.recording.take() else {
            return;
        };
        let finished = recording
            .finish(ABOUT, about)
            .map_err(|error| error.to_string())
            .and_then(|mut file| file.flush().map_err(|error| error.to_string()));
        if let Err(error) = finished {
            self.fail(error);
        }
    }

    /// Writes the verdicts, each at the log time at which it was told, and
    /// hands over the events.
    pub fn finish_verdicts(&mut self, told: &[(i64, LiveVerdict)]) {
        if let Err(error) = self.events.flush() {
            self.fail(format!("the events cannot be written: {error}"));
        }
        let written = verdict_bytes(told).and_then(|bytes| {
            std::fs::write(&self.verdicts, bytes).map_err(|error| error.to_string())
        });
        if let Err(error) = written {
            self.fail(format!("the verdicts cannot be written: {error}"));
        }
    }
}

fn verdict_bytes(told: &[(i64, LiveVerdict)]) -> Result<Vec<u8>, String> {
    let text = |error: recording::Ros2WriteError| error.to_string();
    let mut file = VerdictFile::new().map_err(text)?;
    let mut places = BTreeMap::new();
    for (log_nanos, verdict) in told {
        let label = verdict.label();
        let place = match places.get(&label) {
            Some(place) => *place,
            None => {
                let place = file.add_requirement(&label, &label).map_err(text)?;
                places.insert(label, place);
                place
            }
        };
        let shown = match verdict.verdict {
            RunVerdict::Satisfied => ShownVerdict::Satisfied,
            RunVerdict::Violated => ShownVerdict::Violated,
            RunVerdict::NotCovered => ShownVerdict::NotCovered,
            RunVerdict::Inconclusive => ShownVerdict::Inconclusive,
        };
        file.verdict(place, *log_nanos, shown, &verdict.why())
            .map_err(text)?;
    }
    file.finish().map_err(text)
}

/// The recordings in `folder` that do not end as a recording ends: those of
/// runs that were killed, or that still go on.
fn unfinished(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut found: Vec<PathBuf> = entries
        .map(|entry| entry.path())
        .filter(|path| path.extension().is_some_and(|it| it == "mcap") && !has_end(path))
        .collect();
    found.sort();
    found
}

/// Whether the file ends with the magic number that ends every MCAP file. One
/// that cannot be read is not judged.
fn has_end(path: &Path) -> bool {
    const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";
    let read = || {
        let mut file = File::open(path)?;
        // The number also begins a file, so a file of nothing else has no end.
        if file.metadata()?.len() < 2 * MAGIC.len() as u64 {
            return Ok(false);
        }
        let mut end = [0; MAGIC.len()];
        file.seek(SeekFrom::End(-(MAGIC.len() as i64)))?;
        file.read_exact(&mut end)?;
        Ok::<_, std::io::Error>(end == *MAGIC)
    };
    read().unwrap_or(true)
}

/// A file that was not there before, with its name without extension.
fn new_file(folder: &Path, name: &str) -> Result<(File, PathBuf, String), Problem> {
    let mut attempt = 1;
    loop {
        let name = match attempt {
            1 => name.to_owned(),
            n => format!("{name}-{n}"),
        };
        let path = folder.join(format!("{name}.mcap"));
        match File::create_new(&path) {
            Ok(file) => return Ok((file, path, name)),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => attempt += 1,
            Err(error) => return Err(Problem::cannot_write(&path, &error)),
        }
    }
}

/// The time as `run-20260102T030405Z`. Days are turned into a date by counting
/// years from March, so that leap days come last (the Gregorian calendar's 400
/// years have 146,097 days).
fn stamp(unix_nanos: i64) -> String {
    let secs = unix_nanos.div_euclid(1_000_000_000);
    let (days, second) = (secs.div_euclid(86_400), secs.rem_euclid(86_400));
    let from_march_0000 = days + 719_468;
    let (era, day) = (
        from_march_0000.div_euclid(146_097),
        from_march_0000.rem_euclid(146_097),
    );
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day_of_year = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day_of_year + 2) / 153;
    let date = day_of_year - (153 * month + 2) / 5 + 1;
    let (month, year) = match month {
        0..=9 => (month + 3, year + era * 400),
        _ => (month - 9, year + era * 400 + 1),
    };
    let (hour, minute, second) = (second / 3_600, second / 60 % 60, second % 60);
    format!("run-{year:04}{month:02}{date:02}T{hour:02}{minute:02}{second:02}Z")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_that_were_killed_are_found_by_the_next_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let begin = |nanos| {
            let types = TypeDefinitions::new(&[]).expect("types");
            Keeper::new(folder.path(), nanos, types).expect("a keeper")
        };
        let mut whole = begin(0);
        assert_eq!(whole.unfinished, [] as [PathBuf; 0]);
        whole.finish_recording(&BTreeMap::new());
        let killed = begin(1_000_000_000);
        assert_eq!(killed.unfinished, [] as [PathBuf; 0]);
        // As SIGKILL leaves it: what was handed over is there, no end.
        let path = killed.path.clone();
        std::mem::forget(killed);
        assert_eq!(begin(2_000_000_000).unfinished, [path]);
    }

    /// Dates by `date -u -d @SECS +%Y%m%dT%H%M%SZ` of GNU coreutils.
    #[test]
    fn runs_are_named_by_their_date() {
        for (secs, expected) in [
            (0, "run-19700101T000000Z"),
            (951_782_400, "run-20000229T000000Z"),
            (1_709_251_199, "run-20240229T235959Z"),
            (1_735_689_599, "run-20241231T235959Z"),
            (4_107_542_400, "run-21000301T000000Z"),
        ] {
            assert_eq!(stamp(secs * 1_000_000_000), expected);
        }
    }
}
