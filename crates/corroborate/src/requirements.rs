//! Each requirement in all its forms, where they drifted apart, and the recordings on which they do not agree; and the
//! library of ready requirements.

pub mod exchange;
mod library;

pub use library::{LibraryReport, NeedShown, ParameterShown, TemplateShown, library};

use diagnostic::Problem;
use evidence::Subject;
use host::Host;
use judging::forms::differences::{Difference, NamedForm, forms_of, judges, on_recording};
use judging::forms::drift::{Drift, of_study};
use judging::recording::{ReadingRules, recordings};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use study::{Rule, SentenceForm, Study, SubjectForm};

/// Whose requirements are shown. [`RequirementsRequest::new`] holds them against no recording.
#[derive(Clone, Debug)]
pub struct RequirementsRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Recordings, or folders of them, on which the forms are compared.
    pub recordings: Vec<PathBuf>,
    /// Where recordings have the signals; by default the study's `topics.toml`.
    pub map: Option<PathBuf>,
}

impl RequirementsRequest {
    /// Of the study in this folder.
    pub fn new(study: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            recordings: Vec::new(),
            map: None,
        }
    }

    /// With a recording, or a folder of them, among those on which the forms are compared.
    #[must_use]
    pub fn recording(mut self, path: impl Into<PathBuf>) -> Self {
        self.recordings.push(path.into());
        self
    }
}

/// What `requirements --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RequirementsReport {
    /// Version of this form.
    pub format: String,
    /// Each requirement in its forms.
    pub requirements: Vec<RequirementForms>,
    /// What has a meaning that is perhaps not meant.
    pub warnings: Vec<String>,
    /// Forms whose texts are not what the requirement declares.
    pub drift: Vec<Drift>,
    /// Numbers without a unit that are a declared limit if the signal has the
    /// right unit.
    pub hints: Vec<Drift>,
    /// Forms that cannot judge recordings, and why.
    pub not_judged: Vec<NotJudged>,
    /// The recordings that were judged.
    pub recordings: Vec<String>,
    /// Recordings on which two forms do not agree.
    pub differences: Vec<Difference>,
    /// What could not be read of the recordings.
    pub lost: Vec<String>,
    /// What else is to be known about how recordings were read.
    pub notes: Vec<String>,
}

/// One requirement in its forms. What is missing cannot be expressed;
/// `not_expressible` says why.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct RequirementForms {
    /// The requirement.
    pub id: String,
    /// Its text, verbatim.
    pub text: String,
    /// Why it is asked for, if that is said.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(default)]
    pub rationale: String,
    /// How far it is, in the words of the tool that manages requirements.
    #[serde(skip_serializing_if = "String::is_empty")]
    #[schemars(default)]
    pub status: String,
    /// The ids of the requirements that it was derived from.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(default)]
    pub parents: Vec<String>,
    /// The requirement whose forms it has, if it differs in its threshold only.
    pub same_quantity_as: Option<String>,
    /// The sentence in structured English.
    pub sentence: Option<String>,
    /// What was understood, one statement each.
    pub meaning: Vec<String>,
    /// That as a drawing.
    pub diagram: Option<String>,
    /// The parameters that it is held against, with their values.
    pub parameters: Vec<String>,
    /// The logical property.
    pub property: Option<Form>,
    /// The monitor for traces.
    pub monitor: Option<Form>,
    /// The question to the model whose witness is a test that triggers it.
    pub test_witness: Option<String>,
    /// The question to the model whose witness is a test that breaks it.
    pub test_falsify: Option<String>,
    /// What a simulated test should make true first.
    pub test_reach: Option<String>,
    /// The situations that tests should cover.
    pub coverage: Vec<CoverageBin>,
    /// Forms that cannot be made, with the reason.
    pub not_expressible: Vec<NotJudged>,
}

/// One form of a requirement.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Form {
    /// Its text.
    pub text: String,
    /// `sentence` if it was made from that, or `by hand`.
    pub origin: String,
    /// What counts as covering it.
    pub trigger: Option<String>,
}

/// A situation that tests should cover.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CoverageBin {
    /// Its name.
    pub name: String,
    /// What it is.
    pub meaning: String,
    /// The formula of the traces that are in it.
    pub formula: String,
}

/// A form that is missing, and why.
#[derive(Debug, Serialize, JsonSchema)]
pub struct NotJudged {
    /// The requirement.
    pub requirement: String,
    /// The form.
    pub form: String,
    /// Why.
    pub reason: String,
}

/// Shows requirements, and checks their forms against each other.
///
/// # Errors
/// What the study's files say wrong; `cannot-read` and `bad-recording` of recordings; `interrupted` if the host was asked to
/// stop.
pub fn requirements(
    request: &RequirementsRequest,
    host: &Host,
) -> Result<RequirementsReport, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    let forms = forms_of(&study);
    let found = of_study(&study);
    let subjects = study.forms.subjects.iter();
    let mut report = RequirementsReport {
        format: "1.2".into(),
        warnings: warn(&study, host),
        requirements: subjects
            .filter_map(|form| forms_shown(&study, form))
            .collect(),
        drift: found.drift,
        hints: found.hints,
        not_judged: not_judged(&forms),
        recordings: Vec::new(),
        differences: Vec::new(),
        lost: Vec::new(),
        notes: Vec::new(),
    };
    hold_against_recordings(request, host, &study, &forms, &mut report)?;
    Ok(report)
}

