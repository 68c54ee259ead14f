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
//! Source: Emerson and Clarke 1982; Baier and Katoen 2008, chapter 6. Trusted: [`crate::formula`], for products. Cost: rounds
//! times transitions. Guarantee: exact; nobody is asked.

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
                    return graph.fixpoint(right.clone(), step, &|| self.oracle.go_on());
                }
            }
            Formula::Release(left, right, 0, None) => {
                if let (Some(left), Some(right)) = (set(left), set(right)) {
                    let step = |state: usize, next| right[state] && (left[state] || next);
                    return graph.fixpoint(right.clone(), step, &|| self.oracle.go_on());
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

    /// What a step changes no more, of whether some target is in the set.
    fn fixpoint(
        &self,
        mut set: Vec<bool>,
        step: impl Fn(usize, bool) -> bool,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Vec<bool>, Failure> {
        loop {
            if !go_on() {
                return Err(Failure::Cancelled);
            }
            let before = self.before(&set);
            let next = before.iter().enumerate();
            let next: Vec<bool> = next.map(|(state, next)| step(state, *next)).collect();
            if next == set {
                return Ok(set);
            }
            set = next;
        }
    }
}
