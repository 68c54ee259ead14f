//! Limits that a requirement's sentence has and a form of it leaves out.
//!
//! A limit is left out if the form limits neither the same quantity (the same
//! wait) by the same value or by a value that is nobody's, nor anything else of
//! that dimension that the sentence does not speak of; what it limits instead
//! is then a drift of its own kind. Nothing is said of forms with a proposition
//! that could hold the limit without showing it: a flag that is computed
//! elsewhere, a variable of a model. So what is found is left out, but not all
//! that is left out is found.
//!
//! Where a step of the model has no declared duration, the bounds of a property
//! cannot be held against seconds. A property that has none at all has left out
//! the sentence's nevertheless: it says less, at any duration of a step.
//! Without a sentence, property and monitor are held against each other: which
//! of both is meant is not known, so the one without a limit is named; or the
//! property, where both have limits of time and it has others.

use super::counterpart::{in_words, is_of_same, is_same_limit, same_signals};
use super::limits::{self, Limit, counts_samples, of_proposition, of_sentence};
use super::roles::Role;
use prism_lang::ast::ExprKind;
use requirement_lang::expression::Expression;
use study::{JudgingForm, Rule, SentenceForm, Study, SubjectForm, quoted_names};
use trace::units::Dimension;

/// A form without any time limit, where another has one.
#[derive(Clone, Debug, PartialEq)]
pub struct OneSided {
    /// `property` or `monitor`.
    pub form: &'static str,
    /// What it has not.
    pub found: String,
    /// The limit that the other has.
    pub declared: String,
}

/// The limits that a form for traces leaves out.
pub fn of_judging(study: &Study, sentence: &SentenceForm, form: &JudgingForm) -> Vec<Limit> {
    let (names, waits_in_samples) = spoken_of(form);
    let of_sentence_itself = sentence.tree.propositions();
    let shows_limits =
        |name: &str| of_sentence_itself.contains(&name) || !of_proposition(study, name).is_empty();
    if !names.iter().all(|name| shows_limits(name)) {
        return Vec::new();
    }
    let found = limits::of_judging(study, form);
    missing(study, sentence, &found, |limit| {
        limit.compared.is_some() || !waits_in_samples
    })
}

/// The propositions of a form for traces, and whether it waits in samples instead of seconds.
fn spoken_of(form: &JudgingForm) -> (Vec<&str>, bool) {
    match &form.rule {
        Rule::Staged(spec) => (spec.propositions(), false),
        Rule::Formula(rule) => (
            rule.parsed.atoms.iter().map(|a| a.text.as_str()).collect(),
            counts_samples(&rule.parsed.formula),
        ),
    }
}

/// The durations that a property leaves out. What it limits of other
/// quantities is the model's abstraction, which has no signals; and so is
/// time, where a step of the model has no declared duration.
pub fn of_property(
    study: &Study,
    sentence: &SentenceForm,
    text: &str,
    found: &[Limit],
) -> Vec<Limit> {
    let names = sentence.tree.propositions();
    let mut labels = quoted_names(text).into_iter();
    let only_the_sentence_s = labels.all(|(label, _)| names.contains(&label.as_str()));
    // A bound that is no number (a constant, a sum) may be the limit.
    let is_read = study.about.model.step_secs().is_some() && !limits::has_other_bounds(text);
    if !only_the_sentence_s || !is_read {
        return Vec::new();
    }
    missing(study, sentence, found, |limit| limit.compared.is_none())
}

fn missing(
    study: &Study,
    sentence: &SentenceForm,
    found: &[Limit],
    wanted: impl Fn(&Limit) -> bool,
) -> Vec<Limit> {
    let declared = of_sentence(study, sentence);
    let mut missing: Vec<Limit> = Vec::new();
    for limit in declared.iter().filter(|limit| wanted(limit)) {
        let is_there = found.iter().any(|one| stands_for(one, limit, &declared));
        if !is_there && !missing.contains(limit) {
            missing.push(limit.clone());
        }
    }
    missing
}

/// Whether `found` is the form's limit for what `limit` declares, be it
/// another one.
fn stands_for(found: &Limit, limit: &Limit, declared: &[Limit]) -> bool {
    let is_same_size = is_same_limit(found, limit);
    if is_of_same(found, limit) {
        let mut others = declared.iter().filter(|other| is_of_same(found, other));
        return is_same_size || others.all(|other| !is_same_limit(found, other));
    }
    if declared.iter().any(|other| is_of_same(found, other)) {
        return false;
    }
    match found.dimension {
        Some(dimension) => limit.dimension == Some(dimension),
        None => match (&limit.compared, &found.compared) {
            (Some(required), Some(found)) => same_signals(required, found),
            _ => true,
        },
    }
}

