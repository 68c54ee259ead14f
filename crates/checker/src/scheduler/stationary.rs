//! Schedulers by the state alone that the methods do not find on their way: where a reward is infinite, and averages.
//!
//! *Infinite before a target* (greatest value): where some scheduler misses the target with positive probability, one
//! that heads for where it can be missed for sure, and stays there. *Infinite in total* (greatest): one that heads for an
//! end component that earns, and for the row there that does. *Least in total*: one that rests where it need not earn.
//!
//! *Averages*: within a maximal end component the choices that attain, for numbers `x`, `d_i = opt over c of r_c + sum_j
//! p_cj (x_j - x_i)`; their gain in each state lies between the least and the greatest `d_i` (Puterman 1994, theorem
//! 8.5.5), so `x` is improved until these are close. Which component to stay in is an optimality problem over the
//! components as states ([`crate::quotient`]). Where the bounds do not come close, none is given.
//!
//! Cost: linear for the first two; for averages that of value iteration. Guarantee: of averages, within [`CLOSE`].

use crate::amount::Amount;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::{Context, Sound};
use crate::graph::{Backward, EndComponent, NO_ROW, maximal_end_components};
use crate::quotient::Quotient;
use crate::rewards::Part;
use crate::rounding::Bounds;

/// The relative distance of the bounds of an average that a scheduler is content with.
const CLOSE: f64 = 1e-10;
/// The distance beyond which no scheduler is given.
const TOO_WIDE: f64 = 1e-6;
const MOST_ROUNDS: u64 = 1_000_000;

/// Completes a scheduler of the greatest reward before a target, where it is infinite.
pub(crate) fn missing<N>(choices: Choices<'_, N>, target: &[bool], scheduler: &mut [usize]) {
    let backward = Backward::new(choices);
    let everywhere = vec![true; target.len()];
    let reaches = backward.unavoidable(choices, &everywhere, target);
    let missed: Vec<bool> = reaches.iter().map(|reaches| !reaches).collect();
    let (infinite, towards) = backward.reaching(&missed, |s| !target[s], |_| true);
    for state in (0..target.len()).filter(|s| infinite[*s] && !target[*s]) {
        let stays = |row: &usize| choices.targets(*row).iter().all(|t| missed[*t as usize]);
        scheduler[state] = match missed[state] {
            true => choices.rows(state).find(stays).unwrap_or(NO_ROW),
            false => towards[state],
        };
    }
}

/// Completes a scheduler of the greatest reward in total, where it is infinite.
pub(crate) fn earning<A: Amount>(
    choices: Choices<'_, A::Entry>,
    rewards: &Part<A>,
    scheduler: &mut [usize],
) {
    let everywhere = vec![true; scheduler.len()];
    let backward = Backward::new(choices);
    let mut stays = vec![false; choices.matrix.num_rows()];
    let (mut earns, mut inside) = (vec![false; scheduler.len()], vec![false; scheduler.len()]);
    for component in maximal_end_components(choices, &everywhere, |_| true) {
        let Some(row) = component.rows.iter().find(|row| !rewards.is_free(**row)) else {
            continue;
        };
        component.rows.iter().for_each(|row| stays[*row] = true);
        let states = component.states.iter();
        states.for_each(|state| inside[*state as usize] = true);
        let owner = backward.owner[*row] as usize;
        earns[owner] = true;
        scheduler[owner] = *row;
    }
    let (_, within) = backward.reaching(&earns, |s| inside[s], |row| stays[row]);
    let (infinite, towards) = backward.reaching(&inside, |_| true, |_| true);
    for state in (0..scheduler.len()).filter(|s| infinite[*s] && !earns[*s]) {
        scheduler[state] = if inside[state] {
            within[state]
        } else {
            towards[state]
        };
    }
}

/// Completes a scheduler of the least reward in total: where nothing more need be earned, it stays there.
pub(crate) fn resting<A: Amount>(
    choices: Choices<'_, A::Entry>,
    rewards: &Part<A>,
    scheduler: &mut [usize],
) {
    let everywhere = vec![true; scheduler.len()];
    let owner = choices.owners();
    for component in maximal_end_components(choices, &everywhere, |row| rewards.is_free(row)) {
        for row in component.rows {
            scheduler[owner[row] as usize] = row;
        }
    }
}

