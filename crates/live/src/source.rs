//! The stream that every live connection gives: messages and what happened to the connection, in order.

use crate::{Clock, LiveError, Topic};
use std::sync::Arc;
use std::time::Duration;

/// A running system that is listened to.
///
/// Messages are collected by a thread of the source into a bounded queue, so that a slow caller delays nothing; what
/// does not fit is counted and reported as [`Event::Lost`] at the place in the stream where it is missing.
pub trait Source: Send {
    /// The next message or event, waiting up to `timeout` for it; `None` if nothing came.
    ///
    /// # Errors
    /// When the source has ended and all that came before was handed out; every further call gives the same error.
    fn next(&mut self, timeout: Duration) -> Result<Option<Incoming>, LiveError>;

    /// The topics seen so far; the index is [`Topic::id`]. It grows as topics appear and never shrinks.
    fn topics(&self) -> Vec<Arc<Topic>>;

    /// What was received and lost so far.
    fn totals(&self) -> Totals;

    /// The clock that stamps arrivals.
    fn clock(&self) -> Clock;

    /// Ends the connection and waits for its threads. What is in the queue can still be had by
    /// [`next`](Source::next); then comes an error. Dropping the source does the same.
    fn stop(&mut self);
}

/// A message or an event.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Incoming {
    /// A message of a topic.
    Message(Message),
    /// Something that happened to the connection.
    Event {
        /// When it was noticed, in nanoseconds since 1970 on the source's clock.
        at_nanos: i64,
        /// What happened.
        event: Event,
    },
}

/// One message as its publisher encoded it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Message {
    /// Its topic.
    pub topic: Arc<Topic>,
    /// When it was published by the clock of the publisher, in nanoseconds since 1970, if the transport says so.
    pub publish_nanos: Option<i64>,
    /// When it arrived here, in nanoseconds since 1970 on the source's clock; never less than that of the message
    /// before.
    pub received_nanos: i64,
    /// The publisher's number of this message, if the transport numbers them (see [`Topic::numbered`]).
    pub sequence: Option<i64>,
    /// The encoded message. For `cdr` it begins with the four bytes of the encapsulation header, as in MCAP and
    /// rosbag2 files.
    pub data: Vec<u8>,
}

impl Message {
    /// The publisher's time if it is known, otherwise that of arrival, in nanoseconds since 1970.
    pub fn best_nanos(&self) -> i64 {
        self.publish_nanos.unwrap_or(self.received_nanos)
    }
}

/// Something that happened to a connection.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// The connection is made (for DDS: the domain is joined).
    Connected {
        /// To what, in words.
        to: String,
    },
    /// A wanted topic was seen for the first time and is now listened to.
    TopicAppeared {
        /// The topic, with its type and quality of service.
        topic: Arc<Topic>,
    },
    /// A wanted topic is not listened to.
    Refused {
        /// The topic's name.
        name: String,
        /// Why not, and what would help.
        reason: String,
    },
    /// The first message of a publisher arrived (numbered topics alone).
    PublisherJoined {
        /// The topic.
        topic: Arc<Topic>,
        /// How many messages this publisher had sent before that one. They are no loss when one attaches to a
        /// running system, but after [`Event::Disconnected`] they belong to the gap.
        sent_before: u64,
    },
    /// Messages are missing at this place in the stream.
    Lost {
        /// The topic, if it is known.
        topic: Option<Arc<Topic>>,
        /// How many, at least.
        count: u64,
        /// Where they were lost.
        cause: LossCause,
    },
    /// Nobody publishes the topic any more, or (without a topic) the whole connection broke. The source keeps trying.
    Disconnected {
        /// The topic, or `None` for the whole connection.
        topic: Option<Arc<Topic>>,
        /// What was noticed.
        reason: String,
    },
    /// What was disconnected is there again. In between anything may have been missed.
    Reconnected {
        /// The topic, or `None` for the whole connection.
        topic: Option<Arc<Topic>>,
        /// How long it was away, in nanoseconds.
        away_nanos: i64,
    },
    /// The other side says something about itself (a warning of a server).
    Notice {
        /// Its words.
        text: String,
    },
}

/// Where messages were lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LossCause {
    /// On the way, or because the publisher no longer kept them: their numbers are missing.
    Transport,
    /// In our queue, because the caller took messages more slowly than they came.
    Overflow,
    /// They arrived in a form that is not understood.
    Undecodable,
}

/// What was received and lost since the source was made.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Totals {
    /// Messages handed out or waiting in the queue.
    pub received: u64,
    /// Their bytes.
    pub received_bytes: u64,
    /// Messages lost on the way.
    pub lost_transport: u64,
    /// Messages lost because the queue was full.
    pub lost_overflow: u64,
    /// Messages that were not understood.
    pub lost_undecodable: u64,
}

impl Totals {
    /// All that was lost.
    pub fn lost(&self) -> u64 {
        self.lost_transport + self.lost_overflow + self.lost_undecodable
    }

    pub(crate) fn count_loss(&mut self, count: u64, cause: LossCause) {
        let counter = match cause {
            LossCause::Transport => &mut self.lost_transport,
            LossCause::Overflow => &mut self.lost_overflow,
            LossCause::Undecodable => &mut self.lost_undecodable,
        };
        *counter = counter.saturating_add(count);
    }
}
