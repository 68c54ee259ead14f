//! Benches of simulation besides the handover world: scenes with any robot,
//! whose controllers are processes.

mod process;
mod scene;

pub use scene::SceneCampaign;
