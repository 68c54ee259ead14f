//! Episodes of scenes that are saved in the middle and continued.
//!
//! Physics is saved by its engine, everything else by copying it, except controllers: one may be a
//! process, whose memory is its own. What a controller was told is kept instead, and a new one is
//! told the same again. Its answers have to be the same, bit for bit; a controller that answers
//! otherwise cannot be saved, and is told so. So resuming costs the controllers' time again, but no
//! physics.
//!
//! With a new seed, errors of sensors and delays of the test are drawn anew from there on. What the
//! episode drew at its beginning (masses, speeds, faults) and the seed that controllers were given
//! stay.

use std::sync::Arc;

use stimulus::Stimulus;
use trace::Trace;

use super::bench::SceneBench;
use super::draws::Draws;
use super::run::{Frozen, Run};
use crate::bench::{Cancel, End, Recorded, Savable, SimError, Status, Unwatched, Watch};

/// An episode of a scene in progress; see [`Savable`].
pub struct RunningScene(Run);

/// A saved episode of a scene; see [`Savable`]. Clones share it.
#[derive(Clone)]
pub struct SavedScene(Arc<Frozen>);

impl RunningScene {
    /// From now on what a sensor measures comes from outside, without the errors, latency and faults
    /// that the scene gives it: at each of its times it measures `values` (a list for each of
    /// [`Sensor::fields`](super::Sensor::fields)), or nothing while they are not known.
    ///
    /// An episode with an outside is as repeatable as the outside is.
    ///
    /// # Errors
    /// [`SimError::Stimulus`] for a sensor that there is not, or values that do not fit its fields.
    pub fn measure_outside(
        &mut self,
        sensor: &str,
        values: Option<Vec<Vec<f64>>>,
    ) -> Result<(), SimError> {
        let refused = |reason: String| Err(SimError::Stimulus { reason });
        let Some(found) = self.0.sensor_mut(sensor) else {
            return refused(format!("there is no sensor `{sensor}`"));
        };
        if let Some(values) = &values {
            let lengths = found.fields.iter().map(|field| field.length);
            if !values.iter().map(Vec::len).eq(lengths) {
                return refused(format!("the values do not fit the fields of `{sensor}`"));
            }
        }
        found.outside = Some(values);
        Ok(())
    }
}

impl Savable for SceneBench {
    type Running = RunningScene;
    type Saved = SavedScene;

    fn start(&self, stimulus: &Stimulus, seed: u64) -> Result<RunningScene, SimError> {
        let mut run = Run::new(
            self.with_settings(&stimulus.settings, seed)?,
            stimulus,
            seed,
        )?;
        run.pilots.iter_mut().for_each(|pilot| pilot.keep_log());
        Ok(RunningScene(run))
    }

    fn advance(
        &self,
        running: &mut RunningScene,
        until_secs: f64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Status, SimError> {
        loop {
            if let Some(end) = running.0.end() {
                return Ok(Status::Ended(end));
            }
            if running.0.now_secs() + 1e-9 >= until_secs {
                return Ok(Status::Running);
            }
            if cancel.is_cancelled() {
                return Err(SimError::Cancelled);
            }
            running.0.step(watch)?;
        }
    }

    fn now_secs(&self, running: &RunningScene) -> f64 {
        running.0.now_secs()
    }

    fn so_far<'a>(&self, running: &'a RunningScene) -> &'a Trace {
        &running.0.recorder.trace
    }

    fn save(&self, running: &RunningScene) -> Result<SavedScene, SimError> {
        Ok(SavedScene(Arc::new(running.0.freeze())))
    }

    fn resume(&self, saved: &SavedScene, new_seed: Option<u64>) -> Result<RunningScene, SimError> {
        let mut run = Run::thaw(&saved.0)?;
        if let Some(seed) = new_seed {
            run.draw_anew(Draws { seed });
        }
        Ok(RunningScene(run))
    }

    fn finish(&self, running: RunningScene) -> Result<Recorded, SimError> {
        let end = running.0.end().unwrap_or(End::Watched);
        running.0.finish(end, &mut Unwatched)
    }
}
