//! Differences: recordings on which two forms of one requirement do not agree.
//!
//! Every form that can judge traces judges every recording: the sentence's
//! monitor, the monitor or formula written by hand, the other readings, and
//! the property, as a formula of LTL on finite traces. The sentence is what
//! the others are held against; without one, the main monitor. Two forms
//! differ on a recording if one is violated and the other is not; one that is
//! undecided differs from none.

use super::judged_on_traces;
use crate::{Judgement, Judges, run_verdict};
use diagnostic::Problem;
use evidence::{FormDifference, RunVerdict, Subject};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use study::{FormulaRule, JudgingForm, Rule, Study, SubjectForm};
use temporal::formula::{Formula, Parsed};
use temporal::monitor::Verdict;

/// The name of the form that is made from the sentence.
pub const SENTENCE: &str = "sentence";
/// The name of the main monitor, if it is written by hand.
pub const MONITOR: &str = "monitor";
/// The name of the property, if it is written by hand.
pub const PROPERTY: &str = "property";

/// Runs that are named as witnesses of a difference, at most.
const WITNESSES: usize = 5;

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
    pub reference_verdict: RunVerdict,
    /// The form that differs.
    pub form: String,
    /// Its verdict.
    pub verdict: RunVerdict,
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
            reference_verdict: run_verdict(reference.findings.verdict),
            form: other.reading.unwrap_or_default().to_owned(),
            verdict: run_verdict(other.findings.verdict),
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

/// The differences on many runs, alike ones counted together, taken one run at
/// a time.
#[derive(Clone, Debug)]
pub struct DifferenceTally {
    /// The forms, with their names.
    forms: Vec<(Subject, String)>,
    runs: u64,
    /// By form and by its reference's verdict, so in the order of the forms.
    found: BTreeMap<(usize, Verdict, Verdict), (u64, Vec<String>)>,
}

impl DifferenceTally {
    /// Before the first run, of the forms of [`judges`].
    pub fn new<'a>(forms: impl Iterator<Item = (&'a Subject, Option<&'a str>)>) -> Self {
        let named = |(subject, form): (&Subject, Option<&str>)| {
            (subject.clone(), form.unwrap_or_default().to_owned())
        };
        Self {
            forms: forms.map(named).collect(),
            runs: 0,
            found: BTreeMap::new(),
        }
    }

    /// Takes a run: the verdict of each form, in their order.
    pub fn add(&mut self, name: &str, verdicts: &[Verdict]) {
        self.runs += 1;
        let mut reference = 0;
        for place in 0..self.forms.len().min(verdicts.len()) {
            if self.forms[place].0 != self.forms[reference].0 {
                reference = place;
            }
            let (of_reference, of_form) = (verdicts[reference], verdicts[place]);
            if differ(of_reference, of_form) {
                let key = (place, of_reference, of_form);
                let (count, witnesses) = self.found.entry(key).or_default();
                *count += 1;
                if witnesses.len() < WITNESSES {
                    witnesses.push(name.to_owned());
                }
            }
        }
    }

    /// What was found, in the order of the forms.
    pub fn finish(self) -> Vec<FormDifference> {
        let reference = |place: usize| {
            let subject = &self.forms[place].0;
            let first = self.forms.iter().find(|(other, _)| other == subject);
            first.map(|(_, name)| name.clone()).unwrap_or_default()
        };
        let found = self.found.iter();
        found
            .map(
                |((place, of_reference, of_form), (count, witnesses))| FormDifference {
                    subject: self.forms[*place].0.clone(),
                    reference: reference(*place),
                    reference_verdict: run_verdict(*of_reference),
                    form: self.forms[*place].1.clone(),
                    verdict: run_verdict(*of_form),
                    count: *count,
                    runs: self.runs,
                    witnesses: witnesses.clone(),
                },
            )
            .collect()
    }
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
