//! Long steps while hand and object hardly move against each other: projective integration.
//!
//! Definition: let `x` be the inner configuration (the fingers' angles, the object's pose in the
//! hand's frame) and `x'`, `x''` its rate and the change of that rate, both measured over windows of
//! `W` seconds of the full physics; from the second coast on, `x''` is the change since the last one
//! began, which is the change on the slow scale that matters. While nothing acts on hand or object, the configuration after
//! `t` seconds is taken to be `x + t x'`, for at most
//!
//! ```text
//! T = sqrt(2 e / |x''|)      so that the next term of the series, x'' t^2 / 2, stays below e
//! ```
//!
//! and then the full physics runs again, for at least three windows. The rates used are the mean of
//! the last two measurements: a mode that decays within a coast is overshot by the next, so that its
//! part of the rate changes sign from coast to coast, and the mean is free of it. Meanwhile
//! each joint of the arm follows its servo ([`super::arm`]), or rests. So a grip that
//! creeps goes on creeping at its rate (which freezing it would suppress), and one that slips is not
//! coasted over, because its rate is beyond the limit below or changes.
//!
//! Source: C. W. Gear and I. G. Kevrekidis, "Projective methods for stiff differential equations",
//! SIAM Journal on Scientific Computing 24(4), 2003 (projective forward Euler, with the error term
//! of step-size control). Deviation: the arm is integrated on, since it may move fast.
//!
//! Where hand and object are apart and the object rests, the same holds with rates of 0, until they
//! come within reach of each other: no contact, so nothing to integrate.
//!
//! Cost: a step costs some hundred operations; nothing at all when the arm rests. Guarantee: none beyond the estimate above; `tests/fast.rs` compares with the full physics.

use super::arm::Arm;
use super::body::{Blueprint, Body, Configuration};
use super::clearance::Clearance;
use super::joints::DrivenJoint;
use super::{Grip, ObjectState};
use crate::geometry::{
    Pose, Vector, add, norm, rotate, rotation_between, scale, subtract, turned_by,
};
use crate::scenario::Drive;

/// Length of a window over which a rate is measured.
pub(super) const WINDOW_SECS: f64 = 0.04;
/// The error that a coast may add to a finger; it decays within some tenths of a second after.
const FINGER_ERROR_RAD: f64 = 2e-3;
/// The errors that a coast may add to the object's pose in the hand.
const OBJECT_ERROR_M: f64 = 1e-4;
const OBJECT_ERROR_RAD: f64 = 2e-3;
/// A coast that would be shorter is not worth its beginning and end.
const SHORTEST_SECS: f64 = 0.15;
/// The longest coast while something is held, and by how much one may be longer than what lies
/// between the last two measurements.
const LONGEST_SECS: f64 = 1.5;
const LONGER: f64 = 4.0;
/// Faster than this the object slips in the hand, and a finger is closing or opening.
const SLIP_M_S: f64 = 1e-3;
const SLIP_RAD_S: f64 = 1e-2;
const FINGER_MOVES_RAD_S: f64 = 2e-2;
/// Slower than this the fingers of an empty hand are where they are told to be.
const EMPTY_FINGER_RAD_S: f64 = 0.1;
/// Slower than this an object that nothing holds rests.
const RESTS_M_S: f64 = 1e-4;
const RESTS_RAD_S: f64 = 1e-3;
/// A held object that accelerates by more than a hundredth of gravity loads the grip differently.
const QUASI_STATIC_M_S2: f64 = 0.1;
/// So far gravity may turn in the hand during a coast.
const TILT_RAD: f64 = 0.01;
/// An arm slower than this rests; what is left of its way is this times its servos' time constant
/// of some 0.1 s.
pub(super) const ARM_RESTS_RAD_S: f64 = 1e-3;

/// What is measured at the end of a window.
#[derive(Debug, Clone, PartialEq)]
struct Sample {
    fingers_rad: Vec<f64>,
    object: ObjectState,
    object_in_hand: Pose,
    hand: ObjectState,
}

/// The last windows of the full physics.
#[derive(Debug, Clone, Default)]
pub(super) struct History {
    samples: Vec<Sample>,
    /// With which creep the last coast began, and when.
    coasted: Option<(f64, Creep)>,
}

impl History {
    /// Forgets what was measured: the full physics begins again. What the last coast relied on is
    /// of use only if nothing but its own limit ended it.
    pub(super) fn clear(&mut self, ran_out: bool) {
        self.samples.clear();
        if !ran_out {
            self.coasted = None;
        }
    }

    /// Takes in the end of a window.
    pub(super) fn take(&mut self, body: &Body, joints: &[DrivenJoint]) {
        let (object, hand) = (body.object(), body.hand());
        if self.samples.len() == 3 {
            self.samples.remove(0);
        }
        self.samples.push(Sample {
            fingers_rad: fingers(joints)
                .filter_map(|index| body.position_rad(index))
                .collect(),
            object,
            object_in_hand: object.pose.seen_from(&hand.pose),
            hand,
        });
    }

