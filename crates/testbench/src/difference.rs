//! How far two recordings of the same test lie apart, signal by signal.
//!
//! Definition: for the rows of a topic whose times are in both recordings, the difference of a
//! number is `d = second - first`, in the unit of the first; the root mean square of `d` and its largest size are given.
//! An angle (a number in rad, deg or another unit of angles) is taken the shorter way round where both recordings have it within
//! the same turn, from -180 to 180 or from 0 to 360 degrees; beyond that it counts turns, as of a wheel, and is a number as
//! others. Truth values and names are equal or not, by their names: they have the share of rows in which they differ. Rows
//! where either has no value are counted apart. Numbers whose units measure different things are compared in no row.
//!
//! Source: elementary. Cost: one pass over both recordings.

use std::f64::consts::TAU;

use trace::units::{Conversion, Dimension, Unit};
use trace::{Channel, Field, FieldKind, Trace};

/// What a signal's values are to a comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compared {
    /// A number.
    Number,
    /// A number that is an angle.
    Angle,
    /// A truth value: the sums are those of rows in which it holds.
    Truth,
    /// A name, which has no mean.
    Name,
}

/// How far a signal lies apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// `/topic.field`.
    pub signal: String,
    /// The unit of its numbers; empty for truth values and names.
    pub unit: String,
    /// What its values are.
    pub kind: Compared,
    /// Rows with a number in both recordings.
    pub rows: u64,
    /// Rows with a number in one of them only, or with a time that the other has not.
    pub unmatched: u64,
    /// Sum of the squares of differences; of truth values and names the rows that differ.
    pub sum_of_squares: f64,
    /// The largest difference in size.
    pub largest: f64,
    /// When that was, in seconds.
    pub largest_at_secs: f64,
    /// Sums of the values in the first and the second recording, over the matched rows.
    pub sums: [f64; 2],
    /// The least and the greatest value of both, over the matched rows; without rows infinity and minus infinity.
    pub range: [f64; 2],
    /// Whether an angle was taken the shorter way round the other side, so that a mean of its numbers says nothing.
    pub wrapped: bool,
}

impl Difference {
    /// Root mean square of the differences; of truth values and names the share of rows that
    /// differ. `None` without rows.
    #[must_use]
    pub fn typical(&self) -> Option<f64> {
        let mean = self.sum_of_squares / self.rows as f64;
        let typical = match self.kind {
            Compared::Number | Compared::Angle => mean.sqrt(),
            Compared::Truth | Compared::Name => mean,
        };
        (self.rows > 0).then_some(typical)
    }

    /// The means of the values in the first and the second recording; `None` without rows and where a mean says nothing: of
    /// names, and of angles on both sides of where they begin again.
    #[must_use]
    pub fn means(&self) -> Option<[f64; 2]> {
        let has_mean = self.rows > 0 && !self.wrapped && self.kind != Compared::Name;
        has_mean.then(|| self.sums.map(|sum| sum / self.rows as f64))
    }

    /// How far the values of both recordings range.
    #[must_use]
    pub fn span(&self) -> f64 {
        (self.range[1] - self.range[0]).max(0.0)
    }

    /// Adds what another pair of recordings shows of the same signal.
    pub fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.unmatched += other.unmatched;
        self.sum_of_squares += other.sum_of_squares;
        self.sums = [0, 1].map(|index| self.sums[index] + other.sums[index]);
        self.range = [
            self.range[0].min(other.range[0]),
            self.range[1].max(other.range[1]),
        ];
        self.wrapped |= other.wrapped;
        if other.largest > self.largest {
            (self.largest, self.largest_at_secs) = (other.largest, other.largest_at_secs);
        }
    }
}

/// The differences of all signals that both recordings have, in the order of the first.
#[must_use]
pub fn differences(first: &Trace, second: &Trace) -> Vec<Difference> {
    let channels = first.channels.iter();
    channels
        .filter_map(|channel| Some((channel, second.channel(&channel.topic)?)))
        .flat_map(|(a, b)| of_channels(a, b))
        .collect()
}

