//! Controllers: a robot's code, joined to a bench by named values and nothing else.
//!
//! A controller knows neither simulator nor file. Once an episode it is told what there is
//! ([`Setup`]: sensors, actuators, units, period, seed), then it is asked at a fixed rate: what has
//! arrived since the last time ([`Inputs`]) against what it wants ([`Outputs`]). Between two ticks
//! simulated time stands still, so a controller may take as long as it likes, and the same inputs
//! have to give the same outputs.
//!
//! | a controller is | how |
//! |---|---|
//! | Rust in this process | implement [`Controller`] |
//! | a process in any language | [`RemoteController`] over a [`LockStep`] transport; see [`protocol`] |
//! | a node of ROS 2 | joined by the caller, who publishes its sensors and `/clock` and implements [`Controller`] |
//!
//! ```
//! use testbench::controller::{Controller, ControllerError, Description, Inputs, Outputs, Setup};
//!
//! /// Drives on until the range ahead is short.
//! struct Careful(Description);
//! impl Controller for Careful {
//!     fn describe(&self) -> &Description { &self.0 }
//!     fn set_up(&mut self, _: &Setup) -> Result<(), ControllerError> { Ok(()) }
//!     fn tick(&mut self, inputs: &Inputs) -> Result<Outputs, ControllerError> {
//!         let ahead_m = inputs.number("range", "distance").unwrap_or(0.0);
//!         let speed_m_s = if ahead_m > 1.0 { 0.5 } else { 0.0 };
//!         Ok(Outputs::default().command("drive", "speed", speed_m_s))
//!     }
//! }
//!
//! let mut controller = Careful(Description::new("careful", "1"));
//! controller.set_up(&Setup::default())?;
//! let mut inputs = Inputs::at(0.05);
//! inputs.insert("range", 0.04, [("distance", vec![2.5])]);
//! let outputs = controller.tick(&inputs)?;
//! assert_eq!(outputs.commands["drive"]["speed"], 0.5);
//! # Ok::<(), ControllerError>(())
//! ```

mod remote;
mod wire;

#[doc = include_str!("protocol.md")]
pub mod protocol {}

use std::collections::BTreeMap;
use std::fmt;

pub use remote::{LockStep, Lost, RemoteController};
pub use trace::Field;

/// A robot's code.
pub trait Controller: Send {
    /// Who it is, what it sends, hears and reports. The same at any time.
    fn describe(&self) -> &Description;

    /// Begins an episode. Everything of an earlier one is to be forgotten.
    ///
    /// # Errors
    /// When it lacks a sensor or an actuator, or cannot run.
    fn set_up(&mut self, setup: &Setup) -> Result<(), ControllerError>;

    /// One tick: from what has arrived to what is wanted.
    ///
    /// # Errors
    /// When the controller failed; that ends the episode, which is recorded up to there.
    fn tick(&mut self, inputs: &Inputs) -> Result<Outputs, ControllerError>;

    /// The episode is over.
    ///
    /// # Errors
    /// When the controller could not be told.
    fn end(&mut self) -> Result<(), ControllerError> {
        Ok(())
    }
}

/// What a controller says of itself, before any episode.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Description {
    /// Its name.
    pub name: String,
    /// Its version; it is written into each recording.
    pub version: String,
    /// Messages that it may send.
    pub sends: Vec<String>,
    /// Messages that it understands.
    pub receives: Vec<String>,
    /// What it reports of its inside for the recording (a state, a decision).
    pub reports: Vec<Field>,
}

impl Description {
    /// A controller that sends, hears and reports nothing.
    #[must_use]
    pub fn new(name: &str, version: &str) -> Self {
        Self {
            name: name.to_owned(),
            version: version.to_owned(),
            ..Self::default()
        }
    }
}

/// What a bench offers a controller for an episode.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Setup {
    /// For the controller's own random numbers, if it has any.
    pub seed: u64,
    /// Simulated seconds from tick to tick.
    pub period_secs: f64,
    /// What readings there will be.
    pub sensors: Vec<Port>,
    /// What commands are taken.
    pub actuators: Vec<Port>,
    /// Numbers, texts and truth values given to the controller by the scene.
    pub settings: serde_json::Map<String, serde_json::Value>,
}

/// A sensor or an actuator as a controller sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct Port {
    /// Its name.
    pub name: String,
    /// Its kind, for example `lidar` or `differential_drive`.
    pub kind: String,
    /// Its values.
    pub fields: Vec<PortField>,
    /// Facts that stay the same, for example the angle of the first ray, with units in the names.
    pub facts: BTreeMap<String, f64>,
}

