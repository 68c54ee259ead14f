//! Parameters with their distributions: the space that concrete stimuli are points of.
//!
//! A point of the unit cube `(0, 1)^n` becomes a point of the space by each parameter's quantile
//! function (the inverse transform; J. von Neumann, 1947, and Devroye, "Non-uniform random variate
//! generation", 1986, section II.2), so that a design that is even in the cube follows the
//! declared distributions, and every algorithm needs to know only the cube.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::abstract_test::{AbstractTest, Verb};
use crate::distribution::{DETAILS, Distribution, KINDS, Options, Table};
use crate::error::StimulusError;
use crate::key::{segments, similar};
use crate::setting::{Setting, Settings};
use crate::stimulus::Stimulus;

/// The parameters of a campaign, and which combinations of them are allowed.
///
/// ```
/// let space = stimulus::Space::from_toml(r#"
///     [[parameter]]
///     name = "pull"
///     sets = ["human.pull_forward_newtons"]
///     unit = "N"
///     uniform = [1.0, 15.0]
///     nominal = 8.0
///
///     [[parameter]]
///     name = "surface"
///     sets = ["hand.surface"]
///     choice = ["clean", "dusty"]
///     "#)?;
/// let point = space.at(&[0.5, 0.9]);
/// assert_eq!(point.0, [8.0, 1.0]);
/// let settings = space.settings(&point)?;
/// assert_eq!(settings["hand.surface"], stimulus::Setting::from("dusty"));
/// # Ok::<(), stimulus::StimulusError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Space {
    /// The parameters: one coordinate each, in this order.
    #[serde(rename = "parameter", default)]
    pub parameters: Vec<Parameter>,
    /// Which points are allowed: all of these hold.
    #[serde(rename = "constraint", default, skip_serializing_if = "Vec::is_empty")]
    pub constraints: Vec<Constraint>,
}

/// One quantity that varies between episodes.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(try_from = "ParameterText", into = "ParameterText")]
pub struct Parameter {
    /// What it is called; unique in its space.
    pub name: String,
    /// The dotted keys of the bench's data that it sets, such as
    /// `"parameters.human.pull_forward_newtons"`, all to the same value. Keys that begin with
    /// `test.actions.` set a delay or a value of the abstract test.
    pub sets: Vec<String>,
    /// The unit of its values, for people and reports.
    pub unit: Option<String>,
    /// How it varies.
    pub distribution: Distribution,
    /// The value that needs no explanation: shrinking returns to it. The median if absent.
    pub nominal: Option<f64>,
}

/// A linear constraint between parameters: `at_least <= sum of factor * value <= at_most`.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Constraint {
    /// A factor for each parameter that takes part, by name.
    pub sum: BTreeMap<String, f64>,
    /// The smallest sum that is allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// The largest sum that is allowed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
}

/// A value for each parameter of a space, in its order: numbers as they are, yes as 1 and no as
/// 0, a label as its place in the list, from 0.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(transparent)]
pub struct Point(pub Vec<f64>);

impl Space {
    /// Reads `[[parameter]]` and `[[constraint]]` tables.
    ///
    /// # Errors
    /// [`StimulusError::Text`] with line and column, or what [`check`](Self::check) finds.
    pub fn from_toml(text: &str) -> Result<Self, StimulusError> {
        let space: Self =
            toml::from_str(text).map_err(|error| StimulusError::Text(error.to_string()))?;
        space.check()?;
        Ok(space)
    }

    /// Checks names, keys, distributions, nominal values and constraints.
    ///
    /// # Errors
    /// [`StimulusError::Parameter`] naming the first one that is wrong.
    pub fn check(&self) -> Result<(), StimulusError> {
        let mut names = BTreeSet::new();
        let mut keys = BTreeMap::new();
        for parameter in &self.parameters {
            parameter.check()?;
            if !names.insert(parameter.name.as_str()) {
                let problem = "the name is given to two parameters";
                return Err(StimulusError::parameter(&parameter.name, problem));
            }
            for key in &parameter.sets {
                if let Some(other) = keys.insert(key.as_str(), &parameter.name) {
                    let problem = format!("it sets `{key}`, which `{other}` sets already");
                    return Err(StimulusError::parameter(&parameter.name, problem));
                }
            }
        }
        self.constraints
            .iter()
            .try_for_each(|constraint| constraint.check(&names))
    }

