//! The probability: `with probability at least 0.95`, `in at least 95 % of cases`.

use super::{Reader, place};
use crate::diagnostic::Span;
use crate::lexer::{Kind, Token};
use crate::sentence::{Comparison, Probability};

const CASES: [&str; 10] = [
    "cases",
    "case",
    "runs",
    "trials",
    "attempts",
    "episodes",
    "times",
    "executions",
    "missions",
    "handovers",
];

/// The probability in `tokens`, if it has one, taken out of them.
pub(super) fn take<'t>(
    reader: &mut Reader<'_>,
    tokens: &mut Vec<Token<'t>>,
) -> Option<Probability> {
    let mut found = None;
    while let Some(start) = (0..tokens.len()).find(|start| begins(&tokens[*start..])) {
        let (read, length) = probability(reader, &tokens[start..]);
        if found.is_some() {
            refuse_second(
                reader,
                place(&tokens[start..start + length], Span::default()),
            );
        }
        found = found.or(read);
        tokens.drain(start..start + length);
        // The comma that set it off.
        if tokens
            .get(start)
            .is_some_and(|token| token.kind == Kind::Comma)
        {
            tokens.remove(start);
        }
    }
    found
}

/// Complains of a second probability.
pub(super) fn refuse_second(reader: &mut Reader<'_>, span: Span) {
    reader.error(
        "second-probability",
        span,
        "The sentence has a probability already.",
        "Keep one of the two; it holds for the whole requirement.",
    );
}

fn begins(tokens: &[Token<'_>]) -> bool {
    match tokens {
        [with, probability, ..] if with.is("with") && probability.is("probability") => true,
        [r#in, comparison, ..] => {
            r#in.is("in") && comparison_at(std::slice::from_ref(comparison), true).is_some()
        }
        _ => false,
    }
}

/// The comparison at the start, and how many tokens it takes. With `first_word`, the first of two
/// words is enough.
fn comparison_at(tokens: &[Token<'_>], first_word: bool) -> Option<(Comparison, usize)> {
    let first = tokens.first()?;
    let second =
        |words: &[&str]| first_word || tokens.get(1).is_some_and(|token| token.is_any(words));
    match () {
        () if first.is(">=") => Some((Comparison::AtLeast, 1)),
        () if first.is("<=") => Some((Comparison::AtMost, 1)),
        () if first.is(">") => Some((Comparison::MoreThan, 1)),
        () if first.is("<") => Some((Comparison::LessThan, 1)),
        () if first.is("at") && first_word => Some((Comparison::AtLeast, 1)),
        () if first.is("at") && second(&["least"]) => Some((Comparison::AtLeast, 2)),
        () if first.is("at") && second(&["most"]) => Some((Comparison::AtMost, 2)),
        () if first.is_any(&["more", "greater"]) && second(&["than"]) => {
            Some((Comparison::MoreThan, 2))
        }
        () if first.is_any(&["less", "fewer"]) && second(&["than"]) => {
            Some((Comparison::LessThan, 2))
        }
        () => None,
    }
}

/// Reads the phrase at the start, and says how many tokens it takes.
fn probability(reader: &mut Reader<'_>, tokens: &[Token<'_>]) -> (Option<Probability>, usize) {
    let as_share = tokens[0].is("in");
    let mut next = if as_share { 1 } else { 2 };
    let before = tokens[next - 1].span;
    let Some((comparison, length)) = comparison_at(&tokens[next..], false) else {
        let span = place(&tokens[..next], before);
        reader.error(
            "probability",
            span,
            "The probability has no comparison.",
            "Write `with probability at least 0.95`; `at most`, `more than` and `less than` are the others.",
        );
        return (None, next);
    };
    next += length;
    let Some(number) = tokens.get(next) else {
        reader.error(
            "probability",
            before,
            "The probability has no number.",
            "Write a number from 0 to 1, as in `with probability at least 0.95`.",
        );
        return (None, next);
    };
    next += 1;
    let mut text = number.text.to_owned();
    let mut span = Span::new(tokens[0].span.start, number.span.end);
    if let Some(sign) = tokens
        .get(next)
        .filter(|token| token.is_any(&["%", "percent"]))
    {
        text.push('%');
        span.end = sign.span.end;
        next += 1;
    }
    if as_share {
        next += share(reader, &tokens[next..], span);
    }
    (value(reader, &text, comparison, span), next)
}

/// Skips `of [all] cases`.
fn share(reader: &mut Reader<'_>, tokens: &[Token<'_>], span: Span) -> usize {
    let of = tokens.first().is_some_and(|token| token.is("of"));
    let all = usize::from(
        tokens
            .get(1)
            .is_some_and(|token| token.is_any(&["all", "the"])),
    );
    let cases = tokens
        .get(1 + all)
        .is_some_and(|token| token.is_any(&CASES));
    if of && cases {
        return 2 + all;
    }
    reader.error(
        "probability",
        span,
        "The sentence does not say of what this is a share.",
        "Write `in at least 95 % of runs`; cases, trials and attempts mean the same.",
    );
    usize::from(of)
}

fn value(
    reader: &mut Reader<'_>,
    text: &str,
    comparison: Comparison,
    span: Span,
) -> Option<Probability> {
    let decimal = match text.strip_suffix('%') {
        Some(percent) => hundredth(percent),
        None => plain(text).map(|(whole, fraction)| joined(&whole, &fraction)),
    };
    let value = decimal
        .as_ref()
        .and_then(|decimal| decimal.parse::<f64>().ok());
    match (decimal, value) {
        (Some(decimal), Some(value)) if (0.0..=1.0).contains(&value) => Some(Probability {
            comparison,
            value,
            decimal,
            span,
        }),
        _ => {
            reader.error(
                "probability",
                span,
                format!("`{text}` is not a probability."),
                "Write a number from 0 to 1 in digits, such as 0.95, or from 0 to 100 with `%`.",
            );
            None
        }
    }
}

/// The digits before and after the point.
fn plain(text: &str) -> Option<(String, String)> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |part: &str| part.chars().all(|letter| letter.is_ascii_digit());
    let some = !(whole.is_empty() && fraction.is_empty());
    (some && digits(whole) && digits(fraction)).then(|| (whole.to_owned(), fraction.to_owned()))
}

/// A hundredth of a decimal number: the point moved by two digits, so that nothing is rounded.
fn hundredth(text: &str) -> Option<String> {
    let (whole, fraction) = plain(text)?;
    let padded = format!("{whole:0>2}");
    let split = padded.len() - 2;
    Some(joined(
        &padded[..split],
        &format!("{}{fraction}", &padded[split..]),
    ))
}

fn joined(whole: &str, fraction: &str) -> String {
    let whole = match whole.trim_start_matches('0') {
        "" => "0",
        digits => digits,
    };
    match fraction.trim_end_matches('0') {
        "" => whole.to_owned(),
        fraction => format!("{whole}.{fraction}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentage_is_divided_without_rounding() {
        assert_eq!(hundredth("95").as_deref(), Some("0.95"));
        assert_eq!(hundredth("99.9").as_deref(), Some("0.999"));
        assert_eq!(hundredth("100").as_deref(), Some("1"));
        assert_eq!(hundredth("5").as_deref(), Some("0.05"));
        assert_eq!(hundredth(".5").as_deref(), Some("0.005"));
        assert_eq!(hundredth("9x"), None);
    }
}
