//! Steady motion, carried on between short bursts of the whole physics.
//!
//! Definition: let `x` be what changes but slowly in a steady motion: the angles of the fingers, how far
//! each joint of the arm is from its drive's setpoint, which is known at every step, and the object's
//! pose in the hand's frame. While every drive of the arm speeds up as it did, or not at all, the
//! fingers' drives rest and nobody's force changes, bursts of [`BURST_STEPS`] steps of the whole model
//! alternate with glides of `g` steps in which `x` goes on at the rate `r` of the burst's last step,
//! whose slope is `s`: `x(k) = x + k r + k (k + 1) s / 2`, and velocities likewise. `s` is by how much
//! `r` has changed in a step since the burst before, in those coordinates that the last slope foretold
//! better than "as before" did; 0 in the others. This is projective integration (Gear and Kevrekidis,
//! "Projective methods for stiff differential equations", SIAM J. Sci. Comput. 24(4), 2003), of second
//! order where that pays: contacts and servos are stiff and settle within the burst, what is left is slow.
//!
//! Fingers so heavy that they swing take longer for all of this: a burst lasts until their dry friction
//! has settled ([`DRY_FRICTION_SETTLES_SECS`]), a glide ends before one of them comes upon the object
//! ([`super::approach`]), and while a pull has bent them they are left to the whole model.
//!
//! Accuracy: where the rate changes by `c` over `m` steps, a glide of `g` steps is wrong by `c g^2 / 2 m`;
//! where it changes by `c` more or less than its slope foretold, by `c g^3 / 3 m^2`. The next glide is as
//! long as makes that [`ALLOWED_M`], at most twice the last one; what would be shorter than
//! [`SHORTEST_STEPS`] is left to the whole model. Rates are differences of positions, so that the
//! discretisation of the whole model's own steps is in them.
//!
//! Cost: nothing in a step of a glide, until somebody asks where things are.

use testbench::geometry::{
    Pose, Quaternion, add, compose, inverse, norm, rotation_between, subtract, turned_by,
};

use super::ObjectState;
use super::approach::Approach;
use super::body::{Blueprint, Body, Configuration};
use super::chain::Chain;
use super::joints::DrivenJoint;
use crate::scenario::Drive;
use crate::world::human::Wrench;

/// Steps of the whole model between two glides. With two, and five times as much allowed, what a landing
/// had disturbed counted as a rate: of 516 tuned episodes in which the pull moves no finger by more than 60
/// counts, it moved one further than in the full physics in 179, less far in 121.
const BURST_STEPS: u32 = 4;
/// Steps over which rates are compared before a first glide, which is no longer than that.
const FIRST_STEPS: u32 = 6;
/// The longest and the shortest glide.
const LONGEST_STEPS: f64 = 40.0;
const SHORTEST_STEPS: f64 = 4.0;
/// What a glide may be wrong by: the object against the hand, and the angles that move a finger's tip
/// or the object's skin by as much.
const ALLOWED_M: f64 = 2e-7;
const ALLOWED_FINGER_RAD: f64 = ALLOWED_M / 0.05;
const ALLOWED_OBJECT_RAD: f64 = ALLOWED_M / 0.03;
/// The arm takes the object with it, and its servos make up for what it lacks: ten times as much at
/// its length.
const ALLOWED_ARM_RAD: f64 = 10.0 * ALLOWED_M / 0.8;
/// How long a burst lasts with fingers so heavy that they do not follow at once: twice the time constant
/// of the engine's dry friction (`solreffriction`, which is left at 0.02 s). What a landing has disturbed
/// has faded by then. In bursts of two steps it counts as a rate: fingers that hold the object then lose
/// the friction that a pull has to overcome, by which of 283 untuned pairs of episodes 6 lost a false
/// negative of the pressure sensor and none gained one.
const DRY_FRICTION_SETTLES_SECS: f64 = 0.04;
/// A force on the object that differs by less from the burst's is the same.
const SAME_NEWTONS: f64 = 5e-3;
const SAME_NM: f64 = 2e-4;
/// A drive that speeds up by as much, to this share of the most it can, goes on as it did.
const SAME_ACCELERATION: f64 = 0.02;

/// What is slow: the joints' angles, the arm's from their setpoints (rad), the object's place (m) and
/// turn (rad) in the hand; or how it changes in a step.
type Slow = Vec<f64>;

/// Where a joint of the arm is sent to, and how that moves; 0 for fingers, whose setpoints rest.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Sent {
    position_rad: f64,
    speed_rad_s: f64,
    /// How much it speeds up, in what it can at most.
    acceleration: f64,
}

