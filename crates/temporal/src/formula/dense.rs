//! The engine for dense time: signals that hold their values between samples, judged at all times.
//!
//! # Definition
//! [`super::semantics::dense`], with nanoseconds for ticks: times, counted from the first sample,
//! and the bounds of intervals are rounded to whole nanoseconds, the resolution of recorded times,
//! and from there on all is exact. Late times are known less exactly; they, and with them the bounds,
//! are rounded to the least power of ten that is no less than the tolerance of the discrete engine,
//! four units in the last place (a microsecond for times of the calendar). Nothing is sampled:
//! signals are runs of constant values, and each operator maps runs to runs.
//!
//! # Source
//! Offline, the computation of robustness over piecewise signals operator by operator is by A. Donzé,
//! T. Ferrère and O. Maler ("Efficient robust monitoring for STL", CAV 2013), and bounds online by
//! J. V. Deshmukh et al. (2017). Deviations: signals are piecewise constant; all operators with a
//! window are one algorithm (the sliding composition of clamps, file `dense/window.rs`); values at
//! single points are kept apart from those of open intervals, so closed windows and `until` at a
//! point are exact; and the least and the greatest possible value are two computations of the same
//! positive form, of which the second begins only where something is unknown.
//!
//! # Guarantees
//! * The report is that of the definition.
//! * A verdict given early is never taken back. It comes when the values of operands, in the order
//!   of time, determine it: where an operator waits for its window, the verdict may come later than
//!   the first sample that excludes all others, but at most by the sum of the windows' ends.
//! * Cost: O(1) amortised for each change of an operand and operator, whatever the windows.
//! * Memory: the changes within the sum of the windows' ends, if windows are bounded. An unbounded
//!   `eventually`, `until` and so on within another operator keeps what it has not decided, with
//!   robustness possibly the whole trace; at the top it keeps two numbers.

pub(super) mod between;
pub(super) mod bounded;
mod clamp;
mod program;
mod stream;
mod window;

use between::{Between, Line};
use bounded::{Bounded, Counter};

use std::sync::Arc;

use super::ast::Formula;
use super::positive::{Positive, positive};
use super::report::{FormulaReport, Progress, RobustnessBounds, StepError};
use super::settings::{CompileError, Ending, Interpolation, Settings, TimeModel};
use crate::clock::{nanos_since, resolution_nanos};
use crate::monitor::Verdict;

/// A formula in dense time that is ready to judge traces; it can be shared by threads.
#[derive(Debug, Clone)]
pub struct DenseMonitor {
    parts: Arc<Parts>,
    atom_count: usize,
    interpolation: Interpolation,
    ending: Ending,
}

/// What is computed.
#[derive(Debug)]
struct Parts {
    formula: Positive,
    trigger: Option<Positive>,
    robustness: bool,
}

/// A formula in dense time at work on one trace.
#[derive(Debug, Clone)]
pub struct DenseJudge {
    parts: Arc<Parts>,
    atom_count: usize,
    ending: Ending,
    first_secs: Option<f64>,
    last_secs: f64,
    /// Whether an instant had several samples, so that places may be ahead of times.
    is_ahead: bool,
    /// The place of the last sample: twice its time in nanoseconds since the first one.
    place: i64,
    samples: u64,
    truth: Bounded,
    robustness: Option<Bounded>,
    trigger: Option<Counter>,
    verdict: Option<Verdict>,
    decided_at_secs: Option<f64>,
    interpolation: Interpolation,
    /// The atoms of the last sample, and before it since the one before.
    truth_bounds: Vec<RobustnessBounds>,
    truth_between: Vec<Between>,
    value_bounds: Vec<RobustnessBounds>,
    value_between: Vec<Between>,
    /// The atoms of the sample at hand, to be used again.
    truth_next: Vec<RobustnessBounds>,
    value_next: Vec<RobustnessBounds>,
}

