//! What signals an episode had: at moments to look at, and at any time.
//!
//! # Definition
//! Of the truth values and enumerations of a recording each combination that occurred is kept once, and of the numbers
//! the least and the greatest value, in all and within each combination. Of moments to look at, all values are kept as
//! they were then and at the last sample of an earlier time.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! Whether a condition ever held is answered yes where it did. Where there are too many combinations to keep all of
//! them, it may be answered yes where it did not ([`Moments::may_have_held`]).
//!
//! # Cost
//! One pass over the recording; memory and the journal's line are bounded by [`MOST_STATES`] and [`MOST_EXTREMES`].

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trace::units::{Dimension, Unit};
use trace::{FieldKind, Replay, SignalIndex, SignalValues, Trace};

/// Combinations that are kept of an episode, at most.
const MOST_STATES: usize = 256;

/// Extremes of numbers within combinations that are kept of an episode, at most.
const MOST_EXTREMES: usize = 2_000;

/// The least and the greatest value of a number, if it had one.
type Extreme = Option<[f32; 2]>;

/// The code of a value that is not known.
const UNKNOWN: u16 = u16::MAX;

/// A signal with names for its values: an enumeration or a truth value.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// `/topic.field`.
    pub signal: String,
    /// Its values by their codes.
    pub names: Vec<String>,
    /// Whether it is an enumeration.
    pub is_enumeration: bool,
}

/// A signal of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Number {
    /// `/topic.field`.
    pub signal: String,
    /// Its unit.
    pub unit: String,
    /// Whether that is one of time, so that it may be a clock.
    pub is_time: bool,
}

/// The signals of a bench's recordings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    /// Enumerations and truth values.
    pub named: Vec<Named>,
    /// Numbers.
    pub numbers: Vec<Number>,
}

impl Signals {
    /// Those of recordings with the channels of `layout`.
    pub fn of(layout: &Trace) -> Self {
        let mut signals = Self::default();
        for channel in &layout.channels {
            for field in &channel.fields {
                let signal = format!("{}.{}", channel.topic, field.name);
                let names = match &field.kind {
                    FieldKind::Number => {
                        let unit = field.unit.clone();
                        let parsed = unit.parse::<Unit>();
                        let is_time = parsed.is_ok_and(|it| it.dimension() == Dimension::TIME);
                        signals.numbers.push(Number {
                            signal,
                            unit,
                            is_time,
                        });
                        continue;
                    }
                    FieldKind::Bool => vec!["false".to_owned(), "true".to_owned()],
                    FieldKind::Enumeration(names) => names.clone(),
                };
                signals.named.push(Named {
                    signal,
                    names,
                    is_enumeration: field.kind != FieldKind::Bool,
                });
            }
        }
        signals
    }
}

/// The values of all signals at one time, in the order of [`Signals`].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Values {
    /// Codes of names; the greatest number where none is known.
    #[serde(rename = "n")]
    pub named: Vec<u16>,
    /// Numbers.
    #[serde(rename = "x")]
    pub numbers: Vec<Option<f32>>,
}

/// The values at a moment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// When, in seconds.
    pub secs: f64,
    /// The values then.
    pub then: Values,
    /// Those at the last sample of an earlier time.
    pub before: Values,
}

/// A combination of named values, with the extremes of numbers while it was there; these are left out where there would be too many.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    #[serde(rename = "n")]
    named: Vec<u16>,
    #[serde(rename = "x")]
    extremes: Vec<Extreme>,
    /// For how long it was there, in seconds.
    #[serde(rename = "s")]
    secs: f32,
}

/// What signals an episode had.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moments {
    /// Moments to look at.
    pub at: Vec<Moment>,
    /// Whether the recording is all there is, so that what did not happen in it did not happen.
    pub is_whole: bool,
    /// Names that the recording has and the bench's layout does not, by the place of their signal: their codes go on where
    /// those of the layout end. A simulator of others says in its recordings which names it has.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    more_names: BTreeMap<usize, Vec<String>>,
    states: Vec<State>,
    /// Of each named signal the codes that it had, where not all combinations are kept.
    seen: Vec<Vec<u16>>,
    extremes: Vec<Extreme>,
    /// The numbers in units of time that fell at least once, by their places: what never does is a clock.
    fell: Vec<usize>,
}

