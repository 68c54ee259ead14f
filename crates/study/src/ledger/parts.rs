//! What a piece of work has that others build on.
//!
//! Diagnosis, refinement, replays and searches ask for a part (a model, tables, recordings, what is simulated) and never
//! for the kind of work, so that new work is one more row of [`Work::parts`], in which no field can be left out.

use super::{CommandText, PhysicsEngine, Work};
use evidence::Technique;
use std::collections::BTreeMap;
use std::path::Path;

/// What a piece of work has.
#[derive(Clone, Debug)]
pub struct Parts<'w> {
    /// The technique as whose evidence its findings count.
    pub technique: Technique,
    /// The formal model that it solves, relative to the study.
    pub model: Option<&'w Path>,
    /// The fault tree that it analyses, relative to the study.
    pub tree: Option<&'w Path>,
    /// What gives its episodes.
    pub simulated: Option<Simulated<'w>>,
    /// How many episodes it asks for; 0 of what has none.
    pub episodes: u64,
    /// The tables from which its counts are read.
    pub tables: Option<TableFiles<'w>>,
    /// The recordings that it judges.
    pub recordings: Option<RecordingFiles<'w>>,
    /// Whether it reads recordings through the study's `topics.toml`.
    pub uses_topics: bool,
    /// What a technique that is not built in is told.
    pub told: Option<&'w toml::Table>,
}

/// Files of tables, relative to the study.
#[derive(Clone, Copy, Debug)]
pub struct TableFiles<'w> {
    /// Trials by subject.
    pub cohort: Option<&'w Path>,
    /// Verdicts by requirement.
    pub requirements: Option<&'w Path>,
    /// Occurrences by failure mode.
    pub failure_modes: Option<&'w Path>,
    /// Why the one subject of a cohort stands for all, where the study declares it.
    pub one_for_all: Option<&'w str>,
    /// JUnit XML of runs: a folder or a file, which is no table by itself.
    pub junit: Option<&'w Path>,
    /// Episodes of a learned policy with what makes them alike: a cohort that is made of a file or folder.
    pub episodes: Option<(&'w Path, &'w str)>,
    /// By requirement the test that verifies it.
    pub tests: &'w BTreeMap<String, String>,
}

impl<'w> TableFiles<'w> {
    /// The tables that there are.
    pub fn paths(self) -> impl Iterator<Item = &'w Path> {
        let all = [self.cohort, self.requirements, self.failure_modes];
        all.into_iter().flatten()
    }
}

/// Recordings of a folder, each of which is a trial.
#[derive(Clone, Copy, Debug)]
pub struct RecordingFiles<'w> {
    /// The folder, relative to the study.
    pub folder: &'w Path,
    /// Why recordings of the same messages are trials of their own, where the study declares it.
    pub repeated: Option<&'w str>,
}

/// What gives episodes.
#[derive(Clone, Copy, Debug)]
pub enum Simulated<'w> {
    /// The handover's world.
    Handover {
        /// The scenario's file, relative to the study.
        scenario: &'w Path,
        /// The parameter set's file, relative to the study.
        parameters: &'w Path,
        /// The physics engine.
        engine: PhysicsEngine,
    },
    /// A scene.
    Scene {
        /// The scene's file, relative to the study.
        scene: &'w Path,
        /// Which of its tests is enacted; the first if none is named.
        test: Option<&'w str>,
        /// The physics engine.
        engine: PhysicsEngine,
    },
    /// A command.
    Command(&'w CommandText),
}

impl<'w> Simulated<'w> {
    /// The file that says what happens in an episode of ours.
    pub fn file(self) -> Option<&'w Path> {
        match self {
            Simulated::Handover { scenario, .. } => Some(scenario),
            Simulated::Scene { scene, .. } => Some(scene),
            Simulated::Command(_) => None,
        }
    }

    /// Whether its physics are of this program.
    pub fn is_ours(self) -> bool {
        self.file().is_some()
    }

    /// The parameter set's file, of the handover.
    pub fn parameters(self) -> Option<&'w Path> {
        match self {
            Simulated::Handover { parameters, .. } => Some(parameters),
            Simulated::Scene { .. } | Simulated::Command(_) => None,
        }
    }

    /// The test that is named, of a scene.
    pub fn test(self) -> Option<&'w str> {
        match self {
            Simulated::Scene { test, .. } => test,
            Simulated::Handover { .. } | Simulated::Command(_) => None,
        }
    }

    /// The physics engine, of a scene and of the handover.
    pub fn engine(self) -> Option<PhysicsEngine> {
        match self {
            Simulated::Scene { engine, .. } | Simulated::Handover { engine, .. } => Some(engine),
            Simulated::Command(_) => None,
        }
    }

    /// The command, of what is one.
    pub fn command(self) -> Option<&'w CommandText> {
        match self {
            Simulated::Command(command) => Some(command),
            Simulated::Handover { .. } | Simulated::Scene { .. } => None,
        }
    }
}

