//! Least and greatest probability of an until formula over schedulers.
//!
//! *Unbounded.* Where it is exactly 0 or 1 is found first ([`crate::graph::qualitative_optimum`]). For the
//! greatest probability, the maximal end components of the other states are collapsed, since staying in one for
//! ever gains nothing; for the least there are none, since there every scheduler has a chance of the target.
//! Then [`crate::optimum`].
//!
//! *Bounded in steps.* `x'_i = opt over c of sum_j p_cj x_j`, step by step from the target's indicator; the
//! scheduler counts steps, so that none is kept.
//!
//! *Over fair schedulers* only the least unbounded one differs: [`crate::fairness`].
//!
//! Source: Baier and Katoen 2008, section 10.6; Bianco and de Alfaro 1995. Guarantee: that of the engine.

use prism_lang::Arithmetic;

use crate::amount::Amount;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::{Context, Numbers, leave_out, start_at_nothing};
use crate::fairness;
use crate::graph::{NO_ROW, Optimum, maximal_end_components, optimum};
use crate::quotient::{Optimal, Quotient};
use crate::steps::Back;

/// Values in all states, a scheduler that attains them if one does at all times, and the rounds of iteration.
pub(crate) type Found<V> = (Vec<V>, Option<Vec<usize>>, u64);

/// `left U right` within the steps `first..=last`, in the states `from` (all if not given); others may have bounds that say
/// nothing.
pub(crate) fn until<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    left: &[bool],
    right: &[bool],
    (first, last): (u64, Option<u64>),
    from: Option<&[usize]>,
    maximise: bool,
    context: &Context<'_>,
) -> Result<Found<E::Value>, CheckError> {
    let known = optimum(choices, left, right, maximise);
    let sets = &known.sets;
    let (mut values, mut scheduler, mut iterations) = (Vec::new(), None, 0);
    let fair = context.options.fair;
    match last {
        None if fair && !maximise => {
            (values, iterations) = fairness::least_until::<E>(choices, left, right, context)?;
        }
        None => {
            let optimal = unbounded::<E>(choices, left, &known, maximise, context)?;
            values.extend(optimal.values.iter().map(E::probability));
            // One that is the same at all times may stay away from a choice for ever.
            scheduler = (first == 0 && !fair).then_some(optimal.scheduler);
            iterations = optimal.iterations;
        }
        Some(last) => {
            values.extend(right.iter().map(|right| E::indicator(*right)));
            let active: Vec<bool> = (0..left.len())
                .map(|s| !sets.never[s] && !right[s])
                .collect();
            let steps = last.saturating_sub(first);
            let back = Back {
                choices,
                active: &active,
                steps,
                from: from.filter(|_| first == 0),
                maximise,
            };
            steps_back::<E>(&back, &mut values, context)?;
        }
    }
    if first > 0 {
        let mut back = Back {
            choices,
            active: left,
            steps: 1,
            from: None,
            maximise,
        };
        steps_back::<E>(&back, &mut values, context)?;
        for (value, left) in values.iter_mut().zip(left) {
            if !left {
                *value = E::indicator(false);
            }
        }
        back.steps = first - 1;
        steps_back::<E>(&back, &mut values, context)?;
    }
    Ok((values, scheduler, iterations))
}

/// The probability that the next state is in `operand`.
pub(crate) fn next<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    operand: &[bool],
    maximise: bool,
    context: &Context<'_>,
) -> Result<Vec<E::Value>, CheckError> {
    let mut values = operand.iter().map(|holds| E::indicator(*holds)).collect();
    let everywhere = vec![true; operand.len()];
    let back = Back {
        choices,
        active: &everywhere,
        steps: 1,
        from: None,
        maximise,
    };
    steps_back::<E>(&back, &mut values, context)?;
    Ok(values)
}

/// Replaces the values of the active states by the best mean over their choices, `steps` times.
fn steps_back<E: Numbers>(
    back: &Back<'_, E::Entry>,
    values: &mut Vec<E::Value>,
    context: &Context<'_>,
) -> Result<(), CheckError> {
    if let Some(found) = E::probabilities_back(back, values, context)? {
        *values = found;
        return Ok(());
    }
    let Back {
        choices,
        active,
        steps,
        maximise,
        ..
    } = *back;
    let states: Vec<usize> = (0..active.len()).filter(|state| active[*state]).collect();
    let mut next = values.clone();
    let grows = start_at_nothing::<E>(values, &states);
    for step in 0..steps {
        if step % 16 == 0 && context.options.stops()? {
            return leave_out::<E>(values, &states, grows);
        }
        let mut changed = false;
        for state in &states {
            let mean = |row: usize| {
                let transitions = choices.matrix.row(row);
                E::mean(transitions.map(|(target, p)| (p, &values[target])), context)
            };
            let means = choices.rows(*state).map(mean);
            let Some(new) = means.reduce(|a, b| E::best(&a, &b, maximise)) else {
                continue;
            };
            changed |= new != values[*state];
            next[*state] = new;
        }
        std::mem::swap(values, &mut next);
        if !changed {
            break;
        }
    }
    Ok(())
}

fn unbounded<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    left: &[bool],
    known: &Optimum,
    maximise: bool,
    context: &Context<'_>,
) -> Result<Optimal<E::Amount>, CheckError> {
    let sets = &known.sets;
    let open: Vec<bool> = (0..left.len())
        .map(|s| !sets.never[s] && !sets.surely[s])
        .collect();
    let collapsed = match maximise {
        true => maximal_end_components(choices, &open, |_| true),
        false => Vec::new(),
    };
    if collapsed.is_empty() {
        let value = |state: usize| match open[state] {
            true => None,
            false if sets.surely[state] => Some(E::Amount::one()),
            false => Some(E::Amount::zero()),
        };
        if let Some(found) = E::solve_states(choices, &[], &value, maximise, 1.0, context)? {
            let mut optimal = Optimal::of(found);
            complete(choices, left, known, maximise, &mut optimal.scheduler);
            return Ok(optimal);
        }
    }
    let mut quotient = Quotient::new(choices, maximise);
    quotient.cap = 1.0;
    let zero = quotient.add_class(Some(E::Amount::zero()));
    let one = quotient.add_class(Some(E::Amount::one()));
    quotient.assign(zero, &sets.never);
    quotient.assign(one, &sets.surely);
    quotient.collapse(collapsed);
    quotient.separate(&open);
    let mut optimal = quotient.solve::<E>(&E::Amount::zero(), context)?;
    complete(choices, left, known, maximise, &mut optimal.scheduler);
    Ok(optimal)
}

/// What the scheduler does where the probability is 0 or 1.
fn complete<N: Arithmetic>(
    choices: Choices<'_, N>,
    left: &[bool],
    known: &Optimum,
    maximise: bool,
    scheduler: &mut [usize],
) {
    if choices.is_chain() {
        return;
    }
    let sets = &known.sets;
    if maximise {
        for (state, surely) in sets.surely.iter().enumerate() {
            if *surely {
                scheduler[state] = known.towards[state];
            }
        }
        return;
    }
    for (state, never) in sets.never.iter().enumerate() {
        if *never && left[state] {
            let keeps = |target: &u32| sets.never[*target as usize];
            let found = choices
                .rows(state)
                .find(|row| choices.targets(*row).iter().all(keeps));
            scheduler[state] = found.unwrap_or(NO_ROW);
        }
    }
}

#[cfg(test)]
mod tests;
