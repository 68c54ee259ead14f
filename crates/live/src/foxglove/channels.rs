//! Which channels there are, and what they are to us.
//!
//! A topic keeps its identity when the server takes a channel away and gives it back under another number, also over
//! a new connection, as long as name, type, encoding and definition are the same.

use super::protocol::{Channel, Subscription};
use crate::queue::Queue;
use crate::{Event, Origin, Topic, TopicFilter};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The channels of one server, over all connections to it.
pub(super) struct Channels {
    filter: TopicFilter,
    topics: Vec<Arc<Topic>>,
    /// Topics that were there and are not now, with the time since when on the source's clock.
    away_since_nanos: BTreeMap<u32, i64>,
    /// Of the present connection: subscriptions by their number, which is that of the channel.
    subscribed: BTreeMap<u32, Arc<Topic>>,
    refused: BTreeSet<String>,
}

impl Channels {
    pub(super) fn new(filter: TopicFilter) -> Self {
        Self {
            filter,
            topics: Vec::new(),
            away_since_nanos: BTreeMap::new(),
            subscribed: BTreeMap::new(),
            refused: BTreeSet::new(),
        }
    }

    /// The topic of a subscription.
    pub(super) fn topic(&self, subscription: u32) -> Option<&Arc<Topic>> {
        self.subscribed.get(&subscription)
    }

    /// The connection is lost: no channel is subscribed to, all topics are away.
    pub(super) fn forget_connection(&mut self, queue: &Queue) {
        let now = queue.clock.now_nanos();
        for topic in std::mem::take(&mut self.subscribed).into_values() {
            self.away_since_nanos.entry(topic.id).or_insert(now);
        }
    }

    /// Takes note of new channels; gives the subscriptions to ask for.
    pub(super) fn advertised(&mut self, channels: &[Channel], queue: &Queue) -> Vec<Subscription> {
        let mut wishes = Vec::new();
        for channel in channels {
            if self.filter.wants(&channel.topic) {
                let topic = self.topic_of(channel, queue);
                self.subscribed.insert(channel.id, topic);
                wishes.push(Subscription {
                    id: channel.id,
                    channel_id: channel.id,
                });
            }
        }
        wishes
    }

    /// The topic that is told by a channel, new or known.
    fn topic_of(&mut self, channel: &Channel, queue: &Queue) -> Arc<Topic> {
        let schema = channel.schema_text();
        if schema.is_none()
            && !channel.schema.is_empty()
            && self.refused.insert(channel.topic.clone())
        {
            let text = format!(
                "the definition of {}'s type {} is not in the form it claims; it is left out",
                channel.topic, channel.schema_name
            );
            queue.push_event(Event::Notice { text });
        }
        let known = self.topics.iter().find(|topic| {
            topic.name == channel.topic
                && topic.type_name == channel.schema_name
                && topic.encoding == channel.encoding
                && topic.schema == schema
        });
        if let Some(topic) = known {
            if let Some(since) = self.away_since_nanos.remove(&topic.id) {
                queue.push_event(Event::Reconnected {
                    topic: Some(topic.clone()),
                    away_nanos: queue.clock.now_nanos() - since,
                });
            }
            return topic.clone();
        }
        let topic = queue.add_topic(|id| Topic {
            id,
            name: channel.topic.clone(),
            type_name: channel.schema_name.clone(),
            encoding: channel.encoding.clone(),
            schema,
            qos: None,
            type_hash: None,
            origin: Origin::Outside,
            numbered: false,
        });
        self.topics.push(topic.clone());
        queue.push_event(Event::TopicAppeared {
            topic: topic.clone(),
        });
        topic
    }

    /// Takes note of channels that are no more.
    pub(super) fn unadvertised(&mut self, channel_ids: &[u32], queue: &Queue) {
        for id in channel_ids {
            let Some(topic) = self.subscribed.remove(id) else {
                continue;
            };
            // Another channel may carry the same topic on.
            if self.subscribed.values().any(|other| other.id == topic.id) {
                continue;
            }
            self.away_since_nanos
                .insert(topic.id, queue.clock.now_nanos());
            queue.push_event(Event::Disconnected {
                topic: Some(topic),
                reason: "the server no longer offers it".to_owned(),
            });
        }
    }
}
