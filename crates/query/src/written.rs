//! Values as texts, as PRISM writes them.

use checker::AnswerValue;

/// Sizes of numbers that are written without an exponent.
const PLAIN: std::ops::Range<f64> = 1e-5..1e16;

/// A value, as PRISM writes it.
pub(crate) fn value(value: &AnswerValue) -> String {
    match value {
        AnswerValue::Number(value) => number(*value),
        AnswerValue::Exact(value) => value.to_string(),
        AnswerValue::Range { low, high } => format!("[{},{}]", number(*low), number(*high)),
        AnswerValue::ExactRange { low, high } => format!("[{low},{high}]"),
        AnswerValue::Ends { low, high } => format!("[{},{}]", self::value(low), self::value(high)),
        AnswerValue::Truth(truth) => truth.to_string(),
        AnswerValue::Corners(corners) => {
            let number = |value: &prism_lang::Rational| number(prism_lang::rational_to_f64(value));
            let corner = |corner: &Vec<prism_lang::Rational>| {
                let numbers: Vec<String> = corner.iter().map(number).collect();
                format!("({})", numbers.join(","))
            };
            let corners: Vec<String> = corners.iter().map(corner).collect();
            format!("[{}]", corners.join(","))
        }
    }
}

/// A number, with an exponent where a reader would have to count zeros.
pub fn number(value: f64) -> String {
    if value == f64::INFINITY {
        "Infinity".to_owned()
    } else if value == f64::NEG_INFINITY {
        "-Infinity".to_owned()
    } else if value == 0.0 || PLAIN.contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