fn of_channels(a: &Channel, b: &Channel) -> Vec<Difference> {
    let shared = a.fields.iter().enumerate();
    let shared: Vec<(usize, usize)> = shared
        .filter_map(|(index, field)| Some((index, b.field_index(&field.name)?)))
        .collect();
    let (pairs, unpaired) = paired_rows(&a.times_secs, &b.times_secs);
    shared
        .into_iter()
        .map(|(in_a, in_b)| {
            let fields = [&a.fields[in_a], &b.fields[in_b]];
            let mut found = Difference::none(format!("{}.{}", a.topic, fields[0].name), fields[0]);
            found.unmatched = unpaired;
            match Common::of(fields) {
                None => found.unmatched += 2 * pairs.len() as u64,
                Some(common) => {
                    for (row_a, row_b) in &pairs {
                        let values = [a.row(*row_a)[in_a], b.row(*row_b)[in_b]];
                        found.see(a.times_secs[*row_a], values, &common);
                    }
                }
            }
            found
        })
        .collect()
}

/// How the second recording's values become values of the first's kind.
struct Common {
    conversion: Conversion,
    /// The first's code of each of the second's names; more than there are where the first does not have it.
    codes: Option<Vec<f64>>,
    /// A whole turn, of an angle.
    turn: Option<f64>,
}

impl Common {
    /// `None` if the two cannot be compared.
    fn of([first, second]: [&Field; 2]) -> Option<Self> {
        let mut common = Self {
            conversion: Conversion::NONE,
            codes: None,
            turn: None,
        };
        match (&first.kind, &second.kind) {
            (FieldKind::Number, FieldKind::Number) => {
                if first.unit != second.unit {
                    let units: [Unit; 2] = [second.unit.parse().ok()?, first.unit.parse().ok()?];
                    common.conversion = units[0].conversion_to(&units[1])?;
                }
                common.turn = turn_in(&first.unit);
            }
            (FieldKind::Bool, FieldKind::Bool) => {}
            (FieldKind::Enumeration(own), FieldKind::Enumeration(others)) => {
                let code = |(place, name): (usize, &String)| {
                    let found = own.iter().position(|known| known == name);
                    found.unwrap_or(own.len() + place) as f64
                };
                common.codes = Some(others.iter().enumerate().map(code).collect());
            }
            (FieldKind::Number | FieldKind::Bool | FieldKind::Enumeration(_), _) => return None,
        }
        Some(common)
    }

    /// A value of the second recording as one of the first's.
    fn converted(&self, value: f64) -> f64 {
        match &self.codes {
            None => self.conversion.apply(value),
            Some(codes) => {
                let code = (value >= 0.0).then(|| codes.get(value as usize)).flatten();
                code.copied().unwrap_or(f64::NAN)
            }
        }
    }
}

/// A whole turn in a unit of angles.
fn turn_in(unit: &str) -> Option<f64> {
    let unit: Unit = unit.parse().ok()?;
    let radians = Unit::coherent(Dimension::ANGLE);
    Some(radians.conversion_to(&unit)?.apply(TAU))
}

impl Difference {
    /// Nothing seen yet of a field.
    fn none(signal: String, field: &Field) -> Self {
        let kind = match &field.kind {
            FieldKind::Number if turn_in(&field.unit).is_some() => Compared::Angle,
            FieldKind::Number => Compared::Number,
            FieldKind::Bool => Compared::Truth,
            FieldKind::Enumeration(_) => Compared::Name,
        };
        Self {
            signal,
            unit: match (kind, field.unit.as_str()) {
                (Compared::Truth | Compared::Name, _) => String::new(),
                (Compared::Number | Compared::Angle, "") => "1".to_owned(),
                (Compared::Number | Compared::Angle, unit) => unit.to_owned(),
            },
            kind,
            rows: 0,
            unmatched: 0,
            sum_of_squares: 0.0,
            largest: 0.0,
            largest_at_secs: 0.0,
            sums: [0.0; 2],
            range: [f64::INFINITY, f64::NEG_INFINITY],
            wrapped: false,
        }
    }

