//! Models that compute the same number, to the last digit.
//!
//! # Definition
//! Two pieces that are computed from different models answer a subject alike if both values are exact or bounded, neither is 0 or 1,
//! and they differ by at most [`SAME`] of the lesser of the value and its complement. Numbers that were estimated apart from each
//! other lead to values that differ; where they are the same, both models rest on the same numbers, whatever these are called and
//! however the models are built.
//!
//! Nothing is asked where it is known already: of models that have a file or most of their text in common, or that the ledger says
//! were set to counts of the subject.
//!
//! # Assumes
//! That different sources of a number do not round it alike. Where they do (two teams that both wrote 0.95), the ledger's
//! `independent` says so.
//!
//! # Guarantee
//! None for a probability. Models that share some of their numbers and differ in others compute different values, and are not found.

use evidence::{AssetRole, CopyKind, Evidence, LineageQuestion, Measure, Subject};

/// The part of a value, or of its complement, by which two computations of one number may differ.
const SAME: f64 = 1e-7;

/// What is asked, each with the place of the later piece.
pub(super) fn questions(evidence: &[Evidence]) -> Vec<(usize, LineageQuestion)> {
    let mut found = Vec::new();
    for (place, later) in evidence.iter().enumerate() {
        for earlier in &evidence[..place] {
            found.extend(question(later, earlier).map(|it| (place, it)));
        }
    }
    found
}

fn question(later: &Evidence, earlier: &Evidence) -> Option<LineageQuestion> {
    let is_computed = |it: &Evidence| it.technique.is_of_model() && !it.intermediate;
    let is_known = |one: &Evidence, other: &Evidence| {
        one.common_texts.iter().any(|text| text.with == other.id)
    };
    if !is_computed(later) || !is_computed(earlier) {
        return None;
    }
    if is_known(later, earlier) || is_known(earlier, later) || have_a_file(later, earlier) {
        return None;
    }
    let same: Vec<(Subject, f64)> = later
        .findings
        .iter()
        .filter_map(|finding| {
            let subject = &finding.subject;
            let (own, other) = (value(later, subject)?, value(earlier, subject)?);
            let is_same = (own - other).abs() <= SAME * own.min(1.0 - own);
            is_same.then(|| (subject.clone(), own))
        })
        .collect();
    let (first, value) = same.first()?;
    let more = match same.len() - 1 {
        0 => String::new(),
        more => format!(", and alike on {more} more"),
    };
    let (id, with) = (&later.id, &earlier.id);
    Some(LineageQuestion {
        with: with.clone(),
        kind: CopyKind::Answer,
        finding: format!(
            "{id} and {with} compute the same number for {}, {value:.6}, to the last digit{more}: both rest on the same numbers",
            super::subject_in_words(first)
        ),
        subjects: same.into_iter().map(|(subject, _)| subject).collect(),
        places: [later, earlier].into_iter().filter_map(model).collect(),
        chance: 0.0,
        blocks: true,
        settled: None,
        remedy: format!(
            "they have one voice, and do not agree independently; if each has its numbers from a source of its own, write \
             `independent = {{ {with} = \"reason\" }}` in {id}'s entry of ledger.toml"
        ),
    })
}

/// A computed value that was not set to counts, and says something.
fn value(piece: &Evidence, subject: &Subject) -> Option<f64> {
    if piece.calibrated.iter().any(|it| &it.subject == subject) {
        return None;
    }
    let Measure::Probability { answer, .. } = &piece.finding(subject)?.measure else {
        return None;
    };
    let is_one = !answer.guarantee.is_estimated() && answer.guarantee.over_schedulers().is_none();
    (is_one && answer.value > 0.0 && answer.value < 1.0).then_some(answer.value)
}

fn have_a_file(one: &Evidence, other: &Evidence) -> bool {
    let models = |piece: &Evidence| {
        let all = piece.assets.iter();
        let all = all.filter(|it| it.role == AssetRole::SystemModel);
        all.map(|it| (it.path.clone(), it.hash.clone()))
            .collect::<Vec<_>>()
    };
    let theirs = models(other);
    models(one).iter().any(|(path, hash)| {
        let mut all = theirs.iter();
        all.any(|(other, content)| path == other || hash == content)
    })
}

fn model(piece: &Evidence) -> Option<String> {
    let mut all = piece.assets.iter();
    let model = all.find(|it| it.role == AssetRole::SystemModel)?;
    Some(model.path.clone())
}
