//! Whether a finding is one that could have been found: what can be seen without solving or counting again.
//!
//! # Definition
//! * A rate lies in its interval, which lies in `[0, 1]`; no more successes than trials, no more independent trials
//!   than trials.
//! * An answer lies within its bounds, is the fraction that it is given as, and adds up to 1 with its complement.
//! * A distribution's quantiles ascend within `[0, 1]`. With them at `0.5 %, 1.5 %, ...` the mean lies between
//!
//! ```text
//! (0 + sum of q_1 .. q_99) / 100   and   (sum of q_2 .. q_100 + 1) / 100
//! ```
//!
//!   and each end of the interval between the two quantiles about it.
//!
//! # Guarantee
//! No sound finding is refused. Not every wrong one is: an answer that was changed within its bounds needs `--deep`.

use super::audit::Audit;
use crate::technique::Produced;
use evidence::{CredibleInterval, Guarantee, Interval, Measure, MethodAnswer, Reading, adds_up};
use std::path::Path;

/// What two roundings may differ by.
const ROUNDING: f64 = 1e-12;

/// Looks at every finding.
pub fn check(level: f64, path: &Path, produced: &Produced, audit: &mut Audit) {
    let mut right = 0;
    for (place, finding) in produced.findings.iter().enumerate() {
        let measure =
            measure(&finding.measure, level).map_err(|(at, fault)| ("measure", at, fault));
        let readings = finding.readings.iter().try_for_each(reading);
        let readings = readings.map_err(|fault| ("readings", String::new(), fault));
        match measure.and(readings) {
            Ok(()) => right += 1,
            Err((part, at, fault)) => {
                let place = format!("/content/findings/{place}/{part}{at}");
                audit.fault(path, &place, fault);
            }
        }
    }
    audit.checked(right, "values lie within their own intervals");
}

/// Where it is wrong, and why.
type Fault = (String, &'static str);

fn measure(measure: &Measure, level: f64) -> Result<(), Fault> {
    let at = |place: &'static str| move |fault: &'static str| (place.to_owned(), fault);
    match measure {
        Measure::Counts {
            count,
            trials,
            effective_trials,
            by_subject,
            subjects,
            interval,
        } => {
            let worth = effective_trials.unwrap_or(*trials as f64);
            hold(count <= trials && *trials > 0, "more successes than trials")
                .map_err(at("/count"))?;
            let possible = worth > 0.0 && worth <= *trials as f64 * (1.0 + ROUNDING);
            hold(
                possible,
                "its effective sample size is larger than its number of trials",
            )
            .map_err(at("/effective_trials"))?;
            let fits = |by_subject: &Vec<[u64; 2]>| adds_up(by_subject, [*count, *trials]);
            hold(
                by_subject.as_ref().is_none_or(fits),
                "its counts by subject or session do not add up to it, or one has more successes than trials",
            )
            .map_err(at("/by_subject"))?;
            // Results of older versions say of none how many there are.
            let listed = by_subject.as_ref().map(|it| it.len() as u64);
            let is_counted = subjects.is_none_or(|subjects| {
                (1..=*trials).contains(&subjects) && listed.is_none_or(|listed| listed == subjects)
            });
            hold(is_counted, "it has another number of subjects or sessions")
                .map_err(at("/subjects"))?;
            let rate = *count as f64 / *trials as f64;
            inside(rate, *interval).map_err(at("/interval"))
        }
        Measure::Probability {
            answer: main,
            others,
            credible,
        } => {
            answer(main).map_err(at("/answer"))?;
            for (index, other) in others.iter().enumerate() {
                answer(other).map_err(|fault| (format!("/others/{index}"), fault))?;
            }
            let credible = credible
                .as_ref()
                .map(|credible| distribution(credible, level));
            credible.unwrap_or(Ok(())).map_err(at("/credible"))
        }
        Measure::NotExpressible { .. } | Measure::NotCovered { .. } => Ok(()),
    }
}

fn reading(reading: &Reading) -> Result<(), &'static str> {
    hold(
        reading.count <= reading.trials,
        "more successes than trials",
    )
}

