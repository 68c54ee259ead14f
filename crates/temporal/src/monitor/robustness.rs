//! The robustness of a staged monitor, in one pass and in memory that its deadlines bound.
//!
//! # Definition
//! That of the monitor's formula ([`super::StagedFormula`]), as a recursion over its stages. Let
//! v(p, i) be the robustness of p at sample i. What stages k, k + 1, ... demand from i on is
//!
//! ```text
//! D_k(i) = max over j >= i within the deadline of
//!          min(end_k(j), D_{k+1}(j), min of on_k(l) for i <= l < j),
//! ```
//!
//! and plus infinity behind the last stage. `assert p`: end = v(p), and only j = i. `wait_for p`: end =
//! v(p), on = -v(p). `hold p until q`: end = v(q), on = min(v(p), -v(q)). For a last stage that it be
//! left at the *first* occasion says nothing: on is plus infinity and v(p). With the
//! trigger t(i), which is min(v(when, i), -v(when, i - 1)) or, for each sample, v(when, i):
//!
//! * every trigger: the minimum over i of max(-t(i), D_1(i));
//! * once: one more stage in front, with on = -t, end = t, whose end need not come.
//!
//! # Algorithm
//! Stages are computed from the last to the first. One with a deadline is a fold over a sliding window
//! (`stage`). D of one without is known at the end only, but D_k(i) = max(min(end_k(i), D_{k+1}(i)),
//! min(on_k(i), D_k(i + 1))): a *row* over a variable, its own value at the next sample (`row`). So
//! everything is a function of what the unbounded stages are from now on: rows for one
//! instance, which windows fold as matrices, and a lattice polynomial for the minimum over
//! all instances (`whole`). A trace that ends gives the variables their last values.
//!
//! Where propositions are unknown, the least and the greatest robustness are computed apart, as the
//! formula is monotone in its literals.
//!
//! # Cost and guarantee
//! For m stages, v of them unbounded: amortised O(m v^2 + v^2 2^v) for each sample; memory: the
//! samples within the sum of the deadlines, v^2 numbers each (v rounded up to 1, 2, 4 or 8), and 2^v
//! numbers, however long the trace.
//! v is limited to [`MAX_UNBOUNDED_STAGES`]. Only minima, maxima and changes of sign are taken, so there are no
//! rounding errors: the result is that of the formula's engine, bit for bit (tested on random
//! traces).

mod row;
mod stage;
mod whole;

use super::StepError;
use std::collections::VecDeque;

use super::machine::{Monitor, PropId, Step};
use super::report::{MonitorReport, Verdict};
use super::spec::{AtEnd, Repeat, Trigger};
use crate::formula::RobustnessBounds;
use row::{Carry, MAX_VARIABLES, Row};
use stage::{Given, Here, Lasting, StageWork, Window};
use whole::Whole;

/// The most stages without a deadline (counting the trigger of a monitor that judges only the first)
/// for which there is robustness.
pub const MAX_UNBOUNDED_STAGES: usize = MAX_VARIABLES;

/// The robustness of a staged monitor, ready to be computed on traces.
#[derive(Debug, Clone)]
pub struct RobustnessMonitor {
    start: RobustnessJudge,
}

/// The robustness of a staged monitor on one trace.
///
/// ```
/// use temporal::monitor::{Monitor, MonitorSpec, Stage};
/// let spec = MonitorSpec::new("near", vec![
///     Stage::WaitFor { proposition: "slow".into(), within_secs: Some(1.0) },
/// ]);
/// let monitor = Monitor::compile(&spec)?;
/// let (mut judge, mut robustness) = (monitor.start(), monitor.robustness()?.start());
/// // By how much: near in metres, slow in metres per second.
/// for (time_secs, values) in [(0.0, [-0.5, -0.25]), (0.5, [0.5, -0.25]), (1.5, [0.5, -0.125])] {
///     judge.step(time_secs, &|proposition| Some(values[proposition] > 0.0))?;
///     robustness.step(time_secs, &|proposition| values[proposition])?;
/// }
/// let found = robustness.finish(true, &judge.finish(true));
/// assert_eq!(found.and_then(|it| it.bounds.value()), Some(-0.125));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct RobustnessJudge {
    rule: Rule,
    last_secs: f64,
    lanes: SizedLanes,
}

