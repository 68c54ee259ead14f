//! The monitor: a formula of metric temporal logic over the propositions, and its trigger.
//!
//! Durations in seconds become intervals in seconds, durations in steps intervals in samples. With
//! an [`Ending`] of a finite trace, the end of the trace is no end of the scope: what should have
//! happened and has not is open ([`Ending::Inconclusive`]) or failed ([`Ending::Finite`]), what
//! should hold to the end has held.

use std::fmt;

use temporal::formula::{Ending, Formula, Parsed, Settings, TimeModel, TimeUnit};

use super::build::Numbering;
use super::frame::Frame;
use super::{NotExpressible, check};
use crate::sentence::Sentence;

/// A sentence as a formula for traces.
#[derive(Clone, Debug, PartialEq)]
pub struct Monitor {
    /// The requirement, with its atoms: texts for the vocabulary to bind to signals.
    pub requirement: Parsed,
    /// Where an obligation arises. How often this becomes true is how often the requirement was
    /// covered; with `whenever`, that is the number of intervals in which it is triggered.
    pub trigger: Formula,
}

impl Monitor {
    /// How a trace is to be judged by it.
    #[must_use]
    pub fn settings(&self, time: TimeModel, ending: Ending) -> Settings {
        let base = match time {
            TimeModel::Discrete => Settings::discrete(ending),
            TimeModel::Dense => Settings::dense(ending),
        };
        Settings {
            trigger: Some(self.trigger.clone()),
            ..base
        }
    }

    /// Whether it speaks of steps, so that time has to be discrete.
    #[must_use]
    pub fn needs_discrete_time(&self) -> bool {
        speaks_of_samples(&self.requirement.formula)
    }

    /// The text of the trigger.
    #[must_use]
    pub fn trigger_text(&self) -> String {
        self.trigger.display(&self.requirement.atoms).to_string()
    }
}

/// The text of the formula, as [`temporal::formula::parse`] reads it.
impl fmt::Display for Monitor {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.requirement.fmt(out)
    }
}

fn speaks_of_samples(formula: &Formula) -> bool {
    let counts = formula.interval().is_some_and(|interval| {
        [Some(interval.low), interval.high]
            .iter()
            .flatten()
            .any(|bound| bound.unit == TimeUnit::Samples)
    });
    counts
        || matches!(formula, Formula::Next(_) | Formula::Previous(_))
        || formula.operands().into_iter().any(speaks_of_samples)
}

/// The monitor of a sentence.
///
/// ```
/// use requirement_lang::{Context, compile::monitor::monitor, parse};
/// let text = "When grasped, the robot shall within 2 s satisfy /gripper.force > 5 N.";
/// let sentence = parse(text, &Context::default()).into_result().unwrap();
/// let monitor = monitor(&sentence)?;
/// assert_eq!(
///     monitor.to_string(),
///     "always ((rise grasped) => (eventually[0 s, 2 s] /gripper.force > 5 N))"
/// );
/// assert_eq!(monitor.trigger_text(), "rise grasped");
/// # Ok::<(), requirement_lang::compile::NotExpressible>(())
/// ```
///
/// # Errors
/// [`NotExpressible`] if the sentence has no meaning.
pub fn monitor(sentence: &Sentence) -> Result<Monitor, NotExpressible> {
    check(sentence)?;
    let mut numbering = Numbering::default();
    let frame = Frame::new(sentence, &mut numbering);
    Ok(Monitor {
        requirement: Parsed {
            formula: frame.with_past(),
            atoms: numbering.atoms,
        },
        trigger: frame.trigger(),
    })
}
