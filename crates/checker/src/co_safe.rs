//! Deterministic automata of co-safe formulas, by progression: when has a path shown that the formula holds?
//!
//! *Definition.* What remains to be shown after some letters is a set of alternatives, each a set of obligations
//! (formulas that must hold from the next letter on). Reading a letter replaces every obligation by what the
//! letter leaves of it; when an alternative has none left, the formula holds, whatever follows. As in PRISM the
//! path must show this step by step: `X true` takes a step, although it always holds.
//!
//! Source: Bacchus and Kabanza 1998, "Planning for temporally extended goals" (progression); Kupferman and Vardi
//! 2001 (informative prefixes). Cost: each letter and state once; at worst doubly exponential in the formula.
//! Guarantee: exact.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;
use temporal::automaton::{AutomatonError, DEFAULT_STATE_LIMIT};
use temporal::ltl::{Ltl, StepBound};

use crate::answer::CheckError;
use crate::product::Reader;

/// A formula, or its negation if false.
type Obligation = (Ltl, bool);
type Alternatives = BTreeSet<BTreeSet<Obligation>>;

/// The automaton of a co-safe formula.
pub(crate) struct CoSafe {
    states: Vec<Alternatives>,
    index: FxHashMap<Vec<Vec<Obligation>>, u32>,
    steps: FxHashMap<(u32, u64), u32>,
    letters: u64,
}

impl CoSafe {
    pub fn new(formula: &Ltl) -> Result<Self, AutomatonError> {
        let propositions = formula.ap_count();
        if propositions > 64 {
            return Err(AutomatonError::TooManyPropositions { propositions });
        }
        let first = one((formula.clone(), true));
        let mut automaton = Self {
            states: Vec::new(),
            index: FxHashMap::default(),
            steps: FxHashMap::default(),
            letters: u64::MAX.checked_shr(64 - propositions as u32).unwrap_or(0),
        };
        automaton.intern(first);
        Ok(automaton)
    }

    fn intern(&mut self, state: Alternatives) -> u32 {
        let key: Vec<Vec<Obligation>> = state
            .iter()
            .map(|all| all.iter().cloned().collect())
            .collect();
        let next = self.states.len() as u32;
        let number = *self.index.entry(key).or_insert(next);
        if number == next {
            self.states.push(state);
        }
        number
    }
}

impl Reader for CoSafe {
    fn start(&self) -> u32 {
        0
    }

    fn read(&mut self, state: u32, letter: u64) -> Result<u32, CheckError> {
        let letter = letter & self.letters;
        if let Some(known) = self.steps.get(&(state, letter)) {
            return Ok(*known);
        }
        if self.states.len() >= DEFAULT_STATE_LIMIT {
            let limit = DEFAULT_STATE_LIMIT;
            return Err(CheckError::Automaton(AutomatonError::TooManyStates {
                limit,
            }));
        }
        let mut next = Alternatives::new();
        for obligations in &self.states[state as usize] {
            let left = obligations
                .iter()
                .fold(always(), |all, (formula, positive)| {
                    both(&all, &progress(formula, *positive, letter))
                });
            next = either(next, left);
        }
        let next = self.intern(next);
        self.steps.insert((state, letter), next);
        Ok(next)
    }

    fn verdict(&self, state: u32) -> Option<bool> {
        let alternatives = &self.states[state as usize];
        if alternatives.is_empty() {
            return Some(false);
        }
        alternatives.iter().any(BTreeSet::is_empty).then_some(true)
    }
}

fn always() -> Alternatives {
    Alternatives::from([BTreeSet::new()])
}

fn one(obligation: Obligation) -> Alternatives {
    Alternatives::from([BTreeSet::from([obligation])])
}

fn truth(holds: bool) -> Alternatives {
    if holds { always() } else { Alternatives::new() }
}

/// All of either; an alternative that asks for more than another is dropped.
fn either(mut a: Alternatives, b: Alternatives) -> Alternatives {
    a.extend(b);
    let all: Vec<_> = a.iter().cloned().collect();
    a.retain(|set| !all.iter().any(|other| other != set && other.is_subset(set)));
    a
}

fn both(a: &Alternatives, b: &Alternatives) -> Alternatives {
    let mut joined = Alternatives::new();
    for left in a {
        joined.extend(b.iter().map(|right| left.union(right).cloned().collect()));
    }
    either(joined, Alternatives::new())
}

