//! Linear temporal logic by progression: deterministic machines whose states are what is still to be shown.
//!
//! *Definition.* A formula in negation normal form over sets of states. After a letter (which sets hold) what remains to be
//! shown of the rest of the path is again such a formula; as a positive combination of subformulas it has one shortest
//! disjunctive normal form, so there are finitely many. A *co-safe* formula (no release without bound) holds iff after
//! some letters nothing remains to be shown. `G f` of a co-safe `f` holds iff obligations are discharged infinitely often:
//! those begun since the last time that happened wait in a second formula (breakpoints).
//!
//! Formulas that are combinations of `f`, `G f` and their contraries with co-safe `f` are read as an acceptance condition
//! over such machines; others by guesses of what recurs and what persists ([`stable`]).
//!
//! Source: Esparza, Křetínský and Sickert 2016, "From LTL to deterministic automata", section 3 (progression, co-safety);
//! Miyano and Hayashi 1984 (breakpoints). Cost: exponential in the formula. Guarantee: exact. This is another
//! construction than the solver's, which determinises tableaux.

use std::collections::BTreeSet;

use rustc_hash::FxHashMap;

use crate::failure::Failure;
use crate::question::unsupported;

mod stable;

/// Most clauses of what remains, and most states of a machine.
const MOST_CLAUSES: usize = 512;
const MOST_STATES: usize = 20_000;

/// A formula in negation normal form; atomic ones are numbers of sets, which hold or do not.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Formula {
    True,
    False,
    Set(usize, bool),
    And(Vec<Formula>),
    Or(Vec<Formula>),
    Next(Box<Formula>),
    Until(Box<Formula>, Box<Formula>, u64, Option<u64>),
    Release(Box<Formula>, Box<Formula>, u64, Option<u64>),
}

/// Clauses of subformulas, of which all of one have to be shown.
type Remains = BTreeSet<BTreeSet<Formula>>;

impl Formula {
    pub fn negated(&self) -> Self {
        let all = |of: &[Self]| of.iter().map(Self::negated).collect();
        match self {
            Self::True => Self::False,
            Self::False => Self::True,
            Self::Set(set, holds) => Self::Set(*set, !holds),
            Self::And(of) => Self::Or(all(of)),
            Self::Or(of) => Self::And(all(of)),
            Self::Next(of) => Self::Next(Box::new(of.negated())),
            Self::Until(l, r, first, last) => {
                Self::Release(Box::new(l.negated()), Box::new(r.negated()), *first, *last)
            }
            Self::Release(l, r, first, last) => {
                Self::Until(Box::new(l.negated()), Box::new(r.negated()), *first, *last)
            }
        }
    }

    /// Whether it is decided by some letters, if it holds.
    fn is_co_safe(&self) -> bool {
        match self {
            Self::True | Self::False | Self::Set(..) => true,
            Self::And(of) | Self::Or(of) => of.iter().all(Self::is_co_safe),
            Self::Next(of) => of.is_co_safe(),
            Self::Until(l, r, ..) => l.is_co_safe() && r.is_co_safe(),
            Self::Release(l, r, _, last) => last.is_some() && l.is_co_safe() && r.is_co_safe(),
        }
    }

    fn always(&self) -> Option<&Self> {
        match self {
            Self::Release(l, r, 0, None) if **l == Self::False => Some(r),
            _ => None,
        }
    }

    fn sometime(&self) -> Option<&Self> {
        match self {
            Self::Until(l, r, 0, None) if **l == Self::True => Some(r),
            _ => None,
        }
    }

    /// Whether it speaks only of what happens for ever, so that `X`, `F` and `G` before it say nothing.
    fn is_of_the_end(&self) -> bool {
        match self {
            Self::And(of) | Self::Or(of) => of.iter().all(Self::is_of_the_end),
            Self::Next(of) => of.is_of_the_end(),
            _ => match (self.always(), self.sometime()) {
                (Some(of), _) => of.sometime().is_some() || of.is_of_the_end(),
                (_, Some(of)) => of.always().is_some() || of.is_of_the_end(),
                _ => false,
            },
        }
    }

