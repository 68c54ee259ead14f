//! One synthetic study: its evidence, produced and compared by the code of the product.

use crate::family::{Family, HANDOVER, Setup};
use crate::fault::{Assets, Fault, Planted, SetTo, Site, plant};
use crate::formal::Formal;
use crate::journey;
use crate::judges::Judges;
use crate::matrix::{self, half_step, of_paths};
use crate::random::Random;
use crate::requirements::{failure_modes, id, stated};
use crate::task::{Run, SPEED_LIMIT, Task};
use crate::trials;
use evidence::{
    Asset, AssetRole, Calibration, Cell, Combined, Comparison, Evidence, Finding, Influences,
    Levels, Matter, Measure, Study, Subject, Suspect, Technique, Tool, Weights, combine, compare,
    rank,
};
use prism_lang::{edit, parse_model};
use stats::{Confidence, EffectiveSample, Sample};

/// The level of every interval and of agreement.
pub const LEVEL: f64 = 0.95;

/// The largest difference that counts as agreement, and the tolerance of the first baseline.
pub const MARGIN: f64 = 0.05;

/// The formal model of the handover.
const HANDOVER_MODEL: &str =
    include_str!("../../../case-studies/handover/models/handover_v5.prism");

/// The identifiers of the evidence.
pub mod ids {
    /// Tests of stages alone.
    pub const RIG: &str = "rig";
    /// Model checking.
    pub const MODEL: &str = "M";
    /// Simulation.
    pub const SIMULATION: &str = "S";
    /// Experiments.
    pub const EXPERIMENT: &str = "X";
    /// Recordings of the robot at work.
    pub const OPERATION: &str = "O";
}

/// A study with all that the product says of it.
#[derive(Debug)]
pub struct Synthetic {
    /// From which all is drawn, and its number.
    pub seed: (u64, u64),
    /// What is true.
    pub setup: Setup,
    /// The assets.
    pub assets: Assets,
    /// What was planted.
    pub planted: Planted,
    /// The ledger.
    pub evidence: Vec<Evidence>,
    /// Every pair on every subject.
    pub comparisons: Vec<Comparison>,
    /// Whom the product suspects, the first the most.
    pub suspects: Vec<Suspect>,
}

impl Synthetic {
    /// The study of this number: a truth of the family, with this fault planted.
    ///
    /// # Errors
    /// What could not be produced, in words; none is known.
    pub fn new(family: Family, fault: Fault, seed: u64, number: u64) -> Result<Self, String> {
        let mut random = Random::new(seed, number);
        let mut setup = Setup::draw(family, &mut random);
        let (assets, planted) = plant(fault, &mut setup, &mut random);
        Self::of(setup, assets, planted, (seed, number))
    }

    /// The same study with other assets: what they do not touch is as it was.
    ///
    /// # Errors
    /// What could not be produced, in words.
    pub fn again(&self, assets: Assets) -> Result<Self, String> {
        Self::of(self.setup.clone(), assets, self.planted.clone(), self.seed)
    }

    fn of(
        setup: Setup,
        mut assets: Assets,
        planted: Planted,
        seed: (u64, u64),
    ) -> Result<Self, String> {
        let (evidence, cells) = ledger(&setup, &mut assets, seed)?;
        let requirements = stated(&assets.forms);
        let failure_modes = failure_modes(&assets.modes);
        let influences = Influences::learn(&evidence);
        let study = Study {
            requirements: &requirements,
            failure_modes: &failure_modes,
            evidence: &evidence,
            influences: &influences,
            levels: levels()?,
            looks: None,
        };
        let comparisons = compare(&study);
        let more = assets
            .step
            .map(|_| half_step(&assets, seed.0, seed.1, setup.simulated));
        let matter = Matter {
            requirements: &requirements,
            failure_modes: &failure_modes,
            evidence: &evidence,
            comparisons: &comparisons,
            cells: &cells,
            tables: &[],
            study: "synthetic",
        };
        let suspects = rank(&matter, more.unwrap_or_default());
        Ok(Self {
            seed,
            setup,
            assets,
            planted,
            evidence,
            comparisons,
            suspects,
        })
    }

