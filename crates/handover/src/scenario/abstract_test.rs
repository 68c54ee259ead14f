//! Abstract tests: what the human does, in three verbs.
//!
//! A test says which signals the human sends, which it waits for, and which of gaze, pressure and
//! location it applies; the parameter set makes that concrete (angles, forces, delays). The two
//! tiers follow D. Araiza-Illan et al., "Coverage-driven verification: an approach to verify code
//! for robots that directly interact with humans" (2015).

use schemars::JsonSchema;
use serde::Deserialize;
use testbench::{Distribution, ScenarioError, Stream};

use stimulus::{Setting, Verb};

/// A named list of actions of the human.
#[derive(Debug, Clone, PartialEq, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AbstractTest {
    /// What the test is called.
    pub name: String,
    /// What the human does, in order.
    pub actions: Vec<Action>,
}

/// One action of the human: exactly one of the three verbs.
#[derive(Debug, Clone, PartialEq, JsonSchema, Deserialize)]
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum HumanSignal {
    /// Start the handover.
    Activate,
    /// Ready to take the object.
    Ready,
}

/// A signal the robot can send.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum RobotSignal {
    /// Ready to hand over.
    Announcement,
}

/// What the human applies; what is not named stays as it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, JsonSchema, Deserialize)]
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
    /// The test that `test` means in the handover. Delays of kinds that [`Distribution`] does not
    /// have are drawn here, each from a stream of its own under `seed`.
    ///
    /// # Errors
    /// What is wrong with which action.
    pub fn concrete(test: &stimulus::AbstractTest, seed: u64) -> Result<Self, String> {
        let actions = test.actions.iter().enumerate().map(|(index, action)| {
            let mut stream = Stream::named(seed, &format!("delay of action {index}"));
            let action = Action::concrete(action, &mut stream);
            action.map_err(|reason| format!("test \"{}\", action {index}: {reason}", test.name))
        });
        let concrete = Self {
            name: test.name.clone(),
            actions: actions.collect::<Result<_, _>>()?,
        };
        concrete.check().map_err(|error| error.to_string())?;
        Ok(concrete)
    }

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

impl Action {
    fn concrete(action: &stimulus::Action, stream: &mut Stream) -> Result<Self, String> {
        let mut concrete = Self {
            send_signal: None,
            receive_signal: None,
            set_param: None,
            after_secs: delay(&action.after_secs, stream),
        };
        match &action.verb {
            Verb::Send(signal) => {
                concrete.send_signal = Some(match signal.as_str() {
                    "activate" => HumanSignal::Activate,
                    "ready" => HumanSignal::Ready,
                    _ => return Err(unknown("a signal to send", signal, "activate or ready")),
                });
            }
            Verb::Receive(signal) if signal == "announcement" => {
                concrete.receive_signal = Some(RobotSignal::Announcement);
            }
            Verb::Receive(signal) => {
                return Err(unknown("a signal to receive", signal, "announcement"));
            }
            Verb::Set(settings) => {
                let mut parameters = HumanParameters::default();
                for (name, setting) in settings {
                    parameters.set(name, setting)?;
                }
                concrete.set_param = Some(parameters);
            }
        }
        Ok(concrete)
    }
}

impl HumanParameters {
    fn set(&mut self, name: &str, setting: &Setting) -> Result<(), String> {
        let Setting::Bool(applied) = *setting else {
            return Err(format!("\"{name}\" must be true or false"));
        };
        let parameter = match name {
            "gaze" => &mut self.gaze,
            "pressure" => &mut self.pressure,
            "location" => &mut self.location,
            _ => return Err(unknown("a parameter", name, "gaze, pressure or location")),
        };
        *parameter = Some(applied);
        Ok(())
    }
}

fn unknown(what: &str, name: &str, known: &str) -> String {
    format!("\"{name}\" is not {what} in the handover; use {known}")
}

/// The same distribution in the scenario's terms, or one draw from it.
fn delay(distribution: &stimulus::Distribution, stream: &mut Stream) -> Distribution {
    match *distribution {
        stimulus::Distribution::Constant(value) => Distribution::Constant(value),
        stimulus::Distribution::Uniform { low, high } => Distribution::Uniform {
            uniform: [low, high],
        },
        ref other => Distribution::Constant(other.quantile(stream.unit())),
    }
}
