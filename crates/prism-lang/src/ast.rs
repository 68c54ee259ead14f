//! Syntax trees as written: nothing is resolved, every node knows its place.
//!
//! Trees are compared with spans. Parentheses
//! leave no node: the printer puts them where precedence needs them.

mod composition;
mod property;

pub use composition::{Observables, System, SystemExpr, SystemKind};
pub use property::{
    Coalition, Comparison, Filter, Optimum, Property, PropertyFile, Quantifier, Reward,
    RewardIndex, RewardObjective, StateFilter, StepBound, Strategy, TemporalOp, UnreadProperty,
};

use crate::diagnostic::Span;

/// A name and its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// The identifier.
    pub text: String,
    /// Its place.
    pub span: Span,
}

/// The type of a constant, variable or expression.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    /// `bool`.
    Bool,
    /// `int`.
    Int,
    /// `double`.
    Double,
}

impl Type {
    /// The keyword of this type.
    pub fn keyword(self) -> &'static str {
        match self {
            Self::Bool => "bool",
            Self::Int => "int",
            Self::Double => "double",
        }
    }
}

/// The kind of a model, by its keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ModelType {
    /// Discrete-time Markov chain (`dtmc`, `probabilistic`).
    Dtmc,
    /// Markov decision process (`mdp`, `nondeterministic`); also what PRISM assumes without a keyword, if there are probabilities.
    Mdp,
    /// Continuous-time Markov chain (`ctmc`, `stochastic`).
    Ctmc,
    /// Probabilistic timed automaton (`pta`).
    Pta,
    /// Partially observable Markov decision process (`pomdp`).
    Pomdp,
    /// Partially observable probabilistic timed automaton (`popta`).
    Popta,
}

impl ModelType {
    /// The keyword of this kind.
    pub fn keyword(self) -> &'static str {
        match self {
            Self::Dtmc => "dtmc",
            Self::Mdp => "mdp",
            Self::Ctmc => "ctmc",
            Self::Pta => "pta",
            Self::Pomdp => "pomdp",
            Self::Popta => "popta",
        }
    }
}

/// A whole model file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The model type and the place of its keyword, if one is given.
    pub model_type: Option<(ModelType, Span)>,
    /// Constants, in the order of the text.
    pub constants: Vec<Constant>,
    /// Formulas, in the order of the text.
    pub formulas: Vec<Formula>,
    /// Labels, in the order of the text.
    pub labels: Vec<Label>,
    /// Global variables, in the order of the text.
    pub globals: Vec<Variable>,
    /// Modules, written out or renamed, in the order of the text.
    pub modules: Vec<Module>,
    /// Reward structures, in the order of the text.
    pub rewards: Vec<RewardStructure>,
    /// The predicate of `init ... endinit`.
    pub init: Option<Expr>,
    /// How the modules are composed, where that is written.
    pub systems: Vec<System>,
    /// What can be observed, in a partially observable model.
    pub observables: Vec<Observables>,
}

/// `const double p = 0.5;`
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Its name.
    pub name: Name,
    /// Its declared type (`int` if none is written).
    pub ty: Type,
    /// Its definition; without one it must be given a value from outside.
    pub value: Option<Expr>,
    /// The whole declaration.
    pub span: Span,
}

/// `formula busy = x > 0;`
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    /// Its name.
    pub name: Name,
    /// Its definition.
    pub body: Expr,
    /// The whole declaration.
    pub span: Span,
}

/// `label "done" = x = 3;`
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// Its name, without quotes.
    pub name: Name,
    /// Its definition.
    pub body: Expr,
    /// The whole declaration.
    pub span: Span,
}

/// The declared range of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum VariableRange {
    /// `bool`.
    Bool,
    /// `[low..high]`, both included.
    Int {
        /// Smallest value.
        low: Box<Expr>,
        /// Largest value.
        high: Box<Expr>,
    },
    /// `int`, without bounds.
    Unbounded,
    /// `clock`.
    Clock,
}

/// `x : [0..3] init 0;`
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Its name.
    pub name: Name,
    /// Its range.
    pub range: VariableRange,
    /// Its initial value, if written.
    pub init: Option<Expr>,
    /// The whole declaration.
    pub span: Span,
}

/// A module, written out or as a renamed copy.
#[derive(Clone, Debug, PartialEq)]
pub struct Module {
    /// Its name.
    pub name: Name,
    /// What it consists of.
    pub body: ModuleBody,
    /// The whole module.
    pub span: Span,
}

/// What a module consists of.
#[derive(Clone, Debug, PartialEq)]
pub enum ModuleBody {
    /// Variables and commands.
    Written {
        /// Local variables.
        variables: Vec<Variable>,
        /// The invariant of a timed automaton, if written.
        invariant: Option<Expr>,
        /// Commands.
        commands: Vec<Command>,
    },
    /// `module copy = base [a=b, c=d] endmodule`.
    Renamed {
        /// The module that is copied.
        base: Name,
        /// Old and new names.
        renames: Vec<(Name, Name)>,
    },
}

/// `[act] guard -> 0.5:(x'=1) + 0.5:(x'=2);`
#[derive(Clone, Debug, PartialEq)]
pub struct Command {
    /// The action, if one is written between the brackets.
    pub action: Option<Name>,
    /// The guard.
    pub guard: Expr,
    /// The updates.
    pub updates: Vec<Update>,
    /// The whole command.
    pub span: Span,
}

