//! The binding to the MuJoCo physics engine, and the only `unsafe` code of this crate.
//!
//! Why `unsafe` at all: MuJoCo is a C library. Why here alone: everything above this module holds
//! a [`Simulation`] and sees slices and numbers. Why loaded at run time: the rest of the product
//! must build and work on a machine without the library.
//!
//! Soundness rests on three things. (1) The version is checked before any function is called, and
//! only [`SUPPORTED_VERSION`] is accepted, so signatures and layouts are those of its header.
//! (2) [`Engine::load`] runs a small scene and compares every field reached through
//! a byte offset with what MuJoCo's own functions say. (3) A [`Simulation`] owns its model and
//! data; nothing else holds their pointers, and mutation needs `&mut`.

#![allow(unsafe_code)]

mod functions;
mod layout;
mod self_check;
mod simulation;

use std::ffi::c_int;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use simulation::{BodyId, Contact, DriveLaw, GeomId, JointId, RayHit, SavedState, Simulation};

use functions::{Functions, OpenError};

/// The MuJoCo version this crate is written against; patch releases of it are accepted.
pub const SUPPORTED_VERSION: &str = "3.17";

/// `mj_version()` of the accepted releases: `major * 1e6 + minor * 1e3 + patch`.
const ACCEPTED: std::ops::Range<c_int> = 3_017_000..3_018_000;

/// A loaded and checked MuJoCo library. Cloning it is cheap; threads may share it.
#[derive(Clone)]
pub struct Engine {
    functions: Arc<Functions>,
    version: c_int,
}

impl Engine {
    /// Loads `libmujoco` from `path` (for example what `tools/mujoco` prints) and checks it.
    ///
    /// The file is executed as code: name only a library you trust.
    ///
    /// # Errors
    /// When the file is not a loadable library, is another version, or fails the self check.
    pub fn load(path: &Path) -> Result<Self, EngineError> {
        // SAFETY: the caller names a library it trusts; its version is checked before use.
        let opened = unsafe { functions::open(path, ACCEPTED) };
        let (functions, version) = opened.map_err(|error| match error {
            OpenError::Load(error) => EngineError::NotLoadable {
                path: path.to_owned(),
                reason: error.to_string(),
            },
            OpenError::Version(found) => EngineError::WrongVersion {
                found: version_text(found),
            },
        })?;
        let engine = Self {
            functions: Arc::new(functions),
            version,
        };
        self_check::run(&engine)?;
        Ok(engine)
    }

    /// The engine's version, for example `3.17.0`; part of every trace's metadata.
    #[must_use]
    pub fn version(&self) -> String {
        version_text(self.version)
    }

    /// Compiles a model in MJCF and makes the data to simulate it.
    ///
    /// # Errors
    /// When MuJoCo refuses the model; the message is MuJoCo's.
    pub fn compile(&self, mjcf: &str) -> Result<Simulation, EngineError> {
        Simulation::compile(Arc::clone(&self.functions), mjcf)
    }
}

impl fmt::Debug for Engine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Engine")
            .field("version", &self.version())
            .finish()
    }
}

/// `3017000` as `3.17.0`.
fn version_text(version: c_int) -> String {
    format!(
        "{}.{}.{}",
        version / 1_000_000,
        version / 1_000 % 1_000,
        version % 1_000
    )
}

/// Why the physics engine could not be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EngineError {
    /// The file is missing, is no library, or lacks a function.
    NotLoadable {
        /// The path that was tried.
        path: PathBuf,
        /// What the loader said.
        reason: String,
    },
    /// The library is another version than this crate is written against.
    WrongVersion {
        /// The version found.
        found: String,
    },
    /// The library does not lay out its data as the header of its version says.
    SelfCheck {
        /// The field that disagreed.
        what: &'static str,
    },
    /// MuJoCo refused the model.
    Model {
        /// MuJoCo's message.
        reason: String,
    },
    /// MuJoCo could not allocate the simulation's data.
    OutOfMemory,
}

impl fmt::Display for EngineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotLoadable { path, reason } => write!(
                f,
                "the physics library {} cannot be loaded ({reason}); run tools/mujoco and give the path it prints",
                path.display()
            ),
            Self::WrongVersion { found } => write!(
                f,
                "the physics library is MuJoCo {found}, but {SUPPORTED_VERSION} is needed; run tools/mujoco and give the path it prints"
            ),
            Self::SelfCheck { what } => write!(
                f,
                "the physics library failed its self check at {what}: it is not the release build of MuJoCo {SUPPORTED_VERSION}; run tools/mujoco"
            ),
            Self::Model { reason } => write!(
                f,
                "MuJoCo refuses the scenario's model: {reason}; correct the scenario's bodies or parameters"
            ),
            Self::OutOfMemory => {
                write!(
                    f,
                    "MuJoCo could not allocate a simulation; free memory or run fewer at once"
                )
            }
        }
    }
}

impl std::error::Error for EngineError {}
