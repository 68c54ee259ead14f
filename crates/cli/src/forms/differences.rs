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
use crate::study::{FormulaRule, JudgingForm, Rule, Study, SubjectForm};
use crate::technique::judging::{Judgement, Judges, verdict_name};
use evidence::{FormDifference, Subject};
use schemars::JsonSchema;
use serde::Serialize;
use temporal::formula::{Formula, Parsed};
use temporal::monitor::Verdict;

/// The name of the form that is made from the sentence.
pub const SENTENCE: &str = "sentence";
/// The name of the main monitor, if it is written by hand.
pub const MONITOR: &str = "monitor";
/// The name of the property, if it is written by hand.
pub const PROPERTY: &str = "property";

/// The name of a failure mode's property, negated: that it does not occur.
pub const OCCURS: &str = "occurs";

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

/// The forms of all requirements and failure modes that have more than one of
/// their own. A failure mode's property asks whether it occurs, its monitor
/// whether it does not, so its property is negated.
pub fn forms_of(study: &Study) -> Vec<NamedForm<'_>> {
    let is_own = |subject: &Subject| match subject {
        Subject::Requirement(id) => {
            let mut own = study.requirements.iter();
            own.any(|r| &r.id == id && r.same_quantity_as.is_none())
        }
        Subject::FailureMode(_) => true,
    };
    let own = study.forms.subjects.iter();
    let several = own
        .filter(|form| is_own(&form.subject))
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
        forms.push(match form.subject {
            Subject::Requirement(_) => named(PROPERTY, judging),
            Subject::FailureMode(_) => named(OCCURS, judging.map(negated)),
        });
    }
    for reading in &form.readings {
        forms.push(named(&reading.name, Ok(reading.monitor.clone())));
    }
    forms
}

/// The form that is violated where `form` is satisfied, and conversely.
fn negated(form: JudgingForm) -> JudgingForm {
    let rule = match form.rule {
        Rule::Formula(rule) => {
            let parsed = Parsed {
                formula: Formula::not(rule.parsed.formula),
                atoms: rule.parsed.atoms,
            };
            let text = parsed.to_string();
            Rule::Formula(FormulaRule {
                resolved: text.clone(),
                text,
                parsed,
                ..rule
            })
        }
        staged @ Rule::Staged(_) => staged,
    };
    JudgingForm { rule, ..form }
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
    let differing = differing(judgements).into_iter();
    differing
        .map(|(reference, other)| Difference {
            requirement: reference.subject.id().to_owned(),
            recording: recording.to_owned(),
            reference: reference.reading.unwrap_or_default().to_owned(),
            reference_verdict: verdict_name(reference.findings.verdict).into(),
            form: other.reading.unwrap_or_default().to_owned(),
            verdict: verdict_name(other.findings.verdict).into(),
            at_secs: [reference, other]
                .into_iter()
                .find_map(|judgement| judgement.findings.violation.as_ref().map(|v| v.to_secs)),
        })
        .collect()
}

/// The pairs of forms that differ on one recording: the one that the others
/// are held against, and the other.
fn differing<'j, 'a>(
    judgements: &'j [Judgement<'a>],
) -> Vec<(&'j Judgement<'a>, &'j Judgement<'a>)> {
    let by_subject = judgements.chunk_by(|one, other| one.subject == other.subject);
    let pairs = by_subject.filter_map(<[_]>::split_first);
    pairs
        .flat_map(|(reference, others)| others.iter().map(move |other| (reference, other)))
        .filter(|(one, other)| differ(one.findings.verdict, other.findings.verdict))
        .collect()
}

/// The differences on many runs, alike ones counted together, in the order of
/// the forms. `witnesses` of the runs are named, at most.
pub fn summary(
    runs: &[Vec<Judgement<'_>>],
    names: &[String],
    witnesses: usize,
) -> Vec<FormDifference> {
    let mut all: Vec<FormDifference> = Vec::new();
    for (judgements, name) in runs.iter().zip(names) {
        for (reference, other) in differing(judgements) {
            let new = FormDifference {
                subject: reference.subject.clone(),
                reference: reference.reading.unwrap_or_default().to_owned(),
                reference_verdict: verdict_name(reference.findings.verdict).into(),
                form: other.reading.unwrap_or_default().to_owned(),
                verdict: verdict_name(other.findings.verdict).into(),
                count: 0,
                runs: runs.len() as u64,
                witnesses: Vec::new(),
            };
            let place = all.iter().position(|known| is_alike(known, &new));
            let place = place.unwrap_or_else(|| {
                all.push(new);
                all.len() - 1
            });
            let found = &mut all[place];
            found.count += 1;
            if found.witnesses.len() < witnesses {
                found.witnesses.push(name.clone());
            }
        }
    }
    let place = |found: &FormDifference| {
        let mut order = runs.iter().flatten();
        order.position(|j| j.subject == &found.subject && j.reading == Some(found.form.as_str()))
    };
    all.sort_by_cached_key(|found| (place(found), found.reference_verdict.clone()));
    all
}

/// Whether two differences are of the same forms in the same way.
fn is_alike(one: &FormDifference, other: &FormDifference) -> bool {
    one.subject == other.subject
        && (&one.reference, &one.form) == (&other.reference, &other.form)
        && (&one.reference_verdict, &one.verdict) == (&other.reference_verdict, &other.verdict)
}

/// Differences in one line.
pub fn in_words(differences: &[FormDifference]) -> String {
    let mut subjects: Vec<&str> = differences.iter().map(|d| d.subject.id()).collect();
    subjects.dedup();
    format!(
        "              forms of one requirement judge some of its runs otherwise: {} (in the report and study.json)",
        subjects.join(", ")
    )
}

fn differ(one: Verdict, other: Verdict) -> bool {
    let undecided = [one, other].contains(&Verdict::Inconclusive);
    !undecided && (one == Verdict::Violated) != (other == Verdict::Violated)
}
