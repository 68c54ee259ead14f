//! The tables of a scenario file, one type each. Units are in the names of the fields.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use testbench::geometry::{Vector, box_inertia, cylinder_inertia, sphere_inertia};
use testbench::{Distribution, ScenarioError};

/// Fails unless `value` is finite and greater than 0.
fn positive(key: &str, value: f64) -> Result<(), ScenarioError> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(ScenarioError::value(key, "must be a number greater than 0"))
    }
}

/// Fails unless `value` is finite and at least 0.
fn not_negative(key: &str, value: f64) -> Result<(), ScenarioError> {
    if value.is_finite() && value >= 0.0 {
        Ok(())
    } else {
        Err(ScenarioError::value(key, "must be a number of at least 0"))
    }
}

/// Time step, gravity and solver.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SimulationSettings {
    /// Length of a time step, at most 0.01.
    pub time_step_secs: f64,
    /// Gravity, downwards.
    pub gravity_m_s2: f64,
    /// How many iterations of Newton's method a step may take.
    pub solver_iterations: u32,
    /// Improvement below which the solver stops.
    pub solver_tolerance: f64,
    /// Iterations against slip after the solver; 0 for none.
    pub noslip_iterations: u32,
    /// How much stiffer friction is than the normal force: the larger, the less creep.
    pub impedance_ratio: f64,
    /// How long an episode goes on after the robot has ended or crashed.
    pub end_after_secs: f64,
    /// Length after which an episode is ended as it stands.
    pub longest_secs: f64,
    /// Lets less than the full physics stand in where less will do (see the crate's "Fast physics").
    #[serde(default)]
    pub fast: bool,
}

impl SimulationSettings {
    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        positive("simulation.time_step_secs", self.time_step_secs)?;
        if self.time_step_secs > 0.01 {
            return Err(ScenarioError::value(
                "simulation.time_step_secs",
                "is too long for contact physics: at most 0.01",
            ));
        }
        not_negative("simulation.gravity_m_s2", self.gravity_m_s2)?;
        not_negative("simulation.solver_tolerance", self.solver_tolerance)?;
        positive("simulation.impedance_ratio", self.impedance_ratio)?;
        not_negative("simulation.end_after_secs", self.end_after_secs)?;
        positive("simulation.longest_secs", self.longest_secs)
    }
}

/// How often things happen, in Hz. Each must divide the number of time steps in a second.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rates {
    /// How often the robot's code acts.
    pub controller_hz: u32,
    /// How often the tracking reads positions.
    pub tracking_hz: u32,
    /// How often gaze, pressure and location are judged.
    pub sensing_hz: u32,
    /// How often the truth is recorded.
    pub truth_record_hz: u32,
    /// How many readings of the tracking are recorded.
    pub tracking_record_hz: u32,
}

impl Rates {
    pub(super) fn check(&self, time_step_secs: f64) -> Result<(), ScenarioError> {
        for (key, hz) in [
            ("rates.controller_hz", self.controller_hz),
            ("rates.tracking_hz", self.tracking_hz),
            ("rates.sensing_hz", self.sensing_hz),
            ("rates.truth_record_hz", self.truth_record_hz),
            ("rates.tracking_record_hz", self.tracking_record_hz),
        ] {
            let steps = 1.0 / (f64::from(hz) * time_step_secs);
            if hz == 0 || steps < 0.999 || (steps - steps.round()).abs() > 1e-6 {
                return Err(ScenarioError::value(
                    key,
                    "must give a whole number of time steps in each period",
                ));
            }
        }
        Ok(())
    }

    /// Number of time steps between two events at `hz`.
    pub(crate) fn steps_between(hz: u32, time_step_secs: f64) -> u64 {
        (1.0 / (f64::from(hz) * time_step_secs)).round().max(1.0) as u64
    }
}

/// Joint angles in rad by name of the joint's body.
pub type JointAngles = BTreeMap<String, f64>;

/// The robot's body, poses and hand positions.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// The body whose frame counts as the hand.
    pub hand: String,
    /// The joints with finger encoders, in the order of the readings.
    pub fingers: Vec<String>,
    /// Share of the arm's weight carried by feed-forward, 0 to 1.
    pub gravity_compensation: f64,
    /// Reflected rotor inertia of each arm drive.
    pub joint_armature_kg_m2: f64,
    /// Reflected rotor inertia of each finger drive.
    pub finger_armature_kg_m2: f64,
    /// The arm's poses.
    pub poses: Poses,
    /// The hand's positions.
    pub hand_positions: HandPositions,
}

/// The arm's poses, in rad.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Poses {
    /// The pose about which the reset goes.
    pub neutral: JointAngles,
    /// Before the pick-up.
    pub prepare: JointAngles,
    /// Above the object.
    pub above: JointAngles,
    /// At the object.
    pub pickup: JointAngles,
    /// Where the object is offered.
    pub serve: JointAngles,
}

