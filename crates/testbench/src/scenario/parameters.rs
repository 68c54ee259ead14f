//! The parameter set: what tuning changes. Units are in the names of the fields.

use serde::Deserialize;

use super::ScenarioError;
use crate::random::Distribution;

/// Where inertias come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InertiaSource {
    /// From shape and mass, by the formulas for solids.
    Geometry,
    /// The published placeholder moments.
    Placeholder,
}

/// A named set of physical and fault parameters.
#[derive(Debug, Clone, Deserialize)]
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
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "names carry quantity and unit; the parameter file explains each"
)]
pub struct ObjectParameters {
    pub mass_kg: Distribution,
    pub x_error_m: Distribution,
    pub y_error_m: Distribution,
    pub yaw_rad: Distribution,
}

/// The hand's drives and skin.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "names carry quantity and unit; the parameter file explains each"
)]
pub struct HandParameters {
    pub friction: Distribution,
    pub contact_time_constant_secs: f64,
    pub stiffness_nm_rad: f64,
    pub damping_nms_rad: f64,
    pub torque_limit_nm: f64,
    pub friction_loss_nm: f64,
    pub stop_time_constant_secs: f64,
}

/// How fast the arm moves.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "names carry quantity and unit; the parameter file explains each"
)]
pub struct ArmParameters {
    pub restricted_speed_rad_s: f64,
    pub reset_speed_rad_s: f64,
    pub acceleration_rad_s2: f64,
}

/// Noise and glitches of tracking.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "names carry quantity and unit; the parameter file explains each"
)]
pub struct TrackingParameters {
    pub glitch_rate_per_reading: f64,
    pub noise_m: f64,
}

/// Answer time and failures of the motion planner.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "names carry quantity and unit; the parameter file explains each"
)]
pub struct PlannerParameters {
    pub failure_rate_per_run: f64,
    pub answer_secs: Distribution,
}

/// What is drawn for the human in each episode.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(
    missing_docs,
    reason = "names carry quantity and unit; the parameter file explains each"
)]
pub struct HumanDraws {
    pub head_height_offset_m: Distribution,
    pub yaw_error_rad: Distribution,
    pub yaw_error_when_away_rad: Distribution,
    pub pull_forward_newtons: Distribution,
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
