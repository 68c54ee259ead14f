//! How a number varies between episodes: distribution function and quantiles.
//!
//! ```text
//! constant      F jumps to 1 at the value
//! uniform       F(x) = (x - low) / (high - low)
//! normal        F(x) = (Phi((x - mean)/sd) - Phi(l)) / (Phi(h) - Phi(l))    cut off at l and h
//! log-uniform   F(x) = ln(x / low) / ln(high / low)
//! triangular    F(x) = (x - low)^2 / ((high - low)(mode - low)) up to the mode, mirrored above
//! integer       low, low + 1, ..., high equally likely
//! choice        each value (or label) with its weight; a label's number is its place from 0
//! boolean       1 with the given probability, else 0
//! ```
//!
//! Source: textbook definitions. Quantiles are generalised inverses, `Q(u) = min { x : F(x) >= u }`.
//! Cost: constant time, linear in the number of choices. Guarantee: `Q` is monotone and stays
//! inside the support; for a discrete distribution [`Distribution::unit_of`] is the middle of the
//! interval that leads to the value, so that the round trip gives the value back exactly.

mod text;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::StimulusError;
use crate::normal;
pub(crate) use text::{DETAILS, KINDS, Table};

/// How a number varies between episodes.
///
/// In TOML and JSON it is a plain number or a table of one line: `{ uniform = [1.0, 15.0] }`,
/// `{ normal = [0.0, 0.004], low = -0.02, high = 0.02 }` (mean and standard deviation; the cuts may
/// be left out), `{ log_uniform = [1e-3, 1.0] }`, `{ triangular = [0.0, 1.0, 5.0] }` (low, mode,
/// high), `{ integer = [1, 6] }`, `{ choice = ["low", "high"], weights = [1, 3] }`,
/// `{ boolean = 0.5 }`.
#[derive(Debug, Clone, PartialEq)]
pub enum Distribution {
    /// Always this value.
    Constant(f64),
    /// Uniform between two values.
    Uniform {
        /// Lowest value.
        low: f64,
        /// Highest value.
        high: f64,
    },
    /// Normal, cut off below `low` and above `high` (infinite: not cut off).
    Normal {
        /// Mean before the cut.
        mean: f64,
        /// Standard deviation before the cut, positive.
        sd: f64,
        /// Lowest value, or minus infinity.
        low: f64,
        /// Highest value, or infinity.
        high: f64,
    },
    /// Uniform in the logarithm, between two positive values.
    LogUniform {
        /// Lowest value.
        low: f64,
        /// Highest value.
        high: f64,
    },
    /// Triangular.
    Triangular {
        /// Lowest value.
        low: f64,
        /// Likeliest value.
        mode: f64,
        /// Highest value.
        high: f64,
    },
    /// One of the whole numbers from `low` to `high`, equally likely.
    Integer {
        /// Lowest value.
        low: i64,
        /// Highest value.
        high: i64,
    },
    /// One of several values, with weights.
    Choice {
        /// What can be chosen.
        options: Options,
        /// A weight, not negative, for each option; they need not add up to 1.
        weights: Vec<f64>,
    },
    /// Yes (1) or no (0).
    Boolean {
        /// Probability of yes.
        probability: f64,
    },
}

/// What a choice chooses between.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema, Deserialize)]
#[serde(untagged)]
pub enum Options {
    /// Numbers, which need not be in order.
    Numbers(Vec<f64>),
    /// Labels; the number of a label is its place, from 0.
    Labels(Vec<String>),
}

