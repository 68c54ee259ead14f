//! How a trace is judged: by stages, or by a formula of temporal logic; both
//! written by hand or made from the requirement's sentence.

use super::Vocabulary;
use crate::placed::value_in;
use diagnostic::{Problem, Problems, Source};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use temporal::formula::{Ending, Formula, FormulaMonitor, Horizon, Parsed, Settings, TimeModel};
use temporal::monitor::{Monitor, MonitorSpec, SpecError, Stage};
use toml::Spanned;

/// How much later than the first the last signal may begin, unless that is said.
pub const START_WITHIN_SECS: f64 = 1.0;

/// One way of judging a trace.
#[derive(Clone, Debug, Serialize)]
pub struct JudgingForm {
    /// What is judged.
    pub rule: Rule,
    /// The signal whose value is the time, if it is not the recording's own
    /// clock; in seconds or in its unit.
    pub clock: Option<String>,
    /// By how much later than the first of the signals that are read the last
    /// one may begin for judging to begin with it, in seconds.
    pub start_within_secs: f64,
    /// Whether it comes from the requirement's sentence.
    pub from_sentence: bool,
}

/// What is judged.
#[derive(Clone, Debug, Serialize)]
pub enum Rule {
    /// A precondition, then postconditions in order.
    Staged(MonitorSpec),
    /// A formula of temporal logic.
    Formula(FormulaRule),
}

/// A formula with how it is to be read.
#[derive(Clone, Debug, Serialize)]
pub struct FormulaRule {
    /// The text, as it is written or was made.
    pub text: String,
    /// The same with the values of parameters in place.
    pub resolved: String,
    /// The formula and its atoms.
    #[serde(skip)]
    pub parsed: Parsed,
    /// What counts as covering it, if not what the formula waits for.
    #[serde(skip)]
    pub trigger: Option<Formula>,
    /// That in words.
    pub trigger_text: Option<String>,
    /// Whether time is a sequence of samples or dense.
    pub time: TimeModel,
    /// What is said of times behind the end of a recording.
    pub ending: Ending,
    /// Where it is written in its file, without the quotes, if it is.
    #[serde(skip)]
    pub place: Option<Range<usize>>,
}

impl JudgingForm {
    /// How long a run has to be for what it asks for to be seen; `None` where that is nothing, where runs are judged as if
    /// nothing came behind their ends, and of stages, whose `at_end` says what is pending.
    pub fn horizon(&self) -> Option<Horizon> {
        match &self.rule {
            Rule::Formula(rule) if rule.ending == Ending::LongEnough => {
                let horizon = Horizon::of(&rule.parsed.formula, rule.time).ok()?;
                (horizon != Horizon::default()).then_some(horizon)
            }
            Rule::Formula(_) | Rule::Staged(_) => None,
        }
    }
}

impl FormulaRule {
    /// What has a meaning that is perhaps not meant; `source` is the text in
    /// which the formula stands.
    pub fn warning(&self, source: &Source, place: &Range<usize>) -> Option<Problem> {
        if self.time == TimeModel::Dense {
            return None;
        }
        let instant = self.parsed.formula.exact_instants().into_iter().next()?;
        let place = self.place.as_ref().unwrap_or(place);
        Some(
            Problem::new(
                "exact-instant",
                format!(
                    "{instant} is one exact instant: where a recording has no sample just then, \
                     `eventually` is false and `always` true, whatever happened."
                ),
            )
            .at(source, place.clone())
            .remedy(
                "Widen the window to what may pass between two samples, or judge it in dense time, \
                 in which signals keep their values (`time = \"dense\"`, `--dense`).",
            ),
        )
    }

    /// The rule of a sentence's monitor.
    pub fn of_sentence(
        monitor: requirement_lang::compile::monitor::Monitor,
        time: TimeModel,
        ending: Ending,
    ) -> Self {
        let text = monitor.to_string();
        Self {
            resolved: text.clone(),
            text,
            trigger_text: Some(monitor.trigger_text()),
            parsed: monitor.requirement,
            trigger: Some(monitor.trigger),
            time,
            ending,
            place: None,
        }
    }

    /// How the engine is to judge it.
    pub fn settings(&self) -> Settings {
        Settings {
            trigger: self.trigger.clone(),
            ..match self.time {
                TimeModel::Discrete => Settings::discrete(self.ending),
                TimeModel::Dense => Settings::dense(self.ending),
            }
        }
        .with_robustness()
    }
}

/// The keys of a requirement or of a reading that say how traces are judged.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JudgingText {
    monitor: Option<Spanned<MonitorSpec>>,
    formula: Option<Spanned<String>>,
    time: Option<Spanned<TimeModel>>,
    ending: Option<Spanned<Ending>>,
    clock: Option<Spanned<String>>,
    start_within_secs: Option<Spanned<f64>>,
}

