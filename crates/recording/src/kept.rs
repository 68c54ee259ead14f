//! For tests: a recording in memory, read without any of the readers that are tested themselves.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::reader::{Encoding, Loss, RawMessage, ReadError, Reader, TopicId, TopicInfo};
use crate::schema::{Dialect, Schema, parse_msg};
use crate::storage::StoredFile;

/// A recording in memory, in the order in which it was written.
pub(crate) struct Kept {
    pub(crate) topics: Vec<TopicInfo>,
    pub(crate) messages: Vec<(TopicId, i64, Vec<u8>)>,
    pub(crate) next: usize,
    pub(crate) metadata: BTreeMap<String, String>,
    /// How many topics are known before the first message.
    pub(crate) known: usize,
}

impl Kept {
    pub(crate) fn new(bytes: &[u8]) -> Box<Self> {
        let mut kept = Kept {
            topics: Vec::new(),
            messages: Vec::new(),
            next: 0,
            metadata: BTreeMap::new(),
            known: usize::MAX,
        };
        for message in mcap::MessageStream::new(bytes).unwrap() {
            let message = message.unwrap();
            let name = &message.channel.topic;
            let found = kept.topics.iter().position(|info| info.name == *name);
            let index = found.unwrap_or_else(|| {
                let schema = message.channel.schema.as_ref().unwrap();
                let text = String::from_utf8_lossy(&schema.data);
                let root = parse_msg(&schema.name, &text, Dialect::Ros2).unwrap();
                kept.topics.push(TopicInfo {
                    id: TopicId(kept.topics.len() as u32),
                    name: name.clone(),
                    type_name: schema.name.clone(),
                    encoding: Encoding::Cdr,
                    schema: Arc::new(Schema::Struct(root)),
                    message_count: None,
                });
                kept.topics.len() - 1
            });
            kept.messages.push((
                TopicId(index as u32),
                message.log_time as i64,
                message.data.to_vec(),
            ));
        }
        Box::new(kept)
    }
}

impl Reader for Kept {
    fn topics(&self) -> &[TopicInfo] {
        let seen = self.messages[..self.next]
            .iter()
            .map(|(topic, ..)| topic.index() + 1);
        let seen = seen
            .max()
            .unwrap_or(0)
            .max(self.known.min(self.topics.len()));
        &self.topics[..seen]
    }

    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        let Some((topic, log_nanos, data)) = self.messages.get(self.next) else {
            return Ok(None);
        };
        self.next += 1;
        Ok(Some(RawMessage {
            topic: *topic,
            log_nanos: *log_nanos,
            publish_nanos: *log_nanos,
            data,
            offset: self.next as u64,
        }))
    }

    fn losses(&self) -> &[Loss] {
        &[]
    }

    fn complete(&self) -> bool {
        true
    }

    fn select(&mut self, _: &dyn Fn(&TopicInfo) -> bool) {}

    fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }

    fn in_time_order(&self) -> bool {
        false
    }

    /// Nothing says until when whoever recorded was at work.
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
