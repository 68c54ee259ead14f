//! The motion of a body as it is seen from a frame that moves itself.

use testbench::geometry::{add, cross, inverse, rotate, subtract};

use super::ObjectState;

impl ObjectState {
    /// Something that stands still.
    pub(super) fn at_rest(pose: testbench::geometry::Pose) -> Self {
        Self {
            pose,
            velocity_m_s: [0.0; 3],
            spin_rad_s: [0.0; 3],
        }
    }

    /// The motion in the world of what moves so in a frame that moves itself.
    pub(super) fn carried_by(&self, frame: &Self) -> Self {
        let out = |vector| rotate(frame.pose.orientation, vector);
        let lever = out(self.pose.position_m);
        let with_frame = add(frame.velocity_m_s, cross(frame.spin_rad_s, lever));
        Self {
            pose: frame.pose.then(&self.pose),
            velocity_m_s: add(with_frame, out(self.velocity_m_s)),
            spin_rad_s: add(frame.spin_rad_s, out(self.spin_rad_s)),
        }
    }

    /// The motion in a frame that moves itself of what moves so in the world.
    pub(super) fn seen_from(&self, frame: &Self) -> Self {
        let own = |vector| rotate(inverse(frame.pose.orientation), vector);
        let lever = subtract(self.pose.position_m, frame.pose.position_m);
        let with_frame = add(frame.velocity_m_s, cross(frame.spin_rad_s, lever));
        Self {
            pose: self.pose.seen_from(&frame.pose),
            velocity_m_s: own(subtract(self.velocity_m_s, with_frame)),
            spin_rad_s: own(subtract(self.spin_rad_s, frame.spin_rad_s)),
        }
    }
}
