//! A running system, read as if it were a recording: the same stream of
//! signals judges both.

use super::connection::info_of;
use super::hub::{Hub, SharedHub, locked};
use live::{Incoming, Source};
use recording::{Loss, RawMessage, ReadError, Reader, TopicId, TopicInfo, TypeDefinitions};
use std::collections::BTreeMap;
use std::time::Duration;

/// How long to wait for a message before looking whether to end.
const WAIT: Duration = Duration::from_millis(50);

/// Reads messages until the hub says to end, and hands everything that happens
/// on the way to it.
pub struct LiveReader {
    source: Box<dyn Source>,
    hub: SharedHub,
    types: TypeDefinitions,
    topics: Vec<TopicInfo>,
    metadata: BTreeMap<String, String>,
    last_nanos: i64,
    data: Vec<u8>,
}

impl LiveReader {
    /// Reads `source`.
    pub fn new(source: Box<dyn Source>, hub: SharedHub, types: TypeDefinitions) -> Self {
        let mut reader = Self {
            source,
            hub,
            types,
            topics: Vec::new(),
            metadata: BTreeMap::new(),
            last_nanos: i64::MIN,
            data: Vec::new(),
        };
        reader.take_topics();
        reader
    }

    fn take_topics(&mut self) {
        let known = self.topics.len();
        for topic in &self.source.topics()[known..] {
            self.topics.push(info_of(topic, &self.types));
        }
    }

    /// The next message, as its topic and its times; its bytes are in `data`.
    fn receive(&mut self) -> Option<(TopicId, i64, i64)> {
        loop {
            if locked(&self.hub).must_end() {
                return None;
            }
            match self.source.next(WAIT) {
                Ok(Some(Incoming::Message(message))) => {
                    if message.topic.id as usize >= self.topics.len() {
                        self.take_topics();
                    }
                    // No two messages of one time: each is an instant, and the
                    // recording of the run is judged alike.
                    let log_nanos = message
                        .received_nanos
                        .max(self.last_nanos.saturating_add(1));
                    self.last_nanos = log_nanos;
                    locked(&self.hub).message(&message, log_nanos);
                    let publish_nanos = message.publish_nanos.unwrap_or(log_nanos);
                    self.data = message.data;
                    return Some((TopicId(message.topic.id), log_nanos, publish_nanos));
                }
                Ok(Some(Incoming::Event { at_nanos, event })) => {
                    locked(&self.hub).happened(at_nanos, event);
                }
                Ok(None) => locked(&self.hub).idle(),
                Err(error) => Hub::broke(&self.hub, &error.to_string()),
            }
        }
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
}
