//! What a search for disagreement gives: a map of contexts, as evidence.

use super::{Disagreement, Spent};
use crate::technique::campaign::FailureCounts;
use crate::technique::confidence;
use campaign::{Agreement, DisagreementSearch, Finding, MapCell};
use diagnostic::Problem;
use evidence::{
    ContextParameter, ContextRange, ContextRegion, DisagreementMap, Interval, MapPlace,
    RegionOutcome, RegionShares, SearchEnd,
};
use std::collections::BTreeMap;
use stimulus::{Point, Space};

/// Said with a search for disagreement.
const STATEMENT: &str = "The regions were drawn where episodes of their own had suggested a difference; what is said of a \
    region rests on fresh episodes alone, in contexts drawn from the declared distributions. A region is decided as a \
    whole: what differs in one that agrees on average is not ruled out.";

/// What a search found.
pub(super) fn report(
    of: &Disagreement<'_>,
    search: &DisagreementSearch,
    map: &[MapCell],
    spent: &Spent,
) -> Result<DisagreementMap, Problem> {
    let space = &of.contexts.space;
    let findings = search.findings();
    let regions: Vec<ContextRegion> = findings.iter().map(|f| region(f, space)).collect();
    let level = confidence(of.options.confidence)?;
    let failed = FailureCounts::of(spent.failed.iter().copied());
    Ok(DisagreementMap {
        format: "1.1".into(),
        statement: STATEMENT.into(),
        simulation: of.bench.files.evidence.clone(),
        assets: of.assets.clone(),
        plan: of.plan.clone(),
        seed: of.seed,
        budget: of.data.episodes,
        engine: of.bench.engine.clone(),
        requirement: of.data.requirement.clone(),
        model: of.formal.entry.clone(),
        margin: of.options.margin,
        confidence: of.options.confidence,
        episodes: spent.episodes,
        explored: spent.episodes.min(search.explored() as u64),
        simulated_secs: spent.simulated_secs,
        ended: match (spent.is_interrupted, search.is_over()) {
            (true, _) => SearchEnd::Interrupted,
            (_, true) => SearchEnd::Decided,
            _ => SearchEnd::Budget,
        },
        parameters: parameters(of),
        shares: shares(&regions),
        regions,
        map: map.iter().map(|cell| place(cell, space)).collect(),
        failures: failed.shares(level)?,
    })
}

fn parameters(of: &Disagreement<'_>) -> Vec<ContextParameter> {
    let declared = of.contexts.space.parameters.iter();
    let report = declared.map(|parameter| {
        let constants = of.data.constant.iter();
        let constants = constants.filter(|c| c.parameter == parameter.name);
        ContextParameter {
            name: parameter.name.clone(),
            unit: parameter.unit.clone(),
            support: parameter.distribution.support(),
            constants: constants.map(|c| c.name.clone()).collect(),
        }
    });
    report.collect()
}

fn region(finding: &Finding, space: &Space) -> ContextRegion {
    ContextRegion {
        decided: match finding.agreement {
            Agreement::Differs => RegionOutcome::Differs,
            Agreement::Undecided => RegionOutcome::Undecided,
            Agreement::Agrees => RegionOutcome::Agrees,
        },
        ranges: ranges(finding, space),
        share: finding.region.share(),
        predicted: finding.predicted,
        predicted_error: finding.predicted_error,
        successes: finding.sample.successes,
        trials: finding.sample.trials,
        rate: Interval {
            low: finding.interval.low,
            high: finding.interval.high,
        },
        sure_difference: finding.sure_difference,
        chance_of_difference: finding.chance,
        further_episodes: finding.further,
    }
}

fn ranges(finding: &Finding, space: &Space) -> Vec<ContextRange> {
    let ranges = finding.region.ranges(space).into_iter().enumerate();
    let report = ranges.zip(&space.parameters);
    report
        .map(|((index, [low, high]), parameter)| {
            let shown = |value: f64| parameter.shown(rounded(value));
            ContextRange {
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

fn shares(regions: &[ContextRegion]) -> RegionShares {
    let share = |decided: RegionOutcome| {
        let of = regions.iter().filter(|region| region.decided == decided);
        // The sum of nothing is -0.
        of.map(|region| region.share).sum::<f64>() + 0.0
    };
    RegionShares {
        differs: share(RegionOutcome::Differs),
        undecided: share(RegionOutcome::Undecided),
        agrees: share(RegionOutcome::Agrees),
    }
}

fn place(cell: &MapCell, space: &Space) -> MapPlace {
    MapPlace {
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
