//! Drift: forms of one requirement whose texts no longer say the same.
//!
//! What the requirement declares is taken from its sentence and its
//! parameters. In each form that was written by hand, found are
//! * a limit that is none of the declared ones of what it limits or, where the
//!   requirement limits something else, of its dimension; or of a dimension of
//!   which the requirement's sentence has none,
//! * a limit that itself counts to the other side (`<` for `<=`),
//! * a duration that says something else of what it limits (not before 3 s, or for 3 s, in place of within 3 s), or that adds
//!   up with an equal one that it stands behind (`roles`),
//! * a limit of the sentence that is left out (`left_out`); without a sentence, a time limit that one of property and monitor
//!   has, where the other has none at all or another one,
//! * a number without a unit that is compared with what the requirement
//!   limits, and that is not the limit in any unit in which that is known,
//! * coordinates compared one by one (a box) where the requirement compares a
//!   distance (a ball),
//! * other signals than the requirement's, for a quantity of the same
//!   dimension,
//! * another clock,
//! * an earlier instant than the one that the requirement speaks of.
//!
//! A number without a unit that would be the limit is a hint, no drift: it is
//! in the unit of the signals, which the texts do not say.
//!
//! Clock and instant are those of the sentence's monitor or, without a
//! sentence, of the main monitor.
//!
//! Not found is what only shows in use, such as another signal of the same
//! name; [`super::differences`] finds that on recordings.

use super::counterpart::{agree, in_words, is_of_same, is_same_limit, same_signals};
use super::left_out;
use super::limits::{Compared, Limit, of_judging, of_property, of_sentence, secs_of};
use super::roles::Role;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeSet;
use std::mem::discriminant;
use study::{JudgingForm, Rule, SentenceForm, Study, SubjectForm};
use temporal::formula::Formula;

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
    /// Where the form stands, as file and line.
    pub place: String,
    /// What fixes it.
    pub remedy: String,
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
    /// The limit itself counts to the other side.
    Boundary,
    /// A limit that the requirement has and the form has not.
    LeftOut,
    /// A number without a unit, which is the limit in one of its units.
    Unit,
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
            Self::Boundary => "another boundary",
            Self::LeftOut => "a limit left out",
            Self::Unit => "no unit",
        }
    }

    /// What fixes it.
    fn remedy(self, form: &str) -> &'static str {
        match (self, form) {
            (Self::Limit, _) => {
                "write the declared limit, by the parameter's name where it has one"
            }
            (Self::LeftOut, "property") => {
                "bound the property (`F<=k`, in steps of the model, with their duration as `step` under [model] in \
                 study.toml), or leave it out, so that it is made from the sentence"
            }
            (Self::LeftOut, _) => {
                "add the limit, or leave the form out, so that it is made from the sentence"
            }
            (Self::Unit, _) => "write the unit",
            (Self::Shape | Self::Signal | Self::Clock | Self::Instant | Self::Boundary, _) => {
                "write it as the requirement has it, or leave the form out, so that it is made from the sentence"
            }
        }
    }
}

/// What was found in the texts of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Found {
    /// What a form does not share with its requirement.
    pub drift: Vec<Drift>,
    /// What may be meant as the requirement has it, but does not say so.
    pub hints: Vec<Drift>,
}

/// All drift of a study's requirements.
pub fn of_study(study: &Study) -> Found {
    let own = study
        .requirements
        .iter()
        .filter(|r| r.same_quantity_as.is_none());
    let forms = own.filter_map(|requirement| study.forms.by_id(&requirement.id));
    let mut found = Found::default();
    for form in forms {
        let of_form = of_requirement(study, form);
        found.drift.extend(of_form.drift);
        found.hints.extend(of_form.hints);
    }
    found
}

fn of_requirement(study: &Study, form: &SubjectForm) -> Found {
    let declared = Declared::of(study, form);
    let mut finder = Finder {
        requirement: form.subject.id(),
        place: &|name: &str| place_of(study, form, name),
        declared,
        found: Found::default(),
    };
    if form.sentence.is_none() {
        finder.one_sided(left_out::between(study, form));
        for it in left_out::other_durations(study, form) {
            finder.add(it.form, DriftKind::Limit, it.found, it.declared);
        }
    }
    if finder.declared.limits.is_empty() && form.sentence.is_none() {
        return finder.found;
    }
    if let Some(property) = form.property.as_ref().filter(|p| !p.from_sentence) {
        let limits = of_property(study, &property.text);
        finder.limits("property", &limits);
        if let Some(sentence) = &form.sentence {
            let missing = left_out::of_property(study, sentence, &property.text, &limits);
            finder.left_out("property", missing);
            finder.one_sided(left_out::untimed(study, sentence, &property.text));
        }
    }
    let main = form.monitor.iter().map(|monitor| ("monitor", monitor));
    let readings = form.readings.iter().map(|r| (r.name.as_str(), &r.monitor));
    for (name, judging) in main.chain(readings).filter(|(_, j)| !j.from_sentence) {
        finder.judging(study, name, judging);
        if let Some(sentence) = &form.sentence {
            let missing = left_out::of_judging(study, sentence, judging);
            finder.left_out(name, missing);
        }
    }
    finder.found
}

