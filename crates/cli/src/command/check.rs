//! `corroborate check`: properties of one model, like the peers' command
//! lines.

mod available;
mod certify;
mod distributions;
mod ending;
mod explicit;
mod export;
mod form;
mod memory;
mod parametric;
mod print;
mod properties;
mod ranges;
mod results;
mod strategy;

use super::{Done, Setting, json};
use crate::args::{Check, CheckFormat, Termination, refused};
use crate::outcome::Outcome;
use crate::problem::{Problem, Source};
use crate::study::Method;
use crate::technique::model_checking::{explore_within, warning_line};
use checker::explore::ExploreOptions;
use checker::formats::Written;
use checker::state_space::StateSpace;
use checker::symmetry::Symmetry;
use checker::{Answer, Options, Stop};
use ending::Ending;
use form::{Built, CheckReport, PropertyReport, empty, wrong_report};
use prism_lang::ast::ModelType;
use prism_lang::{Arithmetic, Constants, Experiment, NamedProperty, Rational, resolved};
use properties::{Asked, Text};
use ranges::Ranges;
use std::time::Instant;

/// How many valuations of constants one command checks.
const MOST_VALUATIONS: u64 = 1_000_000;

/// What is the same for all valuations of constants.
struct Work<'a> {
    arguments: &'a Check,
    setting: &'a Setting,
    source: Source,
    tree: prism_lang::ast::Model,
    warnings: Vec<prism_lang::Diagnostic>,
    /// The model's files, if it is not in the PRISM language.
    explicit: Option<explicit::Files>,
    texts: &'a [Text],
    ending: Ending,
}

/// Checks properties of a model, for each valuation of its constants.
pub fn check(arguments: &Check, setting: &Setting) -> Result<Done, Problem> {
    refuse(arguments)?;
    let experiment = constants(&arguments.constants)?;
    say_what_has_no_effect(arguments, setting);
    let texts = properties::read(arguments)?;
    let (report, problem) = match Work::new(arguments, setting, &texts) {
        Ok(work) => work.all(experiment)?,
        Err(problem) if arguments.format == CheckFormat::Jsonl => {
            let failed = properties::failed(&texts, arguments.method, &problem);
            (CheckReport::new(arguments, failed), Some(problem))
        }
        Err(problem) => return Err(problem),
    };
    if let Some(problem) = problem {
        if !report.is_built && arguments.format != CheckFormat::Jsonl {
            return Err(problem);
        }
        setting.talk.say(&problem.render(false));
    }
    if let Some(file) = &arguments.export_results {
        match report.is_finished() {
            true => results::write(file, &report)?,
            false => (setting.talk).say(&format!(
                "note: {file} is not written, since not all answers are there"
            )),
        }
    }
    let output = match arguments.format {
        CheckFormat::Json => json(&report)?,
        CheckFormat::Jsonl => print::lines(&report)?,
        CheckFormat::Text => print::text(&report),
    };
    Ok(Done {
        output,
        outcome: outcome(&report),
    })
}

/// Flags of PRISM's that are not taken.
fn refuse(arguments: &Check) -> Result<(), Problem> {
    match arguments.refused.first() {
        None => Ok(()),
        Some(flag) => {
            let problem = Problem::new("refused-flag", format!("{flag} is not taken"));
            Err(problem.remedy(refused::reason(flag)))
        }
    }
}

fn say_what_has_no_effect(arguments: &Check, setting: &Setting) {
    for flag in &arguments.without_effect {
        let why = match flag.as_str() {
            file if file.starts_with("-export") => "what it writes cannot be written yet",
            "-valiter" | "-power" | "-pow" | "-pwr" | "-gaussseidel" | "-gs" | "-jacobi"
            | "-jac" | "-politer" | "-modpoliter" => {
                "another flag asks for answers that are no estimates"
            }
            "-sim" => "the answers are computed, not estimated from samples",
            "-noprobchecks" => "probabilities are always checked",
            "-javamaxmem" | "-javastack" | "-cuddmaxmem" => "--memory-limit is the limit here",
            "-symm" => "states that stand for each other are found without it",
            "-verbose" | "-v" | "-extraddinfo" | "-extrareachinfo" => "there is no more to be said",
            _ => "our bounds hold by any method, in any data structure",
        };
        setting
            .talk
            .say(&format!("note: {flag} has no effect: {why}"));
    }
}

