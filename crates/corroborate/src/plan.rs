//! What a run would do: which evidence is fresh, which is stale and why.
//!
//! # Definition
//! Evidence is *fresh* if the hash of all that it depends on (its files, the study's settings, the counts that its
//! constants were set to, the build of the engine) is the one that it was kept with, and it is as it was kept. A run
//! produces all that is not. Why evidence is stale is told as far as what was kept says it: the files that were hashed
//! are named; of everything else only one hash was kept.
//!
//! # Cost
//! What is kept is read and hashed; nothing is produced, compared or written.

use crate::corroboration::Piece;
use crate::results::read_result;
use crate::run::{COMPARISON, Opened, Ready, RunRequest, evidence_file, loaded};
use crate::technique::Produced;
use diagnostic::Problem;
use evidence::{StudyResult, Technique};
use host::Host;
use host::store::Stored;
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;
use study::Entry;

/// What a run would do.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct RunPlan {
    /// The entries of the ledger that were asked for, in its order.
    pub evidence: Vec<PlannedEvidence>,
    /// Comparing and concluding; `None` if only some evidence was asked for, so that nothing is compared.
    pub comparison: Option<Freshness>,
}

/// What a run would do for one entry of the ledger.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct PlannedEvidence {
    /// Its identifier.
    pub id: String,
    /// Its title.
    pub title: String,
    /// Its technique.
    pub technique: Technique,
    /// Whether it is fresh.
    pub freshness: Freshness,
    /// Of a simulation that is stale: episodes that were run and judged before an interruption, and are not run again
    /// if their recordings are there.
    pub kept_episodes: Option<u64>,
    /// Of evidence that is not fresh: how long it took when it was last produced, in seconds, which is an estimate of what it
    /// costs now; `None` if it was not produced here before, or what was kept is damaged.
    pub last_took_secs: Option<f64>,
}

/// Whether something has to be produced.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(tag = "is", rename_all = "kebab-case")]
pub enum Freshness {
    /// What was kept is taken.
    Fresh,
    /// No run has kept it.
    NotProduced,
    /// What was kept cannot be read, or was changed.
    Damaged,
    /// Files that it rests on were others when it was produced, or are new to it.
    FilesChanged {
        /// Their paths in the study.
        files: Vec<String>,
    },
    /// It was produced with other settings, from other counts or by another build; which of these is not kept.
    OtherInputs,
    /// It depends on evidence that has to be produced first; whether it is fresh then is known only then.
    Awaits {
        /// The identifiers of that evidence.
        evidence: Vec<String>,
    },
    /// It cannot be produced here.
    CannotProduce {
        /// Why.
        reason: String,
    },
}

impl RunPlan {
    /// Whether a run would take everything as it was kept.
    pub fn is_fresh(&self) -> bool {
        let evidence = self.evidence.iter().map(|planned| &planned.freshness);
        let mut all = evidence.chain(&self.comparison);
        all.all(|it| *it == Freshness::Fresh)
    }

    /// How long all that a run would produce took when it was last produced, in seconds, and of how many pieces that is not
    /// known.
    pub fn last_took_secs(&self) -> (f64, usize) {
        let is_produced = |it: &&PlannedEvidence| match it.freshness {
            Freshness::Fresh | Freshness::CannotProduce { .. } => false,
            Freshness::NotProduced
            | Freshness::Damaged
            | Freshness::FilesChanged { .. }
            | Freshness::OtherInputs
            | Freshness::Awaits { .. } => true,
        };
        let produced: Vec<&PlannedEvidence> = self.evidence.iter().filter(is_produced).collect();
        let known = produced.iter().filter_map(|it| it.last_took_secs);
        let unknown = produced.len() - known.clone().count();
        (known.sum(), unknown)
    }
}

/// What [`run()`](crate::run()) would do with this request. The study is read, compiled and checked as for a run, so that a
/// plan finds every mistake that can be seen without producing anything.
///
/// # Errors
/// What the study's files say wrong, each with its place.
pub fn plan(request: &RunRequest, host: &Host) -> Result<RunPlan, Problem> {
    let study = loaded(request, host)?;
    let folder = request.results();
    let planning = Planning {
        ready: &Ready::new(&study, &request.techniques, host)?,
        // Without it, or with another form of it, less is known of why evidence is stale.
        last: read_result(&request.study, &folder).ok(),
        folder: &folder,
    };
    planning.plan(&request.only)
}

/// What a plan is made of.
struct Planning<'p> {
    ready: &'p Ready<'p>,
    last: Option<StudyResult>,
    folder: &'p Path,
}

