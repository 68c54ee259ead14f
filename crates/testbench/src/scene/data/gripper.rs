//! Grippers and tool changers in a scene's file.

use schemars::JsonSchema;
use serde::Deserialize;

use super::{ActuatorFault, key_of, number_within};
use crate::bench::ScenarioError;

/// A gripper or a tool changer of a robot. A controller commands it by its name; what it holds is recorded as `/gripper/NAME`.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
pub struct Gripper {
    /// Its name, by which a controller commands it.
    pub name: String,
    /// The robot it belongs to.
    pub robot: String,
    /// Faults that may occur.
    #[serde(default, rename = "fault")]
    pub faults: Vec<ActuatorFault>,
    /// What it is.
    #[serde(flatten)]
    pub kind: GripperKind,
}

/// What a gripper is.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum GripperKind {
    /// Fingers that move together: commands `width` (m) and `force` (N), how hard each side presses. Joints that follow others
    /// in the description (mimic) are not named. All are one mechanism, as the drives of real parallel grippers act on one rack or
    /// screw: the fingers are coupled, whether the description says so or not, share the force, and what is held cannot push one
    /// of them aside alone. Fingers on hinges press with `force` on the mean over the whole way.
    Parallel {
        /// The joints that are driven.
        joints: Vec<String>,
        /// Their positions at the greatest width.
        open: Vec<f64>,
        /// Their positions at the width 0.
        closed: Vec<f64>,
        /// The greatest width.
        width_m: f64,
        /// The largest force, which holds until another is commanded.
        force_limit_newtons: f64,
        /// How fast the width changes.
        #[serde(default = "tenth")]
        speed_m_s: f64,
        /// Whether what is grasped is attached to the fingers: a simplification, which evidence says.
        attach: Option<Attach>,
    },
    /// Fingers of which one tendon pulls several joints, each as far as its phalanx comes: command `tension` (N).
    UnderActuated {
        /// The joints that the tendon pulls, towards the sign of their pulley's radius.
        joints: Vec<String>,
        /// The radii of their pulleys: the torque is the radius times the tension.
        pulley_radii_m: Vec<f64>,
        /// Springs that open the joints again, in Nm/rad, about where the joints begin.
        return_stiffness: Vec<f64>,
        /// The largest tension.
        tension_limit_newtons: f64,
        /// Whether what is grasped is attached to the fingers: a simplification, which evidence says.
        attach: Option<Attach>,
    },
    /// A suction cup, which points along its frame's z axis: command `suction` (0 or 1). The nearest loose thing within reach is
    /// held until the pull along the cup's axis is more than it holds, or the shear more than its friction bears.
    Suction {
        /// The cup: one of the scene's `tool_point`s.
        tool_point: String,
        /// How far from the cup a surface is sucked.
        reach_m: f64,
        /// The pull at which it comes off.
        holding_force_newtons: f64,
        /// Friction of the cup: it slips off at this share of the force that is left.
        #[serde(default = "half")]
        friction: f64,
    },
    /// A flange that takes tools, which are robots or objects of the scene: command `lock` (0 or 1).
    ToolChanger {
        /// The flange: one of the scene's `tool_point`s.
        tool_point: String,
        /// The tools that fit: robots that are not fixed, or loose objects.
        tools: Vec<String>,
        /// How far from the flange the origin of a tool may be when it is locked.
        reach_m: f64,
    },
}

/// When something is attached to the fingers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
pub enum Attach {
    /// As soon as two fingers hold it between them, until the gripper is opened.
    #[serde(rename = "when-grasped")]
    WhenGrasped,
}

fn tenth() -> f64 {
    0.1
}
fn half() -> f64 {
    0.5
}

impl Gripper {
    /// Whether what it grasps is attached to it.
    #[must_use]
    pub fn attaches_when_grasped(&self) -> bool {
        match &self.kind {
            GripperKind::Parallel { attach, .. } | GripperKind::UnderActuated { attach, .. } => {
                *attach == Some(Attach::WhenGrasped)
            }
            GripperKind::Suction { .. } | GripperKind::ToolChanger { .. } => false,
        }
    }

    /// The joints that it drives.
    #[must_use]
    pub fn joints(&self) -> &[String] {
        match &self.kind {
            GripperKind::Parallel { joints, .. } | GripperKind::UnderActuated { joints, .. } => {
                joints
            }
            GripperKind::Suction { .. } | GripperKind::ToolChanger { .. } => &[],
        }
    }

    /// The tool point at which it holds, if it has no fingers.
    pub(in crate::scene) fn tool_point(&self) -> Option<&str> {
        match &self.kind {
            GripperKind::Suction { tool_point, .. }
            | GripperKind::ToolChanger { tool_point, .. } => Some(tool_point),
            GripperKind::Parallel { .. } | GripperKind::UnderActuated { .. } => None,
        }
    }

    /// What is wrong with it, everything at once.
    pub(super) fn check(&self) -> Vec<ScenarioError> {
        let key = |field: &str| key_of("gripper", &self.name, field);
        let mut wrong = Vec::new();
        let count = self.joints().len();
        let lists: &[(&str, &Vec<f64>, f64)] = match &self.kind {
            GripperKind::Parallel { open, closed, .. } => {
                &[("open", open, -1e4), ("closed", closed, -1e4)]
            }
            GripperKind::UnderActuated {
                pulley_radii_m,
                return_stiffness,
                ..
            } => &[
                ("pulley_radii_m", pulley_radii_m, -10.0),
                ("return_stiffness", return_stiffness, 0.0),
            ],
            GripperKind::Suction { .. } | GripperKind::ToolChanger { .. } => &[],
        };
        for (field, numbers, low) in lists {
            if numbers.len() != count {
                let problem = format!(
                    "lists {} where the gripper has {count} joints; give a number for each",
                    numbers.len()
                );
                wrong.push(ScenarioError::value(&key(field), &problem));
            }
            let each = numbers.iter();
            wrong.extend(each.filter_map(|it| number_within(&key(field), *it, *low, 1e6).err()));
        }
        if self.tool_point().is_none() && count == 0 {
            wrong.push(ScenarioError::value(
                &key("joints"),
                "must name at least one joint",
            ));
        }
        if let GripperKind::Parallel { open, closed, .. } = &self.kind
            && open.iter().zip(closed).any(|(open, closed)| open == closed)
        {
            let problem = "is as `closed` for a joint, which then does not move";
            wrong.push(ScenarioError::value(&key("open"), problem));
        }
        let numbers = self.numbers();
        wrong.extend(
            numbers
                .iter()
                .filter_map(|(field, value)| number_within(&key(field), *value, 1e-9, 1e6).err()),
        );
        wrong
    }

    /// Numbers that are above 0.
    fn numbers(&self) -> Vec<(&'static str, f64)> {
        match &self.kind {
            GripperKind::Parallel {
                width_m,
                force_limit_newtons,
                speed_m_s,
                ..
            } => vec![
                ("width_m", *width_m),
                ("force_limit_newtons", *force_limit_newtons),
                ("speed_m_s", *speed_m_s),
            ],
            GripperKind::UnderActuated {
                tension_limit_newtons,
                ..
            } => vec![("tension_limit_newtons", *tension_limit_newtons)],
            GripperKind::Suction {
                reach_m,
                holding_force_newtons,
                friction,
                ..
            } => vec![
                ("reach_m", *reach_m),
                ("holding_force_newtons", *holding_force_newtons),
                ("friction", *friction),
            ],
            GripperKind::ToolChanger { reach_m, .. } => vec![("reach_m", *reach_m)],
        }
    }
}
