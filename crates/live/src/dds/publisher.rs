//! Publishing into a DDS domain.

use super::raw::{RawAdapter, without_header};
use super::{DdsOptions, join, names, quality, stamp};
use crate::clock::instant;
use crate::{Durability, LiveError, Outgoing, PublicationId, Publisher, Qos, Reliability};
use rustdds::no_key::DataWriter;
use rustdds::{DomainParticipant, QosPolicyBuilder, TopicKind};
use std::time::Duration;

/// How many messages of a topic are kept for readers that missed them.
const SAMPLES_KEPT: i32 = 1024;

/// A participant that publishes. Messages are sent reliably to readers that ask for it, with the publisher's stamps.
pub struct DdsPublisher {
    // Dropped in this order: a writer can say goodbye only while its participant lives.
    writers: Vec<(String, DataWriter<Vec<u8>, RawAdapter>)>,
    publisher: rustdds::Publisher,
    participant: DomainParticipant,
}

impl DdsPublisher {
    /// Joins the domain in order to publish. The options' queue is not used.
    ///
    /// # Errors
    /// As [`connect`](super::connect).
    pub fn new(options: &DdsOptions) -> Result<Self, LiveError> {
        let participant = join(options)?;
        let publisher = participant
            .create_publisher(&QosPolicyBuilder::new().build())
            .map_err(|error| LiveError::Transport(error.to_string()))?;
        Ok(Self {
            publisher,
            participant,
            writers: Vec::new(),
        })
    }

    /// How many readers of other participants there are for the topic called `name`.
    pub fn readers(&self, name: &str) -> usize {
        let dds_name = names::dds_topic(name);
        let readers = self.participant.discovered_readers();
        readers
            .iter()
            .filter(|reader| *reader.subscription_topic_data.topic_name() == dds_name)
            .count()
    }

    /// Waits until every reliable reader that is known has acknowledged all that was published, so that it has it
    /// before anything that is published later, on whatever topic. Readers of best effort acknowledge nothing and are
    /// not waited for.
    ///
    /// # Errors
    /// With the name of the first topic that is not acknowledged within `longest`.
    pub fn wait_acknowledged(&self, longest: Duration) -> Result<(), LiveError> {
        let began = instant();
        for (name, writer) in &self.writers {
            let left = longest.saturating_sub(began.elapsed());
            let failed = |reason: String| LiveError::Send {
                topic: name.clone(),
                reason,
            };
            match writer.wait_for_acknowledgments(left) {
                Ok(true) => {}
                Ok(false) => {
                    return Err(failed(format!(
                        "a reader has not acknowledged it within {} s",
                        longest.as_secs_f64()
                    )));
                }
                Err(error) => return Err(failed(error.to_string())),
            }
        }
        Ok(())
    }
}

impl Publisher for DdsPublisher {
    fn advertise(&mut self, topic: &Outgoing) -> Result<PublicationId, LiveError> {
        if topic.encoding != "cdr" {
            return Err(LiveError::Unsupported(format!(
                "{} cannot be published over DDS as {}: DDS carries cdr",
                topic.name, topic.encoding
            )));
        }
        let policies = quality::policies(offered(topic.latched), false, SAMPLES_KEPT);
        let dds_type = names::dds_type(&topic.type_name);
        let writer = self
            .participant
            .create_topic(
                names::dds_topic(&topic.name),
                dds_type,
                &policies,
                TopicKind::NoKey,
            )
            .and_then(|made| {
                self.publisher
                    .create_datawriter_no_key(&made, Some(policies))
            })
            .map_err(|error| LiveError::Transport(error.to_string()))?;
        self.writers.push((topic.name.clone(), writer));
        Ok(PublicationId(self.writers.len() - 1))
    }

    fn publish(
        &mut self,
        publication: PublicationId,
        publish_nanos: i64,
        data: &[u8],
    ) -> Result<(), LiveError> {
        let Some((name, writer)) = self.writers.get(publication.0) else {
            return Err(LiveError::Option(
                "this publication is of another publisher".to_owned(),
            ));
        };
        let message = without_header(data).ok_or_else(|| {
            LiveError::Encoding(format!(
                "a message on {name} does not begin with the header 00 01 of little-endian CDR"
            ))
        })?;
        writer
            .write(message.to_vec(), stamp::stamp(publish_nanos))
            .map_err(|error| LiveError::Send {
                topic: name.clone(),
                reason: error.to_string(),
            })
    }
}

fn offered(latched: bool) -> Qos {
    Qos {
        reliability: Reliability::Reliable,
        durability: if latched {
            Durability::TransientLocal
        } else {
            Durability::Volatile
        },
    }
}
