//! The product of a model with several deterministic automata and a clock, which reads on where verdicts are settled.
//!
//! A state of the product says where the model is, where each automaton is after the letters of all states so far,
//! and how many steps were taken, counted up to a horizon. [`Joint::satisfies`] tells whether a scheduler can stay
//! in an end component and satisfy several formulas at once: one that rejects some formula as a whole may contain
//! one that does not, which must avoid the least priority of some part of that formula's automaton; so each is
//! removed in turn, and what remains is searched again.
//!
//! Source: Etessami, Kwiatkowska, Vardi and Yannakakis 2008, "Multi-Objective Model Checking of Markov Decision
//! Processes", section 3; the search is that of [`crate::product`]. Cost: linear in the reachable product, the
//! search in it for each combination of priorities removed. Guarantee: exact.

use prism_lang::Arithmetic;
use rustc_hash::FxHashMap;
use temporal::automaton::{Automaton, DEFAULT_STATE_LIMIT};
use temporal::ltl::Ltl;

use crate::answer::{CheckError, Options};
use crate::choices::Choices;
use crate::graph::{EndComponent, end_components_of};
use crate::scheduler::tour::{Recurring, covering};
use crate::state_space::Csr;

/// The product, with one row for each choice, also for chains.
pub(crate) struct Joint<'a, N> {
    pub matrix: Csr<N>,
    pub choice_start: Vec<usize>,
    /// The model's row of each row.
    pub origin: Vec<usize>,
    /// The steps taken in each state, up to the horizon.
    pub clock: Vec<u32>,
    state: Vec<u32>,
    memory: Vec<u32>,
    owner: Vec<u32>,
    reader: Reader<'a>,
}

/// The automata that read together.
struct Reader<'a> {
    automata: Vec<Automaton>,
    letters: &'a [u64],
    horizon: u32,
    /// Where the automata are, and the clock.
    memories: Vec<Vec<u32>>,
    index: FxHashMap<Vec<u32>, u32>,
}

impl Reader<'_> {
    fn intern(&mut self, memory: Vec<u32>) -> u32 {
        let next = self.memories.len() as u32;
        let number = *self.index.entry(memory.clone()).or_insert(next);
        if number == next {
            self.memories.push(memory);
        }
        number
    }

    fn clock(&self, memory: u32) -> u32 {
        self.memories[memory as usize].last().copied().unwrap_or(0)
    }

    /// The memory after the letter of a state, `ticks` steps later.
    fn read(&mut self, memory: u32, state: usize, ticks: u32) -> Result<u32, CheckError> {
        let mut next = self.memories[memory as usize].clone();
        for (automaton, place) in self.automata.iter_mut().zip(&mut next) {
            *place = automaton.step(*place, self.letters[state])?.state;
        }
        if let Some(clock) = next.last_mut() {
            *clock = self.horizon.min(*clock + ticks);
        }
        Ok(self.intern(next))
    }
}

impl<'a, N: Arithmetic> Joint<'a, N> {
    /// What is reachable from a state, which becomes state 0; `letters` has one letter for each of the model's.
    pub fn new(
        model: Choices<'_, N>,
        formulas: &[Ltl],
        letters: &'a [u64],
        horizon: u32,
        from: usize,
        options: &Options<'_>,
    ) -> Result<Self, CheckError> {
        let limit = options.product_limit.min(DEFAULT_STATE_LIMIT);
        let automata = formulas
            .iter()
            .map(|f| Automaton::with_state_limit(f, limit));
        let automata = automata.collect::<Result<Vec<_>, _>>()?;
        let mut before: Vec<u32> = automata.iter().map(Automaton::initial).collect();
        before.push(0);
        let mut reader = Reader {
            automata,
            letters,
            horizon,
            memories: Vec::new(),
            index: FxHashMap::default(),
        };
        let before = reader.intern(before);
        let first = reader.read(before, from, 0)?;
        let mut joint = Self {
            matrix: Csr::with_capacity(0),
            choice_start: vec![0],
            origin: Vec::new(),
            clock: Vec::new(),
            state: vec![from as u32],
            memory: vec![first],
            owner: Vec::new(),
            reader,
        };
        joint.build(model, options)?;
        Ok(joint)
    }

