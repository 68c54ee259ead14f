//! Why a certificate is not accepted.

use std::fmt;

use prism_lang::EvalError;

/// Why a certificate is not accepted.
#[derive(Clone, Debug, PartialEq)]
pub enum Failure {
    /// Such questions or models cannot be certified yet.
    Unsupported(String),
    /// The certificate does not fit the model.
    Incomplete(String),
    /// A bound is contradicted by the model.
    Broken {
        /// The state.
        state: Vec<i64>,
        /// What does not hold there.
        what: String,
    },
    /// The model is none: an expression without a value, a variable out of range, probabilities that do not sum to 1.
    Model(String),
    /// The model has no initial state.
    NoInitialState,
    /// The caller asked to stop.
    Cancelled,
}

impl From<EvalError> for Failure {
    fn from(error: EvalError) -> Self {
        Self::Model(error.to_string())
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unsupported(what) => write!(f, "{what} cannot be certified yet"),
            Self::Incomplete(what) | Self::Model(what) => write!(f, "{what}"),
            Self::Broken { state, what } => write!(f, "in the state {state:?} {what}"),
            Self::Cancelled => write!(f, "checking the certificate was stopped"),
            Self::NoInitialState => write!(f, "the model has no initial state"),
        }
    }
}

impl std::error::Error for Failure {}
