//! State space of a PRISM model, value of a property, and the guarantee of that value.

mod answer;
mod check;
mod elimination;
mod engine;
mod exact;
pub mod explore;
pub mod graph;
mod interval_iteration;
mod prism_default;
mod product;
mod property;
mod rounding;
mod sample;
mod sound;
pub mod state_space;

pub use answer::{Answer, AnswerValue, CheckError, Guarantee, InitialValue, Method, Options};
pub use check::{check, check_exact, check_space};
pub use rounding::Bounds;
pub use sample::sample_path;
