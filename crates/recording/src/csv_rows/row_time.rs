//! Times in texts: which column or key has them, their unit, and their value in whole nanoseconds.
//!
//! The unit is stated by the caller; or by the name (`time_ms`, `stamp [us]`); or it is that of a
//! time since 1970 of which only one unit makes a date between 2001 and 2096: such seconds have ten
//! digits before the point, milliseconds thirteen, microseconds sixteen, nanoseconds nineteen. All
//! else is ambiguous, and asked for: a factor of 1,000 in time would change every verdict. Decimal
//! digits are taken as they stand; what is finer than a nanosecond is rounded to the nearest.

use std::fmt;

/// The unit of times in a text file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeUnit {
    /// Seconds, `s`.
    Secs,
    /// Milliseconds, `ms`.
    Millis,
    /// Microseconds, `us`.
    Micros,
    /// Nanoseconds, `ns`.
    Nanos,
}

/// A text that names no unit of time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TimeUnitError {
    /// What was given.
    pub text: String,
}

impl fmt::Display for TimeUnitError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            out,
            "\"{}\" is not a unit of time; write s, ms, us or ns",
            self.text
        )
    }
}

impl std::error::Error for TimeUnitError {}

impl std::str::FromStr for TimeUnit {
    type Err = TimeUnitError;

    fn from_str(text: &str) -> Result<Self, TimeUnitError> {
        let lower = text.to_ascii_lowercase();
        match lower.as_str() {
            "s" | "sec" | "secs" | "second" | "seconds" => Ok(TimeUnit::Secs),
            "ms" | "msec" | "msecs" | "millis" | "millisecond" | "milliseconds" => {
                Ok(TimeUnit::Millis)
            }
            "us" | "\u{b5}s" | "\u{3bc}s" | "usec" | "usecs" | "micros" | "microsecond"
            | "microseconds" => Ok(TimeUnit::Micros),
            "ns" | "nsec" | "nsecs" | "nanos" | "nanosec" | "nanosecond" | "nanoseconds" => {
                Ok(TimeUnit::Nanos)
            }
            _ => Err(TimeUnitError {
                text: text.to_owned(),
            }),
        }
    }
}

impl TimeUnit {
    /// How many digits a second has behind its point in this unit.
    fn digits(self) -> i32 {
        match self {
            TimeUnit::Secs => 0,
            TimeUnit::Millis => 3,
            TimeUnit::Micros => 6,
            TimeUnit::Nanos => 9,
        }
    }
}

/// Names of columns and keys that hold the time, in order of preference, without their units.
const TIME_NAMES: [&str; 10] = [
    "time",
    "timestamp",
    "log_time",
    "t",
    "stamp",
    "ts",
    "__time",
    "%time",
    "elapsed",
    "elapsed_time",
];

/// The place among `names` of that which holds the time.
pub(crate) fn find_time<'a>(names: impl Iterator<Item = &'a str>) -> Option<usize> {
    let rank = |name: &str| {
        let (stem, unit) = split_unit(name);
        let stem = stem.to_ascii_lowercase();
        match TIME_NAMES.iter().position(|other| *other == stem) {
            Some(rank) => Some(rank),
            // A column that is called by its unit alone: "secs", "nanoseconds".
            None if stem.is_empty() && unit.is_some() => Some(TIME_NAMES.len()),
            None => None,
        }
    };
    let ranked = names
        .enumerate()
        .filter_map(|(place, name)| Some((rank(name)?, place)));
    ranked.min().map(|(_, place)| place)
}

/// A name without the unit behind it: `time_ms`, `time [ms]`, `time(ms)`, `secs`.
fn split_unit(name: &str) -> (&str, Option<TimeUnit>) {
    let name = name.trim();
    if name == "%time" {
        // As "rostopic echo -p" writes it.
        return (name, Some(TimeUnit::Nanos));
    }
    let bracketed = [('[', ']'), ('(', ')')]
        .into_iter()
        .find_map(|(open, close)| {
            let (stem, unit) = name.strip_suffix(close)?.rsplit_once(open)?;
            Some((stem.trim_end(), unit.trim()))
        });
    let split = bracketed.or_else(|| name.rsplit_once('_'));
    let (stem, unit) = split.unwrap_or(("", name));
    match unit.parse() {
        // A column that is called "s" is rather a distance than a time.
        Ok(_) if stem.is_empty() && unit.len() < 3 => (name, None),
        Ok(unit) => (stem, Some(unit)),
        Err(_) => (name, None),
    }
}