/// A scheduler of the greatest or least long-run average.
pub(crate) fn average(
    choices: Choices<'_, f64>,
    rewards: &Part<Bounds>,
    maximise: bool,
    context: &Context<'_>,
) -> Result<Vec<usize>, CheckError> {
    let everywhere = vec![true; choices.num_states()];
    let components = maximal_end_components(choices, &everywhere, |_| true);
    let mut staying = vec![NO_ROW; everywhere.len()];
    let mut gains = Vec::new();
    let mut x = vec![0.0; everywhere.len()];
    let mut idle = vec![NO_ROW; everywhere.len()];
    if !maximise {
        resting(choices, rewards, &mut idle);
    }
    for component in &components {
        if component.states.iter().any(|s| idle[*s as usize] != NO_ROW) {
            // The least is 0, and attained by going there to rest.
            rest(choices, component, &idle, &mut staying);
            gains.push(0.0);
            continue;
        }
        gains.push(gain(
            choices,
            rewards,
            component,
            maximise,
            &mut x,
            &mut staying,
            context,
        )?);
    }
    let mut inside = vec![false; choices.matrix.num_rows()];
    let rows = components.iter().flat_map(|component| &component.rows);
    rows.for_each(|row| inside[*row] = true);
    let mut quotient = Quotient::new(choices, maximise);
    quotient.collapse(components.clone());
    for (class, gain) in gains.into_iter().enumerate() {
        quotient.stops.push((class as u32, Bounds::exactly(gain)));
    }
    quotient.separate(&everywhere);
    let mut scheduler = quotient.solve::<Sound>(&Bounds::ZERO, context)?.scheduler;
    for component in &components {
        let mut states = component.states.iter().map(|state| *state as usize);
        let leaves = states.any(|s| scheduler[s] != NO_ROW && !inside[scheduler[s]]);
        if !leaves {
            for state in component.states.iter().map(|state| *state as usize) {
                scheduler[state] = staying[state];
            }
        }
    }
    Ok(scheduler)
}

/// Goes, within a component, to where there are `idle` rows.
fn rest(
    choices: Choices<'_, f64>,
    component: &EndComponent,
    idle: &[usize],
    staying: &mut [usize],
) {
    let mut stays = vec![false; choices.matrix.num_rows()];
    component.rows.iter().for_each(|row| stays[*row] = true);
    let goal: Vec<bool> = idle.iter().map(|row| *row != NO_ROW).collect();
    let (_, towards) = Backward::new(choices).reaching(&goal, |_| true, |row| stays[row]);
    for state in component.states.iter().map(|state| *state as usize) {
        staying[state] = if goal[state] {
            idle[state]
        } else {
            towards[state]
        };
    }
}

/// The average of a component, and in `staying` the choices that attain it.
fn gain(
    choices: Choices<'_, f64>,
    rewards: &Part<Bounds>,
    component: &EndComponent,
    maximise: bool,
    x: &mut [f64],
    staying: &mut [usize],
    context: &Context<'_>,
) -> Result<f64, CheckError> {
    let mut rows = component.rows.clone();
    rows.sort_unstable();
    let owner: Vec<u32> = {
        let mut states = component.states.clone();
        states.sort_unstable();
        let of = |row: &usize| {
            let place = states.partition_point(|s| choices.rows(*s as usize).start <= *row);
            states[place - 1]
        };
        rows.iter().map(of).collect()
    };
    let mut next: Vec<(usize, f64)> = Vec::with_capacity(component.states.len());
    for round in 0..MOST_ROUNDS {
        if round % 256 == 0 {
            context.options.check_cancelled()?;
        }
        next.clear();
        for (row, state) in rows.iter().zip(&owner) {
            let state = *state as usize;
            let entries = choices.matrix.row(*row);
            let mean: f64 = entries.map(|(target, p)| p * (x[target] - x[state])).sum();
            let change = rewards.row[*row].middle() + mean;
            match next.last_mut() {
                Some((last, best)) if *last == state => {
                    if (maximise && change > *best) || (!maximise && change < *best) {
                        (*best, staying[state]) = (change, *row);
                    }
                }
                _ => {
                    staying[state] = *row;
                    next.push((state, change));
                }
            }
        }
        let least = next.iter().map(|(_, d)| *d).fold(f64::INFINITY, f64::min);
        let most = (next.iter().map(|(_, d)| *d)).fold(f64::NEG_INFINITY, f64::max);
        let size = least.abs().max(most.abs());
        let close = if round < MOST_ROUNDS / 2 {
            CLOSE
        } else {
            TOO_WIDE
        };
        if most - least <= close * size {
            return Ok(0.5 * (least + most));
        }
        let first = x[next[0].0] + 0.5 * next[0].1;
        for (state, change) in &next {
            x[*state] += 0.5 * change - first;
        }
    }
    Err(CheckError::Unsupported(
        "no scheduler of this average was found whose value is surely within a millionth of it"
            .to_owned(),
    ))
}
