//! Several windows of time in one formula, in a chain with continuous time.
//!
//! *Definition.* A formula is a Boolean combination of operators `left U[a,b] right` between state formulas (the others
//! are their contraries) and of formulas without bounds. Between two neighbouring ends of windows nothing depends on the
//! time but for the chain, so there the chain, whether each window's operator is still open, has become true or has become
//! false ([`Status`]), and deterministic automata of the formulas without bounds are one chain. When a window begins, an
//! open operator becomes true in a state of `right` and false outside `left`; when it ends, false.
//!
//! *Method.* Forward, the reachable states of the joint chain in each segment of time ([`Process::unfold`]); after the
//! last end a bottom component accepts as a whole. Backward, the probabilities of acceptance, segment by segment
//! (`evaluate/windows.rs`).
//!
//! Source: the product with the statuses follows Donatelli, Haddad and Sproston 2009, "Model Checking Timed and Stochastic
//! Properties with CSL^TA", for windows that all begin to count at time 0, where no clock is ever reset; segments as in Baier,
//! Haverkort, Hermanns and Katoen 2003, section 4. Cost: in each segment linear in the states of the joint chain, at most
//! 3 to the number of windows times the states of chain and automata. Guarantee: exact.

use std::cmp::Ordering;

use prism_lang::{Arithmetic, Number};
use rustc_hash::FxHashMap;
use temporal::automaton::Automaton;

use crate::amount::Amount;
use crate::answer::{CheckError, Options};
use crate::graph::bottom_components;
use crate::rounding::Bounds;
use crate::state_space::Csr;

/// `left U[begin,end] right`, counted from the start.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Window {
    pub left: Vec<bool>,
    pub right: Vec<bool>,
    pub begin: Number,
    /// None if it has no end.
    pub end: Option<Number>,
}

/// A Boolean combination of windows and formulas without bounds, by their numbers.
#[derive(Debug, Clone)]
pub(crate) enum Condition {
    Window(usize),
    Untimed(usize),
    Not(Box<Condition>),
    And(Box<Condition>, Box<Condition>),
    Or(Box<Condition>, Box<Condition>),
}

impl Condition {
    /// Kleene's three-valued truth, of what is known of windows and of formulas without bounds.
    fn truth(
        &self,
        window: &impl Fn(usize) -> Option<bool>,
        untimed: &impl Fn(usize) -> Option<bool>,
    ) -> Option<bool> {
        let truth = |inner: &Self| inner.truth(window, untimed);
        let dominated = |a: &Self, b: &Self, by: bool| match (truth(a), truth(b)) {
            (Some(a), _) if a == by => Some(by),
            (_, Some(b)) if b == by => Some(by),
            (Some(_), Some(_)) => Some(!by),
            _ => None,
        };
        match self {
            Self::Window(number) => window(*number),
            Self::Untimed(number) => untimed(*number),
            Self::Not(inner) => truth(inner).map(|holds| !holds),
            Self::And(a, b) => dominated(a, b, false),
            Self::Or(a, b) => dominated(a, b, true),
        }
    }
}

/// Most windows whose statuses fit.
pub(crate) const MOST_WINDOWS: usize = 32;
/// The states of every segment in which the formula is known to be false, and true.
const SETTLED: [u32; 2] = [0, 1];

/// What is known of each window's operator, in two bits each: open (0), true (1) or false (2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Status(u64);

impl Status {
    fn of(self, window: usize) -> Option<bool> {
        match self.0 >> (2 * window) & 3 {
            0 => None,
            known => Some(known == 1),
        }
    }

    fn set(&mut self, window: usize, holds: bool) {
        self.0 |= (if holds { 1 } else { 2 }) << (2 * window);
    }
}

/// The chain's state, the windows' statuses, and the automata's states by their number.
type Key = (u32, Status, u32);

/// The joint chain between two neighbouring ends of windows, or from the last one on.
pub(crate) struct Segment<N> {
    /// The time it takes; none for the last one.
    pub length: Option<Bounds>,
    /// Rates; the first two states are those in which the formula is known to be false, and true.
    pub rates: Csr<N>,
    /// The states in which it is entered: from the states asked for, or from each state of the segment before.
    pub entered: Vec<u32>,
    states: Vec<Key>,
}

/// The formula over a chain.
pub(crate) struct Process<'a, N> {
    rates: &'a Csr<N>,
    windows: &'a [Window],
    condition: &'a Condition,
    automata: Vec<Automaton>,
    /// What the automata read in each state.
    letters: &'a [u64],
    /// States of the automata, by number; before the first letter they are in those of number 0.
    memories: Vec<Vec<u32>>,
    index: FxHashMap<Vec<u32>, u32>,
    /// After a letter.
    steps: FxHashMap<(u32, u64), u32>,
}

