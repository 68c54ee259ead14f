//! How alike the trials of one subject of a cohort are, for all that was counted of them.
//!
//! Each column of the cohort that a requirement or failure mode is counted by tells it of itself, and all of
//! them what they have in common, for counts that do not tell it: 0 of n, n of n, and totals of which the
//! tables do not say who did what (`stats::common_correlation`).

use super::{Cohort, columns, not_covered};
use diagnostic::Problem;
use evidence::{Measure, Subject, TakenCorrelation};
use stats::{ClusterMethod, CommonCorrelation, Confidence, Sample, StatsError};
use study::{Study, SubjectForm};

/// What a cohort tells of the likeness of its trials.
pub(super) struct Alike {
    common: CommonCorrelation,
    /// The columns that tell.
    columns: Vec<String>,
    /// Attempts of each subject.
    attempts: Vec<u64>,
    /// Whose counts were given what the columns have in common.
    taken_for: Vec<Subject>,
}

impl Alike {
    /// From all columns of the cohort by which something is counted, each once.
    pub fn of(study: &Study, cohort: &Cohort) -> Result<Self, Problem> {
        let bindings = columns::bindings(study).into_iter();
        let here = bindings.filter(|binding| !cohort.left_to_others.contains(*binding));
        let (mut columns, mut counts) = (Vec::new(), Vec::new());
        for binding in here {
            let by_subject = cohort.counts(binding)?;
            let total = stats::pool(&by_subject).map_err(bad)?;
            if total.successes > 0 && total.failures() > 0 {
                columns.push(binding.to_owned());
                counts.push(by_subject);
            }
        }
        Ok(Self {
            common: CommonCorrelation::of(&counts).map_err(bad)?,
            columns,
            attempts: cohort.attempts.clone(),
            taken_for: Vec::new(),
        })
    }

    /// A count whose trials are known by subject.
    pub fn by_subject(
        &mut self,
        form: &SubjectForm,
        by_subject: &[Sample],
        level: Confidence,
    ) -> Result<Measure, Problem> {
        match stats::clustered_rate_among(&self.common, by_subject, level) {
            Err(StatsError::NoTrials) => return Ok(not_covered("There are no trials.")),
            Err(error) => return Err(bad(error)),
            Ok(rate) => self.note(form, rate.method),
        }
        Measure::of_clusters_among(&self.common, by_subject, level).map_err(bad)
    }

    /// Occurrences that are known by subject, but the opportunities only in all: as many independent ones for each
    /// trial as the trials are.
    pub fn occurrences(
        &mut self,
        form: &SubjectForm,
        by_subject: &[Sample],
        (count, opportunities): (u64, u64),
        level: Confidence,
    ) -> Result<Measure, Problem> {
        let rate = stats::clustered_rate(by_subject, level).map_err(bad)?;
        match rate.method {
            ClusterMethod::Profile => {
                let share = rate.worth.trials / rate.total.trials as f64;
                super::counts(
                    count,
                    opportunities,
                    Some(opportunities as f64 * share),
                    level,
                )
            }
            _ => self.total(form, (count, opportunities), level),
        }
    }

    /// A count of which only the total is known.
    pub fn total(
        &mut self,
        form: &SubjectForm,
        (count, trials): (u64, u64),
        level: Confidence,
    ) -> Result<Measure, Problem> {
        let total = Sample::new(count, trials).map_err(bad)?;
        let rate = self
            .common
            .rate(total, &self.attempts, level)
            .map_err(bad)?;
        self.note(form, rate.method);
        Measure::of_total_among(&self.common, total, &self.attempts, level).map_err(bad)
    }

    fn note(&mut self, form: &SubjectForm, method: ClusterMethod) {
        if matches!(method, ClusterMethod::Common | ClusterMethod::OneEach) {
            self.taken_for.push(form.subject.clone());
        }
    }

    /// What was taken for whom, if for anybody.
    pub fn taken(&self, level: Confidence) -> Option<TakenCorrelation> {
        let interval = self.common.interval(level);
        (!self.taken_for.is_empty()).then(|| TakenCorrelation {
            estimate: (self.common.columns > 0).then_some(self.common.estimate),
            interval: evidence::Interval {
                low: interval.low,
                high: interval.high,
            },
            columns: self.columns.clone(),
            effective_columns: self.common.effective_columns,
            taken_for: self.taken_for.clone(),
        })
    }

    /// Independent trials that all attempts are worth, as nobody knows better.
    pub fn worth_of_all(&self, cohort: &Cohort, level: Confidence) -> f64 {
        let trials = cohort.attempts.iter().sum();
        let none = Sample {
            successes: 0,
            trials,
        };
        let rate = self.common.rate(none, &self.attempts, level);
        rate.map_or(trials as f64, |rate| rate.worth.trials)
    }
}

fn bad(error: StatsError) -> Problem {
    Problem::new("bad-counts", error.to_string())
}