impl Sent {
    fn of(joint: &DrivenJoint) -> Self {
        match joint.drive {
            Drive::Arm => Self {
                position_rad: joint.setpoint.position_rad(),
                speed_rad_s: joint.setpoint.speed_rad_s(),
                acceleration: joint.acceleration(),
            },
            Drive::Hand => Self::default(),
        }
    }
}

/// A step of a glide: how many there were, and the setpoints then.
#[derive(Debug, Clone, Default, PartialEq)]
struct Step {
    steps: u32,
    sent: Vec<Sent>,
}

impl Step {
    fn set(&mut self, steps: u32, joints: &[DrivenJoint]) {
        self.steps = steps;
        self.sent.clear();
        self.sent.extend(joints.iter().map(Sent::of));
    }
}

/// Where a glide ends.
pub(super) struct Landing {
    pub(super) now: Configuration,
    /// How the hand has turned since the glide began.
    pub(super) turned: Quaternion,
}

/// Watches the whole model and stands in for it while it moves steadily.
#[derive(Debug, Clone)]
pub(super) struct Glide {
    chain: Chain,
    chain_joints: Vec<usize>,
    /// The state after the last step of the whole model, the object's as seen from the hand.
    began: Configuration,
    began_at: Step,
    /// The joints' angles, the arm's from their setpoints, and the object in the hand before that step,
    /// if they are known.
    seen_rad: Vec<f64>,
    seen_object: Option<Pose>,
    /// Whether fingers are so heavy that they swing, and the steps of a burst while such ones hold it.
    fingers_swing: bool,
    heavy_burst_steps: u32,
    approach: Option<Approach>,
    /// What a glide may be wrong by.
    allowed: Slow,
    rates: Slow,
    /// How much the rates change in a step, where that is regular; else 0.
    slopes: Slow,
    fastest: Slow,
    /// The rates at the end of the burst before and how much they changed in a step until then, and the
    /// steps of the whole model since.
    reference: Option<Slow>,
    reference_slopes: Option<Slow>,
    watched_steps: u32,
    last_glide_steps: u32,
    /// How long the glide under way is, its last step and the one before.
    until_steps: Option<u32>,
    now: Step,
    before: Step,
    wrench: Wrench,
    step_secs: f64,
}

impl Glide {
    pub(super) fn new(blueprint: &Blueprint, joints: &[DrivenJoint], fingers_swing: bool) -> Self {
        let scenario = &blueprint.scenario;
        let chain = Chain::to_hand(scenario, joints);
        let step_secs = scenario.simulation.time_step_secs;
        let began = Configuration {
            positions_rad: vec![0.0; joints.len()],
            velocities_rad_s: vec![0.0; joints.len()],
            object: ObjectState::at_rest(super::chain::identity()),
        };
        let approach = fingers_swing.then(|| Approach::new(blueprint, joints, &began));
        Self {
            chain_joints: chain.joints().collect(),
            chain,
            approach: approach.flatten(),
            began,
            began_at: Step::default(),
            seen_rad: Vec::new(),
            seen_object: None,
            fingers_swing,
            heavy_burst_steps: (DRY_FRICTION_SETTLES_SECS / step_secs).ceil() as u32,
            allowed: allowed(joints),
            rates: Slow::new(),
            slopes: Slow::new(),
            fastest: Slow::new(),
            reference: None,
            reference_slopes: None,
            watched_steps: 0,
            last_glide_steps: 0,
            until_steps: None,
            now: Step::default(),
            before: Step::default(),
            wrench: Wrench::default(),
            step_secs,
        }
    }

    /// Whether this force on the object is the one of the last step of the whole model.
    pub(super) fn is_same(&self, wrench: &Wrench) -> bool {
        norm(subtract(wrench.force_newtons, self.wrench.force_newtons)) < SAME_NEWTONS
            && norm(subtract(wrench.torque_nm, self.wrench.torque_nm)) < SAME_NM
    }

    /// Whether the arm's drives speed up as they did in the last step of the whole model.
    pub(super) fn is_driven_alike(&self, joints: &[DrivenJoint]) -> bool {
        joints.iter().zip(&self.began_at.sent).all(|(joint, then)| {
            (Sent::of(joint).acceleration - then.acceleration).abs() < SAME_ACCELERATION
        })
    }

    /// Whether it stands in for the whole model.
    pub(super) fn is_going(&self) -> bool {
        self.until_steps.is_some()
    }

    /// One step of a glide towards the joints' setpoints; `false` if it is over, or there is none.
    pub(super) fn step(&mut self, joints: &[DrivenJoint]) -> bool {
        let steps = self.now.steps + 1;
        if self
            .until_steps
            .is_none_or(|until_steps| steps > until_steps)
        {
            return false;
        }
        std::mem::swap(&mut self.before, &mut self.now);
        self.now.set(steps, joints);
        true
    }

