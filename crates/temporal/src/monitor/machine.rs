//! The state machine that carries out a monitor; its semantics are defined in [`super`].

use super::report::{Failure, FailureReason, MonitorReport, StepError, Verdict};
use super::spec::{AtEnd, MonitorSpec, Repeat, SpecError, Stage, Trigger};
use crate::clock::tolerance_secs;

/// A proposition of one monitor: its position in [`Monitor::propositions`].
pub type PropId = usize;

/// A monitor that is ready to judge traces; it can be shared by threads.
#[derive(Debug, Clone, PartialEq)]
pub struct Monitor {
    propositions: Vec<String>,
    when: PropId,
    trigger: Trigger,
    stages: Vec<Step>,
    repeat: Repeat,
    at_end: AtEnd,
}

/// A stage over proposition numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    Assert(PropId),
    WaitFor {
        proposition: PropId,
        within_secs: f64,
    },
    Hold {
        proposition: PropId,
        until: PropId,
        within_secs: f64,
    },
}

impl Step {
    fn proposition(self) -> PropId {
        match self {
            Step::Assert(proposition)
            | Step::WaitFor { proposition, .. }
            | Step::Hold { proposition, .. } => proposition,
        }
    }

    /// The longest that it may last, in seconds; infinite if there is no limit.
    pub(super) fn within_secs(self) -> f64 {
        match self {
            Step::Assert(_) => 0.0,
            Step::WaitFor { within_secs, .. } | Step::Hold { within_secs, .. } => within_secs,
        }
    }
}

impl Monitor {
    /// Checks `spec` and numbers its propositions.
    ///
    /// # Errors
    /// [`SpecError`] if there is no stage, a proposition is empty or a deadline is not a duration.
    pub fn compile(spec: &MonitorSpec) -> Result<Self, SpecError> {
        let names = spec.propositions();
        if names.iter().any(|name| name.trim().is_empty()) {
            return Err(SpecError::EmptyProposition);
        }
        if spec.then.is_empty() {
            return Err(SpecError::NoStages);
        }
        let number = |name: &str| names.iter().position(|other| *other == name).unwrap_or(0);
        let mut stages = Vec::with_capacity(spec.then.len());
        for stage in &spec.then {
            stages.push(match stage {
                Stage::Assert { proposition } => Step::Assert(number(proposition)),
                Stage::WaitFor {
                    proposition,
                    within_secs,
                } => Step::WaitFor {
                    proposition: number(proposition),
                    within_secs: duration(*within_secs)?,
                },
                Stage::Hold {
                    proposition,
                    until,
                    within_secs,
                } => Step::Hold {
                    proposition: number(proposition),
                    until: number(until),
                    within_secs: duration(*within_secs)?,
                },
            });
        }
        Ok(Monitor {
            when: number(&spec.when),
            trigger: spec.trigger,
            stages,
            repeat: spec.repeat,
            at_end: spec.at_end,
            propositions: names.into_iter().map(str::to_owned).collect(),
        })
    }

    /// The propositions; a [`PropId`] is a position in this list.
    #[must_use]
    pub fn propositions(&self) -> &[String] {
        &self.propositions
    }

    /// What becomes of an instance under way at the end.
    pub(super) fn at_end(&self) -> AtEnd {
        self.at_end
    }

    /// The precondition.
    pub(super) fn when(&self) -> PropId {
        self.when
    }

    /// What is asserted, if all is judged at once.
    pub(super) fn asserted(&self) -> Option<Vec<PropId>> {
        let asserted = self.stages.iter().map(|step| match step {
            Step::Assert(proposition) => Some(*proposition),
            _ => None,
        });
        asserted.collect()
    }

    /// What it is made of.
    pub(super) fn parts(&self) -> (PropId, Trigger, Repeat, AtEnd, &[Step]) {
        (
            self.when,
            self.trigger,
            self.repeat,
            self.at_end,
            &self.stages,
        )
    }

