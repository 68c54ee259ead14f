//! Reads `requirements.toml` and holds it against the vocabulary and the declared parameters.

use super::carried::{CarryOverText, carried};
use super::durations::other_duration;
use super::stated::other_rate;
use super::{Background, FormText, Forms, ReadingForm, SubjectForm, TriggerForm};
use crate::judging_form::{JudgingForm, JudgingText, Rule};
use crate::sentence_form::{SentenceForm, SentenceReader};
use crate::{About, StudyParameters, Texts, Vocabulary};
use diagnostic::{Problem, Problems, Source, did_you_mean};
use evidence::{DEFAULT_MARGIN, FailureMode, Requirement, Step, Subject};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;
use temporal::formula::{Ending, TimeModel};
use temporal::monitor::{MonitorSpec, Stage};
use toml::Spanned;

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// The requirements, in the order of the report.
    #[serde(default)]
    requirement: Vec<RequirementText>,
    /// The ways to fail.
    #[serde(default)]
    failure_mode: Vec<FailureModeText>,
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct RequirementText {
    /// Identifier, by which evidence and tables name it.
    #[schemars(with = "String")]
    id: Spanned<String>,
    /// The requirement verbatim, as its source has it.
    #[schemars(with = "String")]
    text: Spanned<String>,
    /// Why it is asked for.
    #[serde(default)]
    rationale: String,
    /// How far it is, in the words of the tool that manages requirements.
    #[serde(default)]
    status: String,
    /// The ids of the requirements that it was derived from, here or elsewhere.
    #[serde(default)]
    parents: Vec<String>,
    /// What is asked of the probability, for example `"at least 0.95"`; without it every run has to satisfy the requirement.
    #[schemars(with = "Option<String>")]
    threshold: Option<Spanned<String>>,
    /// An earlier requirement whose sentence, property and monitor it shares; only its text and threshold are its own.
    #[schemars(with = "Option<String>")]
    same_as: Option<Spanned<String>>,
    /// The difference of two probabilities that still counts as agreement, between 0 and 1; 0.05, if absent.
    #[schemars(with = "Option<f64>")]
    margin: Option<Spanned<f64>>,
    /// The sentence in structured English from which the other forms are made (`corroborate explain sentence`).
    #[schemars(with = "Option<String>")]
    shall: Option<Spanned<String>>,
    /// A sentence of the library instead of `shall` (`corroborate requirements --library`).
    #[schemars(with = "Option<String>")]
    template: Option<Spanned<String>>,
    /// What stands for the template's parameters, in their order.
    #[serde(default)]
    #[schemars(with = "Vec<String>")]
    parameters: Vec<Spanned<String>>,
    /// A PRISM property written by hand; it replaces the one made from the sentence.
    #[schemars(with = "Option<String>")]
    property: Option<Spanned<String>>,
    /// When the requirement can be violated at all: a proposition. Runs in which it never holds are not counted. Taken from the sentence, if that says it.
    #[schemars(with = "Option<String>")]
    trigger: Option<Spanned<String>>,
    /// A staged monitor written by hand: what is waited for, in which order, within which times (`corroborate explain monitor`).
    #[schemars(with = "Option<MonitorSpec>")]
    monitor: Option<Spanned<MonitorSpec>>,
    /// A temporal formula over signals written by hand (`corroborate explain formula`).
    #[schemars(with = "Option<String>")]
    formula: Option<Spanned<String>>,
    /// Whether the formula speaks of samples or of all times.
    #[schemars(with = "Option<TimeModel>")]
    time: Option<Spanned<TimeModel>>,
    /// What is said of times after the end of a recording.
    #[schemars(with = "Option<Ending>")]
    ending: Option<Spanned<Ending>>,
    /// The signal whose value is the time of the formula or monitor, instead of the recording's time.
    #[schemars(with = "Option<String>")]
    clock: Option<Spanned<String>>,
    /// How long after the start of a recording its signals may begin, in seconds, without leaving a gap at the start.
    #[schemars(with = "Option<f64>")]
    start_within_secs: Option<Spanned<f64>>,
    /// The proposition of the vocabulary whose column counts it in tables of experiments.
    #[schemars(with = "Option<String>")]
    experiment: Option<Spanned<String>>,
    /// Of what a verdict has to speak: `model`, `simulation`, `corroborated` or `system` (`corroborate explain steps`); as `study.toml` says, if absent.
    needs: Option<Step>,
    /// Declarations that the agreement of a model with trials of the system holds for this requirement, too.
    #[serde(default)]
    #[schemars(with = "Vec<CarryOverText>")]
    carries_over: Vec<Spanned<CarryOverText>>,
    /// Other ways to read the requirement, by name, of which a diagnosis finds out which of them evidence follows.
    #[serde(default)]
    reading: BTreeMap<String, ReadingText>,
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReadingText {
    /// What is different in this reading, in words.
    #[schemars(with = "String")]
    meaning: Spanned<String>,
    /// A staged monitor written by hand: what is waited for, in which order, within which times (`corroborate explain monitor`).
    #[schemars(with = "Option<MonitorSpec>")]
    monitor: Option<Spanned<MonitorSpec>>,
    /// A temporal formula over signals written by hand (`corroborate explain formula`).
    #[schemars(with = "Option<String>")]
    formula: Option<Spanned<String>>,
    /// Whether the formula speaks of samples or of all times.
    #[schemars(with = "Option<TimeModel>")]
    time: Option<Spanned<TimeModel>>,
    /// What is said of times after the end of a recording.
    #[schemars(with = "Option<Ending>")]
    ending: Option<Spanned<Ending>>,
    /// The signal whose value is the time of the formula or monitor, instead of the recording's time.
    #[schemars(with = "Option<String>")]
    clock: Option<Spanned<String>>,
    /// How long after the start of a recording its signals may begin, in seconds, without leaving a gap at the start.
    #[schemars(with = "Option<f64>")]
    start_within_secs: Option<Spanned<f64>>,
}

#[derive(JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
struct FailureModeText {
    /// Identifier, by which tables and the ledger name it.
    #[schemars(with = "String")]
    id: Spanned<String>,
    /// What it is called in the report.
    name: String,
    /// What happens, in words.
    meaning: String,
    /// The difference of two rates that still counts as agreement, between 0 and 1; 0.05, if absent.
    #[schemars(with = "Option<f64>")]
    margin: Option<Spanned<f64>>,
    /// The proposition of the vocabulary whose column counts it in tables of experiments.
    #[schemars(with = "Option<String>")]
    experiment: Option<Spanned<String>>,
    /// A PRISM property: the probability that it occurs.
    #[schemars(with = "Option<String>")]
    occurs: Option<Spanned<String>>,
    /// A PRISM property: the probability that a run comes to where it can occur. The rate is that of runs in which it occurs where it can,
    /// divided by it; what occurs elsewhere does not count.
    #[schemars(with = "Option<String>")]
    opportunity: Option<Spanned<String>>,
    /// A staged monitor written by hand: what is waited for, in which order, within which times (`corroborate explain monitor`).
    #[schemars(with = "Option<MonitorSpec>")]
    monitor: Option<Spanned<MonitorSpec>>,
    /// A temporal formula over signals written by hand (`corroborate explain formula`).
    #[schemars(with = "Option<String>")]
    formula: Option<Spanned<String>>,
    /// Whether the formula speaks of samples or of all times.
    #[schemars(with = "Option<TimeModel>")]
    time: Option<Spanned<TimeModel>>,
    /// What is said of times after the end of a recording.
    #[schemars(with = "Option<Ending>")]
    ending: Option<Spanned<Ending>>,
    /// The signal whose value is the time of the formula or monitor, instead of the recording's time.
    #[schemars(with = "Option<String>")]
    clock: Option<Spanned<String>>,
    /// How long after the start of a recording its signals may begin, in seconds, without leaving a gap at the start.
    #[schemars(with = "Option<f64>")]
    start_within_secs: Option<Spanned<f64>>,
}

/// The JSON Schema of `requirements.toml`.
pub(crate) fn schema() -> schemars::Schema {
    schemars::schema_for!(File)
}

/// Reads `requirements.toml` and checks it against the vocabulary. Mistakes are added to those that were found; a form that has
/// one is left out.
pub fn load(
    (folder, texts): (&Path, &dyn Texts),
    vocabulary: &Vocabulary,
    parameters: &StudyParameters,
    about: &About,
    found: &mut Problems,
) -> (Vec<Requirement>, Vec<FailureMode>, Forms) {
    let path = folder.join("requirements.toml");
    let source = texts.needed(&path);
    let source = found.keep(source);
    let file: Option<File> = source
        .as_ref()
        .and_then(|source| crate::toml_text::read_on(source, found));
    let source = source.unwrap_or_else(|| Source::new(path.display().to_string(), ""));
    let Some(file) = file else {
        found.lose_names();
        let subjects = Vec::new();
        return (Vec::new(), Vec::new(), Forms { source, subjects });
    };
    if file.requirement.is_empty() {
        // Who names one follows from that.
        found.lose_names();
        found.add(
            Problem::new(
                "no-requirements",
                "the study has no requirement, so there is nothing to verify",
            )
            .at(&source, 0..0)
            .remedy("add a [[requirement]] with `id`, `text`, and a sentence in `shall`, a `property` or a `monitor`"),
        );
    }
    let step_secs = about.model.step_secs();
    let reader = Reader {
        needs: about.verdicts.needs,
        source: &source,
        vocabulary,
        parameters,
        sentences: SentenceReader {
            source: &source,
            vocabulary,
            parameters,
            step_secs,
        },
    };
    let mut subjects: Vec<SubjectForm> = Vec::new();
    let mut requirements = Vec::new();
    for text in file.requirement {
        let (requirement, form) = reader.requirement(text, &subjects, &requirements, found);
        requirements.push(requirement);
        subjects.push(form);
    }
    let mut failure_modes = Vec::new();
    for text in file.failure_mode {
        let (mode, form) = reader.failure_mode(text, &subjects, found);
        failure_modes.push(mode);
        subjects.push(form);
    }
    let forms = Forms { source, subjects };
    (requirements, failure_modes, forms)
}

pub(super) struct Reader<'a> {
    needs: Step,
    pub(super) source: &'a Source,
    pub(super) vocabulary: &'a Vocabulary,
    parameters: &'a StudyParameters,
    sentences: SentenceReader<'a>,
}

