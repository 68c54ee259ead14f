//! Runs that are saved and continued, whatever the bench is.
//!
//! [`Savable`] has a type for its runs and one for what is saved of them, so a bench behind it cannot be chosen while the
//! program runs. Here a run knows its bench, and what was saved of it continues on the same bench by itself, so nothing has
//! to be asked for its type.

use std::sync::Arc;
use stimulus::Stimulus;
use testbench::{Cancel, Recorded, Savable, SimError, Status, Watch};

/// A bench whose runs can be saved in the middle and continued.
pub trait Resumable: Send + Sync {
    /// Begins a run.
    ///
    /// # Errors
    /// As [`Savable::start`].
    fn start<'b>(
        &'b self,
        stimulus: &Stimulus,
        seed: u64,
    ) -> Result<Box<dyn Running<'b> + 'b>, SimError>;
}

/// A run in progress.
pub trait Running<'b>: Send {
    /// Goes on until `until_secs` of simulated time or the run's end, whichever comes first.
    ///
    /// # Errors
    /// As [`Savable::advance`].
    fn advance(
        &mut self,
        until_secs: f64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Status, SimError>;

    /// Simulated time.
    fn now_secs(&self) -> f64;

    /// Everything that determines how the run goes on.
    ///
    /// # Errors
    /// As [`Savable::save`].
    fn save(&self) -> Result<Saved<'b>, SimError>;

    /// Closes the recording.
    ///
    /// # Errors
    /// As [`Savable::finish`].
    fn finish(self: Box<Self>) -> Result<Recorded, SimError>;
}

/// A saved run. Clones share it.
#[derive(Clone)]
pub struct Saved<'b>(Arc<dyn Continues<'b> + 'b>);

impl<'b> Saved<'b> {
    /// A run that goes on from there. Without a seed it continues bit for bit as the saved one would; with one, whatever
    /// is still to be drawn is drawn anew.
    ///
    /// # Errors
    /// As [`Savable::resume`].
    pub fn resume(&self, new_seed: Option<u64>) -> Result<Box<dyn Running<'b> + 'b>, SimError> {
        self.0.resume(new_seed)
    }
}

trait Continues<'b>: Send + Sync {
    fn resume(&self, new_seed: Option<u64>) -> Result<Box<dyn Running<'b> + 'b>, SimError>;
}

/// A run with its bench.
struct RunOn<'b, B: Savable> {
    bench: &'b B,
    run: B::Running,
}

/// What was saved of a run, with its bench.
struct SavedOn<'b, B: Savable> {
    bench: &'b B,
    saved: B::Saved,
}

impl<B> Resumable for B
where
    B: Savable + 'static,
    B::Running: 'static,
    B::Saved: 'static,
{
    fn start<'b>(
        &'b self,
        stimulus: &Stimulus,
        seed: u64,
    ) -> Result<Box<dyn Running<'b> + 'b>, SimError> {
        let run = Savable::start(self, stimulus, seed)?;
        Ok(Box::new(RunOn { bench: self, run }))
    }
}

impl<'b, B> Running<'b> for RunOn<'b, B>
where
    B: Savable + 'static,
    B::Running: 'static,
    B::Saved: 'static,
{
    fn advance(
        &mut self,
        until_secs: f64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Status, SimError> {
        self.bench.advance(&mut self.run, until_secs, watch, cancel)
    }

    fn now_secs(&self) -> f64 {
        self.bench.now_secs(&self.run)
    }

    fn save(&self) -> Result<Saved<'b>, SimError> {
        let saved = self.bench.save(&self.run)?;
        let bench = self.bench;
        Ok(Saved(Arc::new(SavedOn { bench, saved })))
    }

    fn finish(self: Box<Self>) -> Result<Recorded, SimError> {
        self.bench.finish(self.run)
    }
}