    /// What the independent evidence on each requirement supports together.
    ///
    /// # Errors
    /// None is known.
    pub fn combined(&self) -> Result<Vec<Combined>, String> {
        let (requirements, failure_modes) = (
            stated(&self.assets.forms),
            failure_modes(&self.assets.modes),
        );
        let influences = Influences::learn(&self.evidence);
        let study = Study {
            requirements: &requirements,
            failure_modes: &failure_modes,
            evidence: &self.evidence,
            influences: &influences,
            levels: levels()?,
            looks: None,
        };
        Ok(combine(&study, &self.comparisons, &Weights::default()))
    }

    /// The piece of evidence with this identifier.
    #[must_use]
    pub fn piece(&self, id: &str) -> Option<&Evidence> {
        self.evidence.iter().find(|piece| piece.id == id)
    }

    /// The true rate of a subject.
    #[must_use]
    pub fn truth(&self, subject: &Subject) -> Option<f64> {
        rate(&self.setup.truth, self.setup.limit_steps, subject)
    }

    /// The evidence that rests on the faulty asset.
    #[must_use]
    pub fn faulty(&self) -> Vec<&'static str> {
        match self.planted.site {
            Some(Site::FormalModel | Site::Property | Site::Solver) => vec![ids::MODEL],
            Some(Site::Simulation | Site::TimeStep) => vec![ids::SIMULATION],
            Some(Site::Monitor) => vec![ids::SIMULATION, ids::OPERATION],
            Some(Site::Data) => vec![ids::EXPERIMENT],
            None => Vec::new(),
        }
    }
}

/// The rate of a subject in a task.
#[must_use]
pub fn rate(task: &Task, limit_steps: u32, subject: &Subject) -> Option<f64> {
    match subject {
        Subject::Requirement(name) => match name.as_str() {
            id::DONE | id::READY => Some(task.success()),
            id::IN_TIME => Some(crate::fault::done_between(task, 0, limit_steps)),
            id::SLOW => Some(task.slower_than(SPEED_LIMIT)),
            _ => None,
        },
        Subject::FailureMode(mode) => Some(task.stages[task.stage_of(mode)?].fails),
    }
}

/// What is drawn from a stream of its own, so that it stays as it is when an asset changes that it does not rest on.
#[derive(Clone, Copy)]
enum Stream {
    People = 1,
    Paths,
    Simulation,
    Operation,
}

impl Stream {
    fn open(self, (seed, number): (u64, u64)) -> Random {
        Random::new(seed ^ ((self as u64) << 32), number)
    }
}

fn ledger(
    setup: &Setup,
    assets: &mut Assets,
    seed: (u64, u64),
) -> Result<(Vec<Evidence>, Vec<Cell>), String> {
    let level = Confidence::new(LEVEL).map_err(|error| error.to_string())?;
    let counted = experiments(setup, assets, seed, level)?;
    let calibrated = calibrate(assets, &counted);
    let mut ledger: Vec<Evidence> = rig_evidence(setup, assets, level)?.into_iter().collect();
    let mut cells = if setup.family == Family::Handover {
        Vec::new()
    } else {
        let (described, _) = described(setup, assets)?;
        of_paths(&described, assets, level, &mut Stream::Paths.open(seed))?
    };
    let mut campaign = |id: &str, stream: Stream, task: &Task, runs: usize| {
        let technique = match stream {
            Stream::Operation => Technique::Operation,
            Stream::People => Technique::Experiment,
            Stream::Paths => Technique::ModelChecking,
            Stream::Simulation => Technique::Simulation,
        };
        let mut random = stream.open(seed);
        let runs: Vec<Run> = (0..runs).map(|_| task.run(&mut random)).collect();
        let judges = Judges::new(task, &assets.forms, &assets.words)?;
        let judged = judges.judge(&runs, level)?;
        cells.extend(matrix::cells(id, technique, &judged, assets, level));
        let mut piece = piece(id, technique, judged.findings);
        piece.form_differences = judged.differences;
        Ok::<Evidence, String>(piece)
    };
    let simulator = assets.simulated(1.0);
    let mut simulation = campaign(
        ids::SIMULATION,
        Stream::Simulation,
        &simulator,
        setup.simulated,
    )?;
    simulation.calibrated = calibrated;
    let operation = match setup.recorded {
        0 => None,
        runs => Some(campaign(
            ids::OPERATION,
            Stream::Operation,
            &setup.truth,
            runs,
        )?),
    };
    let experiment = piece(ids::EXPERIMENT, Technique::Experiment, counted);
    let others: Vec<&Evidence> = [&experiment]
        .into_iter()
        .chain(&operation)
        .chain([&simulation])
        .collect();
    let formal = formal_evidence(setup, assets, seed.0, level, &others)?;
    ledger.extend([formal, simulation, experiment]);
    ledger.extend(operation);
    Ok((ledger, cells))
}

