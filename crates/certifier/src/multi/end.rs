//! What a scheduler may have for ever, once nothing within steps is earned any more.
//!
//! *Definition.* In a component in which nothing is earned for ever a scheduler may stay, and has any formulas that can hold
//! together there (for all of a set some component within it accepts). Components become classes; what should be large must
//! not be earned in any, since its greatest value would be infinite. Guarantee: exact.

use num_traits::{One, Signed, Zero};
use prism_lang::Rational;

use super::{Goal, Kind};
use crate::evaluate::is_free;
use crate::explicit::{Origin, end_components, quotient_of};
use crate::failure::Failure;
use crate::formula::{Condition, Machine};
use crate::product::Product;
use crate::question::unsupported;
use crate::reading::Choice;

/// The product after the last step that earns, its components as classes.
pub(super) struct End {
    pub product: Product,
    pub class: Vec<usize>,
    pub choices: Vec<Vec<Choice>>,
    pub origins: Vec<Vec<Origin>>,
    /// Which path formulas can hold together in each component, as bits.
    pub together: Vec<Vec<u32>>,
}

impl End {
    pub fn new(
        mut product: Product,
        goals: &[Goal],
        machines: &[Machine],
    ) -> Result<Self, Failure> {
        // Who stays must earn nothing for ever: a choice's reward says whether it does.
        for (choices, state) in product.choices.iter_mut().zip(&product.state) {
            for (place, choice) in choices.iter_mut().enumerate() {
                let earns = |goal: &Goal| match &goal.kind {
                    Kind::Total(earned) => !earned[*state][place].is_zero(),
                    _ => false,
                };
                if goals.iter().any(earns) {
                    choice.reward = Rational::one();
                }
            }
        }
        let everywhere = vec![true; product.choices.len()];
        refuse_infinite(&product, goals, &everywhere)?;
        let components = end_components(&product.choices, &everywhere, &is_free);
        let mut together = vec![Vec::new(); components.len()];
        for bits in 0..1u32 << goals.len() {
            let mut all = Vec::new();
            for place in (0..goals.len()).filter(|place| bits >> place & 1 == 1) {
                match &goals[place].kind {
                    Kind::Path(condition) => all.push(condition.clone()),
                    Kind::Reward(..) | Kind::Total(_) => {}
                }
            }
            if all.len() != bits.count_ones() as usize {
                continue;
            }
            let accepting = product.accepting_by(&Condition::And(all), machines, &is_free);
            for (component, together) in components.iter().zip(&mut together) {
                if component.iter().any(|state| accepting[*state]) {
                    together.push(bits);
                }
            }
        }
        let (class, choices, origins) = quotient_of(&product.choices, &components);
        Ok(Self {
            product,
            class,
            choices,
            origins,
            together,
        })
    }

    /// The classes' choices, of which some are kept (none: the one to stay); each component may stay, and is then in the goal with its
    /// share. The goal is the last state but one.
    pub fn stopping(
        &self,
        shares: &[Rational],
        keep: impl Fn(usize, Option<usize>) -> bool,
    ) -> Vec<Vec<Choice>> {
        let (goal, sink) = (self.choices.len(), self.choices.len() + 1);
        let mut all = Vec::with_capacity(sink + 1);
        for (class, choices) in self.choices.iter().enumerate() {
            let leaving = choices.iter().enumerate();
            let leaving = leaving.filter(|(place, _)| keep(class, Some(*place)));
            let mut own: Vec<Choice> = leaving.map(|(_, choice)| choice.clone()).collect();
            if let (Some(share), true) = (shares.get(class), keep(class, None)) {
                let outcomes = [(goal, share.clone()), (sink, Rational::one() - share)];
                own.push(Choice {
                    outcomes: (outcomes.into_iter().filter(|(_, p)| !p.is_zero())).collect(),
                    reward: Rational::zero(),
                });
            }
            all.push(own);
        }
        for end in [goal, sink] {
            all.push(vec![Choice {
                outcomes: vec![(end, Rational::one())],
                reward: Rational::zero(),
            }]);
        }
        all
    }
}

/// What should be large must not be earned for ever.
fn refuse_infinite(product: &Product, goals: &[Goal], everywhere: &[bool]) -> Result<(), Failure> {
    let is_large = |goal: &&Goal| matches!(goal.kind, Kind::Total(_)) && !goal.contrary;
    let large: Vec<&Goal> = goals.iter().filter(is_large).collect();
    if large.is_empty() {
        return Ok(());
    }
    for component in end_components(&product.choices, everywhere, &|_| true) {
        for state in &component {
            for (place, choice) in product.choices[*state].iter().enumerate() {
                let mut targets = choice.outcomes.iter();
                let stays = targets.all(|(to, _)| component.binary_search(to).is_ok());
                let earns = |goal: &&Goal| match &goal.kind {
                    Kind::Total(earned) => earned[product.state[*state]][place].is_positive(),
                    _ => false,
                };
                if stays && large.iter().any(earns) {
                    return Err(unsupported(
                        "a reward without bound among several objectives",
                    ));
                }
            }
        }
    }
    Ok(())
}