    /// What remains to be shown before any letter.
    fn remains(&self) -> Result<Remains, Failure> {
        match self {
            Self::True => Ok(proved()),
            Self::False => Ok(Remains::new()),
            Self::And(of) => of
                .iter()
                .try_fold(proved(), |all, f| both(&all, &f.remains()?)),
            Self::Or(of) => of
                .iter()
                .try_fold(Remains::new(), |all, f| either(&all, &f.remains()?)),
            atom => Ok(Remains::from([BTreeSet::from([atom.clone()])])),
        }
    }

    /// What remains to be shown after a letter.
    fn after(&self, letter: u64) -> Result<Remains, Failure> {
        let later = |bound: Option<u64>| bound.map(|b| b.saturating_sub(1));
        match self {
            Self::True => Ok(proved()),
            Self::False => Ok(Remains::new()),
            Self::Set(set, holds) => Ok(match (letter >> set & 1 == 1) == *holds {
                true => proved(),
                false => Remains::new(),
            }),
            Self::And(of) => of
                .iter()
                .try_fold(proved(), |all, f| both(&all, &f.after(letter)?)),
            Self::Or(of) => of
                .iter()
                .try_fold(Remains::new(), |all, f| either(&all, &f.after(letter)?)),
            Self::Next(of) => of.remains(),
            Self::Until(l, r, first, last) => {
                if last.is_some_and(|last| last < *first) {
                    return Ok(Remains::new());
                }
                let waits = || {
                    let rest =
                        Self::Until(l.clone(), r.clone(), first.saturating_sub(1), later(*last));
                    both(&l.after(letter)?, &rest.remains()?)
                };
                match (first, last) {
                    (0, Some(0)) => r.after(letter),
                    (0, _) => either(&r.after(letter)?, &waits()?),
                    _ => waits(),
                }
            }
            Self::Release(l, r, first, last) => {
                if last.is_some_and(|last| last < *first) {
                    return Ok(proved());
                }
                let released = || {
                    let rest =
                        Self::Release(l.clone(), r.clone(), first.saturating_sub(1), later(*last));
                    either(&l.after(letter)?, &rest.remains()?)
                };
                match (first, last) {
                    (0, Some(0)) => r.after(letter),
                    (0, _) => both(&r.after(letter)?, &released()?),
                    _ => released(),
                }
            }
        }
    }
}

fn proved() -> Remains {
    Remains::from([BTreeSet::new()])
}

fn after(remains: &Remains, letter: u64) -> Result<Remains, Failure> {
    remains.iter().try_fold(Remains::new(), |all, clause| {
        let clause = clause
            .iter()
            .try_fold(proved(), |all, f| both(&all, &f.after(letter)?))?;
        either(&all, &clause)
    })
}

/// What remains, with each clause's formulas made safe.
fn made_safe(remains: &Remains, recurring: &BTreeSet<Formula>) -> Result<Remains, Failure> {
    remains.iter().try_fold(Remains::new(), |all, clause| {
        let clause = clause
            .iter()
            .try_fold(proved(), |all, f| both(&all, &f.safe(recurring).remains()?))?;
        either(&all, &clause)
    })
}

fn either(a: &Remains, b: &Remains) -> Result<Remains, Failure> {
    shortest(a.iter().chain(b).cloned().collect())
}

fn both(a: &Remains, b: &Remains) -> Result<Remains, Failure> {
    if a.len().saturating_mul(b.len()) > MOST_CLAUSES * MOST_CLAUSES {
        return Err(too_large());
    }
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| a | b));
    shortest(pairs.collect())
}

/// Without clauses that contain another one.
fn shortest(all: Remains) -> Result<Remains, Failure> {
    let kept: Remains = (all.iter())
        .filter(|clause| {
            !all.iter()
                .any(|less| less != *clause && less.is_subset(clause))
        })
        .cloned()
        .collect();
    if kept.len() > MOST_CLAUSES {
        return Err(too_large());
    }
    Ok(kept)
}