    /// Whether the object rests apart from the hand and the fingers hardly move.
    fn rests(&self) -> bool {
        let [.., a, b] = self.samples.as_slice() else {
            return false;
        };
        largest(&Creep::between(a, b).fingers_rad_s) < EMPTY_FINGER_RAD_S
            && norm(b.object.velocity_m_s) < RESTS_M_S
            && norm(b.object.spin_rad_s) < RESTS_RAD_S
    }

    /// The rates at which a held object and the fingers creep at `now_secs`, and for how long they
    /// may be relied on; `None` if anything is too fast, or would soon be different.
    fn creep(&mut self, now_secs: f64) -> Option<(Creep, f64)> {
        let (before, now, apart_secs) = match (&self.coasted, self.samples.as_slice()) {
            (Some((then, creep)), [_, b, c]) => {
                (creep.clone(), Creep::between(b, c), now_secs - then)
            }
            (None, [a, b, c]) => (Creep::between(a, b), Creep::between(b, c), WINDOW_SECS),
            _ => return None,
        };
        let last = self.samples.last()?;
        if !now.is_slow() || !self.is_quasi_static() {
            self.coasted = None;
            return None;
        }
        let [x, y, _] = last.hand.spin_rad_s;
        let secs = now
            .lasts_secs(&before, apart_secs)
            .min(LONGEST_SECS)
            .min(LONGER * apart_secs.max(SHORTEST_SECS))
            .min(TILT_RAD / x.hypot(y));
        if secs < SHORTEST_SECS {
            return None;
        }
        let used = now.mean(&before);
        self.coasted = Some((now_secs, now));
        Some((used, secs))
    }

    /// Whether the object's acceleration is small against gravity.
    fn is_quasi_static(&self) -> bool {
        let [.., a, b] = self.samples.as_slice() else {
            return false;
        };
        let change_m_s = subtract(b.object.velocity_m_s, a.object.velocity_m_s);
        norm(change_m_s) < QUASI_STATIC_M_S2 * WINDOW_SECS
    }
}

/// How fast the inner configuration changes; the object's part in the hand's frame.
#[derive(Debug, Clone, PartialEq)]
struct Creep {
    fingers_rad_s: Vec<f64>,
    object_m_s: Vector,
    object_rad_s: Vector,
}

impl Creep {
    /// Whether nothing slips and no finger closes or opens.
    fn is_slow(&self) -> bool {
        largest(&self.fingers_rad_s) < FINGER_MOVES_RAD_S
            && norm(self.object_m_s) < SLIP_M_S
            && norm(self.object_rad_s) < SLIP_RAD_S
    }

    /// The mean of two measurements.
    fn mean(&self, other: &Self) -> Self {
        let fingers = self.fingers_rad_s.iter().zip(&other.fingers_rad_s);
        Self {
            fingers_rad_s: fingers.map(|(a, b)| (a + b) / 2.0).collect(),
            object_m_s: scale(0.5, add(self.object_m_s, other.object_m_s)),
            object_rad_s: scale(0.5, add(self.object_rad_s, other.object_rad_s)),
        }
    }

    /// How long these rates may be relied on, if `before` were those `apart_secs` earlier.
    fn lasts_secs(&self, before: &Self, apart_secs: f64) -> f64 {
        let fingers = before.fingers_rad_s.iter().zip(&self.fingers_rad_s);
        let finger_change = fingers
            .map(|(before, now)| (now - before).abs())
            .fold(0.0, f64::max);
        let apart = |a, b| norm(subtract(a, b));
        let changes = [
            (FINGER_ERROR_RAD, finger_change),
            (OBJECT_ERROR_M, apart(self.object_m_s, before.object_m_s)),
            (
                OBJECT_ERROR_RAD,
                apart(self.object_rad_s, before.object_rad_s),
            ),
        ];
        let lasts = |(error, change): (f64, f64)| (2.0 * error * apart_secs / change).sqrt();
        changes.map(lasts).into_iter().fold(f64::INFINITY, f64::min)
    }

    fn between(a: &Sample, b: &Sample) -> Self {
        let (from, to) = (&a.object_in_hand, &b.object_in_hand);
        let rates = a.fingers_rad.iter().zip(&b.fingers_rad);
        Self {
            fingers_rad_s: rates.map(|(a, b)| (b - a) / WINDOW_SECS).collect(),
            object_m_s: scale(1.0 / WINDOW_SECS, subtract(to.position_m, from.position_m)),
            object_rad_s: scale(
                1.0 / WINDOW_SECS,
                rotation_between(from.orientation, to.orientation),
            ),
        }
    }
}

/// What the object does meanwhile.
#[derive(Debug, Clone)]
enum Carried {
    /// It rests in the world, apart from the hand.
    Rests(Clearance),
    /// It is in the hand.
    Held(Creep),
}