    /// Ends a glide.
    pub(super) fn land(&mut self) -> Option<Landing> {
        self.until_steps.take()?;
        let joints = 0..self.began.positions_rad.len();
        let angle_and_speed = joints.map(|joint| self.joint_at(joint, &self.now));
        let (positions_rad, velocities_rad_s) = angle_and_speed.unzip();
        let now = Configuration {
            positions_rad,
            velocities_rad_s,
            object: self.object_at(&self.now),
        };
        self.last_glide_steps = self.now.steps;
        self.seen_rad.clear();
        self.seen_rad.extend(away_rad(&now, &self.now));
        self.seen_object = Some(self.inner_after(self.now.steps).pose);
        let [from, to] = [&self.began_at, &self.now].map(|at| self.hand_at(at).pose.orientation);
        Some(Landing {
            now,
            turned: compose(to, inverse(from)),
        })
    }

    /// Forgets what it watched: the motion is no longer steady.
    pub(super) fn forget(&mut self) {
        self.seen_object = None;
        self.reference = None;
        self.reference_slopes = None;
        self.watched_steps = 0;
        self.last_glide_steps = 0;
    }

    /// Looks at the whole model after a step under a wrench, and begins a glide if it is time.
    pub(super) fn watch(&mut self, body: &Body, joints: &[DrivenJoint], wrench: &Wrench) {
        self.wrench = *wrench;
        body.get(&mut self.began);
        self.began_at.set(0, joints);
        let hand = self.hand_at(&self.began_at);
        self.began.object = self.began.object.seen_from(&hand);
        let before = self.seen_object.replace(self.began.object.pose);
        if let Some(before) = &before {
            self.measure(before);
        }
        self.seen_rad.clear();
        self.seen_rad.extend(away_rad(&self.began, &self.began_at));
        if before.is_some() {
            self.watched_steps += 1;
            self.consider();
        }
    }

    /// Begins a glide if the rates have changed so little, or so regularly, that one is worth it.
    fn consider(&mut self) {
        let glided = self.last_glide_steps;
        let enough = match glided > 0 {
            true => BURST_STEPS,
            false => FIRST_STEPS,
        };
        let enough = match self.fingers_swing {
            true => enough.max(self.heavy_burst_steps),
            false => enough,
        };
        if self.reference.is_some() && self.watched_steps < enough {
            return;
        }
        let passed = f64::from(glided + self.watched_steps);
        let most = f64::from(if glided > 0 { 2 * glided } else { FIRST_STEPS });
        let steps = self.foresee(passed).min(most);
        let steps = steps.min(if steps < SHORTEST_STEPS {
            steps
        } else {
            self.unmet_steps()
        });
        self.watched_steps = 0;
        self.last_glide_steps = 0;
        if steps >= SHORTEST_STEPS {
            self.until_steps = Some(steps.min(LONGEST_STEPS) as u32);
            self.now.clone_from(&self.began_at);
        }
    }

    /// In how many steps no finger comes upon the object unforeseen: those that swing may still be on
    /// their way to it while others hold it already.
    fn unmet_steps(&mut self) -> f64 {
        let Some(approach) = &mut self.approach else {
            return f64::INFINITY;
        };
        let slopes = self.rates.iter().zip(&self.slopes);
        self.fastest.clear();
        self.fastest
            .extend(slopes.map(|(rate, slope)| rate.abs() + LONGEST_STEPS * slope.abs()));
        approach.steps(&self.began, &self.fastest)
    }

    /// Compares the rates with those of `passed` steps before, and with what these foretold; says how
    /// long a glide from here on is right.
    fn foresee(&mut self, passed: f64) -> f64 {
        self.slopes.clear();
        self.slopes.resize(self.rates.len(), 0.0);
        let Some(reference) = &mut self.reference else {
            self.reference = Some(self.rates.clone());
            return 0.0;
        };
        let mut steps = f64::INFINITY;
        let is_first = self.reference_slopes.is_none();
        let known = self
            .reference_slopes
            .get_or_insert_with(|| vec![0.0; self.rates.len()]);
        for (index, &rate) in self.rates.iter().enumerate() {
            let (before, slope) = (&mut reference[index], &mut known[index]);
            let changed = (rate - *before) / self.allowed[index];
            let surprise = (rate - (*before + *slope * passed)) / self.allowed[index];
            let now = (rate - *before) / passed;
            // The length at which each of them is wrong by what is allowed.
            let of_constant = (2.0 * passed / changed.abs()).sqrt();
            let of_steady = (3.0 * passed * passed / surprise.abs()).cbrt();
            if !is_first && of_steady > of_constant {
                self.slopes[index] = now;
                steps = steps.min(of_steady);
            } else {
                steps = steps.min(of_constant);
            }
            (*before, *slope) = (rate, now);
        }
        steps
    }

