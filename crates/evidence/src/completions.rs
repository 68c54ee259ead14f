//! Runs that reached no verdict, counted both ways.
//!
//! # Definition
//! Of `n` runs with a verdict `k` count (passed, or showed the failure mode), and `u` more reached none: they ended before,
//! were cut short, or lack a signal. Each of these may have counted or not, or may not have triggered the subject. The
//! *completions* of the count are `k` of `n + u` and `k + u` of `n + u`; all others lie between. A statement on the rate is
//! made only if it holds of both: p-values are the greatest, limits and intervals the widest of the two.
//!
//! Likewise runs that may be others told twice ([`Finding::or_once`]): the count with them and the count without them are two
//! more ends.
//!
//! Of trials that are alike by subject or session the `u` runs are a further one, of which all count or none.
//!
//! # Source
//! Worst-case bounds for data that are missing for unknown reasons (C. F. Manski, "Partial identification of probability
//! distributions", 2003, chapter 1).
//!
//! # Assumes
//! Of the runs without a verdict nothing, unless the study declares that they are missing at random. The others are
//! independent, or alike by subject as their count says. That the two ends are the extremes is sure of independent trials;
//! of counts by subject, whose limits are not monotone (`stats::clustered`), it is not proved.
//!
//! # Guarantee
//! Whatever the runs without a verdict would have shown, and however that hangs together with why they have none, the true
//! rate of all runs is covered at least as often as if all of them had been seen: of independent trials for certain, of those
//! by subject as far as the two ends are the extremes. The price is the width: `u / (n + u)` at least. Only where the study declares that they are missing at random is the count of the others taken for all.

use crate::{Completions, Finding, Interval, Measure};
use stats::{Confidence, Sample, StatsError};

impl Finding {
    /// The same with its runs without a verdict counted both ways, if there are any; `counted` makes a measure of independent
    /// runs as its own was made.
    ///
    /// # Errors
    /// [`StatsError`] of `counted`, or for counts by subject that contradict each other.
    ///
    /// ```
    /// use evidence::{Denominator, Finding, Measure, Subject};
    /// use stats::{Confidence, Sample};
    /// let counted = |sample| Measure::of_counts(sample, None, Confidence::P95);
    /// let finding = Finding {
    ///     subject: Subject::Requirement("1".into()),
    ///     measure: counted(Sample { successes: 90, trials: 90 })?,
    ///     denominator: Denominator::EveryRun,
    ///     trigger: None,
    ///     undecided: 10,
    ///     left_out: 0,
    ///     completions: None,
    ///     witnesses: vec![],
    ///     readings: vec![],
    /// };
    /// let interval = finding.counting_undecided(Confidence::P95, &counted)?.measure.interval();
    /// // 90 of 100 at the least, 100 of 100 at the most.
    /// let lowest = counted(Sample { successes: 90, trials: 100 })?.interval();
    /// assert_eq!(interval.map(|it| it.low), lowest.map(|it| it.low));
    /// assert_eq!(interval.map(|it| it.high), Some(1.0));
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    pub fn counting_undecided(
        mut self,
        level: Confidence,
        counted: &dyn Fn(Sample) -> Result<Measure, StatsError>,
    ) -> Result<Self, StatsError> {
        let undecided = self.undecided;
        let Measure::Counts { trials, .. } = self.measure else {
            return Ok(self);
        };
        if undecided == 0 || trials == 0 {
            return Ok(self);
        }
        let end = |more: u64| with_more(&self.measure, [more, undecided], level, counted);
        self.widen(vec![end(0)?, end(undecided)?]);
        Ok(self)
    }

    /// The same where some of its runs may be others told twice: `once` is what is found without them. What holds of both holds
    /// whether they are or not.
    #[must_use]
    pub fn or_once(mut self, once: &Self) -> Self {
        let ends = |finding: &Self| match &finding.completions {
            Some(completions) => completions.ends.clone(),
            None => vec![finding.measure.clone()],
        };
        let is_counted = |it: &Measure| matches!(it, Measure::Counts { trials, .. } if *trials > 0);
        if is_counted(&self.measure) && is_counted(&once.measure) && self.measure != once.measure {
            let all = ends(&self).into_iter().chain(ends(once)).collect();
            self.widen(all);
        }
        self
    }

    /// Takes what it may be, and widens its interval to all of it.
    fn widen(&mut self, ends: Vec<Measure>) {
        let limits = ends
            .iter()
            .chain([&self.measure])
            .filter_map(Measure::interval);
        let widest = limits.reduce(|one, other| Interval {
            low: one.low.min(other.low),
            high: one.high.max(other.high),
        });
        if let (Measure::Counts { interval, .. }, Some(widest)) = (&mut self.measure, widest) {
            *interval = widest;
        }
        self.completions = Some(Box::new(Completions { ends }));
    }

