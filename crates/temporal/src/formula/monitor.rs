//! A formula that is ready to judge traces in either model of time, and one at work on a trace.

use std::sync::Arc;

use super::ast::Formula;
use super::dense::{DenseJudge, DenseMonitor};
use super::discrete::{DiscreteJudge, DiscreteMonitor};
use super::early_end::{EarlyJudge, EarlyMonitor};
use super::explain::{Record, explain};
use super::losses::{Across, Marked, across, stand_ins};
use super::report::{FormulaReport, Progress, RobustnessBounds, StepError};
use super::settings::{CompileError, Ending, Settings, TimeModel};
use crate::monitor::Verdict;

/// A formula that is ready to judge traces; it can be shared by threads.
///
/// ```
/// use temporal::formula::{Ending, FormulaMonitor, Settings, Verdict, parse};
/// let parsed = parse("always (grasped => eventually[0, 2 s] released)", &|_| None)?;
/// let monitor = FormulaMonitor::compile(&parsed.formula, &Settings::discrete(Ending::Finite))?;
///
/// let mut judge = monitor.start();
/// //                    grasped, released
/// for (time_secs, atoms) in [(0.0, [false, false]), (1.0, [true, false]), (2.5, [false, true])] {
///     let progress = judge.step_truth(time_secs, &atoms.map(Some))?;
///     assert_eq!(progress.verdict, None); // more could come
/// }
/// let report = judge.finish(true);
/// assert_eq!((report.verdict, report.triggered), (Verdict::Satisfied, 1));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct FormulaMonitor {
    engine: Engine,
    formula: Arc<Formula>,
    time: TimeModel,
    ending: Ending,
    record: Record,
    losses: Option<Losses>,
    early: Option<Box<EarlyMonitor>>,
}

/// How losses are dealt with, and how many atoms the formula has without its marks.
#[derive(Debug, Clone, Copy)]
struct Losses {
    across: Across,
    atom_count: usize,
}

impl Losses {
    /// Whether samples are marked.
    fn is_marked(self) -> bool {
        matches!(self.across, Across::StandIns { .. })
    }
}

#[derive(Debug, Clone)]
enum Engine {
    Discrete(Box<DiscreteMonitor>),
    Dense(Box<DenseMonitor>),
}

/// A formula at work on one trace.
#[derive(Debug, Clone)]
pub struct FormulaJudge {
    work: Work,
    formula: Arc<Formula>,
    time: TimeModel,
    ending: Ending,
    record: Record,
    losses: Option<Losses>,
    /// What is judged beside it for what the end of the trace leaves pending.
    early: Option<Box<EarlyJudge>>,
    /// The time of the last sample.
    last_secs: f64,
    /// Whether there was a loss, whether one ended the trace, and whether nothing can be said for one.
    has_lost: bool,
    is_cut: bool,
    is_void: bool,
}

/// One sample: the truth of each atom, and its robustness.
pub type BothValues<'v> = (&'v [Option<bool>], &'v [f64]);

#[derive(Debug, Clone)]
enum Work {
    Discrete(Box<DiscreteJudge>),
    Dense(Box<DenseJudge>),
}

/// Calls the same method of the judge for either model of time.
macro_rules! either {
    ($work:expr, $judge:ident => $call:expr) => {
        match $work {
            Work::Discrete($judge) => $call,
            Work::Dense($judge) => $call,
        }
    };
}

impl FormulaMonitor {
    /// Translates `formula`.
    ///
    /// # Errors
    /// [`CompileError`] if an interval makes no sense, samples are spoken of in dense time, or the
    /// formula is too large.
    pub fn compile(formula: &Formula, settings: &Settings) -> Result<Self, CompileError> {
        let early = EarlyMonitor::compile(formula, settings)?.map(Box::new);
        let ending = match settings.ending {
            Ending::LongEnough => Ending::Finite,
            ending => ending,
        };
        let settings = Settings {
            ending,
            ..settings.clone()
        };
        Ok(FormulaMonitor {
            early,
            ..Self::compile_whole(formula, &settings)?
        })
    }

