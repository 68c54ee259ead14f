//! Long-run averages: rewards for each step (or unit of time), and the share of time spent in states.
//!
//! *Definition.* The limit of the expected reward in `n` steps (in time `t`) over `n` (over `t`), its optimum
//! over schedulers. With probability 1 a path ends in an end component; within one the optimum, its *gain*, is
//! the same for all states. So the value is the optimum of the expected gain of the component in which the path
//! stays: [`crate::optimum`] with maximal end components collapsed that may stop with their gain.
//!
//! *Gain of a component*, without alternatives: with a state `z`, the expected reward of a round trip from `z`
//! over its expected time (renewal theorem), both by elimination ([`crate::elimination`]) without subtraction,
//! hence with small relative error. If that takes more than some work for each transition, or with alternatives: for any
//! numbers `x`
//!
//! ```text
//! min_i d_i  <=  gain  <=  max_i d_i       d_i = opt over c of  r_c + sum_j p_cj (x_j - x_i)
//! ```
//!
//! (Puterman 1994, theorem 8.5.5); `x` is improved by `x_i += d_i / 2` until the bounds are close. `d` is
//! computed to nearest and its rounding error added. The same holds with rates for `p`, per unit of time. The
//! improvement goes state by state in place (Gauss-Seidel), and where that is slow `x` comes from linear equations
//! ([`krylov`]), which changes nothing of the guarantee: see [`iteration`]. Where neither helps, elimination is tried with
//! more work.
//!
//! *Methods by name* ([`crate::Method`]): elimination alone, or the shares of time by the classical iterations
//! ([`stationary`]), without alternatives; value iteration with them.
//!
//! Source: Puterman 1994, chapters 8 and 9; Ashok, Chatterjee, Daca, Křetínský and Meggendorfer 2017, "Value
//! iteration for long-run average reward in Markov decision processes". Guarantee: that of the engine; exact
//! arithmetic solves models without alternatives only.

use prism_lang::Arithmetic;

use crate::amount::Amount;
use crate::answer::{CheckError, Options};
use crate::choices::Choices;
use crate::diagonals::Keys;
use crate::elimination::{GivenUp, System};
use crate::engine::{Context, Numbers};
use crate::graph::{EndComponent, is_seen_to_be_strongly_connected, maximal_end_components};
use crate::method::Method;
use crate::quotient::{Optimal, Quotient};
use crate::rewards::Part;
use crate::rounding::{Bounds, UNIT};
use crate::sound::not_eliminated;
use crate::stop::Stop;

mod iteration;
mod krylov;
mod stationary;
use iteration::Iteration;
use stationary::Flows;

/// Multiplications that are spent on eliminating a component before iteration, and some for each of its entries.
const FIRST_BUDGET: u64 = 10_000_000;
const BUDGET_OF_ENTRY: u64 = 8;
/// Components with fewer states than this, or fewer transitions for each state, are eliminated first.
const SMALL: usize = 2_000;
const SPARSE: usize = 4;
/// The same after iteration that was cut short.
const BUDGET: u64 = 300_000_000;