fn answer(answer: &MethodAnswer) -> Result<(), &'static str> {
    let rounding = |value: f64| ROUNDING * (1.0 + value.abs());
    let known_to = match answer.guarantee {
        Guarantee::Exact { .. } => ROUNDING,
        // Either may stand anywhere between the bounds.
        Guarantee::Bounded { low, high }
        | Guarantee::Schedulers { low, high, .. }
        | Guarantee::Statistical { low, high, .. } => ROUNDING + high - low,
        Guarantee::Estimated { .. } => f64::INFINITY,
    };
    if let Some(complement) = answer.complement {
        hold(
            (answer.value + complement - 1.0).abs() <= known_to,
            "the answer and its complement do not add up to 1",
        )?;
    }
    match &answer.guarantee {
        Guarantee::Bounded { low, high }
        | Guarantee::Schedulers { low, high, .. }
        | Guarantee::Statistical { low, high, .. } => inside_of(
            answer.value,
            (*low, *high),
            "the answer does not lie within its own bounds",
        ),
        Guarantee::Exact { rational } => {
            let parts = rational.as_deref().and_then(|text| text.split_once('/'));
            let parsed =
                parts.and_then(|(p, q)| Some((p.parse::<f64>().ok()?, q.parse::<f64>().ok()?)));
            let same = parsed.is_none_or(|(p, q)| (p / q - answer.value).abs() <= rounding(p / q));
            hold(same, "the answer is not the fraction that it is given as")?;
            inside_of(answer.value, (0.0, 1.0), "no probability")
        }
        Guarantee::Estimated { .. } => {
            let bounds = (-ROUNDING, 1.0 + ROUNDING);
            inside_of(answer.value, bounds, "no probability")
        }
    }
}

fn distribution(credible: &CredibleInterval, level: f64) -> Result<(), &'static str> {
    let Some(ends) = &credible.ends else {
        return quantiles(
            (credible.mean, &credible.quantiles),
            credible.interval,
            level,
        );
    };
    for end in [&ends.least, &ends.greatest] {
        quantiles((end.mean, &end.quantiles), end.interval, level)?;
    }
    // The least probability is nowhere above the greatest, so neither are its quantiles.
    let mut both = ends.least.quantiles.iter().zip(&ends.greatest.quantiles);
    hold(
        both.all(|(least, greatest)| *least <= greatest + ROUNDING),
        "the least probability over all schedulers is above the greatest",
    )?;
    let is_one_of_them = [&ends.least, &ends.greatest]
        .iter()
        .any(|end| end.mean == credible.mean && end.quantiles == credible.quantiles);
    hold(is_one_of_them, "the distribution is that of neither end")?;
    let Interval { low, high } = credible.interval;
    let reaches =
        low <= ends.least.interval.low + ROUNDING && high >= ends.greatest.interval.high - ROUNDING;
    hold(reaches, "the interval does not reach over both ends")
}

fn quantiles(
    (mean, quantiles): (f64, &[f64]),
    interval: Interval,
    level: f64,
) -> Result<(), &'static str> {
    let count = quantiles.len();
    let is_one = quantiles.is_sorted() && quantiles.iter().all(|q| (0.0..=1.0).contains(q));
    hold(
        is_one && count > 0,
        "the quantiles are not those of a probability",
    )?;
    let sum: f64 = quantiles.iter().sum();
    let bounds = (
        (sum - quantiles[count - 1]) / count as f64 - ROUNDING,
        (sum - quantiles[0] + 1.0) / count as f64 + ROUNDING,
    );
    inside_of(mean, bounds, "the mean is not that of its quantiles")?;
    let Interval { low, high } = interval;
    let between = |end: f64, probability: f64| {
        let position = probability * count as f64 - 0.5;
        let at = |index: f64| quantiles.get(index as usize).copied();
        let below = if position < 0.0 {
            None
        } else {
            at((position - ROUNDING).floor())
        };
        let above = at((position + ROUNDING).ceil().max(0.0));
        let bounds = (
            below.unwrap_or(0.0) - ROUNDING,
            above.unwrap_or(1.0) + ROUNDING,
        );
        inside_of(end, bounds, "the interval is not that of its quantiles")
    };
    between(low, 0.5 * (1.0 - level))?;
    between(high, 0.5 * (1.0 + level))
}

