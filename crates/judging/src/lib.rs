#![doc = include_str!("../README.md")]
//!
//! Each monitor is given the samples of the signals that it reads, and nothing
//! else, so that its verdict depends on them alone (`explain signals`); signals
//! keep their last value in between. The clock is the trace's, unless a form names a signal as its
//! clock. [`Judges`] holds what is compiled once; a [`Session`] is one pass
//! over one trace, whether it comes from memory, a file or a running system.
//! [`monitor()`] judges recordings as a whole: from a request of plain data to
//! a report.

mod at_work;
pub mod forms;
pub mod lacking;
mod losses;
pub mod monitor;
pub mod recording;
mod session;
mod shown;
mod space_time;
#[cfg(test)]
mod tests;
mod valueless;
pub mod verdicts;
pub mod watched;

pub use losses::Losses;
pub use monitor::{MonitorReport, MonitorRequest, Monitored, monitor};
pub use session::{News, Session};
pub use shown::Shown;
pub use space_time::{SpaceTime, SpaceTimeSession};
pub use valueless::valueless_of;

use diagnostic::Problem;
use evidence::{RunVerdict, Subject};
use host::store::Inputs;
use std::collections::BTreeMap;
use study::{Forms, FormulaRule, JudgingForm, Rule, Study, SubjectForm, Vocabulary};
use temporal::formula::{Formula, FormulaMonitor, Horizon, Settings};
use temporal::monitor::{Monitor, RobustnessMonitor, TooManyUnbounded, Verdict};
use trace::{Predicate, Quantity, Replay, Trace};

/// All monitors of a study, compiled.
#[derive(Debug)]
pub struct Judges<'a> {
    vocabulary: &'a Vocabulary,
    /// The forms of the study that they are of, for diagnostics; `None` of forms that belong to no study.
    forms: Option<&'a Forms>,
    /// The propositions that any monitor uses, each once.
    predicates: Vec<Predicate>,
    /// Their texts.
    texts: Vec<String>,
    /// The clocks other than the trace's, each once.
    clocks: Vec<Quantity>,
    /// The monitors, in the order of the subjects.
    judges: Vec<SubjectJudge<'a>>,
}

/// One compiled monitor.
#[derive(Clone, Debug)]
struct SubjectJudge<'a> {
    subject: &'a Subject,
    /// `None`: the main reading.
    reading: Option<&'a str>,
    rule: CompiledRule,
    /// For each of its propositions, the place in `predicates`.
    propositions: Vec<usize>,
    /// Its place in `clocks`; `None` for the trace's clock.
    clock: Option<usize>,
    /// By how much later than the first of its signals the last one may begin.
    start_within_secs: f64,
}

/// A rule that is ready to judge.
#[derive(Clone, Debug)]
enum CompiledRule {
    Staged {
        monitor: Monitor,
        /// Not to be had if it has too many stages without a deadline.
        robustness: Result<Box<RobustnessMonitor>, TooManyUnbounded>,
    },
    Formula {
        monitor: Box<FormulaMonitor>,
        /// What it was made of.
        formula: Box<Formula>,
        settings: Box<Settings>,
        /// The texts of its atoms.
        atoms: Vec<String>,
    },
}

/// What one monitor says of one trace.
#[derive(Clone, Debug)]
pub struct Judgement<'a> {
    /// The requirement or failure mode.
    pub subject: &'a Subject,
    /// `None`: the main reading.
    pub reading: Option<&'a str>,
    /// The verdict and what it rests on.
    pub findings: JudgedTrace,
}

/// A verdict on a trace and what it rests on.
#[derive(Clone, Debug, PartialEq)]
pub struct JudgedTrace {
    /// The conclusion.
    pub verdict: Verdict,
    /// How often the precondition was met.
    pub triggered: u64,
    /// How often all postconditions were; for a formula, 1 if it is satisfied.
    pub passed: u64,
    /// How often one was not; for a formula, 1 if it is violated.
    pub failed: u64,
    /// By how much it is satisfied or, below 0, violated. Stages of which too
    /// many have no deadline have none.
    pub robustness: Option<Robustness>,
    /// Why there is no robustness, if it could not be computed.
    pub no_robustness: Option<TooManyUnbounded>,
    /// When the verdict was determined, if before the end; seconds.
    pub decided_at_secs: Option<f64>,
    /// From when on it was judged, if not from its first sample on: when all
    /// signals that it reads had a value; seconds.
    pub judged_from_secs: Option<f64>,
    /// How long the trace would have to be from the first trigger on, if the verdict is open only because it ends before.
    pub ends_before: Option<Horizon>,
    /// Within what of the end windows began that are pending there, if the verdict leaves them out.
    pub left_out: Option<Horizon>,
    /// Why it is violated.
    pub violation: Option<Violation>,
}

