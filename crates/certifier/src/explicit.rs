//! Models as choices of numbered states, and the components in which a scheduler can stay.
//!
//! *Definition.* An end component is a set of states with a choice or more for each that stay in the set and connect all of
//! its states. Maximal ones: strongly connected components by the choices that stay in the component, again and again
//! until no choice leaves any. In a chain they are the bottom components. Source: de Alfaro 1997, section 3.3; Tarjan 1972.
//! A state that has lost its last choice takes those that lead to it along before components are sought again. Cost: rounds
//! times transitions; few rounds on most models. Guarantee: exact.

use prism_lang::Rational;

use crate::incoming::Incoming;
use crate::reading::Choice;

const NONE: usize = usize::MAX;

/// The maximal end components within some states, by choices that may be used; each with its states, ascending.
pub(crate) fn end_components(
    choices: &[Vec<Choice>],
    within: &[bool],
    usable: &dyn Fn(&Choice) -> bool,
) -> Vec<Vec<usize>> {
    let mut component = vec![NONE; choices.len()];
    let stays = |choice: &Choice| usable(choice) && choice.outcomes.iter().all(|(t, _)| within[*t]);
    let mut on: Vec<Vec<bool>> = (choices.iter().zip(within))
        .map(|(own, inside)| own.iter().map(|choice| *inside && stays(choice)).collect())
        .collect();
    let incoming = Incoming::new(choices);
    let none = (0..choices.len()).filter(|state| !on[*state].contains(&true));
    incoming.unravel(none.collect(), &mut on, |_| false);
    loop {
        let edges: Vec<Vec<usize>> = (choices.iter().zip(&on))
            .map(|(own, on)| {
                let staying = own.iter().zip(on).filter(|(_, on)| **on);
                let targets = staying.flat_map(|(choice, _)| &choice.outcomes);
                targets.map(|(target, _)| *target).collect()
            })
            .collect();
        let strong = strongly_connected(&edges);
        for (state, (component, edges)) in component.iter_mut().zip(&edges).enumerate() {
            // A state without a choice that stays is in none.
            *component = if edges.is_empty() {
                NONE
            } else {
                strong[state]
            };
        }
        let (mut changed, mut gone) = (false, Vec::new());
        for (state, own) in choices.iter().enumerate() {
            let leaves = |choice: &Choice| {
                let mut targets = choice.outcomes.iter();
                targets.any(|(target, _)| component[*target] != component[state])
            };
            let mut lost = false;
            for (choice, on) in own.iter().zip(&mut on[state]) {
                lost |= *on && leaves(choice);
                *on &= !leaves(choice);
            }
            changed |= lost;
            if lost && !on[state].contains(&true) {
                gone.push(state);
            }
        }
        if !changed {
            break;
        }
        incoming.unravel(gone, &mut on, |_| false);
    }
    let mut found: Vec<Vec<usize>> = Vec::new();
    let mut number = rustc_hash::FxHashMap::default();
    for (state, of) in component.iter().enumerate().filter(|(_, of)| **of != NONE) {
        let place = *number.entry(*of).or_insert(found.len());
        if place == found.len() {
            found.push(Vec::new());
        }
        found[place].push(state);
    }
    found
}

/// The strongly connected component of each state.
fn strongly_connected(edges: &[Vec<usize>]) -> Vec<usize> {
    let states = edges.len();
    let (mut index, mut low) = (vec![NONE; states], vec![0; states]);
    let (mut component, mut stack) = (vec![NONE; states], Vec::new());
    let (mut next, mut found) = (0, 0);
    for root in 0..states {
        if index[root] != NONE {
            continue;
        }
        let mut work = vec![(root, 0)];
        while let Some((state, edge)) = work.pop() {
            if edge == 0 {
                (index[state], low[state]) = (next, next);
                next += 1;
                stack.push(state);
            }
            if let Some(target) = edges[state].get(edge) {
                work.push((state, edge + 1));
                if index[*target] == NONE {
                    work.push((*target, 0));
                } else if component[*target] == NONE {
                    low[state] = low[state].min(index[*target]);
                }
                continue;
            }
            if low[state] == index[state] {
                while let Some(member) = stack.pop() {
                    component[member] = found;
                    if member == state {
                        break;
                    }
                }
                found += 1;
            }
            if let Some((parent, _)) = work.last() {
                low[*parent] = low[*parent].min(low[state]);
            }
        }
    }
    component
}

/// The class of each state, and the choices by classes: first the components, each without the choices that only stay in it,
/// then all other states.
pub(crate) fn quotient(
    choices: &[Vec<Choice>],
    components: &[Vec<usize>],
) -> (Vec<usize>, Vec<Vec<Choice>>) {
    let (class, choices, _) = quotient_of(choices, components);
    (class, choices)
}

/// A choice by its state and its place there.
pub(crate) type Origin = (usize, usize);

/// The same, and where each of the choices comes from.
pub(crate) fn quotient_of(
    choices: &[Vec<Choice>],
    components: &[Vec<usize>],
) -> (Vec<usize>, Vec<Vec<Choice>>, Vec<Vec<Origin>>) {
    let mut class = vec![NONE; choices.len()];
    for (number, component) in components.iter().enumerate() {
        component.iter().for_each(|state| class[*state] = number);
    }
    let mut classes = components.len();
    for of in class.iter_mut().filter(|of| **of == NONE) {
        *of = classes;
        classes += 1;
    }
    let mut all = vec![Vec::new(); classes];
    let mut origins = vec![Vec::new(); classes];
    for (state, choices) in choices.iter().enumerate() {
        let own = class[state];
        for (place, choice) in choices.iter().enumerate() {
            let choice = by_class(choice, &class);
            if own >= components.len() || choice.outcomes.iter().any(|(to, _)| *to != own) {
                all[own].push(choice);
                origins[own].push((state, place));
            }
        }
    }
    (class, all, origins)
}

/// A choice by classes.
fn by_class(choice: &Choice, class: &[usize]) -> Choice {
    let mut outcomes: Vec<(usize, Rational)> = (choice.outcomes.iter())
        .map(|(target, p)| (class[*target], p.clone()))
        .collect();
    outcomes.sort_by_key(|(class, _)| *class);
    outcomes.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += &next.1;
        }
        same
    });
    Choice {
        outcomes,
        reward: choice.reward.clone(),
    }
}

/// The states from which some are reached with positive probability by some choices.
pub(crate) fn possible(choices: &[Vec<Choice>], goal: &[bool]) -> Vec<bool> {
    let mut before: Vec<Vec<usize>> = vec![Vec::new(); choices.len()];
    for (state, choices) in choices.iter().enumerate() {
        for (target, _) in choices.iter().flat_map(|choice| &choice.outcomes) {
            before[*target].push(state);
        }
    }
    let mut reached = goal.to_vec();
    let mut open: Vec<usize> = (0..goal.len()).filter(|state| goal[*state]).collect();
    while let Some(state) = open.pop() {
        for from in &before[state] {
            if !std::mem::replace(&mut reached[*from], true) {
                open.push(*from);
            }
        }
    }
    reached
}