    /// Without what is judged of short traces.
    fn compile_whole(formula: &Formula, settings: &Settings) -> Result<Self, CompileError> {
        if !settings.losses {
            return Self::compile_as_is(formula, settings, None);
        }
        let trigger = settings.trigger.as_ref().or_else(|| formula.trigger());
        let atom_count = trigger.map_or(0, Formula::atom_count);
        let losses = Losses {
            across: across(formula, settings.time)?,
            atom_count: formula.atom_count().max(atom_count),
        };
        if !losses.is_marked() {
            return Self::compile_as_is(formula, settings, Some(losses));
        }
        let marked = Marked::new(losses.atom_count);
        let settings = Settings {
            trigger: trigger.map(|trigger| marked.trigger(trigger)),
            ..settings.clone()
        };
        // The mark and the unknown atom are always among the atoms.
        let all_atoms = marked.trigger(&Formula::atom(losses.atom_count));
        let root = Formula::and(marked.root(formula), Formula::or(Formula::True, all_atoms));
        Self::compile_as_is(&root, &settings, Some(losses))
    }

    fn compile_as_is(
        formula: &Formula,
        settings: &Settings,
        losses: Option<Losses>,
    ) -> Result<Self, CompileError> {
        let engine = match settings.time {
            TimeModel::Discrete => {
                Engine::Discrete(Box::new(DiscreteMonitor::compile(formula, settings)?))
            }
            TimeModel::Dense => Engine::Dense(Box::new(DenseMonitor::compile(formula, settings)?)),
        };
        Ok(FormulaMonitor {
            engine,
            formula: Arc::new(formula.clone()),
            time: settings.time,
            ending: settings.ending,
            record: Record::new(settings.explain_samples, formula.atom_count()),
            losses,
            early: None,
        })
    }

    /// Begins to judge a trace.
    #[must_use]
    pub fn start(&self) -> FormulaJudge {
        let work = match &self.engine {
            Engine::Discrete(monitor) => Work::Discrete(Box::new(monitor.start())),
            Engine::Dense(monitor) => Work::Dense(Box::new(monitor.start())),
        };
        FormulaJudge {
            work,
            formula: Arc::clone(&self.formula),
            time: self.time,
            ending: self.ending,
            record: self.record.clone(),
            losses: self.losses,
            early: self.early.as_ref().map(|it| Box::new(it.start())),
            last_secs: f64::NEG_INFINITY,
            has_lost: false,
            is_cut: false,
            is_void: false,
        }
    }
}

impl FormulaJudge {
    /// Takes the next sample: its time in seconds, and the robustness of each atom, which is not a
    /// number where it is unknown, and infinite where an atom is only true or false. The truth of an
    /// atom is the sign of its robustness, and unknown where that is 0; see
    /// [`FormulaJudge::step_both`].
    ///
    /// # Errors
    /// [`StepError`] if the time is not finite or not after the last one, or there is not one value
    /// for each atom; the sample is not taken then.
    pub fn step(&mut self, time_secs: f64, atoms: &[f64]) -> Result<Progress, StepError> {
        if self.losses.is_some() || self.is_watched() {
            let truth = |value: &f64| RobustnessBounds::of_value(*value).truth();
            let truths: Vec<Option<bool>> = atoms.iter().map(truth).collect();
            return self.step_both(time_secs, &truths, atoms);
        }
        let before = self.before();
        let progress = either!(&mut self.work, judge => judge.step(time_secs, atoms))?;
        self.last_secs = time_secs;
        self.keep(
            before,
            time_secs,
            atoms
                .iter()
                .map(|&value| RobustnessBounds::of_value(value).truth()),
        );
        if self.wakes() {
            self.step_awake(time_secs, atoms)?;
        }
        Ok(progress)
    }

