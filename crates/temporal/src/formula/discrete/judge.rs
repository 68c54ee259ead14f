//! A formula that is ready to judge traces, and one at work on a trace.

use super::Truth;
use super::program::{NodeId, Program};
use super::robustness::Lane;
use super::runs::RunMap;
use super::timeline::Timeline;
use super::truth::{After, Said, TruthEngine};
use crate::formula::ast::Formula;
use crate::formula::report::{FormulaReport, Progress, RobustnessBounds, StepError};
use crate::formula::settings::{CompileError, Ending, Settings};
use crate::monitor::Verdict;

/// How many samples [`DiscreteJudge::step_many`] takes at once.
const BATCH: usize = 1_024;

/// A formula in discrete time that is ready to judge traces; it can be shared by threads.
///
/// [`FormulaMonitor`](crate::formula::FormulaMonitor) is the same for both models of time, and
/// explains violations.
///
/// ```
/// use temporal::formula::discrete::DiscreteMonitor;
/// use temporal::formula::{Ending, Settings, Verdict, parse};
/// let parsed = parse("always (grasped => eventually[0, 2 samples] /hand.width > 8 cm)", &|_| None)?;
/// let settings = Settings::discrete(Ending::Finite).with_robustness();
/// let monitor = DiscreteMonitor::compile(&parsed.formula, &settings)?;
///
/// // The robustness of both atoms: the first is only true or false.
/// let times_secs = [0.0, 0.1, 0.2, 0.3];
/// let grasped = [-f64::INFINITY, f64::INFINITY, -f64::INFINITY, -f64::INFINITY];
/// let width = [-0.02, -0.01, 0.005, -0.01];
/// let mut judge = monitor.start();
/// let progress = judge.step_many(&times_secs, &[&grasped, &width])?;
/// assert_eq!(progress.verdict, None); // it may be grasped again
/// let report = judge.finish(true);
/// assert_eq!(report.verdict, Verdict::Satisfied);
/// assert_eq!(report.robustness.and_then(|bounds| bounds.value()), Some(0.005));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct DiscreteMonitor {
    start: DiscreteJudge,
}

/// A formula in discrete time at work on one trace.
#[derive(Debug, Clone)]
pub struct DiscreteJudge {
    atom_count: usize,
    ending: Ending,
    timeline: Timeline,
    last_secs: f64,
    truth: TruthEngine,
    root: NodeId,
    trigger: Option<Trigger>,
    robustness: Option<Robustness>,
    verdict: Option<Verdict>,
    decided_at_secs: Option<f64>,
    /// When times have last been forgotten, this many were left.
    times_left: usize,
}

/// Counts how often a formula becomes true: where it is true and was false at the sample before, if
/// there is one.
#[derive(Debug, Clone)]
struct Trigger {
    node: NodeId,
    waiting: RunMap,
    /// The next sample, and the value at the one before.
    next: u64,
    before: Truth,
    risen: u64,
    /// Whether its truth was unknown anywhere, so that it may have risen unseen.
    doubtful: bool,
}

/// The lanes for both ends of the robustness.
#[derive(Debug, Clone)]
struct Robustness {
    low: Lane,
    /// None as long as it would be the same as `low`.
    high: Option<Lane>,
}

impl DiscreteMonitor {
    /// Translates `formula`.
    ///
    /// # Errors
    /// [`CompileError`] if an interval makes no sense or the formula is nested too deeply.
    pub fn compile(formula: &Formula, settings: &Settings) -> Result<Self, CompileError> {
        let mut program = Program::new();
        let root = program.add(formula)?;
        let robustness = settings.robustness.then(|| Robustness {
            low: Lane::new(&program, root),
            high: None,
        });
        let trigger = settings.trigger.as_ref().or_else(|| formula.trigger());
        let mut atom_count = formula.atom_count();
        let trigger = match trigger {
            None => None,
            Some(trigger) => {
                atom_count = atom_count.max(trigger.atom_count());
                Some(Trigger::new(program.add(trigger)?))
            }
        };
        let start = DiscreteJudge {
            atom_count,
            ending: settings.ending,
            timeline: Timeline::new(program.measures_time()),
            last_secs: f64::NEG_INFINITY,
            truth: TruthEngine::new(&program),
            root,
            trigger,
            robustness,
            verdict: None,
            decided_at_secs: None,
            times_left: 0,
        };
        Ok(DiscreteMonitor { start })
    }

    /// Begins to judge a trace.
    #[must_use]
    pub fn start(&self) -> DiscreteJudge {
        self.start.clone()
    }
}

