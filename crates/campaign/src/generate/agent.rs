//! Usage-like tests: an agent with beliefs that follows plans.
//!
//! ```text
//! repeat: among the plans whose `when` the beliefs meet, draw one by weight; do its actions;
//! change the beliefs as it says; until a plan ends it, none applies, or the test is long enough
//! ```
//!
//! An agent without beliefs but one ("where it is") is a Markov chain. Waiting for a signal is an
//! action, so that the agent reacts to the system; what it does after a signal that never comes,
//! an abstract test cannot say. Source: A. S. Rao and M. P. Georgeff, "BDI agents: from theory to
//! practice" (1995); D. Araiza-Illan, A. Pipe and K. Eder, "Intelligent agent-based stimulation
//! for testing robotic software in human-robot interactions" (2016); for usage models,
//! J. A. Whittaker and M. G. Thomason (1994). Deviation: plans are chosen at random, by weight.
//! Cost: O(steps plans). Guarantee: tests come with the probability that the agent gives them.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stimulus::{AbstractTest, Action, Setting};

use crate::error::CampaignError;
use crate::random::Random;

/// An agent as data.
///
/// ```
/// use campaign::{Agent, Random};
/// let agent = Agent::from_toml(r#"
///     name = "an attentive person"
///     longest = 10
///     beliefs = { phase = "idle", attentive = true }
///
///     [[plan]]
///     name = "ask for the object"
///     when = { phase = "idle" }
///     actions = [{ send_signal = "activate" }, { receive_signal = "announcement" }]
///     believe = { phase = "offered" }
///
///     [[plan]]
///     name = "be distracted"
///     when = { phase = "offered", attentive = true }
///     weight = 0.1
///     actions = [{ set_param = { gaze = false } }]
///     believe = { attentive = false }
///
///     [[plan]]
///     name = "take it"
///     when = { phase = "offered" }
///     actions = [{ send_signal = "ready", after_secs = { uniform = [1.5, 2.5] } }]
///     ends = true
///     "#)?;
/// let test = agent.generate(&mut Random::new(2, "agent"))?;
/// assert!(test.to_string().starts_with("send activate; receive announcement"));
/// assert!(test.to_string().ends_with("send ready"));
/// # Ok::<(), campaign::CampaignError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Agent {
    /// What its tests are called.
    pub name: String,
    /// After so many actions a test ends (with the plan that reaches it).
    pub longest: usize,
    /// What it believes at first; plans may name no other beliefs.
    #[serde(default)]
    pub beliefs: BTreeMap<String, Setting>,
    /// What it can do.
    #[serde(rename = "plan")]
    pub plans: Vec<Plan>,
}

/// Something that an agent does as a whole.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// What it is called.
    pub name: String,
    /// It applies while these beliefs are held.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub when: BTreeMap<String, Setting>,
    /// How likely it is, relative to others that apply.
    #[serde(default = "one")]
    pub weight: f64,
    /// What is done, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub actions: Vec<Action>,
    /// What is believed afterwards.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub believe: BTreeMap<String, Setting>,
    /// Whether the test ends with it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub ends: bool,
}

fn one() -> f64 {
    1.0
}

impl Agent {
    /// Reads an agent.
    ///
    /// # Errors
    /// [`CampaignError::Text`] with line and column, or what [`check`](Self::check) finds.
    pub fn from_toml(text: &str) -> Result<Self, CampaignError> {
        let agent: Self =
            toml::from_str(text).map_err(|error| CampaignError::Text(error.to_string()))?;
        agent.check()?;
        Ok(agent)
    }

    /// Checks weights, beliefs, and that there is a plan to begin with.
    ///
    /// # Errors
    /// [`CampaignError::Unknown`] for a belief that the agent does not begin with,
    /// [`CampaignError::Setting`] naming the plan for a weight that is none.
    pub fn check(&self) -> Result<(), CampaignError> {
        for plan in &self.plans {
            if !plan.weight.is_finite() || plan.weight < 0.0 {
                let problem = "its weight must be a number from 0";
                return Err(CampaignError::setting(&plan.name, problem));
            }
            let mut named = plan.when.keys().chain(plan.believe.keys());
            if let Some(name) = named.find(|name| !self.beliefs.contains_key(*name)) {
                return Err(CampaignError::Unknown {
                    kind: "belief",
                    name: format!("{name} (of plan {})", plan.name),
                });
            }
        }
        let begins = self.plans.iter().any(|plan| plan.applies(&self.beliefs));
        if begins && self.longest > 0 {
            return Ok(());
        }
        let problem = "no plan applies to its first beliefs, or `longest` is 0";
        Err(CampaignError::setting(&self.name, problem))
    }

    /// What the agent does this time.
    ///
    /// # Errors
    /// [`CampaignError::Setting`] if its plans go round without ever doing anything.
    pub fn generate(&self, random: &mut Random) -> Result<AbstractTest, CampaignError> {
        let mut beliefs = self.beliefs.clone();
        let mut test = AbstractTest::new(self.name.clone(), Vec::new());
        let mut idle = 0;
        while test.actions.len() < self.longest {
            let applies = |plan: &Plan| f64::from(u8::from(plan.applies(&beliefs))) * plan.weight;
            let weights: Vec<f64> = self.plans.iter().map(applies).collect();
            let Some(plan) = random
                .weighted(&weights)
                .and_then(|index| self.plans.get(index))
            else {
                break;
            };
            test.actions.extend_from_slice(&plan.actions);
            beliefs.extend(plan.believe.clone());
            idle = if plan.actions.is_empty() { idle + 1 } else { 0 };
            if idle > 10_000 {
                let problem = "it followed 10000 plans in a row that do nothing";
                return Err(CampaignError::setting(&self.name, problem));
            }
            if plan.ends {
                break;
            }
        }
        Ok(test)
    }
}

impl Plan {
    fn applies(&self, beliefs: &BTreeMap<String, Setting>) -> bool {
        self.weight > 0.0
            && self
                .when
                .iter()
                .all(|(name, value)| beliefs.get(name) == Some(value))
    }
}
