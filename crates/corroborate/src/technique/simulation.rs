//! Simulation: the bench that an entry of the ledger names, and its episodes.
//!
//! An episode is known by its number; its seed follows from the study's seed,
//! the evidence's identifier and that number. Campaigns of many episodes are
//! run by `technique::campaign`.

use super::campaign::{Intervals, Tally, monitors};
use super::files::Files;
use crate::memory;
use diagnostic::{Problem, Source};
use evidence::{Asset, AssetRole, DescriptionGap, Finding, Tool};
use handover::{HandoverBench, Parameters, Scenario, World};
use host::store::Inputs;
use host::{Cancel, Stage};
use judging::{Judgement, Judges};
use rayon::prelude::*;
use rig::SceneCampaign;
use schemars::JsonSchema;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use stimulus::Stimulus;
use study::Study;
use testbench::{
    Bench as _, Drawn, Engine, Recorded, Savable, ScenarioError, SimError, Unwatched, Watch,
};
use trace::Trace;

/// A bench and the engine that runs it.
pub struct Campaign {
    /// The engine's name and version.
    engine: (String, String),
    bench: Bench,
}

/// What is simulated.
enum Bench {
    /// The handover world.
    Handover(Box<Handover>),
    /// A scene.
    Scene(Box<SceneCampaign>),
}

/// A scenario with its parameters.
struct Handover {
    scenario: Scenario,
    /// The same world as a bench whose runs can be saved.
    bench: HandoverBench,
    world: World,
    stimulus: Stimulus,
    /// The topics of its recordings.
    layout: Trace,
    scenario_text: String,
    parameters_text: String,
}

impl Campaign {
    /// Reads the scenario and the parameters and loads the engine.
    pub fn new(
        study: &Study,
        scenario: &Path,
        parameters: &Path,
        library: Option<&Path>,
    ) -> Result<Self, Problem> {
        Self::read(scenario, parameters, library, &Files::of(&study.folder))
    }

    /// The same, with both read through `files`.
    pub(crate) fn read(
        scenario: &Path,
        parameters: &Path,
        library: Option<&Path>,
        files: &Files<'_>,
    ) -> Result<Self, Problem> {
        let scenario = files.text(AssetRole::SystemModel, scenario)?;
        let (scenario, scenario_text) = read_scenario(scenario)?;
        let parameters = files.text(AssetRole::SystemModel, parameters)?;
        let (parameters, parameters_text) = read_parameters(parameters)?;
        let engine = load_engine(library)?;
        let handover = Handover::new(
            &engine,
            scenario,
            &parameters,
            scenario_text,
            parameters_text,
        )
        .map_err(|error| Problem::new("simulation-failed", error.to_string()))?;
        Ok(Self {
            engine: ("MuJoCo".to_owned(), engine.version()),
            bench: Bench::Handover(Box::new(handover)),
        })
    }

    /// Reads a scene with everything that it names and loads the engine.
    pub fn of_scene(
        study: &Study,
        scene: &Path,
        test: Option<&str>,
        library: Option<&Path>,
    ) -> Result<Self, Problem> {
        let engine = load_engine(library)?;
        let scene = SceneCampaign::new(study, scene, test, &engine)?;
        Ok(Self {
            engine: ("MuJoCo".to_owned(), engine.version()),
            bench: Bench::Scene(Box::new(scene)),
        })
    }

    /// Reads a scene and everything that it names, to be run in Rapier.
    pub fn of_scene_in_rapier(
        study: &Study,
        scene: &Path,
        test: Option<&str>,
    ) -> Result<Self, Problem> {
        let scene = SceneCampaign::with_physics(study, scene, test, testbench::scene::rapier())?;
        let version = testbench::physics::RAPIER_VERSION.to_owned();
        Ok(Self {
            engine: ("Rapier".to_owned(), version),
            bench: Bench::Scene(Box::new(scene)),
        })
    }

