//! The tree of frames, with the recent history of each.

use std::collections::BTreeMap;

use super::error::{LookupError, TransformProblem};
use super::history::{Found, History, Sample};
use super::pose::Transform;

/// A frame of one [`TransformBuffer`], found by name once and then used without the name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct FrameId(u32);

impl FrameId {
    /// The number of the frame, for keeping it among other numbers.
    pub(crate) fn number(self) -> u32 {
        self.0
    }

    /// The frame of a number that [`FrameId::number`] gave.
    pub(crate) fn from_number(number: u32) -> Self {
        FrameId(number)
    }
}

/// The transforms between frames over the last seconds.
#[derive(Debug, Clone)]
pub struct TransformBuffer {
    names: Vec<String>,
    ids: BTreeMap<String, FrameId>,
    histories: Vec<History>,
    history_secs: f64,
    bridged_secs: f64,
    repeated: u64,
    /// Changes with every change of a parent, so that users can keep what depends on the tree.
    shape: u64,
}

/// The way from a frame up to its root at one time.
struct Climb {
    /// The pose of the frame in each of its ancestors, beginning with itself.
    poses: Vec<(FrameId, Transform)>,
    /// Why it could not go on, if not because the last one is a root.
    stopped: Option<LookupError>,
}

impl TransformBuffer {
    /// An empty buffer that keeps `history_secs` seconds of each moving frame.
    #[must_use]
    pub fn new(history_secs: f64) -> Self {
        TransformBuffer {
            names: Vec::new(),
            ids: BTreeMap::new(),
            histories: Vec::new(),
            history_secs: if history_secs >= 0.0 {
                history_secs
            } else {
                0.0
            },
            bridged_secs: f64::INFINITY,
            repeated: 0,
            shape: 0,
        }
    }

    /// Interpolates between samples that are at most `secs` apart; without this, between any.
    pub fn bridge(&mut self, secs: f64) {
        self.bridged_secs = secs;
    }

    /// The frame called `name`, which need not have appeared in a transform yet. A leading slash,
    /// as ROS 1 sometimes writes it, does not count.
    pub fn frame(&mut self, name: &str) -> FrameId {
        let name = name.strip_prefix('/').unwrap_or(name);
        if let Some(&id) = self.ids.get(name) {
            return id;
        }
        let id = FrameId(self.names.len() as u32);
        self.names.push(name.to_owned());
        self.ids.insert(name.to_owned(), id);
        self.histories.push(History::default());
        id
    }

    /// The name of a frame.
    #[must_use]
    pub fn name(&self, frame: FrameId) -> &str {
        self.names.get(frame.0 as usize).map_or("", String::as_str)
    }

    /// The frames that transforms connect, as (frame, its latest parent, whether it is static), in
    /// order of the frames' names.
    pub fn edges(&self) -> impl Iterator<Item = (&str, &str, bool)> {
        self.ids.iter().filter_map(|(name, id)| {
            let history = &self.histories[id.0 as usize];
            let newest = history.newest()?;
            Some((name.as_str(), self.name(newest.parent), history.is_static))
        })
    }

    /// How many samples repeated the time of an earlier one of their frame and were left out.
    #[must_use]
    pub fn repeated(&self) -> u64 {
        self.repeated
    }

    /// A number that changes whenever a frame gets a first or another parent.
    #[must_use]
    pub fn shape(&self) -> u64 {
        self.shape
    }

    /// Takes the pose of `child` in `parent` at `time_secs`; of a static frame, for all times.
    ///
    /// # Errors
    /// [`TransformProblem`] if the sample cannot be used; the buffer is then as before.
    pub fn insert(
        &mut self,
        parent: &str,
        child: &str,
        time_secs: f64,
        pose_in_parent: Transform,
        is_static: bool,
    ) -> Result<FrameId, TransformProblem> {
        if child.trim_matches('/').is_empty() || parent.trim_matches('/').is_empty() {
            return Err(TransformProblem::EmptyName);
        }
        if !time_secs.is_finite() {
            return Err(TransformProblem::NotFinite);
        }
        let (parent, child) = (self.frame(parent), self.frame(child));
        self.check(parent, child, time_secs, is_static)?;
        let history_secs = self.history_secs;
        let history = &mut self.histories[child.0 as usize];
        let previous = history.newest().map(|newest| newest.parent);
        history.is_static = is_static;
        let sample = Sample {
            time_secs,
            parent,
            pose_in_parent,
        };
        let taken = history.insert(sample, history_secs);
        self.repeated += u64::from(!taken);
        self.shape += u64::from(previous != Some(parent));
        Ok(child)
    }

    fn check(
        &self,
        parent: FrameId,
        child: FrameId,
        time_secs: f64,
        is_static: bool,
    ) -> Result<(), TransformProblem> {
        let history = &self.histories[child.0 as usize];
        if !history.is_empty() && history.is_static != is_static {
            return Err(TransformProblem::StaticAndMoving {
                child: self.name(child).to_owned(),
            });
        }
        if history.is_too_old(time_secs, self.history_secs) {
            return Err(TransformProblem::TooOld {
                child: self.name(child).to_owned(),
                time_secs,
            });
        }
        // Only a new parent can close a loop.
        let known = history
            .newest()
            .is_some_and(|newest| newest.parent == parent);
        if !known && self.ancestors(parent).contains(&child) {
            return Err(TransformProblem::Loop {
                parent: self.name(parent).to_owned(),
                child: self.name(child).to_owned(),
            });
        }
        Ok(())
    }

