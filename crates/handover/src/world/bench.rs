//! The handover world as a [`Bench`].
//!
//! Its data are two tables, `scenario` and `parameters`; settings of a stimulus name values in them
//! by dotted keys, for example `parameters.human.pull_forward_newtons` or
//! `scenario.programme.sensing_secs`, and are applied before the tables are read and checked. Its
//! signals are `activate` and `ready` (sent), `announcement` (received), its parameters `gaze`,
//! `pressure` and `location` (true or false).
//!
//! Which physics integrates is no part of a stimulus: a bench has one physics, that of its scenario, and
//! [`HandoverBench::in_fast_physics`] makes its twin for searching.

use std::sync::{Arc, Mutex, PoisonError};

use stimulus::{Settings, Stimulus};
use testbench::{
    Bench, Cancel, Drawn, Recorded, Savable, ScenarioError, SimError, Status, Unwatched, Watch,
};
use toml::Table;
use trace::Trace;

use super::episode::{Episode, watch_episode};
use super::recorder::Recorder;
use super::run::Run;
use super::setup::World;
use crate::physics::Physics;
use crate::scenario::{AbstractTest, Parameters, Scenario};

/// The handover world, made anew for each stimulus.
#[derive(Debug, Clone)]
pub struct HandoverBench {
    physics: Physics,
    data: Table,
    world: World,
}

/// An episode in progress; see [`Savable`].
pub struct RunningHandover(Run);

/// A saved episode; see [`Savable`]. Clones share it.
#[derive(Clone)]
pub struct SavedHandover(Arc<Mutex<Run>>);

impl HandoverBench {
    /// The bench of a scenario and a parameter set, both as TOML text.
    ///
    /// # Errors
    /// [`SimError::Scenario`] for texts that cannot be used, [`SimError::Engine`] when the physics
    /// engine refuses the model.
    pub fn new(
        physics: impl Into<Physics>,
        scenario: &str,
        parameters: &str,
    ) -> Result<Self, SimError> {
        let physics = physics.into();
        let world = World::new(
            &physics,
            &Scenario::parse(scenario)?,
            &Parameters::parse(parameters)?,
        )?;
        let data = [("scenario", scenario), ("parameters", parameters)]
            .map(|(key, text)| Ok((key.to_owned(), table(text)?.into())));
        Ok(Self {
            physics,
            data: data.into_iter().collect::<Result<_, ScenarioError>>()?,
            world,
        })
    }

    /// The tables `scenario` and `parameters` that settings act on.
    #[must_use]
    pub fn data(&self) -> &Table {
        &self.data
    }

    /// The same bench in the fast physics (see the crate's "Fast physics"), which is approximate: for
    /// searching, where what is found is shown by the full physics before it counts. `None` where the
    /// scenario or the engine has none, or this is that bench already.
    #[must_use]
    pub fn in_fast_physics(&self) -> Option<Self> {
        let scenario = &self.world.setup().scenario;
        if !self.physics.has_short_cuts()
            || scenario.simulation.fast
            || !crate::model::hand_is_separable(scenario)
        {
            return None;
        }
        let mut data = self.data.clone();
        let simulation = data.get_mut("scenario")?.get_mut("simulation")?;
        simulation
            .as_table_mut()?
            .insert("fast".to_owned(), true.into());
        Some(Self {
            physics: self.physics.clone(),
            data,
            world: self.world.clone().in_fast_physics(),
        })
    }

    /// Whether it runs in the fast physics.
    #[must_use]
    pub fn is_fast(&self) -> bool {
        self.world.setup().scenario.simulation.fast
    }

    /// One of the scenario's own abstract tests as a stimulus without settings.
    ///
    /// # Errors
    /// [`SimError::UnknownTest`].
    pub fn own_test(&self, name: &str) -> Result<Stimulus, SimError> {
        let tests = self.data["scenario"]["abstract_test"].clone();
        let tests: Vec<stimulus::AbstractTest> = tests.try_into().map_err(unsuitable)?;
        let test = tests.into_iter().find(|test| test.name == name);
        let unknown = || SimError::UnknownTest {
            name: name.to_owned(),
        };
        Ok(Stimulus {
            test: test.ok_or_else(unknown)?,
            settings: Settings::new(),
        })
    }

