//! Edits of the numbers that formulas of traces read: the parameters of `parameters.toml`, numbers and comparisons in `trace`
//! bindings.
//!
//! # Definition
//! A parameter is looked at if a requirement's or a failure mode's sentence, or a proposition that its monitor reads, names
//! it. It may be
//! * what the text of such a requirement says, in the parameter's dimension;
//! * the same number in another unit of its dimension;
//! * a slip by a factor.
//!
//! One whose value a text says already is not looked at. A number in a binding may be what the texts of those say that read
//! it, or a slip by a factor (its units are in [`super::topics`]); a comparison may be the other way round. A bare number
//! that is compared may be any number that these texts say, but shares and durations, or one that the `model` of the same
//! proposition compares with.
//!
//! # Assumes
//! Nothing of the data. What is suggested is tried.
//!
//! # Guarantee
//! That of [`super`]: none. What is named is what all evidence is explained by.

use super::limits::{in_words, said_texts};
use super::topics::{numbers_with_units, other_units};
use super::{PARAMETERS, Reach, TextEdit, binding, of_monitor};
use evidence::{Subject, SuspectKind};
use std::collections::BTreeSet;
use std::ops::Range;
use study::{Study, SubjectForm};
use trace::units::QuantityValue;

/// Slips of a number.
pub(super) const FACTORS: [f64; 4] = [10.0, 0.1, 2.0, 0.5];

/// Values that differ by less than this part are the same.
pub(super) const SAME_PART: f64 = 1e-9;

/// Other values of the parameters that are read.
pub(super) fn parameters(study: &Study, disagrees: &dyn Fn(&Subject) -> bool) -> Vec<TextEdit> {
    let mut found = Vec::new();
    for (name, declared) in &study.parameters.declared {
        let readers: Vec<&SubjectForm> = readers(study, name).collect();
        let Some(own) = Quantity::read(&declared.text) else {
            continue;
        };
        let said = said(study, &readers, &own);
        let is_said = said.iter().any(|(it, _)| it.is_same(&own));
        if is_said || !readers.iter().any(|form| disagrees(&form.subject)) {
            continue;
        }
        let told = said.into_iter();
        let told = told.map(|(it, by)| (it.text, Some(format!("the text of {by} says it"))));
        let others = own.in_other_units().into_iter().chain(own.slips());
        for (new, hint) in told.chain(others.map(|new| (new, None))) {
            let edit = TextEdit {
                file: PARAMETERS,
                span: declared.span.clone(),
                old: declared.text.clone(),
                new,
                kind: SuspectKind::Vocabulary,
                part: format!("{name}, value"),
                reach: Reach::All,
                is_said: hint.is_some(),
                hint,
            };
            add(edit, &mut found);
        }
    }
    found
}

/// Other numbers in the bindings of traces, and comparisons the other way round.
pub(super) fn in_bindings(study: &Study, disagrees: &dyn Fn(&Subject) -> bool) -> Vec<TextEdit> {
    let mut found = Vec::new();
    for (name, proposition) in &study.vocabulary.propositions {
        let Some(place) = &proposition.trace else {
            continue;
        };
        let forms = study.forms.subjects.iter();
        let readers: Vec<&SubjectForm> = forms
            .filter(|form| of_monitor(form).contains(name))
            .collect();
        if !readers.iter().any(|form| disagrees(&form.subject)) {
            continue;
        }
        let within = |span: &Range<usize>| {
            let start = place.span.start;
            start + span.start..start + span.end
        };
        let model = proposition.model.as_ref().map(|it| it.text.as_str());
        for (span, new, hint) in in_predicate(study, &place.text, model, &readers) {
            let edit = TextEdit {
                span: within(&span),
                old: place.text[span].to_owned(),
                is_said: hint.is_some(),
                ..binding((name, "trace"), place, new, Reach::Runs, hint)
            };
            add(edit, &mut found);
        }
    }
    found
}

