//! Deterministic automata for formulas of linear temporal logic, built while they are walked.
//!
//! A formula is a Boolean combination of temporal parts. Each part becomes a deterministic
//! automaton of its own, and the automaton of the formula runs them side by side:
//!
//! * parts whose negation normal form (or that of their negation) has no unbounded until become
//!   safety (co-safety) automata;
//! * the others become parity automata.
//!
//! A word is accepted iff the combination of the parts' verdicts is true; a part accepts iff the
//! least priority that it shows infinitely often is even (odd, if the part was translated by its
//! negation). In a Markov chain this is decided for each bottom strongly connected component by the
//! set of its marks alone.
//!
//! ```
//! use temporal::automaton::Automaton;
//! use temporal::ltl::Ltl;
//!
//! // Every request (0) is followed by an answer (1).
//! let response = Ltl::globally(Ltl::implies(Ltl::Ap(0), Ltl::finally(Ltl::Ap(1))));
//! let mut automaton = Automaton::new(&response)?;
//! assert!(automaton.accepts_lasso(&[0b01, 0b00], &[0b10, 0b01])?);
//! assert!(!automaton.accepts_lasso(&[0b10], &[0b01])?);
//! # Ok::<(), temporal::automaton::AutomatonError>(())
//! ```

mod determinise;
mod safety;
mod tableau;

use std::fmt;

use rustc_hash::FxHashMap;

use crate::ltl::Ltl;
use determinise::ParityAutomaton;
use safety::SafetyAutomaton;
use tableau::Tableau;

/// Priority of a step in which nothing happens; odd and larger than all others.
const NEUTRAL_PRIORITY: u32 = u32::MAX;

/// How many states an automaton may have unless told otherwise.
pub const DEFAULT_STATE_LIMIT: usize = 1_000_000;

/// Why a formula has no automaton here.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum AutomatonError {
    /// An atomic proposition has a number above 63, so that letters do not fit 64 bits.
    TooManyPropositions {
        /// How many propositions the formula counts.
        propositions: usize,
    },
    /// A part has more than 64 unbounded untils.
    TooManyUntils {
        /// How many it has.
        untils: usize,
    },
    /// The walk reached more states than allowed.
    TooManyStates {
        /// The limit.
        limit: usize,
    },
}

impl fmt::Display for AutomatonError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooManyPropositions { propositions } => write!(
                formatter,
                "the formula has {propositions} atomic propositions, but at most 64 are supported; join state formulas into one proposition each"
            ),
            Self::TooManyUntils { untils } => write!(
                formatter,
                "one part of the formula has {untils} unbounded eventualities, but at most 64 are \
                 supported; split it into several properties"
            ),
            Self::TooManyStates { limit } => write!(
                formatter,
                "the automaton of the formula has more than {limit} states; shorten its step \
                 bounds or split it into several properties"
            ),
        }
    }
}

impl std::error::Error for AutomatonError {}

/// Which parts must accept.
#[derive(Debug, Clone)]
enum Combination {
    Constant(bool),
    Part(usize),
    Not(Box<Combination>),
    And(Box<Combination>, Box<Combination>),
    Or(Box<Combination>, Box<Combination>),
}

impl Combination {
    /// Kleene's three-valued truth: `None` where the parts do not decide.
    fn truth(&self, part: &impl Fn(usize) -> Option<bool>) -> Option<bool> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Part(index) => part(*index),
            Self::Not(inner) => inner.truth(part).map(|value| !value),
            Self::And(left, right) => match (left.truth(part), right.truth(part)) {
                (Some(false), _) | (_, Some(false)) => Some(false),
                (Some(true), Some(true)) => Some(true),
                _ => None,
            },
            Self::Or(left, right) => match (left.truth(part), right.truth(part)) {
                (Some(true), _) | (_, Some(true)) => Some(true),
                (Some(false), Some(false)) => Some(false),
                _ => None,
            },
        }
    }
}

#[derive(Debug, Clone)]
enum Engine {
    Safety(SafetyAutomaton),
    Parity(ParityAutomaton),
}

/// The automaton of one part, or of its negation.
#[derive(Debug, Clone)]
struct Part {
    engine: Engine,
    negated: bool,
    /// Bits of the propositions that occur.
    letters: u64,
    steps: FxHashMap<(u32, u64), (u32, u32)>,
}

