//! One pass over one trace: every monitor is given each sample of the signals that it reads once.
//!
//! Memory is bounded by the monitors (their windows), not by the trace.

use super::at_work::{AtWork, Work};
use super::losses::{Losses, Lost, Masked};
use super::{
    CompiledRule, JudgedTrace, Judgement, Judges, Responsible, Robustness, SubjectJudge, Violation,
};
use diagnostic::Problem;
use temporal::formula::{FormulaReport, RobustnessBounds};
use temporal::monitor::{MonitorReport, StagedRobustness, Verdict};
use trace::{BoundPredicate, BoundQuantity, SignalIndex, SignalValues, Trace};

/// The least step of a clock that stands still, in seconds: the resolution of
/// recorded times.
pub(super) const CLOCK_STEP_SECS: f64 = 1e-9;

/// Judging one trace.
pub struct Session<'s, 'a> {
    judges: &'s Judges<'a>,
    predicates: Vec<BoundPredicate>,
    /// For each predicate, the channels that it reads.
    channels: Vec<Vec<usize>>,
    /// Whether a sample has been taken.
    begun: bool,
    clocks: Vec<BoundQuantity>,
    at_work: Vec<AtWork<'s>>,
    lost: Lost,
    /// Truth of each predicate at this sample.
    truth: Vec<Option<bool>>,
    /// Robustness of each predicate at this sample; NaN if unknown.
    robustness: Vec<f64>,
}

/// What a sample brings.
#[derive(Clone, Copy, Debug)]
pub struct News<'n> {
    /// For each channel, whether any of its values is another than before.
    pub changed: &'n [bool],
    /// For each signal, by channel and field, whether it has a sample here; `None`: all of the changed
    /// channels do.
    pub sampled: Option<&'n [Vec<bool>]>,
    /// For each signal, whether its value has become too old since its last sample.
    pub dropped: Option<&'n [Vec<bool>]>,
    /// Whether another sample of the same instant follows.
    pub more: bool,
}

impl News<'_> {
    /// Whether a signal has a sample here.
    pub fn is_sampled(&self, signal: SignalIndex) -> bool {
        match self.sampled {
            None => self.changed.get(signal.channel).is_none_or(|it| *it),
            Some(_) => is_among(self.sampled, signal),
        }
    }
}

fn is_among(marks: Option<&[Vec<bool>]>, signal: SignalIndex) -> bool {
    let fields = marks.and_then(|marks| marks.get(signal.channel));
    fields.is_some_and(|fields| fields.get(signal.field).is_some_and(|it| *it))
}

impl<'s, 'a> Session<'s, 'a> {
    pub(super) fn new(
        judges: &'s Judges<'a>,
        layout: &Trace,
        losses: &Losses,
    ) -> Result<Self, Problem> {
        let predicates = judges.predicates.iter().enumerate().map(|(place, p)| {
            let bound = p.bind(layout);
            bound.map_err(|error| judges.in_proposition(place, &error))
        });
        let predicates = predicates.collect::<Result<Vec<_>, _>>()?;
        let clocks = judges.clocks.iter().enumerate().map(|(place, c)| {
            let bound = c.bind(layout);
            bound.map_err(|error| judges.in_clock(place, &error))
        });
        let clocks = clocks.collect::<Result<Vec<_>, _>>()?;
        let at_work = judges.judges.iter().map(|judge| {
            let places = judge.propositions.iter();
            let read = places.flat_map(|place| predicates[*place].signals());
            let clock = judge
                .clock
                .iter()
                .flat_map(|place| clocks[*place].signals());
            AtWork::new(judge, read.chain(clock).collect(), losses)
        });
        let at_work = at_work.collect::<Result<_, _>>()?;
        let channels = predicates.iter().map(channels_of).collect();
        Ok(Self {
            channels,
            begun: false,
            at_work,
            lost: Lost::new(losses, layout),
            truth: vec![None; predicates.len()],
            robustness: vec![f64::NAN; predicates.len()],
            judges,
            predicates,
            clocks,
        })
    }

