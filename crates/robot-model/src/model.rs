//! The tree: links, the joints that let them move, and what hangs on them.
//!
//! Frames: a link's frame is where the description puts it. `pose_in_parent` is the frame of a link in the frame of its
//! parent link (of the world, for a root) while all its joints stand at their reference positions. Joints, shapes,
//! sensors and marks are given in the frame of the link that they belong to. Units are SI: metres, radians, kilograms,
//! seconds, newtons.

use crate::actuator::{Actuator, Coupling};
use crate::mesh::Mesh;
use crate::pose::{Pose, Vector};
use crate::sensor::Sensor;
use crate::shape::{Inertial, Shape};

/// The language of a description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Format {
    /// Unified Robot Description Format (ROS).
    Urdf,
    /// Simulation Description Format (Gazebo).
    Sdf,
    /// MuJoCo's XML.
    Mjcf,
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Urdf => "URDF",
            Self::Sdf => "SDF",
            Self::Mjcf => "MJCF",
        })
    }
}

/// A robot, an object or a whole scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// The name that the description gives itself.
    pub name: String,
    /// The language it was written in.
    pub format: Format,
    /// Links, parents before their children, otherwise in the order of the text. Names are unique.
    pub links: Vec<Link>,
    /// Joints in the order in which positions are listed: by link, and from the parent outwards within a link.
    pub joints: Vec<Joint>,
    /// Triangle meshes that shapes name by index.
    pub meshes: Vec<Mesh>,
    /// Sensors.
    pub sensors: Vec<Sensor>,
    /// Drives, transmissions and interfaces of controllers.
    pub actuators: Vec<Actuator>,
    /// Joints that follow other joints.
    pub couplings: Vec<Coupling>,
    /// Named frames on links (sites of MJCF, frames of SDF).
    pub marks: Vec<Mark>,
    /// Pairs of links (indices) that never touch each other.
    pub no_contact: Vec<[usize; 2]>,
    /// Gravity in the world frame, if the description sets it, m/s².
    pub gravity_m_s2: Option<Vector>,
    /// Time step of the physics, if the description sets it.
    pub time_step_secs: Option<f64>,
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Unique name. Links of nested models are called `model::link`.
    pub name: String,
    /// Index of the link it hangs on; `None` for one that hangs on the world.
    pub parent: Option<usize>,
    /// Its frame in the parent's frame (the world's), all its joints at their references.
    pub pose_in_parent: Pose,
    /// Mass and inertia; `None` for a link that has none.
    pub inertial: Option<Inertial>,
    /// What it looks like and what it touches with.
    pub shapes: Vec<Shape>,
    /// Whether gravity acts on it.
    pub gravity: bool,
    /// Group of links that do not touch each other (all but neighbours do if `None`); see [`Link::touches_group`].
    pub contact_group: Option<String>,
    /// Whether its pose is set from outside and no force moves it (mocap bodies of MJCF, static models' links are
    /// simply without joints).
    pub kinematic: bool,
}

impl Link {
    /// Whether contact between the two links is to be computed as far as their groups say: links of one model of
    /// URDF or SDF do not touch each other unless the description asks for it.
    #[must_use]
    pub fn touches_group(&self, other: &Self) -> bool {
        self.contact_group.is_none() || self.contact_group != other.contact_group
    }
}

/// What a joint lets a link do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum JointKind {
    /// Nothing: a name for a rigid connection.
    Fixed,
    /// Turn about the axis; position in radians.
    Revolute,
    /// Slide along the axis; position in metres.
    Prismatic,
    /// Turn about the anchor in every direction; position is a unit quaternion (w, x, y, z).
    Ball,
    /// Move freely; position is the link's origin in metres and its unit quaternion (w, x, y, z), in the parent.
    Free,
}

impl JointKind {
    /// Numbers in a position.
    #[must_use]
    pub const fn position_size(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute | Self::Prismatic => 1,
            Self::Ball => 4,
            Self::Free => 7,
        }
    }

    /// Degrees of freedom.
    #[must_use]
    pub const fn freedoms(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute | Self::Prismatic => 1,
            Self::Ball => 3,
            Self::Free => 6,
        }
    }
}

impl std::fmt::Display for JointKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Fixed => "fixed",
            Self::Revolute => "revolute",
            Self::Prismatic => "prismatic",
            Self::Ball => "ball",
            Self::Free => "free",
        })
    }
}

