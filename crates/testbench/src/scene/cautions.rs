//! What a scene asks for that an engine does, but hardly as it is meant: told beforehand, with its number and what to do about it.
//!
//! Joints whose description lets them begin beyond their limits, drives that are stiffer than the time step carries
//! ([`super::inertia`]), and fingers that sink into what they hold, since Rapier's contacts are springs that scale with the masses:
//! `n` points of contact with the effective mass `m` give way by `F / (n m w^2)` to a force `F`, where `w` is their angular frequency.

use super::build::{Built, BuiltRobot};
use super::data::{ActuatorKind, GripperKind, Robot, SceneData, key_of};
use super::inertia::{Machine, TooStiff};
use crate::physics::{JointKind, Physics};

/// Points of contact of a plane finger.
const POINTS: f64 = 4.0;
/// Rapier's own frequency of contacts.
const CONTACT_HZ: f64 = 30.0;
/// How far fingers may sink, and how far they do with the frequency that is proposed.
const SINKS_M: [f64; 2] = [2e-3, 1e-3];

/// Something that is simulated, but hardly as it is meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Caution {
    /// The key in the scene's file.
    pub key: String,
    /// What it is of.
    pub element: String,
    /// What is to be minded.
    pub what: String,
    /// What it concerns: `motion`, `contact` or `control`.
    pub effect: &'static str,
    /// What follows from it, and what to do about it.
    pub consequence: String,
}

/// All of a scene in an engine, in which it is brought to where it begins.
pub(super) fn cautions(data: &SceneData, built: &Built, physics: &mut dyn Physics) -> Vec<Caution> {
    for (joint, position) in built.robots.iter().flat_map(|it| &it.start) {
        physics.set_joint(*joint, *position);
    }
    physics.refresh();
    let mut found = Vec::new();
    for (place, (robot, at)) in data.robots.iter().zip(&built.robots).enumerate() {
        found.extend(beyond_limits(robot, at, built));
        let mut bodies: Vec<usize> = at.added.links.values().copied().collect();
        bodies.sort_unstable();
        let machine = Machine::new(&built.layout, &bodies, physics);
        match physics.engine().0 {
            "MuJoCo" => found.extend(chattering(&machine, data, built)),
            _ => found.extend(sinking(&machine, place, data, built)),
        }
    }
    found
}

/// Joints that begin beyond their limits because neither the scene nor the description lets them begin within.
fn beyond_limits(robot: &Robot, at: &BuiltRobot, built: &Built) -> Vec<Caution> {
    let joints = at.added.joints.iter().filter_map(|(name, joint)| {
        let plan = &built.layout.joints[*joint];
        let [low, high] = plan.range?;
        let given = at.start.iter().rev().find(|(it, _)| it == joint);
        let begins = given.map_or(plan.reference, |(_, position)| *position);
        let beyond = (low - begins).max(begins - high);
        let unit = unit(plan.kind);
        let slack = 1e-9 * (1.0 + low.abs().max(high.abs()));
        (beyond > slack).then(|| Caution {
            key: format!("robot.{}", robot.name),
            element: format!("joint {name}"),
            what: format!(
                "it begins at {begins} {unit}, beyond its range of {low} to {high} {unit} in {}",
                robot.file
            ),
            effect: "motion",
            consequence: format!(
                "its limit throws it back as the episode begins; give robot.{}.joints.{name} a position within",
                robot.name
            ),
        })
    });
    joints.collect()
}

