//! People who take what is offered to them.
//!
//! # Definition
//! An object is offered while it is nearer to a shoulder than the person reaches out for. After a delay the nearer hand goes to it on a
//! straight line, at its speed, until its surface is within [`GRASPS_M`] of the object's. Then the hand holds the object by the spring of
//! [`super::attachment`] and draws it back to the chest. It pulls with no more than its grip `G`: of the spring's stiffness `k` and
//! force `f` besides the weight it moves in an update by at most `(G - f) / k`, and gives way by as much where the pull is harder. So who
//! does not let go is pulled by `G`, and who lets go loses the object to the hand. Elbows hang down.
//!
//! # Deviation
//! A stand-in for handing over, not a model of it: the hand neither turns nor closes, and what it holds is assumed to be held. Only hands
//! that are led take something: on a hand that gives way, which weighs little, the spring of an attachment is not stable.

use super::attachment::Attachment;
use super::build::{Built, BuiltPerson};
use super::data::{Person, SceneData};
use super::draws::Draws;
use super::person::{HandAt, hand_of, hands_of, resting_hand, shoulder_of};
use super::walker::Walker;
use crate::geometry::{Vector, add, norm, scale, subtract};
use crate::physics::{Motion, Physics};

/// How near a hand comes before it grasps, from surface to surface.
const GRASPS_M: f64 = 0.004;

/// What a person is at with the object.
#[derive(Debug, Clone, PartialEq)]
enum Phase {
    /// Since when it is offered, if it is.
    Waits(Option<f64>),
    Reaches,
    Holds(Box<Attachment>),
}

/// A person who takes an object, in an episode.
#[derive(Debug, Clone)]
pub(super) struct Taking {
    object: usize,
    body: usize,
    within_m: f64,
    delay_secs: f64,
    speed_m_s: f64,
    grip_newtons: f64,
    phase: Phase,
    is_told: bool,
}

impl Taking {
    /// Of a person who takes something that is loose.
    pub(super) fn new(
        person: &Person,
        data: &SceneData,
        built: &Built,
        draws: Draws,
    ) -> Option<Self> {
        let takes = person.takes.as_ref()?;
        let object = data.objects.iter().position(|it| it.name == takes.object)?;
        let body = built.objects[object].body?;
        let is_loose = built.layout.bodies[body].motion == Motion::Free;
        let drawn =
            |field: &str, of| draws.of("person", &person.name, &format!("takes.{field}"), of);
        is_loose.then(|| Self {
            object,
            body,
            within_m: drawn("within_m", &takes.within_m),
            delay_secs: drawn("delay_secs", &takes.delay_secs),
            speed_m_s: drawn("hand_speed_m_s", &takes.hand_speed_m_s),
            grip_newtons: drawn("grip_newtons", &takes.grip_newtons),
            phase: Phase::Waits(None),
            is_told: false,
        })
    }

    /// Whether the hand holds it.
    pub(super) fn holds(&self) -> bool {
        matches!(self.phase, Phase::Holds(_))
    }

    /// Whether it was taken since it was asked last.
    pub(super) fn has_taken(&mut self) -> bool {
        let is_new = self.holds() && !self.is_told;
        self.is_told |= is_new;
        is_new
    }

    /// Bodies to which forces of the last step apply.
    pub(super) fn pulled(&self) -> Option<[usize; 2]> {
        match &self.phase {
            Phase::Holds(attachment) => Some([attachment.holder, attachment.held]),
            Phase::Waits(_) | Phase::Reaches => None,
        }
    }

    /// Forces of the coming step.
    pub(super) fn pull(&mut self, physics: &mut dyn Physics) {
        if let Phase::Holds(attachment) = &mut self.phase {
            attachment.pull(physics);
        }
    }

    /// The hand goes on by a period.
    pub(super) fn update(
        &mut self,
        (now_secs, period_secs): (f64, f64),
        walker: &mut Walker,
        (person, built): (&BuiltPerson, &Built),
        physics: &mut dyn Physics,
    ) {
        let height_m = person.height_m;
        let there = physics.body_pose(self.body).position_m;
        let step_m = self.speed_m_s * period_secs;
        match &mut self.phase {
            Phase::Waits(since) => {
                let far = |side: usize| {
                    norm(subtract(there, shoulder_of(height_m, &walker.stance, side)))
                };
                let side = usize::from(far(1) < far(0));
                if far(side) > self.within_m {
                    *since = None;
                    return;
                }
                let since_secs = *since.get_or_insert(now_secs);
                if now_secs - since_secs >= self.delay_secs {
                    let Some(hands) = hands_of(walker.body, height_m, &walker.stance) else {
                        return;
                    };
                    let at_m = hands[side];
                    walker.stance.hand = Some(HandAt { side, at_m });
                    self.phase = Phase::Reaches;
                }
            }
            Phase::Reaches => self.reach(walker, (person, built), physics, step_m),
            Phase::Holds(attachment) => {
                let Some(hand) = walker.stance.hand else {
                    return;
                };
                let pull = attachment.pull_newtons();
                let give_m = (self.grip_newtons - norm(pull)) / attachment.stiffness_n_m();
                let home = resting_hand(height_m, &walker.stance, hand.side);
                let goal = if give_m >= 0.0 {
                    home
                } else {
                    add(hand.at_m, pull)
                };
                walker.stance.hand = Some(towards(hand, goal, step_m.min(give_m.abs())));
            }
        }
    }

    /// The hand goes on to the object by so far at most, and grasps it.
    fn reach(
        &mut self,
        walker: &mut Walker,
        (person, built): (&BuiltPerson, &Built),
        physics: &mut dyn Physics,
        step_m: f64,
    ) {
        let Some(hand) = walker.stance.hand else {
            return;
        };
        let part = hand_of(hand.side);
        let shapes = built.objects[self.object].shapes.clone();
        let hand_shape = person.shapes.start + part;
        let gaps = shapes.map(|shape| physics.distance_m(hand_shape, shape, 1.0));
        let gap_m = gaps.fold(1.0, f64::min);
        if gap_m <= GRASPS_M {
            let holder = person.bodies.start + part;
            let attachment = Attachment::new(&built.layout, physics, holder, self.body);
            self.phase = Phase::Holds(Box::new(attachment));
            return;
        }
        // Not into the object, which a hand that is led would push away.
        let most_m = step_m.min((gap_m - GRASPS_M / 2.0).max(0.0));
        let there = physics.body_pose(self.body).position_m;
        walker.stance.hand = Some(towards(hand, there, most_m));
    }
}

/// The hand on its way to a place, by so far at most.
fn towards(hand: HandAt, goal_m: Vector, most_m: f64) -> HandAt {
    let way = subtract(goal_m, hand.at_m);
    let length_m = norm(way);
    let at_m = match length_m > most_m {
        true => add(hand.at_m, scale(most_m / length_m, way)),
        false => goal_m,
    };
    HandAt { at_m, ..hand }
}
