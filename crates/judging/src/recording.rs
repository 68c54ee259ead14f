//! Recordings of any format, judged by the study's monitors.
//!
//! A trace that this program wrote is read whole; any other recording is
//! streamed through the study's topic map, so that its size does not matter.

mod losses;

use crate::{Judgement, Judges, Losses, News, Session, Shown, valueless_of};
use diagnostic::Problem;
use host::{Reach, Trust};
use recording::{Moment, OpenOptions, SignalStream, TimeSource, TopicMap};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use trace::{SignalIndex, Trace};

/// The name of a study's topic map.
const TOPIC_MAP: &str = "topics.toml";

/// How recordings are read.
#[derive(Debug, Default)]
pub struct ReadingRules {
    /// Where the signals are.
    pub map: TopicMap,
    /// How files are opened.
    pub options: OpenOptions,
}

/// Where a signal's values are measured in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SignalInfo {
    /// Its unit; empty if it has none.
    pub unit: String,
    /// The frame of its values.
    pub frame: Option<String>,
}

/// One recording, judged.
#[derive(Debug)]
pub struct JudgedRecording<'a> {
    /// One for each monitor.
    pub judgements: Vec<Judgement<'a>>,
    /// Whether everything that was recorded was read.
    pub complete: bool,
    /// What is missing, a clause each.
    pub lost: Vec<String>,
    /// What else is to be known about how it was read.
    pub notes: Vec<String>,
    /// The signals that are judged and have no value in it, `/topic.field`.
    pub valueless: BTreeSet<String>,
    /// Instants that were judged.
    pub instants: u64,
    /// The signals that were read.
    pub signals: BTreeMap<String, SignalInfo>,
}

impl ReadingRules {
    /// The rules of a study, with another topic map if one is named.
    pub fn of_study(folder: &Path, map: Option<&Path>) -> Result<Self, Problem> {
        let of_study = folder.join(TOPIC_MAP);
        let path = match map {
            Some(path) => path.to_owned(),
            None if of_study.exists() => {
                Reach::of(folder, &Trust::default()).check(&of_study)?;
                of_study
            }
            None => return Ok(Self::default()),
        };
        Ok(Self {
            map: read_map(&path)?,
            options: OpenOptions::default(),
        })
    }

    /// The rules of a call: another time or way of opening files counts more
    /// than the topic map.
    pub fn with_call(mut self, time: Option<TimeSource>, options: OpenOptions) -> Self {
        if let Some(time) = time {
            self.map.time.source = time;
        }
        self.options = options;
        self
    }

    /// The rules without a study: a topic map, if one is named.
    pub fn of_map(map: Option<&Path>) -> Result<Self, Problem> {
        let map = map.map(read_map).transpose()?;
        Ok(Self {
            map: map.unwrap_or_default(),
            options: OpenOptions::default(),
        })
    }

