//! Properties of one model, for each valuation of its constants.

use crate::ending::Ending;
use crate::explore::explore_within;
use crate::export::{self, Output, Print};
use crate::properties::{self, Asked, Text};
use crate::ranges::Ranges;
use crate::report::{self, Built, CheckReport, PropertyReport, WitnessReport, wrong_report};
use crate::request::{CheckRequest, ModelInput};
use crate::rounded::Rounded;
use crate::{certify, distributions, explicit, parametric, results, strategy};
use checker::explore::ExploreOptions;
use checker::formats::Written;
use checker::state_space::StateSpace;
use checker::symmetry::Symmetry;
use checker::{Answer, Options, Stop};
use diagnostic::{Problem, Source, counted};
use host::Host;
use prism_lang::{Arithmetic, Constants, Experiment, NamedProperty, Rational, resolved};
use std::path::Path;
use std::time::Instant;
use study::Method;

/// How many valuations of constants one request may have.
const MOST_VALUATIONS: u64 = 1_000_000;

/// What is the same for all valuations of constants.
struct Work<'a> {
    request: &'a CheckRequest,
    host: &'a Host,
    output: Output<'a>,
    source: Source,
    tree: prism_lang::ast::Model,
    warnings: Vec<prism_lang::Diagnostic>,
    /// The model's files, if it is not in the PRISM language.
    explicit: Option<explicit::Files>,
    texts: &'a [Text],
    ending: Ending,
}

/// What was found.
#[derive(Debug)]
pub struct Checked {
    /// All properties, with their answers or why there is none.
    pub report: CheckReport,
    /// What kept properties from being answered, if anything did: a mistake in the model, or what ended the work early.
    pub problem: Option<Problem>,
}

impl Checked {
    /// The report, or the problem if nothing was built at all.
    ///
    /// # Errors
    /// The problem that kept any state space from being built.
    pub fn into_report(self) -> Result<CheckReport, Problem> {
        match self.problem {
            Some(problem) if !self.report.is_built => Err(problem),
            _ => Ok(self.report),
        }
    }
}

/// Checks properties of a model, for each valuation of its constants. Notes and mistakes of single properties go to the host's
/// events; what is to be written to `stdout` goes to `print`.
///
/// # Errors
/// What is wrong with the request: properties of which none can be read, more valuations than can be checked, a property that
/// is selected and does not exist, a file that cannot be written. A mistake in the model is in [`Checked`].
pub fn check(request: &CheckRequest, host: &Host, print: Print<'_>) -> Result<Checked, Problem> {
    let count = request.constants.len();
    if count > MOST_VALUATIONS {
        let message = format!("the ranges of the constants have {count} valuations");
        let remedy = format!("give at most {MOST_VALUATIONS} at a time");
        return Err(Problem::new("bad-constants", message).remedy(remedy));
    }
    let texts = properties::read(request, host)?;
    let (report, problem) = match Work::new(request, host, Output(print), &texts) {
        Ok(work) => work.all(&request.constants)?,
        Err(problem) => {
            let failed = properties::failed(&texts, request.method, &problem);
            (CheckReport::new(request, failed), Some(problem))
        }
    };
    Ok(Checked { report, problem })
}

/// Writes the answers as tables to `FILE[:form]` (csv, matrix, dataframe, comment), as PRISM's `-exportresults` does.
///
/// # Errors
/// A form that is not known, or a file that cannot be written.
pub fn write_results(file: &str, report: &CheckReport, print: Print<'_>) -> Result<(), Problem> {
    results::write(file, report, Output(print))
}

/// Reads a text in the PRISM language, and says if its letters had to be guessed.
pub(crate) fn read_prism(path: &Path, host: &Host) -> Result<Source, Problem> {
    let (source, warning) = host::files::read_prism(path)?;
    if let Some(warning) = warning {
        host.events.say(&warning.warning_line());
    }
    Ok(source)
}

/// What cannot be said of a model whose probabilities were divided by their sum.
fn refuse_rounded(request: &CheckRequest, model: &resolved::Model) -> Result<(), Problem> {
    let what = match (request.certify, distributions::are_asked(request)) {
        _ if model.rounded.is_empty() => return Ok(()),
        (true, _) => "certificates",
        (_, true) => "the probabilities of all states",
        _ => return Ok(()),
    };
    let message = format!("{what}: bounds of rounded probabilities are not known there");
    Err(Problem::new("unsupported", message)
        .remedy("give each command probabilities that sum to 1, the last one as `1 - (...)`"))
}