fn inside(value: f64, interval: Interval) -> Result<(), &'static str> {
    let Interval { low, high } = interval;
    hold(
        0.0 <= low && low <= high && high <= 1.0,
        "it is not an interval of probabilities",
    )?;
    let bounds = (low - ROUNDING, high + ROUNDING);
    inside_of(
        value,
        bounds,
        "the rate does not lie within its own interval",
    )
}

fn inside_of(value: f64, (low, high): (f64, f64), fault: &'static str) -> Result<(), &'static str> {
    hold(low <= value && value <= high, fault)
}

fn hold(holds: bool, fault: &'static str) -> Result<(), &'static str> {
    if holds { Ok(()) } else { Err(fault) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fault(measure: &serde_json::Value) -> Option<String> {
        let measure: Measure = serde_json::from_value(measure.clone()).expect("a measure");
        super::measure(&measure, 0.95).err().map(|(at, _)| at)
    }

    #[test]
    fn what_cannot_have_been_found_is_named_and_all_else_is_not() {
        let quantiles: Vec<f64> = (0..100).map(|i| (f64::from(i) + 0.5) / 100.0).collect();
        let counts = serde_json::json!({
            "kind": "counts", "count": 88, "trials": 100, "effective_trials": 39.5,
            "interval": {"low": 0.74, "high": 0.95}
        });
        let computed = serde_json::json!({
            "kind": "probability",
            "answer": {"method": "exact", "value": 0.25, "complement": 0.75,
                "guarantee": {"kind": "exact", "rational": "1/4"}, "iterations": null},
            "others": [{"method": "sound", "value": 0.25, "complement": null,
                "guarantee": {"kind": "bounded", "low": 0.2499, "high": 0.2501}, "iterations": 3}],
            "credible": {"mean": 0.5, "interval": {"low": 0.025, "high": 0.975}, "solves": 100,
                "spread": [], "quantiles": quantiles}
        });
        assert_eq!((fault(&counts), fault(&computed)), (None, None));
        for (right, path, value, place) in [
            (&counts, "/count", 101.0, "/count"),
            (&counts, "/count", 99.0, "/interval"),
            (&counts, "/interval/low", 0.89, "/interval"),
            (&counts, "/interval/high", 1.2, "/interval"),
            (&counts, "/effective_trials", 100.5, "/effective_trials"),
            (&computed, "/answer/value", 0.26, "/answer"),
            (&computed, "/answer/complement", 0.7, "/answer"),
            (&computed, "/others/0/value", 0.2502, "/others/0"),
            (&computed, "/credible/mean", 0.52, "/credible"),
            (&computed, "/credible/interval/low", 0.036, "/credible"),
            (&computed, "/credible/interval/high", 0.96, "/credible"),
            (&computed, "/credible/quantiles/7", 0.9, "/credible"),
        ] {
            let mut changed = right.clone();
            let whole = path.ends_with("count");
            *changed.pointer_mut(path).expect("a place") = match whole {
                true => (value as u64).into(),
                false => value.into(),
            };
            assert_eq!(fault(&changed).as_deref(), Some(place), "{path}");
        }
        let mut changed = computed.clone();
        changed["answer"]["guarantee"]["rational"] = "1/3".into();
        assert_eq!(fault(&changed).as_deref(), Some("/answer"));
    }
}
