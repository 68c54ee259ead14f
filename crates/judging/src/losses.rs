//! What of a trace was lost, and what is known of the signals then.
//!
//! # Definition
//! A loss is a span of time in which messages of any topic may be missing. From its beginning on no value
//! is known, until its signal has a sample again. A loss of which it is not known where it is may be
//! anywhere.

use super::session::News;
use trace::{SignalIndex, SignalValues, Trace};

/// What may be missing within a trace.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Losses {
    /// Spans of time in which samples may be missing, in seconds, in order of their beginnings.
    pub spans: Vec<(f64, f64)>,
    /// Whether samples may be missing anywhere.
    pub unlocated: bool,
    /// The signals whose values can become too old, which have spans of their own.
    pub can_drop: Vec<SignalIndex>,
}

impl Losses {
    /// Whether a formula that reads these signals has to be ready for a loss.
    pub fn is_possible(&self, reads: &[SignalIndex]) -> bool {
        !self.spans.is_empty() || reads.iter().any(|signal| self.can_drop.contains(signal))
    }
}

/// What was lost, as far as a trace has been judged.
#[derive(Clone, Debug)]
pub(super) struct Lost {
    pub spans: Vec<(f64, f64)>,
    pub unlocated: bool,
    /// For each signal, whether its value is not known any more.
    pub masked: Vec<Vec<bool>>,
    last_secs: f64,
}

impl Lost {
    pub fn new(losses: &Losses, layout: &Trace) -> Self {
        let channels = layout.channels.iter();
        Self {
            spans: losses.spans.clone(),
            unlocated: losses.unlocated,
            masked: channels.map(|it| vec![false; it.fields.len()]).collect(),
            last_secs: f64::NEG_INFINITY,
        }
    }

    pub fn is_nothing(&self) -> bool {
        self.spans.is_empty() && !self.unlocated
    }

    /// Forgets the values of all signals that were lost before a sample, but for those that it brings;
    /// gives whether any is unknown.
    pub fn mask(&mut self, time_secs: f64, news: &News<'_>) -> bool {
        if self.spans.is_empty() {
            return false;
        }
        let last_secs = std::mem::replace(&mut self.last_secs, time_secs);
        let is_lost = |span: &(f64, f64)| span.0 <= time_secs && span.1 >= last_secs;
        if last_secs < time_secs && self.spans.iter().any(is_lost) {
            self.masked.iter_mut().for_each(|fields| fields.fill(true));
        }
        for (channel, fields) in self.masked.iter_mut().enumerate() {
            for (field, masked) in fields.iter_mut().enumerate() {
                *masked &= !news.is_sampled(SignalIndex { channel, field });
            }
        }
        self.masked.iter().flatten().any(|it| *it)
    }
}

/// The values of signals of which some are not known.
pub(super) struct Masked<'v, V> {
    pub values: &'v V,
    pub lost: Option<&'v Vec<Vec<bool>>>,
}

impl<V: SignalValues> SignalValues for Masked<'_, V> {
    fn raw(&self, signal: SignalIndex) -> f64 {
        let is_lost = self
            .lost
            .and_then(|lost| lost.get(signal.channel)?.get(signal.field));
        match is_lost {
            Some(true) => f64::NAN,
            _ => self.values.raw(signal),
        }
    }
}
