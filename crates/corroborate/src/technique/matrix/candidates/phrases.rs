//! Edits of what a requirement's sentence says of when: its scope, its condition, its timing, and what joins its propositions.
//!
//! # Definition
//! In the sentence of a requirement in disagreement, one at a time:
//!
//! * a word of timing (`immediately`, `eventually`, `always`, `never`) becomes another one; `never` is said by a text that has "no",
//!   "not", "never" or "without" where the sentence has none of these;
//! * a duration becomes one that the requirement's own text says, in the same unit, where the text does not say the first;
//! * the scope is left out, or has another word (`before`, `after`, `while`);
//! * `when` becomes `whenever` or the other way round, and `unless` becomes `when`;
//! * `and` becomes `or` or the other way round, and `not` is left out.
//!
//! Other propositions and parameters in sentences are in [`super::sentences`].
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried; what is no sentence then is not.
//!
//! # Guarantee
//! That of [`super`]: none.

use super::limits::{durations, says_secs};
use super::quantities::add;
use super::sentences::words_of;
use super::{REQUIREMENTS, Reach, TextEdit, part_of};
use evidence::{Subject, SuspectKind};
use std::ops::Range;
use study::Study;
use trace::duration::unit_secs;

/// Words of timing that stand for each other.
const TIMINGS: [&str; 4] = ["immediately", "eventually", "always", "never"];

/// Words that begin a scope, and stand for each other.
const SCOPES: [&str; 3] = ["before", "after", "while"];

/// A part of a sentence, what may stand in its place, and what says so.
type Phrase = (Range<usize>, String, Option<String>);

/// Other phrases in sentences.
pub(super) fn of_requirements(
    study: &Study,
    disagrees: &dyn Fn(&Subject) -> bool,
) -> Vec<TextEdit> {
    let mut found = Vec::new();
    for requirement in &study.requirements {
        let subject = Subject::Requirement(requirement.id.clone());
        let form = study.forms.of(&subject).filter(|_| disagrees(&subject));
        let Some((form, written)) = form.and_then(|form| Some((form, form.sentence.as_ref()?)))
        else {
            continue;
        };
        let scope = written.tree.scope.span;
        for (place, new, hint) in phrases(&written.text, scope.start..scope.end, &requirement.text)
        {
            let start = written.span.start;
            let edit = TextEdit {
                file: REQUIREMENTS,
                old: written.text[place.clone()].to_owned(),
                span: start + place.start..start + place.end,
                new,
                kind: SuspectKind::Property,
                part: part_of(form, "sentence"),
                reach: Reach::All,
                is_said: hint.is_some(),
                hint,
            };
            add(edit, &mut found);
        }
    }
    found
}

/// Every phrase of a sentence that may be another, with the place of its scope, and the text that it stands for.
fn phrases(sentence: &str, scope: Range<usize>, text: &str) -> Vec<Phrase> {
    let mut found = of_scope(sentence, scope);
    let shall = sentence.find("shall").unwrap_or_default();
    for (place, word) in words_of(sentence) {
        let lower = word.to_lowercase();
        let like = |new: &str| match word.starts_with(char::is_uppercase) {
            true => capital(new),
            false => new.to_owned(),
        };
        let others: &[&str] = match lower.as_str() {
            "when" => &["whenever"],
            "whenever" | "unless" => &["when"],
            "and" => &["or"],
            "or" => &["and"],
            _ => &[],
        };
        found.extend(others.iter().map(|new| (place.clone(), like(new), None)));
        if place.start > shall && TIMINGS.contains(&lower.as_str()) {
            let others = TIMINGS.iter().filter(|it| **it != lower);
            let is_denied = denies(text) && !denies(sentence);
            found.extend(others.map(|new| {
                let hint = (is_denied && *new == "never")
                    .then(|| "the text of the requirement says that it does not happen".to_owned());
                (place.clone(), (*new).to_owned(), hint)
            }));
        }
        if lower == "not" {
            let rest = &sentence[place.end..];
            let blank = rest.len() - rest.trim_start().len();
            found.push((place.start..place.end + blank, String::new(), None));
        }
    }
    found.extend(of_durations(sentence, text));
    found
}

/// Whether a text says that something does not happen; "no more than" does not.
fn denies(text: &str) -> bool {
    const DENIALS: [&str; 4] = ["no", "not", "never", "without"];
    const COMPARED: [&str; 9] = [
        "more", "less", "later", "earlier", "longer", "above", "below", "over", "under",
    ];
    let words: Vec<String> = words_of(text)
        .into_iter()
        .map(|(_, word)| word.to_lowercase())
        .collect();
    let is = |list: &[&str], at: usize| words.get(at).is_some_and(|it| list.contains(&it.as_str()));
    (0..words.len()).any(|at| is(&DENIALS, at) && !is(&COMPARED, at + 1))
}

