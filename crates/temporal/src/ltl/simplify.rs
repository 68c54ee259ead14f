//! Equivalences that make formulas smaller before they become automata.
//!
//! Applied bottom-up, once; `a`, `b` any formulas, `p`, `q` without temporal operators:
//!
//! * constants: `F true = true`, `a U false = false`, `X true = true`, and so on for each operator;
//! * idempotence: `F F a = F a`, `G G a = G a`, `F G F a = G F a`, `G F G a = F G a`;
//! * absorption: `F (a U b) = F b`, `G (a R b) = G b`;
//! * joining what needs one automaton state anyway: `F p | F q = F (p | q)`, `G p & G q = G (p & q)`;
//! * splitting what needs two: `F (a | b) = F a | F b`, `G (a & b) = G a & G b` when an operand is
//!   temporal, so that each part becomes its own, smaller automaton;
//! * `F_B a`, `G_B a`, `W` without a bound are rewritten to `U`, `R` by the automaton, not here.
//!
//! Source: Baier and Katoen 2008, section 5.1.4, and Etessami and Holzmann 2000, section 3. Each
//! rule is an equivalence, which the tests check on all short words.

use super::{Ltl, StepBound};

impl Ltl {
    /// An equivalent formula, usually smaller.
    ///
    /// ```
    /// use temporal::ltl::Ltl;
    /// let verbose = Ltl::finally(Ltl::finally(Ltl::until(Ltl::Ap(0), Ltl::Ap(1))));
    /// assert_eq!(verbose.simplify(), Ltl::finally(Ltl::Ap(1)));
    /// ```
    #[must_use]
    pub fn simplify(&self) -> Ltl {
        match self {
            Ltl::True | Ltl::False | Ltl::Ap(_) => self.clone(),
            Ltl::Not(inner) => Ltl::negate(inner.simplify()),
            Ltl::And(left, right) => conjunction(left.simplify(), right.simplify()),
            Ltl::Or(left, right) => disjunction(left.simplify(), right.simplify()),
            Ltl::Next(inner) => match inner.simplify() {
                constant @ (Ltl::True | Ltl::False) => constant,
                inner => Ltl::next(inner),
            },
            Ltl::Until(left, right, bound) => until(left.simplify(), right.simplify(), *bound),
            Ltl::Release(left, right, bound) => release(left.simplify(), right.simplify(), *bound),
            Ltl::WeakUntil(left, right, bound) => {
                weak_until(left.simplify(), right.simplify(), *bound)
            }
            Ltl::Finally(inner, bound) => finally(inner.simplify(), *bound),
            Ltl::Globally(inner, bound) => globally(inner.simplify(), *bound),
        }
    }
}

const ALL: StepBound = StepBound::UNBOUNDED;

fn conjunction(left: Ltl, right: Ltl) -> Ltl {
    match (left, right) {
        (Ltl::False, _) | (_, Ltl::False) => Ltl::False,
        (Ltl::True, other) | (other, Ltl::True) => other,
        (left, right) if left == right => left,
        (Ltl::Globally(a, ALL), Ltl::Globally(b, ALL))
            if a.is_propositional() && b.is_propositional() =>
        {
            globally(conjunction(*a, *b), ALL)
        }
        (left, right) => Ltl::and(left, right),
    }
}

fn disjunction(left: Ltl, right: Ltl) -> Ltl {
    match (left, right) {
        (Ltl::True, _) | (_, Ltl::True) => Ltl::True,
        (Ltl::False, other) | (other, Ltl::False) => other,
        (left, right) if left == right => left,
        (Ltl::Finally(a, ALL), Ltl::Finally(b, ALL))
            if a.is_propositional() && b.is_propositional() =>
        {
            finally(disjunction(*a, *b), ALL)
        }
        (left, right) => Ltl::or(left, right),
    }
}

