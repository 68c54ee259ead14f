//! The joints with their drives.

use std::collections::BTreeMap;

use super::super::drives::{Limits, Setpoint};
use crate::model;
use crate::robot::{Commands, HandCommand};
use crate::scenario::{ArmParameters, Drive, HandPositions, Scenario};

/// One joint as the plant drives it.
#[derive(Debug, Clone)]
pub(super) struct DrivenJoint {
    pub(super) name: String,
    pub(super) drive: Drive,
    pub(super) range_rad: [f64; 2],
    speed_limit_rad_s: f64,
    speed_rad_s: f64,
    acceleration_rad_s2: f64,
    pub(super) setpoint: Setpoint,
    target_rad: f64,
    /// How much the setpoint sped up in the last time step, in what it can at most.
    acceleration: f64,
}

impl DrivenJoint {
    /// Moves the setpoint on by one time step; says whether its speed changed.
    pub(super) fn advance(&mut self, time_step_secs: f64) -> bool {
        let before = self.setpoint.speed_rad_s();
        let limits = Limits {
            speed_rad_s: self.speed_rad_s,
            acceleration_rad_s2: self.acceleration_rad_s2,
        };
        self.setpoint
            .advance(self.target_rad, limits, time_step_secs);
        let change_rad_s = self.setpoint.speed_rad_s() - before;
        self.acceleration = change_rad_s / (self.acceleration_rad_s2 * time_step_secs);
        change_rad_s != 0.0
    }

    /// How much the setpoint sped up in the last time step, in what it can at most: -1 to 1.
    pub(super) fn acceleration(&self) -> f64 {
        self.acceleration
    }

    /// Whether the setpoint stands still.
    pub(super) fn is_at_target(&self) -> bool {
        self.setpoint == Setpoint::at(self.target_rad)
    }

    /// Whether the setpoint stands still, or moves beyond the joint's stop, which changes nothing
    /// but the force on it.
    pub(super) fn is_at_rest(&self) -> bool {
        let [low, high] = self.range_rad;
        let (here, there) = (self.setpoint.position_rad(), self.target_rad);
        self.is_at_target() || (here <= low && there <= low) || (here >= high && there >= high)
    }

    /// Takes over the robot's commands.
    pub(super) fn command(
        &mut self,
        commands: &Commands,
        hand: &HandPositions,
        arm: &ArmParameters,
    ) {
        let target = match self.drive {
            Drive::Arm => {
                self.speed_rad_s = if commands.restricted {
                    self.speed_limit_rad_s.min(arm.restricted_speed_rad_s)
                } else {
                    arm.reset_speed_rad_s
                };
                // An arm drive refuses to leave its range; a finger is driven on to its stop.
                let [low, high] = self.range_rad;
                commands
                    .arm_target_rad
                    .get(&self.name)
                    .map(|angle| angle.clamp(low, high))
            }
            Drive::Hand => {
                let positions = match commands.hand {
                    HandCommand::Open => &hand.open,
                    HandCommand::Pregrasp => &hand.pregrasp,
                    HandCommand::Grasp => &hand.grasp,
                };
                positions.get(&self.name).copied()
            }
        };
        self.target_rad = target.unwrap_or(self.target_rad);
    }
}

/// Fingers speed up at once, as small gear motors do.
const FINGER_ACCELERATION_RAD_S2: f64 = 20.0;

/// The joints in the engine's order, at their starting setpoints.
pub(super) fn driven_joints(scenario: &Scenario, arm: &ArmParameters) -> Vec<DrivenJoint> {
    let definitions: BTreeMap<&str, _> = scenario.joints().collect();
    let start = |name: &str| {
        let poses = [
            &scenario.robot.poses.neutral,
            &scenario.robot.hand_positions.open,
        ];
        let angle = poses.iter().find_map(|pose| pose.get(name));
        angle.copied().unwrap_or(0.0)
    };
    let driven = model::joint_order(scenario).into_iter().filter_map(|name| {
        let joint = *definitions.get(name.as_str())?;
        let [low, high] = joint.range_rad;
        let target_rad = start(&name).clamp(low, high);
        Some(DrivenJoint {
            name,
            drive: joint.drive,
            range_rad: joint.range_rad,
            speed_limit_rad_s: joint.speed_limit_rad_s,
            speed_rad_s: joint.speed_limit_rad_s,
            acceleration_rad_s2: match joint.drive {
                Drive::Arm => arm.acceleration_rad_s2,
                Drive::Hand => FINGER_ACCELERATION_RAD_S2,
            },
            setpoint: Setpoint::at(target_rad),
            target_rad,
            acceleration: 0.0,
        })
    });
    driven.collect()
}

/// Names of the arm joints, in the order of their encoder readings.
pub(crate) fn arm_joint_names(scenario: &Scenario) -> Vec<String> {
    let definitions: BTreeMap<&str, _> = scenario.joints().collect();
    let is_arm = |name: &String| {
        let joint = definitions.get(name.as_str());
        joint.is_some_and(|joint| joint.drive == Drive::Arm)
    };
    let order = model::joint_order(scenario).into_iter();
    order.filter(is_arm).collect()
}

/// Places of the hand's joints among the joints.
pub(super) fn fingers(joints: &[DrivenJoint]) -> impl Iterator<Item = usize> {
    places(joints, Drive::Hand)
}

/// Places of the arm's joints among the joints.
pub(super) fn arm(joints: &[DrivenJoint]) -> impl Iterator<Item = usize> {
    places(joints, Drive::Arm)
}

fn places(joints: &[DrivenJoint], drive: Drive) -> impl Iterator<Item = usize> {
    let joints = joints.iter().enumerate();
    joints
        .filter(move |(_, joint)| joint.drive == drive)
        .map(|(index, _)| index)
}
