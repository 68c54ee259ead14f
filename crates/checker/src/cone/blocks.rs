//! The walk back of a chain within a cone, by blocks of states ([`crate::diagonals`]).
//!
//! *Definition.* That of [`super`], for one problem without choices. A block is computed at each step at which one of its states is
//! needed; what others in it get then is not asked for, and nothing that is needed depends on it. Worth it where many
//! steps are taken through most of a model.

use super::Cone;
use crate::diagonals::{Diagonals, Keys, LANES, Order, UNUSED};

/// Fewer steps do not pay for the order.
const FEWEST_STEPS: usize = 48;
/// One of so many states must be within the cone.
const LEAST_PART: usize = 3;

/// Values that go back step by step.
#[derive(Debug)]
pub(crate) struct BlockWalk {
    order: Order,
    matrix: Diagonals,
    /// The first and the last step at which each block is needed.
    span: Vec<(u32, u32)>,
    now: Vec<f64>,
    next: Vec<f64>,
    step: u32,
}

impl BlockWalk {
    /// From `value` of each state; `entries` gives the row of a state. Nothing if it is not worth it.
    pub fn new(
        cone: &Cone,
        steps: usize,
        keys: impl FnOnce() -> Option<Keys>,
        value: impl Fn(usize) -> f64,
        entries: impl Fn(usize, &mut Vec<(u32, f64)>),
    ) -> Option<Self> {
        if steps < FEWEST_STEPS || cone.states.len() * LEAST_PART < cone.all {
            return None;
        }
        let order = Order::new(&keys()?, 0..cone.all as u32);
        let mut span = vec![(u32::MAX, 0); order.states.len() / LANES];
        let mut is_inside = vec![false; cone.all];
        let mut distance = 0;
        for (at, (state, first)) in cone.states.iter().zip(&cone.first).enumerate() {
            while cone.within[distance] <= at {
                distance += 1;
            }
            is_inside[*state as usize] = true;
            let span = &mut span[order.row[*state as usize] as usize / LANES];
            let last = u32::try_from(steps.saturating_sub(distance)).unwrap_or(u32::MAX);
            *span = (span.0.min(*first), span.1.max(last));
        }
        let row = |state: usize, into: &mut Vec<(u32, f64)>| match is_inside[state] {
            true => entries(state, into),
            false => into.push((state as u32, 1.0)),
        };
        let matrix = Diagonals::new(&order, row)?;
        let mut now = vec![0.0; order.states.len() + 2 * LANES];
        let rows = order.states.iter().zip(&mut now[LANES..]);
        for (state, now) in rows.filter(|(state, _)| **state != UNUSED) {
            *now = value(*state as usize);
        }
        Some(Self {
            next: now.clone(),
            now,
            order,
            matrix,
            span,
            step: 0,
        })
    }

    /// The present value of a state that is needed, or is outside of the cone.
    pub fn value(&self, state: usize) -> f64 {
        self.now[self.order.row[state] as usize + LANES]
    }

    /// The greatest number of entries of a row.
    pub fn longest(&self) -> usize {
        self.matrix.longest()
    }

    /// One step more; whether any value has changed. If not, none that is asked for ever will.
    pub fn advance(&mut self) -> bool {
        self.step += 1;
        let mut changed = false;
        for (block, (first, last)) in self.span.iter().enumerate() {
            if !(*first..=*last).contains(&self.step) {
                continue;
            }
            let new = self.matrix.product(block, &self.now);
            let range = (block + 1) * LANES..(block + 2) * LANES;
            let places = self.next[range.clone()].iter_mut().zip(&self.now[range]);
            for ((next, now), new) in places.zip(new) {
                changed |= new != *now;
                *next = new;
            }
        }
        std::mem::swap(&mut self.now, &mut self.next);
        changed
    }
}

#[cfg(test)]
mod tests {
    use super::super::Walk;
    use super::*;
    use crate::choices::Choices;
    use crate::state_space::Csr;

    /// A walk on a grid of `side` times `side` places that drifts to one corner.
    fn grid(side: u32) -> (Csr<f64>, Keys) {
        let rows = (0..side * side).map(|place| {
            let (x, y) = (place / side, place % side);
            let mut row = Vec::new();
            row.extend((x > 0).then(|| (place - side, 0.125)));
            row.extend((y > 0).then(|| (place - 1, 0.0625)));
            row.extend((y + 1 < side).then(|| (place + 1, 0.25)));
            row.extend((x + 1 < side).then(|| (place + side, 0.375)));
            row.push((place, 0.1875));
            row
        });
        let key = |place: u32| u64::from(place / side) << 8 | u64::from(place % side);
        let keys = Keys {
            of: (0..side * side).map(key).collect(),
            cuts: vec![8, 16],
        };
        (Csr::from_rows(rows.collect()), keys)
    }

    #[test]
    fn blocks_have_the_values_of_single_states() {
        const SIDE: u32 = 40;
        let states = (SIDE * SIDE) as usize;
        let (matrix, _) = grid(SIDE);
        let choices = Choices::new(&matrix, &[]);
        let active: Vec<bool> = (0..states).map(|s| s % 97 != 96).collect();
        let ends: Vec<bool> = (0..states).map(|s| s % 97 == 96 && s > 400).collect();
        let all = vec![true; states];
        for (from, steps, support) in [
            (vec![0], 60, &ends),
            (vec![0], 200, &ends),
            (vec![17, 820, 1599], 49, &all),
            (vec![820], 49, &ends),
        ] {
            let cone = || Cone::new(choices, &active, &from, Some(support), steps);
            let value = |s: usize| {
                if support[s] {
                    1.0 + (s % 5) as f64
                } else {
                    0.0
                }
            };
            let row = |s: usize, into: &mut Vec<(u32, f64)>| {
                into.extend(matrix.row(s).map(|(target, p)| (target as u32, *p)));
            };
            let keys = || Some(grid(SIDE).1);
            let mut blocks = BlockWalk::new(&cone(), steps, keys, value, row).unwrap();
            let one = |s: usize| [value(s)];
            let mut single = Walk::<1>::new(cone(), steps, choices, [true], one, |s, _, into| {
                row(s, into)
            });
            assert_eq!(blocks.longest(), single.longest());
            for step in 0..steps {
                blocks.advance();
                single.advance();
                for state in &from {
                    let expected = single.value(*state).map_or(value(*state), |[v]| v);
                    let found = blocks.value(*state);
                    let off = (found - expected).abs();
                    assert!(off <= 1e-12 * expected, "{step} {state} {found} {expected}");
                }
            }
            assert!(from.iter().all(|s| blocks.value(*s) > 0.0));
        }
    }
}
