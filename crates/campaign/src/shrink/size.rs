//! How much there is to read in a stimulus.

use serde::{Deserialize, Serialize};
use stimulus::{Distribution, Setting, Settings, Stimulus, Verb};

/// Digits of a number that cost nothing where it matters more how near it is to the nominal value.
pub(super) const PLAIN_DIGITS: usize = 2;

/// The size of a stimulus, compared part by part in this order.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd, Serialize, Deserialize)]
pub struct Size {
    /// Actions.
    pub actions: usize,
    /// Values in `set` actions.
    pub values: usize,
    /// Settings that are not nominal.
    pub settings: usize,
    /// Delays that are random.
    pub random_delays: usize,
    /// Sum of all delays (the middle of random ones), in seconds.
    pub delay_secs: f64,
    /// Significant digits beyond two of settings that have a nominal value and another one.
    pub further_digits: usize,
    /// How far such settings are from their nominal values, relative to these, together.
    pub distance: f64,
    /// Significant digits of all numbers and delays.
    pub digits: usize,
    /// Settings that merely repeat the nominal value.
    pub nominal_settings: usize,
}

impl Size {
    /// The size of a stimulus whose settings have these nominal values.
    #[must_use]
    pub fn of(stimulus: &Stimulus, nominal: &Settings) -> Self {
        let actions = &stimulus.test.actions;
        let is_nominal = |(key, value): &(&String, &Setting)| nominal.get(*key) == Some(*value);
        let nominal_settings = stimulus.settings.iter().filter(is_nominal).count();
        let own = stimulus.settings.iter();
        let own = own.filter(|entry| !is_nominal(entry));
        let values = actions.iter().flat_map(|action| match &action.verb {
            Verb::Set(values) => values.values().collect(),
            _ => Vec::new(),
        });
        let delays = actions.iter().map(|action| &action.after_secs);
        let digits_of_delay = |delay: &Distribution| match delay {
            Distribution::Constant(secs) => digits(*secs),
            _ => 0,
        };
        Self {
            actions: actions.len(),
            values: values.clone().count(),
            settings: stimulus.settings.len() - nominal_settings,
            random_delays: delays.clone().filter(|delay| !is_constant(delay)).count(),
            further_digits: own
                .clone()
                .filter(|(key, _)| nominal.contains_key(*key))
                .map(|(_, value)| digits_of(value).saturating_sub(PLAIN_DIGITS))
                .sum(),
            distance: own
                .clone()
                .filter_map(|(key, value)| distance(value, nominal.get(key)?))
                .sum(),
            delay_secs: delays.clone().map(|delay| delay.quantile(0.5)).sum(),
            digits: delays.map(digits_of_delay).sum::<usize>()
                + own.map(|(_, value)| digits_of(value)).sum::<usize>()
                + values.map(digits_of).sum::<usize>(),
            nominal_settings,
        }
    }
}

/// How far a number is from its nominal value, relative to that.
fn distance(value: &Setting, nominal: &Setting) -> Option<f64> {
    let (Setting::Number(value), Setting::Number(nominal)) = (value, nominal) else {
        return None;
    };
    let scale = if *nominal == 0.0 { 1.0 } else { nominal.abs() };
    Some((value - nominal).abs() / scale)
}

pub(super) fn is_constant(delay: &Distribution) -> bool {
    matches!(delay, Distribution::Constant(_))
}

fn digits_of(value: &Setting) -> usize {
    match value {
        Setting::Number(number) => digits(*number),
        _ => 0,
    }
}

/// Significant decimal digits of the shortest text that reads back as the number; none of zero.
pub(super) fn digits(number: f64) -> usize {
    if number == 0.0 {
        return 0;
    }
    let text = format!("{number:e}");
    let mantissa = text.split('e').next().unwrap_or_default();
    mantissa.chars().filter(char::is_ascii_digit).count()
}

/// The number with so many significant digits (at least one).
pub(super) fn rounded(number: f64, digits: usize) -> f64 {
    let text = format!("{number:.*e}", digits.max(1) - 1);
    text.parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_that_are_written() {
        let cases = [
            (0.0, 0),
            (1.0, 1),
            (-0.25, 2),
            (1200.0, 2),
            (1e300, 1),
            (0.1 + 0.2, 17),
        ];
        for (number, expected) in cases {
            assert_eq!(digits(number), expected, "{number}");
        }
        assert_eq!(rounded(2.345_67, 3), 2.35);
        assert_eq!(rounded(0.000_96, 1), 0.001);
        assert_eq!(rounded(-17.0, 0), -20.0);
    }
}