/// What a letter leaves of a formula, or of its negation.
fn progress(formula: &Ltl, positive: bool, letter: u64) -> Alternatives {
    let join = |conjunction: bool, a: &Ltl, b: &Ltl| {
        let (a, b) = (progress(a, positive, letter), progress(b, positive, letter));
        if conjunction == positive {
            both(&a, &b)
        } else {
            either(a, b)
        }
    };
    match formula {
        Ltl::True => truth(positive),
        Ltl::False => truth(!positive),
        Ltl::Ap(index) => truth((letter >> index & 1 == 1) == positive),
        Ltl::Not(inner) => progress(inner, !positive, letter),
        Ltl::And(a, b) => join(true, a, b),
        Ltl::Or(a, b) => join(false, a, b),
        Ltl::Next(inner) => one((inner.as_ref().clone(), positive)),
        Ltl::Until(left, right, bound) => {
            let again = |bound| Ltl::Until(left.clone(), right.clone(), bound);
            window(
                (left, true),
                (right, true),
                *bound,
                (positive, letter),
                &again,
            )
        }
        Ltl::Release(left, right, bound) => {
            let again = |bound| Ltl::Release(left.clone(), right.clone(), bound);
            window(
                (left, false),
                (right, false),
                *bound,
                (!positive, letter),
                &again,
            )
        }
        Ltl::Finally(inner, bound) => {
            let again = |bound| Ltl::Finally(inner.clone(), bound);
            window(
                (&Ltl::True, true),
                (inner, true),
                *bound,
                (positive, letter),
                &again,
            )
        }
        Ltl::Globally(inner, bound) => {
            let again = |bound| Ltl::Globally(inner.clone(), bound);
            window(
                (&Ltl::True, true),
                (inner, false),
                *bound,
                (!positive, letter),
                &again,
            )
        }
        Ltl::WeakUntil(left, right, bound) => {
            let refused = Ltl::negate(right.as_ref().clone());
            let waiting = Ltl::and(left.as_ref().clone(), refused.clone());
            let given_up = Ltl::and(Ltl::negate(left.as_ref().clone()), refused);
            progress(
                &Ltl::until(waiting, given_up).within(*bound),
                !positive,
                letter,
            )
        }
    }
}

/// What a letter leaves of an until formula (`positive`) or of its negation; `again` is the formula that was
/// written, with another window. An operand is negated if its flag is false; so is then the formula.
fn window(
    (left, left_plain): (&Ltl, bool),
    (right, right_plain): (&Ltl, bool),
    bound: StepBound,
    (positive, letter): (bool, u64),
    again: &dyn Fn(StepBound) -> Ltl,
) -> Alternatives {
    if bound.is_empty() {
        return truth(!positive);
    }
    // Release and globally are negations: their own polarity is the other one.
    let plain = right_plain && left_plain;
    let goes_on = bound.upper != Some(0);
    let rest = || {
        let next = StepBound {
            lower: bound.lower.saturating_sub(1),
            upper: bound.upper.map(|upper| upper - 1),
        };
        one((again(next), positive == plain))
    };
    let now = |holds: bool| progress(right, right_plain == holds, letter);
    let before = |holds: bool| progress(left, left_plain == holds, letter);
    match positive {
        true => {
            let at_once = if bound.lower == 0 {
                now(true)
            } else {
                truth(false)
            };
            let later = if goes_on {
                both(&before(true), &rest())
            } else {
                truth(false)
            };
            either(at_once, later)
        }
        false => {
            let not_now = if bound.lower == 0 {
                now(false)
            } else {
                truth(true)
            };
            let not_later = if goes_on {
                either(before(false), rest())
            } else {
                truth(true)
            };
            both(&not_now, &not_later)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After how many letters the formula is shown to hold.
    fn shown(formula: &Ltl, word: &[u64]) -> Option<usize> {
        let mut automaton = CoSafe::new(formula).unwrap();
        let mut state = automaton.start();
        for (place, letter) in word.iter().enumerate() {
            state = automaton.read(state, *letter).unwrap();
            if automaton.verdict(state) == Some(true) {
                return Some(place + 1);
            }
        }
        None
    }

    #[test]
    fn formulas_are_shown_when_their_last_letter_is_read() {
        let (a, b) = (|| Ltl::Ap(0), || Ltl::Ap(1));
        assert_eq!(
            shown(&Ltl::next(Ltl::next(Ltl::True)), &[0, 0, 0, 0]),
            Some(3)
        );
        assert_eq!(shown(&Ltl::finally(b()), &[0, 1, 2]), Some(3));
        let until = Ltl::until(a(), b());
        assert_eq!(shown(&until, &[1, 1, 3]), Some(3));
        assert_eq!(shown(&until, &[1, 0, 2]), None);
        let both = Ltl::and(Ltl::finally(a()), Ltl::finally(b()));
        assert_eq!(shown(&both, &[0, 2, 0, 1]), Some(4));
        let safe = Ltl::negate(Ltl::globally(a()));
        assert_eq!(shown(&safe, &[1, 1, 0]), Some(3));
        let bounded = Ltl::globally(a()).within(StepBound::at_most(2));
        assert_eq!(shown(&bounded, &[1, 1, 1, 0]), Some(3));
        assert_eq!(shown(&bounded, &[1, 0, 1, 1]), None);
        let window = Ltl::finally(b()).within(StepBound::between(2, 3));
        assert_eq!(shown(&window, &[2, 2, 0, 2]), Some(4));
        let released = Ltl::negate(Ltl::release(a(), b()));
        assert_eq!(shown(&released, &[2, 2, 0]), Some(3));
        assert_eq!(shown(&released, &[2, 3, 0]), None);
        let weak = Ltl::negate(Ltl::weak_until(a(), b()));
        assert_eq!(shown(&weak, &[1, 1, 0]), Some(3));
    }
}
