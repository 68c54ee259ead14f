//! Schedulers to start from: such that every state may leave its component.

use std::collections::VecDeque;

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
