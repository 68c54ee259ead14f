//! An estimate with an interval from independent replications.
//!
//! Definition. `R` replications give estimates `p_1, ..., p_R`, independent and unbiased. Their mean
//! `m` is the estimate, `s^2` their variance. The interval is `m exp(+-t s / (m sqrt R))` with
//! Student's t for `R - 1` degrees: the mean's, on the scale of logarithms (delta method), because
//! such estimates are skewed to the right and never negative. If no replication reached the event
//! the interval is that of Clopper and Pearson for no event in all first runs, which are plain
//! independent episodes.
//!
//! Source: S. Asmussen and P. W. Glynn, "Stochastic Simulation" (2007), section III.1 and III.3.
//! Cost: linear. Guarantee: approximate coverage, nearer to the stated one the more replications
//! there are; tested on problems with known answers.

use stats::special::student_t_quantile;
use stats::{Confidence, Interval, Sample, clopper_pearson};

use super::Descent;
use crate::error::CampaignError;

/// A rare event's probability, by splitting.
#[derive(Debug, Clone, PartialEq)]
pub struct RareEstimate {
    /// The mean of the replications.
    pub probability: f64,
    /// Where the probability lies, at the confidence asked for.
    pub interval: Interval,
    /// The standard error of the mean divided by it; `None` if the mean is 0.
    pub relative_error: Option<f64>,
    /// The estimate of each replication.
    pub replications: Vec<f64>,
    /// The cost of all, in episodes from beginning to end.
    pub episode_equivalents: f64,
    /// How many plain episodes would give the same relative error: `(1 - p) / (p e^2)`.
    pub plain_equivalent: Option<f64>,
}

/// Combines replications that were made with different seeds.
///
/// # Errors
/// [`CampaignError::Setting`] for fewer than two replications.
pub fn combine(
    descents: &[Descent],
    confidence: Confidence,
) -> Result<RareEstimate, CampaignError> {
    if descents.len() < 2 {
        let problem = "at least two replications are needed to estimate the error";
        return Err(CampaignError::setting("replications", problem));
    }
    let replications: Vec<f64> = descents.iter().map(|it| it.probability).collect();
    let count = replications.len() as f64;
    let mean = replications.iter().sum::<f64>() / count;
    let squares = replications.iter().map(|p| (p - mean).powi(2));
    let error = (squares.sum::<f64>() / (count - 1.0) / count).sqrt();
    let relative_error = (mean > 0.0).then(|| error / mean);
    let plain = relative_error.filter(|e| *e > 0.0);
    Ok(RareEstimate {
        probability: mean,
        interval: interval(descents, mean, relative_error, confidence),
        relative_error,
        replications,
        episode_equivalents: descents.iter().map(|it| it.cost).sum(),
        plain_equivalent: plain.map(|e| (1.0 - mean) / (mean * e * e)),
    })
}

fn interval(
    descents: &[Descent],
    mean: f64,
    relative_error: Option<f64>,
    confidence: Confidence,
) -> Interval {
    let plain = Sample {
        successes: descents.iter().map(|it| it.first_hits).sum(),
        trials: descents.iter().map(|it| it.first_runs).sum(),
    };
    // Equal estimates (all the first runs reached the top, for example) say nothing of their
    // error; then, and without any hit, the first runs are counted.
    let Some(relative) = relative_error.filter(|e| *e > 0.0) else {
        return clopper_pearson(plain, confidence);
    };
    let upper = 0.5 + confidence.level() / 2.0;
    let factor = (relative * student_t_quantile(upper, descents.len() as f64 - 1.0)).exp();
    Interval {
        low: mean / factor,
        high: (mean * factor).min(1.0),
    }
}