    /// How many coordinates a point has.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.parameters.len()
    }

    /// The point at these coordinates of the unit cube; a coordinate that is missing counts as
    /// 1/2.
    #[must_use]
    pub fn at(&self, unit_cube: &[f64]) -> Point {
        let coordinates = unit_cube.iter().copied().chain(std::iter::repeat(0.5));
        let values = self.parameters.iter().zip(coordinates);
        Point(values.map(|(p, u)| p.distribution.quantile(u)).collect())
    }

    /// Coordinates of the unit cube that [`at`](Self::at) leads back to the point.
    #[must_use]
    pub fn unit_of(&self, point: &Point) -> Vec<f64> {
        let values = self.parameters.iter().zip(&point.0);
        values
            .map(|(p, value)| p.distribution.unit_of(*value))
            .collect()
    }

    /// The nominal point: each parameter's nominal value, or its median.
    #[must_use]
    pub fn nominal(&self) -> Point {
        let nominal = |p: &Parameter| p.nominal.unwrap_or_else(|| p.distribution.quantile(0.5));
        Point(self.parameters.iter().map(nominal).collect())
    }

    /// Whether the point has the right length, lies in every support, and meets the constraints.
    #[must_use]
    pub fn allows(&self, point: &Point) -> bool {
        point.0.len() == self.parameters.len()
            && (self.parameters.iter().zip(&point.0)).all(|(p, v)| p.distribution.contains(*v))
            && self.meets_constraints(point)
    }

    /// Whether all constraints hold at the point (to a billionth of their terms' size).
    #[must_use]
    pub fn meets_constraints(&self, point: &Point) -> bool {
        let value = |name: &str| {
            let index = self.parameters.iter().position(|p| p.name == name)?;
            point.0.get(index).copied()
        };
        self.constraints
            .iter()
            .all(|constraint| constraint.holds(&value))
    }

    /// The index of the parameter with this name.
    #[must_use]
    pub fn index_of(&self, name: &str) -> Option<usize> {
        self.parameters.iter().position(|p| p.name == name)
    }

    /// What the point sets, by dotted key.
    ///
    /// # Errors
    /// [`StimulusError::Point`] if it has another number of coordinates, or one that is no value
    /// of its parameter.
    pub fn settings(&self, point: &Point) -> Result<Settings, StimulusError> {
        if point.0.len() != self.parameters.len() {
            return Err(StimulusError::Point(format!(
                "it has {} coordinates for {} parameters",
                point.0.len(),
                self.parameters.len()
            )));
        }
        let mut settings = Settings::new();
        for (parameter, value) in self.parameters.iter().zip(&point.0) {
            let setting = parameter.setting(*value)?;
            for key in &parameter.sets {
                settings.insert(key.clone(), setting.clone());
            }
        }
        Ok(settings)
    }

    /// The point that settings stand for; a parameter that they do not set has its nominal value.
    /// `None` if a setting is no value of its parameter, or keys of one parameter disagree.
    #[must_use]
    pub fn point_of(&self, settings: &Settings) -> Option<Point> {
        let nominal = self.nominal();
        let mut values = Vec::with_capacity(self.parameters.len());
        for (parameter, nominal) in self.parameters.iter().zip(nominal.0) {
            let mut given = parameter.sets.iter().filter_map(|key| settings.get(key));
            let first = given.next();
            if given.any(|other| Some(other) != first) {
                return None;
            }
            values.push(match first {
                Some(setting) => parameter.value(setting)?,
                None => nominal,
            });
        }
        Some(Point(values))
    }

    /// The test made concrete: keys that begin with `test.actions.` change the test, all others
    /// become settings of the bench.
    ///
    /// # Errors
    /// Those of [`settings`](Self::settings), and [`StimulusError::UnknownKey`] or
    /// [`StimulusError::Unsettable`] for a key that the test does not have.
    pub fn stimulus(&self, test: &AbstractTest, point: &Point) -> Result<Stimulus, StimulusError> {
        let mut stimulus = Stimulus {
            test: test.clone(),
            settings: Settings::new(),
        };
        for (key, value) in self.settings(point)? {
            if key.starts_with("test.") {
                set_in_test(&mut stimulus.test, &key, value)?;
            } else {
                stimulus.settings.insert(key, value);
            }
        }
        Ok(stimulus)
    }

    /// The space with a parameter for each random delay of the test (after its own parameters,
    /// in the order of the actions), unless one of its own sets that delay.
    #[must_use]
    pub fn with_delays_of(&self, test: &AbstractTest) -> Self {
        let mut space = self.clone();
        for (index, action) in test.actions.iter().enumerate() {
            let key = format!("test.actions.{index}.after_secs");
            let random = action.after_secs.cardinality() != Some(1);
            if random && !self.parameters.iter().any(|p| p.sets.contains(&key)) {
                space.parameters.push(Parameter {
                    name: format!("delay before action {index} ({})", action.verb),
                    sets: vec![key],
                    unit: Some("s".to_owned()),
                    distribution: action.after_secs.clone(),
                    nominal: None,
                });
            }
        }
        space
    }
}

