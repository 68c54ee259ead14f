//! What is judged: the requirements of a study, or formulas without one.

use crate::args::{EndingChoice, Monitor, TimeChoice};
use diagnostic::{Problem, Source};
use evidence::Subject;
use judging::Judges;
use judging::recording::ReadingRules;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use study::{FormulaRule, JudgingForm, Rule, Study, Vocabulary};
use temporal::formula::{Ending, FormulaMonitor, TimeModel};

/// What a call asks.
#[derive(Debug)]
pub struct Asked<'a> {
    what: What,
    only: &'a [String],
    /// The recordings that are judged, as they are named.
    pub recordings: &'a [PathBuf],
}

#[derive(Debug)]
enum What {
    Study(Box<Study>),
    Formulas {
        vocabulary: Vocabulary,
        forms: Vec<(Subject, JudgingForm)>,
    },
}

impl<'a> Asked<'a> {
    /// Reads the study, or the formulas.
    pub fn new(arguments: &'a Monitor) -> Result<Self, Problem> {
        let (what, recordings) = if arguments.formula.is_empty() {
            let (study, recordings) = study_first(&arguments.paths)?;
            (What::Study(Box::new(Study::load(study)?)), recordings)
        } else {
            (formulas(arguments)?, &arguments.paths[..])
        };
        let asked = Self {
            what,
            only: &arguments.only,
            recordings,
        };
        asked.check_only()?;
        Ok(asked)
    }

    fn check_only(&self) -> Result<(), Problem> {
        let What::Study(study) = &self.what else {
            return Ok(());
        };
        match self.only.iter().find(|id| study.forms.by_id(id).is_none()) {
            Some(id) => Err(Problem::new(
                "unknown-subject",
                format!("requirements.toml does not declare `{id}`"),
            )
            .remedy("check the identifier")),
            None => Ok(()),
        }
    }

    /// What has a meaning that is perhaps not meant, one line each.
    pub fn warnings(&self) -> Vec<String> {
        let found = match &self.what {
            What::Study(study) => study.forms.warnings(self.only),
            What::Formulas { forms, .. } => {
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
        match &self.what {
            What::Study(study) => Judges::new(study, |subject| {
                self.only.is_empty() || self.only.iter().any(|id| id == subject.id())
            }),
            What::Formulas { vocabulary, forms } => {
                let forms = forms.iter().map(|(subject, form)| (subject, form));
                Judges::without_study(vocabulary, forms)
            }
        }
    }

    /// How recordings are read.
    pub fn rules(&self, arguments: &Monitor) -> Result<ReadingRules, Problem> {
        let map = arguments.map.as_deref();
        let rules = match &self.what {
            What::Study(study) => ReadingRules::of_study(&study.folder, map)?,
            What::Formulas { .. } => ReadingRules::of_map(map)?,
        };
        Ok(rules.with_call(
            arguments.time.map(TimeChoice::source),
            arguments.opening.options(),
        ))
    }

    /// What a requirement says, in words or as a formula.
    pub fn text(&self, subject: &Subject) -> String {
        match &self.what {
            What::Study(study) => {
                let requirement = study.requirements.iter().find(|r| r.id == subject.id());
                requirement.map_or_else(|| subject.id().to_owned(), |r| r.text.clone())
            }
            What::Formulas { forms, .. } => {
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
        let What::Study(study) = &self.what else {
            return None;
        };
        let found = study.vocabulary.propositions.get(proposition);
        found.map(|proposition| proposition.meaning.clone())
    }
}

/// The study that is named first, and the recordings.
fn study_first(paths: &[PathBuf]) -> Result<(&Path, &[PathBuf]), Problem> {
    let remedy = "name a study's folder first, or give a formula: \
                  --formula 'always (/robot.speed < 250 mm/s)'";
    match paths {
        [study, rest @ ..] if study.is_file() => {
            let _ = rest;
            let message = format!("{} is a file, not a study's folder", study.display());
            Err(Problem::new("no-study", message).remedy(remedy))
        }
        [study, rest @ ..] if !rest.is_empty() => Ok((study, rest)),
        _ => Err(
            Problem::new("no-recordings", "no recording is named behind the study")
                .remedy("name recordings, or folders of them, behind the study"),
        ),
    }
}

fn formulas(arguments: &Monitor) -> Result<What, Problem> {
    let vocabulary = Vocabulary {
        source: Source {
            name: "<formula>".into(),
            text: arguments.formula.join("\n"),
        },
        propositions: BTreeMap::new(),
        signals: trace::Vocabulary::default(),
    };
    let mut forms = Vec::new();
    for (index, text) in arguments.formula.iter().enumerate() {
        let id = match arguments.formula.len() {
            1 => "formula".to_owned(),
            _ => format!("formula {}", index + 1),
        };
        let form = JudgingForm {
            rule: Rule::Formula(rule(arguments, text)?),
            clock: None,
            start_within_secs: arguments.start_within,
            from_sentence: false,
        };
        forms.push((Subject::Requirement(id), form));
    }
    Ok(What::Formulas { vocabulary, forms })
}

/// A formula of the command line as a text with a name.
fn source_of(formula: &str) -> Source {
    Source {
        name: "<formula>".into(),
        text: formula.to_owned(),
    }
}

fn rule(arguments: &Monitor, text: &str) -> Result<FormulaRule, Problem> {
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
        time: if arguments.dense {
            TimeModel::Dense
        } else {
            TimeModel::Discrete
        },
        ending: match arguments.ending {
            EndingChoice::Finite => Ending::Finite,
            EndingChoice::Weak => Ending::Weak,
            EndingChoice::Strong => Ending::Strong,
            EndingChoice::Inconclusive => Ending::Inconclusive,
        },
        place: Some(0..text.len()),
    };
    FormulaMonitor::compile(&rule.parsed.formula, &rule.settings())
        .map_err(|error| bad(error.to_string(), 0..text.len()))?;
    Ok(rule)
}
