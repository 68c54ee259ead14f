//! What fitting a simulator's parameters to counts gave: posterior, what the counts identify, and whether what was
//! held out is like reality. `corroborate calibrate` does the fitting; how is `campaign`'s business.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `calibrate --format json` prints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CalibrationReport {
    /// Version of this form.
    pub format: String,
    /// The physics engine with its version.
    pub engine: String,
    /// The evidence whose counts were to be reproduced.
    pub evidence: String,
    /// What the numbers rest on.
    pub guarantee: String,
    /// Episodes that the posterior rests on.
    pub episodes: u64,
    /// What the posterior's sample is worth in independent points.
    pub effective_size: f64,
    /// Level of the intervals.
    pub confidence: f64,
    /// What was fitted.
    pub parameters: Vec<ParameterReport>,
    /// Correlations of the parameters, row by row, on the scale of their priors.
    pub correlations: Vec<Vec<f64>>,
    /// Directions of the parameters, the least known first.
    pub directions: Vec<DirectionReport>,
    /// Ways to fail, fitted ones first.
    pub modes: Vec<ModeReport>,
    /// Groups of subjects, each predicted from the others.
    pub held_out_runs: Vec<HeldOutRunsReport>,
    /// Whether the fitted set was shown to be like reality in what was held
    /// out; the command's exit code follows from it.
    pub conclusion: Likeness,
    /// Why, in words.
    pub because: String,
    /// What it was made from.
    pub lineage: LineageReport,
    /// The fitted parameter set, as TOML.
    pub parameter_set: String,
}

/// What a fitted set was made from: with the same files, seed and engine it comes out again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LineageReport {
    /// The study's seed, as a text: readers round numbers beyond 2^53.
    pub seed: String,
    /// The file of the calibration and its hash (BLAKE3).
    pub calibration: FileReport,
    /// The tables that were counted, the scenario, and the parameters to begin with.
    pub files: Vec<FileReport>,
}

/// A file with its hash.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FileReport {
    /// The file, relative to the study where it is one of the study's.
    pub file: String,
    /// The hash of its content.
    pub hash: String,
}

/// One fitted parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ParameterReport {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: Option<String>,
    /// The keys that it sets.
    pub sets: Vec<String>,
    /// Lowest and highest value of the prior.
    pub prior: [f64; 2],
    /// The value of the fitted set.
    pub fitted: f64,
    /// The posterior's median.
    pub median: f64,
    /// Lower end of the credible interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// How much of the prior's variance is gone, on the prior's scale.
    pub contraction: f64,
    /// The posterior's standard deviation over the prior's, on the prior's scale.
    pub deviation_ratio: f64,
    /// Whether the counts say what it is: by the contraction, 0.8 and more,
    /// 0.5 to 0.8, and less.
    pub identifiability: Identification,
}

/// Whether counts say what a parameter is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Identification {
    /// At least 80 % of the prior's variance is gone.
    Identified,
    /// 50 % to 80 %.
    WeaklyIdentified,
    /// Less: the value is mostly the prior's.
    NotIdentified,
}

impl Identification {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Identified => "identified",
            Self::WeaklyIdentified => "weakly identified",
            Self::NotIdentified => "not identified",
        }
    }
}

/// What is shown of a difference between the fitted set and reality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Likeness {
    /// The difference is shown to be within the margin.
    Equivalent,
    /// There is a difference beyond chance.
    Different,
    /// Neither is shown.
    Undecided,
    /// Its counts were fitted, or it follows from what was: agreement shows
    /// nothing.
    Fit,
}

impl Likeness {
    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Equivalent => "equivalent",
            Self::Different => "different",
            Self::Undecided => "undecided",
            Self::Fit => "a fit",
        }
    }
}

/// A direction of the parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DirectionReport {
    /// How much of it each parameter is.
    pub loadings: Vec<f64>,
    /// Posterior variance over prior variance.
    pub variance_share: f64,
    /// Whether the counts say where in this direction the parameters are.
    pub identifiability: Identification,
}

/// One way to fail.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ModeReport {
    /// The requirement or failure mode.
    pub id: String,
    /// Whether it was kept out of the fit.
    pub held_out: bool,
    /// How often it occurred in the evidence.
    pub occurrences: u64,
    /// How often it could have.
    pub opportunities: u64,
    /// Occurrences that were fitted; of a held-out mode, those that were predicted.
    pub fitted_occurrences: u64,
    /// Their opportunities.
    pub fitted_opportunities: u64,
    /// Whether trials of one subject were allowed to be alike.
    pub by_subject: bool,
    /// The posterior mean of the correlation between trials of one subject.
    pub intraclass_correlation: Option<f64>,
    /// The predicted rate.
    pub predicted_rate: f64,
    /// Counts between which 95 % of the predictions of the fitted opportunities lie.
    pub predicted_low: u64,
    /// Upper end.
    pub predicted_high: u64,
    /// Two-sided predictive p-value of what was counted.
    pub predictive_p: Option<f64>,
    /// Probability of the surface's deviations from its episodes if it is right.
    pub surface_p: Option<f64>,
    /// Occurrences in the fitted set's episodes.
    pub check_occurrences: u64,
    /// Opportunities there.
    pub check_opportunities: u64,
    /// Fisher's exact p-value of fitted set against evidence, held-out runs included.
    pub check_p: f64,
    /// The difference that still counts as agreement.
    pub margin: f64,
    /// What the evidence's opportunities are worth in independent ones.
    pub effective_opportunities: f64,
    /// p-value of "fitted set and evidence differ by the margin or more".
    pub equivalence_p: Option<f64>,
    /// Of its occurrences in the simulated episodes, the share in which
    /// something fitted occurred, too. More than half, and it is no held-out
    /// quantity: it follows from what was fitted.
    pub derived_share: Option<f64>,
    /// What is shown.
    pub likeness: Likeness,
}

/// Runs that were predicted from those of the other subjects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HeldOutRunsReport {
    /// Whose runs.
    pub subjects: Vec<String>,
    /// Whether they were kept out of the fitted set, too; else each group is predicted in turn and
    /// the fitted set rests on all.
    pub fitted_set_without_them: bool,
    /// Their counts beside their predictions.
    pub predictions: Vec<PredictionReport>,
}

/// A way to fail in held-out runs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PredictionReport {
    /// The requirement or failure mode.
    pub id: String,
    /// How often it occurred there.
    pub occurrences: u64,
    /// How often it could have.
    pub opportunities: u64,
    /// Counts between which 95 % of the predictions lie.
    pub predicted_low: u64,
    /// Upper end.
    pub predicted_high: u64,
    /// Two-sided predictive p-value of what was counted.
    pub predictive_p: Option<f64>,
}
