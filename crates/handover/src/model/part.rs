//! What of the model is written, and of which scenarios a part can stand in for the whole.

use crate::scenario::{Drive, Scenario};

/// How the engine comes by the pairs of shapes of hand and object. Its numbers are the same, bit for bit.
///
/// The object's pairs with what it stands on are not among them: it begins at a distance of 0, where the boxes of the
/// engine's search do not touch yet and its shapes do, by a rounding, so that a list would give another first step.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Contacts {
    /// They are listed, in the order in which the engine would find them: less time.
    #[default]
    Listed,
    /// The engine finds them, by trees of boxes and the masks of who touches whom: what the list is held against.
    #[cfg_attr(
        not(test),
        expect(dead_code, reason = "the reference that tests compare with")
    )]
    Found,
}

/// A part of the model.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Part {
    /// Whether the model is written for speed, beyond what leaves every bit as it is: all pairs are listed, and where the arm carries its own
    /// weight there is no gravity, but for a force on the object that the caller applies. The equations are the same.
    pub(crate) is_lean: bool,
    /// How pairs that can touch are found.
    pub(crate) contacts: Contacts,
    /// Whether the human's head and hand are left out, which touch nothing and only viewers show.
    pub(crate) is_without_human: bool,
}

impl Part {
    /// Whether the object's weight is a force that the caller applies.
    pub(crate) fn is_weightless(self, scenario: &Scenario) -> bool {
        self.is_lean && scenario.robot.gravity_compensation == 1.0
    }
}

/// Whether the robot is an arm that carries its own weight, with a hand at its end: every joint of
/// the hand's drive and every shape that touches the object are on the hand, the arm's joints are on
/// the way to it.
pub(crate) fn hand_is_separable(scenario: &Scenario) -> bool {
    let hand = &scenario.robot.hand;
    let way = ancestors(scenario, hand);
    scenario.robot.gravity_compensation == 1.0
        && scenario.bodies.iter().all(|body| {
            let beyond = body.name != *hand && ancestors(scenario, &body.name).contains(&hand);
            let touches = body.contact_shape.is_some() && !beyond && body.name != *hand;
            !touches
                && body.joint.as_ref().is_none_or(|joint| match joint.drive {
                    Drive::Hand => beyond,
                    Drive::Arm => way.contains(&&body.name),
                })
        })
}

/// A body with those that it hangs on.
fn ancestors<'a>(scenario: &'a Scenario, name: &'a String) -> Vec<&'a String> {
    let parent = |name: &String| scenario.bodies.iter().find(|body| body.name == *name);
    std::iter::successors(Some(name), |name| Some(&parent(name)?.parent)).collect()
}