/// The freedom of a link against its parent. A link may have several; they apply in order, from the parent outwards.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Unique name.
    pub name: String,
    /// Index of the link that it moves.
    pub link: usize,
    /// What it lets the link do.
    pub kind: JointKind,
    /// A point on the axis (the centre, for a ball), in the frame of the moved link.
    pub anchor_m: Vector,
    /// Unit axis in the frame of the moved link.
    pub axis: Vector,
    /// The position (rad or m) at which the link stands at `pose_in_parent`.
    pub reference: f64,
    /// Lowest and highest position (rad or m); for a ball, the second is the largest angle.
    pub limits: Option<[f64; 2]>,
    /// Largest force or torque of its drive, N or N m.
    pub effort_limit: Option<f64>,
    /// Largest speed, rad/s or m/s.
    pub velocity_limit: Option<f64>,
    /// Viscous damping, N m s/rad or N s/m.
    pub damping: f64,
    /// Dry friction, N m or N.
    pub friction: f64,
    /// Spring, N m/rad or N/m.
    pub stiffness: f64,
    /// Where the spring rests, rad or m.
    pub spring_reference: f64,
    /// Inertia of the rotor as seen at the joint, kg m² or kg.
    pub armature: f64,
}

impl Joint {
    /// A joint of `link` without limits, friction or springs; axis x through the link's origin.
    #[must_use]
    pub fn new(name: impl Into<String>, link: usize, kind: JointKind) -> Self {
        Self {
            name: name.into(),
            link,
            kind,
            anchor_m: [0.0; 3],
            axis: [1.0, 0.0, 0.0],
            reference: 0.0,
            limits: None,
            effort_limit: None,
            velocity_limit: None,
            damping: 0.0,
            friction: 0.0,
            stiffness: 0.0,
            spring_reference: 0.0,
            armature: 0.0,
        }
    }
}

/// A named frame on a link.
#[derive(Debug, Clone, PartialEq)]
pub struct Mark {
    /// Its name.
    pub name: String,
    /// Index of the link; `None` for the world.
    pub link: Option<usize>,
    /// The frame in the link's frame (the world's).
    pub pose_in_link: Pose,
}

impl Model {
    /// A model with nothing in it.
    #[must_use]
    pub fn empty(name: impl Into<String>, format: Format) -> Self {
        Self {
            name: name.into(),
            format,
            links: vec![],
            joints: vec![],
            meshes: vec![],
            sensors: vec![],
            actuators: vec![],
            couplings: vec![],
            marks: vec![],
            no_contact: vec![],
            gravity_m_s2: None,
            time_step_secs: None,
        }
    }

    /// Index of the link called `name`.
    #[must_use]
    pub fn link(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }

    /// Index of the joint called `name`.
    #[must_use]
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|joint| joint.name == name)
    }

    /// Links that hang on the world.
    pub fn roots(&self) -> impl Iterator<Item = usize> + '_ {
        let links = self.links.iter().enumerate();
        links.filter_map(|(index, link)| link.parent.is_none().then_some(index))
    }

    /// The joints of a link, from the parent outwards.
    pub fn joints_of(&self, link: usize) -> impl Iterator<Item = &Joint> + '_ {
        self.joints.iter().filter(move |joint| joint.link == link)
    }

    /// Adds a joint behind those of its link and of the links before it, and lets everything that names joints follow.
    pub fn insert_joint(&mut self, joint: Joint) {
        let behind = |known: &Joint| known.link > joint.link;
        let at = self
            .joints
            .iter()
            .position(behind)
            .unwrap_or(self.joints.len());
        let moved = |index: usize| if index >= at { index + 1 } else { index };
        self.joints.insert(at, joint);
        for actuator in &mut self.actuators {
            actuator.joint = moved(actuator.joint);
        }
        for coupling in &mut self.couplings {
            coupling.joint = moved(coupling.joint);
            coupling.leader = coupling.leader.map(moved);
        }
        for sensor in &mut self.sensors {
            if let Some(index) = sensor.kind.joint_mut() {
                *index = moved(*index);
            }
        }
    }

    /// Whether a link never moves: no joint with a freedom lies between it and the world.
    #[must_use]
    pub fn is_static(&self, link: usize) -> bool {
        let mut at = Some(link);
        while let Some(index) = at {
            let moves = self.links[index].kinematic
                || self.joints_of(index).any(|joint| joint.kind.freedoms() > 0);
            if moves {
                return false;
            }
            at = self.links[index].parent;
        }
        true
    }

    /// Sum of the links' masses.
    #[must_use]
    pub fn total_mass_kg(&self) -> f64 {
        let inertials = self.links.iter().filter_map(|link| link.inertial.as_ref());
        inertials.fold(0.0, |sum, inertial| sum + inertial.mass_kg)
    }

    /// Degrees of freedom of all joints.
    #[must_use]
    pub fn freedoms(&self) -> usize {
        self.joints.iter().map(|joint| joint.kind.freedoms()).sum()
    }
}