/// The durations of a sentence of which a property of a model without declared time has none.
pub fn untimed(study: &Study, sentence: &SentenceForm, text: &str) -> Vec<OneSided> {
    let names = sentence.tree.propositions();
    let is_timed = study.about.model.step_secs().is_some() || is_bounded(study, text);
    if is_timed || !names_only(text, &names) {
        return Vec::new();
    }
    let stages = sentence.tree.stages.iter();
    let timed = stages.filter_map(|stage| Some((stage, stage.timing.duration()?)));
    timed
        .map(|(stage, duration)| OneSided {
            form: "property",
            found: match &stage.response {
                Expression::Atom(atom) => format!("no limit of the time to `{}`", atom.text),
                _ => "no limit of time".to_owned(),
            },
            declared: duration.text.clone(),
        })
        .collect()
}

/// What of a requirement without a sentence has no time limit, of its property and its monitor, where the other has one.
pub fn between(study: &Study, form: &SubjectForm) -> Vec<OneSided> {
    let (Some(property), Some(monitor)) = (&form.property, &form.monitor) else {
        return Vec::new();
    };
    let (names, waits_in_samples) = spoken_of(monitor);
    let mut durations = limits::of_judging(study, monitor);
    durations.retain(Limit::is_duration);
    let is_timed = waits_in_samples || !durations.is_empty();
    let labels = quoted_names(&property.text);
    let is_label = |name: &&str| labels.iter().any(|(label, _)| label == name);
    match is_bounded(study, &property.text) {
        false if names_only(&property.text, &names) => of_durations(&durations),
        true if !is_timed && names.iter().all(is_label) => vec![OneSided {
            form: "monitor",
            found: "no limit of time".to_owned(),
            declared: format!("`{}` as its property", property.text),
        }],
        _ => Vec::new(),
    }
}

/// The durations of a property that its monitor has not, where there is no sentence and both speak of the same.
pub fn other_durations(study: &Study, form: &SubjectForm) -> Vec<OneSided> {
    let (Some(property), Some(monitor)) = (&form.property, &form.monitor) else {
        return Vec::new();
    };
    let (names, waits_in_samples) = spoken_of(monitor);
    let labels = quoted_names(&property.text);
    let is_label = |name: &&str| labels.iter().any(|(label, _)| label == name);
    let is_read = study.about.model.step_secs().is_some()
        && !waits_in_samples
        && !limits::has_other_bounds(&property.text);
    if !is_read || !names_only(&property.text, &names) || !names.iter().all(is_label) {
        return Vec::new();
    }
    let durations = |mut all: Vec<Limit>| {
        all.retain(Limit::is_duration);
        all
    };
    let ours = durations(limits::of_property(study, &property.text));
    let theirs = durations(limits::of_judging(study, monitor));
    let is_there = |limit: &Limit| {
        let of_size = theirs.iter().filter(|it| is_same_limit(it, limit));
        let roles: Vec<Role> = of_size.map(|it| it.role).collect();
        roles
            .iter()
            .any(|it| it.is_said_by(limit.role, &[limit.role]))
    };
    let words = |it: &Limit| format!("{}{}", it.role.words(), in_words(it));
    let all: Vec<String> = theirs.iter().map(words).collect();
    // Which of both is meant is not known; without any, it is left out.
    let other = ours
        .iter()
        .filter(|limit| !all.is_empty() && !is_there(limit));
    let found = other.map(|limit| OneSided {
        form: "property",
        found: words(limit),
        declared: format!("{} in its monitor", all.join(", ")),
    });
    found.collect()
}

/// That a property has none of the durations of its monitor.
fn of_durations(durations: &[Limit]) -> Vec<OneSided> {
    let mut found: Vec<OneSided> = durations
        .iter()
        .map(|limit| OneSided {
            form: "property",
            found: match &limit.awaited {
                Some(awaited) => format!("no limit of the time to `{awaited}`"),
                None => "no limit of time".to_owned(),
            },
            declared: format!("{} in its monitor", limit.text),
        })
        .collect();
    found.dedup();
    found
}

/// Whether all labels of a property are these propositions, and it has one.
fn names_only(text: &str, names: &[&str]) -> bool {
    let labels = quoted_names(text);
    !labels.is_empty()
        && labels
            .iter()
            .all(|(label, _)| names.contains(&label.as_str()))
}

/// Whether any operator of a property has a bound of steps or time, or a label of it compares a variable that is a time.
fn is_bounded(study: &Study, text: &str) -> bool {
    let mut limits = limits::of_property(study, text).into_iter();
    let has_time = limits.any(|limit| limit.dimension == Some(Dimension::TIME));
    has_time
        || limits::any_part(text, |part| {
            matches!(part, ExprKind::Temporal { bound: Some(_), .. })
        })
}