impl Options {
    /// How many there are.
    #[must_use]
    pub fn len(&self) -> usize {
        match self {
            Self::Numbers(numbers) => numbers.len(),
            Self::Labels(labels) => labels.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of the option at `index`: itself, or the label's place.
    fn number(&self, index: usize) -> f64 {
        match self {
            Self::Numbers(numbers) => numbers.get(index).copied().unwrap_or(f64::NAN),
            Self::Labels(_) => index as f64,
        }
    }
}

impl Distribution {
    /// Checks numbers and their order.
    ///
    /// # Errors
    /// [`StimulusError::Distribution`] saying what is wrong.
    pub fn check(&self) -> Result<(), StimulusError> {
        let wrong = |what: &str| Err(StimulusError::Distribution(what.to_owned()));
        match self {
            Self::Constant(value) if !value.is_finite() => wrong("the value must be finite"),
            Self::Uniform { low, high } => check_order(*low, *high),
            Self::LogUniform { low, .. } if *low <= 0.0 => {
                wrong("log_uniform needs a lowest value above 0")
            }
            Self::LogUniform { low, high } => check_order(*low, *high),
            Self::Triangular { low, mode, high } => {
                check_order(*low, *mode).and_then(|()| check_order(*mode, *high))
            }
            Self::Normal { mean, sd, .. } if !mean.is_finite() || !sd.is_finite() || *sd <= 0.0 => {
                wrong("normal needs a finite mean and a standard deviation above 0")
            }
            Self::Normal {
                mean,
                sd,
                low,
                high,
            } => check_cuts((low - mean) / sd, (high - mean) / sd),
            Self::Integer { low, high } if low > high => {
                wrong("the lowest value lies above the highest")
            }
            Self::Integer { low, high } => check_integers(*low, *high),
            Self::Choice { options, weights } => check_choice(options, weights),
            Self::Boolean { probability } if !(0.0..=1.0).contains(probability) => {
                wrong("boolean needs a probability between 0 and 1")
            }
            Self::Constant(_) | Self::Boolean { .. } => Ok(()),
        }
    }

    /// The value at `u` of the way through the distribution, `Q(u)`; `u` is cut to `[0, 1]`.
    ///
    /// A normal distribution that is not cut off is taken between its quantiles at 2^-53 and
    /// 1 - 2^-53 (8.2 standard deviations), so that the value is always finite.
    #[must_use]
    pub fn quantile(&self, u: f64) -> f64 {
        let u = if u.is_nan() { 0.5 } else { u.clamp(0.0, 1.0) };
        match self {
            Self::Constant(value) => *value,
            Self::Uniform { low, high } => between(*low, *high, u),
            Self::Normal {
                mean,
                sd,
                low,
                high,
            } => {
                let inside = u.clamp(f64::EPSILON / 2.0, 1.0 - f64::EPSILON / 2.0);
                let z = normal::truncated_quantile((low - mean) / sd, (high - mean) / sd, inside);
                (mean + sd * z).clamp(*low, *high)
            }
            Self::LogUniform { low, high } => {
                (between(low.ln(), high.ln(), u)).exp().clamp(*low, *high)
            }
            Self::Triangular { low, mode, high } => triangular_quantile(*low, *mode, *high, u),
            Self::Integer { low, high } => integer_quantile(*low, *high, u),
            Self::Choice { options, weights } => options.number(chosen(weights, u)),
            Self::Boolean { probability } if *probability >= 1.0 => 1.0,
            Self::Boolean { probability } => f64::from(u > 1.0 - probability),
        }
    }

    /// The distribution function `F(x) = P(X <= x)`.
    #[must_use]
    pub fn cdf(&self, x: f64) -> f64 {
        match self {
            Self::Constant(value) => f64::from(x >= *value),
            Self::Uniform { low, high } => share(*low, *high, x),
            Self::Normal {
                mean,
                sd,
                low,
                high,
            } => normal::truncated_cdf((low - mean) / sd, (high - mean) / sd, (x - mean) / sd),
            Self::LogUniform { low, high } => share(low.ln(), high.ln(), x.max(*low).ln()),
            Self::Triangular { low, mode, high } => triangular_cdf(*low, *mode, *high, x),
            Self::Integer { low, high } => share(
                *low as f64 - 1.0,
                *high as f64,
                x.floor().max(*low as f64 - 1.0),
            ),
            Self::Choice { options, weights } => {
                let at_most = |index: &usize| options.number(*index) <= x;
                let below: f64 = (0..weights.len()).filter(at_most).map(|i| weights[i]).sum();
                below / weights.iter().sum::<f64>()
            }
            Self::Boolean { .. } if x >= 1.0 => 1.0,
            Self::Boolean { probability } => (1.0 - probability) * f64::from(x >= 0.0),
        }
    }

    /// The coordinate in `[0, 1]` that [`quantile`](Self::quantile) leads back to `value`.
    ///
    /// Continuous: `F(value)`. Discrete: the middle of the value's interval (of the nearest
    /// value's, if it is none of them). Constant: 1/2.
    #[must_use]
    pub fn unit_of(&self, value: f64) -> f64 {
        match self {
            Self::Constant(_) => 0.5,
            Self::Integer { low, high } => {
                let count = *high as f64 - *low as f64 + 1.0;
                let place = (value.round() - *low as f64).clamp(0.0, count - 1.0);
                (place + 0.5) / count
            }
            Self::Choice { options, weights } => {
                let distance = |i: &usize| (options.number(*i) - value).abs();
                let nearest = (0..weights.len())
                    .filter(|i| weights[*i] > 0.0)
                    .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                    .unwrap_or(0);
                let before: f64 = weights[..nearest].iter().sum();
                (before + 0.5 * weights[nearest]) / weights.iter().sum::<f64>()
            }
            Self::Boolean { probability } if value >= 0.5 => 1.0 - 0.5 * probability,
            Self::Boolean { probability } => 0.5 * (1.0 - probability),
            _ => self.cdf(value),
        }
    }

    /// The smallest and the largest value that can come.
    #[must_use]
    pub fn support(&self) -> [f64; 2] {
        match self {
            Self::Normal { low, high, .. } => [*low, *high],
            Self::Choice { options, weights } => {
                let possible = (0..weights.len()).filter(|i| weights[*i] > 0.0);
                possible.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], i| {
                    [low.min(options.number(i)), high.max(options.number(i))]
                })
            }
            _ => [self.quantile(0.0), self.quantile(1.0)],
        }
    }