/// How the texts of a file become times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TimeFormat {
    /// Numbers in this unit.
    Number(TimeUnit),
    /// Dates such as `2024-05-01T12:00:00.5Z`.
    Date,
}

impl TimeFormat {
    /// The format of the column or key `name`, of which `first` is the first text. `None` if the
    /// unit is ambiguous, or the text is no time.
    pub(crate) fn detect(name: &str, first: &str, stated: Option<TimeUnit>) -> Option<Self> {
        if date_nanos(first).is_some() {
            return Some(TimeFormat::Date);
        }
        let number = first.trim();
        decimal(number, 0)?;
        let unit = stated.or_else(|| split_unit(name).1).or_else(|| {
            let whole = number.split(['.', 'e', 'E']).next().unwrap_or_default();
            let seconds: f64 = number.parse().ok()?;
            let units = [
                TimeUnit::Secs,
                TimeUnit::Millis,
                TimeUnit::Micros,
                TimeUnit::Nanos,
            ];
            let unit = units
                .into_iter()
                .find(|unit| whole.len() as i32 == 10 + unit.digits())?;
            let secs = seconds / 10_f64.powi(unit.digits());
            (1e9..4e9).contains(&secs).then_some(unit)
        })?;
        Some(TimeFormat::Number(unit))
    }

    /// The time that `text` tells, in nanoseconds.
    pub(crate) fn nanos(self, text: &str) -> Option<i64> {
        match self {
            TimeFormat::Number(unit) => decimal(text.trim(), 9 - unit.digits()),
            TimeFormat::Date => date_nanos(text),
        }
    }
}

/// The decimal number `text` times 10 to the power of `shift`, rounded to the nearest whole number,
/// halves away from zero.
fn decimal(text: &str, shift: i32) -> Option<i64> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text.strip_prefix('+').unwrap_or(text)),
    };
    let (mantissa, exponent) = match digits.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.parse::<i32>().ok()?),
        None => (digits, 0),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let all = || whole.bytes().chain(fraction.bytes());
    if all().next().is_none() || !all().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    // The point stands this many digits from the left.
    let point = i64::try_from(whole.len()).ok()? + i64::from(exponent) + i64::from(shift);
    let mut value: i64 = 0;
    let mut given = all();
    for _ in 0..point.max(0) {
        let digit = match given.next() {
            Some(byte) => i64::from(byte - b'0'),
            None if value == 0 => return Some(0),
            None => 0,
        };
        value = value.checked_mul(10)?.checked_add(digit)?;
    }
    let rounds_up = point >= 0 && given.next().is_some_and(|byte| byte >= b'5');
    value = value.checked_add(i64::from(rounds_up))?;
    Some(if negative { -value } else { value })
}

/// The nanoseconds since 1970 of a date with time in the profile of RFC 3339: a blank may stand for
/// the `T`, and without an offset it counts as UTC.
fn date_nanos(text: &str) -> Option<i64> {
    let text = text.trim();
    let (date, rest) = text.split_at_checked(10)?;
    let clock = rest.strip_prefix(['T', 't', ' '])?;
    let fields = |text: &str, sign: char| -> Option<[i64; 3]> {
        let mut parts = text.split(sign).map(|part| {
            let is_number = !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
            is_number.then(|| part.parse::<i64>().ok()).flatten()
        });
        let all = [parts.next()??, parts.next()??, parts.next()??];
        parts.next().is_none().then_some(all)
    };
    let [year, month, day] = fields(date, '-')?;
    let (clock, offset_secs) = split_offset(clock)?;
    let (whole, fraction) = clock.split_once('.').unwrap_or((clock, "0"));
    let [hour, minute, second] = fields(whole, ':')?;
    let is_valid = (1..=12).contains(&month)
        && (1..=31).contains(&day)
        && hour < 24
        && minute < 60
        && second <= 60
        && fraction.bytes().all(|byte| byte.is_ascii_digit());
    if !is_valid {
        return None;
    }
    let secs = days_since_1970(year, month, day) * 86_400 + hour * 3_600 + minute * 60 + second;
    let nanos = decimal(&format!("0.{fraction}"), 9)?;
    (secs - offset_secs)
        .checked_mul(1_000_000_000)?
        .checked_add(nanos)
}

