//! The part before `shall`: scope, condition, component.

use super::expression::expression;
use super::{Reader, no_scope, place, top_level, trimmed};
use crate::diagnostic::Span;
use crate::lexer::{Kind, Token};
use crate::sentence::{Condition, ConditionKind, Scope, ScopeKind};

/// What stands before `shall`.
pub(super) struct Clauses {
    pub(super) scope: Scope,
    pub(super) condition: Option<Condition>,
    pub(super) component: String,
}

const SCOPE_WORDS: [&str; 6] = ["in", "during", "while", "before", "after", "only"];
const CONDITION_WORDS: [&str; 6] = ["when", "upon", "if", "whenever", "where", "unless"];
/// The words with which what follows a component can begin.
const TIMING_WORDS: [&str; 19] = [
    "with",
    "in",
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
    "satisfy",
    "repeatedly",
    "not",
    "then",
    "shall",
];

/// Reads the tokens before `shall`; `needs_component` if the component has to be among them.
pub(super) fn clauses(
    reader: &mut Reader<'_>,
    left: &[Token<'_>],
    shall: Span,
    needs_component: bool,
) -> Clauses {
    let component_at = if needs_component {
        component_start(left)
    } else {
        left.len()
    };
    let component = component(reader, &left[component_at..], shall, needs_component);
    let mut rest = trimmed(&left[..component_at]);
    let (scope, used) = scope(reader, rest);
    rest = trimmed(&rest[used..]);
    if rest.first().is_some_and(|token| token.kind == Kind::And) {
        rest = &rest[1..];
    }
    let condition = condition(reader, rest);
    Clauses {
        scope,
        condition,
        component,
    }
}

/// The component that follows `shall`, as in "Only in M shall the robot ...", and what follows it.
pub(super) fn component_behind<'a, 't>(
    right: &'a [Token<'t>],
) -> (Option<String>, &'a [Token<'t>]) {
    if !right.first().is_some_and(|token| token.is("the")) {
        return (None, right);
    }
    let words = right[1..].iter();
    let length = words
        .take_while(|token| token.kind == Kind::Word && !begins_other(token))
        .count();
    // Without a keyword behind it, all of it is the component and the response; one word is enough.
    let length = if length + 1 == right.len() {
        length.min(1)
    } else {
        length
    };
    if length == 0 {
        return (None, right);
    }
    let name = spoken(&right[1..=length]);
    (Some(name), &right[1 + length..])
}

/// Whether a word cannot be part of a component's name.
fn begins_other(token: &Token<'_>) -> bool {
    let words = [&TIMING_WORDS[..], &SCOPE_WORDS, &CONDITION_WORDS, &["the"]];
    words.iter().any(|words| token.is_any(words))
}

/// Where the component begins: at the last `the`, else behind the last comma, else, where there are
/// no other clauses, at the beginning.
fn component_start(left: &[Token<'_>]) -> usize {
    let comma = top_level(left, |token| token.kind == Kind::Comma)
        .last()
        .map(|index| index + 1);
    let article = top_level(left, |token| token.is("the")).last().copied();
    match (comma, article) {
        (comma, Some(article)) if comma.is_none_or(|comma| article >= comma) => article,
        (Some(comma), _) if !left.get(comma).is_some_and(begins_clause) => comma,
        (None, None) if !left.first().is_some_and(begins_clause) => 0,
        _ => left.len(),
    }
}

fn begins_clause(token: &Token<'_>) -> bool {
    token.is_any(&SCOPE_WORDS) || token.is_any(&CONDITION_WORDS) || token.kind == Kind::Not
}

fn component(reader: &mut Reader<'_>, tokens: &[Token<'_>], shall: Span, needed: bool) -> String {
    let words = match tokens {
        [the, rest @ ..] if the.is("the") => rest,
        other => other,
    };
    if words.is_empty() && needed {
        reader.error(
            "no-component",
            Span::new(shall.start, shall.start),
            "The sentence does not say who shall meet the requirement.",
            "Write `the COMPONENT` before `shall`, for example `the robot shall`.",
        );
    }
    let odd = |token: &&Token<'_>| {
        token.kind != Kind::Word || token.is_any(&SCOPE_WORDS) || token.is_any(&CONDITION_WORDS)
    };
    if let Some(odd) = words.iter().find(odd) {
        reader.error(
            "component",
            odd.span,
            format!("`{}` cannot be part of the name of a component.", odd.text),
            "Put scope and condition before `the COMPONENT`, and name it in plain words, as in `the robot`.",
        );
    }
    spoken(words)
}