impl Reader<'_> {
    fn requirement(
        &self,
        text: RequirementText,
        before: &[SubjectForm],
        requirements: &[Requirement],
        found: &mut Problems,
    ) -> (Requirement, SubjectForm) {
        found.keep(self.check_new(&text.id, before));
        let id = text.id.get_ref().clone();
        let same = self.same_as(&text, before, requirements);
        let same = found.keep(same).flatten();
        let judging = JudgingText::new(
            text.monitor,
            text.formula,
            text.time,
            text.ending,
            text.clock,
            text.start_within_secs,
        );
        let sentence = self.sentence(text.shall, text.template, &judging);
        let sentence = found.keep(sentence).flatten();
        let written = judging.compile(self.source, self.vocabulary);
        let written = found.keep(written).flatten();
        let threshold = self.required(text.threshold, sentence.as_ref());
        let threshold = found.keep(threshold).flatten();
        let parameters = self.declared(text.parameters, sentence.as_ref());
        let mut form = SubjectForm {
            subject: Subject::Requirement(id.clone()),
            span: text.id.span(),
            property: text.property.map(form_text),
            no_property: None,
            opportunity: None,
            trigger: TriggerForm::Always,
            monitored: TriggerForm::Always,
            monitor: written,
            no_monitor: None,
            parameters: found.keep(parameters).unwrap_or_default(),
            readings: self.readings(text.reading, found),
            experiment: found.keep(self.experiment(text.experiment)).flatten(),
            carried_at: text.carries_over.iter().map(Spanned::span).collect(),
            other_rate: None,
            wide_margin: self.wide_margin(text.margin.as_ref()),
            other_duration: None,
            background: Background {
                rationale: text.rationale,
                status: text.status,
                parents: text.parents,
            },
            sentence,
        };
        form.complete_from_sentence();
        form.monitored = self.monitored(&form);
        let trigger = self.trigger(&form, text.trigger);
        form.trigger = found.keep(trigger).unwrap_or(TriggerForm::Always);
        if let Some((_, other)) = &same {
            form = SubjectForm {
                subject: form.subject,
                span: form.span,
                carried_at: form.carried_at,
                background: form.background,
                ..(*other).clone()
            };
        }
        let sentence = form.sentence.as_ref();
        let is_of_sentence = sentence.is_some_and(|it| it.tree.probability.is_some());
        form.other_rate = other_rate(self.source, &text.text, threshold, is_of_sentence);
        form.other_duration = form.sentence.as_ref().and_then(|sentence| {
            other_duration(self.source, &text.text, sentence, self.sentences.step_secs)
        });
        self.check_property(&mut form, found);
        let carries_over = carried(text.carries_over, &id);
        let requirement = Requirement {
            id,
            text: text.text.into_inner(),
            threshold,
            // The other's sentence asks for the other's probability.
            sentence: match same {
                Some(_) => None,
                None => form.sentence.as_ref().map(|s| s.text.clone()),
            },
            property: form.property.as_ref().map(|p| p.text.clone()),
            monitor: form.monitor.as_ref().map(in_words),
            trigger: super::trigger::in_words(&form),
            margin: match (&same, text.margin) {
                (Some((first, _)), None) => first.margin,
                (_, margin) => found.keep(self.margin(margin)).unwrap_or(DEFAULT_MARGIN),
            },
            asks_for: form
                .monitor
                .as_ref()
                .and_then(JudgingForm::horizon)
                .map(|it| it.to_string()),
            same_quantity_as: same.map(|(first, _)| first.id.clone()),
            needs: text.needs.unwrap_or(self.needs),
            carries_over,
        };
        (requirement, form)
    }

    /// The requirement's own sentence, or the one of the library.
    fn sentence(
        &self,
        shall: Option<Spanned<String>>,
        template: Option<Spanned<String>>,
        judging: &JudgingText,
    ) -> Result<Option<SentenceForm>, Problem> {
        match (shall, template) {
            (Some(_), Some(template)) => Err(Problem::new(
                "two-sentences",
                "a requirement has its own sentence or one of the library, not both",
            )
            .at(self.source, template.span())
            .remedy("remove `shall` or `template`")),
            (Some(shall), None) => self.sentences.read(shall, judging).map(Some),
            (None, Some(template)) => self.sentences.of_library(&template, judging).map(Some),
            (None, None) => Ok(None),
        }
    }

    fn same_as<'b>(
        &self,
        text: &RequirementText,
        before: &'b [SubjectForm],
        requirements: &'b [Requirement],
    ) -> Result<Option<(&'b Requirement, &'b SubjectForm)>, Problem> {
        let Some(same) = &text.same_as else {
            return Ok(None);
        };
        if text.shall.is_some()
            || text.template.is_some()
            || text.property.is_some()
            || text.trigger.is_some()
            || text.monitor.is_some()
            || text.formula.is_some()
            || text.experiment.is_some()
            || !text.reading.is_empty()
        {
            return Err(Problem::new(
                "same-as-with-forms",
                "a requirement that is the same as another cannot have forms of its own",
            )
            .at(self.source, same.span())
            .remedy("remove `same_as`, or the property and the monitor"));
        }
        let found = requirements
            .iter()
            .zip(before)
            .find(|(requirement, _)| &requirement.id == same.get_ref());
        found.map(Some).ok_or_else(|| {
            let known = requirements.iter().map(|it| it.id.as_str());
            let remedy = match did_you_mean(same.get_ref(), known) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => "name a requirement that stands earlier in the file".to_owned(),
            };
            Problem::new(
                "unknown-requirement",
                format!(
                    "`same_as` names `{}`, but no requirement before this one has that id",
                    same.get_ref()
                ),
            )
            .at(self.source, same.span())
            .remedy(remedy)
        })
    }

    fn failure_mode(
        &self,
        text: FailureModeText,
        before: &[SubjectForm],
        found: &mut Problems,
    ) -> (FailureMode, SubjectForm) {
        found.keep(self.check_new(&text.id, before));
        let id = text.id.get_ref().clone();
        let judging = JudgingText::new(
            text.monitor,
            text.formula,
            text.time,
            text.ending,
            text.clock,
            text.start_within_secs,
        );
        let monitor = judging.compile(self.source, self.vocabulary);
        let mut form = SubjectForm {
            subject: Subject::FailureMode(id.clone()),
            span: text.id.span(),
            sentence: None,
            property: text.occurs.map(form_text),
            no_property: None,
            opportunity: text.opportunity.map(form_text),
            trigger: TriggerForm::Always,
            monitored: TriggerForm::Always,
            monitor: found.keep(monitor).flatten(),
            no_monitor: None,
            parameters: Vec::new(),
            readings: Vec::new(),
            experiment: found.keep(self.experiment(text.experiment)).flatten(),
            carried_at: Vec::new(),
            background: Background::default(),
            other_rate: None,
            wide_margin: self.wide_margin(text.margin.as_ref()),
            other_duration: None,
        };
        self.check_property(&mut form, found);
        form.monitored = self.monitored(&form);
        if form.opportunity.is_none() {
            form.trigger = form.monitored.clone();
        }
        let mode = FailureMode {
            id,
            name: text.name,
            meaning: text.meaning,
            margin: found
                .keep(self.margin(text.margin))
                .unwrap_or(DEFAULT_MARGIN),
        };
        (mode, form)
    }

    fn check_new(&self, id: &Spanned<String>, before: &[SubjectForm]) -> Result<(), Problem> {
        match before.iter().find(|f| f.subject.id() == id.get_ref()) {
            None => Ok(()),
            Some(_) => Err(Problem::new(
                "duplicate-id",
                format!("`{}` is declared twice", id.get_ref()),
            )
            .at(self.source, id.span())
            .remedy("give each requirement and failure mode its own identifier")),
        }
    }
    /// The parameters that a requirement is held against: those named, and
    /// those of its sentence.
    fn declared(
        &self,
        named: Vec<Spanned<String>>,
        sentence: Option<&SentenceForm>,
    ) -> Result<Vec<String>, Problem> {
        let mut found = Problems::new();
        for name in &named {
            if self.parameters.values.get(name.get_ref()).is_none() {
                let known = self.parameters.declared.keys().map(String::as_str);
                let similar = did_you_mean(name.get_ref(), known);
                found.add(
                    Problem::new(
                        "unknown-parameter",
                        format!("`{}` is not declared in parameters.toml", name.get_ref()),
                    )
                    .at(self.source, name.span())
                    .remedy(match similar {
                        Some(similar) => format!("did you mean `{similar}`?"),
                        None => "declare it with a value and a meaning".into(),
                    }),
                );
            }
        }
        let mut all: Vec<String> = named.into_iter().map(Spanned::into_inner).collect();
        if let Some(sentence) = sentence {
            all.extend(sentence.parameters(self.vocabulary, self.parameters));
        }
        all.sort();
        all.dedup();
        found.or(all)
    }

    fn experiment(&self, name: Option<Spanned<String>>) -> Result<Option<String>, Problem> {
        let Some(name) = name else {
            return Ok(None);
        };
        let span = name.span();
        let proposition = self
            .vocabulary
            .proposition(name.get_ref(), self.source, span.clone())?;
        if proposition.column.is_none() {
            return Err(Problem::new(
                "unbound-proposition",
                format!(
                    "`{}` is not bound to a column of the experiments",
                    name.get_ref()
                ),
            )
            .at(self.source, span)
            .remedy(format!(
                "give [{}] a `column = \"…\"` in {}",
                name.get_ref(),
                self.vocabulary.source.name
            )));
        }
        Ok(Some(name.into_inner()))
    }

    fn readings(
        &self,
        texts: BTreeMap<String, ReadingText>,
        found: &mut Problems,
    ) -> Vec<ReadingForm> {
        let mut readings = Vec::new();
        for (name, text) in texts {
            let judging = JudgingText::new(
                text.monitor,
                text.formula,
                text.time,
                text.ending,
                text.clock,
                text.start_within_secs,
            );
            let Some(monitor) = found.keep(judging.compile(self.source, self.vocabulary)) else {
                continue;
            };
            let Some(monitor) = monitor else {
                found.add(
                    Problem::new(
                        "no-monitor",
                        format!("the reading `{name}` does not say how it judges traces"),
                    )
                    .at(self.source, text.meaning.span())
                    .remedy("give it a `monitor` or a `formula`"),
                );
                continue;
            };
            readings.push(ReadingForm {
                name,
                meaning: text.meaning.into_inner(),
                monitor,
            });
        }
        readings
    }

    /// Checks that the labels of the property are propositions with a binding
    /// to the model, and leaves out those that are not. Its syntax is checked with the model, which gives types.
    fn check_property(&self, form: &mut SubjectForm, found: &mut Problems) {
        for written in [&mut form.property, &mut form.opportunity] {
            let by_hand = written.as_ref().filter(|text| !text.from_sentence);
            let checked = by_hand.map_or(Ok(()), |text| self.check_property_text(text));
            if found.keep(checked).is_none() {
                *written = None;
            }
        }
    }

    /// Checks a property's text, and that its propositions are bound to models.
    pub(super) fn check_property_text(&self, text: &FormText) -> Result<(), Problem> {
        let parsed = prism_lang::parse_properties(&text.text);
        if let Some(problem) = self.shifted(text, &parsed.diagnostics) {
            return Err(problem);
        }
        let mut found = Problems::new();
        for (name, span) in quoted_names(&text.text) {
            let place = text.span.start + span.start..text.span.start + span.end;
            let proposition = self
                .vocabulary
                .proposition(&name, self.source, place.clone());
            if found.keep(proposition).is_some_and(|it| it.model.is_none()) {
                found.add(
                    Problem::new(
                        "unbound-proposition",
                        format!("the property uses \"{name}\", which is not bound to the model"),
                    )
                    .at(self.source, place)
                    .remedy(format!(
                        "give [{name}] a `model = \"…\"` in {}",
                        self.vocabulary.source.name
                    )),
                );
            }
        }
        found.or(())
    }

    /// Diagnostics of a property inside this file, at their place in the file.
    fn shifted(&self, text: &FormText, diagnostics: &[prism_lang::Diagnostic]) -> Option<Problem> {
        let shifted: Vec<_> = diagnostics
            .iter()
            .map(|d| {
                let mut d = d.clone();
                d.span = prism_lang::Span::new(
                    d.span.start + text.span.start,
                    d.span.end + text.span.start,
                );
                d.related.clear();
                d
            })
            .collect();
        crate::placed::from_diagnostics(self.source, &shifted)
    }
}

