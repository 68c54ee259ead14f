//! Parts of the robot that are not simulated: hardware in the loop.
//!
//! An episode may be joined to a world outside. Then each of the readings that a [`OutsideReadings`]
//! names comes from there instead of from the simulation, and reaches the robot's code at its next
//! tick. Everything else goes on as simulated, so the trace still says what the simulated sensors
//! and human would have done; what the robot *believes* (`/sensors`) follows the outside.
//!
//! An episode with an outside is as repeatable as the outside is: the same readings at the same
//! ticks give the same trace, bit for bit.

use std::ops::ControlFlow;

use testbench::geometry::{Pose, Vector};
use trace::Trace;

use crate::robot::TrackedPoses;

/// Where a reading comes from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Reading<T> {
    /// From the simulation.
    #[default]
    Simulated,
    /// From outside; `None` while it is not known there, and the robot's code then has no reading.
    Outside(Option<T>),
}

impl<T> Reading<T> {
    /// The reading, given what the simulation says.
    pub fn or(self, simulated: Option<T>) -> Option<T> {
        match self {
            Self::Simulated => simulated,
            Self::Outside(value) => value,
        }
    }
}

/// What the three sensors of the human say, where they are not simulated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SensorsOutside {
    /// Whether the human looks at the object.
    pub gaze: Reading<bool>,
    /// Whether the human pulls on the object.
    pub pressure: Reading<bool>,
    /// Whether the human's hand is on the object.
    pub location: Reading<bool>,
}

/// The readings that an outside can give; those of the default are all simulated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OutsideReadings {
    /// The human has sent "activate"; not known counts as not sent.
    pub activated: Reading<bool>,
    /// The human has sent "ready"; not known counts as not sent.
    pub human_ready: Reading<bool>,
    /// Tracked centre of the object, metres in the world frame. If it is not known, tracking as a
    /// whole gives no reading; so for the next two.
    pub object_m: Reading<Vector>,
    /// Tracked centre of the human's hand, metres in the world frame.
    pub human_hand_m: Reading<Vector>,
    /// Tracked position of the human's head, metres in the world frame; where it faces stays
    /// simulated.
    pub human_head_m: Reading<Vector>,
    /// The sensors' own judgements.
    pub sensors: SensorsOutside,
}

impl OutsideReadings {
    /// A tracking reading as the robot's code gets it, given what simulated tracking reports.
    pub(crate) fn tracked(&self, reported: TrackedPoses) -> Option<TrackedPoses> {
        let head = reported.human_head;
        Some(TrackedPoses {
            time_secs: reported.time_secs,
            object_m: self.object_m.or(Some(reported.object_m))?,
            human_hand_m: self.human_hand_m.or(Some(reported.human_hand_m))?,
            human_head: Pose {
                position_m: self.human_head_m.or(Some(head.position_m))?,
                ..head
            },
        })
    }
}

/// A world outside to which an episode is joined.
pub trait Outside {
    /// The episode has come to `now_secs`; `recorded` is everything that was recorded so far. The
    /// episode goes on when this returns, so that it can be held in step with a clock. `Break`
    /// ends it as if it were cancelled.
    fn step(&mut self, now_secs: f64, recorded: &Trace) -> ControlFlow<()>;

    /// What the outside says now; asked before each time step.
    fn readings(&self) -> OutsideReadings;
}

/// Nothing outside: everything is simulated, as fast as it can be.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Nothing;

impl Outside for Nothing {
    fn step(&mut self, _: f64, _: &Trace) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn readings(&self) -> OutsideReadings {
        OutsideReadings::default()
    }
}
