//! Counting verdicts into cells.

use crate::problem::Problem;
use crate::technique::confidence;
use evidence::{Cell, Interval, JudgedBy, Subject, Traces};
use temporal::monitor::Verdict;

/// Verdicts of one form on many traces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Verdicts {
    pub kept: u64,
    pub violated: u64,
    pub not_covered: u64,
    pub undecided: u64,
}

impl Verdicts {
    pub fn add(&mut self, verdict: Verdict) {
        match verdict {
            Verdict::Satisfied => self.kept += 1,
            Verdict::Violated => self.violated += 1,
            Verdict::NotCovered => self.not_covered += 1,
            Verdict::Inconclusive => self.undecided += 1,
        }
    }

    fn runs(self) -> u64 {
        self.kept + self.violated + self.not_covered + self.undecided
    }
}

/// Whose cell it is.
#[derive(Clone, Debug)]
pub struct Place<'a> {
    pub traces: Traces,
    pub judged_by: JudgedBy,
    pub evidence: &'a str,
    pub subject: &'a Subject,
}

impl Place<'_> {
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

    /// A cell of these verdicts. A property that does not come up is kept, as the model checker counts
    /// it; a monitor that does not come up decides nothing.
    pub fn filled(&self, verdicts: Verdicts, level: f64) -> Result<Cell, Problem> {
        let silent = match self.judged_by {
            JudgedBy::Property => verdicts.not_covered,
            JudgedBy::Monitor => 0,
        };
        let trials = verdicts.kept + verdicts.violated + silent;
        let count = match self.subject {
            Subject::Requirement(_) => verdicts.kept + silent,
            Subject::FailureMode(_) => verdicts.violated,
        };
        self.counted(count, trials, verdicts, level)
    }

    /// A cell of counts, on all the traces of `verdicts`.
    pub fn counted(
        &self,
        count: u64,
        trials: u64,
        verdicts: Verdicts,
        level: f64,
    ) -> Result<Cell, Problem> {
        let interval = match stats::Sample::new(count, trials) {
            Ok(sample) if trials > 0 => {
                let wilson = stats::wilson(sample, confidence(level)?);
                Some(Interval {
                    low: wilson.low,
                    high: wilson.high,
                })
            }
            _ => None,
        };
        Ok(Cell {
            count,
            trials,
            runs: verdicts.runs(),
            undecided: verdicts.undecided,
            interval,
            not_judged: None,
            ..self.empty(String::new())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_come_up_counts_for_properties_and_not_for_monitors() {
        let mut verdicts = Verdicts::default();
        for verdict in [
            Verdict::Satisfied,
            Verdict::Violated,
            Verdict::NotCovered,
            Verdict::NotCovered,
            Verdict::Inconclusive,
        ] {
            verdicts.add(verdict);
        }
        let subject = Subject::Requirement("1".into());
        let place = |judged_by| Place {
            traces: Traces::Simulator,
            judged_by,
            evidence: "E2",
            subject: &subject,
        };
        let b = place(JudgedBy::Property)
            .filled(verdicts, 0.95)
            .expect("a cell");
        assert_eq!(
            (b.cell, b.count, b.trials, b.runs, b.undecided),
            ('B', 3, 4, 5, 1)
        );
        let e = place(JudgedBy::Monitor)
            .filled(verdicts, 0.95)
            .expect("a cell");
        assert_eq!((e.cell, e.count, e.trials), ('E', 1, 2));
        assert!(e.interval.is_some_and(|i| i.low < 0.5 && i.high > 0.5));
    }
}
