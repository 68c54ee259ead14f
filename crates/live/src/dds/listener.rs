//! The listening thread: finds writers, keeps one reader for each wanted topic, and hands out what they receive.
//!
//! Writers are found by comparing the participant's list of them ten times a second with what is known, not by its
//! events: a list cannot be missed. Messages of all topics that wait are handed out in the order in which they arrived.

use super::names;
use super::quality;
use super::reader::{Listened, Sample, Wanted, make_reader};
use crate::clock::instant;
use crate::stream::Outlet;
use crate::{Event, LiveError, Origin, Qos, Topic, TopicFilter};
use rustdds::discovery::DiscoveredWriterData;
use rustdds::mio1::{Events, Poll, Token};
use rustdds::{DomainParticipant, GUID, QosPolicyBuilder, Subscriber, policy};
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// How often writers are looked for, and how long the thread sleeps at most.
const LOOK_EVERY: Duration = Duration::from_millis(100);
const SLEEP_AT_MOST: Duration = Duration::from_millis(50);

/// Listens until the outlet is stopped or the stack fails.
pub(super) fn listen(
    outlet: Outlet,
    participant: &DomainParticipant,
    filter: TopicFilter,
    domain: u16,
) {
    outlet.queue.push_event(Event::Connected {
        to: format!("DDS domain {domain}"),
    });
    let result = Listener::new(outlet, participant, filter)
        .and_then(|mut listener| listener.run().map_err(|error| (error, listener.outlet)));
    if let Err((error, outlet)) = result {
        outlet.queue.end(error);
    }
}

struct Listener<'a> {
    outlet: Outlet,
    participant: &'a DomainParticipant,
    subscriber: Subscriber,
    filter: TopicFilter,
    poll: Poll,
    listened: Vec<Listened>,
    /// The place of each DDS topic in `listened`.
    places: BTreeMap<String, usize>,
    /// Topics (with their types) that were refused, so that it is said once.
    refused: BTreeSet<(String, String)>,
}

/// A writer of a wanted topic.
struct Writer {
    guid: GUID,
    dds_type: String,
    qos: Qos,
    exclusive: bool,
    type_hash: Option<String>,
}

impl<'a> Listener<'a> {
    fn new(
        outlet: Outlet,
        participant: &'a DomainParticipant,
        filter: TopicFilter,
    ) -> Result<Self, (LiveError, Outlet)> {
        let transport = |text: String| LiveError::Transport(text);
        let poll = match Poll::new() {
            Ok(poll) => poll,
            Err(error) => return Err((transport(error.to_string()), outlet)),
        };
        let subscriber = match participant.create_subscriber(&QosPolicyBuilder::new().build()) {
            Ok(subscriber) => subscriber,
            Err(error) => return Err((transport(error.to_string()), outlet)),
        };
        Ok(Self {
            outlet,
            participant,
            subscriber,
            filter,
            poll,
            listened: Vec::new(),
            places: BTreeMap::new(),
            refused: BTreeSet::new(),
        })
    }

    fn run(&mut self) -> Result<(), LiveError> {
        let mut events = Events::with_capacity(256);
        let mut look_at = instant();
        let mut more = false;
        while !self.outlet.stopped() {
            let sleep = if more { Duration::ZERO } else { SLEEP_AT_MOST };
            match self.poll.poll(&mut events, Some(sleep)) {
                Err(error) if error.kind() != std::io::ErrorKind::Interrupted => {
                    return Err(LiveError::Transport(error.to_string()));
                }
                _ => {}
            }
            more = self.hand_out_waiting()?;
            if instant() >= look_at {
                self.look_for_writers();
                look_at = next_look(look_at);
            }
        }
        Ok(())
    }

    /// Hands out what waits, of all topics in the order of arrival. True if more may wait.
    fn hand_out_waiting(&mut self) -> Result<bool, LiveError> {
        let mut samples: Vec<(usize, Sample)> = Vec::new();
        let mut more = false;
        for (index, listened) in self.listened.iter_mut().enumerate() {
            more |= listened
                .take(index, &mut samples, &self.outlet)
                .map_err(|error| LiveError::Transport(error.to_string()))?;
        }
        samples.sort_by_key(|(_, sample)| sample.receive_instant);
        for (index, sample) in samples {
            self.listened[index].hand_out(sample, &self.outlet);
        }
        Ok(more)
    }

    /// Compares the writers that are there with those that are known.
    fn look_for_writers(&mut self) {
        let mut present: BTreeMap<String, Vec<Writer>> = BTreeMap::new();
        for data in self.participant.discovered_writers() {
            let dds_name = data.publication_topic_data.topic_name.clone();
            let shown = names::shown_topic(&dds_name);
            if shown.is_some_and(|shown| self.filter.wants(&shown)) {
                present.entry(dds_name).or_default().push(writer(&data));
            }
        }
        for (dds_name, writers) in &mut present {
            // The order of discovery is not known; that of their identities is at least the same each time.
            writers.sort_by_key(|writer| writer.guid);
            self.attend(dds_name, writers);
        }
        for listened in &mut self.listened {
            if !present.contains_key(&listened.wanted.dds_name) {
                listened.note_writers(&BTreeSet::new(), &self.outlet);
            }
        }
    }