/// What the numbers and the comparisons of a predicate may be instead, with their places and what says so: `model` is what the
/// same means to models, `readers` whose texts speak of it.
pub(super) fn in_predicate(
    study: &Study,
    text: &str,
    model: Option<&str>,
    readers: &[&SubjectForm],
) -> Vec<(Range<usize>, String, Option<String>)> {
    let mut found = Vec::new();
    for (span, ..) in numbers_with_units(text) {
        let Some(own) = Quantity::read(&text[span.clone()]) else {
            continue;
        };
        let said = said(study, readers, &own);
        if said.iter().any(|(it, _)| it.is_same(&own)) {
            continue;
        }
        let told = said.into_iter();
        let told = told.map(|(it, by)| (it.text, Some(format!("the text of {by} says it"))));
        let others = told.chain(own.slips().map(|new| (new, None)));
        found.extend(others.map(|(new, hint)| (span.clone(), new, hint)));
    }
    found.extend(bare(text, model, &told_bare(study, readers)));
    let turned = comparisons(text).into_iter().map(|(span, turned)| {
        let hint = compared_with(text, span.end).and_then(|number| {
            let mut all = readers.iter();
            let by = all.find(|form| {
                let texts = said_texts(study, &form.subject);
                texts
                    .iter()
                    .any(|text| is_said_of(text, number) == Some(turned.starts_with('<')))
            })?;
            let sign = if turned.starts_with('<') {
                "less"
            } else {
                "more"
            };
            Some(format!(
                "the text of {} says {sign} than {number}",
                by.subject.in_words()
            ))
        });
        (span, turned.to_owned(), hint)
    });
    found.extend(turned);
    found
}

/// The number that stands right behind a comparison.
fn compared_with(text: &str, end: usize) -> Option<f64> {
    let rest = text[end..].trim_start();
    let length = rest.find(|c: char| !(c.is_ascii_digit() || c == '.'));
    rest[..length.unwrap_or(rest.len())].parse().ok()
}

/// Words right before a number that say less than it, and more.
const LESS: [&str; 8] = [
    "less than",
    "below",
    "under",
    "at most",
    "up to",
    "no more than",
    "not more than",
    "not above",
];
const MORE: [&str; 8] = [
    "more than",
    "above",
    "over",
    "at least",
    "beyond",
    "no less than",
    "not less than",
    "not below",
];

/// Whether a text in words says less than a number, or more; nothing where it says neither right before the number, or both.
fn is_said_of(text: &str, number: f64) -> Option<bool> {
    let text = text.to_lowercase();
    let mut said = BTreeSet::new();
    for (at, word) in text.match_indices(|c: char| c.is_ascii_digit()) {
        let is_start = !text[..at].ends_with(|c: char| c.is_ascii_digit() || c == '.');
        let rest = &text[at..];
        let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.'));
        let written = rest[..end.unwrap_or(rest.len())].trim_end_matches('.');
        if word.is_empty() || !is_start || written.parse() != Ok(number) {
            continue;
        }
        let before = text[..at].trim_end();
        // The longer phrases contain the shorter ones: "not above" ends with "above".
        let longest = |phrases: &[&str]| {
            let all = phrases.iter().filter(|phrase| before.ends_with(*phrase));
            all.map(|phrase| phrase.len()).max().unwrap_or(0)
        };
        match longest(&LESS).cmp(&longest(&MORE)) {
            std::cmp::Ordering::Greater => said.insert(true),
            std::cmp::Ordering::Less => said.insert(false),
            std::cmp::Ordering::Equal => false,
        };
    }
    match said.len() {
        1 => said.first().copied(),
        _ => None,
    }
}

/// Adds an edit that changes something and is not there yet.
pub(super) fn add(edit: TextEdit, found: &mut Vec<TextEdit>) {
    let mut known = found.iter();
    let is_known = known.any(|it| it.is_of_place(&edit) && it.new == edit.new);
    if edit.new != edit.old && !is_known {
        found.push(edit);
    }
}

