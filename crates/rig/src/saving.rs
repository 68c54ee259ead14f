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