    /// The world that a stimulus makes; delays of kinds that the scenario's own tests do not know
    /// are drawn from `seed`.
    ///
    /// # Errors
    /// [`SimError::Stimulus`].
    pub fn world(&self, stimulus: &Stimulus, seed: u64) -> Result<World, SimError> {
        let test = AbstractTest::concrete(&stimulus.test, seed)
            .map_err(|reason| SimError::Stimulus { reason })?;
        if stimulus.settings.is_empty() {
            return Ok(self.world.clone().enacting(test));
        }
        let mut data = self.data.clone();
        stimulus::apply(&mut data, &stimulus.settings).map_err(unsuitable)?;
        let mut take = |key| match data.remove(key) {
            Some(toml::Value::Table(table)) => table,
            _ => Table::new(),
        };
        let scenario = Scenario::from_table(take("scenario")).map_err(unsuitable)?;
        if scenario.simulation.fast != self.is_fast() {
            return Err(unsuitable(
                "`scenario.simulation.fast` is not a setting: evidence is of the full physics, and searches choose theirs by `physics`",
            ));
        }
        let parameters = Parameters::from_table(take("parameters")).map_err(unsuitable)?;
        Ok(World::unchecked(&self.physics, scenario, parameters)?.enacting(test))
    }

    /// The numbers that the run of a stimulus and a seed draws once. With all of them as settings the
    /// run is the same.
    ///
    /// # Errors
    /// [`SimError::Stimulus`].
    pub fn drawn(&self, stimulus: &Stimulus, seed: u64) -> Result<Vec<Drawn>, SimError> {
        Ok(self.world(stimulus, seed)?.drawn(seed))
    }

    /// As [`Bench::run`], with the summary of the handover.
    ///
    /// # Errors
    /// As [`Bench::run`].
    pub fn episode(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Episode, SimError> {
        watch_episode(&self.world(stimulus, seed)?, seed, watch, cancel)
    }
}

/// Parses a table that was checked before.
fn table(text: &str) -> Result<Table, ScenarioError> {
    toml::from_str(text).map_err(|error| ScenarioError::Syntax {
        reason: error.to_string(),
    })
}

fn unsuitable(error: impl std::fmt::Display) -> SimError {
    SimError::Stimulus {
        reason: error.to_string(),
    }
}

impl Bench for HandoverBench {
    fn layout(&self) -> Result<Trace, SimError> {
        Ok(Recorder::new()?.finish(true))
    }

    fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Recorded, SimError> {
        Ok(self.episode(stimulus, seed, watch, cancel)?.into())
    }
}

impl Savable for HandoverBench {
    type Running = RunningHandover;
    type Saved = SavedHandover;

    fn start(&self, stimulus: &Stimulus, seed: u64) -> Result<RunningHandover, SimError> {
        let world = self.world(stimulus, seed)?;
        Ok(RunningHandover(Run::new(&world, seed)?))
    }

    fn advance(
        &self,
        running: &mut RunningHandover,
        until_secs: f64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Status, SimError> {
        let RunningHandover(run) = running;
        loop {
            if let Some(end) = run.ended() {
                return Ok(Status::Ended(end));
            }
            if run.now_secs() + 1e-9 >= until_secs {
                return Ok(Status::Running);
            }
            run.check(cancel)?;
            run.advance(watch)?;
        }
    }

    fn now_secs(&self, running: &RunningHandover) -> f64 {
        running.0.now_secs()
    }

    fn so_far<'a>(&self, running: &'a RunningHandover) -> &'a Trace {
        running.0.so_far()
    }

    fn save(&self, running: &RunningHandover) -> Result<SavedHandover, SimError> {
        let run = running.0.duplicate(None)?;
        Ok(SavedHandover(Arc::new(Mutex::new(run))))
    }

    fn resume(
        &self,
        saved: &SavedHandover,
        new_seed: Option<u64>,
    ) -> Result<RunningHandover, SimError> {
        // A panic elsewhere cannot leave the saved run half changed: it is only ever read.
        let run = saved.0.lock().unwrap_or_else(PoisonError::into_inner);
        Ok(RunningHandover(run.duplicate(new_seed)?))
    }

    fn finish(&self, running: RunningHandover) -> Result<Recorded, SimError> {
        Ok(running.0.finish(&mut Unwatched)?.into())
    }
}