/// The requirements and failure modes that read a parameter.
fn readers<'s>(study: &'s Study, name: &'s str) -> impl Iterator<Item = &'s SubjectForm> {
    let forms = study.forms.subjects.iter();
    forms.filter(move |form| is_reader(study, form, name))
}

/// Whether a subject's text or sentence, or a predicate that its monitor reads, names a parameter.
pub(super) fn is_reader(study: &Study, form: &SubjectForm, name: &str) -> bool {
    let propositions = of_monitor(form).into_iter();
    let bindings = propositions.filter_map(|it| {
        let found = study.vocabulary.propositions.get(&it)?;
        Some(found.trace.as_ref()?.text.clone())
    });
    let mut texts = bindings.chain(said_texts(study, &form.subject));
    texts.any(|text| has_word(&text, name))
}

fn has_word(text: &str, name: &str) -> bool {
    let mut words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
    words.any(|word| word == name)
}

/// The quantities of the same dimension that the texts of these say, each with whose text it is.
fn said(study: &Study, readers: &[&SubjectForm], own: &Quantity) -> Vec<(Quantity, String)> {
    let mut found: Vec<(Quantity, String)> = Vec::new();
    for form in readers {
        for text in said_texts(study, &form.subject) {
            let all = in_text(&text).into_iter();
            for one in all.filter(|it| it.value.dimension() == own.value.dimension()) {
                if !found.iter().any(|(it, _)| it.is_same(&one)) {
                    found.push((one, form.subject.in_words()));
                }
            }
        }
    }
    found
}

/// A number with its unit.
struct Quantity {
    /// As it is written.
    text: String,
    number: f64,
    unit: String,
    value: QuantityValue,
}

impl Quantity {
    fn read(text: &str) -> Option<Self> {
        let text = text.trim();
        let digits = text.find(|c: char| !(c.is_ascii_digit() || ".eE+-_".contains(c)));
        let (number, unit) = text.split_at(digits.unwrap_or(text.len()));
        Some(Self {
            text: text.to_owned(),
            number: number.replace('_', "").parse().ok()?,
            unit: unit.trim().to_owned(),
            value: text.parse().ok()?,
        })
    }

    fn is_same(&self, other: &Self) -> bool {
        let (one, two) = (self.value.si_value(), other.value.si_value());
        (one - two).abs() <= SAME_PART * one.abs().max(two.abs())
    }

    fn in_other_units(&self) -> Vec<String> {
        let units = other_units(&self.unit).into_iter();
        units
            .map(|unit| format!("{} {unit}", plainly(self.number)))
            .collect()
    }

    fn slips(&self) -> impl Iterator<Item = String> {
        FACTORS.iter().map(|factor| {
            let number = plainly(self.number * factor);
            format!("{number} {}", self.unit).trim_end().to_owned()
        })
    }
}

/// The quantities that a text in words says.
fn in_text(text: &str) -> Vec<Quantity> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let plain = |word: &str| -> String {
        let ends = |c: char| !(c.is_ascii_alphanumeric() || c == '/' || c == '%');
        word.trim_matches(ends).to_owned()
    };
    let pairs = words.windows(2).filter_map(|pair| {
        let (written, unit) = (pair[0].trim_start_matches('('), plain(pair[1]));
        let number = match in_words(written) {
            Some(number) => number.to_string(),
            None => written.to_owned(),
        };
        number.parse::<f64>().ok()?;
        let is_unit = unit.starts_with(char::is_alphabetic) && unit != "percent";
        is_unit.then(|| Quantity::read(&format!("{number} {unit}")))?
    });
    pairs.collect()
}

/// The bare numbers that the texts of these say, but shares and durations, each with whose text it is.
fn told_bare(study: &Study, readers: &[&SubjectForm]) -> Vec<(f64, String)> {
    let mut found: Vec<(f64, String)> = Vec::new();
    for form in readers {
        for text in said_texts(study, &form.subject) {
            for number in bare_in_text(&text) {
                let is_known = found.iter().any(|(it, _)| *it == number);
                if !is_known {
                    found.push((number, format!("the text of {}", form.subject.in_words())));
                }
            }
        }
    }
    found
}