/// By how much a verdict holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Robustness {
    /// The least that it can be, given what was recorded.
    pub low: f64,
    /// The greatest.
    pub high: f64,
    /// False if triggers fell within an instance of the stages under way, so
    /// that only bounds are known.
    pub exact: bool,
}

impl Robustness {
    /// `None` if it is infinitely far from another verdict: then truth values
    /// decided and no comparison of numbers did, so no number says how far.
    pub fn by_numbers(self) -> Option<Self> {
        (self.low != self.high || self.low.is_finite()).then_some(self)
    }
}

/// The shortest part of a trace that shows a violation.
#[derive(Clone, Debug, PartialEq)]
pub struct Violation {
    /// Where it begins, in seconds.
    pub from_secs: f64,
    /// Where it ends and the violation shows.
    pub to_secs: f64,
    /// The propositions or predicates responsible, with their truth there and
    /// the signals that they read.
    pub responsible: Vec<Responsible>,
}

/// A proposition that is part of the reason for a violation.
#[derive(Clone, Debug, PartialEq)]
pub struct Responsible {
    /// Its name, or its text.
    pub proposition: String,
    /// What it was.
    pub value: bool,
    /// From when on, in seconds.
    pub from_secs: f64,
    /// Until when.
    pub to_secs: f64,
    /// The signals that it reads, `/topic.field`.
    pub signals: Vec<String>,
}

impl<'a> Judges<'a> {
    /// Compiles the monitors of those subjects for which `wanted` holds.
    pub fn new(study: &'a Study, wanted: impl Fn(&Subject) -> bool) -> Result<Self, Problem> {
        let mut collector = Collector::of_study(study);
        for form in study.forms.subjects.iter().filter(|f| wanted(&f.subject)) {
            for (reading, judging) in written_forms(form) {
                collector.add(&form.subject, reading, judging)?;
            }
        }
        Ok(collector.judges)
    }

    /// Compiles the given forms; each is known by its name.
    pub fn of_forms(
        study: &'a Study,
        forms: impl IntoIterator<Item = (&'a Subject, &'a str, &'a JudgingForm)>,
    ) -> Result<Self, Problem> {
        let mut collector = Collector::of_study(study);
        for (subject, name, judging) in forms {
            collector.add(subject, Some(name), judging)?;
        }
        Ok(collector.judges)
    }

    /// Compiles forms that belong to no study, over the names of a
    /// vocabulary.
    pub fn without_study(
        vocabulary: &'a Vocabulary,
        forms: impl IntoIterator<Item = (&'a Subject, &'a JudgingForm)>,
    ) -> Result<Self, Problem> {
        let mut collector = Collector::new(vocabulary);
        for (subject, judging) in forms {
            collector.add(subject, None, judging)?;
        }
        Ok(collector.judges)
    }

    /// Whose monitors these are, in their order, each with its reading.
    pub fn monitors(&self) -> impl Iterator<Item = (&'a Subject, Option<&'a str>)> + '_ {
        self.judges
            .iter()
            .map(|judge| (judge.subject, judge.reading))
    }

    /// The signals that are read, `/topic.field`.
    pub fn signals(&self) -> std::collections::BTreeSet<String> {
        let of_predicates = self.predicates.iter().flat_map(Predicate::signals);
        let of_clocks = self.clocks.iter().flat_map(Quantity::signals);
        of_predicates.chain(of_clocks).collect()
    }

