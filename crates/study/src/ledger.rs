//! The ledger's entries: which evidence is to be produced, on which assets,
//! and whose counts those assets were set to.

mod parts;
mod read;
mod work;

use evidence::{Calibration, Finding};
use host::store::Inputs;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stats::{BetaPosterior, Confidence, EffectiveSample};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

pub use parts::{Parts, RecordingFiles, Simulated, TableFiles};
pub use read::load;
pub(crate) use read::schema;

/// A choice among words that files and calls use.
pub trait Choice: Copy + PartialEq + 'static {
    /// Each with its word and what it means, in the order in which they are offered.
    const CHOICES: &'static [(Self, &'static str, &'static str)];

    /// The word of this one.
    fn word(self) -> &'static str {
        let own = Self::CHOICES.iter().find(|(choice, ..)| *choice == self);
        own.map_or("", |(_, word, _)| word)
    }
}

/// An event of a fault tree, and of what it is the failure.
#[derive(Clone, Debug, Serialize)]
pub struct TreeEvent {
    /// The requirement that it violates, or the failure mode that it is.
    pub subject: evidence::Subject,
    /// Its name in the tree.
    pub event: String,
    /// Where the ledger names it.
    #[serde(skip)]
    pub span: Range<usize>,
}

/// One entry of the ledger.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Identifier.
    pub id: String,
    /// Short title.
    pub title: String,
    /// Under which conditions it holds: a key of the study's conditions.
    pub conditions: String,
    /// What was changed before it.
    pub changed: String,
    /// A step on the way to later evidence.
    pub intermediate: bool,
    /// The evidence of ours that reproduces this published evidence.
    pub reproduced_by: Option<String>,
    /// Whose counts its assets were set to.
    pub calibrated: Vec<Calibrated>,
    /// Changes of its texts that were chosen because then other evidence agrees.
    pub chosen: Vec<Calibration>,
    /// Why it is independent of evidence from which it looks copied.
    pub independent: Independent,
    /// Why its runs without a verdict may be left out, where the study declares that they are missing at random.
    pub undecided_at_random: Option<String>,
    /// Figures of the source publication.
    pub published: Published,
    /// How to produce it.
    pub work: Work,
    /// How its episodes are run, for simulations.
    pub sampling: Sampling,
}

impl Entry {
    /// The identifier from which its episodes' seeds are made: its own, or that of the entry whose seeds it uses.
    #[must_use]
    pub fn seeded_as(&self) -> &str {
        self.sampling.seeds.as_deref().unwrap_or(&self.id)
    }
}

/// Why evidence is independent of other evidence from which it looks copied: a reason for all of it, or for each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Independent {
    /// Of all.
    pub of_all: Option<String>,
    /// Of some, by their identifiers.
    pub of: BTreeMap<String, String>,
}

impl Independent {
    /// The reason why it is independent of this evidence, if one is given.
    pub fn reason(&self, of: &str) -> Option<&str> {
        self.of.get(of).or(self.of_all.as_ref()).map(String::as_str)
    }
}

/// How the episodes of a simulation are run.
#[derive(Clone, Debug, Default)]
pub struct Sampling {
    /// When to end before the last episode.
    pub until: Option<UntilText>,
    /// Which recordings are kept.
    pub keep: Keep,
    /// Whether an episode ends once all verdicts are determined.
    pub early_end: bool,
    /// What is done when an episode is ended by a failure.
    pub on_failure: OnFailure,
    /// The entry whose seeds it uses, if not its own.
    pub seeds: Option<String>,
}

impl Sampling {
    /// What results depend on.
    pub fn inputs(&self, inputs: &mut Inputs) {
        inputs
            .add_json("until", &self.until)
            .add_json("keep", &self.keep)
            .add_json("early_end", &self.early_end);
        // Results that counted failures are none where these are to end the campaign.
        if self.on_failure == OnFailure::Stop {
            inputs.add_json("on_failure", &self.on_failure);
        }
        if let Some(seeds) = &self.seeds {
            inputs.add("seeds", seeds.as_bytes());
        }
    }
}

