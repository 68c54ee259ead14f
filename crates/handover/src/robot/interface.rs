//! What passes between the robot's code and its body.

use testbench::geometry::{Pose, Vector};

use crate::outside::SensorsOutside;
use crate::scenario::JointAngles;

/// One reading of the motion-tracking system, in the world frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackedPoses {
    /// When it was taken.
    pub time_secs: f64,
    /// Centre of the object.
    pub object_m: Vector,
    /// Centre of the human's hand.
    pub human_hand_m: Vector,
    /// The human's head; its x axis points where the face does.
    pub human_head: Pose,
}

/// What the motion planner says about the last request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PlannerStatus {
    /// Nothing was asked, or the answer has been taken.
    #[default]
    Idle,
    /// Working on it.
    Working,
    /// A plan is there; the arm may move.
    Answered,
}

/// Everything the robot's code can see at one tick.
#[derive(Debug, Clone, Copy)]
pub struct Readings<'a> {
    /// The robot's clock.
    pub clock_secs: f64,
    /// Arm encoders: joint angles in rad, in the order given to the controller.
    pub arm_rad: &'a [f64],
    /// Finger encoders in counts, in the order of the scenario.
    pub finger_counts: &'a [i64],
    /// The latest tracking reading, if there has been one.
    pub tracking: Option<&'a TrackedPoses>,
    /// The human has sent "activate".
    pub activated: bool,
    /// The human has sent "ready".
    pub human_ready: bool,
    /// The motion planner.
    pub planner: PlannerStatus,
    /// Judgements of sensors that are not simulated; by default there are none.
    pub sensors: SensorsOutside,
}

/// What the hand is told to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HandCommand {
    /// All fingers straight, thumb aside.
    Open,
    /// Thumb and finger tips first.
    Pregrasp,
    /// All fingers flexed.
    Grasp,
}

/// What the robot's code wants, held until changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Commands {
    /// Joint angles the arm is to take, in rad; joints not named stay.
    pub arm_target_rad: JointAngles,
    /// Whether the arm keeps to the restricted speed.
    pub restricted: bool,
    /// What the hand is to do.
    pub hand: HandCommand,
    /// Whether the announcement is being made.
    pub announcing: bool,
    /// Number of requests made to the motion planner so far; a new one raises it.
    pub planner_requests: u32,
}
