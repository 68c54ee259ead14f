//! What a trace leaves open that ends before the windows of a formula do.
//!
//! # Definition
//! The *horizon* of a formula is the longest time that its bounded windows of the future reach, one within another:
//! 10 s of `always[0, 10 s] p`, 14 s of `always[0, 10 s] (p => eventually[0, 4 s] q)`; a window without an end reaches as far as
//! it begins, since "the trace is all there is" gives it one. A trace is *short* of a formula if its length is less than 99 %
//! of the horizon. (A second of samples at 100 Hz ends 10 ms early, and says nonetheless what a second says.)
//!
//! Of a short trace, what lies behind its end within a bounded window is unknown, and what lies there otherwise is
//! nothing, as with [`Ending::Finite`]. With an atom `u` that is always unknown, and `cut` for
//! "no sample comes as late as the window ends", `!eventually[high, inf) true` (of a window without an end "begins", with `low`):
//!
//! ```text
//! eventually[low, high] f       becomes   eventually[low, high] f | (cut & u)
//! always[low, high] f           becomes   always[low, high] f & !(cut & u)
//! left until[low, high] right   becomes   left until[low, high] right | (cut & u & always left)
//! left release[low, high] right becomes   left release[low, high] right & !(cut & u & always !left)
//! next f                        becomes   next f | (cut & u)
//! ```
//!
//! The last factor is left out where `left` has operators of time.
//!
//! # Source
//! Our own; the three values are those of Bauer, Leucker and Schallhart, "Runtime verification for LTL and TLTL" (2011), on
//! the bounded windows alone.
//!
//! # Assumes
//! That the samples are all there were until the last one.
//!
//! # Guarantee
//! A verdict that is given is that of every continuation of the trace in which no window without an end is looked
//! at behind the trace's end. Not complete: a verdict may stay open where all continuations agree. A trace that is not short
//! is judged as before. Held against the engines' own three-valued verdicts in `tests/integration/formula_early_end.rs`.

use std::fmt;

use super::ast::{AtomId, Bound, Formula, Interval, TimeUnit, Window};
use super::monitor::{BothValues, FormulaJudge, FormulaMonitor};
use super::report::{FormulaReport, StepError};
use super::settings::{CompileError, Ending, Settings, TimeModel};
use crate::monitor::Verdict;

/// The share of the horizon that a trace has to reach.
const REACHED: f64 = 0.99;

/// How far the bounded windows of a formula reach.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Horizon {
    /// In seconds.
    pub secs: f64,
    /// In samples.
    pub samples: u64,
}

impl Horizon {
    /// That of a formula.
    ///
    /// # Errors
    /// [`CompileError`] if an interval makes no sense.
    pub fn of(formula: &Formula, time: TimeModel) -> Result<Self, CompileError> {
        let mut furthest = Self::default();
        for operand in formula.operands() {
            let inner = Self::of(operand, time)?;
            furthest = Self {
                secs: furthest.secs.max(inner.secs),
                samples: furthest.samples.max(inner.samples),
            };
        }
        if matches!(formula, Formula::Next(_)) {
            furthest.samples += 1;
        }
        let Some(interval) = formula.interval().filter(|_| looks_ahead(formula)) else {
            return Ok(furthest);
        };
        match interval.window(time)? {
            Window::Seconds {
                low_secs,
                high_secs,
            } => furthest.secs += ended(high_secs).unwrap_or(low_secs),
            Window::Samples { low, high } => furthest.samples += high.unwrap_or(low),
        }
        Ok(furthest)
    }

    /// Whether it is nothing.
    pub(super) fn is_none(&self) -> bool {
        self.secs <= 0.0 && self.samples == 0
    }

    /// Whether a trace of this length, with so many samples behind the first, reaches it.
    pub(super) fn is_reached(&self, length_secs: f64, samples: u64) -> bool {
        length_secs >= REACHED * self.secs && samples >= self.samples
    }
}

impl fmt::Display for Horizon {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.secs > 0.0, self.samples) {
            (true, 0) => write!(out, "{} s", self.secs),
            (true, samples) => write!(out, "{} s and {samples} samples more", self.secs),
            (false, samples) => write!(out, "{samples} samples after the first"),
        }
    }
}