impl DiscreteJudge {
    /// Takes the next sample: its time, and the robustness of each atom: not a number where it is
    /// unknown, infinite where an atom is only true or false. The truth of an atom is the sign of
    /// its robustness, and unknown where that is 0; see [`DiscreteJudge::step_both`].
    ///
    /// # Errors
    /// [`StepError`] if the time is not finite or not after the last one, or values are missing or too
    /// many; the sample is not taken then.
    pub fn step(&mut self, time_secs: f64, atoms: &[f64]) -> Result<Progress, StepError> {
        self.check(self.last_secs, time_secs, atoms.len())?;
        self.take(
            &[time_secs],
            |atom, _| Truth::of_robustness(atoms[atom]),
            |atom| std::iter::once(atoms[atom]),
        );
        Ok(self.progress())
    }

    /// Takes the next samples: their times, and for each atom its robustness at each of them. The
    /// result is that of [`DiscreteJudge::step`] for each sample, and comes sooner.
    ///
    /// # Errors
    /// As [`DiscreteJudge::step`]; none of the samples is taken then.
    pub fn step_many(
        &mut self,
        times_secs: &[f64],
        atoms: &[&[f64]],
    ) -> Result<Progress, StepError> {
        let mut last_secs = self.last_secs;
        for &time_secs in times_secs {
            self.check(last_secs, time_secs, atoms.len())?;
            last_secs = time_secs;
        }
        if let Some(column) = atoms.iter().find(|it| it.len() != times_secs.len()) {
            return Err(StepError::AtomCount {
                expected: times_secs.len(),
                found: column.len(),
            });
        }
        for (index, times_secs) in times_secs.chunks(BATCH).enumerate() {
            let begin = index * BATCH;
            self.take(
                times_secs,
                |atom, at| Truth::of_robustness(atoms[atom][begin + at]),
                |atom| atoms[atom][begin..begin + times_secs.len()].iter().copied(),
            );
        }
        Ok(self.progress())
    }

    /// Takes the next sample: its time, and the truth of each atom, `None` where it is unknown.
    ///
    /// # Errors
    /// As [`DiscreteJudge::step`].
    pub fn step_truth(
        &mut self,
        time_secs: f64,
        atoms: &[Option<bool>],
    ) -> Result<Progress, StepError> {
        self.check(self.last_secs, time_secs, atoms.len())?;
        let robustness = |atom: usize| match atoms[atom] {
            Some(true) => f64::INFINITY,
            Some(false) => f64::NEG_INFINITY,
            None => f64::NAN,
        };
        self.take(
            &[time_secs],
            |atom, _| Truth::of(atoms[atom]),
            |atom| std::iter::once(robustness(atom)),
        );
        Ok(self.progress())
    }

    /// Takes the next sample with both the truth and the robustness of each atom, which decides
    /// atoms whose robustness is 0.
    ///
    /// # Errors
    /// As [`DiscreteJudge::step`].
    pub fn step_both(
        &mut self,
        time_secs: f64,
        truth: &[Option<bool>],
        robustness: &[f64],
    ) -> Result<Progress, StepError> {
        self.check(self.last_secs, time_secs, truth.len())?;
        self.check(self.last_secs, time_secs, robustness.len())?;
        self.take(
            &[time_secs],
            |atom, _| Truth::of(truth[atom]),
            |atom| std::iter::once(robustness[atom]),
        );
        Ok(self.progress())
    }

    /// Takes all samples of one instant, in their order, each with the truth and the robustness of
    /// each atom.
    ///
    /// # Errors
    /// As [`DiscreteJudge::step`]; none of the samples is taken then.
    pub fn step_instant(
        &mut self,
        time_secs: f64,
        samples: &[(&[Option<bool>], &[f64])],
    ) -> Result<Progress, StepError> {
        for (truth, robustness) in samples {
            self.check(self.last_secs, time_secs, truth.len())?;
            self.check(self.last_secs, time_secs, robustness.len())?;
        }
        if samples.is_empty() {
            return Ok(self.progress());
        }
        self.last_secs = time_secs;
        // At once: a window that ends here holds all of them.
        let times_secs = vec![time_secs; samples.len()];
        self.take_truth(&times_secs, |atom, at| Truth::of(samples[at].0[atom]));
        if let Some(lanes) = &mut self.robustness {
            lanes.step(&self.timeline, self.atom_count, |atom| {
                samples.iter().map(move |(_, robustness)| robustness[atom])
            });
        }
        if self.timeline.stored() > 2 * self.times_left + 64 {
            self.forget_times();
        }
        Ok(self.progress())
    }

