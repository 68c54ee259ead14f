//! Counting verdicts into cells of the matrix.
//!
//! # Definition
//! A property holds of a trace on which what it speaks of does not come up, as the model checker counts it; a monitor
//! decides nothing there. Of a requirement a cell counts the traces that keep it, of a failure mode its occurrences. The
//! interval is Wilson's; traces without a verdict may each count or not, so that it reaches from the lower end with none of them
//! to the upper end with all.
//!
//! # Assumes
//! Traces are independent, and their number was fixed in advance. Those without a verdict may be either.
//!
//! # Guarantee
//! The interval is Wilson's approximation for independent traces: it holds its level on average over rates, and may fall short of it by a
//! few points at single ones. Nothing is decided by it.

use super::suspect::{Cell, JudgedBy, Traces};
use crate::{Interval, Subject};
use stats::{Confidence, Sample};

/// Verdicts of one form on many traces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct VerdictCounts {
    /// Traces that keep it.
    pub kept: u64,
    /// Traces that violate it; occurrences of a failure mode.
    pub violated: u64,
    /// Traces on which it does not come up.
    pub not_covered: u64,
    /// Traces that were cut short before a verdict.
    pub undecided: u64,
}

impl VerdictCounts {
    /// All traces.
    #[must_use]
    pub fn runs(self) -> u64 {
        self.kept + self.violated + self.not_covered + self.undecided
    }
}

/// Whose cell it is.
#[derive(Clone, Debug)]
pub struct CellPlace<'a> {
    /// The traces.
    pub traces: Traces,
    /// The requirement model.
    pub judged_by: JudgedBy,
    /// The evidence whose assets gave the traces.
    pub evidence: &'a str,
    /// The requirement or failure mode.
    pub subject: &'a Subject,
}

impl CellPlace<'_> {
    fn letter(&self) -> char {
        match (self.judged_by, self.traces) {
            (JudgedBy::Property, Traces::Model) => 'A',
            (JudgedBy::Property, Traces::Simulator) => 'B',
            (JudgedBy::Property, Traces::Recordings) => 'C',
            (JudgedBy::Monitor, Traces::Model) => 'D',
            (JudgedBy::Monitor, Traces::Simulator) => 'E',
            (JudgedBy::Monitor, Traces::Recordings) => 'F',
        }
    }

    /// A cell that could not be filled.
    #[must_use]
    pub fn empty(&self, why: String) -> Cell {
        Cell {
            cell: self.letter(),
            traces: self.traces,
            judged_by: self.judged_by,
            evidence: self.evidence.to_owned(),
            subject: self.subject.clone(),
            count: 0,
            trials: 0,
            runs: 0,
            undecided: 0,
            interval: None,
            not_judged: Some(why),
        }
    }

    /// A cell of these verdicts.
    ///
    /// ```
    /// use evidence::{CellPlace, JudgedBy, Subject, Traces, VerdictCounts};
    /// use stats::Confidence;
    ///
    /// let subject = Subject::Requirement("1".into());
    /// let counts = VerdictCounts { kept: 1, violated: 1, not_covered: 2, undecided: 1 };
    /// let cell = |judged_by| {
    ///     let place = CellPlace { traces: Traces::Simulator, judged_by, evidence: "E2", subject: &subject };
    ///     let cell = place.filled(counts, Confidence::P95);
    ///     (cell.cell, cell.count, cell.trials, cell.runs, cell.undecided)
    /// };
    /// // What does not come up counts for properties and not for monitors.
    /// assert_eq!(cell(JudgedBy::Property), ('B', 3, 4, 5, 1));
    /// assert_eq!(cell(JudgedBy::Monitor), ('E', 1, 2, 5, 1));
    /// ```
    #[must_use]
    pub fn filled(&self, verdicts: VerdictCounts, level: Confidence) -> Cell {
        let silent = match self.judged_by {
            JudgedBy::Property => verdicts.not_covered,
            JudgedBy::Monitor => 0,
        };
        let trials = verdicts.kept + verdicts.violated + silent;
        let count = match self.subject {
            Subject::Requirement(_) => verdicts.kept + silent,
            Subject::FailureMode(_) => verdicts.violated,
        };
        self.counted((count, trials), verdicts, level)
    }

    /// A cell of counts and their trials, on all the traces of `verdicts`.
    #[must_use]
    pub fn counted(
        &self,
        (count, trials): (u64, u64),
        verdicts: VerdictCounts,
        level: Confidence,
    ) -> Cell {
        let all = trials + verdicts.undecided;
        let ends = [count, count + verdicts.undecided].map(|count| {
            let sample = Sample::new(count, all).ok().filter(|_| trials > 0);
            sample.map(|it| stats::wilson(it, level))
        });
        Cell {
            count,
            trials,
            runs: verdicts.runs(),
            undecided: verdicts.undecided,
            interval: ends[0].zip(ends[1]).map(|(least, most)| Interval {
                low: least.low,
                high: most.high,
            }),
            not_judged: None,
            ..self.empty(String::new())
        }
    }
}