fn too_large() -> Failure {
    unsupported("a formula whose automaton is as large as this one's")
}

/// What a machine watches.
#[derive(Clone, Debug, PartialEq)]
enum Watched {
    /// A co-safe formula.
    Once(Formula),
    /// `G` of a co-safe formula.
    Always(Formula),
    /// What remains of a formula, made safe by which untils recur; marked where that has failed.
    Rest(Formula, BTreeSet<Formula>),
}

/// A deterministic machine: what remains to be shown now, what was begun meanwhile, and whether it is marked.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    watched: Watched,
    states: Vec<(Remains, Remains, bool)>,
    index: FxHashMap<(Remains, Remains, bool), usize>,
    steps: FxHashMap<(usize, u64), usize>,
}

impl Machine {
    fn new(watched: Watched) -> Result<Self, Failure> {
        let (start, beside) = match &watched {
            Watched::Once(formula) => (formula.remains()?, proved()),
            Watched::Always(_) => (proved(), proved()),
            Watched::Rest(formula, recurring) => {
                let start = formula.remains()?;
                let safe = made_safe(&start, recurring)?;
                (start, safe)
            }
        };
        let mut machine = Self {
            watched,
            states: Vec::new(),
            index: FxHashMap::default(),
            steps: FxHashMap::default(),
        };
        machine.enter((start, beside, false))?;
        Ok(machine)
    }

    /// The machine of a co-safe formula, marked where it holds; none for other formulas.
    pub fn once(formula: &Formula) -> Result<Option<Self>, Failure> {
        match formula.is_co_safe() {
            true => Self::new(Watched::Once(formula.clone())).map(Some),
            false => Ok(None),
        }
    }

    /// The place of the machine that watches this, new if there is none.
    fn among(machines: &mut Vec<Self>, watched: Watched) -> Result<usize, Failure> {
        if let Some(known) = machines.iter().position(|m| m.watched == watched) {
            return Ok(known);
        }
        machines.push(Self::new(watched)?);
        Ok(machines.len() - 1)
    }

    fn enter(&mut self, state: (Remains, Remains, bool)) -> Result<usize, Failure> {
        if let Some(known) = self.index.get(&state) {
            return Ok(*known);
        }
        if self.states.len() >= MOST_STATES {
            return Err(too_large());
        }
        self.index.insert(state.clone(), self.states.len());
        self.states.push(state);
        Ok(self.states.len() - 1)
    }

    /// The state after a letter; state 0 is before the first.
    pub fn step(&mut self, state: usize, letter: u64) -> Result<usize, Failure> {
        if let Some(known) = self.steps.get(&(state, letter)) {
            return Ok(*known);
        }
        let (now, begun, _) = self.states[state].clone();
        let next = match &self.watched {
            Watched::Once(_) => {
                let now = after(&now, letter)?;
                let holds = now == proved();
                (now, proved(), holds)
            }
            Watched::Always(formula) => {
                let now = after(&now, letter)?;
                let begun = both(&after(&begun, letter)?, &formula.after(letter)?)?;
                if now.is_empty() || begun.is_empty() {
                    (Remains::new(), Remains::new(), false)
                } else if now == proved() {
                    (begun, proved(), true)
                } else {
                    (now, begun, false)
                }
            }
            Watched::Rest(_, recurring) => {
                let now = after(&now, letter)?;
                let safe = after(&begun, letter)?;
                match safe.is_empty() {
                    true => {
                        let anew = made_safe(&now, recurring)?;
                        (now, anew, true)
                    }
                    false => (now, safe, false),
                }
            }
        };
        let next = self.enter(next)?;
        self.steps.insert((state, letter), next);
        Ok(next)
    }

    /// Whether a state is marked.
    pub fn is_marked(&self, state: usize) -> bool {
        self.states[state].2
    }
}

/// Which machines must be marked infinitely often.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Condition {
    Again(usize),
    NotAgain(usize),
    And(Vec<Condition>),
    Or(Vec<Condition>),
}

