//! One synthetic study: its evidence, produced and compared by the code of the product.

use crate::family::{Family, HANDOVER, Setup};
use crate::fault::{Assets, Fault, Planted, Site, plant};
use crate::formal::{Formal, Question};
use crate::judges::Judges;
use crate::matrix::{self, half_step, of_paths};
use crate::random::Random;
use crate::requirements::id;
use crate::task::{Run, SPEED_LIMIT, Task};
use crate::trials;
use evidence::{
    Asset, AssetRole, Calibration, Cell, Comparison, Evidence, FailureMode, Finding, Influences,
    Levels, Matter, Requirement, Study, Subject, Suspect, Technique, Tool, compare, rank,
};
use stats::Confidence;

/// The level of every interval and of agreement.
pub const LEVEL: f64 = 0.95;

/// The largest difference that counts as agreement, and the tolerance of the first baseline.
pub const MARGIN: f64 = 0.05;

/// The formal model of the handover.
const HANDOVER_MODEL: &str =
    include_str!("../../../case-studies/handover/models/handover_v5.prism");

/// Labels of the handover, as its vocabulary binds them.
const HANDOVER_LABELS: &str = "label \"done\" = robotState=handoverSuccessful;
label \"reached_runtime_error\" = true;
label \"failed_runtime_error\" = robotState=motionError;
label \"reached_false_negative_pressure\" = pressureSensorState!=unset;
label \"failed_false_negative_pressure\" = pressureState=ok & pressureSensorState=notOk;
label \"reached_false_negative_location\" = locationSensorState!=unset;
label \"failed_false_negative_location\" = locationState=ok & locationSensorState=notOk;
label \"reached_grip_failure\" = robotState=GPLOk;
label \"failed_grip_failure\" = robotState=handoverUnsuccessful;
";

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
        let (mut assets, planted) = plant(fault, &mut setup, &mut random);
        let (evidence, cells) = ledger(&setup, &mut assets, seed, &mut random)?;
        let requirements = requirements(&assets);
        let failure_modes = failure_modes(&assets);
        let influences = Influences::learn(&evidence);
        let study = Study {
            requirements: &requirements,
            failure_modes: &failure_modes,
            evidence: &evidence,
            influences: &influences,
            levels: levels()?,
        };
        let comparisons = compare(&study);
        let half = assets.half_step.as_ref();
        let more = half.map(|half| half_step(&assets, half, seed, number, setup.simulated));
        let matter = Matter {
            requirements: &requirements,
            failure_modes: &failure_modes,
            evidence: &evidence,
            comparisons: &comparisons,
            cells: &cells,
            study: "synthetic",
        };
        let suspects = rank(&matter, more.unwrap_or_default());
        Ok(Self {
            setup,
            assets,
            planted,
            evidence,
            comparisons,
            suspects,
        })
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

fn ledger(
    setup: &Setup,
    assets: &mut Assets,
    seed: u64,
    random: &mut Random,
) -> Result<(Vec<Evidence>, Vec<Cell>), String> {
    let level = Confidence::new(LEVEL).map_err(|error| error.to_string())?;
    let mut ledger = Vec::new();
    let people = setup.cohort.runs(&setup.truth, random);
    let columns: Vec<(String, Option<usize>)> = assets
        .modes
        .iter()
        .cloned()
        .zip(assets.columns.iter().map(|place| Some(*place)))
        .collect();
    let counted = trials::findings(
        &setup.truth,
        &people,
        setup.limit_steps,
        &columns,
        setup.cohort.by_subject,
        level,
    )?;
    if let Some(rig) = rig_evidence(setup, assets, level)? {
        ledger.push(rig);
    }
    ledger.push(formal_evidence(setup, assets, seed, level)?);
    let calibrated = calibrate(assets, &counted);
    let mut cells = if setup.family == Family::Handover {
        Vec::new()
    } else {
        of_paths(&assets.formal, assets, level, random)?
    };
    let judges = |task: &Task| Judges::new(task, &assets.forms, &assets.words);
    let mut campaign = |id: &str, technique, task: &Task, runs: usize| {
        let runs: Vec<Run> = (0..runs).map(|_| task.run(random)).collect();
        let judged = judges(task)?.judge(&runs, level)?;
        cells.extend(matrix::cells(id, technique, &judged, assets));
        let mut piece = piece(id, technique, judged.findings);
        piece.form_differences = judged.differences;
        Ok::<Evidence, String>(piece)
    };
    let mut simulation = campaign(
        ids::SIMULATION,
        Technique::Simulation,
        &assets.simulator,
        setup.simulated,
    )?;
    simulation.calibrated = calibrated;
    ledger.push(simulation);
    ledger.push(piece(ids::EXPERIMENT, Technique::Experiment, counted));
    if setup.recorded > 0 {
        ledger.push(campaign(
            ids::OPERATION,
            Technique::Operation,
            &setup.truth,
            setup.recorded,
        )?);
    }
    Ok((ledger, cells))
}

