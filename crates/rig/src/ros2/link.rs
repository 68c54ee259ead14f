//! The connection to a node: what is published, what is awaited, and for how long.

use super::codec::{Inbound, Outbound, at, nanos};
use super::domains::Domain;
use super::node::Node;
use super::table::{CLOCK, Join};
use live::dds::{self, DdsOptions, DdsPublisher};
use live::{
    Event, Incoming, LiveStream, Message, Outgoing, PublicationId, Publisher, Source, TopicFilter,
};
use recording::TypeDefinitions;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};
use testbench::controller::{ControllerError, Inputs, Measurement, Outputs, Setup};

/// How long to wait for a message at once.
const PATIENCE: Duration = Duration::from_millis(20);
/// How long a node has to answer while time stands still, before the clock is repeated.
const REPEAT: Duration = Duration::from_secs(1);
/// How long nothing may come before time begins: then nothing of before is under way.
const QUIET: Duration = Duration::from_millis(200);

/// A topic to the node.
struct Sent {
    name: String,
    publication: PublicationId,
    outbound: Outbound,
    sensor: Option<String>,
    message: Option<String>,
}

/// A topic from the node.
struct Heard {
    type_name: String,
    inbound: Inbound,
    /// Messages that were not looked at yet.
    waiting: Vec<Vec<u8>>,
}

/// A connection for one episode.
pub struct Link {
    // Dropped first, so that its topics go before ours.
    node: Option<Node>,
    source: LiveStream,
    publisher: DdsPublisher,
    clock: (PublicationId, Outbound),
    sent: Vec<Sent>,
    heard: BTreeMap<String, Heard>,
    /// Topics that somebody publishes.
    present: BTreeSet<String>,
    longest: Duration,
    /// The domain is free again when all above has left it.
    _domain: Domain,
}

fn transport(error: impl ToString) -> ControllerError {
    ControllerError::Transport {
        reason: error.to_string(),
    }
}

impl Link {
    /// Joins the domain and makes the topics known.
    pub fn new(
        join: &Join,
        setup: &Setup,
        domain: Domain,
        longest: Duration,
    ) -> Result<Self, ControllerError> {
        let options = DdsOptions {
            domain: domain.number,
            networks: join.networks.clone(),
            ..DdsOptions::default()
        };
        let mut publisher = DdsPublisher::new(&options).map_err(transport)?;
        let clock = clock(&mut publisher)?;
        let mut sent = Vec::new();
        for topic in &join.publish {
            let port = setup.sensors.iter();
            let mut port = port.filter(|port| Some(&port.name) == topic.sensor.as_ref());
            let fields = port.next().map_or(&[][..], |port| &port.fields);
            let outbound = Join::outbound(topic, fields).map_err(transport)?;
            let mut outgoing = Outgoing::ros2(&topic.topic, &topic.type_name);
            outgoing.latched = topic.latched;
            sent.push(Sent {
                name: topic.topic.clone(),
                publication: publisher.advertise(&outgoing).map_err(transport)?,
                outbound,
                sensor: topic.sensor.clone(),
                message: topic.message.clone(),
            });
        }
        let names: Vec<&str> = join.subscribe.iter().map(|it| it.topic.as_str()).collect();
        Ok(Self {
            node: None,
            source: dds::connect(&options, TopicFilter::new(&names, &[])).map_err(transport)?,
            publisher,
            clock,
            sent,
            heard: heard(join)?,
            present: BTreeSet::new(),
            longest,
            _domain: domain,
        })
    }

    /// The domain.
    pub fn domain(&self) -> u16 {
        self._domain.number
    }

    /// The node that is ended with this connection.
    pub fn keep(&mut self, node: Node) {
        self.node = Some(node);
    }

    /// Waits until all topics have both sides, and the node is awake: it has answered the clock of
    /// time 0 on all topics, or `settle` has gone by.
    pub fn wake(&mut self, settle: Option<Duration>) -> Result<(), ControllerError> {
        let began = Instant::now();
        while let Some(absent) = self.absent() {
            self.listen(PATIENCE)?;
            self.check_patience(began, &|| absent.clone())?;
        }
        match settle {
            Some(settle) => self.listen_for(settle)?,
            None => self.wake_by_clock(began)?,
        }
        self.forget();
        Ok(())
    }

    /// Repeats the clock of time 0 until it is answered, and waits until nothing more comes.
    fn wake_by_clock(&mut self, began: Instant) -> Result<(), ControllerError> {
        loop {
            self.forget();
            self.tell_time(0.0)?;
            let told = Instant::now();
            while told.elapsed() < REPEAT && self.unanswered().is_some() {
                self.listen(PATIENCE)?;
            }
            let Some(topic) = self.unanswered() else {
                return self.listen_for(QUIET);
            };
            self.check_patience(began, &|| {
                format!("it has not answered {CLOCK} 0 on {topic} (a node that is silent while time stands still needs `settle_secs`)")
            })?;
        }
    }