impl Part {
    fn new(formula: &Ltl) -> Result<Self, AutomatonError> {
        let (plain, plain_start) = Tableau::new(formula, false)?;
        let (negation, negation_start) = Tableau::new(formula, true)?;
        let negated = negation.until_count() < plain.until_count();
        let (tableau, start) = if negated {
            (negation, negation_start)
        } else {
            (plain, plain_start)
        };
        let engine = if tableau.until_count() == 0 {
            Engine::Safety(SafetyAutomaton::new(tableau, start))
        } else {
            Engine::Parity(ParityAutomaton::new(tableau, start))
        };
        Ok(Self {
            engine,
            negated,
            letters: proposition_bits(formula),
            steps: FxHashMap::default(),
        })
    }

    fn step(
        &mut self,
        state: u32,
        letter: u64,
        state_limit: usize,
    ) -> Result<(u32, u32), AutomatonError> {
        let letter = letter & self.letters;
        if let Some(known) = self.steps.get(&(state, letter)) {
            return Ok(*known);
        }
        let step = match &mut self.engine {
            Engine::Safety(safety) => {
                let next = safety.step(state, letter, state_limit)?;
                (next, u32::from(safety.decided(next) == Some(false)))
            }
            Engine::Parity(parity) => parity.step(state, letter, state_limit)?,
        };
        self.steps.insert((state, letter), step);
        Ok(step)
    }

    fn decided(&self, state: u32) -> Option<bool> {
        let decided = match &self.engine {
            Engine::Safety(safety) => safety.decided(state),
            Engine::Parity(parity) => parity.decided(state),
        };
        decided.map(|value| value != self.negated)
    }

    fn accepts(&self, least_priority: u32) -> bool {
        (least_priority.is_multiple_of(2)) != self.negated
    }
}

fn proposition_bits(formula: &Ltl) -> u64 {
    match formula {
        Ltl::Ap(index) => 1 << (index & 63),
        _ => (formula.operands()).fold(0, |bits, operand| bits | proposition_bits(operand)),
    }
}

/// One step of an [`Automaton`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Step {
    /// The state reached.
    pub state: u32,
    /// What the step contributes to acceptance.
    pub mark: u32,
}

/// A deterministic, complete automaton over the letters `u64`, in which bit `i` is proposition `i`.
#[derive(Debug, Clone)]
pub struct Automaton {
    combination: Combination,
    parts: Vec<Part>,
    states: Interned,
    marks: Interned,
    steps: FxHashMap<(u32, u64), Step>,
    letters: u64,
    state_limit: usize,
}

/// Tuples of numbers, one per part.
#[derive(Debug, Clone, Default)]
struct Interned {
    tuples: Vec<Vec<u32>>,
    index: FxHashMap<Vec<u32>, u32>,
}

impl Interned {
    fn intern(&mut self, tuple: Vec<u32>) -> u32 {
        if let Some(id) = self.index.get(&tuple) {
            return *id;
        }
        let id = self.tuples.len() as u32;
        self.tuples.push(tuple.clone());
        self.index.insert(tuple, id);
        id
    }
}

impl Automaton {
    /// The automaton of `formula`, with [`DEFAULT_STATE_LIMIT`].
    ///
    /// # Errors
    /// When the formula has too many propositions or eventualities.
    pub fn new(formula: &Ltl) -> Result<Self, AutomatonError> {
        Self::with_state_limit(formula, DEFAULT_STATE_LIMIT)
    }

    /// The automaton of `formula`; no part and no combination may exceed `state_limit` states.
    ///
    /// # Errors
    /// When the formula has too many propositions or eventualities.
    pub fn with_state_limit(formula: &Ltl, state_limit: usize) -> Result<Self, AutomatonError> {
        let propositions = formula.ap_count();
        if propositions > 64 {
            return Err(AutomatonError::TooManyPropositions { propositions });
        }
        let mut leaves: Vec<Ltl> = Vec::new();
        let combination = decompose(&formula.simplify(), &mut leaves);
        let parts = leaves
            .iter()
            .map(Part::new)
            .collect::<Result<Vec<_>, _>>()?;
        let mut states = Interned::default();
        states.intern(vec![0; parts.len()]);
        Ok(Self {
            combination,
            letters: parts.iter().fold(0, |bits, part| bits | part.letters),
            parts,
            states,
            marks: Interned::default(),
            steps: FxHashMap::default(),
            state_limit,
        })
    }

    /// The state before the first letter.
    #[must_use]
    pub fn initial(&self) -> u32 {
        0
    }

