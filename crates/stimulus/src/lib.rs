//! What is done to a system under test: abstract tests, parameters with distributions, settings.
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
//! | a bench's data that a stimulus changes | [`apply()`] |
//!
//! ```
//! use stimulus::{AbstractTest, Space, apply};
//!
//! let test: AbstractTest = toml::from_str(r#"
//!     name = "typical use"
//!     actions = [
//!       { send_signal = "activate", after_secs = { uniform = [0.5, 6.0] } },
//!       { receive_signal = "announcement" },
//!     ]"#)?;
//! let space = Space::from_toml(r#"
//!     [[parameter]]
//!     name = "friction"
//!     sets = ["hand.friction"]
//!     uniform = [0.4, 0.9]
//!     "#)?.with_delays_of(&test);
//!
//! // The centre of the unit cube: friction 0.65, a delay of 3.25 s.
//! let stimulus = space.stimulus(&test, &space.at(&[0.5, 0.5]))?;
//! let mut data: toml::Table = toml::from_str("[hand]\nfriction = 0.9")?;
//! apply(&mut data, &stimulus.settings)?;
//! assert_eq!(data["hand"]["friction"].as_float(), Some(0.65));
//! assert!(stimulus.to_toml().contains("after_secs = 3.25"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
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

pub use abstract_test::{AbstractTest, Action, Verb};
pub use apply::{apply, apply_declared};
pub use distribution::{Distribution, Options};
pub use error::StimulusError;
pub use setting::{Setting, Settings};
pub use space::{Constraint, Parameter, Point, Space};
pub use stimulus::Stimulus;
