//! Edits of how a `trace` or a `model` expression of the vocabulary is put together: its negations, its `&` and `|`, its
//! comparisons and its clauses.
//!
//! # Definition
//! Of every expression that a subject in disagreement reads, one of these at a time:
//! * a `!` left out, or put before an operand that compares nothing or stands in parentheses; `=` for `!=`, and back;
//! * `|` for `&`, and back;
//! * `<=` for `<`, `>=` for `>`, and back; in a `model` expression also the other way round (in a `trace` one
//!   [`super::quantities`] does that);
//! * an operand of `&` or `|` left out;
//! * in a `model` expression: a state of the variable that the model comes to and no proposition names, as a further case
//!   beside `variable=value`; or `variable!=other` for it, where another proposition names `variable=other`.
//!
//! What is only another way to say the same (`!(a < b)` for `a >= b`) is tried once.
//!
//! # Guarantee
//! That of [`super`]: none. Nothing but the further case has a hint, which is that a place is free for it.

use super::quantities::{add, comparisons};
use super::{Reach, TextEdit, assigned, binding, equality, of_monitor, plain};
use evidence::Subject;
use std::collections::BTreeSet;
use std::ops::Range;
use study::{Study, SubjectForm, quoted_names};

/// Other ways to put the expressions together that subjects in disagreement read.
pub(super) fn of_vocabulary(study: &Study, disagrees: &dyn Fn(&Subject) -> bool) -> Vec<TextEdit> {
    let mut found = Vec::new();
    let forms = || {
        study
            .forms
            .subjects
            .iter()
            .filter(|form| disagrees(&form.subject))
    };
    for (name, proposition) in &study.vocabulary.propositions {
        let is_judged = forms().any(|form| of_monitor(form).contains(name));
        if let Some(place) = proposition.trace.as_ref().filter(|_| is_judged) {
            for new in rewritten(&place.text, Language::Trace) {
                add(
                    binding((name, "trace"), place, new, Reach::Runs, None),
                    &mut found,
                );
            }
        }
        let is_asked = forms().any(|form| of_property(form).contains(name));
        if let Some(place) = proposition.model.as_ref().filter(|_| is_asked) {
            for new in rewritten(&place.text, Language::Model) {
                add(
                    binding((name, "model"), place, new, Reach::Models, None),
                    &mut found,
                );
            }
            for (new, hint) in cases(study, &place.text) {
                add(
                    binding((name, "model"), place, new, Reach::Models, hint),
                    &mut found,
                );
            }
        }
    }
    found
}