/// Sets a delay or a parameter's value in the test.
fn set_in_test(test: &mut AbstractTest, key: &str, value: Setting) -> Result<(), StimulusError> {
    let unknown = |known: &str| StimulusError::UnknownKey {
        key: key.to_owned(),
        known: known.to_owned(),
        similar: None,
    };
    let path = segments(key).map_err(|problem| StimulusError::unsettable(key, problem))?;
    let path: Vec<&str> = path.iter().map(String::as_str).collect();
    let ["test", "actions", index, rest @ ..] = path.as_slice() else {
        return Err(unknown("test.actions"));
    };
    let index: usize = index.parse().map_err(|_| unknown("test.actions"))?;
    let action = test
        .actions
        .get_mut(index)
        .ok_or_else(|| unknown("test.actions"))?;
    match (rest, &mut action.verb, value) {
        (["after_secs"], _, Setting::Number(secs)) if secs >= 0.0 => {
            action.after_secs = Distribution::Constant(secs);
        }
        (["after_secs"], ..) => {
            return Err(StimulusError::unsettable(key, "a delay is a number from 0"));
        }
        (["set_param", name], Verb::Set(values), value) => {
            let known = values.get_mut(*name);
            *known.ok_or_else(|| unknown(&format!("test.actions.{index}.set_param")))? = value;
        }
        _ => return Err(unknown(&format!("test.actions.{index}"))),
    }
    Ok(())
}

impl Parameter {
    fn check(&self) -> Result<(), StimulusError> {
        let wrong = |problem: String| Err(StimulusError::parameter(&self.name, problem));
        if self.name.is_empty() {
            return wrong("it has no name".to_owned());
        }
        if self.sets.is_empty() {
            return wrong("`sets` names no key: give at least one".to_owned());
        }
        for key in &self.sets {
            if let Err(problem) = segments(key) {
                return wrong(format!("`{key}` is not a valid dotted key: {problem}"));
            }
        }
        if let Err(StimulusError::Distribution(problem)) = self.distribution.check() {
            return wrong(problem);
        }
        match self.nominal {
            Some(value) if !self.distribution.contains(value) => {
                wrong(format!("its nominal value {value} cannot come"))
            }
            _ => Ok(()),
        }
    }

    /// The value as it is set.
    ///
    /// # Errors
    /// [`StimulusError::Point`] for a number that is no value of the parameter's kind.
    pub fn setting(&self, value: f64) -> Result<Setting, StimulusError> {
        let wrong = || {
            let problem = format!("{value} is not a valid value of `{}`", self.name);
            Err(StimulusError::Point(problem))
        };
        match &self.distribution {
            _ if !value.is_finite() => wrong(),
            Distribution::Boolean { .. } if value == 0.0 || value == 1.0 => {
                Ok(Setting::Bool(value == 1.0))
            }
            Distribution::Choice {
                options: Options::Labels(labels),
                ..
            } if value >= 0.0 && value.fract() == 0.0 => match labels.get(value as usize) {
                Some(label) => Ok(Setting::Text(label.clone())),
                None => wrong(),
            },
            Distribution::Boolean { .. }
            | Distribution::Choice {
                options: Options::Labels(_),
                ..
            } => wrong(),
            Distribution::Integer { .. } if value.fract() != 0.0 => wrong(),
            _ => Ok(Setting::Number(value + 0.0)),
        }
    }

    /// The number of a setting: the inverse of [`setting`](Self::setting). `None` if it is of
    /// another kind.
    #[must_use]
    pub fn value(&self, setting: &Setting) -> Option<f64> {
        match (setting, &self.distribution) {
            (Setting::Bool(yes), Distribution::Boolean { .. }) => Some(f64::from(u8::from(*yes))),
            (
                Setting::Text(text),
                Distribution::Choice {
                    options: Options::Labels(labels),
                    ..
                },
            ) => Some(labels.iter().position(|label| label == text)? as f64),
            (
                _,
                Distribution::Boolean { .. }
                | Distribution::Choice {
                    options: Options::Labels(_),
                    ..
                },
            ) => None,
            (Setting::Number(number), _) => Some(*number),
            _ => None,
        }
    }

