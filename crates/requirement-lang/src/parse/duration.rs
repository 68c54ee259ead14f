//! Durations: `2 s`, `500 ms`, `5 steps`, or the name of a parameter that is a time.

use trace::units::{QuantityValue, Unit};

use super::{Reader, place};
use crate::diagnostic::Span;
use crate::lexer::{Kind, Token};
use crate::sentence::{Amount, Duration};

const STEP_WORDS: [&str; 6] = ["step", "steps", "tick", "ticks", "sample", "samples"];

/// The longest duration in seconds: that of the monitors' intervals.
const MAX_SECS: f64 = temporal::formula::MAX_BOUND;

/// The duration at the start of `tokens`, and how many tokens it takes. `before` is the keyword.
pub(super) fn duration(
    reader: &mut Reader<'_>,
    tokens: &[Token<'_>],
    before: Span,
) -> (Duration, usize) {
    let used = length(tokens);
    let span = place(&tokens[..used], before);
    let text: Vec<&str> = tokens[..used].iter().map(|token| token.text).collect();
    let amount = match tokens.first().filter(|_| used > 0) {
        None => {
            missing(reader, span, "A duration is missing here.");
            Amount::Missing
        }
        Some(first) if starts_number(first.text) => literal(reader, &text, span),
        Some(first) => parameter(reader, first.text, span),
    };
    let text = match amount {
        Amount::Missing => text.join(" "),
        _ => spaced(&text),
    };
    (Duration { text, amount, span }, used)
}

fn missing(reader: &mut Reader<'_>, span: Span, message: &str) {
    reader.error(
        "duration",
        span,
        message,
        "Write a number with a unit of time, such as `2 s` or `5 steps`, or a parameter that is a time.",
    );
}

fn starts_number(text: &str) -> bool {
    text.starts_with(|letter: char| letter.is_ascii_digit() || "+-.".contains(letter))
}

/// A number and its unit take two tokens, a number with its unit attached or a name one.
fn length(tokens: &[Token<'_>]) -> usize {
    let Some(first) = tokens
        .first()
        .filter(|token| token.kind == Kind::Word && !token.is("satisfy"))
    else {
        return 0;
    };
    let bare = first.text.parse::<f64>().is_ok();
    let unit = tokens.get(1).is_some_and(|token| {
        token.kind == Kind::Word
            && (token.is_any(&STEP_WORDS) || token.text.parse::<Unit>().is_ok())
    });
    1 + usize::from(bare && unit)
}

fn spaced(words: &[&str]) -> String {
    let text = words.join(" ");
    match text.find(|letter: char| letter.is_ascii_alphabetic()) {
        Some(unit) if starts_number(&text) => {
            format!("{} {}", text[..unit].trim_end(), &text[unit..])
        }
        _ => text,
    }
}

fn literal(reader: &mut Reader<'_>, words: &[&str], span: Span) -> Amount {
    if let [number, unit] = words
        && STEP_WORDS
            .iter()
            .any(|word| unit.eq_ignore_ascii_case(word))
    {
        return match number.parse::<u32>() {
            Ok(count) => Amount::Steps(count),
            Err(_) => {
                missing(
                    reader,
                    span,
                    &format!("`{number}` is not a number of steps."),
                );
                Amount::Missing
            }
        };
    }
    match words.join(" ").parse::<QuantityValue>() {
        Ok(quantity) => seconds(&quantity).map_or_else(
            |what| {
                missing(reader, span, &what);
                Amount::Missing
            },
            Amount::Secs,
        ),
        Err(error) => {
            missing(
                reader,
                span,
                &format!("This is not a duration: {}.", error.kind),
            );
            Amount::Missing
        }
    }
}

fn parameter(reader: &mut Reader<'_>, name: &str, span: Span) -> Amount {
    let parameters = reader.context.parameters;
    if let Some(value) = parameters.and_then(|parameters| parameters.get(name)) {
        return seconds(value).map_or_else(
            |what| {
                let remedy =
                    "Where it is declared, write a number with a unit of time, such as `2 s`.";
                reader.error(
                    "duration",
                    span,
                    format!("The parameter `{name}`: {what}"),
                    remedy,
                );
                Amount::Missing
            },
            Amount::Secs,
        );
    }
    let similar = parameters.and_then(|parameters| parameters.similar(name));
    let remedy = similar.map_or_else(
        || {
            "Declare it as a parameter with a unit of time, or write a duration such as `2 s`."
                .to_owned()
        },
        |similar| format!("Did you mean `{similar}`?"),
    );
    reader.error(
        "unknown-parameter",
        span,
        format!("`{name}` is neither a duration nor a declared parameter."),
        remedy,
    );
    Amount::Missing
}

/// A quantity as a duration, or what is wrong with it.
fn seconds(quantity: &QuantityValue) -> Result<f64, String> {
    let second = "s".parse::<Unit>().ok();
    match second.and_then(|second| quantity.value_in(&second)) {
        Some(secs) if (0.0..=MAX_SECS).contains(&secs) => Ok(secs),
        Some(secs) => Err(format!(
            "A duration is from 0 s to {MAX_SECS} s, and this is {secs} s."
        )),
        None => Err(match quantity.unit() {
            Some(_) => format!("{quantity} is a {}, not a time.", quantity.dimension()),
            None => format!("The duration {quantity} has no unit."),
        }),
    }
}