/// The scope left out, or begun with another word.
fn of_scope(sentence: &str, scope: Range<usize>) -> Vec<Phrase> {
    let Some((place, word)) = words_of(&sentence[scope.clone()]).into_iter().next() else {
        return Vec::new();
    };
    let mut found = Vec::new();
    // With what follows it, whose first letter may become a capital one.
    if let Some((next, first)) = words_of(&sentence[scope.end..]).into_iter().next() {
        let new = match word.starts_with(char::is_uppercase) {
            true => capital(first),
            false => first.to_owned(),
        };
        found.push((scope.start..scope.end + next.end, new, None));
    }
    let own = word.to_lowercase();
    if SCOPES.contains(&own.as_str()) {
        let at = scope.start + place.start..scope.start + place.end;
        let others = SCOPES.iter().filter(|it| **it != own);
        found.extend(others.map(|new| (at.clone(), capital(new), None)));
    }
    found
}

/// Durations in a sentence that its text says otherwise.
fn of_durations(sentence: &str, text: &str) -> Vec<Phrase> {
    let said = durations(text);
    let mut found = Vec::new();
    let words = words_of(sentence);
    for pair in words.windows(2) {
        let [(number, digits), (unit, name)] = pair else {
            continue;
        };
        let (Ok(value), Some(scale)) = (digits.parse::<f64>(), unit_secs(name)) else {
            continue;
        };
        // Numbers with a point are two words here.
        let is_whole = !sentence[..number.start].ends_with('.');
        let is_joined = sentence[number.end..unit.start]
            .chars()
            .all(char::is_whitespace);
        if !is_whole || !is_joined || says_secs(&said, value * scale) {
            continue;
        }
        found.extend(said.iter().map(|secs| {
            let other = (secs / scale * 1e9).round() / 1e9;
            let hint = format!("the text of the requirement says {other} {name}");
            (number.clone(), other.to_string(), Some(hint))
        }));
    }
    found
}

/// A word with a capital letter.
fn capital(word: &str) -> String {
    let mut letters = word.chars();
    let first = letters.next().map(char::to_uppercase);
    first.into_iter().flatten().chain(letters).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(sentence: &str, scope: Range<usize>, text: &str) -> Vec<String> {
        let all = phrases(sentence, scope, text).into_iter();
        all.map(|(place, new, _)| {
            format!(
                "{}{new}{}",
                &sentence[..place.start],
                &sentence[place.end..]
            )
        })
        .collect()
    }

    #[test]
    fn scopes_are_left_out_or_begun_otherwise_and_timings_are_others() {
        let sentence = "Before docked, the tug shall never satisfy stuck or lost.";
        assert_eq!(
            written(sentence, 0..13, ""),
            [
                "The tug shall never satisfy stuck or lost.",
                "After docked, the tug shall never satisfy stuck or lost.",
                "While docked, the tug shall never satisfy stuck or lost.",
                "Before docked, the tug shall immediately satisfy stuck or lost.",
                "Before docked, the tug shall eventually satisfy stuck or lost.",
                "Before docked, the tug shall always satisfy stuck or lost.",
                "Before docked, the tug shall never satisfy stuck and lost.",
            ]
        );
    }

    #[test]
    fn a_text_says_that_something_does_not_happen() {
        assert!(denies("The errands shall not need the operator."));
        assert!(denies("Without a stop at a charger."));
        assert!(!denies("It takes no more than 3 s, and not longer."));
        let hinted = |text: &str| {
            let all = phrases("The tug shall eventually satisfy stuck.", 0..0, text);
            let mut said = all.into_iter().filter(|(.., hint)| hint.is_some());
            said.next().map(|(_, new, _)| new)
        };
        assert_eq!(hinted("It shall not be stuck.").as_deref(), Some("never"));
        assert_eq!(hinted("It shall be stuck."), None);
    }

    #[test]
    fn a_duration_becomes_the_one_that_the_text_says() {
        let sentence = "When called, the lift shall within 15 min satisfy not away.";
        assert_eq!(
            written(sentence, 0..0, "It comes in 25 minutes."),
            [
                "Whenever called, the lift shall within 15 min satisfy not away.",
                "When called, the lift shall within 15 min satisfy away.",
                "When called, the lift shall within 25 min satisfy not away.",
            ]
        );
        let said = written(
            sentence,
            0..0,
            "It comes in a quarter of an hour, 15 minutes.",
        );
        assert!(said.iter().all(|it| it.contains("15 min")), "{said:?}");
    }
}
