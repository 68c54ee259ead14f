//! Which quantities truth signals have, with their units, frames and meanings.

use trace::Field;

use super::things::{Kind, Part};

/// A quantity of one thing that its name says whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Plain {
    Position(usize),
    Roll,
    Pitch,
    Yaw,
    Tilt,
    Upright,
    Speed,
    HorizontalSpeed,
    Velocity(usize),
    BodyVelocity(usize),
    AngularSpeed,
    AngularVelocity(usize),
    BodyAngularVelocity(usize),
    KineticEnergy,
    PotentialEnergy,
    MechanicalEnergy,
    GraspedBy,
}

/// In which frame a number is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Frame {
    None,
    World,
    /// Of the body that it is of.
    Body,
}

/// A quantity as it is told.
pub(super) struct Told<Q> {
    pub(super) name: &'static str,
    pub(super) quantity: Q,
    /// Empty for truth values and names.
    pub(super) unit: &'static str,
    pub(super) frame: Frame,
    pub(super) meaning: &'static str,
}

const fn told<Q>(
    name: &'static str,
    quantity: Q,
    unit: &'static str,
    frame: Frame,
    meaning: &'static str,
) -> Told<Q> {
    Told {
        name,
        quantity,
        unit,
        frame,
        meaning,
    }
}

use Frame::{Body, None as Nowhere, World};

/// Quantities of one thing or part.
pub(super) const PLAIN: [Told<Plain>; 29] = [
    told(
        "x",
        Plain::Position(0),
        "m",
        World,
        "where the origin of its frame is",
    ),
    told(
        "y",
        Plain::Position(1),
        "m",
        World,
        "where the origin of its frame is",
    ),
    told(
        "z",
        Plain::Position(2),
        "m",
        World,
        "where the origin of its frame is",
    ),
    told(
        "roll",
        Plain::Roll,
        "rad",
        World,
        "how it is turned about the fixed x axis, first",
    ),
    told(
        "pitch",
        Plain::Pitch,
        "rad",
        World,
        "then about the fixed y axis",
    ),
    told(
        "yaw",
        Plain::Yaw,
        "rad",
        World,
        "then about the fixed z axis",
    ),
    told(
        "tilt",
        Plain::Tilt,
        "rad",
        Nowhere,
        "the angle between its z axis and the vertical, 0 for what is upright",
    ),
    told(
        "upright",
        Plain::Upright,
        "",
        Nowhere,
        "whether its tilt is at most the scene's `truth.upright_within_rad`",
    ),
    told(
        "speed",
        Plain::Speed,
        "m/s",
        Nowhere,
        "the magnitude of its origin's velocity in space",
    ),
    told(
        "horizontal_speed",
        Plain::HorizontalSpeed,
        "m/s",
        Nowhere,
        "the magnitude of its velocity along the floor",
    ),
    told(
        "velocity.x",
        Plain::Velocity(0),
        "m/s",
        World,
        "a component of its origin's velocity, signed",
    ),
    told(
        "velocity.y",
        Plain::Velocity(1),
        "m/s",
        World,
        "a component of its origin's velocity, signed",
    ),
    told(
        "velocity.z",
        Plain::Velocity(2),
        "m/s",
        World,
        "a component of its origin's velocity, signed",
    ),
    told(
        "body_velocity.x",
        Plain::BodyVelocity(0),
        "m/s",
        Body,
        "the same in its own frame: forwards",
    ),
    told(
        "body_velocity.y",
        Plain::BodyVelocity(1),
        "m/s",
        Body,
        "to the left",
    ),
    told(
        "body_velocity.z",
        Plain::BodyVelocity(2),
        "m/s",
        Body,
        "upwards",
    ),
    told(
        "angular_speed",
        Plain::AngularSpeed,
        "rad/s",
        Nowhere,
        "the magnitude of its angular velocity",
    ),
    told(
        "angular_velocity.x",
        Plain::AngularVelocity(0),
        "rad/s",
        World,
        "a component of its angular velocity, signed",
    ),
    told(
        "angular_velocity.y",
        Plain::AngularVelocity(1),
        "rad/s",
        World,
        "a component of its angular velocity, signed",
    ),
    told(
        "angular_velocity.z",
        Plain::AngularVelocity(2),
        "rad/s",
        World,
        "a component of its angular velocity, signed",
    ),
    told(
        "body_angular_velocity.x",
        Plain::BodyAngularVelocity(0),
        "rad/s",
        Body,
        "the same in its own frame",
    ),
    told(
        "body_angular_velocity.y",
        Plain::BodyAngularVelocity(1),
        "rad/s",
        Body,
        "the same in its own frame",
    ),
    told(
        "body_angular_velocity.z",
        Plain::BodyAngularVelocity(2),
        "rad/s",
        Body,
        "the same in its own frame",
    ),
    told(
        "kinetic_energy",
        Plain::KineticEnergy,
        "J",
        Nowhere,
        "of all its bodies; of a whole robot with its drives' inertia",
    ),
    told(
        "potential_energy",
        Plain::PotentialEnergy,
        "J",
        Nowhere,
        "of its weight over z = 0; of a whole robot with its joints' springs",
    ),
    told(
        "mechanical_energy",
        Plain::MechanicalEnergy,
        "J",
        Nowhere,
        "the sum of both",
    ),
    told(
        "grasped_by",
        Plain::GraspedBy,
        "",
        Nowhere,
        "the robot or person two of whose bodies hold it between them, or whose gripper it is attached to; `nobody` otherwise",
    ),
    told(
        "centre_height",
        Plain::Position(3),
        "m",
        World,
        "how high its centre of mass is",
    ),
    told(
        "turn_rate",
        Plain::AngularVelocity(2),
        "rad/s",
        World,
        "its angular velocity about the vertical, positive to the left",
    ),
];