/// The drive of a robot that is stiffer than the step carries.
fn chattering(machine: &Machine, data: &SceneData, built: &Built) -> Option<Caution> {
    let step_secs = built.layout.time_step_secs;
    let found = machine.too_stiff(&built.layout, step_secs)?;
    let plan = &built.layout.joints[found.joint];
    let name = plan
        .name
        .split_once('/')
        .map_or(plan.name.as_str(), |it| it.1);
    let (of_turn, of_inertia) = match plan.kind {
        JointKind::Slide => ("N/m", "kg"),
        JointKind::Hinge | JointKind::Ball => ("Nm/rad", "kg m2"),
    };
    let (key, by) = driver(found.joint, data, built);
    let TooStiff {
        stiffness,
        damping,
        inertia,
        stable,
        longest_secs,
        ..
    } = found;
    let alone = match stiffness > stable {
        true => format!("{stable:.4} {of_turn} are stable"),
        false => format!(
            "{stable:.4} {of_turn} would be stable alone, less with the other joints' drives"
        ),
    };
    Some(Caution {
        key,
        element: format!("joint {name}"),
        what: format!(
            "{by} has {stiffness} {of_turn}, stiffer than steps of {} ms carry: with its effective inertia of {inertia:.3e} {of_inertia} and damping of {damping} {alone}",
            1e3 * step_secs
        ),
        effect: "control",
        consequence: format!(
            "it chatters; shorten simulation.time_step_secs to below {:.2e} s, lower the stiffness, or raise the damping",
            longest_secs.min(step_secs)
        ),
    })
}

/// Whose drive a joint has: the key of its stiffness, and words for it.
fn driver(joint: usize, data: &SceneData, built: &Built) -> (String, String) {
    let is_of = |drive: usize| built.layout.drives[drive].joint == joint;
    let own = data.actuators.iter().zip(&built.drives);
    let own = own
        .into_iter()
        .find(|(_, drives)| (*drives).clone().any(is_of));
    match own {
        Some((actuator, _)) => {
            let key = match actuator.kind {
                ActuatorKind::Gripper(_) => format!("{}.{}", actuator.list, actuator.name),
                _ => key_of(actuator.list, &actuator.name, "stiffness"),
            };
            (
                key,
                format!("the drive of the {} `{}`", actuator.list, actuator.name),
            )
        }
        None => {
            let body = built.layout.joints[joint].body;
            let robot = built
                .robots
                .iter()
                .position(|it| it.added.links.values().any(|it| *it == body));
            let name = robot.map_or("", |it| data.robots[it].name.as_str());
            (format!("robot.{name}"), "its spring".to_owned())
        }
    }
}

/// Fingers of a robot that sink far into what they hold.
fn sinking(machine: &Machine, robot: usize, data: &SceneData, built: &Built) -> Vec<Caution> {
    let own = data
        .grippers
        .iter()
        .filter(|it| it.robot == data.robots[robot].name);
    let found = own.filter_map(|gripper| {
        let GripperKind::Parallel {
            joints,
            open,
            closed,
            width_m,
            force_limit_newtons,
            ..
        } = &gripper.kind
        else {
            return None;
        };
        let each = joints.iter().zip(open.iter().zip(closed));
        let masses = each.filter_map(|(name, (open, closed))| {
            let joint = built.robots[robot].added.joints.get(name)?;
            // How fast the pad moves for the joint's speed.
            let pad = width_m / 2.0 / (open - closed).abs();
            Some(machine.effective(*joint)? / (pad * pad))
        });
        let mass_kg = masses.fold(f64::INFINITY, f64::min);
        let hz = data.simulation.rapier.solver().contact_frequency_hz;
        let hz = hz.unwrap_or(CONTACT_HZ);
        let yields = POINTS * mass_kg * std::f64::consts::TAU.powi(2) / force_limit_newtons;
        let sinks_m = 1.0 / (yields * hz * hz);
        let [most_m, wanted_m] = SINKS_M;
        (sinks_m > most_m).then(|| Caution {
            key: format!("gripper.{}", gripper.name),
            element: format!("gripper {}", gripper.name),
            what: format!(
                "its fingers, with an effective mass of {mass_kg:.3} kg, sink about {:.0} mm into what they hold at {force_limit_newtons} N",
                1e3 * sinks_m
            ),
            effect: "contact",
            consequence: format!(
                "Rapier's contacts are springs that scale with the masses; set simulation.rapier.contact_frequency_hz = {:.0} (now {hz})",
                (1.0 / (yields * wanted_m)).sqrt().ceil()
            ),
        })
    });
    found.collect()
}

fn unit(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Slide => "m",
        JointKind::Hinge | JointKind::Ball => "rad",
    }
}
