//! The figures of a verdict in words. A limit is rounded away from its threshold's side, so that it never seems to lie on
//! the other one.

use super::CERTAINTY;
use super::stand::ClaimLevels;
use crate::compare::Belief;
use crate::compare::words::{p_value, percent, probability};
use crate::{Direction, Interval, Threshold};

/// Bounds of a computed value that are nearer to each other are within the digits in which the value is shown.
const SHOWN: f64 = 1e-4;

/// One piece in words, with the runs over which it is taken behind its figure (`given`), for example `E3: 88/100, rate <= 92.9 % (one-sided 95 % limit, p = 0.004 against rate >= 95 %)`.
pub(super) fn piece(
    (id, given): (&str, &str),
    belief: &Belief,
    threshold: Threshold,
    (p_not_met, p_met): (f64, f64),
    (limits, levels): (Interval, ClaimLevels),
    contradicted: Option<f64>,
) -> String {
    let leans_to_met = p_not_met <= p_met;
    match belief {
        Belief::Counts {
            sample,
            effective,
            before,
            ..
        } => {
            let counts = counted((sample.successes, sample.trials), given, effective.trials)
                + &counted_both_ways(belief);
            if is_certainty(threshold) {
                let contrary = match threshold.direction {
                    Direction::AtLeast => sample.failures(),
                    Direction::AtMost => sample.successes,
                };
                let seen = match contrary {
                    0 => "no violation".to_owned(),
                    1 => "1 violation".to_owned(),
                    many => format!("{many} violations"),
                };
                return format!("{id}: {counts}, {seen}");
            }
            let (p, level) = match leans_to_met {
                true => (p_not_met, levels.met),
                false => (p_met, levels.missed),
            };
            let at = match before {
                Some(_) => " at every look",
                None => "",
            };
            let contradicted = contradicted.map_or(String::new(), |contrary| {
                format!(
                    "; an earlier look showed the contrary (p {} against {}), and looks that contradict each other \
                     decide nothing",
                    p_value(contrary),
                    hypothesis(threshold, leans_to_met)
                )
            });
            if is_none(limits, threshold, leans_to_met) {
                return format!(
                    "{id}: {counts}, no limit shown on this side at {}{at} (p {} against {}){contradicted}",
                    percent(1.0 - level),
                    p_value(p),
                    hypothesis(threshold, !leans_to_met),
                );
            }
            format!(
                "{id}: {counts}, {} (one-sided {} limit{at}, p {} against {}){contradicted}",
                limit(limits, threshold, leans_to_met),
                percent(1.0 - level),
                p_value(p),
                hypothesis(threshold, !leans_to_met),
            )
        }
        Belief::Known {
            bounds,
            is_range: true,
            ..
        } => {
            let spans = match bounds.low < threshold.value && threshold.value < bounds.high {
                true => ": some meet it and others do not",
                false => "",
            };
            format!(
                "{id}: computed {} over all schedulers{given}{spans}",
                span(*bounds)
            )
        }
        Belief::Known { value, bounds, .. } if bounds.high - bounds.low >= SHOWN => format!(
            "{id}: computed {}{given} (between {} and {})",
            percent(*value),
            percent_down(bounds.low),
            percent_up(bounds.high)
        ),
        Belief::Known { value, .. } => format!(
            "{id}: computed {}{given}",
            // As many digits as show on which side of the threshold it lies, where that is not within rounding.
            match (*value - threshold.value).abs() > CERTAINTY {
                true => with_digits(*value, threshold.value, f64::round, percent),
                false => percent(*value),
            }
        ),
        Belief::Range { ends, .. } => {
            let (level, doubt) = match leans_to_met {
                true => (levels.met, p_not_met),
                false => (levels.missed, p_met),
            };
            format!(
                "{id}: computed {} over all schedulers{given}, {} under each of them ({} credible limit, probability {} of \
                 {} under each)",
                span(ends.as_written),
                limit(limits, threshold, leans_to_met),
                percent(1.0 - level),
                probability(1.0 - doubt),
                hypothesis(threshold, leans_to_met),
            )
        }
        Belief::Distribution { value, .. } => {
            // The posterior probability of meeting it is the doubt of missing it.
            let (level, chance) = match leans_to_met {
                true => (levels.met, p_met),
                false => (levels.missed, p_not_met),
            };
            format!(
                "{id}: computed {}{given}, {} ({} credible limit, probability {} of {})",
                percent(*value),
                limit(limits, threshold, leans_to_met),
                percent(1.0 - level),
                probability(chance),
                hypothesis(threshold, leans_to_met),
            )
        }
    }
}