/// The propositions that a form for models asks for, its trigger's among them.
pub(super) fn of_property(form: &SubjectForm) -> BTreeSet<String> {
    let texts = [&form.property, &form.opportunity].into_iter().flatten();
    let names = texts.flat_map(|text| quoted_names(&text.text));
    let mut found: BTreeSet<String> = names.map(|(name, _)| name).collect();
    // The trigger of a sentence is asked for with it.
    if form.sentence.is_some() {
        found.extend(of_monitor(form));
    }
    found
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Language {
    Trace,
    Model,
}

/// The operands of one level of an expression, and the operators between them.
#[derive(Debug)]
struct Chain {
    operands: Vec<Range<usize>>,
    operators: Vec<Range<usize>>,
}

impl Chain {
    /// One level of a text: what `&`, `|` and `=>` outside of parentheses and quotes divide.
    fn of(text: &str, within: Range<usize>) -> Self {
        let (mut operands, mut operators) = (Vec::new(), Vec::new());
        let (mut depth, mut quoted, mut start) = (0_i32, None, within.start);
        let bytes = text.as_bytes();
        let mut at = within.start;
        while at < within.end {
            let one = bytes[at];
            let length = match (quoted, one) {
                (Some(quote), _) => {
                    quoted = (one != quote).then_some(quote);
                    0
                }
                (None, b'\'' | b'"') => {
                    quoted = Some(one);
                    0
                }
                (None, b'(' | b'[' | b'{') => {
                    depth += 1;
                    0
                }
                (None, b')' | b']' | b'}') => {
                    depth -= 1;
                    0
                }
                (None, b'&' | b'|') if depth == 0 => 1,
                (None, b'=') if depth == 0 && bytes.get(at + 1) == Some(&b'>') => 2,
                (None, _) => 0,
            };
            if length > 0 {
                operands.push(trimmed(text, start..at));
                operators.push(at..at + length);
                start = at + length;
            }
            at += length.max(1);
        }
        operands.push(trimmed(text, start..within.end));
        Self {
            operands,
            operators,
        }
    }

    fn is_plain(&self, text: &str) -> bool {
        let mut all = self.operators.iter();
        all.all(|it| ["&", "|"].contains(&&text[it.clone()]))
    }

    /// The text without one of its operands.
    fn without(&self, text: &str, place: usize) -> String {
        let gone = match place {
            0 => self.operands[0].start..self.operands[1].start,
            _ => self.operands[place - 1].end..self.operands[place].end,
        };
        put(text, gone, "")
    }
}

fn trimmed(text: &str, within: Range<usize>) -> Range<usize> {
    let part = &text[within.clone()];
    let start = within.start + (part.len() - part.trim_start().len());
    start..(start + part.trim().len())
}

fn put(text: &str, place: Range<usize>, new: &str) -> String {
    format!("{}{new}{}", &text[..place.start], &text[place.end..])
}

/// Whether an operand is one pair of parentheses with what is in it.
fn is_group(operand: &str) -> bool {
    let mut depth = 0;
    let last = operand.len().saturating_sub(1);
    operand.starts_with('(')
        && operand.bytes().enumerate().all(|(at, one)| {
            depth += match one {
                b'(' => 1,
                b')' => -1,
                _ => 0,
            };
            depth > 0 || at == last
        })
}

/// Every text that one change of a clause makes of an expression.
fn rewritten(text: &str, language: Language) -> Vec<String> {
    let mut found = Vec::new();
    level(text, 0..text.len(), language, &mut found);
    for (span, sign) in comparisons(text).into_iter().map(|(span, turned)| {
        let sign = text[span.clone()].to_owned();
        (span, (sign, turned))
    }) {
        let (sign, turned) = sign;
        let other = match sign.strip_suffix('=') {
            Some(strict) => strict.to_owned(),
            None => format!("{sign}="),
        };
        found.push(put(text, span.clone(), &other));
        if language == Language::Model {
            found.push(put(text, span, turned));
        }
    }
    found
}

/// The changes of one level, and of what stands in parentheses in it.
fn level(text: &str, within: Range<usize>, language: Language, found: &mut Vec<String>) {
    let chain = Chain::of(text, within);
    for operator in &chain.operators {
        match &text[operator.clone()] {
            "&" => found.push(put(text, operator.clone(), "|")),
            "|" => found.push(put(text, operator.clone(), "&")),
            _ => {}
        }
    }
    for (place, operand) in chain.operands.iter().enumerate() {
        if chain.operands.len() > 1 && chain.is_plain(text) {
            found.push(chain.without(text, place));
        }
        let own = &text[operand.clone()];
        let rest = own.trim_start_matches(|c: char| c == '!' || c.is_whitespace());
        let bare = operand.end - rest.len()..operand.end;
        match own.starts_with('!') {
            true => found.push(put(text, operand.start..operand.start + 1, "")),
            false if is_group(rest) || (compares_nothing(rest) && is_said_of_states(rest)) => {
                found.push(put(text, operand.start..operand.start, "!"));
            }
            false => found.extend(unequal(text, &bare, language)),
        }
        if is_group(rest) {
            level(text, bare.start + 1..bare.end - 1, language, found);
        }
    }
}

fn compares_nothing(operand: &str) -> bool {
    !operand.contains(['=', '<', '>'])
}

/// Whether an operand says something of a state: `true` and numbers say nothing.
fn is_said_of_states(operand: &str) -> bool {
    !["", "true", "false"].contains(&operand) && operand.parse::<f64>().is_err()
}

/// An equality for an inequality, and back.
fn unequal(text: &str, within: &Range<usize>, language: Language) -> Option<String> {
    let own = &text[within.clone()];
    let equal = match language {
        Language::Trace => "==",
        Language::Model => "=",
    };
    let at = |sign: &str| {
        own.find(sign)
            .map(|at| within.start + at..within.start + at + sign.len())
    };
    if let Some(place) = at("!=") {
        return Some(put(text, place, equal));
    }
    let is_compared = own.contains("<=") || own.contains(">=") || own.contains("=>");
    let place = at(equal).filter(|_| !is_compared)?;
    Some(put(text, place, "!="))
}

/// Further cases of an expression on a model's states, each with what suggests it.
fn cases(study: &Study, text: &str) -> Vec<(String, Option<String>)> {
    let all = study.vocabulary.propositions.values();
    let named: Vec<String> = all
        .filter_map(|it| Some(plain(&it.model.as_ref()?.text)))
        .collect();
    let states = |variable: &str| {
        let mut found: Vec<(String, String)> = Vec::new();
        for entry in &study.ledger {
            let Some(model) = entry.work.model() else {
                continue;
            };
            // A model that cannot be read comes to no state.
            let source = host::files::read_prism(&study.folder.join(model));
            let Ok((source, _)) = source else { continue };
            for value in assigned(&source.text, variable) {
                found.push((value, model.display().to_string()));
            }
        }
        found
    };
    further(text, &states, &named)
}

/// The same, with the states that a variable comes to, and by which model, and what the propositions are.
fn further(
    text: &str,
    states: &dyn Fn(&str) -> Vec<(String, String)>,
    named: &[String],
) -> Vec<(String, Option<String>)> {
    let is_named = |state: &str| named.iter().any(|it| has_state(it, state));
    let mut found: Vec<(String, Option<String>)> = Vec::new();
    let chain = Chain::of(text, 0..text.len());
    let is_of_cases = chain.operators.iter().all(|it| &text[it.clone()] == "|");
    let mut looked_at: BTreeSet<String> = BTreeSet::new();
    for operand in &chain.operands {
        let Some((variable, own)) = equality(&text[operand.clone()]) else {
            continue;
        };
        let is_first = looked_at.insert(variable.clone());
        for (value, model) in states(&variable) {
            let state = format!("{variable}={value}");
            if value == own {
                continue;
            }
            if is_named(&state) {
                // Another proposition's state is what this one is not.
                let is_other = !has_state(&plain(text), &state);
                let new = put(text, operand.clone(), &format!("{variable}!={value}"));
                found.extend(is_other.then_some((new, None)));
                continue;
            }
            let hint = format!("{model} comes to `{state}`, which no proposition names");
            let new = match is_of_cases {
                true => format!("{text} | {state}"),
                false => put(
                    text,
                    operand.clone(),
                    &format!("({variable}={own} | {state})"),
                ),
            };
            if !is_of_cases || is_first {
                found.push((new, Some(hint)));
            }
        }
    }
    found
}

/// Whether a binding without blanks names a state.
fn has_state(text: &str, state: &str) -> bool {
    let is_word = |c: Option<char>| c.is_some_and(|c| c.is_ascii_alphanumeric() || c == '_');
    text.match_indices(state).any(|(at, _)| {
        !is_word(text[..at].chars().next_back())
            && !is_word(text[at + state.len()..].chars().next())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clauses_of_traces_are_negated_joined_otherwise_and_left_out() {
        let found = rewritten("/crate.full & !(/belt.speed > 2)", Language::Trace);
        assert_eq!(
            found,
            [
                "/crate.full | !(/belt.speed > 2)",
                "!(/belt.speed > 2)",
                "!/crate.full & !(/belt.speed > 2)",
                "/crate.full",
                "/crate.full & (/belt.speed > 2)",
                "/crate.full & !(/belt.speed >= 2)",
            ]
        );
        assert_eq!(rewritten("!/crate.full", Language::Trace), ["/crate.full"]);
        let found = rewritten("/m.mode == 'a & b'", Language::Trace);
        assert_eq!(found, ["/m.mode != 'a & b'"]);
    }

    #[test]
    fn clauses_of_models_are_compared_otherwise() {
        let found = rewritten("b!=open & (n<3 | done)", Language::Model);
        assert_eq!(
            found,
            [
                "b!=open | (n<3 | done)",
                "(n<3 | done)",
                "b=open & (n<3 | done)",
                "b!=open",
                "b!=open & !(n<3 | done)",
                "b!=open & (n<3 & done)",
                "b!=open & (done)",
                "b!=open & (n<3)",
                "b!=open & (n<3 | !done)",
                "b!=open & (n<=3 | done)",
                "b!=open & (n>3 | done)",
            ]
        );
        assert!(rewritten("true", Language::Model).is_empty());
    }

    #[test]
    fn a_state_that_nothing_names_is_a_further_case() {
        let states = |_: &str| {
            ["1", "2", "4"]
                .map(|it| (it.to_owned(), "m.prism".to_owned()))
                .to_vec()
        };
        let named = ["s=1".to_owned(), "s=2".to_owned()];
        let found = further("s=1", &states, &named);
        let texts: Vec<&str> = found.iter().map(|(text, _)| text.as_str()).collect();
        assert_eq!(texts, ["s!=2", "s=1 | s=4"]);
        assert!(found[0].1.is_none() && found[1].1.is_some());
        let found = further("s=1 & near", &states, &named);
        assert_eq!(found[1].0, "(s=1 | s=4) & near");
        let found = further("s=1 | s=2", &states, &named);
        assert_eq!(found.len(), 1, "one further case: {found:?}");
        assert!(
            has_state("s=1&t=2", "s=1") && !has_state("s=12", "s=1") && !has_state("bus=1", "s=1")
        );
    }
}
