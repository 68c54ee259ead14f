//! The catalogue of faults, and how each is planted.

use crate::family::{Family, Setup, round};
use crate::random::Random;
use crate::requirements::{Forms, id, in_time, requirements};
use crate::study::MARGIN;
use crate::task::{Course, SPEED_LIMIT, Task};
use crate::trials::Told;
use crate::words::Words;
use checker::Method;
use evidence::Subject;

/// What is planted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fault {
    /// Nothing.
    None,
    /// A rate of the formal model or of the simulator is wrong.
    WrongRate,
    /// The formal model or the simulator lacks a failure mode.
    MissingMode,
    /// The formal model or the simulator has a failure mode that does not exist.
    ExtraBehaviour,
    /// The property says something else than the requirement.
    WrongProperty,
    /// The monitor does.
    WrongMonitor,
    /// A limit in the monitor or the property is another, or in another unit.
    DriftedLimit,
    /// The monitor reads the robot's sensor where the requirement speaks of the person.
    SensorForTruth,
    /// The monitor's clock is the wall's, while the simulation runs slower than time.
    WallClock,
    /// The solver stopped before it had the answer.
    SolverStopped,
    /// The simulator's time step is too large.
    LargeStep,
    /// Attempts of one person are much alike, and the tables do not say whose they are.
    ClusteredSubjects,
    /// The simulator was calibrated on the experiments that it is compared with.
    CalibratedOnSame,
    /// Two columns of the experiments' table have each other's name.
    MislabelledColumns,
}

impl Fault {
    /// All that is planted, nothing first.
    pub const ALL: [Fault; 14] = [
        Fault::None,
        Fault::WrongRate,
        Fault::MissingMode,
        Fault::ExtraBehaviour,
        Fault::WrongProperty,
        Fault::WrongMonitor,
        Fault::DriftedLimit,
        Fault::SensorForTruth,
        Fault::WallClock,
        Fault::SolverStopped,
        Fault::LargeStep,
        Fault::ClusteredSubjects,
        Fault::CalibratedOnSame,
        Fault::MislabelledColumns,
    ];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Fault::None => "nothing",
            Fault::WrongRate => "wrong rate",
            Fault::MissingMode => "missing failure mode",
            Fault::ExtraBehaviour => "extra behaviour",
            Fault::WrongProperty => "wrong clause in the property",
            Fault::WrongMonitor => "wrong clause in the monitor",
            Fault::DriftedLimit => "drifted threshold or unit",
            Fault::SensorForTruth => "sensor read instead of truth",
            Fault::WallClock => "wall clock for simulated time",
            Fault::SolverStopped => "solver stopped early",
            Fault::LargeStep => "time step too large",
            Fault::ClusteredSubjects => "clustered subjects",
            Fault::CalibratedOnSame => "calibration on the same data",
            Fault::MislabelledColumns => "mislabelled columns",
        }
    }

    /// Whether it makes pieces of evidence disagree. The others would make them agree, or seem to
    /// disagree, without a reason.
    #[must_use]
    pub fn is_conflict(self) -> bool {
        !matches!(
            self,
            Fault::None | Fault::ClusteredSubjects | Fault::CalibratedOnSame
        )
    }

    /// Whether a family has what this fault needs.
    #[must_use]
    pub fn fits(self, family: Family) -> bool {
        self.missing_in(family).is_none()
    }

    /// What a family lacks that this fault needs.
    #[must_use]
    pub fn missing_in(self, family: Family) -> Option<&'static str> {
        match (self, family) {
            (Fault::MislabelledColumns, Family::Toy) => {
                Some("none: one column has nothing to be exchanged with")
            }
            (Fault::WrongProperty | Fault::WrongMonitor, Family::Corridor) => {
                Some("none: every journey arrives, so to end is to be done")
            }
            (Fault::SensorForTruth, Family::Corridor) => {
                Some("none: every journey arrives, whatever is sensed")
            }
            (Fault::SolverStopped, Family::Handover | Family::Corridor) => {
                Some("none: the iteration on its model does not stop early")
            }
            _ => None,
        }
    }
}

/// Where a fault is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Site {
    /// The formal model.
    FormalModel,
    /// The simulator or its parameters.
    Simulation,
    /// The tables of the experiments, or recordings.
    Data,
    /// A property.
    Property,
    /// A monitor.
    Monitor,
    /// The solver.
    Solver,
    /// The simulator's time step.
    TimeStep,
}

