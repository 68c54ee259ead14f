//! Where things are, how they move and what energy they have.

use super::quantity::{OfJoint, Plain};
use super::things::{Part, Place};
use crate::geometry::{
    Pose, Vector, add, cross, dot, inverse, norm, rotate, rotation_between, scale, subtract,
};
use crate::physics::{DriveKind, JointKind, Layout, Physics, Twist};
use crate::scene::measure::yaw_of;

/// A body that is led: where it is, and how it got there. Engines place such bodies and give them no velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Led {
    pub(super) pose: Pose,
    pub(super) twist: Twist,
}

impl Led {
    /// One that was led on from `self` within a time.
    pub(super) fn on_to(self, pose: &Pose, secs: f64) -> Self {
        let linear = subtract(pose.position_m, self.pose.position_m);
        let angular = rotation_between(self.pose.orientation, pose.orientation);
        Self {
            pose: *pose,
            twist: Twist {
                angular_rad_s: scale(1.0 / secs, angular),
                linear_m_s: scale(1.0 / secs, linear),
            },
        }
    }
}

/// What is looked at.
pub(super) struct View<'a> {
    pub(super) physics: &'a dyn Physics,
    pub(super) layout: &'a Layout,
    /// By body; `None` for those that are not led.
    pub(super) led: &'a [Option<Led>],
    pub(super) upright_within_rad: f64,
}