/// The long-run average of rewards that are not negative, in all states.
///
/// `embedded` has the probabilities by which components are reached, `rates` those (or the rates) by which time
/// passes; they are the same matrix in discrete time. `part.row` is earned per step, or per unit of time.
pub(crate) fn average<'m, E: Numbers>(
    embedded: impl FnOnce() -> Choices<'m, E::Entry>,
    rates: Choices<'_, E::Entry>,
    keys: impl FnOnce() -> Option<Keys>,
    part: &Part<E::Amount>,
    maximise: bool,
    context: &Context<'_>,
) -> Result<Optimal<E::Amount>, CheckError> {
    if rates.is_chain() && is_seen_to_be_strongly_connected(rates.matrix) {
        return everywhere_the_same::<E>(rates, keys, part, context);
    }
    let embedded = embedded();
    let everywhere = vec![true; embedded.num_states()];
    let components = maximal_end_components(embedded, &everywhere, |_| true);
    let mut gains = Vec::with_capacity(components.len());
    let mut local = vec![u32::MAX; everywhere.len()];
    let mut iterations = 0;
    let idle = idle(embedded, part, maximise);
    for component in &components {
        if !stops::<E>(context) {
            context.options.check_cancelled()?;
        }
        let (gain, rounds) = match component.states.iter().any(|s| idle[*s as usize]) {
            true => (E::Amount::zero(), 0),
            false => gain::<E>(rates, part, component, maximise, &mut local, context)?,
        };
        gains.push(gain);
        iterations += rounds;
    }
    if let Some(first) = gains.first()
        && embedded.is_chain()
        && first.bounds().is_exact()
        && gains.iter().all(|gain| gain == first)
    {
        // Every path ends in one of them.
        return Ok(Optimal {
            values: vec![first.clone(); everywhere.len()],
            scheduler: Vec::new(),
            iterations,
        });
    }
    let mut quotient = Quotient::new(embedded, maximise);
    quotient.collapse(components);
    for (class, gain) in gains.into_iter().enumerate() {
        quotient.stops.push((class as u32, gain));
    }
    quotient.separate(&everywhere);
    let mut optimal = quotient.solve::<E>(&E::Amount::zero(), context)?;
    optimal.iterations += iterations;
    Ok(optimal)
}

/// The average in a chain that is one component.
fn everywhere_the_same<E: Numbers>(
    rates: Choices<'_, E::Entry>,
    keys: impl FnOnce() -> Option<Keys>,
    part: &Part<E::Amount>,
    context: &Context<'_>,
) -> Result<Optimal<E::Amount>, CheckError> {
    let states = rates.num_states();
    let mut order: Vec<u32> = (0..states as u32).collect();
    // Neighbours in this order lead to neighbours, which are near in memory.
    if let Some(keys) = keys() {
        order.sort_unstable_by_key(|state| keys.of[*state as usize]);
    }
    let component = EndComponent {
        rows: order.iter().map(|state| *state as usize).collect(),
        states: order,
    };
    let mut local = vec![u32::MAX; states];
    let (gain, iterations) = gain::<E>(rates, part, &component, true, &mut local, context)?;
    Ok(Optimal {
        values: vec![gain; states],
        scheduler: Vec::new(),
        iterations,
    })
}

/// Where a scheduler that earns as little as it can may earn nothing for ever: there, and in the whole component
/// around, the least gain is exactly 0.
fn idle<A: Amount>(choices: Choices<'_, A::Entry>, part: &Part<A>, maximise: bool) -> Vec<bool> {
    let mut idle = vec![false; choices.num_states()];
    if !maximise {
        let everywhere = vec![true; idle.len()];
        let free = maximal_end_components(choices, &everywhere, |row| part.is_free(row));
        for state in free.iter().flat_map(|component| &component.states) {
            idle[*state as usize] = true;
        }
    }
    idle
}

