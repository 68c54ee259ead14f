//! What is judged: the requirements of a study, or formulas without one.

use super::request::{MonitorRequest, Monitored};
use crate::Judges;
use crate::recording::ReadingRules;
use diagnostic::{Problem, Source};
use evidence::Subject;
use host::Host;
use std::collections::BTreeMap;
use std::ops::Range;
use study::{FormulaRule, JudgingForm, Rule, Study, Vocabulary};
use temporal::formula::{Ending, FormulaMonitor, TimeModel};

/// What a request asks, read and checked.
#[derive(Debug)]
pub enum Asked<'r> {
    /// The requirements and failure modes of a study.
    Study {
        study: Box<Study>,
        /// Only these; all if there are none.
        only: &'r [String],
    },
    /// Formulas, each a requirement of its own.
    Formulas {
        vocabulary: Vocabulary,
        forms: Vec<(Subject, JudgingForm)>,
    },
}

impl<'r> Asked<'r> {
    /// Reads the study, or the formulas.
    pub fn new(monitored: &'r Monitored, host: &Host) -> Result<Self, Problem> {
        match monitored {
            Monitored::Study { folder, only } => {
                let study = Box::new(Study::load_for(folder, &host.trust)?);
                check_only(&study, only)?;
                Ok(Self::Study { study, only })
            }
            Monitored::Formulas {
                texts,
                ending,
                time,
                start_within_secs,
            } => formulas(texts, *time, *ending, *start_within_secs),
        }
    }

    /// What has a meaning that is perhaps not meant, one line each.
    pub fn warnings(&self) -> Vec<String> {
        let found = match self {
            Self::Study { study, only } => study.forms.warnings(only),
            Self::Formulas { forms, .. } => {
                let rules = forms.iter().filter_map(|(_, form)| match &form.rule {
                    Rule::Formula(rule) => Some(rule),
                    Rule::Staged(_) => None,
                });
                let warning = |rule: &FormulaRule| rule.warning(&source_of(&rule.text), &(0..0));
                rules.filter_map(warning).collect()
            }
        };
        found.iter().map(Problem::warning_line).collect()
    }

    /// The compiled monitors.
    pub fn judges(&self) -> Result<Judges<'_>, Problem> {
        match self {
            Self::Study { study, only } => Judges::new(study, |subject| {
                only.is_empty() || only.iter().any(|id| id == subject.id())
            }),
            Self::Formulas { vocabulary, forms } => {
                let forms = forms.iter().map(|(subject, form)| (subject, form));
                Judges::without_study(vocabulary, forms)
            }
        }
    }

    /// How recordings are read.
    pub fn rules(&self, request: &MonitorRequest) -> Result<ReadingRules, Problem> {
        let map = request.map.as_deref();
        let rules = match self {
            Self::Study { study, .. } => ReadingRules::of_study(&study.folder, map)?,
            Self::Formulas { .. } => ReadingRules::of_map(map)?,
        };
        Ok(rules.with_call(request.time, request.opening.clone()))
    }

    /// What a requirement says, in words or as a formula.
    pub fn text(&self, subject: &Subject) -> String {
        match self {
            Self::Study { study, .. } => {
                let requirement = study.requirements.iter().find(|r| r.id == subject.id());
                requirement.map_or_else(|| subject.id().to_owned(), |r| r.text.clone())
            }
            Self::Formulas { forms, .. } => {
                let found = forms.iter().find(|(other, _)| other == subject);
                match found.map(|(_, form)| &form.rule) {
                    Some(Rule::Formula(rule)) => rule.text.clone(),
                    _ => subject.id().to_owned(),
                }
            }
        }
    }

    /// What a proposition means, if it is one of the vocabulary.
    pub fn meaning(&self, proposition: &str) -> Option<String> {
        let Self::Study { study, .. } = self else {
            return None;
        };
        let found = study.vocabulary.propositions.get(proposition);
        found.map(|proposition| proposition.meaning.clone())
    }
}

fn check_only(study: &Study, only: &[String]) -> Result<(), Problem> {
    match only.iter().find(|id| study.forms.by_id(id).is_none()) {
        Some(id) => Err(Problem::new(
            "unknown-subject",
            format!("requirements.toml does not declare `{id}`"),
        )
        .remedy("check the identifier")),
        None => Ok(()),
    }
}

fn formulas<'r>(
    texts: &[String],
    time: TimeModel,
    ending: Ending,
    start_within_secs: f64,
) -> Result<Asked<'r>, Problem> {
    let vocabulary = Vocabulary {
        source: source_of(&texts.join("\n")),
        propositions: BTreeMap::new(),
        signals: trace::Vocabulary::default(),
    };
    let mut forms = Vec::new();
    for (index, text) in texts.iter().enumerate() {
        let id = match texts.len() {
            1 => "formula".to_owned(),
            _ => format!("formula {}", index + 1),
        };
        let form = JudgingForm {
            rule: Rule::Formula(rule(text, time, ending)?),
            clock: None,
            start_within_secs,
            from_sentence: false,
        };
        forms.push((Subject::Requirement(id), form));
    }
    Ok(Asked::Formulas { vocabulary, forms })
}

/// A formula as a text with a name.
fn source_of(formula: &str) -> Source {
    Source {
        name: "<formula>".into(),
        text: formula.to_owned(),
    }
}

fn rule(text: &str, time: TimeModel, ending: Ending) -> Result<FormulaRule, Problem> {
    let source = source_of(text);
    let bad = |message: String, span: Range<usize>| {
        Problem::new("bad-formula", message).at(&source, span)
    };
    let parsed = temporal::formula::parse(text, &|_| None)
        .map_err(|error| bad(error.message, error.span).remedy(error.remedy))?;
    for atom in &parsed.atoms {
        trace::Predicate::parse(&atom.text)
            .map(drop)
            .map_err(|error| {
                let start = atom.span.start;
                bad(
                    error.kind.to_string(),
                    start + error.span.start..start + error.span.end,
                )
                .remedy("without a study, a formula compares signals: /topic.field < 250 mm/s; a topic map (--map) names those that are elements of arrays")
            })?;
    }
    let rule = FormulaRule {
        text: text.to_owned(),
        resolved: parsed.to_string(),
        trigger: None,
        trigger_text: parsed
            .formula
            .trigger()
            .map(|trigger| trigger.display(&parsed.atoms).to_string()),
        parsed,
        time,
        ending,
        place: Some(0..text.len()),
    };
    FormulaMonitor::compile(&rule.parsed.formula, &rule.settings())
        .map_err(|error| bad(error.to_string(), 0..text.len()))?;
    Ok(rule)
}