impl Work {
    /// What it has.
    pub fn parts(&self) -> Parts<'_> {
        match self {
            Work::Check { model, methods: _ } => Parts {
                technique: Technique::ModelChecking,
                model: Some(model),
                tree: None,
                simulated: None,
                episodes: 0,
                tables: None,
                recordings: None,
                uses_topics: false,
                told: None,
            },
            Work::FaultTree {
                tree,
                mission_time: _,
                events: _,
                is_triggered: _,
            } => Parts {
                technique: Technique::FaultTree,
                model: None,
                tree: Some(tree),
                simulated: None,
                episodes: 0,
                tables: None,
                recordings: None,
                uses_topics: false,
                told: None,
            },
            Work::Simulate {
                scenario,
                parameters,
                engine,
                episodes,
            } => Parts {
                technique: Technique::Simulation,
                model: None,
                tree: None,
                simulated: Some(Simulated::Handover {
                    scenario,
                    parameters,
                    engine: *engine,
                }),
                episodes: *episodes,
                tables: None,
                recordings: None,
                uses_topics: false,
                told: None,
            },
            Work::SimulateScene {
                scene,
                test,
                engine,
                episodes,
            } => Parts {
                technique: Technique::Simulation,
                model: None,
                tree: None,
                simulated: Some(Simulated::Scene {
                    scene,
                    test: test.as_deref(),
                    engine: *engine,
                }),
                episodes: *episodes,
                tables: None,
                recordings: None,
                uses_topics: false,
                told: None,
            },
            Work::Command {
                technique,
                command,
                episodes,
            } => Parts {
                technique: *technique,
                model: None,
                tree: None,
                simulated: Some(Simulated::Command(command)),
                episodes: *episodes,
                tables: None,
                recordings: None,
                uses_topics: true,
                told: None,
            },
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
            } => Parts {
                technique: *technique,
                model: None,
                tree: None,
                simulated: None,
                episodes: 0,
                tables: Some(TableFiles {
                    cohort: cohort.as_deref(),
                    requirements: requirements.as_deref(),
                    failure_modes: failure_modes.as_deref(),
                    one_for_all: one_for_all.as_deref(),
                    junit: junit.as_deref(),
                    episodes: episodes.as_deref().zip(cluster.as_deref()),
                    tests,
                }),
                recordings: None,
                uses_topics: false,
                told: None,
            },
            Work::Judge {
                technique,
                recordings,
                repeated,
            } => Parts {
                technique: *technique,
                model: None,
                tree: None,
                simulated: None,
                episodes: 0,
                tables: None,
                recordings: Some(RecordingFiles {
                    folder: recordings,
                    repeated: repeated.as_deref(),
                }),
                uses_topics: true,
                told: None,
            },
            Work::Other {
                technique,
                producer: _,
                span: _,
                with,
            } => Parts {
                technique: *technique,
                model: None,
                tree: None,
                simulated: None,
                episodes: 0,
                tables: None,
                recordings: None,
                uses_topics: false,
                told: Some(with),
            },
        }
    }

    /// The technique as whose evidence its findings count.
    pub fn technique(&self) -> Technique {
        self.parts().technique
    }

    /// The formal model that it solves, relative to the study.
    pub fn model(&self) -> Option<&Path> {
        self.parts().model
    }

    /// The fault tree that it analyses, relative to the study.
    pub fn tree(&self) -> Option<&Path> {
        self.parts().tree
    }

    /// What gives its episodes.
    pub fn simulated(&self) -> Option<Simulated<'_>> {
        self.parts().simulated
    }

    /// The scenario's or the scene's file, of simulations in physics of this program.
    pub fn simulated_file(&self) -> Option<&Path> {
        self.simulated()?.file()
    }

    /// The parameter set's file, of a simulation of the handover.
    pub fn simulated_parameters(&self) -> Option<&Path> {
        self.simulated()?.parameters()
    }

    /// Whether its episodes are run in physics of this program.
    pub fn is_simulated_here(&self) -> bool {
        self.simulated().is_some_and(Simulated::is_ours)
    }

    /// The command that gives its episodes.
    pub fn command(&self) -> Option<&CommandText> {
        self.simulated()?.command()
    }

    /// How many episodes it asks for; 0 of what has none.
    pub fn episodes(&self) -> u64 {
        self.parts().episodes
    }

    /// The tables from which its counts are read.
    pub fn tables(&self) -> Option<TableFiles<'_>> {
        self.parts().tables
    }

    /// The table of trials by subject, if its counts are read from one.
    pub fn cohort(&self) -> Option<&Path> {
        self.tables()?.cohort
    }

    /// The folder of the recordings that it judges, relative to the study.
    pub fn recordings(&self) -> Option<&Path> {
        self.parts().recordings.map(|it| it.folder)
    }

    /// What a technique that is not built in is told.
    pub fn told(&self) -> Option<&toml::Table> {
        self.parts().told
    }

    /// Whether what it finds depends on the study's seed.
    pub fn draws_at_random(&self) -> bool {
        match self {
            Self::Read { .. } | Self::Judge { .. } => false,
            Self::Check { .. }
            | Self::FaultTree { .. }
            | Self::Simulate { .. }
            | Self::SimulateScene { .. }
            | Self::Command { .. }
            | Self::Other { .. } => true,
        }
    }

    /// Whether counts are read instead of produced.
    pub fn is_read(&self) -> bool {
        self.tables().is_some()
    }
}