/// A study's assets, one of which may have a fault.
#[derive(Clone, Debug)]
pub struct Assets {
    /// The task that the formal model describes.
    pub formal: Task,
    /// The task that is simulated.
    pub simulator: Task,
    /// The requirements' forms.
    pub forms: Vec<Forms>,
    /// Further words of the vocabulary.
    pub words: Vec<(&'static str, String)>,
    /// The failure modes that the study asks about.
    pub modes: Vec<String>,
    /// What they mean to formal models.
    pub vocabulary: Words,
    /// The stage that each column of the experiments' table counts.
    pub columns: Vec<usize>,
    /// How the formal model is solved.
    pub methods: Vec<Method>,
    /// The simulator's rate that was set to the experiments' count.
    pub calibrated: Option<usize>,
    /// What too large a time step adds to a rate.
    pub step: Option<StepError>,
    /// The formal model's text, where it is not that of `formal`.
    pub formal_text: Option<String>,
    /// Constants of that text that were set to counts since.
    pub set_to: Vec<SetTo>,
    /// The failure modes to whose counts the simulator was fitted since.
    pub fitted: Vec<SetTo>,
}

/// The error of a time step, which is proportional to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepError {
    /// The stage.
    pub place: usize,
    /// What is added to its rate.
    pub error: f64,
    /// The step as a part of that which the scene began with.
    pub step: f64,
}

/// A number that was set to counts.
#[derive(Clone, Debug, PartialEq)]
pub struct SetTo {
    /// The constant or parameter.
    pub parameter: String,
    /// The failure mode that was counted.
    pub mode: String,
    /// In which evidence.
    pub from: String,
    /// Whether it is 1 minus the counted rate.
    pub is_complement: bool,
}

/// What was planted.
#[derive(Clone, Debug)]
pub struct Planted {
    /// The fault.
    pub fault: Fault,
    /// Where it is; `None` for nothing.
    pub site: Option<Site>,
    /// The subjects on which it shows most directly.
    pub subjects: Vec<Subject>,
    /// For faults of forms: the probability that a run shows it to somebody who judges it by both.
    pub seen_in_a_run: Option<f64>,
}

fn requirement(id: &str) -> Subject {
    Subject::Requirement(id.to_owned())
}

impl Assets {
    /// Assets that describe the truth.
    #[must_use]
    pub fn sound(setup: &Setup) -> Self {
        Self {
            formal: setup.truth.clone(),
            simulator: setup.truth.clone(),
            forms: requirements(setup.limit_steps),
            words: Vec::new(),
            modes: setup.modes(),
            vocabulary: Words::new(setup.family, &setup.modes()),
            columns: (0..setup.truth.stages.len()).collect(),
            methods: vec![Method::Sound],
            calibrated: None,
            step: None,
            formal_text: None,
            set_to: Vec::new(),
            fitted: Vec::new(),
        }
    }

    /// What is simulated with this part of the time step.
    #[must_use]
    pub fn simulated(&self, part_of_step: f64) -> Task {
        let mut task = self.simulator.clone();
        if let Some(StepError { place, error, step }) = self.step {
            let stage = &mut task.stages[place];
            stage.fails = round((stage.fails + error * step * part_of_step).clamp(0.0, 0.9));
        }
        task
    }

    fn form(&mut self, id: &str) -> Option<&mut Forms> {
        self.forms.iter_mut().find(|form| form.id == id)
    }
}