impl<'a, N: Arithmetic> Process<'a, N> {
    pub fn new(
        rates: &'a Csr<N>,
        windows: &'a [Window],
        condition: &'a Condition,
        automata: Vec<Automaton>,
        letters: &'a [u64],
    ) -> Self {
        let initial: Vec<u32> = automata.iter().map(Automaton::initial).collect();
        Self {
            rates,
            windows,
            condition,
            automata,
            letters,
            index: std::iter::once((initial.clone(), 0)).collect(),
            memories: vec![initial],
            steps: FxHashMap::default(),
        }
    }

    /// The segments of time, in order, of what is reachable from these states; and the states of the last one that belong to a
    /// bottom component in which the formula holds.
    pub fn unfold(
        &mut self,
        from: &[usize],
        options: &Options<'_>,
    ) -> Result<(Vec<Segment<N>>, Vec<bool>), CheckError> {
        let instants = instants(self.windows)?;
        let mut segments: Vec<Segment<N>> = Vec::new();
        for (place, start) in instants.iter().enumerate() {
            let entered = match segments.last() {
                None => self.first(from)?,
                Some(before) => {
                    let states = &before.states[SETTLED.len()..];
                    states.iter().map(|key| self.at(*key, start)).collect()
                }
            };
            let mut segment = self.segment(start, &entered, options)?;
            segment.length = instants.get(place + 1).map(|end| difference(start, end));
            if place > 0 {
                segment.entered.splice(0..0, SETTLED);
            }
            segments.push(segment);
        }
        let accepting = segments.last().map(|last| self.accepting(last));
        Ok((segments, accepting.transpose()?.unwrap_or_default()))
    }

    /// The joint states at time 0.
    fn first(&mut self, from: &[usize]) -> Result<Vec<Key>, CheckError> {
        let zero = Number::from_i64(0);
        let key = |state: &usize| {
            let mut status = Status(0);
            self.pass(&mut status, *state, &zero);
            let key = (*state as u32, status, self.read(0, *state)?);
            Ok(self.at(key, &zero))
        };
        from.iter().map(key).collect()
    }

    /// What becomes of a joint state when a time has come.
    fn at(&self, (state, mut status, memory): Key, time: &Number) -> Key {
        for (number, window) in self.windows.iter().enumerate() {
            if status.of(number).is_some() {
                continue;
            }
            let place = state as usize;
            if window.begin == *time && window.right[place] {
                status.set(number, true);
            } else if window.begin == *time && !window.left[place]
                || window.end.as_ref() == Some(time)
            {
                status.set(number, false);
            }
        }
        (state, status, memory)
    }

    /// What a state that is entered after a time, before the next end of a window, settles.
    fn pass(&self, status: &mut Status, state: usize, time: &Number) {
        for (number, window) in self.windows.iter().enumerate() {
            if status.of(number).is_some() {
                continue;
            }
            let has_begun = window.begin <= *time;
            if has_begun && window.right[state] {
                status.set(number, true);
            } else if !window.left[state] {
                status.set(number, false);
            }
        }
    }

    /// The number of the automata's states after the letter of a state.
    fn read(&mut self, before: u32, state: usize) -> Result<u32, CheckError> {
        let letter = self.letters[state];
        if let Some(known) = self.steps.get(&(before, letter)) {
            return Ok(*known);
        }
        let mut after = self.memories[before as usize].clone();
        for (automaton, state) in self.automata.iter_mut().zip(&mut after) {
            *state = automaton.step(*state, letter)?.state;
        }
        let next = self.memories.len() as u32;
        let number = *self.index.entry(after.clone()).or_insert(next);
        if number == next {
            self.memories.push(after);
        }
        self.steps.insert((before, letter), number);
        Ok(number)
    }

    fn verdict(&self, (_, status, memory): Key) -> Option<bool> {
        let memory = &self.memories[memory as usize];
        let untimed = |number: usize| self.automata[number].decided(memory[number]);
        (self.condition).truth(&|window| status.of(window), &untimed)
    }

    /// What is reachable of the joint chain after a time, before the next end of a window.
    fn segment(
        &mut self,
        start: &Number,
        entered: &[Key],
        options: &Options<'_>,
    ) -> Result<Segment<N>, CheckError> {
        // Nothing reads the keys of the settled states.
        let nowhere = (u32::MAX, Status(0), 0);
        let mut found = Found {
            states: vec![nowhere; SETTLED.len()],
            index: FxHashMap::default(),
            limit: options.product_limit.min(u32::MAX as usize),
        };
        let entered = entered
            .iter()
            .map(|key| found.enter(*key, self.verdict(*key)));
        let entered = entered.collect::<Result<Vec<_>, _>>()?;
        let mut rates = Csr::with_capacity(found.states.len());
        for settled in SETTLED {
            rates.push_row([(settled, N::one())]);
        }
        let mut next = SETTLED.len();
        while next < found.states.len() {
            if next.is_multiple_of(4096) {
                options.check_cancelled()?;
            }
            let row = self.row(found.states[next], start, &mut found)?;
            rates.push_row(row);
            next += 1;
        }
        Ok(Segment {
            length: None,
            rates,
            entered,
            states: found.states,
        })
    }

