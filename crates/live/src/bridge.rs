//! A part of the robot in the loop with a simulated rest: some topics from outside, some from the test bench.
//!
//! The bench publishes its topics at the pace of the wall clock; what comes from outside meanwhile and what the bench
//! published itself go into one stream, whose times never go back. So a monitor sees the whole system, and the same
//! stream can be recorded.

use crate::clock::{Clock, duration};
use crate::pace::{Pacer, Punctuality};
use crate::{
    Incoming, LiveError, Message, Origin, Outgoing, PublicationId, Publisher, Source, Topic,
};
use std::sync::Arc;
use std::time::Duration;

/// How long to wait at once for something from outside; a wait for the next step is cut into such pieces.
const WAIT_AT_MOST: Duration = Duration::from_millis(100);

/// Joins a source and a publisher.
///
/// Topics that the bench publishes must not come back from outside: leave them out of the source's
/// [`TopicFilter`](crate::TopicFilter), or they are seen twice.
///
/// ```no_run
/// use live::{Bridge, Outgoing, Publisher, TopicFilter, dds};
///
/// let options = dds::DdsOptions::default();
/// let source = dds::connect(&options, TopicFilter::new(&["/gripper/*"], &["/robot/*"]))?;
/// let publisher = dds::DdsPublisher::new(&options)?;
/// let mut bridge = Bridge::new(Box::new(source), Box::new(publisher));
/// let state = bridge.advertise(&Outgoing::ros2("/robot/speed", "std_msgs/msg/Float64"))?;
/// bridge.start(0, 2_000_000);
/// for step in 1..=1000 {
///     // To the next millisecond; what arrives is judged, recorded and given to the simulation.
///     bridge.advance(step * 1_000_000, &mut |incoming| println!("{incoming:?}"))?;
///     let mut data = vec![0, 1, 0, 0];
///     data.extend_from_slice(&0.5_f64.to_le_bytes());
///     bridge.publish(state, data, &mut |incoming| println!("{incoming:?}"))?;
/// }
/// println!("{:?}", bridge.punctuality());
/// # Ok::<(), live::LiveError>(())
/// ```
pub struct Bridge {
    source: Box<dyn Source>,
    publisher: Box<dyn Publisher>,
    clock: Clock,
    pacer: Pacer,
    published: Vec<(PublicationId, Arc<Topic>)>,
    /// Time of the newest message of the stream, of either side.
    last_nanos: i64,
    /// When the newest message from outside arrived.
    arrived_nanos: i64,
    sent: i64,
}

impl Bridge {
    /// Joins `source` and `publisher`. Pacing begins with [`start`](Self::start).
    pub fn new(source: Box<dyn Source>, publisher: Box<dyn Publisher>) -> Self {
        let clock = source.clock();
        Self {
            source,
            publisher,
            clock,
            pacer: Pacer::start(clock, 0, 0),
            published: Vec::new(),
            last_nanos: i64::MIN,
            arrived_nanos: i64::MIN,
            sent: 0,
        }
    }

    /// Makes a topic of the bench known. Its [`Topic::id`] counts the bench's topics by themselves.
    ///
    /// # Errors
    /// As [`Publisher::advertise`].
    pub fn advertise(&mut self, topic: &Outgoing) -> Result<PublicationId, LiveError> {
        let publication = self.publisher.advertise(topic)?;
        let id = u32::try_from(self.published.len()).unwrap_or(u32::MAX);
        let described = Topic {
            id,
            name: topic.name.clone(),
            type_name: topic.type_name.clone(),
            encoding: topic.encoding.clone(),
            schema: topic.schema.clone(),
            qos: None,
            type_hash: None,
            origin: Origin::TestBench,
            numbered: true,
        };
        self.published.push((publication, Arc::new(described)));
        Ok(publication)
    }

    /// The bench's time is `bench_nanos` now and goes with the wall clock from here; steps that are more than
    /// `tolerance_nanos` late are counted.
    pub fn start(&mut self, bench_nanos: i64, tolerance_nanos: i64) {
        self.pacer = Pacer::start(self.clock, bench_nanos, tolerance_nanos);
    }

