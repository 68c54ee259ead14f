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
            repeated: 0,
            shape: 0,
        }
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
            let stopped = match self.histories[current.0 as usize].at(time_secs) {
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
mod tests {
    use super::*;

    fn shifted(x: f64) -> Transform {
        Transform::new([x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]).unwrap()
    }

    fn about_z(angle_rad: f64, translation_m: [f64; 3]) -> Transform {
        let half = angle_rad / 2.0;
        Transform::new(translation_m, [0.0, 0.0, half.sin(), half.cos()]).unwrap()
    }

    /// Two arms on one base; the left one turns with 1 rad/s, sampled at 10 Hz with noise-free
    /// poses, of which spherical interpolation is exact.
    fn two_arms() -> TransformBuffer {
        let mut buffer = TransformBuffer::new(10.0);
        buffer
            .insert(
                "world",
                "base",
                0.0,
                about_z(std::f64::consts::PI, [2.0, 0.0, 0.0]),
                true,
            )
            .unwrap();
        buffer
            .insert("base", "right", 0.0, shifted(-0.5), true)
            .unwrap();
        for step in 0..=20 {
            let time_secs = f64::from(step) / 10.0;
            buffer
                .insert(
                    "base",
                    "left",
                    time_secs,
                    about_z(time_secs, [0.5, 0.0, 0.0]),
                    false,
                )
                .unwrap();
        }
        buffer
            .insert("left", "tip", 0.0, shifted(0.3), true)
            .unwrap();
        buffer
    }

    #[test]
    fn chains_across_the_tree_agree_with_the_closed_form() {
        let buffer = two_arms();
        for time_secs in [0.0_f64, 0.05, 0.1, 0.777, 1.99, 2.0] {
            // In the base: (0.5 + 0.3 cos t, 0.3 sin t); seen from the right arm: 0.5 further.
            let (x, y) = (0.5 + 0.3 * time_secs.cos(), 0.3 * time_secs.sin());
            let tip = buffer
                .lookup("right", "tip", time_secs)
                .unwrap()
                .translation_m;
            assert!((tip[0] - (x + 0.5)).abs() < 1e-12, "{time_secs}: {tip:?}");
            assert!((tip[1] - y).abs() < 1e-12, "{time_secs}: {tip:?}");
            // The base is turned by half a turn in the world.
            let tip = buffer
                .lookup("/world", "tip", time_secs)
                .unwrap()
                .translation_m;
            assert!((tip[0] - (2.0 - x)).abs() < 1e-12 && (tip[1] + y).abs() < 1e-12);
            let there = buffer.lookup("tip", "world", time_secs).unwrap();
            let back = buffer
                .lookup("world", "tip", time_secs)
                .unwrap()
                .then_inner(&there);
            assert!(back.distance_m() < 1e-12);
        }
        assert_eq!(
            buffer.lookup("tip", "tip", 99.0).unwrap(),
            Transform::IDENTITY
        );
    }

    #[test]
    fn nothing_is_extrapolated() {
        let buffer = two_arms();
        let late = buffer.lookup("world", "tip", 2.0001).unwrap_err();
        assert!(
            matches!(&late, LookupError::TooLate { frame, newest_secs, .. } if frame == "left" && *newest_secs == 2.0)
        );
        assert!(late.may_come());
        let early = buffer.lookup("world", "tip", -0.1).unwrap_err();
        assert!(matches!(&early, LookupError::TooEarly { frame, .. } if frame == "left"));
        assert!(!early.may_come());
        // What is static is known at all times.
        assert!(buffer.lookup("world", "right", -5.0).is_ok());
    }

    #[test]
    fn what_is_not_connected_is_named() {
        let mut buffer = two_arms();
        let message = buffer
            .lookup("world", "thumb", 1.0)
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("thumb is not known") && message.contains("left"),
            "{message}"
        );
        buffer
            .insert("map", "person", 0.0, shifted(1.0), true)
            .unwrap();
        let message = buffer.lookup("person", "tip", 1.0).unwrap_err().to_string();
        assert!(
            message.contains("person is below map, tip below world"),
            "{message}"
        );
        // A frame that was only asked for is still unknown.
        let (asked, world) = (buffer.frame("ghost"), buffer.frame("world"));
        let message = buffer
            .lookup_frames(world, asked, 1.0)
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("ghost is not known") && !message.contains(", ghost"),
            "{message}"
        );
    }

    #[test]
    fn loops_and_double_kinds_are_refused() {
        let mut buffer = two_arms();
        let problem = buffer
            .insert("tip", "world", 0.0, shifted(0.0), true)
            .unwrap_err();
        assert!(matches!(problem, TransformProblem::Loop { .. }));
        let problem = buffer
            .insert("tip", "tip", 0.0, shifted(0.0), true)
            .unwrap_err();
        assert!(matches!(problem, TransformProblem::Loop { .. }));
        let problem = buffer
            .insert("base", "right", 0.0, shifted(0.0), false)
            .unwrap_err();
        assert!(matches!(problem, TransformProblem::StaticAndMoving { .. }));
        assert!(buffer.insert("base", "", 0.0, shifted(0.0), false).is_err());
        assert!(buffer.lookup("world", "tip", 1.0).is_ok());
    }

    #[test]
    fn history_is_bounded_and_covers_what_it_says() {
        let mut buffer = TransformBuffer::new(1.0);
        for step in 0..1000 {
            let x = f64::from(step) / 10.0;
            buffer
                .insert("world", "cart", x, shifted(x), false)
                .unwrap();
        }
        let x_at = |time_secs| {
            buffer
                .lookup("world", "cart", time_secs)
                .map(|pose| pose.translation_m[0])
        };
        assert!((x_at(98.9).unwrap() - 98.9).abs() < 1e-12);
        assert!(matches!(x_at(98.0), Err(LookupError::TooEarly { .. })));
        let late = buffer
            .clone()
            .insert("world", "cart", 50.0, shifted(0.0), false);
        assert!(matches!(late, Err(TransformProblem::TooOld { .. })));
    }

    #[test]
    fn samples_out_of_order_are_sorted_and_repeated_ones_left_out() {
        let mut buffer = TransformBuffer::new(10.0);
        for time_secs in [0.0, 2.0, 1.0, 1.0] {
            let again = buffer.repeated();
            let x = time_secs * time_secs + again as f64;
            buffer
                .insert("world", "cart", time_secs, shifted(x), false)
                .unwrap();
        }
        assert_eq!(buffer.repeated(), 1);
        let x = buffer.lookup("world", "cart", 1.5).unwrap().translation_m[0];
        assert!((x - 2.5).abs() < 1e-12);
    }

    #[test]
    fn a_change_of_parent_is_not_bridged() {
        let mut buffer = TransformBuffer::new(10.0);
        buffer
            .insert("world", "table", 0.0, shifted(1.0), true)
            .unwrap();
        buffer
            .insert("world", "robot", 0.0, shifted(5.0), true)
            .unwrap();
        buffer
            .insert("table", "cup", 1.0, shifted(0.1), false)
            .unwrap();
        let before = buffer.shape();
        buffer
            .insert("robot", "cup", 2.0, shifted(0.2), false)
            .unwrap();
        assert_ne!(buffer.shape(), before);
        let x_at = |time_secs| {
            buffer
                .lookup("world", "cup", time_secs)
                .map(|pose| pose.translation_m[0])
        };
        assert!((x_at(1.0).unwrap() - 1.1).abs() < 1e-12);
        assert!((x_at(2.0).unwrap() - 5.2).abs() < 1e-12);
        assert!(matches!(x_at(1.5), Err(LookupError::ParentChanges { .. })));
    }

    #[test]
    fn the_chain_names_each_edge_once() {
        let mut buffer = two_arms();
        let [right, tip] = ["right", "tip"].map(|name| buffer.frame(name));
        let chain = buffer.chain(right, tip).unwrap();
        let named: Vec<(&str, bool)> = chain
            .iter()
            .map(|&(frame, fixed)| (buffer.name(frame), fixed))
            .collect();
        assert_eq!(named, [("tip", true), ("left", false), ("right", true)]);
    }
}