impl Poses {
    pub(super) fn named(&self) -> [(&'static str, &JointAngles); 5] {
        [
            ("neutral", &self.neutral),
            ("prepare", &self.prepare),
            ("above", &self.above),
            ("pickup", &self.pickup),
            ("serve", &self.serve),
        ]
    }
}

/// The hand's positions, in rad; `pregrasp` comes shortly before `grasp`.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandPositions {
    /// Open.
    pub open: JointAngles,
    /// What closes first.
    pub pregrasp: JointAngles,
    /// Closed.
    pub grasp: JointAngles,
}

impl HandPositions {
    pub(super) fn named(&self) -> [(&'static str, &JointAngles); 3] {
        [
            ("open", &self.open),
            ("pregrasp", &self.pregrasp),
            ("grasp", &self.grasp),
        ]
    }
}

/// What the robot's code does, and when.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Programme {
    /// The joints that the reset moves off the neutral pose.
    pub reset_joints: Vec<String>,
    /// How far from the neutral pose each of these joints goes in the reset.
    pub reset_spread_rad: Distribution,
    /// Length of the reset.
    pub reset_secs: f64,
    /// How near to its pose a joint has to be to have arrived.
    pub arrive_tolerance_rad: f64,
    /// How long to wait for a pose.
    pub arrive_timeout_secs: f64,
    /// How long the hand has for `pregrasp` before it closes.
    pub pregrasp_secs: f64,
    /// How long the hand has for `grasp`.
    pub grasp_secs: f64,
    /// How long the announcement takes.
    pub announce_secs: f64,
    /// How long to wait after the human's signal before sensing begins.
    pub wait_before_sensing_secs: f64,
    /// How long after sensing began the fingers are first read; less than `sensing_secs`.
    pub finger_baseline_secs: f64,
    /// How long readings are taken at least before the robot decides.
    pub sensing_secs: f64,
    /// How long sensing goes on at most for want of readings.
    pub sensing_timeout_secs: f64,
    /// How long to wait for the human's signal.
    pub ready_timeout_secs: f64,
    /// How long the hand has to open.
    pub release_secs: f64,
    /// How long to wait for the planner's answer.
    pub planner_timeout_secs: f64,
    /// How often a call that the planner has not answered in time is made again.
    #[serde(default)]
    pub planner_retries: u32,
}

impl Programme {
    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        self.reset_spread_rad
            .check("programme.reset_spread_rad", -3.2, 3.2)?;
        positive("programme.arrive_tolerance_rad", self.arrive_tolerance_rad)?;
        for (key, secs) in [
            ("programme.reset_secs", self.reset_secs),
            ("programme.arrive_timeout_secs", self.arrive_timeout_secs),
            ("programme.pregrasp_secs", self.pregrasp_secs),
            ("programme.grasp_secs", self.grasp_secs),
            ("programme.announce_secs", self.announce_secs),
            (
                "programme.wait_before_sensing_secs",
                self.wait_before_sensing_secs,
            ),
            ("programme.finger_baseline_secs", self.finger_baseline_secs),
            ("programme.sensing_secs", self.sensing_secs),
            ("programme.sensing_timeout_secs", self.sensing_timeout_secs),
            ("programme.ready_timeout_secs", self.ready_timeout_secs),
            ("programme.release_secs", self.release_secs),
            ("programme.planner_timeout_secs", self.planner_timeout_secs),
        ] {
            not_negative(key, secs)?;
        }
        if self.finger_baseline_secs >= self.sensing_secs {
            return Err(ScenarioError::value(
                "programme.finger_baseline_secs",
                "must be less than programme.sensing_secs",
            ));
        }
        Ok(())
    }
}

/// How one sensor's readings become its report at the decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SensorRule {
    /// Satisfied at some reading since sensing began.
    Any,
    /// Satisfied by the last reading.
    Last,
}

/// How the robot judges the human.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sensors {
    /// Counts of a finger encoder.
    pub finger_counts_per_rad: f64,
    /// More counts than the first and fewer than the second mean pressure.
    pub pressure_counts: [i64; 2],
    /// Radius of the gaze cone at the head.
    pub gaze_head_radius_m: f64,
    /// Half the angle of the gaze cone.
    pub gaze_half_angle_rad: f64,
    /// From the object's centre to where a hand is expected.
    pub location_offset_m: Vector,
    /// How far from there the hand may be, in each axis.
    pub location_tolerance_m: Vector,
    /// Which readings of the gaze count.
    pub gaze_rule: SensorRule,
    /// Which readings of the pressure count.
    pub pressure_rule: SensorRule,
    /// Which readings of the location count.
    pub location_rule: SensorRule,
}

