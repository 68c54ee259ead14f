//! What a trace leaves open that ends before the windows of a formula do.
//!
//! # Definition
//! The *horizon* of a formula is the longest time that its bounded windows of the future reach, one within another:
//! 10 s of `always[0, 10 s] p`, 14 s of `always[0, 10 s] (p => eventually[0, 4 s] q)`; a window without an end reaches as far as
//! it begins, since "the trace is all there is" gives it one.
//!
//! A formula is judged as the conjuncts that it has (`always (f & g)` are two). A trace is *short* of a conjunct if less than
//! its horizon follows its trigger's first time, or its first sample where it has no trigger, with a hundredth of its narrowest window
//! to spare: no window was seen whole. (A second of samples at 100 Hz ends 10 ms early, and says nonetheless what a second says. Nothing is
//! spared where the trace would be kept by what may come in that hundredth.) The trigger is all that has to hold before anything has to
//! come: `a & !c` of `always (a => (b[0, 4 s] | c))` with `b[0, 4 s]` for a window.
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
//! Of a trace that is not short, the windows that its end cuts are *left out*: what no continuation could repair violates the
//! formula, and what is pending does not. A response within 50 ms of each instant, of which the last 50 ms are always pending,
//! is judged by the instants before, and one that was asked for 1 s before the end of an hour and may come within 5 s is no violation. The
//! report says so where its verdict would be another by [`Ending::Finite`] ([`FormulaReport::left_out`]). A conjunct in which pending
//! windows cannot be told from what the end of the trace does decide (`always (p => eventually always[0, 1 s] q)`), whose windows
//! begin within an operator without an end (`always (p => always (q => eventually[0, 1 s] r))`) or are of seconds and of samples, is judged
//! like that of a short trace to its end. So is one in which windows stand within an operator of the past, or the other way round.
//!
//! # Source
//! Our own; the three values are those of Bauer, Leucker and Schallhart, "Runtime verification for LTL and TLTL" (2011), on
//! the bounded windows alone; what is left out is what Eisner et al., "Reasoning with temporal logic on truncated paths" (2003)
//! call the weak view.
//!
//! # Assumes
//! That the samples are all there were until the last one.
//!
//! # Guarantee
//! A violation is one of every continuation of the trace in which no window without an end is looked
//! at behind the trace's end. So is a satisfaction on a short trace; on another, of every window that was seen whole. Not complete: a
//! verdict may stay open where all continuations agree. Held against every continuation of short traces and against the engines' own
//! three-valued verdicts in `tests/integration/formula_early_end.rs`.

use std::fmt;

use super::ast::{AtomId, Bound, Formula, Interval, TimeUnit, Window};
use super::monitor::{BothValues, FormulaJudge, FormulaMonitor};
use super::report::{FormulaReport, RobustnessBounds, StepError};
use super::settings::{CompileError, Ending, Settings, TimeModel};
use crate::monitor::Verdict;

/// The share of a formula's narrowest window by which a trace may be shorter than its horizon.
const SPARED: f64 = 0.01;
/// The share of the horizon that rounding may take.
const ROUNDING: f64 = 1e-9;

/// How far the bounded windows of a formula reach.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Horizon {
    /// In seconds.
    pub secs: f64,
    /// In samples.
    pub samples: u64,
    /// By how much a trace may be shorter, in seconds.
    spared_secs: f64,
}

impl Horizon {
    /// That of a formula.
    ///
    /// # Errors
    /// [`CompileError`] if an interval makes no sense.
    pub fn of(formula: &Formula, time: TimeModel) -> Result<Self, CompileError> {
        let mut furthest = Self::default();
        for operand in formula.operands() {
            furthest = furthest.and(Self::of(operand, time)?);
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
            } => {
                let spared_secs = match ended(high_secs) {
                    Some(high_secs) if high_secs > low_secs => SPARED * (high_secs - low_secs),
                    _ => f64::INFINITY,
                };
                let inner_secs = match furthest.secs > 0.0 {
                    true => furthest.spared_secs,
                    false => f64::INFINITY,
                };
                furthest.secs += ended(high_secs).unwrap_or(low_secs);
                furthest.spared_secs = spared_secs.min(inner_secs).min(SPARED * furthest.secs);
            }
            Window::Samples { low, high } => furthest.samples += high.unwrap_or(low),
        }
        Ok(furthest)
    }

    /// What reaches as far as both.
    fn and(self, other: Self) -> Self {
        Self {
            secs: self.secs.max(other.secs),
            samples: self.samples.max(other.samples),
            spared_secs: match (self.secs > 0.0, other.secs > 0.0) {
                (true, true) => self.spared_secs.min(other.spared_secs),
                (true, false) => self.spared_secs,
                (false, _) => other.spared_secs,
            },
        }
    }

    /// Whether it is nothing.
    pub(super) fn is_none(&self) -> bool {
        self.secs <= 0.0 && self.samples == 0
    }

    /// Whether a trace of this length, with so many samples behind the first, reaches it.
    pub(super) fn is_reached(&self, length_secs: f64, samples: u64) -> bool {
        length_secs >= self.secs - self.spared_secs && samples >= self.samples
    }

    /// The same with nothing spared.
    fn is_passed(&self, length_secs: f64) -> bool {
        length_secs >= self.secs * (1.0 - ROUNDING)
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
        Formula::Next(_)
            | Formula::Eventually(..)
            | Formula::Always(..)
            | Formula::Until(..)
            | Formula::WeakUntil(..)
            | Formula::Release(..)
    )
}

