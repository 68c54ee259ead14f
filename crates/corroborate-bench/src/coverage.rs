//! Coverage: how often an interval of 95 % holds the truth, by kind of evidence.
//!
//! From each study in which nothing is planted one interval of each kind is taken at random, so that those
//! counted together are independent.

use crate::random::Random;
use crate::study::{Synthetic, ids};
use evidence::{Finding, Measure};

/// A kind of interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Counts of independent runs.
    Runs,
    /// Counts of people whose attempts are independent.
    People,
    /// Counts of people whose attempts are alike.
    AlikePeople,
    /// A model whose constants were counted.
    Model,
    /// The difference of two pieces of evidence.
    Difference,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 5] = [
        Kind::Runs,
        Kind::People,
        Kind::AlikePeople,
        Kind::Model,
        Kind::Difference,
    ];

    /// Its name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Kind::Runs => "simulation and operation: independent runs",
            Kind::People => "experiments: attempts independent",
            Kind::AlikePeople => "experiments: attempts of one person alike",
            Kind::Model => "model checking: constants counted",
            Kind::Difference => "difference of two techniques",
        }
    }
}

/// One interval of each kind that the study has, and whether the truth is in it.
#[must_use]
pub fn coverage(study: &Synthetic, random: &mut Random) -> Vec<(Kind, bool)> {
    let mut found: Vec<(Kind, bool)> = study
        .evidence
        .iter()
        .filter(|piece| !piece.intermediate && piece.id != ids::OPERATION)
        .filter_map(|piece| {
            let kind = match piece.id.as_str() {
                ids::SIMULATION => Kind::Runs,
                ids::MODEL => Kind::Model,
                _ if study.setup.cohort.correlation > 0.0 => Kind::AlikePeople,
                _ => Kind::People,
            };
            let random_findings: Vec<&Finding> =
                piece.findings.iter().filter(|f| has_interval(f)).collect();
            let finding = pick(&random_findings, random)?;
            let interval = finding.measure.interval()?;
            Some((kind, interval.contains(study.truth(&finding.subject)?)))
        })
        .collect();
    let with_interval: Vec<_> = study
        .comparisons
        .iter()
        .filter_map(|c| c.difference_interval)
        .collect();
    if let Some(interval) = pick(&with_interval, random) {
        found.push((Kind::Difference, interval.contains(0.0)));
    }
    found
}

fn pick<T: Copy>(all: &[T], random: &mut Random) -> Option<T> {
    (!all.is_empty()).then(|| random.one_of(all))
}

/// Whether it has an interval that sampling left: not the bounds of a computation.
fn has_interval(finding: &Finding) -> bool {
    match &finding.measure {
        Measure::Counts { trials, .. } => *trials > 0,
        Measure::Probability { credible, .. } => credible.is_some(),
        _ => false,
    }
}