    /// Judges the recording at `path`; `go_on` is asked now and then.
    pub fn judge<'a>(
        &self,
        judges: &Judges<'a>,
        path: &Path,
        go_on: &dyn Fn() -> Result<(), Problem>,
    ) -> Result<JudgedRecording<'a>, Problem> {
        self.judge_and_show(judges, path, None, go_on)
    }

    /// As [`ReadingRules::judge`]; what is known at each instant is written
    /// to `shown`.
    pub fn judge_and_show<'a>(
        &self,
        judges: &Judges<'a>,
        path: &Path,
        shown: Option<&mut Shown>,
        go_on: &dyn Fn() -> Result<(), Problem>,
    ) -> Result<JudgedRecording<'a>, Problem> {
        let told = self.options.time_field.is_some() || self.options.time_unit.is_some();
        let own = if told { None } else { own_trace(path)? };
        match own {
            Some((trace, lost)) => of_trace(judges, &trace, lost, shown).map(|mut judged| {
                if self.map.time.source != TimeSource::Log {
                    let note = "it is a trace with one time, which counts, not another one";
                    judged.notes.push(note.to_owned());
                }
                judged
            }),
            None => self.of_stream(judges, path, shown, go_on),
        }
        .map_err(|problem| problem.about(&path.display().to_string()))
    }

    /// Judges a recording as it is read. If something of it is lost, it is read
    /// again, now that it is known where.
    fn of_stream<'a>(
        &self,
        judges: &Judges<'a>,
        path: &Path,
        shown: Option<&mut Shown>,
        go_on: &dyn Fn() -> Result<(), Problem>,
    ) -> Result<JudgedRecording<'a>, Problem> {
        let whole = Losses::default();
        let (found, stream) = self.of_stream_once(judges, path, &whole, None, go_on)?;
        let losses = self.losses(judges, path, &stream, go_on)?;
        if losses == whole && shown.is_none() {
            return Ok(found);
        }
        let (found, _) = self.of_stream_once(judges, path, &losses, shown, go_on)?;
        Ok(found)
    }

    /// The signals whose values become too old.
    fn can_drop(&self, judges: &Judges<'_>, layout: &Trace) -> Vec<SignalIndex> {
        let is_limited = |name: &String| {
            let entry = self.map.find(name);
            entry.is_some_and(|(entry, _)| entry.staleness_secs.is_some())
        };
        let signals = judges.signals();
        let limited = signals.iter().filter(|name| is_limited(name));
        limited.filter_map(|name| layout.signal(name)).collect()
    }

    fn of_stream_once<'a>(
        &self,
        judges: &Judges<'a>,
        path: &Path,
        losses: &Losses,
        mut shown: Option<&mut Shown>,
        go_on: &dyn Fn() -> Result<(), Problem>,
    ) -> Result<(JudgedRecording<'a>, SignalStream), Problem> {
        let mut stream = self.stream(judges, path)?;
        let losses = Losses {
            can_drop: self.can_drop(judges, stream.layout()),
            ..losses.clone()
        };
        let valueless = stream.without_values();
        let layout = judges.with_valueless(stream.layout(), &valueless);
        let mut session = judges.start_lossy(&layout, &losses)?;
        let mut instants = 0_u64;
        let mut failed = None;
        // Those that have had no value yet.
        let mut unseen: Vec<(String, SignalIndex)> = judges
            .signals()
            .into_iter()
            .filter_map(|name| stream.layout().signal(&name).map(|at| (name, at)))
            .collect();
        loop {
            match stream.next_instant() {
                Ok(Some(moment)) => {
                    take(&mut session, &stream, moment, shown.as_deref_mut())?;
                    unseen.retain(|(_, at)| stream.snapshot().value(*at).is_none());
                    instants += u64::from(!moment.more);
                }
                Ok(None) => break,
                // What was read before is judged; the rest is lost.
                Err(error) => {
                    failed = Some(error.to_string());
                    break;
                }
            }
            if instants.is_multiple_of(1 << 16) {
                go_on()?;
            }
        }
        let complete = stream.complete() && failed.is_none();
        let (mut lost, mut notes) = left_out(&stream);
        notes.extend(valueless.iter().map(without_value));
        lost.extend(failed);
        if !complete && lost.is_empty() {
            lost.push("it has no proper end, so its last messages may be missing".to_owned());
        }
        let missed = super::watched::missed(stream.metadata());
        let complete = complete && missed.is_none();
        lost.extend(missed);
        let until_secs = super::watched::until_secs(&stream);
        let judgements = match (until_secs, stream.end_secs()) {
            (None, Some(end_secs)) => session.finish_run(complete, end_secs),
            _ => session.finish_at(complete, until_secs)?,
        };
        let judged = JudgedRecording {
            judgements,
            lost,
            notes,
            signals: signals_of(judges, stream.layout()),
            valueless: unseen.into_iter().map(|(name, _)| name).collect(),
            complete,
            instants,
        };
        Ok((judged, stream))
    }

    /// A whole recording as a trace: as it is if this program wrote it, or else of the signals
    /// that are wanted, each topic with a row wherever it has a value.
    pub fn trace(&self, wanted: &[String], path: &Path) -> Result<Trace, Problem> {
        if let Some((trace, _)) = own_trace(path)? {
            return Ok(trace);
        }
        let bad = |message: String| Problem::said("bad-recording", message).of_file(path);
        let mut stream = self.stream_of(wanted, path)?;
        let mut trace = stream.layout().clone();
        let mut is_whole = true;
        loop {
            let moment = match stream.next_instant() {
                Ok(Some(moment)) => moment,
                Ok(None) => break,
                // What was read before stands; the rest is lost.
                Err(_) => {
                    is_whole = false;
                    break;
                }
            };
            let now = stream.snapshot();
            let changed = stream.changed().iter().enumerate();
            for (channel, _) in changed.filter(|(_, changed)| **changed) {
                let fields = 0..trace.channels[channel].fields.len();
                let value = |field| now.value(SignalIndex { channel, field });
                let row: Vec<f64> = fields
                    .map(|field| value(field).unwrap_or(f64::NAN))
                    .collect();
                let pushed = trace.channels[channel].push(moment.time_secs, &row);
                pushed.map_err(|error| bad(error.to_string()))?;
            }
        }
        trace.complete = is_whole && stream.complete();
        Ok(trace)
    }

    /// The signals of a recording that the judges read.
    pub fn stream(&self, judges: &Judges<'_>, path: &Path) -> Result<SignalStream, Problem> {
        let wanted: Vec<String> = judges.signals().into_iter().collect();
        self.stream_of(&wanted, path)
    }

    /// The signals of the judges that a recording does not have.
    pub(crate) fn lacking(
        &self,
        judges: &Judges<'_>,
        path: &Path,
    ) -> Result<BTreeSet<String>, Problem> {
        let wanted = judges.signals();
        if let Some((trace, _)) = own_trace(path)? {
            let lacks = |name: &String| trace.signal(name).is_none();
            return Ok(wanted.into_iter().filter(lacks).collect());
        }
        let reader = recording::open(path, &self.options)
            .map_err(|error| Problem::said("bad-recording", error).of_file(path))?;
        let wanted: Vec<String> = wanted.into_iter().collect();
        let errors = SignalStream::new(reader, &self.map, &wanted).err();
        let errors = errors.into_iter().flatten();
        let entries = errors.filter(|error| error.is_lacking);
        let entries: BTreeSet<String> = entries.map(|error| error.signal).collect();
        // A signal may be a part of what an entry of the map names.
        let lacks = |name: &String| {
            let entry = self.map.find(name).map(|(entry, _)| &entry.name);
            entries.contains(name) || entry.is_some_and(|entry| entries.contains(entry))
        };
        Ok(wanted.into_iter().filter(lacks).collect())
    }

    fn stream_of(&self, wanted: &[String], path: &Path) -> Result<SignalStream, Problem> {
        let reader = recording::open(path, &self.options)
            .map_err(|error| Problem::said("bad-recording", error).of_file(path))?;
        SignalStream::new(reader, &self.map, wanted).map_err(|errors| {
            let problems = errors
                .iter()
                .map(|error| Problem::new("bad-recording", error.to_string()).of_file(path));
            Problem::all(problems)
                .unwrap_or_else(|| Problem::new("bad-recording", "its signals are not known"))
                .remedy("say in the topic map (topics.toml, or --map) where the signal is; `corroborate inspect --draft-map` drafts it")
        })
    }
}

