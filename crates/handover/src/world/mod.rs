//! The simulated world around the robot's code: physics, drives, tracking, planner and human.

mod bench;
mod drives;
mod engine_alone;
mod episode;
mod human;
mod judge;
mod planner;
mod plant;
mod recorder;
mod run;
mod setup;
mod tracking;
mod view;

pub use bench::{HandoverBench, RunningHandover, SavedHandover};
pub use engine_alone::{EngineAlone, Steps};
pub use episode::{Episode, run_episode, run_episode_with, watch_episode};
pub use judge::Outcome;
pub use setup::World;
