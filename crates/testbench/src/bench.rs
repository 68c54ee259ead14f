//! What every thing under test looks like to a campaign: a bench.
//!
//! A bench takes a stimulus and a seed and gives a recording, bit for bit: the same stimulus and
//! seed give the same bytes, in any process and on any thread. While it runs, a [`Watch`] sees each
//! row as it is recorded and may end the run once it knows enough. A [`Savable`] bench can moreover
//! be stopped anywhere and continued from there, as it was or with other random draws: that is what
//! splitting needs.

mod error;
mod savable;
mod scenario_error;

use serde::{Deserialize, Serialize};
use stimulus::Stimulus;
use trace::Trace;

use crate::controller::ControllerError;
use crate::viewer::Viewer;

pub use diagnostic::Cancel;
pub use error::SimError;
pub use savable::{Savable, Status};
pub use scenario_error::ScenarioError;

/// What a [`Watch`] wants next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Control {
    /// Go on.
    Continue,
    /// Enough has been seen: the run ends with the time step in which this is said.
    Finish,
}

/// Something that sees a run while it goes on.
pub trait Watch {
    /// A row was recorded in topic `topic_index` of [`Bench::layout`]. Times never go back; `values`
    /// are as recorded, in the order of the topic's fields.
    fn row(&mut self, topic_index: usize, time_secs: f64, values: &[f64]) -> Control;

    /// What is to be told where bodies are, if anything is.
    fn viewer(&mut self) -> Option<&mut dyn Viewer> {
        None
    }
}

/// Looks at nothing, so the run goes on to its own end.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unwatched;

impl Watch for Unwatched {
    fn row(&mut self, _: usize, _: f64, _: &[f64]) -> Control {
        Control::Continue
    }
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// By itself.
    Over,
    /// The longest time that the bench allows has passed.
    Longest,
    /// The [`Watch`] had seen enough.
    Watched,
    /// A controller failed; see [`Recorded::failure`].
    Failed,
}

/// What can end a run by failing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// A controller.
    Controller,
    /// What simulates, where that is a program of others.
    Simulator,
}

/// What failed in a run: an outcome of the run, not an error of the bench.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// What it was.
    pub part: Part,
    /// Whether it ran on and gave no answer.
    pub is_hung: bool,
    /// What it said, or what is said of it.
    pub words: String,
    /// Whether it failed before its first tick, when it was started or set up.
    pub in_setup: bool,
}

impl Failure {
    /// A controller that failed.
    #[must_use]
    pub fn of_controller(error: &ControllerError, in_setup: bool) -> Self {
        Self {
            part: Part::Controller,
            is_hung: matches!(error, ControllerError::Silent { .. }),
            words: error.to_string(),
            in_setup,
        }
    }

    /// The same word for the same failure, whatever its words are: those can depend on how fast a
    /// dying process was looked at.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match (self.part, self.is_hung) {
            (Part::Controller, false) => "controller-failed",
            (Part::Controller, true) => "controller-hung",
            (Part::Simulator, false) => "simulator-failed",
            (Part::Simulator, true) => "simulator-hung",
        }
    }
}

/// What a run gives. Its trace is complete only if it ended by itself. Of a run whose controller
/// failed it is what was recorded up to there, and its metadata have `failed`.
#[derive(Debug, Clone, PartialEq)]
pub struct Recorded {
    /// Everything recorded.
    pub trace: Trace,
    /// Time steps taken.
    pub steps: u64,
    /// Simulated time.
    pub sim_secs: f64,
    /// Why it ended.
    pub end: End,
    /// What failed, if that ended it, or came with its end.
    pub failure: Option<Failure>,
}

/// A grasped thing that moved in the fingers that held it: a doubt of the simulation, or of the grip. A recording has them in
/// its metadata, if there are any.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Creep {
    /// The thing.
    pub object: String,
    /// Who held it.
    pub holder: String,
    /// How far it moved along the fingers.
    pub moved_m: f64,
    /// Within which time.
    pub over_secs: f64,
    /// What the fingers bore along their surfaces, over what they pressed.
    pub load_over_grip: f64,
    /// That over what friction bears, 0 to 1.
    pub friction_used: f64,
    /// Whether friction was used up, so that it would slide in reality, too.
    pub slid: bool,
    /// What to do about it, with the setting.
    pub remedy: String,
}

