//! Simulation: seeded episodes on all cores, recorded, and judged by the
//! study's monitors.
//!
//! An episode is known by its number; its seed follows from the study's seed,
//! the evidence's identifier and that number. Each episode is kept as one
//! file, so that an interrupted campaign goes on where it stopped, and a
//! changed monitor judges the same episodes again.

use super::Produced;
use super::bench::SceneCampaign;
use super::judging::{Judgement, Judges};
use crate::forms::differences;
use crate::problem::{Problem, Source};
use crate::store::Inputs;
use crate::study::Study;
use crate::talk::{Interrupt, Stage};
use evidence::{Asset, Cost, Finding, Measure, Reading, Subject, Tool};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::time::Instant;
use temporal::monitor::Verdict;
use testbench::{Engine, Parameters, Scenario, ScenarioError, SimError, Unwatched, World};
use trace::Trace;

/// Runs that are named as witnesses of a violation, at most.
const WITNESSES: usize = 5;

/// A bench and the engine that runs it.
pub struct Campaign {
    engine: Engine,
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
    parameters: Parameters,
    scenario_text: String,
    parameters_text: String,
}

/// What one episode took.
#[derive(Clone, Copy, Debug, Default)]
struct Effort {
    simulated_secs: f64,
    /// Processor seconds of this thread; `None` if the recording was read.
    cpu_secs: Option<f64>,
}

/// Processor seconds that this thread has used.
fn thread_cpu_secs() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

