//! The rig that a text names: the one place where handover, scene and command are told apart to be opened.

use crate::technique::simulation::load_engine;
use diagnostic::{Problem, Source};
use handover::Physics;
use host::Host;
use rig::{CommandRig, HandoverRig, HandoverTexts, Rig, ScenePhysics, SceneRig};
use std::path::Path;
use study::{Entry, PhysicsEngine, Simulated, Study};

/// How a text of the study is read.
pub type Read<'a> = dyn Fn(&Path) -> Result<Source, Problem> + 'a;

/// What is needed to open rigs. [`Opening::new`] has what most callers want.
pub struct Opening<'a> {
    /// The study.
    pub study: &'a Study,
    /// Where the physics library is, and what programs that a rig starts are given.
    pub host: &'a Host,
    /// The test that is enacted, in place of the one that is named in the ledger, or of the first.
    pub test: Option<&'a str>,
    /// How mistakes of a handover's files are told: see [`HandoverTexts`].
    pub joined: Option<&'a str>,
    /// How a text is read, whose path is relative to the study's; by default from its folder.
    pub read: Option<&'a Read<'a>>,
    /// The path of a file that is not read, and the text that stands in for it.
    pub instead: Option<(&'a Path, &'a Source)>,
    /// The entry of the ledger that is run in another engine than it says, and which.
    pub in_engine: Option<(&'a Entry, PhysicsEngine)>,
    /// Whether any engine will do, as nothing is run that depends on it: where the physics library is not there, what can be
    /// is opened in the engine that is built in.
    pub any_engine: bool,
    /// Whether a command is opened that may not run, since it need not: where what it left is fresh.
    pub only_looked_at: bool,
}

impl<'a> Opening<'a> {
    /// Rigs of a study as the ledger has them.
    pub fn new(study: &'a Study, host: &'a Host) -> Self {
        Self {
            study,
            host,
            test: None,
            joined: None,
            read: None,
            instead: None,
            in_engine: None,
            any_engine: false,
            only_looked_at: false,
        }
    }

    /// Opens a rig.
    ///
    /// # Errors
    /// What its files say wrong; `not-trusted` if it would run a program that the user has not allowed; `no-physics-library` if it needs the library and that cannot be loaded; `one-engine` of
    /// what is asked for in an engine that cannot run it.
    pub fn open(&self, simulated: Simulated<'_>) -> Result<Box<dyn Rig>, Problem> {
        Ok(match simulated {
            Simulated::Handover {
                scenario,
                parameters,
                engine,
            } => {
                let texts = HandoverTexts {
                    scenario: &self.text(scenario)?,
                    parameters: &self.text(parameters)?,
                    joined: self.joined,
                };
                let physics = || {
                    Ok(match self.engine(engine) {
                        PhysicsEngine::Rapier => Physics::Rapier,
                        PhysicsEngine::Mujoco => Physics::Mujoco(load_engine(self.host)?),
                    })
                };
                Box::new(HandoverRig::new(&texts, self.test, &physics)?)
            }
            Simulated::Scene {
                scene,
                test,
                engine,
            } => {
                let source = self.text(scene)?;
                let physics = match self.engine(engine) {
                    PhysicsEngine::Rapier => ScenePhysics::rapier(),
                    PhysicsEngine::Mujoco => ScenePhysics::mujoco(&load_engine(self.host)?),
                };
                let test = self.test.or(test);
                let test = (test, physics);
                Box::new(SceneRig::new(self.study, scene, &source, test, self.host)?)
            }
            Simulated::Command(command) => {
                self.only_in_its_engine()?;
                let stimulus = match (&command.stimulus, self.instead) {
                    (Some(path), Some((replaced, text))) if path == replaced => Some(text),
                    _ => None,
                };
                let rig = CommandRig::new(self.study, command, self.test, stimulus, self.host)?;
                match rig.obstacle().filter(|_| !self.only_looked_at) {
                    Some(problem) => return Err(problem.clone()),
                    None => Box::new(rig),
                }
            }
        })
    }

