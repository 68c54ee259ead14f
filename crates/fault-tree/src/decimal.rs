//! Decimal numbers as they are written, without rounding.

use num_bigint::{BigInt, BigUint};
use num_rational::BigRational;
use num_traits::{One, Zero};

/// Digits and places that a number may have. Doubles have at most 767 digits, probabilities a dozen; a number like
/// `1e-999999999` would fill the memory.
const MOST_DIGITS: usize = 1_200;

/// The number that a text like `0.1`, `3` or `2.5e-7` is, exactly. `None` if it is no such number, is negative, or has more
/// than 1,200 digits or places.
///
/// ```
/// let tenth = fault_tree::decimal("0.1").expect("a number");
/// assert_eq!(tenth.to_string(), "1/10");
/// assert_eq!(fault_tree::decimal("one"), None);
/// ```
pub fn decimal(text: &str) -> Option<BigRational> {
    let text = text.strip_prefix('+').unwrap_or(text);
    let (digits, exponent) = match text.split_once(['e', 'E']) {
        Some((digits, exponent)) => (digits, exponent.parse::<i64>().ok()?),
        None => (text, 0),
    };
    let (whole, part) = digits.split_once('.').unwrap_or((digits, ""));
    let all = [whole, part].concat();
    let is_number = !all.is_empty() && all.bytes().all(|b| b.is_ascii_digit());
    if !is_number || all.len() > MOST_DIGITS {
        return None;
    }
    let value = BigUint::parse_bytes(all.as_bytes(), 10)?;
    if value.is_zero() {
        return Some(BigRational::zero());
    }
    let places = exponent.checked_sub(i64::try_from(part.len()).ok()?)?;
    let power = usize::try_from(places.unsigned_abs()).ok()?;
    if power > MOST_DIGITS {
        return None;
    }
    let scale = BigInt::from(10).pow(u32::try_from(power).ok()?);
    let value = BigInt::from(value);
    Some(match places < 0 {
        true => BigRational::new(value, scale),
        false => BigRational::new(value * scale, BigInt::one()),
    })
}
