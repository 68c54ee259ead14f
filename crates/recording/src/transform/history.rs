//! The samples of one frame's pose in its parent, in order of time.

use std::collections::VecDeque;

use super::FrameId;
use super::pose::Transform;

/// The most samples kept for one frame, whatever the history: a bound for hostile recordings.
const MAX_SAMPLES: usize = 1 << 17;

/// One sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    pub time_secs: f64,
    pub parent: FrameId,
    pub pose_in_parent: Transform,
}

/// What was recorded of one frame.
#[derive(Debug, Clone, Default)]
pub(super) struct History {
    /// In increasing order of time; one sample if static.
    samples: VecDeque<Sample>,
    pub is_static: bool,
}

/// Where a time lies among the samples.
pub(super) enum Found {
    Pose {
        parent: FrameId,
        pose: Transform,
    },
    /// No sample at all: the frame is a root.
    Root,
    TooEarly {
        oldest_secs: f64,
    },
    TooLate {
        newest_secs: f64,
    },
    ParentChanges,
    /// Between samples that are too far apart.
    TooWide {
        gap_secs: f64,
    },
}

impl History {
    pub fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }

    pub fn newest(&self) -> Option<&Sample> {
        self.samples.back()
    }

    /// Whether a sample at `time_secs` is older than what is kept.
    pub fn is_too_old(&self, time_secs: f64, history_secs: f64) -> bool {
        !self.is_static
            && self
                .newest()
                .is_some_and(|newest| time_secs < newest.time_secs - history_secs)
    }

    /// Puts `sample` in its place. A second one for one time is left out, except of a static
    /// frame, where the later message counts. Gives whether it was taken.
    pub fn insert(&mut self, sample: Sample, history_secs: f64) -> bool {
        if self.is_static {
            self.samples.clear();
            self.samples.push_back(sample);
            return true;
        }
        let position = match self.newest() {
            Some(newest) if sample.time_secs <= newest.time_secs => self
                .samples
                .partition_point(|other| other.time_secs < sample.time_secs),
            _ => self.samples.len(),
        };
        let there = self.samples.get(position);
        if there.is_some_and(|there| there.time_secs == sample.time_secs) {
            return false;
        }
        self.samples.insert(position, sample);
        self.forget(history_secs);
        true
    }

    fn forget(&mut self, history_secs: f64) {
        let Some(newest) = self.samples.back().map(|sample| sample.time_secs) else {
            return;
        };
        // The last sample at or before the edge stays, so that all of the history is covered.
        while self.samples.len() > MAX_SAMPLES
            || self
                .samples
                .get(1)
                .is_some_and(|second| second.time_secs <= newest - history_secs)
        {
            self.samples.pop_front();
        }
    }

    /// The pose at a time; it is not interpolated between samples more than `bridged_secs` apart.
    pub fn at(&self, time_secs: f64, bridged_secs: f64) -> Found {
        let (Some(oldest), Some(newest)) = (self.samples.front(), self.samples.back()) else {
            return Found::Root;
        };
        let pose_of = |sample: &Sample| Found::Pose {
            parent: sample.parent,
            pose: sample.pose_in_parent,
        };
        if self.is_static || time_secs == newest.time_secs {
            return pose_of(newest);
        }
        if time_secs > newest.time_secs {
            return Found::TooLate {
                newest_secs: newest.time_secs,
            };
        }
        let after = self
            .samples
            .partition_point(|sample| sample.time_secs <= time_secs);
        let (Some(before), Some(next)) = (
            after
                .checked_sub(1)
                .and_then(|index| self.samples.get(index)),
            self.samples.get(after),
        ) else {
            return Found::TooEarly {
                oldest_secs: oldest.time_secs,
            };
        };
        if before.time_secs == time_secs {
            return pose_of(before);
        }
        if before.parent != next.parent {
            return Found::ParentChanges;
        }
        let gap_secs = next.time_secs - before.time_secs;
        // Times in seconds are rounded.
        if gap_secs > bridged_secs + 1e-9 {
            return Found::TooWide { gap_secs };
        }
        let u = (time_secs - before.time_secs) / (next.time_secs - before.time_secs);
        Found::Pose {
            parent: before.parent,
            pose: before.pose_in_parent.interpolate(&next.pose_in_parent, u),
        }
    }
}
