//! One pass over one trace: every monitor is given each instant once.
//!
//! Memory is bounded by the monitors (their windows), not by the trace.

use super::{
    CompiledRule, JudgedTrace, Judgement, Judges, Responsible, Robustness, SubjectJudge, Violation,
};
use crate::problem::Problem;
use temporal::formula::{FormulaJudge, FormulaReport, RobustnessBounds};
use temporal::monitor::{Judge, MonitorReport, RobustnessJudge, StagedRobustness, Verdict};
use trace::{BoundPredicate, BoundQuantity, SignalValues, Trace};

/// The least step of a clock that stands still, in seconds: the resolution of
/// recorded times.
const CLOCK_STEP_SECS: f64 = 1e-9;

/// Judging one trace.
pub struct Session<'s, 'a> {
    judges: &'s Judges<'a>,
    predicates: Vec<BoundPredicate>,
    /// For each predicate, the channels that it reads.
    channels: Vec<Vec<usize>>,
    /// Whether an instant has been taken.
    begun: bool,
    clocks: Vec<BoundQuantity>,
    at_work: Vec<AtWork<'s>>,
    /// Truth of each predicate at this instant.
    truth: Vec<Option<bool>>,
    /// Robustness of each predicate at this instant; NaN if unknown.
    robustness: Vec<f64>,
    /// Scratch space for one formula's atoms.
    atom_truth: Vec<Option<bool>>,
    atom_robustness: Vec<f64>,
}

/// One monitor at work.
#[derive(Clone)]
struct AtWork<'s> {
    judge: Work<'s>,
    /// The last time on its own clock.
    last_secs: f64,
}

#[derive(Clone)]
enum Work<'s> {
    Staged(Judge<'s>, Option<Box<RobustnessJudge>>),
    Formula(FormulaJudge),
}

impl<'s, 'a> Session<'s, 'a> {
    pub(super) fn new(judges: &'s Judges<'a>, layout: &Trace) -> Result<Self, Problem> {
        let problem = |error: trace::PredicateError| judges.vocabulary.predicate_problem(&error);
        let predicates = judges.predicates.iter().map(|p| p.bind(layout));
        let predicates = predicates.collect::<Result<Vec<_>, _>>().map_err(problem)?;
        let clocks = judges.clocks.iter().map(|c| c.bind(layout));
        let clocks = clocks.collect::<Result<Vec<_>, _>>().map_err(problem)?;
        let at_work = judges.judges.iter().map(|judge| AtWork {
            judge: match &judge.rule {
                CompiledRule::Staged {
                    monitor,
                    robustness,
                } => Work::Staged(
                    monitor.start(),
                    robustness.as_ref().ok().map(|it| Box::new(it.start())),
                ),
                CompiledRule::Formula { monitor, .. } => Work::Formula(monitor.start()),
            },
            last_secs: f64::NEG_INFINITY,
        });
        let channels = predicates.iter().map(channels_of).collect();
        Ok(Self {
            channels,
            begun: false,
            at_work: at_work.collect(),
            truth: vec![None; predicates.len()],
            robustness: vec![f64::NAN; predicates.len()],
            atom_truth: Vec::new(),
            atom_robustness: Vec::new(),
            judges,
            predicates,
            clocks,
        })
    }

    /// Takes the next instant, at which signals have the given values.
    pub fn step<V: SignalValues>(&mut self, time_secs: f64, values: &V) -> Result<(), Problem> {
        for place in 0..self.predicates.len() {
            self.evaluate(place, values);
        }
        self.take(time_secs, values)
    }

    /// As [`Session::step`], where only channels for which `changed` holds
    /// have other values than at the instant before: a predicate over others
    /// is what it was. The monitors see every instant, since some count them.
    pub fn step_changed<V: SignalValues>(
        &mut self,
        time_secs: f64,
        values: &V,
        changed: &[bool],
    ) -> Result<(), Problem> {
        for place in 0..self.predicates.len() {
            let is_changed = |channel: &usize| changed.get(*channel).is_none_or(|it| *it);
            if !self.begun || self.channels[place].iter().any(is_changed) {
                self.evaluate(place, values);
            }
        }
        self.take(time_secs, values)
    }

    fn evaluate<V: SignalValues>(&mut self, place: usize, values: &V) {
        let judged = self.predicates[place].judge(values);
        self.truth[place] = judged.map(|(truth, _)| truth);
        self.robustness[place] = judged.map_or(f64::NAN, |(_, robustness)| robustness);
    }

    /// Gives the monitors the truth that the predicates have now.
    fn take<V: SignalValues>(&mut self, time_secs: f64, values: &V) -> Result<(), Problem> {
        self.begun = true;
        let judges = self.judges;
        for (index, judge) in judges.judges.iter().enumerate() {
            let now_secs = match judge.clock {
                None => Some(time_secs),
                Some(clock) => own_time(&self.clocks[clock], values, self.at_work[index].last_secs),
            };
            // Before its clock shows a time, a monitor sees nothing.
            if let Some(now_secs) = now_secs {
                self.advance(index, judge, now_secs)
                    .map_err(|error| Problem::new("bad-recording", error))?;
            }
        }
        Ok(())
    }

