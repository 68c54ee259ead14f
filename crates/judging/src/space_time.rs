//! How near an episode came to the violation of a requirement: what searches and splitting go by.
//!
//! # Definition
//! Of stages their space-time robustness ([`temporal::monitor::SpaceTimeJudge`]), of a formula its robustness, both over
//! propositions with *degrees*: of a proposition with `graded` in the vocabulary the robustness of that
//! predicate, of others their own; divided by the greatest magnitude that it compares with, in SI units,
//! so that it is a share of a limit. Where a predicate compares no numbers, the degree is
//! infinite, and stages measure time instead. A sentence is taken in stages where it can be put so.
//!
//! # Guarantee
//! The monitors decide whether a requirement is violated; a degree whose sign contradicts the truth counts
//! as next to nothing. So a wrong `graded` makes a search slow, never a result wrong.

use super::{Collector, CompiledRule, Judges, SubjectJudge, session::own_time};
use diagnostic::Problem;
use requirement_lang::compile::staged::staged;
use std::sync::Arc;
use study::{JudgingForm, Rule, Study, SubjectForm, Vocabulary};
use temporal::formula::{Ending, FormulaJudge};
use temporal::monitor::{AtEnd, Graded, MonitorSpec, SpaceTimeJudge, Verdict};
use trace::{BoundPredicate, BoundQuantity, Predicate, Replay, SignalValues, Trace};

/// The space-time robustness of one requirement or failure mode, ready to be computed on traces.
#[derive(Debug)]
pub struct SpaceTime<'a> {
    /// Holds one monitor.
    judges: Judges<'a>,
    /// For each of its propositions, what grades it, if that is another predicate.
    graded: Vec<Option<Predicate>>,
    /// The time by which every episode ends, if that is known.
    ends_by_secs: Option<f64>,
}

/// It at work on one episode.
#[derive(Clone)]
pub struct SpaceTimeSession<'m> {
    bound: Arc<Bound>,
    work: Work<'m>,
    last_secs: f64,
    values: Vec<Graded>,
}

/// What is read of a trace with a certain layout.
struct Bound {
    propositions: Vec<(BoundPredicate, Scaled)>,
    clock: Option<BoundQuantity>,
    /// The channels that are read.
    channels: Vec<usize>,
}

/// A predicate as a degree.
struct Scaled {
    predicate: BoundPredicate,
    /// The degree is the robustness divided by this.
    scale: f64,
}

#[derive(Clone)]
enum Work<'m> {
    Staged(Box<SpaceTimeJudge<'m>>),
    Formula(Box<FormulaJudge>),
}

impl<'a> SpaceTime<'a> {
    /// That of the main monitor of `id`; `None` if it has none. `ends_by_secs`: the time by which every
    /// episode ends, if that is known.
    pub fn new(
        study: &'a Study,
        id: &str,
        ends_by_secs: Option<f64>,
    ) -> Result<Option<Self>, Problem> {
        let form = study.forms.subjects.iter().find(|f| f.subject.id() == id);
        let Some((form, judging)) = form.and_then(|f| Some((f, f.monitor.as_ref()?))) else {
            return Ok(None);
        };
        let mut collector = Collector::of_study(study);
        match in_stages(form, judging) {
            Some(in_stages) => collector.add(&form.subject, None, &in_stages)?,
            None => collector.add(&form.subject, None, judging)?,
        }
        let judges = collector.judges;
        let names = judges.judges.iter().flat_map(|it| it.rule.propositions());
        let graded = names.map(|name| graded(&study.vocabulary, name));
        Ok(Some(Self {
            graded: graded.collect::<Result<_, _>>()?,
            judges,
            ends_by_secs,
        }))
    }