/// Plants a fault: changes the truth where the fault needs it to be so, and one asset.
pub fn plant(fault: Fault, setup: &mut Setup, random: &mut Random) -> (Assets, Planted) {
    if fault == Fault::SolverStopped {
        // Slow to converge, for the iteration stops when it hardly moves.
        setup.truth.stages[0].again = round(random.between(0.97, 0.996));
        setup.limit_steps = (1.5 * setup.truth.mean_steps()).ceil() as u32;
    }
    let place = random.below(setup.truth.stages.len());
    if fault == Fault::MissingMode && setup.truth.stages[place].fails < 1.2 * MARGIN {
        // What is rarer may be left out: the study declares that it does not matter.
        setup.truth.stages[place].fails = round(random.between(1.2 * MARGIN, 0.2));
        setup.rig = None;
    }
    if fault == Fault::MislabelledColumns {
        let other = (place + 1) % setup.truth.stages.len();
        let apart = setup.truth.stages[place].fails + random.log_between(1.2 * MARGIN, 0.3);
        setup.truth.stages[other].fails = round(apart);
        setup.rig = None;
    }
    if fault == Fault::ExtraBehaviour {
        setup.truth.stages[place].fails = 0.0;
        setup.rig = None;
    }
    let mut assets = Assets::sound(setup);
    let mut planted = Planted {
        fault,
        site: None,
        subjects: Vec::new(),
        seen_in_a_run: None,
    };
    match fault {
        Fault::None => {}
        Fault::WrongRate | Fault::MissingMode | Fault::ExtraBehaviour | Fault::LargeStep => {
            of_system(place, setup, &mut assets, &mut planted, random);
        }
        Fault::WrongProperty | Fault::WrongMonitor => {
            of_clause(setup, &mut assets, &mut planted);
        }
        Fault::DriftedLimit => of_limit(setup, &mut assets, &mut planted, random),
        Fault::SensorForTruth => of_sensor(setup, &mut assets, &mut planted),
        Fault::WallClock => of_clock(setup, &mut assets, &mut planted, random),
        Fault::SolverStopped => {
            planted.site = Some(Site::Solver);
            planted.subjects = vec![requirement(id::DONE)];
            assets.methods = if random.chance(0.5) {
                vec![Method::Sound, Method::PrismDefault]
            } else {
                vec![Method::PrismDefault, Method::Sound]
            };
        }
        Fault::ClusteredSubjects => {
            setup.cohort.correlation = 0.3;
            setup.cohort.told = random.one_of(&Told::ALL);
        }
        Fault::CalibratedOnSame => assets.calibrated = Some(place),
        Fault::MislabelledColumns => of_columns(setup, &mut assets, &mut planted),
    }
    (assets, planted)
}

fn of_system(
    place: usize,
    setup: &mut Setup,
    assets: &mut Assets,
    planted: &mut Planted,
    random: &mut Random,
) {
    let formal = planted.fault != Fault::LargeStep && random.chance(0.5);
    let mode = setup.truth.stages[place].mode.clone();
    let rate = setup.truth.stages[place].fails;
    let change = random.log_between(1.2 * MARGIN, 0.3);
    let wrong = match planted.fault {
        Fault::MissingMode => 0.0,
        Fault::WrongRate if rate > change && random.chance(0.5) => rate - change,
        _ => (rate + change).min(0.9),
    };
    if planted.fault == Fault::LargeStep {
        // The error of the step is of first order: half of it is left at half the step.
        let error = wrong - rate;
        assets.step = Some(StepError {
            place,
            error,
            step: 1.0,
        });
    } else if formal {
        assets.formal.stages[place].fails = round(wrong);
        if planted.fault == Fault::MissingMode && !setup.family.is_case_study() {
            // The model has the stage, but no failure of it.
            assets.formal.stages[place].can_fail = false;
        }
    } else {
        assets.simulator.stages[place].fails = round(wrong);
    }
    if planted.fault == Fault::ExtraBehaviour && !formal && !setup.family.is_case_study() {
        assets.formal.stages[place].can_fail = false;
    }
    if formal && let Some(rig) = &mut setup.rig {
        // The constant is as wrong whether or not others were counted; it was counted nowhere.
        rig[place].trials = 0;
    }
    planted.site = Some(match (planted.fault, formal) {
        (Fault::LargeStep, _) => Site::TimeStep,
        (_, true) => Site::FormalModel,
        (_, false) => Site::Simulation,
    });
    planted.subjects = vec![Subject::FailureMode(mode), requirement(id::DONE)];
}

/// The clause that the last stage must not fail is forgotten: to end is taken for to be done.
fn of_clause(setup: &Setup, assets: &mut Assets, planted: &mut Planted) {
    let wrong = "The robot shall eventually satisfy finished.".to_owned();
    if let Some(form) = assets.form(id::DONE) {
        if planted.fault == Fault::WrongProperty {
            form.property = Some(wrong);
            planted.site = Some(Site::Property);
        } else {
            form.monitor = Some(wrong);
            planted.site = Some(Site::Monitor);
        }
    }
    planted.subjects = vec![requirement(id::DONE)];
    planted.seen_in_a_run = Some(1.0 - setup.truth.success());
}

