//! Suspects: assets that explain disagreements, ranked; and the matrix of cells they follow from.

use super::strength::STRONG;
use crate::{Inaccuracy, Interval, Subject};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The name of a figure: the probability that an asset is the odd one out of a conflict.
pub(super) const ODD_ONE_OUT: &str = "probability of being the odd one out";

/// What was changed in episodes that were run again with half the time step ([`Symptom::RunsOtherwise`]).
pub const HALF_STEP: &str = "half the time step";

/// What kind of thing is suspected.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum SuspectKind {
    /// A formal model.
    FormalModel,
    /// A scenario, a scene or its parameters.
    Simulation,
    /// Tables or recordings of experiments or operation.
    Data,
    /// A logical property.
    Property,
    /// An assertion monitor, a formula for traces, or a reading.
    Monitor,
    /// A word of the vocabulary, bound otherwise to models than to traces.
    Vocabulary,
    /// A method of the model checker.
    Solver,
    /// A physics engine.
    Engine,
    /// The time step of a simulation.
    TimeStep,
    /// How long a step of the formal models, or the mission of a fault tree, takes.
    TimeScale,
}

/// What is suspected: a file, or a named part of one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
pub struct SuspectAsset {
    /// What kind of thing it is.
    pub kind: SuspectKind,
    /// Path relative to the study's folder, with `/` between folders; `None` for tools.
    pub file: Option<String>,
    /// Which part of it: a requirement's form (`requirement 3, monitor`), a method of the checker.
    pub part: Option<String>,
    /// The evidence that rests on it, in the ledger's order.
    pub evidence: Vec<String>,
    /// Other files of the same evidence: what was shown does not tell them apart from `file`.
    #[serde(default)]
    pub together: Vec<String>,
    /// The line of `file` that is to be looked at, from 1, where one is known.
    #[serde(default)]
    pub line: Option<u32>,
}

impl SuspectAsset {
    /// File, line and part for people.
    #[must_use]
    pub fn place_in_words(&self) -> String {
        let file = self.file.as_ref().map(|file| match self.line {
            Some(line) => format!("{file}:{line}"),
            None => file.clone(),
        });
        let words = [file, self.part.clone()];
        let words: Vec<String> = words.into_iter().flatten().collect();
        words.join(", ")
    }

    /// What cannot be told apart from it, for people.
    #[must_use]
    pub fn together_in_words(&self) -> Option<String> {
        let files = &self.together;
        (!files.is_empty()).then(|| {
            format!(
                "not distinguishable from it: {} (the same evidence depends on them)",
                files.join(", ")
            )
        })
    }
}

