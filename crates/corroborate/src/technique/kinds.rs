//! What a technique is to whoever runs a study: one trait, implemented in one file for each technique.
//!
//! A run, a plan and a verification know techniques by [`Technique`] alone. Its methods have no defaults, so that what a
//! technique has to say of itself cannot be forgotten; what it depends on it reads through [`Files`], so that it cannot be
//! forgotten either. [`technique_of`] is the only place that tells kinds of work apart.
//!
//! A technique that is not built in is registered with [`Techniques::with`] and named by `producer` in a ledger:
//!
//! ```toml
//! [[evidence]]
//! id = "E1"
//! title = "A coin"
//! technique = "experiment"        # as whose evidence its findings count
//! producer = "coin"
//! with = { tosses = "coin.txt" }  # what it is told
//! ```

mod episodes;
mod fault_tree;
mod model_checking;
mod recordings;
mod tables;

use super::Produced;
use super::counted::CountedConstant;
use super::files::Files;
use crate::corroboration::Piece;
use crate::technique::campaign::{Sampled, Until};
use crate::verify::{Audit, same_values};
use diagnostic::{Problem, did_you_mean};
use episodes::Episodes;
pub(crate) use fault_tree::{TreeChange, tree_values};
use host::Host;
use host::store::{Inputs, Store};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;
use study::{Entry, Simulated, Study, Work};

/// An entry of a study's ledger, and for whom it is looked at.
#[derive(Clone, Copy)]
pub struct Asked<'a> {
    /// The study.
    pub study: &'a Study,
    /// The entry.
    pub entry: &'a Entry,
    /// Whoever runs the study.
    pub host: &'a Host,
}

/// How evidence is produced, and derived again.
pub trait Technique {
    /// Reads, compiles and checks all that an entry needs, before anything runs. What findings depend on is read through
    /// `files`.
    ///
    /// # Errors
    /// What the study's files say wrong, each with its place.
    fn prepare<'a>(
        &self,
        asked: Asked<'a>,
        files: &Files<'_>,
    ) -> Result<Box<dyn Prepared + 'a>, Problem>;

    /// Whether `verify --deep` computes all its values again, so that nothing else has to be checked of them.
    fn is_computed_again_when_deep(&self) -> bool;

    /// Holds what was kept against what gives it: derives it again where that is quick, or else says that it was not.
    ///
    /// # Errors
    /// What the study's files say wrong. What does not hold is no error, but a fault of the audit.
    fn verify(&self, asked: Asked<'_>, kept: &Kept<'_>, audit: &mut Audit) -> Result<(), Problem>;
}

/// An entry whose files were read, ready to be produced.
pub trait Prepared {
    /// Adds what findings depend on beside what is added already: the files that were read, all keys of the entry's work,
    /// the study's seed and level, and of a technique that is not built in the texts of requirements and vocabulary. Left are
    /// constants with uncertain counts, and of a built-in technique the parts of these texts that it uses.
    ///
    /// # Errors
    /// What cannot be read.
    fn settings(&self, counted: &[CountedConstant], inputs: &mut Inputs) -> Result<(), Problem>;

    /// The number of its assets with this name, if it has one: what the ledger may declare to be set to counts.
    fn constant(&self, name: &str) -> Option<f64>;

    /// Which propositions of the study it can express, if it has to express them itself.
    fn propositions(&self) -> Option<Propositions<'_>>;

    /// Why it cannot be produced here, if so; said when its turn comes, so that all else still runs.
    fn obstacle(&self) -> Option<&Problem>;

    /// Why it may not be produced here, if the user has not allowed the programs that would run for it. What is fresh needs none.
    fn not_allowed(&self) -> Option<&Problem>;

    /// What is found.
    ///
    /// # Errors
    /// Why it could not be produced; `interrupted` if the host was asked to stop.
    fn produce(&self, working: &Working<'_>) -> Result<Produced, Problem>;

    /// How many episodes an interrupted run has left in this folder of results; `None` of what has no episodes.
    ///
    /// # Errors
    /// What cannot be read.
    fn kept_episodes(&self, results: &Path) -> Result<Option<u64>, Problem>;
}

/// Which propositions of a study can be expressed.
#[derive(Clone, Copy, Debug)]
pub struct Propositions<'p> {
    /// Those that can.
    pub expressed: &'p BTreeSet<&'p str>,
    /// Those that cannot, with what is missing.
    pub not_expressed: &'p BTreeMap<&'p str, String>,
}

/// What evidence is produced with.
pub struct Working<'w> {
    /// The constants whose counts are uncertain.
    pub counted: &'w [CountedConstant],
    /// Where results are kept.
    pub store: &'w Store,
    /// The hash of all that the findings depend on.
    pub inputs: &'w str,
    /// When episodes end before the last.
    pub until: Option<&'w Until>,
}

