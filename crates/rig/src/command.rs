//! A command as a rig that takes any stimulus: JSON in, a recording out.
//!
//! What the ledger's stimulus sets, every episode has, unless its own stimulus says otherwise; so what
//! is left out of a stimulus is as the ledger has it. A recording is read through the study's topic
//! map as a trace of all signals of its words, and shown to whoever watches once it is whole. Who has
//! seen enough gets the part up to there, but the command has run to its end.
//!
//! A command cannot be stopped in the middle and continued, so rare events are not split on it; and
//! it does not say what it draws from its seed itself, so of all draws only those of the ledger's
//! stimulus can be set.

pub(super) mod once;
mod outside;
mod persistent;

use super::rest::Rest;
use super::rig::Rig;
use super::saving::Resumable;
use diagnostic::{Problem, Source};
use evidence::{Asset, DescriptionGap, Tool};
use host::store::Inputs;
use host::{BuildId, Cancel, Host};
pub use outside::OutsideCommand;
use recording::{Interpolation, SignalSource, TopicMap};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use stimulus::{AbstractTest, Settings, Stimulus};
use study::{CommandText, Rule, Study};
use testbench::{Control, Drawn, End, Failure, Recorded, SimError, Watch};
use toml::{Table, Value};
use trace::{Field, FieldKind, Trace};

/// The seeds that are tried to learn what its recordings hold.
const FIRST_SEEDS: std::ops::RangeInclusive<u64> = 1..=3;

/// Folders that this process has made.
static FOLDERS: AtomicU64 = AtomicU64::new(0);

/// A command that is run once an episode.
pub struct CommandRig {
    command: OutsideCommand,
    /// The signals that are read: those of the study's words.
    wanted: Vec<String>,
    /// These and others that the topic map names, for whoever compares or explores recordings.
    known: Vec<String>,
    tests: Vec<AbstractTest>,
    data: Table,
    room: Room,
    episodes: AtomicU64,
    /// Words that the study compares signals with: those that one episode has not said another may.
    words: Vec<String>,
    /// The topics of its recordings, once one is there.
    layout: Mutex<Option<Trace>>,
}

/// What stands in a layout for each word that neither its first episode nor the study knows.
const ANOTHER: &str = "(another word)";

/// The words in single quotes with which the study's predicates compare signals.
fn words_of(study: &Study) -> Vec<String> {
    let vocabulary = &study.vocabulary.signals;
    let bound = vocabulary.names().filter_map(|name| vocabulary.text(name));
    let rules = study
        .forms
        .subjects
        .iter()
        .filter_map(|form| form.monitor.as_ref());
    let atoms = rules.flat_map(|monitor| match &monitor.rule {
        Rule::Formula(rule) => rule
            .parsed
            .atoms
            .iter()
            .map(|atom| atom.text.as_str())
            .collect(),
        Rule::Staged(_) => Vec::new(),
    });
    let mut found: Vec<String> = Vec::new();
    for text in bound.chain(atoms) {
        for word in text.split('\'').skip(1).step_by(2) {
            if !found.iter().any(|it| it == word) {
                found.push(word.to_owned());
            }
        }
    }
    found
}

impl CommandRig {
    /// The command of a ledger's entry. Its only test is that of its stimulus, for whose text `stimulus` may stand in;
    /// `test` has to be that one, if it is named. What passes outside campaigns goes to a folder of its own below the host's for that.
    ///
    /// # Errors
    /// `unknown-test`, and as [`OutsideCommand::new`].
    pub fn new(
        study: &Study,
        text: &CommandText,
        test: Option<&str>,
        stimulus: Option<&Source>,
        host: &Host,
    ) -> Result<Self, Problem> {
        let command = OutsideCommand::new(study, text, stimulus, host)?;
        has_test(&command, test)?;
        let wanted = signals_of(study);
        Ok(Self {
            known: known_signals(&command.rules().map, &wanted),
            wanted,
            tests: vec![command.stimulus().test.clone()],
            data: table_of(&command.settings()),
            room: Room::below(&host.scratch),
            episodes: AtomicU64::new(0),
            words: words_of(study),
            layout: Mutex::new(None),
            command,
        })
    }

    /// Why it may not run, if so.
    pub fn obstacle(&self) -> Option<&Problem> {
        self.command.obstacle()
    }

