//! A model brought into the form of [`crate::optimum`]: states joined to classes, end components collapsed.
//!
//! *Definition.* Every state belongs to a class; states of one class have the same value. A class has a fixed
//! value, or the choices of all its states, less those that stay in the class. A class may also have the choice
//! to stop with some value. Collapsing the end components in which a scheduler could stay without gain leaves
//! the optimum as it is (Ciesinski, Baier, Größer and Klein 2008; Haddad and Monmege 2018, "Interval iteration
//! algorithm for MDPs and IMDPs", section 3), and removes all schedulers that never end.
//!
//! Where nothing is collapsed, a technique may solve the problem on the states of the model themselves
//! ([`crate::engine::Numbers::solve_states`]), so that nothing is copied.
//!
//! The scheduler found on the classes becomes one on the model: within a collapsed component, all states go
//! towards the one whose choice leaves it. Cost: linear, plus sorting each row. Guarantee: exact; probabilities
//! of entries that fall together are added, which [`crate::optimum::sound`] allows for.

use prism_lang::Arithmetic;

use crate::amount::Amount;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::{Context, Numbers};
use crate::graph::{Backward, EndComponent, NO_ROW};
use crate::optimum::{Problem, Solution};
use crate::state_space::Csr;

/// The class of states that do not belong to the problem; choices that may lead there are left out.
pub(crate) const NO_CLASS: u32 = u32::MAX;

/// A problem on a model.
pub(crate) struct Quotient<'a, A: Amount> {
    pub choices: Choices<'a, A::Entry>,
    /// The class of each state.
    pub class: Vec<u32>,
    /// The value of each class that has a fixed one.
    pub fixed: Vec<Option<A>>,
    /// The reward of each choice of the model; none if empty.
    pub reward: &'a [A],
    /// Classes that can stop, each with the value.
    pub stops: Vec<(u32, A)>,
    /// End components that are classes.
    pub collapsed: Vec<EndComponent>,
    pub maximise: bool,
    /// An upper bound of all values that is known beforehand.
    pub cap: f64,
}

/// Values in all states and a scheduler.
#[derive(Debug, Clone)]
pub(crate) struct Optimal<A> {
    pub values: Vec<A>,
    /// The choice in each state; [`NO_ROW`] where it does not matter.
    pub scheduler: Vec<usize>,
    pub iterations: u64,
}

impl<A> Optimal<A> {
    /// A solution on the states of the model.
    pub fn of(found: Solution<A>) -> Self {
        Self {
            values: found.values,
            scheduler: found.choice,
            iterations: found.iterations,
        }
    }
}

/// The problem and where its choices come from.
struct Built<A: Amount> {
    problem: Problem<A::Entry, A>,
    /// The model's choice; [`NO_ROW`] for stopping.
    origin: Vec<usize>,
}

impl<'a, A: Amount> Quotient<'a, A> {
    pub fn new(choices: Choices<'a, A::Entry>, maximise: bool) -> Self {
        Self {
            choices,
            class: vec![NO_CLASS; choices.num_states()],
            fixed: Vec::new(),
            reward: &[],
            stops: Vec::new(),
            collapsed: Vec::new(),
            maximise,
            cap: f64::INFINITY,
        }
    }

    /// A new class without states.
    pub fn add_class(&mut self, fixed: Option<A>) -> u32 {
        self.fixed.push(fixed);
        self.fixed.len() as u32 - 1
    }

    /// Puts the states of a set into a class.
    pub fn assign(&mut self, class: u32, set: &[bool]) {
        for (known, holds) in self.class.iter_mut().zip(set) {
            if *holds {
                *known = class;
            }
        }
    }

    /// Makes each of these components a class.
    pub fn collapse(&mut self, components: Vec<EndComponent>) {
        for component in &components {
            let class = self.add_class(None);
            for state in &component.states {
                self.class[*state as usize] = class;
            }
        }
        self.collapsed.extend(components);
    }

    /// Makes each state of a set that has no class yet a class of its own.
    pub fn separate(&mut self, set: &[bool]) {
        for (state, holds) in set.iter().enumerate() {
            if *holds && self.class[state] == NO_CLASS {
                self.class[state] = self.add_class(None);
            }
        }
    }

    /// Solves the problem; states without a class have the value `outside`.
    pub fn solve<E: Numbers<Entry = A::Entry, Amount = A>>(
        &self,
        outside: &A,
        context: &Context<'_>,
    ) -> Result<Optimal<A>, CheckError> {
        let built = self.build();
        let solution = E::solve(&built.problem, self.cap, context)?;
        let value = |class: &u32| match *class {
            NO_CLASS => outside.clone(),
            class => solution.values[class as usize].clone(),
        };
        let chosen = |class: &u32| match *class {
            NO_CLASS => NO_ROW,
            class => match solution.choice[class as usize] {
                NO_ROW => NO_ROW,
                row => built.origin[row],
            },
        };
        let leaving = self.class.iter().map(chosen).collect();
        Ok(Optimal {
            values: self.class.iter().map(value).collect(),
            scheduler: self.scheduler(leaving),
            iterations: solution.iterations,
        })
    }

