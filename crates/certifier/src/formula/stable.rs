//! Linear temporal logic without restriction: what must be guessed of a path so that the rest is safe or co-safe.
//!
//! *Definition.* Let `mu` be the subformulas `l U r` of a formula `f` and `nu` those `l R r`, without bounds. `g[M]` is `g` with
//! each `l U r` of `M` made weak (`l W r`) and each other one false: safe. `g[N]` is `g` with each `l R r` of `N` made true
//! and each other one strong (`r U (l & r)`): co-safe. A word satisfies `f` iff for some `M` and `N`
//!
//! ```text
//! (1) after some letters, what remains of f, with [M], holds of the rest
//! (2) for each g of M    G F g[N]
//! (3) for each g of N    F G g[M]
//! ```
//!
//! Each is a machine that is marked infinitely often, or finitely often; (1) runs what remains beside the safe formula made of
//! it, and makes that anew, marked, whenever it has failed.
//!
//! Source: Esparza, Křetínský and Sickert 2018, "One Theorem to Rule Them All: A Unified Translation of LTL into
//! omega-Automata", theorem 4.4 and section 5. Deviation: bounded operators unfold like `X`, and are neither. Cost: a
//! machine for each `M`. Guarantee: exact.

use std::collections::BTreeSet;

use super::{Condition, Formula, Machine, Watched, too_large};
use crate::failure::Failure;

/// Most subformulas to guess about.
const MOST_GUESSES: usize = 10;
/// The greatest lower bound of steps that is unfolded.
const MOST_STEPS: u64 = 64;

impl Formula {
    /// With lower bounds of operators that have no upper ones unfolded.
    fn unfolded(&self) -> Result<Self, Failure> {
        let all = |of: &[Self]| of.iter().map(Self::unfolded).collect::<Result<Vec<_>, _>>();
        Ok(match self {
            Self::True | Self::False | Self::Set(..) => self.clone(),
            Self::And(of) => Self::And(all(of)?),
            Self::Or(of) => Self::Or(all(of)?),
            Self::Next(of) => Self::Next(Box::new(of.unfolded()?)),
            Self::Until(l, r, first, last) => {
                let (l, r) = (Box::new(l.unfolded()?), Box::new(r.unfolded()?));
                match last {
                    Some(last) => Self::Until(l, r, *first, Some(*last)),
                    None if *first > MOST_STEPS => return Err(too_large()),
                    None => {
                        let start = Self::Until(l.clone(), r, 0, None);
                        (0..*first).fold(start, |rest, _| {
                            Self::And(vec![(*l).clone(), Self::Next(Box::new(rest))])
                        })
                    }
                }
            }
            Self::Release(..) => self.negated().unfolded()?.negated(),
        })
    }

    /// The until and the release operators without bounds.
    fn unbounded(&self, mu: &mut BTreeSet<Self>, nu: &mut BTreeSet<Self>) {
        match self {
            Self::True | Self::False | Self::Set(..) => {}
            Self::And(of) | Self::Or(of) => of.iter().for_each(|f| f.unbounded(mu, nu)),
            Self::Next(of) => of.unbounded(mu, nu),
            Self::Until(l, r, _, last) | Self::Release(l, r, _, last) => {
                match (self, last) {
                    (Self::Until(..), None) => mu.insert(self.clone()),
                    (_, None) => nu.insert(self.clone()),
                    _ => false,
                };
                l.unbounded(mu, nu);
                r.unbounded(mu, nu);
            }
        }
    }

    /// `self[M]`: safe.
    pub(super) fn safe(&self, recurring: &BTreeSet<Self>) -> Self {
        let of = |f: &Self| f.safe(recurring);
        match self {
            Self::Until(l, r, _, None) => match recurring.contains(self) {
                true => {
                    let (l, r) = (of(l), of(r));
                    let waits = either(vec![l, r.clone()]);
                    Self::Release(Box::new(r), Box::new(waits), 0, None)
                }
                false => Self::False,
            },
            _ => self.map(&of),
        }
    }

    /// `self[N]`: co-safe.
    fn co_safe(&self, persisting: &BTreeSet<Self>) -> Self {
        let of = |f: &Self| f.co_safe(persisting);
        match self {
            Self::Release(l, r, _, None) => match persisting.contains(self) {
                true => Self::True,
                false => {
                    let (l, r) = (of(l), of(r));
                    let released = both(vec![l, r.clone()]);
                    Self::Until(Box::new(r), Box::new(released), 0, None)
                }
            },
            _ => self.map(&of),
        }
    }

    /// With its operands replaced.
    fn map(&self, of: &dyn Fn(&Self) -> Self) -> Self {
        match self {
            Self::True | Self::False | Self::Set(..) => self.clone(),
            Self::And(all) => both(all.iter().map(of).collect()),
            Self::Or(all) => either(all.iter().map(of).collect()),
            Self::Next(f) => match of(f) {
                constant @ (Self::True | Self::False) => constant,
                f => Self::Next(Box::new(f)),
            },
            Self::Until(l, r, first, last) => {
                Self::Until(Box::new(of(l)), Box::new(of(r)), *first, *last)
            }
            Self::Release(l, r, first, last) => {
                Self::Release(Box::new(of(l)), Box::new(of(r)), *first, *last)
            }
        }
    }
}

fn both(all: Vec<Formula>) -> Formula {
    if all.contains(&Formula::False) {
        return Formula::False;
    }
    let mut all: Vec<Formula> = all.into_iter().filter(|f| *f != Formula::True).collect();
    match (all.len(), all.pop()) {
        (1, Some(only)) => only,
        (_, Some(last)) => {
            all.push(last);
            Formula::And(all)
        }
        (_, None) => Formula::True,
    }
}

fn either(all: Vec<Formula>) -> Formula {
    both(all.iter().map(Formula::negated).collect()).negated()
}

/// The condition of any formula.
pub(super) fn condition(
    formula: &Formula,
    machines: &mut Vec<Machine>,
) -> Result<Condition, Failure> {
    let formula = formula.unfolded()?;
    let (mut mu, mut nu) = (BTreeSet::new(), BTreeSet::new());
    formula.unbounded(&mut mu, &mut nu);
    if mu.len() + nu.len() > MOST_GUESSES {
        return Err(too_large());
    }
    let mut guesses = Vec::new();
    for recurring in subsets(&mu) {
        let rest = Watched::Rest(formula.clone(), recurring.clone());
        let rest = Condition::NotAgain(Machine::among(machines, rest)?);
        for persisting in subsets(&nu) {
            let again = |f: Formula| {
                Watched::Always(Formula::Until(
                    Box::new(Formula::True),
                    Box::new(f),
                    0,
                    None,
                ))
            };
            let mut all = vec![rest.clone()];
            for f in &recurring {
                let watched = again(f.co_safe(&persisting));
                all.push(Condition::Again(Machine::among(machines, watched)?));
            }
            for f in &persisting {
                let watched = again(f.safe(&recurring).negated());
                all.push(Condition::NotAgain(Machine::among(machines, watched)?));
            }
            guesses.push(Condition::And(all));
        }
    }
    Ok(Condition::Or(guesses))
}

fn subsets(of: &BTreeSet<Formula>) -> Vec<BTreeSet<Formula>> {
    (0..1usize << of.len())
        .map(|chosen| {
            let members = of.iter().enumerate();
            let inside = members.filter(|(place, _)| chosen >> place & 1 == 1);
            inside.map(|(_, formula)| formula.clone()).collect()
        })
        .collect()
}
