//! Numbers as people read them: sensible digits, never a rounded-away fact.
//!
//! The one rule: a probability that is not 0 or 1 is never printed as 0 or 1.
//! Close to either end, digits are added until two significant ones of the
//! distance show; further away than that can be read, the distance itself is
//! printed in powers of ten (`1 − 1.1×10⁻⁵³`).

use evidence::{Guarantee, Interval, MethodAnswer};

/// Printed where there is no number.
pub const NONE: &str = "–";

const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// More decimals of a percentage than this are not readable.
const MOST_DECIMALS: usize = 8;

/// `1.1×10⁻⁵³`; one decimal in the mantissa.
pub fn scientific(value: f64) -> String {
    let plain = format!("{value:.1e}");
    let Some((mantissa, exponent)) = plain.split_once('e') else {
        return NONE.to_owned();
    };
    let raised: String = exponent
        .chars()
        .map(|c| match c.to_digit(10) {
            Some(digit) => SUPERSCRIPTS[digit as usize],
            None => '⁻',
        })
        .collect();
    format!("{}×10{raised}", minus(mantissa))
}

/// The text with a typographic minus in place of a hyphen.
fn minus(text: &str) -> String {
    text.replace('-', "−")
}

/// Decimals of the percentage at which `rate` can be told from 0 and 1;
/// `None` if that takes more than can be read.
fn decimals(rate: f64, usual: usize) -> Option<usize> {
    let distance = rate.min(1.0 - rate).abs();
    if distance == 0.0 {
        return Some(0);
    }
    if distance >= 0.001 {
        return Some(usual);
    }
    let needed = (-(distance * 100.0).log10()).ceil().max(0.0) as usize + 1;
    (needed <= MOST_DECIMALS).then_some(needed.max(usual))
}

/// A rate without its per cent sign, or in powers of ten (then `true`).
fn percentage(rate: f64, usual: usize) -> (String, bool) {
    if !rate.is_finite() {
        return (NONE.to_owned(), true);
    }
    match decimals(rate, usual) {
        // Without the sign of -0.
        Some(digits) => (minus(&format!("{:.digits$}", rate * 100.0 + 0.0)), false),
        None if rate < 0.5 => (scientific(rate), true),
        None => (format!("1 − {}", scientific(1.0 - rate)), true),
    }
}

fn with_unit((text, complete): (String, bool)) -> String {
    if complete {
        text
    } else {
        format!("{text}\u{a0}%")
    }
}

/// A rate as a percentage with one decimal, more where that would print 0 or
/// 100 for something else.
pub fn percent(rate: f64) -> String {
    with_unit(percentage(rate, 1))
}

/// A lower bound as a percentage with one decimal: rounded down, so that what
/// is printed is a lower bound too.
pub fn lower_bound(rate: f64) -> String {
    // The sliver keeps 0.795 * 1000 from falling below 795.
    percent((rate * 1000.0 + 1e-9).floor() / 1000.0)
}

/// A threshold or a confidence level: no more digits than were declared.
pub fn level(value: f64) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    // Twelve digits hide the binary representation of, say, 0.07 * 100.
    let rounded = (value * 1e14).round() / 1e12;
    format!("{rounded}\u{a0}%")
}

/// An interval of rates: `80.2–93.0 %`.
pub fn interval(interval: Interval) -> String {
    let low = percentage(interval.low, 1);
    let high = percentage(interval.high, 1);
    if low.0 == high.0 {
        with_unit(high)
    } else if low.1 || high.1 {
        format!("{} to {}", with_unit(low), with_unit(high))
    } else {
        format!("{}–{}\u{a0}%", low.0, high.0)
    }
}

/// A computed probability: two decimals of a percentage, or its distance from
/// one where the answer carries that; of a decision process its range over all schedulers.
pub fn answer(answer: &MethodAnswer) -> String {
    if let Guarantee::Schedulers { low, high, .. } = answer.guarantee {
        return interval(Interval { low, high });
    }
    match answer.complement {
        Some(rest) if rest > 0.0 && rest < 1e-6 => format!("1 − {}", scientific(rest)),
        _ => with_unit(percentage(answer.value, 2)),
    }
}

