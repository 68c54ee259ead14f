//! One message: its time, its rows or transforms, and what is wrong with it.

use super::decode::TopicDecoder;
use super::error::StreamError;
use super::report::{Notes, StreamNoteKind};
use super::sequencer::{Edge, Sequencer};
use super::tf_message::transforms_of;
use crate::clock::TimeSource;
use crate::reader::{Encoding, RawMessage};
use crate::transform::Transform;

/// How far stamps may be from log time, in nanoseconds, for the two to be mixed: a minute.
const SAME_CLOCK_NANOS: i64 = 60_000_000_000;

/// What a message of a topic is for.
#[derive(Debug)]
pub(super) enum Role {
    Ignored,
    Clock,
    Transforms { is_static: bool },
    Rows(Box<TopicDecoder>),
}

/// A topic as far as this stream is concerned.
#[derive(Debug)]
pub(super) struct Topic {
    pub name: String,
    pub encoding: Encoding,
    pub role: Role,
}

/// The parts of a stream that are needed to take a message, apart from the reader that lends it.
pub(super) struct Taking<'a> {
    pub source: TimeSource,
    pub sequencer: &'a mut Sequencer,
    pub notes: &'a mut Notes,
    pub unstamped: &'a mut Option<String>,
    pub far_stamped: &'a mut Option<(String, i64)>,
}

impl Taking<'_> {
    /// Takes a message; its time is `mapped_nanos` if that is given.
    pub fn message(
        &mut self,
        topic: &mut Topic,
        message: &RawMessage<'_>,
        mapped_nanos: Option<i64>,
    ) -> Result<(), StreamError> {
        let time_nanos = mapped_nanos.unwrap_or(match self.source {
            TimeSource::Publish => message.publish_nanos,
            _ => message.log_nanos,
        });
        match &mut topic.role {
            Role::Ignored | Role::Clock => Ok(()),
            Role::Transforms { is_static } => {
                let is_static = *is_static;
                self.transforms(topic, message, time_nanos, is_static);
                Ok(())
            }
            Role::Rows(decoder) => self.rows(&topic.name, decoder, message, time_nanos),
        }
    }

    fn rows(
        &mut self,
        topic: &str,
        decoder: &mut TopicDecoder,
        message: &RawMessage<'_>,
        time_nanos: i64,
    ) -> Result<(), StreamError> {
        let decoded = match decoder.decode(message.data, self.sequencer.frames()) {
            Ok(decoded) => decoded,
            Err(problem) => {
                self.notes
                    .add(StreamNoteKind::Undecodable, topic, message.offset, || {
                        problem
                    });
                self.without_values(decoder, message, time_nanos);
                return Ok(());
            }
        };
        if let Some(name) = decoded.unknown_name {
            self.notes
                .add(StreamNoteKind::UnknownName, topic, message.offset, || name);
        }
        let time_nanos = match (self.source, decoded.stamp_nanos) {
            (TimeSource::Header, Some(0)) => {
                self.notes.add(
                    StreamNoteKind::Unstamped,
                    topic,
                    message.offset,
                    String::new,
                );
                return Ok(());
            }
            (TimeSource::Header, Some(stamp_nanos)) => {
                self.stamped(topic, stamp_nanos, message.log_nanos)?;
                stamp_nanos
            }
            (TimeSource::Header, None) => {
                self.without_stamp(topic)?;
                time_nanos
            }
            _ => time_nanos,
        };
        for row in decoder.rows().iter().filter(|row| !row.is_absent) {
            let taken = self
                .sequencer
                .row(row.source, time_nanos, message.log_nanos, &row.values);
            if let Err(late) = taken {
                let by_secs = late.by_nanos as f64 / 1e9;
                let note = || format!("{by_secs} s behind what was given already");
                self.notes
                    .add(StreamNoteKind::Late, topic, message.offset, note);
                // The other rows of the message are as late.
                break;
            }
        }
        Ok(())
    }

    /// A message that cannot be understood is a sample without values, so that what it held is not
    /// taken for what was there before. By header time it has none.
    fn without_values(
        &mut self,
        decoder: &TopicDecoder,
        message: &RawMessage<'_>,
        time_nanos: i64,
    ) {
        if self.source == TimeSource::Header {
            return;
        }
        for row in decoder.rows() {
            let missing = vec![f64::NAN; row.values.len()];
            // One that comes too late is noted as lost already.
            let _ = (self.sequencer).row(row.source, time_nanos, message.log_nanos, &missing);
        }
    }

    fn stamped(
        &mut self,
        topic: &str,
        stamp_nanos: i64,
        log_nanos: i64,
    ) -> Result<(), StreamError> {
        let apart_nanos = log_nanos.saturating_sub(stamp_nanos);
        if self.far_stamped.is_none() && apart_nanos.saturating_abs() > SAME_CLOCK_NANOS {
            *self.far_stamped = Some((topic.to_owned(), apart_nanos));
            return self.check_clocks();
        }
        Ok(())
    }

    fn without_stamp(&mut self, topic: &str) -> Result<(), StreamError> {
        self.notes
            .add(StreamNoteKind::LogTimeTaken, topic, 0, String::new);
        if self.unstamped.is_none() {
            *self.unstamped = Some(topic.to_owned());
            return self.check_clocks();
        }
        Ok(())
    }

    fn check_clocks(&self) -> Result<(), StreamError> {
        match (&self.unstamped, &self.far_stamped) {
            (Some(unstamped), Some((stamped, apart_nanos))) => Err(StreamError::MixedClocks {
                unstamped: unstamped.clone(),
                stamped: stamped.clone(),
                apart_secs: *apart_nanos as f64 / 1e9,
            }),
            _ => Ok(()),
        }
    }

    fn transforms(
        &mut self,
        topic: &Topic,
        message: &RawMessage<'_>,
        time_nanos: i64,
        is_static: bool,
    ) {
        let name = &topic.name;
        let recorded = match transforms_of(&topic.encoding, message.data) {
            Ok(recorded) => recorded,
            Err(problem) => {
                self.notes
                    .add(StreamNoteKind::Undecodable, name, message.offset, || {
                        problem
                    });
                return;
            }
        };
        for one in recorded {
            let pose = match Transform::new(one.translation_m, one.rotation_xyzw) {
                Ok(pose) => pose,
                Err(problem) => {
                    let note = || format!("{} in {}: {problem}", one.child, one.parent);
                    self.notes
                        .add(StreamNoteKind::BadTransform, name, message.offset, note);
                    continue;
                }
            };
            let edge = Edge {
                parent: one.parent,
                child: one.child,
                pose,
                offset: message.offset,
            };
            if is_static {
                self.sequencer.static_transform(&edge, self.notes);
                continue;
            }
            let time_nanos = match self.source {
                TimeSource::Header if one.stamp_nanos == 0 => {
                    self.notes
                        .add(StreamNoteKind::Unstamped, name, message.offset, String::new);
                    continue;
                }
                TimeSource::Header => one.stamp_nanos,
                _ => time_nanos,
            };
            if let Err(late) = self
                .sequencer
                .transform(time_nanos, message.log_nanos, edge)
            {
                let note = || {
                    format!(
                        "{} s behind what was given already",
                        late.by_nanos as f64 / 1e9
                    )
                };
                self.notes
                    .add(StreamNoteKind::Late, name, message.offset, note);
            }
        }
    }
}