impl DenseMonitor {
    /// Translates `formula`.
    ///
    /// # Errors
    /// [`CompileError`] if an interval makes no sense, the formula speaks of samples or is too large.
    pub fn compile(formula: &Formula, settings: &Settings) -> Result<Self, CompileError> {
        let trigger = settings.trigger.as_ref().or_else(|| formula.trigger());
        let of_trigger = trigger.map_or(0, Formula::atom_count);
        let own_trigger = trigger.map(|trigger| positive(trigger, TimeModel::Dense));
        Ok(DenseMonitor {
            parts: Arc::new(Parts {
                formula: positive(formula, TimeModel::Dense)?,
                trigger: own_trigger.transpose()?,
                robustness: settings.robustness,
            }),
            atom_count: formula.atom_count().max(of_trigger),
            interpolation: settings.interpolation,
            ending: settings.ending,
        })
    }

    /// Begins to judge a trace.
    #[must_use]
    pub fn start(&self) -> DenseJudge {
        let parts = &self.parts;
        DenseJudge {
            parts: Arc::clone(parts),
            atom_count: self.atom_count,
            ending: self.ending,
            first_secs: None,
            last_secs: f64::NEG_INFINITY,
            is_ahead: false,
            place: 0,
            samples: 0,
            truth: Bounded::new(&parts.formula, true),
            robustness: (parts.robustness).then(|| Bounded::new(&parts.formula, true)),
            trigger: parts.trigger.as_ref().map(Counter::new),
            verdict: None,
            decided_at_secs: None,
            interpolation: self.interpolation,
            truth_bounds: Vec::new(),
            truth_between: Vec::new(),
            value_bounds: Vec::new(),
            value_between: Vec::new(),
            truth_next: Vec::new(),
            value_next: Vec::new(),
        }
    }
}

impl DenseJudge {
    /// Takes the next sample: its time, and the robustness of each atom, which is not a number where
    /// it is unknown, and infinite where an atom is only true or false. The truth of an atom is the
    /// sign of its robustness, and unknown where that is 0; see [`DenseJudge::step_both`].
    ///
    /// # Errors
    /// [`StepError`] if the time is not finite or not a nanosecond after the last one, or there is
    /// not one value for each atom; the sample is not taken then.
    pub fn step(&mut self, time_secs: f64, atoms: &[f64]) -> Result<Progress, StepError> {
        let place = self.check(time_secs, atoms.len())?;
        self.truth_next.clear();
        self.truth_next.extend(atoms.iter().map(|&value| {
            let truth = RobustnessBounds::of_value(value).truth();
            RobustnessBounds::of_truth(truth)
        }));
        self.value_next.clear();
        self.value_next
            .extend(atoms.iter().map(|&value| RobustnessBounds::of_value(value)));
        Ok(self.take(time_secs, place))
    }

    /// Takes the next sample: its time, and the truth of each atom, `None` where it is unknown.
    ///
    /// # Errors
    /// As [`DenseJudge::step`].
    pub fn step_truth(
        &mut self,
        time_secs: f64,
        atoms: &[Option<bool>],
    ) -> Result<Progress, StepError> {
        let place = self.check(time_secs, atoms.len())?;
        self.truth_next.clear();
        self.truth_next
            .extend(atoms.iter().map(|&truth| RobustnessBounds::of_truth(truth)));
        self.value_next.clone_from(&self.truth_next);
        Ok(self.take(time_secs, place))
    }

    /// Takes the next sample with both the truth and the robustness of each atom, which decides
    /// atoms whose robustness is 0.
    ///
    /// # Errors
    /// As [`DenseJudge::step`].
    pub fn step_both(
        &mut self,
        time_secs: f64,
        truth: &[Option<bool>],
        robustness: &[f64],
    ) -> Result<Progress, StepError> {
        self.check(time_secs, truth.len())?;
        let place = self.check(time_secs, robustness.len())?;
        self.hear_both(truth, robustness);
        Ok(self.take(time_secs, place))
    }

    fn hear_both(&mut self, truth: &[Option<bool>], robustness: &[f64]) {
        self.truth_next.clear();
        self.truth_next
            .extend(truth.iter().map(|&truth| RobustnessBounds::of_truth(truth)));
        self.value_next.clear();
        self.value_next.extend(
            robustness
                .iter()
                .map(|&value| RobustnessBounds::of_value(value)),
        );
    }

