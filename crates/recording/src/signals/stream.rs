//! From a recording to the values of all signals at one instant after another.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::fmt;

use trace::{Snapshot, Trace};

use super::bind::{self, BindError, Binding, ColumnPlan};
use super::decode::{TopicDecoder, kind_of};
use super::error::StreamError;
use super::plan::Treatment;
use super::report::{Notes, StreamNote, StreamNoteKind};
use super::sequencer::Sequencer;
use super::taking::{Role, Taking, Topic};
use super::tf_message::clock_nanos_of;
use crate::clock::{Mapped, SimulationClock, TimeSettings, TimeSource};
use crate::csv_rows::columns::NO_VALUE_IN;
use crate::reader::{Loss, RawMessage, Reader, TopicId, TopicInfo};
use crate::topic_map::TopicMap;

/// A message that waits for the next one of `/clock`.
#[derive(Debug)]
struct Waiting {
    topic: TopicId,
    log_nanos: i64,
    offset: u64,
    data: Vec<u8>,
}

/// An instant of a stream.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Its time in seconds from [`SignalStream::origin_nanos`].
    pub time_secs: f64,
    /// Its time in nanoseconds of the chosen clock.
    pub time_nanos: i64,
    /// When its last message was logged, in nanoseconds: where it stands in the recording, for
    /// what is shown beside it. Of values that become too old, and of those that waited for a
    /// transform, to within the delays of neighbouring messages. Equal to `time_nanos` by log
    /// time; otherwise it need not increase.
    pub log_nanos: i64,
    /// Whether another sample of the same instant follows.
    pub more: bool,
}

/// What [`SignalStream::poll`] found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Polled {
    /// The next instant.
    At(Moment),
    /// A message that gives no instant yet.
    Nothing,
    /// The last instant was given.
    End,
}

/// The signals of a recording, or of anything else that can be read as one.
pub struct SignalStream {
    reader: Box<dyn Reader + Send>,
    time: TimeSettings,
    binding: Binding,
    topics: Vec<Topic>,
    needs_frames: bool,
    sequencer: Sequencer,
    notes: Notes,
    clock: SimulationClock,
    waiting: VecDeque<Waiting>,
    /// A topic without stamps, and one whose stamps are far from log time.
    unstamped: Option<String>,
    far_stamped: Option<(String, i64)>,
    finished: bool,
    failed: Option<StreamError>,
    has_failed: bool,
    neighbours: Vec<(u64, i64, i64)>,
}

impl fmt::Debug for SignalStream {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("SignalStream")
            .field("layout", &self.binding.layout)
            .field("finished", &self.finished)
            .finish_non_exhaustive()
    }
}

impl SignalStream {
    /// The signals `wanted` of what `reader` reads, by `map` or as they are written; if none are
    /// named, all of the map.
    ///
    /// # Errors
    /// Every [`BindError`] there is. A signal of the map whose topic is not there is none: it is
    /// missing throughout, and [`SignalStream::absent`] names it.
    pub fn new(
        reader: Box<dyn Reader + Send>,
        map: &TopicMap,
        wanted: &[String],
    ) -> Result<Self, Vec<BindError>> {
        let all: Vec<String>;
        let wanted = if wanted.is_empty() {
            all = map.signal_names().collect();
            &all
        } else {
            wanted
        };
        if map.time.source == TimeSource::Clock
            && !reader.topics().iter().any(|info| info.name == "/clock")
        {
            return Err(vec![BindError {
                signal: "/clock".to_owned(),
                line: 0,
                message: "the time is to be that of /clock, which the recording does not have; \
                          use log, publish or header"
                    .to_owned(),
                is_lacking: false,
            }]);
        }
        let kind = |info: &TopicInfo, path: &str| kind_of(info, path);
        let binding = bind::bind((reader.topics(), reader.metadata()), map, wanted, &kind)?;
        let mut treatments = binding.sources.iter().map(|source| &source.treatment);
        let needs_frames = treatments.any(|treatment| *treatment != Treatment::Plain);
        let sequencer = Sequencer::new(&binding.layout, binding.sources.clone(), &map.time);
        let mut stream = SignalStream {
            reader,
            time: map.time,
            binding,
            topics: Vec::new(),
            needs_frames,
            sequencer,
            notes: Notes::default(),
            clock: SimulationClock::default(),
            waiting: VecDeque::new(),
            unstamped: None,
            far_stamped: None,
            finished: false,
            failed: None,
            has_failed: false,
            neighbours: Vec::new(),
        };
        stream.take_topics()?;
        stream.select();
        Ok(stream)
    }

