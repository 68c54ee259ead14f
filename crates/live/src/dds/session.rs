//! One participation in a domain: who is there, and readers for their topics.

use super::quality;
use super::raw::RawAdapter;
use super::{DdsOptions, join, names};
use crate::{LiveError, Qos, TopicFilter};
use rustdds::dds::CreateError;
use rustdds::discovery::DiscoveredWriterData;
use rustdds::no_key::SimpleDataReader;
use rustdds::{
    DomainParticipant, DomainParticipantStatusEvent, GUID, LostReason, QosPolicyBuilder,
    StatusEvented, Subscriber, TopicKind, policy,
};
use std::collections::BTreeMap;

/// A reader of raw bytes.
pub(super) type Reader = SimpleDataReader<Vec<u8>, RawAdapter>;

/// What a reader is made for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Wanted {
    pub(super) dds_name: String,
    pub(super) dds_type: String,
    pub(super) type_name: String,
    pub(super) qos: Qos,
    pub(super) exclusive: bool,
}

/// A writer of a wanted topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Writer {
    pub(super) guid: GUID,
    pub(super) dds_type: String,
    pub(super) qos: Qos,
    pub(super) exclusive: bool,
    pub(super) type_hash: Option<String>,
}

/// A participant and its subscriber.
pub(super) struct Session {
    subscriber: Subscriber,
    participant: DomainParticipant,
}

impl Session {
    /// Joins the domain.
    pub(super) fn join(options: &DdsOptions) -> Result<Self, LiveError> {
        let participant = join(options)?;
        let subscriber = participant
            .create_subscriber(&QosPolicyBuilder::new().build())
            .map_err(|error| LiveError::Transport(error.to_string()))?;
        Ok(Self {
            subscriber,
            participant,
        })
    }

    /// Makes a reader.
    pub(super) fn reader(&self, wanted: &Wanted) -> Result<Reader, CreateError> {
        let samples = quality::samples_kept(&wanted.type_name);
        let policies = quality::policies(wanted.qos, wanted.exclusive, samples);
        let topic = self.participant.create_topic(
            wanted.dds_name.clone(),
            wanted.dds_type.clone(),
            &QosPolicyBuilder::new().build(),
            TopicKind::NoKey,
        )?;
        self.subscriber
            .create_simple_datareader_no_key(&topic, Some(policies))
    }

    /// The writers of each wanted topic, those of a topic in the order of their identities: the order of their
    /// discovery is not known, and this one is at least the same each time.
    pub(super) fn writers(&self, filter: &TopicFilter) -> BTreeMap<String, Vec<Writer>> {
        let mut found: BTreeMap<String, Vec<Writer>> = BTreeMap::new();
        for data in self.participant.discovered_writers() {
            let dds_name = &data.publication_topic_data.topic_name;
            let shown = names::shown_topic(dds_name);
            if shown.is_some_and(|shown| filter.wants(&shown)) {
                found
                    .entry(dds_name.clone())
                    .or_default()
                    .push(writer(&data));
            }
        }
        for writers in found.values_mut() {
            writers.sort_by_key(|writer| writer.guid);
        }
        found
    }

    /// Whether, since the last call, another participant fell silent without saying goodbye.
    pub(super) fn somebody_fell_silent(&self) -> bool {
        let listener = self.participant.status_listener();
        let mut fell_silent = false;
        while let Some(event) = listener.try_recv_status() {
            fell_silent |= matches!(
                event,
                DomainParticipantStatusEvent::ParticipantLost {
                    reason: LostReason::Timeout { .. },
                    ..
                }
            );
        }
        fell_silent
    }
}

/// What matters of a writer's announcement.
fn writer(data: &DiscoveredWriterData) -> Writer {
    let topic = &data.publication_topic_data;
    Writer {
        guid: topic.key,
        dds_type: topic.type_name.clone(),
        qos: quality::offered(topic.reliability, topic.durability),
        exclusive: matches!(topic.ownership, Some(policy::Ownership::Exclusive { .. })),
        type_hash: names::type_hash(&data.user_data),
    }
}