impl<'a> Work<'a> {
    /// Reads the model.
    fn new(arguments: &'a Check, setting: &'a Setting, texts: &'a [Text]) -> Result<Self, Problem> {
        let explicit = explicit::Files::read(arguments, &setting.talk)?;
        let source = match &explicit {
            // It declares nothing.
            Some(_) => Source {
                name: arguments.model.display().to_string(),
                text: String::new(),
            },
            None => Source::read(&arguments.model)?,
        };
        let parsed = prism_lang::parse_model(&source.text);
        let found = Problem::from_diagnostics(&source, &parsed.diagnostics);
        if let (Some(problem), None) = (found, &explicit) {
            return Err(problem);
        }
        let mut tree = parsed.tree;
        if let Some(keyword) = &arguments.model_type {
            let span = tree
                .model_type
                .map_or_else(Default::default, |(_, span)| span);
            let own = [ModelType::Dtmc, ModelType::Ctmc, ModelType::Mdp];
            let asked = own.into_iter().find(|own| own.keyword() == keyword);
            tree.model_type = asked.map(|own| (own, span));
        }
        Ok(Self {
            arguments,
            setting,
            source,
            tree,
            warnings: parsed.diagnostics,
            explicit,
            texts,
            ending: Ending::new(arguments, &setting.interrupt),
        })
    }

    /// All valuations; a valuation over which the model means nothing does not keep others from being checked.
    fn all(&self, experiment: Experiment) -> Result<(CheckReport, Option<Problem>), Problem> {
        let mut ranges = Ranges::new(&self.tree, self.texts, experiment);
        let mut report = CheckReport::new(self.arguments, Vec::new());
        let mut first_problem = None;
        for (valuation, given) in ranges.valuations().into_iter().enumerate() {
            let values = ranges.values(&given, None);
            if valuation > 0 && self.ending.is_due() {
                let mut rest = self.ending.none_begun(self.texts, self.arguments);
                rest.retain(|property| ranges.is_new(property.prop_idx, &given));
                for property in &mut rest {
                    property.valuation = valuation;
                    property.constants = ranges.values(&given, Some(property.prop_idx));
                }
                report.properties.append(&mut rest);
                continue;
            }
            let mut found = match self.one(&given, &mut ranges) {
                Ok((mut built, found)) => {
                    (built.constants, built.valuation) = (values, valuation);
                    report.push(built);
                    found
                }
                Err(problem) if problem.is_interruption() => {
                    report.interrupted = Some(problem.message().to_owned());
                    self.ending.none_begun(self.texts, self.arguments)
                }
                Err(problem) => {
                    let failed = properties::failed(self.texts, self.arguments.method, &problem);
                    first_problem.get_or_insert(problem);
                    failed
                }
            };
            for property in &mut found {
                property.valuation = valuation;
                property.constants = ranges.values(&given, Some(property.prop_idx));
            }
            report.properties.append(&mut found);
        }
        if !report.is_finished() {
            match self.setting.interrupt.is_set() {
                true => {
                    let interrupted = || "interrupted".to_owned();
                    report.interrupted.get_or_insert_with(interrupted);
                }
                false => {
                    first_problem.get_or_insert_with(|| self.ending.problem());
                }
            }
        }
        Ok((report, first_problem))
    }