    /// Reads one letter in a state that [`Self::initial`] or a step has given.
    ///
    /// # Errors
    /// When the automaton becomes too large.
    pub fn step(&mut self, state: u32, letter: u64) -> Result<Step, AutomatonError> {
        let letter = letter & self.letters;
        if let Some(known) = self.steps.get(&(state, letter)) {
            return Ok(*known);
        }
        let mut tuple = self.states.tuples[state as usize].clone();
        let mut priorities = Vec::with_capacity(tuple.len());
        for (part, state) in self.parts.iter_mut().zip(&mut tuple) {
            let (next, priority) = part.step(*state, letter, self.state_limit)?;
            *state = next;
            priorities.push(priority);
        }
        if !self.states.index.contains_key(&tuple) && self.states.tuples.len() >= self.state_limit {
            let limit = self.state_limit;
            return Err(AutomatonError::TooManyStates { limit });
        }
        let step = Step {
            state: self.states.intern(tuple),
            mark: self.marks.intern(priorities),
        };
        self.steps.insert((state, letter), step);
        Ok(step)
    }

    /// `Some(verdict)` when the words read from this state on cannot change the verdict. (`None` does
    /// not say that they can.)
    #[must_use]
    pub fn decided(&self, state: u32) -> Option<bool> {
        let tuple = &self.states.tuples[state as usize];
        (self.combination).truth(&|part| self.parts[part].decided(tuple[part]))
    }

    /// Whether a run that takes steps with exactly these marks infinitely often is accepting.
    ///
    /// In a bottom strongly connected component of a product with a Markov chain, these are the marks
    /// of all its transitions, with probability 1.
    #[must_use]
    pub fn accepts(&self, marks: impl IntoIterator<Item = u32>) -> bool {
        let mut least = vec![NEUTRAL_PRIORITY; self.parts.len()];
        for mark in marks {
            let priorities = &self.marks.tuples[mark as usize];
            (least.iter_mut().zip(priorities)).for_each(|(least, new)| *least = *new.min(least));
        }
        (self.combination)
            .truth(&|part| Some(self.parts[part].accepts(least[part])))
            .unwrap_or(false)
    }

    /// The priorities of a mark, one for each part: a part's verdict depends on the least that it shows
    /// infinitely often. Leaving out the steps with the least one of some part may change a rejecting set of
    /// marks to an accepting one.
    #[must_use]
    pub fn priorities(&self, mark: u32) -> &[u32] {
        &self.marks.tuples[mark as usize]
    }

    /// Whether the word `prefix cycle cycle ...` is accepted; an empty cycle is read as one empty letter.
    ///
    /// # Errors
    /// When the automaton becomes too large.
    pub fn accepts_lasso(&mut self, prefix: &[u64], cycle: &[u64]) -> Result<bool, AutomatonError> {
        let cycle = if cycle.is_empty() { &[0][..] } else { cycle };
        let mut state = self.initial();
        for letter in prefix {
            state = self.step(state, *letter)?.state;
        }
        // The states at the starts of the rounds repeat; the marks of one repetition decide.
        let mut rounds: Vec<(u32, Vec<u32>)> = Vec::new();
        loop {
            if let Some(first) = rounds.iter().position(|(start, _)| *start == state) {
                let marks = rounds[first..]
                    .iter()
                    .flat_map(|(_, marks)| marks.iter().copied());
                return Ok(self.accepts(marks));
            }
            let (start, mut marks) = (state, Vec::with_capacity(cycle.len()));
            for letter in cycle {
                let step = self.step(state, *letter)?;
                state = step.state;
                marks.push(step.mark);
            }
            rounds.push((start, marks));
        }
    }

    /// States built so far.
    #[must_use]
    pub fn state_count(&self) -> usize {
        self.states.tuples.len()
    }
}

/// The Boolean structure of `formula` above its temporal parts, which are collected in `leaves`.
fn decompose(formula: &Ltl, leaves: &mut Vec<Ltl>) -> Combination {
    match formula {
        Ltl::True => Combination::Constant(true),
        Ltl::False => Combination::Constant(false),
        Ltl::Not(inner) => Combination::Not(Box::new(decompose(inner, leaves))),
        Ltl::And(left, right) if !formula.is_propositional() => Combination::And(
            Box::new(decompose(left, leaves)),
            Box::new(decompose(right, leaves)),
        ),
        Ltl::Or(left, right) if !formula.is_propositional() => Combination::Or(
            Box::new(decompose(left, leaves)),
            Box::new(decompose(right, leaves)),
        ),
        _ => {
            let known = leaves.iter().position(|leaf| leaf == formula);
            Combination::Part(known.unwrap_or_else(|| {
                leaves.push(formula.clone());
                leaves.len() - 1
            }))
        }
    }
}
