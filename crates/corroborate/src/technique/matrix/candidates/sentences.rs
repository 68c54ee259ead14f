//! Edits of the words that a requirement's sentence uses.
//!
//! # Definition
//! In the sentence of a requirement in disagreement each proposition in turn becomes another one that has what it is judged
//! and asked by (a `trace`, a `model`, if the first has it), where
//! * the text of the requirement has the other's name, and not this one's: then the text says it; or
//! * no other subject reads the other: then a place is free for it.
//!
//! Likewise each parameter in turn, of which the text of the requirement has neither name nor value, becomes another one of the same
//! dimension; where the text has the other's, the text says it.
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried.
//!
//! # Guarantee
//! That of [`super`]: none.

use super::clauses::of_property;
use super::quantities::add;
use super::{REQUIREMENTS, Reach, TextEdit, limits, of_monitor, part_of};
use evidence::{Subject, SuspectKind};
use std::ops::Range;
use study::{Study, SubjectForm};
use trace::units::QuantityValue;

/// Other propositions in sentences.
pub(super) fn of_requirements(
    study: &Study,
    disagrees: &dyn Fn(&Subject) -> bool,
) -> Vec<TextEdit> {
    let words = &study.vocabulary.propositions;
    let mut found = Vec::new();
    for requirement in &study.requirements {
        let subject = Subject::Requirement(requirement.id.clone());
        let form = study.forms.of(&subject).filter(|_| disagrees(&subject));
        let Some((form, written)) = form.and_then(|form| Some((form, form.sentence.as_ref()?)))
        else {
            continue;
        };
        let (span, sentence) = (&written.span, &written.text);
        for edit in other_parameters(study, (form, &requirement.text), (span, sentence)) {
            add(edit, &mut found);
        }
        for (place, word) in words_of(sentence) {
            let Some(old) = words.get(word) else { continue };
            let is_trigger = sentence.find(" shall ").is_some_and(|at| place.start < at);
            for (other, new) in words {
                let fits = (old.trace.is_none() || new.trace.is_some())
                    && (old.model.is_none() || new.model.is_some());
                let is_used = words_of(sentence).iter().any(|(_, it)| it == other);
                if !fits || is_used {
                    continue;
                }
                let is_said = names(&requirement.text, other) && !names(&requirement.text, word);
                // What triggers it is seen by how many runs a piece covers, which no rate is held against here.
                if is_trigger && !is_said {
                    continue;
                }
                let hint = match (is_said, is_read(study, other, form)) {
                    (true, _) => format!("the text of the requirement says `{other}`"),
                    (false, false) => format!("nothing else reads `{other}`"),
                    (false, true) => continue,
                };
                let edit = TextEdit {
                    file: REQUIREMENTS,
                    span: span.start + place.start..span.start + place.end,
                    old: word.to_owned(),
                    new: other.clone(),
                    kind: SuspectKind::Property,
                    part: part_of(form, "sentence"),
                    reach: Reach::All,
                    hint: Some(hint),
                    is_said,
                };
                add(edit, &mut found);
            }
        }
    }
    found
}

/// Other parameters of the same dimension in a sentence.
fn other_parameters(
    study: &Study,
    (form, text): (&SubjectForm, &str),
    (span, sentence): (&Range<usize>, &str),
) -> Vec<TextEdit> {
    let values = &study.parameters.values;
    let mut found = Vec::new();
    for (place, word) in words_of(sentence) {
        let says =
            |name: &str, value: &QuantityValue| names(text, name) || limits::says(text, value);
        // What the text says is not looked at.
        let Some(own) = values.get(word).filter(|own| !says(word, own)) else {
            continue;
        };
        for other in study.parameters.declared.keys() {
            let Some(new) = values.get(other) else {
                continue;
            };
            if new.dimension() != own.dimension() || new.si_value() == own.si_value() {
                continue;
            }
            let is_said = says(other, new);
            found.push(TextEdit {
                file: REQUIREMENTS,
                span: span.start + place.start..span.start + place.end,
                old: word.to_owned(),
                new: other.clone(),
                kind: SuspectKind::Property,
                part: part_of(form, "sentence"),
                reach: Reach::All,
                hint: is_said
                    .then(|| format!("the text of the requirement says `{other}` or its value")),
                is_said,
            });
        }
    }
    found
}

/// Whether another subject than this one reads a proposition.
fn is_read(study: &Study, proposition: &String, own: &SubjectForm) -> bool {
    let others = study.forms.subjects.iter();
    let mut others = others.filter(|form| form.subject != own.subject);
    others.any(|form| {
        of_monitor(form).contains(proposition) || of_property(form).contains(proposition)
    })
}

/// The words of a text, with their places.
pub(super) fn words_of(text: &str) -> Vec<(Range<usize>, &str)> {
    let is_end = |c: char| !(c.is_ascii_alphanumeric() || c == '_');
    let start = |word: &str| word.as_ptr() as usize - text.as_ptr() as usize;
    let words = text.split(is_end).filter(|word| !word.is_empty());
    words
        .map(|word| (start(word)..start(word) + word.len(), word))
        .collect()
}

/// Whether a text in words has a proposition's name, its parts as words; articles do not count.
pub(super) fn names(text: &str, proposition: &str) -> bool {
    let plain = |text: &str| {
        let words = words_of(text).into_iter();
        let words = words.map(|(_, word)| word.to_lowercase());
        let words: Vec<String> = words
            .filter(|word| !["a", "an", "the"].contains(&word.as_str()))
            .collect();
        format!(" {} ", words.join(" ").replace('_', " "))
    };
    plain(text).contains(&plain(proposition))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_names_a_proposition_by_its_words() {
        assert!(names("The lid is In range again.", "in_range"));
        assert!(names("On the road it is fully down.", "on_road"));
        assert!(!names("The lid is ranged in.", "in_range") && !names("unlocked", "locked"));
    }

    #[test]
    fn words_stand_where_they_are_found() {
        let text = "\"When lid_open, it\"";
        let found: Vec<&str> = words_of(text)
            .into_iter()
            .map(|(span, _)| &text[span])
            .collect();
        assert_eq!(found, ["When", "lid_open", "it"]);
    }
}
