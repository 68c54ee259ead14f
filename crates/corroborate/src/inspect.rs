//! What is in a recording, in a description of a robot, or in the recordings that a study's simulations would make.

mod description;
mod form;
mod study;

use crate::outcome::Outcome;
use diagnostic::Problem;
use host::Host;
use host::files::write_whole;
use recording::{InspectOptions, Inspection, OpenOptions};
use robot_model::Loaded;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};

pub use description::{DescriptionReport, collision_shapes};
pub(crate) use description::{is_description, load};
pub use study::{Quantity, Signal, SimulationSignals, StudySignals, Truth, TruthTopic};

/// What is looked into, and how.
#[derive(Clone, Debug)]
pub struct InspectRequest {
    /// A recording (a file, or a folder that rosbag2 recorded), a description (by its ending `urdf`, `xacro`, `sdf`, `world` or `xml`), or
    /// a study (a folder with a `study.toml`).
    pub file: PathBuf,
    /// How a recording is opened.
    pub opening: OpenOptions,
    /// A period this many times as long as the middle one is a gap of a recording.
    pub gap_factor: f64,
    /// Folders with the packages or models that a description names, besides those around it.
    pub packages: Vec<PathBuf>,
    /// Values of the arguments (`xacro:arg`) of a description in xacro, by name.
    pub arguments: robot_model::Arguments,
}

impl InspectRequest {
    /// A file as it is, with gaps of five periods.
    pub fn new(file: impl Into<PathBuf>) -> Self {
        Self {
            file: file.into(),
            opening: OpenOptions::default(),
            gap_factor: 5.0,
            packages: Vec::new(),
            arguments: robot_model::Arguments::new(),
        }
    }
}

/// What was found.
#[derive(Debug)]
pub enum Inspected {
    /// A recording's topics, frames and losses.
    Recording(Box<Inspection>),
    /// A description's tree, with what of it is not carried over.
    Description(Box<Loaded>),
    /// The signals that a study's simulations have.
    Study(Box<StudySignals>),
}

impl Inspected {
    /// `DataLost` where something of a recording is lost.
    pub fn outcome(&self) -> Outcome {
        match self {
            Self::Recording(found) => {
                let misfits = found.topics.iter().any(|topic| topic.misfits > 0);
                let lost = !found.complete || found.error.is_some() || !found.losses.is_empty();
                match lost || misfits {
                    true => Outcome::DataLost,
                    false => Outcome::Holds,
                }
            }
            Self::Description(_) | Self::Study(_) => Outcome::Holds,
        }
    }
}

/// What is in a recording.
#[derive(Debug, Serialize, JsonSchema)]
pub struct InspectReport {
    /// Version of this form.
    pub format: String,
    /// The recording.
    pub file: String,
    /// Where the draft of the topic map was written.
    pub draft_map: Option<String>,
    /// What is in it.
    #[schemars(with = "form::InspectionForm")]
    pub recording: Inspection,
}

/// Looks into a recording, a description, or a study. Without the physics library scenes are looked into in the engine that is
/// built in.
///
/// # Errors
/// `bad-recording` and `bad-description`, with the place in a description's text; whatever is wrong in a study's files.
pub fn inspect(request: &InspectRequest, host: &Host) -> Result<Inspected, Problem> {
    if request.file.join("study.toml").is_file() {
        let found = study::signals_of(&request.file, host)?;
        return Ok(Inspected::Study(Box::new(found)));
    }
    if description::is_description(&request.file) {
        let loaded = description::load(&request.file, &request.packages, &request.arguments)?;
        return Ok(Inspected::Description(Box::new(loaded)));
    }
    let options = InspectOptions {
        gap_factor: request.gap_factor,
    };
    recording::inspect(&request.file, &request.opening, &options)
        .map(|found| Inspected::Recording(Box::new(found)))
        .map_err(|error| Problem::new("bad-recording", error.to_string()))
}

/// Writes the draft of a topic map, but never over a map that somebody has worked on.
///
/// # Errors
/// `already-there`, and what keeps a file from being written.
pub fn write_draft(path: &Path, found: &Inspection) -> Result<(), Problem> {
    if path.exists() {
        let message = format!(
            "{} is there already, and a draft would replace it",
            path.display()
        );
        return Err(Problem::new("already-there", message).remedy("name a new file"));
    }
    write_whole(path, found.draft_map().as_bytes())
}
