//! Contexts that are tried again until each is decided, all errors together within one level.
//!
//! ```
//! use campaign::{Agreement, Confirmation};
//! use stimulus::Point;
//! // Two contexts, for each of which a model predicts 0.9.
//! let contexts = vec![(Point(vec![0.0]), 0.9), (Point(vec![1.0]), 0.9)];
//! let mut confirmation = Confirmation::new(contexts, 0.05, 0.95)?;
//! for episode in 0..60 {
//!     for context in confirmation.ask(2) {
//!         // The first fails every other time.
//!         let success = context.0[0] > 0.5 || episode % 2 == 0;
//!         confirmation.tell(&context, success);
//!     }
//! }
//! let findings = confirmation.findings();
//! assert_eq!(findings[0].context, Point(vec![0.0]));
//! assert_eq!(findings[0].agreement, Agreement::Disagrees);
//! assert_eq!(findings[1].agreement, Agreement::Undecided);
//! # Ok::<(), campaign::CampaignError>(())
//! ```

use serde::{Deserialize, Serialize};
use stats::sequential::{confidence_sequence, ln_evidence_against};
use stats::{Confidence, Interval, Sample};
use stimulus::Point;

use crate::error::CampaignError;

/// Whether simulation and prediction agree in a context.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Agreement {
    /// The rate differs from the prediction by more than the margin.
    Disagrees,
    /// Not enough episodes yet.
    Undecided,
    /// The rate differs from the prediction by at most the margin.
    Agrees,
}

/// A context with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The context.
    pub context: Point,
    /// What the model predicts.
    pub predicted: f64,
    /// What fresh episodes showed.
    pub sample: Sample,
    /// Where the simulated rate lies; simultaneously for all contexts, however often one looked.
    pub interval: Interval,
    /// Natural logarithm of the evidence (an e-value) against the very prediction.
    pub ln_evidence: f64,
    /// The decision.
    pub agreement: Agreement,
    /// By how much the rate differs from the prediction at least: 0 if the interval holds it.
    pub sure_difference: f64,
}

/// Contexts that are being decided.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Confirmation {
    contexts: Vec<Context>,
    margin: f64,
    confidence: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Context {
    point: Point,
    predicted: f64,
    successes: u64,
    trials: u64,
    /// Episodes asked for and not told yet.
    open: u64,
    /// Where the rate lies: within the intervals of all looks, which hold all at once.
    low: f64,
    high: f64,
    /// Once decided, a context stays so.
    agreement: Agreement,
}

impl Confirmation {
    /// Contexts with their predicted probabilities, a margin within which differences do not
    /// matter, and the confidence that no context is wrongly decided.
    ///
    /// # Errors
    /// [`CampaignError::Setting`] for a margin outside `[0, 1)`, a confidence outside `(0, 1)`, or
    /// a prediction that is no probability.
    pub fn new(
        contexts: Vec<(Point, f64)>,
        margin: f64,
        confidence: f64,
    ) -> Result<Self, CampaignError> {
        if !(0.0..1.0).contains(&margin) {
            let problem = "it must be at least 0 and below 1";
            return Err(CampaignError::setting("margin", problem));
        }
        if let Err(error) = Confidence::new(confidence) {
            return Err(CampaignError::setting("confidence", error.to_string()));
        }
        if let Some((_, p)) = contexts.iter().find(|(_, p)| !(0.0..=1.0).contains(p)) {
            let problem = format!("{p} is no probability");
            return Err(CampaignError::setting("prediction", problem));
        }
        Ok(Self::of(contexts, margin, confidence))
    }

    /// With settings that were checked.
    pub(super) fn of(contexts: Vec<(Point, f64)>, margin: f64, confidence: f64) -> Self {
        let context = |(point, predicted): (Point, f64)| Context {
            point,
            predicted,
            successes: 0,
            trials: 0,
            open: 0,
            low: 0.0,
            high: 1.0,
            agreement: Agreement::Undecided,
        };
        Self {
            contexts: contexts.into_iter().map(context).collect(),
            margin,
            confidence,
        }
    }

    /// The next contexts for an episode each: undecided ones, those with fewest episodes first;
    /// none when all are decided.
    pub fn ask(&mut self, count: usize) -> Vec<Point> {
        let mut points = Vec::with_capacity(count);
        for _ in 0..count {
            let undecided = |context: &&mut Context| context.agreement == Agreement::Undecided;
            let open = self.contexts.iter_mut().filter(undecided);
            let Some(next) = open.min_by_key(|context| context.trials + context.open) else {
                break;
            };
            next.open += 1;
            points.push(next.point.clone());
        }
        points
    }

    /// What came out in a context; ignored if there is no such context.
    pub fn tell(&mut self, context: &Point, success: bool) {
        let level = self.simultaneous();
        let margin = self.margin;
        if let Some(context) = self.contexts.iter_mut().find(|c| c.point == *context) {
            context.trials += 1;
            context.successes += u64::from(success);
            context.open = context.open.saturating_sub(1);
            context.narrow(level);
            if context.agreement == Agreement::Undecided {
                context.agreement = context.decide(margin);
            }
        }
    }

    /// The level at which each context by itself is decided.
    fn simultaneous(&self) -> Confidence {
        let confidence = Confidence::new(self.confidence).unwrap_or(Confidence::P95);
        confidence.simultaneous(self.contexts.len().max(1))
    }

    /// Whether every context is decided.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.contexts
            .iter()
            .all(|context| context.agreement != Agreement::Undecided)
    }

    /// All contexts: those that disagree first, then the undecided; by the size of the difference
    /// that is sure, then by the evidence.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        let mut findings: Vec<Finding> = self.contexts.iter().map(Context::finding).collect();
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

impl Context {
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
        let (low, high) = (self.predicted - margin, self.predicted + margin);
        if self.low > high || self.high < low {
            Agreement::Disagrees
        } else if self.low >= low && self.high <= high {
            Agreement::Agrees
        } else {
            Agreement::Undecided
        }
    }

    fn finding(&self) -> Finding {
        let interval = Interval {
            low: self.low,
            high: self.high,
        };
        let below = interval.low - self.predicted;
        let above = self.predicted - interval.high;
        Finding {
            context: self.point.clone(),
            predicted: self.predicted,
            sample: self.sample(),
            ln_evidence: ln_evidence_against(self.sample(), self.predicted),
            agreement: self.agreement,
            sure_difference: below.max(above).max(0.0),
            interval,
        }
    }
}
