//! What two physics engines make of the same episodes.

use super::determinism::Repeated;
use evidence::{EpisodeFailures, RunVerdict, Subject};
use schemars::JsonSchema;
use serde::Serialize;

/// What the same episodes show in two engines, or in one that repeats them.
#[derive(Debug, Serialize, JsonSchema)]
pub struct EnginesReport {
    /// Version of this form.
    pub format: String,
    /// The ledger's entry that was simulated.
    pub evidence: String,
    /// The engines with their versions: the first, the second.
    pub engines: Vec<String>,
    /// How many episodes were run in each.
    pub episodes: u64,
    /// How far the recordings lie apart, signal by signal, what matters first: those that differ, truth values and names
    /// before numbers, those with a tolerance before others, and then by how far they differ.
    pub signals: Vec<SignalReport>,
    /// The verdicts in both, those that differ first.
    pub verdicts: Vec<VerdictReport>,
    /// Episodes that the robot's program or the physics ended by failing, in each engine; those are
    /// compared up to there.
    pub failures: Vec<EngineFailures>,
    /// Hashes of repeated and continued episodes, if those were asked for.
    pub repeated: Vec<Repeated>,
    /// Whether in each episode the same failed in both engines, or nothing.
    #[serde(skip)]
    #[schemars(skip)]
    pub fail_alike: bool,
}

impl EnginesReport {
    /// Whether no verdict, failure or hash differs.
    pub fn is_same(&self) -> bool {
        let mut verdicts = self.verdicts.iter();
        let mut repeated = self.repeated.iter();
        self.fail_alike
            && verdicts.all(|verdict| verdict.differ.is_empty())
            && repeated.all(|repeated| repeated.same)
    }
}

/// What failed in one engine.
#[derive(Debug, Serialize, JsonSchema)]
pub struct EngineFailures {
    /// The engine with its version.
    pub engine: String,
    /// Each kind, with its share of the episodes.
    pub failures: Vec<EpisodeFailures>,
}

/// How far a signal lies apart over all episodes.
#[derive(Debug, Serialize, JsonSchema)]
pub struct SignalReport {
    /// `/topic.field`.
    pub signal: String,
    /// What its values are.
    pub kind: SignalKind,
    /// Its unit; empty for truth values and names.
    pub unit: String,
    /// Rows that both recordings have.
    pub rows: u64,
    /// Rows that one of them has.
    pub unmatched: u64,
    /// Root mean square of the differences; for truth values and names the
    /// share of rows that differ. Absent without rows.
    pub typical: Option<f64>,
    /// The largest difference.
    pub largest: f64,
    /// When that was.
    pub largest_at_secs: f64,
    /// Means in the first and the second engine. Absent without rows, of names, and of angles that lie on both sides of where
    /// they begin again.
    pub means: Option<[f64; 2]>,
    /// How far its numbers range in both. Absent of truth values and names, and without rows.
    pub span: Option<f64>,
    /// By how much it may differ, if that was said.
    pub tolerance: Option<f64>,
}

/// What a signal's values are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SignalKind {
    /// Truth values or names, which are equal or not.
    Event,
    /// Numbers.
    Number,
    /// Angles, which are compared the shorter way round within a turn.
    Angle,
}

impl SignalReport {
    /// Whether it is the same in both, as far as both have it.
    pub fn is_same(&self) -> bool {
        self.largest == 0.0
    }

    /// How far it differs: the largest difference as a multiple of the tolerance; without one the root mean square of the
    /// differences as a share of its range; of truth values and names the share of rows.
    pub fn relative(&self) -> f64 {
        match (self.kind, self.tolerance, self.span) {
            (SignalKind::Event, ..) => self.typical.unwrap_or(0.0),
            (_, Some(tolerance), _) => self.largest / tolerance,
            (_, None, Some(span)) if span > 0.0 => self.typical.unwrap_or(0.0) / span,
            (_, None, _) => 0.0,
        }
    }

    /// Its group in the order of what matters.
    pub(super) fn order(&self) -> u8 {
        match (self.is_same(), self.kind) {
            (false, SignalKind::Event) => 0,
            (false, SignalKind::Number | SignalKind::Angle) => 1,
            (true, _) => 2,
        }
    }
}

/// What the engines' recordings show of one requirement or failure mode.
#[derive(Debug, Serialize, JsonSchema)]
pub struct VerdictReport {
    /// Which.
    pub subject: Subject,
    /// The reading; absent for the main one.
    pub reading: Option<String>,
    /// Violations, or occurrences of a failure mode, in each engine.
    pub violated: [u64; 2],
    /// The episodes on which the engines' verdicts differ.
    pub differ: Vec<VerdictPair>,
}

/// An episode on which verdicts differ.
#[derive(Debug, Serialize, JsonSchema)]
pub struct VerdictPair {
    /// The episode's number.
    pub episode: u64,
    /// Its seed.
    pub seed: u64,
    /// The verdict in the first engine.
    pub first: RunVerdict,
    /// The verdict in the second.
    pub second: RunVerdict,
}