    /// Begins to judge a trace.
    #[must_use]
    pub fn start(&self) -> Judge<'_> {
        Judge {
            monitor: self,
            instance: None,
            when_before: None,
            last_secs: f64::NEG_INFINITY,
            has_lost: false,
            is_blind: false,
            report: MonitorReport {
                triggered: 0,
                passed: 0,
                failed: 0,
                pending: 0,
                inconclusive: 0,
                overlapping: 0,
                when_unknown: 0,
                first_failure: None,
                verdict: Verdict::NotCovered,
            },
        }
    }

    /// Judges a whole trace, given as times in seconds with a valuation each. `complete` is false
    /// if the recording was cut short.
    ///
    /// # Errors
    /// [`StepError`] if the times are not finite or do not increase.
    pub fn judge<V: Fn(PropId) -> Option<bool>>(
        &self,
        samples: impl IntoIterator<Item = (f64, V)>,
        complete: bool,
    ) -> Result<MonitorReport, StepError> {
        let mut judge = self.start();
        for (time_secs, valuation) in samples {
            judge.step(time_secs, &valuation)?;
        }
        Ok(judge.finish(complete))
    }
}

/// A duration of at least 0 seconds, infinite if there is none.
fn duration(within_secs: Option<f64>) -> Result<f64, SpecError> {
    match within_secs {
        None => Ok(f64::INFINITY),
        Some(secs) if secs >= 0.0 && secs.is_finite() => Ok(secs),
        Some(within_secs) => Err(SpecError::BadWithin { within_secs }),
    }
}

/// A monitor at work on one trace.
#[derive(Debug, Clone)]
pub struct Judge<'m> {
    monitor: &'m Monitor,
    instance: Option<Instance>,
    /// The last known value of the precondition.
    when_before: Option<bool>,
    last_secs: f64,
    /// Whether samples were lost, and whether nothing that comes later can be judged for that.
    has_lost: bool,
    is_blind: bool,
    report: MonitorReport,
}

/// One pass through the stages.
#[derive(Debug, Clone, Copy)]
struct Instance {
    triggered_at_secs: f64,
    stage: usize,
    /// Time at which the stage was entered, in seconds.
    entered_secs: f64,
    /// Something asserted or held was unknown, so that this instance can no longer pass.
    doubtful: bool,
    /// What ends the current stage was unknown, so that this stage can no longer fail.
    end_unseen: bool,
}

/// What a stage does at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Move {
    Stay,
    Next,
    Fail(FailureReason),
    Unclear,
}

/// A stage of an instance at one sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Visit {
    pub(super) step: Step,
    /// When the stage was entered, in seconds.
    pub(super) entered_secs: f64,
    pub(super) time_secs: f64,
    pub(super) moved: Move,
}

/// Where a time lies in relation to a deadline.
#[derive(PartialEq)]
enum Deadline {
    Ahead,
    Now,
    Passed,
}

