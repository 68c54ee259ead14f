//! A rate that a requirement's text states in words, held against the threshold that is declared.
//!
//! # Definition
//! A text states a rate where it has one percentage alone, with a comparison right before it ("at least", "no more than",
//! ">=", ...) or right after it ("or more"), and "of" with what is counted behind that ("of attempts", "of all journeys"). "100 %
//! of" and "0 % of" need no comparison. Any other number may be something else: a
//! charge, a speed, a share of a time; nothing is said of it. A rate and its complement ask for the same: "at most 5 % of runs
//! fail" and a threshold of at least 0.95; and so do "at least 100 %" and no threshold, which asks it of every run.

use diagnostic::{Problem, Source};
use evidence::{Direction, Threshold};
use std::ops::Range;
use toml::Spanned;

/// Two shares that are the same number, written otherwise.
const SAME: f64 = 1e-9;

/// Words before a percentage, and what they ask for. Longer ones before those that end alike.
const COMPARISONS: [(&str, Direction); 18] = [
    ("no more than", Direction::AtMost),
    ("not more than", Direction::AtMost),
    ("no less than", Direction::AtLeast),
    ("not less than", Direction::AtLeast),
    ("no fewer than", Direction::AtLeast),
    ("at least", Direction::AtLeast),
    ("at most", Direction::AtMost),
    ("more than", Direction::AtLeast),
    ("less than", Direction::AtMost),
    ("fewer than", Direction::AtMost),
    ("a minimum of", Direction::AtLeast),
    ("a maximum of", Direction::AtMost),
    ("up to", Direction::AtMost),
    (">=", Direction::AtLeast),
    ("<=", Direction::AtMost),
    ("≥", Direction::AtLeast),
    ("≤", Direction::AtMost),
    ("minimum of", Direction::AtLeast),
];

/// Words right behind a percentage, and what they ask for.
const AFTER: [(&str, Direction); 5] = [
    ("or more", Direction::AtLeast),
    ("or higher", Direction::AtLeast),
    ("or less", Direction::AtMost),
    ("or fewer", Direction::AtMost),
    ("or lower", Direction::AtMost),
];

/// What a requirement without a threshold asks for.
const CERTAINTY: Threshold = Threshold {
    direction: Direction::AtLeast,
    value: 1.0,
};

/// Words between "of" and what is counted.
const ARTICLES: [&str; 4] = ["the", "all", "its", "their"];

/// What a text states, and where in it.
#[derive(Clone, Debug, PartialEq)]
struct Stated {
    threshold: Threshold,
    place: Range<usize>,
}

/// That a text states another rate than the requirement asks for, by its key `threshold` or in its sentence.
pub(super) fn other_rate(
    source: &Source,
    text: &Spanned<String>,
    threshold: Option<Threshold>,
    is_of_sentence: bool,
) -> Option<Problem> {
    let stated = stated(text.get_ref())?;
    if is_same(stated.threshold, threshold.unwrap_or(CERTAINTY)) {
        return None;
    }
    let asked = match threshold {
        Some(asked) => format!("the threshold is {}", in_words(asked)),
        None => "no threshold is declared, so that it is asked of every run".to_owned(),
    };
    let problem = Problem::new(
        "text-threshold",
        format!(
            "the text states {}, and {asked}",
            in_words(stated.threshold)
        ),
    );
    // Where the text has escapes its parts stand elsewhere than in the source.
    let phrase = &text.get_ref()[stated.place.clone()];
    let within = source.text.get(text.span()).and_then(|it| it.find(phrase));
    let place = match within {
        Some(at) => text.span().start + at..text.span().start + at + phrase.len(),
        None => text.span(),
    };
    let words = format!("{} {}", direction(stated.threshold), stated.threshold.value);
    let remedy = match is_of_sentence {
        true => format!("write `with probability {words}` in the sentence"),
        false => format!("write `threshold = \"{words}\"`"),
    };
    Some(problem.at(source, place).remedy(format!(
        "{remedy}, or correct the text: results are judged by the threshold alone"
    )))
}

fn is_same(stated: Threshold, asked: Threshold) -> bool {
    let value = match stated.direction == asked.direction {
        true => stated.value,
        false => 1.0 - stated.value,
    };
    (value - asked.value).abs() <= SAME
}