fn without_value(signal: &String) -> String {
    format!("{signal} has no value anywhere, so it is missing throughout")
}

/// Gives an instant to the monitors, and shows what they make of it.
fn take(
    session: &mut Session<'_, '_>,
    stream: &SignalStream,
    moment: Moment,
    shown: Option<&mut Shown>,
) -> Result<(), Problem> {
    session.step_changed(
        moment.time_secs,
        stream.snapshot(),
        &news_of(stream, moment),
    )?;
    match shown.filter(|_| !moment.more) {
        Some(shown) => shown.instant(moment.log_nanos, session),
        None => Ok(()),
    }
}

/// What an instant of a stream brings.
pub fn news_of(stream: &SignalStream, moment: Moment) -> News<'_> {
    News {
        changed: stream.changed(),
        sampled: Some(stream.sampled()),
        dropped: Some(stream.dropped()),
        more: moment.more,
    }
}

/// What of a recording is lost, and what else is to be known of how it was
/// read.
fn left_out(stream: &SignalStream) -> (Vec<String>, Vec<String>) {
    let (losses, others): (Vec<_>, Vec<_>) = stream
        .notes()
        .into_iter()
        .partition(|note| note.kind.is_loss());
    let lost = stream.losses().iter().map(ToString::to_string);
    let lost = lost.chain(losses.iter().map(ToString::to_string));
    let absent = stream.absent().iter().map(ToString::to_string);
    let notes = absent.chain(others.iter().map(ToString::to_string));
    (lost.collect(), notes.collect())
}

/// The units and frames of the signals that are judged.
fn signals_of(judges: &Judges<'_>, layout: &Trace) -> BTreeMap<String, SignalInfo> {
    let mut signals = BTreeMap::new();
    for name in judges.signals() {
        let Some(at) = layout.signal(&name) else {
            continue;
        };
        let field = &layout.channels[at.channel].fields[at.field];
        let info = SignalInfo {
            unit: field.unit.clone(),
            frame: field.frame.clone(),
        };
        signals.insert(name, info);
    }
    signals
}