    /// The files that a scene names: robots' descriptions, their code.
    pub fn assets(&self) -> &[Asset] {
        match &self.bench {
            Bench::Handover(_) => &[],
            Bench::Scene(scene) => scene.assets(),
        }
    }

    /// What of robots' descriptions is not simulated.
    pub fn gaps(&self) -> &[DescriptionGap] {
        match &self.bench {
            Bench::Handover(_) => &[],
            Bench::Scene(scene) => scene.gaps(),
        }
    }

    /// The engine and the settings that can move a number.
    pub fn tool(&self) -> Tool {
        Tool {
            name: self.engine.0.clone(),
            version: self.engine.1.clone(),
            settings: match &self.bench {
                Bench::Handover(handover) => {
                    let settings = &handover.scenario.simulation;
                    format!("time step {} s", settings.time_step_secs)
                }
                Bench::Scene(scene) => scene.settings(),
            },
        }
    }

    /// The handover's parts; a scene has none of them.
    fn handover(&self) -> Result<&Handover, Problem> {
        match &self.bench {
            Bench::Handover(handover) => Ok(handover),
            Bench::Scene(_) => Err(Problem::new(
                "not-a-handover",
                "a scene cannot be joined to parts outside",
            )
            .remedy("name an entry of the ledger with a `scenario` and `parameters`")),
        }
    }

    /// The scene, if it is one.
    pub fn scene(&self) -> Option<&SceneCampaign> {
        match &self.bench {
            Bench::Scene(scene) => Some(scene),
            Bench::Handover(_) => None,
        }
    }

    /// A world in which single episodes can be run.
    pub fn world(&self) -> Result<World, Problem> {
        Ok(self.handover()?.world.clone())
    }

    /// How often the robot's code runs, per second.
    pub fn controller_hz(&self) -> Result<u32, Problem> {
        Ok(self.handover()?.scenario.rates.controller_hz)
    }

    /// What an episode's trace depends on, besides its seed and this program.
    pub fn inputs(&self, inputs: &mut Inputs) {
        let (name, version) = &self.engine;
        inputs.add("engine", version.as_bytes());
        if name != "MuJoCo" {
            inputs.add("engine_name", name.as_bytes());
        }
        match &self.bench {
            Bench::Handover(handover) => {
                inputs
                    .add("scenario", handover.scenario_text.as_bytes())
                    .add("parameters", handover.parameters_text.as_bytes());
            }
            Bench::Scene(scene) => scene.inputs(inputs),
        }
    }

    /// The topics of its recordings, without rows.
    pub fn layout(&self) -> Result<Trace, Problem> {
        match &self.bench {
            Bench::Handover(handover) => Ok(handover.layout.clone()),
            Bench::Scene(scene) => scene
                .layout()
                .map_err(|error| Problem::new("simulation-failed", error.to_string())),
        }
    }

    /// What is done in each episode.
    pub fn stimulus(&self) -> &Stimulus {
        match &self.bench {
            Bench::Handover(handover) => &handover.stimulus,
            Bench::Scene(scene) => scene.stimulus(),
        }
    }

    /// The numbers that an episode draws once from its seed.
    pub fn drawn(&self, seed: u64) -> Result<Vec<Drawn>, Problem> {
        match &self.bench {
            Bench::Handover(handover) => handover.bench.drawn(&handover.stimulus, seed),
            Bench::Scene(scene) => scene.bench().drawn(scene.stimulus(), seed),
        }
        .map_err(|error| problem_at(seed, &error))
    }

    /// Runs one episode, which `watch` may end. One whose controller fails is cut short; one whose
    /// controller cannot be set up is an error.
    pub fn run(
        &self,
        seed: u64,
        watch: &mut dyn Watch,
        interrupt: &Cancel,
    ) -> Result<Recorded, Problem> {
        let recorded = self
            .attempt(seed, watch, interrupt)
            .map_err(|error| problem_at(seed, &error))?;
        match &recorded.failure {
            Some(failure) if failure.in_setup => {
                let message = format!("seed {seed}: {}", failure.words);
                Err(Problem::new("controller-failed", message))
            }
            _ => Ok(recorded),
        }
    }

