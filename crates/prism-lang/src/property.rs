//! Properties with all names resolved: PCTL* and CSL* with rewards, long-run shares, CTL's quantifiers,
//! filters and several objectives.
//!
//! A formula that has no temporal operator outside of `P` is a [`StateFormula`] (true or false in a state) or a
//! [`Quantity`] (a number in a state); both can contain each other, and both are evaluated bottom-up, one
//! vector over the states for each node. A [`Path`] is true or false of a path. Bounds are exact rationals.
//! Constants, formulas, labels of the file and references to properties are written out.

mod quantity;
mod structures;
pub use structures::Mentioned;

pub use crate::ast::{Comparison, Optimum};
pub use quantity::{
    Filter, FilterOperand, FilterOperator, Horizon, Objective, Quantity, RewardObjective,
    RewardQuery,
};

use crate::ast::BinaryOp;
use crate::diagnostic::Span;
use crate::expr::Expr;
use crate::number::Number;

/// The bound of a probability: exact, and between 0 and 1.
pub type Bound = Number;

/// A property, its name and its text.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedProperty {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Its source, verbatim (without name and semicolon).
    pub text: String,
    /// Its place.
    pub span: Span,
    /// What it means.
    pub property: Property,
}

/// What is asked.
///
/// What is true or false is asked of all initial states; a number has a value in each of them.
#[derive(Clone, Debug, PartialEq)]
pub enum Property {
    /// The probability of a path formula in a model without choices (bound `None`: `P=?`), or whether it meets
    /// a bound (in a model with choices: under every scheduler).
    Probability {
        /// The comparison and the bound; none for `=?`.
        bound: Option<(Comparison, Bound)>,
        /// The path formula.
        path: Path,
    },
    /// Whether a state formula holds.
    State(StateFormula),
    /// A number: `Pmax=?`, `R=?`, `S=?`, arithmetic over these, or a filter's value.
    Number(Quantity),
    /// `filter(range, ...)`: least and greatest value.
    Range(Filter),
    /// `multi(...)`.
    Objectives(Vec<Objective>),
}

/// A formula that holds or does not hold in a state.
#[derive(Clone, Debug, PartialEq)]
pub enum StateFormula {
    /// A predicate over the variables.
    Expr(Expr),
    /// A label of the model, or the built-in `init` or `deadlock`.
    Label(String),
    /// Negation.
    Not(Box<StateFormula>),
    /// Conjunction.
    And(Box<StateFormula>, Box<StateFormula>),
    /// Disjunction.
    Or(Box<StateFormula>, Box<StateFormula>),
    /// Implication.
    Implies(Box<StateFormula>, Box<StateFormula>),
    /// Equivalence.
    Iff(Box<StateFormula>, Box<StateFormula>),
    /// The second formula where the first holds, else the third.
    Choice(Box<StateFormula>, Box<StateFormula>, Box<StateFormula>),
    /// Whether the probability of a path formula meets a bound (under every scheduler).
    Probability {
        /// The comparison and the bound.
        bound: (Comparison, Bound),
        /// The path formula.
        path: Box<Path>,
    },
    /// Whether an expected reward meets a bound (under every scheduler).
    Reward {
        /// The comparison and the bound.
        bound: (Comparison, Number),
        /// Which reward, and what of it.
        reward: RewardQuery,
    },
    /// Whether the share of time that is spent in states, in the long run, meets a bound.
    LongRun {
        /// The comparison and the bound.
        bound: (Comparison, Bound),
        /// The states.
        states: Box<StateFormula>,
    },
    /// `A`: all paths satisfy it.
    ForAll(Box<Path>),
    /// `E`: some path satisfies it.
    Exists(Box<Path>),
    /// `<<*>>`: the bound of the operator directly inside must be met under some scheduler, not under all.
    SomeScheduler(Box<StateFormula>),
    /// A comparison of numbers: one of `=`, `!=`, `<`, `<=`, `>`, `>=`.
    Compare(BinaryOp, Box<Quantity>, Box<Quantity>),
    /// A filter whose value is true or false; it is the same in all states, except for
    /// [`FilterOperator::ArgMin`], [`FilterOperator::ArgMax`], and those that print.
    Filter(Box<Filter>),
}