/// The end of a window in seconds, if it has one.
fn ended(high_secs: f64) -> Option<f64> {
    high_secs.is_finite().then_some(high_secs)
}

/// Whether it is an operator of the future.
fn looks_ahead(formula: &Formula) -> bool {
    matches!(
        formula,
        Formula::Eventually(..)
            | Formula::Always(..)
            | Formula::Until(..)
            | Formula::WeakUntil(..)
            | Formula::Release(..)
    )
}

/// The formula in which what a bounded window does not see is the atom `unknown`. Its intervals make sense.
pub(super) fn opened(formula: &Formula, time: TimeModel, unknown: AtomId) -> Formula {
    let part = |inner: &Formula| Box::new(opened(inner, time, unknown));
    let all = |parts: &[Formula]| parts.iter().map(|it| opened(it, time, unknown)).collect();
    let open = |interval: &Interval| open_behind(interval, time, unknown);
    match formula {
        Formula::True | Formula::False | Formula::Atom(_) => formula.clone(),
        Formula::Not(f) => Formula::Not(part(f)),
        Formula::And(parts) => Formula::And(all(parts)),
        Formula::Or(parts) => Formula::Or(all(parts)),
        Formula::Implies(f, g) => Formula::Implies(part(f), part(g)),
        Formula::Iff(f, g) => Formula::Iff(part(f), part(g)),
        Formula::Next(f) => some(Formula::Next(part(f)), open(&Interval::samples(1, 1))),
        Formula::Previous(f) => Formula::Previous(part(f)),
        Formula::Rise(f) => Formula::Rise(part(f)),
        Formula::Fall(f) => Formula::Fall(part(f)),
        Formula::Once(i, f) => Formula::Once(*i, part(f)),
        Formula::Historically(i, f) => Formula::Historically(*i, part(f)),
        Formula::Since(i, f, g) => Formula::Since(*i, part(f), part(g)),
        Formula::Eventually(i, f) => some(Formula::Eventually(*i, part(f)), open(i)),
        Formula::Always(i, f) => every(Formula::Always(*i, part(f)), open(i)),
        Formula::Until(i, f, g) => {
            let waits = open(i).map(|open| Formula::and(open, throughout(f)));
            some(Formula::Until(*i, part(f), part(g)), waits)
        }
        Formula::Release(i, f, g) => {
            let never = throughout(&Formula::not(f.as_ref().clone()));
            let held = open(i).map(|open| Formula::and(open, never));
            every(Formula::Release(*i, part(f), part(g)), held)
        }
        // By its definition.
        Formula::WeakUntil(i, f, g) => {
            let either = Formula::or(f.as_ref().clone(), g.as_ref().clone());
            opened(
                &Formula::Release(*i, g.clone(), Box::new(either)),
                time,
                unknown,
            )
        }
    }
}

/// That it holds from here to the end of the trace; true of what has operators of its own, which would stand there twice, at
/// each depth again.
fn throughout(formula: &Formula) -> Formula {
    match formula.is_propositional() {
        true => Formula::always(Interval::UNBOUNDED, formula.clone()),
        false => Formula::True,
    }
}

/// True where the trace may go on into the window; `None` of one that is here alone.
fn open_behind(interval: &Interval, time: TimeModel, unknown: AtomId) -> Option<Formula> {
    let low = match interval.window(time).ok()? {
        Window::Seconds {
            low_secs,
            high_secs,
        } => Bound::secs(ended(high_secs).unwrap_or(low_secs)),
        Window::Samples { low, high } => Bound {
            value: high.unwrap_or(low) as f64,
            unit: TimeUnit::Samples,
        },
    };
    let behind = Interval { low, high: None };
    let seen = Formula::eventually(behind, Formula::True);
    (low.value > 0.0).then(|| Formula::and(Formula::not(seen), Formula::Atom(unknown)))
}

fn some(formula: Formula, open: Option<Formula>) -> Formula {
    match open {
        Some(open) => Formula::or(formula, open),
        None => formula,
    }
}

fn every(formula: Formula, open: Option<Formula>) -> Formula {
    match open {
        Some(open) => Formula::and(formula, Formula::not(open)),
        None => formula,
    }
}