/// A condition on one signal, by its place among the named signals or the numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// It has this code.
    Named(usize, u16),
    /// It is this or more.
    AtLeast(usize, f32),
    /// It is this or less.
    AtMost(usize, f32),
}

impl Condition {
    /// Whether it holds of some values.
    pub fn holds(self, of: &Values) -> bool {
        let number = |place: usize| of.numbers.get(place).copied().flatten();
        match self {
            Self::Named(place, code) => of.named.get(place) == Some(&code),
            Self::AtLeast(place, least) => number(place).is_some_and(|it| it >= least),
            Self::AtMost(place, most) => number(place).is_some_and(|it| it <= most),
        }
    }

    /// Whether extremes reach it; true of names.
    fn is_reached(self, extremes: &[Extreme]) -> bool {
        let of = |place: usize| extremes.get(place).copied().flatten();
        match self {
            Self::Named(..) => true,
            Self::AtLeast(place, least) => of(place).is_some_and(|it| it[1] >= least),
            Self::AtMost(place, most) => of(place).is_some_and(|it| it[0] <= most),
        }
    }

    /// Whether it is one on a number.
    pub fn is_of_number(&self) -> bool {
        match self {
            Self::Named(..) => false,
            Self::AtLeast(..) | Self::AtMost(..) => true,
        }
    }

    fn is_named_in(self, named: &[u16]) -> bool {
        match self {
            Self::Named(place, code) => named.get(place) == Some(&code),
            Self::AtLeast(..) | Self::AtMost(..) => true,
        }
    }
}

impl Moments {
    /// Those of a recording, of which the values at some times are wanted.
    pub fn of(signals: &Signals, trace: &Trace, times: &[f64]) -> Self {
        let mut reading = Reading::new(signals, trace);
        let mut wanted: Vec<f64> = times.to_vec();
        wanted.sort_by(f64::total_cmp);
        wanted.dedup();
        let mut wanted = wanted.into_iter().peekable();
        let mut replay = Replay::new(trace);
        let mut at: Vec<Moment> = Vec::new();
        let (mut last_secs, mut before) = (f64::NEG_INFINITY, reading.now.clone());
        while let Some(sample) = replay.advance() {
            // What was wanted before this sample is as it was.
            while let Some(secs) = wanted.next_if(|secs| *secs < sample.time_secs) {
                at.push(reading.moment(secs, last_secs, &before));
            }
            if sample.time_secs > last_secs {
                before = reading.now.clone();
                last_secs = sample.time_secs;
            }
            reading.take(&replay, sample.time_secs);
        }
        for secs in wanted {
            at.push(reading.moment(secs, last_secs, &before));
        }
        reading.finish(at, trace.complete)
    }

    /// Puts the codes of names that the layout does not have as `signals` has them, which takes those that are new.
    pub fn join(&mut self, layout: &Signals, signals: &mut Signals) {
        for (place, names) in std::mem::take(&mut self.more_names) {
            let (Some(old), Some(known)) = (layout.named.get(place), signals.named.get_mut(place))
            else {
                continue;
            };
            let mut codes: Vec<u16> = Vec::new();
            for name in names {
                let at = known.names.iter().position(|it| *it == name);
                let at = at.unwrap_or_else(|| {
                    known.names.push(name);
                    known.names.len() - 1
                });
                codes.push(u16::try_from(at).unwrap_or(UNKNOWN));
            }
            let first = old.names.len();
            let renamed = |code: u16| {
                let extra = usize::from(code).checked_sub(first);
                extra.and_then(|it| codes.get(it).copied()).unwrap_or(code)
            };
            let moments = self.at.iter_mut();
            let moments = moments.flat_map(|it| [&mut it.then.named, &mut it.before.named]);
            for named in moments.chain(self.states.iter_mut().map(|it| &mut it.named)) {
                named[place] = renamed(named[place]);
            }
            for code in self.seen.get_mut(place).into_iter().flatten() {
                *code = renamed(*code);
            }
        }
    }

