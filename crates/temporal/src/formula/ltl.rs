//! From the model checker's LTL to formulas that judge traces, so that one property judges both.
//!
//! A step of the model is a sample of the trace ([`Steps::Samples`]), or lasts a stated time
//! ([`Steps::Secs`]), where the trace may have more or fewer samples than the model has steps. Step
//! bounds become intervals in samples or seconds; `F<=20` with steps of 0.1 s is `eventually[0 s, 2
//! s]`. The truth on an infinite word is kept, and what is said of a finite one is the
//! [`Ending`](super::Ending)'s. `a W_B b` with a lower bound above 0 is the model checker's
//! `!((a & !b) U_B (!a & !b))`, which also holds where both are false before the window begins.
//!
//! ```
//! use temporal::formula::ltl::{Steps, from_ltl};
//! use temporal::ltl::{Ltl, StepBound};
//! let property = Ltl::globally(Ltl::implies(
//!     Ltl::Ap(0),
//!     Ltl::finally(Ltl::Ap(1)).within(StepBound::at_most(20)),
//! ));
//! let formula = from_ltl(&property, Steps::Secs(0.1))?;
//! assert_eq!(formula.to_string(), "always (p0 => (eventually[0 s, 2 s] p1))");
//! # Ok::<(), temporal::formula::ltl::StepError>(())
//! ```

use std::fmt;

use super::ast::{Bound, Formula, Interval, MAX_BOUND, TimeUnit};
use crate::ltl::{Ltl, StepBound};

/// What one step of the model is in the trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Steps {
    /// From one sample to the next.
    Samples,
    /// This many seconds.
    Secs(f64),
}

/// Why a property of steps is not one of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepError {
    /// A step's duration is not a positive number.
    Duration {
        /// The duration in seconds.
        secs: f64,
    },
    /// `X` asks for the next step, where only durations are known.
    Next,
    /// A bound is longer than an interval can be.
    Bound {
        /// The number of steps.
        steps: u64,
    },
}

impl fmt::Display for StepError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StepError::Duration { secs } => write!(
                out,
                "a step cannot last {secs} s; give a duration of more than 0 s"
            ),
            StepError::Next => out.write_str(
                "\"X\" means the next step, which a trace in seconds does not show; use a bounded \
                 \"F\" or \"G\", or judge the trace by samples",
            ),
            StepError::Bound { steps } => write!(
                out,
                "a bound of {steps} steps is too long for a trace; an interval may have up to \
                 {MAX_BOUND} seconds or samples"
            ),
        }
    }
}

impl std::error::Error for StepError {}

/// The formula that means the same as `property`; atomic proposition i becomes atom i.
///
/// # Errors
/// [`StepError`] if a bound or `X` cannot be said of a trace.
pub fn from_ltl(property: &Ltl, steps: Steps) -> Result<Formula, StepError> {
    let part = |inner: &Ltl| from_ltl(inner, steps);
    let boxed = |inner: &Ltl| part(inner).map(Box::new);
    Ok(match property {
        Ltl::True => Formula::True,
        Ltl::False => Formula::False,
        Ltl::Ap(index) => Formula::atom(*index),
        Ltl::Not(inner) => Formula::Not(boxed(inner)?),
        Ltl::And(left, right) => Formula::and(part(left)?, part(right)?),
        // Implications are kept, so that what triggers a response is seen.
        Ltl::Or(left, right) => match left.as_ref() {
            Ltl::Not(from) => Formula::implies(part(from)?, part(right)?),
            _ => Formula::or(part(left)?, part(right)?),
        },
        Ltl::Next(inner) => match steps {
            Steps::Samples => Formula::Next(boxed(inner)?),
            Steps::Secs(_) => return Err(StepError::Next),
        },
        // An empty window has nothing in it to find, and nothing that could be wrong.
        Ltl::Until(_, _, bound) | Ltl::Finally(_, bound) if bound.is_empty() => Formula::False,
        Ltl::Release(_, _, bound) | Ltl::WeakUntil(_, _, bound) | Ltl::Globally(_, bound)
            if bound.is_empty() =>
        {
            Formula::True
        }
        Ltl::Until(left, right, bound) => {
            Formula::Until(interval(*bound, steps)?, boxed(left)?, boxed(right)?)
        }
        Ltl::Release(left, right, bound) => {
            Formula::Release(interval(*bound, steps)?, boxed(left)?, boxed(right)?)
        }
        Ltl::Finally(inner, bound) => Formula::Eventually(interval(*bound, steps)?, boxed(inner)?),
        Ltl::Globally(inner, bound) => Formula::Always(interval(*bound, steps)?, boxed(inner)?),
        Ltl::WeakUntil(left, right, bound) => {
            let window = interval(*bound, steps)?;
            let (left, right) = (boxed(left)?, boxed(right)?);
            if bound.lower == 0 {
                Formula::WeakUntil(window, left, right)
            } else {
                weak_until_later(window, *left, *right)
            }
        }
    })
}

/// `!((a & !b) U (!a & !b))`
fn weak_until_later(window: Interval, left: Formula, right: Formula) -> Formula {
    let only_left = Formula::and(left.clone(), Formula::not(right.clone()));
    let neither = Formula::and(Formula::not(left), Formula::not(right));
    Formula::not(Formula::until(window, only_left, neither))
}

fn interval(bound: StepBound, steps: Steps) -> Result<Interval, StepError> {
    let high = bound
        .upper
        .map(|upper| converted(upper, steps))
        .transpose()?;
    Ok(match (bound.lower, high) {
        (0, None) => Interval::UNBOUNDED,
        (lower, high) => Interval {
            low: converted(lower, steps)?,
            high,
        },
    })
}

fn converted(count: u64, steps: Steps) -> Result<Bound, StepError> {
    let (value, unit) = match steps {
        Steps::Samples => (count as f64, TimeUnit::Samples),
        Steps::Secs(secs) if secs > 0.0 && secs.is_finite() => {
            (count as f64 * secs, TimeUnit::Seconds)
        }
        Steps::Secs(secs) => return Err(StepError::Duration { secs }),
    };
    if value > MAX_BOUND {
        return Err(StepError::Bound { steps: count });
    }
    Ok(Bound { value, unit })
}