impl Campaign {
    /// Reads the scenario and the parameters and loads the engine.
    pub fn new(
        study: &Study,
        scenario: &Path,
        parameters: &Path,
        library: Option<&Path>,
    ) -> Result<Self, Problem> {
        let (scenario, scenario_text) = read_scenario(&study.folder.join(scenario))?;
        let (parameters, parameters_text) = read_parameters(&study.folder.join(parameters))?;
        let engine = load_engine(library)?;
        let handover = Handover {
            scenario,
            parameters,
            scenario_text,
            parameters_text,
        };
        Ok(Self {
            engine,
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
            engine,
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
    pub fn gaps(&self) -> &[String] {
        match &self.bench {
            Bench::Handover(_) => &[],
            Bench::Scene(scene) => scene.gaps(),
        }
    }

    /// The engine and the settings that can move a number.
    pub fn tool(&self) -> Tool {
        Tool {
            name: "MuJoCo".into(),
            version: self.engine.version().to_owned(),
            settings: match &self.bench {
                Bench::Handover(handover) => {
                    let step_secs = handover.scenario.simulation.time_step_secs;
                    format!("time step {step_secs} s")
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

    /// A world in which single episodes can be run.
    pub fn world(&self) -> Result<World, Problem> {
        let handover = self.handover()?;
        World::new(&self.engine, &handover.scenario, &handover.parameters)
            .map_err(|error| Problem::new("simulation-failed", error.to_string()))
    }

    /// How often the robot's code runs, per second.
    pub fn controller_hz(&self) -> Result<u32, Problem> {
        Ok(self.handover()?.scenario.rates.controller_hz)
    }

    /// What an episode's trace depends on, besides its seed and this program.
    pub fn inputs(&self, inputs: &mut Inputs) {
        inputs.add("engine", self.engine.version().as_bytes());
        match &self.bench {
            Bench::Handover(handover) => {
                inputs
                    .add("scenario", handover.scenario_text.as_bytes())
                    .add("parameters", handover.parameters_text.as_bytes());
            }
            Bench::Scene(scene) => scene.inputs(inputs),
        }
    }

    /// Runs the episodes of `numbers` in parallel and hands each trace to
    /// `use_trace`, which may run on any thread; the results come in the order
    /// of the numbers. Episodes whose recording is in `folder` are read.
    fn episodes<T: Send>(
        &self,
        seeds: &Seeds,
        numbers: std::ops::Range<u64>,
        folder: &Path,
        interrupt: &Interrupt,
        stage: &Stage,
        use_trace: impl Fn(&Trace) -> Result<T, Problem> + Sync,
    ) -> Result<Vec<(T, Effort)>, Problem> {
        let numbers: Vec<u64> = numbers.collect();
        numbers
            .into_par_iter()
            .map_init(
                || None,
                |world: &mut Option<World>, number| {
                    if interrupt.is_set() {
                        return Err(Problem::interrupted());
                    }
                    let path = folder.join(episode_name(number));
                    let began = thread_cpu_secs();
                    let recorded = recorded(&path, seeds.of(number));
                    let is_new = recorded.is_none();
                    let trace = match recorded {
                        Some(trace) => trace,
                        None => {
                            let trace = self.simulate(world, seeds.of(number), interrupt)?;
                            recording::write_mcap(&path, &trace).map_err(write_problem)?;
                            trace
                        }
                    };
                    let result = use_trace(&trace)?;
                    stage.advance();
                    let effort = Effort {
                        simulated_secs: trace.end_secs().unwrap_or(0.0),
                        cpu_secs: is_new.then(|| thread_cpu_secs() - began),
                    };
                    Ok((result, effort))
                },
            )
            .collect()
    }

    fn simulate(
        &self,
        world: &mut Option<World>,
        seed: u64,
        interrupt: &Interrupt,
    ) -> Result<Trace, Problem> {
        let problem = |error: SimError| match error {
            SimError::Cancelled => Problem::interrupted(),
            other => Problem::new("simulation-failed", format!("seed {seed}: {other}")),
        };
        let handover = match &self.bench {
            Bench::Handover(handover) => handover,
            Bench::Scene(scene) => {
                let run = scene.run(seed, &mut Unwatched, interrupt);
                return Ok(run.map_err(problem)?.trace);
            }
        };
        let world = match world {
            Some(world) => world,
            None => world.insert(
                World::new(&self.engine, &handover.scenario, &handover.parameters)
                    .map_err(problem)?,
            ),
        };
        let episode = testbench::run_episode(world, seed, interrupt.cancel());
        Ok(episode.map_err(problem)?.trace)
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
    Engine::load(library).map_err(|error| {
        Problem::new("no-physics-library", error.to_string())
            .remedy("run `tools/mujoco`, which fetches the version that is needed")
    })
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

/// Records episodes without judging them.
pub fn record(
    campaign: &Campaign,
    seeds: &Seeds,
    numbers: std::ops::Range<u64>,
    folder: &Path,
    interrupt: &Interrupt,
    stage: &Stage,
) -> Result<Vec<PathBuf>, Problem> {
    campaign.episodes(seeds, numbers.clone(), folder, interrupt, stage, |_| Ok(()))?;
    Ok(numbers.map(|n| folder.join(episode_name(n))).collect())
}

/// Simulates episodes and hands each trace, with its file's path, to `write`,
/// which may run on any thread; the results come in the order of the numbers.
pub fn record_with<T: Send>(
    campaign: &Campaign,
    seeds: &Seeds,
    numbers: std::ops::Range<u64>,
    folder: &Path,
    interrupt: &Interrupt,
    stage: &Stage,
    write: impl Fn(&Trace, &Path) -> Result<T, Problem> + Sync,
) -> Result<Vec<(PathBuf, T)>, Problem> {
    let numbers: Vec<u64> = numbers.collect();
    numbers
        .into_par_iter()
        .map_init(
            || None,
            |world: &mut Option<World>, number| {
                if interrupt.is_set() {
                    return Err(Problem::interrupted());
                }
                let trace = campaign.simulate(world, seeds.of(number), interrupt)?;
                let path = folder.join(episode_name(number));
                let result = write(&trace, &path)?;
                stage.advance();
                Ok((path, result))
            },
        )
        .collect()
}

/// Runs a campaign and judges it.
pub fn produce(
    study: &Study,
    id: &str,
    campaign: &Campaign,
    episodes: u64,
    folder: &Path,
    interrupt: &Interrupt,
    stage: &Stage,
) -> Result<Produced, Problem> {
    let began = Instant::now();
    let judges = Judges::new(study, |_| true)?;
    let forms = differences::forms_of(study);
    let form_judges = differences::judges(study, &forms)?;
    let seeds = Seeds::new(study.about.seed, id);
    let judged = campaign.episodes(&seeds, 1..episodes + 1, folder, interrupt, stage, |trace| {
        Ok((judges.judge(trace)?, form_judges.judge(trace)?))
    })?;
    let (judged, efforts): (Vec<_>, Vec<_>) = judged.into_iter().unzip();
    let (judgements, of_forms): (Vec<_>, Vec<_>) = judged.into_iter().unzip();
    let numbers: Vec<String> = (1..=episodes).map(episode_name).collect();
    let cost = Cost {
        evidence: id.to_owned(),
        wall_secs: began.elapsed().as_secs_f64(),
        ..cost_of(&efforts)
    };
    Ok(Produced {
        tool: campaign.tool(),
        findings: findings(study, &judgements, &numbers)?,
        form_differences: differences::summary(&of_forms, &numbers, WITNESSES),
        clusters: None,
        influences: Vec::new(),
        cost,
    })
}

/// The cost of episodes; processor time and speed are of those that were not
/// read from an earlier run.
fn cost_of(efforts: &[Effort]) -> Cost {
    let (mut simulated_secs, mut cpu_secs) = (0.0, 0.0);
    for effort in efforts {
        if let Some(used) = effort.cpu_secs {
            simulated_secs += effort.simulated_secs;
            cpu_secs += used;
        }
    }
    Cost {
        simulated_secs: Some(efforts.iter().map(|e| e.simulated_secs).sum()),
        cpu_secs: Some(cpu_secs),
        real_time_factor: (cpu_secs > 0.0).then(|| simulated_secs / cpu_secs),
        ..Cost::default()
    }
}

/// Sums up judgements of many traces, one finding for each subject.
pub fn findings(
    study: &Study,
    judgements: &[Vec<Judgement>],
    names: &[String],
) -> Result<Vec<Finding>, Problem> {
    study
        .forms
        .subjects
        .iter()
        .map(|form| {
            let main = Tally::of(judgements, names, &form.subject, None);
            if form.monitor.is_none() {
                return Ok(Finding {
                    subject: form.subject.clone(),
                    measure: Measure::NotExpressible {
                        reason: match &form.no_monitor {
                            Some(reason) => format!("It cannot be judged on traces: {reason}."),
                            None => "It has no monitor.".into(),
                        },
                    },
                    undecided: 0,
                    witnesses: Vec::new(),
                    readings: Vec::new(),
                });
            }
            let readings = form.readings.iter().map(|reading| {
                let other = Tally::of(judgements, names, &form.subject, Some(&reading.name));
                let differing: Vec<&String> = (0..names.len())
                    .filter(|i| main.verdicts[*i] != other.verdicts[*i])
                    .map(|i| &names[i])
                    .collect();
                Reading {
                    name: reading.name.clone(),
                    meaning: reading.meaning.clone(),
                    count: other.satisfied,
                    trials: other.satisfied + other.violated,
                    differing: differing.len() as u64,
                    witnesses: differing.into_iter().take(WITNESSES).cloned().collect(),
                }
            });
            Ok(Finding {
                subject: form.subject.clone(),
                measure: main.measure(study, &form.subject)?,
                undecided: main.inconclusive,
                readings: readings.collect(),
                witnesses: main.witnesses,
            })
        })
        .collect()
}

/// The verdicts of one monitor over many traces.
#[derive(Debug, Default)]
struct Tally {
    satisfied: u64,
    violated: u64,
    inconclusive: u64,
    verdicts: Vec<Option<Verdict>>,
    witnesses: Vec<String>,
}

impl Tally {
    fn of(
        judgements: &[Vec<Judgement>],
        names: &[String],
        subject: &Subject,
        reading: Option<&str>,
    ) -> Self {
        let mut tally = Self::default();
        for (judgement, name) in judgements.iter().zip(names) {
            let judged = judgement
                .iter()
                .find(|j| j.subject == subject && j.reading == reading);
            let verdict = judged.map(|j| j.findings.verdict);
            match verdict {
                Some(Verdict::Satisfied) => tally.satisfied += 1,
                Some(Verdict::Violated) => {
                    tally.violated += 1;
                    if tally.witnesses.len() < WITNESSES {
                        tally.witnesses.push(name.clone());
                    }
                }
                Some(Verdict::Inconclusive) => tally.inconclusive += 1,
                Some(Verdict::NotCovered) | None => {}
            }
            tally.verdicts.push(verdict);
        }
        tally
    }

    fn measure(&self, study: &Study, subject: &Subject) -> Result<Measure, Problem> {
        let trials = self.satisfied + self.violated;
        if trials == 0 {
            return Ok(Measure::NotCovered {
                reason: format!(
                    "In none of {} runs was its precondition met{}.",
                    self.verdicts.len(),
                    if self.inconclusive > 0 {
                        " and a verdict reached"
                    } else {
                        ""
                    }
                ),
            });
        }
        let count = match subject {
            Subject::Requirement(_) => self.satisfied,
            Subject::FailureMode(_) => self.violated,
        };
        super::counts(
            count,
            trials,
            None,
            super::confidence(study.about.confidence)?,
        )
    }
}

fn read_scenario(path: &Path) -> Result<(Scenario, String), Problem> {
    let source = Source::read(path)?;
    let scenario = Scenario::parse(&source.text).map_err(|e| scenario_problem(&source, &e))?;
    Ok((scenario, source.text))
}

fn read_parameters(path: &Path) -> Result<(Parameters, String), Problem> {
    let source = Source::read(path)?;
    let parameters = Parameters::parse(&source.text).map_err(|e| scenario_problem(&source, &e))?;
    Ok((parameters, source.text))
}

fn scenario_problem(source: &Source, error: &ScenarioError) -> Problem {
    Problem::new("bad-scenario", format!("{}: {error}", source.name))
}

fn recorded(path: &Path, seed: u64) -> Option<Trace> {
    // A recording that is missing, damaged, cut short or of another episode is
    // made again.
    let trace = path
        .exists()
        .then(|| recording::read_mcap(path))?
        .ok()?
        .trace;
    let is_ours = trace.metadata.get("seed") == Some(&seed.to_string());
    (trace.complete && is_ours).then_some(trace)
}

fn write_problem(error: recording::TraceWriteError) -> Problem {
    Problem::data_lost("cannot-record", error.to_string())
        .remedy("make room on the disk or choose another folder, and run the command again")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn seeds_differ_between_episodes_and_evidence_and_never_change() {
        let seeds = Seeds::new(2020, "E4");
        let first: BTreeSet<u64> = (1..=1000).map(|n| seeds.of(n)).collect();
        assert_eq!(first.len(), 1000);
        assert!(!first.contains(&Seeds::new(2020, "E2").of(1)));
        assert_eq!(seeds.of(7), Seeds::new(2020, "E4").of(7));
    }
}
