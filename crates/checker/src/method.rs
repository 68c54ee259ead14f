//! The methods by name, and what each of them guarantees.
//!
//! | method | answers with |
//! |---|---|
//! | sound, policy iteration, linear equations | bounds that contain the value, rounding included |
//! | exact | the value |
//! | value iteration, Gauss-Seidel, Jacobi, modified policy iteration, PRISM's default | an estimate, of whose error nothing is known |
//!
//! A method by name is for the equations of what may take for ever; what happens within steps or a time is followed
//! by all methods alike ([`crate::steps`], [`crate::transient`]), and so are questions of the graph alone.

/// How values are computed, and thereby what is known of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Floating point with bounds that hold, rounding included: the fastest way that gives them.
    #[default]
    Sound,
    /// PRISM's default: Jacobi iteration that stops when values hardly change. An estimate, for
    /// reproducing published figures.
    PrismDefault,
    /// Rational arithmetic.
    Exact,
    /// Value iteration (the power method, in chains), stopped when values hardly change. An estimate.
    ValueIteration,
    /// Value iteration state by state in place, stopped when values hardly change. An estimate.
    GaussSeidel,
    /// Value iteration with self-loops divided out, stopped when values hardly change. An estimate.
    Jacobi,
    /// A scheduler is followed for some rounds between two improvements; stopped when an improvement hardly changes
    /// anything. An estimate.
    ModifiedPolicyIteration,
    /// The chain of each scheduler is solved by elimination, until no choice is better by more than rounding. The
    /// bounds are shown to hold, rounding included.
    PolicyIteration,
    /// Chains are solved by elimination without subtraction. The bounds allow for its rounding.
    LinearEquations,
}

impl Method {
    /// All of them.
    pub const ALL: [Method; 9] = [
        Method::Sound,
        Method::PrismDefault,
        Method::Exact,
        Method::ValueIteration,
        Method::GaussSeidel,
        Method::Jacobi,
        Method::ModifiedPolicyIteration,
        Method::PolicyIteration,
        Method::LinearEquations,
    ];

    /// Whether its answers are estimates: it stops when values hardly change, which does not bound their error.
    pub fn is_estimate(self) -> bool {
        !matches!(
            self,
            Self::Sound | Self::Exact | Self::PolicyIteration | Self::LinearEquations
        )
    }

    /// Whether chains are solved by elimination alone, whatever it costs.
    pub(crate) fn is_direct(self) -> bool {
        matches!(self, Self::PolicyIteration | Self::LinearEquations)
    }

    /// What the field calls it.
    pub(crate) fn term(self) -> &'static str {
        match self {
            Self::Sound => "bounds from below and above",
            Self::Exact => "rational arithmetic",
            Self::PrismDefault | Self::Jacobi => "Jacobi iteration",
            Self::ValueIteration => "value iteration",
            Self::GaussSeidel => "Gauss-Seidel iteration",
            Self::ModifiedPolicyIteration => "modified policy iteration",
            Self::PolicyIteration => "policy iteration",
            Self::LinearEquations => "linear equations",
        }
    }
}

/// By which change an iteration without bounds stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Termination {
    /// By how much values change relatively.
    #[default]
    Relative,
    /// By how much values change.
    Absolute,
}

impl Termination {
    /// The change of a value that is not negative; not a number (hence no change) where both are 0.
    pub(crate) fn change(self, old: f64, new: f64) -> f64 {
        match self {
            Self::Relative => (new - old).abs() / new,
            Self::Absolute => (new - old).abs(),
        }
    }

    /// In a message.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Relative => "relative",
            Self::Absolute => "absolute",
        }
    }
}
