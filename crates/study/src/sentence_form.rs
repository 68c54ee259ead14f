//! A requirement's sentence, and the forms that are made from it: the property,
//! the monitor, the test goals and the coverage bins.
//!
//! What a form cannot express is kept as the reason, never left out silently.

use super::judging_form::{FormulaRule, JudgingForm, JudgingText, Rule, is_name};
use super::{StudyParameters, Vocabulary};
use diagnostic::{Problem, Source, did_you_mean};
use requirement_lang::compile::coverage::{Bin, bins};
use requirement_lang::compile::goal::{
    ModelGoal, TraceGoal, model_goal, trace_goal, trigger_probability,
};
use requirement_lang::compile::monitor::{Monitor, monitor};
use requirement_lang::compile::property::{Model, Property, property};
use requirement_lang::sentence::{Amount, Duration, Sentence, Stage, Timing};
use requirement_lang::{Context, Diagnostic, Explanation, explain, library, parse};
use std::ops::Range;
use temporal::formula::TimeModel;
use toml::Spanned;

/// A sentence and what was made from it; an `Err` says why a form is missing.
#[derive(Clone, Debug)]
pub struct SentenceForm {
    /// The sentence, verbatim.
    pub text: String,
    /// Its place in the requirements' file, without the quotes.
    pub span: Range<usize>,
    /// What was understood.
    pub tree: Sentence,
    /// For traces.
    pub monitor: Result<JudgingForm, String>,
    /// For the model checker.
    pub property: Result<Property, String>,
    /// For a test generator that searches the model.
    pub model_goal: Result<ModelGoal, String>,
    /// The property that asks for the probability of its trigger.
    pub trigger: Result<String, String>,
    /// For a test generator that simulates.
    pub trace_goal: Result<TraceGoal, String>,
    /// What a campaign of tests should have seen.
    pub bins: Result<Vec<Bin>, String>,
    /// Propositions without a column in the experiments' tables.
    pub not_in_experiments: Vec<String>,
    /// What has a meaning that is perhaps not meant.
    pub warnings: Vec<Problem>,
}

/// What sentences are read with.
#[derive(Clone, Copy, Debug)]
pub struct SentenceReader<'a> {
    /// The requirements' file.
    pub source: &'a Source,
    /// The propositions.
    pub vocabulary: &'a Vocabulary,
    /// The parameters.
    pub parameters: &'a StudyParameters,
    /// The duration of a step of the formal models, in seconds.
    pub step_secs: Option<f64>,
}

