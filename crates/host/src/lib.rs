#![doc = include_str!("../README.md")]
//!
//! No library reads the environment, catches a signal, ends the process or asks which executable runs: a face does, and
//! hands the answers over in a [`Host`]. Several hosts may live side by side in one process.

pub mod events;
pub mod files;
mod memory;
pub mod reach;
pub mod store;
pub mod system;
mod trust;

pub use diagnostic::Cancel;
pub use events::{Event, Events, Stage};
pub use memory::{MemoryBudget, Unlimited};
pub use reach::Reach;
pub use trust::Trust;

use diagnostic::Problem;
use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

/// Which build of the engine computes: results of another build are stale.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BuildId(String);

impl BuildId {
    /// A build by its name, for example a hash of the sources that compute results.
    pub fn new(name: impl Into<String>) -> Self {
        Self(name.into())
    }

    /// The name.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// What the engine is given by whoever runs it.
#[derive(Clone, Debug)]
pub struct Host {
    /// Where events go.
    pub events: Events,
    /// Whether somebody has asked to stop.
    pub cancel: Arc<Cancel>,
    /// The physics library, if its place is known.
    pub physics_library: Option<PathBuf>,
    /// Which build computes.
    pub build: BuildId,
    /// Where programs in Python that a study names find modules (`PYTHONPATH`); by default as the process has it.
    pub python_path: Option<OsString>,
    /// The folder for what passes while work goes on, and is removed again.
    pub scratch: PathBuf,
    /// Which studies may run the programs that they name.
    pub trust: Trust,
    /// How much memory the work may take.
    pub memory: Arc<dyn MemoryBudget>,
}

/// Where Unix has a folder for what passes, unless the environment names another one.
const SCRATCH: &str = "/tmp";

impl Host {
    /// A host that is silent, never asks to stop, has no physics and allows no study to run programs; what passes goes to `/tmp`.
    pub fn silent(build: BuildId) -> Self {
        Self {
            events: Events::none(),
            cancel: Arc::default(),
            physics_library: None,
            python_path: None,
            scratch: PathBuf::from(SCRATCH),
            trust: Trust::default(),
            build,
            memory: Arc::new(Unlimited),
        }
    }

    /// Fails if somebody has asked to stop.
    pub fn go_on(&self) -> Result<(), Problem> {
        match self.cancel.is_cancelled() {
            true => Err(Problem::interrupted()),
            false => Ok(()),
        }
    }
}
