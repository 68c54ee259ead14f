//! Staged monitors as formulas, for what only formulas have: robustness, explanations, dense time.
//!
//! # Translation
//! What an instance demands from the sample where it begins, with `rest` for the stages after:
//!
//! * `assert p`: p and rest;
//! * `wait_for p within d`: (not p) until[0, d] (p and rest), and eventually[0, d] p as the last stage;
//! * `hold p until q within d`: (p and not q) until[0, d] (q and rest), and p until[0, d] q as the
//!   last stage.
//!
//! A stage ends at the *first* sample that ends it, hence the negations. The trigger t is `rise(when)`,
//! or `when` for each sample. Every trigger: always (t => demand). Once: (not t) weak_until (t and
//! demand).
//!
//! # Guarantee
//! Where all propositions are known, and no trigger falls within an instance under way
//! ([`MonitorReport::overlapping`](super::MonitorReport::overlapping) is 0; otherwise the formula
//! makes demands for those, too), the formula is violated exactly where the monitor is, given the
//! ending: `fail_pending` is [`Ending::Finite`]. With `inconclusive_pending`, the monitor is violated
//! where the formula is with [`Ending::Inconclusive`], satisfied or not covered where it is
//! with [`Ending::Finite`], and otherwise inconclusive. With unknown propositions, neither calls
//! satisfied what the other calls violated.
//!
//! # Robustness
//! By the translation, the robustness of an instance is the least over its stages: of an assertion,
//! that of p where it is judged; of a last `wait_for`, the greatest of p in time; of a hold, the
//! least of p so far or the greatest of q, as for until. For a stage before others it also says how
//! far its end is from coming at another sample: it is a bound on what may change with no effect on
//! the verdict, not always the largest. That of the monitor is the least over its instances.
//! [`RobustnessMonitor`](super::RobustnessMonitor) computes it without the formula.

use super::spec::{AtEnd, MonitorSpec, Repeat, SpecError, Stage, Trigger};
use crate::formula::{AtomText, Ending, Formula, Interval};

/// A staged monitor as a formula.
#[derive(Debug, Clone, PartialEq)]
pub struct StagedFormula {
    /// The formula; atom i is the proposition i of the monitor.
    pub formula: Formula,
    /// What begins an instance.
    pub trigger: Formula,
    /// The propositions.
    pub propositions: Vec<String>,
    /// The ending under which it is violated where the monitor is.
    pub ending: Ending,
    /// Whether it judges as the monitor does even where triggers overlap: only one instance
    /// counts, or each is over at the sample where it begins.
    pub exact: bool,
}

impl MonitorSpec {
    /// The monitor as a formula in discrete time.
    ///
    /// ```
    /// use temporal::monitor::{MonitorSpec, Stage};
    /// let spec = MonitorSpec::new("grasped", vec![
    ///     Stage::Hold { proposition: "in_hand".into(), until: "sensed".into(), within_secs: None },
    ///     Stage::WaitFor { proposition: "released".into(), within_secs: Some(5.0) },
    /// ]);
    /// let staged = spec.to_formula()?;
    /// assert_eq!(staged.to_string(), "always ((rise grasped) => ((in_hand and (not sensed)) \
    ///     until (sensed and (eventually[0 s, 5 s] released))))");
    /// # Ok::<(), temporal::monitor::SpecError>(())
    /// ```
    ///
    /// # Errors
    /// [`SpecError`] as from [`Monitor::compile`](super::Monitor::compile).
    pub fn to_formula(&self) -> Result<StagedFormula, SpecError> {
        let monitor = super::Monitor::compile(self)?;
        let propositions = monitor.propositions().to_vec();
        let atom = |name: &str| {
            Formula::atom(
                propositions
                    .iter()
                    .position(|other| other == name)
                    .unwrap_or(0),
            )
        };
        let when = atom(&self.when);
        let trigger = match self.trigger {
            Trigger::BecomesTrue => Formula::rise(when),
            Trigger::EachSample => when,
        };
        let demand = demand(&self.then, &atom);
        let formula = match self.repeat {
            Repeat::EveryTrigger => Formula::always(
                Interval::UNBOUNDED,
                Formula::implies(trigger.clone(), demand),
            ),
            Repeat::Once => Formula::WeakUntil(
                Interval::UNBOUNDED,
                Box::new(Formula::not(trigger.clone())),
                Box::new(Formula::and(trigger.clone(), demand)),
            ),
        };
        let immediate = self
            .then
            .iter()
            .all(|stage| matches!(stage, Stage::Assert { .. }));
        Ok(StagedFormula {
            formula,
            trigger,
            propositions,
            ending: match self.at_end {
                AtEnd::FailPending => Ending::Finite,
                AtEnd::InconclusivePending => Ending::Inconclusive,
            },
            exact: immediate || self.repeat == Repeat::Once,
        })
    }
}

/// What an instance demands from here on.
fn demand(stages: &[Stage], atom: &dyn Fn(&str) -> Formula) -> Formula {
    let Some((stage, rest)) = stages.split_first() else {
        return Formula::True;
    };
    let is_last = rest.is_empty();
    let and_rest = |end: Formula| {
        if is_last {
            end
        } else {
            Formula::and(end, demand(rest, atom))
        }
    };
    match stage {
        Stage::Assert { proposition } => and_rest(atom(proposition)),
        Stage::WaitFor {
            proposition,
            within_secs,
        } => {
            let window = within(*within_secs);
            let end = atom(proposition);
            if is_last {
                return Formula::eventually(window, end);
            }
            Formula::until(window, Formula::not(end.clone()), and_rest(end))
        }
        Stage::Hold {
            proposition,
            until,
            within_secs,
        } => {
            let window = within(*within_secs);
            let (held, end) = (atom(proposition), atom(until));
            if is_last {
                return Formula::until(window, held, end);
            }
            let on = Formula::and(held, Formula::not(end.clone()));
            Formula::until(window, on, and_rest(end))
        }
    }
}

fn within(secs: Option<f64>) -> Interval {
    secs.map_or(Interval::UNBOUNDED, |secs| Interval::secs(0.0, secs))
}

impl std::fmt::Display for StagedFormula {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let text = |name: &String| AtomText {
            text: name.clone(),
            span: 0..name.len(),
        };
        let atoms: Vec<AtomText> = self.propositions.iter().map(text).collect();
        self.formula.display(&atoms).fmt(out)
    }
}
