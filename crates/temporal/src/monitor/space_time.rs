//! Space-time robustness of a staged monitor: how near a run came to the other verdict, in space and in time.
//!
//! # Definition
//! The robustness ([`super::RobustnessMonitor`]) is infinite wherever truth values decide, and says
//! nothing of time. This is a number for those monitors, too. It is the least over everything
//! that instances of the monitor meet, each as a share of what is allowed, so that metres, newtons
//! and seconds can be put beside each other:
//!
//! * *degree* of a proposition p at time t, with the sign of its truth: the number that is given with it
//!   ([`Graded::degree`]); where there is none, d / (d + 1 s), d the time since p last changed, in
//!   seconds (its time robustness to the left);
//! * `assert p`: the degree of p where it is judged;
//! * `wait_for p within L`: (L - w) / L, w the time waited, at each sample until p comes. So what
//!   counts is the time that was left when it came, and below 0 the time that has been missed since
//!   (counted on behind the failure until p comes). Without a deadline L lasts
//!   from the beginning of the stage to the time by which every run ends, if that is known;
//! * `hold p until q within L`: the least degree of p that is given as a number, and the time left as above;
//! * a stage that is pending at the end and fails for it: the degree of what is waited for if that is a
//!   number, else -1;
//! * where the monitor judges at once (only `assert`) and its trigger has a degree: at samples that do
//!   not trigger, the greater of minus the trigger's degree and the assertions' least, as for
//!   an implication.
//!
//! # Source
//! Time and space robustness: A. Donze and O. Maler, "Robust satisfaction of temporal logic over
//! real-valued signals" (FORMATS 2010). Deviations: of an instance's stages as they come and not of
//! formulas, since of a conjunction with `until` the time robustness is that of an instant, 0; only to the left, so
//! that it is known while the run lasts; and space and time in one number, as shares.
//!
//! # Guarantee
//! On a complete trace it is negative exactly if the monitor is violated (tested on random monitors
//! and traces): [`super::Judge`] decides, and this only measures. While a run lasts, what
//! is known of it never rises. How large it is depends on how degrees are scaled: it orders runs for a search or for splitting,
//! and is no evidence.
//!
//! # Cost
//! O(m) a sample for m propositions; memory: m times and the deadlines that were missed.

use super::machine::{Judge, Monitor, Move, PropId, Step, Visit};
use super::report::{FailureReason, StepError};
use super::spec::AtEnd;

/// The least distance from 0: the sign is that of the verdict.
const LEAST: f64 = 1e-9;

/// The truth of a proposition at a sample, and by how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Graded {
    /// `None` if it is unknown.
    pub truth: Option<bool>,
    /// How far it is from changing, as a share of what is allowed; not finite if it is only true or
    /// false. Where its sign contradicts the truth, it counts as 0.
    pub degree: f64,
}

/// The space-time robustness of a staged monitor on one trace.
///
/// ```
/// use temporal::monitor::{Graded, SpaceTimeJudge, Monitor, MonitorSpec, Stage};
/// let spec = MonitorSpec::new("decided", vec![
///     Stage::WaitFor { proposition: "released".into(), within_secs: Some(2.0) },
/// ]);
/// let monitor = Monitor::compile(&spec)?;
/// let mut judge = SpaceTimeJudge::new(&monitor, None);
/// for (time_secs, values) in [(0.0, [true, false]), (1.5, [true, true])] {
///     let graded = |p: usize| Graded { truth: Some(values[p]), degree: f64::NAN };
///     judge.step(time_secs, &graded)?;
/// }
/// // A quarter of the time was left.
/// assert_eq!(judge.finish(true), Some(0.25));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct SpaceTimeJudge<'m> {
    monitor: &'m Monitor,
    judge: Judge<'m>,
    /// The time by which every run ends.
    ends_by_secs: Option<f64>,
    /// Of each proposition its truth, and since when.
    since: Vec<Option<(bool, f64)>>,
    /// Of each its last degree, if that was a number.
    degrees: Vec<Option<f64>>,
    /// What has missed its deadline and has not come since.
    missed: Vec<Missed>,
    least: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Missed {
    awaited: PropId,
    due_secs: f64,
    allowed_secs: f64,
}

impl<'m> SpaceTimeJudge<'m> {
    /// Begins with a trace. `ends_by_secs`: the time by which every run ends, if it is known.
    #[must_use]
    pub fn new(monitor: &'m Monitor, ends_by_secs: Option<f64>) -> Self {
        let count = monitor.propositions().len();
        SpaceTimeJudge {
            monitor,
            judge: monitor.start(),
            ends_by_secs,
            since: vec![None; count],
            degrees: vec![None; count],
            missed: Vec::new(),
            least: None,
        }
    }

    /// Takes the next sample: its time in seconds, and each proposition.
    ///
    /// # Errors
    /// [`StepError`] if the time is not finite or not after the last one; the sample is not taken
    /// then.
    pub fn step(
        &mut self,
        time_secs: f64,
        graded: &dyn Fn(PropId) -> Graded,
    ) -> Result<(), StepError> {
        let mut visits = Vec::new();
        let triggered = self.judge.triggered();
        self.judge
            .step_seen(time_secs, &|p| graded(p).truth, &mut |visit| {
                visits.push(visit);
            })?;
        for proposition in 0..self.since.len() {
            self.take(proposition, time_secs, graded(proposition));
        }
        self.pass_by(time_secs);
        for visit in visits {
            self.visit(visit);
        }
        if self.judge.triggered() == triggered {
            self.near_trigger(time_secs);
        }
        Ok(())
    }