/// What is wrong, for programs. Identifiers are those of the study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Symptom {
    /// A failure mode occurs elsewhere, and the asset cannot express it.
    MissingMode {
        /// The failure mode.
        mode: String,
        /// The evidence that shows it, the most telling first: identifier, occurrences, opportunities.
        shown: Vec<(String, u64, u64)>,
    },
    /// A rate differs from that of other evidence.
    RateDiffers {
        /// Of what.
        subject: Subject,
        /// The asset's own evidence.
        evidence: String,
        /// What it says.
        value: f64,
        /// The others that share a rate: identifier, count, trials; computed values have no counts.
        others: Vec<(String, u64, u64)>,
    },
    /// Two forms of a requirement judge the same runs otherwise.
    FormsDiffer {
        /// The requirement or failure mode.
        subject: Subject,
        /// The form that is suspected.
        form: String,
        /// The form that it was held against.
        reference: String,
        /// On whose runs.
        evidence: String,
        /// On how many runs they differ.
        differing: u64,
        /// Of how many.
        runs: u64,
    },
    /// A form's limit is not the declared one, or a model's constant not the counts that it is said to be set to.
    Drifted {
        /// The requirement, or what the constant is the rate of.
        subject: Subject,
        /// The form (`property`, `monitor`, or a reading's name), or the constant's name.
        form: String,
        /// What is declared, in words.
        required: String,
        /// What it has, in words.
        found: String,
    },
    /// An event of the simulator or of a recording has no counterpart in the model.
    UnmodelledEvent {
        /// The propositions that hold before it.
        from: Vec<String>,
        /// Those that hold after it; `None` if the run ended where the model cannot stay.
        to: Option<Vec<String>>,
        /// The evidence whose runs show it.
        evidence: String,
        /// Runs that show it.
        runs: u64,
        /// Of how many.
        of: u64,
    },
    /// One value of a requirement model, replaced, makes pieces agree, and nothing else disagree.
    EditExplains {
        /// The requirement or failure mode on which they agree then.
        subject: Subject,
        /// What stands in the file.
        found: String,
        /// What stands there if they agree.
        instead: String,
        /// The pairs of evidence that agree then.
        pairs: Vec<[String; 2]>,
        /// The part of the disagreement that it takes from other suspects.
        share: f64,
    },
    /// One row of a table differs from all others.
    RowDiffers {
        /// Of what.
        subject: Subject,
        /// The evidence.
        evidence: String,
        /// The row's name: a person, a session, a day.
        row: String,
        /// Its violations or occurrences, and its trials.
        own: [u64; 2],
        /// Those of all other rows together.
        others: [u64; 2],
    },
    /// A table counts more trials than there were attempts, of what a run is asked once.
    MoreThanAttempts {
        /// Of what.
        subject: Subject,
        /// The evidence.
        evidence: String,
        /// The trials that its row counts.
        trials: u64,
        /// The attempts.
        attempts: u64,
    },
    /// A solver's answer lies outside the bounds of a sound one.
    SolverStopped {
        /// Of what.
        subject: Subject,
        /// The method in doubt.
        method: String,
        /// Its answer.
        value: f64,
        /// The method whose bounds hold.
        sound: String,
        /// Its answer.
        sound_value: f64,
    },
    /// The answer computed and the paths sampled of one model do not agree.
    SampledOtherwise {
        /// Of what.
        subject: Subject,
        /// The computed answer.
        computed: f64,
        /// Sampled paths on which it holds.
        count: u64,
        /// Of how many.
        paths: u64,
    },
    /// A property has one truth value on all runs of a model, whatever its commands do, where others counted both.
    SaysNothing {
        /// Of what.
        subject: Subject,
        /// The model's evidence.
        evidence: String,
        /// The truth value.
        truth: bool,
        /// The evidence that counted both: identifier, count, trials.
        other: (String, u64, u64),
    },
    /// The same episodes come out otherwise with a shorter step or in another engine.
    RunsOtherwise {
        /// Of what.
        subject: Subject,
        /// What was changed: [`HALF_STEP`], or the other engine's name.
        changed: String,
        /// Episodes that were violated (or a failure mode's occurrences) before and after.
        violated: [u64; 2],
        /// Of how many.
        episodes: u64,
        /// Episodes with two verdicts.
        differing: u64,
    },
}

/// A number behind an argument.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Figure {
    /// What it is.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its interval, where it has one.
    pub interval: Option<Interval>,
}

/// A run that shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Witness {
    /// A recording's or a path's name.
    pub name: String,
    /// What to see in it, in one sentence.
    pub shows: String,
    /// The command that shows it again.
    pub replay: String,
}

/// An asset that explains disagreements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Suspect {
    /// Place in the list, from 1.
    pub rank: u32,
    /// Which of the three sources of disagreement it is.
    pub inaccuracy: Inaccuracy,
    /// The asset.
    pub asset: SuspectAsset,
    /// What it touches.
    pub subjects: Vec<Subject>,
    /// Disagreement that goes away if the asset is set aside: decimal logarithm of the Bayes factor
    /// for "they differ" against "they are the same". Above 2 is decisive by Jeffreys' scale.
    pub score: f64,
    /// What is wrong, as a headline.
    pub title: String,
    /// The argument, with figures.
    pub explanation: String,
    /// What is wrong, for programs.
    pub symptoms: Vec<Symptom>,
    /// The figures of the argument.
    pub figures: Vec<Figure>,
    /// Runs that show it.
    pub witnesses: Vec<Witness>,
    /// What was held against it and found not to be the reason, one sentence each.
    pub ruled_out: Vec<String>,
    /// The later evidence in which it is fixed, if it is.
    pub resolved_by: Option<String>,
}

