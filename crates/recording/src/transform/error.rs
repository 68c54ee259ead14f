//! What can be wrong with transforms and with asking for them.

use std::fmt;

/// A sample of a transform that cannot be used. It is left out; the others stay.
#[derive(Debug, Clone, PartialEq)]
pub enum TransformProblem {
    /// A number is NaN or infinite.
    NotFinite,
    /// The quaternion is not of unit length.
    NotUnit {
        /// Its length.
        length: f64,
    },
    /// A frame has no name.
    EmptyName,
    /// A frame would become its own ancestor.
    Loop {
        /// The parent that was given.
        parent: String,
        /// The frame, of which `parent` is already a descendant.
        child: String,
    },
    /// A frame is published both as static and as moving.
    StaticAndMoving {
        /// The frame.
        child: String,
    },
    /// A sample is older than the history that is kept.
    TooOld {
        /// The frame.
        child: String,
        /// Its time in seconds.
        time_secs: f64,
    },
}

impl fmt::Display for TransformProblem {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TransformProblem::NotFinite => write!(
                out,
                "a transform holds a number that is not finite; repair what publishes it"
            ),
            TransformProblem::NotUnit { length } => write!(
                out,
                "the quaternion of a transform has length {length}, not 1; repair what publishes it"
            ),
            TransformProblem::EmptyName => {
                write!(out, "a transform names no frame; repair what publishes it")
            }
            TransformProblem::Loop { parent, child } => write!(
                out,
                "frame {child} cannot have the parent {parent}, which is below {child}; \
                 give each frame one parent"
            ),
            TransformProblem::StaticAndMoving { child } => write!(
                out,
                "frame {child} is published both as static and as moving; stop one of the two"
            ),
            TransformProblem::TooOld { child, time_secs } => write!(
                out,
                "a transform of frame {child} at {time_secs} s comes later than the history that \
                 is kept; keep a longer history"
            ),
        }
    }
}

impl std::error::Error for TransformProblem {}

/// Why the pose of one frame in another is not known at a time.
#[derive(Debug, Clone, PartialEq)]
pub enum LookupError {
    /// No transform has named this frame so far.
    UnknownFrame {
        /// The frame.
        frame: String,
        /// The frames that are known, in the order of their first appearance.
        known: Vec<String>,
    },
    /// The two frames are in trees that no transform connects.
    NotConnected {
        /// The frame in which the pose was asked for.
        target: String,
        /// The root of its tree at that time.
        target_root: String,
        /// The frame whose pose was asked for.
        source: String,
        /// The root of its tree at that time.
        source_root: String,
    },
    /// The time lies before the first sample that is kept.
    TooEarly {
        /// The frame whose pose in its parent is missing.
        frame: String,
        /// The time that was asked for, in seconds.
        time_secs: f64,
        /// The time of the first sample that is kept.
        oldest_secs: f64,
    },
    /// The time lies behind the last sample so far; a later message may bring it.
    TooLate {
        /// The frame whose pose in its parent is missing.
        frame: String,
        /// The time that was asked for, in seconds.
        time_secs: f64,
        /// The time of the last sample.
        newest_secs: f64,
    },
    /// The time lies between samples under two different parents.
    ParentChanges {
        /// The frame.
        frame: String,
        /// The time that was asked for, in seconds.
        time_secs: f64,
    },
    /// The time lies between samples that are too far apart to interpolate between them.
    TooWide {
        /// The frame.
        frame: String,
        /// The time that was asked for, in seconds.
        time_secs: f64,
        /// How far apart they are.
        gap_secs: f64,
        /// How far apart they may be.
        bridged_secs: f64,
    },
}

impl LookupError {
    /// Whether messages that are still to come may bring the transform.
    #[must_use]
    pub fn may_come(&self) -> bool {
        !matches!(
            self,
            LookupError::TooEarly { .. }
                | LookupError::ParentChanges { .. }
                | LookupError::TooWide { .. }
        )
    }
}

impl fmt::Display for LookupError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LookupError::UnknownFrame { frame, known } if known.is_empty() => write!(
                out,
                "frame {frame} is not known, since no transforms were recorded; record /tf and \
                 /tf_static"
            ),
            LookupError::UnknownFrame { frame, known } => write!(
                out,
                "frame {frame} is not known; the recording has {}",
                known.join(", ")
            ),
            LookupError::NotConnected {
                target,
                target_root,
                source,
                source_root,
            } => write!(
                out,
                "frames {target} and {source} are not connected: {target} is below {target_root}, \
                 {source} below {source_root}; record the transform between these two"
            ),
            LookupError::TooEarly {
                frame,
                time_secs,
                oldest_secs,
            } => write!(
                out,
                "the pose of frame {frame} at {time_secs} s is not known: its samples begin at \
                 {oldest_secs} s"
            ),
            LookupError::TooLate {
                frame,
                time_secs,
                newest_secs,
            } => write!(
                out,
                "the pose of frame {frame} at {time_secs} s is not known: its samples end at \
                 {newest_secs} s"
            ),
            LookupError::ParentChanges { frame, time_secs } => write!(
                out,
                "the pose of frame {frame} at {time_secs} s is not known, since its parent changes \
                 there"
            ),
            LookupError::TooWide {
                frame,
                time_secs,
                gap_secs,
                bridged_secs,
            } => write!(
                out,
                "the pose of frame {frame} at {time_secs} s is not known: its samples are {gap_secs} s \
                 apart there, and at most {bridged_secs} s are interpolated over; if the frame moves \
                 slowly, raise frame_gap in [time] of the topic map"
            ),
        }
    }
}

impl std::error::Error for LookupError {}
