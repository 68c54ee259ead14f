//! Where a chain is: the probabilities of all its states after some steps, at a time, and in the long run.
//!
//! *Definition.* From a distribution over the states (by default equal probabilities of the initial ones), the probability of
//! being in each state after `k` steps (`dtmc`), at time `t` (`ctmc`), or its share of the time in the long run.
//!
//! *Method.* Steps: `y' = y P`. Time: uniformisation (Jensen 1953), as in the crate's module `transient` but forward, so that one
//! sequence of vectors serves all states and all times: the sum of `w_k y_k` with the weights of each time. Long run: the expected
//! visits of the transient states say how probable each bottom component is, and those between two visits to one of its states
//! which share of the time is spent where, both by elimination (module `elimination`), which loses no digits to subtraction.
//!
//! *Guarantee.* Bounds: all terms are positive, so relative errors add up; uniformisation is cut where what is left of the weights
//! is below `CUT`, which is added to the upper bounds. Cost: entries times steps, or times about `q t`; that of an elimination.

use prism_lang::Number;
use prism_lang::resolved::ModelType;

use crate::amount::Amount;
use crate::answer::{CheckError, Options};
use crate::elimination::{GivenUp, System};
use crate::engine::Context;
use crate::graph::bottom_components;
use crate::poisson::Weights;
use crate::rounding::{Bounds, UNIT};
use crate::state_space::{Csr, StateSpace};

/// What may be left of the weights.
const CUT: f64 = 1e-30;
/// Jumps beyond which a time is refused.
const MOST_JUMPS: f64 = 1e9;
/// Multiplications that are spent on eliminating.
const BUDGET: u64 = 3_000_000_000;
/// Products below this may have lost digits.
const SMALLEST: f64 = 1e-290;
/// A relative error beyond which bounds say too little.
const MOST_ERROR: f64 = 1e-3;

/// The probabilities of all states after numbers of steps, ascending, of a chain in discrete time.
///
/// `start` has the probability of each state; equal ones of the initial states if not given. One vector for each number of steps.
///
/// # Errors
/// When the model is no `dtmc`, when it has none but irrational probabilities, or when cancelled.
pub fn after_steps(
    space: &StateSpace<f64>,
    start: Option<&[f64]>,
    steps: &[u64],
    options: &Options<'_>,
) -> Result<Vec<Vec<Bounds>>, CheckError> {
    let flow = Flow::new(space, ModelType::Dtmc, options)?;
    let (mut y, given_error) = beginning(space, start);
    let stay: Vec<f64> = (0..y.len()).map(|_| 0.0).collect();
    let each = flow.context.entry_error + (flow.longest + 1) as f64 * UNIT;
    let (mut found, mut lost) = (Vec::new(), false);
    let mut taken = 0;
    for count in steps {
        while taken < *count {
            if taken.is_multiple_of(16) {
                options.check_cancelled()?;
            }
            let next = flow.step(&y, &stay, &mut lost);
            taken += 1;
            if next == y {
                // Nothing will change any more.
                taken = u64::MAX;
            }
            y = next;
        }
        let error = given_error + *count as f64 * each;
        found.push(bounds_of(&y, error, 0.0, lost));
    }
    Ok(found)
}

/// The probabilities of all states at times, ascending, of a chain in continuous time.
///
/// `start` as in [`after_steps`]. One vector for each time.
///
/// # Errors
/// When the model is no `ctmc`, when a time is so long that too many jumps are expected, or when cancelled.
pub fn at_times(
    space: &StateSpace<f64>,
    start: Option<&[f64]>,
    times: &[Number],
    options: &Options<'_>,
) -> Result<Vec<Vec<Bounds>>, CheckError> {
    let mut flow = Flow::new(space, ModelType::Ctmc, options)?;
    let (mut y, given_error) = beginning(space, start);
    let speed = 1.02 * flow.leaving.iter().copied().fold(0.0, f64::max);
    let stay: Vec<f64> = flow.leaving.iter().map(|r| 1.0 - r / speed).collect();
    flow.value.iter_mut().for_each(|rate| *rate /= speed);
    let mut sums: Vec<Sums> = Vec::with_capacity(times.len());
    for time in times {
        sums.push(Sums::new(speed, &Bounds::literal(time), y.len())?);
    }
    let (mut lost, mut jumps) = (false, 0u64);
    loop {
        for sum in &mut sums {
            sum.add(jumps, &y);
        }
        if sums.iter().all(|sum| sum.last <= jumps) {
            break;
        }
        if jumps.is_multiple_of(16) {
            options.check_cancelled()?;
        }
        y = flow.step(&y, &stay, &mut lost);
        jumps += 1;
    }
    let each = flow.context.entry_error + (flow.longest + 70) as f64 * UNIT;
    let bounds = |sum: &Sums| {
        let steps = sum.last as f64 + sum.mean + 10.0 * sum.mean.sqrt();
        let error = given_error + 2.0 * sum.error + 2.0 * steps * (each + sum.off_time);
        bounds_of(&sum.values, error, sum.rest, lost)
    };
    Ok(sums.iter().map(bounds).collect())
}

