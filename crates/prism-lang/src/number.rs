//! Real numbers that stay exact for as long as they are rational, and the values of constants.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::fmt;

use num_bigint::BigInt;
use num_traits::{Pow, ToPrimitive, Zero};

/// An exact rational number of any size.
pub type Rational = num_rational::BigRational;

/// Largest magnitude of a decimal exponent in a literal: beyond it, an exact value would only eat memory.
const MAX_EXPONENT: i64 = 5_000;

/// Longest literal: an exact value takes time that grows faster than its length.
const MAX_LENGTH: usize = 10_000;

/// A real number: exact if it is rational, and in any case the nearest (or a near) `f64`.
///
/// Literals such as `0.1` are exact (one tenth). Only irrational results (logarithms, roots) lose exactness.
#[derive(Clone, Debug)]
pub struct Number {
    exact: Option<Rational>,
    approximate: f64,
}

impl Number {
    /// The number that equals this rational; its `f64` is the nearest one.
    pub fn from_rational(exact: Rational) -> Self {
        let approximate = rational_to_f64(&exact);
        Self {
            exact: Some(exact),
            approximate,
        }
    }

    /// A number known only approximately.
    pub fn from_approximate(approximate: f64) -> Self {
        Self {
            exact: None,
            approximate,
        }
    }

    /// The number that equals this integer.
    pub fn from_i64(value: i64) -> Self {
        Self {
            exact: Some(Rational::from_integer(value.into())),
            approximate: value as f64,
        }
    }

    /// Reads an unsigned decimal literal (`0.25`, `1e-3`, `.5`) exactly.
    ///
    /// `None` when it is not such a literal, has more than ten thousand characters, or its exponent is beyond five thousand.
    pub fn parse(literal: &str) -> Option<Self> {
        if literal.len() > MAX_LENGTH {
            return None;
        }
        let approximate: f64 = literal.parse().ok()?;
        let (mantissa, exponent) = match literal.find(['e', 'E']) {
            Some(at) => (&literal[..at], literal[at + 1..].parse::<i64>().ok()?),
            None => (literal, 0),
        };
        let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
        let digits: BigInt = format!("0{whole}{fraction}").parse().ok()?;
        let exponent = exponent.checked_sub(fraction.len() as i64)?;
        if exponent.abs() > MAX_EXPONENT {
            return None;
        }
        let scale = Pow::pow(BigInt::from(10), exponent.unsigned_abs());
        let exact = if exponent >= 0 {
            Rational::from_integer(digits * scale)
        } else {
            Rational::new(digits, scale)
        };
        Some(Self {
            exact: Some(exact),
            approximate,
        })
    }

    /// The exact value, unless the number is irrational.
    pub fn exact(&self) -> Option<&Rational> {
        self.exact.as_ref()
    }

    /// The nearest `f64` (near, if the number is irrational).
    pub fn to_f64(&self) -> f64 {
        self.approximate
    }
}

/// The `f64` nearest to a rational (ties to even), also when numerator and denominator overflow `f64`.
///
/// Definition: with `q = floor(|n| 2^s / d)` for a shift `s` that leaves `q` at least 66 bits, and a
/// sticky bit for the remainder, rounding `q` to 53 bits (fewer for subnormal results) rounds `n/d` once.
pub fn rational_to_f64(value: &Rational) -> f64 {
    if value.is_zero() {
        return 0.0;
    }
    let numerator = value.numer().magnitude();
    let denominator = value.denom().magnitude();
    let shift = 66 + denominator.bits() as i64 - numerator.bits() as i64;
    let (quotient, remainder) = if shift >= 0 {
        let scaled = numerator << shift as u64;
        (&scaled / denominator, &scaled % denominator)
    } else {
        let scaled = denominator << (-shift) as u64;
        (numerator / &scaled, numerator % &scaled)
    };
    // The quotient has 66 or 67 bits: it fits u128, and a remainder only matters as "a little more".
    let mut bits = quotient.to_u128().unwrap_or(u128::MAX) << 1;
    if !remainder.is_zero() {
        bits |= 1;
    }
    let magnitude = round_scaled(bits, -shift - 1);
    if value.numer().sign() == num_bigint::Sign::Minus {
        -magnitude
    } else {
        magnitude
    }
}