    /// The verdict, once no continuation can change it.
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        self.verdict
    }

    /// The time of the sample that determined the verdict.
    pub(crate) fn decided_at_secs(&self) -> Option<f64> {
        self.decided_at_secs
    }

    /// The least and the greatest robustness that this trace can still have, whatever comes; `None`
    /// if robustness is not computed or there was no sample. Mostly in constant time: see the file
    /// `robustness/so_far.rs`.
    #[must_use]
    pub fn robustness_bounds(&self) -> Option<RobustnessBounds> {
        let Robustness { low, high } = self.robustness.as_ref()?;
        if self.timeline.count() == 0 {
            return None;
        }
        let high = high.as_ref().unwrap_or(low);
        // Adding 0 makes a negative zero positive.
        Some(RobustnessBounds {
            low: low.so_far(&self.timeline, f64::NEG_INFINITY)? + 0.0,
            high: high.so_far(&self.timeline, f64::INFINITY)? + 0.0,
        })
    }

    /// How many values, runs of truth values and times are stored.
    #[must_use]
    pub fn stored(&self) -> usize {
        let lanes = self.robustness.as_ref().map_or(0, |lanes| {
            lanes.low.stored() + lanes.high.as_ref().map_or(0, Lane::stored)
        });
        self.timeline.stored() + self.truth.stored() + lanes
    }

    /// Whether the trigger may have become true.
    pub(in crate::formula) fn may_have_triggered(&self) -> bool {
        let may = |it: &Trigger| it.risen > 0 || it.doubtful;
        self.trigger.as_ref().is_some_and(may)
    }

    /// Whether the trigger was seen to become true, as far as that is known.
    pub(in crate::formula) fn has_triggered(&self) -> bool {
        self.trigger.as_ref().is_some_and(|it| it.risen > 0)
    }

    /// The same with another ending.
    pub(in crate::formula) fn with_ending(mut self, ending: Ending) -> Self {
        self.ending = ending;
        self
    }

    /// Ends the trace. `complete` is false if it was cut short: then [`Ending::Finite`] is treated as
    /// [`Ending::Inconclusive`].
    #[must_use]
    pub fn finish(mut self, complete: bool) -> FormulaReport {
        let ending = match self.ending {
            Ending::Finite | Ending::LongEnough if !complete => Ending::Inconclusive,
            ending => ending,
        };
        let robustness = self.robustness_at_end(ending);
        let verdict = self.verdict_at_end(ending);
        let triggered = self.trigger.as_ref().map_or(0, |trigger| trigger.risen);
        let doubtful = self
            .trigger
            .as_ref()
            .is_some_and(|trigger| trigger.doubtful);
        FormulaReport {
            verdict: match verdict {
                Verdict::Violated => verdict,
                // An unseen trigger may have been followed by anything.
                Verdict::Inconclusive if doubtful => verdict,
                _ if self.trigger.is_none() || triggered > 0 => verdict,
                _ => Verdict::NotCovered,
            },
            robustness,
            triggered,
            has_trigger: self.trigger.is_some(),
            samples: self.timeline.count(),
            decided_at_secs: self.decided_at_secs,
            ends_before: None,
            left_out: None,
            explanation: None,
        }
    }

    #[inline]
    fn check(&self, last_secs: f64, time_secs: f64, found: usize) -> Result<(), StepError> {
        if !time_secs.is_finite() || time_secs <= last_secs {
            return Err(StepError::Time {
                last_secs,
                time_secs,
            });
        }
        if found != self.atom_count {
            return Err(StepError::AtomCount {
                expected: self.atom_count,
                found,
            });
        }
        Ok(())
    }

    fn progress(&self) -> Progress {
        Progress {
            verdict: self.verdict,
        }
    }

    /// Takes samples that have been checked, at least one.
    #[inline]
    fn take<I: Iterator<Item = f64>>(
        &mut self,
        times_secs: &[f64],
        truth: impl Fn(usize, usize) -> Truth,
        robustness: impl Fn(usize) -> I,
    ) {
        let Some(&last_secs) = times_secs.last() else {
            return;
        };
        self.last_secs = last_secs;
        if self.verdict.is_some() || times_secs.len() == 1 {
            self.take_truth(times_secs, &truth);
        } else {
            self.take_truth_of_many(times_secs, truth);
        }
        if let Some(lanes) = &mut self.robustness {
            lanes.step(&self.timeline, self.atom_count, robustness);
        }
        if self.timeline.stored() > 2 * self.times_left + 64 {
            self.forget_times();
        }
    }

    #[inline]
    fn take_truth(&mut self, times_secs: &[f64], truth: impl Fn(usize, usize) -> Truth) {
        self.timeline.add(times_secs);
        if self.verdict.is_none() || self.trigger.is_some() {
            self.truth.step(&self.timeline, truth);
            self.hear_truth();
            if self.verdict.is_some() && self.decided_at_secs.is_none() {
                self.decided_at_secs = times_secs.last().copied();
            }
        }
    }

    /// Takes samples at once; if they decide, again one by one, to find the one that does.
    fn take_truth_of_many(&mut self, times_secs: &[f64], truth: impl Fn(usize, usize) -> Truth) {
        let (engine, trigger) = (self.truth.clone(), self.trigger.clone());
        self.take_truth(times_secs, &truth);
        if self.verdict.is_none() {
            return;
        }
        (self.truth, self.trigger) = (engine, trigger);
        (self.verdict, self.decided_at_secs) = (None, None);
        self.timeline.take_back();
        for at in 0..times_secs.len() {
            self.take_truth(&times_secs[at..=at], |atom, _| truth(atom, at));
        }
        // Robustness takes them at once.
        self.timeline.freshen(times_secs.len() as u64);
    }

    /// Notes what the formula and its trigger said.
    #[inline]
    fn hear_truth(&mut self) {
        if self.verdict.is_none() {
            let at_first = self
                .truth
                .said(self.root)
                .iter()
                .find(|said| said.from == 0);
            self.verdict = at_first.and_then(|said| match said.value {
                Truth::True => Some(Verdict::Satisfied),
                Truth::False => Some(Verdict::Violated),
                Truth::Unknown => None,
            });
        }
        if let Some(trigger) = &mut self.trigger {
            trigger.hear(self.truth.said(trigger.node));
        }
    }

    fn forget_times(&mut self) {
        let mut needed = self.truth.needed_from();
        if let Some(lanes) = &self.robustness {
            needed = needed.min(lanes.low.needed_from());
            needed = needed.min(lanes.high.as_ref().map_or(u64::MAX, Lane::needed_from));
        }
        self.timeline.forget_before(needed);
        self.times_left = self.timeline.stored();
    }

    fn verdict_at_end(&mut self, ending: Ending) -> Verdict {
        let after = match ending {
            Ending::Inconclusive => None,
            Ending::Weak => Some(After::All(true)),
            Ending::Strong => Some(After::All(false)),
            Ending::Finite | Ending::LongEnough => Some(After::Nothing),
        };
        if let Some(after) = after
            && (self.verdict.is_none() || self.trigger.is_some())
        {
            self.truth.close(&self.timeline, after);
            self.hear_truth();
        }
        self.verdict.unwrap_or(Verdict::Inconclusive)
    }

    fn robustness_at_end(&mut self, ending: Ending) -> Option<RobustnessBounds> {
        let Robustness { low, high } = self.robustness.take()?;
        let high = high.unwrap_or_else(|| low.optimist());
        let (below, above) = match ending {
            Ending::Inconclusive => (Some(f64::NEG_INFINITY), Some(f64::INFINITY)),
            Ending::Weak => (Some(f64::INFINITY), Some(f64::INFINITY)),
            Ending::Strong => (Some(f64::NEG_INFINITY), Some(f64::NEG_INFINITY)),
            Ending::Finite | Ending::LongEnough => (None, None),
        };
        // Adding 0 makes a negative zero positive.
        Some(RobustnessBounds {
            low: low.close(&self.timeline, below)? + 0.0,
            high: high.close(&self.timeline, above)? + 0.0,
        })
    }
}