    /// Takes the next sample, at which signals have the given values. Each monitor is given the samples
    /// of the signals that it reads; those of one instant together.
    pub fn step_changed<V: SignalValues>(
        &mut self,
        time_secs: f64,
        values: &V,
        news: &News<'_>,
    ) -> Result<(), Problem> {
        let is_masked = self.lost.mask(time_secs, news);
        let masked = Masked {
            values,
            lost: is_masked.then_some(&self.lost.masked),
        };
        for place in 0..self.predicates.len() {
            let is_changed = |channel: &usize| news.changed.get(*channel).is_none_or(|it| *it);
            if !self.begun || is_masked || self.channels[place].iter().any(is_changed) {
                let judged = self.predicates[place].judge(&masked);
                self.truth[place] = judged.map(|(truth, _)| truth);
                self.robustness[place] = judged.map_or(f64::NAN, |(_, robustness)| robustness);
            }
        }
        self.begun = true;
        for (index, judge) in self.judges.judges.iter().enumerate() {
            let at_work = &mut self.at_work[index];
            let is_sample = at_work.reads.is_empty()
                || at_work.reads.iter().any(|signal| news.is_sampled(*signal));
            let clock = judge.clock.map(|clock| &self.clocks[clock]);
            let now_secs = match clock {
                None => Some(time_secs),
                Some(clock) => own_time(clock, values, at_work.last_secs),
            };
            // Before its clock shows a time, a monitor sees nothing.
            if let Some(now_secs) = now_secs.filter(|_| is_sample) {
                let lost = &self.lost.spans;
                at_work
                    .bring_across(lost, time_secs)
                    .map_err(bad_recording)?;
                let truth = judge.propositions.iter().map(|place| self.truth[*place]);
                let values_of = judge
                    .propositions
                    .iter()
                    .map(|place| self.robustness[*place]);
                at_work.hear(now_secs, (truth.collect(), values_of.collect()), &masked);
                at_work.seen(time_secs, news);
            }
            // On a clock of its own samples of one instant may have different times.
            if !news.more || clock.is_some() {
                at_work.flush().map_err(bad_recording)?;
            }
        }
        Ok(())
    }

