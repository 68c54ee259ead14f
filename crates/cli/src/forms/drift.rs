//! Drift: forms of one requirement whose texts no longer say the same.
//!
//! What the requirement declares is taken from its sentence and its
//! parameters. In each form that was written by hand, found are
//! * a limit that is none of the declared ones of its dimension,
//! * coordinates compared one by one (a box) where the requirement compares a
//!   distance (a ball),
//! * other signals than the requirement's, for a quantity of the same
//!   dimension,
//! * another clock,
//! * an earlier instant than the one that the requirement speaks of.
//!
//! Not found is what only shows in use, such as another signal of the same
//! name; [`super::differences`] finds that on recordings.

use super::limits::{Compared, Limit, of_judging, of_property, of_sentence};
use crate::study::{JudgingForm, Rule, Study, SubjectForm};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use temporal::formula::Formula;
use trace::Measure;

/// Relative difference below which two limits are the same number, written in
/// other units.
const SAME: f64 = 1e-9;

/// One way in which a form is not what its requirement declares.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Drift {
    /// The requirement.
    pub requirement: String,
    /// The form: `property`, `monitor`, or the name of a reading.
    pub form: String,
    /// Of which kind it is.
    pub kind: DriftKind,
    /// What the form has.
    pub found: String,
    /// What the requirement declares.
    pub declared: String,
}

/// Kinds of drift.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DriftKind {
    /// A limit of another size.
    Limit,
    /// A box where a distance is required, or the like.
    Shape,
    /// Another signal.
    Signal,
    /// Another clock.
    Clock,
    /// Another instant.
    Instant,
}

impl DriftKind {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Limit => "another limit",
            Self::Shape => "another shape",
            Self::Signal => "another signal",
            Self::Clock => "another clock",
            Self::Instant => "another instant",
        }
    }
}

/// All drift of a study's requirements.
pub fn of_study(study: &Study) -> Vec<Drift> {
    let own = study
        .requirements
        .iter()
        .filter(|r| r.same_quantity_as.is_none());
    let forms = own.filter_map(|requirement| study.forms.by_id(&requirement.id));
    forms.flat_map(|form| of_requirement(study, form)).collect()
}

fn of_requirement(study: &Study, form: &SubjectForm) -> Vec<Drift> {
    let declared = Declared::of(study, form);
    if declared.limits.is_empty() && form.sentence.is_none() {
        return Vec::new();
    }
    let mut finder = Finder {
        requirement: form.subject.id(),
        declared,
        found: Vec::new(),
    };
    if let Some(property) = form.property.as_ref().filter(|p| !p.from_sentence) {
        finder.limits("property", &of_property(study, &property.text));
    }
    let main = form.monitor.iter().map(|monitor| ("monitor", monitor));
    let readings = form.readings.iter().map(|r| (r.name.as_str(), &r.monitor));
    for (name, judging) in main.chain(readings).filter(|(_, j)| !j.from_sentence) {
        finder.judging(study, name, judging);
    }
    finder.found
}

/// What a requirement declares.
struct Declared {
    limits: Vec<Limit>,
    clock: Option<String>,
}

impl Declared {
    fn of(study: &Study, form: &SubjectForm) -> Self {
        let sentence = form.sentence.as_ref();
        let mut limits = sentence.map_or_else(Vec::new, |s| of_sentence(study, s));
        for name in &form.parameters {
            let known = limits.iter().any(|l| l.parameter.as_ref() == Some(name));
            if let (false, Some(value)) = (known, study.parameters.values.get(name)) {
                limits.push(Limit {
                    text: name.clone(),
                    si_value: value.si_value(),
                    dimension: value.dimension(),
                    parameter: Some(name.clone()),
                    compared: None,
                    proposition: None,
                });
            }
        }
        let monitor = sentence.and_then(|s| s.monitor.as_ref().ok());
        Self {
            limits,
            clock: monitor.and_then(|m| m.clock.clone()),
        }
    }

    /// What it declares of a dimension, in words.
    fn words(&self, limits: &[&Limit], study_words: impl Fn(&Limit) -> String) -> String {
        let words: BTreeSet<String> = limits.iter().map(|limit| study_words(limit)).collect();
        words.into_iter().collect::<Vec<_>>().join(", ")
    }
}

struct Finder<'a> {
    requirement: &'a str,
    declared: Declared,
    found: Vec<Drift>,
}