    /// Runs one episode, whatever comes of it.
    pub fn attempt(
        &self,
        seed: u64,
        watch: &mut dyn Watch,
        interrupt: &Cancel,
    ) -> Result<Recorded, SimError> {
        match &self.bench {
            Bench::Scene(scene) => scene.run(seed, watch, interrupt),
            Bench::Handover(handover) => {
                handover::watch_episode(&handover.world, seed, watch, interrupt).map(Recorded::from)
            }
        }
    }
}

/// What kept an episode from being simulated.
pub fn problem_at(seed: u64, error: &SimError) -> Problem {
    match error {
        SimError::Cancelled => Problem::interrupted(),
        other => Problem::new("simulation-failed", format!("seed {seed}: {other}")),
    }
}

impl Campaign {
    /// Runs one episode that is saved in the middle of its recording and
    /// continued from there in a new run.
    pub fn run_in_two_parts(&self, seed: u64, interrupt: &Cancel) -> Result<Recorded, Problem> {
        let run = match &self.bench {
            Bench::Scene(scene) => in_two_parts(scene.bench(), scene.stimulus(), seed, interrupt),
            Bench::Handover(handover) => {
                in_two_parts(&handover.bench, &handover.stimulus, seed, interrupt)
            }
        };
        run.map_err(|error| problem_at(seed, &error))
    }
}

/// Measures how long the run is, then runs it to its middle, and on from what was saved there.
fn in_two_parts<B: Savable>(
    bench: &B,
    stimulus: &Stimulus,
    seed: u64,
    interrupt: &Cancel,
) -> Result<Recorded, SimError> {
    let cancel = &interrupt;
    let mut whole = bench.start(stimulus, seed)?;
    bench.advance(&mut whole, f64::INFINITY, &mut Unwatched, cancel)?;
    let middle_secs = bench.now_secs(&whole) / 2.0;
    drop(whole);
    let mut first = bench.start(stimulus, seed)?;
    bench.advance(&mut first, middle_secs, &mut Unwatched, cancel)?;
    let saved = bench.save(&first)?;
    drop(first);
    let mut second = bench.resume(&saved, None)?;
    bench.advance(&mut second, f64::INFINITY, &mut Unwatched, cancel)?;
    bench.finish(second)
}

impl Handover {
    fn new(
        engine: &Engine,
        scenario: Scenario,
        parameters: &Parameters,
        scenario_text: String,
        parameters_text: String,
    ) -> Result<Self, SimError> {
        let world = World::new(engine, &scenario, parameters)?;
        let bench = HandoverBench::new(engine, &scenario_text, &parameters_text)?;
        let test = scenario
            .abstract_tests
            .first()
            .map(|test| test.name.as_str());
        Ok(Self {
            stimulus: bench.own_test(test.unwrap_or_default())?,
            layout: bench.layout()?,
            bench,
            scenario,
            world,
            scenario_text,
            parameters_text,
        })
    }
}

/// Loads the physics library.
pub fn load_engine(library: Option<&Path>) -> Result<Engine, Problem> {
    let Some(library) = library else {
        return Err(Problem::new(
                "no-physics-library",
                "simulations need the MuJoCo library, whose place is not known",
            )
            .remedy("start the program as `./corroborate`, which fetches it, or set CORROBORATE_MUJOCO to its path"));
    };
    let engine = Engine::load(library).map_err(|error| {
        Problem::new("no-physics-library", error.to_string())
            .remedy("run `tools/mujoco`, which fetches the version that is needed")
    })?;
    memory::give_large_blocks_back();
    Ok(engine)
}

/// The seeds of a piece of evidence's episodes.
#[derive(Clone, Debug)]
pub struct Seeds {
    study: u64,
    evidence: String,
}

