#![doc = include_str!("../README.md")]
//!
//! * [`explore::explore`] builds the reachable states of a model ([`state_space::StateSpace`]);
//! * [`symmetry`] finds symmetries of a model, up to which it is enough to explore;
//! * [`formats`] writes and reads them as PRISM's explicit files and as Storm's, and draws them;
//! * [`check()`] answers a property with a value and what is known of it ([`Guarantee`]);
//! * [`scheduler::scheduler`] gives the scheduler that attains the value, with the memory it needs, and the chain it induces;
//! * [`distribution`] has the probabilities of all states of a chain, at times and in the long run;
//! * [`Stop`] ends a check early with the bounds reached so far;
//! * [`sample_path`] draws a random path, the same for the same seed;
//! * [`paths`] has witnesses: the most probable and the shortest path to a goal, paths that take every
//!   transition, and what happens in each step;
//! * [`interval_model`] bounds a property over all chains whose probabilities lie in intervals.
//!
//! Methods by name ([`Method`]): sound (the default: floating point with bounds that hold, rounding included), exact
//! rational arithmetic, an imitation of PRISM's default for reproducing published figures, and the classical ones, of
//! which policy iteration and linear equations have bounds and the iterations none. Path formulas may be any linear temporal logic with step bounds, nested in probabilistic state formulas.

mod amount;
mod answer;
mod check;
pub mod choices;
mod co_safe;
mod cone;
mod diagonals;
pub mod distribution;
mod elimination;
mod engine;
mod evaluate;
mod exact;
pub mod explore;
mod fairness;
pub mod formats;
mod fragment;
pub mod graph;
mod interval_iteration;
pub mod interval_model;
mod joint;
mod krylov;
mod limit;
mod long_run;
mod lumping;
mod method;
mod multi;
mod not_yet;
mod optimum;
pub mod parametric;
pub mod paths;
mod poisson;
mod prism_default;
mod product;
mod property;
mod quotient;
mod reachability;
mod rewards;
mod rounding;
mod sample;
pub mod scheduler;
mod shape;
mod sound;
pub mod state_space;
mod steps;
mod stop;
pub mod symmetry;
#[cfg(test)]
mod test_models;
mod transient;
mod windows;
mod witness;

pub use answer::{Answer, AnswerValue, CheckError, Guarantee, InitialValue, Options};
pub use check::{bounds_of_states, check, check_exact, check_or_exact, check_space};
pub use evaluate::bounds_of_states::{Outcomes, StateBounds};
pub use method::{Method, Termination};
pub use not_yet::unsupported;
pub use rounding::Bounds;
pub use sample::{Visit, sample_path};
pub use stop::Stop;
pub use witness::{Witness, witness};
