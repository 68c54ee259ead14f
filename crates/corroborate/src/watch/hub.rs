//! What is known of a watched run: everything that happens comes here, is
//! counted, kept and told.

use super::Audience;
use super::event::{WatchEvent, WatchLine};
use super::keeper::Keeper;
use host::Cancel;
use live::{Clock, Event, LossCause, Message, Origin};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The hub as the reader and the command share it.
pub type SharedHub = Arc<Mutex<Hub>>;

/// Locks the hub. A panic elsewhere leaves counters, not broken memory.
pub fn locked(hub: &SharedHub) -> MutexGuard<'_, Hub> {
    hub.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What is known of a run.
pub struct Hub {
    /// The clock that stamps arrivals.
    pub clock: Clock,
    /// Who is told what happens.
    pub audience: Box<dyn Audience>,
    /// Who keeps it.
    pub keeper: Option<Keeper>,
    interrupt: Arc<Cancel>,
    ends_at_nanos: Option<i64>,
    /// What was to be over before watching ends, if that was planned.
    planned: Option<String>,
    /// Whether it was not.
    pub was_cut_short: bool,
    /// Why watching ends, once it does.
    ended: Option<String>,
    /// What is missing, a clause each, and how often.
    missing: BTreeMap<String, u64>,
    lost: u64,
    received: u64,
    /// Numbered topics that were gone.
    away: BTreeSet<u32>,
}

impl Hub {
    /// A hub that ends at `ends_at_nanos`, or when the user says so.
    pub fn new(
        clock: Clock,
        audience: Box<dyn Audience>,
        keeper: Option<Keeper>,
        interrupt: Arc<Cancel>,
        ends_at_nanos: Option<i64>,
        planned: Option<String>,
    ) -> Self {
        Self {
            clock,
            audience,
            keeper,
            interrupt,
            ends_at_nanos,
            planned,
            was_cut_short: false,
            ended: None,
            missing: BTreeMap::new(),
            lost: 0,
            received: 0,
            away: BTreeSet::new(),
        }
    }

    /// Whether to end now.
    pub fn must_end(&mut self) -> bool {
        if self.ended.is_none() {
            if self.interrupt.is_cancelled() {
                self.ended = Some("interrupted".into());
                if let Some(what) = self.planned.clone() {
                    self.was_cut_short = true;
                    self.miss(format!("it was interrupted before {what}"));
                }
            } else if self.audience.is_gone() {
                self.ended = Some("its output is no longer read".into());
            } else if self
                .ends_at_nanos
                .is_some_and(|end| self.clock.now_nanos() >= end)
            {
                self.ended = Some("the time is over".into());
            }
        }
        self.ended.is_some()
    }

    /// Why watching ended.
    pub fn reason(&self) -> &str {
        self.ended.as_deref().unwrap_or("the stream ended")
    }

    /// All came that was to come.
    pub fn end(&mut self, why: String) {
        self.ended.get_or_insert(why);
    }

    /// The connection cannot be continued.
    pub fn broke(hub: &SharedHub, why: &str) {
        let mut hub = locked(hub);
        hub.miss(format!("the connection ended: {why}"));
        hub.ended.get_or_insert_with(|| why.to_owned());
    }

    /// A message came.
    pub fn message(&mut self, message: &Message, log_nanos: i64) {
        self.received += 1;
        self.audience.message(&message.topic.name);
        if let Some(keeper) = &mut self.keeper {
            keeper.message(message, log_nanos);
            keeper.flush_when_due(self.clock.now_nanos());
        }
    }

    /// Nothing came for a while.
    pub fn idle(&mut self) {
        let now_nanos = self.clock.now_nanos();
        if let Some(keeper) = &mut self.keeper {
            keeper.flush_when_due(now_nanos);
        }
        self.audience.idle(now_nanos);
    }

    /// Something happened to the connection.
    pub fn happened(&mut self, at_nanos: i64, event: Event) {
        if let Some(told) = self.taken(event) {
            self.tell(at_nanos, told);
        }
    }