/// Where a form stands; a monitor at its requirement.
fn place_of(study: &Study, form: &SubjectForm, name: &str) -> String {
    let property = form.property.as_ref().filter(|_| name == "property");
    let span = property.map_or(&form.span, |property| &property.span);
    let source = &study.forms.source;
    let (line, _) = diagnostic::line_and_column(&source.text, span.start);
    format!("{}:{line}", source.name)
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
                    awaited: None,
                    boundary: None,
                    role: Role::Unknown,
                    behind: 0,
                    twin: None,
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
    /// Where a form of this name stands.
    place: &'a dyn Fn(&str) -> String,
    declared: Declared,
    found: Found,
}

impl Finder<'_> {
    fn add(&mut self, form: &str, kind: DriftKind, found: String, declared: String) {
        let drift = Drift {
            requirement: self.requirement.to_owned(),
            form: form.to_owned(),
            kind,
            found,
            declared,
            place: (self.place)(form),
            remedy: kind.remedy(form).to_owned(),
        };
        let found = match kind {
            DriftKind::Unit => &mut self.found.hints,
            _ => &mut self.found.drift,
        };
        if !found.contains(&drift) {
            found.push(drift);
        }
    }

    fn left_out(&mut self, form: &str, missing: Vec<Limit>) {
        for limit in missing {
            let found = match (&limit.compared, &limit.awaited) {
                (Some(compared), _) => format!("no limit of `{}`", compared.quantity),
                (None, Some(awaited)) => format!("no limit of the time to `{awaited}`"),
                (None, None) => "no limit of that time".to_owned(),
            };
            self.add(form, DriftKind::LeftOut, found, in_words(&limit));
        }
    }

    /// Time limits of another form where this one has none.
    fn one_sided(&mut self, missing: Vec<left_out::OneSided>) {
        for it in missing {
            self.add(it.form, DriftKind::LeftOut, it.found, it.declared);
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
            let (same, limit) = same_or_twin(&counterparts, limit);
            if !same.is_empty() {
                let drift = boundary_drift(&same, limit);
                let drift = drift.or_else(|| role_drift(&same, limit, limits));
                let drift = drift.or_else(|| self.behind_drift(&same, limit));
                let hint = unit_hint(&same, limit);
                for (kind, found, declared) in drift.into_iter().chain(hint) {
                    self.add(form, kind, found, declared);
                }
                continue;
            }
            let declared = match counterparts.as_slice() {
                [] if limit.dimension.is_none() => {
                    let hint = unit_hint(&self.read_likewise(limit), limit);
                    if let Some((kind, found, declared)) = hint {
                        self.add(form, kind, found, declared);
                    }
                    continue;
                }
                [] if !self.declared.are_all => continue,
                [] => "no such limit".to_owned(),
                some => self.declared.words(some, in_words),
            };
            let found = self.told_apart(limit);
            self.add(form, DriftKind::Limit, found, declared);
        }
    }

    /// That a duration stands behind as many equal ones as are declared, or more: they add up.
    fn behind_drift(&self, same: &[&Limit], limit: &Limit) -> Option<(DriftKind, String, String)> {
        let first = same.first()?;
        let all = self.declared.limits.iter();
        let declared = all.filter(|it| it.is_duration() && is_same_limit(it, limit));
        (limit.is_duration() && limit.behind >= declared.count()).then(|| {
            let found = format!("{} behind another {}", in_words(limit), in_words(limit));
            (DriftKind::Limit, found, in_words(first))
        })
    }

    /// A limit in words; with what it limits, if the same limit of something
    /// else is declared.
    fn told_apart(&self, limit: &Limit) -> String {
        let words = in_words(limit);
        let mut all = self.declared.limits.iter();
        let is_elsewhere = all.any(|o| o.dimension == limit.dimension && is_same_limit(o, limit));
        match (&limit.compared, &limit.awaited) {
            (Some(compared), _) if is_elsewhere => format!("{words}, of `{}`", compared.quantity),
            (None, Some(awaited)) if is_elsewhere => format!("{words}, until `{awaited}`"),
            _ => words,
        }
    }

    /// The declared limits that a limit has to be one of: those of the same
    /// quantity or wait or, if there are none, of its dimension; where a unit
    /// is missing, those of what it limits. A parameter that the requirement
    /// names and its sentence does not use may limit anything.
    fn counterparts(&self, limit: &Limit) -> Vec<&Limit> {
        let all = self.declared.limits.iter();
        let of_dimension: Vec<&Limit> = all
            .filter(|other| match (other.dimension, limit.dimension) {
                (Some(one), Some(other)) => one == other,
                _ => is_of_same(other, limit),
            })
            .collect();
        if !of_dimension.iter().any(|other| is_of_same(other, limit)) {
            return of_dimension;
        }
        let is_free = |other: &Limit| other.compared.is_none() && other.awaited.is_none();
        let some = of_dimension.into_iter();
        some.filter(|other| is_of_same(other, limit) || is_free(other))
            .collect()
    }

    /// Declared limits of quantities whose signals a limit reads, whose value
    /// it has in SI units.
    fn read_likewise(&self, limit: &Limit) -> Vec<&Limit> {
        let Some(found) = &limit.compared else {
            return Vec::new();
        };
        let all = self.declared.limits.iter();
        all.filter(|other| {
            let compared = other.compared.as_ref();
            compared.is_some_and(|c| same_signals(c, found)) && is_same_limit(other, limit)
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
            .filter(|other| match limit.dimension {
                Some(_) => other.dimension == limit.dimension,
                // Without a unit, by what is read.
                None => other
                    .compared
                    .as_ref()
                    .is_some_and(|c| same_signals(c, found)),
            })
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

/// The declared limits that a limit is, as it is written or otherwise; and how it then reads.
fn same_or_twin<'l>(declared: &[&'l Limit], limit: &'l Limit) -> (Vec<&'l Limit>, &'l Limit) {
    let of = |one: &'l Limit| -> Vec<&'l Limit> {
        let all = declared.iter().copied();
        all.filter(|other| is_same_limit(other, one)).collect()
    };
    let own = of(limit);
    match limit.twin.as_deref() {
        Some(twin) if own.is_empty() || boundary_drift(&own, limit).is_some() => {
            let others = of(twin);
            match others.is_empty() {
                true => (own, limit),
                false => (others, twin),
            }
        }
        _ => (own, limit),
    }
}

/// That a duration of the declared size says something else of what it limits: not before 3 s, for within 3 s.
fn role_drift(
    same: &[&Limit],
    limit: &Limit,
    all: &[Limit],
) -> Option<(DriftKind, String, String)> {
    let with_twins = all.iter().flat_map(|it| [Some(it), it.twin.as_deref()]);
    let of_size = with_twins
        .flatten()
        .filter(|it| it.is_duration() && is_same_limit(it, limit));
    let roles: Vec<Role> = of_size.map(|it| it.role).collect();
    if same.iter().any(|it| it.role.is_said_by(limit.role, &roles)) {
        return None;
    }
    let words = |it: &Limit| format!("{}{}", it.role.words(), in_words(it));
    Some((DriftKind::Limit, words(limit), words(same.first()?)))
}

/// That the limit itself counts to another side than it does in each of the
/// declared limits of the same size.
fn boundary_drift(same: &[&Limit], limit: &Limit) -> Option<(DriftKind, String, String)> {
    let found = limit.boundary.as_ref()?;
    // The same wait, or the same quantity; a box has its own boundary.
    let alike = same
        .iter()
        .filter(|other| match (&other.compared, &limit.compared) {
            (Some(required), Some(found)) => agree(required, found),
            (None, None) => true,
            _ => false,
        });
    let declared = alike
        .map(|other| other.boundary.as_ref())
        .collect::<Option<Vec<_>>>()?;
    let first = declared.first()?;
    if declared
        .iter()
        .any(|other| other.is_above == found.is_above)
    {
        return None;
    }
    let (found, first) = (format!("`{}`", found.text), format!("`{}`", first.text));
    Some((DriftKind::Boundary, found, first))
}

/// That a number has no unit where the declared one has.
fn unit_hint(same: &[&Limit], limit: &Limit) -> Option<(DriftKind, String, String)> {
    let declared = same.iter().find(|other| other.dimension.is_some())?;
    let found = limit.dimension.is_none().then(|| in_words(limit))?;
    Some((DriftKind::Unit, found, in_words(declared)))
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

/// Whether all durations of a sentence are known in seconds.
fn has_known_durations(study: &Study, sentence: &SentenceForm) -> bool {
    let stages = sentence.tree.stages.iter();
    let mut durations = stages.filter_map(|stage| stage.timing.duration());
    durations.all(|duration| secs_of(study, duration.amount).is_some())
}
