//! Random paths through a state space, the same for the same seed.
//!
//! Each step draws 53 random bits as a number in [0, 1) and takes the first transition at which the running sum
//! of the probabilities exceeds it. Guarantee: the paths' distribution is the chain's to within 2^-53 for each
//! step. Cost: the length of the rows passed.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::state_space::StateSpace;

/// The states of a random path from the first initial state.
///
/// The path ends in a state that cannot be left, which it contains once, or after `max_steps` transitions. It
/// is empty if there is no initial state.
///
/// ```
/// use checker::sample_path;
/// use checker::state_space::{Csr, StateSpace};
///
/// let rows = vec![vec![(0, 0.5), (1, 0.5)], vec![(1, 1.0)]];
/// let space = StateSpace::from_matrix(Csr::from_rows(rows), vec![0], Vec::new());
/// let path = sample_path(&space, 7, 1000);
/// assert_eq!(path.last(), Some(&1));
/// assert_eq!(path, sample_path(&space, 7, 1000));
/// ```
pub fn sample_path(space: &StateSpace<f64>, seed: u64, max_steps: u64) -> Vec<usize> {
    let Some(start) = space.initial_states().first() else {
        return Vec::new();
    };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut path = vec![*start];
    let mut state = *start;
    for _ in 0..max_steps {
        if space.matrix.row(state).all(|(target, _)| target == state) {
            break;
        }
        let draw = (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
        state = step(space, state, draw);
        path.push(state);
    }
    path
}

/// The target of the transition that `draw`, from [0, 1), selects.
fn step(space: &StateSpace<f64>, state: usize, draw: f64) -> usize {
    let mut sum = 0.0;
    let mut last = state;
    for (target, probability) in space.matrix.row(state) {
        sum += probability;
        last = target;
        if draw < sum {
            break;
        }
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::state_space::Csr;

    #[test]
    fn frequencies_follow_the_probabilities() {
        let rows = vec![vec![(1, 0.2), (2, 0.8)], vec![(1, 1.0)], vec![(2, 1.0)]];
        let space = StateSpace::from_matrix(Csr::from_rows(rows), vec![0], Vec::new());
        let paths = (0..10_000).map(|seed| sample_path(&space, seed, 10));
        let hits = paths.filter(|path| path[1] == 1).count();
        // Mean 2000, standard deviation 40: five deviations.
        assert!((1800..=2200).contains(&hits), "{hits}");
    }

    #[test]
    fn the_number_of_steps_is_limited() {
        let rows = vec![vec![(1, 1.0)], vec![(0, 1.0)]];
        let space = StateSpace::from_matrix(Csr::from_rows(rows), vec![0], Vec::new());
        assert_eq!(sample_path(&space, 1, 3), [0, 1, 0, 1]);
    }
}