    /// The topics of a first episode, which is run for that.
    fn learn_layout(&self, interrupt: &Cancel) -> Result<Trace, Problem> {
        let mut failed = None;
        for seed in FIRST_SEEDS {
            let (trace, failure) = self.attempt(self.command.stimulus(), seed, interrupt)?;
            match (trace, failure) {
                (Some(mut layout), None) => {
                    for channel in &mut layout.channels {
                        channel.times_secs.clear();
                        channel.values.clear();
                        for field in &mut channel.fields {
                            know_words(field, &self.words);
                        }
                    }
                    layout.metadata.clear();
                    *self.layout.lock().unwrap_or_else(PoisonError::into_inner) =
                        Some(layout.clone());
                    return Ok(layout);
                }
                (_, failure) => failed = failed.or(failure),
            }
        }
        let words = failed.map_or_else(String::new, |failure| failure.words);
        Err(Problem::new("episode-failed", words).remedy(
            "it has not worked once: check `command` in the ledger; it runs in the study's folder",
        ))
    }

    fn known_layout(&self) -> Option<Trace> {
        let layout = self.layout.lock().unwrap_or_else(PoisonError::into_inner);
        layout.clone()
    }

    /// Runs the command; gives what it recorded, if that can be read, and what went wrong.
    fn attempt(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        interrupt: &Cancel,
    ) -> Result<(Option<Trace>, Option<Failure>), Problem> {
        let number = self.episodes.fetch_add(1, Ordering::Relaxed);
        let folder = self.room.folder()?;
        let recording = folder.join(self.command.recording_name(number));
        let failure = self
            .command
            .run(Some(stimulus), seed, &recording, interrupt)?;
        let read = match recording.exists() {
            // What no word reads may be missing.
            true => Some(
                (self.command.trace(&self.known, &recording))
                    .or_else(|_| self.command.trace(&self.wanted, &recording)),
            ),
            false => None,
        };
        OutsideCommand::remove(&recording);
        match (read, &failure) {
            // What a command left that failed may be no recording.
            (Some(Err(_)) | None, Some(_)) => Ok((None, failure)),
            (Some(read), _) => Ok((Some(read?), failure)),
            (None, None) => Ok((None, None)),
        }
    }
}

impl Rig for CommandRig {
    fn engine(&self) -> String {
        format!("`{}`", self.tool().name)
    }

    fn tool(&self) -> Tool {
        self.command.tool()
    }

    fn is_outside(&self) -> bool {
        true
    }

    fn assets(&self) -> &[Asset] {
        self.command.assets()
    }

    fn gaps(&self) -> &[DescriptionGap] {
        &[]
    }

    fn checked(&self) -> &[String] {
        &[]
    }

    fn truth(&self) -> Option<testbench::scene::TruthVocabulary> {
        None
    }

    fn stimulus(&self) -> &Stimulus {
        self.command.stimulus()
    }

    fn tests(&self) -> &[AbstractTest] {
        &self.tests
    }

    /// What the ledger's stimulus sets, as tables.
    fn data(&self) -> &Table {
        &self.data
    }

