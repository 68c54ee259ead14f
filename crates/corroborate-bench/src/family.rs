//! Families of studies: how their truth is drawn.

use crate::journey;
use crate::random::Random;
use crate::task::{Course, Stage, Task};
use crate::trials::{Cohort, Told};
use stats::Sample;

/// A family of studies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Family {
    /// One stage, which fails or not.
    Toy,
    /// Three to six stages in series with retries.
    Serial,
    /// The handover's last model, with rates about the published ones.
    Handover,
    /// The corridor's model, with rates that matter.
    Corridor,
}

impl Family {
    /// All families.
    pub const ALL: [Family; 4] = [
        Family::Toy,
        Family::Serial,
        Family::Handover,
        Family::Corridor,
    ];

    /// Whether its formal model is that of a case study, where a failure that is left out has the rate 0.
    #[must_use]
    pub fn is_case_study(self) -> bool {
        matches!(self, Family::Handover | Family::Corridor)
    }

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Family::Toy => "toy",
            Family::Serial => "serial",
            Family::Handover => "handover",
            Family::Corridor => "corridor",
        }
    }
}

/// What is true, and how it is looked at.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The family.
    pub family: Family,
    /// The truth.
    pub truth: Task,
    /// Steps in which a run has to be done.
    pub limit_steps: u32,
    /// Runs of the simulator.
    pub simulated: usize,
    /// The experiments.
    pub cohort: Cohort,
    /// Recorded runs of the robot at work; 0 for a study without.
    pub recorded: usize,
    /// Tests of each stage alone, from which the formal model's constants were set; `None` where they
    /// are known.
    pub rig: Option<Vec<Sample>>,
}

/// What the handover's model says of a failure mode.
#[derive(Clone, Copy, Debug)]
pub struct HandoverMode {
    /// The failure mode.
    pub mode: &'static str,
    /// The constant that decides it.
    pub constant: &'static str,
    /// Its published value.
    pub rate: f64,
    /// What it means over the model's variables.
    pub occurs: &'static str,
    /// What its opportunity means.
    pub after: &'static str,
}

/// The failure modes of the handover's model, as the study's vocabulary binds them.
pub const HANDOVER: [HandoverMode; 4] = [
    HandoverMode {
        mode: "runtime_error",
        constant: "pMotionFailure",
        rate: 0.002,
        occurs: "robotState=motionError",
        after: "true",
    },
    HandoverMode {
        mode: "false_negative_pressure",
        constant: "pPressureFN",
        rate: 0.071_428_571,
        occurs: "pressureState=ok & pressureSensorState=notOk",
        after: "pressureSensorState!=unset",
    },
    HandoverMode {
        mode: "false_negative_location",
        constant: "pLocationFN",
        rate: 0.030_612_245,
        occurs: "locationState=ok & locationSensorState=notOk",
        after: "locationSensorState!=unset",
    },
    HandoverMode {
        mode: "grip_failure",
        constant: "pGripperFailure",
        rate: 0.02,
        occurs: "robotState=handoverUnsuccessful",
        after: "robotState=GPLOk",
    },
];

impl Setup {
    /// Draws what is true.
    pub fn draw(family: Family, random: &mut Random) -> Self {
        let truth = truth(family, random);
        let limit_steps = match truth.course {
            Course::Stages => (truth.mean_steps() * random.between(1.2, 1.8)).ceil() as u32,
            Course::Journey => random.one_of(&[27, 28, 29]),
        };
        let has_rig = random.chance(0.2);
        let rig = has_rig.then(|| tests_of_stages(&truth, random));
        Self {
            family,
            limit_steps: limit_steps.max(3),
            simulated: random.one_of(&[50, 100, 200, 500, 1000]),
            cohort: Cohort {
                subjects: random.one_of(&[5, 10, 20, 40]),
                attempts: 10,
                correlation: random.one_of(&[0.0, 0.05, 0.1]),
                told: Told::Everything,
            },
            recorded: if random.chance(0.5) { 300 } else { 0 },
            rig,
            truth,
        }
    }

    /// Has each stage tested alone.
    pub fn count_constants(&mut self, random: &mut Random) {
        self.rig = Some(tests_of_stages(&self.truth, random));
    }

    /// The formal model's constant for a stage, and whether it says how often the stage is passed instead of how often
    /// it fails.
    #[must_use]
    pub fn constant(&self, place: usize) -> (String, bool) {
        match self.family {
            Family::Handover => (HANDOVER[place].constant.to_owned(), false),
            Family::Corridor => (journey::CONSTANTS[place].to_owned(), false),
            Family::Toy | Family::Serial => {
                let name = Task::constant(place, &self.truth.stages[place].mode);
                (name, Task::says_what_passes(place))
            }
        }
    }

    /// The failure modes of the truth.
    #[must_use]
    pub fn modes(&self) -> Vec<String> {
        self.truth
            .stages
            .iter()
            .map(|stage| stage.mode.clone())
            .collect()
    }
}

fn tests_of_stages(truth: &Task, random: &mut Random) -> Vec<Sample> {
    let stages = truth.stages.iter();
    stages.map(|stage| rig(stage.fails, random)).collect()
}

/// Tests of one stage alone.
fn rig(fails: f64, random: &mut Random) -> Sample {
    let trials = random.one_of(&[100, 300, 1000]);
    let successes = (0..trials).filter(|_| random.chance(fails)).count() as u64;
    Sample { successes, trials }
}

fn truth(family: Family, random: &mut Random) -> Task {
    let mut stage = |mode: String, low: f64, high: f64| Stage {
        mode,
        fails: round(random.log_between(low, high)),
        again: round(random.between(0.0, 0.5)),
        can_fail: true,
    };
    let stages: Vec<Stage> = match family {
        Family::Toy => vec![stage("slip".into(), 0.02, 0.4)],
        Family::Serial => {
            let mut stages: Vec<Stage> = (1..=6)
                .map(|i| stage(format!("mode_{i}"), 0.01, 0.2))
                .collect();
            let count = 3 + random.below(4);
            stages.truncate(count);
            stages
        }
        Family::Handover => HANDOVER
            .iter()
            .map(|it| stage(it.mode.into(), 0.5 * it.rate, 2.0 * it.rate))
            .collect(),
        Family::Corridor => journey::MODES
            .iter()
            .map(|(mode, ..)| stage((*mode).into(), 0.05, 0.4))
            .collect(),
    };
    let slow = random.between(0.8, 0.98);
    Task {
        course: match family {
            Family::Corridor => Course::Journey,
            _ => Course::Stages,
        },
        sensing: (stages.len().saturating_sub(2)).min(1),
        median_speed: Task::median_for(slow),
        stages,
    }
}

/// Rates have few digits, as in a model that somebody wrote.
#[must_use]
pub fn round(rate: f64) -> f64 {
    (rate * 1e5).round() / 1e5
}
