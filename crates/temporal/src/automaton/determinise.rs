//! From the tableau of any formula to a deterministic parity automaton, built while it is walked.
//!
//! *Büchi automaton.* A state is a set of obligations and a counter `k` of untils: a transition
//! advances `k` past each until it does not put off, and is accepting when `k` passes the last one
//! (degeneralisation; Giannakopoulou and Lerda 2002, on transitions).
//!
//! *Determinisation.* A deterministic state gives each reachable Büchi state a path of nested
//! *braces*, outermost first: brace `b` around a state says that it was reached, since `b` was
//! opened, by a run with an accepting transition. Braces are numbered from the oldest, 0, which
//! holds all states. On a letter:
//!
//! 1. each transition carries the path of its source; if it is accepting, a new brace is opened
//!    inside (one for all states with the same path);
//! 2. a state reached twice keeps the better path: at the first difference the older brace, else
//!    the longer path;
//! 3. a brace around which every state sits in an inner brace is *green*: since it was opened, or was
//!    last green, all its runs have passed an accepting transition. The braces inside are removed;
//! 4. a brace without states is *dead*; the others are renumbered without gaps, in order of age.
//!
//! The priority of the step is the least of `2 b + 1` for dead `b` and `2 b + 2` for green `b`, and a
//! large odd number if there is none. (A number is only reused after its brace, or an older one, died, so
//! the dead must outrank the green.) A word is accepted iff the least priority seen infinitely often
//! is even: then some brace lives for ever and is green infinitely often, and by König's lemma some run
//! has infinitely many accepting transitions.
//!
//! Source: Safra 1988; Piterman 2007 (parity, renumbering); Redziejowski 2012 (braces). Deviations: the
//! letter is given, so no transition is computed that is not walked; a state in which some obligations
//! are empty accepts everything and is replaced by one accepting sink.
//!
//! Cost: `2^O(n log n)` states for `n` Büchi states at worst. Guarantee: exact.

use rustc_hash::FxHashMap;

use super::tableau::{Obligations, Tableau};
use super::{AutomatonError, NEUTRAL_PRIORITY};

/// A Büchi state: obligations and the until that is waited for.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct BuchiState {
    obligations: Obligations,
    waiting_for: u32,
}

/// Büchi states, each with the path of its braces, sorted by state. Empty: rejecting sink.
type Paths = Vec<(u32, Vec<u32>)>;

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum State {
    /// Everything from here on is accepted.
    Accepting,
    Open(Paths),
}

/// A deterministic parity automaton.
#[derive(Debug, Clone)]
pub(super) struct ParityAutomaton {
    tableau: Tableau,
    buchi_states: Vec<BuchiState>,
    buchi_index: FxHashMap<BuchiState, u32>,
    buchi_moves: FxHashMap<(u32, u64), Vec<(u32, bool)>>,
    states: Vec<State>,
    index: FxHashMap<State, u32>,
}

impl ParityAutomaton {
    /// State 0 is the initial one.
    pub fn new(tableau: Tableau, start: Obligations) -> Self {
        let mut automaton = Self {
            tableau,
            buchi_states: Vec::new(),
            buchi_index: FxHashMap::default(),
            buchi_moves: FxHashMap::default(),
            states: Vec::new(),
            index: FxHashMap::default(),
        };
        let state = if automaton.tableau.is_false(&start) {
            State::Open(Vec::new())
        } else if start.is_empty() {
            State::Accepting
        } else {
            let buchi = automaton.intern_buchi(start, 0);
            State::Open(vec![(buchi, vec![0])])
        };
        automaton.intern(state);
        automaton
    }

    fn intern(&mut self, state: State) -> u32 {
        if let Some(id) = self.index.get(&state) {
            return *id;
        }
        let id = self.states.len() as u32;
        self.states.push(state.clone());
        self.index.insert(state, id);
        id
    }

    fn intern_buchi(&mut self, obligations: Obligations, waiting_for: u32) -> u32 {
        let state = BuchiState {
            obligations,
            waiting_for,
        };
        if let Some(id) = self.buchi_index.get(&state) {
            return *id;
        }
        let id = self.buchi_states.len() as u32;
        self.buchi_states.push(state.clone());
        self.buchi_index.insert(state, id);
        id
    }

    /// Successors of a Büchi state, each with whether the transition is accepting.
    fn buchi_successors(&mut self, state: u32, letter: u64) -> Vec<(u32, bool)> {
        if let Some(known) = self.buchi_moves.get(&(state, letter)) {
            return known.clone();
        }
        let BuchiState {
            obligations,
            waiting_for,
        } = self.buchi_states[state as usize].clone();
        let moves = self.tableau.successors(&obligations, letter);
        let mut successors = Vec::with_capacity(moves.len());
        for step in moves {
            let (next, accepting) = advance(waiting_for, step.put_off, self.tableau.until_count());
            successors.push((self.intern_buchi(step.obligations, next), accepting));
        }
        self.buchi_moves.insert((state, letter), successors.clone());
        successors
    }

