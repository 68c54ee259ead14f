//! Rewards in total, as rewards before a target.
//!
//! *Definition.* Least (and without alternatives): what is earned before the end components in which nothing is earned,
//! since a path with a finite total ends in one, and a scheduler can rest there. Greatest: infinite where an end
//! component that earns can be reached; elsewhere end components earn nothing, each is made one state that may also stop,
//! and what is earned before all has stopped is the total.
//!
//! Source: de Alfaro 1997; Forejt, Kwiatkowska, Norman and Parker 2011, section 5. Guarantee: exact, by inequalities.

use num_traits::{One, Zero};
use prism_lang::Rational;

use crate::evaluate::{Evaluator, is_free};
use crate::explicit::{end_components, possible, quotient};
use crate::failure::Failure;
use crate::inequalities::Problem;
use crate::interval::Interval;
use crate::reading::{Choice, Reading};

impl Evaluator<'_> {
    /// The reward in total in each state.
    pub(crate) fn total(
        &mut self,
        reading: &Reading,
        maximise: bool,
    ) -> Result<Vec<Interval>, Failure> {
        let states = reading.states.len();
        let everywhere = vec![true; states];
        if !maximise || self.is_chain() {
            let mut target = vec![false; states];
            for component in end_components(&reading.choices, &everywhere, &is_free) {
                component.iter().for_each(|state| target[*state] = true);
            }
            return self.solved(Problem {
                choices: &reading.choices,
                target: &target,
                failed: &vec![false; states],
                is_reward: true,
                maximise,
            });
        }
        let components = end_components(&reading.choices, &everywhere, &|_| true);
        let mut earns = vec![false; states];
        for component in &components {
            let stays = |choice: &Choice| {
                let mut targets = choice.outcomes.iter();
                targets.all(|(t, _)| component.binary_search(t).is_ok())
            };
            let choices = component.iter().flat_map(|state| &reading.choices[*state]);
            let is_earning = choices.filter(|c| stays(c)).any(|choice| !is_free(choice));
            component
                .iter()
                .for_each(|state| earns[*state] = is_earning);
        }
        let infinite = possible(&reading.choices, &earns);
        let (class, mut choices) = quotient(&reading.choices, &components);
        let (classes, collapsed) = (choices.len(), components.len());
        let end = classes;
        for state in (0..states).filter(|state| infinite[*state]) {
            // What is infinite is not asked about, and no finite state leads there.
            choices[class[state]].clear();
        }
        choices.push(Vec::new());
        let go = |to: usize| Choice {
            outcomes: vec![(to, Rational::one())],
            reward: Rational::zero(),
        };
        for (number, choices) in choices.iter_mut().enumerate() {
            if number < collapsed || choices.is_empty() {
                choices.push(go(end));
            }
        }
        let target: Vec<bool> = (0..=classes).map(|number| number == end).collect();
        let values = self.solved(Problem {
            choices: &choices,
            target: &target,
            failed: &vec![false; classes + 1],
            is_reward: true,
            maximise: true,
        })?;
        let value = |state: usize| match infinite[state] {
            true => Interval::exactly(f64::INFINITY),
            false => values[class[state]],
        };
        Ok((0..states).map(value).collect())
    }
}