/// One value, or one list of values, of a sensor or an actuator.
#[derive(Debug, Clone, PartialEq)]
pub struct PortField {
    /// Its name.
    pub name: String,
    /// Its unit, as in traces: `m`, `rad/s`; `1` for truth values and numbers without one.
    pub unit: String,
    /// How many numbers it has.
    pub length: usize,
}

/// What a sensor said.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Measurement {
    /// When it measured, in simulated seconds; it may arrive later.
    pub time_secs: f64,
    /// The numbers of each field; NaN for what it could not measure.
    pub values: BTreeMap<String, Vec<f64>>,
}

/// A message, for example a call of a person.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// What it says: one of the names that the controller receives.
    pub name: String,
    /// When it was sent, in simulated seconds.
    pub time_secs: f64,
}

/// What has arrived since the last tick.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Inputs {
    /// The bench's clock in simulated seconds.
    pub time_secs: f64,
    /// The latest measurement of each sensor from which one has arrived since the last tick.
    pub measurements: BTreeMap<String, Measurement>,
    /// Messages in the order of their arrival.
    pub messages: Vec<Message>,
}

impl Inputs {
    /// Nothing has arrived by `time_secs`.
    #[must_use]
    pub fn at(time_secs: f64) -> Self {
        Self {
            time_secs,
            ..Self::default()
        }
    }

    /// Adds a measurement.
    pub fn insert<'a>(
        &mut self,
        sensor: &str,
        time_secs: f64,
        values: impl IntoIterator<Item = (&'a str, Vec<f64>)>,
    ) {
        let values = values
            .into_iter()
            .map(|(field, numbers)| (field.to_owned(), numbers))
            .collect();
        let measurement = Measurement { time_secs, values };
        self.measurements.insert(sensor.to_owned(), measurement);
    }

    /// The first number of a sensor's field, if a measurement has arrived.
    #[must_use]
    pub fn number(&self, sensor: &str, field: &str) -> Option<f64> {
        let numbers = self.measurements.get(sensor)?.values.get(field)?;
        numbers.first().copied()
    }
}

/// What a controller wants. A command stays in force until another one replaces it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outputs {
    /// For each actuator the fields that change.
    pub commands: BTreeMap<String, BTreeMap<String, f64>>,
    /// Messages sent.
    pub messages: Vec<String>,
    /// What it reports of its inside; what is not named stays. For an enumeration the index.
    pub reports: BTreeMap<String, f64>,
    /// The controller has done its work, well or not.
    pub finished: bool,
}

impl Outputs {
    /// The same with a command.
    #[must_use]
    pub fn command(mut self, actuator: &str, field: &str, value: f64) -> Self {
        let fields = self.commands.entry(actuator.to_owned()).or_default();
        fields.insert(field.to_owned(), value);
        self
    }
}

/// Why a controller gave no outputs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ControllerError {
    /// It could not be reached, ended or took too long.
    Transport {
        /// What the transport says.
        reason: String,
    },
    /// It runs, but gives no answer.
    Silent {
        /// What was waited for, how long, and what to look at.
        reason: String,
    },
    /// It answered something that the protocol does not allow.
    Protocol {
        /// What was asked.
        asked: &'static str,
        /// What is wrong with the answer.
        problem: String,
    },
    /// It reported an error itself.
    Failed {
        /// In its own words.
        message: String,
    },
    /// It commands, sends or reports something that does not exist, or no number.
    Output {
        /// What, with its name.
        what: String,
        /// Names that exist.
        known: Vec<String>,
    },
}

impl fmt::Display for ControllerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Transport { reason } => write!(f, "the controller cannot be reached: {reason}"),
            Self::Silent { reason } => write!(f, "the controller is silent: {reason}"),
            Self::Protocol { asked, problem } => write!(
                f,
                "the controller answered `{asked}` against the protocol: {problem}; see the description of the protocol in the crate testbench"
            ),
            Self::Failed { message } => write!(f, "the controller failed: {message}"),
            Self::Output { what, known } if known.is_empty() => {
                write!(
                    f,
                    "the controller gives {what}, which the scene does not have"
                )
            }
            Self::Output { what, known } => write!(
                f,
                "the controller gives {what}; there is {}",
                known.join(", ")
            ),
        }
    }
}

impl std::error::Error for ControllerError {}