impl Planning<'_> {
    fn plan(&self, only: &[String]) -> Result<RunPlan, Problem> {
        let mut evidence: Vec<PlannedEvidence> = Vec::new();
        let mut fresh: Vec<Piece> = Vec::new();
        for (entry, prepared) in self.ready.entries() {
            if !only.is_empty() && !only.contains(&entry.id) {
                continue;
            }
            let stored = kept::<Produced>(&self.folder.join(evidence_file(&entry.id)));
            let took = stored.as_ref().ok().map(|it| it.content.cost.wall_secs);
            let freshness = self.freshness((entry, prepared), stored, &evidence, &mut fresh)?;
            let freshness = match prepared.work.not_allowed() {
                Some(problem) if freshness != Freshness::Fresh => Freshness::CannotProduce {
                    reason: problem.message().to_owned(),
                },
                _ => freshness,
            };
            evidence.push(PlannedEvidence {
                id: entry.id.clone(),
                title: entry.title.clone(),
                technique: entry.work.technique(),
                kept_episodes: match freshness {
                    Freshness::Fresh => None,
                    _ => prepared.work.kept_episodes(self.folder)?,
                },
                last_took_secs: match freshness {
                    Freshness::Fresh => None,
                    _ => took,
                },
                freshness,
            });
        }
        let comparison = only.is_empty().then(|| self.comparison(&evidence, &fresh));
        Ok(RunPlan {
            evidence,
            comparison,
        })
    }

    /// Whether an entry's evidence is fresh, by what was stored; if it is, it is added to the `fresh` ones.
    fn freshness(
        &self,
        (entry, prepared): (&Entry, &Opened<'_>),
        stored: Result<Stored<Produced>, Freshness>,
        before: &[PlannedEvidence],
        fresh: &mut Vec<Piece>,
    ) -> Result<Freshness, Problem> {
        if let Some(problem) = prepared.work.obstacle() {
            return Ok(Freshness::CannotProduce {
                reason: problem.message().to_owned(),
            });
        }
        let stored = match stored {
            Ok(stored) => stored,
            Err(stale) => return Ok(stale),
        };
        let awaited = awaited(entry, before);
        if !awaited.is_empty() {
            return Ok(Freshness::Awaits { evidence: awaited });
        }
        let counted = self.ready.counted(entry, prepared, fresh)?;
        let inputs = self.ready.inputs(entry, prepared, &counted)?;
        if stored.inputs != inputs {
            return Ok(match self.changed_files(entry, &stored.inputs) {
                files if files.is_empty() => Freshness::OtherInputs,
                files => Freshness::FilesChanged { files },
            });
        }
        let piece = self
            .ready
            .piece(entry, prepared, fresh, inputs, stored.content)?;
        fresh.push(piece);
        Ok(Freshness::Fresh)
    }

    /// The files of an entry that are not as they were when it was produced from these inputs, as far as the last result
    /// tells.
    fn changed_files(&self, entry: &Entry, inputs: &str) -> Vec<String> {
        let mut pieces = self.last.iter().flat_map(|result| &result.evidence);
        let Some(last) = pieces.find(|piece| piece.id == entry.id && piece.inputs == inputs) else {
            return Vec::new();
        };
        let now = self.ready.assets(entry);
        let changed = now.iter().filter(|asset| !last.assets.contains(asset));
        let is_gone = |path: &String| now.iter().all(|asset| asset.path != *path);
        let paths = last.assets.iter().map(|asset| &asset.path);
        let gone = paths.filter(|path| is_gone(path)).cloned();
        let mut files: Vec<String> = changed.map(|a| a.path.clone()).chain(gone).collect();
        files.sort();
        files.dedup();
        files
    }

    /// Whether what the evidence says together is fresh.
    fn comparison(&self, evidence: &[PlannedEvidence], fresh: &[Piece]) -> Freshness {
        let stale = evidence
            .iter()
            .filter(|planned| planned.freshness != Freshness::Fresh);
        let stale: Vec<String> = stale.map(|planned| planned.id.clone()).collect();
        if !stale.is_empty() {
            return Freshness::Awaits { evidence: stale };
        }
        match kept::<StudyResult>(&self.folder.join(COMPARISON)) {
            Ok(stored) if stored.inputs == self.ready.study_inputs(fresh) => Freshness::Fresh,
            Ok(_) => Freshness::OtherInputs,
            Err(stale) => stale,
        }
    }
}

/// What a file keeps, or why it cannot be taken.
fn kept<T: DeserializeOwned + Serialize>(path: &Path) -> Result<Stored<T>, Freshness> {
    let bytes = std::fs::read(path).map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => Freshness::NotProduced,
        _ => Freshness::Damaged,
    })?;
    let stored: Stored<T> = serde_json::from_slice(&bytes).map_err(|_| Freshness::Damaged)?;
    match stored.is_as_kept() {
        true => Ok(stored),
        false => Err(Freshness::Damaged),
    }
}

/// The stale evidence before an entry whose counts its model is computed with.
fn awaited(entry: &Entry, before: &[PlannedEvidence]) -> Vec<String> {
    // A step on the way is not compared, so the uncertainty of its counts is not asked for.
    if entry.intermediate {
        return Vec::new();
    }
    let constants = entry.calibrated.iter().filter(|it| it.constant.is_some());
    let mut sources: Vec<String> = constants.map(|it| it.calibration.from.clone()).collect();
    sources.sort();
    sources.dedup();
    let is_stale = |id: &String| {
        let mut all = before.iter();
        all.any(|planned| planned.id == *id && planned.freshness != Freshness::Fresh)
    };
    sources.retain(is_stale);
    sources
}