/// Says what has a meaning that is perhaps not meant, and gives it.
fn warn(study: &Study, host: &Host) -> Vec<String> {
    let found = study.forms.warnings(&[]);
    let lines: Vec<String> = found.iter().map(Problem::warning_line).collect();
    lines.iter().for_each(|line| host.events.say(line));
    lines
}

fn hold_against_recordings(
    request: &RequirementsRequest,
    host: &Host,
    study: &Study,
    forms: &[NamedForm<'_>],
    report: &mut RequirementsReport,
) -> Result<(), Problem> {
    let rules = ReadingRules::of_study(&study.folder, request.map.as_deref())?;
    let files = recordings(&request.recordings)?;
    let judges = judges(study, forms)?;
    let stage = host.events.begin("recordings", files.len() as u64);
    for file in &files {
        let judged = rules.judge(&judges, file, &|| host.go_on())?;
        let name = file.display().to_string();
        let differences = on_recording(&name, &judged.judgements);
        report.differences.extend(differences);
        let lost = judged.lost.iter().map(|lost| format!("{name}: {lost}"));
        report.lost.extend(lost);
        let notes = judged.notes.iter().map(|note| format!("{name}: {note}"));
        report.notes.extend(notes);
        report.recordings.push(name);
        stage.advance();
    }
    Ok(())
}

fn not_judged(forms: &[NamedForm<'_>]) -> Vec<NotJudged> {
    let unable = forms.iter().filter_map(|form| {
        Some(NotJudged {
            requirement: form.subject.id().to_owned(),
            form: form.name.clone(),
            reason: form.judging.as_ref().err()?.clone(),
        })
    });
    unable.collect()
}

fn forms_shown(study: &Study, form: &SubjectForm) -> Option<RequirementForms> {
    let Subject::Requirement(id) = &form.subject else {
        return None;
    };
    let requirement = study.requirements.iter().find(|r| &r.id == id)?;
    let mut shown = RequirementForms {
        id: id.clone(),
        text: requirement.text.clone(),
        rationale: form.background.rationale.clone(),
        status: form.background.status.clone(),
        parents: form.background.parents.clone(),
        parameters: form
            .parameters
            .iter()
            .map(|name| valued(study, name))
            .collect(),
        property: form.property.as_ref().map(|property| Form {
            text: property.text.clone(),
            origin: origin(property.from_sentence),
            trigger: None,
        }),
        monitor: form.monitor.as_ref().map(|monitor| Form {
            text: requirement.monitor.clone().unwrap_or_default(),
            origin: origin(monitor.from_sentence),
            trigger: match &monitor.rule {
                Rule::Formula(rule) => rule.trigger_text.clone(),
                Rule::Staged(spec) => Some(spec.when.clone()),
            },
        }),
        ..RequirementForms::default()
    };
    shown.same_quantity_as = requirement.same_quantity_as.clone();
    if let Some(sentence) = form
        .sentence
        .as_ref()
        .filter(|_| shown.same_quantity_as.is_none())
    {
        add_sentence(&mut shown, sentence);
    }
    Some(shown)
}

fn add_sentence(shown: &mut RequirementForms, sentence: &SentenceForm) {
    let explanation = sentence.explanation();
    shown.sentence = Some(sentence.text.clone());
    shown.meaning = explanation.words;
    shown.diagram = Some(explanation.diagram);
    let mut missing = Vec::new();
    let mut note = |form: &str, reason: &String| {
        missing.push(NotJudged {
            requirement: shown.id.clone(),
            form: form.to_owned(),
            reason: reason.clone(),
        });
    };
    if let Err(reason) = &sentence.property {
        note("property", reason);
    }
    if let Err(reason) = &sentence.monitor {
        note("monitor", reason);
    }
    for name in &sentence.not_in_experiments {
        note("experiment", &format!("`{name}` is not bound to a column"));
    }
    match &sentence.model_goal {
        Ok(goal) => {
            shown.test_witness = Some(goal.witness.clone());
            shown.test_falsify = Some(goal.falsify.clone());
        }
        Err(reason) => note("test goal in the model", reason),
    }
    match &sentence.trace_goal {
        Ok(goal) => shown.test_reach = Some(goal.reach.to_string()),
        Err(reason) => note("test goal in simulation", reason),
    }
    match &sentence.bins {
        Ok(bins) => {
            shown.coverage = bins
                .iter()
                .map(|bin| CoverageBin {
                    name: bin.name.to_owned(),
                    meaning: bin.meaning.to_owned(),
                    formula: bin.formula.to_string(),
                })
                .collect();
        }
        Err(reason) => note("coverage", reason),
    }
    shown.not_expressible = missing;
}

fn origin(from_sentence: bool) -> String {
    if from_sentence { "sentence" } else { "by hand" }.to_owned()
}

/// A parameter with its value as it is written.
fn valued(study: &Study, name: &str) -> String {
    match study.parameters.declared.get(name) {
        Some(parameter) => format!("{name} = {} ({})", parameter.text, parameter.meaning),
        None => name.to_owned(),
    }
}
