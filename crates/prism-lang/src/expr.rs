//! Expressions with all names resolved and types known.

use crate::ast::{BinaryOp, Type, UnaryOp};
use crate::diagnostic::Span;
use crate::number::Number;

/// The index of a variable in [`crate::resolved::Model::variables`] and in a state.
pub type VarIndex = usize;

/// A typed expression over the variables of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Its type.
    pub ty: Type,
    /// Its place in the text it comes from (a formula's own place, where a formula was inlined).
    pub span: Span,
}

/// The kinds of resolved expressions.
///
/// Operands of comparisons and arithmetic may mix `int` and `double`; the result's type is in [`Expr::ty`].
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// A truth value.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A real number.
    Double(Number),
    /// The value of a variable.
    Variable(VarIndex),
    /// A constant that was left open: the index in [`crate::resolved::Model::parameters`].
    Parameter(usize),
    /// An operator before its operand.
    Unary(UnaryOp, Box<Expr>),
    /// An operator between its operands.
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
    /// `condition ? then : otherwise`; only the chosen branch is evaluated.
    IfThenElse(Box<Expr>, Box<Expr>, Box<Expr>),
    /// A built-in function.
    Call(Function, Vec<Expr>),
}

/// Built-in functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Function {
    /// Least of one or more numbers.
    Min,
    /// Greatest of one or more numbers.
    Max,
    /// Largest integer not above.
    Floor,
    /// Smallest integer not below.
    Ceil,
    /// Nearest integer; halves go up.
    Round,
    /// Power: an integer if both arguments are.
    Pow,
    /// Remainder of integers, never negative for a positive divisor.
    Mod,
    /// `log(x, b)`: logarithm of `x` to base `b`.
    Log,
}

impl Function {
    /// All functions.
    pub const ALL: [Self; 8] = [
        Self::Min,
        Self::Max,
        Self::Floor,
        Self::Ceil,
        Self::Round,
        Self::Pow,
        Self::Mod,
        Self::Log,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Min => "min",
            Self::Max => "max",
            Self::Floor => "floor",
            Self::Ceil => "ceil",
            Self::Round => "round",
            Self::Pow => "pow",
            Self::Mod => "mod",
            Self::Log => "log",
        }
    }

    /// The function of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.name() == name)
    }

    /// The type of its result for arguments that are all `int`, or not.
    pub(crate) fn result(self, arguments: Type) -> Type {
        match self {
            Self::Floor | Self::Ceil | Self::Round | Self::Mod => Type::Int,
            Self::Log => Type::Double,
            _ => arguments,
        }
    }

    /// Least and greatest number of arguments (`None`: any).
    pub fn arity(self) -> (usize, Option<usize>) {
        match self {
            Self::Min | Self::Max => (1, None),
            Self::Floor | Self::Ceil | Self::Round => (1, Some(1)),
            Self::Pow | Self::Mod | Self::Log => (2, Some(2)),
        }
    }
}

impl Expr {
    /// The expression `true` or `false`, at this place.
    pub fn bool(value: bool, span: Span) -> Self {
        Self {
            kind: ExprKind::Bool(value),
            ty: Type::Bool,
            span,
        }
    }

    /// An integer literal, at this place.
    pub fn int(value: i64, span: Span) -> Self {
        Self {
            kind: ExprKind::Int(value),
            ty: Type::Int,
            span,
        }
    }

    /// A real literal, at this place.
    pub fn double(value: Number, span: Span) -> Self {
        Self {
            kind: ExprKind::Double(value),
            ty: Type::Double,
            span,
        }
    }

    /// Whether no variable and no parameter occurs.
    pub fn is_constant(&self) -> bool {
        let is_open = matches!(self.kind, ExprKind::Variable(_) | ExprKind::Parameter(_));
        !is_open && self.operands().into_iter().all(Self::is_constant)
    }

    /// Whether some parameter occurs.
    pub fn has_parameters(&self) -> bool {
        matches!(self.kind, ExprKind::Parameter(_))
            || self.operands().into_iter().any(Self::has_parameters)
    }

    /// The variables that occur, ascending, each once.
    pub fn variables(&self) -> Vec<VarIndex> {
        let mut found = Vec::new();
        self.for_each_variable(&mut |v| found.push(v));
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The operands, in the order of the text.
    pub fn operands(&self) -> Vec<&Expr> {
        match &self.kind {
            ExprKind::Unary(_, a) => vec![a],
            ExprKind::Binary(_, a, b) => vec![a, b],
            ExprKind::IfThenElse(a, b, c) => vec![a, b, c],
            ExprKind::Call(_, arguments) => arguments.iter().collect(),
            _ => Vec::new(),
        }
    }

    fn for_each_variable(&self, visit: &mut impl FnMut(VarIndex)) {
        if let ExprKind::Variable(index) = self.kind {
            visit(index);
        }
        for operand in self.operands() {
            operand.for_each_variable(visit);
        }
    }
}