/// A stopping rule as it is written.
#[derive(Clone, Debug, PartialEq, JsonSchema, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct UntilText {
    /// The requirement that is to be decided.
    pub requirement: String,
    /// The confidence in the decision, for example 0.99; against the requirement's own threshold the campaign goes on until its
    /// verdict can be given, too.
    pub confidence: f64,
    /// The rate against which it is decided, if not the requirement's own.
    pub threshold: Option<f64>,
}

/// What is done when the robot's program or the simulator ends an episode by failing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum OnFailure {
    /// It counts as what it is, and the campaign goes on.
    #[default]
    Count,
    /// The campaign ends there, with what the program said.
    Stop,
}

impl Choice for OnFailure {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Count,
            "count",
            "It counts as what it is, and the campaign goes on",
        ),
        (
            Self::Stop,
            "stop",
            "The campaign ends there, with what the program said",
        ),
    ];
}

/// The physics engine of a scene or of the handover.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PhysicsEngine {
    /// MuJoCo, a library that is fetched apart.
    #[default]
    Mujoco,
    /// Rapier, which is built in.
    Rapier,
}

impl PhysicsEngine {
    /// Whether it is the one that is meant where nothing is said.
    fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The other one of the two.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Mujoco => Self::Rapier,
            Self::Rapier => Self::Mujoco,
        }
    }
}

impl Choice for PhysicsEngine {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Mujoco,
            "mujoco",
            "MuJoCo, a library that is fetched apart",
        ),
        (Self::Rapier, "rapier", "Rapier, which is built in"),
    ];
}

/// Which recordings of episodes are kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, JsonSchema, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Keep {
    /// All, so that a changed monitor judges the same episodes again.
    #[default]
    All,
    /// Those in which a requirement is violated or a failure mode occurs.
    Violations,
    /// None; results are kept.
    None,
}

impl Choice for Keep {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::All,
            "all",
            "All, so that a changed monitor judges the same episodes again",
        ),
        (
            Self::Violations,
            "violations",
            "Those in which a requirement is violated or a failure mode occurs",
        ),
        (Self::None, "none", "None; results are kept"),
    ];
}

/// Another simulator, or a rig, as the ledger names it.
#[derive(Clone, Debug, Serialize)]
pub struct CommandText {
    /// The words of the command.
    pub command: Vec<String>,
    /// Files on which its episodes depend.
    pub assets: Vec<PathBuf>,
    /// What is done in each episode.
    pub stimulus: Option<PathBuf>,
    /// The extension of its recordings; empty for folders.
    pub leaves: String,
    /// The longest that an episode may take, in seconds of real time.
    pub limit_secs: f64,
    /// Whether a process takes many episodes, each by a line on its input.
    pub persistent: bool,
}

