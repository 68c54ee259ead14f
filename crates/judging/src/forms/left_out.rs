//! Limits that a requirement's sentence has and a form of it leaves out.
//!
//! A limit is left out if the form limits neither the same quantity (the same
//! wait) by the same value or by a value that is nobody's, nor anything else of
//! that dimension that the sentence does not speak of; what it limits instead
//! is then a drift of its own kind. Nothing is said of forms with a proposition
//! that could hold the limit without showing it: a flag that is computed
//! elsewhere, a variable of a model. So what is found is left out, but not all
//! that is left out is found.

use super::counterpart::{is_of_same, is_same_limit, same_signals};
use super::limits::{self, Limit, counts_samples, of_proposition, of_sentence};
use study::{JudgingForm, Rule, SentenceForm, Study, quoted_names};

/// The limits that a form for traces leaves out.
pub fn of_judging(study: &Study, sentence: &SentenceForm, form: &JudgingForm) -> Vec<Limit> {
    let (names, waits_in_samples): (Vec<&str>, bool) = match &form.rule {
        Rule::Staged(spec) => (spec.propositions(), false),
        Rule::Formula(rule) => (
            rule.parsed.atoms.iter().map(|a| a.text.as_str()).collect(),
            counts_samples(&rule.parsed.formula),
        ),
    };
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
    if !only_the_sentence_s || study.about.model.step_secs().is_none() {
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
