//! One monitor at work on the samples of the signals that it reads.
//!
//! # Definition
//! As in `temporal::formula::semantics::signals`: the samples are those of the signals that are read; those
//! of one instant are given together; a monitor that is open at the end and of which not all signals had a
//! value at its first sample is judged from the first sample on at which all have had one, if that comes
//! within the start-up limit. Both are followed at once, since what comes is seen once.

use super::losses::Losses;
use super::session::{CLOCK_STEP_SECS, News};
use super::{CompiledRule, SubjectJudge};
use diagnostic::Problem;
use temporal::formula::{
    BothValues, Formula, FormulaJudge, FormulaMonitor, Interval, Settings, TimeModel,
};
use temporal::monitor::{Judge, RobustnessJudge, Verdict};
use trace::{SignalIndex, SignalValues};

/// Truth and robustness of each proposition at a sample.
type Values = (Vec<Option<bool>>, Vec<f64>);

/// One monitor at work.
#[derive(Clone)]
pub(super) struct AtWork<'s> {
    /// The signals that it reads.
    pub reads: Vec<SignalIndex>,
    judge: Work<'s>,
    /// It, begun anew when all signals were there, and when.
    late: Option<(Work<'s>, f64)>,
    /// Ready to be begun; `None` once that is settled.
    waiting: Option<Waiting<'s>>,
    /// The samples of the instant that is not complete, its time, and which of them is the first for what
    /// was begun anew.
    open: Vec<Values>,
    open_secs: f64,
    late_from: usize,
    /// The last time on its own clock, and the time of its last sample.
    pub last_secs: f64,
    pub seen_secs: f64,
    /// Since when one of its signals has been without a value that is not too old.
    dropped_since: Option<f64>,
    /// What was known at the last sample.
    held: Values,
    has_own_clock: bool,
    is_dense: bool,
}

#[derive(Clone)]
struct Waiting<'s> {
    fresh: Work<'s>,
    limit_secs: f64,
    first_secs: Option<f64>,
    had: Vec<bool>,
}

#[derive(Clone)]
pub(super) enum Work<'s> {
    Staged(Judge<'s>, Option<Box<RobustnessJudge>>),
    Formula(Box<FormulaJudge>),
}

impl<'s> AtWork<'s> {
    pub fn new(
        judge: &'s SubjectJudge<'_>,
        reads: Vec<SignalIndex>,
        losses: &Losses,
    ) -> Result<Self, Problem> {
        let fresh = match &judge.rule {
            CompiledRule::Staged {
                monitor,
                robustness,
            } => Work::Staged(
                monitor.start(),
                robustness.as_ref().ok().map(|it| Box::new(it.start())),
            ),
            // On a clock of its own the times of a loss are not known.
            CompiledRule::Formula {
                formula, settings, ..
            } if losses.is_possible(&reads) && judge.clock.is_none() => {
                let settings = Settings {
                    losses: true,
                    ..settings.as_ref().clone()
                };
                let monitor = FormulaMonitor::compile(formula, &settings)
                    .map_err(|error| Problem::new("bad-formula", error.to_string()))?;
                Work::Formula(Box::new(monitor.start()))
            }
            CompiledRule::Formula { monitor, .. } => Work::Formula(Box::new(monitor.start())),
        };
        let count = judge.propositions.len();
        Ok(Self {
            waiting: Some(Waiting {
                fresh: fresh.clone(),
                limit_secs: judge.start_within_secs,
                first_secs: None,
                had: vec![false; reads.len()],
            }),
            reads,
            judge: fresh,
            late: None,
            open: Vec::new(),
            open_secs: f64::NEG_INFINITY,
            late_from: 0,
            last_secs: f64::NEG_INFINITY,
            seen_secs: f64::NEG_INFINITY,
            dropped_since: None,
            held: (vec![None; count], vec![f64::NAN; count]),
            has_own_clock: judge.clock.is_some(),
            is_dense: matches!(&judge.rule, CompiledRule::Formula { settings, .. }
                if settings.time == TimeModel::Dense),
        })
    }

    /// Takes a sample at a time of its own clock; it is judged with the others of its instant.
    pub fn hear<V: SignalValues>(&mut self, now_secs: f64, sample: Values, values: &V) {
        self.held.clone_from(&sample);
        self.open_secs = now_secs;
        self.open.push(sample);
        self.look_for_start(now_secs, values);
    }

