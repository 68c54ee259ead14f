//! Edits of the negations and operators in hand-written properties and formulas of requirements.toml.
//!
//! # Definition
//! Of a property or a formula of a subject in disagreement, one at a time: a negation left out, or put before a proposition;
//! `|` for `&`, `or` for `and`, and back; an implication for a conjunction, and back; `F` for `G`, `eventually` for `always`, and
//! back, of the same or of its negation, or without its limit of time; two propositions in each other's place; of a failure mode also that what its monitor or its column names comes about. In a formula also a quantity, a number or a comparison, as in the binding of a
//! proposition ([`super::quantities`]), in a property a whole number. Limits of time are in [`super::limits`], other propositions in [`super`].
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried.
//!
//! # Guarantee
//! That of [`super`]: none.

use super::limits::counts;
use super::quantities::{add, compared_numbers, comparisons, in_predicate};
use super::{REQUIREMENTS, Reach, TextEdit, block, of_monitor, part_of, values};
use evidence::{Subject, SuspectKind};
use std::ops::Range;
use study::{Rule, Study, SubjectForm, quoted_names};

/// Other clauses of properties and formulas.
pub(super) fn of_forms(study: &Study, disagrees: &dyn Fn(&Subject) -> bool) -> Vec<TextEdit> {
    let forms = study.forms.subjects.iter();
    let mut found = Vec::new();
    for form in forms.filter(|form| disagrees(&form.subject)) {
        for edit in happens(study, form) {
            add(edit, &mut found);
        }
        for text in written(study, form) {
            let is_word = |word: &str| study.vocabulary.propositions.contains_key(word);
            for new in rewritten(&text.text, &is_word, text.negation) {
                let edit = TextEdit {
                    file: REQUIREMENTS,
                    span: text.span.clone(),
                    old: text.text.clone(),
                    new,
                    kind: text.kind,
                    part: part_of(form, text.which),
                    reach: text.reach.clone(),
                    hint: None,
                    is_said: false,
                };
                add(edit, &mut found);
            }
            if text.which == "property" {
                for edit in whole_numbers(study, form, &text) {
                    add(edit, &mut found);
                }
            }
            if text.which == "monitor" {
                let all = in_predicate(study, &text.text, None, &[form]).into_iter();
                for (span, new, hint) in all.chain(elsewhere(study, &text.text)) {
                    let start = text.span.start;
                    let edit = TextEdit {
                        file: REQUIREMENTS,
                        old: text.text[span.clone()].to_owned(),
                        span: start + span.start..start + span.end,
                        new,
                        kind: text.kind,
                        part: part_of(form, text.which),
                        reach: text.reach.clone(),
                        is_said: hint.is_some(),
                        hint,
                    };
                    add(edit, &mut found);
                }
            }
        }
    }
    found
}

/// The whole numbers that a property compares variables with: those that the subject's text bounds something with, where it does not say
/// the first, and one more or less.
fn whole_numbers(study: &Study, form: &SubjectForm, text: &Written) -> Vec<TextEdit> {
    let said = counts(study, &form.subject);
    let whole = compared_numbers(&text.text)
        .into_iter()
        .filter(|(span, number)| {
            // A limit of time is another matter.
            let before = text.text[..span.start].trim_end_matches(['<', '>', '=', ' ']);
            let is_limit = before.ends_with(['F', 'G', 'U', 'W', 'R', 'X']);
            number.fract() == 0.0 && !said.contains(number) && !is_limit
        });
    let mut found = Vec::new();
    for (span, number) in whole {
        let told = said.iter().map(|it| (*it, true));
        let steps = [number + 1.0, number - 1.0].map(|it| (it, false));
        for (new, is_said) in told.chain(steps) {
            found.push(TextEdit {
                file: REQUIREMENTS,
                old: text.text[span.clone()].to_owned(),
                span: text.span.start + span.start..text.span.start + span.end,
                new: new.to_string(),
                kind: text.kind,
                part: part_of(form, text.which),
                reach: text.reach.clone(),
                hint: is_said
                    .then(|| format!("the text of {} says {new}", form.subject.in_words())),
                is_said,
            });
        }
    }
    found
}

