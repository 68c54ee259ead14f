#![doc = include_str!("../README.md")]
//!
//! # What is here
//!
//! | for | there is |
//! |---|---|
//! | whatever is put to a test: run once, watched while it runs, saved in the middle and continued | [`Bench`], [`Watch`], [`Savable`] |
//! | scenes of any robot, among things and people | [`scene`] |
//! | the robots' own code | [`controller`] |
//! | physics: a layout in plain numbers, and two engines that run it | [`physics`] |
//! | MuJoCo itself, for worlds with models of their own | [`Engine`], [`Simulation`] |
//! | seeded randomness | [`Stream`], [`Distribution`] |
//! | where bodies are while a run goes on, for who looks at it | [`Viewer`], [`ViewKeeper`] |
//! | how far two recordings lie apart | [`differences`] |
//!
//! MuJoCo is loaded at run time from a path the caller gives (`tools/mujoco` fetches the pinned release and prints it);
//! everything else works without it. `examples/scene.rs` runs a scene's episodes and prints one topic as CSV.
//!
//! # Determinism
//!
//! Each purpose draws from a random stream of its own under the run's seed, every rate is counted in whole time steps, and a
//! run builds its physics afresh. The same seed gives the same bits in a used bench, a fresh one, and on any thread. Across
//! machines MuJoCo's bits may differ: the C library chooses code by processor.

mod bench;
pub mod controller;
mod difference;
pub mod geometry;
mod hull;
mod mujoco;
pub mod physics;
mod random;
pub mod scene;
mod viewer;

pub use bench::{
    Bench, Cancel, Control, Creep, Drawn, End, Failure, OutOfReach, Part, Recorded, Savable,
    ScenarioError, SimError, Status, Unwatched, Watch,
};
pub use difference::{Compared, Difference, differences};
pub use hull::hull_triangles;
pub use mujoco::{
    BodyId, Contact, DriveLaw, Engine, EngineError, GeomId, JointId, RayHit, SUPPORTED_VERSION,
    SavedState, Simulation,
};
pub use random::{Distribution, Stream};
pub use viewer::{Geometry, Role, ViewKeeper, Viewer, VisibleShape};
