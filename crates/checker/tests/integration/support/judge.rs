//! What an answer must be for its exact value to be what it is.

use checker::{Answer, AnswerValue, Guarantee};
use num_traits::Signed;
use prism_lang::property::Quantity;
use prism_lang::{Arithmetic, Property, Rational, rational_to_f64};

use super::value::{Expected, exact_of};

/// Relative width that the sound method is asked for.
pub const PRECISION: f64 = 1e-6;

/// Below this the sound method promises an upper bound alone.
pub const SMALLEST: f64 = 1.001e-150;

pub fn exactly(answer: &Answer, expected: &Expected) -> Result<(), String> {
    let found = match &answer.value {
        AnswerValue::Exact(value) => Expected::Number(value.clone()),
        AnswerValue::ExactRange { low, high } => Expected::Range(low.clone(), high.clone()),
        AnswerValue::Truth(truth) => Expected::Truth(*truth),
        other => return Err(format!("the exact method answered {other:?}")),
    };
    if answer.guarantee != Guarantee::Exact {
        return Err(format!("its guarantee is {:?}", answer.guarantee));
    }
    if found == *expected {
        Ok(())
    } else {
        Err(format!("{found:?}"))
    }
}

pub fn sound(answer: &Answer, property: &Property, expected: &Expected) -> Result<(), String> {
    let is_probability = matches!(
        property,
        Property::Probability { .. } | Property::Number(Quantity::Probability { .. })
    );
    match (&answer.value, expected) {
        (AnswerValue::Truth(found), Expected::Truth(expected)) if found == expected => Ok(()),
        (AnswerValue::Number(value), Expected::Number(exact)) => {
            encloses(answer, *value, exact)?;
            match is_probability {
                true => complement_encloses(answer, exact),
                false => Ok(()),
            }
        }
        (AnswerValue::Range { low, high }, Expected::Range(exact_low, exact_high)) => {
            for exact in [exact_low, exact_high] {
                let initial = answer.initial.iter().any(|i| {
                    let bounds = bounds_of(&i.value, &i.guarantee);
                    bounds.is_some_and(|(low, high)| contains(low, high, exact))
                });
                if !initial {
                    return Err(format!(
                        "no initial state's bounds contain {exact}: {:?}",
                        answer.initial
                    ));
                }
            }
            near(*low, exact_low, PRECISION)?;
            near(*high, exact_high, PRECISION)
        }
        (found, _) => Err(format!("{found:?}")),
    }
}

/// What the guarantee says of a number.
pub fn bounds_of(value: &AnswerValue, guarantee: &Guarantee) -> Option<(f64, f64)> {
    match (value, guarantee) {
        (AnswerValue::Number(value), Guarantee::Exact) => Some((*value, *value)),
        (_, Guarantee::Bounded { low, high }) => Some((*low, *high)),
        _ => None,
    }
}

pub fn encloses(answer: &Answer, value: f64, exact: &Rational) -> Result<(), String> {
    let (low, high) = bounds_of(&answer.value, &answer.guarantee)
        .ok_or_else(|| format!("the sound method's guarantee is {:?}", answer.guarantee))?;
    if !contains(low, high, exact) {
        return Err(format!(
            "{low:e} to {high:e} does not contain {:e}",
            rational_to_f64(exact)
        ));
    }
    if !(low <= value && value <= high) {
        return Err(format!(
            "{value:e} is not between its bounds {low:e} and {high:e}"
        ));
    }
    narrow(low, high)
}

/// The probability of the contrary keeps its digits too.
pub fn complement_encloses(answer: &Answer, exact: &Rational) -> Result<(), String> {
    let Some(complement) = answer.complement else {
        return Err("the complement is missing".to_owned());
    };
    let exact = <Rational as Arithmetic>::one() - exact;
    let (low, high) = answer.complement_bounds.unwrap_or((complement, complement));
    if !contains(low, high, &exact) {
        return Err(format!(
            "complement: {low:e} to {high:e} does not contain {:e}",
            rational_to_f64(&exact)
        ));
    }
    narrow(low, high).map_err(|reason| format!("complement: {reason}"))
}

pub fn contains(low: f64, high: f64, exact: &Rational) -> bool {
    is_below(low, exact) && is_above(high, exact)
}

/// Whether a lower bound holds.
pub fn is_below(low: f64, exact: &Rational) -> bool {
    low == f64::NEG_INFINITY || exact_of(low) <= *exact
}

/// Whether an upper bound holds.
pub fn is_above(high: f64, exact: &Rational) -> bool {
    high == f64::INFINITY || *exact <= exact_of(high)
}

/// The relative width is as asked, rounding to neighbouring doubles allowed; of values below the least that floating
/// point is used for, only that is known.
pub fn narrow(low: f64, high: f64) -> Result<(), String> {
    if high - low <= PRECISION * high * (1.0 + 1e-9) || high <= SMALLEST {
        Ok(())
    } else {
        Err(format!("{low:e} to {high:e} is wider than asked"))
    }
}

pub fn near(value: f64, exact: &Rational, tolerance: f64) -> Result<(), String> {
    if !value.is_finite() {
        return Err(format!("{value} is no probability"));
    }
    let error = (exact_of(value) - exact).abs();
    if Arithmetic::is_zero(exact) && value == 0.0
        || rational_to_f64(&error) <= tolerance * rational_to_f64(&exact.abs())
    {
        Ok(())
    } else {
        Err(format!(
            "{value:e} is not near {:e}",
            rational_to_f64(exact)
        ))
    }
}

/// Whether an estimate is this near, and calls itself one; `is_near` compares a number with the exact one.
pub fn estimate_is_close(
    answer: &Answer,
    expected: &Expected,
    is_near: &dyn Fn(f64, &Rational) -> Result<(), String>,
) -> Result<(), String> {
    if answer.guarantee == Guarantee::Exact && !matches!(answer.value, AnswerValue::Truth(_)) {
        return Err("an iteration that stopped calls itself exact".to_owned());
    }
    match (&answer.value, expected) {
        (AnswerValue::Truth(found), Expected::Truth(expected)) if found == expected => Ok(()),
        (AnswerValue::Number(value), Expected::Number(exact)) => is_near(*value, exact),
        (AnswerValue::Range { low, high }, Expected::Range(exact_low, exact_high)) => {
            is_near(*low, exact_low)?;
            is_near(*high, exact_high)
        }
        (found, _) => Err(format!("{found:?}")),
    }
}

/// Like [`near`], but numbers below 1 may be off by as much as 1 may.
pub fn near_absolutely(value: f64, exact: &Rational, tolerance: f64) -> Result<(), String> {
    match (value - rational_to_f64(exact)).abs() <= tolerance {
        true => Ok(()),
        false => near(value, exact, tolerance),
    }
}
