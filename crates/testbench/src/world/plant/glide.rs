//! Steady motion, carried on between short bursts of the whole physics.
//!
//! Definition: let `x` be what changes but slowly in a steady motion: the joints' angles and the
//! object's pose in the hand's frame. While no drive speeds up or slows down and nobody's force
//! changes, bursts of [`BURST_STEPS`] steps of the whole model alternate with glides of `g` steps in
//! which `x` goes on at the rate `r` of the burst's last step, `x(k) = x + k r`, and velocities stay
//! as they are (the object's against the hand). This is projective integration (Gear and Kevrekidis,
//! "Projective methods for stiff differential equations", SIAM J. Sci. Comput. 24(4), 2003): contacts
//! and servos are stiff and settle within the burst, what is left is slow.
//!
//! Fingers so heavy that they swing are left to the whole model: they settle in tenths of a second, so
//! that under a pull glides run ahead of them, and of 900 untuned pairs of episodes 16 had a false
//! negative of the pressure sensor in the full physics alone and 1 with glides alone.
//!
//! Accuracy: where the rate changes by `c` from one burst to the next, a glide of `g` steps is wrong
//! by `c g / 2`. The next glide is as long as makes that [`ALLOWED_M`], at most twice the last one;
//! what would be shorter than [`SHORTEST_STEPS`] is left to the whole model. The errors of a creep
//! that slows down add up to no more than half a glide's time by the change of its speed. Rates are
//! differences of positions, so that the discretisation of the whole model's own steps is in them.
//!
//! Cost: nothing in a step of a glide, until somebody asks where things are.

use super::ObjectState;
use super::body::{Body, Configuration};
use super::chain::Chain;
use super::joints::DrivenJoint;
use crate::geometry::{
    Pose, Quaternion, Vector, add, compose, inverse, norm, rotation_between, scale, subtract,
    turned_by,
};
use crate::scenario::{Drive, Scenario};
use crate::world::human::Wrench;

/// Steps of the whole model between two glides.
const BURST_STEPS: u32 = 2;
/// Steps over which rates are compared before a first glide, which is no longer than that.
const FIRST_STEPS: u32 = 6;
/// The longest and the shortest glide.
const LONGEST_STEPS: f64 = 40.0;
const SHORTEST_STEPS: f64 = 4.0;
/// What a glide may be wrong by: the object against the hand, and the angles that move a finger's tip
/// or the object's skin by as much.
const ALLOWED_M: f64 = 1e-6;
const ALLOWED_FINGER_RAD: f64 = ALLOWED_M / 0.05;
const ALLOWED_OBJECT_RAD: f64 = ALLOWED_M / 0.03;
/// The arm takes the object with it, and its servos make up for what it lacks: ten times as much at
/// its length.
const ALLOWED_ARM_RAD: f64 = 10.0 * ALLOWED_M / 0.8;
/// A force on the object that differs by less from the burst's is the same.
const SAME_NEWTONS: f64 = 5e-3;
const SAME_NM: f64 = 2e-4;

/// By how much what is slow changes in a step.
#[derive(Debug, Clone, Default, PartialEq)]
struct Rates {
    turned_rad: Vec<f64>,
    object_m: Vector,
    object_rad: Vector,
}

/// A glide under way.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Going {
    steps: u32,
    until_steps: u32,
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
    is_arm: Vec<bool>,
    /// The state after the last step of the whole model, the object's as seen from the hand.
    began: Configuration,
    /// The joints' angles and the object in the hand before that step, if they are known.
    seen_rad: Vec<f64>,
    seen_object: Option<Pose>,
    rates: Rates,
    /// The rates at the end of the burst before, and the steps of the whole model since.
    reference: Option<Rates>,
    watched_steps: u32,
    last_glide_steps: u32,
    going: Option<Going>,
    wrench: Wrench,
}

impl Glide {
    pub(super) fn new(scenario: &Scenario, joints: &[DrivenJoint]) -> Self {
        let chain = Chain::to_hand(scenario, joints);
        Self {
            chain_joints: chain.joints().collect(),
            is_arm: joints.iter().map(|it| it.drive == Drive::Arm).collect(),
            chain,
            began: Configuration {
                positions_rad: vec![0.0; joints.len()],
                velocities_rad_s: vec![0.0; joints.len()],
                object: ObjectState::at_rest(super::chain::identity()),
            },
            seen_rad: Vec::new(),
            seen_object: None,
            rates: Rates::default(),
            reference: None,
            watched_steps: 0,
            last_glide_steps: 0,
            going: None,
            wrench: Wrench::default(),
        }
    }

    /// Whether this force on the object is the one of the last step of the whole model.
    pub(super) fn is_same(&self, wrench: &Wrench) -> bool {
        norm(subtract(wrench.force_newtons, self.wrench.force_newtons)) < SAME_NEWTONS
            && norm(subtract(wrench.torque_nm, self.wrench.torque_nm)) < SAME_NM
    }

    /// Whether it stands in for the whole model.
    pub(super) fn is_going(&self) -> bool {
        self.going.is_some()
    }

    /// One step of a glide; `false` if it is over, or there is none.
    pub(super) fn step(&mut self) -> bool {
        match &mut self.going {
            Some(going) if going.steps < going.until_steps => {
                going.steps += 1;
                true
            }
            _ => false,
        }
    }

