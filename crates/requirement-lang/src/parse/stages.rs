//! The part behind `shall`: the probability, and the stages joined by `then`.

use super::duration::duration;
use super::expression::expression;
use super::{Reader, place, probability, top_level, trimmed};
use crate::diagnostic::Span;
use crate::expression::Expression;
use crate::lexer::{Kind, Token};
use crate::sentence::{Amount, Probability, ScopeKind, Stage, Timing};

/// What stands behind `shall`.
pub(super) struct Response {
    pub(super) probability: Option<Probability>,
    pub(super) stages: Vec<Stage>,
}

/// The words with which a timing can begin.
const TIMING_WORDS: [&str; 12] = [
    "immediately",
    "initially",
    "eventually",
    "always",
    "never",
    "finally",
    "at",
    "within",
    "for",
    "after",
    "until",
    "before",
];

/// Reads the tokens behind `shall`.
pub(super) fn stages(
    reader: &mut Reader<'_>,
    right: &[Token<'_>],
    shall: Span,
    scope: ScopeKind,
) -> Response {
    let mut tokens = right.to_vec();
    let probability = probability::take(reader, &mut tokens);
    let mut cuts = top_level(&tokens, |token| token.is("then"));
    cuts.push(tokens.len());
    let mut stages = Vec::new();
    let (mut start, mut before) = (0, shall);
    for cut in cuts {
        stages.push(stage(reader, trimmed(&tokens[start..cut]), before));
        before = tokens.get(cut).map_or(before, |token| token.span);
        start = cut + 1;
    }
    check_order(reader, &stages);
    if scope.is_only() && stages.len() > 1 {
        reader.error(
            "only-stages",
            stages[1].span,
            "With `only`, a timing is negated, which has no meaning for several stages.",
            "Write one requirement for each stage, or use a scope without `only`.",
        );
    }
    Response {
        probability,
        stages,
    }
}

fn check_order(reader: &mut Reader<'_>, stages: &[Stage]) {
    for pair in stages.windows(2) {
        if !pair[0].timing.completes() {
            reader.error(
                "endless-stage",
                pair[0].span,
                "Nothing can come after a stage that never ends.",
                "Use `until`, `for` or `within` in all stages but the last one.",
            );
        }
    }
}

fn stage(reader: &mut Reader<'_>, tokens: &[Token<'_>], before: Span) -> Stage {
    let span = place(tokens, before);
    let (leading, used) = timing(reader, tokens);
    let (negated, satisfy, rest) = opening(trimmed(&tokens[used..]), leading.is_some());
    let (trailing, response) = trailing_timing(reader, rest);
    let read = expression(reader, response, satisfy.unwrap_or(before));
    if negated && (satisfy.is_none() || trailing.is_some()) {
        check_negation(reader, response, trailing.as_ref(), span);
    }
    let (timing, response) = match (leading, trailing) {
        (Some(_), Some((_, second))) => {
            reader.error(
                "second-timing",
                second,
                "The stage has a timing already.",
                "Keep one of the two, or join two stages with `then`.",
            );
            (Timing::Eventually, Expression::Missing)
        }
        (Some(timing), None) if negated => (timing, read.negation()),
        (Some(timing), None) | (None, Some((timing, _))) => (timing, read),
        (None, None) if negated => (Timing::Never, read),
        (None, None) => {
            no_timing(reader, response, span);
            (Timing::Eventually, read)
        }
    };
    Stage {
        timing,
        response,
        span,
    }
}

/// Takes `not` and `satisfy` off the tokens. Without a timing before it, any `not` is taken off,
/// since "shall not R" is "shall never R"; with one, only that in "not satisfy", since any other
/// belongs to the expression.
fn opening<'a, 't>(tokens: &'a [Token<'t>], timed: bool) -> (bool, Option<Span>, &'a [Token<'t>]) {
    match tokens {
        [not, satisfy, rest @ ..] if not.is("not") && satisfy.is("satisfy") => {
            (true, Some(satisfy.span), rest)
        }
        [not, rest @ ..] if not.is("not") && !timed => (true, None, rest),
        [satisfy, rest @ ..] if satisfy.is("satisfy") => (false, Some(satisfy.span), rest),
        rest => (false, None, rest),
    }
}

/// "shall not A and B" and "shall not R within 2 s" can each be read in two ways.
fn check_negation(
    reader: &mut Reader<'_>,
    response: &[Token<'_>],
    trailing: Option<&(Timing, Span)>,
    span: Span,
) {
    let connectives = top_level(response, |token| {
        !matches!(token.kind, Kind::Word | Kind::Comma)
    });
    if let Some((_, place)) = trailing {
        reader.error(
            "ambiguous-not",
            *place,
            "`not` with a timing behind it can be read in two ways.",
            "Put the timing first: `for 2 s satisfy not R`, `until Q satisfy not R`.",
        );
    } else if !connectives.is_empty() {
        reader.error(
            "ambiguous-not",
            span,
            "It is not clear how much the `not` before the response negates.",
            "Write `never satisfy (...)`, or `always satisfy not (...)`.",
        );
    }
}

fn no_timing(reader: &mut Reader<'_>, response: &[Token<'_>], span: Span) {
    // A timing that is misspelt looks like the first word of a phrase.
    let word = response
        .first()
        .map_or("", |token| token.text)
        .to_lowercase();
    if response.len() > 1
        && let Some(similar) = trace::nearest(
            &word,
            TIMING_WORDS.iter().copied().filter(|known| known.len() > 4),
        )
    {
        reader.error(
            "timing",
            response[0].span,
            format!("`{}` is not a timing.", response[0].text),
            format!("Did you mean `{similar}`?"),
        );
        return;
    }
    reader.warning(
        "no-timing",
        span,
        "The response has no timing, and is read as `eventually`.",
        "Write `immediately`, `always`, `eventually` or `within 2 s` before it, as is meant.",
    );
}