    /// Begins with an episode whose trace has the channels of `layout`.
    pub fn start(&self, layout: &Trace) -> Result<SpaceTimeSession<'_>, Problem> {
        let judge = self.judge();
        let places = judge.propositions.iter().zip(&self.graded);
        let propositions = places.map(|(place, graded)| {
            let predicate = &self.judges.predicates[*place];
            let wrong = |error: trace::PredicateError| self.judges.in_proposition(*place, &error);
            let degree = match graded {
                Some(graded) => scaled(graded, layout).map_err(|error| {
                    in_graded(self.judges.vocabulary, &self.judges.texts[*place], &error)
                })?,
                None => scaled(predicate, layout).map_err(wrong)?,
            };
            Ok((predicate.bind(layout).map_err(wrong)?, degree))
        });
        let propositions = propositions.collect::<Result<Vec<_>, Problem>>()?;
        let clock = judge.clock.map(|place| {
            let bound = self.judges.clocks[place].bind(layout);
            bound.map_err(|error| self.judges.in_clock(place, &error))
        });
        let unknown = Graded {
            truth: None,
            degree: f64::NAN,
        };
        Ok(SpaceTimeSession {
            values: vec![unknown; propositions.len()],
            bound: Arc::new(Bound::new(propositions, clock.transpose()?)),
            work: match &judge.rule {
                CompiledRule::Staged { monitor, .. } => {
                    Work::Staged(Box::new(SpaceTimeJudge::new(monitor, self.ends_by_secs)))
                }
                CompiledRule::Formula { monitor, .. } => Work::Formula(Box::new(monitor.start())),
            },
            last_secs: f64::NEG_INFINITY,
        })
    }

    /// That of an episode; `None` if it says nothing: the requirement did not come up, or nothing in
    /// it is a number.
    pub fn of(&self, trace: &Trace) -> Result<Option<f64>, Problem> {
        let mut session = self.start(trace)?;
        let mut replay = Replay::new(trace);
        let mut is_sample = false;
        while let Some(sample) = replay.advance() {
            is_sample |= session.reads(replay.changed());
            if is_sample && !sample.more {
                session.step(sample.time_secs, &replay)?;
                is_sample = false;
            }
        }
        Ok(session.finish(trace.complete))
    }

    fn judge(&self) -> &SubjectJudge<'a> {
        // One was added.
        &self.judges.judges[0]
    }
}

impl Bound {
    fn new(propositions: Vec<(BoundPredicate, Scaled)>, clock: Option<BoundQuantity>) -> Self {
        let of_predicates = propositions
            .iter()
            .flat_map(|(predicate, _)| predicate.signals());
        let of_clock = clock.iter().flat_map(BoundQuantity::signals);
        let signals = of_predicates.chain(of_clock);
        Self {
            channels: signals.map(|signal| signal.channel).collect(),
            propositions,
            clock,
        }
    }
}

impl SpaceTimeSession<'_> {
    /// Whether it reads one of the channels that have changed: at other times it has no sample.
    pub fn reads(&self, changed: &[bool]) -> bool {
        let channels = &self.bound.channels;
        channels.is_empty()
            || channels
                .iter()
                .any(|it| changed.get(*it).is_none_or(|it| *it))
    }

    /// Takes the next instant, at which signals have the given values.
    pub fn step<V: SignalValues>(&mut self, time_secs: f64, values: &V) -> Result<(), Problem> {
        let bound = Arc::clone(&self.bound);
        let now_secs = match &bound.clock {
            None => Some(time_secs),
            Some(clock) => own_time(clock, values, self.last_secs),
        };
        let Some(now_secs) = now_secs else {
            return Ok(());
        };
        self.last_secs = now_secs;
        for (value, (predicate, degree)) in self.values.iter_mut().zip(&bound.propositions) {
            let robustness = degree.predicate.robustness(values).unwrap_or(f64::NAN);
            *value = Graded {
                truth: predicate.eval(values),
                degree: robustness / degree.scale,
            };
        }
        let bad = |error: String| Problem::new("bad-recording", error);
        let values = &self.values;
        match &mut self.work {
            Work::Staged(judge) => judge
                .step(now_secs, &|proposition| values[proposition])
                .map_err(|error| bad(error.to_string())),
            Work::Formula(judge) => {
                let truth: Vec<Option<bool>> = values.iter().map(|it| it.truth).collect();
                let degrees: Vec<f64> = values.iter().map(formula_value).collect();
                let taken = judge.step_both(now_secs, &truth, &degrees);
                taken.map(drop).map_err(|error| bad(error.to_string()))
            }
        }
    }

    /// What it is so far, which never rises; `None` as long as there is none.
    pub fn so_far(&self) -> Option<f64> {
        match &self.work {
            Work::Staged(judge) => judge.so_far(),
            Work::Formula(judge) => {
                let bounds = judge.robustness_bounds()?;
                bounds.high.is_finite().then_some(bounds.high)
            }
        }
    }

    /// Ends the episode; `complete` is false if it was cut short. An episode that was ended because the
    /// requirement was decided has what was seen.
    pub fn finish(self, complete: bool) -> Option<f64> {
        match self.work {
            Work::Staged(judge) => judge.finish(complete),
            Work::Formula(judge) => {
                let report = judge.finish(complete);
                let bounds = report.robustness?;
                let seen = match report.verdict {
                    Verdict::Violated => [bounds.high, bounds.low],
                    _ => [bounds.low, bounds.high],
                };
                seen.into_iter().find(|bound| bound.is_finite())
            }
        }
    }
}