impl Judge<'_> {
    /// Takes the next sample: its time on the trace's clock, and the value of each proposition
    /// there, `None` where it is unknown.
    ///
    /// # Errors
    /// [`StepError`] if the time is not finite or not after the last one; the sample is not
    /// taken then.
    pub fn step(
        &mut self,
        time_secs: f64,
        valuation: &dyn Fn(PropId) -> Option<bool>,
    ) -> Result<(), StepError> {
        self.step_seen(time_secs, valuation, &mut |_| ())
    }

    /// As [`Judge::step`], where `seen` is told of each stage that an instance is in at this sample.
    pub(super) fn step_seen(
        &mut self,
        time_secs: f64,
        valuation: &dyn Fn(PropId) -> Option<bool>,
        seen: &mut dyn FnMut(Visit),
    ) -> Result<(), StepError> {
        if !time_secs.is_finite() || time_secs <= self.last_secs {
            return Err(StepError {
                last_secs: self.last_secs,
                time_secs,
            });
        }
        self.last_secs = time_secs;
        if self.is_blind {
            return Ok(());
        }
        self.advance(time_secs, valuation, seen);
        if self.triggers(valuation(self.monitor.when)) {
            if self.instance.is_some() {
                self.report.overlapping += 1;
            } else if self.monitor.repeat == Repeat::EveryTrigger || self.report.triggered == 0 {
                self.report.triggered += 1;
                self.instance = Some(Instance {
                    triggered_at_secs: time_secs,
                    stage: 0,
                    entered_secs: time_secs,
                    doubtful: false,
                    end_unseen: false,
                });
                self.advance(time_secs, valuation, seen);
            }
        }
        Ok(())
    }

    fn triggers(&mut self, when: Option<bool>) -> bool {
        let Some(now) = when else {
            self.report.when_unknown += 1;
            return false;
        };
        let before = self.when_before.replace(now);
        match self.monitor.trigger {
            Trigger::EachSample => now,
            Trigger::BecomesTrue => now && before != Some(true),
        }
    }

    /// Takes the instance under way, if any, through as many stages as this sample ends.
    fn advance(
        &mut self,
        time_secs: f64,
        valuation: &dyn Fn(PropId) -> Option<bool>,
        seen: &mut dyn FnMut(Visit),
    ) {
        let Some(mut instance) = self.instance.take() else {
            return;
        };
        while let Some(&step) = self.monitor.stages.get(instance.stage) {
            let moved = instance.judge(step, time_secs, valuation);
            seen(Visit {
                step,
                entered_secs: instance.entered_secs,
                time_secs,
                moved,
            });
            match moved {
                Move::Stay => {
                    self.instance = Some(instance);
                    return;
                }
                Move::Next => {
                    instance.stage += 1;
                    instance.entered_secs = time_secs;
                    instance.end_unseen = false;
                }
                Move::Fail(reason) => {
                    self.fail(&instance, time_secs, reason);
                    return;
                }
                Move::Unclear => {
                    self.report.inconclusive += 1;
                    return;
                }
            }
        }
        if instance.doubtful {
            self.report.inconclusive += 1;
        } else {
            self.report.passed += 1;
        }
    }

    fn fail(&mut self, instance: &Instance, time_secs: f64, reason: FailureReason) {
        self.report.failed += 1;
        if self.report.first_failure.is_none() {
            let step = self.monitor.stages[instance.stage];
            // By a deadline, what is missing is the end of the stage.
            let proposition = match (step, reason) {
                (Step::Hold { until, .. }, FailureReason::Deadline | FailureReason::EndOfTrace) => {
                    until
                }
                _ => step.proposition(),
            };
            let entered_secs = instance.entered_secs;
            let (false_from_secs, false_to_secs) = match reason {
                FailureReason::AssertedFalse | FailureReason::HoldBroken => (time_secs, time_secs),
                FailureReason::Deadline => {
                    let deadline_secs = entered_secs + step.within_secs();
                    (entered_secs, deadline_secs.min(time_secs))
                }
                FailureReason::EndOfTrace => (entered_secs, time_secs),
            };
            self.report.first_failure = Some(Failure {
                time_secs,
                stage: instance.stage,
                proposition: self.monitor.propositions[proposition].clone(),
                triggered_at_secs: instance.triggered_at_secs,
                false_from_secs,
                false_to_secs,
                reason,
            });
        }
    }

    /// Samples may be missing between the last one and the next: any number, with any values.
    ///
    /// An instance under way may have passed or failed there, and another one may have begun that is
    /// still under way, so that later triggers begin none: the former ends inconclusive, and nothing
    /// later is judged. If all stages are assertions none can be under way, and what is asserted at a
    /// later trigger is judged: one that is seen to become true behind the loss. The verdict is then
    /// `Violated` or `Inconclusive`, whatever the lost samples were, unless it was determined before.
    pub fn lose(&mut self) {
        if self.is_decided() {
            return;
        }
        self.has_lost = true;
        if self.instance.take().is_some() {
            self.report.inconclusive += 1;
        }
        let only_first = self.monitor.repeat == Repeat::Once;
        self.is_blind |= only_first || self.monitor.asserted().is_none();
        // It may have become true unseen.
        self.when_before = Some(true);
    }

    /// Nothing can be said of the trace, since samples may be missing anywhere in it.
    pub fn void(&mut self) {
        *self = self.monitor.start();
        (self.has_lost, self.is_blind) = (true, true);
    }

    /// Whether the only instance is over.
    fn is_decided(&self) -> bool {
        let only_first = self.monitor.repeat == Repeat::Once;
        only_first && self.report.triggered > 0 && self.instance.is_none()
    }

    /// How many instances have begun so far.
    pub(super) fn triggered(&self) -> u64 {
        self.report.triggered
    }

    /// How many instances have failed so far.
    #[must_use]
    pub fn failed(&self) -> u64 {
        self.report.failed
    }

    /// The stage that the instance under way is in, and since when, if there is one that fails if a
    /// complete trace ends here.
    pub(super) fn would_fail(&self) -> Option<(Step, f64)> {
        let instance = self.instance.as_ref()?;
        let fails = self.monitor.at_end == AtEnd::FailPending && !instance.end_unseen;
        let step = self.monitor.stages.get(instance.stage).copied()?;
        fails.then_some((step, instance.entered_secs))
    }

    /// Ends the trace. `complete` is false if the recording was cut short: then nothing fails for
    /// being under way, and the verdict is [`Verdict::Satisfied`] only if nothing can follow.
    #[must_use]
    pub fn finish(mut self, complete: bool) -> MonitorReport {
        let complete = complete && !self.has_lost;
        let has_lost = self.has_lost;
        if let Some(instance) = self.instance.take() {
            let fails = self.monitor.at_end == AtEnd::FailPending && !instance.end_unseen;
            if complete && fails {
                self.fail(&instance, self.last_secs, FailureReason::EndOfTrace);
            } else {
                self.report.pending += 1;
            }
        }
        let report = &self.report;
        let over = complete || self.monitor.repeat == Repeat::Once;
        self.report.verdict = if report.failed > 0 {
            Verdict::Violated
        } else if report.triggered == 0 && !has_lost {
            Verdict::NotCovered
        } else if report.passed == report.triggered && over && report.triggered > 0 {
            Verdict::Satisfied
        } else {
            Verdict::Inconclusive
        };
        self.report
    }
}