impl View<'_> {
    /// How the origin of a body's frame moves.
    pub(super) fn body_twist(&self, body: usize) -> Twist {
        match self.led.get(body) {
            Some(Some(led)) => led.twist,
            _ => self.physics.body_twist(body),
        }
    }

    /// Where a body's frame is.
    pub(super) fn body_pose(&self, body: usize) -> Pose {
        match self.led.get(body) {
            Some(Some(led)) => led.pose,
            _ => self.physics.body_pose(body),
        }
    }

    pub(super) fn pose(&self, place: Place) -> Pose {
        match place {
            Place::World(pose) => pose,
            Place::Body(body, offset) => self.body_pose(body).then(&offset),
        }
    }

    /// How the origin of a frame moves.
    pub(super) fn twist(&self, place: Place) -> Twist {
        let Place::Body(body, offset) = place else {
            return Twist::default();
        };
        let twist = self.body_twist(body);
        let arm = rotate(self.body_pose(body).orientation, offset.position_m);
        Twist {
            linear_m_s: at_arm(&twist, arm),
            ..twist
        }
    }

    /// A quantity of a part but of whom grasps it, which is not motion.
    pub(super) fn plain(&self, part: &Part, plain: Plain) -> f64 {
        let pose = || self.pose(part.place);
        let twist = || self.twist(part.place);
        let in_body = |vector: Vector| rotate(inverse(pose().orientation), vector);
        match plain {
            Plain::Position(3) => self.centre_height(part),
            Plain::Position(axis) => pose().position_m[axis],
            Plain::Roll => roll_pitch(&pose())[0],
            Plain::Pitch => roll_pitch(&pose())[1],
            Plain::Yaw => yaw_of(pose().orientation),
            Plain::Tilt => tilt_of(&pose()),
            Plain::Upright => flag(tilt_of(&pose()) <= self.upright_within_rad),
            Plain::Speed => norm(twist().linear_m_s),
            Plain::HorizontalSpeed => twist().linear_m_s[0].hypot(twist().linear_m_s[1]),
            Plain::Velocity(axis) => twist().linear_m_s[axis],
            Plain::BodyVelocity(axis) => in_body(twist().linear_m_s)[axis],
            Plain::AngularSpeed => norm(twist().angular_rad_s),
            Plain::AngularVelocity(axis) => twist().angular_rad_s[axis],
            Plain::BodyAngularVelocity(axis) => in_body(twist().angular_rad_s)[axis],
            Plain::KineticEnergy => self.kinetic_energy(part),
            Plain::PotentialEnergy => self.potential_energy(part),
            Plain::MechanicalEnergy => self.kinetic_energy(part) + self.potential_energy(part),
            Plain::GraspedBy => f64::NAN,
        }
    }

    /// `m v² / 2 + w J w / 2` of each body, about its centre of mass, and what turns in the joints' drives.
    fn kinetic_energy(&self, part: &Part) -> f64 {
        let bodies = part.bodies.iter().filter_map(|body| {
            let inertia = self.layout.bodies[*body].inertia?;
            let (pose, twist) = (self.body_pose(*body), self.body_twist(*body));
            let arm = rotate(pose.orientation, inertia.centre_m);
            let velocity = at_arm(&twist, arm);
            let turn = rotate(inverse(pose.orientation), twist.angular_rad_s);
            let [xx, yy, zz, xy, xz, yz] = inertia.moments_kg_m2;
            let [x, y, z] = turn;
            let turning = xx * x * x + yy * y * y + zz * z * z;
            let turning = turning + 2.0 * (xy * x * y + xz * x * z + yz * y * z);
            Some((inertia.mass_kg * dot(velocity, velocity) + turning) / 2.0)
        });
        let drives = self.joints_of(part).map(|joint| {
            let velocity = self.physics.joint(joint).velocity;
            self.layout.joints[joint].armature * velocity * velocity / 2.0
        });
        bodies.sum::<f64>() + drives.sum::<f64>()
    }

    /// `m g z` of each body, and what is in the joints' springs.
    fn potential_energy(&self, part: &Part) -> f64 {
        let gravity = self.layout.gravity_m_s2;
        let springs = self.joints_of(part).map(|joint| {
            let plan = &self.layout.joints[joint];
            let stretch = self.physics.joint(joint).position - plan.spring_reference;
            plan.stiffness * stretch * stretch / 2.0
        });
        let [mass_kg, moment] = self.mass(part);
        mass_kg * gravity * moment + springs.sum::<f64>()
    }

    fn centre_height(&self, part: &Part) -> f64 {
        self.mass(part)[1]
    }

    /// The mass of a part and how high its centre is.
    fn mass(&self, part: &Part) -> [f64; 2] {
        let (mut mass_kg, mut moment) = (0.0, 0.0);
        for body in &part.bodies {
            let Some(inertia) = self.layout.bodies[*body].inertia else {
                continue;
            };
            let pose = self.body_pose(*body);
            let centre = add(pose.position_m, rotate(pose.orientation, inertia.centre_m));
            mass_kg += inertia.mass_kg;
            moment += inertia.mass_kg * centre[2];
        }
        match mass_kg > 0.0 {
            true => [mass_kg, moment / mass_kg],
            false => [0.0, f64::NAN],
        }
    }

    /// The joints of a whole that have one position; none of a single link.
    fn joints_of<'p>(&'p self, part: &'p Part) -> impl Iterator<Item = usize> + 'p {
        let joints = self.layout.joints.iter().enumerate();
        let joints = joints.filter(|(_, plan)| plan.kind != JointKind::Ball);
        let own = joints.filter(|(_, plan)| part.is_whole && part.bodies.contains(&plan.body));
        own.map(|(joint, _)| joint)
    }

    pub(super) fn joint(&self, joint: usize, quantity: OfJoint) -> f64 {
        let plan = &self.layout.joints[joint];
        let state = self.physics.joint(joint);
        match quantity {
            OfJoint::Position => state.position,
            OfJoint::Velocity => state.velocity,
            OfJoint::LimitDistance => plan.range.map_or(f64::NAN, |[low, high]| {
                (state.position - low).min(high - state.position)
            }),
            OfJoint::DriveTorque => self.drive_torque(joint),
            OfJoint::Torque => self.borne_torque(joint),
        }
    }

    /// What all drives of a joint exert in its present state, by their laws.
    fn drive_torque(&self, joint: usize) -> f64 {
        let state = self.physics.joint(joint);
        let drives = self.layout.drives.iter().enumerate();
        let own = drives.filter(|(_, drive)| drive.joint == joint);
        own.map(|(index, drive)| {
            let told = self.physics.drive(index);
            let wanted = match drive.kind {
                DriveKind::Position { stiffness, damping } => {
                    stiffness * (told.target - state.position) - damping * state.velocity
                }
                DriveKind::Velocity { gain } => gain * (told.target - state.velocity),
                DriveKind::Effort => told.target,
            };
            told.strength * wanted.clamp(-drive.limit, drive.limit)
        })
        .sum()
    }

    /// The part about a joint's axis of what its link's parent exerts on the link.
    fn borne_torque(&self, joint: usize) -> f64 {
        let plan = &self.layout.joints[joint];
        let Some([force, torque]) = self.physics.wrench(plan.body) else {
            return f64::NAN;
        };
        let axis = scale(1.0 / norm(plan.axis).max(1e-12), plan.axis);
        match plan.kind {
            JointKind::Slide => dot(axis, force),
            // About a point of the axis, not about the origin of the frame.
            JointKind::Hinge | JointKind::Ball => {
                dot(axis, subtract(torque, cross(plan.anchor_m, force)))
            }
        }
    }
}

/// The velocity of a point that is `arm` away from the point of a twist.
pub(super) fn at_arm(twist: &Twist, arm: Vector) -> Vector {
    add(twist.linear_m_s, cross(twist.angular_rad_s, arm))
}

pub(super) fn flag(value: bool) -> f64 {
    f64::from(u8::from(value))
}

/// The angle between a frame's z axis and the vertical.
fn tilt_of(pose: &Pose) -> f64 {
    let [x, y, z] = rotate(pose.orientation, [0.0, 0.0, 1.0]);
    x.hypot(y).atan2(z)
}

/// Turns about the fixed x and y axes, before that about z.
fn roll_pitch(pose: &Pose) -> [f64; 2] {
    let [w, x, y, z] = pose.orientation;
    let roll = (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y));
    let pitch = (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin();
    [roll, pitch]
}