/// Which runs count both ways, behind a count.
fn counted_both_ways(belief: &Belief) -> String {
    let undecided = match belief.undecided() {
        0 => String::new(),
        many => format!(" and {many} undecided, counted against and for"),
    };
    match belief.may_be_told_twice() {
        true => format!("{undecided} (copies counted once and each)"),
        false => undecided,
    }
}

/// `86.5 % to 93 %`; one number where both ends are shown alike.
fn span(ends: stats::Interval) -> String {
    let (low, high) = (percent(ends.low), percent(ends.high));
    match low == high {
        true => low,
        false => format!("{low} to {high}"),
    }
}

/// What a verdict says that takes from other columns how alike trials of one subject are.
pub const AS_ALIKE: &str =
    "it supposes that trials of one subject are as alike here as in the other columns of the table";

/// That a claim rests on how alike trials of one subject are in other columns.
pub(super) fn alike_as_elsewhere(p: f64) -> String {
    format!(
        "; {AS_ALIKE} (p {} with each subject as one trial)",
        p_value(p)
    )
}

/// That a claim rests on every attempt of a table being one in which this came to hold.
pub(super) fn each_triggers(trigger: &str) -> String {
    format!(
        "; it supposes that every attempt triggers it ({trigger}), which its tables do not count"
    )
}

/// That a claim rests on so few subjects being of every kind that there is.
pub(super) fn all_kinds_met(subjects: Option<u64>, p: f64) -> String {
    let Some(subjects) = subjects else {
        return String::new();
    };
    format!(
        "; it supposes that these {subjects} subjects are of every kind there is (p {} if some could always have the contrary \
         outcome and none of them was met)",
        p_value(p)
    )
}

/// `88/100 of the runs that trigger it (effective sample size 37)`.
fn counted((successes, trials): (u64, u64), given: &str, effective: f64) -> String {
    if effective < trials as f64 {
        let size = effective_size(effective);
        return format!("{successes}/{trials}{given} (effective sample size {size})");
    }
    format!("{successes}/{trials}{given}")
}

/// An effective sample size in digits that are the same wherever it is shown.
///
/// ```
/// assert_eq!(evidence::effective_size(37.25), "37");
/// assert_eq!(evidence::effective_size(4.04), "4.0");
/// ```
#[must_use]
pub fn effective_size(size: f64) -> String {
    match size {
        size if size < 10.0 => format!("{size:.1}"),
        size => format!("{size:.0}"),
    }
}

/// The limit toward which a piece leans: `rate >= 90.1 %`.
fn limit(limits: Interval, threshold: Threshold, leans_to_met: bool) -> String {
    let is_lower = (threshold.direction == Direction::AtLeast) == leans_to_met;
    match is_lower {
        true => format!("rate >= {}", lower(limits.low, threshold.value)),
        false => format!("rate <= {}", upper(limits.high, threshold.value)),
    }
}

/// Whether the limit toward which a piece leans is none: every rate is at least 0 and at most 1.
fn is_none(limits: Interval, threshold: Threshold, leans_to_met: bool) -> bool {
    match (threshold.direction == Direction::AtLeast) == leans_to_met {
        true => limits.low <= 0.0,
        false => limits.high >= 1.0,
    }
}

/// "The threshold is met" or its contrary: `rate >= 95 %`, `rate < 95 %`.
pub(super) fn hypothesis(threshold: Threshold, is_met: bool) -> String {
    let sign = match (threshold.direction, is_met) {
        (Direction::AtLeast, true) => ">=",
        (Direction::AtLeast, false) => "<",
        (Direction::AtMost, true) => "<=",
        (Direction::AtMost, false) => ">",
    };
    format!("rate {sign} {}", declared(threshold.value))
}