/// What the robustness of a staged monitor can be, given what is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StagedRobustness {
    /// Its bounds.
    pub bounds: RobustnessBounds,
    /// Whether the demands of exactly those instances are in it that the monitor judged. If
    /// not, triggers fell within an instance under way; the formula makes demands for those, too, so
    /// its robustness is only a lower bound.
    pub exact: bool,
}

/// What is to be computed.
#[derive(Debug, Clone)]
struct Rule {
    when: PropId,
    trigger: Trigger,
    repeat: Repeat,
    at_end: AtEnd,
    /// The stages, the first one first.
    stages: Vec<Step>,
    /// What trigger and stages read, each once.
    propositions: Vec<PropId>,
}

/// More stages without a deadline than robustness can be computed for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooManyUnbounded {
    /// How many there are.
    pub count: usize,
}

impl std::fmt::Display for TooManyUnbounded {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            out,
            "robustness is computed for up to {MAX_UNBOUNDED_STAGES} stages without a deadline, and \
             this monitor has {}; give some of them `within_secs`",
            self.count
        )
    }
}

impl std::error::Error for TooManyUnbounded {}

/// Both lanes with room for as many variables as there are, or a few more: most monitors have one or
/// two, whose rows stay in registers.
#[derive(Debug, Clone)]
enum SizedLanes {
    One(Lanes<1>),
    Two(Lanes<2>),
    Four(Lanes<4>),
    All(Lanes<MAX_VARIABLES>),
}

/// The same for lanes of any size.
macro_rules! of_lanes {
    ($lanes_of_size:expr, $lanes:ident => $value:expr) => {
        match $lanes_of_size {
            SizedLanes::One($lanes) => $value,
            SizedLanes::Two($lanes) => $value,
            SizedLanes::Four($lanes) => $value,
            SizedLanes::All($lanes) => $value,
        }
    };
}

/// The computation for both ends of the bounds.
#[derive(Debug, Clone)]
struct Lanes<const N: usize> {
    low: Lane<N>,
    /// None as long as it would be the same as `low`.
    high: Option<Lane<N>>,
}

/// The computation for one end of the bounds.
#[derive(Debug, Clone)]
struct Lane<const N: usize> {
    /// What unknown literals are taken for.
    unknown: f64,
    when_before: Option<f64>,
    /// The stages, the last one first; behind them, for monitors that judge one trigger, the trigger.
    stages: Vec<StageWork<N>>,
    /// For samples whose demand is not known yet, by how much nothing triggers.
    unless: VecDeque<f64>,
    whole: Whole,
    /// What stages give, kept to avoid allocations.
    given: Vec<Given<N>>,
    taken: Vec<Given<N>>,
}

impl Monitor {
    /// The robustness of this monitor.
    ///
    /// # Errors
    /// [`TooManyUnbounded`] if there are more than [`MAX_UNBOUNDED_STAGES`] stages without a deadline.
    pub fn robustness(&self) -> Result<RobustnessMonitor, TooManyUnbounded> {
        let (when, trigger, repeat, at_end, stages) = self.parts();
        let rule = Rule {
            when,
            trigger,
            repeat,
            at_end,
            stages: stages.to_vec(),
            propositions: propositions_of(when, stages),
        };
        let count = rule.unbounded();
        if count > MAX_UNBOUNDED_STAGES {
            return Err(TooManyUnbounded { count });
        }
        let start = RobustnessJudge {
            lanes: SizedLanes::new(&rule, count),
            last_secs: f64::NEG_INFINITY,
            rule,
        };
        Ok(RobustnessMonitor { start })
    }
}

impl RobustnessMonitor {
    /// Begins with a trace.
    #[must_use]
    pub fn start(&self) -> RobustnessJudge {
        self.start.clone()
    }
}

impl RobustnessJudge {
    /// Takes the next sample: its time in seconds, and the robustness of each proposition, which is
    /// not a number where it is unknown, and infinite where it is only true or false.
    ///
    /// # Errors
    /// [`StepError`] if the time is not finite or not after the last one; the sample is not
    /// taken then.
    pub fn step(&mut self, time_secs: f64, value: &dyn Fn(PropId) -> f64) -> Result<(), StepError> {
        if !time_secs.is_finite() || time_secs <= self.last_secs {
            return Err(StepError {
                last_secs: self.last_secs,
                time_secs,
            });
        }
        self.last_secs = time_secs;
        of_lanes!(&mut self.lanes, lanes => lanes.step(&self.rule, time_secs, value));
        Ok(())
    }

