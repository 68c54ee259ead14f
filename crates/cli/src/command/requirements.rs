//! `corroborate requirements`: each requirement in all its forms, where they
//! drifted apart, and the recordings on which they do not agree.

use super::{Done, Host, json};
use crate::args::{Format, Requirements};
use corroborate::outcome::Outcome;
use diagnostic::Problem;
use evidence::Subject;
use judging::forms::differences::{Difference, NamedForm, forms_of, judges, on_recording};
use judging::forms::drift::{Drift, of_study};
use judging::recording::{ReadingRules, recordings};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;
use study::{Rule, SentenceForm, Study, SubjectForm};

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

/// Shows requirements and checks their forms against each other.
pub fn requirements(arguments: &Requirements, setting: &Host) -> Result<Done, Problem> {
    let Some(folder) = &arguments.study else {
        return super::library::library(arguments.format);
    };
    let study = Study::load(folder)?;
    let forms = forms_of(&study);
    let found = of_study(&study);
    let mut report = RequirementsReport {
        format: "1.2".into(),
        warnings: warn(&study, setting),
        requirements: study
            .forms
            .subjects
            .iter()
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
    hold_against_recordings(arguments, setting, &study, &forms, &mut report)?;
    let outcome = if !report.drift.is_empty() || !report.differences.is_empty() {
        Outcome::Violated
    } else if !report.lost.is_empty() {
        Outcome::DataLost
    } else {
        Outcome::Holds
    };
    let output = match arguments.format {
        Format::Json => json(&report)?,
        Format::Text => text(&report),
    };
    Ok(Done { output, outcome })
}

/// Says what has a meaning that is perhaps not meant, and gives it.
fn warn(study: &Study, setting: &Host) -> Vec<String> {
    let found = study.forms.warnings(&[]);
    let lines: Vec<String> = found.iter().map(Problem::warning_line).collect();
    lines.iter().for_each(|line| setting.events.say(line));
    lines
}

fn hold_against_recordings(
    arguments: &Requirements,
    setting: &Host,
    study: &Study,
    forms: &[NamedForm<'_>],
    report: &mut RequirementsReport,
) -> Result<(), Problem> {
    let rules = ReadingRules::of_study(&study.folder, arguments.map.as_deref())?;
    let files = recordings(&arguments.recordings)?;
    let judges = judges(study, forms)?;
    let stage = setting.events.begin("recordings", files.len() as u64);
    for file in &files {
        let judged = rules.judge(&judges, file, &|| setting.go_on())?;
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

fn text(report: &RequirementsReport) -> String {
    let mut out = String::new();
    for requirement in &report.requirements {
        requirement_text(&mut out, requirement);
    }
    drift_text(&mut out, &report.drift);
    for hint in &report.hints {
        let _ = writeln!(
            out,
            "  hint: {}, {}: {}, where the requirement has {}",
            hint.requirement, hint.form, hint.found, hint.declared
        );
    }
    differences_text(&mut out, report);
    out
}

fn requirement_text(out: &mut String, shown: &RequirementForms) {
    let _ = writeln!(out, "{}", shown.id);
    let mut line = |label: &str, text: &str| {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "  {label:<11} {text}");
    };
    line("text", &shown.text);
    if let Some(first) = &shown.same_quantity_as {
        line("forms", &format!("those of {first}"));
        out.push('\n');
        return;
    }
    if let Some(sentence) = &shown.sentence {
        line("sentence", sentence);
    }
    for words in &shown.meaning {
        line("", words);
    }
    if !shown.parameters.is_empty() {
        line("parameters", &shown.parameters.join(", "));
    }
    for (label, form) in [("property", &shown.property), ("monitor", &shown.monitor)] {
        if let Some(form) = form {
            line(label, &format!("{}   ({})", form.text, form.origin));
        }
    }
    if let Some(witness) = &shown.test_witness {
        line("test", &format!("a witness of {witness}"));
    }
    if let Some(falsify) = &shown.test_falsify {
        line("", &format!("to break it: a witness of {falsify}"));
    }
    if let Some(reach) = &shown.test_reach {
        line("", &format!("in simulation: {reach}"));
    }
    if !shown.coverage.is_empty() {
        let names: Vec<&str> = shown.coverage.iter().map(|bin| bin.name.as_str()).collect();
        line("coverage", &names.join(", "));
    }
    for missing in &shown.not_expressible {
        let text = format!("no {}: {}", missing.form, missing.reason);
        line("", &text);
    }
    out.push('\n');
}

fn drift_text(out: &mut String, drift: &[Drift]) {
    if drift.is_empty() {
        out.push_str("No drift: the forms declare what their requirements do.\n");
        return;
    }
    out.push_str("Drift\n");
    for found in drift {
        let _ = writeln!(
            out,
            "  {}, {}: {}: {}, where the requirement has {}\n    {}: {}",
            found.requirement,
            found.form,
            found.kind.words(),
            found.found,
            found.declared,
            found.place,
            found.remedy
        );
    }
}

fn differences_text(out: &mut String, report: &RequirementsReport) {
    for form in &report.not_judged {
        let _ = writeln!(
            out,
            "  {}, {}: cannot judge recordings: {}",
            form.requirement, form.form, form.reason
        );
    }
    if report.recordings.is_empty() {
        out.push_str("Name recordings, and the forms are held against each other on them.\n");
        return;
    }
    let _ = writeln!(
        out,
        "\nDifferences on {} recordings: {}",
        report.recordings.len(),
        report.differences.len()
    );
    for found in &report.differences {
        let at = found
            .at_secs
            .map_or(String::new(), |secs| format!(" (at {secs:.3} s)"));
        let _ = writeln!(
            out,
            "  {}, {}: {} {}, {} {}{at}",
            found.requirement,
            found.recording,
            found.reference,
            found.reference_verdict,
            found.form,
            found.verdict
        );
    }
    for note in &report.notes {
        let _ = writeln!(out, "  note: {note}");
    }
    for lost in &report.lost {
        let _ = writeln!(out, "  lost: {lost}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(RequirementsReport).into();
        crate::command::tests::assert_schema_is_committed("requirements.schema.json", &schema);
    }
}
