//! Expected rewards: until a target, within steps, at a step, in total.
//!
//! *Definitions.* A step from state `s` by choice `c` earns `r_c`, the state's reward and the mean of the
//! transitions' (in a `ctmc` by the embedded chain: the rate of earning over the rate of leaving).
//!
//! ```text
//! F target   infinite where the target may be missed (max: by some scheduler; min: by all); else the optimum of
//!            the reward before it. For min, end components in which nothing is earned are collapsed, since
//!            staying there for ever misses the target at no cost.
//! C<=k       x' = opt r_c + sum p_cj x_j, k times from 0
//! I=k        x' = opt sum p_cj x_j, k times from the states' rewards
//! C          max: infinite where an end component that earns can be reached; other end components are
//!            collapsed and may stop. min: F over the end components in which nothing is earned.
//! ```
//!
//! Rewards of both signs: without alternatives the positive and the negative part are solved on their own and
//! subtracted (`F target` is infinite where the target may be missed, whatever is lost before); with alternatives only for
//! bounded numbers of steps, else they are refused.
//!
//! Source: Forejt, Kwiatkowska, Norman and Parker 2011, "Automated Verification Techniques for Probabilistic
//! Systems", section 5; Baier, Klein, Leuschner, Parker and Wunderlich 2017. Guarantee: that of the engine.

use crate::amount::Amount;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::{Context, Numbers};
use crate::graph::{Backward, maximal_end_components, qualitative_optimum};
use crate::quotient::{NO_CLASS, Optimal, Quotient};
use crate::rounding::Bounds;
use crate::steps::Back;

mod model;
pub(crate) use model::{Part, RewardModel};

/// The reward before a target, in all states.
pub(crate) fn reach<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    rewards: &RewardModel<E::Amount>,
    target: &[bool],
    maximise: bool,
    context: &Context<'_>,
) -> Result<Optimal<E::Amount>, CheckError> {
    // Where the target may be missed both parts are infinite, and so is the reward, whatever is lost.
    by_sign(
        choices,
        rewards,
        |part| reach_part::<E>(choices, part, target, maximise, context),
        |gain, loss| match gain.bounds().low == f64::INFINITY {
            true => gain.clone(),
            false => gain.sub(loss),
        },
    )
}

/// The reward in total, in all states.
pub(crate) fn total<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    rewards: &RewardModel<E::Amount>,
    maximise: bool,
    context: &Context<'_>,
) -> Result<Optimal<E::Amount>, CheckError> {
    let solve = |part: &Part<E::Amount>| total_part::<E>(choices, part, maximise, context);
    by_sign(choices, rewards, solve, Amount::sub)
}

/// Solves for each sign and subtracts.
pub(crate) fn by_sign<A: Amount>(
    choices: Choices<'_, A::Entry>,
    rewards: &RewardModel<A>,
    solve: impl Fn(&Part<A>) -> Result<Optimal<A>, CheckError>,
    subtract: impl Fn(&A, &A) -> A,
) -> Result<Optimal<A>, CheckError> {
    let mut gains = solve(&rewards.gain)?;
    let Some(loss) = &rewards.loss else {
        return Ok(gains);
    };
    if !choices.is_chain() {
        return Err(CheckError::Unsupported(
            "negative rewards in a model with choices can be computed for bounded numbers of steps only: \
             use `C<=k` or `I=k`, or rewards that are not negative"
                .to_owned(),
        ));
    }
    let losses = solve(loss)?;
    for (gain, loss) in gains.values.iter_mut().zip(&losses.values) {
        *gain = subtract(gain, loss);
    }
    gains.iterations += losses.iterations;
    Ok(gains)
}

fn reach_part<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    rewards: &Part<E::Amount>,
    target: &[bool],
    maximise: bool,
    context: &Context<'_>,
) -> Result<Optimal<E::Amount>, CheckError> {
    let everywhere = vec![true; target.len()];
    let finite = match maximise {
        true => qualitative_optimum(choices, &everywhere, target, false).surely,
        false => {
            Backward::new(choices)
                .sure_for_some(choices, &everywhere, target)
                .0
        }
    };
    let open: Vec<bool> = (0..target.len()).map(|s| finite[s] && !target[s]).collect();
    let free = match maximise {
        true => Vec::new(),
        false => maximal_end_components(choices, &open, |row| rewards.is_free(row)),
    };
    if free.is_empty() {
        let value = |state: usize| match open[state] {
            true => None,
            false if target[state] => Some(E::Amount::zero()),
            false => Some(E::Amount::infinity()),
        };
        let (reward, most) = (&rewards.row, f64::INFINITY);
        if let Some(found) = E::solve_states(choices, reward, &value, maximise, most, context)? {
            return Ok(Optimal::of(found));
        }
    }
    let mut quotient = Quotient::new(choices, maximise);
    quotient.reward = &rewards.row;
    let done = quotient.add_class(Some(E::Amount::zero()));
    quotient.assign(done, target);
    quotient.collapse(free);
    quotient.separate(&open);
    quotient.solve::<E>(&E::Amount::infinity(), context)
}