    /// The state after reading `letter`, and the priority of the step.
    pub fn step(
        &mut self,
        state: u32,
        letter: u64,
        state_limit: usize,
    ) -> Result<(u32, u32), AutomatonError> {
        let paths = match &self.states[state as usize] {
            State::Accepting => return Ok((state, 0)),
            State::Open(paths) if paths.is_empty() => return Ok((state, 1)),
            State::Open(paths) => paths.clone(),
        };
        let brace_count = paths
            .iter()
            .flat_map(|(_, path)| path)
            .max()
            .map_or(0, |b| b + 1);
        let mut next = self.carry(&paths, brace_count, letter);
        let requires_nothing =
            |(buchi, _): &(u32, _)| self.buchi_states[*buchi as usize].obligations.is_empty();
        let (next, priority) = if next.iter().any(requires_nothing) {
            (State::Accepting, 0)
        } else {
            let priority = settle(&mut next, brace_count);
            (State::Open(next), priority)
        };
        if !self.index.contains_key(&next) && self.states.len() >= state_limit {
            return Err(AutomatonError::TooManyStates { limit: state_limit });
        }
        Ok((self.intern(next), priority))
    }

    /// Rules 1 and 2: follow all transitions, open braces, keep the better paths.
    fn carry(&mut self, paths: &Paths, brace_count: u32, letter: u64) -> Paths {
        let mut opened: FxHashMap<u32, u32> = FxHashMap::default();
        let mut best: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
        for (source, path) in paths {
            for (target, accepting) in self.buchi_successors(*source, letter) {
                let mut candidate = path.clone();
                if accepting {
                    let fresh = brace_count + opened.len() as u32;
                    // A node of the tree is known by its innermost brace.
                    let innermost = path.last().copied().unwrap_or(0);
                    candidate.push(*opened.entry(innermost).or_insert(fresh));
                }
                match best.get_mut(&target) {
                    Some(known) if !is_better(&candidate, known) => {}
                    Some(known) => *known = candidate,
                    None => {
                        best.insert(target, candidate);
                    }
                }
            }
        }
        let mut next: Paths = best.into_iter().collect();
        next.sort_unstable();
        next
    }

    /// Whether the words from here on are all accepted (`Some(true)`) or all rejected.
    pub fn decided(&self, state: u32) -> Option<bool> {
        match &self.states[state as usize] {
            State::Accepting => Some(true),
            State::Open(paths) if paths.is_empty() => Some(false),
            State::Open(_) => None,
        }
    }
}

/// The counter after a transition that puts off `put_off`, and whether it passed the last until.
fn advance(waiting_for: u32, put_off: u64, untils: u32) -> (u32, bool) {
    let mut next = waiting_for;
    while next < untils && put_off >> next & 1 == 0 {
        next += 1;
    }
    if next < untils {
        return (next, false);
    }
    (0, true)
}

/// Whether path `a` is preferred to path `b`.
fn is_better(a: &[u32], b: &[u32]) -> bool {
    match a.iter().zip(b).find(|(a, b)| a != b) {
        Some((a, b)) => a < b,
        None => a.len() > b.len(),
    }
}

/// Rules 3 and 4: remove what is inside green braces, renumber, and find the priority.
fn settle(paths: &mut Paths, old_braces: u32) -> u32 {
    let highest = paths
        .iter()
        .flat_map(|(_, path)| path)
        .max()
        .map_or(0, |b| b + 1);
    let braces = highest.max(old_braces) as usize;
    let (mut alive, mut innermost) = (vec![false; braces], vec![false; braces]);
    for (_, path) in paths.iter() {
        path.iter().for_each(|brace| alive[*brace as usize] = true);
        path.last()
            .iter()
            .for_each(|brace| innermost[**brace as usize] = true);
    }
    let green = |brace: u32| alive[brace as usize] && !innermost[brace as usize];
    for (_, path) in paths.iter_mut() {
        if let Some(position) = path.iter().position(|brace| green(*brace)) {
            path.truncate(position + 1);
        }
    }
    let events = (0..old_braces).filter_map(|brace| match alive[brace as usize] {
        true => green(brace).then_some(2 * brace + 2),
        false => Some(2 * brace + 1),
    });
    let priority = events.min().unwrap_or(NEUTRAL_PRIORITY);
    renumber(paths, braces);
    priority
}

/// Gives the braces in use the numbers 0, 1, ... in their order.
fn renumber(paths: &mut Paths, braces: usize) {
    let mut used = vec![false; braces];
    for brace in paths.iter().flat_map(|(_, path)| path) {
        used[*brace as usize] = true;
    }
    let mut next = 0;
    let numbers: Vec<u32> = (used.into_iter())
        .map(|used| {
            let number = next;
            next += u32::from(used);
            number
        })
        .collect();
    for brace in paths.iter_mut().flat_map(|(_, path)| path) {
        *brace = numbers[*brace as usize];
    }
}