/// Where a tracking glitch reports the object: uniform in a box of the world.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackingVolume {
    /// The lowest corner of the box.
    pub glitch_low_m: Vector,
    /// The highest corner of the box.
    pub glitch_high_m: Vector,
}

/// How the truth is judged, apart from the robot's sensors.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruthRules {
    /// From the object's centre to where the hand holds it.
    pub in_hand_offset_m: Vector,
    /// How far from there the hand may be, in each axis.
    pub in_hand_tolerance_m: Vector,
    /// Weaker pulls are not counted as pulls.
    pub weakest_pull_newtons: f64,
}

/// The object: a cylinder that stands on the pedestal.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Object {
    /// Length, more than 2.5 times the radius.
    pub length_m: f64,
    /// Radius.
    pub radius_m: f64,
    /// Where its centre stands on the pedestal, x and y.
    pub position_m: [f64; 2],
    /// Published moments of inertia, used by parameter sets that ask for placeholders.
    pub placeholder_inertia_kg_m2: Vector,
    /// Coulomb friction on the pedestal's top.
    pub pedestal_friction: f64,
}

impl Object {
    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        positive("object.radius_m", self.radius_m)?;
        if !(self.length_m.is_finite() && self.length_m > 2.5 * self.radius_m) {
            return Err(ScenarioError::value(
                "object.length_m",
                "must be more than 2.5 times object.radius_m",
            ));
        }
        positive("object.pedestal_friction", self.pedestal_friction)?;
        self.placeholder_inertia_kg_m2
            .iter()
            .try_for_each(|moment| positive("object.placeholder_inertia_kg_m2", *moment))
    }
}

/// The cylinder the object stands on.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pedestal {
    /// Its centre.
    pub centre_m: Vector,
    /// Its height.
    pub length_m: f64,
    /// Its radius.
    pub radius_m: f64,
}

impl Pedestal {
    /// Height of its top above the floor.
    #[must_use]
    pub fn top_m(&self) -> f64 {
        self.centre_m[2] + self.length_m / 2.0
    }
}

/// The human's body and reach.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Human {
    /// Where the head is.
    pub head_position_m: Vector,
    /// Where the hand rests.
    pub hand_rest_m: Vector,
    /// From the object's centre to the hand's centre, when the hand is on it.
    pub hand_on_object_m: Vector,
    /// Edge lengths of the hand.
    pub hand_box_m: Vector,
    /// How long one movement of the hand takes (minimum jerk).
    pub reach_secs: f64,
    /// The hand does not reach for an object lower than this, which has been dropped.
    pub reach_lowest_object_m: f64,
    /// How long a pull lasts.
    pub pull_secs: f64,
    /// How long a pull grows to its force.
    pub pull_onset_secs: f64,
    /// An object that comes along further than this is held on to.
    pub pull_travel_m: f64,
    /// Height above the object's centre at which the pull acts.
    pub pull_line_m: f64,
    /// A signal that has not come by then is given up.
    pub patience_secs: f64,
    /// Stiffness with which the hand carries the object once the robot has let go.
    pub hold_stiffness_n_m: f64,
    /// Damping of the same.
    pub hold_damping_ns_m: f64,
    /// Largest force of the same.
    pub hold_limit_newtons: f64,
    /// Stiffness against turning of the same.
    pub hold_torque_nm_rad: f64,
    /// Damping against turning of the same.
    pub hold_torque_damping_nms_rad: f64,
}

impl Human {
    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        positive("human.reach_secs", self.reach_secs)?;
        positive("human.pull_secs", self.pull_secs)?;
        positive("human.pull_onset_secs", self.pull_onset_secs)?;
        not_negative("human.hold_stiffness_n_m", self.hold_stiffness_n_m)?;
        not_negative("human.hold_damping_ns_m", self.hold_damping_ns_m)?;
        not_negative("human.hold_limit_newtons", self.hold_limit_newtons)
    }
}

/// A solid whose mass is spread evenly.
#[derive(Debug, Clone, Copy, PartialEq, JsonSchema, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
pub enum Shape {
    /// A box.
    Box {
        /// Full edge lengths.
        box_m: Vector,
    },
    /// A cylinder along z.
    Cylinder {
        /// Its length.
        cylinder_length_m: f64,
        /// Its radius.
        cylinder_radius_m: f64,
    },
    /// A ball.
    Sphere {
        /// Its radius.
        sphere_radius_m: f64,
    },
    /// A capsule along y, as the finger segments are.
    Capsule {
        /// Its length, with the round ends.
        capsule_length_m: f64,
        /// Its radius.
        capsule_radius_m: f64,
    },
}