/// The numbers of a text in words that are no share and no duration, whatever their units.
pub(super) fn bare_in_text(text: &str) -> Vec<f64> {
    const OTHERS: [&str; 12] = [
        "%", "percent", "of", "ms", "s", "second", "seconds", "min", "minutes", "minute", "h",
        "hours",
    ];
    let words: Vec<&str> = text.split_whitespace().collect();
    let mut found = Vec::new();
    for (place, word) in words.iter().enumerate() {
        let number = word
            .trim_matches(['(', ')', ',', ';', ':'])
            .trim_end_matches('.');
        let next = words.get(place + 1).copied().unwrap_or_default();
        let next = next.trim_matches(|c: char| !(c.is_ascii_alphanumeric() || c == '%'));
        let is_share = place > 0 && words[place - 1] == "probability"
            || place > 1
                && words[place - 2..place] == ["at", "least"]
                && words[..place].contains(&"probability");
        if let (Ok(number), false, false) =
            (number.parse::<f64>(), OTHERS.contains(&next), is_share)
        {
            found.push(number);
        }
    }
    found
}

/// Other bare numbers in the comparisons of a predicate: what is told, what the proposition's `model` compares with, slips.
fn bare(
    text: &str,
    model: Option<&str>,
    told: &[(f64, String)],
) -> Vec<(Range<usize>, String, Option<String>)> {
    let of_model = model.map_or_else(Vec::new, compared_numbers).into_iter();
    let of_model = of_model.map(|(_, number)| (number, "its `model`".to_owned()));
    let told: Vec<(f64, String)> = told.iter().cloned().chain(of_model).collect();
    let mut found = Vec::new();
    for (span, own) in compared_numbers(text) {
        let is_same = |other: f64| (other - own).abs() <= SAME_PART * own.abs();
        // What a text says already is not looked at.
        if told.iter().any(|(it, _)| is_same(*it)) {
            continue;
        }
        let said = told
            .iter()
            .map(|(it, by)| (*it, Some(format!("{by} says it"))));
        let slips = FACTORS.iter().map(|factor| (own * factor, None));
        for (number, hint) in said.chain(slips.filter(|_| own != 0.0)) {
            found.push((span.clone(), plainly(number), hint));
        }
    }
    found
}

/// The numbers without a unit behind the comparisons of a predicate, with their places.
pub(super) fn compared_numbers(text: &str) -> Vec<(Range<usize>, f64)> {
    let numbers = comparisons(text).into_iter().filter_map(|(sign, _)| {
        let rest = text[sign.end..].trim_start();
        let start = text.len() - rest.len();
        let end = rest.find(|c: char| !(c.is_ascii_digit() || ".-".contains(c)));
        let (number, behind) = rest.split_at(end.unwrap_or(rest.len()));
        let is_bare = behind
            .trim_start()
            .chars()
            .next()
            .is_none_or(|c| ")&|=?".contains(c));
        let number: f64 = number.parse().ok()?;
        is_bare.then_some((start..start + end.unwrap_or(rest.len()), number))
    });
    numbers.collect()
}

/// The comparisons of a predicate, each with the one that is the other way round.
pub(super) fn comparisons(text: &str) -> Vec<(Range<usize>, &'static str)> {
    const TURNED: [(&str, &str); 4] = [("<=", ">="), (">=", "<="), ("<", ">"), (">", "<")];
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(rest) = text.get(at..).filter(|rest| !rest.is_empty()) {
        // An arrow is no comparison.
        let is_arrow = rest.starts_with("=>") || rest.starts_with("->");
        let known = TURNED.iter().find(|(sign, _)| rest.starts_with(sign));
        at += match (is_arrow, known) {
            (true, _) => 2,
            (false, Some((sign, turned))) => {
                found.push((at..at + sign.len(), *turned));
                sign.len()
            }
            (false, None) => rest.chars().next().map_or(1, char::len_utf8),
        };
    }
    found
}