/// How a piece of evidence is produced. All that is serialized is part of what findings depend on.
#[derive(Clone, Debug, Serialize)]
pub enum Work {
    /// Check the properties of all requirements on a formal model.
    Check {
        /// The model's file, relative to the study.
        model: PathBuf,
        /// Methods; the first gives the answer that counts.
        methods: Vec<Method>,
    },
    /// Analyse events of a fault tree.
    FaultTree {
        /// The tree's file, relative to the study.
        tree: PathBuf,
        /// The time under way without repair, in the unit of its rates.
        mission_time: Option<f64>,
        /// Which of its events say something of what.
        events: Vec<TreeEvent>,
        /// Whether it speaks of the runs that trigger a subject alone; of all runs otherwise.
        is_triggered: bool,
    },
    /// Run seeded episodes of a simulation and judge them with the monitors.
    Simulate {
        /// The scenario's file, relative to the study.
        scenario: PathBuf,
        /// The parameter set's file, relative to the study.
        parameters: PathBuf,
        /// The physics engine. MuJoCo, the only one at first, is not written: what was found in it stays valid.
        #[serde(skip_serializing_if = "PhysicsEngine::is_default")]
        engine: PhysicsEngine,
        /// How many episodes.
        episodes: u64,
    },
    /// Run seeded episodes of a scene and judge them with the monitors.
    SimulateScene {
        /// The scene's file, relative to the study.
        scene: PathBuf,
        /// Which of its tests is enacted; the first if none is named.
        test: Option<String>,
        /// The physics engine.
        engine: PhysicsEngine,
        /// How many episodes.
        episodes: u64,
    },
    /// Run a command for each episode and judge the recording that it leaves.
    Command {
        /// Of a simulator or of a rig.
        technique: evidence::Technique,
        /// The command with all that belongs to it.
        command: CommandText,
        /// How many episodes.
        episodes: u64,
    },
    /// Read counts from tables.
    Read {
        /// Of the real robot or of published simulations.
        technique: evidence::Technique,
        /// Trials by subject.
        cohort: Option<PathBuf>,
        /// Verdicts by requirement.
        requirements: Option<PathBuf>,
        /// Occurrences by failure mode.
        failure_modes: Option<PathBuf>,
        /// Why the one subject of a cohort stands for all, where the study declares it.
        one_for_all: Option<String>,
        /// JUnit XML of runs: a folder or a file.
        #[serde(skip_serializing_if = "Option::is_none")]
        junit: Option<PathBuf>,
        /// Episodes of a learned policy: a file or a folder.
        #[serde(skip_serializing_if = "Option::is_none")]
        episodes: Option<PathBuf>,
        /// What makes episodes alike.
        #[serde(skip_serializing_if = "Option::is_none")]
        cluster: Option<String>,
        /// By requirement the test that verifies it.
        #[serde(skip_serializing_if = "BTreeMap::is_empty")]
        tests: BTreeMap<String, String>,
    },
    /// Judge recordings with the monitors; each is a trial.
    Judge {
        /// Of the robot at work, or of trials with it.
        technique: evidence::Technique,
        /// Their folder, relative to the study.
        recordings: PathBuf,
        /// Why recordings of the same messages are trials of their own, where the study declares it; else they may be one.
        #[serde(skip_serializing_if = "Option::is_none")]
        repeated: Option<String>,
    },
    /// What a technique does that is not built in: whoever runs the study brings it.
    Other {
        /// As whose evidence its findings count.
        technique: evidence::Technique,
        /// Its name.
        producer: String,
        /// Where the ledger names it.
        #[serde(skip)]
        span: Range<usize>,
        /// What it is told.
        with: toml::Table,
    },
}

/// A method of model checking.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Bounds that hold, to a relative width (for `check`: `--precision`).
    Sound,
    /// Rational arithmetic, without any rounding.
    Exact,
    /// The stopping rule of PRISM's default settings: an estimate.
    PrismDefault,
    /// Value iteration (power method) that stops when little changes: an estimate.
    ValueIteration,
    /// The same in place: an estimate.
    GaussSeidel,
    /// The same with self-loops divided out: an estimate.
    Jacobi,
    /// Policy iteration with some rounds for each policy: an estimate.
    ModifiedPolicyIteration,
    /// Policy iteration, each policy's chain solved by elimination: bounds that hold.
    PolicyIteration,
    /// Chains solved by elimination: bounds that hold.
    LinearEquations,
}