impl Suspect {
    /// Whether nothing has fixed it yet.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.resolved_by.is_none()
    }

    /// Whether it differs only from evidence that its own evidence has taken the place of: then nothing of it was fixed.
    #[must_use]
    pub fn differs_from_what_it_replaced(&self) -> bool {
        let by = self.resolved_by.as_ref();
        self.inaccuracy == Inaccuracy::SystemModel
            && by.is_some_and(|by| self.asset.evidence.contains(by))
    }

    /// What has resolved it: words before the evidence that has, its identifier, and words behind it.
    #[must_use]
    pub fn resolution(&self) -> Option<(&'static str, &str, &'static str)> {
        let by = self.resolved_by.as_deref()?;
        Some(match self.differs_from_what_it_replaced() {
            true => ("from evidence that ", by, " replaces"),
            false => ("fixed in ", by, ""),
        })
    }

    /// Whether what speaks against it is strong evidence: [`STRONG`] or more.
    #[must_use]
    pub fn is_strong(&self) -> bool {
        self.score >= STRONG
    }

    /// The greatest probability that it is the odd one out of a conflict; none if it is suspected for something else.
    #[must_use]
    pub fn odd_one_out(&self) -> Option<f64> {
        let figures = self.figures.iter().filter(|f| f.name == ODD_ONE_OUT);
        figures.map(|f| f.value).max_by(f64::total_cmp)
    }
}

/// What is judged in a cell of the matrix.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Traces {
    /// Paths sampled from a formal model.
    Model,
    /// Episodes of a simulator.
    Simulator,
    /// Recordings of experiments or operation.
    Recordings,
}

/// By what it is judged.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum JudgedBy {
    /// The logical property, on finite traces.
    Property,
    /// The assertion monitor.
    Monitor,
}

/// A cell of the matrix: one requirement model on one source of traces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Cell {
    /// `A` to `F`: properties on model paths, episodes, recordings; then monitors on the same.
    #[schemars(with = "String")]
    pub cell: char,
    /// The traces.
    pub traces: Traces,
    /// The requirement model.
    pub judged_by: JudgedBy,
    /// The evidence whose assets gave the traces.
    pub evidence: String,
    /// The requirement or failure mode.
    pub subject: Subject,
    /// Requirement: traces that keep it. Failure mode: occurrences.
    pub count: u64,
    /// Traces that decide it; of a failure mode its opportunities.
    pub trials: u64,
    /// All traces.
    pub runs: u64,
    /// Traces that were cut short before a verdict.
    pub undecided: u64,
    /// Interval of the rate at the study's level; `None` without trials.
    pub interval: Option<Interval>,
    /// Why the cell is empty, if it is.
    pub not_judged: Option<String>,
}

impl Cell {
    /// The least and the greatest share that the traces can have: those that were cut short may all count, and may all
    /// not.
    #[must_use]
    pub fn shares(&self) -> [f64; 2] {
        let all = (self.trials + self.undecided).max(1) as f64;
        [self.count, self.count + self.undecided].map(|count| count as f64 / all)
    }

    /// The share of a completion that is nearest to a value.
    #[must_use]
    pub fn share_near(&self, value: f64) -> f64 {
        let [low, high] = self.shares();
        value.clamp(low, high)
    }
}

/// Two cells that differ in one asset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Contrast {
    /// The cells, such as `A-B`.
    pub cells: String,
    /// What differs between them.
    pub changed: Inaccuracy,
    /// The evidence of either cell.
    pub evidence: [String; 2],
    /// The requirement or failure mode.
    pub subject: Subject,
    /// p-value of "no difference": McNemar's exact test on the same traces, Fisher's otherwise.
    pub p_value: f64,
    /// Decimal logarithm of the Bayes factor for a difference.
    pub strength: f64,
    /// On the same traces: how many have two verdicts.
    pub differing: Option<u64>,
}

/// How much a diagnosis looked at.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Effort {
    /// Paths that were sampled from each formal model.
    pub paths: u64,
    /// Episodes that were run again with half the time step, if any.
    pub half_step: Option<u64>,
    /// Episodes that were run in the other engine, too, if any.
    pub engines: Option<u64>,
    /// Recordings of each simulation that were read for steps that models do not have; all, if not said.
    #[serde(default)]
    pub runs: Option<u64>,
}

/// What changing one asset at a time shows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Diagnosis {
    /// Hash of all that it was made from.
    pub inputs: String,
    /// How much was looked at.
    #[serde(default)]
    pub effort: Effort,
    /// The matrix.
    pub cells: Vec<Cell>,
    /// Pairs of cells that differ in one asset.
    pub contrasts: Vec<Contrast>,
    /// The suspects, the strongest first.
    pub suspects: Vec<Suspect>,
    /// What was looked at and found in order, one sentence each.
    pub in_order: Vec<String>,
    /// What could not be looked at, one sentence each.
    pub not_done: Vec<String>,
}
