//! The parameter set: what tuning changes. Units are in the names of the fields.

use schemars::JsonSchema;
use serde::Deserialize;
use testbench::{Distribution, ScenarioError};

/// Where inertias come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InertiaSource {
    /// From shape and mass, by the formulas for solids.
    Geometry,
    /// The published placeholder moments.
    Placeholder,
}

/// A named set of physical and fault parameters.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// What the set is called in reports and in the trace's metadata.
    pub name: String,
    /// Where inertias come from.
    pub inertia: InertiaSource,
    /// The object's mass and placement.
    pub object: ObjectParameters,
    /// The hand's drives and skin.
    pub hand: HandParameters,
    /// The arm's speeds.
    pub arm: ArmParameters,
    /// Noise and glitches of tracking.
    pub tracking: TrackingParameters,
    /// Answer time and failures of the motion planner.
    pub planner: PlannerParameters,
    /// Where the human stands, looks and pulls.
    pub human: HumanDraws,
}

/// The object's mass and its place on the pedestal.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectParameters {
    /// Mass.
    pub mass_kg: Distribution,
    /// How far the object stands off its place along x.
    pub x_error_m: Distribution,
    /// How far the object stands off its place along y.
    pub y_error_m: Distribution,
    /// How far the object is turned about its axis.
    pub yaw_rad: Distribution,
}

/// The hand's drives and skin.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HandParameters {
    /// Coulomb friction between hand and object.
    pub friction: Distribution,
    /// Time constant of a contact: the larger, the softer the skin.
    pub contact_time_constant_secs: f64,
    /// Proportional gain of a finger's servo.
    pub stiffness_nm_rad: f64,
    /// Derivative gain of a finger's servo.
    pub damping_nms_rad: f64,
    /// Largest torque of a finger drive.
    pub torque_limit_nm: f64,
    /// Torque by which dry friction holds a finger joint.
    pub friction_loss_nm: f64,
    /// Time constant of a joint's stop: the larger, the softer the stop.
    pub stop_time_constant_secs: f64,
}

/// How fast the arm moves.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmParameters {
    /// Highest speed of a joint while the robot's code restricts it.
    pub restricted_speed_rad_s: f64,
    /// Speed of a joint while it is not restricted, as in the reset.
    pub reset_speed_rad_s: f64,
    /// Acceleration of the arm's joints.
    pub acceleration_rad_s2: f64,
}

/// Noise and glitches of tracking.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackingParameters {
    /// Probability that a reading is a glitch.
    pub glitch_rate_per_reading: f64,
    /// Standard deviation of a position in each axis.
    pub noise_m: f64,
}

/// Answer time and failures of the motion planner.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannerParameters {
    /// Probability that one of the five requests of a run is never answered.
    pub failure_rate_per_run: f64,
    /// How long an answer takes.
    pub answer_secs: Distribution,
}

/// What is drawn for the human in each episode.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HumanDraws {
    /// How far the head is above `head_position_m` of the scenario.
    pub head_height_offset_m: Distribution,
    /// By which angle a gaze at the object misses it.
    pub yaw_error_rad: Distribution,
    /// By which angle a gaze away from the object misses it.
    pub yaw_error_when_away_rad: Distribution,
    /// Force of the pull, towards the human.
    pub pull_forward_newtons: Distribution,
    /// Force of the pull, upwards.
    pub pull_up_newtons: Distribution,
}

impl Parameters {
    /// Parses and checks a parameter set.
    ///
    /// # Errors
    /// [`ScenarioError`] with the place and what to do about it.
    pub fn parse(text: &str) -> Result<Self, ScenarioError> {
        let parameters: Self = toml::from_str(text).map_err(|error| ScenarioError::Syntax {
            reason: error.to_string(),
        })?;
        parameters.check()?;
        Ok(parameters)
    }

    /// As [`Parameters::parse`], of a table that is read already.
    ///
    /// # Errors
    /// As [`Parameters::parse`], without lines.
    pub fn from_table(table: toml::Table) -> Result<Self, ScenarioError> {
        let parameters: Self = table.try_into().map_err(|error: toml::de::Error| {
            let reason = error.to_string();
            ScenarioError::Syntax { reason }
        })?;
        parameters.check()?;
        Ok(parameters)
    }

    fn check(&self) -> Result<(), ScenarioError> {
        self.object.mass_kg.check("object.mass_kg", 1e-3, 100.0)?;
        let anywhere = f64::INFINITY;
        self.object
            .x_error_m
            .check("object.x_error_m", -anywhere, anywhere)?;
        self.object
            .y_error_m
            .check("object.y_error_m", -anywhere, anywhere)?;
        self.object
            .yaw_rad
            .check("object.yaw_rad", -anywhere, anywhere)?;
        self.hand.friction.check("hand.friction", 1e-3, 10.0)?;
        for (key, value, low, high) in self.numbers() {
            Distribution::Constant(value).check(key, low, high)?;
        }
        self.planner
            .answer_secs
            .check("planner.answer_secs", 0.0, 3600.0)?;
        self.human.check()
    }

    /// The plain numbers, each with the range it must lie in.
    fn numbers(&self) -> [(&'static str, f64, f64, f64); 12] {
        let (hand, arm) = (&self.hand, &self.arm);
        [
            (
                "hand.contact_time_constant_secs",
                hand.contact_time_constant_secs,
                1e-3,
                1.0,
            ),
            ("hand.stiffness_nm_rad", hand.stiffness_nm_rad, 1e-6, 1e6),
            ("hand.damping_nms_rad", hand.damping_nms_rad, 0.0, 1e6),
            ("hand.torque_limit_nm", hand.torque_limit_nm, 1e-6, 1e6),
            ("hand.friction_loss_nm", hand.friction_loss_nm, 0.0, 1e6),
            (
                "hand.stop_time_constant_secs",
                hand.stop_time_constant_secs,
                1e-3,
                1.0,
            ),
            (
                "arm.restricted_speed_rad_s",
                arm.restricted_speed_rad_s,
                1e-6,
                100.0,
            ),
            ("arm.reset_speed_rad_s", arm.reset_speed_rad_s, 1e-6, 100.0),
            (
                "arm.acceleration_rad_s2",
                arm.acceleration_rad_s2,
                1e-6,
                1e4,
            ),
            (
                "tracking.glitch_rate_per_reading",
                self.tracking.glitch_rate_per_reading,
                0.0,
                1.0,
            ),
            ("tracking.noise_m", self.tracking.noise_m, 0.0, 1.0),
            (
                "planner.failure_rate_per_run",
                self.planner.failure_rate_per_run,
                0.0,
                1.0,
            ),
        ]
    }
}

impl HumanDraws {
    fn check(&self) -> Result<(), ScenarioError> {
        self.head_height_offset_m
            .check("human.head_height_offset_m", -2.0, 2.0)?;
        self.yaw_error_rad.check("human.yaw_error_rad", -3.2, 3.2)?;
        self.yaw_error_when_away_rad
            .check("human.yaw_error_when_away_rad", -3.2, 3.2)?;
        self.pull_forward_newtons
            .check("human.pull_forward_newtons", 0.0, 1e3)?;
        self.pull_up_newtons
            .check("human.pull_up_newtons", -1e3, 1e3)
    }
}
