//! Abstract tests, made: from a grammar, by agents, by mutation, from paths of a formal model.
//!
//! | source | made by | good for |
//! |---|---|---|
//! | what is possible, and rules that tests keep | [`Grammar::generate`] | what nobody thought of |
//! | what people do, reacting to the system | [`Agent::generate`] | usage as it will be |
//! | a goal that a test has to contain | [`Grammar::generate_for`] | each coverage goal |
//! | tests that were interesting | [`Grammar::mutate`] | going on from there |
//! | a path of a formal model | [`PathMapping::test`] | witnesses, transition coverage |
//!
//! Whatever the source, [`Known`] tells which tests were there before, and [`smallest_cover`]
//! which few tests of many reach every goal that any of them reaches.

mod agent;
mod grammar;
mod known;
mod mutation;
mod path;
mod pattern;

pub use agent::{Agent, Plan};
pub use grammar::{Alternative, Grammar, Rule, Values};
pub use known::{Cover, Known, smallest_cover};
pub use path::{FromPath, PathMapping, PathStep, StepRule};
pub use pattern::ActionPattern;

#[cfg(test)]
mod tests;
