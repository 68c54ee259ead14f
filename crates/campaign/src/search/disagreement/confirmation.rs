//! Regions that are tried with fresh episodes until each is decided, all errors together within one
//! level; episodes go where a difference may be shown soonest.
//!
//! Definition. In each region contexts are drawn from the declared distributions, so that outcomes are
//! trials of one rate `r`, the mean of the rates of its contexts, which is held against the mean `p` of
//! their predictions, known up to `e`:
//!
//! ```text
//! differs    the confidence sequence of r lies beyond [p - margin - e, p + margin + e]
//! agrees     it lies within [p - margin + e, p + margin - e]
//! next       the open region with the largest (P(|r - p| > margin | its outcomes) + 1/4) / N,
//!            N = ln(1/level) and what the mixture costs, less what is shown, over KL(r, nearest bound)
//! ```
//!
//! The probability is that of Jeffreys' posterior, the quarter what agreement is worth, and N about
//! how many more episodes it takes. A region at the very edge of the margin has a large N, so it does not eat up the budget; a region
//! that is decided gets no more.
//!
//! Source: E. Even-Dar, S. Mannor and Y. Mansour (2006) for elimination of what is decided; the
//! confidence sequences are those of [`stats::confidence_sequence`]; K. Jamieson and A. Jain, "A bandit
//! approach to multiple testing with false discovery control" (2018) for looking where a
//! difference may be shown. Level: shared equally (C. E. Bonferroni, 1936). Deviation: the index
//! is ours. Cost: constant for an outcome, O(regions) for a choice. Guarantee: whatever the choices, with
//! probability at least `confidence` no region is wrongly decided, as long as `e` bounds what is
//! wrong with `p`; that all are decided is not guaranteed.

use serde::{Deserialize, Serialize};
use stats::special::beta_cdf;
use stats::{Confidence, Interval, Sample};
use stats::{confidence_sequence, ln_evidence_against};

use super::region::Region;

/// Each region gets so many episodes before any is preferred.
const FIRST: u64 = 8;

/// What it is worth to decide a region that has no chance of a difference; one that differs for sure
/// is worth 1 more.
const WORTH_OF_AGREEMENT: f64 = 0.25;

/// Whether simulation and prediction agree in a region.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// The rate differs from the prediction by more than the margin.
    Differs,
    /// Not enough episodes.
    Undecided,
    /// The rate differs from the prediction by at most the margin.
    Agrees,
}

/// A region with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The region.
    pub region: Region,
    /// The mean of what the model predicts in it.
    pub predicted: f64,
    /// That mean is known to within this.
    pub predicted_error: f64,
    /// What fresh episodes showed.
    pub sample: Sample,
    /// Where the simulated rate lies; simultaneously for all regions, however often one looked.
    pub interval: Interval,
    /// Natural logarithm of the evidence (an e-value) against the very prediction.
    pub ln_evidence: f64,
    /// The decision.
    pub agreement: Agreement,
    /// By how much the rate differs from the prediction at least: 0 if the interval holds it.
    pub sure_difference: f64,
    /// How probable a difference beyond the margin is by Jeffreys' posterior, of one rate alone.
    pub chance: f64,
    /// About how many more episodes would decide it, if the rate is what it seems to be; `None`
    /// when it is decided.
    pub further: Option<f64>,
}

/// A region as it is to be decided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Question {
    /// The region.
    pub region: Region,
    /// The mean of what the model predicts in it.
    pub predicted: f64,
    /// That mean is known to within this.
    pub predicted_error: f64,
}

/// Regions that are being decided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confirmation {
    tried: Vec<Tried>,
    margin: f64,
    confidence: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Tried {
    question: Question,
    successes: u64,
    trials: u64,
    /// Episodes asked for and not told yet.
    open: u64,
    /// Where the rate lies: within the intervals of all looks, which hold all at once.
    low: f64,
    high: f64,
    /// Once decided, a region stays so.
    agreement: Agreement,
}

impl Confirmation {
    /// Regions to be decided, with settings that were checked.
    pub(super) fn new(questions: Vec<Question>, margin: f64, confidence: f64) -> Self {
        let tried = |question: Question| Tried {
            question,
            successes: 0,
            trials: 0,
            open: 0,
            low: 0.0,
            high: 1.0,
            agreement: Agreement::Undecided,
        };
        Self {
            tried: questions.into_iter().map(tried).collect(),
            margin,
            confidence,
        }
    }

    /// The region, by its place, in which to run the next episode; `None` when all are decided.
    pub(super) fn ask(&mut self) -> Option<usize> {
        let (level, margin) = (self.level(), self.margin);
        let open = self.tried.iter().enumerate();
        let open = open.filter(|(_, it)| it.agreement == Agreement::Undecided);
        let first = open.clone().filter(|(_, it)| it.trials + it.open < FIRST);
        let next = match first.min_by_key(|(_, it)| it.trials + it.open) {
            Some((index, _)) => index,
            // The first of equals.
            None => {
                let scored = open.map(|(index, it)| (index, it.urgency(margin, level)));
                scored.rev().max_by(|a, b| a.1.total_cmp(&b.1))?.0
            }
        };
        self.tried[next].open += 1;
        Some(next)
    }

    /// What came out of an episode in a region; `None` if it could not be judged.
    pub(super) fn tell(&mut self, index: usize, outcome: Option<bool>) {
        let (level, margin) = (self.level(), self.margin);
        let Some(it) = self.tried.get_mut(index) else {
            return;
        };
        it.open = it.open.saturating_sub(1);
        let Some(success) = outcome else { return };
        it.trials += 1;
        it.successes += u64::from(success);
        it.narrow(level);
        if it.agreement == Agreement::Undecided {
            it.agreement = it.decide(margin);
        }
    }