    /// Takes the rates of the last step, before which the object was there in the hand.
    fn measure(&mut self, before: &Pose) {
        let (now, rates) = (&self.began, &mut self.rates);
        rates.clear();
        let pairs = away_rad(now, &self.began_at).zip(&self.seen_rad);
        rates.extend(pairs.map(|(now, before)| now - before));
        rates.extend(subtract(now.object.pose.position_m, before.position_m));
        rates.extend(rotation_between(
            before.orientation,
            now.object.pose.orientation,
        ));
    }

    /// By how much something slow has changed after some steps, and by how much its rate.
    fn change_after(&self, index: usize, steps: u32) -> (f64, f64) {
        let steps = f64::from(steps);
        let faster = steps * self.slopes[index];
        (
            steps * self.rates[index] + faster * (steps + 1.0) / 2.0,
            faster,
        )
    }

    /// Angle and speed of a joint.
    fn joint_at(&self, joint: usize, at: &Step) -> (f64, f64) {
        let [began_rad, began_rad_s] =
            [&self.began.positions_rad, &self.began.velocities_rad_s].map(|values| values[joint]);
        if at.steps == 0 {
            return (began_rad, began_rad_s);
        }
        let (from, to) = (&self.began_at.sent[joint], &at.sent[joint]);
        let (away_rad, faster_rad) = self.change_after(joint, at.steps);
        (
            began_rad + (to.position_rad - from.position_rad) + away_rad,
            began_rad_s + (to.speed_rad_s - from.speed_rad_s) + faster_rad / self.step_secs,
        )
    }

    /// The hand in the world.
    fn hand_at(&self, at: &Step) -> ObjectState {
        let state = |index: usize| self.joint_at(self.chain_joints[index], at);
        self.chain.hand(state)
    }

    /// The object in the hand.
    fn inner_after(&self, steps: u32) -> ObjectState {
        let began = &self.began.object;
        if steps == 0 {
            return *began;
        }
        let first = self.began.positions_rad.len();
        let changes: [_; 6] = std::array::from_fn(|k| self.change_after(first + k, steps));
        let [x, y, z, a, b, c] = changes.map(|(change, _)| change);
        let [vx, vy, vz, va, vb, vc] = changes.map(|(_, faster)| faster / self.step_secs);
        ObjectState {
            pose: Pose {
                position_m: add(began.pose.position_m, [x, y, z]),
                orientation: turned_by(began.pose.orientation, [a, b, c]),
            },
            velocity_m_s: add(began.velocity_m_s, [vx, vy, vz]),
            spin_rad_s: add(began.spin_rad_s, [va, vb, vc]),
        }
    }

    /// The object in the world.
    fn object_at(&self, at: &Step) -> ObjectState {
        self.inner_after(at.steps).carried_by(&self.hand_at(at))
    }

    /// The angle of a joint, while it is going.
    pub(super) fn position_rad(&self, joint: usize) -> Option<f64> {
        self.until_steps?;
        Some(self.joint_at(joint, &self.now).0)
    }

    /// The hand's frame as it was before the last step, if that was one of a glide: what is asked of
    /// the engine after a step belongs to the time before it.
    pub(super) fn hand(&self) -> Option<ObjectState> {
        Some(self.hand_at(self.last_step()?))
    }

    /// The object, likewise.
    pub(super) fn object(&self) -> Option<ObjectState> {
        Some(self.object_at(self.last_step()?))
    }

    fn last_step(&self) -> Option<&Step> {
        (self.is_going() && self.now.steps > 0).then_some(&self.before)
    }
}

/// The joints' angles, the arm's from their setpoints.
fn away_rad(state: &Configuration, at: &Step) -> impl Iterator<Item = f64> {
    let pairs = state.positions_rad.iter().zip(&at.sent);
    pairs.map(|(angle_rad, to)| angle_rad - to.position_rad)
}

/// What a glide may be wrong by.
fn allowed(joints: &[DrivenJoint]) -> Slow {
    let of_joints = joints.iter().map(|joint| match joint.drive {
        Drive::Arm => ALLOWED_ARM_RAD,
        Drive::Hand => ALLOWED_FINGER_RAD,
    });
    let of_object = [ALLOWED_M; 3].into_iter().chain([ALLOWED_OBJECT_RAD; 3]);
    of_joints.chain(of_object).collect()
}