    fn see(&mut self, time_secs: f64, [first, second]: [f64; 2], common: &Common) {
        let second = common.converted(second);
        match (first.is_nan(), second.is_nan()) {
            (true, true) => return,
            (false, false) => {}
            _ => {
                self.unmatched += 1;
                return;
            }
        }
        let mut apart = (second - first).abs();
        if let Some(turn) = common.turn
            && in_one_turn(first, second, turn)
            && turn - apart < apart
        {
            apart = turn - apart;
            self.wrapped = true;
        }
        if matches!(self.kind, Compared::Truth | Compared::Name) {
            apart = f64::from(u8::from(first != second));
        }
        self.rows += 1;
        self.sum_of_squares += apart * apart;
        self.sums = [self.sums[0] + first, self.sums[1] + second];
        self.range = [
            self.range[0].min(first).min(second),
            self.range[1].max(first).max(second),
        ];
        if apart > self.largest {
            (self.largest, self.largest_at_secs) = (apart, time_secs);
        }
    }
}

/// Whether both are from minus to plus half a turn, or both from nothing to a whole one. Numbers of a recording may be
/// rounded, and so lie next to it.
fn in_one_turn(first: f64, second: f64, turn: f64) -> bool {
    let next = turn * 1e-6;
    let both = |low: f64, high: f64| {
        [first, second]
            .iter()
            .all(|it| (low - next..=high + next).contains(it))
    };
    both(-turn / 2.0, turn / 2.0) || both(0.0, turn)
}

