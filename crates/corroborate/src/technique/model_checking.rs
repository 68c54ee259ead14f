//! Model checking: the study's properties on one formal model.
//!
//! Everything is compiled before anything runs: [`Compiled::new`] finds the
//! errors of the model, of the vocabulary's bindings and of the properties,
//! each at its place in the user's files. A proposition that this model cannot
//! express (because it has no such variable or constant) is no error: the
//! subjects that need it are reported as not expressible.
//!
//! The uncertainty of constants that were set to counts is carried through in
//! `uncertainty`.

mod answer;
mod at_constants;
mod functions;
mod given;
mod idle_commands;
mod never;
mod point_values;
mod robust;
mod schedulers;
mod solved;
mod uncertainty;
mod unexpressed;
mod vacuity;
mod worst_case;

pub use unexpressed::Unexpressed;
pub use worst_case::{in_lines as worst_cases_in_lines, tests as worst_case_tests};

use given::{Asked, Over};

use super::counted::CountedConstant;
use super::files::Files;
use super::{Produced, Propositions};
use checker::state_space::StateSpace;
use diagnostic::{Problem, Source};
use evidence::{AssetRole, Cost, Denominator, Finding, Measure, Subject, Tool};
use host::store::Inputs;
use host::{Cancel, Stage};
use prism_lang::ast::Optimum;
use prism_lang::property::Quantity;
use prism_lang::{Constants, Diagnostic, Number, Property, Rational, Value, resolved};
use query::explore;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::Instant;
use study::{FormText, Method, Study, TriggerForm, quoted_names};

/// The most states that a model of a study may have: about 2 GB of memory.
const MAX_STATES: usize = 20_000_000;

/// Of a path no more steps are shown.
const MAX_STEPS_SHOWN: usize = 100;

/// A model and the study's questions to it.
#[derive(Debug)]
pub struct Compiled<'a> {
    study: &'a Study,
    source: Source,
    /// That its letters had to be guessed, if so.
    guessed: Option<Problem>,
    tree: prism_lang::ast::Model,
    model: resolved::Model,
    questions: Vec<Question<'a>>,
    /// Propositions that this model expresses.
    pub expressed: BTreeSet<&'a str>,
    /// Propositions that it does not express, with what is missing.
    pub not_expressed: BTreeMap<&'a str, String>,
}

/// What is asked about one subject.
#[derive(Debug)]
struct Question<'a> {
    subject: &'a Subject,
    property: &'a FormText,
    /// Over which runs it is asked.
    over: Over,
    /// Whether the model leaves choices open, so that the answer is a range over all schedulers.
    has_choices: bool,
    /// Why this model cannot be asked, if so.
    missing: Option<String>,
    /// Whether it knows nothing of the situation that is asked about, so that it excludes nothing there.
    is_outside: bool,
}

/// A computed rate that is nearer to 0 or 1 may be that of a property which has one truth value on all runs.
const NEARLY_CERTAIN: f64 = 1e-6;

/// What a property amounts to that no command of the model can make false, or true.
const NO_EVIDENCE: &str = "so the model is not evidence about it; if it should be, look at the property, at what its words mean in the \
                           model, and at the model's first state";

/// The findings on which a model says nothing, as what its property says holds whatever it does: a line for each.
pub fn said_of_nothing(produced: &Produced) -> Vec<String> {
    let lines = produced.findings.iter().filter_map(|finding| {
        let Measure::NotCovered {
            reason,
            constant: Some(_),
        } = &finding.measure
        else {
            return None;
        };
        Some(format!("{}: {reason}", finding.subject.in_words()))
    });
    lines.collect()
}