    /// Begins to judge a trace with the channels of `layout`.
    pub fn start<'s>(&'s self, layout: &Trace) -> Result<Session<'s, 'a>, Problem> {
        Session::new(self, layout, &Losses::default())
    }

    /// As [`Judges::start`], of a trace from which samples may be missing.
    pub fn start_lossy<'s>(
        &'s self,
        layout: &Trace,
        losses: &Losses,
    ) -> Result<Session<'s, 'a>, Problem> {
        Session::new(self, layout, losses)
    }

    /// Judges one trace with all monitors in one pass.
    pub fn judge(&self, trace: &Trace) -> Result<Vec<Judgement<'a>>, Problem> {
        self.judge_and_watch(trace, &mut |_, _| Ok(()))
    }

    /// As [`Judges::judge`], of a trace behind whose end nothing changes for ever: it is not too short for any formula.
    pub fn judge_at_rest(&self, trace: &Trace) -> Result<Vec<Judgement<'a>>, Problem> {
        let (mut session, end_secs) = self.followed(trace, &mut |_, _| Ok(()))?;
        session.rests();
        Ok(session.finish_run(trace.complete, end_secs))
    }

    /// The verdicts alone, in the order of the monitors; of an episode that left nothing, none is reached.
    pub fn verdicts_of(&self, trace: Option<&Trace>) -> Result<Vec<Verdict>, Problem> {
        let Some(trace) = trace else {
            return Ok(vec![Verdict::Inconclusive; self.judges.len()]);
        };
        let judged = self.judge(trace)?;
        Ok(judged.iter().map(|it| it.findings.verdict).collect())
    }

    /// Judges one trace; `watch` is shown the session after each instant,
    /// with its time in seconds.
    pub fn judge_and_watch(
        &self,
        trace: &Trace,
        watch: &mut dyn FnMut(f64, &Session<'_, 'a>) -> Result<(), Problem>,
    ) -> Result<Vec<Judgement<'a>>, Problem> {
        let (session, end_secs) = self.followed(trace, watch)?;
        Ok(session.finish_run(trace.complete, end_secs))
    }

    /// All samples of a trace taken, and the time of the last one.
    fn followed<'s>(
        &'s self,
        trace: &Trace,
        watch: &mut dyn FnMut(f64, &Session<'_, 'a>) -> Result<(), Problem>,
    ) -> Result<(Session<'s, 'a>, f64), Problem> {
        let mut session = self.start(trace)?;
        let mut replay = Replay::new(trace);
        let mut end_secs = f64::NEG_INFINITY;
        while let Some(sample) = replay.advance() {
            end_secs = sample.time_secs;
            let news = News {
                changed: replay.changed(),
                sampled: None,
                dropped: None,
                more: sample.more,
            };
            session.step_changed(sample.time_secs, &replay, &news)?;
            if !sample.more {
                watch(sample.time_secs, &session)?;
            }
        }
        Ok((session, end_secs))
    }
}

impl Judges<'_> {
    /// An error in a proposition: at its place in the vocabulary, or, for a predicate that stands in a requirement, at its place
    /// there, with the requirement's name and the predicate.
    fn in_proposition(&self, place: usize, error: &trace::PredicateError) -> Problem {
        let uses = |judge: &&SubjectJudge<'_>| judge.propositions.contains(&place);
        self.in_subject(self.judges.iter().find(uses), &self.texts[place], error)
    }

    /// The same for the signal that a requirement takes as its clock.
    fn in_clock(&self, place: usize, error: &trace::PredicateError) -> Problem {
        let uses = |judge: &&SubjectJudge<'_>| judge.clock == Some(place);
        self.in_subject(self.judges.iter().find(uses), "clock", error)
    }

    fn in_subject(
        &self,
        judge: Option<&SubjectJudge<'_>>,
        text: &str,
        error: &trace::PredicateError,
    ) -> Problem {
        let problem = self.vocabulary.predicate_problem(error);
        let Some(judge) = judge.filter(|_| error.entry.is_none()) else {
            return problem;
        };
        let problem = problem.about(&format!("{}: `{text}`", judge.subject.id()));
        let place = |forms: &Forms| forms.place_of(judge.subject, text);
        match self.forms.and_then(|forms| Some((forms, place(forms)?))) {
            Some((forms, place)) => problem.at(&forms.source, place).remedy(
                "correct the predicate, or judge a recording that has the signals it names",
            ),
            None => problem,
        }
    }
}

/// Judges that are being put together.
struct Collector<'a> {
    judges: Judges<'a>,
    places: BTreeMap<String, usize>,
    clocks: BTreeMap<String, usize>,
}

impl<'a> Collector<'a> {
    /// For forms of a study, whose places are told.
    fn of_study(study: &'a Study) -> Self {
        let mut collector = Self::new(&study.vocabulary);
        collector.judges.forms = Some(&study.forms);
        collector
    }

    fn new(vocabulary: &'a Vocabulary) -> Self {
        Self {
            judges: Judges {
                vocabulary,
                forms: None,
                predicates: Vec::new(),
                texts: Vec::new(),
                clocks: Vec::new(),
                judges: Vec::new(),
            },
            places: BTreeMap::new(),
            clocks: BTreeMap::new(),
        }
    }

    fn add(
        &mut self,
        subject: &'a Subject,
        reading: Option<&'a str>,
        form: &JudgingForm,
    ) -> Result<(), Problem> {
        let rule = CompiledRule::new(&form.rule)?;
        let names: Vec<String> = rule.propositions().to_vec();
        let propositions = names
            .iter()
            .map(|name| {
                let found = self.proposition(name);
                found.map_err(|problem| match problem.has_place() {
                    true => problem,
                    false => problem.about(&format!("{}: `{name}`", subject.id())),
                })
            })
            .collect::<Result<Vec<_>, _>>()?;
        let clock = match &form.clock {
            Some(clock) => Some(self.clock(clock)?),
            None => None,
        };
        self.judges.judges.push(SubjectJudge {
            subject,
            reading,
            rule,
            propositions,
            clock,
            start_within_secs: form.start_within_secs,
        });
        Ok(())
    }

