//! A formula that is ready to judge traces in either model of time, and one at work on a trace.

use std::sync::Arc;

use super::ast::Formula;
use super::dense::{DenseJudge, DenseMonitor};
use super::discrete::{DiscreteJudge, DiscreteMonitor};
use super::explain::{Record, explain};
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
}

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
        let before = self.before();
        let progress = either!(&mut self.work, judge => judge.step(time_secs, atoms))?;
        self.keep(
            before,
            time_secs,
            atoms
                .iter()
                .map(|&value| RobustnessBounds::of_value(value).truth()),
        );
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
        let before = self.before();
        let progress = either!(&mut self.work, judge => judge.step_truth(time_secs, atoms))?;
        self.keep(before, time_secs, atoms.iter().copied());
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
        let before = self.before();
        let progress =
            either!(&mut self.work, judge => judge.step_both(time_secs, truth, robustness))?;
        self.keep(before, time_secs, truth.iter().copied());
        Ok(progress)
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
        let undecided = self.verdict().is_none();
        let Work::Discrete(judge) = &mut self.work else {
            return self.step_each(times_secs, atoms);
        };
        let progress = judge.step_many(times_secs, atoms)?;
        if undecided {
            // What explains a violation ends where it is determined.
            let decided_at_secs = judge.decided_at_secs().unwrap_or(f64::INFINITY);
            let last = times_secs.partition_point(|&time_secs| time_secs <= decided_at_secs);
            self.record.push_many(&times_secs[..last], atoms);
        }
        Ok(progress)
    }

    /// As [`FormulaJudge::step_many`], one by one.
    fn step_each(&mut self, times_secs: &[f64], atoms: &[&[f64]]) -> Result<Progress, StepError> {
        let mut values = vec![f64::NAN; atoms.len()];
        for (at, &time_secs) in times_secs.iter().enumerate() {
            for (value, column) in values.iter_mut().zip(atoms) {
                let found = column.len();
                *value = *column.get(at).ok_or(StepError::AtomCount {
                    expected: times_secs.len(),
                    found,
                })?;
            }
            self.step(time_secs, &values)?;
        }
        Ok(Progress {
            verdict: self.verdict(),
        })
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

    /// How many values, stretches and times are stored: what bounds the memory.
    #[must_use]
    pub fn stored(&self) -> usize {
        either!(&self.work, judge => judge.stored())
    }

    /// Ends the trace. `complete` is false if it was cut short: then
    /// [`Ending::Finite`] is treated as
    /// [`Ending::Inconclusive`].
    #[must_use]
    pub fn finish(self, complete: bool) -> FormulaReport {
        let ending = match self.ending {
            Ending::Finite if !complete => Ending::Inconclusive,
            ending => ending,
        };
        let mut report = either!(self.work, judge => judge.finish(complete));
        if report.verdict == Verdict::Violated {
            // What was kept ends where the verdict was determined, if it was before the end.
            let ending = if report.decided_at_secs.is_some() {
                Ending::Inconclusive
            } else {
                ending
            };
            report.explanation = explain(&self.formula, &self.record, self.time, ending);
        }
        report
    }
}
