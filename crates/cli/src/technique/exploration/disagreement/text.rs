//! Where model and bench part, for people.

use super::report::{Decided, DisagreementReport, Ended, RegionReport};
use std::fmt::{Result, Write};

impl DisagreementReport {
    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> Result {
        let ended = match self.ended {
            Ended::Decided => "every region is decided",
            Ended::Budget => "the budget",
            Ended::Interrupted => "interrupted",
        };
        writeln!(
            text,
            "Where {} and {} part on requirement {}; differences up to {} do not matter\n",
            self.model, self.bench.evidence, self.requirement, self.margin
        )?;
        writeln!(
            text,
            "{} episodes ({}), {:.0} s simulated: {} led to the regions, {} fresh ones decide; ended by: {ended}",
            self.episodes,
            self.engine,
            self.simulated_secs,
            self.explored,
            self.episodes - self.explored
        )?;
        if self.regions.is_empty() {
            writeln!(text, "\nNo region was drawn yet.")?;
        }
        for (decided, title) in [
            (Decided::Differs, "Differs"),
            (Decided::Undecided, "Undecided"),
            (Decided::Agrees, "Agrees"),
        ] {
            let of: Vec<&RegionReport> = (self.regions.iter())
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
            100.0 * self.shares.differs,
            100.0 * self.shares.agrees,
            100.0 * self.shares.undecided,
            self.confidence,
            self.statement
        )
    }
}

fn write_regions(text: &mut String, title: &str, regions: &[&RegionReport]) -> Result {
    let widest = regions.iter().map(|it| place(it).chars().count()).max();
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
            "  {:<width$}  {:>4.0} %  {:>6.3}  {bench:>10}  [{:.3}, {:.3}]    {}{more}",
            place(region),
            100.0 * region.share,
            region.predicted,
            region.low,
            region.high,
            differ_by(region)
        )?;
    }
    Ok(())
}

/// At least and at most.
fn differ_by(region: &RegionReport) -> String {
    let most = (region.high - region.predicted)
        .abs()
        .max((region.predicted - region.low).abs());
    format!("{:.2} to {most:.2}", region.sure_difference)
}

/// What tells a region from the others.
fn place(region: &RegionReport) -> String {
    let told = region.ranges.iter().filter(|range| !range.all);
    let told: Vec<String> = told
        .map(|range| format!("{} {}", range.parameter, range.in_words))
        .collect();
    match told.is_empty() {
        true => "all contexts".into(),
        false => told.join(", "),
    }
}
