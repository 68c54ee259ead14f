//! The robot's own code: what would run on the real machine.
//!
//! [`Controller`] and [`SensorNodes`] see only [`Readings`] and give only [`Commands`]: encoder
//! readings, tracking, signals and a clock in; joint targets, a hand position, an announcement and
//! requests to the motion planner out. Nothing of the simulator appears here.

mod controller;
mod interface;
mod sensing;

pub use controller::{Controller, Decision, ResetPose, State};
pub use interface::{Commands, HandCommand, PlannerStatus, Readings, TrackedPoses};
pub use sensing::{SensorNodes, SensorReport};
pub(crate) use sensing::{gaze_satisfied, location_satisfied};
