//! What an interval at a level says of a rate, where no more than that is known of it.
//!
//! # Definition
//! A value lies in `[low, high]` with confidence `c`. What is believed of it is the beta distribution around the middle of the
//! interval whose central interval at level `c` has the whole of it, and which is otherwise as narrow as it can be. An end at 0
//! or 1 is that of all rates, so that the other end alone is to be reached.
//!
//! Source: fitting a beta distribution to an interval is how experts' probabilities are elicited (O'Hagan et al., "Uncertain
//! Judgements", 2006); here it covers the interval, where they fit both ends as well as they can. Cost: some 100 quantiles.
//!
//! # Assumes
//! That the interval has its level, whoever found it, and that it is independent of what it is compared with.
//!
//! # Guarantee
//! At level `c` it is never narrower than the interval. At other levels it is an approximation, as wherever a beta distribution
//! stands for another one.

use stats::BetaPosterior;

/// The fewest and the most runs that an interval may be worth: of fewer than two nothing is known, and more are a number.
const WORTH: (f64, f64) = (2.0, 1e12);
/// Steps from the most to the fewest, by their logarithm. Very few runs lie at 0 and 1 and may have less of an interval than
/// more runs, so that not all is halved at once.
const STEPS: u32 = 64;
/// Halvings of the step that leads to a distribution that has the interval.
const HALVINGS: u32 = 40;

/// The distribution of a value that lies between these with this confidence, or in words why there is none.
pub(super) fn of_interval(
    (low, high): (f64, f64),
    confidence: f64,
) -> Result<BetaPosterior, String> {
    let middle = f64::midpoint(low, high);
    let tail = (1.0 - confidence) / 2.0;
    let around = |size: f64| BetaPosterior::new(middle * size, (1.0 - middle) * size).ok();
    let has_it = |of: &BetaPosterior| {
        (low <= 0.0 || of.quantile(tail) <= low) && (high >= 1.0 || of.quantile_upper(tail) >= high)
    };
    let (fewest, most) = (WORTH.0.ln(), WORTH.1.ln());
    let step = (most - fewest) / f64::from(STEPS);
    let is_level = 0.0 < confidence && confidence < 1.0;
    let tried = (0..=STEPS).map(|steps| most - step * f64::from(steps));
    let first = tried.filter(|_| is_level).find_map(|size| {
        let found = around(size.exp()).filter(&has_it)?;
        Some((found, size))
    });
    let (mut found, mut wide) = first.ok_or_else(|| {
        format!("has an answer of which nearly nothing is known: {low} to {high} at {confidence}")
    })?;
    let mut narrow = wide + step;
    for _ in 0..HALVINGS {
        let between = f64::midpoint(wide, narrow);
        match around(between.exp()).filter(&has_it) {
            Some(wider) => (found, wide) = (wider, between),
            None => narrow = between,
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stats::Confidence;

    /// At its own level never narrower than the interval, at stricter levels wider, and not much wider than it has to be.
    #[test]
    fn what_is_believed_is_as_uncertain_as_the_interval() {
        for confidence in [0.9, 0.95, 0.999] {
            for (low, high) in [
                (0.4, 0.6),
                (0.93, 0.999),
                (0.0, 0.03),
                (0.97, 1.0),
                (0.2, 0.2002),
            ] {
                let found = of_interval((low, high), confidence).expect("it says something");
                let at = |level: f64| {
                    let level = Confidence::new(level).expect("a level");
                    found.credible_interval(level)
                };
                let (own, stricter) = (at(confidence), at(1.0 - (1.0 - confidence) / 10.0));
                let case = format!("{low} to {high} at {confidence}: {own:?}");
                assert!(low <= 0.0 || own.low <= low + 1e-12, "{case}");
                assert!(high >= 1.0 || own.high >= high - 1e-12, "{case}");
                assert!(
                    stricter.low < own.low && stricter.high > own.high,
                    "{case}, {stricter:?}"
                );
                let is_touched = (low > 0.0 && own.low > low * (1.0 - 1e-6))
                    || (high < 1.0 && own.high < high * (1.0 + 1e-6));
                assert!(is_touched, "{case}");
            }
        }
    }

    #[test]
    fn an_interval_over_nearly_everything_says_nothing() {
        let error = of_interval((0.001, 0.999), 0.5).expect_err("too wide");
        assert!(error.contains("nearly nothing is known"), "{error}");
        assert!(of_interval((0.4, 0.6), 1.0).is_err());
    }
}