    fn proposition(&mut self, text: &str) -> Result<usize, Problem> {
        if let Some(place) = self.places.get(text) {
            return Ok(*place);
        }
        let vocabulary = self.judges.vocabulary;
        let predicate = vocabulary.signals.predicate(text);
        let predicate = predicate.map_err(|error| vocabulary.predicate_problem(&error))?;
        self.judges.predicates.push(predicate);
        self.judges.texts.push(text.to_owned());
        let place = self.judges.predicates.len() - 1;
        self.places.insert(text.to_owned(), place);
        Ok(place)
    }

    fn clock(&mut self, text: &str) -> Result<usize, Problem> {
        if let Some(place) = self.clocks.get(text) {
            return Ok(*place);
        }
        let vocabulary = self.judges.vocabulary;
        let quantity = vocabulary.signals.quantity(text);
        let quantity = quantity.map_err(|error| vocabulary.predicate_problem(&error))?;
        self.judges.clocks.push(quantity);
        let place = self.judges.clocks.len() - 1;
        self.clocks.insert(text.to_owned(), place);
        Ok(place)
    }
}

impl CompiledRule {
    fn new(rule: &Rule) -> Result<Self, Problem> {
        match rule {
            Rule::Staged(spec) => {
                let monitor = Monitor::compile(spec)
                    .map_err(|error| Problem::new("bad-monitor", error.to_string()))?;
                let robustness = monitor.robustness().map(Box::new);
                Ok(Self::Staged {
                    monitor,
                    robustness,
                })
            }
            Rule::Formula(formula) => Self::formula(formula),
        }
    }

    fn formula(rule: &FormulaRule) -> Result<Self, Problem> {
        let monitor = FormulaMonitor::compile(&rule.parsed.formula, &rule.settings())
            .map_err(|error| Problem::new("bad-formula", error.to_string()))?;
        let atoms = rule.parsed.atoms.iter().map(|atom| atom.text.clone());
        Ok(Self::Formula {
            monitor: Box::new(monitor),
            formula: Box::new(rule.parsed.formula.clone()),
            settings: Box::new(rule.settings()),
            atoms: atoms.collect(),
        })
    }

    fn propositions(&self) -> &[String] {
        match self {
            Self::Staged { monitor, .. } => monitor.propositions(),
            Self::Formula { atoms, .. } => atoms,
        }
    }
}

/// A subject's judging forms: the main one and those of other readings.
fn written_forms(form: &SubjectForm) -> impl Iterator<Item = (Option<&str>, &JudgingForm)> {
    let main = form.monitor.iter().map(|judging| (None, judging));
    let others = form
        .readings
        .iter()
        .map(|reading| (Some(reading.name.as_str()), &reading.monitor));
    main.chain(others)
}

/// Everything that judging a trace of a study depends on, besides this program.
pub fn inputs_of(study: &Study, inputs: &mut Inputs) {
    for form in &study.forms.subjects {
        inputs.add("subject", form.subject.id().as_bytes());
        inputs.add_json("monitor", &form.monitor);
        // The forms that are held against the monitor.
        let sentence = form.sentence.as_ref();
        inputs.add_json("sentence", &sentence.map(|sentence| &sentence.text));
        let property = form.property.as_ref();
        inputs.add_json("property", &property.map(|property| &property.text));
        for reading in &form.readings {
            inputs.add("reading", reading.name.as_bytes());
            inputs.add("meaning", reading.meaning.as_bytes());
            inputs.add_json("monitor", &reading.monitor);
        }
    }
    inputs.add_json("step", &study.about.model.step_secs());
    for (name, proposition) in &study.vocabulary.propositions {
        if let Some(binding) = &proposition.trace {
            inputs.add(name, binding.text.as_bytes());
        }
    }
    for (name, parameter) in &study.parameters.declared {
        inputs.add(name, parameter.text.as_bytes());
    }
}

/// A monitor's verdict as it stands in results.
pub fn run_verdict(verdict: Verdict) -> RunVerdict {
    match verdict {
        Verdict::NotCovered => RunVerdict::NotCovered,
        Verdict::Satisfied => RunVerdict::Satisfied,
        Verdict::Violated => RunVerdict::Violated,
        Verdict::Inconclusive => RunVerdict::Inconclusive,
    }
}
