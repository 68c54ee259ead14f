//! Several objectives at once: what one scheduler can achieve of all of them.
//!
//! *Definition.* Each objective gives a scheduler a number that should be large: the probability of a formula (of
//! its negation, where it should be small), or an expected reward in total or within steps (negative, where it
//! should be small). The vectors that schedulers achieve form a convex set, less what lies below is no loss. Asked
//! is whether a vector lies in it, how far one number can be raised while the others meet their bounds, or the
//! corners of the set's upper boundary for two objectives.
//!
//! *Method.* On the product with all formulas' automata and a clock ([`crate::joint`]), the scheduler that is best
//! for a weighted sum ([`weighted`]) is a corner of the set, and says that nothing lies beyond in that direction.
//! Where a question is open, the weights that tell most are those of a linear programme over the corners known
//! ([`frontier`]). There are finitely many corners, so this ends.
//!
//! Source: Forejt, Kwiatkowska and Parker 2012, "Pareto Curves for Probabilistic Model Checking"; Etessami,
//! Kwiatkowska, Vardi and Yannakakis 2008. Deviation: rational arithmetic with policy iteration in place of value
//! iteration, so that bounds met exactly are decided. Cost: one policy iteration and one chain for each objective,
//! for each corner. Guarantee: exact. The mixture of the corners' schedulers that shows what was found is that of the last
//! linear programme ([`mixture`], [`scheduler`]).

mod frontier;
pub(crate) mod scheduler;
mod simplex;
mod weighted;

use num_traits::{One, Signed, Zero};
use prism_lang::Rational;

use crate::answer::{CheckError, Options};
pub(crate) use weighted::{Corner, Kind, Skeleton};

/// An objective in the form in which more is better.
#[derive(Debug, Clone)]
pub(crate) struct Goal {
    pub kind: Kind,
    /// What must be reached, and whether it must be passed; none if as much as possible is asked for.
    pub bound: Option<(Rational, bool)>,
    /// Whether the number is that of the contrary: one less the probability, or the negative reward.
    pub contrary: bool,
}

/// What can be achieved.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Achieved {
    /// Whether all bounds can be met.
    Truth(bool),
    /// The best value of the objective without bound; none if the bounds cannot be met.
    Best(Option<Rational>),
    /// The corners of the boundary, in the order of the first number.
    Corners(Vec<Vec<Rational>>),
}

impl Goal {
    /// The number that was asked for, from the one of which more is better.
    fn asked(&self, value: &Rational) -> Rational {
        match (&self.kind, self.contrary) {
            (_, false) => value.clone(),
            (Kind::Path(_), true) => Rational::one() - value,
            (Kind::Reward { .. }, true) => -value,
        }
    }
}

/// Schedulers, with their shares, that together achieve what was asked for; none if it cannot be achieved.
pub(crate) fn mixture(
    skeleton: &Skeleton,
    goals: &[Goal],
    options: &Options<'_>,
) -> Result<Option<Vec<(Rational, Corner)>>, CheckError> {
    let (achieved, search) = search(skeleton, goals, options)?;
    Ok(match achieved {
        Achieved::Truth(true) | Achieved::Best(Some(_)) => Some(search.mixture()),
        _ => None,
    })
}

/// Answers the question.
pub(crate) fn solve(
    skeleton: &Skeleton,
    goals: &[Goal],
    options: &Options<'_>,
) -> Result<Achieved, CheckError> {
    if goals.len() == 2 && goals.iter().all(|goal| goal.bound.is_none()) {
        return corners(skeleton, goals, options);
    }
    Ok(search(skeleton, goals, options)?.0)
}

/// The answer where at most one objective has no bound, and the search that found it.
fn search<'a>(
    skeleton: &'a Skeleton,
    goals: &[Goal],
    options: &'a Options<'a>,
) -> Result<(Achieved, frontier::Search<'a>), CheckError> {
    let free: Vec<usize> = (0..goals.len())
        .filter(|i| goals[*i].bound.is_none())
        .collect();
    let bound: Vec<usize> = (0..goals.len())
        .filter(|i| goals[*i].bound.is_some())
        .collect();
    if free.len() > 1 {
        return Err(CheckError::Unsupported(
            "the curve of more than two objectives, or of two with bounds beside them, cannot be computed yet: \
             give bounds to all but one"
                .to_owned(),
        ));
    }
    let limit = |goal: &Goal| {
        goal.bound
            .as_ref()
            .map_or_else(Rational::zero, |(b, _)| b.clone())
    };
    let mut search = frontier::Search::new(skeleton, goals.iter().map(limit).collect(), options);
    let indicator = |of: &dyn Fn(usize) -> bool| -> Vec<Rational> {
        let number = |holds| {
            if holds {
                Rational::one()
            } else {
                Rational::zero()
            }
        };
        (0..goals.len()).map(|place| number(of(place))).collect()
    };
    let mut met = true;
    if !bound.is_empty() {
        let all = indicator(&|place| goals[place].bound.is_some());
        met = search
            .furthest(&bound, &all)?
            .is_some_and(|by| !by.is_negative());
        let is_strict = |place: usize| {
            goals[place]
                .bound
                .as_ref()
                .is_some_and(|(_, strict)| *strict)
        };
        if met && bound.iter().any(|place| is_strict(*place)) {
            let strict = indicator(&is_strict);
            met = search
                .furthest(&bound, &strict)?
                .is_some_and(|by| by.is_positive());
        }
    }
    let Some(asked) = free.first() else {
        return Ok((Achieved::Truth(met), search));
    };
    if !met {
        return Ok((Achieved::Best(None), search));
    }
    let everything: Vec<usize> = (0..goals.len()).collect();
    let direction = indicator(&|place| place == *asked);
    let best = search.furthest(&everything, &direction)?;
    let best = best.map(|value| goals[*asked].asked(&value));
    Ok((Achieved::Best(best), search))
}

/// The corners of the boundary of two objectives.
fn corners(
    skeleton: &Skeleton,
    goals: &[Goal],
    options: &Options<'_>,
) -> Result<Achieved, CheckError> {
    let (zero, one) = (Rational::zero, Rational::one);
    let first = skeleton.best(&[one(), zero()], options)?.numbers;
    let last = skeleton.best(&[zero(), one()], options)?.numbers;
    let mut found = vec![first.clone(), last.clone()];
    let mut open = vec![(last, first)];
    while let Some((upper, right)) = open.pop() {
        // The normal of the line from the upper one to the one further right.
        let weights = [&upper[1] - &right[1], &right[0] - &upper[0]];
        if weights.iter().any(Signed::is_negative) || weights.iter().all(Zero::is_zero) {
            continue;
        }
        let point = skeleton.best(&weights, options)?.numbers;
        let value = |point: &[Rational]| &weights[0] * &point[0] + &weights[1] * &point[1];
        if value(&point) > value(&upper) {
            found.push(point.clone());
            open.push((upper, point.clone()));
            open.push((point, right));
        }
    }
    let dominates = |a: &Vec<Rational>, b: &Vec<Rational>| a != b && a[0] >= b[0] && a[1] >= b[1];
    let all = found.clone();
    found.retain(|point| !all.iter().any(|other| dominates(other, point)));
    let asked = |point: &Vec<Rational>| -> Vec<Rational> {
        goals
            .iter()
            .zip(point)
            .map(|(goal, value)| goal.asked(value))
            .collect()
    };
    let mut found: Vec<Vec<Rational>> = found.iter().map(asked).collect();
    found.sort();
    found.dedup();
    Ok(Achieved::Corners(found))
}
