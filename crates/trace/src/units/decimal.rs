//! Decimal numbers as they were written, which can be scaled with a single rounding.

use std::fmt;

use super::factor::{Factor, greatest_common_divisor};

/// The greatest integer up to which every integer is a double.
const EXACT: u128 = 1 << 53;

/// A finite decimal number and its text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Decimal {
    text: String,
    value: f64,
}

impl Decimal {
    /// The number of bytes at the beginning of `text` that make a number without a sign: digits,
    /// a point with digits, an exponent.
    pub(crate) fn length(text: &str) -> usize {
        let bytes = text.as_bytes();
        let digits = |from: usize| {
            let rest = bytes.get(from..).unwrap_or(&[]);
            from + rest.iter().take_while(|byte| byte.is_ascii_digit()).count()
        };
        let mut end = digits(0);
        if end == 0 {
            return 0;
        }
        if bytes.get(end) == Some(&b'.') && digits(end + 1) > end + 1 {
            end = digits(end + 1);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            if digits(end + 1 + sign) > end + 1 + sign {
                end = digits(end + 1 + sign);
            }
        }
        end
    }

    /// The whole of `text`, with or without a sign, if it is a finite number.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let unsigned = text.strip_prefix(['-', '+']).unwrap_or(text);
        if unsigned.is_empty() || Decimal::length(unsigned) != unsigned.len() {
            return None;
        }
        let value: f64 = text.parse().ok()?;
        value.is_finite().then(|| Decimal {
            text: text.to_owned(),
            value,
        })
    }

    /// The nearest double.
    pub(crate) fn value(&self) -> f64 {
        self.value
    }

    /// The number times `factor`, rounded as [`super`] promises.
    pub(crate) fn scaled(&self, factor: Factor) -> f64 {
        let (numerator, denominator, pi_power) = factor.parts();
        if (numerator, denominator, pi_power) == (1, 1, 0) {
            return self.value;
        }
        let rational = Factor::new(numerator, denominator, 0).unwrap_or(Factor::ONE);
        let magnitude = self
            .rounded_once(rational)
            .unwrap_or_else(|| rational.conversion().apply(self.value.abs()));
        let magnitude = magnitude * std::f64::consts::PI.powi(i32::from(pi_power));
        magnitude.copysign(self.value)
    }

    /// The magnitude times a factor without pi, if it can be had with a single rounding.
    fn rounded_once(&self, factor: Factor) -> Option<f64> {
        let (mantissa, exponent) = self.mantissa()?;
        if let Some(shift) = factor.power_of_ten() {
            // Reading a decimal number rounds it once.
            return format!("{mantissa}e{}", exponent.checked_add(shift)?)
                .parse()
                .ok();
        }
        let (numerator, denominator, _) = factor.parts();
        let power = 10_u128.checked_pow(exponent.unsigned_abs())?;
        let (above, below) = if exponent < 0 { (1, power) } else { (power, 1) };
        let numerator = mantissa.checked_mul(numerator)?.checked_mul(above)?;
        let denominator = denominator.checked_mul(below)?;
        let common = greatest_common_divisor(numerator, denominator);
        let (numerator, denominator) = (numerator / common, denominator / common);
        (numerator <= EXACT && denominator <= EXACT).then(|| numerator as f64 / denominator as f64)
    }

    /// m and k with |number| = m * 10^k, if m is not too large.
    fn mantissa(&self) -> Option<(u128, i32)> {
        let text = self.text.trim_start_matches(['-', '+']);
        let (digits, exponent) = match text.split_once(['e', 'E']) {
            Some((digits, exponent)) => (digits, exponent.parse::<i32>().ok()?),
            None => (text, 0),
        };
        let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
        let mantissa = format!("{whole}{fraction}").parse().ok()?;
        let exponent = exponent.checked_sub(i32::try_from(fraction.len()).ok()?)?;
        Some((mantissa, exponent))
    }
}

impl fmt::Display for Decimal {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.text)
    }
}