/// What must recur and what must not, together.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clause {
    pub again: Vec<usize>,
    pub not_again: Vec<usize>,
}

impl Condition {
    /// Reads a formula, if it is of the form.
    pub fn read(formula: &Formula, machines: &mut Vec<Machine>) -> Result<Self, Failure> {
        let mut add = |watched: Watched, marked: bool| {
            let place = Machine::among(machines, watched)?;
            Ok(match marked {
                true => Self::Again(place),
                false => Self::NotAgain(place),
            })
        };
        let contrary = formula.negated();
        if formula.is_co_safe() {
            return add(Watched::Once(formula.clone()), true);
        }
        if contrary.is_co_safe() {
            return add(Watched::Once(contrary), false);
        }
        if let Some(of) = formula.always() {
            if of.is_co_safe() {
                return add(Watched::Always(of.clone()), true);
            }
            if of.is_of_the_end() {
                return Self::read(of, machines);
            }
        }
        if let Some(of) = contrary.always() {
            if of.is_co_safe() {
                return add(Watched::Always(of.clone()), false);
            }
            if of.is_of_the_end() {
                return Self::read(&of.negated(), machines);
            }
        }
        let mut all = |of: &[Formula], around: &dyn Fn(&Formula) -> Formula| {
            of.iter()
                .map(|f| Self::read(&around(f), machines))
                .collect::<Result<Vec<_>, _>>()
        };
        let same = |f: &Formula| f.clone();
        let unbounded = |l, f: &Formula, until: bool| match until {
            true => Formula::Until(Box::new(l), Box::new(f.clone()), 0, None),
            false => Formula::Release(Box::new(l), Box::new(f.clone()), 0, None),
        };
        match formula {
            Formula::And(of) => return Ok(Self::And(all(of, &same)?)),
            Formula::Or(of) => return Ok(Self::Or(all(of, &same)?)),
            _ => {}
        }
        match (formula.always(), formula.sometime(), formula) {
            (Some(Formula::And(of)), ..) => {
                let around = |f: &Formula| unbounded(Formula::False, f, false);
                Ok(Self::And(all(of, &around)?))
            }
            (_, Some(Formula::Or(of)), _) => {
                let around = |f: &Formula| unbounded(Formula::True, f, true);
                Ok(Self::Or(all(of, &around)?))
            }
            (.., Formula::Next(inner)) => {
                let next = |f: &Formula| Formula::Next(Box::new(f.clone()));
                match (&**inner, inner.always(), inner.sometime()) {
                    (Formula::And(of), ..) => Ok(Self::And(all(of, &next)?)),
                    (Formula::Or(of), ..) => Ok(Self::Or(all(of, &next)?)),
                    (_, Some(of), _) => {
                        Self::read(&unbounded(Formula::False, &next(of), false), machines)
                    }
                    (_, _, Some(of)) => {
                        Self::read(&unbounded(Formula::True, &next(of), true), machines)
                    }
                    _ => stable::condition(formula, machines),
                }
            }
            _ => stable::condition(formula, machines),
        }
    }

    /// Its disjunctive normal form.
    pub fn clauses(&self) -> Vec<Clause> {
        let single = |again: Vec<usize>, not_again: Vec<usize>| vec![Clause { again, not_again }];
        match self {
            Self::Again(machine) => single(vec![*machine], Vec::new()),
            Self::NotAgain(machine) => single(Vec::new(), vec![*machine]),
            Self::Or(of) => of.iter().flat_map(Self::clauses).collect(),
            Self::And(of) => of.iter().fold(vec![Clause::default()], |all, next| {
                let next = next.clauses();
                let join = |a: &Clause, b: &Clause| Clause {
                    again: [&a.again[..], &b.again].concat(),
                    not_again: [&a.not_again[..], &b.not_again].concat(),
                };
                let pairs = all
                    .iter()
                    .flat_map(|a| next.iter().map(move |b| join(a, b)));
                pairs.collect()
            }),
        }
    }
}

#[cfg(test)]
mod tests;