    /// Takes another sample of the last one's time, which is put a nanosecond behind it.
    ///
    /// # Errors
    /// As [`DenseJudge::step`].
    pub fn step_again(
        &mut self,
        truth: &[Option<bool>],
        robustness: &[f64],
    ) -> Result<Progress, StepError> {
        if let Some(&found) = [truth.len(), robustness.len()]
            .iter()
            .find(|it| **it != self.atom_count)
        {
            return Err(StepError::AtomCount {
                expected: self.atom_count,
                found,
            });
        }
        self.is_ahead = true;
        self.hear_both(truth, robustness);
        Ok(self.take(self.last_secs, self.place + 2))
    }

    /// The verdict, once no continuation can change it.
    #[must_use]
    pub fn verdict(&self) -> Option<Verdict> {
        self.verdict
    }

    /// The least and the greatest robustness that this trace can still have, whatever comes; `None`
    /// if robustness is not computed or there was no sample. A copy of what is stored is finished.
    #[must_use]
    pub fn robustness_bounds(&self) -> Option<RobustnessBounds> {
        let robustness = self.robustness.as_ref().filter(|_| self.samples > 0)?;
        Some(robustness.clone().close(Ending::Inconclusive))
    }

    /// How many stretches of time are stored.
    #[must_use]
    pub fn stored(&self) -> usize {
        let trigger = self.trigger.as_ref().map_or(0, Counter::len);
        self.truth.len() + self.robustness.as_ref().map_or(0, Bounded::len) + trigger
    }

    /// The place of a sample that can be taken.
    fn check(&self, time_secs: f64, found: usize) -> Result<i64, StepError> {
        if found != self.atom_count {
            return Err(StepError::AtomCount {
                expected: self.atom_count,
                found,
            });
        }
        let last_nanos = self.first_secs.map(|_| self.place / 2);
        // Up to 2e18 places, and as many for a window, fit into 63 bits.
        let first_secs = self.first_secs.unwrap_or(time_secs);
        match nanos_since(first_secs, time_secs, last_nanos) {
            Some(nanos) if time_secs > self.last_secs => Ok(2 * nanos),
            // Samples of one instant have reached beyond this one.
            None if self.is_ahead
                && time_secs > self.last_secs
                && time_secs - first_secs <= 1e9 =>
            {
                Ok(self.place + 2)
            }
            _ => Err(StepError::Time {
                last_secs: self.last_secs,
                time_secs,
            }),
        }
    }

    /// Times begin here: where they are known less exactly than to a nanosecond, so are windows.
    fn begin(&mut self, time_secs: f64) {
        self.first_secs = Some(time_secs);
        let resolution_nanos = resolution_nanos(time_secs);
        if resolution_nanos > 1 {
            let formula = self.parts.formula.with_resolution(resolution_nanos);
            let trigger = self.parts.trigger.as_ref();
            let trigger = trigger.map(|trigger| trigger.with_resolution(resolution_nanos));
            self.truth = Bounded::new(&formula, true);
            self.robustness = (self.parts.robustness).then(|| Bounded::new(&formula, true));
            self.trigger = trigger.as_ref().map(Counter::new);
        }
    }

    /// Takes the sample at hand for the last one, and finds what was in between.
    fn interpolate(&mut self, place: i64) {
        self.truth_between.clear();
        self.value_between.clear();
        let before = self.truth_bounds.iter().zip(&self.value_bounds);
        for ((truth, value), next) in before.zip(&self.value_next) {
            let line = Line {
                places: [self.place, place],
                // Of an atom whose value is not known, neither bound is finite.
                values: [value, next].map(|bounds| {
                    if bounds.low == bounds.high {
                        bounds.low
                    } else {
                        f64::NAN
                    }
                }),
            };
            let (of_truth, of_value) = match self.interpolation {
                Interpolation::Hold => (Between::held(*truth, place), Between::held(*value, place)),
                Interpolation::Linear => (line.truth(*truth), line.robustness(*value)),
            };
            self.truth_between.push(of_truth);
            self.value_between.push(of_value);
        }
        std::mem::swap(&mut self.truth_bounds, &mut self.truth_next);
        std::mem::swap(&mut self.value_bounds, &mut self.value_next);
        self.place = place;
    }

