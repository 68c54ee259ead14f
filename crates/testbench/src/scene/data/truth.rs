//! What a scene's file says of its truth: settings, regions, points of tools.

use schemars::JsonSchema;
use serde::Deserialize;

use super::{key_of, number_within};
use crate::bench::ScenarioError;
use crate::geometry::{Pose, Vector, from_roll_pitch_yaw};

/// What counts as what in truth signals, and which are recorded besides those that the study reads.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruthKeys {
    /// Signals that are recorded though nothing in the study reads them: `"/truth/arm/hand.speed"`.
    #[serde(default)]
    pub record: Vec<String>,
    /// A body that moves at most this fast stands: below it a contact is not of its making.
    #[serde(default = "crawl")]
    pub standing_below_m_s: f64,
    /// Two that touch again within this time are still in the same contact.
    #[serde(default = "blink")]
    pub same_contact_within_secs: f64,
    /// What is tilted by at most this is upright.
    #[serde(default = "ten_degrees")]
    pub upright_within_rad: f64,
    /// Contacts with less normal force hold nothing.
    #[serde(default = "tenth")]
    pub grasp_newtons: f64,
    /// A grasped thing that moves by more than this in its fingers is told.
    #[serde(default = "millimetre")]
    pub creep_above_m: f64,
}

fn crawl() -> f64 {
    0.05
}
fn blink() -> f64 {
    0.05
}
fn ten_degrees() -> f64 {
    0.1745
}
fn tenth() -> f64 {
    0.1
}
fn millimetre() -> f64 {
    0.001
}

impl Default for TruthKeys {
    fn default() -> Self {
        Self {
            record: Vec::new(),
            standing_below_m_s: crawl(),
            same_contact_within_secs: blink(),
            upright_within_rad: ten_degrees(),
            grasp_newtons: tenth(),
            creep_above_m: millimetre(),
        }
    }
}

impl TruthKeys {
    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        for (field, value, high) in [
            ("standing_below_m_s", self.standing_below_m_s, 10.0),
            (
                "same_contact_within_secs",
                self.same_contact_within_secs,
                60.0,
            ),
            ("upright_within_rad", self.upright_within_rad, 3.15),
            ("grasp_newtons", self.grasp_newtons, 1e6),
            ("creep_above_m", self.creep_above_m, 1e3),
        ] {
            number_within(&format!("truth.{field}"), value, 0.0, high)?;
        }
        Ok(())
    }
}

/// A place in which things can be: a cuboid, or an upright cylinder.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Its name.
    pub name: String,
    /// A cuboid's edges.
    pub box_m: Option<Vector>,
    /// A cylinder's radius; with `length_m`, upright.
    pub radius_m: Option<f64>,
    /// See `radius_m`.
    pub length_m: Option<f64>,
    /// The robot or object that carries it, in the frame of whose root it then lies; the world if left out.
    pub on: Option<String>,
    /// Where its centre is.
    #[serde(default)]
    #[allow(missing_docs, reason = "names carry quantity and unit")]
    pub x_m: f64,
    /// Where its centre is, to the left.
    #[serde(default)]
    pub y_m: f64,
    /// Where its centre is, upwards.
    #[serde(default)]
    pub z_m: f64,
    /// How it is turned, from the x axis to the left.
    #[serde(default)]
    pub yaw_rad: f64,
}

impl Region {
    /// Where its centre is.
    pub(in crate::scene) fn pose(&self) -> Pose {
        Pose {
            position_m: [self.x_m, self.y_m, self.z_m],
            orientation: from_roll_pitch_yaw([0.0, 0.0, self.yaw_rad]),
        }
    }

    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        let key = |field: &str| key_of("region", &self.name, field);
        let is_form = matches!(
            (self.box_m, self.radius_m, self.length_m),
            (Some(_), None, None) | (None, Some(_), Some(_))
        );
        if !is_form {
            let problem = "needs `box_m`, or `radius_m` and `length_m`";
            return Err(ScenarioError::value(&key("box_m"), problem));
        }
        let lengths = self.box_m.iter().flatten();
        for length in lengths.chain(&self.radius_m).chain(&self.length_m) {
            number_within(&key("size"), *length, 1e-6, 1e4)?;
        }
        [self.x_m, self.y_m, self.z_m, self.yaw_rad]
            .iter()
            .try_for_each(|number| number_within(&key("x_m"), *number, -1e4, 1e4))
    }
}

/// A point of a robot's link that signals can speak of as of a link: the tip of a tool, the middle of a gripper.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ToolPoint {
    /// Its name, as that of a further link: `/truth/ROBOT/NAME.speed`.
    pub name: String,
    /// The robot.
    pub robot: String,
    /// The link on which it is; the robot's root if left out.
    pub link: Option<String>,
    /// Where it is in the link's frame, forwards.
    #[serde(default)]
    pub x_m: f64,
    /// To the left.
    #[serde(default)]
    pub y_m: f64,
    /// Upwards.
    #[serde(default)]
    pub z_m: f64,
    /// How its frame is turned in the link's, about x first.
    #[serde(default)]
    pub roll_rad: f64,
    /// Then about y.
    #[serde(default)]
    pub pitch_rad: f64,
    /// Then about z.
    #[serde(default)]
    pub yaw_rad: f64,
}

impl ToolPoint {
    /// Its frame in the link's.
    pub(in crate::scene) fn pose(&self) -> Pose {
        Pose {
            position_m: [self.x_m, self.y_m, self.z_m],
            orientation: from_roll_pitch_yaw([self.roll_rad, self.pitch_rad, self.yaw_rad]),
        }
    }

    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        let key = |field: &str| key_of("tool_point", &self.name, field);
        for (field, number) in [
            ("x_m", self.x_m),
            ("y_m", self.y_m),
            ("z_m", self.z_m),
            ("roll_rad", self.roll_rad),
            ("pitch_rad", self.pitch_rad),
            ("yaw_rad", self.yaw_rad),
        ] {
            number_within(&key(field), number, -100.0, 100.0)?;
        }
        Ok(())
    }
}
