//! What only properties contain.

use super::{BinaryOp, Constant, Expr, Formula, Label, Name};
use crate::diagnostic::{Diagnostic, Span};

/// The comparison of a probability or an expectation with its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Comparison {
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
}

impl Comparison {
    /// The same as an operator of expressions.
    pub fn operator(self) -> BinaryOp {
        match self {
            Self::Less => BinaryOp::Less,
            Self::LessEqual => BinaryOp::LessEqual,
            Self::Greater => BinaryOp::Greater,
            Self::GreaterEqual => BinaryOp::GreaterEqual,
        }
    }

    /// The comparison as written.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Less => "<",
            Self::LessEqual => "<=",
            Self::Greater => ">",
            Self::GreaterEqual => ">=",
        }
    }

    /// Whether `value` compared with `bound` holds (never, if one is not a number).
    pub fn holds<N: PartialOrd>(self, value: &N, bound: &N) -> bool {
        match self {
            Self::Less => value < bound,
            Self::LessEqual => value <= bound,
            Self::Greater => value > bound,
            Self::GreaterEqual => value >= bound,
        }
    }
}

/// Temporal operators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TemporalOp {
    /// `X`
    Next,
    /// `F`
    Finally,
    /// `G`
    Globally,
    /// `U`
    Until,
    /// `W`
    WeakUntil,
    /// `R`
    Release,
}

impl TemporalOp {
    /// The letter of this operator.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Next => "X",
            Self::Finally => "F",
            Self::Globally => "G",
            Self::Until => "U",
            Self::WeakUntil => "W",
            Self::Release => "R",
        }
    }
}

/// The bound of a temporal operator, as written: in steps, or in time in models with continuous time.
#[derive(Clone, Debug, PartialEq)]
pub enum StepBound {
    /// `<=k`, `<k`, `>=k`, `>k`.
    Compare(Comparison, Expr),
    /// `=k`.
    Exactly(Expr),
    /// `[low,high]`.
    Between(Expr, Expr),
}

/// Over which schedulers a query takes the least or greatest value: `min`, `max`; in models whose
/// probabilities are intervals the second word is about them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Optimum {
    /// `min`
    Min,
    /// `max`
    Max,
    /// `minmin`
    MinMin,
    /// `minmax`
    MinMax,
    /// `maxmin`
    MaxMin,
    /// `maxmax`
    MaxMax,
}

impl Optimum {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::Min,
        Self::Max,
        Self::MinMin,
        Self::MinMax,
        Self::MaxMin,
        Self::MaxMax,
    ];

    /// The word as written.
    pub fn word(self) -> &'static str {
        match self {
            Self::Min => "min",
            Self::Max => "max",
            Self::MinMin => "minmin",
            Self::MinMax => "minmax",
            Self::MaxMin => "maxmin",
            Self::MaxMax => "maxmax",
        }
    }
}

/// `{s=0}{min}`: the states for which an operator is asked, in the old form.
#[derive(Clone, Debug, PartialEq)]
pub struct StateFilter {
    /// The states.
    pub states: Expr,
    /// Whether `{min}` is written.
    pub min: bool,
    /// Whether `{max}` is written.
    pub max: bool,
}

/// `R{"cost"}min=? [ F "done" ]`
#[derive(Clone, Debug, PartialEq)]
pub struct Reward {
    /// Which reward structure; the first one, if none is written.
    pub structure: Option<RewardIndex>,
    /// The second one of `R{"a"}/{"b"}`, by which is divided.
    pub divisor: Option<RewardIndex>,
    /// `min`, `max`, ...
    pub optimum: Option<Optimum>,
    /// The comparison and the bound; none for `=?`.
    pub bound: Option<(Comparison, Box<Expr>)>,
    /// What is accumulated.
    pub objective: RewardObjective,
    /// The old form of a filter, if written.
    pub filter: Option<StateFilter>,
}

/// Which reward structure.
#[derive(Clone, Debug, PartialEq)]
pub enum RewardIndex {
    /// `{"name"}`
    Name(Name),
    /// `{2}`: counted from 1.
    Index(Expr),
}

/// What stands between the brackets of `R`.
#[derive(Clone, Debug, PartialEq)]
pub enum RewardObjective {
    /// `C`
    Total,
    /// `C<=k`
    Cumulative(Expr),
    /// `I=k`
    Instantaneous(Expr),
    /// `S`
    LongRun,
    /// `F target`, or another path formula.
    Path(Expr),
}

/// Over all paths, or over some path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantifier {
    /// `A`
    ForAll,
    /// `E`
    Exists,
}

impl Quantifier {
    /// The letter of this quantifier.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::ForAll => "A",
            Self::Exists => "E",
        }
    }
}

/// `<<1,2>> P>=0.5 [ ... ]`, `[[*]] Pmax=? [ ... ]`
#[derive(Clone, Debug, PartialEq)]
pub struct Strategy {
    /// `<<>>` (the players can) or `[[]]` (they cannot avoid).
    pub quantifier: Quantifier,
    /// The players.
    pub coalition: Coalition,
    /// The operator to which this applies.
    pub operand: Box<Expr>,
}

/// Who chooses.
#[derive(Clone, Debug, PartialEq)]
pub enum Coalition {
    /// `*`
    All,
    /// Players by name or number; none for `<<>>`.
    Players(Vec<Name>),
}

/// `filter(min, P=? [ F "done" ], x=0)`
#[derive(Clone, Debug, PartialEq)]
pub struct Filter {
    /// `min`, `+`, ... as written.
    pub operator: Name,
    /// What has a value in each state.
    pub operand: Box<Expr>,
    /// The states; all, if none are written.
    pub states: Option<Box<Expr>>,
}

/// A properties file, or a single property.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PropertyFile {
    /// Constants of this file.
    pub constants: Vec<Constant>,
    /// Formulas of this file.
    pub formulas: Vec<Formula>,
    /// Labels of this file.
    pub labels: Vec<Label>,
    /// Properties, in the order of the text.
    pub properties: Vec<Property>,
    /// Properties with syntax errors, in the order of the text.
    pub unread: Vec<UnreadProperty>,
}

impl PropertyFile {
    /// Whether something outside of properties could not be read, such as a label: then it is not known what they mean.
    pub fn has_errors_outside(&self, diagnostics: &[Diagnostic]) -> bool {
        let is_inside = |error: &Diagnostic| {
            let begun = (self.unread).partition_point(|p| p.span.start <= error.span.start);
            begun > 0 && self.unread[begun - 1].has(error)
        };
        diagnostics.iter().any(|d| d.is_error() && !is_inside(d))
    }
}

/// A property that could not be read; the others of its file can.
#[derive(Clone, Debug, PartialEq)]
pub struct UnreadProperty {
    /// Its place among all properties of the file, from 0.
    pub index: usize,
    /// Its name, if it has one.
    pub name: Option<Name>,
    /// What was skipped for it, verbatim (without the semicolon).
    pub text: String,
    /// From its beginning to that of what follows it.
    pub span: Span,
}

impl UnreadProperty {
    /// Whether a diagnostic is about this property.
    pub fn has(&self, diagnostic: &Diagnostic) -> bool {
        (self.span.start..self.span.end.max(self.span.start + 1)).contains(&diagnostic.span.start)
    }
}

/// `"name": P=? [ F "done" ];`
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// Its name, if it has one.
    pub name: Option<Name>,
    /// The formula.
    pub formula: Expr,
    /// The formula's source, verbatim (without name and semicolon).
    pub text: String,
    /// The formula's place.
    pub span: Span,
}