/// Rows of the same time, each used once, and how many rows are left over. Times do not go back;
/// those of one instant are paired in their order.
fn paired_rows(a: &[f64], b: &[f64]) -> (Vec<(usize, usize)>, u64) {
    let (mut at_a, mut at_b) = (0, 0);
    let mut pairs = Vec::with_capacity(a.len().min(b.len()));
    while let (Some(time_a), Some(time_b)) = (a.get(at_a), b.get(at_b)) {
        match time_a.total_cmp(time_b) {
            std::cmp::Ordering::Less => at_a += 1,
            std::cmp::Ordering::Greater => at_b += 1,
            std::cmp::Ordering::Equal => {
                pairs.push((at_a, at_b));
                (at_a, at_b) = (at_a + 1, at_b + 1);
            }
        }
    }
    let left = a.len() + b.len() - 2 * pairs.len();
    (pairs, left as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trace::Field;

    fn recording(rows: &[(f64, [f64; 3])]) -> Trace {
        let mut trace = Trace::new();
        let fields = vec![
            Field::number("x", "m"),
            Field::number("yaw", "rad"),
            Field::bool("touching"),
        ];
        let channel = trace.add_channel("/a", fields).expect("a new topic");
        for (time, values) in rows {
            trace.channels[channel]
                .push(*time, values)
                .expect("in order");
        }
        trace
    }

    #[test]
    fn differences_are_those_computed_by_hand() {
        let first = recording(&[
            (0.0, [0.0, 3.0, 0.0]),
            (1.0, [1.0, 0.0, 1.0]),
            (2.0, [9.0, 0.0, 1.0]),
        ]);
        let second = recording(&[
            (0.0, [3.0, -3.0, 0.0]),
            (1.0, [5.0, 0.5, 0.0]),
            (3.0, [0.0; 3]),
        ]);
        let found = differences(&first, &second);
        let [x, yaw, touching] = found.as_slice() else {
            panic!("three signals");
        };
        assert_eq!(
            (x.rows, x.unmatched, x.largest, x.largest_at_secs),
            (2, 2, 4.0, 1.0)
        );
        assert_eq!(x.typical(), Some(f64::sqrt(f64::midpoint(9.0, 16.0))));
        assert_eq!(x.sums, [1.0, 8.0]);
        assert!((yaw.largest - 0.5).abs() < 1e-15);
        assert!((yaw.sum_of_squares - 0.25 - (TAU - 6.0).powi(2)).abs() < 1e-12);
        assert_eq!(touching.typical(), Some(0.5));
    }

    /// A recording with one signal.
    fn of_one(field: Field, values: &[f64]) -> Trace {
        let mut trace = Trace::new();
        let channel = trace.add_channel("/a", vec![field]).expect("a new topic");
        for (second, value) in values.iter().enumerate() {
            let pushed = trace.channels[channel].push(second as f64, &[*value]);
            pushed.expect("in order");
        }
        trace
    }

    fn one(first: (Field, &[f64]), second: (Field, &[f64])) -> Difference {
        let [first, second] = [first, second].map(|(field, values)| of_one(field, values));
        differences(&first, &second).remove(0)
    }

    #[test]
    fn names_are_compared_by_name_and_have_no_mean() {
        let own = Field::enumeration("mode", ["idle", "carry", "full"]);
        let other = Field::enumeration("mode", ["carry", "lost", "idle"]);
        // The same but at the third row, where the second has a name that the first does not know.
        let found = one((own.clone(), &[0.0, 1.0, 2.0]), (other, &[2.0, 0.0, 1.0]));
        assert_eq!(
            (found.rows, found.sum_of_squares, found.kind),
            (3, 1.0, Compared::Name)
        );
        assert_eq!((found.largest, found.largest_at_secs), (1.0, 2.0));
        assert_eq!(found.means(), None);
        let far = one((own.clone(), &[0.0]), (own, &[2.0]));
        assert_eq!(far.largest, 1.0);
    }

    #[test]
    fn an_angle_is_wrapped_within_a_turn_in_its_own_unit_and_counts_turns_beyond() {
        let degrees = || Field::number("yaw", "deg");
        let found = one((degrees(), &[179.0, 10.0]), (degrees(), &[-179.0, 12.0]));
        assert!((found.largest - 2.0).abs() < 1e-9 && found.kind == Compared::Angle);
        assert!(found.wrapped && found.means().is_none());
        // From nothing to a whole turn.
        let found = one((degrees(), &[1.0]), (degrees(), &[359.0]));
        assert!((found.largest - 2.0).abs() < 1e-9, "{found:?}");
        // A wheel that has turned once more.
        let found = one((degrees(), &[400.0]), (degrees(), &[760.0]));
        assert!((found.largest - 360.0).abs() < 1e-9 && found.means().is_some());
        // A number in rad/s or of no unit is none.
        for unit in ["rad/s", "1", "m"] {
            let field = || Field::number("yaw", unit);
            let found = one((field(), &[3.0]), (field(), &[-3.0]));
            assert_eq!((found.largest, found.kind), (6.0, Compared::Number));
        }
    }

    #[test]
    fn numbers_are_compared_in_the_unit_of_the_first_and_not_at_all_if_they_measure_other_things() {
        let field = |unit: &str| Field::number("x", unit);
        let found = one((field("m"), &[1.0]), (field("cm"), &[150.0]));
        assert!((found.largest - 0.5).abs() < 1e-12 && found.unit == "m");
        let turned = one((field("rad"), &[3.0]), (field("deg"), &[-180.0]));
        assert!((turned.largest - (std::f64::consts::PI - 3.0)).abs() < 1e-9);
        let apart = one((field("m"), &[1.0]), (field("s"), &[1.0]));
        assert_eq!((apart.rows, apart.unmatched), (0, 2));
        let apart = one((field("m"), &[1.0]), (Field::bool("x"), &[1.0]));
        assert_eq!((apart.rows, apart.unmatched), (0, 2));
    }

    #[test]
    fn a_number_in_one_recording_only_is_counted_apart() {
        let first = recording(&[(0.0, [f64::NAN, 0.0, 0.0]), (1.0, [f64::NAN, 0.0, 0.0])]);
        let second = recording(&[(0.0, [1.0, 0.0, 0.0]), (1.0, [f64::NAN, 0.0, 0.0])]);
        let x = &differences(&first, &second)[0];
        assert_eq!((x.rows, x.unmatched, x.typical()), (0, 1, None));
    }
}