impl<'a> Work<'a> {
    /// Reads the model.
    fn new(
        request: &'a CheckRequest,
        host: &'a Host,
        output: Output<'a>,
        texts: &'a [Text],
    ) -> Result<Self, Problem> {
        let ending = Ending::new(request, host);
        let explicit = explicit::Files::read(request, &host.events)?;
        let source = match &explicit {
            // It declares nothing.
            Some(_) => Source {
                name: request.model.name(),
                text: String::new(),
            },
            None => match &request.model {
                ModelInput::File(path) => read_prism(path, host)?,
                ModelInput::Text(source) => source.clone(),
            },
        };
        let parsed = prism_lang::parse_model(&source.text);
        let found = study::placed::from_diagnostics(&source, &parsed.diagnostics);
        if let (Some(problem), None) = (found, &explicit) {
            return Err(problem);
        }
        let mut tree = parsed.tree;
        if let Some(asked) = request.model_type {
            let span = tree
                .model_type
                .map_or_else(Default::default, |(_, span)| span);
            tree.model_type = Some((asked, span));
        }
        Ok(Self {
            request,
            host,
            output,
            source,
            tree,
            warnings: parsed.diagnostics,
            explicit,
            texts,
            ending,
        })
    }

    /// All valuations; a valuation over which the model means nothing does not keep others from being checked.
    fn all(&self, experiment: &Experiment) -> Result<(CheckReport, Option<Problem>), Problem> {
        let mut ranges = Ranges::new(&self.tree, self.texts, experiment.clone());
        let mut report = CheckReport::new(self.request, Vec::new());
        let mut first_problem = None;
        for (valuation, given) in ranges.valuations().into_iter().enumerate() {
            let values = ranges.values(&given, None);
            if valuation > 0 && self.ending.is_due() {
                let mut rest = self.ending.none_begun(self.texts, self.request);
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
                    self.ending.none_begun(self.texts, self.request)
                }
                Err(problem) => {
                    let failed = properties::failed(self.texts, self.request.method, &problem);
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
            match self.host.cancel.is_cancelled() {
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
        if self.request.open.is_some() {
            let request = self.request;
            if distributions::are_asked(request) {
                let message =
                    "the probabilities of all states are numbers, not functions of open constants";
                let problem = Problem::new("bad-distribution", message);
                return Err(problem.remedy("give the open constants values"));
            }
            let report = parametric::check(
                request,
                &self.source,
                &self.tree,
                &own,
                given,
                self.texts,
                &self.ending,
            )?;
            let mut found = report.properties;
            found.retain(|property| ranges.is_new(property.prop_idx, given));
            return Ok((report.built, found));
        }
        let resolved = match self.request.sum_roundoff {
            Some(most) => prism_lang::resolve_rounded(&self.tree, &own, most),
            None => prism_lang::resolve(&self.tree, &own),
        };
        let model = resolved.map_err(|found| {
            study::placed::from_diagnostics(&self.source, &found)
                .unwrap_or_else(|| Problem::new("cannot-resolve", "the model cannot be resolved"))
        })?;
        refuse_rounded(self.request, &model)?;
        for warning in self.warnings.iter().chain(&model.warnings) {
            self.host
                .events
                .say(&study::placed::warning_line(&self.source, warning));
        }
        let asked = self.asked(&model, given)?;
        let mut chosen = selected(self.request, &asked)?;
        chosen.retain(|(place, _)| ranges.is_new(*place, given));
        let meaningful = chosen.iter().filter_map(|(_, asked)| match asked {
            Asked::Property(property) => Some(&property.property),
            Asked::Wrong(_) => None,
        });
        let limits = ExploreOptions {
            max_states: most_states(self.request),
            symmetry: match self.may_fold() {
                true => Symmetry::of_while(&model, meaningful.clone(), &|| !self.ending.is_due()),
                false => Symmetry::default(),
            },
            ..match self.request.exports.model.is_empty() {
                true => ExploreOptions::for_properties(meaningful),
                // What is written has all reward structures.
                false => ExploreOptions::default(),
            }
        };
        let as_it_is = || ExploreOptions {
            symmetry: Symmetry::default(),
            ..limits.clone()
        };
        let rounded = Rounded::of(&model, || {
            explore(&self.source, &model, &as_it_is(), &self.ending)
        })?;
        let carried =
            |answered: Result<Answer, _>, p: &NamedProperty, o: &Options<'_>| match &rounded {
                Some(rounded) => rounded.carry(answered?, p, o),
                None => answered,
            };
        let (built, found) = match self.request.method {
            Method::Exact => self.explored::<Rational>(&model, &limits, &chosen, |space, p, o| {
                carried(checker::check_exact(space, &p.property, o), p, o)
            }),
            _ => self.explored::<f64>(&model, &limits, &chosen, |space, p, o| {
                carried(checker::check(space, &model, &p.property, o), p, o)
            }),
        }?;
        let mut report = CheckReport::new(self.request, found);
        if self.request.certify {
            certify::all(&mut report, self.request, &model, &asked, &self.ending)?;
        }
        Ok((built, report.properties))
    }

    /// Whether states that symmetries map to each other may stand for each other: nothing is shown of single states, all
    /// schedulers count, and the method has bounds (estimates are of the model as it is).
    fn may_fold(&self) -> bool {
        let request = self.request;
        let is_shown = distributions::are_asked(request)
            || request.witness
            || request.exports.strategy.is_some()
            || !request.exports.model.is_empty();
        !is_shown && !request.fair && !request.method.of_checker().is_estimate()
    }

    /// The properties over a model.
    fn asked(&self, model: &resolved::Model, given: &Constants) -> Result<Vec<Asked>, Problem> {
        let asked = properties::resolved(self.texts, model, given)?;
        if asked.is_empty() && !self.texts.is_empty() {
            let warning = "warning: no property was given, so nothing is checked";
            self.host.events.say(warning);
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
        match self.request.method {
            Method::Exact => {
                let space = files.space::<Rational>()?;
                let model = space.outline();
                let asked = self.asked(&model, given)?;
                let mut chosen = selected(self.request, &asked)?;
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
                let mut chosen = selected(self.request, &asked)?;
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
            } else if self.texts.is_empty() {
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
        let request = self.request;
        let mut built = Built::new(space, began.elapsed().as_secs_f64());
        export::model(&request.exports, model, space, self.output)?;
        let mut options = Options::with_method(request.method.of_checker());
        options.precision = request.precision;
        options.fair = request.fair;
        options.epsilon = request.epsilon;
        options.termination = request.termination;
        options.max_iters = request.max_iterations.unwrap_or(options.max_iters);
        let is_due = || self.ending.is_due();
        let until_due = Options {
            cancel: Some(&is_due),
            ..options
        };
        built.distributions = distributions::all(request, space, &until_due, self.output)?;
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
                (&request.exports.strategy, asked, answered)
            {
                let cancel = || self.ending.is_due();
                let options = Options {
                    cancel: Some(&cancel),
                    ..options
                };
                let (property, talk) = (&named.property, &self.host.events);
                strategy::write_strategy(
                    file,
                    model,
                    space,
                    property,
                    &options,
                    talk,
                    self.output,
                )?;
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
        let method = self.request.method;
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
            Ok(answer) if self.request.witness => witness(space, property, answer),
            _ => None,
        };
        let mut report = report::property_report(place, property, answered, method, check_secs);
        report.witness = witness;
        for listed in &mut report.printed {
            listed.values = space.describe(listed.state as usize);
        }
        Ok(report)
    }
}

/// How many states a model may have: without the option as many as can be numbered, since the memory is limited.
pub(crate) fn most_states(request: &CheckRequest) -> usize {
    let asked = request.max_states;
    asked.map_or(usize::MAX, |most| {
        usize::try_from(most).unwrap_or(usize::MAX)
    })
}

/// The state space of a model.
pub(crate) fn explore<N: Arithmetic>(
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
) -> Option<WitnessReport> {
    // Rational state spaces have none: the sound method shows it.
    let space = (space as &dyn std::any::Any).downcast_ref::<StateSpace<f64>>()?;
    let found = checker::witness(space, &property.property, answer, &Options::default());
    let found = found.ok().flatten()?;
    Some(WitnessReport {
        violates: found.violates,
        probability: found.probability,
        states: found.states,
        actions: found.actions,
    })
}

pub(crate) fn selected<'a>(
    request: &CheckRequest,
    asked: &'a [Asked],
) -> Result<Vec<(usize, &'a Asked)>, Problem> {
    let numbered = || asked.iter().enumerate().map(|(i, p)| (i + 1, p));
    if request.selected.is_empty() {
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
            Problem::new("unknown-property", message).remedy(format!(
                "the input has {}{named}{names}",
                counted(count, "property")
            ))
        })
    };
    // PRISM's switch takes several, separated by commas.
    let wanted = request.selected.iter().flat_map(|names| names.split(','));
    wanted.map(|name| find(&name.trim().to_owned())).collect()
}