    /// Where a joint state leads after a time, with the rates.
    fn row(
        &mut self,
        (state, status, memory): Key,
        start: &Number,
        found: &mut Found,
    ) -> Result<Vec<(u32, N)>, CheckError> {
        let model = self.rates;
        let mut row: Vec<(u32, N)> = Vec::new();
        for (target, rate) in model.row(state as usize) {
            let mut status = status;
            self.pass(&mut status, target, start);
            let key = (target as u32, status, self.read(memory, target)?);
            row.push((found.enter(key, self.verdict(key))?, rate.clone()));
        }
        row.sort_by_key(|(target, _)| *target);
        row.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 = kept.1.add(&next.1);
            }
            same
        });
        Ok(row)
    }

    /// The states of bottom components in which the formula holds; what is open then never becomes true.
    fn accepting(&mut self, last: &Segment<N>) -> Result<Vec<bool>, CheckError> {
        let mut accepting = vec![false; last.states.len()];
        accepting[SETTLED[1] as usize] = true;
        for component in bottom_components(&last.rates) {
            if component.iter().any(|state| SETTLED.contains(state)) {
                continue;
            }
            let mut holds = Vec::with_capacity(self.automata.len());
            for (number, automaton) in self.automata.iter_mut().enumerate() {
                let mut marks = Vec::new();
                for from in &component {
                    let before = self.memories[last.states[*from as usize].2 as usize][number];
                    for (to, _) in last.rates.row(*from as usize) {
                        let letter = self.letters[last.states[to].0 as usize];
                        marks.push(automaton.step(before, letter)?.mark);
                    }
                }
                marks.sort_unstable();
                marks.dedup();
                holds.push(automaton.accepts(marks));
            }
            let status = last.states[component[0] as usize].1;
            let window = |number| Some(status.of(number) == Some(true));
            let verdict = self.condition.truth(&window, &|number| Some(holds[number]));
            for state in component {
                accepting[state as usize] = verdict == Some(true);
            }
        }
        Ok(accepting)
    }
}

/// The joint states found in a segment.
struct Found {
    states: Vec<Key>,
    index: FxHashMap<Key, u32>,
    limit: usize,
}

impl Found {
    fn enter(&mut self, key: Key, verdict: Option<bool>) -> Result<u32, CheckError> {
        if let Some(verdict) = verdict {
            return Ok(SETTLED[usize::from(verdict)]);
        }
        if let Some(known) = self.index.get(&key) {
            return Ok(*known);
        }
        if self.states.len() >= self.limit {
            return Err(CheckError::ProductTooLarge { limit: self.limit });
        }
        let number = self.states.len() as u32;
        self.states.push(key);
        self.index.insert(key, number);
        Ok(number)
    }
}

/// Time 0 and the ends of the windows, ascending, each once.
fn instants(windows: &[Window]) -> Result<Vec<Number>, CheckError> {
    let ends = windows.iter().flat_map(|w| w.end.iter().chain([&w.begin]));
    let zero = Number::from_i64(0);
    let mut all: Vec<Number> = ends.chain([&zero]).cloned().collect();
    all.sort_by(|a, b| a.partial_cmp(b).unwrap_or(Ordering::Equal));
    all.dedup_by(|a, b| a.exact().is_some() && a.exact() == b.exact());
    for pair in all.windows(2) {
        let is_exact = pair.iter().all(|time| time.exact().is_some());
        if !is_exact && Bounds::literal(&pair[0]).high >= Bounds::literal(&pair[1]).low {
            return Err(CheckError::Unsupported(format!(
                "the times {} and {} are too near to each other to tell which is first: write them as decimal numbers",
                pair[0], pair[1]
            )));
        }
    }
    Ok(all)
}

/// How much later the second time is.
pub(crate) fn difference(start: &Number, end: &Number) -> Bounds {
    match (start.exact(), end.exact()) {
        (Some(start), Some(end)) => Bounds::literal(&Number::from_rational(end - start)),
        _ => Bounds::literal(end)
            .sub(&Bounds::literal(start))
            .greatest(&Bounds::ZERO),
    }
}