fn experiments(
    setup: &Setup,
    assets: &Assets,
    seed: (u64, u64),
    level: Confidence,
) -> Result<Vec<Finding>, String> {
    let people = setup
        .cohort
        .runs(&setup.truth, &mut Stream::People.open(seed));
    let places = assets.columns.iter().map(|place| Some(*place));
    let columns: Vec<(String, Option<usize>)> = assets.modes.iter().cloned().zip(places).collect();
    trials::findings(
        &people,
        setup.limit_steps,
        &columns,
        setup.cohort.told,
        level,
    )
}

fn levels() -> Result<Levels, String> {
    Levels::new(LEVEL, LEVEL).map_err(|error| error.to_string())
}

/// Sets the simulator's rate to what the experiments count, where that was planted; with what it was fitted to since.
fn calibrate(assets: &mut Assets, counted: &[Finding]) -> Vec<Calibration> {
    let mut all: Vec<Calibration> = assets.fitted.iter().map(calibration).collect();
    let Some(place) = assets.calibrated else {
        return all;
    };
    let subject = Subject::FailureMode(assets.modes[place].clone());
    let found = counted.iter().find(|finding| finding.subject == subject);
    if let Some(rate) = found.and_then(|finding| finding.measure.estimate()) {
        assets.simulator.stages[place].fails = rate;
    }
    all.push(Calibration {
        parameter: format!("{} of the simulator", assets.modes[place]),
        from: ids::EXPERIMENT.to_owned(),
        subject,
        chosen: false,
    });
    all
}

fn calibration(it: &SetTo) -> Calibration {
    Calibration {
        parameter: it.parameter.clone(),
        from: it.from.clone(),
        subject: Subject::FailureMode(it.mode.clone()),
        chosen: false,
    }
}

fn rig_evidence(
    setup: &Setup,
    assets: &Assets,
    level: Confidence,
) -> Result<Option<Evidence>, String> {
    let Some(rig) = &setup.rig else {
        return Ok(None);
    };
    let findings = assets.modes.iter().zip(rig).map(|(mode, sample)| {
        crate::judges::finding(Subject::FailureMode(mode.clone()), *sample, 0, level)
    });
    let mut rig = piece(
        ids::RIG,
        Technique::Experiment,
        findings.collect::<Result<_, _>>()?,
    );
    rig.intermediate = true;
    Ok(Some(rig))
}

/// The task that the formal model describes, and its constants that were set to tests of stages alone.
fn described(setup: &Setup, assets: &Assets) -> Result<(Task, Counted), String> {
    let mut task = assets.formal.clone();
    let mut counted = Vec::new();
    for (place, sample) in setup.rig.iter().flatten().enumerate() {
        let stage = &mut task.stages[place];
        let (parameter, is_complement) = setup.constant(place);
        // What was set to other counts since is so in the task.
        let is_set = assets.set_to.iter().any(|it| it.parameter == parameter);
        if sample.trials > 0 && stage.can_fail && !is_set {
            stage.fails = sample.successes as f64 / sample.trials as f64;
            let set_to = SetTo {
                parameter,
                is_complement,
                mode: stage.mode.clone(),
                from: ids::RIG.to_owned(),
            };
            let sample = of_constant(&set_to, *sample).map_err(|error| error.to_string())?;
            counted.push((set_to, sample.into()));
        }
    }
    Ok((task, counted))
}

/// The formal model's text, and its constants that were set to tests of stages alone.
///
/// # Errors
/// What is wrong with the text of the handover's model.
pub fn formal_text(setup: &Setup, assets: &Assets) -> Result<(String, Counted), String> {
    let (task, counted) = described(setup, assets)?;
    let text = match (&assets.formal_text, setup.family) {
        (Some(text), _) => text.clone(),
        (None, Family::Handover) => handover(&task)?,
        (None, Family::Corridor) => journey::model(&task)?,
        (None, _) => task.model(),
    };
    Ok((text, counted))
}

/// Constants that were set to counts, with what those are worth in independent trials.
pub type Counted = Vec<(SetTo, EffectiveSample)>;