fn gain<E: Numbers>(
    rates: Choices<'_, E::Entry>,
    part: &Part<E::Amount>,
    component: &EndComponent,
    maximise: bool,
    local: &mut [u32],
    context: &Context<'_>,
) -> Result<(E::Amount, u64), CheckError> {
    if component.rows.iter().all(|row| part.is_free(*row)) {
        return Ok((E::Amount::zero(), 0));
    }
    if let Some(same) = earned_everywhere(part, component) {
        return Ok((same, 0));
    }
    if stops::<E>(context) {
        return Ok((between_rewards::<E>(part, component, None), 0));
    }
    for (place, state) in component.states.iter().enumerate() {
        local[*state as usize] = place as u32;
    }
    let is_chain = component.rows.len() == component.states.len();
    let entries = component.rows.iter().map(|row| rates.entries(*row).len());
    let entries: usize = entries.sum();
    let is_simple = component.states.len() < SMALL || entries < SPARSE * component.states.len();
    let first = FIRST_BUDGET + BUDGET_OF_ENTRY * entries as u64;
    let directly = |budget: u64| -> Result<Option<(E::Amount, u64)>, CheckError> {
        let found = match is_chain {
            true => round_trip::<E>(rates, part, component, local, budget, context)?,
            false => None,
        };
        Ok(found.map(|gain| (gain, 0)))
    };
    let iterated = || -> Result<(E::Amount, u64), CheckError> {
        let Some(matrix) = E::floats(rates.matrix) else {
            return Err(CheckError::Unsupported(
                "long-run averages over schedulers cannot be computed exactly yet: use the sound method"
                    .to_owned(),
            ));
        };
        let rewards = component.rows.iter().map(|row| part.row[*row].bounds());
        let rewards: Vec<Bounds> = rewards.collect();
        let rows = |state: u32| rates.rows(state as usize);
        let work = Iteration::new(matrix, rows, &rewards, component, local);
        let of_bounds = |(bounds, rounds)| (E::from_bounds(bounds), rounds);
        if is_chain {
            if let Some(found) = work.quickly(context)? {
                return Ok(of_bounds(found));
            }
            if let Some(found) = directly(BUDGET)? {
                return Ok(found);
            }
        }
        work.run(maximise, context).map(of_bounds)
    };
    let found = match E::method(context.options.method) {
        Method::Sound | Method::PrismDefault | Method::Exact => match is_simple {
            true => directly(first).and_then(|found| found.map_or_else(iterated, Ok)),
            false => iterated(),
        },
        method if method.is_direct() && is_chain => directly(u64::MAX)
            .and_then(|found| found.ok_or_else(|| not_eliminated(component.states.len()))),
        method => by_name::<E>(method, rates, part, component, maximise, local, context),
    };
    component
        .states
        .iter()
        .for_each(|state| local[*state as usize] = u32::MAX);
    match found {
        Err(CheckError::Cancelled) if stops::<E>(context) => {
            Ok((between_rewards::<E>(part, component, None), 0))
        }
        Ok((gain, rounds)) if is_cut::<E>(context) => {
            Ok((between_rewards::<E>(part, component, Some(&gain)), rounds))
        }
        found => found,
    }
}

/// What all choices of a component earn, if that is known and the same: then it is the gain.
fn earned_everywhere<A: Amount>(part: &Part<A>, component: &EndComponent) -> Option<A> {
    let (first, others) = component.rows.split_first()?;
    let first = &part.row[*first];
    let same = others.iter().all(|row| part.row[*row] == *first);
    (same && first.bounds().is_exact()).then(|| first.clone())
}

/// Whether the method has bounds, so that they are there when a check is stopped.
fn has_bounds<E: Numbers>(context: &Context<'_>) -> bool {
    let method = E::method(context.options.method);
    !method.is_estimate() && method != Method::Exact
}

/// Whether to stop and take the bounds that there are.
fn stops<E: Numbers>(context: &Context<'_>) -> bool {
    has_bounds::<E>(context) && context.options.must_stop()
}

/// Whether what was found may have been cut short.
fn is_cut<E: Numbers>(context: &Context<'_>) -> bool {
    has_bounds::<E>(context) && context.options.stop.is_some_and(Stop::is_cut)
}

/// The gain is a mean of what the component's choices earn; and within what is known besides.
fn between_rewards<E: Numbers>(
    part: &Part<E::Amount>,
    component: &EndComponent,
    known: Option<&E::Amount>,
) -> E::Amount {
    let none = Bounds {
        low: f64::INFINITY,
        high: 0.0,
    };
    let rewards = component.rows.iter().map(|row| part.row[*row].bounds());
    let of_all = rewards.fold(none, |all, reward| Bounds {
        low: all.low.min(reward.low),
        high: all.high.max(reward.high),
    });
    let known = known.map(Amount::bounds);
    E::from_bounds(Bounds {
        low: known.map_or(of_all.low, |known| known.low.max(of_all.low)),
        high: known.map_or(of_all.high, |known| known.high.min(of_all.high)),
    })
}