    fn build(&mut self, model: Choices<'_, N>, options: &Options<'_>) -> Result<(), CheckError> {
        let mut index = FxHashMap::default();
        index.insert((self.state[0], self.memory[0]), 0);
        let mut next = 0;
        while next < self.state.len() {
            if next % 4096 == 0 {
                options.check_cancelled()?;
            }
            for choice in model.rows(self.state[next] as usize) {
                let mut row = Vec::new();
                for (target, p) in model.matrix.row(choice) {
                    let memory = self.reader.read(self.memory[next], target, 1)?;
                    let new = self.state.len() as u32;
                    let number = *index.entry((target as u32, memory)).or_insert(new);
                    if number == new {
                        if self.state.len() >= options.product_limit {
                            let limit = options.product_limit;
                            return Err(CheckError::ProductTooLarge { limit });
                        }
                        self.state.push(target as u32);
                        self.memory.push(memory);
                    }
                    row.push((number, p.clone()));
                }
                row.sort_unstable_by_key(|(column, _)| *column);
                self.matrix.push_row(row);
                self.origin.push(choice);
                self.owner.push(next as u32);
            }
            self.choice_start.push(self.matrix.num_rows());
            next += 1;
        }
        let clock = |memory: &u32| self.reader.clock(*memory);
        self.clock = self.memory.iter().map(clock).collect();
        Ok(())
    }

    pub fn choices(&self) -> Choices<'_, N> {
        Choices::new(&self.matrix, &self.choice_start)
    }

    pub fn num_states(&self) -> usize {
        self.state.len()
    }

    /// Where a row starts.
    pub fn owner(&self, row: usize) -> usize {
        self.owner[row] as usize
    }

    /// The model's state of a state.
    pub fn state(&self, state: usize) -> usize {
        self.state[state] as usize
    }

    /// Where the automata and the clock are in a state, as one number.
    pub fn memory(&self, state: usize) -> u32 {
        self.memory[state]
    }

    /// Whether a scheduler can stay in a component such that the formulas `wanted` hold of almost all paths that
    /// do; the formulas by their place.
    pub fn satisfies(
        &mut self,
        component: &EndComponent,
        wanted: &[usize],
    ) -> Result<bool, CheckError> {
        Ok(self.recurring(component, wanted)?.is_some())
    }

    /// Where in a component to stay for that, and what must recur there.
    pub fn recurring(
        &mut self,
        component: &EndComponent,
        wanted: &[usize],
    ) -> Result<Option<Recurring>, CheckError> {
        let mut open = vec![component.clone()];
        while let Some(component) = open.pop() {
            let (mut rejecting, mut recurring) = (None, Vec::new());
            for automaton in wanted {
                let marks = self.marks(&component, *automaton)?;
                let mut all: Vec<u32> = marks.iter().flatten().copied().collect();
                all.sort_unstable();
                all.dedup();
                let reader = &self.reader.automata[*automaton];
                if !reader.accepts(all) {
                    rejecting = Some((*automaton, marks));
                    break;
                }
                recurring.extend(covering(reader, &component.rows, &marks));
            }
            match rejecting {
                None => {
                    recurring.sort_unstable();
                    recurring.dedup();
                    return Ok(Some((component, recurring)));
                }
                Some((automaton, marks)) => {
                    open.extend(self.within(&component, automaton, &marks));
                }
            }
        }
        Ok(None)
    }

    /// The marks that an automaton shows on each row of a component.
    fn marks(
        &mut self,
        component: &EndComponent,
        automaton: usize,
    ) -> Result<Vec<Vec<u32>>, CheckError> {
        let mut all = Vec::with_capacity(component.rows.len());
        for row in &component.rows {
            let memory = self.memory[self.owner[*row] as usize];
            let place = self.reader.memories[memory as usize][automaton];
            let range = self.matrix.row_start[*row]..self.matrix.row_start[row + 1];
            let mut marks = Vec::with_capacity(range.len());
            for target in &self.matrix.column[range] {
                let letter = self.reader.letters[self.state[*target as usize] as usize];
                marks.push(self.reader.automata[automaton].step(place, letter)?.mark);
            }
            marks.sort_unstable();
            marks.dedup();
            all.push(marks);
        }
        Ok(all)
    }

    /// The maximal end components of a component that avoid the least priority of some part of an automaton.
    fn within(
        &self,
        component: &EndComponent,
        automaton: usize,
        marks: &[Vec<u32>],
    ) -> Vec<EndComponent> {
        let automaton = &self.reader.automata[automaton];
        let parts = marks
            .iter()
            .flatten()
            .map(|m| automaton.priorities(*m).len());
        let mut found = Vec::new();
        for part in 0..parts.max().unwrap_or(0) {
            let priority = |mark: &u32| automaton.priorities(*mark)[part];
            let Some(least) = marks.iter().flatten().map(priority).min() else {
                continue;
            };
            let usable = |at: usize| marks[at].iter().all(|mark| priority(mark) > least);
            found.extend(end_components_of(self.choices(), component, usable));
        }
        found
    }
}