    /// The value as people write it: a label, yes or no, or the number with its unit.
    #[must_use]
    pub fn shown(&self, value: f64) -> String {
        let number = match self.setting(value) {
            Ok(Setting::Text(label)) => return label,
            Ok(Setting::Bool(yes)) => return yes.to_string(),
            _ => value.to_string(),
        };
        match &self.unit {
            Some(unit) => format!("{number} {unit}"),
            None => number,
        }
    }
}

impl Constraint {
    fn check(&self, names: &BTreeSet<&str>) -> Result<(), StimulusError> {
        for (name, factor) in &self.sum {
            if !names.contains(name.as_str()) {
                let problem = "a constraint names it, but the space has no such parameter";
                return Err(StimulusError::parameter(name, problem));
            }
            if !factor.is_finite() {
                let problem = "its factor in a constraint must be finite";
                return Err(StimulusError::parameter(name, problem));
            }
        }
        let name = self.sum.keys().next().map_or("", String::as_str);
        let low = self.at_least.unwrap_or(f64::NEG_INFINITY);
        let high = self.at_most.unwrap_or(f64::INFINITY);
        if self.sum.is_empty() || (self.at_least.is_none() && self.at_most.is_none()) {
            let problem = "a constraint needs a sum, and at_least or at_most";
            return Err(StimulusError::parameter(name, problem));
        }
        if low <= high {
            return Ok(());
        }
        let problem = "a constraint's at_least lies above its at_most";
        Err(StimulusError::parameter(name, problem))
    }

    fn holds(&self, value: &dyn Fn(&str) -> Option<f64>) -> bool {
        let mut sum = 0.0;
        let mut size = 0.0;
        for (name, factor) in &self.sum {
            let Some(value) = value(name) else {
                return false;
            };
            sum += factor * value;
            size += (factor * value).abs();
        }
        let slack = 1e-9 * size;
        self.at_least.is_none_or(|low| sum >= low - slack)
            && self.at_most.is_none_or(|high| sum <= high + slack)
    }
}

/// A parameter as it is written: the distribution's keys stand beside its own.
#[derive(Clone, Serialize, JsonSchema, Deserialize)]
struct ParameterText {
    /// What it is called; unique in its file.
    name: String,
    /// The dotted keys of the data that it sets, all to the same value; those that begin with `test.actions.` set a delay or a value of the test.
    sets: Vec<String>,
    /// Its unit, for the report.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
    #[serde(flatten)]
    distribution: Table,
    /// The value that needs no explanation; shrinking goes towards it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    nominal: Option<f64>,
    /// What no field took: keys that are unknown.
    #[serde(flatten, skip_serializing)]
    #[schemars(skip)]
    unknown: BTreeMap<String, serde::de::IgnoredAny>,
}

impl TryFrom<ParameterText> for Parameter {
    type Error = StimulusError;

    fn try_from(text: ParameterText) -> Result<Self, StimulusError> {
        if let Some(key) = text.unknown.keys().next() {
            let known = ["name", "sets", "unit", "nominal"];
            let known = known.iter().chain(&KINDS).chain(&DETAILS).copied();
            let problem = match similar(key, known) {
                Some(similar) => format!("unknown key `{key}`; did you mean `{similar}`?"),
                None => format!("unknown key `{key}`"),
            };
            return Err(StimulusError::parameter(&text.name, problem));
        }
        let distribution = match text.distribution.distribution() {
            Err(StimulusError::Distribution(problem)) => {
                return Err(StimulusError::parameter(&text.name, problem));
            }
            other => other?,
        };
        Ok(Self {
            name: text.name,
            sets: text.sets,
            unit: text.unit,
            distribution,
            nominal: text.nominal,
        })
    }
}

impl From<Parameter> for ParameterText {
    fn from(parameter: Parameter) -> Self {
        Self {
            name: parameter.name,
            sets: parameter.sets,
            unit: parameter.unit,
            distribution: Table::from(&parameter.distribution),
            nominal: parameter.nominal,
            unknown: BTreeMap::new(),
        }
    }
}