    /// Whether `value` can come (for a continuous distribution: lies inside the support).
    #[must_use]
    pub fn contains(&self, value: f64) -> bool {
        let [low, high] = self.support();
        let inside = (low..=high).contains(&value);
        match self {
            Self::Integer { .. } => inside && value.fract() == 0.0,
            Self::Choice { options, weights } => {
                (0..weights.len()).any(|i| weights[i] > 0.0 && options.number(i) == value)
            }
            Self::Boolean { .. } => inside && (value == 0.0 || value == 1.0),
            _ => inside,
        }
    }

    /// The number of values a discrete distribution has, `None` for a continuous one.
    #[must_use]
    pub fn cardinality(&self) -> Option<u64> {
        match self {
            Self::Constant(_) => Some(1),
            Self::Integer { low, high } => Some(high.abs_diff(*low).saturating_add(1)),
            Self::Choice { options, .. } => Some(options.len() as u64),
            Self::Boolean { .. } => Some(2),
            _ => None,
        }
    }
}

fn between(low: f64, high: f64, u: f64) -> f64 {
    (low * (1.0 - u) + high * u).clamp(low, high)
}

/// How far `x` is on the way from `low` to `high`, within 0 and 1; a way without length is
/// covered once it is reached.
fn share(low: f64, high: f64, x: f64) -> f64 {
    if high > low {
        ((x - low) / (high - low)).clamp(0.0, 1.0)
    } else {
        f64::from(x >= low)
    }
}