/// The share of the time spent in each state in the long run.
///
/// `start` as in [`after_steps`].
///
/// # Errors
/// When the model has choices, when elimination would take too long or its error could not be bounded, or when cancelled.
pub fn in_the_long_run(
    space: &StateSpace<f64>,
    start: Option<&[f64]>,
    options: &Options<'_>,
) -> Result<Vec<Bounds>, CheckError> {
    let flow = Flow::new(space, space.kind, options)?;
    let (y, given_error) = beginning(space, start);
    let components = bottom_components(&space.matrix);
    let mut shares = vec![Bounds::ZERO; y.len()];
    let mut place = vec![u32::MAX; y.len()];
    let arrivals = match components.len() {
        1 => vec![(1.0, 0.0)],
        _ => flow.arrivals(&y, given_error, &components, &mut place, options)?,
    };
    for (component, (arrives, error)) in components.iter().zip(arrivals) {
        let (parts, own_error) = flow.parts(component, &mut place, options)?;
        for (state, part) in component.iter().zip(parts) {
            let share = Bounds::exactly(arrives * part);
            shares[*state as usize] = match (arrives, part) {
                (0.0, _) => Bounds::ZERO,
                // Alone, and reached for certain.
                (1.0, 1.0) if component.len() == 1 => Bounds::ONE,
                _ => share.widened(error + own_error + 2.0 * UNIT),
            };
        }
    }
    Ok(shares)
}

/// The matrix by columns.
struct Flow<'a> {
    rows: &'a Csr<f64>,
    start: Vec<usize>,
    source: Vec<u32>,
    value: Vec<f64>,
    /// The sum of the entries that leave each state.
    leaving: Vec<f64>,
    /// Entries of the longest column.
    longest: usize,
    context: Context<'a>,
}

impl<'a> Flow<'a> {
    fn new(
        space: &'a StateSpace<f64>,
        kind: ModelType,
        options: &'a Options<'a>,
    ) -> Result<Self, CheckError> {
        let is_chain = matches!(space.kind, ModelType::Dtmc | ModelType::Ctmc);
        if space.kind != kind || !is_chain {
            return Err(CheckError::Unsupported(format!(
                "the probabilities of single states are those of a chain (`dtmc`, `ctmc`), but the model is of type `{}`",
                space.kind.keyword()
            )));
        }
        crate::sound::check_entries(&space.matrix)?;
        let mut context = Context::new(options, space.relative_error());
        if !context.entry_error_known {
            return Err(CheckError::Unsupported(
                crate::engine::UNKNOWN_ENTRY_ERROR.to_owned(),
            ));
        }
        let rows = &space.matrix;
        let states = space.num_states();
        let is_discrete = space.kind == ModelType::Dtmc;
        let counts = |state: usize, to: usize| is_discrete || state != to;
        let mut start = vec![0; states + 1];
        let mut leaving = vec![0.0; states];
        let mut longest_row = 0;
        for (state, leaving) in leaving.iter_mut().enumerate() {
            for (to, value) in rows.row(state).filter(|(to, _)| counts(state, *to)) {
                start[to + 1] += 1;
                *leaving += if to == state { 0.0 } else { *value };
            }
            longest_row = longest_row.max(rows.row_start[state + 1] - rows.row_start[state]);
        }
        let longest = start.iter().copied().max().unwrap_or(0);
        for state in 0..states {
            start[state + 1] += start[state];
        }
        if !is_discrete {
            context.entry_error += (longest_row + 2) as f64 * UNIT;
        }
        let mut next = start.clone();
        let mut source = vec![0; start[states]];
        let mut values = vec![0.0; start[states]];
        for state in 0..states {
            for (to, value) in rows.row(state).filter(|(to, _)| counts(state, *to)) {
                source[next[to]] = state as u32;
                values[next[to]] = *value;
                next[to] += 1;
            }
        }
        Ok(Self {
            rows,
            start,
            source,
            value: values,
            leaving,
            longest,
            context,
        })
    }