    /// What is still missing of the topics.
    fn absent(&self) -> Option<String> {
        let published = self.sent.iter().map(|topic| topic.name.as_str());
        let unread: Vec<&str> = std::iter::once(CLOCK)
            .chain(published)
            .filter(|topic| self.publisher.readers(topic) == 0)
            .collect();
        let unheard: Vec<&str> = self
            .heard
            .keys()
            .filter(|topic| !self.present.contains(*topic))
            .map(String::as_str)
            .collect();
        let domain = self.domain();
        match (unread.as_slice(), unheard.as_slice()) {
            ([], []) => None,
            ([], unheard) => Some(format!(
                "no publisher of {} in domain {domain}",
                unheard.join(", ")
            )),
            (unread, []) => Some(format!(
                "no subscriber to {} in domain {domain}",
                unread.join(", ")
            )),
            (unread, unheard) => Some(format!(
                "no subscriber to {} and no publisher of {} in domain {domain}",
                unread.join(", "),
                unheard.join(", ")
            )),
        }
    }

    /// Publishes what has arrived for the node, then the time. What is reliable is there before the
    /// time is told.
    pub fn tell(&mut self, inputs: &Inputs) -> Result<(), ControllerError> {
        for place in 0..self.sent.len() {
            let topic = &self.sent[place];
            let measured = topic.sensor.as_ref();
            let measured = measured.and_then(|sensor| inputs.measurements.get(sensor));
            let messages = inputs.messages.iter();
            let sent = messages.filter(|it| Some(&it.name) == topic.message.as_ref());
            let mut all: Vec<Measurement> = sent.map(|message| at(message.time_secs)).collect();
            all.extend(measured.cloned());
            for measurement in all {
                let data = self.sent[place].outbound.encode(&measurement);
                let data = data.map_err(|message| ControllerError::Failed { message })?;
                let id = self.sent[place].publication;
                let stamp = nanos(measurement.time_secs);
                self.publisher
                    .publish(id, stamp, &data)
                    .map_err(transport)?;
            }
        }
        self.publisher
            .wait_acknowledged(self.longest)
            .map_err(|error| self.silent(&error.to_string()))?;
        self.tell_time(inputs.time_secs)
    }

    fn tell_time(&mut self, time_secs: f64) -> Result<(), ControllerError> {
        let (id, outbound) = &self.clock;
        let data = outbound.encode(&at(time_secs));
        let data = data.map_err(|message| ControllerError::Failed { message })?;
        self.publisher
            .publish(*id, nanos(time_secs), &data)
            .map_err(transport)
    }

    /// Waits for one message on each topic, and gives what they say.
    pub fn answers(&mut self, time_secs: f64) -> Result<Outputs, ControllerError> {
        let began = Instant::now();
        while let Some(topic) = self.unanswered() {
            self.listen(PATIENCE)?;
            self.check_patience(began, &|| {
                format!("{topic} has no answer to {CLOCK} {time_secs} s")
            })?;
        }
        let mut outputs = Outputs::default();
        for (name, topic) in &mut self.heard {
            let said = std::mem::take(&mut topic.waiting);
            let [one] = said.as_slice() else {
                return Err(asynchronous(name, said.len(), time_secs));
            };
            let stamp = topic.inbound.decode(one, &mut outputs);
            let stamp = stamp.map_err(|message| ControllerError::Failed { message })?;
            if let Some(stamp) = stamp.filter(|stamp| *stamp != nanos(time_secs)) {
                let message = format!(
                    "{name}: the answer to {CLOCK} {time_secs} s is stamped {} s; in lock step the stamp repeats the clock",
                    stamp as f64 / 1e9
                );
                return Err(ControllerError::Failed { message });
            }
        }
        Ok(outputs)
    }

    /// What has come by `until`, the latest message of each topic; the others are passed over.
    pub fn latest(&mut self, until: Instant) -> Result<(Outputs, bool), ControllerError> {
        loop {
            let left = until.saturating_duration_since(Instant::now());
            self.listen(left.min(PATIENCE))?;
            if left.is_zero() {
                break;
            }
        }
        let mut outputs = Outputs::default();
        let mut has_come = false;
        for topic in self.heard.values_mut() {
            for message in std::mem::take(&mut topic.waiting) {
                let before = std::mem::take(&mut outputs.messages);
                let decoded = topic.inbound.decode(&message, &mut outputs);
                decoded.map_err(|message| ControllerError::Failed { message })?;
                // What was said once was said, however late it is looked at.
                let new = before
                    .into_iter()
                    .filter(|it| !outputs.messages.contains(it));
                let new: Vec<String> = new.collect();
                outputs.messages.extend(new);
                has_come = true;
            }
        }
        Ok((outputs, has_come))
    }