/// The same judging in stages, where it is by a sentence that can be put so: stages measure time.
fn in_stages(form: &SubjectForm, judging: &JudgingForm) -> Option<JudgingForm> {
    let sentence = form.sentence.as_ref().filter(|_| judging.from_sentence)?;
    let Rule::Formula(formula) = &judging.rule else {
        return None;
    };
    let spec = staged(&sentence.tree).ok()?;
    let at_end = match formula.ending {
        Ending::Finite | Ending::LongEnough | Ending::Strong => AtEnd::FailPending,
        Ending::Inconclusive | Ending::Weak => AtEnd::InconclusivePending,
    };
    Some(JudgingForm {
        rule: Rule::Staged(MonitorSpec { at_end, ..spec }),
        clock: judging.clock.clone(),
        start_within_secs: judging.start_within_secs,
        from_sentence: true,
    })
}

/// What a formula's engine takes: unknown, or a number with the sign of the truth.
fn formula_value(graded: &Graded) -> f64 {
    match graded.truth {
        None => f64::NAN,
        Some(true) if graded.degree.is_nan() => f64::INFINITY,
        Some(true) => graded.degree.max(f64::MIN_POSITIVE),
        Some(false) if graded.degree.is_nan() => f64::NEG_INFINITY,
        Some(false) => graded.degree.min(-f64::MIN_POSITIVE),
    }
}

/// The predicate that grades a proposition, if the vocabulary has one for it.
fn graded(vocabulary: &Vocabulary, name: &str) -> Result<Option<Predicate>, Problem> {
    let proposition = vocabulary.propositions.get(name);
    let Some(binding) = proposition.and_then(|it| it.graded.as_ref()) else {
        return Ok(None);
    };
    let predicate = vocabulary.signals.predicate(&binding.text);
    predicate
        .map(Some)
        .map_err(|error| in_graded(vocabulary, name, &error))
}

/// An error in the predicate that grades a proposition, at its place in the vocabulary: in `graded`, or in the proposition
/// that it names.
fn in_graded(vocabulary: &Vocabulary, name: &str, error: &trace::PredicateError) -> Problem {
    let proposition = vocabulary.propositions.get(name);
    let binding = proposition.and_then(|it| it.graded.as_ref());
    match binding.filter(|_| error.entry.is_none()) {
        None => vocabulary.predicate_problem(error),
        Some(binding) => {
            let at = binding.span.start;
            Problem::new("bad-predicate", error.kind.to_string())
                .at(
                    &vocabulary.source,
                    at + error.span.start..at + error.span.end,
                )
                .remedy("`graded` is a predicate over signals, such as \"/gripper.force > 0.5 N\"")
        }
    }
}

/// A predicate with the greatest magnitude that it compares numbers with.
fn scaled(predicate: &Predicate, layout: &Trace) -> Result<Scaled, trace::PredicateError> {
    let comparisons = predicate.comparisons_in(layout)?;
    let limits = comparisons.iter().map(|comparison| {
        let threshold = &comparison.threshold;
        threshold.si_value.unwrap_or(threshold.number).abs()
    });
    let greatest = limits.filter(|it| it.is_finite()).fold(0.0, f64::max);
    Ok(Scaled {
        predicate: predicate.bind(layout)?,
        scale: if greatest > 0.0 { greatest } else { 1.0 },
    })
}
