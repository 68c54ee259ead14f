//! A duration that a requirement's text states in words, held against those of its sentence.
//!
//! # Definition
//! A text and a sentence speak of different times where each has a duration that the other has not: "within 40 s" beside
//! `within attach_time`, which is 60 s. A text may say other times, too (how long a pause is before it), and a sentence may
//! have some that the text leaves out: where one has all that the other has, nothing is said. Durations are numbers with a
//! unit of time right behind them; steps of a model count by their declared duration.

use diagnostic::{Problem, Source};
use requirement_lang::sentence::Amount;
use std::ops::Range;
use toml::Spanned;

use crate::sentence_form::SentenceForm;

/// Two times that are the same, written in other units.
const SAME: f64 = 1e-9;

/// A duration in a text: its seconds, and its place.
type Said = (f64, Range<usize>);

/// That a text states another duration than the requirement's sentence.
pub(super) fn other_duration(
    source: &Source,
    text: &Spanned<String>,
    sentence: &SentenceForm,
    step_secs: Option<f64>,
) -> Option<Problem> {
    let stages = sentence.tree.stages.iter();
    let durations = stages.filter_map(|stage| stage.timing.duration());
    let asked = durations.map(|duration| {
        let secs = match duration.amount {
            Amount::Secs(secs) => Some(secs),
            Amount::Steps(count) => step_secs.map(|step| f64::from(count) * step),
            Amount::Missing => None,
        };
        Some((secs?, duration.text.clone()))
    });
    // A duration that is not known may be any of those that the text says.
    let asked: Vec<(f64, String)> = asked.collect::<Option<_>>()?;
    let said = said(text.get_ref());
    let is_asked = |secs: f64| asked.iter().any(|(other, _)| is_same(secs, *other));
    let is_said = |secs: f64| said.iter().any(|(other, _)| is_same(secs, *other));
    let (_, place) = said.iter().find(|(secs, _)| !is_asked(*secs))?;
    let (secs, written) = asked.iter().find(|(secs, _)| !is_said(*secs))?;
    let phrase = &text.get_ref()[place.clone()];
    let value = format!("{secs} s");
    let asked = match *written == value {
        true => value,
        false => format!("`{written}` ({value})"),
    };
    let problem = Problem::new(
        "text-duration",
        format!("the text states {phrase}, and the sentence asks for {asked}"),
    );
    // Where the text has escapes its parts stand elsewhere than in the source.
    let within = source.text.get(text.span()).and_then(|it| it.find(phrase));
    let place = match within {
        Some(at) => text.span().start + at..text.span().start + at + phrase.len(),
        None => text.span(),
    };
    Some(problem.at(source, place).remedy(
        "write the same time in both, or correct the parameter: results are judged by the sentence alone",
    ))
}

fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= SAME * one.abs().max(other.abs())
}

/// The durations of a text in words.
fn said(text: &str) -> Vec<Said> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(offset) = text[at..].find(|c: char| c.is_ascii_digit()) {
        let start = at + offset;
        let rest = &text[start..];
        let length = rest
            .find(|c: char| !(c.is_ascii_digit() || c == '.'))
            .unwrap_or(rest.len());
        at = start + length;
        // Part of a name (`E1`), of a number with commas or of a decimal that began before.
        let before = text[..start].chars().next_back();
        let is_own = before.is_none_or(|c| !(c.is_alphanumeric() || ".,_-".contains(c)));
        let behind = &text[at..];
        let gap = behind.len()
            - behind
                .trim_start_matches([' ', '-', '\u{a0}', '\u{202f}'])
                .len();
        let word = &behind[gap..];
        let end = word
            .find(|c: char| !c.is_alphanumeric() && c != '/' && c != '^')
            .unwrap_or(word.len());
        let unit = trace::duration::unit_secs(&word[..end]);
        if let (true, Ok(number), Some(scale)) = (is_own, rest[..length].parse::<f64>(), unit) {
            found.push((number * scale, start..at + gap + end));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::said;

    fn secs(text: &str) -> Vec<f64> {
        said(text).into_iter().map(|(secs, _)| secs).collect()
    }

    #[test]
    fn durations_are_numbers_with_a_unit_of_time_behind_them() {
        let text = "within 60 s, or after 1.5 minutes (500ms), a 5-minute pause.";
        assert_eq!(secs(text), [60.0, 90.0, 0.5, 300.0]);
        assert_eq!(&text[said(text)[0].1.clone()], "60 s");
        for other in [
            "at least 70 % of 12 attempts",
            "at 5 m/s and 3 s^2, with E1 s",
            "1,500 s are written with a comma",
            "a limit of 3 sensors",
        ] {
            assert_eq!(secs(other), Vec::<f64>::new(), "{other}");
        }
    }
}