    /// The moment at a time, if it was wanted.
    pub fn at_secs(&self, secs: f64) -> Option<&Moment> {
        self.at.iter().find(|moment| moment.secs == secs)
    }

    /// Whether a number in a unit of time ever fell.
    pub fn has_fallen(&self, place: usize) -> bool {
        self.fell.contains(&place)
    }

    /// For which share of the episode conditions on names held together; 1 where that is not known.
    pub fn share_of_time(&self, conditions: &[Condition]) -> f64 {
        let is_known = self.seen.is_empty() && !conditions.iter().any(Condition::is_of_number);
        let secs = |states: &mut dyn Iterator<Item = &State>| -> f64 {
            states.map(|state| f64::from(state.secs)).sum()
        };
        let all = secs(&mut self.states.iter());
        if !is_known || all <= 0.0 {
            return 1.0;
        }
        let holds = |state: &&State| conditions.iter().all(|it| it.is_named_in(&state.named));
        (secs(&mut self.states.iter().filter(holds)) / all).min(1.0)
    }

    /// Whether conditions may have held together at any time; false only where they did not.
    pub fn may_have_held(&self, conditions: &[Condition]) -> bool {
        if !conditions.iter().all(|it| it.is_reached(&self.extremes)) {
            return false;
        }
        let in_state = |state: &State| {
            let reached =
                |it: &Condition| state.extremes.is_empty() || it.is_reached(&state.extremes);
            let mut all = conditions.iter();
            all.all(|it| it.is_named_in(&state.named) && reached(it))
        };
        if self.states.iter().any(in_state) {
            return true;
        }
        // Combinations that were not kept may have been any of the values that there were.
        let was_seen = |it: &Condition| match *it {
            Condition::Named(place, code) => self
                .seen
                .get(place)
                .is_some_and(|seen| seen.contains(&code)),
            Condition::AtLeast(..) | Condition::AtMost(..) => true,
        };
        !self.seen.is_empty() && conditions.iter().all(was_seen)
    }
}

/// A recording that is being read.
struct Reading<'s> {
    signals: &'s Signals,
    /// Where the recording has each named signal, and what its codes are in the bench's layout.
    named: Vec<Option<(SignalIndex, Vec<u16>)>>,
    more_names: BTreeMap<usize, Vec<String>>,
    numbers: Vec<Option<SignalIndex>>,
    now: Values,
    /// By the codes of names: extremes of numbers, and for how long it was there.
    states: BTreeMap<Vec<u16>, (Vec<Extreme>, f64)>,
    /// When the last sample was.
    last_secs: Option<f64>,
    overflow: bool,
    seen: Vec<Vec<u16>>,
    extremes: Vec<Extreme>,
    fell: Vec<usize>,
}

impl<'s> Reading<'s> {
    fn new(signals: &'s Signals, trace: &Trace) -> Self {
        let mut more_names: BTreeMap<usize, Vec<String>> = BTreeMap::new();
        let mut codes = |(at, named): (usize, &Named)| {
            let place = trace.signal(&named.signal)?;
            let own = match &trace.field(place)?.kind {
                FieldKind::Number => return None,
                FieldKind::Bool => return Some((place, vec![0, 1])),
                FieldKind::Enumeration(own) => own,
            };
            let code = |name: &String| {
                let found = named.names.iter().position(|known| known == name);
                let found = found.unwrap_or_else(|| {
                    let more = more_names.entry(at).or_default();
                    more.push(name.clone());
                    named.names.len() + more.len() - 1
                });
                u16::try_from(found).unwrap_or(UNKNOWN)
            };
            Some((place, own.iter().map(code).collect()))
        };
        let number = |number: &Number| {
            let place = trace.signal(&number.signal)?;
            (trace.field(place)?.kind == FieldKind::Number).then_some(place)
        };
        Self {
            signals,
            named: signals.named.iter().enumerate().map(&mut codes).collect(),
            more_names,
            numbers: signals.numbers.iter().map(number).collect(),
            now: Values {
                named: vec![UNKNOWN; signals.named.len()],
                numbers: vec![None; signals.numbers.len()],
            },
            states: BTreeMap::new(),
            last_secs: None,
            overflow: false,
            seen: vec![Vec::new(); signals.named.len()],
            extremes: vec![None; signals.numbers.len()],
            fell: Vec::new(),
        }
    }

