//! What a search for disagreement gives: the form of `disagreement.json`.

use super::{Disagreement, Spent};
use crate::study::BenchFiles;
use campaign::{Agreement, DisagreementSearch, Finding, MapCell};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use stimulus::{Point, Space};

/// Said with a search for disagreement.
const STATEMENT: &str = "The regions were drawn where episodes of their own had suggested a difference; what is said of a \
    region rests on fresh episodes alone, in contexts drawn from the declared distributions. A region is decided as a \
    whole: what differs in one that agrees on average is not ruled out.";

/// Where the formal model and the bench part.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DisagreementReport {
    /// Version of this form.
    pub format: String,
    /// What the numbers are, and what they are not.
    pub statement: String,
    /// What was run.
    pub bench: BenchFiles,
    /// The version of the physics engine.
    pub engine: String,
    /// The requirement whose probability is compared.
    pub requirement: String,
    /// The ledger's entry whose formal model predicts.
    pub model: String,
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
    pub ended: Ended,
    /// The declared parameters of contexts.
    pub parameters: Vec<ParameterReport>,
    /// All contexts in regions: those that differ first, then the undecided, by the size of the
    /// difference.
    pub regions: Vec<RegionReport>,
    /// The share of all contexts, by the declared distributions, in regions of each kind.
    pub shares: SharesReport,
    /// What the first episodes suggest, over the first two parameters; the
    /// others are at their nominal values. Estimates, not evidence.
    pub map: Vec<MapReport>,
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Ended {
    /// Every region is decided.
    Decided,
    /// All episodes of the budget were run.
    Budget,
    /// It was interrupted; what was found until then is given.
    Interrupted,
}

/// What became of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Decided {
    /// The bench's rate differs from the prediction by more than the margin.
    Differs,
    /// Not enough episodes.
    Undecided,
    /// It differs by at most the margin.
    Agrees,
}

/// A parameter of contexts.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ParameterReport {
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
#[derive(Debug, Serialize, JsonSchema)]
pub struct RegionReport {
    /// What became of it.
    pub decided: Decided,
    /// The values of each parameter in it.
    pub ranges: Vec<RangeReport>,
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
    /// The bench's rate is at least this, whenever one looked.
    pub low: f64,
    /// The bench's rate is at most this.
    pub high: f64,
    /// Rate and prediction differ by at least this.
    pub sure_difference: f64,
    /// How probable a difference beyond the margin is (Jeffreys' posterior; estimated).
    pub chance_of_difference: f64,
    /// About how many more episodes would decide it; null when it is decided.
    pub further_episodes: Option<f64>,
}

/// The values of a parameter in a region.
#[derive(Debug, Serialize, JsonSchema)]
pub struct RangeReport {
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
#[derive(Debug, Default, Serialize, JsonSchema)]
pub struct SharesReport {
    /// In regions that differ.
    pub differs: f64,
    /// In regions that are undecided.
    pub undecided: f64,
    /// In regions that agree.
    pub agrees: f64,
}

/// A place of the map.
#[derive(Debug, Serialize, JsonSchema)]
pub struct MapReport {
    /// Its parameters.
    pub parameters: BTreeMap<String, f64>,
    /// The model's probability.
    pub predicted: f64,
    /// The bench's rate, as few episodes suggest it.
    pub simulated: f64,
    /// Standard deviation of that estimate.
    pub sd: f64,
}

/// What a search found.
pub(super) fn report(
    of: &Disagreement<'_>,
    search: &DisagreementSearch,
    map: &[MapCell],
    spent: Spent,
) -> DisagreementReport {
    let space = &of.contexts.space;
    let findings = search.findings();
    let regions: Vec<RegionReport> = findings.iter().map(|f| region(f, space)).collect();
    DisagreementReport {
        format: "1.0".into(),
        statement: STATEMENT.into(),
        bench: of.bench.files.clone(),
        engine: of.bench.engine.clone(),
        requirement: of.data.requirement.clone(),
        model: of.formal.entry.clone(),
        margin: of.options.margin,
        confidence: of.options.confidence,
        episodes: spent.episodes,
        explored: spent.episodes.min(search.explored() as u64),
        simulated_secs: spent.simulated_secs,
        ended: match (spent.is_interrupted, search.is_over()) {
            (true, _) => Ended::Interrupted,
            (_, true) => Ended::Decided,
            _ => Ended::Budget,
        },
        parameters: parameters(of),
        shares: shares(&regions),
        regions,
        map: map.iter().map(|cell| place(cell, space)).collect(),
    }
}

fn parameters(of: &Disagreement<'_>) -> Vec<ParameterReport> {
    let declared = of.contexts.space.parameters.iter();
    let report = declared.map(|parameter| {
        let constants = of.data.constant.iter();
        let constants = constants.filter(|c| c.parameter == parameter.name);
        ParameterReport {
            name: parameter.name.clone(),
            unit: parameter.unit.clone(),
            support: parameter.distribution.support(),
            constants: constants.map(|c| c.name.clone()).collect(),
        }
    });
    report.collect()
}

fn region(finding: &Finding, space: &Space) -> RegionReport {
    RegionReport {
        decided: match finding.agreement {
            Agreement::Differs => Decided::Differs,
            Agreement::Undecided => Decided::Undecided,
            Agreement::Agrees => Decided::Agrees,
        },
        ranges: ranges(finding, space),
        share: finding.region.share(),
        predicted: finding.predicted,
        predicted_error: finding.predicted_error,
        successes: finding.sample.successes,
        trials: finding.sample.trials,
        low: finding.interval.low,
        high: finding.interval.high,
        sure_difference: finding.sure_difference,
        chance_of_difference: finding.chance,
        further_episodes: finding.further,
    }
}

fn ranges(finding: &Finding, space: &Space) -> Vec<RangeReport> {
    let ranges = finding.region.ranges(space).into_iter().enumerate();
    let report = ranges.zip(&space.parameters);
    report
        .map(|((index, [low, high]), parameter)| {
            let shown = |value: f64| parameter.shown(rounded(value));
            RangeReport {
                parameter: parameter.name.clone(),
                low,
                high,
                all: finding.region.is_whole_in(index),
                in_words: match low == high {
                    true => shown(low),
                    false => format!("{} to {}", rounded(low), shown(high)),
                },
            }
        })
        .collect()
}

/// To four digits: where a region ends is estimated.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn shares(regions: &[RegionReport]) -> SharesReport {
    let share = |decided: Decided| {
        let of = regions.iter().filter(|region| region.decided == decided);
        of.map(|region| region.share).sum()
    };
    SharesReport {
        differs: share(Decided::Differs),
        undecided: share(Decided::Undecided),
        agrees: share(Decided::Agrees),
    }
}

fn place(cell: &MapCell, space: &Space) -> MapReport {
    MapReport {
        parameters: named(space, &cell.context),
        predicted: cell.predicted,
        simulated: cell.simulated,
        sd: cell.sd,
    }
}

fn named(space: &Space, point: &Point) -> BTreeMap<String, f64> {
    let values = space.parameters.iter().zip(&point.0);
    values.map(|(p, value)| (p.name.clone(), *value)).collect()
}