    /// The engine in which what names this one is run.
    fn engine(&self, named: PhysicsEngine) -> PhysicsEngine {
        match self.in_engine {
            _ if self.any_engine && self.host.physics_library.is_none() => PhysicsEngine::Rapier,
            Some((_, engine)) => engine,
            None => named,
        }
    }

    fn only_in_its_engine(&self) -> Result<(), Problem> {
        match self.in_engine {
            Some((entry, _)) => Err(one_engine(entry)),
            None => Ok(()),
        }
    }

    fn text(&self, path: &Path) -> Result<Source, Problem> {
        match (self.instead, self.read) {
            (Some((replaced, text)), _) if path == replaced => Ok(text.clone()),
            (_, Some(read)) => read(path),
            (_, None) => {
                let full = self.study.folder.join(path);
                self.study.reach.check(&full)?;
                host::files::read_source(&full)
            }
        }
    }
}

/// What files simulate that are named apart from the ledger, in this engine: a scenario with its parameters, or a scene; `None` of
/// any other choice of them.
pub fn of_files<'p>(
    scenario: Option<&'p Path>,
    parameters: Option<&'p Path>,
    scene: Option<&'p Path>,
    engine: PhysicsEngine,
) -> Option<Simulated<'p>> {
    match (scenario, parameters, scene) {
        (Some(scenario), Some(parameters), None) => Some(Simulated::Handover {
            scenario,
            parameters,
            engine,
        }),
        (None, None, Some(scene)) => Some(Simulated::Scene {
            scene,
            test: None,
            engine,
        }),
        _ => None,
    }
}

/// The rig of a ledger's entry.
///
/// # Errors
/// `not-a-simulation`, and as [`Opening::open`].
pub fn of_entry(study: &Study, entry: &Entry, host: &Host) -> Result<Box<dyn Rig>, Problem> {
    Opening::new(study, host).open(simulated(entry)?)
}

/// The rig of a ledger's entry in this engine, whichever the entry says; with its engine, a command is run, too.
///
/// # Errors
/// `not-a-simulation`, `one-engine`, and what its files say wrong.
pub fn in_engine(
    study: &Study,
    entry: &Entry,
    engine: PhysicsEngine,
    host: &Host,
) -> Result<Box<dyn Rig>, Problem> {
    let simulated = simulated(entry).map_err(|_| one_engine(entry))?;
    let is_its_own = simulated.engine().unwrap_or_default() == engine;
    let opening = Opening {
        in_engine: (!is_its_own).then_some((entry, engine)),
        ..Opening::new(study, host)
    };
    opening.open(simulated)
}

/// The rig of a ledger's entry in the engine that it does not say.
///
/// # Errors
/// As [`in_engine`].
pub fn in_other_engine(study: &Study, entry: &Entry, host: &Host) -> Result<Box<dyn Rig>, Problem> {
    let own = entry.work.simulated().and_then(Simulated::engine);
    in_engine(study, entry, own.unwrap_or_default().other(), host)
}

/// What an entry of the ledger simulates.
///
/// # Errors
/// `not-a-simulation`.
pub fn simulated(entry: &Entry) -> Result<Simulated<'_>, Problem> {
    entry.work.simulated().ok_or_else(|| {
        let message = format!("`{}` is not a simulation of this study", entry.id);
        Problem::new("not-a-simulation", message)
            .remedy("name an entry of the ledger with a scenario, a scene or a command")
    })
}

/// An entry that only one engine can run.
fn one_engine(entry: &Entry) -> Problem {
    Problem::new(
        "one-engine",
        format!(
            "`{}` is neither a scene nor the handover, and only these run in another engine",
            entry.id
        ),
    )
    .remedy("name an entry of the ledger with a `scene`, or with `scenario` and `parameters`")
}
