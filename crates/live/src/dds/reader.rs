//! The reader of one topic.

use super::sequence::{Numbered, Numbers, Releases};
use super::session::{Reader, Session, Wanted};
use super::stamp::unix_nanos;
use crate::stream::Outlet;
use crate::{Event, LossCause, Message, Topic};
use rustdds::dds::result::ReadError;
use rustdds::mio1;
use rustdds::no_key::DeserializedCacheChange;
use rustdds::{GUID, Timestamp};
use std::collections::BTreeSet;
use std::rc::Rc;
use std::sync::Arc;

/// How many messages of a topic are taken before those of other topics get their turn.
const TAKEN_AT_ONCE: usize = 1024;

/// A message as the stack hands it out.
pub(super) type Sample = DeserializedCacheChange<Vec<u8>>;

/// A message that waits to be handed out.
pub(super) struct Waiting {
    /// When it could be handed out: it and all before it of the same writer had arrived. A message that was lost and
    /// sent again arrives after those that follow it, so the times of arrival alone would not keep the order.
    pub(super) released: Timestamp,
    /// The place of its topic.
    pub(super) place: usize,
    /// The message.
    pub(super) sample: Sample,
}

/// A topic that is listened to.
pub(super) struct Listened {
    pub(super) topic: Arc<Topic>,
    pub(super) wanted: Wanted,
    /// Since when nobody publishes it, in nanoseconds on the source's clock.
    pub(super) away_since_nanos: Option<i64>,
    // Before the session: a reader is dropped while its participant lives.
    reader: Reader,
    pub(super) session: Rc<Session>,
    numbers: Numbers<GUID>,
    /// Messages that were not understood and whose numbers will therefore be missing.
    undecodable: u64,
}

impl Listened {
    pub(super) fn new(
        topic: Arc<Topic>,
        wanted: Wanted,
        reader: Reader,
        session: Rc<Session>,
    ) -> Self {
        Self {
            topic,
            wanted,
            away_since_nanos: None,
            reader,
            session,
            numbers: Numbers::new(),
            undecodable: 0,
        }
    }

    /// Replaces the reader by one with another quality of service or of another session. The numbers stay, so what
    /// both would hand out is handed out once, and what neither gets is counted.
    pub(super) fn replace(&mut self, wanted: Wanted, reader: Reader, session: Rc<Session>) {
        self.wanted = wanted;
        self.reader = reader;
        self.session = session;
    }

    pub(super) fn register(
        &mut self,
        registry: &mio1::Registry,
        token: mio1::Token,
    ) -> std::io::Result<()> {
        registry.register(&mut self.reader, token, mio1::Interest::READABLE)
    }

    /// Takes what has arrived into `waiting`, under the topic's place. True if more may wait.
    pub(super) fn take(
        &mut self,
        place: usize,
        waiting: &mut Vec<Waiting>,
        outlet: &Outlet,
    ) -> Result<bool, ReadError> {
        self.reader.drain_read_notifications();
        let mut releases = Releases::new();
        for _ in 0..TAKEN_AT_ONCE {
            match self.reader.try_take_one() {
                Ok(Some(sample)) => {
                    let released = releases.note(sample.writer_guid, sample.receive_instant);
                    waiting.push(Waiting {
                        released,
                        place,
                        sample,
                    });
                }
                Ok(None) => return Ok(false),
                Err(ReadError::Deserialization { .. } | ReadError::UnknownKey { .. }) => {
                    self.undecodable += 1;
                    self.tell_lost(1, LossCause::Undecodable, outlet);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(true)
    }

    /// Checks a message's number and hands it out.
    pub(super) fn hand_out(&mut self, sample: Sample, outlet: &Outlet) {
        let sequence = i64::from(sample.sequence_number);
        let numbered = self.numbers.note(sample.writer_guid, sequence);
        if numbered == Numbered::Repeated {
            return;
        }
        self.note_back(outlet);
        match numbered {
            Numbered::Repeated | Numbered::Next => {}
            Numbered::First { sent_before } => outlet.queue.push_event(Event::PublisherJoined {
                topic: self.topic.clone(),
                sent_before,
            }),
            Numbered::After { missing } => {
                let told = missing.min(self.undecodable);
                self.undecodable -= told;
                if missing > told {
                    self.tell_lost(missing - told, LossCause::Transport, outlet);
                }
            }
        }
        let clock = &outlet.queue.clock;
        let arrived = unix_nanos(sample.receive_instant);
        outlet.queue.push_message(Message {
            topic: self.topic.clone(),
            publish_nanos: sample.source_timestamp().and_then(unix_nanos),
            received_nanos: arrived.map_or_else(
                || clock.now_nanos(),
                |nanos| clock.from_recent_wall_stamp(nanos),
            ),
            sequence: Some(sequence),
            data: sample.into_value(),
        });
    }

    fn tell_lost(&self, count: u64, cause: LossCause, outlet: &Outlet) {
        outlet.queue.push_event(Event::Lost {
            topic: Some(self.topic.clone()),
            count,
            cause,
        });
    }

    /// Somebody publishes the topic: a writer was found, or a message came from one that was there so shortly that it
    /// was not. Says so if nobody did before.
    fn note_back(&mut self, outlet: &Outlet) {
        if let Some(since) = self.away_since_nanos.take() {
            outlet.queue.push_event(Event::Reconnected {
                topic: Some(self.topic.clone()),
                away_nanos: outlet.queue.clock.now_nanos() - since,
            });
        }
    }

    /// Takes note of the writers that are there now, and says if all are gone or some are back.
    pub(super) fn note_writers(&mut self, present: &BTreeSet<GUID>, outlet: &Outlet) {
        if !present.is_empty() {
            self.note_back(outlet);
        } else if self.away_since_nanos.is_none() {
            self.away_since_nanos = Some(outlet.queue.clock.now_nanos());
            outlet.queue.push_event(Event::Disconnected {
                topic: Some(self.topic.clone()),
                reason: "it has no publisher any more".to_owned(),
            });
        }
        self.numbers.forget_gone(present);
    }
}
