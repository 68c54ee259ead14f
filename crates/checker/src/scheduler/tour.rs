//! What is done for ever in end components: going round the transitions that must recur.
//!
//! *Definition.* In an accepting end component, for each part of the automaton one row that shows the least
//! priority which the component shows is enough to accept. The scheduler heads for the first of these rows, takes it,
//! heads for the next, and so on in turn: almost surely each is taken infinitely often, since from every state of the
//! component each is reached with probability 1 by rows that lead nearer. The memory is which one is next.
//!
//! Source: Baier and Katoen 2008, lemma 10.119 and theorem 10.122. Deviation: rows in place of states, and as many as
//! the automaton has parts, not all. Cost: one backward search for each place of the round. Guarantee: exact.

use temporal::automaton::Automaton;

use crate::choices::Choices;
use crate::graph::{Backward, EndComponent, NO_ROW};

/// An end component with the rows that must recur.
pub(crate) type Recurring = (EndComponent, Vec<usize>);

/// Rows of a component that show, for each part of an automaton, the least priority that the component shows; `marks`
/// are those of each row.
pub(crate) fn covering(automaton: &Automaton, rows: &[usize], marks: &[Vec<u32>]) -> Vec<usize> {
    let all = || marks.iter().flatten();
    let parts = all().map(|mark| automaton.priorities(*mark).len()).max();
    let mut places: Vec<usize> = Vec::new();
    for part in 0..parts.unwrap_or(0) {
        let priority = |mark: &u32| automaton.priorities(*mark)[part];
        let least = all().map(priority).min();
        let shows = |place: &usize| marks[*place].iter().any(|m| Some(priority(m)) == least);
        if !places.iter().any(&shows) {
            places.extend((0..rows.len()).find(|place| shows(place)));
        }
    }
    places.into_iter().map(|place| rows[place]).collect()
}

/// Where schedulers stay, and how they go round.
pub(crate) struct Tour {
    /// The component of each state, or none.
    component: Vec<u32>,
    recurring: Vec<Vec<usize>>,
    /// For each place of a round, a row that leads nearer to it.
    towards: Vec<Vec<usize>>,
    /// A row that stays.
    staying: Vec<usize>,
    owner: Vec<u32>,
}

const NONE: u32 = u32::MAX;

impl Tour {
    /// The components; one that shares states with an earlier one is left out, since that one can be reached in it.
    pub fn new<N>(choices: Choices<'_, N>, components: Vec<Recurring>) -> Self {
        let backward = Backward::new(choices);
        let mut tour = Self {
            component: vec![NONE; choices.num_states()],
            recurring: Vec::new(),
            towards: Vec::new(),
            staying: vec![NO_ROW; choices.num_states()],
            owner: backward.owner.clone(),
        };
        let mut stays = vec![false; choices.matrix.num_rows()];
        for (component, recurring) in components {
            let known = |state: &u32| tour.component[*state as usize] != NONE;
            if component.states.iter().any(known) {
                continue;
            }
            for state in &component.states {
                tour.component[*state as usize] = tour.recurring.len() as u32;
            }
            for row in &component.rows {
                stays[*row] = true;
                tour.staying[tour.owner[*row] as usize] = *row;
            }
            tour.recurring.push(recurring);
        }
        let longest = tour.recurring.iter().map(Vec::len).max().unwrap_or(0);
        for place in 0..longest {
            let mut goal = vec![false; choices.num_states()];
            for row in tour.recurring.iter().filter_map(|rows| rows.get(place)) {
                goal[tour.owner[*row] as usize] = true;
            }
            let inside = |state: usize| tour.component[state] != NONE;
            let (_, towards) = backward.reaching(&goal, inside, |row| stays[row]);
            tour.towards.push(towards);
        }
        tour
    }

    /// Where one of the components is entered.
    pub fn goal(&self) -> Vec<bool> {
        self.component.iter().map(|of| *of != NONE).collect()
    }

    /// What is done in a state of a component, if this place of the round is next; none outside.
    pub fn row(&self, state: usize, place: u32) -> Option<usize> {
        let recurring = self.recurring.get(self.component[state] as usize)?;
        Some(match recurring.get(place as usize) {
            None => self.staying[state],
            Some(row) if self.owner[*row] as usize == state => *row,
            Some(_) => self.towards[place as usize][state],
        })
    }

    /// The place that is next after a row was taken.
    pub fn next(&self, state: usize, place: u32, row: usize) -> u32 {
        match self.recurring.get(self.component[state] as usize) {
            Some(recurring) if recurring.get(place as usize) == Some(&row) => {
                (place + 1) % recurring.len() as u32
            }
            Some(_) => place,
            None => 0,
        }
    }
}

/// How to stay in components: first to where one goes round, then round.
pub(crate) struct Stay {
    towards: Vec<usize>,
    tour: Tour,
}

impl Stay {
    /// In each component, with where in it one goes round.
    pub fn new<N>(choices: Choices<'_, N>, components: &[(EndComponent, Recurring)]) -> Self {
        let tour = Tour::new(choices, components.iter().map(|(_, r)| r.clone()).collect());
        let mut inside = vec![false; choices.num_states()];
        let mut stays = vec![false; choices.matrix.num_rows()];
        for (component, _) in components {
            let states = component.states.iter();
            states.for_each(|state| inside[*state as usize] = true);
            component.rows.iter().for_each(|row| stays[*row] = true);
        }
        let backward = Backward::new(choices);
        let (_, towards) = backward.reaching(&tour.goal(), |s| inside[s], |row| stays[row]);
        Self { towards, tour }
    }

    /// What is done in a state of a component, if this place of the round is next.
    pub fn row(&self, state: usize, place: u32) -> usize {
        let touring = self.tour.row(state, place);
        touring.unwrap_or(self.towards[state])
    }

    /// The place that is next after a row was taken.
    pub fn next(&self, state: usize, place: u32, row: usize) -> u32 {
        self.tour.next(state, place, row)
    }
}
