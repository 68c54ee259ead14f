//! What is asked of the checker beyond the property, and what it answers.

use std::fmt;

use prism_lang::Rational;
pub use stats::Guarantee;
use temporal::automaton::AutomatonError;

use crate::method::{Method, Termination};
use crate::rounding::Bounds;
use crate::state_space::StateError;
use crate::stop::Stop;

/// How to check.
#[derive(Clone, Copy)]
pub struct Options<'a> {
    /// How values are computed.
    pub method: Method,
    /// Methods with bounds: the widest relative distance of these that is aimed at.
    pub precision: f64,
    /// Methods that are estimates ([`Method::is_estimate`]): iteration stops when no value changes by more than this.
    pub epsilon: f64,
    /// The same: which change is meant.
    pub termination: Termination,
    /// The same: iteration fails after this many rounds (of [`Method::PrismDefault`] on the whole model, of others on
    /// a strongly connected component).
    pub max_iters: u64,
    /// Most states of a product with an automaton, and of an automaton.
    pub product_limit: usize,
    /// Only fair schedulers: each choice of each state that is visited infinitely often is taken infinitely often.
    pub fair: bool,
    /// Most states for which a comparison that bounds leave open is decided by rational arithmetic.
    pub exact_limit: usize,
    /// Asked now and then; the check ends with [`CheckError::Cancelled`] when it returns true.
    pub cancel: Option<&'a (dyn Fn() -> bool + Sync)>,
    /// Asked now and then; the check ends with [`CheckError::Stopped`] and the bounds reached so far when it is to stop.
    pub stop: Option<&'a Stop<'a>>,
}

impl Default for Options<'_> {
    fn default() -> Self {
        Self {
            method: Method::Sound,
            precision: 1e-6,
            epsilon: 1e-6,
            termination: Termination::Relative,
            max_iters: 10_000,
            product_limit: 50_000_000,
            fair: false,
            exact_limit: 1_000_000,
            cancel: None,
            stop: None,
        }
    }
}

impl Options<'_> {
    /// The default options with another method.
    pub fn with_method(method: Method) -> Self {
        Self {
            method,
            ..Self::default()
        }
    }

    pub(crate) fn check_cancelled(&self) -> Result<(), CheckError> {
        match self.is_cancelled() {
            true => Err(CheckError::Cancelled),
            false => Ok(()),
        }
    }

    /// Whether to end what is under way: for good, or to stop.
    pub(crate) fn is_cancelled(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel()) || self.stop.is_some_and(Stop::is_asked)
    }

    /// Whether to stop with the bounds that a loop has reached: an error if it is cancelled, or would stop and has none.
    pub(crate) fn stops(&self) -> Result<bool, CheckError> {
        if self.method.is_estimate() {
            return self.check_cancelled().map(|()| false);
        }
        match self.cancel.is_some_and(|cancel| cancel()) {
            true => Err(CheckError::Cancelled),
            // Asked once: what is asked again may have another answer.
            false => Ok(self.must_stop()),
        }
    }

    /// Whether to stop and go on with the bounds reached so far; asked by methods with bounds before what they would leave
    /// out, and before [`Self::check_cancelled`].
    pub(crate) fn must_stop(&self) -> bool {
        !self.method.is_estimate() && self.stop.is_some_and(Stop::cuts)
    }
}

impl fmt::Debug for Options<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        (formatter.debug_struct("Options"))
            .field("method", &self.method)
            .field("precision", &self.precision)
            .field("epsilon", &self.epsilon)
            .field("termination", &self.termination)
            .field("max_iters", &self.max_iters)
            .field("product_limit", &self.product_limit)
            .field("fair", &self.fair)
            .field("exact_limit", &self.exact_limit)
            .finish_non_exhaustive()
    }
}

/// The value of a property in the initial state, or in the initial states if there are several.
#[derive(Debug, Clone, PartialEq)]
pub enum AnswerValue {
    /// A number, as near as the guarantee says.
    Number(f64),
    /// The number itself.
    Exact(Rational),
    /// Least and greatest value over several initial states, as near as the guarantee says.
    Range {
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
    },
    /// Least and greatest value over several initial states.
    ExactRange {
        /// Least value.
        low: Rational,
        /// Greatest value.
        high: Rational,
    },
    /// Least and greatest value over several initial states, of which one at least is infinite.
    Ends {
        /// Least value.
        low: Box<AnswerValue>,
        /// Greatest value.
        high: Box<AnswerValue>,
    },
    /// Whether the property holds (in all initial states).
    Truth(bool),
    /// The corners of what two objectives can reach together, in the order of the first.
    Corners(Vec<Vec<Rational>>),
}

/// The value in one initial state.
#[derive(Debug, Clone, PartialEq)]
pub struct InitialValue {
    /// The state's number.
    pub state: usize,
    /// Its value.
    pub value: AnswerValue,
    /// What is known of it.
    pub guarantee: Guarantee,
}

