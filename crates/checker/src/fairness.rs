//! Probabilities over fair schedulers only.
//!
//! *Definition.* A path is fair if each choice of each state that it visits infinitely often is taken infinitely
//! often; a scheduler is fair if almost all of its paths are.
//!
//! *Within finitely many steps* nothing changes, since a scheduler may turn fair afterwards. *The greatest probability
//! of `left U right`* is that of all schedulers, for the same reason. *The least* is
//!
//! ```text
//! 1 - Pmax( left & !right  U  Z ),     Z = states without a path of left U right
//! ```
//!
//! since a fair path that stays where `right` remains possible reaches it almost surely. *Of other formulas* the
//! greatest probability is that of reaching an accepting end component of the product with an automaton that is
//! *complete*: for each of the model's states in it, it has all of that state's choices, in one of the automaton's
//! states at least. One that is not complete holds none that is: that one could not be left, so that both would have
//! the same states of the model. All of these are attained by fair schedulers.
//!
//! Source: Baier and Kwiatkowska 1998, "Model checking for a probabilistic branching time logic with fairness"; Baier
//! 1998, "On Algorithmic Verification Methods for Probabilistic Systems", section 9.4. Deviation: PRISM demands all
//! choices of each state of the product, so that a scheduler that alternates between choices of a state is not fair
//! there; here, as in the sources, fairness is one of the model.
//!
//! Cost: that of reachability. Guarantee: that of the engine.

use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::{Context, Numbers};
use crate::graph::{Backward, EndComponent};
use crate::reachability;
use crate::shape::negation;

/// The least probability of `left U right` over fair schedulers, in all states, and the rounds of iteration.
pub(crate) fn least_until<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    left: &[bool],
    right: &[bool],
    context: &Context<'_>,
) -> Result<(Vec<E::Value>, u64), CheckError> {
    let (possible, _) = Backward::new(choices).reaching(right, |s| left[s], |_| true);
    let lost = negation(possible);
    let pairs = left.iter().zip(right);
    let waiting: Vec<bool> = pairs.map(|(left, right)| *left && !right).collect();
    let steps = (0, None);
    let (values, _, rounds) =
        reachability::until::<E>(choices, &waiting, &lost, steps, None, true, context)?;
    Ok((values.iter().map(E::contrary).collect(), rounds))
}

/// Whether a scheduler can stay in an end component of a product and be fair: whether it takes all choices of the
/// model's states in it. `state` and `origin` say which state and which row of the model each one of the product is;
/// rows of the product alone have none, and may be taken for ever.
pub(crate) fn is_complete<N>(
    model: Choices<'_, N>,
    component: &EndComponent,
    state: impl Fn(usize) -> usize,
    origin: &[Option<usize>],
) -> bool {
    let Some(mut taken) = (component.rows.iter())
        .map(|row| origin[*row])
        .collect::<Option<Vec<usize>>>()
    else {
        return true;
    };
    let states = component.states.iter();
    let mut states: Vec<usize> = states.map(|s| state(*s as usize)).collect();
    states.sort_unstable();
    states.dedup();
    taken.sort_unstable();
    taken.dedup();
    let all: usize = states.iter().map(|state| model.rows(*state).len()).sum();
    taken.len() == all
}

/// That a value is not computed over fair schedulers.
pub(crate) fn not_yet(what: &str) -> CheckError {
    CheckError::Unsupported(format!(
        "{what} cannot be computed over fair schedulers only yet: leave fairness out for all schedulers"
    ))
}