/// What was kept for an entry.
pub struct Kept<'k> {
    /// The file.
    pub path: &'k Path,
    /// Its content.
    pub produced: &'k Produced,
    /// The folder of results.
    pub results: &'k Path,
    /// The evidence before it.
    pub before: &'k [Piece],
    /// Whether what takes as long as at first is derived again, too.
    pub deep: bool,
    /// Which episodes are run again then.
    pub sampled: Sampled,
}

impl Kept<'_> {
    /// Holds all that was kept but times against what was found again; `what` says what holds then.
    ///
    /// # Errors
    /// What cannot be serialized.
    pub fn is(&self, mut again: Produced, what: &str, audit: &mut Audit) -> Result<(), Problem> {
        // Times differ from run to run.
        again.cost = self.produced.cost.clone();
        let values = same_values(self.path, "/content", &again, self.produced, audit)?;
        audit.checked(values, what);
        Ok(())
    }
}

/// Techniques that are not built in, by the names by which ledgers know them.
#[derive(Clone, Default)]
pub struct Techniques(BTreeMap<String, Arc<dyn Technique + Send + Sync>>);

impl Techniques {
    /// With one more; one that has the same name is replaced.
    #[must_use]
    pub fn with(
        mut self,
        name: impl Into<String>,
        technique: impl Technique + Send + Sync + 'static,
    ) -> Self {
        self.0.insert(name.into(), Arc::new(technique));
        self
    }
}

impl fmt::Debug for Techniques {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_set().entries(self.0.keys()).finish()
    }
}

/// The technique of an entry.
///
/// # Errors
/// `unknown-technique` if it is not built in and nobody brought it.
pub(crate) fn technique_of<'t>(
    study: &Study,
    entry: &'t Entry,
    others: &'t Techniques,
) -> Result<Box<dyn Technique + 't>, Problem> {
    Ok(match &entry.work {
        Work::Check { model, methods } => {
            Box::new(model_checking::ModelChecking { model, methods })
        }
        Work::FaultTree {
            tree,
            mission_time,
            events,
            is_triggered,
        } => Box::new(fault_tree::FaultTrees {
            tree,
            mission_time: *mission_time,
            events,
            is_triggered: *is_triggered,
        }),
        Work::Simulate {
            scenario,
            parameters,
            engine,
            episodes,
        } => Box::new(Episodes {
            of: Simulated::Handover {
                scenario,
                parameters,
                engine: *engine,
            },
            count: *episodes,
        }),
        Work::SimulateScene {
            scene,
            test,
            engine,
            episodes,
        } => Box::new(Episodes {
            of: Simulated::Scene {
                scene,
                test: test.as_deref(),
                engine: *engine,
            },
            count: *episodes,
        }),
        Work::Command {
            technique: _,
            command,
            episodes,
        } => Box::new(Episodes {
            of: Simulated::Command(command),
            count: *episodes,
        }),
        Work::Read {
            technique,
            cohort,
            requirements,
            failure_modes,
            one_for_all,
            junit,
            episodes,
            cluster,
            tests,
        } => Box::new(tables::ReadTables {
            technique: *technique,
            files: study::TableFiles {
                cohort: cohort.as_deref(),
                requirements: requirements.as_deref(),
                failure_modes: failure_modes.as_deref(),
                one_for_all: one_for_all.as_deref(),
                junit: junit.as_deref(),
                episodes: episodes.as_deref().zip(cluster.as_deref()),
                tests,
            },
        }),
        Work::Judge {
            technique: _,
            recordings,
            repeated,
        } => Box::new(recordings::JudgeRecordings {
            files: study::RecordingFiles {
                folder: recordings,
                repeated: repeated.as_deref(),
            },
        }),
        Work::Other {
            technique: _,
            producer,
            span,
            with: _,
        } => match others.0.get(producer) {
            Some(technique) => Box::new(Brought(technique.as_ref())),
            None => return Err(unknown(study, (producer, span), others)),
        },
    })
}

/// A technique that is not built in.
struct Brought<'t>(&'t (dyn Technique + Send + Sync));

impl Technique for Brought<'_> {
    fn prepare<'a>(
        &self,
        asked: Asked<'a>,
        files: &Files<'_>,
    ) -> Result<Box<dyn Prepared + 'a>, Problem> {
        self.0.prepare(asked, files)
    }

    fn is_computed_again_when_deep(&self) -> bool {
        self.0.is_computed_again_when_deep()
    }

    fn verify(&self, asked: Asked<'_>, kept: &Kept<'_>, audit: &mut Audit) -> Result<(), Problem> {
        self.0.verify(asked, kept, audit)
    }
}

fn unknown(study: &Study, (producer, span): (&str, &Range<usize>), others: &Techniques) -> Problem {
    let message = format!("unknown technique `{producer}`");
    let problem = Problem::new("unknown-technique", message).at(&study.ledger_source, span.clone());
    match did_you_mean(producer, others.0.keys().map(String::as_str)) {
        Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
        None => problem.remedy(
            "run the study by the program that has this technique, or leave `producer` out",
        ),
    }
}
