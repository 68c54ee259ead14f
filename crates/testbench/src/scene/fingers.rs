//! The fingers of a parallel gripper: one mechanism with one freedom, the width.
//!
//! Definition: the fingers of a gripper are the joints that it drives and those that follow them in the description (mimic,
//! equality), directly or one after another. At the width `w` a driven joint is at `closed + (open - closed) w / w_max`, one that
//! follows where its leader takes it. All are coupled: the drives of a real parallel gripper act on one rack or screw, so that a
//! push on what is held moves no finger unless it moves both. Each finger has a servo with a share of the grip force `F`; by virtual work
//! the torques `t` of joints with the positions `q` are `sum t dq/dw = F`, of `n` fingers each `F w_max / (n |open - closed|)`.
//! The coupling then bears what the fingers differ by (their weight, a push on what is held) and none of the grip.
//!
//! Why not one drive at the joint that leads: an engine's coupling of light fingers is softer than the grip is strong. With fingers
//! of 15 g and a drive for 40 N, MuJoCo's (a spring of a stiffness that scales with the masses) passed on 17 N before the part had
//! been shifted to the finger's stop, and in Rapier, where drives and couplings are solved one after another, the part fell.
//!
//! Deviation: where the width is not linear in the joint (hinges), the force is `F` on the mean over the whole way. A joint that
//! follows by a polynomial of higher order has no drive of its own; the coupling moves it.

use super::build::BuiltRobot;
use super::data::{GripperKind, SceneData, key_of};
use crate::bench::ScenarioError;
use crate::physics::{CouplingPlan, DriveKind, DrivePlan, Layout};

/// The share of the whole way at which a finger's servo has its full force.
const FULL_AT: f64 = 0.02;
/// How fast a finger that nothing stops follows.
pub(super) const FOLLOWS_SECS: f64 = 0.02;
/// Coupled joints may begin apart by this much, in rad or m.
const APART: f64 = 1e-3;

/// A joint of the mechanism.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Finger {
    /// Its place in the layout.
    pub(super) joint: usize,
    /// Its positions at the greatest width and at the width 0.
    pub(super) open: f64,
    pub(super) closed: f64,
    /// Whether its position is linear in the width, so that it can have a drive.
    is_linear: bool,
}

impl Finger {
    /// Where it is at a width.
    pub(super) fn at(&self, width_m: f64, widest_m: f64) -> f64 {
        self.closed + (self.open - self.closed) * width_m / widest_m
    }

    /// The width at which it is there.
    pub(super) fn width_m(&self, position: f64, widest_m: f64) -> f64 {
        widest_m * (position - self.closed) / (self.open - self.closed)
    }
}

/// The fingers of a gripper with these driven joints: those first, in their order, then what follows them.
pub(super) fn fingers_of(kind: &GripperKind, joints: &[usize], layout: &Layout) -> Vec<Finger> {
    let GripperKind::Parallel { open, closed, .. } = kind else {
        return Vec::new();
    };
    let driven = joints.iter().zip(open.iter().zip(closed));
    let mut fingers: Vec<Finger> = driven
        .map(|(joint, (open, closed))| Finger {
            joint: *joint,
            open: *open,
            closed: *closed,
            is_linear: true,
        })
        .collect();
    let mut leader = 0;
    while let Some(leads) = fingers.get(leader).copied() {
        let followers = layout.couplings.iter();
        for follower in followers.filter(|it| it.leader == Some(leads.joint)) {
            let [open, closed] =
                [leads.open, leads.closed].map(|lead| position_of(follower, layout, lead));
            let is_known = fingers.iter().any(|it| it.joint == follower.joint);
            if is_known || open == closed {
                continue;
            }
            fingers.push(Finger {
                joint: follower.joint,
                open,
                closed,
                is_linear: leads.is_linear && follower.coefficients[2..] == [0.0; 3],
            });
        }
        leader += 1;
    }
    fingers
}

/// Where a joint is when its leader is at `lead`: couplings are of positions from where bodies stand as their poses say.
pub(super) fn position_of(coupling: &CouplingPlan, layout: &Layout, lead: f64) -> f64 {
    let reference = |joint: usize| layout.joints[joint].reference;
    let from = lead - coupling.leader.map_or(0.0, reference);
    let coefficients = coupling.coefficients.iter().rev();
    let way = coefficients.fold(0.0, |sum, coefficient| sum * from + coefficient);
    reference(coupling.joint) + way
}