fn levels() -> Result<Levels, String> {
    let levels = Levels::new(LEVEL, LEVEL).map_err(|error| error.to_string())?;
    Ok(levels.without_plans())
}

/// Sets the simulator's rate to what the experiments count, where that was planted.
fn calibrate(assets: &mut Assets, counted: &[Finding]) -> Vec<Calibration> {
    let Some(place) = assets.calibrated else {
        return Vec::new();
    };
    let subject = Subject::FailureMode(assets.modes[place].clone());
    let found = counted.iter().find(|finding| finding.subject == subject);
    if let Some(rate) = found.and_then(|finding| finding.measure.estimate()) {
        assets.simulator.stages[place].fails = rate;
    }
    vec![Calibration {
        parameter: format!("{} of the simulator", assets.modes[place]),
        from: ids::EXPERIMENT.to_owned(),
        subject,
    }]
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

fn formal_evidence(
    setup: &Setup,
    assets: &Assets,
    seed: u64,
    level: Confidence,
) -> Result<Evidence, String> {
    let mut task = assets.formal.clone();
    let mut counted = Vec::new();
    let mut calibrated = Vec::new();
    for (place, sample) in setup.rig.iter().flatten().enumerate() {
        let stage = &mut task.stages[place];
        if sample.trials > 0 && stage.mode == assets.modes[place] {
            stage.fails = sample.successes as f64 / sample.trials as f64;
            let parameter = format!("p_{}", stage.mode);
            counted.push((parameter.clone(), *sample));
            calibrated.push(Calibration {
                parameter,
                from: ids::RIG.to_owned(),
                subject: Subject::FailureMode(stage.mode.clone()),
            });
        }
    }
    let mut formal = if setup.family == Family::Handover {
        handover(&task, assets)
    } else {
        Formal::of_task(&task, &assets.forms, &assets.modes)?
    };
    formal.counted = counted;
    formal.methods.clone_from(&assets.methods);
    let mut piece = piece(
        ids::MODEL,
        Technique::ModelChecking,
        formal.findings(level, seed)?,
    );
    piece.calibrated = calibrated;
    Ok(piece)
}

/// The handover's model with the rates of `task`.
fn handover(task: &Task, assets: &Assets) -> Formal {
    let constants = HANDOVER.iter().zip(&task.stages);
    let requirements = assets.forms.iter().map(|form| Question {
        subject: Subject::Requirement(form.id.to_owned()),
        property: (form.id == id::DONE).then(|| ("P=? [ F \"done\" ]".to_owned(), None)),
    });
    let modes = assets.modes.iter().map(|mode| {
        let asked = |label: &str| format!("P=? [ F \"{label}_{mode}\" ]");
        Question {
            subject: Subject::FailureMode(mode.clone()),
            property: Some((asked("failed"), Some(asked("reached")))),
        }
    });
    Formal {
        text: HANDOVER_MODEL.to_owned(),
        labels: HANDOVER_LABELS.to_owned(),
        constants: constants
            .map(|((_, name, _), stage)| ((*name).to_owned(), stage.fails))
            .collect(),
        counted: Vec::new(),
        questions: requirements.chain(modes).collect(),
        methods: assets.methods.clone(),
    }
}

fn piece(id: &str, technique: Technique, findings: Vec<Finding>) -> Evidence {
    let (role, path) = match technique {
        Technique::ModelChecking => (AssetRole::SystemModel, "model.prism"),
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
        clusters: None,
        inputs: String::new(),
    }
}

fn requirements(assets: &Assets) -> Vec<Requirement> {
    let forms = assets.forms.iter();
    forms
        .map(|form| Requirement {
            id: form.id.to_owned(),
            text: form.sentence.clone(),
            threshold: None,
            sentence: Some(form.sentence.clone()),
            property: form.property.clone(),
            monitor: form.monitor.clone(),
            margin: MARGIN,
            same_quantity_as: None,
        })
        .collect()
}

fn failure_modes(assets: &Assets) -> Vec<FailureMode> {
    let modes = assets.modes.iter();
    modes
        .map(|mode| FailureMode {
            id: mode.clone(),
            name: mode.clone(),
            meaning: "Counted against the runs that reach its stage.".into(),
            margin: MARGIN,
        })
        .collect()
}