impl<'b, B> Continues<'b> for SavedOn<'b, B>
where
    B: Savable + 'static,
    B::Running: 'static,
    B::Saved: 'static,
{
    fn resume(&self, new_seed: Option<u64>) -> Result<Box<dyn Running<'b> + 'b>, SimError> {
        let run = self.bench.resume(&self.saved, new_seed)?;
        let bench = self.bench;
        Ok(Box::new(RunOn { bench, run }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use testbench::Unwatched;
    use testbench::controller::ControllerError;
    use testbench::scene::{SceneBench, rapier};

    /// A box whose pose is measured with errors, which are drawn for each reading.
    const SCENE: &str = r#"
name = "standing"
simulation = { duration_secs = 1.0, time_step_secs = 0.01 }

[[robot]]
name = "carrier"
file = "carrier.urdf"

[[sensor]]
name = "pose"
robot = "carrier"
kind = "pose"
rate_hz = 20
noise = { x_m = 1.0 }

[[abstract_test]]
name = "nothing"
actions = []
"#;

    const CARRIER: &str = r#"<robot name="carrier"><link name="base">
<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>
</link></robot>"#;

    fn bench() -> (SceneBench, Stimulus) {
        let read = |_: &str| Ok(CARRIER.as_bytes().to_vec());
        let none = Arc::new(|_: &_| {
            Err(ControllerError::Failed {
                message: "there is none".to_owned(),
            })
        });
        let (bench, _) = SceneBench::new(SCENE, &read, rapier(), none).expect("a scene");
        let stimulus = Stimulus::of(bench.tests()[0].clone());
        (bench, stimulus)
    }

    /// Its bytes: of numbers that are none, none is equal to itself.
    fn recording(recorded: &Recorded) -> Vec<u8> {
        assert!(recorded.trace.complete, "it ends by itself");
        recording::to_mcap(&recorded.trace).expect("a recording")
    }

    /// A run that is saved after half a second and continued, with the types of the bench.
    fn typed(bench: &SceneBench, stimulus: &Stimulus, new_seed: Option<u64>) -> Vec<u8> {
        let cancel = Cancel::default();
        let mut run = Savable::start(bench, stimulus, 7).expect("begun");
        let status = bench.advance(&mut run, 0.5, &mut Unwatched, &cancel);
        assert_eq!(status.expect("it goes on"), Status::Running);
        let saved = bench.save(&run).expect("saved");
        let mut run = bench.resume(&saved, new_seed).expect("continued");
        let status = bench.advance(&mut run, f64::INFINITY, &mut Unwatched, &cancel);
        assert_ne!(status.expect("it ends"), Status::Running);
        recording(&bench.finish(run).expect("a recording"))
    }

    /// The same without them.
    fn erased(bench: &dyn Resumable, stimulus: &Stimulus, new_seed: Option<u64>) -> Vec<u8> {
        let cancel = Cancel::default();
        let mut run = bench.start(stimulus, 7).expect("begun");
        let status = run.advance(0.5, &mut Unwatched, &cancel);
        assert_eq!(status.expect("it goes on"), Status::Running);
        assert!((run.now_secs() - 0.5).abs() < 0.011);
        let saved = run.save().expect("saved").clone();
        drop(run);
        let mut run = saved.resume(new_seed).expect("continued");
        let status = run.advance(f64::INFINITY, &mut Unwatched, &cancel);
        assert_ne!(status.expect("it ends"), Status::Running);
        recording(&run.finish().expect("a recording"))
    }

    #[test]
    fn erased_and_typed_runs_give_the_same_recording() {
        let (bench, stimulus) = bench();
        let whole = erased(&bench, &stimulus, None);
        assert!(whole == typed(&bench, &stimulus, None), "continued");
        let anew = erased(&bench, &stimulus, Some(8));
        assert!(anew == typed(&bench, &stimulus, Some(8)), "drawn anew");
        assert!(whole != anew, "it draws nothing anew");
    }
}