fn direction(threshold: Threshold) -> &'static str {
    match threshold.direction {
        Direction::AtLeast => "at least",
        Direction::AtMost => "at most",
    }
}

/// `at least 95 %`.
fn in_words(threshold: Threshold) -> String {
    // Without the digits that the factor leaves behind.
    let percent = (threshold.value * 1e8).round() / 1e6;
    format!("{} {percent} %", direction(threshold))
}

/// Words with which a comparison may say the contrary.
const NEGATIONS: [&str; 9] = [
    "not", "no", "never", "cannot", "can't", "mustn't", "without", "nor", "too",
];

/// The one rate that a text states without doubt.
fn stated(text: &str) -> Option<Stated> {
    let mut signs = text
        .match_indices('%')
        .map(|(at, sign)| at..at + sign.len());
    let words = ["percent", "per cent"].into_iter();
    let mut in_letters =
        words.flat_map(|word| text.match_indices(word).map(|(at, it)| at..at + it.len()));
    let sign = match (signs.next(), in_letters.next()) {
        (Some(sign), None) | (None, Some(sign)) => sign,
        _ => return None,
    };
    let after = text[sign.end..].trim_start();
    let behind = AFTER
        .iter()
        .find_map(|(words, direction)| Some((after.strip_prefix(words)?, *direction)));
    let counted = behind.map_or(after, |(rest, _)| rest);
    if signs.next().is_some() || in_letters.next().is_some() || !counts_something(counted) {
        return None;
    }
    let before = text[..sign.start].trim_end();
    // A comma may stand for the point.
    let digits = |it: char| it.is_ascii_digit() || it == '.' || it == ',';
    let start = before.len() - before.chars().rev().take_while(|it| digits(*it)).count();
    let percent: f64 = before[start..].replace(',', ".").parse().ok()?;
    let compared = before[..start].trim_end().to_lowercase();
    let in_front = COMPARISONS
        .iter()
        .find(|(words, _)| compared.ends_with(words));
    let (words, direction) = match (in_front, behind) {
        (Some((words, direction)), None) => (*words, *direction),
        (None, Some((_, direction))) => ("", direction),
        (None, None) if compared.ends_with("than") => return None,
        // All of them, or none.
        (None, None) if percent >= 100.0 => ("", Direction::AtLeast),
        (None, None) if percent <= 0.0 => ("", Direction::AtMost),
        (Some(_), Some(_)) | (None, None) => return None,
    };
    let begin = match words {
        "" => start,
        words => before[..start].trim_end().len().checked_sub(words.len())?,
    };
    // "Must not fail in more than 5 % of attempts" bounds the rate from the other side.
    let is_negated = |part: &str| {
        let mut words = part.split(|it: char| !it.is_alphabetic() && it != '\'');
        words.any(|word| NEGATIONS.contains(&word.to_lowercase().as_str()))
    };
    // Behind the rate it says of what it is one, which its complement allows for ("at most 5 % of runs never end"), unless what is
    // told is too much.
    let mut behind = text[sign.end..].split(|it: char| !it.is_alphabetic());
    if is_negated(&text[..begin]) || behind.any(|word| word == "too") {
        return None;
    }
    let value = percent / 100.0;
    (0.0..=1.0).contains(&value).then_some(Stated {
        threshold: Threshold { direction, value },
        place: begin..sign.end,
    })
}