impl Trigger {
    fn new(node: NodeId) -> Self {
        Trigger {
            node,
            waiting: RunMap::default(),
            next: 0,
            before: Truth::False,
            risen: 0,
            doubtful: false,
        }
    }

    #[inline]
    fn hear(&mut self, said: &[Said]) {
        for said in said {
            if said.from == self.next {
                self.count(said.to, said.value);
            } else {
                self.waiting.insert(said.from, said.to, said.value);
            }
        }
        while let Some((to, value)) = self.waiting.take_first_at(self.next) {
            self.count(to, value);
        }
    }

    #[inline]
    fn count(&mut self, to: u64, value: Truth) {
        let rises = value == Truth::True && self.before == Truth::False;
        self.risen += u64::from(rises);
        self.doubtful |= value == Truth::Unknown;
        (self.next, self.before) = (to, value);
    }
}

impl Robustness {
    #[inline]
    fn step<I: Iterator<Item = f64>>(
        &mut self,
        timeline: &Timeline,
        atom_count: usize,
        values: impl Fn(usize) -> I,
    ) {
        if self.high.is_none()
            && (0..atom_count).any(|atom| values(atom).any(|value| value.is_nan()))
        {
            self.high = Some(self.low.optimist());
        }
        if let Some(high) = &mut self.high {
            high.step(timeline, &values);
        }
        self.low.step(timeline, values);
    }
}
