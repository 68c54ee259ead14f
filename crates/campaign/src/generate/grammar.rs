//! Constrained random tests: alternatives with weights, and rules that every test keeps.
//!
//! A length is drawn, then one action after the other among the alternatives that the rules still
//! allow, in proportion to their weights; a test that breaks a rule at its end is drawn again.
//! Source: J. Yuan, C. Pixley and A. Aziz, "Constraint-based verification" (2006), chapter 1, for
//! constrained random generation. Cost: O(length (alternatives + rules)) a try. Guarantee: every
//! test keeps every rule; every test that can be written with the grammar within its lengths has a
//! positive probability.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stimulus::{AbstractTest, Action, Distribution, Setting, Verb};

use super::pattern::ActionPattern;
use crate::error::CampaignError;
use crate::random::Random;

/// How often a test is drawn before the rules count as impossible.
const TRIES: usize = 2000;

/// Which actions there are, and which orders of them make sense, as data.
///
/// ```
/// use campaign::{Grammar, Random};
/// let grammar = Grammar::from_toml(r#"
///     name = "handover"
///     length = [3, 6]
///     begins = ["send activate"]
///
///     [[action]]
///     send_signal = "activate"
///     most = 1
///
///     [[action]]
///     receive_signal = "announcement"
///     most = 1
///
///     [[action]]
///     send_signal = "ready"
///
///     [[action]]
///     set_param = { gaze = [true, false], hand = [true, false] }
///     after_secs = { uniform = [0.3, 1.0] }
///     weight = 2
///
///     [[rule]]
///     action = "send ready"
///     needs_before = "receive announcement"
///     "#)?;
/// let test = grammar.generate(&mut Random::new(1, "tests"))?;
/// assert!(test.to_string().starts_with("send activate"));
/// assert!((3..=6).contains(&test.actions.len()) && grammar.allows(&test));
/// # Ok::<(), campaign::CampaignError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Grammar {
    /// What its tests are called.
    pub name: String,
    /// Fewest and most actions of a test.
    pub length: [usize; 2],
    /// How every test begins.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub begins: Vec<ActionPattern>,
    /// What can be done.
    #[serde(rename = "action")]
    pub alternatives: Vec<Alternative>,
    /// What every test keeps.
    #[serde(rename = "rule", default, skip_serializing_if = "Vec::is_empty")]
    pub rules: Vec<Rule>,
}

/// One thing that can be done: exactly one of the three verbs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Alternative {
    /// Sends this signal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub send_signal: Option<String>,
    /// Waits for this signal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub receive_signal: Option<String>,
    /// Sets some of these parameters (at least one) to one of their values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub set_param: Option<BTreeMap<String, Values>>,
    /// The delay that the action gets.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after_secs: Option<Distribution>,
    /// How often it comes, relative to the others; 1 if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight: Option<f64>,
    /// How often it may be in one test.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<usize>,
}

/// The values that a parameter can be set to.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(untagged)]
pub enum Values {
    /// One of these, equally likely.
    OneOf(Vec<Setting>),
    /// A number of this distribution.
    Drawn(Distribution),
}

/// A rule for each occurrence of an action.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rule {
    /// The action that the rule is about.
    pub action: ActionPattern,
    /// This has to be somewhere before it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needs_before: Option<ActionPattern>,
    /// This has to be somewhere after it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needs_after: Option<ActionPattern>,
    /// This may be nowhere before it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub never_after: Option<ActionPattern>,
}

impl Grammar {
    /// Reads a grammar.
    ///
    /// # Errors
    /// [`CampaignError::Text`] with line and column, or what [`check`](Self::check) finds.
    pub fn from_toml(text: &str) -> Result<Self, CampaignError> {
        let grammar: Self =
            toml::from_str(text).map_err(|error| CampaignError::Text(error.to_string()))?;
        grammar.check()?;
        Ok(grammar)
    }

    /// Checks lengths, alternatives, and that rules and beginnings can be met by some alternative.
    ///
    /// # Errors
    /// [`CampaignError::Setting`] naming what is wrong, [`CampaignError::Unknown`] for an action
    /// that no alternative makes.
    pub fn check(&self) -> Result<(), CampaignError> {
        let [fewest, most] = self.length;
        if fewest > most || most == 0 || self.begins.len() > most {
            let problem = "give the fewest and the most actions, the fewest first, at least as \
                           many as the beginning has";
            return Err(CampaignError::setting("length", problem));
        }
        if self.alternatives.is_empty() {
            return Err(CampaignError::setting(
                "action",
                "give at least one [[action]]",
            ));
        }
        for (index, alternative) in self.alternatives.iter().enumerate() {
            if let Some(problem) = alternative.problem() {
                return Err(CampaignError::setting(&format!("action {index}"), problem));
            }
        }
        let rules = self.rules.iter().flat_map(|rule| {
            let named = [&rule.needs_before, &rule.needs_after, &rule.never_after];
            std::iter::once(&rule.action).chain(named.into_iter().flatten())
        });
        for pattern in self.begins.iter().chain(rules) {
            if !self.alternatives.iter().any(|a| a.can_match(pattern)) {
                return Err(CampaignError::Unknown {
                    kind: "action",
                    name: pattern.to_string(),
                });
            }
        }
        Ok(())
    }