impl Choice for Method {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Sound,
            "sound",
            "Bounds that hold, to a relative width (for `check`: `--precision`)",
        ),
        (
            Self::Exact,
            "exact",
            "Rational arithmetic, without any rounding",
        ),
        (
            Self::PrismDefault,
            "prism-default",
            "The stopping rule of PRISM's default settings: an estimate",
        ),
        (
            Self::ValueIteration,
            "value-iteration",
            "Value iteration (power method) that stops when little changes: an estimate",
        ),
        (
            Self::GaussSeidel,
            "gauss-seidel",
            "The same in place: an estimate",
        ),
        (
            Self::Jacobi,
            "jacobi",
            "The same with self-loops divided out: an estimate",
        ),
        (
            Self::ModifiedPolicyIteration,
            "modified-policy-iteration",
            "Policy iteration with some rounds for each policy: an estimate",
        ),
        (
            Self::PolicyIteration,
            "policy-iteration",
            "Policy iteration, each policy's chain solved by elimination: bounds that hold",
        ),
        (
            Self::LinearEquations,
            "linear-equations",
            "Chains solved by elimination: bounds that hold",
        ),
    ];
}

impl Method {
    /// The checker's method.
    pub fn of_checker(self) -> checker::Method {
        match self {
            Method::Sound => checker::Method::Sound,
            Method::Exact => checker::Method::Exact,
            Method::PrismDefault => checker::Method::PrismDefault,
            Method::ValueIteration => checker::Method::ValueIteration,
            Method::GaussSeidel => checker::Method::GaussSeidel,
            Method::Jacobi => checker::Method::Jacobi,
            Method::ModifiedPolicyIteration => checker::Method::ModifiedPolicyIteration,
            Method::PolicyIteration => checker::Method::PolicyIteration,
            Method::LinearEquations => checker::Method::LinearEquations,
        }
    }

    /// The name of a method of the checker.
    pub fn name_of_checker(method: checker::Method) -> &'static str {
        let same = |own: &&Method| own.of_checker() == method;
        let own = Method::CHOICES.iter().map(|(own, ..)| own).find(same);
        own.unwrap_or(&Method::Sound).name()
    }

    /// Its name in evidence, reports and on the command line.
    pub fn name(self) -> &'static str {
        self.word()
    }
}

/// A number of the assets that was set to another evidence's count.
#[derive(Clone, Debug)]
pub struct Calibrated {
    /// As the evidence reports it.
    pub calibration: Calibration,
    /// The formal model's constant whose uncertainty is carried through; a
    /// held constant keeps its value.
    pub constant: Option<String>,
    /// Whether the constant keeps its value although it was estimated.
    pub held: bool,
    /// Whether the constant is 1 minus the counted rate: the probability that what was counted does not happen.
    pub is_complement: bool,
    /// Its place in the ledger.
    pub span: Range<usize>,
}

impl Calibrated {
    /// What the constant was set to, if the counts have this rate.
    pub fn value_of(&self, rate: f64) -> f64 {
        if self.is_complement { 1.0 - rate } else { rate }
    }

    /// What is known of the rate that the constant is the probability of; none if the finding that it was set to does
    /// not count. Trials that are alike count at their effective size, and runs without a verdict count both ways: the
    /// central interval at `level` reaches over all that they may have shown.
    pub fn posterior(&self, finding: &Finding, level: Confidence) -> Option<BetaPosterior> {
        let of_constant = |worth: EffectiveSample| match self.is_complement {
            true => worth.complement(),
            false => worth,
        };
        let ends: Option<Vec<BetaPosterior>> = finding
            .may_be()
            .map(|end| Some(BetaPosterior::jeffreys(of_constant(end.at_its_worth()?.1))))
            .collect();
        ends.map(|ends| BetaPosterior::spanning(&ends, level))
    }
}

/// Figures that the source publication prints.
#[derive(Clone, Debug, Default, JsonSchema, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// States of the model.
    pub states: Option<u64>,
    /// Transitions of the model.
    pub transitions: Option<u64>,
    /// The probability of the first requirement.
    pub success: Option<PublishedValue>,
    /// Values by requirement.
    #[serde(default)]
    pub requirements: BTreeMap<String, String>,
    /// What it took, in words.
    pub cost: Option<String>,
}

/// A printed probability.
#[derive(Clone, Debug, JsonSchema, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedValue {
    /// The method of ours that should give these digits.
    pub method: Method,
    /// The digits.
    pub value: String,
}