    /// Decides what each topic is for that has appeared since.
    fn take_topics(&mut self) -> Result<(), Vec<BindError>> {
        let mut errors = Vec::new();
        for info in &self.reader.topics()[self.topics.len()..] {
            let role = match info.name.as_str() {
                "/clock" if self.time.source == TimeSource::Clock => Role::Clock,
                "/tf" if self.needs_frames => Role::Transforms { is_static: false },
                "/tf_static" if self.needs_frames => Role::Transforms { is_static: true },
                name => match self.binding.topics.iter().find(|plan| plan.name == name) {
                    None => Role::Ignored,
                    Some(plan) => match TopicDecoder::new(info, plan, self.sequencer.frames()) {
                        Ok(decoder) => Role::Rows(Box::new(decoder)),
                        Err(found) => {
                            errors.extend(found);
                            Role::Ignored
                        }
                    },
                },
            };
            self.topics.push(Topic {
                name: info.name.clone(),
                encoding: info.encoding.clone(),
                role,
            });
        }
        if errors.is_empty() {
            Ok(())
        } else {
            Err(errors)
        }
    }

    fn select(&mut self) {
        let mut wanted: BTreeSet<String> = self
            .binding
            .topics
            .iter()
            .map(|plan| plan.name.clone())
            .collect();
        if self.needs_frames {
            wanted.extend(["/tf".to_owned(), "/tf_static".to_owned()]);
        }
        if self.time.source == TimeSource::Clock {
            wanted.insert("/clock".to_owned());
        }
        self.reader.select(&|info| wanted.contains(&info.name));
    }

    /// The signals as channels without rows, to which predicates can be bound.
    #[must_use]
    pub fn layout(&self) -> &Trace {
        &self.binding.layout
    }

    /// The signals whose topics the recording does not have; they are missing throughout.
    #[must_use]
    pub fn absent(&self) -> &[BindError] {
        &self.binding.absent
    }

    /// The numbers among the signals that come from columns of a table in which no row has a value:
    /// nothing tells whether such a column would hold numbers or truth values.
    #[must_use]
    pub fn without_values(&self) -> Vec<String> {
        let metadata = self.reader.metadata();
        let mut found = Vec::new();
        for plan in &self.binding.topics {
            for row in &plan.rows {
                for (column, (signal, _)) in row.columns.iter().zip(&row.asked_by) {
                    if let ColumnPlan::Number { path, .. } = column
                        && metadata.contains_key(&format!("{NO_VALUE_IN}{}.{path}", plan.name))
                    {
                        found.push(signal.clone());
                    }
                }
            }
        }
        found
    }

    /// Moves to the next instant; `None` after the last one. After an error, the instants before
    /// it have all been given.
    ///
    /// # Errors
    /// [`StreamError`] if the recording cannot be read on or understood.
    pub fn next_instant(&mut self) -> Result<Option<Moment>, StreamError> {
        loop {
            match self.poll()? {
                Polled::At(moment) => return Ok(Some(moment)),
                Polled::Nothing => {}
                Polled::End => return Ok(None),
            }
        }
    }

