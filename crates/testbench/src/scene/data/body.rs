//! Robots, objects and drives in a scene's file.

use std::collections::BTreeMap;
use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use stimulus::Distribution;

use super::actuator::{ActuatorFault, hundred};
use super::{Gripper, Group, ToolPoint};
use super::{key_of, number_within, within, zero};
use crate::bench::ScenarioError;
use crate::controller::PortField;
use crate::geometry::Vector;
use crate::scene::load::Description;

/// Where something stands at the beginning, in the world.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[allow(missing_docs, reason = "names carry quantity and unit")]
pub struct PlaceKeys {
    #[serde(default = "zero")]
    pub x_m: Distribution,
    #[serde(default = "zero")]
    pub y_m: Distribution,
    #[serde(default = "zero")]
    pub z_m: Distribution,
    #[serde(default = "zero")]
    pub yaw_rad: Distribution,
}

impl PlaceKeys {
    /// The numbers with their keys.
    pub(in crate::scene) fn fields(&self) -> [(&'static str, &Distribution); 4] {
        [
            ("x_m", &self.x_m),
            ("y_m", &self.y_m),
            ("z_m", &self.z_m),
            ("yaw_rad", &self.yaw_rad),
        ]
    }

    fn check(&self, list: &str, name: &str) -> Result<(), ScenarioError> {
        for (field, distribution) in self.fields() {
            within(&key_of(list, name, field), distribution, -1e4, 1e4)?;
        }
        Ok(())
    }
}

/// A value of an argument of a description.
#[derive(Debug, Clone, PartialEq, JsonSchema, Deserialize)]
#[serde(untagged)]
pub enum Argument {
    /// `true` or `false`.
    Truth(bool),
    /// A whole number.
    Whole(i64),
    /// Another number.
    Number(f64),
    /// A text.
    Text(String),
}

impl fmt::Display for Argument {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Truth(value) => value.fmt(out),
            Self::Whole(value) => value.fmt(out),
            Self::Number(value) => fmt::Debug::fmt(value, out),
            Self::Text(value) => value.fmt(out),
        }
    }
}

/// A robot: a description of its links and joints, and where it stands.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// Its name.
    pub name: String,
    /// URDF (also in xacro), SDF or MJCF, relative to the scene's file.
    pub file: String,
    /// Values of the arguments (`xacro:arg`) of a description in xacro, by name: texts, numbers or truth values.
    #[serde(default)]
    pub arguments: BTreeMap<String, Argument>,
    /// Where its root stands.
    #[serde(default = "zero")]
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub x_m: Distribution,
    /// Where it stands at first, to the left.
    #[serde(default = "zero")]
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub y_m: Distribution,
    /// Where it stands at first, upwards.
    #[serde(default = "zero")]
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub z_m: Distribution,
    /// Where it faces at first, from the x axis to the left.
    #[serde(default = "zero")]
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub yaw_rad: Distribution,
    /// Whether its root is fixed to the world.
    #[serde(default)]
    pub fixed: bool,
    /// Positions of joints at the beginning, in rad or m; others are where the description has
    /// them.
    #[serde(default)]
    pub joints: BTreeMap<String, Distribution>,
    /// Friction of shapes whose description gives none.
    #[serde(default = "half")]
    pub friction: Distribution,
    /// What its shapes are made of: one of the scene's materials.
    pub material: Option<String>,
    /// What the shapes of single links are made of, by link.
    #[serde(default)]
    pub materials: BTreeMap<String, String>,
    /// What one joint's friction, damping and drive inertia are, over what the description says.
    #[serde(default)]
    pub joint_friction: BTreeMap<String, Distribution>,
    /// Joints whose positions and velocities are recorded.
    #[serde(default)]
    pub recorded_joints: Vec<String>,
    /// Those of them that slide, by the description: their positions are lengths.
    #[serde(skip)]
    pub sliding_joints: Vec<String>,
}