impl SentenceReader<'_> {
    /// Reads a sentence and makes its forms; `judging` says how traces are to
    /// be read.
    pub fn read(
        &self,
        text: Spanned<String>,
        judging: &JudgingText,
    ) -> Result<SentenceForm, Problem> {
        let span = text.span().start + 1..text.span().end.saturating_sub(1);
        let text = text.into_inner();
        let (tree, warnings) = self.parse(&text, span.start)?;
        Ok(SentenceForm {
            warnings,
            ..self.forms(text, tree, span, judging)
        })
    }

    /// The sentence of a template of the library, whose parameters the study
    /// has declared.
    pub fn of_library(
        &self,
        id: &Spanned<String>,
        judging: &JudgingText,
    ) -> Result<SentenceForm, Problem> {
        let span = id.span();
        let Some(template) = library::template(id.get_ref()) else {
            let known = library::templates().map(|template| template.id);
            let problem = Problem::new(
                "unknown-template",
                format!("the library has no requirement `{}`", id.get_ref()),
            )
            .at(self.source, span);
            return Err(match did_you_mean(id.get_ref(), known) {
                Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
                None => problem.remedy("`corroborate requirements --library` lists them"),
            });
        };
        let mut values = Vec::new();
        for declaration in template.parameters {
            match self.parameters.declared.get(declaration.name) {
                Some(parameter) => values.push((declaration.name, parameter.text.as_str())),
                None => return Err(self.undeclared(template, declaration, span)),
            }
        }
        let instance = template.instantiate(&values).map_err(|error| {
            Problem::new("bad-parameter", error.to_string())
                .at(self.source, span.clone())
                .remedy("correct the value in parameters.toml")
        })?;
        for need in template.needs {
            self.vocabulary
                .proposition(need.name, self.source, span.clone())?;
        }
        let text = instance.text.to_owned();
        Ok(self.forms(text, instance.sentence, span, judging))
    }

    fn undeclared(
        &self,
        template: &library::Template,
        declaration: &library::Declaration,
        span: Range<usize>,
    ) -> Problem {
        let value = declaration.default.unwrap_or(declaration.least);
        Problem::new(
            "unknown-parameter",
            format!(
                "the requirement `{}` needs the parameter `{}`: {}",
                template.id, declaration.name, declaration.meaning
            ),
        )
        .at(self.source, span)
        .remedy(format!(
            "declare it in parameters.toml: [{}] value = \"{value}\"",
            declaration.name
        ))
    }

    /// The forms of a sentence that was understood.
    fn forms(
        &self,
        text: String,
        tree: Sentence,
        span: Range<usize>,
        judging: &JudgingText,
    ) -> SentenceForm {
        let proposition = |text: &str| self.in_model(text);
        let model = Model {
            step_secs: self.step_secs,
            proposition: &proposition,
        };
        let unbound = self.unbound(&tree, |p| p.trace.is_some());
        let monitor = match unbound.first() {
            Some(name) => Err(format!("`{name}` is not bound to traces")),
            None => monitor(&tree)
                .map(|monitor| {
                    let time = judging.time().unwrap_or_else(|| time_of(&tree, &monitor));
                    let rule = FormulaRule::of_sentence(monitor, time, judging.ending());
                    JudgingForm {
                        rule: Rule::Formula(rule),
                        clock: judging.clock(),
                        start_within_secs: judging.start_within_secs(),
                        from_sentence: true,
                    }
                })
                .map_err(|reason| reason.to_string()),
        };
        SentenceForm {
            monitor,
            property: property(&tree, &model).map_err(|reason| reason.to_string()),
            model_goal: model_goal(&tree, &model).map_err(|reason| reason.to_string()),
            trigger: trigger_probability(&tree, &model).map_err(|reason| reason.to_string()),
            trace_goal: trace_goal(&tree).map_err(|reason| reason.to_string()),
            bins: bins(&tree).map_err(|reason| reason.to_string()),
            not_in_experiments: self.unbound(&tree, |p| p.column.is_some()),
            warnings: Vec::new(),
            text,
            span,
            tree,
        }
    }

    /// The sentence, and what has a meaning that is perhaps not meant.
    fn parse(&self, text: &str, start: usize) -> Result<(Sentence, Vec<Problem>), Problem> {
        let names: Vec<&str> = self
            .vocabulary
            .propositions
            .keys()
            .map(String::as_str)
            .collect();
        let context = Context {
            parameters: Some(&self.parameters.values),
            vocabulary: Some(&names),
        };
        let parsed = parse(text, &context);
        let failed = parsed.has_errors();
        let found = parsed.diagnostics.into_iter();
        let problems = found.map(|found| self.problem(found, start));
        if !failed {
            return Ok((parsed.tree, problems.collect()));
        }
        Err(Problem::all(problems)
            .unwrap_or_else(|| Problem::new("bad-sentence", "the sentence could not be read")))
    }

    /// A diagnostic of a sentence that begins at `start` in its file.
    fn problem(&self, found: Diagnostic, start: usize) -> Problem {
        let span = start + found.span.start..start + found.span.end;
        let problem = Problem::new(found.code, found.message).at(self.source, span);
        match found.remedy {
            Some(remedy) => problem.remedy(remedy),
            None => problem,
        }
    }

    /// The model's text for an atom of a sentence.
    fn in_model(&self, text: &str) -> Option<String> {
        let proposition = self.vocabulary.propositions.get(text)?;
        proposition.model.as_ref().map(|_| format!("\"{text}\""))
    }

    /// The propositions of a sentence that lack a binding.
    fn unbound(
        &self,
        tree: &Sentence,
        bound: impl Fn(&super::vocabulary::Proposition) -> bool,
    ) -> Vec<String> {
        let names = tree.propositions().into_iter().filter(|text| is_name(text));
        names
            .filter(|name| {
                let proposition = self.vocabulary.propositions.get(*name);
                proposition.is_some_and(|p| !bound(p))
            })
            .map(str::to_owned)
            .collect()
    }
}

/// The time in which a sentence is judged where none is written: discrete,
/// unless a stage begins some seconds after the one before, when its `for` is
/// over. Then a recording need not have a sample, but signals keep their
/// values. `after` is left as it is: that what holds exactly then does not
/// hold before can only be seen where there is a sample.
fn time_of(sentence: &Sentence, monitor: &Monitor) -> TimeModel {
    let is_secs = |duration: &Duration| matches!(duration.amount, Amount::Secs(_));
    let (_, earlier) = sentence.stages.split_last().unzip();
    let earlier: &[Stage] = earlier.unwrap_or_default();
    let waits = |stage: &Stage| matches!(&stage.timing, Timing::For(d) if is_secs(d));
    let needs_sample = |stage: &Stage| matches!(&stage.timing, Timing::After(d) if is_secs(d));
    if earlier.iter().any(waits)
        && !sentence.stages.iter().any(needs_sample)
        && !monitor.needs_discrete_time()
    {
        TimeModel::Dense
    } else {
        TimeModel::Discrete
    }
}

impl SentenceForm {
    /// What was understood, in words and as a drawing.
    pub fn explanation(&self) -> Explanation {
        explain(&self.tree)
    }

    /// The parameters that it uses, directly or through the vocabulary.
    pub fn parameters(&self, vocabulary: &Vocabulary, parameters: &StudyParameters) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for stage in &self.tree.stages {
            let duration = stage.timing.duration();
            names.extend(duration.map(|duration| duration.text.clone()));
        }
        for text in self.tree.propositions() {
            if let Ok(predicate) = vocabulary.signals.predicate(text) {
                let constants = predicate.constants().into_iter();
                names.extend(constants.filter_map(|constant| constant.parameter));
            }
        }
        names.retain(|name| parameters.values.get(name).is_some());
        names
    }
}