/// Quantities of a joint: `JOINT.NAME`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OfJoint {
    Position,
    Velocity,
    DriveTorque,
    Torque,
    LimitDistance,
}

/// Units are those of a hinge; those of a slide stand in [`unit_of_slide`].
pub(super) const OF_JOINT: [Told<OfJoint>; 5] = [
    told(
        "position",
        OfJoint::Position,
        "rad",
        Nowhere,
        "its angle, of a wheel with all turns; of a slide its displacement, in m",
    ),
    told(
        "velocity",
        OfJoint::Velocity,
        "rad/s",
        Nowhere,
        "the rate of that, signed; of a slide in m/s",
    ),
    told(
        "drive_torque",
        OfJoint::DriveTorque,
        "Nm",
        Nowhere,
        "what its drives exert by their law and limit; of a slide a force, in N",
    ),
    told(
        "torque",
        OfJoint::Torque,
        "Nm",
        Nowhere,
        "what is passed on to its link about its axis; of a slide a force, in N",
    ),
    told(
        "limit_distance",
        OfJoint::LimitDistance,
        "rad",
        Nowhere,
        "how far its position is from the nearer of its limits, negative beyond; of a slide in m",
    ),
];

/// The unit of a slide's quantity.
pub(super) fn unit_of_slide(unit: &'static str) -> &'static str {
    match unit {
        "rad" => "m",
        "rad/s" => "m/s",
        "Nm" => "N",
        other => other,
    }
}

/// Quantities of a contact: `contact.OTHER.NAME`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OfContact {
    Touching,
    NormalForce,
    TangentialForce,
    Impulse,
    RelativeSpeed,
    Moving,
    OtherMoving,
    CausedBySelf,
    CausedByOther,
    OwnBody,
    OtherBody,
}