fn of_limit(setup: &Setup, assets: &mut Assets, planted: &mut Planted, random: &mut Random) {
    let kind = random.below(3);
    if kind == 2 || setup.family == Family::Handover {
        // 250 mm/s as some other number, or as 250 cm/s.
        let factor = if random.chance(0.3) {
            10.0
        } else {
            random.log_between(1.1, 1.6)
        };
        let limit = round(SPEED_LIMIT * factor);
        assets
            .words
            .push(("slow_enough", format!("/run.speed < {limit} m/s")));
        if let Some(form) = assets.form(id::SLOW) {
            form.monitor =
                Some("When near, the robot shall immediately satisfy slow_enough.".into());
        }
        planted.site = Some(Site::Monitor);
        planted.subjects = vec![requirement(id::SLOW)];
        let truth = &setup.truth;
        let between = truth.slower_than(limit) - truth.slower_than(SPEED_LIMIT);
        planted.seen_in_a_run = Some(truth.success() * between);
        return;
    }
    let factor = if random.chance(0.3) {
        10.0
    } else {
        random.log_between(1.2, 2.5)
    };
    let drifted = (f64::from(setup.limit_steps) * factor).ceil() as u32;
    let is_property = kind == 1;
    if let Some(form) = assets.form(id::IN_TIME) {
        let text = Some(in_time(drifted));
        if is_property {
            form.property = text
        } else {
            form.monitor = text
        }
    }
    planted.site = Some(if is_property {
        Site::Property
    } else {
        Site::Monitor
    });
    planted.subjects = vec![requirement(id::IN_TIME)];
    planted.seen_in_a_run = Some(done_between(&setup.truth, setup.limit_steps, drifted));
}

fn of_sensor(setup: &Setup, assets: &mut Assets, planted: &mut Planted) {
    if let Some(form) = assets.form(id::READY) {
        form.monitor = Some("When sensed, the robot shall eventually satisfy done.".into());
    }
    planted.site = Some(Site::Monitor);
    planted.subjects = vec![requirement(id::READY)];
    let until = &setup.truth.stages[..=setup.truth.sensing];
    let sensed: f64 = until.iter().map(|stage| 1.0 - stage.fails).product();
    planted.seen_in_a_run = Some(1.0 - sensed);
}

fn of_clock(setup: &Setup, assets: &mut Assets, planted: &mut Planted, random: &mut Random) {
    let real_time = random.between(0.4, 0.9);
    if let Some(form) = assets.form(id::IN_TIME) {
        form.clock = 1.0 / real_time;
    }
    planted.site = Some(Site::Monitor);
    planted.subjects = vec![requirement(id::IN_TIME)];
    let limit = (f64::from(setup.limit_steps) * real_time + 1e-9).floor() as u32;
    planted.seen_in_a_run = Some(done_between(&setup.truth, limit, setup.limit_steps));
}

fn of_columns(setup: &Setup, assets: &mut Assets, planted: &mut Planted) {
    // Those two that differ most: of others nobody could tell.
    let rates = |i: usize| setup.truth.stages[i].fails;
    let order = |a: &usize, b: &usize| rates(*a).total_cmp(&rates(*b));
    let low = (0..setup.truth.stages.len()).min_by(order).unwrap_or(0);
    let high = (0..setup.truth.stages.len()).max_by(order).unwrap_or(0);
    assets.columns.swap(low, high);
    planted.site = Some(Site::Data);
    planted.subjects = [low, high]
        .map(|i| Subject::FailureMode(setup.truth.stages[i].mode.clone()))
        .into();
}

/// The probability that a run is done after `from` and within `to` steps, by convolution.
pub(crate) fn done_between(task: &Task, from: u32, to: u32) -> f64 {
    if task.course == Course::Journey {
        return crate::journey::done_between(task, from, to);
    }
    let mut at: Vec<f64> = vec![0.0; to as usize + 1];
    at[0] = 1.0;
    for stage in &task.stages {
        let mut next = vec![0.0; at.len()];
        for (steps, mass) in at.iter().enumerate().filter(|(_, mass)| **mass > 0.0) {
            let mut left = mass * (1.0 - stage.again) * (1.0 - stage.fails);
            for place in (steps + 1..next.len()).step_by(2) {
                next[place] += left;
                left *= stage.again;
            }
        }
        at = next;
    }
    at.iter().skip(from as usize + 1).sum()
}