    fn time_step_key(&self) -> Option<&'static str> {
        None
    }

    fn ends_by_secs(&self) -> Option<f64> {
        None
    }

    fn own_inputs(&self, inputs: &mut Inputs) {
        self.command.inputs(inputs);
    }

    fn inputs(&self, inputs: &mut Inputs) {
        inputs
            .add("engine", self.engine().as_bytes())
            .add("bench", self.data.to_string().as_bytes());
        self.command.inputs(inputs);
        self.command.reading_inputs(inputs);
    }

    fn test_inputs(&self, build: &BuildId, inputs: &mut Inputs) {
        self.inputs(inputs);
        inputs.add("program", build.as_str().as_bytes());
    }

    fn reading_inputs(&self, inputs: &mut Inputs) {
        self.command.reading_inputs(inputs);
    }

    fn recording_name(&self, number: u64) -> String {
        self.command.recording_name(number)
    }

    fn layout(&self, cancel: &Cancel) -> Result<Trace, Problem> {
        match self.known_layout() {
            Some(layout) => Ok(layout),
            None => self.learn_layout(cancel),
        }
    }

    /// What the ledger's stimulus has drawn; what the command draws itself it does not say.
    fn drawn(&self, stimulus: &Stimulus, seed: u64) -> Result<Option<Vec<Drawn>>, SimError> {
        Ok(self.command.drawn(&stimulus.settings, seed))
    }

    fn refuses(&self, _: &Stimulus) -> Option<String> {
        None
    }

    /// `watch` may want the beginning only.
    fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        interrupt: &Cancel,
    ) -> Result<Recorded, SimError> {
        let outside = |problem: Problem| match problem.is_interruption() {
            true => SimError::Cancelled,
            false => SimError::Outside {
                reason: problem.line(),
            },
        };
        let (trace, failure) = self.attempt(stimulus, seed, interrupt).map_err(outside)?;
        let is_whole = failure.is_none() && trace.as_ref().is_some_and(|trace| trace.complete);
        let layout = match (&trace, self.known_layout()) {
            // Monitors are bound to topics, even where there is no row.
            (None, None) => Some(self.layout(interrupt).map_err(outside)?),
            (_, known) => known,
        };
        let (mut trace, is_enough) = shown(trace, layout, watch)?;
        trace.metadata.insert("seed".to_owned(), seed.to_string());
        let test = ("abstract_test".to_owned(), stimulus.test.name.clone());
        trace.metadata.extend([test]);
        for (key, value) in &stimulus.settings {
            let key = format!("setting.{key}");
            trace.metadata.insert(key, value.to_string());
        }
        // What comes after enough has been seen is another matter.
        let failure = failure.filter(|_| !is_enough);
        if let Some(failure) = &failure {
            let kind = failure.kind().to_owned();
            trace.metadata.insert("failed".to_owned(), kind);
        }
        trace.complete = is_whole && !is_enough;
        Ok(Recorded {
            steps: 0,
            sim_secs: trace.end_secs().unwrap_or(0.0),
            trace,
            end: match (is_enough, &failure) {
                (true, _) => End::Watched,
                (false, Some(_)) => End::Failed,
                (false, None) => End::Over,
            },
            failure,
        })
    }

    fn in_fast_physics(&self) -> Option<Box<dyn Rig>> {
        None
    }

    fn resumable(&self) -> Option<&dyn Resumable> {
        None
    }

    fn rest(&self, _: &dyn Fn(&[String]) -> bool) -> Option<Arc<dyn Rest>> {
        None
    }

    fn leaves(&self) -> Option<&OutsideCommand> {
        Some(&self.command)
    }
}

/// Where a command works outside campaigns: a folder for what passes, made once something runs there.
struct Room {
    scratch: PathBuf,
    made: Mutex<Option<PathBuf>>,
}

impl Room {
    fn below(scratch: &Path) -> Self {
        Self {
            scratch: scratch.to_owned(),
            made: Mutex::default(),
        }
    }

    fn folder(&self) -> Result<PathBuf, Problem> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(folder) = made.as_ref() {
            return Ok(folder.clone());
        }
        let number = FOLDERS.fetch_add(1, Ordering::Relaxed);
        let name = format!("corroborate-{}-{number}", std::process::id());
        let folder = self.scratch.join(name);
        std::fs::create_dir_all(&folder).map_err(|error| Problem::cannot_write(&folder, &error))?;
        Ok(made.insert(folder).clone())
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        let made = self.made.get_mut().unwrap_or_else(PoisonError::into_inner);
        if let Some(folder) = made.take() {
            OutsideCommand::remove(&folder);
        }
    }
}

fn has_test(command: &OutsideCommand, test: Option<&str>) -> Result<(), Problem> {
    let own = command.stimulus().test.name.as_str();
    match test.filter(|test| *test != own) {
        None => Ok(()),
        Some(test) => {
            let name = command.tool().name;
            let message = format!("the stimulus of `{name}` has no abstract test `{test}`");
            Err(Problem::new("unknown-test", message).remedy(format!("it has: {own}")))
        }
    }
}

/// All signals that the study's words name.
fn signals_of(study: &Study) -> Vec<String> {
    let vocabulary = &study.vocabulary.signals;
    let predicates = vocabulary.names().filter_map(|name| {
        let text = vocabulary.text(name)?;
        vocabulary.predicate(text).ok()
    });
    let signals: BTreeSet<String> = predicates.flat_map(|it| it.signals()).collect();
    signals.into_iter().collect()
}