    /// Takes a sample.
    fn take(&mut self, replay: &Replay<'_>, time_secs: f64) {
        // What was until now lasted until now.
        if let Some((_, secs)) = self.states.get_mut(&self.now.named) {
            *secs += self
                .last_secs
                .map_or(0.0, |last| (time_secs - last).max(0.0));
        }
        self.last_secs = Some(time_secs);
        for (value, place) in self.now.named.iter_mut().zip(&self.named) {
            let Some((place, codes)) = place else {
                continue;
            };
            let raw = replay.raw(*place);
            // A row that does not say it leaves it unknown.
            let index = (raw.is_finite() && raw >= 0.0).then_some(raw as usize);
            *value = index
                .and_then(|it| codes.get(it).copied())
                .unwrap_or(UNKNOWN);
        }
        let numbers = self.now.numbers.iter_mut().zip(&self.numbers);
        for (at, (value, place)) in numbers.enumerate() {
            let raw = place.map_or(f64::NAN, |place| replay.raw(place)) as f32;
            let has_fallen = value.is_some_and(|before| raw < before);
            if has_fallen && self.signals.numbers[at].is_time && !self.fell.contains(&at) {
                self.fell.push(at);
            }
            *value = raw.is_finite().then_some(raw);
        }
        for (seen, value) in self.seen.iter_mut().zip(&self.now.named) {
            if !seen.contains(value) {
                seen.push(*value);
            }
        }
        widen(&mut self.extremes, &self.now.numbers);
        let is_full = self.states.len() >= MOST_STATES;
        match self.states.get_mut(&self.now.named) {
            Some((extremes, _)) => widen(extremes, &self.now.numbers),
            None if !is_full => {
                let mut extremes = vec![None; self.now.numbers.len()];
                widen(&mut extremes, &self.now.numbers);
                self.states.insert(self.now.named.clone(), (extremes, 0.0));
            }
            None => self.overflow = true,
        }
    }

    /// The values at a time of which all samples were taken; `before` is what held before the last of them.
    fn moment(&self, secs: f64, last_secs: f64, before: &Values) -> Moment {
        let is_there = last_secs == secs;
        Moment {
            secs,
            then: self.now.clone(),
            before: if is_there {
                before.clone()
            } else {
                self.now.clone()
            },
        }
    }

    fn finish(self, at: Vec<Moment>, is_whole: bool) -> Moments {
        let keeps = self.states.len() * self.signals.numbers.len() <= MOST_EXTREMES;
        let states = self
            .states
            .into_iter()
            .map(|(named, (extremes, secs))| State {
                named,
                extremes: if keeps { extremes } else { Vec::new() },
                secs: secs as f32,
            });
        Moments {
            at,
            is_whole,
            more_names: self.more_names,
            states: states.collect(),
            seen: if self.overflow { self.seen } else { Vec::new() },
            extremes: self.extremes,
            fell: self.fell,
        }
    }
}