/// The formal model with the constants that were set to tests of stages alone.
///
/// # Errors
/// What is wrong with the model's text.
pub fn counted_model(setup: &Setup, assets: &Assets) -> Result<Formal, String> {
    let (text, counted) = formal_text(setup, assets)?;
    let mut formal = Formal::new(text, &assets.vocabulary, &assets.forms)?;
    let counted = counted.into_iter();
    formal.counted = counted.map(|(it, worth)| (it.parameter, worth)).collect();
    Ok(formal)
}

/// The handover's model with the rates of `task`.
fn handover(task: &Task) -> Result<String, String> {
    let mut text = HANDOVER_MODEL.to_owned();
    for (it, stage) in HANDOVER.iter().zip(&task.stages) {
        let tree = parse_model(&text).tree;
        let edits = edit::set_constant(&tree, it.constant, &stage.fails.to_string());
        let edits = edits.map_err(|error| error.to_string())?;
        text = edit::apply(&text, &edits).map_err(|error| error.to_string())?;
    }
    Ok(text)
}

fn formal_evidence(
    setup: &Setup,
    assets: &Assets,
    seed: u64,
    level: Confidence,
    others: &[&Evidence],
) -> Result<Evidence, String> {
    let (text, mut counted) = formal_text(setup, assets)?;
    for it in &assets.set_to {
        counted.retain(|(old, _)| old.parameter != it.parameter);
        let subject = Subject::FailureMode(it.mode.clone());
        let piece = others.iter().find(|piece| piece.id == it.from);
        let finding = piece.and_then(|piece| piece.finding(&subject));
        if let Some(sample) = finding.and_then(|finding| worth(&finding.measure, it)) {
            counted.push((it.clone(), sample));
        }
    }
    let mut formal = Formal::new(text, &assets.vocabulary, &assets.forms)?;
    formal.counted = counted
        .iter()
        .map(|(it, sample)| (it.parameter.clone(), *sample))
        .collect();
    formal.methods.clone_from(&assets.methods);
    let mut piece = piece(
        ids::MODEL,
        Technique::ModelChecking,
        formal.findings(level, seed)?,
    );
    piece.calibrated = counted.iter().map(|(it, _)| calibration(it)).collect();
    Ok(piece)
}

/// What a constant that was set to them is the probability of.
fn of_constant(set_to: &SetTo, counts: Sample) -> Result<Sample, stats::StatsError> {
    match set_to.is_complement {
        true => Sample::new(counts.trials - counts.successes, counts.trials),
        false => Ok(counts),
    }
}

/// What counts are worth in independent trials.
fn worth(measure: &Measure, set_to: &SetTo) -> Option<EffectiveSample> {
    let Measure::Counts {
        count,
        trials,
        effective_trials,
        ..
    } = measure
    else {
        return None;
    };
    let sample = of_constant(set_to, Sample::new(*count, *trials).ok()?).ok()?;
    match effective_trials {
        Some(size) => EffectiveSample::at_size(sample, *size).ok(),
        None => Some(sample.into()),
    }
}

fn piece(id: &str, technique: Technique, findings: Vec<Finding>) -> Evidence {
    let (role, path) = match technique {
        Technique::ModelChecking => (AssetRole::SystemModel, "model.prism"),
        Technique::FaultTree => (AssetRole::SystemModel, "tree.dft"),
        Technique::Simulation => (AssetRole::SystemModel, "scenario.toml"),
        Technique::Experiment => (AssetRole::Data, "cohort.csv"),
        Technique::Operation => (AssetRole::Data, "recordings"),
    };
    Evidence {
        id: id.to_owned(),
        title: id.to_owned(),
        technique,
        tool: Tool {
            name: "corroborate-bench".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            settings: String::new(),
        },
        assets: vec![Asset {
            role,
            path: path.to_owned(),
            hash: String::new(),
        }],
        conditions: "typical use".into(),
        changed: String::new(),
        calibrated: Vec::new(),
        intermediate: false,
        published: false,
        reproduced_by: None,
        findings,
        form_differences: Vec::new(),
        description_gaps: Vec::new(),
        failures: Vec::new(),
        clusters: None,
        shared_rows: Vec::new(),
        common_texts: Vec::new(),
        shared_seeds: Vec::new(),
        undecided_at_random: None,
        alike_trials: None,
        lineage_questions: Vec::new(),
        inputs: String::new(),
    }
}
