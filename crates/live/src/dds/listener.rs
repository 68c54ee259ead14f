//! The listening thread: finds writers, keeps one reader for each wanted topic, and hands out what they receive.
//!
//! Writers are found by comparing the participant's list of them ten times a second with what is known, not by its
//! events: a list cannot be missed. Messages of all topics that wait are handed out in the order in which they arrived.
//!
//! A participant that fell silent (a broken link, a halted process) for longer than its lease is forgotten by the
//! stack, and some implementations then repeat their announcement under its old number, which the stack takes for a
//! repetition: it would never be found again. So whenever somebody falls silent the domain is joined anew, beside the
//! session at hand; a topic moves to the new session when that sees writers which its own does not.

use super::DdsOptions;
use super::names;
use super::quality;
use super::reader::{Listened, Waiting};
use super::session::{Session, Wanted, Writer};
use crate::clock::instant;
use crate::stream::Outlet;
use crate::{Event, LiveError, Origin, Topic, TopicFilter};
use rustdds::mio1::{Events, Poll, Token};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// How often writers are looked for, and how long the thread sleeps at most.
const LOOK_EVERY: Duration = Duration::from_millis(100);
const SLEEP_AT_MOST: Duration = Duration::from_millis(50);
/// How much time lies at least between two joinings.
const REJOIN_AFTER: Duration = Duration::from_secs(1);

/// The writers of each wanted topic, by their DDS names.
type Writers = BTreeMap<String, Vec<Writer>>;

/// Listens until the outlet is stopped or the stack fails.
pub(super) fn listen(outlet: &Outlet, session: Session, filter: TopicFilter, options: DdsOptions) {
    outlet.queue.push_event(Event::Connected {
        to: format!("DDS domain {}", options.domain),
    });
    let result =
        Listener::new(outlet, session, filter, options).and_then(|mut listener| listener.run());
    if let Err(error) = result {
        outlet.queue.end(error);
    }
}

struct Listener<'a> {
    outlet: &'a Outlet,
    listened: Vec<Listened>,
    /// The place of each DDS topic in `listened`.
    places: BTreeMap<String, usize>,
    /// The newest session, in which new topics are listened to.
    session: Rc<Session>,
    rejoin_wanted: bool,
    joined_at: Instant,
    options: DdsOptions,
    filter: TopicFilter,
    poll: Poll,
    /// Topics (with their types) that were refused, so that it is said once.
    refused: BTreeSet<(String, String)>,
}