/// The numbers of a formula's comparisons as propositions compare the same signal with, which say so.
fn elsewhere(study: &Study, text: &str) -> Vec<(Range<usize>, String, Option<String>)> {
    let words = &study.vocabulary.propositions;
    let mut found = Vec::new();
    for (span, signal) in compared_signals(text) {
        for (name, word) in words {
            let Some(trace) = &word.trace else { continue };
            for (place, other) in compared_signals(&trace.text) {
                let new = &trace.text[place];
                if signal == other && *new != text[span.clone()] {
                    let hint = format!("`{name}` compares `{signal}` with it");
                    found.push((span.clone(), new.to_owned(), Some(hint)));
                }
            }
        }
    }
    found
}

/// The numbers that signals are compared with, with their units, and the signal of each.
fn compared_signals(text: &str) -> Vec<(Range<usize>, &str)> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "_/.".contains(c);
    let signs = comparisons(text).into_iter();
    let found = signs.filter_map(|(sign, _)| {
        let before = text[..sign.start].trim_end();
        let start = before.rfind(|c: char| !is_part(c)).map_or(0, |it| it + 1);
        let signal = &before[start..];
        let rest = &text[sign.end..];
        let begin = sign.end + (rest.len() - rest.trim_start().len());
        let behind = &text[begin..];
        let digits = behind.find(|c: char| !(c.is_ascii_digit() || ".-".contains(c)));
        let digits = digits.unwrap_or(behind.len());
        // A unit, but no operator.
        let unit = behind[digits..].split([')', '&', '|', ',', '=']).next()?;
        let unit = unit.split(" and ").next()?.split(" or ").next()?.trim_end();
        let is_number = digits > 0 && signal.starts_with('/');
        is_number.then_some((begin..begin + digits + unit.len(), signal))
    });
    found.collect()
}

/// A failure mode's property as what its other forms say: that a proposition comes about which they name, and its opportunity
/// does not.
fn happens(study: &Study, form: &SubjectForm) -> Vec<TextEdit> {
    let property = form.property.as_ref().filter(|it| !it.from_sentence);
    let (Some(property), Subject::FailureMode(_)) = (property, &form.subject) else {
        return Vec::new();
    };
    let names = |text: &str| quoted_names(text).into_iter().map(|(name, _)| name);
    let before: Vec<String> = form
        .opportunity
        .iter()
        .flat_map(|it| names(&it.text))
        .collect();
    let words = &study.vocabulary.propositions;
    let has_states = |name: &String| words.get(name).is_some_and(|it| it.model.is_some());
    let named = of_monitor(form).into_iter().chain(form.experiment.clone());
    let named = named.filter(|it| has_states(it) && !before.contains(it));
    let edits = named.map(|name| TextEdit {
        file: REQUIREMENTS,
        span: property.span.clone(),
        old: property.text.clone(),
        new: format!("P=? [ F \"{name}\" ]"),
        kind: SuspectKind::Property,
        part: part_of(form, "property"),
        reach: Reach::Models,
        hint: Some(format!("the other forms of it name `{name}`")),
        is_said: true,
    });
    edits.filter(|it| it.new != it.old).collect()
}

/// A form that was written by hand.
struct Written {
    span: Range<usize>,
    text: String,
    which: &'static str,
    kind: SuspectKind,
    reach: Reach,
    /// How its language negates.
    negation: &'static str,
}

fn written(study: &Study, form: &SubjectForm) -> Vec<Written> {
    let property = form.property.iter().filter(|it| !it.from_sentence);
    let properties = property.map(|it| Written {
        span: it.span.clone(),
        text: it.text.clone(),
        which: "property",
        kind: SuspectKind::Property,
        reach: Reach::Models,
        negation: "!",
    });
    let text = &study.forms.source.text;
    let rule = form.monitor.as_ref().map(|monitor| &monitor.rule);
    let is_own = |written: &str| matches!(rule, Some(Rule::Formula(rule)) if rule.text == written);
    let formulas = values(text, block(text, form), "formula").into_iter();
    let formulas = formulas.filter_map(|(span, quoted)| {
        let text = quoted.trim_matches(['"', '\'']).to_owned();
        is_own(&text).then(|| Written {
            span: span.start + 1..span.start + 1 + text.len(),
            text,
            which: "monitor",
            kind: SuspectKind::Monitor,
            reach: Reach::Runs,
            negation: "not ",
        })
    });
    properties.chain(formulas).collect()
}