fn widen(extremes: &mut [Extreme], values: &[Option<f32>]) {
    for (extreme, value) in extremes.iter_mut().zip(values) {
        if let Some(value) = value {
            let [low, high] = extreme.unwrap_or([*value; 2]);
            *extreme = Some([low.min(*value), high.max(*value)]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trace::Field;

    /// A robot in a mode with a speed, at whole seconds.
    fn recording(rows: &[(f64, f64)]) -> Trace {
        let mut trace = Trace::new();
        let fields = vec![
            Field::enumeration("mode", ["idle", "carry", "full"]),
            Field::number("speed", "m/s"),
        ];
        let robot = trace.add_channel("/robot", fields).expect("a new topic");
        for (second, (mode, speed)) in rows.iter().enumerate() {
            let row = [*mode, *speed];
            trace.channels[robot]
                .push(second as f64, &row)
                .expect("in order");
        }
        trace
    }

    #[test]
    fn what_held_together_and_what_was_there_before_is_told() {
        let trace = recording(&[(0.0, 0.5), (1.0, 2.0), (2.0, 0.25)]);
        let signals = Signals::of(&trace);
        let moments = Moments::of(&signals, &trace, &[1.0, 1.5, 9.0]);
        let carries = Condition::Named(0, 1);
        assert!(moments.may_have_held(&[carries, Condition::AtLeast(0, 2.0)]));
        assert!(moments.may_have_held(&[Condition::AtMost(0, 0.25)]));
        // It was as slow, and it carried, but not at the same time.
        assert!(!moments.may_have_held(&[carries, Condition::AtMost(0, 0.5)]));
        assert!(!moments.may_have_held(&[Condition::Named(0, 3)]));
        let at = |secs: f64| moments.at_secs(secs).expect("it was wanted");
        assert!(carries.holds(&at(1.0).then) && !carries.holds(&at(1.0).before));
        assert_eq!(at(1.0).before.numbers, [Some(0.5)]);
        // Between samples what was there holds, then and before.
        assert!(carries.holds(&at(1.5).then) && carries.holds(&at(1.5).before));
        assert_eq!(at(9.0).then.numbers, [Some(0.25)]);
        assert!(moments.at_secs(0.0).is_none());
        // Each mode lasted for a second, but the last.
        assert_eq!(moments.share_of_time(&[carries]), 0.5);
        assert_eq!(moments.share_of_time(&[Condition::Named(0, 2)]), 0.0);
        assert_eq!(moments.share_of_time(&[Condition::AtLeast(0, 2.0)]), 1.0);
    }

    #[test]
    fn with_more_combinations_than_are_kept_nothing_that_held_is_denied() {
        let mut trace = Trace::new();
        let names: Vec<String> = (0..400).map(|it| format!("m{it}")).collect();
        let fields = vec![
            Field::enumeration("mode", names),
            Field::bool("on"),
            Field::number("x", "m"),
        ];
        let robot = trace.add_channel("/robot", fields).expect("a new topic");
        for second in 0..400_u32 {
            let row = [f64::from(second), f64::from(second % 2), f64::from(second)];
            let time_secs = f64::from(second);
            trace.channels[robot]
                .push(time_secs, &row)
                .expect("in order");
        }
        let moments = Moments::of(&Signals::of(&trace), &trace, &[]);
        assert!(moments.states.len() == MOST_STATES && !moments.seen.is_empty());
        for second in 0..400_u16 {
            let held = [
                Condition::Named(0, second),
                Condition::Named(1, second % 2),
                Condition::AtLeast(0, f32::from(second)),
            ];
            assert!(moments.may_have_held(&held), "{second}");
        }
        assert!(!moments.may_have_held(&[Condition::AtLeast(0, 400.0)]));
    }

    #[test]
    fn names_are_the_same_whatever_their_order_in_a_recording_and_new_ones_are_kept() {
        let layout = Signals::of(&recording(&[]));
        let mut signals = layout.clone();
        let mut of = |names: [&str; 3]| {
            let mut trace = Trace::new();
            let fields = vec![Field::enumeration("mode", names)];
            let robot = trace.add_channel("/robot", fields).expect("a new topic");
            for (second, mode) in [0.0, 1.0, 2.0].into_iter().enumerate() {
                let pushed = trace.channels[robot].push(second as f64, &[mode]);
                pushed.expect("in order");
            }
            let mut moments = Moments::of(&layout, &trace, &[1.0]);
            moments.join(&layout, &mut signals);
            moments
        };
        let (first, second) = (of(["full", "new", "idle"]), of(["newer", "new", "carry"]));
        assert_eq!(
            signals.named[0].names,
            ["idle", "carry", "full", "new", "newer"]
        );
        let had = |moments: &Moments| -> Vec<bool> {
            let held = |code: u16| moments.may_have_held(&[Condition::Named(0, code)]);
            (0..5).map(held).collect()
        };
        assert_eq!(had(&first), [true, false, true, true, false]);
        assert_eq!(had(&second), [false, true, false, true, true]);
        // Both had `new` at the moment that was wanted.
        for moments in [&first, &second] {
            let moment = moments.at_secs(1.0).expect("it was wanted");
            assert_eq!(moment.then.named, [3]);
        }
    }
}
