//! One scenario and one seed give one trace, bit for bit.

pub mod geometry;
mod model;
mod mujoco;
mod random;
pub mod robot;
pub mod scenario;
mod world;

pub use model::{PhysicalDraws, joint_order, mjcf, standing_pose};
pub use mujoco::{
    BodyId, Contact, Engine, EngineError, GeomId, SUPPORTED_VERSION, SavedState, Simulation,
};
pub use random::{Distribution, Purpose, Stream};
pub use scenario::{Parameters, Scenario, ScenarioError};
pub use world::{Cancel, Episode, Outcome, SimError, World, run_episode};
