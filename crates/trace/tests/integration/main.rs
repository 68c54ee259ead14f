//! All integration tests of the crate in one program, since each program costs a link.

mod comparisons;
mod csv;
mod predicates;
mod robustness;
mod snapshot;
mod units;