impl Shape {
    /// Principal moments of inertia about the shape's centre, kg m², in its own frame. A capsule
    /// counts as the cylinder of its length.
    #[must_use]
    pub fn inertia_kg_m2(&self, mass_kg: f64) -> Vector {
        match *self {
            Self::Box { box_m } => box_inertia(mass_kg, box_m),
            Self::Cylinder {
                cylinder_length_m,
                cylinder_radius_m,
            } => cylinder_inertia(mass_kg, cylinder_length_m, cylinder_radius_m),
            Self::Sphere { sphere_radius_m } => sphere_inertia(mass_kg, sphere_radius_m),
            Self::Capsule {
                capsule_length_m,
                capsule_radius_m,
            } => {
                let [across, _, along] =
                    cylinder_inertia(mass_kg, capsule_length_m, capsule_radius_m);
                [across, along, across]
            }
        }
    }

    fn check(&self, key: &str) -> Result<(), ScenarioError> {
        match *self {
            Self::Box { box_m } => box_m.iter().try_for_each(|edge| positive(key, *edge)),
            Self::Cylinder {
                cylinder_length_m: length,
                cylinder_radius_m: radius,
            } => positive(key, length).and_then(|()| positive(key, radius)),
            Self::Sphere { sphere_radius_m } => positive(key, sphere_radius_m),
            Self::Capsule {
                capsule_length_m,
                capsule_radius_m,
            } => {
                positive(key, capsule_radius_m)?;
                positive(key, capsule_length_m - 2.0 * capsule_radius_m)
            }
        }
    }
}

/// Which servos move a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Drive {
    /// A position servo of the arm, with gains of its own.
    Arm,
    /// A finger drive, with the gains of the parameter set.
    Hand,
}

/// A hinge between a body and its parent.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// Axis in the body's frame.
    pub axis: Vector,
    /// Lowest and highest angle.
    pub range_rad: [f64; 2],
    /// What moves it.
    pub drive: Drive,
    /// Largest torque.
    pub effort_limit_nm: f64,
    /// Largest speed.
    pub speed_limit_rad_s: f64,
    /// Proportional gain of an arm servo.
    #[serde(default)]
    pub stiffness_nm_rad: f64,
    /// Derivative gain of an arm servo.
    #[serde(default)]
    pub damping_nms_rad: f64,
}

/// A link of the robot.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// Unique name.
    pub name: String,
    /// The body it hangs on, or `world`.
    pub parent: String,
    /// Origin of its frame in the parent's frame.
    pub position_m: Vector,
    /// Orientation of its frame in the parent's, about fixed axes.
    pub rotation_rpy_rad: Vector,
    /// Axis of a joint that is held at `fixed_angle_rad`.
    #[serde(default)]
    pub fixed_axis: Vector,
    /// Angle of a joint that is held.
    #[serde(default)]
    pub fixed_angle_rad: f64,
    /// Mass.
    pub mass_kg: f64,
    /// The solid that gives the mass its inertia.
    pub shape: Shape,
    /// Centre of the solid in the body's frame.
    #[serde(default)]
    pub shape_position_m: Vector,
    /// Published moments of inertia, used by parameter sets that ask for placeholders.
    pub placeholder_inertia_kg_m2: Vector,
    /// What can touch the object, centred as `shape`.
    pub contact_shape: Option<Shape>,
    /// The joint to the parent, if it moves.
    pub joint: Option<Joint>,
}

impl Body {
    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        let key = |field: &str| format!("body.{}.{field}", self.name);
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if self.name.is_empty() || !self.name.chars().all(plain) {
            return Err(ScenarioError::value(
                &key("name"),
                "must consist of letters, digits and underscores",
            ));
        }
        positive(&key("mass_kg"), self.mass_kg)?;
        self.shape.check(&key("shape"))?;
        for moment in self.placeholder_inertia_kg_m2 {
            positive(&key("placeholder_inertia_kg_m2"), moment)?;
        }
        if let Some(shape) = &self.contact_shape {
            shape.check(&key("contact_shape"))?;
        }
        let Some(joint) = &self.joint else {
            return Ok(());
        };
        if joint.axis.iter().all(|component| *component == 0.0) {
            return Err(ScenarioError::value(&key("joint.axis"), "must not be zero"));
        }
        if joint.range_rad[0] >= joint.range_rad[1] {
            return Err(ScenarioError::value(
                &key("joint.range_rad"),
                "must have its lowest first",
            ));
        }
        positive(&key("joint.effort_limit_nm"), joint.effort_limit_nm)?;
        positive(&key("joint.speed_limit_rad_s"), joint.speed_limit_rad_s)?;
        if joint.drive == Drive::Arm {
            positive(&key("joint.stiffness_nm_rad"), joint.stiffness_nm_rad)?;
            not_negative(&key("joint.damping_nms_rad"), joint.damping_nms_rad)?;
        }
        Ok(())
    }
}
