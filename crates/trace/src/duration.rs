//! Durations as people write them: `300s`, `5 min`, `20 ms`.
//!
//! # Language
//! A number and a unit of time, with or without space between them; a number alone is in seconds.
//!
//! | unit | written |
//! |---|---|
//! | nanosecond, microsecond, millisecond | `ns`, `us` or `µs`, `ms` |
//! | second | `s`, `sec` |
//! | minute | `min`, `m` |
//! | hour, day, week | `h`, `d`, `w` |
//!
//! All but `m`, `d` and `w` may be written out, in singular or plural, too (`5 minutes`). Those three stand for a duration only
//! where nothing else can stand ([`seconds`]: an argument, or a key of a file that is a duration): in a text or a sentence
//! ([`unit_secs`], [`crate::units`]) `5 m` are five metres.
//!
//! # Guarantee
//! Of units below a second the number is divided by a power of ten and so rounded once.

use std::fmt;

/// Units, with how many make a second, or how many seconds they have.
const UNITS: [(&[&str], Scale); 8] = [
    (&["ns", "nanosecond", "nanoseconds"], Scale::Parts(1e9)),
    (
        &["us", "µs", "μs", "microsecond", "microseconds"],
        Scale::Parts(1e6),
    ),
    (&["ms", "millisecond", "milliseconds"], Scale::Parts(1e3)),
    (
        &["s", "sec", "secs", "second", "seconds"],
        Scale::Seconds(1.0),
    ),
    (&["min", "minute", "minutes"], Scale::Seconds(60.0)),
    (&["h", "hour", "hours"], Scale::Seconds(3600.0)),
    (&["day", "days"], Scale::Seconds(86_400.0)),
    (&["week", "weeks"], Scale::Seconds(604_800.0)),
];

/// What stands for a unit of time where only a duration can stand.
const SHORT: [(&str, &str); 3] = [("m", "min"), ("d", "day"), ("w", "week")];

#[derive(Clone, Copy)]
enum Scale {
    /// So many make a second.
    Parts(f64),
    /// It has so many seconds.
    Seconds(f64),
}

impl Scale {
    fn seconds(self, number: f64) -> f64 {
        match self {
            Scale::Parts(parts) => number / parts,
            Scale::Seconds(seconds) => number * seconds,
        }
    }
}

/// A text that is not a duration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DurationError {
    text: String,
}

impl DurationError {
    /// How a duration is written.
    pub const REMEDY: &str = "write a number of seconds, or a number and a unit of time (ns, us, ms, s, min or m, h, d, w), \
                              as in \"300\", \"0.5 s\", \"20 ms\" or \"5 min\"";
}

impl fmt::Display for DurationError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "\"{}\" is not a valid duration", self.text)
    }
}

impl std::error::Error for DurationError {}

/// The seconds that a duration means, from 0.
///
/// ```
/// assert_eq!(trace::duration::seconds("5 min"), Ok(300.0));
/// assert_eq!(trace::duration::seconds("5m"), trace::duration::seconds("300"));
/// assert!(trace::duration::seconds("5 mm").is_err());
/// ```
///
/// # Errors
/// A text that is no number with a unit of time, and a number that is negative or beyond all numbers.
pub fn seconds(text: &str) -> Result<f64, DurationError> {
    let error = || DurationError {
        text: text.to_owned(),
    };
    let written = text.trim();
    let (number, unit) = written.split_at(number_end(written));
    let number: f64 = number.trim().parse().map_err(|_| error())?;
    let unit = unit.trim();
    let unit = SHORT
        .iter()
        .find(|(short, _)| *short == unit)
        .map_or(unit, |(_, long)| long);
    let secs = match (unit, scale(unit)) {
        ("", _) => Some(number),
        (_, scale) => scale.map(|scale| scale.seconds(number)),
    };
    // A zero with a sign is none of those who read on.
    secs.filter(|secs| secs.is_finite() && *secs >= 0.0)
        .map(f64::abs)
        .ok_or_else(error)
}

/// The seconds of a unit of time, as a text in words names it.
#[must_use]
pub fn unit_secs(word: &str) -> Option<f64> {
    scale(word).map(|scale| scale.seconds(1.0))
}

fn scale(unit: &str) -> Option<Scale> {
    let known = UNITS.iter().find(|(words, _)| words.contains(&unit));
    known.map(|(_, scale)| *scale)
}

/// Where the number at the start of a text ends: digits, signs, a point, and an exponent with its digits.
fn number_end(text: &str) -> usize {
    let is_digit_or_sign = |c: char| c.is_ascii_digit() || "+-".contains(c);
    let of_number = |(at, c): (usize, char)| {
        let is_exponent = matches!(c, 'e' | 'E') && text[at + 1..].starts_with(is_digit_or_sign);
        is_digit_or_sign(c) || c == '.' || is_exponent
    };
    let mut all = text.char_indices();
    all.find(|it| !of_number(*it))
        .map_or(text.len(), |(at, _)| at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_read_with_and_without_units() {
        for (text, secs) in [
            ("300", 300.0),
            ("300s", 300.0),
            ("5m", 300.0),
            ("5 min", 300.0),
            (" 5 minutes ", 300.0),
            ("0.5 s", 0.5),
            ("20 ms", 0.02),
            ("20ms", 0.02),
            ("3 us", 3e-6),
            ("3 µs", 3e-6),
            ("7 ns", 7e-9),
            ("2h", 7200.0),
            ("1d", 86_400.0),
            ("1 day", 86_400.0),
            ("2w", 1_209_600.0),
            ("1e-3 s", 1e-3),
            ("2.5E2ms", 0.25),
            ("0", 0.0),
            ("-0 s", 0.0),
        ] {
            assert_eq!(seconds(text), Ok(secs), "{text}");
        }
        assert!(seconds("-0").is_ok_and(f64::is_sign_positive));
    }

    #[test]
    fn what_is_no_duration_is_refused_with_its_text() {
        for text in [
            "", "s", "fast", "-1 s", "1e400 s", "5 mm", "5 M", "5 min 3", "5 m/s", "nan", "inf s",
            "1.2.3", "5,5 s",
        ] {
            let error = seconds(text).expect_err(text);
            assert!(error.to_string().contains(text), "{error}");
        }
    }

    /// What is common to both tables of units has the same seconds in both.
    #[test]
    fn units_of_time_are_those_of_all_units() {
        for (words, _) in UNITS {
            for word in words {
                let Ok(unit) = word.parse::<crate::units::Unit>() else {
                    continue;
                };
                let quantity: crate::units::QuantityValue =
                    format!("3 {word}").parse().expect("a quantity");
                assert_eq!(unit.dimension(), crate::units::Dimension::TIME, "{word}");
                assert_eq!(
                    seconds(&format!("3 {word}")),
                    Ok(quantity.si_value()),
                    "{word}"
                );
            }
        }
    }

    #[test]
    fn in_a_text_a_metre_is_not_a_minute() {
        assert_eq!(unit_secs("minutes"), Some(60.0));
        assert_eq!(
            (unit_secs("m"), unit_secs("d"), unit_secs("")),
            (None, None, None)
        );
    }
}
