//! The line of time: samples in discrete time, places in dense time, and which lie in whose window.

use std::ops::Range;

use super::Record;
use crate::clock::{nanos_since, resolution_nanos, rounded, tolerance_secs};
use crate::formula::ast::{Interval, Window};
use crate::formula::settings::{Ending, TimeModel};

/// The times that were kept, as whole numbers.
pub(super) struct Line<'r> {
    pub(super) record: &'r Record,
    pub(super) time: TimeModel,
    pub(super) ending: Ending,
    /// In dense time the place of each sample that was kept.
    pub(super) places: Vec<i64>,
}

/// The points of a window, in the order in which the operator looks at them; `last < first` if none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reach {
    pub(super) first: i64,
    pub(super) last: i64,
    /// Whether it goes on beyond what was kept.
    pub(super) open: bool,
}

impl<'r> Line<'r> {
    pub(super) fn new(record: &'r Record, time: TimeModel, ending: Ending) -> Self {
        let origin_secs = record.first_secs.unwrap_or(0.0);
        let mut last_nanos = None;
        let place = |time_secs: &f64| {
            last_nanos = nanos_since(origin_secs, *time_secs, last_nanos).or(last_nanos);
            2 * last_nanos.unwrap_or(0)
        };
        Line {
            places: match time {
                TimeModel::Discrete => Vec::new(),
                TimeModel::Dense => record.times_secs.iter().map(place).collect(),
            },
            record,
            time,
            ending,
        }
    }

    /// The first point. In discrete time samples are numbered from the first that was kept.
    pub(super) fn first(&self) -> i64 {
        0
    }

    /// One more than the last point.
    pub(super) fn end(&self) -> i64 {
        match self.time {
            TimeModel::Discrete => self.record.times_secs.len() as i64,
            TimeModel::Dense => self.places.last().map_or(0, |last| last + 1),
        }
    }

    /// Whether there were earlier samples that were not kept. In dense time they are points, at
    /// which all is unknown.
    pub(super) fn is_cut(&self) -> bool {
        self.time == TimeModel::Discrete && self.record.forgotten > 0
    }

    pub(super) fn is_dense(&self) -> bool {
        self.time == TimeModel::Dense
    }

    /// The kept samples whose values hold somewhere from one point to another.
    pub(super) fn samples(&self, first: i64, last: i64) -> Range<usize> {
        if !self.is_dense() {
            let number = |point: i64| {
                usize::try_from(point)
                    .unwrap_or(0)
                    .min(self.record.times_secs.len())
            };
            return number(first)..number(last + 1);
        }
        let begun = |point: i64| self.places.partition_point(|&place| place <= point);
        begun(first).saturating_sub(1)..begun(last)
    }

    /// Where a point begins, in seconds of the trace's clock.
    pub(super) fn begins_secs(&self, point: i64) -> f64 {
        self.secs(point, point.div_euclid(2))
    }

    /// Where it ends.
    pub(super) fn ends_secs(&self, point: i64) -> f64 {
        self.secs(point, (point + 1).div_euclid(2))
    }

    fn secs(&self, sample: i64, tick: i64) -> f64 {
        let times_secs = &self.record.times_secs;
        if self.is_dense() {
            // The time of a sample is given back as it came.
            return match self.places.binary_search(&(2 * tick)) {
                Ok(at) => times_secs[at],
                Err(_) => self.record.first_secs.unwrap_or(0.0) + tick as f64 / 1e9,
            };
        }
        let at = usize::try_from(sample)
            .unwrap_or(0)
            .min(times_secs.len().saturating_sub(1));
        times_secs.get(at).copied().unwrap_or(0.0)
    }

    /// What `interval` reaches in the future of a point.
    pub(super) fn ahead(&self, interval: &Interval, point: i64) -> Option<Reach> {
        let end = self.end();
        Some(match self.distances(interval)? {
            Distances::Points { low, high } => {
                let last = high.map_or(i64::MAX, |high| point + high);
                Reach {
                    first: point + low,
                    last: last.min(end - 1),
                    open: last > end - 1,
                }
            }
            Distances::Secs { low, high } => {
                let first = self.partition(point, end, |later| self.is_before(point, later, low));
                let over = self.partition(point, end, |later| self.is_before(point, later, high));
                let within = over < end && !self.is_beyond(point, over, high);
                Reach {
                    first,
                    last: if within { over } else { over - 1 },
                    open: over == end,
                }
            }
        })
    }

    /// What `interval` reaches in the past of a point, backwards.
    pub(super) fn behind(&self, interval: &Interval, point: i64) -> Option<Reach> {
        Some(match self.distances(interval)? {
            Distances::Points { low, high } => {
                let last = high.map_or(i64::MIN, |high| point - high);
                Reach {
                    first: point - low,
                    last: last.max(self.first()),
                    open: self.is_cut() && last < 0,
                }
            }
            Distances::Secs { low, high } => {
                // Earlier points are in the window from the first that is not too early, up to the
                // last that is not too late.
                let first =
                    self.partition(0, point + 1, |earlier| !self.is_before(earlier, point, low));
                let last = self.partition(0, point + 1, |earlier| {
                    !self.contains_end(earlier, point, high)
                });
                Reach {
                    first: first - 1,
                    last,
                    open: self.is_cut() && last == 0,
                }
            }
        })
    }

    fn partition(&self, from: i64, to: i64, holds: impl Fn(i64) -> bool) -> i64 {
        let (mut low, mut high) = (from, to);
        while low < high {
            let middle = low + (high - low) / 2;
            if holds(middle) {
                low = middle + 1
            } else {
                high = middle
            }
        }
        low
    }

    /// Whether the distance of two samples is clearly less than `secs`.
    fn is_before(&self, earlier: i64, later: i64, secs: f64) -> bool {
        self.secs(later, 0) - self.secs(earlier, 0) < secs - tolerance_secs(self.secs(later, 0))
    }

    fn is_beyond(&self, earlier: i64, later: i64, secs: f64) -> bool {
        self.secs(later, 0) - self.secs(earlier, 0) > secs + tolerance_secs(self.secs(later, 0))
    }

    /// Whether `later` is not after the end of the window of `earlier`.
    fn contains_end(&self, earlier: i64, later: i64, high: f64) -> bool {
        let over_before = later > earlier && !self.is_before(earlier, later - 1, high);
        !over_before && !self.is_beyond(earlier, later, high)
    }

    fn distances(&self, interval: &Interval) -> Option<Distances> {
        Some(match (interval.window(self.time).ok()?, self.time) {
            (Window::Samples { low, high }, _) => Distances::Points {
                low: low as i64,
                high: high.map(|high| high as i64),
            },
            (
                Window::Seconds {
                    low_secs,
                    high_secs,
                },
                TimeModel::Discrete,
            ) => Distances::Secs {
                low: low_secs,
                high: high_secs,
            },
            (
                Window::Seconds {
                    low_secs,
                    high_secs,
                },
                TimeModel::Dense,
            ) => {
                let resolution = resolution_nanos(self.record.first_secs.unwrap_or(0.0));
                let places = |secs: f64| 2 * rounded((secs * 1e9).round() as i64, resolution);
                Distances::Points {
                    low: places(low_secs),
                    high: high_secs.is_finite().then(|| places(high_secs)),
                }
            }
        })
    }
}

enum Distances {
    Points { low: i64, high: Option<i64> },
    Secs { low: f64, high: f64 },
}