    /// The verdict of each monitor that is determined already, `None` while
    /// it is open, with its subject and reading.
    pub fn determined(
        &self,
    ) -> impl Iterator<Item = (&'a evidence::Subject, Option<&'a str>, Option<Verdict>)> + '_ {
        let pairs = self.judges.judges.iter().zip(&self.at_work);
        pairs.map(|(judge, at_work)| (judge.subject, judge.reading, at_work.determined()))
    }

    /// Between which bounds the robustness of each formula still is, whatever
    /// comes; `None` for stages, and before the first instant.
    pub fn robustness_bounds(&self) -> impl Iterator<Item = Option<RobustnessBounds>> + '_ {
        self.at_work.iter().map(|at_work| match at_work.telling() {
            Work::Staged(..) => None,
            Work::Formula(formula) => formula.robustness_bounds(),
        })
    }

    /// Ends the trace; `complete` is false if it was cut short.
    pub fn finish(self, complete: bool) -> Vec<Judgement<'a>> {
        let judges = self.judges;
        let (spans, unlocated) = (self.lost.spans, self.lost.unlocated);
        let pairs = judges.judges.iter().zip(self.at_work);
        pairs
            .map(|(judge, mut at_work)| {
                // What was lost behind the last sample ends the trace for this monitor.
                let all_seen = !spans.iter().any(|span| span.1 >= at_work.seen_secs);
                if !all_seen {
                    at_work.lose_the_rest(&spans);
                }
                if unlocated {
                    at_work.forget_what_may_differ(judge);
                }
                conclude(judges, judge, at_work, complete && all_seen)
            })
            .collect()
    }

    /// Ends the trace as [`Session::finish`] does, where it is known that until
    /// `until_secs` nothing came: what is overdue by then is judged so.
    pub fn finish_at(
        self,
        complete: bool,
        until_secs: Option<f64>,
    ) -> Result<Vec<Judgement<'a>>, Problem> {
        let overdue = match until_secs {
            Some(secs) => self.overdue(secs)?,
            None => Vec::new(),
        };
        let mut judgements = self.finish(complete);
        for (judgement, overdue) in judgements.iter_mut().zip(overdue) {
            if let Some(overdue) = overdue {
                *judgement = overdue;
            }
        }
        Ok(judgements)
    }

    /// Nothing changes any more, for ever: no formula is short of what it has not seen.
    pub fn rests(&mut self) {
        self.at_work.iter_mut().for_each(AtWork::rests);
    }

    /// Ends a run that is known to have gone on until `end_secs`, though none of the signals that a monitor reads may have had
    /// a sample so late: a deadline of stages that had passed by then was missed, and a formula has seen the time until then.
    pub fn finish_run(mut self, complete: bool, end_secs: f64) -> Vec<Judgement<'a>> {
        if complete && self.lost.is_nothing() {
            for (judge, at_work) in self.judges.judges.iter().zip(&mut self.at_work) {
                if judge.clock.is_none() {
                    at_work.lasted_until(end_secs);
                }
            }
        }
        self.finish(complete)
    }

    /// For each monitor, what it says if it is open so far and determined by
    /// time alone, since nothing came until `time_secs`: whatever the values
    /// are then and later, the verdict is the same. Monitors with a clock of
    /// their own are left out, since that stands still.
    pub fn overdue(&self, time_secs: f64) -> Result<Vec<Option<Judgement<'a>>>, Problem> {
        let pairs = self.judges.judges.iter().zip(&self.at_work);
        let said = pairs.map(|(judge, at_work)| {
            let is_open = at_work.determined().is_none() && judge.clock.is_none();
            if !is_open || time_secs <= at_work.last_secs {
                return Ok(None);
            }
            let mut quiet = at_work.clone();
            quiet.silence(time_secs).map_err(bad_recording)?;
            let is_new = quiet.determined().is_some();
            Ok(is_new.then(|| conclude(self.judges, judge, quiet, false)))
        });
        said.collect()
    }

    /// What each monitor would say if the trace were cut short here. The
    /// monitors are copied, so this costs as much as they keep.
    pub fn so_far(&self) -> Vec<Judgement<'a>> {
        let pairs = self.judges.judges.iter().zip(&self.at_work);
        pairs
            .map(|(judge, at_work)| conclude(self.judges, judge, at_work.clone(), false))
            .collect()
    }
}

fn bad_recording(error: String) -> Problem {
    Problem::said("bad-recording", error)
}

/// What a monitor says; if it is open and was begun anew when all that it reads was there, what it says
/// from there on.
fn conclude<'a>(
    judges: &Judges<'a>,
    judge: &SubjectJudge<'a>,
    at_work: AtWork<'_>,
    complete: bool,
) -> Judgement<'a> {
    let (from_start, late) = at_work.parts();
    let found = findings(judges, judge, from_start, complete);
    let findings = match (found.verdict, late) {
        (Verdict::Inconclusive, Some((late, since_secs))) => JudgedTrace {
            judged_from_secs: Some(since_secs),
            ..findings(judges, judge, late, complete)
        },
        _ => found,
    };
    Judgement {
        subject: judge.subject,
        reading: judge.reading,
        findings,
    }
}

fn findings<'a>(
    judges: &Judges<'a>,
    judge: &SubjectJudge<'a>,
    work: Work<'_>,
    complete: bool,
) -> JudgedTrace {
    match work {
        Work::Staged(staged, robustness) => {
            let report = staged.finish(complete);
            let robustness = robustness.and_then(|it| it.finish(complete, &report));
            of_stages(judges, judge, report, robustness)
        }
        Work::Formula(formula) => of_formula(judges, judge, formula.finish(complete)),
    }
}