/// Adds the servos of a parallel gripper and couples its fingers; gives the fingers that have one, in the order of the servos.
/// Joints of `elsewhere` have drives of their own.
pub(super) fn join(layout: &mut Layout, kind: &GripperKind, joints: &[usize], elsewhere: &[usize]) {
    let GripperKind::Parallel {
        width_m,
        force_limit_newtons,
        ..
    } = kind
    else {
        return;
    };
    let fingers = fingers_of(kind, joints, layout);
    couple(layout, &fingers, joints.len());
    carry(layout, joints);
    let driven = driven(&fingers, elsewhere);
    for finger in &driven {
        let way = (finger.open - finger.closed).abs();
        let limit = force_limit_newtons * width_m / (driven.len() as f64 * way);
        let stiffness = limit / (FULL_AT * way);
        let damping = stiffness * FOLLOWS_SECS;
        layout.drives.push(DrivePlan {
            joint: finger.joint,
            kind: DriveKind::Position { stiffness, damping },
            limit,
        });
    }
}

/// The fingers with servos.
pub(super) fn driven(fingers: &[Finger], elsewhere: &[usize]) -> Vec<Finger> {
    let driven = fingers.iter();
    let driven = driven.filter(|it| it.is_linear && !elsewhere.contains(&it.joint));
    driven.copied().collect()
}

/// The couplings by which joints follow these, directly or one after another, carry what these are driven with.
pub(super) fn carry(layout: &mut Layout, joints: &[usize]) {
    let mut carrying = joints.to_vec();
    let mut place = 0;
    while let Some(leads) = carrying.get(place).copied() {
        for coupling in &mut layout.couplings {
            if coupling.leader == Some(leads) && !coupling.carries {
                coupling.carries = true;
                carrying.push(coupling.joint);
            }
        }
        place += 1;
    }
}

/// The first driven joint leads the others.
fn couple(layout: &mut Layout, fingers: &[Finger], count: usize) {
    let [leads, others @ ..] = &fingers[..count.min(fingers.len())] else {
        return;
    };
    for finger in others {
        let slope = (finger.open - finger.closed) / (leads.open - leads.closed);
        let reference = |joint: usize| layout.joints[joint].reference;
        let from = finger.closed - reference(finger.joint);
        let offset = from - slope * (leads.closed - reference(leads.joint));
        layout.couplings.push(CouplingPlan {
            joint: finger.joint,
            leader: Some(leads.joint),
            coefficients: [offset, slope, 0.0, 0.0, 0.0],
            carries: false,
        });
    }
}

/// Joints that follow one whose beginning the scene gives begin where it takes them.
///
/// # Errors
/// [`ScenarioError::Value`] for each that the scene lets begin elsewhere.
pub(super) fn begin_together(
    layout: &Layout,
    data: &SceneData,
    robots: &mut [BuiltRobot],
) -> Result<(), ScenarioError> {
    let mut wrong = Vec::new();
    for (robot, built) in data.robots.iter().zip(robots) {
        let name_of = |joint: usize| {
            let named = built.added.joints.iter().find(|(_, it)| **it == joint);
            named.map_or("", |(name, _)| name.as_str())
        };
        // Each pass reaches the followers of followers.
        for _ in 0..layout.couplings.len() {
            let known = built.start.len();
            for coupling in &layout.couplings {
                let given = |joint: usize| built.start.iter().rev().find(|(it, _)| *it == joint);
                let Some((leader, lead)) = coupling.leader.and_then(given).copied() else {
                    continue;
                };
                let wanted = position_of(coupling, layout, lead);
                match given(coupling.joint) {
                    None => built.start.push((coupling.joint, wanted)),
                    Some((_, begins)) if (begins - wanted).abs() > APART => {
                        let follower = name_of(coupling.joint);
                        let problem = format!(
                            "lets it begin at {begins}, but it is coupled to `{}`, which takes it to {wanted:.6}; leave it out, or give both what belongs together",
                            name_of(leader)
                        );
                        let key = key_of("robot", &robot.name, &format!("joints.{follower}"));
                        wrong.push(ScenarioError::value(&key, &problem));
                    }
                    Some(_) => {}
                }
            }
            if built.start.len() == known {
                break;
            }
        }
    }
    ScenarioError::all(wrong)
}