fn total_part<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    rewards: &Part<E::Amount>,
    maximise: bool,
    context: &Context<'_>,
) -> Result<Optimal<E::Amount>, CheckError> {
    let states = choices.num_states();
    let everywhere = vec![true; states];
    if !maximise {
        let mut free = vec![false; states];
        for component in maximal_end_components(choices, &everywhere, |row| rewards.is_free(row)) {
            component
                .states
                .iter()
                .for_each(|state| free[*state as usize] = true);
        }
        return reach_part::<E>(choices, rewards, &free, false, context);
    }
    let components = maximal_end_components(choices, &everywhere, |_| true);
    let (earning, idle): (Vec<_>, Vec<_>) = (components.into_iter())
        .partition(|component| component.rows.iter().any(|row| !rewards.is_free(*row)));
    let mut endless = vec![false; states];
    for component in &earning {
        component
            .states
            .iter()
            .for_each(|state| endless[*state as usize] = true);
    }
    let (infinite, _) = Backward::new(choices).reaching(&endless, |_| true, |_| true);
    let open: Vec<bool> = infinite.iter().map(|infinite| !infinite).collect();
    let mut quotient = Quotient::new(choices, true);
    quotient.reward = &rewards.row;
    quotient.collapse(
        idle.into_iter()
            .filter(|c| open[c.states[0] as usize])
            .collect(),
    );
    for class in 0..quotient.fixed.len() as u32 {
        quotient.stops.push((class, E::Amount::zero()));
    }
    quotient.separate(&open);
    debug_assert!((0..states).all(|s| open[s] == (quotient.class[s] != NO_CLASS)));
    quotient.solve::<E>(&E::Amount::infinity(), context)
}

/// Steps back from `values`, in the states `from`: each adds a choice's reward, if `rewards` are given, to its mean.
pub(crate) fn steps<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    rewards: Option<&RewardModel<E::Amount>>,
    mut values: Vec<E::Amount>,
    steps: u64,
    from: &[usize],
    maximise: bool,
    context: &Context<'_>,
) -> Result<Vec<E::Amount>, CheckError> {
    let earned = rewards.map(RewardModel::rows);
    let everywhere = vec![true; values.len()];
    let back = Back {
        choices,
        active: &everywhere,
        steps,
        from: Some(from),
        maximise,
    };
    if let Some(found) = E::amounts_back(&back, earned.as_deref(), &values, context)? {
        return Ok(found);
    }
    for step in 0..steps {
        if step % 16 == 0 && context.options.stops()? {
            if E::floats(choices.matrix).is_none() {
                return Err(CheckError::Cancelled);
            }
            let earned = earned.as_deref().unwrap_or_default();
            return Ok(leave_out::<E>(&values, earned, steps - step));
        }
        let mean = |row: usize| {
            let transitions = choices
                .matrix
                .row(row)
                .map(|(target, p)| (p, &values[target]));
            let reward = earned.as_ref().map(|earned| &earned[row]);
            E::Amount::mean(reward, transitions, context.entry_error)
        };
        let best = |state: usize| {
            let means = choices.rows(state).map(mean);
            let found = means.reduce(|a, b| a.best(&b, maximise));
            found.unwrap_or_else(E::Amount::undefined)
        };
        let next: Vec<E::Amount> = (0..values.len()).map(best).collect();
        if next == values {
            break;
        }
        values = next;
    }
    Ok(values)
}

/// Bounds of what steps that are not taken make of the values: means, between the least and the greatest, and what is earned on
/// the way, at most the extremes in each step.
fn leave_out<E: Numbers>(values: &[E::Amount], earned: &[E::Amount], steps: u64) -> Vec<E::Amount> {
    let ends = |of: &[E::Amount]| {
        let of = of.iter().map(Amount::bounds);
        of.reduce(|all, one| Bounds {
            low: all.low.min(one.low),
            high: all.high.max(one.high),
        })
    };
    let of_steps = Bounds {
        low: (steps as f64).next_down(),
        high: (steps as f64).next_up(),
    };
    let earned = ends(earned).map_or(Bounds::ZERO, |earned| earned.mul(&of_steps));
    let all = ends(values).map_or(Bounds::ZERO, |values| values.add(&earned));
    vec![E::from_bounds(all); values.len()]
}

#[cfg(test)]
mod tests;
