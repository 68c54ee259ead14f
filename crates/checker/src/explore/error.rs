//! Why a state space could not be built.

use std::fmt;

use prism_lang::{EvalError, Span};

/// Why a state space could not be built. Spans are places in the model's text.
#[derive(Clone, Debug, PartialEq)]
pub enum ExploreError {
    /// The model has a construct that cannot be explored yet.
    UnsupportedConstruct(&'static str),
    /// An update takes a variable out of its range.
    OutOfRange {
        /// The variable.
        variable: String,
        /// The value that it was to take.
        value: i64,
        /// The least value of its range.
        low: i64,
        /// The greatest value of its range.
        high: i64,
        /// The state in which that happens, written out.
        state: String,
        /// The value's expression.
        span: Span,
    },
    /// The probabilities of a command do not sum to 1.
    ProbabilitySum {
        /// What they sum to.
        sum: f64,
        /// The state in which that happens, written out.
        state: String,
        /// The command.
        span: Span,
    },
    /// A probability (a rate) is negative, infinite or not a number.
    NotAProbability {
        /// Its value.
        value: f64,
        /// The state in which that happens, written out.
        state: String,
        /// The probability's expression.
        span: Span,
    },
    /// A positive probability is too small for a double.
    Underflow {
        /// The state in which that happens, written out.
        state: String,
        /// The probability's expression, or the command.
        span: Span,
    },
    /// A reward is infinite or not a number. The structure that it belongs to has no values then.
    NotAReward {
        /// Its value.
        value: f64,
        /// The state in which that happens, written out.
        state: String,
        /// The item of the reward structure.
        span: Span,
    },
    /// The rewards of a structure that the search was told to leave out.
    RewardsLeftOut,
    /// An expression has no value.
    NoValue {
        /// What went wrong, and in which expression.
        error: EvalError,
        /// The state in which that happens, written out.
        state: String,
    },
    /// There are more states than allowed.
    TooManyStates {
        /// The limit.
        limit: usize,
    },
    /// States and transitions take more memory than allowed.
    TooMuchMemory {
        /// The limit in bytes.
        limit: usize,
        /// How many states were found until then.
        states: usize,
    },
    /// `init ... endinit` has too many candidates to try.
    TooManyCandidates {
        /// The limit.
        limit: u64,
    },
    /// No state satisfies the predicate of `init ... endinit`.
    NoInitialState {
        /// The predicate.
        span: Span,
    },
    /// The caller wanted to stop.
    Cancelled,
}

impl ExploreError {
    /// The place in the model's text, if there is one.
    pub fn span(&self) -> Option<Span> {
        match self {
            Self::OutOfRange { span, .. }
            | Self::ProbabilitySum { span, .. }
            | Self::NotAProbability { span, .. }
            | Self::NotAReward { span, .. }
            | Self::Underflow { span, .. }
            | Self::NoInitialState { span } => Some(*span),
            Self::NoValue { error, .. } => Some(error.span),
            _ => None,
        }
    }
}

impl fmt::Display for ExploreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnsupportedConstruct(what) => write!(f, "{what}"),
            Self::OutOfRange {
                variable,
                value,
                low,
                high,
                state,
                ..
            } => write!(
                f,
                "in state {state}, this update would set `{variable}` to {value}, out of its range {low}..{high}: guard the command, or widen the range"
            ),
            Self::ProbabilitySum { sum, state, .. } => write!(
                f,
                "in state {state}, the probabilities of this command sum to {sum}, not to 1: write the last one as `1 - (...)`"
            ),
            Self::NotAProbability { value, state, .. } => write!(
                f,
                "in state {state}, this probability is {value}, not a number between 0 and 1: check its expression"
            ),
            Self::NotAReward { value, state, .. } => write!(
                f,
                "in state {state}, this reward is {value}, not a finite number: check its expression"
            ),
            Self::Underflow { state, .. } => write!(
                f,
                "in state {state}, this probability is positive but too small for a double: use the exact method"
            ),
            Self::RewardsLeftOut => write!(
                f,
                "this reward structure was left out when the model was explored: explore with it"
            ),
            Self::NoValue { error, state } => write!(f, "in state {state}, {error}"),
            Self::TooManyStates { limit } => write!(
                f,
                "the model has more than {limit} reachable states, which is the limit"
            ),
            Self::TooMuchMemory { limit, states } => write!(
                f,
                "the first {states} states take more than {} MiB: make the model smaller, or raise the limit",
                limit >> 20
            ),
            Self::TooManyCandidates { limit } => write!(
                f,
                "`init ... endinit` would have to be tried on more than {limit} states: give the variables smaller ranges or single initial values"
            ),
            Self::NoInitialState { .. } => write!(
                f,
                "no state satisfies the predicate of `init ... endinit`: correct it"
            ),
            Self::Cancelled => write!(f, "exploring was cancelled before all states were found"),
        }
    }
}

impl std::error::Error for ExploreError {}