    /// Checks properties of a model whose constants have one value each.
    fn one(
        &self,
        given: &Constants,
        ranges: &mut Ranges,
    ) -> Result<(Built, Vec<PropertyReport>), Problem> {
        if let Some(files) = &self.explicit {
            return self.of_files(files, given, ranges);
        }
        let own = self.constants_of_model(given)?;
        if !self.arguments.open.is_empty() {
            let arguments = self.arguments;
            if distributions::are_asked(arguments) {
                let message = "--steady-state and --transient give numbers, not functions";
                let problem = Problem::new("bad-distribution", message);
                return Err(problem.remedy("leave out --param, and give the constants values"));
            }
            let report = parametric::check(
                arguments,
                &self.source,
                &self.tree,
                &own,
                given,
                &self.ending,
            )?;
            let mut found = report.properties;
            found.retain(|property| ranges.is_new(property.prop_idx, given));
            return Ok((report.built, found));
        }
        let model = prism_lang::resolve(&self.tree, &own).map_err(|found| {
            Problem::from_diagnostics(&self.source, &found)
                .unwrap_or_else(|| Problem::new("cannot-resolve", "the model cannot be resolved"))
        })?;
        for warning in self.warnings.iter().chain(&model.warnings) {
            self.setting.talk.say(&warning_line(&self.source, warning));
        }
        let asked = self.asked(&model, given)?;
        let mut chosen = selected(self.arguments, &asked)?;
        chosen.retain(|(place, _)| ranges.is_new(*place, given));
        let meaningful = chosen.iter().filter_map(|(_, asked)| match asked {
            Asked::Property(property) => Some(&property.property),
            Asked::Wrong(_) => None,
        });
        let limits = ExploreOptions {
            max_states: most_states(self.arguments),
            symmetry: match self.may_fold() {
                true => Symmetry::of(&model, meaningful.clone()),
                false => Symmetry::default(),
            },
            ..match self.arguments.export_model.is_empty() {
                true => ExploreOptions::for_properties(meaningful),
                // What is written has all reward structures.
                false => ExploreOptions::default(),
            }
        };
        let (built, found) = match self.arguments.method {
            Method::Exact => self.explored::<Rational>(&model, &limits, &chosen, |space, p, o| {
                checker::check_exact(space, &p.property, o)
            }),
            _ => self.explored::<f64>(&model, &limits, &chosen, |space, p, o| {
                checker::check(space, &model, &p.property, o)
            }),
        }?;
        let mut report = CheckReport::new(self.arguments, found);
        if self.arguments.certify {
            certify::all(&mut report, self.arguments, &model, &asked, &self.ending)?;
        }
        Ok((built, report.properties))
    }

    /// Whether states that symmetries map to each other may stand for each other: nothing is shown of single states, all
    /// schedulers count, and the method has bounds (estimates are of the model as it is).
    fn may_fold(&self) -> bool {
        let arguments = self.arguments;
        let is_shown = distributions::are_asked(arguments)
            || arguments.witness
            || arguments.export_strategy.is_some()
            || !arguments.export_model.is_empty();
        !is_shown && !arguments.fair && !arguments.method.of_checker().is_estimate()
    }

    /// The properties over a model.
    fn asked(&self, model: &resolved::Model, given: &Constants) -> Result<Vec<Asked>, Problem> {
        let asked = properties::resolved(self.texts, model, given)?;
        if asked.is_empty() && !self.texts.is_empty() {
            let warning = "warning: no property was given, so nothing is checked";
            self.setting.talk.say(warning);
        }
        Ok(asked)
    }

