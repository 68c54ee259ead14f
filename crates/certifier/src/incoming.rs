//! The choices that lead to each state, so that sets of states are searched backward once and not in rounds.

use crate::reading::Choice;

/// By targets.
pub(crate) struct Incoming {
    start: Vec<usize>,
    /// State and place of each choice; once for each outcome.
    choice: Vec<(u32, u32)>,
}

impl Incoming {
    /// Of all choices.
    pub fn new(choices: &[Vec<Choice>]) -> Self {
        let each = || {
            choices.iter().enumerate().flat_map(|(state, own)| {
                own.iter().enumerate().flat_map(move |(place, choice)| {
                    let targets = choice.outcomes.iter().map(|(target, _)| *target);
                    targets.map(move |target| (target, (state as u32, place as u32)))
                })
            })
        };
        let mut start = vec![0; choices.len() + 1];
        each().for_each(|(target, _)| start[target + 1] += 1);
        for state in 0..choices.len() {
            start[state + 1] += start[state];
        }
        let mut next = start.clone();
        let mut choice = vec![(0, 0); start[choices.len()]];
        for (target, from) in each() {
            choice[next[target]] = from;
            next[target] += 1;
        }
        Self { start, choice }
    }

    /// The choices (state and place) that may lead to a state.
    pub fn of(&self, state: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
        let range = self.start[state]..self.start[state + 1];
        let choices = self.choice[range].iter();
        choices.map(|(state, place)| (*state as usize, *place as usize))
    }

    /// Takes out what leads to the states `gone`, of the choices that are `on`, and states that have none left, and so on;
    /// `keeps` says which states stay without any. The states that went along.
    pub fn unravel(
        &self,
        mut gone: Vec<usize>,
        on: &mut [Vec<bool>],
        keeps: impl Fn(usize) -> bool,
    ) -> Vec<usize> {
        let mut along = Vec::new();
        while let Some(state) = gone.pop() {
            for (from, place) in self.of(state) {
                if std::mem::replace(&mut on[from][place], false)
                    && !on[from].contains(&true)
                    && !keeps(from)
                {
                    along.push(from);
                    gone.push(from);
                }
            }
        }
        along
    }
}