    /// How many samples and numbers are kept.
    #[must_use]
    pub fn stored(&self) -> usize {
        of_lanes!(&self.lanes, lanes => lanes.stored())
    }

    /// Ends the trace, on which the monitor itself gave `report`. `complete` is false if it was cut
    /// short: then anything may have come after. `None` if there was no sample.
    #[must_use]
    pub fn finish(self, complete: bool, report: &MonitorReport) -> Option<StagedRobustness> {
        if self.last_secs == f64::NEG_INFINITY {
            return None;
        }
        let once = self.rule.repeat == Repeat::Once;
        let exact = report.overlapping == 0 || once || self.rule.is_immediate();
        let bounds = self.bounds_at_end(complete);
        let widened = RobustnessBounds {
            low: match report.verdict {
                Verdict::Satisfied => bounds.low.max(0.0),
                _ => bounds.low,
            },
            high: match report.verdict {
                Verdict::Violated => 0.0,
                _ => f64::INFINITY,
            },
        };
        Some(StagedRobustness {
            bounds: if exact { bounds } else { widened },
            exact,
        })
    }

    /// The bounds of the formula's robustness.
    fn bounds_at_end(self, complete: bool) -> RobustnessBounds {
        let (worst, best) = (f64::NEG_INFINITY, f64::INFINITY);
        // In a complete trace no more triggers come.
        let no_more = if complete { best } else { worst };
        let fails = complete && self.rule.at_end == AtEnd::FailPending;
        let after = if fails { worst } else { best };
        let (low, high) = of_lanes!(self.lanes, lanes => {
            let high = lanes.high.unwrap_or_else(|| lanes.low.optimist());
            let low = lanes.low.close(&self.rule, worst, no_more);
            (low, high.close(&self.rule, after, best))
        });
        // Adding 0 makes a negative zero positive.
        RobustnessBounds {
            low: low + 0.0,
            high: high + 0.0,
        }
    }
}

impl SizedLanes {
    fn new(rule: &Rule, count: usize) -> Self {
        match count {
            0..=1 => SizedLanes::One(Lanes::new(rule, count)),
            2 => SizedLanes::Two(Lanes::new(rule, count)),
            3..=4 => SizedLanes::Four(Lanes::new(rule, count)),
            _ => SizedLanes::All(Lanes::new(rule, count)),
        }
    }
}

impl<const N: usize> Lanes<N> {
    fn new(rule: &Rule, count: usize) -> Self {
        Lanes {
            low: Lane::new(rule, count),
            high: None,
        }
    }

    fn step(&mut self, rule: &Rule, time_secs: f64, value: &dyn Fn(PropId) -> f64) {
        if self.high.is_none() && rule.propositions.iter().any(|p| value(*p).is_nan()) {
            self.high = Some(self.low.optimist());
        }
        self.low.step(rule, time_secs, value);
        if let Some(high) = &mut self.high {
            high.step(rule, time_secs, value);
        }
    }

    fn stored(&self) -> usize {
        self.low.stored() + self.high.as_ref().map_or(0, Lane::stored)
    }
}

impl Rule {
    fn unbounded(&self) -> usize {
        let endless = |step: &&Step| step.within_secs() == f64::INFINITY;
        self.stages.iter().filter(endless).count() + usize::from(self.repeat == Repeat::Once)
    }

    /// Whether each instance is over at the sample where it begins.
    fn is_immediate(&self) -> bool {
        self.stages
            .iter()
            .all(|step| matches!(step, Step::Assert(_)))
    }
}

/// What a trigger and stages read, each once.
fn propositions_of(when: PropId, stages: &[Step]) -> Vec<PropId> {
    let of_stages = stages.iter().flat_map(|step| match *step {
        Step::Assert(proposition) | Step::WaitFor { proposition, .. } => [proposition, proposition],
        Step::Hold {
            proposition, until, ..
        } => [proposition, until],
    });
    let mut all: Vec<PropId> = std::iter::once(when).chain(of_stages).collect();
    all.sort_unstable();
    all.dedup();
    all
}

