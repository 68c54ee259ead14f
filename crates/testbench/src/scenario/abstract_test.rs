//! Abstract tests: what the human does, in three verbs.
//!
//! A test says which signals the human sends, which it waits for, and which of gaze, pressure and
//! location it applies; the parameter set makes that concrete (angles, forces, delays). The two
//! tiers follow D. Araiza-Illan et al., "Coverage-driven verification: an approach to verify code
//! for robots that directly interact with humans" (2015).

use serde::Deserialize;

use super::ScenarioError;
use crate::random::Distribution;

/// A named list of actions of the human.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AbstractTest {
    /// What the test is called.
    pub name: String,
    /// What the human does, in order.
    pub actions: Vec<Action>,
}

/// One action of the human: exactly one of the three verbs.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Action {
    /// Sends a signal to the robot: `activate` or `ready`.
    pub send_signal: Option<HumanSignal>,
    /// Waits for a signal from the robot: `announcement`.
    pub receive_signal: Option<RobotSignal>,
    /// Applies or stops applying gaze, pressure and location.
    pub set_param: Option<HumanParameters>,
    /// The human's delay before acting, in seconds.
    #[serde(default = "no_delay")]
    pub after_secs: Distribution,
}

/// A signal the human can send.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HumanSignal {
    /// Start the handover.
    Activate,
    /// Ready to take the object.
    Ready,
}

/// A signal the robot can send.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RobotSignal {
    /// Ready to hand over.
    Announcement,
}

/// What the human applies; what is not named stays as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HumanParameters {
    /// Looks at the object (`false`: away from it).
    pub gaze: Option<bool>,
    /// Pulls on the object.
    pub pressure: Option<bool>,
    /// Has the hand on the object.
    pub location: Option<bool>,
}

fn no_delay() -> Distribution {
    Distribution::Constant(0.0)
}

impl AbstractTest {
    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        for (index, action) in self.actions.iter().enumerate() {
            let key = format!("abstract_test.{}.actions[{index}]", self.name);
            let verbs = [
                action.send_signal.is_some(),
                action.receive_signal.is_some(),
                action.set_param.is_some(),
            ];
            if verbs.iter().filter(|given| **given).count() != 1 {
                return Err(ScenarioError::value(
                    &key,
                    "must have exactly one of send_signal, receive_signal and set_param",
                ));
            }
            action
                .after_secs
                .check(&format!("{key}.after_secs"), 0.0, 3600.0)?;
        }
        Ok(())
    }
}
