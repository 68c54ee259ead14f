//! The physics engine alone: the steps of an episode of the full physics, without anything around them.
//!
//! An episode is run once, and what the engine is given before each of its steps is kept: the servos' setpoints and the force
//! on the object. The engine then takes the same steps from the same start with nothing in between, which bounds from below
//! what an episode can cost as long as no bit of it changes. That the steps are the same is checked: all joints and the
//! object end in the same bits.

use testbench::{Cancel, SimError, Unwatched};

use super::plant::Plant;
use super::run::Run;
use super::setup::World;

/// The engine's steps of one episode, to be taken by themselves.
pub struct EngineAlone {
    plant: Plant,
    /// What each step is given, one step after the other.
    inputs: Vec<f64>,
    end: Vec<u64>,
}

impl EngineAlone {
    /// Runs the episode of `world` with `seed` and keeps what the engine is given. `None` in the fast physics, which steps
    /// the engine only where nothing else will do.
    ///
    /// # Errors
    /// As [`crate::run_episode`].
    pub fn record(world: &World, seed: u64) -> Result<Option<Self>, SimError> {
        if world.setup().scenario.simulation.fast {
            return Ok(None);
        }
        let mut run = Run::new(world, seed)?;
        let plant = Run::new(world, seed)?.into_plant();
        let mut inputs = Vec::new();
        while run.ended().is_none() {
            run.check(&Cancel::default())?;
            run.advance(&mut Unwatched)?;
            run.plant().engine_inputs(&mut inputs);
        }
        let end = run.plant().engine_state();
        Ok(Some(Self { plant, inputs, end }))
    }

    /// The engine at the episode's start, ready to take its steps.
    ///
    /// # Errors
    /// [`SimError::Engine`] when memory does not suffice for a copy of the start.
    pub fn start(&self) -> Result<Steps<'_>, SimError> {
        Ok(Steps {
            plant: self.plant.duplicate()?,
            of: self,
        })
    }
}

/// The engine at the start of an episode.
pub struct Steps<'a> {
    plant: Plant,
    of: &'a EngineAlone,
}

impl Steps<'_> {
    /// Takes all steps and returns their number; nothing else is done here.
    pub fn take(&mut self) -> u64 {
        self.plant.engine_steps(&self.of.inputs)
    }

    /// Whether everything ended where it did in the episode, bit for bit.
    #[must_use]
    pub fn ended_the_same(&self) -> bool {
        self.plant.engine_state() == self.of.end
    }
}
