//! Edits of the negations and operators in hand-written properties and formulas of requirements.toml.
//!
//! # Definition
//! Of a property or a formula of a subject in disagreement, one at a time: a negation left out, or put before a proposition;
//! `|` for `&`, `or` for `and`, and back. Limits of time are in [`super::limits`], other propositions in [`super`].
//!
//! # Guarantee
//! That of [`super`]: none.

use super::quantities::add;
use super::{REQUIREMENTS, Reach, TextEdit, block, part_of, values};
use evidence::{Subject, SuspectKind};
use std::ops::Range;
use study::{Rule, Study, SubjectForm};

/// Other clauses of properties and formulas.
pub(super) fn of_forms(study: &Study, disagrees: &dyn Fn(&Subject) -> bool) -> Vec<TextEdit> {
    let forms = study.forms.subjects.iter();
    let mut found = Vec::new();
    for form in forms.filter(|form| disagrees(&form.subject)) {
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
        }
    }
    found
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
        match &text[place.clone()] {
            "&" => found.push(put(place, "|")),
            "|" => found.push(put(place, "&")),
            "and" => found.push(put(place, "or")),
            "or" => found.push(put(place, "and")),
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
    found
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
    fn formulas_are_negated_and_joined_otherwise() {
        let found = rewritten(
            "always (left => (shut and not lost))",
            &is_proposition,
            "not ",
        );
        assert_eq!(
            found,
            [
                "always (not left => (shut and not lost))",
                "always (left => (not shut and not lost))",
                "always (left => (shut or not lost))",
                "always (left => (shut and lost))",
            ]
        );
    }

    #[test]
    fn properties_are_negated_and_joined_otherwise() {
        let found = rewritten("P=? [ F<=30 \"left\" & !\"lost\" ]", &is_proposition, "!");
        assert_eq!(
            found,
            [
                "P=? [ F<=30 !\"left\" & !\"lost\" ]",
                "P=? [ F<=30 \"left\" | !\"lost\" ]",
                "P=? [ F<=30 \"left\" & \"lost\" ]",
            ]
        );
    }
}
