//! Linear temporal logic over numbered atomic propositions.
//!
//! Syntax, with `p` an atomic proposition and `B` a step bound `[l, h]` (`h` may be missing):
//!
//! ```text
//! phi ::= true | false | p | !phi | phi & phi | phi '|' phi
//!       | X phi | phi U_B phi | phi R_B phi | phi W_B phi | F_B phi | G_B phi
//! ```
//!
//! Semantics on an infinite word `w = w0 w1 ...` of valuations (Pnueli 1977; Baier and Katoen 2008,
//! section 5.1; the step bounds as in PRISM), where `w, i |= phi` is read "phi holds at position i":
//!
//! * `w, i |= X phi` iff `w, i+1 |= phi`;
//! * `w, i |= a U_[l,h] b` iff for some `k` in `[l, h]`: `w, i+k |= b`, and `w, i+j |= a` for all `j < k`;
//! * `a R_B b = !(!a U_B !b)`, `F_B a = true U_B a`, `G_B a = !F_B !a`;
//! * `a W_B b = !((a & !b) U_B (!a & !b))`, which without a bound is `(a U b) | G a`.
//!
//! [`Ltl::holds_on_lasso`] is this definition, executed on ultimately periodic words;
//! [`crate::automaton`] turns formulas into automata.

mod lasso;
mod simplify;

use std::fmt;

/// The steps at which an operator looks: from `lower` to `upper`, both included, relative to now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct StepBound {
    /// First step of the window.
    pub lower: u64,
    /// Last step of the window; `None` when there is no end.
    pub upper: Option<u64>,
}

impl StepBound {
    /// All steps from now on.
    pub const UNBOUNDED: Self = Self {
        lower: 0,
        upper: None,
    };

    /// The steps `0..=upper`.
    #[must_use]
    pub const fn at_most(upper: u64) -> Self {
        Self {
            lower: 0,
            upper: Some(upper),
        }
    }

    /// The steps `lower..=upper`.
    #[must_use]
    pub const fn between(lower: u64, upper: u64) -> Self {
        Self {
            lower,
            upper: Some(upper),
        }
    }

    /// Whether the window is all steps.
    #[must_use]
    pub fn is_unbounded(&self) -> bool {
        *self == Self::UNBOUNDED
    }

    /// Whether the window has no steps.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.upper.is_some_and(|upper| upper < self.lower)
    }
}

/// A formula of linear temporal logic; atomic propositions are numbers.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Ltl {
    /// Holds everywhere.
    True,
    /// Holds nowhere.
    False,
    /// Atomic proposition with this number.
    Ap(usize),
    /// Negation.
    Not(Box<Ltl>),
    /// Conjunction.
    And(Box<Ltl>, Box<Ltl>),
    /// Disjunction.
    Or(Box<Ltl>, Box<Ltl>),
    /// At the next step.
    Next(Box<Ltl>),
    /// The left holds until the right does, and the right does within the window.
    Until(Box<Ltl>, Box<Ltl>, StepBound),
    /// Dual of until: the right holds throughout the window, unless the left has released it.
    Release(Box<Ltl>, Box<Ltl>, StepBound),
    /// Until that does not insist on the right ever holding.
    WeakUntil(Box<Ltl>, Box<Ltl>, StepBound),
    /// At some step of the window.
    Finally(Box<Ltl>, StepBound),
    /// At all steps of the window.
    Globally(Box<Ltl>, StepBound),
}

/// Constructors. Those of the temporal operators have no bound; [`Ltl::within`] sets one.
impl Ltl {
    /// `!inner`, where a double negation vanishes.
    #[must_use]
    pub fn negate(inner: Ltl) -> Ltl {
        match inner {
            Ltl::True => Ltl::False,
            Ltl::False => Ltl::True,
            Ltl::Not(inner) => *inner,
            other => Ltl::Not(Box::new(other)),
        }
    }

    /// `left & right`.
    #[must_use]
    pub fn and(left: Ltl, right: Ltl) -> Ltl {
        Ltl::And(Box::new(left), Box::new(right))
    }

    /// `left | right`.
    #[must_use]
    pub fn or(left: Ltl, right: Ltl) -> Ltl {
        Ltl::Or(Box::new(left), Box::new(right))
    }

    /// `left => right`.
    #[must_use]
    pub fn implies(left: Ltl, right: Ltl) -> Ltl {
        Ltl::or(Ltl::negate(left), right)
    }

    /// `left <=> right`.
    #[must_use]
    pub fn iff(left: Ltl, right: Ltl) -> Ltl {
        Ltl::or(
            Ltl::and(left.clone(), right.clone()),
            Ltl::and(Ltl::negate(left), Ltl::negate(right)),
        )
    }

    /// `X inner`.
    #[must_use]
    pub fn next(inner: Ltl) -> Ltl {
        Ltl::Next(Box::new(inner))
    }

    /// `left U right`.
    #[must_use]
    pub fn until(left: Ltl, right: Ltl) -> Ltl {
        Ltl::Until(Box::new(left), Box::new(right), StepBound::UNBOUNDED)
    }

    /// `left R right`.
    #[must_use]
    pub fn release(left: Ltl, right: Ltl) -> Ltl {
        Ltl::Release(Box::new(left), Box::new(right), StepBound::UNBOUNDED)
    }

