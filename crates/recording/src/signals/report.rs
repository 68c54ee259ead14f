//! What a stream left out, and what it assumed.

use std::collections::BTreeMap;
use std::fmt;

/// The kind of a [`StreamNote`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum StreamNoteKind {
    /// Messages came too late to be put in order and were left out.
    Late,
    /// Messages whose stamp is 0 were left out.
    Unstamped,
    /// Messages came before the first one of `/clock` and were left out.
    BeforeClock,
    /// The simulation's clock went back; the stream ended there.
    ClockReset,
    /// Messages do not fit the schema of their topic and were left out.
    Undecodable,
    /// A value is not one of the names that the topic map lists; it is missing.
    UnknownName,
    /// Transforms that cannot be used were left out.
    BadTransform,
    /// A transform was not known when it was needed; the value is missing.
    NoTransform,
    /// Messages have no header, so their log time was taken.
    LogTimeTaken,
}

impl StreamNoteKind {
    /// Whether something that was recorded is missing in the signals.
    #[must_use]
    pub fn is_loss(self) -> bool {
        !matches!(
            self,
            StreamNoteKind::LogTimeTaken | StreamNoteKind::BeforeClock
        )
    }
}

/// Something that happened on one topic, once or more often.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamNote {
    /// What.
    pub kind: StreamNoteKind,
    /// The topic.
    pub topic: String,
    /// How often.
    pub count: u64,
    /// What was said the first time.
    pub first: String,
    /// Where in the recording that was, in bytes.
    pub first_offset: u64,
}

impl fmt::Display for StreamNote {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (count, topic) = (self.count, &self.topic);
        let plural = if count == 1 { "" } else { "s" };
        match self.kind {
            StreamNoteKind::Late => write!(
                out,
                "{count} message{plural} of {topic} came too late to be put in order and are left \
                 out; raise reorder in [time] of the topic map"
            )?,
            StreamNoteKind::Unstamped => write!(
                out,
                "{count} message{plural} of {topic} with the stamp 0 are left out; use another time"
            )?,
            StreamNoteKind::BeforeClock => write!(
                out,
                "{count} message{plural} of {topic} came before the first one of /clock and are \
                 left out"
            )?,
            StreamNoteKind::ClockReset => write!(
                out,
                "the clock of the simulation went back, so what follows is of another run and is \
                 left out; split the recording there"
            )?,
            StreamNoteKind::Undecodable => write!(
                out,
                "{count} message{plural} of {topic} do not fit their schema and are left out"
            )?,
            StreamNoteKind::UnknownName => write!(
                out,
                "{count} value{plural} of {topic} not among the names in the topic map, counted as missing; add the names"
            )?,
            StreamNoteKind::BadTransform => write!(
                out,
                "{count} transform{plural} on {topic} cannot be used and are left out"
            )?,
            StreamNoteKind::NoTransform => write!(
                out,
                "{count} value{plural} of {topic} are missing because a transform is not known"
            )?,
            StreamNoteKind::LogTimeTaken => write!(
                out,
                "messages of {topic} have no header, so their log time was taken"
            )?,
        }
        if !self.first.is_empty() {
            write!(
                out,
                " (the first at byte {}: {})",
                self.first_offset, self.first
            )?;
        }
        Ok(())
    }
}

/// All notes, one for each kind and topic.
#[derive(Debug, Clone, Default)]
pub(super) struct Notes {
    notes: BTreeMap<(StreamNoteKind, String), StreamNote>,
}

impl Notes {
    pub fn add(
        &mut self,
        kind: StreamNoteKind,
        topic: &str,
        offset: u64,
        said: impl FnOnce() -> String,
    ) {
        // Almost always there is one already; then no text is made.
        if let Some(note) = self.notes.get_mut(&(kind, topic.to_owned())) {
            note.count += 1;
            return;
        }
        let note = StreamNote {
            kind,
            topic: topic.to_owned(),
            count: 1,
            first: said(),
            first_offset: offset,
        };
        self.notes.insert((kind, topic.to_owned()), note);
    }

    pub fn list(&self) -> Vec<StreamNote> {
        self.notes.values().cloned().collect()
    }
}