/// Something else, fixed or loose: a wall, a box, a table.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Its name.
    pub name: String,
    /// URDF, SDF or MJCF, relative to the scene's file; or else one of the forms below.
    pub file: Option<String>,
    /// A cuboid's edges.
    pub box_m: Option<Vector>,
    /// A cylinder's radius; with `length_m`, upright.
    pub radius_m: Option<f64>,
    /// See `radius_m`; without it the object is a ball.
    pub length_m: Option<f64>,
    /// Its mass if it is loose; fixed to the world without one.
    pub mass_kg: Option<Distribution>,
    /// Whether an object from a file is fixed to the world.
    #[serde(default)]
    pub fixed: bool,
    /// Its Coulomb friction.
    #[serde(default = "half")]
    pub friction: Distribution,
    /// What it is made of: one of the scene's materials.
    pub material: Option<String>,
    /// Where its centre (or its file's root) stands.
    #[serde(default = "zero")]
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub x_m: Distribution,
    /// Where it stands at first, to the left.
    #[serde(default = "zero")]
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub y_m: Distribution,
    /// Where it stands at first, upwards.
    #[serde(default = "zero")]
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub z_m: Distribution,
    /// Where it faces at first, from the x axis to the left.
    #[serde(default = "zero")]
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub yaw_rad: Distribution,
}

fn half() -> Distribution {
    Distribution::Constant(0.5)
}

/// The four keys of a place, gathered.
macro_rules! place_of {
    ($thing:expr) => {
        PlaceKeys {
            x_m: $thing.x_m.clone(),
            y_m: $thing.y_m.clone(),
            z_m: $thing.z_m.clone(),
            yaw_rad: $thing.yaw_rad.clone(),
        }
    };
}

impl Robot {
    /// Its description: the file, with the values of its arguments; robots of the same share what is read.
    pub(in crate::scene) fn description(&self) -> Description {
        let text = |(name, value): (&String, &Argument)| (name.clone(), value.to_string());
        (self.file.clone(), self.arguments.iter().map(text).collect())
    }

    /// Where it stands.
    #[must_use]
    pub fn place(&self) -> PlaceKeys {
        place_of!(self)
    }

    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        self.place().check("robot", &self.name)?;
        let key = |field: &str| key_of("robot", &self.name, field);
        within(&key("friction"), &self.friction, 0.0, 10.0)?;
        for (joint, position) in &self.joints {
            within(&key(&format!("joints.{joint}")), position, -1e4, 1e4)?;
        }
        for (joint, friction) in &self.joint_friction {
            within(&key(&format!("joint_friction.{joint}")), friction, 0.0, 1e6)?;
        }
        Ok(())
    }
}

impl Object {
    /// Its description, if it has one.
    pub(in crate::scene) fn description(&self) -> Option<Description> {
        Some((self.file.clone()?, robot_model::Arguments::new()))
    }

    /// Where it stands.
    #[must_use]
    pub fn place(&self) -> PlaceKeys {
        place_of!(self)
    }

    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        self.place().check("object", &self.name)?;
        let key = |field: &str| key_of("object", &self.name, field);
        within(&key("friction"), &self.friction, 0.0, 10.0)?;
        if let Some(mass_kg) = &self.mass_kg {
            within(&key("mass_kg"), mass_kg, 1e-6, 1e6)?;
        }
        let forms = [
            self.file.is_some(),
            self.box_m.is_some(),
            self.radius_m.is_some(),
        ];
        if forms.iter().filter(|given| **given).count() != 1 {
            let problem = "needs exactly one of `file`, `box_m` and `radius_m`";
            return Err(ScenarioError::value(&key("form"), problem));
        }
        let lengths = self.box_m.iter().flatten();
        for length in lengths.chain(&self.radius_m).chain(&self.length_m) {
            number_within(&key("size"), *length, 1e-6, 1e4)?;
        }
        Ok(())
    }
}

