//! Schedulers to start from: such that every state may leave its component.

use std::collections::VecDeque;

use rustc_hash::FxHashMap;

use crate::choices::Choices;

/// The same for the states of a component of a model, in its order; `position` has no entry yet, and none afterwards.
pub(super) fn leaving_component<N>(
    choices: Choices<'_, N>,
    component: &[u32],
    position: &mut [u32],
) -> Option<Vec<usize>> {
    for (place, state) in component.iter().enumerate() {
        position[*state as usize] = place as u32;
    }
    let rows = |place: usize| choices.rows(component[place] as usize);
    // Rows of a component are not contiguous; their targets inside, by row.
    let mut inside: FxHashMap<usize, Vec<u32>> = FxHashMap::default();
    for row in (0..component.len()).flat_map(rows) {
        let within = choices.targets(row).iter().map(|t| position[*t as usize]);
        inside.insert(row, within.filter(|place| *place != u32::MAX).collect());
    }
    for state in component {
        position[*state as usize] = u32::MAX;
    }
    let targets = |row: usize| inside.get(&row).map_or(&[][..], Vec::as_slice);
    let leaves = |row: usize| targets(row).len() < choices.entries(row).len();
    leaving(component.len(), rows, targets, leaves)
}

/// For each state of a component a choice such that the component is left with probability 1; `None` if some
/// state cannot leave.
///
/// `choices` gives the choices of a state, `inside` a choice's targets in the component, `leaves` whether it
/// may leave at once.
pub(super) fn leaving<'a>(
    states: usize,
    choices: impl Fn(usize) -> std::ops::Range<usize>,
    inside: impl Fn(usize) -> &'a [u32],
    leaves: impl Fn(usize) -> bool,
) -> Option<Vec<usize>> {
    let mut into: Vec<Vec<(u32, usize)>> = vec![Vec::new(); states];
    let mut policy = vec![usize::MAX; states];
    let mut queue = VecDeque::new();
    for (state, chosen) in policy.iter_mut().enumerate() {
        for row in choices(state) {
            if *chosen == usize::MAX && leaves(row) {
                *chosen = row;
                queue.push_back(state);
            }
            for target in inside(row) {
                into[*target as usize].push((state as u32, row));
            }
        }
    }
    while let Some(state) = queue.pop_front() {
        for (from, row) in &into[state] {
            if policy[*from as usize] == usize::MAX {
                policy[*from as usize] = *row;
                queue.push_back(*from as usize);
            }
        }
    }
    (!policy.contains(&usize::MAX)).then_some(policy)
}