fn of_trace<'a>(
    judges: &Judges<'a>,
    trace: &Trace,
    lost: Option<String>,
    shown: Option<&mut Shown>,
) -> Result<JudgedRecording<'a>, Problem> {
    let valueless = valueless_of(trace, judges);
    let with_valueless;
    let trace = match valueless.is_empty() {
        true => trace,
        false => {
            with_valueless = judges.with_valueless(trace, &valueless);
            &with_valueless
        }
    };
    let judgements = match shown {
        None => judges.judge(trace)?,
        Some(shown) => judges.judge_and_watch(trace, &mut |time_secs, session| {
            shown.instant((time_secs * 1e9).round() as i64, session)
        })?,
    };
    Ok(JudgedRecording {
        judgements,
        signals: signals_of(judges, trace),
        complete: trace.complete,
        lost: lost.into_iter().collect(),
        notes: valueless.iter().map(without_value).collect(),
        valueless: valueless.into_iter().collect(),
        instants: trace::ticks(trace, trace::Sampling::EveryRow)
            .map_or(0, |times| times.len() as u64),
    })
}

/// A trace that this program wrote, or a table of signals in its form, with
/// what is lost; `None` if the file is anything else.
fn own_trace(path: &Path) -> Result<Option<(Trace, Option<String>)>, Problem> {
    let bad = |message: String| Problem::said("bad-recording", message).of_file(path);
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    match extension {
        "csv" if has_our_header(path) => own_table(path).map(Some),
        "mcap" if recording::is_trace_file(path).map_err(|e| Problem::cannot_read(path, &e))? => {
            let outcome = recording::read_mcap(path).map_err(|error| bad(error.to_string()))?;
            Ok(Some((outcome.trace, outcome.lost)))
        }
        _ => Ok(None),
    }
}

/// A table in the form of this program. A last line without a line break may
/// be cut short, even within a number, so it is left out.
fn own_table(path: &Path) -> Result<(Trace, Option<String>), Problem> {
    let source = host::files::read_source(path)?;
    let whole_bytes = source.text.rfind('\n').map_or(0, |last| last + 1);
    let (whole, cut) = source.text.split_at(whole_bytes);
    let bad = |error: &dyn std::fmt::Display| Problem::said("bad-recording", error).of_file(path);
    let table = trace::Table::parse(&source.name, whole).map_err(|error| bad(&error))?;
    let mut trace = trace::trace_of_table(&table).map_err(|error| bad(&error))?;
    if cut.is_empty() {
        return Ok((trace, None));
    }
    trace.complete = false;
    let lost = format!(
        "at byte {whole_bytes}: the last line has no line break behind it and may be cut short, so \
         it is left out; if it is whole, add the line break"
    );
    Ok((trace, Some(lost)))
}

/// Whether a table names its signals as `/topic.field`.
fn has_our_header(path: &Path) -> bool {
    let Ok(file) = std::fs::File::open(path) else {
        return false;
    };
    let mut first = String::new();
    let read = std::io::BufRead::read_line(&mut std::io::BufReader::new(file), &mut first);
    read.is_ok() && first.starts_with("time_secs,") && first.contains(",/")
}

/// The recordings named, with those of named folders in natural order.
pub fn recordings(paths: &[PathBuf]) -> Result<Vec<PathBuf>, Problem> {
    let mut files = Vec::new();
    for path in paths {
        let found = recording::trials(path)
            .map_err(|error| Problem::said("bad-recording", error).of_file(path))?;
        if found.trials.is_empty() {
            return Err(Problem::new(
                "no-recordings",
                format!("{} holds no recording", path.display()),
            )
            .remedy("name recordings (MCAP, bags, CSV, JSON lines), or a folder of them"));
        }
        files.extend(found.trials.into_iter().map(|trial| trial.path));
    }
    Ok(files)
}

/// Reads a topic map.
///
/// # Errors
/// All its mistakes, each with its place.
pub fn read_map(path: &Path) -> Result<TopicMap, Problem> {
    let source = host::files::read_source(path)?;
    TopicMap::parse(&source.name, &source.text).map_err(|errors| {
        let problems = errors.into_iter().map(|error| {
            Problem::new("bad-topic-map", error.message)
                .at(&source, error.span)
                .remedy(error.remedy)
        });
        Problem::all(problems).unwrap_or_else(|| {
            Problem::new("bad-topic-map", "the topic map cannot be read")
                .at(&source, 0..0)
                .remedy("`corroborate inspect RECORDING` drafts a topic map")
        })
    })
}