/// Whether "of" and a plural follow: what is counted.
fn counts_something(after: &str) -> bool {
    let mut words = after.split_whitespace();
    if words.next() != Some("of") {
        return false;
    }
    let end = |word: &str| word.ends_with([',', '.', ';', ':']);
    let mut noun = words.skip_while(|word| ARTICLES.contains(word));
    // An adjective may stand between: `of handover attempts`.
    let mut phrase = Vec::new();
    for word in noun.by_ref().take(3) {
        phrase.push(word.trim_end_matches([',', '.', ';', ':']));
        if end(word) {
            break;
        }
    }
    phrase.iter().any(|word| {
        word.len() > 3 && word.ends_with('s') && !word.ends_with("ss") && !word.ends_with("'s")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn threshold(direction: Direction, value: f64) -> Threshold {
        Threshold { direction, value }
    }

    fn warned(text: &str, asked: Option<Threshold>) -> Option<String> {
        let source = Source::new("requirements.toml", format!("text = \"{text}\""));
        let spanned = Spanned::new(7..9 + text.len(), text.to_owned());
        other_rate(&source, &spanned, asked, false).map(|it| it.warning_line())
    }

    #[test]
    fn a_text_that_states_another_rate_is_placed_with_both_values() {
        let asked = Some(threshold(Direction::AtLeast, 0.9));
        let text = "The arm shall dock in at least 95 % of attempts.";
        let line = warned(text, asked).expect("a warning");
        assert!(
            line.contains("states at least 95 %") && line.contains("is at least 90 %"),
            "{line}"
        );
        assert!(line.contains("requirements.toml:1:31"), "{line}");
        let source = Source::new("requirements.toml", format!("text = \"{text}\""));
        let spanned = Spanned::new(7..9 + text.len(), text.to_owned());
        for (is_of_sentence, remedy) in [(false, "write `threshold ="), (true, "in the sentence")] {
            let problem = other_rate(&source, &spanned, asked, is_of_sentence).expect("a warning");
            assert!(format!("{problem:?}").contains(remedy), "{problem:?}");
        }
        let line = warned("At least 60% of handover attempts succeed.", None).expect("a warning");
        assert!(line.contains("no threshold is declared"), "{line}");
        for text in [
            "It docks in 80 % or more of attempts.",
            "It docks in >= 80 % of attempts.",
            "It docks in a minimum of 80 percent of all attempts.",
            "It docks in 100 % of attempts.",
            "It fails in 0 % of attempts.",
            "It docks in at least 100 % of attempts.",
        ] {
            assert!(warned(text, asked).is_some(), "{text}");
        }
        // A decimal comma.
        let comma = warned("It docks in at least 85,5 % of attempts.", asked);
        assert!(comma.is_some_and(|it| it.contains("at least 85.5 %")));
        assert_eq!(
            warned("It docks in at least 90,0 % of attempts.", asked),
            None
        );
        let opposite = warned("No more than 2.5 percent of the journeys fail.", asked);
        assert!(opposite.is_some_and(|it| it.contains("at most 2.5 %")));
    }

    #[test]
    fn the_same_rate_and_its_complement_are_no_contradiction() {
        let asked = Some(threshold(Direction::AtLeast, 0.95));
        for text in [
            "At least 95 % of attempts succeed.",
            "At least 95% of all attempts succeed.",
            "Attempts fail in at most 5 % of cases.",
            "Attempts succeed in 95 % or more of cases.",
        ] {
            assert_eq!(warned(text, asked), None, "{text}");
        }
        // No threshold asks it of every run.
        for text in [
            "At least 100 % of attempts succeed.",
            "It docks in 100 % of attempts.",
            "At most 0 % of attempts fail.",
            "It fails in 0 % of attempts.",
        ] {
            assert_eq!(warned(text, None), None, "{text}");
        }
    }

    #[test]
    fn a_negation_behind_the_rate_is_of_what_is_counted() {
        let text = "At least 60 % of visits are finished without being given up.";
        let of = |direction, value| Some(Threshold { direction, value });
        // Whether the requirement is about those that are or those that are not.
        assert_eq!(warned(text, of(Direction::AtLeast, 0.6)), None);
        assert_eq!(warned(text, of(Direction::AtMost, 0.4)), None);
        assert!(warned(text, of(Direction::AtMost, 0.6)).is_some());
    }

    #[test]
    fn a_number_that_may_be_something_else_is_left_alone() {
        let asked = Some(threshold(Direction::AtLeast, 0.9));
        for text in [
            "The battery keeps at least 20 % of its charge.",
            "The battery keeps at least 20 %.",
            "It is slower than 80 % of full speed.",
            "It is slower than 100 % of its limits.",
            "95 % of attempts succeed.",
            "At least 95 % of attempts succeed, at least 99 % of them in time.",
            "It docks within at least 3 s of arrivals.",
            "At least 995 % of attempts succeed.",
            "At least 95 percent of attempts succeed, 3 % late.",
            "Nine of ten attempts succeed.",
            "It must not fail in more than 5 % of attempts.",
            "It never fails in more than 5 % of attempts.",
            "More than 5 % of runs need help; that is too many.",
            "It keeps at least 20 % of the battery's capacity.",
        ] {
            assert_eq!(warned(text, asked), None, "{text}");
        }
    }
}
