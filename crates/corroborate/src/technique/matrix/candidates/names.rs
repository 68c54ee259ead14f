//! Other propositions in hand-written properties, triggers, opportunities and `experiment` entries of requirements.toml.
//!
//! # Definition
//! In a property, a `trigger` or an `opportunity` of a subject in disagreement each proposition in turn becomes another one that models
//! are asked by and the text does not name. The words of the subject (a requirement's text, a failure mode's name and meaning) say the
//! other one if they have its name and not this one's; otherwise nothing suggests it but that it can be. A trigger also says which
//! rows of tables and which runs count, so that these are produced again with it. What the other forms of a subject name is in [`super`].
//!
//! The proposition whose column counts a subject becomes in turn each other one that has a column; the property says those that it names.
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried.
//!
//! # Guarantee
//! That of [`super`]: none.

use super::quantities::add;
use super::sentences::names;
use super::{REQUIREMENTS, Reach, TextEdit, block, part_of, values};
use evidence::{Subject, SuspectKind};
use study::{FormText, Study, SubjectForm, TriggerForm, quoted_names};

/// Other words of properties, triggers and opportunities.
pub(super) fn of_forms(study: &Study, disagrees: &dyn Fn(&Subject) -> bool) -> Vec<TextEdit> {
    let mut found = Vec::new();
    let forms = study.forms.subjects.iter();
    for form in forms.filter(|form| disagrees(&form.subject)) {
        for edit in of_experiment(study, form) {
            add(edit, &mut found);
        }
        for (which, text, reach) in written(form) {
            for edit in in_text(study, form, (which, text), &reach) {
                add(edit, &mut found);
            }
        }
    }
    found
}

/// What was written by hand of the texts that models are asked by.
fn written(form: &SubjectForm) -> Vec<(&'static str, &FormText, Reach)> {
    let trigger = match &form.trigger {
        TriggerForm::Runs(text) => Some(text),
        TriggerForm::Always | TriggerForm::Unknown(_) => None,
    };
    let all = [
        ("property", form.property.as_ref(), Reach::Models),
        ("trigger", trigger, Reach::All),
        ("opportunity", form.opportunity.as_ref(), Reach::All),
    ];
    let by_hand = all.into_iter().filter_map(|(which, text, reach)| {
        let text = text.filter(|it| !it.from_sentence)?;
        Some((which, text, reach))
    });
    by_hand.collect()
}

fn in_text(
    study: &Study,
    form: &SubjectForm,
    (which, text): (&str, &FormText),
    reach: &Reach,
) -> Vec<TextEdit> {
    let words = &study.vocabulary.propositions;
    let said = words_of_subject(study, &form.subject);
    let named = quoted_names(&text.text);
    let mut found = Vec::new();
    for (old, place) in &named {
        for (new, word) in words {
            if word.model.is_none() || named.iter().any(|(name, _)| name == new) {
                continue;
            }
            let is_said = names(&said, new) && !names(&said, old);
            found.push(TextEdit {
                file: REQUIREMENTS,
                span: text.span.start + place.start..text.span.start + place.end,
                old: old.clone(),
                new: new.clone(),
                kind: SuspectKind::Property,
                part: part_of(form, which),
                reach: reach.clone(),
                hint: is_said
                    .then(|| format!("the text of {} says `{new}`", form.subject.in_words())),
                is_said,
            });
        }
    }
    found
}

/// Other propositions whose columns count a subject.
fn of_experiment(study: &Study, form: &SubjectForm) -> Vec<TextEdit> {
    let Some(own) = &form.experiment else {
        return Vec::new();
    };
    let text = &study.forms.source.text;
    let asked = form.property.as_ref().map(|it| quoted_names(&it.text));
    let asked = asked.unwrap_or_default();
    let words = &study.vocabulary.propositions;
    let others = words
        .iter()
        .filter(|(name, word)| word.column.is_some() && *name != own);
    let places = values(text, block(text, form), "experiment");
    let mut found = Vec::new();
    for (new, _) in others {
        for (span, quoted) in &places {
            let is_said = asked.iter().any(|(name, _)| name == new)
                && asked.iter().all(|(name, _)| name != own);
            if quoted.trim_matches(['"', '\'']) != own {
                continue;
            }
            found.push(TextEdit {
                file: REQUIREMENTS,
                span: span.start + 1..span.end - 1,
                old: own.clone(),
                new: new.clone(),
                kind: SuspectKind::Property,
                part: part_of(form, "experiment"),
                reach: Reach::Tables,
                hint: is_said.then(|| format!("its property names `{new}`")),
                is_said,
            });
        }
    }
    found
}

/// What people wrote of a subject.
fn words_of_subject(study: &Study, subject: &Subject) -> String {
    let requirements = study.requirements.iter();
    let modes = study.failure_modes.iter();
    match subject {
        Subject::Requirement(id) => requirements
            .filter(|it| &it.id == id)
            .map(|it| it.text.clone())
            .collect(),
        Subject::FailureMode(id) => modes
            .filter(|it| &it.id == id)
            .map(|it| format!("{} {}", it.name, it.meaning))
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn places_are_those_of_the_name_without_its_quotes() {
        let text = "P=? [ F<=4 \"sorted\" ]";
        let found = study::quoted_names(text);
        let (name, place) = &found[0];
        assert_eq!((name.as_str(), &text[place.clone()]), ("sorted", "sorted"));
    }
}
