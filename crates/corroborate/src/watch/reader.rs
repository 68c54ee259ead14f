//! A running system, read as if it were a recording: the same stream of
//! signals judges both.

use super::connection::info_of;
use super::hub::{Hub, SharedHub, locked};
use live::{Incoming, LiveError, Message, Source};
use recording::{
    Loss, RawMessage, ReadError, Reader, StoredFile, TopicId, TopicInfo, TypeDefinitions,
};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How long to wait for a message before looking at the clock, and whether to
/// end.
const WAIT: Duration = Duration::from_millis(50);

/// Where messages wait to be read; the reader and the command share it.
pub type SharedInbox = Arc<Mutex<Inbox>>;

/// Locks the inbox. A panic elsewhere leaves a message, not broken memory.
pub fn opened(inbox: &SharedInbox) -> MutexGuard<'_, Inbox> {
    inbox.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Takes messages from the running system one at a time, and hands everything
/// else that happens to the hub.
pub struct Inbox {
    source: Box<dyn Source>,
    hub: SharedHub,
    waiting: Option<Message>,
    /// The log time that was given out or judged last.
    last_nanos: i64,
}

impl Inbox {
    /// An empty inbox.
    pub fn new(source: Box<dyn Source>, hub: SharedHub) -> SharedInbox {
        Arc::new(Mutex::new(Self {
            source,
            hub,
            waiting: None,
            last_nanos: i64::MIN,
        }))
    }

    /// Waits a moment for a message. True if there is something to read: a
    /// message, or the end.
    pub fn wait(&mut self) -> bool {
        if self.waiting.is_some() || locked(&self.hub).must_end() {
            return true;
        }
        match self.source.next(WAIT) {
            Ok(Some(Incoming::Message(message))) => self.waiting = Some(message),
            Ok(Some(Incoming::Event { at_nanos, event })) => {
                locked(&self.hub).happened(at_nanos, event);
            }
            Ok(None) => locked(&self.hub).idle(),
            Err(LiveError::Ended(why)) => locked(&self.hub).end(why),
            Err(error) => Hub::broke(&self.hub, &error.to_string()),
        }
        self.waiting.is_some()
    }

    /// Whether everything that has arrived was read.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_none() && self.source.totals().received == locked(&self.hub).received()
    }

    /// Everything before `log_nanos` is judged: messages count as later.
    pub fn judged_until(&mut self, log_nanos: i64) {
        self.last_nanos = self.last_nanos.max(log_nanos);
    }

    /// The next message with its log time; `None` at the end.
    fn take(&mut self) -> Option<(Message, i64)> {
        while !self.wait() {}
        if locked(&self.hub).must_end() {
            return None;
        }
        let message = self.waiting.take()?;
        // No two messages of one time: each is an instant, and the recording
        // of the run is judged alike.
        let after = self.last_nanos.saturating_add(1);
        let log_nanos = message.received_nanos.max(after);
        self.last_nanos = log_nanos;
        locked(&self.hub).message(&message, log_nanos);
        Some((message, log_nanos))
    }
}

/// Reads messages until the hub says to end.
pub struct LiveReader {
    inbox: SharedInbox,
    hub: SharedHub,
    types: TypeDefinitions,
    topics: Vec<TopicInfo>,
    metadata: BTreeMap<String, String>,
    data: Vec<u8>,
}

impl LiveReader {
    /// Reads what comes into `inbox`.
    pub fn new(inbox: SharedInbox, hub: SharedHub, types: TypeDefinitions) -> Self {
        let mut reader = Self {
            inbox,
            hub,
            types,
            topics: Vec::new(),
            metadata: BTreeMap::new(),
            data: Vec::new(),
        };
        reader.take_topics();
        reader
    }

    fn take_topics(&mut self) {
        let topics = opened(&self.inbox).source.topics();
        for topic in &topics[self.topics.len()..] {
            self.topics.push(info_of(topic, &self.types));
        }
    }

    /// The next message, as its topic and its times; its bytes are in `data`.
    fn receive(&mut self) -> Option<(TopicId, i64, i64)> {
        let (message, log_nanos) = opened(&self.inbox).take()?;
        if message.topic.id as usize >= self.topics.len() {
            self.take_topics();
        }
        let publish_nanos = message.publish_nanos.unwrap_or(log_nanos);
        self.data = message.data;
        Some((TopicId(message.topic.id), log_nanos, publish_nanos))
    }
}

impl Reader for LiveReader {
    fn topics(&self) -> &[TopicInfo] {
        &self.topics
    }

    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        let Some((topic, log_nanos, publish_nanos)) = self.receive() else {
            return Ok(None);
        };
        Ok(Some(RawMessage {
            topic,
            log_nanos,
            publish_nanos,
            data: &self.data,
            offset: 0,
        }))
    }

    /// Losses are told by the hub, when they happen.
    fn losses(&self) -> &[Loss] {
        &[]
    }

    fn complete(&self) -> bool {
        locked(&self.hub).is_complete()
    }

    /// Which topics come was said to the connection; the stream passes over
    /// those that are only recorded.
    fn select(&mut self, _: &dyn Fn(&TopicInfo) -> bool) {}

    fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }

    fn in_time_order(&self) -> bool {
        true
    }

    /// A running system has no end.
    fn end_nanos(&self) -> Option<i64> {
        None
    }

    fn checked(&self) -> bool {
        false
    }

    fn storage(&self) -> Vec<StoredFile> {
        Vec::new()
    }
}
