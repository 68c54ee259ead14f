//! Verdicts of monitors as the counts of cells.

pub use evidence::CellPlace as Place;
use evidence::VerdictCounts;
use temporal::monitor::Verdict;

/// The counts of these verdicts.
pub fn counts(verdicts: impl IntoIterator<Item = Verdict>) -> VerdictCounts {
    let mut sum = VerdictCounts::default();
    for verdict in verdicts {
        match verdict {
            Verdict::Satisfied => sum.kept += 1,
            Verdict::Violated => sum.violated += 1,
            Verdict::NotCovered => sum.not_covered += 1,
            Verdict::Inconclusive => sum.undecided += 1,
        }
    }
    sum
}
