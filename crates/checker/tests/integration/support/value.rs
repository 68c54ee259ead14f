//! Expected values: arithmetic over decimal numbers, computed exactly and apart from the code under test.

use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Zero};

/// What a property is expected to give.
#[derive(Clone, Debug, PartialEq)]
pub enum Expected {
    /// A number.
    Number(BigRational),
    /// Least and greatest value over the initial states.
    Range(BigRational, BigRational),
    /// A truth value.
    Truth(bool),
}

impl Expected {
    /// Reads `true`, `false`, `[low, high]` or an expression.
    pub fn parse(text: &str) -> Result<Self, String> {
        match text {
            "true" => return Ok(Self::Truth(true)),
            "false" => return Ok(Self::Truth(false)),
            _ => {}
        }
        match text.strip_prefix('[').and_then(|t| t.strip_suffix(']')) {
            Some(range) => {
                let (low, high) = range.split_once(',').ok_or("a range has two ends")?;
                Ok(Self::Range(number(low)?, number(high)?))
            }
            None => Ok(Self::Number(number(text)?)),
        }
    }
}

/// The rational number that a double is.
pub fn exact_of(value: f64) -> BigRational {
    BigRational::from_float(value).expect("a finite number")
}

/// The value of an expression.
pub fn number(text: &str) -> Result<BigRational, String> {
    let mut rest = text.trim();
    let value = sum(&mut rest)?;
    if rest.is_empty() {
        Ok(value)
    } else {
        Err(format!("`{rest}` is left of `{text}`"))
    }
}

fn sum(rest: &mut &str) -> Result<BigRational, String> {
    let mut value = product(rest)?;
    while let Some(operator) = take(rest, &['+', '-']) {
        let right = product(rest)?;
        value = if operator == '+' {
            value + right
        } else {
            value - right
        };
    }
    Ok(value)
}

fn product(rest: &mut &str) -> Result<BigRational, String> {
    let mut value = power(rest)?;
    while let Some(operator) = take(rest, &['*', '/']) {
        let right = power(rest)?;
        value = if operator == '*' {
            value * right
        } else {
            value / right
        };
    }
    Ok(value)
}

fn power(rest: &mut &str) -> Result<BigRational, String> {
    let base = atom(rest)?;
    if take(rest, &['^']).is_none() {
        return Ok(base);
    }
    let negative = take(rest, &['-']).is_some();
    let exponent = atom(rest)?;
    let count: u32 = exponent
        .to_integer()
        .try_into()
        .map_err(|_| "an exponent is too large")?;
    let raised = (0..count).fold(BigRational::one(), |product, _| product * &base);
    Ok(if negative { raised.recip() } else { raised })
}

fn atom(rest: &mut &str) -> Result<BigRational, String> {
    if take(rest, &['(']).is_some() {
        let value = sum(rest)?;
        take(rest, &[')']).ok_or("a parenthesis is not closed")?;
        return Ok(value);
    }
    let is_exponent = |at: usize, c: char| {
        let before = rest[..at].chars().next_back();
        c == 'e' || (matches!(c, '-' | '+') && before == Some('e'))
    };
    let end = rest
        .char_indices()
        .find(|(at, c)| !(c.is_ascii_digit() || *c == '.' || is_exponent(*at, *c)));
    let (literal, behind) = rest.split_at(end.map_or(rest.len(), |(at, _)| at));
    *rest = behind.trim_start();
    decimal(literal)
}

fn take(rest: &mut &str, wanted: &[char]) -> Option<char> {
    let first = rest.chars().next().filter(|c| wanted.contains(c))?;
    *rest = rest[1..].trim_start();
    Some(first)
}

fn decimal(literal: &str) -> Result<BigRational, String> {
    let wrong = || format!("`{literal}` is no number");
    let (mantissa, exponent) = literal.split_once('e').unwrap_or((literal, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits: BigInt = format!("{whole}{fraction}").parse().map_err(|_| wrong())?;
    let exponent: i64 = exponent.parse().map_err(|_| wrong())?;
    let shift = exponent - fraction.len() as i64;
    let scale = (0..shift.unsigned_abs()).fold(BigRational::one(), |s, _| s * BigInt::from(10));
    let value = BigRational::from_integer(digits);
    Ok(if shift < 0 {
        value / scale
    } else {
        value * scale
    })
}

#[test]
fn expressions_mean_what_they_say() {
    let ratio = |n: i64, d: i64| BigRational::new(n.into(), d.into());
    assert_eq!(number("1 - (1 - 0.5^2)^2"), Ok(ratio(7, 16)));
    assert_eq!(number("2 * 3/4 + 1e-2"), Ok(ratio(151, 100)));
    assert_eq!(number("2^-3"), Ok(ratio(1, 8)));
    assert_eq!(number("1.5e3 / 3"), Ok(ratio(500, 1)));
    assert_eq!(number("0"), Ok(BigRational::zero()));
    assert!(number("1 +").is_err());
    assert!(number("1 2").is_err());
    assert_eq!(
        Expected::parse("[0, 1/2]"),
        Ok(Expected::Range(ratio(0, 1), ratio(1, 2)))
    );
}
