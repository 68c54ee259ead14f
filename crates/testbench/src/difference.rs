//! How far two recordings of the same test lie apart, signal by signal.
//!
//! Definition: for the rows of a topic whose times are in both recordings, the difference of a
//! number is `d = second - first`, of an angle within a turn the one on the shorter way round; the
//! root mean square of `d` and its largest size are given. Truth values and names have the share of
//! rows in which they differ. Rows where either has no number are counted apart.
//!
//! Source: elementary. Cost: one pass over both recordings.

use std::f64::consts::{PI, TAU};

use trace::{Channel, FieldKind, Trace};

/// How far a signal lies apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// `/topic.field`.
    pub signal: String,
    /// The unit of its numbers; empty for truth values and names.
    pub unit: String,
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
}

impl Difference {
    /// Root mean square of the differences; of truth values and names the share of rows that
    /// differ. `None` without rows.
    #[must_use]
    pub fn typical(&self) -> Option<f64> {
        let mean = self.sum_of_squares / self.rows as f64;
        let is_number = !self.unit.is_empty();
        (self.rows > 0).then_some(if is_number { mean.sqrt() } else { mean })
    }

    /// Adds what another pair of recordings shows of the same signal.
    pub fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.unmatched += other.unmatched;
        self.sum_of_squares += other.sum_of_squares;
        self.sums = [0, 1].map(|index| self.sums[index] + other.sums[index]);
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
            let field = &a.fields[in_a];
            let is_number = field.kind == FieldKind::Number;
            let mut found = Difference {
                signal: format!("{}.{}", a.topic, field.name),
                unit: match (is_number, field.unit.as_str()) {
                    (true, "") => "1".to_owned(),
                    (true, unit) => unit.to_owned(),
                    (false, _) => String::new(),
                },
                rows: 0,
                unmatched: unpaired,
                sum_of_squares: 0.0,
                largest: 0.0,
                largest_at_secs: 0.0,
                sums: [0.0; 2],
            };
            for (row_a, row_b) in &pairs {
                let values = [a.row(*row_a)[in_a], b.row(*row_b)[in_b]];
                found.see(a.times_secs[*row_a], values);
            }
            found
        })
        .collect()
}

impl Difference {
    fn see(&mut self, time_secs: f64, [first, second]: [f64; 2]) {
        match (first.is_nan(), second.is_nan()) {
            (true, true) => return,
            (false, false) => {}
            _ => {
                self.unmatched += 1;
                return;
            }
        }
        let mut apart = (second - first).abs();
        let is_angle = self.unit == "rad" && first.abs() <= PI && second.abs() <= PI;
        if is_angle {
            apart = apart.min(TAU - apart);
        }
        if self.unit.is_empty() {
            apart = f64::from(u8::from(first != second));
        }
        self.rows += 1;
        self.sum_of_squares += apart * apart;
        self.sums = [self.sums[0] + first, self.sums[1] + second];
        if apart > self.largest {
            (self.largest, self.largest_at_secs) = (apart, time_secs);
        }
    }
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

    #[test]
    fn a_number_in_one_recording_only_is_counted_apart() {
        let first = recording(&[(0.0, [f64::NAN, 0.0, 0.0]), (1.0, [f64::NAN, 0.0, 0.0])]);
        let second = recording(&[(0.0, [1.0, 0.0, 0.0]), (1.0, [f64::NAN, 0.0, 0.0])]);
        let x = &differences(&first, &second)[0];
        assert_eq!((x.rows, x.unmatched, x.typical()), (0, 1, None));
    }
}
