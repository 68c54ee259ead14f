//! What is asked of recordings.

use recording::{OpenOptions, TimeSource};
use std::path::PathBuf;
use temporal::formula::{Ending, TimeModel};

/// What is judged, in which recordings, and how these are read. [`MonitorRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct MonitorRequest {
    /// What is judged.
    pub monitored: Monitored,
    /// The recordings, or folders of them, in their order.
    pub recordings: Vec<PathBuf>,
    /// A topic map, which says where recordings have the signals; by default the study's.
    pub map: Option<PathBuf>,
    /// Which time of a message counts; by default the one of the topic map.
    pub time: Option<TimeSource>,
    /// How recordings are opened.
    pub opening: OpenOptions,
    /// Judges recordings that are not complete as far as they go.
    pub partial: bool,
    /// The folder to which verdicts and robustness over time are written, one MCAP file for each recording.
    pub verdicts: Option<PathBuf>,
}

/// What is judged.
#[derive(Clone, Debug)]
pub enum Monitored {
    /// The requirements and failure modes of a study.
    Study {
        /// Its folder.
        folder: PathBuf,
        /// Only the requirements and failure modes with these identifiers; all if there are none.
        only: Vec<String>,
    },
    /// Formulas over signals, without a study.
    Formulas {
        /// Their texts.
        texts: Vec<String>,
        /// What is said of times behind the end of a recording.
        ending: Ending,
        /// Whether operators speak of the samples or of all times.
        time: TimeModel,
        /// By how many seconds the signals of a formula may begin later than the first of them for judging to begin when all are
        /// there.
        start_within_secs: f64,
    },
}

impl Monitored {
    /// All requirements and failure modes of the study in a folder.
    pub fn study(folder: impl Into<PathBuf>) -> Self {
        Self::Study {
            folder: folder.into(),
            only: Vec::new(),
        }
    }

    /// One formula over the samples of a recording that is all there is, if it is as long as the formula asks for.
    pub fn formula(text: impl Into<String>) -> Self {
        Self::Formulas {
            texts: vec![text.into()],
            ending: Ending::LongEnough,
            time: TimeModel::Discrete,
            start_within_secs: study::START_WITHIN_SECS,
        }
    }
}

impl MonitorRequest {
    /// No recording yet; those that are added have to be complete, and nothing is written.
    pub fn new(monitored: Monitored) -> Self {
        Self {
            monitored,
            recordings: Vec::new(),
            map: None,
            time: None,
            opening: OpenOptions::default(),
            partial: false,
            verdicts: None,
        }
    }

    /// With a further recording, or a folder of them.
    #[must_use]
    pub fn recording(mut self, path: impl Into<PathBuf>) -> Self {
        self.recordings.push(path.into());
        self
    }
}