/// A quantity without unit, with so many decimals.
pub fn decimal(value: f64, decimals: usize) -> String {
    if value.is_finite() {
        minus(&format!("{value:.decimals$}"))
    } else {
        NONE.to_owned()
    }
}

/// Every digit of a computed probability.
pub fn full(value: f64) -> String {
    if !value.is_finite() {
        NONE.to_owned()
    } else if value != 0.0 && value.abs() < 1e-5 {
        minus(&format!("{value:e}"))
    } else {
        minus(&format!("{value}"))
    }
}

/// What is known of a computed probability's error, in a few words.
pub fn guarantee(guarantee: &Guarantee) -> String {
    match guarantee {
        Guarantee::Exact { rational: Some(r) } => format!("exact: {r}"),
        Guarantee::Exact { rational: None } => "exact".to_owned(),
        Guarantee::Bounded { low, high } if high - low == 0.0 => {
            "bounded, to the last digit".to_owned()
        }
        Guarantee::Bounded { low, high } if high - low < 1e-6 => {
            format!("bounded, within {}", scientific(high - low))
        }
        Guarantee::Bounded { low, high } => format!(
            "bounded: {}",
            interval(Interval {
                low: *low,
                high: *high
            })
        ),
        Guarantee::Schedulers { low, high, .. } => format!(
            "over all schedulers: {}",
            interval(Interval {
                low: *low,
                high: *high
            })
        ),
        Guarantee::Statistical {
            confidence,
            low,
            high,
        } => format!(
            "statistical at {}: {}",
            level(*confidence),
            interval(Interval {
                low: *low,
                high: *high
            })
        ),
        Guarantee::Estimated { .. } => "estimated, error unknown".to_owned(),
    }
}

/// A p-value or posterior probability.
pub fn p_value(p: f64) -> String {
    match p {
        p if !p.is_finite() => NONE.to_owned(),
        0.0 => "0".to_owned(),
        p if p < 0.0001 => scientific(p),
        p if p < 0.001 => format!("{p:.5}"),
        p if p < 0.01 => format!("{p:.4}"),
        p if p > 0.999 && p < 1.0 => "> 0.999".to_owned(),
        p => format!("{p:.3}"),
    }
}

/// A difference of rates in percentage points, signed.
pub fn points(difference: f64) -> String {
    if !difference.is_finite() {
        return NONE.to_owned();
    }
    let scaled = difference * 100.0;
    if scaled == 0.0 {
        return "0".to_owned();
    }
    if scaled.abs() >= 0.05 {
        return minus(&format!("{scaled:+.1}"));
    }
    let sign = if difference < 0.0 { "−" } else { "+" };
    let digits = (-scaled.abs().log10()).ceil() as usize + 1;
    if digits <= MOST_DECIMALS {
        format!("{sign}{:.digits$}", scaled.abs())
    } else {
        format!("{sign}{}", scientific(scaled.abs()))
    }
}