    /// The frame and its ancestors by their latest parents.
    fn ancestors(&self, frame: FrameId) -> Vec<FrameId> {
        let mut found = vec![frame];
        let mut current = frame;
        while let Some(newest) = self.histories[current.0 as usize].newest() {
            current = newest.parent;
            // Samples of different times may name parents that make a circle together.
            if found.contains(&current) {
                break;
            }
            found.push(current);
        }
        found
    }

    /// The frames whose poses in their parents make up the pose of `source` in `target`, by the
    /// latest parents, and whether each is static; `None` if the two are not connected.
    #[must_use]
    pub fn chain(&self, target: FrameId, source: FrameId) -> Option<Vec<(FrameId, bool)>> {
        let (up_target, up_source) = (self.ancestors(target), self.ancestors(source));
        let meeting = up_source
            .iter()
            .position(|frame| up_target.contains(frame))?;
        let common = up_source[meeting];
        let down = up_target.iter().take_while(|frame| **frame != common);
        let edges = up_source[..meeting].iter().chain(down);
        let is_static = |frame: &FrameId| self.histories[frame.0 as usize].is_static;
        Some(edges.map(|frame| (*frame, is_static(frame))).collect())
    }

    /// The pose of `source` in `target` at `time_secs`: it takes coordinates in `source` to those
    /// in `target`.
    ///
    /// # Errors
    /// [`LookupError`] if it is not known there.
    pub fn lookup(
        &self,
        target: &str,
        source: &str,
        time_secs: f64,
    ) -> Result<Transform, LookupError> {
        let find = |name: &str| {
            let plain = name.strip_prefix('/').unwrap_or(name);
            let unknown = || LookupError::UnknownFrame {
                frame: name.to_owned(),
                known: self.names.clone(),
            };
            self.ids.get(plain).copied().ok_or_else(unknown)
        };
        self.lookup_frames(find(target)?, find(source)?, time_secs)
    }

    /// As [`TransformBuffer::lookup`], by frames of this buffer.
    ///
    /// # Errors
    /// [`LookupError`] if it is not known there.
    pub fn lookup_frames(
        &self,
        target: FrameId,
        source: FrameId,
        time_secs: f64,
    ) -> Result<Transform, LookupError> {
        let up_source = self.climb(source, target, time_secs);
        if let Some((last, pose)) = up_source.poses.last()
            && *last == target
        {
            return Ok(*pose);
        }
        let up_target = self.climb(target, source, time_secs);
        for (ancestor, target_pose) in &up_target.poses {
            let meeting = up_source.poses.iter().find(|(frame, _)| frame == ancestor);
            if let Some((_, source_pose)) = meeting {
                return Ok(target_pose.inverse().then_inner(source_pose));
            }
        }
        match (up_source.stopped, up_target.stopped) {
            (Some(error), _) | (None, Some(error)) => Err(error),
            (None, None) => {
                Err(self.not_connected(target, &up_target.poses, source, &up_source.poses))
            }
        }
    }

    fn not_connected(
        &self,
        target: FrameId,
        up_target: &[(FrameId, Transform)],
        source: FrameId,
        up_source: &[(FrameId, Transform)],
    ) -> LookupError {
        let known = |frame: FrameId| {
            let has_parent = !self.histories[frame.0 as usize].is_empty();
            has_parent
                || self
                    .edges()
                    .any(|(_, parent, _)| parent == self.name(frame))
        };
        if let Some(unknown) = [target, source].into_iter().find(|frame| !known(*frame)) {
            let names = self.ids.iter().filter(|(_, id)| known(**id));
            return LookupError::UnknownFrame {
                frame: self.name(unknown).to_owned(),
                known: names.map(|(name, _)| name.clone()).collect(),
            };
        }
        let root = |poses: &[(FrameId, Transform)]| {
            let last = poses.last().map_or("", |(frame, _)| self.name(*frame));
            last.to_owned()
        };
        LookupError::NotConnected {
            target: self.name(target).to_owned(),
            target_root: root(up_target),
            source: self.name(source).to_owned(),
            source_root: root(up_source),
        }
    }

    /// Climbs from `frame` to `until` or as far as the samples go.
    fn climb(&self, frame: FrameId, until: FrameId, time_secs: f64) -> Climb {
        let mut poses = vec![(frame, Transform::IDENTITY)];
        let (mut current, mut pose) = (frame, Transform::IDENTITY);
        while current != until && poses.len() <= self.names.len() {
            let stopped = match self.histories[current.0 as usize].at(time_secs, self.bridged_secs)
            {
                Found::Pose {
                    parent,
                    pose: pose_in_parent,
                } => {
                    pose = pose_in_parent.then_inner(&pose);
                    current = parent;
                    poses.push((current, pose));
                    continue;
                }
                Found::Root => None,
                Found::TooEarly { oldest_secs } => Some(LookupError::TooEarly {
                    frame: self.name(current).to_owned(),
                    time_secs,
                    oldest_secs,
                }),
                Found::TooLate { newest_secs } => Some(LookupError::TooLate {
                    frame: self.name(current).to_owned(),
                    time_secs,
                    newest_secs,
                }),
                Found::ParentChanges => Some(LookupError::ParentChanges {
                    frame: self.name(current).to_owned(),
                    time_secs,
                }),
                Found::TooWide { gap_secs } => Some(LookupError::TooWide {
                    frame: self.name(current).to_owned(),
                    time_secs,
                    gap_secs,
                    bridged_secs: self.bridged_secs,
                }),
            };
            return Climb { poses, stopped };
        }
        Climb {
            poses,
            stopped: None,
        }
    }
}

#[cfg(test)]
mod tests;
