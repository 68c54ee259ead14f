//! From a box of constants to the ranges of transition probabilities, by exploring its corners.

use super::degrees::obstacle;
use super::{IntervalModel, Range};
use crate::explore::{ExploreError, ExploreOptions, explore_with};
use crate::state_space::{Csr, StateSpace};
use prism_lang::resolved::ModelType;
use prism_lang::{Constants, Number, Rational, Value, ast, resolve_with};
use std::fmt;

/// How near to 0 a constant comes whose interval begins there: products of six such constants can still be represented, and
/// what is missed is far below what each mean is widened by.
const NEXT_TO_ZERO: f64 = 1e-50;

/// Constants beyond which corners are too many.
const MOST_CONSTANTS: usize = 10;

/// A constant of a model and the interval in which it lies.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstantRange {
    /// Its name.
    pub name: String,
    /// Least value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

impl ConstantRange {
    /// The ends at which the model is explored: 0 and 1 are approached, since transitions vanish there.
    fn explored_ends(&self) -> (f64, f64) {
        let is_interval = self.low < self.high;
        let low = match is_interval && self.low == 0.0 {
            true => NEXT_TO_ZERO.min(self.high),
            false => self.low,
        };
        let high = match is_interval && self.high == 1.0 {
            true => 1.0_f64.next_down().max(low),
            false => self.high,
        };
        (low, high)
    }
}

/// Why there is no interval model.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum IntervalModelError {
    /// The probabilities of a state's transitions cannot sum to 1 within their ranges, or may be 0.
    Row {
        /// The state's number.
        state: usize,
    },
    /// A range is none, or the constants are too many.
    Box(String),
    /// The ranges of the probabilities cannot be found from the corners.
    Form(String),
    /// A corner of the box is no model: the reason.
    Corner(String),
    /// The caller stopped the search.
    Cancelled,
}

impl fmt::Display for IntervalModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Row { state } => write!(
                f,
                "the transitions of state {state} have no probabilities within their ranges that are \
                 positive and sum to 1"
            ),
            Self::Box(what) => write!(f, "{what}"),
            Self::Form(what) => write!(f, "the ranges of probabilities are not known: {what}"),
            Self::Corner(what) => write!(f, "at a corner of the constants' box: {what}"),
            Self::Cancelled => write!(f, "the search was stopped"),
        }
    }
}

impl std::error::Error for IntervalModelError {}

impl IntervalModel {
    /// The interval model of a model whose constants lie in a box; constants not named keep their value.
    ///
    /// # Errors
    /// See [`IntervalModelError`]; [`IntervalModelError::Form`] says why a model is refused.
    pub fn new(
        tree: &ast::Model,
        constants: &[ConstantRange],
        max_states: usize,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Self, IntervalModelError> {
        if constants.len() > MOST_CONSTANTS {
            let count = constants.len();
            let message =
                format!("{count} constants have too many corners (at most {MOST_CONSTANTS})");
            return Err(IntervalModelError::Box(message));
        }
        if let Some(bad) = constants
            .iter()
            .find(|c| c.low.is_nan() || c.high.is_nan() || c.low > c.high)
        {
            let message = format!("`{}` has no interval", bad.name);
            return Err(IntervalModelError::Box(message));
        }
        let names: Vec<&str> = constants.iter().map(|c| c.name.as_str()).collect();
        if let Some(reason) = obstacle(tree, &names) {
            return Err(IntervalModelError::Form(reason));
        }
        let mut hull: Option<StateSpace<Range>> = None;
        for corner in 0_u32..1 << constants.len() {
            let space = explored(tree, constants, corner, max_states, cancelled)?;
            hull = Some(match hull {
                None => as_ranges(space),
                Some(known) => widened(known, &space)?,
            });
        }
        match hull {
            Some(space) => Self::feasible(space),
            None => Err(IntervalModelError::Box("there is no corner".to_owned())),
        }
    }
}

/// The state space at one corner: the upper end of each constant whose bit is set.
fn explored(
    tree: &ast::Model,
    constants: &[ConstantRange],
    corner: u32,
    max_states: usize,
    cancelled: &dyn Fn() -> bool,
) -> Result<StateSpace<f64>, IntervalModelError> {
    let mut overrides = Constants::new();
    for (place, constant) in constants.iter().enumerate() {
        let (low, high) = constant.explored_ends();
        let end = if corner >> place & 1 == 1 { high } else { low };
        let exact = Rational::from_float(end).ok_or_else(|| {
            IntervalModelError::Box(format!("`{}` has no finite end", constant.name))
        })?;
        let value = Value::Double(Number::from_rational(exact));
        overrides.set(constant.name.clone(), value);
    }
    let model = resolve_with(tree, &Constants::new(), &overrides).map_err(|found| {
        let words: Vec<String> = found.into_iter().map(|d| d.message).collect();
        IntervalModelError::Corner(words.join("; "))
    })?;
    if model.model_type != ModelType::Dtmc {
        let kind = model.model_type.keyword();
        let message =
            format!("models of type `{kind}` have no interval model yet: only `dtmc` has");
        return Err(IntervalModelError::Form(message));
    }
    let go_on = |_: usize| !cancelled();
    explore_with(
        &model,
        ExploreOptions {
            max_states,
            ..ExploreOptions::default()
        },
        &go_on,
    )
    .map_err(|error| match error {
        ExploreError::Cancelled => IntervalModelError::Cancelled,
        error => IntervalModelError::Corner(error.to_string()),
    })
}

/// Each probability with its own rounding.
pub(super) fn as_ranges(space: StateSpace<f64>) -> StateSpace<Range> {
    let error = space.relative_error();
    let matrix = Csr {
        value: space
            .matrix
            .value
            .iter()
            .map(|p| about(*p, error))
            .collect(),
        row_start: space.matrix.row_start,
        column: space.matrix.column,
    };
    StateSpace {
        kind: space.kind,
        matrix,
        choice_start: space.choice_start,
        choice_action: space.choice_action,
        actions: space.actions,
        // Rewards have no ranges yet.
        rewards: Vec::new(),
        variables: space.variables,
        layout: space.layout,
        packed: space.packed,
        initial: space.initial,
        deadlocks: space.deadlocks,
        labelled_transitions: space.labelled_transitions,
        labels: space.labels,
        roundings: Some(0),
        represented: None,
    }
}

/// A probability that was computed with this relative error; 1 is exact, as the only transition.
fn about(probability: f64, error: f64) -> Range {
    if probability == 1.0 {
        return Range {
            low: 1.0,
            high: 1.0,
        };
    }
    Range {
        low: (probability * (1.0 - error)).next_down(),
        high: (probability * (1.0 + error)).next_up().min(1.0),
    }
}

/// The hull with another corner, which must have the same states and transitions.
fn widened(
    mut known: StateSpace<Range>,
    corner: &StateSpace<f64>,
) -> Result<StateSpace<Range>, IntervalModelError> {
    let same = known.packed == corner.packed
        && known.initial == corner.initial
        && known.matrix.row_start == corner.matrix.row_start
        && known.matrix.column == corner.matrix.column;
    if !same {
        return Err(IntervalModelError::Form(
            "the corners do not have the same transitions".to_owned(),
        ));
    }
    let error = corner.relative_error();
    for (range, p) in known.matrix.value.iter_mut().zip(&corner.matrix.value) {
        let here = about(*p, error);
        range.low = range.low.min(here.low);
        range.high = range.high.max(here.high);
    }
    Ok(known)
}
