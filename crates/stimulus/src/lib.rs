#![doc = include_str!("../README.md")]
//!
//! Every thing under test is a bench: a stimulus and a seed give one trace. This crate is the
//! stimulus, and knows nothing of any bench:
//!
//! | you have | it is |
//! |---|---|
//! | what is done, in order, without numbers | [`AbstractTest`]: send, receive, set |
//! | what varies, and how | [`Space`] of [`Parameter`]s with [`Distribution`]s, in the unit cube |
//! | one value for each parameter | [`Point`] |
//! | a test with its values, for one episode | [`Stimulus`], as TOML, JSON, and a hash |
//! | the same, with values that each episode draws | [`VariedStimulus`] |
//! | a bench's data that a stimulus changes | [`apply()`] |
//!
//! Nothing here prints, draws random numbers, or opens files.

mod abstract_test;
mod apply;
mod distribution;
mod error;
mod key;
mod normal;
mod setting;
mod space;
// The crate is called after its main noun, and so is the file.
#[allow(clippy::module_inception)]
mod stimulus;
mod varied;

pub use abstract_test::{AbstractTest, Action, Verb};
pub use apply::{apply, apply_declared};
pub use distribution::{Distribution, Options};
pub use error::StimulusError;
pub use setting::{Setting, Settings};
pub use space::{Constraint, Parameter, Point, Space};
pub use stimulus::Stimulus;
pub use varied::VariedStimulus;