/// The gain by a classical iteration.
fn by_name<E: Numbers>(
    method: Method,
    rates: Choices<'_, E::Entry>,
    part: &Part<E::Amount>,
    component: &EndComponent,
    maximise: bool,
    local: &[u32],
    context: &Context<'_>,
) -> Result<(E::Amount, u64), CheckError> {
    let refused = || {
        CheckError::Unsupported(format!(
            "long-run averages over schedulers cannot be computed by {}: use value iteration or the sound method",
            method.term()
        ))
    };
    let matrix = E::floats(rates.matrix).ok_or_else(refused)?;
    let rewards: Vec<Bounds> = component
        .rows
        .iter()
        .map(|row| part.row[*row].bounds())
        .collect();
    if component.rows.len() == component.states.len() {
        let flows = Flows::new(matrix, component, local);
        let (shares, rounds) = flows.shares(context.options)?;
        let pairs = shares.iter().zip(&rewards);
        let gain = pairs.map(|(share, reward)| share * reward.middle()).sum();
        return Ok((E::from_bounds(Bounds::exactly(gain)), rounds));
    }
    if method != Method::ValueIteration {
        return Err(refused());
    }
    let rows = |state: u32| rates.rows(state as usize);
    let work = Iteration::new(matrix, rows, &rewards, component, local);
    // Its stopping rule: values grow by nearly as much everywhere.
    let options = Options {
        precision: 2.0 * context.options.epsilon,
        ..*context.options
    };
    let context = Context {
        options: &options,
        ..*context
    };
    let (bounds, rounds) = work.run(maximise, &context)?;
    Ok((E::from_bounds(bounds), rounds))
}

/// Expected reward over expected time of a round trip; nothing if that takes too long.
fn round_trip<E: Numbers>(
    rates: Choices<'_, E::Entry>,
    part: &Part<E::Amount>,
    component: &EndComponent,
    local: &[u32],
    budget: u64,
    context: &Context<'_>,
) -> Result<Option<E::Amount>, CheckError> {
    let entry = |amount: &E::Amount, high: bool| E::entry_of(amount, high);
    let one = <E::Entry as Arithmetic>::one;
    let zero = <E::Entry as Arithmetic>::zero;
    let mut system: System<E::Entry, 4> = System {
        rows: Vec::new(),
        rhs: Vec::new(),
    };
    let mut first = Vec::new();
    for (place, row) in component.rows.iter().enumerate() {
        let (mut entries, mut back) = (Vec::new(), zero());
        for (target, p) in rates.matrix.row(*row) {
            match local[target] as usize {
                to if to == place => {}
                0 => back = back.add(p),
                to => entries.push((to as u32 - 1, p.clone())),
            }
        }
        entries.sort_unstable_by_key(|(column, _)| *column);
        let reward = &part.row[*row];
        let rhs = [back, entry(reward, false), entry(reward, true), one()];
        match place {
            0 => first = vec![(entries, rhs)],
            _ => {
                system.rows.push(entries);
                system.rhs.push(rhs);
            }
        }
    }
    let cancelled = || context.options.is_cancelled();
    let budget = if <E::Entry as Arithmetic>::EXACT {
        u64::MAX
    } else {
        budget
    };
    let solution = match system.solve(budget, &cancelled) {
        Ok(solution) => solution,
        Err(GivenUp::Cancelled) => return Err(CheckError::Cancelled),
        Err(_) => return Ok(None),
    };
    let Some((entries, [_, low, high, time])) = first.pop() else {
        return Ok(None);
    };
    let mut sums = [low, high, time];
    for (column, p) in &entries {
        for (place, sum) in sums.iter_mut().enumerate() {
            *sum = sum.add(&p.mul(&solution.values[*column as usize][place + 1]));
        }
    }
    let [low, high, time] = sums;
    let size = component.states.len() as f64;
    let error = 2.0 * solution.relative_error
        + 4.0 * (size + 1.0) * context.entry_error
        + (4 * entries.len() + 8) as f64 * UNIT;
    match (low.div(&time), high.div(&time)) {
        (Some(low), Some(high)) => Ok(Some(E::between(&low, &high, error))),
        _ => Ok(None),
    }
}

#[cfg(test)]
mod tests;
