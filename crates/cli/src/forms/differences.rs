//! Differences: recordings on which two forms of one requirement do not agree.
//!
//! Every form that can judge traces judges every recording: the sentence's
//! monitor, the monitor or formula written by hand, the other readings, and
//! the property, as a formula of LTL on finite traces. The sentence is what
//! the others are held against; without one, the main monitor. Two forms
//! differ on a recording if one is violated and the other is not; one that is
//! undecided differs from none.

use super::judged_on_traces;
use crate::problem::Problem;
use crate::study::{JudgingForm, Study, SubjectForm};
use crate::technique::judging::{Judgement, Judges, verdict_name};
use evidence::Subject;
use schemars::JsonSchema;
use serde::Serialize;
use temporal::monitor::Verdict;

/// The name of the form that is made from the sentence.
pub const SENTENCE: &str = "sentence";
/// The name of the main monitor, if it is written by hand.
pub const MONITOR: &str = "monitor";
/// The name of the property, if it is written by hand.
pub const PROPERTY: &str = "property";

/// One form of a requirement, ready to judge.
#[derive(Clone, Debug)]
pub struct NamedForm<'a> {
    /// Whose form it is.
    pub subject: &'a Subject,
    /// Its name.
    pub name: String,
    /// How it judges, or why it cannot.
    pub judging: Result<JudgingForm, String>,
}

/// A recording on which a form does not agree with its requirement.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Difference {
    /// The requirement.
    pub requirement: String,
    /// The recording.
    pub recording: String,
    /// What the others are held against: `sentence` or `monitor`.
    pub reference: String,
    /// Its verdict.
    pub reference_verdict: String,
    /// The form that differs.
    pub form: String,
    /// Its verdict.
    pub verdict: String,
    /// When the violation shows, in seconds of the judging form's clock.
    pub at_secs: Option<f64>,
}

/// The forms of all requirements that have more than one of their own. A
/// failure mode's property asks whether it occurs, its monitor whether it does
/// not, so these are not compared.
pub fn forms_of(study: &Study) -> Vec<NamedForm<'_>> {
    let own = study
        .requirements
        .iter()
        .filter(|r| r.same_quantity_as.is_none());
    let several = own
        .filter_map(|requirement| study.forms.by_id(&requirement.id))
        .map(|form| forms(study, form));
    several.filter(|forms| forms.len() > 1).flatten().collect()
}

/// The forms of one requirement, the one to hold the others against first.
fn forms<'a>(study: &Study, form: &'a SubjectForm) -> Vec<NamedForm<'a>> {
    let named = |name: &str, judging| NamedForm {
        subject: &form.subject,
        name: name.to_owned(),
        judging,
    };
    let mut forms = Vec::new();
    if let Some(sentence) = &form.sentence {
        forms.push(named(SENTENCE, sentence.monitor.clone()));
    }
    if let Some(monitor) = form.monitor.as_ref().filter(|m| !m.from_sentence) {
        forms.push(named(MONITOR, Ok(monitor.clone())));
    }
    if let Some(property) = form.property.as_ref().filter(|p| !p.from_sentence) {
        let judging = judged_on_traces(study, &property.text);
        forms.push(named(PROPERTY, judging));
    }
    for reading in &form.readings {
        forms.push(named(&reading.name, Ok(reading.monitor.clone())));
    }
    forms
}

/// The judges of those forms that can judge traces.
pub fn judges<'a>(study: &'a Study, forms: &'a [NamedForm<'a>]) -> Result<Judges<'a>, Problem> {
    let able = forms.iter().filter_map(|form| {
        let judging = form.judging.as_ref().ok()?;
        Some((form.subject, form.name.as_str(), judging))
    });
    Judges::of_forms(study, able)
}

/// The differences on one recording. The judgements are those of [`judges`],
/// in their order.
pub fn on_recording(recording: &str, judgements: &[Judgement<'_>]) -> Vec<Difference> {
    let mut differences = Vec::new();
    for of_subject in judgements.chunk_by(|one, other| one.subject == other.subject) {
        let Some((reference, others)) = of_subject.split_first() else {
            continue;
        };
        for other in others {
            if differ(reference.findings.verdict, other.findings.verdict) {
                let violated = [reference, other]
                    .into_iter()
                    .find_map(|judgement| judgement.findings.violation.as_ref().map(|v| v.to_secs));
                differences.push(Difference {
                    requirement: reference.subject.id().to_owned(),
                    recording: recording.to_owned(),
                    reference: reference.reading.unwrap_or_default().to_owned(),
                    reference_verdict: verdict_name(reference.findings.verdict).into(),
                    form: other.reading.unwrap_or_default().to_owned(),
                    verdict: verdict_name(other.findings.verdict).into(),
                    at_secs: violated,
                });
            }
        }
    }
    differences
}

fn differ(one: Verdict, other: Verdict) -> bool {
    let undecided = [one, other].contains(&Verdict::Inconclusive);
    !undecided && (one == Verdict::Violated) != (other == Verdict::Violated)
}
