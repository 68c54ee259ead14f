//! Columns of tables in which no value was ever written.
//!
//! Nothing in such a column says whether it would hold numbers or truth values; readers take it for
//! numbers. A proposition that needs a truth value there is not wrong for it: the signal is missing
//! throughout. So each such column is taken for truth values where that makes the propositions fit.

use super::Judges;
use std::cmp::Reverse;
use trace::{FieldKind, Trace};

impl Judges<'_> {
    /// The layout with those of `valueless` (`/topic.field`) taken for truth values which the
    /// propositions take for such. A field with a unit stays a number.
    pub fn with_valueless(&self, layout: &Trace, valueless: &[String]) -> Trace {
        let mut fitting = layout.clone();
        let mut misfits = self.misfits(&fitting);
        for name in valueless {
            let Some(at) = fitting.signal(name) else {
                continue;
            };
            let field = &mut fitting.channels[at.channel].fields[at.field];
            if !field.unit.is_empty() || field.kind != FieldKind::Number {
                continue;
            }
            field.kind = FieldKind::Bool;
            let now = self.misfits(&fitting);
            if now < misfits {
                misfits = now;
            } else {
                fitting.channels[at.channel].fields[at.field].kind = FieldKind::Number;
            }
        }
        fitting
    }

    /// How many propositions and clocks do not fit, and how far into them the first faults stand:
    /// less is better.
    fn misfits(&self, layout: &Trace) -> (usize, Reverse<usize>) {
        let predicates = self.predicates.iter().map(|it| it.bind(layout).err());
        let clocks = self.clocks.iter().map(|it| it.bind(layout).err());
        let errors: Vec<_> = predicates.chain(clocks).flatten().collect();
        let depth = errors.iter().map(|error| error.span.start).sum();
        (errors.len(), Reverse(depth))
    }
}

/// The signals of a trace that are judged and have no value at all.
pub fn valueless_of(trace: &Trace, judges: &Judges<'_>) -> Vec<String> {
    let judged = judges.signals();
    let channels = trace.channels.iter();
    let fields = channels.flat_map(|channel| {
        let places = channel.fields.iter().enumerate();
        places.filter_map(move |(place, field)| {
            let is_missing = (0..channel.len()).all(|row| channel.row(row)[place].is_nan());
            is_missing.then(|| format!("{}.{}", channel.topic, field.name))
        })
    });
    fields.filter(|name| judged.contains(name)).collect()
}