/// A drive, or several that are commanded together.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
pub struct Actuator {
    /// Its name, by which a controller commands it.
    pub name: String,
    /// The robot it belongs to.
    pub robot: String,
    /// Standard deviation of normal noise on commands, by field with its unit: `effort_nm = 0.1`.
    #[serde(default)]
    pub noise: BTreeMap<String, Distribution>,
    /// How often noise is drawn anew; in between it stays.
    #[serde(default = "hundred")]
    pub noise_hz: f64,
    /// A constant error of an episode, by field with its unit.
    #[serde(default)]
    pub bias: BTreeMap<String, Distribution>,
    /// Faults that may occur.
    #[serde(default, rename = "fault")]
    pub faults: Vec<ActuatorFault>,
    /// The list of the scene that it stands in, by which its numbers are drawn.
    #[serde(skip, default = "own_list")]
    pub(in crate::scene) list: &'static str,
    /// What it drives, and how.
    #[serde(flatten)]
    pub kind: ActuatorKind,
}

/// The list of actuators.
fn own_list() -> &'static str {
    "actuator"
}

/// What an actuator drives.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[allow(missing_docs, reason = "names carry quantity and unit")]
pub enum ActuatorKind {
    /// One joint to a position: command `position`.
    Position {
        /// The joint that it drives.
        joint: String,
        /// Torque or force for each rad or m of error.
        stiffness: f64,
        /// Torque or force for each rad/s or m/s of velocity.
        damping: f64,
        /// The largest torque (Nm) or force (N).
        limit: f64,
    },
    /// One joint to a velocity: command `velocity`.
    Velocity {
        /// The joint that it drives.
        joint: String,
        /// Torque or force for each rad/s or m/s of error.
        gain: f64,
        /// The largest torque (Nm) or force (N).
        limit: f64,
    },
    /// One joint by torque or force: command `effort`.
    Effort {
        /// The joint that it drives.
        joint: String,
        /// The largest torque (Nm) or force (N).
        limit: f64,
    },
    /// Wheels left and right: commands `speed` (m/s, forwards) and `turn_rate` (rad/s, to the
    /// left), reached at a limited acceleration.
    DifferentialDrive {
        /// The joints of the wheels on the left.
        left_joints: Vec<String>,
        /// The joints of the wheels on the right.
        right_joints: Vec<String>,
        /// The radius of the wheels.
        wheel_radius_m: f64,
        /// The distance between left and right wheels.
        wheel_separation_m: f64,
        /// The highest speed that is commanded to the wheels or the base.
        longest_speed_m_s: f64,
        /// The highest turn rate.
        longest_turn_rate_rad_s: f64,
        /// How fast it gets faster.
        acceleration_m_s2: Distribution,
        /// How fast it gets slower.
        deceleration_m_s2: Distribution,
        /// How fast its turn rate changes.
        turn_acceleration_rad_s2: f64,
        /// Torque of a wheel for each rad/s of error.
        gain_nms_rad: f64,
        /// The largest torque: of a wheel, or about the base's vertical axis.
        torque_limit_nm: f64,
    },
    /// A base that can move in every direction on the floor: commands `forward`, `left` (m/s, in
    /// the base's frame) and `turn_rate` (rad/s), reached by limited forces on its root.
    PlanarVelocity {
        /// The highest speed that is commanded to the wheels or the base.
        longest_speed_m_s: f64,
        /// The highest turn rate.
        longest_turn_rate_rad_s: f64,
        /// Force for each m/s of error.
        gain_ns_m: f64,
        /// Torque for each rad/s of error.
        turn_gain_nms_rad: f64,
        /// The largest force on the base.
        force_limit_newtons: f64,
        /// The largest torque: of a wheel, or about the base's vertical axis.
        torque_limit_nm: f64,
    },
    /// A group of the scene, not given as an actuator.
    #[serde(skip)]
    JointGroup(Box<JointGroup>),
    /// A gripper of the scene, not given as an actuator.
    #[serde(skip)]
    Gripper(Box<Gripper>),
}

/// A group with what follows from its robot's description.
#[derive(Debug, Clone)]
pub struct JointGroup {
    /// As the scene gives it.
    pub group: Group,
    /// Its tool point.
    pub tool: Option<ToolPoint>,
    /// Which of its joints are slides.
    pub is_slide: Vec<bool>,
    /// The largest torque or force of each joint.
    pub torque_limit: Vec<f64>,
    /// The highest speed of each.
    pub velocity_limit: Vec<f64>,
}