    /// Ends a glide.
    pub(super) fn land(&mut self) -> Option<Landing> {
        let steps = self.going.take()?.steps;
        let joints = 0..self.began.positions_rad.len();
        let now = Configuration {
            positions_rad: joints.map(|joint| self.angle_after(joint, steps)).collect(),
            velocities_rad_s: self.began.velocities_rad_s.clone(),
            object: self.object_after(steps),
        };
        self.last_glide_steps = steps;
        self.seen_rad.clone_from(&now.positions_rad);
        self.seen_object = Some(self.inner_after(steps).pose);
        let [from, to] = [0, steps].map(|steps| self.hand_after(steps).pose.orientation);
        Some(Landing {
            now,
            turned: compose(to, inverse(from)),
        })
    }

    /// Forgets what it watched: the motion is no longer steady.
    pub(super) fn forget(&mut self) {
        self.seen_object = None;
        self.reference = None;
        self.last_glide_steps = 0;
    }

    /// Looks at the whole model after a step under a wrench, and begins a glide if it is time.
    pub(super) fn watch(&mut self, body: &Body, wrench: &Wrench) {
        self.wrench = *wrench;
        body.get(&mut self.began);
        let hand = self.hand_after(0);
        self.began.object = self.began.object.seen_from(&hand);
        let before = self.seen_object.replace(self.began.object.pose);
        if let Some(before) = &before {
            self.measure(before);
        }
        self.seen_rad.clone_from(&self.began.positions_rad);
        if before.is_some() {
            self.watched_steps += 1;
            self.consider();
        }
    }

    /// Begins a glide if the rates have changed so little that one is worth it.
    fn consider(&mut self) {
        let glided = self.last_glide_steps;
        let enough = if glided > 0 { BURST_STEPS } else { FIRST_STEPS };
        let changed = match &self.reference {
            Some(_) if self.watched_steps < enough => return,
            Some(reference) => self.change_from(reference),
            None => f64::INFINITY,
        };
        // In a steady change the error grows with the square of the length.
        let steps = if glided > 0 {
            let glided = f64::from(glided);
            (2.0 * glided / changed).sqrt().min(2.0 * glided)
        } else {
            let first = f64::from(FIRST_STEPS);
            (2.0 * first / changed).sqrt().min(first)
        };
        self.reference
            .get_or_insert_default()
            .clone_from(&self.rates);
        self.watched_steps = 0;
        self.last_glide_steps = 0;
        self.going = (steps >= SHORTEST_STEPS).then(|| Going {
            steps: 0,
            until_steps: steps.min(LONGEST_STEPS) as u32,
        });
    }

    /// Takes the rates of the last step, before which the object was there in the hand.
    fn measure(&mut self, before: &Pose) {
        let now = &self.began;
        let pairs = now.positions_rad.iter().zip(&self.seen_rad);
        let rates = &mut self.rates;
        rates.turned_rad.clear();
        rates
            .turned_rad
            .extend(pairs.map(|(now, before)| now - before));
        rates.object_m = subtract(now.object.pose.position_m, before.position_m);
        rates.object_rad = rotation_between(before.orientation, now.object.pose.orientation);
    }

    /// By how much the rates differ from others, in what is allowed.
    fn change_from(&self, other: &Rates) -> f64 {
        let apart = |a: Vector, b: Vector| norm(subtract(a, b));
        let joints = self.rates.turned_rad.iter().zip(&other.turned_rad);
        let joints = joints.zip(&self.is_arm).map(|((a, b), is_arm)| {
            let allowed_rad = if *is_arm {
                ALLOWED_ARM_RAD
            } else {
                ALLOWED_FINGER_RAD
            };
            (a - b).abs() / allowed_rad
        });
        joints
            .fold(0.0, f64::max)
            .max(apart(self.rates.object_m, other.object_m) / ALLOWED_M)
            .max(apart(self.rates.object_rad, other.object_rad) / ALLOWED_OBJECT_RAD)
    }

    fn angle_after(&self, joint: usize, steps: u32) -> f64 {
        let began_rad = self.began.positions_rad[joint];
        if steps == 0 {
            began_rad
        } else {
            began_rad + f64::from(steps) * self.rates.turned_rad[joint]
        }
    }

    /// The hand in the world.
    fn hand_after(&self, steps: u32) -> ObjectState {
        let frames = self.chain.follow(|index| {
            let joint = self.chain_joints[index];
            let angle_rad = self.angle_after(joint, steps);
            (angle_rad, self.began.velocities_rad_s[joint])
        });
        frames.hand
    }

    /// The object in the hand.
    fn inner_after(&self, steps: u32) -> ObjectState {
        let began = &self.began.object;
        let steps = f64::from(steps);
        let moved = scale(steps, self.rates.object_m);
        let turned = scale(steps, self.rates.object_rad);
        ObjectState {
            pose: Pose {
                position_m: add(began.pose.position_m, moved),
                orientation: turned_by(began.pose.orientation, turned),
            },
            ..*began
        }
    }

    /// The object in the world.
    fn object_after(&self, steps: u32) -> ObjectState {
        self.inner_after(steps).carried_by(&self.hand_after(steps))
    }

    /// The angle of a joint, while it is going.
    pub(super) fn position_rad(&self, joint: usize) -> Option<f64> {
        Some(self.angle_after(joint, self.going?.steps))
    }

    /// The hand's frame as it was before the last step, if that was one of a glide: what is asked of
    /// the engine after a step belongs to the time before it.
    pub(super) fn hand(&self) -> Option<ObjectState> {
        Some(self.hand_after(self.last_step()?))
    }

    /// The object, likewise.
    pub(super) fn object(&self) -> Option<ObjectState> {
        Some(self.object_after(self.last_step()?))
    }

    fn last_step(&self) -> Option<u32> {
        self.going?.steps.checked_sub(1)
    }
}
