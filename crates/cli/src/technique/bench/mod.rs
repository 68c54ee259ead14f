//! Benches of simulation besides the handover world: scenes with any robot,
//! whose controllers are processes or nodes of ROS 2.

mod place;
mod process;
pub mod processor;
mod ros2;
mod scene;

pub use scene::SceneCampaign;