impl Actuator {
    /// A group or a gripper, which controllers command as any actuator.
    pub(super) fn of(
        (list, name, robot): (&'static str, &str, &str),
        faults: &[ActuatorFault],
        kind: ActuatorKind,
    ) -> Self {
        Self {
            name: name.to_owned(),
            robot: robot.to_owned(),
            noise: BTreeMap::new(),
            noise_hz: hundred(),
            bias: BTreeMap::new(),
            faults: faults.to_vec(),
            list,
            kind,
        }
    }

    /// The fields of its commands.
    #[must_use]
    pub fn fields(&self) -> Vec<PortField> {
        crate::scene::actuating::fields_of(&self.kind)
    }

    pub(super) fn check(&self, time_step_secs: f64) -> Result<(), ScenarioError> {
        self.check_errors(time_step_secs)?;
        let key = |field: &str| key_of("actuator", &self.name, field);
        for (field, value) in self.kind.positive() {
            number_within(&key(field), value, 1e-9, 1e9)?;
        }
        if let ActuatorKind::DifferentialDrive {
            left_joints,
            right_joints,
            acceleration_m_s2,
            deceleration_m_s2,
            ..
        } = &self.kind
        {
            within(&key("acceleration_m_s2"), acceleration_m_s2, 1e-3, 1e3)?;
            within(&key("deceleration_m_s2"), deceleration_m_s2, 1e-3, 1e3)?;
            if left_joints.is_empty() || right_joints.is_empty() {
                let problem = "is empty; a drive needs joints on both sides";
                return Err(ScenarioError::value(
                    &key("left_joints, right_joints"),
                    problem,
                ));
            }
        }
        Ok(())
    }
}

impl ActuatorKind {
    /// The joints that it drives.
    #[must_use]
    pub fn joints(&self) -> Vec<&str> {
        match self {
            Self::Position { joint, .. }
            | Self::Velocity { joint, .. }
            | Self::Effort { joint, .. } => vec![joint],
            Self::DifferentialDrive {
                left_joints,
                right_joints,
                ..
            } => left_joints
                .iter()
                .chain(right_joints)
                .map(String::as_str)
                .collect(),
            Self::JointGroup(group) => group.group.joints.iter().map(String::as_str).collect(),
            Self::Gripper(gripper) => gripper.joints().iter().map(String::as_str).collect(),
            Self::PlanarVelocity { .. } => Vec::new(),
        }
    }

    /// Numbers that have to be above 0.
    fn positive(&self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Position {
                stiffness, limit, ..
            } => vec![("stiffness", *stiffness), ("limit", *limit)],
            Self::Velocity { gain, limit, .. } => vec![("gain", *gain), ("limit", *limit)],
            Self::Effort { limit, .. } => vec![("limit", *limit)],
            Self::JointGroup(_) | Self::Gripper(_) => Vec::new(),
            Self::DifferentialDrive {
                wheel_radius_m,
                wheel_separation_m,
                longest_speed_m_s,
                longest_turn_rate_rad_s,
                turn_acceleration_rad_s2,
                gain_nms_rad,
                torque_limit_nm,
                ..
            } => vec![
                ("wheel_radius_m", *wheel_radius_m),
                ("wheel_separation_m", *wheel_separation_m),
                ("longest_speed_m_s", *longest_speed_m_s),
                ("longest_turn_rate_rad_s", *longest_turn_rate_rad_s),
                ("turn_acceleration_rad_s2", *turn_acceleration_rad_s2),
                ("gain_nms_rad", *gain_nms_rad),
                ("torque_limit_nm", *torque_limit_nm),
            ],
            Self::PlanarVelocity {
                longest_speed_m_s,
                longest_turn_rate_rad_s,
                gain_ns_m,
                turn_gain_nms_rad,
                force_limit_newtons,
                torque_limit_nm,
            } => vec![
                ("longest_speed_m_s", *longest_speed_m_s),
                ("longest_turn_rate_rad_s", *longest_turn_rate_rad_s),
                ("gain_ns_m", *gain_ns_m),
                ("turn_gain_nms_rad", *turn_gain_nms_rad),
                ("force_limit_newtons", *force_limit_newtons),
                ("torque_limit_nm", *torque_limit_nm),
            ],
        }
    }
}