/// A time of day without its offset from UTC, and the offset.
fn split_offset(clock: &str) -> Option<(&str, i64)> {
    if let Some(clock) = clock.strip_suffix(['Z', 'z']) {
        return Some((clock, 0));
    }
    let Some(place) = clock.rfind(['+', '-']) else {
        return Some((clock, 0));
    };
    let (clock, offset) = clock.split_at(place);
    let (hours, minutes) = offset[1..].split_once(':')?;
    let number = |text: &str| {
        text.parse::<i64>()
            .ok()
            .filter(|number| (0..60).contains(number))
    };
    let secs = number(hours)? * 3_600 + number(minutes)? * 60;
    Some((clock, if offset.starts_with('-') { -secs } else { secs }))
}

/// Days of the Gregorian calendar: years begin in March, so that the leap day is the last one.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let month_from_march = (month + 9) % 12;
    let leap_days = year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400);
    let day_of_year = (153 * month_from_march + 2) / 5 + day - 1;
    year * 365 + leap_days + day_of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_come_from_the_name_or_from_the_date() {
        let detect = |name, first| TimeFormat::detect(name, first, None);
        let unit = |unit| Some(TimeFormat::Number(unit));
        assert_eq!(detect("time_secs", "0.5"), unit(TimeUnit::Secs));
        assert_eq!(detect("Time [ms]", "12"), unit(TimeUnit::Millis));
        assert_eq!(detect("t(us)", "12"), unit(TimeUnit::Micros));
        assert_eq!(detect("%time", "12"), unit(TimeUnit::Nanos));
        assert_eq!(detect("nanoseconds", "12"), unit(TimeUnit::Nanos));
        assert_eq!(detect("t", "1700000000.25"), unit(TimeUnit::Secs));
        assert_eq!(detect("t", "1700000000250"), unit(TimeUnit::Millis));
        assert_eq!(detect("t", "1700000000250000"), unit(TimeUnit::Micros));
        assert_eq!(detect("t", "1700000000250000000"), unit(TimeUnit::Nanos));
        assert_eq!(detect("t", "2024-02-29T00:00:00Z"), Some(TimeFormat::Date));
        for ambiguous in ["0.0", "12", "170000000", "5000000000", "17000000000"] {
            assert_eq!(detect("t", ambiguous), None, "{ambiguous}");
        }
        assert_eq!(detect("time_secs", "soon"), None);
        assert_eq!(
            TimeFormat::detect("t", "12", Some(TimeUnit::Millis)),
            unit(TimeUnit::Millis)
        );
    }

    #[test]
    fn the_column_of_times_is_found() {
        let find = |names: &[&str]| find_time(names.iter().copied());
        assert_eq!(find(&["x", "t", "Timestamp_ns"]), Some(2));
        assert_eq!(find(&["x", "secs"]), Some(1));
        assert_eq!(find(&["x", "s"]), None);
        assert_eq!(find(&["position", "temperature"]), None);
    }

    #[test]
    fn digits_are_taken_as_they_stand() {
        let secs = |text| TimeFormat::Number(TimeUnit::Secs).nanos(text);
        assert_eq!(
            secs("1700000000.123456789"),
            Some(1_700_000_000_123_456_789)
        );
        assert_eq!(secs("-0.0000000015"), Some(-2));
        assert_eq!(secs("1.5e-3"), Some(1_500_000));
        assert_eq!(secs("2e3"), Some(2_000_000_000_000));
        assert_eq!(secs("0e999999999"), Some(0));
        assert_eq!(secs("1e-999999999"), Some(0));
        for wrong in ["", ".", "-", "1e", "1e99", "nan", "1,5", "9223372037"] {
            assert_eq!(secs(wrong), None, "{wrong}");
        }
        assert_eq!(TimeFormat::Number(TimeUnit::Nanos).nanos("7"), Some(7));
        assert_eq!(
            TimeFormat::Number(TimeUnit::Millis).nanos(".25"),
            Some(250_000)
        );
    }

    #[test]
    fn dates_are_days_of_the_gregorian_calendar() {
        let date = |text| TimeFormat::Date.nanos(text);
        assert_eq!(date("1970-01-01T00:00:00Z"), Some(0));
        // date -u -d 2024-02-29T12:30:15Z +%s
        let secs = 1_709_209_815;
        assert_eq!(
            date("2024-02-29T12:30:15.000000001Z"),
            Some(secs * 1_000_000_000 + 1)
        );
        assert_eq!(
            date("2024-02-29 14:30:15+02:00"),
            Some(secs * 1_000_000_000)
        );
        assert_eq!(date("2024-02-29T12:30"), None);
        assert_eq!(date("2024-13-01T00:00:00Z"), None);
    }
}