    fn advance(
        &mut self,
        index: usize,
        judge: &SubjectJudge<'_>,
        now_secs: f64,
    ) -> Result<(), String> {
        let at_work = &mut self.at_work[index];
        at_work.last_secs = now_secs;
        match &mut at_work.judge {
            Work::Staged(staged, robustness) => {
                let (truth, values) = (&self.truth, &self.robustness);
                if let Some(robustness) = robustness {
                    robustness
                        .step(now_secs, &|p| values[judge.propositions[p]])
                        .map_err(|error| error.to_string())?;
                }
                staged
                    .step(now_secs, &|p| truth[judge.propositions[p]])
                    .map_err(|error| error.to_string())
            }
            Work::Formula(formula) => {
                self.atom_truth.clear();
                self.atom_robustness.clear();
                for place in &judge.propositions {
                    self.atom_truth.push(self.truth[*place]);
                    self.atom_robustness.push(self.robustness[*place]);
                }
                formula
                    .step_both(now_secs, &self.atom_truth, &self.atom_robustness)
                    .map(drop)
                    .map_err(|error| error.to_string())
            }
        }
    }

    /// The verdict of each monitor that is determined already, `None` while
    /// it is open, with its subject and reading.
    pub fn determined(
        &self,
    ) -> impl Iterator<Item = (&'a evidence::Subject, Option<&'a str>, Option<Verdict>)> + '_ {
        let pairs = self.judges.judges.iter().zip(&self.at_work);
        pairs.map(|(judge, at_work)| {
            let verdict = match &at_work.judge {
                Work::Staged(staged, _) => (staged.failed() > 0).then_some(Verdict::Violated),
                Work::Formula(formula) => formula.verdict(),
            };
            (judge.subject, judge.reading, verdict)
        })
    }

    /// Between which bounds the robustness of each formula still is, whatever
    /// comes; `None` for stages, and before the first instant.
    pub fn robustness_bounds(&self) -> impl Iterator<Item = Option<RobustnessBounds>> + '_ {
        self.at_work.iter().map(|at_work| match &at_work.judge {
            Work::Staged(..) => None,
            Work::Formula(formula) => formula.robustness_bounds(),
        })
    }

    /// Ends the trace; `complete` is false if it was cut short.
    pub fn finish(self, complete: bool) -> Vec<Judgement<'a>> {
        let judges = self.judges;
        let pairs = judges.judges.iter().zip(self.at_work);
        pairs
            .map(|(judge, at_work)| conclude(judges, judge, at_work.judge, complete))
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

    /// For each monitor, what it says if it is open so far and determined by
    /// time alone, since nothing came until `time_secs`: whatever the values
    /// are then and later, the verdict is the same. Monitors with a clock of
    /// their own are left out, since that stands still.
    pub fn overdue(&self, time_secs: f64) -> Result<Vec<Option<Judgement<'a>>>, Problem> {
        let quiet = self.after_silence(time_secs)?;
        let pairs = self.determined().zip(quiet.determined());
        let newly: Vec<bool> = pairs
            .map(|((.., before), (.., after))| before.is_none() && after.is_some())
            .collect();
        if !newly.contains(&true) {
            return Ok(newly.iter().map(|_| None).collect());
        }
        let said = quiet.so_far().into_iter().zip(newly);
        Ok(said.map(|(it, newly)| newly.then_some(it)).collect())
    }

    /// The monitors, copied, after an instant at `time_secs` of which nothing
    /// is known.
    fn after_silence(&self, time_secs: f64) -> Result<Self, Problem> {
        let mut quiet = Session {
            judges: self.judges,
            predicates: Vec::new(),
            channels: Vec::new(),
            begun: self.begun,
            clocks: Vec::new(),
            at_work: self.at_work.clone(),
            truth: vec![None; self.truth.len()],
            robustness: vec![f64::NAN; self.robustness.len()],
            atom_truth: Vec::new(),
            atom_robustness: Vec::new(),
        };
        for (index, judge) in self.judges.judges.iter().enumerate() {
            if judge.clock.is_none() && time_secs > quiet.at_work[index].last_secs {
                quiet
                    .advance(index, judge, time_secs)
                    .map_err(|error| Problem::new("bad-recording", error))?;
            }
        }
        Ok(quiet)
    }

    /// What each monitor would say if the trace were cut short here. The
    /// monitors are copied, so this costs as much as they keep.
    pub fn so_far(&self) -> Vec<Judgement<'a>> {
        let pairs = self.judges.judges.iter().zip(&self.at_work);
        pairs
            .map(|(judge, at_work)| conclude(self.judges, judge, at_work.judge.clone(), false))
            .collect()
    }
}

fn conclude<'a>(
    judges: &Judges<'a>,
    judge: &SubjectJudge<'a>,
    work: Work<'_>,
    complete: bool,
) -> Judgement<'a> {
    Judgement {
        subject: judge.subject,
        reading: judge.reading,
        findings: match work {
            Work::Staged(staged, robustness) => {
                let report = staged.finish(complete);
                let robustness = robustness.and_then(|it| it.finish(complete, &report));
                of_stages(judges, judge, report, robustness)
            }
            Work::Formula(formula) => of_formula(judges, judge, formula.finish(complete)),
        },
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
        violation,
    }
}

fn signals(judges: &Judges<'_>, proposition: &str) -> Vec<String> {
    let predicate = judges.vocabulary.signals.predicate(proposition);
    predicate.map_or_else(|_| Vec::new(), |p| p.signals().into_iter().collect())
}
