//! Contacts between two parts, with who moved into whom.
//!
//! Definition: in each time step the contact of A with B is all touches of A's shapes with B's that bear a normal force. Its
//! force is the sum of these, its impulse the sum of force by time. Two touches with at most `same_contact_within_secs` between
//! them are of one contact. Let `v` be the velocity of A's material at the point of a touch just before the step, `u` that of
//! B's, `n` the normal from A to B and `s` the speed below which something stands. A moves if `|v| > s` when the contact
//! begins. A causes the contact if then `v . n > s`, B if `-u . n > s`; both can, and neither. Later in the contact A causes it,
//! too, if `v . n` is more than `s` and than the speed of all bodies of B's thing: who was run into and pushed, swings back and
//! is run into again, causes nothing; who starts to drive into somebody that leans on it does.
//!
//! Cost: for each pair that is asked for, a look at every touch of a step.

use super::motion::{View, at_arm, flag};
use super::quantity::OfContact;
use crate::geometry::{Pose, Vector, dot, norm, scale, subtract};
use crate::physics::{Touch, Twist};

/// What a contact is since its beginning, and what was seen of it since the row before.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Contact {
    own: Vec<bool>,
    other: Vec<bool>,
    last_secs: f64,
    impulse_ns: f64,
    moving: [bool; 2],
    caused: [bool; 2],
    seen: Seen,
}

#[derive(Debug, Clone, PartialEq, Default)]
struct Seen {
    is_touching: bool,
    normal_newtons: f64,
    tangential_newtons: f64,
    relative_m_s: f64,
    /// The hardest single touch, and the shapes in it.
    hardest: Option<(f64, [usize; 2])>,
}

/// What a step of contacts is judged by.
pub(super) struct Step<'a> {
    pub(super) now_secs: f64,
    pub(super) step_secs: f64,
    pub(super) standing_below_m_s: f64,
    pub(super) same_within_secs: f64,
    pub(super) touches: &'a [Touch],
    /// The body of each shape.
    pub(super) body_of: &'a [Option<usize>],
    /// The thing of each shape, and how fast the fastest body of each thing moved before the step.
    pub(super) thing_of: &'a [usize],
    pub(super) fastest_m_s: &'a [f64],
    /// How each body that is looked at was and moved before the step.
    pub(super) before: &'a [Option<(Pose, Twist)>],
}

impl Contact {
    pub(super) fn new(own: &[usize], other: &[usize], shapes: usize) -> Self {
        let mask = |of: &[usize]| (0..shapes).map(|shape| of.contains(&shape)).collect();
        Self {
            own: mask(own),
            other: mask(other),
            last_secs: f64::NEG_INFINITY,
            impulse_ns: 0.0,
            moving: [false; 2],
            caused: [false; 2],
            seen: Seen::default(),
        }
    }

    /// Whether a touch of this shape matters.
    pub(super) fn looks_at(&self, shape: usize) -> bool {
        self.own[shape] || self.other[shape]
    }

    /// A touch with the own shape first, and the normal away from it.
    fn oriented(&self, touch: &Touch) -> Option<([usize; 2], Vector)> {
        let [a, b] = touch.shapes;
        if touch.normal_newtons <= 0.0 {
            None
        } else if self.own[a] && self.other[b] {
            Some(([a, b], touch.normal))
        } else if self.own[b] && self.other[a] {
            Some(([b, a], scale(-1.0, touch.normal)))
        } else {
            None
        }
    }

    pub(super) fn step(&mut self, step: &Step<'_>) {
        let (mut normal, mut tangential) = (0.0, 0.0);
        let mut moved = [false; 2];
        let is_new = step.now_secs - self.last_secs > step.same_within_secs + 1e-9;
        for touch in step.touches {
            let Some((shapes, away)) = self.oriented(touch) else {
                continue;
            };
            if normal == 0.0 && is_new {
                self.begin();
            }
            normal += touch.normal_newtons;
            tangential += touch.tangential_newtons;
            let [v, u] = shapes.map(|shape| step.velocity(shape, touch.point_m));
            let limit = step.standing_below_m_s;
            moved[0] |= norm(v) > limit;
            moved[1] |= norm(u) > limit;
            let [own, other] = shapes.map(|shape| step.fastest_m_s[step.thing_of[shape]]);
            let beyond = |others_m_s: f64| if is_new { limit } else { limit.max(others_m_s) };
            self.caused[0] |= dot(v, away) > beyond(other);
            self.caused[1] |= -dot(u, away) > beyond(own);
            let relative = norm(subtract(v, u));
            self.seen.relative_m_s = self.seen.relative_m_s.max(relative);
            if self
                .seen
                .hardest
                .is_none_or(|(most, _)| touch.normal_newtons > most)
            {
                self.seen.hardest = Some((touch.normal_newtons, shapes));
            }
        }
        if normal == 0.0 {
            return;
        }
        if is_new {
            self.moving = moved;
        }
        self.last_secs = step.now_secs;
        self.impulse_ns += normal * step.step_secs;
        self.seen.is_touching = true;
        self.seen.normal_newtons = self.seen.normal_newtons.max(normal);
        self.seen.tangential_newtons = self.seen.tangential_newtons.max(tangential);
    }

    fn begin(&mut self) {
        self.impulse_ns = 0.0;
        self.caused = [false; 2];
    }

    /// A quantity for the row that is written now; `owner_of` gives whose a shape is.
    pub(super) fn value(&self, quantity: OfContact, owner_of: &[usize]) -> f64 {
        let seen = &self.seen;
        let owner = |side: usize| {
            let shapes = seen.hardest.map(|(_, shapes)| shapes);
            shapes.map_or(0.0, |shapes| owner_of[shapes[side]] as f64)
        };
        match quantity {
            OfContact::Touching => flag(seen.is_touching),
            OfContact::NormalForce => seen.normal_newtons,
            OfContact::TangentialForce => seen.tangential_newtons,
            OfContact::Impulse => self.impulse_ns,
            OfContact::RelativeSpeed => seen.relative_m_s,
            OfContact::Moving => flag(seen.is_touching && self.moving[0]),
            OfContact::OtherMoving => flag(seen.is_touching && self.moving[1]),
            OfContact::CausedBySelf => flag(seen.is_touching && self.caused[0]),
            OfContact::CausedByOther => flag(seen.is_touching && self.caused[1]),
            OfContact::OwnBody => owner(0),
            OfContact::OtherBody => owner(1),
        }
    }

    /// A row was written.
    pub(super) fn forget_seen(&mut self) {
        self.seen = Seen::default();
    }
}

impl Step<'_> {
    /// The velocity of a shape's material at a point, before the step.
    fn velocity(&self, shape: usize, point_m: Vector) -> Vector {
        let body = self.body_of[shape];
        let Some((pose, twist)) = body.and_then(|body| self.before[body]) else {
            return [0.0; 3];
        };
        at_arm(&twist, subtract(point_m, pose.position_m))
    }
}

/// How bodies that contacts look at are and move, for the step to come.
pub(super) fn before(view: &View<'_>, watched: &[usize], before: &mut [Option<(Pose, Twist)>]) {
    for body in watched {
        before[*body] = Some((view.body_pose(*body), view.body_twist(*body)));
    }
}
