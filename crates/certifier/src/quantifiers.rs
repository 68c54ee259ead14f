//! `A` and `E`: sets of states by the fixpoints that define them.
//!
//! *Definition.* With `EX Z` the states with a transition into `Z`,
//!
//! ```text
//! E [ l U r ]   the least Z = r | (l & EX Z)
//! E [ l R r ]   the greatest Z = r & (l | EX Z)
//! ```
//!
//! Other formulas by the product with machines, where every transition is a choice of its own: some path satisfies the
//! formula iff it leads to strongly connected states that meet the condition. `A` is the contrary of `E` of the contrary.
//! A deadlock stays.
//!
//! Source: Emerson and Clarke 1982; Baier and Katoen 2008, chapter 6. Trusted: [`crate::formula`], for products. Cost: linear
//! in the transitions. Guarantee: exact; nobody is asked.

use num_traits::{One, Zero};
use prism_lang::Rational;
use prism_lang::property::Path;

use crate::evaluate::{Evaluator, as_set};
use crate::explicit::possible;
use crate::failure::Failure;
use crate::formula::{Condition, Formula};
use crate::product::Product;
use crate::reading::{Choice, Reading};

impl Evaluator<'_> {
    /// Whether some path satisfies a formula (or its contrary), in each state.
    pub(crate) fn some_path(&mut self, path: &Path, contrary: bool) -> Result<Vec<bool>, Failure> {
        let mut sets = Vec::new();
        let mut formula = self.formula(path, &mut sets)?;
        if contrary {
            formula = formula.negated();
        }
        let reading = self.reading()?;
        let states = reading.states.len();
        let set = |of: &Formula| as_set(of, &sets, states);
        if let Some(set) = set(&formula) {
            return Ok(set);
        }
        let graph = Graph::new(&reading);
        match &formula {
            Formula::Next(of) => {
                if let Some(of) = set(of) {
                    return Ok(graph.before(&of));
                }
            }
            Formula::Until(left, right, 0, None) => {
                if let (Some(left), Some(right)) = (set(left), set(right)) {
                    let step = |state: usize, next| right[state] || (left[state] && next);
                    return graph.fixpoint(right.clone(), step, &|| self.oracle.is_cancelled());
                }
            }
            Formula::Release(left, right, 0, None) => {
                if let (Some(left), Some(right)) = (set(left), set(right)) {
                    let step = |state: usize, next| right[state] && (left[state] || next);
                    return graph.fixpoint(right.clone(), step, &|| self.oracle.is_cancelled());
                }
            }
            _ => {}
        }
        let mut machines = Vec::new();
        let condition = Condition::read(&formula, &mut machines)?;
        let product = Product::new(&graph.choices(), &mut machines, &sets)?;
        let leads = possible(&product.choices, &product.accepting(&condition, &machines));
        Ok(product.start.iter().map(|start| leads[*start]).collect())
    }
}

/// The targets of each state's transitions, ascending.
struct Graph {
    targets: Vec<Vec<usize>>,
}

impl Graph {
    fn new(reading: &Reading) -> Self {
        let of = |choices: &Vec<Choice>| {
            let all = choices.iter().flat_map(|choice| &choice.outcomes);
            let mut targets: Vec<usize> = all.map(|(target, _)| *target).collect();
            targets.sort_unstable();
            targets.dedup();
            targets
        };
        Self {
            targets: reading.choices.iter().map(of).collect(),
        }
    }

    /// Each transition as a choice.
    fn choices(&self) -> Vec<Vec<Choice>> {
        let choice = |target: &usize| Choice {
            outcomes: vec![(*target, Rational::one())],
            reward: Rational::zero(),
        };
        let of = |targets: &Vec<usize>| targets.iter().map(choice).collect();
        self.targets.iter().map(of).collect()
    }

    /// `EX`.
    fn before(&self, set: &[bool]) -> Vec<bool> {
        let leads = |targets: &Vec<usize>| targets.iter().any(|target| set[*target]);
        self.targets.iter().map(leads).collect()
    }

    /// What a step changes no more, of whether some target is in the set; from a set that the step only adds to, or only
    /// takes from.
    fn fixpoint(
        &self,
        mut set: Vec<bool>,
        step: impl Fn(usize, bool) -> bool,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Vec<bool>, Failure> {
        let mut sources = vec![Vec::new(); set.len()];
        for (state, targets) in self.targets.iter().enumerate() {
            targets
                .iter()
                .for_each(|target| sources[*target].push(state));
        }
        let of_set = |targets: &Vec<usize>| targets.iter().filter(|t| set[**t]).count();
        let mut targets_in: Vec<usize> = self.targets.iter().map(of_set).collect();
        let changes = |state: &usize| step(*state, targets_in[*state] > 0) != set[*state];
        let mut changed: Vec<usize> = (0..set.len()).filter(changes).collect();
        changed.iter().for_each(|state| set[*state] = !set[*state]);
        let mut done = 0u32;
        while let Some(state) = changed.pop() {
            done = done.wrapping_add(1);
            if done.is_multiple_of(4096) && cancelled() {
                return Err(Failure::Cancelled);
            }
            for from in &sources[state] {
                match set[state] {
                    true => targets_in[*from] += 1,
                    false => targets_in[*from] -= 1,
                }
                let next = step(*from, targets_in[*from] > 0);
                if next != set[*from] {
                    set[*from] = next;
                    changed.push(*from);
                }
            }
        }
        Ok(set)
    }
}