/// `0.5:(x'=1)&(y'=2)`
#[derive(Clone, Debug, PartialEq)]
pub struct Update {
    /// Its probability (or rate, or an interval of probabilities); 1 if none is written.
    pub probability: Option<Expr>,
    /// Its assignments; none for `true`.
    pub assignments: Vec<Assignment>,
    /// The whole update.
    pub span: Span,
}

/// `(x'=x+1)`
#[derive(Clone, Debug, PartialEq)]
pub struct Assignment {
    /// The variable, without its prime.
    pub variable: Name,
    /// Its next value.
    pub value: Expr,
    /// The whole assignment.
    pub span: Span,
}

/// `rewards "time" ... endrewards`
#[derive(Clone, Debug, PartialEq)]
pub struct RewardStructure {
    /// Its name, if it has one.
    pub name: Option<Name>,
    /// Its items.
    pub items: Vec<RewardItem>,
    /// The whole structure.
    pub span: Span,
}

/// One line of a reward structure.
#[derive(Clone, Debug, PartialEq)]
pub struct RewardItem {
    /// What earns the reward.
    pub kind: RewardKind,
    /// Where it is earned.
    pub guard: Expr,
    /// How much.
    pub value: Expr,
    /// The whole item.
    pub span: Span,
}

/// What earns a reward.
#[derive(Clone, Debug, PartialEq)]
pub enum RewardKind {
    /// Being in a state.
    State,
    /// Leaving a state by a transition: `[]` (no action) or `[act]`.
    Transition(Option<Name>),
}

/// An expression, in a model or in a property.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Its place, without surrounding parentheses.
    pub span: Span,
}

/// The kinds of expressions.
#[derive(Clone, Debug, PartialEq)]
pub enum ExprKind {
    /// `true`, `false`.
    Bool(bool),
    /// `42`.
    Int(i64),
    /// `0.5`, `1e-3`: the literal as written.
    Double(String),
    /// A constant, variable or formula.
    Name(String),
    /// `"done"`: a label or, in a property, another property.
    Label(String),
    /// An operator before its operand.
    Unary(UnaryOp, Box<Expr>),
    /// An operator between its operands.
    Binary(BinaryOp, Box<Expr>, Box<Expr>),
    /// `condition ? then : otherwise`.
    IfThenElse(Box<Expr>, Box<Expr>, Box<Expr>),
    /// `min(a, b)`, also written `func(min, a, b)`: the name as written.
    Call(Name, Vec<Expr>),
    /// `[0.1,0.2]`: an interval, as the probability of an update.
    Interval(Box<Expr>, Box<Expr>),
    /// `P=? [ path ]`, `Pmax=? [ path ]`, `P>=0.5 [ path ]`, `P=? [ path || condition ]`.
    Probability {
        /// `min`, `max`, ...
        optimum: Option<Optimum>,
        /// The comparison and the bound; none for `=?`.
        bound: Option<(Comparison, Box<Expr>)>,
        /// The path formula.
        path: Box<Expr>,
        /// What is given, behind `||`, if written.
        condition: Option<Box<Expr>>,
        /// The old form of a filter, if written.
        filter: Option<Box<StateFilter>>,
    },
    /// `R=? [ F "done" ]`, ...
    Reward(Box<Reward>),
    /// `S=? [ "up" ]`, `S>=0.9 [ "up" ]`.
    LongRun {
        /// The comparison and the bound; none for `=?`.
        bound: Option<(Comparison, Box<Expr>)>,
        /// The states whose share of time is asked for.
        states: Box<Expr>,
        /// The old form of a filter, if written.
        filter: Option<Box<StateFilter>>,
    },
    /// `A [ path ]`, `E [ path ]`.
    Quantified(Quantifier, Box<Expr>),
    /// `<<...>> ...`, `[[...]] ...`.
    Strategy(Strategy),
    /// `filter(...)`.
    Filter(Filter),
    /// `F a`, `a U<=3 b`, ...
    Temporal {
        /// The operator.
        operator: TemporalOp,
        /// Its bound in steps or time, if written.
        bound: Option<Box<StepBound>>,
        /// The operand before the operator (`U`, `W`, `R`).
        left: Option<Box<Expr>>,
        /// The operand behind the operator.
        right: Box<Expr>,
    },
    /// What could not be understood; a diagnostic says why.
    Error,
}

/// Operators with one operand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum UnaryOp {
    /// `!`
    Not,
    /// `-`
    Minus,
}

/// Operators with two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BinaryOp {
    /// `=>`
    Implies,
    /// `<=>`
    Iff,
    /// `|`
    Or,
    /// `&`
    And,
    /// `=`
    Equal,
    /// `!=`
    NotEqual,
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
    /// `+`
    Plus,
    /// `-`
    Minus,
    /// `*`
    Times,
    /// `/` (always a real number)
    Divide,
    /// `^`
    Power,
}

impl BinaryOp {
    /// The operator as written.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Implies => "=>",
            Self::Iff => "<=>",
            Self::Or => "|",
            Self::And => "&",
            Self::Equal => "=",
            Self::NotEqual => "!=",
            Self::Less => "<",
            Self::LessEqual => "<=",
            Self::Greater => ">",
            Self::GreaterEqual => ">=",
            Self::Plus => "+",
            Self::Minus => "-",
            Self::Times => "*",
            Self::Divide => "/",
            Self::Power => "^",
        }
    }
}
