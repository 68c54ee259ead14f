//! Where model and bench part, for people.

use crate::technique::campaign::failures_in_words;
use diagnostic::counted;
use evidence::{ContextRegion, DisagreementMap, RegionOutcome, SearchEnd};
use std::fmt::{Result, Write};

/// For people.
pub fn as_text(map: &DisagreementMap) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write(map, &mut text);
    text
}

fn write(map: &DisagreementMap, text: &mut String) -> Result {
    let ended = match map.ended {
        SearchEnd::Decided => "every region is decided",
        SearchEnd::Budget => "the budget",
        SearchEnd::Interrupted => "interrupted",
    };
    writeln!(
        text,
        "Where {} and {} disagree on requirement {}; differences up to {} do not matter\n",
        map.model, map.simulation, map.requirement, map.margin
    )?;
    writeln!(
        text,
        "{} ({}), {:.0} s simulated: {} led to the regions, {} fresh ones decide; ended by: {ended}",
        counted(map.episodes, "episode"),
        map.engine,
        map.simulated_secs,
        map.explored,
        map.episodes - map.explored
    )?;
    for failures in &map.failures {
        writeln!(text, "{}", failures_in_words(failures))?;
    }
    if map.regions.is_empty() {
        writeln!(text, "\nNo region was drawn yet.")?;
    }
    for (decided, title) in [
        (RegionOutcome::Differs, "Differs"),
        (RegionOutcome::Undecided, "Undecided"),
        (RegionOutcome::Agrees, "Agrees"),
    ] {
        let of: Vec<&ContextRegion> = (map.regions.iter())
            .filter(|it| it.decided == decided)
            .collect();
        if !of.is_empty() {
            write_regions(text, title, &of)?;
        }
    }
    writeln!(
        text,
        "\nOf all contexts, {:.0} % lie in regions that differ, {:.0} % in ones that agree, {:.0} % in undecided ones.\n\
         With a probability of at least {} no region is wrongly decided.\n{}",
        100.0 * map.shares.differs,
        100.0 * map.shares.agrees,
        100.0 * map.shares.undecided,
        map.confidence,
        map.statement
    )
}

fn write_regions(text: &mut String, title: &str, regions: &[&ContextRegion]) -> Result {
    let widest = regions.iter().map(|it| it.place().chars().count()).max();
    let width = widest.unwrap_or(0);
    writeln!(
        text,
        "\n{title:<width$}    share   model       bench  rate              differ by"
    )?;
    for region in regions {
        let more = match region.further_episodes {
            Some(further) if further < 1e6 => format!(
                "; a difference has chance {:.2}, about {further:.0} more episodes decide",
                region.chance_of_difference
            ),
            _ => String::new(),
        };
        let bench = format!("{}/{}", region.successes, region.trials);
        writeln!(
            text,
            "  {:<width$}  {:>4.0} %  {:>6.3}  {bench:>10}  [{:.3}, {:.3}]    {:.2} to {:.2}{more}",
            region.place(),
            100.0 * region.share,
            region.predicted,
            region.rate.low,
            region.rate.high,
            region.sure_difference,
            region.largest_difference()
        )?;
    }
    Ok(())
}