fn triangular_quantile(low: f64, mode: f64, high: f64, u: f64) -> f64 {
    let rising = share(low, high, mode);
    let value = if u <= rising {
        low + (u * (high - low) * (mode - low)).sqrt()
    } else {
        high - ((1.0 - u) * (high - low) * (high - mode)).sqrt()
    };
    value.clamp(low, high)
}

fn triangular_cdf(low: f64, mode: f64, high: f64, x: f64) -> f64 {
    if x <= low || x >= high {
        return f64::from(x >= high);
    }
    if x <= mode {
        (x - low).powi(2) / ((high - low) * (mode - low))
    } else {
        1.0 - (high - x).powi(2) / ((high - low) * (high - mode))
    }
}

/// The whole number whose interval of `u` (of equal length, closed above) holds `u`.
fn integer_quantile(low: i64, high: i64, u: f64) -> f64 {
    let count = high as f64 - low as f64 + 1.0;
    let place = ((u * count).ceil() - 1.0).clamp(0.0, count - 1.0);
    low as f64 + place
}

/// The first option at which the accumulated weight reaches `u` of the whole; never one of
/// weight 0.
fn chosen(weights: &[f64], u: f64) -> usize {
    let wanted = u * weights.iter().sum::<f64>();
    let mut sum = 0.0;
    let mut last = 0;
    for (index, weight) in weights.iter().enumerate().filter(|(_, w)| **w > 0.0) {
        sum += weight;
        last = index;
        if sum >= wanted {
            break;
        }
    }
    last
}

fn check_order(low: f64, high: f64) -> Result<(), StimulusError> {
    let problem = if !(low.is_finite() && high.is_finite()) {
        "its numbers must be finite"
    } else if low > high {
        "its numbers must not descend (low first)"
    } else {
        return Ok(());
    };
    Err(StimulusError::Distribution(problem.to_owned()))
}

/// Cuts in standard deviations from the mean must leave something between them.
fn check_cuts(low: f64, high: f64) -> Result<(), StimulusError> {
    let problem = if low.is_nan() || high.is_nan() {
        "its cuts must be numbers"
    } else if low >= high {
        "its lowest value must lie below its highest"
    } else if low > 30.0 || high < -30.0 {
        "its cuts leave only what lies beyond 30 standard deviations"
    } else {
        return Ok(());
    };
    Err(StimulusError::Distribution(problem.to_owned()))
}

/// Beyond 2^53 whole numbers are no longer exact as a coordinate.
fn check_integers(low: i64, high: i64) -> Result<(), StimulusError> {
    const LARGEST: u64 = 1 << 53;
    if low.unsigned_abs() > LARGEST || high.unsigned_abs() > LARGEST {
        return Err(StimulusError::Distribution(
            "whole numbers must lie within 2^53 of 0".to_owned(),
        ));
    }
    Ok(())
}

fn check_choice(options: &Options, weights: &[f64]) -> Result<(), StimulusError> {
    let problem = if options.is_empty() {
        "choice needs at least one option"
    } else if weights.len() != options.len() {
        "choice needs as many weights as options"
    } else if weights.iter().any(|w| !w.is_finite() || *w < 0.0) {
        "weights must be finite and not negative"
    } else if weights.iter().sum::<f64>() <= 0.0 {
        "some weight must be above 0"
    } else if !weights.iter().sum::<f64>().is_finite() {
        "weights must have a finite sum"
    } else if has_twins(options) {
        "no option may be there twice: give it more weight instead"
    } else {
        return Ok(());
    };
    Err(StimulusError::Distribution(problem.to_owned()))
}

fn has_twins(options: &Options) -> bool {
    match options {
        Options::Numbers(numbers) => numbers
            .iter()
            .enumerate()
            .any(|(i, a)| !a.is_finite() || numbers[..i].contains(a)),
        Options::Labels(labels) => labels
            .iter()
            .enumerate()
            .any(|(i, a)| labels[..i].contains(a)),
    }
}

#[cfg(test)]
mod tests;