/// The timing at the start of `tokens`, if any, and how many tokens it takes.
fn timing(reader: &mut Reader<'_>, tokens: &[Token<'_>]) -> (Option<Timing>, usize) {
    let Some(first) = tokens.first() else {
        return (None, 0);
    };
    let repeated = usize::from(first.is("repeatedly"));
    let Some(word) = tokens.get(repeated) else {
        return (None, 0);
    };
    let next = repeated + 1;
    let simple = |timing: Timing| (Some(timing), next);
    match () {
        () if word.is_any(&["immediately", "initially"]) => simple(Timing::Immediately),
        () if word.is("eventually") => simple(Timing::Eventually),
        () if word.is("always") => simple(Timing::Always),
        () if word.is("never") => simple(Timing::Never),
        () if word.is("finally") => last_point(reader, word.span, next),
        () if word.is("at") => at_point(reader, tokens),
        () if word.is_any(&["within", "for", "after"]) => {
            let (duration, length) = duration(reader, &tokens[next..], word.span);
            let timing = match () {
                () if word.is("within") => Timing::Within(duration),
                () if word.is("for") => Timing::For(duration),
                () => Timing::After(duration),
            };
            (Some(timing), next + length)
        }
        () if word.is_any(&["until", "before"]) => stopped(reader, tokens, repeated),
        () => (None, 0),
    }
}

/// "until" or "before" at `keyword`, with a condition that ends at a comma or at "satisfy".
fn stopped(
    reader: &mut Reader<'_>,
    tokens: &[Token<'_>],
    keyword: usize,
) -> (Option<Timing>, usize) {
    let behind = &tokens[keyword + 1..];
    let ends = top_level(behind, |token| {
        token.kind == Kind::Comma || token.is("satisfy")
    });
    let length = ends.first().copied().unwrap_or(behind.len());
    let stop = expression(reader, &behind[..length], tokens[keyword].span);
    let timing = match tokens[keyword].is("until") {
        true => Timing::Until(stop),
        false => Timing::Before(stop),
    };
    (Some(timing), keyword + 1 + length)
}

/// "at the next step", "at the same time" and the like.
fn at_point(reader: &mut Reader<'_>, tokens: &[Token<'_>]) -> (Option<Timing>, usize) {
    const POINTS: [&str; 7] = [
        "step",
        "timepoint",
        "sample",
        "time",
        "point",
        "instant",
        "tick",
    ];
    match tokens {
        [_, the, which, point, ..] if the.is("the") && point.is_any(&POINTS) => match () {
            () if which.is("next") => (Some(Timing::Next), 4),
            () if which.is_any(&["same", "first"]) => (Some(Timing::Immediately), 4),
            () if which.is("last") => last_point(reader, which.span, 4),
            () => (None, 0),
        },
        [_, once, ..] if once.is("once") => (Some(Timing::Immediately), 2),
        _ => (None, 0),
    }
}

/// The last point of a scope is known only when it is over, which no technique can ask for alike.
fn last_point(reader: &mut Reader<'_>, span: Span, used: usize) -> (Option<Timing>, usize) {
    reader.error(
        "last-point",
        span,
        "A response at the last point of a scope is not supported.",
        "Say what must hold where the scope ends: `when SCOPE_HAS_ENDED, ... immediately satisfy ...`.",
    );
    (Some(Timing::Eventually), used)
}

/// A timing behind the response, with its place, and the tokens of the response.
fn trailing_timing<'a, 't>(
    reader: &mut Reader<'_>,
    tokens: &'a [Token<'t>],
) -> (Option<(Timing, Span)>, &'a [Token<'t>]) {
    // The response has at least one token before its timing.
    let starts = top_level(tokens, |token| {
        token.is_any(&TIMING_WORDS) || token.is("repeatedly")
    });
    // A `repeatedly` that no timing follows is a word of the response.
    let read = starts
        .into_iter()
        .filter(|start| *start > 0)
        .find_map(|start| {
            let (found, used) = timing(reader, &tokens[start..]);
            found.map(|timing| (start, timing, used))
        });
    let Some((start, timing, used)) = read else {
        return (None, tokens);
    };
    let behind = &tokens[start..];
    let rest = trimmed(&behind[used..]);
    if let Some(odd) = rest.first()
        && timing
            .duration()
            .is_none_or(|duration| duration.amount != Amount::Missing)
    {
        reader.error(
            "unexpected",
            odd.span,
            format!("`{}` does not belong to the timing before it.", odd.text),
            "Put the timing before `satisfy`, and join stages with `then`.",
        );
    }
    let span = match rest.is_empty() {
        true => place(behind, behind[0].span),
        false => behind[0].span,
    };
    (Some((timing, span)), trimmed(&tokens[..start]))
}