    /// Counts what an event means for completeness, and says how to tell it.
    fn taken(&mut self, event: Event) -> Option<WatchEvent> {
        let name = |topic: Option<Arc<live::Topic>>| topic.map(|topic| topic.name.clone());
        Some(match event {
            Event::Connected { to } => WatchEvent::Connected { to },
            Event::TopicAppeared { topic } => WatchEvent::TopicAppeared {
                topic: topic.name.clone(),
                type_name: topic.type_name.clone(),
                origin: match topic.origin {
                    Origin::Outside => "outside",
                    Origin::TestBench => "simulation",
                }
                .into(),
            },
            Event::Refused { name, reason } => WatchEvent::TopicRefused {
                topic: name,
                reason,
            },
            Event::Lost {
                topic,
                count,
                cause,
            } => self.lose(name(topic), count, cause_name(cause)),
            // What was sent before one attaches is no loss; what was sent
            // while it was away is.
            Event::PublisherJoined { topic, sent_before } => {
                if sent_before == 0 || !self.away.remove(&topic.id) {
                    return None;
                }
                self.lose(Some(topic.name.clone()), sent_before, "while-away")
            }
            Event::Disconnected { topic, reason } => {
                if let Some(topic) = topic.as_ref().filter(|topic| topic.numbered) {
                    self.away.insert(topic.id);
                }
                WatchEvent::Disconnected {
                    topic: name(topic),
                    reason,
                }
            }
            Event::Reconnected { topic, away_nanos } => {
                let numbered = topic.as_ref().is_some_and(|topic| topic.numbered);
                if !numbered {
                    let what = topic.as_ref().map_or("the connection", |t| t.name.as_str());
                    self.miss(format!(
                        "{what} was away, and whether messages were sent meanwhile is not known"
                    ));
                }
                WatchEvent::Reconnected {
                    topic: name(topic),
                    away_secs: away_nanos as f64 / 1e9,
                }
            }
            Event::Notice { text } => WatchEvent::Notice { text },
        })
    }

    fn lose(&mut self, topic: Option<String>, count: u64, cause: &str) -> WatchEvent {
        self.lost = self.lost.saturating_add(count);
        let of = topic.as_deref().unwrap_or("a topic not known");
        *self
            .missing
            .entry(format!("messages of {of} were lost ({cause})"))
            .or_insert(0) += count;
        WatchEvent::Lost {
            topic,
            count,
            cause: cause.into(),
        }
    }

    /// Notes that something is missing.
    pub fn miss(&mut self, what: String) {
        *self.missing.entry(what).or_insert(0) += 1;
    }

    /// Tells and keeps an event.
    pub fn tell(&mut self, at_nanos: i64, event: WatchEvent) {
        let line = WatchLine {
            unix_secs: at_nanos as f64 / 1e9,
            event,
        };
        // The forms are plain data; a failure would be a mistake of ours.
        let json = serde_json::to_string(&line).unwrap_or_else(|error| error.to_string());
        if let Some(keeper) = &mut self.keeper {
            keeper.event(&json);
        }
        self.audience.told(at_nanos, &line.event, &json);
    }

    /// Messages that came.
    pub fn received(&self) -> u64 {
        self.received
    }

    /// Messages that are known to be lost.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// What is missing, a clause each.
    pub fn missing(&self) -> Vec<String> {
        let told = |(what, count): (&String, &u64)| match count {
            1 => what.clone(),
            count => format!("{what}: {count}"),
        };
        let mut missing: Vec<String> = self.missing.iter().map(told).collect();
        let failure = self.keeper.as_ref().and_then(Keeper::failure);
        missing.extend(failure.map(|what| format!("not all could be kept: {what}")));
        missing
    }

    /// Whether nothing that was sent is known or feared to be missing.
    pub fn is_complete(&self) -> bool {
        self.missing.is_empty()
    }
}

fn cause_name(cause: LossCause) -> &'static str {
    match cause {
        LossCause::Transport => "transport",
        LossCause::Overflow => "overflow",
        LossCause::Undecodable => "undecodable",
    }
}