/// The answer to one property.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Answer {
    /// The value.
    pub value: AnswerValue,
    /// What is known of it.
    pub guarantee: Guarantee,
    /// How it was computed.
    pub method: Method,
    /// For a probability with one initial state: the probability of the contrary, computed as such and
    /// not as a difference from 1, so that it keeps its digits when the value is nearly 1. Missing
    /// where it was not computed (methods that are estimates).
    pub complement: Option<f64>,
    /// What is known of the complement, where it is not exact.
    pub complement_bounds: Option<(f64, f64)>,
    /// Rounds of iteration; 0 when all components were solved directly.
    pub iterations: u64,
    /// States of the largest product with an automaton; `None` when no automaton was needed.
    pub product_states: Option<usize>,
    /// The value in each initial state.
    pub initial: Vec<InitialValue>,
    /// What the reader should know besides, for example that the precision asked for was not reached.
    pub notes: Vec<String>,
    /// In a model with choices: for each state the choice (a row of the matrix) that attains the value, if the
    /// outermost operator has such a scheduler and the choice matters.
    pub scheduler: Option<Vec<Option<usize>>>,
    /// The states, with their values, that filters of the property list.
    pub printed: Vec<(usize, AnswerValue)>,
}

/// Relative width of its bounds up to which a complement is shown.
const SHARP: f64 = 1e-3;

impl Answer {
    /// The complement, unless its bounds are so far apart that its digits mean nothing.
    pub fn sharp_complement(&self) -> Option<f64> {
        match self.complement_bounds {
            Some((low, high)) if high - low > low * SHARP => None,
            _ => self.complement,
        }
    }
}

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum CheckError {
    /// The caller asked to stop.
    Cancelled,
    /// The caller asked to stop, by [`Options::stop`].
    Stopped {
        /// Bounds of the property's value (in all initial states) that hold but are wider than asked for; of a
        /// comparison, of the value that is compared. `None` if there were none yet.
        reached: Option<Bounds>,
    },
    /// The property or model asks for something that is not implemented.
    Unsupported(String),
    /// An option makes no sense.
    InvalidOption(String),
    /// A set of states could not be found.
    State(StateError),
    /// A reward of the model has no value in some state.
    Reward(String),
    /// The automaton of a path formula could not be built.
    Automaton(AutomatonError),
    /// The product with an automaton has too many states.
    ProductTooLarge {
        /// The limit.
        limit: usize,
    },
    /// An iteration that is an estimate did not reach its stopping rule.
    NotConverged {
        /// Rounds done.
        iterations: u64,
        /// The threshold that was not met.
        epsilon: f64,
    },
    /// An iteration that is an estimate divided by zero (1 less the probability of staying in a state rounds to
    /// 0), or its values grew beyond all numbers.
    NotFinite {
        /// The state's number.
        state: usize,
    },
    /// Whether a bound is met cannot be told from the computed bounds.
    Undecided {
        /// The comparison, written out.
        comparison: String,
        /// What is known of the probability.
        bounds: Bounds,
        /// Whether it is the property's own comparison, not one within it.
        is_whole: bool,
    },
    /// Which choice is best is not the same at all points of a region of parameters, or not known to be.
    OpenChoice,
    /// The state space could not be built in rational arithmetic.
    ExactModel(String),
    /// The model has no initial state.
    NoInitialState,
    /// A filter has no value, because of the states that it selects.
    Filter(String),
}

impl fmt::Display for CheckError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cancelled => formatter.write_str("the check was stopped before it had an answer"),
            Self::Stopped { reached: None } => {
                formatter.write_str("the check was stopped before it had bounds")
            }
            Self::Stopped {
                reached: Some(Bounds { low, high }),
            } => write!(
                formatter,
                "the check was stopped when the value was known to lie between {low} and {high}"
            ),
            Self::Unsupported(what)
            | Self::InvalidOption(what)
            | Self::Filter(what)
            | Self::Reward(what) => formatter.write_str(what),
            Self::State(error) => error.fmt(formatter),
            Self::Automaton(error) => error.fmt(formatter),
            Self::ProductTooLarge { limit } => write!(
                formatter,
                "the product of the model with the automaton of the property has more than {limit} \
                 states; raise the limit or split the property"
            ),
            Self::NotConverged {
                iterations,
                epsilon,
            } => write!(
                formatter,
                "the iteration still changes by more than {epsilon} after {iterations} rounds; use \
                 the sound or the exact method, or raise the limit of iterations"
            ),
            Self::NotFinite { state } => write!(
                formatter,
                "the probability of leaving state {state} is too small for this method, which takes it \
                 for 0 and divides by it; use the sound or the exact method"
            ),
            Self::Undecided { comparison, bounds, .. } if bounds.low.is_nan() => write!(
                formatter,
                "whether the value is {comparison} is not the same for all values of the open constants, or \
                 not known to be: give them narrower ranges"
            ),
            Self::Undecided { comparison, bounds, .. } => write!(
                formatter,
                "whether the value is {comparison} is undecided: it lies between {} and {}; \
                 use the exact method",
                bounds.low, bounds.high
            ),
            Self::OpenChoice => formatter.write_str(
                "which choice is best is not known to be the same for all values of the open constants; \
                 give them narrower ranges",
            ),
            Self::ExactModel(reason) => write!(
                formatter,
                "the model cannot be built in rational arithmetic: {reason}"
            ),
            Self::NoInitialState => formatter
                .write_str("the model has no initial state; its `init` predicate holds nowhere"),
        }
    }
}

impl std::error::Error for CheckError {}

impl From<StateError> for CheckError {
    fn from(error: StateError) -> Self {
        Self::State(error)
    }
}

impl From<AutomatonError> for CheckError {
    fn from(error: AutomatonError) -> Self {
        Self::Automaton(error)
    }
}