impl JudgingText {
    /// Takes the keys from a table that has others, too.
    pub fn new(
        monitor: Option<Spanned<MonitorSpec>>,
        formula: Option<Spanned<String>>,
        time: Option<Spanned<TimeModel>>,
        ending: Option<Spanned<Ending>>,
        clock: Option<Spanned<String>>,
        start_within_secs: Option<Spanned<f64>>,
    ) -> Self {
        Self {
            monitor,
            formula,
            time,
            ending,
            clock,
            start_within_secs,
        }
    }

    /// How much later than the first the last signal may begin.
    pub fn start_within_secs(&self) -> f64 {
        let limit = self.start_within_secs.as_ref();
        limit.map_or(START_WITHIN_SECS, |limit| *limit.get_ref())
    }

    /// How time is to be read, if that is written.
    pub fn time(&self) -> Option<TimeModel> {
        self.time.as_ref().map(|time| *time.get_ref())
    }

    /// How the end of a trace is to be read.
    pub fn ending(&self) -> Ending {
        let ending = self.ending.as_ref().map(|ending| *ending.get_ref());
        ending.unwrap_or(Ending::LongEnough)
    }

    /// The clock that was named.
    pub fn clock(&self) -> Option<String> {
        self.clock.as_ref().map(|clock| clock.get_ref().clone())
    }

    /// Checks the rule against the vocabulary; `None` if there is none.
    pub fn compile(
        self,
        source: &Source,
        vocabulary: &Vocabulary,
    ) -> Result<Option<JudgingForm>, Problem> {
        let reader = Reader { source, vocabulary };
        let (time, ending) = (self.time().unwrap_or_default(), self.ending());
        let clock = self.clock();
        let mut found = Problems::new();
        if let Some(clock) = &self.clock {
            found.keep(reader.check_clock(clock));
        }
        if let Some(limit) = &self.start_within_secs {
            found.keep(reader.check_limit(limit));
        }
        let start_within_secs = self.start_within_secs();
        let rule = match (self.monitor, self.formula) {
            (None, None) => return found.or(None),
            (Some(_), Some(formula)) => {
                found.add(
                    Problem::new(
                        "two-monitors",
                        "a requirement is judged by a monitor or by a formula, not by both",
                    )
                    .at(source, formula.span())
                    .remedy("move one of them into a [requirement.reading.NAME]"),
                );
                None
            }
            (Some(monitor), None) => {
                let time = self.time.as_ref().map(Spanned::span);
                if let Some(place) = time.or(self.ending.as_ref().map(Spanned::span)) {
                    found.add(
                        Problem::new(
                            "not-for-monitors",
                            "`time` and `ending` are for formulas; a monitor in stages has `at_end`",
                        )
                        .at(source, place)
                        .remedy("remove it, or write `monitor.at_end`"),
                    );
                }
                found.keep(reader.staged(monitor)).map(Rule::Staged)
            }
            (None, Some(formula)) => {
                let rule = reader.formula(&formula, time, ending);
                found.keep(rule).map(Rule::Formula)
            }
        };
        found.or(rule.map(|rule| JudgingForm {
            rule,
            clock,
            start_within_secs,
            from_sentence: false,
        }))
    }
}

struct Reader<'a> {
    source: &'a Source,
    vocabulary: &'a Vocabulary,
}