    /// As [`SignalStream::next_instant`], but reads one message at most, for streams that have no
    /// end: between two messages the caller can look at the clock.
    ///
    /// # Errors
    /// As [`SignalStream::next_instant`].
    pub fn poll(&mut self) -> Result<Polled, StreamError> {
        if let Some(moment) = self.ready()? {
            return Ok(Polled::At(moment));
        }
        if self.finished {
            return self.failed.take().map_or(Ok(Polled::End), Err);
        }
        if let Err(error) = self.read_one() {
            // What was read before is given first.
            self.failed = Some(error);
            self.has_failed = true;
            self.finish();
        }
        Ok(Polled::Nothing)
    }

    /// The next instant, if it follows from what was read already.
    ///
    /// # Errors
    /// [`StreamError`] if its values cannot be held.
    pub fn ready(&mut self) -> Result<Option<Moment>, StreamError> {
        let next = self.sequencer.next(&mut self.notes);
        let next = next.map_err(StreamError::Trace)?;
        Ok(next.map(|time_nanos| Moment {
            time_secs: self.sequencer.secs(time_nanos),
            time_nanos,
            log_nanos: self.sequencer.log_nanos(),
            more: self.sequencer.more(),
        }))
    }

    /// If every message that was logged before `log_nanos` has been read: up to when the signals
    /// are known to be as they were at the last instant, in seconds from the origin; at most the
    /// moment before a value becomes too old or before something that waits for a transform.
    ///
    /// `None` before the first instant, if that is not behind the last one, and by other times than
    /// log time, since by those a message may always come later than it was measured.
    #[must_use]
    pub fn steady_until_secs(&self, log_nanos: i64) -> Option<f64> {
        let last_nanos = self.sequencer.last_nanos()?;
        if self.time.source != TimeSource::Log {
            return None;
        }
        let before_nanos = self.sequencer.steady_before_nanos();
        let until_nanos = log_nanos.min(before_nanos.saturating_sub(1));
        (until_nanos > last_nanos).then(|| self.sequencer.secs(until_nanos))
    }

    /// What the recording says of itself.
    #[must_use]
    pub fn metadata(&self) -> &BTreeMap<String, String> {
        self.reader.metadata()
    }

    /// The values at the last instant.
    #[must_use]
    pub fn snapshot(&self) -> &Snapshot {
        self.sequencer.snapshot()
    }

    /// For each channel of the layout, whether the last instant changed it.
    #[must_use]
    pub fn changed(&self) -> &[bool] {
        self.sequencer.changed()
    }

    /// For each signal of the layout, by channel and field, whether the last instant is one of its
    /// samples: the time of one of its messages, or one at which its value has become too old.
    #[must_use]
    pub fn sampled(&self) -> &[Vec<bool>] {
        self.sequencer.sampled()
    }

    /// For each signal, whether its value has become too old since its last sample.
    #[must_use]
    pub fn dropped(&self) -> &[Vec<bool>] {
        self.sequencer.dropped()
    }

    /// Whether any signal has a greatest age.
    #[must_use]
    pub fn can_drop(&self) -> bool {
        self.sequencer.can_drop()
    }

    /// Until when the recorder was at work, in seconds from the origin; `None` if it is not known, and by
    /// other times than log time. Final after the last instant.
    #[must_use]
    pub fn end_secs(&self) -> Option<f64> {
        let end_nanos = self.reader.end_nanos()?;
        (self.time.source == TimeSource::Log).then(|| self.sequencer.secs(end_nanos))
    }

    /// A time in nanoseconds of the chosen clock as seconds from [`SignalStream::origin_nanos`].
    #[must_use]
    pub fn secs(&self, time_nanos: i64) -> f64 {
        self.sequencer.secs(time_nanos)
    }

    /// Which time counts.
    #[must_use]
    pub fn time_source(&self) -> TimeSource {
        self.time.source
    }

    /// Finds out, while reading on, between which log times these places of the recording are, in
    /// bytes from its beginning: see [`SignalStream::neighbours`].
    pub fn find_neighbours(&mut self, offsets: Vec<u64>) {
        self.neighbours = offsets
            .into_iter()
            .map(|it| (it, i64::MIN, i64::MAX))
            .collect();
    }

