//! Properties with all names resolved: PCTL* without rewards, over discrete steps.

pub use crate::ast::Comparison;
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
#[derive(Clone, Debug, PartialEq)]
pub enum Property {
    /// The probability of a path formula (bound `None`: `P=?`) or whether it meets a bound.
    Probability {
        /// The comparison and the bound; none for `=?`.
        bound: Option<(Comparison, Bound)>,
        /// The path formula.
        path: Path,
    },
    /// Whether a state formula holds.
    State(StateFormula),
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
    /// Whether the probability of a path formula meets a bound.
    Probability {
        /// The comparison and the bound.
        bound: (Comparison, Bound),
        /// The path formula.
        path: Box<Path>,
    },
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