fn until(left: Ltl, right: Ltl, bound: StepBound) -> Ltl {
    match (left, right) {
        _ if bound.is_empty() => Ltl::False,
        (_, Ltl::False) => Ltl::False,
        (_, Ltl::True) if bound.lower == 0 => Ltl::True,
        (Ltl::False, right) if bound.lower == 0 => right,
        (Ltl::True, right) => finally(right, bound),
        (left, right) => Ltl::Until(Box::new(left), Box::new(right), bound),
    }
}

fn release(left: Ltl, right: Ltl, bound: StepBound) -> Ltl {
    match (left, right) {
        _ if bound.is_empty() => Ltl::True,
        (_, Ltl::True) => Ltl::True,
        (_, Ltl::False) if bound.lower == 0 => Ltl::False,
        (Ltl::True, right) if bound.lower == 0 => right,
        (Ltl::False, right) => globally(right, bound),
        (left, right) => Ltl::Release(Box::new(left), Box::new(right), bound),
    }
}

fn weak_until(left: Ltl, right: Ltl, bound: StepBound) -> Ltl {
    match (left, right) {
        _ if bound.is_empty() => Ltl::True,
        (Ltl::True, _) | (_, Ltl::True) => Ltl::True,
        (left, Ltl::False) if bound.is_unbounded() => globally(left, bound),
        (left, right) => Ltl::WeakUntil(Box::new(left), Box::new(right), bound),
    }
}

fn finally(inner: Ltl, bound: StepBound) -> Ltl {
    if bound.is_empty() {
        return Ltl::False;
    }
    match inner {
        constant @ (Ltl::True | Ltl::False) => constant,
        inner if !bound.is_unbounded() => Ltl::Finally(Box::new(inner), bound),
        Ltl::Finally(inner, ALL) => Ltl::finally(*inner),
        Ltl::Until(_, right, ALL) => finally(*right, ALL),
        Ltl::Globally(inner, ALL) if matches!(*inner, Ltl::Finally(_, ALL)) => {
            Ltl::globally(*inner)
        }
        Ltl::Or(left, right) if !(left.is_propositional() && right.is_propositional()) => {
            disjunction(finally(*left, ALL), finally(*right, ALL))
        }
        inner => Ltl::finally(inner),
    }
}

fn globally(inner: Ltl, bound: StepBound) -> Ltl {
    if bound.is_empty() {
        return Ltl::True;
    }
    match inner {
        constant @ (Ltl::True | Ltl::False) => constant,
        inner if !bound.is_unbounded() => Ltl::Globally(Box::new(inner), bound),
        Ltl::Globally(inner, ALL) => Ltl::globally(*inner),
        Ltl::Release(_, right, ALL) => globally(*right, ALL),
        Ltl::Finally(inner, ALL) if matches!(*inner, Ltl::Globally(_, ALL)) => Ltl::finally(*inner),
        Ltl::And(left, right) if !(left.is_propositional() && right.is_propositional()) => {
            conjunction(globally(*left, ALL), globally(*right, ALL))
        }
        inner => Ltl::globally(inner),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_and_joins() {
        let (a, b) = (|| Ltl::Ap(0), || Ltl::Ap(1));
        let joined = Ltl::globally(Ltl::or(Ltl::finally(a()), Ltl::finally(b())));
        assert_eq!(
            joined.simplify(),
            Ltl::globally(Ltl::finally(Ltl::or(a(), b())))
        );
        let split = Ltl::globally(Ltl::and(Ltl::finally(a()), Ltl::finally(b())));
        assert_eq!(
            split.simplify(),
            Ltl::and(
                Ltl::globally(Ltl::finally(a())),
                Ltl::globally(Ltl::finally(b()))
            )
        );
    }

    #[test]
    fn an_empty_window_decides() {
        let empty = StepBound::between(3, 2);
        assert_eq!(
            Ltl::finally(Ltl::Ap(0)).within(empty).simplify(),
            Ltl::False
        );
        assert_eq!(
            Ltl::globally(Ltl::Ap(0)).within(empty).simplify(),
            Ltl::True
        );
    }
}
