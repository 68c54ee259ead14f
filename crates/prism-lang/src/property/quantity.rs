//! Numbers that a property asks for: probabilities, rewards, long-run shares, and arithmetic over them.

use super::{Path, StateFormula};
use crate::ast::{BinaryOp, Optimum, Type};
use crate::expr::{Expr, Function};
use crate::number::Number;

/// A number in each state.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// An expression over the variables.
    Expr(Expr),
    /// The probability of a path formula: least or greatest over schedulers, if the model has choices.
    Probability {
        /// `min` or `max`; none in a model without choices.
        optimum: Option<Optimum>,
        /// The path formula.
        path: Box<Path>,
    },
    /// The probability of a path formula, given that another one holds: least or greatest over the schedulers
    /// under which that is possible, if the model has choices.
    Conditional {
        /// `min` or `max`; none in a model without choices.
        optimum: Option<Optimum>,
        /// The path formula.
        path: Box<Path>,
        /// What is given.
        condition: Box<Path>,
    },
    /// An expected reward: least or greatest over schedulers, if the model has choices.
    Reward {
        /// `min` or `max`; none in a model without choices.
        optimum: Option<Optimum>,
        /// Which reward, and what of it.
        reward: RewardQuery,
    },
    /// The share of time that is spent in these states, in the long run.
    LongRun(Box<StateFormula>),
    /// The opposite number.
    Minus(Box<Quantity>),
    /// One of `+`, `-`, `*`, `/`, `^`.
    Binary(BinaryOp, Box<Quantity>, Box<Quantity>),
    /// The first number where the formula holds, else the second.
    Choice(Box<StateFormula>, Box<Quantity>, Box<Quantity>),
    /// A function.
    Call(Function, Vec<Quantity>),
    /// A filter whose value is a number; the same in all states, except for those that print.
    Filter(Box<Filter>),
}

impl Quantity {
    /// `int` or `double`: powers and `mod` of integers are integers.
    pub fn ty(&self) -> Type {
        let join = |a: Type, b: Type| if a == Type::Int { b } else { a };
        match self {
            Self::Expr(expr) => expr.ty,
            Self::Probability { .. }
            | Self::Conditional { .. }
            | Self::Reward { .. }
            | Self::LongRun(_) => Type::Double,
            Self::Minus(operand) => operand.ty(),
            Self::Binary(BinaryOp::Divide, ..) => Type::Double,
            Self::Binary(_, a, b) | Self::Choice(_, a, b) => join(a.ty(), b.ty()),
            Self::Call(function, arguments) => {
                function.result(arguments.iter().map(Self::ty).fold(Type::Int, join))
            }
            Self::Filter(filter) => match (filter.operator, &filter.operand) {
                (FilterOperator::Count, _) => Type::Int,
                (FilterOperator::Average, _) | (_, FilterOperand::Truth(_)) => Type::Double,
                (_, FilterOperand::Number(number)) => number.ty(),
            },
        }
    }
}

/// An expected reward.
#[derive(Clone, Debug, PartialEq)]
pub struct RewardQuery {
    /// The index of the reward structure in [`Model::rewards`](crate::resolved::Model::rewards).
    pub structure: usize,
    /// The index of the one by which is divided (`R{"a"}/{"b"}`), if any.
    pub divisor: Option<usize>,
    /// What is accumulated, and how long.
    pub objective: RewardObjective,
}

/// What of a reward is expected.
#[derive(Clone, Debug, PartialEq)]
pub enum RewardObjective {
    /// `F target`: accumulated before the target is reached; infinite where it may never be.
    Reach(Box<StateFormula>),
    /// Accumulated until a co-safe formula of linear temporal logic is decided to hold; infinite where it may
    /// never be.
    CoSafe(Box<Path>),
    /// `C<=k`: accumulated within these steps, or this time.
    Cumulative(Horizon),
    /// `C`: accumulated for ever.
    Total,
    /// `I=k`: the state reward at this step, or time.
    Instantaneous(Horizon),
    /// `S`: for each step, or unit of time, in the long run.
    LongRun,
}

/// A number of steps, or a time where that is continuous.
#[derive(Clone, Debug, PartialEq)]
pub enum Horizon {
    /// Steps.
    Steps(u64),
    /// Time, in the model's unit.
    Time(Number),
}

/// One of several objectives.
#[derive(Clone, Debug, PartialEq)]
pub enum Objective {
    /// A probability or a reward, as small or as large as possible.
    Optimise(Optimum, Quantity),
    /// A probability or a reward that must meet its bound.
    Require(StateFormula),
}

/// A value over a set of states.
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    /// How the values are joined.
    pub operator: FilterOperator,
    /// What has a value in each state.
    pub operand: FilterOperand,
    /// The states; all reachable ones, if `None`.
    pub states: Option<StateFormula>,
}

/// What a filter is over.
#[derive(Clone, Debug, PartialEq)]
pub enum FilterOperand {
    /// Truth values.
    Truth(StateFormula),
    /// Numbers.
    Number(Quantity),
}

/// How a filter joins values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FilterOperator {
    /// The least.
    Min,
    /// The greatest.
    Max,
    /// True in the states that have the least.
    ArgMin,
    /// True in the states that have the greatest.
    ArgMax,
    /// In how many states it holds.
    Count,
    /// The sum.
    Sum,
    /// The mean.
    Average,
    /// The value in the first state.
    First,
    /// The least and the greatest.
    Range,
    /// Whether it holds in all.
    ForAll,
    /// Whether it holds in some.
    Exists,
    /// Lists the states where it holds or is not 0.
    Print,
    /// Lists all states.
    PrintAll,
    /// The value in the only state; several are an error.
    State,
}

impl FilterOperator {
    /// All operators.
    pub const ALL: [Self; 14] = [
        Self::Min,
        Self::Max,
        Self::ArgMin,
        Self::ArgMax,
        Self::Count,
        Self::Sum,
        Self::Average,
        Self::First,
        Self::Range,
        Self::ForAll,
        Self::Exists,
        Self::Print,
        Self::PrintAll,
        Self::State,
    ];

    /// Its word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Min => "min",
            Self::Max => "max",
            Self::ArgMin => "argmin",
            Self::ArgMax => "argmax",
            Self::Count => "count",
            Self::Sum => "sum",
            Self::Average => "avg",
            Self::First => "first",
            Self::Range => "range",
            Self::ForAll => "forall",
            Self::Exists => "exists",
            Self::Print => "print",
            Self::PrintAll => "printall",
            Self::State => "state",
        }
    }

    /// The operator of this word or symbol (`+`, `&`, `|`).
    pub fn from_word(word: &str) -> Option<Self> {
        match word {
            "+" => Some(Self::Sum),
            "&" => Some(Self::ForAll),
            "|" => Some(Self::Exists),
            _ => Self::ALL.into_iter().find(|o| o.word() == word),
        }
    }

    /// Whether its operand must be a number.
    pub fn needs_numbers(self) -> bool {
        matches!(
            self,
            Self::Min
                | Self::Max
                | Self::ArgMin
                | Self::ArgMax
                | Self::Sum
                | Self::Average
                | Self::Range
        )
    }

    /// Whether its operand must be true or false.
    pub fn needs_truth(self) -> bool {
        matches!(self, Self::Count | Self::ForAll | Self::Exists)
    }
}
