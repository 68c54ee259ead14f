//! Random paths through a chain's state space, the same for the same seed.
//!
//! Each step draws 53 random bits as a number in [0, 1) and takes the first transition at which the running sum
//! of the probabilities exceeds it. In continuous time the running sum is that of the rates over their total `e`, and the
//! state is left after `-ln(1 - u) / e`, `u` a number drawn before (the race of exponential clocks; D. T. Gillespie, "Exact
//! stochastic simulation of coupled chemical reactions", 1977). Guarantee: the paths' distribution is the chain's to within
//! 2^-53 for each step. A model that leaves choices open has no distribution of paths, and none is drawn. Cost: the length
//! of the rows passed.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use crate::state_space::StateSpace;
use prism_lang::resolved::ModelType;

/// A state of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visit {
    /// When it is entered: the number of the step; in continuous time in units of the model.
    pub time: f64,
    /// Its number.
    pub state: usize,
}

/// A random path of a chain from the first initial state; none of a model that leaves choices open.
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
/// let path = sample_path(&space, 7, 1000).expect("a chain");
/// assert_eq!(path.last().map(|visit| visit.state), Some(1));
/// assert_eq!(path.len() as f64 - 1.0, path.last().expect("the end").time);
/// assert_eq!(Some(path), sample_path(&space, 7, 1000));
/// ```
pub fn sample_path(space: &StateSpace<f64>, seed: u64, max_steps: u64) -> Option<Vec<Visit>> {
    let is_timed = match space.kind {
        ModelType::Dtmc => false,
        ModelType::Ctmc => true,
        _ => return None,
    };
    let Some(start) = space.initial_states().first() else {
        return Some(Vec::new());
    };
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
    let (mut time, mut state) = (0.0, *start);
    let mut path = vec![Visit { time, state }];
    for _ in 0..max_steps {
        if space.matrix.row(state).all(|(target, _)| target == state) {
            break;
        }
        let total = match is_timed {
            true => space.matrix.row(state).map(|(_, rate)| rate).sum(),
            false => 1.0,
        };
        time += match is_timed {
            true => -(-draw()).ln_1p() / total,
            false => 1.0,
        };
        state = step(space, state, draw() * total);
        path.push(Visit { time, state });
    }
    Some(path)
}

/// The target of the transition that `draw`, from 0 to the row's sum, selects.
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
        let paths = (0..10_000).map(|seed| sample_path(&space, seed, 10).unwrap());
        let hits = paths.filter(|path| path[1].state == 1).count();
        // Mean 2000, standard deviation 40: five deviations.
        assert!((1800..=2200).contains(&hits), "{hits}");
    }

    #[test]
    fn the_number_of_steps_is_limited() {
        let rows = vec![vec![(1, 1.0)], vec![(0, 1.0)]];
        let space = StateSpace::from_matrix(Csr::from_rows(rows), vec![0], Vec::new());
        let path = sample_path(&space, 1, 3).unwrap();
        let states: Vec<usize> = path.iter().map(|visit| visit.state).collect();
        assert_eq!(states, [0, 1, 0, 1]);
    }

    #[test]
    fn clocks_race_in_continuous_time() {
        // Left at rate 5 in all, for state 1 in a fifth.
        let rows = vec![vec![(1, 1.0), (2, 4.0)], vec![(1, 1.0)], vec![(2, 1.0)]];
        let matrix = Csr::from_rows(rows);
        let space =
            StateSpace::from_parts(ModelType::Ctmc, matrix, Vec::new(), vec![0], Vec::new());
        let paths: Vec<_> = (0..10_000)
            .map(|seed| sample_path(&space, seed, 10).unwrap())
            .collect();
        let hits = paths.iter().filter(|path| path[1].state == 1).count();
        assert!((1800..=2200).contains(&hits), "{hits}");
        // Mean 0.2, standard deviation of the mean 0.002.
        let mean = paths.iter().map(|path| path[1].time).sum::<f64>() / 1e4;
        assert!((mean - 0.2).abs() < 0.01, "{mean}");
        let early = paths.iter().filter(|path| path[1].time <= 0.1).count() as f64 / 1e4;
        assert!((early - (1.0 - (-0.5_f64).exp())).abs() < 0.025, "{early}");
    }

    #[test]
    fn choices_that_are_open_have_no_paths() {
        let matrix = Csr::from_rows(vec![vec![(0, 1.0)], vec![(1, 1.0)], vec![(1, 1.0)]]);
        let starts = vec![0, 2, 3];
        let space = StateSpace::from_parts(ModelType::Mdp, matrix, starts, vec![0], Vec::new());
        assert_eq!(sample_path(&space, 1, 3), None);
    }
}