/// A count with separators: `236,643`.
pub fn count(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// An elapsed time.
pub fn duration(secs: f64) -> String {
    match secs {
        s if !s.is_finite() || s < 0.0 => NONE.to_owned(),
        s if s < 0.9995e-3 => format!("{:.0}\u{a0}µs", s * 1e6),
        s if s < 0.9995 => format!("{:.0}\u{a0}ms", s * 1e3),
        s if s < 59.95 => format!("{s:.1}\u{a0}s"),
        s if s < 3599.5 => {
            let whole = s.round() as u64;
            format!("{}\u{a0}min {}\u{a0}s", whole / 60, whole % 60)
        }
        s => {
            let minutes = (s / 60.0).round() as u64;
            format!("{}\u{a0}h {}\u{a0}min", count(minutes / 60), minutes % 60)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(text: String) -> String {
        text.replace('\u{a0}', " ")
    }

    #[test]
    fn a_rate_near_an_end_is_never_printed_as_the_end() {
        for (rate, text) in [
            (0.88, "88.0 %"),
            (0.998, "99.8 %"),
            (0.9996, "99.960 %"),
            (0.9999948082592586, "99.99948 %"),
            (1.0 - 1e-14, "1 − 1.0×10⁻¹⁴"),
            (1.12e-53, "1.1×10⁻⁵³"),
            (0.0, "0 %"),
            (1.0, "100 %"),
            (f64::NAN, "–"),
        ] {
            assert_eq!(plain(percent(rate)), text);
        }
    }

    #[test]
    fn a_lower_bound_is_rounded_down() {
        assert_eq!(plain(lower_bound(0.7538)), "75.3 %");
        assert_eq!(plain(lower_bound(0.795)), "79.5 %");
        assert_eq!(plain(lower_bound(0.99999)), "99.9 %");
        assert_eq!(plain(lower_bound(1.0)), "100 %");
    }

    #[test]
    fn no_rate_strictly_inside_prints_as_certain_or_impossible() {
        for exponent in 1..300 {
            let tiny = 10f64.powi(-exponent) * 0.999;
            for rate in [tiny, 1.0 - tiny] {
                if rate > 0.0 && rate < 1.0 {
                    let text = plain(percent(rate));
                    let number = text.trim_end_matches(" %").parse::<f64>();
                    assert!(number != Ok(0.0) && number != Ok(100.0), "{rate:e}: {text}");
                }
            }
        }
    }

    #[test]
    fn the_complement_shows_what_the_double_cannot_hold() {
        let sound = MethodAnswer {
            method: "sound".into(),
            value: 1.0,
            complement: Some(1.12e-53),
            guarantee: Guarantee::Exact { rational: None },
            iterations: None,
        };
        assert_eq!(answer(&sound), "1 − 1.1×10⁻⁵³");
    }

    #[test]
    fn intervals_share_their_unit() {
        let text = |low, high| plain(interval(Interval { low, high }));
        assert_eq!(text(0.8019, 0.93), "80.2–93.0 %");
        assert_eq!(text(0.0, 0.0361), "0–3.6 %");
        assert_eq!(text(0.0, 1e-12), "0 % to 1.0×10⁻¹²");
        assert_eq!(text(1.0, 1.0), "100 %");
    }

    #[test]
    fn levels_keep_their_declared_digits() {
        assert_eq!(plain(level(0.95)), "95 %");
        assert_eq!(plain(level(0.07)), "7 %");
        assert_eq!(plain(level(0.999)), "99.9 %");
    }

    #[test]
    fn differences_are_signed_and_never_vanish() {
        assert_eq!(points(0.08), "+8.0");
        assert_eq!(points(-0.002), "−0.2");
        assert_eq!(points(-5.2e-6), "−0.00052");
        assert_eq!(points(1e-53), "+1.0×10⁻⁵¹");
        assert_eq!(points(0.0), "0");
    }

    #[test]
    fn p_values_counts_and_durations() {
        assert_eq!(p_value(0.1762), "0.176");
        assert_eq!(p_value(2.4e-8), "2.4×10⁻⁸");
        assert_eq!(p_value(0.00022), "0.00022");
        assert_eq!(p_value(0.0043), "0.0043");
        assert_eq!(count(236643), "236,643");
        assert_eq!(count(100), "100");
        assert_eq!(plain(duration(0.0412)), "41 ms");
        assert_eq!(plain(duration(69.3)), "1 min 9 s");
        assert_eq!(plain(duration(7500.0)), "2 h 5 min");
    }

    #[test]
    fn guarantees_are_named() {
        let level = Guarantee::Statistical {
            confidence: 0.95,
            low: 0.61,
            high: 0.78,
        };
        assert_eq!(plain(guarantee(&level)), "statistical at 95 %: 61.0–78.0 %");
        let narrow = Guarantee::Bounded {
            low: 0.8803785717422,
            high: 0.8803785717423,
        };
        assert!(guarantee(&narrow).starts_with("bounded, within 1.0×10⁻¹³"));
        let loose = Guarantee::Estimated {
            reason: "stopped".into(),
        };
        assert_eq!(guarantee(&loose), "estimated, error unknown");
    }
}