    /// One step on; `lost` if products were so small that digits may be lost.
    fn step(&self, y: &[f64], stay: &[f64], lost: &mut bool) -> Vec<f64> {
        let mut least = f64::INFINITY;
        let mut product = |a: f64, b: f64| {
            let product = a * b;
            if product < least && a > 0.0 && b > 0.0 {
                least = product;
            }
            product
        };
        let next = (0..y.len())
            .map(|state| {
                let mut sum = product(y[state], stay[state]);
                for at in self.start[state]..self.start[state + 1] {
                    sum += product(y[self.source[at] as usize], self.value[at]);
                }
                sum
            })
            .collect();
        *lost |= least < SMALLEST;
        next
    }

    /// The probability of each bottom component, with the bound of its relative error.
    fn arrivals(
        &self,
        y: &[f64],
        given_error: f64,
        components: &[Vec<u32>],
        place: &mut [u32],
        options: &Options<'_>,
    ) -> Result<Vec<(f64, f64)>, CheckError> {
        let mut is_bottom = vec![false; y.len()];
        for state in components.iter().flatten() {
            is_bottom[*state as usize] = true;
        }
        let transient: Vec<u32> = (0..y.len() as u32)
            .filter(|s| !is_bottom[*s as usize])
            .collect();
        let inflow = transient.iter().map(|s| y[*s as usize]).collect();
        let (visits, error) = self.visits(&transient, inflow, place, options)?;
        let mut arriving = y.to_vec();
        for (state, visits) in transient.iter().zip(visits) {
            for (to, value) in self.rows.row(*state as usize) {
                if is_bottom[to] {
                    arriving[to] += visits * value;
                }
            }
        }
        let arrives = |component: &Vec<u32>| {
            let sum: f64 = component.iter().map(|s| arriving[*s as usize]).sum();
            let terms = component.len() + self.longest + 2;
            let error = given_error + error + self.context.entry_error + terms as f64 * UNIT;
            // Certain without any way that leads elsewhere.
            (
                sum,
                if transient.is_empty() && y.contains(&1.0) {
                    0.0
                } else {
                    error
                },
            )
        };
        Ok(components.iter().map(arrives).collect())
    }

    /// The share of each state of a bottom component, with the bound of their relative error.
    fn parts(
        &self,
        component: &[u32],
        place: &mut [u32],
        options: &Options<'_>,
    ) -> Result<(Vec<f64>, f64), CheckError> {
        let (first, others) = component.split_first().expect("components have states");
        if others.is_empty() {
            return Ok((vec![1.0], 0.0));
        }
        let mut inflow = vec![0.0; others.len()];
        for (at, state) in others.iter().enumerate() {
            place[*state as usize] = at as u32;
        }
        for (to, value) in self.rows.row(*first as usize) {
            if to != *first as usize {
                inflow[place[to] as usize] += value;
            }
        }
        let (visits, error) = self.visits(others, inflow, place, options)?;
        let sum = 1.0 + visits.iter().sum::<f64>();
        let parts = std::iter::once(1.0)
            .chain(visits)
            .map(|visits| visits / sum);
        Ok((
            parts.collect(),
            2.0 * error + (component.len() + 2) as f64 * UNIT,
        ))
    }

