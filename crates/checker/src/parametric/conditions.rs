//! At which points of a region a model has the graph that it was solved with.
//!
//! A solution by state elimination holds at every point at which each transition's function is positive (and, since
//! they sum to 1 by their form, at most 1). Where rewards depend on parameters, they must not be negative.

use super::function::{Factored, RationalFunction};
use super::region::{Region, Sign};
use crate::state_space::{StateSpace, TransitionRewards};

/// A function that must be positive (a probability or a rate), or not negative (a reward).
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// The function.
    pub function: RationalFunction,
    /// Whether it may be 0.
    pub or_zero: bool,
    /// Whether it is met at all points of the region; `None` if that is not known.
    pub holds: Option<bool>,
}

/// What must hold for a solution to be valid, and whether it does on a region.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conditions {
    /// Each once: functions that are the same everywhere are left out.
    pub each: Vec<Condition>,
}

impl Conditions {
    /// Those of a state space on a region.
    pub(super) fn new(space: &StateSpace<RationalFunction>, region: &Region) -> Self {
        let mut each = Vec::new();
        for function in distinct(space.matrix.value.iter()) {
            each.push(condition(function, false, region));
        }
        let rewards = space.rewards.iter().filter_map(|(_, r)| r.as_ref().ok());
        let values = rewards.flat_map(|rewards| {
            let of_transitions = match &rewards.transition {
                TransitionRewards::None => &[][..],
                TransitionRewards::Row(values) | TransitionRewards::Entry(values) => values,
            };
            rewards.state.iter().chain(of_transitions)
        });
        for function in distinct(values) {
            each.push(condition(function, true, region));
        }
        Self { each }
    }

    /// Whether all hold at all points of the region.
    pub fn hold(&self) -> bool {
        self.each.iter().all(|c| c.holds == Some(true))
    }

    /// Whether one holds at no point of the region.
    pub fn never_hold(&self) -> bool {
        self.each.iter().any(|c| c.holds == Some(false))
    }
}

fn condition(function: RationalFunction, or_zero: bool, region: &Region) -> Condition {
    let holds = match region.sign(&function) {
        Sign::Positive => Some(true),
        Sign::Zero => Some(or_zero),
        Sign::Negative => Some(false),
        Sign::Unknown => None,
    };
    Condition {
        function,
        or_zero,
        holds,
    }
}

/// The functions that depend on a parameter, each once, in the order in which they come first.
fn distinct<'a>(functions: impl Iterator<Item = &'a RationalFunction>) -> Vec<RationalFunction> {
    let key = |(_, known): &(usize, &'a Factored)| (&known.coefficient, &known.product);
    let known = functions.filter_map(|f| f.known.as_ref());
    let dependent = known.filter(|known| !known.product.is_empty());
    let mut found: Vec<(usize, &Factored)> = dependent.enumerate().collect();
    found.sort_by(|a, b| key(a).cmp(&key(b)));
    found.dedup_by(|next, kept| key(next) == key(kept));
    found.sort_by_key(|(place, _)| *place);
    let function = |(_, known): (usize, &Factored)| {
        RationalFunction::factored(known.coefficient.clone(), known.product.clone())
    };
    found.into_iter().map(function).collect()
}