/// A formula that holds or does not hold of a path.
///
/// A subformula without temporal operators outside `P` is always one [`Path::State`].
#[derive(Clone, Debug, PartialEq)]
pub enum Path {
    /// A state formula, of the path's first state.
    State(Box<StateFormula>),
    /// Negation.
    Not(Box<Path>),
    /// Conjunction.
    And(Box<Path>, Box<Path>),
    /// Disjunction.
    Or(Box<Path>, Box<Path>),
    /// Implication.
    Implies(Box<Path>, Box<Path>),
    /// Equivalence.
    Iff(Box<Path>, Box<Path>),
    /// In the next step.
    Next(Box<Path>),
    /// `left` holds until, at a step within the bound, `right` holds.
    Until {
        /// What must hold before.
        left: Box<Path>,
        /// What must come.
        right: Box<Path>,
        /// When.
        bound: TimeBound,
    },
    /// At some step within the bound.
    Finally {
        /// What must come.
        operand: Box<Path>,
        /// When.
        bound: TimeBound,
    },
    /// At all steps within the bound.
    Globally {
        /// What must always hold.
        operand: Box<Path>,
        /// When.
        bound: TimeBound,
    },
    /// `(left U right) | G left`; with a bound: `!( (left & !right) U{bound} (!left & !right) )`.
    WeakUntil {
        /// What must hold before.
        left: Box<Path>,
        /// What ends the obligation.
        right: Box<Path>,
        /// When.
        bound: TimeBound,
    },
    /// An operator with a bound in time, in a model with continuous time.
    Timed {
        /// The operator.
        operator: TimedOperator,
        /// What must hold before (`U`, `W`), or what ends the obligation (`R`); none for `F` and `G`.
        left: Option<Box<Path>>,
        /// The other operand.
        right: Box<Path>,
        /// When: not unbounded.
        interval: TimeInterval,
    },
    /// `!(!left U{bound} !right)`.
    Release {
        /// What ends the obligation.
        left: Box<Path>,
        /// What must hold up to and including then.
        right: Box<Path>,
        /// When.
        bound: TimeBound,
    },
}

impl Path {
    /// Whether some temporal operator outside of nested `P`, `A`, `E` has a bound in continuous time.
    pub fn has_time_bound(&self) -> bool {
        match self {
            Self::State(_) => false,
            Self::Not(a) | Self::Next(a) => a.has_time_bound(),
            Self::Finally { operand, .. } | Self::Globally { operand, .. } => {
                operand.has_time_bound()
            }
            Self::And(a, b) | Self::Or(a, b) | Self::Implies(a, b) | Self::Iff(a, b) => {
                a.has_time_bound() || b.has_time_bound()
            }
            Self::Until { left, right, .. }
            | Self::WeakUntil { left, right, .. }
            | Self::Release { left, right, .. } => left.has_time_bound() || right.has_time_bound(),
            Self::Timed { .. } => true,
        }
    }
}

/// The steps at which an operand counts: `lower..upper`, each bound with a flag that is true if it is strict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct TimeBound {
    /// Least number of steps, and whether it is excluded.
    pub lower: Option<(i64, bool)>,
    /// Greatest number of steps, and whether it is excluded.
    pub upper: Option<(i64, bool)>,
}

impl TimeBound {
    /// Whether any number of steps will do.
    pub fn is_unbounded(&self) -> bool {
        self.first_step() == 0 && self.upper.is_none()
    }

    /// The first step that counts.
    pub fn first_step(&self) -> u64 {
        let (bound, strict) = self.lower.unwrap_or((0, false));
        let first = bound.saturating_add(i64::from(strict));
        u64::try_from(first).unwrap_or(0)
    }

    /// The last step that counts, if there is a last one. Empty ranges are rejected when resolving.
    pub fn last_step(&self) -> Option<u64> {
        let (bound, strict) = self.upper?;
        u64::try_from(bound.saturating_sub(i64::from(strict))).ok()
    }
}

/// The temporal operators that a bound in time can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TimedOperator {
    /// `U`
    Until,
    /// `F`
    Finally,
    /// `G`
    Globally,
    /// `W`
    WeakUntil,
    /// `R`
    Release,
}

/// An interval of times, in the model's unit; each bound with a flag that is true if it is strict. (In a
/// `ctmc` strictness changes no probability.)
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimeInterval {
    /// Least time, and whether it is excluded; 0 if `None`.
    pub lower: Option<(Number, bool)>,
    /// Greatest time, and whether it is excluded; none if `None`.
    pub upper: Option<(Number, bool)>,
}