    /// Takes the next sample: its time, and the truth of each atom, `None` where it is unknown.
    ///
    /// # Errors
    /// As [`FormulaJudge::step`].
    pub fn step_truth(
        &mut self,
        time_secs: f64,
        atoms: &[Option<bool>],
    ) -> Result<Progress, StepError> {
        if self.losses.is_some() || self.is_watched() {
            let values: Vec<f64> = atoms.iter().map(|truth| value_of(*truth)).collect();
            return self.step_both(time_secs, atoms, &values);
        }
        let before = self.before();
        let progress = either!(&mut self.work, judge => judge.step_truth(time_secs, atoms))?;
        self.last_secs = time_secs;
        self.keep(before, time_secs, atoms.iter().copied());
        if self.wakes() {
            let values: Vec<f64> = atoms.iter().map(|truth| value_of(*truth)).collect();
            self.step_early(time_secs, &[(atoms, &values)])?;
        }
        Ok(progress)
    }

    /// Takes the next sample with both the truth and the robustness of each atom, which decides
    /// atoms whose robustness is 0.
    ///
    /// # Errors
    /// As [`FormulaJudge::step`].
    pub fn step_both(
        &mut self,
        time_secs: f64,
        truth: &[Option<bool>],
        robustness: &[f64],
    ) -> Result<Progress, StepError> {
        self.step_instant(time_secs, &[(truth, robustness)])
    }

