//! States of a chain that cannot be told apart, joined to classes.
//!
//! *Definition.* A partition of the states is an ordinary lumping if states of one class have the same value and the same rate
//! into each other class. Values carried back, `P^k x`, are then the same throughout a class, and those of the chain of the classes
//! (Kemeny and Snell 1960, section 6.3; Buchholz 1994, "Exact and ordinary lumpability in finite Markov chains").
//! States that are not left keep their value, so that it alone counts.
//!
//! *Method.* The coarsest such partition is found by refinement (Derisavi, Hermanns and Sanders 2003, "Optimal state-space lumping
//! in Markov chains"): classes are split by the rates into the others, until none is. In each round only classes are looked
//! at of which a state, or a successor of one, has changed its class, and the largest part of a class keeps its number. Deviation: states
//! are signed round by round, which is not `O(m log n)`, but a budget of entries ends it, so that little is lost where
//! there is little to be joined.
//!
//! *Guarantee.* Rates into a class are added in an order that depends on them alone, and only sums with the same digits join states.
//! So the rates of each state are those of its class up to a relative `longest row * u`, which [`crate::transient`] adds
//! to the error of the rates. Cost: at most the budget, and four bytes an entry for the predecessors.

use rustc_hash::FxHashMap;

use crate::rounding::Bounds;
use crate::state_space::Csr;

/// At least so many states must go into one class on average.
const LEAST_JOINED: usize = 4;
/// Rounds that the budget has to allow for at least.
const FEWEST_ROUNDS: usize = 4;

/// The chain of the classes.
#[derive(Debug)]
pub(crate) struct Lumped {
    /// The class of each state.
    pub class: Vec<u32>,
    /// The first state of each class.
    pub representative: Vec<u32>,
    /// Rates between classes; none of classes that are not left.
    pub rates: Csr<f64>,
    /// Classes that are left.
    pub active: Vec<bool>,
    /// The greatest number of rates that were added up.
    pub longest: usize,
}

/// Rates of a state into classes other than its own, by class, with the digits of their sums.
type Signature = Vec<(u32, u64)>;

struct Refinement<'a> {
    rates: &'a Csr<f64>,
    active: &'a [bool],
    class: Vec<u32>,
    members: Vec<Vec<u32>>,
    /// Entries that were looked at.
    spent: usize,
    rates_by_class: Vec<(u32, f64)>,
    signature: Signature,
}

/// The coarsest lumping that tells different `values` apart, where only active states are left; nothing if it takes more than
/// `budget` entries to find, or joins few states.
pub(crate) fn lump(
    rates: &Csr<f64>,
    active: &[bool],
    values: &[Bounds],
    budget: usize,
) -> Option<Lumped> {
    let lengths = rates.row_start.windows(2).map(|ends| ends[1] - ends[0]);
    let rows = lengths.zip(active).filter(|(_, active)| **active);
    let lengths: Vec<usize> = rows.map(|(length, _)| length).collect();
    if budget < FEWEST_ROUNDS * lengths.iter().sum::<usize>() {
        return None;
    }
    let mut refinement = Refinement::new(rates, active, values);
    let most = lengths.len() / LEAST_JOINED + refinement.members.len();
    let into = predecessors(rates, active);
    let mut touched: Vec<u32> = (0..refinement.members.len() as u32).collect();
    while !touched.is_empty() {
        touched = refinement.round(&touched, &into);
        if refinement.spent > budget || refinement.members.len() > most {
            return None;
        }
    }
    Some(refinement.finish(lengths.into_iter().max().unwrap_or(0)))
}

impl<'a> Refinement<'a> {
    fn new(rates: &'a Csr<f64>, active: &'a [bool], values: &[Bounds]) -> Self {
        let mut known: FxHashMap<(bool, u64, u64), u32> = FxHashMap::default();
        let mut members: Vec<Vec<u32>> = Vec::new();
        let mut class = Vec::with_capacity(active.len());
        for (state, (active, value)) in active.iter().zip(values).enumerate() {
            let key = (*active, value.low.to_bits(), value.high.to_bits());
            let own = *known.entry(key).or_insert_with(|| {
                members.push(Vec::new());
                members.len() as u32 - 1
            });
            members[own as usize].push(state as u32);
            class.push(own);
        }
        Self {
            rates,
            active,
            class,
            members,
            spent: 0,
            rates_by_class: Vec::new(),
            signature: Vec::new(),
        }
    }

    /// Splits these classes, and returns those to look at next.
    fn round(&mut self, touched: &[u32], into: &(Vec<usize>, Vec<u32>)) -> Vec<u32> {
        let mut parts: Vec<Vec<u32>> = Vec::new();
        for class in touched {
            let members = std::mem::take(&mut self.members[*class as usize]);
            let is_left = self.active[members[0] as usize];
            if members.len() == 1 || !is_left {
                self.members[*class as usize] = members;
                continue;
            }
            let mut split = self.split(&members);
            let sizes = split.iter().enumerate();
            // Of several that are as large, the first.
            let largest = sizes.rev().max_by_key(|(_, part)| part.len());
            let largest = largest.map_or(0, |(at, _)| at);
            self.members[*class as usize] = split.remove(largest);
            parts.append(&mut split);
        }
        let first = self.members.len();
        for part in parts {
            let new = self.members.len() as u32;
            part.iter()
                .for_each(|state| self.class[*state as usize] = new);
            self.members.push(part);
        }
        let (start, from) = into;
        let mut next: Vec<u32> = Vec::new();
        for state in self.members[first..].iter().flatten() {
            let state = *state as usize;
            next.push(self.class[state]);
            let before = &from[start[state]..start[state + 1]];
            next.extend(before.iter().map(|state| self.class[*state as usize]));
        }
        next.sort_unstable();
        next.dedup();
        next
    }