impl Finder<'_> {
    fn add(&mut self, form: &str, kind: DriftKind, found: String, declared: String) {
        let drift = Drift {
            requirement: self.requirement.to_owned(),
            form: form.to_owned(),
            kind,
            found,
            declared,
        };
        if !self.found.contains(&drift) {
            self.found.push(drift);
        }
    }

    fn judging(&mut self, study: &Study, name: &str, judging: &JudgingForm) {
        let limits = of_judging(study, judging);
        self.limits(name, &limits);
        self.shapes(name, &limits);
        if judging.clock != self.declared.clock {
            let words = |clock: &Option<String>| match clock {
                Some(clock) => format!("the time of `{clock}`"),
                None => "the recording's time".to_owned(),
            };
            let declared = words(&self.declared.clock);
            self.add(name, DriftKind::Clock, words(&judging.clock), declared);
        }
        if let Rule::Formula(rule) = &judging.rule
            && let Some(past) = past_of(&rule.parsed.formula)
        {
            let text = past.display(&rule.parsed.atoms).to_string();
            let declared = "the instant at which it applies".to_owned();
            self.add(name, DriftKind::Instant, format!("`{text}`"), declared);
        }
    }

    fn limits(&mut self, form: &str, limits: &[Limit]) {
        for limit in limits {
            let same_dimension: Vec<&Limit> = self
                .declared
                .limits
                .iter()
                .filter(|other| other.dimension == limit.dimension)
                .collect();
            let known = same_dimension
                .iter()
                .any(|other| is_same(other.si_value, limit.si_value));
            if known || same_dimension.is_empty() {
                continue;
            }
            let declared = self.declared.words(&same_dimension, in_words);
            self.add(form, DriftKind::Limit, in_words(limit), declared);
        }
    }

    fn shapes(&mut self, form: &str, limits: &[Limit]) {
        // Those with the same counterpart are one drift: a box has three axes.
        let mut groups: Vec<(DriftKind, String, Vec<String>)> = Vec::new();
        for limit in limits {
            let Some((kind, found, declared)) = self.shape(limit) else {
                continue;
            };
            match groups
                .iter_mut()
                .find(|(k, d, _)| *k == kind && *d == declared)
            {
                Some((.., all)) if !all.contains(&found) => all.push(found),
                Some(_) => {}
                None => groups.push((kind, declared, vec![found])),
            }
        }
        for (kind, declared, found) in groups {
            self.add(form, kind, found.join(", "), declared);
        }
    }

    /// What a limit compares, if the requirement compares something else of
    /// that dimension.
    fn shape(&self, limit: &Limit) -> Option<(DriftKind, String, String)> {
        let found = limit.compared.as_ref()?;
        let required: Vec<&Compared> = self
            .declared
            .limits
            .iter()
            .filter(|other| other.dimension == limit.dimension)
            .filter_map(|other| other.compared.as_ref())
            .collect();
        if required.is_empty() || required.iter().any(|other| agree(other, found)) {
            return None;
        }
        let kind = if required.iter().any(|other| same_signals(other, found)) {
            DriftKind::Shape
        } else {
            DriftKind::Signal
        };
        let declared: BTreeSet<String> = required
            .iter()
            .map(|required| format!("`{}`", required.quantity))
            .collect();
        let declared: Vec<String> = declared.into_iter().collect();
        Some((kind, format!("`{}`", found.quantity), declared.join(", ")))
    }
}

fn agree(required: &Compared, found: &Compared) -> bool {
    required.measure == found.measure && required.signals == found.signals
        || is_distance_of(required, found)
}

/// Distances are the same in both directions.
fn is_distance_of(required: &Compared, found: &Compared) -> bool {
    match (&required.measure, &found.measure) {
        (
            Measure::Distance {
                first,
                second,
                axes,
            },
            Measure::Distance {
                first: other_first,
                second: other_second,
                axes: other_axes,
            },
        ) => {
            axes.len() == other_axes.len()
                && BTreeSet::from([first, second]) == BTreeSet::from([other_first, other_second])
        }
        _ => false,
    }
}

/// Whether what is found reads some of what is required, and nothing else.
fn same_signals(required: &Compared, found: &Compared) -> bool {
    found.signals.iter().all(|s| required.signals.contains(s))
}

fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * one.abs().max(other.abs())
}

/// A limit for people: `5 s`, `near_distance (0.1 m)`, `released: 2 s`.
fn in_words(limit: &Limit) -> String {
    let unit = limit.dimension.si_unit();
    let value = format!("{} {unit}", rounded(limit.si_value));
    let same = limit.text == value;
    let with_value = match (&limit.parameter, same) {
        (Some(name), _) => format!("{name} = {value}"),
        (None, true) => value,
        (None, false) => format!("{} = {value}", limit.text),
    };
    match (&limit.proposition, &limit.parameter) {
        (Some(name), None) => format!("{with_value} in `{name}`"),
        _ => with_value,
    }
}

/// Without the digits that a conversion of units leaves behind.
fn rounded(value: f64) -> f64 {
    format!("{value:.12e}").parse().unwrap_or(value)
}

/// The first part of a formula that speaks of the past.
fn past_of(formula: &Formula) -> Option<&Formula> {
    match formula {
        Formula::Previous(_)
        | Formula::Once(..)
        | Formula::Historically(..)
        | Formula::Since(..) => Some(formula),
        _ => formula.operands().into_iter().find_map(past_of),
    }
}