impl<const N: usize> Lane<N> {
    fn new(rule: &Rule, count: usize) -> Self {
        let once = rule.repeat == Repeat::Once;
        let mut variables = usize::from(once)..count;
        let lasting = |step: &Step| match *step {
            Step::Assert(_) => Lasting::OneInstant,
            _ if step.within_secs() == f64::INFINITY => Lasting::Unbounded {
                variable: variables.next().unwrap_or(0),
            },
            _ => Lasting::Within(Box::new(Window::new(step.within_secs()))),
        };
        let mut stages: Vec<Lasting<N>> = rule.stages.iter().rev().map(lasting).collect();
        if once {
            stages.push(Lasting::Unbounded { variable: 0 });
        }
        Lane {
            unknown: f64::NEG_INFINITY,
            when_before: None,
            stages: stages.into_iter().map(StageWork::new).collect(),
            unless: VecDeque::new(),
            whole: if once {
                Whole::first_variable(count)
            } else {
                Whole::satisfied(count)
            },
            given: Vec::new(),
            taken: Vec::new(),
        }
    }

    fn optimist(&self) -> Self {
        Lane {
            unknown: f64::INFINITY,
            ..self.clone()
        }
    }

    fn stored(&self) -> usize {
        let of_stages: usize = self.stages.iter().map(StageWork::stored).sum();
        of_stages + self.unless.len() + self.whole.stored()
    }

    fn step(&mut self, rule: &Rule, time_secs: f64, value: &dyn Fn(PropId) -> f64) {
        let unknown = self.unknown;
        let known = |value: f64| if value.is_nan() { unknown } else { value };
        let (yes, no) = (|p| known(value(p)), |p| known(-value(p)));
        let when_before = self.when_before.replace(value(rule.when));
        let (mut triggers, mut unless) = (yes(rule.when), no(rule.when));
        if let (Trigger::BecomesTrue, Some(before)) = (rule.trigger, when_before) {
            triggers = triggers.min(known(-before));
            unless = unless.max(known(before));
        }
        let last = rule.stages.len() - 1;
        for (place, work) in self.stages.iter_mut().enumerate() {
            let (on, end) = match rule.stages.get(last.wrapping_sub(place)) {
                None => (unless, triggers),
                Some(step) => on_and_end(*step, place == 0, yes, no),
            };
            work.see(Here { time_secs, on, end });
        }
        // Of one trigger the stage in front of all speaks.
        let once = rule.repeat == Repeat::Once;
        self.unless
            .push_back(if once { f64::INFINITY } else { unless });
        self.given.clear();
        self.given.push(Given {
            row: Row::constant(f64::INFINITY),
            carry: Carry::default(),
        });
        self.pass(None);
    }

    /// Passes what is given from the last stage to the first; with `after`, these end.
    fn pass(&mut self, after: Option<f64>) {
        for work in &mut self.stages {
            self.taken.clear();
            work.take(&self.given, &mut self.taken);
            if let Some(after) = after {
                work.close(after, &mut self.taken);
            }
            std::mem::swap(&mut self.given, &mut self.taken);
        }
        for given in &self.given {
            let unless = self.unless.pop_front().unwrap_or(f64::INFINITY);
            self.whole.demand(unless, given);
        }
    }

    /// The robustness, if stages that could go on at the end have the value `after`, and the trace
    /// itself, as to triggers, `no_more`: both plus or minus infinity.
    fn close(mut self, rule: &Rule, after: f64, no_more: f64) -> f64 {
        self.given.clear();
        self.pass(Some(after));
        let once = rule.repeat == Repeat::Once;
        let all = (1_usize << rule.unbounded()) - 1;
        let mut corner = if after > 0.0 { all } else { 0 };
        if once {
            corner = corner & !1 | usize::from(no_more > 0.0);
            return self.whole.corner(corner);
        }
        self.whole.corner(corner).min(no_more)
    }
}

/// By how much a stage may go on and end, by what its propositions and their negations are.
fn on_and_end(
    step: Step,
    is_last: bool,
    yes: impl Fn(PropId) -> f64,
    no: impl Fn(PropId) -> f64,
) -> (f64, f64) {
    // A stage before others is left at the first occasion.
    let not_yet = |end: PropId| if is_last { f64::INFINITY } else { no(end) };
    match step {
        Step::Assert(proposition) => (f64::NEG_INFINITY, yes(proposition)),
        Step::WaitFor { proposition, .. } => (not_yet(proposition), yes(proposition)),
        Step::Hold {
            proposition, until, ..
        } => (yes(proposition).min(not_yet(until)), yes(until)),
    }
}
