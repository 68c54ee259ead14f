//! The bounded queue between the thread that listens and the caller.
//!
//! Order is kept between messages and events. When the queue is full, the newest messages are left out and counted;
//! the count enters the stream as [`Event::Lost`] before the next message that fits, so it stands where the messages
//! are missing. Events are small and few; they have room of their own and are themselves replaced by a count beyond it.

use crate::clock::Clock;
use crate::{Event, Incoming, LiveError, LossCause, Message, Topic, Totals};
use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How much may wait in the queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct QueueLimits {
    /// Messages, at least 1.
    pub messages: usize,
    /// Bytes of messages; one message is always taken, however large.
    pub bytes: usize,
}

impl Default for QueueLimits {
    /// 65,536 messages (a minute at 1 kHz) and 256 MiB.
    fn default() -> Self {
        Self {
            messages: 65_536,
            bytes: 256 << 20,
        }
    }
}

/// How many events may wait.
const EVENTS_AT_MOST: usize = 10_000;

/// Both ends of the queue share it.
pub(crate) struct Queue {
    state: Mutex<State>,
    ready: Condvar,
    limits: QueueLimits,
    /// The clock of the source.
    pub(crate) clock: Clock,
}

#[derive(Default)]
struct State {
    items: VecDeque<Incoming>,
    messages: usize,
    bytes: usize,
    /// Messages left out since the last one that fitted, by topic and in the order of the topics.
    left_out: BTreeMap<u32, (Arc<Topic>, u64)>,
    events_left_out: u64,
    last_received_nanos: i64,
    topics: Vec<Arc<Topic>>,
    totals: Totals,
    ended: Option<LiveError>,
}

impl Queue {
    pub(crate) fn new(limits: QueueLimits, clock: Clock) -> Self {
        Self {
            state: Mutex::default(),
            ready: Condvar::new(),
            limits,
            clock,
        }
    }

    /// A panic elsewhere while the lock was held leaves counters, not broken memory: go on with them.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a topic; `make` gets its id.
    pub(crate) fn add_topic(&self, make: impl FnOnce(u32) -> Topic) -> Arc<Topic> {
        let mut state = self.lock();
        let id = u32::try_from(state.topics.len()).unwrap_or(u32::MAX);
        let topic = Arc::new(make(id));
        state.topics.push(topic.clone());
        topic
    }

    pub(crate) fn topics(&self) -> Vec<Arc<Topic>> {
        self.lock().topics.clone()
    }

    pub(crate) fn totals(&self) -> Totals {
        self.lock().totals
    }

    /// Adds a message, or counts it as lost if there is no room. Its time of arrival is raised to that of the message
    /// before if it is less.
    pub(crate) fn push_message(&self, mut message: Message) {
        let mut state = self.lock();
        let no_room = state.messages >= self.limits.messages.max(1)
            || state.bytes + message.data.len() > self.limits.bytes;
        if state.messages > 0 && no_room {
            state.totals.count_loss(1, LossCause::Overflow);
            let counted = state.left_out.entry(message.topic.id);
            counted.or_insert_with(|| (message.topic.clone(), 0)).1 += 1;
            return;
        }
        state.tell_left_out(self.clock.now_nanos());
        message.received_nanos = message.received_nanos.max(state.last_received_nanos);
        state.last_received_nanos = message.received_nanos;
        state.messages += 1;
        state.bytes += message.data.len();
        state.totals.received += 1;
        state.totals.received_bytes += message.data.len() as u64;
        state.items.push_back(Incoming::Message(message));
        self.ready.notify_one();
    }

    /// Adds an event.
    pub(crate) fn push_event(&self, event: Event) {
        let mut state = self.lock();
        if let Event::Lost { count, cause, .. } = &event {
            state.totals.count_loss(*count, *cause);
        }
        if state.items.len() - state.messages >= EVENTS_AT_MOST {
            state.events_left_out += 1;
            return;
        }
        let at_nanos = self.clock.now_nanos();
        state.tell_left_out(at_nanos);
        state.items.push_back(Incoming::Event { at_nanos, event });
        self.ready.notify_one();
    }

    /// Ends the stream; the first reason counts.
    pub(crate) fn end(&self, reason: LiveError) {
        self.lock().ended.get_or_insert(reason);
        self.ready.notify_all();
    }

    /// The next item, waiting up to `timeout`.
    pub(crate) fn pop(&self, timeout: Duration) -> Result<Option<Incoming>, LiveError> {
        let (mut state, _) = self
            .ready
            .wait_timeout_while(self.lock(), timeout, |state| {
                state.items.is_empty() && state.left_out.is_empty() && state.ended.is_none()
            })
            .unwrap_or_else(PoisonError::into_inner);
        if state.items.is_empty() {
            state.tell_left_out(self.clock.now_nanos());
        }
        let Some(item) = state.items.pop_front() else {
            return state.ended.clone().map_or(Ok(None), Err);
        };
        if let Incoming::Message(message) = &item {
            state.messages -= 1;
            state.bytes -= message.data.len();
        }
        Ok(Some(item))
    }
}

impl State {
    /// Puts what was left out into the stream as events.
    fn tell_left_out(&mut self, at_nanos: i64) {
        for (topic, count) in std::mem::take(&mut self.left_out).into_values() {
            let event = Event::Lost {
                topic: Some(topic),
                count,
                cause: LossCause::Overflow,
            };
            self.items.push_back(Incoming::Event { at_nanos, event });
        }
        if self.events_left_out > 0 {
            let count = std::mem::take(&mut self.events_left_out);
            let noun = if count == 1 { "event" } else { "events" };
            let text = format!("{count} {noun} dropped: not read in time");
            let event = Event::Notice { text };
            self.items.push_back(Incoming::Event { at_nanos, event });
        }
    }
}

#[cfg(test)]
mod tests;
