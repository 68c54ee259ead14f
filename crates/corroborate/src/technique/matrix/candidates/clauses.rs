//! Edits of how a `trace` or a `model` expression of the vocabulary is put together: its negations, its `&` and `|`, its
//! comparisons and its clauses.
//!
//! # Definition
//! Of every expression that a subject in disagreement reads, one of these at a time:
//! * a `!` or `not` left out, or put before an operand that compares nothing or stands in parentheses; `=` for `!=`, and back;
//! * `|` for `&`, `or` for `and`, and back;
//! * `<=` for `<`, `>=` for `>`, and back; in a `model` expression also the other way round (in a `trace` one
//!   [`super::quantities`] does that), and `=` for `<=` and `>=`, and back;
//! * an operand of `&` or `|` left out; in a `trace` expression also one of another proposition's put behind it by `and`, or its negation,
//!   where it reads something of which the proposition's meaning speaks and its own expression reads nothing;
//! * in a `model` expression: a state of the variable that the model comes to and no proposition names, as a further case
//!   beside `variable=value`; or `variable!=other` for it, where another proposition names `variable=other`;
//! * in a `trace` expression that holds a signal against words, as `/robot.state == 'dropped'`: a further word that the proposition's
//!   `model` names;
//! * in a `model` expression of several cases: a Boolean variable of the model that no proposition names, as a further case.
//!
//! What is only another way to say the same (`!(a < b)` for `a >= b`) is tried once.
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried.
//!
//! # Guarantee
//! That of [`super`]: none. Nothing but the further case has a hint, which is that a place is free for it.

use super::quantities::{add, comparisons};
use super::{Reach, TextEdit, assigned, binding, equality, of_monitor, plain};
use evidence::Subject;
use std::collections::BTreeSet;
use std::ops::Range;
use study::{Study, SubjectForm, quoted_names};

/// Clauses of other propositions that are put behind one, at most.
const MOST_CLAUSES: usize = 24;

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
            let others = study.vocabulary.propositions.values();
            let others = others.filter_map(|it| Some(it.trace.as_ref()?.text.as_str()));
            for (new, of) in further_clauses(&place.text, &proposition.meaning, others) {
                let hint = format!("its meaning speaks of `{of}`, of which it reads nothing");
                add(
                    binding((name, "trace"), place, new, Reach::Runs, Some(hint)),
                    &mut found,
                );
            }
            let model = proposition.model.as_ref().map(|it| it.text.as_str());
            for (new, hint) in cases_of_words(&place.text, model) {
                // What the other binding of the same word says is said.
                let edit = TextEdit {
                    is_said: hint.is_some(),
                    ..binding((name, "trace"), place, new, Reach::Runs, hint)
                };
                add(edit, &mut found);
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

/// A model's expression of several clauses with one of them about another state, as `others` says, denied where it was.
pub(super) fn with_other_operands(text: &str, others: &dyn Fn(&str) -> Vec<String>) -> Vec<String> {
    let chain = Chain::of(text, 0..text.len());
    if chain.operands.len() < 2 {
        return Vec::new();
    }
    let mut found = Vec::new();
    for operand in &chain.operands {
        let own = &text[operand.clone()];
        let bare = own[negation(own)..].trim_start();
        let place = operand.end - bare.len()..operand.end;
        let is_plain = !bare.contains(['&', '|', '(', '<', '>', '!']);
        let new = others(bare).into_iter().filter(|_| is_plain);
        found.extend(
            new.filter(|it| it != bare)
                .map(|it| put(text, place.clone(), &it)),
        );
    }
    found
}

/// A trace expression with one clause more, and what this clause reads: what another proposition's expression consists of, or its
/// negation, of what the meaning speaks of and the expression does not read.
fn further_clauses<'t>(
    text: &str,
    meaning: &str,
    others: impl Iterator<Item = &'t str>,
) -> Vec<(String, String)> {
    let spoken = meaning.split(|c: char| !c.is_alphanumeric());
    let spoken: BTreeSet<String> = spoken.map(str::to_lowercase).collect();
    let own = read_of(text);
    let mut clauses: BTreeSet<(String, String)> = BTreeSet::new();
    for other in others {
        for operand in Chain::of(other, 0..other.len()).operands {
            let clause = &other[operand];
            let bare = clause.trim_start_matches("not ").trim_start_matches('!');
            let mut read = read_of(bare).into_iter();
            if let Some(of) = read.find(|it| spoken.contains(it) && !own.contains(it)) {
                clauses.insert((bare.trim().to_owned(), of));
            }
        }
    }
    let is_one = Chain::of(text, 0..text.len()).operands.len() == 1;
    let own = match is_one {
        true => text.to_owned(),
        false => format!("({text})"),
    };
    let both = clauses
        .into_iter()
        .take(MOST_CLAUSES)
        .flat_map(|(clause, of)| {
            let contrary = match is_signal(&clause) || clause.starts_with('(') {
                true => format!("not {clause}"),
                false => format!("not ({clause})"),
            };
            [clause, contrary].map(|clause| (format!("{own} and {clause}"), of.clone()))
        });
    both.collect()
}