    /// Checks properties of a model that was read from its states and transitions.
    fn of_files(
        &self,
        files: &explicit::Files,
        given: &Constants,
        ranges: &mut Ranges,
    ) -> Result<(Built, Vec<PropertyReport>), Problem> {
        let began = Instant::now();
        match self.arguments.method {
            Method::Exact => {
                let space = files.space::<Rational>()?;
                let model = space.outline();
                let asked = self.asked(&model, given)?;
                let mut chosen = selected(self.arguments, &asked)?;
                chosen.retain(|(place, _)| ranges.is_new(*place, given));
                let exactly = |space: &_, property: &NamedProperty, options: &Options<'_>| {
                    checker::check_exact(space, &property.property, options)
                };
                self.on_space(&space, &model, began, &chosen, exactly)
            }
            _ => {
                let space = files.space::<f64>()?;
                let model = space.outline();
                let asked = self.asked(&model, given)?;
                let mut chosen = selected(self.arguments, &asked)?;
                chosen.retain(|(place, _)| ranges.is_new(*place, given));
                let exact = || {
                    let space = files.space::<Rational>();
                    space.map_err(|problem| checker::CheckError::ExactModel(problem.line()))
                };
                let soundly = |space: &_, property: &NamedProperty, options: &Options<'_>| {
                    checker::check_or_exact(space, &property.property, options, &exact)
                };
                self.on_space(&space, &model, began, &chosen, soundly)
            }
        }
    }

    /// Constants may be meant for the model or for the properties' file; the model
    /// is given those that it declares.
    fn constants_of_model(&self, given: &Constants) -> Result<Constants, Problem> {
        let names = self.tree.constants.iter().map(|c| c.name.text.as_str());
        let declared: Vec<&str> = names.collect();
        let mut own = Constants::new();
        for (name, value) in &given.0 {
            if declared.contains(&name.as_str()) {
                own.set(name.clone(), value.clone());
            } else if self.arguments.properties.is_none() {
                return Err(Problem::new(
                    "unknown-constant",
                    format!("the model declares no constant `{name}`"),
                )
                .remedy(format!("it declares {}", declared.join(", "))));
            }
        }
        Ok(own)
    }

    fn explored<N: Arithmetic + Written + 'static>(
        &self,
        model: &resolved::Model,
        limits: &ExploreOptions,
        chosen: &[(usize, &Asked)],
        answer: impl Fn(&StateSpace<N>, &NamedProperty, &Options) -> Result<Answer, checker::CheckError>,
    ) -> Result<(Built, Vec<PropertyReport>), Problem> {
        let began = Instant::now();
        let space: StateSpace<N> = explore(&self.source, model, limits, &self.ending)?;
        self.on_space(&space, model, began, chosen, answer)
    }

    /// Answers over a state space, which was begun to be built at some time.
    fn on_space<N: Arithmetic + Written + 'static>(
        &self,
        space: &StateSpace<N>,
        model: &resolved::Model,
        began: Instant,
        chosen: &[(usize, &Asked)],
        answer: impl Fn(&StateSpace<N>, &NamedProperty, &Options) -> Result<Answer, checker::CheckError>,
    ) -> Result<(Built, Vec<PropertyReport>), Problem> {
        let arguments = self.arguments;
        let mut built = Built::new(space, began.elapsed().as_secs_f64());
        export::model(arguments, model, space)?;
        let mut options = Options::with_method(arguments.method.of_checker());
        options.precision = arguments.precision;
        options.fair = arguments.fair;
        options.epsilon = arguments.epsilon;
        options.termination = match arguments.termination {
            Termination::Relative => checker::Termination::Relative,
            Termination::Absolute => checker::Termination::Absolute,
        };
        options.max_iters = arguments.max_iterations.unwrap_or(options.max_iters);
        let is_due = || self.ending.is_due();
        let until_due = Options {
            cancel: Some(&is_due),
            ..options
        };
        built.distributions = distributions::all(arguments, space, &until_due)?;
        let mut reports = Vec::new();
        for (place, asked) in chosen {
            let answer = |property: &NamedProperty| {
                let is_due = || self.ending.is_due();
                let is_urgent = || self.ending.is_urgent();
                let stop = Stop::new(&is_due);
                let options = Options {
                    stop: Some(&stop),
                    cancel: Some(&is_urgent),
                    ..options
                };
                answer(space, property, &options)
            };
            reports.push(self.answered(*place, asked, space, answer)?);
            let answered = !self.ending.is_due()
                && reports.last().is_some_and(|report| report.error.is_none());
            if let (Some(file), Asked::Property(named), true) =
                (&arguments.export_strategy, asked, answered)
            {
                let cancel = || self.ending.is_due();
                let options = Options {
                    cancel: Some(&cancel),
                    ..options
                };
                let (property, talk) = (&named.property, &self.setting.talk);
                strategy::write_strategy(file, model, space, property, &options, talk)?;
            }
        }
        Ok((built, reports))
    }

    fn answered<N: Arithmetic + Written + 'static>(
        &self,
        place: usize,
        asked: &Asked,
        space: &StateSpace<N>,
        answer: impl Fn(&NamedProperty) -> Result<Answer, checker::CheckError>,
    ) -> Result<PropertyReport, Problem> {
        let method = self.arguments.method;
        let began = Instant::now();
        let property = match asked {
            Asked::Property(property) => property.as_ref(),
            Asked::Wrong(wrong) => return Ok(wrong_report(place, wrong, method)),
        };
        let named = || (place, property.name.clone(), property.text.clone());
        if self.ending.is_due() {
            return Ok(self.ending.not_begun(named(), method));
        }
        let answered = answer(property);
        let check_secs = began.elapsed().as_secs_f64();
        if let Some(reached) = answered.as_ref().err().and_then(Ending::of_error) {
            return Ok(self.ending.stopped(named(), method, reached, check_secs));
        }
        let witness = match &answered {
            Ok(answer) if self.arguments.witness => witness(space, property, answer),
            _ => None,
        };
        let mut report = form::property_report(place, property, answered, method, check_secs);
        report.witness = witness;
        for listed in &mut report.printed {
            listed.values = space.describe(listed.state as usize);
        }
        Ok(report)
    }
}