    /// For each place asked for, the latest log time of a message before it in the file, and the
    /// earliest of one behind it; `i64::MIN` and `i64::MAX` if there is none.
    #[must_use]
    pub fn neighbours(&self) -> &[(u64, i64, i64)] {
        &self.neighbours
    }

    /// From where seconds are counted, in nanoseconds of the chosen clock: 0, or the first message
    /// that was put in order if times are dates. Known with the first instant.
    #[must_use]
    pub fn origin_nanos(&self) -> i64 {
        self.sequencer.origin_nanos()
    }

    /// What was left out or assumed so far.
    #[must_use]
    pub fn notes(&self) -> Vec<StreamNote> {
        self.notes.list()
    }

    /// What of the recording could not be read so far.
    #[must_use]
    pub fn losses(&self) -> &[Loss] {
        self.reader.losses()
    }

    /// Whether everything that was recorded of these signals was read and used, so far; `false`
    /// if messages were lost or left out or the recording was cut short.
    #[must_use]
    pub fn complete(&self) -> bool {
        let lost = self.notes.list().iter().any(|note| note.kind.is_loss());
        self.reader.complete() && !lost && !self.has_failed
    }

    /// The rest of the stream as a trace, for recordings that fit into memory: at each instant one
    /// row for each channel that it changed.
    ///
    /// # Errors
    /// [`StreamError`] as for [`SignalStream::next_instant`], and if a value is infinite, which a
    /// trace cannot hold.
    pub fn collect(&mut self) -> Result<Trace, StreamError> {
        let mut trace = self.binding.layout.clone();
        let mut row = Vec::new();
        while let Some(instant) = self.next_instant()? {
            for (index, channel) in trace.channels.iter_mut().enumerate() {
                if !self.changed()[index] {
                    continue;
                }
                row.clear();
                let signal = |field| trace::SignalIndex {
                    channel: index,
                    field,
                };
                let values =
                    (0..channel.fields.len()).map(|field| self.snapshot().value(signal(field)));
                row.extend(values.map(|value| value.unwrap_or(f64::NAN)));
                channel
                    .push(instant.time_secs, &row)
                    .map_err(StreamError::Trace)?;
            }
        }
        trace.metadata = self.reader.metadata().clone();
        trace.complete = self.complete();
        Ok(trace)
    }

    fn finish(&mut self) {
        self.finished = true;
        // Behind the last message of the clock, its time stands still.
        if let (Some(last), None) = (self.clock.last(), &self.failed) {
            while let Some(message) = self.waiting.pop_front() {
                let taken = self.take(&message.borrowed(), Some(last));
                if let Err(error) = taken {
                    self.failed = Some(error);
                    self.has_failed = true;
                }
            }
        }
        for message in std::mem::take(&mut self.waiting) {
            self.note_before_clock(message.topic, message.offset);
        }
        let end_nanos = match self.time.source {
            TimeSource::Log => self.reader.end_nanos(),
            _ => None,
        };
        self.sequencer.finish(end_nanos);
    }

    fn read_one(&mut self) -> Result<(), StreamError> {
        let known = self.topics.len();
        let Some(message) = self.reader.next().map_err(StreamError::Read)? else {
            self.finish();
            return Ok(());
        };
        for (offset, before, after) in &mut self.neighbours {
            if message.offset < *offset {
                *before = (*before).max(message.log_nanos);
            } else {
                *after = (*after).min(message.log_nanos);
            }
        }
        if message.topic.index() < known && self.time.source != TimeSource::Clock {
            let Self {
                topics,
                sequencer,
                notes,
                ..
            } = self;
            let mut taking = Taking {
                source: self.time.source,
                sequencer,
                notes,
                unstamped: &mut self.unstamped,
                far_stamped: &mut self.far_stamped,
            };
            return taking.message(&mut topics[message.topic.index()], &message, None);
        }
        // The message has to be let go before topics can be looked at.
        let message = Waiting {
            topic: message.topic,
            log_nanos: message.log_nanos,
            offset: message.offset,
            data: message.data.to_vec(),
        };
        if message.topic.index() >= known {
            self.take_topics().map_err(StreamError::Bind)?;
        }
        if self.time.source == TimeSource::Clock {
            self.by_clock(message)
        } else {
            self.take(&message.borrowed(), None)
        }
    }