    /// Begins anew once all signals have had a value, if they had none at first.
    fn look_for_start<V: SignalValues>(&mut self, now_secs: f64, values: &V) {
        let Some(waiting) = &mut self.waiting else {
            return;
        };
        for (had, signal) in waiting.had.iter_mut().zip(&self.reads) {
            *had |= !values.raw(*signal).is_nan();
        }
        let is_first = waiting.first_secs.is_none();
        let first_secs = *waiting.first_secs.get_or_insert(now_secs);
        let is_late = now_secs - first_secs > waiting.limit_secs;
        let is_there = waiting.had.iter().all(|it| *it);
        if !(is_there || is_late) {
            return;
        }
        let waiting = self.waiting.take();
        if let Some(waiting) = waiting.filter(|_| is_there && !is_late && !is_first) {
            self.late = Some((waiting.fresh, now_secs));
            self.late_from = self.open.len() - 1;
        }
    }

    /// Notes that a sample was seen at a time of the trace, and whether a signal is without a value since.
    pub fn seen(&mut self, time_secs: f64, news: &News<'_>) {
        self.seen_secs = time_secs;
        let is_dropped = |signal: &SignalIndex| {
            let fields = news.dropped.and_then(|dropped| dropped.get(signal.channel));
            fields.is_some_and(|fields| fields.get(signal.field).is_some_and(|it| *it))
        };
        self.dropped_since = self.reads.iter().any(is_dropped).then_some(time_secs);
    }

    /// Gives the samples of the instant to the monitor.
    pub fn flush(&mut self) -> Result<(), String> {
        if self.open.is_empty() {
            return Ok(());
        }
        let next_secs = (self.last_secs + CLOCK_STEP_SECS).max(self.last_secs.next_up());
        // On line, a sample may come for an instant that was given already.
        let now_secs = if self.open_secs > self.last_secs {
            self.open_secs
        } else {
            next_secs
        };
        let open = std::mem::take(&mut self.open);
        self.last_secs = self.judge.take(now_secs, &open)?;
        if let Some((late, _)) = &mut self.late {
            late.take(now_secs, &open[self.late_from..])?;
        }
        self.late_from = 0;
        self.open = open;
        self.open.clear();
        Ok(())
    }

    /// Brings the monitor across what was lost since its last sample, before one at `time_secs`.
    pub fn bring_across(&mut self, spans: &[(f64, f64)], time_secs: f64) -> Result<(), String> {
        if !self.open.is_empty() {
            return Ok(());
        }
        let count = self.held.0.len();
        let unknown = (vec![None; count], vec![f64::NAN; count]);
        let is_between = |span: &&(f64, f64)| span.0 <= time_secs && span.1 >= self.seen_secs;
        for span in spans.iter().filter(is_between) {
            self.judge.lose(*span, time_secs, &unknown)?;
            if let Some((late, _)) = &mut self.late {
                late.lose(*span, time_secs, &unknown)?;
            }
        }
        // In dense time that the value is missing says all.
        if let Some(since_secs) = self.dropped_since.filter(|_| !self.is_dense) {
            let held = self.held.clone();
            self.judge.lose((since_secs, time_secs), time_secs, &held)?;
            if let Some((late, _)) = &mut self.late {
                late.lose((since_secs, time_secs), time_secs, &held)?;
            }
        }
        Ok(())
    }

    /// Samples may be missing behind the last one.
    pub fn lose_the_rest(&mut self, spans: &[(f64, f64)]) {
        self.dropped_since = None;
        // Nothing comes behind, so that no time can be wrong.
        let _ = self.bring_across(spans, f64::INFINITY);
    }

    /// The verdict, if it is determined already.
    pub fn determined(&self) -> Option<Verdict> {
        let late = self.late.as_ref().and_then(|(late, _)| late.determined());
        self.judge.determined().or(late)
    }