/// The wanted signals, and all others of a topic map that add no row to any of them: values as they are recorded, in topics of
/// their own or from the messages that all wanted signals of their topic are read from. So what is judged is the same.
fn known_signals(map: &TopicMap, wanted: &[String]) -> Vec<String> {
    let topic_of = |name: &str| name.split('.').next().unwrap_or(name).to_owned();
    let source_of = |name: &str| match &map.find(name)?.0.source {
        SignalSource::Value { from } => Some(topic_of(from)),
        _ => None,
    };
    let mut known = wanted.to_vec();
    for name in map.signal_names() {
        let is_held = map
            .find(&name)
            .is_some_and(|(it, _)| it.interpolation == Interpolation::Hold);
        let Some(source) = source_of(&name).filter(|_| is_held && !wanted.contains(&name)) else {
            continue;
        };
        let mut beside = wanted.iter().filter(|it| topic_of(it) == topic_of(&name));
        if beside.all(|it| source_of(it).as_ref() == Some(&source)) {
            known.push(name);
        }
    }
    known
}

/// Settings as the tables that their dotted keys mean.
fn table_of(settings: &Settings) -> Table {
    let mut table = Table::new();
    for (key, value) in settings {
        let mut parts: Vec<&str> = key.split('.').collect();
        let Some(last) = parts.pop() else { continue };
        let place = parts.into_iter().try_fold(&mut table, |place, part| {
            let inner = place
                .entry(part)
                .or_insert_with(|| Value::Table(Table::new()));
            inner.as_table_mut()
        });
        if let Some(place) = place {
            place.insert(last.to_owned(), value.to_toml());
        }
    }
    table
}

/// Lets a field of words hold those that the study knows, and one for any other.
fn know_words(field: &mut Field, words: &[String]) {
    if let FieldKind::Enumeration(names) = &mut field.kind {
        let others = words.iter().map(String::as_str).chain([ANOTHER]);
        for word in others {
            if !names.iter().any(|it| it == word) {
                names.push(word.to_owned());
            }
        }
    }
}

/// Whether fields are the same but for the words that they have met.
fn are_alike(some: &[Field], others: &[Field]) -> bool {
    let is_of_words = |it: &Field| matches!(it.kind, FieldKind::Enumeration(_));
    some.len() == others.len()
        && some.iter().zip(others).all(|(one, other)| {
            let is_same =
                (&one.name, &one.unit, &one.frame) == (&other.name, &other.unit, &other.frame);
            is_same && (one.kind == other.kind || is_of_words(one) && is_of_words(other))
        })
}

/// The value of a field as the same word's of another.
fn in_words_of(from: &Field, to: &Field, value: f64) -> f64 {
    let (FieldKind::Enumeration(ours), FieldKind::Enumeration(theirs)) = (&from.kind, &to.kind)
    else {
        return value;
    };
    if value.is_nan() || ours == theirs {
        return value;
    }
    let place = |word: &str| theirs.iter().position(|it| it == word);
    let word = ours.get(value as usize).and_then(|word| place(word));
    word.or_else(|| place(ANOTHER))
        .map_or(f64::NAN, |at| at as f64)
}