impl Seeds {
    /// Seeds that differ between pieces of evidence of one study.
    pub fn new(study: u64, evidence: &str) -> Self {
        Self {
            study,
            evidence: evidence.to_owned(),
        }
    }

    /// The seed of one episode.
    pub fn of(&self, number: u64) -> u64 {
        let mut inputs = Inputs::default();
        inputs
            .add("study", &self.study.to_le_bytes())
            .add("evidence", self.evidence.as_bytes())
            .add("episode", &number.to_le_bytes());
        u64::from_str_radix(&inputs.hash()[..16], 16).unwrap_or(number)
    }
}

/// The file name of an episode's recording.
pub fn episode_name(number: u64) -> String {
    format!("episode-{number:05}.mcap")
}

/// Simulates episodes and hands each trace, with its file's path, to `write`,
/// which may run on any thread; the results come in the order of the numbers.
pub fn record_with<T: Send>(
    campaign: &Campaign,
    seeds: &Seeds,
    numbers: std::ops::Range<u64>,
    folder: &Path,
    interrupt: &Cancel,
    stage: &Stage,
    write: impl Fn(&Trace, &Path) -> Result<T, Problem> + Sync,
) -> Result<Vec<(PathBuf, T)>, Problem> {
    let numbers: Vec<u64> = numbers.collect();
    numbers
        .into_par_iter()
        .map(|number| {
            let trace = campaign
                .run(seeds.of(number), &mut Unwatched, interrupt)?
                .trace;
            let path = folder.join(episode_name(number));
            let result = write(&trace, &path)?;
            stage.advance();
            Ok((path, result))
        })
        .collect()
}

/// Sums up judgements of many traces, one finding for each subject.
pub fn findings(
    study: &Study,
    judges: &Judges<'_>,
    judgements: &[Vec<Judgement>],
    names: &[String],
) -> Result<Vec<Finding>, Problem> {
    let mut tally = Tally::new(&monitors(judges));
    for (judgements, name) in judgements.iter().zip(names) {
        let verdicts: Vec<_> = judgements.iter().map(|j| j.findings.verdict).collect();
        tally.add(name, &verdicts);
    }
    tally.findings(study, Intervals::Fixed)
}

/// Which physics a search runs in. What it finds is shown by the full one before it counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SearchPhysics {
    /// The fast one, which is approximate; of benches that have one.
    Fast,
    /// The full one.
    Full,
}

impl study::Choice for SearchPhysics {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Fast,
            "fast",
            "The fast one, which is approximate; of benches that have one",
        ),
        (Self::Full, "full", "The full one"),
    ];
}

impl SearchPhysics {
    /// What a search runs in beside the full physics: `fast` makes the bench of the fast one, if there is one. Without
    /// a choice the fast one is taken where it exists; `Err` if it is asked for where it does not exist.
    pub fn choose<T>(
        asked: Option<Self>,
        fast: impl FnOnce() -> Option<T>,
    ) -> Result<Option<T>, String> {
        match asked {
            Some(Self::Full) => Ok(None),
            None => Ok(fast()),
            Some(Self::Fast) => match fast() {
                Some(bench) => Ok(Some(bench)),
                None => {
                    Err("this bench has no fast physics: it always runs in the full one".to_owned())
                }
            },
        }
    }
}

/// The part of a scenario that says in which physics it is simulated.
#[derive(Deserialize)]
struct PhysicsText {
    simulation: Option<PhysicsOfScenario>,
}

#[derive(Deserialize)]
struct PhysicsOfScenario {
    fast: Option<toml::Spanned<bool>>,
}

/// Reads a scenario of a study, which is refused if it asks for the fast physics: what is counted would be
/// approximate, and nothing in a count, a verdict or a table of episodes shows it.
pub fn scenario_source(path: &Path) -> Result<Source, Problem> {
    in_full_physics(host::files::read_source(path)?)
}

