//! Episodes that are frozen and thawed; what that means is said in [`super::super::saving`].

use super::*;
use crate::physics::PhysicsState;
use crate::scene::piloting::PilotLog;

/// Everything of an episode but the engine and the controllers themselves.
pub(in crate::scene) struct Frozen {
    prepared: Arc<Prepared>,
    seed: u64,
    draws: Draws,
    built: Built,
    physics: PhysicsState,
    people: Vec<Walker>,
    takings: Vec<Option<Taking>>,
    sensors: Vec<Sensing>,
    actuators: Vec<Actuating>,
    pilots: Vec<PilotLog>,
    script: Script,
    known: Known,
    recorder: Recorder,
    witness: Witness,
    grips: Grips,
    touches: Vec<Touch>,
    forces: Vec<[f64; 2]>,
    arrived: Vec<bool>,
    steps: u64,
    record_steps: u64,
    people_steps: u64,
    finished_secs: Option<f64>,
    commands: VecDeque<(f64, usize, usize, f64)>,
}

impl Run {
    /// Everything that determines how the episode goes on.
    pub(in crate::scene) fn freeze(&self) -> Frozen {
        Frozen {
            prepared: Arc::clone(&self.prepared),
            seed: self.seed,
            draws: self.draws,
            built: self.built.clone(),
            physics: self.physics.save(),
            people: self.people.clone(),
            takings: self.takings.clone(),
            sensors: self.sensors.clone(),
            actuators: self.actuators.clone(),
            pilots: self.pilots.iter().map(Piloting::log).collect(),
            script: self.script.clone(),
            known: self.known.clone(),
            recorder: self.recorder.clone(),
            witness: self.witness.clone(),
            grips: self.grips.clone(),
            touches: self.touches.clone(),
            forces: self.forces.clone(),
            arrived: self.arrived.clone(),
            steps: self.steps,
            record_steps: self.record_steps,
            people_steps: self.people_steps,
            finished_secs: self.finished_secs,
            commands: self.commands.clone(),
        }
    }

    /// An episode that goes on from a saved one.
    pub(in crate::scene) fn thaw(frozen: &Frozen) -> Result<Self, SimError> {
        let prepared = Arc::clone(&frozen.prepared);
        let mut physics = (prepared.physics)(&frozen.built.layout)?;
        if !physics.restore(&frozen.physics) {
            return Err(SimError::Stimulus {
                reason: "the saved state is of another scene".to_owned(),
            });
        }
        let controllers = prepared.data.controllers.iter().zip(&frozen.pilots);
        let pilots = controllers
            .map(|(data, log)| Piloting::replay(&prepared, data, log))
            .collect::<Result<_, _>>()?;
        Ok(Self {
            seed: frozen.seed,
            draws: frozen.draws,
            built: frozen.built.clone(),
            physics,
            people: frozen.people.clone(),
            takings: frozen.takings.clone(),
            sensors: frozen.sensors.clone(),
            actuators: frozen.actuators.clone(),
            pilots,
            script: frozen.script.clone(),
            known: frozen.known.clone(),
            recorder: frozen.recorder.clone(),
            witness: frozen.witness.clone(),
            grips: frozen.grips.clone(),
            touches: frozen.touches.clone(),
            touchers: Toucher::of(&frozen.built.layout, &frozen.built.people),
            skin: Vec::new(),
            forces: frozen.forces.clone(),
            arrived: frozen.arrived.clone(),
            steps: frozen.steps,
            record_steps: frozen.record_steps,
            people_steps: frozen.people_steps,
            finished_secs: frozen.finished_secs,
            commands: frozen.commands.clone(),
            prepared,
        })
    }

    /// Draws what is still to be drawn under another seed.
    pub(in crate::scene) fn draw_anew(&mut self, draws: Draws) {
        self.draws = draws;
        for sensor in &mut self.sensors {
            sensor.draw_anew(draws);
        }
        for person in &mut self.people {
            person.draw_anew(draws);
        }
        for actuator in &mut self.actuators {
            actuator.errors.draw_anew(draws);
        }
        self.recorder.note("drawn_anew_seed", draws.seed);
        let secs = self.now_secs();
        self.recorder.note("drawn_anew_from_secs", secs);
    }
}