    /// In lock step nothing may come before time goes on.
    pub fn check_quiet(&mut self, time_secs: f64) -> Result<(), ControllerError> {
        self.listen(Duration::ZERO)?;
        let noisy = self
            .heard
            .iter()
            .find(|(_, topic)| !topic.waiting.is_empty());
        match noisy {
            None => Ok(()),
            Some((name, topic)) => Err(asynchronous(name, topic.waiting.len() + 1, time_secs)),
        }
    }

    /// A topic on which nothing waits.
    fn unanswered(&self) -> Option<String> {
        let mut topics = self.heard.iter();
        let found = topics.find(|(_, topic)| topic.waiting.is_empty());
        found.map(|(name, _)| name.clone())
    }

    fn forget(&mut self) {
        self.heard.values_mut().for_each(|it| it.waiting.clear());
    }

    fn listen_for(&mut self, time: Duration) -> Result<(), ControllerError> {
        let began = Instant::now();
        while began.elapsed() < time {
            self.listen(PATIENCE)?;
        }
        Ok(())
    }

    /// Takes what comes, waiting for the first for up to `timeout`.
    fn listen(&mut self, timeout: Duration) -> Result<(), ControllerError> {
        let mut next = self.source.next(timeout).map_err(transport)?;
        while let Some(incoming) = next {
            match incoming {
                Incoming::Message(message) => self.note_message(message),
                Incoming::Event { event, .. } => self.note_event(event)?,
            }
            next = self.source.next(Duration::ZERO).map_err(transport)?;
        }
        Ok(())
    }

    fn note_message(&mut self, message: Message) {
        if let Some(topic) = self.heard.get_mut(&message.topic.name) {
            topic.waiting.push(message.data);
        }
    }

    fn note_event(&mut self, event: Event) -> Result<(), ControllerError> {
        match event {
            Event::TopicAppeared { topic }
            | Event::Reconnected {
                topic: Some(topic), ..
            } => {
                let wanted = self.heard.get(&topic.name);
                if let Some(wanted) = wanted.filter(|it| it.type_name != topic.type_name) {
                    return Err(transport(format!(
                        "{} is published as {}, and the scene says {}",
                        topic.name, topic.type_name, wanted.type_name
                    )));
                }
                self.present.insert(topic.name.clone());
            }
            Event::Refused { name, reason } => return Err(transport(format!("{name}: {reason}"))),
            Event::Lost { topic, count, .. } => {
                let name = topic.map_or_else(|| "a topic".to_owned(), |it| it.name.clone());
                return Err(transport(format!(
                    "lost {} of {name}",
                    diagnostic::counted(count, "message")
                )));
            }
            Event::Disconnected {
                topic: Some(topic), ..
            } => drop(self.present.remove(&topic.name)),
            _ => {}
        }
        Ok(())
    }

    /// Fails when the node has ended, or nothing has come for too long.
    fn check_patience(
        &mut self,
        began: Instant,
        what: &dyn Fn() -> String,
    ) -> Result<(), ControllerError> {
        if self
            .node
            .as_mut()
            .is_some_and(|node| node.ended().is_some())
        {
            return Err(self.silent(&what()));
        }
        if began.elapsed() < self.longest {
            return Ok(());
        }
        let secs = self.longest.as_secs_f64();
        Err(self.silent(&format!(
            "{} after {secs} s of the wall clock (`answer_within_secs`)",
            what()
        )))
    }

    /// The error of a node that does not answer.
    pub fn silent(&mut self, what: &str) -> ControllerError {
        let node = self.node.as_mut();
        let words = node.map_or_else(
            || "no program was started here, so one has to run already".to_owned(),
            Node::last_words,
        );
        ControllerError::Silent {
            reason: format!("{what}; {words}"),
        }
    }
}

fn clock(publisher: &mut DdsPublisher) -> Result<(PublicationId, Outbound), ControllerError> {
    let type_name = "rosgraph_msgs/msg/Clock";
    let fields = [("clock".to_owned(), super::codec::Source::Time)];
    let outbound = Outbound::new(CLOCK, type_name, &[], &fields, None).map_err(transport)?;
    let outgoing = Outgoing::ros2(CLOCK, type_name);
    Ok((publisher.advertise(&outgoing).map_err(transport)?, outbound))
}

fn heard(join: &Join) -> Result<BTreeMap<String, Heard>, ControllerError> {
    let types = TypeDefinitions::new(&[]).map_err(transport)?;
    let made = join.subscribe.iter().map(|topic| {
        let heard = Heard {
            type_name: topic.type_name.clone(),
            inbound: Join::inbound(topic, &types).map_err(transport)?,
            waiting: Vec::new(),
        };
        Ok((topic.topic.clone(), heard))
    });
    made.collect()
}

/// The error of a node that does not keep step.
fn asynchronous(topic: &str, count: usize, time_secs: f64) -> ControllerError {
    ControllerError::Failed {
        message: format!(
            "{topic} had {count} messages by {CLOCK} {time_secs} s where one answers each tick; let the node publish once for each {CLOCK}, or give `real_time_factor`"
        ),
    }
}