    /// Makes sure that the writers of a topic are listened to.
    fn attend(&mut self, dds_name: &str, writers: &[Writer]) {
        let place = self.places.get(dds_name).copied();
        let dds_type = match (place, writers.first()) {
            (Some(place), _) => self.listened[place].wanted.dds_type.clone(),
            (None, Some(first)) => first.dds_type.clone(),
            (None, None) => return,
        };
        let (of_type, others): (Vec<&Writer>, Vec<&Writer>) = writers
            .iter()
            .partition(|writer| writer.dds_type == dds_type);
        for other in others {
            let reason = format!(
                "it is published as {}, but it is already listened to as {}",
                names::shown_type(&other.dds_type),
                names::shown_type(&dds_type)
            );
            self.refuse(dds_name, &other.dds_type, reason);
        }
        let wanted = Wanted {
            dds_name: dds_name.to_owned(),
            type_name: names::shown_type(&dds_type),
            dds_type,
            qos: quality::fitting(of_type.iter().map(|writer| writer.qos)),
            exclusive: of_type.first().is_some_and(|writer| writer.exclusive),
        };
        match place {
            None => self.begin(wanted, &of_type),
            Some(place) => self.adapt(place, wanted, &of_type),
        }
    }

    /// Listens to a topic that was not known.
    fn begin(&mut self, wanted: Wanted, writers: &[&Writer]) {
        let reader = match make_reader(self.participant, &self.subscriber, &wanted) {
            Ok(reader) => reader,
            Err(error) => {
                let (name, dds_type) = (wanted.dds_name, wanted.dds_type);
                return self.refuse(&name, &dds_type, error.to_string());
            }
        };
        let name = names::shown_topic(&wanted.dds_name);
        let topic = self.outlet.queue.add_topic(|id| Topic {
            id,
            name: name.unwrap_or_else(|| wanted.dds_name.clone()),
            type_name: wanted.type_name.clone(),
            encoding: "cdr".to_owned(),
            schema: None,
            qos: Some(wanted.qos),
            type_hash: writers.iter().find_map(|writer| writer.type_hash.clone()),
            origin: Origin::Outside,
            numbered: true,
        });
        self.outlet.queue.push_event(Event::TopicAppeared {
            topic: topic.clone(),
        });
        let place = self.listened.len();
        self.places.insert(wanted.dds_name.clone(), place);
        self.listened.push(Listened::new(topic, wanted, reader));
        self.register(place);
        self.note(place, writers);
    }

    /// Changes the quality of service of a topic's reader if it does not fit all writers any more.
    fn adapt(&mut self, place: usize, wanted: Wanted, writers: &[&Writer]) {
        let asked = &self.listened[place].wanted;
        let unfit = writers.iter().any(|writer| {
            !quality::fits(asked.qos, writer.qos) || asked.exclusive != writer.exclusive
        });
        if unfit && *asked != wanted {
            match make_reader(self.participant, &self.subscriber, &wanted) {
                Ok(reader) => {
                    self.listened[place].replace(wanted, reader);
                    self.register(place);
                }
                Err(error) => {
                    self.refuse(&wanted.dds_name, &wanted.dds_type, error.to_string());
                }
            }
        }
        self.note(place, writers);
    }

    /// Wakes the thread when messages of the topic arrive. If that cannot be had, they are found when it wakes anyway.
    fn register(&mut self, place: usize) {
        let result = self.listened[place].register(self.poll.registry(), Token(place));
        if let Err(error) = result {
            let text = format!(
                "{} is looked at {} times a second only: {error}",
                self.listened[place].topic.name,
                1000 / SLEEP_AT_MOST.as_millis()
            );
            self.outlet.queue.push_event(Event::Notice { text });
        }
    }

    fn note(&mut self, place: usize, writers: &[&Writer]) {
        let present = writers.iter().map(|writer| writer.guid).collect();
        self.listened[place].note_writers(&present, &self.outlet);
    }

    fn refuse(&mut self, dds_name: &str, dds_type: &str, reason: String) {
        if self
            .refused
            .insert((dds_name.to_owned(), dds_type.to_owned()))
        {
            let name = names::shown_topic(dds_name).unwrap_or_else(|| dds_name.to_owned());
            self.outlet
                .queue
                .push_event(Event::Refused { name, reason });
        }
    }
}

/// The time of the next look: regular, but not catching up after a pause.
fn next_look(last: Instant) -> Instant {
    (last + LOOK_EVERY).max(instant())
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