impl Reader<'_> {
    fn check_clock(&self, clock: &Spanned<String>) -> Result<(), Problem> {
        let quantity = self.vocabulary.signals.quantity(clock.get_ref());
        quantity.map(drop).map_err(|error| {
            Problem::new("bad-clock", error.to_string())
                .at(self.source, clock.span())
                .remedy("name a signal that holds the time, for example \"/clock.wall\"")
        })
    }

    fn check_limit(&self, limit: &Spanned<f64>) -> Result<(), Problem> {
        let secs = *limit.get_ref();
        if secs >= 0.0 {
            return Ok(());
        }
        Err(Problem::new(
            "bad-form",
            format!("`start_within_secs` must be a number of seconds from 0 (got {secs})"),
        )
        .at(self.source, limit.span())
        .remedy("give the longest time between the beginnings of two signals, for example 0.5"))
    }

    fn staged(&self, monitor: Spanned<MonitorSpec>) -> Result<MonitorSpec, Problem> {
        let span = monitor.span();
        let spec = monitor.into_inner();
        let mut found = Problems::new();
        let alone = |place: usize| MonitorSpec {
            then: spec.then[place..=place].to_vec(),
            ..spec.clone()
        };
        // What is waited for to begin with, also where no stage can be read.
        let when = MonitorSpec {
            then: vec![Stage::Assert {
                proposition: spec.when.clone(),
            }],
            ..spec.clone()
        };
        if let Ok(compiled) = Monitor::compile(&when) {
            for name in compiled.propositions() {
                found.keep(self.bound(name, self.place_of(name, &span)));
            }
        }
        for place in 0..spec.then.len() {
            // Each stage by itself, so that the mistake of one hides no other.
            match Monitor::compile(&alone(place)) {
                Ok(compiled) => {
                    for name in compiled.propositions() {
                        let place = self.place_of(name, &span);
                        found.keep(self.bound(name, place));
                    }
                }
                Err(error) => found.add(self.bad_stage(&error, place, &span)),
            }
        }
        if found.is_empty()
            && let Err(error) = Monitor::compile(&spec)
        {
            found.add(self.bad_stage(&error, 0, &span));
        }
        found.or(spec)
    }

    /// A mistake of a monitor's stage, at the value that is wrong as far as that is known.
    fn bad_stage(&self, error: &SpecError, stage: usize, monitor: &Range<usize>) -> Problem {
        let limit = match error {
            SpecError::BadWithin { within_secs } => {
                value_in(self.source, monitor, &|key, value| {
                    let number = value.as_float().map(|it| it.as_str().parse::<f64>());
                    let number =
                        number.or_else(|| value.as_integer().map(|it| it.as_str().parse()));
                    key == "within_secs" && number == Some(Ok(*within_secs))
                })
            }
            _ => None,
        };
        let of_stage = || {
            let then = value_in(self.source, monitor, &|key, value| {
                key == "then" && value.is_array()
            })?;
            let stages = crate::placed::elements(self.source, &then);
            stages.into_iter().nth(stage)
        };
        let place = limit.or_else(of_stage).unwrap_or_else(|| monitor.clone());
        Problem::new("bad-monitor", error.to_string())
            .at(self.source, place)
            .remedy("correct that stage (`corroborate explain monitor`)")
    }

    fn formula(
        &self,
        text: &Spanned<String>,
        time: TimeModel,
        ending: Ending,
    ) -> Result<FormulaRule, Problem> {
        // Without its quotes.
        let start = text.span().start + 1;
        let place = |span: Range<usize>| start + span.start..start + span.end;
        let parameters = self.vocabulary.signals.parameters();
        let parsed = temporal::formula::parse(text.get_ref(), &|name| parameters.secs(name))
            .map_err(|error| {
                Problem::new("bad-formula", error.message)
                    .at(self.source, place(error.span))
                    .remedy(error.remedy)
            })?;
        let mut found = Problems::new();
        for atom in &parsed.atoms {
            found.keep(self.bound(&atom.text, place(atom.span.clone())));
        }
        found.or(())?;
        let rule = FormulaRule {
            text: text.get_ref().clone(),
            resolved: parsed.to_string(),
            trigger: None,
            trigger_text: parsed
                .formula
                .trigger()
                .map(|trigger| trigger.display(&parsed.atoms).to_string()),
            parsed,
            time,
            ending,
            place: Some(start..text.span().end.saturating_sub(1)),
        };
        FormulaMonitor::compile(&rule.parsed.formula, &rule.settings()).map_err(|error| {
            Problem::new("bad-formula", error.to_string()).at(self.source, text.span())
        })?;
        Ok(rule)
    }

    /// Checks that a proposition, or a predicate of signals, can be judged on
    /// traces.
    fn bound(&self, text: &str, place: Range<usize>) -> Result<(), Problem> {
        if is_name(text) {
            let proposition = self
                .vocabulary
                .proposition(text, self.source, place.clone())?;
            if proposition.trace.is_some() {
                return Ok(());
            }
            return Err(Problem::new(
                "unbound-proposition",
                format!("the monitor uses `{text}`, which is not bound to traces"),
            )
            .at(self.source, place)
            .remedy(format!(
                "give [{text}] a `trace = \"…\"` in {}",
                self.vocabulary.source.name
            )));
        }
        self.vocabulary
            .signals
            .predicate(text)
            .and_then(|predicate| predicate.check())
            .map_err(|error| {
                Problem::new("bad-predicate", error.kind.to_string())
                    .at(
                        self.source,
                        place.start + error.span.start..place.start + error.span.end,
                    )
                    .remedy("correct the predicate, or name it in the vocabulary")
            })
    }

    /// Where a name is written in a monitor, or the monitor.
    fn place_of(&self, name: &str, monitor: &Range<usize>) -> Range<usize> {
        let is_name = |value: &toml::de::DeValue<'_>| value.as_str() == Some(name);
        let has_name = |value: &toml::de::DeValue<'_>| {
            value.as_str().is_some_and(|text| {
                let mut words = text.split(|c: char| !(c.is_alphanumeric() || c == '_'));
                words.any(|word| word == name)
            })
        };
        let whole = value_in(self.source, monitor, &|_, value| is_name(value));
        let part = || value_in(self.source, monitor, &|_, value| has_name(value));
        let Some(place) = whole.or_else(part) else {
            return monitor.clone();
        };
        let written = self.source.text.get(place.clone()).unwrap_or_default();
        match written.find(name) {
            Some(at) => place.start + at..place.start + at + name.len(),
            None => place,
        }
    }
}

/// Whether a text is the name of a proposition, not a predicate.
pub fn is_name(text: &str) -> bool {
    let mut letters = text.chars();
    letters
        .next()
        .is_some_and(|c| c.is_alphabetic() || c == '_')
        && letters.all(|c| c.is_alphanumeric() || c == '_')
        && text != "true"
        && text != "false"
}