    /// What was found, and all that it may be.
    pub fn may_be(&self) -> impl Iterator<Item = &Measure> {
        let ends = self.completions.iter().flat_map(|all| &all.ends);
        std::iter::once(&self.measure).chain(ends)
    }

    /// Its runs without a verdict, with what they count for, as the end of a sentence; empty where there are none.
    #[must_use]
    pub fn undecided_in_words(&self) -> String {
        let (many, they) = match self.undecided {
            0 => return String::new(),
            1 => ("1 more run".to_owned(), "is"),
            many => (format!("{many} more runs"), "are"),
        };
        match &self.completions {
            Some(_) => format!("{many} reached no verdict and {they} counted against and for"),
            None => format!("{many} reached no verdict"),
        }
    }
}

/// A count with more runs, of which so many count.
fn with_more(
    measure: &Measure,
    more: [u64; 2],
    level: Confidence,
    counted: &dyn Fn(Sample) -> Result<Measure, StatsError>,
) -> Result<Measure, StatsError> {
    let Measure::Counts {
        count,
        trials,
        effective_trials,
        by_subject,
        subjects,
        ..
    } = measure
    else {
        return Ok(measure.clone());
    };
    let sample = Sample::new(
        count.saturating_add(more[0]),
        trials.saturating_add(more[1]),
    )?;
    if let Some(by_subject) = by_subject {
        let all = by_subject.iter().chain([&more]);
        let all: Result<Vec<Sample>, _> = all.map(|it| Sample::new(it[0], it[1])).collect();
        return Measure::of_clusters(&all?, level);
    }
    match (effective_trials, subjects) {
        // At what the runs with a verdict are worth.
        (Some(worth), Some(_)) => {
            let each = worth / *trials as f64;
            Measure::of_counts(sample, Some(each * sample.trials as f64), level)
        }
        _ => counted(sample),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Denominator, Subject};

    const LEVEL: Confidence = Confidence::P95;

    fn finding(measure: Measure, undecided: u64) -> Finding {
        let finding = Finding {
            subject: Subject::Requirement("1".into()),
            measure,
            denominator: Denominator::EveryRun,
            trigger: None,
            undecided,
            left_out: 0,
            completions: None,
            witnesses: Vec::new(),
            readings: Vec::new(),
        };
        let counted = |sample| Measure::of_counts(sample, None, LEVEL);
        finding.counting_undecided(LEVEL, &counted).expect("counts")
    }

    /// The interval holds that of every completion, by going through them.
    #[test]
    fn the_interval_holds_whatever_the_runs_would_have_shown() {
        for (count, trials, undecided) in [(0, 1, 5), (9, 10, 1), (30, 40, 12), (7, 7, 3)] {
            let counted = |count, trials| {
                let sample = Sample::new(count, trials).expect("counts");
                Measure::of_counts(sample, None, LEVEL).expect("counts")
            };
            let found = finding(counted(count, trials), undecided);
            let widest = found.measure.interval().expect("an interval");
            // Each counts, does not count, or never triggered it.
            for passed in 0..=undecided {
                for failed in 0..=undecided - passed {
                    let one = counted(count + passed, trials + passed + failed).interval();
                    let one = one.expect("an interval");
                    assert!(widest.low <= one.low && one.high <= widest.high);
                }
            }
            let decided = found.measure.estimate().expect("a rate");
            assert!((decided - count as f64 / trials as f64).abs() < 1e-12);
        }
    }

    #[test]
    fn what_may_be_told_twice_counts_with_and_without() {
        let counted = |count, trials| {
            let sample = Sample::new(count, trials).expect("counts");
            Measure::of_counts(sample, None, LEVEL).expect("counts")
        };
        let (each, once) = (finding(counted(40, 50), 2), finding(counted(10, 20), 2));
        let both = each.clone().or_once(&once);
        let interval = |it: &Finding| it.measure.interval().expect("an interval");
        assert_eq!(interval(&both).low, interval(&once).low);
        assert_eq!(interval(&both).high, interval(&each).high);
        assert_eq!(both.completions.map(|it| it.ends.len()), Some(4));
        // The same count twice is one.
        assert_eq!(each.clone().or_once(&each), each);
    }

    #[test]
    fn runs_that_are_alike_get_one_more_subject() {
        let people = [[4, 5], [5, 5], [3, 5], [5, 5], [4, 5]];
        let samples = people.map(|it| Sample::new(it[0], it[1]).expect("counts"));
        let measure = Measure::of_clusters(&samples, LEVEL).expect("counts");
        let found = finding(measure.clone(), 4);
        let completions = found.completions.as_ref().expect("two ends");
        for (end, more) in completions.ends.iter().zip([[0, 4], [4, 4]]) {
            let all = samples
                .into_iter()
                .chain([Sample::new(more[0], more[1]).expect("counts")]);
            let all: Vec<Sample> = all.collect();
            assert_eq!(*end, Measure::of_clusters(&all, LEVEL).expect("counts"));
        }
        assert_eq!(finding(measure, 0).completions, None);
    }
}