    /// The expected visits of states (the time, with rates) before they are left for others, by what comes in. `place` has no
    /// places before and after.
    fn visits(
        &self,
        states: &[u32],
        inflow: Vec<f64>,
        place: &mut [u32],
        options: &Options<'_>,
    ) -> Result<(Vec<f64>, f64), CheckError> {
        for (at, state) in states.iter().enumerate() {
            place[*state as usize] = at as u32;
        }
        let mut system = System {
            rows: Vec::with_capacity(states.len()),
            rhs: Vec::new(),
        };
        for state in states {
            let (mut row, mut out) = (Vec::new(), 0.0);
            for (to, value) in self.rows.row(*state as usize) {
                match place[to] {
                    _ if to == *state as usize => {}
                    u32::MAX => out += value,
                    at => row.push((at, *value)),
                }
            }
            row.sort_unstable_by_key(|(at, _)| *at);
            system.rows.push(row);
            system.rhs.push([out]);
        }
        states
            .iter()
            .for_each(|state| place[*state as usize] = u32::MAX);
        let size = states.len() as f64;
        let (visits, error) = match system.visits(inflow, BUDGET, &|| options.is_cancelled()) {
            Ok(found) => found,
            Err(GivenUp::Cancelled) => return Err(CheckError::Cancelled),
            Err(_) => return Err(too_large(states.len())),
        };
        let error = error + 4.0 * (size + 1.0) * self.context.entry_error;
        if error > MOST_ERROR {
            return Err(too_large(states.len()));
        }
        Ok((visits, error))
    }
}

fn too_large(states: usize) -> CheckError {
    CheckError::Unsupported(format!(
        "the shares of single states cannot be bounded where {states} states are to be eliminated: ask for sets of states, as in \
         `S=? [ x=1 ]`"
    ))
}

/// The distribution at the start, and the bound of its relative error.
fn beginning(space: &StateSpace<f64>, start: Option<&[f64]>) -> (Vec<f64>, f64) {
    if let Some(start) = start {
        return (start.to_vec(), 0.0);
    }
    let initial = space.initial_states();
    let mut y = vec![0.0; space.num_states()];
    for state in initial {
        y[*state] = 1.0 / initial.len() as f64;
    }
    (y, if initial.len() == 1 { 0.0 } else { UNIT })
}

/// Bounds of probabilities that were computed with a relative error, of which this much may be left out.
fn bounds_of(values: &[f64], error: f64, rest: f64, lost: bool) -> Vec<Bounds> {
    let bounds = |value: &f64| {
        if *value == 0.0 && !lost {
            return Bounds {
                low: 0.0,
                high: rest,
            };
        }
        if error == 0.0 && rest == 0.0 && !lost {
            return Bounds::exactly(*value);
        }
        let widened = Bounds::exactly(*value).widened(error);
        Bounds {
            low: widened.low,
            high: (widened.high + rest).min(1.0),
        }
    };
    values.iter().map(bounds).collect()
}

/// The weighted sum for one time.
struct Sums {
    weights: Option<Weights>,
    mean: f64,
    /// The last number of jumps that is added.
    last: u64,
    /// What is left out at most.
    rest: f64,
    error: f64,
    off_time: f64,
    values: Vec<f64>,
}

impl Sums {
    fn new(speed: f64, time: &Bounds, states: usize) -> Result<Self, CheckError> {
        let mean = speed * time.middle();
        if mean.is_nan() || mean > MOST_JUMPS {
            return Err(CheckError::Unsupported(format!(
                "the time times the greatest rate is {mean:e}, more than the {MOST_JUMPS:e} jumps that can be followed; ask for a \
                 shorter time, or for the long run"
            )));
        }
        let mut sums = Self {
            weights: None,
            mean,
            last: 0,
            rest: 0.0,
            error: 0.0,
            off_time: 0.0,
            values: vec![0.0; states],
        };
        if mean > 0.0 {
            let weights = Weights::new(mean);
            let tails = weights.tails();
            let last = tails.iter().position(|tail| *tail <= CUT);
            sums.last = last.map_or(weights.last(), |last| last as u64);
            sums.rest = 2.0 * tails[sums.last as usize] + 1e-270;
            sums.error = weights.error;
            sums.off_time = (time.high - time.low) / time.middle();
            sums.weights = Some(weights);
        }
        Ok(sums)
    }

    fn add(&mut self, jumps: u64, y: &[f64]) {
        let weight = match &self.weights {
            _ if jumps > self.last => return,
            None => 1.0,
            Some(weights) => weights.of(jumps),
        };
        if weight > 0.0 {
            for (value, y) in self.values.iter_mut().zip(y) {
                *value += weight * y;
            }
        }
    }
}

#[cfg(test)]
mod tests;
