//! The simulated world around the robot's code: physics, drives, tracking, planner and human.

mod drives;
mod episode;
mod human;
mod judge;
mod planner;
mod plant;
mod recorder;
mod tracking;

pub use episode::{Cancel, Episode, SimError, World, run_episode, run_episode_with};
pub use judge::Outcome;
