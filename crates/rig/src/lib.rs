#![doc = include_str!("../README.md")]

mod asset;
mod command;
pub mod consent;
mod group;
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
mod start;
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