    /// `left W right`.
    #[must_use]
    pub fn weak_until(left: Ltl, right: Ltl) -> Ltl {
        Ltl::WeakUntil(Box::new(left), Box::new(right), StepBound::UNBOUNDED)
    }

    /// `F inner`.
    #[must_use]
    pub fn finally(inner: Ltl) -> Ltl {
        Ltl::Finally(Box::new(inner), StepBound::UNBOUNDED)
    }

    /// `G inner`.
    #[must_use]
    pub fn globally(inner: Ltl) -> Ltl {
        Ltl::Globally(Box::new(inner), StepBound::UNBOUNDED)
    }

    /// The same formula with the window of its outermost operator replaced; formulas whose
    /// outermost operator has no window are returned unchanged.
    #[must_use]
    pub fn within(self, bound: StepBound) -> Ltl {
        match self {
            Ltl::Until(left, right, _) => Ltl::Until(left, right, bound),
            Ltl::Release(left, right, _) => Ltl::Release(left, right, bound),
            Ltl::WeakUntil(left, right, _) => Ltl::WeakUntil(left, right, bound),
            Ltl::Finally(inner, _) => Ltl::Finally(inner, bound),
            Ltl::Globally(inner, _) => Ltl::Globally(inner, bound),
            other => other,
        }
    }

    /// The operands, none to two.
    pub fn operands(&self) -> impl Iterator<Item = &Ltl> {
        let (first, second) = match self {
            Ltl::True | Ltl::False | Ltl::Ap(_) => (None, None),
            Ltl::Not(inner)
            | Ltl::Next(inner)
            | Ltl::Finally(inner, _)
            | Ltl::Globally(inner, _) => (Some(inner.as_ref()), None),
            Ltl::And(left, right)
            | Ltl::Or(left, right)
            | Ltl::Until(left, right, _)
            | Ltl::Release(left, right, _)
            | Ltl::WeakUntil(left, right, _) => (Some(left.as_ref()), Some(right.as_ref())),
        };
        first.into_iter().chain(second)
    }

    /// Whether no temporal operator occurs, so that the truth at a position depends on its
    /// valuation alone.
    #[must_use]
    pub fn is_propositional(&self) -> bool {
        match self {
            Ltl::True | Ltl::False | Ltl::Ap(_) => true,
            Ltl::Not(_) | Ltl::And(..) | Ltl::Or(..) => self.operands().all(Ltl::is_propositional),
            _ => false,
        }
    }

    /// One more than the largest number of an atomic proposition, 0 when there is none.
    #[must_use]
    pub fn ap_count(&self) -> usize {
        match self {
            Ltl::Ap(index) => index.saturating_add(1),
            _ => self.operands().map(Ltl::ap_count).max().unwrap_or(0),
        }
    }
}

impl fmt::Display for StepBound {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.lower, self.upper) {
            (0, None) => Ok(()),
            (0, Some(upper)) => write!(formatter, "<={upper}"),
            (lower, None) => write!(formatter, ">={lower}"),
            (lower, Some(upper)) => write!(formatter, "[{lower},{upper}]"),
        }
    }
}

/// Every operand that is not atomic is in parentheses; proposition 3 is printed `p3`.
impl fmt::Display for Ltl {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ltl::True => formatter.write_str("true"),
            Ltl::False => formatter.write_str("false"),
            Ltl::Ap(index) => write!(formatter, "p{index}"),
            Ltl::Not(inner) => write!(formatter, "!{}", Operand(inner)),
            Ltl::And(left, right) => write!(formatter, "{} & {}", Operand(left), Operand(right)),
            Ltl::Or(left, right) => write!(formatter, "{} | {}", Operand(left), Operand(right)),
            Ltl::Next(inner) => write!(formatter, "X {}", Operand(inner)),
            Ltl::Until(left, right, bound) => {
                write!(formatter, "{} U{bound} {}", Operand(left), Operand(right))
            }
            Ltl::Release(left, right, bound) => {
                write!(formatter, "{} R{bound} {}", Operand(left), Operand(right))
            }
            Ltl::WeakUntil(left, right, bound) => {
                write!(formatter, "{} W{bound} {}", Operand(left), Operand(right))
            }
            Ltl::Finally(inner, bound) => write!(formatter, "F{bound} {}", Operand(inner)),
            Ltl::Globally(inner, bound) => write!(formatter, "G{bound} {}", Operand(inner)),
        }
    }
}

/// A formula printed as an operand.
struct Operand<'a>(&'a Ltl);

impl fmt::Display for Operand<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Ltl::True | Ltl::False | Ltl::Ap(_) => self.0.fmt(formatter),
            _ => write!(formatter, "({})", self.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_bounds_and_parentheses() {
        let formula = Ltl::globally(Ltl::implies(
            Ltl::Ap(0),
            Ltl::finally(Ltl::Ap(1)).within(StepBound::at_most(5)),
        ));
        assert_eq!(formula.to_string(), "G ((!p0) | (F<=5 p1))");
        let bound = StepBound::between(2, 7);
        let formula = Ltl::until(Ltl::Ap(0), Ltl::Ap(1)).within(bound);
        assert_eq!(formula.to_string(), "p0 U[2,7] p1");
    }

    #[test]
    fn counts_propositions() {
        assert_eq!(Ltl::True.ap_count(), 0);
        assert_eq!(Ltl::or(Ltl::Ap(4), Ltl::Ap(1)).ap_count(), 5);
    }
}
