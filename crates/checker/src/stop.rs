//! Ending a check early, with the bounds reached so far.
//!
//! Bounds hold at every moment of an iteration, so a check need not be lost that takes too long: asked to stop
//! ([`Options::stop`]), what is being solved is left with the bounds that it has, what is still to be solved gets bounds that
//! cost little, and the check ends with the property's bounds ([`CheckError::Stopped`]).
//!
//! | what is solved | bounds when stopped |
//! |---|---|
//! | equations of a component ([`crate::sound`], [`crate::optimum::sound`]) | those of the iteration; else, of a probability, the least and greatest value next to the component |
//! | gain of a component ([`crate::long_run`]) | those of the iteration, within the least and greatest reward |
//! | sums over jumps ([`crate::transient`]) | the sum so far, and what the weights left may add |
//! | a number of steps ([`crate::steps`]) | the steps so far, and what the steps left may make of the values |
//!
//! Elsewhere (products with automata, rational arithmetic, and methods whose answers are estimates) there are no bounds to
//! give, and the check is cancelled.
//!
//! [`Options::stop`]: crate::Options::stop
//! [`CheckError::Stopped`]: crate::CheckError::Stopped

use std::sync::atomic::{AtomicBool, Ordering};

use crate::answer::{Answer, AnswerValue, CheckError, Guarantee};
use crate::rounding::Bounds;

/// A request to end a check with the bounds reached so far.
///
/// ```
/// use checker::state_space::{Csr, StateSpace};
/// use checker::{CheckError, Options, Stop, check_space};
/// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
///
/// let text = "dtmc module coin s : [0..2]; [] s=0 -> 0.5:(s'=0) + 0.25:(s'=1) + 0.25:(s'=2); endmodule";
/// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
/// let space = checker::explore::explore::<f64>(&model)?;
/// let properties = parse_properties("P=? [ F s=1 ]").tree;
/// let properties = resolve_properties(&properties, &model, &Constants::new()).unwrap();
/// let at_once = || true;
/// let stop = Stop::new(&at_once);
/// let options = Options { stop: Some(&stop), ..Options::default() };
/// match check_space(&space, &properties[0].property, &options) {
///     Err(CheckError::Stopped { reached: Some(bounds) }) => assert!(bounds.contains(0.5)),
///     // It had an answer already.
///     answer => assert!(answer.is_ok()),
/// }
/// # Ok::<(), checker::explore::ExploreError>(())
/// ```
pub struct Stop<'a> {
    asked: &'a (dyn Fn() -> bool + Sync),
    is_cut: AtomicBool,
}

impl<'a> Stop<'a> {
    /// A check stops when this returns true, and from then on always does.
    pub fn new(asked: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self {
            asked,
            is_cut: AtomicBool::new(false),
        }
    }

    /// Whether to stop.
    pub(crate) fn is_asked(&self) -> bool {
        (self.asked)()
    }

    /// Whether to stop, asked where there is work left that will then be left out.
    pub(crate) fn cuts(&self) -> bool {
        if self.is_asked() {
            self.is_cut.store(true, Ordering::Relaxed);
        }
        self.is_cut()
    }

    /// Whether work was left out.
    pub(crate) fn is_cut(&self) -> bool {
        self.is_cut.load(Ordering::Relaxed)
    }
}

/// What a check found in whose course work was left out: truths, and numbers whose bounds are as close as was asked for,
/// are an answer all the same.
pub(crate) fn after_a_cut(
    found: Result<Answer, CheckError>,
    precision: f64,
) -> Result<Answer, CheckError> {
    let reached = match found {
        Ok(answer) if is_whole(&answer, precision) => return Ok(answer),
        Ok(answer) => {
            let bounds = answer.guarantee.bounds();
            bounds.map(|(low, high)| Bounds { low, high })
        }
        Err(CheckError::Undecided {
            bounds,
            is_whole: true,
            ..
        }) => Some(bounds),
        Err(CheckError::Undecided { .. } | CheckError::Cancelled) => None,
        Err(other) => return Err(other),
    };
    Err(CheckError::Stopped { reached })
}

/// Whether an answer is one as if nothing had been left out.
fn is_whole(answer: &Answer, precision: f64) -> bool {
    let is_close = |guarantee: &Guarantee| match guarantee {
        Guarantee::Exact => true,
        Guarantee::Bounded { low, high } => high - low <= precision * low.abs().max(high.abs()),
        Guarantee::Statistical { .. } | Guarantee::Estimated { .. } => false,
    };
    // States that filters list have values, but no bounds that could be looked at.
    if !answer.printed.is_empty() {
        return false;
    }
    match (&answer.value, answer.initial.is_empty()) {
        (AnswerValue::Truth(_), _) => true,
        (_, true) => is_close(&answer.guarantee),
        _ => answer
            .initial
            .iter()
            .all(|state| is_close(&state.guarantee)),
    }
}