fn spoken(tokens: &[Token<'_>]) -> String {
    let words: Vec<&str> = tokens.iter().map(|token| token.text).collect();
    words.join(" ")
}

/// The scope at the start of `tokens`, and how many tokens it takes.
fn scope(reader: &mut Reader<'_>, tokens: &[Token<'_>]) -> (Scope, usize) {
    let Some((kind, keywords)) = scope_keywords(tokens) else {
        return (no_scope(), 0);
    };
    let body = &tokens[keywords..];
    let length = clause_length(body);
    let mode = without_mode(&body[..length]);
    let last = tokens[keywords - 1].span;
    let scope = Scope {
        kind,
        mode: expression(reader, mode, last),
        span: place(&tokens[..keywords + length], last),
    };
    (scope, keywords + length)
}

/// The kind of scope that the first words announce, and how many words these are.
fn scope_keywords(tokens: &[Token<'_>]) -> Option<(ScopeKind, usize)> {
    let word =
        |index: usize, words: &[&str]| tokens.get(index).is_some_and(|token| token.is_any(words));
    let within = ["in", "during", "while"];
    if word(0, &["only"]) {
        let skip = 1 + usize::from(word(1, &["when", "if"]) && word(2, &["in"]));
        return match tokens.get(skip) {
            Some(token) if token.is_any(&within) => Some((ScopeKind::OnlyIn, skip + 1)),
            Some(token) if token.is("before") => Some((ScopeKind::OnlyBefore, skip + 1)),
            Some(token) if token.is("after") => Some((ScopeKind::OnlyAfter, skip + 1)),
            _ => None,
        };
    }
    match () {
        () if word(0, &["when", "if"]) && word(1, &["not"]) && word(2, &["in", "during"]) => {
            Some((ScopeKind::NotIn, 3))
        }
        () if word(0, &["not"]) && word(1, &["in", "during"]) => Some((ScopeKind::NotIn, 2)),
        () if word(0, &["unless", "except"]) && word(1, &within) => Some((ScopeKind::NotIn, 2)),
        () if word(0, &["when", "if"]) && word(1, &["in"]) => Some((ScopeKind::In, 2)),
        () if word(0, &within) => Some((ScopeKind::In, 1)),
        () if word(0, &["before"]) => Some((ScopeKind::Before, 1)),
        () if word(0, &["after"]) => Some((ScopeKind::After, 1)),
        () => None,
    }
}

/// How many tokens belong to the clause: those before a comma or a condition's keyword.
fn clause_length(tokens: &[Token<'_>]) -> usize {
    let ends = top_level(tokens, |token| {
        token.kind == Kind::Comma || token.is_any(&CONDITION_WORDS)
    });
    let length = ends.first().copied().unwrap_or(tokens.len());
    // "in M and when C": the "and" joins the clauses.
    match length.checked_sub(1).map(|last| tokens[last].kind) {
        Some(Kind::And) if length < tokens.len() => length - 1,
        _ => length,
    }
}

/// "mode lifting" and "lifting mode" are "lifting".
fn without_mode<'a, 't>(tokens: &'a [Token<'t>]) -> &'a [Token<'t>] {
    match tokens {
        [first, rest @ ..]
            if first.is("mode") && !rest.is_empty() && rest[0].kind == Kind::Word =>
        {
            rest
        }
        [rest @ .., last] if last.is("mode") && !rest.is_empty() => rest,
        other => other,
    }
}

fn condition(reader: &mut Reader<'_>, tokens: &[Token<'_>]) -> Option<Condition> {
    let first = tokens.first()?;
    let kind = match () {
        () if first.is("unless") => ConditionKind::Unless,
        () if first.is("whenever") => ConditionKind::Whenever,
        () if first.is_any(&CONDITION_WORDS) => ConditionKind::Upon,
        () => {
            reader.error(
                "unexpected",
                place(tokens, first.span),
                format!("`{}` begins neither a scope nor a condition.", first.text),
                "Begin a scope with `in`, `while`, `before`, `after` or `only`, a condition with \
                 `when`, `whenever`, `if` or `unless`, and the component with `the`.",
            );
            return None;
        }
    };
    let body = &tokens[1..];
    let length = clause_length(body);
    if let Some(more) = trimmed(&body[length..]).first() {
        reader.error(
            "second-condition",
            more.span,
            format!(
                "A sentence has one condition, but `{}` begins another clause.",
                more.text
            ),
            "Join the conditions with `and` or `or` behind one keyword; a scope goes first.",
        );
    }
    Some(Condition {
        kind,
        expression: expression(reader, &body[..length], first.span),
        span: place(&tokens[..=length], first.span),
    })
}
