//! State spaces in PRISM's explicit formats (`.tra`, `.sta`, `.lab`, `.srew`, `.trew`), in Storm's (DRN), and as
//! graphs for Graphviz.
//!
//! States are numbered in the lexicographic order of their values, as PRISM does, not in the order in which they
//! were found; choices of a state keep their order. Source: PRISM's manual, appendix "Explicit Model Files".
//! Deviation: actions of a chain's transitions are not kept, and hence not written. Numbers are the shortest
//! that read back to the same double, or exact fractions. Cost: sorting of the states, one visit of each entry.
//!
//! ```
//! use checker::explore::explore;
//! use checker::formats::Explicit;
//! use prism_lang::{Constants, parse_model, resolve};
//! let text = "mdp module m x : [0..1]; [go] x=0 -> 1/4:(x'=0) + 3/4:(x'=1); [] x=1 -> true; endmodule";
//! let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
//! let space = explore::<f64>(&model).unwrap();
//! let mut file = Vec::new();
//! Explicit::new(&space).write_transitions(&mut file)?;
//! let text = String::from_utf8(file).unwrap();
//! assert_eq!(text, "# Transitions (MDP)\n2 2 3\n0 0 0 0.25 go\n0 0 1 0.75 go\n1 0 1 1\n");
//! # Ok::<(), std::io::Error>(())
//! ```

mod dot;
mod drn;
mod outline;
mod read;
mod scheduler;
mod write;

pub use drn::read_drn;
pub use read::{ExplicitError, ExplicitFiles, read_explicit};
pub use scheduler::Decision;

use prism_lang::{Rational, rational_to_f64};

use crate::state_space::StateSpace;

/// A state space with its states in the order of their values, to be written.
#[derive(Debug)]
pub struct Explicit<'a, N> {
    space: &'a StateSpace<N>,
    /// The state at each place, and the place of each state.
    order: Vec<usize>,
    place: Vec<usize>,
}

impl<'a, N: Written> Explicit<'a, N> {
    /// Puts the states in order.
    pub fn new(space: &'a StateSpace<N>) -> Self {
        let mut order: Vec<usize> = (0..space.num_states()).collect();
        let variables = 0..space.variables().len();
        // Stable: states without variables stay in their order.
        order.sort_by(|a, b| {
            let value = |state: usize, v| space.value(state, v);
            let mut each = variables.clone().map(|v| value(*a, v).cmp(&value(*b, v)));
            each.find(|order| order.is_ne())
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        let mut place = vec![0; order.len()];
        for (at, state) in order.iter().enumerate() {
            place[*state] = at;
        }
        Self {
            space,
            order,
            place,
        }
    }

    /// The number that a state has in the files.
    ///
    /// # Panics
    /// If there is no such state.
    pub fn number(&self, state: usize) -> usize {
        self.place[state]
    }

    /// The states in the order of their numbers in the files.
    pub fn states(&self) -> &[usize] {
        &self.order
    }

    /// The entries of a row: number of the target, place in the matrix; numbers ascend.
    fn row(&self, row: usize) -> Vec<(usize, usize)> {
        let matrix = &self.space.matrix;
        let entries = matrix.row_start[row]..matrix.row_start[row + 1];
        let entry = |at: usize| (self.place[matrix.column[at] as usize], at);
        let mut entries: Vec<_> = entries.map(entry).collect();
        entries.sort_unstable();
        entries
    }
}

/// A number that has a place in explicit files.
pub trait Written {
    /// As it is written.
    fn written(&self) -> String;
    /// Whether it is 0: zeros are not written.
    fn is_nothing(&self) -> bool;
}

impl Written for f64 {
    fn written(&self) -> String {
        let size = self.abs();
        if *self == 0.0 {
            "0".to_owned()
        } else if !(1e-4..1e17).contains(&size) {
            format!("{self:e}")
        } else {
            format!("{self}")
        }
    }

    fn is_nothing(&self) -> bool {
        *self == 0.0
    }
}

impl Written for Rational {
    fn written(&self) -> String {
        self.to_string()
    }

    fn is_nothing(&self) -> bool {
        rational_to_f64(self) == 0.0 && self.numer().sign() == num_bigint::Sign::NoSign
    }
}
