//! Which engine integrates the full physics.

use testbench::Engine;
use testbench::physics::RAPIER_VERSION;

/// The engine that integrates the full physics.
#[derive(Debug, Clone)]
pub enum Physics {
    /// MuJoCo, whose library is loaded; the reference. Its short cuts for searching are the fast physics.
    Mujoco(Engine),
    /// Rapier, which is built in: the same model in another engine, made by others with other methods. It has no fast physics.
    Rapier,
}

impl Physics {
    /// The engine's name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Mujoco(_) => "MuJoCo",
            Self::Rapier => "Rapier",
        }
    }

    /// Its version.
    #[must_use]
    pub fn version(&self) -> String {
        match self {
            Self::Mujoco(engine) => engine.version(),
            Self::Rapier => RAPIER_VERSION.to_owned(),
        }
    }

    /// Whether less than its full physics can stand in for it in searches.
    pub(crate) fn has_short_cuts(&self) -> bool {
        matches!(self, Self::Mujoco(_))
    }
}

impl From<Engine> for Physics {
    fn from(engine: Engine) -> Self {
        Self::Mujoco(engine)
    }
}

impl From<&Engine> for Physics {
    fn from(engine: &Engine) -> Self {
        Self::Mujoco(engine.clone())
    }
}

impl From<&Self> for Physics {
    fn from(physics: &Self) -> Self {
        physics.clone()
    }
}