    /// What tells the robustness so far.
    pub fn telling(&self) -> &Work<'s> {
        match &self.late {
            Some((late, _)) if self.judge.determined().is_none() => late,
            _ => &self.judge,
        }
    }

    /// The monitor from its first sample on; and from where all signals were there, with when that was.
    pub fn parts(self) -> (Work<'s>, Option<(Work<'s>, f64)>) {
        (self.judge, self.late)
    }

    /// Time passes, and nothing is known of the values at `time_secs`.
    pub fn silence(&mut self, time_secs: f64) -> Result<(), String> {
        let count = self.held.0.len();
        let unknown = [(vec![None; count], vec![f64::NAN; count])];
        self.last_secs = self.judge.take(time_secs, &unknown)?;
        match &mut self.late {
            Some((late, _)) => late.take(time_secs, &unknown).map(drop),
            None => Ok(()),
        }
    }

    /// Nothing came from the last sample until `end_secs`: stages whose deadline has passed by then fail, and a formula is not
    /// short of what was seen until then.
    pub fn lasted_until(&mut self, end_secs: f64) {
        if self.has_own_clock || end_secs <= self.last_secs {
            return;
        }
        if matches!(self.judge, Work::Formula(_)) {
            return self.formulas_lasted_until(end_secs);
        }
        let mut quiet = self.clone();
        let failed = |it: &Self| match &it.judge {
            Work::Staged(judge, _) => judge.failed(),
            Work::Formula(_) => 0,
        };
        if quiet.silence(end_secs).is_ok() && failed(&quiet) > failed(self) {
            *self = quiet;
        }
    }

    /// Nothing changes behind the last sample, for ever.
    pub fn rests(&mut self) {
        self.formulas_lasted_until(f64::INFINITY);
    }

    fn formulas_lasted_until(&mut self, end_secs: f64) {
        let late = self.late.as_mut().map(|(late, _)| late);
        for work in [Some(&mut self.judge), late].into_iter().flatten() {
            if let Work::Formula(formula) = work {
                formula.lasted_until(end_secs);
            }
        }
    }

    /// Of a trace from which samples are missing nobody knows where, only what a single sample shows by
    /// itself is kept: that something that should always hold did not, or that something did occur.
    pub fn forget_what_may_differ(&mut self, judge: &SubjectJudge<'_>) {
        let channel = self.reads.first().map(|signal| signal.channel);
        let is_one_topic = self.reads.iter().all(|it| Some(it.channel) == channel);
        let shown = match &judge.rule {
            CompiledRule::Formula { formula, .. } => shown_by_one_sample(formula),
            CompiledRule::Staged { .. } => None,
        };
        let stands = is_one_topic && shown.is_some() && self.judge.determined() == shown;
        if !stands {
            self.judge.void();
            self.late = None;
        }
    }
}

/// The verdict on a formula that one sample can show by itself.
fn shown_by_one_sample(formula: &Formula) -> Option<Verdict> {
    match formula {
        Formula::Always(interval, inner)
            if *interval == Interval::UNBOUNDED && inner.is_propositional() =>
        {
            Some(Verdict::Violated)
        }
        Formula::Eventually(interval, inner)
            if *interval == Interval::UNBOUNDED && inner.is_propositional() =>
        {
            Some(Verdict::Satisfied)
        }
        _ => None,
    }
}

impl Work<'_> {
    /// Takes the samples of one instant; gives the time at which the last one was put.
    fn take(&mut self, now_secs: f64, samples: &[Values]) -> Result<f64, String> {
        match self {
            Work::Staged(staged, robustness) => {
                let mut at_secs = now_secs;
                for (place, (truth, values)) in samples.iter().enumerate() {
                    if place > 0 {
                        at_secs = (at_secs + CLOCK_STEP_SECS).max(at_secs.next_up());
                    }
                    if let Some(robustness) = robustness {
                        let value = |proposition: usize| values[proposition];
                        let taken = robustness.step(at_secs, &value);
                        taken.map_err(|error| error.to_string())?;
                    }
                    let taken = staged.step(at_secs, &|proposition| truth[proposition]);
                    taken.map_err(|error| error.to_string())?;
                }
                Ok(at_secs)
            }
            Work::Formula(formula) => {
                let samples: Vec<BothValues<'_>> = (samples.iter())
                    .map(|(truth, values)| (&truth[..], &values[..]))
                    .collect();
                let taken = formula.step_instant(now_secs, &samples);
                taken.map(|_| now_secs).map_err(|error| error.to_string())
            }
        }
    }

    fn lose(&mut self, span: (f64, f64), next_secs: f64, held: &Values) -> Result<(), String> {
        match self {
            Work::Staged(staged, robustness) => {
                staged.lose();
                *robustness = None;
                Ok(())
            }
            Work::Formula(formula) => {
                let taken = formula.lose(span, next_secs, (&held.0, &held.1));
                taken.map_err(|error| error.to_string())
            }
        }
    }

    fn determined(&self) -> Option<Verdict> {
        match self {
            Work::Staged(staged, _) => (staged.failed() > 0).then_some(Verdict::Violated),
            Work::Formula(formula) => formula.verdict(),
        }
    }

    /// Nothing can be said of the trace.
    fn void(&mut self) {
        match self {
            Work::Staged(staged, robustness) => {
                staged.void();
                *robustness = None;
            }
            Work::Formula(formula) => formula.void(),
        }
    }
}
