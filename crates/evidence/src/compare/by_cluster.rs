//! Counts by subject or session, and what they say of a threshold that the effective sample size does not.
//!
//! # Definition
//! The effective size of a count is that of its 95 % interval. A test at another level, or of a threshold far from the
//! rate, asks how improbable the counts are under the *least favourable* correlation at the threshold: that is the
//! likelihood of the beta-binomial model, profiled over the correlation, and the probability of a better count at that
//! correlation ([`stats::BetaBinomial::threshold_tests`]). A claim needs all tests: its p-value is the greatest.
//!
//! # Why
//! People who hardly ever fail do not show how much they differ, so one failure in a hundred attempts counts as one in a
//! hundred independent trials; and the score test, which speaks of rates below a threshold, takes tails that are skew for
//! normal. The likelihood at the threshold knows both. By itself it says too much where few people have two attempts, and
//! at the small levels of a study of several quantities, for which it is no limit: there the count is asked.
//! `stats::clustered` has the sizes of each and of all.
//!
//! Neither knows of subjects of a kind that none of these is. By how much a claim rests on there being none is found by
//! [`stats::with_unmet_kind`], and said beside the claim. One subject's trials speak of that subject, and where each has a
//! single one they are independent: there nothing is said.
//!
//! # Assumes
//! People are independent draws of one population, with rates of a beta distribution; trials of one are independent given
//! the rate. A claim takes every kind of people as met, and says beside it where it rests on that.
//!
//! # Guarantee
//! Never more claims than by the effective size alone. Near its level for any number of subjects, as measured there.

use stats::{BetaBinomial, Sample, with_unmet_kind};
use std::cell::OnceCell;

/// Counts by subject or session.
#[derive(Debug)]
pub(crate) struct ByCluster {
    /// The counts of each; empty where only the total is known.
    found: Vec<Sample>,
    /// How many subjects there are, if several and of several trials.
    subjects: Option<u64>,
    /// Fitted when first asked for, since few counts are held against a threshold.
    fit: OnceCell<Option<BetaBinomial>>,
}

impl ByCluster {
    pub fn new(found: &[[u64; 2]]) -> Self {
        let sample = |&[successes, trials]: &[u64; 2]| Sample { successes, trials };
        let found: Vec<Sample> = found.iter().map(sample).collect();
        let with_trials = found.iter().filter(|it| it.trials > 0).count() as u64;
        let has_several = found.iter().any(|it| it.trials > 1);
        Self {
            found,
            subjects: Some(with_trials).filter(|subjects| *subjects > 1 && has_several),
            fit: OnceCell::new(),
        }
    }

    /// A total of so many subjects with several trials, of whom it is not known who did what.
    pub fn of_total(subjects: u64) -> Self {
        Self {
            found: Vec::new(),
            subjects: Some(subjects).filter(|subjects| *subjects > 1),
            fit: OnceCell::new(),
        }
    }

    /// How many subjects there are, if several and of several trials.
    pub fn subjects(&self) -> Option<u64> {
        self.subjects
    }

    /// p-values by these tests, if a share of all subjects could always have the contrary outcome and none of them was met.
    pub fn with_unmet_kind(&self, threshold: f64, tests: impl Fn(f64) -> (f64, f64)) -> (f64, f64) {
        match self.subjects() {
            Some(subjects) => with_unmet_kind(subjects as f64, threshold, tests),
            None => tests(threshold),
        }
    }

    /// The counts of each; `None` where only the total is known.
    pub fn found(&self) -> Option<&[Sample]> {
        (!self.found.is_empty()).then_some(&self.found)
    }

    /// The number of subjects with a trial, if all trials had one outcome: then nothing here tells how alike those of one
    /// subject are, and what else was counted of the same subjects has to.
    pub fn of_one_outcome(&self) -> Option<f64> {
        let with_trials = self.found.iter().filter(|it| it.trials > 0).count();
        let is_so = self.subjects.is_some() && with_trials > 0 && !self.tells_how_alike();
        is_so.then_some(with_trials as f64)
    }

    /// Whether these counts tell how alike trials of one are: of several subjects, and not all with one outcome.
    fn tells_how_alike(&self) -> bool {
        let has = |of: fn(&Sample) -> u64| self.found.iter().any(|it| of(it) > 0);
        self.subjects.is_some() && has(|it| it.successes) && has(Sample::failures)
    }

    /// p-values of "the rate is below the threshold" and "the rate is at least as high"; 0, which claims nothing by
    /// itself, where no model can be fitted.
    pub fn doubts(&self, threshold: f64) -> (f64, f64) {
        let fit = self.fit();
        fit.map_or((0.0, 0.0), |fit| fit.threshold_tests(threshold))
    }

    /// The most likely mean of all subjects; `None` where no model can be fitted.
    pub fn mean(&self) -> Option<f64> {
        self.fit().map(|fit| fit.mean)
    }

    fn fit(&self) -> Option<&BetaBinomial> {
        let fitted = || {
            let fit = || BetaBinomial::fit(&self.found).ok();
            self.tells_how_alike().then(fit).flatten()
        };
        self.fit.get_or_init(fitted).as_ref()
    }
}