/// A threshold in percent with no more and no fewer digits than were declared: who reads "85 %" for 84.95 % reads a false sentence.
fn declared(value: f64) -> String {
    // Twelve digits hide the binary representation.
    format!("{} %", (value * 1e14).round() / 1e12)
}

/// Whether a requirement asks for all or none.
pub(super) fn is_certainty(threshold: Threshold) -> bool {
    match threshold.direction {
        Direction::AtLeast => threshold.value >= 1.0,
        Direction::AtMost => threshold.value <= 0.0,
    }
}

/// What a requirement asks for, as the subject of a sentence.
pub(super) fn asked(threshold: Threshold) -> String {
    match is_certainty(threshold) {
        true if threshold.direction == Direction::AtLeast => "certainty (rate = 100 %)".to_owned(),
        true => "impossibility (rate = 0 %)".to_owned(),
        false => hypothesis(threshold, true),
    }
}

/// A lower limit with as many digits as show on which side of the threshold it lies.
fn lower(limit: f64, threshold: f64) -> String {
    with_digits(limit, threshold, f64::floor, percent_down)
}

/// An upper limit, likewise.
fn upper(limit: f64, threshold: f64) -> String {
    with_digits(limit, threshold, f64::ceil, percent_up)
}

fn with_digits(
    limit: f64,
    threshold: f64,
    round: fn(f64) -> f64,
    plain: fn(f64) -> String,
) -> String {
    let mut scale = 1e3;
    while scale < 1e12 {
        let rounded = round(limit * scale) / scale;
        if (rounded < threshold) == (limit < threshold)
            && (rounded > threshold) == (limit > threshold)
        {
            break;
        }
        scale *= 10.0;
    }
    if scale == 1e3 || limit <= 0.0 || limit >= 1.0 {
        return plain(limit);
    }
    let digits = (scale.log10() - 2.0).round() as usize;
    format!("{:.*} %", digits, 100.0 * round(limit * scale) / scale)
}

/// A lower bound in percent, rounded down so that the sentence stays true.
pub(super) fn percent_down(bound: f64) -> String {
    if bound >= 1.0 {
        return percent(1.0);
    }
    let mut scale = 1e3;
    while 1.0 - bound < 1.0 / scale && scale < 1e12 {
        scale *= 10.0;
    }
    percent((bound * scale).floor() / scale)
}

/// An upper bound in percent, rounded up.
pub(super) fn percent_up(bound: f64) -> String {
    if bound <= 0.0 {
        return percent(0.0);
    }
    let mut scale = 1e3;
    while bound < 1.0 / scale && scale < 1e12 {
        scale *= 10.0;
    }
    percent(((bound * scale).ceil() / scale).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_without_width_is_one_number() {
        let of = |low, high| span(stats::Interval { low, high });
        assert_eq!(of(1.0, 1.0), "100 %");
        assert_eq!(of(0.865, 0.93), "86.5 % to 93 %");
    }

    #[test]
    fn a_rounded_limit_stays_on_its_side_of_the_threshold() {
        assert_eq!(lower(0.9512, 0.95), "95.1 %");
        assert_eq!(lower(0.95001, 0.95), "95.001 %");
        assert_eq!(lower(0.94999, 0.95), "94.9 %");
        assert_eq!(upper(0.94999, 0.95), "94.999 %");
        assert_eq!(upper(0.9412, 0.95), "94.2 %");
        assert_eq!(upper(1.0, 0.95), "100 %");
        assert_eq!(lower(0.0, 0.95), "0 %");
    }

    #[test]
    fn a_known_value_shows_on_which_side_of_the_threshold_it_lies() {
        let of = |value| with_digits(value, 0.3, f64::round, percent);
        assert_eq!(of(0.300_000_1), "30.00001 %");
        assert_eq!(of(0.299_999_99), "29.999999 %");
        assert_eq!(of(0.31), "31 %");
        assert_eq!(of(1e-13), "practically 0 %");
        assert_eq!(declared(0.8495), "84.95 %");
        assert_eq!(declared(0.07), "7 %");
        assert_eq!(declared(0.999_999), "99.9999 %");
    }
}
