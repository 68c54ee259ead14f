//! A test bench in a thread of its own, and the mixed stream of what it publishes and what comes from outside.
//!
//! The stream numbers its topics anew, those of the bench first; what it hands out is in the order in which it
//! happened, as that of a [`Bridge`] is.

use crate::queue::{Queue, QueueLimits};
use crate::stream::Outlet;
use crate::{
    Bridge, Event, Incoming, LiveError, LiveStream, Message, Outgoing, PublicationId, Punctuality,
    Topic,
};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

/// A [`Bridge`] whose both sides go into one [`LiveStream`].
pub struct BridgeFeed {
    bridge: Bridge,
    taker: Taker,
}

/// Puts what the bridge hands over into the stream.
struct Taker {
    outlet: Outlet,
    /// The topics of the bench by its own numbers.
    bench: Vec<Arc<Topic>>,
    /// The topics from outside by the numbers of their source.
    outside: BTreeMap<u32, Arc<Topic>>,
}

impl LiveStream {
    /// Runs a test bench in a thread until `bench` returns; the stream then ends with the text that it gives
    /// ([`LiveError::Ended`]), or with its error. The topics of the bench are known from the start.
    ///
    /// ```no_run
    /// use live::{Bridge, Incoming, LiveStream, Outgoing, Source, TopicFilter, dds};
    /// use std::time::Duration;
    ///
    /// let options = dds::DdsOptions::default();
    /// let outside = dds::connect(&options, TopicFilter::new(&["/gripper/*"], &[]))?;
    /// let bridge = Bridge::new(Box::new(outside), Box::new(dds::DdsPublisher::new(&options)?));
    /// let speed = Outgoing::ros2("/robot/speed", "std_msgs/msg/Float64");
    /// let mut stream = LiveStream::of_bench(bridge, &[speed], |feed, ids| {
    ///     feed.start(0, 1_000_000);
    ///     for step in 1..=1000 {
    ///         feed.advance(step * 1_000_000)?;
    ///         feed.publish(ids[0], vec![0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0])?;
    ///     }
    ///     Ok("a second is over".into())
    /// })?;
    /// while let Ok(incoming) = stream.next(Duration::from_secs(1)) {
    ///     println!("{incoming:?}");
    /// }
    /// # Ok::<(), live::LiveError>(())
    /// ```
    ///
    /// # Errors
    /// When a topic cannot be published or no thread be started.
    pub fn of_bench(
        mut bridge: Bridge,
        topics: &[Outgoing],
        bench: impl FnOnce(&mut BridgeFeed, &[PublicationId]) -> Result<String, LiveError>
        + Send
        + 'static,
    ) -> Result<Self, LiveError> {
        let queue = Arc::new(Queue::new(QueueLimits::default(), bridge.clock()));
        let (mut ids, mut known) = (Vec::new(), Vec::new());
        for outgoing in topics {
            let publication = bridge.advertise(outgoing)?;
            ids.push(publication);
            if let Some(topic) = bridge.topic(publication) {
                known.push(queue.add_topic(|id| renumbered(topic, id)));
            }
        }
        for topic in &known {
            let topic = topic.clone();
            queue.push_event(Event::TopicAppeared { topic });
        }
        Self::start("live-bench", queue.clone(), move |outlet| {
            let taker = Taker {
                outlet,
                bench: known,
                outside: BTreeMap::new(),
            };
            let mut feed = BridgeFeed { bridge, taker };
            let ended = bench(&mut feed, &ids);
            // Before the feed is dropped, which ends the stream in its own way.
            queue.end(ended.map_or_else(|error| error, LiveError::Ended));
        })
    }
}

impl BridgeFeed {
    /// Whether the stream's owner wants the bench to end.
    pub fn stopped(&self) -> bool {
        self.taker.outlet.stopped()
    }

    /// Hands on what comes from outside for up to `timeout`, before the bench's time begins.
    ///
    /// # Errors
    /// When the source has ended.
    pub fn listen(&mut self, timeout: Duration) -> Result<(), LiveError> {
        let taker = &mut self.taker;
        self.bridge
            .listen(timeout, &mut |incoming| taker.take(incoming))
    }

    /// As [`Bridge::start`].
    pub fn start(&mut self, bench_nanos: i64, tolerance_nanos: i64) {
        self.bridge.start(bench_nanos, tolerance_nanos);
    }

    /// As [`Bridge::advance`].
    ///
    /// # Errors
    /// When the source has ended.
    pub fn advance(&mut self, bench_nanos: i64) -> Result<i64, LiveError> {
        let taker = &mut self.taker;
        self.bridge
            .advance(bench_nanos, &mut |incoming| taker.take(incoming))
    }

    /// As [`Bridge::publish`].
    ///
    /// # Errors
    /// As [`Publisher::publish`](crate::Publisher::publish).
    pub fn publish(&mut self, publication: PublicationId, data: Vec<u8>) -> Result<(), LiveError> {
        let taker = &mut self.taker;
        self.bridge
            .publish(publication, data, &mut |incoming| taker.take(incoming))
    }

    /// How well the bench kept up with the wall clock.
    pub fn punctuality(&self) -> Punctuality {
        self.bridge.punctuality()
    }
}

impl Taker {
    fn take(&mut self, incoming: Incoming) {
        match incoming {
            Incoming::Message(message) => {
                let topic = self.known(&message.topic);
                let message = Message { topic, ..message };
                self.outlet.queue.push_message(message);
            }
            Incoming::Event { event, .. } => {
                let event = self.renumbered_event(event);
                self.outlet.queue.push_event(event);
            }
        }
    }

    /// The topic under its number in the mixed stream.
    fn known(&mut self, topic: &Arc<Topic>) -> Arc<Topic> {
        if topic.origin == crate::Origin::TestBench
            && let Some(known) = self.bench.get(topic.id as usize)
        {
            return known.clone();
        }
        let queue = &self.outlet.queue;
        let add = || queue.add_topic(|id| renumbered(topic, id));
        self.outside.entry(topic.id).or_insert_with(add).clone()
    }

    fn renumbered_event(&mut self, event: Event) -> Event {
        let mut maybe = |topic: Option<Arc<Topic>>| topic.map(|topic| self.known(&topic));
        match event {
            Event::Lost {
                topic,
                count,
                cause,
            } => Event::Lost {
                topic: maybe(topic),
                count,
                cause,
            },
            Event::Disconnected { topic, reason } => Event::Disconnected {
                topic: maybe(topic),
                reason,
            },
            Event::Reconnected { topic, away_nanos } => Event::Reconnected {
                topic: maybe(topic),
                away_nanos,
            },
            Event::TopicAppeared { topic } => Event::TopicAppeared {
                topic: self.known(&topic),
            },
            Event::PublisherJoined { topic, sent_before } => Event::PublisherJoined {
                topic: self.known(&topic),
                sent_before,
            },
            same @ (Event::Connected { .. } | Event::Refused { .. } | Event::Notice { .. }) => same,
        }
    }
}

fn renumbered(topic: &Topic, id: u32) -> Topic {
    Topic {
        id,
        ..topic.clone()
    }
}

#[cfg(test)]
mod tests;