/// How many states a model may have: without the option as many as can be numbered, since the memory is limited.
fn most_states(arguments: &Check) -> usize {
    let asked = arguments.max_states;
    asked.map_or(usize::MAX, |most| {
        usize::try_from(most).unwrap_or(usize::MAX)
    })
}

/// The state space of a model.
fn explore<N: Arithmetic>(
    source: &Source,
    model: &resolved::Model,
    limits: &ExploreOptions,
    ending: &Ending,
) -> Result<StateSpace<N>, Problem> {
    ending.exploring(|go_on| explore_within(source, model, limits.clone(), go_on))
}

/// The most probable path that shows why an answer is as it is.
fn witness<N: Arithmetic + 'static>(
    space: &StateSpace<N>,
    property: &NamedProperty,
    answer: &Answer,
) -> Option<form::WitnessReport> {
    // Rational state spaces have none: the sound method shows it.
    let space = (space as &dyn std::any::Any).downcast_ref::<StateSpace<f64>>()?;
    let found = checker::witness(space, &property.property, answer, &Options::default());
    let found = found.ok().flatten()?;
    Some(form::WitnessReport {
        violates: found.violates,
        probability: found.probability,
        states: found.states,
        actions: found.actions,
    })
}

fn constants(texts: &[String]) -> Result<Experiment, Problem> {
    let experiment = Experiment::parse(&texts.join(",")).map_err(|error| {
        Problem::new("bad-constants", format!("--const: {error}"))
            .remedy("write for example --const N=5,p=0.1 or, for a range, --const N=1:2:9")
    })?;
    if experiment.len() > MOST_VALUATIONS {
        let count = experiment.len();
        let message = format!("--const: the ranges have {count} valuations");
        let remedy = format!("give at most {MOST_VALUATIONS} in one command");
        return Err(Problem::new("bad-constants", message).remedy(remedy));
    }
    Ok(experiment)
}

fn selected<'a>(arguments: &Check, asked: &'a [Asked]) -> Result<Vec<(usize, &'a Asked)>, Problem> {
    let numbered = || asked.iter().enumerate().map(|(i, p)| (i + 1, p));
    if arguments.selected.is_empty() {
        return Ok(numbered().collect());
    }
    let find = |wanted: &String| {
        let is_wanted = |(place, p): &(usize, &Asked)| {
            p.name() == Some(wanted.as_str()) || place.to_string() == *wanted
        };
        numbered().find(is_wanted).ok_or_else(|| {
            let names: Vec<&str> = asked.iter().filter_map(Asked::name).collect();
            let message = format!("there is no property `{wanted}`");
            let named = if names.is_empty() { "" } else { ", named " };
            let (count, names) = (asked.len(), names.join(", "));
            Problem::new("unknown-property", message)
                .remedy(format!("there are {count} properties{named}{names}"))
        })
    };
    // PRISM's switch takes several, separated by commas.
    let wanted = arguments.selected.iter().flat_map(|names| names.split(','));
    wanted.map(|name| find(&name.trim().to_owned())).collect()
}

fn outcome(report: &CheckReport) -> Outcome {
    let any = |test: &dyn Fn(&PropertyReport) -> bool| report.properties.iter().any(test);
    if report.interrupted.is_some() {
        Outcome::Interrupted
    } else if any(&|p| p.result.as_deref() == Some("false")) {
        Outcome::Violated
    } else if any(&|p| p.is_wrong) {
        Outcome::Wrong
    } else if report.distributions.iter().any(|d| d.error.is_some())
        || any(&|p| p.error.is_some() || p.certificate.as_ref().is_some_and(|c| !c.is_good()))
    {
        Outcome::Inconclusive
    } else {
        Outcome::Holds
    }
}
