//! Requirements and failure modes: what is asked, and the forms in which each
//! technique asks it.

mod carried;
mod durations;
mod read;
mod stated;
mod threshold;
mod trigger;

use super::judging_form::{JudgingForm, Rule};
use super::sentence_form::SentenceForm;
use diagnostic::{Problem, Source};
use evidence::Subject;
use std::ops::Range;

pub(crate) use read::schema;
pub use read::{load, quoted_names};
pub use trigger::{TriggerForm, text_in_words};

/// How every subject is judged.
#[derive(Debug)]
pub struct Forms {
    /// The file, for diagnostics.
    pub source: Source,
    /// Requirements in the order of the file, then failure modes.
    pub subjects: Vec<SubjectForm>,
}

impl Forms {
    /// The forms of a subject.
    pub fn of(&self, subject: &Subject) -> Option<&SubjectForm> {
        self.subjects.iter().find(|form| &form.subject == subject)
    }

    /// Where a text stands among the forms of a subject; its identifier where that cannot be told.
    pub fn place_of(&self, subject: &Subject, text: &str) -> Option<Range<usize>> {
        let file = &self.source.text;
        let id = self.of(subject)?.span.clone();
        let begin = file.get(..id.start)?.rfind("[[").unwrap_or(id.start);
        let rest = file.get(id.end..)?;
        let next = ["\n[[requirement]]", "\n[[failure_mode]]"];
        let next = next.iter().filter_map(|header| rest.find(header)).min();
        let end = next.map_or(file.len(), |at| id.end + at);
        let found = file.get(begin..end)?.find(text);
        Some(match found.filter(|_| !text.is_empty()) {
            Some(at) => begin + at..begin + at + text.len(),
            None => id,
        })
    }

    /// The subject with this identifier, requirement or failure mode.
    pub fn by_id(&self, id: &str) -> Option<&SubjectForm> {
        self.subjects.iter().find(|form| form.subject.id() == id)
    }

    /// What has a meaning that is perhaps not meant, in the forms of those
    /// with the identifiers `only`, or of all if there are none.
    pub fn warnings(&self, only: &[String]) -> Vec<Problem> {
        let mut found: Vec<Problem> = Vec::new();
        for form in &self.subjects {
            let id = form.subject.id();
            if !only.is_empty() && !only.iter().any(|wanted| wanted == id) {
                continue;
            }
            for warning in form.warnings(&self.source) {
                // Requirements that differ in their threshold share their forms.
                let line = warning.warning_line();
                if found.iter().all(|other| other.warning_line() != line) {
                    found.push(warning);
                }
            }
        }
        found
    }
}

/// Where a requirement comes from, as the tool that manages requirements has it. Nothing is judged by it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Background {
    /// Why it is asked for.
    pub rationale: String,
    /// How far it is.
    pub status: String,
    /// The ids of the requirements that it was derived from.
    pub parents: Vec<String>,
}

/// How one subject is judged by each technique.
#[derive(Clone, Debug)]
pub struct SubjectForm {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// Its place in the file.
    pub span: Range<usize>,
    /// The requirement in structured English, with what is made from it.
    pub sentence: Option<SentenceForm>,
    /// For the model checker: what is asked, as written or else from the
    /// sentence.
    pub property: Option<FormText>,
    /// Why there is no property, if the sentence cannot be made into one.
    pub no_property: Option<String>,
    /// For failure modes: the probability of an opportunity, by which the
    /// property's is divided.
    pub opportunity: Option<FormText>,
    /// What triggers it in a model, so that the property's probability is given that.
    pub trigger: TriggerForm,
    /// What triggers its monitor, as the same question to a model: what [`SubjectForm::trigger`] is where nobody wrote one.
    pub monitored: TriggerForm,
    /// For traces, as written or else from the sentence.
    pub monitor: Option<JudgingForm>,
    /// Why there is no monitor, if the sentence cannot be made into one.
    pub no_monitor: Option<String>,
    /// The declared parameters that its forms are held against.
    pub parameters: Vec<String>,
    /// Other readings of the same text, for traces.
    pub readings: Vec<ReadingForm>,
    /// The proposition whose column of the experiments' table counts it.
    pub experiment: Option<String>,
    /// The places of the declarations of what carries over to it.
    pub carried_at: Vec<Range<usize>>,
    /// Where it comes from.
    pub background: Background,
    /// That its text states another rate than its threshold.
    other_rate: Option<Problem>,
    /// That its margin is very wide.
    wide_margin: Option<Problem>,
    /// That its text states another time than its sentence.
    other_duration: Option<Problem>,
}

impl SubjectForm {
    /// That its text states another rate or time than it is judged by, a sentence for each.
    #[must_use]
    pub fn text_differs(&self) -> Vec<String> {
        let both = [&self.other_rate, &self.other_duration];
        let said = both.into_iter().flatten();
        said.map(|it| format!("Of its wording: {}.", it.message()))
            .collect()
    }

    /// What has a meaning that is perhaps not meant.
    fn warnings(&self, source: &Source) -> Vec<Problem> {
        let sentence = self.sentence.as_ref();
        let mut found = sentence.map_or_else(Vec::new, |sentence| sentence.warnings.clone());
        found.extend(self.other_rate.clone());
        found.extend(self.wide_margin.clone());
        found.extend(self.other_duration.clone());
        let said = found.iter().any(|warning| warning.code == "exact-instant");
        let main = self.monitor.iter();
        let judging = main.chain(self.readings.iter().map(|reading| &reading.monitor));
        for form in judging {
            if let Rule::Formula(rule) = &form.rule
                && !(said && form.from_sentence)
            {
                let place = sentence.map_or(&self.span, |sentence| &sentence.span);
                found.extend(rule.warning(source, place));
            }
        }
        found
    }

    /// Takes from the sentence the forms that are not written by hand.
    fn complete_from_sentence(&mut self) {
        let Some(sentence) = &self.sentence else {
            return;
        };
        if self.monitor.is_none() {
            match &sentence.monitor {
                Ok(monitor) => self.monitor = Some(monitor.clone()),
                Err(reason) => self.no_monitor = Some(reason.clone()),
            }
        }
        if self.property.is_none() {
            match &sentence.property {
                Ok(property) => {
                    self.property = Some(FormText {
                        text: property.query(),
                        span: sentence.span.clone(),
                        from_sentence: true,
                    });
                }
                Err(reason) => self.no_property = Some(reason.clone()),
            }
        }
    }
}

/// Another reading of a requirement.
#[derive(Clone, Debug)]
pub struct ReadingForm {
    /// Its short name.
    pub name: String,
    /// How it differs.
    pub meaning: String,
    /// Its monitor.
    pub monitor: JudgingForm,
}

/// A property's text and its place.
#[derive(Clone, Debug)]
pub struct FormText {
    /// The text.
    pub text: String,
    /// Its place in the requirements' source, without the quotes.
    pub span: Range<usize>,
    /// Whether it was made from the requirement's sentence.
    pub from_sentence: bool,
}