    /// The members of a class by their signatures, in the order in which these are met.
    fn split(&mut self, members: &[u32]) -> Vec<Vec<u32>> {
        let mut known: FxHashMap<Signature, usize> = FxHashMap::default();
        let mut parts: Vec<Vec<u32>> = Vec::new();
        for state in members {
            self.sign(*state as usize);
            let part = known.get(&self.signature[..]).copied();
            let part = part.unwrap_or_else(|| {
                known.insert(self.signature.clone(), parts.len());
                parts.push(Vec::new());
                parts.len() - 1
            });
            parts[part].push(*state);
        }
        parts
    }

    /// Sets the signature to that of a state.
    fn sign(&mut self, state: usize) {
        let own = self.class[state];
        let class = &self.class;
        self.spent += self.rates.row_start[state + 1] - self.rates.row_start[state];
        self.rates_by_class.clear();
        let row = self.rates.row(state).map(|(to, rate)| (class[to], *rate));
        self.rates_by_class.extend(row.filter(|(to, _)| *to != own));
        // Rates are positive, so that their digits order them.
        let order = |(to, rate): &(u32, f64)| (*to, rate.to_bits());
        self.rates_by_class.sort_unstable_by_key(order);
        self.signature.clear();
        for of_class in self.rates_by_class.chunk_by(|a, b| a.0 == b.0) {
            let sum: f64 = of_class.iter().map(|(_, rate)| rate).sum();
            self.signature.push((of_class[0].0, sum.to_bits()));
        }
    }

    fn finish(mut self, longest: usize) -> Lumped {
        let representative: Vec<u32> = self.members.iter().map(|members| members[0]).collect();
        let mut rates = Csr::with_capacity(representative.len());
        let mut active = Vec::with_capacity(representative.len());
        for state in &representative {
            let is_active = self.active[*state as usize];
            self.signature.clear();
            if is_active {
                self.sign(*state as usize);
            }
            let row = self.signature.iter();
            rates.push_row(row.map(|(class, digits)| (*class, f64::from_bits(*digits))));
            active.push(is_active);
        }
        Lumped {
            class: self.class,
            representative,
            rates,
            active,
            longest,
        }
    }
}

/// For each state where the active states begin from which it is reached in one step, and these.
fn predecessors(rates: &Csr<f64>, active: &[bool]) -> (Vec<usize>, Vec<u32>) {
    let mut start = vec![0; active.len() + 1];
    let left = || (0..active.len()).filter(|state| active[*state]);
    let targets = |state: usize| &rates.column[rates.row_start[state]..rates.row_start[state + 1]];
    for target in left().flat_map(targets) {
        start[*target as usize + 1] += 1;
    }
    for state in 0..active.len() {
        start[state + 1] += start[state];
    }
    let mut from = vec![0; start[active.len()]];
    let mut free = start.clone();
    for state in left() {
        for target in targets(state) {
            let place = &mut free[*target as usize];
            from[*place] = state as u32;
            *place += 1;
        }
    }
    (start, from)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Machines that fail and are repaired, each on its own; a state is the set of those that work.
    fn machines(count: u32, fails: f64, repaired: f64) -> Csr<f64> {
        let row = |works: u32| -> Vec<(u32, f64)> {
            let rate = |machine: u32| match works >> machine & 1 {
                1 => fails,
                _ => repaired,
            };
            let to = |machine: u32| (works ^ (1 << machine), rate(machine));
            (0..count).map(to).collect()
        };
        Csr::from_rows((0..1 << count).map(row).collect())
    }

    #[test]
    fn of_equal_machines_only_the_number_counts() {
        let rates = machines(7, 0.5, 3.0);
        let states = rates.num_rows();
        // Until none works.
        let active: Vec<bool> = (0..states).map(|works| works != 0).collect();
        let values: Vec<Bounds> = active.iter().map(|a| Bounds::indicator(!a)).collect();
        let lumped = lump(&rates, &active, &values, usize::MAX).unwrap();
        assert_eq!(lumped.active.iter().filter(|active| **active).count(), 7);
        for works in 0..states {
            let class = lumped.class[works] as usize;
            assert_eq!(
                works.count_ones(),
                lumped.representative[class].count_ones()
            );
            assert_eq!(lumped.active[class], works != 0);
            let up = f64::from(works.count_ones());
            let expected = [up * 0.5, (7.0 - up) * 3.0]
                .into_iter()
                .filter(|r| *r > 0.0);
            let mut expected: Vec<f64> = expected.collect();
            let mut found: Vec<f64> = lumped.rates.row(class).map(|(_, rate)| *rate).collect();
            expected.sort_by(f64::total_cmp);
            found.sort_by(f64::total_cmp);
            assert_eq!(found, if works == 0 { Vec::new() } else { expected });
        }
        // Not within too small a budget.
        assert!(lump(&rates, &active, &values, 4 * 7 * 128).is_none());
    }

    #[test]
    fn different_values_and_rates_are_told_apart() {
        let rates = machines(6, 0.5, 3.0);
        let states = rates.num_rows();
        let active = vec![true; states];
        // The first machine has a value of its own.
        let values: Vec<Bounds> = (0..states)
            .map(|works| Bounds::exactly((works & 1) as f64))
            .collect();
        let lumped = lump(&rates, &active, &values, usize::MAX).unwrap();
        // Whether the others work does not matter to it.
        assert_eq!(lumped.representative.len(), 2);
        let mut rates = rates;
        for (at, rate) in rates.value.iter_mut().enumerate() {
            *rate *= 1.0 + at as f64 / 1e6;
        }
        assert!(lump(&rates, &active, &values, usize::MAX).is_none());
    }
}
