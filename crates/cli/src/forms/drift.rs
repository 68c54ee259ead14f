//! Drift: forms of one requirement whose texts no longer say the same.
//!
//! What the requirement declares is taken from its sentence and its
//! parameters. In each form that was written by hand, found are
//! * a limit that is none of the declared ones of its dimension, or of a
//!   dimension of which the requirement's sentence has none,
//! * a number without a unit that is compared with what the requirement
//!   limits, and that is not the limit in any unit in which that is known,
//! * coordinates compared one by one (a box) where the requirement compares a
//!   distance (a ball),
//! * other signals than the requirement's, for a quantity of the same
//!   dimension,
//! * another clock,
//! * an earlier instant than the one that the requirement speaks of.
//!
//! Clock and instant are those of the sentence's monitor or, without a
//! sentence, of the main monitor.
//!
//! Not found is what only shows in use, such as another signal of the same
//! name; [`super::differences`] finds that on recordings.

use super::limits::{Compared, Limit, of_judging, of_property, of_sentence, secs_of};
use crate::study::{JudgingForm, Rule, SentenceForm, Study, SubjectForm};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use std::mem::discriminant;
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
    /// Whether these are all, as a sentence says.
    are_all: bool,
    clock: Option<String>,
    /// The operators of the past in the form that all others are held against.
    past: Vec<Formula>,
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
                    number: value.number(),
                    dimension: value.unit().map(|unit| unit.dimension()),
                    parameter: Some(name.clone()),
                    compared: None,
                    proposition: None,
                });
            }
        }
        let monitor = match sentence {
            Some(sentence) => sentence.monitor.as_ref().ok(),
            None => form.monitor.as_ref(),
        };
        let mut past = Vec::new();
        if let Some(Rule::Formula(rule)) = monitor.map(|monitor| &monitor.rule) {
            past_parts(&rule.parsed.formula, &mut past);
        }
        Self {
            limits,
            are_all: sentence.is_some_and(|s| has_known_durations(study, s)),
            clock: monitor.and_then(|m| m.clock.clone()),
            past: past.into_iter().cloned().collect(),
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
        let mut parts = Vec::new();
        if let Rule::Formula(rule) = &judging.rule {
            past_parts(&rule.parsed.formula, &mut parts);
        }
        let is_declared = |part: &Formula| {
            let mut operators = self.declared.past.iter().map(discriminant);
            operators.any(|operator| operator == discriminant(part))
        };
        if let Rule::Formula(rule) = &judging.rule
            && let Some(past) = parts.into_iter().find(|part| !is_declared(part))
        {
            let text = past.display(&rule.parsed.atoms).to_string();
            let declared = "the instant at which it applies".to_owned();
            self.add(name, DriftKind::Instant, format!("`{text}`"), declared);
        }
    }

    fn limits(&mut self, form: &str, limits: &[Limit]) {
        for limit in limits {
            let counterparts = self.counterparts(limit);
            if counterparts.iter().any(|other| is_same_limit(other, limit)) {
                continue;
            }
            let declared = match counterparts.as_slice() {
                [] if !self.declared.are_all || limit.dimension.is_none() => continue,
                [] => "no such limit".to_owned(),
                some => self.declared.words(some, in_words),
            };
            self.add(form, DriftKind::Limit, in_words(limit), declared);
        }
    }

    /// The declared limits that a limit has to be one of: those of its
    /// dimension or, where a unit is missing, those of what it limits.
    fn counterparts(&self, limit: &Limit) -> Vec<&Limit> {
        let all = self.declared.limits.iter();
        all.filter(|other| match (other.dimension, limit.dimension) {
            (Some(one), Some(other)) => one == other,
            _ => match (&other.compared, &limit.compared) {
                (Some(one), Some(other)) => agree(one, other),
                _ => false,
            },
        })
        .collect()
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
            .filter(|other| limit.dimension.is_some() && other.dimension == limit.dimension)
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
            BTreeSet::from_iter(axes) == BTreeSet::from_iter(other_axes)
                && BTreeSet::from([first, second]) == BTreeSet::from([other_first, other_second])
        }
        _ => false,
    }
}

/// Whether what is found reads some of what is required, and nothing else.
fn same_signals(required: &Compared, found: &Compared) -> bool {
    found.signals.iter().all(|s| required.signals.contains(s))
}

/// Whether two limits are the same. A number without a unit is in that of the
/// signals, of which all that is known is the unit in which the other is
/// written, and the SI unit.
fn is_same_limit(one: &Limit, other: &Limit) -> bool {
    if one.dimension.is_some() == other.dimension.is_some() {
        return is_same(one.si_value, other.si_value);
    }
    is_same(one.number, other.number) || is_same(one.si_value, other.si_value)
}

/// Whether all durations of a sentence are known in seconds.
fn has_known_durations(study: &Study, sentence: &SentenceForm) -> bool {
    let stages = sentence.tree.stages.iter();
    let mut durations = stages.filter_map(|stage| stage.timing.duration());
    durations.all(|duration| secs_of(study, duration.amount).is_some())
}

fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * one.abs().max(other.abs())
}

/// A limit for people: `5 s`, `near_distance (0.1 m)`, `released: 2 s`.
fn in_words(limit: &Limit) -> String {
    let value = match limit.dimension {
        Some(dimension) => format!("{} {}", rounded(limit.si_value), dimension.si_unit()),
        None => format!("{} without a unit", rounded(limit.number)),
    };
    let same = limit.text == value || limit.dimension.is_none();
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

/// The parts of a formula that speak of the past.
fn past_parts<'f>(formula: &'f Formula, parts: &mut Vec<&'f Formula>) {
    if matches!(
        formula,
        Formula::Previous(_) | Formula::Once(..) | Formula::Historically(..) | Formula::Since(..)
    ) {
        parts.push(formula);
    }
    for operand in formula.operands() {
        past_parts(operand, parts);
    }
}