fn in_full_physics(source: Source) -> Result<Source, Problem> {
    let text: Option<PhysicsText> = toml::from_str(&source.text).ok();
    let fast = text.and_then(|text| text.simulation?.fast);
    match fast {
        Some(fast) if *fast.get_ref() => Err(Problem::new(
            "fast-physics-as-evidence",
            "evidence must be simulated in the full physics, and this scenario asks for the fast one, which is approximate",
        )
        .at(&source, fast.span())
        .remedy("remove `fast`; explore, shrink and calibrate search in the fast physics by themselves (`physics`)")),
        _ => Ok(source),
    }
}

fn read_scenario(source: Source) -> Result<(Scenario, String), Problem> {
    let source = in_full_physics(source)?;
    let scenario = Scenario::parse(&source.text);
    let scenario = scenario.map_err(|error| scenario_problem(&source.name, &error.into()))?;
    Ok((scenario, source.text))
}

fn read_parameters(source: Source) -> Result<(Parameters, String), Problem> {
    let parameters = Parameters::parse(&source.text);
    let parameters = parameters.map_err(|error| scenario_problem(&source.name, &error.into()))?;
    Ok((parameters, source.text))
}

/// What is wrong with the scenario or the parameters in these files.
pub fn scenario_problem(files: &str, error: &SimError) -> Problem {
    let said = error.to_string();
    let problem = Problem::new("bad-scenario", format!("{files}: {}", said.trim_end()));
    match error {
        SimError::Scenario(ScenarioError::Syntax { .. }) => problem.remedy(
            "correct that place of the file; `corroborate explain scenario` and `corroborate explain parameters` say what is in it",
        ),
        _ => problem,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn an_empty_scenario_is_refused_with_what_it_lacks_and_a_remedy() {
        let source = Source {
            name: "scenario.toml".to_owned(),
            text: String::new(),
        };
        let error = Scenario::parse(&source.text).expect_err("it is empty");
        let said = scenario_problem(&source.name, &error.into()).to_string();
        for part in [
            "scenario.toml: ",
            "missing field `name`",
            "explain scenario",
        ] {
            assert!(said.contains(part), "{said}");
        }
    }

    #[test]
    fn a_scenario_in_the_fast_physics_is_refused_with_its_place() {
        let folder = std::env::temp_dir().join(format!("fast-physics-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("scenario.toml");
        let read = |text: &str| {
            std::fs::write(&path, text).expect("a file");
            scenario_source(&path)
        };
        let refused =
            read("name = \"x\"\n[simulation]\nstep = 1\nfast = true\n").expect_err("it is fast");
        assert_eq!(refused.code, "fast-physics-as-evidence");
        let said = refused.to_string();
        assert!(said.contains("scenario.toml:4:8"), "{said}");
        for text in [
            "[simulation]\nfast = false\n",
            "[simulation]\n",
            "",
            "not toml",
        ] {
            assert_eq!(
                read(text)
                    .expect("what else is wrong is told elsewhere")
                    .text,
                text
            );
        }
        std::fs::remove_dir_all(&folder).expect("it was there");
    }

    #[test]
    fn a_search_takes_the_fast_physics_where_it_exists() {
        let choose = |asked, there: bool| SearchPhysics::choose(asked, || there.then_some(()));
        assert_eq!(choose(None, true), Ok(Some(())));
        assert_eq!(choose(None, false), Ok(None));
        assert_eq!(choose(Some(SearchPhysics::Full), true), Ok(None));
        assert_eq!(choose(Some(SearchPhysics::Fast), true), Ok(Some(())));
        assert!(choose(Some(SearchPhysics::Fast), false).is_err());
    }

    #[test]
    fn seeds_differ_between_episodes_and_evidence_and_never_change() {
        let seeds = Seeds::new(2020, "E4");
        let first: BTreeSet<u64> = (1..=1000).map(|n| seeds.of(n)).collect();
        assert_eq!(first.len(), 1000);
        assert!(!first.contains(&Seeds::new(2020, "E2").of(1)));
        assert_eq!(seeds.of(7), Seeds::new(2020, "E4").of(7));
    }
}