/// Whether it is an operator of the past.
fn looks_back(formula: &Formula) -> bool {
    use Formula::{Fall, Historically, Once, Previous, Rise, Since};
    matches!(
        formula,
        Previous(_) | Rise(_) | Fall(_) | Once(..) | Historically(..) | Since(..)
    )
}

/// Whether a formula has operators of a kind.
fn speaks_of(formula: &Formula, kind: fn(&Formula) -> bool) -> bool {
    let mut operands = formula.operands().into_iter();
    kind(formula) || operands.any(|it| speaks_of(it, kind))
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

/// The conjuncts of a formula that are judged beside it.
#[derive(Debug, Clone)]
pub(super) struct EarlyMonitor {
    parts: Vec<Part>,
    /// Whether the trigger of the whole has windows of the future.
    looks_for_trigger: bool,
}

#[derive(Debug, Clone)]
struct Part {
    monitor: FormulaMonitor,
    horizon: Horizon,
    has_trigger: bool,
    /// Whether the end of a trace can violate it by its pending windows alone.
    ends_pending: bool,
    /// Whether its trigger has windows of the future.
    looks_for_trigger: bool,
    /// Whether nothing that comes before the trigger of the formula can matter.
    sleeps: bool,
}

/// They at work.
#[derive(Debug, Clone)]
pub(super) struct EarlyJudge {
    parts: Vec<PartJudge>,
    looks_for_trigger: bool,
    /// The horizons of the conjuncts that the trace is not short of any more, and when their windows began.
    left_out: Vec<(Horizon, f64)>,
    /// Until when the trace is known to have gone on.
    lasted_secs: f64,
    /// A sample with the unknown atom.
    longer: (Vec<Option<bool>>, Vec<f64>),
}

#[derive(Debug, Clone)]
struct PartJudge {
    judge: FormulaJudge,
    horizon: Horizon,
    has_trigger: bool,
    ends_pending: bool,
    looks_for_trigger: bool,
    /// Whether it waits for the trigger of the formula, which the formula itself sees.
    sleeps: bool,
    /// When its windows began: at the trigger, or the first sample.
    began_secs: Option<f64>,
    /// How many samples came behind.
    samples: u64,
}

impl EarlyMonitor {
    /// That of a formula; `None` if it has no window that an end could cut, or if another ending is asked for.
    ///
    /// # Errors
    /// As of [`FormulaMonitor::compile`].
    pub(super) fn compile(
        formula: &Formula,
        settings: &Settings,
    ) -> Result<Option<Self>, CompileError> {
        if settings.ending != Ending::LongEnough || Horizon::of(formula, settings.time)?.is_none() {
            return Ok(None);
        }
        let common = settings.trigger.as_ref().or_else(|| formula.trigger());
        let looks_for_trigger = common.is_some_and(|it| speaks_of(it, looks_ahead));
        let of_trigger = common.map_or(0, Formula::atom_count);
        let unknown = AtomId(formula.atom_count().max(of_trigger));
        let mut parts = Vec::new();
        for conjunct in conjuncts(formula) {
            let own = trigger_of(&conjunct);
            let is_common = own.is_some() && own.as_ref() == common;
            let trigger = (own, is_common);
            parts.extend(Part::compile(&conjunct, trigger, unknown, settings)?);
        }
        Ok(Some(Self {
            parts,
            looks_for_trigger,
        }))
    }

    /// Begins to judge a trace.
    pub(super) fn start(&self) -> EarlyJudge {
        EarlyJudge {
            parts: self.parts.iter().map(Part::start).collect(),
            looks_for_trigger: self.looks_for_trigger,
            left_out: Vec::new(),
            lasted_secs: f64::NEG_INFINITY,
            longer: Default::default(),
        }
    }
}

impl Part {
    /// That of a conjunct with its trigger, and whether that is the one of the formula; `None` if no end violates it.
    fn compile(
        conjunct: &Formula,
        (trigger, is_common): (Option<Formula>, bool),
        unknown: AtomId,
        settings: &Settings,
    ) -> Result<Option<Self>, CompileError> {
        let horizon = Horizon::of(conjunct, settings.time)?;
        let waits = waits_without_end(conjunct, true);
        if horizon.is_none() && !waits {
            return Ok(None);
        }
        let is_plain = !waits && !mixes_past(conjunct) && has_its_windows_in_front(conjunct);
        let ends_pending = is_plain && (horizon.secs <= 0.0 || horizon.samples == 0);
        let has_trigger = trigger.is_some();
        let looks_for_trigger = trigger
            .as_ref()
            .is_some_and(|it| speaks_of(it, looks_ahead));
        let of_formula = is_common && settings.time == TimeModel::Discrete;
        let sleeps = of_formula
            && trigger
                .as_ref()
                .is_some_and(|it| !speaks_of(it, looks_ahead))
            && !speaks_of(conjunct, looks_back);
        let opened_trigger = trigger.map(|it| opened(&it, settings.time, unknown));
        let settings = Settings {
            ending: Ending::Finite,
            explain_samples: 0,
            trigger: opened_trigger,
            ..settings.clone()
        };
        // The unknown atom is always among the atoms.
        let among = Formula::or(Formula::True, Formula::Atom(unknown));
        let opened = Formula::and(opened(conjunct, settings.time, unknown), among);
        Ok(Some(Self {
            monitor: FormulaMonitor::compile(&opened, &settings)?,
            horizon,
            has_trigger,
            ends_pending,
            looks_for_trigger,
            sleeps,
        }))
    }

    fn start(&self) -> PartJudge {
        PartJudge {
            judge: self.monitor.start(),
            horizon: self.horizon,
            has_trigger: self.has_trigger,
            ends_pending: self.ends_pending,
            looks_for_trigger: self.looks_for_trigger,
            sleeps: self.sleeps,
            began_secs: None,
            samples: 0,
        }
    }
}

/// What has to hold before a window of a conjunct has to be kept: of `always (a => (b | w))` with a window in `w`, `a & !b`.
/// `None` if nothing has to.
fn trigger_of(conjunct: &Formula) -> Option<Formula> {
    let mut body = conjunct;
    while let Formula::Always(_, inner) = body {
        body = inner;
    }
    if !speaks_of(body, looks_ahead) {
        return None;
    }
    let mut conditions = Vec::new();
    conditions_of(body, true, &mut conditions);
    match conditions.len() {
        0 | 1 => conditions.pop(),
        _ => Some(Formula::And(conditions)),
    }
}

/// The parts of a disjunction without windows, negated; of an implication, its left side as it is.
fn conditions_of(formula: &Formula, wanted: bool, into: &mut Vec<Formula>) {
    match (formula, wanted) {
        (Formula::Implies(left, right), true) => {
            into.push(left.as_ref().clone());
            conditions_of(right, true, into);
        }
        (Formula::Or(parts), true) => parts.iter().for_each(|it| conditions_of(it, true, into)),
        (Formula::And(parts), false) => parts.iter().for_each(|it| conditions_of(it, false, into)),
        (Formula::Not(inner), _) if speaks_of(inner, looks_ahead) => {
            conditions_of(inner, !wanted, into);
        }
        _ if speaks_of(formula, looks_ahead) => {}
        (_, true) => into.push(Formula::not(formula.clone())),
        (_, false) => into.push(formula.clone()),
    }
}

/// Whether an operator of the past stands over one of the future, or below one that is not the `always` in front.
fn mixes_past(conjunct: &Formula) -> bool {
    let mut body = conjunct;
    while let Formula::Always(_, inner) = body {
        body = inner;
    }
    fn mixed(formula: &Formula, is_ahead: bool) -> bool {
        let over = looks_back(formula)
            && (is_ahead
                || formula
                    .operands()
                    .iter()
                    .any(|it| speaks_of(it, looks_ahead)));
        let is_ahead = is_ahead || looks_ahead(formula);
        over || formula.operands().into_iter().any(|it| mixed(it, is_ahead))
    }
    mixed(body, false)
}

/// Whether no window stands within an operator of the future without an end, other than the `always` in front.
fn has_its_windows_in_front(conjunct: &Formula) -> bool {
    let mut body = conjunct;
    while let Formula::Always(_, inner) = body {
        body = inner;
    }
    fn is_endless(formula: &Formula) -> bool {
        looks_ahead(formula) && formula.interval().is_some_and(|it| it.high.is_none())
    }
    fn holds(formula: &Formula) -> bool {
        let mut operands = formula.operands().into_iter();
        match is_endless(formula) {
            true => !operands.any(|it| speaks_of(it, ends_in)),
            false => operands.all(holds),
        }
    }
    fn ends_in(formula: &Formula) -> bool {
        looks_ahead(formula) && !is_endless(formula)
    }
    holds(body)
}

/// Formulas whose conjunction it is, also in each instant of an `always`.
fn conjuncts(formula: &Formula) -> Vec<Formula> {
    match formula {
        Formula::And(parts) => parts.iter().flat_map(conjuncts).collect(),
        Formula::Always(interval, inner) => {
            let parts = conjuncts(inner).into_iter();
            parts.map(|part| Formula::always(*interval, part)).collect()
        }
        _ => vec![formula.clone()],
    }
}

/// Whether the formula, or its negation if not `wanted`, waits in a window without an end, so that the end of a trace decides it.
fn waits_without_end(formula: &Formula, wanted: bool) -> bool {
    let is_endless = formula.interval().is_some_and(|it| it.high.is_none());
    let waits = match formula {
        Formula::Eventually(..) | Formula::Until(..) => is_endless && wanted,
        Formula::Always(..) | Formula::WeakUntil(..) | Formula::Release(..) => {
            is_endless && !wanted
        }
        _ => false,
    };
    let part = |it: &Formula| waits_without_end(it, wanted);
    let contrary = |it: &Formula| waits_without_end(it, !wanted);
    waits
        || match formula {
            Formula::Not(f) => contrary(f),
            Formula::Implies(f, g) => contrary(f) || part(g),
            Formula::Iff(..) | Formula::Rise(_) | Formula::Fall(_) => {
                let mut operands = formula.operands().into_iter();
                operands.any(|it| part(it) || contrary(it))
            }
            _ => formula.operands().into_iter().any(part),
        }
}

impl EarlyJudge {
    /// Takes the samples of an instant, each without the unknown atom.
    pub(super) fn step(
        &mut self,
        time_secs: f64,
        samples: &[BothValues<'_>],
    ) -> Result<(), StepError> {
        if !self.is_at_work() {
            return Ok(());
        }
        if let [(truth, values)] = samples {
            // The longer sample is made where the last one was.
            self.longer.0.clear();
            self.longer.0.extend(truth.iter().copied().chain([None]));
            self.longer.1.clear();
            self.longer
                .1
                .extend(values.iter().copied().chain([f64::NAN]));
            let longer = [(&self.longer.0[..], &self.longer.1[..])];
            for part in self.parts.iter_mut().filter(|it| !it.sleeps) {
                part.step(time_secs, &longer)?;
            }
        } else {
            let longer: Vec<_> = samples.iter().map(with_unknown).collect();
            let longer: Vec<BothValues<'_>> =
                longer.iter().map(|it| (&it.0[..], &it.1[..])).collect();
            for part in self.parts.iter_mut().filter(|it| !it.sleeps) {
                part.step(time_secs, &longer)?;
            }
        }
        self.leave_what_is_over(time_secs);
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
        for part in self.parts.iter_mut().filter(|it| !it.sleeps) {
            part.judge.lose(span, next_secs, (&truth, &values))?;
        }
        Ok(())
    }

    /// As [`FormulaJudge::lasted_until`].
    pub(super) fn lasted_until(&mut self, end_secs: f64) {
        self.lasted_secs = self.lasted_secs.max(end_secs);
        self.leave_what_is_over(end_secs);
    }

    fn leave_what_is_over(&mut self, time_secs: f64) {
        let over = |part: &PartJudge| part.ends_pending && part.is_over(time_secs);
        for part in self.parts.iter().filter(|part| over(part)) {
            (self.left_out).push((part.horizon, part.began_secs.unwrap_or(time_secs)));
        }
        self.parts.retain(|part| !over(part));
    }

    /// Whether there are conjuncts that the trace is short of, other than those that wait for the trigger of the formula.
    pub(super) fn is_at_work(&self) -> bool {
        self.parts.iter().any(|part| !part.sleeps)
    }

    /// Whether there are such that wait for it.
    pub(super) fn sleeps(&self) -> bool {
        self.parts.iter().any(|part| part.sleeps)
    }

    /// The formula was triggered.
    pub(super) fn wake(&mut self) {
        self.parts.iter_mut().for_each(|part| part.sleeps = false);
    }

    /// Whether nothing came behind the last sample for so long that all windows ended, of the conjuncts that the trace is not short of.
    fn saw_all(&self, last_secs: f64) -> bool {
        let silent_secs = self.lasted_secs - last_secs;
        let mut horizons = self.left_out.iter();
        horizons.all(|(horizon, _)| horizon.samples == 0 && horizon.is_passed(silent_secs))
    }

    /// What is said of the trace in place of a verdict that only its end gave, if that is something else. `weak` is what is said
    /// with the benefit of the doubt (it may be open where samples are unknown), `best` the greatest robustness that a continuation
    /// can give, `last_secs` the time of the last sample.
    pub(super) fn said_instead(
        self,
        report: &FormulaReport,
        weak: Option<&FormulaReport>,
        best: Option<RobustnessBounds>,
        last_secs: f64,
    ) -> Option<FormulaReport> {
        let may_change = match report.verdict {
            Verdict::Satisfied | Verdict::Violated => report.decided_at_secs.is_none(),
            Verdict::NotCovered => self.looks_for_trigger,
            Verdict::Inconclusive => false,
        };
        if !may_change || self.lasted_secs == f64::INFINITY {
            return None;
        }
        let is_violated = report.verdict == Verdict::Violated;
        let saw_all = self.saw_all(last_secs);
        let end_secs = self.lasted_secs.max(last_secs);
        let mut open = None;
        // What was never triggered is not violated.
        for part in self.parts.into_iter().filter(|part| !part.sleeps) {
            let found = part.judge.finish(true);
            match found.verdict {
                Verdict::Violated => return None,
                Verdict::Inconclusive => open = open.or(Some((part.horizon, found.robustness))),
                // The end may have cut the trigger itself.
                Verdict::NotCovered if part.looks_for_trigger && !is_violated => {
                    open = open.or(Some((part.horizon, found.robustness)));
                }
                Verdict::Satisfied | Verdict::NotCovered => {}
            }
        }
        let as_open = |(horizon, robustness)| FormulaReport {
            verdict: Verdict::Inconclusive,
            robustness,
            ends_before: Some(horizon),
            explanation: None,
            ..report.clone()
        };
        if let Some(open) = open {
            return Some(as_open(open));
        }
        let weak = weak?;
        if !is_violated || weak.verdict == Verdict::Violated || saw_all {
            return None;
        }
        let mut left_out = self.left_out.iter();
        // The end leaves nothing open in these, but what was never known does.
        let best = report.robustness.and(best).map(|best| {
            let seen = weak.robustness.unwrap_or(best);
            let high = seen.high.min(best.high);
            RobustnessBounds {
                low: seen.low.min(high),
                high,
            }
        });
        if let Some((spared, _)) = left_out.find(|(it, began)| !it.is_passed(end_secs - began)) {
            return Some(as_open((*spared, best)));
        }
        let longest = self
            .left_out
            .iter()
            .map(|(it, _)| *it)
            .reduce(Horizon::and)?;
        Some(FormulaReport {
            verdict: match weak.verdict {
                Verdict::Inconclusive => Verdict::Inconclusive,
                _ => Verdict::Satisfied,
            },
            robustness: best,
            left_out: Some(longest),
            explanation: None,
            ..report.clone()
        })
    }
}

impl PartJudge {
    fn step(&mut self, time_secs: f64, samples: &[BothValues<'_>]) -> Result<(), StepError> {
        self.judge.step_instant(time_secs, samples)?;
        if self.began_secs.is_some() {
            self.samples += samples.len() as u64;
        } else if !self.has_trigger || self.looks_for_trigger || self.judge.has_triggered() {
            self.began_secs = Some(time_secs);
            self.samples = samples.len() as u64 - 1;
        }
        Ok(())
    }

    /// Whether a window was seen whole at this time.
    fn is_over(&self, time_secs: f64) -> bool {
        // Of what nothing changes behind, for ever, all samples that could be asked for are known.
        let began = self.began_secs.is_some_and(|began_secs| {
            self.horizon
                .is_reached(time_secs - began_secs, self.samples)
        });
        began || time_secs == f64::INFINITY
    }
}

/// A sample with the unknown atom behind the others.
fn with_unknown((truth, values): &BothValues<'_>) -> (Vec<Option<bool>>, Vec<f64>) {
    ([*truth, &[None]].concat(), [*values, &[f64::NAN]].concat())
}