impl<'a> Listener<'a> {
    fn new(
        outlet: &'a Outlet,
        session: Session,
        filter: TopicFilter,
        options: DdsOptions,
    ) -> Result<Self, LiveError> {
        let poll = Poll::new().map_err(|error| LiveError::Transport(error.to_string()))?;
        Ok(Self {
            outlet,
            listened: Vec::new(),
            places: BTreeMap::new(),
            session: Rc::new(session),
            rejoin_wanted: false,
            joined_at: instant(),
            options,
            filter,
            poll,
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

    /// Hands out what waits, of all topics in the order of arrival and of each writer in its own. True if more may wait.
    fn hand_out_waiting(&mut self) -> Result<bool, LiveError> {
        let mut waiting: Vec<Waiting> = Vec::new();
        let mut more = false;
        for (place, listened) in self.listened.iter_mut().enumerate() {
            more |= listened
                .take(place, &mut waiting, self.outlet)
                .map_err(|error| LiveError::Transport(error.to_string()))?;
        }
        // Stable, so messages of one writer that were released together stay in order.
        waiting.sort_by_key(|message| message.released);
        for message in waiting {
            self.listened[message.place].hand_out(message.sample, self.outlet);
        }
        Ok(more)
    }

    /// Compares the writers that are there with those that are known.
    fn look_for_writers(&mut self) {
        self.rejoin_if_somebody_fell_silent();
        let newest = self.session.writers(&self.filter);
        let older = self.writers_of_older_sessions();
        let known: Vec<String> = self.places.keys().cloned().collect();
        for dds_name in known.iter().chain(newest.keys()).collect::<BTreeSet<_>>() {
            let in_newest = newest.get(dds_name).map_or(&[][..], Vec::as_slice);
            match self.places.get(dds_name).copied() {
                None => self.begin(dds_name, in_newest),
                Some(place) => {
                    let own = older
                        .iter()
                        .find(|(session, _)| Rc::ptr_eq(session, &self.listened[place].session));
                    let in_own = own.and_then(|(_, writers)| writers.get(dds_name));
                    let in_own = in_own.map_or(&[][..], Vec::as_slice);
                    if own.is_some() && !sees_more(in_newest, in_own) {
                        let session = self.listened[place].session.clone();
                        self.attend(place, session, in_own);
                    } else {
                        self.attend(place, self.session.clone(), in_newest);
                    }
                }
            }
        }
    }

    /// Joins the domain anew if somebody fell silent, so that they are found when they come back.
    fn rejoin_if_somebody_fell_silent(&mut self) {
        self.rejoin_wanted |= self.session.somebody_fell_silent();
        if !self.rejoin_wanted || self.joined_at.elapsed() < REJOIN_AFTER {
            return;
        }
        self.joined_at = instant();
        match Session::join(&self.options) {
            Ok(session) => {
                self.session = Rc::new(session);
                self.rejoin_wanted = false;
            }
            Err(error) => {
                let text =
                    format!("the domain could not be joined anew, which is tried again: {error}");
                self.outlet.queue.push_event(Event::Notice { text });
            }
        }
    }

    /// The sessions before the newest in which topics are still listened to, with the writers that they see.
    fn writers_of_older_sessions(&self) -> Vec<(Rc<Session>, Writers)> {
        let mut older: Vec<(Rc<Session>, Writers)> = Vec::new();
        for listened in &self.listened {
            let session = &listened.session;
            let known = Rc::ptr_eq(session, &self.session)
                || older.iter().any(|(other, _)| Rc::ptr_eq(other, session));
            if !known {
                older.push((session.clone(), session.writers(&self.filter)));
            }
        }
        older
    }

    /// What to ask of the writers of a topic in the type `dds_type`, and which they are. The others are refused.
    fn wanted<'w>(
        &mut self,
        dds_name: &str,
        dds_type: &str,
        writers: &'w [Writer],
    ) -> (Wanted, Vec<&'w Writer>) {
        let (of_type, others): (Vec<&Writer>, Vec<&Writer>) = writers
            .iter()
            .partition(|writer| writer.dds_type == dds_type);
        for other in others {
            let reason = format!(
                "it is published as {}, but it is already listened to as {}",
                names::shown_type(&other.dds_type),
                names::shown_type(dds_type)
            );
            self.refuse(dds_name, &other.dds_type, reason);
        }
        let wanted = Wanted {
            dds_name: dds_name.to_owned(),
            type_name: names::shown_type(dds_type),
            dds_type: dds_type.to_owned(),
            qos: quality::fitting(of_type.iter().map(|writer| writer.qos)),
            exclusive: of_type.first().is_some_and(|writer| writer.exclusive),
        };
        (wanted, of_type)
    }

    /// Listens to a topic that was not known, in the type of its first writer.
    fn begin(&mut self, dds_name: &str, writers: &[Writer]) {
        let Some(first) = writers.first() else {
            return;
        };
        let (wanted, of_type) = self.wanted(dds_name, &first.dds_type, writers);
        let reader = match self.session.reader(&wanted) {
            Ok(reader) => reader,
            Err(error) => return self.refuse(dds_name, &wanted.dds_type, error.to_string()),
        };
        let name = names::shown_topic(dds_name);
        let topic = self.outlet.queue.add_topic(|id| Topic {
            id,
            name: name.unwrap_or_else(|| dds_name.to_owned()),
            type_name: wanted.type_name.clone(),
            encoding: "cdr".to_owned(),
            schema: None,
            qos: Some(wanted.qos),
            type_hash: of_type.iter().find_map(|writer| writer.type_hash.clone()),
            origin: Origin::Outside,
            numbered: true,
        });
        self.outlet.queue.push_event(Event::TopicAppeared {
            topic: topic.clone(),
        });
        let place = self.listened.len();
        self.places.insert(dds_name.to_owned(), place);
        let session = self.session.clone();
        self.listened
            .push(Listened::new(topic, wanted, reader, session));
        self.register(place);
    }

    /// Listens to the writers of a known topic in `session`, with another reader if the present one is of another
    /// session or its quality of service does not fit all of them any more.
    fn attend(&mut self, place: usize, session: Rc<Session>, writers: &[Writer]) {
        let asked = self.listened[place].wanted.clone();
        let (wanted, of_type) = self.wanted(&asked.dds_name, &asked.dds_type, writers);
        let unfit = of_type.iter().any(|writer| {
            !quality::fits(asked.qos, writer.qos) || asked.exclusive != writer.exclusive
        });
        let moves = !of_type.is_empty() && !Rc::ptr_eq(&session, &self.listened[place].session);
        if moves || (unfit && asked != wanted) {
            match session.reader(&wanted) {
                Ok(reader) => {
                    self.listened[place].replace(wanted, reader, session);
                    self.register(place);
                }
                Err(error) => self.refuse(&asked.dds_name, &asked.dds_type, error.to_string()),
            }
        }
        let present = of_type.iter().map(|writer| writer.guid).collect();
        self.listened[place].note_writers(&present, self.outlet);
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

/// Whether the newest session sees writers that a topic's own does not, and none fewer.
fn sees_more(newest: &[Writer], own: &[Writer]) -> bool {
    let has = |writers: &[Writer], guid| writers.iter().any(|writer| writer.guid == guid);
    newest.iter().any(|writer| !has(own, writer.guid))
        && own.iter().all(|writer| has(newest, writer.guid))
}
