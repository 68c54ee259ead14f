//! The simulated rest of a robot: an episode in step with somebody who keeps time, which reads from outside what is said to
//! be there.

use diagnostic::Problem;
use std::ops::ControlFlow;
use testbench::SimError;
use trace::{SignalValues, Trace};

/// Who keeps an episode in step.
pub trait Pace {
    /// Everything is ready, the robot's code too; time begins.
    fn start(&mut self);

    /// The episode has come to `now_secs`; `recorded` is everything that was recorded so far. It goes on when this
    /// returns; `Break` ends it.
    fn step(&mut self, now_secs: f64, recorded: &Trace) -> ControlFlow<()>;
}

/// The simulated rest of a robot.
pub trait Rest: Send + Sync {
    /// The signals that are read from outside.
    fn signals(&self) -> Vec<String>;

    /// The way of these signals, found in `layout`, to the episode under way.
    ///
    /// # Errors
    /// `unfit-input` for a signal that is not there, or not as it can be read.
    fn link(&self, layout: &Trace) -> Result<Box<dyn Link>, Problem>;

    /// Simulated time from step to step: that of the robot's code, or of the recording where there is none.
    fn period_secs(&self) -> f64;

    /// An episode: its trace and how long it took.
    ///
    /// # Errors
    /// [`SimError::Cancelled`] if `pace` ends it, and whatever keeps the simulation from going on.
    fn run(&self, seed: u64, pace: &mut dyn Pace) -> Result<(Trace, f64), SimError>;
}

/// Passes the values of signals on to the episode under way.
pub trait Link: Send {
    /// Passes on what the signals are at this instant.
    fn pass(&self, values: &dyn SignalValues);
}