/// Every text that one change of a negation or an operator makes of a form.
fn rewritten(text: &str, is_proposition: &dyn Fn(&str) -> bool, negation: &str) -> Vec<String> {
    let put = |place: Range<usize>, new: &str| {
        format!("{}{new}{}", &text[..place.start], &text[place.end..])
    };
    let mut found = Vec::new();
    for place in tokens(text) {
        let behind = &text[place.end..];
        let quote = text[..place.start]
            .chars()
            .next_back()
            .filter(|c| *c == '"');
        let is_doubled =
            |sign: char| behind.starts_with(sign) || text[..place.start].ends_with(sign);
        match &text[place.clone()] {
            // What is given is no disjunction.
            "|" if is_doubled('|') => {}
            "&" => found.extend([put(place.clone(), "|"), put(place, "=>")]),
            "|" => found.push(put(place, "&")),
            "and" => found.extend([put(place.clone(), "or"), put(place, "=>")]),
            "or" => found.push(put(place, "and")),
            "=" if behind.starts_with('>') => {
                let and = if negation == "!" { "&" } else { "and" };
                found.push(put(place.start..place.end + 1, and));
            }
            "F" | "G" | "eventually" | "always" => {
                let other = match &text[place.clone()] {
                    "F" => "G",
                    "G" => "F",
                    "eventually" => "always",
                    _ => "eventually",
                };
                found.push(put(place.clone(), other));
                // What is bounded may have been meant without a bound.
                found.extend(bound(text, place.end).map(|bound| put(bound, "")));
                if let Some(operand) = operand(text, place.end) {
                    let own = &text[operand.clone()];
                    let contrary = match own.strip_prefix(negation) {
                        Some(rest) => rest.to_owned(),
                        None => format!("{negation}{own}"),
                    };
                    let between = &text[place.end..operand.start];
                    let all = place.start..operand.end;
                    found.push(put(all, &format!("{other}{between}{contrary}")));
                }
            }
            "!" if !behind.starts_with('=') => found.push(put(place, "")),
            "not" => {
                let blank = behind.len() - behind.trim_start().len();
                found.push(put(place.start..place.end + blank, ""));
            }
            word if is_proposition(word) => {
                let start = place.start - quote.map_or(0, char::len_utf8);
                // A double negation is the negation left out.
                let before = text[..start].trim_end_matches([' ', '(']);
                let is_negated = before.ends_with('!') || before.ends_with("not");
                found.extend((!is_negated).then(|| put(start..start, negation)));
            }
            _ => {}
        }
    }
    found.extend(exchanged(text, is_proposition));
    found
}

/// Every text in which two propositions have each other's place, each text once.
fn exchanged(text: &str, is_proposition: &dyn Fn(&str) -> bool) -> Vec<String> {
    let places: Vec<Range<usize>> = tokens(text)
        .into_iter()
        .filter(|place| is_proposition(&text[place.clone()]))
        .collect();
    let mut found = Vec::new();
    for (number, one) in places.iter().enumerate() {
        for other in &places[number + 1..] {
            let [first, second] = [one, other].map(|it| &text[it.clone()]);
            let new = format!(
                "{}{second}{}{first}{}",
                &text[..one.start],
                &text[one.end..other.start],
                &text[other.end..]
            );
            if first != second && !found.contains(&new) {
                found.push(new);
            }
        }
    }
    found
}

/// The limit of a temporal operator that ends at a place: `[0, 3 s]` of a formula, `<=3` of a property.
fn bound(text: &str, end: usize) -> Option<Range<usize>> {
    let rest = &text[end..];
    let length = match rest.chars().next()? {
        '[' => rest.find(']')? + 1,
        '<' | '>' => rest.find(' ')?,
        _ => return None,
    };
    Some(end..end + length)
}

