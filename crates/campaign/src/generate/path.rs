//! Tests from paths of a formal model: what its modules do becomes what is done to the system.
//!
//! A mapping says which steps of the model are actions of a test. Steps that no rule of the
//! mapping matches are the system's own, or time; they are left out and counted. Source:
//! D. Araiza-Illan et al., "Coverage-driven verification" (2015), section on model-based test
//! generation. Cost: O(steps rules). Guarantee: the same path and mapping give the same test.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stimulus::{AbstractTest, Action, Distribution, Setting, Verb};

use crate::error::CampaignError;

/// One step of a path.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PathStep {
    /// The module whose command was taken; several, where they synchronise.
    pub modules: Vec<String>,
    /// The label of the command, if it has one.
    pub action: Option<String>,
    /// Variables that changed, with their new values.
    pub changes: BTreeMap<String, Setting>,
}

/// Which steps of a model are which actions.
///
/// ```
/// use campaign::{PathMapping, PathStep};
/// let mapping = PathMapping::from_toml(r#"
///     [[step]]
///     action = "activate"
///     send_signal = "activate"
///     after_secs = { uniform = [0.5, 6.0] }
///
///     [[step]]
///     module = "human"
///     changes = { gaze = 1 }
///     set_param = { gaze = true }
///     "#)?;
/// let steps = [
///     PathStep { action: Some("activate".into()), ..PathStep::default() },
///     PathStep { modules: vec!["robot".into()], ..PathStep::default() },
///     PathStep {
///         modules: vec!["human".into()],
///         changes: [("gaze".to_owned(), 1.0.into())].into(),
///         ..PathStep::default()
///     },
/// ];
/// let made = mapping.test("to the goal", &steps);
/// assert_eq!(made.test.to_string(), "send activate; set gaze=true");
/// assert_eq!(made.unmapped, [1]);
/// # Ok::<(), campaign::CampaignError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathMapping {
    /// The rules; all that match a step act, in this order.
    #[serde(rename = "step")]
    pub rules: Vec<StepRule>,
}

/// A rule: which steps are meant (all that is given has to fit), and what they become.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepRule {
    /// The step's modules contain this one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub module: Option<String>,
    /// The step has this label.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub action: Option<String>,
    /// The step changes these variables to these values.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub changes: BTreeMap<String, Setting>,
    /// It becomes the sending of this signal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub send_signal: Option<String>,
    /// It becomes the waiting for this signal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub receive_signal: Option<String>,
    /// It becomes the setting of these parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set_param: Option<BTreeMap<String, Setting>>,
    /// The delay before it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after_secs: Option<Distribution>,
}

/// A test made from a path.
#[derive(Debug, Clone, PartialEq)]
pub struct FromPath {
    /// The test.
    pub test: AbstractTest,
    /// Places (from 0) of the steps that no rule matched.
    pub unmapped: Vec<usize>,
}

impl PathMapping {
    /// Reads `[[step]]` tables.
    ///
    /// # Errors
    /// [`CampaignError::Text`] with line and column, or what [`check`](Self::check) finds.
    pub fn from_toml(text: &str) -> Result<Self, CampaignError> {
        let mapping: Self =
            toml::from_str(text).map_err(|error| CampaignError::Text(error.to_string()))?;
        mapping.check()?;
        Ok(mapping)
    }

    /// Checks that each rule says which steps it means, and what they become.
    ///
    /// # Errors
    /// [`CampaignError::Setting`] with the rule's place.
    pub fn check(&self) -> Result<(), CampaignError> {
        for (index, rule) in self.rules.iter().enumerate() {
            if let Some(problem) = rule.problem() {
                return Err(CampaignError::setting(&format!("step {index}"), problem));
            }
        }
        Ok(())
    }

    /// The test of a path. Values that are set in one step are one action.
    #[must_use]
    pub fn test(&self, name: &str, steps: &[PathStep]) -> FromPath {
        let mut test = AbstractTest::new(name, Vec::new());
        let mut unmapped = Vec::new();
        for (index, step) in steps.iter().enumerate() {
            let before = test.actions.len();
            let mut matched = false;
            for rule in self.rules.iter().filter(|rule| rule.matches(step)) {
                matched = true;
                append(&mut test.actions, before, rule);
            }
            if !matched {
                unmapped.push(index);
            }
        }
        FromPath { test, unmapped }
    }
}

/// Appends a rule's action, or joins it with the `set` action that the same step ends with.
fn append(actions: &mut Vec<Action>, step_begin: usize, rule: &StepRule) {
    let of_this_step = actions.len() > step_begin;
    if let (true, Some(more), Some(last)) = (of_this_step, &rule.set_param, actions.last_mut())
        && rule.after_secs.is_none()
        && let Verb::Set(values) = &mut last.verb
    {
        values.extend(more.clone());
        return;
    }
    if let Some(verb) = rule.verb() {
        let action = Action::new(verb);
        actions.push(match &rule.after_secs {
            Some(delay) => action.after(delay.clone()),
            None => action,
        });
    }
}

impl StepRule {
    fn problem(&self) -> Option<&'static str> {
        let verbs = [
            self.send_signal.is_some(),
            self.receive_signal.is_some(),
            self.set_param.is_some(),
        ];
        if verbs.iter().filter(|given| **given).count() != 1 {
            return Some("give exactly one of send_signal, receive_signal and set_param");
        }
        if self.set_param.as_ref().is_some_and(BTreeMap::is_empty) {
            return Some("set_param names no parameter");
        }
        if self
            .after_secs
            .as_ref()
            .is_some_and(|delay| delay.support()[0] < 0.0)
        {
            return Some("after_secs can be negative; a delay starts at 0");
        }
        let says_which = self.module.is_some() || self.action.is_some() || !self.changes.is_empty();
        (!says_which).then_some("say which steps are meant: module, action or changes")
    }

    fn matches(&self, step: &PathStep) -> bool {
        let changed = |(name, value): (&String, &Setting)| step.changes.get(name) == Some(value);
        self.module
            .as_ref()
            .is_none_or(|module| step.modules.contains(module))
            && (self.action.is_none() || self.action == step.action)
            && self.changes.iter().all(changed)
    }

    fn verb(&self) -> Option<Verb> {
        let send = self.send_signal.clone().map(Verb::Send);
        let receive = self.receive_signal.clone().map(Verb::Receive);
        send.or(receive)
            .or_else(|| self.set_param.clone().map(Verb::Set))
    }
}