    /// Takes a message whose time is that of `/clock`, or lets it wait.
    fn by_clock(&mut self, message: Waiting) -> Result<(), StreamError> {
        let Some(topic) = self.topics.get(message.topic.index()) else {
            return Ok(());
        };
        if !matches!(topic.role, Role::Clock) {
            if matches!(topic.role, Role::Transforms { is_static: true }) {
                return self.take(&message.borrowed(), Some(0));
            }
            self.waiting.push_back(message);
            if self.waiting.len() > self.time.reorder_messages {
                self.release_waiting(true)?;
            }
            return Ok(());
        }
        match clock_nanos_of(&topic.encoding, &message.data) {
            Ok(sim_nanos) => {
                if let Err(reset) = self.clock.push(message.log_nanos, sim_nanos) {
                    let note = || {
                        let (from, to) =
                            (reset.from_nanos as f64 / 1e9, reset.to_nanos as f64 / 1e9);
                        format!("from {from} s to {to} s")
                    };
                    self.notes
                        .add(StreamNoteKind::ClockReset, "/clock", message.offset, note);
                    self.finish();
                    return Ok(());
                }
            }
            Err(problem) => {
                self.notes.add(
                    StreamNoteKind::Undecodable,
                    "/clock",
                    message.offset,
                    || problem,
                );
            }
        }
        self.release_waiting(false)
    }

    /// Takes the waiting messages whose time is known; with `crowded`, the first in any case.
    fn release_waiting(&mut self, mut crowded: bool) -> Result<(), StreamError> {
        while let Some(first) = self.waiting.front() {
            let mapped = match self.clock.at(first.log_nanos) {
                Mapped::NotYet if crowded => {
                    self.clock.last().map_or(Mapped::BeforeFirst, Mapped::Time)
                }
                mapped => mapped,
            };
            crowded = false;
            if mapped == Mapped::NotYet {
                return Ok(());
            }
            let Some(message) = self.waiting.pop_front() else {
                return Ok(());
            };
            match mapped {
                Mapped::Time(time_nanos) => self.take(&message.borrowed(), Some(time_nanos))?,
                _ => self.note_before_clock(message.topic, message.offset),
            }
        }
        Ok(())
    }

    fn note_before_clock(&mut self, topic: TopicId, offset: u64) {
        let name = self
            .topics
            .get(topic.index())
            .map_or("", |topic| topic.name.as_str());
        self.notes
            .add(StreamNoteKind::BeforeClock, name, offset, String::new);
    }

    fn take(
        &mut self,
        message: &RawMessage<'_>,
        time_nanos: Option<i64>,
    ) -> Result<(), StreamError> {
        let Some(topic) = self.topics.get_mut(message.topic.index()) else {
            return Ok(());
        };
        let mut taking = Taking {
            source: self.time.source,
            sequencer: &mut self.sequencer,
            notes: &mut self.notes,
            unstamped: &mut self.unstamped,
            far_stamped: &mut self.far_stamped,
        };
        taking.message(topic, message, time_nanos)
    }
}

impl Waiting {
    fn borrowed(&self) -> RawMessage<'_> {
        RawMessage {
            topic: self.topic,
            log_nanos: self.log_nanos,
            publish_nanos: self.log_nanos,
            data: &self.data,
            offset: self.offset,
        }
    }
}

#[cfg(test)]
mod tests;