/// A number as it would be written: at most nine digits that count.
pub(super) fn plainly(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 8 - value.abs().log10().floor().clamp(-12.0, 8.0) as i32;
    let scale = 10.0_f64.powi(digits);
    format!("{}", (value * scale).round() / scale)
}

/// The dimensions in which a parameter is a duration.
pub(super) fn is_duration(text: &str) -> bool {
    let of_time = BTreeSet::from(["ms", "s", "min", "h"]);
    Quantity::read(text).is_some_and(|it| of_time.contains(it.unit.as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_says_on_which_side_of_a_number() {
        let of = |text: &str| is_said_of(text, 15.0);
        assert_eq!(of("It is tilted by less than 15 degrees."), Some(true));
        assert_eq!(
            of("In at least 90 % it is not above 15 degrees, for 3 s."),
            Some(true)
        );
        assert_eq!(of("It is at least 15 mm high."), Some(false));
        assert_eq!(of("Above 15, and below 15.0 too."), None);
        assert_eq!(of("Less than 115, or 15.5, at 15 s."), None);
        assert_eq!(compared_with("/a.b > 15 deg", 6), Some(15.0));
    }

    #[test]
    fn quantities_of_a_text_are_read_with_their_units() {
        let text = "Within 3.5 s, nearer than 10 cm (0.25 m/s at most), in 95 % of 12 runs.";
        let found: Vec<String> = in_text(text).into_iter().map(|it| it.text).collect();
        assert_eq!(found, ["3.5 s", "10 cm", "0.25 m/s"]);
        let found = in_text("It is held within 10 h, in 2 hours mostly, after 90 seconds.");
        let seconds: Vec<f64> = found.iter().map(|it| it.value.si_value()).collect();
        assert_eq!(seconds, [36000.0, 7200.0, 90.0]);
        assert!(is_duration("3.5 s") && !is_duration("10 cm"));
        let found = in_text("No vehicle passes at less than two metres.");
        assert!(found.iter().all(|it| it.value.si_value() == 2.0) && found.len() == 1);
    }

    #[test]
    fn a_quantity_slips_by_its_unit_and_by_factors() {
        let own = Quantity::read("1.5 cm").expect("a quantity");
        assert_eq!(own.in_other_units(), ["1.5 mm", "1.5 m", "1.5 km"]);
        let slips: Vec<String> = own.slips().collect();
        assert_eq!(slips, ["15 cm", "0.15 cm", "3 cm", "0.75 cm"]);
        assert!(own.is_same(&Quantity::read("15 mm").expect("a quantity")));
    }

    #[test]
    fn bare_numbers_are_those_that_texts_and_models_say() {
        let text = "In at least 75 % of 12 meals, with probability at least 0.7, nobody eats above 70 mg/dl in 4 h (or 60 degrees).";
        assert_eq!(bare_in_text(text), [12.0, 70.0, 60.0]);
        let found = compared_numbers("/a.x < 52 & (/a.y >= -0.5) & /a.v > 3 m/s");
        let numbers: Vec<f64> = found.iter().map(|(_, number)| *number).collect();
        assert_eq!(numbers, [52.0, -0.5]);
        let told = [(70.0, "the text".to_owned())];
        let found = bare("/a.x < 52", Some("charge<30"), &told);
        let said: Vec<&str> = found
            .iter()
            .filter(|it| it.2.is_some())
            .map(|it| it.1.as_str())
            .collect();
        assert_eq!(said, ["70", "30"]);
        assert!(
            bare("/a.x < 70", None, &told).is_empty(),
            "the text says it"
        );
    }

    #[test]
    fn comparisons_are_turned_round_and_arrows_left() {
        let text = "/a.x <= 3 & (/a.y > 2 => /a.z < 1)";
        let found: Vec<(&str, &str)> = comparisons(text)
            .into_iter()
            .map(|(span, turned)| (&text[span], turned))
            .collect();
        assert_eq!(found, [("<=", ">="), (">", "<"), ("<", ">")]);
    }
}
