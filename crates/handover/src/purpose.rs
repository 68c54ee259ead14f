//! What an episode draws random numbers for.

/// What a stream of random numbers is for. The numbers are part of the seed's meaning: a new
/// purpose takes a new number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Mass, friction and placement of the object.
    Object = 1,
    /// The robot's random pose at the reset.
    RobotPose = 2,
    /// Head, gaze error and pull of the human.
    Human = 3,
    /// The human's delays.
    HumanTiming = 4,
    /// Noise and glitches of tracking.
    Tracking = 5,
    /// Answer times and failures of the motion planner.
    Planner = 6,
}

impl From<Purpose> for u32 {
    fn from(purpose: Purpose) -> Self {
        purpose as Self
    }
}