/// A recording in the topics of a layout, up to where `watch` has seen enough; whether it has.
fn shown(
    trace: Option<Trace>,
    layout: Option<Trace>,
    watch: &mut dyn Watch,
) -> Result<(Trace, bool), SimError> {
    let recorded = trace.unwrap_or_default();
    let mut shown = layout.unwrap_or_else(|| {
        let mut empty = recorded.clone();
        for channel in &mut empty.channels {
            channel.times_secs.clear();
            channel.values.clear();
        }
        empty
    });
    // Time, topic and row, in the order of time; rows of one topic stay in theirs.
    let mut rows: Vec<(f64, usize, usize, usize)> = Vec::new();
    for (place, channel) in shown.channels.iter().enumerate() {
        let from = recorded.channels.iter();
        let from = from
            .enumerate()
            .find(|(_, it)| it.topic == channel.topic && are_alike(&it.fields, &channel.fields));
        if let Some((index, from)) = from {
            let times = from.times_secs.iter().enumerate();
            rows.extend(times.map(|(row, secs)| (*secs, place, index, row)));
        }
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut values: Vec<f64> = Vec::new();
    for (time_secs, place, index, row) in rows {
        let (from, to) = (&recorded.channels[index], &mut shown.channels[place]);
        values.clear();
        let fields = from.fields.iter().zip(&to.fields).zip(from.row(row));
        values.extend(fields.map(|((from, to), value)| in_words_of(from, to, *value)));
        to.push(time_secs, &values)?;
        if watch.row(place, time_secs, &values) == Control::Finish {
            return Ok((shown, true));
        }
    }
    Ok((shown, false))
}

#[cfg(test)]
mod tests {
    use super::*;
    use trace::Channel;

    #[test]
    fn dotted_keys_are_tables() {
        let settings = Settings::from([
            ("cart.speed".to_owned(), 1.5.into()),
            ("cart.brake.gain".to_owned(), 2.5.into()),
            ("wet".to_owned(), true.into()),
        ]);
        let table = table_of(&settings);
        assert_eq!(table["cart"]["speed"].as_float(), Some(1.5));
        assert_eq!(table["cart"]["brake"]["gain"].as_float(), Some(2.5));
        assert_eq!(table["wet"].as_bool(), Some(true));
    }

    /// One episode has met other words than another: none of its rows may be lost for that.
    #[test]
    fn words_that_the_first_episode_did_not_say_are_kept() {
        let states = |names: &[&str], values: &[f64]| {
            let mut channel =
                Channel::new("/cell", vec![Field::enumeration("state", names.to_vec())]);
            for (at, value) in values.iter().enumerate() {
                channel.push(at as f64, &[*value]).unwrap();
            }
            Trace {
                channels: vec![channel],
                ..Trace::default()
            }
        };
        let mut layout = states(&["move", "wait"], &[]);
        know_words(&mut layout.channels[0].fields[0], &["stop".to_owned()]);
        let recorded = states(&["wait", "stop", "back"], &[0.0, 1.0, 2.0, f64::NAN]);
        let mut all = UpTo(f64::INFINITY, Vec::new());
        let (seen, _) = shown(Some(recorded), Some(layout), &mut all).unwrap();
        let channel = &seen.channels[0];
        let FieldKind::Enumeration(names) = &channel.fields[0].kind else {
            panic!("{channel:?}");
        };
        let words: Vec<Option<&str>> = channel
            .values
            .iter()
            .map(|it| (!it.is_nan()).then(|| names[*it as usize].as_str()))
            .collect();
        assert_eq!(words, [Some("wait"), Some("stop"), Some(ANOTHER), None]);
    }

    /// Sees all rows up to a time.
    struct UpTo(f64, Vec<(usize, f64)>);

    impl Watch for UpTo {
        fn row(&mut self, topic_index: usize, time_secs: f64, _: &[f64]) -> Control {
            self.1.push((topic_index, time_secs));
            match time_secs >= self.0 {
                true => Control::Finish,
                false => Control::Continue,
            }
        }
    }

    #[test]
    fn a_recording_is_shown_in_the_order_of_time_and_cut_where_enough_was_seen() {
        let channel = |topic: &str, times: &[f64]| {
            let mut channel = Channel::new(topic, vec![Field::bool("b")]);
            for secs in times {
                channel.push(*secs, &[1.0]).unwrap();
            }
            channel
        };
        let trace = |channels: Vec<Channel>| Trace {
            channels,
            ..Trace::default()
        };
        let recorded = trace(vec![
            channel("/b", &[0.5, 1.5]),
            channel("/a", &[0.0, 1.0, 2.0]),
        ]);
        let layout = trace(vec![
            channel("/a", &[]),
            channel("/c", &[]),
            channel("/b", &[]),
        ]);
        let mut watch = UpTo(1.5, Vec::new());
        let (cut, is_enough) = shown(Some(recorded), Some(layout), &mut watch).unwrap();
        assert!(is_enough);
        assert_eq!(watch.1, [(0, 0.0), (2, 0.5), (0, 1.0), (2, 1.5)]);
        assert_eq!(cut.channels[0].times_secs, [0.0, 1.0]);
        assert!(cut.channels[1].is_empty());
        assert_eq!(cut.channels[2].times_secs, [0.5, 1.5]);
    }
}