impl Instance {
    fn judge(
        &mut self,
        step: Step,
        time_secs: f64,
        valuation: &dyn Fn(PropId) -> Option<bool>,
    ) -> Move {
        match step {
            Step::Assert(proposition) => match valuation(proposition) {
                Some(true) => Move::Next,
                Some(false) => Move::Fail(FailureReason::AssertedFalse),
                None => {
                    self.doubtful = true;
                    Move::Next
                }
            },
            Step::WaitFor {
                proposition,
                within_secs,
            } => self.wait(valuation(proposition), time_secs, within_secs),
            Step::Hold {
                proposition,
                until,
                within_secs,
            } => {
                let end = self.wait(valuation(until), time_secs, within_secs);
                if self.deadline(time_secs, within_secs) == Deadline::Passed
                    || matches!(end, Move::Next)
                {
                    return end;
                }
                match valuation(proposition) {
                    Some(true) => end,
                    Some(false) if self.end_unseen => Move::Unclear,
                    Some(false) => Move::Fail(FailureReason::HoldBroken),
                    None => {
                        self.doubtful = true;
                        end
                    }
                }
            }
        }
    }

    /// Waits for the end of a stage, which is now seen to be there, not there, or not seen.
    fn wait(&mut self, end: Option<bool>, time_secs: f64, within_secs: f64) -> Move {
        let deadline = self.deadline(time_secs, within_secs);
        if deadline != Deadline::Passed {
            match end {
                Some(true) => return Move::Next,
                Some(false) => {}
                None => self.end_unseen = true,
            }
        }
        match deadline {
            Deadline::Ahead => Move::Stay,
            _ if self.end_unseen => Move::Unclear,
            _ => Move::Fail(FailureReason::Deadline),
        }
    }

    fn deadline(&self, time_secs: f64, within_secs: f64) -> Deadline {
        let left_secs = within_secs - (time_secs - self.entered_secs);
        let tolerance_secs = tolerance_secs(time_secs);
        if left_secs > tolerance_secs {
            Deadline::Ahead
        } else if left_secs >= -tolerance_secs {
            Deadline::Now
        } else {
            Deadline::Passed
        }
    }
}