    /// Where atoms change between the last two samples, if they are not held: times in seconds, and
    /// the truth from there on.
    pub(super) fn changes(&self, before: i64) -> Vec<(f64, Vec<Option<bool>>)> {
        if self.interpolation == Interpolation::Hold {
            return Vec::new();
        }
        let mut places: Vec<i64> = (self.truth_between.iter())
            .flat_map(|part| [before + 2, part.middle])
            .filter(|place| before < *place && *place < self.place)
            .collect();
        places.sort_unstable();
        places.dedup();
        let at = |place: i64| {
            let truth = |part: &Between| {
                if part.middle > place {
                    part.first
                } else {
                    part.then
                }
            };
            let truths = self.truth_between.iter().map(|part| truth(part).truth());
            (
                self.first_secs.unwrap_or(0.0) + place as f64 / 2e9,
                truths.collect(),
            )
        };
        places.into_iter().map(at).collect()
    }

    /// The place of the last sample.
    pub(super) fn place(&self) -> i64 {
        self.place
    }

    fn take(&mut self, time_secs: f64, place: i64) -> Progress {
        if self.first_secs.is_none() {
            self.begin(time_secs);
        }
        self.last_secs = time_secs;
        self.samples += 1;
        self.interpolate(place);
        if self.verdict.is_none() {
            self.truth
                .step(place, &self.truth_between, &self.truth_bounds);
        }
        if let Some(robustness) = &mut self.robustness {
            robustness.step(place, &self.value_between, &self.value_bounds);
        }
        if let Some(trigger) = &mut self.trigger {
            trigger.step(place, &self.truth_between, &self.truth_bounds);
        }
        if self.verdict.is_none()
            && let Some(truth) = self.truth.bounds().truth()
        {
            self.verdict = Some(if truth {
                Verdict::Satisfied
            } else {
                Verdict::Violated
            });
            self.decided_at_secs = Some(time_secs);
        }
        Progress {
            verdict: self.verdict,
        }
    }

    /// Whether the trigger was seen to be true, as far as that is known.
    pub(super) fn has_triggered(&self) -> bool {
        self.trigger.as_ref().is_some_and(|it| it.so_far() > 0)
    }

    /// The same with another ending.
    pub(super) fn with_ending(mut self, ending: Ending) -> Self {
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
        let seen = self.samples > 0;
        let mut close = |work: &mut Bounded| {
            if seen {
                work.close(ending)
            } else {
                RobustnessBounds::UNKNOWN
            }
        };
        // What is determined is not computed further.
        let verdict = self
            .verdict
            .unwrap_or_else(|| close(&mut self.truth).verdict());
        let robustness = self.robustness.as_mut().map(&mut close).filter(|_| seen);
        let triggered = self.trigger.as_mut().map(|trigger| {
            // What is said of times that were not seen triggers nothing.
            let ending = if matches!(ending, Ending::Finite | Ending::LongEnough) {
                ending
            } else {
                Ending::Inconclusive
            };
            if seen { trigger.close(ending) } else { 0 }
        });
        let doubtful = self.trigger.as_ref().is_some_and(|t| t.is_doubtful());
        FormulaReport {
            verdict: match (verdict, triggered) {
                // An unseen trigger may have been followed by anything.
                (Verdict::Inconclusive, Some(0)) if doubtful => verdict,
                (Verdict::Satisfied | Verdict::Inconclusive, Some(0)) => Verdict::NotCovered,
                (verdict, _) => verdict,
            },
            robustness,
            triggered: triggered.unwrap_or(0),
            has_trigger: triggered.is_some(),
            samples: self.samples,
            decided_at_secs: self.decided_at_secs,
            ends_before: None,
            left_out: None,
            explanation: None,
        }
    }
}
