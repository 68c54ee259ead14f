//! What episodes show, by the schema `simulate`.

use evidence::{Alone, DescriptionGap, FailureKind, Subject};
use schemars::JsonSchema;
use serde::Serialize;

/// What episodes show.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct SimulateReport {
    /// Version of this form.
    pub format: String,
    /// The ledger's entry that was simulated.
    pub evidence: String,
    /// The simulator with its version.
    pub engine: String,
    /// How many episodes there are, those of earlier calls included.
    pub episodes: u64,
    /// The recordings that are kept, with the seed of each.
    pub recordings: Vec<RecordingReport>,
    /// What the episodes show of each requirement and failure mode. Absent for
    /// recordings in another form, which are not judged.
    pub estimates: Vec<EstimateReport>,
    /// What they show of each requirement that has a threshold, as `run` judges one piece of evidence;
    /// the exit code follows from these and from the stopping rule.
    pub verdicts: Vec<Alone>,
    /// Episodes that the robot's program or the simulator ended by failing; those are judged up to
    /// there.
    pub failures: Vec<FailureReport>,
    /// What of robots' and things' descriptions is not simulated as it is described.
    pub description_gaps: Vec<DescriptionGap>,
    /// What came of the stopping rule, if there was one.
    pub until: Option<String>,
    /// The table of all episodes, in Parquet.
    pub table: Option<String>,
}

/// One recorded episode.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct RecordingReport {
    /// The file.
    pub file: String,
    /// The episode's seed.
    pub seed: u64,
}

/// The rate at which a requirement was kept, or a failure mode occurred.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct EstimateReport {
    /// Which requirement or failure mode.
    pub subject: Subject,
    /// Episodes in which it was kept, or occurred.
    pub count: u64,
    /// Episodes that decide it.
    pub trials: u64,
    /// Episodes that reached no verdict. The interval counts them against and for.
    pub undecided: u64,
    /// The lower end of the interval at the study's level. It is of a
    /// confidence sequence, which holds however often one looks.
    pub low: f64,
    /// The upper end.
    pub high: f64,
}

/// How often one kind of failure ended an episode.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FailureReport {
    /// What failed.
    pub kind: FailureKind,
    /// Episodes that it ended.
    pub count: u64,
    /// All episodes.
    pub trials: u64,
    /// The lower end of the interval, as of estimates.
    pub low: f64,
    /// The upper end.
    pub high: f64,
    /// The number of the first of them.
    pub first_episode: u64,
    /// That episode's seed, as a text: readers round numbers beyond 2^53.
    pub seed: String,
    /// The file with what the program said in it.
    pub said: String,
}
