#![doc = include_str!("../README.md")]

#[cfg(not(unix))]
compile_error!(
    "this crate starts programs in groups of processes and ends them by signals, which it has for Unix alone: build it on Linux or macOS, or in WSL"
);

mod asset;
mod command;
mod handover;
mod parameters;
mod place;
mod process;
pub mod processor;
mod rest;
mod rig;
mod ros2;
mod saving;
mod scene;
pub mod surroundings;
mod trial;

pub use self::handover::{HandoverRig, HandoverTexts};
pub use asset::asset;
pub use command::{CommandRig, OutsideCommand};
pub use parameters::{check_keys, check_units, tried, unit_of};
pub use rest::{Link, Pace, Rest};
pub use rig::{Rig, episode_name, failed};
pub use ros2::Join;
pub use saving::{Resumable, Running, Saved};
pub use scene::{ScenePhysics, SceneRig};
pub use trial::{TrialCommand, TrialEnd};
