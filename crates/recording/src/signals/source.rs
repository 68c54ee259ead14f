//! The sources of a stream, and the queue of what they have ready.

use std::collections::VecDeque;

use super::frames::FrameSource;
use super::linear::Samples;
use super::plan::{Output, SourcePlan};
use crate::topic_map::Interpolation;
use crate::transform::TransformBuffer;

/// What is given out.
#[derive(Debug)]
pub(super) enum Ready {
    /// A row, and how far its log time is ahead of its time.
    Row {
        source: usize,
        slot: usize,
        behind_nanos: i64,
    },
    /// Linearly interpolated values of a source end here. At the end of the stream that is no sample,
    /// since whether anything comes later depends on other signals.
    Touch { source: usize, is_sample: bool },
}

/// Rows of one width, kept without allocating anew for each.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub width: usize,
    pub values: Vec<f64>,
    pub free: Vec<usize>,
}

impl Rows {
    pub fn keep(&mut self, row: &[f64]) -> usize {
        let slot = self.free.pop().unwrap_or_else(|| {
            let slot = self.values.len() / self.width.max(1);
            self.values.resize(self.values.len() + self.width, f64::NAN);
            slot
        });
        let from = slot * self.width;
        self.values[from..from + self.width].copy_from_slice(&row[..self.width]);
        slot
    }

    pub fn get(&self, slot: usize) -> &[f64] {
        &self.values[slot * self.width..(slot + 1) * self.width]
    }
}

/// The state of one source.
#[derive(Debug)]
pub(super) struct Source {
    pub plan: SourcePlan,
    /// As they arrive.
    pub arrived: Rows,
    /// As they are given out.
    pub ready: Rows,
    pub frames: Option<FrameSource>,
    /// If any output is linear.
    pub samples: Option<Samples>,
    /// The widest gap between samples that is bridged, and whether the one behind the newest
    /// sample is known to be wider.
    pub bridged_nanos: i64,
    pub gap_seen: bool,
    /// For each output, when its value becomes too old; `i64::MAX` if it has none or never does.
    pub expiry_nanos: Vec<i64>,
}

/// What is ready, in order of time and then of arrival.
#[derive(Debug, Default)]
pub(super) struct Outgoing {
    pub queue: VecDeque<(i64, Ready)>,
}

impl Outgoing {
    /// Puts `item` behind everything of its time or earlier; nearly always at the end.
    pub fn push(&mut self, time_nanos: i64, item: Ready) {
        let place = match self.queue.back() {
            Some((last, _)) if *last > time_nanos => {
                self.queue.partition_point(|(time, _)| *time <= time_nanos)
            }
            _ => self.queue.len(),
        };
        self.queue.insert(place, (time_nanos, item));
    }

    pub fn len(&self) -> usize {
        self.queue.len()
    }

    pub fn front_nanos(&self) -> Option<i64> {
        self.queue.front().map(|(time, _)| *time)
    }

    /// Whether the next is of `time_nanos` or earlier, and a row of one of these sources.
    pub fn is_row_of(&self, time_nanos: i64, sources: &[bool]) -> bool {
        matches!(self.queue.front(), Some((time, Ready::Row { source, .. }))
            if *time <= time_nanos && sources.get(*source).is_some_and(|it| *it))
    }

    pub fn pop_at(&mut self, time_nanos: i64) -> Option<Ready> {
        if self.front_nanos()? > time_nanos {
            return None;
        }
        self.queue.pop_front().map(|(_, item)| item)
    }
}

impl Source {
    pub fn new(plan: SourcePlan, frames: &mut TransformBuffer) -> Self {
        let rows = |width| Rows {
            width,
            ..Rows::default()
        };
        let columns = plan.outputs.iter().map(|output| output.column + 1);
        let ready_width = columns.max().unwrap_or(0);
        Source {
            arrived: rows(plan.width),
            ready: rows(ready_width),
            frames: FrameSource::new(&plan, frames),
            samples: plan.is_linear().then(Samples::default),
            bridged_nanos: plan.bridged_nanos(),
            gap_seen: false,
            expiry_nanos: vec![i64::MAX; plan.outputs.len()],
            plan,
        }
    }

    /// A row is ready: it is a sample of what is interpolated, and an instant.
    pub fn give(
        &mut self,
        index: usize,
        time_nanos: i64,
        (slot, behind_nanos): (usize, i64),
        outgoing: &mut Outgoing,
    ) {
        self.look_for_gap(index, time_nanos, true, outgoing);
        if let Some(samples) = &mut self.samples {
            samples.push(time_nanos, self.ready.get(slot));
            self.gap_seen = false;
        }
        outgoing.push(
            time_nanos,
            Ready::Row {
                source: index,
                slot,
                behind_nanos,
            },
        );
    }

    /// If no sample can come before `known_nanos`, and that is too far from the newest one, values
    /// are missing right behind that, which is an instant.
    pub fn look_for_gap(
        &mut self,
        index: usize,
        known_nanos: i64,
        is_sample: bool,
        outgoing: &mut Outgoing,
    ) {
        let newest = self.samples.as_ref().and_then(Samples::newest_nanos);
        if let Some(newest) = newest
            && !self.gap_seen
            && known_nanos.saturating_sub(newest) > self.bridged_nanos
        {
            self.gap_seen = true;
            let touch = Ready::Touch {
                source: index,
                is_sample,
            };
            outgoing.push(newest.saturating_add(1), touch);
        }
    }

    /// Up to which time all rows of this source have come, if all items up to `now_nanos` have.
    pub fn known_nanos(&self, now_nanos: i64) -> i64 {
        let waiting = self.frames.as_ref().and_then(FrameSource::waiting_since);
        waiting.map_or(now_nanos, |since| since.saturating_sub(1))
    }
}

/// The outputs that are interpolated.
pub(super) fn linear(outputs: &[Output]) -> impl Iterator<Item = &Output> {
    let is_linear = |output: &&Output| output.interpolation == Interpolation::Linear;
    outputs.iter().filter(is_linear)
}
