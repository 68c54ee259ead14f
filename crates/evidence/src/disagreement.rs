//! Where two techniques part: a map of contexts that a search found.
//!
//! A context is a value for each declared parameter (how engaged the person is, how strong the pull). The search draws
//! regions where its first episodes suggest a difference between what a model predicts and what a simulation shows, and
//! decides each region by fresh episodes; how it does so is the searcher's business (`campaign::disagreement`).

use crate::{Asset, EpisodeFailures, Interval};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Contexts in which a model and a simulation part on a requirement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DisagreementMap {
    /// Version of this form.
    pub format: String,
    /// What the numbers are, and what they are not.
    pub statement: String,
    /// The requirement whose probability is compared.
    pub requirement: String,
    /// The piece of evidence whose formal model predicts.
    pub model: String,
    /// The piece of evidence whose simulation is run.
    pub simulation: String,
    /// The version of the physics engine.
    pub engine: String,
    /// What model, simulation and search rest on.
    pub assets: Vec<Asset>,
    /// The plan of the search: one of the assets.
    pub plan: String,
    /// The seed from which those of the episodes are drawn.
    pub seed: u64,
    /// Episodes that were allowed.
    pub budget: u64,
    /// Differences up to this one do not matter.
    pub margin: f64,
    /// Probability with which no region is wrongly decided, however often one looked.
    pub confidence: f64,
    /// Episodes that were run.
    pub episodes: u64,
    /// How many of them led to the regions; the others are fresh and decided.
    pub explored: u64,
    /// Simulated time of all episodes.
    pub simulated_secs: f64,
    /// Why it ended.
    pub ended: SearchEnd,
    /// The declared parameters of contexts.
    pub parameters: Vec<ContextParameter>,
    /// All contexts in regions: those that differ first, then the undecided, by the size of the
    /// difference.
    pub regions: Vec<ContextRegion>,
    /// The share of all contexts, by the declared distributions, in regions of each kind.
    pub shares: RegionShares,
    /// What the first episodes suggest, over the first two parameters; the
    /// others are at their nominal values. Estimates, not evidence.
    pub map: Vec<MapPlace>,
    /// Episodes that the robot's program or the simulator ended by failing; where that left the requirement
    /// undecided, they count in no region.
    #[serde(default)]
    pub failures: Vec<EpisodeFailures>,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SearchEnd {
    /// Every region is decided.
    Decided,
    /// All episodes of the budget were run.
    Budget,
    /// It was interrupted; what was found until then is given.
    Interrupted,
}

/// What became of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RegionOutcome {
    /// The simulation's rate differs from the prediction by more than the margin.
    Differs,
    /// Not enough episodes.
    Undecided,
    /// It differs by at most the margin.
    Agrees,
}

/// A parameter of contexts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContextParameter {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: Option<String>,
    /// Lowest and highest value.
    pub support: [f64; 2],
    /// The constants of the model that follow it.
    pub constants: Vec<String>,
}

/// Contexts that were tried together until they were decided, or the budget ended.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContextRegion {
    /// What became of it.
    pub decided: RegionOutcome,
    /// The values of each parameter in it.
    pub ranges: Vec<ContextRange>,
    /// Its share of all contexts.
    pub share: f64,
    /// The mean of the model's probabilities in it, by the sound method.
    pub predicted: f64,
    /// That mean is known to within this.
    pub predicted_error: f64,
    /// Fresh episodes in which the requirement held.
    pub successes: u64,
    /// Fresh episodes that were judged.
    pub trials: u64,
    /// The simulation's rate lies in this, whenever one looked.
    #[serde(flatten)]
    pub rate: Interval,
    /// Rate and prediction differ by at least this.
    pub sure_difference: f64,
    /// How probable a difference beyond the margin is (Jeffreys' posterior; estimated).
    pub chance_of_difference: f64,
    /// About how many more episodes would decide it; null when it is decided.
    pub further_episodes: Option<f64>,
}

/// The values of a parameter in a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContextRange {
    /// The parameter.
    pub parameter: String,
    /// Its lowest value there.
    pub low: f64,
    /// Its highest value there.
    pub high: f64,
    /// Whether these are all its values.
    pub all: bool,
    /// In words.
    pub in_words: String,
}

/// How much of all contexts is what.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RegionShares {
    /// In regions that differ.
    pub differs: f64,
    /// In regions that are undecided.
    pub undecided: f64,
    /// In regions that agree.
    pub agrees: f64,
}

/// A place of the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct MapPlace {
    /// Its parameters.
    pub parameters: BTreeMap<String, f64>,
    /// The model's probability.
    pub predicted: f64,
    /// The simulation's rate, as few episodes suggest it.
    pub simulated: f64,
    /// Standard deviation of that estimate.
    pub sd: f64,
}

impl ContextRegion {
    /// What tells the region from the others: the values of the parameters that do not vary over all their range in it.
    pub fn place(&self) -> String {
        let told = self.ranges.iter().filter(|range| !range.all);
        let told: Vec<String> = told
            .map(|range| format!("{} {}", range.parameter, range.in_words))
            .collect();
        match told.is_empty() {
            true => "all contexts".into(),
            false => told.join(", "),
        }
    }

    /// Rate and prediction differ by at most this.
    pub fn largest_difference(&self) -> f64 {
        let above = (self.rate.high - self.predicted).abs();
        above.max((self.predicted - self.rate.low).abs())
    }
}