    /// Takes all samples of one instant, in their order, each with the truth and the robustness of
    /// each atom. In discrete time they are samples of one time; in dense time each of them but the
    /// last lasts for a nanosecond, and what comes within that is put behind it.
    ///
    /// # Errors
    /// As [`FormulaJudge::step`].
    pub fn step_instant(
        &mut self,
        time_secs: f64,
        samples: &[BothValues<'_>],
    ) -> Result<Progress, StepError> {
        if self.is_cut {
            return Ok(Progress {
                verdict: self.verdict(),
            });
        }
        let progress = match self.losses.filter(|losses| losses.is_marked()) {
            None => self.take_instant(time_secs, samples),
            Some(losses) => self.step_marked(time_secs, samples, losses, false),
        }?;
        self.wakes();
        self.step_early(time_secs, samples)?;
        Ok(progress)
    }

    /// Whether what is judged beside begins here, as the formula was triggered.
    fn wakes(&mut self) -> bool {
        let sleeps = self.early.as_ref().is_some_and(|early| early.sleeps());
        let may_have_triggered = match &self.work {
            Work::Discrete(judge) => judge.may_have_triggered(),
            Work::Dense(_) => true,
        };
        if !sleeps || !may_have_triggered {
            return false;
        }
        if let Some(early) = &mut self.early {
            early.wake();
        }
        true
    }

    /// As [`FormulaJudge::step_early`], of a sample's robustness.
    fn step_awake(&mut self, time_secs: f64, atoms: &[f64]) -> Result<(), StepError> {
        let truth = |value: &f64| RobustnessBounds::of_value(*value).truth();
        let truths: Vec<Option<bool>> = atoms.iter().map(truth).collect();
        self.step_early(time_secs, &[(&truths, atoms)])
    }

    /// What is judged beside, as long as the trace is short and its end may decide.
    fn step_early(&mut self, time_secs: f64, samples: &[BothValues<'_>]) -> Result<(), StepError> {
        let Some(early) = &mut self.early else {
            return Ok(());
        };
        early.step(time_secs, samples)?;
        if self.verdict().is_some() {
            self.early = None;
        }
        Ok(())
    }

    /// As [`FormulaJudge::step_instant`], with the atoms that mark stand-ins.
    fn step_marked(
        &mut self,
        time_secs: f64,
        samples: &[BothValues<'_>],
        losses: Losses,
        is_stand_in: bool,
    ) -> Result<Progress, StepError> {
        let found = |(truth, values): &BothValues<'_>| [truth.len(), values.len()];
        if let Some(found) = (samples.iter().flat_map(found)).find(|it| *it != losses.atom_count) {
            return Err(StepError::AtomCount {
                expected: losses.atom_count,
                found,
            });
        }
        let marks = [Some(is_stand_in), None];
        let mark_values = marks.map(value_of);
        let marked: Vec<(Vec<Option<bool>>, Vec<f64>)> = samples
            .iter()
            .map(|(truth, values)| ([*truth, &marks].concat(), [*values, &mark_values].concat()))
            .collect();
        let borrowed: Vec<BothValues<'_>> = (marked.iter())
            .map(|(truth, values)| (&truth[..], &values[..]))
            .collect();
        self.take_instant(time_secs, &borrowed)
    }

    fn take_instant(
        &mut self,
        time_secs: f64,
        samples: &[BothValues<'_>],
    ) -> Result<Progress, StepError> {
        let before = self.before();
        match &mut self.work {
            Work::Discrete(judge) => {
                match samples {
                    [(truth, values)] => judge.step_both(time_secs, truth, values)?,
                    _ => judge.step_instant(time_secs, samples)?,
                };
                for (truth, _) in samples {
                    self.keep(before, time_secs, truth.iter().copied());
                }
            }
            Work::Dense(_) => self.take_dense(time_secs, samples)?,
        }
        self.last_secs = time_secs;
        Ok(Progress {
            verdict: self.verdict(),
        })
    }

    fn take_dense(&mut self, time_secs: f64, samples: &[BothValues<'_>]) -> Result<(), StepError> {
        for (place, (truth, values)) in samples.iter().enumerate() {
            let before = self.before();
            let Work::Dense(judge) = &mut self.work else {
                return Ok(());
            };
            match place {
                0 => judge.step_both(time_secs, truth, values)?,
                _ => judge.step_again(truth, values)?,
            };
            let at_secs = time_secs + place as f64 * 1e-9;
            self.keep(before, at_secs, truth.iter().copied());
        }
        Ok(())
    }

    /// Samples may be missing between the last one and the next, which is at `next_secs`: such as were
    /// taken between `from_secs` and `to_secs`. `truth` and `robustness` are what is known of the atoms
    /// meanwhile. The formula must have been compiled with [`Settings::losses`]; otherwise, and where
    /// it cannot be brought across, the trace counts as cut short here.
    ///
    /// # Errors
    /// As [`FormulaJudge::step`].
    pub fn lose(
        &mut self,
        (from_secs, to_secs): (f64, f64),
        next_secs: f64,
        (truth, robustness): BothValues<'_>,
    ) -> Result<(), StepError> {
        self.has_lost = true;
        if let Some(early) = &mut self.early {
            early.lose((from_secs, to_secs), next_secs, (truth, robustness))?;
        }
        let Some(losses) = self.losses.filter(|_| !self.is_cut) else {
            self.is_cut = true;
            return Ok(());
        };
        let limits = match losses.across {
            Across::Cut => None,
            Across::Unknown => Some((0, f64::INFINITY)),
            Across::StandIns {
                count,
                spacing_secs,
            } => Some((count, spacing_secs)),
        };
        let times_secs = limits.and_then(|limits| {
            stand_ins(limits, (from_secs, to_secs), (self.last_secs, next_secs))
        });
        let Some(times_secs) = times_secs else {
            self.is_cut = true;
            return Ok(());
        };
        if losses.across == Across::Unknown {
            let unknown = (vec![None; truth.len()], vec![f64::NAN; robustness.len()]);
            if let Some(first_secs) = times_secs.first() {
                self.take_instant(*first_secs, &[(&unknown.0, &unknown.1)])?;
            }
            return Ok(());
        }
        for same in times_secs.chunk_by(|one, other| one == other) {
            let samples = vec![(truth, robustness); same.len()];
            self.step_marked(same[0], &samples, losses, true)?;
        }
        Ok(())
    }

    /// Takes the next samples: their times in seconds, and for each atom its robustness at each of
    /// them. The result is that of [`FormulaJudge::step`] for each sample, and in discrete time comes
    /// several times as fast.
    ///
    /// # Errors
    /// As [`FormulaJudge::step`]. In discrete time none of the samples is taken then; in dense time
    /// those before the wrong one are.
    pub fn step_many(
        &mut self,
        times_secs: &[f64],
        atoms: &[&[f64]],
    ) -> Result<Progress, StepError> {
        if self.losses.is_some() || self.is_watched() || matches!(self.work, Work::Dense(_)) {
            let taken = self.step_each(times_secs, atoms)?;
            let rest: Vec<&[f64]> = (atoms.iter())
                .map(|column| column.get(taken..).unwrap_or_default())
                .collect();
            return match &times_secs[taken..] {
                [] => Ok(Progress {
                    verdict: self.verdict(),
                }),
                later => self.step_many(later, &rest),
            };
        }
        let undecided = self.verdict().is_none();
        let Work::Discrete(judge) = &mut self.work else {
            return Ok(Progress { verdict: None });
        };
        let progress = judge.step_many(times_secs, atoms)?;
        self.last_secs = times_secs.last().copied().unwrap_or(self.last_secs);
        if undecided {
            // What explains a violation ends where it is determined.
            let decided_at_secs = judge.decided_at_secs().unwrap_or(f64::INFINITY);
            let last = times_secs.partition_point(|&time_secs| time_secs <= decided_at_secs);
            self.record.push_many(&times_secs[..last], atoms);
        }
        if self.wakes() {
            // None of those before the trigger matters, and it is among these.
            let mut values = vec![f64::NAN; atoms.len()];
            for (at, &time_secs) in times_secs.iter().enumerate() {
                for (value, column) in values.iter_mut().zip(atoms) {
                    *value = column[at];
                }
                self.step_awake(time_secs, &values)?;
                if !self.is_watched() {
                    break;
                }
            }
        }
        Ok(progress)
    }

    /// As [`FormulaJudge::step_many`], one by one, until the rest can be taken at once; gives how many were taken.
    fn step_each(&mut self, times_secs: &[f64], atoms: &[&[f64]]) -> Result<usize, StepError> {
        let stays = self.losses.is_some() || matches!(self.work, Work::Dense(_));
        let mut values = vec![f64::NAN; atoms.len()];
        for (at, &time_secs) in times_secs.iter().enumerate() {
            if !stays && !self.is_watched() {
                return Ok(at);
            }
            for (value, column) in values.iter_mut().zip(atoms) {
                let found = column.len();
                *value = *column.get(at).ok_or(StepError::AtomCount {
                    expected: times_secs.len(),
                    found,
                })?;
            }
            self.step(time_secs, &values)?;
        }
        Ok(times_secs.len())
    }

    /// Whether conjuncts are judged beside the formula.
    fn is_watched(&self) -> bool {
        self.early.as_ref().is_some_and(|early| early.is_at_work())
    }

    /// The place of the last sample, if the next one is to be kept.
    fn before(&self) -> Option<i64> {
        let place = match &self.work {
            Work::Discrete(_) => 0,
            Work::Dense(judge) => judge.place(),
        };
        self.verdict().is_none().then_some(place)
    }

    /// Keeps a sample for an explanation, and what changed between it and the last one.
    fn keep(
        &mut self,
        before: Option<i64>,
        time_secs: f64,
        atoms: impl Iterator<Item = Option<bool>>,
    ) {
        let Some(before) = before else { return };
        if let Work::Dense(judge) = &self.work {
            for (time_secs, truths) in judge.changes(before) {
                self.record.push(time_secs, truths.into_iter());
            }
        }
        self.record.push(time_secs, atoms);
    }

    /// The verdict, once no continuation can change it.
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        either!(&self.work, judge => judge.verdict())
    }

    /// The robust satisfaction interval: the least and the greatest robustness that this trace can
    /// still have, whatever comes after the samples so far. `None` if robustness was not asked for or
    /// there was no sample. It is what [`FormulaJudge::finish`] would say with
    /// [`Ending::Inconclusive`].
    ///
    /// In discrete time this mostly takes constant time, in dense time as long as copying what is
    /// stored ([`FormulaJudge::stored`]).
    ///
    /// ```
    /// use temporal::formula::{Ending, FormulaMonitor, Settings, parse};
    /// let formula = parse("always (near => eventually[0, 1 samples] slow)", &|_| None)?.formula;
    /// let settings = Settings::discrete(Ending::Finite).with_robustness();
    /// let mut judge = FormulaMonitor::compile(&formula, &settings)?.start();
    /// judge.step(0.0, &[0.5, -0.25])?;
    /// judge.step(1.0, &[-0.5, 0.125])?;
    /// let bounds = judge.robustness_bounds().ok_or("there was a sample")?;
    /// assert_eq!((bounds.low, bounds.high), (f64::NEG_INFINITY, 0.125));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn robustness_bounds(&self) -> Option<RobustnessBounds> {
        either!(&self.work, judge => judge.robustness_bounds())
    }

    /// Whether the trigger was seen to be true, as far as that is known.
    pub(super) fn has_triggered(&self) -> bool {
        either!(&self.work, judge => judge.has_triggered())
    }

    /// How many values, stretches and times are stored: what bounds the memory.
    #[must_use]
    pub fn stored(&self) -> usize {
        either!(&self.work, judge => judge.stored())
    }

    /// The trace is known to have gone on until `end_secs`, a time of its clock, without another sample: it is not shorter than
    /// that ([`Ending::LongEnough`]).
    pub fn lasted_until(&mut self, end_secs: f64) {
        if let Some(early) = &mut self.early {
            early.lasted_until(end_secs);
        }
    }

    /// Nothing can be said of the trace, since samples may be missing anywhere in it.
    pub fn void(&mut self) {
        self.is_void = true;
    }

    /// Ends the trace. `complete` is false if it was cut short: then
    /// [`Ending::Finite`] is treated as
    /// [`Ending::Inconclusive`].
    #[must_use]
    pub fn finish(self, complete: bool) -> FormulaReport {
        let complete = complete && !self.is_cut;
        let ending = match self.ending {
            Ending::Finite if !complete => Ending::Inconclusive,
            ending => ending,
        };
        let early = self.early.as_ref().filter(|_| complete);
        let best = early.and_then(|_| self.robustness_bounds());
        let weak = early.map(|_| {
            let work = self.work.clone();
            either!(work, judge => judge.with_ending(Ending::Weak).finish(complete))
        });
        let mut report = either!(self.work, judge => judge.finish(complete));
        if self.is_void {
            report.verdict = Verdict::Inconclusive;
            report.robustness = report.robustness.map(|_| RobustnessBounds::UNKNOWN);
            report.decided_at_secs = None;
        }
        if report.verdict == Verdict::NotCovered && (self.has_lost || !complete) {
            // What was lost, or comes behind where it was cut short, may trigger it.
            report.verdict = Verdict::Inconclusive;
        }
        if let Some(early) = self.early.filter(|_| complete)
            && let Some(said) = early.said_instead(&report, weak.as_ref(), best, self.last_secs)
        {
            report = said;
        }
        if report.verdict == Verdict::Violated {
            // What was kept ends where the verdict was determined, if it was before the end.
            let ending = if report.decided_at_secs.is_some() {
                Ending::Inconclusive
            } else {
                ending
            };
            report.explanation = explain(&self.formula, &self.record, self.time, ending);
            if let (Some(losses), Some(explanation)) = (self.losses, &mut report.explanation) {
                // That a sample is none of the stand-ins is no reason.
                (explanation.atoms).retain(|part| part.atom.0 < losses.atom_count);
            }
        }
        report
    }
}

/// The robustness of an atom of which the truth alone is known.
fn value_of(truth: Option<bool>) -> f64 {
    match truth {
        Some(true) => f64::INFINITY,
        Some(false) => f64::NEG_INFINITY,
        None => f64::NAN,
    }
}