    /// The clock of the source, which stamps both sides.
    pub(crate) fn clock(&self) -> Clock {
        self.clock
    }

    /// What is known of a topic of the bench.
    pub(crate) fn topic(&self, publication: PublicationId) -> Option<&Arc<Topic>> {
        let mut published = self.published.iter();
        published
            .find(|(id, _)| *id == publication)
            .map(|(_, topic)| topic)
    }

    /// Hands what comes from outside for up to `timeout` to `take`, and what waits already.
    ///
    /// # Errors
    /// When the source has ended.
    pub fn listen(
        &mut self,
        timeout: Duration,
        take: &mut dyn FnMut(Incoming),
    ) -> Result<(), LiveError> {
        let mut next = self.source.next(timeout)?;
        while let Some(incoming) = next {
            self.hand_over(incoming, take);
            next = self.source.next(Duration::ZERO)?;
        }
        Ok(())
    }

    /// Waits until bench time `bench_nanos` is due and hands what comes from outside meanwhile to `take`. What waits
    /// already is handed over even if the bench is late. Gives how late the step is, in nanoseconds.
    ///
    /// # Errors
    /// When the source has ended.
    pub fn advance(
        &mut self,
        bench_nanos: i64,
        take: &mut dyn FnMut(Incoming),
    ) -> Result<i64, LiveError> {
        loop {
            let remaining = self.pacer.remaining_nanos(bench_nanos);
            match self.source.next(duration(remaining).min(WAIT_AT_MOST))? {
                Some(incoming) => {
                    self.hand_over(incoming, take);
                    // A flood from outside must not hold the bench up.
                    if remaining <= 0 && self.caught_up_to(bench_nanos) {
                        break;
                    }
                }
                None if remaining <= 0 => break,
                None => {}
            }
        }
        Ok(self.pacer.note_step(bench_nanos))
    }

    /// Whether all that arrived before bench time `bench_nanos` was due has been handed over.
    fn caught_up_to(&self, bench_nanos: i64) -> bool {
        self.arrived_nanos >= self.pacer.due_nanos(bench_nanos)
    }

    /// Takes something from outside into the stream. The source stamps arrivals in a thread of its own, so the bench may
    /// have published between a stamp and now: such an arrival gets the time of what it stands behind.
    fn hand_over(&mut self, mut incoming: Incoming, take: &mut dyn FnMut(Incoming)) {
        let nanos = match &mut incoming {
            Incoming::Message(message) => &mut message.received_nanos,
            Incoming::Event { at_nanos, .. } => at_nanos,
        };
        self.arrived_nanos = self.arrived_nanos.max(*nanos);
        self.last_nanos = self.last_nanos.max(*nanos);
        *nanos = self.last_nanos;
        take(incoming);
    }

    /// Publishes a message of the bench, stamped with the present time, and hands it to `take` too.
    ///
    /// # Errors
    /// As [`Publisher::publish`]; then it is not handed over.
    pub fn publish(
        &mut self,
        publication: PublicationId,
        data: Vec<u8>,
        take: &mut dyn FnMut(Incoming),
    ) -> Result<(), LiveError> {
        let topic = self
            .topic(publication)
            .cloned()
            .ok_or_else(|| LiveError::Option("this publication is of another bridge".to_owned()))?;
        let now = self.clock.now_nanos().max(self.last_nanos);
        self.publisher.publish(publication, now, &data)?;
        self.last_nanos = now;
        self.sent += 1;
        take(Incoming::Message(Message {
            topic,
            publish_nanos: Some(now),
            received_nanos: now,
            sequence: Some(self.sent),
            data,
        }));
        Ok(())
    }

    /// The source, for its topics and totals.
    pub fn source(&self) -> &dyn Source {
        self.source.as_ref()
    }

    /// The relation of the bench's time to the clock's.
    pub fn pacer(&self) -> &Pacer {
        &self.pacer
    }

    /// How well the bench kept up with the wall clock.
    pub fn punctuality(&self) -> Punctuality {
        self.pacer.punctuality()
    }

    /// Ends the source.
    pub fn stop(&mut self) {
        self.source.stop();
    }
}
