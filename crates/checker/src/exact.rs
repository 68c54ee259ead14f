//! Reachability in rational arithmetic.
//!
//! The equations of [`crate::sound`], component by component, each solved by the elimination of
//! [`crate::elimination`] over the rationals.
//!
//! Guarantee: exact. Cost: as there in the number of operations, but numbers grow with the number of
//! states on a path, so that large models with many different probabilities take long.

use prism_lang::{Arithmetic, Rational};

use crate::answer::{CheckError, Options};
use crate::elimination::{GivenUp, System};
use crate::graph::{Components, Qualitative};
use crate::state_space::Csr;

/// Exactly 1 if `holds`, else 0.
pub(crate) fn indicator(holds: bool) -> Rational {
    if holds {
        Rational::one()
    } else {
        Rational::zero()
    }
}

/// Solves the reachability problem whose target are the states of `sets.surely`.
pub(crate) fn reachability(
    matrix: &Csr<Rational>,
    sets: &Qualitative,
    options: &Options<'_>,
) -> Result<Vec<Rational>, CheckError> {
    let mut x: Vec<Rational> = sets
        .surely
        .iter()
        .map(|surely| indicator(*surely))
        .collect();
    let open = |(surely, never): (&bool, &bool)| !surely && !never;
    let open: Vec<bool> = sets.surely.iter().zip(&sets.never).map(open).collect();
    let mut local = vec![u32::MAX; x.len()];
    let cancelled = || options.is_cancelled();
    for component in Components::new(matrix, &open).iter() {
        options.check_cancelled()?;
        let system = system(matrix, component, &x, &mut local);
        let solution = system
            .solve(u64::MAX, &cancelled)
            .map_err(|reason| match reason {
                GivenUp::Cancelled => CheckError::Cancelled,
                // Open states leave their component, and rationals neither underflow nor exceed this budget.
                _ => CheckError::Unsupported(
                    "the equations of a component have no unique solution; its transition \
                 probabilities do not sum to 1"
                        .to_owned(),
                ),
            })?;
        for (state, [_, value]) in component.iter().zip(solution.values) {
            x[*state as usize] = value;
        }
    }
    Ok(x)
}

fn system(
    matrix: &Csr<Rational>,
    component: &[u32],
    x: &[Rational],
    local: &mut [u32],
) -> System<Rational, 2> {
    for (position, state) in component.iter().enumerate() {
        local[*state as usize] = position as u32;
    }
    let mut system = System {
        rows: Vec::with_capacity(component.len()),
        rhs: Vec::with_capacity(component.len()),
    };
    for state in component {
        let (mut row, mut exit, mut value) = (Vec::new(), Rational::zero(), Rational::zero());
        for (target, p) in matrix.row(*state as usize) {
            match local[target] {
                u32::MAX => {
                    exit = exit.add(p);
                    value = value.add(&p.mul(&x[target]));
                }
                _ if target == *state as usize => {}
                position => row.push((position, p.clone())),
            }
        }
        row.sort_unstable_by_key(|(column, _)| *column);
        system.rows.push(row);
        system.rhs.push([exit, value]);
    }
    component
        .iter()
        .for_each(|state| local[*state as usize] = u32::MAX);
    system
}