/// `bits * 2^exponent` rounded once to the nearest `f64`, ties to even.
fn round_scaled(bits: u128, exponent: i64) -> f64 {
    let length = 128 - i64::from(bits.leading_zeros());
    // The exponent of the last place kept: 53 bits, or the subnormal floor.
    let last_place = (exponent + length - 53).max(-1074);
    let dropped = last_place - exponent;
    if dropped >= 128 {
        return 0.0;
    }
    let kept = bits >> dropped;
    let rest = bits & ((1u128 << dropped) - 1);
    let half = 1u128 << (dropped - 1);
    let round_up = rest > half || (rest == half && kept & 1 == 1);
    let mantissa = (kept + u128::from(round_up)) as f64;
    scale_by_power_of_two(mantissa, last_place)
}

/// `mantissa * 2^exponent`, where the result is representable or overflows to infinity.
fn scale_by_power_of_two(mantissa: f64, exponent: i64) -> f64 {
    if exponent > 1100 {
        return f64::INFINITY;
    }
    let half = exponent / 2;
    mantissa * 2f64.powi(half as i32) * 2f64.powi((exponent - half) as i32)
}

impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Number {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match (&self.exact, &other.exact) {
            (Some(a), Some(b)) => Some(a.cmp(b)),
            _ => self.approximate.partial_cmp(&other.approximate),
        }
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.approximate)
    }
}

/// The value of a constant.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `true` or `false`.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A real number.
    Double(Number),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bool(value) => write!(f, "{value}"),
            Self::Int(value) => write!(f, "{value}"),
            Self::Double(value) => write!(f, "{value}"),
        }
    }
}

/// Values given to constants from outside the model, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Constants(pub BTreeMap<String, Value>);

impl Constants {
    /// No values.
    pub fn new() -> Self {
        Self::default()
    }

    /// Reads what PRISM's switch `-const` takes: `a=1,b=0.5,c=true`.
    ///
    /// # Errors
    /// A sentence that names the part that is not `name=value`, or the name given twice.
    ///
    /// ```
    /// use prism_lang::{Constants, Value};
    /// let constants = Constants::parse("n=3, p=0.5")?;
    /// assert_eq!(constants.get("n"), Some(&Value::Int(3)));
    /// # Ok::<(), prism_lang::ConstantsError>(())
    /// ```
    pub fn parse(text: &str) -> Result<Self, ConstantsError> {
        let mut constants = Self::new();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (name, value) = part
                .split_once('=')
                .ok_or_else(|| ConstantsError::NoEquals(part.to_owned()))?;
            let (name, value) = (name.trim(), value.trim());
            if !is_identifier(name) {
                return Err(ConstantsError::NotAName(name.to_owned()));
            }
            let parsed = parse_value(value).ok_or_else(|| ConstantsError::NotAValue {
                name: name.to_owned(),
                value: value.to_owned(),
            })?;
            if constants.0.insert(name.to_owned(), parsed).is_some() {
                return Err(ConstantsError::Twice(name.to_owned()));
            }
        }
        Ok(constants)
    }

    /// The value given to `name`.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.0.get(name)
    }

    /// Gives `name` a value, in place of an earlier one.
    pub fn set(&mut self, name: impl Into<String>, value: Value) {
        self.0.insert(name.into(), value);
    }
}

pub(crate) fn is_identifier(name: &str) -> bool {
    let mut chars = name.chars();
    chars
        .next()
        .is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && chars.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// An integer, a decimal number, a fraction `a/b`, `true` or `false`, possibly with a minus in front.
pub(crate) fn parse_value(text: &str) -> Option<Value> {
    match text {
        "true" => return Some(Value::Bool(true)),
        "false" => return Some(Value::Bool(false)),
        _ => {}
    }
    if let Ok(value) = text.parse::<i64>() {
        return Some(Value::Int(value));
    }
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let mut parts = digits.split('/');
    let mut exact = parse_decimal(parts.next()?)?;
    // `1/1/3` is `(1/1)/3`.
    for part in parts {
        let below = parse_decimal(part)?;
        if below.is_zero() {
            return None;
        }
        exact /= below;
    }
    let exact = if negative { -exact } else { exact };
    Some(Value::Double(Number::from_rational(exact)))
}

fn parse_decimal(text: &str) -> Option<Rational> {
    let text = text.trim();
    if !text.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return None;
    }
    Number::parse(text)?.exact
}