    fn build(&self) -> Built<A> {
        let (order, start) = self.members();
        let mut matrix = Csr::with_capacity(self.fixed.len());
        let mut fixed = self.fixed.clone();
        let (mut choice_start, mut origin) = (vec![0], Vec::new());
        let (mut reward, mut merged) = (Vec::new(), 0);
        let mut entries: Vec<(u32, A::Entry)> = Vec::new();
        let mut stops: Vec<&(u32, A)> = self.stops.iter().collect();
        stops.sort_by_key(|(class, _)| *class);
        let mut stops = stops.into_iter().peekable();
        for class in 0..self.fixed.len() {
            if self.fixed[class].is_none() {
                for state in &order[start[class]..start[class + 1]] {
                    for row in self.choices.rows(*state as usize) {
                        let Some(most) = self.merge(row, class as u32, &mut entries) else {
                            continue;
                        };
                        merged = merged.max(most);
                        matrix.push_row(entries.drain(..));
                        origin.push(row);
                        if let Some(earned) = self.reward.get(row) {
                            reward.push(earned.clone());
                        }
                    }
                }
                while stops.next_if(|(of, _)| (*of as usize) < class).is_some() {}
                while let Some((_, value)) = stops.next_if(|(of, _)| *of as usize == class) {
                    matrix.push_row([(fixed.len() as u32, A::Entry::one())]);
                    fixed.push(Some(value.clone()));
                    origin.push(NO_ROW);
                    if !self.reward.is_empty() {
                        reward.push(A::zero());
                    }
                }
            }
            choice_start.push(matrix.num_rows());
        }
        choice_start.resize(fixed.len() + 1, matrix.num_rows());
        let problem = Problem {
            matrix,
            choice_start,
            reward,
            fixed,
            maximise: self.maximise,
            merged,
        };
        Built { problem, origin }
    }

    /// The states by class, and where each class starts.
    fn members(&self) -> (Vec<u32>, Vec<usize>) {
        let mut start = vec![0; self.fixed.len() + 1];
        for class in self.class.iter().filter(|class| **class != NO_CLASS) {
            start[*class as usize + 1] += 1;
        }
        for class in 0..self.fixed.len() {
            start[class + 1] += start[class];
        }
        let mut next = start.clone();
        let mut order = vec![0; start[self.fixed.len()]];
        for (state, class) in self.class.iter().enumerate() {
            if *class != NO_CLASS {
                order[next[*class as usize]] = state as u32;
                next[*class as usize] += 1;
            }
        }
        (order, start)
    }

    /// The entries of a choice by class, without the own one; the most additions for one of them, or nothing if
    /// the choice is left out.
    fn merge(&self, row: usize, own: u32, entries: &mut Vec<(u32, A::Entry)>) -> Option<usize> {
        entries.clear();
        for (target, p) in self.choices.matrix.row(row) {
            match self.class[target] {
                NO_CLASS => {
                    entries.clear();
                    return None;
                }
                class if class == own => {}
                class => entries.push((class, p.clone())),
            }
        }
        if entries.is_empty() {
            return None;
        }
        entries.sort_by_key(|(class, _)| *class);
        let (mut most, mut here) = (0, 0);
        entries.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            here = if same { here + 1 } else { 0 };
            most = most.max(here);
            if same {
                kept.1 = kept.1.add(&next.1);
            }
            same
        });
        Some(most)
    }

    /// The choices on the model, from the choice that leaves each state's class.
    fn scheduler(&self, leaving: Vec<usize>) -> Vec<usize> {
        if self.collapsed.is_empty() || self.choices.is_chain() {
            return leaving;
        }
        let mut scheduler = leaving.clone();
        let backward = Backward::new(self.choices);
        let mut stays = vec![false; self.choices.matrix.num_rows()];
        let mut member = vec![false; leaving.len()];
        let mut exits = vec![false; leaving.len()];
        for component in &self.collapsed {
            component.rows.iter().for_each(|row| stays[*row] = true);
            for state in &component.states {
                let row = leaving[*state as usize];
                member[*state as usize] = true;
                exits[*state as usize] = row != NO_ROW && backward.owner[row] == *state;
            }
        }
        let (_, towards) = backward.reaching(&exits, |s| member[s], |row| stays[row]);
        for component in &self.collapsed {
            for state in component.states.iter().map(|s| *s as usize) {
                if leaving[state] == NO_ROW {
                    // Stopping: any choice that stays.
                    let staying = self.choices.rows(state).find(|row| stays[*row]);
                    scheduler[state] = staying.unwrap_or(NO_ROW);
                } else if !exits[state] {
                    scheduler[state] = towards[state];
                }
            }
        }
        scheduler
    }
}
