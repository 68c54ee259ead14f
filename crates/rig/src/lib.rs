#![doc = include_str!("../README.md")]

mod parameters;
mod place;
mod process;
pub mod processor;
mod ros2;
mod scene;

pub use parameters::{check_keys, check_units, tried, unit_of};
pub use ros2::Join;
pub use scene::SceneCampaign;