pub(super) fn form_text(text: Spanned<String>) -> FormText {
    let span = text.span();
    FormText {
        text: text.into_inner(),
        span: span.start + 1..span.end.saturating_sub(1).max(span.start + 1),
        from_sentence: false,
    }
}

/// The labels that a property names, `"like_this"`, with their places.
pub fn quoted_names(text: &str) -> Vec<(String, Range<usize>)> {
    let mut names = Vec::new();
    let mut from = 0;
    while let Some(open) = text[from..].find('"').map(|at| from + at) {
        let Some(close) = text[open + 1..].find('"').map(|at| open + 1 + at) else {
            break;
        };
        let name = &text[open + 1..close];
        // PRISM's own labels are not propositions of the study.
        if name != "init" && name != "deadlock" {
            names.push((name.to_owned(), open + 1..close));
        }
        from = close + 1;
    }
    names
}
/// A monitor in words, for reports.
fn in_words(form: &JudgingForm) -> String {
    let spec = match &form.rule {
        Rule::Staged(spec) => spec,
        Rule::Formula(formula) => return formula.text.clone(),
    };
    let stages: Vec<String> = spec.then.iter().map(stage_in_words).collect();
    format!("when {}: {}", spec.when, stages.join("; then "))
}

fn stage_in_words(stage: &Stage) -> String {
    let within = |limit: &Option<f64>| match limit {
        Some(secs) => format!(" within {secs} s"),
        None => String::new(),
    };
    match stage {
        Stage::Assert { proposition } => format!("{proposition} holds"),
        Stage::WaitFor {
            proposition,
            within_secs,
        } => format!("wait for {proposition}{}", within(within_secs)),
        Stage::Hold {
            proposition,
            until,
            within_secs,
        } => format!("{proposition} holds until {until}{}", within(within_secs)),
    }
}
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_found_with_their_places() {
        let text = r#"P=? [ F ("a" & "b") | "deadlock" ]"#;
        let names = quoted_names(text);
        assert_eq!(names.len(), 2);
        for (name, span) in names {
            assert_eq!(&text[span], name);
        }
    }
}