/// Why a list of constants could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConstantsError {
    /// A part is not of the form `name=value`.
    NoEquals(String),
    /// What stands before `=` is no identifier.
    NotAName(String),
    /// What stands behind `=` is no value.
    NotAValue {
        /// The constant.
        name: String,
        /// What was given.
        value: String,
    },
    /// A range (`first:step:last`) has no values.
    BadRange {
        /// The constant.
        name: String,
        /// What was given.
        range: String,
        /// What is wrong with it.
        why: &'static str,
    },
    /// A constant was given two values.
    Twice(String),
}

impl fmt::Display for ConstantsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoEquals(part) => write!(
                f,
                "`{part}` does not give a constant a value: write `name=value`, separated by commas"
            ),
            Self::NotAName(name) => write!(
                f,
                "`{name}` is not the name of a constant: names are letters, digits and `_`"
            ),
            Self::NotAValue { name, value } => write!(
                f,
                "`{value}` is not a valid value of constant `{name}`: give an integer, a decimal number, a fraction such as 1/3, true or false"
            ),
            Self::BadRange { name, range, why } => write!(
                f,
                "`{range}` is not a valid range of constant `{name}`, {why}: write `first:step:last` or `first:last`"
            ),
            Self::Twice(name) => {
                write!(f, "constant `{name}` is given twice: give it one value")
            }
        }
    }
}

impl std::error::Error for ConstantsError {}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn literals_are_exact() {
        let tenth = Number::parse("0.1").unwrap();
        assert_eq!(tenth.exact(), Some(&Rational::new(1.into(), 10.into())));
        assert_eq!(tenth.to_f64(), 0.1);
        let half = Number::parse(".5e0").unwrap();
        assert_eq!(half.to_f64(), 0.5);
        assert_eq!(Number::parse("1e999999999"), None);
        assert_eq!(Number::parse("abc"), None);
    }

    #[test]
    fn constants_are_read_as_on_a_command_line() {
        let constants = Constants::parse("a=1, b=-0.25,c=true,d=1/4").unwrap();
        assert_eq!(constants.get("a"), Some(&Value::Int(1)));
        assert_eq!(constants.get("c"), Some(&Value::Bool(true)));
        let (Some(Value::Double(b)), Some(Value::Double(d))) =
            (constants.get("b"), constants.get("d"))
        else {
            panic!("b and d are doubles");
        };
        assert_eq!((b.to_f64(), d.to_f64()), (-0.25, 0.25));
        for (text, error) in [
            ("a", ConstantsError::NoEquals("a".into())),
            ("1=2", ConstantsError::NotAName("1".into())),
            ("a=1,a=2", ConstantsError::Twice("a".into())),
        ] {
            assert_eq!(Constants::parse(text), Err(error));
        }
        let message = Constants::parse("a=inf").unwrap_err().to_string();
        assert!(
            message.contains("`inf` is not a valid value of constant `a`"),
            "{message}"
        );
        assert!(Constants::parse("a=1/0").is_err());
    }

    proptest! {
        /// Every finite f64, written as a rational, rounds back to itself.
        #[test]
        fn rounding_is_the_identity_on_doubles(bits in any::<u64>()) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            let exact = Rational::from_float(value).unwrap();
            prop_assert_eq!(rational_to_f64(&exact), value);
        }

        /// Decimal literals round as the standard library's parser does, which is correctly rounded.
        #[test]
        fn rounding_agrees_with_the_standard_library(digits in 1u64.., exponent in -340i32..300) {
            let literal = format!("{digits}e{exponent}");
            let exact = Number::parse(&literal).unwrap().exact.unwrap();
            prop_assert_eq!(rational_to_f64(&exact), literal.parse::<f64>().unwrap());
        }

        /// A halfway case goes to the even neighbour, a little more goes up.
        #[test]
        fn halfway_cases_round_to_even(mantissa in (1u64 << 52)..((1u64 << 53) - 1)) {
            let twice: BigInt = BigInt::from(mantissa) * 2 + 1;
            let even = mantissa + (mantissa & 1);
            prop_assert_eq!(rational_to_f64(&Rational::from_integer(twice.clone())), even as f64 * 2.0);
            let more = Rational::new(twice * 1_000_000 + 1, 1_000_000.into());
            prop_assert_eq!(rational_to_f64(&more), (mantissa + 1) as f64 * 2.0);
        }
    }
}