impl Creep {
    /// The key of a recording's metadata that has them, as JSON.
    pub const KEY: &str = "crept";

    /// Those of a recording; none of one that says nothing of them.
    #[must_use]
    pub fn of(trace: &Trace) -> Vec<Self> {
        let text = trace.metadata.get(Self::KEY);
        text.and_then(|text| serde_json::from_str(text).ok())
            .unwrap_or_default()
    }
}

impl std::fmt::Display for Creep {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let verb = if self.slid { "slid" } else { "crept" };
        write!(
            f,
            "`{}` {verb} {:.1} mm in the fingers of `{}` in {:.1} s, with {:.0} % of friction used",
            self.object,
            1e3 * self.moved_m,
            self.holder,
            self.over_secs,
            100.0 * self.friction_used.min(1.0)
        )
    }
}

/// A trajectory that could not be gone along from where its group was when it was begun. A recording has them in its metadata, if
/// there are any.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OutOfReach {
    /// The trajectory.
    pub trajectory: String,
    /// The waypoint, counted from 0.
    pub waypoint: usize,
    /// When it was found.
    pub secs: f64,
    /// What is left to the best pose that was found.
    pub distance_left_m: f64,
    /// The same of its orientation.
    pub angle_left_rad: f64,
}

impl OutOfReach {
    /// The key of a recording's metadata that has them, as JSON.
    pub const KEY: &str = "out_of_reach";

    /// One, with the distance and the angle that are left.
    #[must_use]
    pub fn new(trajectory: &str, waypoint: usize, secs: f64, left: [f64; 2]) -> Self {
        let [distance_left_m, angle_left_rad] = left;
        Self {
            trajectory: trajectory.to_owned(),
            waypoint,
            secs,
            distance_left_m,
            angle_left_rad,
        }
    }

    /// Those of a recording; none of one that says nothing of them.
    #[must_use]
    pub fn of(trace: &Trace) -> Vec<Self> {
        let text = trace.metadata.get(Self::KEY);
        text.and_then(|text| serde_json::from_str(text).ok())
            .unwrap_or_default()
    }

    /// Writes it down behind those that the recording has.
    pub(crate) fn add_to(self, trace: &mut Trace) {
        let mut all = Self::of(trace);
        all.push(self);
        if let Ok(text) = serde_json::to_string(&all) {
            trace.metadata.insert(Self::KEY.to_owned(), text);
        }
    }
}

impl std::fmt::Display for OutOfReach {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "at {:.2} s waypoint {} of `{}` was out of reach by {:.1} mm and {:.2} degrees",
            self.secs,
            self.waypoint,
            self.trajectory,
            1e3 * self.distance_left_m,
            self.angle_left_rad.to_degrees()
        )
    }
}

/// A number that a run draws once from its seed, which a setting of its key would fix.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawn {
    /// The setting's key.
    pub key: String,
    /// The number of this run.
    pub value: f64,
    /// The middle of what it is drawn from.
    pub middle: f64,
}

/// Anything that turns a stimulus and a seed into a recording.
pub trait Bench: Send + Sync {
    /// The topics and fields that every run records, without rows: what to bind monitors to.
    ///
    /// # Errors
    /// [`SimError::Trace`] when the bench's data give topics or fields that cannot be.
    fn layout(&self) -> Result<Trace, SimError>;

    /// Runs once.
    ///
    /// # Errors
    /// [`SimError::Stimulus`] for a stimulus that this bench does not understand,
    /// [`SimError::Cancelled`], and whatever keeps the simulation from going on. A controller that
    /// fails is no error: that is what the run shows.
    fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        watch: &mut dyn Watch,
        cancel: &Cancel,
    ) -> Result<Recorded, SimError>;
}