    /// A random test.
    ///
    /// # Errors
    /// [`CampaignError::TooTight`] when 2000 tries in a row broke a rule.
    pub fn generate(&self, random: &mut Random) -> Result<AbstractTest, CampaignError> {
        self.generate_for(&[], random)
    }

    /// A random test in which each of the goals is met by some action.
    ///
    /// # Errors
    /// [`CampaignError::TooTight`] when 2000 tries in a row broke a rule or missed a goal;
    /// [`CampaignError::Unknown`] for a goal that no alternative can meet.
    pub fn generate_for(
        &self,
        goals: &[ActionPattern],
        random: &mut Random,
    ) -> Result<AbstractTest, CampaignError> {
        for goal in goals {
            if !self.alternatives.iter().any(|a| a.can_match(goal)) {
                return Err(CampaignError::Unknown {
                    kind: "action",
                    name: goal.to_string(),
                });
            }
        }
        for _ in 0..TRIES {
            let test = self.draw(goals, random);
            if self.allows(&test) && goals.iter().all(|goal| goal.is_in(&test)) {
                return Ok(test);
            }
        }
        Err(CampaignError::TooTight { tried: TRIES })
    }

    /// One test that keeps what can be kept on the way.
    fn draw(&self, goals: &[ActionPattern], random: &mut Random) -> AbstractTest {
        let [fewest, most] = self.length;
        let length = fewest + random.index(most - fewest + 1);
        let mut test = AbstractTest::new(self.name.clone(), Vec::with_capacity(length));
        while test.actions.len() < length {
            let wanted = match self.begins.get(test.actions.len()) {
                Some(beginning) => Some(beginning),
                // Every other action is meant for a goal that is not met yet.
                None if random.chance(0.5) => goals.iter().find(|goal| !goal.is_in(&test)),
                None => None,
            };
            let Some(action) = self.draw_action(&test, wanted, random) else {
                break;
            };
            test.actions.push(action);
        }
        test
    }

    /// An action that may come next; the wanted one if it may.
    fn draw_action(
        &self,
        test: &AbstractTest,
        wanted: Option<&ActionPattern>,
        random: &mut Random,
    ) -> Option<Action> {
        let mut actions: Vec<Action> = Vec::with_capacity(self.alternatives.len());
        let mut weights = Vec::with_capacity(self.alternatives.len());
        for alternative in &self.alternatives {
            let action = alternative.draw(wanted, random);
            let fits = wanted.is_none_or(|wanted| wanted.matches(&action));
            let allowed = alternative.has_room(test) && self.may_follow(test, &action);
            let weight = alternative.weight.unwrap_or(1.0);
            weights.push(if allowed && fits { weight } else { 0.0 });
            actions.push(action);
        }
        match random.weighted(&weights) {
            Some(index) => Some(actions.swap_remove(index)),
            // What is wanted cannot come yet: something else may make it possible.
            None if wanted.is_some() => self.draw_action(test, None, random),
            None => None,
        }
    }

    /// Whether the rules allow an action after the test so far.
    fn may_follow(&self, test: &AbstractTest, action: &Action) -> bool {
        let concerned = self.rules.iter().filter(|rule| rule.action.matches(action));
        concerned.into_iter().all(|rule| {
            rule.needs_before
                .as_ref()
                .is_none_or(|needed| needed.is_in(test))
                && rule
                    .never_after
                    .as_ref()
                    .is_none_or(|never| !never.is_in(test))
        })
    }

    /// Whether a test keeps length, beginning, numbers and rules; actions need not be ones that
    /// the grammar makes.
    #[must_use]
    pub fn allows(&self, test: &AbstractTest) -> bool {
        let [fewest, most] = self.length;
        let begins = self.begins.iter().zip(&test.actions);
        (fewest..=most).contains(&test.actions.len())
            && self.begins.len() <= test.actions.len()
            && begins
                .into_iter()
                .all(|(pattern, action)| pattern.matches(action))
            && self
                .alternatives
                .iter()
                .all(|a| a.is_not_too_often_in(test))
            && self.rules.iter().all(|rule| rule.holds(test))
    }
}

impl Rule {
    fn holds(&self, test: &AbstractTest) -> bool {
        let places = test.actions.iter().enumerate();
        let mut concerned = places.filter(|(_, action)| self.action.matches(action));
        concerned.all(|(place, _)| {
            let in_part = |pattern: &Option<ActionPattern>, part: &[Action]| {
                pattern
                    .as_ref()
                    .map(|p| part.iter().any(|action| p.matches(action)))
            };
            let (before, after) = (&test.actions[..place], &test.actions[place + 1..]);
            in_part(&self.needs_before, before) != Some(false)
                && in_part(&self.needs_after, after) != Some(false)
                && in_part(&self.never_after, before) != Some(true)
        })
    }
}

