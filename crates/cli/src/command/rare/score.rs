//! How near a run comes to an event, while it runs.
//!
//! A score is a quantity over signals, of which the greatest value so far
//! counts, or a proposition, of which the longest time counts during which it
//! held without interruption. The event is a score of at least the limit.

use super::file::{EventText, quoted};
use crate::problem::{Problem, Source};
use crate::study::Study;
use testbench::{Control, Watch};
use trace::{BoundPredicate, BoundQuantity, SignalIndex, Snapshot, Trace};

/// Times that differ by less are equal: half of a step of the fastest rates.
const SAME_SECS: f64 = 1e-6;

/// A score bound to what the bench records.
pub struct Score {
    kind: Kind,
    channels: Vec<usize>,
    layout: Trace,
    /// Rungs of the ladder, the last being the limit; rising.
    pub rungs: Vec<f64>,
}

enum Kind {
    Greatest(BoundQuantity),
    Longest(BoundPredicate),
}

/// A score so far; a saved run is continued with a copy of it.
#[derive(Clone, Debug)]
pub struct Follower {
    snapshot: Snapshot,
    since_secs: Option<f64>,
    /// The score so far.
    pub highest: f64,
}

impl Score {
    /// Binds the event's score to the channels of `layout`.
    pub fn new(
        study: &Study,
        source: &Source,
        event: &EventText,
        layout: Trace,
    ) -> Result<Self, Problem> {
        let words = &study.vocabulary.signals;
        let wrong = |text: &str, reason: String| {
            let message = format!("event `{}`: {reason}", event.name);
            Problem::new("bad-predicate", message)
                .at(source, quoted(source, text))
                .remedy("correct the score: signals are written /topic.field, words are the vocabulary's")
        };
        let kind = match (&event.greatest, &event.longest) {
            (Some(text), _) => Kind::Greatest(
                words
                    .quantity(text)
                    .and_then(|q| q.bind(&layout))
                    .map_err(|error| wrong(text, error.kind.to_string()))?,
            ),
            (_, Some(text)) => Kind::Longest(
                words
                    .predicate(text)
                    .and_then(|p| p.bind(&layout))
                    .map_err(|error| wrong(text, error.kind.to_string()))?,
            ),
            // Refused when the file is read.
            (None, None) => return Err(wrong(&event.name, "it has no score".into())),
        };
        let signals = match &kind {
            Kind::Greatest(quantity) => quantity.signals(),
            Kind::Longest(predicate) => predicate.signals(),
        };
        Ok(Self {
            channels: signals.iter().map(|it: &SignalIndex| it.channel).collect(),
            kind,
            layout,
            rungs: event.rungs(),
        })
    }

    /// Before a run.
    pub fn start(&self) -> Follower {
        Follower {
            snapshot: Snapshot::new(&self.layout),
            since_secs: None,
            highest: f64::NEG_INFINITY,
        }
    }

    /// How many rungs a score has reached.
    pub fn rung(&self, score: f64) -> usize {
        let slack = match self.kind {
            Kind::Greatest(_) => 0.0,
            Kind::Longest(_) => SAME_SECS,
        };
        self.rungs.partition_point(|rung| score + slack >= *rung)
    }

    fn take(&self, follower: &mut Follower, time_secs: f64) {
        let now = match &self.kind {
            Kind::Greatest(quantity) => quantity.eval(&follower.snapshot),
            Kind::Longest(predicate) => match predicate.eval(&follower.snapshot) {
                Some(true) => {
                    let since = *follower.since_secs.get_or_insert(time_secs);
                    Some(time_secs - since)
                }
                _ => {
                    follower.since_secs = None;
                    None
                }
            },
        };
        if let Some(score) = now.filter(|score| !score.is_nan()) {
            follower.highest = follower.highest.max(score);
        }
    }
}

/// Follows a score along a run, which ends once the limit is reached.
pub struct Following<'a> {
    pub score: &'a Score,
    pub follower: &'a mut Follower,
    pub until_secs: f64,
    /// What kept it from being followed.
    pub problem: Option<Problem>,
}

impl Watch for Following<'_> {
    fn row(&mut self, topic: usize, time_secs: f64, values: &[f64]) -> Control {
        if !self.score.channels.contains(&topic) {
            return Control::Continue;
        }
        if time_secs > self.until_secs + SAME_SECS {
            return Control::Finish;
        }
        if let Err(error) = self.follower.snapshot.update(topic, time_secs, values) {
            self.problem = Some(Problem::new("bad-recording", error.to_string()));
            return Control::Finish;
        }
        self.score.take(self.follower, time_secs);
        match self.score.rung(self.follower.highest) >= self.score.rungs.len() {
            true => Control::Finish,
            false => Control::Continue,
        }
    }
}