    /// What it is so far: it never rises. `None` as long as nothing has been met that has one.
    #[must_use]
    pub fn so_far(&self) -> Option<f64> {
        self.least
    }

    /// Ends the trace; `complete` is false if it was cut short.
    #[must_use]
    pub fn finish(mut self, complete: bool) -> Option<f64> {
        if let (true, Some((step, _))) = (complete, self.judge.would_fail()) {
            let awaited = awaited(step);
            let degree = self.degrees.get(awaited).copied().flatten();
            self.meet(degree.filter(|degree| *degree < 0.0).unwrap_or(-1.0));
        }
        self.least
    }

    /// Notes the truth and the degree of a proposition.
    fn take(&mut self, proposition: PropId, time_secs: f64, graded: Graded) {
        let Some(truth) = graded.truth else {
            self.since[proposition] = None;
            self.degrees[proposition] = None;
            return;
        };
        if self.since[proposition].is_none_or(|(before, _)| before != truth) {
            self.since[proposition] = Some((truth, time_secs));
        }
        let number = graded.degree.is_finite().then_some(graded.degree);
        self.degrees[proposition] = number.map(|degree| signed(degree, truth));
    }

    /// What has been missed grows until it comes.
    fn pass_by(&mut self, time_secs: f64) {
        let mut missed = std::mem::take(&mut self.missed);
        for late in &missed {
            let lateness = (time_secs - late.due_secs) / late.allowed_secs;
            self.meet(-lateness.max(LEAST));
        }
        missed.retain(|late| self.since[late.awaited].is_none_or(|(truth, _)| !truth));
        self.missed = missed;
    }

    /// A stage that an instance is in, or has just left.
    fn visit(&mut self, visit: Visit) {
        let Visit {
            step,
            entered_secs,
            time_secs,
            moved,
        } = visit;
        match (step, moved) {
            (_, Move::Unclear) => {}
            (Step::Assert(proposition), _) => {
                if let Some(degree) = self.degree(proposition, time_secs) {
                    self.meet(degree);
                }
            }
            (_, Move::Fail(FailureReason::Deadline)) => self.miss(step, entered_secs, time_secs),
            (Step::Hold { proposition, .. }, Move::Fail(_)) => {
                let degree = self.degree(proposition, time_secs);
                self.meet(degree.unwrap_or(-1.0));
            }
            (_, Move::Fail(_)) => self.meet(-1.0),
            (_, Move::Stay | Move::Next) => {
                let left = self.share_left(step, entered_secs, time_secs);
                self.meet(left.unwrap_or(1.0).max(LEAST));
                if let (Step::Hold { proposition, .. }, Move::Stay) = (step, moved)
                    && let Some(degree) = self.degrees[proposition]
                {
                    self.meet(degree);
                }
            }
        }
    }

    /// A deadline has passed: how far what was waited for was from coming, if that is a number, and
    /// from now on how late it is.
    fn miss(&mut self, step: Step, entered_secs: f64, time_secs: f64) {
        let awaited = awaited(step);
        let allowed_secs = step.within_secs();
        self.meet(self.degrees[awaited].map_or(-LEAST, |degree| degree.min(-LEAST)));
        if allowed_secs > 0.0 {
            self.missed.push(Missed {
                awaited,
                due_secs: entered_secs + allowed_secs,
                allowed_secs,
            });
            self.pass_by(time_secs);
        }
    }

    /// The share of a stage's time that is left; `None` if it has all the time there is.
    fn share_left(&self, step: Step, entered_secs: f64, time_secs: f64) -> Option<f64> {
        let allowed_secs = match step.within_secs() {
            secs if secs.is_finite() => secs,
            // At the end of the run a stage fails only if it is said so.
            _ if self.monitor.at_end() == AtEnd::FailPending => self.ends_by_secs? - entered_secs,
            _ => return None,
        };
        let left_secs = allowed_secs - (time_secs - entered_secs);
        (allowed_secs > 0.0).then(|| left_secs / allowed_secs)
    }

    /// The degree of a proposition, by time if it is no number; `None` if it is unknown.
    fn degree(&self, proposition: PropId, time_secs: f64) -> Option<f64> {
        let (truth, since_secs) = self.since[proposition]?;
        let lasted = time_secs - since_secs;
        let by_time = || signed(lasted / (lasted + 1.0), truth);
        Some(self.degrees[proposition].unwrap_or_else(by_time))
    }

    /// How near a sample is to triggering what would fail at once.
    fn near_trigger(&mut self, time_secs: f64) {
        let Some(asserted) = self.monitor.asserted() else {
            return;
        };
        let Some(trigger) = self.degrees[self.monitor.when()] else {
            return;
        };
        if trigger > 0.0 {
            return;
        }
        let degrees = asserted
            .iter()
            .map(|proposition| self.degree(*proposition, time_secs));
        // What is unknown may be anything: the trigger alone is sure.
        let least = degrees.map(|degree| degree.unwrap_or(f64::NEG_INFINITY));
        let least = least.fold(f64::INFINITY, f64::min);
        self.meet(least.max(-trigger));
    }

    fn meet(&mut self, robustness: f64) {
        self.least = Some(self.least.map_or(robustness, |least| least.min(robustness)));
    }
}

/// What ends a stage.
fn awaited(step: Step) -> PropId {
    match step {
        Step::Assert(proposition) | Step::WaitFor { proposition, .. } => proposition,
        Step::Hold { until, .. } => until,
    }
}

/// A degree with the sign of the truth, never 0; what contradicts the truth is next to nothing.
fn signed(degree: f64, truth: bool) -> f64 {
    if truth {
        degree.max(LEAST)
    } else {
        degree.min(-LEAST)
    }
}