/// The formula that is judged beside the one that was given, as long as the trace is short.
#[derive(Debug, Clone)]
pub(super) struct EarlyMonitor {
    monitor: FormulaMonitor,
    horizon: Horizon,
}

/// It at work.
#[derive(Debug, Clone)]
pub(super) struct EarlyJudge {
    judge: FormulaJudge,
    horizon: Horizon,
    first_secs: Option<f64>,
    /// How many samples came behind the first.
    samples: u64,
}

impl EarlyMonitor {
    /// That of a formula; `None` if no trace is short of it, or if another ending is asked for.
    ///
    /// # Errors
    /// As of [`FormulaMonitor::compile`].
    pub(super) fn compile(
        formula: &Formula,
        settings: &Settings,
    ) -> Result<Option<Self>, CompileError> {
        let horizon = Horizon::of(formula, settings.time)?;
        if settings.ending != Ending::LongEnough || horizon.is_none() {
            return Ok(None);
        }
        let trigger = settings.trigger.as_ref().or_else(|| formula.trigger());
        let of_trigger = trigger.map_or(0, Formula::atom_count);
        let unknown = AtomId(formula.atom_count().max(of_trigger));
        let settings = Settings {
            ending: Ending::Finite,
            explain_samples: 0,
            trigger: trigger.cloned(),
            ..settings.clone()
        };
        // The unknown atom is always among the atoms.
        let among = Formula::or(Formula::True, Formula::Atom(unknown));
        let opened = Formula::and(opened(formula, settings.time, unknown), among);
        let monitor = FormulaMonitor::compile(&opened, &settings)?;
        Ok(Some(Self { monitor, horizon }))
    }

    /// Begins to judge a trace.
    pub(super) fn start(&self) -> EarlyJudge {
        EarlyJudge {
            judge: self.monitor.start(),
            horizon: self.horizon,
            first_secs: None,
            samples: 0,
        }
    }
}

impl EarlyJudge {
    /// Takes the samples of an instant, each without the unknown atom.
    pub(super) fn step(
        &mut self,
        time_secs: f64,
        samples: &[BothValues<'_>],
    ) -> Result<(), StepError> {
        let longer: Vec<_> = samples.iter().map(with_unknown).collect();
        let longer: Vec<BothValues<'_>> = longer.iter().map(|it| (&it.0[..], &it.1[..])).collect();
        self.judge.step_instant(time_secs, &longer)?;
        self.samples += samples.len() as u64 - u64::from(self.first_secs.is_none());
        self.first_secs.get_or_insert(time_secs);
        Ok(())
    }

    /// As [`FormulaJudge::lose`].
    pub(super) fn lose(
        &mut self,
        span: (f64, f64),
        next_secs: f64,
        held: BothValues<'_>,
    ) -> Result<(), StepError> {
        let (truth, values) = with_unknown(&held);
        self.judge.lose(span, next_secs, (&truth, &values))
    }

    /// Whether the trace is not short any more at this time.
    pub(super) fn is_over(&self, time_secs: f64) -> bool {
        let length_secs = self
            .first_secs
            .map_or(0.0, |first_secs| time_secs - first_secs);
        // Of what nothing changes behind, for ever, all samples that could be asked for are known.
        time_secs == f64::INFINITY || self.horizon.is_reached(length_secs, self.samples)
    }

    /// What is said of the short trace, if that is open, in place of a verdict that only its end gave.
    pub(super) fn said_instead(self, report: &FormulaReport) -> Option<FormulaReport> {
        let by_its_end = matches!(report.verdict, Verdict::Satisfied | Verdict::Violated)
            && report.decided_at_secs.is_none();
        if !by_its_end {
            return None;
        }
        let horizon = self.horizon;
        let found = self.judge.finish(true);
        (found.verdict == Verdict::Inconclusive).then(|| FormulaReport {
            verdict: Verdict::Inconclusive,
            robustness: found.robustness,
            ends_before: Some(horizon),
            explanation: None,
            ..report.clone()
        })
    }
}

/// A sample with the unknown atom behind the others.
fn with_unknown((truth, values): &BothValues<'_>) -> (Vec<Option<bool>>, Vec<f64>) {
    ([*truth, &[None]].concat(), [*values, &[f64::NAN]].concat())
}