impl Alternative {
    fn problem(&self) -> Option<String> {
        let verbs = [
            self.send_signal.is_some(),
            self.receive_signal.is_some(),
            self.set_param.is_some(),
        ];
        if verbs.iter().filter(|given| **given).count() != 1 {
            return Some("give exactly one of send_signal, receive_signal and set_param".into());
        }
        let weight = self.weight.unwrap_or(1.0);
        if !weight.is_finite() || weight < 0.0 {
            return Some("its weight must be a number from 0".into());
        }
        if self
            .after_secs
            .as_ref()
            .is_some_and(|delay| delay.support()[0] < 0.0)
        {
            return Some("after_secs can be negative; a delay starts at 0".into());
        }
        let no_value = |values: &Values| matches!(values, Values::OneOf(list) if list.is_empty());
        match &self.set_param {
            Some(values) if values.is_empty() => Some("set_param names no parameter".into()),
            Some(values) if values.values().any(no_value) => {
                Some("a parameter of set_param has no value to take".into())
            }
            _ => None,
        }
    }

    /// Whether some action that it makes can be meant by a pattern.
    fn can_match(&self, pattern: &ActionPattern) -> bool {
        match pattern {
            ActionPattern::Send(name) => self.send_signal.as_ref() == Some(name),
            ActionPattern::Receive(name) => self.receive_signal.as_ref() == Some(name),
            ActionPattern::Set(name, value) => {
                let values = self.set_param.as_ref().and_then(|values| values.get(name));
                values.is_some_and(|values| value.as_ref().is_none_or(|v| values.can_be(v)))
            }
        }
    }

    /// Whether an action is one that it makes, whatever the values.
    fn made(&self, action: &Action) -> bool {
        match &action.verb {
            Verb::Send(signal) => self.send_signal.as_ref() == Some(signal),
            Verb::Receive(signal) => self.receive_signal.as_ref() == Some(signal),
            Verb::Set(values) => self
                .set_param
                .as_ref()
                .is_some_and(|mine| values.keys().all(|name| mine.contains_key(name))),
        }
    }

    fn count_in(&self, test: &AbstractTest) -> usize {
        test.actions
            .iter()
            .filter(|action| self.made(action))
            .count()
    }

    fn has_room(&self, test: &AbstractTest) -> bool {
        self.most.is_none_or(|most| self.count_in(test) < most)
    }

    fn is_not_too_often_in(&self, test: &AbstractTest) -> bool {
        self.most.is_none_or(|most| self.count_in(test) <= most)
    }

    /// An action of this kind; the value that is wanted if it can take it.
    pub(super) fn draw(&self, wanted: Option<&ActionPattern>, random: &mut Random) -> Action {
        let verb = match (&self.send_signal, &self.receive_signal, &self.set_param) {
            (Some(signal), ..) => Verb::Send(signal.clone()),
            (_, Some(signal), _) => Verb::Receive(signal.clone()),
            (.., Some(values)) => Verb::Set(draw_values(values, wanted, random)),
            // Refused by `problem`.
            (None, None, None) => Verb::Set(BTreeMap::new()),
        };
        let action = Action::new(verb);
        match &self.after_secs {
            Some(delay) => action.after(delay.clone()),
            None => action,
        }
    }
}

/// Each parameter in half of the cases, at least one of them.
fn draw_values(
    values: &BTreeMap<String, Values>,
    wanted: Option<&ActionPattern>,
    random: &mut Random,
) -> BTreeMap<String, Setting> {
    let certain = random.index(values.len());
    let mut drawn = BTreeMap::new();
    for (index, (name, values)) in values.iter().enumerate() {
        let value = values.draw(random);
        match wanted {
            Some(ActionPattern::Set(wanted, fixed)) if wanted == name => {
                let fixed = fixed.clone().filter(|fixed| values.can_be(fixed));
                drawn.insert(name.clone(), fixed.unwrap_or(value));
            }
            _ if random.chance(0.5) || index == certain => {
                drawn.insert(name.clone(), value);
            }
            _ => {}
        }
    }
    drawn
}

impl Values {
    pub(super) fn draw(&self, random: &mut Random) -> Setting {
        match self {
            Self::OneOf(values) => {
                let index = random.index(values.len());
                values.get(index).cloned().unwrap_or(Setting::Bool(false))
            }
            Self::Drawn(distribution) => Setting::Number(distribution.quantile(random.open_unit())),
        }
    }

    fn can_be(&self, value: &Setting) -> bool {
        match (self, value) {
            (Self::OneOf(values), value) => values.contains(value),
            (Self::Drawn(distribution), Setting::Number(number)) => distribution.contains(*number),
            _ => false,
        }
    }
}