/// The operand of a temporal operator that ends at a place, with its limit left out: a word, a quoted one or what stands in
/// parentheses, negated or not.
fn operand(text: &str, end: usize) -> Option<Range<usize>> {
    let mut at = bound(text, end).map_or(end, |it| it.end);
    at = text.len() - text[at..].trim_start().len();
    let start = at;
    for negation in ["!", "not "] {
        if text[at..].starts_with(negation) {
            at += negation.len();
        }
    }
    let rest = &text[at..];
    let length = match rest.chars().next()? {
        '"' => rest[1..].find('"')? + 2,
        '(' => {
            let mut depth = 0_i32;
            let closing = rest.char_indices().find(|(_, c)| {
                depth += i32::from(*c == '(') - i32::from(*c == ')');
                depth == 0
            });
            closing?.0 + 1
        }
        c if c.is_ascii_alphabetic() || c == '_' => rest
            .find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))
            .unwrap_or(rest.len()),
        _ => return None,
    };
    Some(start..at + length)
}

/// Words, and signs one by one.
fn tokens(text: &str) -> Vec<Range<usize>> {
    let is_word = |c: char| c.is_ascii_alphanumeric() || "_/.".contains(c);
    let mut found: Vec<Range<usize>> = Vec::new();
    let mut in_word = false;
    for (at, c) in text.char_indices() {
        let end = at + c.len_utf8();
        match found.last_mut().filter(|_| in_word && is_word(c)) {
            Some(last) => last.end = end,
            None => found.push(at..end),
        }
        in_word = is_word(c);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_proposition(word: &str) -> bool {
        ["left", "shut", "lost"].contains(&word)
    }

    #[test]
    fn numbers_stand_beside_the_signals_that_are_compared_with_them() {
        let text = "always (/arm.gap < 2.5 mm and /arm.load>=0.3)";
        let found = compared_signals(text).into_iter();
        let found: Vec<(&str, &str)> = found.map(|(span, of)| (of, &text[span])).collect();
        assert_eq!(found, [("/arm.gap", "2.5 mm"), ("/arm.load", "0.3")]);
    }

    #[test]
    fn formulas_are_negated_and_joined_otherwise() {
        let found = rewritten(
            "always (left => (shut and not lost))",
            &is_proposition,
            "not ",
        );
        assert_eq!(
            found,
            [
                "eventually (left => (shut and not lost))",
                "eventually not (left => (shut and not lost))",
                "always (not left => (shut and not lost))",
                "always (left and (shut and not lost))",
                "always (left => (not shut and not lost))",
                "always (left => (shut or not lost))",
                "always (left => (shut => not lost))",
                "always (left => (shut and lost))",
                "always (shut => (left and not lost))",
                "always (lost => (shut and not left))",
                "always (left => (lost and not shut))",
            ]
        );
    }

    #[test]
    fn properties_are_negated_and_joined_otherwise() {
        let found = rewritten("P=? [ F<=30 \"left\" & !\"lost\" ]", &is_proposition, "!");
        assert_eq!(
            found,
            [
                "P=? [ G<=30 \"left\" & !\"lost\" ]",
                "P=? [ F \"left\" & !\"lost\" ]",
                "P=? [ G<=30 !\"left\" & !\"lost\" ]",
                "P=? [ F<=30 !\"left\" & !\"lost\" ]",
                "P=? [ F<=30 \"left\" | !\"lost\" ]",
                "P=? [ F<=30 \"left\" => !\"lost\" ]",
                "P=? [ F<=30 \"left\" & \"lost\" ]",
                "P=? [ F<=30 \"lost\" & !\"left\" ]",
            ]
        );
        let given = rewritten("P=? [ F \"lost\" || G !\"left\" ]", &is_proposition, "!");
        assert_eq!(
            given,
            [
                "P=? [ G \"lost\" || G !\"left\" ]",
                "P=? [ G !\"lost\" || G !\"left\" ]",
                "P=? [ F !\"lost\" || G !\"left\" ]",
                "P=? [ F \"lost\" || F !\"left\" ]",
                "P=? [ F \"lost\" || F \"left\" ]",
                "P=? [ F \"lost\" || G \"left\" ]",
                "P=? [ F \"left\" || G !\"lost\" ]",
            ]
        );
    }
}