/// Of what an expression reads signals: of `/worker.grips` it is `worker`.
fn read_of(text: &str) -> BTreeSet<String> {
    let signals = text.split('/').skip(1);
    let names = signals.filter_map(|rest| {
        let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_'));
        let name = &rest[..end.unwrap_or(rest.len())];
        (!name.is_empty()).then(|| name.to_lowercase())
    });
    names.collect()
}

/// Whether a clause is a signal by itself.
fn is_signal(clause: &str) -> bool {
    clause.starts_with('/') && !clause.contains(|c: char| c.is_whitespace() || "<>=!()".contains(c))
}

/// The propositions that a form for models asks for, its trigger's among them.
pub(in super::super) fn of_property(form: &SubjectForm) -> BTreeSet<String> {
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
                (None, b'a' | b'o') if depth == 0 => word_at(text, at, within.end),
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
        all.all(|it| turned(&text[it.clone()]).is_some())
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

/// The length of `and` or `or` where one stands as a word of its own, else 0.
fn word_at(text: &str, at: usize, end: usize) -> usize {
    let is_word = |c: Option<char>| c.is_some_and(|c| c.is_alphanumeric() || "_./".contains(c));
    if is_word(text[..at].chars().next_back()) {
        return 0;
    }
    let found = ["and", "or"].into_iter().find(|word| {
        text[at..end].starts_with(word) && !is_word(text[at + word.len()..end].chars().next())
    });
    found.map_or(0, str::len)
}

/// `|` for `&`, and back; none of other operators.
fn turned(operator: &str) -> Option<&'static str> {
    Some(match operator {
        "&" => "|",
        "|" => "&",
        "and" => "or",
        "or" => "and",
        _ => return None,
    })
}

/// The length of a negation that an operand begins with, `!` or `not`; 0 without one.
fn negation(operand: &str) -> usize {
    let behind = operand.strip_prefix("not");
    let is_word = behind.is_some_and(|it| it.starts_with(|c: char| c.is_whitespace() || c == '('));
    match (operand.starts_with('!'), is_word) {
        (true, _) => 1,
        (false, true) => 3,
        (false, false) => 0,
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
            if sign.ends_with('=') {
                found.push(put(text, span.clone(), "="));
            }
            found.push(put(text, span, turned));
        }
    }
    found
}