/// A coast in progress.
#[derive(Debug, Clone)]
pub(super) struct Coasting {
    arm: Arm,
    began: Configuration,
    object_in_hand: Pose,
    carried: Carried,
    grip: Grip,
    elapsed_secs: f64,
    longest_secs: f64,
}

impl Coasting {
    /// Begins a coast from the state of `body` after a window, if one can be begun. `now` is its
    /// configuration, `clearance` gives where the hand's shapes are against the object.
    pub(super) fn begin(
        blueprint: &Blueprint,
        joints: &[DrivenJoint],
        body: &Body,
        now: Configuration,
        history: &mut History,
        now_secs: f64,
    ) -> Option<Self> {
        let last = history.samples.last()?.clone();
        let grip = body.grip();
        let (carried, longest_secs) = if grip.contacts > 0 {
            let (creep, secs) = history.creep(now_secs)?;
            (Carried::Held(creep), secs)
        } else if history.rests() && blueprint.scenario.robot.gravity_compensation == 1.0 {
            let clearance = Clearance::of(blueprint, body, &last.hand.pose, &last.object.pose);
            (Carried::Rests(clearance), f64::INFINITY)
        } else {
            return None;
        };
        let is_held = matches!(carried, Carried::Held(_));
        let begun = Self {
            arm: Arm::new(blueprint, joints, &now, is_held),
            began: now,
            object_in_hand: last.object_in_hand,
            carried,
            grip,
            elapsed_secs: 0.0,
            longest_secs,
        };
        begun.may_go_on(joints, false).then_some(begun)
    }

    /// Whether the next step may be coasted, given what the drives are about to do.
    pub(super) fn may_go_on(&self, joints: &[DrivenJoint], accelerating: bool) -> bool {
        fingers(joints).all(|index| joints[index].is_at_rest())
            && !self.has_run_out()
            && match &self.carried {
                Carried::Rests(_) if self.arm.rests() && !accelerating => true,
                Carried::Rests(clearance) => clearance.is_clear(&self.arm.hand_now().pose),
                Carried::Held(_) => !accelerating,
            }
    }

    /// Whether it has lasted as long as its rates may be relied on.
    pub(super) fn has_run_out(&self) -> bool {
        self.elapsed_secs >= self.longest_secs
    }

    /// One time step.
    pub(super) fn step(&mut self, joints: &[DrivenJoint], time_step_secs: f64) {
        self.elapsed_secs += time_step_secs;
        self.arm.step(joints, time_step_secs);
    }

    /// The angle of a joint; `finger` is its place among the fingers, if it is one.
    pub(super) fn position_rad(&self, joint: usize, finger: Option<usize>) -> f64 {
        let start_rad = self.began.positions_rad[joint];
        match (finger, &self.carried) {
            (Some(finger), Carried::Held(creep)) => {
                let rate = creep.fingers_rad_s.get(finger).copied();
                start_rad + self.elapsed_secs * rate.unwrap_or(0.0)
            }
            (None, _) => self.arm.position_rad(joint).unwrap_or(start_rad),
            _ => start_rad,
        }
    }

    /// The hand's frame.
    pub(super) fn hand(&self) -> ObjectState {
        self.arm.hand()
    }

    /// The object.
    pub(super) fn object(&self) -> ObjectState {
        self.object_with(&self.arm.hand())
    }

    fn object_with(&self, hand: &ObjectState) -> ObjectState {
        let Carried::Held(creep) = &self.carried else {
            return self.began.object;
        };
        let secs = self.elapsed_secs;
        let start = &self.object_in_hand;
        let pose = Pose {
            position_m: add(start.position_m, scale(secs, creep.object_m_s)),
            orientation: turned_by(start.orientation, scale(secs, creep.object_rad_s)),
        };
        let moving = hand.carries(&pose);
        let turn = |rate| rotate(hand.pose.orientation, rate);
        ObjectState {
            velocity_m_s: add(moving.velocity_m_s, turn(creep.object_m_s)),
            spin_rad_s: add(moving.spin_rad_s, turn(creep.object_rad_s)),
            ..moving
        }
    }

    /// How the hand holds the object: as when the coast began.
    pub(super) fn grip(&self) -> Grip {
        self.grip
    }

    /// Ends the coast: the whole configuration as it is now.
    pub(super) fn end(self, joints: &[DrivenJoint]) -> Configuration {
        let mut now = self.began.clone();
        if let Carried::Held(creep) = &self.carried {
            for (finger, index) in fingers(joints).enumerate() {
                let rate = creep.fingers_rad_s.get(finger).copied().unwrap_or(0.0);
                now.positions_rad[index] += self.elapsed_secs * rate;
                now.velocities_rad_s[index] = rate;
            }
        }
        self.arm.get(&mut now);
        now.object = self.object_with(&self.arm.hand_now());
        now
    }
}

/// Places of the fingers among the joints.
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

fn largest(rates: &[f64]) -> f64 {
    rates.iter().fold(0.0, |most, rate| rate.abs().max(most))
}