    /// The level at which each region by itself is decided.
    fn level(&self) -> Confidence {
        let confidence = Confidence::new(self.confidence).unwrap_or(Confidence::P95);
        confidence.simultaneous(self.tried.len().max(1))
    }

    /// Whether every region is decided.
    #[must_use]
    pub fn is_over(&self) -> bool {
        let mut all = self.tried.iter();
        all.all(|it| it.agreement != Agreement::Undecided)
    }

    /// The regions, in the order of asking.
    pub(super) fn region(&self, index: usize) -> Option<&Region> {
        self.tried.get(index).map(|it| &it.question.region)
    }

    /// All regions: those that differ first, then the undecided; by the size of the difference
    /// that is sure, then by the evidence.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        let (level, margin) = (self.level(), self.margin);
        let tried = self.tried.iter();
        let mut findings: Vec<Finding> = tried.map(|it| it.finding(margin, level)).collect();
        findings.sort_by(|a, b| {
            let by_size = b.sure_difference.total_cmp(&a.sure_difference);
            let by_evidence = b.ln_evidence.total_cmp(&a.ln_evidence);
            a.agreement
                .cmp(&b.agreement)
                .then(by_size)
                .then(by_evidence)
        });
        findings
    }
}

impl Tried {
    fn sample(&self) -> Sample {
        Sample {
            successes: self.successes,
            trials: self.trials,
        }
    }

    /// Takes the interval of one more look. If no rate lies in all of them, which has at most the
    /// probability that is allowed for, what was known before stays.
    fn narrow(&mut self, level: Confidence) {
        let interval = confidence_sequence(self.sample(), level);
        let (low, high) = (self.low.max(interval.low), self.high.min(interval.high));
        if low <= high {
            (self.low, self.high) = (low, high);
        }
    }

    fn decide(&self, margin: f64) -> Agreement {
        let Question {
            predicted,
            predicted_error: error,
            ..
        } = self.question;
        let beyond = margin + error;
        let within = margin - error;
        if self.low > predicted + beyond || self.high < predicted - beyond {
            Agreement::Differs
        } else if self.low >= predicted - within && self.high <= predicted + within {
            Agreement::Agrees
        } else {
            Agreement::Undecided
        }
    }

    /// The probability that the rate lies beyond the margin, by Jeffreys' posterior.
    fn chance(&self, margin: f64) -> f64 {
        let a = self.successes as f64 + 0.5;
        let b = (self.trials - self.successes) as f64 + 0.5;
        let below = |rate: f64| beta_cdf(a, b, rate.clamp(0.0, 1.0));
        let predicted = self.question.predicted;
        (1.0 - below(predicted + margin) + below(predicted - margin)).clamp(0.0, 1.0)
    }

    /// About how many more episodes decide it if the rate is the mean of Jeffreys' posterior.
    fn further(&self, margin: f64, level: Confidence) -> f64 {
        let rate = (self.successes as f64 + 0.5) / (self.trials as f64 + 1.0);
        let predicted = self.question.predicted;
        let bounds = [predicted - margin, predicted + margin];
        let bounds = bounds
            .into_iter()
            .filter(|bound| *bound > 0.0 && *bound < 1.0);
        // What a difference has to leave behind is the nearer bound; agreement has to leave both.
        let differs = (rate - predicted).abs() > margin;
        let needed = bounds.map(|bound| {
            let shown = ln_evidence_against(self.sample(), bound).max(0.0);
            // Half a logarithm of the number of trials is the price of not knowing the rate.
            let wanted = -level.alpha().ln() + 0.5 * (self.trials as f64 + 20.0).ln() + 0.5;
            (wanted - shown).max(1.0) / divergence(rate, bound).max(1e-6)
        });
        match differs {
            true => needed.fold(f64::INFINITY, f64::min),
            false => needed.fold(1.0, f64::max),
        }
    }

    /// How soon a difference may be shown here: its chance for each further episode.
    fn urgency(&self, margin: f64, level: Confidence) -> f64 {
        // What still runs may already do.
        let episodes = self.further(margin, level) + self.open as f64;
        (self.chance(margin) + WORTH_OF_AGREEMENT) / episodes
    }

    fn finding(&self, margin: f64, level: Confidence) -> Finding {
        let interval = Interval {
            low: self.low,
            high: self.high,
        };
        let Question {
            region,
            predicted,
            predicted_error,
        } = self.question.clone();
        let below = interval.low - predicted;
        let above = predicted - interval.high;
        let is_open = self.agreement == Agreement::Undecided;
        Finding {
            region,
            predicted,
            predicted_error,
            sample: self.sample(),
            ln_evidence: ln_evidence_against(self.sample(), predicted),
            agreement: self.agreement,
            sure_difference: (below.max(above) - predicted_error).max(0.0),
            chance: self.chance(margin),
            further: is_open.then(|| self.further(margin, level)),
            interval,
        }
    }
}

/// The Kullback-Leibler divergence of one rate from another that is neither 0 nor 1.
fn divergence(rate: f64, other: f64) -> f64 {
    let part = |p: f64, q: f64| match p > 0.0 {
        true => p * (p / q).ln(),
        false => 0.0,
    };
    part(rate, other) + part(1.0 - rate, 1.0 - other)
}