/// The changes of one level, and of what stands in parentheses in it.
fn level(text: &str, within: Range<usize>, language: Language, found: &mut Vec<String>) {
    let chain = Chain::of(text, within);
    for operator in &chain.operators {
        let other = turned(&text[operator.clone()]);
        found.extend(other.map(|other| put(text, operator.clone(), other)));
    }
    for (place, operand) in chain.operands.iter().enumerate() {
        if chain.operands.len() > 1 && chain.is_plain(text) {
            found.push(chain.without(text, place));
        }
        let own = &text[operand.clone()];
        let mut rest = own;
        while negation(rest) > 0 {
            rest = rest[negation(rest)..].trim_start();
        }
        let bare = operand.end - rest.len()..operand.end;
        match negation(own) {
            1.. => found.push(
                put(text, operand.start..operand.start + negation(own), "")
                    .trim()
                    .to_owned(),
            ),
            0 if is_group(rest) || (compares_nothing(rest) && is_said_of_states(rest)) => {
                found.push(put(text, operand.start..operand.start, "!"));
            }
            0 => {
                found.extend(unequal(text, &bare, language));
                if language == Language::Model {
                    found.extend(one_sided(text, &bare));
                }
            }
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

/// `>=` and `<=` for an equality.
fn one_sided(text: &str, within: &Range<usize>) -> Vec<String> {
    let own = &text[within.clone()];
    let Some(at) = own.find('=').filter(|_| !own.contains(['!', '<', '>'])) else {
        return Vec::new();
    };
    let place = within.start + at..within.start + at + 1;
    let signs = [">=", "<="].into_iter();
    signs.map(|sign| put(text, place.clone(), sign)).collect()
}

/// Further cases of an expression that holds a signal against a word: words that the proposition's `model` names. What other
/// propositions hold the signal against is what this one is not.
fn cases_of_words(text: &str, model: Option<&str>) -> Vec<(String, Option<String>)> {
    let chain = Chain::of(text, 0..text.len());
    if chain
        .operators
        .iter()
        .any(|it| !["|", "or"].contains(&&text[it.clone()]))
    {
        return Vec::new();
    }
    let compared = |text: &str| -> Vec<(String, String)> {
        let chain = Chain::of(text, 0..text.len());
        let operands = chain.operands.into_iter();
        operands
            .filter_map(|it| word_comparison(&text[it]))
            .collect()
    };
    let own = compared(text);
    let Some((signal, _)) = own.first().cloned() else {
        return Vec::new();
    };
    let is_known = |word: &str| own.iter().any(|(_, known)| known == word);
    let mut found: Vec<(String, Option<String>)> = Vec::new();
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let names = model.unwrap_or_default().split(|c: char| !is_part(c));
    // What a variable is held against, not the variable.
    let model_text = model.unwrap_or_default();
    for name in names.filter(|it| it.starts_with(|c: char| c.is_ascii_alphabetic())) {
        if model_text.contains(&format!("={name}")) || model_text.contains(&format!("= {name}")) {
            let new = format!("{text} | {signal} == '{name}'");
            if !is_known(name) && found.iter().all(|(known, _)| *known != new) {
                found.push((new, Some(format!("its `model` has the case `{name}`"))));
            }
        }
    }
    found
}

/// The signal and the word of `/signal == 'word'`.
fn word_comparison(operand: &str) -> Option<(String, String)> {
    let (signal, word) = operand.split_once("==")?;
    let word = word.trim();
    let word = ['\'', '"']
        .into_iter()
        .find_map(|quote| word.strip_prefix(quote)?.strip_suffix(quote))?;
    let signal = signal.trim();
    (signal.starts_with('/') && !signal.contains(char::is_whitespace))
        .then(|| (signal.to_owned(), word.to_owned()))
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
    let mut found = further(text, &states, &named);
    let chain = Chain::of(text, 0..text.len());
    if chain.operators.is_empty() || chain.operators.iter().any(|it| &text[it.clone()] != "|") {
        return found;
    }
    for entry in &study.ledger {
        let Some(model) = entry.work.model() else {
            continue;
        };
        let Ok((source, _)) = host::files::read_prism(&study.folder.join(model)) else {
            continue;
        };
        for variable in booleans(&source.text) {
            let is_named = named.iter().any(|it| has_state(it, variable));
            let new = format!("{text} | {variable}");
            if !is_named && found.iter().all(|(known, _)| *known != new) {
                let hint = format!(
                    "{} has `{variable}`, which no proposition names",
                    model.display()
                );
                found.push((new, Some(hint)));
            }
        }
    }
    found
}

/// The variables that a model's text declares as Boolean.
fn booleans(text: &str) -> Vec<&str> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let code = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default());
    let declared = code.filter_map(|line| {
        let (before, behind) = line.split_once(':')?;
        let is_bool = behind.trim_start().starts_with("bool");
        let name = before.trim();
        (is_bool && !name.is_empty() && name.chars().all(is_word)).then_some(name)
    });
    declared.collect()
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
    fn a_clause_of_another_proposition_is_put_behind_one() {
        let others = [
            "/gripper.open",
            "/gripper.open and not /worker.grips",
            "/crate.force > 40 N",
        ];
        let meaning = "The gripper has opened although the worker does not hold it.";
        let found = further_clauses("/gripper.open", meaning, others.into_iter());
        let wanted = [
            "/gripper.open and /worker.grips",
            "/gripper.open and not /worker.grips",
        ];
        assert!(found.iter().all(|(_, of)| of == "worker"));
        let found: Vec<&str> = found.iter().map(|(text, _)| text.as_str()).collect();
        assert_eq!(found, wanted);
        let found = further_clauses("/a.x or /b.x", "A, B or C.", ["/c.x > 1"].into_iter());
        let found: Vec<&str> = found.iter().map(|(text, _)| text.as_str()).collect();
        assert_eq!(
            found,
            [
                "(/a.x or /b.x) and /c.x > 1",
                "(/a.x or /b.x) and not (/c.x > 1)"
            ]
        );
    }

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
        assert_eq!(
            rewritten("/band.full and not /door.open", Language::Trace),
            [
                "/band.full or not /door.open",
                "not /door.open",
                "!/band.full and not /door.open",
                "/band.full",
                "/band.full and  /door.open",
            ]
        );
        assert_eq!(
            word_comparison("/a.state == 'on'"),
            Some(("/a.state".to_owned(), "on".to_owned()))
        );
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
        assert_eq!(rewritten("r>=4", Language::Model), ["r>4", "r=4", "r<=4"]);
        assert_eq!(rewritten("r=4", Language::Model), ["r!=4", "r>=4", "r<=4"]);
    }

    #[test]
    fn boolean_variables_are_those_that_are_declared() {
        let text = "module m\n  a : bool init false;\n s : [0..2]; // b : bool\n c:bool;\n [] s=0 -> 0.5 : (a'=true);\n";
        assert_eq!(booleans(text), ["a", "c"]);
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