/// Largest ones are those of all time steps since the row before, so that no contact between two rows is missed.
pub(super) const OF_CONTACT: [Told<OfContact>; 11] = [
    told(
        "touching",
        OfContact::Touching,
        "",
        Nowhere,
        "whether they touched since the row before",
    ),
    told(
        "normal_force",
        OfContact::NormalForce,
        "N",
        Nowhere,
        "the largest sum of their normal forces since the row before",
    ),
    told(
        "tangential_force",
        OfContact::TangentialForce,
        "N",
        Nowhere,
        "the largest sum of the sizes of their friction forces since the row before",
    ),
    told(
        "impulse",
        OfContact::Impulse,
        "N*s",
        Nowhere,
        "normal force by time of the contact that is under way, or else of the last one",
    ),
    told(
        "relative_speed",
        OfContact::RelativeSpeed,
        "m/s",
        Nowhere,
        "the largest magnitude of the velocity between them where they touched, since the row before",
    ),
    told(
        "moving",
        OfContact::Moving,
        "",
        Nowhere,
        "whether it moved where it was touched when the contact began, faster than `truth.standing_below_m_s`",
    ),
    told(
        "other_moving",
        OfContact::OtherMoving,
        "",
        Nowhere,
        "whether the other moved there when the contact began",
    ),
    told(
        "caused_by_self",
        OfContact::CausedBySelf,
        "",
        Nowhere,
        "whether it moved into the other, faster than `truth.standing_below_m_s` along the normal: when the contact began, or later faster than the other moves",
    ),
    told(
        "caused_by_other",
        OfContact::CausedByOther,
        "",
        Nowhere,
        "whether the other moved into it",
    ),
    told(
        "own_body",
        OfContact::OwnBody,
        "",
        Nowhere,
        "its body that was touched hardest since the row before, or `none`",
    ),
    told(
        "other_body",
        OfContact::OtherBody,
        "",
        Nowhere,
        "the other's body that was",
    ),
];

/// Quantities of a region: `NAME.REGION`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum OfRegion {
    In,
    WhollyIn,
    DepthIn,
}

pub(super) const OF_REGION: [Told<OfRegion>; 3] = [
    told(
        "in",
        OfRegion::In,
        "",
        Nowhere,
        "whether its origin is in the region",
    ),
    told(
        "wholly_in",
        OfRegion::WhollyIn,
        "",
        Nowhere,
        "whether all of its surface is in the region",
    ),
    told(
        "depth_in",
        OfRegion::DepthIn,
        "m",
        Nowhere,
        "how far its origin is from the region's nearest side, negative outside",
    ),
];

/// Distances: `NAME.OTHER`.
pub(super) const DISTANCES: [Told<bool>; 2] = [
    told(
        "distance_to",
        true,
        "m",
        Nowhere,
        "the least distance between their surfaces, negative where they overlap, at most `simulation.longest_distance_m`",
    ),
    told(
        "origin_distance_to",
        false,
        "m",
        Nowhere,
        "the least distance between the origins of their frames",
    ),
];

/// What is asked for and there is not, and what to do instead.
pub(super) const PRESSURE: &str = "is not offered: bodies are rigid here and touch at points, so no engine computes an area of contact; divide `normal_force` by the area that was measured or is assumed, for example `/truth/arm.contact.anna.normal_force / (1 cm^2)`";

/// Whose quantity it can be, or why not.
pub(super) fn refusal(plain: Plain, part: &Part) -> Option<&'static str> {
    match plain {
        Plain::GraspedBy if part.kind != Kind::Object || !part.is_whole => {
            Some("is available for whole objects only")
        }
        Plain::GraspedBy if part.never_yields => Some("is available for loose objects only"),
        Plain::KineticEnergy
        | Plain::PotentialEnergy
        | Plain::MechanicalEnergy
        | Plain::Position(3) => match (part.kind, part.bodies.is_empty()) {
            (Kind::Person, _) => Some("is not known: people are moved as they go and have no mass"),
            (_, true) => Some(
                "is not known of what has no mass: a point of a tool, or what is fixed to the world; name the link",
            ),
            _ => None,
        },
        _ => None,
    }
}

/// The field of a recording that holds it.
pub(super) fn field_of<Q>(told: &Told<Q>, name: &str, unit: &str, part: &Part) -> Field {
    let field = match unit {
        "" => Field::bool(name),
        unit => Field::number(name, unit),
    };
    match told.frame {
        Frame::None => field,
        Frame::World => field.in_frame("world"),
        Frame::Body => field.in_frame(&part.label),
    }
}