/// The time on a monitor's own clock, which never goes back and, where it
/// stands still, takes the least step. So of several instants exactly at a
/// deadline the first decides: what comes with the others is late.
pub(super) fn own_time<V: SignalValues>(
    clock: &BoundQuantity,
    values: &V,
    last_secs: f64,
) -> Option<f64> {
    let shown = clock.eval(values)?;
    let in_secs = match clock.unit() {
        Some(unit) if unit.dimension() == trace::units::Dimension::TIME => {
            unit.factor().conversion().apply(shown)
        }
        _ => shown,
    };
    // Of late times, such as those of the calendar, a nanosecond is no part.
    let next_secs = (last_secs + CLOCK_STEP_SECS).max(last_secs.next_up());
    Some(in_secs.max(next_secs))
}

/// The channels that a predicate reads, each once.
fn channels_of(predicate: &BoundPredicate) -> Vec<usize> {
    let signals = predicate.signals();
    let channels: std::collections::BTreeSet<usize> =
        signals.iter().map(|signal| signal.channel).collect();
    channels.into_iter().collect()
}

fn of_stages(
    judges: &Judges<'_>,
    judge: &SubjectJudge<'_>,
    report: MonitorReport,
    robustness: Option<StagedRobustness>,
) -> JudgedTrace {
    let violation = report.first_failure.map(|failure| Violation {
        from_secs: failure.triggered_at_secs,
        to_secs: failure.time_secs,
        responsible: vec![Responsible {
            signals: signals(judges, &failure.proposition),
            proposition: failure.proposition,
            value: false,
            from_secs: failure.false_from_secs,
            to_secs: failure.false_to_secs,
        }],
    });
    JudgedTrace {
        verdict: report.verdict,
        triggered: report.triggered,
        passed: report.passed,
        failed: report.failed,
        robustness: robustness.map(|found| Robustness {
            low: found.bounds.low,
            high: found.bounds.high,
            exact: found.exact,
        }),
        no_robustness: match &judge.rule {
            CompiledRule::Staged { robustness, .. } if report.triggered > 0 => {
                robustness.as_ref().err().copied()
            }
            _ => None,
        },
        decided_at_secs: violation.as_ref().map(|v| v.to_secs),
        judged_from_secs: None,
        ends_before: None,
        left_out: None,
        violation,
    }
}

fn of_formula(judges: &Judges<'_>, judge: &SubjectJudge<'_>, report: FormulaReport) -> JudgedTrace {
    let atoms = judge.rule.propositions();
    let violation = report.explanation.map(|explanation| Violation {
        from_secs: explanation.from_secs,
        to_secs: explanation.to_secs,
        responsible: explanation
            .atoms
            .iter()
            .map(|part| Responsible {
                proposition: atoms[part.atom.0].clone(),
                value: part.value,
                from_secs: part.from_secs,
                to_secs: part.to_secs,
                signals: signals(judges, &atoms[part.atom.0]),
            })
            .collect(),
    });
    JudgedTrace {
        verdict: report.verdict,
        triggered: report.triggered,
        passed: u64::from(report.verdict == Verdict::Satisfied),
        failed: u64::from(report.verdict == Verdict::Violated),
        robustness: report.robustness.map(|bounds| Robustness {
            low: bounds.low,
            high: bounds.high,
            exact: true,
        }),
        no_robustness: None,
        decided_at_secs: report.decided_at_secs,
        judged_from_secs: None,
        ends_before: report.ends_before,
        left_out: report.left_out,
        violation,
    }
}

fn signals(judges: &Judges<'_>, proposition: &str) -> Vec<String> {
    let predicate = judges.vocabulary.signals.predicate(proposition);
    predicate.map_or_else(|_| Vec::new(), |p| p.signals().into_iter().collect())
}
