//! Path formulas with one temporal operator, which are solved on the model itself.

use prism_lang::{Path, StateFormula, TimeBound};
use temporal::ltl::{Ltl, StepBound};

use crate::answer::CheckError;
use crate::evaluate::NESTED;

/// A path formula that is solved without an automaton; `contrary` says that it is the negation that was asked.
#[derive(Debug, Clone)]
pub(crate) enum Shape {
    /// True of paths that start in these states.
    Set(Vec<bool>),
    /// In the next step.
    Next { operand: Vec<bool>, contrary: bool },
    /// `left U right` within steps.
    Until {
        left: Vec<bool>,
        right: Vec<bool>,
        steps: (u64, Option<u64>),
        contrary: bool,
    },
}

/// The shape of a formula over sets of states, if it has at most one temporal operator.
pub(crate) fn shape(formula: &Ltl, sets: &[Vec<bool>], states: usize) -> Option<Shape> {
    let set = |formula: &Ltl| (formula.is_propositional()).then(|| holds(formula, sets, states));
    if let Some(holds) = set(formula) {
        return Some(Shape::Set(holds));
    }
    let until = |left: Option<Vec<bool>>, right: Option<Vec<bool>>, bound: &StepBound, contrary| {
        Some(Shape::Until {
            left: left?,
            right: right?,
            steps: (bound.lower, bound.upper),
            contrary,
        })
    };
    let everything = || Some(vec![true; states]);
    match formula {
        Ltl::Not(inner) => shape(inner, sets, states).map(Shape::negated),
        Ltl::Next(inner) => {
            let operand = set(inner)?;
            Some(Shape::Next {
                operand,
                contrary: false,
            })
        }
        Ltl::Until(left, right, bound) => until(set(left), set(right), bound, false),
        Ltl::Finally(inner, bound) => until(everything(), set(inner), bound, false),
        Ltl::Globally(inner, bound) => until(everything(), set(inner).map(negation), bound, true),
        Ltl::Release(left, right, bound) => until(
            set(left).map(negation),
            set(right).map(negation),
            bound,
            true,
        ),
        Ltl::WeakUntil(left, right, bound) => {
            let (left, right) = (set(left)?, set(right)?);
            let (waiting, given_up) = weak(&left, &right);
            until(Some(waiting), Some(given_up), bound, true)
        }
        _ => None,
    }
}

/// `!(left W right)` is `waiting U given_up`.
pub(crate) fn weak(left: &[bool], right: &[bool]) -> (Vec<bool>, Vec<bool>) {
    let pairs = || left.iter().zip(right);
    let waiting = pairs().map(|(left, right)| *left && !right).collect();
    let given_up = pairs().map(|(left, right)| !left && !right).collect();
    (waiting, given_up)
}

impl Shape {
    fn negated(self) -> Self {
        match self {
            Self::Set(set) => Self::Set(negation(set)),
            Self::Next { operand, contrary } => Self::Next {
                operand,
                contrary: !contrary,
            },
            Self::Until {
                left,
                right,
                steps,
                contrary,
            } => Self::Until {
                left,
                right,
                steps,
                contrary: !contrary,
            },
        }
    }
}

/// Reads a path formula over the sets of its state subformulas, which are collected.
pub(crate) fn read_path(
    path: &Path,
    sets: &mut Vec<Vec<bool>>,
    states: &mut dyn FnMut(&StateFormula) -> Result<Vec<bool>, CheckError>,
) -> Result<Ltl, CheckError> {
    let window = |bound: &TimeBound| StepBound {
        lower: bound.first_step(),
        upper: bound.last_step(),
    };
    let mut read = |path: &Path| read_path(path, sets, states);
    Ok(match path {
        Path::State(formula) => proposition(states(formula)?, sets),
        Path::Not(inner) => Ltl::negate(read(inner)?),
        Path::And(left, right) => Ltl::and(read(left)?, read(right)?),
        Path::Or(left, right) => Ltl::or(read(left)?, read(right)?),
        Path::Implies(left, right) => Ltl::implies(read(left)?, read(right)?),
        Path::Iff(left, right) => Ltl::iff(read(left)?, read(right)?),
        Path::Next(inner) => Ltl::next(read(inner)?),
        Path::Until { left, right, bound } => {
            Ltl::until(read(left)?, read(right)?).within(window(bound))
        }
        Path::WeakUntil { left, right, bound } => {
            Ltl::weak_until(read(left)?, read(right)?).within(window(bound))
        }
        Path::Release { left, right, bound } => {
            Ltl::release(read(left)?, read(right)?).within(window(bound))
        }
        Path::Finally { operand, bound } => Ltl::finally(read(operand)?).within(window(bound)),
        Path::Globally { operand, bound } => Ltl::globally(read(operand)?).within(window(bound)),
        Path::Timed { .. } => {
            return Err(CheckError::Unsupported(NESTED.to_owned()));
        }
    })
}

/// The atomic proposition of a set of states; equal sets are one proposition.
fn proposition(set: Vec<bool>, sets: &mut Vec<Vec<bool>>) -> Ltl {
    if set.iter().all(|holds| *holds) {
        return Ltl::True;
    }
    if !set.contains(&true) {
        return Ltl::False;
    }
    let known = sets.iter().position(|known| *known == set);
    Ltl::Ap(known.unwrap_or_else(|| {
        sets.push(set);
        sets.len() - 1
    }))
}

/// The states in which a formula without temporal operators holds.
pub(crate) fn holds(formula: &Ltl, sets: &[Vec<bool>], states: usize) -> Vec<bool> {
    let pairs = |left: &Ltl, right: &Ltl, operator: fn(bool, bool) -> bool| {
        let (left, right) = (holds(left, sets, states), holds(right, sets, states));
        left.into_iter()
            .zip(right)
            .map(|(l, r)| operator(l, r))
            .collect()
    };
    match formula {
        Ltl::Ap(index) => sets[*index].clone(),
        Ltl::Not(inner) => negation(holds(inner, sets, states)),
        Ltl::And(left, right) => pairs(left, right, |l, r| l & r),
        Ltl::Or(left, right) => pairs(left, right, |l, r| l | r),
        // Only constants are left: the caller has excluded temporal operators.
        other => vec![*other == Ltl::True; states],
    }
}

pub(crate) fn negation(mut set: Vec<bool>) -> Vec<bool> {
    set.iter_mut().for_each(|holds| *holds = !*holds);
    set
}

/// One letter for each state: bit `i` is set where the set `i` holds. (Automata refuse more than 64.)
pub(crate) fn letters(sets: &[Vec<bool>], states: usize) -> Vec<u64> {
    let mut letters = vec![0; states];
    for (bit, set) in sets.iter().take(64).enumerate() {
        for (letter, holds) in letters.iter_mut().zip(set) {
            *letter |= u64::from(*holds) << bit;
        }
    }
    letters
}