impl<'a> Compiled<'a> {
    /// Which propositions it expresses.
    pub fn propositions(&self) -> Propositions<'_> {
        Propositions {
            expressed: &self.expressed,
            not_expressed: &self.not_expressed,
        }
    }

    /// Reads a model and binds the study's questions to it.
    pub fn new(study: &'a Study, path: &Path) -> Result<Self, Problem> {
        Self::read(study, path, &Files::of_study(study))
    }

    /// The same, with the model read through `files`.
    pub(crate) fn read(study: &'a Study, path: &Path, files: &Files<'_>) -> Result<Self, Problem> {
        let (source, guessed) = files.prism(AssetRole::SystemModel, path)?;
        Ok(Self {
            guessed,
            ..Self::of_source(study, source)?
        })
    }

    /// Binds the study's questions to a model's text.
    pub fn of_source(study: &'a Study, source: Source) -> Result<Self, Problem> {
        let parsed = prism_lang::parse_model(&source.text);
        if let Some(problem) = study::placed::from_diagnostics(&source, &parsed.diagnostics) {
            return Err(problem);
        }
        let model = prism_lang::resolve(&parsed.tree, &Constants::new())
            .map_err(|found| input_problem(&source, &found))?;
        let mut compiled = Self {
            study,
            source,
            guessed: None,
            tree: parsed.tree,
            model,
            questions: Vec::new(),
            expressed: BTreeSet::new(),
            not_expressed: BTreeMap::new(),
        };
        for (name, proposition) in &study.vocabulary.propositions {
            if let Some(binding) = &proposition.model {
                compiled.express(name, &binding.text, binding.span.start)?;
            }
        }
        compiled.questions = compiled.bind_questions()?;
        Ok(compiled)
    }

    /// Finds out whether the model can express a proposition.
    fn express(&mut self, name: &'a str, text: &str, place: usize) -> Result<(), Problem> {
        let vocabulary = &self.study.vocabulary.source;
        let prefix = format!("label \"{name}\" = ");
        let parsed = prism_lang::parse_properties(&format!("{prefix}{text};\n\"{name}\""));
        let shift = |d: &Diagnostic| shifted(d, prefix.len(), place, text.len());
        let found: Vec<_> = parsed.diagnostics.iter().map(shift).collect();
        if let Some(problem) = study::placed::from_diagnostics(vocabulary, &found) {
            return Err(problem);
        }
        let resolved = prism_lang::resolve_properties(&parsed.tree, &self.model, &Constants::new());
        match resolved {
            Ok(_) => {
                self.expressed.insert(name);
            }
            Err(found) if found.iter().all(|d| d.code == "unknown-name") => {
                // A name that is nearly one of the model's is a slip, not an abstraction.
                let words = |d: &Diagnostic| {
                    let message = d.message.trim_end_matches('.');
                    match d.remedy.as_deref().and_then(|it| it.strip_prefix('D')) {
                        Some(meant) if meant.starts_with("id you mean") => {
                            format!("{message} (d{meant})")
                        }
                        _ => message.to_owned(),
                    }
                };
                let words: Vec<_> = found.iter().map(words).collect();
                self.not_expressed.insert(name, words.join("; "));
            }
            Err(found) => {
                let found: Vec<_> = found.iter().map(shift).collect();
                return Err(input_problem(vocabulary, &found));
            }
        }
        Ok(())
    }

    fn bind_questions(&self) -> Result<Vec<Question<'a>>, Problem> {
        let study = self.study;
        let mut questions = Vec::new();
        for form in &study.forms.subjects {
            let Some(property) = &form.property else {
                continue;
            };
            let texts = [Some(property), form.opportunity.as_ref()];
            let unknown = |text: &FormText| {
                let mut names = quoted_names(&text.text).into_iter();
                names.find_map(|(name, _)| self.not_expressed.get(name.as_str()))
            };
            let outside = form.opportunity.as_ref().and_then(unknown);
            let missing = match outside {
                Some(reason) => Some(("The model does not speak of its opportunity", reason)),
                None => unknown(property).map(|reason| ("The model does not express it", reason)),
            };
            let missing = missing.map(|(what, reason)| {
                let reason = reason.trim_end_matches('.');
                format!("{what}: {reason}.")
            });
            if missing.is_none() {
                for text in texts.into_iter().flatten() {
                    self.property(&self.model, text)?;
                }
            }
            let over = match (&missing, &form.opportunity) {
                (None, None) => {
                    self.over(&form.subject, property, &form.trigger, &form.monitored)?
                }
                // A failure mode's opportunity is what triggers it.
                (None, Some(opportunity)) => {
                    let trigger = TriggerForm::Runs(opportunity.clone());
                    self.over(&form.subject, property, &trigger, &form.monitored)?
                }
                (Some(_), _) => Over::EveryRun,
            };
            questions.push(Question {
                subject: &form.subject,
                property,
                over,
                has_choices: self.model.model_type.has_choices(),
                missing,
                is_outside: outside.is_some(),
            });
        }
        Ok(questions)
    }

    /// What was found, or that it is no more than what the property says of all runs that count, whatever the model's
    /// commands do.
    fn unless_it_says_nothing(
        &self,
        question: &Question<'_>,
        asked: Asked,
    ) -> Result<Asked, Problem> {
        let may_be_constant = |rate: f64| rate.min(1.0 - rate) < NEARLY_CERTAIN;
        if !asked.measure.estimate().is_some_and(may_be_constant) {
            return Ok(asked);
        }
        let bound = |text: &FormText| self.property(&self.model, text);
        let condition = question.given().map(|given| bound(&given.trigger));
        let property = bound(question.property)?;
        let condition = condition.transpose()?;
        let truth = vacuity::constant_truth(&property, condition.as_ref(), &self.model);
        Ok(truth.map_or(asked, |truth| Asked {
            measure: Measure::NotCovered {
                reason: format!(
                    "Its property is {truth} of each run that counts, whatever the model's commands do, {NO_EVIDENCE}."
                ),
                constant: Some(truth),
            },
            denominator: Denominator::default(),
            trigger: None,
        }))
    }

    /// A property with the vocabulary's propositions as labels, bound to a
    /// model.
    ///
    /// Of a model with choices, the least probability over all schedulers.
    fn property(&self, model: &resolved::Model, text: &FormText) -> Result<Property, Problem> {
        self.property_over(model, text, Optimum::Min)
    }

    /// The same, of a model with choices the least or the greatest probability.
    fn property_over(
        &self,
        model: &resolved::Model,
        text: &FormText,
        optimum: Optimum,
    ) -> Result<Property, Problem> {
        let text = &match model.model_type.has_choices() {
            true => schedulers::with_optimum(text, optimum),
            false => text.clone(),
        };
        let mut whole = String::new();
        let names: BTreeSet<_> = quoted_names(&text.text)
            .into_iter()
            .map(|(n, _)| n)
            .collect();
        for name in names {
            let proposition = self.study.vocabulary.propositions.get(&name);
            if let Some(binding) = proposition.and_then(|p| p.model.as_ref()) {
                whole.push_str(&format!("label \"{name}\" = {};\n", binding.text));
            }
        }
        let prefix = whole.len();
        whole.push_str(&text.text);
        let source = &self.study.forms.source;
        let shift = |d: &Diagnostic| shifted(d, prefix, text.span.start, text.text.len());
        let parsed = prism_lang::parse_properties(&whole);
        let resolved = parsed
            .into_result()
            .and_then(|tree| prism_lang::resolve_properties(&tree, model, &Constants::new()));
        let mut properties = resolved.map_err(|found| {
            let found: Vec<_> = found.iter().map(shift).collect();
            input_problem(source, &found)
        })?;
        match properties.pop().map(|p| p.property) {
            Some(property @ Property::Probability { bound: None, .. }) => Ok(property),
            Some(
                property @ Property::Number(
                    Quantity::Probability { .. } | Quantity::Conditional { .. },
                ),
            ) => Ok(property),
            _ => Err(Problem::new(
                "not-a-probability",
                "a requirement's property must ask for a probability",
            )
            .at(source, text.span.clone())
            .remedy("write `P=? [ … ]`, and the bound as `threshold = \"at least …\"`")),
        }
    }

    /// Answers all questions, by all methods, and carries the uncertainty of
    /// counted constants through.
    pub fn produce(
        &self,
        id: &str,
        methods: &[Method],
        counted: &[CountedConstant],
        interrupt: &Cancel,
        begin: &dyn Fn(&str, u64) -> Stage,
    ) -> Result<Produced, Problem> {
        let began = Instant::now();
        let cancel = || interrupt.is_cancelled();
        let space = explore::<f64>(&self.source, &self.model, MAX_STATES, &cancel)?;
        let exact_space = if methods.contains(&Method::Exact) {
            Some(explore::<Rational>(
                &self.source,
                &self.model,
                MAX_STATES,
                &cancel,
            )?)
        } else {
            None
        };
        let mut findings = Vec::new();
        for question in &self.questions {
            let asked = match &question.missing {
                Some(reason) => Asked {
                    measure: match question.is_outside {
                        true => Measure::NotCovered {
                            reason: reason.clone(),
                            constant: None,
                        },
                        false => Measure::NotExpressible {
                            reason: reason.clone(),
                        },
                    },
                    denominator: Denominator::default(),
                    trigger: None,
                },
                None => match self.ask(question, methods, &space, exact_space.as_ref(), &cancel) {
                    Ok(asked) => self.unless_it_says_nothing(question, asked)?,
                    Err(problem) => self.unless_it_was_derived(question, problem)?,
                },
            };
            findings.push(Finding {
                subject: question.subject.clone(),
                measure: asked.measure,
                denominator: asked.denominator,
                trigger: asked.trigger,
                undecided: 0,
                left_out: 0,
                completions: None,
                witnesses: Vec::new(),
                readings: Vec::new(),
            });
        }
        self.say_what_is_missing(&mut findings);
        self.add_worst_cases(id, &space, &mut findings, &cancel)?;
        let (held, varied): (Vec<_>, Vec<_>) = counted.iter().cloned().partition(|c| c.held);
        if !varied.is_empty() {
            let varied = (&varied[..], space.num_states());
            self.carry_uncertainty(id, varied, &mut findings, interrupt, begin)?;
        }
        self.say_what_is_held_at_zero(&held, &mut findings, &cancel)?;
        let influences = self.influences(&held, &cancel)?;
        let cost = Cost {
            evidence: id.to_owned(),
            wall_secs: began.elapsed().as_secs_f64(),
            states: Some(space.num_states() as u64),
            transitions: Some(space.num_transitions() as u64),
            ..Cost::default()
        };
        Ok(Produced {
            tool: tool(methods),
            findings,
            form_differences: Vec::new(),
            description_gaps: Vec::new(),
            failures: Vec::new(),
            clusters: None,
            alike_trials: None,
            repeated_recordings: Vec::new(),
            findings_once: Vec::new(),
            influences,
            cost,
        })
    }

    /// That a model cannot be asked what a sentence says is no mistake of the study's: who wrote the sentence wrote no property
    /// for this model.
    fn unless_it_was_derived(
        &self,
        question: &Question,
        problem: Problem,
    ) -> Result<Asked, Problem> {
        match self
            .derived(question)
            .filter(|_| given::is_refused(&problem))
        {
            None => Err(problem),
            Some(property) => Ok(Asked {
                measure: Measure::NotExpressible {
                    reason: format!(
                        "This model cannot be asked what its sentence says (`{}`): {}. A `property` written for the model can be asked.",
                        property.text,
                        problem.message()
                    ),
                },
                denominator: Denominator::default(),
                trigger: None,
            }),
        }
    }

    /// The property of a question, if it follows from a sentence.
    fn derived(&self, question: &Question) -> Option<&FormText> {
        let form = self.study.forms.of(question.subject)?;
        form.property.as_ref().filter(|it| it.from_sentence)
    }

    /// A value of a question; `None` where the model cannot be asked what its sentence says, as when evidence is made.
    fn unless_refused<T>(
        &self,
        question: &Question,
        value: Result<T, Problem>,
    ) -> Result<Option<T>, Problem> {
        match value {
            Err(problem) if given::is_refused(&problem) && self.derived(question).is_some() => {
                Ok(None)
            }
            value => value.map(Some),
        }
    }

    /// Requirements without a property are not expressible by any model.
    fn say_what_is_missing(&self, findings: &mut Vec<Finding>) {
        for form in &self.study.forms.subjects {
            if form.property.is_none() {
                findings.push(Finding {
                    subject: form.subject.clone(),
                    measure: Measure::NotExpressible {
                        reason: match &form.no_property {
                            Some(reason) => {
                                format!("Its sentence has no logical property: {reason}.")
                            }
                            None => {
                                "It has no logical property: the formal model does not express it."
                                    .into()
                            }
                        },
                    },
                    denominator: Denominator::default(),
                    trigger: None,
                    undecided: 0,
                    left_out: 0,
                    completions: None,
                    witnesses: Vec::new(),
                    readings: Vec::new(),
                });
            }
        }
    }

    fn ask(
        &self,
        question: &Question,
        methods: &[Method],
        space: &StateSpace<f64>,
        exact_space: Option<&StateSpace<Rational>>,
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Asked, Problem> {
        question.ask(methods.len(), &|method, text| {
            let end = |optimum| {
                let property = self.property_over(&self.model, text, optimum)?;
                answer::answer(&property, methods[method], space, exact_space, cancel)
                    .map_err(|problem| problem.at(&self.study.forms.source, text.span.clone()))
            };
            match question.has_choices {
                false => end(Optimum::Min),
                true => {
                    let ends = (end(Optimum::Min)?, end(Optimum::Max)?);
                    Ok(schedulers::range(question.subject, ends))
                }
            }
        })
    }

    /// What the answers depend on: the model, the questions and the bindings
    /// that they use.
    pub fn inputs(&self, inputs: &mut Inputs) {
        inputs.add("model", self.source.text.as_bytes());
        for question in &self.questions {
            inputs.add("subject", question.subject.id().as_bytes());
            question.over.inputs(inputs);
            for text in [
                Some(question.property),
                question.given().map(|given| &given.trigger),
                question.monitored(),
            ]
            .into_iter()
            .flatten()
            {
                inputs.add("property", text.text.as_bytes());
                for (name, _) in quoted_names(&text.text) {
                    let proposition = self.study.vocabulary.propositions.get(&name);
                    if let Some(binding) = proposition.and_then(|p| p.model.as_ref()) {
                        inputs.add(&name, binding.text.as_bytes());
                    }
                }
            }
        }
        self.inputs_of_worst_cases(inputs);
        let unasked = self
            .study
            .forms
            .subjects
            .iter()
            .filter(|f| f.property.is_none());
        inputs.add_json(
            "unasked",
            &unasked.map(|f| f.subject.id()).collect::<Vec<_>>(),
        );
    }

    /// Says what is suspicious in the model.
    pub fn warn(&self, say: &dyn Fn(&str)) {
        if let Some(guessed) = &self.guessed {
            say(&guessed.warning_line());
        }
        for warning in &self.model.warnings {
            say(&study::placed::warning_line(&self.source, warning));
        }
    }

    /// The names of the model's constants.
    pub fn constants(&self) -> impl Iterator<Item = &str> {
        self.model.constants.iter().map(|c| c.name.as_str())
    }

    /// The value of a constant of the model, if it has it.
    pub fn constant(&self, name: &str) -> Option<f64> {
        match self.model.constant(name)? {
            Value::Double(number) => Some(number.to_f64()),
            Value::Int(value) => Some(*value as f64),
            Value::Bool(_) => None,
        }
    }

    /// Whether a constant of the model is declared to be a whole number.
    pub fn is_whole(&self, name: &str) -> bool {
        matches!(self.model.constant(name), Some(Value::Int(_)))
    }

    /// The model with other values for some constants.
    fn model_at(&self, constants: &[(String, f64)]) -> Result<resolved::Model, Problem> {
        let mut overrides = Constants::new();
        for (name, value) in constants {
            let whole = self.is_whole(name) && value.fract() == 0.0 && value.abs() < 2_f64.powi(53);
            let value = match whole {
                true => Value::Int(*value as i64),
                false => Value::Double(Number::from_approximate(*value)),
            };
            overrides.set(name.clone(), value);
        }
        prism_lang::resolve_with(&self.tree, &Constants::new(), &overrides)
            .map_err(|found| unplaced(&found))
    }
}

fn tool(methods: &[Method]) -> Tool {
    let names: Vec<&str> = methods.iter().map(|m| m.name()).collect();
    Tool {
        name: "corroborate checker".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        settings: format!(
            "methods {}; bounds of relative width 1e-6",
            names.join(", ")
        ),
    }
}

/// A diagnostic inside a composed text, at its place in the user's file.
fn shifted(diagnostic: &Diagnostic, prefix: usize, place: usize, length: usize) -> Diagnostic {
    let shift = |offset: usize| place + offset.saturating_sub(prefix).min(length);
    let mut shifted = diagnostic.clone();
    shifted.span = prism_lang::Span::new(shift(diagnostic.span.start), shift(diagnostic.span.end));
    shifted.related.clear();
    shifted
}

fn input_problem(source: &Source, found: &[Diagnostic]) -> Problem {
    study::placed::from_diagnostics(source, found).unwrap_or_else(|| unplaced(found))
}

fn unplaced(found: &[Diagnostic]) -> Problem {
    let words: Vec<_> = found.iter().map(|d| d.message.clone()).collect();
    Problem::new("cannot-resolve", words.join("; "))
}
